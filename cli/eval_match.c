#include "eval_match.h"

#include <math.h>
#include <stdlib.h>

#include "base/frame.h"
#include "base/interpolate.h"
#include "base/matrix.h"
#include "base/summary.h"

/* A stamp that misses a row by no more than this is the row's: it may have been through text. */
#define SAME_NS 1000

const char *const eval_quantity_names[EVAL_QUANTITIES] = {
    "north_m", "east_m",       "down_m",   "horizontal_m", "position_m",  "vn_mps",       "ve_mps",
    "vd_mps",  "velocity_mps", "roll_deg", "pitch_deg",    "heading_deg", "attitude_deg",
};

/* ---- the truth at a moment ---- */

/* Rows around a moment, none of them beyond a gap. */
typedef struct {
	const eval_fix *row; /* the first */
	int n;               /* 1..4 */
	int before;          /* the row before the moment, or at it */
	double t[4];         /* times of the rows since the one before [s] */
	double at;           /* the moment, likewise */
} neighbours;

static bool joined(const eval_truth *truth, const eval_fix *a, const eval_fix *b)
{
	return b->t.ns - a->t.ns <= truth->gap_ns;
}

static fw_status find_neighbours(const eval_truth *truth, fw_time t, neighbours *near)
{
	const eval_series *s = truth->series;
	size_t after = eval_series_at(s, fw_time_add_ns(t, -SAME_NS));
	if (after == s->n)
		return FW_ERANGE;
	size_t first = after;
	bool on_row = s->fix[after].t.ns - t.ns <= SAME_NS;
	if (!on_row && (after == 0 || !joined(truth, &s->fix[after - 1], &s->fix[after])))
		return FW_ERANGE;
	if (!on_row)
		first--;
	size_t before = first, last = after;
	if (on_row && last + 1 < s->n && joined(truth, &s->fix[last], &s->fix[last + 1]))
		last++;
	if (first > 0 && joined(truth, &s->fix[first - 1], &s->fix[first]))
		first--;
	if (last + 1 < s->n && joined(truth, &s->fix[last], &s->fix[last + 1]))
		last++;
	*near = (neighbours){
	    .row = &s->fix[first], .n = (int)(last - first) + 1, .before = (int)(before - first)};
	if (near->before == near->n - 1 && near->n > 1)
		near->before--; /* the last row before a gap: still between two */
	const fw_time origin = near->row[near->before].t;
	for (int i = 0; i < near->n; i++)
		near->t[i] = fw_time_diff_s(near->row[i].t, origin);
	near->at = fw_time_diff_s(t, origin);
	return FW_OK;
}

static void velocity_in_ecef(const eval_fix *fix, double v_e[static 3])
{
	double C_e_n[3][3];
	fw_frame_ned(fix->lat_rad, fix->lon_rad, C_e_n);
	fw_mat3_vec(C_e_n, fix->velocity_mps, v_e);
}

static bool is_known(const double x[static 3])
{
	return isfinite(x[0]) && isfinite(x[1]) && isfinite(x[2]);
}

/* Through all neighbours that have a velocity; the two on both sides must. */
static void polynomial_velocity(const neighbours *near, double v_e[static 3])
{
	double t[4], v[4][3];
	int n = 0;
	v_e[0] = v_e[1] = v_e[2] = nan("");
	for (int i = 0; i < near->n; i++) {
		if (is_known(near->row[i].velocity_mps)) {
			velocity_in_ecef(&near->row[i], v[n]);
			t[n++] = near->t[i];
		} else if (i == near->before || i == near->before + 1) {
			return;
		}
	}
	(void)!fw_lagrange(n, 3, t, v[0], near->at, v_e);
}

/* Differences to the row before keep all digits. */
static fw_status position(const neighbours *near, double p_e[static 3])
{
	const eval_fix *a = &near->row[near->before], *b = a + 1;
	double p[4][3], v0[3], v1[3];
	fw_status status = FW_OK;
	for (int i = 0; i < near->n; i++)
		for (int j = 0; j < 3; j++)
			p[i][j] = near->row[i].position_m[j] - a->position_m[j];
	if (near->n > 1 && is_known(a->velocity_mps) && is_known(b->velocity_mps)) {
		double h = near->t[near->before + 1];
		velocity_in_ecef(a, v0);
		velocity_in_ecef(b, v1);
		fw_hermite(3, h, near->at / h, p[near->before], v0, p[near->before + 1], v1, p_e);
	} else {
		status = fw_lagrange(near->n, 3, near->t, p[0], near->at, p_e);
	}
	for (int j = 0; j < 3; j++)
		p_e[j] += a->position_m[j];
	return status;
}

