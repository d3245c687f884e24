/* Masks and faults: which satellites, which directions, when. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "sim/fault.h"

#define DEG 0.017453292519943295

static const fw_satellite G05 = {FW_GPS, 5}, E05 = {FW_GALILEO, 5};

static fw_mask everywhere(void)
{
	fw_mask m = {.window = {10, 20},
	             .stations = FW_STATION_ROVER,
	             .below_rad = 90 * DEG,
	             .attenuation_db = INFINITY};
	for (int i = 0; i < FW_SYSTEM_COUNT; i++)
		m.satellites.bits[i] = UINT64_MAX;
	return m;
}

static double attenuation(const fw_mask *m, double t_s, fw_satellite s, double azimuth, double elevation)
{
	return fw_masks_attenuation_db(m, 1, NULL, FW_STATION_ROVER, t_s, s, azimuth * DEG, elevation * DEG);
}

static void test_window(void **state)
{
	(void)state;
	fw_mask m = everywhere();
	assert_true(attenuation(&m, 9.999, G05, 0, 45) == 0);
	assert_true(isinf(attenuation(&m, 10, G05, 0, 45)));
	assert_true(isinf(attenuation(&m, 19.999, G05, 0, 45)));
	assert_true(attenuation(&m, 20, G05, 0, 45) == 0);
	assert_true(attenuation(&m, NAN, G05, 0, 45) == 0);
}

static void test_station(void **state)
{
	(void)state;
	fw_mask m = everywhere();
	m.stations = FW_STATION_BASE;
	assert_true(attenuation(&m, 15, G05, 0, 45) == 0);
}

/* A sector from 300 over north to 60 degrees. */
static void test_sector(void **state)
{
	(void)state;
	fw_mask m = everywhere();
	m.azimuth_from_rad = 300 * DEG;
	m.azimuth_to_rad = 60 * DEG;
	assert_true(isinf(attenuation(&m, 15, G05, 0, 45)));
	assert_true(isinf(attenuation(&m, 15, G05, 301, 45)));
	assert_true(isinf(attenuation(&m, 15, G05, 59, 45)));
	assert_true(attenuation(&m, 15, G05, 61, 45) == 0);
	assert_true(attenuation(&m, 15, G05, 180, 45) == 0);
	assert_true(attenuation(&m, 15, G05, 299, 45) == 0);
}

static void test_elevation_and_satellites(void **state)
{
	(void)state;
	fw_mask m = everywhere();
	m.below_rad = 30 * DEG;
	m.attenuation_db = 12;
	m.satellites = (fw_satellite_set){{[FW_GPS] = UINT64_C(1) << 5}};
	assert_true(attenuation(&m, 15, G05, 0, 29) == 12);
	assert_true(attenuation(&m, 15, G05, 0, 31) == 0);
	assert_true(attenuation(&m, 15, E05, 0, 29) == 0);
}

/* Two masks add up; what one of them keeps is still dimmed by the other. */
static void test_two_masks(void **state)
{
	(void)state;
	fw_mask m[2] = {everywhere(), everywhere()};
	fw_satellite_set kept[2] = {{{[FW_GPS] = UINT64_C(1) << 5}}, {{0}}};
	m[0].keep = 1;
	m[1].attenuation_db = 6;
	assert_true(fw_masks_attenuation_db(m, 2, kept, FW_STATION_ROVER, 15, G05, 0, 1) == 6);
	assert_true(isinf(fw_masks_attenuation_db(m, 2, kept, FW_STATION_ROVER, 15, E05, 0, 1)));
}

static void test_faults_hold(void **state)
{
	(void)state;
	fw_fault f[] = {{.kind = FW_FAULT_NO_PVT, .window = {5, 6}, .stations = FW_STATION_ROVER},
	                {.kind = FW_FAULT_SILENCE, .window = {7, 8}, .stations = FW_STATION_BASE}};
	assert_true(fw_faults_hold(f, 2, FW_FAULT_NO_PVT, FW_STATION_ROVER, 5.5));
	assert_false(fw_faults_hold(f, 2, FW_FAULT_NO_PVT, FW_STATION_ROVER, 6));
	assert_false(fw_faults_hold(f, 2, FW_FAULT_NO_PVT, FW_STATION_BASE, 5.5));
	assert_true(fw_faults_hold(f, 2, FW_FAULT_SILENCE, FW_STATION_BASE, 7));
	assert_false(fw_faults_hold(f, 2, FW_FAULT_NO_ATTITUDE, FW_STATION_ROVER, 5.5));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_window),    cmocka_unit_test(test_station),
	    cmocka_unit_test(test_sector),    cmocka_unit_test(test_elevation_and_satellites),
	    cmocka_unit_test(test_two_masks), cmocka_unit_test(test_faults_hold),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
