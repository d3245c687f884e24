#include "base/time.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define GST_WEEK_0 1024 /* Galileo OS SIS ICD 2.1, 5.1.2: GST week 0 is GPS week 1024 */
#define BDT_WEEK_0 1356 /* BDS-SIS-ICD-B1I-3.0, 3.3: BDT week 0 begins 2006-01-01T00:00:00 UTC */
#define BDT_LAG_NS (14 * FW_NS_PER_S)

#define UNIX_EPOCH_LAG_US INT64_C(315964800000000) /* 1970-01-01 to 1980-01-06: 3657 days */
#define MOSCOW_NS         (3 * 3600 * FW_NS_PER_S)

/* GPST - UTC from 00:00:00 UTC of a date on (IERS Leap_Second.dat gives TAI - UTC, 19 s more). */
static const struct leap_row {
	int year, month, day;
	int leap_s;
} leap_table[] = {
    {1980, 1, 6, 0},  {1981, 7, 1, 1},  {1982, 7, 1, 2},  {1983, 7, 1, 3},  {1985, 7, 1, 4},
    {1988, 1, 1, 5},  {1990, 1, 1, 6},  {1991, 1, 1, 7},  {1992, 7, 1, 8},  {1993, 7, 1, 9},
    {1994, 7, 1, 10}, {1996, 1, 1, 11}, {1997, 7, 1, 12}, {1999, 1, 1, 13}, {2006, 1, 1, 14},
    {2009, 1, 1, 15}, {2012, 7, 1, 16}, {2015, 7, 1, 17}, {2017, 1, 1, 18},
};

#define LEAP_ROWS ((int)(sizeof(leap_table) / sizeof(leap_table[0])))

/* Leap_Second.dat, updated through IERS Bulletin C 72 (July 2026): "File expires on 28 June 2027". */
static const struct leap_row leap_expiry = {2027, 6, 28, 18};

static bool in_range(int64_t ns)
{
	return ns >= 0 && ns <= FW_TIME_NS_MAX;
}

static fw_status store(int64_t ns, fw_time *t)
{
	if (!in_range(ns))
		return FW_ERANGE;
	t->ns = ns;
	return FW_OK;
}

/* ---- calendar ---- */

/* Days from 0000-03-01 to 1980-01-06. */
#define GPS_EPOCH_DAY 723125

/* Days since 1980-01-06. Years count from March, so that the leap day is the last of its year. */
static int64_t days_from_date(int year, int month, int day)
{
	int64_t y = month > 2 ? year : year - 1;
	int64_t march = (month + 9) % 12; /* months since March */
	int64_t before_year = 365 * y + y / 4 - y / 100 + y / 400;

	return before_year + (153 * march + 2) / 5 + day - 1 - GPS_EPOCH_DAY;
}

static void date_from_days(int64_t days, fw_civil *c)
{
	int64_t since = days + GPS_EPOCH_DAY;
	int64_t era = since / 146097; /* 400 years */
	int64_t in_era = since % 146097;
	int64_t year = (in_era - in_era / 1460 + in_era / 36524 - in_era / 146096) / 365;
	int64_t in_year = in_era - (365 * year + year / 4 - year / 100);
	int64_t march = (5 * in_year + 2) / 153;

	c->day = (int)(in_year - (153 * march + 2) / 5 + 1);
	c->month = (int)(march < 10 ? march + 3 : march - 9);
	c->year = (int)(year + 400 * era + (c->month <= 2));
}

static int days_in_month(int year, int month)
{
	static const int days[12] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
	bool leap_year = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);

	return days[month - 1] + (month == 2 && leap_year);
}

static fw_status check_date(const fw_civil *c)
{
	if (c->year < 1980 || c->year > 2137)
		return FW_ERANGE;
	if (c->month < 1 || c->month > 12 || c->day < 1 || c->day > days_in_month(c->year, c->month))
		return FW_EINVAL;
	return FW_OK;
}

/* Nanoseconds since 1980-01-06 on the scale of c, where every day has 86400 s. */
static fw_status join(const fw_civil *c, int last_second, int64_t *ns)
{
	fw_status status = check_date(c);

	if (status < 0)
		return status;
	if (c->hour < 0 || c->hour > 23 || c->minute < 0 || c->minute > 59 || c->second < 0 ||
	    c->second > last_second || c->nanosecond < 0 || c->nanosecond > 999999999)
		return FW_EINVAL;
	*ns = days_from_date(c->year, c->month, c->day) * FW_NS_PER_DAY + c->nanosecond +
	      (c->hour * 3600 + c->minute * 60 + c->second) * FW_NS_PER_S;
	return FW_OK;
}

