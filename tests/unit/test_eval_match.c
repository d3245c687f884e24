#include "../../cli/eval_match.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/frame.h"

enum { ROWS = 600 };

/* Two minutes to the end of a week, in nanoseconds. */
#define BEGIN_NS (2401 * FW_NS_PER_WEEK - 30 * FW_NS_PER_S)
#define STEP_NS  INT64_C(100000000)
#define ARM_M                                                                                                \
	{                                                                                                    \
		0.4, -0.3, 1.2                                                                               \
	}

/* An eight of 120 m with 8 m of climb, flown at about 12 m/s, on 53 degrees north; turning about all axes. Velocities
 * by the derivative of the formulas and the radii of curvature, not by what is tested here. */
static eval_fix trajectory(fw_time t)
{
	const double s = (double)(t.ns - BEGIN_NS) / 1e9, w = 2 * FW_PI / 60, a = 120 / 6.37e6;
	const double lat = fw_rad_from_deg(53.3) + a * sin(w * s), lat_dot = a * w * cos(w * s);
	const double lon = fw_rad_from_deg(-2.2) + a * sin(2 * w * s), lon_dot = 2 * a * w * cos(2 * w * s);
	const double h = 80 + 8 * sin(w * s / 2), h_dot = 4 * w * cos(w * s / 2);
	const double root = sqrt(1 - FW_WGS84_E2 * sin(lat) * sin(lat));
	const double N = FW_WGS84_A / root, M = N * (1 - FW_WGS84_E2) / (root * root);
	eval_fix fix = eval_fix_empty(t, FW_nav);
	fix.lat_rad = lat;
	fix.lon_rad = lon;
	fix.height_m = h;
	fix.velocity_mps[0] = (M + h) * lat_dot;
	fix.velocity_mps[1] = (N + h) * cos(lat) * lon_dot;
	fix.velocity_mps[2] = -h_dot;
	fix.rpy_rad[0] = 0.4 * sin(0.7 * s);
	fix.rpy_rad[1] = 0.2 * cos(0.5 * s);
	fix.rpy_rad[2] = fw_wrap_2pi(0.3 * s);
	const double llh[] = {lat, lon, h};
	assert_int_equal(fw_llh_to_ecef(llh, fix.position_m), FW_OK);
	return fix;
}

static fw_time row_time(int i)
{
	return (fw_time){BEGIN_NS + i * STEP_NS};
}

enum { WITH_ALL, WITHOUT_VELOCITY };

/* The trajectory at 10 Hz, without rows `gap` to `gap_end`. */
static eval_series make_truth(int what, int gap, int gap_end)
{
	eval_series s = {0};
	for (int i = 0; i < ROWS; i++) {
		eval_fix fix = trajectory(row_time(i));
		if (i >= gap && i < gap_end)
			continue;
		for (int j = 0; what == WITHOUT_VELOCITY && j < 3; j++)
			fix.velocity_mps[j] = nan("");
		assert_int_equal(eval_series_add(&s, &fix, ROWS), FW_OK);
	}
	eval_series_settle(&s, FW_RECORD_COUNT);
	return s;
}

static double distance(const double a[static 3], const double b[static 3])
{
	return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
	            (a[2] - b[2]) * (a[2] - b[2]));
}

/* The worst that interpolation does to position [m], velocity [m/s] and attitude [rad], over many moments, those half-way
 * between rows among them, `margin` rows from both ends; the end of the week is in the middle. */
static void worst_of(const eval_truth *truth, int margin, double worst[static 3])
{
	worst[0] = worst[1] = worst[2] = 0;
	for (int64_t ns = row_time(margin).ns; ns <= row_time(ROWS - 1 - margin).ns; ns += STEP_NS / 4) {
		eval_fix have, want = trajectory((fw_time){ns});
		assert_int_equal(eval_truth_at(truth, (fw_time){ns}, &have), FW_OK);
		worst[0] = fmax(worst[0], distance(have.position_m, want.position_m));
		if (isfinite(have.velocity_mps[0]))
			worst[1] = fmax(worst[1], distance(have.velocity_mps, want.velocity_mps));
		for (int i = 0; i < 3; i++)
			worst[2] = fmax(worst[2], fabs(fw_wrap_pi(have.rpy_rad[i] - want.rpy_rad[i])));
	}
}

