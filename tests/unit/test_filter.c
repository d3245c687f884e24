/* The filter: its Jacobian and those of its measurements against differences of the nonlinear functions, its update against the
 * textbook's, its covariance after many updates. */
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
#include "fusion/filter.h"
#include "fusion/measure_navigation.h"
#include "ins/magnetometer.h"

static const unsigned all_blocks = (1U << FW_BLOCK_COUNT) - 1;

/* A filter somewhere, moving fast, with everything that it can have. */
static void make(fw_filter *f, fw_random *r)
{
	fw_filter_model model = {.layout = fw_layout_of(all_blocks), .gyro_noise = 1e-4, .accel_noise = 1e-3};
	const double rpy[3] = {fw_random_normal(r) * 0.3, fw_random_normal(r) * 0.3,
	                       fw_random_uniform(r) * 6.28};
	fw_pva pva = {.llh = {1.2 * (2 * fw_random_uniform(r) - 1), 3 * (2 * fw_random_uniform(r) - 1),
	                      1000 * fw_random_uniform(r)}};
	double sd[FW_STATES_MAX];
	for (int i = 0; i < FW_STATES_MAX; i++)
		sd[i] = 0.1 + fw_random_uniform(r);
	for (int b = 0; b < FW_BLOCK_COUNT; b++) {
		model.process[b].tau_s = 10 + 1000 * fw_random_uniform(r);
		for (int i = 0; i < 3; i++)
			model.process[b].density[i] = 1e-3;
	}
	for (int i = 0; i < 3; i++)
		pva.velocity_mps[i] = 100 * fw_random_normal(r);
	fw_euler_to_quat(rpy, pva.q_n_b);
	assert_int_equal(fw_filter_init(f, &model, &pva, sd), FW_OK);
	for (int i = FW_NAV_STATES; i < model.layout.n; i++)
		f->x[i] = 1e-3 * fw_random_normal(r);
}

static void make_reading(fw_random *r, double dt, fw_increment *raw)
{
	raw->dt_s = dt;
	for (int i = 0; i < 3; i++) {
		raw->angle_rad[i] = fw_random_normal(r) * dt;
		raw->velocity_mps[i] = 15 * fw_random_normal(r) * dt;
	}
}

static void layout_holds_the_blocks(void **state)
{
	(void)state;
	const fw_layout few = fw_layout_of(1U << FW_BLOCK_ACCEL_BIAS), all = fw_layout_of(all_blocks);
	assert_int_equal(few.n, 12);
	assert_int_equal(few.at[FW_BLOCK_ATTITUDE], 0);
	assert_int_equal(few.at[FW_BLOCK_GYRO_BIAS], -1);
	assert_int_equal(few.at[FW_BLOCK_ACCEL_BIAS], 9);
	assert_int_equal(all.n, 28);
	assert_int_equal(all.at[FW_BLOCK_HEIGHT_ERROR], 27);
}

/* What an error of h in state j has become of after a step, by central differences, less what it was, per second. */
static void grown(const fw_filter *f, const fw_increment *rates, double dt, int j, double h, double *column)
{
	const fw_layout *l = &f->model.layout;
	fw_increment raw = {.dt_s = dt};
	double error[2][FW_STATES_MAX];
	fw_filter middle = *f;
	for (int i = 0; i < 3; i++) {
		raw.angle_rad[i] = rates->angle_rad[i] * dt;
		raw.velocity_mps[i] = rates->velocity_mps[i] * dt;
	}
	fw_filter_predict(&middle, &raw);
	for (int side = 0; side < 2; side++) {
		fw_filter moved = *f;
		double start[FW_STATES_MAX] = {0};
		start[j] = side == 0 ? h : -h;
		fw_estimate_add(l, start, &moved.pva, moved.x);
		fw_filter_predict(&moved, &raw);
		fw_estimate_difference(l, &middle.pva, middle.x, &moved.pva, moved.x, error[side]);
	}
	for (int i = 0; i < l->n; i++)
		column[i] = ((error[0][i] - error[1][i]) / (2 * h) - (i == j)) / dt;
}

