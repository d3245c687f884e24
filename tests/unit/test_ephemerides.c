/* Ephemerides from records, and the store. Weeks and times of week are written out by hand. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "../../cli/ephemerides.h"
#include "furrow_eph_bds.h"
#include "furrow_eph_gal.h"
#include "furrow_eph_glo.h"
#include "furrow_eph_gps.h"
#include "furrow_eph_gps_columns.h"
#include "furrow_eph_sbas.h"
#include "furrow_klobuchar.h"

static ephemeris_store store;
static char name[8];

/* All columns present: absent ones are tested by clearing bits. */
static const int64_t everything = INT64_MAX;

static char *sat(const char *text)
{
	strncpy(name, text, sizeof name - 1);
	return name;
}

static furrow_eph_gps gps(int stamp_week, double stamp_tow_s, int toe_week, int toe_s)
{
	return (furrow_eph_gps){.present = everything,
	                        .gps_week = stamp_week,
	                        .tow_s = stamp_tow_s,
	                        .sat = sat("G07"),
	                        .sqrt_a_sqrtm = 5153,
	                        .toe_week = toe_week,
	                        .toe_s = toe_s,
	                        .toc_s = toe_s,
	                        .iode2 = 5};
}

static void expect_time(fw_time t, int week, int tow_s)
{
	fw_time expected;
	assert_int_equal(fw_time_from_gps(week, tow_s * FW_NS_PER_S, &expected), FW_OK);
	assert_int_equal(t.ns, expected.ns);
}

static void gps_weeks_are_completed_near_the_stamp(void **state)
{
	(void)state;
	fw_ephemeris e;
	furrow_eph_gps r = gps(2320, 122400, 2320 % 1024, 122400);
	assert_int_equal(ephemeris_of_record(FW_eph_gps, &r, &e), FW_OK);
	expect_time(e.toe, 2320, 122400);
	/* sent at the end of a week for the begin of the next one, across a roll-over of the ten bits too */
	r = gps(2047, 604700, 0, 0);
	assert_int_equal(ephemeris_of_record(FW_eph_gps, &r, &e), FW_OK);
	expect_time(e.toe, 2048, 0);
	expect_time(e.toc, 2048, 0);
	/* no week: the nearest moment */
	r = gps(2048, 100, 0, 604784);
	r.present &= ~(INT64_C(1) << FW_COL_eph_gps_toe_week);
	assert_int_equal(ephemeris_of_record(FW_eph_gps, &r, &e), FW_OK);
	expect_time(e.toe, 2047, 604784);
}

static void incomplete_records_are_refused(void **state)
{
	(void)state;
	fw_ephemeris e = {.issue = 77};
	furrow_eph_gps r = gps(2320, 122400, 272, 122400);
	r.present &= ~(INT64_C(1) << FW_COL_eph_gps_ecc);
	assert_int_equal(ephemeris_of_record(FW_eph_gps, &r, &e), FW_EINVAL);
	r = gps(2320, 122400, 272, 700000);
	assert_int_equal(ephemeris_of_record(FW_eph_gps, &r, &e), FW_ERANGE);
	r = gps(2320, 122400, 272, 122400);
	r.sat = sat("?");
	assert_int_equal(ephemeris_of_record(FW_eph_gps, &r, &e), FW_EINVAL);
	assert_int_equal(ephemeris_of_record(FW_pvt, &r, &e), FW_EINVAL);
	assert_int_equal(e.issue, 77);
}

static void times_of_the_other_systems_become_gpst(void **state)
{
	(void)state;
	fw_ephemeris e;
	/* BDT week 964 begins 14 s into GPS week 2320 */
	furrow_eph_bds bds = {.present = everything,
	                      .gps_week = 2320,
	                      .tow_s = 3700,
	                      .sat = sat("C21"),
	                      .toe_week = 964,
	                      .toe_s = 3600,
	                      .toc_s = 3600};
	assert_int_equal(ephemeris_of_record(FW_eph_bds, &bds, &e), FW_OK);
	expect_time(e.toe, 2320, 3614);
	expect_time(e.toc, 2320, 3614);
	furrow_eph_glo glo = {.present = everything,
	                      .gps_week = 2320,
	                      .tow_s = 119000,
	                      .sat = sat("R05"),
	                      .tau_s = 1e-4F,
	                      .gamma = 2e-12F,
	                      .toe_week = 2320,
	                      .toe_s = 117918,
	                      .x_m = 1e7,
	                      .glonass_channel = -3};
	assert_int_equal(ephemeris_of_record(FW_eph_glo, &glo, &e), FW_OK);
	expect_time(e.toe, 2320, 117918);
	assert_true(e.af0_s == -(double)1e-4F && e.af1_sps == (double)2e-12F && e.state.channel == -3 &&
	            e.healthy);
	glo.health_b = 4;
	assert_int_equal(ephemeris_of_record(FW_eph_glo, &glo, &e), FW_OK);
	assert_false(e.healthy);
	/* seconds of the day, from just before midnight */
	furrow_eph_sbas sbas = {
	    .present = everything, .gps_week = 2320, .tow_s = 86410, .sat = sat("S123"), .t0_s = 86384};
	assert_int_equal(ephemeris_of_record(FW_eph_sbas, &sbas, &e), FW_OK);
	expect_time(e.toe, 2320, 86384);
}