static void split(int64_t ns, fw_civil *c)
{
	int second = (int)(ns % FW_NS_PER_DAY / FW_NS_PER_S);

	date_from_days(ns / FW_NS_PER_DAY, c);
	c->hour = second / 3600;
	c->minute = second / 60 % 60;
	c->second = second % 60;
	c->nanosecond = (int)(ns % FW_NS_PER_S);
}

fw_status fw_time_from_civil(const fw_civil *gpst, fw_time *t)
{
	int64_t ns;
	fw_status status = join(gpst, 59, &ns);

	return status < 0 ? status : store(ns, t);
}

fw_status fw_time_to_civil(fw_time t, fw_civil *gpst)
{
	if (!in_range(t.ns))
		return FW_ERANGE;
	split(t.ns, gpst);
	return FW_OK;
}

fw_status fw_civil_day_of_year(const fw_civil *c, int *day)
{
	fw_status status = check_date(c);

	if (status < 0)
		return status;
	*day = (int)(days_from_date(c->year, c->month, c->day) - days_from_date(c->year, 1, 1)) + 1;
	return FW_OK;
}

/* ---- weeks and time of week ---- */

fw_status fw_time_add_s(fw_time t, double s, fw_time *sum)
{
	double span = (double)FW_TIME_NS_MAX / 1e9;

	if (!isfinite(s))
		return FW_ENONFINITE;
	if (!in_range(t.ns) || !(fabs(s) <= span))
		return FW_ERANGE;
	int64_t ns; /* the sum of two moments may not fit, unlike their difference */
	if (__builtin_add_overflow(t.ns, (int64_t)llround(s * 1e9), &ns))
		return FW_ERANGE;
	return store(ns, sum);
}

fw_status fw_time_from_gps(int week, int64_t tow_ns, fw_time *t)
{
	if (week < 0 || week > FW_TIME_WEEK_MAX || tow_ns < 0 || tow_ns >= FW_NS_PER_WEEK)
		return FW_ERANGE;
	t->ns = week * FW_NS_PER_WEEK + tow_ns;
	return FW_OK;
}

fw_status fw_time_from_gps_s(int week, double tow_s, fw_time *t)
{
	if (!isfinite(tow_s))
		return FW_ENONFINITE;
	if (week < 0 || week > FW_TIME_WEEK_MAX || !(tow_s >= 0 && tow_s < 604800))
		return FW_ERANGE;
	return store(week * FW_NS_PER_WEEK + llround(tow_s * 1e9), t);
}

/* Division that rounds down, so that the time of week is never negative. */
static void split_week(int64_t ns, int *week, int64_t *tow_ns)
{
	int64_t rest = ns % FW_NS_PER_WEEK;

	*week = (int)(ns / FW_NS_PER_WEEK) - (rest < 0);
	*tow_ns = rest < 0 ? rest + FW_NS_PER_WEEK : rest;
}

void fw_time_to_gps(fw_time t, int *week, int64_t *tow_ns)
{
	split_week(t.ns, week, tow_ns);
}

void fw_time_to_gps_s(fw_time t, int *week, double *tow_s)
{
	int64_t tow_ns;

	split_week(t.ns, week, &tow_ns);
	*tow_s = (double)tow_ns / 1e9;
}

fw_status fw_time_from_gst(int week, int64_t tow_ns, fw_time *t)
{
	if (week < 0 || week > FW_TIME_WEEK_MAX - GST_WEEK_0)
		return FW_ERANGE;
	return fw_time_from_gps(week + GST_WEEK_0, tow_ns, t);
}

void fw_time_to_gst(fw_time t, int *week, int64_t *tow_ns)
{
	split_week(t.ns, week, tow_ns);
	*week -= GST_WEEK_0;
}

fw_status fw_time_from_bdt(int week, int64_t tow_ns, fw_time *t)
{
	if (week < 0 || week > FW_TIME_WEEK_MAX - BDT_WEEK_0 || tow_ns < 0 || tow_ns >= FW_NS_PER_WEEK)
		return FW_ERANGE;
	return store((week + BDT_WEEK_0) * FW_NS_PER_WEEK + tow_ns + BDT_LAG_NS, t);
}

void fw_time_to_bdt(fw_time t, int *week, int64_t *tow_ns)
{
	split_week(t.ns - BDT_LAG_NS, week, tow_ns);
	*week -= BDT_WEEK_0;
}

