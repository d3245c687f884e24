#include "formats/imu_text.h"

#include <math.h>
#include <string.h>

#include "formats/number.h"

#define UNKNOWN    ((double)NAN)
#define UNIX_LEAST 5e8 /* a time of so many seconds counts from 1970 */

/** IS-GPS-200N, 3.3.4: 1980-01-06T00:00:00, in seconds of Unix time */
#define GPS_EPOCH_UNIX_S INT64_C(315964800)

/* ISO 2533:1975, 2.1: temperature by its gradient, and exponent, up to 11 km */
#define ISA_HEIGHT_M 44330.769
#define ISA_EXPONENT 0.190263
#define ISA_PA       101325.0

enum { LEAST_SATELLITES = 4, LEAST_FIX = 3, KF_GINS_NAV_COLUMNS = 11 };

static const char euroc_header[] = "#timestamp [ns],w_RS_S_x";

typedef struct {
	const char *text;
	size_t n;
} field;

/* A line's fields, and what the plan makes of them: NaN where there is nothing. */
typedef struct {
	int n;
	field field[FW_IMU_COLUMN_MAX];
	double value[FW_IMU_NAMES];
	int64_t time_ns, fixtime_ns; /* as they stand */
	bool named;                  /* of a kind that the plan names */
} row;

bool fw_imu_text_detect(const uint8_t *bytes, size_t n)
{
	return n >= sizeof euroc_header - 1 && memcmp(bytes, euroc_header, sizeof euroc_header - 1) == 0;
}

void fw_imu_text_again(fw_imu_text *r, fw_input *input)
{
	fw_lines_begin(&r->lines, input);
	r->rows = r->lost = r->untimed = r->passed_over = 0;
	r->queue.n = 0;
	r->final = FW_OK;
	r->surveying = r->begun = r->is_euroc = r->has_last = r->has_fix = false;
	r->overlong = 0;
	r->n_header = 0;
	r->rates = (fw_imu_rates){0};
}

void fw_imu_text_begin(fw_imu_text *r, fw_input *input, const fw_imu_plan *plan)
{
	r->problem = (fw_imu_text_problem){.name = "", .reason = ""};
	r->queue.first = 0;
	if (plan != NULL)
		r->plan = *plan;
	else
		fw_imu_plan_begin(&r->plan);
	fw_boot_clock_begin(&r->clock);
	fw_imu_text_again(r, input);
}

static bool clock_from_fixes(const fw_imu_text *r)
{
	return r->plan.clock.scale == FW_SCALE_BOOT && !r->plan.clock.has_start;
}

bool fw_imu_text_wants_survey(const fw_imu_text *r)
{
	return clock_from_fixes(r);
}

/* ---- problems ---- */

static fw_status problem(fw_imu_text *r, fw_status status, int column, const char *name, const char *reason)
{
	r->problem = (fw_imu_text_problem){r->lines.number, column, name, reason};
	return status;
}

/* The entry's value makes the line useless. */
static fw_status refuse(fw_imu_text *r, fw_imu_name name, const char *reason)
{
	return problem(r, FW_ESYNTAX, r->column[name], fw_imu_name_text(name), reason);
}

/* ---- fields ---- */

static void trim(field *f)
{
	while (f->n > 0 && (f->text[0] == ' ' || f->text[0] == '\t')) {
		f->text++;
		f->n--;
	}
	while (f->n > 0 && (f->text[f->n - 1] == ' ' || f->text[f->n - 1] == '\t'))
		f->n--;
	if (f->n >= 2 && f->text[0] == '"' && f->text[f->n - 1] == '"') {
		f->text++;
		f->n -= 2;
	}
}

/* Tabs and blanks together are blanks. */
static char separator_of(const char *text, size_t n)
{
	if (memchr(text, ',', n) != NULL)
		return ',';
	if (memchr(text, ';', n) != NULL)
		return ';';
	return memchr(text, '\t', n) != NULL && memchr(text, ' ', n) == NULL ? '\t' : ' ';
}

