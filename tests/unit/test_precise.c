/* precise: the tables are filled from broadcast ephemerides (which test_ephemeris holds against RTKLIB),
 * so the state between the epochs is known. tests/oracle/test_ephemeris.py compares with RTKLIB's
 * interpolation. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "gnss/precise.h"

static const fw_satellite gps = {FW_GPS, 21}, galileo = {FW_GALILEO, 18}, other = {FW_SBAS, 23};

/* Of 2024-01-01; the Galileo satellite is one with the eccentricity of 0.16 that a launch went wrong for. */
static const fw_ephemeris orbits[] = {
    {.satellite = {FW_GPS, 21},
     .toe = {1388145584000000000},
     .toc = {1388145584000000000},
     .af0_s = 0.0001397891901433,
     .af1_sps = -1.136868377216e-12,
     .kepler = {.sqrt_a = 5153.746572495,
                .ecc = 0.02516158868093,
                .i0 = 0.9616983212695,
                .omega0 = -1.71982612781,
                .omega = -0.6592165095279,
                .m0 = 2.417315396261,
                .delta_n = 4.226247468742e-09,
                .omega_dot = -7.841398054275e-09,
                .idot = -2.642967233051e-11,
                .cuc = 3.950670361519e-06,
                .cus = 7.783994078636e-06,
                .crc = 223.625,
                .crs = 75.25,
                .cic = 2.682209014893e-07,
                .cis = 3.8743019104e-07}},
    {.satellite = {FW_GALILEO, 18},
     .toe = {1388145584000000000},
     .toc = {1388145584000000000},
     .af0_s = 0.0001590164029039,
     .af1_sps = 4.33715285908e-11,
     .kepler = {.sqrt_a = 5289.384557724,
                .ecc = 0.161014210782,
                .i0 = 0.869857558956,
                .omega0 = -2.605589952617,
                .omega = 2.5266668652,
                .m0 = -1.65317115918,
                .delta_n = 4.994850912732e-09,
                .omega_dot = -7.899614764949e-09,
                .idot = -2.928693420408e-10,
                .cuc = 3.281980752945e-06,
                .cus = 1.371093094349e-05,
                .crc = 99.78125,
                .crs = 89.125,
                .cic = -4.570931196213e-06,
                .cis = -4.097819328308e-08}},
};

static fw_precise table;

static fw_time at(double s)
{
	return fw_time_add_ns(orbits[0].toe, llround(s * 1e9));
}

static fw_satellite_state truth(int i, fw_time t)
{
	fw_satellite_state s;

	assert_true(fw_ephemeris_state(&orbits[i], t, &s) >= 0);
	return s;
}

/* An epoch of both satellites. The clock is put in as the files have it, without the periodic relativistic
 * effect. */
static void add_epoch(double s)
{
	for (int i = 0; i < 2; i++) {
		const fw_satellite_state state = truth(i, at(s));

		assert_int_equal(
		    fw_precise_add_position(&table, at(s), orbits[i].satellite, state.position_m), FW_OK);
		assert_int_equal(fw_precise_add_clock(&table, at(s), orbits[i].satellite,
		                                      orbits[i].af0_s + s * orbits[i].af1_sps),
		                 FW_OK);
	}
}

static void fill(double from, double to, double step)
{
	fw_precise_init(&table);
	for (double s = from; s <= to; s += step)
		add_epoch(s);
}

static double distance(const double a[static 3], const double b[static 3])
{
	return sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
}

/* The periodic effect as SP3 wants it to be added. The broadcast form, e sin E of mean elements, differs from
 * it by the harmonic corrections of the orbit: some 0.03 ns. */
static double relativity(const fw_satellite_state *s)
{
	const double *p = s->position_m, *v = s->velocity_mps;

	return -2 * (p[0] * v[0] + p[1] * v[1] + p[2] * v[2]) / (299792458.0 * 299792458.0);
}

/* What a state is off, in m, m/s, s and s/s. */
static void assert_near(int i, double s, fw_status expected, double m, double mps)
{
	const fw_satellite_state right = truth(i, at(s));
	fw_satellite_state found;

	assert_int_equal(fw_precise_state(&table, orbits[i].satellite, at(s), &found), expected);
	if (!(distance(found.position_m, right.position_m) < m) ||
	    !(distance(found.velocity_mps, right.velocity_mps) < mps))
		fail_msg("satellite %d at %g s: %g m, %g m/s off", i, s,
		         distance(found.position_m, right.position_m),
		         distance(found.velocity_mps, right.velocity_mps));
	assert_true(fabs(found.clock_s - orbits[i].af0_s - s * orbits[i].af1_sps - relativity(&right)) <
	            1e-14 + m / 1e12);
	assert_true(fabs(found.clock_s - right.clock_s) < 5e-11);
	assert_true(fabs(found.drift_sps - right.drift_sps) < 2e-14);
}

