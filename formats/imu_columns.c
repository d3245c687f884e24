#include "formats/imu_columns.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "formats/number.h"

#define STANDARD_GRAVITY 9.80665 /* ISO 80000-3: g_n [m/s^2] */

#define NORMAL_FIELD_UT 50.0 /* a normalised magnetic field is made as strong as the Earth's */

enum { WORD_MAX = 160 }; /* longest entry of a map */

/* ---- units ---- */

/* What a column counts; each has its units, the first by default. */
typedef enum {
	PLAIN,
	TIME,
	RATE,
	FORCE,
	FIELD,
	HEIGHT_OR_PRESSURE,
	ANGLE,
	LENGTH,
	SPEED,
} dimension;

typedef struct {
	dimension of;
	const char *name;
	double scale; /* to the unit of the records */
	bool increment, pressure;
} unit;

static const unit units[] = {
    {PLAIN, "1", 1, false, false},
    {TIME, "s", 1e9, false, false},
    {TIME, "ms", 1e6, false, false},
    {TIME, "us", 1e3, false, false},
    {TIME, "ns", 1, false, false},
    {RATE, "rad/s", 1, false, false},
    {RATE, "deg/s", FW_PI / 180, false, false},
    {RATE, "rad", 1, true, false},
    {RATE, "deg", FW_PI / 180, true, false},
    {FORCE, "m/s2", 1, false, false},
    {FORCE, "g", STANDARD_GRAVITY, false, false},
    {FORCE, "m/s", 1, true, false},
    {FIELD, "uT", 1, false, false},
    {FIELD, "nT", 1e-3, false, false},
    {FIELD, "G", 100, false, false},
    {FIELD, "mG", 0.1, false, false},
    {FIELD, "1", NORMAL_FIELD_UT, false, false},
    {HEIGHT_OR_PRESSURE, "m", 1, false, false},
    {HEIGHT_OR_PRESSURE, "Pa", 1, false, true},
    {HEIGHT_OR_PRESSURE, "hPa", 100, false, true},
    {HEIGHT_OR_PRESSURE, "kPa", 1000, false, true},
    {ANGLE, "deg", 1, false, false},
    {ANGLE, "rad", 180 / FW_PI, false, false},
    {LENGTH, "m", 1, false, false},
    {SPEED, "m/s", 1, false, false},
};

static const struct {
	const char *name;
	dimension of;
} names[FW_IMU_NAMES] = {
    [FW_IMU_TIME] = {"time", TIME},       [FW_IMU_WEEK] = {"week", PLAIN},
    [FW_IMU_GX] = {"gx", RATE},           [FW_IMU_GY] = {"gy", RATE},
    [FW_IMU_GZ] = {"gz", RATE},           [FW_IMU_AX] = {"ax", FORCE},
    [FW_IMU_AY] = {"ay", FORCE},          [FW_IMU_AZ] = {"az", FORCE},
    [FW_IMU_MX] = {"mx", FIELD},          [FW_IMU_MY] = {"my", FIELD},
    [FW_IMU_MZ] = {"mz", FIELD},          [FW_IMU_BARO] = {"baro", HEIGHT_OR_PRESSURE},
    [FW_IMU_LAT] = {"lat", ANGLE},        [FW_IMU_LON] = {"lon", ANGLE},
    [FW_IMU_HEIGHT] = {"height", LENGTH}, [FW_IMU_VN] = {"vn", SPEED},
    [FW_IMU_VE] = {"ve", SPEED},          [FW_IMU_VD] = {"vd", SPEED},
    [FW_IMU_SDN] = {"sdn", LENGTH},       [FW_IMU_SDE] = {"sde", LENGTH},
    [FW_IMU_SDD] = {"sdd", LENGTH},       [FW_IMU_SDVN] = {"sdvn", SPEED},
    [FW_IMU_SDVE] = {"sdve", SPEED},      [FW_IMU_SDVD] = {"sdvd", SPEED},
    [FW_IMU_NSATS] = {"nsats", PLAIN},    [FW_IMU_FIX] = {"fix", PLAIN},
    [FW_IMU_FIXTIME] = {"fixtime", TIME}, [FW_IMU_NLAT] = {"nlat", ANGLE},
    [FW_IMU_NLON] = {"nlon", ANGLE},      [FW_IMU_NHEIGHT] = {"nheight", LENGTH},
    [FW_IMU_NVN] = {"nvn", SPEED},        [FW_IMU_NVE] = {"nve", SPEED},
    [FW_IMU_NVD] = {"nvd", SPEED},        [FW_IMU_ROLL] = {"roll", ANGLE},
    [FW_IMU_PITCH] = {"pitch", ANGLE},    [FW_IMU_HEADING] = {"heading", ANGLE},
};

