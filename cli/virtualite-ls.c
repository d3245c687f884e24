/* virtualite-ls: single-point positions by least squares. See virtualite-ls(1). */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "ephemerides.h"
#include "epochs.h"
#include "formats/input.h"
#include "formats/rinex.h"
#include "formats/sbf_decoder.h"
#include "furrow_dop.h"
#include "furrow_dop_columns.h"
#include "furrow_nav.h"
#include "furrow_nav_columns.h"
#include "furrow_pos.h"
#include "furrow_pos_columns.h"
#include "furrow_residual.h"
#include "furrow_residual_columns.h"
#include "gnss/single_point.h"
#include "options.h"
#include "relay.h"
#include "sinks.h"
#include "source.h"
#include "tool.h"

static const option table[] = {
    {"output", 'o', OPTION_TEXT, "FILE", NULL, "write to FILE instead of standard output", 0, 0},
    {"types", 't', OPTION_TEXT, "TYPE[,TYPE]", "pos", "what to compute: pos, nav, dop, residual", 0, 0},
    {"stream", 's', OPTION_FLAG, NULL, NULL, "write a stream: what was read, and the solutions", 0, 0},
    {"format", 'f', OPTION_CHOICE, "csv|lcm", "csv", "text, or an LCM event log", 0, 0},
    {"from", 0, OPTION_TIME, "TIME", NULL, "leave out what is before TIME", 0, 0},
    {"until", 0, OPTION_TIME, "TIME", NULL, "leave out what is at TIME and after", 0, 0},
    {"every", 0, OPTION_NUMBER, "SECONDS", NULL, "keep epochs at multiples of SECONDS", 0.001, 604800},
    {"systems", 0, OPTION_TEXT, "LETTERS", "GECRJ", "satellite systems: G E C R J I S as in RINEX", 0, 0},
    {"signals", 0, OPTION_TEXT, "LIST", NULL, "signals by preference, as G1C,G5Q,E1X; others: built in", 0,
     0},
    {"elevation-mask", 0, OPTION_NUMBER, "DEGREES", "10", "leave out satellites below", -90, 90},
    {"cn0-mask", 0, OPTION_NUMBER, "DBHZ", "0", "leave out satellites that are weaker", 0, 60},
    {"ionosphere", 0, OPTION_CHOICE, "off|broadcast|free|weighted", "weighted", "how to treat the ionosphere",
     0, 0},
    {"troposphere", 0, OPTION_CHOICE, "off|saastamoinen|mops", "saastamoinen", "model of the troposphere", 0,
     0},
    {"gate", 0, OPTION_NUMBER, "SIGMAS", "4", "exclude satellites with a larger residual; 0: none", 0, 100},
    {"max-gdop", 0, OPTION_NUMBER, "GDOP", "30", "no solution where the geometry is worse", 1, 1e6},
    {"quiet", 'q', OPTION_FLAG, NULL, NULL, "only messages about errors that end the run", 0, 0},
    {"verbose", 'v', OPTION_FLAG, NULL, NULL, "every message, however often it repeats", 0, 0},
    {"progress", 0, OPTION_CHOICE, "auto|always|never", "auto", "show how much has been read", 0, 0},
};

/* Large, and one of each: static, so that what is not used costs nothing. */
static options opts = {
    .tool = "virtualite-ls",
    .synopsis = "[options] [FILE...]",
    .purpose = "Single-point positions by least squares, from SBF, RINEX or a furrow stream.",
    .table = table,
    .n = sizeof table / sizeof table[0],
};
static tool self = {.name = "virtualite-ls"};
static sink_set sinks;
static relay solver; /* from reading to solving */
static ephemeris_store store;
static epochs rows;
static fw_signal_choice signals;

/* The run: how to solve, where to put what comes of it, and the count. */
static struct {
	fw_single_point_options options;
	fw_single_point_memory memory;
	fw_kind_set wanted; /* the types computed */
	bool pass_on;       /* a stream: what was read goes on */
	const fw_time *from, *until;
	int64_t every_ns;
	fw_sink onward; /* to the solver */
	fw_sink to;     /* from there */
	uint64_t epochs, failed[FW_SP_NO_CONVERGENCE + 1];
} run;

/* ---- solutions to records ---- */

#define BIT(column) (INT64_C(1) << (column))

/* All columns from a to b. */
static int64_t bits(int a, int b)
{
	return (BIT(b) - BIT(a)) | BIT(b);
}

