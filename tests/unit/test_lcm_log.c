/* Writer and reader of LCM event logs. The layout of an event is written out by hand from liblcm's
 * eventlog.c; PyPI's lcm reads our logs in tests/oracle. The round trip of random records is
 * tests/property/test_records.c. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../random_record.h"
#include "formats/lcm_log.h"
#include "furrow_baro.h"
#include "furrow_comment.h"
#include "furrow_meta.h"

enum { EVENTS = 10000 };

static char bytes[8 << 20];
static memory out;
static fw_lcm_writer writer;
static fw_lcm_reader reader;
static fw_input input;
static fw_any_record record;
static fw_kind kind;

static void begin(void)
{
	out = (memory){bytes, sizeof bytes, 0};
	fw_lcm_begin(&writer, to_memory, &out);
}

static void put_baro(double height_m)
{
	/* 100 s into week 2345 less 18 leap seconds: 2024-12-15T00:01:22Z, in Unix time 1734220882. */
	furrow_baro b = {.present = 7, .gps_week = 2345, .tow_s = 100.25, .baro_height_m = height_m};
	fw_lcm_put(&writer, FW_baro, &b);
}

static void put_comment(const char *text)
{
	furrow_comment c = {.present = 4};
	memcpy(&c.text, &text, sizeof text);
	fw_lcm_put(&writer, FW_comment, &c);
}

static void end(void)
{
	assert_int_equal(fw_lcm_end(&writer, true, 0), FW_OK);
}

static void read_bytes(const void *from, size_t n)
{
	fw_input_open_memory(&input, from, n);
	fw_lcm_begin_read(&reader, &input);
}

static void expect(fw_status status)
{
	assert_int_equal(fw_lcm_read(&reader, &kind, &record), status);
}

static void expect_baro(double height_m)
{
	furrow_baro b;

	expect(FW_OK);
	assert_int_equal(kind, FW_baro);
	memcpy(&b, &record, sizeof b);
	assert_true(b.baro_height_m == height_m);
}

static void expect_loss(uint64_t offset, const char *reason)
{
	expect(FW_ESYNTAX);
	assert_int_equal(reader.lost_offset, offset);
	assert_string_equal(reader.reason, reason);
}

/* Length of the baro events here: header, "FURROW_BARO", fingerprint, mask, week, two doubles. */
enum { BARO = 28 + 11 + 8 + 8 + 4 + 8 + 8 };

static void event_layout(void **state)
{
	static const unsigned char expected[] = {
	    0xed, 0xa1, 0xda, 0x01, 0,    0,    0,    0,    0,   0,   0,   1, /* event number */
	    0x00, 0x06, 0x29, 0x43, 0xc3, 0xa6, 0x09, 0x10,                   /* 1734220882250000 */
	    0,    0,    0,    11,   0,    0,    0,    36,                     /* lengths */
	    'F',  'U',  'R',  'R',  'O',  'W',  '_',  'B',  'A', 'R', 'O',
	};
	(void)state;
	begin();
	put_baro(1);
	put_baro(2);
	assert_int_equal(fw_lcm_flush(&writer), FW_OK);
	assert_int_equal(out.used, 2 * BARO);
	assert_memory_equal(bytes + BARO, expected, sizeof expected);
}

static void carries_records_and_provenance(void **state)
{
	furrow_comment c;
	furrow_meta m;

	(void)state;
	begin();
	fw_lcm_meta(&writer, "pg", "tool=x");
	put_baro(1.23456); /* rounded as in CSV */
	put_comment("a, b");
	end();
	assert_int_equal(writer.rows, 2);
	read_bytes(bytes, out.used);
	expect(FW_OK);
	assert_int_equal(kind, FW_meta);
	memcpy(&m, &record, sizeof m);
	assert_string_equal(m.key, "pg");
	assert_string_equal(m.value, "tool=x");
	expect_baro(1.2346);
	expect(FW_OK);
	assert_int_equal(kind, FW_comment);
	memcpy(&c, &record, sizeof c);
	assert_string_equal(c.text, "a, b");
	expect(FW_EOF);
	expect(FW_EOF);
	assert_int_equal(reader.rows, 2);
	assert_false(reader.partial);

	begin();
	assert_int_equal(fw_lcm_end(&writer, false, 3), FW_OK);
	read_bytes(bytes, out.used);
	expect(FW_EOF);
	assert_true(reader.partial);
}

