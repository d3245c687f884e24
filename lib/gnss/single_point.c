#include "gnss/single_point.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"

/* clang-format off */
const fw_single_point_options fw_single_point_defaults = {
	.systems = 1U << FW_GPS | 1U << FW_GALILEO | 1U << FW_BEIDOU | 1U << FW_GLONASS | 1U << FW_QZSS,
	.elevation_mask_rad = 10 * FW_PI / 180,
	.iono = FW_IONO_BROADCAST,
	.tropo = FW_TROPO_SAASTAMOINEN,
	.gate = 4,
	.max_gdop = 30,
};
/* clang-format on */

/* The unknowns: position, the clocks of the systems present, and the errors of the models: the ionosphere's at the zenith
 * [m on L1] and how it changes to the north and to the east [m / 1000 km], the troposphere's at the zenith [m]. */
enum { CLOCKS = 3 };
enum { ZENITH_IONO, NORTH_IONO, EAST_IONO, ZENITH_TROPO, MODEL_ERRORS };
enum {
	MAX_UNKNOWNS = CLOCKS + FW_SYSTEM_COUNT + MODEL_ERRORS,
	TERMS = CLOCKS + 1 + MODEL_ERRORS,
	MAX_ITERATIONS = 20,
	NEAR_M = 5 /* so near nothing changes: see look_around() and converge() */
};

/* One observation equation, linear: sum of h[i] x[column[i]] = y, columns ascending. */
typedef struct {
	unsigned terms;
	uint8_t column[TERMS];
	double h[TERMS];
	double y, sigma;
	bool active;
} equation;

/* A satellite while the position is being found. */
typedef struct {
	const fw_range *range;
	fw_range_use use;
	fw_line_of_sight line;
	double azimuth_rad, elevation_rad;
	double iono_m, tropo_m;             /* slant corrections; the ionosphere's on L1 */
	double model[MODEL_ERRORS];         /* how the errors of the models enter; the ionosphere's on L1 */
	double code_m, iono_scale, sigma_m; /* of the combination of its codes */
} sight;

typedef struct {
	const fw_single_point_options *options;
	const fw_iono_coefficients *iono;
	fw_time tag;
	double tow_s, day_of_year;
	unsigned n;
	sight sights[FW_RANGE_MAX];
	equation equations[FW_RANGE_MAX];
	double position_m[3], clock_m[FW_SYSTEM_COUNT], model_error[MODEL_ERRORS]; /* the unknowns, now */
	double llh[3];
	double C_e_n[3][3];
	double zenith_m, zenith_per_m;    /* tropospheric delay, and its change with the height */
	double model_sigma[MODEL_ERRORS]; /* what the errors of the models are held by, */
	double model_usual[MODEL_ERRORS]; /* and how much of that they usually are */
	unsigned systems;                 /* those that have a clock */
	uint8_t clock_column[FW_SYSTEM_COUNT];
	int unknowns;
	bool located; /* near enough for elevations and delays to mean something */
	bool aimed;   /* the satellites' directions and weights are those seen from: */
	double aimed_from_m[3];
	double Q[MAX_UNKNOWNS * MAX_UNKNOWNS];
	int dof;
	double chi2, redundancy;
} solver;

const char *fw_single_point_text(fw_single_point_status status)
{
	switch (status) {
	case FW_SP_OK: return "solved";
	case FW_SP_NO_RANGES: return "no-ranges";
	case FW_SP_TOO_FEW: return "too-few-satellites";
	case FW_SP_BAD_GEOMETRY: return "bad-geometry";
	case FW_SP_NO_CONVERGENCE: return "no-convergence";
	}
	return "unknown";
}

/* ---- what errors to expect ---- */

/* Standard deviations; what they are off by on the whole, the variance factor makes good. */
typedef struct {
	double orbit_m; /* broadcast orbit and clock */
	double code_m;  /* noise and multipath at the zenith, 45 dB-Hz */
} system_error;

static const system_error errors[FW_SYSTEM_COUNT] = {
    [FW_GPS] = {0.6, 0.4},  [FW_GALILEO] = {0.3, 0.4}, [FW_BEIDOU] = {0.8, 0.4}, [FW_GLONASS] = {2.0, 1.5},
    [FW_QZSS] = {0.8, 0.4}, [FW_NAVIC] = {1.5, 0.6},   [FW_SBAS] = {4.0, 1.5},
};

static bool is_beidou_geo(fw_satellite s)
{
	return s.system == FW_BEIDOU && (s.number <= 5 || s.number >= 59);
}

static double orbit_sigma_m(const fw_range *r)
{
	const double usual = is_beidou_geo(r->satellite) ? 3 : errors[r->satellite.system].orbit_m;
	return fmax(usual, r->accuracy_m / 4); /* a satellite that calls itself unusually bad */
}

static double amplitude(double db)
{
	return exp(db * 0.11512925464970228); /* log(10) / 20 */
}

