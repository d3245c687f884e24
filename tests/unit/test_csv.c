/* Writer and reader of tables and streams. Expected texts are written by hand after RFC 4180 and csv.h. The
 * round trip of random records is tests/property/test_records.c. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../random_record.h"
#include "formats/csv.h"
#include "furrow_baro.h"
#include "furrow_comment.h"
#include "furrow_dop.h"
#include "furrow_meta.h"
#include "furrow_obs.h"

static char bytes[8 << 20];
static memory out;
static fw_csv_writer writer;
static fw_csv_reader reader;
static fw_input input;
static fw_any_record record;
static fw_kind kind;

/* ---- Writing ---- */

static void begin_table(fw_kind k)
{
	out = (memory){bytes, sizeof bytes - 1, 0};
	fw_csv_begin_table(&writer, k, to_memory, &out);
}

static void begin_stream(void)
{
	out = (memory){bytes, sizeof bytes - 1, 0};
	fw_csv_begin_stream(&writer, to_memory, &out);
}

static void end_is(const char *text)
{
	assert_int_equal(fw_csv_end(&writer, true, 0), FW_OK);
	bytes[out.used] = '\0';
	assert_string_equal(bytes, text);
}

static void put_comment(const char *text)
{
	furrow_comment c = {.present = 7, .gps_week = 2345, .tow_s = 1};
	memcpy(&c.text, &text, sizeof text);
	fw_csv_put(&writer, FW_comment, &c);
}

static void table_of_observations(void **state)
{
	char sat[] = "G05", signal[] = "1C";
	furrow_obs o = {.present = 0x3fff,
	                .gps_week = 2345,
	                .tow_s = 482321.2,
	                .sat = sat,
	                .signal = signal,
	                .antenna = 1,
	                .glonass_channel = -7,
	                .pseudorange_m = 23456789.012,
	                .carrier_cyc = -123456.789,
	                .doppler_hz = 1234.5,
	                .cn0_dbhz = 47.25,
	                .lock_s = 65535,
	                .half_cycle = 1,
	                .rx_channel = 300};
	(void)state;
	begin_table(FW_obs);
	fw_csv_put(&writer, FW_obs, &o);
	o.present &= ~(INT64_C(1) << 5);
	o.tow_s = 482322;
	fw_csv_put(&writer, FW_obs, &o);
	o.present = 0;
	fw_csv_put(&writer, FW_obs, &o);
	fw_csv_put(&writer, FW_baro, &(furrow_baro){.present = 7}); /* passed over */
	fw_csv_meta(&writer, "pg", "nothing");
	end_is("gps_week,tow_s,sat,signal,antenna,glonass_channel,pseudorange_m,carrier_cyc,doppler_hz,cn0_"
	       "dbhz,lock_s,"
	       "half_cycle,smoothed,rx_channel\n"
	       "2345,482321.2,G05,1C,1,-7,23456789.0120,-123456.789,1234.5000,47.25,65535,1,0,300\n"
	       "2345,482322,G05,1C,1,,23456789.0120,-123456.789,1234.5000,47.25,65535,1,0,300\n"
	       ",,,,,,,,,,,,,\n");
	assert_int_equal(writer.rows, 3);
}

static void shortest_numbers_are_neat(void **state)
{
	furrow_dop d = {.present = 0xff,
	                .gps_week = 2345,
	                .tow_s = 0,
	                .n_sats = 12,
	                .pdop = 79 / 100.0,
	                .tdop = 102 / 100.0,
	                .hdop = 57 / 100.0,
	                .vdop = -0.0,
	                .hpl_m = 0.1F,
	                .vpl_m = 1e10F};
	(void)state;
	d.present |= 0x100;
	begin_table(FW_dop);
	fw_csv_put(&writer, FW_dop, &d);
	end_is("gps_week,tow_s,n_sats,pdop,tdop,hdop,vdop,hpl_m,vpl_m\n2345,0,12,0.79,1.02,0.57,0,0.1,"
	       "10000000000\n");
}

