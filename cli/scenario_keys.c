#include "scenario_keys.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "formats/number.h"
#include "options.h"

/* ---- units ---- */

#define DEG    (FW_PI / 180)
#define DEG_H  (DEG / 3600)
#define DEG_RH (DEG / 60) /* degrees per square root of an hour */
#define G0     9.80665
#define MILLIG (G0 * 1e-3)
#define MICROG (G0 * 1e-6)

/** A date far from the end of any system's week, and after WMM2025's beginning: a Wednesday in June. */
#define START "2026-06-10T08:00:00"

#define GRADES "perfect|mems|industrial|tactical|navigation"
#define CLOCKS "perfect|tcxo|ocxo|csac|rubidium|caesium"

/* ---- the table ---- */

#define IN(member)   offsetof(scenario, member)
#define IN_M(member) offsetof(fw_mask, member)
#define IN_F(member) offsetof(fw_fault, member)
#define NUMBER(section, name, offset, unit, min, max, fallback)                                              \
	{                                                                                                    \
		section, name, KEY_NUMBER, offset, 0, unit, min, max, NULL, fallback                         \
	}
#define VECTOR(section, name, offset, n, unit, fallback)                                                     \
	{                                                                                                    \
		section, name, KEY_NUMBERS, offset, n, unit, -1e9, 1e9, NULL, fallback                       \
	}
#define LIST(section, name, offset)                                                                          \
	{                                                                                                    \
		section, name, KEY_LIST, offset, 0, 1, 0, 1e9, NULL, ""                                      \
	}
#define TEXT(section, name, offset, fallback)                                                                \
	{                                                                                                    \
		section, name, KEY_TEXT, offset, 0, 0, 0, 0, NULL, fallback                                  \
	}
#define CHOICE(section, name, offset, words, fallback)                                                       \
	{                                                                                                    \
		section, name, KEY_CHOICE, offset, 0, 0, 0, 0, words, fallback                               \
	}
#define FLAG(section, name, offset, fallback)                                                                \
	{                                                                                                    \
		section, name, KEY_FLAG, offset, 0, 0, 0, 0, NULL, fallback                                  \
	}
#define SATELLITES(section, name, offset)                                                                    \
	{                                                                                                    \
		section, name, KEY_SATELLITES, offset, 0, 0, 0, 0, NULL, "all"                               \
	}
#define ROUTE(name, kind)                                                                                    \
	{                                                                                                    \
		"trajectory", name, KEY_ROUTE, 0, kind, 0, 0, 0, NULL, NULL                                  \
	}

