/* The smoother against a batch: the joint normal distribution of the errors at all nodes, conditioned on all measurements at once by
 * dense algebra, must give the same estimates and covariances. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "base/random.h"
#include "fusion/measure_navigation.h"
#include "fusion/rts.h"

enum { NODES = 4, N = 15, ALL = NODES * N, STEPS = 25 };

static fw_node nodes[NODES];
static fw_smoothed smoothed[NODES];
static double transition[NODES][N * N], Q[NODES][N * N]; /* from the node before */
static double sigma[ALL * ALL];

static void snapshot_predicted(const fw_filter *f, fw_node *node)
{
	node->predicted = f->pva;
	memcpy(node->x_predicted, f->x, sizeof f->x);
	memcpy(node->P_predicted, f->P, sizeof f->P);
	memcpy(node->transition, f->transition, sizeof f->transition);
}

static void snapshot_filtered(const fw_filter *f, fw_node *node)
{
	node->filtered = f->pva;
	memcpy(node->x_filtered, f->x, sizeof f->x);
	memcpy(node->P_filtered, f->P, sizeof f->P);
}

static void fly(fw_filter *f, fw_random *r)
{
	for (int k = 0; k < STEPS; k++) {
		fw_increment raw = {.dt_s = 0.02};
		for (int i = 0; i < 3; i++) {
			raw.angle_rad[i] = 0.02 * (0.3 + 0.2 * fw_random_normal(r));
			raw.velocity_mps[i] = 0.02 * (2 + fw_random_normal(r));
		}
		raw.velocity_mps[2] -= 0.02 * 9.81;
		fw_filter_predict(f, &raw);
	}
}

/* Q of a stretch: what P has more than Phi P Phi^T. */
static void take_noise(int k)
{
	double P[N * N], Phi[N * N], moved[N * N];
	for (int i = 0; i < N; i++)
		for (int j = 0; j < N; j++) {
			P[i * N + j] = nodes[k - 1].P_filtered[i][j];
			Phi[i * N + j] = nodes[k].transition[i][j];
		}
	fw_mat_sandwich(N, N, Phi, P, moved);
	for (int i = 0; i < N; i++)
		for (int j = 0; j < N; j++)
			Q[k][i * N + j] = nodes[k].P_predicted[i][j] - moved[i * N + j];
	memcpy(transition[k], Phi, sizeof Phi);
}

/* The prior of all nodes together: covariances of (x_i, x_j) = Phi(j..i) P_i. */
static void make_prior(const double P0[N * N])
{
	double diagonal[NODES][N * N], cross[N * N], next[N * N];
	memcpy(diagonal[0], P0, sizeof diagonal[0]);
	for (int k = 1; k < NODES; k++) {
		fw_mat_sandwich(N, N, transition[k], diagonal[k - 1], diagonal[k]);
		for (int i = 0; i < N * N; i++)
			diagonal[k][i] += Q[k][i];
	}
	for (int a = 0; a < NODES; a++) {
		memcpy(cross, diagonal[a], sizeof cross); /* cov(x_b, x_a) */
		for (int b = a; b < NODES; b++) {
			if (b > a) {
				fw_mat_mul(N, N, N, transition[b], cross, next);
				memcpy(cross, next, sizeof cross);
			}
			for (int i = 0; i < N; i++)
				for (int j = 0; j < N; j++)
					sigma[(b * N + i) * ALL + a * N + j] =
					    sigma[(a * N + j) * ALL + b * N + i] = cross[i * N + j];
		}
	}
}

/* Conditions the batch on a measurement of node k: the mean and sigma change. */
static void condition(int k, const fw_measurement *z, const double residual[3], double *mean)
{
	double PH[ALL * 3], S[9], K[3 * ALL];
	for (int i = 0; i < ALL; i++)
		for (int r = 0; r < 3; r++) {
			PH[i * 3 + r] = 0;
			for (int j = 0; j < N; j++)
				PH[i * 3 + r] += sigma[i * ALL + k * N + j] * z->H[r][j];
		}
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 3; c++) {
			S[r * 3 + c] = z->R[r][c];
			for (int j = 0; j < N; j++)
				S[r * 3 + c] += z->H[r][j] * PH[(k * N + j) * 3 + c];
		}
	double PH_t[3 * ALL], innovation[3];
	fw_mat_transpose(ALL, 3, PH, PH_t);
	assert_int_equal(fw_mat_solve_spd(3, ALL, S, PH_t, K), FW_OK);
	for (int r = 0; r < 3; r++) {
		innovation[r] = residual[r];
		for (int j = 0; j < N; j++)
			innovation[r] -= z->H[r][j] * mean[k * N + j];
	}
	for (int i = 0; i < ALL; i++)
		for (int r = 0; r < 3; r++)
			mean[i] += K[r * ALL + i] * innovation[r];
	for (int i = 0; i < ALL; i++)
		for (int j = 0; j < ALL; j++)
			for (int r = 0; r < 3; r++)
				sigma[i * ALL + j] -= PH[i * 3 + r] * K[r * ALL + j];
}

