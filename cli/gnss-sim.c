/* gnss-sim: receiver logs, IMU logs and truth from a scenario. See gnss-sim(1). */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "ephemerides.h"
#include "formats/csv.h"
#include "formats/sbf_decoder.h"
#include "furrow_baro.h"
#include "furrow_imu.h"
#include "furrow_mag.h"
#include "furrow_nav.h"
#include "furrow_nav_columns.h"
#include "ins/magnetic_field.h"
#include "options.h"
#include "output.h"
#include "rinex_files.h"
#include "scenario.h"
#include "sim/constellation.h"
#include "sim_log.h"
#include "source.h"
#include "tool.h"

enum { EPHEMERIDES = 32768, MS = 1000000 };

static const option table[] = {
    {"output", 'o', OPTION_TEXT, "DIR", NULL, "write into the folder DIR, which is made if need be", 0, 0},
    {"seed", 0, OPTION_NUMBER, "N", NULL, "seed of all errors, in place of the scenario's", 0,
     9007199254740992.0},
    {"truth-rate", 0, OPTION_NUMBER, "HZ", NULL, "rate of truth.csv, in place of the scenario's", 0.001,
     1000},
    {"rinex", 0, OPTION_FLAG, NULL, NULL, "write RINEX too: rover/obs.rnx, rover/nav.rnx, and base/ likewise",
     0, 0},
    {"quiet", 'q', OPTION_FLAG, NULL, NULL, "only messages about errors that end the run", 0, 0},
    {"verbose", 'v', OPTION_FLAG, NULL, NULL, "every message, however often it repeats", 0, 0},
};

static options opts = {
    .tool = "gnss-sim",
    .synopsis = "[options] SCENARIO.ini",
    .purpose = "Receiver logs (SBF), IMU logs and truth from a scenario.",
    .table = table,
    .n = sizeof table / sizeof table[0],
    .has_scenario = 1,
};
static tool self = {.name = "gnss-sim"};

/* A table that is being written. */
typedef struct {
	output out;
	fw_csv_writer writer;
} sim_table;

/* One receiver with its antennas, clock and log. */
typedef struct {
	bool present;
	double lever_m[3], aux_lever_m[3]; /* of the antennas, body axes */
	int64_t period_ns, next_ns;        /* of epochs; the next one, GPST */
	fw_clock clock;
	int jumps_ms; /* by which the clock has been set back */
	fw_receiver main, aux;
	fw_epoch epoch, aux_epoch;
	double bias_s; /* the receiver's idea of its clock */
	sim_log log;
	char folder[PATH_MAX + 16]; /* of its RINEX files */
	rinex_files *rinex;         /* NULL: none wanted */
} station;

/* When the camera fires. */
typedef struct {
	double t_s;  /* looked at up to here */
	double left; /* seconds or metres to the next picture */
	unsigned fired;
} camera;

/* Everything, large and once. */
static struct {
	scenario s;
	fw_trajectory trajectory;
	fw_receiver_setup base_setup;
	fw_ephemeris ephemerides[EPHEMERIDES];
	ephemeris_store store;
	fw_sky sky;
	fw_sbf_plans plans;
	station rover, base;
	fw_antenna base_antenna;
	camera camera;
	uint64_t seed[8]; /* of the parts, see enum */
	sim_table imu, mag, baro, truth;
	unsigned samples;
	char folder[PATH_MAX];
} sim;

enum { SEED_SKY, SEED_ROVER, SEED_AUX, SEED_BASE, SEED_ROVER_CLOCK, SEED_BASE_CLOCK, SEED_IMU, SEED_OTHERS };

/* ---- settings ---- */

/* Scenario file, then --set, then the options that stand for one key each. */
static int read_settings(const char *file)
{
	scenario *s = &sim.s;
	scenario_defaults(s);
	int status = scenario_read(s, &self, file);
	for (int i = 0; i < opts.n_settings && status == EXIT_COMPLETE; i++)
		status = scenario_set(s, &self, opts.settings[i]);
	if (options_text(&opts, "seed") != NULL)
		s->seed = options_number(&opts, "seed");
	if (options_text(&opts, "truth-rate") != NULL)
		s->truth_rate_hz = options_number(&opts, "truth-rate");
	if (status == EXIT_COMPLETE)
		status = scenario_complete(s, &self, &sim.base_setup);
	return status;
}

