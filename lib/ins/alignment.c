#include "ins/alignment.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "ins/gravity.h"

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

static void cross(const double a[3], const double b[3], double c[3])
{
	c[0] = a[1] * b[2] - a[2] * b[1];
	c[1] = a[2] * b[0] - a[0] * b[2];
	c[2] = a[0] * b[1] - a[1] * b[0];
}

static bool imu_is_sane(const fw_align_imu *imu)
{
	return imu->gyro_bias_sd >= 0 && imu->gyro_noise >= 0 && imu->accel_bias_sd >= 0 &&
	       imu->accel_noise >= 0 && imu->scale_sd >= 0;
}

static double scale_sd(const fw_align_imu *imu)
{
	return imu->scale_sd > 0 ? imu->scale_sd : 1e-3;
}

/* Of a mean over some time: the bias stays, white noise shrinks. */
static double mean_sd(double bias_sd, double noise, double seconds)
{
	return hypot(bias_sd, noise / sqrt(seconds));
}

/* ---- an attitude with its errors ---- */

/* How roll, pitch and heading change with the rotation vector phi, NED, at an attitude. */
static void angles_by_rotation(const double rpy[3], double J[3][3])
{
	double c = cos(rpy[2]), s = sin(rpy[2]), cp = fmax(cos(rpy[1]), 1e-9), tp = sin(rpy[1]) / cp;
	double rows[3][3] = {{c / cp, s / cp, 0}, {-s, c, 0}, {c * tp, s * tp, 1}};

	memcpy(J, rows, sizeof(rows));
}

/* The same the other way round: the axes about which the angles turn, as columns. */
static void rotation_by_angles(const double rpy[3], double J[3][3])
{
	double c = cos(rpy[2]), s = sin(rpy[2]), cp = cos(rpy[1]), sp = sin(rpy[1]);
	double rows[3][3] = {{c * cp, -s, 0}, {s * cp, c, 0}, {-sp, 0, 1}};

	memcpy(J, rows, sizeof(rows));
}

static void set_attitude(const double C_n_b[3][3], const double covariance[3][3], fw_alignment *a)
{
	double J[3][3], variance[3][3];

	fw_quat_from_matrix(C_n_b, a->q_n_b);
	fw_matrix_to_euler(C_n_b, a->rpy_rad);
	memcpy(a->covariance_rad2, covariance, sizeof(a->covariance_rad2));
	angles_by_rotation(a->rpy_rad, J);
	fw_mat_sandwich(3, 3, J[0], covariance[0], variance[0]);
	for (int i = 0; i < 3; i++)
		a->sd_rad[i] = fmin(sqrt(variance[i][i]), FW_PI);
}

fw_status fw_align_from_angles(const double rpy_rad[3], const double sd_rad[3], fw_alignment *a)
{
	double C[3][3], J[3][3], variance[3][3] = {{0}}, covariance[3][3];

	if (!all_finite(3, rpy_rad) || !all_finite(3, sd_rad))
		return FW_ENONFINITE;
	if (!(fabs(rpy_rad[1]) <= FW_PI / 2) || sd_rad[0] < 0 || sd_rad[1] < 0 || sd_rad[2] < 0)
		return FW_EINVAL;
	for (int i = 0; i < 3; i++)
		variance[i][i] = sd_rad[i] * sd_rad[i];
	rotation_by_angles(rpy_rad, J);
	fw_mat_sandwich(3, 3, J[0], variance[0], covariance[0]);
	fw_euler_to_matrix(rpy_rad, C);
	set_attitude(C, covariance, a);
	memcpy(a->sd_rad, sd_rad, sizeof(a->sd_rad));
	return FW_OK;
}

/* ---- standing still ---- */

/* Whether a mean has the length that it has at rest, within a share of it and 5 sigma. */
static bool at_rest(const double mean[3], double expected, double share, double sd)
{
	return fabs(length(mean) - expected) <= share * expected + 5 * sd;
}

fw_status fw_align_level(const double force_b[3], double seconds, double gravity_mps2,
                         const fw_align_imu *imu, double rp_rad[2], double sd_rad[2])
{
	double sd, across;

	if (!all_finite(3, force_b))
		return FW_ENONFINITE;
	if (!(seconds > 0) || !(gravity_mps2 > 0) || !imu_is_sane(imu))
		return FW_EINVAL;
	sd = mean_sd(imu->accel_bias_sd, imu->accel_noise, seconds);
	if (!at_rest(force_b, gravity_mps2, 0.05, sd))
		return FW_ERANGE;
	across = hypot(force_b[1], force_b[2]); /* all but the part along the nose */
	rp_rad[0] = atan2(-force_b[1], -force_b[2]);
	rp_rad[1] = atan2(force_b[0], across);
	sd_rad[0] = across * FW_PI > sd ? sd / across : FW_PI;
	sd_rad[1] = sd / gravity_mps2;
	return FW_OK;
}

