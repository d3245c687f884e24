#include "formats/rtklib_pos.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "formats/number.h"

#define UNKNOWN ((double)NAN)

enum { FIELDS = 40, JST_HOURS = 9, WEEK_MOST = 8191 };

typedef struct {
	const char *text;
	size_t n;
} field;

/* What is said behind the position, NaN where there is nothing. */
typedef struct {
	double quality, n_sats, sd[6], age_s, ratio, velocity[3], sd_velocity[6];
} remainder_of_line;

static bool contains(const char *text, size_t n, const char *word)
{
	return memmem(text, n, word, strlen(word)) != NULL;
}

bool fw_rtklib_pos_detect(const uint8_t *bytes, size_t n)
{
	static const char *const words[] = {
	    "% program",     "latitude(deg)",      "latitude(d'\")", "x-ecef(m)",
	    "e-baseline(m)", "% (lat/lon/height=", "% (x/y/z-ecef="};

	if (n < 2 || bytes[0] != '%')
		return false;
	for (size_t i = 0; i < sizeof words / sizeof *words; i++)
		if (contains((const char *)bytes, n, words[i]))
			return true;
	return false;
}

void fw_rtklib_pos_begin(fw_rtklib_pos *r, fw_input *input)
{
	fw_lines_begin(&r->lines, input);
	r->problem = (fw_rinex_problem){0, ""};
	r->rows = r->lost = r->none = r->overlong = 0;
	r->msl = r->xyz = r->dms = r->baseline = r->jst = false;
	r->final = FW_OK;
	r->scale = FW_RINEX_GPS;
	r->queue.first = r->queue.n = 0;
}

static fw_status refuse(fw_rtklib_pos *r, const char *reason)
{
	r->problem = (fw_rinex_problem){r->lines.number, reason};
	return FW_ESYNTAX;
}

/* ---- header ---- */

static void take_header(fw_rtklib_pos *r, const fw_line *line)
{
	const bool llh = contains(line->text, line->n, "latitude(deg)"),
	           dms = contains(line->text, line->n, "latitude(d'\")"),
	           xyz = contains(line->text, line->n, "x-ecef(m)"),
	           baseline = contains(line->text, line->n, "e-baseline(m)");

	if (contains(line->text, line->n, "WGS84/geodetic"))
		r->msl = true;
	else if (contains(line->text, line->n, "WGS84/ellipsoidal"))
		r->msl = false;
	if (!llh && !dms && !xyz && !baseline)
		return;
	r->xyz = xyz;
	r->dms = dms;
	r->baseline = baseline;
	r->jst = contains(line->text, line->n, "JST");
	r->scale = r->jst || contains(line->text, line->n, "UTC") ? FW_RINEX_UTC : FW_RINEX_GPS;
}

/* ---- fields ---- */

static bool separates(char c)
{
	return c == ' ' || c == '\t' || c == ',' || c == ';';
}

static int split(const fw_line *line, field *fields)
{
	const char *p = line->text, *const end = p + line->n;
	int n = 0;

	while (n < FIELDS) {
		while (p < end && separates(*p))
			p++;
		if (p == end)
			break;
		fields[n].text = p;
		while (p < end && !separates(*p))
			p++;
		fields[n].n = (size_t)(p - fields[n].text);
		n++;
	}
	return n;
}

/* Whole numbers between separators: "2025/08/28", "17:30:39.749" with the last one to ns. */
static bool three_parts(field f, char separator, int part[3], int *ns)
{
	fw_line line = {f.text, f.n, 0, true};
	size_t from = 0;
	int64_t fraction;

	for (int i = 0; i < 3; i++) {
		const char *stop = i < 2 ? memchr(f.text + from, separator, f.n - from) : f.text + f.n;

		if (stop == NULL)
			return false;
		const size_t n = (size_t)(stop - f.text) - from;
		if (i == 2 && ns != NULL) {
			if (fw_rinex_seconds(&line, from, n, &fraction) != FW_OK)
				return false;
			part[2] = (int)(fraction / FW_NS_PER_S);
			*ns = (int)(fraction % FW_NS_PER_S);
		} else if (fw_rinex_int(&line, from, n, &part[i]) != FW_OK) {
			return false;
		}
		from += n + 1;
	}
	return true;
}