/* Splits a line; returns the number of fields, at most FW_IMU_COLUMN_MAX. Further ones are not looked at. */
static int split(const char *text, size_t n, char separator, field *fields)
{
	const char *const end = text + n;
	int count = 0;

	while (count < FW_IMU_COLUMN_MAX) {
		const char *stop = text;

		if (separator == ' ')
			while (text < end && (*text == ' ' || *text == '\t'))
				text++;
		if (separator == ' ' && text == end)
			break;
		for (stop = text; stop < end && *stop != separator && !(separator == ' ' && *stop == '\t');)
			stop++;
		fields[count] = (field){text, (size_t)(stop - text)};
		trim(&fields[count++]);
		if (stop == end)
			break;
		text = stop + 1;
	}
	return count;
}

static bool is_number(field f)
{
	double x;

	return fw_get_double(f.text, f.n, &x) == FW_OK;
}

/* "", "nan": nothing there. */
static bool is_absent(field f)
{
	return f.n == 0 ||
	       (f.n == 3 && (f.text[0] | 32) == 'n' && (f.text[1] | 32) == 'a' && (f.text[2] | 32) == 'n');
}

/* A decimal number, times 10^power, to an integer: exact as far as the digits say. */
static bool decimal_ns(field f, int power, int64_t *ns)
{
	const bool minus = f.n > 0 && f.text[0] == '-';
	int64_t x = 0;
	int after = -1; /* digits behind the point; -1: no point yet */

	for (size_t i = minus; i < f.n; i++) {
		const char c = f.text[i];

		if (c == '.' && after < 0) {
			after = 0;
		} else if (c < '0' || c > '9' || x > (INT64_MAX - 9) / 10) {
			return false;
		} else if (after < power) {
			x = 10 * x + (c - '0');
			after += after >= 0;
		} else if (after == power) { /* the digit that rounds */
			x += c >= '5';
			after++;
		}
	}
	for (int i = after < 0 ? 0 : after; i < power; i++) {
		if (x > INT64_MAX / 10)
			return false;
		x *= 10;
	}
	*ns = minus ? -x : x;
	return true;
}

/* A time as it stands to nanoseconds. */
static bool time_ns(field f, double scale, int64_t *ns)
{
	const int power = scale == 1e9 ? 9 : scale == 1e6 ? 6 : scale == 1e3 ? 3 : scale == 1 ? 0 : -1;
	double x;

	if (fw_get_double(f.text, f.n, &x) != FW_OK || !(fabs(x * scale) < 9e18))
		return false;
	if (power < 0 || !decimal_ns(f, power, ns))
		*ns = llround(x * scale);
	return true;
}

/* ---- the beginning of a table ---- */

/* A column by its name in the header. */
static int find_column(const fw_imu_text *r, const char *name)
{
	field fields[FW_IMU_COLUMN_MAX];
	const char separator = r->separator == '\t' ? '\t' : separator_of(r->header, r->n_header);
	const int n = split(r->header, r->n_header, separator, fields);

	for (int i = 0; i < n; i++)
		if (strlen(name) == fields[i].n && memcmp(name, fields[i].text, fields[i].n) == 0)
			return i + 1;
	return 0;
}

static void use_layout(fw_imu_text *r, const char *word)
{
	fw_imu_problem unused;

	(void)!fw_imu_parse_columns(word, &r->plan.map, &unused); /* known layouts are right */
}

/* Which of KF-GINS' three layouts a line has. Degrees of latitude and longitude are no increments of an IMU.
 * */
static void use_kf_gins(fw_imu_text *r, const row *line)
{
	double lat = 0, lon = 0;
	const bool place =
	    line->n >= 7 && fw_get_double(line->field[1].text, line->field[1].n, &lat) == FW_OK &&
	    fw_get_double(line->field[2].text, line->field[2].n, &lon) == FW_OK && fabs(lat) + fabs(lon) > 2;

	use_layout(r, line->n >= KF_GINS_NAV_COLUMNS ? "kf-gins-nav"
	              : place                        ? "kf-gins-gnss"
	                                             : "kf-gins-imu");
	if (r->plan.clock.scale == FW_SCALE_AUTO)
		r->plan.clock.scale = FW_SCALE_GPS;
}