/* Errors of a gyrocompass: the force's east and north errors tilt it, and the gyro's east error turns it, as
 * far as the Earth's rotation is horizontal; the tilt about north turns it too, since the rotation is
 * vertical as well. */
static void gyrocompass_covariance(double lat_rad, double gravity, double force_sd, double gyro_sd,
                                   double P[3][3])
{
	double tilt = force_sd / gravity, turn = gyro_sd / (FW_EARTH_RATE_RADPS * cos(lat_rad));
	double lean = tan(lat_rad);
	double rows[3][3] = {{tilt * tilt, 0, -lean * tilt * tilt},
	                     {0, tilt * tilt, 0},
	                     {-lean * tilt * tilt, 0, turn * turn + lean * lean * tilt * tilt}};

	memcpy(P, rows, sizeof(rows));
}

/* The rows of C_n_b are north, east and down as the body sees them. */
static void attitude_from_north_and_down(const double force_b[3], const double omega_b[3], double C_n_b[3][3])
{
	double down = -length(force_b), east;

	for (int i = 0; i < 3; i++)
		C_n_b[2][i] = force_b[i] / down;
	cross(C_n_b[2], omega_b, C_n_b[1]);
	east = length(C_n_b[1]);
	for (int i = 0; i < 3; i++)
		C_n_b[1][i] /= east;
	cross(C_n_b[1], C_n_b[2], C_n_b[0]);
}

fw_status fw_align_gyrocompass(const double force_b[3], const double omega_ib_b[3], double seconds,
                               const double llh[3], const fw_align_imu *imu, double heading_sd_limit_rad,
                               fw_alignment *a)
{
	double C[3][3], P[3][3], gravity, force_sd, gyro_sd;

	if (!all_finite(3, force_b) || !all_finite(3, omega_ib_b) || !all_finite(3, llh))
		return FW_ENONFINITE;
	if (!(seconds > 0) || !imu_is_sane(imu) || !(fabs(llh[0]) <= FW_PI / 2) ||
	    !(heading_sd_limit_rad > 0))
		return FW_EINVAL;
	gravity = fw_gravity_mps2(llh[0], llh[2]);
	force_sd = mean_sd(imu->accel_bias_sd, imu->accel_noise, seconds);
	gyro_sd = mean_sd(imu->gyro_bias_sd, imu->gyro_noise, seconds);
	gyrocompass_covariance(llh[0], gravity, force_sd, gyro_sd, P);
	if (!(sqrt(P[2][2]) <= heading_sd_limit_rad))
		return FW_ESINGULAR;
	if (!at_rest(force_b, gravity, 0.05, force_sd) ||
	    !at_rest(omega_ib_b, FW_EARTH_RATE_RADPS, 0.1, gyro_sd))
		return FW_ERANGE;
	attitude_from_north_and_down(force_b, omega_ib_b, C);
	if (!all_finite(9, C[0]))
		return FW_ESINGULAR;
	set_attitude(C, P, a);
	return FW_OK;
}

/* ---- course over ground ---- */

fw_status fw_align_course(const double velocity_mps[3], double sd_mps, double *heading_rad, double *sd_rad)
{
	double speed = hypot(velocity_mps[0], velocity_mps[1]);

	if (!all_finite(3, velocity_mps) || !isfinite(sd_mps))
		return FW_ENONFINITE;
	if (!(sd_mps > 0))
		return FW_EINVAL;
	if (!(speed >= 3 * sd_mps))
		return FW_ESINGULAR;
	*heading_rad = fw_wrap_2pi(atan2(velocity_mps[1], velocity_mps[0]));
	*sd_rad = sd_mps / speed;
	return FW_OK;
}

/* ---- in motion: the integrals of a window ---- */

enum { IX_R = 0, IX_BG = 9, IX_BA = 12, IX_E0 = 15, IX_ONE = 18 };

/* Velocities after the first that it takes before a window is asked. */
enum { ROWS_MIN = 8 };

/* n0 to the present n: the Earth has turned since, and the vehicle has gone elsewhere. */
static void frozen_from_local(const fw_align_window *w, fw_time t, const double llh[3], double C_n0_n[3][3])
{
	double turn[3] = {0, 0, FW_EARTH_RATE_RADPS * fw_time_diff_s(t, w->t0)};
	double q[4], C_i_e[3][3], C_e_n[3][3], C_i_n[3][3], C_n0_i[3][3];

	fw_quat_from_rotvec(turn, q);
	fw_quat_to_matrix(q, C_i_e);
	fw_frame_ned(llh[0], llh[1], C_e_n);
	fw_mat3_mul(C_i_e, C_e_n, C_i_n);
	fw_mat3_transpose(w->C_e_n0, C_n0_i);
	fw_mat3_mul(C_n0_i, C_i_n, C_n0_n);
}

