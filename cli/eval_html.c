#include "eval_html.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "eval_pictures.h"

/* clang-format off */
static const char style[] =
	":root{color-scheme:light dark;--page:#f4f6f9;--card:#fff;--text:#0f172a;--soft:#5b6b82;"
	"--line:#e2e8f0;--ink:#334155;--muted:#94a3b8;--grid:#d6dce5;--blue:#2563eb;--orange:#ea580c;"
	"--green:#16a34a;--violet:#9333ea;--red:#dc2626;--teal:#0d9488}\n"
	"@media(prefers-color-scheme:dark){:root{--page:#0b1120;--card:#131c2e;--text:#e8edf5;"
	"--soft:#93a4bd;--line:#25324a;--ink:#c3cfdf;--muted:#7688a3;--grid:#2c3a54;--blue:#6ea8ff;"
	"--orange:#ff9a57;--green:#4ade80;--violet:#c79bff;--red:#ff7b7b;--teal:#2dd4bf}}\n"
	"*{box-sizing:border-box}"
	"body{margin:0;background:var(--page);color:var(--text);"
	"font:15px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,'Noto Sans','DejaVu Sans',sans-serif}\n"
	"main{max-width:1180px;margin:0 auto;padding:28px 20px 48px}"
	"h1{font-size:26px;margin:0 0 2px;letter-spacing:-.01em}"
	"h2{font-size:20px;margin:44px 0 12px;overflow-wrap:anywhere}h3{font-size:15px;margin:0 0 2px}"
	"p{margin:0}.soft{color:var(--soft)}"
	"code{font:13px ui-monospace,'DejaVu Sans Mono',monospace;overflow-wrap:anywhere}\n"
	".cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:12px;"
	"margin-bottom:14px}"
	".card,figure,.table{background:var(--card);border:1px solid var(--line);border-radius:12px}"
	".card{padding:12px 16px}"
	".card b{display:block;font-size:24px;font-weight:650;letter-spacing:-.02em}"
	".card span{color:var(--soft);font-size:13px}\n"
	"figure{margin:0;padding:16px 16px 8px;min-width:0}"
	"figure svg{display:block;width:100%;height:auto;margin-top:6px}"
	"figcaption{color:var(--soft);font-size:13px}"
	".key{display:inline-block;width:18px;height:0;border-top:3px solid;vertical-align:middle;"
	"margin:0 5px 2px 10px;border-radius:2px}.dash{border-top-style:dashed}"
	".band{border-top-width:10px;opacity:.3}\n"
	".grid{display:grid;grid-template-columns:repeat(2,minmax(0,1fr));gap:14px;margin-top:14px}"
	".wide{grid-column:1/-1;overflow-x:auto}.wide svg{min-width:640px}"
	"@media(max-width:820px){.grid{grid-template-columns:minmax(0,1fr)}}\n"
	".table{overflow-x:auto;padding:6px 16px 10px;margin-top:14px}"
	"table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums;font-size:14px}"
	"th,td{padding:5px 8px;text-align:right;white-space:nowrap;border-bottom:1px solid var(--line)}"
	"th{color:var(--soft);font-weight:500}tr:last-child td{border-bottom:0}"
	"th:first-child,td:first-child{text-align:left}\n"
	"svg text,svg tspan{font-family:inherit;font-size:13px}"
	"footer{margin-top:40px;color:var(--soft);font-size:13px}\n"
	"@media print{body{background:#fff}figure,.table,.card{break-inside:avoid}}\n";
/* clang-format on */

/* ---- text ---- */

static void put_escaped(const char *text, FILE *out)
{
	for (const char *p = text; *p != '\0'; p++) {
		if (*p == '<')
			fputs("&lt;", out);
		else if (*p == '>')
			fputs("&gt;", out);
		else if (*p == '&')
			fputs("&amp;", out);
		else if (*p == '"')
			fputs("&quot;", out);
		else
			fputc((unsigned char)*p < ' ' ? ' ' : *p, out);
	}
}

/* Rules that give the pictures' colours the names of the page's, so that they follow it into the dark. gnuplot writes a
 * colour in two ways. */