/* The interval of a rate in whole milliseconds, as SBF stamps its epochs. 0 after a message. */
static int64_t period_ns(const char *section, double rate_hz)
{
	double ms = 1000 / rate_hz;
	if (fabs(ms - nearbyint(ms)) < 1e-9 * ms)
		return llround(ms) * MS;
	tool_error(&self, "[%s] rate_hz: %g epochs per second are not a whole number of milliseconds apart",
	           section, rate_hz);
	return 0;
}

static void make_seeds(void)
{
	fw_random r;
	fw_random_init(&r, (uint64_t)sim.s.seed);
	for (int i = 0; i <= SEED_OTHERS; i++)
		sim.seed[i] = fw_random_u64(&r);
}

/* ---- the sky ---- */

/* Ephemerides of a navigation file that are of use between the two times, into sim.ephemerides. */
static unsigned gather_ephemerides(fw_time from, fw_time until, unsigned systems)
{
	const int64_t reach = 4 * 3600 * FW_NS_PER_S;
	unsigned n = 0;
	for (unsigned i = 0; i < FW_SATELLITE_COUNT; i++)
		for (int m = 0; m < EPHEMERIS_MESSAGES; m++)
			for (unsigned k = 0; k < sim.store.lists[i][m].n && n < EPHEMERIDES; k++) {
				const fw_ephemeris *e = &sim.store.lists[i][m].list[k];
				if (systems >> e->satellite.system & 1 && e->healthy &&
				    e->toe.ns >= from.ns - reach && e->toe.ns <= until.ns + reach)
					sim.ephemerides[n++] = *e;
			}
	return n;
}

static int read_navigation(fw_time from, fw_time until, unsigned systems, unsigned *n)
{
	char path[SCENARIO_TEXT + PATH_MAX];
	source_plan plan = {
	    .table = FW_RECORD_COUNT, .nav_sources = FW_NAV_DECODED | FW_NAV_RAW, .progress = "never"};
	source_totals totals = {0};
	ephemeris_kinds(&plan.wanted);
	if (!scenario_path(&sim.s, sim.s.nav_file, path))
		return EXIT_USAGE;
	int status = source_read(&self, path, &plan, (fw_sink){ephemeris_store_put, &sim.store}, &totals);
	if (status == EXIT_IO)
		return status;
	if (sim.store.iono.has_gps)
		sim.s.sky.klobuchar = sim.store.iono.gps;
	*n = gather_ephemerides(from, until, systems);
	if (*n > 0)
		return EXIT_COMPLETE;
	tool_error(&self, "%s: no ephemerides for the time of the scenario", path);
	return EXIT_NO_DATA;
}

/* "GPS Galileo" to bits. 0 after a message. */
static unsigned systems_wanted(void)
{
	static const char *const names[] = {"GPS", "Galileo", "BeiDou", "GLONASS"};
	unsigned bits = 0;
	for (const char *p = sim.s.systems + strspn(sim.s.systems, " ,"); *p != '\0'; p += strspn(p, " ,")) {
		size_t length = strcspn(p, " ,"), i = 0;
		while (i < 4 && (strlen(names[i]) != length || strncmp(p, names[i], length) != 0))
			i++;
		if (i == 4) {
			tool_error(&self, "[sky] systems: '%.*s' is not one of GPS Galileo BeiDou GLONASS",
			           (int)length, p);
			return 0;
		}
		bits |= 1U << i;
		p += length;
	}
	if (bits == 0)
		tool_error(&self, "[sky] systems: none");
	return bits;
}

