/* stats: expected values from mpmath (40 digits; ncdf, gammainc and their roots) unless said otherwise. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "base/stats.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

static void assert_relative(double actual, double expected, double tolerance)
{
	if (!(fabs(actual - expected) <= tolerance * fabs(expected)))
		fail_msg("%.17g is not %.17g", actual, expected);
}

static void normal_cdf_is_right_in_both_tails(void **state)
{
	static const struct {
		double x, p;
	} cases[] = {
	    {-38, 2.8854283600687843e-316}, /* a subnormal number: fewer digits */
	    {-8, 6.2209605742717841e-16},
	    {-6.18, 3.2050800813734157e-10},
	    {-5.33, 4.9106383331285318e-8},
	    {-3, 0.0013498980316300945},
	    {-1, 0.15865525393145705},
	    {-0.1, 0.46017216272297102},
	    {0, 0.5},
	    {0.5, 0.6914624612740131},
	    {2, 0.97724986805182079},
	    {6, 0.99999999901341235},
	};

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++)
		assert_relative(fw_normal_cdf(cases[i].x), cases[i].p, i == 0 ? 1e-7 : 1e-14);
	assert_true(fw_normal_cdf(-HUGE_VAL) == 0 && fw_normal_cdf(HUGE_VAL) == 1);
	assert_true(isnan(fw_normal_cdf(nan(""))));
}

static void normal_quantile_is_right_in_every_branch(void **state)
{
	static const struct {
		double p, z;
	} cases[] = {
	    {1e-300, -37.047096299361199},   {1e-20, -9.2623400897984076}, {1e-09, -5.9978070150076869},
	    {3.33e-07, -4.9710245927695215}, {0.001, -3.0902323061678135}, {0.025, -1.9599639845400542},
	    {0.07, -1.4757910281791707},     {0.075, -1.4395314709384559}, {0.3, -0.52440051270804082},
	    {0.6, 0.25334710313579974},      {0.93, 1.4757910281791711},   {0.975, 1.9599639845400539},
	    {0.999999, 4.7534243088170878},
	};
	double z;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		assert_int_equal(fw_normal_quantile(cases[i].p, &z), FW_OK);
		assert_relative(z, cases[i].z, 1e-15);
	}
	assert_int_equal(fw_normal_quantile(0.5, &z), FW_OK);
	assert_true(z == 0);
}

static void normal_quantile_refuses_what_is_no_probability(void **state)
{
	const double bad[] = {0, 1, -0.1, 1.1, nan("")};
	double z = 7;

	(void)state;
	for (size_t i = 0; i < COUNT(bad); i++)
		assert_int_equal(fw_normal_quantile(bad[i], &z), FW_EINVAL);
	assert_true(z == 7);
}

static void chi2_tails_keep_their_digits(void **state)
{
	static const struct {
		int dof;
		double x, lower, upper;
	} cases[] = {
	    {1, 0.001, 0.025227120630039612, 0.97477287936996039},
	    {1, 26, 0.99999965858264227, 3.4141735772975276e-7},
	    {2, 5, 0.9179150013761012, 0.082084998623898795},
	    {3, 1, 0.1987480430987992, 0.8012519569012008},
	    {3, 40, 0.99999998934490967, 1.0655090334255861e-8},
	    {4, 1e-05, 1.249995833341146e-11, 0.99999999998750004},
	    {5, 5, 0.58411981300449208, 0.41588018699550792},
	    {7, 6.9, 0.56063433957637189, 0.43936566042362811},
	    {8, 200, 1.0, 6.3898877022382161e-39},
	    {20, 3, 4.0975009763948429e-6, 0.99999590249902361},
	    {20, 45, 0.99889653075697165, 0.0011034692430283502},
	    {20, 68, 0.99999961502426561, 3.8497573439485936e-7},
	    {99, 100, 0.54704148867906863, 0.45295851132093137},
	    {100, 40, 1.2458926079719379e-8, 0.99999998754107392},
	    {500, 700, 0.99999999227100789, 7.7289921112166518e-9},
	    {1000, 900, 0.010717238091289742, 0.98928276190871026},
	    {1000, 1100, 0.98538559187370481, 0.014614408126295194},
	    {1, 1400, 1.0, 2.1010145162642175e-306},
	};

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		assert_relative(fw_chi2_lower(cases[i].x, cases[i].dof), cases[i].lower, 1e-12);
		assert_relative(fw_chi2_upper(cases[i].x, cases[i].dof), cases[i].upper, 1e-12);
	}
}

static void chi2_is_defined_at_the_edges(void **state)
{
	(void)state;
	assert_true(fw_chi2_lower(0, 3) == 0 && fw_chi2_upper(0, 3) == 1);
	assert_true(fw_chi2_lower(-1, 3) == 0 && fw_chi2_upper(-1, 3) == 1);
	assert_true(fw_chi2_lower(HUGE_VAL, 3) == 1 && fw_chi2_upper(HUGE_VAL, 3) == 0);
	assert_true(isnan(fw_chi2_lower(nan(""), 3)) && isnan(fw_chi2_upper(nan(""), 3)));
	assert_true(isnan(fw_chi2_lower(1, 0)) && isnan(fw_chi2_upper(1, FW_CHI2_DOF_MAX + 1)));
}

