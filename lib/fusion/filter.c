#include "fusion/filter.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/interpolate.h"
#include "base/matrix.h"

/* ---- the layout ---- */

int fw_block_size(fw_block block)
{
	return block == FW_BLOCK_HEIGHT_ERROR ? 1 : 3;
}

fw_layout fw_layout_of(unsigned blocks)
{
	fw_layout layout = {0};
	blocks |= 1U << FW_BLOCK_ATTITUDE | 1U << FW_BLOCK_VELOCITY | 1U << FW_BLOCK_POSITION;
	for (int b = 0; b < FW_BLOCK_COUNT; b++) {
		layout.at[b] = (blocks >> b & 1) != 0 ? layout.n : -1;
		if (layout.at[b] >= 0)
			layout.n += fw_block_size((fw_block)b);
	}
	return layout;
}

/* ---- the error model ----
 *
 * F consists of 3 x 3 blocks, most of them zero. One list of those that are not serves the covariance, the transition and the
 * Jacobian; what it costs to predict is then proportional to their number. */

enum { ATT = 0, VEL = 3, POS = 6, BLOCKS_MAX = 24 };

typedef struct {
	int row, col;
	double A[3][3];
} block;

typedef struct {
	int n;
	block of[BLOCKS_MAX];
} block_list;

/* A new block, all zero. */
static double (*add(block_list *list, int row, int col))[3]
{
	block *b = &list->of[list->n++];
	memset(b, 0, sizeof *b);
	b->row = row;
	b->col = col;
	return b->A;
}

/* A += s [w x] */
static void add_cross(double A[3][3], double s, const double w[3])
{
	A[0][1] -= s * w[2];
	A[0][2] += s * w[1];
	A[1][0] += s * w[2];
	A[1][2] -= s * w[0];
	A[2][0] -= s * w[1];
	A[2][1] += s * w[0];
}

/* A = -s C diag(r); r NULL: ones */
static void set_sensor(double A[3][3], double s, const double C[3][3], const double *r)
{
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			A[i][j] = -s * C[i][j] * (r != NULL ? r[j] : 1);
}

/* d(attitude error)/dt = -omega_in x phi - d(omega_in) + C d(omega_ib): the blocks times dt. */
static void attitude_rows(const fw_earth *e, const double v[3], double dt, const double W_v[3][3],
                          const double W_p[3][3], block_list *list)
{
	const double omega_in[3] = {e->omega_ie_n[0] + e->omega_en_n[0], e->omega_en_n[1],
	                            e->omega_ie_n[2] + e->omega_en_n[2]};
	double(*A)[3] = add(list, ATT, ATT);
	(void)v;
	add_cross(A, -dt, omega_in);
	A = add(list, ATT, VEL);
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			A[i][j] = -dt * W_v[i][j];
	A = add(list, ATT, POS);
	for (int i = 0; i < 3; i++) {
		A[i][0] = -dt * W_p[i][0];
		A[i][2] = -dt * W_p[i][2];
	}
	A[0][0] +=
	    dt * e->omega_ie_n[2] * -1 / e->M_m; /* d(omega_ie) of latitude: (-sin, 0, -cos) Omega / M */
	A[2][0] += dt * e->omega_ie_n[0] / e->M_m;
}

/* d(velocity error)/dt = phi x f + C d(f) - (2 omega_ie + omega_en) x d(v) + v x d(2 omega_ie + omega_en) + d(g) */
static void velocity_rows(const fw_earth *e, const double v[3], const double f_n[3], double dt,
                          const double W_v[3][3], const double W_p[3][3], block_list *list)
{
	const double omega[3] = {2 * e->omega_ie_n[0] + e->omega_en_n[0], e->omega_en_n[1],
	                         2 * e->omega_ie_n[2] + e->omega_en_n[2]};
	double V[3][3] = {{0}}, T[3][3], W[3][3];
	double(*A)[3] = add(list, VEL, ATT);
	add_cross(A, -dt, f_n);
	add_cross(V, dt, v);
	A = add(list, VEL, VEL);
	fw_mat3_mul(V, W_v, T);
	memcpy(A, T, sizeof T);
	add_cross(A, -dt, omega);
	memcpy(W, W_p, sizeof W);
	W[0][0] += 2 * e->omega_ie_n[2] / e->M_m;
	W[2][0] -= 2 * e->omega_ie_n[0] / e->M_m;
	A = add(list, VEL, POS);
	fw_mat3_mul(V, W, T);
	memcpy(A, T, sizeof T);
	A[2][2] += dt * e->gravity_per_m;
}