static int make_sky(void)
{
	const scenario *s = &sim.s;
	fw_time until = fw_time_add_ns(s->start, llround(s->duration_s * 1e9));
	unsigned systems = systems_wanted(), n = 0;
	int status = EXIT_COMPLETE;
	if (systems == 0)
		return EXIT_USAGE;
	if (s->nav_file[0] != '\0') {
		status = read_navigation(s->start, until, systems, &n);
	} else if (fw_constellation(s->start, until, systems, EPHEMERIDES, sim.ephemerides, &n) < 0) {
		tool_error(&self, "[scenario] duration_s: too long for the ephemerides that fit in");
		status = EXIT_USAGE;
	}
	if (status != EXIT_COMPLETE)
		return status;
	if (fw_sky_init(&sim.sky, &sim.s.sky, sim.ephemerides, n, s->start, sim.seed[SEED_SKY]) == FW_OK)
		return EXIT_COMPLETE;
	tool_error(&self, "more than %d satellites", FW_SKY_SATELLITES);
	return EXIT_USAGE;
}

/* ---- stations ---- */

static int start_clock(station *st, const fw_clock_model *model, uint64_t seed)
{
	if (fw_clock_init(model, (double)st->period_ns / 1e9, seed, &st->clock) == FW_OK)
		return EXIT_COMPLETE;
	tool_error(&self, "[clock] numbers that are no clock");
	return EXIT_USAGE;
}

/* The first epoch at or after the start, at a multiple of the period since the beginning of GPS time. */
static void start_epochs(station *st)
{
	st->next_ns = (sim.s.start.ns + st->period_ns - 1) / st->period_ns * st->period_ns;
}

static int start_rover(void)
{
	station *st = &sim.rover;
	const scenario *s = &sim.s;
	if ((st->period_ns = period_ns("gnss", s->gnss_rate_hz)) == 0)
		return EXIT_USAGE;
	st->present = true;
	for (int i = 0; i < 3; i++) {
		st->lever_m[i] = s->lever_m[i];
		st->aux_lever_m[i] = s->lever_m[i] + s->rover.baseline_b_m[i];
	}
	start_epochs(st);
	fw_receiver_init(&st->main, &s->rover, sim.seed[SEED_ROVER]);
	fw_receiver_init(&st->aux, &s->rover, sim.seed[SEED_AUX]);
	memcpy(st->aux.bias_m, st->main.bias_m, sizeof st->aux.bias_m); /* one receiver with two antennas */
	return start_clock(st, &s->clock, sim.seed[SEED_ROVER_CLOCK]);
}

/* The base's antenna stands at its place beside the origin. */
static bool place_base(fw_antenna *a)
{
	const scenario *s = &sim.s;
	double C_e_n[3][3], ned[3] = {s->base_place_m[0], s->base_place_m[1], -s->base_place_m[2]}, e[3],
	                    origin[3];
	if (fw_llh_to_ecef(s->path.origin_llh, origin) < 0)
		return false;
	fw_frame_ned(s->path.origin_llh[0], s->path.origin_llh[1], C_e_n);
	fw_mat3_vec(C_e_n, ned, e);
	for (int i = 0; i < 3; i++)
		a->position_m[i] = origin[i] + e[i];
	return fw_ecef_to_llh(a->position_m, a->llh) >= 0;
}

static int start_base(void)
{
	station *st = &sim.base;
	const scenario *s = &sim.s;
	if (!s->has_base)
		return EXIT_COMPLETE;
	if ((st->period_ns = period_ns("base", s->base_rate_hz)) == 0)
		return EXIT_USAGE;
	st->present = true;
	start_epochs(st);
	if (!place_base(&sim.base_antenna)) {
		tool_error(&self, "[base] place_m: no place on Earth");
		return EXIT_USAGE;
	}
	fw_receiver_init(&st->main, &sim.base_setup, sim.seed[SEED_BASE]);
	return start_clock(st, &s->base_clock, sim.seed[SEED_BASE_CLOCK]);
}

/* ---- motion ---- */