fw_status fw_week_resolve(int truncated, int modulus, int near_week, int *week)
{
	if (modulus < 2 || modulus % 2 != 0 || modulus > FW_TIME_WEEK_MAX + 1 || truncated < 0 ||
	    truncated >= modulus || near_week < 0 || near_week > FW_TIME_WEEK_MAX)
		return FW_EINVAL;

	int earliest = near_week - modulus / 2;
	int up = ((truncated - earliest) % modulus + modulus) % modulus;
	int full = earliest + up;

	if (full < 0 || full > FW_TIME_WEEK_MAX)
		return FW_ERANGE;
	*week = full;
	return FW_OK;
}

double fw_tow_wrap_s(double difference_s)
{
	return remainder(difference_s, 604800.0);
}

/* ---- UTC: ns since 1980-01-06T00:00:00 UTC, leap seconds not counted, as Unix time does it ---- */

static int64_t row_utc_ns(const struct leap_row *row)
{
	return days_from_date(row->year, row->month, row->day) * FW_NS_PER_DAY;
}

/* The moment from which a row holds: the end of its leap second. */
static int64_t row_gpst_ns(const struct leap_row *row)
{
	return row_utc_ns(row) + row->leap_s * FW_NS_PER_S;
}

/* The row that holds at a moment; from the newest down, where most data lie. */
static int row_at_gpst(fw_time t)
{
	int i = LEAP_ROWS - 1;

	while (i > 0 && t.ns < row_gpst_ns(&leap_table[i]))
		i--;
	return i;
}

static int row_at_utc(int64_t utc_ns)
{
	int i = LEAP_ROWS - 1;

	while (i > 0 && utc_ns < row_utc_ns(&leap_table[i]))
		i--;
	return i;
}

/* Whether t, in the reign of a row, lies in the leap second that ends that reign. */
static bool in_leap_second(int row, fw_time t)
{
	return row + 1 < LEAP_ROWS && t.ns >= row_gpst_ns(&leap_table[row + 1]) - FW_NS_PER_S;
}

static fw_status freshness(fw_time t)
{
	return t.ns < row_gpst_ns(&leap_expiry) ? FW_OK : FW_DUBIOUS;
}

fw_status fw_time_leap_seconds(fw_time t, int *leap_s)
{
	if (!in_range(t.ns))
		return FW_ERANGE;
	*leap_s = leap_table[row_at_gpst(t)].leap_s;
	return freshness(t);
}

static fw_status gpst_to_utc_ns(fw_time t, int64_t *utc_ns)
{
	int leap_s;
	fw_status status = fw_time_leap_seconds(t, &leap_s);

	if (status >= 0)
		*utc_ns = t.ns - leap_s * FW_NS_PER_S;
	return status;
}

static fw_status utc_ns_to_gpst(int64_t utc_ns, fw_time *t)
{
	fw_status status;

	if (!in_range(utc_ns))
		return FW_ERANGE;
	status = store(utc_ns + leap_table[row_at_utc(utc_ns)].leap_s * FW_NS_PER_S, t);
	return status < 0 ? status : freshness(*t);
}

fw_status fw_time_to_utc(fw_time t, fw_civil *utc)
{
	int64_t utc_ns;
	fw_status status = gpst_to_utc_ns(t, &utc_ns);

	if (status < 0)
		return status;
	if (in_leap_second(row_at_gpst(t), t)) {
		split(utc_ns - FW_NS_PER_S, utc); /* 23:59:59 ... */
		utc->second = 60;                 /* ... plus one */
	} else {
		split(utc_ns, utc);
	}
	return status;
}

fw_status fw_time_from_utc(const fw_civil *utc, fw_time *t)
{
	fw_civil c = *utc;
	bool leaping = c.second == 60;
	int64_t utc_ns;
	fw_time moment;
	fw_status status;

	if (leaping)
		c.second = 59;
	status = join(&c, 59, &utc_ns);
	if (status < 0)
		return status;
	status = utc_ns_to_gpst(utc_ns, &moment);
	if (status < 0)
		return status;
	if (leaping) {
		moment.ns += FW_NS_PER_S;
		if (!in_leap_second(row_at_gpst(moment), moment))
			return FW_EINVAL;
	}
	*t = moment;
	return status;
}

fw_status fw_time_from_utc_leap(const fw_civil *utc, int leap_s, fw_time *t)
{
	int64_t utc_ns;
	fw_status status = join(utc, 59, &utc_ns);

	if (status < 0)
		return status;
	if (leap_s < -128 || leap_s > 127)
		return FW_EINVAL;
	return store(utc_ns + leap_s * FW_NS_PER_S, t);
}

fw_status fw_time_to_utc_leap(fw_time t, int leap_s, fw_civil *utc)
{
	if (leap_s < -128 || leap_s > 127)
		return FW_EINVAL;
	if (!in_range(t.ns) || !in_range(t.ns - leap_s * FW_NS_PER_S))
		return FW_ERANGE;
	split(t.ns - leap_s * FW_NS_PER_S, utc);
	return FW_OK;
}

