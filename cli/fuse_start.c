#include "fuse_start.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "ins/gravity.h"
#include "ins/magnetic_field.h"
#include "ins/magnetometer.h"

#define DEG (FW_PI / 180)

/* The data that the attitude comes from are used once more when the filter goes over them: its sigmas are made wider. */
#define USED_TWICE 1.5

/* How sure levelling in motion is, by the two means of force: turns within the second are not known. */
#define PUSH_LEVEL_SD (5 * DEG)
#define PUSH_S        1.0

enum {
	TRY_EVERY_NS = 250000000, /* how often it is tried */
	FRESH_NS = 1500000000,    /* a heading older than this is none */
	REST_OLD_NS = 1000000000 /* how long a vehicle has to stand on for means of standing to be believed */
};

/* With no better way in sight for so long, a coarser one will do [s]. */
#define PATIENCE_S 20.0
#define COARSEST   (20 * DEG)

/* An attitude found, and what else is known with it. */
typedef struct {
	fw_time t;
	double q_n_b[4], sd[3]; /* sigma of phi, NED */
	double bias[3], bias_sd[3];
	double heading_sd;
	const char *way;
} finding;

/* ---- rings ---- */

static const fw_imu_reading *reading_at(const fuse_start *s, uint64_t number)
{
	return &s->reading[number % FUSE_START_READINGS];
}

static const fw_item *item_at(const fuse_start *s, uint64_t number)
{
	return &s->item[number % FUSE_START_ITEMS];
}

static void keep_reading(fuse_start *s, const fw_imu_reading *r)
{
	if (s->end_reading - s->first_reading == FUSE_START_READINGS) {
		s->first_reading++;
		s->lost++;
	}
	if (s->motion_reading < s->first_reading)
		s->motion_reading = s->first_reading;
	s->reading[s->end_reading++ % FUSE_START_READINGS] = *r;
}

static void keep_item(fuse_start *s, const fw_item *item)
{
	if (s->end_item - s->first_item == FUSE_START_ITEMS) {
		s->first_item++;
		s->lost++;
	}
	s->item[s->end_item++ % FUSE_START_ITEMS] = *item;
}

static bool has_reading(const fuse_start *s)
{
	return s->end_reading > s->first_reading;
}

/* ---- what comes in ---- */

fw_status fuse_start_begin(fuse_start *s, const fuse_start_setup *setup)
{
	const fw_align_motion_setup motion = {
	    .imu = setup->imu, .lever_b = {setup->lever_b[0], setup->lever_b[1], setup->lever_b[2]}};
	fw_stillness stillness;
	fw_align_motion m;
	if (fw_stillness_init(&setup->still, &stillness) != FW_OK ||
	    fw_align_motion_init(&motion, &m) != FW_OK)
		return FW_EINVAL;
	s->setup = *setup;
	s->stillness = stillness;
	s->motion = m;
	s->interval_s = 0;
	s->first_reading = s->end_reading = s->motion_reading = 0;
	s->first_item = s->end_item = 0;
	s->has_fix = s->has_heading = s->has_field = s->has_push_from = false;
	s->push.known = s->young.known = s->standing.known = s->rest.known = false;
	s->moving_s = 0;
	s->tried = (fw_time){0};
	return FW_OK;
}

bool fuse_start_breaks(const fuse_start *s, const fuse_entry *e)
{
	return e->is_imu && has_reading(s) && fw_time_diff_s(e->imu.time, s->last) > s->setup.gap_s;
}

static bool is_vector(const double v[static 3], double most)
{
	return fabs(v[0]) <= most && fabs(v[1]) <= most && fabs(v[2]) <= most;
}

/* FW_REFUSED_COUNT: nothing is wrong with it. */
static fw_refusal examine(const fuse_start *s, const fw_imu_reading *r)
{
	const fw_refusal why = fw_examine_reading(r, fw_loose_defaults.gyro_max, fw_loose_defaults.accel_max);
	if (why == FW_REFUSED_COUNT && has_reading(s) && r->time.ns <= s->last.ns)
		return r->time.ns == s->last.ns ? FW_REFUSED_DUPLICATE : FW_REFUSED_BACKWARDS;
	return why;
}

