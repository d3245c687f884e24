/* Many simulated flights through the filter, in memory: for Monte Carlo campaigns and the search for settings.
 *
 *     campaign SCENARIO.ini [--seeds FIRST-LAST] [--set SECTION.KEY=VALUE] [--smooth]
 *              [--report sections|consistency|outages|heading] [--withhold EVERY:LENGTH:FIRST] < settings
 *
 * Each line of the input is a list of settings of the filter, KEY=VALUE with blanks between, KEY as insgnss-fuse
 * calls it. For each line all flights are flown, and one line of figures comes out, at once. A flight is that of the
 * scenario: motion, IMU, and fixes whose errors are those of the [pvt] sections, with protection levels of [pvt] k_h
 * and k_v times sigma; for --report heading its magnetometer and the heading of its two antennas as well, with its
 * faults. The filter begins at the truth plus errors that it is told the sigma of, with the position and velocity of
 * the first fix. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "base/random.h"
#include "base/stats.h"
#include "cli/scenario.h"
#include "formats/number.h"
#include "fusion/loose.h"
#include "fusion/rts.h"
#include "ins/magnetic_field.h"
#include "sim/process.h"

#define DEG (FW_PI / 180)

/* What the filter is told of the attitude at its start, and what is drawn for it. */
#define START_LEVEL_SD   (0.3 * DEG)
#define START_HEADING_SD (3.0 * DEG)

enum { SECTIONS_MAX = 32, NODES_STEP = 4096, SETTING_MAX = 64 };

static tool self = {.name = "campaign"};

/* ---- what is wanted ---- */

enum report { SECTIONS, CONSISTENCY, OUTAGES, HEADING };

static struct {
	bool smooth;
	double every_s, length_s, first_s; /* fixes are withheld; every_s 0: none */
	enum report report;
} wanted = {0};

/* ---- what is flown ---- */

typedef struct {
	fw_imu_reading *imu;      /* n of them, at k / rate, k = 1..n */
	fw_item *fix;             /* n_fixes */
	fw_item *heading;         /* with each fix; NULL: none wanted */
	fw_item *field;           /* of the magnetometer, n_fields */
	fw_imu errors;            /* biases and scale factors of the sensors, as they began */
	double attitude_error[3]; /* of the start, in sigmas */
} flight;

static struct {
	scenario s;
	fw_receiver_setup base;
	fw_trajectory path;
	int rate_hz, n, every; /* IMU samples; a fix comes with every so many of them */
	int n_fixes;
	int field_every, n_fields;                   /* the same of the magnetometer */
	fw_pva *truth;                               /* n + 1 */
	double (*omega)[3], (*force)[3], (*turn)[3]; /* turn: omega_ib_b at the moment */
	flight *flights;
	int first_seed, n_flights;
} world;

static void *need(void *memory)
{
	if (memory != NULL)
		return memory;
	fputs("campaign: no memory\n", stderr);
	exit(EXIT_IO);
}

static fw_time at_sample(int k)
{
	return fw_time_add_ns(world.s.start, llround((double)k / world.rate_hz * 1e9));
}

/* The truth, once for all flights. */
static void fly_truth(void)
{
	world.rate_hz = (int)lround(world.s.imu_rate_hz);
	world.n = (int)(world.s.duration_s * world.rate_hz + 1e-6);
	world.every = (int)lround(world.s.imu_rate_hz / world.s.gnss_rate_hz);
	world.n_fixes = world.n / world.every + 1;
	if (wanted.report == HEADING) {
		world.field_every = (int)lround(world.s.imu_rate_hz / world.s.mag_rate_hz);
		world.n_fields = world.n / world.field_every + 1;
	}
	world.truth = need(calloc((size_t)world.n + 1, sizeof world.truth[0]));
	world.omega = need(calloc((size_t)world.n + 1, sizeof world.omega[0]));
	world.force = need(calloc((size_t)world.n + 1, sizeof world.force[0]));
	world.turn = need(calloc((size_t)world.n + 1, sizeof world.turn[0]));
	for (int k = 0; k <= world.n; k++) {
		fw_motion m;
		fw_pva *p = &world.truth[k];
		if (fw_trajectory_at(&world.path, (double)k / world.rate_hz, &m) < 0 ||
		    (k > 0 &&
		     fw_trajectory_average(&world.path, (k - 1.0) / world.rate_hz, (double)k / world.rate_hz,
		                           world.omega[k], world.force[k]) < 0)) {
			fputs("campaign: the trajectory ends too early\n", stderr);
			exit(EXIT_USAGE);
		}
		p->time = at_sample(k);
		p->llh[0] = m.lat_rad;
		p->llh[1] = m.lon_rad;
		p->llh[2] = m.height_m;
		memcpy(p->velocity_mps, m.velocity_ned_mps, sizeof p->velocity_mps);
		fw_quat_from_matrix(m.C_n_b, p->q_n_b);
		memcpy(world.turn[k], m.omega_ib_b_radps, sizeof world.turn[k]);
	}
}

