/* Gauss-Markov processes: moments of long runs against the autocorrelations that define them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "sim/process.h"

enum { RUN = 400000 };

/* Expected: R(0) = sd^2 = 4, R(tau) = 4 / e. With 20,000 correlation times the estimates scatter by about 1
 * %. */
static void test_first_order(void **state)
{
	(void)state;
	fw_random r;
	fw_gm1 p;
	double history[20] = {0}, variance = 0, lagged = 0;
	fw_random_init(&r, 1);
	fw_gm1_init(&p, 2, &r);
	for (int i = 0; i < RUN; i++) {
		fw_gm1_step(&p, 2, 10, 0.5, &r);
		variance += p.value * p.value / RUN;
		lagged += p.value * history[i % 20] / RUN;
		history[i % 20] = p.value;
	}
	assert_true(fabs(variance - 4) < 0.2);
	assert_true(fabs(lagged - 4 * exp(-1)) < 0.2);
}

/* tau 0: white, whatever the step. */
static void test_white(void **state)
{
	(void)state;
	fw_random r;
	fw_gm1 p;
	double variance = 0, lagged = 0, last = 0;
	fw_random_init(&r, 2);
	fw_gm1_init(&p, 3, &r);
	for (int i = 0; i < RUN; i++) {
		fw_gm1_step(&p, 3, 0, 0.2, &r);
		variance += p.value * p.value / RUN;
		lagged += p.value * last / RUN;
		last = p.value;
	}
	assert_true(fabs(variance - 9) < 0.1);
	assert_true(fabs(lagged) < 0.1);
}

/* Expected: R(tau) = sd^2 2 / e, rate of standard deviation sd / tau, value and rate uncorrelated. */
static void test_second_order(void **state)
{
	(void)state;
	fw_random r;
	fw_gm2 p;
	double history[20] = {0}, variance = 0, lagged = 0, rates = 0, mixed = 0;
	fw_random_init(&r, 3);
	fw_gm2_init(&p, 2, 10, &r);
	for (int i = 0; i < RUN; i++) {
		fw_gm2_step(&p, 2, 10, 0.5, &r);
		variance += p.value * p.value / RUN;
		rates += p.rate * p.rate / RUN;
		mixed += p.value * p.rate / RUN;
		lagged += p.value * history[i % 20] / RUN;
		history[i % 20] = p.value;
	}
	assert_true(fabs(variance - 4) < 0.25);
	assert_true(fabs(rates - 0.04) < 0.002);
	assert_true(fabs(mixed) < 0.01);
	assert_true(fabs(lagged - 4 * 2 * exp(-1)) < 0.25);
}

/* The rate is the derivative: a step is its integral, up to what is random within the step. */
static void test_rate_is_derivative(void **state)
{
	(void)state;
	fw_random r;
	fw_gm2 p;
	fw_random_init(&r, 4);
	fw_gm2_init(&p, 1, 100, &r);
	for (int i = 0; i < 1000; i++) {
		fw_gm2 before = p;
		fw_gm2_step(&p, 1, 100, 0.01, &r);
		/* within a step the rate wanders by sqrt(4 dt / tau^3) = 2e-4, its integral by that times
		 * dt / sqrt(12) */
		assert_true(fabs(p.value - before.value - 0.005 * (before.rate + p.rate)) < 6 * 5.8e-7);
	}
}

/* One long step is as good as many short ones: its variance stays. */
static void test_long_step(void **state)
{
	(void)state;
	fw_random r;
	fw_gm2 p;
	double variance = 0;
	fw_random_init(&r, 5);
	fw_gm2_init(&p, 2, 1, &r);
	for (int i = 0; i < RUN; i++) {
		fw_gm2_step(&p, 2, 1, 50, &r);
		variance += p.value * p.value / RUN;
	}
	assert_true(fabs(variance - 4) < 0.1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_first_order),  cmocka_unit_test(test_white),
	    cmocka_unit_test(test_second_order), cmocka_unit_test(test_rate_is_derivative),
	    cmocka_unit_test(test_long_step),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