/* What velocity gains in the frozen frame besides the specific force, with the sign of alpha: omega_ie x v -
 * g. */
static void push_rate(const double C_n0_n[3][3], const double llh[3], const double v[3], double rate_n0[3])
{
	double omega_ie[3] = {FW_EARTH_RATE_RADPS * cos(llh[0]), 0, -FW_EARTH_RATE_RADPS * sin(llh[0])};
	double rate[3];

	cross(omega_ie, v, rate);
	rate[2] -= fw_gravity_mps2(llh[0], llh[2]);
	fw_mat3_vec(C_n0_n, rate, rate_n0);
}

/* Velocity of the antenna against the IMU, in b0. */
static void lever_velocity(const fw_align_motion *m, const fw_align_window *w, double v_b0[3])
{
	double C[3][3], v_b[3];

	cross(m->omega_b, m->setup.lever_b, v_b);
	fw_quat_to_matrix(w->q_b0_b, C);
	fw_mat3_vec(C, v_b, v_b0);
}

static void window_begin(const fw_align_motion *m, fw_align_window *w)
{
	double C[3][3];

	*w = (fw_align_window){.begun = true,
	                       .t0 = m->t_waiting,
	                       .t_velocity = m->t_waiting,
	                       .q_b0_b = {1, 0, 0, 0},
	                       .q_last = {1, 0, 0, 0},
	                       .sd0_mps = m->sd_mps};
	memcpy(w->gyro_bias, m->gyro_bias, sizeof(w->gyro_bias));
	memcpy(w->gyro_bias_sd, m->gyro_bias_sd, sizeof(w->gyro_bias_sd));
	memcpy(w->v0, m->velocity_mps, sizeof(w->v0));
	lever_velocity(m, w, w->lever0);
	fw_frame_ned(m->llh[0], m->llh[1], w->C_e_n0);
	frozen_from_local(w, w->t0, m->llh, C);
	push_rate(C, m->llh, m->velocity_mps, w->push_rate);
}

/* Over an interval, or the part of one: angle and velocity are increments without the known biases. */
static void window_advance(fw_align_window *w, double dt, const double angle[3], const double velocity[3])
{
	double C[3][3], S[3][3], SJ[3][3], turned[3], gain[3], q[4], next[4], half[3];

	/* The velocity increment as it points at the begin of the interval: half the turn later than the
	 * frame. */
	cross(angle, velocity, turned);
	for (int i = 0; i < 3; i++) {
		turned[i] = velocity[i] + turned[i] / 2;
		half[i] = angle[i] / 2;
	}
	fw_quat_to_matrix(w->q_b0_b, C);
	fw_mat3_vec(C, turned, gain);
	fw_quat_from_rotvec(half, q);
	fw_quat_mul(w->q_b0_b, q, next);
	fw_quat_to_matrix(next, C); /* in the middle */
	fw_skew(gain, S);
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			w->theta[i][j] += C[i][j] * dt / 2;
	fw_mat3_mul(S, w->theta, SJ);
	for (int i = 0; i < 3; i++) {
		w->beta[i] += gain[i];
		for (int j = 0; j < 3; j++) {
			w->J[i][j] += SJ[i][j];
			w->theta[i][j] += C[i][j] * dt / 2;
		}
	}
	fw_quat_mul(next, q, w->q_b0_b);
	if (fw_quat_normalise(w->q_b0_b) != FW_OK)
		w->begun = false;
}

/* The rows of a velocity, R^T alpha - beta - J b_g + Theta b_a - e0 = 0. */
static void rows_of(const fw_align_window *w, const double alpha[3], const double beta[3],
                    double h[3][FW_ALIGN_FORM])
{
	memset(h, 0, sizeof(double[3][FW_ALIGN_FORM]));
	for (int k = 0; k < 3; k++) {
		for (int j = 0; j < 3; j++) {
			h[k][IX_R + 3 * j + k] = alpha[j];
			h[k][IX_BG + j] = -w->J[k][j];
			h[k][IX_BA + j] = w->theta[k][j];
		}
		h[k][IX_E0 + k] = -1;
		h[k][IX_ONE] = -beta[k];
	}
}

/* Adds the rows to the form, each over its sigma. Vertical velocity is as a rule the worse half of GNSS and
 * says next to nothing about attitude: its part of the residuals, which is along beta, is halved. */
