#include "eval_stats.h"

#include <math.h>
#include <stdlib.h>

#include "base/frame.h"

/* 95 % quantile of chi-square with three degrees of freedom. */
#define CHI2_3_95 7.814727903251178

/* ---- epochs ---- */

static double positive(double x)
{
	return x > 0 ? x : nan("");
}

static void take_epoch(const eval_fix *fix, const eval_fix *truth, const eval_question *question,
                       eval_epoch *e)
{
	*e = (eval_epoch){.t = fix->t, .solution = fix};
	eval_errors(fix, truth, e->error);
	for (int q = 0; q < EVAL_QUANTITIES; q++)
		e->sd[q] = nan("");
	for (int i = 0; i < 3; i++) {
		e->truth_m[i] = truth->position_m[i];
		e->sd[EVAL_NORTH + i] = positive(fix->sd_position_m[i]);
		e->sd[EVAL_VN + i] = positive(fix->sd_velocity_mps[i]);
		e->sd[EVAL_ROLL + i] = positive(fw_deg_from_rad(fix->sd_rpy_rad[i]));
	}
	for (int i = 0; i < 2; i++) {
		double al = isfinite(fix->al_m[i]) ? fix->al_m[i] : question->al_m[i];
		e->pl_m[i] = fix->pl_m[i];
		e->fom_m[i] = fix->fom_m[i];
		e->al_m[i] = isfinite(al) ? al : (double)INFINITY;
	}
}

static void take_epochs(const eval_truth *truth, const eval_question *question, eval_result *r)
{
	const eval_series *s = r->solution;
	for (size_t i = 0; i < s->n; i++) {
		eval_fix state;
		if (s->fix[i].t.ns < question->window.begin.ns || s->fix[i].t.ns >= question->window.end.ns)
			continue;
		if (eval_truth_at(truth, s->fix[i].t, &state) == FW_OK)
			take_epoch(&s->fix[i], &state, question, &r->epoch[r->n++]);
		else
			r->without_truth++;
	}
}

/* ---- figures ---- */

/* Epochs of one section. */
typedef struct {
	const eval_epoch *epoch;
	size_t n;
	fw_time first; /* of the whole solution: where the grid of expected epochs begins */
	int64_t interval_ns;
} stretch;

/* Errors of one quantity, its summary, and on how many places of the grid it is known. */
static void sum_up(const stretch *s, eval_quantity q, double *scratch, eval_row *row)
{
	int64_t last = INT64_MIN;
	size_t n = 0;
	for (size_t i = 0; i < s->n; i++) {
		double e = s->epoch[i].error[q];
		if (!isfinite(e))
			continue;
		int64_t place = s->epoch[i].t.ns - s->first.ns; /* never negative */
		if (s->interval_ns > 0)
			place = place / s->interval_ns + (place % s->interval_ns > s->interval_ns / 2);
		row->solved += place != last;
		last = place;
		scratch[n++] = e;
	}
	if (fw_summarise(n, scratch, &row->errors) != FW_OK)
		row->errors = (fw_summary){0};
}

static void count_sigmas(const stretch *s, eval_quantity q, eval_row *row)
{
	for (size_t i = 0; i < s->n; i++) {
		double ratio = fabs(s->epoch[i].error[q]) / s->epoch[i].sd[q];
		row->with_sd += isfinite(ratio) ? 1 : 0;
		for (int k = 0; k < 3; k++)
			row->inside[k] += ratio <= k + 1;
	}
}

/* Normalised errors squared of three quantities from `first` on. */
static void count_nees(const stretch *s, int first, eval_row *row)
{
	double sum = 0;
	for (size_t i = 0; i < s->n; i++) {
		double nees = 0;
		for (int k = 0; k < 3; k++) {
			double ratio = s->epoch[i].error[first + k] / s->epoch[i].sd[first + k];
			nees += ratio * ratio;
		}
		if (!isfinite(nees))
			continue;
		sum += nees;
		row->with_nees++;
		row->nees_inside += nees <= CHI2_3_95;
	}
	row->nees = row->with_nees > 0 ? sum / (3 * (double)row->with_nees) : 0;
}

static void count_levels(const stretch *s, eval_quantity q, int which, eval_row *row)
{
	for (size_t i = 0; i < s->n; i++) {
		const eval_epoch *e = &s->epoch[i];
		double error = fabs(e->error[q]);
		if (isfinite(e->pl_m[which])) {
			row->with_level++;
			row->stanford[fw_stanford_class(error, e->pl_m[which], e->al_m[which])]++;
		}
		if (isfinite(e->fom_m[which])) {
			row->with_fom++;
			row->fom_inside += error <= e->fom_m[which];
		}
	}
}

static size_t first_at(const eval_result *r, fw_time t)
{
	size_t begin = 0, end = r->n;
	while (begin < end) {
		size_t middle = begin + (end - begin) / 2;
		if (r->epoch[middle].t.ns < t.ns)
			begin = middle + 1;
		else
			end = middle;
	}
	return begin;
}

static void fill_figures(const eval_result *r, const eval_truth *truth, const eval_section *section,
                         double *scratch, eval_figures *f)
{
	size_t begin = first_at(r, section->begin);
	const stretch s = {&r->epoch[begin], first_at(r, section->end) - begin, r->epoch[0].t,
	                   r->interval_ns};

	*f = (eval_figures){.section = *section};
	f->expected = eval_truth_expected(truth, s.first, s.interval_ns, section->begin, section->end);
	for (int q = 0; q < EVAL_QUANTITIES; q++) {
		sum_up(&s, (eval_quantity)q, scratch, &f->row[q]);
		count_sigmas(&s, (eval_quantity)q, &f->row[q]);
	}
	count_nees(&s, EVAL_NORTH, &f->row[EVAL_POSITION]);
	count_nees(&s, EVAL_VN, &f->row[EVAL_VELOCITY]);
	count_nees(&s, EVAL_ROLL, &f->row[EVAL_ATTITUDE]);
	count_levels(&s, EVAL_HORIZONTAL, EVAL_H, &f->row[EVAL_HORIZONTAL]);
	count_levels(&s, EVAL_DOWN, EVAL_V, &f->row[EVAL_DOWN]);
}

fw_status eval_compare(const eval_series *solution, const eval_truth *truth, const eval_question *question,
                       eval_result *r)
{
	*r = (eval_result){.solution = solution, .n_sections = question->n_sections};
	r->interval_ns = question->interval_ns > 0 ? question->interval_ns : eval_series_interval(solution);
	if (solution->n == 0)
		return FW_ERANGE;
	r->epoch = calloc(solution->n, sizeof r->epoch[0]);
	r->sections = calloc(question->n_sections + 1, sizeof r->sections[0]);
	double *scratch = calloc(solution->n, sizeof scratch[0]);
	fw_status status = FW_ENOMEM;
	if (r->epoch != NULL && r->sections != NULL && scratch != NULL) {
		take_epochs(truth, question, r);
		status = r->n > 0 ? FW_OK : FW_ERANGE;
	}
	if (status == FW_OK) {
		fill_figures(r, truth, &question->window, scratch, &r->whole);
		for (size_t i = 0; i < r->n_sections; i++)
			fill_figures(r, truth, &question->sections[i], scratch, &r->sections[i]);
	}
	free(scratch);
	return status;
}

void eval_result_release(eval_result *r)
{
	free(r->epoch);
	free(r->sections);
	*r = (eval_result){0};
}
