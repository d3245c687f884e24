#include "base/summary.h"

#include <math.h>
#include <stdlib.h>

double fw_quantile(size_t n, const double *sorted, double p)
{
	if (n == 0 || !(p >= 0 && p <= 1))
		return nan("");
	double place = p * (double)(n - 1);
	size_t below = (size_t)place;
	if (below + 1 >= n)
		return sorted[n - 1];
	return sorted[below] + (place - (double)below) * (sorted[below + 1] - sorted[below]);
}

static int ascending(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

fw_status fw_summarise(size_t n, double *values, fw_summary *s)
{
	double sum = 0, squares = 0;

	if (n == 0)
		return FW_EINVAL;
	for (size_t i = 0; i < n; i++) {
		if (!isfinite(values[i]))
			return FW_ENONFINITE;
		sum += values[i];
		squares += values[i] * values[i];
	}
	for (size_t i = 0; i < n; i++)
		values[i] = fabs(values[i]);
	qsort(values, n, sizeof values[0], ascending);
	*s = (fw_summary){
	    .n = n,
	    .mean = sum / (double)n,
	    .rms = sqrt(squares / (double)n),
	    .p50 = fw_quantile(n, values, 0.50),
	    .p68 = fw_quantile(n, values, 0.68),
	    .p95 = fw_quantile(n, values, 0.95),
	    .p99 = fw_quantile(n, values, 0.99),
	    .max = values[n - 1],
	};
	return FW_OK;
}
