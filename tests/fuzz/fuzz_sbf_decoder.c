/* The whole way of a receiver log: framing, decoding, and both encodings of the records. The LCM log and the stream,
 * each read back and written as a stream, must be the stream that was written at first. */
#include "log_input.h"

#include "formats/csv.h"
#include "formats/lcm_log.h"
#include "formats/sbf_decoder.h"

#include "record_check.h"

enum { TEXT_MOST = 4 << 20 };

typedef struct {
	size_t used;
	char bytes[TEXT_MOST];
} memory;

static memory stream, events, again;
static fw_csv_writer csv;
static fw_lcm_writer lcm;
static fw_any_record record;
static fw_input in;

static fw_status to_memory(void *context, const void *bytes, size_t n)
{
	memory *m = context;
	require(n <= sizeof m->bytes - m->used);
	memcpy(m->bytes + m->used, bytes, n);
	m->used += n;
	return FW_OK;
}

static void put_both(void *context, fw_kind kind, const void *decoded)
{
	record_check(context, kind, decoded);
	fw_csv_put(&csv, kind, decoded);
	fw_lcm_put(&lcm, kind, decoded);
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	return log_make(random, data);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return log_mutate(data, size, max, seed);
}

static fw_sbf_decoder_options options_of(uint8_t mode)
{
	fw_sbf_decoder_options o = {.antennas = mode & 1 ? FW_ANTENNA_ALL : FW_ANTENNA_MAIN,
	                            .nav_sources = mode & 2 ? FW_NAV_RAW : FW_NAV_DECODED};
	if (mode & 4)
		o.nav_sources = FW_NAV_RAW | FW_NAV_DECODED;
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++)
		if ((mode & 0x18) != 0x18 || kind % 8 == mode >> 5)
			fw_kind_add(&o.wanted, kind);
	return o;
}

/* Returns the rows written. */
static uint64_t decode(const uint8_t *data, size_t size, uint8_t mode)
{
	static fw_sbf_framer framer;
	static fw_sbf_decoder decoder;
	const fw_sbf_decoder_options options = options_of(mode);
	fw_sbf_block block;

	fw_input_open_memory(&in, data, size);
	fw_sbf_init(&framer, &in, NULL, NULL);
	fw_sbf_decoder_init(&decoder, &options, (fw_sink){put_both, NULL});
	fw_csv_begin_stream(&csv, to_memory, &stream);
	fw_lcm_begin(&lcm, to_memory, &events);
	while (fw_sbf_next(&framer, &block) == FW_OK) {
		block.data = sbf_alone(block.data, block.length);
		fw_sbf_decoder_put(&decoder, &block);
	}
	fw_sbf_decoder_flush(&decoder);
	require(fw_csv_end(&csv, true, 0) == FW_OK && fw_lcm_end(&lcm, true, 0) == FW_OK);
	require(csv.refused == 0 && lcm.refused == 0 && csv.rows == lcm.rows);
	return csv.rows;
}

static void stream_comes_back(uint64_t rows)
{
	static fw_csv_reader reader;
	fw_kind kind;
	fw_status status;

	again.used = 0;
	fw_input_open_memory(&in, stream.bytes, stream.used);
	fw_csv_begin_stream(&csv, to_memory, &again);
	fw_csv_begin_read(&reader, &in, FW_RECORD_COUNT);
	while ((status = fw_csv_read(&reader, &kind, &record)) == FW_OK)
		fw_csv_put(&csv, kind, &record);
	require(status == FW_EOF && reader.lost == 0 && reader.rows == rows);
	require(fw_csv_end(&csv, true, 0) == FW_OK);
	require(again.used == stream.used && memcmp(again.bytes, stream.bytes, stream.used) == 0);
}

static void log_comes_back(uint64_t rows)
{
	static fw_lcm_reader reader;
	fw_kind kind;
	fw_status status;

	again.used = 0;
	fw_input_open_memory(&in, events.bytes, events.used);
	fw_csv_begin_stream(&csv, to_memory, &again);
	fw_lcm_begin_read(&reader, &in);
	while ((status = fw_lcm_read(&reader, &kind, &record)) == FW_OK)
		fw_csv_put(&csv, kind, &record);
	require(status == FW_EOF && reader.lost == 0 && reader.rows == rows);
	require(fw_csv_end(&csv, true, 0) == FW_OK);
	require(again.used == stream.used && memcmp(again.bytes, stream.bytes, stream.used) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	if (size == 0)
		return 0;
	stream.used = events.used = 0;
	const uint64_t rows = decode(data + 1, size - 1, data[0]);
	stream_comes_back(rows);
	log_comes_back(rows);
	return 0;
}