/* Known layouts. */
static const struct {
	const char *word, *map;
} layouts[] = {
    {"euroc", "time=1:ns gx=2 gy=3 gz=4 ax=5 ay=6 az=7"},
    {"px4-replay",
     "time=1:us ax=imu@3 ay=imu@4 az=imu@5 gx=imu@6 gy=imu@7 gz=imu@8 mx=mag@3:G my=mag@4:G mz=mag@5:G "
     "baro=baro@3 height=gps@3:0.001 lon=gps@4:1e-7 lat=gps@5:1e-7 vn=gps@6 ve=gps@7 vd=gps@8"},
    {"kf-gins-imu", "time=1 gx=2:rad gy=3:rad gz=4:rad ax=5:m/s ay=6:m/s az=7:m/s"},
    {"kf-gins-gnss", "time=1 lat=2 lon=3 height=4 sdn=5 sde=6 sdd=7"},
    {"kf-gins-nav", "week=1 time=2 nlat=3 nlon=4 nheight=5 nvn=6 nve=7 nvd=8 roll=9 pitch=10 heading=11"},
};

const char *fw_imu_name_text(fw_imu_name name)
{
	return names[name].name;
}

/* ---- words ---- */

static fw_status complain(fw_imu_problem *problem, const char *text, size_t n, const char *reason)
{
	n = n < sizeof problem->token ? n : sizeof problem->token - 1;
	memcpy(problem->token, text, n);
	problem->token[n] = '\0';
	problem->reason = reason;
	return FW_ESYNTAX;
}

static bool is(const char *text, size_t n, const char *word)
{
	return strlen(word) == n && memcmp(text, word, n) == 0;
}

/* Where the entry at p ends: at a blank or comma outside quotes. */
static size_t entry_length(const char *p)
{
	char quote = '\0';
	size_t n = 0;

	for (; p[n] != '\0'; n++) {
		if (quote != '\0')
			quote = p[n] == quote ? '\0' : quote;
		else if (p[n] == '\'' || p[n] == '"')
			quote = p[n];
		else if (strchr(" ,\t\n", p[n]) != NULL)
			break;
	}
	return n;
}

/* ---- columns ---- */

/* "5", "name" or "'quoted name'": n bytes that end before the unit. */
static fw_status take_column(const char *text, size_t n, fw_imu_column *c, fw_imu_problem *problem)
{
	int64_t number;

	if (n >= 2 && (text[0] == '\'' || text[0] == '"') && text[n - 1] == text[0]) {
		text++;
		n -= 2;
	} else if (fw_get_i64(text, n, &number) == FW_OK) {
		if (number < 1 || number > FW_IMU_COLUMN_MAX)
			return complain(problem, text, n, "columns are counted from 1 to 256");
		c->column = (int)number;
		return FW_OK;
	}
	if (n == 0)
		return complain(problem, text, n, "a column's number or name is missing");
	if (n >= sizeof c->name)
		return complain(problem, text, n, "a column's name is longer than 47 bytes");
	memcpy(c->name, text, n);
	return FW_OK;
}

static fw_status take_unit(const char *text, size_t n, fw_imu_name name, fw_imu_column *c,
                           fw_imu_problem *problem)
{
	const unit *fallback = NULL;
	double factor;

	for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
		if (units[i].of != names[name].of)
			continue;
		if (fallback == NULL)
			fallback = &units[i];
		if (n != 0 && !is(text, n, units[i].name))
			continue;
		c->scale = units[i].scale;
		c->increment = units[i].increment;
		c->pressure = units[i].pressure;
		return FW_OK;
	}
	if (fw_get_double(text, n, &factor) != FW_OK || factor == 0)
		return complain(problem, text, n, "neither a unit of this column nor a factor");
	c->scale = factor * fallback->scale;
	return FW_OK;
}

/* The bytes of `text` before the first `what` outside quotes; n when there is none. */
static size_t before(const char *text, size_t n, char what)
{
	char quote = '\0';

	for (size_t i = 0; i < n; i++) {
		if (quote != '\0')
			quote = text[i] == quote ? '\0' : quote;
		else if (text[i] == '\'' || text[i] == '"')
			quote = text[i];
		else if (text[i] == what)
			return i;
	}
	return n;
}

