/* imu_rates: the intervals are counted by hand. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "formats/imu_rates.h"

static fw_imu_rates rates;

static fw_status at_ms(int64_t ms, double *dt)
{
	return fw_imu_rates_interval(&rates, (fw_time){ms * 1000000}, dt);
}

static void intervals_are_those_of_the_stamps(void **state)
{
	double dt = -1;

	(void)state;
	rates = (fw_imu_rates){0};
	assert_int_equal(at_ms(1000, &dt), FW_MORE);
	assert_true(dt == -1);
	for (int i = 1; i < 50; i++) {
		assert_int_equal(at_ms(1000 + 5 * i + i % 2, &dt), FW_OK); /* a millisecond of jitter */
		assert_true(fabs(dt - (i % 2 ? 0.006 : 0.004)) < 1e-12 || i == 1);
	}
}

static void a_gap_takes_no_more_than_a_sample(void **state)
{
	double dt;

	(void)state;
	rates = (fw_imu_rates){0};
	for (int i = 0; i < 10; i++)
		(void)!at_ms(5 * i, &dt);
	assert_int_equal(at_ms(1045, &dt), FW_OK);
	assert_true(fabs(dt - 0.005) < 1e-12);
	assert_int_equal(at_ms(1050, &dt), FW_OK);
	assert_true(fabs(dt - 0.005) < 1e-12);
}

/* Wrong at first, but not for long. */
static void a_gap_at_the_beginning_is_found_out(void **state)
{
	double dt;

	(void)state;
	rates = (fw_imu_rates){0};
	(void)!at_ms(0, &dt);
	(void)!at_ms(1000, &dt);
	assert_int_equal(at_ms(1005, &dt), FW_OK);
	assert_true(fabs(dt - 0.005) < 1e-12);
	assert_int_equal(at_ms(2005, &dt), FW_OK);
	assert_true(fabs(dt - 0.005) < 1e-12);
}

static void a_new_rate_is_believed_in_the_end(void **state)
{
	double dt;

	(void)state;
	rates = (fw_imu_rates){0};
	for (int i = 0; i < 10; i++)
		(void)!at_ms(5 * i, &dt);
	for (int i = 1; i <= 5; i++)
		assert_int_equal(at_ms(45 + 20 * i, &dt), FW_OK);
	assert_true(fabs(dt - 0.020) < 1e-12);
}

static void time_has_to_advance(void **state)
{
	double dt = -1;

	(void)state;
	rates = (fw_imu_rates){0};
	(void)!at_ms(100, &dt);
	assert_int_equal(at_ms(100, &dt), FW_ERANGE);
	assert_int_equal(at_ms(50, &dt), FW_ERANGE);
	assert_true(dt == -1);
	assert_int_equal(at_ms(105, &dt), FW_OK);
	assert_true(fabs(dt - 0.005) < 1e-12);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(intervals_are_those_of_the_stamps),
	    cmocka_unit_test(a_gap_takes_no_more_than_a_sample),
	    cmocka_unit_test(a_gap_at_the_beginning_is_found_out),
	    cmocka_unit_test(a_new_rate_is_believed_in_the_end),
	    cmocka_unit_test(time_has_to_advance),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