static int64_t timestamp(size_t at)
{
	uint64_t t = 0;
	for (int i = 0; i < 8; i++)
		t = t << 8 | (unsigned char)bytes[at + 12 + (size_t)i];
	return (int64_t)t;
}

/* What has no time of its own has a neighbour's: no player shall wait from 1970 to the flight. */
static void timestamps(void **state)
{
	(void)state;
	begin();
	put_comment("first");
	assert_int_equal(fw_lcm_flush(&writer), FW_OK);
	assert_int_equal(out.used, 0); /* waits */
	const size_t first = writer.used;
	put_baro(1);
	put_comment("last");
	assert_int_equal(fw_lcm_flush(&writer), FW_OK);
	assert_int_equal(timestamp(0), 1734220882250000);
	assert_int_equal(timestamp(first), 1734220882250000);
	assert_int_equal(timestamp(first + BARO), 1734220882250000);

	begin(); /* nothing ever has a time */
	for (int i = 0; i < 10000; i++)
		put_comment("x");
	end();
	assert_int_equal(timestamp(0), 0);
	read_bytes(bytes, out.used);
	for (int i = 0; i < 10000; i++)
		expect(FW_OK);
	expect(FW_EOF);
}

static void cut_at_every_byte(void **state)
{
	(void)state;
	begin();
	fw_lcm_meta(&writer, "pg", "tool=x");
	const size_t first = writer.used;
	for (int i = 0; i < 3; i++)
		put_baro(i);
	end();
	for (size_t cut = 0; cut < out.used; cut++) {
		const size_t whole = cut < first ? 0 : cut < first + 3 * BARO ? 1 + (cut - first) / BARO : 4;
		read_bytes(bytes, cut);
		for (size_t i = 0; i < whole; i++)
			expect(FW_OK);
		expect(cut == 0 ? FW_EOF : FW_ETRUNCATED);
		assert_int_equal(reader.lost, 0);
	}
}

/* A log that no furrow tool began ends where it ends. */
static void log_without_provenance(void **state)
{
	(void)state;
	begin();
	put_baro(1);
	assert_int_equal(fw_lcm_flush(&writer), FW_OK);
	read_bytes(bytes, out.used);
	expect_baro(1);
	expect(FW_EOF);
}

static void set_u32(size_t at, uint32_t x)
{
	for (size_t i = 0; i < 4; i++)
		bytes[at + i] = (char)(x >> (24 - 8 * i));
}

/* Wrong lengths of one event cost that one event. */
static void wrong_lengths(void **state)
{
	static const uint32_t wrong[] = {
	    0, 1, 35, 37, 1000, 65535, 1 << 20, (1 << 20) + 1, 0x7fffffff, 0x80000000, 0xffffffff};

	(void)state;
	for (size_t i = 0; i < 2 * sizeof wrong / sizeof *wrong; i++) {
		begin();
		for (int k = 0; k < 100; k++)
			put_baro(k);
		end();
		set_u32(50 * BARO + (i % 2 ? 20 : 24), wrong[i / 2]);
		read_bytes(bytes, out.used);
		for (int k = 0; k < 50; k++)
			expect_baro(k);
		expect(FW_ESYNTAX);
		assert_int_equal(reader.lost_offset, 50 * BARO);
		for (int k = 51; k < 100; k++)
			expect_baro(k);
		expect(FW_EOF);
		assert_int_equal(reader.lost, 1);
	}
}

