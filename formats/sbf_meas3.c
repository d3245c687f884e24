/* The layout, little-endian; bits are counted from the lowest, a sub-block's kind is given by its low bits in binary.
 *
 * Meas3Ranges: header 14 bytes, then
 *   u1 CommonFlags as in MeasEpoch, u1 CumClkJumps, u2 constellations (bit s: system s follows),
 *   u1 bits 0-2 antenna, bit 3 masters carry a rate, bits 4-7 interval of the reference epochs (a table),
 *   u1 version, below 32; for each system:
 *     u1 0: layout as at the reference epoch; else
 *     u1 bits 0-2 length of the mask (7 means 8), bits 3-6 signal index of short masters, bit 7 exclusions follow
 *     mask, a bit per satellite; GLONASS: four bits per satellite in the mask, frequency number + 8;
 *     BeiDou: u2 far; if bit 7 says so: u1 excluded signals, those that remain move down in the table
 *     per satellite a master, then a slave per further signal, by rising index
 *
 *   MasterShort  ...1: 1-18 carrier, 19 range msb, 20-22 lock, 23-27 C/N0, 28-31 the four slaves behind it;
 *                u4 range; (i2 rate)
 *   MasterLong   ..00: 2-5 range msb, 6-27 carrier, 28-31 lock; u4 range;
 *                u2: 0-5 C/N0, 6-14 signals, 15 more; (u1 seven more signals); (i2 rate)
 *   DeltaLong    1110: 4-7 range msb; u4: 0-12 range, 13-15 C/N0, 16-31 carrier
 *   DeltaShort   ..10: 2-3 C/N0 (never 3), 4-17 range, 18-31 carrier
 *   SlaveShort   ...1: 1-16 carrier, 17-31 range; u1: 0-2 lock, 3-7 C/N0
 *   SlaveLong    ..00: 2-23 carrier, 24-27 lock, 28-30 range msb; u2 range; u1: 0-5 C/N0
 *   SlaveDelta   ..10: 2-13 range, 14-15 C/N0; u1 carrier
 *
 * The extensions: header 14 bytes, u2 Flags (bits 0-2 antenna), then in the order of the signals
 *   Meas3CN0HiRes  4 bits each, 1/16 dB-Hz, less half a dB-Hz
 *   Meas3Doppler   range rate [mm/s] in 1 to 4 bytes: bit 0 sign; from bit 1 on a one for each byte that follows,
 *                  then a zero unless it was three; the rest magnitude
 *   Meas3PP        5 bits each: multipath mitigation is settling, loss count. Flags >> 8: where a second part begins
 *                  [4 bytes], for which furrow has no column
 *   Meas3MP        2 bits each, then: 0 nothing, no correction; 1 and 2, plus and minus 7 bits of 1 cm, 5 bits of
 *                  1/512 cycle; 3: 11 and 8 bits of these
 *
 * Where the sources differ: 7 as the length of a mask is just that in the Septentrio decoder of 2019, which knew 56
 * satellites of a system, and 8 in RTKLIB, which knows 64; only BeiDou from C49 on needs it, and C49 to C56 are not
 * in use. The rate of a MasterLong with more signals is behind these (sbfdef.h); both decoders read it one byte
 * early, but no signal has an index that high. Both also go by references that are not there; here that is a loss. */
#include "formats/sbf_meas3.h"

#include <stddef.h>
#include <string.h>

#include "formats/bytes.h"
#include "formats/sbf_signal.h"
#include "furrow_epoch.h"
#include "furrow_epoch_columns.h"
#include "furrow_obs.h"
#include "furrow_obs_columns.h"
#include "furrow_obs_extra.h"
#include "furrow_obs_extra_columns.h"

/** SI and all GNSS interface documents: speed of light [m/s] */
#define SPEED_OF_LIGHT_MPS 299792458.0

enum { RANGES = 4109, END_OF_MEAS = 5922, RANGES_HEADER = 20, EXTENSION_HEADER = 16, MAX_VERSION = 31 };

enum { CN0HIRES = 1, DOPPLER, PP, MP }; /* kinds of blocks, counted from Meas3Ranges */

enum { GLONASS = 1, BEIDOU = 3 };

enum {
	COMMON_SMOOTHED = 2,
	COMMON_STEERING = 8,
	COMMON_DYNAMICS = 32,
	COMMON_E6B = 64,
	COMMON_SCRAMBLED = 128
};

enum { SIGNAL_INDICES = 16, NO_SIGNAL = 255, SIGNAL_GPS_L1P = 1, SIGNAL_GPS_L2P = 2, SIGNAL_E6 = 19 };

/* fw_sbf_meas3_signal.known; a range comes with its C/N0. */
enum { KNOWN_RANGE = 1, KNOWN_CARRIER = 2, HALF_CYCLE = 4 };

/* Rates that stand for none [mm/s]. */
enum { NO_MASTER_RATE = -0xfffffff, NO_SLAVE_RATE = -0xfffff };