static const fw_pvt_section *section_at(double t_s)
{
	const fw_pvt_setup *p = &world.s.rover.pvt;
	for (unsigned i = 0; i < p->n_sections; i++)
		if (fw_window_holds(p->section[i].window, t_s))
			return &p->section[i];
	return &p->section[p->n_sections - 1];
}

/* Where the antenna is, and how fast: lever arm turned, rotation against the Earth times lever arm. */
static void antenna_of(int k, double offset_n[static 3], double velocity_n[static 3])
{
	const fw_pva *p = &world.truth[k];
	const double *lever = world.s.lever_m;
	double C[3][3], w[3], earth_b[3], swept[3];
	fw_earth e;
	fw_quat_to_matrix(p->q_n_b, C);
	fw_earth_at(p->llh, p->velocity_mps, &e);
	const double earth_n[3] = {e.omega_ie_n[0] + e.omega_en_n[0], e.omega_ie_n[1] + e.omega_en_n[1],
	                           e.omega_ie_n[2] + e.omega_en_n[2]};
	fw_mat3_t_vec(C, earth_n, earth_b);
	for (int i = 0; i < 3; i++)
		w[i] = world.turn[k][i] - earth_b[i];
	swept[0] = w[1] * lever[2] - w[2] * lever[1];
	swept[1] = w[2] * lever[0] - w[0] * lever[2];
	swept[2] = w[0] * lever[1] - w[1] * lever[0];
	fw_mat3_vec(C, lever, offset_n);
	fw_mat3_vec(C, swept, velocity_n);
}

static void make_fix(int k, const fw_gm1 error[static 6], fw_item *item)
{
	const fw_pva *p = &world.truth[k];
	const fw_pvt_section *s = section_at((double)k / world.rate_hz);
	double offset[3], velocity[3];
	fw_earth e;
	antenna_of(k, offset, velocity);
	fw_earth_at(p->llh, p->velocity_mps, &e);
	*item = (fw_item){.time = p->time, .kind = FW_ITEM_FIX};
	item->fix.has_position = item->fix.has_velocity = true;
	for (int i = 0; i < 3; i++) {
		item->fix.R_position[i][i] = i < 2 ? s->horizontal_m2 : s->vertical_m2;
		item->fix.R_velocity[i][i] = i < 2 ? s->horizontal_m2ps2 : s->vertical_m2ps2;
		offset[i] += sqrt(item->fix.R_position[i][i]) * error[i].value;
		item->fix.velocity_mps[i] =
		    p->velocity_mps[i] + velocity[i] + sqrt(item->fix.R_velocity[i][i]) * error[3 + i].value;
	}
	item->fix.llh[0] = p->llh[0] + offset[0] / e.M_m;
	item->fix.llh[1] = p->llh[1] + offset[1] / (e.N_m * e.cos_lat);
	item->fix.llh[2] = p->llh[2] - offset[2];
}

/* Of an antenna pair: half of the variance stays for the time of multipath, as sim/receiver.h has it. HDOP is that of
 * an open sky. Where the scenario takes the heading away the sigma is 0. */
#define HDOP 0.8
static void make_headings(flight *f, fw_random *r)
{
	const fw_receiver_setup *s = &world.s.rover;
	const double *b = s->baseline_b_m, length = sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
	fw_gm1 slow;
	fw_gm1_init(&slow, 1, r);
	f->heading = need(calloc((size_t)world.n_fixes, sizeof f->heading[0]));
	for (int j = 0; j < world.n_fixes; j++) {
		const fw_pva *p = &world.truth[j * world.every];
		fw_item *item = &f->heading[j];
		double rpy[3];
		const double sd = s->attitude_noise_m * HDOP / length,
		             error = sqrt(0.5) * (slow.value + fw_random_normal(r));
		fw_quat_to_euler(p->q_n_b, rpy);
		*item = (fw_item){.time = p->time, .kind = FW_ITEM_HEADING};
		item->heading.heading_rad = fw_wrap_2pi(rpy[2] + sd * error);
		if (!fw_faults_hold(s->fault, s->n_faults, FW_FAULT_NO_ATTITUDE, s->station,
		                    j / world.s.gnss_rate_hz))
			item->heading.sd_rad = sd;
		fw_gm1_step(&slow, 1, s->noise.multipath_tau_s, 1 / world.s.gnss_rate_hz, r);
	}
}

