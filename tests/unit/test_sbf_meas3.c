/* The compressed measurement blocks. The vector at the start was put together and computed by hand (in Python with
 * 30 digits) from the layout in sbf_meas3.c; the random epochs come from an encoder of this file's own, which names
 * signals and frequencies by the RINEX tables. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../sbf_files.h"
#include "base/random.h"
#include "formats/bytes.h"
#include "formats/sbf_meas3.h"
#include "furrow_epoch.h"
#include "furrow_epoch_columns.h"
#include "furrow_obs.h"
#include "furrow_obs_columns.h"
#include "furrow_obs_extra.h"
#include "furrow_obs_extra_columns.h"

enum { RANGES = 4109, CN0HIRES, DOPPLER, PP, MP };

static fw_sbf_meas3 meas3;

/* What came out. */
static struct {
	furrow_obs obs[6000];
	furrow_obs_extra extra[6000];
	furrow_epoch epoch;
	unsigned n_obs, n_extra, n_epochs;
} out;

static void collect(void *context, fw_kind kind, const void *record)
{
	(void)context;
	if (kind == FW_obs) {
		assert_true(out.n_obs < 6000);
		out.obs[out.n_obs++] = *(const furrow_obs *)record;
	} else if (kind == FW_obs_extra) {
		assert_true(out.n_extra < 6000);
		out.extra[out.n_extra++] = *(const furrow_obs_extra *)record;
	} else {
		assert_int_equal(kind, FW_epoch);
		out.epoch = *(const furrow_epoch *)record;
		out.n_epochs++;
	}
}

static void start(unsigned antennas)
{
	fw_kind_set wanted = {{0}};
	fw_kind_add(&wanted, FW_obs);
	fw_kind_add(&wanted, FW_obs_extra);
	fw_kind_add(&wanted, FW_epoch);
	memset(&out, 0, sizeof out);
	fw_sbf_meas3_init(&meas3, antennas, &wanted, (fw_sink){collect, NULL});
}

static int has(int64_t present, int column)
{
	return (int)(present >> column & 1);
}

static void assert_near(double value, double expected, double tolerance)
{
	if (!(fabs(value - expected) <= tolerance))
		fail_msg("%.9f is not %.9f", value, expected);
}

static fw_status put_hex(const char *hex)
{
	uint8_t block[64];
	size_t n = strlen(hex) / 2;
	assert_true(n <= sizeof block);
	for (size_t i = 0; i < n; i++) {
		const char digits[] = {hex[2 * i], hex[2 * i + 1], '\0'};
		block[i] = (uint8_t)strtoul(digits, NULL, 16);
	}
	return fw_sbf_meas3_put(&meas3, block, (uint16_t)n);
}

/* G05 at 600 s of week 2300: a short master, a short and a long slave. Reference epochs each second. */
static const char reference_hex[] =
    "244000000d102c00c0270900fc0829070100280101101127149ad20296496400f50179697ad08a7f43a00f21";
/* 0.3 s later: layout as before, a short delta and two slave deltas; then the extensions. */
static const char delta_hex[] = "244000000d102000ec280900fc08290701002801007a00f67f2a608402a08000";
static const char cn0_hex[] = "244000000e101400ec280900fc080000f8000000";
static const char doppler_hex[] = "244000000f101800ec280900fc080000b30450f7ffff0000";
static const char pp_hex[] = "2440000010101400ec280900fc080000c7070000";
static const char mp_hex[] = "2440000011101800ec280900fc080000653ae39c0c000000";
/* EndOfMeas of that epoch. */
static const char end_hex[] = "2440000022171000ec280900fc080000";

static void a_vector_computed_by_hand(void **state)
{
	(void)state;
	static const struct {
		const char *signal;
		double range_m, carrier_cyc, cn0_dbhz;
		int lock_s;
	} expected[] = {
	    {"1C", 20234567.890, 106333376.953152, 44, 60},
	    {"2L", 20234571.390, 82857193.949090, 39, 30},
	    {"2W", 20234571.890, 82857181.829840, 33, 15},
	    {"1C", 20234569.817, 106333387.076606, 45, 60},
	    {"2L", 20234573.327406, 82857201.841495, 38, 30},
	    {"2W", 20234573.816429, 82857189.718245, 33, 15},
	};
	start(255);
	assert_int_equal(put_hex(reference_hex), FW_OK);
	assert_int_equal(put_hex(delta_hex), FW_OK);
	assert_int_equal(put_hex(cn0_hex), FW_OK);
	assert_int_equal(put_hex(doppler_hex), FW_OK);
	assert_int_equal(put_hex(pp_hex), FW_OK);
	assert_int_equal(put_hex(mp_hex), FW_OK);
	assert_int_equal(out.n_obs, 3);
	assert_int_equal(out.n_epochs, 1);
	assert_int_equal(put_hex(end_hex), FW_OK);

	assert_int_equal(out.n_obs, 6);
	for (int i = 0; i < 6; i++) {
		const furrow_obs *o = &out.obs[i];
		assert_int_equal(o->gps_week, 2300);
		assert_near(o->tow_s, i < 3 ? 600 : 600.3, 1e-9);
		assert_string_equal(o->sat, "G05");
		assert_string_equal(o->signal, expected[i].signal);
		assert_int_equal(o->antenna, 0);
		assert_near(o->pseudorange_m, expected[i].range_m, 1e-6);
		assert_near(o->carrier_cyc, expected[i].carrier_cyc, 1e-6);
		assert_near(o->cn0_dbhz, expected[i].cn0_dbhz, 0);
		assert_int_equal(o->lock_s, expected[i].lock_s);
		assert_int_equal(o->half_cycle, 0);
		assert_int_equal(o->smoothed, 0);
		int64_t all = (INT64_C(1) << FW_COL_obs_COUNT) - 1;
		int64_t absent = INT64_C(1) << FW_COL_obs_glonass_channel | INT64_C(1)
		                                                                << FW_COL_obs_rx_channel;
		if (i != 3 && i != 4)
			absent |= INT64_C(1) << FW_COL_obs_doppler_hz;
		assert_int_equal(o->present, all & ~absent);
	}
	assert_near(out.obs[3].doppler_hz, -32.843972, 1e-6);
	assert_near(out.obs[4].doppler_hz, -25.674602, 1e-6);

	static const struct {
		double cn0, range_m, carrier_512th;
		int loss_count, info;
	} extra[] = {{0, 0.25, -3, 3, 1}, {0.4375, 0, 0, 15, 0}, {-0.5, -2.00, 100, 0, 1}};
	assert_int_equal(out.n_extra, 3);
	for (int i = 0; i < 3; i++) {
		const furrow_obs_extra *x = &out.extra[i];
		assert_string_equal(x->sat, "G05");
		assert_string_equal(x->signal, expected[i].signal);
		assert_near(x->cn0_highres_dbhz, extra[i].cn0, 0);
		assert_near(x->multipath_corr_m, extra[i].range_m, 1e-12);
		assert_near(x->carrier_multipath_corr_cyc, extra[i].carrier_512th / 512, 0);
		assert_int_equal(x->loss_count, extra[i].loss_count);
		assert_int_equal(x->info, extra[i].info);
		assert_false(has(x->present, FW_COL_obs_extra_code_var_m2));
		assert_false(has(x->present, FW_COL_obs_extra_lock_s));
	}

	assert_int_equal(out.n_epochs, 2);
	assert_int_equal(out.epoch.present, (INT64_C(1) << FW_COL_epoch_COUNT) - 1);
	assert_int_equal(out.epoch.n_signals, 3);
	assert_int_equal(out.epoch.multipath_mitigation, 1);
	assert_int_equal(out.epoch.smoothed, 0);
	assert_int_equal(out.epoch.clock_steering, 1);
	assert_int_equal(out.epoch.high_dynamics, 1);
	assert_int_equal(out.epoch.e6b, 0);
	assert_int_equal(out.epoch.scrambled, 0);
	assert_int_equal(out.epoch.clock_jumps_ms, 7);
}