/* What is not known of an attitude counts as level or north while turning, and stays unknown. */
static void quaternion(const eval_fix *fix, double q[static 4])
{
	double rpy[3];
	for (int i = 0; i < 3; i++)
		rpy[i] = isfinite(fix->rpy_rad[i]) ? fix->rpy_rad[i] : 0;
	fw_euler_to_quat(rpy, q);
}

/* Attitude, and the angular rate against the local frame, body axes. */
static void attitude(const neighbours *near, double rpy[static 3], double rate_radps[static 3])
{
	const eval_fix *a = &near->row[near->before], *b = near->n > 1 ? a + 1 : a;
	double h = near->n > 1 ? near->t[near->before + 1] : 1;
	double q0[4], q1[4], q[4];
	quaternion(a, q0);
	quaternion(b, q1);
	fw_slerp(q0, q1, near->at / h, q);
	fw_quat_to_euler(q, rpy);
	fw_quat_between(q0, q1, rate_radps);
	for (int i = 0; i < 3; i++) {
		rate_radps[i] /= h;
		if (!isfinite(a->rpy_rad[i]) || !isfinite(b->rpy_rad[i]))
			rpy[i] = nan("");
	}
}

/* Position and velocity of another point of the body. */
static fw_status move(const eval_truth *truth, const eval_fix *state, const double rate_radps[static 3],
                      double p_e[static 3], double v_e[static 3])
{
	const double *l = truth->lever_arm_m, *w = rate_radps;
	const double turning[3] = {w[1] * l[2] - w[2] * l[1], w[2] * l[0] - w[0] * l[2],
	                           w[0] * l[1] - w[1] * l[0]};
	double C_e_n[3][3], C_n_b[3][3], C_e_b[3][3], arm_e[3], turning_e[3];
	if (!is_known(state->rpy_rad))
		return FW_ERANGE;
	fw_frame_ned(state->lat_rad, state->lon_rad, C_e_n);
	fw_euler_to_matrix(state->rpy_rad, C_n_b);
	fw_mat3_mul(C_e_n, C_n_b, C_e_b);
	fw_mat3_vec(C_e_b, l, arm_e);
	fw_mat3_vec(C_e_b, turning, turning_e);
	for (int i = 0; i < 3; i++) {
		p_e[i] += arm_e[i];
		v_e[i] += turning_e[i];
	}
	return FW_OK;
}

static fw_status place(eval_fix *state, const double p_e[static 3])
{
	double llh[3];
	fw_status status = fw_ecef_to_llh(p_e, llh);
	if (status != FW_OK)
		return status;
	state->lat_rad = llh[0];
	state->lon_rad = llh[1];
	state->height_m = llh[2];
	for (int i = 0; i < 3; i++)
		state->position_m[i] = p_e[i];
	return FW_OK;
}

fw_status eval_truth_at(const eval_truth *truth, fw_time t, eval_fix *state)
{
	neighbours near;
	double p_e[3], v_e[3], rate_radps[3], C_e_n[3][3];
	eval_fix at = eval_fix_empty(t, truth->series->kind);

	if (find_neighbours(truth, t, &near) != FW_OK || position(&near, p_e) != FW_OK ||
	    place(&at, p_e) != FW_OK)
		return FW_ERANGE;
	polynomial_velocity(&near, v_e);
	attitude(&near, at.rpy_rad, rate_radps);
	if (truth->moved && (move(truth, &at, rate_radps, p_e, v_e) != FW_OK || place(&at, p_e) != FW_OK))
		return FW_ERANGE;
	fw_frame_ned(at.lat_rad, at.lon_rad, C_e_n);
	fw_mat3_t_vec(C_e_n, v_e, at.velocity_mps);
	*state = at;
	return FW_OK;
}

/* ---- about the truth ---- */

/* Whole numbers k with begin <= first + k interval < end. */
static uint64_t grid_points(int64_t first, int64_t interval, int64_t begin, int64_t end)
{
	if (end <= begin)
		return 0;
	int64_t from = begin - first, to = end - first; /* ceil(to / interval) - ceil(from / interval) */
	int64_t low = from / interval + (from % interval > 0), high = to / interval + (to % interval > 0);
	return (uint64_t)(high - low);
}

