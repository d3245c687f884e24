#include "../../cli/eval_stats.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/frame.h"

enum { EPOCHS = 8 };

/* Errors of a solution at seconds 1..8 of a truth of seconds 0..9 that stands still on the equator. */
static const double velocity_errors[EPOCHS][3] = {{.1, -.3, .2},   {-.25, .05, .4}, {0, .15, -.6},
                                                  {.45, -.1, .1},  {-.05, .3, -.2}, {.12, .2, .3},
                                                  {.02, -.22, .9}, {-.3, .08, -.1}};
static const double velocity_sd[] = {.2, .15, .3};
static const double east_errors[EPOCHS] = {1, 2, 3, 4, 5, 6, 7, 8};

static fw_time second(int s)
{
	return (fw_time){2400 * FW_NS_PER_WEEK + s * FW_NS_PER_S};
}

static eval_fix still(int s)
{
	eval_fix fix = eval_fix_empty(second(s), FW_nav);
	fix.lat_rad = fix.lon_rad = fix.height_m = 0;
	fix.velocity_mps[0] = fix.velocity_mps[1] = fix.velocity_mps[2] = 0;
	return fix;
}

static eval_series make_truth(void)
{
	eval_series s = {0};
	for (int i = 0; i < 10; i++) {
		eval_fix fix = still(i);
		assert_int_equal(eval_series_add(&s, &fix, 100), FW_OK);
	}
	eval_series_settle(&s, FW_RECORD_COUNT);
	return s;
}

static eval_series make_solution(void)
{
	eval_series s = {0};
	for (int i = 0; i < EPOCHS; i++) {
		eval_fix fix = still(i + 1);
		fix.lon_rad = east_errors[i] / FW_WGS84_A;
		fix.pl_m[EVAL_H] = 4.5;
		fix.pl_m[EVAL_V] = i < 4 ? 1 : 60;
		fix.fom_m[EVAL_H] = 6.5;
		fix.sd_position_m[1] = i == 0 ? 0 : 2; /* nought is no standard deviation */
		for (int j = 0; j < 3; j++) {
			fix.velocity_mps[j] = velocity_errors[i][j];
			fix.sd_velocity_mps[j] = velocity_sd[j];
		}
		assert_int_equal(eval_series_add(&s, &fix, 100), FW_OK);
	}
	eval_series_settle(&s, FW_RECORD_COUNT);
	return s;
}

/* Everything, and the halves 0..5 s and 5..10 s. Alert limits 6 m and 50 m. */
static const eval_section halves[] = {
    {{2400 * FW_NS_PER_WEEK}, {2400 * FW_NS_PER_WEEK + 5 * FW_NS_PER_S}},
    {{2400 * FW_NS_PER_WEEK + 5 * FW_NS_PER_S}, {2400 * FW_NS_PER_WEEK + 10 * FW_NS_PER_S}}};
static const eval_question question = {
    .al_m = {6, 50},
    .window = {{2400 * FW_NS_PER_WEEK}, {2400 * FW_NS_PER_WEEK + 10 * FW_NS_PER_S}},
    .sections = halves,
    .n_sections = 2};

typedef struct {
	eval_series truth_series, solution;
	eval_truth truth;
	eval_result result;
} fixture;

static void set_up(fixture *f)
{
	f->truth_series = make_truth();
	f->solution = make_solution();
	f->truth = (eval_truth){.series = &f->truth_series, .gap_ns = 2500000000};
	assert_int_equal(eval_compare(&f->solution, &f->truth, &question, &f->result), FW_OK);
}

static void tear_down(fixture *f)
{
	eval_result_release(&f->result);
	eval_series_release(&f->solution);
	eval_series_release(&f->truth_series);
}

static void assert_near(double have, double want, double tolerance)
{
	if (!(fabs(have - want) <= tolerance))
		fail_msg("%.17g, not %.17g", have, want);
}

/* Expected: numpy on the table above. */
static void errors_are_summed_up(void **state)
{
	fixture f;

	(void)state;
	set_up(&f);
	const eval_row *row = f.result.whole.row;
	assert_int_equal(f.result.n, EPOCHS);
	assert_near(row[EVAL_VN].errors.mean, 0.01125, 1e-12);
	assert_near(row[EVAL_VN].errors.rms, 0.218603522386992, 1e-12);
	assert_near(row[EVAL_VN].errors.p50, 0.11, 1e-12);
	assert_near(row[EVAL_VN].errors.p68, 0.2188, 1e-12);
	assert_near(row[EVAL_VN].errors.p95, 0.3975, 1e-12);
	assert_near(row[EVAL_VN].errors.p99, 0.4395, 1e-12);
	assert_near(row[EVAL_VN].errors.max, 0.45, 1e-12);
	assert_near(row[EVAL_VELOCITY].errors.rms, 0.525844558781395, 1e-12);
	assert_near(row[EVAL_VELOCITY].errors.p95, 0.818827552931488, 1e-12);
	assert_near(row[EVAL_EAST].errors.mean, 4.5, 1e-8);
	assert_near(row[EVAL_HORIZONTAL].errors.p50, 4.5, 1e-8);
	assert_int_equal(row[EVAL_HEADING].errors.n, 0);
	tear_down(&f);
}

