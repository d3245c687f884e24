/* heading_table: what it learns against deviations that are put in, through an outage of GNSS heading on a
 * simulated flight. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "base/frame.h"
#include "base/random.h"
#include "ins/heading_table.h"
#include "ins/magnetometer.h"
#include "sim/sensors.h"

static fw_time at(double seconds)
{
	return (fw_time){INT64_C(1450000000) * FW_NS_PER_S + llround(seconds * 1e9)};
}

static fw_heading_table fresh(void)
{
	fw_heading_table_setup setup = fw_heading_table_defaults();
	fw_heading_table h;

	assert_int_equal(fw_heading_table_init(&setup, &h), FW_OK);
	return h;
}

static double deg(double degrees)
{
	return fw_rad_from_deg(degrees);
}

static double corrected(const fw_heading_table *h, double magnetic)
{
	double correction, sd;

	fw_heading_table_correction(h, magnetic, &correction, &sd);
	return magnetic + correction;
}

/* ---- small cases ---- */

static void nothing_learnt_is_nothing_corrected(void **state)
{
	fw_heading_table h = fresh();
	double correction, sd;

	(void)state;
	fw_heading_table_correction(&h, 1, &correction, &sd);
	assert_true(correction == 0);
	/* Five terms: 5 degrees for the constant, and for each of the cycles, whose cos^2 + sin^2 is 1; half
	 * way between two cells each counts half. Heading 1 is 5.73 cells from north. */
	assert_true(fabs(sd - deg(sqrt(3 * 25 + 0.73 * 0.73 + 0.27 * 0.27))) < 1e-4);
}

static void a_steady_offset_is_learnt_once_and_for_all_headings_in_part(void **state)
{
	fw_heading_table h = fresh();
	double correction, sd, other, other_sd;

	(void)state;
	for (int i = 0; i < 100; i++)
		assert_int_equal(fw_heading_table_update(&h, at(i), deg(90), deg(94), deg(0.5)), FW_OK);
	fw_heading_table_correction(&h, deg(90), &correction, &sd);
	fw_heading_table_correction(&h, deg(270), &other, &other_sd);
	assert_true(fabs(correction - deg(4)) < deg(0.02));
	/* 0.5 / sqrt(100) if nothing moved; the three terms that count here wander by 2 25 / 86400 each in a
	 * second, and then it is the fourth root of (3 2 25 / 86400) 0.5^2. */
	assert_true(sd > deg(0.05) && sd < deg(pow(150 / 86400.0 * 0.25, 0.25) * 1.1));
	/* Opposite, a cycle of one turn has the other sign: of three terms alike two go with it, one against:
	 * a third, and most of the doubt remains. */
	assert_true(fabs(other - deg(4.0 / 3)) < deg(0.1));
	assert_true(other_sd > deg(5));
}

static void north_is_no_border(void **state)
{
	fw_heading_table h = fresh();

	(void)state;
	for (int i = 0; i < 200; i++) {
		double magnetic = deg(i % 2 ? 359 : 1);

		assert_int_equal(
		    fw_heading_table_update(&h, at(i), magnetic, fw_wrap_2pi(magnetic - deg(3)), deg(0.3)),
		    FW_OK);
	}
	assert_true(fabs(corrected(&h, deg(0.2)) - deg(-2.8)) < deg(0.1));
	assert_true(fabs(corrected(&h, deg(359.8)) - deg(356.8)) < deg(0.1));
	assert_true(fabs(corrected(&h, deg(-0.2)) - deg(-3.2)) < deg(0.1));
}

static void samples_close_together_share_their_weight(void **state)
{
	fw_heading_table slow = fresh(), fast = fresh();
	double correction, slow_sd, fast_sd;

	(void)state;
	for (int i = 0; i < 20; i++)
		assert_int_equal(fw_heading_table_update(&slow, at(i), 2, 2.05, 0.01), FW_OK);
	for (int i = 0; i < 400; i++)
		assert_int_equal(fw_heading_table_update(&fast, at(i * 0.05), 2, 2.05, 0.01), FW_OK);
	fw_heading_table_correction(&slow, 2, &correction, &slow_sd);
	fw_heading_table_correction(&fast, 2, &correction, &fast_sd);
	assert_true(fabs(fast_sd / slow_sd - 1) < 0.05);
}

/* Iron that is vertical when level: nothing to see until the vehicle leans. By geometry, hard iron of 2 uT
 * downwards under a field of 20 uT turns a compass that looks north and is rolled by 0.2 by atan(2 sin 0.2 /
 * 20) to the left. */