/* clang-format off */
const scenario_key scenario_keys[] = {
    {"scenario", "start", KEY_TIME, IN(start), 0, 0, 0, 0, NULL, START},
    NUMBER("scenario", "duration_s", IN(duration_s), 1, 0, 604800, "0"),
    NUMBER("scenario", "seed", IN(seed), 1, 0, 9007199254740992.0, "1"),
    NUMBER("scenario", "truth_rate_hz", IN(truth_rate_hz), 1, 0, 1000, "0"),

    CHOICE("trajectory", "vehicle", IN(vehicle), "ground|plane|multirotor", "multirotor"),
    NUMBER("trajectory", "latitude_deg", IN(path.origin_llh[0]), DEG, -85, 85, "52.05"),
    NUMBER("trajectory", "longitude_deg", IN(path.origin_llh[1]), DEG, -180, 360, "11.45"),
    NUMBER("trajectory", "height_m", IN(path.origin_llh[2]), 1, -1000, 20000, "120"),
    NUMBER("trajectory", "heading_deg", IN(path.heading_rad), DEG, -360, 360, "0"),
    NUMBER("trajectory", "accel_mps2", IN(path.limits.accel_mps2), 1, 1e-3, 100, "2"),
    NUMBER("trajectory", "lateral_mps2", IN(path.limits.lateral_mps2), 1, 1e-3, 100, "3"),
    NUMBER("trajectory", "jerk_mps3", IN(path.limits.jerk_mps3), 1, 1e-3, 1000, "3"),
    NUMBER("trajectory", "climb_mps", IN(path.limits.climb_mps), 1, 1e-3, 100, "3"),
    NUMBER("trajectory", "turn_degps", IN(path.limits.turn_radps), DEG, 0.01, 1000, "60"),
    NUMBER("trajectory", "radius_m", IN(path.limits.radius_m), 1, 0.01, 1e5, "3"),
    ROUTE("waypoint", ROUTE_WAYPOINT),
    ROUTE("place", ROUTE_PLACE),
    ROUTE("rows", ROUTE_ROWS),
    TEXT("trajectory", "table", IN(table), ""),
    NUMBER("trajectory", "table_spacing_s", IN(table_spacing_s), 1, 0, 1000, "0"),

    {"imu", "grade", KEY_IMU_GRADE, IN(imu_grade), 0, 0, 0, 0, GRADES, "industrial"},
    NUMBER("imu", "rate_hz", IN(imu_rate_hz), 1, 0, 1000, "100"),
    NUMBER("imu", "gyro_bias_degph", IN(imu.gyro.bias_sd), DEG_H, 0, 1e6, NULL),
    NUMBER("imu", "gyro_noise_degprth", IN(imu.gyro.white), DEG_RH, 0, 1e6, NULL),
    NUMBER("imu", "gyro_instability_degph", IN(imu.gyro.flicker), DEG_H, 0, 1e6, NULL),
    NUMBER("imu", "gyro_walk_degphprth", IN(imu.gyro.walk), DEG_H / 60, 0, 1e6, NULL),
    NUMBER("imu", "gyro_markov_degph", IN(imu.gyro.markov_sd), DEG_H, 0, 1e6, NULL),
    NUMBER("imu", "gyro_markov_tau_s", IN(imu.gyro.markov_tau_s), 1, 0, 1e7, NULL),
    NUMBER("imu", "gyro_scale_ppm", IN(imu.gyro.scale_sd), 1e-6, 0, 1e5, NULL),
    NUMBER("imu", "gyro_misalignment_mrad", IN(imu.gyro.misalignment_sd), 1e-3, 0, 100, NULL),
    NUMBER("imu", "gyro_quantum_urad", IN(imu.gyro.quantum), 1e-6, 0, 1e6, NULL),
    NUMBER("imu", "gyro_range_degps", IN(imu.gyro.range), DEG, 0, 1e5, NULL),
    NUMBER("imu", "accel_bias_mg", IN(imu.accel.bias_sd), MILLIG, 0, 1e6, NULL),
    NUMBER("imu", "accel_noise_ugprthz", IN(imu.accel.white), MICROG, 0, 1e6, NULL),
    NUMBER("imu", "accel_instability_ug", IN(imu.accel.flicker), MICROG, 0, 1e6, NULL),
    NUMBER("imu", "accel_walk_ugprts", IN(imu.accel.walk), MICROG, 0, 1e6, NULL),
    NUMBER("imu", "accel_markov_mg", IN(imu.accel.markov_sd), MILLIG, 0, 1e6, NULL),
    NUMBER("imu", "accel_markov_tau_s", IN(imu.accel.markov_tau_s), 1, 0, 1e7, NULL),
    NUMBER("imu", "accel_scale_ppm", IN(imu.accel.scale_sd), 1e-6, 0, 1e5, NULL),
    NUMBER("imu", "accel_misalignment_mrad", IN(imu.accel.misalignment_sd), 1e-3, 0, 100, NULL),
    NUMBER("imu", "accel_quantum_mmps", IN(imu.accel.quantum), 1e-3, 0, 1e6, NULL),
    NUMBER("imu", "accel_range_g", IN(imu.accel.range), G0, 0, 1e5, NULL),

    NUMBER("magnetometer", "rate_hz", IN(mag_rate_hz), 1, 0, 1000, "10"),
    VECTOR("magnetometer", "hard_iron_ut", IN(mag.hard_iron_ut), 3, 1, "0 0 0"),
    VECTOR("magnetometer", "soft_iron", IN(mag.soft_iron), 9, 1, "0 0 0 0 0 0 0 0 0"),
    NUMBER("magnetometer", "noise_ut", IN(mag.noise_ut), 1, 0, 1000, "0.1"),
    NUMBER("magnetometer", "quantum_ut", IN(mag.quantum_ut), 1, 0, 1000, "0"),

    NUMBER("barometer", "rate_hz", IN(baro_rate_hz), 1, 0, 1000, "10"),
    NUMBER("barometer", "bias_m", IN(baro.bias_sd_m), 1, 0, 1000, "2"),
    NUMBER("barometer", "drift_m", IN(baro.drift_sd_m), 1, 0, 1000, "1"),
    NUMBER("barometer", "drift_tau_s", IN(baro.drift_tau_s), 1, 0.1, 1e7, "600"),
    NUMBER("barometer", "noise_m", IN(baro.noise_m), 1, 0, 1000, "0.2"),
    NUMBER("barometer", "quantum_m", IN(baro.quantum_m), 1, 0, 1000, "0.01"),

    {"clock", "model", KEY_CLOCK_MODEL, IN(clock), IN(clock_name), 0, 0, 0, CLOCKS, "tcxo"},
    NUMBER("clock", "h0_s", IN(clock.h0), 1, 0, 1, NULL),
    NUMBER("clock", "hm1", IN(clock.hm1), 1, 0, 1, NULL),
    NUMBER("clock", "hm2_ps", IN(clock.hm2), 1, 0, 1, NULL),
    NUMBER("clock", "ageing_ppmonth", IN(clock.ageing_per_s), 1 / (30 * 86400.0), -1, 1, NULL),
    NUMBER("clock", "offset_us", IN(clock.offset_s), 1e-6, -400, 400, "11"),
    NUMBER("clock", "drift_ppb", IN(clock.drift_sps), 1e-9, -10000, 10000, "40"),

    TEXT("sky", "systems", IN(systems), "GPS Galileo BeiDou GLONASS"),
    TEXT("sky", "nav_file", IN(nav_file), ""),
    NUMBER("sky", "radial_m", IN(sky.radial_m), 1, 0, 1000, "0.3"),
    NUMBER("sky", "along_m", IN(sky.along_m), 1, 0, 1000, "0.8"),
    NUMBER("sky", "cross_m", IN(sky.cross_m), 1, 0, 1000, "0.6"),
    NUMBER("sky", "orbit_tau_s", IN(sky.orbit_tau_s), 1, 1, 1e7, "7200"),
    NUMBER("sky", "clock_m", IN(sky.clock_m), 1, 0, 1000, "0.4"),
    NUMBER("sky", "clock_tau_s", IN(sky.clock_tau_s), 1, 1, 1e7, "7200"),
    NUMBER("sky", "iono_pct", IN(sky.iono_fraction), 0.01, 0, 300, "25"),
    NUMBER("sky", "iono_tau_s", IN(sky.iono_tau_s), 1, 1, 1e7, "1800"),
    NUMBER("sky", "tropo_m", IN(sky.tropo_m), 1, 0, 10, "0.04"),
    NUMBER("sky", "tropo_tau_s", IN(sky.tropo_tau_s), 1, 1, 1e7, "7200"),
    VECTOR("sky", "klobuchar_alpha", IN(sky.klobuchar.alpha), 4, 1, "1.0245e-8 1.4901e-8 -5.9605e-8 -5.9605e-8"),
    VECTOR("sky", "klobuchar_beta", IN(sky.klobuchar.beta), 4, 1, "90112 32768 -196608 -131072"),

    NUMBER("gnss", "rate_hz", IN(gnss_rate_hz), 1, 0.001, 100, "5"),
    TEXT("gnss", "signals", IN(signals), "G1C G2W G5Q E1C E5Q C2I C5P R1C R2C"),
    NUMBER("gnss", "elevation_mask_deg", IN(rover.noise.elevation_mask_rad), DEG, -5, 90, "5"),
    VECTOR("gnss", "lever_m", IN(lever_m), 3, 1, "0 0 0"),
    NUMBER("gnss", "cn0_zenith_dbhz", IN(rover.noise.cn0_zenith_dbhz), 1, 0, 70, "51"),
    NUMBER("gnss", "cn0_horizon_dbhz", IN(rover.noise.cn0_horizon_dbhz), 1, 0, 70, "36"),
    NUMBER("gnss", "cn0_sd_db", IN(rover.noise.cn0_sd_db), 1, 0, 20, "0.3"),
    NUMBER("gnss", "cn0_track_dbhz", IN(rover.noise.cn0_track_dbhz), 1, 0, 70, "25"),
    NUMBER("gnss", "dll_hz", IN(rover.noise.dll_hz), 1, 1e-4, 100, "0.25"),
    NUMBER("gnss", "pll_hz", IN(rover.noise.pll_hz), 1, 1e-4, 1000, "15"),
    NUMBER("gnss", "fll_hz", IN(rover.noise.fll_hz), 1, 1e-4, 1000, "2"),
    NUMBER("gnss", "integration_s", IN(rover.noise.integration_s), 1, 1e-3, 1, "0.02"),
    NUMBER("gnss", "multipath_m", IN(rover.noise.multipath_m), 1, 0, 1000, "0.8"),
    NUMBER("gnss", "multipath_carrier_m", IN(rover.noise.multipath_carrier_m), 1, 0, 1, "0.006"),
    NUMBER("gnss", "multipath_scale_deg", IN(rover.noise.multipath_scale_rad), DEG, 1, 1000, "20"),
    NUMBER("gnss", "multipath_tau_s", IN(rover.noise.multipath_tau_s), 1, 0, 1e6, "20"),
    NUMBER("gnss", "slips_per_hour", IN(rover.noise.slips_per_hour), 1, 0, 1e6, "0"),
    NUMBER("gnss", "half_cycle_s", IN(rover.noise.half_cycle_s), 1, 0, 1000, "0"),
    NUMBER("gnss", "system_bias_m", IN(rover.noise.system_bias_m), 1, 0, 1000, "3"),

    CHOICE("pvt", "mode", IN(pvt_mode), "standalone|sbas", "standalone"),
    NUMBER("pvt", "sbas_rest_pct", IN(rover.pvt.sbas_rest), 0.01, 0, 100, "30"),
    NUMBER("pvt", "elevation_mask_deg", IN(rover.pvt.elevation_mask_rad), DEG, -5, 90, "10"),
    NUMBER("pvt", "k_h", IN(rover.pvt.k_h), 1, 0, 100, "6.0"),
    NUMBER("pvt", "k_v", IN(rover.pvt.k_v), 1, 0, 100, "5.33"),
    NUMBER("pvt", "section_from_s", IN(section_from_s), 1, 0, 1e9, "0"),
    NUMBER("pvt", "section_s", IN(section_s), 1, 0.001, 1e9, "100"),
    NUMBER("pvt", "section_tau_s", IN(rover.pvt.section_tau_s), 1, 0, 1e7, "0"),
    LIST("pvt", "horizontal_m2", IN(section[0])),
    LIST("pvt", "vertical_m2", IN(section[1])),
    LIST("pvt", "horizontal_m2ps2", IN(section[2])),
    LIST("pvt", "vertical_m2ps2", IN(section[3])),

    VECTOR("attitude", "baseline_m", IN(rover.baseline_b_m), 3, 1, "0 0 0"),
    NUMBER("attitude", "noise_m", IN(rover.attitude_noise_m), 1, 0, 10, "0.004"),
    FLAG("attitude", "observations", IN(aux_observations), "no"),

    FLAG("base", "present", IN(has_base), "yes"),
    NUMBER("base", "rate_hz", IN(base_rate_hz), 1, 0.001, 100, "1"),
    VECTOR("base", "place_m", IN(base_place_m), 3, 1, "-60 40 2"),
    NUMBER("base", "multipath_m", IN(base_multipath_m), 1, 0, 1000, "0.3"),
    {"base", "clock", KEY_CLOCK_MODEL, IN(base_clock), IN(base_clock_name), 0, 0, 0, CLOCKS, "ocxo"},

    NUMBER("camera", "interval_s", IN(camera_interval_s), 1, 0, 1e6, "0"),
    NUMBER("camera", "distance_m", IN(camera_distance_m), 1, 0, 1e6, "0"),
    NUMBER("camera", "from_s", IN(camera_from_s), 1, 0, 1e9, "0"),
    NUMBER("camera", "until_s", IN(camera_until_s), 1, 0, 1e9, "1e9"),
    NUMBER("camera", "min_speed_mps", IN(camera_speed_mps), 1, 0, 1000, "0.5"),

    CHOICE("mask", "station", IN_M(stations), "none|rover|base|both", "rover"),
    NUMBER("mask", "from_s", IN_M(window.from_s), 1, 0, 1e9, "0"),
    NUMBER("mask", "until_s", IN_M(window.until_s), 1, 0, 1e9, "1e9"),
    SATELLITES("mask", "satellites", IN_M(satellites)),
    NUMBER("mask", "azimuth_from_deg", IN_M(azimuth_from_rad), DEG, -360, 360, "0"),
    NUMBER("mask", "azimuth_to_deg", IN_M(azimuth_to_rad), DEG, -360, 360, "0"),
    NUMBER("mask", "below_deg", IN_M(below_rad), DEG, -90, 90, "90"),
    NUMBER("mask", "attenuation_db", IN_M(attenuation_db), 1, 0, 200, "200"),
    {"mask", "keep", KEY_CHOICE, IN_M(keep), 0, 0, 0, 0,
     "0|1|2|3|4|5|6|7|8|9|10|11|12|13|14|15|16|17|18|19|20", "0"},

    CHOICE("fault", "type", IN_F(kind), "step|ramp|meacon|drag-off|slip|no-pvt|no-attitude|silence", "step"),
    CHOICE("fault", "station", IN_F(stations), "none|rover|base|both", "rover"),
    NUMBER("fault", "from_s", IN_F(window.from_s), 1, 0, 1e9, "0"),
    NUMBER("fault", "until_s", IN_F(window.until_s), 1, 0, 1e9, "1e9"),
    SATELLITES("fault", "satellites", IN_F(satellites)),
    NUMBER("fault", "size_m", IN_F(size_m), 1, -1e6, 1e6, "0"),
    NUMBER("fault", "rate_mps", IN_F(rate_mps), 1, -1e4, 1e4, "0"),
    NUMBER("fault", "delay_m", IN_F(delay_m), 1, 0, 1e6, "0"),
    VECTOR("fault", "offset_ned_m", IN_F(offset_ned_m), 3, 1, "0 0 0"),
    VECTOR("fault", "rate_ned_mps", IN_F(rate_ned_mps), 3, 1, "0 0 0"),
};
/* clang-format on */
const int scenario_n_keys = sizeof scenario_keys / sizeof scenario_keys[0];

