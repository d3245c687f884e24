/* insgnss-fuse: an INS corrected by GNSS. See insgnss-fuse(1). */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/frame.h"
#include "formats/sbf_decoder.h"
#include "furrow_meta.h"
#include "furrow_meta_columns.h"
#include "fuse_inputs.h"
#include "fuse_options.h"
#include "fuse_order.h"
#include "fuse_output.h"
#include "fuse_records.h"
#include "fuse_smooth.h"
#include "fuse_start.h"
#include "options.h"
#include "sinks.h"
#include "source.h"
#include "tool.h"

/* Large, and one of each: static, so that what is not used costs nothing. */
static options opts = {
    .tool = "insgnss-fuse",
    .synopsis = "[options] [FILE...]",
    .purpose = "Position, velocity and attitude from an IMU and GNSS, forwards or smoothed.",
    .table = fuse_option_table,
};
static tool self = {.name = "insgnss-fuse"};
static sink_set sinks;
static fuse_inputs inputs;
static fuse_config config;
static fuse_records records;
static fuse_order order;
static fuse_start start;
static fw_loose loose;
static fuse_smooth smooth;
static fuse_compass compass;

/* The run of the tool, which may have several runs of the filter. */
static struct {
	fuse_output out;  /* and its sink, where all other records go too */
	bool pass_on;     /* a stream: what was read goes on */
	bool calibrating; /* a first time through the log, for the compass: nothing is put out */
	fuse_rate rate;
	fuse_beginning beginning; /* of the run that is about to begin */
	fw_time last_row;
	uint64_t runs, rows, bad_rows, unseen_events;
	uint64_t wrong_times; /* records whose time cannot be */
	fw_kind_set used;     /* types that the filter takes */
} run;

/* ---- out ---- */

static void put_moment(const fw_loose *l)
{
	fuse_moment m;
	if (l->filter.pva.time.ns == run.last_row.ns)
		return; /* an event at the time of a sample */
	run.last_row = l->filter.pva.time;
	fuse_moment_of(l, &m);
	if (config.smooth)
		fuse_smooth_moment(&smooth, &m);
	else if (!fuse_output_put(&run.out, &m))
		run.bad_rows++;
	run.rows++;
}

static void on_sample(void *unused, const fw_loose *l)
{
	(void)unused;
	if (run.calibrating)
		fuse_compass_attitude(&compass, l);
	else if (fuse_rate_keeps(&run.rate, l->filter.pva.time))
		put_moment(l);
}

static void on_event(void *unused, const fw_loose *l, uint64_t number)
{
	(void)unused;
	(void)number;
	if (!run.calibrating)
		put_moment(l);
}

static void on_node(void *unused, const fw_loose *l)
{
	(void)unused;
	fuse_smooth_node(&smooth, &l->filter.model.layout, &l->node);
}

static void on_refused(void *unused, fw_time when, const char *what, fw_refusal why, double size)
{
	int week;
	double tow_s;
	char sigmas[48] = "";
	(void)unused;
	fw_time_to_gps_s(when, &week, &tow_s);
	if (size > 0)
		snprintf(sigmas, sizeof sigmas, ", %.1f sigma", size);
	tool_warn(&self, CAUSE_REFUSED, "%d:%.3f: %s refused: %s%s", week, tow_s, what, fw_refusal_text(why),
	          sigmas);
}

/* ---- runs ---- */

static void begin_anew(void)
{
	(void)!fuse_start_begin(&start, &config.start); /* it was possible once */
}

/* Where one run ended and another begins: for those who read the stream. */
static void put_gap(fw_time from, fw_time until)
{
	static char key[] = "gap";
	char value[96];
	int week[2];
	double tow_s[2];
	fw_time_to_gps_s(from, &week[0], &tow_s[0]);
	fw_time_to_gps_s(until, &week[1], &tow_s[1]);
	snprintf(value, sizeof value, "from=%d:%.3f until=%d:%.3f", week[0], tow_s[0], week[1], tow_s[1]);
	furrow_meta m = {.present = INT64_C(1) << FW_COL_meta_key | INT64_C(1) << FW_COL_meta_value,
	                 .key = key,
	                 .value = value};
	run.out.to.put(run.out.to.context, FW_meta, &m);
}