/* d(error)/dt = F error, column by column: from the nonlinear step, whose own second order two lengths of it take out. */
static void jacobian_is_the_derivative(void **state)
{
	(void)state;
	const double dt = 1e-4;
	static const double h[FW_BLOCK_COUNT] = {1e-3, 50, 100, 0.1, 1e-1, 1e-3, 1e-3, 1, 1, 1};
	fw_random r;
	fw_random_init(&r, 11);
	for (int trial = 0; trial < 200; trial++) {
		fw_filter f;
		fw_increment rates, raw;
		double F[FW_STATES_MAX * FW_STATES_MAX], whole[FW_STATES_MAX], half[FW_STATES_MAX];
		make(&f, &r);
		make_reading(&r, 1, &rates);
		raw.dt_s = 1e-9;
		for (int i = 0; i < 3; i++) {
			raw.angle_rad[i] = rates.angle_rad[i] * raw.dt_s;
			raw.velocity_mps[i] = rates.velocity_mps[i] * raw.dt_s;
		}
		const fw_layout *l = &f.model.layout;
		fw_filter_jacobian(&f, &raw, F);
		for (int b = 0; b < FW_BLOCK_COUNT; b++)
			for (int j = l->at[b]; j < l->at[b] + fw_block_size((fw_block)b); j++) {
				grown(&f, &rates, dt, j, h[b], whole);
				grown(&f, &rates, dt / 2, j, h[b], half);
				for (int i = 0; i < l->n; i++) {
					const double expected = 2 * half[i] - whole[i], is = F[i * l->n + j];
					/* positions are latitudes, rounded to some 1e-9 m */
					const double rounding = i >= 6 && i < 9 ? 1e-8 / (h[b] * dt) : 0;
					if (!(fabs(is - expected) < 1e-6 * fmax(1, fabs(is)) + rounding))
						fail_msg("trial %d: F[%d][%d] = %.9g, by differences %.9g",
						         trial, i, j, is, expected);
				}
			}
	}
}

/* H of a measurement: how its innovation changes when the estimate is moved, with the sign turned. */
static void check_measurement(fw_filter *f, void (*measure)(const fw_filter *f, fw_measurement *z),
                              const char *name)
{
	static const double h[FW_BLOCK_COUNT] = {1e-5, 1e-3, 1, 1e-6, 1e-3, 1e-5, 1e-5, 1e-2, 1e-3, 1e-2};
	const fw_layout *l = &f->model.layout;
	fw_measurement z;
	measure(f, &z);
	for (int b = 0; b < FW_BLOCK_COUNT; b++)
		for (int j = l->at[b]; j < l->at[b] + fw_block_size((fw_block)b); j++) {
			fw_measurement side[2];
			for (int s = 0; s < 2; s++) {
				fw_filter moved = *f;
				double error[FW_STATES_MAX] = {0};
				error[j] = s == 0 ? h[b] : -h[b];
				fw_estimate_add(l, error, &moved.pva, moved.x);
				if (b ==
				    FW_BLOCK_GYRO_BIAS) /* the last angular rate was computed with the old bias */
					moved.omega_nb_b[j - l->at[b]] -= error[j];
				measure(&moved, &side[s]);
			}
			for (int row = 0; row < z.m; row++) {
				const double by =
				    -(side[0].innovation[row] - side[1].innovation[row]) / (2 * h[b]);
				if (!(fabs(z.H[row][j] - by) < 1e-6 * (1 + fabs(by)) + 1e-8 / h[b]))
					fail_msg("%s: H[%d][%d] = %.9g, by differences %.9g", name, row, j,
					         z.H[row][j], by);
			}
		}
}

static const double lever[3] = {0.7, -0.4, -1.1};
static const double R[3][3] = {{4, 1, 0}, {1, 3, 0.5}, {0, 0.5, 9}};
static fw_pva measured;

static void position(const fw_filter *f, fw_measurement *z)
{
	fw_measure_position(f, measured.llh, R, lever, z);
}

static void velocity(const fw_filter *f, fw_measurement *z)
{
	fw_measure_velocity(f, measured.velocity_mps, R, lever, z);
}

static void heading(const fw_filter *f, fw_measurement *z)
{
	assert_int_equal(fw_measure_heading(f, 1.0, 0.01, z), FW_OK);
}

static const double field_nt[3] = {17000, 1200, 51000};
static double field_b[3];

static void compass(const fw_filter *f, fw_measurement *z)
{
	const fw_mag_calibration as_it_is = fw_mag_as_it_is(53.8, 0.1);
	double rpy[3], heading_rad, sd;
	fw_quat_to_euler(f->pva.q_n_b, rpy);
	assert_int_equal(fw_mag_heading(&as_it_is, field_b, rpy, 0, field_nt, &heading_rad, &sd), FW_OK);
	assert_int_equal(fw_measure_compass(f, heading_rad, 0.01, field_nt, z), FW_OK);
}