/* Position errors in metres, as d(latitude) M, d(longitude) N cos, -d(height), on an ellipsoid that turns under the path. */
static void position_rows(const fw_earth *e, const double v[3], double dt, block_list *list)
{
	const double tan_lat = e->sin_lat / e->cos_lat;
	double(*A)[3] = add(list, POS, VEL);
	A[0][0] = A[1][1] = A[2][2] = dt;
	A = add(list, POS, POS);
	A[0][0] = -dt * v[2] / e->M_m;
	A[0][2] = dt * v[0] / e->M_m;
	A[1][0] = dt * v[1] * tan_lat / e->N_m;
	A[1][1] = -dt * (v[2] + v[0] * tan_lat) / e->N_m;
	A[1][2] = dt * v[1] / e->N_m;
}

/* F dt, of a step with mean readings of the sensors. */
static void error_model(const fw_filter *f, const fw_strapdown_step *s, const fw_increment *raw,
                        block_list *list)
{
	const fw_layout *l = &f->model.layout;
	const fw_earth *e = &s->earth;
	const double dt = raw->dt_s, *v = s->velocity_mps, tan_lat = e->sin_lat / e->cos_lat;
	/* d(omega_en) of velocity, and of position */
	const double W_v[3][3] = {{0, 1 / e->N_m, 0}, {-1 / e->M_m, 0, 0}, {0, -tan_lat / e->N_m, 0}};
	const double W_p[3][3] = {
	    {0, 0, v[1] / (e->N_m * e->N_m)},
	    {0, 0, -v[0] / (e->M_m * e->M_m)},
	    {-v[1] / (e->N_m * e->M_m * e->cos_lat * e->cos_lat), 0, -v[1] * tan_lat / (e->N_m * e->N_m)}};

	list->n = 0;
	attitude_rows(e, v, dt, W_v, W_p, list);
	velocity_rows(e, v, s->force_n, dt, W_v, W_p, list);
	position_rows(e, v, dt, list);
	if (l->at[FW_BLOCK_GYRO_BIAS] >= 0)
		set_sensor(add(list, ATT, l->at[FW_BLOCK_GYRO_BIAS]), dt, s->C_n_b, NULL);
	if (l->at[FW_BLOCK_ACCEL_BIAS] >= 0)
		set_sensor(add(list, VEL, l->at[FW_BLOCK_ACCEL_BIAS]), dt, s->C_n_b, NULL);
	if (l->at[FW_BLOCK_GYRO_SCALE] >= 0)
		set_sensor(add(list, ATT, l->at[FW_BLOCK_GYRO_SCALE]), 1, s->C_n_b, raw->angle_rad);
	if (l->at[FW_BLOCK_ACCEL_SCALE] >= 0)
		set_sensor(add(list, VEL, l->at[FW_BLOCK_ACCEL_SCALE]), 1, s->C_n_b, raw->velocity_mps);
}

/* ---- prediction ---- */