/* ---- finding ---- */

const scenario_key *scenario_key_find(const char *section, const char *name)
{
	for (int i = 0; i < scenario_n_keys; i++)
		if (strcmp(scenario_keys[i].section, section) == 0 &&
		    strcmp(scenario_keys[i].name, name) == 0)
			return &scenario_keys[i];
	return NULL;
}

bool scenario_section_known(const char *section)
{
	for (int i = 0; i < scenario_n_keys; i++)
		if (strcmp(scenario_keys[i].section, section) == 0)
			return true;
	return false;
}

static const char *name_at(const void *section, int i)
{
	return strcmp(scenario_keys[i].section, section) == 0 ? scenario_keys[i].name : "";
}

static const char *section_at(const void *unused, int i)
{
	(void)unused;
	return scenario_keys[i].section;
}

/* The table's names, those of other sections empty, must not be near because they are short. */
static const char *not_empty(const char *word)
{
	return word != NULL && word[0] != '\0' ? word : NULL;
}

const char *scenario_key_near(const char *section, const char *name)
{
	return not_empty(nearest_word(name, name_at, section, scenario_n_keys));
}

const char *scenario_section_near(const char *section)
{
	return nearest_word(section, section_at, NULL, scenario_n_keys);
}

/* ---- presets ---- */