static void form_add(fw_align_window *w, const double alpha[3], const double beta[3], double sd)
{
	double h[3][FW_ALIGN_FORM], L[3][3], weighted[3][FW_ALIGN_FORM], square = 0;

	for (int k = 0; k < 3; k++)
		square += beta[k] * beta[k];
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			L[i][j] = ((i == j) - (square > 0 ? beta[i] * beta[j] / square / 2 : 0)) / sd;
	rows_of(w, alpha, beta, h);
	fw_mat_mul(3, 3, FW_ALIGN_FORM, L[0], h[0], weighted[0]);
	for (int k = 0; k < 3; k++)
		for (int i = 0; i < FW_ALIGN_FORM; i++)
			for (int j = 0; j < FW_ALIGN_FORM; j++)
				w->form[i][j] += weighted[k][i] * weighted[k][j];
	w->rows++;
}

/* Sigma of a velocity with what the model of the IMU leaves out: the part of the gyros' random walk that is
 * no slope, and scale factors and misalignments, which tilt by a share of all turns. Both come as velocity by
 * way of gravity. They change slowly, as if a quarter of the window's velocities had them alike: so many
 * times each of these counts more. */
static double sd_with_drift(const fw_align_motion *m, const fw_align_window *w, double interval)
{
	double t = fw_time_diff_s(m->t_waiting, w->t0), alike = fmax(1, t / 4 / interval);
	double walk = 9.8 * m->setup.imu.gyro_noise * t * sqrt(t) / 27;
	double tilt = 9.8 * scale_sd(&m->setup.imu) * w->turned * t / 8;

	return sqrt(m->sd_mps * m->sd_mps + alike * (walk * walk + tilt * tilt));
}

/* How far the body has turned since the last velocity, which noise makes hardly longer. */
static void count_turns(fw_align_window *w)
{
	double back[4] = {w->q_last[0], -w->q_last[1], -w->q_last[2], -w->q_last[3]}, q[4];

	fw_quat_mul(back, w->q_b0_b, q);
	w->turned += 2 * asin(fmin(1, length(q + 1)));
	memcpy(w->q_last, w->q_b0_b, sizeof(w->q_last));
}

/* Takes the waiting velocity, to whose time the window has been advanced. */
static void window_velocity(const fw_align_motion *m, fw_align_window *w)
{
	double dt = fw_time_diff_s(m->t_waiting, w->t_velocity), C[3][3], rate[3], v_n0[3], lever[3];
	double alpha[3], beta[3];

	if (!(dt > 0))
		return;
	frozen_from_local(w, m->t_waiting, m->llh, C);
	push_rate(C, m->llh, m->velocity_mps, rate);
	fw_mat3_vec(C, m->velocity_mps, v_n0);
	lever_velocity(m, w, lever);
	for (int i = 0; i < 3; i++) {
		w->push[i] += (w->push_rate[i] + rate[i]) / 2 * dt;
		w->push_rate[i] = rate[i];
		alpha[i] = v_n0[i] - w->v0[i] + w->push[i];
		beta[i] = w->beta[i] + lever[i] - w->lever0[i];
	}
	w->t_velocity = m->t_waiting;
	count_turns(w);
	form_add(w, alpha, beta, sd_with_drift(m, w, dt));
}

/* ---- in motion: least squares ---- */

enum { N_OTHERS = 9, N_UNKNOWNS = 3 + N_OTHERS }; /* turn of R about the axes of b0; b_g, b_a, e0 */

typedef struct {
	double R[3][3];
	double others[N_OTHERS];
	double cost; /* sum of squares, each over its variance: with what was known before of the others */
	double normal[N_UNKNOWNS][N_UNKNOWNS];
} guess;

typedef struct {
	const fw_align_window *window;
	double weight[N_OTHERS]; /* 1 / variance of the others beforehand */
} problem;

/* Biases beforehand. A random walk of the angle is most of all a slope, which looks like a bias: noise /
 * sqrt(time). */
static void set_weights(const fw_align_motion *m, const fw_align_window *w, problem *p)
{
	const fw_align_imu *imu = &m->setup.imu;
	double seconds = fw_time_diff_s(w->t_velocity, w->t0);
	double accel =
	    fmax(hypot(mean_sd(imu->accel_bias_sd, imu->accel_noise, seconds), 9.8 * scale_sd(imu)), 1e-8);

	p->window = w;
	for (int i = 0; i < 3; i++) {
		double gyro = fmax(mean_sd(w->gyro_bias_sd[i], imu->gyro_noise, seconds), 1e-10);

		p->weight[i] = 1 / (gyro * gyro);
		p->weight[3 + i] = 1 / (accel * accel);
		p->weight[6 + i] = 1 / (w->sd0_mps * w->sd0_mps);
	}
}

