/* random: sequences against published vectors and a Python model, distributions against their definition. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "base/random.h"
#include "base/stats.h"

/* xoshiro256plusplus.c of https://prng.di.unimi.it started from {1, 2, 3, 4}, as published with its ports. */
static void generator_gives_the_published_sequence(void **state)
{
	static const uint64_t expected[] = {
	    41943041,
	    58720359,
	    3588806011781223,
	    3591011842654386,
	    UINT64_C(9228616714210784205),
	    UINT64_C(9973669472204895162),
	    UINT64_C(14011001112246962877),
	    UINT64_C(12406186145184390807),
	    UINT64_C(15849039046786891736),
	    UINT64_C(10450023813501588000),
	};
	fw_random r = {{1, 2, 3, 4}};

	(void)state;
	for (size_t i = 0; i < sizeof(expected) / sizeof(expected[0]); i++)
		assert_true(fw_random_u64(&r) == expected[i]);
}

/* splitmix64.c from 1234567: the first numbers of the published test vector. */
static void seed_is_spread_by_splitmix(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 1234567);
	assert_true(r.s[0] == UINT64_C(6457827717110365317));
	assert_true(r.s[1] == UINT64_C(3203168211198807973));
	assert_true(r.s[2] == UINT64_C(9817491932198370423));
	assert_true(r.s[3] == UINT64_C(4593380528125082431));
}

/* From here on: a model of the two algorithms in Python integers. */
static void seeds_give_the_sequences_of_the_model(void **state)
{
	static const struct {
		uint64_t seed, first[3];
	} cases[] = {
	    {0, {0x53175d61490b23df, 0x61da6f3dc380d507, 0x5c0fdf91ec9a7bfc}},
	    {42, {0xd0764d4f4476689f, 0x519e4174576f3791, 0xfbe07cfb0c24ed8c}},
	    {UINT64_MAX, {0x56ccf8ce948e27b2, 0xe68588432e5a5b90, 0xe3e9b5a48119ca8b}},
	};

	(void)state;
	for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
		fw_random r;

		fw_random_init(&r, cases[i].seed);
		for (int k = 0; k < 3; k++)
			assert_true(fw_random_u64(&r) == cases[i].first[k]);
	}
}

static void uniform_gives_the_doubles_of_the_model(void **state)
{
	static const double expected[] = {0.8143051451229099, 0.3188210400616611, 0.9838941681774888,
	                                  0.7011355981347556};
	fw_random r;

	(void)state;
	fw_random_init(&r, 42);
	for (int i = 0; i < 4; i++)
		assert_true(fw_random_uniform(&r) == expected[i]);
}

static void uniform_fills_the_interval_evenly(void **state)
{
	enum { N = 100000, BINS = 100 };
	int count[BINS] = {0};
	double chi2 = 0;
	fw_random r;

	(void)state;
	fw_random_init(&r, 1);
	for (int i = 0; i < N; i++) {
		double u = fw_random_uniform(&r);

		assert_true(u >= 0 && u < 1);
		count[(int)(u * BINS)]++;
	}
	for (int i = 0; i < BINS; i++)
		chi2 += pow(count[i] - N / BINS, 2) / (N / BINS);
	assert_true(fw_chi2_upper(chi2, BINS - 1) > 1e-4 && fw_chi2_lower(chi2, BINS - 1) > 1e-4);
}

static void below_gives_the_integers_of_the_model(void **state)
{
	static const struct {
		uint64_t n, expected;
	} cases[] = {
	    {6, 1},
	    {1000, 753},
	    {UINT64_C(9223372036854775809), UINT64_C(8926271879130705291)},
	    {UINT64_C(9223372036854775809), UINT64_C(3710296902904329655)},
	    {7, 2},
	};
	fw_random r;

	(void)state;
	fw_random_init(&r, 42);
	for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
		assert_true(fw_random_below(&r, cases[i].n) == cases[i].expected);
	assert_true(fw_random_below(&r, 1) == 0);
}

/* n = 3 * 2^62 would meet the lowest third twice as often if the remainder alone were taken. */
static void below_has_no_bias(void **state)
{
	const uint64_t third = UINT64_C(1) << 62;
	int count[3] = {0};
	fw_random r;

	(void)state;
	fw_random_init(&r, 2);
	for (int i = 0; i < 30000; i++)
		count[fw_random_below(&r, 3 * third) / third]++;
	for (int i = 0; i < 3; i++)
		assert_true(abs(count[i] - 10000) < 350); /* 4 sigma = 327 */
}

/* Expected: the polar method in mpmath, 40 digits. */
static void normal_gives_the_deviates_of_the_model(void **state)
{
	static const double expected[] = {0.98139839007249853, 1.3403256427520228, -0.96422050629413833,
	                                  0.19622652967452662, 0.20290854483035598};
	fw_random r;
	double z = 0;

	(void)state;
	fw_random_init(&r, 42);
	for (int i = 0; i < 5; i++)
		assert_true(fabs(fw_random_normal(&r) - expected[i]) < 4e-15);
	fw_random_init(&r, 7);
	for (int i = 0; i < 100000; i++)
		z = fw_random_normal(&r);
	assert_true(fabs(z - 0.66003800912427158) < 4e-15);
}

/* Kolmogorov-Smirnov against the normal cdf over bins of equal probability, and the first four moments. */
static void normal_is_normal(void **state)
{
	enum { N = 200000, BINS = 1000 };
	static int count[BINS];
	double m[5] = {0};
	double sum = 0, worst = 0;
	fw_random r;

	(void)state;
	fw_random_init(&r, 3);
	for (int i = 0; i < N; i++) {
		double z = fw_random_normal(&r);

		for (int k = 1; k <= 4; k++)
			m[k] += pow(z, k) / N;
		count[(int)(fw_normal_cdf(z) * BINS)]++;
	}
	assert_true(fabs(m[1]) < 4 / sqrt(N)); /* 4 sigma of each moment */
	assert_true(fabs(m[2] - 1) < 4 * sqrt(2.0 / N));
	assert_true(fabs(m[3]) < 4 * sqrt(15.0 / N));
	assert_true(fabs(m[4] - 3) < 4 * sqrt(96.0 / N));
	for (int i = 0; i < BINS; i++) {
		sum += count[i];
		worst = fmax(worst, fabs(sum / N - (i + 1.0) / BINS));
	}
	assert_true(worst < 1.95 / sqrt(N)); /* alpha = 0.001 */
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(generator_gives_the_published_sequence),
	    cmocka_unit_test(seed_is_spread_by_splitmix),
	    cmocka_unit_test(seeds_give_the_sequences_of_the_model),
	    cmocka_unit_test(uniform_gives_the_doubles_of_the_model),
	    cmocka_unit_test(uniform_fills_the_interval_evenly),
	    cmocka_unit_test(below_gives_the_integers_of_the_model),
	    cmocka_unit_test(below_has_no_bias),
	    cmocka_unit_test(normal_gives_the_deviates_of_the_model),
	    cmocka_unit_test(normal_is_normal),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
