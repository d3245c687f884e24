/* What a set of errors comes to: mean, root mean square, quantiles. */
#ifndef FURROW_BASE_SUMMARY_H
#define FURROW_BASE_SUMMARY_H

#include <stddef.h>

#include "base/status.h"

typedef struct {
	size_t n;
	double mean; /* of the values with their signs; all else is of their magnitudes */
	double rms;
	double p50, p68, p95, p99; /* magnitude that 50, 68, 95, 99 % of them do not exceed */
	double max;
} fw_summary;

/* The p-quantile of n values sorted in ascending order: the value at place p (n - 1), counted from 0, linear between two
 * places.
 *   n       in  at least 1
 *   p       in  0..1
 * Returns NaN for n = 0 or any other p.
 * Source: R. J. Hyndman, Y. Fan, "Sample quantiles in statistical packages", The American Statistician 50 (1996),
 * definition 7 (the one of numpy and R). */
double fw_quantile(size_t n, const double *sorted, double p);

/* Sums up n values.
 *   values  in/out  given with their signs; left behind are their magnitudes in ascending order
 *   s       out
 * Returns FW_OK; FW_EINVAL (n = 0); FW_ENONFINITE (a value is not finite): both untouched. */
fw_status fw_summarise(size_t n, double *values, fw_summary *s) FW_MUST_CHECK;

#endif