/* Place and velocity of an antenna on the moving body: the lever turns with the body against the Earth. */
static bool antenna_on(const fw_motion *m, const double lever_m[static 3], fw_antenna *a)
{
	double C_e_n[3][3], arm_n[3], arm_e[3], earth_n[3], omega_b[3], swept_b[3], swept_n[3], swept_e[3];
	const double *w = omega_b;
	fw_frame_ned(m->lat_rad, m->lon_rad, C_e_n);
	fw_mat3_vec(m->C_n_b, lever_m, arm_n);
	fw_mat3_vec(C_e_n, arm_n, arm_e);
	fw_mat3_t_vec(C_e_n, (const double[3]){0, 0, FW_EARTH_RATE_RADPS}, earth_n);
	fw_mat3_t_vec(m->C_n_b, earth_n, omega_b);
	for (int i = 0; i < 3; i++)
		omega_b[i] = m->omega_ib_b_radps[i] - omega_b[i];
	swept_b[0] = w[1] * lever_m[2] - w[2] * lever_m[1];
	swept_b[1] = w[2] * lever_m[0] - w[0] * lever_m[2];
	swept_b[2] = w[0] * lever_m[1] - w[1] * lever_m[0];
	fw_mat3_vec(m->C_n_b, swept_b, swept_n);
	fw_mat3_vec(C_e_n, swept_n, swept_e);
	for (int i = 0; i < 3; i++) {
		a->position_m[i] = m->position_ecef_m[i] + arm_e[i];
		a->velocity_mps[i] = m->velocity_ecef_mps[i] + swept_e[i];
	}
	return fw_ecef_to_llh(a->position_m, a->llh) >= 0;
}

static fw_time at(double t_s)
{
	return fw_time_add_ns(sim.s.start, llround(t_s * 1e9));
}

/* ---- epochs ---- */

/* Receivers keep their clock within half a millisecond: they set it by a whole one. */
static double clock_offset_s(station *st)
{
	double offset = st->clock.offset_s + st->jumps_ms * 1e-3;
	if (fabs(offset) > 0.5e-3) {
		int step = offset > 0 ? -1 : 1;
		st->jumps_ms += step;
		offset += step * 1e-3;
	}
	return offset;
}

static bool is_silent(const station *st, double t_s)
{
	const fw_receiver_setup *s = &st->main.setup;
	return fw_faults_hold(s->fault, s->n_faults, FW_FAULT_SILENCE, s->station, t_s);
}

static void log_ephemerides(station *st, fw_time now)
{
	for (unsigned i = 0; i < st->main.n_measured; i++) {
		const fw_ephemeris *e = fw_sky_broadcast(&sim.sky, st->main.measured[i].satellite, now);
		if (e != NULL)
			sim_log_ephemeris(&st->log, e, now);
	}
}

/* The second antenna, if it has measurements of its own. */
static const fw_epoch *measure_aux(station *st, const fw_motion *m, fw_time tag, double clock_s)
{
	fw_antenna antenna = {.t_s = fw_time_diff_s(tag, sim.s.start)};
	if (m == NULL || !sim.s.aux_observations || !antenna_on(m, st->aux_lever_m, &antenna))
		return NULL;
	fw_receiver_measure(&st->aux, &sim.sky, tag, clock_s, st->clock.drift_sps, &antenna, &st->aux_epoch);
	return &st->aux_epoch;
}

/* One epoch of a station. m: the body that carries it; NULL: the base. */
static void epoch_of(station *st, fw_time tag, double clock_s, const fw_motion *m, const fw_antenna *antenna)
{
	fw_receiver_solution solution;
	fw_receiver_attitude attitude;
	const fw_receiver_setup *setup = &st->main.setup;

	fw_receiver_measure(&st->main, &sim.sky, tag, clock_s, st->clock.drift_sps, antenna, &st->epoch);
	const fw_epoch *aux = measure_aux(st, m, tag, clock_s);
	bool solved = fw_receiver_solve(&st->main, &sim.sky, &st->epoch, clock_s, st->clock.drift_sps,
	                                antenna, &solution) == FW_OK;
	bool has_attitude =
	    m != NULL && fw_receiver_attitude_of(&st->main, m->C_n_b, antenna, solved ? &solution : NULL,
	                                         &attitude) == FW_OK;
	if (solved)
		st->bias_s = solution.clock_m / FW_SPEED_OF_LIGHT_MPS;
	if (is_silent(st, antenna->t_s))
		return;
	if (tag.ns % FW_NS_PER_S == 0 || st->log.epochs == 0)
		log_ephemerides(st, tag);
	sim_log_measurements(&st->log, &st->epoch, aux, st->jumps_ms);
	sim_log_solution(&st->log, solved ? &solution : NULL, setup->pvt.sbas, &st->epoch);
	if (m != NULL && setup->baseline_b_m[0] * setup->baseline_b_m[0] +
	                         setup->baseline_b_m[1] * setup->baseline_b_m[1] +
	                         setup->baseline_b_m[2] * setup->baseline_b_m[2] >
	                     0)
		sim_log_attitude(&st->log, has_attitude ? &attitude : NULL, solved ? solution.n_used : 0);
}