static void end_run(void)
{
	if (config.smooth && !run.calibrating)
		run.bad_rows += fuse_smooth_run(&smooth, &run.out);
}

/* Items from before the beginning of a run: only protection levels are of use. */
static void take_early(void *unused, const fuse_entry *e)
{
	(void)unused;
	if (e->item.kind == FW_ITEM_LEVELS)
		fw_loose_item(&loose, &e->item);
	run.unseen_events += e->item.kind == FW_ITEM_MARK;
}

static void feed(const fuse_entry *e)
{
	if (!e->is_imu) {
		fw_loose_item(&loose, &e->item);
	} else if (fw_loose_imu(&loose, &e->imu) == FW_EUNKNOWN) {
		end_run();
		begin_anew();
	}
}

/* What was kept for the alignment, in order of time: the run begins when it comes to its beginning. */
static void take_kept(void *unused, const fuse_entry *e)
{
	const fuse_beginning *b = &run.beginning;
	(void)unused;
	if (b->way != NULL) {
		(void)!fw_loose_start(&loose, &b->pva, b->attitude_sd, b->velocity_sd, b->position_sd,
		                      b->has_gyro_bias ? b->gyro_bias : NULL,
		                      b->has_gyro_bias ? b->gyro_bias_sd : NULL);
		run.beginning.way = NULL;
		loose.counts.refused[FW_ITEM_FIX][FW_REFUSED_GATE] += b->stray_fixes;
	}
	if (loose.running)
		feed(e);
}

/* Where the antenna is: the user's word, or the log's. */
static void learn_lever(void)
{
	if (!records.has_lever || config.lever_given)
		return;
	memcpy(loose.options.lever_b, records.lever_b, sizeof records.lever_b);
	memcpy(config.start.lever_b, records.lever_b, sizeof records.lever_b);
	memcpy(start.setup.lever_b, records.lever_b, sizeof records.lever_b);
}

static bool try_to_begin(bool last)
{
	fuse_beginning *b = &run.beginning;
	int week;
	double tow_s;
	learn_lever();
	if (fuse_start_try(&start, last, b) != FW_OK)
		return false;
	fw_time_to_gps_s(b->pva.time, &week, &tow_s);
	if (!run.calibrating)
		tool_note(
		    &self, "%d:%.3f: begins, heading %.1f +- %.1f degrees (%s)", week, tow_s,
		    fw_deg_from_rad(fw_wrap_2pi(atan2(
		        2 * (b->pva.q_n_b[0] * b->pva.q_n_b[3] + b->pva.q_n_b[1] * b->pva.q_n_b[2]),
		        1 - 2 * (b->pva.q_n_b[2] * b->pva.q_n_b[2] + b->pva.q_n_b[3] * b->pva.q_n_b[3])))),
		    fw_deg_from_rad(b->heading_sd_rad), b->way);
	if (run.runs++ > 0 && !run.calibrating)
		put_gap(run.last_row, b->pva.time);
	fuse_start_replay(&start, b->pva.time, take_early, take_kept, NULL);
	return loose.running;
}

static void take(fuse_entry *e)
{
	if (!loose.running && fuse_start_breaks(&start, e) && !try_to_begin(true)) {
		loose.counts.gaps++;
		begin_anew();
	}
	if (loose.running) {
		feed(e);
		if (loose.running)
			return;
	}
	if ((e->is_imu || fw_loose_usable(&loose, &e->item)) && fuse_start_put(&start, e))
		(void)try_to_begin(false);
}

/* ---- in ---- */

