/* pl-monitor: protection levels and the integrity state that follows from them. See pl-monitor(1). */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "formats/sbf_decoder.h"
#include "furrow_pl.h"
#include "furrow_pl_columns.h"
#include "furrow_transition.h"
#include "furrow_transition_columns.h"
#include "integrity/state_machine.h"
#include "options.h"
#include "receiver_levels.h"
#include "sinks.h"
#include "source.h"
#include "tool.h"

static const option table[] = {
    {"output", 'o', OPTION_TEXT, "FILE", NULL, "write to FILE instead of standard output", 0, 0},
    {"types", 't', OPTION_TEXT, "TYPE[,TYPE]", NULL, "what to write: pl, transition", 0, 0},
    {"stream", 's', OPTION_FLAG, NULL, NULL, "write a stream: what was read, and the states", 0, 0},
    {"format", 'f', OPTION_CHOICE, "csv|lcm", "csv", "text, or an LCM event log", 0, 0},
    {"source", 0, OPTION_CHOICE, "receiver", "receiver", "where the protection levels come from", 0, 0},
    {"hal", 0, OPTION_NUMBER, "METRES", "40", "horizontal alert limit", 0.01, 1e6},
    {"val", 0, OPTION_NUMBER, "METRES", "50", "vertical alert limit", 0.01, 1e6},
    {"margin", 0, OPTION_NUMBER, "PERCENT", "0", "levels must be so far below the limits to return", 0, 99},
    {"hold", 0, OPTION_NUMBER, "SECONDS", "0", "a better state is entered after so long", 0, 86400},
    {"time-to-alert", 0, OPTION_NUMBER, "SECONDS", "0", "a worse state is entered after so long", 0, 86400},
    {"timeout", 0, OPTION_NUMBER, "SECONDS", "3", "no position when no epoch came for longer", 0.001, 86400},
    {"from", 0, OPTION_TIME, "TIME", NULL, "leave out what is before TIME", 0, 0},
    {"until", 0, OPTION_TIME, "TIME", NULL, "leave out what is at TIME and after", 0, 0},
    {"quiet", 'q', OPTION_FLAG, NULL, NULL, "only messages about errors that end the run", 0, 0},
    {"verbose", 'v', OPTION_FLAG, NULL, NULL, "every message, however often it repeats", 0, 0},
    {"progress", 0, OPTION_CHOICE, "auto|always|never", "auto", "show how much has been read", 0, 0},
};

/* Large, and one of each: static, so that what is not used costs nothing. */
static options opts = {
    .tool = "pl-monitor",
    .synopsis = "[options] [FILE...]",
    .purpose =
        "Protection levels and integrity state, epoch by epoch, from a receiver log or a furrow stream.",
    .table = table,
    .n = sizeof table / sizeof table[0],
};
static tool self = {.name = "pl-monitor"};
static sink_set sinks;
static receiver_levels levels;

/* The run: the machine, where its rows go, and the count. */
static struct {
	fw_integrity machine;
	fw_kind_set wanted; /* the types written */
	bool pass_on;       /* a stream: what was read goes on */
	fw_sink to;
	uint64_t epochs, transitions;
	uint64_t refused;    /* epochs that are not after the one before, or whose time cannot be */
	int behind;          /* how many of these just now followed each other, ... */
	fw_time last_behind; /* ... up to this one */
	uint64_t replaced;   /* states that others had put into the input */
	bool counting;       /* since `counted`: seconds are added up from there on */
	fw_time counted;
	double seconds[FW_NO_POSITION + 1]; /* by state */
} run;

/* ---- states to records ---- */

#define BIT(column) (INT64_C(1) << FW_COL_##column)

/* Strings of records are not const, but nobody writes to them. */
static char *text(const char *s)
{
	return (char *)(uintptr_t)s;
}

