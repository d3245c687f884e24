#include "base/stats.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

double fw_normal_cdf(double x)
{
	return 0.5 * erfc(-x * M_SQRT1_2);
}

/* AS 241: numerators and denominators, lowest power first, for the centre, the tails and the far tails. */
static const double centre[2][8] = {
    {3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3, 1.3731693765509461125e4,
     4.5921953931549871457e4, 6.7265770927008700853e4, 3.3430575583588128105e4, 2.5090809287301226727e3},
    {1.0, 4.2313330701600911252e1, 6.8718700749205790830e2, 5.3941960214247511077e3, 2.1213794301586595867e4,
     3.9307895800092710610e4, 2.8729085735721942674e4, 5.2264952788528545610e3},
};
static const double tails[2][8] = {
    {1.42343711074968357734e0, 4.63033784615654529590e0, 5.76949722146069140550e0, 3.64784832476320460504e0,
     1.27045825245236838258e0, 2.41780725177450611770e-1, 2.27238449892691845833e-2,
     7.74545014278341407640e-4},
    {1.0, 2.05319162663775882187e0, 1.67638483018380384940e0, 6.89767334985100004550e-1,
     1.48103976427480074590e-1, 1.51986665636164571966e-2, 5.47593808499534494600e-4,
     1.05075007164441684324e-9},
};
static const double far_tails[2][8] = {
    {6.65790464350110377720e0, 5.46378491116411436990e0, 1.78482653991729133580e0, 2.96560571828504891230e-1,
     2.65321895265761230930e-2, 1.24266094738807843860e-3, 2.71155556874348757815e-5,
     2.01033439929228813265e-7},
    {1.0, 5.99832206555887937690e-1, 1.36929880922735805310e-1, 1.48753612908506148525e-2,
     7.86869131145613259100e-4, 1.84631831751005468180e-5, 1.42151175831644588870e-7,
     2.04426310338993978564e-15},
};

static double ratio(const double c[2][8], double r)
{
	double above = 0, below = 0;

	for (int i = 7; i >= 0; i--) {
		above = above * r + c[0][i];
		below = below * r + c[1][i];
	}
	return above / below;
}

/* AS 241 itself, for 0 < p < 1. */
static double quantile(double p)
{
	double q = p - 0.5;
	double r;

	if (fabs(q) <= 0.425)
		return q * ratio(centre, 0.180625 - q * q);
	r = sqrt(-log(q < 0 ? p : 1 - p));
	return copysign(r <= 5 ? ratio(tails, r - 1.6) : ratio(far_tails, r - 5), q);
}

fw_status fw_normal_quantile(double p, double *z)
{
	if (!(p > 0 && p < 1))
		return FW_EINVAL;
	*z = quantile(p);
	return FW_OK;
}

/* y^a e^-y / Gamma(a + 1): what both tails are sums of. */
static double term(double a, double y)
{
	int sign;

	return exp(a * log(y) - y - lgamma_r(a + 1, &sign));
}

/* P(a, y) = term(a) (1 + y/(a+1) + y^2/((a+1)(a+2)) + ...): all positive, quick for y < a + 1. */
static double lower_series(double a, double y)
{
	double add = 1, sum = 1;

	for (double k = a + 1; add > sum * DBL_EPSILON / 4; k++) {
		add *= y / k;
		sum += add;
	}
	return term(a, y) * sum;
}

/* Q(a, y) = Q(a - 1, y) + term(a - 1), down to Q(1/2) = erfc(sqrt y) or Q(1) = e^-y. */
static double upper_sum(double a, double y)
{
	double sum = 0;
	double add = term(a - 1, y);
	double k = a - 1;

	for (; k >= 0.5; k--) {
		sum += add;
		add *= k / y;
	}
	return sum + (k < 0 ? erfc(sqrt(y)) : exp(-y));
}

static bool dof_is_good(int dof)
{
	return dof >= 1 && dof <= FW_CHI2_DOF_MAX;
}

double fw_chi2_lower(double x, int dof)
{
	double a = 0.5 * dof, y = 0.5 * x;

	if (isnan(x) || !dof_is_good(dof))
		return nan("");
	if (x <= 0)
		return 0;
	return y < a + 1 ? lower_series(a, y) : 1 - fw_chi2_upper(x, dof);
}

double fw_chi2_upper(double x, int dof)
{
	double a = 0.5 * dof, y = 0.5 * x;

	if (isnan(x) || !dof_is_good(dof))
		return nan("");
	if (x <= 0)
		return 1;
	if (isinf(x))
		return 0;
	return y < a + 1 ? 1 - lower_series(a, y) : upper_sum(a, y);
}

/* Wilson and Hilferty: the cube root of chi-square / dof is nearly normal. */
static double chi2_start(double tail, int dof, bool upper)
{
	double spread = 2.0 / (9.0 * dof);
	double z = upper ? -quantile(tail) : quantile(tail);
	double root = 1 - spread + z * sqrt(spread);

	return fmax(dof * root * root * root, 1e-3);
}

/* Newton on ln(tail) against ln(x): both tails are concave there, so the steps cannot oscillate. */
static fw_status chi2_solve(double tail, int dof, bool upper, double *x)
{
	double try = chi2_start(tail, dof, upper);

	for (int i = 0; i < 50; i++) {
		double have = upper ? fw_chi2_upper(try, dof) : fw_chi2_lower(try, dof);
		double slope = 0.5 * dof * term(0.5 * dof, 0.5 * try) / have;
		double step = log(have / tail) / (upper ? slope : -slope);

		try *= exp(step);
		if (fabs(step) < 1e-12) {
			*x = try;
			return FW_OK;
		}
	}
	return FW_ENOCONV;
}

/* 1 - p is exact for p >= 1/2: either tail can be asked for through the smaller one. */
static fw_status chi2_quantile(double tail, int dof, bool upper, double *x)
{
	if (!(tail > 0 && tail < 1) || !dof_is_good(dof))
		return FW_EINVAL;
	return tail > 0.5 ? chi2_solve(1 - tail, dof, !upper, x) : chi2_solve(tail, dof, upper, x);
}

fw_status fw_chi2_quantile_lower(double p, int dof, double *x)
{
	return chi2_quantile(p, dof, false, x);
}

fw_status fw_chi2_quantile_upper(double alpha, int dof, double *x)
{
	return chi2_quantile(alpha, dof, true, x);
}