/* The form's variables at a guess. */
static void variables(const guess *g, double x[FW_ALIGN_FORM])
{
	memcpy(x, g->R, sizeof(g->R));
	memcpy(x + IX_BG, g->others, sizeof(g->others));
	x[IX_ONE] = 1;
}

static double cost_of(const problem *p, const guess *g)
{
	double x[FW_ALIGN_FORM], sum = 0;

	variables(g, x);
	for (int i = 0; i < FW_ALIGN_FORM; i++)
		for (int j = 0; j < FW_ALIGN_FORM; j++)
			sum += x[i] * p->window->form[i][j] * x[j];
	for (int i = 0; i < N_OTHERS; i++)
		sum += p->weight[i] * g->others[i] * g->others[i];
	return sum;
}

/* How the form's variables change with the unknowns: R (I + [psi x]), the others by themselves. */
static void tangent(const guess *g, double X[FW_ALIGN_FORM][N_UNKNOWNS])
{
	memset(X, 0, sizeof(double[FW_ALIGN_FORM][N_UNKNOWNS]));
	for (int m = 0; m < 3; m++) {
		double axis[3] = {m == 0, m == 1, m == 2}, S[3][3], RS[3][3];

		fw_skew(axis, S);
		fw_mat3_mul(g->R, S, RS);
		for (int i = 0; i < 9; i++)
			X[IX_R + i][m] = RS[i / 3][i % 3];
	}
	for (int i = 0; i < N_OTHERS; i++)
		X[IX_BG + i][3 + i] = 1;
}

/* A guess moved by a share of a step. */
static void move(const guess *from, const double step[N_UNKNOWNS], double share, guess *to)
{
	double psi[3] = {step[0] * share, step[1] * share, step[2] * share}, q[4], turn[3][3];

	fw_quat_from_rotvec(psi, q);
	fw_quat_to_matrix(q, turn);
	fw_mat3_mul(from->R, turn, to->R);
	for (int i = 0; i < N_OTHERS; i++)
		to->others[i] = from->others[i] + step[3 + i] * share;
}

/* Normal matrix at a guess, and the step to the minimum as it seems from there. */
static fw_status newton_step(const problem *p, guess *g, double step[N_UNKNOWNS])
{
	double x[FW_ALIGN_FORM], X[FW_ALIGN_FORM][N_UNKNOWNS], NX[FW_ALIGN_FORM][N_UNKNOWNS];

	variables(g, x);
	tangent(g, X);
	fw_mat_mul(FW_ALIGN_FORM, FW_ALIGN_FORM, N_UNKNOWNS, p->window->form[0], X[0], NX[0]);
	fw_mat_t_mul(N_UNKNOWNS, FW_ALIGN_FORM, N_UNKNOWNS, X[0], NX[0], g->normal[0]);
	fw_mat_t_mul(N_UNKNOWNS, FW_ALIGN_FORM, 1, NX[0], x, step);
	for (int i = 0; i < N_OTHERS; i++) {
		g->normal[3 + i][3 + i] += p->weight[i];
		step[3 + i] += p->weight[i] * g->others[i];
	}
	for (int i = 0; i < N_UNKNOWNS; i++)
		step[i] = -step[i];
	return fw_mat_solve_spd(N_UNKNOWNS, 1, g->normal[0], step, step);
}

/* Gauss-Newton downhill; steps that lead up are halved. Leaves the normal matrix of the last step. */
static fw_status descend(const problem *p, guess *g)
{
	g->cost = cost_of(p, g);
	for (int i = 0; i < 30; i++) {
		double step[N_UNKNOWNS], share = 1, drop;
		fw_status status = newton_step(p, g, step);
		guess next = *g;

		if (status != FW_OK)
			return status;
		do {
			move(g, step, share, &next);
			next.cost = cost_of(p, &next);
			share /= 2;
		} while (!(next.cost <= g->cost) && share > 1e-3);
		drop = g->cost - next.cost;
		if (!(drop >= 0))
			return FW_OK; /* no lower: rounding has the last word */
		*g = next;
		if (drop < 1e-6)
			return FW_OK;
	}
	return FW_ENOCONV;
}

/* Makes the normal matrix the exact one, half the second derivatives of the cost. Gauss and Newton's leaves
 * out how the residuals bend with R; but then the noise of alpha, squared, looks like motion, and a vehicle
 * at rest would seem to know its heading. */
static void bend(const problem *p, guess *g)
{
	double x[FW_ALIGN_FORM], Nx[FW_ALIGN_FORM], RtG[3][3], trace;

	variables(g, x);
	fw_mat_mul(FW_ALIGN_FORM, FW_ALIGN_FORM, 1, p->window->form[0], x, Nx);
	fw_mat_t_mul(3, 3, 3, g->R[0], Nx + IX_R, RtG[0]);
	trace = RtG[0][0] + RtG[1][1] + RtG[2][2];
	for (int i = 0; i < 3; i++) /* d2R / dpsi_i dpsi_j = R ((e_i e_j^T + e_j e_i^T) / 2 - I [i = j]) */
		for (int j = 0; j < 3; j++)
			g->normal[i][j] += (RtG[i][j] + RtG[j][i]) / 2 - (i == j ? trace : 0);
}