/* Means of standing still: the newest ones come of age when the vehicle still stands REST_OLD_NS later. */
static void note_rest(fuse_start *s, fw_time t)
{
	fuse_rest now = {.known = true, .until = t};
	if (fw_stillness_averages(&s->stillness, &now.means) != FW_OK) {
		s->young.known = s->standing.known = false;
		return;
	}
	if (s->young.known && t.ns - s->young.until.ns < REST_OLD_NS)
		return;
	if (s->young.known) {
		s->standing = s->young;
		if (!s->rest.known || s->standing.means.seconds >= s->rest.means.seconds)
			s->rest = s->standing;
	}
	s->young = now;
}

static void put_reading(fuse_start *s, const fw_imu_reading *r)
{
	const fw_refusal why = examine(s, r);
	if (why != FW_REFUSED_COUNT) {
		s->refused[why]++;
		return;
	}
	const double dt = fw_time_diff_s(r->time, s->last);
	if (has_reading(s) && (s->interval_s <= 0 || dt < 1.5 * s->interval_s))
		s->interval_s = s->interval_s <= 0 ? dt : s->interval_s + 0.02 * (dt - s->interval_s);
	keep_reading(s, r);
	s->last = r->time;
	(void)!fw_stillness_imu(&s->stillness, r->time, r->gyro_radps, r->accel_mps2);
	note_rest(s, r->time);
	for (int i = 0; i < 3; i++)
		s->push_sum[i] += r->accel_mps2[i];
	s->push_n++;
}

/* Whether a position can be one, and its sigma with it. */
static bool is_fix(const fw_item *item)
{
	const double *llh = item->fix.llh;
	return item->kind == FW_ITEM_FIX && item->fix.has_position && fabs(llh[0]) < 89.9 * DEG &&
	       fabs(llh[1]) <= 2 * FW_PI && fabs(llh[2]) < 1e5 && item->fix.R_position[0][0] >= 0 &&
	       item->fix.R_position[1][1] >= 0 && item->fix.R_position[2][2] >= 0;
}

static bool is_velocity(const fw_item *item)
{
	return item->fix.has_velocity && is_vector(item->fix.velocity_mps, 1000) &&
	       item->fix.R_velocity[0][0] + item->fix.R_velocity[1][1] > 0;
}

/* b - a in metres, north, east, down. */
static void displacement(const double a[static 3], const double b[static 3], double ned[static 3])
{
	static const double still[3];
	fw_earth earth;
	fw_earth_at(a, still, &earth);
	ned[0] = (b[0] - a[0]) * earth.M_m;
	ned[1] = fw_wrap_pi(b[1] - a[1]) * earth.N_m * earth.cos_lat;
	ned[2] = a[2] - b[2];
}

static double horizontal_sd(const double R[static 3][3])
{
	return sqrt((R[0][0] + R[1][1]) / 2);
}

static void feed_motion(fuse_start *s, fw_time until)
{
	for (; s->motion_reading < s->end_reading; s->motion_reading++) {
		const fw_imu_reading *r = reading_at(s, s->motion_reading);
		if (r->time.ns > until.ns)
			return;
		fw_increment raw = {.dt_s = s->interval_s};
		if (s->motion_reading > s->first_reading)
			raw.dt_s = fw_time_diff_s(r->time, reading_at(s, s->motion_reading - 1)->time);
		for (int i = 0; i < 3; i++) {
			raw.angle_rad[i] = r->gyro_radps[i] * raw.dt_s;
			raw.velocity_mps[i] = r->accel_mps2[i] * raw.dt_s;
		}
		(void)!fw_align_motion_imu(&s->motion, r->time, &raw);
	}
}

