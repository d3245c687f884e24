#include "base/matrix.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

static double dot(int n, const double *a, const double *b)
{
	double sum = 0;

	for (int i = 0; i < n; i++)
		sum += a[i] * b[i];
	return sum;
}

/* y += s x */
static void add_scaled(int n, double s, const double *x, double *y)
{
	for (int i = 0; i < n; i++)
		y[i] += s * x[i];
}

static void clear(int n, double *x)
{
	for (int i = 0; i < n; i++)
		x[i] = 0;
}

void fw_mat_mul(int n, int k, int m, const double *A, const double *B, double *C)
{
	clear(n * m, C);
	for (int i = 0; i < n; i++)
		for (int l = 0; l < k; l++)
			add_scaled(m, A[i * k + l], &B[l * m], &C[i * m]);
}

void fw_mat_mul_t(int n, int k, int m, const double *A, const double *B, double *C)
{
	for (int i = 0; i < n; i++)
		for (int j = 0; j < m; j++)
			C[i * m + j] = dot(k, &A[i * k], &B[j * k]);
}

void fw_mat_t_mul(int n, int k, int m, const double *A, const double *B, double *C)
{
	clear(n * m, C);
	for (int l = 0; l < k; l++)
		for (int i = 0; i < n; i++)
			add_scaled(m, A[l * n + i], &B[l * m], &C[i * m]);
}

void fw_mat_sandwich(int n, int m, const double *A, const double *P, double *C)
{
	double row[FW_MAT_MAX]; /* one row of A P at a time */

	assert(m <= FW_MAT_MAX);
	for (int i = 0; i < n; i++) {
		fw_mat_mul(1, m, m, &A[i * m], P, row);
		for (int j = 0; j <= i; j++)
			C[i * n + j] = C[j * n + i] = dot(m, row, &A[j * m]);
	}
}

void fw_mat_transpose(int n, int m, const double *A, double *B)
{
	for (int i = 0; i < n; i++)
		for (int j = 0; j < m; j++)
			B[j * n + i] = A[i * m + j];
}

void fw_mat_symmetrise(int n, double *P)
{
	for (int i = 0; i < n; i++)
		for (int j = 0; j < i; j++)
			P[i * n + j] = P[j * n + i] = 0.5 * (P[i * n + j] + P[j * n + i]);
}

/* Row by row: L_ij = (A_ij - sum_k L_ik L_jk) / L_jj, L_ii = sqrt(A_ii - sum_k L_ik^2). */
fw_status fw_mat_cholesky(int n, const double *A, double *L)
{
	if (n < 1 || n > FW_MAT_MAX)
		return FW_EINVAL;
	for (int i = 0; i < n; i++) {
		double diagonal = A[i * n + i];
		double pivot;

		for (int j = 0; j < i; j++)
			L[i * n + j] = (A[i * n + j] - dot(j, &L[i * n], &L[j * n])) / L[j * n + j];
		pivot = diagonal - dot(i, &L[i * n], &L[i * n]);
		if (!(pivot > n * DBL_EPSILON * diagonal && pivot <= DBL_MAX))
			return FW_ESINGULAR;
		L[i * n + i] = sqrt(pivot);
		clear(n - 1 - i, &L[i * n + i + 1]);
	}
	return FW_OK;
}

/* L Y = B downward, then L^T X = Y upward, on whole rows of right-hand sides. */
void fw_mat_cholesky_solve(int n, int m, const double *L, const double *B, double *X)
{
	memmove(X, B, (size_t)n * (size_t)m * sizeof(*X));
	for (int i = 0; i < n; i++) {
		for (int k = 0; k < i; k++)
			add_scaled(m, -L[i * n + k], &X[k * m], &X[i * m]);
		for (int j = 0; j < m; j++)
			X[i * m + j] /= L[i * n + i];
	}
	for (int i = n - 1; i >= 0; i--) {
		for (int k = i + 1; k < n; k++)
			add_scaled(m, -L[k * n + i], &X[k * m], &X[i * m]);
		for (int j = 0; j < m; j++)
			X[i * m + j] /= L[i * n + i];
	}
}

fw_status fw_mat_solve_spd(int n, int m, const double *A, const double *B, double *X)
{
	double L[FW_MAT_MAX * FW_MAT_MAX];
	fw_status status = fw_mat_cholesky(n, A, L);

	if (status >= 0)
		fw_mat_cholesky_solve(n, m, L, B, X);
	return status;
}

fw_status fw_mat_inverse_spd(int n, const double *A, double *X)
{
	double L[FW_MAT_MAX * FW_MAT_MAX];
	fw_status status = fw_mat_cholesky(n, A, L);

	if (status < 0)
		return status;
	clear(n * n, X);
	for (int i = 0; i < n; i++)
		X[i * n + i] = 1;
	fw_mat_cholesky_solve(n, n, L, X, X);
	fw_mat_symmetrise(n, X);
	return FW_OK;
}

void fw_mat3_mul(const double A[static 3][3], const double B[static 3][3], double C[static 3][3])
{
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			C[i][j] = A[i][0] * B[0][j] + A[i][1] * B[1][j] + A[i][2] * B[2][j];
}

void fw_mat3_transpose(const double A[static 3][3], double B[static 3][3])
{
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			B[i][j] = A[j][i];
}

void fw_mat3_vec(const double A[static 3][3], const double x[static 3], double y[static 3])
{
	for (int i = 0; i < 3; i++)
		y[i] = A[i][0] * x[0] + A[i][1] * x[1] + A[i][2] * x[2];
}

void fw_mat3_t_vec(const double A[static 3][3], const double x[static 3], double y[static 3])
{
	for (int i = 0; i < 3; i++)
		y[i] = A[0][i] * x[0] + A[1][i] * x[1] + A[2][i] * x[2];
}
