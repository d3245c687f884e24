/* The sky: true states against the broadcast and against geometry computed in inertial space, errors
 * against what was asked for. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/frame.h"
#include "sim/constellation.h"
#include "sim/sky.h"

#define C     299792458.0
#define OMEGA 7.2921151467e-5

enum { ROOM = 4096 };

static fw_ephemeris list[ROOM];
static fw_sky sky;

static const fw_sky_errors no_errors = {
    .orbit_tau_s = 3600,
    .clock_tau_s = 3600,
    .iono_tau_s = 3600,
    .tropo_tau_s = 3600,
    .klobuchar = {{1.0245e-8, 1.4901e-8, -5.9605e-8, -5.9605e-8}, {90112, 32768, -196608, -131072}}};

static fw_time at(double s)
{
	fw_time t = {0};
	assert_int_equal(fw_time_parse("2026-06-10T08:00:00", &t), FW_OK);
	return fw_time_add_ns(t, llround(s * 1e9));
}

static void begin(const fw_sky_errors *errors, unsigned systems, uint64_t seed)
{
	unsigned n = 0;
	assert_int_equal(fw_constellation(at(0), at(7200), systems, ROOM, list, &n), FW_OK);
	assert_int_equal(fw_sky_init(&sky, errors, list, n, at(0), seed), FW_OK);
}

static const double llh[3] = {0.9084, 0.1998, 120};
static const double velocity[3] = {4, -7, 2};

static void position_at(double s, double p[static 3])
{
	assert_int_equal(fw_llh_to_ecef(llh, p), FW_OK);
	for (int i = 0; i < 3; i++)
		p[i] += s * velocity[i];
}

static bool look(unsigned i, double s, fw_sky_view *v)
{
	double p[3];
	position_at(s, p);
	return fw_sky_look(&sky, i, at(s), p, velocity, llh, v);
}

/* The distance in inertial space, that is the frame that coincides with ECEF at reception: the satellite's
 * place at transmission turned by hand, the light time found by bisection. */