/* A velocity for the alignment in motion: the fix's own, or that between two positions. */
static void put_velocity(fuse_start *s, const fw_item *fix)
{
	const double dt = s->has_fix ? fw_time_diff_s(fix->time, s->fix.time) : 0;
	if (is_velocity(fix)) {
		const double speed = hypot(fix->fix.velocity_mps[0], fix->fix.velocity_mps[1]);
		const double sd = fmax(USED_TWICE * horizontal_sd(fix->fix.R_velocity), 0.03);
		feed_motion(s, fix->time);
		(void)!fw_align_motion_velocity(&s->motion, fix->time, fix->fix.llh, fix->fix.velocity_mps,
		                                sd);
		fw_stillness_speed(&s->stillness, fix->time, speed, sd);
		if (speed > 2 && speed > 3 * sd && dt > 0 && dt < 2)
			s->moving_s += dt;
		return;
	}
	if (!(dt > 0.05 && dt < 1.5))
		return;
	double v[3];
	displacement(s->fix.fix.llh, fix->fix.llh, v);
	for (int i = 0; i < 3; i++)
		v[i] /= dt;
	s->moving_s += hypot(v[0], v[1]) > 2 ? dt : 0;
	const fw_time middle = fw_time_add_ns(s->fix.time, fw_time_diff_ns(fix->time, s->fix.time) / 2);
	feed_motion(s, middle);
	(void)!fw_align_motion_velocity(&s->motion, middle, fix->fix.llh, v,
	                                hypot(1.4 * horizontal_sd(fix->fix.R_position) / dt, 0.05));
}

/* The mean force over a second, as the IMU and as GNSS have it. */
static void put_push(fuse_start *s, const fw_item *fix)
{
	if (!is_velocity(fix))
		return;
	const double dt = s->has_push_from ? fw_time_diff_s(fix->time, s->push_from.time) : 0;
	if (s->has_push_from && dt < PUSH_S)
		return;
	if (s->has_push_from && dt < 2 * PUSH_S + 1 && s->push_n > 0) {
		s->push.known = true;
		s->push.time = fix->time;
		for (int i = 0; i < 3; i++) {
			s->push.force_b[i] = s->push_sum[i] / s->push_n;
			s->push.force_n[i] =
			    (fix->fix.velocity_mps[i] - s->push_from.fix.velocity_mps[i]) / dt;
		}
		s->push.force_n[2] -= fw_gravity_mps2(fix->fix.llh[0], fix->fix.llh[2]);
	}
	s->push_from = *fix;
	s->has_push_from = true;
	memset(s->push_sum, 0, sizeof s->push_sum);
	s->push_n = 0;
}

static void put_item(fuse_start *s, const fw_item *item)
{
	keep_item(s, item);
	switch (item->kind) {
	case FW_ITEM_FIX:
		if (!is_fix(item))
			return;
		put_velocity(s, item);
		put_push(s, item);
		s->fix = *item;
		s->has_fix = true;
		return;
	case FW_ITEM_HEADING:
		if (!(item->heading.sd_rad > 0 && item->heading.sd_rad < 1 &&
		      fabs(item->heading.heading_rad) < 100))
			return;
		s->heading = *item;
		s->has_heading = true;
		return;
	case FW_ITEM_FIELD:
		if (!is_vector(item->field.b_ut, 1e6))
			return;
		s->field = *item;
		s->has_field = true;
		return;
	case FW_ITEM_HEIGHT:
	case FW_ITEM_LEVELS:
	case FW_ITEM_MARK: return;
	}
}

bool fuse_start_put(fuse_start *s, const fuse_entry *e)
{
	if (e->is_imu)
		put_reading(s, &e->imu);
	else
		put_item(s, &e->item);
	if (!has_reading(s) || !s->has_fix || s->last.ns - s->tried.ns < TRY_EVERY_NS)
		return false;
	s->tried = s->last;
	return true;
}

/* ---- ways to the attitude ---- */

static bool is_fresh(const fuse_start *s, bool has, const fw_item *item)
{
	return has && s->last.ns - item->time.ns < FRESH_NS;
}

static void set_finding(const fw_alignment *a, double factor, fw_time t, const char *way, finding *f)
{
	f->t = t;
	f->way = way;
	memcpy(f->q_n_b, a->q_n_b, sizeof f->q_n_b);
	for (int i = 0; i < 3; i++)
		f->sd[i] = fmin(factor * sqrt(a->covariance_rad2[i][i]), FW_PI);
	f->heading_sd = factor * a->sd_rad[2];
}