/* Hands the filter what is in order by now. */
static void take_ready(fw_time horizon)
{
	fuse_entry *e;
	while ((e = fuse_order_first(&order)) != NULL &&
	       (order.n == FUSE_ORDER || fuse_entry_time(e).ns < horizon.ns - config.window_ns)) {
		if (run.calibrating && !e->is_imu)
			fuse_compass_item(&compass, &e->item);
		take(e);
		fuse_order_drop(&order);
	}
}

static void refuse_time(void)
{
	run.wrong_times++;
	if (!run.calibrating)
		tool_warn(&self, CAUSE_REFUSED, "record refused: its time cannot be");
}

/* The end: nothing earlier comes any more. What is far ahead of everything else never had its time. */
static void take_rest(void)
{
	const fw_time last = fw_time_add_ns(fuse_inputs_latest(&inputs), FUSE_LEAP_NS);
	take_ready(fw_time_add_ns(last, config.window_ns));
	for (; order.n > 0; fuse_order_drop(&order))
		refuse_time();
	fw_loose_end(&loose);
}

static void read_all(void)
{
	fuse_record r;
	fuse_entry e;
	while (fuse_inputs_next(&inputs, &r)) {
		if (!run.calibrating && (run.pass_on || r.kind == FW_meta))
			run.out.to.put(run.out.to.context, r.kind, r.record);
		if (r.mistimed && fw_kind_in(&run.used, r.kind))
			refuse_time();
		if (!r.timed || !fuse_records_take(&records, r.kind, r.record, r.time, &e))
			continue;
		fuse_order_put(&order, &e);
		take_ready(fuse_inputs_horizon(&inputs));
	}
	if (tool_interrupted() || sinks_failed(&sinks))
		return;
	take_rest();
	if (!loose.running && start.end_reading > start.first_reading)
		(void)try_to_begin(true);
	end_run();
}

/* ---- files and options ---- */

/* Files that options name, with the type that a table in them must be. */
static const struct {
	const char *name;
	fw_kind kind;
} named[] = {{"imu", FW_imu}, {"mag", FW_mag}, {"baro", FW_baro}, {"pl", FW_pl}};
enum { NAMED = sizeof named / sizeof named[0] };

static int is_stdin(const char *path)
{
	return path != NULL && strcmp(path, "-") == 0;
}

static int is_file(const char *path)
{
	struct stat st;
	return path == NULL || (!is_stdin(path) && (stat(path, &st) != 0 || S_ISREG(st.st_mode)));
}

/* Standard input is one file; and to calibrate the compass all have to be read twice. */
static int check_files(int n, char **files)
{
	int stdins = n == 0, twice = n > 0;
	for (int i = 0; i < NAMED + n; i++) {
		const char *path = i < NAMED ? options_text(&opts, named[i].name) : files[i - NAMED];
		stdins += is_stdin(path);
		twice &= is_file(path);
	}
	if (stdins > 1) {
		tool_error(&self, "standard input can be one file only");
		return EXIT_USAGE;
	}
	if (!twice && config.compass_way >= FUSE_COMPASS_TURNING) {
		tool_error(&self, "--compass-calibration %s reads files twice: a pipe cannot be",
		           options_text(&opts, "compass-calibration"));
		return EXIT_USAGE;
	}
	return EXIT_COMPLETE;
}

/* Of a file that --imu names only sensors are taken. */
static void narrow(source_plan *p, fw_kind kind)
{
	p->progress = "never"; /* one line is enough */
	p->table = kind;
	p->wanted = (fw_kind_set){0};
	fw_kind_add(&p->wanted, kind);
	if (kind != FW_imu)
		return;
	fw_kind_add(&p->wanted, FW_imu_setup);
	fw_kind_add(&p->wanted, FW_mag);
	fw_kind_add(&p->wanted, FW_baro);
}

