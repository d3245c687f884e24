#include "eval_report.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

double eval_percent(uint64_t part, uint64_t whole)
{
	return whole > 0 ? 100 * (double)part / (double)whole : 0;
}

double eval_seconds(const eval_report *report, fw_time t)
{
	return fw_time_diff_s(t, report->origin);
}

/* Without "-0.0000". */
static double tidy(double x, int decimals)
{
	return fabs(x) < 0.5 * pow(10, -decimals) ? 0 : x;
}

/* ---- text ---- */

static void write_head(const eval_report *report, const eval_result *r, FILE *out)
{
	const eval_series *truth = report->truth->series;
	double longest_s, off_m = eval_truth_interpolation(report->truth);
	size_t gaps = eval_truth_gaps(report->truth, &longest_s);

	fprintf(out, "solution  %s (%s), every %.9g s\n", r->solution->name,
	        fw_record_type_of(r->solution->kind)->name, (double)r->interval_ns / 1e9);
	fprintf(out, "truth     %s (%s), %zu rows every %.9g s", truth->name,
	        fw_record_type_of(truth->kind)->name, truth->n, (double)eval_series_interval(truth) / 1e9);
	if (gaps > 0)
		fprintf(out, ", %zu gap%s of up to %.9g s", gaps, gaps == 1 ? "" : "s", longest_s);
	if (isfinite(off_m))
		fprintf(out, "; between rows good to about %.2g m", off_m);
	fputc('\n', out);
	if (r->without_truth > 0)
		fprintf(out, "          %zu epochs of the solution at times without truth\n",
		        r->without_truth);
}

static void write_row(const char *name, const eval_row *row, FILE *out)
{
	const fw_summary *s = &row->errors;
	fprintf(out, "%-13s%9zu", name, s->n);
	if (s->n > 0)
		fprintf(out, "%11.4f%11.4f%11.4f%11.4f%11.4f%11.4f%11.4f", tidy(s->mean, 4), s->rms, s->p50,
		        s->p68, s->p95, s->p99, s->max);
	for (int k = 0; k < 3 && row->with_sd > 0; k++)
		fprintf(out, "%7.2f", eval_percent(row->inside[k], row->with_sd));
	fputc('\n', out);
}

static void write_levels(const char *name, const eval_row *row, FILE *out)
{
	const uint64_t *n = row->stanford;
	if (row->with_level > 0)
		fprintf(out,
		        "%-13s%9" PRIu64 " epochs with protection level: %" PRIu64 " nominal, %" PRIu64
		        " MI, %" PRIu64 " HMI, %" PRIu64 " unavailable, %" PRIu64
		        " unavailable and misleading\n",
		        name, row->with_level, n[FW_NOMINAL], n[FW_MISLEADING], n[FW_HAZARDOUS],
		        n[FW_UNAVAILABLE], n[FW_UNAVAILABLE_MISLEADING]);
	if (row->with_fom > 0)
		fprintf(out,
		        "%-13s%9" PRIu64
		        " epochs with figure of merit: %.2f %% of errors inside (95 expected)\n",
		        name, row->with_fom, eval_percent(row->fom_inside, row->with_fom));
}

static void write_nees(const char *name, const eval_row *row, FILE *out)
{
	if (row->with_nees > 0)
		fprintf(out,
		        "%-13s%9" PRIu64 " epochs with standard deviations: NEES %.3f (1 expected), %.2f %% "
		        "below its 95 %% point\n",
		        name, row->with_nees, row->nees, eval_percent(row->nees_inside, row->with_nees));
}

static void write_figures(const eval_result *r, const eval_figures *f, FILE *out)
{
	const eval_row *position = &f->row[EVAL_POSITION];
	fprintf(out, "epochs    %" PRIu64 " of %" PRIu64 " solved, %.2f %% available\n\n", position->solved,
	        f->expected, eval_percent(position->solved, f->expected));
	fprintf(out, "%-13s%9s%11s%11s%11s%11s%11s%11s%11s%7s%7s%7s\n", "", "n", "mean", "rms", "50 %",
	        "68 %", "95 %", "99 %", "max", "1 sd", "2 sd", "3 sd");
	for (int q = 0; q < EVAL_QUANTITIES; q++)
		if (r->whole.row[q].errors.n > 0)
			write_row(eval_quantity_names[q], &f->row[q], out);
	write_nees("position", position, out);
	write_nees("velocity", &f->row[EVAL_VELOCITY], out);
	write_nees("attitude", &f->row[EVAL_ATTITUDE], out);
	write_levels("horizontal", &f->row[EVAL_HORIZONTAL], out);
	write_levels("vertical", &f->row[EVAL_DOWN], out);
}