/* ---- an encoder ---- */

#define SPEED_OF_LIGHT_MPS 299792458.0

enum { SYSTEMS = 7, SATELLITES = 63, SIGNALS = 8 };

/* RINEX names in the order of the signal indices, and the carriers [MHz], GLONASS of channel 0. */
static const struct {
	char letter;
	unsigned first, last; /* satellite numbers */
	double short_base_m;
	struct {
		const char *name;
		double mhz, step_mhz;
	} signals[SIGNALS];
} rinex[SYSTEMS] = {
    {'G',
     1,
     37,
     19e6,
     {{"1C", 1575.42, 0},
      {"2L", 1227.6, 0},
      {"5Q", 1176.45, 0},
      {"1W", 1575.42, 0},
      {"2W", 1227.6, 0},
      {"1L", 1575.42, 0}}},
    {'R',
     1,
     30,
     19e6,
     {{"1C", 1602, 0.5625},
      {"2C", 1246, 0.4375},
      {"1P", 1602, 0.5625},
      {"2P", 1246, 0.4375},
      {"3Q", 1202.025, 0}}},
    {'E',
     1,
     36,
     22e6,
     {{"1C", 1575.42, 0}, {"5Q", 1176.45, 0}, {"7Q", 1207.14, 0}, {"6C", 1278.75, 0}, {"8Q", 1191.795, 0}}},
    {'C',
     1,
     63,
     20e6,
     {{"2I", 1561.098, 0},
      {"7I", 1207.14, 0},
      {"6I", 1268.52, 0},
      {"1P", 1575.42, 0},
      {"5P", 1176.45, 0},
      {"7D", 1207.14, 0}}},
    {'S', 120, 158, 34e6, {{"1C", 1575.42, 0}, {"5I", 1176.45, 0}}},
    {'J',
     1,
     10,
     34e6,
     {{"1C", 1575.42, 0},
      {"2L", 1227.6, 0},
      {"5Q", 1176.45, 0},
      {"6S", 1278.75, 0},
      {"1L", 1575.42, 0},
      {"1Z", 1575.42, 0},
      {"5P", 1176.45, 0},
      {"1E", 1575.42, 0}}},
    {'I', 1, 14, 34e6, {{"5A", 1176.45, 0}, {"1P", 1575.42, 0}}},
};

static const int lock_ms[16] = {0,   60000, 30000, 15000, 10000, 5000, 2000, 1000,
                                500, 200,   100,   50,    40,    20,   10,   0};

typedef struct {
	double range_m, carrier_cyc;
	int cn0_dbhz, lock; /* lock: an indicator, 0..15 */
	int has_carrier;
} measured;

typedef struct {
	unsigned signals;         /* bits; 0: not in view */
	int channel, is_geo, far; /* far: BeiDou, and among the 16 satellites that can be called so */
	double rate_mps;
	measured now[SIGNALS], sent[SIGNALS],
	    old[SIGNALS]; /* the truth; as coded; as coded at the reference epoch */
	unsigned old_signals;
	int old_rate; /* [64 mm/s] */
} satellite;

typedef struct {
	uint8_t bytes[16384];
	size_t n, n_bits; /* n_bits of the last byte are used; 0: all */
} writer;

static struct {
	fw_random random;
	satellite sky[SYSTEMS][SATELLITES];
	uint8_t excluded[SYSTEMS];
	uint64_t old_mask[SYSTEMS]; /* of satellites, at the reference epoch */
	int has_rate;
	uint32_t interval_ms, elapsed_ms;
	writer blocks[5];
	/* what the decoder should say */
	struct {
		char sat[8];
		const char *signal;
		measured m;
		int channel, loss, settling, multipath_cm, carrier_512th;
		double cn0, doppler_hz;
		int has_doppler;
	} expected[2000];
	unsigned n_expected;
	unsigned kinds[7]; /* of sub-blocks that were used */
} enc;

enum { MASTER_SHORT, MASTER_LONG, DELTA_LONG, DELTA_SHORT, SLAVE_SHORT, SLAVE_LONG, SLAVE_DELTA };