static void make_fields(flight *f, fw_random *r)
{
	fw_magnetometer m;
	f->field = need(calloc((size_t)world.n_fields, sizeof f->field[0]));
	if (fw_magnetometer_init(&world.s.mag, fw_random_u64(r), &m) < 0)
		exit(EXIT_USAGE);
	for (int j = 0; j < world.n_fields; j++) {
		const fw_pva *p = &world.truth[j * world.field_every];
		double field[3], C[3][3];
		if (fw_magnetic_field(p->llh, p->time, field) < 0)
			exit(EXIT_USAGE);
		fw_quat_to_matrix(p->q_n_b, C);
		f->field[j] = (fw_item){.time = p->time, .kind = FW_ITEM_FIELD};
		fw_magnetometer_sample(&m, (const double(*)[3])C, field, f->field[j].field.b_ut);
	}
}

static void make_flight(flight *f, int seed)
{
	fw_gm1 error[6];
	fw_random r;
	fw_imu imu;
	fw_random_init(&r, (uint64_t)seed);
	f->imu = need(calloc((size_t)world.n + 1, sizeof f->imu[0]));
	f->fix = need(calloc((size_t)world.n_fixes, sizeof f->fix[0]));
	if (fw_imu_init(&world.s.imu, 1.0 / world.rate_hz, fw_random_u64(&r), &imu) < 0) {
		fputs("campaign: [imu]: numbers that are no sensor\n", stderr);
		exit(EXIT_USAGE);
	}
	f->errors = imu;
	for (int i = 0; i < 3; i++)
		f->attitude_error[i] = fw_random_normal(&r);
	for (int i = 0; i < 6; i++)
		fw_gm1_init(&error[i], 1, &r);
	for (int k = 1; k <= world.n; k++) {
		f->imu[k].time = at_sample(k);
		fw_imu_sample(&imu, world.omega[k], world.force[k], f->imu[k].gyro_radps,
		              f->imu[k].accel_mps2);
	}
	for (int j = 0; j < world.n_fixes; j++) {
		make_fix(j * world.every, error, &f->fix[j]);
		for (int i = 0; i < 6; i++)
			fw_gm1_step(&error[i], 1, world.s.rover.pvt.section_tau_s, 1 / world.s.gnss_rate_hz,
			            &r);
	}
	if (wanted.report == HEADING) {
		make_headings(f, &r);
		make_fields(f, &r);
	}
}

/* ---- settings ---- */

#define IN(member) offsetof(fw_loose_options, member)

/* Those of insgnss-fuse's settings that are searched over. `n` of the same value in a row. */
static const struct {
	const char *name;
	size_t offset;
	int n;
	double unit;
} keys[] = {
    {"gyro-noise", IN(gyro_noise), 1, DEG / 60},
    {"gyro-bias", IN(gyro_bias_sd), 1, DEG / 3600},
    {"gyro-walk", IN(gyro_bias_walk), 1, DEG / 3600},
    {"gyro-tau", IN(gyro_bias_tau_s), 1, 1},
    {"accel-noise", IN(accel_noise), 1, 9.80665e-6},
    {"accel-bias", IN(accel_bias_sd), 1, 9.80665e-3},
    {"accel-walk", IN(accel_bias_walk), 1, 9.80665e-6},
    {"accel-tau", IN(accel_bias_tau_s), 1, 1},
    {"gyro-scale", IN(gyro_scale_sd), 1, 1e-6},
    {"accel-scale", IN(accel_scale_sd), 1, 1e-6},
    {"gyro-matrix", IN(gyro_matrix), 1, 1e-6},
    {"accel-matrix", IN(accel_matrix), 1, 1e-6},
    {"position-sd-h", IN(position_sd[0]), 2, 1},
    {"position-sd-v", IN(position_sd[2]), 1, 1},
    {"velocity-sd-h", IN(velocity_sd[0]), 2, 1},
    {"velocity-sd-v", IN(velocity_sd[2]), 1, 1},
    {"hul", IN(adapt.hul_m), 1, 1},
    {"vul", IN(adapt.vul_m), 1, 1},
    {"tau1", IN(adapt.tau1), 1, 1},
    {"tau2", IN(adapt.tau2), 1, 1},
    {"tau3", IN(adapt.tau3), 1, 1},
    {"tau4", IN(adapt.tau4), 1, 1},
    {"gm-tau", IN(adapt.gm_tau_s), 1, 1},
    {"gm-k-h", IN(adapt.gm_k_h), 1, 1},
    {"gm-k-v", IN(adapt.gm_k_v), 1, 1},
    {"gm-share", IN(adapt.gm_share), 1, 1},
    {"vb-memory", IN(adapt.vb_memory), 1, 1},
    {"student-dof", IN(adapt.student_dof), 1, 1},
    {"still-sd", IN(still_sd_mps), 1, 1},
    {"compass-sd", IN(field_sd_rad), 1, DEG},
    {"gate", IN(gate), 1, 1},
};

