/* nav-eval: solutions against a reference trajectory. See nav-eval(1). */
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eval_html.h"
#include "eval_report.h"
#include "eval_series.h"
#include "eval_stats.h"
#include "formats/number.h"
#include "formats/sbf_decoder.h"
#include "options.h"
#include "output.h"
#include "sinks.h"
#include "tool.h"

static const option table[] = {
    {"truth", 0, OPTION_TEXT, "FILE", NULL, "the reference trajectory", 0, 0},
    {"output", 'o', OPTION_TEXT, "FILE", NULL, "write to FILE instead of standard output", 0, 0},
    {"format", 'f', OPTION_CHOICE, "text|csv", "text", "tables to read, or one for programs", 0, 0},
    {"html", 0, OPTION_TEXT, "FILE", NULL, "write a page with pictures as well (needs gnuplot)", 0, 0},
    {"sky", 0, OPTION_TEXT, "FILE[,FILE]", NULL, "observations and ephemerides for the page's sky", 0, 0},
    {"types", 't', OPTION_TEXT, "TYPE", NULL, "record type that is the solution", 0, 0},
    {"sections", 0, OPTION_TEXT, "SECONDS|TIME,...", NULL, "figures for stretches of time as well", 0, 0},
    {"from", 0, OPTION_TIME, "TIME", NULL, "leave out what is before TIME", 0, 0},
    {"until", 0, OPTION_TIME, "TIME", NULL, "leave out what is at TIME and after", 0, 0},
    {"interval", 0, OPTION_NUMBER, "SECONDS", NULL, "time between the epochs expected", 0.001, 604800},
    {"max-gap", 0, OPTION_NUMBER, "SECONDS", NULL, "longest step of the truth to interpolate", 0.001, 604800},
    {"lever-arm", 0, OPTION_TEXT, "X,Y,Z", NULL, "the solutions' point, seen from the truth's [m]", 0, 0},
    {"levels", 0, OPTION_TEXT, "FILE", NULL, "protection levels (pl) from FILE", 0, 0},
    {"hal", 0, OPTION_NUMBER, "METRES", NULL, "horizontal alert limit where none is given", 0, 1e6},
    {"val", 0, OPTION_NUMBER, "METRES", NULL, "vertical alert limit where none is given", 0, 1e6},
    {"max-rows", 0, OPTION_NUMBER, "N", "2000000", "rows of a file to keep in memory", 1, 1e9},
    {"quiet", 'q', OPTION_FLAG, NULL, NULL, "only messages about errors that end the run", 0, 0},
    {"verbose", 'v', OPTION_FLAG, NULL, NULL, "every message, however often it repeats", 0, 0},
    {"progress", 0, OPTION_CHOICE, "auto|always|never", "auto", "show how much has been read", 0, 0},
};

static options opts = {
    .tool = "nav-eval",
    .synopsis = "[options] --truth FILE [SOLUTION...]",
    .purpose = "Positions, velocities and attitudes against a reference: errors, consistency, integrity.",
    .table = table,
    .n = sizeof table / sizeof table[0],
};
static tool self = {.name = "nav-eval"};

enum { MAX_SOLUTIONS = 32, MAX_SECTIONS = 2000 };

/* Everything that is in memory; run() fills it, release() gives it back. */
static struct {
	source_totals totals;
	eval_series truth_series, levels, solutions[MAX_SOLUTIONS];
	eval_result results[MAX_SOLUTIONS];
	int n;
	eval_truth truth;
	eval_section sections[MAX_SECTIONS];
	eval_question question;
	eval_sky sky;
} all;

static int usage(const char *message)
{
	tool_error(&self, "%s", message);
	return EXIT_USAGE;
}

/* ---- options ---- */

static int64_t nanoseconds(const char *name)
{
	return options_text(&opts, name) != NULL ? llround(options_number(&opts, name) * 1e9) : 0;
}

/* "X,Y,Z": three numbers below 1 km. Returns 0 if it is not that. */
static int parse_lever_arm(const char *text, double arm[static 3])
{
	const char *p = text;
	for (int i = 0; i < 3; i++) {
		size_t n = strcspn(p, ",");
		if (fw_get_double(p, n, &arm[i]) != FW_OK || !(fabs(arm[i]) < 1000))
			return 0;
		p += n;
		if (*p != (i < 2 ? ',' : '\0'))
			return 0;
		p += i < 2;
	}
	return 1;
}

/* The kind that -t names: one that can be a trajectory. Returns 0 after a message. */
static int parse_kind(const char *text, fw_kind *kind)
{
	*kind = FW_RECORD_COUNT;
	if (text == NULL)
		return 1;
	*kind = fw_record_find(text, strlen(text));
	for (int k = 0; eval_kinds[k] != FW_RECORD_COUNT; k++)
		if (eval_kinds[k] == *kind)
			return 1;
	tool_error(&self, "--types: '%s' is not one of nav, pos, ins, pvt", text);
	return 0;
}

