/* 10,000 random records of every type, written as a stream, read, written as an LCM log and read again: twice
 * the same as the rounded original, bit for bit. Deterministic; about 5 s. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../random_record.h"
#include "formats/csv.h"
#include "formats/lcm_log.h"

enum { RECORDS = 10000, PER_ROUND = 50 };

static char csv_bytes[16 << 20], lcm_bytes[16 << 20];
static fw_csv_writer csv_writer;
static fw_csv_reader csv_reader;
static fw_lcm_writer lcm_writer;
static fw_lcm_reader lcm_reader;
static fw_input input;

/* The n-th record of a round: all types in turn. */
static fw_kind nth(fw_random *r, int n, fw_any_record *record)
{
	const fw_kind kind = (fw_kind)(n % FW_RECORD_COUNT);

	if (kind == FW_meta) { /* has a form of its own in streams; see test_csv.c */
		random_record(r, FW_mag, record);
		return FW_mag;
	}
	random_record(r, kind, record);
	return kind;
}

static void check(fw_random *r, int n, fw_kind kind, const fw_any_record *read)
{
	fw_any_record expected;

	assert_int_equal(kind, nth(r, n, &expected));
	fw_record_round(kind, &expected);
	const int column = first_difference(kind, &expected, read);
	if (column >= 0)
		fail_msg("%s: record %d, column %s", fw_record_type_of(kind)->name, n,
		         fw_record_type_of(kind)->columns[column].name);
}

static void one_round(uint64_t seed)
{
	const int n = PER_ROUND * FW_RECORD_COUNT;
	memory csv = {csv_bytes, sizeof csv_bytes, 0}, lcm = {lcm_bytes, sizeof lcm_bytes, 0};
	fw_any_record record;
	fw_random r;
	fw_kind kind;

	fw_random_init(&r, seed);
	fw_csv_begin_stream(&csv_writer, to_memory, &csv);
	for (int i = 0; i < n; i++) {
		kind = nth(&r, i, &record);
		fw_csv_put(&csv_writer, kind, &record);
	}
	assert_int_equal(fw_csv_end(&csv_writer, true, 0), FW_OK);

	fw_random_init(&r, seed);
	fw_input_open_memory(&input, csv.bytes, csv.used);
	fw_csv_begin_read(&csv_reader, &input, FW_RECORD_COUNT);
	fw_lcm_begin(&lcm_writer, to_memory, &lcm);
	for (int i = 0; i < n; i++) {
		assert_int_equal(fw_csv_read(&csv_reader, &kind, &record), FW_OK);
		check(&r, i, kind, &record);
		fw_lcm_put(&lcm_writer, kind, &record);
	}
	assert_int_equal(fw_csv_read(&csv_reader, &kind, &record), FW_EOF);
	assert_int_equal(fw_lcm_end(&lcm_writer, true, 0), FW_OK);

	fw_random_init(&r, seed);
	fw_input_open_memory(&input, lcm.bytes, lcm.used);
	fw_lcm_begin_read(&lcm_reader, &input);
	for (int i = 0; i < n; i++) {
		assert_int_equal(fw_lcm_read(&lcm_reader, &kind, &record), FW_OK);
		check(&r, i, kind, &record);
	}
	assert_int_equal(fw_lcm_read(&lcm_reader, &kind, &record), FW_EOF);
	assert_int_equal(csv_writer.refused + csv_reader.lost + lcm_writer.refused + lcm_reader.lost, 0);
}

static void round_trip(void **state)
{
	(void)state;
	for (uint64_t seed = 0; seed < RECORDS / PER_ROUND; seed++)
		one_round(seed);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(round_trip)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