static void next_epoch(station *st)
{
	fw_time tag = {st->next_ns};
	double clock_s = clock_offset_s(st), tag_s = fw_time_diff_s(tag, sim.s.start);
	fw_motion m;
	fw_antenna antenna = {.t_s = tag_s}, base = sim.base_antenna;
	base.t_s = tag_s;
	fw_sky_advance(&sim.sky, fw_time_add_ns(tag, MS));
	if (st == &sim.base)
		epoch_of(st, tag, clock_s, NULL, &base);
	else if (fw_trajectory_at(&sim.trajectory, tag_s - clock_s, &m) >= 0 &&
	         antenna_on(&m, st->lever_m, &antenna))
		epoch_of(st, tag, clock_s, &m, &antenna);
	fw_clock_step(&st->clock);
	st->next_ns += st->period_ns;
}

/* ---- the camera ---- */

/* Fires whatever falls before GPST until. By distance: it steps along the way in hundredths of a second. */
static void run_camera(fw_time until)
{
	const scenario *s = &sim.s;
	camera *c = &sim.camera;
	const double step = 0.01;
	bool by_distance = s->camera_distance_m > 0;
	double end = fmin(fw_time_diff_s(until, s->start), fmin(s->duration_s, s->camera_until_s));
	fw_motion m;
	if (!by_distance && !(s->camera_interval_s > 0))
		return;
	c->t_s = fmax(c->t_s, s->camera_from_s);
	while (c->t_s < end) {
		double dt = fmin(step, end - c->t_s), gone = dt;
		if (fw_trajectory_at(&sim.trajectory, c->t_s + dt / 2, &m) < 0)
			return;
		double speed = hypot(m.velocity_ned_mps[0], m.velocity_ned_mps[1]);
		if (by_distance)
			gone *= speed;
		if (gone > c->left) {
			double t_s = c->t_s + dt * c->left / gone;
			c->left += by_distance ? s->camera_distance_m : s->camera_interval_s;
			if (speed >= s->camera_speed_mps && !is_silent(&sim.rover, t_s)) {
				sim_log_event(&sim.rover.log, at(t_s), clock_offset_s(&sim.rover),
				              sim.rover.bias_s);
				c->fired++;
			}
		}
		c->left -= gone;
		c->t_s += dt;
	}
}

/* All epochs of both stations in the order of time. */
static void run_receivers(void)
{
	int64_t end_ns = at(sim.s.duration_s).ns;
	while (!tool_interrupted()) {
		station *next = &sim.rover;
		if (sim.base.present && sim.base.next_ns < next->next_ns)
			next = &sim.base;
		if (next->next_ns > end_ns || next->log.out.error != 0)
			break;
		if (next == &sim.rover && next->log.epochs > 0)
			run_camera((fw_time){next->next_ns});
		next_epoch(next);
	}
}

/* ---- sensors and truth ---- */

/* The k-th of samples at a rate. */
static double sample_s(unsigned k, double rate_hz)
{
	return (double)k / rate_hz;
}

static void begin_record(fw_kind kind, void *record, double t_s)
{
	fw_record_clear(kind, record);
	((fw_record_head *)record)->present = (INT64_C(1) << fw_record_type_of(kind)->n_columns) - 1;
	record_stamp(record, at(t_s));
}

