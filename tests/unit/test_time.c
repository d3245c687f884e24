/* time: expected values from astropy 8 (ERFA) for UTC, from Python's datetime for calendars, or by hand. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/random.h"
#include "base/time.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))
#define S        FW_NS_PER_S

static fw_time at(int week, int64_t tow_ns)
{
	fw_time t = {-1};

	assert_int_equal(fw_time_from_gps(week, tow_ns, &t), FW_OK);
	return t;
}

static void assert_time(fw_time t, int week, int64_t tow_ns)
{
	if (t.ns != week * FW_NS_PER_WEEK + tow_ns)
		fail_msg("%lld ns is not week %d + %lld ns", (long long)t.ns, week, (long long)tow_ns);
}

static void assert_civil(const fw_civil *a, const fw_civil *b)
{
	assert_int_equal(a->year, b->year);
	assert_int_equal(a->month, b->month);
	assert_int_equal(a->day, b->day);
	assert_int_equal(a->hour, b->hour);
	assert_int_equal(a->minute, b->minute);
	assert_int_equal(a->second, b->second);
	assert_int_equal(a->nanosecond, b->nanosecond);
}

static int64_t random_ns(fw_random *r)
{
	return (int64_t)fw_random_below(r, (uint64_t)FW_TIME_NS_MAX + 1);
}

/* ---- arithmetic and weeks ---- */

static void times_compare_and_subtract(void **state)
{
	fw_time a = at(2446, 5), b = at(2446, 7), sum;

	(void)state;
	assert_true(fw_time_compare(a, b) == -1 && fw_time_compare(b, a) == 1 && fw_time_compare(a, a) == 0);
	assert_int_equal(fw_time_diff_ns(a, b), -2);
	assert_true(fw_time_diff_s(b, a) == 2e-9);
	assert_true(fw_time_diff_s(at(8191, 0), at(0, 0)) == 8191 * 604800.0);
	assert_time(fw_time_add_ns(a, -6), 2445, FW_NS_PER_WEEK - 1);
	assert_int_equal(fw_time_add_s(a, -0.073123456789, &sum), FW_OK);
	assert_time(sum, 2445, FW_NS_PER_WEEK + 5 - 73123457 + 0);
	assert_int_equal(fw_time_add_s(a, 604800, &sum), FW_OK);
	assert_time(sum, 2447, 5);
}

static void add_s_refuses_what_leaves_the_range(void **state)
{
	fw_time sum = {7};

	(void)state;
	assert_int_equal(fw_time_add_s(at(0, 0), -1e-9, &sum), FW_ERANGE);
	assert_int_equal(fw_time_add_s(at(8191, FW_NS_PER_WEEK - 1), 1e-9, &sum), FW_ERANGE);
	assert_int_equal(fw_time_add_s(at(1, 0), 1e300, &sum), FW_ERANGE);
	assert_int_equal(fw_time_add_s((fw_time){INT64_MIN}, -4e9, &sum), FW_ERANGE);
	assert_int_equal(fw_time_add_s(at(1, 0), nan(""), &sum), FW_ENONFINITE);
	assert_int_equal(fw_time_add_s(at(1, 0), -HUGE_VAL, &sum), FW_ENONFINITE);
	assert_int_equal(sum.ns, 7);
}

static void weeks_come_back(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 21);
	for (int i = 0; i < 100000; i++) {
		fw_time t = {random_ns(&r)}, back;
		int week;
		int64_t tow_ns;
		double tow_s;

		fw_time_to_gps(t, &week, &tow_ns);
		assert_true(tow_ns >= 0 && tow_ns < FW_NS_PER_WEEK);
		assert_int_equal(fw_time_from_gps(week, tow_ns, &back), FW_OK);
		assert_true(back.ns == t.ns);
		fw_time_to_gps_s(t, &week, &tow_s);
		assert_int_equal(fw_time_from_gps_s(week, tow_s, &back), FW_OK);
		assert_true(back.ns == t.ns);
	}
}