static void put_colours(FILE *out)
{
	static const struct {
		const char *name, *colour;
	} colours[] = {{"ink", PLOT_INK},       {"muted", PLOT_MUTED},   {"grid", PLOT_GRID},
	               {"blue", PLOT_BLUE},     {"orange", PLOT_ORANGE}, {"green", PLOT_GREEN},
	               {"violet", PLOT_VIOLET}, {"red", PLOT_RED},       {"teal", PLOT_TEAL}};
	for (size_t i = 0; i < sizeof colours / sizeof colours[0]; i++) {
		unsigned long rgb = strtoul(colours[i].colour + 1, NULL, 16);
		unsigned r = rgb >> 16 & 255, g = rgb >> 8 & 255, b = rgb & 255;
		fprintf(out,
		        "[stroke=\"rgb(%3u, %3u, %3u)\"]{stroke:var(--%s)}[fill=\"rgb(%3u, %3u, "
		        "%3u)\"],[fill=\"rgb(%u,%u,%u)\"]"
		        "{fill:var(--%s)}\n",
		        r, g, b, colours[i].name, r, g, b, r, g, b, colours[i].name);
	}
}

/* "#2563eb" to the name of the page's colour is a detour: the key uses the style's own. */
static const char *key_colour(int solution)
{
	static const char *const names[] = {"blue", "orange", "green", "violet", "teal", "red"};
	return names[solution % (int)(sizeof names / sizeof names[0])];
}

static void put_key(const char *colour, const char *kind, FILE *out)
{
	fprintf(out, "<i class=\"key %s\" style=\"border-color:var(--%s)\"></i>", kind, colour);
}

/* ---- figures ---- */

static void put_card(int decimals, double value, const char *unit, const char *what, FILE *out)
{
	fprintf(out, "<div class=card><b>%.*f%s</b><span>%s</span></div>\n", decimals, value, unit, what);
}

static void put_cards(const eval_result *r, FILE *out)
{
	const eval_row *row = r->whole.row;
	const eval_row *h = &row[EVAL_HORIZONTAL], *v = &row[EVAL_DOWN], *p = &row[EVAL_POSITION];
	fputs("<div class=cards>\n", out);
	put_card(3, h->errors.p95, " m", "horizontal, 95 %", out);
	put_card(3, v->errors.p95, " m", "vertical, 95 %", out);
	put_card(2, eval_percent(p->solved, r->whole.expected), " %", "of epochs available", out);
	if (p->with_nees > 0)
		put_card(2, p->nees, "", "NEES of position, 1 expected", out);
	if (row[EVAL_HEADING].errors.n > 0)
		put_card(3, row[EVAL_HEADING].errors.rms, "&deg;", "heading, RMS", out);
	if (h->with_level + v->with_level > 0)
		put_card(0,
		         (double)(h->stanford[FW_HAZARDOUS] + v->stanford[FW_HAZARDOUS] +
		                  h->stanford[FW_MISLEADING] + v->stanford[FW_MISLEADING]),
		         "", "misleading epochs (MI, HMI)", out);
	fputs("</div>\n", out);
}

static void put_table(const eval_result *r, FILE *out)
{
	fputs("<div class=table><table><tr><th>error<th>n<th>mean<th>RMS<th>50 %<th>68 %<th>95 %<th>99 "
	      "%<th>max<th>in 1 "
	      "sd<th>2 sd<th>3 sd</tr>\n",
	      out);
	for (int q = 0; q < EVAL_QUANTITIES; q++) {
		const eval_row *row = &r->whole.row[q];
		const fw_summary *s = &row->errors;
		if (s->n == 0)
			continue;
		fprintf(out, "<tr><td>%s<td>%zu<td>%.4f<td>%.4f<td>%.4f<td>%.4f<td>%.4f<td>%.4f<td>%.4f",
		        eval_quantity_names[q], s->n, s->mean, s->rms, s->p50, s->p68, s->p95, s->p99,
		        s->max);
		for (int k = 0; k < 3; k++)
			if (row->with_sd > 0)
				fprintf(out, "<td>%.1f %%", eval_percent(row->inside[k], row->with_sd));
			else
				fputs("<td>", out);
		fputs("</tr>\n", out);
	}
	fputs("</table></div>\n", out);
}

static void put_integrity(const eval_result *r, FILE *out)
{
	static const eval_quantity of[] = {EVAL_HORIZONTAL, EVAL_DOWN};
	static const char *const names[] = {"horizontal", "vertical"};
	if (!eval_has_levels(r, EVAL_H) && !eval_has_levels(r, EVAL_V))
		return;
	fputs("<div class=table><table><tr><th>protection "
	      "level<th>epochs<th>nominal<th>MI<th>HMI<th>unavailable<th>unavailable, "
	      "misleading</tr>\n",
	      out);
	for (int i = 0; i < 2; i++) {
		const eval_row *row = &r->whole.row[of[i]];
		fprintf(out, "<tr><td>%s<td>%" PRIu64, names[i], row->with_level);
		for (int k = 0; k < FW_STANFORD_CLASSES; k++)
			fprintf(out, "<td>%" PRIu64, row->stanford[k]);
		fputs("</tr>\n", out);
	}
	fputs("</table></div>\n", out);
}

