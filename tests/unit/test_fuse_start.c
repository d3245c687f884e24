#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "../../cli/fuse_start.h"
#include "base/frame.h"
#include "base/matrix.h"
#include "ins/gravity.h"

#define DEG                   (FW_PI / 180)
#define near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static const fw_time noon = {2000 * FW_NS_PER_WEEK};
static const double place[3] = {0.9, 0.2, 100};
static fuse_start start;

static fuse_start_setup drone(void)
{
	const fw_stillness_setup still = fw_stillness_defaults();
	return (fuse_start_setup){
	    .heading_sd_rad = 0.1,
	    .limit_rad = 3 * DEG,
	    .imu = {.gyro_bias_sd = 2.4e-4, .gyro_noise = 4e-5, .accel_bias_sd = 0.02, .accel_noise = 6e-4},
	    .still = still,
	    .gap_s = 1,
	    .compass_sd_rad = 0.1,
	    .declination_rad = (double)NAN};
}

static bool put_imu(double t, const double gyro[3], const double accel[3])
{
	fuse_entry e = {.is_imu = true, .imu.time = fw_time_add_ns(noon, llround(t * 1e9))};
	memcpy(e.imu.gyro_radps, gyro, sizeof e.imu.gyro_radps);
	memcpy(e.imu.accel_mps2, accel, sizeof e.imu.accel_mps2);
	return fuse_start_put(&start, &e);
}

static void put_fix_at(double t, double north_m, double up_m)
{
	fuse_entry e = {.item = {.time = fw_time_add_ns(noon, llround(t * 1e9)), .kind = FW_ITEM_FIX}};
	memcpy(e.item.fix.llh, place, sizeof place);
	e.item.fix.llh[0] += north_m / 6.37e6;
	e.item.fix.llh[2] += up_m;
	e.item.fix.has_position = e.item.fix.has_velocity = true;
	for (int i = 0; i < 3; i++) {
		e.item.fix.R_position[i][i] = 1;
		e.item.fix.R_velocity[i][i] = 0.01;
	}
	fuse_start_put(&start, &e);
}

static void put_fix(double t, double north_m)
{
	put_fix_at(t, north_m, 0);
}

static void put_heading(double t, double heading)
{
	fuse_entry e = {.item = {.time = fw_time_add_ns(noon, llround(t * 1e9)), .kind = FW_ITEM_HEADING}};
	e.item.heading.heading_rad = heading;
	e.item.heading.sd_rad = 0.01;
	fuse_start_put(&start, &e);
}

/* What an IMU at rest feels at these angles. */
static void at_rest(const double rpy[3], double force_b[3])
{
	const double up[3] = {0, 0, -fw_gravity_mps2(place[0], place[2])};
	double C[3][3];
	fw_euler_to_matrix(rpy, C);
	fw_mat3_t_vec(C, up, force_b);
}

/* Standing still with two antennas: the first position is the beginning, at the angles that gravity and antennas say. */
static void test_still(void **state)
{
	const fuse_start_setup s = drone();
	const double rpy[3] = {5 * DEG, -3 * DEG, 40 * DEG}, bias[3] = {1e-4, -2e-4, 5e-5};
	double force[3], found[3];
	fuse_beginning b;
	fw_status status = FW_MORE;
	(void)state;
	at_rest(rpy, force);
	assert_int_equal(fuse_start_begin(&start, &s), FW_OK);
	for (int i = 1; i < 1000 && status != FW_OK; i++) {
		const double t = i / 100.0;
		if (i % 20 == 0) {
			put_fix(t - 0.005, 0);
			put_heading(t - 0.005, rpy[2]);
		}
		if (put_imu(t, bias, force))
			status = fuse_start_try(&start, false, &b);
	}
	assert_int_equal(status, FW_OK);
	assert_string_equal(b.way, "heading of two antennas");
	assert_int_equal(b.pva.time.ns, noon.ns + 190000000); /* the reading before the first fix */
	fw_quat_to_euler(b.pva.q_n_b, found);
	for (int i = 0; i < 3; i++)
		near(found[i], rpy[i], 0.05 * DEG);
	near(b.pva.llh[0], place[0], 1e-9);
	assert_true(b.position_sd[0] >= 1 && b.position_sd[0] < 4);
	for (int i = 0; i < 3; i++) /* the rotation of the Earth is at most this */
		near(b.gyro_bias[i], bias[i], 7.4e-5);
	assert_true(b.gyro_bias_sd[0] < s.imu.gyro_bias_sd);
}