static void not_finite_is_absent(void **state)
{
	furrow_dop d = {.present = 0x1ff,
	                .tow_s = INFINITY,
	                .pdop = NAN,
	                .tdop = -INFINITY,
	                .hpl_m = NAN,
	                .vpl_m = INFINITY};
	(void)state;
	begin_table(FW_dop);
	fw_csv_put(&writer, FW_dop, &d);
	end_is("gps_week,tow_s,n_sats,pdop,tdop,hdop,vdop,hpl_m,vpl_m\n0,,0,,,0,0,,\n");
}

static void strings(void **state)
{
	static const char *const cases[][2] = {
	    {"plain text; 100 %", "plain text; 100 %"},
	    {" blanks ", " blanks "},
	    {"", ""},
	    {"a,b", "\"a,b\""},
	    {"say \"ah\"", "\"say \"\"ah\"\"\""},
	    {"\"", "\"\"\"\""},
	    {"two\r\nlines", "\"two\r\nlines\""},
	    {"tab\t", "\"tab\t\""},
	    {"M\xc3\xbcller \xe2\x82\xac", "M\xc3\xbcller \xe2\x82\xac"},
	    {"\xf0\x9f\x9b\xb0,", "\"\xf0\x9f\x9b\xb0,\""},
	    {"M\xfcller", "M?ller"},                     /* Latin-1 */
	    {"\xc3", "?"},                               /* cut short by the end */
	    {"\xe2\x82", "??"},                          /* the same */
	    {"\xc0\xaf\xed\xa0\x80\xf5\x80", "???????"}, /* overlong, surrogate, beyond U+10FFFF */
	};
	char expected[100];

	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		begin_table(FW_comment);
		put_comment(cases[i][0]);
		snprintf(expected, sizeof expected, "gps_week,tow_s,text\n2345,1,%s\n", cases[i][1]);
		end_is(expected);
	}
}

static void stream(void **state)
{
	furrow_baro b = {.present = 7, .gps_week = 2345, .tow_s = 0.5, .baro_height_m = 12.34567};
	char key[] = "cfg", value[] = "a=b,c";

	(void)state;
	begin_stream();
	fw_csv_meta(&writer, "pg", "tool=x cl=x \"two\nlines\"");
	fw_csv_put(&writer, FW_baro, &b);
	put_comment("hi, there");
	fw_csv_put(&writer, FW_baro, &b);
	fw_csv_put(&writer, FW_meta, &(furrow_meta){.present = 0xc, .key = key, .value = value});
	assert_int_equal(fw_csv_end(&writer, false, 4), FW_OK);
	bytes[out.used] = '\0';
	assert_string_equal(bytes, "#furrow-stream 1\n"
	                           "#pg tool=x cl=x \"two lines\"\n"
	                           "#baro,gps_week,tow_s,baro_height_m\n"
	                           "baro,2345,0.5,12.3457\n"
	                           "#comment,gps_week,tow_s,text\n"
	                           "comment,2345,1,\"hi, there\"\n"
	                           "baro,2345,0.5,12.3457\n"
	                           "#cfg a=b,c\n"
	                           "#end status=partial rows=3 skipped=4\n");
}

static char long_text[1 << 20];

/* The longest comment that a receiver can log fits; longer rows are refused as a whole. */
static void long_rows(void **state)
{
	(void)state;
	begin_stream();
	memset(long_text, '"', 65500);
	long_text[65500] = '\0';
	put_comment(long_text);
	for (size_t n = FW_CSV_LINE_MAX - 40; n < sizeof long_text;
	     n = n < FW_CSV_LINE_MAX + 9 ? n + 1 : 2 * n) {
		memset(long_text, 'x', n);
		long_text[n] = '\0';
		put_comment(long_text);
	}
	memset(long_text, '"', sizeof long_text - 1); /* quoting makes it longer still */
	put_comment(long_text);
	fw_csv_meta(&writer, "cfg", long_text);
	put_comment("last");
	assert_int_equal(fw_csv_end(&writer, true, 0), FW_OK);

	/* "comment,2345,1," and the line's end leave room for 16 bytes less than a line */
	assert_int_equal(writer.rows, 1 + (40 - 16 + 1) + 1);
	fw_input_open_memory(&input, bytes, out.used);
	fw_csv_begin_read(&reader, &input, FW_RECORD_COUNT);
	for (uint64_t i = 0; i < writer.rows; i++) {
		assert_int_equal(fw_csv_read(&reader, &kind, &record), FW_OK);
		assert_int_equal(kind, FW_comment);
	}
	assert_int_equal(fw_csv_read(&reader, &kind, &record), FW_EOF);
	assert_int_equal(writer.refused, 50 + 2 - 25 + 2);
}

