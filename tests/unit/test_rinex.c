/* What RINEX files have in common: kinds, lines, columns, time. Expected values by hand. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "formats/rinex.h"

static fw_input input;
static fw_lines lines;
static fw_line line;
static char bytes[1 << 20];

static fw_rinex_kind kind_of(const char *text, const char *label)
{
	char head[128];
	const int n = snprintf(head, sizeof head, "%-60s%-20s\n", text, label);
	return fw_rinex_detect((const uint8_t *)head, (size_t)n);
}

static void kinds(void **state)
{
	static const char version[] = "RINEX VERSION / TYPE";
	(void)state;
	assert_int_equal(kind_of("     3.04           OBSERVATION DATA    M", version), FW_RINEX_OBSERVATION);
	assert_int_equal(kind_of("3.0                 COMPACT RINEX FORMAT", "CRINEX VERS   / TYPE"),
	                 FW_RINEX_OBSERVATION);
	assert_int_equal(kind_of("     3.04           N: GNSS NAV DATA    M", version), FW_RINEX_NAVIGATION);
	assert_int_equal(kind_of("     2.11           G: GLONASS NAV DATA", version), FW_RINEX_NAVIGATION);
	assert_int_equal(kind_of("     2.11           H: GEO NAV MSG DATA", version), FW_RINEX_NAVIGATION);
	assert_int_equal(kind_of("     3.04           CLOCK DATA", version), FW_RINEX_OTHER);
	assert_int_equal(kind_of("     2.11           METEOROLOGICAL DATA", version), FW_RINEX_OTHER);
	assert_int_equal(kind_of("     9.00           OBSERVATION DATA    M", version), FW_RINEX_OTHER);
	assert_int_equal(kind_of("gps_week,tow_s", ""), FW_RINEX_NONE);
	assert_int_equal(fw_rinex_detect((const uint8_t *)"", 0), FW_RINEX_NONE);
}

static void begin(const char *text, size_t n)
{
	fw_input_open_memory(&input, text, n);
	fw_lines_begin(&lines, &input);
}

static void line_is(const char *text, uint64_t number, bool whole)
{
	assert_int_equal(fw_lines_next(&lines, &line), FW_OK);
	assert_int_equal(line.n, strlen(text));
	assert_memory_equal(line.text, text, line.n);
	assert_int_equal(line.number, number);
	assert_int_equal(line.whole, whole);
}

static void simple_lines(void **state)
{
	static const char text[] = "one\r\n\ntwo \nthree";
	(void)state;
	begin(text, sizeof text - 1);
	line_is("one", 1, true);
	line_is("", 2, true);
	line_is("two ", 3, true);
	line_is("three", 4, false);
	assert_int_equal(fw_lines_next(&lines, &line), FW_EOF);
	assert_int_equal(fw_lines_next(&lines, &line), FW_EOF);
	begin("", 0);
	assert_int_equal(fw_lines_next(&lines, &line), FW_EOF);
}

/* A line of FW_RINEX_LINE_MAX bytes is one; a longer one, however long, is an empty one. */
static void overlong_lines(void **state)
{
	static const size_t lengths[] = {FW_RINEX_LINE_MAX, FW_RINEX_LINE_MAX + 1, FW_RINEX_BUFFER,
	                                 sizeof bytes - 8};
	(void)state;
	for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
		memset(bytes, 'x', lengths[i]);
		memcpy(bytes + lengths[i], "\nnext\n", 6);
		begin(bytes, lengths[i] + 6);
		assert_int_equal(fw_lines_next(&lines, &line), FW_OK);
		assert_int_equal(line.n, i == 0 ? lengths[0] : 0);
		line_is("next", 2, true);
		assert_int_equal(lines.overlong, i > 0);
		assert_int_equal(fw_lines_next(&lines, &line), FW_EOF);
	}
	memset(bytes, 'x', sizeof bytes);
	begin(bytes, sizeof bytes);
	assert_int_equal(fw_lines_next(&lines, &line), FW_OK);
	assert_int_equal(line.n, 0);
	assert_int_equal(fw_lines_next(&lines, &line), FW_EOF);
}

static fw_line of(const char *text)
{
	return (fw_line){text, strlen(text), 1, true};
}