static void put(fw_kind kind, const void *record)
{
	run.to.put(run.to.context, kind, record);
}

/* The position at the time tag itself: the receiver was there `clock` before its clock said so. */
static void position_at_tag(const fw_solution *s, fw_time tag, double llh[3])
{
	const double dt_s = fw_time_diff_s(tag, s->time);
	memcpy(llh, s->llh, sizeof s->llh);
	if (!s->has_velocity || dt_s == 0)
		return;
	double C_e_n[3][3], v[3], ecef[3];
	fw_frame_ned(s->llh[0], s->llh[1], C_e_n);
	fw_mat3_vec(C_e_n, s->velocity_mps, v);
	for (int i = 0; i < 3; i++)
		ecef[i] = s->position_m[i] + v[i] * dt_s;
	(void)!fw_ecef_to_llh(ecef, llh);
}

static double deviation(const double C[3][3], int i)
{
	return sqrt(fmax(C[i][i], 0));
}

static double clock_m(const fw_solution *s)
{
	for (unsigned k = 0; k < FW_SYSTEM_COUNT; k++)
		if ((s->systems >> k & 1) != 0)
			return s->clock_m[k];
	return 0;
}

static void put_pos(const fw_solution *s, int week, double tow_s, const double llh[3])
{
	static char single[] = "single";
	furrow_pos r = {
	    .present = bits(FW_COL_pos_gps_week, FW_COL_pos_n_virtual) | BIT(FW_COL_pos_clock_m),
	    .gps_week = week,
	    .tow_s = tow_s,
	    .lat_deg = fw_deg_from_rad(llh[0]),
	    .lon_deg = fw_deg_from_rad(llh[1]),
	    .height_m = llh[2],
	    .sd_n_m = deviation(s->covariance_m2, 0),
	    .sd_e_m = deviation(s->covariance_m2, 1),
	    .sd_d_m = deviation(s->covariance_m2, 2),
	    .quality = single,
	    .n_sats = (int16_t)s->n_used,
	    .clock_m = clock_m(s),
	};
	put(FW_pos, &r);
}

static void put_nav(const fw_solution *s, int week, double tow_s, const double llh[3])
{
	static char single[] = "single";
	furrow_nav r = {
	    .present = bits(FW_COL_nav_gps_week, FW_COL_nav_height_m) |
	               bits(FW_COL_nav_sd_n_m, FW_COL_nav_sd_d_m) | BIT(FW_COL_nav_status),
	    .gps_week = week,
	    .tow_s = tow_s,
	    .lat_deg = fw_deg_from_rad(llh[0]),
	    .lon_deg = fw_deg_from_rad(llh[1]),
	    .height_m = llh[2],
	    .sd_n_m = deviation(s->covariance_m2, 0),
	    .sd_e_m = deviation(s->covariance_m2, 1),
	    .sd_d_m = deviation(s->covariance_m2, 2),
	    .status = single,
	};
	if (s->has_velocity) {
		r.present |= bits(FW_COL_nav_vn_mps, FW_COL_nav_vd_mps) |
		             bits(FW_COL_nav_sd_vn_mps, FW_COL_nav_sd_vd_mps);
		r.vn_mps = s->velocity_mps[0];
		r.ve_mps = s->velocity_mps[1];
		r.vd_mps = s->velocity_mps[2];
		r.sd_vn_mps = deviation(s->velocity_covariance, 0);
		r.sd_ve_mps = deviation(s->velocity_covariance, 1);
		r.sd_vd_mps = deviation(s->velocity_covariance, 2);
	}
	put(FW_nav, &r);
}

static void put_dop(const fw_solution *s, int week, double tow_s)
{
	furrow_dop r = {
	    .present = bits(FW_COL_dop_gps_week, FW_COL_dop_vdop),
	    .gps_week = week,
	    .tow_s = tow_s,
	    .n_sats = (int16_t)s->n_used,
	    .pdop = s->pdop,
	    .tdop = s->tdop,
	    .hdop = s->hdop,
	    .vdop = s->vdop,
	};
	put(FW_dop, &r);
}

