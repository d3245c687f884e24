#include "eval_series.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/frame.h"
#include "formats/sbf_decoder.h"

/* Stamps no further apart than this are the same: a stamp may have been through text. */
#define SAME_NS 1000

const fw_kind eval_kinds[] = {FW_nav, FW_pos, FW_ins, FW_pvt, FW_RECORD_COUNT};

/* Types that have no position but belong to a fix, those first whose word counts most. */
static const fw_kind companions[] = {FW_pl, FW_att, FW_dop, FW_RECORD_COUNT};

/* ---- records to fixes ---- */

enum { AS_IT_IS, DEGREES, VARIANCE };

/* Columns by name, whatever record they are in. */
static const struct {
	const char *column;
	size_t member;
	int unit;
} fields[] = {
    {"lat_deg", offsetof(eval_fix, lat_rad), DEGREES},
    {"lon_deg", offsetof(eval_fix, lon_rad), DEGREES},
    {"height_m", offsetof(eval_fix, height_m), AS_IT_IS},
    {"vn_mps", offsetof(eval_fix, velocity_mps[0]), AS_IT_IS},
    {"ve_mps", offsetof(eval_fix, velocity_mps[1]), AS_IT_IS},
    {"vd_mps", offsetof(eval_fix, velocity_mps[2]), AS_IT_IS},
    {"roll_deg", offsetof(eval_fix, rpy_rad[0]), DEGREES},
    {"pitch_deg", offsetof(eval_fix, rpy_rad[1]), DEGREES},
    {"heading_deg", offsetof(eval_fix, rpy_rad[2]), DEGREES},
    {"sd_n_m", offsetof(eval_fix, sd_position_m[0]), AS_IT_IS},
    {"sd_e_m", offsetof(eval_fix, sd_position_m[1]), AS_IT_IS},
    {"sd_d_m", offsetof(eval_fix, sd_position_m[2]), AS_IT_IS},
    {"sd_vn_mps", offsetof(eval_fix, sd_velocity_mps[0]), AS_IT_IS},
    {"sd_ve_mps", offsetof(eval_fix, sd_velocity_mps[1]), AS_IT_IS},
    {"sd_vd_mps", offsetof(eval_fix, sd_velocity_mps[2]), AS_IT_IS},
    {"cov_vnvn_m2ps2", offsetof(eval_fix, sd_velocity_mps[0]), VARIANCE},
    {"cov_veve_m2ps2", offsetof(eval_fix, sd_velocity_mps[1]), VARIANCE},
    {"cov_vdvd_m2ps2", offsetof(eval_fix, sd_velocity_mps[2]), VARIANCE},
    {"sd_roll_deg", offsetof(eval_fix, sd_rpy_rad[0]), DEGREES},
    {"sd_pitch_deg", offsetof(eval_fix, sd_rpy_rad[1]), DEGREES},
    {"sd_heading_deg", offsetof(eval_fix, sd_rpy_rad[2]), DEGREES},
    {"hpl_m", offsetof(eval_fix, pl_m[EVAL_H]), AS_IT_IS},
    {"vpl_m", offsetof(eval_fix, pl_m[EVAL_V]), AS_IT_IS},
    {"hal_m", offsetof(eval_fix, al_m[EVAL_H]), AS_IT_IS},
    {"val_m", offsetof(eval_fix, al_m[EVAL_V]), AS_IT_IS},
    {"hfom_m", offsetof(eval_fix, fom_m[EVAL_H]), AS_IT_IS},
    {"vfom_m", offsetof(eval_fix, fom_m[EVAL_V]), AS_IT_IS},
    {"h_accuracy_m", offsetof(eval_fix, fom_m[EVAL_H]), AS_IT_IS},
    {"v_accuracy_m", offsetof(eval_fix, fom_m[EVAL_V]), AS_IT_IS},
};
enum { N_FIELDS = sizeof fields / sizeof fields[0] };

static double *member(eval_fix *fix, int field)
{
	return (double *)(void *)((char *)fix + fields[field].member);
}

