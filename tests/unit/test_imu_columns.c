/* imu_columns: texts of the options, and what each of them means by the documentation in the header. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "formats/imu_columns.h"

static fw_imu_map map;
static fw_imu_problem problem;

static const fw_imu_column *column(const char *text, fw_imu_name name)
{
	if (fw_imu_parse_columns(text, &map, &problem) != FW_OK)
		fail_msg("%s: '%s': %s", text, problem.token, problem.reason);
	assert_true(map.given && map.entry[name].wanted);
	return &map.entry[name];
}

#define RATES "gx=2 gy=3 gz=4 ax=5 ay=6 az=7 "

static void columns_have_numbers_or_names(void **state)
{
	(void)state;
	assert_int_equal(column("time=1," RATES, FW_IMU_GZ)->column, 4);
	assert_string_equal(column(RATES "  time=t_s", FW_IMU_TIME)->name, "t_s");
	assert_int_equal(map.entry[FW_IMU_TIME].column, 0);
	assert_string_equal(column("time='my time, [s]':ms " RATES, FW_IMU_TIME)->name, "my time, [s]");
	assert_true(map.entry[FW_IMU_TIME].scale == 1e6);
	assert_string_equal(column("time=\"a:b=c@d\" " RATES, FW_IMU_TIME)->name, "a:b=c@d");
	assert_false(map.entry[FW_IMU_MX].wanted);
}

static void units_have_their_factors(void **state)
{
	static const struct {
		const char *text;
		fw_imu_name name;
		double scale;
	} units[] = {
	    {"time=1 baro=2", FW_IMU_TIME, 1e9},
	    {"time=1:ns baro=2", FW_IMU_TIME, 1},
	    {"time=1:us baro=2:hPa", FW_IMU_BARO, 100},
	    {"time=1 mx=2:G my=3:G mz=4:G", FW_IMU_MY, 100},
	    {"time=1 mx=2:mG my=3:mG mz=4:mG", FW_IMU_MY, 0.1},
	    {"time=1 mx=2:1 my=3:1 mz=4:1", FW_IMU_MY, 50},
	    {"time=1 lat=2:1e-7 lon=3:rad height=4:0.001", FW_IMU_LAT, 1e-7},
	    {"time=1 lat=2:1e-7 lon=3:rad height=4:0.001", FW_IMU_LON, 57.29577951308232},
	    {"time=1 gx=5:deg/s gy=6:deg/s gz=7:deg/s ax=2:g ay=3:g az=4:g", FW_IMU_GX, 0.017453292519943295},
	    {"time=1 gx=5:deg/s gy=6:deg/s gz=7:deg/s ax=2:g ay=3:g az=4:g", FW_IMU_AZ, 9.80665},
	    {"time=1 gx=5:-0.5 gy=6 gz=7 ax=2 ay=3 az=4", FW_IMU_GX, -0.5},
	};

	(void)state;
	for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
		const double scale = column(units[i].text, units[i].name)->scale;

		if (!(fabs(scale - units[i].scale) <= 1e-15 * fabs(scale)))
			fail_msg("%s: %.17g", units[i].text, scale);
	}
	assert_true(
	    column("time=1 gx=5:deg gy=6:deg gz=7:deg ax=2:m/s ay=3:m/s az=4:m/s", FW_IMU_GX)->increment);
	assert_true(map.entry[FW_IMU_AX].increment && !map.entry[FW_IMU_TIME].increment);
	assert_true(column("time=1 baro=2:Pa", FW_IMU_BARO)->pressure);
}

static void lines_of_kinds_and_known_layouts(void **state)
{
	(void)state;
	assert_string_equal(column("px4-replay", FW_IMU_MX)->tag, "mag");
	assert_int_equal(map.entry[FW_IMU_MX].column, 3);
	assert_true(map.entry[FW_IMU_MX].scale == 100 && map.entry[FW_IMU_LAT].scale == 1e-7);
	assert_int_equal(column("euroc", FW_IMU_AZ)->column, 7);
	assert_true(column("kf-gins-imu", FW_IMU_GX)->increment);
	assert_int_equal(fw_imu_parse_columns("kf-gins", &map, &problem), FW_OK);
	assert_true(map.given && map.kf_gins);
}

/* Each is refused, and the part that is wrong is named. */
static void what_is_wrong_is_named(void **state)
{
	static const char *const wrong[][2] = {
	    {"time=1 gx=2", "gx gy gz"},
	    {"time=1 " RATES "gx=9", "gx"},
	    {"time=1 speed=9 " RATES, "speed"},
	    {RATES, "time"},
	    {"time=1", "time"},
	    {"", "time"},
	    {"nonsense", "nonsense"},
	    {"time=1:parsec " RATES, "parsec"},
	    {"time=1: " RATES, "time"},
	    {"time= " RATES, ""},
	    {"time=0 " RATES, "0"},
	    {"time=257 " RATES, "257"},
	    {"time=@3 " RATES, "time"},
	    {"time=1 lat=2 lon=3", "lat lon height"},
	    {"time=1 vn=2 ve=3 vd=4 baro=5", "vn ve vd"},
	    {"time=1 gx=2 gy=3 gz=4", "gx gy gz ax ay az"},
	    {"time=1 gx=2:rad gy=3:rad gz=4 ax=5 ay=6 az=7", "gx gy gz"},
	    {"time=1 gx=a@2 gy=b@3 gz=a@4 ax=a@5 ay=a@6 az=a@7", "gx gy gz"},
	    {"time=1 baro=2:0", "0"},
	};

	(void)state;
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		memset(&map, 0, sizeof map);
		if (fw_imu_parse_columns(wrong[i][0], &map, &problem) != FW_ESYNTAX)
			fail_msg("%s was taken", wrong[i][0]);
		assert_string_equal(problem.token, wrong[i][1]);
		assert_false(map.given);
	}
}

