/* sbf2csv: Septentrio receiver logs to CSV, streams and LCM logs. See sbf2csv(1). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "formats/input.h"
#include "formats/sbf_decoder.h"
#include "formats/sbf_frame.h"
#include "inventory.h"
#include "options.h"
#include "output.h"
#include "sinks.h"
#include "source.h"
#include "tool.h"

static const option table[] = {
    {"output", 'o', OPTION_TEXT, "FILE", NULL, "write to FILE instead of standard output", 0, 0},
    {"types", 't', OPTION_TEXT, "TYPE[,TYPE]", NULL, "record types wanted", 0, 0},
    {"stream", 's', OPTION_FLAG, NULL, NULL, "write a stream of several types", 0, 0},
    {"format", 'f', OPTION_CHOICE, "csv|lcm|rinex", "csv",
     "text, an LCM event log, or RINEX 3 files in --split DIR", 0, 0},
    {"split", 0, OPTION_TEXT, "DIR", NULL, "write one table per type to DIR/TYPE.csv, or RINEX files", 0, 0},
    {"list", 0, OPTION_FLAG, NULL, NULL, "write an inventory of the blocks instead", 0, 0},
    {"from", 0, OPTION_TIME, "TIME", NULL, "leave out what is before TIME", 0, 0},
    {"until", 0, OPTION_TIME, "TIME", NULL, "leave out what is at TIME and after", 0, 0},
    {"every", 0, OPTION_NUMBER, "SECONDS", NULL, "keep epochs at multiples of SECONDS", 0.001, 604800},
    {"antenna", 0, OPTION_CHOICE, "main|aux1|aux2|all", "main", "antenna whose measurements are wanted", 0,
     0},
    {"nav", 0, OPTION_CHOICE, "both|decoded|raw", "both", "where navigation messages come from", 0, 0},
    {"imu-columns", 0, OPTION_TEXT, "MAP", NULL, "what the columns of a table of sensor data are", 0, 0},
    {"imu-axes", 0, OPTION_TEXT, "AXES", NULL, "where that sensor's axes point: FRD, FLU, RFU or -y,x,z", 0,
     0},
    {"imu-time", 0, OPTION_TEXT, "SCALE", NULL, "what its time counts", 0, 0},
    {"imu-instance", 0, OPTION_NUMBER, "N", NULL, "which IMU of an autopilot's log, from 0", 0, 15},
    {"gps-lag", 0, OPTION_NUMBER, "SECONDS", NULL, "latency of the positions in an autopilot's log", -10, 10},
    {"lcm-url", 0, OPTION_TEXT, "URL", NULL, "publish by LCM instead of writing", 0, 0},
    {"quiet", 'q', OPTION_FLAG, NULL, NULL, "only messages about errors that end the run", 0, 0},
    {"verbose", 'v', OPTION_FLAG, NULL, NULL, "every message, however often it repeats", 0, 0},
    {"progress", 0, OPTION_CHOICE, "auto|always|never", "auto", "show how much has been read", 0, 0},
};

/* Large, and one of each: static, so that what is not used costs nothing. */
static options opts = {
    .tool = "sbf2csv",
    .synopsis = "[options] [FILE...]",
    .purpose = "Septentrio receiver logs (SBF) to CSV tables, streams and LCM logs.",
    .table = table,
    .n = sizeof table / sizeof table[0],
};
static tool self = {.name = "sbf2csv"};
static inventory blocks;
static sink_set sinks;

static void all_types(fw_kind_set *wanted)
{
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++)
		fw_kind_add(wanted, kind);
}

