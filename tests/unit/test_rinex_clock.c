/* rinex_clock: the records are those of the IGS final clocks of 2010-07-01 and, in the layout of version
 * 3.04, written by hand after the document's tables. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/random.h"
#include "formats/rinex_clock.h"

static fw_input input;
static fw_rinex_clock_reader reader;

static void begin(const char *text)
{
	fw_input_open_memory(&input, text, strlen(text));
	fw_rinex_clock_begin(&reader, &input);
}

static fw_time gpst(const char *text)
{
	fw_time t;

	assert_int_equal(fw_time_parse(text, &t), FW_OK);
	return t;
}

#define FIRST "     3.00           C                                       RINEX VERSION / TYPE\n"
#define HEAD                                                                                                 \
	FIRST "CCLOCK              IGSACC @ NOAA NGS                       PGM / RUN BY / DATE \n"           \
	      "     2    AR    AS                                          # / TYPES OF DATA   \n"           \
	      "                                                            END OF HEADER       \n"

static void clocks_are_read(void **state)
{
	fw_rinex_clock_point p;

	(void)state;
	begin(HEAD "AR ZWE2 2010 07 01 00 00  0.000000  2   -3.167370059072e-03  7.480860050640e-12\n"
	           "AS G02  2010 07 01 00 00  0.000000  2    2.691084288582e-04  1.507490528240e-11\n"
	           "AS G07  2010 07 01 00 00 30.000000  1   -1.513484068958D-06\n");
	assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_OK);
	assert_int_equal(p.time.ns, gpst("2010-07-01T00:00:00").ns);
	assert_true(fw_satellite_equal(p.satellite, (fw_satellite){FW_GPS, 2}));
	assert_true(p.clock_s == 2.691084288582e-04 && p.sd_s == 1.507490528240e-11);
	assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_OK);
	assert_int_equal(p.time.ns, gpst("2010-07-01T00:00:30").ns);
	assert_true(p.clock_s == -1.513484068958e-06 && p.sd_s == 0);
	assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_EOF);
}

#define HEAD_304                                                                                             \
	"3.04                 C                    M                      RINEX VERSION / TYPE\n"            \
	"   GPS                                                           TIME SYSTEM ID\n"                  \
	"THIS COMMENT SAYS                                           END OF HEADER        COMMENT\n"         \
	"                                                                 END OF HEADER\n"

static void long_names_move_the_columns(void **state)
{
	fw_rinex_clock_point p;

	(void)state;
	begin(HEAD_304
	      "AR ABMF00GLP 2024 01 01 00 00  0.000000  2   -0.123456789012E-07  0.123456789012E-10\n"
	      "AS E36       2024 01 01 00 05  0.000000  2   -0.123456789012E-03  0.234567890123E-10\n");
	assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_OK);
	assert_int_equal(p.time.ns, gpst("2024-01-01T00:05:00").ns);
	assert_true(fw_satellite_equal(p.satellite, (fw_satellite){FW_GALILEO, 36}));
	assert_true(p.clock_s == -0.123456789012e-03 && p.sd_s == 0.234567890123e-10);
	assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_EOF);
}

/* More than two values continue on a second line, which is of no interest here. */
static void continuation_lines_are_passed_over(void **state)
{
	fw_rinex_clock_point p;

	(void)state;
	begin(HEAD "AS G16  1994 07 14 20 59  0.000000  6   -0.123456789012E+00  0.123456789012E+01\n"
	           "   -0.123456789012E+02  0.123456789012E+03 -0.123456789012E+04  0.123456789012E+05\n"
	           "AS L51  1994 07 14 20 59  0.000000  1   -0.123456789012E+00\n"
	           "MS G16  1994 07 14 20 59  0.000000  1   -0.123456789012E+00\n");
	assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_OK);
	assert_true(p.clock_s == -0.123456789012);
	assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_EOF);
}

static void time_systems_are_brought_to_gpst(void **state)
{
	static const struct {
		const char *system, *gpst;
	} systems[] = {{"GPS", "2024-01-01T00:00:00"},
	               {"GAL", "2024-01-01T00:00:00"},
	               {"BDT", "2024-01-01T00:00:14"},
	               {"UTC", "2024-01-01T00:00:18"},
	               {"GLO", "2024-01-01T00:00:18"}};

	(void)state;
	for (size_t i = 0; i < sizeof systems / sizeof systems[0]; i++) {
		char text[1000];
		fw_rinex_clock_point p;

		snprintf(text, sizeof text, "%s   %s%54s%s\n%60s%s\n%s", FIRST, systems[i].system, "",
		         "TIME SYSTEM ID", "", "END OF HEADER",
		         "AS G02  2024 01 01 00 00  0.000000  1    2.691084288582e-04\n");
		begin(text);
		assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_OK);
		assert_int_equal(p.time.ns, gpst(systems[i].gpst).ns);
	}
}

