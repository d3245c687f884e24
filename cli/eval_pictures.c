#include "eval_pictures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/frame.h"

enum { CELLS = 900, TRACK_POINTS = 3000, SHARE_POINTS = 200, BINS = 60, STANFORD_BINS = 48 };

const char *eval_colour(int solution)
{
	static const char *const colours[] = {PLOT_BLUE,   PLOT_ORANGE, PLOT_GREEN,
	                                      PLOT_VIOLET, PLOT_TEAL,   PLOT_RED};
	return colours[solution % (int)(sizeof colours / sizeof colours[0])];
}

int eval_has_levels(const eval_result *r, int which)
{
	return r->whole.row[which == EVAL_H ? EVAL_HORIZONTAL : EVAL_DOWN].with_level > 0;
}

/* ---- over time ---- */

/* What a picture over time shows of an epoch; NaN where there is nothing. */
typedef struct {
	double error, bound, limit;
} sight;

typedef sight look(const eval_epoch *e, int which);

static sight look_error(const eval_epoch *e, int quantity)
{
	return (sight){e->error[quantity], 2 * e->sd[quantity], nan("")};
}

static sight look_level(const eval_epoch *e, int which)
{
	double error = fabs(e->error[which == EVAL_H ? EVAL_HORIZONTAL : EVAL_DOWN]);
	return (sight){error, e->pl_m[which], isfinite(e->al_m[which]) ? e->al_m[which] : nan("")};
}

/* More epochs than a screen has columns become cells: the extremes of the errors, the smallest of the bounds. */
typedef struct {
	double t_s, low, high, bound, limit;
	int64_t place;
	int n;
} cell;

static void put_cell(const cell *c, FILE *f)
{
	if (c->n == 0)
		return;
	fprintf(f, "%.4f %.5f %.6g %.6g\n", c->t_s, c->low, c->bound, c->limit);
	if (c->high > c->low)
		fprintf(f, "%.4f %.5f %.6g %.6g\n", c->t_s, c->high, c->bound, c->limit);
}

/* A data block: time, error, bound, limit; an empty line where epochs are missing. */
static void put_block(const eval_report *report, const eval_result *r, const char *name, look *at, int which,
                      FILE *f)
{
	const int64_t begin = r->epoch[0].t.ns, span = r->epoch[r->n - 1].t.ns - begin;
	const int64_t width = r->n > 2 * CELLS ? span / CELLS + 1 : 1;
	const double gap = 2.5 * (double)(r->interval_ns > width ? r->interval_ns : width);
	cell c = {0};
	int64_t last = begin;

	fprintf(f, "$%s << EOD\n", name);
	for (size_t i = 0; i < r->n; i++) {
		sight s = at(&r->epoch[i], which);
		int64_t now = r->epoch[i].t.ns;
		if (!isfinite(s.error))
			continue;
		if (c.n > 0 && (now - begin) / width != c.place) {
			put_cell(&c, f);
			c.n = 0;
			if ((double)(now - last) > gap)
				fputc('\n', f);
		}
		if (c.n++ == 0)
			c = (cell){eval_seconds(report, r->epoch[i].t),
			           s.error,
			           s.error,
			           s.bound,
			           s.limit,
			           (now - begin) / width,
			           1};
		c.low = fmin(c.low, s.error);
		c.high = fmax(c.high, s.error);
		c.bound = fmin(c.bound, s.bound);
		last = now;
	}
	put_cell(&c, f);
	fputs("EOD\n", f);
}

static void begin_panels(const eval_report *report, const eval_result *r, int n, FILE *f)
{
	fprintf(
	    f, "set xrange [%.6g:%.6g]\nset multiplot layout %d,1 margins 0.075,0.985,%g,0.97 spacing 0.05\n",
	    eval_seconds(report, r->whole.section.begin), eval_seconds(report, r->whole.section.end), n,
	    n == 3 ? 0.11 : 0.15);
	fputs("set format x ''\n", f);
}

