/* stillness: a simulated industrial IMU that stands, is driven, stands; means and sigmas against plain
 * sums. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/random.h"
#include "ins/stillness.h"

static fw_time at(double seconds)
{
	return (fw_time){INT64_C(1450000000) * FW_NS_PER_S + llround(seconds * 1e9)};
}

static fw_stillness fresh(void)
{
	fw_stillness_setup setup = fw_stillness_defaults();
	fw_stillness s;

	assert_int_equal(fw_stillness_init(&setup, &s), FW_OK);
	return s;
}

/* Samples of an IMU at rest with noise, and with a shake on top when moving: 0.5 m/s^2 and 3 deg/s at 2
 * Hz. */
static void sample(fw_stillness *s, fw_random *r, double t, bool moving)
{
	double omega[3] = {0.002, -0.001, 0.003}, force[3] = {0.1, -0.2, -9.8};

	for (int i = 0; i < 3; i++) {
		omega[i] += 0.001 * fw_random_normal(r) + (moving ? 0.05 * sin(12.6 * t + i) : 0);
		force[i] += 0.02 * fw_random_normal(r) + (moving ? 0.5 * sin(12.6 * t + 2 * i) : 0);
	}
	assert_int_equal(fw_stillness_imu(s, at(t), omega, force), FW_OK);
}

/* Still until 10 s, moving until 20 s, still again: found with a window of delay, lost within a quarter. */
static void stands_drives_stands(int rate_hz)
{
	fw_stillness s = fresh();
	double found = 0, lost = 0, found_again = 0;
	fw_random r;

	fw_random_init(&r, (uint64_t)rate_hz);
	for (int i = 1; i <= 30 * rate_hz; i++) {
		double t = i / (double)rate_hz;

		sample(&s, &r, t, t > 10 && t <= 20);
		if (s.still && found == 0)
			found = t;
		if (!s.still && found > 0 && lost == 0)
			lost = t;
		if (s.still && lost > 0 && found_again == 0)
			found_again = t;
	}
	assert_true(s.still);
	assert_true(found >= 1 && found <= 1.3);
	assert_true(lost > 10 && lost <= 10.35);
	assert_true(found_again >= 20.8 && found_again <= 21.4);
	assert_true(fabs(fw_time_diff_s(s.since, at(20))) < 0.2);
}

static void rest_and_motion_are_told_apart_at_all_rates(void **state)
{
	static const int rates[] = {20, 50, 52, 100, 200, 400, 1000};

	(void)state;
	for (size_t i = 0; i < sizeof(rates) / sizeof(rates[0]); i++)
		stands_drives_stands(rates[i]);
}

/* Means over the stretch are those of the samples; motion at its end is not in them. */
static void means_leave_the_start_of_motion_out(void **state)
{
	fw_stillness s = fresh();
	fw_stillness_means m = {.seconds = -1};
	fw_random r;

	(void)state;
	fw_random_init(&r, 9);
	assert_int_equal(fw_stillness_averages(&s, &m), FW_MORE);
	assert_true(m.seconds < 0);
	for (int i = 1; i <= 2002; i++)
		sample(&s, &r, i / 100.0,
		       i > 2000); /* 20 s of rest, then the begin of a shake, not noticed yet */
	assert_int_equal(fw_stillness_averages(&s, &m), FW_OK);
	assert_true(m.seconds > 19.6 && m.seconds < 20);
	/* 0.001 / sqrt(2000) and 0.02 / sqrt(2000), four times */
	assert_true(fabs(m.omega_ib_b[0] - 0.002) < 9e-5 && fabs(m.omega_ib_b[2] - 0.003) < 9e-5);
	assert_true(fabs(m.force_b[1] + 0.2) < 2e-3 && fabs(m.force_b[2] + 9.8) < 2e-3);
	for (int i = 0; i < 3; i++) {
		assert_true(fabs(m.gyro_sd[i] / 0.001 - 1) < 0.08);
		assert_true(fabs(m.accel_sd[i] / 0.02 - 1) < 0.08);
	}
}