static void columns(void **state)
{
	const fw_line l = of("ab  1.5D-03  -7 .5d2     x\t9");
	double x = 99;
	int i = 99;
	char text[8];
	(void)state;
	assert_int_equal(fw_rinex_double(&l, 2, 10, &x), FW_OK);
	assert_true(x == 1.5e-3);
	assert_int_equal(fw_rinex_double(&l, 16, 5, &x), FW_OK);
	assert_true(x == 50);
	assert_int_equal(fw_rinex_double(&l, 20, 4, &x), FW_EOF);
	assert_int_equal(fw_rinex_double(&l, 500, 4, &x), FW_EOF);
	assert_int_equal(fw_rinex_double(&l, 0, 6, &x), FW_ESYNTAX);
	assert_true(x == 50);
	assert_int_equal(fw_rinex_int(&l, 12, 4, &i), FW_OK);
	assert_int_equal(i, -7);
	assert_int_equal(fw_rinex_int(&l, 2, 6, &i), FW_ESYNTAX);
	const fw_line large = of("99999999999");
	assert_int_equal(fw_rinex_int(&large, 0, 11, &i), FW_ERANGE);
	assert_int_equal(i, -7);
	fw_rinex_text(&l, 20, 30, text, sizeof text);
	assert_string_equal(text, "x?9");
	fw_rinex_text(&l, 0, 30, text, 4);
	assert_string_equal(text, "ab ");
	fw_rinex_text(&l, 400, 30, text, sizeof text);
	assert_string_equal(text, "");
}

static void seconds(void **state)
{
	int64_t ns = 7;
	const fw_line l = of(" 59.9999999 60.0 61.0 -1.0");
	(void)state;
	assert_int_equal(fw_rinex_seconds(&l, 0, 11, &ns), FW_OK);
	assert_int_equal(ns, INT64_C(59999999900));
	assert_int_equal(fw_rinex_seconds(&l, 11, 5, &ns), FW_OK);
	assert_int_equal(ns, INT64_C(60000000000));
	assert_int_equal(fw_rinex_seconds(&l, 16, 5, &ns), FW_ERANGE);
	assert_int_equal(fw_rinex_seconds(&l, 21, 5, &ns), FW_ERANGE);
}

static int64_t moment(int year, int month, int day, int hour, int minute, int second, fw_rinex_time system)
{
	const fw_civil c = {year, month, day, hour, minute, second, 0};
	fw_time t;
	assert_true(fw_rinex_moment(&c, system, &t) >= 0);
	return t.ns / FW_NS_PER_S;
}

static void moments(void **state)
{
	const int64_t week_2347 = INT64_C(2347) * 604800; /* 2024-12-29 */
	const fw_civil wrong = {2024, 2, 30, 0, 0, 0, 0};
	fw_time t;
	(void)state;
	assert_int_equal(moment(2024, 12, 29, 0, 0, 0, FW_RINEX_GPS), week_2347);
	assert_int_equal(moment(24, 12, 29, 0, 0, 0, FW_RINEX_GAL), week_2347);
	assert_int_equal(moment(2024, 12, 28, 23, 59, 60, FW_RINEX_QZS), week_2347);
	assert_int_equal(moment(2024, 12, 29, 0, 0, 0, FW_RINEX_BDT), week_2347 + 14);
	assert_int_equal(moment(2024, 12, 29, 0, 0, 0, FW_RINEX_UTC), week_2347 + 18);
	assert_int_equal(moment(2024, 12, 28, 23, 59, 60, FW_RINEX_GLO),
	                 week_2347 + 18); /* no leap second: the full minute */
	/* the leap second at the end of 2016, after which UTC is 18 s behind */
	assert_int_equal(
	    moment(2017, 1, 1, 0, 0, 0, FW_RINEX_GLO) - moment(2016, 12, 31, 23, 59, 60, FW_RINEX_GLO), 1);
	assert_int_equal(moment(80, 1, 6, 0, 0, 0, FW_RINEX_GPS), 0);
	assert_int_equal(moment(99, 8, 22, 0, 0, 0, FW_RINEX_GPS), INT64_C(1024) * 604800);
	assert_int_equal(fw_rinex_moment(&wrong, FW_RINEX_GPS, &t), FW_EINVAL);
}

static void satellites(void **state)
{
	(void)state;
	assert_string_equal(fw_rinex_satellite('G', 5), "G05");
	assert_string_equal(fw_rinex_satellite('S', 23), "S123");
	assert_string_equal(fw_rinex_satellite('C', 63), "C63");
	assert_null(fw_rinex_satellite('G', 0));
	assert_null(fw_rinex_satellite('G', 64));
	assert_null(fw_rinex_satellite('S', 19));
	assert_null(fw_rinex_satellite('G', -1));
	assert_null(fw_rinex_satellite('Q', 1));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(kinds),      cmocka_unit_test(simple_lines), cmocka_unit_test(overlong_lines),
	    cmocka_unit_test(columns),    cmocka_unit_test(seconds),      cmocka_unit_test(moments),
	    cmocka_unit_test(satellites),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