/* Turn-on bias [deg/h, mg], noise [deg/sqrt(h), ug/sqrt(Hz)], instability [deg/h, ug], scale [ppm],
 * misalignment [mrad]: what data sheets of such sensors promise. */
static const double grades[][10] = {
    {0},                                                   /* perfect */
    {300, 0.3, 10, 2000, 2, 8, 150, 60, 2000, 2},          /* mems: a drone's autopilot */
    {50, 0.15, 3, 500, 1, 2, 60, 30, 500, 1},              /* industrial: MEMS, calibrated */
    {1, 0.05, 0.5, 100, 0.2, 0.3, 50, 15, 100, 0.2},       /* tactical: FOG or the best MEMS */
    {0.01, 0.003, 0.005, 5, 0.02, 0.025, 10, 5, 20, 0.02}, /* navigation: RLG */
};

static void set_triad(const double *g, double bias, double noise, double instability, fw_triad_model *m)
{
	*m = (fw_triad_model){.bias_sd = g[0] * bias,
	                      .white = g[1] * noise,
	                      .flicker = g[2] * instability,
	                      .scale_sd = g[3] * 1e-6,
	                      .misalignment_sd = g[4] * 1e-3};
}

static void set_grade(scenario *s)
{
	const double *g = grades[s->imu_grade];
	set_triad(g, DEG_H, DEG_RH, DEG_H, &s->imu.gyro);
	set_triad(g + 5, MILLIG, MICROG, MICROG, &s->imu.accel);
}

