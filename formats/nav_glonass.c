#include "formats/nav_glonass.h"

#include <string.h>

#include "base/time.h"
#include "formats/nav_bits.h"

#include "furrow_eph_glo.h"

#define U            FW_NAV_UNSIGNED
#define S            FW_NAV_SIGNED
#define M            FW_NAV_SIGN_MAGNITUDE
#define COUNT(table) (int)(sizeof(table) / sizeof *(table))

enum { STRING_1, STRING_2, STRING_3, STRING_4, STRING_5, STRING_14, ALMANAC }; /* of a satellite's store */

enum {
	STRING_BITS = 85,
	CHANNEL_AT =
	    88, /* where a page that is kept has the frequency number k: eight bits that no string has */
	CHANNEL_UNKNOWN = -8,
	FRAME_SLACK_MS = 1000
};

/* Bits counted from the idle bit on, bit 85 of the ICD: bit n of the ICD is 85 - n here. Kilometres in the
 * string. */
static const fw_nav_field ephemeris[] = {
    {"p1_min", U, 0, 0, {{STRING_1, 7, 2}}}, /* a code; finish_ephemeris() makes minutes of it */
    {"vx_mps", M, -20, 1000, {{STRING_1, 21, 24}}},
    {"ax_mps2", M, -30, 1000, {{STRING_1, 45, 5}}},
    {"x_m", M, -11, 1000, {{STRING_1, 50, 27}}},
    {"health_b", U, 0, 0, {{STRING_2, 5, 3}}},
    {"p2", U, 0, 0, {{STRING_2, 8, 1}}},
    {"tb_min", U, 0, 15, {{STRING_2, 9, 7}}},
    {"vy_mps", M, -20, 1000, {{STRING_2, 21, 24}}},
    {"ay_mps2", M, -30, 1000, {{STRING_2, 45, 5}}},
    {"y_m", M, -11, 1000, {{STRING_2, 50, 27}}},
    {"gamma", M, -40, 0, {{STRING_3, 6, 11}}},
    {"p", U, 0, 0, {{STRING_3, 18, 2}}},
    {"l", U, 0, 0, {{STRING_3, 20, 1}}},
    {"vz_mps", M, -20, 1000, {{STRING_3, 21, 24}}},
    {"az_mps2", M, -30, 1000, {{STRING_3, 45, 5}}},
    {"z_m", M, -11, 1000, {{STRING_3, 50, 27}}},
    {"tau_s", M, -30, 0, {{STRING_4, 5, 22}}},
    {"dtau_s", M, -30, 0, {{STRING_4, 27, 5}}},
    {"age_days", U, 0, 0, {{STRING_4, 32, 5}}},
    {"p4", U, 0, 0, {{STRING_4, 51, 1}}},
    {"nt_day", U, 0, 0, {{STRING_4, 59, 11}}},
    {"m", U, 0, 0, {{STRING_4, 75, 2}}},
    {"glonass_channel", S, 0, 0, {{STRING_4, CHANNEL_AT, 8}}},
    {"health_c", U, 0, 0, {{ALMANAC, 5, 1}}},
};

static const fw_nav_field time_parameters[] = {
    {"day", U, 0, 0, {{STRING_5, 5, 11}}},
    {"tau_c_s", M, -31, 0, {{STRING_5, 16, 32}}},
    {"n4", U, 0, 0, {{STRING_5, 49, 5}}},
    {"tau_gps_s", M, -30, 0, {{STRING_5, 54, 22}}},
    {"glonass_channel", S, 0, 0, {{STRING_5, CHANNEL_AT, 8}}},
    {"b1_s", M, -10, 0, {{STRING_14, 5, 11}}},
    {"b2_s", M, -16, 0, {{STRING_14, 16, 10}}},
    {"kp", U, 0, 0, {{STRING_14, 26, 2}}},
};

/* GLONASS time (UTC + 3 h) minus GPS time [ms]. Past the end of the leap second table, its last count. */
static int64_t moscow_minus_gps_ms(int64_t gps_ms)
{
	const fw_time t = {gps_ms * 1000000};
	int leap_s = 0;

	(void)!fw_time_leap_seconds(t, &leap_s);
	return 10800000 - (int64_t)leap_s * 1000;
}

/* tb is a time of the Moscow day; the day is the one that puts it nearest to now. */
static void put_toe(int64_t now_ms, int tb_min, void *record)
{
	const int64_t day_ms = 86400000, offset_ms = moscow_minus_gps_ms(now_ms);
	const int64_t tb_ms = (int64_t)tb_min * 60000, moscow_ms = now_ms + offset_ms;
	const int64_t days = (moscow_ms - tb_ms + day_ms / 2) / day_ms;
	const int64_t toe_ms = days * day_ms + tb_ms - offset_ms;

	fw_nav_put(FW_eph_glo, record, "toe_s", (double)(toe_ms % FW_NAV_WEEK_MS / 1000));
	fw_nav_put(FW_eph_glo, record, "toe_week", (double)(toe_ms / FW_NAV_WEEK_MS & 1023));
}

