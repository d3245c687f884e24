/* What the simulator logs is what it simulates: ephemerides through records, SBF blocks and back, and what a receiver
 * measured and found as records. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "cli/ephemerides.h"
#include "cli/sim_records.h"
#include "formats/sbf_build.h"
#include "furrow_obs_columns.h"
#include "furrow_pvt_columns.h"
#include "sim/constellation.h"

enum { ROOM = 2048 };

static fw_ephemeris list[ROOM], back;
static fw_sbf_plans plans;
static uint8_t block[FW_SBF_MAX_LENGTH];

static fw_time start(void)
{
	fw_time t = {0};
	assert_int_equal(fw_time_parse("2026-06-10T08:00:00", &t), FW_OK);
	return t;
}

static void take(void *context, fw_kind kind, const void *record)
{
	*(fw_status *)context = ephemeris_of_record(kind, record, &back);
}

static uint16_t block_of(fw_kind kind)
{
	return kind == FW_eph_gps ? 5891 : kind == FW_eph_gal ? 4002 : kind == FW_eph_bds ? 4081 : 4004;
}

/* Every ephemeris of every system comes back from its block with the same orbit, clock, delays and issue. */
static void test_ephemerides(void **state)
{
	(void)state;
	unsigned n = 0;
	assert_int_equal(fw_constellation(start(), start(), 15, ROOM, list, &n), FW_OK);
	fw_sbf_plans_init(&plans);
	for (unsigned i = 0; i < n; i++) {
		const fw_ephemeris *e = &list[i];
		fw_any_record record;
		fw_kind_set wanted = {0};
		char name[5];
		uint16_t length;
		fw_status status = FW_EUNKNOWN;
		fw_satellite_state a, b;
		fw_kind kind = ephemeris_record(e, e->toe, &record, name);
		const void *records[] = {&record};
		assert_int_equal(fw_sbf_build(&plans, block_of(kind), 0, records, 1, block, &length), FW_OK);
		fw_kind_add(&wanted, kind);
		assert_int_equal(fw_sbf_emit(&plans, block, length, &wanted, (fw_sink){take, &status}),
		                 FW_OK);
		assert_int_equal(status, FW_OK);
		assert_true(fw_satellite_equal(e->satellite, back.satellite));
		assert_true(e->toe.ns == back.toe.ns && e->toc.ns == back.toc.ns);
		assert_int_equal(e->message, back.message);
		assert_true(back.healthy);
		fw_time later = fw_time_add_ns(e->toe, 600 * FW_NS_PER_S);
		assert_int_equal(fw_ephemeris_state(e, later, &a), FW_OK);
		assert_int_equal(fw_ephemeris_state(&back, later, &b), FW_OK);
		for (int k = 0; k < 3; k++)
			assert_true(fabs(a.position_m[k] - b.position_m[k]) < 1e-6);
		assert_true(fabs(a.clock_s - b.clock_s) < 1e-16);
		assert_true(fabs(e->tgd_s[0] - back.tgd_s[0]) < 1e-15 &&
		            fabs(e->tgd_s[1] - back.tgd_s[1]) < 1e-15);
		assert_true(back.accuracy_m > 0);
	}
}

static void test_no_record(void **state)
{
	(void)state;
	fw_any_record record;
	char name[5];
	const fw_ephemeris sbas = {.satellite = {FW_SBAS, 23}};
	assert_int_equal(ephemeris_record(&sbas, start(), &record, name), FW_RECORD_COUNT);
}

static void test_observation(void **state)
{
	(void)state;
	furrow_obs r;
	char satellite[5], signal[3];
	fw_observation o = {.satellite = {FW_GLONASS, 7},
	                    .signal = {'1', 'C'},
	                    .glonass_channel = -4,
	                    .code_m = 2.1e7,
	                    .carrier_cyc = 1.1e8,
	                    .doppler_hz = -1234.5,
	                    .cn0_dbhz = 47,
	                    .lock_s = 12.9,
	                    .half_cycle = true};
	observation_record(&o, start(), 1, 9, &r, satellite, signal);
	assert_string_equal(r.sat, "R07");
	assert_string_equal(r.signal, "1C");
	assert_true(r.pseudorange_m == 2.1e7 && r.carrier_cyc == 1.1e8 && r.doppler_hz == -1234.5 &&
	            r.cn0_dbhz == 47);
	assert_int_equal(r.lock_s, 12);
	assert_int_equal(r.antenna, 1);
	assert_int_equal(r.rx_channel, 9);
	assert_int_equal(r.glonass_channel, -4);
	assert_int_equal(r.half_cycle, 1);
	assert_int_equal(r.gps_week, 2422);
	assert_true(r.tow_s == 288000 && (r.present >> FW_COL_obs_glonass_channel & 1) == 1);
	o.satellite.system = FW_GPS;
	observation_record(&o, start(), 0, 1, &r, satellite, signal);
	assert_int_equal(r.present >> FW_COL_obs_glonass_channel & 1, 0);
}

/* Degrees, standard deviations and signs of a solution; 6378137 m and 45 degrees are easy to check by hand. */
static void test_solution(void **state)
{
	(void)state;
	furrow_pvt pvt;
	furrow_dop dop;
	furrow_att att;
	fw_receiver_solution s = {
	    .n_used = 11,
	    .llh = {0.7853981633974483, -0.5235987755982988, 100},
	    .velocity_ned_mps = {0, -3, 1},
	    .clock_m = 299.792458,
	    .covariance_m2 = {{4, 0.5, 0, 0}, {0.5, 9, 0, 0}, {0, 0, 16, 0}, {0, 0, 0, 25}},
	    .hdop = 0.7,
	    .hpl_m = 12};
	pvt_record(&s, start(), true, 5, &pvt);
	assert_true(fabs(pvt.lat_deg - 45) < 1e-12 && fabs(pvt.lon_deg + 30) < 1e-12 && pvt.height_m == 100);
	assert_true(pvt.sd_n_m == 2 && pvt.sd_e_m == 3 && pvt.sd_d_m == 4);
	assert_true(fabsf(pvt.cov_ne_m2 - 0.5f) < 1e-7f && fabsf(pvt.course_deg - 270) < 1e-4f);
	assert_true(fabs(pvt.clock_bias_s - 1e-6) < 1e-18);
	assert_int_equal(pvt.mode, 6);
	assert_int_equal(pvt.n_sats, 11);
	assert_int_equal(pvt.signals, 5);
	dop_record(&s, start(), &dop);
	assert_true(dop.hdop == 0.7 && fabsf(dop.hpl_m - 12) < 1e-6f);
	pvt_record(NULL, start(), true, 0, &pvt);
	assert_int_equal(pvt.mode, 0);
	assert_int_equal(pvt.error, 1);
	assert_int_equal(pvt.present >> FW_COL_pvt_lat_deg & 1, 0);
	const fw_receiver_attitude a = {3.141592653589793, 0.05, 0.01, 0.02};
	att_record(&a, 8, start(), &att);
	assert_true(fabsf(att.heading_deg - 180) < 1e-4f &&
	            fabs(att.sd_heading_deg - 0.5729577951308232) < 1e-12);
	assert_int_equal(att.mode, 2);
	att_record(NULL, 0, start(), &att);
	assert_int_equal(att.mode, 0);
	assert_int_equal(att.error_aux1, 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_ephemerides),
	    cmocka_unit_test(test_no_record),
	    cmocka_unit_test(test_observation),
	    cmocka_unit_test(test_solution),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