/* ---- setting ---- */

static bool complain(char *why, size_t room, const char *format, const char *value, double min, double max)
{
	if (format == NULL)
		snprintf(why, room, "'%.60s' is not a number from %g to %g", value, min, max);
	else
		snprintf(why, room, "'%.60s' %s", value, format);
	return false;
}

/* Which of the words separated by | this is; -1: none. */
static int choice_of(const char *words, const char *value)
{
	size_t n = strlen(value);
	int i = 0;
	for (const char *p = words;; p = strchr(p, '|') + 1, i++) {
		if (strncmp(p, value, n) == 0 && (p[n] == '|' || p[n] == '\0'))
			return i;
		if (strchr(p, '|') == NULL)
			return -1;
	}
}

static void word_of(const char *words, int which, char *word, size_t room)
{
	const char *p = words;
	for (; which > 0 && strchr(p, '|') != NULL; which--)
		p = strchr(p, '|') + 1;
	snprintf(word, room, "%.*s", (int)strcspn(p, "|"), p);
}

/* Numbers separated by blanks or commas. Returns how many, -1 when one is none or there are more than room
 * for. */
static int numbers(const char *text, double *to, int room)
{
	int n = 0;
	for (const char *p = text + strspn(text, " \t,"); *p != '\0'; p += strspn(p, " \t,")) {
		size_t length = strcspn(p, " \t,");
		if (n == room || fw_get_double(p, length, &to[n]) != FW_OK)
			return -1;
		n++;
		p += length;
	}
	return n;
}