static void run_imu(fw_imu *imu)
{
	double rate = sim.s.imu_rate_hz, omega[3], force[3], gyro[3], accel[3];
	furrow_imu r;
	for (unsigned k = 1; sample_s(k, rate) <= sim.s.duration_s && !tool_interrupted(); k++) {
		double t = sample_s(k, rate);
		if (fw_trajectory_average(&sim.trajectory, sample_s(k - 1, rate), t, omega, force) < 0)
			break;
		fw_imu_sample(imu, omega, force, gyro, accel);
		begin_record(FW_imu, &r, t);
		r.gyro_x_radps = gyro[0];
		r.gyro_y_radps = gyro[1];
		r.gyro_z_radps = gyro[2];
		r.accel_x_mps2 = accel[0];
		r.accel_y_mps2 = accel[1];
		r.accel_z_mps2 = accel[2];
		fw_csv_put(&sim.imu.writer, FW_imu, &r);
		sim.samples++;
	}
}

static void run_magnetometer(fw_magnetometer *mag)
{
	double rate = sim.s.mag_rate_hz, field[3], reading[3];
	fw_motion m;
	furrow_mag r;
	for (unsigned k = 0; sample_s(k, rate) <= sim.s.duration_s && !tool_interrupted(); k++) {
		double t = sample_s(k, rate);
		if (fw_trajectory_at(&sim.trajectory, t, &m) < 0 ||
		    fw_magnetic_field((const double[3]){m.lat_rad, m.lon_rad, m.height_m}, at(t), field) < 0)
			break;
		fw_magnetometer_sample(mag, m.C_n_b, field, reading);
		begin_record(FW_mag, &r, t);
		r.mag_x_ut = reading[0];
		r.mag_y_ut = reading[1];
		r.mag_z_ut = reading[2];
		fw_csv_put(&sim.mag.writer, FW_mag, &r);
	}
}

static void run_barometer(fw_barometer *baro)
{
	double rate = sim.s.baro_rate_hz;
	fw_motion m;
	furrow_baro r;
	for (unsigned k = 0; sample_s(k, rate) <= sim.s.duration_s && !tool_interrupted(); k++) {
		if (fw_trajectory_at(&sim.trajectory, sample_s(k, rate), &m) < 0)
			break;
		begin_record(FW_baro, &r, sample_s(k, rate));
		r.baro_height_m = fw_barometer_sample(baro, m.height_m);
		fw_csv_put(&sim.baro.writer, FW_baro, &r);
	}
}

static void run_truth(double rate)
{
	static char true_status[] = "truth";
	fw_motion m;
	furrow_nav r;
	for (unsigned k = 0; sample_s(k, rate) <= sim.s.duration_s && !tool_interrupted(); k++) {
		if (fw_trajectory_at(&sim.trajectory, sample_s(k, rate), &m) < 0)
			break;
		begin_record(FW_nav, &r, sample_s(k, rate));
		r.lat_deg = fw_deg_from_rad(m.lat_rad);
		r.lon_deg = fw_deg_from_rad(m.lon_rad);
		r.height_m = m.height_m;
		r.vn_mps = m.velocity_ned_mps[0];
		r.ve_mps = m.velocity_ned_mps[1];
		r.vd_mps = m.velocity_ned_mps[2];
		r.roll_deg = fw_deg_from_rad(m.roll_rad);
		r.pitch_deg = fw_deg_from_rad(m.pitch_rad);
		r.heading_deg = fw_deg_from_rad(m.heading_rad);
		r.status = true_status;
		r.present = ((INT64_C(2) << FW_COL_nav_heading_deg) - 1) | INT64_C(1) << FW_COL_nav_status;
		fw_csv_put(&sim.truth.writer, FW_nav, &r);
	}
}

static int run_sensors(void)
{
	const scenario *s = &sim.s;
	fw_imu imu;
	fw_magnetometer mag;
	fw_barometer baro;
	if ((s->imu_rate_hz > 0 && fw_imu_init(&s->imu, 1 / s->imu_rate_hz, sim.seed[SEED_IMU], &imu) < 0) ||
	    fw_magnetometer_init(&s->mag, sim.seed[SEED_OTHERS], &mag) < 0 ||
	    (s->baro_rate_hz > 0 &&
	     fw_barometer_init(&s->baro, 1 / s->baro_rate_hz, sim.seed[SEED_OTHERS] + 1, &baro) < 0)) {
		tool_error(&self, "[imu], [magnetometer] or [barometer]: numbers that are no sensor");
		return EXIT_USAGE;
	}
	if (s->imu_rate_hz > 0)
		run_imu(&imu);
	if (s->mag_rate_hz > 0)
		run_magnetometer(&mag);
	if (s->baro_rate_hz > 0)
		run_barometer(&baro);
	run_truth(s->truth_rate_hz > 0 ? s->truth_rate_hz
	          : s->imu_rate_hz > 0 ? s->imu_rate_hz
	                               : s->gnss_rate_hz);
	return EXIT_COMPLETE;
}