#define BIT(column) (INT64_C(1) << (column))

/* Signal numbers by system and index. */
static const uint8_t signal_table[FW_MEAS3_SYSTEMS][FW_MEAS3_SIGNALS] = {
    {0, 3, 4, 1, 2, 5, NO_SIGNAL, NO_SIGNAL},
    {8, 11, 9, 10, 12, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL},
    {17, 20, 21, 19, 22, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL},
    {28, 29, 30, 13, 14, 34, NO_SIGNAL, NO_SIGNAL},
    {24, 25, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL},
    {6, 7, 26, 27, 32, 33, 39, 38},
    {15, 37, 36, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL, NO_SIGNAL},
};

/* What a short master adds its range to [mm]. */
static const int64_t range_base_mm[FW_MEAS3_SYSTEMS] = {19000000000, 19000000000, 22000000000, 20000000000,
                                                        34000000000, 34000000000, 34000000000};
static const int64_t far_base_mm = 34000000000;

/* The SVIDs of a system's satellites: two runs at most. */
static const struct {
	uint8_t n1, first1, n2, first2;
} svids[FW_MEAS3_SYSTEMS] = {
    {37, 1, 0, 0},      {24, 38, 6, 63}, {36, 71, 0, 0},   {40, 141, 23, 223},
    {21, 120, 18, 198}, {10, 181, 0, 0}, {7, 191, 7, 216},
};

static const uint32_t interval_ms[16] = {1,     500,    1000, 2000, 5000, 10000, 15000, 30000,
                                         60000, 120000, 1,    1,    1,    1,     1,     1};

static const int32_t lock_table_ms[16] = {0,   60000, 30000, 15000, 10000, 5000, 2000, 1000,
                                          500, 200,   100,   50,    40,    20,   10,   0};

/* Bytes still to be read. */
typedef struct {
	const uint8_t *p, *end;
} bytes;

/* Bits still to be read. */
typedef struct {
	const uint8_t *p;
	size_t next, end;
} bits;

/* A Meas3Ranges on its way to records, and how far each extension has been read. */
typedef struct {
	fw_sbf_meas3 *m;
	fw_sbf_meas3_reference *ref;
	int is_reference, emit;
	uint32_t elapsed_ms; /* since the reference epoch */
	uint8_t common, has_rate, antenna;
	int64_t time; /* which of these two are known */
	int32_t gps_week;
	double tow_s;
	bytes ranges, doppler;
	bits cn0, pp, mp;
	unsigned n_signals;

	/* the system */
	unsigned system;
	uint8_t numbers[SIGNAL_INDICES];

	/* the satellite */
	fw_sbf_meas3_satellite *old; /* at the reference epoch, if its stamp says so */
	const char *name;
	int channel; /* GLONASS frequency number */
	int channel_known;
	int64_t base_mm;
	fw_sbf_meas3_signal master;
	unsigned master_index, slaves;
	int16_t rate;
	int64_t master_rate_mmps;
	int master_rate_known;
} walk;

/* What the extensions say of one signal; a bit in known for each. */
typedef struct {
	unsigned known;
	double range_rate_mps;
	double cn0_db;
	unsigned settling, loss_count;
	double range_m, carrier_cyc;
} extension;

/* Whether the reference epoch knows the satellite at hand. */
static int is_referred(const walk *w)
{
	return w->old->stamp == w->ref->stamp;
}

static int has_reference(const walk *w)
{
	return !w->is_reference && is_referred(w);
}

static const char *satellite_name(unsigned system, unsigned index)
{
	if (index < svids[system].n1)
		return fw_sbf_satellite((uint8_t)(svids[system].first1 + index));
	index -= svids[system].n1;
	return index < svids[system].n2 ? fw_sbf_satellite((uint8_t)(svids[system].first2 + index)) : NULL;
}

/* Cycles per metre, or 0 when the signal is not known, or the frequency of its GLONASS satellite. */
static double wave_number(const walk *w, unsigned number)
{
	const fw_sbf_signal *signal = fw_sbf_signal_of(number);
	if (signal == NULL || (signal->channel_spacing_hz > 0 && !w->channel_known))
		return 0;
	return (signal->frequency_hz + w->channel * signal->channel_spacing_hz) / SPEED_OF_LIGHT_MPS;
}

static int is_gps_p_code(unsigned number)
{
	return number == SIGNAL_GPS_L1P || number == SIGNAL_GPS_L2P;
}

static unsigned field(uint32_t word, unsigned first, unsigned n)
{
	return word >> first & ((1u << n) - 1);
}

static int sign_extend(unsigned value, unsigned n)
{
	return (int)value - (int)(value >> (n - 1) << n);
}

/* ---- the extensions ---- */

/* Takes n bits; 0 when there are not so many, and then there are none left. */
static int take_bits(bits *b, unsigned n, uint32_t *value)
{
	if (b->end - b->next < n) {
		b->next = b->end;
		return 0;
	}
	*value = 0;
	for (unsigned i = 0; i < n; i++, b->next++)
		*value |= (uint32_t)(b->p[b->next / 8] >> b->next % 8 & 1) << i;
	return 1;
}