/* A boundary: seconds since the begin of the window, or a time. */
static int parse_boundary(const char *text, size_t n, fw_time origin, fw_time *t)
{
	char word[64];
	double seconds;
	if (n >= sizeof word)
		return 0;
	memcpy(word, text, n);
	word[n] = '\0';
	if (fw_get_double(word, n, &seconds) != FW_OK)
		return fw_time_parse(word, t) >= 0;
	if (!(seconds >= 0 && seconds <= 1e9))
		return 0;
	*t = fw_time_add_ns(origin, llround(seconds * 1e9));
	return 1;
}

/* "100": stretches of so many seconds from the begin of the window to its end. The last row of the truth is no stretch of
 * its own, it ends one. */
static int equal_sections(fw_time second, eval_section window)
{
	int64_t length = second.ns - window.begin.ns, at = window.begin.ns;
	eval_section *s = all.sections;
	if (length < 1000000)
		return usage("--sections: below a millisecond");
	for (int n = 0; n < MAX_SECTIONS; n++, at += length) {
		int last = at + length >= window.end.ns - 1;
		s[n] = (eval_section){{at}, last ? window.end : (fw_time){at + length}};
		if (!last)
			continue;
		all.question.n_sections = (size_t)n + 1;
		return EXIT_COMPLETE;
	}
	return usage("--sections: more than 2000 of them");
}

/* Fills all.sections from --sections, once it is known where the window is. */
static int parse_sections(const char *text, eval_section window)
{
	fw_time last = {0};
	int n = 0;
	all.question.sections = all.sections;
	for (const char *p = text; p != NULL && *p != '\0'; n++) {
		size_t length = strcspn(p, ",");
		fw_time t;
		if (!parse_boundary(p, length, window.begin, &t))
			return usage("--sections: neither seconds nor times, separated by commas");
		if (n > 0 && t.ns <= last.ns)
			return usage("--sections: the boundaries are not in order");
		if (n > MAX_SECTIONS)
			return usage("--sections: more than 2000 of them");
		if (n > 0)
			all.sections[all.question.n_sections++] = (eval_section){last, t};
		last = t;
		p += length + (p[length] == ',');
	}
	if (n == 1 && strchr(text, ':') != NULL)
		return usage("--sections: one time is no stretch");
	return n == 1 ? equal_sections(last, window) : EXIT_COMPLETE;
}

/* What can be said of the options before anything is read. Returns EXIT_COMPLETE or EXIT_USAGE. */
static int check_options(int n_files, char **files)
{
	const char *truth = options_text(&opts, "truth"), *arm = options_text(&opts, "lever-arm");
	const char *to = options_text(&opts, "output"), *html = options_text(&opts, "html");
	int from_stdin = (truth != NULL && strcmp(truth, "-") == 0) + (n_files == 0);
	fw_kind kind;

	self.quiet = options_flag(&opts, "quiet");
	self.verbose = options_flag(&opts, "verbose");
	if (truth == NULL)
		return usage("--truth FILE is needed: the trajectory that solutions are held against");
	for (int i = 0; i < n_files; i++)
		from_stdin += strcmp(files[i], "-") == 0;
	if (from_stdin > 1)
		return usage("standard input can be one file only: the truth, or one solution");
	if (n_files > MAX_SOLUTIONS)
		return usage("more than 32 solutions");
	if (html != NULL && strcmp(html, to != NULL ? to : "-") == 0)
		return usage("--html and --output go to the same place");
	if (!parse_kind(options_text(&opts, "types"), &kind))
		return EXIT_USAGE;
	all.truth.moved = arm != NULL;
	if (arm != NULL && !parse_lever_arm(arm, all.truth.lever_arm_m))
		return usage(
		    "--lever-arm: not three numbers, forward, right and down in metres, separated by commas");
	all.question.interval_ns = nanoseconds("interval");
	all.question.al_m[EVAL_H] =
	    options_text(&opts, "hal") != NULL ? options_number(&opts, "hal") : (double)INFINITY;
	all.question.al_m[EVAL_V] =
	    options_text(&opts, "val") != NULL ? options_number(&opts, "val") : (double)INFINITY;
	return EXIT_COMPLETE;
}

/* ---- the run ---- */