static void label_panel(const char *label, int is_last, FILE *f)
{
	fprintf(f, "set ylabel '%s' textcolor rgb '" PLOT_INK "' offset 1,0\n", label);
	if (is_last)
		fputs("set format x '%g'\nset xlabel 'time [s]' textcolor rgb '" PLOT_INK "' offset 0,0.4\n",
		      f);
}

fw_status eval_draw_errors(const eval_report *report, const eval_result *r, eval_quantity first,
                           const tool *t, FILE *out)
{
	static const char *const colours[] = {PLOT_BLUE, PLOT_ORANGE, PLOT_GREEN};
	static const char *const labels[] = {
	    [EVAL_NORTH] = "north [m]", [EVAL_EAST] = "east [m]",     [EVAL_DOWN] = "down [m]",
	    [EVAL_VN] = "north [m/s]",  [EVAL_VE] = "east [m/s]",     [EVAL_VD] = "down [m/s]",
	    [EVAL_ROLL] = "roll [deg]", [EVAL_PITCH] = "pitch [deg]", [EVAL_HEADING] = "heading [deg]"};
	char name[16];
	plot p;
	if (plot_begin(&p, 1120, 560, t) != FW_OK)
		return FW_EIO;
	for (int i = 0; i < 3; i++) {
		snprintf(name, sizeof name, "d%d", i);
		put_block(report, r, name, look_error, (int)first + i, p.script);
	}
	begin_panels(report, r, 3, p.script);
	for (int i = 0; i < 3; i++) {
		int q = (int)first + i;
		label_panel(labels[q], i == 2, p.script);
		if (r->whole.row[q].errors.n == 0)
			fputs("plot [][-1:1] NaN\n", p.script);
		else
			fprintf(p.script,
			        "plot $d%d using 1:(-$3):3 with filledcurves fc rgb '%s', 0 lc rgb '" PLOT_INK
			        "' lw 0.6, $d%d using 1:2 with lines lw 1.2 lc rgb '%s'\n",
			        i, colours[i], i, colours[i]);
	}
	return plot_end(&p, t, out);
}

fw_status eval_draw_levels(const eval_report *report, const eval_result *r, const tool *t, FILE *out)
{
	static const char *const names[] = {"horizontal", "vertical"}, *const labels[] = {"horizontal [m]",
	                                                                                  "vertical [m]"};
	plot p;
	if (plot_begin(&p, 1120, 430, t) != FW_OK)
		return FW_EIO;
	for (int i = 0; i < 2; i++)
		put_block(report, r, names[i], look_level, i, p.script);
	begin_panels(report, r, 2, p.script);
	fputs("set yrange [0:*]\n", p.script);
	for (int i = 0; i < 2; i++) {
		label_panel(labels[i], i == 1, p.script);
		fprintf(p.script,
		        "plot $%s using 1:4 with lines lw 1.2 dt 2 lc rgb '" PLOT_RED
		        "', '' using 1:3 with lines lw "
		        "1.4 lc rgb '" PLOT_ORANGE "', '' using 1:2 with lines lw 1.2 lc rgb '" PLOT_BLUE
		        "'\n",
		        names[i]);
	}
	return plot_end(&p, t, out);
}

/* ---- tracks ---- */

/* The square that holds all tracks, metres from the origin. */
typedef struct {
	double low[2], high[2];
} bounds;

static void put_place(const double origin_m[static 3], const double point_m[static 3], bounds *b, FILE *f)
{
	double enu[3];
	if (fw_baseline_enu(origin_m, point_m, enu) != FW_OK)
		return;
	fprintf(f, "%.3f %.3f\n", enu[0], enu[1]);
	for (int i = 0; i < 2; i++) {
		b->low[i] = fmin(b->low[i], enu[i]);
		b->high[i] = fmax(b->high[i], enu[i]);
	}
}

static void put_truth(const eval_report *report, const double origin_m[static 3], bounds *b, FILE *f)
{
	const eval_series *s = report->truth->series;
	const size_t step = s->n / TRACK_POINTS + 1;
	const double gap_s = (double)report->truth->gap_ns / 1e9 * (double)step;
	fputs("$truth << EOD\n", f);
	for (size_t i = 0; i < s->n; i += step) {
		if (i > 0 && fw_time_diff_s(s->fix[i].t, s->fix[i - step].t) > gap_s)
			fputc('\n', f);
		put_place(origin_m, s->fix[i].position_m, b, f);
	}
	fputs("EOD\n", f);
}