static bool finish_ephemeris(const fw_nav_store *store, int64_t now_ms, void *record)
{
	static const uint8_t p1_min[] = {0, 30, 45, 60};
	static const double accuracy_m[] = {1, 2, 2.5, 4, 5, 7, 10, 12, 14, 16, 32, 64, 128, 256, 512};
	const uint8_t *string_4 = store->pages[STRING_4].bits;
	const unsigned f_t = fw_bits_unsigned(string_4, FW_NAV_PAGE_BYTES, 52, 4);
	const furrow_eph_glo *eph = record;

	if (eph->tb_min >= 1440 || now_ms < FW_NAV_WEEK_MS)
		return false;
	put_toe(now_ms, eph->tb_min, record);
	fw_nav_put(FW_eph_glo, record, "p1_min", p1_min[eph->p1_min]);
	if (f_t < COUNT(accuracy_m)) /* 15: unknown */
		fw_nav_put(FW_eph_glo, record, "accuracy_m", accuracy_m[f_t]);
	if (eph->glonass_channel == CHANNEL_UNKNOWN)
		fw_nav_remove(FW_eph_glo, record, "glonass_channel");
	return true;
}

static bool finish_time(const fw_nav_store *store, int64_t now_ms, void *record)
{
	const uint8_t *string_5 = store->pages[STRING_5].bits;

	(void)now_ms;
	if (fw_bits_unsigned(string_5, FW_NAV_PAGE_BYTES, CHANNEL_AT, 8) == (CHANNEL_UNKNOWN & 0xff))
		fw_nav_remove(FW_glo_time, record, "glonass_channel");
	return true;
}

/* Hamming code (ICD table 4.13): checks C1 to C7 and the overall parity C8 are all zero. A mask covers bits
 * 85 to 1 of the ICD, first bit first. */
static bool hamming_holds(const uint8_t *bits)
{
	static const uint8_t masks[8][11] = {
	    {0x55, 0x55, 0x5a, 0xaa, 0xaa, 0xaa, 0xb5, 0x55, 0x6a, 0xd8, 0x08},
	    {0x66, 0x66, 0x6c, 0xcc, 0xcc, 0xcc, 0xd9, 0x99, 0xb3, 0x68, 0x10},
	    {0x87, 0x87, 0x8f, 0x0f, 0x0f, 0x0f, 0x1e, 0x1e, 0x3c, 0x70, 0x20},
	    {0x07, 0xf8, 0x0f, 0xf0, 0x0f, 0xf0, 0x1f, 0xe0, 0x3f, 0x80, 0x40},
	    {0xf8, 0x00, 0x0f, 0xff, 0xf0, 0x00, 0x1f, 0xff, 0xc0, 0x00, 0x80},
	    {0x00, 0x00, 0x0f, 0xff, 0xff, 0xff, 0xe0, 0x00, 0x00, 0x01, 0x00},
	    {0xff, 0xff, 0xf0, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x00},
	    {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xf8},
	};

	for (int check = 0; check < 8; check++) {
		unsigned ones = 0;
		for (int i = 0; i < 11; i++)
			ones ^= bits[i] & masks[check][i];
		if (__builtin_parity(ones))
			return false;
	}
	return true;
}

/* Five frames of 30 s make a superframe; superframes begin with the Moscow day. */
static bool in_last_frame(int64_t begin_ms)
{
	const int64_t moscow_ms = begin_ms + moscow_minus_gps_ms(begin_ms);
	return (moscow_ms + 15000) / 30000 % 5 == 4;
}

/* Almanac of another satellite: of interest is its flag C alone. */
static void take_almanac(fw_nav_arrival *arrival)
{
	uint8_t *bits = arrival->page.bits;
	const unsigned slot = fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 8, 5);

	if (slot < 1 || slot > 24)
		return;
	arrival->index = ALMANAC;
	arrival->svid = (uint8_t)(37 + slot);
	bits[0] &= 0x04; /* bit 5 */
	memset(bits + 1, 0, FW_NAV_PAGE_BYTES - 1);
}

static fw_status unpack(const fw_nav_raw *raw, fw_nav_arrival *arrival)
{
	uint8_t *bits = arrival->page.bits;
	const int string = (int)fw_bits_unsigned(raw->bytes, sizeof raw->bytes, 1, 4);

	if (!hamming_holds(raw->bytes))
		return FW_ECHECKSUM;
	memcpy(bits, raw->bytes, 11);
	fw_bits_clear(bits, FW_NAV_PAGE_BYTES, STRING_BITS, 3);
	bits[CHANNEL_AT / 8] = (uint8_t)(raw->channel - 8);
	arrival->page.begin_ms = raw->end_ms - 2000 * string;
	if (string == 1)
		fw_bits_clear(bits, FW_NAV_PAGE_BYTES, 9, 12); /* t_k, the time of day */
	if (string >= 1 && string <= 5)
		arrival->index = string - 1;
	else if (string == 14 && in_last_frame(arrival->page.begin_ms))
		arrival->index = STRING_14;
	else if (string >= 6 && string <= 14 && string % 2 == 0)
		take_almanac(arrival);
	return FW_OK;
}

static const fw_nav_layout messages[] = {
    {FW_eph_glo, 1 << STRING_1 | 1 << STRING_2 | 1 << STRING_3 | 1 << STRING_4, 1 << ALMANAC, FRAME_SLACK_MS,
     COUNT(ephemeris), ephemeris, finish_ephemeris},
    {FW_glo_time, 1 << STRING_5 | 1 << STRING_14, 0, 600000, COUNT(time_parameters), time_parameters,
     finish_time},
};

const fw_nav_system fw_nav_gnav = {unpack, COUNT(messages), messages};