/* "all", "G", "E05 C": systems and satellites. */
static bool satellites(const char *text, fw_satellite_set *set)
{
	*set = (fw_satellite_set){0};
	for (const char *p = text + strspn(text, " \t,"); *p != '\0'; p += strspn(p, " \t,")) {
		char word[8];
		fw_satellite s;
		size_t length = strcspn(p, " \t,");
		if (length >= sizeof word)
			return false;
		memcpy(word, p, length);
		word[length] = '\0';
		p += length;
		if (strcmp(word, "all") == 0)
			memset(set, 0xff, sizeof *set);
		else if (length == 1 && fw_system_of_letter(word[0]) != FW_SYSTEM_COUNT)
			set->bits[fw_system_of_letter(word[0])] = UINT64_MAX;
		else if (fw_satellite_parse(word, &s) == FW_OK)
			set->bits[s.system] |= UINT64_C(1) << s.number % 64;
		else
			return false;
	}
	return true;
}

/* Beyond this a flat map is none. */
#define FAR_M 1e6

static const char *const route_forms[] = {
    [ROUTE_WAYPOINT] = "is not NORTH EAST UP [SPEED [STAY]]",
    [ROUTE_PLACE] = "is not LATITUDE LONGITUDE HEIGHT [SPEED [STAY]]",
    [ROUTE_ROWS] = "is not NORTH EAST UP HEADING LENGTH SPACING COUNT SPEED TURN_SPEED",
};