static void put_sections(const eval_report *report, const eval_result *r, FILE *out)
{
	if (r->n_sections == 0)
		return;
	fputs("<div class=table><table><tr><th>section [s]<th>n<th>available<th>north RMS<th>east "
	      "RMS<th>down RMS<th>horizontal 95 "
	      "%<th>vertical 95 %<th>NEES<th>MI, HMI</tr>\n",
	      out);
	for (size_t k = 0; k < r->n_sections; k++) {
		const eval_figures *f = &r->sections[k];
		const eval_row *row = f->row, *h = &row[EVAL_HORIZONTAL], *v = &row[EVAL_DOWN];
		fprintf(out, "<tr><td>%.9g to %.9g<td>%zu<td>%.2f %%", eval_seconds(report, f->section.begin),
		        eval_seconds(report, f->section.end), row[EVAL_POSITION].errors.n,
		        eval_percent(row[EVAL_POSITION].solved, f->expected));
		if (f->row[EVAL_POSITION].errors.n == 0) {
			fputs("<td><td><td><td><td><td><td></tr>\n", out);
			continue;
		}
		fprintf(out, "<td>%.4f<td>%.4f<td>%.4f<td>%.4f<td>%.4f", row[EVAL_NORTH].errors.rms,
		        row[EVAL_EAST].errors.rms, v->errors.rms, h->errors.p95, v->errors.p95);
		if (row[EVAL_POSITION].with_nees > 0)
			fprintf(out, "<td>%.2f", row[EVAL_POSITION].nees);
		else
			fputs("<td>", out);
		if (h->with_level + v->with_level > 0)
			fprintf(out, "<td>%" PRIu64 "</tr>\n",
			        h->stanford[FW_MISLEADING] + h->stanford[FW_HAZARDOUS] +
			            v->stanford[FW_MISLEADING] + v->stanford[FW_HAZARDOUS]);
		else
			fputs("<td></tr>\n", out);
	}
	fputs("</table></div>\n", out);
}

/* ---- pictures ---- */

static void begin_figure(const char *title, int wide, FILE *out)
{
	fprintf(out, "<figure%s><h3>%s</h3><figcaption>", wide ? " class=wide" : "", title);
}

static void put_ned_keys(FILE *out)
{
	put_key("blue", "", out);
	fputs("north", out);
	put_key("orange", "", out);
	fputs("east", out);
	put_key("green", "", out);
	fputs("down", out);
}

static fw_status put_errors(const eval_report *report, const eval_result *r, eval_quantity first,
                            const char *title, const tool *t, FILE *out)
{
	const eval_row *row = &r->whole.row[first];
	if (row[0].errors.n + row[1].errors.n + row[2].errors.n == 0)
		return FW_OK;
	begin_figure(title, 1, out);
	fputs("solution minus truth", out);
	if (row[0].with_sd + row[1].with_sd + row[2].with_sd > 0) {
		put_key("blue", "band", out);
		fputs("twice the solution&rsquo;s own standard deviation", out);
	}
	fputs("</figcaption>\n", out);
	fw_status status = eval_draw_errors(report, r, first, t, out);
	fputs("</figure>\n", out);
	return status;
}

static fw_status put_levels(const eval_report *report, const eval_result *r, const tool *t, FILE *out)
{
	static const char *const titles[] = {"Stanford diagram, horizontal", "Stanford diagram, vertical"};
	fw_status status = FW_OK;
	if (!eval_has_levels(r, EVAL_H) && !eval_has_levels(r, EVAL_V))
		return FW_OK;
	begin_figure("Protection", 1, out);
	put_key("blue", "", out);
	fputs("size of the error", out);
	put_key("orange", "", out);
	fputs("protection level", out);
	put_key("red", "dash", out);
	fputs("alert limit</figcaption>\n", out);
	status = eval_draw_levels(report, r, t, out);
	fputs("</figure>\n", out);
	for (int which = EVAL_H; which <= EVAL_V && status == FW_OK; which++) {
		if (!eval_has_levels(r, which))
			continue;
		begin_figure(titles[which], 0, out);
		fputs("epochs by error and protection level; the more in a cell, the warmer its "
		      "colour</figcaption>\n",
		      out);
		status = eval_draw_stanford(r, which, t, out);
		fputs("</figure>\n", out);
	}
	return status;
}

