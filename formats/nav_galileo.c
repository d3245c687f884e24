#include "formats/nav_galileo.h"

#include <string.h>

#include "formats/crc.h"
#include "formats/nav_bits.h"

#include "furrow_eph_gal.h"
#include "furrow_ggto.h"

#define U            FW_NAV_UNSIGNED
#define S            FW_NAV_SIGNED
#define C            FW_NAV_CONSTANT
#define SEMICIRCLES  FW_GPS_PI
#define COUNT(table) (int)(sizeof(table) / sizeof *(table))

enum { INAV = 2, FNAV = 16 }; /* the receiver's names for the two messages (column `message`) */

enum { PAGE_SPREAD_MS = 3600000 }; /* words are joined by their issue of data; this only keeps old ones out */

static uint32_t bits_of(const fw_nav_store *store, int page, unsigned first, unsigned width)
{
	return fw_bits_unsigned(store->pages[page].bits, FW_NAV_PAGE_BYTES, first, width);
}

/* What both messages have in common: the four pages with an issue of data carry the same one, and toe and toc
 * are seconds of a week near now. Galileo weeks are given as GPS weeks modulo 4096. */
static bool finish_ephemeris(const fw_nav_store *store, const uint8_t issue_at[4], int64_t now_ms,
                             void *record)
{
	const furrow_eph_gal *eph = record;

	for (int i = 0; i < 4; i++)
		if (bits_of(store, i, issue_at[i], 10) != (uint32_t)eph->iodnav)
			return false;
	if (eph->toe_s >= 604800 || eph->toc_s >= 604800)
		return false;
	fw_nav_put(FW_eph_gal, record, "toe_week", fw_nav_week_of(now_ms, eph->toe_s) & 4095);
	fw_nav_put(FW_eph_gal, record, "toc_week", fw_nav_week_of(now_ms, eph->toc_s) & 4095);
	return true;
}

/* SISA 255 is "no accuracy prediction available": absent, as in the receiver's blocks. */
static void drop_unknown_sisa(void *record, const char *column, int sisa)
{
	if (sisa == 255)
		fw_nav_remove(FW_eph_gal, record, column);
}

/* A time offset of nothing but ones says that there is none (OS SIS ICD 5.1.8). */
static bool finish_ggto(const fw_nav_store *store, int64_t now_ms, void *record)
{
	const furrow_ggto *ggto = record;

	(void)store;
	(void)now_ms;
	return !(ggto->a0_s == -0x1p-35F && ggto->a1_sps == -0x1p-51F && ggto->tot_s == 255 * 3600 &&
	         ggto->wnt == 63);
}

/* ---- I/NAV ---- */

enum { WORD_1, WORD_2, WORD_3, WORD_4, WORD_5, WORD_6, WORD_10 }; /* of a satellite's store */

/* Bits counted over the 128 bits of a word, its type included. */
static const fw_nav_field inav_ephemeris[] = {
    {"message", C, 0, INAV, {{0}}},
    {"iodnav", U, 0, 0, {{WORD_1, 6, 10}}},
    {"toe_s", U, 0, 60, {{WORD_1, 16, 14}}},
    {"m0_rad", S, -31, SEMICIRCLES, {{WORD_1, 30, 32}}},
    {"ecc", U, -33, 0, {{WORD_1, 62, 32}}},
    {"sqrt_a_sqrtm", U, -19, 0, {{WORD_1, 94, 32}}},
    {"omega0_rad", S, -31, SEMICIRCLES, {{WORD_2, 16, 32}}},
    {"i0_rad", S, -31, SEMICIRCLES, {{WORD_2, 48, 32}}},
    {"omega_rad", S, -31, SEMICIRCLES, {{WORD_2, 80, 32}}},
    {"idot_radps", S, -43, SEMICIRCLES, {{WORD_2, 112, 14}}},
    {"omegadot_radps", S, -43, SEMICIRCLES, {{WORD_3, 16, 24}}},
    {"deltan_radps", S, -43, SEMICIRCLES, {{WORD_3, 40, 16}}},
    {"cuc_rad", S, -29, 0, {{WORD_3, 56, 16}}},
    {"cus_rad", S, -29, 0, {{WORD_3, 72, 16}}},
    {"crc_m", S, -5, 0, {{WORD_3, 88, 16}}},
    {"crs_m", S, -5, 0, {{WORD_3, 104, 16}}},
    {"sisa_e1e5b", U, 0, 0, {{WORD_3, 120, 8}}},
    {"cic_rad", S, -29, 0, {{WORD_4, 22, 16}}},
    {"cis_rad", S, -29, 0, {{WORD_4, 38, 16}}},
    {"toc_s", U, 0, 60, {{WORD_4, 54, 14}}},
    {"af0_s", S, -34, 0, {{WORD_4, 68, 31}}},
    {"af1_sps", S, -46, 0, {{WORD_4, 99, 21}}},
    {"af2_sps2", S, -59, 0, {{WORD_4, 120, 6}}},
    {"bgd_e1e5a_s", S, -32, 0, {{WORD_5, 47, 10}}},
    {"bgd_e1e5b_s", S, -32, 0, {{WORD_5, 57, 10}}},
};