static bool add_route(scenario *s, const scenario_key *key, const char *value, int line, char *why,
                      size_t room)
{
	scenario_route route = {.kind = (scenario_route_kind)key->n, .line = line};
	int n = numbers(value, route.value, key->n == ROUTE_ROWS ? 9 : 5);
	if (n < (key->n == ROUTE_ROWS ? 9 : 3))
		return complain(why, room, route_forms[key->n], value, 0, 0);
	for (int i = 0; i < n; i++)
		if (!(fabs(route.value[i]) <= FAR_M))
			return complain(why, room, NULL, value, -FAR_M, FAR_M);
	if (s->n_route == SCENARIO_ROUTE)
		return complain(why, room, "is one waypoint too many", value, 0, 0);
	route.n = (unsigned)n;
	s->route[s->n_route++] = route;
	return true;
}

static bool set_numbers(const scenario_key *key, void *base, const char *value, char *why, size_t room)
{
	double v[SCENARIO_LIST], *to = (double *)(void *)((char *)base + key->offset);
	scenario_list *list = (scenario_list *)(void *)((char *)base + key->offset);
	int n = numbers(value, v, SCENARIO_LIST), wanted = key->type == KEY_LIST     ? n
	                                                   : key->type == KEY_NUMBER ? 1
	                                                                             : (int)key->n;
	char form[40];
	if (n < 0 || n != wanted) {
		snprintf(form, sizeof form, "is not %d number%s", wanted, wanted == 1 ? "" : "s");
		return complain(why, room, key->type == KEY_LIST ? "is not a list of up to 32 numbers" : form,
		                value, 0, 0);
	}
	for (int i = 0; i < n; i++)
		if (!(v[i] >= key->min && v[i] <= key->max))
			return complain(why, room, NULL, value, key->min, key->max);
	for (int i = 0; i < n; i++)
		*(key->type == KEY_LIST ? &list->value[i] : &to[i]) = v[i] * key->unit;
	if (key->type == KEY_LIST)
		list->n = (unsigned)n;
	return true;
}

static bool set_choice(const scenario_key *key, void *base, const char *value, char *why, size_t room)
{
	int which = choice_of(key->words, value);
	char *at = (char *)base + (key->type == KEY_CLOCK_MODEL ? key->n : key->offset);
	fw_clock_model model;
	if (which < 0) {
		snprintf(why, room, "'%.40s' is not one of %s", value, key->words);
		return false;
	}
	memcpy(at, &which, sizeof which);
	if (key->type == KEY_IMU_GRADE)
		set_grade(base);
	if (key->type == KEY_CLOCK_MODEL && fw_clock_model_named(value, &model) == FW_OK) {
		fw_clock_model *clock = (fw_clock_model *)(void *)((char *)base + key->offset);
		model.offset_s = clock->offset_s; /* where it starts is not the model's */
		model.drift_sps = clock->drift_sps;
		*clock = model;
	}
	return true;
}