static void interpolation_is_far_below_a_millimetre(void **state)
{
	eval_series s = make_truth(WITH_ALL, 0, 0);
	const eval_truth truth = {.series = &s, .gap_ns = 250000000};
	double worst[3];

	(void)state;
	worst_of(&truth, 0, worst);
	assert_true(worst[0] < 1e-6);
	assert_true(worst[1] < 1e-5);
	assert_true(worst[2] < 1e-3); /* slerp: h^2 / 8 of the angular acceleration, 0.2 rad/s^2 */
	eval_series_release(&s);
}

static void without_velocities_too(void **state)
{
	eval_series s = make_truth(WITHOUT_VELOCITY, 0, 0);
	const eval_truth truth = {.series = &s, .gap_ns = 250000000};
	eval_fix fix;
	double worst[3];

	(void)state;
	worst_of(&truth, 0, worst);
	assert_true(worst[0] < 1e-3);
	assert_true(worst[0] > 1e-9); /* it is another way, after all */
	assert_int_equal(eval_truth_at(&truth, row_time(100), &fix), FW_OK);
	assert_true(isnan(fix.velocity_mps[0])); /* positions alone are no velocity to judge others by */
	eval_series_release(&s);
}

/* The estimate of the report is the size of the error that there is. */
static void estimates_its_own_error(void **state)
{
	eval_series s = make_truth(WITHOUT_VELOCITY, 0, 0), with = make_truth(WITH_ALL, 0, 0);
	const eval_truth truth = {.series = &s, .gap_ns = 250000000},
	                 better = {.series = &with, .gap_ns = 250000000};
	double worst[3], estimate = eval_truth_interpolation(&truth);

	(void)state;
	worst_of(&truth, 2, worst);
	assert_true(estimate > worst[0] / 2 &&
	            estimate < worst[0] * 1.01); /* 95 % of them are below the estimate */
	assert_true(eval_truth_interpolation(&better) < estimate);
	eval_series_release(&s);
	eval_series_release(&with);
}

static void gaps_have_no_truth(void **state)
{
	eval_series s = make_truth(WITH_ALL, 200, 220);
	const eval_truth truth = {.series = &s, .gap_ns = 250000000};
	eval_fix fix, want = trajectory(row_time(199));
	double longest_s;

	(void)state;
	assert_int_equal(eval_truth_at(&truth, row_time(210), &fix), FW_ERANGE);
	assert_int_equal(eval_truth_at(&truth, fw_time_add_ns(row_time(199), 10000), &fix), FW_ERANGE);
	assert_int_equal(eval_truth_at(&truth, fw_time_add_ns(row_time(220), -10000), &fix), FW_ERANGE);
	assert_int_equal(eval_truth_at(&truth, row_time(220), &fix), FW_OK);
	assert_int_equal(eval_truth_at(&truth, row_time(199), &fix), FW_OK); /* the last row before it */
	assert_true(distance(fix.position_m, want.position_m) < 1e-8);
	assert_true(distance(fix.velocity_mps, want.velocity_mps) < 1e-8);
	assert_int_equal(eval_truth_at(&truth, fw_time_add_ns(row_time(0), -10000), &fix), FW_ERANGE);
	assert_int_equal(eval_truth_at(&truth, fw_time_add_ns(row_time(0), -500), &fix),
	                 FW_OK); /* a stamp through text */
	assert_int_equal(eval_truth_at(&truth, fw_time_add_ns(row_time(ROWS - 1), 500), &fix), FW_OK);
	assert_int_equal(eval_truth_at(&truth, fw_time_add_ns(row_time(ROWS - 1), 10000), &fix), FW_ERANGE);
	assert_int_equal(eval_truth_gaps(&truth, &longest_s), 1);
	assert_true(fabs(longest_s - 2.1) < 1e-12);
	eval_series_release(&s);
}

/* One row missing is no gap: 0.2 s are bridged, a little less exactly. */
static void a_lost_row_is_bridged(void **state)
{
	eval_series s = make_truth(WITH_ALL, 200, 201);
	const eval_truth truth = {.series = &s, .gap_ns = 250000000};
	eval_fix fix, want = trajectory(row_time(200));

	(void)state;
	assert_int_equal(eval_truth_at(&truth, row_time(200), &fix), FW_OK);
	assert_true(distance(fix.position_m, want.position_m) < 1e-5);
	eval_series_release(&s);
}

