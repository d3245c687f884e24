/* magnetometer: calibrations against distortions that the simulator's forward model (sim/sensors.h) puts in,
 * headings against geometry by hand. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "base/random.h"
#include "ins/magnetometer.h"
#include "sim/sensors.h"

/* About the field in the middle of Germany: 49.3 uT, dip 66 degrees, declination 5 degrees [nT]. */
static const double earth[3] = {19850, 1740, 45070};

static const fw_magnetometer_model distorted = {
    .hard_iron_ut = {12, -7, 5},
    .soft_iron = {{0.08, 0.03, -0.02}, {0.03, -0.05, 0.01}, {-0.02, 0.01, 0.04}},
    .noise_ut = 0.1};

static double degrees(double rad)
{
	return fw_deg_from_rad(rad);
}

/* A reading at an attitude. */
static void read_at(fw_magnetometer *m, const double rpy[3], double mag[3])
{
	double C[3][3];

	fw_euler_to_matrix(rpy, C);
	fw_magnetometer_sample(m, C, earth, mag);
}

static fw_magnetometer instrument(const fw_magnetometer_model *model, uint64_t seed)
{
	fw_magnetometer m;

	assert_int_equal(fw_magnetometer_init(model, seed, &m), FW_OK);
	return m;
}

/* Any attitude, all alike likely. */
static void tumble(fw_random *r, double rpy[3])
{
	double q[4], C[3][3];

	for (int i = 0; i < 4; i++)
		q[i] = fw_random_normal(r);
	assert_int_equal(fw_quat_normalise(q), FW_OK);
	fw_quat_to_matrix(q, C);
	fw_matrix_to_euler(C, rpy);
}

/* Largest element of matrix (I + S) - I: the product of what was put in and what was found. */
static double matrix_error(const fw_mag_calibration *cal, const fw_magnetometer_model *model)
{
	double A[3][3], product[3][3], worst = 0;

	for (int i = 0; i < 9; i++)
		A[i / 3][i % 3] = model->soft_iron[i / 3][i % 3] + (i % 4 == 0);
	fw_mat3_mul(cal->matrix, A, product);
	for (int i = 0; i < 9; i++)
		worst = fmax(worst, fabs(product[i / 3][i % 3] - (i % 4 == 0)));
	return worst;
}

/* Root mean square of the heading's error around the circle [degrees], readings without noise. */
static double heading_rms_deg(const fw_mag_calibration *cal, const fw_magnetometer_model *model, double roll,
                              double pitch)
{
	fw_magnetometer_model quiet = *model;
	fw_magnetometer m;
	double sum = 0;

	quiet.noise_ut = 0;
	m = instrument(&quiet, 1);
	for (int i = 0; i < 72; i++) {
		double rpy[3] = {roll, pitch, i * FW_PI / 36}, mag[3], heading, sd, off;

		read_at(&m, rpy, mag);
		assert_int_equal(fw_mag_heading(cal, mag, rpy, 0, earth, &heading, &sd), FW_OK);
		off = fw_wrap_pi(heading - rpy[2]);
		sum += off * off;
	}
	return degrees(sqrt(sum / 72));
}

/* ---- heading ---- */

static void a_perfect_compass_shows_true_heading_at_any_tilt(void **state)
{
	fw_magnetometer_model perfect = {0};
	fw_mag_calibration none = fw_mag_as_it_is(49.3, 0);

	(void)state;
	assert_true(heading_rms_deg(&none, &perfect, 0, 0) < 1e-9);
	assert_true(heading_rms_deg(&none, &perfect, 0.5, -0.3) < 1e-9);
}

