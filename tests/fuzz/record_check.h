/* What must hold of every record that a decoder hands out. */
#ifndef FURROW_TESTS_FUZZ_RECORD_CHECK_H
#define FURROW_TESTS_FUZZ_RECORD_CHECK_H

#include <string.h>

#include "formats/record.h"

#include "fuzz.h"

/* The `put` of a fw_sink: only columns of the type are present, strings that are present exist and end, and the
 * record survives its own encoding. */
static inline void record_check(void *context, fw_kind kind, const void *record)
{
	static uint8_t bytes[256 * 1024];
	const fw_record_type *type = fw_record_type_of(kind);
	const fw_record_head *head = record;
	fw_any_record again;
	size_t n;

	(void)context;
	require((uint64_t)head->present >> (type->n_columns - 1) < 2);
	for (int i = 0; i < type->n_columns; i++) {
		const char *text;
		if (type->columns[i].type != FW_STR || !(head->present >> i & 1))
			continue;
		memcpy(&text, (const char *)record + type->columns[i].offset, sizeof text);
		require(text != NULL && strlen(text) < sizeof bytes / 2);
	}
	require(fw_record_encode(kind, record, bytes, sizeof bytes, &n) == FW_OK);
	require(fw_record_decode(kind, bytes, n, &again) == FW_OK);
}

#endif
