#include "fusion/rts.h"

#include <math.h>
#include <string.h>

#include "base/matrix.h"

void fw_rts_last(const fw_layout *layout, const fw_node *node, fw_smoothed *s)
{
	memset(s->error, 0, sizeof s->error);
	fw_estimate_difference(layout, &node->predicted, node->x_predicted, &node->filtered, node->x_filtered,
	                       s->ahead);
	memcpy(s->P, node->P_filtered, sizeof s->P);
}

/* The n x n of a matrix with rows of FW_STATES_MAX, close together. */
static void pack(int n, const double A[static FW_STATES_MAX][FW_STATES_MAX], double *B)
{
	for (int i = 0; i < n; i++)
		for (int j = 0; j < n; j++)
			B[i * n + j] = A[i][j];
}

/* Gain^T (n x n) = P_predicted^-1 Phi P_filtered, so that Gain = P_filtered Phi^T P_predicted^-1. */
static fw_status gain_t(int n, const fw_node *node, const fw_node *next, double *G_t)
{
	double P[FW_STATES_MAX * FW_STATES_MAX], Phi[FW_STATES_MAX * FW_STATES_MAX],
	    PhiP[FW_STATES_MAX * FW_STATES_MAX];
	pack(n, node->P_filtered, P);
	pack(n, next->transition, Phi);
	fw_mat_mul(n, n, n, Phi, P, PhiP);
	pack(n, next->P_predicted, P);
	return fw_mat_solve_spd(n, n, P, PhiP, G_t);
}

fw_status fw_rts_step(const fw_layout *layout, const fw_node *node, const fw_node *next,
                      const fw_smoothed *next_smoothed, fw_smoothed *s)
{
	const int n = layout->n;
	double G_t[FW_STATES_MAX * FW_STATES_MAX], D[FW_STATES_MAX * FW_STATES_MAX],
	    GD[FW_STATES_MAX * FW_STATES_MAX];
	fw_pva pva = node->filtered;
	double x[FW_STATES_MAX];

	fw_rts_last(layout, node, s);
	if (gain_t(n, node, next, G_t) < 0)
		return FW_DUBIOUS;
	fw_mat_t_mul(n, n, 1, G_t, next_smoothed->ahead, s->error);
	/* P = P_filtered + G (P_smoothed - P_predicted of the next) G^T */
	for (int i = 0; i < n; i++)
		for (int j = 0; j < n; j++)
			D[i * n + j] = next_smoothed->P[i][j] - next->P_predicted[i][j];
	fw_mat_t_mul(n, n, n, G_t, D, GD);
	for (int i = 0; i < n; i++)
		for (int j = i; j < n; j++) {
			double sum = node->P_filtered[i][j];
			for (int k = 0; k < n; k++)
				sum += GD[i * n + k] * G_t[k * n + j];
			s->P[i][j] = s->P[j][i] = sum;
		}
	memcpy(x, node->x_filtered, sizeof x);
	fw_estimate_add(layout, s->error, &pva, x);
	fw_estimate_difference(layout, &node->predicted, node->x_predicted, &pva, x, s->ahead);
	return FW_OK;
}