/* Y += A X for the blocks of a list; X and Y have rows of FW_STATES_MAX, the first `width` of each row count. */
static void add_product(const block_list *list, int width, const double (*X)[FW_STATES_MAX],
                        double (*Y)[FW_STATES_MAX])
{
	for (int b = 0; b < list->n; b++) {
		const double(*A)[3] = list->of[b].A;
		const double *restrict x0 = X[list->of[b].col], *restrict x1 = x0 + FW_STATES_MAX,
		                       *restrict x2 = x1 + FW_STATES_MAX;
		double *restrict y0 = Y[list->of[b].row], *restrict y1 = y0 + FW_STATES_MAX,
		                 *restrict y2 = y1 + FW_STATES_MAX;
		for (int j = 0; j < width; j++) {
			y0[j] += A[0][0] * x0[j] + A[0][1] * x1[j] + A[0][2] * x2[j];
			y1[j] += A[1][0] * x0[j] + A[1][1] * x1[j] + A[1][2] * x2[j];
			y2[j] += A[2][0] * x0[j] + A[2][1] * x1[j] + A[2][2] * x2[j];
		}
	}
}

/* P + W + W^T + (A W^T), W = A P: A has rows of navigation only, so only the first nine rows of W are not zero. */
static void propagate(double (*P)[FW_STATES_MAX], int n, const block_list *list)
{
	double W[FW_NAV_STATES][FW_STATES_MAX] = {{0}}, W_t[FW_STATES_MAX][FW_STATES_MAX],
	       B[FW_NAV_STATES][FW_STATES_MAX] = {{0}};

	add_product(list, n, (const double(*)[FW_STATES_MAX])P, W);
	for (int i = 0; i < n; i++)
		for (int j = 0; j < FW_NAV_STATES; j++)
			W_t[i][j] = W[j][i];
	add_product(list, FW_NAV_STATES, (const double(*)[FW_STATES_MAX])W_t, B);
	for (int i = 0; i < FW_NAV_STATES; i++) {
		for (int j = i; j < FW_NAV_STATES; j++)
			P[j][i] = P[i][j] += W[i][j] + W[j][i] + B[i][j];
		for (int j = FW_NAV_STATES; j < n; j++)
			P[j][i] = P[i][j] += W[i][j];
	}
}

/* The part of a Gauss-Markov process that is left after dt. */
static double left_after(const fw_process_noise *p, double dt)
{
	return dt < p->tau_s ? 1 - dt / p->tau_s : 0;
}

/* Decay and noise of the blocks that are no navigation. */
static void wander(fw_filter *f, double dt)
{
	const fw_layout *l = &f->model.layout;
	for (int b = FW_BLOCK_POSITION + 1; b < FW_BLOCK_COUNT; b++) {
		const fw_process_noise *p = &f->model.process[b];
		const double left = left_after(p, dt);
		const int size = fw_block_size((fw_block)b);
		for (int i = l->at[b]; i >= 0 && i < l->at[b] + size; i++) {
			if (left < 1) {
				f->x[i] *= left;
				for (int j = 0; j < l->n; j++) {
					f->P[i][j] *= left;
					f->P[j][i] = f->P[i][j];
				}
				f->P[i][i] *= left;
				if (f->keep_transition)
					for (int j = 0; j < l->n; j++)
						f->transition[i][j] *= left;
			}
			const double density = p->density[i - l->at[b]];
			f->P[i][i] += density * density * dt;
		}
	}
}

/* The increments without the errors that are known. */
static void correct(const fw_filter *f, const fw_increment *raw, fw_increment *now)
{
	static const double zero[3];
	const int *at = f->model.layout.at;
	const double *bg = at[FW_BLOCK_GYRO_BIAS] >= 0 ? &f->x[at[FW_BLOCK_GYRO_BIAS]] : zero;
	const double *ba = at[FW_BLOCK_ACCEL_BIAS] >= 0 ? &f->x[at[FW_BLOCK_ACCEL_BIAS]] : zero;
	const double *sg = at[FW_BLOCK_GYRO_SCALE] >= 0 ? &f->x[at[FW_BLOCK_GYRO_SCALE]] : zero;
	const double *sa = at[FW_BLOCK_ACCEL_SCALE] >= 0 ? &f->x[at[FW_BLOCK_ACCEL_SCALE]] : zero;

	now->dt_s = raw->dt_s;
	for (int i = 0; i < 3; i++) {
		now->angle_rad[i] = (1 - sg[i]) * raw->angle_rad[i] - bg[i] * raw->dt_s;
		now->velocity_mps[i] = (1 - sa[i]) * raw->velocity_mps[i] - ba[i] * raw->dt_s;
	}
}

