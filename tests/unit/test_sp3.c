/* sp3: the lines of the first test are those of the IGS final orbits of 2010-07-01; times of other scales are
 * counted by hand: GPST = TAI - 19 s = BDT + 14 s = UTC + 18 s (2024). */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/random.h"
#include "formats/sp3.h"

static fw_input input;
static fw_sp3_reader reader;

static void begin(const char *text)
{
	fw_input_open_memory(&input, text, strlen(text));
	fw_sp3_begin(&reader, &input);
}

static fw_time gpst(const char *text)
{
	fw_time t;

	assert_int_equal(fw_time_parse(text, &t), FW_OK);
	return t;
}

static void assert_near(double a, double b, double tolerance)
{
	if (!(fabs(a - b) <= tolerance))
		fail_msg("%.15g is not %.15g", a, b);
}

#define HEAD_OF(version, scale)                                                                              \
	"#" version "P2010  7  1  0  0  0.00000000      96 ORBIT IGS05 HLM  IGS\n"                           \
	"## 1590 345600.00000000   900.00000000 55378 0.0000000000000\n"                                     \
	"+   32   G01G02G03G04G05G06G07G08G09G10G11G12G13G14G15G16G17\n"                                     \
	"++         0  2  2  2  2  2  2  2  2  2  3  2  2  2  2  2  2\n"                                     \
	"%c G  cc " scale " ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc\n"                               \
	"%c cc cc ccc ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc\n"                                     \
	"%f  1.2500000  1.025000000  0.00000000000  0.000000000000000\n"                                     \
	"%i    0    0    0    0      0      0      0      0         0\n"                                     \
	"/* REFERENCED TO IGS TIME (IGST) AND TO WEIGHTED MEAN POLE: \n"
#define HEAD  HEAD_OF("c", "GPS")
#define EPOCH "*  2010  7  1  0 15  0.00000000\n"

static void points_are_read(void **state)
{
	fw_sp3_point p;

	(void)state;
	begin(HEAD "*  2010  7  1  0  0  0.00000000\n"
	           "PG01  18392.619117   7490.690408 -17846.346485 999999.999999\n"
	           "PG02 -14889.160729  -5131.952946 -21416.801336    269.108429  7  6  8 110       \n"
	           "VG02  12889.160729  -5131.952946 -21416.801336    269.108429  7  6  8 110       \n" EPOCH
	           "PG02 -14399.063465  -7514.993025 -21086.733714    269.111382  6  5  8  92       \n"
	           "EOF\n");
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_int_equal(p.time.ns, gpst("2010-07-01T00:00:00").ns);
	assert_true(fw_satellite_equal(p.satellite, (fw_satellite){FW_GPS, 1}));
	assert_true(p.has_position && !p.has_clock);
	assert_near(p.position_m[0], 18392619.117, 1e-8);
	assert_near(p.position_m[1], 7490690.408, 1e-8);
	assert_near(p.position_m[2], -17846346.485, 1e-8);

	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_true(fw_satellite_equal(p.satellite, (fw_satellite){FW_GPS, 2}));
	assert_true(p.has_position && p.has_clock);
	assert_near(p.clock_s, 269.108429e-6, 1e-18);
	assert_false(p.clock_event || p.clock_predicted || p.manoeuvre || p.orbit_predicted);

	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_int_equal(p.time.ns, gpst("2010-07-01T00:15:00").ns);
	assert_near(p.position_m[1], -7514993.025, 1e-8);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_EOF);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_EOF);
}

static void flags_are_read(void **state)
{
	fw_sp3_point p;

	(void)state;
	begin(HEAD EPOCH "PR24      0.000000      0.000000      0.000000    100.000000              E   M \n"
	                 "PE36  18392.619117   7490.690408 -17846.346485    100.000000  7  6  8 110  P   P\n"
	                 "PL51  18392.619117   7490.690408 -17846.346485    100.000000\n"
	                 "PC59  18392.619117   7490.690408 -17846.346485\n"
	                 "PS23  18392.619117   7490.690408 -17846.346485               \nEOF\n");
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_true(fw_satellite_equal(p.satellite, (fw_satellite){FW_GLONASS, 24}));
	assert_true(!p.has_position && p.has_clock);
	assert_true(p.clock_event && !p.clock_predicted && p.manoeuvre && !p.orbit_predicted);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_true(!p.clock_event && p.clock_predicted && !p.manoeuvre && p.orbit_predicted);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK); /* the low orbit L51 was passed over */
	assert_true(fw_satellite_equal(p.satellite, (fw_satellite){FW_BEIDOU, 59}) && !p.has_clock);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_true(fw_satellite_equal(p.satellite, (fw_satellite){FW_SBAS, 23}) && !p.has_clock);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_EOF);
}