/* The Earth's field at the last fix, with the user's declination if there is one. */
static bool earth_field(const fuse_start *s, double field_ned_nt[static 3])
{
	if (fw_magnetic_field(s->fix.fix.llh, s->fix.time, field_ned_nt) < 0)
		return false;
	if (isfinite(s->setup.declination_rad)) {
		const double h = hypot(field_ned_nt[0], field_ned_nt[1]);
		field_ned_nt[0] = h * cos(s->setup.declination_rad);
		field_ned_nt[1] = h * sin(s->setup.declination_rad);
	}
	return true;
}

static bool compass_heading(const fuse_start *s, const double rp[static 2], double *heading, double *sd)
{
	const fw_mag_calibration as_it_is = fw_mag_as_it_is(50, 0.5);
	double field[3];
	if (!s->setup.compass || !is_fresh(s, s->has_field, &s->field) || !earth_field(s, field) ||
	    fw_mag_heading(&as_it_is, s->field.field.b_ut, rp, 0.01, field, heading, sd) != FW_OK)
		return false;
	*sd = hypot(*sd, s->setup.compass_sd_rad);
	return true;
}

/* Is this way to be gone: it alone was asked for, or any? */
static bool may(const fuse_start *s, fuse_align way)
{
	return s->setup.way == way || (s->setup.way == FUSE_ALIGN_AUTO && way != FUSE_ALIGN_GIVEN);
}

/* Heading by other means than roll and pitch: best first. `last`: the compass too, which moving would make needless. */
static bool find_heading(const fuse_start *s, const double rp[static 2], bool last, double *heading,
                         double *sd, const char **way)
{
	if (may(s, FUSE_ALIGN_GIVEN)) {
		*heading = s->setup.heading_rad;
		*sd = s->setup.heading_sd_rad;
		*way = "given heading";
		return true;
	}
	if (may(s, FUSE_ALIGN_GNSS) && is_fresh(s, s->has_heading, &s->heading)) {
		*heading = s->heading.heading.heading_rad;
		*sd = USED_TWICE * s->heading.heading.sd_rad;
		*way = "heading of two antennas";
		return true;
	}
	*way = "compass";
	return (s->setup.way == FUSE_ALIGN_MAGNETIC || (last && may(s, FUSE_ALIGN_MAGNETIC))) &&
	       compass_heading(s, rp, heading, sd);
}

/* The bias of the gyros is what they read at rest less the rotation of the Earth. */
static void bias_at_rest(const fuse_start *s, const fw_stillness_means *m, const double q_n_b[static 4],
                         double heading_sd, finding *f)
{
	static const double still[3];
	double C[3][3], omega_ie_b[3];
	fw_earth earth;
	fw_quat_to_matrix(q_n_b, C);
	fw_earth_at(s->fix.fix.llh, still, &earth);
	fw_mat3_t_vec(C, earth.omega_ie_n, omega_ie_b);
	const double turned = earth.omega_ie_n[0] * fmin(heading_sd, 1.4),
	             sd = hypot(hypot(2 * s->setup.imu.gyro_noise / sqrt(m->seconds), turned),
	                        s->setup.gyro_bias_walk);
	for (int i = 0; i < 3; i++) {
		if (!(sd < f->bias_sd[i]))
			continue;
		f->bias[i] = m->omega_ib_b[i] - omega_ie_b[i];
		f->bias_sd[i] = sd;
	}
}

