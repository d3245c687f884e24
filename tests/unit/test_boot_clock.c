/* boot_clock: clocks of known offset and drift, fixes of random latency: what comes back is what went in. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "base/random.h"
#include "formats/boot_clock.h"

#define LEAST_LATENCY 0.08

static fw_boot_clock boot;
static fw_random dice;

/* GPS time [ns] of a boot clock that was switched on at `on` and is `drift` too slow. */
static int64_t truth_ns(int64_t boot_us, double drift)
{
	const int64_t on = INT64_C(2300) * FW_NS_PER_WEEK + 123456789;

	return on + boot_us * 1000 + llround((double)boot_us * 1000 * drift);
}

/* A fix every 200 ms, its message 80 ms later or more. */
static void add_fix(int64_t boot_us, double drift)
{
	const double latency = LEAST_LATENCY - 0.03 * log(1 - fw_random_uniform(&dice));

	fw_boot_clock_add(&boot, boot_us, (fw_time){truth_ns(boot_us, drift) - llround(latency * 1e9)});
}

static double error_s(int64_t boot_us, double drift)
{
	fw_time t;

	assert_int_equal(fw_boot_clock_time(&boot, boot_us, LEAST_LATENCY, &t), FW_OK);
	return (double)(t.ns - truth_ns(boot_us, drift)) * 1e-9;
}

/* An hour, with the drift of a good quartz and of a bad clock. What comes before the first fix has a time
 * too. */
static void a_log_that_was_read_before_has_the_right_times(void **state)
{
	static const double drifts[] = {0, 20e-6, -20e-6, 209e-6};
	enum { START_S = 40, END_S = 3600 };

	(void)state;
	for (size_t k = 0; k < sizeof drifts / sizeof *drifts; k++) {
		double before = 0;

		fw_random_init(&dice, 1 + k);
		fw_boot_clock_begin(&boot);
		for (int64_t us = START_S * 1000000; us < END_S * INT64_C(1000000); us += 200000)
			add_fix(us, drifts[k]);
		fw_boot_clock_learn(&boot);
		for (int64_t us = 0; us < (END_S + 10) * INT64_C(1000000); us += 100000) {
			const double error = error_s(us, drifts[k]);

			assert_true(fabs(error) < 0.004);
			assert_true(us == 0 || fabs(error - before) < 1e-4 * 0.1 + 1e-9); /* no jumps */
			before = error;
		}
	}
}

static void in_turn_the_times_settle_after_some_seconds(void **state)
{
	fw_time t;

	(void)state;
	fw_random_init(&dice, 5);
	fw_boot_clock_begin(&boot);
	assert_int_equal(fw_boot_clock_time(&boot, 1, 0, &t), FW_MORE);
	for (int64_t us = 1000000; us < 600000000; us += 200000) {
		add_fix(us, -20e-6);
		if (us > 60000000)
			assert_true(fabs(error_s(us + 100000, -20e-6)) < 0.008);
	}
}

static void a_fix_of_another_time_is_passed_over(void **state)
{
	(void)state;
	fw_random_init(&dice, 7);
	fw_boot_clock_begin(&boot);
	for (int64_t us = 1000000; us < 100000000; us += 200000) {
		add_fix(us, 0);
		if (us % 5000000 == 0)
			fw_boot_clock_add(&boot, us, (fw_time){truth_ns(us, 0) + us * 100});
	}
	fw_boot_clock_learn(&boot);
	assert_true(boot.strays > 10);
	assert_true(fabs(error_s(50000000, 0)) < 0.004);
}

/* A receiver that learns of two leap seconds after 20 s. */
static void what_most_fixes_say_is_right(void **state)
{
	(void)state;
	fw_random_init(&dice, 8);
	fw_boot_clock_begin(&boot);
	for (int64_t us = 1000000; us < 20000000; us += 200000)
		fw_boot_clock_add(&boot, us, (fw_time){truth_ns(us, 0) - 2 * FW_NS_PER_S});
	for (int64_t us = 20000000; us < 100000000; us += 200000)
		add_fix(us, 0);
	fw_boot_clock_learn(&boot);
	assert_true(fabs(error_s(2000000, 0)) < 0.006);
	assert_true(fabs(error_s(90000000, 0)) < 0.004);
}

static void times_that_are_none_are_refused(void **state)
{
	fw_time t = {7};

	(void)state;
	fw_boot_clock_begin(&boot);
	fw_boot_clock_add(&boot, -1, (fw_time){truth_ns(0, 0)});
	fw_boot_clock_add(&boot, INT64_MAX, (fw_time){truth_ns(0, 0)});
	fw_boot_clock_add(&boot, 1, (fw_time){INT64_MAX});
	assert_int_equal(boot.pairs, 0);
	fw_boot_clock_add(&boot, 1, (fw_time){truth_ns(1, 0)});
	assert_int_equal(fw_boot_clock_time(&boot, -1, 0, &t), FW_ERANGE);
	assert_int_equal(fw_boot_clock_time(&boot, INT64_MAX, 0, &t), FW_ERANGE);
	assert_int_equal(fw_boot_clock_time(&boot, 1, (double)NAN, &t), FW_ERANGE);
	assert_int_equal(t.ns, 7);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(a_log_that_was_read_before_has_the_right_times),
	    cmocka_unit_test(in_turn_the_times_settle_after_some_seconds),
	    cmocka_unit_test(a_fix_of_another_time_is_passed_over),
	    cmocka_unit_test(what_most_fixes_say_is_right),
	    cmocka_unit_test(times_that_are_none_are_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