/* It turns by 60 degrees before it stands still, and only then has a heading: the beginning is where it was before the turn. */
static void test_carried_back(void **state)
{
	fuse_start_setup s = drone();
	const double level[3] = {0, 0, 0}, still[3] = {0, 0, 0}, turning[3] = {0, 0, 60 * DEG / 2};
	double force[3], found[3];
	fuse_beginning b;
	fw_status status = FW_MORE;
	(void)state;
	at_rest(level, force);
	s.imu.gyro_bias_sd = 1e-5;
	assert_int_equal(fuse_start_begin(&start, &s), FW_OK);
	for (int i = 1; i < 2000 && status != FW_OK; i++) {
		const double t = i / 100.0;
		if (i % 20 == 0)
			put_fix(t, 0);
		if (i > 400 && i % 20 == 0)
			put_heading(t, 100 * DEG);
		if (put_imu(t, i <= 200 ? turning : still, force))
			status = fuse_start_try(&start, false, &b);
	}
	assert_int_equal(status, FW_OK);
	assert_int_equal(b.pva.time.ns, noon.ns + 200000000);
	fw_quat_to_euler(b.pva.q_n_b, found);
	near(found[2], 46 * DEG, 0.1 * DEG); /* 40 degrees, and 0.2 s at 30 degrees/s */
}

/* A first position far away, or far up, is not where it begins. One of which nobody can be sure is, but with a sigma that
 * holds the next one. */
static void test_outlier(void **state)
{
	static const struct {
		double north_m, up_m;
		bool stray;
	} first[] = {{111000, 0, true}, {0, 50, true}, {15, 0, true}, {6, 0, false}, {0, -6, false}};
	const fuse_start_setup s = drone();
	const double level[3] = {0, 0, 0}, still[3] = {0, 0, 0};
	double force[3];
	fuse_beginning b;
	(void)state;
	at_rest(level, force);
	for (size_t k = 0; k < sizeof first / sizeof first[0]; k++) {
		fw_status status = FW_MORE;
		assert_int_equal(fuse_start_begin(&start, &s), FW_OK);
		for (int i = 1; i < 2000 && status != FW_OK; i++) {
			const double t = i / 100.0;
			if (i % 20 == 0) {
				put_fix_at(t, i == 20 ? first[k].north_m : 0, i == 20 ? first[k].up_m : 0);
				put_heading(t, 1);
			}
			if (put_imu(t, still, force))
				status = fuse_start_try(&start, false, &b);
		}
		assert_int_equal(status, FW_OK);
		assert_int_equal(b.stray_fixes, first[k].stray);
		assert_int_equal(b.pva.time.ns, noon.ns + (first[k].stray ? 400000000 : 200000000));
		near(b.pva.llh[0], place[0] + (first[k].stray ? 0 : first[k].north_m / 6.37e6), 1e-8);
		if (!first[k].stray)
			near(fmax(b.position_sd[0], b.position_sd[2]), 6, 0.02);
	}
}

