#include "base/summary.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

static void assert_near(double have, double want)
{
	if (!(fabs(have - want) <= 1e-14 * fmax(1, fabs(want))))
		fail_msg("%.17g, not %.17g", have, want);
}

/* numpy.quantile */
static void quantiles_are_numpys(void **state)
{
	const double sorted[] = {1, 2, 4, 8, 16};

	(void)state;
	assert_near(fw_quantile(5, sorted, 0), 1);
	assert_near(fw_quantile(5, sorted, 0.1), 1.4);
	assert_near(fw_quantile(5, sorted, 0.5), 4);
	assert_near(fw_quantile(5, sorted, 0.95), 14.4);
	assert_near(fw_quantile(5, sorted, 1), 16);
	assert_near(fw_quantile(1, sorted, 0.3), 1);
}

static void quantile_of_nothing_is_nan(void **state)
{
	const double sorted[] = {1, 2};

	(void)state;
	assert_true(isnan(fw_quantile(0, sorted, 0.5)));
	assert_true(isnan(fw_quantile(2, sorted, -0.1)));
	assert_true(isnan(fw_quantile(2, sorted, 1.1)));
	assert_true(isnan(fw_quantile(2, sorted, nan(""))));
}

/* numpy: mean, sqrt(mean(v^2)), percentile(abs(v), ...), abs(v).max() */
static void summary_is_numpys(void **state)
{
	double v[] = {0.5, -1.25, 2.0, -0.1, 3.75, -4.5, 0.0, 1.5, -2.25, 0.8};
	fw_summary s;

	(void)state;
	assert_int_equal(fw_summarise(10, v, &s), FW_OK);
	assert_int_equal(s.n, 10);
	assert_near(s.mean, 0.045);
	assert_near(s.rms, 2.192886225958839);
	assert_near(s.p50, 1.375);
	assert_near(s.p68, 2.03);
	assert_near(s.p95, 4.1625);
	assert_near(s.p99, 4.4325);
	assert_near(s.max, 4.5);
	for (int i = 1; i < 10; i++)
		assert_true(v[i - 1] <= v[i]); /* left behind in order */
}

static void summary_of_one(void **state)
{
	double v[] = {-3};
	fw_summary s;

	(void)state;
	assert_int_equal(fw_summarise(1, v, &s), FW_OK);
	assert_true(s.mean == -3 && s.rms == 3 && s.p50 == 3 && s.p99 == 3 && s.max == 3);
}

static void summary_refuses(void **state)
{
	double v[] = {-3, nan(""), 2}, w[] = {-3, (double)INFINITY};
	fw_summary s = {.n = 99};

	(void)state;
	assert_int_equal(fw_summarise(0, v, &s), FW_EINVAL);
	assert_int_equal(fw_summarise(3, v, &s), FW_ENONFINITE);
	assert_int_equal(fw_summarise(2, w, &s), FW_ENONFINITE);
	assert_true(s.n == 99 && v[0] == -3 && v[2] == 2 && w[0] == -3);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(quantiles_are_numpys), cmocka_unit_test(quantile_of_nothing_is_nan),
	    cmocka_unit_test(summary_is_numpys),    cmocka_unit_test(summary_of_one),
	    cmocka_unit_test(summary_refuses),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
