#include "fuse_smooth.h"

#include <math.h>
#include <string.h>

/* A node as it is kept: this, then x predicted and filtered (n each), the covariances' triangles, and the transition (n x n). */
typedef struct {
	fw_time time;
	fw_pva predicted, filtered;
	double numbers[];
} kept_node;

/* A moment as it is kept: its spread comes from the nodes. */
typedef struct {
	fw_pva pva;
	float hpl_m, vpl_m;
} kept_moment;

/* What was found out about a node. */
typedef struct {
	fw_time time;
	double spread[FUSE_SPREAD];
	double errors[]; /* error and ahead, n each */
} result;

static size_t node_size(int n)
{
	return sizeof(kept_node) + sizeof(double) * (size_t)(2 * n + n * (n + 1) + n * n);
}

/* ---- packing ---- */

static double *pack_triangle(int n, const double A[FW_STATES_MAX][FW_STATES_MAX], double *to)
{
	for (int i = 0; i < n; i++)
		for (int j = 0; j <= i; j++)
			*to++ = A[i][j];
	return to;
}

static const double *unpack_triangle(int n, const double *from, double A[FW_STATES_MAX][FW_STATES_MAX])
{
	for (int i = 0; i < n; i++)
		for (int j = 0; j <= i; j++)
			A[i][j] = A[j][i] = *from++;
	return from;
}

static void pack(int n, const fw_node *node, kept_node *k)
{
	const size_t row = sizeof(double) * (size_t)n;
	double *to = k->numbers;
	k->time = node->time;
	k->predicted = node->predicted;
	k->filtered = node->filtered;
	memcpy(to, node->x_predicted, row);
	memcpy(to + n, node->x_filtered, row);
	to = pack_triangle(n, node->P_predicted, to + 2 * n);
	to = pack_triangle(n, node->P_filtered, to);
	for (int i = 0; i < n; i++, to += n)
		memcpy(to, node->transition[i], row);
}

static void unpack(int n, const kept_node *k, fw_node *node)
{
	const size_t row = sizeof(double) * (size_t)n;
	const double *from = k->numbers;
	node->time = k->time;
	node->predicted = k->predicted;
	node->filtered = k->filtered;
	memcpy(node->x_predicted, from, row);
	memcpy(node->x_filtered, from + n, row);
	from = unpack_triangle(n, from + 2 * n, node->P_predicted);
	from = unpack_triangle(n, from, node->P_filtered);
	for (int i = 0; i < n; i++, from += n)
		memcpy(node->transition[i], from, row);
}

/* ---- keeping ---- */

void fuse_smooth_begin(fuse_smooth *s, uint64_t memory)
{
	memset(s, 0, sizeof *s);
	fuse_budget_begin(&s->budget, memory);
	fuse_store_begin(&s->moments, &s->budget, sizeof(kept_moment));
}

void fuse_smooth_node(fuse_smooth *s, const fw_layout *layout, const fw_node *node)
{
	if (s->nodes.budget == NULL) { /* the first one says how large they are */
		s->layout = *layout;
		fuse_store_begin(&s->nodes, &s->budget, node_size(layout->n));
		fuse_store_begin(&s->results, &s->budget,
		                 sizeof(result) + sizeof(double) * 2 * (size_t)layout->n);
	}
	kept_node *k = fuse_store_add(&s->nodes);
	if (k != NULL)
		pack(s->layout.n, node, k);
}

void fuse_smooth_moment(fuse_smooth *s, const fuse_moment *m)
{
	kept_moment *kept = fuse_store_add(&s->moments);
	if (kept != NULL)
		*kept = (kept_moment){m->pva, m->hpl_m, m->vpl_m};
}

/* ---- backwards over the nodes ---- */

static bool load(fuse_smooth *s, uint64_t i, fw_node *node)
{
	const kept_node *k = fuse_store_at(&s->nodes, i);
	if (k != NULL)
		unpack(s->layout.n, k, node);
	return k != NULL;
}

static bool keep_result(fuse_smooth *s, const fw_node *node, const fw_smoothed *found)
{
	const size_t row = sizeof(double) * (size_t)s->layout.n;
	result *r = fuse_store_add(&s->results);
	if (r == NULL)
		return false;
	r->time = node->time;
	fuse_spread_of(found->P, r->spread);
	memcpy(r->errors, found->error, row);
	memcpy(r->errors + s->layout.n, found->ahead, row);
	return true;
}