static void put_residuals(const fw_solution *s, int week, double tow_s)
{
	static char code[] = "code";
	char name[5];
	for (unsigned i = 0; i < s->n; i++) {
		const fw_satellite_use *u = &s->satellite[i];
		if (u->use != FW_USED && u->use != FW_OUTLIER)
			continue;
		fw_satellite_name(u->satellite, name);
		furrow_residual r = {
		    .present = bits(FW_COL_residual_gps_week, FW_COL_residual_sat) |
		               BIT(FW_COL_residual_quantity) | BIT(FW_COL_residual_residual) |
		               BIT(FW_COL_residual_weight),
		    .gps_week = week,
		    .tow_s = tow_s,
		    .sat = name,
		    .quantity = code,
		    .residual = (float)u->residual_m,
		    .weight = u->use == FW_USED ? 1 / (u->sigma_m * u->sigma_m) : 0,
		};
		put(FW_residual, &r);
	}
}

static bool is_kept(fw_time t)
{
	if ((run.from != NULL && t.ns < run.from->ns) || (run.until != NULL && t.ns >= run.until->ns))
		return false;
	return run.every_ns == 0 || t.ns % FW_NS_PER_WEEK % run.every_ns == 0;
}

static void solve(const fw_epoch *epoch)
{
	static fw_solution s;
	const fw_ephemeris_source source = {ephemeris_store_find, &store, ephemeris_store_state};
	int week;
	double tow_s, llh[3];
	if (!is_kept(epoch->time))
		return;
	fw_single_point_status status =
	    fw_single_point(epoch, &source, &store.iono, &run.options, &run.memory, &s);
	run.epochs++;
	fw_time_to_gps_s(epoch->time, &week, &tow_s);
	if (status != FW_SP_OK) {
		if (run.failed[status]++ == 0 || self.verbose)
			tool_note(&self, "%d:%.3f: no solution: %s", week, tow_s,
			          fw_single_point_text(status));
		return;
	}
	position_at_tag(&s, epoch->time, llh);
	if (fw_kind_in(&run.wanted, FW_pos))
		put_pos(&s, week, tow_s, llh);
	if (fw_kind_in(&run.wanted, FW_nav))
		put_nav(&s, week, tow_s, llh);
	if (fw_kind_in(&run.wanted, FW_dop))
		put_dop(&s, week, tow_s);
	if (fw_kind_in(&run.wanted, FW_residual))
		put_residuals(&s, week, tow_s);
}

/* ---- reading ---- */

/* One core reads and gathers observations to epochs, another one solves them. From the one to the other, in this order,
 * go epochs, and the records that somebody needs besides. */

/* At the solver's end. */
static void take(void *unused, fw_kind kind, const void *record)
{
	(void)unused;
	if (kind == FW_RECORD_COUNT) {
		solve(record);
		return;
	}
	ephemeris_store_put(&store, kind, record);
	if (run.pass_on || kind == FW_meta)
		put(kind, record);
}

static void send_epoch(void *unused, const fw_epoch *epoch)
{
	(void)unused;
	if (solver.running)
		relay_bytes(&solver, epoch, offsetof(fw_epoch, obs) + epoch->n * sizeof epoch->obs[0]);
	else
		solve(epoch);
}

/* A record that was read. The epoch that it ends goes before it, so that the output is in time order. */
static void read_record(void *unused, fw_kind kind, const void *record)
{
	(void)unused;
	epochs_put(&rows, kind, record);
	if (run.pass_on || kind != FW_obs)
		run.onward.put(run.onward.context, kind, record);
}

/* What a file is, from its first bytes. Nothing is known of what cannot be read twice. */
static fw_rinex_kind kind_of_file(const char *path, bool *twice)
{
	static fw_input input;
	struct stat st;
	const uint8_t *head;
	size_t n;
	fw_rinex_kind kind = FW_RINEX_NONE;
	*twice = strcmp(path, "-") != 0 && stat(path, &st) == 0 && S_ISREG(st.st_mode);
	if (!*twice)
		return kind;
	if (fw_input_open(&input, path) == FW_OK && fw_input_peek(&input, 300, &head, &n) == FW_OK)
		kind = fw_rinex_detect(head, n);
	fw_input_close(&input);
	return kind;
}

/* Before anything is solved, all ephemerides of files that can be read twice are collected: navigation files may stand
 * anywhere, and the first epochs of a log have those that came after them. Navigation files are done with after this. */