static int take_rate(bytes *b, int32_t *rate_mmps)
{
	if (b->p == b->end)
		return 0;
	unsigned ones = 0; /* bits 1 to 3, up to the first 0 */
	while (ones < 3 && b->p[0] >> (1 + ones) & 1)
		ones++;
	unsigned prefix = ones < 3 ? 2 + ones : 4;
	if ((unsigned)(b->end - b->p) < 1 + ones) {
		b->p = b->end;
		return 0;
	}
	uint32_t value = 0;
	for (unsigned i = 0; i <= ones; i++)
		value |= (uint32_t)b->p[i] << 8 * i;
	b->p += 1 + ones;
	int32_t size = (int32_t)(value >> prefix);
	*rate_mmps = value & 1 ? -size : size;
	return 1;
}

/* A master's rate comes on top of that of the reference epoch, a slave's on top of its master's. */
static void take_doppler(walk *w, int is_master, extension *x)
{
	int32_t rate;
	int known =
	    take_rate(&w->doppler, &rate) && rate != NO_MASTER_RATE && (is_master || rate != NO_SLAVE_RATE);
	int64_t base_mmps = w->master_rate_mmps;
	if (is_master) {
		base_mmps = is_referred(w) ? w->old->rate * 64 : 0;
		w->master_rate_known = known;
		w->master_rate_mmps = known ? base_mmps + rate : 0;
	}
	if (known && w->master_rate_known) {
		x->range_rate_mps = (double)(base_mmps + rate) / 1000.0;
		x->known |= 1 << DOPPLER;
	}
}

static void take_multipath(bits *b, extension *x)
{
	uint32_t type, value = 0;
	if (!take_bits(b, 2, &type))
		return;
	if (type != 0 && !take_bits(b, type == 3 ? 19 : 12, &value))
		return;
	x->known |= 1 << MP;
	if (type == 3) {
		x->range_m = sign_extend(field(value, 0, 11), 11) / 100.0;
		x->carrier_cyc = sign_extend(field(value, 11, 8), 8) / 512.0;
	} else {
		x->range_m = (type == 2 ? -(int)field(value, 0, 7) : (int)field(value, 0, 7)) / 100.0;
		x->carrier_cyc = sign_extend(field(value, 7, 5), 5) / 512.0;
	}
}

static extension take_extension(walk *w, int is_master)
{
	extension x = {0};
	uint32_t value;
	take_doppler(w, is_master, &x);
	if (take_bits(&w->cn0, 4, &value)) {
		x.cn0_db = value / 16.0 - 0.5;
		x.known |= 1 << CN0HIRES;
	}
	if (take_bits(&w->pp, 5, &value)) {
		x.settling = value & 1;
		x.loss_count = value >> 1;
		x.known |= 1 << PP;
	}
	take_multipath(&w->mp, &x);
	return x;
}

/* ---- records ---- */

static char *signal_name(const walk *w, unsigned number)
{
	const char *name =
	    number == SIGNAL_E6 && w->common & COMMON_E6B ? "6B" : fw_sbf_signal_of(number)->rinex;
	return (char *)(uintptr_t)name;
}

static void emit_obs(const walk *w, const fw_sbf_meas3_signal *s, const extension *x)
{
	furrow_obs o = {
	    .present = w->time | BIT(FW_COL_obs_sat) | BIT(FW_COL_obs_signal) | BIT(FW_COL_obs_antenna) |
	               BIT(FW_COL_obs_pseudorange_m) | BIT(FW_COL_obs_cn0_dbhz) | BIT(FW_COL_obs_half_cycle),
	    .gps_week = w->gps_week,
	    .tow_s = w->tow_s,
	    .sat = (char *)(uintptr_t)w->name,
	    .signal = signal_name(w, s->number),
	    .antenna = (int8_t)w->antenna,
	    .pseudorange_m = s->range_m,
	    .cn0_dbhz = s->cn0_dbhz,
	    .half_cycle = (s->known & HALF_CYCLE) != 0,
	};
	if (w->system == GLONASS && w->channel_known) {
		o.glonass_channel = (int8_t)w->channel;
		o.present |= BIT(FW_COL_obs_glonass_channel);
	}
	if (s->known & KNOWN_CARRIER) {
		o.carrier_cyc = s->carrier_cyc;
		o.present |= BIT(FW_COL_obs_carrier_cyc);
	}
	double cycles_per_m = wave_number(w, s->number);
	if (x->known & 1 << DOPPLER && cycles_per_m > 0) {
		o.doppler_hz = -x->range_rate_mps * cycles_per_m;
		o.present |= BIT(FW_COL_obs_doppler_hz);
	}
	if (!(s->known & HALF_CYCLE)) {
		o.lock_s = s->lock_ms / 1000;
		o.present |= BIT(FW_COL_obs_lock_s);
	}
	if (!(w->common & COMMON_SMOOTHED))
		o.present |= BIT(FW_COL_obs_smoothed);
	w->m->sink.put(w->m->sink.context, FW_obs, &o);
}