static void weeks_outside_are_refused(void **state)
{
	fw_time t = {7};

	(void)state;
	assert_int_equal(fw_time_from_gps(-1, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gps(8192, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gps(65535, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gps(0, -1, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gps(0, FW_NS_PER_WEEK, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gps(0, INT64_MAX, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gps_s(0, 604800, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gps_s(0, -1e-9, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gps_s(0, nan(""), &t), FW_ENONFINITE);
	assert_int_equal(fw_time_from_gps_s(0, HUGE_VAL, &t), FW_ENONFINITE);
	assert_int_equal(fw_time_from_gps_s(8191, nextafter(604800, 0), &t),
	                 FW_ERANGE); /* rounds up to week 8192 */
	assert_int_equal(t.ns, 7);
	assert_int_equal(fw_time_from_gps_s(8190, nextafter(604800, 0), &t), FW_OK);
	assert_time(t, 8191, 0);
}

static void time_of_week_is_never_negative(void **state)
{
	int week;
	int64_t tow_ns;

	(void)state;
	fw_time_to_gps((fw_time){-1}, &week, &tow_ns);
	assert_true(week == -1 && tow_ns == FW_NS_PER_WEEK - 1);
	fw_time_to_gps((fw_time){-FW_NS_PER_WEEK}, &week, &tow_ns);
	assert_true(week == -1 && tow_ns == 0);
}

/* GST 0 = 1999-08-22, GPS week 1024; BDT 0 = 2006-01-01T00:00:00 UTC = GPST 14 s into week 1356. */
static void other_systems_count_their_own_weeks(void **state)
{
	fw_time t;
	int week;
	int64_t tow_ns;

	(void)state;
	assert_int_equal(fw_time_from_gst(0, 0, &t), FW_OK);
	assert_time(t, 1024, 0);
	fw_time_to_gst(at(2446, 3), &week, &tow_ns);
	assert_true(week == 1422 && tow_ns == 3);
	fw_time_to_gst(at(1023, 3), &week, &tow_ns);
	assert_true(week == -1 && tow_ns == 3);

	assert_int_equal(fw_time_from_bdt(0, 0, &t), FW_OK);
	assert_time(t, 1356, 14 * S);
	fw_time_to_bdt(at(2446, 13 * S), &week, &tow_ns);
	assert_true(week == 1089 && tow_ns == 604799 * S);
	fw_time_to_bdt(at(2446, 14 * S), &week, &tow_ns);
	assert_true(week == 1090 && tow_ns == 0);
	assert_int_equal(fw_time_from_bdt(8191 - 1356, 604786 * S - 1, &t), FW_OK);
	assert_time(t, 8191, FW_NS_PER_WEEK - 1);
}

static void other_systems_refuse_weeks_outside(void **state)
{
	fw_time t = {7};

	(void)state;
	assert_int_equal(fw_time_from_gst(-1, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gst(INT32_MAX, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gst(7168, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_gst(0, FW_NS_PER_WEEK, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_bdt(-1, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_bdt(INT32_MAX, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_bdt(0, -1, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_bdt(0, FW_NS_PER_WEEK, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_bdt(8192 - 1356, 0, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_bdt(8191 - 1356, 604786 * S, &t), FW_ERANGE);
	assert_int_equal(t.ns, 7);
}

static void other_systems_come_back(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 22);
	for (int i = 0; i < 100000; i++) {
		fw_time t = {1357 * FW_NS_PER_WEEK + random_ns(&r) % (6800 * FW_NS_PER_WEEK)}, back;
		int week;
		int64_t tow_ns;

		fw_time_to_gst(t, &week, &tow_ns);
		assert_int_equal(fw_time_from_gst(week, tow_ns, &back), FW_OK);
		assert_true(back.ns == t.ns);
		fw_time_to_bdt(t, &week, &tow_ns);
		assert_int_equal(fw_time_from_bdt(week, tow_ns, &back), FW_OK);
		assert_true(back.ns == t.ns);
	}
}

static void truncated_weeks_resolve_to_the_nearest(void **state)
{
	static const struct {
		int truncated, modulus, near, week;
	} cases[] = {
	    {0, 1024, 1023, 1024},       {1023, 1024, 1024, 1023}, /* first rollover, 1999-08-22 */
	    {0, 1024, 2047, 2048},       {1023, 1024, 2048, 2047}, /* second, 2019-04-07 */
	    {398, 1024, 2446, 2446},     {399, 1024, 2440, 2447},  {1422, 4096, 1400, 1422},
	    {0, 4096, 4095, 4096},       {2446, 8192, 2400, 2446}, {142, 256, 2440, 2446},
	    {2446 % 64, 64, 2470, 2446}, {512, 1024, 2048, 1536},  {511, 1024, 2048, 2559},
	    {31, 64, 2048, 2079},        {32, 64, 2048, 2016},     {0, 2, 5, 4},
	};
	int week;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		assert_int_equal(fw_week_resolve(cases[i].truncated, cases[i].modulus, cases[i].near, &week),
		                 FW_OK);
		assert_int_equal(week, cases[i].week);
	}
}

static void truncated_weeks_find_every_week_back(void **state)
{
	static const int moduli[] = {64, 256, 1024, 4096, 8192};
	int week;

	(void)state;
	for (size_t m = 0; m < COUNT(moduli); m++)
		for (int full = 0; full <= 8191; full += 7)
			for (int off = -moduli[m] / 2 + 1; off <= moduli[m] / 2; off += moduli[m] / 8 - 1) {
				if (full + off < 0 || full + off > 8191)
					continue;
				assert_int_equal(
				    fw_week_resolve(full % moduli[m], moduli[m], full + off, &week), FW_OK);
				assert_int_equal(week, full);
			}
}

static void truncated_weeks_refuse_bad_arguments(void **state)
{
	int week = 7;

	(void)state;
	assert_int_equal(fw_week_resolve(1024, 1024, 2000, &week), FW_EINVAL);
	assert_int_equal(fw_week_resolve(-1, 1024, 2000, &week), FW_EINVAL);
	assert_int_equal(fw_week_resolve(0, 0, 2000, &week), FW_EINVAL);
	assert_int_equal(fw_week_resolve(0, 3, 2000, &week), FW_EINVAL);
	assert_int_equal(fw_week_resolve(0, 1024, -1, &week), FW_EINVAL);
	assert_int_equal(fw_week_resolve(0, 1024, INT32_MAX, &week), FW_EINVAL);
	assert_int_equal(fw_week_resolve(1000, 1024, 10, &week), FW_ERANGE); /* would be week -24 */
	assert_int_equal(fw_week_resolve(0, 1024, 8190, &week), FW_ERANGE);  /* would be week 8192 */
	assert_int_equal(week, 7);
}

static void time_of_week_differences_wrap(void **state)
{
	(void)state;
	assert_true(fw_tow_wrap_s(0) == 0 && fw_tow_wrap_s(7200.5) == 7200.5);
	assert_true(fw_tow_wrap_s(302400) == 302400 && fw_tow_wrap_s(-302400) == -302400);
	assert_true(fw_tow_wrap_s(302400.25) == -302399.75 && fw_tow_wrap_s(-302400.25) == 302399.75);
	assert_true(fw_tow_wrap_s(604799) == -1 && fw_tow_wrap_s(-604799) == 1);
	assert_true(fw_tow_wrap_s(2 * 604800 + 3) == 3);
	assert_true(isnan(fw_tow_wrap_s(nan(""))) && isnan(fw_tow_wrap_s(HUGE_VAL)));
}

/* ---- calendar ---- */

static void civil_dates_are_what_datetime_says(void **state)
{
	static const struct {
		fw_civil c;
		int week, tow_s, day_of_year;
	} cases[] = {
	    {{1980, 1, 6, 0, 0, 0, 0}, 0, 0, 6},
	    {{1999, 8, 21, 23, 59, 59, 0}, 1023, 604799, 233},
	    {{1999, 8, 22, 0, 0, 0, 0}, 1024, 0, 234},
	    {{2000, 2, 29, 12, 0, 0, 0}, 1051, 216000, 60},
	    {{2019, 4, 6, 23, 59, 59, 0}, 2047, 604799, 96},
	    {{2019, 4, 7, 0, 0, 0, 0}, 2048, 0, 97},
	    {{2023, 11, 5, 0, 0, 0, 0}, 2287, 0, 309},
	    {{2024, 12, 31, 0, 0, 0, 0}, 2347, 172800, 366},
	    {{2100, 2, 28, 23, 59, 59, 0}, 6269, 86399, 59},
	    {{2100, 3, 1, 0, 0, 0, 0}, 6269, 86400, 60},
	    {{2136, 12, 31, 23, 59, 59, 0}, 8191, 172799, 366},
	    {{2137, 1, 5, 23, 59, 59, 0}, 8191, 604799, 5},
	};
	fw_time t;
	fw_civil c;
	int day;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		assert_int_equal(fw_time_from_civil(&cases[i].c, &t), FW_OK);
		assert_time(t, cases[i].week, cases[i].tow_s * S);
		assert_int_equal(fw_time_to_civil(t, &c), FW_OK);
		assert_civil(&c, &cases[i].c);
		assert_int_equal(fw_civil_day_of_year(&cases[i].c, &day), FW_OK);
		assert_int_equal(day, cases[i].day_of_year);
	}
}

/* The days between the first and the last week, one after the other, each the successor of the one before. */
static void every_day_follows_its_predecessor(void **state)
{
	static const int length[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
	fw_civil c = {1980, 1, 6, 0, 0, 0, 0}, got;
	fw_time t;

	(void)state;
	for (int64_t day = 0; day < 8192 * 7; day++) {
		assert_int_equal(fw_time_to_civil((fw_time){day * FW_NS_PER_DAY}, &got), FW_OK);
		assert_civil(&got, &c);
		assert_int_equal(fw_time_from_civil(&c, &t), FW_OK);
		assert_true(t.ns == day * FW_NS_PER_DAY);
		c.day++;
		if (c.day > length[c.month - 1] + (c.month == 2 && c.year % 4 == 0 && c.year != 2100)) {
			c.day = 1;
			c.month++;
		}
		if (c.month > 12) {
			c.month = 1;
			c.year++;
		}
	}
}

static void dates_that_do_not_exist_are_refused(void **state)
{
	static const fw_civil bad[] = {
	    {2023, 0, 1, 0, 0, 0, 0},  {2023, 13, 1, 0, 0, 0, 0},
	    {2023, 1, 0, 0, 0, 0, 0},  {2023, 2, 29, 0, 0, 0, 0},
	    {2100, 2, 29, 0, 0, 0, 0}, {2023, 4, 31, 0, 0, 0, 0},
	    {2023, 1, 1, -1, 0, 0, 0}, {2023, 1, 1, 24, 0, 0, 0},
	    {2023, 1, 1, 0, 60, 0, 0}, {2023, 1, 1, 0, -1, 0, 0},
	    {2023, 1, 1, 0, 0, 61, 0}, {2023, 1, 1, 0, 0, -1, 0},
	    {2023, 1, 1, 0, 0, 0, -1}, {2023, 1, 1, 0, 0, 0, 1000000000},
	    {2023, 1, 1, 0, 0, 60, 0}, /* GPST has no leap seconds, and UTC had none here */
	};
	static const fw_civil outside[] = {
	    {1980, 1, 5, 23, 59, 59, 999999999}, {2137, 1, 6, 0, 0, 0, 0},      {1979, 12, 31, 0, 0, 0, 0},
	    {INT32_MAX, 1, 1, 0, 0, 0, 0},       {INT32_MIN, 1, 1, 0, 0, 0, 0},
	};
	fw_time t = {7};
	fw_civil c;
	int day = 7;

	(void)state;
	for (size_t i = 0; i < COUNT(bad); i++) {
		assert_int_equal(fw_time_from_civil(&bad[i], &t), FW_EINVAL);
		assert_int_equal(fw_time_from_utc(&bad[i], &t), FW_EINVAL);
		assert_int_equal(fw_time_from_utc_leap(&bad[i], 18, &t), FW_EINVAL);
	}
	for (size_t i = 0; i < COUNT(outside); i++) {
		assert_int_equal(fw_time_from_civil(&outside[i], &t), FW_ERANGE);
		assert_int_equal(fw_time_from_utc(&outside[i], &t), FW_ERANGE);
		assert_int_equal(fw_time_from_utc_leap(&outside[i], 0, &t), FW_ERANGE);
	}
	assert_int_equal(fw_civil_day_of_year(&bad[3], &day), FW_EINVAL);
	assert_int_equal(fw_civil_day_of_year(&outside[2], &day), FW_ERANGE);
	assert_int_equal(fw_time_to_civil((fw_time){-1}, &c), FW_ERANGE);
	assert_int_equal(fw_time_to_civil((fw_time){FW_TIME_NS_MAX + 1}, &c), FW_ERANGE);
	assert_true(t.ns == 7 && day == 7);
}

/* ---- UTC ---- */

static const struct {
	fw_civil utc;
	int week;
	int64_t tow_ns;
	int leap_s;
} utc_cases[] = {
    {{1980, 1, 6, 0, 0, 0, 0}, 0, 0, 0},
    {{1981, 6, 30, 23, 59, 59, 0}, 77, 259199 * S, 0},
    {{1981, 6, 30, 23, 59, 60, 0}, 77, 259200 * S, 0},
    {{1981, 7, 1, 0, 0, 0, 0}, 77, 259201 * S, 1},
    {{1999, 8, 21, 23, 59, 46, 0}, 1023, 604799 * S, 13},
    {{1999, 8, 21, 23, 59, 47, 0}, 1024, 0, 13},
    {{2006, 1, 1, 0, 0, 0, 0}, 1356, 14 * S, 14},
    {{2015, 6, 30, 23, 59, 59, 500000000}, 1851, 259215500 * (S / 1000), 16},
    {{2015, 6, 30, 23, 59, 60, 500000000}, 1851, 259216500 * (S / 1000), 16},
    {{2015, 7, 1, 0, 0, 0, 0}, 1851, 259217 * S, 17},
    {{2016, 12, 31, 23, 59, 60, 0}, 1930, 17 * S, 17},
    {{2016, 12, 31, 23, 59, 60, 999999999}, 1930, 18 * S - 1, 17},
    {{2017, 1, 1, 0, 0, 0, 0}, 1930, 18 * S, 18},
    {{2019, 4, 6, 23, 59, 42, 0}, 2048, 0, 18},
    {{2026, 11, 22, 12, 34, 56, 789000000}, 2446, 45314789 * (S / 1000), 18},
};

static void utc_is_what_astropy_says(void **state)
{
	fw_time t;
	fw_civil utc;
	int leap_s;

	(void)state;
	for (size_t i = 0; i < COUNT(utc_cases); i++) {
		assert_int_equal(fw_time_from_utc(&utc_cases[i].utc, &t), FW_OK);
		assert_time(t, utc_cases[i].week, utc_cases[i].tow_ns);
		assert_int_equal(fw_time_to_utc(t, &utc), FW_OK);
		assert_civil(&utc, &utc_cases[i].utc);
		assert_int_equal(fw_time_leap_seconds(t, &leap_s), FW_OK);
		assert_int_equal(leap_s, utc_cases[i].leap_s);
	}
}

/* The first day of each new count, from IERS Leap_Second.dat (TAI - UTC less 19 s). */
static void every_leap_second_is_there(void **state)
{
	static const int dates[18][3] = {
	    {1981, 7, 1}, {1982, 7, 1}, {1983, 7, 1}, {1985, 7, 1}, {1988, 1, 1}, {1990, 1, 1},
	    {1991, 1, 1}, {1992, 7, 1}, {1993, 7, 1}, {1994, 7, 1}, {1996, 1, 1}, {1997, 7, 1},
	    {1999, 1, 1}, {2006, 1, 1}, {2009, 1, 1}, {2012, 7, 1}, {2015, 7, 1}, {2017, 1, 1},
	};

	(void)state;
	for (int i = 0; i < 18; i++) {
		fw_civil utc = {dates[i][0], dates[i][1], dates[i][2], 0, 0, 0, 0}, before;
		fw_time t;
		int leap_s;

		assert_int_equal(fw_time_from_utc(&utc, &t), FW_OK);
		assert_int_equal(fw_time_leap_seconds(t, &leap_s), FW_OK);
		assert_int_equal(leap_s, i + 1);
		assert_int_equal(fw_time_to_utc(fw_time_add_ns(t, -1), &before), FW_OK);
		assert_int_equal(before.second, 60);
		assert_int_equal(before.minute, 59);
		assert_int_equal(fw_time_to_utc(fw_time_add_ns(t, -S - 1), &before), FW_OK);
		assert_int_equal(before.second, 59);
	}
}

static void second_60_exists_only_in_a_leap_second(void **state)
{
	static const fw_civil bad[] = {
	    {2016, 12, 30, 23, 59, 60, 0}, {2016, 12, 31, 22, 59, 60, 0}, {2016, 12, 31, 23, 58, 60, 0},
	    {2017, 1, 1, 0, 0, 60, 0},     {2018, 12, 31, 23, 59, 60, 0}, {2030, 12, 31, 23, 59, 60, 0},
	};
	fw_time t = {7};

	(void)state;
	for (size_t i = 0; i < COUNT(bad); i++)
		assert_int_equal(fw_time_from_utc(&bad[i], &t), FW_EINVAL);
	assert_int_equal(fw_time_from_utc_leap(&(fw_civil){2016, 12, 31, 23, 59, 60, 0}, 17, &t), FW_EINVAL);
	assert_int_equal(t.ns, 7);
}

static void the_table_knows_its_expiry(void **state)
{
	const fw_civil last = {2027, 6, 27, 23, 59, 59, 999999999}, after = {2027, 6, 28, 0, 0, 0, 0};
	fw_civil utc;
	fw_time t, t2;
	int leap_s = 0;
	int64_t unix_us;

	(void)state;
	assert_int_equal(fw_time_from_utc(&last, &t), FW_OK);
	assert_int_equal(fw_time_to_utc(t, &utc), FW_OK);
	assert_int_equal(fw_time_leap_seconds(t, &leap_s), FW_OK);
	assert_int_equal(fw_time_from_utc(&after, &t2), FW_DUBIOUS);
	assert_int_equal(fw_time_diff_ns(t2, t), 1);
	assert_int_equal(fw_time_to_utc(t2, &utc), FW_DUBIOUS);
	assert_civil(&utc, &after);
	assert_int_equal(fw_time_leap_seconds(t2, &leap_s), FW_DUBIOUS);
	assert_int_equal(leap_s, 18);
	assert_int_equal(fw_time_to_unix_us(t2, &unix_us), FW_DUBIOUS);
	assert_int_equal(fw_time_from_unix_us(unix_us, &t), FW_DUBIOUS);
	assert_true(t.ns == t2.ns);
}

static void utc_outside_the_range_is_refused(void **state)
{
	fw_civil utc;
	int leap_s = 7;

	(void)state;
	assert_int_equal(fw_time_leap_seconds((fw_time){-1}, &leap_s), FW_ERANGE);
	assert_int_equal(fw_time_to_utc((fw_time){-1}, &utc), FW_ERANGE);
	assert_int_equal(fw_time_to_utc((fw_time){FW_TIME_NS_MAX + 1}, &utc), FW_ERANGE);
	assert_int_equal(fw_time_to_utc_leap(at(0, 17 * S), 18, &utc), FW_ERANGE);
	assert_int_equal(leap_s, 7);
}

static void utc_comes_back(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 23);
	for (int i = 0; i < 100000; i++) {
		fw_time t = {random_ns(&r) % (FW_TIME_NS_MAX - 20 * S)}, back;
		fw_civil c;

		assert_true(fw_time_to_utc(t, &c) >= 0);
		assert_true(fw_time_from_utc(&c, &back) >= 0);
		assert_true(back.ns == t.ns);
		assert_int_equal(fw_time_to_civil(t, &c), FW_OK);
		assert_int_equal(fw_time_from_civil(&c, &back), FW_OK);
		assert_true(back.ns == t.ns);
	}
}

static void a_given_leap_count_overrides_the_table(void **state)
{
	const fw_civil utc = {2030, 1, 1, 0, 0, 0, 5};
	fw_civil back;
	fw_time with_18 = {0}, with_19 = {0};

	(void)state;
	assert_int_equal(fw_time_from_utc_leap(&utc, 18, &with_18), FW_OK);
	assert_int_equal(fw_time_from_utc_leap(&utc, 19, &with_19), FW_OK);
	assert_int_equal(fw_time_diff_ns(with_19, with_18), S);
	assert_int_equal(fw_time_to_utc_leap(with_19, 19, &back), FW_OK);
	assert_civil(&back, &utc);
	assert_int_equal(fw_time_from_utc_leap(&utc, 127, &with_19), FW_OK);
	assert_int_equal(fw_time_from_utc_leap(&utc, -128, &with_18), FW_OK);
	assert_true(fw_time_diff_ns(with_19, with_18) == 255 * S);
	assert_int_equal(fw_time_to_utc_leap(with_18, -128, &back), FW_OK);
	assert_civil(&back, &utc);
	assert_int_equal(fw_time_from_utc_leap(&utc, 128, &with_18), FW_EINVAL);
	assert_int_equal(fw_time_to_utc_leap(with_19, -129, &back), FW_EINVAL);
}

/* Unix seconds of the cases above from astropy; a leap second repeats the second after it. */
static void unix_time_is_what_astropy_says(void **state)
{
	static const struct {
		int week;
		int64_t tow_ns, unix_us;
	} cases[] = {
	    {0, 0, 315964800000000},
	    {77, 259199 * S, 362793599000000},
	    {77, 259201 * S, 362793600000000},
	    {1024, 0, 935279987000000},
	    {1356, 14 * S, 1136073600000000},
	    {1851, 259217 * S, 1435708800000000},
	    {1930, 18 * S, 1483228800000000},
	    {2048, 0, 1554595182000000},
	    {2446, 45314789 * (S / 1000), 1795350896789000},
	};
	int64_t unix_us;
	fw_time t;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		assert_int_equal(fw_time_to_unix_us(at(cases[i].week, cases[i].tow_ns), &unix_us), FW_OK);
		assert_true(unix_us == cases[i].unix_us);
		assert_int_equal(fw_time_from_unix_us(unix_us, &t), FW_OK);
		assert_time(t, cases[i].week, cases[i].tow_ns);
	}
	assert_int_equal(fw_time_to_unix_us(at(1930, 17 * S + 250999), &unix_us), FW_OK);
	assert_true(unix_us == 1483228800000250); /* inside 23:59:60, and rounded down */
	assert_int_equal(fw_time_from_unix_us(unix_us, &t), FW_OK);
	assert_time(t, 1930, 18 * S + 250000);
}

static void unix_time_outside_the_range_is_refused(void **state)
{
	fw_time t = {7};
	int64_t unix_us = 7;

	(void)state;
	assert_int_equal(fw_time_from_unix_us(315964799999999, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_unix_us(INT64_MIN, &t), FW_ERANGE);
	assert_int_equal(fw_time_from_unix_us(INT64_MAX, &t), FW_ERANGE);
	assert_int_equal(fw_time_to_unix_us((fw_time){-1}, &unix_us), FW_ERANGE);
	assert_true(t.ns == 7 && unix_us == 7);
}

/* ---- GLONASS ---- */

/* datetime: UTC + 3 h, days from 1 January of the interval's first year. */
static void glonass_time_is_what_datetime_says(void **state)
{
	static const struct {
		fw_civil utc;
		int n4, nt;
		int64_t tod_ns;
	} cases[] = {
	    {{1996, 1, 1, 0, 0, 0, 0}, 1, 1, 10800 * S},
	    {{1999, 12, 31, 20, 59, 59, 0}, 1, 1461, 86399 * S},
	    {{1999, 12, 31, 21, 0, 0, 0}, 2, 1, 0},
	    {{2015, 7, 1, 12, 0, 0, 0}, 5, 1278, 54000 * S},
	    {{2016, 12, 31, 23, 59, 59, 0}, 6, 367, 10799 * S},
	    {{2017, 1, 1, 0, 0, 0, 0}, 6, 367, 10800 * S},
	    {{2023, 12, 31, 20, 59, 59, 999000000}, 7, 1461, 86399999 * (S / 1000)},
	    {{2023, 12, 31, 21, 0, 0, 0}, 8, 1, 0},
	    {{2100, 2, 28, 21, 0, 0, 0}, 27, 60, 0},
	};
	int n4, nt;
	int64_t tod_ns;
	fw_time t, back;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		fw_status expected = cases[i].utc.year < 2027 ? FW_OK : FW_DUBIOUS;

		assert_int_equal(fw_time_from_utc(&cases[i].utc, &t), expected);
		assert_int_equal(fw_time_to_glonass(t, &n4, &nt, &tod_ns), expected);
		assert_int_equal(n4, cases[i].n4);
		assert_int_equal(nt, cases[i].nt);
		assert_true(tod_ns == cases[i].tod_ns);
		assert_int_equal(fw_time_from_glonass(n4, nt, tod_ns, &back), expected);
		assert_true(back.ns == t.ns);
	}
}

static void glonass_repeats_a_second_at_a_leap_second(void **state)
{
	int n4, nt;
	int64_t tod_ns;
	fw_time t;

	(void)state;
	assert_int_equal(fw_time_to_glonass(at(1930, 17 * S + 5), &n4, &nt, &tod_ns), FW_OK);
	assert_true(n4 == 6 && nt == 367 && tod_ns == 10800 * S + 5);
	assert_int_equal(fw_time_from_glonass(n4, nt, tod_ns, &t), FW_OK);
	assert_time(t, 1930, 18 * S + 5);
}

static void glonass_comes_back(void **state)
{
	const int64_t first = 835 * FW_NS_PER_WEEK, last = 7300 * FW_NS_PER_WEEK; /* 1996-01-07, 2119-12-17 */
	fw_random r;

	(void)state;
	fw_random_init(&r, 24);
	for (int i = 0; i < 100000; i++) {
		fw_time t = {first + random_ns(&r) % (last - first)}, back;
		int n4, nt;
		int64_t tod_ns;

		assert_true(fw_time_to_glonass(t, &n4, &nt, &tod_ns) >= 0);
		assert_true(fw_time_from_glonass(n4, nt, tod_ns, &back) >= 0);
		assert_true(back.ns == t.ns);
	}
}

static void glonass_refuses_what_does_not_exist(void **state)
{
	fw_time t = {7}, early;
	int n4 = 7, nt = 7;
	int64_t tod_ns = 7;

	(void)state;
	assert_int_equal(fw_time_from_glonass(0, 1, 0, &t), FW_EINVAL);
	assert_int_equal(fw_time_from_glonass(32, 1, 0, &t), FW_EINVAL);
	assert_int_equal(fw_time_from_glonass(8, 0, 0, &t), FW_EINVAL);
	assert_int_equal(fw_time_from_glonass(8, 1462, 0, &t), FW_EINVAL);
	assert_int_equal(fw_time_from_glonass(8, 1, -1, &t), FW_EINVAL);
	assert_int_equal(fw_time_from_glonass(8, 1, FW_NS_PER_DAY, &t), FW_EINVAL);
	assert_int_equal(fw_time_from_utc(&(fw_civil){1995, 12, 31, 20, 59, 59, 0}, &early), FW_OK);
	assert_int_equal(fw_time_to_glonass(early, &n4, &nt, &tod_ns), FW_ERANGE);
	assert_int_equal(fw_time_to_glonass(at(8000, 0), &n4, &nt, &tod_ns), FW_ERANGE);
	assert_int_equal(fw_time_to_glonass((fw_time){-1}, &n4, &nt, &tod_ns), FW_ERANGE);
	assert_true(t.ns == 7 && n4 == 7 && nt == 7 && tod_ns == 7);
}

/* ---- text ---- */

static void text_is_understood(void **state)
{
	static const struct {
		const char *text;
		fw_status status;
		int week;
		int64_t tow_ns;
	} cases[] = {
	    {"2446:45314", FW_OK, 2446, 45314 * S},
	    {"2446:45314.789", FW_OK, 2446, 45314789 * (S / 1000)},
	    {"0:0", FW_OK, 0, 0},
	    {"0002:000000.000000001", FW_OK, 2, 1},
	    {"8191:604799.999999999", FW_OK, 8191, FW_NS_PER_WEEK - 1},
	    {"2019-04-07T00:00:00", FW_OK, 2048, 0},
	    {"2000-02-29T12:00:00.5", FW_OK, 1051, 216000 * S + S / 2},
	    {"2019-04-06T23:59:42Z", FW_OK, 2048, 0},
	    {"2016-12-31T23:59:60.25Z", FW_OK, 1930, 17 * S + S / 4},
	    {"2027-06-28T00:00:00Z", FW_DUBIOUS, 2477, 86418 * S},
	};
	fw_time t;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		if (fw_time_parse(cases[i].text, &t) != cases[i].status)
			fail_msg("%s", cases[i].text);
		assert_time(t, cases[i].week, cases[i].tow_ns);
	}
}

static void other_text_is_refused(void **state)
{
	static const struct {
		const char *text;
		fw_status status;
	} cases[] = {
	    {"", FW_ESYNTAX},
	    {":", FW_ESYNTAX},
	    {"T", FW_ESYNTAX},
	    {"now", FW_ESYNTAX},
	    {"2446", FW_ESYNTAX},
	    {"2446:", FW_ESYNTAX},
	    {":45314", FW_ESYNTAX},
	    {"2446:45314.", FW_ESYNTAX},
	    {"2446:45314,5", FW_ESYNTAX},
	    {"2446:.5", FW_ESYNTAX},
	    {"2446:45314 ", FW_ESYNTAX},
	    {" 2446:45314", FW_ESYNTAX},
	    {"2446:-1", FW_ESYNTAX},
	    {"+2446:1", FW_ESYNTAX},
	    {"2446:1e3", FW_ESYNTAX},
	    {"2446:0000001", FW_ESYNTAX},
	    {"12446:1", FW_ESYNTAX},
	    {"2446:1.0123456789", FW_ESYNTAX},
	    {"2446:604800", FW_ERANGE},
	    {"8192:0", FW_ERANGE},
	    {"2019-04-07", FW_ESYNTAX},
	    {"2019-04-07 00:00:00", FW_ESYNTAX},
	    {"2019-04-07t00:00:00", FW_ESYNTAX},
	    {"2019-04-07T00:00", FW_ESYNTAX},
	    {"2019-04-07T00:00:00z", FW_ESYNTAX},
	    {"2019-04-07T00:00:00ZZ", FW_ESYNTAX},
	    {"2019-04-07T00:00:00.Z", FW_ESYNTAX},
	    {"2019-04-07T00:00:00+01:00", FW_ESYNTAX},
	    {"2019-4-07T00:00:00", FW_ESYNTAX},
	    {"2019-04-07T00:000:00", FW_ESYNTAX},
	    {"019-04-07T00:00:00", FW_ESYNTAX},
	    {"2019-13-07T00:00:00", FW_EINVAL},
	    {"2019-02-29T00:00:00Z", FW_EINVAL},
	    {"2019-04-07T24:00:00", FW_EINVAL},
	    {"2016-12-31T23:59:60", FW_EINVAL},
	    {"2018-12-31T23:59:60Z", FW_EINVAL},
	    {"1980-01-05T23:59:59", FW_ERANGE},
	    {"9999-01-01T00:00:00Z", FW_ERANGE},
	};
	fw_time t = {7};

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++)
		if (fw_time_parse(cases[i].text, &t) != cases[i].status)
			fail_msg("%s", cases[i].text);
	assert_int_equal(t.ns, 7);
}

/* A time is refused when cut at any character, and nothing is read past the cut. */
static void cut_text_is_refused(void **state)
{
	static const char *whole = "2019-04-06T23:59:42";
	char text[32];
	fw_time t = {7};

	(void)state;
	for (size_t n = 0; n < strlen(whole); n++) {
		memset(text, '9', sizeof(text));
		memcpy(text, whole, n);
		text[n] = '\0';
		assert_int_equal(fw_time_parse(text, &t), FW_ESYNTAX);
	}
	assert_int_equal(t.ns, 7);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(times_compare_and_subtract),
	    cmocka_unit_test(add_s_refuses_what_leaves_the_range),
	    cmocka_unit_test(weeks_come_back),
	    cmocka_unit_test(weeks_outside_are_refused),
	    cmocka_unit_test(time_of_week_is_never_negative),
	    cmocka_unit_test(other_systems_count_their_own_weeks),
	    cmocka_unit_test(other_systems_refuse_weeks_outside),
	    cmocka_unit_test(other_systems_come_back),
	    cmocka_unit_test(truncated_weeks_resolve_to_the_nearest),
	    cmocka_unit_test(truncated_weeks_find_every_week_back),
	    cmocka_unit_test(truncated_weeks_refuse_bad_arguments),
	    cmocka_unit_test(time_of_week_differences_wrap),
	    cmocka_unit_test(civil_dates_are_what_datetime_says),
	    cmocka_unit_test(every_day_follows_its_predecessor),
	    cmocka_unit_test(dates_that_do_not_exist_are_refused),
	    cmocka_unit_test(utc_is_what_astropy_says),
	    cmocka_unit_test(every_leap_second_is_there),
	    cmocka_unit_test(second_60_exists_only_in_a_leap_second),
	    cmocka_unit_test(the_table_knows_its_expiry),
	    cmocka_unit_test(utc_outside_the_range_is_refused),
	    cmocka_unit_test(utc_comes_back),
	    cmocka_unit_test(a_given_leap_count_overrides_the_table),
	    cmocka_unit_test(unix_time_is_what_astropy_says),
	    cmocka_unit_test(unix_time_outside_the_range_is_refused),
	    cmocka_unit_test(glonass_time_is_what_datetime_says),
	    cmocka_unit_test(glonass_repeats_a_second_at_a_leap_second),
	    cmocka_unit_test(glonass_comes_back),
	    cmocka_unit_test(glonass_refuses_what_does_not_exist),
	    cmocka_unit_test(text_is_understood),
	    cmocka_unit_test(other_text_is_refused),
	    cmocka_unit_test(cut_text_is_refused),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
