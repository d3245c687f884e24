/* A record with its strings in one piece of memory, for those who keep it longer than its maker does. */
#ifndef FURROW_CLI_RECORD_COPY_H
#define FURROW_CLI_RECORD_COPY_H

#include "formats/record.h"

/* To be called before the first copy, and before there are threads. */
void record_copy_prepare(void);

/* Bytes that the copy of a record takes. */
size_t record_copy_size(fw_kind kind, const void *record);

/* Copies a record, strings and all; `to` is aligned as structs are. */
void record_copy(fw_kind kind, const void *record, char *to);

#endif