static void put_track(const eval_result *r, int number, const double origin_m[static 3], bounds *b, FILE *f)
{
	const size_t step = r->n / TRACK_POINTS + 1;
	const double gap_s = 2.5 * (double)r->interval_ns / 1e9 * (double)step;
	fprintf(f, "$s%d << EOD\n", number);
	for (size_t i = 0; i < r->n; i += step) {
		if (i > 0 && fw_time_diff_s(r->epoch[i].t, r->epoch[i - step].t) > gap_s)
			fputc('\n', f);
		put_place(origin_m, r->epoch[i].solution->position_m, b, f);
	}
	fputs("EOD\n", f);
}

/* The same scale on both axes, and a little room around. */
static void put_bounds(const bounds *b, FILE *f)
{
	static const char *const axes[] = {"x", "y"};
	double half = 0.53 * fmax(fmax(b->high[0] - b->low[0], b->high[1] - b->low[1]), 0.01);
	for (int i = 0; i < 2; i++) {
		double middle = (b->low[i] + b->high[i]) / 2;
		fprintf(f, "set %srange [%.6f:%.6f]\n", axes[i], middle - half, middle + half);
	}
}

fw_status eval_draw_track(const eval_report *report, const tool *t, FILE *out)
{
	const double *origin_m = report->truth->series->fix[0].position_m;
	bounds b = {{0, 0}, {0, 0}};
	plot p;
	if (plot_begin(&p, 550, 510, t) != FW_OK)
		return FW_EIO;
	put_truth(report, origin_m, &b, p.script);
	for (int i = 0; i < report->n; i++)
		if (report->results[i].n > 0)
			put_track(&report->results[i], i, origin_m, &b, p.script);
	put_bounds(&b, p.script);
	fputs("set size square\nset xlabel 'east [m]' textcolor rgb '" PLOT_INK "'\n"
	      "set ylabel 'north [m]' textcolor rgb '" PLOT_INK "'\n"
	      "plot $truth using 1:2 with lines lw 3.5 lc rgb '" PLOT_MUTED "'",
	      p.script);
	for (int i = 0; i < report->n; i++)
		if (report->results[i].n > 0)
			fprintf(p.script, ", $s%d using 1:2 with lines lw 1.2 lc rgb '%s'", i,
			        eval_colour(i));
	fputc('\n', p.script);
	return plot_end(&p, t, out);
}

/* ---- how often ---- */

/* All known errors of a quantity, magnitudes in ascending order. Returns how many; *values to be given to free(). */
static size_t sorted_errors(const eval_result *r, eval_quantity q, double **values)
{
	size_t n = 0;
	fw_summary s;
	*values = malloc((r->n > 0 ? r->n : 1) * sizeof(double));
	for (size_t i = 0; *values != NULL && i < r->n; i++)
		if (isfinite(r->epoch[i].error[q]))
			(*values)[n++] = r->epoch[i].error[q];
	return fw_summarise(n, *values, &s) == FW_OK ? n : 0;
}

static void put_shares(const eval_result *r, int number, const char *letter, eval_quantity q, FILE *f)
{
	double *values;
	size_t n = sorted_errors(r, q, &values);
	fprintf(f, "$%s%d << EOD\n0 0\n", letter, number);
	for (int i = 1; i <= SHARE_POINTS && n > 0; i++) {
		double share = (double)i / SHARE_POINTS;
		fprintf(f, "%.6g %.6g\n", fw_quantile(n, values, share), 100 * share);
	}
	fputs("EOD\n", f);
	free(values);
}

