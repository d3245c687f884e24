/* MeasEpoch and MeasExtra: expected values are those of a public mosaic-X5 log decoded by hand from the guide's
 * formulas; the encoder is tested by what it gives back. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "formats/bytes.h"
#include "formats/crc.h"
#include "formats/sbf_codec.h"
#include "formats/sbf_measurements.h"
#include "formats/sbf_signal.h"
#include "furrow_obs_columns.h"
#include "furrow_obs_extra.h"
#include "furrow_obs_extra_columns.h"

enum { MAX_OBS = 5000 };

static furrow_obs obs[MAX_OBS];
static furrow_obs_extra extras[64];
static furrow_epoch epochs[4];
static unsigned n_obs, n_extras, n_epochs;

static void collect(void *context, fw_kind kind, const void *record)
{
	(void)context;
	if (kind == FW_obs && n_obs < MAX_OBS)
		obs[n_obs++] = *(const furrow_obs *)record;
	else if (kind == FW_obs_extra && n_extras < 64)
		extras[n_extras++] = *(const furrow_obs_extra *)record;
	else if (kind == FW_epoch && n_epochs < 4)
		epochs[n_epochs++] = *(const furrow_epoch *)record;
}

static const fw_sink sink = {collect, NULL};

/* Returns the number of observations left out because of their antenna. */
static unsigned decode(const uint8_t *block, uint16_t length, unsigned antennas, fw_sbf_channels *channels)
{
	fw_sbf_left_out left_out = {0};
	fw_kind_set wanted = {{0}};
	fw_kind_add(&wanted, FW_obs);
	fw_kind_add(&wanted, FW_epoch);
	n_obs = n_epochs = 0;
	fw_sbf_meas_epoch(block, length, antennas, &wanted, sink, channels, &left_out);
	return (unsigned)left_out.other_antenna;
}

static size_t from_hex(const char *hex, uint8_t *out)
{
	size_t n = 0;
	for (; hex[0] != '\0'; hex += 2) {
		const char pair[] = {hex[0], hex[1], '\0'};
		char *end;
		out[n++] = (uint8_t)strtoul(pair, &end, 16);
		assert_ptr_equal(end, pair + 2);
	}
	return n;
}

static int near(double a, double b, double tolerance)
{
	return fabs(a - b) <= tolerance;
}

/* Sub-blocks of a real epoch: G17 on three signals, E27 on two. */
static void test_known_epoch(void **state)
{
	(void)state;
	static const char hex[] = "2440e5bcbb2f540068a2bf1c3f0902140c050c00"
	                          "010011053ab0343a4af33c01f707009001020002"
	                          "02feb10700004df87f150400"
	                          "03fe80ff0000c7f7ac17bffc"
	                          "031461062ab86a880bbbb30072f0ff77c1010002"
	                          "11fe6c07000081ead815c004"
	                          /* a second Type2 of a signal number that is reserved: passed over */
	                          "12fe6c07000081ead815c004";
	static const struct {
		const char *sat, *signal;
		double range_m, carrier_cyc, doppler_hz, cn0_dbhz;
		int lock_s;
	} expected[] = {
	    {"G17", "1C", 22451367.994, 117982737.165, 2077.1658, 46.00, 513},
	    {"G17", "2W", 22451366.023, 91934596.232, 1618.5712, 44.25, 254},
	    {"G17", "2L", 22451365.889, 91934596.240, 1618.4875, 42.00, 254},
	    {"E27", "5Q", 28058499.114, 110107573.450, 1177.8827, 39.75, 449},
	    {"E27", "1C", 28058493.611, 147448384.712, 1577.4602, 37.00, 254},
	};
	uint8_t block[256];
	fw_sbf_channels channels;
	size_t length = from_hex(hex, block);

	assert_int_equal(decode(block, (uint16_t)length, FW_ANTENNA_ALL, &channels), 0);
	assert_int_equal(n_obs, 5);
	for (unsigned i = 0; i < 5; i++) {
		assert_string_equal(obs[i].sat, expected[i].sat);
		assert_string_equal(obs[i].signal, expected[i].signal);
		assert_true(near(obs[i].pseudorange_m, expected[i].range_m, 1e-9));
		assert_true(near(obs[i].carrier_cyc, expected[i].carrier_cyc, 0.0005));
		assert_true(near(obs[i].doppler_hz, expected[i].doppler_hz, 0.00005));
		assert_true(near(obs[i].cn0_dbhz, expected[i].cn0_dbhz, 0));
		assert_int_equal(obs[i].lock_s, expected[i].lock_s);
		assert_int_equal(obs[i].gps_week, 2367);
		assert_true(near(obs[i].tow_s, 482321.0, 0));
		assert_int_equal(obs[i].present >> FW_COL_obs_glonass_channel & 1, 0);
	}
	assert_int_equal(n_epochs, 1);
	assert_int_equal(epochs[0].n_signals, 5);
	assert_int_equal(epochs[0].clock_jumps_ms, 12);
	assert_int_equal(epochs[0].multipath_mitigation, 1);
	assert_int_equal(epochs[0].smoothed, 0);
	assert_string_equal(channels.satellite[1], "G17");
	assert_string_equal(channels.satellite[3], "E27");
}

