/* Times: text, and the numbers of all clocks, there and back. The first line is text, the rest numbers. */
#include <string.h>

#include "base/time.h"
#include "formats/bytes.h"

#include "text_input.h"

static const char *const words[] = {
    "2360:345600",
    "8191:604799.999999999",
    "0:0",
    ":604800",
    "2026-11-22T05:00:00",
    "2016-12-31T23:59:60Z",
    "2016-12-31T23:59:60",
    "1980-01-06T00:00:00",
    "2137-01-04T23:59:59.999999999",
    "2100-02-29T00:00:00",
    "Z",
    "T",
    ".",
    ".0000000001",
    "-",
    ":",
    "99999",
    "24:00:00",
    "13-01",
    "00-00",
};

enum { WORDS = sizeof words / sizeof *words };

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	const size_t n = (size_t)snprintf((char *)data, 64, "%s\n", words[fw_random_below(random, WORDS)]);
	const uint64_t ns = fw_random_below(random, FW_TIME_NS_MAX);
	fw_store_u64(data + n, ns);
	for (size_t i = 0; i < 16; i++)
		data[n + 8 + i] = (uint8_t)fw_random_below(random, 64);
	return n + 24;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return text_mutate(data, size, max, seed, words, WORDS);
}

static int is_moment(fw_time t)
{
	return t.ns >= 0 && t.ns <= FW_TIME_NS_MAX;
}

/* From a count to every clock and back. */
static void check_moment(fw_time t)
{
	fw_time back = {-1};
	fw_civil c;
	int week, n4, nt;
	int64_t tow_ns, tod_ns, unix_us;

	fw_time_to_gps(t, &week, &tow_ns);
	require((fw_time_from_gps(week, tow_ns, &back) == FW_OK) == is_moment(t) &&
	        (!is_moment(t) || back.ns == t.ns));
	if (fw_time_to_civil(t, &c) == FW_OK)
		require(fw_time_from_civil(&c, &back) == FW_OK && back.ns == t.ns);
	if (fw_time_to_utc(t, &c) >= 0)
		require(fw_time_from_utc(&c, &back) >= 0 && back.ns == t.ns);
	if (fw_time_to_utc_leap(t, 18, &c) == FW_OK)
		require(fw_time_from_utc_leap(&c, 18, &back) == FW_OK && back.ns == t.ns);
	if (fw_time_to_unix_us(t, &unix_us) >= 0 && fw_time_from_unix_us(unix_us, &back) >= 0)
		require(t.ns - back.ns < FW_NS_PER_S &&
		        back.ns - t.ns <= FW_NS_PER_S); /* a leap second comes twice */
	if (fw_time_to_glonass(t, &n4, &nt, &tod_ns) >= 0 && fw_time_from_glonass(n4, nt, tod_ns, &back) >= 0)
		require(t.ns - back.ns < FW_NS_PER_S && back.ns - t.ns <= FW_NS_PER_S);
}

/* From numbers that need not mean anything. */
static void check_numbers(const uint8_t *p)
{
	const fw_civil c = {
	    1980 + p[0], p[1] % 16, p[2] % 40, p[3] % 30, p[4], p[5] % 70, (int)fw_load_u32(p + 6)};
	const int64_t ns = (int64_t)fw_load_u64(p);
	fw_time t;
	int week;

	check_moment((fw_time){ns});
	check_moment((fw_time){ns & ((INT64_C(1) << 62) - 1)});
	if (fw_time_from_civil(&c, &t) >= 0)
		require(is_moment(t));
	if (fw_time_from_utc(&c, &t) >= 0)
		require(is_moment(t));
	if (fw_time_from_glonass(p[0], (int)fw_load_u16(p + 1), ns, &t) >= 0)
		require(is_moment(t));
	if (fw_time_from_unix_us(ns, &t) >= 0)
		require(is_moment(t));
	if (fw_time_from_gst(fw_load_u16(p), ns, &t) == FW_OK)
		require(is_moment(t));
	if (fw_time_from_bdt(fw_load_u16(p), ns, &t) == FW_OK)
		require(is_moment(t));
	if (fw_time_from_gps_s(fw_load_u16(p), fw_load_f64(p + 8), &t) == FW_OK)
		require(is_moment(t));
	if (fw_time_add_s((fw_time){ns & FW_TIME_NS_MAX}, fw_load_f64(p + 8), &t) == FW_OK)
		require(is_moment(t));
	if (fw_week_resolve((int)fw_load_u32(p), (int)fw_load_u32(p + 4), (int)fw_load_u32(p + 8), &week) ==
	    FW_OK)
		require(week >= 0 && week <= FW_TIME_WEEK_MAX);
	(void)fw_tow_wrap_s(fw_load_f64(p));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	char text[128] = "";
	fw_time t;
	const uint8_t *end = memchr(data, '\n', size);
	const size_t n = end != NULL ? (size_t)(end - data) : size;

	memcpy(text, data, n < sizeof text - 1 ? n : sizeof text - 1);
	if (fw_time_parse(text, &t) >= 0) {
		require(is_moment(t));
		check_moment(t);
	}
	if (size - n > 24)
		check_numbers(data + n + 1);
	return 0;
}
