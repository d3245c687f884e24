/* Records with random content, for round trips. */
#ifndef FURROW_TESTS_RANDOM_RECORD_H
#define FURROW_TESTS_RANDOM_RECORD_H

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/random.h"
#include "formats/record.h"

/* A double as a log has it, or one of the kind that breaks things. */
static inline double random_double(fw_random *r)
{
	static const double odd[] = {0,   -0.0,     1e-300, -5e-324,     1.7976931348623157e308,
	                             0.1, -0.00005, 1e22,   (double)NAN, (double)INFINITY};
	uint64_t bits;
	double x;

	switch (fw_random_below(r, 20)) {
	case 0: return odd[fw_random_below(r, sizeof odd / sizeof *odd)];
	case 1: bits = fw_random_u64(r), memcpy(&x, &bits, sizeof x); return x;
	default: return (fw_random_uniform(r) - 0.5) * (fw_random_below(r, 2) ? 6e7 : 1);
	}
}

static inline float random_float(fw_random *r)
{
	const uint32_t bits = (uint32_t)fw_random_u64(r);
	float x;

	switch (fw_random_below(r, 8)) {
	case 0: return -0.0F;
	case 1: memcpy(&x, &bits, sizeof x); return x;
	default: return (float)(fw_random_uniform(r) - 0.5);
	}
}

/* Any bit pattern, or a small number, or an end of a type's range. */
static inline int64_t random_integer(fw_random *r)
{
	static const int64_t ends[] = {INT8_MIN,  INT8_MAX,  INT16_MIN, INT16_MAX,
	                               INT32_MIN, INT32_MAX, INT64_MIN, INT64_MAX};

	switch (fw_random_below(r, 3)) {
	case 0: return (int64_t)fw_random_u64(r);
	case 1: return ends[fw_random_below(r, sizeof ends / sizeof *ends)];
	default: return (int64_t)fw_random_below(r, 100);
	}
}

static inline const char *random_string(fw_random *r)
{
	static const char *const strings[] = {
	    "G05",
	    "1C",
	    "",
	    "a,b",
	    "say \"ah\"",
	    "\"",
	    "\"\"",
	    ",",
	    "M\xc3\xbcller \xe2\x82\xac \xf0\x9f\x9b\xb0",
	    "two\nlines",
	    "two\r\nlines",
	    "\r",
	    "\n",
	    " blanks ",
	    "tab\tbed",
	    "#pg",
	    "\x01\x7f",
	    "NaN",
	    "8B3C00FF",
	};
	return strings[fw_random_below(r, sizeof strings / sizeof *strings)];
}

/* Fills all columns of a record, and lets a fifth of them be absent. */
static inline void random_record(fw_random *r, fw_kind kind, fw_any_record *record)
{
	const fw_record_type *type = fw_record_type_of(kind);

	fw_record_clear(kind, record);
	for (int i = 0; i < type->n_columns; i++) {
		const fw_column *c = &type->columns[i];
		char *member = record->bytes + c->offset;
		const int64_t x = random_integer(r);
		const double d = random_double(r);
		const float f = random_float(r);
		const char *s = random_string(r);
		if (fw_random_below(r, 5) == 0)
			continue;
		record->head.present |= INT64_C(1) << i;
		switch (c->type) {
		case FW_I8: memcpy(member, &(int8_t){(int8_t)x}, 1); break;
		case FW_I16: memcpy(member, &(int16_t){(int16_t)x}, 2); break;
		case FW_I32: memcpy(member, &(int32_t){(int32_t)x}, 4); break;
		case FW_I64: memcpy(member, &x, 8); break;
		case FW_F32: memcpy(member, &f, 4); break;
		case FW_F64: memcpy(member, &d, 8); break;
		case FW_STR: memcpy(member, &s, sizeof s); break;
		}
	}
}

/* The first column in which two records of a kind differ, bit for bit; -1: none. */
static inline int first_difference(fw_kind kind, const fw_any_record *a, const fw_any_record *b)
{
	static const size_t sizes[] = {
	    [FW_I8] = 1, [FW_I16] = 2, [FW_I32] = 4, [FW_I64] = 8, [FW_F32] = 4, [FW_F64] = 8};
	const fw_record_type *type = fw_record_type_of(kind);
	const char *s, *t;

	for (int i = 0; i < type->n_columns; i++) {
		const fw_column *c = &type->columns[i];
		if ((a->head.present ^ b->head.present) >> i & 1)
			return i;
		if (c->type == FW_STR) {
			memcpy(&s, a->bytes + c->offset, sizeof s);
			memcpy(&t, b->bytes + c->offset, sizeof t);
			if (strcmp(s, t) != 0)
				return i;
		} else if (memcmp(a->bytes + c->offset, b->bytes + c->offset, sizes[c->type]) != 0) {
			return i;
		}
	}
	return -1;
}

/* An output into memory, for writers under test. */
typedef struct {
	char *bytes;
	size_t size, used;
} memory;

static inline fw_status to_memory(void *context, const void *bytes, size_t n)
{
	memory *m = context;

	if (n > m->size - m->used)
		return FW_EIO;
	memcpy(m->bytes + m->used, bytes, n);
	m->used += n;
	return FW_OK;
}

#endif