static void a_limit_is_harder_to_pass_going_in_than_going_out(void **state)
{
	fw_stillness_setup setup = fw_stillness_defaults();
	static const double force[3] = {0, 0, -9.80665};
	fw_stillness s = fresh();
	double rate[3] = {0, 0, setup.gyro_mean_radps * 1.5};

	(void)state;
	for (int i = 1; i <= 500; i++)
		assert_int_equal(fw_stillness_imu(&s, at(i * 0.01), rate, force), FW_OK);
	assert_false(s.still);
	rate[2] = 0;
	for (int i = 501; i <= 1000; i++)
		assert_int_equal(fw_stillness_imu(&s, at(i * 0.01), rate, force), FW_OK);
	assert_true(s.still);
	rate[2] = setup.gyro_mean_radps *
	          0.5; /* within the limit, but its change is a deviation for a moment: also within */
	for (int i = 1001; i <= 1500; i++) {
		assert_int_equal(fw_stillness_imu(&s, at(i * 0.01), rate, force), FW_OK);
	}
	assert_true(s.still);
	rate[2] = setup.gyro_mean_radps * 2.5;
	for (int i = 1501; i <= 1530; i++)
		assert_int_equal(fw_stillness_imu(&s, at(i * 0.01), rate, force), FW_OK);
	assert_false(s.still);
}

/* A train at constant speed: the IMU sees nothing, GNSS does. */
static void what_gnss_says_comes_first(void **state)
{
	static const double rate[3] = {0}, force[3] = {0, 0, -9.80665};
	fw_stillness s = fresh();

	(void)state;
	for (int i = 1; i <= 2000; i++) {
		double t = i * 0.01;

		assert_int_equal(fw_stillness_imu(&s, at(t), rate, force), FW_OK);
		if (i % 20 == 0 && t > 5 && t < 10)
			fw_stillness_speed(&s, at(t), 20, 0.1);
		if (i % 20 == 0 && t > 12) { /* these say nothing */
			fw_stillness_speed(&s, at(t), 0.2, 0.05);
			fw_stillness_speed(&s, at(t), 2, 1);
			fw_stillness_speed(&s, at(t), (double)NAN, 1);
			fw_stillness_speed(&s, at(t), 5, -1);
		}
		assert_int_equal(s.still, (t >= 0.01 + 1.13 && t < 5.2) || t >= 11.5 ? 1 : s.still);
		if (t > 5.2 && t < 11.3)
			assert_false(s.still);
	}
	assert_true(s.still);
}

static void a_gap_begins_anew_and_nonsense_is_refused(void **state)
{
	static const double rate[3] = {0}, force[3] = {0, 0, -9.80665}, bad[3] = {0, (double)NAN, 0};
	fw_stillness_setup setup = fw_stillness_defaults();
	fw_stillness s = fresh();

	(void)state;
	for (int i = 1; i <= 300; i++)
		assert_int_equal(fw_stillness_imu(&s, at(i * 0.01), rate, force), FW_OK);
	assert_true(s.still);
	assert_int_equal(fw_stillness_imu(&s, at(3), rate, force), FW_EINVAL);
	assert_int_equal(fw_stillness_imu(&s, at(2), rate, force), FW_EINVAL);
	assert_int_equal(fw_stillness_imu(&s, at(3.01), bad, force), FW_ENONFINITE);
	assert_int_equal(fw_stillness_imu(&s, at(3.01), rate, bad), FW_ENONFINITE);
	assert_int_equal(fw_stillness_imu(&s, at(3.01), rate, force), FW_OK);
	assert_true(s.still);
	assert_int_equal(fw_stillness_imu(&s, at(4), rate, force), FW_OK);
	assert_false(s.still);
	setup.window_s = 0;
	assert_int_equal(fw_stillness_init(&setup, &s), FW_EINVAL);
	setup = fw_stillness_defaults();
	setup.leave = (double)NAN;
	assert_int_equal(fw_stillness_init(&setup, &s), FW_EINVAL);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(rest_and_motion_are_told_apart_at_all_rates),
	    cmocka_unit_test(means_leave_the_start_of_motion_out),
	    cmocka_unit_test(a_limit_is_harder_to_pass_going_in_than_going_out),
	    cmocka_unit_test(what_gnss_says_comes_first),
	    cmocka_unit_test(a_gap_begins_anew_and_nonsense_is_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