static void emit_extra(const walk *w, const fw_sbf_meas3_signal *s, const extension *x)
{
	furrow_obs_extra e = {
	    .present = w->time | BIT(FW_COL_obs_extra_sat) | BIT(FW_COL_obs_extra_signal) |
	               BIT(FW_COL_obs_extra_antenna),
	    .gps_week = w->gps_week,
	    .tow_s = w->tow_s,
	    .sat = (char *)(uintptr_t)w->name,
	    .signal = signal_name(w, s->number),
	    .antenna = (int8_t)w->antenna,
	};
	if (x->known & 1 << CN0HIRES) {
		e.cn0_highres_dbhz = x->cn0_db;
		e.present |= BIT(FW_COL_obs_extra_cn0_highres_dbhz);
	}
	if (x->known & 1 << PP) {
		e.loss_count = (int16_t)x->loss_count;
		e.info = (int16_t)x->settling;
		e.present |= BIT(FW_COL_obs_extra_loss_count) | BIT(FW_COL_obs_extra_info);
	}
	if (x->known & 1 << MP) {
		e.multipath_corr_m = x->range_m;
		e.carrier_multipath_corr_cyc = x->carrier_cyc;
		e.present |=
		    BIT(FW_COL_obs_extra_multipath_corr_m) | BIT(FW_COL_obs_extra_carrier_multipath_corr_cyc);
	}
	w->m->sink.put(w->m->sink.context, FW_obs_extra, &e);
}

/* Every signal comes by here, known or not, for the extensions count them all. */
static void show(walk *w, const fw_sbf_meas3_signal *s, int is_master)
{
	extension x = take_extension(w, is_master);
	fw_sbf_meas3 *m = w->m;
	if (!w->emit || w->name == NULL || fw_sbf_signal_of(s->number) == NULL)
		return;
	if (!(s->known & KNOWN_RANGE)) {
		m->stats.lost_signals++;
		return;
	}
	w->n_signals++;
	if (!(m->antennas >> w->antenna & 1)) {
		m->stats.other_antenna++;
		return;
	}
	if (fw_kind_in(&m->wanted, FW_obs))
		emit_obs(w, s, &x);
	if (x.known & ~(1u << DOPPLER) && fw_kind_in(&m->wanted, FW_obs_extra))
		emit_extra(w, s, &x);
}

/* ---- masters ---- */

static void set_lock(fw_sbf_meas3_signal *s, unsigned indicator)
{
	s->lock_ms = lock_table_ms[indicator];
	if (indicator == 0)
		s->known |= HALF_CYCLE;
}

/* The carrier [cycles] is `start` plus the coded thousandths. 0 stands for none; so does an unknown wavelength. */
static void set_carrier(const walk *w, fw_sbf_meas3_signal *s, unsigned coded, double start)
{
	if (coded == 0 || !(s->known & KNOWN_RANGE) || !(wave_number(w, s->number) > 0))
		return;
	s->carrier_cyc = start + coded * 0.001;
	s->known |= KNOWN_CARRIER;
}

static void begin_master(walk *w, unsigned index)
{
	w->master_index = index;
	w->master = (fw_sbf_meas3_signal){.number = w->numbers[index]};
}

static void set_master_range(fw_sbf_meas3_signal *s, int64_t range_mm)
{
	s->range_m = (double)range_mm / 1000.0;
	if (range_mm != 0)
		s->known |= KNOWN_RANGE;
}

static void master_short(walk *w, const uint8_t *p, unsigned short_index)
{
	uint32_t word = fw_load_u32(p);
	fw_sbf_meas3_signal *s = &w->master;
	begin_master(w, short_index);
	w->slaves = (word >> 28) << (short_index + 1);
	w->rate = w->has_rate ? (int16_t)fw_load_u16(p + 8) : 0;
	set_master_range(s, w->base_mm + ((int64_t)field(word, 19, 1) << 32 | fw_load_u32(p + 4)));
	set_carrier(w, s, field(word, 1, 18), s->range_m * wave_number(w, s->number) - 131.072);
	s->cn0_dbhz = (int16_t)(field(word, 23, 5) + 24);
	set_lock(s, field(word, 20, 3));
}

static int master_long(walk *w, const uint8_t *p)
{
	uint32_t word = fw_load_u32(p), word2 = fw_load_u16(p + 8);
	unsigned more = word2 >> 15, signals = field(word2, 6, 9) | (more ? (p[10] & 127u) << 9 : 0);
	if (signals == 0)
		return 0;
	fw_sbf_meas3_signal *s = &w->master;
	begin_master(w, (unsigned)__builtin_ctz(signals));
	w->slaves = signals & (signals - 1);
	w->rate = w->has_rate ? (int16_t)fw_load_u16(p + 10 + more) : 0;
	set_master_range(s, (int64_t)field(word, 2, 4) << 32 | fw_load_u32(p + 4));
	set_carrier(w, s, field(word, 6, 22), s->range_m * wave_number(w, s->number) - 2097.152);
	s->cn0_dbhz = (int16_t)(field(word2, 0, 6) + (is_gps_p_code(s->number) ? 0 : 10));
	set_lock(s, word >> 28);
	return 1;
}