static void headings_by_hand(void **state)
{
	/* Level, 20 uT to magnetic north, which is straight off the left wing: the nose looks to magnetic
	 * east. Rolled by 90 degrees to the right (right wing down), the same: down is off the right wing,
	 * north where the belly looks. */
	static const double level[3] = {0, -20, 40}, rolled[3] = {0, 40, 20}, field[3] = {20000, 0, 40000};
	static const double turned_field[3] = {0, 20000, 40000}; /* declination 90 degrees */
	fw_mag_calibration none = fw_mag_as_it_is(hypot(20, 40), 0.2);
	double rp[2] = {0, 0}, heading, sd;

	(void)state;
	assert_int_equal(fw_mag_heading(&none, level, rp, 0, field, &heading, &sd), FW_OK);
	assert_true(fabs(heading - FW_PI / 2) < 1e-12);
	assert_true(fabs(sd - 0.2 / 20) < 1e-9);
	assert_int_equal(fw_mag_heading(&none, level, rp, 0.01, turned_field, &heading, &sd), FW_OK);
	assert_true(fabs(heading - FW_PI) < 1e-12);
	assert_true(fabs(sd - hypot(0.01, 0.01 * 2)) < 1e-9);
	rp[0] = FW_PI / 2;
	assert_int_equal(fw_mag_heading(&none, rolled, rp, 0, field, &heading, &sd), FW_OK);
	assert_true(fabs(heading - FW_PI / 2) < 1e-12);
}

static void the_stated_sigma_is_that_of_the_errors(void **state)
{
	enum { N = 4000 };
	fw_magnetometer_model noisy = {.noise_ut = 0.3};
	fw_magnetometer m = instrument(&noisy, 5);
	fw_mag_calibration none = fw_mag_as_it_is(sqrt(19.85 * 19.85 + 1.74 * 1.74 + 45.07 * 45.07), 0.3);
	fw_random r;
	double tilt_sd = 0.008, sum = 0;

	(void)state;
	fw_random_init(&r, 6);
	for (int i = 0; i < N; i++) {
		double rpy[3] = {0.1, -0.05, i * 2 * FW_PI / N}, mag[3], rp[2], heading, sd, z;

		read_at(&m, rpy, mag);
		rp[0] = rpy[0] + tilt_sd * fw_random_normal(&r);
		rp[1] = rpy[1] + tilt_sd * fw_random_normal(&r);
		assert_int_equal(fw_mag_heading(&none, mag, rp, tilt_sd, earth, &heading, &sd), FW_OK);
		z = fw_wrap_pi(heading - rpy[2]) / sd;
		sum += z * z;
	}
	assert_true(fabs(sqrt(sum / N) - 1) < 0.06);
}

static void a_field_of_the_wrong_strength_is_not_trusted(void **state)
{
	static const double beside_a_motor[3] = {25, 5, 50}, field[3] = {20000, 0, 45000};
	static const double vertical[3] = {0.5, 0.5, 49}, pole[3] = {0, 0, 55000}, rp[2] = {0, 0};
	fw_mag_calibration none = fw_mag_as_it_is(49.2, 0.1);
	double heading, sd = -1;

	(void)state;
	assert_int_equal(fw_mag_heading(&none, beside_a_motor, rp, 0, field, &heading, &sd), FW_OK);
	assert_true(sd > fw_rad_from_deg(15));
	assert_int_equal(fw_mag_heading(&none, vertical, rp, 0, field, &heading, &sd), FW_ESINGULAR);
	assert_int_equal(fw_mag_heading(&none, vertical, rp, 0, pole, &heading, &sd), FW_ESINGULAR);
}

static void arguments_that_are_none(void **state)
{
	static const double bad[3] = {20, (double)NAN, 40}, good[3] = {20, 0, 45}, rp[2] = {0, 0};
	fw_mag_calibration none = fw_mag_as_it_is(49.2, 0.1);
	double heading = 7, sd = 8;

	(void)state;
	assert_int_equal(fw_mag_heading(&none, bad, rp, 0, earth, &heading, &sd), FW_ENONFINITE);
	assert_int_equal(fw_mag_heading(&none, good, rp, (double)NAN, earth, &heading, &sd), FW_ENONFINITE);
	assert_int_equal(fw_mag_heading(&none, good, rp, -1, earth, &heading, &sd), FW_EINVAL);
	assert_true(heading == 7 && sd == 8);
}