static const fw_nav_field inav_nequick[] = {
    {"message", C, 0, INAV, {{0}}},
    {"ai0_sfu", U, -2, 0, {{WORD_5, 6, 11}}},
    {"ai1_sfu", S, -8, 0, {{WORD_5, 17, 11}}},
    {"ai2_sfu", S, -15, 0, {{WORD_5, 28, 14}}},
    {"storm", U, 0, 0, {{WORD_5, 42, 5}}},
};

static const fw_nav_field inav_utc[] = {
    {"message", C, 0, INAV, {{0}}},
    {"a0_s", S, -30, 0, {{WORD_6, 6, 32}}},
    {"a1_sps", S, -50, 0, {{WORD_6, 38, 24}}},
    {"leap_s", S, 0, 0, {{WORD_6, 62, 8}}},
    {"tot_s", U, 0, 3600, {{WORD_6, 70, 8}}},
    {"wnt", U, 0, 0, {{WORD_6, 78, 8}}},
    {"wnlsf", U, 0, 0, {{WORD_6, 86, 8}}},
    {"dn", U, 0, 0, {{WORD_6, 94, 3}}},
    {"leap_future_s", S, 0, 0, {{WORD_6, 97, 8}}},
};

static const fw_nav_field inav_ggto[] = {
    {"message", C, 0, INAV, {{0}}},
    {"a0_s", S, -35, 0, {{WORD_10, 86, 16}}},
    {"a1_sps", S, -51, 0, {{WORD_10, 102, 12}}},
    {"tot_s", U, 0, 3600, {{WORD_10, 114, 8}}},
    {"wnt", U, 0, 0, {{WORD_10, 122, 6}}},
};

static bool finish_inav(const fw_nav_store *store, int64_t now_ms, void *record)
{
	static const uint8_t issue_at[4] = {6, 6, 6, 6};
	const uint32_t e5b_hs = bits_of(store, WORD_5, 67, 2), e1b_hs = bits_of(store, WORD_5, 69, 2);
	const uint32_t e5b_dvs = bits_of(store, WORD_5, 71, 1), e1b_dvs = bits_of(store, WORD_5, 72, 1);

	if (!finish_ephemeris(store, issue_at, now_ms, record))
		return false;
	fw_nav_put(FW_eph_gal, record, "health",
	           1U | e1b_dvs << 1 | e1b_hs << 2 | 1U << 4 | e5b_dvs << 5 | e5b_hs << 6);
	drop_unknown_sisa(record, "sisa_e1e5b", ((const furrow_eph_gal *)record)->sisa_e1e5b);
	return true;
}

/* Joins the 112 data bits of the even half-page and the 16 of the odd one. */
static void join_halves(const uint8_t *bytes, uint8_t *bits)
{
	size_t used = 0;

	for (unsigned i = 0; i < 112; i += 16)
		fw_bits_append(bits, FW_NAV_PAGE_BYTES, &used, fw_bits_unsigned(bytes, 40, 2 + i, 16), 16);
	fw_bits_append(bits, FW_NAV_PAGE_BYTES, &used, fw_bits_unsigned(bytes, 40, 116, 16), 16);
}

/* The satellite's own number in word 4 and F/NAV page 1: another one means a cross-correlated signal. */
static bool is_sender(const fw_nav_raw *raw, const uint8_t *bits, unsigned first)
{
	return fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, first, 6) + 70U == raw->svid;
}