static bool set_mode(const char *value, fw_adapt_mode *mode)
{
	static const char *const names[] = {"none", "pl", "gm", "vb", "student"};
	for (int i = 0; i < 5; i++) {
		if (strcmp(value, names[i]) == 0) {
			*mode = (fw_adapt_mode)i;
			return true;
		}
	}
	return false;
}

/* One KEY=VALUE. */
static bool set_one(const char *word, fw_loose_options *o)
{
	const char *equals = strchr(word, '=');
	double v;
	if (equals == NULL)
		return false;
	const size_t length = (size_t)(equals - word);
	if (strncmp(word, "adapt", length) == 0 && length == 5)
		return set_mode(equals + 1, &o->adapt.mode);
	if (strncmp(word, "compass", length) == 0 && length == 7) {
		o->use_field = strcmp(equals + 1, "yes") == 0;
		return true;
	}
	if (strncmp(word, "still", length) == 0 && length == 5) {
		o->use_still = strcmp(equals + 1, "yes") == 0;
		return true;
	}
	if (fw_get_double(equals + 1, strlen(equals + 1), &v) != FW_OK)
		return false;
	for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
		if (strlen(keys[i].name) != length || strncmp(word, keys[i].name, length) != 0)
			continue;
		double *to = (double *)(void *)((char *)o + keys[i].offset);
		for (int k = 0; k < keys[i].n; k++)
			to[k] = v * keys[i].unit;
		return true;
	}
	return false;
}

/* The IMU of the scenario as a filter is told of it: what wanders in it becomes one Gauss-Markov process. */
static void know_sensors(fw_loose_options *o)
{
	const fw_triad_model *g = &world.s.imu.gyro, *a = &world.s.imu.accel;
	o->gyro_noise = fmax(g->white, 1e-9);
	o->accel_noise = fmax(a->white, 1e-9);
	o->gyro_bias_sd = g->bias_sd;
	o->accel_bias_sd = a->bias_sd;
	o->gyro_bias_walk = hypot(g->flicker, g->markov_sd);
	o->accel_bias_walk = hypot(a->flicker, a->markov_sd);
	o->gyro_matrix = hypot(g->scale_sd, g->misalignment_sd);
	o->accel_matrix = hypot(a->scale_sd, a->misalignment_sd);
	if (g->markov_tau_s > 0)
		o->gyro_bias_tau_s = g->markov_tau_s;
	if (a->markov_tau_s > 0)
		o->accel_bias_tau_s = a->markov_tau_s;
}

static bool read_settings(char *line, fw_loose_options *o)
{
	char *rest = line;
	*o = fw_loose_defaults;
	know_sensors(o);
	memcpy(o->lever_b, world.s.lever_m, sizeof o->lever_b);
	for (char *word; (word = strsep(&rest, " \t\r\n")) != NULL;) {
		if (word[0] == '\0' || set_one(word, o))
			continue;
		fprintf(stderr, "campaign: '%s' is no setting\n", word);
		return false;
	}
	return true;
}

/* ---- a flight through the filter ---- */

static struct {
	fw_node *node;
	int n, room;
	fw_smoothed now, next;
} kept;

/* Number of the window of withheld fixes at a time, counted from 1; 0: none; the last moment belongs to it. */
static int outage_at(double t_s)
{
	const double since = t_s - wanted.first_s;
	if (!(wanted.every_s > 0) || since <= 0)
		return 0;
	const int which = (int)(since / wanted.every_s);
	return since - which * wanted.every_s < wanted.length_s ? which + 1 : 0;
}