static int read_ephemerides(int n, char **files, const source_plan *plan, source_totals *totals)
{
	int worst = EXIT_COMPLETE;
	for (int i = 0; i < n && !tool_interrupted(); i++) {
		bool twice;
		const fw_rinex_kind kind = kind_of_file(files[i], &twice);
		source_totals unused = {0};
		tool silent = {.name = self.name, .quiet = 1};
		source_plan first = *plan;
		int status;
		if (!twice || kind == FW_RINEX_OBSERVATION)
			continue;
		if (kind == FW_RINEX_NAVIGATION) {
			status = source_read(&self, files[i], plan, (fw_sink){take, NULL}, totals);
		} else {
			first.wanted = (fw_kind_set){0};
			ephemeris_kinds(&first.wanted);
			first.progress = "never";
			status = source_read(&silent, files[i], &first,
			                     (fw_sink){ephemeris_store_put, &store}, &unused);
			if (status != EXIT_IO)
				status =
				    EXIT_COMPLETE; /* what is wrong with it is said when it is read for good */
		}
		worst = status > worst ? status : worst;
	}
	return worst;
}

static int read_observations(int n, char **files, const source_plan *plan, source_totals *totals)
{
	int worst = EXIT_COMPLETE;
	for (int i = 0; i < n && !tool_interrupted() && !sinks_failed(&sinks); i++) {
		bool twice;
		if (kind_of_file(files[i], &twice) == FW_RINEX_NAVIGATION)
			continue;
		/* A live receiver's epochs shall not wait for a batch to fill. */
		run.onward = (fw_sink){take, NULL};
		if (twice)
			run.onward = relay_start(&solver, run.onward);
		int status = source_read(&self, files[i], plan, (fw_sink){read_record, NULL}, totals);
		relay_stop(&solver);
		worst = status > worst ? status : worst;
	}
	epochs_flush(&rows);
	return worst;
}

static int read_all(int n, char **files, const source_plan *plan, source_totals *totals)
{
	static char dash[] = "-", *standard_input[] = {dash};
	if (n == 0) {
		n = 1;
		files = standard_input;
	}
	int status = read_ephemerides(n, files, plan, totals);
	if (status == EXIT_IO)
		return status;
	int second = read_observations(n, files, plan, totals);
	return second > status ? second : status;
}

/* ---- options ---- */

static int parse_systems(const char *letters, unsigned *systems)
{
	*systems = 0;
	for (const char *p = letters; *p != '\0'; p++) {
		const fw_system system = fw_system_of_letter(*p);
		if (system == FW_SYSTEM_COUNT) {
			tool_error(&self, "--systems: '%c' is no satellite system; G E C R J I S are", *p);
			return 0;
		}
		*systems |= 1U << system;
	}
	if (*systems == 0)
		tool_error(&self, "--systems: none given");
	return *systems != 0;
}

/* "G1C,G5Q,E1": the systems that are named get these lists, the others keep theirs. */
static int parse_signals(const char *text, fw_signal_choice *choice)
{
	unsigned n[FW_SYSTEM_COUNT] = {0};
	*choice = fw_signals_default;
	for (const char *p = text; *p != '\0';) {
		const size_t length = strcspn(p, ",");
		const fw_system system = fw_system_of_letter(p[0]);
		if (length < 2 || length > 3 || system == FW_SYSTEM_COUNT || n[system] == FW_SIGNAL_CHOICES) {
			tool_error(
			    &self,
			    "--signals: '%.*s' is no signal; G1C, E5Q or, for any code on a band, C2 are",
			    (int)length, p);
			return 0;
		}
		if (n[system] == 0)
			memset(choice->of[system], 0, sizeof choice->of[system]);
		choice->of[system][n[system]++] = (fw_signal){p[1], length == 3 ? p[2] : '\0'};
		p += length + (p[length] == ',');
	}
	return 1;
}

/* The place of a word among the words of an option. */
static int choice_index(const char *name)
{
	const char *words = table[options_index(&opts, name)].argument, *word = options_text(&opts, name);
	int index = 0;
	for (const char *p = words;
	     strncmp(p, word, strlen(word)) != 0 || strchr("|", p[strlen(word)]) == NULL; index++)
		p = strchr(p, '|') + 1;
	return index;
}

