#include "formats/sbf_measurements.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "formats/bytes.h"
#include "formats/crc.h"
#include "formats/sbf_codec.h"
#include "formats/sbf_signal.h"
#include "furrow_epoch_columns.h"
#include "furrow_obs_columns.h"
#include "furrow_obs_extra.h"
#include "furrow_obs_extra_columns.h"

/** SI and all GNSS interface documents: speed of light [m/s] */
#define SPEED_OF_LIGHT_MPS 299792458.0

enum { HEADER = 20, TYPE1 = 20, TYPE2 = 12, EXTRA_REV0 = 12 };

enum { SIGNAL_ESCAPE = 31, SIGNAL_E6 = 19 };

enum {
	COMMON_SMOOTHED = 1 << 1,
	COMMON_STEERING = 1 << 3,
	COMMON_DYNAMICS = 1 << 5,
	COMMON_E6B = 1 << 6,
	COMMON_SCRAMBLED = 1 << 7
};

#define BIT(column) (INT64_C(1) << (column))

/* What is the same for all signals of a satellite, from its Type1 sub-block. */
typedef struct {
	int64_t range_mm; /* 0: not available */
	int glonass_channel;
	double doppler_hz;
	double frequency_hz; /* of the Type1 signal */
	int has_doppler;
} parent;

static int64_t set_time(uint32_t tow_ms, uint16_t week, int32_t *gps_week, double *tow_s)
{
	int64_t present = 0;
	*gps_week = 0;
	*tow_s = 0;
	if (week != UINT16_MAX) {
		*gps_week = week;
		present |= BIT(FW_COL_obs_gps_week);
	}
	if (tow_ms != UINT32_MAX) {
		*tow_s = tow_ms / 1000.0;
		present |= BIT(FW_COL_obs_tow_s);
	}
	return present;
}

/* The signal number of a Type1 or Type2: five bits of Type, continued in ObsInfo. */
static unsigned signal_number(uint8_t type, uint8_t obs_info)
{
	unsigned low = type & 31;
	return low == SIGNAL_ESCAPE ? 32U + (obs_info >> 3) : low;
}

static const char *rinex_code(const fw_sbf_signal *signal, unsigned number, int e6b)
{
	return number == SIGNAL_E6 && e6b ? "6B" : signal->rinex;
}

/* GLONASS FDMA frequencies depend on the channel; without it the wavelength is not known. */
static double carrier_frequency(const fw_sbf_signal *signal, int glonass_channel, int channel_known)
{
	if (signal->channel_spacing_hz > 0 && !channel_known)
		return 0;
	return signal->frequency_hz + glonass_channel * signal->channel_spacing_hz;
}

static void put_range(furrow_obs *o, int64_t range_mm)
{
	o->pseudorange_m = (double)range_mm / 1000.0;
	o->present |= BIT(FW_COL_obs_pseudorange_m);
}

/* Carrier phase: the pseudorange in cycles plus the offset that the sub-block holds (0.001 cycle). */
static void put_carrier(furrow_obs *o, double frequency_hz, int8_t msb, uint16_t lsb)
{
	if ((msb == INT8_MIN && lsb == 0) || !(frequency_hz > 0))
		return;
	double wavelength_m = SPEED_OF_LIGHT_MPS / frequency_hz;
	o->carrier_cyc = o->pseudorange_m / wavelength_m + (msb * 65536 + lsb) * 0.001;
	o->present |= BIT(FW_COL_obs_carrier_cyc);
}

/* Signals 1 and 2, the P(Y) codes, are stored without the offset of 10 dB-Hz that all others have. */
static void put_cn0(furrow_obs *o, unsigned number, uint8_t cn0)
{
	if (cn0 == UINT8_MAX)
		return;
	o->cn0_dbhz = cn0 * 0.25 + (number == 1 || number == 2 ? 0 : 10);
	o->present |= BIT(FW_COL_obs_cn0_dbhz);
}

static void put_lock(furrow_obs *o, uint16_t lock, uint16_t do_not_use)
{
	if (lock == do_not_use)
		return;
	o->lock_s = lock;
	o->present |= BIT(FW_COL_obs_lock_s);
}

