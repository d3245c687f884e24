/* What a decoder made of some bytes, for comparisons: a sum over all its records, one for each record in turn. */
#ifndef FURROW_TESTS_RECORD_SUM_H
#define FURROW_TESTS_RECORD_SUM_H

#include <string.h>

#include "formats/input.h"
#include "formats/record.h"
#include "formats/sbf_decoder.h"
#include "formats/sbf_frame.h"

/* FNV-1a over what the records encode to. */
typedef struct {
	uint64_t sum;
	size_t records;
} record_sum;

static inline void add_record(void *context, fw_kind kind, const void *record)
{
	static uint8_t bytes[256 * 1024];
	record_sum *s = context;
	size_t n;

	if (fw_record_encode(kind, record, bytes, sizeof(bytes), &n) != FW_OK)
		n = 0; /* still counts as a record, and never equals one that encodes */
	s->sum = (s->sum ^ (uint64_t)kind) * 0x100000001b3;
	for (size_t i = 0; i < n; i++)
		s->sum = (s->sum ^ bytes[i]) * 0x100000001b3;
	s->records++;
}

static inline void decode_everything(fw_sbf_decoder *d, record_sum *s)
{
	fw_sbf_decoder_options all = {.antennas = FW_ANTENNA_ALL, .nav_sources = FW_NAV_DECODED | FW_NAV_RAW};

	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++)
		fw_kind_add(&all.wanted, kind);
	*s = (record_sum){0xcbf29ce484222325, 0};
	fw_sbf_decoder_init(d, &all, (fw_sink){add_record, s});
}

/* Frames n bytes and puts the blocks into the decoder; the framer's counts go to *stats. */
static inline void decode_bytes(fw_sbf_decoder *d, const uint8_t *bytes, size_t n, fw_sbf_stats *stats)
{
	static fw_input in;
	static fw_sbf_framer framer;
	fw_sbf_block b;

	fw_input_open_memory(&in, bytes, n);
	fw_sbf_init(&framer, &in, NULL, NULL);
	while (fw_sbf_next(&framer, &b) == FW_OK)
		fw_sbf_decoder_put(d, &b);
	fw_input_close(&in);
	*stats = framer.stats;
}

/* All that framer and decoder make of n bytes. */
static inline record_sum sum_records(const uint8_t *bytes, size_t n, fw_sbf_stats *stats)
{
	static fw_sbf_decoder decoder;
	record_sum s;

	decode_everything(&decoder, &s);
	decode_bytes(&decoder, bytes, n, stats);
	fw_sbf_decoder_flush(&decoder);
	return s;
}

#endif