/* Opens the files: operands may hold anything. Returns EXIT_COMPLETE or an error. */
static int open_all(int n, char **files, const source_plan *plan)
{
	source_plan p = *plan;
	int status = n == 0 ? fuse_inputs_add(&inputs, "-", &p) : EXIT_COMPLETE;
	for (int i = 0; i < n && status == EXIT_COMPLETE; i++) {
		status = fuse_inputs_add(&inputs, files[i], &p);
		p.progress = "never";
	}
	for (int i = 0; i < NAMED && status == EXIT_COMPLETE; i++) {
		const char *path = options_text(&opts, named[i].name);
		narrow(&p, named[i].kind);
		if (path != NULL)
			status = fuse_inputs_add(&inputs, path, &p);
	}
	return status;
}

/* What the options ask for, as the sinks and the sources want it. Returns EXIT_COMPLETE or EXIT_USAGE. */
static int make_plan(sink_plan *sink, source_plan *source)
{
	const int stream = options_flag(&opts, "stream"),
	          lcm = strcmp(options_text(&opts, "format"), "lcm") == 0;
	self.quiet = options_flag(&opts, "quiet");
	self.verbose = options_flag(&opts, "verbose");
	if (fuse_configure(&opts, &self, &config) != EXIT_COMPLETE)
		return EXIT_USAGE;
	sink->mode = lcm ? SINK_LCM : stream ? SINK_STREAM : SINK_TABLE;
	sink->table = FW_nav;
	sink->path = options_text(&opts, "output");
	sink->from = options_time(&opts, "from");
	sink->until = options_time(&opts, "until");
	run.pass_on = stream;
	run.rate = config.rate;
	run.last_row = (fw_time){INT64_MIN};
	fuse_records_kinds(&run.used);
	source->wanted = run.used;
	for (fw_kind kind = 0; run.pass_on && kind < FW_RECORD_COUNT; kind++)
		fw_kind_add(&source->wanted, kind);
	source->table = FW_RECORD_COUNT;
	source->antennas = run.pass_on ? FW_ANTENNA_ALL : FW_ANTENNA_MAIN;
	source->nav_sources = FW_NAV_RAW | FW_NAV_DECODED;
	source->progress = options_text(&opts, "progress");
	source->logs = &config.logs;
	source->sinks = &sinks;
	return EXIT_COMPLETE;
}

/* ---- the end ---- */

/* Adds "3 back in time, 1 not finite" to a line. Returns the sum. */
static uint64_t list_refused(const uint64_t counts[static FW_REFUSED_COUNT], const char *what, char *line,
                             size_t room)
{
	uint64_t sum = 0;
	for (int why = 0; why < FW_REFUSED_COUNT; why++) {
		const size_t used = strlen(line);
		if (counts[why] > 0)
			snprintf(line + used, room - used, "%s%" PRIu64 " %s %s", used > 0 ? ", " : "",
			         counts[why], what, fw_refusal_text((fw_refusal)why));
		sum += counts[why];
	}
	return sum;
}

/* Fixes whose errors stay a while agree with each other better than with the truth: the filter follows them, and its sigmas know
 * nothing of it. Their innovations tell. */
static void judge_innovations(const fw_loose_counts *c)
{
	const double nis = c->position_nis_rows > 0 ? c->position_nis_sum / (double)c->position_nis_rows : 1;
	const char *hint = "";
	if (c->position_nis_rows == 0)
		return;
	if (nis < 0.5 && config.loose.adapt.mode != FW_ADAPT_GM)
		hint = "; their errors seem to stay a while, which the sigmas here do not know: --adapt gm";
	else if (nis > 2)
		hint = "; fixes or IMU are worse than they are said to be";
	tool_note(&self,
	          "innovations of positions, squared over their variance: %.2f on average (1 expected)%s",
	          nis, hint);
}