/* A beginning: level by the direction that answers to alpha's vertical, which is gravity's, at a heading. */
static void level_guess(const fw_align_window *w, double heading, guess *g)
{
	double level[3][3], north[3] = {1, 0, 0}, turn[3][3], up[3], rpy[3] = {0, 0, heading};

	/* Minus the sum of alpha_d beta_k: as time goes on, beta grows upwards and alpha_d is negative. */
	for (int k = 0; k < 3; k++)
		up[k] = w->form[IX_R + 6 + k][IX_ONE];
	if (fabs(up[0]) > 0.9 * length(up)) { /* nose up or down: north is then where belly or back looks */
		north[0] = 0;
		north[2] = up[0] < 0 ? -1 : 1;
	}
	attitude_from_north_and_down(up, north, level);
	fw_euler_to_matrix(rpy, turn);
	fw_mat3_mul(turn, level, g->R);
	memset(g->others, 0, sizeof(g->others));
}

/* The least of the minima found from several headings. *margin: by how much the next one is worse, INFINITY
 * without one. */
static fw_status best_guess(const problem *p, guess *best, double *margin)
{
	enum { STARTS = 6 };
	guess found[STARTS];
	int n = 0, least = 0;

	for (int i = 0; i < STARTS; i++) {
		level_guess(p->window, i * 2 * FW_PI / STARTS, &found[n]);
		if (descend(p, &found[n]) == FW_OK)
			n++;
	}
	if (n == 0)
		return FW_ENOCONV;
	for (int i = 1; i < n; i++)
		if (found[i].cost < found[least].cost)
			least = i;
	*best = found[least];
	*margin = (double)INFINITY;
	for (int i = 0; i < n; i++) {
		double trace = 0; /* 1 + 2 cos of the angle between the two */

		for (int j = 0; j < 9; j++)
			trace += found[i].R[j / 3][j % 3] * best->R[j / 3][j % 3];
		if (trace < 1 + 2 * cos(0.2))
			*margin = fmin(*margin, found[i].cost - best->cost);
	}
	return FW_OK;
}

/* Least squares over a window: the best guess, the covariance of its unknowns, the mean square of the
 * residuals over what was promised, and the margin of best_guess. */
static fw_status solve_window(const fw_align_motion *m, const fw_align_window *w, problem *p, guess *g,
                              double P[N_UNKNOWNS][N_UNKNOWNS], double *misfit2, double *margin)
{
	fw_status status;

	set_weights(m, w, p);
	status = best_guess(p, g, margin);
	if (status != FW_OK)
		return status;
	bend(p, g);
	status = fw_mat_inverse_spd(N_UNKNOWNS, g->normal[0], P[0]);
	*misfit2 = fmax(0, g->cost) / (3 * w->rows - 3);
	for (int i = 0; i < N_UNKNOWNS; i++)
		for (int j = 0; j < N_UNKNOWNS; j++)
			P[i][j] *= fmax(1, *misfit2);
	return status;
}

/* What a window says about the gyros' biases is what the next one stands on; no better than a twentieth of
 * what they began with, since they move. */
static void learn_bias(fw_align_motion *m, const fw_align_window *w)
{
	double P[N_UNKNOWNS][N_UNKNOWNS], misfit2, margin;
	problem p;
	guess g;

	if (w->rows < ROWS_MIN / 2 || solve_window(m, w, &p, &g, P, &misfit2, &margin) != FW_OK)
		return;
	for (int i = 0; i < 3; i++) {
		double sd = fmax(sqrt(P[3 + i][3 + i]), m->setup.imu.gyro_bias_sd / 20);

		if (sd < m->gyro_bias_sd[i]) {
			m->gyro_bias[i] = w->gyro_bias[i] + g.others[i];
			m->gyro_bias_sd[i] = sd;
		}
	}
}

/* ---- in motion: two windows that take turns ---- */

/* As long as first-order effects of the gyros' biases are the whole to about 5 cm/s: gravity is what they
 * tilt (g b^2 T^3 / 6), but the worst known axis is taken to be the vertical, about which they only turn the
 * horizontal accelerations (by at most a seventh of a radian). And as long as their noise does no more than
 * that either: of a random walk's integral, less offset, slope and curvature, about g N T^(3/2) / 27 is
 * left. */