fw_status eval_draw_shares(const eval_report *report, const tool *t, FILE *out)
{
	double reach = 0;
	plot p;
	if (plot_begin(&p, 550, 470, t) != FW_OK)
		return FW_EIO;
	for (int i = 0; i < report->n; i++) {
		const eval_result *r = &report->results[i];
		if (r->n == 0)
			continue;
		put_shares(r, i, "h", EVAL_HORIZONTAL, p.script);
		put_shares(r, i, "v", EVAL_DOWN, p.script);
		reach = fmax(reach, fmax(r->whole.row[EVAL_HORIZONTAL].errors.p99,
		                         r->whole.row[EVAL_DOWN].errors.p99));
	}
	fprintf(p.script, "set xrange [0:%.6g]\nset yrange [0:100]\nset ytics add (68, 95)\n",
	        reach > 0 ? 1.05 * reach : 1);
	fputs("set xlabel 'error [m]' textcolor rgb '" PLOT_INK
	      "'\nset ylabel 'share of epochs [%]' textcolor rgb '" PLOT_INK "'\nplot 95 lc rgb '" PLOT_INK
	      "' lw 0.6",
	      p.script);
	for (int i = 0; i < report->n; i++)
		if (report->results[i].n > 0)
			fprintf(p.script,
			        ", $h%d using 1:2 with lines lw 2 lc rgb '%s', $v%d using 1:2 with lines lw "
			        "2 dt 2 lc rgb '%s'",
			        i, eval_colour(i), i, eval_colour(i));
	fputc('\n', p.script);
	return plot_end(&p, t, out);
}

/* Shares per bin of the errors of a quantity, divided by their standard deviations if `scaled`. */
static void put_histogram(const eval_result *r, eval_quantity q, int scaled, double reach, FILE *f)
{
	size_t count[BINS] = {0}, n = 0;
	for (size_t i = 0; i < r->n; i++) {
		double x = r->epoch[i].error[q] / (scaled ? r->epoch[i].sd[q] : 1);
		if (!isfinite(x))
			continue;
		n++;
		if (fabs(x) < reach)
			count[(int)((x + reach) / (2 * reach) * BINS)]++;
	}
	fprintf(f, "$q%d << EOD\n", (int)q);
	for (int i = 0; i < BINS && n > 0; i++)
		fprintf(f, "%.6g %.6g\n", (2 * (i + 0.5) / BINS - 1) * reach,
		        100 * (double)count[i] / (double)n);
	fputs("EOD\n", f);
}

fw_status eval_draw_histogram(const eval_result *r, const tool *t, FILE *out)
{
	const eval_row *row = r->whole.row;
	int scaled = row[EVAL_NORTH].with_sd > 0 && row[EVAL_EAST].with_sd > 0 && row[EVAL_DOWN].with_sd > 0;
	double reach = scaled ? 4.5 : fmax(row[EVAL_HORIZONTAL].errors.p99, row[EVAL_DOWN].errors.p99) * 1.2;
	double bin = 2 * reach / BINS;
	plot p;
	if (plot_begin(&p, 550, 470, t) != FW_OK)
		return FW_EIO;
	reach = reach > 0 ? reach : 1;
	for (int q = EVAL_NORTH; q <= EVAL_DOWN; q++)
		put_histogram(r, (eval_quantity)q, scaled, reach, p.script);
	fprintf(p.script,
	        "set xrange [%.6g:%.6g]\nset yrange [0:*]\nset xlabel '%s' textcolor rgb '" PLOT_INK
	        "'\nset ylabel 'share of epochs [%%]' textcolor rgb '" PLOT_INK "'\nset samples 200\nplot ",
	        -reach, reach, scaled ? "error in standard deviations" : "error [m]");
	if (scaled)
		fprintf(p.script, "%.6g * exp(-x * x / 2) with filledcurves y1=0 fc rgb '" PLOT_INK "', ",
		        100 * bin / sqrt(2 * FW_PI));
	fprintf(p.script,
	        "$q%d with histeps lw 1.6 lc rgb '" PLOT_BLUE
	        "', $q%d with histeps lw 1.6 lc rgb '" PLOT_ORANGE
	        "', $q%d with histeps lw 1.6 lc rgb '" PLOT_GREEN "'\n",
	        EVAL_NORTH, EVAL_EAST, EVAL_DOWN);
	return plot_end(&p, t, out);
}