/* A block cut at every length gives a prefix of the observations and touches nothing behind it. */
static void test_cut(void **state)
{
	(void)state;
	static const char hex[] = "2440e5bcbb2f400068a2bf1c3f0902140c050c00"
	                          "010011053ab0343a4af33c01f707009001020002"
	                          "02feb10700004df87f15040003fe80ff0000c7f7ac17bffc";
	uint8_t block[256];
	fw_sbf_channels channels;
	size_t length = from_hex(hex, block);
	for (size_t cut = 0; cut <= length; cut++) {
		(void)decode(block, (uint16_t)cut, FW_ANTENNA_ALL, &channels);
		unsigned whole = cut >= 64 ? 3 : cut >= 52 ? 2 : cut >= 40 ? 1 : 0;
		assert_int_equal(n_obs, whole);
	}
}

/* Do-not-use values, one field at a time. */
static void test_absent(void **state)
{
	(void)state;
	uint8_t block[64];
	fw_sbf_channels channels;
	size_t length = from_hex("2440e5bcbb2f3400ffffffffffff01140c000c00"
	                         "01001100000000000000008000000080ffff0002"
	                         "00ffff840000800000000000",
	                         block);
	block[20 + 15] = 0xFF; /* C/N0 */
	block[20 + 19] = 1;
	/* carrier of Type1: MSB -128, LSB 0; Type2: everything do-not-use */
	(void)decode(block, (uint16_t)length, FW_ANTENNA_ALL, &channels);
	assert_int_equal(n_obs, 2);
	const int64_t values = INT64_C(1) << FW_COL_obs_pseudorange_m | INT64_C(1) << FW_COL_obs_carrier_cyc |
	                       INT64_C(1) << FW_COL_obs_doppler_hz | INT64_C(1) << FW_COL_obs_cn0_dbhz |
	                       INT64_C(1) << FW_COL_obs_lock_s | INT64_C(1) << FW_COL_obs_gps_week |
	                       INT64_C(1) << FW_COL_obs_tow_s;
	assert_int_equal(obs[0].present & values, 0);
	assert_int_equal(obs[1].present & values, 0);
}

/* The offsets of Type2 are signed: -0.131 m and -4 m. */
static void test_signed_offsets(void **state)
{
	(void)state;
	uint8_t block[64];
	fw_sbf_channels channels;
	(void)from_hex("2440e5bcbb2f340068a2bf1c3f0901140c000c00"
	               "0100110500000000000000000000000101000001"
	               "02feb1ff00007dff00000000",
	               block);
	(void)decode(block, 52, FW_ANTENNA_ALL, &channels);
	assert_int_equal(n_obs, 2);
	/* MSB -1, LSB 0xFF7D: 0xFFFFFF7D = -131 mm */
	assert_true(near(obs[1].pseudorange_m - obs[0].pseudorange_m, -0.131, 1e-8));
	/* Doppler: MSB -1, LSB 0: -65536 * 0.0001 Hz from a Doppler of 0 */
	assert_true(near(obs[1].doppler_hz, -6.5536, 1e-12));
}

static void test_antennas(void **state)
{
	(void)state;
	uint8_t block[64];
	fw_sbf_channels channels;
	(void)from_hex("2440e5bcbb2f340068a2bf1c3f0901140c000c00"
	               "0100110500000000000000000000000101000001"
	               "22feb1ff00007dff00000000", /* the second signal on aux1 */
	               block);
	assert_int_equal(decode(block, 52, FW_ANTENNA_MAIN, &channels), 1);
	assert_int_equal(n_obs, 1);
	assert_int_equal(decode(block, 52, FW_ANTENNA_AUX1, &channels), 1);
	assert_int_equal(n_obs, 1);
	assert_int_equal(obs[0].antenna, 1);
}

