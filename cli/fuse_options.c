#include "fuse_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/frame.h"
#include "formats/number.h"

#define DEG    (FW_PI / 180)
#define DEG_H  (DEG / 3600)
#define DEG_RH (DEG / 60) /* degrees per square root of an hour */
#define G0     9.80665
#define MILLIG (G0 * 1e-3)
#define MICROG (G0 * 1e-6)

#define TEXT(name, letter, argument, fallback, help)                                                         \
	{                                                                                                    \
		name, letter, OPTION_TEXT, argument, fallback, help, 0, 0                                    \
	}
#define CHOICE(name, letter, words, fallback, help)                                                          \
	{                                                                                                    \
		name, letter, OPTION_CHOICE, words, fallback, help, 0, 0                                     \
	}
#define FLAG(name, letter, help)                                                                             \
	{                                                                                                    \
		name, letter, OPTION_FLAG, NULL, NULL, help, 0, 0                                            \
	}
#define NUMBER(name, unit, fallback, min, max, help)                                                         \
	{                                                                                                    \
		name, 0, OPTION_NUMBER, unit, fallback, help, min, max                                       \
	}

const option fuse_option_table[] = {
    /* input and output */
    TEXT("output", 'o', "FILE", NULL, "write to FILE instead of standard output"),
    FLAG("stream", 's', "write a stream: what was read, and the solution"),
    CHOICE("format", 'f', "csv|lcm", "csv", "text, or an LCM event log"),
    {"from", 0, OPTION_TIME, "TIME", NULL, "leave out what is before TIME", 0, 0},
    {"until", 0, OPTION_TIME, "TIME", NULL, "leave out what is at TIME and after", 0, 0},
    TEXT("rate", 0, "imu|events|HZ", "imu", "rows at each IMU sample, at events only, or so many per second"),
    TEXT("imu", 0, "FILE", NULL, "IMU samples: a table, a text table, an autopilot's log"),
    TEXT("mag", 0, "FILE", NULL, "magnetometer: a table of type mag"),
    TEXT("baro", 0, "FILE", NULL, "barometer: a table of type baro"),
    TEXT("pl", 0, "FILE", NULL, "protection levels: a table of type pl"),
    TEXT("imu-columns", 0, "MAP", NULL, "columns of a text table of sensor data"),
    TEXT("imu-axes", 0, "AXES", NULL, "where its axes point: FRD, FLU, RFU, or such as -y,x,z [FRD]"),
    TEXT("imu-time", 0, "SCALE", NULL, "what its time counts: unix-utc, unix-gps, gps or boot, ..."),
    NUMBER("imu-instance", "N", NULL, 0, 15,
           "the IMU of an autopilot's log; the first healthy one if not set"),
    NUMBER("gps-lag", "S", NULL, -10, 10, "latency of the positions of an autopilot's log"),
    CHOICE("fixes", 0, "auto|pvt|pos|nav", "auto", "records that positions are taken from"),
    NUMBER("window", "S", "1", 0, 60, "how far records may be out of order [s]"),
    TEXT("withhold", 0, "EVERY:LENGTH[:FIRST]", NULL,
         "leave out fixes and headings in windows, to test outages [s]"),

    /* the IMU */
    NUMBER("imu-offset", "S", "0", -3600, 3600, "added to the times of IMU samples [s]"),
    NUMBER("imu-roll", "DEG", "0", -180, 180, "how the IMU is mounted: body from sensor, Z-Y-X"),
    NUMBER("imu-pitch", "DEG", "0", -90, 90, "likewise"),
    NUMBER("imu-yaw", "DEG", "0", -360, 360, "likewise"),
    NUMBER("lever-x", "M", NULL, -100, 100, "antenna, from the IMU: forward [m]"),
    NUMBER("lever-y", "M", NULL, -100, 100, "right [m]"),
    NUMBER("lever-z", "M", NULL, -100, 100, "down [m]"),
    CHOICE("imu-grade", 0, "consumer|mems|industrial|tactical|navigation", "industrial",
           "what the next options have when they are not set"),
    NUMBER("gyro-noise", "DEG/SQRT(H)", NULL, 1e-9, 1e6, "angle random walk"),
    NUMBER("gyro-bias", "DEG/H", NULL, 0, 1e6, "turn-on bias, sigma"),
    NUMBER("gyro-walk", "DEG/H", NULL, 0, 1e6, "what the bias changes during a run, sigma"),
    NUMBER("gyro-tau", "S", "1000", 0.01, 1e9, "its correlation time"),
    NUMBER("accel-noise", "UG/SQRT(HZ)", NULL, 1e-6, 1e9, "velocity random walk"),
    NUMBER("accel-bias", "MG", NULL, 0, 1e6, "turn-on bias, sigma"),
    NUMBER("accel-walk", "UG", NULL, 0, 1e9, "what the bias changes during a run, sigma"),
    NUMBER("accel-tau", "S", "1000", 0.01, 1e9, "its correlation time"),
    NUMBER("gyro-scale", "PPM", "0", 0, 1e5, "scale factor, sigma; 0: not estimated"),
    NUMBER("accel-scale", "PPM", "0", 0, 1e5, "scale factor, sigma; 0: not estimated"),
    NUMBER("imu-misalignment", "MRAD", NULL, 0, 100,
           "of the IMU's axes, sigma; added to that of the attitude"),
    NUMBER("gap", "S", "1", 1e-3, 60, "longest gap of the IMU that is bridged"),

    /* fixes */
    CHOICE("velocity", 0, "yes|no", "yes", "use the velocity of fixes"),
    NUMBER("position-sd-h", "M", "0", 0, 1e4,
           "sigma of positions in place of the receiver's; 0: the receiver's"),
    NUMBER("position-sd-v", "M", "0", 0, 1e4, "the same, vertical"),
    NUMBER("velocity-sd-h", "M/S", "0", 0, 1e4, "the same of velocities"),
    NUMBER("velocity-sd-v", "M/S", "0", 0, 1e4, "the same, vertical"),
    NUMBER("position-floor", "M", "0.005", 0, 1e4, "least sigma of positions that is believed"),
    NUMBER("float-floor", "M", "0.3", 0, 1e4, "the same of positions with float ambiguities"),
    NUMBER("velocity-floor", "M/S", "0.01", 0, 1e4, "least sigma of velocities"),
    NUMBER("gate", "P", "1e-5", 0, 0.5, "refuse what would come with less than this probability; 0: nothing"),
    NUMBER("gate-patience", "N", "30", 0, 1e6, "believe fixes after so many refused in a row; 0: never"),
    NUMBER("antenna-heading", "DEG", "0", -360, 360, "heading of the two antennas' baseline in the body"),
    NUMBER("heading-sd", "DEG", "0.2", 0, 90, "least sigma of their heading that is believed"),

    /* covariances that adapt */
    CHOICE("adapt", 0, "none|pl|gm|vb|student", "none", "how covariances of fixes follow what happens"),
    NUMBER("hul", "M", "20", 1e-3, 1e6, "pl: the user's horizontal level"),
    NUMBER("vul", "M", "25", 1e-3, 1e6, "pl: the user's vertical level"),
    NUMBER("tau1", "1", "1", 1e-6, 1e6, "pl: R times PL/UL / tau1 while PL <= UL"),
    NUMBER("tau2", "1", "1", 1e-6, 1e6, "pl: R times PL/UL tau2 beyond"),
    NUMBER("tau3", "1", "1", 1e-6, 1e6, "pl: Q times UL/PL / tau3 beyond"),
    NUMBER("tau4", "1", "1", 1e-6, 1e6, "pl: Q times UL/PL tau4 while PL <= UL"),
    NUMBER("pl-max-age", "S", "2", 1e-3, 3600, "protection levels older than this are none"),
    NUMBER("gm-tau", "S", "30", 1e-3, 1e6, "gm: correlation time of the fixes' errors"),
    NUMBER("gm-k-h", "1", "6", 0.1, 100, "gm: HPL over sigma"),
    NUMBER("gm-k-v", "1", "5.33", 0.1, 100, "gm: VPL over sigma"),
    NUMBER("gm-share", "1", "0.9", 0, 1, "gm: share of the variance that stays a while"),
    NUMBER("vb-memory", "1", "0.98", 0, 0.999999, "vb: how much is kept from fix to fix"),
    NUMBER("student-dof", "1", "4", 2.001, 1000, "student: degrees of freedom"),

    /* the first attitude */
    CHOICE("align", 0, "auto|gnss|magnetic|motion|gyrocompass|given", "auto",
           "where the first heading comes from"),
    NUMBER("heading", "DEG", NULL, -360, 360, "given: heading at the beginning"),
    NUMBER("heading-given-sd", "DEG", "5", 1e-3, 180, "given: its sigma"),
    NUMBER("align-limit", "DEG", "3", 0.01, 45, "sigma of a first attitude that is good enough"),

    /* compass, barometer, stillness, wheels */
    CHOICE("compass", 0, "yes|no", "no", "use the magnetometer"),
    NUMBER("compass-sd", "DEG", "5", 0.01, 180,
           "sigma of a magnetic heading that the table does not correct"),
    NUMBER("compass-every", "S", "10", 0, 3600, "magnetic headings are used so far apart at least"),
    CHOICE("compass-table", 0, "yes|no", "yes", "learn corrections from the antennas' heading"),
    TEXT("compass-calibration", 0, "none|turning|log|NUMBERS", "none",
         "hard and soft iron: how they are found"),
    NUMBER("declination", "DEG", NULL, -180, 180, "in place of the World Magnetic Model"),
    NUMBER("baro-sd", "M", NULL, 0, 1e4, "white noise of the barometer; 0: not used"),
    NUMBER("baro-drift", "M", "1", 0, 1e4, "its wandering, sigma"),
    NUMBER("baro-tau", "S", "600", 0.01, 1e9, "and correlation time"),
    CHOICE("still", 0, "yes|no", "yes", "zero velocity while the IMU stands still"),
    NUMBER("still-sd", "M/S", "0.02", 1e-4, 10, "sigma of that zero"),
    NUMBER("wheels", "M/S", "0", 0, 100, "sigma of sideways and vertical velocity of wheels; 0: none"),

    /* smoothing */
    CHOICE("smooth", 0, "none|rts", "none", "every moment from all of the log"),
    NUMBER("memory", "MIB", "256", 1, 1e6, "for smoothing; what is more goes to a file in TMPDIR"),

    FLAG("quiet", 'q', "only messages about errors that end the run"),
    FLAG("verbose", 'v', "every message, however often it repeats"),
    CHOICE("progress", 0, "auto|always|never", "auto", "show how much has been read"),
};
const int fuse_option_count = sizeof fuse_option_table / sizeof fuse_option_table[0];