eval_fix eval_fix_empty(fw_time t, fw_kind kind)
{
	const double none = nan("");
	eval_fix fix = {.t = t, .kind = kind, .position_m = {none, none, none}};
	for (int i = 0; i < N_FIELDS; i++)
		*member(&fix, i) = none;
	return fix;
}

/* The value of a column, NaN if it has none. Only the columns that `fields` names are asked for: all are numbers. */
static double value_of(const fw_record_type *type, const void *record, int column)
{
	const char *at = (const char *)record + type->columns[column].offset;
	int64_t present = ((const fw_record_head *)record)->present;
	double x = nan("");
	float single;
	if (!(present >> column & 1))
		return x;
	if (type->columns[column].type == FW_F64) {
		memcpy(&x, at, sizeof x);
	} else if (type->columns[column].type == FW_F32) {
		memcpy(&single, at, sizeof single);
		x = (double)single;
	}
	return x;
}

/* Where a record type has the columns of `fields`; -1: it has not. */
typedef struct {
	int column[N_FIELDS];
} layout;

static void find_columns(fw_kind kind, layout *at)
{
	const fw_record_type *type = fw_record_type_of(kind);
	for (int i = 0; i < N_FIELDS; i++)
		at->column[i] = fw_record_column(type, fields[i].column, strlen(fields[i].column));
}

static eval_fix fix_from_record(fw_time t, fw_kind kind, const layout *at, const void *record)
{
	const fw_record_type *type = fw_record_type_of(kind);
	eval_fix fix = eval_fix_empty(t, kind);
	for (int i = 0; i < N_FIELDS; i++) {
		if (at->column[i] < 0)
			continue;
		double x = value_of(type, record, at->column[i]);
		if (isnan(x))
			continue;
		*member(&fix, i) = fields[i].unit == DEGREES    ? fw_rad_from_deg(x)
		                   : fields[i].unit == VARIANCE ? sqrt(x)
		                                                : x;
	}
	return fix;
}

/* ---- a series grows ---- */

/* Room for one more: returns 0 when there is no memory. */
static int grow(void **array, size_t n, size_t *room, size_t size)
{
	if (n < *room)
		return 1;
	size_t more = *room > 0 ? 2 * *room : 1024;
	void *larger = more <= SIZE_MAX / size ? realloc(*array, more * size) : NULL;
	if (larger == NULL)
		return 0;
	*array = larger;
	*room = more;
	return 1;
}

static int is_companion(fw_kind kind)
{
	for (int i = 0; companions[i] != FW_RECORD_COUNT; i++)
		if (companions[i] == kind)
			return 1;
	return 0;
}

static int is_trajectory(fw_kind kind)
{
	for (int i = 0; eval_kinds[i] != FW_RECORD_COUNT; i++)
		if (eval_kinds[i] == kind)
			return 1;
	return 0;
}

/* Deeper or higher than this is no place where furrow's users go [m]. */
static const double LOWEST_M = -1e5, HIGHEST_M = 1e8;

fw_status eval_series_add(eval_series *s, const eval_fix *fix, size_t max)
{
	eval_fix kept = *fix;
	const double llh[3] = {fix->lat_rad, fix->lon_rad, fix->height_m};
	bool has_position = isfinite(llh[0]) && isfinite(llh[1]) && isfinite(llh[2]);
	if (!has_position && !is_companion(fix->kind)) {
		s->no_position++;
		return FW_OK;
	}
	if (has_position && (!(llh[2] > LOWEST_M && llh[2] < HIGHEST_M) || !(fabs(llh[1]) < 4 * FW_PI) ||
	                     fw_llh_to_ecef(llh, kept.position_m) != FW_OK)) {
		s->misplaced++;
		return FW_ERANGE;
	}
	if (s->n >= max) {
		s->too_many++;
		return FW_OK;
	}
	void *array = s->fix;
	if (!grow(&array, s->n, &s->room, sizeof s->fix[0])) {
		s->no_memory = 1;
		return FW_ENOMEM;
	}
	s->fix = array;
	s->fix[s->n++] = kept;
	return FW_OK;
}

/* ---- order ---- */