/* What the time counts, where the user left it to us, and whether all is known that it takes. */
static fw_status choose_scale(fw_imu_text *r, const row *line)
{
	const fw_imu_column *e = r->plan.map.entry;
	fw_imu_clock *c = &r->plan.clock;
	const bool has_week = c->has_week || e[FW_IMU_WEEK].wanted;
	const int at = r->column[FW_IMU_TIME] - 1;
	int64_t ns;

	if (c->scale == FW_SCALE_AUTO && has_week)
		c->scale = FW_SCALE_GPS;
	if (c->scale == FW_SCALE_AUTO && at < line->n &&
	    time_ns(line->field[at], e[FW_IMU_TIME].scale, &ns) && (double)ns >= UNIX_LEAST * 1e9)
		c->scale = FW_SCALE_UNIX_UTC;
	if (c->scale == FW_SCALE_AUTO)
		return problem(r, FW_EUNKNOWN, at + 1, "time", "--imu-time has to say what it counts");
	if (c->scale == FW_SCALE_GPS && !has_week)
		return problem(r, FW_EUNKNOWN, at + 1, "time", "which GPS week? --imu-time gps,week=N");
	if (clock_from_fixes(r) && !(c->has_week && e[FW_IMU_FIXTIME].wanted))
		return problem(r, FW_EUNKNOWN, at + 1, "time",
		               "when was 0? --imu-time boot,start=TIME, or boot,week=N and a column fixtime");
	return FW_OK;
}

/* The first line of data: where are the columns? */
static fw_status begin_table(fw_imu_text *r, const row *line)
{
	const fw_imu_column *e = r->plan.map.entry;

	if (!r->plan.map.given && r->is_euroc)
		use_layout(r, "euroc");
	if (!r->plan.map.given)
		return problem(r, FW_EUNKNOWN, 0, "", "--imu-columns has to say what the columns are");
	if (r->plan.map.kf_gins)
		use_kf_gins(r, line);
	for (fw_imu_name i = 0; i < FW_IMU_NAMES; i++) {
		r->column[i] = e[i].column;
		if (e[i].wanted && e[i].column == 0)
			r->column[i] = find_column(r, e[i].name);
		if (e[i].wanted && r->column[i] == 0)
			return problem(r, FW_EUNKNOWN, 0, fw_imu_name_text(i),
			               "the table's header has no column of the name given for it");
	}
	r->begun = true;
	return choose_scale(r, line);
}

/* A line that is no data: the last of them has the names. */
static void keep_header(fw_imu_text *r, const fw_line *line)
{
	size_t mark = 0;

	if (fw_imu_text_detect((const uint8_t *)line->text, line->n))
		r->is_euroc = true;
	while (mark < line->n && memchr("#%/ ", line->text[mark], 4) != NULL)
		mark++;
	r->n_header = line->n - mark;
	memcpy(r->header, line->text + mark, r->n_header);
}

/* ---- a line's numbers ---- */

static bool has_tags(const fw_imu_text *r)
{
	for (int i = 0; i < FW_IMU_NAMES; i++)
		if (r->plan.map.entry[i].tag[0] != '\0')
			return true;
	return false;
}

/* The word that says which kind of line it is. */
static field tag_of(const row *line)
{
	for (int i = 0; i < line->n; i++)
		if (!is_number(line->field[i]))
			return line->field[i];
	return (field){"", 0};
}

static fw_status take_value(fw_imu_text *r, fw_imu_name name, row *line)
{
	const fw_imu_column *e = &r->plan.map.entry[name];
	const int at = r->column[name] - 1;
	double x;

	if (at >= line->n || is_absent(line->field[at]))
		return FW_OK;
	if (fw_get_double(line->field[at].text, line->field[at].n, &x) != FW_OK)
		return refuse(r, name, "no number");
	if ((name == FW_IMU_TIME && !time_ns(line->field[at], e->scale, &line->time_ns)) ||
	    (name == FW_IMU_FIXTIME && !time_ns(line->field[at], e->scale, &line->fixtime_ns)))
		return refuse(r, name, "no time");
	line->value[name] = x * e->scale;
	return isfinite(line->value[name]) ? FW_OK : refuse(r, name, "too large");
}