static void put_bits(writer *w, uint32_t value, unsigned n)
{
	for (unsigned i = 0; i < n; i++) {
		assert_true(w->n < sizeof w->bytes);
		if (w->n_bits == 0)
			w->bytes[w->n++] = 0;
		if (value >> i & 1)
			w->bytes[w->n - 1] |= (uint8_t)(1u << w->n_bits);
		w->n_bits = (w->n_bits + 1) % 8;
	}
}

static unsigned below(unsigned n)
{
	return (unsigned)fw_random_below(&enc.random, n);
}

static double between(double low, double high)
{
	return low + (high - low) * fw_random_uniform(&enc.random);
}

static double wave_of(unsigned system, const satellite *t, unsigned i)
{
	return (rinex[system].signals[i].mhz + t->channel * rinex[system].signals[i].step_mhz) * 1e6 /
	       SPEED_OF_LIGHT_MPS;
}

static int is_p_code(unsigned system, unsigned i)
{
	return system == 0 && (i == 3 || i == 4);
}

/* A signal's index after those that are excluded have made room. */
static unsigned moved(unsigned system, unsigned i)
{
	return i - (unsigned)__builtin_popcount(enc.excluded[system] & ((1u << i) - 1));
}

/* The nearest code of x in steps of a thousandth above `zero`; -1 when it is not in 1 .. limit - 1. */
static int64_t code_of(double x, double zero, int64_t limit)
{
	double code = nearbyint((x - zero) * 1000);
	return code >= 1 && code < (double)limit ? (int64_t)code : -1;
}

/* The carrier's code for a start value, 0 when there is no carrier; *sent becomes what the decoder will see. */
static int64_t code_carrier(const measured *now, double zero, int64_t limit, measured *sent)
{
	if (!now->has_carrier)
		return 0;
	int64_t code = code_of(now->carrier_cyc, zero, limit);
	sent->carrier_cyc = zero + (double)code * 0.001;
	return code;
}

static int master_delta(unsigned system, satellite *t, unsigned i)
{
	writer *w = &enc.blocks[0];
	const measured *now = &t->now[i], *old = &t->old[i];
	measured *sent = &t->sent[i];
	double wave = wave_of(system, t, i);
	double zero = old->range_m + (double)((int64_t)t->old_rate * 64 * enc.elapsed_ms / 1000) / 1000.0;
	int step = now->cn0_dbhz - old->cn0_dbhz;
	if (t->signals != t->old_signals || enc.elapsed_ms == 0 || now->lock != old->lock ||
	    (now->has_carrier && !old->has_carrier))
		return 0;
	for (int is_long = 0; is_long < 2; is_long++) {
		double half = is_long ? 65.536 : 8.192, carrier_half = is_long ? 32.768 : 8.192;
		int64_t range = code_of(now->range_m, zero - half, is_long ? 1 << 17 : 1 << 14);
		int cn0 = step + (is_long ? 4 : 1);
		if (range < 0 || cn0 < 0 || cn0 > (is_long ? 7 : 2))
			continue;
		*sent = *now;
		sent->range_m = zero - half + (double)range * 0.001;
		double start = (sent->range_m - old->range_m) * wave + old->carrier_cyc - carrier_half;
		int64_t carrier = code_carrier(now, start, is_long ? 1 << 16 : 1 << 14, sent);
		if (carrier < 0)
			continue;
		if (is_long) {
			put_bits(w, 14 | (uint32_t)(range >> 13) << 4, 8);
			put_bits(w, (uint32_t)(range & 0x1fff), 13);
			put_bits(w, (uint32_t)cn0, 3);
			put_bits(w, (uint32_t)carrier, 16);
		} else {
			put_bits(w, 2 | (uint32_t)cn0 << 2, 4);
			put_bits(w, (uint32_t)range, 14);
			put_bits(w, (uint32_t)carrier, 14);
		}
		enc.kinds[is_long ? DELTA_LONG : DELTA_SHORT]++;
		return 1;
	}
	return 0;
}

static int master_short(unsigned system, satellite *t, unsigned i, unsigned mask)
{
	writer *w = &enc.blocks[0];
	const measured *now = &t->now[i];
	measured *sent = &t->sent[i];
	double base = t->far ? 34e6 : rinex[system].short_base_m;
	double range = nearbyint((now->range_m - base) * 1000);
	if (moved(system, i) != 0 || mask > 31 || now->lock > 7 || now->cn0_dbhz < 24 || now->cn0_dbhz > 55 ||
	    !(range >= 0 && range < 8589934592.0))
		return 0;
	*sent = *now;
	sent->range_m = base + range * 0.001;
	int64_t carrier = code_carrier(now, sent->range_m * wave_of(system, t, i) - 131.072, 1 << 18, sent);
	if (carrier < 0)
		return 0;
	uint64_t code = (uint64_t)range;
	put_bits(w, 1, 1);
	put_bits(w, (uint32_t)carrier, 18);
	put_bits(w, (uint32_t)(code >> 32), 1);
	put_bits(w, (uint32_t)now->lock, 3);
	put_bits(w, (uint32_t)(now->cn0_dbhz - 24), 5);
	put_bits(w, mask >> 1, 4);
	put_bits(w, (uint32_t)code, 32);
	enc.kinds[MASTER_SHORT]++;
	return 1;
}

static void master_long(unsigned system, satellite *t, unsigned i, unsigned mask)
{
	writer *w = &enc.blocks[0];
	const measured *now = &t->now[i];
	measured *sent = &t->sent[i];
	uint64_t range = (uint64_t)nearbyint(now->range_m * 1000);
	*sent = *now;
	sent->range_m = (double)range * 0.001;
	int64_t carrier = code_carrier(now, sent->range_m * wave_of(system, t, i) - 2097.152, 1 << 22, sent);
	assert_true(carrier >= 0);
	put_bits(w, 0, 2);
	put_bits(w, (uint32_t)(range >> 32), 4);
	put_bits(w, (uint32_t)carrier, 22);
	put_bits(w, (uint32_t)now->lock, 4);
	put_bits(w, (uint32_t)range, 32);
	put_bits(w, (uint32_t)(now->cn0_dbhz - (is_p_code(system, i) ? 0 : 10)), 6);
	put_bits(w, mask, 9);
	put_bits(w, 0, 1);
	enc.kinds[MASTER_LONG]++;
}