/* Nav before pos before pvt; a companion after them. */
static int rank(fw_kind kind)
{
	int i = 0;
	for (int k = 0; eval_kinds[k] != FW_RECORD_COUNT; k++, i++)
		if (eval_kinds[k] == kind)
			return i;
	for (int k = 0; companions[k] != FW_RECORD_COUNT; k++, i++)
		if (companions[k] == kind)
			return i;
	return i;
}

static int by_time(const void *a, const void *b)
{
	const eval_fix *x = a, *y = b;
	int order = fw_time_compare(x->t, y->t);
	return order != 0 ? order : rank(x->kind) - rank(y->kind);
}

static int in_order(const eval_series *s)
{
	for (size_t i = 1; i < s->n; i++)
		if (by_time(&s->fix[i - 1], &s->fix[i]) > 0)
			return 0;
	return 1;
}

static fw_kind best_kind(const eval_series *s)
{
	fw_kind_set there = {0};
	for (size_t i = 0; i < s->n; i++)
		fw_kind_add(&there, s->fix[i].kind);
	for (int k = 0; eval_kinds[k] != FW_RECORD_COUNT; k++)
		if (fw_kind_in(&there, eval_kinds[k]))
			return eval_kinds[k];
	return FW_RECORD_COUNT;
}

/* Fills what the fix lacks; protection levels of pl come before its own. */
static void merge(eval_fix *fix, const eval_fix *companion)
{
	for (int i = 0; i < N_FIELDS; i++) {
		double *mine = member(fix, i);
		double theirs;
		memcpy(&theirs, (const char *)companion + fields[i].member, sizeof theirs);
		if (isnan(*mine) || (companion->kind == FW_pl && !isnan(theirs)))
			*mine = theirs;
	}
}

void eval_series_settle(eval_series *s, fw_kind wanted)
{
	size_t kept = 0;
	s->kind = wanted != FW_RECORD_COUNT ? wanted : best_kind(s);
	if (!in_order(s))
		qsort(s->fix, s->n, sizeof s->fix[0], by_time);
	for (size_t i = 0, end; i < s->n; i = end) {
		eval_fix *found = NULL;
		for (end = i; end < s->n && s->fix[end].t.ns - s->fix[i].t.ns <= SAME_NS; end++) {
			if (s->fix[end].kind != s->kind)
				continue;
			s->repeated += found != NULL;
			found = found == NULL ? &s->fix[end] : found;
		}
		if (found == NULL)
			continue;
		for (size_t j = i; j < end; j++)
			if (is_companion(s->fix[j].kind) && &s->fix[j] != found)
				merge(found, &s->fix[j]);
		s->fix[kept++] = *found;
	}
	s->n = kept;
}

/* ---- reading ---- */

typedef struct {
	eval_series *series;
	const eval_plan *plan;
	layout layouts[FW_RECORD_COUNT]; /* of the types that become fixes */
} reading;

static void take(void *context, fw_kind kind, const void *record)
{
	const reading *r = context;
	fw_time t;
	if (fw_kind_in(&r->plan->others, kind))
		r->plan->other.put(r->plan->other.context, kind, record);
	if ((!is_companion(kind) && !is_trajectory(kind)) || fw_record_time(record, &t) != FW_OK)
		return;
	if ((r->plan->from != NULL && t.ns < r->plan->from->ns) ||
	    (r->plan->until != NULL && t.ns >= r->plan->until->ns))
		return;
	eval_fix fix = fix_from_record(t, kind, &r->layouts[kind], record);
	(void)!eval_series_add(r->series, &fix, r->plan->max);
}

/* What a user may want to know about rows that were not used. Returns whether any is a loss. */
static int explain(const eval_series *s, tool *t, const eval_plan *plan)
{
	if (s->no_position > 0)
		tool_note(t, "%s: %" PRIu64 " rows without a position", s->name, s->no_position);
	if (s->misplaced > 0)
		tool_note(t, "%s: %" PRIu64 " rows whose position is no place near the Earth left out",
		          s->name, s->misplaced);
	if (s->repeated > 0)
		tool_note(t, "%s: %" PRIu64 " rows with the stamp of another left out", s->name, s->repeated);
	if (s->too_many > 0)
		tool_error(t, "%s: %" PRIu64 " rows beyond the first %zu left out (--max-rows)", s->name,
		           s->too_many, plan->max);
	return s->too_many + s->repeated + s->misplaced > 0;
}