/* NAME=[WORD@]COLUMN[:UNIT] */
static fw_status take_entry(const char *text, size_t n, fw_imu_map *map, fw_imu_problem *problem)
{
	const size_t n_name = before(text, n, '=');
	const char *column = text + n_name + 1;
	fw_imu_column c = {.wanted = true};
	fw_imu_name name = 0;
	fw_status status;

	if (n_name == n)
		return complain(problem, text, n, "not NAME=COLUMN and no layout that is known");
	while (name < FW_IMU_NAMES && !is(text, n_name, names[name].name))
		name++;
	if (name == FW_IMU_NAMES)
		return complain(problem, text, n_name,
		                "no such name; they are time, gx, ax, mx, baro, lat, ...");
	if (map->entry[name].wanted)
		return complain(problem, text, n_name, "named twice");
	n -= n_name + 1;
	const size_t n_tag = before(column, n, '@');
	if (n_tag < n) {
		if (n_tag == 0 || n_tag >= sizeof c.tag)
			return complain(problem, text, n_name, "the word before @ has 1 to 15 bytes");
		memcpy(c.tag, column, n_tag);
		column += n_tag + 1;
		n -= n_tag + 1;
	}
	const size_t n_column = before(column, n, ':');
	status = take_column(column, n_column, &c, problem);
	if (status == FW_OK && n_column + 1 == n)
		return complain(problem, text, n_name, "a unit is missing after the colon");
	if (status == FW_OK)
		status = take_unit(n_column < n ? column + n_column + 1 : "",
		                   n_column < n ? n - n_column - 1 : 0, name, &c, problem);
	if (status == FW_OK)
		map->entry[name] = c;
	return status;
}

/* ---- what belongs together ---- */

/* Of n names either all are wanted, from lines of one kind, or none. */
static bool all_or_none(const fw_imu_map *map, fw_imu_name first, int n)
{
	const fw_imu_column *e = &map->entry[first];

	for (int i = 1; i < n; i++)
		if (e[i].wanted != e[0].wanted || strcmp(e[i].tag, e[0].tag) != 0 ||
		    e[i].increment != e[0].increment)
			return false;
	return true;
}

static fw_status check_map(const fw_imu_map *map, fw_imu_problem *problem)
{
	static const struct {
		fw_imu_name first;
		int n;
		const char *names;
	} groups[] = {
	    {FW_IMU_GX, 3, "gx gy gz"},         {FW_IMU_AX, 3, "ax ay az"},
	    {FW_IMU_MX, 3, "mx my mz"},         {FW_IMU_LAT, 3, "lat lon height"},
	    {FW_IMU_VN, 3, "vn ve vd"},         {FW_IMU_SDN, 3, "sdn sde sdd"},
	    {FW_IMU_SDVN, 3, "sdvn sdve sdvd"}, {FW_IMU_NLAT, 3, "nlat nlon nheight"},
	    {FW_IMU_NVN, 3, "nvn nve nvd"},     {FW_IMU_ROLL, 3, "roll pitch heading"},
	};
	bool any = false;

	for (fw_imu_name i = FW_IMU_GX; i < FW_IMU_NAMES; i++)
		any |= map->entry[i].wanted;
	if (!map->entry[FW_IMU_TIME].wanted)
		return complain(problem, "time", 4, "needed");
	if (!any)
		return complain(problem, "time", 4, "nothing else is named");
	for (size_t i = 0; i < sizeof groups / sizeof *groups; i++)
		if (!all_or_none(map, groups[i].first, groups[i].n))
			return complain(problem, groups[i].names, strlen(groups[i].names),
			                "all of these or none, and of the same kind");
	if (map->entry[FW_IMU_GX].wanted != map->entry[FW_IMU_AX].wanted ||
	    strcmp(map->entry[FW_IMU_GX].tag, map->entry[FW_IMU_AX].tag) != 0)
		return complain(problem, "gx gy gz ax ay az", 17,
		                "all of these or none, and of the same kind");
	if (map->entry[FW_IMU_VN].wanted && !map->entry[FW_IMU_LAT].wanted)
		return complain(problem, "vn ve vd", 8, "a velocity needs a position, lat lon height");
	return FW_OK;
}

fw_status fw_imu_parse_columns(const char *text, fw_imu_map *map, fw_imu_problem *problem)
{
	fw_imu_map m = {.given = true};

	if (strcmp(text, "kf-gins") == 0) {
		m.kf_gins = true;
		*map = m;
		return FW_OK;
	}
	for (size_t i = 0; i < sizeof layouts / sizeof *layouts; i++)
		if (strcmp(text, layouts[i].word) == 0)
			text = layouts[i].map;
	while (*text != '\0') {
		const size_t n = entry_length(text);
		fw_status status = FW_OK;

		if (n > WORD_MAX)
			status = complain(problem, text, n, "too long");
		else if (n > 0)
			status = take_entry(text, n, &m, problem);
		if (status != FW_OK)
			return status;
		text += n + (text[n] != '\0');
	}
	if (check_map(&m, problem) != FW_OK)
		return FW_ESYNTAX;
	*map = m;
	return FW_OK;
}

/* ---- axes ---- */