/* How much worse than at 45 dB-Hz a measurement is. */
static double weakness(double cn0_dbhz)
{
	return cn0_dbhz > 0 && cn0_dbhz < 45 ? amplitude(45 - cn0_dbhz) : 1;
}

/* In the open even a low satellite has 36 dB-Hz. One that has less on all its signals is seen through something, and
 * reflections are not: against it they count for more, by as much. */
static double shade(const fw_range *r)
{
	double best = 0;
	for (unsigned i = 0; i < r->n_codes; i++)
		best = fmax(best, r->code[i].cn0_dbhz);
	return best > 0 && best < 36 ? amplitude(36 - best) : 1;
}

static double code_variance_m2(const fw_range *r, const fw_code *code, double sine, double shaded)
{
	const double zenith = errors[r->satellite.system].code_m;
	const double multipath = shaded * zenith / sine, noise = 0.3 * weakness(code->cn0_dbhz);
	return multipath * multipath + noise * noise + (code->delay_known ? 0 : 1.5 * 1.5);
}

/* ---- the models at a place ---- */

/* The slant delay on L1; GPS's coefficients serve all systems, BeiDou's when there are no others. */
static double broadcast_iono_m(const solver *s, double azimuth_rad, double elevation_rad)
{
	const fw_sight at = {s->llh[0], s->llh[1], azimuth_rad, elevation_rad, s->tow_s};
	const double B1I_per_L1 = (1575.42 / 1561.098) * (1575.42 / 1561.098);
	if (s->iono == NULL || s->options->iono == FW_IONO_OFF || s->options->iono == FW_IONO_FREE)
		return 0;
	if (s->iono->has_gps)
		return fw_klobuchar_m(&s->iono->gps, &at);
	return s->iono->has_beidou ? fw_klobuchar_beidou_m(&s->iono->beidou, &at) / B1I_per_L1 : 0;
}

static double zenith_delay_m(const solver *s, double height_m)
{
	fw_zenith_delay z = {0, 0};
	if (s->options->tropo == FW_TROPO_MOPS)
		z = fw_mops_troposphere(s->llh[0], height_m, s->day_of_year);
	else if (s->options->tropo == FW_TROPO_SAASTAMOINEN)
		z = fw_saastamoinen(s->llh[0], height_m, 0.7);
	return z.dry_m + z.wet_m;
}

/* What the models may be off by, all satellites alike. Klobuchar's takes away half of the delay even on a bad day (J. A.
 * Klobuchar, IEEE Trans. AES 23 (1987): 50 % rms worldwide, equator and solar maximum included), and the solution is
 * weighted so that such a day does it little harm. On a usual day at middle latitudes it leaves about a quarter. Most of
 * that each satellite has on its own (see aim()); of what they share so much goes into the covariance: a sixth of the
 * delay above, which the height takes up, and a fifth in 1000 km to the north and east. Over many simulated days 68 % of
 * the errors are then inside one sigma. */
static void set_model_sigma(solver *s, double zenith_iono_m)
{
	static const double usual[MODEL_ERRORS] = {0.35, 0.4, 0.4, 1};
	const bool coefficients = s->iono != NULL && (s->iono->has_gps || s->iono->has_beidou);
	for (int k = ZENITH_IONO; k <= EAST_IONO; k++)
		s->model_sigma[k] = coefficients ? 0.5 * zenith_iono_m : 5;
	s->model_sigma[ZENITH_TROPO] = 0.1;
	for (int k = 0; k < MODEL_ERRORS; k++)
		s->model_usual[k] = coefficients ? usual[k] : 1;
}

static void set_zenith(solver *s)
{
	s->zenith_m = zenith_delay_m(s, s->llh[2]);
	s->zenith_per_m = zenith_delay_m(s, s->llh[2] + 1) - s->zenith_m;
	set_model_sigma(s, broadcast_iono_m(s, 0, FW_PI / 2));
}

/* Brings the codes of a satellite together to one: the weights that give the smallest error when the ionosphere is known
 * to sigma_iono_m on L1 besides. With one code it is that code; with two, and nothing known, the iono-free pair.
 * Returns false when nothing is left of it. */
static bool combine(sight *g, double sigma_iono_m, bool iono_known)
{
	const fw_range *r = g->range;
	const double sine = fmax(sin(g->elevation_rad), 0.05), shaded = shade(r);
	double variance[FW_RANGE_CODES], weight[FW_RANGE_CODES], s1 = 0, s2 = 0, sum = 0;
	if (!iono_known && r->n_codes < 2)
		return false;
	for (unsigned i = 0; i < r->n_codes; i++) {
		variance[i] = code_variance_m2(r, &r->code[i], sine, shaded);
		s1 += r->code[i].iono_scale / variance[i];
		s2 += r->code[i].iono_scale * r->code[i].iono_scale / variance[i];
	}
	const double c = s1 / ((iono_known ? 1 / (sigma_iono_m * sigma_iono_m) : 0) + s2);
	for (unsigned i = 0; i < r->n_codes; i++) {
		weight[i] = (1 - c * r->code[i].iono_scale) / variance[i];
		sum += weight[i];
	}
	g->code_m = g->iono_scale = g->sigma_m = 0;
	for (unsigned i = 0; i < r->n_codes; i++) {
		const double a = weight[i] / sum;
		g->code_m += a * r->code[i].code_m;
		g->iono_scale += a * r->code[i].iono_scale;
		g->sigma_m += a * a * variance[i];
	}
	return true;
}