static int slave_delta(unsigned system, satellite *t, unsigned i, unsigned master)
{
	writer *w = &enc.blocks[0];
	const measured *now = &t->now[i], *old = &t->old[i];
	measured *sent = &t->sent[i];
	double wave = wave_of(system, t, i);
	int cn0 = now->cn0_dbhz - old->cn0_dbhz + 2;
	if (t->signals != t->old_signals || enc.elapsed_ms == 0 || now->lock != old->lock ||
	    !now->has_carrier || !old->has_carrier || !t->now[master].has_carrier ||
	    !t->old[master].has_carrier || cn0 < 0 || cn0 > 3)
		return 0;
	*sent = *now;
	double start = old->carrier_cyc + (t->sent[master].carrier_cyc - t->old[master].carrier_cyc) * wave /
	                                      wave_of(system, t, master);
	int64_t carrier = code_carrier(now, start - 0.128, 256, sent);
	if (carrier < 0)
		return 0;
	double range_zero = old->range_m + (sent->carrier_cyc - old->carrier_cyc) / wave - 2.048;
	int64_t range = code_of(now->range_m, range_zero, 4096);
	if (range < 0)
		return 0;
	sent->range_m = range_zero + (double)range * 0.001;
	put_bits(w, 2, 2);
	put_bits(w, (uint32_t)range, 12);
	put_bits(w, (uint32_t)cn0, 2);
	put_bits(w, (uint32_t)carrier, 8);
	enc.kinds[SLAVE_DELTA]++;
	return 1;
}

static int slave_short(unsigned system, satellite *t, unsigned i, unsigned master)
{
	writer *w = &enc.blocks[0];
	const measured *now = &t->now[i], *first = &t->sent[master];
	measured *sent = &t->sent[i];
	double wave = wave_of(system, t, i), master_wave = wave_of(system, t, master);
	double sign = master_wave > wave ? 1 : -1;
	int64_t range = code_of((now->range_m - first->range_m) * sign, -10, 1 << 15);
	int cn0 = is_p_code(system, i) ? first->cn0_dbhz - 3 - now->cn0_dbhz : now->cn0_dbhz - 24;
	if (range < 0 || cn0 < 0 || cn0 > 31 || now->lock > 7 ||
	    (now->has_carrier && !t->now[master].has_carrier))
		return 0;
	*sent = *now;
	sent->range_m = first->range_m + sign * ((double)range * 0.001 - 10);
	double offset = (first->carrier_cyc - first->range_m * master_wave) * master_wave / wave;
	int64_t carrier = code_carrier(now, sent->range_m * wave + offset - 32.768, 1 << 16, sent);
	if (carrier < 0)
		return 0;
	put_bits(w, 1, 1);
	put_bits(w, (uint32_t)carrier, 16);
	put_bits(w, (uint32_t)range, 15);
	put_bits(w, (uint32_t)now->lock, 3);
	put_bits(w, (uint32_t)cn0, 5);
	enc.kinds[SLAVE_SHORT]++;
	return 1;
}

static void slave_long(unsigned system, satellite *t, unsigned i, unsigned master)
{
	writer *w = &enc.blocks[0];
	const measured *now = &t->now[i];
	measured *sent = &t->sent[i];
	int64_t range = (int64_t)nearbyint((now->range_m - t->sent[master].range_m) * 1000) + 262144;
	assert_true(range >= 0 && range < 1 << 19);
	*sent = *now;
	sent->range_m = t->sent[master].range_m + (double)(range - 262144) * 0.001;
	int64_t carrier = code_carrier(now, sent->range_m * wave_of(system, t, i) - 2097.152, 1 << 22, sent);
	assert_true(carrier >= 0);
	put_bits(w, 0, 2);
	put_bits(w, (uint32_t)carrier, 22);
	put_bits(w, (uint32_t)now->lock, 4);
	put_bits(w, (uint32_t)(range >> 16), 4);
	put_bits(w, (uint32_t)(range & 0xffff), 16);
	put_bits(w, (uint32_t)(now->cn0_dbhz - (is_p_code(system, i) ? 0 : 10)), 8);
	enc.kinds[SLAVE_LONG]++;
}

static void put_rate(writer *w, int32_t rate_mmps)
{
	static const struct {
		unsigned prefix, n_prefix, n;
	} forms[] = {{0, 1, 6}, {1, 2, 13}, {3, 3, 20}, {7, 3, 28}};
	uint32_t size = (uint32_t)abs(rate_mmps);
	int form = size < 1 << 6 ? 0 : size < 1 << 13 ? 1 : size < 1 << 20 ? 2 : 3;
	put_bits(w, rate_mmps < 0, 1);
	put_bits(w, forms[form].prefix, forms[form].n_prefix);
	put_bits(w, size, forms[form].n);
}

/* The extensions of a signal, and all that is expected of it. */
static void extend(unsigned system, unsigned number, const satellite *t, unsigned i, int is_master,
                   int reference_rate)
{
	static int master_rate, master_has_rate; /* [mm/s] */
	int rate = (int)nearbyint(t->rate_mps * 1000) + (int)below(200) - 100, has_rate = below(20) != 0;
	unsigned n = enc.n_expected++;
	assert_true(n < 2000);
	if (is_master) {
		put_rate(&enc.blocks[2], has_rate ? rate - reference_rate * 64 : -0xfffffff);
		master_rate = rate;
		master_has_rate = has_rate;
	} else {
		put_rate(&enc.blocks[2], has_rate ? rate - master_rate : -0xfffff);
		has_rate = has_rate && master_has_rate;
	}
	snprintf(enc.expected[n].sat, sizeof enc.expected[n].sat, "%c%02u", rinex[system].letter, number);
	enc.expected[n].signal = rinex[system].signals[i].name;
	enc.expected[n].m = t->now[i];
	enc.expected[n].channel = t->channel;
	enc.expected[n].has_doppler = has_rate;
	enc.expected[n].doppler_hz = -rate / 1000.0 * wave_of(system, t, i);

	unsigned cn0 = below(16), loss = below(16), settling = below(2), type = below(4);
	put_bits(&enc.blocks[1], cn0, 4);
	enc.expected[n].cn0 = cn0 / 16.0 - 0.5;
	put_bits(&enc.blocks[3], settling | loss << 1, 5);
	enc.expected[n].loss = (int)loss;
	enc.expected[n].settling = (int)settling;
	int range = type == 3 ? (int)below(2048) - 1024 : (int)below(128);
	int carrier = type == 3 ? (int)below(256) - 128 : (int)below(32) - 16;
	put_bits(&enc.blocks[4], type, 2);
	if (type != 0) {
		put_bits(&enc.blocks[4], (uint32_t)range, type == 3 ? 11 : 7);
		put_bits(&enc.blocks[4], (uint32_t)carrier, type == 3 ? 8 : 5);
	}
	enc.expected[n].multipath_cm = type == 0 ? 0 : type == 2 ? -range : range;
	enc.expected[n].carrier_512th = type == 0 ? 0 : carrier;
}