static fw_status date_and_time(const fw_rtklib_pos *r, field date, field clock, fw_time *t)
{
	int day[3], time[3], ns;
	fw_civil c;
	fw_status status;

	if (!three_parts(date, '/', day, NULL) || !three_parts(clock, ':', time, &ns))
		return FW_ESYNTAX;
	c = (fw_civil){day[0], day[1], day[2], time[0], time[1], time[2], ns};
	status = fw_rinex_moment(&c, r->scale, t);
	if (status >= 0 && r->jst)
		*t = fw_time_add_ns(*t, -JST_HOURS * 3600 * FW_NS_PER_S);
	return status < 0 ? status : FW_OK;
}

/* Week and time of week are of GPS time, whatever the header says of dates. */
static fw_status week_and_tow(field week, field tow, fw_time *t)
{
	double tow_s;
	int64_t w;

	if (fw_get_i64(week.text, week.n, &w) != FW_OK || w < 0 || w > WEEK_MOST ||
	    fw_get_double(tow.text, tow.n, &tow_s) != FW_OK)
		return FW_ESYNTAX;
	return fw_time_from_gps_s((int)w, tow_s, t);
}

/* ---- a solution ---- */

static double degrees(const double dms[static 3])
{
	const double size = fabs(dms[0]) + dms[1] / 60 + dms[2] / 3600;

	return signbit(dms[0]) ? -size : size;
}

/* Variance of ECEF components with RTKLIB's signed roots of covariances {xx yy zz xy yz zx} to deviations in
 * NED. */