/* Where the line goes through the ionosphere, a thin shell: how steeply, and how far from here. */
static void aim_through_ionosphere(sight *g, double elevation, bool counts)
{
	const double R = 6371, height = 400; /* km */
	const double sine = R / (R + height) * cos(elevation);
	const double away = R / 1000 * (FW_PI / 2 - elevation - asin(sine));
	const double slant = counts ? 1 / sqrt(1 - sine * sine) : 0;
	g->model[ZENITH_IONO] = slant;
	g->model[NORTH_IONO] = slant * away * cos(g->azimuth_rad);
	g->model[EAST_IONO] = slant * away * sin(g->azimuth_rad);
}

/* Direction, corrections and weight of a satellite as seen from the present position. */
static void aim(solver *s, sight *g)
{
	const fw_single_point_options *o = s->options;
	double ned[3];
	fw_mat3_t_vec(s->C_e_n, g->line.unit, ned);
	g->azimuth_rad = atan2(ned[1], ned[0]);
	g->elevation_rad = asin(fmax(-1, fmin(1, -ned[2])));
	if (g->use != FW_OUTLIER)
		g->use = g->elevation_rad >= o->elevation_mask_rad ? FW_USED : FW_LOW;
	const double cn0 = g->range->code[0].cn0_dbhz;
	if (g->use == FW_USED && cn0 > 0 && cn0 < o->cn0_mask_dbhz)
		g->use = FW_WEAK;
	if (g->use == FW_LOW || g->use == FW_WEAK)
		return;

	const double elevation = fmax(g->elevation_rad, 0.05);
	g->model[ZENITH_TROPO] = o->tropo == FW_TROPO_OFF    ? 0
	                         : o->tropo == FW_TROPO_MOPS ? fw_mops_mapping(elevation)
	                                                     : 1 / sin(elevation);
	g->iono_m = broadcast_iono_m(s, g->azimuth_rad, g->elevation_rad);
	aim_through_ionosphere(g, elevation, o->iono == FW_IONO_BROADCAST || o->iono == FW_IONO_WEIGHTED);

	const double common = s->model_sigma[ZENITH_IONO] * g->model[ZENITH_IONO], own = 0.4 * common;
	if (!combine(g, sqrt(own * own + common * common), o->iono != FW_IONO_FREE)) {
		g->use = FW_NO_PAIR;
		return;
	}
	const double orbit = orbit_sigma_m(g->range), iono = own * g->iono_scale;
	g->sigma_m = sqrt(g->sigma_m + orbit * orbit + iono * iono);
}

/* Before anything is known of where we are: first codes, no corrections, equal weights. */
static void aim_blindly(sight *g)
{
	g->use = FW_USED;
	g->iono_m = g->tropo_m = 0;
	memset(g->model, 0, sizeof g->model);
	g->code_m = g->range->code[0].code_m;
	g->iono_scale = g->range->code[0].iono_scale;
	g->sigma_m = 10;
}

/* ---- least squares ---- */

/* The columns of the unknowns: a clock for each system that is used. */
static unsigned number_unknowns(solver *s)
{
	unsigned used = 0;
	s->systems = 0;
	for (unsigned i = 0; i < s->n; i++) {
		if (s->sights[i].use == FW_USED) {
			s->systems |= 1U << s->sights[i].range->satellite.system;
			used++;
		}
	}
	s->unknowns = CLOCKS;
	for (unsigned k = 0; k < FW_SYSTEM_COUNT; k++)
		if ((s->systems >> k & 1) != 0)
			s->clock_column[k] = (uint8_t)s->unknowns++;
	s->dof = (int)used - s->unknowns;
	s->unknowns += MODEL_ERRORS;
	return used;
}

/* Adds h / sigma^2 of one equation to the normal equations N x = b, N by its lower triangle. */
static void accumulate(const equation *e, int n, double *N, double *b)
{
	const double w = 1 / (e->sigma * e->sigma);
	for (unsigned i = 0; i < e->terms; i++) {
		const double wh = w * e->h[i];
		double *row = &N[e->column[i] * n];
		for (unsigned j = 0; j <= i; j++)
			row[e->column[j]] += wh * e->h[j];
		b[e->column[i]] += wh * e->y;
	}
}

