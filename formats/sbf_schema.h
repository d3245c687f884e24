/* The one table of SBF blocks: block number, name, and for each field its place, type, do-not-use rule, scale
 * and the record column that it becomes. The exact codec (sbf_codec.h), the records (sbf_records.h), the random
 * tests and the manual all walk this table; nothing else in furrow knows a block's layout, save the
 * measurement blocks, whose hot loop is written out in sbf_measurements.c and tested against this table.
 *
 * Layouts: Septentrio SBF reference guides. Revisions only append, so a field is read when it lies inside the
 * block (or sub-block) and is absent otherwise. `since` is needed only where a new field took the place of padding. */
#ifndef FURROW_FORMATS_SBF_SCHEMA_H
#define FURROW_FORMATS_SBF_SCHEMA_H

#include <stdint.h>

#include "formats/record.h"

/* Wire types, little-endian. C1 is a character, kept as an unsigned byte. */
typedef enum { SBF_U1, SBF_U2, SBF_U4, SBF_I1, SBF_I2, SBF_I4, SBF_F4, SBF_F8, SBF_C1 } fw_sbf_type;

/* When is a value "not available"? A float below -1.9e10 or not finite always is (do-not-use -2e10). */
typedef enum {
	SBF_ALWAYS, /* always available */
	SBF_DNU, /* not available: the type's do-not-use value (u1 255, u2 65535, u4 4294967295, i1 -128, ...) */
	SBF_DNU_ZERO /* not available: 0 */
} fw_sbf_dnu;

/* How a raw value becomes a column's value. */
typedef enum {
	SBF_NUMBER, /* raw * mul / div + add */
	SBF_ROOT,   /* a view: square root of an f4; a negative number has none and is absent */
	SBF_CHANNEL, /* a number for GLONASS only, that is when the byte before it is the SVID of a GLONASS satellite */
	SBF_SATELLITE, /* SVID -> "G05"; an SVID that means no satellite is absent */
	SBF_SIGNAL,    /* signal number -> RINEX code; one without code is absent */
	SBF_TEXT,      /* `count` characters, NUL or end terminated -> string; empty is absent */
	SBF_HEX,     /* `count` words u4 -> hexadecimal digits, bit 31 first; a view: `width` bits of them */
	SBF_INDEX,   /* a view of nothing on the wire: number of the sub-block, from 1 */
	SBF_CONSTANT /* likewise: always the text `name` */
} fw_sbf_convert;

/* One line of a table: a field, or a view, which takes some bits of a field or more than one column from it and
 * follows the field's own line. Only fields (width == 0) are on the wire.
 * A value that does not fit its column's integer type is absent. */
typedef struct {
	const char *name; /* as in the reference guide; reserved bytes are named "reserved" */
	uint16_t offset;  /* from the start of the block or sub-block [bytes] */
	uint16_t count;   /* array length, 1 for a scalar; only SBF_TEXT and SBF_HEX arrays become columns */
	uint8_t type;     /* fw_sbf_type */
	uint8_t shift;    /* first bit of a view on a bit field */
	uint8_t width;    /* number of bits of a view; 0: the field itself */
	uint8_t dnu;      /* fw_sbf_dnu; views of bits have none */
	uint8_t convert;  /* fw_sbf_convert */
	uint8_t since;    /* revision of the block that brought it; in older ones its place is padding */
	int16_t add;      /* column = raw * mul / div + add */
	double mul, div;  /* 0 stands for 1 */
	const char *column; /* of the record; NULL: not in the record */
} fw_sbf_field;

/* How often a sub-block occurs. */
typedef enum {
	SBF_COUNT_U1,   /* the u1 at count_offset says it */
	SBF_COUNT_U2,   /* the u2 at count_offset says it */
	SBF_COUNT_BIT,  /* once if bit `count_bit` of the u2 at count_offset is set */
	SBF_COUNT_BITS, /* the number of set bits in the lowest `count_bit` bits of the u1 at count_offset */
	SBF_COUNT_FIXED /* always `count_bit` times */
} fw_sbf_count;

/* A group of equal sub-blocks. Its first sub-block starts where the fixed part (start > 0) says, or (start == 0)
 * where the previous group ended. Each sub-block is `size` bytes, or as many as the u1 at size_offset says.
 * Sub-blocks counted by SBF_COUNT_BIT are optional parts of the block's one record; all others whose fields have
 * columns make a record each. */
typedef struct fw_sbf_group {
	const char *name;
	uint16_t start;
	uint8_t count; /* fw_sbf_count */
	uint8_t count_bit;
	uint16_t count_offset; /* from the start of the block; in a nested group, of the parent sub-block */
	uint16_t size_offset;  /* of the u1 sub-block length, from the start of the BLOCK; 0: always `size` */
	uint16_t size;         /* length of the fields listed [bytes] */
	uint16_t n_fields;
	const fw_sbf_field *fields;
	const struct fw_sbf_group *nested; /* follows each sub-block of this group; NULL: none */
} fw_sbf_group;

typedef enum { SBF_TIME_RECEIVER, SBF_TIME_SIS, SBF_TIME_EXTERNAL } fw_sbf_time;

typedef struct {
	uint16_t id;      /* block number, 13 bits */
	uint8_t revision; /* newest revision known */
	uint8_t time;     /* fw_sbf_time: what the stamp means */
	const char *name; /* as in the reference guide */
	fw_kind kind;     /* the record it becomes; FW_RECORD_COUNT: none, or sbf_measurements.c makes it */
	uint16_t size;    /* length of the fixed part up to the last field listed [bytes], header included */
	uint16_t n_fields;
	const fw_sbf_field *fields; /* of the fixed part, from offset 14 on, in ascending order, gap-free */
	uint16_t n_groups;
	const fw_sbf_group *groups;
} fw_sbf_schema;

/* All blocks that furrow knows the layout of, ascending by number. */
extern const fw_sbf_schema fw_sbf_schemas[];
extern const int fw_sbf_n_schemas;

/* The schema of a block number, or NULL. */
const fw_sbf_schema *fw_sbf_schema_find(uint16_t id);

/* The name of a block number, also of blocks whose layout is not known; "" when even that is unknown. */
const char *fw_sbf_block_name(uint16_t id);

#endif