static void a_single_row_is_truth_at_its_stamp(void **state)
{
	eval_series s = {0};
	const eval_truth truth = {.series = &s, .gap_ns = 0};
	eval_fix fix = trajectory(row_time(0)), have;

	(void)state;
	assert_int_equal(eval_series_add(&s, &fix, 10), FW_OK);
	eval_series_settle(&s, FW_RECORD_COUNT);
	assert_int_equal(eval_truth_at(&truth, row_time(0), &have), FW_OK);
	assert_true(distance(fix.position_m, have.position_m) < 1e-8);
	assert_true(distance(fix.velocity_mps, have.velocity_mps) < 1e-8);
	assert_int_equal(eval_truth_at(&truth, row_time(1), &have), FW_ERANGE);
	eval_series_release(&s);
}

/* Where the antenna is, and how it moves, by differences of places that the exact attitude gives. */
static void antenna(fw_time t, double p_e[static 3])
{
	const double arm[] = ARM_M;
	eval_fix fix = trajectory(t);
	double C_e_n[3][3], C_n_b[3][3];
	fw_frame_ned(fix.lat_rad, fix.lon_rad, C_e_n);
	fw_euler_to_matrix(fix.rpy_rad, C_n_b);
	for (int i = 0; i < 3; i++) {
		p_e[i] = fix.position_m[i];
		for (int j = 0; j < 3; j++)
			for (int k = 0; k < 3; k++)
				p_e[i] += C_e_n[i][j] * C_n_b[j][k] * arm[k];
	}
}

static void lever_arm_moves_position_and_velocity(void **state)
{
	eval_series s = make_truth(WITH_ALL, 0, 0);
	const eval_truth truth = {.series = &s, .gap_ns = 250000000, .moved = true, .lever_arm_m = ARM_M};

	(void)state;
	for (int i = 10; i < ROWS - 10; i += 7) {
		const fw_time t = fw_time_add_ns(row_time(i), STEP_NS / 3);
		double here[3], before[3], after[3], v_e[3], v_n[3], C_e_n[3][3];
		eval_fix fix;
		antenna(t, here);
		antenna(fw_time_add_ns(t, -1000000), before);
		antenna(fw_time_add_ns(t, 1000000), after);
		assert_int_equal(eval_truth_at(&truth, t, &fix), FW_OK);
		for (int j = 0; j < 3; j++)
			v_e[j] = (after[j] - before[j]) / 2e-3;
		fw_frame_ned(fix.lat_rad, fix.lon_rad, C_e_n);
		for (int j = 0; j < 3; j++)
			v_n[j] = C_e_n[0][j] * v_e[0] + C_e_n[1][j] * v_e[1] + C_e_n[2][j] * v_e[2];
		assert_true(distance(fix.position_m, here) < 1e-3);
		assert_true(distance(fix.velocity_mps, v_n) <
		            0.03); /* the rate is that of the middle of the step */
	}
	eval_series_release(&s);
}

static void lever_arm_needs_attitude(void **state)
{
	eval_series s = {0};
	const eval_truth truth = {.series = &s, .gap_ns = 250000000, .moved = true, .lever_arm_m = ARM_M};
	eval_fix have;

	(void)state;
	for (int i = 0; i < 10; i++) {
		eval_fix fix = trajectory(row_time(i));
		fix.rpy_rad[0] = nan("");
		assert_int_equal(eval_series_add(&s, &fix, ROWS), FW_OK);
	}
	eval_series_settle(&s, FW_RECORD_COUNT);
	assert_int_equal(eval_truth_at(&truth, row_time(4), &have), FW_ERANGE);
	eval_series_release(&s);
}

/* A heading by two antennas, without roll: what is not known stays unknown, heading goes on. */
static void heading_alone_is_interpolated(void **state)
{
	eval_series s = {0};
	const eval_truth truth = {.series = &s, .gap_ns = 250000000};
	eval_fix have;

	(void)state;
	for (int i = 0; i < 4; i++) {
		eval_fix fix = trajectory(row_time(i));
		fix.rpy_rad[0] = fix.rpy_rad[1] = nan("");
		fix.rpy_rad[2] = fw_wrap_2pi(fw_rad_from_deg(358 + i));
		assert_int_equal(eval_series_add(&s, &fix, ROWS), FW_OK);
	}
	eval_series_settle(&s, FW_RECORD_COUNT);
	assert_int_equal(eval_truth_at(&truth, fw_time_add_ns(row_time(1), STEP_NS / 2), &have), FW_OK);
	assert_true(isnan(have.rpy_rad[0]) && isnan(have.rpy_rad[1]));
	assert_true(fabs(fw_wrap_pi(have.rpy_rad[2] - fw_rad_from_deg(359.5))) < 1e-12);
	eval_series_release(&s);
}