/* What the options ask for, as the sinks and the source want it. Returns EXIT_COMPLETE or EXIT_USAGE. */
static int make_plan(sink_plan *sink, source_plan *source)
{
	const char *types = options_text(&opts, "types"), *split = options_text(&opts, "split");
	const char *url = options_text(&opts, "lcm-url"), *antenna = options_text(&opts, "antenna");
	const char *nav = options_text(&opts, "nav");
	const char *format = options_text(&opts, "format");
	int stream = options_flag(&opts, "stream"), lcm = strcmp(format, "lcm") == 0,
	    rinex = strcmp(format, "rinex") == 0;
	int n = 0;

	self.quiet = options_flag(&opts, "quiet");
	self.verbose = options_flag(&opts, "verbose");
	sink->table = FW_pvt;
	if (types != NULL &&
	    (n = sinks_parse_types(&self, types, NULL, 0, &source->wanted, &sink->table)) == 0)
		return EXIT_USAGE;
	sink->mode = url != NULL     ? SINK_PUBLISH
	             : rinex         ? SINK_RINEX
	             : split != NULL ? SINK_SPLIT
	             : lcm           ? SINK_LCM
	             : stream        ? SINK_STREAM
	                             : SINK_TABLE;
	if ((split != NULL) + (url != NULL) + (options_text(&opts, "output") != NULL) > 1 ||
	    (stream && split != NULL)) {
		tool_error(&self,
		           "--output, --split and --lcm-url exclude each other; so do --stream and --split");
		return EXIT_USAGE;
	}
	if (rinex && split == NULL) {
		tool_error(&self, "--format rinex makes several files: --split DIR says where");
		return EXIT_USAGE;
	}
	if (sink->mode == SINK_TABLE && n > 1) {
		tool_error(&self,
		           "a table holds one type; add -s for a stream, or --split DIR for one table each");
		return EXIT_USAGE;
	}
	if (types == NULL && sink->mode == SINK_TABLE)
		fw_kind_add(&source->wanted, FW_pvt);
	else if (types == NULL && rinex)
		rinex_files_wanted(&source->wanted);
	else if (types == NULL)
		all_types(&source->wanted);
	sink->path = split != NULL ? split : url != NULL ? url : options_text(&opts, "output");
	sink->from = options_time(&opts, "from");
	sink->until = options_time(&opts, "until");
	sink->every_ns =
	    options_text(&opts, "every") != NULL ? llround(options_number(&opts, "every") * 1e9) : 0;
	source->table = types != NULL && n == 1 ? sink->table : FW_RECORD_COUNT;
	source->antennas = strcmp(antenna, "all") == 0    ? FW_ANTENNA_ALL
	                   : strcmp(antenna, "aux1") == 0 ? FW_ANTENNA_AUX1
	                   : strcmp(antenna, "aux2") == 0 ? FW_ANTENNA_AUX2
	                                                  : FW_ANTENNA_MAIN;
	source->nav_sources = strcmp(nav, "raw") == 0       ? FW_NAV_RAW
	                      : strcmp(nav, "decoded") == 0 ? FW_NAV_DECODED
	                                                    : FW_NAV_RAW | FW_NAV_DECODED;
	source->blocks = options_flag(&opts, "list") ? &blocks : NULL;
	source->progress = options_text(&opts, "progress");
	return EXIT_COMPLETE;
}

/* How the logs of other devices are to be read. Returns EXIT_COMPLETE or EXIT_USAGE. */
static int make_log_plan(log_plan *logs)
{
	int status = log_plan_make(&self, options_text(&opts, "imu-columns"), options_text(&opts, "imu-axes"),
	                           options_text(&opts, "imu-time"), logs);
	if (options_text(&opts, "imu-instance") != NULL)
		logs->instance = (int)options_number(&opts, "imu-instance");
	if (options_text(&opts, "gps-lag") != NULL)
		logs->lag_s = options_number(&opts, "gps-lag");
	return status;
}

static int write_inventory(int status, const source_totals *totals)
{
	output out;
	if (status == EXIT_IO)
		return status;
	if (output_open(&out, options_text(&opts, "output")) == FW_OK) {
		inventory_write(&blocks, &out);
		if (totals->blocks == 0 && out.error == 0) {
			output_discard(&out);
			return EXIT_NO_DATA;
		}
		if (output_commit(&out) == FW_OK)
			return status;
	}
	tool_error(&self, "%s: %s", out.path, strerror(out.error));
	return EXIT_IO;
}

/* Ends the output and says in one line what came of it. */
static int finish(int status, source_totals *totals)
{
	int interrupted = tool_interrupted();
	sinks_stop(&sinks);
	totals->lost += sinks_refused(&sinks);
	int complete = status == EXIT_COMPLETE && !interrupted && totals->lost == 0;
	uint64_t rows = sinks_rows(&sinks);

	tool_repeats(&self);
	if (sinks_end(&sinks, &self, complete, totals->lost, rows > 0 && status != EXIT_IO && !interrupted) !=
	    FW_OK)
		return EXIT_IO;
	source_summary(&self, totals, rows);
	if (interrupted)
		return tool_die_of(interrupted);
	if (status >= EXIT_USAGE)
		return status;
	if (rows == 0) {
		source_offer(&self, totals);
		return EXIT_NO_DATA;
	}
	return complete ? EXIT_COMPLETE : EXIT_PARTIAL;
}

int main(int argc, char **argv)
{
	sink_plan to = {0};
	source_plan from = {0};
	log_plan logs;
	source_totals totals = {0};

	tool_hold_standard_streams();
	switch (options_parse(&opts, argc, argv)) {
	case OPTIONS_DONE: return tool_end_answer(&self);
	case OPTIONS_WRONG: return EXIT_USAGE;
	case OPTIONS_FAILED: return EXIT_IO;
	case OPTIONS_RUN: break;
	}
	if (make_plan(&to, &from) != EXIT_COMPLETE || make_log_plan(&logs) != EXIT_COMPLETE)
		return EXIT_USAGE;
	from.logs = &logs;
	tool_catch_signals();
	const int n = argc - opts.first_file;
	char **const files = argv + opts.first_file;
	if (from.blocks != NULL) {
		int status = source_read_all(&self, n, files, &from, sinks_head(&sinks), &totals);
		source_summary(&self, &totals, totals.blocks);
		return tool_interrupted() ? tool_die_of(tool_interrupted())
		                          : write_inventory(status, &totals);
	}
	if (sinks_begin(&sinks, &to, &self, &opts, argc, argv) != FW_OK)
		return tool_interrupted() ? tool_die_of(tool_interrupted()) : EXIT_IO;
	from.sinks = &sinks;
	return finish(source_read_all(&self, n, files, &from, sinks_head(&sinks), &totals), &totals);
}