/* ---- files ---- */

/* The files of a run: those of this run, so that all take their places together. */
static output *files[6];
static unsigned n_files;

static const char *path_of(const char *name)
{
	static char path[PATH_MAX + 16];
	snprintf(path, sizeof path, "%s/%s", sim.folder, name);
	return path;
}

static int complain_file(const output *out)
{
	tool_error(&self, "%s: %s", out->path, strerror(out->error));
	return EXIT_IO;
}

static int open_table(sim_table *t, const char *name, fw_kind kind)
{
	if (output_open(&t->out, path_of(name)) < 0)
		return complain_file(&t->out);
	files[n_files++] = &t->out;
	fw_csv_begin_table(&t->writer, kind, output_write, &t->out);
	return EXIT_COMPLETE;
}

/* Makes a folder, unless it is there. */
static int make_folder(const char *path)
{
	if (mkdir(path, 0777) == 0 || errno == EEXIST)
		return EXIT_COMPLETE;
	tool_error(&self, "%s: %s", path, strerror(errno));
	return EXIT_IO;
}

static int open_rinex(station *st, const char *name)
{
	if (!options_flag(&opts, "rinex"))
		return EXIT_COMPLETE;
	snprintf(st->folder, sizeof st->folder, "%s", path_of(name));
	if (make_folder(st->folder) != EXIT_COMPLETE)
		return EXIT_IO;
	st->rinex = rinex_files_begin(st->folder, &self);
	return st->rinex != NULL ? EXIT_COMPLETE : EXIT_IO;
}

static int open_log(station *st, const char *name, const char *marker, const double *llh)
{
	char remark[SCENARIO_TEXT + 64];
	const char *slash = strrchr(sim.s.file, '/');
	fw_sink also = {NULL, NULL};
	if (open_rinex(st, marker) != EXIT_COMPLETE)
		return EXIT_IO;
	if (st->rinex != NULL)
		also = (fw_sink){rinex_files_put, st->rinex};
	fw_time first = {st->next_ns};
	snprintf(remark, sizeof remark, "simulated by gnss-sim: scenario %.100s, seed %.0f",
	         slash != NULL ? slash + 1 : sim.s.file, sim.s.seed);
	if (sim_log_open(&st->log, path_of(name), &sim.plans, also) < 0)
		return complain_file(&st->log.out);
	files[n_files++] = &st->log.out;
	sim_log_head head = {.marker = marker, .receiver = marker, .remark = remark, .llh = llh};
	sim_log_begin(&st->log, &head, &sim.s.sky.klobuchar, first);
	return EXIT_COMPLETE;
}

static int open_files(void)
{
	int status = make_folder(sim.folder);
	if (status != EXIT_COMPLETE)
		return status;
	fw_sbf_plans_init(&sim.plans);
	status = open_log(&sim.rover, "rover.sbf", "rover", NULL);
	if (status == EXIT_COMPLETE && sim.base.present)
		status = open_log(&sim.base, "base.sbf", "base", sim.base_antenna.llh);
	if (status == EXIT_COMPLETE && sim.s.imu_rate_hz > 0)
		status = open_table(&sim.imu, "imu.csv", FW_imu);
	if (status == EXIT_COMPLETE && sim.s.mag_rate_hz > 0)
		status = open_table(&sim.mag, "mag.csv", FW_mag);
	if (status == EXIT_COMPLETE && sim.s.baro_rate_hz > 0)
		status = open_table(&sim.baro, "baro.csv", FW_baro);
	if (status == EXIT_COMPLETE)
		status = open_table(&sim.truth, "truth.csv", FW_nav);
	return status;
}