static void put(fw_kind kind, const void *record)
{
	if (fw_kind_in(&run.wanted, kind))
		run.to.put(run.to.context, kind, record);
}

static void put_pl(fw_time time, const level_epoch *e)
{
	furrow_pl r = {.present = BIT(pl_gps_week) | BIT(pl_tow_s) | BIT(pl_hal_m) | BIT(pl_val_m) |
	                          BIT(pl_state) | BIT(pl_source),
	               .hal_m = run.machine.rules.hal_m,
	               .val_m = run.machine.rules.val_m,
	               .state = text(fw_integrity_state_name(run.machine.state)),
	               .source = text(options_text(&opts, "source"))};
	int week;
	fw_time_to_gps_s(time, &week, &r.tow_s);
	r.gps_week = week;
	if (e != NULL && e->seen.position && e->seen.sbas) { /* without SBAS a level is no bound */
		r.hpl_m = e->seen.hpl_m;
		r.vpl_m = e->seen.vpl_m;
		r.present |= (r.hpl_m > 0 ? BIT(pl_hpl_m) : 0) | (r.vpl_m > 0 ? BIT(pl_vpl_m) : 0);
	}
	if (e != NULL && e->n_sats >= 0) {
		r.n_sats = (int16_t)e->n_sats;
		r.present |= BIT(pl_n_sats);
	}
	put(FW_pl, &r);
}

/* The time since the last row was spent in this state. */
static void count_time(fw_time until, fw_integrity_state state)
{
	if (run.counting)
		run.seconds[state] += fw_time_diff_s(until, run.counted);
	run.counting = true;
	run.counted = until;
}

static void put_transition(const fw_transition *t)
{
	furrow_transition r = {.present = (INT64_C(1) << FW_COL_transition_COUNT) - 1,
	                       .from_state = text(fw_integrity_state_name(t->from)),
	                       .to_state = text(fw_integrity_state_name(t->to)),
	                       .cause = text(fw_integrity_cause_name(t->cause))};
	int week;
	if (t->from == t->to)
		return;
	fw_time_to_gps_s(t->time, &week, &r.tow_s);
	r.gps_week = week;
	run.transitions++;
	if (self.verbose)
		tool_note(&self, "%d:%.3f: %s to %s: %s", week, r.tow_s, r.from_state, r.to_state, r.cause);
	put(FW_transition, &r);
}

/* ---- epochs to states ---- */

/* What falls due before `now`: a change of its own time, with a row that says so. */
static void let_time_pass(fw_time now)
{
	fw_transition t;
	while (fw_integrity_expire(&run.machine, now, &t)) {
		count_time(t.time, t.from);
		put_transition(&t);
		put_pl(t.time, NULL);
	}
}

/* An epoch that is not after the one before is left out. But when several of them follow each other, the one before was
 * wrong, or another log begins: then time begins anew. Returns whether it does. */
static bool begin_anew(const level_epoch *e)
{
	enum { ENOUGH = 3 };
	int week;
	double tow_s;
	fw_time_to_gps_s(e->time, &week, &tow_s);
	run.behind = fw_time_compare(e->time, run.last_behind) > 0 ? run.behind + 1 : 1;
	run.last_behind = e->time;
	if (run.behind < ENOUGH) {
		run.refused++;
		tool_warn(&self, CAUSE_ROW, "%d:%.3f: an epoch that is not after the one before, left out",
		          week, tow_s);
		return false;
	}
	tool_note(&self, "%d:%.3f: time begins anew", week, tow_s);
	fw_integrity_restart(&run.machine);
	run.counting = false;
	return true;
}

static void judge(void *unused, const level_epoch *e)
{
	fw_transition t;
	(void)unused;
	let_time_pass(e->time);
	fw_status status = fw_integrity_update(&run.machine, e->time, &e->seen, &t);
	if (status != FW_OK && begin_anew(e))
		status = fw_integrity_update(&run.machine, e->time, &e->seen, &t);
	if (status != FW_OK)
		return;
	run.behind = 0;
	run.epochs++;
	count_time(e->time, t.from);
	put_transition(&t);
	put_pl(e->time, e);
}