void eval_write_text(const eval_report *report, FILE *out)
{
	for (int i = 0; i < report->n; i++) {
		const eval_result *r = &report->results[i];
		if (r->n == 0)
			continue;
		if (i > 0)
			fputc('\n', out);
		write_head(report, r, out);
		write_figures(r, &r->whole, out);
		for (size_t k = 0; k < r->n_sections; k++) {
			const eval_section *s = &r->sections[k].section;
			fprintf(out, "\nsection %zu  %.9g to %.9g s\n", k + 1, eval_seconds(report, s->begin),
			        eval_seconds(report, s->end));
			write_figures(r, &r->sections[k], out);
		}
	}
}

/* ---- table ---- */

static const char columns[] =
    "solution,section,begin_s,end_s,quantity,n,expected,available_percent,mean,rms,p50,p68,p95,"
    "p99,max,inside_1sd_percent,inside_2sd_percent,inside_3sd_percent,nees,nees_inside_percent,"
    "n_levels,nominal,misleading,hazardous,unavailable,unavailable_misleading,fom_inside_percent\n";

/* RFC 4180: in quotes when it has to be. */
static void write_field(const char *text, FILE *out)
{
	if (text[strcspn(text, ",\"\r\n")] == '\0') {
		fputs(text, out);
		return;
	}
	fputc('"', out);
	for (const char *p = text; *p != '\0'; p++)
		fprintf(out, "%s%c", *p == '"' ? "\"" : "", *p);
	fputc('"', out);
}

/* Shares, if they are of something. */
static void write_shares(const uint64_t *part, int n, uint64_t whole, FILE *out)
{
	for (int k = 0; k < n; k++)
		if (whole > 0)
			fprintf(out, ",%.4f", eval_percent(part[k], whole));
		else
			fputc(',', out);
}

static void write_csv_row(const eval_figures *f, const eval_row *row, FILE *out)
{
	const fw_summary *s = &row->errors;
	fprintf(out, ",%zu,%" PRIu64, s->n, f->expected);
	write_shares(&row->solved, 1, f->expected, out);
	if (s->n > 0)
		fprintf(out, ",%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f", tidy(s->mean, 6), s->rms, s->p50, s->p68,
		        s->p95, s->p99, s->max);
	else
		fputs(",,,,,,,", out);
	write_shares(row->inside, 3, row->with_sd, out);
	if (row->with_nees > 0)
		fprintf(out, ",%.6f", row->nees);
	else
		fputc(',', out);
	write_shares(&row->nees_inside, 1, row->with_nees, out);
	if (row->with_level > 0) {
		fprintf(out, ",%" PRIu64, row->with_level);
		for (int k = 0; k < FW_STANFORD_CLASSES; k++)
			fprintf(out, ",%" PRIu64, row->stanford[k]);
	} else {
		fputs(",,,,,,", out);
	}
	write_shares(&row->fom_inside, 1, row->with_fom, out);
	fputc('\n', out);
}

static void write_csv_figures(const eval_report *report, const eval_result *r, const eval_figures *f,
                              const char *section, FILE *out)
{
	for (int q = 0; q < EVAL_QUANTITIES; q++) {
		if (r->whole.row[q].errors.n == 0)
			continue;
		write_field(r->solution->name, out);
		fprintf(out, ",%s,%.9g,%.9g,%s", section, eval_seconds(report, f->section.begin),
		        eval_seconds(report, f->section.end), eval_quantity_names[q]);
		write_csv_row(f, &f->row[q], out);
	}
}

void eval_write_csv(const eval_report *report, FILE *out)
{
	fputs(columns, out);
	for (int i = 0; i < report->n; i++) {
		const eval_result *r = &report->results[i];
		if (r->n == 0)
			continue;
		write_csv_figures(report, r, &r->whole, "all", out);
		for (size_t k = 0; k < r->n_sections; k++) {
			char number[32];
			snprintf(number, sizeof number, "%zu", k + 1);
			write_csv_figures(report, r, &r->sections[k], number, out);
		}
	}
}
