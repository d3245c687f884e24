/* Where a tool's records end up: a table, a stream, an LCM log, a table for each type, RINEX files, or the network. */
#ifndef FURROW_CLI_SINKS_H
#define FURROW_CLI_SINKS_H

#include "formats/csv.h"
#include "formats/lcm_log.h"
#include "formats/record.h"
#include "options.h"
#include "output.h"
#include "relay.h"
#include "rinex_files.h"
#include "tool.h"

typedef enum { SINK_TABLE, SINK_STREAM, SINK_LCM, SINK_SPLIT, SINK_RINEX, SINK_PUBLISH } sink_mode;

typedef struct {
	sink_mode mode;
	const char *path;            /* file, folder or URL; NULL: stdout */
	fw_kind table;               /* the type of a table */
	const fw_time *from, *until; /* NULL: no limit */
	int64_t every_ns;            /* 0: all epochs */
} sink_plan;

/* One output with its writer; of a split there is one for each type that occurs. */
typedef struct {
	output out;
	union {
		fw_csv_writer csv;
		fw_lcm_writer lcm;
	} writer;
} sink_file;

typedef struct {
	sink_plan plan;
	const tool *owner;
	relay relay;                       /* between the filter and the writer */
	fw_sink writer;                    /* behind the filter: the relay */
	sink_file file;                    /* unless split */
	sink_file *split[FW_RECORD_COUNT]; /* made when the first record of a type comes */
	rinex_files *rinex;                /* of a RINEX sink */
	struct _lcm_t *lcm;                /* when publishing */
	uint64_t published;
	int64_t next_publish_ns;
	_Atomic int failed; /* a message about it has been or will be given by sinks_end */
} sink_set;

/* The record types that --types names, "obs,pvt", to a set.
 *   allowed  in   of these n_allowed; NULL: of all
 *   wanted   out
 *   first    out  the first one named
 * Returns how many they are, 0 after a message. */
int sinks_parse_types(const tool *t, const char *text, const fw_kind *allowed, int n_allowed,
                      fw_kind_set *wanted, fw_kind *first);

/* Opens the output and writes its head: provenance from argv, settings. Returns FW_EIO after a message. */
fw_status sinks_begin(sink_set *s, const sink_plan *plan, const tool *owner, const options *o, int argc,
                      char **argv) FW_MUST_CHECK;

/* Where records are to be put: the filter by time, if there is one, then the writer. */
fw_sink sinks_head(sink_set *s);

/* Hands all records so far to the output. For inputs that pause, such as a live pipe. */
void sinks_flush(sink_set *s);

/* Whether going on is of no use. */
int sinks_failed(const sink_set *s);

/* There will be no more records: waits until all have reached the writer. To be called before the next two. */
void sinks_stop(sink_set *s);

/* Rows written, and records that were too long for a row or an event. */
uint64_t sinks_rows(const sink_set *s);
uint64_t sinks_refused(const sink_set *s);

/* Writes the end and closes. With `keep` files take their place, without it targets stay as they were.
 * Returns FW_EIO after a message. */
fw_status sinks_end(sink_set *s, const tool *t, int complete, uint64_t lost, int keep) FW_MUST_CHECK;

#endif