/* What was refused, and what else the user should know. Returns how much was refused. */
static uint64_t summarise(void)
{
	static const char *const what[] = {"fixes", "headings", "fields", "heights", "levels", "events"};
	const fw_loose_counts *c = &loose.counts;
	uint64_t samples[FW_REFUSED_COUNT], refused = 0;
	char line[900] = "";
	for (int why = 0; why < FW_REFUSED_COUNT; why++)
		samples[why] = c->samples_refused[why] + start.refused[why];
	refused += list_refused(samples, "IMU samples", line, sizeof line);
	for (int kind = 0; kind <= FW_ITEM_MARK; kind++)
		refused += list_refused(c->refused[kind], what[kind], line, sizeof line);
	tool_note(&self,
	          "%" PRIu64 " IMU samples, %" PRIu64 " fixes, %" PRIu64 " headings used; %" PRIu64
	          " gaps bridged; %" PRIu64 " rows",
	          c->samples, c->used[FW_ITEM_FIX], c->used[FW_ITEM_HEADING], c->bridged, run.rows);
	judge_innovations(c);
	if (refused > 0)
		tool_note(&self, "refused: %s", line);
	if (c->gaps > 0)
		tool_note(&self, "%" PRIu64 " gaps of the IMU, each followed by a new beginning", c->gaps);
	if (c->strayed > 0)
		tool_note(&self, "%" PRIu64 " runs ended because all fixes were somewhere else", c->strayed);
	if (run.wrong_times > 0)
		tool_note(&self, "%" PRIu64 " records with a time that cannot be", run.wrong_times);
	if (start.lost > 0)
		tool_note(&self, "%" PRIu64 " records came too long before the first attitude was found",
		          start.lost);
	if (records.other_fixes > 0)
		tool_note(&self, "%" PRIu64 " positions of other records not used, %s first (--fixes)",
		          records.other_fixes, fw_record_type_of(records.other_kind)->name);
	if (records.without_sigma > 0)
		tool_note(&self, "%" PRIu64 " fixes without standard deviations: some metres assumed",
		          records.without_sigma);
	if (records.withheld > 0)
		tool_note(&self, "%" PRIu64 " fixes and headings withheld", records.withheld);
	if (config.smooth)
		tool_note(&self, "smoothing took %.0f MiB, %.0f MiB of them in a file",
		          (double)smooth.budget.most / 1048576,
		          fmax(0, (double)smooth.budget.most - (double)config.memory) / 1048576);
	return refused + c->gaps + c->strayed + run.wrong_times + run.bad_rows;
}

static int finish(const source_totals *totals, int status)
{
	const int interrupted = tool_interrupted(), store_error = config.smooth ? smooth.budget.error : 0;
	if (store_error != 0)
		tool_error(&self, "smoothing: %s", strerror(store_error));
	if (store_error != 0 && status < EXIT_USAGE)
		status = EXIT_IO;
	sinks_stop(&sinks);
	tool_repeats(&self);
	const uint64_t refused = status < EXIT_USAGE ? summarise() : 0;
	const int complete = status == EXIT_COMPLETE && !interrupted && totals->lost == 0 && refused == 0;
	if (config.smooth)
		fuse_smooth_end(&smooth);
	if (sinks_end(&sinks, &self, complete, totals->lost + refused,
	              run.rows > 0 && status < EXIT_USAGE && !interrupted) != FW_OK)
		return EXIT_IO;
	if (interrupted)
		return tool_die_of(interrupted);
	if (status >= EXIT_USAGE)
		return status;
	if (run.rows == 0) {
		tool_error(&self, "no solution: %s", fuse_start_lacks(&start));
		return EXIT_NO_DATA;
	}
	return complete ? EXIT_COMPLETE : EXIT_PARTIAL;
}

/* Gets filter and alignment ready. Returns EXIT_COMPLETE or, after a message, EXIT_USAGE. */
static int get_ready(const fw_loose_options *o, const fuse_start_setup *s, const fw_loose_hooks *hooks)
{
	memset(start.refused, 0, sizeof start.refused);
	start.lost = 0;
	order.n = order.n_free = order.slots = 0;
	fuse_records_begin(&records, &config.records);
	if (fw_loose_init(&loose, o, hooks) == FW_OK && fuse_start_begin(&start, s) == FW_OK)
		return EXIT_COMPLETE;
	tool_error(&self, "these options do not go together");
	return EXIT_USAGE;
}