bool scenario_key_set(const scenario_key *key, void *base, const char *value, int line, char *why,
                      size_t room)
{
	char *at = (char *)base + key->offset;
	fw_time t;
	switch (key->type) {
	case KEY_NUMBER:
	case KEY_NUMBERS:
	case KEY_LIST: return set_numbers(key, base, value, why, room);
	case KEY_CHOICE:
	case KEY_IMU_GRADE:
	case KEY_CLOCK_MODEL: return set_choice(key, base, value, why, room);
	case KEY_ROUTE: return add_route(base, key, value, line, why, room);
	case KEY_TEXT:
		if (strlen(value) >= SCENARIO_TEXT)
			return complain(why, room, "is too long", value, 0, 0);
		snprintf(at, SCENARIO_TEXT, "%s", value);
		return true;
	case KEY_FLAG:
		if (strcmp(value, "yes") != 0 && strcmp(value, "no") != 0)
			return complain(why, room, "is neither yes nor no", value, 0, 0);
		*(bool *)(void *)at = value[0] == 'y';
		return true;
	case KEY_TIME:
		if (fw_time_parse(value, &t) < 0)
			return complain(
			    why, room,
			    "is no time; write WEEK:SECONDS, YYYY-MM-DDTHH:MM:SS (GPS time), or the same "
			    "with Z (UTC)",
			    value, 0, 0);
		memcpy(at, &t, sizeof t);
		return true;
	case KEY_SATELLITES:
		if (!satellites(value, (fw_satellite_set *)(void *)at))
			return complain(why, room, "is not all, or letters and numbers as in G E05", value, 0,
			                0);
		return true;
	}
	return false;
}

/* ---- printing ---- */

static void print_satellites(const fw_satellite_set *set, FILE *to)
{
	static const fw_satellite_set all = {
	    {UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX}};
	if (memcmp(set, &all, sizeof all) == 0) {
		fputs(" all", to);
		return;
	}
	for (unsigned system = 0; system < FW_SYSTEM_COUNT; system++) {
		if (set->bits[system] == UINT64_MAX) {
			fprintf(to, " %c", fw_system_letter((fw_system)system));
			continue;
		}
		for (unsigned k = 1; k < 64; k++) {
			char name[5];
			fw_satellite_name((fw_satellite){(uint8_t)system, (uint8_t)k}, name);
			if (set->bits[system] >> k & 1)
				fprintf(to, " %s", name);
		}
	}
}

static void print_time(fw_time t, FILE *to)
{
	int week;
	double tow_s;
	fw_time_to_gps_s(t, &week, &tow_s);
	fprintf(to, " %d:%.10g", week, tow_s);
}

/* As many digits as were given, without those that the change of unit left behind. */
static void print_numbers(const double *v, unsigned n, double unit, FILE *to)
{
	for (unsigned i = 0; i < n; i++)
		fprintf(to, " %.12g", v[i] / unit);
}

/* The whole route in its order, at the first of its keys. */
static void print_route(const scenario *s, FILE *to)
{
	static const char *const names[] = {
	    [ROUTE_WAYPOINT] = "waypoint", [ROUTE_PLACE] = "place", [ROUTE_ROWS] = "rows"};
	for (unsigned i = 0; i < s->n_route; i++) {
		fprintf(to, "%s =", names[s->route[i].kind]);
		print_numbers(s->route[i].value, s->route[i].n, 1, to);
		fputc('\n', to);
	}
}

void scenario_key_print(const scenario_key *key, const void *base, FILE *to)
{
	const char *at = (const char *)base + (key->type == KEY_CLOCK_MODEL ? key->n : key->offset);
	const scenario_list *list = (const scenario_list *)(const void *)at;
	const double *numbers_at = (const double *)(const void *)at;
	char word[40];
	int which;
	fw_time t;
	if (key->type == KEY_ROUTE) {
		if (key->n == ROUTE_WAYPOINT)
			print_route(base, to);
		return;
	}
	fprintf(to, "%s =", key->name);
	switch (key->type) {
	case KEY_NUMBER: print_numbers(numbers_at, 1, key->unit, to); break;
	case KEY_NUMBERS: print_numbers(numbers_at, key->n, key->unit, to); break;
	case KEY_LIST: print_numbers(list->value, list->n, key->unit, to); break;
	case KEY_TEXT: fprintf(to, " %s", at); break;
	case KEY_FLAG: fprintf(to, " %s", *(const bool *)(const void *)at ? "yes" : "no"); break;
	case KEY_SATELLITES: print_satellites((const fw_satellite_set *)(const void *)at, to); break;
	case KEY_TIME:
		memcpy(&t, at, sizeof t);
		print_time(t, to);
		break;
	default:
		memcpy(&which, at, sizeof which);
		word_of(key->words, which, word, sizeof word);
		fprintf(to, " %s", word);
	}
	fputc('\n', to);
}
