/* matrix: small cases by hand (integers, exact), larger ones against the definitions. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/matrix.h"
#include "base/random.h"

#define N FW_MAT_MAX

static void assert_same(int count, const double *actual, const double *expected)
{
	for (int i = 0; i < count; i++)
		if (!(actual[i] == expected[i]))
			fail_msg("element %d: %.17g is not %.17g", i, actual[i], expected[i]);
}

static void assert_near(int count, const double *actual, const double *expected, double tolerance)
{
	for (int i = 0; i < count; i++)
		if (!(fabs(actual[i] - expected[i]) <= tolerance))
			fail_msg("element %d: %.17g is not %.17g", i, actual[i], expected[i]);
}

static void fill(fw_random *r, int count, double *x)
{
	for (int i = 0; i < count; i++)
		x[i] = fw_random_normal(r);
}

/* A = G G^T + I: positive definite whatever G. */
static void fill_spd(fw_random *r, int n, double *A)
{
	static double G[N * N];

	fill(r, n * n, G);
	fw_mat_mul_t(n, n, n, G, G, A);
	for (int i = 0; i < n; i++)
		A[i * n + i] += 1;
}

static const double two_by_three[] = {1, 2, 3, 4, 5, 6};

static void products_by_hand(void **state)
{
	static const double B[] = {7, 8, 9, 10, 11, 12};                  /* 3 x 2 */
	static const double AB[] = {58, 64, 139, 154};                    /* 2 x 2 */
	static const double BA[] = {39, 54, 69, 49, 68, 87, 59, 82, 105}; /* 3 x 3 */
	static const double AAt[] = {14, 32, 32, 77};                     /* 2 x 2 */
	static const double AtA[] = {17, 22, 27, 22, 29, 36, 27, 36, 45}; /* 3 x 3 */
	static const double At[] = {1, 4, 2, 5, 3, 6};                    /* 3 x 2 */
	double C[9];

	(void)state;
	fw_mat_mul(2, 3, 2, two_by_three, B, C);
	assert_same(4, C, AB);
	fw_mat_mul(3, 2, 3, B, two_by_three, C);
	assert_same(9, C, BA);
	fw_mat_mul_t(2, 3, 2, two_by_three, two_by_three, C);
	assert_same(4, C, AAt);
	fw_mat_t_mul(3, 2, 3, two_by_three, two_by_three, C);
	assert_same(9, C, AtA);
	fw_mat_transpose(2, 3, two_by_three, C);
	assert_same(6, C, At);
}

/* A P = {4 10 14; 13 25 29}, and that times A^T. */
static void sandwich_by_hand(void **state)
{
	static const double P[] = {2, 1, 0, 1, 3, 1, 0, 1, 4};
	static const double expected[] = {66, 150, 150, 351};
	double C[4];

	(void)state;
	fw_mat_sandwich(2, 3, two_by_three, P, C);
	assert_same(4, C, expected);
}

static void sandwich_is_symmetric_to_the_last_bit(void **state)
{
	static double A[20 * N], P[N * N], C[20 * 20], AP[20 * N], expected[20 * 20];
	fw_random r;

	(void)state;
	fw_random_init(&r, 1);
	fill(&r, 20 * N, A);
	fill_spd(&r, N, P);
	fw_mat_sandwich(20, N, A, P, C);
	fw_mat_mul(20, N, N, A, P, AP);
	fw_mat_mul_t(20, N, 20, AP, A, expected);
	assert_near(20 * 20, C, expected, 1e-9);
	for (int i = 0; i < 20; i++)
		for (int j = 0; j < i; j++)
			assert_true(C[i * 20 + j] == C[j * 20 + i]);
}

static void symmetrise_takes_the_mean(void **state)
{
	double P[] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
	static const double expected[] = {1, 3, 5, 3, 5, 7, 5, 7, 9};

	(void)state;
	fw_mat_symmetrise(3, P);
	assert_same(9, P, expected);
}

/* The textbook case with an integer factor; only the lower triangle is read. */
static void cholesky_by_hand(void **state)
{
	double none = nan("");
	double A[] = {4, none, none, 12, 37, none, -16, -43, 98};
	static const double expected[] = {2, 0, 0, 6, 1, 0, -8, 5, 3};
	double L[9];

	(void)state;
	assert_int_equal(fw_mat_cholesky(3, A, L), FW_OK);
	assert_same(9, L, expected);
	assert_int_equal(fw_mat_cholesky(3, A, A), FW_OK); /* in place */
	assert_same(9, A, expected);
}

static void cholesky_refuses_what_is_not_positive_definite(void **state)
{
	static const double indefinite[] = {1, 2, 2, 1};
	static const double semidefinite[] = {1, 1, 1, 1};
	static const double zero[] = {0};
	const double with_nan[] = {1, 0, nan(""), 1};
	const double nan_pivot[] = {nan("")};
	static const double infinite[] = {HUGE_VAL, 0, 0, 1};
	double L[4];

	(void)state;
	assert_int_equal(fw_mat_cholesky(2, indefinite, L), FW_ESINGULAR);
	assert_int_equal(fw_mat_cholesky(2, semidefinite, L), FW_ESINGULAR);
	assert_int_equal(fw_mat_cholesky(1, zero, L), FW_ESINGULAR);
	assert_int_equal(fw_mat_cholesky(2, with_nan, L), FW_ESINGULAR);
	assert_int_equal(fw_mat_cholesky(1, nan_pivot, L), FW_ESINGULAR);
	assert_int_equal(fw_mat_cholesky(2, infinite, L), FW_ESINGULAR);
	assert_int_equal(fw_mat_cholesky(0, zero, L), FW_EINVAL);
	assert_int_equal(fw_mat_cholesky(FW_MAT_MAX + 1, zero, L), FW_EINVAL);
}

