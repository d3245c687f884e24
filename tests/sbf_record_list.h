/* Records that a decoder emitted, kept for a look at their columns. */
#ifndef FURROW_TESTS_SBF_RECORD_LIST_H
#define FURROW_TESTS_SBF_RECORD_LIST_H

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "formats/record.h"

enum { LIST_MOST = 300, LIST_TEXT = 20000 };

typedef struct {
	size_t n; /* emitted; only the first LIST_MOST are kept */
	struct {
		fw_kind kind;
		fw_any_record record;
	} at[LIST_MOST];
	size_t used;
	char text[LIST_TEXT]; /* strings are the maker's only until it returns */
} record_list;

static inline void list_put(void *context, fw_kind kind, const void *record)
{
	record_list *list = context;
	if (list->n >= LIST_MOST) {
		list->n++;
		return;
	}
	const fw_record_type *type = fw_record_type_of(kind);
	fw_any_record *copy = &list->at[list->n].record;
	list->at[list->n++].kind = kind;
	memcpy(copy, record, type->size);
	for (int i = 0; i < type->n_columns; i++) {
		const char *text;
		if (type->columns[i].type != FW_STR)
			continue;
		memcpy(&text, copy->bytes + type->columns[i].offset, sizeof text);
		size_t n = text ? strlen(text) + 1 : 1;
		char *kept = list->text + list->used;
		assert_true(list->used + n <= LIST_TEXT);
		memcpy(kept, text ? text : "", n);
		memcpy(copy->bytes + type->columns[i].offset, &kept, sizeof kept);
		list->used += n;
	}
}

static inline void list_clear(record_list *list)
{
	list->n = list->used = 0;
}

static inline bool column_present(const void *record, int column)
{
	fw_record_head head;
	memcpy(&head, record, sizeof head);
	return head.present >> column & 1;
}

static inline const char *column_text(const fw_record_type *type, const void *record, int column)
{
	const char *text;
	memcpy(&text, (const char *)record + type->columns[column].offset, sizeof text);
	return text ? text : "";
}

/* Any number as a double, whether present or not. */
static inline double column_number(const fw_record_type *type, const void *record, int column)
{
	const char *p = (const char *)record + type->columns[column].offset;
	union {
		int8_t i8;
		int16_t i16;
		int32_t i32;
		int64_t i64;
		float f32;
		double f64;
	} u;
	static const size_t sizes[] = {
	    [FW_I8] = 1, [FW_I16] = 2, [FW_I32] = 4, [FW_I64] = 8, [FW_F32] = 4, [FW_F64] = 8};
	memcpy(&u, p, sizes[type->columns[column].type]);
	switch (type->columns[column].type) {
	case FW_I8: return u.i8;
	case FW_I16: return u.i16;
	case FW_I32: return u.i32;
	case FW_I64: return (double)u.i64;
	case FW_F32: return (double)u.f32;
	default: return u.f64;
	}
}

static inline int column_index(const fw_record_type *type, const char *name)
{
	int column = fw_record_column(type, name, strlen(name));
	if (column < 0)
		fail_msg("%s has no column %s", type->name, name);
	return column;
}

/* The column `name` of the i-th record; NaN when it is absent. */
static inline double list_number(const record_list *list, size_t i, const char *name)
{
	const fw_record_type *type = fw_record_type_of(list->at[i].kind);
	int column = column_index(type, name);
	return column_present(&list->at[i].record, column) ? column_number(type, &list->at[i].record, column)
	                                                   : (double)NAN;
}

static inline const char *list_text(const record_list *list, size_t i, const char *name)
{
	const fw_record_type *type = fw_record_type_of(list->at[i].kind);
	int column = column_index(type, name);
	return column_present(&list->at[i].record, column) ? column_text(type, &list->at[i].record, column)
	                                                   : "absent";
}

/* Fails unless the column equals `expected` to `relative`; NaN expects an absent one. */
static inline void expect_number(const record_list *list, size_t i, const char *name, double expected,
                                 double relative)
{
	assert_true(i < list->n);
	double got = list_number(list, i, name);
	if (isnan(expected) ? !isnan(got) : !(fabs(got - expected) <= fabs(expected) * relative))
		fail_msg("%s is %.17g, not %.17g", name, got, expected);
}

static inline size_t bytes_from_hex(const char *hex, uint8_t *out)
{
	size_t n = strlen(hex) / 2;
	for (size_t i = 0; i < n; i++) {
		const char pair[3] = {hex[2 * i], hex[2 * i + 1], '\0'};
		out[i] = (uint8_t)strtoul(pair, NULL, 16);
	}
	return n;
}

#endif
