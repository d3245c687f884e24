/* Receiver logs for the harnesses of the whole way: blocks of every kind. */
#ifndef FURROW_TESTS_FUZZ_LOG_INPUT_H
#define FURROW_TESTS_FUZZ_LOG_INPUT_H

#include "meas3_input.h"
#include "nav_input.h"

/* Inertial samples, rates and accelerations in blocks of their own or together: see sbf_maker. */
static inline size_t log_make_inertial(fw_random *r, uint32_t *tow_ms, uint8_t *blocks)
{
	enum { EXT_SENSOR_MEAS = 4050, N = 14, SIZE = 15, SETS = 16, TYPE = 2 };
	static const uint8_t types[] = {0, 1, 0, 1, 0, 1, 3, 4, 20};
	size_t size = 0;
	for (unsigned n = 1 + (unsigned)fw_random_below(r, 4); n > 0; n--) {
		uint8_t *block = blocks + size;
		const size_t length =
		    sbf_make_by_table(r, fw_sbf_schema_find(EXT_SENSOR_MEAS), *tow_ms, block);
		for (unsigned i = 0; i < block[N]; i++)
			block[SETS + i * block[SIZE] + TYPE] = types[fw_random_below(r, sizeof types)];
		fw_sbf_seal(block, EXT_SENSOR_MEAS, 0, (uint16_t)length, *tow_ms, SBF_WEEK);
		size += length;
		*tow_ms += fw_random_below(r, 2) == 0 ? 5 : 0;
	}
	return size;
}

/* See sbf_maker. */
static inline size_t log_make_blocks(fw_random *r, uint32_t *tow_ms, uint8_t *blocks)
{
	switch (fw_random_below(r, 12)) {
	case 0: return nav_make_pages(r, tow_ms, blocks);
	case 1: return nav_make_sbas(r, tow_ms, blocks);
	case 2: return meas3_make(r, tow_ms, blocks);
	case 3: return log_make_inertial(r, tow_ms, blocks);
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
