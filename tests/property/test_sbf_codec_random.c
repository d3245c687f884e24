/* 10,000 random valid blocks of every schema: random revisions and lengths, counts of sub-blocks, lengths of
 * sub-blocks below and above the known one, random bytes everywhere else, so all bit patterns of floats occur.
 * decode, encode, decode must give the same bytes and the same values. Seeded: every run is the same run. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "base/random.h"
#include "formats/bytes.h"
#include "formats/sbf_codec.h"

enum { BLOCKS = 10000, MOST = 4 /* sub-blocks in a group */ };

static fw_sbf_values first, second;
static uint8_t block[FW_SBF_MAX_LENGTH], bytes[FW_SBF_MAX_LENGTH];

static void fill(fw_random *random, size_t from, size_t to)
{
	for (; from < to; from += 8) {
		uint64_t bits = fw_random_u64(random);
		memcpy(block + from, &bits, to - from < 8 ? to - from : 8);
	}
}

/* A small count of sub-blocks in place of a random one. Bit fields may stay as they are. */
static void limit_count(fw_random *random, const fw_sbf_group *group, uint8_t *parent, size_t size)
{
	size_t width = group->count == SBF_COUNT_U1 ? 1 : 2;
	if ((group->count != SBF_COUNT_U1 && group->count != SBF_COUNT_U2) ||
	    group->count_offset + width > size)
		return;
	parent[group->count_offset] = (uint8_t)fw_random_below(random, MOST + 1);
	if (width == 2)
		parent[group->count_offset + 1] = 0;
}

/* A length of sub-blocks near the known one, at least 1. */
static void choose_size(fw_random *random, const fw_sbf_group *group)
{
	if (group->size_offset == 0)
		return;
	unsigned size = group->size;
	if (fw_random_below(random, 2) == 0)
		size = (unsigned)(1 + fw_random_below(random, size + 9));
	block[group->size_offset] = (uint8_t)size;
}

/* Writes the sub-blocks of a group; returns where they end. */
static size_t make_group(fw_random *random, const fw_sbf_group *group, uint8_t *parent, size_t size,
                         size_t at)
{
	size_t count = fw_sbf_group_count(group, parent, size);
	size_t length = fw_sbf_group_size(group, block, FW_SBF_MAX_LENGTH);
	for (size_t i = 0; i < count; i++) {
		uint8_t *sub = block + at;
		fill(random, at, at + length);
		at += length;
		if (group->nested) {
			limit_count(random, group->nested, sub, length);
			at = make_group(random, group->nested, sub, length, at);
		}
	}
	return at;
}

static size_t make_block(fw_random *random, const fw_sbf_schema *schema)
{
	size_t end = schema->size;
	fill(random, FW_SBF_BODY, end + 8);
	if (schema->n_groups == 0)
		return FW_SBF_BODY + 2 + fw_random_below(random, end + 12 - FW_SBF_BODY);
	for (unsigned g = 0; g < schema->n_groups; g++) {
		limit_count(random, &schema->groups[g], block, end);
		choose_size(random, &schema->groups[g]);
		if (schema->groups[g].nested)
			choose_size(random, schema->groups[g].nested);
	}
	for (unsigned g = 0; g < schema->n_groups; g++)
		end = make_group(random, &schema->groups[g], block, schema->size, end);
	size_t tail = fw_random_below(random, 4) == 0 ? fw_random_below(random, 20) : 0;
	fill(random, end, end + tail);
	return end + tail;
}

static void round_trips(void **state)
{
	(void)state;
	fw_random random;
	fw_random_init(&random, 20261122);
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		const fw_sbf_schema *schema = &fw_sbf_schemas[i];
		for (int k = 0; k < BLOCKS; k++) {
			size_t end = make_block(&random, schema);
			uint16_t length = (uint16_t)((end + 3) / 4 * 4);
			memset(block + end, 0, length - end);
			fw_sbf_seal(block, schema->id, (uint8_t)fw_random_below(&random, 8), length,
			            (uint32_t)fw_random_u64(&random), (uint16_t)fw_random_u64(&random));

			assert_int_equal(fw_sbf_decode(block, &first), FW_OK);
			memset(bytes, 0xA5, length);
			assert_int_equal(fw_sbf_encode(&first, bytes), FW_OK);
			if (memcmp(bytes, block, length) != 0)
				fail_msg("%s, block %d: other bytes", schema->name, k);
			assert_int_equal(fw_sbf_decode(bytes, &second), FW_OK);
			assert_memory_equal(&first, &second, offsetof(fw_sbf_values, values));
			assert_memory_equal(first.values, second.values, first.n * sizeof first.values[0]);
		}
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(round_trips)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
