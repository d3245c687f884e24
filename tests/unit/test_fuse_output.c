#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "../../cli/fuse_output.h"
#include "base/frame.h"
#include "furrow_nav.h"
#include "furrow_nav_columns.h"

static furrow_nav last;
static int rows;

static void put(void *unused, fw_kind kind, const void *record)
{
	(void)unused;
	assert_int_equal(kind, FW_nav);
	memcpy(&last, record, sizeof last);
	rows++;
}

static const fuse_output out = {{put, NULL}, 0};

#define near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static fuse_moment level_moment(void)
{
	fuse_moment m = {.pva = {.time = {5 * FW_NS_PER_WEEK + 7 * FW_NS_PER_S / 2},
	                         .llh = {0.5, -0.25, 100},
	                         .velocity_mps = {1, 2, 3}},
	                 .spread = {[FUSE_SPREAD_ATTITUDE] = 1e-6,
	                            4e-6,
	                            9e-6,
	                            [FUSE_SPREAD_VELOCITY] = 0.01,
	                            0.04,
	                            0.09,
	                            [FUSE_SPREAD_POSITION] = 4,
	                            4,
	                            9},
	                 .hpl_m = (float)NAN,
	                 .vpl_m = 7,
	                 .status = FUSE_COASTING};
	const double rpy[3] = {0, 0, 0};
	fw_euler_to_quat(rpy, m.pva.q_n_b);
	return m;
}

static void test_columns(void **state)
{
	const fuse_moment m = level_moment();
	(void)state;
	assert_true(fuse_output_put(&out, &m));
	assert_int_equal(last.gps_week, 5);
	near(last.tow_s, 3.5, 0);
	near(last.lat_deg, 28.6478897565, 1e-9); /* 0.5 rad */
	near(last.lon_deg, -14.3239448783, 1e-9);
	assert_true(last.height_m == 100 && last.vn_mps == 1 && last.ve_mps == 2 && last.vd_mps == 3);
	near(last.sd_n_m, 2, 1e-12);
	near(last.sd_d_m, 3, 1e-12);
	near(last.sd_ve_mps, 0.2, 1e-12);
	near(last.sd_roll_deg, 0.0572957795, 1e-9); /* 1 mrad */
	near(last.sd_heading_deg, 0.1718873385, 1e-9);
	assert_int_equal(last.present >> FW_COL_nav_hpl_m & 1, 0);
	assert_int_equal(last.present >> FW_COL_nav_vpl_m & 1, 1);
	assert_string_equal(last.status, "coasting");
	near(last.vfom_m, 1.96 * 3, 1e-12);
	near(last.hfom_m, 2 * 2.4477,
	     0.01); /* a circle: sqrt(chi-square of 2 degrees of freedom at 0.95) = 2.4477 */
}

/* All error in one direction: the normal distribution's 1.96, whichever way it points. */
static void test_radius_of_a_line(void **state)
{
	fuse_moment m = level_moment();
	double *p = m.spread + FUSE_SPREAD_POSITION;
	(void)state;
	p[0] = 9;
	p[1] = p[3] = 0;
	assert_true(fuse_output_put(&out, &m));
	near(last.hfom_m, 1.96 * 3, 0.01);
	p[0] = p[1] = p[3] = 4.5;
	assert_true(fuse_output_put(&out, &m));
	near(last.hfom_m, 1.96 * 3, 0.01);
}

/* The sigmas of the angles are those that the library has. */
static void test_angles(void **state)
{
	static fw_filter f;
	fuse_moment m = level_moment();
	const double rpy[3] = {0.3, -0.8, 2.5};
	double sd[3];
	(void)state;
	fw_euler_to_quat(rpy, m.pva.q_n_b);
	f.pva = m.pva;
	const double P[3][3] = {{4e-6, 1e-6, -2e-6}, {1e-6, 3e-6, 5e-7}, {-2e-6, 5e-7, 8e-6}};
	for (int i = 0; i < 3; i++)
		memcpy(f.P[i], P[i], sizeof P[i]);
	fuse_spread_of((const double(*)[FW_STATES_MAX])f.P, m.spread);
	fw_attitude_sd(&f, sd);
	assert_true(fuse_output_put(&out, &m));
	near(last.sd_roll_deg, fw_deg_from_rad(sd[0]), 1e-12);
	near(last.sd_pitch_deg, fw_deg_from_rad(sd[1]), 1e-12);
	near(last.sd_heading_deg, fw_deg_from_rad(sd[2]), 1e-12);
	const fuse_output turned = {{put, NULL}, 0.003};
	assert_true(fuse_output_put(&turned, &m));
	near(last.sd_pitch_deg, fw_deg_from_rad(hypot(sd[1], 0.003)), 1e-12);
}

static void test_not_finite(void **state)
{
	(void)state;
	rows = 0;
	for (int i = 0; i < 3; i++) {
		fuse_moment m = level_moment();
		m.pva.llh[i] = i < 2 ? (double)NAN : (double)INFINITY;
		assert_false(fuse_output_put(&out, &m));
		m = level_moment();
		m.pva.velocity_mps[i] = (double)NAN;
		assert_false(fuse_output_put(&out, &m));
		m = level_moment();
		m.pva.q_n_b[i] = (double)NAN;
		assert_false(fuse_output_put(&out, &m));
		m = level_moment();
		m.spread[FUSE_SPREAD_POSITION + i] = (double)NAN;
		assert_false(fuse_output_put(&out, &m));
	}
	assert_int_equal(rows, 0);
}

static int kept(fuse_rate r, int64_t step_ns, int n)
{
	int count = 0;
	for (int i = 0; i < n; i++)
		count += fuse_rate_keeps(&r, (fw_time){1000 * FW_NS_PER_WEEK + 3 + i * step_ns});
	return count;
}

static void test_rate(void **state)
{
	const int64_t never = INT64_MIN / 2;
	(void)state;
	assert_int_equal(kept((fuse_rate){0, never}, 10000000, 1000), 1000);
	assert_int_equal(kept((fuse_rate){-1, never}, 10000000, 1000), 0);
	assert_int_equal(kept((fuse_rate){100000000, never}, 10000000, 1000), 100);
	assert_int_equal(kept((fuse_rate){30000000, never}, 10000000, 300), 100);
	/* Slower than what is asked for: each is the first one after a multiple. */
	assert_int_equal(kept((fuse_rate){1000000, never}, 10000000, 50), 50);
	/* After a leap back, as a new log may begin, it goes on. */
	fuse_rate r = {FW_NS_PER_S, never};
	assert_true(fuse_rate_keeps(&r, (fw_time){100 * FW_NS_PER_S}));
	assert_false(fuse_rate_keeps(&r, (fw_time){100 * FW_NS_PER_S + 5}));
	assert_true(fuse_rate_keeps(&r, (fw_time){50 * FW_NS_PER_S + 5}));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_columns), cmocka_unit_test(test_radius_of_a_line),
	    cmocka_unit_test(test_angles),  cmocka_unit_test(test_not_finite),
	    cmocka_unit_test(test_rate),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
