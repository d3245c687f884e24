/* Distributions that tests of hypotheses need: normal and chi-square, both tails, and their inverses.
 *
 * Each tail has its own function, since 1 - cdf has no digits left where integrity lives (alpha = 3.33e-7 and
 * below). Quantiles leave their output untouched when they fail (status < 0). */
#ifndef FURROW_BASE_STATS_H
#define FURROW_BASE_STATS_H

#include "base/status.h"

/* Degrees of freedom that the chi-square functions take: 1..FW_CHI2_DOF_MAX. */
#define FW_CHI2_DOF_MAX 1000

/* P(Z <= x) of the standard normal distribution. The upper tail P(Z > x) is fw_normal_cdf(-x), to full
 * relative precision. NaN gives NaN. */
double fw_normal_cdf(double x);

/* z with P(Z <= z) = p. For an upper tail alpha take -z(alpha).
 *   p  in   0 < p < 1
 *   z  out  relative error below 1e-15
 * Returns FW_OK or FW_EINVAL (NaN among the reasons).
 * Source: M. J. Wichura, Algorithm AS 241 (PPND16), Applied Statistics 37 (1988). */
fw_status fw_normal_quantile(double p, double *z) FW_MUST_CHECK;

/* Lower tail P(X <= x) and upper tail P(X > x) of the chi-square distribution, each to a relative precision
 * of 1e-12 as long as it does not underflow.
 *   x    in   NaN gives NaN; x <= 0 gives 0 and 1
 *   dof  in   degrees of freedom, 1..FW_CHI2_DOF_MAX (else NaN)
 * Source: Abramowitz and Stegun, 26.4.4, 26.4.5 (upper, finite sums) and 6.5.29 (lower, series). */
double fw_chi2_lower(double x, int dof);
double fw_chi2_upper(double x, int dof);

/* x with P(X <= x) = p (lower), or with P(X > x) = alpha (upper: the threshold of a test with that rate of
 * false alarms), by Newton's method from Wilson and Hilferty's approximation.
 *   p, alpha  in   inside (0, 1)
 *   dof       in   1..FW_CHI2_DOF_MAX
 *   x         out  relative error below 1e-12
 * Returns FW_OK, FW_EINVAL or FW_ENOCONV. */
fw_status fw_chi2_quantile_lower(double p, int dof, double *x) FW_MUST_CHECK;
fw_status fw_chi2_quantile_upper(double alpha, int dof, double *x) FW_MUST_CHECK;

#endif