static fw_status take_values(fw_imu_text *r, row *line)
{
	const field tag = has_tags(r) ? tag_of(line) : (field){"", 0};
	fw_status status = FW_OK;

	line->named = !has_tags(r);
	for (fw_imu_name i = 0; i < FW_IMU_NAMES && status == FW_OK; i++) {
		const fw_imu_column *e = &r->plan.map.entry[i];
		const bool tagged = e->tag[0] != '\0';

		line->value[i] = UNKNOWN;
		if (!e->wanted ||
		    (tagged && !(strlen(e->tag) == tag.n && memcmp(e->tag, tag.text, tag.n) == 0)))
			continue;
		line->named |= tagged;
		status = take_value(r, i, line);
	}
	return status;
}

/* Of n values that belong together: 1 all there, 0 none, -1 some. */
static int together(const row *line, fw_imu_name first, int n)
{
	int there = 0;

	for (int i = 0; i < n; i++)
		there += isfinite(line->value[first + (fw_imu_name)i]);
	return there == n ? 1 : there == 0 ? 0 : -1;
}

static fw_status check_groups(fw_imu_text *r, const row *line)
{
	static const struct {
		fw_imu_name first;
		int n;
		const char *reason;
	} groups[] = {
	    {FW_IMU_GX, 6, "part of the IMU sample is missing"},
	    {FW_IMU_MX, 3, "part of the magnetic field is missing"},
	    {FW_IMU_LAT, 3, "part of the position is missing"},
	    {FW_IMU_VN, 3, "part of the velocity is missing"},
	    {FW_IMU_NLAT, 3, "part of the reference is missing"},
	    {FW_IMU_NVN, 3, "part of the reference is missing"},
	    {FW_IMU_ROLL, 3, "part of the attitude is missing"},
	};
	bool any = isfinite(line->value[FW_IMU_BARO]);

	if (!isfinite(line->value[FW_IMU_TIME]))
		return refuse(r, FW_IMU_TIME, "no time");
	for (size_t i = 0; i < sizeof groups / sizeof *groups; i++) {
		const int all = together(line, groups[i].first, groups[i].n);

		if (all < 0)
			return refuse(r, groups[i].first, groups[i].reason);
		any |= all > 0;
	}
	return any ? FW_OK : problem(r, FW_ESYNTAX, 0, "", "no value in it");
}

/* ---- time ---- */

/* The moment of a time of week that is nearest to another moment. */
static fw_time nearest_week(fw_time near, int64_t tow_ns)
{
	int64_t difference = (tow_ns - near.ns) % FW_NS_PER_WEEK;

	if (difference > FW_NS_PER_WEEK / 2)
		difference -= FW_NS_PER_WEEK;
	if (difference < -FW_NS_PER_WEEK / 2)
		difference += FW_NS_PER_WEEK;
	return fw_time_add_ns(near, difference);
}

/* Time of week to a moment; `week` of the line, NaN: the week is counted on. */
static fw_status gps_time(fw_imu_text *r, double week, int64_t tow_ns, fw_time *t)
{
	const double first = r->plan.clock.has_week ? r->plan.clock.week : UNKNOWN;
	const double known = isfinite(week) ? week : first;

	if (tow_ns < 0 || tow_ns > 2 * FW_NS_PER_WEEK)
		return FW_ERANGE;
	if (!isfinite(week) && r->has_last) {
		*t = nearest_week(r->last, tow_ns);
	} else {
		if (!(known >= 0 && known <= FW_TIME_WEEK_MAX))
			return FW_ERANGE;
		t->ns = (int64_t)known * FW_NS_PER_WEEK + tow_ns;
	}
	if (t->ns < 0 || t->ns > FW_TIME_NS_MAX)
		return FW_ERANGE;
	r->has_last = true;
	r->last = *t;
	return FW_OK;
}