int eval_series_read(eval_series *s, tool *t, const char *path, const eval_plan *plan, source_totals *totals)
{
	reading r = {.series = s, .plan = plan};
	source_plan source = {.table = FW_RECORD_COUNT,
	                      .antennas = FW_ANTENNA_MAIN,
	                      .nav_sources = FW_NAV_RAW | FW_NAV_DECODED,
	                      .progress = plan->progress};

	*s = (eval_series){.name = strcmp(path, "-") == 0 ? "standard input" : path};
	if (plan->kind != FW_RECORD_COUNT)
		fw_kind_add(&source.wanted, plan->kind);
	for (int k = 0; plan->kind == FW_RECORD_COUNT && eval_kinds[k] != FW_RECORD_COUNT; k++)
		fw_kind_add(&source.wanted, eval_kinds[k]);
	for (int k = 0; companions[k] != FW_RECORD_COUNT; k++)
		fw_kind_add(&source.wanted, companions[k]);
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++)
		if (fw_kind_in(&source.wanted, kind))
			find_columns(kind, &r.layouts[kind]);
	for (size_t i = 0; i < sizeof source.wanted.bits / sizeof source.wanted.bits[0]; i++)
		source.wanted.bits[i] |= plan->others.bits[i];

	int status = source_read(t, path, &source, (fw_sink){take, &r}, totals);
	if (s->no_memory) {
		tool_error(t, "%s: out of memory after %zu rows (--max-rows sets a limit)", s->name, s->n);
		return EXIT_IO;
	}
	eval_series_settle(s, plan->kind);
	return explain(s, t, plan) && status == EXIT_COMPLETE ? EXIT_PARTIAL : status;
}

/* Levels and limits alone: what else the other series knows of that time is not this one's. */
static void take_levels(eval_fix *fix, const eval_fix *from)
{
	for (int k = 0; k < 2; k++) {
		fix->pl_m[k] = isnan(from->pl_m[k]) ? fix->pl_m[k] : from->pl_m[k];
		fix->al_m[k] = isnan(from->al_m[k]) ? fix->al_m[k] : from->al_m[k];
	}
}

void eval_series_add_levels(eval_series *s, const eval_series *levels)
{
	size_t i = 0;
	for (size_t j = 0; j < levels->n; j++) {
		while (i < s->n && s->fix[i].t.ns < levels->fix[j].t.ns - SAME_NS)
			i++;
		if (i < s->n && s->fix[i].t.ns <= levels->fix[j].t.ns + SAME_NS)
			take_levels(&s->fix[i], &levels->fix[j]);
	}
}

size_t eval_series_at(const eval_series *s, fw_time t)
{
	size_t begin = 0, end = s->n;
	while (begin < end) {
		size_t middle = begin + (end - begin) / 2;
		if (s->fix[middle].t.ns < t.ns)
			begin = middle + 1;
		else
			end = middle;
	}
	return begin;
}

static int shorter(const void *a, const void *b)
{
	int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
	return (x > y) - (x < y);
}

int64_t eval_series_interval(const eval_series *s)
{
	if (s->n < 2)
		return 0;
	int64_t *gap = malloc((s->n - 1) * sizeof gap[0]);
	if (gap == NULL)
		return 0;
	for (size_t i = 1; i < s->n; i++)
		gap[i - 1] = s->fix[i].t.ns - s->fix[i - 1].t.ns;
	qsort(gap, s->n - 1, sizeof gap[0], shorter);
	int64_t median = gap[(s->n - 1) / 2];
	free(gap);
	return median < FW_NS_PER_WEEK ? median : FW_NS_PER_WEEK;
}

void eval_series_release(eval_series *s)
{
	free(s->fix);
	*s = (eval_series){0};
}
