#include "fusion/loose.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/stats.h"
#include "fusion/measure_navigation.h"
#include "ins/magnetic_field.h"

/* An item so close after the filter's time is taken at once [ns]: a vehicle of 100 m/s goes 0.1 mm. */
#define AT_ONCE_NS 1000

/* Beyond this an innovation is no error of a receiver [m]. */
#define FAR_M 50e3

/* Fixes that were refused are believed after so long at the earliest [s]. */
#define PATIENCE_S 30

/* A run is proven after so long [s]. */
#define YOUNG_S 120

/* By how much an attitude may be doubted at a time [rad]; and so many times within so long [s] are too many. */
#define DOUBT_MOST  0.5
#define DOUBTS_MOST 3
#define STRAYING_S  100

/* What only a filter gone astray explains has to be said so many times --gate-patience. */
#define MUCH_PATIENCE 10

/* No protection level at all [m]. */
#define LEVEL_MOST 1e6

/* Sigmas out of all proportion [m], [m/s], [rad]. */
#define SIGMA_LEAST 1e-6
#define SIGMA_MOST  1e4

/* What may happen while the IMU says nothing: angular rate and acceleration change so fast [rad/s^2, m/s^3] and so far
 * [rad/s, m/s^2]. A drone's manoeuvres. */
#define UNSEEN_TURN      0.5
#define UNSEEN_TURN_MOST 0.5
#define UNSEEN_PUSH      5.0
#define UNSEEN_PUSH_MOST 5.0

/* An accelerometer that reads exactly 0 and no more force than this on the others: no free fall, but a dead sensor [m/s^2]. */
#define DEAD_MPS2 1.0

/* No IMU is faster than this; samples closer together have a wrong time [s]. */
#define INTERVAL_LEAST 1e-4

/* What a magnetic heading scatters by itself [rad]. */
#define COMPASS_NOISE 0.01

/* phi, down: what a heading speaks of. */
#define HEADING_STATE 2

/* So long a vehicle has to keep its velocity before it counts as standing [s]; to so much [m/s]. */
#define REST_S     2
#define PUSH_LEAST 0.03

/* A quiet cruise feels like rest. The filter has to be sure that it is slow: its speed and the sigma of it [m/s]. */
#define SLOW_MPS 0.5

/* Zero-velocity updates come so often [ns], at round times: errors of stillness are no white noise. */
#define STILL_EVERY_NS (FW_NS_PER_S / 2)

const fw_loose_options fw_loose_defaults = {
    .gyro_noise = 4.4e-5,     /* 0.15 deg/sqrt(h) */
    .accel_noise = 5.9e-4,    /* 60 ug/sqrt(Hz) */
    .gyro_bias_sd = 2.4e-4,   /* 50 deg/h */
    .accel_bias_sd = 0.02,    /* 2 mg */
    .gyro_bias_walk = 1.5e-5, /* 3 deg/h */
    .accel_bias_walk = 3e-4,  /* 30 ug */
    .gyro_bias_tau_s = 1000,
    .accel_bias_tau_s = 1000,
    .gyro_matrix = 1e-3,
    .accel_matrix = 1e-3,
    .position_floor_m = 0.005,
    .velocity_floor_mps = 0.01,
    .adapt = {.mode = FW_ADAPT_NONE,
              .hul_m = 20,
              .vul_m = 25,
              .tau1 = 1,
              .tau2 = 1,
              .tau3 = 1,
              .tau4 = 1,
              .max_age_s = 2,
              .gm_tau_s = 30,
              .gm_k_h = 6.0,  /* DO-229 2.1.2.2.2.2: K of precision approach, horizontal */
              .gm_k_v = 5.33, /* and vertical */
              .gm_share = 0.9,
              .vb_memory = 0.98,
              .student_dof = 4},
    .gate = 1e-5,
    .gate_patience = 30,
    .field_sd_rad = 0.087,
    .field_tau_s = 10,
    .use_table = true,
    .declination_rad = (double)NAN,
    .height_drift_m = 1,
    .height_tau_s = 600,
    .use_still = true,
    .still = {.window_s = 1,
              .gyro_sd_radps = 0.0105,
              .accel_sd_mps2 = 0.15,
              .gyro_mean_radps = 0.0524,
              .gravity_mps2 = 9.80665,
              .gravity_within_mps2 = 0.6,
              .leave = 2,
              .speed_mps = 0.3},
    .still_sd_mps = 0.02,
    .gap_s = 1,
    .gyro_max = 60,
    .accel_max = 500,
    .node_s = 0.25,
};

const char *fw_refusal_text(fw_refusal why)
{
	static const char *const text[FW_REFUSED_COUNT] = {
	    [FW_REFUSED_NOT_FINITE] = "not finite",     [FW_REFUSED_RANGE] = "out of range",
	    [FW_REFUSED_SIGMA] = "no valid sigma",      [FW_REFUSED_DUPLICATE] = "duplicate time",
	    [FW_REFUSED_BACKWARDS] = "back in time",    [FW_REFUSED_LATE] = "too late",
	    [FW_REFUSED_GATE] = "innovation too large", [FW_REFUSED_INTEGRITY] = "integrity lost",
	    [FW_REFUSED_OVERFLOW] = "too many at once",
	};
	return why < FW_REFUSED_COUNT ? text[why] : "unknown";
}

static const char *item_name(fw_item_kind kind)
{
	static const char *const name[FW_ITEM_MARK + 1] = {"fix",    "heading", "magnetic heading",
	                                                   "height", "levels",  "mark"};
	return name[kind];
}