/* Sums over all flights of one line of settings. Forward and smoothed. */
typedef struct {
	double sum[SECTIONS_MAX][3]; /* |error| in position, north, east, down */
	long n[SECTIONS_MAX];
	double nees_sum;           /* of nine states */
	long nees_n, inside[2][9]; /* inside one and two sigma */
	double outage_error2, outage_predicted2, heading_error2, heading_predicted2;
	long outages;
	/* Heading errors squared, of compass, compass with the table, filter: while that of GNSS is away; from a
	 * minute on. */
	double raw2, corrected2, filter2, raw2_all, corrected2_all, filter2_all;
	long headings, headings_all;
} tally;

static tally forward, smoothed;

/* Consistency at moments, over all flights: means of NEES and of NIS. */
enum { MOMENTS_MAX = 4096 };
static struct {
	double nees[MOMENTS_MAX], nis[MOMENTS_MAX];
	int n_nees[MOMENTS_MAX], n_nis[MOMENTS_MAX];
} moments;

/* The largest error within the present outage. */
typedef struct {
	int which;
	double error2, predicted2, heading2, heading_predicted2;
} worst;

static int sample_of(fw_time t)
{
	return (int)llround(fw_time_diff_s(t, world.s.start) * world.rate_hz);
}

static void close_outage(worst *w, tally *to)
{
	if (w->which > 0) {
		to->outage_error2 += w->error2;
		to->outage_predicted2 += w->predicted2;
		to->heading_error2 += w->heading2;
		to->heading_predicted2 += w->heading_predicted2;
		to->outages++;
	}
	*w = (worst){0};
}

static void note_outage(worst *w, tally *to, int which, const double e[static 9],
                        const double P[FW_STATES_MAX][FW_STATES_MAX])
{
	if (which != w->which)
		close_outage(w, to);
	w->which = which;
	if (which == 0)
		return;
	const double error2 = e[6] * e[6] + e[7] * e[7] + e[8] * e[8];
	if (error2 > w->error2) {
		w->error2 = error2;
		w->predicted2 = P[6][6] + P[7][7] + P[8][8];
	}
	if (e[2] * e[2] > w->heading2) {
		w->heading2 = e[2] * e[2];
		w->heading_predicted2 = P[2][2];
	}
}

/* Error squared over variance, of the nine states of navigation. */
static double nees_of(const double e[static 9], const double P[FW_STATES_MAX][FW_STATES_MAX])
{
	double A[81], y[9], sum = 0;
	for (int i = 0; i < 9; i++)
		for (int k = 0; k < 9; k++)
			A[9 * i + k] = P[i][k];
	if (fw_mat_solve_spd(9, 1, A, e, y) < 0)
		return (double)NAN;
	for (int i = 0; i < 9; i++)
		sum += e[i] * y[i];
	return sum;
}

/* Every second of the flight, the first 20 left out: what is asked before the start is known. */
static void note_consistency(tally *to, int k, const double e[static 9],
                             const double P[FW_STATES_MAX][FW_STATES_MAX])
{
	const int second = k / world.rate_hz;
	if (k % world.rate_hz != 0 || second < 20 || second >= MOMENTS_MAX)
		return;
	const double nees = nees_of(e, P);
	to->nees_sum += nees;
	to->nees_n++;
	if (to == &forward) {
		moments.nees[second] += nees;
		moments.n_nees[second]++;
	}
	for (int i = 0; i < 9; i++) {
		to->inside[0][i] += fabs(e[i]) <= sqrt(P[i][i]);
		to->inside[1][i] += fabs(e[i]) <= 2 * sqrt(P[i][i]);
	}
}

static void note(tally *to, worst *w, int k, const fw_pva *estimate,
                 const double P[FW_STATES_MAX][FW_STATES_MAX])
{
	const fw_layout nav = fw_layout_of(0);
	const double t_s = (double)k / world.rate_hz;
	double e[9];
	fw_estimate_difference(&nav, estimate, NULL, &world.truth[k], NULL, e);
	if (wanted.report == SECTIONS) {
		const int s = (int)(section_at(t_s) - world.s.rover.pvt.section);
		for (int i = 0; i < 3; i++)
			to->sum[s][i] += fabs(e[6 + i]);
		to->n[s]++;
	} else if (wanted.report == CONSISTENCY) {
		note_consistency(to, k, e, P);
	} else if (wanted.report == OUTAGES) {
		note_outage(w, to, outage_at(t_s), e, P);
	}
}