/* The last bytes of every file. Returns EXIT_COMPLETE or, after a message, EXIT_IO or EXIT_USAGE. */
static int end_files(void)
{
	sim_table *tables[] = {&sim.imu, &sim.mag, &sim.baro, &sim.truth};
	station *stations[] = {&sim.rover, &sim.base};
	for (int i = 0; i < 4; i++)
		if (tables[i]->out.path[0] != '\0' &&
		    (fw_csv_end(&tables[i]->writer, true, 0) < 0 || output_finish(&tables[i]->out) < 0))
			return complain_file(&tables[i]->out);
	for (int i = 0; i < 2; i++) {
		if (!stations[i]->present)
			continue;
		fw_status status = sim_log_end(&stations[i]->log);
		if (status == FW_EIO)
			return complain_file(&stations[i]->log.out);
		if (status < 0) {
			tool_error(&self, "%s: SBF cannot hold some measurements (%s)",
			           stations[i]->log.out.path, fw_status_text(stations[i]->log.refused));
			return EXIT_USAGE;
		}
	}
	return EXIT_COMPLETE;
}

/* The RINEX files of a station; nothing of them stays when the run has failed. */
static int end_rinex(station *st, int status)
{
	bool keep = status == EXIT_COMPLETE && !tool_interrupted();
	if (st->rinex == NULL)
		return status;
	fw_status ended = rinex_files_end(st->rinex, keep);
	return keep && ended < 0 ? EXIT_IO : status;
}

static int place_files(int status)
{
	if (status == EXIT_COMPLETE && !tool_interrupted())
		status = end_files();
	status = end_rinex(&sim.rover, status);
	status = end_rinex(&sim.base, status);
	for (unsigned i = 0; i < n_files; i++) {
		if (status != EXIT_COMPLETE || tool_interrupted())
			output_discard(files[i]);
		else if (output_commit(files[i]) < 0)
			status = complain_file(files[i]);
	}
	return status;
}

/* ---- main ---- */

static int prepare(void)
{
	int status = scenario_trajectory(&sim.s, &self, &sim.trajectory);
	make_seeds();
	if (status == EXIT_COMPLETE)
		status = make_sky();
	if (status == EXIT_COMPLETE)
		status = start_rover();
	if (status == EXIT_COMPLETE)
		status = start_base();
	return status;
}

static int simulate(void)
{
	int status = open_files();
	if (status == EXIT_COMPLETE) {
		run_receivers();
		status = run_sensors();
	}
	status = place_files(status);
	if (tool_interrupted())
		return tool_die_of(tool_interrupted());
	if (status == EXIT_COMPLETE)
		tool_note(&self, "%s: %g s, %llu rover epochs, %llu base epochs, %u IMU samples, %u events",
		          sim.folder, sim.s.duration_s, (unsigned long long)sim.rover.log.epochs,
		          (unsigned long long)sim.base.log.epochs, sim.samples, sim.camera.fired);
	return status;
}

int main(int argc, char **argv)
{
	tool_hold_standard_streams();
	switch (options_parse(&opts, argc, argv)) {
	case OPTIONS_DONE: return tool_end_answer(&self);
	case OPTIONS_WRONG: return EXIT_USAGE;
	case OPTIONS_FAILED: return EXIT_IO;
	case OPTIONS_RUN: break;
	}
	self.quiet = options_flag(&opts, "quiet");
	self.verbose = options_flag(&opts, "verbose");
	if (argc - opts.first_file != 1) {
		tool_error(&self, "one scenario file is wanted; see gnss-sim --help");
		return EXIT_USAGE;
	}
	int status = read_settings(argv[opts.first_file]);
	if (status != EXIT_COMPLETE)
		return status;
	if (opts.print_config) {
		scenario_print(&sim.s, stdout);
		return tool_end_answer(&self);
	}
	const char *folder = options_text(&opts, "output");
	if (folder == NULL ||
	    snprintf(sim.folder, sizeof sim.folder, "%s", folder) >= (int)sizeof sim.folder) {
		tool_error(&self, "-o DIR is needed: where to write");
		return EXIT_USAGE;
	}
	tool_catch_signals();
	status = prepare();
	return status == EXIT_COMPLETE ? simulate() : status;
}