/* ---- what they are to the library ---- */

/* A number in SI units; `otherwise` when nothing was said. */
static double in_si(const options *o, const char *name, double unit, double otherwise)
{
	return options_text(o, name) != NULL ? options_number(o, name) * unit : otherwise;
}

static double angle(const options *o, const char *name)
{
	return options_number(o, name) * DEG;
}

static bool is_yes(const options *o, const char *name)
{
	return strcmp(options_text(o, name), "yes") == 0;
}

/* The place of an option's word among its words. */
static int choice(const options *o, const char *name)
{
	const char *words = o->table[options_index(o, name)].argument, *word = options_text(o, name);
	const size_t n = strlen(word);
	int index = 0;
	for (const char *p = words; strncmp(p, word, n) != 0 || (p[n] != '|' && p[n] != '\0');
	     p = strchr(p, '|') + 1)
		index++;
	return index;
}

/* Noise [deg/sqrt(h), ug/sqrt(Hz)], turn-on bias [deg/h, mg], in-run bias [deg/h, ug]; misalignment [mrad]: the grades of
 * gnss-sim(1), and one below them. */
static const struct {
	double gyro[3], accel[3], misalignment;
} grades[] = {
    {{1, 3600, 360}, {500, 30, 3000}, 10},        /* consumer: not calibrated, as in telephones */
    {{0.3, 300, 10}, {150, 8, 60}, 2},            /* mems: a drone's autopilot */
    {{0.15, 50, 3}, {60, 2, 30}, 1},              /* industrial: MEMS, calibrated */
    {{0.05, 1, 0.5}, {50, 0.3, 15}, 0.2},         /* tactical: FOG or the best MEMS */
    {{0.003, 0.01, 0.005}, {10, 0.025, 5}, 0.02}, /* navigation: RLG */
};