static void old_versions_are_read(void **state)
{
	fw_sp3_point p;

	(void)state;
	begin(HEAD_OF("a", "ccc") EPOCH "P  1  18392.619117   7490.690408 -17846.346485 999999.999999\nEOF");
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_true(fw_satellite_equal(p.satellite, (fw_satellite){FW_GPS, 1}));
	assert_int_equal(fw_sp3_read(&reader, &p), FW_EOF);
}

static void scales_are_brought_to_gpst(void **state)
{
	static const struct {
		const char *scale, *gpst;
	} scales[] = {{"GPS", "2024-01-01T00:15:00"}, {"GAL", "2024-01-01T00:15:00"},
	              {"QZS", "2024-01-01T00:15:00"}, {"BDT", "2024-01-01T00:15:14"},
	              {"UTC", "2024-01-01T00:15:18"}, {"GLO", "2024-01-01T00:15:18"},
	              {"TAI", "2024-01-01T00:14:41"}};

	(void)state;
	for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
		char text[2000];
		fw_sp3_point p;

		snprintf(text, sizeof text, "#dP\n%%c M  cc %s ccc\n*  2024  1  1  0 15  0.00000000\n%s",
		         scales[i].scale,
		         "PG01  18392.619117   7490.690408 -17846.346485    100.000000\nEOF\n");
		begin(text);
		assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
		assert_int_equal(p.time.ns, gpst(scales[i].gpst).ns);
	}
}

/* Day after day in one stream. The second file's scale is its own. */
static void files_may_follow_one_another(void **state)
{
	fw_sp3_point p;

	(void)state;
	begin(HEAD_OF("c", "BDT") EPOCH
	      "PG01  18392.619117   7490.690408 -17846.346485    100.000000\nEOF\n" //
	      HEAD EPOCH "PG01  18392.619117   7490.690408 -17846.346485    100.000000\nEOF\n");
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_int_equal(p.time.ns, gpst("2010-07-01T00:15:14").ns);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_int_equal(p.time.ns, gpst("2010-07-01T00:15:00").ns);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_EOF);
}

/* Each damaged line is lost with its number and a reason; the good one behind it is not. */
static void damaged_lines_are_lost_alone(void **state)
{
	static const char *const damaged[] = {
	    "PG02 -14889.16x729  -5131.952946 -21416.801336    269.108429",
	    "PG02 -14889.160729  -5131.952946               ",
	    "PG02 -14889.160729  -5131.952946 -21416.801336    269.1o8429",
	    "PX02 -14889.160729  -5131.952946 -21416.801336    269.108429",
	    "PG00 -14889.160729  -5131.952946 -21416.801336    269.108429",
	    "PG",
	    "P",
	    "QG02 -14889.160729  -5131.952946 -21416.801336    269.108429",
	};

	(void)state;
	for (size_t i = 0; i < sizeof damaged / sizeof damaged[0]; i++) {
		char text[2000];
		fw_sp3_point p = {.clock_s = 7};

		snprintf(text, sizeof text, "%s%s\n%s", HEAD EPOCH, damaged[i],
		         "PG01  18392.619117   7490.690408 -17846.346485    100.000000\nEOF\n");
		begin(text);
		assert_int_equal(fw_sp3_read(&reader, &p), FW_ESYNTAX);
		assert_int_equal(reader.lines.number, 11);
		assert_true(strlen(reader.reason) > 0);
		assert_true(p.clock_s == 7);
		assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
		assert_int_equal(fw_sp3_read(&reader, &p), FW_EOF);
	}
}