/* MeasExtra takes the satellite from the MeasEpoch of the same time tag only. */
static void test_extra(void **state)
{
	(void)state;
	uint8_t block[64];
	fw_sbf_channels channels = {.tow_ms = 482321000, .week = 2367};
	channels.satellite[7] = "G17";
	memset(block, 0, sizeof block);
	fw_store_u16(block + 4, 4000 | 3 << 13);
	fw_store_u32(block + 8, 482321000);
	fw_store_u16(block + 12, 2367);
	block[14] = 1;
	block[15] = 16;
	fw_store_u32(block + 16, 0x40000000); /* 2.0f */
	uint8_t *p = block + 20;
	p[0] = 7;
	p[1] = 3; /* L2C, main antenna */
	fw_store_u16(p + 2, (uint16_t)-250);
	fw_store_u16(p + 4, 0);
	fw_store_u16(p + 6, 1234);
	fw_store_u16(p + 8, 500);
	fw_store_u16(p + 10, 65535);
	p[12] = 9;
	p[13] = (uint8_t)-64;
	p[15] = 3;
	n_extras = 0;
	fw_sbf_meas_extra(block, 36, FW_ANTENNA_MAIN, &channels, sink);
	assert_int_equal(n_extras, 1);
	assert_string_equal(extras[0].sat, "G17");
	assert_string_equal(extras[0].signal, "2L");
	assert_true(near(extras[0].multipath_corr_m, -0.25, 0));
	assert_true(near(extras[0].code_var_m2, 0.1234, 0));
	assert_true(near(extras[0].carrier_var_cyc2, 0.0005, 0));
	assert_true(near(extras[0].doppler_var_hz2, 0.001, 0));
	assert_int_equal(extras[0].present >> FW_COL_obs_extra_lock_s & 1, 0);
	assert_int_equal(extras[0].loss_count, 9);
	assert_true(near(extras[0].carrier_multipath_corr_cyc, -0.125, 0));
	assert_true(near(extras[0].cn0_highres_dbhz, 0.09375, 0));

	/* Revision 1 had padding where revision 3 has the C/N0. */
	fw_store_u16(block + 4, 4000 | 1 << 13);
	n_extras = 0;
	fw_sbf_meas_extra(block, 36, FW_ANTENNA_MAIN, &channels, sink);
	assert_int_equal(extras[0].present >> FW_COL_obs_extra_loss_count & 1, 1);
	assert_int_equal(extras[0].present >> FW_COL_obs_extra_info & 1, 0);
	assert_int_equal(extras[0].present >> FW_COL_obs_extra_cn0_highres_dbhz & 1, 0);

	channels.tow_ms++;
	n_extras = 0;
	fw_sbf_meas_extra(block, 36, FW_ANTENNA_MAIN, &channels, sink);
	assert_int_equal(extras[0].present >> FW_COL_obs_extra_sat & 1, 0);
}

static double uniform(fw_random *r, double low, double high)
{
	return low + (high - low) * fw_random_uniform(r);
}

/* A random epoch on the wire's own grid, signals of a satellite together. Returns the number of observations. */
static unsigned random_epoch(fw_random *r, furrow_epoch *e, furrow_obs *o)
{
	unsigned n = 0;
	memset(e, 0, sizeof *e);
	e->present = 3;
	e->gps_week = (int32_t)uniform(r, 0, 8191);
	e->tow_s = floor(uniform(r, 0, 604800000)) / 1000;
	for (uint8_t channel = 1; channel < 20; channel++) {
		uint8_t svid = (uint8_t)uniform(r, 1, 246);
		const char *sat = fw_sbf_satellite(svid);
		double range_m = floor(uniform(r, 18e9, 42e9)) / 1000, doppler_hz = uniform(r, -5000, 5000);
		for (unsigned number = 0; sat != NULL && number < 40; number++) {
			const fw_sbf_signal *s = fw_sbf_signal_of(number);
			if (s == NULL || s->system != sat[0] || fw_random_uniform(r) < 0.3)
				continue;
			furrow_obs *x = &o[n++];
			memset(x, 0, sizeof *x);
			x->present = (INT64_C(1) << FW_COL_obs_COUNT) - 1;
			x->sat = (char *)(uintptr_t)sat;
			x->signal = (char *)(uintptr_t)s->rinex;
			x->rx_channel = channel;
			if (s->channel_spacing_hz > 0)
				x->glonass_channel = (int8_t)(channel % 14 - 7);
			double f = s->frequency_hz + x->glonass_channel * s->channel_spacing_hz;
			x->pseudorange_m = nearbyint((range_m + uniform(r, -100, 100)) * 1000) / 1000;
			x->carrier_cyc =
			    x->pseudorange_m / (299792458.0 / f) + nearbyint(uniform(r, -8e6, 8e6)) * 0.001;
			x->doppler_hz = nearbyint(doppler_hz * f / 1575.42e6 * 1e4) / 1e4;
			x->cn0_dbhz = nearbyint(uniform(r, 40, 200)) * 0.25;
			if (number != 1 && number != 2)
				x->cn0_dbhz += 10;
			x->lock_s = (int32_t)uniform(r, 0, 254);
			x->half_cycle = fw_random_uniform(r) < 0.5;
			x->smoothed = fw_random_uniform(r) < 0.5;
		}
	}
	return n;
}