/* ---- reading ---- */

/* Records that come all the time: when they go on without an epoch, time passes without one. */
static bool tells_time(fw_kind kind)
{
	return kind == FW_pvt || kind == FW_pvt_ecef || kind == FW_dop || kind == FW_epoch || kind == FW_imu;
}

static bool is_inside(const void *record, fw_time *t)
{
	const fw_time *from = options_time(&opts, "from"), *until = options_time(&opts, "until");
	return fw_record_time(record, t) == FW_OK && (from == NULL || t->ns >= from->ns) &&
	       (until == NULL || t->ns < until->ns);
}

/* A time that cannot be, which is more than none. */
static void refuse_time(fw_kind kind, const void *record)
{
	fw_time t;
	const fw_status status = fw_record_time(record, &t);
	if (status >= 0 || status == FW_EINVAL || (kind != FW_pvt && kind != FW_pvt_ecef && kind != FW_dop))
		return;
	run.refused++;
	tool_warn(&self, CAUSE_ROW, "a record whose time cannot be, left out");
}

/* A record that was read. The rows of an epoch follow the record that completes it. */
static void take(void *unused, fw_kind kind, const void *record)
{
	fw_time t;
	const bool inside = is_inside(record, &t);
	(void)unused;
	if (inside)
		receiver_levels_before(&levels, kind, record);
	if (inside && tells_time(kind) && !levels.waiting)
		let_time_pass(t);
	if (kind == FW_pl || kind == FW_transition)
		run.replaced++;
	else if (run.pass_on || kind == FW_meta)
		run.to.put(run.to.context, kind, record);
	if (inside)
		receiver_levels_put(&levels, kind, record);
	else
		refuse_time(kind, record);
}

/* ---- options ---- */

static int64_t nanoseconds(const char *name)
{
	return llround(options_number(&opts, name) * 1e9);
}

static fw_status make_machine(void)
{
	const fw_integrity_rules rules = {.hal_m = options_number(&opts, "hal"),
	                                  .val_m = options_number(&opts, "val"),
	                                  .margin = options_number(&opts, "margin") / 100,
	                                  .hold_ns = nanoseconds("hold"),
	                                  .alert_ns = nanoseconds("time-to-alert"),
	                                  .timeout_ns = nanoseconds("timeout")};
	receiver_levels_begin(&levels, rules.timeout_ns, judge, NULL);
	return fw_integrity_init(&rules, &run.machine);
}

/* Which types are written: as -t says, or what the output can hold. Returns 0 after a message. */
static int make_types(sink_plan *sink)
{
	static const fw_kind own[] = {FW_pl, FW_transition};
	const char *types = options_text(&opts, "types");
	sink->table = FW_pl;
	if (types != NULL && sinks_parse_types(&self, types, own, 2, &run.wanted, &sink->table) == 0)
		return 0;
	if (types == NULL)
		fw_kind_add(&run.wanted, FW_pl);
	if (types == NULL && sink->mode != SINK_TABLE)
		fw_kind_add(&run.wanted, FW_transition);
	if (sink->mode == SINK_TABLE && fw_kind_in(&run.wanted, FW_pl) &&
	    fw_kind_in(&run.wanted, FW_transition)) {
		tool_error(&self, "a table holds one type; add -s for a stream");
		return 0;
	}
	return 1;
}