/* Expected epochs: 0.2 s from -1 s on, in 20 s of truth with a hole of 2.1 s. By hand: rows 0..199 are 0 to 19.9 s, hence
 * 0, 0.2 .. 19.8: 100; rows 220..599 are 22.0 to 59.9 s: 190. */
static void expected_epochs_are_those_with_truth(void **state)
{
	eval_series s = make_truth(WITH_ALL, 200, 220);
	const eval_truth truth = {.series = &s, .gap_ns = 250000000};
	const fw_time first = row_time(2), begin = {0}, end = {FW_TIME_NS_MAX};

	(void)state;
	assert_int_equal(eval_truth_expected(&truth, first, 2 * STEP_NS, begin, end), 290);
	assert_int_equal(eval_truth_expected(&truth, row_time(-10), 2 * STEP_NS, begin, end), 290);
	assert_int_equal(eval_truth_expected(&truth, first, 2 * STEP_NS, row_time(10), row_time(20)), 5);
	assert_int_equal(eval_truth_expected(&truth, first, 2 * STEP_NS, row_time(201), row_time(219)), 0);
	assert_int_equal(eval_truth_expected(&truth, first, 0, begin, end), 0);
	eval_series_release(&s);
}

/* Errors, by hand: near the equator and the date line, 1 m north and 2 m east, 3 m up. */
static void errors_are_solution_minus_truth(void **state)
{
	eval_fix truth = eval_fix_empty((fw_time){0}, FW_nav), solution = truth;
	const double M = FW_WGS84_A * (1 - FW_WGS84_E2);
	double e[EVAL_QUANTITIES];

	(void)state;
	truth.lat_rad = 0;
	truth.lon_rad = FW_PI;
	truth.height_m = 0;
	solution.lat_rad = 1 / M;
	solution.lon_rad = -FW_PI + 2 / FW_WGS84_A;
	solution.height_m = 3;
	eval_fix *both[] = {&truth, &solution};
	for (int i = 0; i < 2; i++) {
		const double llh[] = {both[i]->lat_rad, both[i]->lon_rad, both[i]->height_m};
		assert_int_equal(fw_llh_to_ecef(llh, both[i]->position_m), FW_OK);
	}
	for (int i = 0; i < 3; i++) {
		truth.velocity_mps[i] = 10;
		solution.velocity_mps[i] = 10 + i + 1;
	}
	truth.rpy_rad[2] = fw_rad_from_deg(359);
	solution.rpy_rad[2] = fw_rad_from_deg(1.5);
	eval_errors(&solution, &truth, e);
	assert_true(fabs(e[EVAL_NORTH] - 1) < 1e-5);
	assert_true(fabs(e[EVAL_EAST] - 2) < 1e-5);
	assert_true(fabs(e[EVAL_DOWN] + 3) < 1e-5);
	assert_true(fabs(e[EVAL_HORIZONTAL] - sqrt(5)) < 1e-5);
	assert_true(fabs(e[EVAL_POSITION] - sqrt(14)) < 1e-5);
	assert_true(e[EVAL_VN] == 1 && e[EVAL_VE] == 2 && e[EVAL_VD] == 3);
	assert_true(fabs(e[EVAL_VELOCITY] - sqrt(14)) < 1e-12);
	assert_true(fabs(e[EVAL_HEADING] - 2.5) < 1e-12);
	assert_true(isnan(e[EVAL_ROLL]) && isnan(e[EVAL_PITCH]) && isnan(e[EVAL_ATTITUDE]));
	truth.rpy_rad[0] = solution.rpy_rad[0] = 0.1;
	truth.rpy_rad[1] = solution.rpy_rad[1] = 0;
	eval_errors(&solution, &truth, e);
	assert_true(fabs(e[EVAL_ATTITUDE] - 2.5) < 1e-9); /* one turn about down */
}

/* ---- series ---- */