static void height(const fw_filter *f, fw_measurement *z)
{
	fw_measure_height(f, 100, 0.5, z);
}

static void zero_velocity(const fw_filter *f, fw_measurement *z)
{
	fw_measure_zero_velocity(f, 0.01, z);
}

static void zero_rate(const fw_filter *f, fw_measurement *z)
{
	const double omega[3] = {1e-3, 2e-3, -1e-3};
	fw_measure_zero_rate(f, omega, 1e-4, z);
}

static void wheels(const fw_filter *f, fw_measurement *z)
{
	fw_measure_wheels(f, 0.1, lever, z);
}

static void measurements_are_derivatives(void **state)
{
	(void)state;
	fw_random r;
	fw_random_init(&r, 12);
	for (int trial = 0; trial < 100; trial++) {
		fw_filter f;
		make(&f, &r);
		for (int i = 0; i < 3; i++)
			f.omega_nb_b[i] = fw_random_normal(&r);
		measured = f.pva;
		measured.llh[0] += 1e-7;
		check_measurement(&f, position, "position");
		check_measurement(&f, velocity, "velocity");
		check_measurement(&f, heading, "heading");
		double C[3][3], field_ut[3];
		for (int i = 0; i < 3; i++)
			field_ut[i] = field_nt[i] * 1e-3;
		fw_quat_to_matrix(f.pva.q_n_b, C);
		fw_mat3_t_vec(C, field_ut, field_b);
		check_measurement(&f, compass, "compass");
		check_measurement(&f, height, "height");
		check_measurement(&f, zero_velocity, "zero velocity");
		check_measurement(&f, zero_rate, "zero rate");
		check_measurement(&f, wheels, "wheels");
	}
}

/* P - P H^T S^-1 H P and K innovation, computed as they stand in the textbook, in full matrices. */
static void update_is_the_textbooks(void **state)
{
	(void)state;
	fw_random r;
	fw_random_init(&r, 13);
	for (int trial = 0; trial < 100; trial++) {
		fw_filter f;
		fw_measurement z;
		make(&f, &r);
		const int n = f.model.layout.n;
		double P[FW_STATES_MAX * FW_STATES_MAX], H[3 * FW_STATES_MAX], HP[3 * FW_STATES_MAX], S[9],
		    X[3 * FW_STATES_MAX], y[3];
		for (int k = 0; k < 50; k++) { /* correlations */
			fw_increment raw;
			make_reading(&r, 0.01, &raw);
			fw_filter_predict(&f, &raw);
		}
		measured = f.pva;
		measured.llh[0] += 1e-8;
		measured.llh[2] += 0.3;
		position(&f, &z);
		for (int i = 0; i < n; i++)
			for (int j = 0; j < n; j++)
				P[i * n + j] = f.P[i][j];
		for (int i = 0; i < 3; i++)
			for (int j = 0; j < n; j++)
				H[i * n + j] = z.H[i][j];
		fw_mat_mul(3, n, n, H, P, HP);
		fw_mat_mul_t(3, n, 3, HP, H, S);
		for (int i = 0; i < 9; i++)
			S[i] += R[i / 3][i % 3];
		assert_int_equal(fw_mat_solve_spd(3, n, S, HP, X), FW_OK);
		assert_int_equal(fw_mat_solve_spd(3, 1, S, z.innovation, y), FW_OK);
		fw_filter before = f;
		double nis, expected_nis = 0, error[FW_STATES_MAX];
		assert_int_equal(fw_filter_update(&f, &z, &nis), FW_OK);
		for (int i = 0; i < 3; i++)
			expected_nis += z.innovation[i] * y[i];
		assert_true(fabs(nis - expected_nis) < 1e-9 * (1 + nis));
		fw_estimate_difference(&f.model.layout, &before.pva, before.x, &f.pva, f.x, error);
		for (int i = 0; i < n; i++) {
			double dx = 0;
			for (int k = 0; k < 3; k++)
				dx += HP[k * n + i] * y[k];
			assert_true(fabs(error[i] - dx) < 1e-7 * (1 + fabs(dx)));
			for (int j = 0; j < n; j++) {
				double cut = 0;
				for (int k = 0; k < 3; k++)
					cut += HP[k * n + i] * X[k * n + j];
				assert_true(fabs(f.P[i][j] - (P[i * n + j] - cut)) <
				            1e-9 * (1 + fabs(P[i * n + j])));
			}
		}
	}
}