/* v = (1, 2, 3) in the sensor's axes. */
static void assert_turned(const char *text, double x, double y, double z)
{
	const double v[3] = {1, 2, 3};
	fw_imu_axes axes;
	double body[3];

	assert_int_equal(fw_imu_parse_axes(text, &axes, &problem), FW_OK);
	assert_true(axes.given);
	fw_imu_turn(&axes, v, body);
	assert_true(body[0] == x && body[1] == y && body[2] == z);
}

/* FLU and RFU: x forward (right), y left (forward), z up; by drawing. The last is roll 180, yaw -90 degrees.
 * */
static void axes_turn_vectors(void **state)
{
	(void)state;
	assert_turned("FRD", 1, 2, 3);
	assert_turned("FLU", 1, -2, -3);
	assert_turned("RFU", 2, 1, -3);
	assert_turned("-y,x,z", -2, 1, 3);
	assert_turned("+z,+x,+y", 3, 1, 2);
	assert_turned("-y,-x,-z", -2, -1, -3);
}

static void axes_that_are_none(void **state)
{
	static const char *const wrong[] = {"",      "x",     "x,y",     "x,y,z,x", "y,x,z", "-x,y,z",
	                                    "x,x,z", "a,b,c", "x, y, z", "FRU",     "x,y,"};
	fw_imu_axes axes = {.from = {7}};

	(void)state;
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
		if (fw_imu_parse_axes(wrong[i], &axes, &problem) != FW_ESYNTAX)
			fail_msg("%s was taken", wrong[i]);
	assert_int_equal(axes.from[0], 7);
}

static void times_of_all_scales(void **state)
{
	fw_imu_clock c;

	(void)state;
	assert_int_equal(fw_imu_parse_time("unix-gps", &c, &problem), FW_OK);
	assert_true(c.scale == FW_SCALE_UNIX_GPS && !c.has_week && !c.has_start && c.shift_s == 0);
	assert_int_equal(fw_imu_parse_time("gps,week=2381,shift=-0.02", &c, &problem), FW_OK);
	assert_true(c.scale == FW_SCALE_GPS && c.has_week && c.week == 2381 && c.shift_s == -0.02);
	assert_int_equal(fw_imu_parse_time("boot,start=2381:100.5", &c, &problem), FW_OK);
	assert_true(c.has_start && c.start.ns == 2381 * FW_NS_PER_WEEK + 100500000000);
	assert_int_equal(fw_imu_parse_time("unix-utc", &c, &problem), FW_OK);
}

static void times_that_are_none(void **state)
{
	static const char *const wrong[] = {"",
	                                    "tai",
	                                    "gps,",
	                                    "gps,week",
	                                    "gps,week=",
	                                    "gps,week=9999",
	                                    "gps,year=3",
	                                    "boot,start=yesterday",
	                                    "gps,shift=x",
	                                    "gps,shift=1e9",
	                                    "gps week=3"};
	fw_imu_clock c = {.week = 7};

	(void)state;
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
		if (fw_imu_parse_time(wrong[i], &c, &problem) != FW_ESYNTAX)
			fail_msg("%s was taken", wrong[i]);
	assert_int_equal(c.week, 7);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(columns_have_numbers_or_names),
	    cmocka_unit_test(units_have_their_factors),
	    cmocka_unit_test(lines_of_kinds_and_known_layouts),
	    cmocka_unit_test(what_is_wrong_is_named),
	    cmocka_unit_test(axes_turn_vectors),
	    cmocka_unit_test(axes_that_are_none),
	    cmocka_unit_test(times_of_all_scales),
	    cmocka_unit_test(times_that_are_none),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
