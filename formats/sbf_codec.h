/* Exact decoding and encoding of SBF blocks by schema: every field, nothing converted, nothing lost.
 * encode(decode(block)) gives the same bytes, unknown tails and reserved bytes included. */
#ifndef FURROW_FORMATS_SBF_CODEC_H
#define FURROW_FORMATS_SBF_CODEC_H

#include <stddef.h>

#include "formats/bytes.h"
#include "formats/sbf_schema.h"

enum { FW_SBF_MAX_LENGTH = 65532, FW_SBF_MAX_VALUES = 65536, FW_SBF_BODY = 14 /* where the fields begin */ };

/* A decoded block: header and the raw values of all fields in the order of the wire; each array element, and
 * each byte that no field covers (newer revisions, padding), is a value. Integers as int64_t (sign-extended),
 * floats as their bit patterns (f4 in the low 32 bits). */
typedef struct {
	const fw_sbf_schema *schema;
	uint8_t revision;
	uint16_t length; /* total, header included; a multiple of 4 */
	uint32_t tow_ms; /* do-not-use 4294967295 */
	uint16_t week;   /* do-not-use 65535 */
	uint32_t n;      /* number of values */
	int64_t values[FW_SBF_MAX_VALUES];
} fw_sbf_values;

/* Decodes the whole block at `block` (its length field says how long; the caller has checked that so many bytes
 * are there). Returns FW_EUNKNOWN for a block without schema, FW_EFORMAT when counts and lengths in the block
 * contradict its length; *v is then undefined. */
fw_status fw_sbf_decode(const uint8_t *block, fw_sbf_values *v) FW_MUST_CHECK;

/* Encodes: writes v->length bytes with sync, CRC and header at `block` (room for FW_SBF_MAX_LENGTH bytes).
 * Returns FW_EINVAL when a value does not fit its field, or when the values do not fill the length that v->length
 * and the counts among them ask for; the bytes at `block` are then undefined. */
fw_status fw_sbf_encode(const fw_sbf_values *v, uint8_t *block) FW_MUST_CHECK;

/* Makes a block of `length` bytes whose body is written: puts sync, CRC and header in front of it. */
void fw_sbf_seal(uint8_t *block, uint16_t id, uint8_t revision, uint16_t length, uint32_t tow_ms,
                 uint16_t week);

/* The pieces that whoever walks a block by its table needs. */

/* Length of a wire type [bytes]. */
static inline size_t fw_sbf_type_size(uint8_t type)
{
	static const uint8_t size[] = {[SBF_U1] = 1, [SBF_U2] = 2, [SBF_U4] = 4, [SBF_I1] = 1, [SBF_I2] = 2,
	                               [SBF_I4] = 4, [SBF_F4] = 4, [SBF_F8] = 8, [SBF_C1] = 1};
	return size[type];
}

/* The raw value of one field: integers sign-extended, floats as bit patterns. */
static inline int64_t fw_sbf_load(const uint8_t *p, uint8_t type)
{
	switch (type) {
	case SBF_I1: return (int8_t)p[0];
	case SBF_U2: return fw_load_u16(p);
	case SBF_I2: return (int16_t)fw_load_u16(p);
	case SBF_I4: return (int32_t)fw_load_u32(p);
	case SBF_U4:
	case SBF_F4: return fw_load_u32(p);
	case SBF_F8: return (int64_t)fw_load_u64(p);
	default: return p[0];
	}
}

/* Where the first of a schema's groups starts; the block's length when it has none or ends before. */
size_t fw_sbf_fixed_end(const fw_sbf_schema *schema, size_t length);

/* How many sub-blocks of a group follow, as the `size` bytes at `parent` say: the block, or, for a nested group, the
 * sub-block that it follows. A count that does not lie inside them is 0. */
size_t fw_sbf_group_count(const fw_sbf_group *group, const uint8_t *parent, size_t size);

/* The length of each of a group's sub-blocks [bytes]; 0 when the block of `length` bytes ends before it says it. */
size_t fw_sbf_group_size(const fw_sbf_group *group, const uint8_t *block, size_t length);

#endif