static double longest_window(const fw_align_motion *m)
{
	const double *sd = m->gyro_bias_sd;
	double worst = fmax(sd[0], fmax(sd[1], sd[2]));
	double tilting = sd[0] * sd[0] + sd[1] * sd[1] + sd[2] * sd[2] - worst * worst;
	double by_bias = fmin(cbrt(6 * 0.05 / 9.8 / tilting), 0.15 / worst);
	double by_noise = pow(0.05 * 27 / (9.8 * m->setup.imu.gyro_noise), 2 / 3.0);

	return m->setup.window_s > 0 ? m->setup.window_s : fmax(5, fmin(600, fmin(by_bias, by_noise)));
}

fw_status fw_align_motion_init(const fw_align_motion_setup *setup, fw_align_motion *m)
{
	const fw_align_imu *imu = &setup->imu;

	if (!all_finite(3, setup->gyro_bias) || !all_finite(3, setup->accel_bias) ||
	    !all_finite(3, setup->lever_b))
		return FW_ENONFINITE;
	if (!imu_is_sane(imu) || !(setup->window_s >= 0))
		return FW_EINVAL;
	*m = (fw_align_motion){.setup = *setup};
	for (int i = 0; i < 3; i++) {
		m->gyro_bias[i] = setup->gyro_bias[i];
		m->gyro_bias_sd[i] = imu->gyro_bias_sd;
	}
	return FW_OK;
}

/* A new window, about the biases as they are known by now. */
static void begin(fw_align_motion *m, fw_align_window *w)
{
	window_begin(m, w);
	w->longest_s = longest_window(m);
}

/* Whether a window has done a share of its time, and has had that share of the velocities that it takes to be
 * of use. */
static bool through(const fw_align_motion *m, const fw_align_window *w, double share)
{
	return fw_time_diff_s(m->t_waiting, w->t0) >= share * w->longest_s && w->rows >= share * ROWS_MIN;
}

static void take_velocity(fw_align_motion *m)
{
	fw_align_window *old = &m->window[0], *young = &m->window[1];

	m->waiting = false;
	for (int i = 0; i < 2; i++)
		if (m->window[i].begun)
			window_velocity(m, &m->window[i]);
	if (old->begun && through(m, old, 1)) {
		learn_bias(m, old);
		*old = *young;
		young->begun = false;
	}
	if (!old->begun) {
		begin(m, old);
	} else if (!young->begun && through(m, old, 0.5)) {
		learn_bias(m, old);
		begin(m, young);
	}
}

static void advance(fw_align_motion *m, double dt, const double rate[3], const double force[3])
{
	double angle[3], velocity[3];

	for (int k = 0; k < 2; k++) {
		fw_align_window *w = &m->window[k];

		for (int i = 0; i < 3; i++) {
			angle[i] = (rate[i] - w->gyro_bias[i]) * dt;
			velocity[i] = force[i] * dt;
		}
		if (w->begun)
			window_advance(w, dt, angle, velocity);
	}
}

/* Where an increment begins: where the last one ended, unless there is none or the gap is too wide. */
static fw_time interval_begin(fw_align_motion *m, fw_time end, double dt)
{
	fw_time begin = fw_time_add_ns(end, -(int64_t)llround(dt * 1e9));
	bool bridged = m->running && fw_time_diff_s(end, m->t) <= fmax(0.1, 3 * dt);

	if (bridged)
		return m->t;
	m->window[0].begun = m->window[1].begun = false;
	m->running = true;
	if (m->waiting && fw_time_compare(m->t_waiting, begin) < 0)
		m->waiting = false;
	return begin;
}

fw_status fw_align_motion_imu(fw_align_motion *m, fw_time end, const fw_increment *raw)
{
	double rate[3], force[3], dt, before = 0;
	fw_time begin;

	if (!all_finite(3, raw->angle_rad) || !all_finite(3, raw->velocity_mps) || !isfinite(raw->dt_s))
		return FW_ENONFINITE;
	if (!(raw->dt_s > 0) || !(raw->dt_s <= 1) || (m->running && fw_time_compare(end, m->t) <= 0))
		return FW_EINVAL;
	begin = interval_begin(m, end, raw->dt_s);
	dt = fw_time_diff_s(end, begin);
	for (int i = 0; i < 3; i++) {
		rate[i] = raw->angle_rad[i] / raw->dt_s;
		m->omega_b[i] = rate[i] - m->gyro_bias[i];
		force[i] = raw->velocity_mps[i] / raw->dt_s - m->setup.accel_bias[i];
	}
	if (m->waiting && fw_time_compare(m->t_waiting, end) <= 0) {
		before = fw_time_diff_s(m->t_waiting, begin);
		advance(m, before, rate, force);
		take_velocity(m);
	}
	advance(m, dt - before, rate, force);
	m->t = end;
	return FW_OK;
}