static void set_imu(const options *o, fw_loose_options *l)
{
	const int grade = choice(o, "imu-grade");
	const double *g = grades[grade].gyro, *a = grades[grade].accel;
	l->gyro_noise = in_si(o, "gyro-noise", DEG_RH, g[0] * DEG_RH);
	l->gyro_bias_sd = in_si(o, "gyro-bias", DEG_H, g[1] * DEG_H);
	l->gyro_bias_walk = in_si(o, "gyro-walk", DEG_H, g[2] * DEG_H);
	l->gyro_bias_tau_s = options_number(o, "gyro-tau");
	l->accel_noise = in_si(o, "accel-noise", MICROG, a[0] * MICROG);
	l->accel_bias_sd = in_si(o, "accel-bias", MILLIG, a[1] * MILLIG);
	l->accel_bias_walk = in_si(o, "accel-walk", MICROG, a[2] * MICROG);
	l->accel_bias_tau_s = options_number(o, "accel-tau");
	l->gyro_scale_sd = options_number(o, "gyro-scale") * 1e-6;
	l->accel_scale_sd = options_number(o, "accel-scale") * 1e-6;
	l->gyro_matrix = l->accel_matrix =
	    in_si(o, "imu-misalignment", 1e-3, grades[grade].misalignment * 1e-3);
	l->gap_s = options_number(o, "gap");
}