/* All of a series, unless --from and --until make it less. */
static void set_window(void)
{
	const eval_series *s = &all.truth_series;
	const fw_time *from = options_time(&opts, "from"), *until = options_time(&opts, "until");
	eval_section w = {s->fix[0].t, fw_time_add_ns(s->fix[s->n - 1].t, 1)};
	if (from != NULL && from->ns > w.begin.ns)
		w.begin = *from;
	if (until != NULL && until->ns < w.end.ns)
		w.end = *until;
	all.question.window = w;
}

static int read_truth(const char *path)
{
	eval_plan plan = {.kind = FW_RECORD_COUNT,
	                  .max = (size_t)options_number(&opts, "max-rows"),
	                  .progress = options_text(&opts, "progress")};
	int status = eval_series_read(&all.truth_series, &self, path, &plan, &all.totals);
	if (status < EXIT_USAGE && all.truth_series.n == 0) {
		tool_error(&self, "%s: no trajectory in it, so no truth", all.truth_series.name);
		return EXIT_NO_DATA;
	}
	/* Unless told otherwise, a row or two may be missing. */
	all.truth.series = &all.truth_series;
	all.truth.gap_ns = nanoseconds("max-gap");
	if (all.truth.gap_ns == 0)
		all.truth.gap_ns = eval_series_interval(&all.truth_series) * 5 / 2;
	return status;
}

static int read_levels(const char *path)
{
	eval_plan plan = {.kind = FW_pl,
	                  .max = (size_t)options_number(&opts, "max-rows"),
	                  .progress = options_text(&opts, "progress")};
	if (path == NULL)
		return EXIT_COMPLETE;
	int status = eval_series_read(&all.levels, &self, path, &plan, &all.totals);
	if (status < EXIT_USAGE && all.levels.n == 0) {
		tool_error(&self, "%s: no protection levels (pl) in it", all.levels.name);
		return EXIT_NO_DATA;
	}
	return status;
}

/* The files that --sky names. */
static int read_sky(const char *list)
{
	source_plan plan = {.table = FW_RECORD_COUNT,
	                    .antennas = FW_ANTENNA_MAIN,
	                    .nav_sources = FW_NAV_RAW | FW_NAV_DECODED,
	                    .progress = options_text(&opts, "progress")};
	int worst = EXIT_COMPLETE;
	eval_sky_kinds(&plan.wanted);
	for (const char *p = list; p != NULL && *p != '\0' && worst < EXIT_USAGE;) {
		char path[PATH_MAX];
		size_t n = strcspn(p, ",");
		snprintf(path, sizeof path, "%.*s", (int)n, p);
		int status = source_read(&self, path, &plan, (fw_sink){eval_sky_put, &all.sky}, &all.totals);
		worst = status > worst ? status : worst;
		p += n + (p[n] == ',');
	}
	return worst;
}

/* One solution. Returns EXIT_NO_DATA after a message when nothing can be said of it. */
static int evaluate(const char *path)
{
	eval_series *s = &all.solutions[all.n];
	eval_result *r = &all.results[all.n++];
	eval_plan plan = {.from = &all.question.window.begin,
	                  .until = &all.question.window.end,
	                  .max = (size_t)options_number(&opts, "max-rows"),
	                  .progress = options_text(&opts, "progress")};
	(void)parse_kind(options_text(&opts, "types"), &plan.kind);
	if (options_text(&opts, "html") != NULL && options_text(&opts, "sky") == NULL) {
		eval_sky_kinds(&plan.others);
		plan.other = (fw_sink){eval_sky_put, &all.sky};
	}
	int status = eval_series_read(s, &self, path, &plan, &all.totals);
	if (status >= EXIT_USAGE)
		return status;
	if (s->n == 0) {
		tool_error(&self, "%s: no solution in it for the time of the truth", s->name);
		return EXIT_NO_DATA;
	}
	eval_series_add_levels(s, &all.levels);
	fw_status compared = eval_compare(s, &all.truth, &all.question, r);
	if (compared == FW_OK)
		return status;
	tool_error(&self, "%s: %s", s->name,
	           compared == FW_ENOMEM ? "out of memory" : "no epoch for which there is truth");
	return compared == FW_ENOMEM ? EXIT_IO : EXIT_NO_DATA;
}

/* Reads and compares everything. Returns an exit status; a solution of which nothing can be said is no reason to stop. */
static int run(int n_files, char **files)
{
	static char dash[] = "-", *standard_input[] = {dash};
	int status = read_truth(options_text(&opts, "truth")), good = 0;
	if (status >= EXIT_USAGE)
		return status;
	set_window();
	int levels = parse_sections(options_text(&opts, "sections"), all.question.window);
	if (levels == EXIT_COMPLETE)
		levels = read_levels(options_text(&opts, "levels"));
	int sky = levels < EXIT_USAGE ? read_sky(options_text(&opts, "sky")) : EXIT_COMPLETE;
	levels = levels > sky ? levels : sky;
	if (levels >= EXIT_USAGE)
		return levels;
	status = levels > status ? levels : status;
	if (n_files == 0) {
		n_files = 1;
		files = standard_input;
	}
	for (int i = 0; i < n_files && !tool_interrupted(); i++) {
		int one = evaluate(files[i]);
		if (one == EXIT_IO)
			return one;
		good += one != EXIT_NO_DATA;
		if (one != EXIT_COMPLETE)
			status = EXIT_PARTIAL;
	}
	eval_sky_settle(&all.sky);
	return good > 0 ? status : EXIT_NO_DATA;
}