/* h Q h^T */
static double variance_of(const equation *e, int n, const double *Q)
{
	double sum = 0;
	for (unsigned i = 0; i < e->terms; i++) {
		const double *row = &Q[e->column[i] * n];
		double below = 0;
		for (unsigned j = 0; j < i; j++)
			below += row[e->column[j]] * e->h[j];
		sum += e->h[i] * (2 * below + row[e->column[i]] * e->h[i]);
	}
	return sum;
}

/* The equation of a satellite for the change of the unknowns. */
static void write_equation(const solver *s, const sight *g, equation *e)
{
	const uint8_t system = g->range->satellite.system;
	*e = (equation){.terms = TERMS, .sigma = g->sigma_m, .active = g->use == FW_USED};
	e->y = g->code_m - g->line.distance_m - s->clock_m[system] - g->iono_scale * g->iono_m - g->tropo_m;
	for (unsigned i = 0; i < 3; i++) {
		e->column[i] = (uint8_t)i;
		e->h[i] = -g->line.unit[i] -
		          s->zenith_per_m * g->model[ZENITH_TROPO] * s->C_e_n[i][2]; /* column 2 is down */
	}
	e->column[CLOCKS] = s->clock_column[system];
	e->h[CLOCKS] = 1;
	for (int i = 0; i < MODEL_ERRORS; i++) {
		e->column[CLOCKS + 1 + i] = (uint8_t)(s->unknowns - MODEL_ERRORS + i);
		e->h[CLOCKS + 1 + i] = (i == ZENITH_TROPO ? 1 : g->iono_scale) * g->model[i];
		e->y -= e->h[CLOCKS + 1 + i] * s->model_error[i];
	}
}

static void write_equations(solver *s)
{
	for (unsigned i = 0; i < s->n; i++) {
		const sight *g = &s->sights[i];
		if (g->use == FW_USED || g->use == FW_OUTLIER)
			write_equation(s, g, &s->equations[i]);
		else
			s->equations[i].active = false;
	}
}

/* Before there is a place nothing is corrected, and the errors of the models are held at 0. */
static double model_sigma(const solver *s, int k)
{
	const double held = 1e-3;
	return s->located ? fmax(s->model_sigma[k], held) : held;
}

/* The normal equations N x = b (N by its lower triangle) of the active equations and of what is known of the errors
 * of the models. */
static void normal_equations(const solver *s, double *N, double *b)
{
	const int n = s->unknowns;
	memset(N, 0, sizeof(double) * (size_t)(n * n));
	memset(b, 0, sizeof(double) * (size_t)n);
	for (unsigned i = 0; i < s->n; i++)
		if (s->equations[i].active)
			accumulate(&s->equations[i], n, N, b);
	for (int k = 0; k < MODEL_ERRORS; k++) {
		const int j = n - MODEL_ERRORS + k;
		const double sigma = model_sigma(s, k);
		N[j * n + j] += 1 / (sigma * sigma);
		b[j] -= s->model_error[k] / (sigma * sigma);
	}
}

static void move(solver *s, const double *dx)
{
	for (int i = 0; i < 3; i++)
		s->position_m[i] += dx[i];
	for (unsigned k = 0; k < FW_SYSTEM_COUNT; k++)
		if ((s->systems >> k & 1) != 0)
			s->clock_m[k] += dx[s->clock_column[k]];
	for (int k = 0; k < MODEL_ERRORS; k++)
		s->model_error[k] += dx[s->unknowns - MODEL_ERRORS + k];
}

static void draw_lines(solver *s)
{
	for (unsigned i = 0; i < s->n; i++)
		fw_range_line(s->position_m, s->sights[i].range->position_m, NULL, &s->sights[i].line);
}

