/* Tests of the readers of other devices' logs: records of all kinds as numbers by their columns' names. */
#ifndef FURROW_TESTS_LOG_TEST_H
#define FURROW_TESTS_LOG_TEST_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/record.h"

#include "../log_bytes.h"

/* A column's value; NaN: absent. */
static inline double number_of(fw_kind kind, const fw_any_record *record, const char *name)
{
	const fw_record_type *type = fw_record_type_of(kind);
	const int i = fw_record_column(type, name, strlen(name));
	const char *member = record->bytes + type->columns[i < 0 ? 0 : i].offset;
	double d;
	float f;
	int32_t w;
	int16_t h;

	if (i < 0)
		fail_msg("no column %s", name);
	if (!(record->head.present >> i & 1))
		return (double)NAN;
	switch (type->columns[i].type) {
	case FW_F64: memcpy(&d, member, sizeof d); return d;
	case FW_F32: memcpy(&f, member, sizeof f); return (double)f;
	case FW_I32: memcpy(&w, member, sizeof w); return w;
	case FW_I16: memcpy(&h, member, sizeof h); return h;
	default: return *(const signed char *)member;
	}
}

static inline const char *text_of(fw_kind kind, const fw_any_record *record, const char *name)
{
	const fw_record_type *type = fw_record_type_of(kind);
	const int i = fw_record_column(type, name, strlen(name));
	const char *text;

	memcpy(&text, record->bytes + type->columns[i].offset, sizeof text);
	return record->head.present >> i & 1 ? text : "";
}

static inline void assert_near(double a, double b, double tolerance)
{
	if (!(fabs(a - b) <= tolerance))
		fail_msg("%.15g is not %.15g", a, b);
}

/* Columns "name=value name=value" of a record, each to a relative 1e-9. */
static inline void assert_columns(fw_kind kind, const fw_any_record *record, const char *expected)
{
	char name[64];

	while (*expected != '\0') {
		const size_t n = strcspn(expected, "=");
		char *end;

		memcpy(name, expected, n);
		name[n] = '\0';
		const double value = strtod(expected + n + 1, &end);
		const double is = number_of(kind, record, name);
		if (isnan(value) ? !isnan(is) : !(fabs(is - value) <= 1e-9 * (1 + fabs(value))))
			fail_msg("%s is %.15g, not %.15g", name, is, value);
		expected = *end == ' ' ? end + 1 : end;
	}
}

#endif
