/* SBF for the harnesses: streams of valid blocks made at random, and changes that know where a block keeps its counts,
 * lengths and CRC. */
#ifndef FURROW_TESTS_FUZZ_SBF_INPUT_H
#define FURROW_TESTS_FUZZ_SBF_INPUT_H

#include <string.h>

#include "formats/bytes.h"
#include "formats/crc.h"
#include "formats/sbf_codec.h"
#include "formats/sbf_frame.h"

#include "fuzz.h"

enum { SBF_MOST_SUBS = 4, SBF_BLOCK_ROOM = 4096, SBF_WEEK = 2360 };

/* ---- making ---- */

/* Mostly random bytes; runs of zeros and of ones for absent values. */
static inline void sbf_fill(fw_random *r, uint8_t *p, size_t n)
{
	for (size_t i = 0; i < n; i += 4) {
		const uint64_t bits = fw_random_u64(r);
		uint32_t word = (uint32_t)bits;
		if (bits >> 60 < 3)
			word = 0;
		else if (bits >> 60 == 3)
			word = UINT32_MAX;
		else if (bits >> 60 == 4)
			word &= 0x01010101;
		memcpy(p + i, &word, n - i < 4 ? n - i : 4);
	}
}

/* A small count of sub-blocks; bit fields may stay as they are. */
static inline void sbf_limit_count(fw_random *r, const fw_sbf_group *group, uint8_t *parent)
{
	if (group->count != SBF_COUNT_U1 && group->count != SBF_COUNT_U2)
		return;
	parent[group->count_offset] = (uint8_t)fw_random_below(r, SBF_MOST_SUBS + 1);
	if (group->count == SBF_COUNT_U2)
		parent[group->count_offset + 1] = 0;
}

static inline size_t sbf_make_group(fw_random *r, const fw_sbf_group *group, uint8_t *block, uint8_t *parent,
                                    size_t at)
{
	const size_t n = fw_sbf_group_count(group, parent, SBF_BLOCK_ROOM);
	for (size_t i = 0; i < n && at + group->size < SBF_BLOCK_ROOM / 2; i++) {
		uint8_t *sub = block + at;
		sbf_fill(r, sub, group->size);
		at += group->size;
		if (group->nested != NULL) {
			sbf_limit_count(r, group->nested, sub);
			at = sbf_make_group(r, group->nested, block, sub, at);
		}
	}
	return at;
}

/* A block of a schema, with random content. Returns its length. */
static inline size_t sbf_make_by_table(fw_random *r, const fw_sbf_schema *schema, uint32_t tow_ms,
                                       uint8_t *block)
{
	size_t end = schema->size;
	sbf_fill(r, block + FW_SBF_BODY, end - FW_SBF_BODY);
	for (unsigned g = 0; g < schema->n_groups; g++) {
		const fw_sbf_group *group = &schema->groups[g];
		sbf_limit_count(r, group, block);
		if (group->size_offset > 0)
			block[group->size_offset] = (uint8_t)group->size;
		if (group->nested != NULL && group->nested->size_offset > 0)
			block[group->nested->size_offset] = (uint8_t)group->nested->size;
	}
	for (unsigned g = 0; g < schema->n_groups; g++)
		end = sbf_make_group(r, &schema->groups[g], block, block, end);
	while (end % 4 != 0)
		block[end++] = 0;
	fw_sbf_seal(block, schema->id, schema->revision, (uint16_t)end, tow_ms, SBF_WEEK);
	return end;
}

/* A block of any schema. */
static inline size_t sbf_make_any(fw_random *r, uint32_t tow_ms, uint8_t *block)
{
	return sbf_make_by_table(r, &fw_sbf_schemas[fw_random_below(r, (uint64_t)fw_sbf_n_schemas)], tow_ms,
	                         block);
}

/* Blocks that belong together, at most SBF_BLOCK_ROOM bytes; returns their size. */
typedef size_t sbf_maker(fw_random *r, uint32_t *tow_ms, uint8_t *blocks);

/* One to ten of them, as much as fits into `room` bytes, the time going on now and then. */
static inline size_t sbf_make_stream(fw_random *r, sbf_maker *make, uint8_t *data, size_t room)
{
	static uint8_t blocks[SBF_BLOCK_ROOM];
	uint32_t tow_ms = (uint32_t)fw_random_below(r, 6048) * 100000;
	size_t size = 0;
	for (size_t n = 1 + (size_t)fw_random_below(r, 10); n > 0; n--) {
		const size_t length = make(r, &tow_ms, blocks);
		if (length > room - size)
			break;
		memcpy(data + size, blocks, length);
		size += length;
		tow_ms += fw_random_below(r, 3) == 0 ? 100 : 0;
	}
	return size;
}

/* ---- finding one's way ---- */

/* The next sync pair from `at` on; `size` when there is none. */
static inline size_t sbf_find(const uint8_t *data, size_t size, size_t at)
{
	for (; at + 1 < size; at++)
		if (data[at] == '$' && data[at + 1] == '@')
			return at;
	return size;
}

/* A copy of a block with nothing behind it, so that the sanitizers see a step beyond its end. */
static inline const uint8_t *sbf_alone(const uint8_t *block, size_t length)
{
	static uint8_t room[FW_SBF_MAX_LENGTH];
	return memcpy(room + sizeof room - length, block, length);
}