static void equals_the_batch(void **state)
{
	(void)state;
	const double R[3][3] = {{1e-6, 0, 0}, {0, 2e-6, 0}, {0, 0, 3e-6}}, lever[3] = {0},
	             rpy[3] = {0.1, -0.2, 1};
	fw_filter_model model = {.layout = fw_layout_of(1U << FW_BLOCK_GYRO_BIAS | 1U << FW_BLOCK_ACCEL_BIAS),
	                         .gyro_noise = 1e-5,
	                         .accel_noise = 1e-4};
	fw_pva start = {.llh = {0.9, 0.2, 100}, .velocity_mps = {3, -2, 0.1}};
	double sd[N], P0[N * N] = {0}, mean[ALL] = {0}, residual[NODES][3];
	fw_measurement z[NODES];
	fw_filter f, open;
	fw_random r, same;
	for (int i = 0; i < N; i++) {
		sd[i] = i < 3 ? 1e-4 : i < 9 ? 1e-3 : i < 12 ? 1e-5 : 1e-3;
		P0[i * N + i] = sd[i] * sd[i];
	}
	for (int b = 0; b < FW_BLOCK_COUNT; b++) {
		model.process[b].tau_s = 100;
		for (int i = 0; i < 3; i++)
			model.process[b].density[i] = 1e-6;
	}
	fw_euler_to_quat(rpy, start.q_n_b);
	fw_random_init(&r, 5);
	assert_int_equal(fw_filter_init(&f, &model, &start, sd), FW_OK);
	open = f; /* never corrected: what the batch is linear about */
	f.keep_transition = true;
	for (int k = 0; k < NODES; k++) {
		if (k > 0) {
			same = r;
			fly(&open, &same);
			fly(&f, &r);
		}
		snapshot_predicted(&f, &nodes[k]);
		double llh[3] = {open.pva.llh[0] + 2e-11 * (k + 1), open.pva.llh[1] - 1e-11 * k,
		                 open.pva.llh[2] + 1e-4};
		fw_measure_position(&open, llh, R, lever, &z[k]);
		memcpy(residual[k], z[k].innovation, sizeof residual[k]);
		fw_measurement own;
		fw_measure_position(&f, llh, R, lever, &own);
		assert_int_equal(fw_filter_update(&f, &own, NULL), FW_OK);
		snapshot_filtered(&f, &nodes[k]);
		fw_filter_restart_transition(&f);
		if (k > 0)
			take_noise(k);
	}
	fw_rts_last(&model.layout, &nodes[NODES - 1], &smoothed[NODES - 1]);
	for (int k = NODES - 2; k >= 0; k--)
		assert_int_equal(
		    fw_rts_step(&model.layout, &nodes[k], &nodes[k + 1], &smoothed[k + 1], &smoothed[k]),
		    FW_OK);

	make_prior(P0);
	for (int k = 0; k < NODES; k++)
		condition(k, &z[k], residual[k], mean);

	/* The open-loop estimate at each node again, to compare estimates. */
	fw_filter again;
	assert_int_equal(fw_filter_init(&again, &model, &start, sd), FW_OK);
	fw_random_init(&r, 5);
	for (int k = 0; k < NODES; k++) {
		double x[FW_STATES_MAX], error[FW_STATES_MAX];
		fw_pva pva = nodes[k].filtered;
		if (k > 0)
			fly(&again, &r);
		memcpy(x, nodes[k].x_filtered, sizeof x);
		fw_estimate_add(&model.layout, smoothed[k].error, &pva, x);
		fw_estimate_difference(&model.layout, &again.pva, again.x, &pva, x, error);
		for (int i = 0; i < N; i++) {
			const double spread = sqrt(sigma[(k * N + i) * (ALL + 1)]);
			/* linear to a hundredth of a sigma; latitudes are rounded to 1e-9 m */
			if (!(fabs(error[i] - mean[k * N + i]) < 0.01 * spread + 5e-9))
				fail_msg("node %d state %d: smoothed %g, batch %g +- %g", k, i, error[i],
				         mean[k * N + i], spread);
			for (int j = 0; j < N; j++) {
				const double batch = sigma[(k * N + i) * ALL + k * N + j],
				             scale = sqrt(sigma[(k * N + i) * (ALL + 1)] *
				                          sigma[(k * N + j) * (ALL + 1)]);
				if (!(fabs(smoothed[k].P[i][j] - batch) < 2e-3 * scale))
					fail_msg("node %d P[%d][%d]: %g, batch %g", k, i, j,
					         smoothed[k].P[i][j], batch);
			}
		}
	}
}

/* A prediction whose covariance is singular: the estimate stays as filtered, and says so. */
static void singular_predictions_are_survived(void **state)
{
	(void)state;
	const fw_layout layout = fw_layout_of(0);
	static fw_node a, b;
	static fw_smoothed last, s;
	a.filtered.q_n_b[0] = a.predicted.q_n_b[0] = b.filtered.q_n_b[0] = b.predicted.q_n_b[0] = 1;
	for (int i = 0; i < 9; i++)
		a.P_filtered[i][i] = b.P_filtered[i][i] = 1;
	fw_rts_last(&layout, &b, &last);
	last.ahead[3] = 1;
	assert_int_equal(fw_rts_step(&layout, &a, &b, &last, &s), FW_DUBIOUS);
	assert_true(s.error[3] == 0 && s.P[3][3] == 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(equals_the_batch),
	    cmocka_unit_test(singular_predictions_are_survived),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