/* Fills what Type1 and Type2 share; returns the signal or NULL when it is not to be shown. */
static const fw_sbf_signal *begin_signal(furrow_obs *o, const furrow_obs *shared, uint8_t type,
                                         uint8_t obs_info, int e6b, const parent *sat)
{
	unsigned number = signal_number(type, obs_info);
	const fw_sbf_signal *signal = fw_sbf_signal_of(number);
	if (signal == NULL || signal->rinex[0] == '\0')
		return NULL;
	*o = *shared;
	o->signal = (char *)(uintptr_t)rinex_code(signal, number, e6b);
	o->antenna = (int8_t)(type >> 5);
	o->half_cycle = obs_info >> 2 & 1;
	o->smoothed = obs_info & 1;
	o->present |= BIT(FW_COL_obs_signal) | BIT(FW_COL_obs_antenna) | BIT(FW_COL_obs_half_cycle) |
	              BIT(FW_COL_obs_smoothed);
	if (signal->system == 'R' && sat->glonass_channel != INT8_MIN) {
		o->glonass_channel = (int8_t)sat->glonass_channel;
		o->present |= BIT(FW_COL_obs_glonass_channel);
	}
	return signal;
}

static int type1(const uint8_t *p, furrow_obs *o, const furrow_obs *shared, int e6b, parent *sat)
{
	uint8_t type = p[1], obs_info = p[18];
	unsigned number = signal_number(type, obs_info);
	int is_fdma = number >= 8 && number <= 11;

	sat->range_mm = (int64_t)(p[3] & 15) << 32 | fw_load_u32(p + 4);
	sat->glonass_channel = is_fdma && obs_info >> 3 != 0 ? (obs_info >> 3) - 8 : INT8_MIN;
	int32_t doppler = (int32_t)fw_load_u32(p + 8);
	sat->has_doppler = doppler != INT32_MIN;
	sat->doppler_hz = doppler / 10000.0;
	sat->frequency_hz = 0;

	const fw_sbf_signal *signal = begin_signal(o, shared, type, obs_info, e6b, sat);
	if (signal == NULL)
		return 0;
	sat->frequency_hz = carrier_frequency(signal, sat->glonass_channel, sat->glonass_channel != INT8_MIN);
	if (sat->range_mm != 0) {
		put_range(o, sat->range_mm);
		put_carrier(o, sat->frequency_hz, (int8_t)p[14], fw_load_u16(p + 12));
	}
	if (sat->has_doppler) {
		o->doppler_hz = sat->doppler_hz;
		o->present |= BIT(FW_COL_obs_doppler_hz);
	}
	put_cn0(o, number, p[15]);
	put_lock(o, fw_load_u16(p + 16), UINT16_MAX);
	return 1;
}

static int type2(const uint8_t *p, furrow_obs *o, const furrow_obs *shared, int e6b, const parent *sat)
{
	uint8_t type = p[0], obs_info = p[5];
	const fw_sbf_signal *signal = begin_signal(o, shared, type, obs_info, e6b, sat);
	if (signal == NULL)
		return 0;
	double frequency_hz =
	    carrier_frequency(signal, sat->glonass_channel, sat->glonass_channel != INT8_MIN);

	/* OffsetsMSB: signed three bits for the code, signed five bits for the Doppler. */
	int code_msb = (int8_t)(p[3] << 5) >> 5;
	int doppler_msb = (int8_t)p[3] >> 3;
	uint16_t code_lsb = fw_load_u16(p + 6), doppler_lsb = fw_load_u16(p + 10);

	if (sat->range_mm != 0 && !(code_msb == -4 && code_lsb == 0)) {
		put_range(o, sat->range_mm + code_msb * 65536 + code_lsb);
		put_carrier(o, frequency_hz, (int8_t)p[4], fw_load_u16(p + 8));
	}
	if (sat->has_doppler && !(doppler_msb == -16 && doppler_lsb == 0) && sat->frequency_hz > 0 &&
	    frequency_hz > 0) {
		o->doppler_hz = sat->doppler_hz * (frequency_hz / sat->frequency_hz) +
		                (doppler_msb * 65536 + doppler_lsb) * 1e-4;
		o->present |= BIT(FW_COL_obs_doppler_hz);
	}
	put_cn0(o, signal_number(type, obs_info), p[2]);
	put_lock(o, p[1], UINT8_MAX);
	return 1;
}