/* What the options ask for, as the sinks and the source want it. Returns EXIT_COMPLETE or EXIT_USAGE. */
static int make_plan(sink_plan *sink, source_plan *source)
{
	const int stream = options_flag(&opts, "stream"),
	          lcm = strcmp(options_text(&opts, "format"), "lcm") == 0;
	self.quiet = options_flag(&opts, "quiet");
	self.verbose = options_flag(&opts, "verbose");
	sink->mode = lcm ? SINK_LCM : stream ? SINK_STREAM : SINK_TABLE;
	if (!make_types(sink) || make_machine() != FW_OK)
		return EXIT_USAGE;
	run.pass_on = stream;
	sink->path = options_text(&opts, "output");
	sink->from = options_time(&opts, "from");
	sink->until = options_time(&opts, "until");
	receiver_levels_kinds(&source->wanted);
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++)
		if (run.pass_on || tells_time(kind))
			fw_kind_add(&source->wanted, kind);
	source->table = FW_RECORD_COUNT;
	source->antennas = FW_ANTENNA_ALL;
	source->nav_sources = FW_NAV_RAW | FW_NAV_DECODED;
	source->progress = options_text(&opts, "progress");
	return EXIT_COMPLETE;
}

/* ---- the end ---- */

static void summarise(void)
{
	double all = 0;
	char share[64] = "";
	for (int s = FW_RELIABLE; s <= FW_NO_POSITION; s++)
		all += run.seconds[s];
	if (all > 0)
		snprintf(share, sizeof share, "; available %.2f %% of %.1f s",
		         100 * run.seconds[FW_RELIABLE] / all, all);
	tool_note(&self,
	          "%" PRIu64 " epochs, %" PRIu64
	          " transition%s%s: RELIABLE %.1f s, NO_SBAS %.1f s, UNRELIABLE %.1f s, NO_POSITION %.1f s",
	          run.epochs, run.transitions, run.transitions == 1 ? "" : "s", share,
	          run.seconds[FW_RELIABLE], run.seconds[FW_NO_SBAS], run.seconds[FW_UNRELIABLE],
	          run.seconds[FW_NO_POSITION]);
	if (run.replaced > 0)
		tool_note(&self, "%" PRIu64 " rows of pl and transition in the input not passed on",
		          run.replaced);
}

static int finish(int status, source_totals *totals)
{
	const int interrupted = tool_interrupted();
	receiver_levels_flush(&levels);
	sinks_stop(&sinks);
	totals->lost += run.refused + sinks_refused(&sinks);
	const int complete = status == EXIT_COMPLETE && !interrupted && totals->lost == 0;
	tool_repeats(&self);
	if (sinks_end(&sinks, &self, complete, totals->lost,
	              run.epochs > 0 && status != EXIT_IO && !interrupted) != FW_OK)
		return EXIT_IO;
	source_summary(&self, totals, sinks_rows(&sinks));
	if (interrupted)
		return tool_die_of(interrupted);
	if (status >= EXIT_USAGE)
		return status;
	if (run.epochs == 0) {
		source_offer(&self, totals);
		return EXIT_NO_DATA;
	}
	summarise();
	return complete ? EXIT_COMPLETE : EXIT_PARTIAL;
}

int main(int argc, char **argv)
{
	sink_plan to = {0};
	source_plan from = {0};
	source_totals totals = {0};

	tool_hold_standard_streams();
	switch (options_parse(&opts, argc, argv)) {
	case OPTIONS_DONE: return tool_end_answer(&self);
	case OPTIONS_WRONG: return EXIT_USAGE;
	case OPTIONS_FAILED: return EXIT_IO;
	case OPTIONS_RUN: break;
	}
	if (make_plan(&to, &from) != EXIT_COMPLETE)
		return EXIT_USAGE;
	tool_catch_signals();
	if (sinks_begin(&sinks, &to, &self, &opts, argc, argv) != FW_OK)
		return tool_interrupted() ? tool_die_of(tool_interrupted()) : EXIT_IO;
	from.sinks = &sinks;
	run.to = sinks_head(&sinks);
	return finish(source_read_all(&self, argc - opts.first_file, argv + opts.first_file, &from,
	                              (fw_sink){take, NULL}, &totals),
	              &totals);
}