static fw_status unix_time(int64_t ns, bool utc, fw_time *t)
{
	const int64_t us = ns >= 0 ? ns / 1000 : -1;

	if (!utc) {
		t->ns = ns - GPS_EPOCH_UNIX_S * FW_NS_PER_S;
		return ns >= 0 ? FW_OK : FW_ERANGE;
	}
	if (fw_time_from_unix_us(us, t) < 0)
		return FW_ERANGE;
	*t = fw_time_add_ns(*t, ns % 1000);
	return FW_OK;
}

/* A time as it stands to a moment. */
static fw_status moment(fw_imu_text *r, double week, int64_t ns, fw_time *t)
{
	const fw_imu_clock *c = &r->plan.clock;
	fw_status status = FW_OK;

	switch (c->scale) {
	case FW_SCALE_UNIX_UTC: status = unix_time(ns, true, t); break;
	case FW_SCALE_UNIX_GPS: status = unix_time(ns, false, t); break;
	case FW_SCALE_AUTO:
	case FW_SCALE_GPS: status = gps_time(r, week, ns, t); break;
	case FW_SCALE_BOOT:
		if (clock_from_fixes(r)) {
			status = fw_boot_clock_time(&r->clock, ns / 1000, c->shift_s, t);
			return status == FW_OK ? (t->ns += ns % 1000, FW_OK) : status;
		}
		if (ns < -FW_TIME_NS_MAX || ns > FW_TIME_NS_MAX)
			return FW_ERANGE;
		*t = fw_time_add_ns(c->start, ns);
		break;
	}
	if (status == FW_OK)
		*t = fw_time_add_ns(*t, llround(c->shift_s * 1e9));
	return status == FW_OK && (t->ns < 0 || t->ns > FW_TIME_NS_MAX) ? FW_ERANGE : status;
}

/* ---- records ---- */

static fw_status put_imu(fw_imu_text *r, const row *line, fw_time t)
{
	const fw_imu_column *e = r->plan.map.entry;
	double dt = 1, gyro[3], accel[3];

	if (together(line, FW_IMU_GX, 6) == 0)
		return FW_OK;
	if (e[FW_IMU_GX].increment || e[FW_IMU_AX].increment) {
		const fw_status status = fw_imu_rates_interval(&r->rates, t, &dt);

		if (status == FW_MORE)
			return FW_OK;
		if (status != FW_OK)
			return refuse(r, FW_IMU_TIME, "increments, and the time does not advance");
	}
	for (int i = 0; i < 3; i++) {
		gyro[i] = line->value[FW_IMU_GX + i] / (e[FW_IMU_GX].increment ? dt : 1);
		accel[i] = line->value[FW_IMU_AX + i] / (e[FW_IMU_AX].increment ? dt : 1);
	}
	fw_imu_turn(&r->plan.axes, gyro, gyro);
	fw_imu_turn(&r->plan.axes, accel, accel);
	return fw_log_put_imu(&r->queue, t, gyro, accel);
}

static fw_status put_mag(fw_imu_text *r, const row *line, fw_time t)
{
	double field_ut[3];

	if (together(line, FW_IMU_MX, 3) == 0)
		return FW_OK;
	fw_imu_turn(&r->plan.axes, &line->value[FW_IMU_MX], field_ut);
	return fw_log_put_mag(&r->queue, t, field_ut);
}

static fw_status put_baro(fw_imu_text *r, const row *line, fw_time t)
{
	double x = line->value[FW_IMU_BARO];

	if (!isfinite(x))
		return FW_OK;
	if (r->plan.map.entry[FW_IMU_BARO].pressure) {
		if (!(x > 0))
			return refuse(r, FW_IMU_BARO, "no pressure");
		x = ISA_HEIGHT_M * (1 - pow(x / ISA_PA, ISA_EXPONENT));
	}
	return fw_log_put_baro(&r->queue, t, x);
}