static void emit_epoch(const uint8_t *block, const furrow_obs *head, unsigned n_signals, fw_sink sink)
{
	uint8_t flags = block[17];
	furrow_epoch e = {
	    .present =
	        (BIT(FW_COL_epoch_COUNT) - 1) &
	        ~(BIT(FW_COL_epoch_gps_week) | BIT(FW_COL_epoch_tow_s) | BIT(FW_COL_epoch_clock_jumps_ms)),
	    .gps_week = head->gps_week,
	    .tow_s = head->tow_s,
	    .n_signals = (int16_t)n_signals,
	    .multipath_mitigation = flags & 1,
	    .smoothed = (flags & COMMON_SMOOTHED) != 0,
	    .clock_steering = (flags & COMMON_STEERING) != 0,
	    .high_dynamics = (flags & COMMON_DYNAMICS) != 0,
	    .e6b = (flags & COMMON_E6B) != 0,
	    .scrambled = (flags & COMMON_SCRAMBLED) != 0,
	};
	e.present |= head->present;
	if (block[5] >> 5 >= 1) { /* revision 0 has no count of clock jumps */
		e.clock_jumps_ms = block[18];
		e.present |= BIT(FW_COL_epoch_clock_jumps_ms);
	}
	sink.put(sink.context, FW_epoch, &e);
}

int fw_sbf_is_scrambled(const uint8_t *block, uint16_t length)
{
	return length >= HEADER && (block[17] & COMMON_SCRAMBLED) != 0;
}

void fw_sbf_meas_epoch(const uint8_t *block, uint16_t length, unsigned antennas, const fw_kind_set *wanted,
                       fw_sink sink, fw_sbf_channels *channels, fw_sbf_left_out *left_out)
{
	if (length < HEADER)
		return;
	const uint8_t *end = block + length, *p = block + HEADER;
	unsigned size1 = block[15], size2 = block[16], n_signals = 0;
	bool e6b = (block[17] & COMMON_E6B) != 0;
	int want_obs = fw_kind_in(wanted, FW_obs) && !fw_sbf_is_scrambled(block, length);
	furrow_obs shared = {0}, o;

	channels->tow_ms = fw_load_u32(block + 8);
	channels->week = fw_load_u16(block + 12);
	channels->e6b = e6b;
	memset(channels->satellite, 0, sizeof channels->satellite);
	int64_t time = set_time(channels->tow_ms, channels->week, &shared.gps_week, &shared.tow_s);
	if (size1 < TYPE1)
		return;

	for (unsigned i = 0; i < block[14] && end - p >= (ptrdiff_t)size1; i++) {
		const uint8_t *sub = p;
		parent sat;
		p += size1;
		const char *satellite = fw_sbf_satellite(sub[2]);
		channels->satellite[sub[0]] = satellite;
		shared.sat = (char *)(uintptr_t)satellite;
		shared.rx_channel = sub[0];
		shared.present =
		    time | BIT(FW_COL_obs_rx_channel) | (satellite != NULL ? BIT(FW_COL_obs_sat) : 0);

		for (unsigned k = 0; k <= sub[19]; k++) {
			const uint8_t *q = sub;
			if (k > 0) {
				if (size2 < TYPE2 || end - p < (ptrdiff_t)size2)
					break;
				q = p;
				p += size2;
			}
			int shown =
			    k == 0 ? type1(q, &o, &shared, e6b, &sat) : type2(q, &o, &shared, e6b, &sat);
			if (!shown)
				continue;
			n_signals++;
			if (!(antennas >> o.antenna & 1))
				left_out->other_antenna++;
			else if (satellite == NULL)
				left_out->unnamed++;
			else if (want_obs)
				sink.put(sink.context, FW_obs, &o);
		}
	}
	shared.present = time;
	if (fw_kind_in(wanted, FW_epoch))
		emit_epoch(block, &shared, n_signals, sink);
}