static void vertical_iron_shows_when_leaning(void **state)
{
	static const double right[2] = {0.2, 0}, left[2] = {-0.2, 0}, field[3] = {20000, 0, 40000};
	fw_mag_calibration none = fw_mag_as_it_is(hypot(20, 40), 0.1);
	fw_magnetometer_model iron = {.hard_iron_ut = {0, 0, 2}};
	double turned = atan(2 * sin(0.2) / 20), correction, sd;
	fw_heading_table h = fresh();
	fw_magnetometer m;

	(void)state;
	assert_int_equal(fw_magnetometer_init(&iron, 1, &m), FW_OK);
	for (int i = 0; i < 600; i++) {
		double rpy[3] = {i % 2 ? 0.2 : -0.2, 0, i * 2 * FW_PI / 60}, C[3][3], mag[3], magnetic;

		fw_euler_to_matrix(rpy, C);
		fw_magnetometer_sample(&m, C, field, mag);
		assert_int_equal(fw_mag_heading(&none, mag, rpy, 0, field, &magnetic, &sd), FW_OK);
		fw_heading_table_tilt(&h, rpy);
		assert_int_equal(fw_heading_table_update(&h, at(i), magnetic, rpy[2], deg(0.2)), FW_OK);
	}
	fw_heading_table_tilt(&h, right);
	fw_heading_table_correction(&h, turned, &correction, &sd);
	assert_true(fabs(correction + turned) < deg(0.1));
	fw_heading_table_tilt(&h, left);
	fw_heading_table_correction(&h, -turned, &correction, &sd);
	assert_true(fabs(correction - turned) < deg(0.1));
}

static void one_wrong_heading_does_little(void **state)
{
	fw_heading_table h = fresh();
	double before, after;

	(void)state;
	for (int i = 0; i < 30; i++)
		assert_int_equal(fw_heading_table_update(&h, at(i), 1, 1.03, 0.01), FW_OK);
	before = corrected(&h, 1);
	assert_int_equal(fw_heading_table_update(&h, at(31), 1, 1 + FW_PI / 2, 1e-4), FW_OK);
	after = corrected(&h, 1);
	assert_true(fabs(after - before) < deg(0.05));
}

static void a_compass_that_has_changed_is_learnt_anew(void **state)
{
	fw_heading_table h = fresh();

	(void)state;
	for (int i = 0; i < 600; i++)
		assert_int_equal(fw_heading_table_update(&h, at(i), 1, 1.05, 0.01), FW_OK);
	for (int i = 600; i < 1200; i++)
		assert_int_equal(fw_heading_table_update(&h, at(i), 1, 0.95, 0.01), FW_OK);
	assert_true(fabs(corrected(&h, 1) - 0.95) < deg(1));
	assert_int_equal(fw_heading_table_update(&h, at(1e6), 3, 3, 0.01), FW_OK); /* 11 days later */
	assert_true(fabs(corrected(&h, 1) - 1) < deg(0.5));
}

static void what_is_not_a_heading_is_refused(void **state)
{
	fw_heading_table_setup setup = fw_heading_table_defaults();
	fw_heading_table h = fresh();
	double correction, sd;

	(void)state;
	assert_int_equal(fw_heading_table_update(&h, at(5), (double)NAN, 0, 1), FW_ENONFINITE);
	assert_int_equal(fw_heading_table_update(&h, at(5), 0, (double)INFINITY, 1), FW_ENONFINITE);
	assert_int_equal(fw_heading_table_update(&h, at(5), 0, 0, 0), FW_EINVAL);
	assert_int_equal(fw_heading_table_update(&h, at(5), 0, 0, -1), FW_EINVAL);
	assert_int_equal(fw_heading_table_update(&h, at(5), 0, 0.1, 1), FW_OK);
	assert_int_equal(fw_heading_table_update(&h, at(4), 0, 0.1, 1), FW_EINVAL);
	fw_heading_table_correction(&h, (double)NAN, &correction, &sd);
	assert_true(isnan(correction) && isnan(sd));
	setup.memory_s = 0;
	assert_int_equal(fw_heading_table_init(&setup, &h), FW_EINVAL);
}

/* ---- a flight ---- */

/* Ten minutes around a field by way of waypoints, legs of 20 s between turns, with hard and soft iron of
 * three to four degrees, and no GNSS heading for two minutes. */
typedef struct {
	double before_deg,
	    after_deg; /* root mean square in the outage, of the compass and of the corrected one */
	double sigmas; /* the latter over its sigma */
} flight;

static const double earth[3] = {19850, 1740, 45070};