static void rows_are_put_in_order_and_merged(void **state)
{
	eval_series s = {0};
	const int order[] = {3, 1, 2, 1};

	(void)state;
	for (int i = 0; i < 4; i++) {
		eval_fix fix = trajectory(row_time(order[i]));
		fix.pl_m[EVAL_H] = 9;
		assert_int_equal(eval_series_add(&s, &fix, 100), FW_OK);
	}
	eval_fix other = trajectory(row_time(2)); /* a pvt beside a nav is not the solution */
	other.kind = FW_pvt;
	assert_int_equal(eval_series_add(&s, &other, 100), FW_OK);
	eval_fix level = eval_fix_empty(row_time(2), FW_pl), dop = eval_fix_empty(row_time(3), FW_dop);
	level.pl_m[EVAL_H] = 5;
	level.al_m[EVAL_H] = 40;
	dop.pl_m[EVAL_H] = 7;
	dop.pl_m[EVAL_V] = 8;
	assert_int_equal(eval_series_add(&s, &level, 100), FW_OK);
	assert_int_equal(eval_series_add(&s, &dop, 100), FW_OK);
	eval_series_settle(&s, FW_RECORD_COUNT);
	assert_int_equal(s.kind, FW_nav);
	assert_int_equal(s.n, 3);
	assert_int_equal(s.repeated, 1);
	for (int i = 0; i < 3; i++)
		assert_int_equal(s.fix[i].t.ns, row_time(i + 1).ns);
	assert_true(s.fix[1].pl_m[EVAL_H] == 5 &&
	            s.fix[1].al_m[EVAL_H] == 40); /* pl counts more than nav's own */
	assert_true(s.fix[2].pl_m[EVAL_H] == 9 && s.fix[2].pl_m[EVAL_V] == 8); /* dop fills what is missing */
	assert_int_equal(eval_series_interval(&s), STEP_NS);
	eval_series_release(&s);
}

/* A stream with levels knows the receiver's attitude too: that is not the solution's. */
static void levels_bring_nothing_else(void **state)
{
	eval_series s = {0}, levels = {0};
	eval_fix fix = trajectory(row_time(1)), level = eval_fix_empty(row_time(1), FW_pl);

	(void)state;
	const double pitch = fix.rpy_rad[1];
	level.pl_m[EVAL_H] = 5;
	level.al_m[EVAL_V] = 50;
	level.rpy_rad[1] = pitch + 1;
	level.sd_rpy_rad[1] = 1;
	assert_int_equal(eval_series_add(&s, &fix, 2), FW_OK);
	assert_int_equal(eval_series_add(&levels, &level, 2), FW_OK);
	eval_series_add_levels(&s, &levels);
	assert_true(s.fix[0].pl_m[EVAL_H] == 5 && s.fix[0].al_m[EVAL_V] == 50);
	assert_true(isnan(pitch) ? isnan(s.fix[0].rpy_rad[1]) : s.fix[0].rpy_rad[1] == pitch);
	eval_series_release(&s);
	eval_series_release(&levels);
}

static void nonsense_is_counted_not_kept(void **state)
{
	eval_series s = {0};
	eval_fix fix = trajectory(row_time(0));

	(void)state;
	fix.lat_rad = nan("");
	assert_int_equal(eval_series_add(&s, &fix, 2), FW_OK);
	fix.lat_rad = 7;
	assert_int_equal(eval_series_add(&s, &fix, 2), FW_ERANGE);
	fix = trajectory(row_time(0));
	fix.height_m = 1e11;
	assert_int_equal(eval_series_add(&s, &fix, 2), FW_ERANGE);
	for (int i = 0; i < 3; i++) {
		fix = trajectory(row_time(i));
		assert_int_equal(eval_series_add(&s, &fix, 2), FW_OK);
	}
	assert_int_equal(s.no_position, 1);
	assert_int_equal(s.misplaced, 2);
	assert_int_equal(s.too_many, 1);
	assert_int_equal(s.n, 2);
	eval_series_release(&s);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(interpolation_is_far_below_a_millimetre),
	    cmocka_unit_test(without_velocities_too),
	    cmocka_unit_test(estimates_its_own_error),
	    cmocka_unit_test(gaps_have_no_truth),
	    cmocka_unit_test(a_lost_row_is_bridged),
	    cmocka_unit_test(a_single_row_is_truth_at_its_stamp),
	    cmocka_unit_test(lever_arm_moves_position_and_velocity),
	    cmocka_unit_test(lever_arm_needs_attitude),
	    cmocka_unit_test(heading_alone_is_interpolated),
	    cmocka_unit_test(expected_epochs_are_those_with_truth),
	    cmocka_unit_test(errors_are_solution_minus_truth),
	    cmocka_unit_test(rows_are_put_in_order_and_merged),
	    cmocka_unit_test(levels_bring_nothing_else),
	    cmocka_unit_test(nonsense_is_counted_not_kept),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