/* The master at the reference epoch, or NULL when there is none of the same signal. */
static const fw_sbf_meas3_signal *old_master(const walk *w)
{
	if (!has_reference(w) || w->old->master >= FW_MEAS3_SIGNALS)
		return NULL;
	const fw_sbf_meas3_signal *s = &w->old->signals[w->old->master];
	return s->known & KNOWN_RANGE && s->number == w->numbers[w->old->master] ? s : NULL;
}

/* Coded against the old range moved on by its rate, and against the old carrier moved by the range. */
static void master_delta(walk *w, int64_t range_mm, unsigned carrier, double carrier_zero, int cn0_db)
{
	const fw_sbf_meas3_signal *old = old_master(w);
	fw_sbf_meas3_signal *s = &w->master;
	begin_master(w, has_reference(w) ? w->old->master : SIGNAL_INDICES - 1);
	w->slaves = has_reference(w) ? w->old->slaves : 0;
	w->rate = 0;
	if (!has_reference(w) && w->emit)
		w->m->stats.lost_signals++; /* of a name that only the reference knew */
	if (old == NULL)
		return;
	int64_t moved_mm = (int64_t)w->old->rate * 64 * w->elapsed_ms / 1000 + range_mm;
	s->range_m = old->range_m + (double)moved_mm / 1000.0;
	s->cn0_dbhz = (int16_t)(old->cn0_dbhz + cn0_db);
	s->lock_ms = old->lock_ms;
	s->known = KNOWN_RANGE | (old->known & HALF_CYCLE);
	if (old->known & KNOWN_CARRIER)
		set_carrier(w, s, carrier,
		            (double)moved_mm / 1000.0 * wave_number(w, s->number) + old->carrier_cyc -
		                carrier_zero);
}

/* Decodes the master that follows; 0 when it does not fit or says nothing. */
static int take_master(walk *w, unsigned short_index)
{
	const uint8_t *p = w->ranges.p;
	ptrdiff_t left = w->ranges.end - p, size;
	if (left < 4)
		return 0;
	if (p[0] & 1)
		size = 8 + 2 * w->has_rate;
	else if ((p[0] & 3) == 0)
		size = left < 10 ? 10 : 10 + 2 * w->has_rate + (p[9] >> 7);
	else
		size = (p[0] & 12) == 12 ? 5 : 4;
	if (left < size)
		return 0;
	w->ranges.p += size;
	if (p[0] & 1) {
		master_short(w, p, short_index);
	} else if ((p[0] & 3) == 0) {
		return master_long(w, p);
	} else if (size == 5) {
		uint32_t word = fw_load_u32(p + 1);
		int64_t range_mm = (uint32_t)(p[0] >> 4) << 13 | field(word, 0, 13);
		master_delta(w, range_mm - 65536, word >> 16, 32.768, (int)field(word, 13, 3) - 4);
	} else {
		uint32_t word = fw_load_u32(p);
		int64_t range_mm = field(word, 4, 14);
		master_delta(w, range_mm - 8192, word >> 18, 8.192, (int)field(word, 2, 2) - 1);
	}
	return 1;
}

/* ---- slaves ---- */

static void slave_short(walk *w, const uint8_t *p, fw_sbf_meas3_signal *s)
{
	uint32_t word = fw_load_u32(p);
	double wave = wave_number(w, s->number), master_wave = wave_number(w, w->master.number);
	if (!(wave > 0 && master_wave > 0)) /* the ionosphere's sign is not known */
		return;
	double later_m = (word >> 17) * 0.001 - 10;
	double master_offset = w->master.carrier_cyc - w->master.range_m * master_wave;
	s->range_m = w->master.range_m + (master_wave > wave ? later_m : -later_m);
	s->known = KNOWN_RANGE;
	if (w->master.known & KNOWN_CARRIER)
		set_carrier(w, s, field(word, 1, 16),
		            s->range_m * wave + master_offset * (master_wave / wave) - 32.768);
	int cn0 = p[4] >> 3;
	s->cn0_dbhz = (int16_t)(is_gps_p_code(s->number) ? w->master.cn0_dbhz - 3 - cn0 : cn0 + 24);
	set_lock(s, p[4] & 7);
}