static void encode_satellite(unsigned system, unsigned number, satellite *t)
{
	unsigned master = (unsigned)__builtin_ctz(t->signals), mask = 0;
	int rate = enc.has_rate ? (int)nearbyint(t->rate_mps * 1000 / 64) : 0;
	for (unsigned i = 0; i < SIGNALS; i++)
		if (t->signals >> i & 1)
			mask |= 1u << moved(system, i);
	if (!master_delta(system, t, master)) {
		if (!master_short(system, t, master, mask))
			master_long(system, t, master, mask);
		if (enc.has_rate)
			put_bits(&enc.blocks[0], (uint32_t)rate, 16);
	}
	extend(system, number, t, master, 1, enc.elapsed_ms == 0 ? rate : t->old_rate);
	for (unsigned i = master + 1; i < SIGNALS; i++) {
		if (!(t->signals >> i & 1))
			continue;
		if (!slave_delta(system, t, i, master) && !slave_short(system, t, i, master))
			slave_long(system, t, i, master);
		extend(system, number, t, i, 0, 0);
	}
	/* The one thing that changes in a reference: deltas go by the longest lock time that was told since. */
	for (unsigned i = 0; i < SIGNALS; i++)
		if (t->signals & t->old_signals & 1u << i && t->old[i].lock != 0 &&
		    lock_ms[t->now[i].lock] > lock_ms[t->old[i].lock])
			t->old[i].lock = t->now[i].lock;
	if (enc.elapsed_ms == 0) {
		memcpy(t->old, t->sent, sizeof t->old);
		t->old_signals = t->signals;
		t->old_rate = rate;
	}
}

static void encode_layout(unsigned system, uint64_t mask)
{
	writer *w = &enc.blocks[0];
	if (enc.elapsed_ms != 0 && mask == enc.old_mask[system]) {
		put_bits(w, 0, 8);
		return;
	}
	unsigned length = mask >> 48 ? 8 : mask >> 32 ? 6 : 4;
	put_bits(w, length == 8 ? 7 : length, 3);
	put_bits(w, 0, 4); /* short masters have index 0 */
	put_bits(w, enc.excluded[system] != 0, 1);
	for (unsigned i = 0; i < length; i++)
		put_bits(w, (uint32_t)(mask >> 8 * i) & 255, 8);
	unsigned n = 0, far = 0;
	for (unsigned i = 0; i < SATELLITES; i++) {
		if (!(mask >> i & 1))
			continue;
		if (system == 1)
			put_bits(w, (uint32_t)(enc.sky[system][i].channel + 8), 4);
		far |= enc.sky[system][i].far ? 1u << n : 0;
		n++;
	}
	if (system == 1 && n % 2)
		put_bits(w, 0, 4);
	if (system == 3)
		put_bits(w, far, 16);
	if (enc.excluded[system] != 0)
		put_bits(w, enc.excluded[system], 8);
}

static void encode_epoch(uint32_t tow_ms, unsigned antenna)
{
	static const uint32_t intervals[] = {1, 500, 1000, 2000};
	unsigned interval = 0;
	while (intervals[interval] != enc.interval_ms)
		interval++;
	memset(enc.blocks, 0, sizeof enc.blocks);
	enc.n_expected = 0;
	enc.elapsed_ms = tow_ms % enc.interval_ms;
	uint64_t masks[SYSTEMS] = {0};
	unsigned systems = 0;
	for (unsigned s = 0; s < SYSTEMS; s++) {
		unsigned n = 0;
		for (unsigned i = 0; i < SATELLITES; i++) {
			satellite *t = &enc.sky[s][i];
			if (enc.elapsed_ms == 0)
				t->old_signals = 0, t->old_rate = 0;
			if (t->signals == 0)
				continue;
			masks[s] |= (uint64_t)1 << i;
			t->far = n++ < 16 && t->is_geo;
		}
		systems |= masks[s] != 0 ? 1u << s : 0;
	}
	for (unsigned kind = 0; kind < 5; kind++) {
		writer *w = &enc.blocks[kind];
		put_bits(w, 0x4024, 16);
		put_bits(w, 0, 16); /* the CRC is the framer's business */
		put_bits(w, RANGES + kind, 16);
		put_bits(w, 0, 16);
		put_bits(w, tow_ms, 32);
		put_bits(w, 2300, 16);
		if (kind > 0)
			put_bits(w, antenna, 16);
	}
	put_bits(&enc.blocks[0], 2, 16); /* smoothed, no clock jumps */
	put_bits(&enc.blocks[0], systems, 16);
	put_bits(&enc.blocks[0], antenna | (enc.has_rate ? 8u : 0) | interval << 4, 8);
	put_bits(&enc.blocks[0], 1, 8);
	for (unsigned s = 0; s < SYSTEMS; s++) {
		if (masks[s] == 0)
			continue;
		encode_layout(s, masks[s]);
		for (unsigned i = 0; i < SATELLITES; i++)
			if (masks[s] >> i & 1)
				encode_satellite(s, rinex[s].first + i, &enc.sky[s][i]);
		if (enc.elapsed_ms == 0)
			enc.old_mask[s] = masks[s];
	}
	for (unsigned kind = 0; kind < 5; kind++) {
		writer *w = &enc.blocks[kind];
		while (w->n % 4 != 0) {
			w->n_bits = 0;
			put_bits(w, 0, 8);
		}
		if (kind == 3 && w->n / 4 < 255) { /* Meas3PP: a second part, and where it begins */
			w->bytes[15] = (uint8_t)((w->n - 16) / 4);
			put_bits(w, 0xffffffff, 32);
		}
		fw_store_u16(w->bytes + 6, (uint16_t)w->n);
	}
}