static void states_between_epochs_are_right(void **state)
{
	(void)state;
	fill(-5400, 5400, 900);
	for (double s = -899; s <= 1800; s += 61.7)
		assert_near(0, s, FW_OK, 1e-3, 1e-5);
	fill(-2100, 2100, 300);
	for (double s = -599; s <= 900; s += 17.3)
		for (int i = 0; i < 2; i++)
			assert_near(i, s, FW_OK, 1e-6, 1e-7);
	assert_near(0, 300, FW_OK, 1e-7, 1e-7);
}

/* Beyond the middle of the epochs the polynomial swings. */
static void ends_of_the_tables_are_dubious(void **state)
{
	(void)state;
	fill(-4500, 4500, 900);
	assert_near(0, 1, FW_OK, 1e-3, 1e-5);
	assert_near(0, 900, FW_OK, 1e-3, 1e-5);
	assert_near(0, -1, FW_DUBIOUS, 1e-3, 1e-5);
	assert_near(0, 901, FW_DUBIOUS, 1e-3, 1e-5);
	assert_near(0, -4450, FW_DUBIOUS, 0.1, 1e-3);
	assert_near(0, 4450, FW_DUBIOUS, 0.1, 1e-3);
}

/* Up to 900 s outside; the clock then stays as it was. */
static void outside_the_tables_there_is_little(void **state)
{
	fw_satellite_state found = {.clock_s = 7};

	(void)state;
	fill(-4500, 4500, 900);
	assert_int_equal(fw_precise_state(&table, gps, at(5400), &found), FW_DUBIOUS);
	assert_true(distance(found.position_m, truth(0, at(5400)).position_m) < 10);
	assert_true(fabs(found.clock_s - truth(0, at(5400)).clock_s) < 2e-9);
	assert_int_equal(fw_precise_state(&table, gps, at(-5400), &found), FW_DUBIOUS);
	found.clock_s = 7;
	assert_int_equal(fw_precise_state(&table, gps, at(5400.1), &found), FW_ERANGE);
	assert_int_equal(fw_precise_state(&table, gps, at(-5400.1), &found), FW_ERANGE);
	assert_true(found.clock_s == 7);
}

static void too_little_gives_no_state(void **state)
{
	fw_satellite_state found = {.clock_s = 7};

	(void)state;
	fw_precise_init(&table);
	assert_int_equal(fw_precise_state(&table, gps, at(0), &found), FW_ERANGE);
	fill(-4500, 3600, 900); /* ten epochs */
	assert_int_equal(fw_precise_state(&table, gps, at(10), &found), FW_ERANGE);
	add_epoch(4500);
	assert_int_equal(fw_precise_state(&table, gps, at(10), &found), FW_OK);
	found.clock_s = 7;
	assert_int_equal(fw_precise_state(&table, other, at(0), &found), FW_EUNKNOWN);
	assert_int_equal(fw_precise_state(&table, (fw_satellite){200, 1}, at(0), &found), FW_EUNKNOWN);
	assert_true(found.clock_s == 7);
}

static void gaps_are_not_bridged(void **state)
{
	fw_satellite_state found;

	(void)state;
	fill(-5400, -900, 900);
	for (double s = 900; s <= 7200; s += 900) /* the epoch at 0 is missing */
		add_epoch(s);
	assert_int_equal(fw_precise_state(&table, gps, at(950), &found), FW_ERANGE);

	fw_precise_init(&table); /* one satellite is missing once */
	for (double s = -5400; s <= 5400; s += 900) {
		if (s == 1800)
			assert_int_equal(
			    fw_precise_add_position(&table, at(s), gps, truth(0, at(s)).position_m), FW_OK);
		else
			add_epoch(s);
	}
	assert_int_equal(fw_precise_state(&table, gps, at(10), &found), FW_OK);
	assert_int_equal(fw_precise_state(&table, galileo, at(10), &found), FW_EUNKNOWN);
}

/* Clocks come in steps of 30 s; a satellite that is missing for a while is interpolated across, up to 900
 * s. */
static void clocks_are_linear_between_what_there_is(void **state)
{
	fw_satellite_state found;
	const fw_satellite_state right = truth(0, at(10));

	(void)state;
	fill(-4500, 4500, 900);
	table.clocks.n = 0;
	assert_int_equal(fw_precise_state(&table, gps, at(10), &found), FW_EUNKNOWN);
	assert_int_equal(fw_precise_add_clock(&table, at(-30), gps, 1e-6), FW_OK);
	assert_int_equal(fw_precise_add_clock(&table, at(0), galileo, 5e-6), FW_OK);
	assert_int_equal(fw_precise_add_clock(&table, at(30), galileo, 5e-6), FW_OK);
	assert_int_equal(fw_precise_state(&table, gps, at(10), &found), FW_DUBIOUS);
	assert_int_equal(fw_precise_add_clock(&table, at(50), gps, 9e-6), FW_OK);
	assert_int_equal(fw_precise_state(&table, gps, at(10), &found), FW_OK);
	assert_true(fabs(found.clock_s - 5e-6 - relativity(&right)) < 1e-14);
	assert_true(fabs(found.drift_sps - 1e-7 - (right.drift_sps - orbits[0].af1_sps)) < 2e-14);
}