static void the_model_of_the_field_says_when_it_is_out_of_date(void **state)
{
	static const double llh[3] = {0.9, 0.2, 100}, mag[3] = {20, 0, 45}, rp[2] = {0, 0};
	fw_mag_calibration none = fw_mag_as_it_is(49.2, 0.1);
	fw_civil now = {.year = 2026, .month = 6, .day = 1}, then = {.year = 2012, .month = 6, .day = 1};
	double heading, sd;
	fw_time t;

	(void)state;
	assert_int_equal(fw_time_from_civil(&now, &t), FW_OK);
	assert_int_equal(fw_mag_heading_at(&none, mag, rp, 0, llh, t, &heading, &sd), FW_OK);
	assert_true(degrees(heading) > 3 && degrees(heading) < 6); /* the declination */
	assert_int_equal(fw_time_from_civil(&then, &t), FW_OK);
	assert_int_equal(fw_mag_heading_at(&none, mag, rp, 0, llh, t, &heading, &sd), FW_DUBIOUS);
}

/* ---- turning on the ground ---- */

static void an_ellipsoid_is_found(void **state)
{
	fw_mag_calibration cal, none = fw_mag_as_it_is(49.3, 0.1);
	fw_magnetometer m = instrument(&distorted, 11);
	fw_mag_turning g;
	fw_random r;

	(void)state;
	fw_random_init(&r, 12);
	fw_mag_turning_init(&g);
	for (int i = 0; i < 2000; i++) {
		double rpy[3], mag[3];

		tumble(&r, rpy);
		read_at(&m, rpy, mag);
		assert_int_equal(fw_mag_turning_add(&g, mag), FW_OK);
	}
	assert_int_equal(fw_mag_turning_solve(&g, earth, &cal), FW_OK);
	assert_false(cal.flat);
	for (int i = 0; i < 3; i++)
		assert_true(fabs(cal.offset[i] - distorted.hard_iron_ut[i]) < 0.03);
	assert_true(matrix_error(&cal, &distorted) < 1e-3);
	assert_true(fabs(cal.noise_ut - 0.1) < 0.02);
	assert_true(heading_rms_deg(&none, &distorted, 0, 0) > 15);
	assert_true(heading_rms_deg(&cal, &distorted, 0.2, 0.1) < 0.1);
}

/* Readings in another unit give the same field. */
static void the_unit_of_the_readings_does_not_matter(void **state)
{
	fw_mag_calibration cal;
	fw_magnetometer m = instrument(&distorted, 11);
	double rpy[3], mag[3], field[3], scaled[3];
	fw_mag_turning g;
	fw_random r;

	(void)state;
	fw_random_init(&r, 12);
	fw_mag_turning_init(&g);
	for (int i = 0; i < 500; i++) {
		tumble(&r, rpy);
		read_at(&m, rpy, mag);
		for (int k = 0; k < 3; k++)
			scaled[k] = mag[k] * 0.013;
		assert_int_equal(fw_mag_turning_add(&g, scaled), FW_OK);
	}
	assert_int_equal(fw_mag_turning_solve(&g, earth, &cal), FW_OK);
	fw_mag_field(&cal, scaled, field);
	assert_true(fabs(sqrt(field[0] * field[0] + field[1] * field[1] + field[2] * field[2]) - 49.28) <
	            0.5);
}