/* ---- a sky ---- */

static void new_carrier(unsigned system, satellite *t, unsigned i)
{
	/* Like the ionosphere, so that the slaves' carriers follow from the master's, but for a few cycles. */
	double wave = wave_of(system, t, i), advance_m = 250 / (wave * wave);
	t->now[i].carrier_cyc = (t->now[i].range_m + advance_m) * wave + between(-20, 20);
	t->now[i].lock = (int)below(below(3) == 0 ? 16 : 8);
}

static void new_satellite(unsigned system, unsigned number, satellite *t)
{
	t->signals = 0; /* what was known of it at the reference epoch stays */
	t->is_geo = system == 3 && number >= 59;
	memset(t->now, 0, sizeof t->now);
	t->channel = system == 1 ? (int)(number * 5 % 14) - 7 : 0;
	double low = rinex[system].short_base_m;
	if (t->is_geo)
		low = 34e6;
	double range = below(10) == 0 ? between(0.1e6, 60e6) : between(low, low + 8.5e6);
	t->rate_mps = below(10) == 0 ? between(-2000, 2000) : between(-800, 800);
	for (unsigned i = 0; i < SIGNALS; i++) {
		if (rinex[system].signals[i].name == NULL || enc.excluded[system] >> i & 1 || below(3) == 0)
			continue;
		t->signals |= 1u << i;
		t->now[i].range_m = range + (below(10) == 0 ? between(-100, 100) : between(-5, 5));
		t->now[i].cn0_dbhz = 11 + (int)below(40);
		t->now[i].has_carrier = below(20) != 0;
		new_carrier(system, t, i);
	}
}

static void move_satellite(unsigned system, satellite *t, double dt)
{
	double jump = below(15) == 0 ? between(-40, 40) : 0; /* what only a long delta can say */
	for (unsigned i = 0; i < SIGNALS; i++) {
		if (!(t->signals >> i & 1))
			continue;
		double moved_m = t->rate_mps * dt + jump;
		t->now[i].range_m += moved_m + between(-0.3, 0.3);
		t->now[i].carrier_cyc += moved_m * wave_of(system, t, i) + between(-0.01, 0.01);
		t->now[i].cn0_dbhz += below(3) == 0 ? (int)below(5) - 2 : 0;
		t->now[i].cn0_dbhz = t->now[i].cn0_dbhz < 11   ? 11
		                     : t->now[i].cn0_dbhz > 54 ? 54
		                                               : t->now[i].cn0_dbhz;
		if (below(40) == 0) {
			t->now[i].has_carrier = below(4) != 0;
			new_carrier(system, t, i);
		}
	}
}

static void move_sky(double dt)
{
	for (unsigned s = 0; s < SYSTEMS; s++) {
		unsigned in_view = 0;
		for (unsigned i = 0; rinex[s].first + i <= rinex[s].last; i++) {
			satellite *t = &enc.sky[s][i];
			if (t->signals != 0 && below(60) == 0)
				t->signals = 0;
			else if (t->signals != 0)
				move_satellite(s, t, dt);
			else if (below(80) == 0 && in_view < 12)
				new_satellite(s, rinex[s].first + i, t);
			in_view += t->signals != 0;
		}
	}
}

static void new_sky(uint64_t seed)
{
	memset(&enc, 0, sizeof enc);
	fw_random_init(&enc.random, seed);
	enc.interval_ms = seed % 4 == 0 ? 1 : seed % 4 == 1 ? 500 : seed % 4 == 2 ? 1000 : 2000;
	enc.has_rate = seed % 3 != 0;
	for (unsigned s = 0; s < SYSTEMS; s++) {
		enc.excluded[s] = below(2) == 0 ? (uint8_t)(below(256) & below(256)) : 0;
		for (unsigned i = 0; rinex[s].first + i <= rinex[s].last; i += 1 + below(8))
			new_satellite(s, rinex[s].first + i, &enc.sky[s][i]);
	}
}

/* ---- round trips ---- */

static void check_signal(unsigned n, unsigned antenna)
{
	const furrow_obs *o = &out.obs[n];
	const measured *m = &enc.expected[n].m;
	assert_string_equal(o->sat, enc.expected[n].sat);
	assert_string_equal(o->signal, enc.expected[n].signal);
	assert_int_equal(o->antenna, antenna);
	assert_int_equal(has(o->present, FW_COL_obs_glonass_channel), o->sat[0] == 'R');
	assert_int_equal(o->glonass_channel, o->sat[0] == 'R' ? enc.expected[n].channel : 0);
	assert_near(o->pseudorange_m, m->range_m, 0.000501);
	assert_int_equal(has(o->present, FW_COL_obs_carrier_cyc), m->has_carrier);
	if (m->has_carrier)
		assert_near(o->carrier_cyc, m->carrier_cyc, 0.000501);
	assert_near(o->cn0_dbhz, m->cn0_dbhz, 0);
	assert_int_equal(o->half_cycle, m->lock == 0);
	assert_int_equal(has(o->present, FW_COL_obs_lock_s), m->lock != 0);
	assert_int_equal(o->lock_s, lock_ms[m->lock] / 1000);
	assert_false(has(o->present, FW_COL_obs_smoothed));
	assert_int_equal(has(o->present, FW_COL_obs_doppler_hz), enc.expected[n].has_doppler);
	if (enc.expected[n].has_doppler)
		assert_near(o->doppler_hz, enc.expected[n].doppler_hz, 1e-8);

	const furrow_obs_extra *x = &out.extra[n];
	assert_string_equal(x->sat, o->sat);
	assert_string_equal(x->signal, o->signal);
	assert_int_equal(x->antenna, antenna);
	assert_near(x->cn0_highres_dbhz, enc.expected[n].cn0, 0);
	assert_int_equal(x->loss_count, enc.expected[n].loss);
	assert_int_equal(x->info, enc.expected[n].settling);
	assert_near(x->multipath_corr_m, enc.expected[n].multipath_cm / 100.0, 1e-12);
	assert_near(x->carrier_multipath_corr_cyc, enc.expected[n].carrier_512th / 512.0, 0);
}

