/* LCM logs for the harnesses: records with random content, and changes that know where an event keeps its lengths. */
#ifndef FURROW_TESTS_FUZZ_LCM_INPUT_H
#define FURROW_TESTS_FUZZ_LCM_INPUT_H

#include <string.h>

#include "../random_record.h"
#include "formats/lcm_log.h"

#include "fuzz.h"

static inline size_t lcm_make(fw_random *random, uint8_t *data, size_t room)
{
	static fw_lcm_writer writer;
	memory m = {(char *)data, room, 0};

	fw_lcm_begin(&writer, to_memory, &m);
	for (size_t n = (size_t)fw_random_below(random, 3); n > 0; n--)
		fw_lcm_meta(&writer, fw_random_below(random, 2) == 0 ? "pg" : random_string(random),
		            "tool=x");
	for (size_t n = 1 + (size_t)fw_random_below(random, 10); n > 0; n--) {
		const fw_kind kind = (fw_kind)fw_random_below(random, FW_meta);
		fw_any_record record;
		random_record(random, kind, &record);
		fw_lcm_put(&writer, kind, &record);
	}
	(void)!fw_lcm_end(&writer, true, 0);
	return m.used;
}

static inline uint32_t lcm_load(const uint8_t *p)
{
	return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static inline void lcm_store(uint8_t *p, size_t v)
{
	for (int i = 0; i < 4; i++)
		p[i] = (uint8_t)(v >> (24 - 8 * i));
}

static inline size_t lcm_find(const uint8_t *data, size_t size, size_t at)
{
	static const uint8_t sync[] = {0xed, 0xa1, 0xda, 0x01};
	const uint8_t *p = at < size ? memmem(data + at, size - at, sync, sizeof sync) : NULL;
	return p != NULL ? (size_t)(p - data) : size;
}

/* Lengths that lead from each event to the next. */
static inline void lcm_repair(uint8_t *data, size_t size)
{
	for (size_t at = lcm_find(data, size, 0); at < size;) {
		const size_t next = lcm_find(data, size, at + 4), n = next - at;
		if (n >= FW_LCM_HEADER) {
			size_t name = lcm_load(data + at + 20);
			if (name > n - FW_LCM_HEADER)
				name = n - FW_LCM_HEADER;
			lcm_store(data + at + 20, name);
			lcm_store(data + at + 24, n - FW_LCM_HEADER - name);
		}
		at = next;
	}
}

static inline size_t lcm_mutate(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	fw_random r;
	fw_random_init(&r, seed);
	const size_t at = lcm_find(data, size, (size_t)fw_random_below(&r, size + 1));
	if (fw_random_below(&r, 4) == 0 && size - at >= FW_LCM_HEADER) /* one of the two lengths */
		data[at + 20 + fw_random_below(&r, 8)] =
		    (uint8_t)(fw_random_below(&r, 2) ? fw_random_u64(&r) : 0xff);
	else
		size = LLVMFuzzerMutate(data, size, max);
	if (seed & 1)
		lcm_repair(data, size);
	return size;
}

#endif