static fw_status failing(void *context, const void *text, size_t n)
{
	(void)text;
	(void)n;
	++*(int *)context;
	return FW_EIO;
}

static void failing_output(void **state)
{
	int calls = 0;

	(void)state;
	fw_csv_begin_stream(&writer, failing, &calls);
	for (int i = 0; i < 100000; i++)
		put_comment("text");
	assert_int_equal(writer.status, FW_EIO);
	assert_int_equal(fw_csv_flush(&writer), FW_EIO);
	assert_int_equal(fw_csv_end(&writer, true, 0), FW_EIO);
	assert_int_equal(calls, 1);
}

/* ---- Reading ---- */

static void read_from(const char *text, size_t n, fw_kind wanted)
{
	fw_input_open_memory(&input, text, n);
	fw_csv_begin_read(&reader, &input, wanted);
}

static void read_text(const char *text)
{
	read_from(text, strlen(text), FW_RECORD_COUNT);
}

static void expect(fw_status status)
{
	assert_int_equal(fw_csv_read(&reader, &kind, &record), status);
}

static void expect_baro(double height_m)
{
	furrow_baro b;

	expect(FW_OK);
	assert_int_equal(kind, FW_baro);
	memcpy(&b, &record, sizeof b);
	assert_true(b.baro_height_m == height_m);
}

static void expect_problem(uint64_t line, int field, const char *column, const char *reason)
{
	expect(FW_ESYNTAX);
	assert_int_equal(reader.problem.line, line);
	assert_int_equal(reader.problem.field, field);
	assert_string_equal(reader.problem.column, column);
	assert_string_equal(reader.problem.reason, reason);
}

static void expect_meta(const char *key, const char *value)
{
	furrow_meta m;

	expect(FW_OK);
	assert_int_equal(kind, FW_meta);
	memcpy(&m, &record, sizeof m);
	assert_string_equal(m.key, key);
	assert_string_equal(m.value, value);
}

static void columns_in_any_order(void **state)
{
	furrow_obs o;

	(void)state;
	read_text("\xef\xbb\xbfsignal,new,tow_s,\"sat\",cn0_dbhz,gps_week,other\r\n"
	          "\r\n"
	          "\"1C\",7,482321.2,\"G\"\"5,\",+4.725e1,,\r\n"
	          "2W,,,,,2345,9");
	expect(FW_OK);
	assert_int_equal(kind, FW_obs);
	memcpy(&o, &record, sizeof o);
	assert_int_equal(o.present, 1 << 1 | 1 << 2 | 1 << 3 | 1 << 9);
	assert_int_equal(o.gps_week, 0);
	assert_true(o.tow_s == 482321.2 && o.cn0_dbhz == 47.25);
	assert_string_equal(o.sat, "G\"5,");
	assert_string_equal(o.signal, "1C");
	expect(FW_OK);
	memcpy(&o, &record, sizeof o);
	assert_int_equal(o.present, 1 << 0 | 1 << 3);
	assert_int_equal(o.gps_week, 2345);
	assert_string_equal(o.sat, "");
	expect(FW_EOF);
	expect(FW_EOF);
	assert_int_equal(reader.unknown_columns, 2);
	assert_string_equal(reader.unknown, "new");
	assert_int_equal(reader.rows, 2);
	assert_int_equal(reader.lost, 0);
}