/* Results come in the order in which they are found: the last node's first. */
static bool go_back(fuse_smooth *s)
{
	unsigned now = 0;
	const uint64_t n = s->nodes.n;
	if (!load(s, n - 1, &s->node[now]))
		return false;
	fw_rts_last(&s->layout, &s->node[now], &s->smoothed[now]);
	if (!keep_result(s, &s->node[now], &s->smoothed[now]))
		return false;
	for (uint64_t i = n - 1; i-- > 0; now = 1 - now) {
		const unsigned earlier = 1 - now;
		if (!load(s, i, &s->node[earlier]))
			return false;
		s->singular += fw_rts_step(&s->layout, &s->node[earlier], &s->node[now], &s->smoothed[now],
		                           &s->smoothed[earlier]) != FW_OK;
		if (!keep_result(s, &s->node[earlier], &s->smoothed[earlier]))
			return false;
	}
	return true;
}

/* ---- forwards over the moments ---- */

/* Two neighbouring results, copied: the lists show one at a time. */
typedef struct {
	uint64_t before; /* number of the node before the moment */
	fw_time time[2];
	double error[FW_STATES_MAX], ahead[FW_STATES_MAX]; /* of the one before, and of the one after */
	double spread[2][FUSE_SPREAD];
} between;

/* Looks at nodes i and i + 1; after the last one there is none, and it stands for both. */
static bool look_between(fuse_smooth *s, uint64_t i, between *b)
{
	const size_t row = sizeof(double) * (size_t)s->layout.n;
	for (unsigned k = 0; k < 2; k++) {
		const uint64_t number = i + k < s->nodes.n ? i + k : s->nodes.n - 1;
		const result *r = fuse_store_at(&s->results, s->nodes.n - 1 - number);
		if (r == NULL)
			return false;
		b->time[k] = r->time;
		memcpy(b->spread[k], r->spread, sizeof r->spread);
		if (k == 0)
			memcpy(b->error, r->errors, row);
		else
			memcpy(b->ahead, r->errors + s->layout.n, row);
		if (k == 1 && number == i)
			memcpy(b->ahead, b->error, row);
	}
	b->before = i;
	return true;
}

static void correct(const fuse_smooth *s, const between *b, fuse_moment *m)
{
	const double length = fw_time_diff_s(b->time[1], b->time[0]),
	             since = fw_time_diff_s(m->pva.time, b->time[0]);
	const double w = length > 0 ? fmin(fmax(since / length, 0), 1) : 0;
	double error[FW_STATES_MAX], x[FW_STATES_MAX] = {0};
	for (int i = 0; i < s->layout.n; i++)
		error[i] = (1 - w) * b->error[i] + w * b->ahead[i];
	for (int i = 0; i < FUSE_SPREAD; i++)
		m->spread[i] = (1 - w) * b->spread[0][i] + w * b->spread[1][i];
	fw_estimate_add(&s->layout, error, &m->pva, x);
	m->status = FUSE_SMOOTHED;
}

static uint64_t go_forward(fuse_smooth *s, const fuse_output *to)
{
	between b;
	uint64_t bad = 0;
	if (!look_between(s, 0, &b))
		return 0;
	for (uint64_t i = 0; i < s->moments.n; i++) {
		const kept_moment *kept = fuse_store_at(&s->moments, i);
		if (kept == NULL)
			return bad;
		fuse_moment m = {.pva = kept->pva, .hpl_m = kept->hpl_m, .vpl_m = kept->vpl_m};
		while (b.before + 1 < s->nodes.n && b.time[1].ns <= m.pva.time.ns)
			if (!look_between(s, b.before + 1, &b))
				return bad;
		correct(s, &b, &m);
		bad += !fuse_output_put(to, &m);
	}
	return bad;
}

uint64_t fuse_smooth_run(fuse_smooth *s, const fuse_output *to)
{
	uint64_t bad = 0;
	if (s->nodes.n > 0 && s->budget.error == 0 && go_back(s))
		bad = go_forward(s, to);
	if (s->nodes.budget != NULL) {
		fuse_store_end(&s->nodes);
		fuse_store_end(&s->results);
	}
	fuse_store_end(&s->moments);
	return bad;
}

void fuse_smooth_end(fuse_smooth *s)
{
	if (s->nodes.budget != NULL) {
		fuse_store_end(&s->nodes);
		fuse_store_end(&s->results);
	}
	fuse_store_end(&s->moments);
	fuse_budget_end(&s->budget);
}