static void damaged_lines_are_lost_alone(void **state)
{
	static const char *const damaged[] = {
	    "AS G02  2010 13 01 00 00  0.000000  2    2.691084288582e-04  1.507490528240e-11",
	    "AS G02  2010 07 01 00 00 xx.000000  2    2.691084288582e-04  1.507490528240e-11",
	    "AS G02  2010 07 01 00 00  0.000000  2    2.69l084288582e-04  1.507490528240e-11",
	    "AS G02  2010 07 01 00 00  0.000000  2    2.691084288582e-04  1.507490528240e-xx",
	    "AS G02  2010 07 01 00 00  0.000000  2                      ",
	    "AS X02  2010 07 01 00 00  0.000000  2    2.691084288582e-04  1.507490528240e-11",
	    "AS G02",
	    "AS",
	};

	(void)state;
	for (size_t i = 0; i < sizeof damaged / sizeof damaged[0]; i++) {
		char text[1000];
		fw_rinex_clock_point p = {.clock_s = 7};

		snprintf(text, sizeof text, "%s%s\n%s", HEAD, damaged[i],
		         "AS G02  2010 07 01 00 00  0.000000  2    2.691084288582e-04  1.507490528240e-11\n");
		begin(text);
		assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_ESYNTAX);
		assert_int_equal(reader.lines.number, 5);
		assert_true(strlen(reader.reason) > 0 && p.clock_s == 7);
		assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_OK);
		assert_int_equal(fw_rinex_clock_read(&reader, &p), FW_EOF);
	}
}

static void other_files_are_refused(void **state)
{
	static const struct {
		const char *text;
		fw_status status;
	} files[] = {{"", FW_EUNKNOWN},
	             {"#cP2010\n", FW_EUNKNOWN},
	             {"     3.04           N: GNSS NAV DATA    M: Mixed            RINEX VERSION / TYPE\n",
	              FW_EUNKNOWN},
	             {"     4.00           C                                       RINEX VERSION / TYPE\n",
	              FW_EUNKNOWN},
	             {"     x.00           C                                       RINEX VERSION / TYPE\n",
	              FW_EUNKNOWN},
	             {FIRST "   XYZ                                                      TIME SYSTEM ID\n",
	              FW_EUNKNOWN},
	             {FIRST, FW_ETRUNCATED},
	             {HEAD, FW_EOF}};

	(void)state;
	for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
		fw_rinex_clock_point p;

		begin(files[i].text);
		assert_int_equal(fw_rinex_clock_read(&reader, &p), files[i].status);
	}
}

/* Whatever is done to a file, reading ends, and what comes out is finite. */
static void damage_does_no_harm(void **state)
{
	static const char whole[] =
	    HEAD "AS G02  2010 07 01 00 00  0.000000  2    2.691084288582e-04  1.507490528240e-11\n"
	         "AS G07  2010 07 01 00 00 30.000000  1   -1.513484068958D-06\n";
	char text[sizeof whole];
	fw_random r;

	(void)state;
	fw_random_init(&r, 2);
	for (int i = 0; i < 20000; i++) {
		fw_rinex_clock_point p;
		fw_status status;
		int lines = 0;

		memcpy(text, whole, sizeof text);
		for (uint64_t n = 1 + fw_random_below(&r, 5); n > 0; n--)
			text[fw_random_below(&r, sizeof text - 1)] = (char)(1 + fw_random_below(&r, 255));
		text[fw_random_below(&r, 4) == 0 ? fw_random_below(&r, sizeof text) : sizeof text - 1] = '\0';
		begin(text);
		while ((status = fw_rinex_clock_read(&reader, &p)) == FW_OK || status == FW_ESYNTAX) {
			assert_true(++lines < 40);
			if (status == FW_OK)
				assert_true(isfinite(p.clock_s) && isfinite(p.sd_s));
		}
		assert_true(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EUNKNOWN);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(clocks_are_read),
	    cmocka_unit_test(long_names_move_the_columns),
	    cmocka_unit_test(continuation_lines_are_passed_over),
	    cmocka_unit_test(time_systems_are_brought_to_gpst),
	    cmocka_unit_test(damaged_lines_are_lost_alone),
	    cmocka_unit_test(other_files_are_refused),
	    cmocka_unit_test(damage_does_no_harm),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