static fw_status find_still(const fuse_start *s, bool last, finding *f)
{
	const fw_stillness_means *m = &s->standing.means;
	double rp[2], sd[2], heading = 0, heading_sd = 1.8; /* sigma of a heading that can be any */
	fw_alignment a;
	if (!s->standing.known || m->seconds < 1)
		return FW_MORE;
	const double gravity = fw_gravity_mps2(s->fix.fix.llh[0], s->fix.fix.llh[2]);
	if (fw_align_level(m->force_b, m->seconds, gravity, &s->setup.imu, rp, sd) != FW_OK)
		return FW_MORE;
	const char *way = "heading unknown";
	const bool known = find_heading(s, rp, last, &heading, &heading_sd, &way);
	if (!known && may(s, FUSE_ALIGN_GYROCOMPASS) &&
	    fw_align_gyrocompass(m->force_b, m->omega_ib_b, m->seconds, s->fix.fix.llh, &s->setup.imu,
	                         s->setup.limit_rad, &a) == FW_OK) {
		set_finding(&a, USED_TWICE, s->standing.until, "gyrocompass", f);
		return FW_OK;
	}
	if (!known && !(last && s->setup.way == FUSE_ALIGN_AUTO))
		return FW_MORE;
	const double rpy[3] = {rp[0], rp[1], heading}, rpy_sd[3] = {sd[0], sd[1], heading_sd};
	if (fw_align_from_angles(rpy, rpy_sd, &a) != FW_OK)
		return FW_MORE;
	set_finding(&a, 1, s->standing.until, known ? way : "heading unknown", f);
	bias_at_rest(s, m, a.q_n_b, heading_sd, f);
	return FW_OK;
}

/* An answer that does not get better while the vehicle moves is good enough in the end. */
static fw_status find_motion(fuse_start *s, bool last, finding *f)
{
	fw_align_motion_answer answer;
	if (!may(s, FUSE_ALIGN_MOTION) || fw_align_motion_solve(&s->motion, &answer) != FW_OK)
		return FW_MORE;
	const double limit =
	    last ? COARSEST : fmin(s->setup.limit_rad * (1 + s->moving_s / PATIENCE_S), COARSEST);
	for (int i = 0; i < 3; i++)
		if (!(USED_TWICE * answer.attitude.sd_rad[i] < limit))
			return FW_MORE;
	set_finding(&answer.attitude, USED_TWICE, answer.t, "motion", f);
	for (int i = 0; i < 3; i++) {
		if (!(USED_TWICE * answer.gyro_bias_sd[i] < f->bias_sd[i]))
			continue;
		f->bias[i] = answer.gyro_bias[i];
		f->bias_sd[i] = hypot(USED_TWICE * answer.gyro_bias_sd[i], s->setup.gyro_bias_walk);
	}
	return FW_OK;
}

/* Roll and pitch that turn the force that GNSS saw, in a frame turned by the heading, into the one that the IMU saw. */
static bool level_by_push(const fuse_push *p, double heading, double rp[static 2])
{
	const double c = cos(heading), s = sin(heading), *n = p->force_n, *b = p->force_b;
	const double h[3] = {c * n[0] + s * n[1], -s * n[0] + c * n[1], n[2]};
	const double across = hypot(b[1], b[2]);
	if (!(across > 1 && fabs(h[1]) < across))
		return false;
	rp[0] = asin(h[1] / across) - atan2(b[1], -b[2]);
	const double z = b[1] * sin(rp[0]) + b[2] * cos(rp[0]), along = hypot(b[0], z);
	if (!(fabs(h[0]) < along))
		return false;
	rp[1] = atan2(b[0], -z) - asin(h[0] / along);
	rp[0] = fw_wrap_pi(rp[0]);
	return fabs(rp[1]) < FW_PI / 2;
}

static fw_status find_moving(const fuse_start *s, bool last, finding *f)
{
	const double waited = fw_time_diff_s(s->last, reading_at(s, s->first_reading)->time);
	double rp[2] = {0}, heading, sd;
	const char *way;
	fw_alignment a;
	if (!s->push.known || s->last.ns - s->push.time.ns > FRESH_NS || (!last && waited < PATIENCE_S))
		return FW_MORE;
	if (s->setup.wheels && may(s, FUSE_ALIGN_MOTION) && is_velocity(&s->fix) &&
	    fw_align_course(s->fix.fix.velocity_mps, horizontal_sd(s->fix.fix.R_velocity), &heading, &sd) ==
	        FW_OK) {
		sd = hypot(sd, 3 * DEG);
		way = "course";
		if (sd > 10 * DEG)
			return FW_MORE;
	} else if (!find_heading(s, rp, last, &heading, &sd, &way)) {
		return FW_MORE;
	}
	for (int pass = 0; pass < 2; pass++) { /* the compass wants to know roll and pitch */
		if (!level_by_push(&s->push, heading, rp))
			return FW_MORE;
		if (strcmp(way, "compass") == 0 && !compass_heading(s, rp, &heading, &sd))
			return FW_MORE;
	}
	const double rpy[3] = {rp[0], rp[1], heading}, rpy_sd[3] = {PUSH_LEVEL_SD, PUSH_LEVEL_SD, sd};
	if (fw_align_from_angles(rpy, rpy_sd, &a) != FW_OK)
		return FW_MORE;
	set_finding(&a, 1, s->push.time, way, f);
	return FW_OK;
}