/* What the hooks need. */
typedef struct {
	worst now;
	double nis_before;
	uint64_t rows_before;
} progress;

/* The compass as it is, with the table's correction, and the filter's heading; at the compass's readings. */
static void note_heading(const fw_loose *l, int k)
{
	const double t_s = (double)k / world.rate_hz;
	const fw_receiver_setup *s = &world.s.rover;
	static fw_heading_table table; /* a copy: the filter's own is not to be leant over */
	double rpy[3], true_rpy[3], correction, sd;
	if (k % world.field_every != 0 || !l->has_compass || t_s < 60)
		return;
	fw_quat_to_euler(l->filter.pva.q_n_b, rpy);
	fw_quat_to_euler(world.truth[k].q_n_b, true_rpy);
	const double compass = rpy[2] + l->compass_off_rad, raw = fw_wrap_pi(compass - true_rpy[2]);
	table = l->table;
	fw_heading_table_tilt(&table, rpy);
	fw_heading_table_correction(&table, fw_wrap_2pi(compass), &correction, &sd);
	const double corrected = fw_wrap_pi(raw + correction), filter = fw_wrap_pi(rpy[2] - true_rpy[2]);
	forward.raw2_all += raw * raw;
	forward.corrected2_all += corrected * corrected;
	forward.filter2_all += filter * filter;
	forward.headings_all++;
	if (!fw_faults_hold(s->fault, s->n_faults, FW_FAULT_NO_ATTITUDE, s->station, t_s))
		return;
	forward.raw2 += raw * raw;
	forward.corrected2 += corrected * corrected;
	forward.filter2 += filter * filter;
	forward.headings++;
}

static void on_sample(void *context, const fw_loose *l)
{
	progress *p = context;
	const int k = sample_of(l->filter.pva.time);
	if (wanted.report == HEADING)
		note_heading(l, k);
	if (k % (world.rate_hz / 10) == 0)
		note(&forward, &p->now, k, &l->filter.pva, l->filter.P);
	const int second = k / world.rate_hz;
	if (wanted.report == CONSISTENCY && l->counts.nis_rows >= p->rows_before + 6 &&
	    second < MOMENTS_MAX) {
		if (second >= 20) {
			moments.nis[second] += l->counts.nis_sum - p->nis_before;
			moments.n_nis[second]++;
		}
		p->nis_before = l->counts.nis_sum;
		p->rows_before = l->counts.nis_rows;
	}
}

static void on_node(void *context, const fw_loose *l)
{
	(void)context;
	if (kept.n == kept.room) {
		kept.room += NODES_STEP;
		kept.node = need(realloc(kept.node, (size_t)kept.room * sizeof kept.node[0]));
	}
	kept.node[kept.n++] = l->node;
}

static void smooth(const fw_layout *layout)
{
	worst w = {0};
	fw_rts_last(layout, &kept.node[kept.n - 1], &kept.next);
	for (int j = kept.n - 2; j > 0; j--) {
		fw_pva pva = kept.node[j].filtered;
		double x[FW_STATES_MAX];
		memcpy(x, kept.node[j].x_filtered, sizeof x);
		if (fw_rts_step(layout, &kept.node[j], &kept.node[j + 1], &kept.next, &kept.now) != FW_OK)
			fputs("campaign: a step that cannot be smoothed\n", stderr);
		fw_estimate_add(layout, kept.now.error, &pva, x);
		note(&smoothed, &w, sample_of(kept.node[j].time), &pva, kept.now.P);
		kept.next = kept.now;
	}
	close_outage(&w, &smoothed);
}

static bool start(fw_loose *l, const flight *f)
{
	const fw_layout nav = fw_layout_of(0);
	const fw_item *first = &f->fix[0];
	const double attitude_sd[3] = {START_LEVEL_SD, START_LEVEL_SD, START_HEADING_SD};
	double position_sd[3], velocity_sd[3], offset[3], velocity[3], error[9] = {0};
	fw_pva pva = world.truth[0];
	fw_earth e;
	antenna_of(0, offset, velocity);
	fw_earth_at(pva.llh, pva.velocity_mps, &e);
	for (int i = 0; i < 3; i++) {
		position_sd[i] = sqrt(first->fix.R_position[i][i]);
		velocity_sd[i] = sqrt(first->fix.R_velocity[i][i]);
		error[i] = attitude_sd[i] * f->attitude_error[i];
		error[3 + i] = first->fix.velocity_mps[i] - pva.velocity_mps[i] - velocity[i];
	}
	error[6] = (first->fix.llh[0] - pva.llh[0]) * e.M_m - offset[0];
	error[7] = (first->fix.llh[1] - pva.llh[1]) * e.N_m * e.cos_lat - offset[1];
	error[8] = -(first->fix.llh[2] - pva.llh[2]) - offset[2];
	fw_estimate_add(&nav, error, &pva, NULL);
	return fw_loose_start(l, &pva, attitude_sd, velocity_sd, position_sd, NULL, NULL) == FW_OK;
}