/* "-y" to a row of the permutation. */
static bool take_axis(const char *text, size_t n, int row, fw_imu_axes *axes)
{
	axes->sign[row] = 1;
	if (n == 2 && (text[0] == '-' || text[0] == '+')) {
		axes->sign[row] = text[0] == '-' ? -1 : 1;
		text++;
		n--;
	}
	if (n != 1 || text[0] < 'x' || text[0] > 'z')
		return false;
	axes->from[row] = text[0] - 'x';
	return true;
}

/* +1 or -1 of a permutation that is one, else 0. */
static double determinant(const fw_imu_axes *a)
{
	const int i = a->from[0], j = a->from[1], k = a->from[2];

	return (double)((j - i) * (k - i) * (k - j)) / 2 * a->sign[0] * a->sign[1] * a->sign[2];
}

fw_status fw_imu_parse_axes(const char *text, fw_imu_axes *axes, fw_imu_problem *problem)
{
	static const char *const known[][2] = {{"FRD", "x,y,z"}, {"FLU", "x,-y,-z"}, {"RFU", "y,x,-z"}};
	const char *p = text;
	fw_imu_axes a = {.given = true};

	for (size_t i = 0; i < sizeof known / sizeof *known; i++)
		if (strcmp(text, known[i][0]) == 0)
			p = known[i][1];
	for (int row = 0; row < 3; row++) {
		const size_t n = strcspn(p, ",");

		if (!take_axis(p, n, row, &a) || (p[n] == ',') != (row < 2))
			return complain(problem, text, strlen(text),
			                "neither FRD, FLU, RFU nor three axes such as -y,x,z");
		p += n + 1;
	}
	if (determinant(&a) != 1)
		return complain(problem, text, strlen(text),
		                "these axes are left-handed, or one comes twice");
	*axes = a;
	return FW_OK;
}

void fw_imu_turn(const fw_imu_axes *axes, const double sensor[static 3], double body[static 3])
{
	const double v[3] = {sensor[0], sensor[1], sensor[2]};

	for (int i = 0; i < 3; i++)
		body[i] = axes->sign[i] * v[axes->from[i]];
}

/* ---- time ---- */

/* KEY=VALUE of --imu-time, NUL-terminated value in `value`. */
static fw_status take_setting(const char *text, size_t n, fw_imu_clock *clock, fw_imu_problem *problem)
{
	const size_t n_key = before(text, n, '=');
	const char *value = text + n_key + 1;
	const size_t n_value = n_key < n ? n - n_key - 1 : 0;
	char copy[64];
	int64_t week;

	if (n_value == 0 || n_value >= sizeof copy)
		return complain(problem, text, n, "not week=N, start=TIME or shift=SECONDS");
	memcpy(copy, value, n_value);
	copy[n_value] = '\0';
	if (is(text, n_key, "week")) {
		if (fw_get_i64(copy, n_value, &week) != FW_OK || week < 0 || week > FW_TIME_WEEK_MAX)
			return complain(problem, text, n, "no GPS week, 0 to 8191");
		clock->week = (int)week;
		clock->has_week = true;
	} else if (is(text, n_key, "start")) {
		if (fw_time_parse(copy, &clock->start) < 0)
			return complain(problem, text, n,
			                "no time, such as 2380:408600.5 or 2025-08-28T17:30:00Z");
		clock->has_start = true;
	} else if (is(text, n_key, "shift")) {
		if (fw_get_double(copy, n_value, &clock->shift_s) != FW_OK ||
		    !(fabs(clock->shift_s) <= 86400))
			return complain(problem, text, n, "no number of seconds within a day");
	} else {
		return complain(problem, text, n, "not week=N, start=TIME or shift=SECONDS");
	}
	return FW_OK;
}

static bool take_scale(const char *text, size_t n, fw_imu_scale *scale)
{
	static const char *const words[] = {"auto", "unix-utc", "unix-gps", "gps", "boot"};

	for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
		if (is(text, n, words[i])) {
			*scale = (fw_imu_scale)i;
			return true;
		}
	}
	return false;
}

fw_status fw_imu_parse_time(const char *text, fw_imu_clock *clock, fw_imu_problem *problem)
{
	fw_imu_clock c = {0};
	size_t n = strcspn(text, ",");

	if (!take_scale(text, n, &c.scale))
		return complain(problem, text, n, "not unix-utc, unix-gps, gps or boot");
	while (text[n] == ',') {
		text += n + 1;
		n = strcspn(text, ",");
		if (take_setting(text, n, &c, problem) != FW_OK)
			return FW_ESYNTAX;
	}
	*clock = c;
	return FW_OK;
}

void fw_imu_plan_begin(fw_imu_plan *plan)
{
	memset(plan, 0, sizeof *plan);
	plan->axes = (fw_imu_axes){false, {0, 1, 2}, {1, 1, 1}};
}