static void set_fixes(const options *o, fw_loose_options *l)
{
	const double h = options_number(o, "position-sd-h"), v = options_number(o, "position-sd-v"),
	             vh = options_number(o, "velocity-sd-h"), vv = options_number(o, "velocity-sd-v");
	memcpy(l->position_sd, (double[3]){h, h, v}, sizeof l->position_sd);
	memcpy(l->velocity_sd, (double[3]){vh, vh, vv}, sizeof l->velocity_sd);
	l->position_floor_m = options_number(o, "position-floor");
	l->velocity_floor_mps = options_number(o, "velocity-floor");
	l->gate = options_number(o, "gate");
	l->gate_patience = (int)options_number(o, "gate-patience");
}

static void set_adaptation(const options *o, fw_adapt_options *a)
{
	a->mode = (fw_adapt_mode)choice(o, "adapt");
	a->hul_m = options_number(o, "hul");
	a->vul_m = options_number(o, "vul");
	a->tau1 = options_number(o, "tau1");
	a->tau2 = options_number(o, "tau2");
	a->tau3 = options_number(o, "tau3");
	a->tau4 = options_number(o, "tau4");
	a->max_age_s = options_number(o, "pl-max-age");
	a->gm_tau_s = options_number(o, "gm-tau");
	a->gm_k_h = options_number(o, "gm-k-h");
	a->gm_k_v = options_number(o, "gm-k-v");
	a->gm_share = options_number(o, "gm-share");
	a->vb_memory = options_number(o, "vb-memory");
	a->student_dof = options_number(o, "student-dof");
}

static void set_aids(const options *o, fw_loose_options *l)
{
	l->use_field = is_yes(o, "compass");
	l->field_sd_rad = angle(o, "compass-sd");
	l->field_tau_s = options_number(o, "compass-every");
	l->use_table = is_yes(o, "compass-table");
	l->declination_rad = in_si(o, "declination", DEG, (double)NAN);
	l->height_sd_m = in_si(o, "baro-sd", 1, options_text(o, "baro") != NULL ? 1 : 0);
	l->height_drift_m = options_number(o, "baro-drift");
	l->height_tau_s = options_number(o, "baro-tau");
	l->use_still = is_yes(o, "still");
	l->still_sd_mps = options_number(o, "still-sd");
	l->wheels_sd_mps = options_number(o, "wheels");
}

static void set_records(const options *o, fuse_records_setup *r)
{
	const double rpy[3] = {angle(o, "imu-roll"), angle(o, "imu-pitch"), angle(o, "imu-yaw")};
	fw_euler_to_matrix(rpy, r->C_b_s);
	r->imu_offset_ns = llround(options_number(o, "imu-offset") * 1e9);
	r->fixes = (fuse_fixes)choice(o, "fixes");
	r->float_floor_m = options_number(o, "float-floor");
	r->use_velocity = is_yes(o, "velocity");
	r->antenna_heading_rad = angle(o, "antenna-heading");
	r->heading_floor_rad = angle(o, "heading-sd");
}

static void set_start(const options *o, const fw_loose_options *l, fuse_start_setup *s)
{
	s->way = (fuse_align)choice(o, "align");
	s->heading_rad = fw_wrap_2pi(in_si(o, "heading", DEG, 0));
	s->heading_sd_rad = angle(o, "heading-given-sd");
	s->limit_rad = angle(o, "align-limit");
	s->imu = (fw_align_imu){.gyro_bias_sd = hypot(l->gyro_bias_sd, l->gyro_bias_walk),
	                        .gyro_noise = l->gyro_noise,
	                        .accel_bias_sd = hypot(l->accel_bias_sd, l->accel_bias_walk),
	                        .accel_noise = l->accel_noise,
	                        .scale_sd = l->gyro_matrix};
	s->gyro_bias_walk = l->gyro_bias_walk;
	memcpy(s->lever_b, l->lever_b, sizeof s->lever_b);
	s->still = l->still;
	s->gap_s = l->gap_s;
	s->wheels = l->wheels_sd_mps > 0;
	s->compass = l->use_field || s->way == FUSE_ALIGN_MAGNETIC;
	s->compass_sd_rad = l->field_sd_rad;
	s->declination_rad = l->declination_rad;
}