static void consistency_is_counted(void **state)
{
	fixture f;

	(void)state;
	set_up(&f);
	const eval_row *row = f.result.whole.row;
	assert_int_equal(row[EVAL_VN].with_sd, 8);
	assert_int_equal(row[EVAL_VN].inside[0], 5);
	assert_int_equal(row[EVAL_VN].inside[1], 7);
	assert_int_equal(row[EVAL_VN].inside[2], 8);
	assert_int_equal(row[EVAL_VE].inside[0], 4);
	assert_int_equal(row[EVAL_VE].inside[1], 8);
	assert_int_equal(row[EVAL_VE].inside[2], 8);
	assert_int_equal(row[EVAL_VD].inside[0], 5);
	assert_int_equal(row[EVAL_VD].inside[1], 7);
	assert_int_equal(row[EVAL_VD].inside[2], 8);
	assert_int_equal(row[EVAL_VELOCITY].with_nees, 8);
	assert_near(row[EVAL_VELOCITY].nees, 1.67563657407407, 1e-12);
	assert_int_equal(row[EVAL_VELOCITY].nees_inside, 7);
	assert_int_equal(row[EVAL_EAST].with_sd, 7);       /* the first has none */
	assert_int_equal(row[EVAL_EAST].inside[0], 1);     /* 2 */
	assert_int_equal(row[EVAL_EAST].inside[1], 3);     /* 2 3 4 */
	assert_int_equal(row[EVAL_EAST].inside[2], 5);     /* 2 .. 6 */
	assert_int_equal(row[EVAL_POSITION].with_nees, 0); /* north and down have none */
	tear_down(&f);
}

/* Horizontal errors 1..8, PL 4.5, AL 6: four nominal, 5 and 6 MI, 7 and 8 HMI. Vertical errors 0, PL 1 four times and 60
 * four times, AL 50: unavailable. */
static void stanford_classes_are_counted(void **state)
{
	fixture f;

	(void)state;
	set_up(&f);
	const eval_row *h = &f.result.whole.row[EVAL_HORIZONTAL], *v = &f.result.whole.row[EVAL_DOWN];
	assert_int_equal(h->with_level, 8);
	assert_int_equal(h->stanford[FW_NOMINAL], 4);
	assert_int_equal(h->stanford[FW_MISLEADING], 2);
	assert_int_equal(h->stanford[FW_HAZARDOUS], 2);
	assert_int_equal(h->stanford[FW_UNAVAILABLE], 0);
	assert_int_equal(v->stanford[FW_NOMINAL], 4);
	assert_int_equal(v->stanford[FW_UNAVAILABLE], 4);
	assert_int_equal(h->with_fom, 8);
	assert_int_equal(h->fom_inside, 6); /* 1 .. 6, FOM 6.5 */
	assert_int_equal(v->with_fom, 0);
	tear_down(&f);
}

/* Truth at 0..9 s: ten epochs could have been, eight were. */
static void availability_by_section(void **state)
{
	fixture f;

	(void)state;
	set_up(&f);
	assert_int_equal(f.result.interval_ns, FW_NS_PER_S);
	assert_int_equal(f.result.whole.expected, 10);
	assert_int_equal(f.result.whole.row[EVAL_POSITION].solved, 8);
	assert_int_equal(f.result.sections[0].expected, 5);
	assert_int_equal(f.result.sections[0].row[EVAL_POSITION].solved, 4); /* 1 .. 4 s */
	assert_int_equal(f.result.sections[1].expected, 5);
	assert_int_equal(f.result.sections[1].row[EVAL_POSITION].solved, 4); /* 5 .. 8 s */
	assert_near(f.result.sections[0].row[EVAL_EAST].errors.mean, 2.5, 1e-8);
	assert_near(f.result.sections[1].row[EVAL_EAST].errors.mean, 6.5, 1e-8);
	assert_int_equal(f.result.sections[0].row[EVAL_ROLL].solved, 0);
	tear_down(&f);
}

static void truth_that_has_no_such_time_is_no_truth(void **state)
{
	fixture f;
	eval_question later = question;
	eval_result r;

	(void)state;
	set_up(&f);
	later.window.begin = second(9);
	assert_int_equal(eval_compare(&f.solution, &f.truth, &later, &r), FW_ERANGE);
	eval_result_release(&r);
	eval_series none = {0};
	assert_int_equal(eval_compare(&none, &f.truth, &question, &r), FW_ERANGE);
	eval_result_release(&r);
	tear_down(&f);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(errors_are_summed_up),
	    cmocka_unit_test(consistency_is_counted),
	    cmocka_unit_test(stanford_classes_are_counted),
	    cmocka_unit_test(availability_by_section),
	    cmocka_unit_test(truth_that_has_no_such_time_is_no_truth),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
