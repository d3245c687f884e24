/* Writing RINEX navigation files: records read from a file written by hand, written, and read again are the
 * same; the reader's own tests are in test_rinex_nav.c. Against RTKLIB: tests/oracle/test_rinex.py. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>

#include "../random_record.h"
#include "formats/rinex_nav.h"
#include "formats/rinex_write_nav.h"

/* clang-format off */
static const char file[] =
    "     3.04           NAVIGATION DATA     M: MIXED            RINEX VERSION / TYPE\n"
    "furrow " FURROW_VERSION "                            20240624 080000 GPS PGM / RUN BY / DATE\n"
    "GPSA   1.8626E-08  2.2352E-08 -1.1921E-07 -5.9605E-08       IONOSPHERIC CORR\n"
    "GPSB   1.2902E+05  1.6384E+05 -1.9661E+05  0.0000E+00       IONOSPHERIC CORR\n"
    "GAL    1.6175E+02  6.6016E-01  1.9379E-02                   IONOSPHERIC CORR\n"
    "GPUT -9.3132257462E-10-7.993605777E-15 319488 2320          TIME SYSTEM CORR\n"
    "GAUT  9.3132257462E-10 0.000000000E+00  86400 2320          TIME SYSTEM CORR\n"
    "    18    19  2330     7                                    LEAP SECONDS\n"
    "                                                            END OF HEADER\n"
    "G05 2024 06 24 10 00 00-1.774230040610E-04-1.364242052659E-12 0.000000000000E+00\n"
    "     7.200000000000E+01-9.821875000000E+01 4.293035965037E-09 1.714815412488E+00\n"
    "    -5.291774868965E-06 5.927642923780E-03 1.830980181694E-06 5.153635631561E+03\n"
    "     1.224000000000E+05 3.352761268616E-08 2.520897825810E+00-5.774199962616E-08\n"
    "     9.719266524177E-01 3.536250000000E+02 1.273307347665E+00-8.275344701323E-09\n"
    "    -2.610823036973E-10 1.000000000000E+00 2.320000000000E+03 0.000000000000E+00\n"
    "     2.000000000000E+00 0.000000000000E+00-1.071020960808E-08 7.200000000000E+01\n"
    "     1.152180000000E+05 4.000000000000E+00\n"
    "E05 2023 12 31 23 40 00 4.705949453637E-03 3.666400516522E-12 0.000000000000E+00\n"
    "     1.400000000000E+01-1.377187500000E+02 2.965123509296E-09 2.768396775866E+00\n"
    "    -6.398186087608E-06 6.165727972984E-05 9.458512067795E-06 5.440615369797E+03\n"
    "     8.520000000000E+04 4.656612873077E-08 4.691600838407E-01 0.000000000000E+00\n"
    "     9.604247779356E-01 1.374375000000E+02 2.772505962070E+00-5.544516665660E-09\n"
    "    -4.643050544549E-11 2.580000000000E+02 2.295000000000E+03\n"
    "     3.120000000000E+00 8.000000000000E+00 3.725290298462E-09 0.000000000000E+00\n"
    "     8.590000000000E+04\n"
    "E05 2023 12 31 23 40 00 4.705949453637E-03 3.666400516522E-12 0.000000000000E+00\n"
    "     1.400000000000E+01-1.377187500000E+02 2.965123509296E-09 2.768396775866E+00\n"
    "    -6.398186087608E-06 6.165727972984E-05 9.458512067795E-06 5.440615369797E+03\n"
    "     8.520000000000E+04 4.656612873077E-08 4.691600838407E-01 0.000000000000E+00\n"
    "     9.604247779356E-01 1.374375000000E+02 2.772505962070E+00-5.544516665660E-09\n"
    "    -4.643050544549E-11 5.170000000000E+02 2.295000000000E+03\n"
    "    -1.000000000000E+00 6.500000000000E+01 3.725290298462E-09 4.190951585770E-09\n"
    "     8.590000000000E+04\n"
    "C01 2024 01 01 00 00 00 8.813514141366E-04 5.533351554732E-13 0.000000000000E+00\n"
    "     1.000000000000E+00-4.073593750000E+02 3.017268538490E-09-4.899218874420E-02\n"
    "    -1.346226781607E-05 4.545742413030E-04 9.190756827593E-06 6.493366928100E+03\n"
    "     8.640000000000E+04-1.573935151100E-07-2.924794698380E+00 8.195638656616E-08\n"
    "     6.475285035900E-02-2.854218750000E+02-7.687375453020E-01-1.848291274460E-09\n"
    "    -3.764442518430E-10                    9.390000000000E+02\n"
    "     2.000000000000E+00 0.000000000000E+00-5.400000002709E-09-9.799999922677E-09\n"
    "     8.640000000000E+04 0.000000000000E+00\n"
    "R01 2023 12 31 23 45 00 7.346738129854E-05 9.094947017729E-13 8.460000000000E+04\n"
    "    -1.590860058594E+04 2.358419418335E+00-1.862645149231E-09 1.000000000000E+00\n"
    "    -9.789697265625E+03 3.281402587891E-01-1.862645149231E-09 1.000000000000E+00\n"
    "    -1.737410107422E+04-2.343545913696E+00 0.000000000000E+00 0.000000000000E+00\n"
    "S22 2025 02 15 23 59 44 0.000000000000E+00 0.000000000000E+00 0.000000000000E+00\n"
    "    -3.389392800000E+04 0.000000000000E+00 0.000000000000E+00 1.000000000000E+00\n"
    "     2.508018800000E+04 0.000000000000E+00 0.000000000000E+00 8.192000000000E+03\n"
    "     1.589600000000E+00 0.000000000000E+00 0.000000000000E+00 1.570000000000E+02\n";