/* ---- back to the beginning ---- */

/* How far back the attitude can be carried before the gyros have spoiled it [s]. */
static double carry_s(const finding *f, double gyro_noise)
{
	const double sd = f->heading_sd, most = fmin(fmax(3 * sd, 2 * DEG), fmax(1.2 * sd, 10 * DEG)),
	             room = fmax(most * most - sd * sd, 0),
	             bias = fmax(f->bias_sd[0], fmax(f->bias_sd[1], f->bias_sd[2])), b2 = bias * bias,
	             n2 = gyro_noise * gyro_noise;
	/* b2 t^2 + n2 t = room */
	return b2 > 0 ? (-n2 + sqrt(n2 * n2 + 4 * b2 * room)) / (2 * b2) : n2 > 0 ? room / n2 : 1e9;
}

/* How far a fix is from where another one and its velocity lead [m], NED. */
static void apart(const fw_item *a, const fw_item *b, double ned[static 3])
{
	const double dt = fw_time_diff_s(b->time, a->time);
	displacement(a->fix.llh, b->fix.llh, ned);
	for (int i = 0; is_velocity(a) && i < 3; i++)
		ned[i] -= a->fix.velocity_mps[i] * dt;
}

/* Do two fixes belong to one way? A wrong one shall not be where all begins. */
static bool agree(const fw_item *a, const fw_item *b)
{
	double off[3];
	apart(a, b, off);
	const double dt = fabs(fw_time_diff_s(b->time, a->time)),
	             room = 2 + (is_velocity(a) ? 1 : 35) * dt + 3 * dt * dt,
	             sd_h = hypot(horizontal_sd(a->fix.R_position), horizontal_sd(b->fix.R_position)),
	             sd_v = sqrt(a->fix.R_position[2][2] + b->fix.R_position[2][2]);
	return hypot(off[0], off[1]) < room + 5 * sd_h && fabs(off[2]) < room + 5 * sd_v;
}

/* The fix after number `after`; end_item: none. */
static uint64_t next_fix(const fuse_start *s, uint64_t after)
{
	uint64_t i = after + 1;
	while (i < s->end_item && !is_fix(item_at(s, i)))
		i++;
	return i;
}

static bool is_credible(const fuse_start *s, uint64_t number)
{
	int others = 0, agreeing = 0;
	for (uint64_t i = next_fix(s, number); i < s->end_item && others < 3; i = next_fix(s, i)) {
		others++;
		agreeing += agree(item_at(s, number), item_at(s, i));
	}
	return others == 0 || 2 * agreeing > others;
}

/* The first fix that can be begun with; end_item: none. *strays counts those that were passed over. */
static uint64_t first_fix(const fuse_start *s, fw_time not_before, unsigned *strays)
{
	*strays = 0;
	for (uint64_t i = s->first_item; i < s->end_item; i++) {
		const fw_item *item = item_at(s, i);
		if (!is_fix(item) || item->time.ns < not_before.ns || item->time.ns > s->last.ns)
			continue;
		if (is_credible(s, i))
			return i;
		++*strays;
	}
	return s->end_item;
}

/* The last reading at or before t; the first one if there is none. */
static uint64_t reading_before(const fuse_start *s, fw_time t)
{
	uint64_t low = s->first_reading, high = s->end_reading;
	while (high - low > 1) {
		const uint64_t middle = low + (high - low) / 2;
		if (reading_at(s, middle)->time.ns <= t.ns)
			low = middle;
		else
			high = middle;
	}
	return low;
}

