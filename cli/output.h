/* Where a tool's data goes: stdout, or a file that is written aside and renamed when it is whole, so that the
 * target is at all times the old file or the new one, never half of it. */
#ifndef FURROW_CLI_OUTPUT_H
#define FURROW_CLI_OUTPUT_H

#include <limits.h>
#include <stddef.h>

#include "base/status.h"

typedef struct {
	int fd;
	_Atomic int error; /* errno of the first failure, 0: none */
	char path[PATH_MAX];
	char aside[PATH_MAX]; /* "" for stdout */
} output;

/* Opens `path` for writing; NULL or "-" is stdout. Returns FW_EIO with out->error set. */
fw_status output_open(output *out, const char *path) FW_MUST_CHECK;

/* Writes n bytes; the first failure sticks. The signature is that of the writers' flush callbacks. */
fw_status output_write(void *out, const void *bytes, size_t n) FW_MUST_CHECK;

/* Flushes to disk and closes: the first half of a commit, for those who have several files to commit. Returns FW_EIO
 * with out->error set when a step or an earlier write failed. */
fw_status output_finish(output *out) FW_MUST_CHECK;

/* Finishes and renames. Returns FW_EIO with out->error set when any step or an earlier write failed; the target is then
 * untouched and nothing stays behind. */
fw_status output_commit(output *out) FW_MUST_CHECK;

/* Gives up: closes and removes what was written aside. Data that went to stdout stays written. */
void output_discard(output *out);

#endif
