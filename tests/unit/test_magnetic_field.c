/* magnetic_field: against values of the World Magnetic Model that PyPI's pygeomag 1.1.0 computes. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>

#include "base/frame.h"
#include "ins/magnetic_field.h"

/* The moment of a decimal year that begins a year or halves it. */
static fw_time moment(double year)
{
	bool half = year != floor(year);
	fw_civil c = {.year = (int)year, .month = half ? 7 : 1, .day = half ? 2 : 1, .hour = half ? 12 : 0};
	fw_time t;

	assert_int_equal(fw_time_from_civil(&c, &t), FW_OK);
	return t;
}

static void field_of(double lat_deg, double lon_deg, double height_m, double year, double field[3])
{
	double llh[3] = {fw_rad_from_deg(lat_deg), fw_rad_from_deg(lon_deg), height_m};

	assert_int_equal(fw_magnetic_field(llh, moment(year), field), FW_OK);
}

static void field_is_that_of_pygeomag(void **state)
{
	static const struct {
		double lat_deg, lon_deg, height_m, year;
		double north, east, down, total; /* nT */
		double declination_deg, inclination_deg;
	} cases[] = {
	    {80, 0, 0, 2025.0, 6521.6, 145.9, 54791.5, 55178.5, 1.28, 83.21},
	    {0, 120, 0, 2025.0, 39677.8, -109.6, -10580.2, 41064.3, -0.16, -14.93},
	    {-80, 240, 0, 2025.0, 6117.5, 15751.9, -52022.5, 54698.2, 68.78, -72.00},
	    {80, 0, 100e3, 2025.0, 6216.0, 92.4, 52598.8, 52964.9, 0.85, 83.26},
	    {80, 0, 0, 2027.5, 6500.8, 294.5, 54869.4, 55253.9, 2.59, 83.24},
	    {37.4, -5.9, 50, 2025.5, 27411.2, -52.1, 33959.9, 43642.4, -0.11, 51.09},
	};

	(void)state;
	for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
		double f[3], flat;

		field_of(cases[i].lat_deg, cases[i].lon_deg, cases[i].height_m, cases[i].year, f);
		flat = hypot(f[0], f[1]);
		assert_true(fabs(f[0] - cases[i].north) < 0.06);
		assert_true(fabs(f[1] - cases[i].east) < 0.06);
		assert_true(fabs(f[2] - cases[i].down) < 0.06);
		assert_true(fabs(hypot(flat, f[2]) - cases[i].total) < 0.06);
		assert_true(fabs(fw_deg_from_rad(atan2(f[1], f[0])) - cases[i].declination_deg) < 0.006);
		assert_true(fabs(fw_deg_from_rad(atan2(f[2], flat)) - cases[i].inclination_deg) < 0.006);
	}
}

/* 11 mm from a pole the field is that at the pole. */
static void field_is_smooth_at_the_poles(void **state)
{
	double at_pole[3], near_pole[3];

	(void)state;
	for (int side = -1; side <= 1; side += 2) {
		for (double lon = -170; lon < 180; lon += 50) {
			field_of(90 * side, lon, 0, 2026, at_pole);
			field_of((90 - 1e-7) * side, lon, 0, 2026, near_pole);
			for (int i = 0; i < 3; i++)
				assert_true(fabs(at_pole[i] - near_pole[i]) < 1e-2);
		}
	}
}

static void years_outside_the_model_are_dubious(void **state)
{
	double llh[3] = {0.6, 0.1, 100}, f[3];

	(void)state;
	assert_int_equal(fw_magnetic_field(llh, moment(2024.5), f), FW_DUBIOUS);
	assert_int_equal(fw_magnetic_field(llh, moment(2029.5), f), FW_OK);
	assert_int_equal(fw_magnetic_field(llh, moment(2030), f), FW_DUBIOUS);
}

static void nonsense_is_refused(void **state)
{
	static const struct {
		double llh[3];
		fw_status status;
	} cases[] = {
	    {{NAN, 0, 0}, FW_ENONFINITE}, {{0, INFINITY, 0}, FW_ENONFINITE}, {{1.6, 0, 0}, FW_ERANGE},
	    {{0, 0, 2e6}, FW_ERANGE},     {{0, 0, -2e4}, FW_ERANGE},
	};
	double f[3] = {1, 2, 3};

	(void)state;
	for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
		assert_int_equal(fw_magnetic_field(cases[i].llh, moment(2026), f), cases[i].status);
	assert_int_equal(fw_magnetic_field(cases[2].llh, (fw_time){-1}, f), FW_ERANGE);
	assert_true(f[0] == 1 && f[1] == 2 && f[2] == 3);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(field_is_that_of_pygeomag),
	    cmocka_unit_test(field_is_smooth_at_the_poles),
	    cmocka_unit_test(years_outside_the_model_are_dubious),
	    cmocka_unit_test(nonsense_is_refused),
	};

	return cmocka_run_group_tests_name("magnetic_field", tests, NULL, NULL);
}
