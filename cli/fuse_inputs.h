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

/* A stamp so far ahead of those before is not believed at once [ns]. */
#define FUSE_LEAP_NS (10 * FW_NS_PER_S)

typedef struct fuse_source fuse_source;

typedef struct {
	tool *owner;
	sink_set *sinks; /* flushed when all wait; when they fail reading ends. NULL: none */
	unsigned n;
	fuse_source *source[FUSE_SOURCES];
} fuse_inputs;

/* A record; its memory is the reader's until the next call. */
typedef struct {
	fw_kind kind;
	const void *record;
	bool timed;    /* it has a time stamp */
	bool mistimed; /* it has one that cannot be, or none though others of its type had */
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
 * records of each source decide, so that a single wrong time stamp does not, and a leap ahead has to be
 * confirmed by a hundred. */
fw_time fuse_inputs_horizon(const fuse_inputs *in);

/* The latest time that was believed. When all sources have ended, what is later by FUSE_LEAP_NS has a wrong time. */
fw_time fuse_inputs_latest(const fuse_inputs *in);

/* Ends the threads and gives back the memory. Sums go to *totals. Returns the worst exit status of all sources. */
int fuse_inputs_end(fuse_inputs *in, source_totals *totals);

#endif