static furrow_eph_gal gal(int message, int toe_s, int health)
{
	return (furrow_eph_gal){.present = everything,
	                        .gps_week = 2320,
	                        .tow_s = toe_s + 600,
	                        .sat = sat("E11"),
	                        .message = (int8_t)message,
	                        .toe_week = 2320,
	                        .toe_s = toe_s,
	                        .toc_s = toe_s,
	                        .health = health,
	                        .iodnav = 1,
	                        .sisa_e1e5a = 107,
	                        .sisa_e1e5b = 107};
}

static void health_of_galileo_is_in_its_bits(void **state)
{
	(void)state;
	static const struct {
		int health;
		bool good;
	} cases[] = {{0x111, true},  {0x113, false}, {0x115, false},
	             {0x131, false}, {0x511, false}, {0x511 & ~0x100, true}};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		fw_ephemeris e;
		furrow_eph_gal r = gal(2, 36000, cases[i].health);
		assert_int_equal(ephemeris_of_record(FW_eph_gal, &r, &e), FW_OK);
		assert_int_equal(e.healthy, cases[i].good);
		r.sisa_e1e5b = 255;
		assert_int_equal(ephemeris_of_record(FW_eph_gal, &r, &e), FW_OK);
		assert_false(e.healthy);
	}
}

static const fw_ephemeris *find(const char *satellite, fw_nav_message wanted, int tow_s)
{
	fw_satellite s;
	fw_time t;
	assert_int_equal(fw_satellite_parse(satellite, &s), FW_OK);
	assert_int_equal(fw_time_from_gps(2320, tow_s * FW_NS_PER_S, &t), FW_OK);
	return ephemeris_store_find(&store, s, wanted, t);
}

static void nearest_in_time_is_found_in_any_order(void **state)
{
	(void)state;
	static const int toes[] = {14400, 0, 21600, 7200, 14400};
	for (size_t i = 0; i < sizeof toes / sizeof toes[0]; i++) {
		furrow_eph_gps r = gps(2320, toes[i], 272, toes[i]);
		ephemeris_store_put(&store, FW_eph_gps, &r);
	}
	assert_int_equal(store.taken, 5);
	static const int asked[] = {10000, 100, 25000, 3000, 13000, 5000};
	static const int found[] = {7200, 0, 21600, 0, 14400, 7200};
	for (size_t i = 0; i < sizeof asked / sizeof asked[0]; i++)
		expect_time(find("G07", FW_NAV_LNAV, asked[i])->toe, 2320, found[i]);
	assert_null(find("G08", FW_NAV_LNAV, 0));
	ephemeris_store_free(&store);
}

static void newest_content_wins_and_unhealthy_satellites_have_none(void **state)
{
	(void)state;
	furrow_eph_gps r = gps(2320, 7200, 272, 7200);
	ephemeris_store_put(&store, FW_eph_gps, &r);
	r.iode2 = 6;
	ephemeris_store_put(&store, FW_eph_gps, &r);
	assert_int_equal(find("G07", FW_NAV_LNAV, 7000)->issue, 6);
	r.health = 1;
	ephemeris_store_put(&store, FW_eph_gps, &r);
	assert_null(find("G07", FW_NAV_LNAV, 7000));
	ephemeris_store_free(&store);
}