/* Any byte of any event inverted: that event is lost, or comes with other content, and no other. */
static void damaged_bytes(void **state)
{
	(void)state;
	begin();
	for (int k = 0; k < 5; k++)
		put_baro(k);
	assert_int_equal(fw_lcm_flush(&writer), FW_OK);
	for (size_t at = 0; at < out.used; at++) {
		uint64_t good = 0;
		fw_status status;
		bytes[at] = (char)~bytes[at];
		read_bytes(bytes, out.used);
		while ((status = fw_lcm_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX)
			good += status == FW_OK;
		/* a channel's name may come out as one that furrow does not know */
		assert_int_equal(good + reader.lost + reader.foreign + (status == FW_ETRUNCATED), 5);
		assert_true(good >= 4);
		bytes[at] = (char)~bytes[at];
	}
}

static void losses_say_why(void **state)
{
	(void)state;
	begin();
	for (int k = 0; k < 8; k++)
		put_baro(k);
	end();
	bytes[1 * BARO] = 0;             /* sync */
	set_u32(2 * BARO + 24, 1 << 21); /* length */
	bytes[4 * BARO + 28 + 11] ^= 1;  /* fingerprint */
	set_u32(6 * BARO + 24, 1 << 20);
	memcpy(bytes + out.used, "rubbish", 7);
	read_bytes(bytes, out.used + 7);
	expect_baro(0);
	expect_loss(1 * BARO, "no event where one should begin");
	expect_loss(2 * BARO, "an event with an impossible length");
	expect_baro(3);
	expect_loss(4 * BARO, "an event that is not what its channel says");
	expect_baro(5);
	expect_loss(6 * BARO, "an event that reaches beyond the end of the log");
	expect_baro(7);
	expect_loss(out.used, "no event where one should begin");
	expect(FW_EOF);
	assert_int_equal(reader.lost, 5);
}

/* Other people's channels are passed over, whatever they carry. */
static void foreign_channels(void **state)
{
	static char event[28 + 5 + 1000] = "\xed\xa1\xda\x01";

	(void)state;
	begin();
	put_baro(1);
	assert_int_equal(fw_lcm_flush(&writer), FW_OK);
	event[23] = 5;
	event[26] = 1000 / 256;
	event[27] = (char)(1000 % 256);
	memcpy(event + 28, "OTHER", 5);
	assert_int_equal(to_memory(&out, event, sizeof event), FW_OK);
	assert_int_equal(to_memory(&out, event, sizeof event), FW_OK);
	put_baro(2);
	assert_int_equal(fw_lcm_flush(&writer), FW_OK);
	assert_int_equal(to_memory(&out, event, sizeof event), FW_OK);
	read_bytes(bytes, out.used);
	expect_baro(1);
	expect_baro(2);
	expect(FW_EOF);
	assert_int_equal(reader.foreign, 3);
	assert_int_equal(reader.lost, 0);
}

static char long_text[FW_LCM_WRITE_MAX + 1];

static void long_records(void **state)
{
	(void)state;
	begin();
	memset(long_text, 'x', FW_LCM_WRITE_MAX);
	put_comment(long_text);
	assert_int_equal(writer.refused, 1);
	long_text[65532] = '\0';
	put_comment(long_text);
	end();
	assert_int_equal(writer.refused, 1);
	read_bytes(bytes, out.used);
	expect(FW_OK);
	expect(FW_EOF);
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
	fw_lcm_begin(&writer, failing, &calls);
	for (int i = 0; i < 10000; i++)
		put_baro(i);
	assert_int_equal(fw_lcm_end(&writer, true, 0), FW_EIO);
	assert_int_equal(calls, 1);
}

/* Syncs and headers everywhere: linear time, an end. */
static void noise(void **state)
{
	static const char sync[] = "\xed\xa1\xda\x01";
	const size_t hostile = 3 << 20;
	fw_random r;
	fw_status status;

	(void)state;
	fw_random_init(&r, 3);
	for (int i = 0; i < 200; i++) {
		begin();
		for (int k = 0; k < 20; k++)
			put_baro(k);
		end();
		for (int k = 0; k < 40; k++) {
			const size_t at = fw_random_below(&r, out.used - 40);
			if (k % 2)
				memcpy(bytes + at, sync, 4);
			set_u32(at + fw_random_below(&r, 36),
			        (uint32_t)(fw_random_u64(&r) >> fw_random_below(&r, 64)));
		}
		read_bytes(bytes, out.used);
		while ((status = fw_lcm_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX)
			;
		assert_true(status == FW_EOF || status == FW_ETRUNCATED);
	}
	/* Each sync claims an event of 1 MiB that would hold all the others. */
	for (size_t at = 0; at + 28 <= hostile; at += 28) {
		memset(bytes + at, 0, 28);
		memcpy(bytes + at, sync, 4);
		set_u32(at + 20, 7);
		set_u32(at + 24, FW_LCM_DATA_MAX - (uint32_t)at % 1000);
	}
	read_bytes(bytes, hostile);
	while ((status = fw_lcm_read(&reader, &kind, &record)) == FW_ESYNTAX)
		;
	assert_int_equal(status, FW_ETRUNCATED);
}

/* All of them, in pieces that end anywhere. liblcm's own reader loses every second event on a pipe. */
static void through_a_pipe(void **state)
{
	char path[32];
	int ends[2];

	(void)state;
	begin();
	for (int k = 0; k < EVENTS; k++)
		put_baro(k);
	end();
	assert_int_equal(pipe(ends), 0);
	const pid_t child = fork();
	if (child == 0) {
		for (size_t at = 0; at < out.used;) {
			const size_t step = 1 + at % 4999, left = out.used - at;
			const ssize_t n = write(ends[1], bytes + at, step < left ? step : left);
			if (n <= 0)
				_exit(1);
			at += (size_t)n;
		}
		_exit(0);
	}
	close(ends[1]);
	snprintf(path, sizeof path, "/dev/fd/%d", ends[0]);
	assert_int_equal(fw_input_open(&input, path), FW_OK);
	fw_lcm_begin_read(&reader, &input);
	for (int k = 0; k < EVENTS; k++)
		expect_baro(k);
	expect(FW_EOF);
	assert_int_equal(reader.lost, 0);
	fw_input_close(&input);
	close(ends[0]);
	waitpid(child, NULL, 0);
}

/* An event is handed on when it is there, not when the next one comes. */
static void live(void **state)
{
	char path[32];
	int ends[2];

	(void)state;
	begin();
	put_baro(1);
	assert_int_equal(fw_lcm_flush(&writer), FW_OK);
	assert_int_equal(pipe(ends), 0);
	assert_int_equal(write(ends[1], bytes, out.used), out.used);
	snprintf(path, sizeof path, "/dev/fd/%d", ends[0]);
	assert_int_equal(fw_input_open(&input, path), FW_OK);
	fw_lcm_begin_read(&reader, &input);
	alarm(5);
	expect_baro(1);
	alarm(0);
	fw_input_close(&input);
	close(ends[0]);
	close(ends[1]);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(event_layout),
	    cmocka_unit_test(carries_records_and_provenance),
	    cmocka_unit_test(timestamps),
	    cmocka_unit_test(cut_at_every_byte),
	    cmocka_unit_test(log_without_provenance),
	    cmocka_unit_test(wrong_lengths),
	    cmocka_unit_test(damaged_bytes),
	    cmocka_unit_test(losses_say_why),
	    cmocka_unit_test(foreign_channels),
	    cmocka_unit_test(long_records),
	    cmocka_unit_test(failing_output),
	    cmocka_unit_test(noise),
	    cmocka_unit_test(through_a_pipe),
	    cmocka_unit_test(live),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