/* clang-format on */

static char bytes[1 << 16];
static memory out;
static fw_rinex_survey survey;
static fw_rinex_nav_writer writer;

/* All records of a file to a sink. */
static int each(const char *text, size_t n, fw_sink sink, int times)
{
	static fw_rinex_nav reader;
	static fw_input input;
	fw_any_record record;
	fw_kind kind;
	fw_status status;
	int count = 0;

	fw_input_open_memory(&input, text, n);
	fw_rinex_nav_begin(&reader, &input);
	while ((status = fw_rinex_nav_read(&reader, &kind, &record)) == FW_OK) {
		for (int i = 0; i < times; i++)
			sink.put(sink.context, kind, &record);
		count++;
	}
	assert_int_equal(status, FW_EOF);
	return count;
}

static void write_file(int times)
{
	out = (memory){bytes, sizeof bytes - 1, 0};
	fw_rinex_survey_begin(&survey);
	survey.last = (fw_time){INT64_C(2320) * FW_NS_PER_WEEK + FW_NS_PER_DAY + 8 * 3600 * FW_NS_PER_S};
	each(file, sizeof file - 1, (fw_sink){fw_rinex_survey_put, &survey}, 1);
	fw_rinex_nav_write(&writer, &survey, to_memory, &out);
	assert_int_equal(each(file, sizeof file - 1, (fw_sink){fw_rinex_nav_put, &writer}, times), 4 + 6);
	assert_int_equal(fw_rinex_nav_end(&writer), FW_OK);
	bytes[out.used] = '\0';
}

/* The same file comes out, blanks for what it leaves open aside. */
static void there_and_back(void **state)
{
	(void)state;
	write_file(1);
	assert_string_equal(bytes, file);
	assert_int_equal(writer.entries, 6);
}

/* The same ephemeris again, decoded by somebody else, is left out. */
static void repeated(void **state)
{
	(void)state;
	write_file(2);
	assert_string_equal(bytes, file);
	assert_int_equal(writer.repeated, 6);
	assert_int_equal(writer.refused, 0);
}

static void without_a_name(void **state)
{
	fw_any_record record;
	(void)state;
	write_file(1);
	fw_record_clear(FW_eph_gps, &record);
	fw_rinex_nav_put(&writer, FW_eph_gps, &record);
	fw_record_clear(FW_eph_sbas, &record);
	fw_rinex_nav_put(&writer, FW_eph_sbas, &record);
	assert_int_equal(writer.refused, 2);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(there_and_back),
	    cmocka_unit_test(repeated),
	    cmocka_unit_test(without_a_name),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