/* Carries the attitude from one reading back to an earlier one. */
static void carry_back(const fuse_start *s, const finding *f, uint64_t from, uint64_t to, double q[static 4])
{
	fw_earth earth;
	const double *v = is_velocity(&s->fix) ? s->fix.fix.velocity_mps : (const double[3]){0};
	fw_earth_at(s->fix.fix.llh, v, &earth);
	for (uint64_t i = from; i > to; i--) {
		const fw_imu_reading *r = reading_at(s, i);
		const double dt = fw_time_diff_s(r->time, reading_at(s, i - 1)->time);
		double body[3], nav[3], dq[4], p[4];
		for (int k = 0; k < 3; k++) {
			body[k] = -(r->gyro_radps[k] - f->bias[k]) * dt;
			nav[k] = (earth.omega_ie_n[k] + earth.omega_en_n[k]) * dt;
		}
		fw_quat_from_rotvec(body, dq);
		fw_quat_mul(q, dq, p);
		fw_quat_from_rotvec(nav, dq);
		fw_quat_mul(dq, p, q);
		(void)!fw_quat_normalise(q);
	}
}

/* Velocity of the antenna at a fix, with its sigma: its own, or none while standing still, or that to the next fix. */
static void velocity_at(const fuse_start *s, uint64_t number, double v[static 3], double sd[static 3])
{
	const fw_item *fix = item_at(s, number);
	if (is_velocity(fix)) {
		for (int i = 0; i < 3; i++) {
			v[i] = fix->fix.velocity_mps[i];
			sd[i] = fmin(2 * sqrt(fmax(fix->fix.R_velocity[i][i], 0)), 10) + 0.05;
		}
		return;
	}
	for (uint64_t i = number + 1; i < s->end_item; i++) {
		const fw_item *next = item_at(s, i);
		const double dt = fw_time_diff_s(next->time, fix->time);
		if (!is_fix(next) || !(dt > 0.05))
			continue;
		displacement(fix->fix.llh, next->fix.llh, v);
		for (int k = 0; k < 3; k++) {
			v[k] = fmin(fmax(v[k] / dt, -100), 100);
			sd[k] = 0.5 + 2 * dt + 3 * sqrt(fmax(fix->fix.R_position[k][k], 0)) / dt;
			sd[k] = fmin(sd[k], 50);
		}
		return;
	}
	for (int k = 0; k < 3; k++) {
		v[k] = 0;
		sd[k] = s->stillness.still ? 0.2 : 10;
	}
}

/* From the antenna at a fix to the IMU at the reading before it. */
static void place(const fuse_start *s, uint64_t number, uint64_t at, fuse_beginning *b)
{
	const fw_item *fix = item_at(s, number);
	const fw_imu_reading *r = reading_at(s, at);
	const double *l = s->setup.lever_b, *w = r->gyro_radps;
	const double swing_b[3] = {w[1] * l[2] - w[2] * l[1], w[2] * l[0] - w[0] * l[2],
	                           w[0] * l[1] - w[1] * l[0]};
	const double since = fw_time_diff_s(fix->time, r->time);
	double C[3][3], lever_n[3], swing_n[3], v[3], off[3] = {0};
	fw_earth earth;
	fw_quat_to_matrix(b->pva.q_n_b, C);
	fw_mat3_vec(C, l, lever_n);
	fw_mat3_vec(C, swing_b, swing_n);
	velocity_at(s, number, v, b->velocity_sd);
	if (next_fix(s, number) < s->end_item) /* which of the two is wrong? */
		apart(fix, item_at(s, next_fix(s, number)), off);
	fw_earth_at(fix->fix.llh, v, &earth);
	b->pva.time = since >= 0 ? r->time : fix->time; /* within the interval of the first reading */
	for (int i = 0; i < 3; i++) {
		b->pva.velocity_mps[i] = v[i] - swing_n[i];
		lever_n[i] += v[i] * fmax(since, 0);
		b->position_sd[i] =
		    fmax(fmin(2 * sqrt(fix->fix.R_position[i][i]), 1000) + 0.05, fabs(off[i]));
	}
	b->pva.llh[0] = fix->fix.llh[0] - lever_n[0] / earth.M_m;
	b->pva.llh[1] = fw_wrap_pi(fix->fix.llh[1] - lever_n[1] / (earth.N_m * earth.cos_lat));
	b->pva.llh[2] = fix->fix.llh[2] + lever_n[2];
}