/* Metres beside radians per second: a good matrix stays good in any units. */
static void cholesky_does_not_care_about_units(void **state)
{
	static const double A[] = {1e12, 0.5e2, 0.5e2, 1e-8}; /* correlation 0.5 */
	static const double expected[] = {1e6, 0, 0.5e-4, 0.8660254037844386e-4};
	double L[4];

	(void)state;
	assert_int_equal(fw_mat_cholesky(2, A, L), FW_OK);
	assert_near(4, L, expected, 1e-19);
}

static void solve_by_hand(void **state)
{
	static const double A[] = {4, 12, -16, 12, 37, -43, -16, -43, 98};
	static const double B[] = {0, 1, 6, 2, 39, 3}; /* first column A {1, 1, 1}^T */
	double X[6], in_place[6], back[6];

	(void)state;
	assert_int_equal(fw_mat_solve_spd(3, 2, A, B, X), FW_OK);
	for (int i = 0; i < 3; i++)
		assert_true(fabs(X[2 * i] - 1) < 1e-12);
	fw_mat_mul(3, 3, 2, A, X, back);
	assert_near(6, back, B, 1e-11);
	memcpy(in_place, B, sizeof(B));
	assert_int_equal(fw_mat_solve_spd(3, 2, A, in_place, in_place), FW_OK);
	assert_same(6, in_place, X);
}

/* The inverse of the Hilbert matrix of order 4 is known in integers; its condition is 1.5e4. */
static void inverse_of_hilbert_is_integer(void **state)
{
	static const double expected[] = {16,  -120,  240,  -140,  -120, 1200, -2700, 1680,
	                                  240, -2700, 6480, -4200, -140, 1680, -4200, 2800};
	double H[16], X[16];

	(void)state;
	for (int i = 0; i < 16; i++)
		H[i] = 1.0 / (i / 4 + i % 4 + 1);
	assert_int_equal(fw_mat_inverse_spd(4, H, X), FW_OK);
	assert_near(16, X, expected, 1e-8);
	assert_int_equal(fw_mat_inverse_spd(4, H, H), FW_OK); /* in place */
	assert_same(16, H, X);
}

static void inverse_undoes_the_matrix_up_to_the_largest_order(void **state)
{
	static const int orders[] = {1, 2, 15, 21, N};
	static double A[N * N], X[N * N], AX[N * N], identity[N * N];
	fw_random r;

	(void)state;
	fw_random_init(&r, 2);
	for (size_t k = 0; k < sizeof(orders) / sizeof(orders[0]); k++) {
		int n = orders[k];

		fill_spd(&r, n, A);
		assert_int_equal(fw_mat_inverse_spd(n, A, X), FW_OK);
		fw_mat_mul(n, n, n, A, X, AX);
		for (int i = 0; i < n * n; i++)
			identity[i] = i % (n + 1) == 0;
		assert_near(n * n, AX, identity, 1e-11);
		for (int i = 0; i < n; i++)
			for (int j = 0; j < i; j++)
				assert_true(X[i * n + j] == X[j * n + i]);
	}
}

static void failure_leaves_the_output_alone(void **state)
{
	static const double A[] = {1, 2, 2, 1};
	static const double B[] = {1, 1};
	double X[4] = {7, 7, 7, 7};
	static const double sevens[] = {7, 7, 7, 7};

	(void)state;
	assert_int_equal(fw_mat_solve_spd(2, 1, A, B, X), FW_ESINGULAR);
	assert_int_equal(fw_mat_inverse_spd(2, A, X), FW_ESINGULAR);
	assert_same(4, X, sevens);
}

static void three_by_three_by_hand(void **state)
{
	static const double A[3][3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 10}};
	static const double B[3][3] = {{2, 0, 1}, {1, 1, 0}, {0, 3, 1}};
	static const double AB[3][3] = {{4, 11, 4}, {13, 23, 10}, {22, 38, 17}};
	static const double At[3][3] = {{1, 4, 7}, {2, 5, 8}, {3, 6, 10}};
	static const double x[3] = {2, -1, 3};
	static const double Ax[3] = {9, 21, 36};
	static const double Atx[3] = {19, 23, 30};
	double C[3][3], y[3];

	(void)state;
	fw_mat3_mul(A, B, C);
	assert_same(9, C[0], AB[0]);
	fw_mat3_transpose(A, C);
	assert_same(9, C[0], At[0]);
	fw_mat3_vec(A, x, y);
	assert_same(3, y, Ax);
	fw_mat3_t_vec(A, x, y);
	assert_same(3, y, Atx);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(products_by_hand),
	    cmocka_unit_test(sandwich_by_hand),
	    cmocka_unit_test(sandwich_is_symmetric_to_the_last_bit),
	    cmocka_unit_test(symmetrise_takes_the_mean),
	    cmocka_unit_test(cholesky_by_hand),
	    cmocka_unit_test(cholesky_refuses_what_is_not_positive_definite),
	    cmocka_unit_test(cholesky_does_not_care_about_units),
	    cmocka_unit_test(solve_by_hand),
	    cmocka_unit_test(inverse_of_hilbert_is_integer),
	    cmocka_unit_test(inverse_undoes_the_matrix_up_to_the_largest_order),
	    cmocka_unit_test(failure_leaves_the_output_alone),
	    cmocka_unit_test(three_by_three_by_hand),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