static void turn_deviations(const double C_e_n[static 3][3], const double sd[static 6], double ned[static 3])
{
	static const int at[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

	for (int k = 0; k < 3; k++) {
		double variance = 0;

		for (int i = 0; i < 3; i++)
			for (int j = 0; j < 3; j++)
				variance += C_e_n[i][k] * C_e_n[j][k] * sd[at[i][j]] * fabs(sd[at[i][j]]);
		ned[k] = sqrt(variance); /* NaN if the file's covariance is none */
	}
}

/* A position in ECEF with what belongs to it. */
static fw_status take_xyz(const double position[static 3], const remainder_of_line *a, fw_log_fix *fix)
{
	double llh[3], C_e_n[3][3];

	if (fw_ecef_to_llh(position, llh) != FW_OK || !(llh[2] > -1e5))
		return FW_ERANGE;
	fw_frame_ned(llh[0], llh[1], C_e_n);
	fix->lat_deg = fw_deg_from_rad(llh[0]);
	fix->lon_deg = fw_deg_from_rad(llh[1]);
	fix->height_m = llh[2];
	turn_deviations((const double(*)[3])C_e_n, a->sd, fix->sd_m);
	fw_mat3_t_vec((const double(*)[3])C_e_n, a->velocity, fix->velocity_mps);
	turn_deviations((const double(*)[3])C_e_n, a->sd_velocity, fix->sd_velocity_mps);
	return FW_OK;
}

/* Latitude, longitude, height; the rest is north, east, up. */
static void take_llh(const fw_rtklib_pos *r, const double *v, const remainder_of_line *a, fw_log_fix *fix)
{
	fix->lat_deg = r->dms ? degrees(v) : v[0];
	fix->lon_deg = r->dms ? degrees(v + 3) : v[1];
	fix->height_m = v[r->dms ? 6 : 2];
	memcpy(fix->sd_m, a->sd, sizeof fix->sd_m);
	memcpy(fix->velocity_mps, a->velocity, sizeof fix->velocity_mps);
	fix->velocity_mps[2] = -fix->velocity_mps[2];
	memcpy(fix->sd_velocity_mps, a->sd_velocity, sizeof fix->sd_velocity_mps);
}

/* RTKLIB's Q as a word; NULL: no solution. */
static const char *quality_of(double q)
{
	static const char *const words[] = {NULL, "fixed", "float", "sbas", "dgnss", "single", "single"};

	return q >= 1 && q <= 6 ? words[(int)q] : NULL;
}

static fw_status put(fw_rtklib_pos *r, fw_time t, const double *position, const remainder_of_line *a)
{
	fw_log_fix fix = fw_log_no_fix();
	fw_status status = FW_OK;

	if (isfinite(a->quality) && quality_of(a->quality) == NULL) {
		r->none++;
		return FW_OK;
	}
	if (a->n_sats >= 0 && a->n_sats <= INT16_MAX)
		fix.n_sats = (int)a->n_sats;
	if (r->xyz)
		status = take_xyz(position, a, &fix);
	else
		take_llh(r, position, a, &fix);
	if (status == FW_OK)
		status = fw_log_put_pos(&r->queue, t, &fix, quality_of(a->quality), a->ratio);
	if (status != FW_OK)
		return refuse(r, "a position that is not on the Earth");
	r->rows++;
	return FW_OK;
}

/* ---- lines ---- */

/* Numbers from field `at` on; returns how many, or -1 when one is none. */
static int numbers(const field *fields, int at, int n, double *v)
{
	for (int i = at; i < n; i++)
		if (fw_get_double(fields[i].text, fields[i].n, &v[i - at]) != FW_OK)
			return -1;
	return n - at;
}

static fw_status take_solution(fw_rtklib_pos *r, const fw_line *line)
{
	field fields[FIELDS];
	double v[FIELDS];
	remainder_of_line a;
	fw_time t;
	const int n = split(line, fields);
	const int n_position = r->dms ? 7 : 3;
	const bool dated = n > 1 && memchr(fields[0].text, '/', fields[0].n) != NULL;

	if (n < 2 || (dated ? date_and_time(r, fields[0], fields[1], &t)
	                    : week_and_tow(fields[0], fields[1], &t)) != FW_OK)
		return refuse(r, "no date and time, no week and time of week");
	for (int i = 0; i < FIELDS; i++)
		v[i] = UNKNOWN;
	const int n_numbers = numbers(fields, 2, n, v);
	if (n_numbers < 0)
		return refuse(r, "a field that is no number");
	if (n_numbers < n_position)
		return refuse(r, "cut short");
	memcpy(&a, v + n_position, sizeof a);
	if (isfinite(a.sd[0]) && !isfinite(a.sd[2]))
		return refuse(r, "cut short");
	return put(r, t, v, &a);
}

static fw_status take_line(fw_rtklib_pos *r, const fw_line *line)
{
	if (r->lines.overlong != r->overlong) {
		r->overlong = r->lines.overlong;
		return refuse(r, "a line that is too long");
	}
	if (line->n == 0)
		return FW_OK;
	if (line->text[0] == '%') {
		take_header(r, line);
		return FW_OK;
	}
	if (!r->baseline)
		return take_solution(r, line);
	r->problem = (fw_rinex_problem){line->number, "baselines have no place on the Earth"};
	return FW_EUNKNOWN;
}

fw_status fw_rtklib_pos_read(fw_rtklib_pos *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status = r->final;
	fw_line line;

	while (status == FW_OK) {
		if (fw_log_take(&r->queue, kind, record) == FW_OK)
			return FW_OK;
		status = fw_lines_next(&r->lines, &line);
		if (status == FW_OK)
			status = take_line(r, &line);
	}
	r->lost += status == FW_ESYNTAX || status == FW_EUNKNOWN;
	if (status != FW_ESYNTAX)
		r->final = status;
	return status;
}
