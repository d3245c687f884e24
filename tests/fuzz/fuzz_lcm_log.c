/* LCM logs. What was read, written and read again, is the same log; and as a stream it has as many rows. */
#include "lcm_input.h"

#include "formats/csv.h"

#include "record_check.h"

enum { LOG_MOST = 1 << 20 };

static char first_log[LOG_MOST], second_log[LOG_MOST], text[LOG_MOST];
static fw_lcm_writer writer;
static fw_csv_writer stream;
static fw_any_record record;
static fw_input in;

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	return lcm_make(random, data, FUZZ_ROOM);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return lcm_mutate(data, size, max, seed);
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
