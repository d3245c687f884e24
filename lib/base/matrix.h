/* Small dense matrices, row-major: element (i, j) of A (n x m) is A[i * m + j].
 *
 * Sizes come first, then inputs, then outputs. An output is a different array from every input unless the
 * comment says otherwise. NaN spreads through products and fails the factorisation. Sizes are the caller's,
 * at least 1; functions that return a status answer FW_EINVAL beyond FW_MAT_MAX, the others assert where they
 * have a limit. */
#ifndef FURROW_BASE_MATRIX_H
#define FURROW_BASE_MATRIX_H

#include "base/status.h"

/* The largest order that the functions with a limit take; above it, sparse methods. */
#define FW_MAT_MAX 64

/* C (n x m) = A (n x k) B (k x m) */
void fw_mat_mul(int n, int k, int m, const double *A, const double *B, double *C);

/* C (n x m) = A (n x k) B^T, B (m x k) */
void fw_mat_mul_t(int n, int k, int m, const double *A, const double *B, double *C);

/* C (n x m) = A^T B, A (k x n), B (k x m) */
void fw_mat_t_mul(int n, int k, int m, const double *A, const double *B, double *C);

/* C (n x n) = A P A^T, A (n x m), P (m x m) symmetric, m <= FW_MAT_MAX. C is symmetric to the last bit. */
void fw_mat_sandwich(int n, int m, const double *A, const double *P, double *C);

/* B (m x n) = A^T, A (n x m) */
void fw_mat_transpose(int n, int m, const double *A, double *B);

/* P (n x n) = (P + P^T) / 2, in place */
void fw_mat_symmetrise(int n, double *P);

/* Cholesky factor: A = L L^T, A (n x n) symmetric positive definite (its lower triangle is read), L (n x n)
 * lower triangular with zeros above. n <= FW_MAT_MAX. L may be A.
 * Returns FW_OK; FW_EINVAL (n); FW_ESINGULAR if a pivot is not above n eps times its own diagonal element,
 * which does not depend on the units of the rows, or if there is NaN or infinity: L is then without
 * meaning. */
fw_status fw_mat_cholesky(int n, const double *A, double *L) FW_MUST_CHECK;

/* X (n x m) = A^-1 B by the factor L (n x n) of fw_mat_cholesky, B (n x m). X may be B. */
void fw_mat_cholesky_solve(int n, int m, const double *L, const double *B, double *X);

/* X (n x m) with A X = B, A (n x n) symmetric positive definite, B (n x m). X may be B.
 * Returns as fw_mat_cholesky; X is untouched on error. */
fw_status fw_mat_solve_spd(int n, int m, const double *A, const double *B, double *X) FW_MUST_CHECK;

/* X (n x n) = A^-1, A symmetric positive definite; X is symmetric to the last bit and may be A.
 * Returns as fw_mat_cholesky; X is untouched on error. */
fw_status fw_mat_inverse_spd(int n, const double *A, double *X) FW_MUST_CHECK;

/* ---- 3 x 3 ---- */

/* C = A B */
void fw_mat3_mul(const double A[static 3][3], const double B[static 3][3], double C[static 3][3]);

/* B = A^T */
void fw_mat3_transpose(const double A[static 3][3], double B[static 3][3]);

/* y = A x */
void fw_mat3_vec(const double A[static 3][3], const double x[static 3], double y[static 3]);

/* y = A^T x: for a rotation, the way back */
void fw_mat3_t_vec(const double A[static 3][3], const double x[static 3], double y[static 3]);

#endif