static void give_levels(fw_loose *l, const fw_item *fix)
{
	const fw_pvt_setup *p = &world.s.rover.pvt;
	const fw_item levels = {.time = fix->time,
	                        .kind = FW_ITEM_LEVELS,
	                        .levels = {p->k_h * sqrt(fix->fix.R_position[0][0]),
	                                   p->k_v * sqrt(fix->fix.R_position[2][2]), FW_RELIABLE}};
	fw_loose_item(l, &levels);
}

static bool fly(const flight *f, const fw_loose_options *o)
{
	static fw_loose l;
	progress p = {0};
	const fw_loose_hooks hooks = {
	    .context = &p, .sample = on_sample, .node = wanted.smooth ? on_node : NULL};
	kept.n = 0;
	if (fw_loose_init(&l, o, &hooks) < 0 || !start(&l, f))
		return false;
	for (int k = 1, j = 1, m = 0; k <= world.n; k++) {
		for (; j < world.n_fixes && j * world.every <= k; j++) {
			if (outage_at(fw_time_diff_s(f->fix[j].time, world.s.start)) > 0)
				continue;
			give_levels(&l, &f->fix[j]);
			fw_loose_item(&l, &f->fix[j]);
			if (f->heading != NULL && f->heading[j].heading.sd_rad > 0)
				fw_loose_item(&l, &f->heading[j]);
		}
		for (; m < world.n_fields && m * world.field_every <= k; m++)
			fw_loose_item(&l, &f->field[m]);
		if (fw_loose_imu(&l, &f->imu[k]) < 0)
			return false;
	}
	close_outage(&p.now, &forward);
	if (wanted.smooth)
		smooth(&l.filter.model.layout);
	return true;
}

/* ---- figures ---- */

static void print_sections(const tally *t)
{
	for (unsigned s = 0; s < world.s.rover.pvt.n_sections; s++)
		for (int i = 0; i < 3; i++)
			printf(" %.4f", t->sum[s][i] / (double)t->n[s]);
}

/* Share of moments at which the mean over all flights lies inside its 95 % band, and the mean of all. */
static void print_band(const char *name, const double sum[static MOMENTS_MAX],
                       const int n[static MOMENTS_MAX], int dof)
{
	double total = 0;
	int inside = 0, all = 0, flights = 0;
	for (int i = 0; i < MOMENTS_MAX; i++) {
		if (n[i] == 0)
			continue;
		/* a chi-square of so many degrees of freedom is normal to three digits */
		const double mean = sum[i] / n[i], half = 1.96 * sqrt(2.0 * dof / n[i]);
		inside += fabs(mean - dof) <= half;
		total += mean;
		flights = n[i];
		all++;
	}
	const double half = 1.96 * sqrt(2.0 * dof / flights);
	printf(" %s=%.4f %s-low=%.4f %s-high=%.4f %s-share=%.4f", name, total / all, name, dof - half, name,
	       dof + half, name, (double)inside / all);
}

static void print_consistency(const tally *t)
{
	static const char *const names[9] = {"att-n", "att-e", "att-d", "vel-n", "vel-e",
	                                     "vel-d", "pos-n", "pos-e", "pos-d"};
	printf(" nees9=%.4f", t->nees_sum / (double)t->nees_n);
	for (int i = 0; i < 9; i++)
		printf(" %s=%.4f,%.4f", names[i], (double)t->inside[0][i] / (double)t->nees_n,
		       (double)t->inside[1][i] / (double)t->nees_n);
}

static void print_outages(const tally *t)
{
	const double n = (double)t->outages;
	printf(" outages=%ld rms=%.5f predicted=%.5f heading-deg=%.6f heading-predicted-deg=%.6f", t->outages,
	       sqrt(t->outage_error2 / n), sqrt(t->outage_predicted2 / n), sqrt(t->heading_error2 / n) / DEG,
	       sqrt(t->heading_predicted2 / n) / DEG);
}