static double distance_ago(const fw_ephemeris *e, double s, double ago, const double r[static 3])
{
	fw_satellite_state state;
	assert_true(fw_ephemeris_state(e, at(s - ago), &state) >= 0);
	double angle = -OMEGA * ago, x = state.position_m[0], y = state.position_m[1];
	double d[3] = {x * cos(angle) - y * sin(angle) - r[0], x * sin(angle) + y * cos(angle) - r[1],
	               state.position_m[2] - r[2]};
	return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

static double distance_by_bisection(const fw_ephemeris *e, double s)
{
	double low = 0.05, high = 0.2, r[3];
	position_at(s, r);
	for (int i = 0; i < 60; i++) {
		double middle = (low + high) / 2;
		*(distance_ago(e, s, middle, r) > C * middle ? &low : &high) = middle;
	}
	return C * low;
}

/* Close to toe the true orbit without errors is that of this ephemeris. */
static void test_ranges(void **state)
{
	(void)state;
	begin(&no_errors, 15, 1);
	unsigned checked = 0;
	for (unsigned i = 0; i < sky.n; i++) {
		const fw_sky_satellite *s = &sky.satellite[i];
		for (unsigned k = 0; k < s->n; k++) {
			double t = fw_time_diff_s(s->ephemerides[k].toe, at(0));
			fw_sky_view v;
			fw_satellite_state state_then;
			if (t < 0 || t > 20)
				continue;
			fw_sky_advance(&sky, at(t));
			assert_true(look(i, t, &v));
			assert_true(fabs(v.range_m - distance_by_bisection(&s->ephemerides[k], t)) < 1e-4);
			assert_int_equal(fw_ephemeris_state(&s->ephemerides[k], v.transmitted, &state_then),
			                 FW_OK);
			assert_true(fabs(v.clock_m - C * state_then.clock_s) < 1e-4);
			assert_true(fabs(fw_time_diff_s(at(t), v.transmitted) - v.range_m / C) < 2e-9);
			checked++;
		}
	}
	assert_true(checked > 80); /* GPS and Galileo at 0 s, BeiDou at 14 s */
}

/* The rate is the derivative of the range, errors, nodes and a change of ephemeris on the way included; so
 * is the drift that of the clock. Central differences over a second leave out 1/6 of the third derivative,
 * below 1e-6 m/s. */
static void test_rates(void **state)
{
	(void)state;
	fw_sky_errors errors = no_errors;
	errors.radial_m = errors.along_m = errors.cross_m = errors.clock_m = 2;
	begin(&errors, 15, 2);
	for (double t = 3000.25; t < 3640; t += 63.7) {
		for (unsigned i = 0; i < sky.n; i++) {
			fw_sky_view a, b, c;
			fw_sky_advance(&sky, at(t + 0.5));
			assert_true(look(i, t - 0.5, &a) && look(i, t, &b) && look(i, t + 0.5, &c));
			assert_true(fabs(c.range_m - a.range_m - b.range_rate_mps) < 1e-5);
			assert_true(fabs(c.clock_m - a.clock_m - b.drift_mps) < 1e-5);
		}
	}
}

/* No step anywhere: carrier phases go through nodes and ephemerides without a jump. */
static void test_continuous(void **state)
{
	(void)state;
	begin(&no_errors, 15, 3);
	for (double t = 10; t < 5400; t += 10) {
		for (unsigned i = 0; i < sky.n; i += 7) {
			fw_sky_view before, after;
			fw_sky_advance(&sky, at(t));
			assert_true(look(i, t, &before));
			fw_sky_advance(&sky, at(t + 1e-3));
			assert_true(look(i, t + 1e-3, &after));
			assert_true(fabs(after.range_m - before.range_m - 1e-3 * before.range_rate_mps) <
			            2e-6);
			assert_true(fabs(after.clock_m - before.clock_m - 1e-3 * before.drift_mps) < 2e-6);
		}
	}
}

/* Standard deviations of clock and range errors over satellites and seeds: 2,000 draws, 5 % would be three
 * sigma. */
static void test_error_sizes(void **state)
{
	(void)state;
	fw_sky_errors errors = no_errors;
	double clock = 0, range = 0;
	unsigned n = 0;
	errors.clock_m = 3;
	errors.radial_m = errors.along_m = errors.cross_m =
	    2; /* alike in all directions: 2 m along any line of sight */
	for (uint64_t seed = 0; seed < 40; seed++) {
		begin(&errors, 1U << FW_GPS | 1U << FW_GALILEO, seed);
		fw_sky_advance(&sky, at(5));
		for (unsigned i = 0; i < sky.n; i++, n++) {
			fw_sky_view v;
			fw_satellite_state s;
			const fw_ephemeris *e = fw_sky_broadcast(&sky, i, at(5));
			assert_non_null(e);
			assert_true(look(i, 5, &v));
			assert_int_equal(fw_ephemeris_state(e, v.transmitted, &s), FW_OK);
			clock += pow(v.clock_m - C * s.clock_s, 2);
			range += pow(v.range_m - distance_by_bisection(e, 5), 2);
		}
	}
	assert_true(fabs(sqrt(clock / n) - 3) < 0.2);
	assert_true(fabs(sqrt(range / n) - 2) < 0.15);
}

static void test_broadcast(void **state)
{
	(void)state;
	begin(&no_errors, 15, 4);
	for (double t = 0; t < 7200; t += 333) {
		for (unsigned i = 0; i < sky.n; i++) {
			const fw_ephemeris *e = fw_sky_broadcast(&sky, i, at(t));
			assert_non_null(e);
			double age = fw_time_diff_s(at(t), e->toe);
			switch (sky.satellite[i].satellite.system) {
			case FW_GPS: assert_true(fabs(age) <= 3600); break;
			case FW_GALILEO: assert_true(age >= 0 && age <= 3600); break;
			case FW_BEIDOU: assert_true(fabs(age) <= 1800); break;
			default: assert_true(fabs(age) <= 900); break;
			}
		}
	}
}

/* Without errors the ionosphere is the broadcast model's; the troposphere at the zenith is about 2.4 m near
 * sea level (2.31 m dry, some 0.1 m wet) and grows by 1 / sin(elevation), less near the horizon. */
static void test_delays(void **state)
{
	(void)state;
	begin(&no_errors, 15, 5);
	fw_sky_advance(&sky, at(5));
	for (unsigned i = 0; i < sky.n; i++) {
		fw_sky_view v;
		double iono, tropo, tow_s;
		int week;
		assert_true(look(i, 5, &v));
		if (v.elevation_rad < 0.1)
			continue;
		fw_sky_delays(&sky, i, at(5), &v, llh, &iono, &tropo);
		fw_time_to_gps_s(at(5), &week, &tow_s);
		fw_sight sight = {llh[0], llh[1], v.azimuth_rad, v.elevation_rad, tow_s};
		assert_true(fabs(iono - fw_klobuchar_m(&no_errors.klobuchar, &sight)) < 1e-9);
		assert_true(tropo * sin(v.elevation_rad) > 2.0 && tropo * sin(v.elevation_rad) < 2.6);
	}
}

static void test_seeds(void **state)
{
	(void)state;
	fw_sky_errors errors = no_errors;
	fw_sky_view first, same, other;
	errors.clock_m = 1;
	begin(&errors, 15, 7);
	assert_true(look(3, 1, &first));
	begin(&errors, 15, 7);
	assert_true(look(3, 1, &same));
	begin(&errors, 15, 8);
	assert_true(look(3, 1, &other));
	assert_true(first.clock_m == same.clock_m && first.range_m == same.range_m);
	assert_true(first.clock_m != other.clock_m);
}

/* A satellite whose ephemerides end is out of sight when the last one is no longer meant to be used. */
static void test_end_of_ephemerides(void **state)
{
	(void)state;
	fw_sky_view v;
	unsigned n = 0;
	assert_int_equal(fw_constellation(at(0), at(0), 1U << FW_GLONASS, ROOM, list, &n), FW_OK);
	assert_int_equal(fw_sky_init(&sky, &no_errors, list, n, at(0), 1), FW_OK);
	assert_true(look(0, 1, &v));
	fw_sky_advance(&sky, at(3 * 3600));
	assert_false(look(0, 3 * 3600, &v));
	assert_null(fw_sky_broadcast(&sky, 0, at(3 * 3600)));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_ranges),     cmocka_unit_test(test_rates),
	    cmocka_unit_test(test_continuous), cmocka_unit_test(test_error_sizes),
	    cmocka_unit_test(test_broadcast),  cmocka_unit_test(test_delays),
	    cmocka_unit_test(test_seeds),      cmocka_unit_test(test_end_of_ephemerides),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