static double distance_m(const double a[3], const double b[3])
{
	const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
	return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* Corrections and weights at the present position. Directions are those of 5 m ago: that changes no correction by more
 * than 0.05 mm. Only the troposphere goes with the height. Returns false when the position is no place. */
static bool look_around(solver *s)
{
	if (!s->located) {
		for (unsigned i = 0; i < s->n; i++)
			aim_blindly(&s->sights[i]);
		return true;
	}
	if (fw_ecef_to_llh(s->position_m, s->llh) != FW_OK)
		return false;
	set_zenith(s);
	if (!s->aimed || distance_m(s->position_m, s->aimed_from_m) > NEAR_M) {
		fw_frame_ned(s->llh[0], s->llh[1], s->C_e_n);
		for (unsigned i = 0; i < s->n; i++)
			aim(s, &s->sights[i]);
		memcpy(s->aimed_from_m, s->position_m, sizeof s->aimed_from_m);
		s->aimed = true;
	}
	for (unsigned i = 0; i < s->n; i++)
		s->sights[i].tropo_m = s->zenith_m * s->sights[i].model[ZENITH_TROPO];
	return true;
}

/* Q = N^-1 by the factor L of N, all n x n. With W = L^-1, lower too: L W = 1 row by row, then Q = W^T W. A quarter of the
 * work of solving for n right-hand sides. */
static void invert(int n, const double *L, double *Q)
{
	double W[MAX_UNKNOWNS * MAX_UNKNOWNS];
	memset(Q, 0, sizeof(double) * (size_t)(n * n));
	for (int i = 0; i < n; i++) {
		double *row = &W[i * n];
		memset(row, 0, sizeof(double) * (size_t)(i + 1));
		for (int k = 0; k < i; k++)
			for (int j = 0; j <= k; j++)
				row[j] -= L[i * n + k] * W[k * n + j];
		row[i] = 1;
		for (int j = 0; j <= i; j++)
			row[j] /= L[i * n + i];
		for (int j = 0; j <= i; j++)
			for (int k = 0; k <= j; k++)
				Q[j * n + k] += row[j] * row[k];
	}
	for (int i = 0; i < n; i++)
		for (int j = 0; j < i; j++)
			Q[j * n + i] = Q[i * n + j];
}

/* Brings the residuals up to the step that was made last. */
static void follow(solver *s, const double *dx)
{
	for (unsigned i = 0; i < s->n; i++) {
		equation *e = &s->equations[i];
		if (s->sights[i].use != FW_USED && s->sights[i].use != FW_OUTLIER)
			continue;
		for (unsigned k = 0; k < e->terms; k++)
			e->y -= e->h[k] * dx[e->column[k]];
	}
}

/* Gauss-Newton from s->position_m, until a step is below 5 m: what is not linear in that is below a micrometre. */
static fw_single_point_status converge(solver *s)
{
	double N[MAX_UNKNOWNS * MAX_UNKNOWNS], L[MAX_UNKNOWNS * MAX_UNKNOWNS], dx[MAX_UNKNOWNS];
	for (int i = 0; i < MAX_ITERATIONS; i++) {
		draw_lines(s);
		if (!look_around(s))
			return FW_SP_NO_CONVERGENCE;
		if (number_unknowns(s) < (unsigned)(s->unknowns - MODEL_ERRORS))
			return FW_SP_TOO_FEW;
		write_equations(s);
		normal_equations(s, N, dx);
		if (fw_mat_cholesky(s->unknowns, N, L) != FW_OK)
			return FW_SP_BAD_GEOMETRY;
		fw_mat_cholesky_solve(s->unknowns, 1, L, dx, dx);
		move(s, dx);
		const double moved = sqrt(dx[0] * dx[0] + dx[1] * dx[1] + dx[2] * dx[2]);
		if (!(moved < 1e8))
			return FW_SP_NO_CONVERGENCE;
		if (s->located && moved < NEAR_M) {
			follow(s, dx);
			invert(s->unknowns, L, s->Q);
			return FW_SP_OK;
		}
		s->located = s->located || moved < 10e3;
	}
	return FW_SP_NO_CONVERGENCE;
}

/* ---- residuals ---- */

/* Weighted sum of the squared residuals, and the redundancy that they have: what is not taken up by the unknowns. */
static void sum_squares(solver *s)
{
	const int n = s->unknowns;
	s->chi2 = 0;
	for (unsigned i = 0; i < s->n; i++) {
		const equation *e = &s->equations[i];
		if (e->active)
			s->chi2 += e->y * e->y / (e->sigma * e->sigma);
	}
	s->redundancy = s->dof;
	for (int k = 0; k < MODEL_ERRORS; k++) {
		const int j = n - MODEL_ERRORS + k;
		const double sigma = model_sigma(s, k);
		s->redundancy -= 1 - s->Q[j * n + j] / (sigma * sigma);
	}
}

/* The equation whose residual is least like the others', n equations of `unknowns` with the covariance Q: the largest
 * residual over its standard deviation, the scale taken from the other residuals and from `prior_dof` degrees of freedom
 * of experience with variance factor `prior`. Returns -1 when it is below the gate. */
static int find_outlier(const equation *equations, unsigned n, int unknowns, const double *Q, double chi2,
                        int dof, double prior, double prior_dof, double gate)
{
	int worst = -1;
	double largest = gate * gate;
	for (unsigned i = 0; i < n && dof > 1; i++) {
		const equation *e = &equations[i];
		if (!e->active)
			continue;
		const double variance = e->sigma * e->sigma, left = variance - variance_of(e, unknowns, Q);
		if (!(left > 0.02 * variance)) /* nothing checks this one */
			continue;
		const double square = e->y * e->y / left;
		const double scale = (prior_dof * prior + fmax(chi2 - square, 0)) / (prior_dof + dof - 1);
		if (square > largest * scale) {
			largest = square / scale;
			worst = (int)i;
		}
	}
	return worst;
}

/* The variance factor of the measurements: from the residuals of this epoch and of those before it, and some belief in the
 * errors above. An epoch that is worse than those before it speaks for itself. */
static double variance_factor(double chi2, double dof, double past_chi2, double past_dof)
{
	const double belief = 0.2;
	const double experience = (belief + chi2 + past_chi2) / (belief + dof + past_dof);
	const double now = (5 * experience + chi2) / (5 + dof);
	return fmax(experience, now);
}

/* That of the models. Their errors leave few residuals; but an atmosphere that is off smoothly is also off roughly, and
 * then the measurements scatter. */
static double model_factor(double factor)
{
	return factor >= 1 ? factor : fmin(1, 4 * factor);
}

/* Experience fades within a minute or so. */
static double fading(const fw_single_point_memory *memory, fw_time tag)
{
	const double age_s = fabs(fw_time_diff_s(tag, memory->time));
	return exp(-age_s / 60);
}

/* ---- the position ---- */

static void start_from(solver *s, const double *position)
{
	s->located = position != NULL;
	s->aimed = false;
	s->zenith_per_m = 0;
	memset(s->C_e_n, 0, sizeof s->C_e_n);
	for (int i = 0; i < 3; i++)
		s->position_m[i] = position != NULL ? position[i] : 0;
	for (unsigned k = 0; k < FW_SYSTEM_COUNT; k++)
		s->clock_m[k] = 0;
	memset(s->model_error, 0, sizeof s->model_error);
	for (unsigned i = 0; i < s->n; i++)
		s->sights[i].use = FW_USED;
}

/* From where the receiver ought to be; if that leads nowhere, or far away, from the centre of the Earth. */
static fw_single_point_status locate(solver *s, const fw_single_point_memory *memory)
{
	if (memory->has_position) {
		const double age_s = fw_time_diff_s(s->tag, memory->time),
		             coast_s = fabs(age_s) < 10 ? age_s : 0;
		double expected[3];
		for (int i = 0; i < 3; i++)
			expected[i] = memory->position_m[i] + coast_s * memory->velocity_mps[i];
		start_from(s, expected);
		if (converge(s) == FW_SP_OK && distance_m(s->position_m, expected) < 50e3)
			return FW_SP_OK;
	}
	start_from(s, NULL);
	return converge(s);
}

/* Solves again without the outliers, one after the other, as long as there is one and others to tell it by. */
static fw_single_point_status exclude_outliers(solver *s, double prior, double prior_dof)
{
	fw_single_point_status status = FW_SP_OK;
	sum_squares(s);
	while (s->options->gate > 0 && status == FW_SP_OK) {
		const int worst = find_outlier(s->equations, s->n, s->unknowns, s->Q, s->chi2, s->dof, prior,
		                               prior_dof, s->options->gate);
		if (worst < 0)
			break;
		s->sights[worst].use = FW_OUTLIER;
		status = converge(s);
		if (status == FW_SP_OK)
			sum_squares(s);
	}
	return status;
}

/* GDOP and its parts, all satellites alike. Returns FW_SP_BAD_GEOMETRY when there is no such thing. */
static fw_single_point_status dilute(const solver *s, fw_solution *out)
{
	const int n = s->unknowns - MODEL_ERRORS;
	double N[MAX_UNKNOWNS * MAX_UNKNOWNS] = {0}, L[MAX_UNKNOWNS * MAX_UNKNOWNS];
	double unused[MAX_UNKNOWNS] = {0}, ned[3];
	for (unsigned i = 0; i < s->n; i++) {
		equation e = s->equations[i];
		if (!e.active)
			continue;
		fw_mat3_t_vec(s->C_e_n, e.h, ned);
		memcpy(e.h, ned, sizeof ned);
		e.terms = 4;
		e.sigma = 1;
		accumulate(&e, n, N, unused);
	}
	if (fw_mat_cholesky(n, N, L) != FW_OK)
		return FW_SP_BAD_GEOMETRY;
	invert(n, L, N);
	const double horizontal = N[0] + N[n + 1], vertical = N[2 * n + 2], clock = N[3 * n + 3];
	out->hdop = sqrt(horizontal);
	out->vdop = sqrt(vertical);
	out->tdop = sqrt(clock);
	out->pdop = sqrt(horizontal + vertical);
	out->gdop = sqrt(horizontal + vertical + clock);
	return out->gdop <= s->options->max_gdop ? FW_SP_OK : FW_SP_BAD_GEOMETRY;
}

/* C = the covariance P of three ECEF coordinates, seen in NED. */
static void covariance_ned(const double C_e_n[3][3], const double P[9], double C[3][3])
{
	double C_n_e[3][3], R[9];
	fw_mat3_transpose(C_e_n, C_n_e);
	fw_mat_sandwich(3, 3, &C_n_e[0][0], P, R);
	memcpy(C, R, sizeof R);
}

/* The covariance of the position: Q = N^-1 has a part from the measurements and one from the errors of the models,
 * N^-1 P0^-1 N^-1 with P0 what they are held by. The first has its factor; of the second counts what is usual. */
static void position_covariance(const solver *s, double factor, double C[3][3])
{
	const int n = s->unknowns;
	double P[9];
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			P[3 * i + j] = factor * s->Q[i * n + j];
	for (int k = 0; k < MODEL_ERRORS; k++) {
		const double *row = &s->Q[(n - MODEL_ERRORS + k) * n], sigma = model_sigma(s, k);
		const double usual = s->model_usual[k] * s->model_usual[k] * model_factor(factor);
		for (int i = 0; i < 3; i++)
			for (int j = 0; j < 3; j++)
				P[3 * i + j] += (usual - factor) * row[i] * row[j] / (sigma * sigma);
	}
	covariance_ned(s->C_e_n, P, C);
}

/* ---- the velocity ---- */

/** Doppler at 45 dB-Hz: noise of a phase or frequency lock loop, and a little acceleration [m/s] */
static const double rate_sigma_mps = 0.05;

/* The observation equations of velocity and clock drift, of the satellites that the position was found with. */
static unsigned rate_equations(const solver *s, equation rates[FW_RANGE_MAX])
{
	unsigned used = 0;
	for (unsigned i = 0; i < s->n; i++) {
		const sight *g = &s->sights[i];
		fw_line_of_sight line;
		rates[i].active = g->use == FW_USED && g->range->has_rate;
		if (!rates[i].active)
			continue;
		used++;
		fw_range_line(s->position_m, g->range->position_m, g->range->velocity_mps, &line);
		rates[i] = (equation){
		    .terms = 4,
		    .column = {0, 1, 2, 3},
		    .h = {-line.unit[0], -line.unit[1], -line.unit[2], 1},
		    .y = g->range->rate_mps - line.rate_mps,
		    .sigma = rate_sigma_mps * weakness(g->range->rate_cn0_dbhz) /
		             sqrt(fmax(sin(g->elevation_rad), 0.05)),
		    .active = true,
		};
	}
	return used;
}

/* Solves n equations for four unknowns: x, their covariance Q, the residuals in y, chi2. */
static fw_status fit(equation *rates, unsigned n, double x[4], double Q[16], double *chi2)
{
	double N[16] = {0}, b[4] = {0};
	for (unsigned i = 0; i < n; i++)
		if (rates[i].active)
			accumulate(&rates[i], 4, N, b);
	fw_status status = fw_mat_inverse_spd(4, N, Q);
	if (status != FW_OK)
		return status;
	fw_mat_mul(4, 4, 1, Q, b, x);
	*chi2 = 0;
	for (unsigned i = 0; i < n; i++) {
		equation *e = &rates[i];
		if (!e->active)
			continue;
		for (int j = 0; j < 4; j++)
			e->y -= e->h[j] * x[j];
		*chi2 += e->y * e->y / (e->sigma * e->sigma);
	}
	return FW_OK;
}

/* Velocity and drift, outliers excluded as among the codes. */
static void find_velocity(const solver *s, fw_single_point_memory *memory, fw_solution *out)
{
	equation rates[FW_RANGE_MAX];
	double x[4] = {0}, dx[4], Q[16], chi2 = 0;
	int dof = (int)rate_equations(s, rates) - 4;
	out->has_velocity = false;
	for (;;) {
		if (dof < 0 || fit(rates, s->n, dx, Q, &chi2) != FW_OK)
			return;
		for (int i = 0; i < 4; i++)
			x[i] += dx[i];
		const double past = fmin(memory->rate_dof, 10);
		const double prior = (1 + memory->rate_chi2) / (1 + memory->rate_dof);
		const int worst = s->options->gate > 0 ? find_outlier(rates, s->n, 4, Q, chi2, dof, prior,
		                                                      1 + past, s->options->gate)
		                                       : -1;
		if (worst < 0)
			break;
		rates[worst].active = false;
		dof--;
	}
	const double scale = variance_factor(chi2, dof, memory->rate_chi2, memory->rate_dof);
	memory->rate_chi2 += chi2;
	memory->rate_dof += dof;
	fw_mat3_t_vec(s->C_e_n, x, out->velocity_mps);
	out->drift_mps = x[3];
	double P[9];
	for (int i = 0; i < 9; i++)
		P[i] = scale * Q[i / 3 * 4 + i % 3];
	covariance_ned(s->C_e_n, P, out->velocity_covariance);
	out->has_velocity = true;
}

/* ---- all together ---- */

static void report_satellites(const solver *s, fw_solution *out)
{
	out->n = s->n;
	out->n_used = out->n_excluded = 0;
	for (unsigned i = 0; i < s->n; i++) {
		const sight *g = &s->sights[i];
		const bool corrected = g->use == FW_USED || g->use == FW_OUTLIER;
		out->n_used += g->use == FW_USED;
		out->n_excluded += g->use == FW_OUTLIER;
		out->satellite[i] = (fw_satellite_use){
		    .satellite = g->range->satellite,
		    .use = g->use,
		    .azimuth_rad = fw_wrap_2pi(g->azimuth_rad),
		    .elevation_rad = g->elevation_rad,
		    .residual_m = corrected ? s->equations[i].y : 0,
		    .sigma_m = corrected ? g->sigma_m : 0,
		    .iono_m = corrected ? g->iono_scale * g->iono_m : 0,
		    .tropo_m = corrected ? g->tropo_m : 0,
		};
	}
}

static void report(const solver *s, fw_time tag, double scale, fw_solution *out)
{
	unsigned first = 0;
	while (first + 1 < FW_SYSTEM_COUNT && (s->systems >> first & 1) == 0)
		first++;
	const double clock_s = s->clock_m[first] / FW_SPEED_OF_LIGHT_MPS;
	out->time = fabs(clock_s) < 1 ? fw_time_add_ns(tag, -(int64_t)llround(clock_s * 1e9)) : tag;
	memcpy(out->position_m, s->position_m, sizeof out->position_m);
	if (fw_ecef_to_llh(s->position_m, out->llh) !=
	    FW_OK) /* it was a place before the last step, of 0.1 mm at most */
		memcpy(out->llh, s->llh, sizeof out->llh);
	for (unsigned k = 0; k < FW_SYSTEM_COUNT; k++)
		out->clock_m[k] = (s->systems >> k & 1) != 0 ? s->clock_m[k] : 0;
	out->systems = s->systems;
	out->chi2 = s->chi2;
	out->redundancy = s->redundancy;
	out->variance_factor = scale;
	position_covariance(s, scale, out->covariance_m2);
	report_satellites(s, out);
}

static void prepare(solver *s, const fw_range *ranges, unsigned n, fw_time tag,
                    const fw_iono_coefficients *iono, const fw_single_point_options *options)
{
	int week, day = 1;
	fw_civil date;
	s->options = options;
	s->iono = iono;
	s->tag = tag;
	s->n = n < FW_RANGE_MAX ? n : FW_RANGE_MAX;
	for (unsigned i = 0; i < s->n; i++)
		s->sights[i] = (sight){.range = &ranges[i]};
	fw_time_to_gps_s(tag, &week, &s->tow_s);
	if (options->tropo == FW_TROPO_MOPS && fw_time_to_civil(tag, &date) == FW_OK)
		(void)!fw_civil_day_of_year(&date, &day);
	s->day_of_year = day;
}

static void remember(const solver *s, const fw_solution *out, double past_chi2, double past_dof,
                     fw_single_point_memory *m)
{
	m->has_position = true;
	m->time = s->tag;
	memcpy(m->position_m, out->position_m, sizeof m->position_m);
	memset(m->velocity_mps, 0, sizeof m->velocity_mps);
	if (out->has_velocity)
		fw_mat3_vec(s->C_e_n, out->velocity_mps, m->velocity_mps);
	m->chi2 = past_chi2 + s->chi2;
	m->dof = past_dof + s->redundancy;
}

fw_single_point_status fw_single_point_ranges(const fw_range *ranges, unsigned n, fw_time tag,
                                              const fw_iono_coefficients *iono,
                                              const fw_single_point_options *options,
                                              fw_single_point_memory *memory, fw_solution *solution)
{
	fw_single_point_memory none = {0}, *m = memory != NULL ? memory : &none;
	solver s;
	fw_solution out;
	if (n == 0)
		return FW_SP_NO_RANGES;
	prepare(&s, ranges, n, tag, iono, options);
	const double fade = fading(m, tag), past_chi2 = fade * m->chi2, past_dof = fade * m->dof;
	fw_single_point_status status = locate(&s, m);
	if (status == FW_SP_OK)
		status = exclude_outliers(&s, (1 + past_chi2) / (1 + past_dof), 1 + fmin(past_dof, 10));
	if (status == FW_SP_OK)
		status = dilute(&s, &out);
	if (status != FW_SP_OK)
		return status;
	report(&s, tag, variance_factor(s.chi2, s.redundancy, past_chi2, past_dof), &out);
	m->rate_chi2 *= fade;
	m->rate_dof *= fade;
	out.has_velocity = false;
	if (!options->no_velocity)
		find_velocity(&s, m, &out);
	remember(&s, &out, past_chi2, past_dof, m);
	*solution = out;
	return FW_SP_OK;
}

fw_single_point_status fw_single_point(const fw_epoch *epoch, const fw_ephemeris_source *source,
                                       const fw_iono_coefficients *iono,
                                       const fw_single_point_options *options, fw_single_point_memory *memory,
                                       fw_solution *solution)
{
	fw_range ranges[FW_RANGE_MAX];
	unsigned n = 0;
	const unsigned bands = options->iono == FW_IONO_FREE       ? 2
	                       : options->iono == FW_IONO_WEIGHTED ? FW_RANGE_CODES
	                                                           : 1;
	const fw_signal_choice *signals = options->signals != NULL ? options->signals : &fw_signals_default;
	if (fw_range_prepare(epoch, source, signals, options->systems, bands, ranges, &n) != FW_OK)
		return FW_SP_NO_RANGES;
	return fw_single_point_ranges(ranges, n, epoch->time, iono, options, memory, solution);
}