/* A hundred thousand updates, half of them with hardly any noise, of a vehicle that stands: still symmetric to the bit, still positive
 * definite. */
static void covariance_stays_one(void **state)
{
	(void)state;
	const double no_lever[3] = {0}, tight[3][3] = {{1e-10, 0, 0}, {0, 1e-10, 0}, {0, 0, 1e-10}};
	fw_random r;
	fw_filter f;
	fw_earth e;
	double C[3][3];
	fw_random_init(&r, 14);
	make(&f, &r);
	const int n = f.model.layout.n;
	for (int i = 0; i < 3; i++)
		f.pva.velocity_mps[i] = 0;
	for (int i = FW_NAV_STATES; i < n; i++)
		f.x[i] = 0;
	measured = f.pva;
	fw_earth_at(measured.llh, measured.velocity_mps, &e);
	fw_quat_to_matrix(measured.q_n_b, C);
	for (int k = 0; k < 100000; k++) {
		const double dt = 0.01;
		fw_increment raw = {.dt_s = dt};
		fw_measurement z;
		for (int i = 0; i < 3; i++) {
			raw.angle_rad[i] = dt * (C[0][i] * e.omega_ie_n[0] + C[2][i] * e.omega_ie_n[2]) +
			                   1e-5 * fw_random_normal(&r);
			raw.velocity_mps[i] = -dt * C[2][i] * e.gravity_mps2 + 1e-4 * fw_random_normal(&r);
		}
		fw_filter_predict(&f, &raw);
		if (k % 2 == 0)
			fw_measure_position(&f, measured.llh, tight, no_lever, &z);
		else
			fw_measure_velocity(&f, measured.velocity_mps, R, no_lever, &z);
		assert_int_equal(fw_filter_update(&f, &z, NULL), FW_OK);
	}
	double P[FW_STATES_MAX * FW_STATES_MAX], L[FW_STATES_MAX * FW_STATES_MAX];
	for (int i = 0; i < n; i++)
		for (int j = 0; j < n; j++) {
			assert_true(f.P[i][j] == f.P[j][i]);
			P[i * n + j] = f.P[i][j] / sqrt(f.P[i][i] * f.P[j][j]) + (i == j ? 1e-12 : 0);
		}
	assert_int_equal(fw_mat_cholesky(n, P, L), FW_OK);
}

static void what_is_no_measurement_is_refused(void **state)
{
	(void)state;
	fw_random r;
	fw_filter f, before;
	fw_measurement z;
	double nis = 0;
	fw_random_init(&r, 15);
	make(&f, &r);
	measured = f.pva;
	before = f;
	position(&f, &z);
	z.R[0][0] = -1e6;
	assert_int_equal(fw_filter_update(&f, &z, &nis), FW_ESINGULAR);
	position(&f, &z);
	z.innovation[1] = (double)NAN;
	assert_int_equal(fw_filter_update(&f, &z, &nis), FW_ENONFINITE);
	position(&f, &z);
	z.H[0][2] = (double)INFINITY;
	assert_true(fw_filter_update(&f, &z, &nis) < 0);
	assert_memory_equal(&f, &before, sizeof f);
}

static void starts_are_checked(void **state)
{
	(void)state;
	fw_random r;
	fw_filter f, g;
	double sd[FW_STATES_MAX] = {0};
	fw_random_init(&r, 16);
	make(&f, &r);
	fw_pva bad = f.pva;
	bad.velocity_mps[1] = (double)NAN;
	assert_int_equal(fw_filter_init(&g, &f.model, &bad, sd), FW_ENONFINITE);
	bad = f.pva;
	bad.llh[0] = FW_PI / 2;
	assert_int_equal(fw_filter_init(&g, &f.model, &bad, sd), FW_EINVAL);
	sd[3] = -1;
	assert_int_equal(fw_filter_init(&g, &f.model, &f.pva, sd), FW_EINVAL);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(layout_holds_the_blocks),
	    cmocka_unit_test(jacobian_is_the_derivative),
	    cmocka_unit_test(measurements_are_derivatives),
	    cmocka_unit_test(update_is_the_textbooks),
	    cmocka_unit_test(covariance_stays_one),
	    cmocka_unit_test(what_is_no_measurement_is_refused),
	    cmocka_unit_test(starts_are_checked),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
