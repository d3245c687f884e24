/* The built-in constellations: orbits as the systems publish them, ephemerides that fit together and on the
 * wire. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "sim/constellation.h"

enum { ROOM = 4096 };

static fw_ephemeris made[ROOM], again[ROOM];

static fw_time start(void)
{
	fw_time t = {0};
	assert_int_equal(fw_time_parse("2026-06-10T08:00:00", &t), FW_OK);
	return t;
}

static unsigned make(unsigned systems, int seconds, fw_ephemeris *to)
{
	unsigned n = 0;
	fw_time from = start();
	assert_int_equal(
	    fw_constellation(from, fw_time_add_ns(from, seconds * FW_NS_PER_S), systems, ROOM, to, &n),
	    FW_OK);
	return n;
}

static unsigned satellites(const fw_ephemeris *e, unsigned n)
{
	unsigned count = 0;
	for (unsigned i = 0; i < n; i++)
		count += i == 0 || !fw_satellite_equal(e[i].satellite, e[i - 1].satellite);
	return count;
}

static double radius(const fw_satellite_state *s)
{
	const double *p = s->position_m;
	return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
}

/* As many as the systems' performance standards have; radii from there too, eccentricities allow for 2 %. */
static void test_orbits(void **state)
{
	(void)state;
	static const struct {
		fw_system system;
		unsigned n;
		double radius_m, most_z;
	} systems[] = {
	    {FW_GPS, 31, 26560e3, 0.83}, {FW_GALILEO, 24, 29600e3, 0.84}, {FW_GLONASS, 24, 25510e3, 0.92}};
	for (int k = 0; k < 3; k++) {
		unsigned n = make(1U << systems[k].system, 3600, made);
		assert_int_equal(satellites(made, n), systems[k].n);
		for (unsigned i = 0; i < n; i++) {
			fw_satellite_state s;
			assert_int_equal(fw_ephemeris_state(&made[i], made[i].toe, &s), FW_OK);
			assert_true(fabs(radius(&s) / systems[k].radius_m - 1) < 0.02);
			assert_true(fabs(s.position_m[2]) < systems[k].most_z * radius(&s));
			assert_true(fabs(s.clock_s) < 1e-3);
		}
	}
	assert_int_equal(satellites(made, make(1U << FW_BEIDOU, 3600, made)), 24 + 3 + 5);
}

/* What two ephemerides in a row say about the moment between them differs by their rounding: a few
 * decimetres for GLONASS, whose coordinates are broadcast in steps of 0.49 m, a few centimetres for the
 * others. */
static void test_neighbours_agree(void **state)
{
	(void)state;
	unsigned n = make(15, 7200, made);
	for (unsigned i = 1; i < n; i++) {
		fw_satellite_state a, b;
		if (!fw_satellite_equal(made[i].satellite, made[i - 1].satellite))
			continue;
		fw_time middle = {(made[i].toe.ns + made[i - 1].toe.ns) / 2};
		assert_true(made[i].toe.ns > made[i - 1].toe.ns);
		assert_int_equal(fw_ephemeris_state(&made[i - 1], middle, &a), FW_OK);
		assert_int_equal(fw_ephemeris_state(&made[i], middle, &b), FW_OK);
		double limit = made[i].satellite.system == FW_GLONASS ? 5 : 0.3;
		for (int k = 0; k < 3; k++)
			assert_true(fabs(a.position_m[k] - b.position_m[k]) < limit);
		assert_true(fabs(a.clock_s - b.clock_s) < 1e-13); /* relativity: the rounding of the orbit */
	}
}

/* BeiDou's geostationary satellites stand where the performance standard has them. */
static void test_geostationary(void **state)
{
	(void)state;
	static const double places[] = {140, 80, 110.5, 160, 58.75};
	unsigned n = make(1U << FW_BEIDOU, 3600, made);
	int seen = 0;
	for (unsigned i = 0; i < n; i++) {
		fw_satellite_state s;
		if (made[i].satellite.number > 5)
			continue;
		for (int quarter = -4; quarter <= 4; quarter++) {
			fw_time t = fw_time_add_ns(made[i].toe, quarter * 900 * FW_NS_PER_S);
			assert_int_equal(fw_ephemeris_state(&made[i], t, &s), FW_OK);
			double longitude = atan2(s.position_m[1], s.position_m[0]) * 57.29577951308232;
			assert_true(fabs(longitude - places[made[i].satellite.number - 1]) < 0.1);
			assert_true(fabs(s.position_m[2]) < 50e3);
			seen++;
		}
	}
	assert_true(seen >= 5 * 9);
}

/* IS-GPS-200N tables 20-I and 20-III: the steps in which a GPS satellite sends these, all of which a float
 * holds. */
static void test_quantised(void **state)
{
	(void)state;
	unsigned n = make(1U << FW_GPS, 3600, made);
	for (unsigned i = 0; i < n; i++) {
		const fw_ephemeris *e = &made[i];
		double af0 = ldexp(e->af0_s, 31), m0 = ldexp(e->kepler.m0 / 3.1415926535898, 31);
		double sqrt_a = ldexp(e->kepler.sqrt_a, 19), crs = ldexp(e->kepler.crs, 5);
		double af1 = ldexp(e->af1_sps, 43);
		assert_true(af0 == nearbyint(af0) && fabs(af0) < 2097152);
		assert_true(af1 == nearbyint(af1) && fabs(af1) < 32768);
		assert_true(fabs(m0 - nearbyint(m0)) < 1e-5 && fabs(m0) <= 2147483648.0);
		assert_true(sqrt_a == nearbyint(sqrt_a));
		assert_true(crs == nearbyint(crs) && fabs(crs) < 32768);
		assert_true((double)(float)e->af0_s == e->af0_s && (double)(float)e->tgd_s[0] == e->tgd_s[0]);
		assert_true((double)(float)e->kepler.cuc == e->kepler.cuc);
	}
}

static void test_same_again(void **state)
{
	(void)state;
	unsigned n = make(15, 3600, made);
	assert_int_equal(make(15, 3600, again), n);
	for (unsigned i = 0; i < n; i++)
		assert_true(made[i].af0_s == again[i].af0_s && made[i].kepler.m0 == again[i].kepler.m0);
}

static void test_refusals(void **state)
{
	(void)state;
	unsigned n = 77;
	fw_time from = start();
	assert_int_equal(fw_constellation(from, fw_time_add_ns(from, -1), 15, ROOM, made, &n), FW_EINVAL);
	assert_int_equal(fw_constellation(from, from, 15, 10, made, &n), FW_ENOSPACE);
	assert_int_equal(n, 77);
	assert_int_equal(fw_constellation(from, from, 0, 0, made, &n), FW_OK);
	assert_int_equal(n, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_orbits),        cmocka_unit_test(test_neighbours_agree),
	    cmocka_unit_test(test_geostationary), cmocka_unit_test(test_quantised),
	    cmocka_unit_test(test_same_again),    cmocka_unit_test(test_refusals),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
