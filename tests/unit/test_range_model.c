/* Expected values: light time solved here by iteration with the whole rotation, derivatives by differences. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "gnss/range_model.h"

static const double receiver[3] = {4027893.7, 307045.8, 4919474.9};
static const double satellite[3] = {15600000.0, 7540000.0, 20140000.0};
static const double velocity[3] = {-2300.0, 1900.0, 1100.0};

static void near(double got, double expected, double tolerance)
{
	if (!(fabs(got - expected) <= tolerance))
		fail_msg("%.12g is not %.12g within %g", got, expected, tolerance);
}

static double length(const double d[3])
{
	return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* The distance that a signal travels which arrives at time t (from some zero) and was sent by a satellite in straight
 * motion; the satellite's position is that in the frame that turns with the Earth. */
static double light_path_m(const double r[3], double t)
{
	double path = 2e7;
	for (int i = 0; i < 20; i++) {
		const double travel = path / FW_SPEED_OF_LIGHT_MPS, turn = FW_EARTH_RATE_RADPS * travel;
		double s[3];
		for (int k = 0; k < 3; k++)
			s[k] = satellite[k] + velocity[k] * (t - travel + 0.075);
		const double d[3] = {cos(turn) * s[0] + sin(turn) * s[1] - r[0],
		                     cos(turn) * s[1] - sin(turn) * s[0] - r[1], s[2] - r[2]};
		path = length(d);
	}
	return path;
}

/* Where that satellite was when it sent what arrives at t = 0. */
static void position_when_sent(const double r[3], double s[3])
{
	const double travel = light_path_m(r, 0) / FW_SPEED_OF_LIGHT_MPS;
	for (int k = 0; k < 3; k++)
		s[k] = satellite[k] + velocity[k] * (0.075 - travel);
}

static void distance_has_the_turn_of_the_earth(void **state)
{
	(void)state;
	double s[3];
	fw_line_of_sight line;
	position_when_sent(receiver, s);
	fw_range_line(receiver, s, NULL, &line);
	near(line.distance_m, light_path_m(receiver, 0), 1e-7);
	near(length(line.unit), 1, 1e-14);
	assert_true(line.rate_mps == 0);
}

static void unit_vector_is_the_derivative(void **state)
{
	(void)state;
	double s[3];
	fw_line_of_sight line, plus, minus;
	position_when_sent(receiver, s);
	fw_range_line(receiver, s, NULL, &line);
	for (int k = 0; k < 3; k++) {
		double a[3], b[3];
		memcpy(a, receiver, sizeof a);
		memcpy(b, receiver, sizeof b);
		a[k] += 10;
		b[k] -= 10;
		fw_range_line(a, s, NULL, &plus);
		fw_range_line(b, s, NULL, &minus);
		/* the turn changes with the distance: some 1e-6 */
		near((plus.distance_m - minus.distance_m) / 20, -line.unit[k], 3e-6);
	}
}

static void rate_is_the_derivative_in_time(void **state)
{
	(void)state;
	double s[3];
	fw_line_of_sight line;
	position_when_sent(receiver, s);
	fw_range_line(receiver, s, velocity, &line);
	near(line.rate_mps, (light_path_m(receiver, 0.5) - light_path_m(receiver, -0.5)) / 1, 1e-5);
}

/* ---- ranges of an epoch ---- */

static fw_ephemeris stored;
static fw_nav_message asked_for;

static const fw_ephemeris *find(void *context, fw_satellite s, fw_nav_message wanted, fw_time t)
{
	(void)context;
	(void)t;
	asked_for = wanted;
	return fw_satellite_equal(s, stored.satellite) ? &stored : NULL;
}

static const fw_ephemeris_source source = {find, NULL, NULL};
static const fw_time tag = {1400000000LL * FW_NS_PER_S};

static fw_ephemeris make_ephemeris(uint8_t system, fw_nav_message message)
{
	fw_ephemeris e = {.satellite = {system, 11},
	                  .message = message,
	                  .toe = tag,
	                  .toc = tag,
	                  .healthy = true,
	                  .af0_s = 1e-4,
	                  .tgd_s = {5e-9, 7e-9}};
	e.kepler.sqrt_a = 5440.6;
	e.kepler.ecc = 0.0003;
	e.kepler.i0 = 0.97;
	e.kepler.m0 = 1.1;
	return e;
}

static fw_observation code(uint8_t system, char band, char attribute, double code_m)
{
	return (fw_observation){.satellite = {system, 11},
	                        .signal = {band, attribute},
	                        .glonass_channel = INT8_MIN,
	                        .has = FW_HAS_CODE,
	                        .code_m = code_m};
}

/* What one satellite's observations become. Returns the number of ranges. */
static unsigned prepare(const fw_observation *obs, unsigned n, unsigned bands, fw_range *range)
{
	static fw_epoch epoch;
	static fw_range ranges[FW_RANGE_MAX];
	unsigned found;
	epoch.time = tag;
	epoch.n = n;
	memcpy(epoch.obs, obs, n * sizeof obs[0]);
	assert_int_equal(fw_range_prepare(&epoch, &source, &fw_signals_default, ~0U, bands, ranges, &found),
	                 FW_OK);
	*range = ranges[0];
	return found;
}