fw_status fw_align_motion_velocity(fw_align_motion *m, fw_time t, const double llh[3],
                                   const double velocity_mps[3], double sd_mps)
{
	if (!all_finite(3, llh) || !all_finite(3, velocity_mps) || !isfinite(sd_mps))
		return FW_ENONFINITE;
	if (!(sd_mps > 0) || !(fabs(llh[0]) <= FW_PI / 2) || (m->running && fw_time_compare(t, m->t) < 0))
		return FW_EINVAL;
	memcpy(m->llh, llh, sizeof(m->llh));
	memcpy(m->velocity_mps, velocity_mps, sizeof(m->velocity_mps));
	m->sd_mps = sd_mps;
	m->t_waiting = t;
	m->waiting = true;
	if (m->running && fw_time_compare(t, m->t) == 0)
		take_velocity(m);
	return FW_OK;
}

/* ---- in motion: the answer ---- */

/* Attitude now: C_n_b = C_n_n0 R C_b0_b, the last with the bias found. An error of R turns it all, one of the
 * bias turns it since t0. */
static void attitude_now(const fw_align_motion *m, const problem *p, const guess *g,
                         const double P[N_UNKNOWNS][N_UNKNOWNS], fw_alignment *a)
{
	const fw_align_window *w = p->window;
	double drift[3], q[4], C_n0_n[3][3], C_n_n0[3][3], C_n_b0[3][3], turned[3][3], C_b0_b[3][3], C[3][3];
	double E[3][N_UNKNOWNS] = {{0}}, lag[3][3], covariance[3][3];

	fw_mat3_vec(w->theta, g->others, drift);
	for (int i = 0; i < 3; i++)
		drift[i] = -drift[i];
	fw_quat_from_rotvec(drift, q);
	fw_quat_to_matrix(q, turned);
	fw_quat_to_matrix(w->q_b0_b, C);
	fw_mat3_mul(turned, C, C_b0_b);
	frozen_from_local(w, m->t, m->llh, C_n0_n);
	fw_mat3_transpose(C_n0_n, C_n_n0);
	fw_mat3_mul(C_n_n0, g->R, C_n_b0);
	fw_mat3_mul(C_n_b0, C_b0_b, C);
	fw_mat3_mul(C_n_b0, w->theta, lag);
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++) {
			E[i][j] = C_n_b0[i][j];
			E[i][3 + j] = -lag[i][j];
		}
	fw_mat_sandwich(3, N_UNKNOWNS, E[0], P[0], covariance[0]);
	for (int i = 0; i < 3; i++)
		covariance[i][i] += pow(scale_sd(&m->setup.imu) * w->turned / 2, 2);
	set_attitude(C, covariance, a);
}

static void set_biases(const fw_align_motion *m, const problem *p, const guess *g,
                       const double P[N_UNKNOWNS][N_UNKNOWNS], fw_align_motion_answer *answer)
{
	for (int i = 0; i < 3; i++) {
		answer->gyro_bias[i] = p->window->gyro_bias[i] + g->others[i];
		answer->accel_bias[i] = m->setup.accel_bias[i] + g->others[3 + i];
		answer->gyro_bias_sd[i] = sqrt(P[3 + i][3 + i]);
		answer->accel_bias_sd[i] = sqrt(P[6 + i][6 + i]);
	}
}

static fw_status answer_of(const fw_align_motion *m, const fw_align_window *w, fw_align_motion_answer *answer)
{
	double P[N_UNKNOWNS][N_UNKNOWNS], misfit2, margin;
	problem p;
	guess g;

	if (!w->begun || w->rows < ROWS_MIN || solve_window(m, w, &p, &g, P, &misfit2, &margin) != FW_OK)
		return FW_MORE;
	attitude_now(m, &p, &g, P, &answer->attitude);
	if (!(answer->attitude.sd_rad[2] <= 1) || !(margin > 9 * fmax(1, misfit2)))
		return FW_MORE;
	set_biases(m, &p, &g, P, answer);
	answer->t = m->t;
	answer->memory_s = fw_time_diff_s(w->t_velocity, w->t0);
	answer->misfit = sqrt(misfit2);
	return FW_OK;
}

fw_status fw_align_motion_solve(const fw_align_motion *m, fw_align_motion_answer *answer)
{
	fw_align_motion_answer found[2];
	bool old = answer_of(m, &m->window[0], &found[0]) == FW_OK;
	bool young = answer_of(m, &m->window[1], &found[1]) == FW_OK;

	if (!old && !young)
		return FW_MORE;
	if (old && young)
		old = found[0].attitude.sd_rad[2] <= found[1].attitude.sd_rad[2];
	*answer = found[old ? 0 : 1];
	return FW_OK;
}