static fw_status unpack_inav(const fw_nav_raw *raw, fw_nav_arrival *arrival)
{
	uint8_t *bits = arrival->page.bits;

	/* even/odd flag and page type, then again for the odd half */
	const unsigned even = fw_bits_unsigned(raw->bytes, sizeof raw->bytes, 0, 2);
	const unsigned odd = fw_bits_unsigned(raw->bytes, sizeof raw->bytes, 114, 2);

	if (fw_crc24q_bits(raw->bytes, 0, 220) != 0)
		return FW_ECHECKSUM;
	if (even != 0 || odd != 2)
		return FW_OK; /* an alert page */
	join_halves(raw->bytes, bits);
	const unsigned type = fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 0, 6);
	if (type >= 1 && type <= 6)
		arrival->index = (int)type - 1;
	else if (type == 10)
		arrival->index = WORD_10;
	if (type == 4 && !is_sender(raw, bits, 16))
		arrival->index = -1;
	if (type == 5)
		fw_bits_clear(bits, FW_NAV_PAGE_BYTES, 73, 32); /* week and time of week */
	if (type == 6)
		fw_bits_clear(bits, FW_NAV_PAGE_BYTES, 105, 20); /* time of week */
	return FW_OK;
}

static const fw_nav_layout inav_messages[] = {
    {FW_eph_gal, 1 << WORD_1 | 1 << WORD_2 | 1 << WORD_3 | 1 << WORD_4 | 1 << WORD_5, 0, PAGE_SPREAD_MS,
     COUNT(inav_ephemeris), inav_ephemeris, finish_inav},
    {FW_nequick, 1 << WORD_5, 0, 0, COUNT(inav_nequick), inav_nequick, NULL},
    {FW_utc, 1 << WORD_6, 0, 0, COUNT(inav_utc), inav_utc, NULL},
    {FW_ggto, 1 << WORD_10, 0, 0, COUNT(inav_ggto), inav_ggto, finish_ggto},
};

const fw_nav_system fw_nav_inav = {unpack_inav, COUNT(inav_messages), inav_messages};

/* ---- F/NAV ---- */

enum { PAGE_1, PAGE_2, PAGE_3, PAGE_4 };

/* Bits counted over the page, its type included. */
static const fw_nav_field fnav_ephemeris[] = {
    {"message", C, 0, FNAV, {{0}}},
    {"iodnav", U, 0, 0, {{PAGE_1, 12, 10}}},
    {"toc_s", U, 0, 60, {{PAGE_1, 22, 14}}},
    {"af0_s", S, -34, 0, {{PAGE_1, 36, 31}}},
    {"af1_sps", S, -46, 0, {{PAGE_1, 67, 21}}},
    {"af2_sps2", S, -59, 0, {{PAGE_1, 88, 6}}},
    {"sisa_e1e5a", U, 0, 0, {{PAGE_1, 94, 8}}},
    {"bgd_e1e5a_s", S, -32, 0, {{PAGE_1, 143, 10}}},
    {"m0_rad", S, -31, SEMICIRCLES, {{PAGE_2, 16, 32}}},
    {"omegadot_radps", S, -43, SEMICIRCLES, {{PAGE_2, 48, 24}}},
    {"ecc", U, -33, 0, {{PAGE_2, 72, 32}}},
    {"sqrt_a_sqrtm", U, -19, 0, {{PAGE_2, 104, 32}}},
    {"omega0_rad", S, -31, SEMICIRCLES, {{PAGE_2, 136, 32}}},
    {"idot_radps", S, -43, SEMICIRCLES, {{PAGE_2, 168, 14}}},
    {"i0_rad", S, -31, SEMICIRCLES, {{PAGE_3, 16, 32}}},
    {"omega_rad", S, -31, SEMICIRCLES, {{PAGE_3, 48, 32}}},
    {"deltan_radps", S, -43, SEMICIRCLES, {{PAGE_3, 80, 16}}},
    {"cuc_rad", S, -29, 0, {{PAGE_3, 96, 16}}},
    {"cus_rad", S, -29, 0, {{PAGE_3, 112, 16}}},
    {"crc_m", S, -5, 0, {{PAGE_3, 128, 16}}},
    {"crs_m", S, -5, 0, {{PAGE_3, 144, 16}}},
    {"toe_s", U, 0, 60, {{PAGE_3, 160, 14}}},
    {"cic_rad", S, -29, 0, {{PAGE_4, 16, 16}}},
    {"cis_rad", S, -29, 0, {{PAGE_4, 32, 16}}},
};