static fw_status begin_with(const fuse_start *s, finding *f, fuse_beginning *b)
{
	const fw_time first =
	    fw_time_add_ns(reading_at(s, s->first_reading)->time, -llround(1.5 * s->interval_s * 1e9));
	const double back_s = fmin(carry_s(f, s->setup.imu.gyro_noise), fw_time_diff_s(f->t, first) + 1);
	fw_time not_before = fw_time_add_ns(f->t, -llround(back_s * 1e9));
	if (not_before.ns < first.ns)
		not_before = first;
	unsigned strays;
	const uint64_t number = first_fix(s, not_before, &strays);
	if (number == s->end_item)
		return FW_MORE;
	const uint64_t at = reading_before(s, item_at(s, number)->time), from = reading_before(s, f->t);
	*b = (fuse_beginning){.way = f->way, .has_gyro_bias = true, .stray_fixes = strays};
	memcpy(b->pva.q_n_b, f->q_n_b, sizeof f->q_n_b);
	carry_back(s, f, from, at, b->pva.q_n_b);
	const double carried = at < from ? fw_time_diff_s(f->t, reading_at(s, at)->time) : 0,
	             noise = s->setup.imu.gyro_noise;
	for (int i = 0; i < 3; i++) {
		b->attitude_sd[i] =
		    sqrt(f->sd[i] * f->sd[i] + pow(f->bias_sd[i] * carried, 2) + noise * noise * carried);
		b->gyro_bias[i] = f->bias[i];
		b->gyro_bias_sd[i] = f->bias_sd[i];
	}
	b->heading_sd_rad = b->attitude_sd[2];
	place(s, number, at, b);
	return FW_OK;
}

fw_status fuse_start_try(fuse_start *s, bool last, fuse_beginning *b)
{
	finding f = {
	    .bias_sd = {s->setup.imu.gyro_bias_sd, s->setup.imu.gyro_bias_sd, s->setup.imu.gyro_bias_sd}};
	if (!has_reading(s) || !s->has_fix)
		return FW_MORE;
	last |= s->end_reading - s->first_reading == FUSE_START_READINGS;
	if (find_still(s, false, &f) != FW_OK && find_motion(s, last, &f) != FW_OK &&
	    find_moving(s, last, &f) != FW_OK && (!last || find_still(s, true, &f) != FW_OK))
		return FW_MORE;
	if (s->rest.known && strcmp(f.way, "gyrocompass") != 0)
		bias_at_rest(s, &s->rest.means, f.q_n_b, 1.4, &f);
	return begin_with(s, &f, b);
}

const char *fuse_start_lacks(const fuse_start *s)
{
	if (!has_reading(s))
		return "no IMU sample";
	if (!s->has_fix)
		return "no position";
	return "heading not found";
}

/* ---- the way over what was kept ---- */

void fuse_start_replay(fuse_start *s, fw_time begin, void (*early)(void *context, const fuse_entry *e),
                       void (*take)(void *context, const fuse_entry *e), void *context)
{
	fuse_entry e;
	while (s->first_item < s->end_item || s->first_reading < s->end_reading) {
		e.is_imu = s->first_item == s->end_item ||
		           (s->first_reading < s->end_reading &&
		            reading_at(s, s->first_reading)->time.ns < item_at(s, s->first_item)->time.ns);
		if (e.is_imu)
			e.imu = *reading_at(s, s->first_reading++);
		else
			e.item = *item_at(s, s->first_item++);
		if (fuse_entry_time(&e).ns >= begin.ns + e.is_imu)
			take(context, &e);
		else if (!e.is_imu)
			early(context, &e);
	}
}
