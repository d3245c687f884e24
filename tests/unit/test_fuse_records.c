#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "../../cli/fuse_records.h"
#include "base/frame.h"
#include "furrow_att.h"
#include "furrow_att_columns.h"
#include "furrow_imu.h"
#include "furrow_imu_columns.h"
#include "furrow_imu_setup.h"
#include "furrow_imu_setup_columns.h"
#include "furrow_pl.h"
#include "furrow_pl_columns.h"
#include "furrow_pos.h"
#include "furrow_pos_columns.h"
#include "furrow_pvt.h"
#include "furrow_pvt_columns.h"
#include "furrow_pvt_ecef.h"
#include "furrow_pvt_ecef_columns.h"

#define near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))
#define BIT(type, column)     (INT64_C(1) << FW_COL_##type##_##column)

/* All columns from a to b. */
#define BITS(type, a, b) ((BIT(type, b) - BIT(type, a)) | BIT(type, b))

static const fw_time noon = {2000 * FW_NS_PER_WEEK};
static fuse_records r;
static fuse_entry e;

static fuse_records_setup plain(void)
{
	return (fuse_records_setup){.C_b_s = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .use_velocity = true};
}

static void begin(void)
{
	const fuse_records_setup s = plain();
	fuse_records_begin(&r, &s);
}

static furrow_pvt fix(void)
{
	return (furrow_pvt){.present = BIT(pvt, mode) | BIT(pvt, error) | BITS(pvt, lat_deg, height_m) |
	                               BITS(pvt, vn_mps, vd_mps) | BITS(pvt, sd_n_m, sd_d_m),
	                    .mode = 1,
	                    .lat_deg = 52,
	                    .lon_deg = 11,
	                    .height_m = 100,
	                    .vn_mps = 1,
	                    .ve_mps = 2,
	                    .vd_mps = 3,
	                    .sd_n_m = 1,
	                    .sd_e_m = 2,
	                    .sd_d_m = 3};
}

static void test_pvt(void **state)
{
	furrow_pvt p = fix();
	(void)state;
	begin();
	assert_true(fuse_records_take(&r, FW_pvt, &p, noon, &e));
	assert_false(e.is_imu);
	assert_int_equal(e.item.kind, FW_ITEM_FIX);
	assert_true(e.item.fix.has_position && e.item.fix.has_velocity);
	near(e.item.fix.llh[0], fw_rad_from_deg(52), 1e-15);
	assert_true(e.item.fix.R_position[1][1] == 4 && e.item.fix.R_position[0][1] == 0);
	assert_true(e.item.fix.velocity_mps[2] == 3 && e.item.fix.R_velocity[0][0] > 0);

	/* Covariances come before deviations. */
	p.present |=
	    BITS(pvt, cov_nn_m2, cov_dd_m2) | BIT(pvt, cov_ne_m2) | BIT(pvt, cov_nd_m2) | BIT(pvt, cov_ed_m2);
	p.cov_nn_m2 = 9;
	p.cov_ee_m2 = 16;
	p.cov_dd_m2 = 25;
	p.cov_ne_m2 = -2;
	p.cov_ed_m2 = 3;
	assert_true(fuse_records_take(&r, FW_pvt, &p, noon, &e));
	assert_true(e.item.fix.R_position[0][0] == 9 && e.item.fix.R_position[1][0] == -2 &&
	            e.item.fix.R_position[0][1] == -2 && e.item.fix.R_position[2][1] == 3);

	/* The receiver's clock is fast by 2 ms: it was there 2 ms before its stamp. */
	p.present |= BIT(pvt, clock_bias_s);
	p.clock_bias_s = 0.002;
	assert_true(fuse_records_take(&r, FW_pvt, &p, noon, &e));
	assert_int_equal(e.item.time.ns, noon.ns - 2000000);

	p.present |= BIT(pvt, two_d);
	p.two_d = 1;
	assert_true(fuse_records_take(&r, FW_pvt, &p, noon, &e));
	assert_true(e.item.fix.R_position[2][2] >= 1e4 && e.item.fix.R_position[2][1] == 0);
	assert_int_equal(r.fixes, 4);

	p.mode = 0;
	assert_false(fuse_records_take(&r, FW_pvt, &p, noon, &e));
	p.mode = 1;
	p.error = 3;
	assert_false(fuse_records_take(&r, FW_pvt, &p, noon, &e));
	assert_int_equal(r.no_fix, 2);
}