static double heading_at(double t)
{
	static const double legs_deg[] = {0, 90, 180, 215, 63, 135, 18, 0, 303, 256, 180, 128, 62};
	double place = t / 20;
	int leg = (int)place % 13, next = (leg + 1) % 13;
	double turn = fmax(0, (place - floor(place)) * 20 - 16) / 4;

	return deg(legs_deg[leg]) + turn * fw_wrap_pi(deg(legs_deg[next]) - deg(legs_deg[leg]));
}

static flight fly(const fw_magnetometer_model *model, uint64_t seed, int visited_until_s)
{
	fw_mag_calibration none = fw_mag_as_it_is(49.28, 0.3);
	fw_heading_table h = fresh();
	fw_magnetometer m;
	fw_random r;
	double before = 0, after = 0, sigmas = 0;
	int n = 0;

	fw_random_init(&r, seed);
	assert_int_equal(fw_magnetometer_init(model, seed, &m), FW_OK);
	for (int i = 0; i < 420 * 5; i++) {
		double t = i / 5.0, rpy[3] = {0.15 * sin(t / 3), 0.15 * cos(t / 4), heading_at(t)}, C[3][3],
		       mag[3];
		double magnetic, sd, off, correction;

		fw_euler_to_matrix(rpy, C);
		fw_magnetometer_sample(&m, C, earth, mag);
		assert_int_equal(fw_mag_heading(&none, mag, rpy, 0, earth, &magnetic, &sd), FW_OK);
		fw_heading_table_tilt(&h, rpy);
		if (t < visited_until_s) {
			double gnss = rpy[2] + deg(0.3) * fw_random_normal(&r);

			assert_int_equal(fw_heading_table_update(&h, at(t), magnetic, gnss, deg(0.5)), FW_OK);
		} else if (t >= 300) {
			fw_heading_table_correction(&h, magnetic, &correction, &sd);
			before += pow(fw_wrap_pi(magnetic - rpy[2]), 2);
			off = fw_wrap_pi(magnetic + correction - rpy[2]);
			after += off * off;
			sigmas +=
			    off * off / (sd * sd + pow(deg(0.3), 2)); /* and the magnetometer's own noise */
			n++;
		}
	}
	return (flight){fw_deg_from_rad(sqrt(before / n)), fw_deg_from_rad(sqrt(after / n)),
	                sqrt(sigmas / n)};
}

static const fw_magnetometer_model disturbed = {
    .hard_iron_ut = {1.5, -1.2, 1.5},
    .soft_iron = {{0.03, 0.01, 0}, {0.01, -0.02, 0}, {0, 0, 0.01}},
    .noise_ut = 0.1};

static void three_degrees_become_less_than_half_a_degree_through_an_outage(void **state)
{
	(void)state;
	for (uint64_t seed = 1; seed <= 10; seed++) {
		flight f = fly(&disturbed, seed, 300);

		assert_true(f.before_deg > 3 && f.before_deg < 4);
		assert_true(f.after_deg < 0.5);
		assert_true(f.sigmas < 1.2);
	}
}

/* With one leg seen only, the other headings get what the harmonics make of it: no worse than without. */
static void headings_never_seen_are_no_worse_than_the_compass_alone(void **state)
{
	(void)state;
	for (uint64_t seed = 1; seed <= 10; seed++) {
		flight f = fly(&disturbed, seed, 110);

		assert_true(f.after_deg < f.before_deg);
		assert_true(f.sigmas < 2);
	}
}

static void a_good_compass_is_not_made_worse(void **state)
{
	fw_magnetometer_model good = {.noise_ut = 0.1};

	(void)state;
	for (uint64_t seed = 1; seed <= 10; seed++) {
		flight f = fly(&good, seed, 300);

		assert_true(f.after_deg < f.before_deg + 0.15);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(nothing_learnt_is_nothing_corrected),
	    cmocka_unit_test(a_steady_offset_is_learnt_once_and_for_all_headings_in_part),
	    cmocka_unit_test(north_is_no_border),
	    cmocka_unit_test(samples_close_together_share_their_weight),
	    cmocka_unit_test(vertical_iron_shows_when_leaning),
	    cmocka_unit_test(one_wrong_heading_does_little),
	    cmocka_unit_test(a_compass_that_has_changed_is_learnt_anew),
	    cmocka_unit_test(what_is_not_a_heading_is_refused),
	    cmocka_unit_test(three_degrees_become_less_than_half_a_degree_through_an_outage),
	    cmocka_unit_test(headings_never_seen_are_no_worse_than_the_compass_alone),
	    cmocka_unit_test(a_good_compass_is_not_made_worse),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