/* The pilot's dance: turns level, nose down, and on either side. */
static void a_turn_with_some_tilts_is_enough_for_all_axes(void **state)
{
	fw_mag_calibration cal;
	fw_magnetometer m = instrument(&distorted, 21);
	fw_mag_turning g;

	(void)state;
	fw_mag_turning_init(&g);
	for (int i = 0; i < 1200; i++) {
		double rpy[3] = {0.9 * (i % 4 == 1) - 0.9 * (i % 4 == 2), -0.9 * (i % 4 == 3),
		                 i * 2 * FW_PI / 400},
		       mag[3];

		read_at(&m, rpy, mag);
		assert_int_equal(fw_mag_turning_add(&g, mag), FW_OK);
	}
	assert_int_equal(fw_mag_turning_solve(&g, earth, &cal), FW_OK);
	assert_true(heading_rms_deg(&cal, &distorted, 0, 0) < 0.3);
	assert_true(heading_rms_deg(&cal, &distorted, 0.3, 0) < 0.5);
}

static void a_flat_turn_calibrates_the_level_compass(void **state)
{
	fw_magnetometer_model flat = distorted;
	fw_mag_calibration cal;
	fw_magnetometer m;
	fw_mag_turning g;
	fw_random r;

	(void)state;
	fw_random_init(&r, 3);
	/* Without these two, what the vertical field makes of them looks like hard iron, and goes with it. */
	for (int i = 0; i < 2; i++)
		flat.soft_iron[2][i] = flat.soft_iron[i][2] = 0;
	m = instrument(&flat, 31);
	fw_mag_turning_init(&g);
	for (int i = 0; i < 1000; i++) {
		double rpy[3] = {0.005 * fw_random_normal(&r), 0.005 * fw_random_normal(&r),
		                 i * 2 * FW_PI / 500},
		       mag[3];

		read_at(&m, rpy, mag);
		assert_int_equal(fw_mag_turning_add(&g, mag), FW_OK);
	}
	assert_int_equal(fw_mag_turning_solve(&g, earth, &cal), FW_DUBIOUS);
	assert_true(cal.flat);
	assert_true(fabs(cal.offset[0] - 12) < 0.15 && fabs(cal.offset[1] + 7) < 0.15);
	assert_true(heading_rms_deg(&cal, &flat, 0, 0) < 0.3);
}

static void a_sector_is_refused(void **state)
{
	fw_mag_calibration cal = fw_mag_as_it_is(1, 2);
	fw_magnetometer m = instrument(&distorted, 41);
	fw_mag_turning g;
	double mag[3];

	(void)state;
	fw_mag_turning_init(&g);
	for (int i = 0; i < 1000; i++) {
		double rpy[3] = {0, 0, i * FW_PI / 6 / 1000};

		read_at(&m, rpy, mag);
		assert_int_equal(fw_mag_turning_add(&g, mag), FW_OK);
		if (i == 5)
			assert_int_equal(fw_mag_turning_solve(&g, earth, &cal), FW_MORE);
	}
	assert_int_equal(fw_mag_turning_solve(&g, earth, &cal), FW_ESINGULAR);
	fw_mag_turning_init(&g);
	for (int i = 0; i < 100; i++) /* the very same reading again and again */
		assert_int_equal(fw_mag_turning_add(&g, mag), FW_OK);
	assert_int_equal(fw_mag_turning_solve(&g, earth, &cal), FW_ESINGULAR);
	assert_true(cal.field_ut == 1 && cal.noise_ut == 2);
	mag[1] = (double)INFINITY;
	assert_int_equal(fw_mag_turning_add(&g, mag), FW_ENONFINITE);
}

/* ---- with attitude ---- */

/* A flight about a route: all headings, small tilts. */
static void fly(fw_magnetometer *m, fw_random *r, int n, double heading_sd, fw_mag_referenced *g)
{
	fw_mag_referenced_init(g);
	for (int i = 0; i < n; i++) {
		double rpy[3] = {0.1 * fw_random_normal(r), 0.1 * fw_random_normal(r),
		                 2 * FW_PI * fw_random_uniform(r)};
		double mag[3], q[4];

		read_at(m, rpy, mag);
		rpy[2] += heading_sd * fw_random_normal(r);
		fw_euler_to_quat(rpy, q);
		assert_int_equal(fw_mag_referenced_add(g, q, earth, mag), FW_OK);
	}
}

