#include "ins/heading_table.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"

enum { N = FW_HEADING_STATES, CELLS = FW_HEADING_HARMONICS + FW_HEADING_TILTS };

fw_heading_table_setup fw_heading_table_defaults(void)
{
	return (fw_heading_table_setup){.harmonic_sd_rad = fw_rad_from_deg(5),
	                                .cell_sd_rad = fw_rad_from_deg(1),
	                                .memory_s = 86400,
	                                .correlation_s = 1};
}

/* Variance of a state of which nothing is known. */
static double unknown(const fw_heading_table_setup *s, int state)
{
	double sd = state < CELLS ? s->harmonic_sd_rad : s->cell_sd_rad;

	return sd * sd;
}

static bool positive(double x)
{
	return x > 0 && isfinite(x);
}

fw_status fw_heading_table_init(const fw_heading_table_setup *setup, fw_heading_table *h)
{
	if (!positive(setup->harmonic_sd_rad) || !positive(setup->cell_sd_rad) ||
	    !positive(setup->memory_s) || !positive(setup->correlation_s))
		return FW_EINVAL;
	*h = (fw_heading_table){.setup = *setup};
	for (int i = 0; i < N; i++)
		h->P[i][i] = unknown(setup, i);
	return FW_OK;
}

void fw_heading_table_tilt(fw_heading_table *h, const double rp_rad[2])
{
	if (isfinite(rp_rad[0]) && isfinite(rp_rad[1]))
		memcpy(h->rp_rad, rp_rad, sizeof(h->rp_rad));
}

/* The row of the correction at a heading: Fourier terms, tilt, the two cells on either side. */
static void row_at(const fw_heading_table *h, double heading, double row[N])
{
	double place = fw_wrap_2pi(heading) / (2 * FW_PI) * FW_HEADING_CELLS, below = floor(place);
	int cell = (int)below % FW_HEADING_CELLS;

	memset(row, 0, sizeof(double[N]));
	row[0] = 1;
	row[1] = cos(heading);
	row[2] = sin(heading);
	row[3] = cos(2 * heading);
	row[4] = sin(2 * heading);
	for (int i = 0; i < 2; i++) {
		row[FW_HEADING_HARMONICS + 2 * i] = h->rp_rad[i] * row[1];
		row[FW_HEADING_HARMONICS + 2 * i + 1] = h->rp_rad[i] * row[2];
	}
	row[CELLS + cell] = 1 - (place - below);
	row[CELLS + (cell + 1) % FW_HEADING_CELLS] = place - below;
}

/* The correction of a row; Pr = P row, *variance = row^T P row. */
static double correction(const fw_heading_table *h, const double row[N], double Pr[N], double *variance)
{
	double sum = 0;

	*variance = 0;
	for (int i = 0; i < N; i++) {
		Pr[i] = 0;
		for (int j = 0; j < N; j++)
			Pr[i] += h->P[i][j] * row[j];
		*variance += row[i] * Pr[i];
		sum += row[i] * h->x[i];
	}
	return sum;
}

/* Time goes by: what was learnt fades towards nothing learnt. */
static void fade(fw_heading_table *h, double dt)
{
	double keep = exp(-dt / h->setup.memory_s);

	for (int i = 0; i < N; i++) {
		h->x[i] *= keep;
		for (int j = 0; j < N; j++)
			h->P[i][j] *= keep * keep;
		h->P[i][i] += (1 - keep * keep) * unknown(&h->setup, i);
	}
}

fw_status fw_heading_table_update(fw_heading_table *h, fw_time t, double magnetic_heading_rad,
                                  double gnss_heading_rad, double sd_rad)
{
	double dt = h->begun ? fw_time_diff_s(t, h->t) : h->setup.correlation_s, row[N], Pr[N], off, S;

	if (!isfinite(magnetic_heading_rad) || !isfinite(gnss_heading_rad) || !isfinite(sd_rad))
		return FW_ENONFINITE;
	if (!(sd_rad > 0) || !(dt >= 0))
		return FW_EINVAL;
	if (h->begun)
		fade(h, dt);
	row_at(h, magnetic_heading_rad, row);
	off = fw_wrap_pi(gnss_heading_rad - magnetic_heading_rad - correction(h, row, Pr, &S));
	/* Samples closer together than the errors change share the weight of one. */
	S += sd_rad * sd_rad * fmax(1, h->setup.correlation_s / fmax(dt, 1e-3));
	S = fmax(S, off * off / 9);
	for (int i = 0; i < N; i++) {
		h->x[i] += Pr[i] * off / S;
		for (int j = 0; j < N; j++)
			h->P[i][j] -= Pr[i] * Pr[j] / S;
	}
	h->t = t;
	h->begun = true;
	return FW_OK;
}

void fw_heading_table_correction(const fw_heading_table *h, double magnetic_heading_rad,
                                 double *correction_rad, double *sd_rad)
{
	double row[N], Pr[N], variance;

	if (!isfinite(magnetic_heading_rad)) {
		*correction_rad = *sd_rad = (double)NAN;
		return;
	}
	row_at(h, magnetic_heading_rad, row);
	*correction_rad = correction(h, row, Pr, &variance);
	*sd_rad = sqrt(fmax(variance, 0));
}