/* ---- the Stanford diagram ---- */

/* Up to where the axes go: beyond the limit, the levels and nearly all errors. */
static double stanford_reach(const eval_result *r, int which)
{
	double reach = 0;
	for (size_t i = 0; i < r->n; i++) {
		const eval_epoch *e = &r->epoch[i];
		if (!isfinite(e->pl_m[which]))
			continue;
		reach = fmax(reach, look_level(e, which).error);
		reach =
		    fmax(reach, fmin(e->pl_m[which], isfinite(e->al_m[which]) ? 2 * e->al_m[which] : 1e3));
		if (isfinite(e->al_m[which]))
			reach = fmax(reach, 1.2 * e->al_m[which]);
	}
	return reach > 0 ? 1.05 * reach : 1;
}

/* Epochs per cell, those beyond the axes in the outermost cells: error, level, how many. Returns the most in a cell. */
static unsigned put_stanford(const eval_result *r, int which, double reach, FILE *f)
{
	unsigned count[STANFORD_BINS][STANFORD_BINS] = {0}, most = 0;
	for (size_t i = 0; i < r->n; i++) {
		sight s = look_level(&r->epoch[i], which);
		if (!isfinite(s.bound) || !(s.bound >= 0))
			continue;
		int x = (int)fmin(s.error / reach * STANFORD_BINS, STANFORD_BINS - 1);
		int y = (int)fmin(s.bound / reach * STANFORD_BINS, STANFORD_BINS - 1);
		count[x][y]++;
		most = count[x][y] > most ? count[x][y] : most;
	}
	fputs("$cells << EOD\n", f);
	for (int x = 0; x < STANFORD_BINS; x++)
		for (int y = 0; y < STANFORD_BINS; y++)
			if (count[x][y] > 0)
				fprintf(f, "%.6g %.6g %u\n", (x + 0.5) * reach / STANFORD_BINS,
				        (y + 0.5) * reach / STANFORD_BINS, count[x][y]);
	fputs("EOD\n", f);
	return most;
}

/* The last limit given; NaN: none. */
static double alert_limit(const eval_result *r, int which)
{
	double limit = nan("");
	for (size_t i = 0; i < r->n; i++)
		if (isfinite(r->epoch[i].al_m[which]))
			limit = r->epoch[i].al_m[which];
	return limit;
}

static void put_region(int number, const double corner[][2], int n, const char *colour, double opacity,
                       FILE *f)
{
	fprintf(f, "set object %d polygon", number);
	for (int i = 0; i <= n; i++)
		fprintf(f, "%s %.6g,%.6g", i == 0 ? " from" : " to", corner[i % n][0], corner[i % n][1]);
	fprintf(f, " fc rgb '%s' fillstyle solid %g noborder behind\n", colour, opacity);
}

/* The regions of the diagram as coloured ground, the limits as lines. */
static void put_regions(double reach, double al, FILE *f)
{
	const double L = reach, A = isfinite(al) ? fmin(al, reach) : reach;
	const double nominal[][2] = {{0, 0}, {A, A}, {0, A}}, misleading[][2] = {{0, 0}, {A, 0}, {A, A}};
	const double hazardous[][2] = {{A, 0}, {L, 0}, {L, A}, {A, A}};
	const double unavailable[][2] = {{0, A}, {A, A}, {L, L}, {0, L}},
	             both[][2] = {{A, A}, {L, A}, {L, L}};
	put_region(1, nominal, 3, PLOT_GREEN, 0.14, f);
	put_region(2, misleading, 3, PLOT_ORANGE, 0.16, f);
	if (A < L) {
		put_region(3, hazardous, 4, PLOT_RED, 0.22, f);
		put_region(4, unavailable, 4, PLOT_GRID, 0.4, f);
		put_region(5, both, 3, PLOT_ORANGE, 0.10, f);
		fprintf(f, "set arrow 1 from 0,%.6g to %.6g,%.6g nohead lc rgb '" PLOT_INK "' lw 0.8 dt 2\n",
		        A, L, A);
		fprintf(f, "set arrow 2 from %.6g,0 to %.6g,%.6g nohead lc rgb '" PLOT_INK "' lw 0.8 dt 2\n",
		        A, A, A);
	}
	fprintf(f, "set arrow 3 from 0,0 to %.6g,%.6g nohead lc rgb '" PLOT_INK "' lw 1\n", L, L);
}