uint64_t eval_truth_expected(const eval_truth *truth, fw_time first, int64_t interval_ns, fw_time begin,
                             fw_time end)
{
	const eval_series *s = truth->series;
	uint64_t n = 0;
	if (interval_ns <= 0)
		return 0;
	for (size_t i = 0, last; i < s->n; i = last + 1) {
		for (last = i; last + 1 < s->n && joined(truth, &s->fix[last], &s->fix[last + 1]);)
			last++;
		int64_t from = s->fix[i].t.ns - SAME_NS, to = s->fix[last].t.ns + SAME_NS + 1;
		n += grid_points(first.ns, interval_ns, from > begin.ns ? from : begin.ns,
		                 to < end.ns ? to : end.ns);
	}
	return n;
}

size_t eval_truth_gaps(const eval_truth *truth, double *longest_s)
{
	const eval_series *s = truth->series;
	size_t n = 0;
	*longest_s = 0;
	for (size_t i = 1; i < s->n; i++) {
		if (joined(truth, &s->fix[i - 1], &s->fix[i]))
			continue;
		n++;
		*longest_s = fmax(*longest_s, fw_time_diff_s(s->fix[i].t, s->fix[i - 1].t));
	}
	return n;
}

/* Row i against the rows around it. Returns 0 when there are none, or not as far apart as it takes. */
static bool leave_out(const eval_series *s, size_t i, double *distance_m)
{
	eval_fix around[4];
	neighbours near = {.row = around, .n = 4, .before = 1};
	double p[3], sum = 0;
	const int64_t step = s->fix[i + 1].t.ns - s->fix[i].t.ns;
	for (int k = 0; k < 4; k++) {
		around[k] = s->fix[i + 2 * (size_t)k - 3];
		if (llabs(around[k].t.ns - s->fix[i].t.ns - (2 * k - 3) * step) > SAME_NS)
			return false;
		near.t[k] = fw_time_diff_s(around[k].t, s->fix[i - 1].t);
	}
	near.at = fw_time_diff_s(s->fix[i].t, s->fix[i - 1].t);
	if (position(&near, p) != FW_OK)
		return false;
	for (int j = 0; j < 3; j++)
		sum += (p[j] - s->fix[i].position_m[j]) * (p[j] - s->fix[i].position_m[j]);
	*distance_m = sqrt(sum);
	return true;
}

double eval_truth_interpolation(const eval_truth *truth)
{
	enum { TRIES = 2000 };
	const eval_series *s = truth->series;
	double distance[TRIES];
	size_t n = 0, step = s->n / TRIES + 1;
	fw_summary summary;
	for (size_t i = 3; i + 3 < s->n && n < TRIES; i += step)
		n += leave_out(s, i, &distance[n]);
	return fw_summarise(n, distance, &summary) == FW_OK ? summary.p95 / 16 : nan("");
}

/* ---- errors ---- */

static double length(const double x[static 3])
{
	return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

void eval_errors(const eval_fix *solution, const eval_fix *truth, double error[static EVAL_QUANTITIES])
{
	double C_e_n[3][3], apart_e[3], q0[4], q1[4], turn[3];

	for (int i = 0; i < 3; i++) {
		apart_e[i] = solution->position_m[i] - truth->position_m[i];
		error[EVAL_VN + i] = solution->velocity_mps[i] - truth->velocity_mps[i];
		error[EVAL_ROLL + i] = fw_deg_from_rad(fw_wrap_pi(solution->rpy_rad[i] - truth->rpy_rad[i]));
	}
	fw_frame_ned(truth->lat_rad, truth->lon_rad, C_e_n);
	fw_mat3_t_vec(C_e_n, apart_e, &error[EVAL_NORTH]);
	error[EVAL_HORIZONTAL] = hypot(error[EVAL_NORTH], error[EVAL_EAST]);
	error[EVAL_POSITION] = length(&error[EVAL_NORTH]);
	error[EVAL_VELOCITY] = length(&error[EVAL_VN]);
	fw_euler_to_quat(truth->rpy_rad, q0);
	fw_euler_to_quat(solution->rpy_rad, q1);
	fw_quat_between(q0, q1, turn);
	error[EVAL_ATTITUDE] = fw_deg_from_rad(length(turn));
}