/* An interval as it would have been with another length. */
static void stretch(fw_increment *i, double dt)
{
	const double by = i->dt_s > 0 ? dt / i->dt_s : 0;
	for (int k = 0; k < 3; k++) {
		i->angle_rad[k] *= by;
		i->velocity_mps[k] *= by;
	}
	i->dt_s = dt;
}

/* What lever arms and detectors want to know of the interval. */
static void keep_rates(fw_filter *f, const fw_increment *now, const fw_strapdown_step *s)
{
	double omega_in_n[3], omega_in_b[3];
	for (int i = 0; i < 3; i++)
		omega_in_n[i] = s->earth.omega_ie_n[i] + s->earth.omega_en_n[i];
	fw_mat3_t_vec(s->C_n_b, omega_in_n, omega_in_b);
	for (int i = 0; i < 3; i++) {
		f->omega_nb_b[i] = now->angle_rad[i] / now->dt_s - omega_in_b[i];
		f->force_b[i] = now->velocity_mps[i] / now->dt_s;
	}
	f->before = *now;
}

/* How long a manoeuvre takes, for errors that grow with it [s]. */
#define MANOEUVRE_S 2

static double square(double x)
{
	return x * x;
}

static void add_sensor_noise(fw_filter *f, const fw_increment *now, const fw_strapdown_step *s)
{
	const fw_filter_model *m = &f->model;
	const double dt = now->dt_s, *a = now->angle_rad, *force = s->force_n;
	const double omega2 = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) / (dt * dt);
	const double push2 = square(force[0]) + square(force[1]) + square(force[2] + s->earth.gravity_mps2);
	const double q_attitude = square(m->gyro_noise) + square(m->gyro_matrix) * omega2 * MANOEUVRE_S;
	const double q_velocity = square(m->accel_noise) + square(m->accel_matrix) * push2 * MANOEUVRE_S;
	for (int i = 0; i < 3; i++) {
		f->P[ATT + i][ATT + i] += q_attitude * dt;
		f->P[VEL + i][VEL + i] += q_velocity * dt;
	}
}

void fw_filter_predict(fw_filter *f, const fw_increment *raw)
{
	const double dt = raw->dt_s;
	fw_increment now;
	fw_strapdown_step step;
	block_list F;

	correct(f, raw, &now);
	if (f->before.dt_s != dt)
		stretch(&f->before, dt);
	fw_strapdown(&f->pva, &now, &f->before, &step);
	keep_rates(f, &now, &step);
	error_model(f, &step, raw, &F);
	propagate(f->P, f->model.layout.n, &F);
	if (f->keep_transition) {
		double old[FW_STATES_MAX][FW_STATES_MAX];
		memcpy(old, f->transition, sizeof old[0] * (size_t)f->model.layout.n);
		add_product(&F, f->model.layout.n, (const double(*)[FW_STATES_MAX])old, f->transition);
	}
	add_sensor_noise(f, &now, &step);
	wander(f, dt);
}