/* How to solve. Returns 0 after a message. */
static int make_solver(void)
{
	fw_single_point_options *o = &run.options;
	const char *list = options_text(&opts, "signals");
	*o = fw_single_point_defaults;
	if (!parse_systems(options_text(&opts, "systems"), &o->systems))
		return 0;
	if (list != NULL && !parse_signals(list, &signals))
		return 0;
	o->signals = list != NULL ? &signals : NULL;
	o->elevation_mask_rad = fw_rad_from_deg(options_number(&opts, "elevation-mask"));
	o->cn0_mask_dbhz = options_number(&opts, "cn0-mask");
	o->iono = (fw_iono_mode)choice_index("ionosphere");
	o->tropo = (fw_tropo_mode)choice_index("troposphere");
	o->gate = options_number(&opts, "gate");
	o->max_gdop = options_number(&opts, "max-gdop");
	return 1;
}

/* What the options ask for, as the sinks and the source want it. Returns EXIT_COMPLETE or EXIT_USAGE. */
static int make_plan(sink_plan *sink, source_plan *source)
{
	const int stream = options_flag(&opts, "stream"),
	          lcm = strcmp(options_text(&opts, "format"), "lcm") == 0;
	static const fw_kind computed[] = {FW_pos, FW_nav, FW_dop, FW_residual};
	const int n = sinks_parse_types(&self, options_text(&opts, "types"), computed,
	                                sizeof computed / sizeof computed[0], &run.wanted, &sink->table);
	self.quiet = options_flag(&opts, "quiet");
	self.verbose = options_flag(&opts, "verbose");
	if (n == 0 || !make_solver())
		return EXIT_USAGE;
	sink->mode = lcm ? SINK_LCM : stream ? SINK_STREAM : SINK_TABLE;
	if (sink->mode == SINK_TABLE && n > 1) {
		tool_error(&self, "a table holds one type; add -s for a stream");
		return EXIT_USAGE;
	}
	run.pass_on = stream;
	sink->path = options_text(&opts, "output");
	run.from = sink->from = options_time(&opts, "from");
	run.until = sink->until = options_time(&opts, "until");
	run.every_ns =
	    options_text(&opts, "every") != NULL ? llround(options_number(&opts, "every") * 1e9) : 0;
	sink->every_ns = run.every_ns;
	ephemeris_kinds(&source->wanted);
	fw_kind_add(&source->wanted, FW_obs);
	for (fw_kind kind = 0; run.pass_on && kind < FW_RECORD_COUNT; kind++)
		fw_kind_add(&source->wanted, kind);
	source->table = FW_RECORD_COUNT;
	source->no_carriers = !run.pass_on;
	source->antennas = run.pass_on ? FW_ANTENNA_ALL : FW_ANTENNA_MAIN;
	source->nav_sources = FW_NAV_RAW | FW_NAV_DECODED;
	source->progress = options_text(&opts, "progress");
	return EXIT_COMPLETE;
}

/* ---- the end ---- */

/* Epochs, and why some of them have no solution. */
static void summarise(void)
{
	char why[256] = "";
	uint64_t failed = 0;
	for (int k = 1; k <= FW_SP_NO_CONVERGENCE; k++) {
		const size_t used = strlen(why);
		if (run.failed[k] > 0)
			snprintf(why + used, sizeof why - used, "%s%" PRIu64 " %s", used > 0 ? ", " : ": ",
			         run.failed[k], fw_single_point_text((fw_single_point_status)k));
		failed += run.failed[k];
	}
	tool_note(&self, "%" PRIu64 " epochs, %" PRIu64 " ephemerides, %" PRIu64 " epochs without solution%s",
	          run.epochs, store.taken, failed, why);
}

static int finish(int status, const source_totals *totals)
{
	const int interrupted = tool_interrupted();
	const int complete = status == EXIT_COMPLETE && !interrupted && totals->lost == 0 && !store.no_memory;
	const uint64_t solved = run.epochs - run.failed[1] - run.failed[2] - run.failed[3] - run.failed[4];
	sinks_stop(&sinks);
	tool_repeats(&self);
	if (sinks_end(&sinks, &self, complete, totals->lost,
	              solved > 0 && status != EXIT_IO && !interrupted) != FW_OK)
		return EXIT_IO;
	summarise();
	ephemeris_store_free(&store);
	if (interrupted)
		return tool_die_of(interrupted);
	if (status >= EXIT_USAGE)
		return status;
	if (solved == 0)
		return EXIT_NO_DATA;
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
	epochs_begin(&rows, send_epoch, NULL);
	return finish(read_all(argc - opts.first_file, argv + opts.first_file, &from, &totals), &totals);
}