static fw_status put_histogram(const eval_result *r, const tool *t, FILE *out)
{
	begin_figure("How often which error", 0, out);
	put_ned_keys(out);
	if (r->whole.row[EVAL_NORTH].with_sd > 0) {
		put_key("ink", "band", out);
		fputs("normal distribution", out);
	}
	fputs("</figcaption>\n", out);
	fw_status status = eval_draw_histogram(r, t, out);
	fputs("</figure>\n", out);
	return status;
}

static fw_status put_sky(const eval_report *report, const tool *t, FILE *out)
{
	static const char *const systems[][2] = {{"blue", "GPS"},    {"orange", "Galileo"},
	                                         {"red", "BeiDou"},  {"green", "GLONASS"},
	                                         {"violet", "QZSS"}, {"teal", "SBAS"}};
	if (report->sky->n == 0)
		return FW_OK;
	begin_figure("Sky", 0, out);
	for (size_t i = 0; i < sizeof systems / sizeof systems[0]; i++) {
		put_key(systems[i][0], "", out);
		fputs(systems[i][1], out);
	}
	fputs("</figcaption>\n", out);
	fw_status status = eval_draw_sky(report, t, out);
	fputs("</figure>\n", out);
	return status;
}

static fw_status put_solution(const eval_report *report, const eval_result *r, int with_sky, const tool *t,
                              FILE *out)
{
	fputs("<h2>", out);
	put_escaped(r->solution->name, out);
	fprintf(out, " <span class=soft>%s</span></h2>\n", fw_record_type_of(r->solution->kind)->name);
	put_cards(r, out);
	put_table(r, out);
	put_integrity(r, out);
	put_sections(report, r, out);
	fputs("<div class=grid>\n", out);
	fw_status status = put_errors(report, r, EVAL_NORTH, "Position error", t, out);
	if (status == FW_OK)
		status = put_levels(report, r, t, out);
	if (status == FW_OK)
		status = put_errors(report, r, EVAL_VN, "Velocity error", t, out);
	if (status == FW_OK)
		status = put_errors(report, r, EVAL_ROLL, "Attitude error", t, out);
	if (status == FW_OK)
		status = put_histogram(r, t, out);
	if (status == FW_OK && with_sky)
		status = put_sky(report, t, out);
	fputs("</div>\n", out);
	return status;
}

/* One colour for each solution. */
static void put_solution_keys(const eval_report *report, FILE *out)
{
	for (int i = 0; i < report->n; i++) {
		if (report->results[i].n == 0)
			continue;
		put_key(key_colour(i), "", out);
		put_escaped(report->results[i].solution->name, out);
	}
}

static fw_status put_overview(const eval_report *report, const tool *t, FILE *out)
{
	fputs("<div class=grid style=\"margin-top:22px\">\n", out);
	begin_figure("Track", 0, out);
	put_key("muted", "", out);
	fputs("truth", out);
	put_solution_keys(report, out);
	fputs("</figcaption>\n", out);
	fw_status status = eval_draw_track(report, t, out);
	fputs("</figure>\n", out);
	if (status != FW_OK)
		return status;
	begin_figure("Share of epochs with at most this error", 0, out);
	fputs("solid: horizontal, dashed: vertical", out);
	put_solution_keys(report, out);
	fputs("</figcaption>\n", out);
	status = eval_draw_shares(report, t, out);
	fputs("</figure>\n", out);
	fputs("</div>\n", out);
	return status;
}

fw_status eval_write_html(const eval_report *report, const char *command, const tool *t, FILE *out)
{
	const eval_series *truth = report->truth->series;
	fputs("<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8><meta name=viewport "
	      "content=\"width=device-width,"
	      "initial-scale=1\"><meta name=color-scheme content=\"light "
	      "dark\"><title>nav-eval</title>\n<style>\n",
	      out);
	fputs(style, out);
	put_colours(out);
	fputs("</style></head><body><main>\n<h1>Solutions against truth</h1>\n<p class=soft>truth: ", out);
	put_escaped(truth->name, out);
	fprintf(out, ", %zu rows every %.9g s</p>\n", truth->n, (double)eval_series_interval(truth) / 1e9);
	fw_status status = put_overview(report, t, out);
	for (int i = 0, first = 1; i < report->n && status == FW_OK; i++) {
		if (report->results[i].n == 0)
			continue;
		status = put_solution(report, &report->results[i], first, t, out);
		first = 0;
	}
	fputs("<footer><code>", out);
	put_escaped(command, out);
	fputs("</code><br>furrow " FURROW_VERSION "</footer></main></body></html>\n", out);
	return status;
}
