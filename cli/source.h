/* Where a tool's records come from: files of any kind that furrow knows, found out from their first bytes. */
#ifndef FURROW_CLI_SOURCE_H
#define FURROW_CLI_SOURCE_H

#include "formats/imu_columns.h"
#include "formats/record.h"
#include "inventory.h"
#include "sinks.h"
#include "tool.h"

/* The memory that reading a file takes: 20 MiB of address space, of which a file touches what its format needs, mostly below 1 MiB. */
typedef struct source_readers source_readers;

/* How logs of other devices are to be read; options of the tools, see log_plan_make(). */
typedef struct {
	fw_imu_plan table; /* --imu-columns, --imu-axes, --imu-time */
	int instance;      /* --imu-instance: of an autopilot's log; -1: the first healthy one */
	double lag_s;      /* --gps-lag: latency of its positions; NaN: as the log says */
} log_plan;

typedef struct {
	fw_kind_set wanted;
	fw_kind table;        /* the type that a table must be; FW_RECORD_COUNT: found from its columns */
	unsigned antennas;    /* FW_ANTENNA_... */
	unsigned nav_sources; /* FW_NAV_... */
	bool no_carriers;     /* of RINEX observations: nobody wants carrier phases, which saves time */
	inventory *blocks;    /* count blocks instead of decoding them; NULL: decode */
	const char *progress; /* auto, always or never */
	const log_plan *logs; /* NULL: tables of sensor data only where they explain themselves */
	sink_set *sinks;      /* flushed when the input pauses; reading ends when they fail. NULL: none */

	/* For threads that read at the same time as others. */
	source_readers *readers; /* of this thread; NULL: the one set that all others share */
	void (*pause)(
	    void *context); /* called when the input pauses, in place of flushing the sinks; NULL: none */
	void *pause_context;
} source_plan;

/* Sums over all files. */
typedef struct {
	uint64_t blocks;        /* intact SBF blocks */
	uint64_t records;       /* rows or events read from other kinds of files */
	uint64_t lost;          /* blocks, rows or events damaged, cut short or refused */
	uint64_t bytes_skipped; /* bytes that belong to no block */
	uint64_t unknown;       /* blocks of unknown numbers */
	fw_kind_set offered;    /* record types that the files have, wanted or not */
} source_totals;

/* Reads a file to its end; records go to `sink`, messages to stderr. Returns an exit status: EXIT_COMPLETE,
 * EXIT_PARTIAL (something was lost) or EXIT_IO. */
int source_read(tool *t, const char *path, const source_plan *plan, fw_sink sink, source_totals *totals);

/* Memory for one more thread that reads, zeroed; NULL: there is none. The caller gives it back; r may be NULL. */
source_readers *source_readers_new(void);
void source_readers_free(source_readers *r);

/* Reads n files one after the other, standard input if there are none. Ends early when it is interrupted or the plan's
 * sinks fail. Returns the worst exit status. */
int source_read_all(tool *t, int n, char **files, const source_plan *plan, fw_sink sink,
                    source_totals *totals);

/* Fills a plan from the texts of --imu-columns, --imu-axes and --imu-time; NULL: not given. Returns EXIT_COMPLETE, or
 * EXIT_USAGE after a message. */
int log_plan_make(const tool *t, const char *columns, const char *axes, const char *time, log_plan *plan);

/* Says which record types the files have, because none of those wanted was among them. */
void source_offer(const tool *t, const source_totals *totals);

/* The closing line: what was read, what was lost, what came of it. */
void source_summary(const tool *t, const source_totals *totals, uint64_t rows);

#endif