/* ---- the output ---- */

/* A text that grows in memory, so that it is whole before any of it is written. */
typedef struct {
	FILE *file;
	char *text;
	size_t n;
} draft;

static int begin_draft(draft *d)
{
	*d = (draft){0};
	d->file = open_memstream(&d->text, &d->n);
	if (d->file == NULL)
		tool_error(&self, "%s", strerror(errno));
	return d->file != NULL;
}

/* Puts the draft where `path` says, unless `status` is a failure already. Returns an exit status. */
static int end_draft(draft *d, const char *path, int status)
{
	output out;
	int whole = !ferror(d->file), closed = fclose(d->file) == 0;
	if (status == EXIT_COMPLETE && !(whole && closed)) {
		tool_error(&self, "out of memory");
		status = EXIT_IO;
	}
	if (status == EXIT_COMPLETE &&
	    (output_open(&out, path) != FW_OK || output_write(&out, d->text, d->n) != FW_OK ||
	     output_commit(&out) != FW_OK)) {
		tool_error(&self, "%s: %s", out.path, strerror(out.error));
		output_discard(&out);
		status = EXIT_IO;
	}
	free(d->text);
	return status;
}

static int write_page(const eval_report *report, int argc, char **argv)
{
	char command[2048] = "nav-eval";
	draft d;
	for (int i = 1; i < argc; i++) {
		size_t used = strlen(command);
		snprintf(command + used, sizeof command - used, " %s", argv[i]);
	}
	if (!begin_draft(&d))
		return EXIT_IO;
	int status = eval_write_html(report, command, &self, d.file) == FW_OK ? EXIT_COMPLETE : EXIT_IO;
	return end_draft(&d, options_text(&opts, "html"), status);
}

static int write_figures(const eval_report *report)
{
	draft d;
	if (!begin_draft(&d))
		return EXIT_IO;
	if (strcmp(options_text(&opts, "format"), "csv") == 0)
		eval_write_csv(report, d.file);
	else
		eval_write_text(report, d.file);
	return end_draft(&d, options_text(&opts, "output"), EXIT_COMPLETE);
}

/* The page first: without it there is nothing. */
static int write_all(int argc, char **argv)
{
	const eval_report report = {&all.truth, all.results, all.n, all.question.window.begin, &all.sky};
	int status = options_text(&opts, "html") != NULL ? write_page(&report, argc, argv) : EXIT_COMPLETE;
	return status == EXIT_COMPLETE ? write_figures(&report) : status;
}

static void release(void)
{
	for (int i = 0; i < all.n; i++) {
		eval_result_release(&all.results[i]);
		eval_series_release(&all.solutions[i]);
	}
	eval_series_release(&all.truth_series);
	eval_series_release(&all.levels);
	eval_sky_release(&all.sky);
}

static void summarise(void)
{
	size_t epochs = 0;
	for (int i = 0; i < all.n; i++)
		epochs += all.results[i].n;
	tool_note(&self, "%zu rows of truth, %zu epochs compared, %" PRIu64 " rows or blocks lost",
	          all.truth_series.n, epochs, all.totals.lost);
}

int main(int argc, char **argv)
{
	tool_hold_standard_streams();
	switch (options_parse(&opts, argc, argv)) {
	case OPTIONS_DONE: return tool_end_answer(&self);
	case OPTIONS_WRONG: return EXIT_USAGE;
	case OPTIONS_FAILED: return EXIT_IO;
	case OPTIONS_RUN: break;
	}
	if (check_options(argc - opts.first_file, argv + opts.first_file) != EXIT_COMPLETE)
		return EXIT_USAGE;
	tool_catch_signals();
	int status = run(argc - opts.first_file, argv + opts.first_file);
	tool_repeats(&self);
	if (!tool_interrupted() && status <= EXIT_PARTIAL) {
		int written = write_all(argc, argv);
		status = written != EXIT_COMPLETE ? written : status;
		if (written == EXIT_COMPLETE)
			summarise();
	}
	release();
	return tool_interrupted() ? tool_die_of(tool_interrupted()) : status;
}