static void slave_long(walk *w, const uint8_t *p, fw_sbf_meas3_signal *s)
{
	uint32_t word = fw_load_u32(p);
	int32_t later_mm = (int32_t)(field(word, 28, 3) << 16 | fw_load_u16(p + 4)) - 262144;
	s->range_m = w->master.range_m + later_mm / 1000.0;
	s->known = KNOWN_RANGE;
	set_carrier(w, s, field(word, 2, 22), s->range_m * wave_number(w, s->number) - 2097.152);
	s->cn0_dbhz = (int16_t)((p[6] & 63) + (is_gps_p_code(s->number) ? 0 : 10));
	set_lock(s, field(word, 24, 4));
}

/* The same signal at the reference epoch, or NULL. There it must have been the same slave of the same master,
 * for deltas find their reference by counting. */
static const fw_sbf_meas3_signal *old_slave(const walk *w, unsigned index, unsigned count)
{
	const fw_sbf_meas3_satellite *old = w->old;
	if (!has_reference(w) || index >= FW_MEAS3_SIGNALS || !(old->slaves >> index & 1) ||
	    old->master != w->master_index)
		return NULL;
	unsigned before = old->slaves & ((1u << index) - 1);
	const fw_sbf_meas3_signal *s = &old->signals[index];
	int same = (unsigned)__builtin_popcount(before) == count && s->number == w->numbers[index];
	return same && s->known & KNOWN_CARRIER ? s : NULL;
}

/* Coded against the old carrier moved by the master's, and the old range moved by that. */
static void slave_delta(walk *w, const uint8_t *p, unsigned index, unsigned count, fw_sbf_meas3_signal *s)
{
	const fw_sbf_meas3_signal *old = old_slave(w, index, count), *master = old_master(w);
	double wave = wave_number(w, s->number), master_wave = wave_number(w, w->master.number);
	if (old == NULL || master == NULL || !(master->known & w->master.known & KNOWN_CARRIER) ||
	    !(wave > 0 && master_wave > 0))
		return;
	uint32_t word = fw_load_u16(p);
	double moved_cyc =
	    (w->master.carrier_cyc - master->carrier_cyc) * (wave / master_wave) - 0.128 + p[2] * 0.001;
	s->carrier_cyc = old->carrier_cyc + moved_cyc;
	s->range_m = old->range_m + moved_cyc / wave - 2.048 + field(word, 2, 12) * 0.001;
	s->cn0_dbhz = (int16_t)(old->cn0_dbhz - 2 + (int)(word >> 14));
	s->lock_ms = old->lock_ms;
	s->known = KNOWN_RANGE | KNOWN_CARRIER | (old->known & HALF_CYCLE);
}

/* Decodes the slave that follows, `count` slaves behind the first; 0 when it does not fit. */
static int take_slave(walk *w, unsigned index, unsigned count, fw_sbf_meas3_signal *s)
{
	const uint8_t *p = w->ranges.p;
	ptrdiff_t left = w->ranges.end - p;
	if (left < 3)
		return 0;
	ptrdiff_t size = p[0] & 1 ? 5 : (p[0] & 3) == 0 ? 7 : 3;
	if (left < size)
		return 0;
	w->ranges.p += size;
	*s = (fw_sbf_meas3_signal){.number = w->numbers[index]};
	if (size == 3)
		slave_delta(w, p, index, count, s);
	else if (!(w->master.known & KNOWN_RANGE))
		return 1;
	else if (size == 5)
		slave_short(w, p, s);
	else
		slave_long(w, p, s);
	return 1;
}

/* ---- the walk ---- */

/* Keeps a signal for the deltas to come. In between only its lock time can grow. */
static void remember(walk *w, unsigned index, const fw_sbf_meas3_signal *s)
{
	if (index >= FW_MEAS3_SIGNALS)
		return;
	fw_sbf_meas3_signal *old = &w->old->signals[index];
	if (w->is_reference)
		*old = *s;
	else if (is_referred(w) && old->known & KNOWN_RANGE && old->number == s->number &&
	         s->lock_ms > old->lock_ms)
		old->lock_ms = s->lock_ms;
}

static int take_satellite(walk *w, unsigned short_index)
{
	if (w->is_reference && !is_referred(w))
		*w->old = (fw_sbf_meas3_satellite){.stamp = w->ref->stamp};
	if (!take_master(w, short_index))
		return 0;
	if (w->is_reference) {
		w->old->master = (uint8_t)w->master_index;
		w->old->slaves = (uint16_t)w->slaves;
		w->old->rate = w->rate;
	}
	remember(w, w->master_index, &w->master);
	show(w, &w->master, 1);

	unsigned count = 0;
	for (unsigned index = 1; index < SIGNAL_INDICES; index++) {
		fw_sbf_meas3_signal s;
		if (!(w->slaves >> index & 1))
			continue;
		if (!take_slave(w, index, count++, &s))
			return 0;
		remember(w, index, &s);
		show(w, &s, 0);
	}
	return 1;
}