/* A bad row costs itself, and the message says where and why. */
static void bad_rows(void **state)
{
	static const char text[] = "gps_week,tow_s,antenna,pseudorange_m,sat\n" /* line 1 */
	                           "2345,1,0,2.5\n"
	                           "2345,1,0,2.5,G05,\n"
	                           "2345,1,0,abc,G05\n"
	                           "2345,1,0,2,5,G05\n" /* a decimal comma */
	                           "2345,1,128,2.5,G05\n"
	                           "2345,1,-129,2.5,G05\n"
	                           "2345,1,0,2.5,\"two\nlines\" here\n" /* lines 8 and 9 */
	                           "2345,1,1.0,2.5,G05\n"
	                           "gps_week,tow_s,antenna,pseudorange_m,sat\n"
	                           "2345,1,0,1e999,G05\n"
	                           "2345,1,0,nan,G05\n"
	                           "2345,1,0,2.5,G\0005\n"
	                           "2345,1,0,2.5,G05\n";
	(void)state;
	read_from(text, sizeof text - 1, FW_RECORD_COUNT);
	expect_problem(2, 0, "", "fewer fields than columns");
	expect_problem(3, 6, "", "more fields than columns");
	expect_problem(4, 4, "pseudorange_m", "not a number");
	expect_problem(5, 6, "", "more fields than columns");
	expect_problem(6, 3, "antenna", "number out of range");
	expect_problem(7, 3, "antenna", "number out of range");
	expect_problem(8, 0, "", "text behind a closing quote");
	expect_problem(9, 1, "gps_week", "not a whole number");
	expect_problem(10, 3, "antenna", "not a whole number");
	expect_problem(11, 1, "gps_week", "not a whole number");
	expect_problem(12, 4, "pseudorange_m", "number out of range");
	expect_problem(13, 4, "pseudorange_m", "not a number");
	expect_problem(14, 0, "", "a NUL byte");
	expect(FW_OK);
	expect(FW_EOF);
	assert_int_equal(reader.rows, 1);
	assert_int_equal(reader.lost, 13);
}

static void header_problem(const char *text, const char *reason)
{
	read_text(text);
	expect(FW_EUNKNOWN);
	assert_string_equal(reader.problem.reason, reason);
	assert_int_equal(reader.problem.line, 1);
	expect(FW_EUNKNOWN);
}

static void headers(void **state)
{
	static const char baro[] = "gps_week,tow_s,baro_height_m\n1,2,3\n",
	                  levels[] = "tow_s,hpl_m,vpl_m\n1,2,3\n";
	char many[FW_CSV_FIELDS_MAX + 1] = "";

	(void)state;
	header_problem("2345,1,12.5\n2345,2,12.5\n", "no line of column names that fit a type of record");
	header_problem("gps_week,tow_s\n", "no line of column names that fit a type of record");
	header_problem("gps_week,baro_height_m,tow_s,baro_height_m\n1,2,3,4\n", "a column that comes twice");
	header_problem("gps_week,tow_s,hpl_m,vpl_m\n1,2,3,4\n", "these columns fit several types of record");
	header_problem("#furrow-stream 2\n", "not a stream of a version that furrow knows");
	memset(many, ',', FW_CSV_FIELDS_MAX);
	header_problem(many, "too many columns");
	read_text("");
	expect(FW_EOF);
	read_from(baro, sizeof baro - 1, FW_imu);
	expect(FW_EUNKNOWN);
	assert_string_equal(reader.problem.reason, "none of the columns that are wanted here");
	read_from(levels, sizeof levels - 1, FW_pl);
	expect(FW_OK);
	assert_int_equal(kind, FW_pl);
}

/* Every table that furrow writes tells its type; those at an event are read as the type of equal columns. */
static void own_tables_are_recognised(void **state)
{
	(void)state;
	for (fw_kind k = 0; k < FW_RECORD_COUNT; k++) {
		const char *name = fw_record_type_of(k)->name;
		begin_table(k);
		fw_record_clear(k, &record);
		record.head.present = 1;
		fw_csv_put(&writer, k, &record);
		assert_int_equal(fw_csv_end(&writer, true, 0), FW_OK);
		read_from(bytes, out.used, FW_RECORD_COUNT);
		expect(FW_OK);
		const fw_kind plain =
		    strncmp(name, "event_", 6) == 0 ? fw_record_find(name + 6, strlen(name + 6)) : k;
		assert_int_equal(kind, plain);
		assert_int_equal(reader.table, plain);
		read_from(bytes, out.used, k);
		expect(FW_OK);
		assert_int_equal(kind, k);
	}
}