static void put_epoch(void)
{
	for (unsigned kind = 0; kind < 5; kind++)
		assert_int_equal(
		    fw_sbf_meas3_put(&meas3, enc.blocks[kind].bytes, (uint16_t)enc.blocks[kind].n), FW_OK);
}

static void random_epochs_come_back(void **state)
{
	(void)state;
	unsigned kinds[7] = {0};
	for (uint64_t seed = 0; seed < 24; seed++) {
		unsigned antenna = (unsigned)(seed % 3);
		new_sky(seed);
		start(255);
		for (unsigned e = 0; e < 25; e++) {
			encode_epoch(302400000 + 100 * e, antenna);
			out.n_obs = out.n_extra = out.n_epochs = 0;
			put_epoch();
			fw_sbf_meas3_flush(&meas3);
			assert_int_equal(out.n_obs, enc.n_expected);
			assert_int_equal(out.n_extra, enc.n_expected);
			assert_int_equal(out.n_epochs, 1);
			assert_int_equal(out.epoch.n_signals, enc.n_expected);
			for (unsigned n = 0; n < enc.n_expected; n++)
				check_signal(n, antenna);
			move_sky(0.1);
		}
		assert_int_equal(meas3.stats.lost_signals + meas3.stats.lost_epochs + meas3.stats.malformed,
		                 0);
		for (int i = 0; i < 7; i++)
			kinds[i] += enc.kinds[i];
	}
	for (int i = 0; i < 7; i++)
		assert_true(kinds[i] > 1000); /* every kind of sub-block was there */
}

/* ---- losses ---- */