static void test_given_and_unknown(void **state)
{
	fuse_start_setup s = drone();
	const double level[3] = {0, 0, 0}, still[3] = {0, 0, 0};
	double force[3], found[3];
	fuse_beginning b;
	(void)state;
	at_rest(level, force);
	for (int way = 0; way < 2; way++) {
		s.way = way == 0 ? FUSE_ALIGN_GIVEN : FUSE_ALIGN_AUTO;
		s.heading_rad = 2;
		assert_int_equal(fuse_start_begin(&start, &s), FW_OK);
		assert_string_equal(fuse_start_lacks(&start), "no IMU sample");
		for (int i = 1; i < 500; i++) {
			if (i == 100)
				assert_string_equal(fuse_start_lacks(&start), "no position");
			if (i >= 100 && i % 20 == 0)
				put_fix(i / 100.0, 0);
			put_imu(i / 100.0, still, force);
		}
		if (way ==
		    1) { /* nothing says where north is: a last try begins with a heading that may be any */
			assert_int_equal(fuse_start_try(&start, false, &b), FW_MORE);
			assert_string_equal(fuse_start_lacks(&start), "heading not found");
		}
		assert_int_equal(fuse_start_try(&start, way == 1, &b), FW_OK);
		fw_quat_to_euler(b.pva.q_n_b, found);
		if (way == 0)
			near(found[2], 2, 1e-3);
		assert_true(way == 0 ? b.heading_sd_rad < 0.2 : b.heading_sd_rad > 1.5);
	}
}

static int64_t last_ns;
static int n_early, n_items, n_readings;

static void early(void *unused, const fuse_entry *e)
{
	(void)unused;
	assert_false(e->is_imu);
	n_early++;
}

static void taken(void *unused, const fuse_entry *e)
{
	(void)unused;
	assert_true(fuse_entry_time(e).ns >= last_ns);
	last_ns = fuse_entry_time(e).ns;
	n_items += !e->is_imu;
	n_readings += e->is_imu;
}

/* What was kept comes back in order of time, from the beginning on; the oldest of too much is gone; bad readings are counted. */
static void test_kept(void **state)
{
	const fuse_start_setup s = drone();
	const double still[3] = {0, 0, 0}, level[3] = {0, 0, -9.81}, bad[3] = {0, (double)NAN, 0};
	enum { N = FUSE_START_READINGS + 1000 };
	(void)state;
	start.lost = 0;
	memset(start.refused, 0, sizeof start.refused);
	assert_int_equal(fuse_start_begin(&start, &s), FW_OK);
	for (int i = 1; i <= N; i++) {
		if (i % 100 == 0)
			put_fix(i / 100.0 - 0.002, 0);
		put_imu(i / 100.0, still, level);
	}
	put_imu(N / 100.0, still, level);
	put_imu(N / 100.0 - 1, still, level);
	put_imu(N / 100.0 + 1, bad, level);
	assert_int_equal(start.lost, 1000);
	assert_int_equal(start.refused[FW_REFUSED_DUPLICATE], 1);
	assert_int_equal(start.refused[FW_REFUSED_BACKWARDS], 1);
	assert_int_equal(start.refused[FW_REFUSED_NOT_FINITE], 1);
	last_ns = n_early = n_items = n_readings = 0;
	fuse_start_replay(&start, fw_time_add_ns(noon, 20 * FW_NS_PER_S), early, taken, NULL);
	assert_int_equal(n_readings, N - 2000);
	assert_int_equal(n_items + n_early, N / 100);
	assert_int_equal(n_early, 20);
	last_ns = n_readings = 0;
	fuse_start_replay(&start, noon, early, taken, NULL);
	assert_int_equal(n_readings, 0);
}

static void test_breaks(void **state)
{
	const fuse_start_setup s = drone();
	const double still[3] = {0, 0, 0}, level[3] = {0, 0, -9.81};
	fuse_entry e = {.is_imu = true, .imu.time = fw_time_add_ns(noon, 2 * FW_NS_PER_S)};
	(void)state;
	assert_int_equal(fuse_start_begin(&start, &s), FW_OK);
	assert_false(fuse_start_breaks(&start, &e));
	put_imu(0.5, still, level);
	assert_true(fuse_start_breaks(&start, &e));
	put_imu(1.2, still, level);
	assert_false(fuse_start_breaks(&start, &e));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_still),   cmocka_unit_test(test_carried_back),
	    cmocka_unit_test(test_outlier), cmocka_unit_test(test_given_and_unknown),
	    cmocka_unit_test(test_kept),    cmocka_unit_test(test_breaks),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
