/* LCM logs. What was read, written and read again, is the same log; and as a stream it has as many rows. */
#include <string.h>

#include "../random_record.h"
#include "formats/csv.h"
#include "formats/lcm_log.h"

#include "record_check.h"

enum { LOG_MOST = 1 << 20 };

static char first_log[LOG_MOST], second_log[LOG_MOST], text[LOG_MOST];
static fw_lcm_writer writer;
static fw_csv_writer stream;
static fw_any_record record;
static fw_input in;

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	memory m = {(char *)data, FUZZ_ROOM, 0};

	fw_lcm_begin(&writer, to_memory, &m);
	for (size_t n = (size_t)fw_random_below(random, 3); n > 0; n--)
		fw_lcm_meta(&writer, random_string(random), "tool=x");
	for (size_t n = 1 + (size_t)fw_random_below(random, 10); n > 0; n--) {
		const fw_kind kind = (fw_kind)fw_random_below(random, FW_meta);
		random_record(random, kind, &record);
		fw_lcm_put(&writer, kind, &record);
	}
	(void)!fw_lcm_end(&writer, true, 0);
	return m.used;
}

static uint32_t load_big(const uint8_t *p)
{
	return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static void store_big(uint8_t *p, size_t v)
{
	for (int i = 0; i < 4; i++)
		p[i] = (uint8_t)(v >> (24 - 8 * i));
}

static size_t find_event(const uint8_t *data, size_t size, size_t at)
{
	static const uint8_t sync[] = {0xed, 0xa1, 0xda, 0x01};
	const uint8_t *p = at < size ? memmem(data + at, size - at, sync, sizeof sync) : NULL;
	return p != NULL ? (size_t)(p - data) : size;
}

/* Lengths that lead from each event to the next. */
static void repair(uint8_t *data, size_t size)
{
	for (size_t at = find_event(data, size, 0); at < size;) {
		const size_t next = find_event(data, size, at + 4), n = next - at;
		if (n >= FW_LCM_HEADER) {
			size_t name = load_big(data + at + 20);
			if (name > n - FW_LCM_HEADER)
				name = n - FW_LCM_HEADER;
			store_big(data + at + 20, name);
			store_big(data + at + 24, n - FW_LCM_HEADER - name);
		}
		at = next;
	}
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	fw_random r;
	fw_random_init(&r, seed);
	const size_t at = find_event(data, size, (size_t)fw_random_below(&r, size + 1));
	if (fw_random_below(&r, 4) == 0 && size - at >= FW_LCM_HEADER) /* one of the two lengths */
		data[at + 20 + fw_random_below(&r, 8)] =
		    (uint8_t)(fw_random_below(&r, 2) ? fw_random_u64(&r) : 0xff);
	else
		size = LLVMFuzzerMutate(data, size, max);
	if (seed & 1)
		repair(data, size);
	return size;
}

/* The stream that was written has this many rows, and no line that means anything else. */
static void read_text(size_t n, uint64_t rows)
{
	static fw_csv_reader reader;
	fw_kind kind;
	fw_status status;

	fw_input_open_memory(&in, text, n);
	fw_csv_begin_read(&reader, &in, FW_RECORD_COUNT);
	while ((status = fw_csv_read(&reader, &kind, &record)) == FW_OK)
		;
	require(status == FW_EOF && reader.rows == rows && reader.lost == 0);
}

/* Reads all of an input and writes it; the number of records. */
static uint64_t copy(const void *bytes, size_t n, memory *to, fw_lcm_reader *reader)
{
	memory m = {text, LOG_MOST, 0};
	fw_kind kind;
	fw_status status;

	fw_input_open_memory(&in, bytes, n);
	fw_lcm_begin_read(reader, &in);
	fw_lcm_begin(&writer, to_memory, to);
	fw_csv_begin_stream(&stream, to_memory, &m);
	while ((status = fw_lcm_read(reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		require(status == FW_OK || (reader->lost_offset < n && reader->reason != NULL));
		if (status == FW_OK) {
			record_check(NULL, kind, &record);
			fw_lcm_put(&writer, kind, &record);
			fw_csv_put(&stream, kind, &record);
		}
	}
	require(fw_lcm_end(&writer, true, 0) == FW_OK && fw_csv_end(&stream, true, 0) == FW_OK);
	require(writer.rows == reader->rows && writer.refused == 0);
	read_text(m.used, reader->rows);
	return reader->rows;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_lcm_reader reader;
	memory first = {first_log, LOG_MOST, 0}, second = {second_log, LOG_MOST, 0};

	const uint64_t rows = copy(data, size, &first, &reader);
	require(copy(first.bytes, first.used, &second, &reader) == rows);
	require(reader.lost == 0 && reader.foreign == 0 && !reader.partial);
	require(first.used == second.used && memcmp(first.bytes, second.bytes, first.used) == 0);
	return 0;
}