static void test_encode_random(void **state)
{
	(void)state;
	static uint8_t block[FW_SBF_MAX_LENGTH], again[FW_SBF_MAX_LENGTH];
	static furrow_obs made[MAX_OBS];
	fw_sbf_channels channels;
	furrow_epoch e;
	fw_random r;
	uint16_t length, length_again;

	fw_random_init(&r, 20250401);
	for (int run = 0; run < 2000; run++) {
		unsigned n = random_epoch(&r, &e, made);
		assert_int_equal(fw_sbf_encode_meas_epoch(&e, made, n, block, &length), FW_OK);
		assert_int_equal(length % 4, 0);
		assert_int_equal(fw_crc16(block + 4, length - 4U), fw_load_u16(block + 2));
		assert_int_equal(decode(block, length, FW_ANTENNA_ALL, &channels), 0);
		assert_int_equal(n_obs, n);
		for (unsigned i = 0; i < n; i++) {
			assert_string_equal(obs[i].sat, made[i].sat);
			assert_string_equal(obs[i].signal, made[i].signal);
			assert_true(near(obs[i].pseudorange_m, made[i].pseudorange_m, 0));
			assert_true(near(obs[i].carrier_cyc, made[i].carrier_cyc, 0.000501));
			assert_true(near(obs[i].doppler_hz, made[i].doppler_hz, 0.0000501));
			assert_true(near(obs[i].cn0_dbhz, made[i].cn0_dbhz, 0));
			assert_int_equal(obs[i].lock_s, made[i].lock_s);
			assert_int_equal(obs[i].half_cycle, made[i].half_cycle);
			assert_int_equal(obs[i].smoothed, made[i].smoothed);
			if (made[i].sat[0] == 'R' && made[i].signal[0] != '3')
				assert_int_equal(obs[i].glonass_channel, made[i].glonass_channel);
		}
		assert_int_equal(fw_sbf_encode_meas_epoch(&epochs[0], obs, n_obs, again, &length_again),
		                 FW_OK);
		assert_int_equal(length_again, length);
		assert_memory_equal(again + 20, block + 20, length - 20U);
	}
}

static void test_encode_refuses(void **state)
{
	(void)state;
	uint8_t block[256];
	uint16_t length = 7;
	furrow_epoch e = {.present = 3};
	furrow_obs o = {.present = INT64_C(1) << FW_COL_obs_pseudorange_m,
	                .sat = (char[]){"G05"},
	                .signal = (char[]){"1C"}};

	o.pseudorange_m = 7e7;
	assert_int_equal(fw_sbf_encode_meas_epoch(&e, &o, 1, block, &length), FW_ERANGE);
	o.pseudorange_m = NAN;
	assert_int_equal(fw_sbf_encode_meas_epoch(&e, &o, 1, block, &length), FW_ERANGE);
	o.pseudorange_m = 2e7;
	o.signal = (char[]){"9X"};
	assert_int_equal(fw_sbf_encode_meas_epoch(&e, &o, 1, block, &length), FW_EUNKNOWN);
	o.signal = (char[]){"1C"};
	o.sat = (char[]){"G99"};
	assert_int_equal(fw_sbf_encode_meas_epoch(&e, &o, 1, block, &length), FW_EUNKNOWN);
	assert_int_equal(length, 7);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_known_epoch),   cmocka_unit_test(test_cut),
	    cmocka_unit_test(test_absent),        cmocka_unit_test(test_signed_offsets),
	    cmocka_unit_test(test_antennas),      cmocka_unit_test(test_extra),
	    cmocka_unit_test(test_encode_random), cmocka_unit_test(test_encode_refuses),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