static int take_layout(bytes *b, unsigned system, fw_sbf_meas3_layout *layout)
{
	ptrdiff_t left = b->end - b->p;
	if (left < 1)
		return 0;
	unsigned head = *b->p++;
	if (head == 0)
		return 1; /* as at the reference epoch, which the caller has put there */
	*layout = (fw_sbf_meas3_layout){.short_master = head >> 3 & 15};
	unsigned n = (head & 7) == 7 ? 8 : head & 7;
	left -= 1 + (ptrdiff_t)n;
	if (left < 0)
		return 0;
	for (unsigned i = 0; i < n; i++)
		layout->satellites |= (uint64_t)*b->p++ << 8 * i;
	n = system == GLONASS ? ((unsigned)__builtin_popcountll(layout->satellites) + 1) / 2 : 0;
	left -= (ptrdiff_t)n + (system == BEIDOU ? 2 : 0) + (head >> 7);
	if (left < 0)
		return 0;
	memcpy(layout->glonass, b->p, n);
	b->p += n;
	if (system == BEIDOU) {
		layout->far = fw_load_u16(b->p);
		b->p += 2;
	}
	if (head >> 7)
		layout->excluded = *b->p++;
	return 1;
}

static void prepare_numbers(walk *w, uint8_t excluded)
{
	unsigned n = 0;
	memset(w->numbers, NO_SIGNAL, sizeof w->numbers);
	for (unsigned i = 0; i < FW_MEAS3_SIGNALS; i++)
		if (!(excluded >> i & 1))
			w->numbers[n++] = signal_table[w->system][i];
}

static int take_system(walk *w, unsigned system)
{
	fw_sbf_meas3_layout layout = w->ref->layout[system];
	if (!take_layout(&w->ranges, system, &layout))
		return 0;
	if (w->is_reference)
		w->ref->layout[system] = layout;
	w->system = system;
	prepare_numbers(w, layout.excluded);

	unsigned n = 0;
	for (unsigned i = 0; i < FW_MEAS3_SATELLITES; i++) {
		if (!(layout.satellites >> i & 1))
			continue;
		unsigned nibble = layout.glonass[n / 2] >> (n % 2 * 4) & 15;
		w->channel_known = system == GLONASS && nibble >= 1 && nibble <= 14;
		w->channel = w->channel_known ? (int)nibble - 8 : 0;
		w->base_mm = n < 16 && layout.far >> n & 1 ? far_base_mm : range_base_mm[system];
		w->name = satellite_name(system, i);
		w->old = &w->ref->satellites[system][i];
		if (!take_satellite(w, layout.short_master))
			return 0;
		n++;
	}
	return 1;
}

static bytes extension_body(const fw_sbf_meas3 *m, unsigned antenna, unsigned kind)
{
	if (m->held[antenna][kind].length == 0)
		return (bytes){m->bytes, m->bytes};
	const uint8_t *block = m->bytes + m->held[antenna][kind].at;
	return (bytes){block + EXTENSION_HEADER, block + m->held[antenna][kind].length};
}

static bits bits_of(bytes b)
{
	return (bits){b.p, 0, (size_t)(b.end - b.p) * 8};
}

/* From the block's first system to its last; 0 when they do not fit into it. */
static int take_all(walk *w, const uint8_t *block, unsigned length)
{
	const fw_sbf_meas3 *m = w->m;
	w->ranges = (bytes){block + RANGES_HEADER, block + length};
	w->doppler = extension_body(m, w->antenna, DOPPLER);
	w->cn0 = bits_of(extension_body(m, w->antenna, CN0HIRES));
	w->mp = bits_of(extension_body(m, w->antenna, MP));
	bytes pp = extension_body(m, w->antenna, PP);
	w->pp = bits_of(pp);
	size_t second = pp.p < pp.end ? pp.p[-1] * 32u : 0; /* where PP's second part begins [bits] */
	if (second != 0 && second < w->pp.end)
		w->pp.end = second;

	for (unsigned system = 0; system < FW_MEAS3_SYSTEMS; system++)
		if (fw_load_u16(block + 16) >> system & 1 && !take_system(w, system))
			return 0;
	return 1;
}

/* The time of the epoch that is open; returns which of the two are known, the other is 0. */
static int64_t set_time(const fw_sbf_meas3 *m, int32_t *gps_week, double *tow_s)
{
	int has_week = m->week != UINT16_MAX, has_tow = m->tow_ms != UINT32_MAX;
	*gps_week = has_week ? m->week : 0;
	*tow_s = has_tow ? m->tow_ms / 1000.0 : 0;
	return (has_week ? BIT(FW_COL_obs_gps_week) : 0) | (has_tow ? BIT(FW_COL_obs_tow_s) : 0);
}

/* Decodes the Meas3Ranges of an antenna: once to see whether it is sound, once for its records. Returns whether
 * it was. */
