/* Time: one count of nanoseconds of GPS time, and every edge where weeks, calendars and leap seconds come in.
 *
 * Inside furrow a moment is a fw_time, a 64-bit count, so equality, order and differences are exact. Whatever
 * furrow assumes about week rollover, leap seconds and the clocks of other systems stands in this file and in
 * time.c. No clock of the operating system is ever read.
 *
 * The scales:
 *   GPST     continuous since 1980-01-06T00:00:00 UTC; UTC = GPST - leap seconds (18 s since 2017-01-01)
 *   GST      Galileo: ticks with GPST, week 0 = GPS week 1024 (1999-08-22); the offset GGTO (ns) is not
 * applied
 *   BDT      BeiDou: GPST - 14 s, week 0 begins 2006-01-01T00:00:00 UTC (GPS week 1356)
 *   GLONASS  UTC + 3 h, leap seconds included; four-year intervals since 1996, days inside them
 *
 * Range: the functions below make and take moments of GPS weeks 0..8191, 1980-01-06 .. 2137-01-05. Inside it
 * no difference of two moments can overflow. Outputs are untouched when a function fails (status < 0). */
#ifndef FURROW_BASE_TIME_H
#define FURROW_BASE_TIME_H

#include <stdint.h>

#include "base/status.h"

/* Nanoseconds of GPST since 1980-01-06T00:00:00 GPST. */
typedef struct {
	int64_t ns;
} fw_time;

/* A calendar date and time of day, on whatever scale the function that takes it says. */
typedef struct {
	int year;       /* 1980..2137 */
	int month;      /* 1..12 */
	int day;        /* 1..31 */
	int hour;       /* 0..23 */
	int minute;     /* 0..59 */
	int second;     /* 0..59; 60 only in UTC, inside a leap second */
	int nanosecond; /* 0..999999999 */
} fw_civil;

#define FW_NS_PER_S    INT64_C(1000000000)
#define FW_NS_PER_DAY  (86400 * FW_NS_PER_S)
#define FW_NS_PER_WEEK (604800 * FW_NS_PER_S)

/* The last GPS week that furrow represents: 13-bit weeks, as in GPS CNAV and BDT. */
#define FW_TIME_WEEK_MAX 8191

/* The last representable moment. */
#define FW_TIME_NS_MAX ((FW_TIME_WEEK_MAX + 1) * FW_NS_PER_WEEK - 1)

/* -1, 0 or 1 as a is before, at or after b. */
static inline int fw_time_compare(fw_time a, fw_time b)
{
	return (a.ns > b.ns) - (a.ns < b.ns);
}

/* a - b [ns], exact. */
static inline int64_t fw_time_diff_ns(fw_time a, fw_time b)
{
	return a.ns - b.ns;
}

/* a - b [s]; exact to the ns as long as the gap is below 52 days. */
static inline double fw_time_diff_s(fw_time a, fw_time b)
{
	return (double)(a.ns - b.ns) / 1e9;
}

/* t + ns, exact. The caller keeps the sum inside int64_t. */
static inline fw_time fw_time_add_ns(fw_time t, int64_t ns)
{
	return (fw_time){t.ns + ns};
}

/* The moment s seconds after t (before it if s < 0), to the nearest ns.
 * Returns FW_OK; FW_ENONFINITE (s is NaN or infinite) or FW_ERANGE (sum outside weeks 0..8191). */
fw_status fw_time_add_s(fw_time t, double s, fw_time *sum) FW_MUST_CHECK;

/* ---- weeks and time of week ---- */

/* GPS week and time of week [ns] to a moment, exact.
 *   week    in   full GPS week, 0..8191
 *   tow_ns  in   0 <= tow < 604800 s
 * Returns FW_OK or FW_ERANGE. */
fw_status fw_time_from_gps(int week, int64_t tow_ns, fw_time *t) FW_MUST_CHECK;