static int begin(void)
{
	const fw_loose_hooks hooks = {.sample = on_sample,
	                              .mark = on_event,
	                              .node = config.smooth ? on_node : NULL,
	                              .refused = on_refused};
	if (config.smooth)
		fuse_smooth_begin(&smooth, config.memory);
	return get_ready(&config.loose, &config.start, &hooks);
}

/* A first time through the log, without the magnetometer, to learn what iron does to it. Returns an exit status. */
static int calibrate(int n, char **files, const source_plan *plan)
{
	const fw_loose_hooks hooks = {.sample = on_sample};
	fw_loose_options o = config.loose;
	tool silent = {.name = self.name, .quiet = 1};
	source_totals unused = {0};
	source_plan p = *plan;
	char text[200];
	o.use_field = o.use_table = false;
	p.sinks = NULL;
	p.progress = "never";
	if (get_ready(&o, &config.start, &hooks) != EXIT_COMPLETE)
		return EXIT_USAGE;
	run.calibrating = true;
	fuse_compass_begin(&compass, config.loose.declination_rad);
	fuse_inputs_begin(&inputs, &silent, NULL);
	int status = open_all(n, files, &p);
	if (status == EXIT_COMPLETE)
		read_all();
	const int read = fuse_inputs_end(&inputs, &unused);
	run.calibrating = false;
	run.runs = 0;
	run.unseen_events = run.wrong_times = 0;
	if (status >= EXIT_USAGE || read >= EXIT_USAGE)
		return read > status ? read : status;
	const fw_status found = fuse_compass_solve(&compass, config.compass_way, &config.compass);
	if (found < 0 || found == FW_MORE) {
		tool_note(&self, "compass not calibrated: %s",
		          found == FW_MORE ? "too few readings with an attitude"
		                           : "the motion shows too little");
		return EXIT_COMPLETE;
	}
	config.records.compass = &config.compass;
	fuse_compass_print(&config.compass, text, sizeof text);
	tool_note(&self, "compass calibrated to %.1f degrees%s: %s",
	          fw_deg_from_rad(config.compass.heading_sd_rad), config.compass.flat ? ", near level" : "",
	          text);
	return EXIT_COMPLETE;
}

int main(int argc, char **argv)
{
	sink_plan to = {0};
	source_plan from = {0};
	source_totals totals = {0};

	opts.n = fuse_option_count;
	tool_hold_standard_streams();
	switch (options_parse(&opts, argc, argv)) {
	case OPTIONS_DONE: return tool_end_answer(&self);
	case OPTIONS_WRONG: return EXIT_USAGE;
	case OPTIONS_FAILED: return EXIT_IO;
	case OPTIONS_RUN: break;
	}
	const int n = argc - opts.first_file;
	char **files = argv + opts.first_file;
	if (make_plan(&to, &from) != EXIT_COMPLETE || check_files(n, files) != EXIT_COMPLETE)
		return EXIT_USAGE;
	tool_catch_signals();
	int status = config.compass_way >= FUSE_COMPASS_TURNING ? calibrate(n, files, &from) : EXIT_COMPLETE;
	if (tool_interrupted())
		return tool_die_of(tool_interrupted());
	if (status != EXIT_COMPLETE || (status = begin()) != EXIT_COMPLETE)
		return status;
	if (sinks_begin(&sinks, &to, &self, &opts, argc, argv) != FW_OK)
		return tool_interrupted() ? tool_die_of(tool_interrupted()) : EXIT_IO;
	run.out = (fuse_output){sinks_head(&sinks), config.misalignment_rad};
	fuse_inputs_begin(&inputs, &self, &sinks);
	status = open_all(n, files, &from);
	if (status == EXIT_COMPLETE)
		read_all();
	const int read = fuse_inputs_end(&inputs, &totals);
	return finish(&totals, read > status ? read : status);
}
