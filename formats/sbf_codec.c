#include "formats/sbf_codec.h"

#include <stdbool.h>

#include "formats/crc.h"

/* Decoding and encoding go the same way through a block, so that neither can ever read the table differently from
 * the other. When encoding, counts are read from the bytes just written. */
typedef struct {
	const uint8_t *block;
	uint8_t *out; /* the same block when encoding; NULL when decoding */
	size_t length;
	int64_t *to;         /* decoding: where values go */
	const int64_t *from; /* encoding: where they come from */
	uint32_t n;          /* values done */
	uint32_t limit;      /* values there are */
} walk;

/* Returns whether the value is one of the type's. */
static bool store(uint8_t *p, uint8_t type, int64_t value)
{
	switch (fw_sbf_type_size(type)) {
	case 8: fw_store_u64(p, (uint64_t)value); break;
	case 4: fw_store_u32(p, (uint32_t)value); break;
	case 2: fw_store_u16(p, (uint16_t)value); break;
	default: p[0] = (uint8_t)value;
	}
	return fw_sbf_load(p, type) == value;
}

static fw_status visit(walk *w, size_t at, uint8_t type)
{
	if (!w->out) {
		w->to[w->n++] = fw_sbf_load(w->block + at, type);
		return FW_OK;
	}
	if (w->n >= w->limit || !store(w->out + at, type, w->from[w->n]))
		return FW_EINVAL;
	w->n++;
	return FW_OK;
}

/* The bytes at..end that no field covers. */
static fw_status visit_bytes(walk *w, size_t at, size_t end)
{
	fw_status status = FW_OK;
	for (; at < end && status == FW_OK; at++)
		status = visit(w, at, SBF_U1);
	return status;
}

/* The fields of the bytes at..end as far as they fit, then what is left over. The table is free of gaps. */
static fw_status visit_fields(walk *w, const fw_sbf_field *fields, size_t n, size_t at, size_t end)
{
	for (size_t i = 0; i < n; i++) {
		if (fields[i].width > 0)
			continue;
		size_t size = fw_sbf_type_size(fields[i].type);
		for (unsigned k = 0; k < fields[i].count; k++, at += size) {
			if (size > end - at)
				return visit_bytes(w, at, end);
			fw_status status = visit(w, at, fields[i].type);
			if (status != FW_OK)
				return status;
		}
	}
	return visit_bytes(w, at, end);
}

/* All sub-blocks of a group, from *at on; parent and size as in fw_sbf_group_count. The table says how deep groups
 * nest, never the block. */
static fw_status visit_group(walk *w, const fw_sbf_group *group, const uint8_t *parent, size_t parent_size,
                             size_t *at)
{
	size_t count = fw_sbf_group_count(group, parent, parent_size);
	size_t size = fw_sbf_group_size(group, w->block, w->length);
	for (size_t i = 0; i < count; i++) {
		if (size == 0 || *at > w->length || size > w->length - *at)
			return FW_EFORMAT;
		size_t start = *at;
		fw_status status = visit_fields(w, group->fields, group->n_fields, start, start + size);
		*at += size;
		if (status == FW_OK && group->nested)
			status = visit_group(w, group->nested, w->block + start, size, at);
		if (status != FW_OK)
			return status;
	}
	return FW_OK;
}

static fw_status visit_block(walk *w, const fw_sbf_schema *schema)
{
	size_t at = fw_sbf_fixed_end(schema, w->length);
	fw_status status = visit_fields(w, schema->fields, schema->n_fields, FW_SBF_BODY, at);
	for (unsigned g = 0; g < schema->n_groups && status == FW_OK; g++) {
		const fw_sbf_group *group = &schema->groups[g];
		if (group->start > w->length && fw_sbf_group_count(group, w->block, w->length) > 0)
			return FW_EFORMAT;
		status = visit_group(w, group, w->block, w->length, &at);
	}
	return status == FW_OK ? visit_bytes(w, at, w->length) : status;
}

fw_status fw_sbf_decode(const uint8_t *block, fw_sbf_values *v)
{
	uint16_t id = fw_load_u16(block + 4);
	v->schema = fw_sbf_schema_find(id & 0x1FFF);
	v->revision = (uint8_t)(id >> 13);
	v->length = fw_load_u16(block + 6);
	if (!v->schema)
		return FW_EUNKNOWN;
	if (v->length % 4 != 0 || v->length < FW_SBF_BODY)
		return FW_EFORMAT;
	v->tow_ms = fw_load_u32(block + 8);
	v->week = fw_load_u16(block + 12);

	walk w = {.block = block, .length = v->length, .to = v->values};
	fw_status status = visit_block(&w, v->schema);
	v->n = w.n;
	return status;
}

fw_status fw_sbf_encode(const fw_sbf_values *v, uint8_t *block)
{
	if (!v->schema || v->revision > 7 || v->length % 4 != 0 || v->length < FW_SBF_BODY)
		return FW_EINVAL;
	walk w = {.block = block, .out = block, .length = v->length, .from = v->values, .limit = v->n};
	if (visit_block(&w, v->schema) != FW_OK || w.n != v->n)
		return FW_EINVAL;
	fw_sbf_seal(block, v->schema->id, v->revision, v->length, v->tow_ms, v->week);
	return FW_OK;
}

void fw_sbf_seal(uint8_t *block, uint16_t id, uint8_t revision, uint16_t length, uint32_t tow_ms,
                 uint16_t week)
{
	block[0] = '$';
	block[1] = '@';
	fw_store_u16(block + 4, (uint16_t)(id | revision << 13));
	fw_store_u16(block + 6, length);
	fw_store_u32(block + 8, tow_ms);
	fw_store_u16(block + 12, week);
	fw_store_u16(block + 2, fw_crc16(block + 4, length - 4U));
}

size_t fw_sbf_fixed_end(const fw_sbf_schema *schema, size_t length)
{
	if (schema->n_groups == 0 || schema->groups[0].start > length)
		return length;
	return schema->groups[0].start;
}

size_t fw_sbf_group_count(const fw_sbf_group *group, const uint8_t *parent, size_t size)
{
	if (group->count == SBF_COUNT_FIXED)
		return group->count_bit;
	const uint8_t *p = parent + group->count_offset;
	size_t width = group->count == SBF_COUNT_U1 || group->count == SBF_COUNT_BITS ? 1 : 2;
	if (group->count_offset + width > size)
		return 0;
	switch (group->count) {
	case SBF_COUNT_U1: return p[0];
	case SBF_COUNT_U2: return fw_load_u16(p);
	case SBF_COUNT_BIT: return fw_load_u16(p) >> group->count_bit & 1;
	default: return (size_t)__builtin_popcount(p[0] & ((1U << group->count_bit) - 1));
	}
}

size_t fw_sbf_group_size(const fw_sbf_group *group, const uint8_t *block, size_t length)
{
	if (group->size_offset == 0)
		return group->size;
	return group->size_offset < length ? block[group->size_offset] : 0;
}