/* A position that is one, and not the one of the line before. */
static bool is_new_fix(fw_imu_text *r, const row *line)
{
	const bool timed = r->plan.map.entry[FW_IMU_FIXTIME].wanted;
	double now[7] = {0};

	if (together(line, FW_IMU_LAT, 3) != 1 || line->value[FW_IMU_NSATS] < LEAST_SATELLITES ||
	    line->value[FW_IMU_FIX] < LEAST_FIX ||
	    (line->value[FW_IMU_LAT] == 0 && line->value[FW_IMU_LON] == 0) ||
	    (timed && !isfinite(line->value[FW_IMU_FIXTIME])))
		return false;
	if (timed)
		now[0] = line->value[FW_IMU_FIXTIME];
	else
		memcpy(now + 1, &line->value[FW_IMU_LAT], 6 * sizeof *now);
	if (r->has_fix && memcmp(now, r->last_fix, sizeof now) == 0)
		return false;
	r->has_fix = true;
	memcpy(r->last_fix, now, sizeof now);
	return true;
}

/* Where fixes set the clock: the moment of one, and what it says of the clock. */
static fw_status learn_clock(fw_imu_text *r, const row *line, fw_time *t)
{
	if (gps_time(r, UNKNOWN, line->fixtime_ns, t) != FW_OK)
		return refuse(r, FW_IMU_FIXTIME, "no time of week");
	if (line->time_ns >= 0)
		fw_boot_clock_add(&r->clock, line->time_ns / 1000, *t);
	return FW_OK;
}

static fw_status put_fix(fw_imu_text *r, const row *line, fw_time t)
{
	const double *v = line->value;
	fw_log_fix fix = fw_log_no_fix();
	fw_status status;

	fix.lat_deg = v[FW_IMU_LAT];
	fix.lon_deg = v[FW_IMU_LON];
	fix.height_m = v[FW_IMU_HEIGHT];
	memcpy(fix.velocity_mps, &v[FW_IMU_VN], sizeof fix.velocity_mps);
	memcpy(fix.sd_m, &v[FW_IMU_SDN], sizeof fix.sd_m);
	memcpy(fix.sd_velocity_mps, &v[FW_IMU_SDVN], sizeof fix.sd_velocity_mps);
	if (v[FW_IMU_NSATS] >= 0 && v[FW_IMU_NSATS] <= INT16_MAX)
		fix.n_sats = (int)v[FW_IMU_NSATS];
	status = fw_log_put_pos(&r->queue, t, &fix, NULL, UNKNOWN);
	return status == FW_OK ? FW_OK : refuse(r, FW_IMU_LAT, "no place on the Earth");
}

static fw_status put_nav(fw_imu_text *r, const row *line, fw_time t)
{
	const double *v = line->value;
	fw_log_nav nav = fw_log_no_nav();

	if (together(line, FW_IMU_NLAT, 3) == 0 && together(line, FW_IMU_NVN, 3) == 0 &&
	    together(line, FW_IMU_ROLL, 3) == 0)
		return FW_OK;
	if (v[FW_IMU_NLAT] == 0 && v[FW_IMU_NLON] == 0)
		return FW_OK; /* that filter does not run yet */
	nav.lat_deg = v[FW_IMU_NLAT];
	nav.lon_deg = v[FW_IMU_NLON];
	nav.height_m = v[FW_IMU_NHEIGHT];
	memcpy(nav.velocity_mps, &v[FW_IMU_NVN], sizeof nav.velocity_mps);
	memcpy(nav.angle_deg, &v[FW_IMU_ROLL], sizeof nav.angle_deg);
	return fw_log_put_nav(&r->queue, t, &nav, "reference") == FW_OK
	           ? FW_OK
	           : refuse(r, FW_IMU_NLAT, "no place on the Earth");
}