/* "EVERY:LENGTH[:FIRST]" in seconds. Returns 0 if it is not that. */
static int parse_withhold(const char *text, fuse_records_setup *r)
{
	double seconds[3] = {0, 0, 0};
	int n = 0;
	for (const char *p = text;; p++) {
		const size_t length = strcspn(p, ":");
		if (n == 3 || fw_get_double(p, length, &seconds[n]) != FW_OK ||
		    !(seconds[n] >= 0 && seconds[n] <= 1e6))
			return 0;
		n++;
		p += length;
		if (*p == '\0')
			break;
	}
	if (n < 2 || !(seconds[1] > 0 && seconds[1] < seconds[0]))
		return 0;
	r->withhold_every_ns = llround(seconds[0] * 1e9);
	r->withhold_length_ns = llround(seconds[1] * 1e9);
	r->withhold_first_ns = llround(seconds[2] * 1e9);
	return 1;
}

/* "imu", "events" or rows per second. Returns 0 if it is none of these. */
static int parse_rate(const char *text, fuse_rate *rate)
{
	double hz;
	*rate = (fuse_rate){.next_ns = INT64_MIN / 2};
	if (strcmp(text, "imu") == 0)
		return 1;
	if (strcmp(text, "events") == 0) {
		rate->every_ns = -1;
		return 1;
	}
	if (fw_get_double(text, strlen(text), &hz) != FW_OK || !(hz >= 0.001 && hz <= 10000))
		return 0;
	rate->every_ns = llround(1e9 / hz);
	return 1;
}

static int set_logs(const options *o, const tool *t, log_plan *p)
{
	const int status = log_plan_make(t, options_text(o, "imu-columns"), options_text(o, "imu-axes"),
	                                 options_text(o, "imu-time"), p);
	p->instance = (int)in_si(o, "imu-instance", 1, -1);
	p->lag_s = in_si(o, "gps-lag", 1, (double)NAN);
	return status;
}

int fuse_configure(const options *o, const tool *t, fuse_config *c)
{
	static const char *const lever[] = {"lever-x", "lever-y", "lever-z"};
	*c = (fuse_config){.loose = fw_loose_defaults};
	set_imu(o, &c->loose);
	set_fixes(o, &c->loose);
	set_adaptation(o, &c->loose.adapt);
	set_aids(o, &c->loose);
	for (int i = 0; i < 3; i++) {
		c->loose.lever_b[i] = in_si(o, lever[i], 1, 0);
		c->lever_given |= options_text(o, lever[i]) != NULL;
	}
	set_records(o, &c->records);
	set_start(o, &c->loose, &c->start);
	c->misalignment_rad = c->loose.gyro_matrix;
	c->smooth = strcmp(options_text(o, "smooth"), "rts") == 0;
	c->memory = (uint64_t)(options_number(o, "memory") * 1048576);
	c->window_ns = llround(options_number(o, "window") * 1e9) + llabs(c->records.imu_offset_ns);
	if (set_logs(o, t, &c->logs) != EXIT_COMPLETE)
		return EXIT_USAGE;
	if (!fuse_compass_parse(options_text(o, "compass-calibration"), &c->compass_way, &c->compass)) {
		tool_error(t, "--compass-calibration: '%s' is neither none, turning nor log, nor 12 numbers",
		           options_text(o, "compass-calibration"));
		return EXIT_USAGE;
	}
	c->records.compass = c->compass_way == FUSE_COMPASS_GIVEN ? &c->compass : NULL;
	if (c->start.way == FUSE_ALIGN_GIVEN && options_text(o, "heading") == NULL) {
		tool_error(t, "--align given needs --heading DEG");
		return EXIT_USAGE;
	}
	if (options_text(o, "withhold") != NULL &&
	    !parse_withhold(options_text(o, "withhold"), &c->records)) {
		tool_error(t, "--withhold: '%s' is not EVERY:LENGTH[:FIRST] in seconds, LENGTH below EVERY",
		           options_text(o, "withhold"));
		return EXIT_USAGE;
	}
	if (!parse_rate(options_text(o, "rate"), &c->rate)) {
		tool_error(t, "--rate: '%s' is neither imu nor events nor a number from 0.001 to 10000",
		           options_text(o, "rate"));
		return EXIT_USAGE;
	}
	return EXIT_COMPLETE;
}