void fw_filter_jacobian(const fw_filter *f, const fw_increment *raw, double F[])
{
	const int n = f->model.layout.n;
	fw_pva pva = f->pva;
	fw_increment now;
	fw_strapdown_step step;
	block_list list;

	correct(f, raw, &now);
	fw_strapdown(&pva, &now, &f->before, &step);
	error_model(f, &step, raw, &list);
	memset(F, 0, sizeof *F * (size_t)(n * n));
	for (int b = 0; b < list.n; b++)
		for (int i = 0; i < 3; i++)
			for (int j = 0; j < 3; j++)
				F[(list.of[b].row + i) * n + list.of[b].col + j] +=
				    list.of[b].A[i][j] / raw->dt_s;
	for (int b = FW_BLOCK_POSITION + 1; b < FW_BLOCK_COUNT; b++)
		for (int i = 0; f->model.layout.at[b] >= 0 && i < fw_block_size((fw_block)b); i++)
			F[(f->model.layout.at[b] + i) * (n + 1)] = -1 / f->model.process[b].tau_s;
}

void fw_filter_restart_transition(fw_filter *f)
{
	memset(f->transition, 0, sizeof f->transition);
	for (int i = 0; i < f->model.layout.n; i++)
		f->transition[i][i] = 1;
}

/* ---- estimates and their errors ---- */

void fw_estimate_add(const fw_layout *layout, const double error[], fw_pva *pva, double x[])
{
	const double zero[3] = {0};
	double q_error[4], q[4];
	fw_earth e;

	fw_quat_from_rotvec(error + ATT, q_error);
	fw_quat_mul(q_error, pva->q_n_b, q);
	memcpy(pva->q_n_b, q, sizeof q);
	(void)!fw_quat_normalise(pva->q_n_b);
	fw_earth_at(pva->llh, zero, &e);
	pva->llh[0] += error[POS] / e.M_m;
	pva->llh[1] = fw_wrap_pi(pva->llh[1] + error[POS + 1] / (e.N_m * e.cos_lat));
	pva->llh[2] -= error[POS + 2];
	for (int i = 0; i < 3; i++)
		pva->velocity_mps[i] += error[VEL + i];
	for (int i = FW_NAV_STATES; i < layout->n; i++)
		x[i] += error[i];
}

void fw_estimate_difference(const fw_layout *layout, const fw_pva *from, const double x_from[],
                            const fw_pva *to, const double x_to[], double error[])
{
	const double zero[3] = {0};
	double C[3][3], body[3];
	fw_earth e;

	fw_earth_at(from->llh, zero, &e);
	fw_quat_between(from->q_n_b, to->q_n_b, body);
	fw_quat_to_matrix(from->q_n_b, C);
	fw_mat3_vec(C, body, error + ATT);
	error[POS] = (to->llh[0] - from->llh[0]) * e.M_m;
	error[POS + 1] = fw_wrap_pi(to->llh[1] - from->llh[1]) * e.N_m * e.cos_lat;
	error[POS + 2] = from->llh[2] - to->llh[2];
	for (int i = 0; i < 3; i++)
		error[VEL + i] = to->velocity_mps[i] - from->velocity_mps[i];
	for (int i = FW_NAV_STATES; i < layout->n; i++)
		error[i] = x_to[i] - x_from[i];
}

fw_status fw_filter_init(fw_filter *f, const fw_filter_model *model, const fw_pva *pva, const double sd[])
{
	double sum = 0;
	for (int i = 0; i < 3; i++)
		sum += pva->llh[i] + pva->velocity_mps[i] + pva->q_n_b[i];
	if (!isfinite(sum + pva->q_n_b[3]))
		return FW_ENONFINITE;
	if (!(fabs(pva->llh[0]) < FW_PI / 2 - 1e-6))
		return FW_EINVAL;
	for (int i = 0; i < model->layout.n; i++)
		if (!(sd[i] >= 0 && sd[i] <= DBL_MAX))
			return FW_EINVAL;
	memset(f, 0, sizeof *f);
	f->model = *model;
	f->pva = *pva;
	for (int i = 0; i < model->layout.n; i++)
		f->P[i][i] = sd[i] * sd[i];
	fw_filter_restart_transition(f);
	return FW_OK;
}

/* ---- update ---- */

/* What an update computes on the way. */
typedef struct {
	double PH_t[FW_STATES_MAX][FW_ROWS_MAX];
	double L[FW_ROWS_MAX * FW_ROWS_MAX]; /* S = L L^T */
	double nis;
} innovation;