static void with_attitude_soft_iron_that_turns_the_field_is_found_too(void **state)
{
	fw_magnetometer_model turning = distorted;
	fw_mag_calibration cal;
	fw_magnetometer m;
	fw_mag_referenced g;
	fw_random r;

	(void)state;
	turning.soft_iron[0][1] = 0.09; /* not symmetric: turns by 3 degrees */
	turning.soft_iron[1][0] = -0.03;
	m = instrument(&turning, 51);
	fw_random_init(&r, 52);
	fly(&m, &r, 3000, 0.005, &g);
	assert_int_equal(fw_mag_referenced_solve(&g, &cal), FW_OK);
	for (int i = 0; i < 3; i++)
		assert_true(fabs(cal.offset[i] - turning.hard_iron_ut[i]) < 0.15);
	assert_true(matrix_error(&cal, &turning) < 4e-3);
	assert_true(heading_rms_deg(&cal, &turning, 0.1, 0.1) < 0.1);
}

/* Over many short calibrations, errors of heading are as large as each says. The 100 x 72 errors are not
 * independent: the worst axis and the worst heading make it a little careful. */
static void a_calibration_knows_how_good_it_is(void **state)
{
	double sum = 0;

	(void)state;
	for (uint64_t seed = 0; seed < 100; seed++) {
		fw_magnetometer m = instrument(&distorted, 100 + seed);
		fw_mag_calibration cal;
		fw_mag_referenced g;
		fw_random r;

		fw_random_init(&r, 200 + seed);
		fly(&m, &r, 40, 0.01, &g);
		assert_int_equal(fw_mag_referenced_solve(&g, &cal), FW_OK);
		sum += pow(heading_rms_deg(&cal, &distorted, 0, 0) / degrees(cal.heading_sd_rad), 2);
	}
	assert_true(sqrt(sum / 100) > 0.6 && sqrt(sum / 100) < 1.05);
}

static void one_heading_is_not_enough(void **state)
{
	fw_magnetometer m = instrument(&distorted, 61);
	fw_mag_calibration cal;
	fw_mag_referenced g;
	fw_random r;

	(void)state;
	fw_random_init(&r, 62);
	fly(&m, &r, 10, 0, &g);
	assert_int_equal(fw_mag_referenced_solve(&g, &cal), FW_MORE);
	fw_mag_referenced_init(&g);
	for (int i = 0; i < 1000; i++) {
		double rpy[3] = {0, 0, 1 + 0.01 * fw_random_normal(&r)}, mag[3], q[4];

		read_at(&m, rpy, mag);
		fw_euler_to_quat(rpy, q);
		assert_int_equal(fw_mag_referenced_add(&g, q, earth, mag), FW_OK);
	}
	assert_int_equal(fw_mag_referenced_solve(&g, &cal), FW_ESINGULAR);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(a_perfect_compass_shows_true_heading_at_any_tilt),
	    cmocka_unit_test(headings_by_hand),
	    cmocka_unit_test(the_stated_sigma_is_that_of_the_errors),
	    cmocka_unit_test(a_field_of_the_wrong_strength_is_not_trusted),
	    cmocka_unit_test(arguments_that_are_none),
	    cmocka_unit_test(the_model_of_the_field_says_when_it_is_out_of_date),
	    cmocka_unit_test(an_ellipsoid_is_found),
	    cmocka_unit_test(the_unit_of_the_readings_does_not_matter),
	    cmocka_unit_test(a_turn_with_some_tilts_is_enough_for_all_axes),
	    cmocka_unit_test(a_flat_turn_calibrates_the_level_compass),
	    cmocka_unit_test(a_sector_is_refused),
	    cmocka_unit_test(with_attitude_soft_iron_that_turns_the_field_is_found_too),
	    cmocka_unit_test(a_calibration_knows_how_good_it_is),
	    cmocka_unit_test(one_heading_is_not_enough),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