/* Ambiguities that are not fixed: centimetres are not believed. */
static void test_float(void **state)
{
	static char quality[] = "float";
	const furrow_pos q = {.present = BITS(pos, lat_deg, height_m) | BITS(pos, sd_n_m, sd_d_m) |
	                                 BIT(pos, quality),
	                      .sd_n_m = 0.01,
	                      .sd_e_m = 0.01,
	                      .sd_d_m = 2,
	                      .quality = quality};
	furrow_pvt p = fix();
	fuse_records_setup s = plain();
	(void)state;
	s.float_floor_m = 0.5;
	fuse_records_begin(&r, &s);
	assert_true(fuse_records_take(&r, FW_pos, &q, noon, &e));
	assert_true(e.item.fix.R_position[0][0] == 0.25 && e.item.fix.R_position[2][2] == 4);
	p.sd_n_m = 0.02;
	for (int mode = 1; mode <= 10; mode++) {
		fuse_records_begin(&r, &s);
		p.mode = (int8_t)mode;
		assert_true(fuse_records_take(&r, FW_pvt, &p, noon, &e));
		near(e.item.fix.R_position[0][0], mode == 5 || mode == 8 ? 0.25 : 0.0004, 1e-12);
	}
}

/* 1 m^2 north, 4 up at latitude 0, longitude 90 degrees: x is west, y up, z north. */
static void test_pvt_ecef(void **state)
{
	furrow_pvt_ecef p = {.present = BITS(pvt_ecef, x_m, z_m) | BITS(pvt_ecef, vx_mps, vz_mps) |
	                                BITS(pvt_ecef, cov_xx_m2, cov_zz_m2) | BIT(pvt_ecef, cov_xy_m2) |
	                                BIT(pvt_ecef, cov_xz_m2) | BIT(pvt_ecef, cov_yz_m2),
	                     .y_m = FW_WGS84_A + 50,
	                     .vx_mps = -3,
	                     .vy_mps = 5,
	                     .vz_mps = 7,
	                     .cov_xx_m2 = 2,
	                     .cov_yy_m2 = 4,
	                     .cov_zz_m2 = 1,
	                     .cov_yz_m2 = 0.5F};
	(void)state;
	begin();
	assert_true(fuse_records_take(&r, FW_pvt_ecef, &p, noon, &e));
	near(e.item.fix.llh[2], 50, 1e-6);
	near(e.item.fix.velocity_mps[0], 7, 1e-12);
	near(e.item.fix.velocity_mps[1], 3, 1e-12);
	near(e.item.fix.velocity_mps[2], -5, 1e-12);
	near(e.item.fix.R_position[0][0], 1, 1e-12);
	near(e.item.fix.R_position[1][1], 2, 1e-12);
	near(e.item.fix.R_position[2][2], 4, 1e-12);
	near(e.item.fix.R_position[0][2], -0.5, 1e-12);
}

/* One type of record gives the positions: the first, or the one asked for. */
static void test_choice(void **state)
{
	const furrow_pvt p = fix();
	const furrow_pos q = {.present = BITS(pos, lat_deg, height_m), .lat_deg = 52, .lon_deg = 11};
	fuse_records_setup s = plain();
	(void)state;
	begin();
	assert_true(fuse_records_take(&r, FW_pos, &q, noon, &e));
	assert_int_equal(r.without_sigma, 1);
	assert_false(e.item.fix.has_velocity);
	assert_true(e.item.fix.R_position[0][0] > 1);
	assert_false(fuse_records_take(&r, FW_pvt, &p, noon, &e));
	assert_int_equal(r.other_fixes, 1);
	assert_int_equal(r.other_kind, FW_pvt);
	s.fixes = FUSE_FIXES_PVT;
	s.use_velocity = false;
	fuse_records_begin(&r, &s);
	assert_false(fuse_records_take(&r, FW_pos, &q, noon, &e));
	assert_true(fuse_records_take(&r, FW_pvt, &p, noon, &e));
	assert_false(e.item.fix.has_velocity);
}