/* What a line of numbers becomes; on failure nothing of it stays. */
static fw_status put_row(fw_imu_text *r, const row *line)
{
	fw_time t, fix_time;
	const bool new_fix = is_new_fix(r, line);
	const bool own_time = r->plan.map.entry[FW_IMU_FIXTIME].wanted;
	fw_status status = FW_OK;

	if (new_fix && clock_from_fixes(r))
		status = learn_clock(r, line, &fix_time);
	if (status != FW_OK || r->surveying)
		return status;
	status = moment(r, line->value[FW_IMU_WEEK], line->time_ns, &t);
	if (status == FW_MORE) {
		r->untimed++;
		return FW_OK;
	}
	if (status != FW_OK)
		return refuse(r, FW_IMU_TIME, "no GPS time");
	if (new_fix && own_time && !clock_from_fixes(r) &&
	    moment(r, line->value[FW_IMU_WEEK], line->fixtime_ns, &fix_time) != FW_OK)
		return refuse(r, FW_IMU_FIXTIME, "no GPS time");
	status = put_imu(r, line, t);
	if (status == FW_OK)
		status = put_mag(r, line, t);
	if (status == FW_OK)
		status = put_baro(r, line, t);
	if (status == FW_OK && new_fix)
		status = put_fix(r, line, own_time ? fix_time : t);
	if (status == FW_OK)
		status = put_nav(r, line, t);
	if (status != FW_OK)
		r->queue.n = 0;
	return status == FW_OK || status == FW_ESYNTAX ? status
	                                               : problem(r, FW_ESYNTAX, 0, "", "a value too large");
}

/* ---- lines ---- */

static bool is_blank(const fw_line *line)
{
	size_t i = 0;

	while (i < line->n && (line->text[i] == ' ' || line->text[i] == '\t'))
		i++;
	return i == line->n;
}

static bool is_comment(const fw_line *line)
{
	return line->text[0] == '#' || line->text[0] == '%' ||
	       (line->n > 1 && memcmp(line->text, "//", 2) == 0);
}

static bool is_data(const fw_imu_text *r, const row *line)
{
	if (line->n > 0 && is_number(line->field[0]))
		return true;
	for (int i = 0; has_tags(r) && i < line->n; i++)
		if (is_number(line->field[i]))
			return true;
	return false;
}

static fw_status take_line(fw_imu_text *r, fw_line *text)
{
	fw_status status = FW_OK;
	row line = {.n = 0};

	if (text->number == 1 && text->n >= 3 && memcmp(text->text, "\xef\xbb\xbf", 3) == 0) {
		text->text += 3; /* byte order mark */
		text->n -= 3;
	}
	if (is_blank(text))
		return FW_OK;
	if (!r->begun)
		r->separator = separator_of(text->text, text->n);
	line.n = is_comment(text) ? 0 : split(text->text, text->n, r->separator, line.field);
	if (!r->begun && (is_comment(text) || !is_data(r, &line))) {
		keep_header(r, text);
		return FW_OK;
	}
	if (is_comment(text))
		return FW_OK;
	if (!r->begun)
		status = begin_table(r, &line);
	if (status == FW_OK)
		status = take_values(r, &line);
	if (status == FW_OK && !line.named) {
		r->passed_over++;
		return FW_OK;
	}
	if (status == FW_OK)
		status = check_groups(r, &line);
	if (status == FW_OK)
		status = put_row(r, &line);
	r->rows += status == FW_OK;
	return status;
}

/* Reads until there is something to hand out. */
static fw_status advance(fw_imu_text *r)
{
	fw_line line;
	fw_status status = fw_lines_next(&r->lines, &line);

	if (status == FW_OK && r->lines.overlong != r->overlong) {
		r->overlong = r->lines.overlong;
		status = problem(r, FW_ESYNTAX, 0, "", "a line that is too long");
	} else if (status == FW_OK) {
		status = take_line(r, &line);
	}
	r->lost += status == FW_ESYNTAX || status == FW_EUNKNOWN;
	if (status != FW_OK && status != FW_ESYNTAX)
		r->final = status;
	return status;
}

fw_status fw_imu_text_read(fw_imu_text *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status;

	do {
		if (fw_log_take(&r->queue, kind, record) == FW_OK)
			return FW_OK;
		status = r->final == FW_OK ? advance(r) : r->final;
	} while (status == FW_OK);
	return status;
}

fw_status fw_imu_text_survey(fw_imu_text *r)
{
	fw_status status;

	r->surveying = true;
	do
		status = advance(r);
	while (status == FW_OK || status == FW_ESYNTAX);
	fw_boot_clock_learn(&r->clock);
	return status;
}