static void deltas_without_their_reference_are_lost(void **state)
{
	(void)state;
	start(255);
	assert_int_equal(put_hex(delta_hex), FW_OK);
	assert_int_equal(put_hex(doppler_hex), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(out.n_obs + out.n_extra + out.n_epochs, 0);
	assert_int_equal(meas3.stats.lost_epochs, 1);

	/* The reference of a week before, or of a second before, is not the one. */
	char older[sizeof reference_hex];
	memcpy(older, reference_hex, sizeof older);
	memcpy(older + 24, "fb08", 4);
	assert_int_equal(put_hex(older), FW_OK);
	assert_int_equal(put_hex(delta_hex), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(meas3.stats.lost_epochs, 2);
	memcpy(older, reference_hex, sizeof older);
	memcpy(older + 16, "d8230900", 8); /* 599000 */
	assert_int_equal(put_hex(older), FW_OK);
	assert_int_equal(put_hex(delta_hex), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(meas3.stats.lost_epochs, 3);
	assert_int_equal(out.n_obs, 6);

	/* Nor is that of another antenna. */
	memcpy(older, reference_hex, sizeof older);
	older[37] = '9';
	assert_int_equal(put_hex(older), FW_OK);
	assert_int_equal(put_hex(delta_hex), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(meas3.stats.lost_epochs, 4);
}

/* A satellite that only the delta epoch has, with a master delta: nothing can be said of it, the others stand. */
static void a_delta_of_an_unknown_satellite_is_lost_alone(void **state)
{
	(void)state;
	/* As the delta epoch of the vector, but with a mask of G05 and G06 and the same short delta for G06. */
	static const char two[] = "244000000d102400ec280900fc08290701002801"
	                          "0130"
	                          "7a00f67f2a608402a080"
	                          "7a00f67f";
	start(255);
	assert_int_equal(put_hex(reference_hex), FW_OK);
	assert_int_equal(put_hex(two), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(out.n_obs, 6);
	assert_near(out.obs[5].pseudorange_m, 20234573.816429, 1e-6);
	assert_int_equal(meas3.stats.lost_signals, 1);
	assert_int_equal(meas3.stats.lost_epochs, 0);
	assert_int_equal(out.epoch.n_signals, 3);
}

/* Slave deltas find their reference by counting; behind a master with other slaves they would find a wrong one. */
static void a_slave_delta_behind_other_slaves_is_lost(void **state)
{
	(void)state;
	/* G05 with a short master again, now of index 0 and slave 4 alone: a slave delta would mean slave 1 of then. */
	static const char other[] = "244000000d102800ec280900fc08290701002801"
	                            "0110"
	                            "1127148ad202964964" /* SigList 1000: slave 4 */
	                            "00"
	                            "02a080"
	                            "0000";
	start(255);
	assert_int_equal(put_hex(reference_hex), FW_OK);
	assert_int_equal(put_hex(other), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(out.n_obs, 4);
	assert_string_equal(out.obs[3].signal, "1C");
	assert_int_equal(meas3.stats.lost_signals, 1);
}

static void scrambled_ranges_make_no_records(void **state)
{
	(void)state;
	char scrambled[sizeof reference_hex];
	memcpy(scrambled, reference_hex, sizeof scrambled);
	scrambled[28] = 'a'; /* CommonFlags 0xa9 */
	start(255);
	assert_int_equal(put_hex(scrambled), FW_OK);
	assert_int_equal(put_hex(delta_hex), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(out.n_obs + out.n_epochs, 0);
	assert_int_equal(meas3.stats.scrambled, 1);
	assert_int_equal(meas3.stats.lost_epochs, 1);
}

static void blocks_that_do_not_belong_are_refused(void **state)
{
	(void)state;
	start(255);
	assert_int_equal(put_hex("24400000bb0f1400c0270900fc080000"), FW_EUNKNOWN); /* MeasEpoch */
	assert_int_equal(put_hex("244000000d10"), FW_EFORMAT);
	assert_int_equal(put_hex("244000000d101000c0270900fc082907"), FW_EFORMAT);
	assert_int_equal(put_hex("244000000d101400c0270900fc08290700002b01"), FW_EFORMAT); /* antenna 3 */
	assert_int_equal(put_hex("244000000d101400c0270900fc08290700002820"), FW_EFORMAT); /* version 32 */
	assert_int_equal(put_hex(reference_hex), FW_OK);
	assert_int_equal(put_hex(reference_hex), FW_EFORMAT);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(out.n_obs, 3);
	assert_int_equal(put_hex(doppler_hex), FW_OK);
	assert_int_equal(put_hex(mp_hex), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(out.n_obs, 3);
	assert_int_equal(out.n_epochs, 1);
	assert_int_equal(meas3.stats.orphans, 2);

	static uint8_t big[65532];
	fw_store_u16(big + 4, RANGES);
	fw_store_u16(big + 6, 65532);
	assert_int_equal(fw_sbf_meas3_put(&meas3, big, 65532), FW_OK);
	fw_store_u16(big + 4, DOPPLER);
	assert_int_equal(fw_sbf_meas3_put(&meas3, big, 65532), FW_ENOSPACE);
}

static void unwanted_antennas_are_counted(void **state)
{
	(void)state;
	start(2); /* aux1 only */
	assert_int_equal(put_hex(reference_hex), FW_OK);
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(out.n_obs, 0);
	assert_int_equal(meas3.stats.other_antenna, 3);
	assert_int_equal(out.epoch.n_signals, 3);
}

/* Every length of a block, each in memory of just that size, for the sanitizer to watch. A Meas3Ranges that is cut
 * inside its last sub-block makes no record; extensions say what they hold. */
static void truncated_blocks_are_harmless(void **state)
{
	(void)state;
	new_sky(2);
	start(255);
	encode_epoch(302400000, 0);
	put_epoch();
	fw_sbf_meas3_flush(&meas3);
	move_sky(0.1);
	encode_epoch(302400100, 0);
	unsigned whole = enc.n_expected;
	for (unsigned cut = 0; cut < 5; cut++) {
		for (size_t length = 20; length < enc.blocks[cut].n; length += cut == 0 ? 1 : 13) {
			uint8_t *exact = malloc(length);
			assert_non_null(exact);
			memcpy(exact, enc.blocks[cut].bytes, length);
			out.n_obs = out.n_extra = out.n_epochs = 0;
			for (unsigned kind = 0; kind < 5; kind++) {
				const writer *w = &enc.blocks[kind];
				assert_int_equal(fw_sbf_meas3_put(&meas3, kind == cut ? exact : w->bytes,
				                                  (uint16_t)(kind == cut ? length : w->n)),
				                 FW_OK);
			}
			fw_sbf_meas3_flush(&meas3);
			free(exact);
			if (cut == 0 && length + 3 < enc.blocks[cut].n)
				assert_int_equal(out.n_obs, 0);
			if (cut != 0)
				assert_int_equal(out.n_obs, whole);
		}
	}
	assert_true(meas3.stats.malformed > 100);
}

static void random_bytes_are_harmless(void **state)
{
	(void)state;
	new_sky(3);
	start(255);
	for (unsigned e = 0; e < 60; e++) {
		encode_epoch(302400000 + 100 * e, 0);
		for (unsigned kind = 0; kind < 5; kind++) {
			writer *w = &enc.blocks[kind];
			for (unsigned i = 0; i < 4; i++)
				w->bytes[16 + below((unsigned)w->n - 16)] = (uint8_t)below(256);
			(void)!fw_sbf_meas3_put(&meas3, w->bytes, (uint16_t)w->n);
		}
		fw_sbf_meas3_flush(&meas3);
		for (unsigned n = 0; n < out.n_obs; n++) {
			const furrow_obs *o = &out.obs[n];
			assert_true(isfinite(o->pseudorange_m) && isfinite(o->carrier_cyc) &&
			            isfinite(o->doppler_hz));
		}
		out.n_obs = out.n_extra = 0;
		move_sky(0.1);
	}
}

/* ---- real blocks ---- */

static void put_real(const uint8_t *block, size_t length, void *context)
{
	unsigned *n = context;
	fw_status status = fw_sbf_meas3_put(&meas3, block, (uint16_t)length);
	unsigned number = fw_load_u16(block + 4) & 0x1fff;
	if (number >= RANGES && number <= MP) {
		assert_int_equal(status, FW_OK);
		++*n;
	}
}

/* The receiver of that log had two antennas and no satellite: its ten blocks make one epoch without signals. */
static void real_blocks_are_understood(void **state)
{
	(void)state;
	unsigned n = 0;
	start(255);
	if (sbf_each_real_block(put_real, &n) == 0) {
		print_message("no real logs: skipped\n");
		skip();
	}
	fw_sbf_meas3_flush(&meas3);
	assert_int_equal(n, 10);
	assert_int_equal(out.n_obs + out.n_extra, 0);
	assert_int_equal(out.n_epochs, 1);
	assert_int_equal(out.epoch.gps_week, 2367);
	assert_near(out.epoch.tow_s, 395280, 0);
	assert_int_equal(out.epoch.n_signals, 0);
	assert_int_equal(out.epoch.multipath_mitigation, 1);
	assert_int_equal(out.epoch.clock_jumps_ms, 17);
	assert_int_equal(meas3.stats.malformed + meas3.stats.lost_epochs + meas3.stats.orphans, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(a_vector_computed_by_hand),
	    cmocka_unit_test(random_epochs_come_back),
	    cmocka_unit_test(deltas_without_their_reference_are_lost),
	    cmocka_unit_test(a_delta_of_an_unknown_satellite_is_lost_alone),
	    cmocka_unit_test(a_slave_delta_behind_other_slaves_is_lost),
	    cmocka_unit_test(scrambled_ranges_make_no_records),
	    cmocka_unit_test(blocks_that_do_not_belong_are_refused),
	    cmocka_unit_test(unwanted_antennas_are_counted),
	    cmocka_unit_test(truncated_blocks_are_harmless),
	    cmocka_unit_test(random_bytes_are_harmless),
	    cmocka_unit_test(real_blocks_are_understood),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