/* Satellites below an epoch that cannot be read have no time. */
static void damaged_epochs_cost_their_points(void **state)
{
	fw_sp3_point p;

	(void)state;
	begin(HEAD EPOCH "PG01  18392.619117   7490.690408 -17846.346485    100.000000\n"
	                 "*  2010 13  1  0 15  0.00000000\n"
	                 "PG01  18392.619117   7490.690408 -17846.346485    100.000000\nEOF\n");
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_ESYNTAX);
	assert_int_equal(reader.lines.number, 12);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_ESYNTAX);
	assert_int_equal(reader.lines.number, 13);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_EOF);
}

static void other_files_are_refused(void **state)
{
	static const struct {
		const char *text;
		fw_status status;
	} files[] = {{"", FW_EUNKNOWN},
	             {"\n", FW_EUNKNOWN},
	             {"     3.04           N", FW_EUNKNOWN},
	             {"#eP2010\n", FW_EUNKNOWN},
	             {"#", FW_EUNKNOWN},
	             {"#furrow-stream 1\n", FW_EUNKNOWN},
	             {HEAD_OF("c", "XYZ"), FW_EUNKNOWN},
	             {HEAD, FW_ETRUNCATED},
	             {HEAD EPOCH, FW_ETRUNCATED}};

	(void)state;
	for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
		fw_sp3_point p;

		begin(files[i].text);
		assert_int_equal(fw_sp3_read(&reader, &p), files[i].status);
	}
}

static void overlong_lines_are_lost(void **state)
{
	static char text[3 * FW_RINEX_LINE_MAX];
	fw_sp3_point p;
	size_t n;

	(void)state;
	n = (size_t)snprintf(text, sizeof text, "%s/* ", HEAD EPOCH);
	memset(text + n, 'x', 2 * FW_RINEX_LINE_MAX);
	snprintf(text + n + 2 * FW_RINEX_LINE_MAX, 200, "\n%s",
	         "PG01  18392.619117   7490.690408 -17846.346485    100.000000\nEOF\n");
	begin(text);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_ESYNTAX);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_OK);
	assert_int_equal(fw_sp3_read(&reader, &p), FW_EOF);
}

/* Whatever is done to a file, reading ends, and what comes out is finite. */
static void damage_does_no_harm(void **state)
{
	static const char whole[] = HEAD EPOCH
	    "PG02 -14889.160729  -5131.952946 -21416.801336    269.108429  7  6  8 110       \n"
	    "PE36  18392.619117   7490.690408 -17846.346485    100.000000  7  6  8 110  P   P\nEOF\n";
	char text[sizeof whole];
	fw_random r;

	(void)state;
	fw_random_init(&r, 1);
	for (int i = 0; i < 20000; i++) {
		fw_sp3_point p;
		fw_status status;
		int lines = 0;

		memcpy(text, whole, sizeof text);
		for (uint64_t n = 1 + fw_random_below(&r, 5); n > 0; n--)
			text[fw_random_below(&r, sizeof text - 1)] = (char)(1 + fw_random_below(&r, 255));
		text[fw_random_below(&r, 4) == 0 ? fw_random_below(&r, sizeof text) : sizeof text - 1] = '\0';
		begin(text);
		while ((status = fw_sp3_read(&reader, &p)) == FW_OK || status == FW_ESYNTAX) {
			assert_true(++lines < 40);
			if (status == FW_OK)
				assert_true(isfinite(p.position_m[0] + p.position_m[1] + p.position_m[2] +
				                     p.clock_s));
		}
		assert_true(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EUNKNOWN);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(points_are_read),
	    cmocka_unit_test(flags_are_read),
	    cmocka_unit_test(old_versions_are_read),
	    cmocka_unit_test(scales_are_brought_to_gpst),
	    cmocka_unit_test(files_may_follow_one_another),
	    cmocka_unit_test(damaged_lines_are_lost_alone),
	    cmocka_unit_test(damaged_epochs_cost_their_points),
	    cmocka_unit_test(other_files_are_refused),
	    cmocka_unit_test(overlong_lines_are_lost),
	    cmocka_unit_test(damage_does_no_harm),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