/* One sub-block of MeasExtra; `size` bytes, of which revision 0 had 12. Later revisions filled what had been padding. */
static int extra(const uint8_t *p, unsigned size, unsigned revision, float doppler_factor, bool e6b,
                 furrow_obs_extra *x)
{
	unsigned number = size >= 16 && revision >= 3 ? signal_number(p[1], p[15]) : p[1] & 31;
	const fw_sbf_signal *signal = fw_sbf_signal_of(number);
	if (signal == NULL || signal->rinex[0] == '\0')
		return 0;
	x->signal = (char *)(uintptr_t)rinex_code(signal, number, e6b);
	x->antenna = (int8_t)(p[1] >> 5);
	x->rx_channel = p[0];
	x->multipath_corr_m = (int16_t)fw_load_u16(p + 2) / 1000.0;
	x->smoothing_corr_m = (int16_t)fw_load_u16(p + 4) / 1000.0;
	x->present |= BIT(FW_COL_obs_extra_signal) | BIT(FW_COL_obs_extra_antenna) |
	              BIT(FW_COL_obs_extra_rx_channel) | BIT(FW_COL_obs_extra_multipath_corr_m) |
	              BIT(FW_COL_obs_extra_smoothing_corr_m);
	uint16_t code_var = fw_load_u16(p + 6), carrier_var = fw_load_u16(p + 8), lock = fw_load_u16(p + 10);
	if (code_var != UINT16_MAX) {
		x->code_var_m2 = code_var / 10000.0;
		x->present |= BIT(FW_COL_obs_extra_code_var_m2);
	}
	if (carrier_var != UINT16_MAX) {
		x->carrier_var_cyc2 = carrier_var / 1e6;
		x->present |= BIT(FW_COL_obs_extra_carrier_var_cyc2);
		if (doppler_factor >= 0 && doppler_factor < 1e30f) {
			x->doppler_var_hz2 = x->carrier_var_cyc2 * (double)doppler_factor;
			x->present |= BIT(FW_COL_obs_extra_doppler_var_hz2);
		}
	}
	if (lock != UINT16_MAX) {
		x->lock_s = lock;
		x->present |= BIT(FW_COL_obs_extra_lock_s);
	}
	if (size >= 16 && revision >= 1) {
		x->loss_count = p[12];
		x->carrier_multipath_corr_cyc = (int8_t)p[13] / 512.0;
		x->present |=
		    BIT(FW_COL_obs_extra_loss_count) | BIT(FW_COL_obs_extra_carrier_multipath_corr_cyc);
	}
	if (size >= 16 && revision >= 2) {
		x->info = p[14];
		x->present |= BIT(FW_COL_obs_extra_info);
	}
	if (size >= 16 && revision >= 3) {
		x->cn0_highres_dbhz = (p[15] & 7) * 0.03125;
		x->present |= BIT(FW_COL_obs_extra_cn0_highres_dbhz);
	}
	return 1;
}

void fw_sbf_meas_extra(const uint8_t *block, uint16_t length, unsigned antennas,
                       const fw_sbf_channels *channels, fw_sink sink)
{
	if (length < HEADER || block[15] < EXTRA_REV0)
		return;
	const uint8_t *end = block + length, *p = block + HEADER;
	unsigned size = block[15];
	uint32_t tow_ms = fw_load_u32(block + 8);
	uint16_t week = fw_load_u16(block + 12);
	int same_epoch = tow_ms == channels->tow_ms && week == channels->week;
	float doppler_factor = fw_load_f32(block + 16);
	int32_t gps_week;
	double tow_s;
	int64_t time = set_time(tow_ms, week, &gps_week, &tow_s);

	for (unsigned i = 0; i < block[14] && end - p >= (ptrdiff_t)size; i++, p += size) {
		furrow_obs_extra x = {.present = time, .gps_week = gps_week, .tow_s = tow_s};
		if (!extra(p, size, block[5] >> 5, doppler_factor, same_epoch && channels->e6b, &x) ||
		    !(antennas >> x.antenna & 1))
			continue;
		if (same_epoch && channels->satellite[p[0]] != NULL) {
			x.sat = (char *)(uintptr_t)channels->satellite[p[0]];
			x.present |= BIT(FW_COL_obs_extra_sat);
		}
		sink.put(sink.context, FW_obs_extra, &x);
	}
}

/* ---- encoding ---- */

static int has(int64_t present, int column)
{
	return (int)(present >> column & 1);
}

/* The signal number of an observation: by its system and RINEX code. 64 when SBF has none. */
static unsigned find_signal(const furrow_obs *o)
{
	for (unsigned number = 0; number < 64; number++) {
		const fw_sbf_signal *s = fw_sbf_signal_of(number);
		if (s != NULL && s->system == o->sat[0] &&
		    strcmp(rinex_code(s, number, strcmp(o->signal, "6B") == 0), o->signal) == 0)
			return number;
	}
	return 64;
}

