/* Several files read at once, each by a thread of its own, their records in one sequence by time.
 *
 * Every source is taken to be in order of time but for small disorder (a receiver logs a position some time after the
 * moment it is for). The source that is furthest behind is always read next, so that nobody runs ahead and memory
 * stays bounded; what is left of disorder is for fuse_order.h. */
#ifndef FURROW_CLI_FUSE_INPUTS_H
#define FURROW_CLI_FUSE_INPUTS_H

#include <stdbool.h>

#include "formats/record.h"
#include "sinks.h"
#include "source.h"
#include "tool.h"

enum { FUSE_SOURCES = 16 };

typedef struct fuse_source fuse_source;

typedef struct {
	tool *owner;
	sink_set *sinks; /* flushed when all wait; when they fail reading ends */
	unsigned n;
	fuse_source *source[FUSE_SOURCES];
} fuse_inputs;

/* A record; its memory is the reader's until the next call. */
typedef struct {
	fw_kind kind;
	const void *record;
	bool timed; /* it has a time stamp */
	fw_time time;
} fuse_record;

void fuse_inputs_begin(fuse_inputs *in, tool *owner, sink_set *sinks);

/* One more source. Reading begins at once.
 *   path  in  a file, or "-"; it has to outlive the reading
 *   plan  in  what is wanted; copied
 * Returns EXIT_COMPLETE, or EXIT_USAGE (too many) or EXIT_IO (no memory, no thread) after a message. */
int fuse_inputs_add(fuse_inputs *in, const char *path, const source_plan *plan);

/* The next record. Returns false when there are no more, when the sinks have failed or a signal came. */
bool fuse_inputs_next(fuse_inputs *in, fuse_record *r);

/* No record before this time is to be expected any more; INT64_MAX when all sources have ended. The latest few
 * records of each source decide, so that a single wrong time stamp does not. */
fw_time fuse_inputs_horizon(const fuse_inputs *in);

/* Ends the threads and gives back the memory. Sums go to *totals. Returns the worst exit status of all sources. */
int fuse_inputs_end(fuse_inputs *in, source_totals *totals);

#endif
