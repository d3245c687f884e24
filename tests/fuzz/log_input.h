/* Receiver logs for the harnesses of the whole way: blocks of every kind. */
#ifndef FURROW_TESTS_FUZZ_LOG_INPUT_H
#define FURROW_TESTS_FUZZ_LOG_INPUT_H

#include "meas3_input.h"
#include "nav_input.h"

/* See sbf_maker. */
static inline size_t log_make_blocks(fw_random *r, uint32_t *tow_ms, uint8_t *blocks)
{
	switch (fw_random_below(r, 12)) {
	case 0: return nav_make_pages(r, tow_ms, blocks);
	case 1: return nav_make_sbas(r, tow_ms, blocks);
	case 2: return meas3_make(r, tow_ms, blocks);
	default: return sbf_make_any(r, *tow_ms, blocks);
	}
}

/* A byte that says how the log is to be read, then the log. */
static inline size_t log_make(fw_random *r, uint8_t *data)
{
	data[0] = (uint8_t)fw_random_u64(r);
	return 1 + sbf_make_stream(r, log_make_blocks, data + 1, FUZZ_ROOM - 1);
}

static inline size_t log_mutate(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	if (size == 0 || seed % 64 < 2)
		data[0] = (uint8_t)(seed >> 6);
	size = 1 + sbf_mutate(data + 1, size > 0 ? size - 1 : 0, max - 1, seed, log_make_blocks);
	if (seed % 4 == 1)
		nav_repair(data + 1, size - 1);
	return size;
}

#endif
