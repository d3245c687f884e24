/* Tables and streams. What was read, written as a stream and read again, is the same stream. */
#include "text_input.h"

#include "../random_record.h"
#include "formats/csv.h"

#include "record_check.h"

enum { TEXT_MOST = 1 << 20 };

static char first_text[TEXT_MOST], second_text[TEXT_MOST];
static fw_csv_writer writer;

static const char *const words[] = {
    "#furrow-stream 1\n",
    "#end status=complete rows=1 skipped=0\n",
    "#pvt,gps_week,tow_s\n",
    "pvt,2360,1\n",
    "obs,",
    "imu,",
    "#",
    "#pg tool=x\n",
    "gps_week",
    "tow_s",
    "lat_deg",
    "height_m",
    "\"\"",
    "\"",
    "\",\"",
    "\r\n",
    "\n\n",
    ",,,,,,,,",
    "\xef\xbb\xbf",
    "nan",
    "inf",
    "-0",
    "1e308",
    "1e-400",
    "0x10",
    "9223372036854775808",
    "999999999999999999999999",
    "0.00000000000000000000000000000000000001",
    "2360,604800",
    "65536",
    "\xff\xfe",
};

/* A table of one type, or a stream of several. */
size_t fuzz_make(fw_random *random, uint8_t *data)
{
	memory m = {(char *)data, FUZZ_ROOM, 0};
	fw_kind kind = (fw_kind)fw_random_below(random, FW_meta);
	const int table = fw_random_below(random, 3) == 0;

	if (table)
		fw_csv_begin_table(&writer, kind, to_memory, &m);
	else
		fw_csv_begin_stream(&writer, to_memory, &m);
	for (size_t n = 1 + (size_t)fw_random_below(random, 6); n > 0; n--) {
		fw_any_record record;
		if (!table && fw_random_below(random, 3) == 0)
			kind = (fw_kind)fw_random_below(random, FW_meta);
		random_record(random, kind, &record);
		fw_csv_put(&writer, kind, &record);
	}
	(void)!fw_csv_end(&writer, true, 0);
	return m.used;
}

/* Every other time the head stays as it is, so that the rows behind it are read. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	size_t head = 0;
	for (int lines = 0; (seed & 1) && head < size && lines < 2; head++)
		lines += data[head] == '\n';
	return head +
	       text_mutate(data + head, size - head, max - head, seed, words, sizeof words / sizeof *words);
}

/* Reads all of an input and writes it as a stream; the number of rows. */
static uint64_t copy(const void *bytes, size_t n, memory *to, fw_csv_reader *reader)
{
	static fw_input in;
	static fw_any_record record;
	fw_kind kind;
	fw_status status;

	fw_input_open_memory(&in, bytes, n);
	fw_csv_begin_read(reader, &in, FW_RECORD_COUNT);
	fw_csv_begin_stream(&writer, to_memory, to);
	while ((status = fw_csv_read(reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		require(status == FW_OK || (reader->problem.line > 0 && reader->problem.reason != NULL));
		if (status == FW_OK) {
			record_check(NULL, kind, &record);
			fw_csv_put(&writer, kind, &record);
		}
	}
	require(fw_csv_end(&writer, true, 0) == FW_OK);
	require(writer.rows == reader->rows && writer.refused == 0);
	return reader->rows;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_csv_reader reader;
	memory first = {first_text, TEXT_MOST, 0}, second = {second_text, TEXT_MOST, 0};

	const uint64_t rows = copy(data, size, &first, &reader);
	require(copy(first.bytes, first.used, &second, &reader) == rows);
	require(reader.lost == 0 && !reader.partial);
	require(first.used == second.used && memcmp(first.bytes, second.bytes, first.used) == 0);
	return 0;
}
