/* Quintic splines with uniform knots, fitted to samples of values and rates: C4, and good for the third derivative. */
#ifndef FURROW_SIM_SPLINE_H
#define FURROW_SIM_SPLINE_H

#include "base/status.h"

enum { FW_SPLINE_COLUMNS = 7 };

/* A coefficient of each column, and the room to find it. Columns 0..2 are fitted to values and rates, 3..6 to values. */
typedef struct {
	double value[FW_SPLINE_COLUMNS];
	double band[2][6]; /* lower band of the normal equations: columns 0..2, 3..6 */
} fw_spline_knot;

typedef struct {
	double first, spacing; /* range: first .. first + spacing (n_knots - 5) */
	int n_knots;
	fw_spline_knot *knot; /* the caller's */
} fw_spline;

/* Knots for a range; 0: no range (last <= first, spacing <= 0, NaN) or more than 10 million. */
int fw_spline_knots(double first, double last, double spacing);

/* Starts a fit over first..last; knots as many as fw_spline_knots says. Returns FW_OK or FW_EINVAL. */
fw_status fw_spline_begin(double first, double last, double spacing, int n_knots, fw_spline_knot knots[],
                          fw_spline *s) FW_MUST_CHECK;

/* Adds a sample at x: value of all columns and rate (derivative with x) of columns 0..2, where a rate weighs as much as a
 * value. Returns FW_OK, FW_ENONFINITE or FW_ERANGE (x). */
fw_status fw_spline_add(fw_spline *s, double x, const double value[static FW_SPLINE_COLUMNS],
                        const double rate[static 3]) FW_MUST_CHECK;

/* Solves for the coefficients. What the samples leave open is as smooth as can be (least fourth differences).
 * Returns FW_OK or FW_ESINGULAR. */
fw_status fw_spline_solve(fw_spline *s) FW_MUST_CHECK;

/* Value and derivatives, derivative[0..3], of columns from..from + n - 1 at x inside the range. */
void fw_spline_at(const fw_spline *s, double x, int from, int n, double derivative[4][FW_SPLINE_COLUMNS]);

#endif
