#include "record_copy.h"

#include <string.h>

enum { STRINGS_MOST = 16 };

/* Where the strings of a type are: offsets in the struct [bytes]. */
static struct {
	uint8_t n;
	uint16_t member[STRINGS_MOST];
	uint16_t size;
} types[FW_RECORD_COUNT];

void record_copy_prepare(void)
{
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++) {
		const fw_record_type *type = fw_record_type_of(kind);
		types[kind].n = 0;
		types[kind].size = type->size;
		for (int i = 0; i < type->n_columns; i++)
			if (type->columns[i].type == FW_STR)
				types[kind].member[types[kind].n++] = type->columns[i].offset;
	}
}

static const char *string_of(fw_kind kind, unsigned i, const char *record)
{
	const char *text;
	memcpy(&text, record + types[kind].member[i], sizeof text);
	return text;
}

size_t record_copy_size(fw_kind kind, const void *record)
{
	size_t n = types[kind].size;
	for (unsigned i = 0; i < types[kind].n; i++) {
		const char *text = string_of(kind, i, record);
		n += text != NULL ? strlen(text) + 1 : 0;
	}
	return n;
}

void record_copy(fw_kind kind, const void *record, char *to)
{
	char *end = to + types[kind].size;
	memcpy(to, record, types[kind].size);
	for (unsigned i = 0; i < types[kind].n; i++) {
		const char *text = string_of(kind, i, record);
		if (text == NULL)
			continue;
		const size_t n = strlen(text) + 1;
		memcpy(to + types[kind].member[i], &end, sizeof end);
		memcpy(end, text, n);
		end += n;
	}
}