static void what_is_no_number_is_not_taken(void **state)
{
	const double position[3] = {2e7, NAN, 0}, infinite[3] = {2e7, 0, -INFINITY};

	(void)state;
	fill(-4500, 4500, 900);
	assert_int_equal(fw_precise_add_position(&table, at(5400), gps, position), FW_ENONFINITE);
	assert_int_equal(fw_precise_add_position(&table, at(5400), gps, infinite), FW_ENONFINITE);
	assert_int_equal(fw_precise_add_clock(&table, at(5400), gps, NAN), FW_ENONFINITE);
	assert_int_equal(fw_precise_add_clock(&table, at(4400), gps, 0), FW_EINVAL);
	assert_int_equal(fw_precise_add_position(&table, at(4400), gps, truth(0, at(0)).position_m),
	                 FW_EINVAL);
	assert_int_equal(fw_precise_add_clock(&table, at(5400), (fw_satellite){FW_SYSTEM_COUNT, 1}, 0),
	                 FW_EINVAL);
	assert_int_equal(table.orbits.n, 11);
	assert_int_equal(table.clocks.n, 11);
}

static void finite_numbers_that_overflow_give_no_state(void **state)
{
	fw_satellite_state found = {.clock_s = 7};

	(void)state;
	fw_precise_init(&table);
	for (double s = -4500; s <= 4500; s += 900) {
		const double sign = fmod(s, 1800) == 0 ? 1 : -1, position[3] = {sign * 1e308, 0, 0};

		assert_int_equal(fw_precise_add_position(&table, at(s), gps, position), FW_OK);
		assert_int_equal(fw_precise_add_clock(&table, at(s), gps, sign * 1e308), FW_OK);
	}
	assert_int_equal(fw_precise_state(&table, gps, at(100), &found), FW_ENONFINITE);
	assert_true(found.clock_s == 7);
}

static void a_later_file_replaces_midnight(void **state)
{
	fw_satellite_state found;

	(void)state;
	fill(-4500, 4500, 900);
	assert_int_equal(fw_precise_add_clock(&table, at(4500), gps, 1e-3), FW_OK);
	assert_int_equal(table.clocks.n, 11);
	assert_int_equal(fw_precise_state(&table, gps, at(4500), &found), FW_DUBIOUS);
	assert_true(fabs(found.clock_s - 1e-3) < 1e-6);
}

/* Reading on demand: at every time the state is as good as with the whole file, and no more is read than need
 * be. */
static void windows_slide(void **state)
{
	const double begin = -12600, end = 12600;
	double next = begin, next_clock = begin;

	(void)state;
	fw_precise_init(&table);
	for (double t = -7000; t < 7000; t += 123.4) {
		fw_satellite_state found;

		while (fw_precise_wants_orbits(&table, at(t)) && next <= end) {
			assert_int_equal(
			    fw_precise_add_position(&table, at(next), gps, truth(0, at(next)).position_m),
			    FW_OK);
			next += 900;
		}
		while (fw_precise_wants_clocks(&table, at(t)) && next_clock <= end) {
			assert_int_equal(
			    fw_precise_add_clock(&table, at(next_clock), gps, next_clock * 1e-12), FW_OK);
			next_clock += 30;
		}
		assert_int_equal(fw_precise_state(&table, gps, at(t), &found), FW_OK);
		assert_true(distance(found.position_m, truth(0, at(t)).position_m) < 1e-3);
		assert_true(next <= t + 7 * 900);
		assert_true(next_clock <= t + 90);

		/* A satellite is asked for at the time of transmission, which is earlier. */
		assert_int_equal(fw_precise_state(&table, gps, at(t - 0.1), &found), FW_OK);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(states_between_epochs_are_right),
	    cmocka_unit_test(ends_of_the_tables_are_dubious),
	    cmocka_unit_test(outside_the_tables_there_is_little),
	    cmocka_unit_test(too_little_gives_no_state),
	    cmocka_unit_test(gaps_are_not_bridged),
	    cmocka_unit_test(clocks_are_linear_between_what_there_is),
	    cmocka_unit_test(what_is_no_number_is_not_taken),
	    cmocka_unit_test(finite_numbers_that_overflow_give_no_state),
	    cmocka_unit_test(a_later_file_replaces_midnight),
	    cmocka_unit_test(windows_slide),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
