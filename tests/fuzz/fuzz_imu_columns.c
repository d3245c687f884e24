/* The texts of --imu-columns, --imu-axes and --imu-time, a line each. What is taken says what it means within
 * bounds. */
#include "text_input.h"

#include <math.h>

#include "formats/imu_columns.h"

static const char *const words[] = {"time=", "gx=",          "gy=",    "gz=",      "ax=",  "ay=", "az=",
                                    "lat=",  "baro=",        "'",      "\"",       "@",    ":",   "deg/s",
                                    "m/s",   "uT",           " ",      ",",        "x",    "-y",  "RFU",
                                    "week=", "start=2300:0", "shift=", "unix-utc", "boot", "gps", "256",
                                    "257",   "1e-7",         "0"};

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	static const char *const texts[] = {
	    "time=1:us gx=5:deg/s gy=6 gz=7 ax=2:g ay=3:g az=4:g\n-y,x,z\ngps,week=2300,shift=-0.02\n",
	    "time='my time':ms,baro=word@3:hPa,lat=lat:1e-7 lon=lon height=h\nFLU\nboot,start=2300:5\n",
	    "kf-gins\nRFU\nunix-utc\n",
	};
	const char *text = texts[fw_random_below(random, 3)];

	memcpy(data, text, strlen(text));
	return strlen(text);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return text_mutate(data, size, max, seed, words, sizeof words / sizeof *words);
}

static void check_map(const char *text)
{
	fw_imu_problem problem;
	fw_imu_map map;

	if (fw_imu_parse_columns(text, &map, &problem) != FW_OK) {
		require(strlen(problem.token) < sizeof problem.token && problem.reason[0] != '\0');
		return;
	}
	for (int i = 0; i < FW_IMU_NAMES; i++) {
		const fw_imu_column *e = &map.entry[i];

		require(!e->wanted || (e->column >= 0 && e->column <= FW_IMU_COLUMN_MAX && e->scale != 0 &&
		                       isfinite(e->scale)));
		require(strlen(e->name) < sizeof e->name && strlen(e->tag) < sizeof e->tag);
	}
}

static void check_axes(const char *text)
{
	const double v[3] = {1, 2, 3};
	fw_imu_problem problem;
	fw_imu_axes axes;
	double body[3];

	if (fw_imu_parse_axes(text, &axes, &problem) != FW_OK)
		return;
	fw_imu_turn(&axes, v, body);
	require(fabs(body[0] * body[1] * body[2]) == 6);
}

static void check_time(const char *text)
{
	fw_imu_problem problem;
	fw_imu_clock clock;

	if (fw_imu_parse_time(text, &clock, &problem) == FW_OK)
		require(clock.week >= 0 && clock.week <= FW_TIME_WEEK_MAX && isfinite(clock.shift_s));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static char text[FUZZ_ROOM + 1];
	char *line = text;

	memcpy(text, data, size);
	text[size] = '\0';
	for (int i = 0; i < 3 && line != NULL; i++) {
		char *rest = strchr(line, '\n');

		if (rest != NULL)
			*rest++ = '\0';
		check_map(line);
		check_axes(line);
		check_time(line);
		line = rest;
	}
	return 0;
}