static fw_status innovate(const fw_filter *f, const fw_measurement *z, innovation *v)
{
	const int n = f->model.layout.n, m = z->m;
	double S[FW_ROWS_MAX * FW_ROWS_MAX] = {0}, y[FW_ROWS_MAX];

	for (int i = 0; i < n; i++)
		for (int r = 0; r < m; r++) {
			double sum = 0;
			for (int k = 0; k < n; k++)
				sum += f->P[i][k] * z->H[r][k];
			v->PH_t[i][r] = sum;
		}
	for (int r = 0; r < m; r++)
		for (int c = 0; c < m; c++) {
			double sum = z->R[r][c];
			for (int k = 0; k < n; k++)
				sum += z->H[r][k] * v->PH_t[k][c];
			S[r * m + c] = sum;
		}
	fw_status status = fw_mat_cholesky(m, S, v->L);
	if (status < 0)
		return status;
	fw_mat_cholesky_solve(m, 1, v->L, z->innovation, y);
	v->nis = 0;
	for (int r = 0; r < m; r++)
		v->nis += y[r] * z->innovation[r];
	return isfinite(v->nis) ? FW_OK : FW_ENONFINITE;
}

fw_status fw_filter_nis(const fw_filter *f, const fw_measurement *z, double *nis)
{
	innovation v;
	fw_status status = innovate(f, z, &v);
	if (status >= 0)
		*nis = v.nis;
	return status;
}

/* P = (I - K H) P (I - K H)^T + K R K^T, as T = P - K (P H^T)^T, then T - (T H^T) K^T + K R K^T. */
static void joseph(fw_filter *f, const fw_measurement *z, const innovation *v,
                   double K[FW_STATES_MAX][FW_ROWS_MAX])
{
	const int n = f->model.layout.n, m = z->m;
	double T[FW_STATES_MAX][FW_STATES_MAX], G[FW_STATES_MAX][FW_ROWS_MAX];

	for (int i = 0; i < n; i++)
		for (int j = 0; j < n; j++) {
			double sum = f->P[i][j];
			for (int r = 0; r < m; r++)
				sum -= K[i][r] * v->PH_t[j][r];
			T[i][j] = sum;
		}
	for (int i = 0; i < n; i++)
		for (int r = 0; r < m; r++) { /* T H^T - K R */
			double sum = 0;
			for (int k = 0; k < n; k++)
				sum += T[i][k] * z->H[r][k];
			for (int c = 0; c < m; c++)
				sum -= K[i][c] * z->R[c][r];
			G[i][r] = sum;
		}
	for (int i = 0; i < n; i++)
		for (int j = i; j < n; j++) {
			double sum = (T[i][j] + T[j][i]) / 2;
			for (int r = 0; r < m; r++)
				sum -= (G[i][r] * K[j][r] + G[j][r] * K[i][r]) / 2;
			f->P[i][j] = f->P[j][i] = sum;
		}
}

fw_status fw_filter_update(fw_filter *f, const fw_measurement *z, double *nis)
{
	const int n = f->model.layout.n, m = z->m;
	innovation v;
	double K[FW_STATES_MAX][FW_ROWS_MAX], gain[FW_ROWS_MAX], error[FW_STATES_MAX] = {0};
	fw_status status = innovate(f, z, &v);

	if (status < 0)
		return status;
	for (int i = 0; i < n; i++) {
		fw_mat_cholesky_solve(m, 1, v.L, v.PH_t[i], gain);
		for (int r = 0; r < m; r++) {
			K[i][r] = gain[r];
			error[i] += gain[r] * z->innovation[r];
		}
	}
	joseph(f, z, &v, K);
	fw_estimate_add(&f->model.layout, error, &f->pva, f->x);
	if (nis != NULL)
		*nis = v.nis;
	return FW_OK;
}
