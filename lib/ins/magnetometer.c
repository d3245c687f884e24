#include "ins/magnetometer.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "ins/magnetic_field.h"

#define HEADING_SD_MAX fw_rad_from_deg(3)

enum { READINGS_MIN = 20 };

/* Soft iron beforehand: each element of it is about so large. */
#define SOFT_IRON_SD 0.2

static bool all_finite(int n, const double *x)
{
	for (int i = 0; i < n; i++)
		if (!isfinite(x[i]))
			return false;
	return true;
}

static double length(const double v[3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

fw_mag_calibration fw_mag_as_it_is(double field_ut, double noise_ut)
{
	return (fw_mag_calibration){
	    .matrix = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .field_ut = field_ut, .noise_ut = noise_ut};
}

/* ---- turning on the ground: the Gram matrix of quadric terms ---- */

void fw_mag_turning_init(fw_mag_turning *g)
{
	*g = (fw_mag_turning){0};
}

fw_status fw_mag_turning_add(fw_mag_turning *g, const double m_b[3])
{
	double m[3], term[FW_MAG_TERMS];

	if (!all_finite(3, m_b))
		return FW_ENONFINITE;
	if (g->n == 0) {
		if (!(length(m_b) > 0))
			return FW_EINVAL;
		g->scale = length(m_b);
		memcpy(g->first, m_b, sizeof(g->first));
	}
	for (int i = 0; i < 3; i++) {
		m[i] = (m_b[i] - g->first[i]) / g->scale;
		term[i] = m[i] * m[i];
		term[6 + i] = m[i];
	}
	term[3] = m[1] * m[2];
	term[4] = m[0] * m[2];
	term[5] = m[0] * m[1];
	term[9] = 1;
	for (int i = 0; i < FW_MAG_TERMS; i++)
		for (int j = 0; j < FW_MAG_TERMS; j++)
			g->gram[i][j] += term[i] * term[j];
	g->n++;
	return FW_OK;
}

/* ---- turning on the ground: the fit ---- */

enum { ELLIPSOID = 9, ELLIPSE = 5 };

/* The ellipsoid |N (m - h)| = 1, or the cylinder over an ellipse, in scaled readings. */
typedef struct {
	int n; /* unknowns: 9, N11 N22 N33 N23 N13 N12 h1 h2 h3; or 5, N11 N22 N12 h1 h2 */
	double N[3][3], h[3];
	double cost; /* sum of (|N (m - h)|^2 - 1)^2 */
	double normal[ELLIPSOID * ELLIPSOID];
	double per_radius; /* soft iron beforehand: N is 1 / radius times I, to SOFT_IRON_SD */
	double weight;     /* of that, against residuals */
} surface;

/* Which element of N or h an unknown is. */
typedef struct {
	bool centre;
	int i, j;
} unknown;

static unknown unknown_at(const surface *s, int k)
{
	static const unknown ellipsoid[ELLIPSOID] = {{false, 0, 0}, {false, 1, 1}, {false, 2, 2},
	                                             {false, 1, 2}, {false, 0, 2}, {false, 0, 1},
	                                             {true, 0, 0},  {true, 1, 0},  {true, 2, 0}};
	static const unknown ellipse[ELLIPSE] = {
	    {false, 0, 0}, {false, 1, 1}, {false, 0, 1}, {true, 0, 0}, {true, 1, 0}};

	return s->n == ELLIPSOID ? ellipsoid[k] : ellipse[k];
}

/* Coefficients of m^T A m + b^T m + c as they stand with the terms. */
static void set_terms(const double A[3][3], const double b[3], double c, double q[FW_MAG_TERMS])
{
	for (int i = 0; i < 3; i++) {
		q[i] = A[i][i];
		q[6 + i] = b[i];
	}
	q[3] = A[1][2] + A[2][1];
	q[4] = A[0][2] + A[2][0];
	q[5] = A[0][1] + A[1][0];
	q[9] = c;
}

/* |N (m - h)|^2 - 1 as a quadric in m. */
static void quadric(const surface *s, double q[FW_MAG_TERMS])
{
	double A[3][3], Ah[3], b[3];

	fw_mat_t_mul(3, 3, 3, s->N[0], s->N[0], A[0]);
	fw_mat3_vec(A, s->h, Ah);
	for (int i = 0; i < 3; i++)
		b[i] = -2 * Ah[i];
	set_terms(A, b, s->h[0] * Ah[0] + s->h[1] * Ah[1] + s->h[2] * Ah[2] - 1, q);
}

/* Its derivative with an unknown. */
static void quadric_slope(const surface *s, int k, double q[FW_MAG_TERMS])
{
	unknown u = unknown_at(s, k);
	double A[3][3], dA[3][3], E[3][3] = {{0}}, EN[3][3], Ah[3], b[3], c = 0;

	if (u.centre) {
		fw_mat_t_mul(3, 3, 3, s->N[0], s->N[0], A[0]);
		fw_mat3_vec(A, s->h, Ah);
		for (int i = 0; i < 3; i++)
			b[i] = -2 * A[i][u.i];
		set_terms(E, b, 2 * Ah[u.i], q);
		return;
	}
	E[u.i][u.j] = E[u.j][u.i] = 1;
	fw_mat3_mul(E, s->N, EN);
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			dA[i][j] = EN[i][j] + EN[j][i];
	fw_mat3_vec(dA, s->h, Ah);
	for (int i = 0; i < 3; i++) {
		b[i] = -2 * Ah[i];
		c += s->h[i] * Ah[i];
	}
	set_terms(dA, b, c, q);
}

/* How far an unknown of N is from what it is beforehand. */
static double surprise(const surface *s, unknown u)
{
	return u.centre ? 0 : s->N[u.i][u.j] - (u.i == u.j ? s->per_radius : 0);
}

static double surface_cost(const fw_mag_turning *g, surface *s)
{
	double q[FW_MAG_TERMS], Gq[FW_MAG_TERMS], prior = 0;

	quadric(s, q);
	fw_mat_mul(FW_MAG_TERMS, FW_MAG_TERMS, 1, g->gram[0], q, Gq);
	s->cost = 0;
	for (int i = 0; i < FW_MAG_TERMS; i++)
		s->cost += q[i] * Gq[i];
	for (int k = 0; k < s->n; k++)
		prior += s->weight * pow(surprise(s, unknown_at(s, k)), 2);
	return s->cost + prior;
}

/* The step of Gauss and Newton; leaves the normal matrix. */
static fw_status surface_step(const fw_mag_turning *g, surface *s, double step[])
{
	double q[FW_MAG_TERMS], slope[ELLIPSOID][FW_MAG_TERMS], Gs[ELLIPSOID][FW_MAG_TERMS];

	quadric(s, q);
	for (int k = 0; k < s->n; k++)
		quadric_slope(s, k, slope[k]);
	fw_mat_mul(s->n, FW_MAG_TERMS, FW_MAG_TERMS, slope[0], g->gram[0], Gs[0]);
	fw_mat_mul_t(s->n, FW_MAG_TERMS, s->n, Gs[0], slope[0], s->normal);
	fw_mat_mul(s->n, FW_MAG_TERMS, 1, Gs[0], q, step);
	for (int k = 0; k < s->n; k++) {
		unknown u = unknown_at(s, k);

		s->normal[k * s->n + k] += u.centre ? 0 : s->weight;
		step[k] = -step[k] - s->weight * surprise(s, u);
	}
	return fw_mat_solve_spd(s->n, 1, s->normal, step, step);
}

static void surface_move(const surface *from, const double step[], double share, surface *to)
{
	*to = *from;
	for (int k = 0; k < from->n; k++) {
		unknown u = unknown_at(from, k);

		if (u.centre)
			to->h[u.i] += share * step[k];
		else
			to->N[u.i][u.j] = to->N[u.j][u.i] = from->N[u.i][u.j] + share * step[k];
	}
}

/* Downhill from a sphere, with halved steps where it would go up. */
static fw_status fit(const fw_mag_turning *g, surface *s)
{
	double cost = surface_cost(g, s);

	for (int i = 0; i < 100; i++) {
		double step[ELLIPSOID], share = 1, lower;
		surface next;
		fw_status status = surface_step(g, s, step);

		if (status != FW_OK)
			return status;
		do {
			surface_move(s, step, share, &next);
			lower = surface_cost(g, &next);
			share /= 2;
		} while (!(lower <= cost) && share > 1e-6);
		if (!(lower <= cost))
			return FW_OK;
		*s = next;
		if (cost - lower <= 1e-10 * cost)
			return FW_OK;
		cost = lower;
	}
	return FW_ENOCONV;
}

/* The sphere (circle) to begin with: m^2 - 2 h m - c = 0 is linear in h and c. */
static fw_status first_surface(const fw_mag_turning *g, int n, surface *s)
{
	static const int sphere[] = {6, 7, 8, 9}, circle[] = {6, 7, 9};
	const int *term = n == ELLIPSOID ? sphere : circle, axes = n == ELLIPSOID ? 3 : 2;
	double normal[16], right[4] = {0}, square;

	for (int i = 0; i <= axes; i++) {
		for (int j = 0; j <= axes; j++)
			normal[i * (axes + 1) + j] = g->gram[term[i]][term[j]];
		for (int j = 0; j < axes; j++)
			right[i] += g->gram[term[i]][j];
	}
	if (fw_mat_solve_spd(axes + 1, 1, normal, right, right) != FW_OK)
		return FW_ESINGULAR;
	*s = (surface){.n = n};
	square = right[axes];
	for (int i = 0; i < axes; i++) {
		s->h[i] = right[i] / 2;
		square += s->h[i] * s->h[i];
	}
	if (!(square > 0))
		return FW_ESINGULAR;
	s->per_radius = 1 / sqrt(square);
	for (int i = 0; i < axes; i++)
		s->N[i][i] = s->per_radius;
	/* A residual is about twice the noise over the field: some percent. */
	s->weight = pow(0.02 / (SOFT_IRON_SD * s->per_radius), 2);
	return FW_OK;
}

/* ---- how good a calibration is ---- */

/* What a magnetometer sees of a field of strength 1 at an attitude whose heading is magnetic, and which way
 * error turns that: d heading = turn . (error of the field in body axes). */
static void seen_at(const double rpy[3], double horizontal, double vertical, double field_b[3],
                    double turn[3])
{
	double C[3][3], field[3] = {horizontal, 0, vertical}, east[3] = {0, -1 / horizontal, 0};

	fw_euler_to_matrix(rpy, C);
	fw_mat3_t_vec(C, field, field_b);
	fw_mat3_t_vec(C, east, turn);
}

/* row . P row */
static double variance_of(int n, const double row[], const double *P)
{
	double variance;

	fw_mat_sandwich(1, n, row, P, &variance);
	return variance;
}

/* Heading sigma of a surface with covariance P, in the worst of all headings, held at a tilt {roll,
 * pitch}. */
static double surface_heading_sd(const surface *s, const double inverse[3][3], const double *P,
                                 double horizontal, double vertical, const double tilt[2])
{
	double worst = 0;

	for (int i = 0; i < 24; i++) {
		double rpy[3] = {tilt[0], tilt[1], i * FW_PI / 12}, field[3], turn[3], m[3], row[ELLIPSOID];

		seen_at(rpy, horizontal, vertical, field, turn);
		fw_mat3_vec(inverse, field, m);
		for (int k = 0; k < s->n; k++) {
			unknown u = unknown_at(s, k);

			if (u.centre)
				row[k] = -(turn[0] * s->N[0][u.i] + turn[1] * s->N[1][u.i] +
				           turn[2] * s->N[2][u.i]);
			else
				row[k] = turn[u.i] * m[u.j] + (u.i == u.j ? 0 : turn[u.j] * m[u.i]);
		}
		worst = fmax(worst, variance_of(s->n, row, P));
	}
	return sqrt(worst);
}

/* Covariance of the unknowns and variance of a residual. */
static fw_status surface_covariance(const fw_mag_turning *g, const surface *s, double P[], double *variance)
{
	fw_status status = fw_mat_inverse_spd(s->n, s->normal, P);

	*variance = s->cost / (g->n - s->n);
	for (int i = 0; i < s->n * s->n; i++)
		P[i] *= *variance;
	return status;
}

/* Calibration of a surface whose radius is a field of strength [uT]. */
static void set_calibration(const fw_mag_turning *g, const surface *s, double strength, double variance,
                            fw_mag_calibration *cal)
{
	for (int i = 0; i < 3; i++) {
		cal->offset[i] = g->first[i] + g->scale * s->h[i];
		for (int j = 0; j < 3; j++)
			cal->matrix[i][j] = strength * s->N[i][j] / g->scale;
	}
	cal->noise_ut = strength * sqrt(variance) / 2; /* |v|^2 - 1 is twice the radial error */
}

/* The whole ellipsoid, if it can be trusted when leaning by 15 degrees too. */
static fw_status solve_ellipsoid(const fw_mag_turning *g, double horizontal, double vertical,
                                 fw_mag_calibration *cal)
{
	static const double tilts[][2] = {{0, 0}, {0.26, 0}, {-0.26, 0}, {0, 0.26}, {0, -0.26}};
	double P[ELLIPSOID * ELLIPSOID], inverse[3][3], variance, strength = hypot(horizontal, vertical);
	surface s;

	if (first_surface(g, ELLIPSOID, &s) != FW_OK || fit(g, &s) != FW_OK ||
	    fw_mat_inverse_spd(3, s.N[0], inverse[0]) != FW_OK ||
	    surface_covariance(g, &s, P, &variance) != FW_OK)
		return FW_ESINGULAR;
	for (int i = 0; i < 5; i++) {
		double sd =
		    surface_heading_sd(&s, inverse, P, horizontal / strength, vertical / strength, tilts[i]);

		if (!(sd <= HEADING_SD_MAX))
			return FW_ESINGULAR;
		if (i == 0)
			cal->heading_sd_rad = sd;
	}
	set_calibration(g, &s, strength, variance, cal);
	return FW_OK;
}

/* The ellipse in the plane of x and y, if z hardly changed. */
static fw_status solve_ellipse(const fw_mag_turning *g, double horizontal, double vertical,
                               fw_mag_calibration *cal)
{
	static const double level[2] = {0, 0};
	double P[ELLIPSE * ELLIPSE], inverse[3][3], variance, z = g->gram[8][9] / g->n, z_sd;
	surface s;

	if (first_surface(g, ELLIPSE, &s) != FW_OK || fit(g, &s) != FW_OK)
		return FW_ESINGULAR;
	z_sd = sqrt(fmax(0, g->gram[2][9] / g->n - z * z));
	s.N[2][2] =
	    (s.N[0][0] + s.N[1][1]) / 2; /* the third axis is taken to be as sensitive as the others */
	s.h[2] = z - vertical / horizontal / s.N[2][2];
	if (!(z_sd * s.N[2][2] < 0.2) || fw_mat_inverse_spd(3, s.N[0], inverse[0]) != FW_OK ||
	    surface_covariance(g, &s, P, &variance) != FW_OK)
		return FW_ESINGULAR;
	cal->heading_sd_rad = surface_heading_sd(&s, inverse, P, 1, vertical / horizontal, level);
	if (!(cal->heading_sd_rad <= HEADING_SD_MAX))
		return FW_ESINGULAR;
	set_calibration(g, &s, horizontal, variance, cal);
	cal->flat = true;
	return FW_OK;
}

fw_status fw_mag_turning_solve(const fw_mag_turning *g, const double field_ned_nt[3], fw_mag_calibration *cal)
{
	double horizontal = hypot(field_ned_nt[0], field_ned_nt[1]) / 1e3, vertical = field_ned_nt[2] / 1e3;
	fw_mag_calibration c = {.field_ut = hypot(horizontal, vertical)};

	if (!all_finite(3, field_ned_nt))
		return FW_ENONFINITE;
	if (!(horizontal > 0))
		return FW_EINVAL;
	if (!(g->n >= READINGS_MIN))
		return FW_MORE;
	if (solve_ellipsoid(g, horizontal, vertical, &c) != FW_OK &&
	    solve_ellipse(g, horizontal, vertical, &c) != FW_OK)
		return FW_ESINGULAR;
	*cal = c;
	return c.flat ? FW_DUBIOUS : FW_OK;
}

/* ---- with the attitude known ---- */

void fw_mag_referenced_init(fw_mag_referenced *g)
{
	*g = (fw_mag_referenced){0};
}

fw_status fw_mag_referenced_add(fw_mag_referenced *g, const double q_n_b[4], const double field_ned_nt[3],
                                const double m_b[3])
{
	double strength = length(field_ned_nt), C[3][3], u[4];

	if (!all_finite(4, q_n_b) || !all_finite(3, field_ned_nt) || !all_finite(3, m_b))
		return FW_ENONFINITE;
	if (!(hypot(field_ned_nt[0], field_ned_nt[1]) > 0))
		return FW_EINVAL;
	fw_quat_to_matrix(q_n_b, C);
	fw_mat3_t_vec(C, field_ned_nt, u);
	for (int i = 0; i < 3; i++)
		u[i] /= strength;
	u[3] = 1;
	for (int i = 0; i < 4; i++)
		for (int j = 0; j < 4; j++)
			g->normal[i][j] += u[i] * u[j];
	for (int k = 0; k < 3; k++) {
		for (int i = 0; i < 4; i++)
			g->right[i][k] += u[i] * m_b[k];
		g->squares[k] += m_b[k] * m_b[k];
	}
	g->field_ut = strength / 1e3;
	g->horizontal_ut = hypot(field_ned_nt[0], field_ned_nt[1]) / 1e3;
	g->vertical_ut = field_ned_nt[2] / 1e3;
	g->n++;
	return FW_OK;
}

/* X (4 x 3): T^T and h^T one below the other, T drawn to I with a weight. */
static fw_status solve_axes(const fw_mag_referenced *g, double weight, double inverse[4][4], double X[4][3])
{
	double normal[4][4], right[4][3];
	fw_status status;

	memcpy(normal, g->normal, sizeof(normal));
	memcpy(right, g->right, sizeof(right));
	for (int i = 0; i < 3; i++) {
		normal[i][i] += weight;
		right[i][i] += weight * g->field_ut; /* (I field)_i; u is the field over its strength */
	}
	status = fw_mat_inverse_spd(4, normal[0], inverse[0]);
	if (status == FW_OK)
		fw_mat_mul(4, 4, 3, inverse[0], right[0], X[0]);
	return status;
}

/* Mean square of what a solution leaves of the readings, on the worst axis: errors of the heading are in two
 * of them only. */
static double residual_variance(const fw_mag_referenced *g, const double X[4][3])
{
	double worst = 0;

	for (int k = 0; k < 3; k++) {
		double sum = g->squares[k];

		for (int i = 0; i < 4; i++) {
			sum -= 2 * X[i][k] * g->right[i][k];
			for (int j = 0; j < 4; j++)
				sum += X[i][k] * g->normal[i][j] * X[j][k];
		}
		worst = fmax(worst, sum);
	}
	return worst / (g->n - 4);
}

/* Heading sigma held level, worst of all headings: each component of the field is off by u . (its column of
 * X), all alike. */
static double referenced_heading_sd(const fw_mag_referenced *g, double variance, const double inverse[4][4])
{
	double worst = 0;

	for (int i = 0; i < 24; i++) {
		double rpy[3] = {0, 0, i * FW_PI / 12}, u[4], turn[3];

		seen_at(rpy, g->horizontal_ut / g->field_ut, g->vertical_ut / g->field_ut, u, turn);
		u[3] = 1;
		worst = fmax(worst, variance_of(4, u, inverse[0]));
	}
	return sqrt(worst * variance) / g->horizontal_ut;
}

/* A (3 x 3) inverse by cofactors. */
static fw_status inverse3(const double A[3][3], double inverse[3][3])
{
	double det;

	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++) {
			int r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;

			inverse[i][j] = A[r][c] * A[s][d] - A[r][d] * A[s][c];
		}
	det = A[0][0] * inverse[0][0] + A[0][1] * inverse[1][0] + A[0][2] * inverse[2][0];
	if (!(fabs(det) > 1e-3))
		return FW_ESINGULAR;
	for (int i = 0; i < 9; i++)
		inverse[i / 3][i % 3] /= det;
	return FW_OK;
}

fw_status fw_mag_referenced_solve(const fw_mag_referenced *g, fw_mag_calibration *cal)
{
	double inverse[4][4], X[4][3], T[3][3], variance = 0;
	fw_mag_calibration c = {.field_ut = g->field_ut};

	if (!(g->n >= READINGS_MIN))
		return FW_MORE;
	/* The noise sets the weight of what is known beforehand, and comes out of the fit: twice is
	 * enough. */
	for (int i = 0; i < 2; i++) {
		double noise2 = i == 0 ? pow(0.01 * g->field_ut, 2) : variance;

		if (solve_axes(g, noise2 / pow(SOFT_IRON_SD * g->field_ut, 2), inverse, X) != FW_OK)
			return FW_ESINGULAR;
		variance = residual_variance(g, X);
	}
	for (int i = 0; i < 3; i++) {
		c.offset[i] = X[3][i];
		for (int j = 0; j < 3; j++)
			T[i][j] = X[j][i] / g->field_ut;
	}
	if (inverse3(T, c.matrix) != FW_OK)
		return FW_ESINGULAR;
	c.noise_ut = sqrt(variance);
	c.heading_sd_rad = referenced_heading_sd(g, variance, inverse);
	if (!(c.heading_sd_rad <= HEADING_SD_MAX))
		return FW_ESINGULAR;
	*cal = c;
	return FW_OK;
}

/* ---- heading ---- */

void fw_mag_field(const fw_mag_calibration *cal, const double m_b[3], double field_b_ut[3])
{
	double m[3] = {m_b[0] - cal->offset[0], m_b[1] - cal->offset[1], m_b[2] - cal->offset[2]};

	fw_mat3_vec(cal->matrix, m, field_b_ut);
}

fw_status fw_mag_heading(const fw_mag_calibration *cal, const double m_b[3], const double rp_rad[2],
                         double tilt_sd_rad, const double field_ned_nt[3], double *heading_rad,
                         double *sd_rad)
{
	double tilt[3] = {rp_rad[0], rp_rad[1], 0}, C[3][3], field_b[3], field[3], flat, noise, lean;
	double horizontal = hypot(field_ned_nt[0], field_ned_nt[1]) / 1e3;

	if (!all_finite(3, m_b) || !all_finite(2, rp_rad) || !all_finite(3, field_ned_nt) ||
	    !isfinite(tilt_sd_rad))
		return FW_ENONFINITE;
	if (!(tilt_sd_rad >= 0))
		return FW_EINVAL;
	fw_mag_field(cal, m_b, field_b);
	fw_euler_to_matrix(tilt, C);
	fw_mat3_vec(C, field_b, field); /* levelled, turned by the heading still */
	flat = hypot(field[0], field[1]);
	if (!(flat > horizontal / 10) || !(horizontal > 0))
		return FW_ESINGULAR;
	noise = fmax(cal->noise_ut, fabs(length(field_b) - length(field_ned_nt) / 1e3)) / horizontal;
	lean = tilt_sd_rad * field_ned_nt[2] / 1e3 / horizontal;
	*heading_rad = fw_wrap_2pi(atan2(-field[1], field[0]) + atan2(field_ned_nt[1], field_ned_nt[0]));
	*sd_rad = fmin(FW_PI, sqrt(noise * noise + lean * lean + cal->heading_sd_rad * cal->heading_sd_rad));
	return FW_OK;
}

fw_status fw_mag_heading_at(const fw_mag_calibration *cal, const double m_b[3], const double rp_rad[2],
                            double tilt_sd_rad, const double llh[3], fw_time t, double *heading_rad,
                            double *sd_rad)
{
	double field_ned_nt[3];
	fw_status model = fw_magnetic_field(llh, t, field_ned_nt), status;

	if (model < 0)
		return model;
	status = fw_mag_heading(cal, m_b, rp_rad, tilt_sd_rad, field_ned_nt, heading_rad, sd_rad);
	return status == FW_OK ? model : status;
}