/* The same with the time of week in seconds, rounded to the nearest ns: a time of week that fw_time_to_gps_s
 * gave, or that was printed with 9 decimals, comes back exactly.
 * Returns FW_OK, FW_ENONFINITE or FW_ERANGE. */
fw_status fw_time_from_gps_s(int week, double tow_s, fw_time *t) FW_MUST_CHECK;

/* GPS week and time of week (0 <= tow < 604800 s) of t. Never fails; the week is negative before 1980. */
void fw_time_to_gps(fw_time t, int *week, int64_t *tow_ns);
void fw_time_to_gps_s(fw_time t, int *week, double *tow_s);

/* Galileo System Time: week since 1999-08-22, time of week [ns]. GST = GPST here; the broadcast GGTO, some
 * ns, is a matter of the range model. Source: Galileo OS SIS ICD 2.1, 5.1.2.
 * from: FW_OK or FW_ERANGE. to: never fails; the week is negative before 1999-08-22. */
fw_status fw_time_from_gst(int week, int64_t tow_ns, fw_time *t) FW_MUST_CHECK;
void fw_time_to_gst(fw_time t, int *week, int64_t *tow_ns);

/* BeiDou Time = GPST - 14 s: week since 2006-01-01, time of week [ns]. Source: BDS-SIS-ICD-B1I-3.0, 3.3.
 * from: FW_OK or FW_ERANGE. to: never fails; the week is negative before 2006-01-01. */
fw_status fw_time_from_bdt(int week, int64_t tow_ns, fw_time *t) FW_MUST_CHECK;
void fw_time_to_bdt(fw_time t, int *week, int64_t *tow_ns);

/* The full week that a truncated week number stands for, nearest to a week known from elsewhere.
 *   truncated  in   0..modulus-1, as broadcast
 *   modulus    in   1024 (LNAV), 4096 (Galileo), 8192 (CNAV, BDT), 256 or 64 (almanacs), ...; even, >= 2
 *   near_week  in   full week, 0..8191, of the same system's count, within half a modulus of the answer
 *   week       out  near_week - modulus/2 <= week < near_week + modulus/2
 * Returns FW_OK, FW_EINVAL (an argument outside the above) or FW_ERANGE (the answer lies outside 0..8191). */
fw_status fw_week_resolve(int truncated, int modulus, int near_week, int *week) FW_MUST_CHECK;

/* A difference of two times of week brought to the nearer side of the week's end: -302400..302400 s.
 * Exact; NaN and infinity give NaN. Source: IS-GPS-200N, 20.3.3.4.3.1 (t_k). */
double fw_tow_wrap_s(double difference_s);

/* ---- calendar ---- */

/* Calendar date and time of the GPST scale (no leap seconds: second 0..59) to a moment and back, exact.
 * from: FW_OK, FW_EINVAL (no such date or time of day) or FW_ERANGE (outside weeks 0..8191).
 * to: FW_OK or FW_ERANGE.
 * Gregorian calendar; source: H. Hinnant, "chrono-compatible low-level date algorithms". */
fw_status fw_time_from_civil(const fw_civil *gpst, fw_time *t) FW_MUST_CHECK;
fw_status fw_time_to_civil(fw_time t, fw_civil *gpst) FW_MUST_CHECK;

/* Day of the year, 1 January = 1, of the date in c (its time of day is not looked at).
 * Returns FW_OK, FW_EINVAL (no such date) or FW_ERANGE (year outside 1980..2137). */
fw_status fw_civil_day_of_year(const fw_civil *c, int *day) FW_MUST_CHECK;

/* ---- UTC ---- */

/* Leap seconds GPST - UTC [s] at a moment; during a leap second still the old count.
 * Table: 1980-01-06 (0 s) .. 2017-01-01 (18 s). It is known to hold until 2027-06-28T00:00:00 UTC, the expiry
 * that the IERS gives it (Leap_Second.dat, updated through Bulletin C 72, July 2026); bring both up to date
 * together.
 * Returns FW_OK; FW_DUBIOUS from the expiry on (leap_s is the last known count); FW_ERANGE. */