static void print_heading(const tally *t)
{
	const double n = (double)t->headings, all = (double)t->headings_all;
	printf(" outage-compass=%.4f outage-corrected=%.4f outage-filter=%.4f compass=%.4f corrected=%.4f "
	       "filter=%.4f",
	       sqrt(t->raw2 / n) / DEG, sqrt(t->corrected2 / n) / DEG, sqrt(t->filter2 / n) / DEG,
	       sqrt(t->raw2_all / all) / DEG, sqrt(t->corrected2_all / all) / DEG,
	       sqrt(t->filter2_all / all) / DEG);
}

static void print_tally(const tally *t)
{
	if (wanted.report == SECTIONS)
		print_sections(t);
	else if (wanted.report == CONSISTENCY)
		print_consistency(t);
	else if (wanted.report == OUTAGES)
		print_outages(t);
	else
		print_heading(t);
}

static void fly_all(const fw_loose_options *o)
{
	forward = smoothed = (tally){0};
	memset(&moments, 0, sizeof moments);
	for (int i = 0; i < world.n_flights; i++) {
		if (!fly(&world.flights[i], o)) {
			printf("failed\n");
			return;
		}
	}
	printf("forward");
	print_tally(&forward);
	if (wanted.report == CONSISTENCY) {
		print_band("nees", moments.nees, moments.n_nees, 9);
		print_band("nis", moments.nis, moments.n_nis, 6);
	}
	if (wanted.smooth) {
		printf(" smoothed");
		print_tally(&smoothed);
	}
	printf("\n");
}

/* ---- command line ---- */

static bool numbers(const char *text, char separator, int n, double to[])
{
	for (int i = 0; i < n; i++) {
		const char *end = strchrnul(text, i < n - 1 ? separator : '\0');
		if (fw_get_double(text, (size_t)(end - text), &to[i]) != FW_OK)
			return false;
		text = end + (*end != '\0');
	}
	return true;
}

static bool take_option(const char *name, const char *value)
{
	static const char *const reports[] = {"sections", "consistency", "outages", "heading"};
	double v[3];
	if (strcmp(name, "--set") == 0)
		return scenario_set(&world.s, &self, value) == EXIT_COMPLETE;
	if (strcmp(name, "--seeds") == 0 && numbers(value, '-', 2, v) && v[1] >= v[0]) {
		world.first_seed = (int)v[0];
		world.n_flights = (int)(v[1] - v[0]) + 1;
		return true;
	}
	if (strcmp(name, "--withhold") == 0 && numbers(value, ':', 3, v)) {
		wanted.every_s = v[0];
		wanted.length_s = v[1];
		wanted.first_s = v[2];
		return true;
	}
	for (int i = 0; strcmp(name, "--report") == 0 && i < 4; i++) {
		if (strcmp(value, reports[i]) != 0)
			continue;
		wanted.report = (enum report)i;
		return true;
	}
	return false;
}

static int read_command_line(int argc, char **argv)
{
	if (argc < 2)
		return EXIT_USAGE;
	scenario_defaults(&world.s);
	int status = scenario_read(&world.s, &self, argv[1]);
	world.first_seed = world.n_flights = 1;
	for (int i = 2; i < argc && status == EXIT_COMPLETE; i++) {
		if (strcmp(argv[i], "--smooth") == 0)
			wanted.smooth = true;
		else if (i + 1 < argc && take_option(argv[i], argv[i + 1]))
			i++;
		else
			status = EXIT_USAGE;
	}
	return status;
}

int main(int argc, char **argv)
{
	static char line[4096];
	fw_loose_options o;
	int status = read_command_line(argc, argv);
	if (status == EXIT_COMPLETE)
		status = scenario_complete(&world.s, &self, &world.base);
	if (status == EXIT_COMPLETE)
		status = scenario_trajectory(&world.s, &self, &world.path);
	if (status != EXIT_COMPLETE || world.s.rover.pvt.n_sections == 0) {
		fputs("campaign: a scenario with [pvt] sections is wanted, and options as the head of "
		      "campaign.c has them\n",
		      stderr);
		return EXIT_USAGE;
	}
	fly_truth();
	world.flights = need(calloc((size_t)world.n_flights, sizeof world.flights[0]));
	for (int i = 0; i < world.n_flights; i++)
		make_flight(&world.flights[i], world.first_seed + i);
	while (fgets(line, sizeof line, stdin) != NULL) {
		if (!read_settings(line, &o))
			return EXIT_USAGE;
		fly_all(&o);
		fflush(stdout);
	}
	return EXIT_COMPLETE;
}