static const char whole_stream[] = "#furrow-stream 1\n"
                                   "#pg tool=x cl=x \"a, b\n"
                                   "#baro,gps_week,new,baro_height_m\n"
                                   "baro,2345,,1.5\n"
                                   "#comment,gps_week,tow_s,text\n"
                                   "#gap\n"
                                   "comment,2345,1,\"two\nlines\"\n"
                                   "baro,2345,9,2.5\n"
                                   "#end status=complete rows=3 skipped=0\n";

static void reads_a_stream(void **state)
{
	furrow_comment c;

	(void)state;
	read_text(whole_stream);
	expect_meta("pg", "tool=x cl=x \"a, b");
	expect_baro(1.5);
	expect_meta("gap", "");
	expect(FW_OK);
	assert_int_equal(kind, FW_comment);
	memcpy(&c, &record, sizeof c);
	assert_string_equal(c.text, "two\nlines");
	expect_baro(2.5);
	expect(FW_EOF);
	assert_true(reader.stream && !reader.partial);
	assert_int_equal(reader.rows, 3);
	assert_int_equal(reader.unknown_columns, 1);
}

/* Cut at every byte: the rows that are whole, then FW_ETRUNCATED. Half a first line says nothing. */
static void cut_streams(void **state)
{
	static const size_t ends[] = {17, 39, 72, 87, 116, 121, 148, 164}; /* of the lines */
	const size_t n = strlen(whole_stream);

	(void)state;
	for (size_t cut = 0; cut < n; cut++) {
		int handed_out = 0, expected = 0;
		read_from(whole_stream, cut, FW_RECORD_COUNT);
		fw_status status;
		while ((status = fw_csv_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX)
			handed_out += status == FW_OK;
		assert_int_equal(status, cut == 0 ? FW_EOF : cut < 16 ? FW_EUNKNOWN : FW_ETRUNCATED);
		for (int i = 0; i < 8; i++) /* lines 2, 4, 6, 7 and 8 hold something */
			expected += cut >= ends[i] && i != 0 && i != 2 && i != 4;
		assert_int_equal(handed_out, expected);
	}
}

static void bad_streams(void **state)
{
	(void)state;
	read_text("#furrow-stream 1\r\n"
	          "baro,1,2,3\r\n" /* line 2 */
	          "#baro,gps_week,tow_s,baro_height_m\r\n"
	          "barometer,1,2,3\r\n"
	          "baro,1,2\r\n"
	          "baro,1,x,3\r\n"
	          "#baro,baro_height_m\r\n"
	          "baro,7\r\n"
	          "#end status=partial rows=1 skipped=4\r\n"
	          "baro,8\r\n" /* line 10 */
	          "#furrow-stream 1\r\n"
	          "baro,9\r\n"
	          "#baro,tow_s,tow_s\r\n"
	          "#furrow-stream 1\r\n");
	expect_problem(2, 1, "", "a type of record that furrow does not know or that was not announced");
	expect_problem(4, 1, "", "a type of record that furrow does not know or that was not announced");
	expect_problem(5, 0, "", "fewer fields than columns");
	expect_problem(6, 3, "tow_s", "not a number");
	expect_baro(7);
	assert_false(reader.partial);
	expect_problem(10, 0, "", "a row behind the stream's end");
	assert_true(reader.partial);
	expect_problem(12, 1, "", "a type of record that furrow does not know or that was not announced");
	expect_problem(13, 3, "tow_s", "a column that comes twice");
	expect_problem(14, 0, "", "a stream begins before the one before it has ended");
	expect(FW_ETRUNCATED);
	expect(FW_ETRUNCATED);
}

/* A line of 1 MB, and a quote that nobody closes: one line lost each, and nothing behind it. */
static void endless_lines(void **state)
{
	size_t n = (size_t)snprintf(bytes, sizeof bytes, "gps_week,tow_s,baro_height_m\n1,2,3\n");

	(void)state;
	memset(bytes + n, '7', 1000000);
	n += 1000000;
	n += (size_t)snprintf(bytes + n, 100, "\n1,2,4\n1,\"2,5\n");
	for (int i = 0; i < 100000; i++)
		n += (size_t)snprintf(bytes + n, 100, "1,2,6\n");
	read_from(bytes, n, FW_RECORD_COUNT);
	expect_baro(3);
	expect_problem(3, 0, "", "line too long");
	expect_baro(4);
	expect_problem(5, 0, "", "a quote that is not closed");
	for (int i = 0; i < 100000; i++)
		expect_baro(6);
	expect(FW_EOF);
	assert_int_equal(reader.line, 100006);
}

static void quote_open_at_the_end(void **state)
{
	(void)state;
	read_text("gps_week,tow_s,text\n1,2,\"ab\n1,2,cd\n1,2,ef");
	expect_problem(2, 0, "", "a quote that is not closed");
	expect(FW_OK);
	expect(FW_OK);
	expect(FW_EOF);
}

/* Any bytes at all: no crash, an end. */
static void noise(void **state)
{
	static const char alphabet[] = "#,\"\n\r\0 0123456789.-ebarobaro,gps_week,tow_s";
	char text[600];
	fw_random r;
	fw_status status;

	(void)state;
	fw_random_init(&r, 7);
	for (int i = 0; i < 3000; i++) {
		size_t n = (size_t)snprintf(text, sizeof text,
		                            i % 2 ? "#furrow-stream 1\n#baro,gps_week,tow_s\n"
		                                  : "tow_s,baro_height_m\n");
		while (n < sizeof text)
			text[n++] = alphabet[fw_random_below(&r, sizeof alphabet - 1)];
		read_from(text, fw_random_below(&r, sizeof text), FW_RECORD_COUNT);
		while ((status = fw_csv_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX)
			;
		assert_true(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EUNKNOWN);
	}
}

/* A pipe hands out what it has: rows that arrive in pieces of 1 to 7 bytes. */
static void through_a_pipe(void **state)
{
	const size_t n = strlen(whole_stream);
	char path[32];
	int ends[2];

	(void)state;
	assert_int_equal(pipe(ends), 0);
	const pid_t child = fork();
	if (child == 0) {
		for (size_t at = 0, step = 1; at < n; at += step, step = step % 7 + 1)
			if (write(ends[1], whole_stream + at, step < n - at ? step : n - at) < 0)
				_exit(1);
		_exit(0);
	}
	close(ends[1]);
	snprintf(path, sizeof path, "/dev/fd/%d", ends[0]);
	assert_int_equal(fw_input_open(&input, path), FW_OK);
	fw_csv_begin_read(&reader, &input, FW_RECORD_COUNT);
	for (int i = 0; i < 5; i++)
		expect(FW_OK);
	expect(FW_EOF);
	fw_input_close(&input);
	close(ends[0]);
	waitpid(child, NULL, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(table_of_observations),
	    cmocka_unit_test(shortest_numbers_are_neat),
	    cmocka_unit_test(not_finite_is_absent),
	    cmocka_unit_test(strings),
	    cmocka_unit_test(stream),
	    cmocka_unit_test(long_rows),
	    cmocka_unit_test(failing_output),
	    cmocka_unit_test(columns_in_any_order),
	    cmocka_unit_test(bad_rows),
	    cmocka_unit_test(headers),
	    cmocka_unit_test(own_tables_are_recognised),
	    cmocka_unit_test(reads_a_stream),
	    cmocka_unit_test(cut_streams),
	    cmocka_unit_test(bad_streams),
	    cmocka_unit_test(endless_lines),
	    cmocka_unit_test(quote_open_at_the_end),
	    cmocka_unit_test(noise),
	    cmocka_unit_test(through_a_pipe),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
