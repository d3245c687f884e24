/* Where a tool's records come from: files of any kind that furrow knows, found out from their first bytes. */
#ifndef FURROW_CLI_SOURCE_H
#define FURROW_CLI_SOURCE_H

#include "formats/record.h"
#include "inventory.h"
#include "sinks.h"
#include "tool.h"

typedef struct {
	fw_kind_set wanted;
	fw_kind table;        /* the type that a table must be; FW_RECORD_COUNT: found from its columns */
	unsigned antennas;    /* FW_ANTENNA_... */
	unsigned nav_sources; /* FW_NAV_... */
	inventory *blocks;    /* count blocks instead of decoding them; NULL: decode */
	const char *progress; /* auto, always or never */
	sink_set *sinks;      /* flushed when the input pauses; reading ends when they fail. NULL: none */
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

/* Says which record types the files have, because none of those wanted was among them. */
void source_offer(const tool *t, const source_totals *totals);

/* The closing line: what was read, what was lost, what came of it. */
void source_summary(const tool *t, const source_totals *totals, uint64_t rows);

#endif