static double speed_of(const double v[static 3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static bool finite3(const double v[static 3])
{
	return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

/* ---- the start ---- */

static void set_process(fw_process_noise *p, double sd, double tau_s)
{
	p->tau_s = tau_s;
	for (int i = 0; i < 3; i++)
		p->density[i] = sd * sqrt(2 / tau_s);
}

/* A bias is a constant of the turn-on sigma and a wandering part; one state holds both. It fades to zero as slowly as the sum of their
 * variances allows: with the noise of the wandering part, a variance that stays what it is at the start. */
static void set_bias(fw_process_noise *p, double turn_on_sd, double walk_sd, double tau_s)
{
	const double noise = 2 * walk_sd * walk_sd / tau_s;
	p->tau_s = noise > 0 ? 2 * (turn_on_sd * turn_on_sd + walk_sd * walk_sd) / noise : (double)INFINITY;
	for (int i = 0; i < 3; i++)
		p->density[i] = sqrt(noise);
}

static void make_model(const fw_loose_options *o, fw_filter_model *m)
{
	unsigned blocks = 1U << FW_BLOCK_GYRO_BIAS | 1U << FW_BLOCK_ACCEL_BIAS;
	if (o->gyro_scale_sd > 0)
		blocks |= 1U << FW_BLOCK_GYRO_SCALE;
	if (o->accel_scale_sd > 0)
		blocks |= 1U << FW_BLOCK_ACCEL_SCALE;
	if (o->adapt.mode == FW_ADAPT_GM)
		blocks |= 1U << FW_BLOCK_POSITION_ERROR | 1U << FW_BLOCK_VELOCITY_ERROR;
	if (o->height_sd_m > 0)
		blocks |= 1U << FW_BLOCK_HEIGHT_ERROR;
	memset(m, 0, sizeof *m);
	m->layout = fw_layout_of(blocks);
	m->gyro_noise = o->gyro_noise;
	m->accel_noise = o->accel_noise;
	m->gyro_matrix = o->gyro_matrix;
	m->accel_matrix = o->accel_matrix;
	for (int b = 0; b < FW_BLOCK_COUNT; b++)
		m->process[b].tau_s = (double)INFINITY;
	set_bias(&m->process[FW_BLOCK_GYRO_BIAS], o->gyro_bias_sd, o->gyro_bias_walk, o->gyro_bias_tau_s);
	set_bias(&m->process[FW_BLOCK_ACCEL_BIAS], o->accel_bias_sd, o->accel_bias_walk, o->accel_bias_tau_s);
	set_process(&m->process[FW_BLOCK_POSITION_ERROR], 0, o->adapt.gm_tau_s);
	set_process(&m->process[FW_BLOCK_VELOCITY_ERROR], 0, o->adapt.gm_tau_s);
	set_process(&m->process[FW_BLOCK_HEIGHT_ERROR], o->height_drift_m, o->height_tau_s);
	m->process[FW_BLOCK_HEIGHT_ERROR].tau_s = (double)INFINITY; /* from wherever it is, not from zero */
}

static bool options_good(const fw_loose_options *o)
{
	const double positive[] = {
	    o->gyro_noise,        o->accel_noise,  o->gyro_bias_tau_s, o->accel_bias_tau_s, o->gap_s,
	    o->gyro_max,          o->accel_max,    o->node_s,          o->adapt.gm_tau_s,   o->adapt.hul_m,
	    o->adapt.vul_m,       o->adapt.tau1,   o->adapt.tau2,      o->adapt.tau3,       o->adapt.tau4,
	    o->adapt.student_dof, o->height_tau_s, o->still_sd_mps};
	const double not_negative[] = {o->gyro_bias_sd,       o->accel_bias_sd, o->gyro_bias_walk,
	                               o->accel_bias_walk,    o->gyro_scale_sd, o->accel_scale_sd,
	                               o->gyro_matrix,        o->accel_matrix,  o->position_floor_m,
	                               o->velocity_floor_mps, o->gate,          o->height_sd_m,
	                               o->wheels_sd_mps};
	for (size_t i = 0; i < sizeof positive / sizeof positive[0]; i++)
		if (!(positive[i] > 0))
			return false;
	for (size_t i = 0; i < sizeof not_negative / sizeof not_negative[0]; i++)
		if (!(not_negative[i] >= 0))
			return false;
	return finite3(o->lever_b) && o->gate < 1 && o->adapt.vb_memory >= 0 && o->adapt.vb_memory < 1;
}

fw_status fw_loose_init(fw_loose *l, const fw_loose_options *o, const fw_loose_hooks *hooks)
{
	const fw_heading_table_setup table = fw_heading_table_defaults();
	fw_stillness stillness;
	if (!options_good(o) || fw_stillness_init(&o->still, &stillness) != FW_OK)
		return FW_EINVAL;
	memset(l, 0, sizeof *l);
	l->options = *o;
	if (hooks != NULL)
		l->hooks = *hooks;
	l->stillness = stillness;
	for (int m = 1; m <= 3; m++) {
		l->gate_limit[m] = DBL_MAX;
		if (o->gate > 0)
			(void)!fw_chi2_quantile_upper(o->gate, m, &l->gate_limit[m]);
	}
	for (int k = 0; k <= FW_ITEM_MARK; k++)
		l->item_time[k].ns = INT64_MIN;
	l->levels_time.ns = l->last_fix.ns = INT64_MIN;
	for (int i = 0; i < 4; i++)
		fw_vb_start(&l->vb[i]);
	return fw_heading_table_init(&table, &l->table);
}

/* An error of the fixes begins as wrong as the first fix, and the estimate that came from it is wrong by the same, the other way. */
static void tie_errors(fw_filter *f, fw_block block, fw_block error)
{
	const int at = f->model.layout.at[block], e = f->model.layout.at[error];
	for (int i = 0; e >= 0 && i < 3; i++)
		f->P[at + i][e + i] = f->P[e + i][at + i] = -0.99 * f->P[at + i][at + i];
}

/* ---- nodes ---- */

static void node_begin(fw_loose *l)
{
	const fw_filter *f = &l->filter;
	if (l->hooks.node == NULL || l->node_open)
		return;
	l->node.time = f->pva.time;
	l->node.predicted = f->pva;
	memcpy(l->node.x_predicted, f->x, sizeof f->x);
	memcpy(l->node.P_predicted, f->P, sizeof f->P);
	memcpy(l->node.transition, f->transition, sizeof f->transition);
	l->node_open = true;
}

static void node_end(fw_loose *l)
{
	const fw_filter *f = &l->filter;
	if (!l->node_open)
		return;
	l->node.filtered = f->pva;
	memcpy(l->node.x_filtered, f->x, sizeof f->x);
	memcpy(l->node.P_filtered, f->P, sizeof f->P);
	fw_filter_restart_transition(&l->filter);
	l->node_open = false;
	l->hooks.node(l->hooks.context, l);
}

fw_status fw_loose_start(fw_loose *l, const fw_pva *pva, const double attitude_sd[static 3],
                         const double velocity_sd[static 3], const double position_sd[static 3],
                         const double *gyro_bias, const double *gyro_bias_sd)
{
	const fw_loose_options *o = &l->options;
	fw_filter_model model;
	double sd[FW_STATES_MAX] = {0};

	make_model(o, &model);
	const int *at = model.layout.at;
	for (int i = 0; i < 3; i++) {
		sd[i] = attitude_sd[i];
		sd[3 + i] = velocity_sd[i];
		sd[6 + i] = position_sd[i];
		sd[at[FW_BLOCK_GYRO_BIAS] + i] =
		    gyro_bias_sd != NULL ? gyro_bias_sd[i] : hypot(o->gyro_bias_sd, o->gyro_bias_walk);
		/* misaligned accelerometers feel gravity: a bias, as long as the vehicle is about level */
		sd[at[FW_BLOCK_ACCEL_BIAS] + i] =
		    hypot(hypot(o->accel_bias_sd, o->accel_bias_walk), o->accel_matrix * 9.8);
		if (at[FW_BLOCK_GYRO_SCALE] >= 0)
			sd[at[FW_BLOCK_GYRO_SCALE] + i] = o->gyro_scale_sd;
		if (at[FW_BLOCK_ACCEL_SCALE] >= 0)
			sd[at[FW_BLOCK_ACCEL_SCALE] + i] = o->accel_scale_sd;
		if (at[FW_BLOCK_POSITION_ERROR] >=
		    0) /* the fix that began it all is as wrong as the filter */
			sd[at[FW_BLOCK_POSITION_ERROR] + i] = position_sd[i];
		if (at[FW_BLOCK_VELOCITY_ERROR] >= 0)
			sd[at[FW_BLOCK_VELOCITY_ERROR] + i] = velocity_sd[i];
	}
	if (at[FW_BLOCK_HEIGHT_ERROR] >= 0)
		sd[at[FW_BLOCK_HEIGHT_ERROR]] = 1000; /* any zero that a barometer may have */
	fw_status status = fw_filter_init(&l->filter, &model, pva, sd);
	if (status < 0)
		return status;
	for (int i = 0; gyro_bias != NULL && i < 3; i++)
		l->filter.x[at[FW_BLOCK_GYRO_BIAS] + i] = gyro_bias[i];
	tie_errors(&l->filter, FW_BLOCK_VELOCITY, FW_BLOCK_VELOCITY_ERROR);
	tie_errors(&l->filter, FW_BLOCK_POSITION, FW_BLOCK_POSITION_ERROR);
	l->filter.keep_transition = l->hooks.node != NULL;
	l->running = true;
	l->has_last = l->has_suspect = l->node_open = l->has_compass = l->lost = false;
	l->last.time = pva->time;
	l->interval_s = 0;
	l->queued = 0;
	memset(l->refused_in_row, 0, sizeof l->refused_in_row);
	memset(l->half_refused, 0, sizeof l->half_refused);
	l->half_used[0] = l->half_used[1] = l->doubted = pva->time;
	l->doubts = 0;
	l->rest_since = l->begun = pva->time;
	memset(l->push_mps, 0, sizeof l->push_mps);
	l->last_fix = l->still_time = l->field_time = pva->time;
	(void)!fw_stillness_init(&o->still, &l->stillness);
	node_begin(l);
	node_end(l);
	return FW_OK;
}

/* ---- items: what is refused at the door ---- */

static void refuse(fw_loose *l, const fw_item *item, fw_refusal why, double size)
{
	l->counts.refused[item->kind][why]++;
	if (l->hooks.refused != NULL)
		l->hooks.refused(l->hooks.context, item->time, item_name(item->kind), why, size);
}

/* Whether a covariance is one: symmetric, positive, neither 0 nor infinite. */
static bool covariance_good(const double R[static 3][3])
{
	for (int i = 0; i < 3; i++) {
		if (!(R[i][i] >= SIGMA_LEAST * SIGMA_LEAST && R[i][i] <= SIGMA_MOST * SIGMA_MOST))
			return false;
		for (int j = 0; j < i; j++)
			if (!(R[i][j] == R[j][i] && R[i][j] * R[i][j] < R[i][i] * R[j][j]))
				return false;
	}
	const double det = R[0][0] * (R[1][1] * R[2][2] - R[1][2] * R[2][1]) -
	                   R[0][1] * (R[1][0] * R[2][2] - R[1][2] * R[2][0]) +
	                   R[0][2] * (R[1][0] * R[2][1] - R[1][1] * R[2][0]);
	return det > 0;
}

static bool sigma_good(double sd)
{
	return sd >= SIGMA_LEAST && sd <= SIGMA_MOST;
}

/* Puts the static sigmas of the options in place of the receiver's, where they are set. */
static void replace_covariance(const double sd[static 3], double R[static 3][3])
{
	if (!(sd[0] > 0 || sd[1] > 0 || sd[2] > 0))
		return;
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			if (sd[i] > 0 || sd[j] > 0)
				R[i][j] = i == j ? sd[i] * sd[i] : 0;
}

/* A protection level, or none. */
static bool is_level(double level_m)
{
	return isnan(level_m) || (level_m > 0 && level_m < LEVEL_MOST);
}

/* FW_REFUSED_COUNT: nothing wrong with it. */
static fw_refusal examine(const fw_loose *l, fw_item *item)
{
	switch (item->kind) {
	case FW_ITEM_FIX:
		if ((item->fix.has_position && !finite3(item->fix.llh)) ||
		    (item->fix.has_velocity && !finite3(item->fix.velocity_mps)))
			return FW_REFUSED_NOT_FINITE;
		if (item->fix.has_position &&
		    !(fabs(item->fix.llh[0]) < FW_PI / 2 && fabs(item->fix.llh[1]) <= 2 * FW_PI &&
		      fabs(item->fix.llh[2]) < 1e5))
			return FW_REFUSED_RANGE;
		if (item->fix.has_velocity && !(speed_of(item->fix.velocity_mps) < 1000))
			return FW_REFUSED_RANGE;
		replace_covariance(l->options.position_sd, item->fix.R_position);
		replace_covariance(l->options.velocity_sd, item->fix.R_velocity);
		if ((item->fix.has_position && !covariance_good(item->fix.R_position)) ||
		    (item->fix.has_velocity && !covariance_good(item->fix.R_velocity)))
			return FW_REFUSED_SIGMA;
		return FW_REFUSED_COUNT;
	case FW_ITEM_HEADING:
		if (!isfinite(item->heading.heading_rad) || !isfinite(item->heading.sd_rad))
			return FW_REFUSED_NOT_FINITE;
		if (!(fabs(item->heading.heading_rad) <= 4 * FW_PI))
			return FW_REFUSED_RANGE;
		return sigma_good(item->heading.sd_rad) ? FW_REFUSED_COUNT : FW_REFUSED_SIGMA;
	case FW_ITEM_FIELD:
		if (!finite3(item->field.b_ut))
			return FW_REFUSED_NOT_FINITE;
		return speed_of(item->field.b_ut) < 1e4 ? FW_REFUSED_COUNT : FW_REFUSED_RANGE;
	case FW_ITEM_HEIGHT:
		if (!isfinite(item->height.height_m))
			return FW_REFUSED_NOT_FINITE;
		return fabs(item->height.height_m) < 1e5 ? FW_REFUSED_COUNT : FW_REFUSED_RANGE;
	case FW_ITEM_LEVELS:
		return is_level(item->levels.hpl_m) && is_level(item->levels.vpl_m) ? FW_REFUSED_COUNT
		                                                                    : FW_REFUSED_RANGE;
	case FW_ITEM_MARK: break;
	}
	return FW_REFUSED_COUNT;
}

bool fw_loose_usable(fw_loose *l, fw_item *item)
{
	const fw_refusal why = examine(l, item);
	if (why != FW_REFUSED_COUNT)
		refuse(l, item, why, 0);
	return why == FW_REFUSED_COUNT;
}

/* Into the queue, behind those of the same time. */
static bool enqueue(fw_loose *l, const fw_item *item)
{
	int i = l->queued;
	if (i == FW_LOOSE_QUEUE)
		return false;
	for (; i > 0 && l->queue[i - 1].time.ns > item->time.ns; i--)
		l->queue[i] = l->queue[i - 1];
	l->queue[i] = *item;
	l->queued++;
	return true;
}

static void take_levels(fw_loose *l, const fw_item *item)
{
	l->integrity = item->levels.state;
	l->levels.known = item->levels.hpl_m > 0 && item->levels.vpl_m > 0;
	l->levels.hpl_m = item->levels.hpl_m;
	l->levels.vpl_m = item->levels.vpl_m;
	l->levels_time = item->time;
}

void fw_loose_item(fw_loose *l, const fw_item *given)
{
	fw_item item = *given;
	fw_time *before = &l->item_time[item.kind];
	fw_refusal why = FW_REFUSED_COUNT;
	if (item.kind != FW_ITEM_MARK && item.time.ns <= before->ns)
		why = item.time.ns == before->ns ? FW_REFUSED_DUPLICATE : FW_REFUSED_BACKWARDS;
	else if (l->running && item.time.ns < l->filter.pva.time.ns)
		why = FW_REFUSED_LATE;
	else
		why = examine(l, &item);
	if (why != FW_REFUSED_COUNT)
		refuse(l, &item, why, 0);
	if (item.kind == FW_ITEM_LEVELS && why == FW_REFUSED_RANGE)
		item.levels.hpl_m = item.levels.vpl_m =
		    (double)NAN; /* what the monitor says of the state stands */
	else if (why != FW_REFUSED_COUNT)
		return;
	*before = item.time;
	if (!l->running && item.kind == FW_ITEM_LEVELS)
		take_levels(l, &item);
	else if (l->running && !enqueue(l, &item))
		refuse(l, &item, FW_REFUSED_OVERFLOW, 0);
}

/* ---- updates ---- */

/* Gauss-Markov errors of the fixes have the sigma of the protection levels, or of the receiver without them. */
static void follow_levels(fw_loose *l, fw_block block, double R[static 3][3], double per_m)
{
	const fw_adapt_options *o = &l->options.adapt;
	const bool known = l->levels.known && per_m > 0;
	for (int i = 0; i < 3; i++) {
		const double level = i < 2 ? l->levels.hpl_m / o->gm_k_h : l->levels.vpl_m / o->gm_k_v;
		const double sd = known ? level * per_m : sqrt(R[i][i]);
		l->filter.model.process[block].density[i] = sd * sqrt(2 * o->gm_share / o->gm_tau_s);
	}
	for (int i = 0; i < 3; i++) {
		const double white = fmax(1 - o->gm_share, 1e-5);
		for (int j = 0; j < 3; j++)
			R[i][j] *= white;
	}
}

static void scale_rows(double h, double v, double R[static 3][3])
{
	const double s[3] = {sqrt(h), sqrt(h), sqrt(v)};
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			R[i][j] *= s[i] * s[j];
}

static void raise_to_floor(double floor, double R[static 3][3])
{
	for (int i = 0; i < 3; i++)
		R[i][i] = fmax(R[i][i], floor * floor);
}

typedef void measure_fix(const fw_filter *f, const double *value, const double (*R)[3], const double *lever_b,
                         fw_measurement *z);

/* Learns the scales of horizontal and vertical variance together with the update: fixed-point iteration of the
 * variational Bayes filter. Source: S. Saerkkae, A. Nummenmaa, "Recursive noise adaptive Kalman filtering by variational Bayesian
 * approximations", IEEE Trans. Automatic Control 54 (2009). */
static fw_status update_vb(fw_loose *l, fw_measurement *z, fw_vb_scale scale[static 2])
{
	static const int rows_of[2][2] = {{0, 2}, {2, 3}};
	const double memory = l->options.adapt.vb_memory;
	const fw_filter start = l->filter;
	const fw_measurement nominal = *z;
	const fw_vb_scale prior[2] = {{memory * scale[0].a, memory * scale[0].b},
	                              {memory * scale[1].a, memory * scale[1].b}};
	fw_vb_scale learnt[2] = {scale[0], scale[1]};
	fw_status status = FW_OK;
	for (int pass = 0; pass < 3 && status >= 0; pass++) {
		double error[FW_STATES_MAX];
		for (int r = 0; r < 3; r++)
			for (int c = 0; c < 3; c++) {
				const fw_vb_scale *a = &learnt[r / 2], *b = &learnt[c / 2];
				z->R[r][c] = nominal.R[r][c] * sqrt(a->b / a->a * b->b / b->a);
			}
		l->filter = start;
		status = fw_filter_update(&l->filter, z, NULL);
		fw_estimate_difference(&start.model.layout, &start.pva, start.x, &l->filter.pva, l->filter.x,
		                       error);
		for (int g = 0; g < 2 && status >= 0; g++) {
			learnt[g].a = prior[g].a + (rows_of[g][1] - rows_of[g][0]) / 2.0;
			learnt[g].b = prior[g].b;
			for (int r = rows_of[g][0]; r < rows_of[g][1]; r++) {
				double left = nominal.innovation[r], spread = 0;
				for (int i = 0; i < start.model.layout.n; i++) {
					left -= nominal.H[r][i] * error[i];
					for (int k = 0; k < start.model.layout.n; k++)
						spread +=
						    nominal.H[r][i] * l->filter.P[i][k] * nominal.H[r][k];
				}
				learnt[g].b += (left * left + spread) / nominal.R[r][r] / 2;
			}
		}
	}
	if (status < 0) {
		l->filter = start;
		return status;
	}
	scale[0] = learnt[0];
	scale[1] = learnt[1];
	return FW_OK;
}

/* R of Student's t, by the innovation itself. */
static void scale_student(const fw_loose *l, fw_measurement *z)
{
	const fw_measurement nominal = *z;
	for (int pass = 0; pass < 3; pass++) {
		double nis;
		if (fw_filter_nis(&l->filter, z, &nis) < 0)
			return;
		const double k = fw_student_factor(l->options.adapt.student_dof, nis, z->m);
		for (int r = 0; r < z->m; r++)
			for (int c = 0; c < z->m; c++)
				z->R[r][c] = nominal.R[r][c] * k;
	}
}

/* Have so many items been refused in a row that it is time to believe them? */
static bool is_enough(const fw_loose *l, fw_item_kind kind, int factor)
{
	return l->options.gate_patience > 0 && l->refused_in_row[kind] / factor >= l->options.gate_patience;
}

/* The same for the halves of a fix, and for long: reflections and wrong ambiguities last, and agree with each other. Velocities
 * are believed only where no position bears the filter out. But a run that has just begun is itself the first to be doubted: its
 * patience grows with its age. */
static bool is_time_to_believe(const fw_loose *l, fw_block block)
{
	const fw_time now = l->filter.pva.time;
	const double age_s = fw_time_diff_s(now, l->begun), share = fmin(fmax(age_s / YOUNG_S, 0.05), 1);
	const double *const alone =
	    (const double[]){fw_time_diff_s(now, l->half_used[0]), fw_time_diff_s(now, l->half_used[1])};
	const int half = block == FW_BLOCK_VELOCITY;
	return l->options.gate_patience > 0 && l->half_refused[half] >= share * l->options.gate_patience &&
	       alone[half] > share * PATIENCE_S && (half == 0 || share < 1 || alone[0] > PATIENCE_S);
}

/* Makes an innovation credible: what it is off goes into the variances of the n states that it speaks of, as if it had come
 * on the way here. */
static void believe(fw_loose *l, const fw_measurement *z, int at, int n)
{
	for (int i = 0; i < n; i++) {
		const double more = z->innovation[i] * z->innovation[i];
		l->filter.P[at + i][at + i] += more;
		if (l->node_open)
			l->node.P_predicted[at + i][at + i] += more;
	}
	l->counts.forced++;
}

/* A filter that is somewhere else than all fixes has leant the wrong way: by the angle whose share of gravity explains it, which is
 * doubted from now on. Astray again and again within a short time, it has to begin anew. */
static void doubt(fw_loose *l, const fw_measurement *z, fw_block block)
{
	const bool is_position = block == FW_BLOCK_POSITION;
	const fw_time now = l->filter.pva.time;
	const double alone_s = fmax(1, fw_time_diff_s(now, l->half_used[!is_position])),
	             speed = speed_of(z->innovation) / alone_s * (is_position ? 2 / alone_s : 1),
	             angle = fmin(speed / 9.8, DOUBT_MOST);
	for (int i = 0; i < 3; i++) {
		l->filter.P[i][i] += angle * angle;
		if (l->node_open)
			l->node.P_predicted[i][i] += angle * angle;
	}
	l->begun = now; /* as good as: if that was wrong, it must not take as long to find back */
	if (angle == DOUBT_MOST) {
		l->lost |= l->doubts > 0 && fw_time_diff_s(now, l->doubted) < STRAYING_S &&
		           l->doubts + 1 >= DOUBTS_MOST;
		l->doubts = fw_time_diff_s(now, l->doubted) < STRAYING_S ? l->doubts + 1 : 1;
		l->doubted = now;
	}
}

/* One of the two halves of a fix. Returns whether it was used. */
static bool update_fix(fw_loose *l, const fw_item *item, fw_measurement *z, fw_block block)
{
	const bool is_position = block == FW_BLOCK_POSITION;
	int *in_row = &l->half_refused[!is_position];
	double nis;
	if (l->options.adapt.mode == FW_ADAPT_STUDENT)
		scale_student(l, z);
	if (fw_filter_nis(&l->filter, z, &nis) < 0) {
		refuse(l, item, FW_REFUSED_SIGMA, 0);
		return false;
	}
	if (is_position && !(speed_of(z->innovation) < FAR_M)) {
		++*in_row;
		l->lost |=
		    l->options.gate_patience > 0 && *in_row / MUCH_PATIENCE >= l->options.gate_patience;
		refuse(l, item, FW_REFUSED_RANGE, 0);
		return false;
	}
	if (nis > l->gate_limit[3]) {
		if (!is_time_to_believe(l, block)) {
			++*in_row;
			refuse(l, item, FW_REFUSED_GATE, sqrt(nis));
			return false;
		}
		doubt(l, z, block);
		believe(l, z, l->filter.model.layout.at[block], 3);
	}
	fw_status status = l->options.adapt.mode == FW_ADAPT_VB ? update_vb(l, z, &l->vb[is_position ? 0 : 2])
	                                                        : fw_filter_update(&l->filter, z, NULL);
	if (status < 0) {
		refuse(l, item, FW_REFUSED_SIGMA, 0);
		return false;
	}
	*in_row = 0;
	l->half_used[!is_position] = l->filter.pva.time;
	l->counts.nis_sum += nis;
	l->counts.nis_rows += 3;
	if (is_position) {
		l->counts.position_nis_sum += nis;
		l->counts.position_nis_rows += 3;
	}
	return true;
}

/* R of a half of a fix, as it is believed, and the measurement. */
static void prepare_fix(fw_loose *l, measure_fix *measure, const double *value, double (*R)[3], double floor,
                        fw_block error, fw_measurement *z)
{
	const fw_adapt_factors k = l->options.adapt.mode == FW_ADAPT_PL
	                               ? fw_adapt_by_levels(&l->options.adapt, &l->levels)
	                               : (fw_adapt_factors){1, 1, 1};
	scale_rows(k.r_h, k.r_v, R);
	if (l->options.adapt.mode == FW_ADAPT_GM)
		follow_levels(l, error, R, error == FW_BLOCK_POSITION_ERROR ? 1 : 0);
	raise_to_floor(floor, R);
	measure(&l->filter, value, (const double(*)[3])R, l->options.lever_b, z);
}

static void take_fix(fw_loose *l, fw_item *item)
{
	const fw_loose_options *o = &l->options;
	fw_measurement z;
	bool used = false, refused = false;
	if (l->integrity == FW_UNRELIABLE) {
		refuse(l, item, FW_REFUSED_INTEGRITY, 0);
		return;
	}
	if (item->fix.has_position) {
		prepare_fix(l, fw_measure_position, item->fix.llh, item->fix.R_position, o->position_floor_m,
		            FW_BLOCK_POSITION_ERROR, &z);
		used = update_fix(l, item, &z, FW_BLOCK_POSITION);
		refused = !used;
	}
	if (item->fix.has_velocity && !refused) {
		const double *v = item->fix.velocity_mps;
		fw_stillness_speed(&l->stillness, item->time, hypot(v[0], v[1]),
		                   sqrt(fmax(item->fix.R_velocity[0][0], item->fix.R_velocity[1][1])));
		prepare_fix(l, fw_measure_velocity, v, item->fix.R_velocity, o->velocity_floor_mps,
		            FW_BLOCK_VELOCITY_ERROR, &z);
		used |= update_fix(l, item, &z, FW_BLOCK_VELOCITY);
	}
	if (used) {
		l->counts.used[FW_ITEM_FIX]++;
		l->last_fix = item->time;
	}
}

/* A measurement of one row, through the gate. Too often refused it is believed, and not what the filter has for `state`. */
static bool update_one(fw_loose *l, const fw_item *item, const fw_measurement *z, int state, int patience)
{
	int *in_row = &l->refused_in_row[item->kind];
	double nis;
	if (fw_filter_nis(&l->filter, z, &nis) < 0) {
		refuse(l, item, FW_REFUSED_SIGMA, 0);
		return false;
	}
	if (nis > l->gate_limit[1]) {
		if (!is_enough(l, item->kind, patience)) {
			++*in_row;
			refuse(l, item, FW_REFUSED_GATE, sqrt(nis));
			return false;
		}
		believe(l, z, state, 1);
	}
	*in_row = 0;
	if (fw_filter_update(&l->filter, z, NULL) < 0) {
		refuse(l, item, FW_REFUSED_SIGMA, 0);
		return false;
	}
	l->counts.used[item->kind]++;
	return true;
}

/* What the table learns from a heading of the antennas: where the compass would point now, and how the vehicle leans. */
static void teach_table(fw_loose *l, const fw_item *item)
{
	double rpy[3];
	if (!l->has_compass || !l->options.use_table)
		return;
	fw_quat_to_euler(l->filter.pva.q_n_b, rpy);
	fw_heading_table_tilt(&l->table, rpy);
	(void)!fw_heading_table_update(&l->table, item->time, fw_wrap_2pi(rpy[2] + l->compass_off_rad),
	                               item->heading.heading_rad, hypot(item->heading.sd_rad, COMPASS_NOISE));
}

static void take_heading(fw_loose *l, const fw_item *item)
{
	fw_measurement z;
	if (fw_measure_heading(&l->filter, item->heading.heading_rad, item->heading.sd_rad, &z) < 0) {
		refuse(l, item, FW_REFUSED_RANGE, 0);
		return;
	}
	teach_table(l, item);
	update_one(l, item, &z, HEADING_STATE, MUCH_PATIENCE);
}

/* The Earth's field at the first reading, and the declination that the options say. Returns false if there is none. */
static bool know_field(fw_loose *l)
{
	double *b = l->field_ned_nt;
	if (b[0] != 0 || b[1] != 0)
		return true;
	if (fw_magnetic_field(l->filter.pva.llh, l->filter.pva.time, b) < 0)
		return false;
	if (isfinite(l->options.declination_rad)) {
		const double h = hypot(b[0], b[1]);
		b[0] = h * cos(l->options.declination_rad);
		b[1] = h * sin(l->options.declination_rad);
	}
	return true;
}

/* A magnetic heading, corrected by the table. Its errors stay a while: it is used now and then only, but it is always heard for the table. */
static void take_field(fw_loose *l, const fw_item *item)
{
	const fw_mag_calibration as_it_is = fw_mag_as_it_is(50, 0.5);
	double rpy[3], heading, sd, correction = 0, correction_sd = l->options.field_sd_rad;
	fw_measurement z;
	fw_quat_to_euler(l->filter.pva.q_n_b, rpy);
	if (!know_field(l) ||
	    fw_mag_heading(&as_it_is, item->field.b_ut, rpy, 0, l->field_ned_nt, &heading, &sd) < 0) {
		refuse(l, item, FW_REFUSED_RANGE, 0);
		return;
	}
	l->compass_off_rad = fw_wrap_pi(heading - rpy[2]);
	l->has_compass = true;
	if (!l->options.use_field || item->time.ns - l->field_time.ns < llround(l->options.field_tau_s * 1e9))
		return;
	if (l->options.use_table && l->table.begun) {
		fw_heading_table_tilt(&l->table, rpy);
		fw_heading_table_correction(&l->table, heading, &correction, &correction_sd);
		correction_sd = fmin(correction_sd, l->options.field_sd_rad);
	}
	if (fw_measure_compass(&l->filter, heading + correction, hypot(sd, correction_sd), l->field_ned_nt,
	                       &z) < 0) {
		refuse(l, item, FW_REFUSED_RANGE, 0);
		return;
	}
	update_one(l, item, &z, HEADING_STATE, MUCH_PATIENCE);
	l->field_time = item->time;
}

static void take_height(fw_loose *l, const fw_item *item)
{
	fw_measurement z;
	const int zero = l->filter.model.layout.at[FW_BLOCK_HEIGHT_ERROR];
	if (zero < 0)
		return;
	fw_measure_height(&l->filter, item->height.height_m, l->options.height_sd_m, &z);
	update_one(l, item, &z, zero, 1);
}

/* Protection levels that nobody has renewed are none. */
static void forget_levels(fw_loose *l)
{
	if (l->levels_time.ns == INT64_MIN ||
	    fw_time_diff_s(l->filter.pva.time, l->levels_time) <= l->options.adapt.max_age_s)
		return;
	l->levels.known = false;
	l->integrity = FW_INTEGRITY_UNKNOWN;
	l->levels_time.ns = INT64_MIN;
}

static void take(fw_loose *l, fw_item *item)
{
	forget_levels(l);
	if (item->kind == FW_ITEM_LEVELS) {
		take_levels(l, item);
		l->counts.used[FW_ITEM_LEVELS]++;
		return;
	}
	if (item->kind == FW_ITEM_MARK) {
		l->counts.used[FW_ITEM_MARK]++;
		if (l->hooks.mark != NULL)
			l->hooks.mark(l->hooks.context, l, item->mark.number);
		return;
	}
	node_begin(l);
	if (item->kind == FW_ITEM_FIX)
		take_fix(l, item);
	else if (item->kind == FW_ITEM_HEADING)
		take_heading(l, item);
	else if (item->kind == FW_ITEM_FIELD)
		take_field(l, item);
	else
		take_height(l, item);
}

/* All items that are due. Levels of an epoch count for its fix, and marks see what its fix has done. */
static void take_due(fw_loose *l)
{
	const int64_t due = l->filter.pva.time.ns + AT_ONCE_NS;
	int n = 0;
	while (n < l->queued && l->queue[n].time.ns <= due)
		n++;
	if (n == 0)
		return;
	for (int i = 0; i < n; i++)
		if (l->queue[i].kind == FW_ITEM_LEVELS)
			take(l, &l->queue[i]);
	for (int i = 0; i < n; i++)
		if (l->queue[i].kind != FW_ITEM_LEVELS && l->queue[i].kind != FW_ITEM_MARK)
			take(l, &l->queue[i]);
	node_end(l);
	for (int i = 0; i < n; i++)
		if (l->queue[i].kind == FW_ITEM_MARK)
			take(l, &l->queue[i]);
	l->queued -= n;
	memmove(l->queue, l->queue + n, sizeof l->queue[0] * (size_t)l->queued);
}

/* ---- IMU samples ---- */

/* On to a moment at constant readings, by way of the items that lie before it. */
static void advance(fw_loose *l, fw_time end, const double gyro[static 3], const double accel[static 3])
{
	take_due(l);
	while (l->filter.pva.time.ns < end.ns) {
		int64_t to = end.ns;
		if (l->queued > 0 && l->queue[0].time.ns < end.ns)
			to = l->queue[0].time.ns;
		const double dt = (double)(to - l->filter.pva.time.ns) * 1e-9;
		fw_increment raw = {.dt_s = dt};
		for (int i = 0; i < 3; i++) {
			raw.angle_rad[i] = gyro[i] * dt;
			raw.velocity_mps[i] = accel[i] * dt;
		}
		for (int i = 0; i < 3; i++)
			l->push_mps[i] -= l->filter.pva.velocity_mps[i];
		fw_filter_predict(&l->filter, &raw);
		for (int i = 0; i < 3; i++)
			l->push_mps[i] += l->filter.pva.velocity_mps[i];
		l->filter.pva.time.ns = to;
		take_due(l);
	}
}

/* Samples are missing: in between it was, about, as before and after; by how much it may have been otherwise goes into
 * the covariance. */
static void bridge(fw_loose *l, const fw_imu_reading *next)
{
	const int64_t step_ns = llround(l->interval_s * 1e9), end_ns = next->time.ns - step_ns;
	const double gap_s = (double)(end_ns - l->filter.pva.time.ns) * 1e-9;
	double gyro[3], accel[3];
	for (int i = 0; i < 3; i++) {
		const double turn = fabs(next->gyro_radps[i] - l->last.gyro_radps[i]) / 2 +
		                    fmin(UNSEEN_TURN * gap_s, UNSEEN_TURN_MOST);
		const double push = fabs(next->accel_mps2[i] - l->last.accel_mps2[i]) / 2 +
		                    fmin(UNSEEN_PUSH * gap_s, UNSEEN_PUSH_MOST);
		gyro[i] = (next->gyro_radps[i] + l->last.gyro_radps[i]) / 2;
		accel[i] = (next->accel_mps2[i] + l->last.accel_mps2[i]) / 2;
		l->filter.P[i][i] += pow(turn * gap_s, 2);
		l->filter.P[3 + i][3 + i] += pow(push * gap_s, 2);
		l->filter.P[6 + i][6 + i] += pow(push * gap_s * gap_s / 2, 2);
	}
	while (end_ns - l->filter.pva.time.ns > step_ns / 2) {
		const int64_t to = l->filter.pva.time.ns + step_ns;
		advance(l, (fw_time){to < end_ns ? to : end_ns}, gyro, accel);
	}
	l->counts.bridged++;
}

static fw_status refuse_sample(fw_loose *l, fw_time t, fw_refusal why)
{
	l->counts.samples_refused[why]++;
	if (l->hooks.refused != NULL)
		l->hooks.refused(l->hooks.context, t, "IMU sample", why, 0);
	return FW_DUBIOUS;
}

static bool is_denormal(double x)
{
	return x != 0 && fabs(x) < DBL_MIN;
}

fw_refusal fw_examine_reading(const fw_imu_reading *r, double gyro_max, double accel_max)
{
	bool zero = false;
	if (!finite3(r->gyro_radps) || !finite3(r->accel_mps2))
		return FW_REFUSED_NOT_FINITE;
	for (int i = 0; i < 3; i++) {
		const double gyro = r->gyro_radps[i], accel = r->accel_mps2[i];
		if (!(fabs(gyro) <= gyro_max && fabs(accel) <= accel_max) || is_denormal(gyro) ||
		    is_denormal(accel))
			return FW_REFUSED_RANGE;
		zero |= accel == 0;
	}
	return zero && speed_of(r->accel_mps2) < DEAD_MPS2 ? FW_REFUSED_RANGE : FW_REFUSED_COUNT;
}

static fw_refusal examine_sample(const fw_loose *l, const fw_imu_reading *s)
{
	const fw_refusal why = fw_examine_reading(s, l->options.gyro_max, l->options.accel_max);
	if (why != FW_REFUSED_COUNT)
		return why;
	if (s->time.ns <= l->last.time.ns)
		return s->time.ns == l->last.time.ns ? FW_REFUSED_DUPLICATE : FW_REFUSED_BACKWARDS;
	return FW_REFUSED_COUNT;
}

/* The usual interval: a slow mean, in which a gap counts as two intervals, so that a first guess too short does not stay. */
static void learn_interval(fw_loose *l, double dt)
{
	if (dt < INTERVAL_LEAST)
		return;
	if (l->interval_s <= 0)
		l->interval_s = dt;
	l->interval_s += 0.05 * (fmin(dt, 2 * l->interval_s) - l->interval_s);
}

/* A vehicle that rolls out brakes so gently that its IMU calls it still. But its velocity changes, and the filter sees that to a few
 * centimetres per second, by as much as its level is known. Returns whether it has been at rest for long enough. */
static bool is_at_rest(fw_loose *l, fw_time now)
{
	const double rest_s = fw_time_diff_s(now, l->rest_since),
	             tilt = sqrt(l->filter.P[0][0] + l->filter.P[1][1]),
	             most = PUSH_LEAST + 2 * 9.8 * tilt * fmin(rest_s, REST_S);
	if (l->stillness.still && speed_of(l->push_mps) <= most) {
		if (rest_s <= REST_S)
			return false;
		for (int i = 0; i < 3; i++) /* what came long ago is forgotten */
			l->push_mps[i] *= 1 - fmin(l->interval_s / REST_S, 1);
		return true;
	}
	l->rest_since = now;
	memset(l->push_mps, 0, sizeof l->push_mps);
	return false;
}

/* Zero velocity while the vehicle stands. It stands when the IMU is quiet and the filter has it so, too. */
static void take_stillness(fw_loose *l, const fw_imu_reading *s)
{
	fw_filter *f = &l->filter;
	fw_measurement z;
	double nis;
	if (fw_stillness_imu(&l->stillness, s->time, s->gyro_radps, s->accel_mps2) < 0 ||
	    !is_at_rest(l, s->time) || s->time.ns / STILL_EVERY_NS == l->still_time.ns / STILL_EVERY_NS)
		return;
	fw_measure_zero_velocity(f, l->options.still_sd_mps, &z);
	const double sd = sqrt(f->P[3][3] + f->P[4][4] + f->P[5][5]);
	if (fw_filter_nis(f, &z, &nis) < 0 || nis > l->gate_limit[3] ||
	    !(speed_of(f->pva.velocity_mps) < SLOW_MPS && sd < SLOW_MPS))
		return;
	node_begin(l);
	if (fw_filter_update(f, &z, NULL) >= 0)
		l->counts.still++;
	node_end(l);
	l->still_time = s->time;
}

static void take_wheels(fw_loose *l)
{
	const double zero[3] = {0};
	fw_measurement z;
	double nis;
	fw_measure_wheels(&l->filter, l->options.wheels_sd_mps, zero, &z);
	if (fw_filter_nis(&l->filter, &z, &nis) >= 0 && nis <= l->gate_limit[2])
		(void)!fw_filter_update(&l->filter, &z, NULL);
}

/* A gap, or one sample with a wrong time? The next one tells. Returns FW_OK to go on, FW_DUBIOUS to wait, FW_EUNKNOWN: a gap. */
static fw_status judge_time(fw_loose *l, const fw_imu_reading *s)
{
	const int64_t limit_ns = llround(l->options.gap_s * 1e9);
	if (s->time.ns - l->last.time.ns <= limit_ns) {
		if (l->has_suspect)
			refuse_sample(l, l->suspect.time, FW_REFUSED_RANGE);
		l->has_suspect = false;
		return FW_OK;
	}
	if (l->has_suspect && s->time.ns > l->suspect.time.ns &&
	    s->time.ns - l->suspect.time.ns <= limit_ns) {
		l->running = l->has_suspect = false;
		l->counts.gaps++;
		return FW_EUNKNOWN;
	}
	if (l->has_suspect)
		refuse_sample(l, l->suspect.time, FW_REFUSED_RANGE);
	l->suspect = *s;
	l->has_suspect = true;
	return FW_DUBIOUS;
}

fw_status fw_loose_imu(fw_loose *l, const fw_imu_reading *sample)
{
	if (!l->running)
		return FW_EUNKNOWN;
	const fw_refusal why = examine_sample(l, sample);
	if (why != FW_REFUSED_COUNT)
		return refuse_sample(l, sample->time, why);
	const fw_status status = judge_time(l, sample);
	if (status != FW_OK)
		return status;
	const double dt = (double)(sample->time.ns - l->last.time.ns) * 1e-9;
	if (l->has_last && l->interval_s > 0 && dt > 1.5 * l->interval_s)
		bridge(l, sample);
	advance(l, sample->time, sample->gyro_radps, sample->accel_mps2);
	if (l->lost) {
		l->running = false;
		l->counts.strayed++;
		return FW_EUNKNOWN;
	}
	if (l->has_last)
		learn_interval(l, dt);
	l->last = *sample;
	l->has_last = true;
	l->counts.samples++;
	if (l->options.wheels_sd_mps > 0)
		take_wheels(l);
	if (l->options.use_still)
		take_stillness(l, sample);
	if (l->hooks.node != NULL && sample->time.ns - l->node.time.ns >= llround(l->options.node_s * 1e9)) {
		node_begin(l);
		node_end(l);
	}
	if (l->hooks.sample != NULL)
		l->hooks.sample(l->hooks.context, l);
	return FW_OK;
}

void fw_loose_end(fw_loose *l)
{
	if (l->running && l->has_suspect)
		refuse_sample(l, l->suspect.time, FW_REFUSED_RANGE);
	l->has_suspect = false;
}

void fw_attitude_sd(const fw_filter *f, double rpy_sd[static 3])
{
	double C[3][3];
	fw_quat_to_matrix(f->pva.q_n_b, C);
	const double cos_pitch2 = fmax(C[0][0] * C[0][0] + C[1][0] * C[1][0], 1e-12),
	             cos_pitch = sqrt(cos_pitch2);
	/* d(roll, pitch, heading) = J phi */
	const double J[3][3] = {{C[0][0] / cos_pitch2, C[1][0] / cos_pitch2, 0},
	                        {-C[1][0] / cos_pitch, C[0][0] / cos_pitch, 0},
	                        {-C[0][0] * C[2][0] / cos_pitch2, -C[1][0] * C[2][0] / cos_pitch2, 1}};
	for (int r = 0; r < 3; r++) {
		double sum = f->model.gyro_matrix * f->model.gyro_matrix;
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++)
				sum += J[r][i] * f->P[i][k] * J[r][k];
		rpy_sd[r] = fmin(sqrt(fmax(sum, 0)), FW_PI);
	}
}