fw_status fw_time_leap_seconds(fw_time t, int *leap_s) FW_MUST_CHECK;

/* UTC date and time to a moment and back, exact, by the table above. The leap second 23:59:60 is a moment
 * like any other; second = 60 where no leap second was is FW_EINVAL.
 * Returns FW_OK, FW_DUBIOUS (done, past the table's expiry), FW_EINVAL (from only) or FW_ERANGE. */
fw_status fw_time_from_utc(const fw_civil *utc, fw_time *t) FW_MUST_CHECK;
fw_status fw_time_to_utc(fw_time t, fw_civil *utc) FW_MUST_CHECK;

/* The same with a count of leap seconds known from elsewhere (the receiver's DeltaLS); no table is looked at.
 *   leap_s  in   GPST - UTC [s], -128..127
 * Since one count holds for all moments, no 23:59:60 is given out or taken.
 * Returns FW_OK, FW_EINVAL (no such date, or leap_s) or FW_ERANGE. */
fw_status fw_time_from_utc_leap(const fw_civil *utc, int leap_s, fw_time *t) FW_MUST_CHECK;
fw_status fw_time_to_utc_leap(fw_time t, int leap_s, fw_civil *utc) FW_MUST_CHECK;

/* Unix time [microseconds since 1970-01-01T00:00:00 UTC, leap seconds not counted], as LCM logs stamp events.
 * to rounds down to the microsecond. A leap second repeats the numbers of the second after it, as POSIX has
 * it; from takes a number that exists twice as the later moment.
 * Returns FW_OK, FW_DUBIOUS (done, past the table's expiry) or FW_ERANGE. */
fw_status fw_time_from_unix_us(int64_t unix_us, fw_time *t) FW_MUST_CHECK;
fw_status fw_time_to_unix_us(fw_time t, int64_t *unix_us) FW_MUST_CHECK;

/* GLONASS time (UTC + 3 h) to a moment and back.
 *   n4      four-year interval, 1..31; 1 begins on 1996-01-01 (Moscow), always a year divisible by 4
 *   nt      day in the interval, 1..1461; 1 is the interval's first 1 January
 *   tod_ns  time of day [ns], 0 <= tod < 86400 s
 * A leap second (02:59:60) repeats the numbers of the second after it; from takes the later moment.
 * Returns FW_OK, FW_DUBIOUS (done, past the leap table's expiry), FW_EINVAL (from: an argument outside the
 * above) or FW_ERANGE (to: outside 1996..2119). Source: GLONASS ICD L1, L2, edition 5.1, 3.3.3 and 4.4 (N_4,
 * N_T). */
fw_status fw_time_from_glonass(int n4, int nt, int64_t tod_ns, fw_time *t) FW_MUST_CHECK;
fw_status fw_time_to_glonass(fw_time t, int *n4, int *nt, int64_t *tod_ns) FW_MUST_CHECK;

/* ---- text ---- */

/* The TIME of the command line, whole string, independent of the locale:
 *   WWWW:SSSSSS[.fff]             GPS week and time of week [s]
 *   YYYY-MM-DDTHH:MM:SS[.fff]     date and time of the GPST scale
 *   YYYY-MM-DDTHH:MM:SS[.fff]Z    UTC
 * Week 1 to 4 digits, time of week 1 to 6, fraction 1 to 9, the rest as many digits as shown; no blanks, no
 * signs.
 * Returns FW_OK; FW_DUBIOUS (done; UTC past the leap table's expiry); FW_ESYNTAX (none of these forms);
 * FW_EINVAL (no such date or time of day); FW_ERANGE (outside weeks 0..8191, or tow >= 604800). */
fw_status fw_time_parse(const char *text, fw_time *t) FW_MUST_CHECK;

#endif