static uint8_t encode_cn0(const furrow_obs *o, unsigned number)
{
	if (!has(o->present, FW_COL_obs_cn0_dbhz))
		return UINT8_MAX;
	double steps = nearbyint((o->cn0_dbhz - (number == 1 || number == 2 ? 0 : 10)) / 0.25);
	return (uint8_t)fmin(fmax(steps, 0), UINT8_MAX - 1);
}

/* Carrier minus the range in cycles, in 0.001 cycle: 24 bits, the lowest value means absent. */
static fw_status encode_carrier(const furrow_obs *o, double frequency_hz, uint8_t *msb, uint8_t *lsb)
{
	*msb = (uint8_t)INT8_MIN;
	fw_store_u16(lsb, 0);
	if (!has(o->present, FW_COL_obs_carrier_cyc) || !has(o->present, FW_COL_obs_pseudorange_m))
		return FW_OK;
	double cycles = nearbyint(o->pseudorange_m * 1000) / 1000.0 / (SPEED_OF_LIGHT_MPS / frequency_hz);
	double offset = nearbyint((o->carrier_cyc - cycles) * 1000);
	if (!(offset > INT8_MIN * 65536.0 && offset <= INT8_MAX * 65536.0 + UINT16_MAX))
		return FW_ERANGE;
	int32_t value = (int32_t)offset;
	*msb = (uint8_t)(value >> 16);
	fw_store_u16(lsb, (uint16_t)value);
	return FW_OK;
}

/* Type (signal and antenna) and ObsInfo (flags and the signal's upper bits or the GLONASS channel). */
static void encode_type(const furrow_obs *o, unsigned number, uint8_t *type, uint8_t *obs_info)
{
	unsigned low = number >= 32 ? SIGNAL_ESCAPE : number, high = number >= 32 ? number - 32 : 0;
	if (number >= 8 && number <= 11 && has(o->present, FW_COL_obs_glonass_channel))
		high = (unsigned)(o->glonass_channel + 8) & 31;
	*type = (uint8_t)(low | (unsigned)(o->antenna & 7) << 5);
	*obs_info = (uint8_t)(high << 3 | (o->half_cycle ? 4 : 0) | (o->smoothed ? 1 : 0));
}

static double frequency_of(const furrow_obs *o, unsigned number)
{
	return carrier_frequency(fw_sbf_signal_of(number), o->glonass_channel, 1);
}

static fw_status encode_type1(const furrow_obs *o, unsigned number, uint8_t p[static TYPE1])
{
	memset(p, 0, TYPE1);
	p[0] = (uint8_t)o->rx_channel;
	p[2] = fw_sbf_svid(o->sat);
	encode_type(o, number, &p[1], &p[18]);
	int64_t range_mm = 0;
	if (has(o->present, FW_COL_obs_pseudorange_m)) {
		if (!(o->pseudorange_m > 0 && o->pseudorange_m < 68e6))
			return FW_ERANGE;
		range_mm = (int64_t)nearbyint(o->pseudorange_m * 1000);
	}
	p[3] = (uint8_t)(range_mm >> 32);
	fw_store_u32(p + 4, (uint32_t)range_mm);
	int32_t doppler = INT32_MIN;
	if (has(o->present, FW_COL_obs_doppler_hz)) {
		if (!(fabs(o->doppler_hz) < 2e5))
			return FW_ERANGE;
		doppler = (int32_t)nearbyint(o->doppler_hz * 1e4);
	}
	fw_store_u32(p + 8, (uint32_t)doppler);
	p[15] = encode_cn0(o, number);
	int lock = has(o->present, FW_COL_obs_lock_s);
	fw_store_u16(p + 16, lock ? (uint16_t)fmin(fmax(o->lock_s, 0), 65534) : UINT16_MAX);
	return encode_carrier(o, frequency_of(o, number), &p[14], &p[12]);
}