/* Rows of the tables that receiver autonomous integrity monitoring is published with: three decimals. */
static void chi2_thresholds_agree_with_the_tables(void **state)
{
	static const int dof[] = {1, 2, 3, 4, 5, 6, 8, 10, 15, 20};
	static const struct {
		double alpha, threshold[10];
	} rows[] = {
	    {0.001, {10.828, 13.816, 16.266, 18.467, 20.515, 22.458, 26.124, 29.588, 37.697, 45.315}},
	    {1.0 / 15000, {15.903, 19.232, 21.955, 24.391, 26.652, 28.790, 32.809, 36.588, 45.381, 53.584}},
	    {3.33e-7, {26.048, 29.830, 32.931, 35.703, 38.270, 40.692, 45.229, 49.477, 59.297, 68.389}},
	};
	double x;

	(void)state;
	for (size_t i = 0; i < COUNT(rows); i++)
		for (size_t k = 0; k < COUNT(dof); k++) {
			assert_int_equal(fw_chi2_quantile_upper(rows[i].alpha, dof[k], &x), FW_OK);
			assert_true(fabs(x - rows[i].threshold[k]) < 0.00051);
		}
}

static void chi2_upper_quantiles_are_right(void **state)
{
	static const struct {
		double alpha;
		int dof;
		double x;
	} cases[] = {
	    {0.001, 1, 10.827566170662732},     {0.001, 2, 13.815510557964274},
	    {0.001, 3, 16.266236196238131},     {0.001, 10, 29.588298445074419},
	    {0.001, 31, 61.09830608105812},     {0.001, 64, 104.71632526304058},
	    {3.33e-07, 1, 26.048195132751594},  {3.33e-07, 2, 29.830246693931935},
	    {3.33e-07, 3, 32.931267184159275},  {3.33e-07, 10, 49.477053548314039},
	    {3.33e-07, 31, 86.920542835095462}, {3.33e-07, 64, 136.77504896698077},
	    {1e-12, 1, 50.844127911818156},     {1e-12, 2, 55.262042231857096},
	    {1e-12, 3, 58.919755683202153},     {1e-12, 10, 78.471646562838481},
	    {1e-12, 31, 121.91359005017611},    {1e-12, 64, 178.32229468555989},
	};
	double x;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		assert_int_equal(fw_chi2_quantile_upper(cases[i].alpha, cases[i].dof, &x), FW_OK);
		assert_relative(x, cases[i].x, 1e-12);
	}
}

static void chi2_lower_quantiles_are_right(void **state)
{
	static const struct {
		double p;
		int dof;
		double x;
	} cases[] = {
	    {1e-10, 1, 1.5707963267948967e-20}, {1e-10, 2, 2.0000000001000001e-10},
	    {1e-10, 5, 0.00032335571462496935}, {1e-10, 40, 6.0649346306151253},
	    {0.001, 1, 1.5707971492624899e-6},  {0.001, 2, 0.002001000667167067},
	    {0.001, 5, 0.21021260262921917},    {0.001, 40, 17.916426535252026},
	    {0.4, 1, 0.27499589772845608},      {0.4, 2, 1.0216512475319814},
	    {0.4, 5, 3.655499623141586},        {0.4, 40, 37.133959479084619},
	    {0.6, 1, 0.70832630080079374},      {0.6, 2, 1.83258146374831},
	    {0.6, 5, 5.1318670744018214},       {0.6, 40, 41.622192885586724},
	    {0.9999, 1, 15.136705226623605},    {0.9999, 2, 18.420680743952586},
	    {0.9999, 5, 25.744831959056122},    {0.9999, 40, 82.06229383534456},
	};
	double x;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		assert_int_equal(fw_chi2_quantile_lower(cases[i].p, cases[i].dof, &x), FW_OK);
		assert_relative(x, cases[i].x, 1e-12);
	}
}

/* Every order, every decade of the tail: the quantile leads back to its probability. */
static void chi2_quantiles_invert_the_tails(void **state)
{
	double x;

	(void)state;
	for (int dof = 1; dof <= FW_CHI2_DOF_MAX; dof += dof < 70 ? 1 : 93)
		for (double tail = 0.9; tail > 1e-60; tail *= 0.03) {
			assert_int_equal(fw_chi2_quantile_upper(tail, dof, &x), FW_OK);
			assert_relative(fw_chi2_upper(x, dof), tail, 1e-10);
			assert_int_equal(fw_chi2_quantile_lower(tail, dof, &x), FW_OK);
			assert_relative(fw_chi2_lower(x, dof), tail, 1e-10);
		}
}

static void chi2_quantile_refuses_bad_arguments(void **state)
{
	double x = 7;

	(void)state;
	assert_int_equal(fw_chi2_quantile_upper(0, 3, &x), FW_EINVAL);
	assert_int_equal(fw_chi2_quantile_upper(1, 3, &x), FW_EINVAL);
	assert_int_equal(fw_chi2_quantile_upper(nan(""), 3, &x), FW_EINVAL);
	assert_int_equal(fw_chi2_quantile_lower(0.5, 0, &x), FW_EINVAL);
	assert_int_equal(fw_chi2_quantile_lower(0.5, FW_CHI2_DOF_MAX + 1, &x), FW_EINVAL);
	assert_int_equal(fw_chi2_quantile_lower(1e-200, 1, &x),
	                 FW_ENOCONV); /* x = 1.6e-400: no such double */
	assert_true(x == 7);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(normal_cdf_is_right_in_both_tails),
	    cmocka_unit_test(normal_quantile_is_right_in_every_branch),
	    cmocka_unit_test(normal_quantile_refuses_what_is_no_probability),
	    cmocka_unit_test(chi2_tails_keep_their_digits),
	    cmocka_unit_test(chi2_is_defined_at_the_edges),
	    cmocka_unit_test(chi2_thresholds_agree_with_the_tables),
	    cmocka_unit_test(chi2_upper_quantiles_are_right),
	    cmocka_unit_test(chi2_lower_quantiles_are_right),
	    cmocka_unit_test(chi2_quantiles_invert_the_tails),
	    cmocka_unit_test(chi2_quantile_refuses_bad_arguments),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