static const fw_nav_field fnav_nequick[] = {
    {"message", C, 0, FNAV, {{0}}},
    {"ai0_sfu", U, -2, 0, {{PAGE_1, 102, 11}}},
    {"ai1_sfu", S, -8, 0, {{PAGE_1, 113, 11}}},
    {"ai2_sfu", S, -15, 0, {{PAGE_1, 124, 14}}},
    {"storm", U, 0, 0, {{PAGE_1, 138, 5}}},
};

static const fw_nav_field fnav_utc[] = {
    {"message", C, 0, FNAV, {{0}}},
    {"a0_s", S, -30, 0, {{PAGE_4, 48, 32}}},
    {"a1_sps", S, -50, 0, {{PAGE_4, 80, 24}}},
    {"leap_s", S, 0, 0, {{PAGE_4, 104, 8}}},
    {"tot_s", U, 0, 3600, {{PAGE_4, 112, 8}}},
    {"wnt", U, 0, 0, {{PAGE_4, 120, 8}}},
    {"wnlsf", U, 0, 0, {{PAGE_4, 128, 8}}},
    {"dn", U, 0, 0, {{PAGE_4, 136, 3}}},
    {"leap_future_s", S, 0, 0, {{PAGE_4, 139, 8}}},
};

static const fw_nav_field fnav_ggto[] = {
    {"message", C, 0, FNAV, {{0}}},           {"tot_s", U, 0, 3600, {{PAGE_4, 147, 8}}},
    {"a0_s", S, -35, 0, {{PAGE_4, 155, 16}}}, {"a1_sps", S, -51, 0, {{PAGE_4, 171, 12}}},
    {"wnt", U, 0, 0, {{PAGE_4, 183, 6}}},
};

static bool finish_fnav(const fw_nav_store *store, int64_t now_ms, void *record)
{
	static const uint8_t issue_at[4] = {12, 6, 6, 6};
	const uint32_t hs = bits_of(store, PAGE_1, 153, 2), dvs = bits_of(store, PAGE_1, 187, 1);

	if (!finish_ephemeris(store, issue_at, now_ms, record))
		return false;
	fw_nav_put(FW_eph_gal, record, "health", 1U << 8 | dvs << 9 | hs << 10);
	drop_unknown_sisa(record, "sisa_e1e5a", ((const furrow_eph_gal *)record)->sisa_e1e5a);
	return true;
}

static fw_status unpack_fnav(const fw_nav_raw *raw, fw_nav_arrival *arrival)
{
	static const uint8_t time_at[] = {155, 182, 174, 189}; /* week (but on page 4) and time of week */
	static const uint8_t time_width[] = {32, 32, 32, 20};
	uint8_t *bits = arrival->page.bits;

	if (fw_crc24q_bits(raw->bytes, 0, 238) != 0)
		return FW_ECHECKSUM;
	const unsigned type = fw_bits_unsigned(raw->bytes, sizeof raw->bytes, 0, 6);
	if (type < 1 || type > 4 || (type == 1 && !is_sender(raw, raw->bytes, 6)))
		return FW_OK;
	arrival->index = (int)type - 1;
	memcpy(bits, raw->bytes, 27); /* 214 bits; the CRC is not kept */
	fw_bits_clear(bits, FW_NAV_PAGE_BYTES, 214, 2);
	fw_bits_clear(bits, FW_NAV_PAGE_BYTES, time_at[type - 1], time_width[type - 1]);
	return FW_OK;
}

static const fw_nav_layout fnav_messages[] = {
    {FW_eph_gal, 1 << PAGE_1 | 1 << PAGE_2 | 1 << PAGE_3 | 1 << PAGE_4, 0, PAGE_SPREAD_MS,
     COUNT(fnav_ephemeris), fnav_ephemeris, finish_fnav},
    {FW_nequick, 1 << PAGE_1, 0, 0, COUNT(fnav_nequick), fnav_nequick, NULL},
    {FW_utc, 1 << PAGE_4, 0, 0, COUNT(fnav_utc), fnav_utc, NULL},
    {FW_ggto, 1 << PAGE_4, 0, 0, COUNT(fnav_ggto), fnav_ggto, finish_ggto},
};

const fw_nav_system fw_nav_fnav = {unpack_fnav, COUNT(fnav_messages), fnav_messages};