static fw_status encode_type2(const furrow_obs *o, unsigned number, const furrow_obs *first,
                              unsigned first_number, uint8_t p[static TYPE2])
{
	memset(p, 0, TYPE2);
	encode_type(o, number, &p[0], &p[5]);
	p[1] = has(o->present, FW_COL_obs_lock_s) ? (uint8_t)fmin(fmax(o->lock_s, 0), 254) : UINT8_MAX;
	p[2] = encode_cn0(o, number);

	int64_t code = INT64_C(-4) * 65536;
	if (has(o->present, FW_COL_obs_pseudorange_m) && has(first->present, FW_COL_obs_pseudorange_m)) {
		double mm = nearbyint(o->pseudorange_m * 1000) - nearbyint(first->pseudorange_m * 1000);
		if (!(mm > -4 * 65536.0 && mm < 4 * 65536.0))
			return FW_ERANGE;
		code = (int64_t)mm;
	}
	int64_t doppler = INT64_C(-16) * 65536;
	if (has(o->present, FW_COL_obs_doppler_hz) && has(first->present, FW_COL_obs_doppler_hz)) {
		double scaled = nearbyint(first->doppler_hz * 1e4) / 1e4 *
		                (frequency_of(o, number) / frequency_of(first, first_number));
		double steps = nearbyint((o->doppler_hz - scaled) * 1e4);
		if (!(steps > -16 * 65536.0 && steps < 16 * 65536.0))
			return FW_ERANGE;
		doppler = (int64_t)steps;
	}
	p[3] = (uint8_t)((code >> 16 & 7) | (doppler >> 16 & 31) << 3);
	fw_store_u16(p + 6, (uint16_t)code);
	fw_store_u16(p + 10, (uint16_t)doppler);
	return encode_carrier(o, frequency_of(o, number), &p[4], &p[8]);
}

static void encode_header(const furrow_epoch *e, unsigned n1, unsigned length, uint8_t *block)
{
	memset(block, 0, HEADER);
	block[0] = '$';
	block[1] = '@';
	fw_store_u16(block + 4, 4027 | 1 << 13);
	fw_store_u16(block + 6, (uint16_t)length);
	fw_store_u32(block + 8,
	             has(e->present, FW_COL_epoch_tow_s) ? (uint32_t)nearbyint(e->tow_s * 1000) : UINT32_MAX);
	fw_store_u16(block + 12, has(e->present, FW_COL_epoch_gps_week) ? (uint16_t)e->gps_week : UINT16_MAX);
	block[14] = (uint8_t)n1;
	block[15] = TYPE1;
	block[16] = TYPE2;
	block[17] =
	    (uint8_t)((e->multipath_mitigation ? 1 : 0) | (e->smoothed ? COMMON_SMOOTHED : 0) |
	              (e->clock_steering ? COMMON_STEERING : 0) | (e->high_dynamics ? COMMON_DYNAMICS : 0) |
	              (e->e6b ? COMMON_E6B : 0) | (e->scrambled ? COMMON_SCRAMBLED : 0));
	block[18] = (uint8_t)e->clock_jumps_ms;
	fw_store_u16(block + 2, fw_crc16(block + 4, length - 4));
}

fw_status fw_sbf_encode_meas_epoch(const furrow_epoch *epoch, const furrow_obs *obs, unsigned n,
                                   uint8_t *block, uint16_t *length)
{
	uint8_t *p = block + HEADER, *parent_block = NULL;
	const furrow_obs *first = NULL;
	unsigned n1 = 0, first_number = 0;

	for (unsigned i = 0; i < n; i++) {
		const furrow_obs *o = &obs[i];
		unsigned number = find_signal(o);
		if (number >= 64 || fw_sbf_svid(o->sat) == 0)
			return FW_EUNKNOWN;
		if (p - block > FW_SBF_MAX_LENGTH - TYPE1 || n1 == UINT8_MAX ||
		    (parent_block != NULL && parent_block[19] == UINT8_MAX))
			return FW_ERANGE;
		fw_status status;
		if (first != NULL && strcmp(first->sat, o->sat) == 0 && first->rx_channel == o->rx_channel) {
			status = encode_type2(o, number, first, first_number, p);
			parent_block[19]++;
			p += TYPE2;
		} else {
			first = o;
			first_number = number;
			parent_block = p;
			status = encode_type1(o, number, p);
			n1++;
			p += TYPE1;
		}
		if (status != FW_OK)
			return status;
	}
	*length = (uint16_t)(p - block);
	encode_header(epoch, n1, *length, block);
	return FW_OK;
}