static int decode_antenna(fw_sbf_meas3 *m, unsigned antenna, unsigned *n_signals)
{
	const uint8_t *block = m->bytes + m->held[antenna][0].at;
	uint32_t interval = interval_ms[block[18] >> 4];
	fw_sbf_meas3_reference *ref = &m->reference[antenna];
	walk w = {.m = m,
	          .ref = ref,
	          .elapsed_ms = m->tow_ms % interval,
	          .common = block[14],
	          .has_rate = block[18] >> 3 & 1,
	          .antenna = (uint8_t)antenna};
	w.is_reference = w.elapsed_ms == 0;
	w.time = set_time(m, &w.gps_week, &w.tow_s);

	if (w.is_reference) {
		ref->valid = 0;
		ref->stamp++;
		memset(ref->layout, 0, sizeof ref->layout);
	}
	if (w.common & COMMON_SCRAMBLED) {
		m->stats.scrambled++;
		return 0;
	}
	if (!w.is_reference &&
	    !(ref->valid && ref->week == m->week && ref->tow_ms == m->tow_ms - w.elapsed_ms)) {
		m->stats.lost_epochs++;
		return 0;
	}
	if (!take_all(&w, block, m->held[antenna][0].length)) {
		m->stats.malformed++;
		return 0;
	}
	if (w.is_reference) {
		ref->tow_ms = m->tow_ms;
		ref->week = m->week;
		ref->valid = 1;
	}
	w.emit = 1;
	(void)take_all(&w, block, m->held[antenna][0].length);
	*n_signals += w.n_signals;
	return 1;
}

static void emit_epoch(const fw_sbf_meas3 *m, uint8_t common, uint8_t clock_jumps_ms, unsigned n_signals)
{
	furrow_epoch e = {
	    .n_signals = (int16_t)n_signals,
	    .multipath_mitigation = common & 1,
	    .smoothed = (common & COMMON_SMOOTHED) != 0,
	    .clock_steering = (common & COMMON_STEERING) != 0,
	    .high_dynamics = (common & COMMON_DYNAMICS) != 0,
	    .e6b = (common & COMMON_E6B) != 0,
	    .clock_jumps_ms = clock_jumps_ms,
	};
	e.present = BIT(FW_COL_epoch_COUNT) - BIT(FW_COL_epoch_n_signals); /* all behind the time */
	e.present |= set_time(m, &e.gps_week, &e.tow_s);
	m->sink.put(m->sink.context, FW_epoch, &e);
}

void fw_sbf_meas3_flush(fw_sbf_meas3 *m)
{
	unsigned n_signals = 0, n_decoded = 0;
	uint8_t common = 0, clock_jumps_ms = 0;
	for (unsigned antenna = 0; antenna < FW_MEAS3_ANTENNAS; antenna++) {
		if (m->held[antenna][0].length == 0) {
			for (unsigned kind = 1; kind < FW_MEAS3_BLOCKS; kind++)
				m->stats.orphans += m->held[antenna][kind].length != 0;
			continue;
		}
		if (!decode_antenna(m, antenna, &n_signals))
			continue;
		const uint8_t *block = m->bytes + m->held[antenna][0].at;
		if (n_decoded++ == 0)
			clock_jumps_ms = block[15];
		common |= block[14];
	}
	if (n_decoded > 0 && fw_kind_in(&m->wanted, FW_epoch))
		emit_epoch(m, common, clock_jumps_ms, n_signals);
	memset(m->held, 0, sizeof m->held);
	m->used = 0;
}

void fw_sbf_meas3_init(fw_sbf_meas3 *m, unsigned antennas, const fw_kind_set *wanted, fw_sink sink)
{
	memset(m, 0, sizeof *m);
	m->antennas = antennas;
	m->wanted = *wanted;
	m->sink = sink;
}

fw_status fw_sbf_meas3_put(fw_sbf_meas3 *m, const uint8_t *block, uint16_t length)
{
	if (length < FW_MEAS3_BLOCKS + 3)
		return FW_EFORMAT;
	unsigned number = fw_load_u16(block + 4) & 0x1fff, kind = number - RANGES;
	if (number == END_OF_MEAS) {
		fw_sbf_meas3_flush(m);
		return FW_OK;
	}
	if (kind >= FW_MEAS3_BLOCKS)
		return FW_EUNKNOWN;
	if (length < (kind == 0 ? RANGES_HEADER : EXTENSION_HEADER))
		return FW_EFORMAT;

	uint32_t tow_ms = fw_load_u32(block + 8);
	uint16_t week = fw_load_u16(block + 12);
	if (tow_ms != m->tow_ms || week != m->week)
		fw_sbf_meas3_flush(m);
	m->tow_ms = tow_ms;
	m->week = week;

	unsigned antenna = block[kind == 0 ? 18 : 14] & 7;
	if (antenna >= FW_MEAS3_ANTENNAS || (kind == 0 && block[19] > MAX_VERSION) ||
	    m->held[antenna][kind].length != 0)
		return FW_EFORMAT;
	if (length > FW_MEAS3_ROOM - m->used)
		return FW_ENOSPACE;
	memcpy(m->bytes + m->used, block, length);
	m->held[antenna][kind].at = m->used;
	m->held[antenna][kind].length = length;
	m->used += length;
	return FW_OK;
}