/* The IMU turned by 90 degrees: its x axis points right. */
static void test_imu(void **state)
{
	const furrow_imu imu = {.present = BITS(imu, gyro_x_radps, accel_z_mps2),
	                        .gyro_x_radps = 1,
	                        .gyro_y_radps = 2,
	                        .gyro_z_radps = 3,
	                        .accel_x_mps2 = 4,
	                        .accel_y_mps2 = 5,
	                        .accel_z_mps2 = 6};
	const furrow_imu lacking = {.present = BITS(imu, gyro_x_radps, accel_y_mps2)};
	const double rpy[3] = {0, 0, FW_PI / 2};
	fuse_records_setup s = plain();
	(void)state;
	fw_euler_to_matrix(rpy, s.C_b_s);
	s.imu_offset_ns = 5;
	fuse_records_begin(&r, &s);
	assert_true(fuse_records_take(&r, FW_imu, &imu, noon, &e));
	assert_true(e.is_imu);
	assert_int_equal(e.imu.time.ns, noon.ns + 5);
	near(e.imu.gyro_radps[0], -2, 1e-12);
	near(e.imu.gyro_radps[1], 1, 1e-12);
	near(e.imu.accel_mps2[2], 6, 1e-12);
	assert_true(fuse_records_take(&r, FW_imu, &lacking, noon, &e));
	assert_true(isnan(e.imu.gyro_radps[0])); /* for the filter to refuse */
}

static void test_heading(void **state)
{
	furrow_att a = {.present = BIT(att, mode) | BIT(att, heading_deg) | BIT(att, sd_heading_deg),
	                .mode = 2,
	                .heading_deg = 10,
	                .sd_heading_deg = 0.01};
	fuse_records_setup s = plain();
	(void)state;
	s.antenna_heading_rad = fw_rad_from_deg(90);
	s.heading_floor_rad = 0.005;
	fuse_records_begin(&r, &s);
	assert_true(fuse_records_take(&r, FW_att, &a, noon, &e));
	near(e.item.heading.heading_rad, fw_rad_from_deg(280), 1e-7);
	assert_true(e.item.heading.sd_rad == 0.005);
	a.sd_heading_deg = -1; /* for the filter to refuse */
	assert_true(fuse_records_take(&r, FW_att, &a, noon, &e));
	assert_true(e.item.heading.sd_rad < 0);
	a.mode = 0;
	assert_false(fuse_records_take(&r, FW_att, &a, noon, &e));
	a.mode = 2;
	a.present &= ~BIT(att, heading_deg);
	assert_false(fuse_records_take(&r, FW_att, &a, noon, &e));
}

static void test_levels_and_lever(void **state)
{
	static char reliable[] = "RELIABLE", unreliable[] = "UNRELIABLE";
	furrow_pl p = {.present = BIT(pl, hpl_m) | BIT(pl, state), .hpl_m = 5, .state = reliable};
	const furrow_imu_setup m = {
	    .present = BITS(imu_setup, lever_x_m, lever_z_m), .lever_x_m = 0.5F, .lever_z_m = -1};
	(void)state;
	begin();
	assert_true(fuse_records_take(&r, FW_pl, &p, noon, &e));
	assert_int_equal(e.item.levels.state, FW_RELIABLE);
	assert_true(e.item.levels.hpl_m == 5 && isnan(e.item.levels.vpl_m));
	p.state = unreliable;
	assert_true(fuse_records_take(&r, FW_pl, &p, noon, &e));
	assert_int_equal(e.item.levels.state, FW_UNRELIABLE);
	assert_false(r.has_lever);
	assert_false(fuse_records_take(&r, FW_imu_setup, &m, noon, &e));
	assert_true(r.has_lever && r.lever_b[0] == 0.5 && r.lever_b[2] == -1);
}

/* 3 s of every 10 s, from 5 s after the first fix. */
static void test_withheld(void **state)
{
	const furrow_pvt p = fix();
	fuse_records_setup s = plain();
	int used = 0;
	(void)state;
	s.withhold_every_ns = 10 * FW_NS_PER_S;
	s.withhold_length_ns = 3 * FW_NS_PER_S;
	s.withhold_first_ns = 5 * FW_NS_PER_S;
	fuse_records_begin(&r, &s);
	for (int i = 0; i < 40; i++) {
		const bool taken =
		    fuse_records_take(&r, FW_pvt, &p, fw_time_add_ns(noon, i * FW_NS_PER_S), &e);
		assert_int_equal(taken, !(i % 10 >= 5 && i % 10 < 8));
		used += taken;
	}
	assert_int_equal(used, 28);
	assert_int_equal(r.withheld, 12);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_pvt),      cmocka_unit_test(test_pvt_ecef),
	    cmocka_unit_test(test_choice),   cmocka_unit_test(test_imu),
	    cmocka_unit_test(test_heading),  cmocka_unit_test(test_levels_and_lever),
	    cmocka_unit_test(test_withheld), cmocka_unit_test(test_float),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