static void put_count(const char *name, const eval_row *row, fw_stanford class, double x, double y, FILE *f)
{
	fprintf(f, "set label '%s %.2f %%' at %.6g,%.6g right front textcolor rgb '" PLOT_INK "'\n", name,
	        eval_percent(row->stanford[class], row->with_level), x, y);
}

fw_status eval_draw_stanford(const eval_result *r, int which, const tool *t, FILE *out)
{
	const eval_row *row = &r->whole.row[which == EVAL_H ? EVAL_HORIZONTAL : EVAL_DOWN];
	const double L = stanford_reach(r, which), al = alert_limit(r, which), A = isfinite(al) ? al : L;
	plot p;
	if (plot_begin(&p, 550, 510, t) != FW_OK)
		return FW_EIO;
	unsigned most = put_stanford(r, which, L, p.script);
	put_regions(L, al, p.script);
	put_count("nominal", row, FW_NOMINAL, 0.9 * A, A - 0.03 * L, p.script);
	put_count("MI", row, FW_MISLEADING, 0.97 * A, 0.1 * A, p.script);
	if (A < L) {
		put_count("HMI", row, FW_HAZARDOUS, 0.99 * L, 0.25 * A, p.script);
		put_count("unavailable", row, FW_UNAVAILABLE, 0.9 * L, 0.97 * L, p.script);
		put_count("unavailable, MI", row, FW_UNAVAILABLE_MISLEADING, 0.99 * L, A + 0.03 * L,
		          p.script);
	}
	fprintf(p.script,
	        "unset grid\nunset colorbox\nset size square\nset xrange [0:%.6g]\nset yrange [0:%.6g]\n"
	        "set xlabel '%s error [m]' textcolor rgb '" PLOT_INK
	        "'\nset ylabel '%s protection level [m]' textcolor rgb '" PLOT_INK
	        "'\nset palette defined (0 '#60a5fa', 0.5 '#2563eb', 1 '#f97316')\nset cbrange [0:%.6g]\nset "
	        "style fill solid 1 noborder\n"
	        "plot $cells using 1:2:(%.6g):(%.6g):(log10($3)) with boxxyerror lc palette\n",
	        L, L, which == EVAL_H ? "horizontal" : "vertical",
	        which == EVAL_H ? "horizontal" : "vertical", most > 1 ? log10((double)most) : 1.0,
	        0.48 * L / STANFORD_BINS, 0.48 * L / STANFORD_BINS);
	return plot_end(&p, t, out);
}

/* ---- the sky ---- */

/* Where on the picture a satellite is seen from the truth: the zenith in the middle, the horizon at radius 90. Returns 0
 * when it is not. */
static int sky_place(const eval_report *report, const eval_sighting *s, double *x, double *y)
{
	eval_fix here;
	double enu[3], azimuth, elevation;
	if (eval_truth_at(report->truth, s->t, &here) != FW_OK ||
	    fw_baseline_enu(here.position_m, s->position_m, enu) != FW_OK ||
	    fw_azimuth_elevation(enu, &azimuth, &elevation) != FW_OK || !(elevation >= 0))
		return 0;
	double radius = 90 - fw_deg_from_rad(elevation);
	*x = radius * sin(azimuth);
	*y = radius * cos(azimuth);
	return 1;
}

static const char *system_colour(fw_satellite s)
{
	static const char *const colours[FW_SYSTEM_COUNT] = {
	    [FW_GPS] = PLOT_BLUE,      [FW_GALILEO] = PLOT_ORANGE, [FW_BEIDOU] = PLOT_RED,
	    [FW_GLONASS] = PLOT_GREEN, [FW_QZSS] = PLOT_VIOLET,    [FW_NAVIC] = PLOT_MUTED,
	    [FW_SBAS] = PLOT_TEAL};
	return colours[s.system];
}