static void galileo_has_the_message_that_is_wanted(void **state)
{
	(void)state;
	furrow_eph_gal inav = gal(2, 36000, 0), fnav = gal(16, 36600, 0);
	ephemeris_store_put(&store, FW_eph_gal, &inav);
	assert_int_equal(find("E11", FW_NAV_FNAV, 36000)->message, FW_NAV_INAV);
	ephemeris_store_put(&store, FW_eph_gal, &fnav);
	assert_int_equal(find("E11", FW_NAV_FNAV, 36000)->message, FW_NAV_FNAV);
	assert_int_equal(find("E11", FW_NAV_INAV, 36600)->message, FW_NAV_INAV);
	/* too old to be used: the other one */
	assert_int_equal(find("E11", FW_NAV_INAV, 36000 + 4 * 3600 + 300)->message, FW_NAV_FNAV);
	ephemeris_store_free(&store);
}

static void expect_same_way(const fw_ephemeris *e, int from_s, int until_s)
{
	for (int at = from_s; at < until_s; at += 97) {
		fw_satellite_state a, b;
		fw_time t;
		assert_int_equal(fw_time_from_gps(2320, at * FW_NS_PER_S + 123456789, &t), FW_OK);
		assert_true(fw_ephemeris_state(e, t, &a) >= 0);
		for (int again = 0; again < 2; again++) {
			assert_true(ephemeris_store_state(&store, e, t, &b) >= 0);
			for (int i = 0; i < 3; i++) {
				assert_true(fabs(a.position_m[i] - b.position_m[i]) < 1e-4);
				assert_true(fabs(a.velocity_mps[i] - b.velocity_mps[i]) < 5e-5);
			}
			assert_true(fabs(a.clock_s - b.clock_s) < 1e-15);
			assert_true(fabs(a.drift_sps - b.drift_sps) < 1e-15);
		}
	}
}

static void interpolated_states_are_those_of_the_ephemeris(void **state)
{
	(void)state;
	fw_ephemeris e;
	furrow_eph_glo glo = {.present = everything,
	                      .gps_week = 2320,
	                      .tow_s = 9000,
	                      .sat = sat("R05"),
	                      .toe_week = 2320,
	                      .toe_s = 9000,
	                      .x_m = 11000e3,
	                      .y_m = -18000e3,
	                      .z_m = 14000e3,
	                      .vx_mps = 1900,
	                      .vy_mps = 2200,
	                      .vz_mps = 1400,
	                      .tau_s = 1e-5F};
	assert_int_equal(ephemeris_of_record(FW_eph_glo, &glo, &e), FW_OK);
	expect_same_way(&e, 7210, 10790);
	furrow_eph_gps r = gps(2320, 7200, 272, 7200);
	r.ecc = 0.02;
	r.i0_rad = 0.96;
	r.m0_rad = 2;
	r.cuc_rad = 5e-6F;
	r.crs_m = 100;
	r.af0_s = 1e-4F;
	r.af1_sps = 1e-11F;
	assert_int_equal(ephemeris_of_record(FW_eph_gps, &r, &e), FW_OK);
	expect_same_way(&e, 0, 14400);
	/* other content, same satellite: another way */
	e.kepler.m0 += 1e-3;
	expect_same_way(&e, 7200, 7300);
	fw_time late = fw_time_add_ns(e.toe, 5 * 3600 * FW_NS_PER_S);
	fw_satellite_state unused;
	assert_int_equal(ephemeris_store_state(&store, &e, late, &unused), FW_ERANGE);
	ephemeris_store_free(&store);
}

static void klobuchar_is_kept_by_system(void **state)
{
	(void)state;
	furrow_klobuchar r = {.present = everything, .sat = sat("C03"), .alpha0_s = 1e-8F, .beta3_s = -2e5F};
	ephemeris_store_put(&store, FW_klobuchar, &r);
	assert_true(store.iono.has_beidou && !store.iono.has_gps);
	assert_true(store.iono.beidou.alpha[0] == (double)1e-8F &&
	            store.iono.beidou.beta[3] == (double)-2e5F);
	r.sat = sat("G");
	ephemeris_store_put(&store, FW_klobuchar, &r);
	assert_true(store.iono.has_gps);
	ephemeris_store_free(&store);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(gps_weeks_are_completed_near_the_stamp),
	    cmocka_unit_test(incomplete_records_are_refused),
	    cmocka_unit_test(times_of_the_other_systems_become_gpst),
	    cmocka_unit_test(health_of_galileo_is_in_its_bits),
	    cmocka_unit_test(nearest_in_time_is_found_in_any_order),
	    cmocka_unit_test(newest_content_wins_and_unhealthy_satellites_have_none),
	    cmocka_unit_test(galileo_has_the_message_that_is_wanted),
	    cmocka_unit_test(interpolated_states_are_those_of_the_ephemeris),
	    cmocka_unit_test(klobuchar_is_kept_by_system),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
