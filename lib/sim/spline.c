#include "sim/spline.h"

#include <assert.h>
#include <math.h>

enum { SUPPORT = 6, RATED = 3 };

/* The six pieces of the uniform quintic B-spline as polynomials in the place x, 0..1, between two knots; over 120. */
static const double basis[SUPPORT][SUPPORT] = {
    {1, -5, 10, -10, 5, -1},    {26, -50, 20, 20, -20, 5}, {66, 0, -60, 0, 30, -10},
    {26, 50, 20, -20, -20, 10}, {1, 5, 10, 10, 5, -5},     {0, 0, 0, 0, 0, 1},
};

/* A fourth difference, and its weight against a sample: enough to decide what the samples leave open, too little to move
 * what they say. */
static const double difference[5] = {1, -4, 6, -4, 1};
#define SMOOTHNESS 1e-8

/* The basis at x and its first order derivatives (with x): b[order][piece]. */
static void basis_at(double x, int orders, double b[][SUPPORT])
{
	for (int k = 0; k < SUPPORT; k++) {
		for (int order = 0; order < orders; order++) {
			double sum = 0;

			for (int power = SUPPORT - 1; power >= order; power--) {
				double factor = 1;

				for (int i = 0; i < order; i++)
					factor *= power - i;
				sum = sum * x + factor * basis[k][power];
			}
			b[order][k] = sum / 120;
		}
	}
}

/* The knot interval that x is in; *within: where in it, 0..1. */
static int interval_of(const fw_spline *s, double x, double *within)
{
	double u = (x - s->first) / s->spacing;
	int i = (int)u;

	if (i > s->n_knots - SUPPORT)
		i = s->n_knots - SUPPORT;
	*within = u - i;
	return i;
}

int fw_spline_knots(double first, double last, double spacing)
{
	double n = ceil((last - first) / spacing * (1 - 1e-12));

	return last > first && spacing > 0 && n >= 1 && n < 1e7 ? (int)n + SUPPORT - 1 : 0;
}

fw_status fw_spline_begin(double first, double last, double spacing, int n_knots, fw_spline_knot knots[],
                          fw_spline *s)
{
	if (n_knots < SUPPORT || n_knots != fw_spline_knots(first, last, spacing))
		return FW_EINVAL;
	for (int i = 0; i < n_knots; i++)
		knots[i] = (fw_spline_knot){0};
	for (int i = 0; i + 4 < n_knots; i++) {
		for (int j = 0; j < 5; j++) {
			for (int k = 0; k <= j; k++) {
				double term = SMOOTHNESS * difference[j] * difference[k];

				knots[i + j].band[0][j - k] += term;
				knots[i + j].band[1][j - k] += term;
			}
		}
	}
	*s = (fw_spline){first, spacing, n_knots, knots};
	return FW_OK;
}

/* Adds the equation sum b[k] c[i + k] = value to some columns' normal equations. */
static void add_equation(fw_spline_knot *knot, const double b[SUPPORT], int band, int from, int n,
                         const double value[])
{
	for (int j = 0; j < SUPPORT; j++) {
		for (int k = 0; k <= j; k++)
			knot[j].band[band][j - k] += b[j] * b[k];
		for (int c = 0; c < n; c++)
			knot[j].value[from + c] += b[j] * value[c];
	}
}

fw_status fw_spline_add(fw_spline *s, double x, const double value[static FW_SPLINE_COLUMNS],
                        const double rate[static 3])
{
	double within, b[2][SUPPORT], sum = rate[0] + rate[1] + rate[2];
	fw_spline_knot *knot;

	for (int c = 0; c < FW_SPLINE_COLUMNS; c++)
		sum += value[c];
	if (!isfinite(sum))
		return FW_ENONFINITE;
	if (!(x >= s->first && x <= s->first + s->spacing * (s->n_knots - SUPPORT + 1) * (1 + 1e-12)))
		return FW_ERANGE;
	knot = &s->knot[interval_of(s, x, &within)];
	basis_at(within, 2, b);
	for (int k = 0; k < SUPPORT; k++)
		b[1][k] /= s->spacing;
	add_equation(knot, b[0], 0, 0, RATED, value);
	add_equation(knot, b[1], 0, 0, RATED, rate);
	add_equation(knot, b[0], 1, RATED, FW_SPLINE_COLUMNS - RATED, value + RATED);
	return FW_OK;
}

/* Cholesky factor of a band matrix, in place. Row i holds its elements i, i - 1, ..., i - 5. */
static fw_status factor(fw_spline_knot *knot, int n, int band)
{
	for (int i = 0; i < n; i++) {
		double *row = knot[i].band[band], diagonal = row[0];

		for (int d = SUPPORT - 1; d >= 0; d--) { /* element (i, j), j = i - d */
			int j = i - d;
			double sum = row[d];

			if (j < 0)
				continue;
			for (int e = d + 1; e < SUPPORT && e <= i; e++)
				sum -= row[e] * knot[j].band[band][e - d];
			if (d > 0)
				row[d] = sum / knot[j].band[band][0];
			else if (sum > 1e-15 * diagonal)
				row[0] = sqrt(sum);
			else
				return FW_ESINGULAR;
		}
	}
	return FW_OK;
}

static void substitute(fw_spline_knot *knot, int n, int band, int c)
{
	for (int i = 0; i < n; i++) {
		for (int d = 1; d < SUPPORT && d <= i; d++)
			knot[i].value[c] -= knot[i].band[band][d] * knot[i - d].value[c];
		knot[i].value[c] /= knot[i].band[band][0];
	}
	for (int i = n - 1; i >= 0; i--) {
		for (int d = 1; d < SUPPORT && i + d < n; d++)
			knot[i].value[c] -= knot[i + d].band[band][d] * knot[i + d].value[c];
		knot[i].value[c] /= knot[i].band[band][0];
	}
}

fw_status fw_spline_solve(fw_spline *s)
{
	for (int band = 0; band < 2; band++) {
		fw_status status = factor(s->knot, s->n_knots, band);

		if (status < 0)
			return status;
	}
	for (int c = 0; c < FW_SPLINE_COLUMNS; c++)
		substitute(s->knot, s->n_knots, c >= RATED, c);
	return FW_OK;
}

void fw_spline_at(const fw_spline *s, double x, int from, int n, double derivative[4][FW_SPLINE_COLUMNS])
{
	double within, b[4][SUPPORT], scale = 1;
	const fw_spline_knot *knot = &s->knot[interval_of(s, x, &within)];

	basis_at(within, 4, b);
	for (int order = 0; order < 4; order++) {
		for (int c = from; c < from + n; c++) {
			double sum = 0;

			for (int k = 0; k < SUPPORT; k++)
				sum += b[order][k] * knot[k].value[c];
			derivative[order][c] = sum * scale;
		}
		scale /= s->spacing;
	}
}