/* A block drawn at random: where it starts; `size` when there is none. *end: where the next one does. */
static inline size_t sbf_pick(fw_random *r, const uint8_t *data, size_t size, size_t *end)
{
	size_t at = sbf_find(data, size, (size_t)fw_random_below(r, size + 1));
	if (at == size)
		at = sbf_find(data, size, 0);
	*end = sbf_find(data, size, at + 2 < size ? at + 2 : size);
	return at;
}

/* Lengths that do not fit and all CRCs put right. */
static inline void sbf_repair(uint8_t *data, size_t size)
{
	size_t at = 0;
	while ((at = sbf_find(data, size, at)) + FW_SBF_HEADER <= size) {
		size_t length = fw_load_u16(data + at + 6);
		if (length % 4 != 0 || length < FW_SBF_HEADER || length > size - at) {
			length = (sbf_find(data, size, at + 2) - at) / 4 * 4;
			if (length < FW_SBF_HEADER || length > FW_SBF_LONGEST) {
				at += 2;
				continue;
			}
			fw_store_u16(data + at + 6, (uint16_t)length);
		}
		fw_store_u16(data + at + 2, fw_crc16(data + at + 4, length - 4));
		at += length;
	}
}

/* ---- spoiling ---- */

/* Nought, one, the most, one more, one less, anything. */
static inline void sbf_spoil_number(fw_random *r, uint8_t *p, size_t width)
{
	const uint16_t old = width == 2 ? fw_load_u16(p) : p[0];
	const uint16_t choices[] = {
	    0, 1, UINT16_MAX, (uint16_t)(old + 1), (uint16_t)(old - 1), (uint16_t)fw_random_u64(r)};
	const uint16_t value = choices[fw_random_below(r, sizeof choices / sizeof *choices)];
	p[0] = (uint8_t)value;
	if (width == 2)
		p[1] = (uint8_t)(value >> 8);
}

/* The length of a block, or one of the counts and lengths that its table tells of. */
static inline void sbf_spoil_count(fw_random *r, uint8_t *data, size_t size)
{
	size_t end;
	const size_t at = sbf_pick(r, data, size, &end);
	if (end - at < 20)
		return;
	const fw_sbf_schema *schema = fw_sbf_schema_find(fw_load_u16(data + at + 4) & 0x1fff);
	size_t offset = 6, width = 2;
	if (schema != NULL && schema->n_groups > 0 && fw_random_below(r, 4) > 0) {
		const fw_sbf_group *group = &schema->groups[fw_random_below(r, schema->n_groups)];
		width = group->count == SBF_COUNT_U1 || group->count == SBF_COUNT_BITS ? 1 : 2;
		offset = group->count_offset;
		if (fw_random_below(r, 2) == 0) {
			const fw_sbf_group *inner =
			    group->nested != NULL && fw_random_below(r, 2) == 0 ? group->nested : group;
			offset = inner->size_offset > 0 ? inner->size_offset : offset;
			width = 1;
		} else if (group->nested != NULL && fw_random_below(r, 2) == 0) {
			offset = group->start > 0 ? group->start : schema->size;
			offset += group->nested->count_offset;
			width = 1;
		}
	}
	if (offset + width <= end - at)
		sbf_spoil_number(r, data + at + offset, width);
}

/* A block away, or once more at another place. */
static inline size_t sbf_spoil_order(fw_random *r, uint8_t *data, size_t size, size_t max)
{
	static uint8_t copy[FUZZ_ROOM];
	size_t end, other_end;
	const size_t at = sbf_pick(r, data, size, &end), n = end - at;
	if (n == 0 || n > sizeof copy)
		return size;
	if (fw_random_below(r, 2) == 0) {
		memmove(data + at, data + end, size - end);
		return size - n;
	}
	const size_t to = sbf_pick(r, data, size, &other_end);
	if (n > max - size)
		return size;
	memcpy(copy, data + at, n);
	memmove(data + to + n, data + to, size - to);
	memcpy(data + to, copy, n);
	return size + n;
}

/* New valid blocks in front of another. */
static inline size_t sbf_spoil_insert(fw_random *r, sbf_maker *make, uint8_t *data, size_t size, size_t max)
{
	static uint8_t blocks[SBF_BLOCK_ROOM];
	size_t end;
	const size_t at = sbf_pick(r, data, size, &end);
	uint32_t tow_ms = at + 12 <= size ? fw_load_u32(data + at + 8) : 0;
	const size_t n = make(r, &tow_ms, blocks);
	if (n > max - size)
		return size;
	memmove(data + at + n, data + at, size - at);
	memcpy(data + at, blocks, n);
	return size + n;
}

/* What LLVMFuzzerCustomMutator() does with a stream of blocks. */
static inline size_t sbf_mutate(uint8_t *data, size_t size, size_t max, unsigned seed, sbf_maker *make)
{
	fw_random r;
	fw_random_init(&r, seed);
	switch (fw_random_below(&r, 10)) {
	case 0:
	case 1:
	case 2: sbf_spoil_count(&r, data, size); break;
	case 3: size = sbf_spoil_order(&r, data, size, max); break;
	case 4: size = sbf_spoil_insert(&r, make, data, size, max); break;
	default: size = LLVMFuzzerMutate(data, size, max); break;
	}
	if (seed & 1)
		sbf_repair(data, size);
	return size;
}

#endif