fw_status fw_time_from_unix_us(int64_t unix_us, fw_time *t)
{
	if (unix_us < UNIX_EPOCH_LAG_US || unix_us > UNIX_EPOCH_LAG_US + FW_TIME_NS_MAX / 1000)
		return FW_ERANGE;
	return utc_ns_to_gpst((unix_us - UNIX_EPOCH_LAG_US) * 1000, t);
}

fw_status fw_time_to_unix_us(fw_time t, int64_t *unix_us)
{
	int64_t utc_ns;
	fw_status status = gpst_to_utc_ns(t, &utc_ns);

	if (status >= 0)
		*unix_us = utc_ns / 1000 + UNIX_EPOCH_LAG_US;
	return status;
}

/* 1 January of the first year of a four-year interval, in days since 1980-01-06. */
static int64_t glonass_first_day(int n4)
{
	return days_from_date(1996 + 4 * (n4 - 1), 1, 1);
}

fw_status fw_time_from_glonass(int n4, int nt, int64_t tod_ns, fw_time *t)
{
	if (n4 < 1 || n4 > 31 || nt < 1 || nt > 1461 || tod_ns < 0 || tod_ns >= FW_NS_PER_DAY)
		return FW_EINVAL;
	return utc_ns_to_gpst((glonass_first_day(n4) + nt - 1) * FW_NS_PER_DAY + tod_ns - MOSCOW_NS, t);
}

fw_status fw_time_to_glonass(fw_time t, int *n4, int *nt, int64_t *tod_ns)
{
	int64_t utc_ns, moscow_ns;
	fw_civil date;
	fw_status status = gpst_to_utc_ns(t, &utc_ns);

	if (status < 0)
		return status;
	moscow_ns = utc_ns + MOSCOW_NS;
	date_from_days(moscow_ns / FW_NS_PER_DAY, &date);
	if (date.year < 1996 || date.year > 2119)
		return FW_ERANGE;
	*n4 = (date.year - 1996) / 4 + 1;
	*nt = (int)(moscow_ns / FW_NS_PER_DAY - glonass_first_day(*n4)) + 1;
	*tod_ns = moscow_ns % FW_NS_PER_DAY;
	return status;
}

/* ---- text ---- */

/* A number of min to max digits; false, and nothing is taken, if it is shorter. */
static bool take_number(const char **s, int min, int max, int *value)
{
	const char *p = *s;
	int sum = 0;

	while (p - *s < max && *p >= '0' && *p <= '9')
		sum = 10 * sum + (*p++ - '0');
	if (p - *s < min)
		return false;
	*s = p;
	*value = sum;
	return true;
}

static bool take_char(const char **s, char c)
{
	if (**s != c)
		return false;
	(*s)++;
	return true;
}

/* An optional decimal fraction of a second; no fraction is 0. */
static bool take_fraction(const char **s, int *ns)
{
	const char *digits;
	int value;

	*ns = 0;
	if (!take_char(s, '.'))
		return true;
	digits = *s;
	if (!take_number(s, 1, 9, &value))
		return false;
	for (long n = *s - digits; n < 9; n++)
		value *= 10;
	*ns = value;
	return true;
}

static fw_status parse_week(const char *s, fw_time *t)
{
	int week, tow, ns;

	if (!take_number(&s, 1, 4, &week) || !take_char(&s, ':') || !take_number(&s, 1, 6, &tow) ||
	    !take_fraction(&s, &ns) || *s != '\0')
		return FW_ESYNTAX;
	return fw_time_from_gps(week, tow * FW_NS_PER_S + ns, t);
}

static fw_status parse_date(const char *s, fw_time *t)
{
	fw_civil c;
	bool utc;

	if (!take_number(&s, 4, 4, &c.year) || !take_char(&s, '-') || !take_number(&s, 2, 2, &c.month) ||
	    !take_char(&s, '-') || !take_number(&s, 2, 2, &c.day) || !take_char(&s, 'T') ||
	    !take_number(&s, 2, 2, &c.hour) || !take_char(&s, ':') || !take_number(&s, 2, 2, &c.minute) ||
	    !take_char(&s, ':') || !take_number(&s, 2, 2, &c.second) || !take_fraction(&s, &c.nanosecond))
		return FW_ESYNTAX;
	utc = take_char(&s, 'Z');
	if (*s != '\0')
		return FW_ESYNTAX;
	return utc ? fw_time_from_utc(&c, t) : fw_time_from_civil(&c, t);
}

fw_status fw_time_parse(const char *text, fw_time *t)
{
	return strchr(text, 'T') ? parse_date(text, t) : parse_week(text, t);
}