static void clocks_and_group_delays_are_taken_out(void **state)
{
	(void)state;
	fw_range r;
	fw_satellite_state at;
	const fw_observation obs[] = {code(FW_GALILEO, '1', 'C', 23e6), code(FW_GALILEO, '5', 'Q', 23e6 + 4)};
	stored = make_ephemeris(FW_GALILEO, FW_NAV_FNAV);
	assert_int_equal(prepare(obs, 2, 2, &r), 1);
	assert_int_equal(asked_for, FW_NAV_FNAV);
	assert_int_equal(r.n_codes, 2);
	/* the clock of F/NAV is that of the pair: BGD on E1, (f_E1 / f_E5a)^2 BGD on E5a */
	const double travel = 23e6 / FW_SPEED_OF_LIGHT_MPS, c = FW_SPEED_OF_LIGHT_MPS;
	assert_int_equal(
	    fw_ephemeris_state(&stored, fw_time_add_ns(tag, -llround((travel + 1e-4) * 1e9)), &at), FW_OK);
	near(r.code[0].code_m, 23e6 + c * (at.clock_s - 5e-9), 1e-7);
	near(r.code[1].code_m, 23e6 + 4 + c * (at.clock_s - 5e-9 * pow(1575.42 / 1176.45, 2)), 1e-7);
	near(r.code[1].iono_scale, pow(1575.42 / 1176.45, 2), 1e-12);
	/* the instant is exact below a nanosecond, in which a satellite moves 3 micrometres */
	for (int i = 0; i < 3; i++)
		near(r.position_m[i], at.position_m[i], 3e-6);
}

static void preferred_signals_come_first(void **state)
{
	(void)state;
	fw_range r;
	const fw_observation obs[] = {code(FW_GPS, '5', 'Q', 23e6), code(FW_GPS, '2', 'W', 23e6),
	                              code(FW_GPS, '2', 'L', 23e6), code(FW_GPS, '1', 'W', 23e6),
	                              code(FW_GPS, '1', 'C', 23e6)};
	stored = make_ephemeris(FW_GPS, FW_NAV_LNAV);
	assert_int_equal(prepare(obs, 5, 1, &r), 1);
	assert_int_equal(r.n_codes, 1);
	assert_memory_equal(&r.code[0].signal, "1C", 2);
	/* L5 would be third, but LNAV says nothing of its group delay */
	assert_int_equal(prepare(obs, 5, 3, &r), 1);
	assert_int_equal(r.n_codes, 2);
	assert_memory_equal(&r.code[1].signal, "2L", 2);
	/* without L2 it is better than nothing */
	const fw_observation pair[] = {obs[0], obs[4]};
	assert_int_equal(prepare(pair, 2, 3, &r), 1);
	assert_int_equal(r.n_codes, 2);
	assert_false(r.code[1].delay_known);
}

static void satellites_without_code_or_ephemeris_are_left_out(void **state)
{
	(void)state;
	fw_range r;
	fw_observation o = code(FW_GPS, '1', 'C', 23e6);
	stored = make_ephemeris(FW_GPS, FW_NAV_LNAV);
	o.has = FW_HAS_DOPPLER;
	assert_int_equal(prepare(&o, 1, 1, &r), 0);
	o = code(FW_GPS, '1', 'C', NAN);
	assert_int_equal(prepare(&o, 1, 1, &r), 0);
	o = code(FW_GALILEO, '1', 'C', 23e6);
	assert_int_equal(prepare(&o, 1, 1, &r), 0);
	stored.toe.ns += 86400 * FW_NS_PER_S;
	o = code(FW_GPS, '1', 'C', 23e6);
	assert_int_equal(prepare(&o, 1, 1, &r), 0);
}

static void doppler_becomes_a_rate(void **state)
{
	(void)state;
	fw_range r;
	fw_observation obs[] = {code(FW_GPS, '1', 'C', 23e6), code(FW_GPS, '2', 'L', 23e6)};
	stored = make_ephemeris(FW_GPS, FW_NAV_LNAV);
	stored.af1_sps = 1e-11;
	stored.kepler.ecc = 0; /* no relativity in the drift */
	obs[1].has |= FW_HAS_DOPPLER;
	obs[1].doppler_hz = 1000;
	assert_int_equal(prepare(obs, 2, 1, &r), 1);
	assert_true(r.has_rate);
	near(r.rate_mps, FW_SPEED_OF_LIGHT_MPS * (1e-11 - 1000 / 1227.60e6), 1e-6);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(distance_has_the_turn_of_the_earth),
	    cmocka_unit_test(unit_vector_is_the_derivative),
	    cmocka_unit_test(rate_is_the_derivative_in_time),
	    cmocka_unit_test(clocks_and_group_delays_are_taken_out),
	    cmocka_unit_test(preferred_signals_come_first),
	    cmocka_unit_test(satellites_without_code_or_ephemeris_are_left_out),
	    cmocka_unit_test(doppler_becomes_a_rate),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