/* The path of one satellite, broken where it was not seen for a minute; a dot and its name at the end. Labels go to
 * `labels`, since a data block is open in `f`. */
static void put_path(const eval_report *report, const eval_sighting *s, size_t n, FILE *f, FILE *labels)
{
	const char *colour = system_colour(s->satellite);
	double x, y, last_x = nan(""), last_y = nan("");
	char name[8];
	fw_satellite_name(s->satellite, name);
	for (size_t i = 0; i < n; i++) {
		if (!sky_place(report, &s[i], &x, &y))
			continue;
		if (i > 0 && s[i].t.ns - s[i - 1].t.ns > 60 * FW_NS_PER_S)
			fputc('\n', f);
		fprintf(f, "%.2f %.2f 0x%s\n", x, y, colour + 1);
		last_x = x;
		last_y = y;
	}
	fputc('\n', f);
	if (isfinite(last_x))
		fprintf(labels,
		        "set label '%s' at %.2f,%.2f left offset 0.6,0 front textcolor rgb '" PLOT_INK
		        "'\nset object circle at %.2f,%.2f size 1.3 fc rgb '%s' fillstyle solid 1 noborder\n",
		        name, last_x, last_y, last_x, last_y, colour);
}

static void put_dome(FILE *f)
{
	static const struct {
		const char *name;
		int x, y;
	} winds[] = {{"N", 0, 98}, {"E", 98, 0}, {"S", 0, -98}, {"W", -98, 0}};
	fputs("unset border\nunset tics\nunset grid\nset size square\nset xrange [-104:104]\nset yrange "
	      "[-104:104]\n",
	      f);
	for (int radius = 30; radius <= 90; radius += 30)
		fprintf(f, "set label '%d' at 1,%d left textcolor rgb '" PLOT_MUTED "'\n", 90 - radius,
		        radius - 4);
	for (int i = 0; i < 4; i++)
		fprintf(f,
		        "set arrow from 0,0 to %g,%g nohead back lc rgb '" PLOT_GRID "'\n"
		        "set label '%s' at %d,%d center textcolor rgb '" PLOT_INK "'\n",
		        winds[i].x / 98.0 * 90, winds[i].y / 98.0 * 90, winds[i].name, winds[i].x,
		        winds[i].y);
}

/* Elevations 0, 30 and 60, drawn as paths are. */
static void put_circles(FILE *f)
{
	enum { STEPS = 72 };
	for (int radius = 30; radius <= 90; radius += 30) {
		for (int i = 0; i <= STEPS; i++)
			fprintf(f, "%.2f %.2f 0x%s\n", radius * cos(2 * FW_PI * i / STEPS),
			        radius * sin(2 * FW_PI * i / STEPS), &PLOT_GRID[1]);
		fputc('\n', f);
	}
}

static void put_sky(const eval_report *report, FILE *f, FILE *labels)
{
	const eval_sky *sky = report->sky;
	put_dome(f);
	fputs("$paths << EOD\n", f);
	put_circles(f);
	for (size_t i = 0, end; i < sky->n; i = end) {
		for (end = i; end < sky->n &&
		              fw_satellite_equal(sky->sighting[end].satellite, sky->sighting[i].satellite);)
			end++;
		put_path(report, &sky->sighting[i], end - i, f, labels);
	}
	fputs("EOD\n", f);
}

fw_status eval_draw_sky(const eval_report *report, const tool *t, FILE *out)
{
	char *text = NULL;
	size_t length = 0;
	FILE *labels = open_memstream(&text, &length);
	plot p;
	if (labels == NULL)
		return FW_EIO;
	fw_status status = plot_begin(&p, 550, 510, t);
	if (status == FW_OK)
		put_sky(report, p.script, labels);
	fclose(labels);
	if (status == FW_OK) {
		fprintf(p.script, "%splot $paths using 1:2:3 with lines lw 1.6 lc rgb variable\n", text);
		status = plot_end(&p, t, out);
	}
	free(text);
	return status;
}
