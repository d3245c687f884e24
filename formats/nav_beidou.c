#include "formats/nav_beidou.h"

#include "formats/nav_bits.h"

#include "furrow_eph_bds.h"

#define U            FW_NAV_UNSIGNED
#define S            FW_NAV_SIGNED
#define SEMICIRCLES  FW_GPS_PI
#define COUNT(table) (int)(sizeof(table) / sizeof *(table))

enum {
	PREAMBLE = 0x712,
	HEAD_BITS = 38,       /* preamble, reserved bits, subframe number, second of week */
	FRAME_SLACK_MS = 1000 /* two frames begin at least 3 s apart */
};

/* BeiDou time behind GPS time [ms]: 1356 weeks and 14 s. */
#define BDT_MS (1356 * FW_NAV_WEEK_MS + 14000)

static bool finish_ephemeris(const fw_nav_store *store, int64_t now_ms, void *record)
{
	const furrow_eph_bds *eph = record;

	(void)store;
	if (eph->toe_s >= 604800 || eph->toc_s >= 604800)
		return false;
	fw_nav_put(FW_eph_bds, record, "toe_week", fw_nav_week_of(now_ms - BDT_MS, eph->toe_s) & 8191);
	fw_nav_put(FW_eph_bds, record, "toc_week", fw_nav_week_of(now_ms - BDT_MS, eph->toc_s) & 8191);
	return true;
}

/* ---- a subframe ---- */

/* Is a word of BCH(15,11) without error? Rows of the check matrix of x^4 + x + 1. */
static bool bch_holds(uint32_t word)
{
	return !(__builtin_parity(word & 0x7ac8) | __builtin_parity(word & 0x3d64) |
	         __builtin_parity(word & 0x1eb2) | __builtin_parity(word & 0x7591));
}

/* Checks the ten words and joins their information bits, 26 of the first word and 22 of the others. The first
 * word is uncoded in its first half; the others hold two code words: information 1, information 2, parity 1,
 * parity 2. */
static bool join_words(const uint8_t *bytes, uint8_t *bits)
{
	size_t used = 0;

	if (!bch_holds(fw_bits_unsigned(bytes, 40, 15, 15)))
		return false;
	fw_bits_append(bits, FW_NAV_PAGE_BYTES, &used, fw_bits_unsigned(bytes, 40, 0, 26), 26);
	for (unsigned first = 30; first < 300; first += 30) {
		const uint32_t information = fw_bits_unsigned(bytes, 40, first, 22);
		const uint32_t parity = fw_bits_unsigned(bytes, 40, first + 22, 8);
		if (!bch_holds(information >> 11 << 4 | parity >> 4) ||
		    !bch_holds((information & 0x7ff) << 4 | (parity & 0xf)))
			return false;
		fw_bits_append(bits, FW_NAV_PAGE_BYTES, &used, information, 22);
	}
	return fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 0, 11) == PREAMBLE;
}

/* The bits of a subframe, its head cleared, and its number. */
static fw_status unpack(const fw_nav_raw *raw, uint8_t *bits, int *subframe)
{
	if (!join_words(raw->bytes, bits))
		return FW_ECHECKSUM;
	*subframe = (int)fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 15, 3);
	fw_bits_clear(bits, FW_NAV_PAGE_BYTES, 0, HEAD_BITS);
	return FW_OK;
}

static unsigned page_number(const uint8_t *bits)
{
	return fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 39, 7);
}

/* ---- D1 ---- */

enum { D1_1, D1_2, D1_3, D1_UTC }; /* of a satellite's store */

/* Bits counted over the information bits alone, 26 in the first word and 22 in the others. */
static const fw_nav_field d1_ephemeris[] = {
    {"health", U, 0, 0, {{D1_1, 38, 1}}},
    {"aodc", U, 0, 0, {{D1_1, 39, 5}}},
    {"ura", U, 0, 0, {{D1_1, 44, 4}}},
    {"week", U, 0, 0, {{D1_1, 48, 13}}},
    {"toc_s", U, 3, 0, {{D1_1, 61, 17}}},
    {"tgd1_s", S, 0, 1e-10, {{D1_1, 78, 10}}},
    {"tgd2_s", S, 0, 1e-10, {{D1_1, 88, 10}}},
    {"af2_sps2", S, -66, 0, {{D1_1, 162, 11}}},
    {"af0_s", S, -33, 0, {{D1_1, 173, 24}}},
    {"af1_sps", S, -50, 0, {{D1_1, 197, 22}}},
    {"aode", U, 0, 0, {{D1_1, 219, 5}}},
    {"deltan_radps", S, -43, SEMICIRCLES, {{D1_2, 38, 16}}},
    {"cuc_rad", S, -31, 0, {{D1_2, 54, 18}}},
    {"m0_rad", S, -31, SEMICIRCLES, {{D1_2, 72, 32}}},
    {"ecc", U, -33, 0, {{D1_2, 104, 32}}},
    {"cus_rad", S, -31, 0, {{D1_2, 136, 18}}},
    {"crc_m", S, -6, 0, {{D1_2, 154, 18}}},
    {"crs_m", S, -6, 0, {{D1_2, 172, 18}}},
    {"sqrt_a_sqrtm", U, -19, 0, {{D1_2, 190, 32}}},
    {"toe_s", U, 3, 0, {{D1_2, 222, 2}, {D1_3, 38, 15}}},
    {"i0_rad", S, -31, SEMICIRCLES, {{D1_3, 53, 32}}},
    {"cic_rad", S, -31, 0, {{D1_3, 85, 18}}},
    {"omegadot_radps", S, -43, SEMICIRCLES, {{D1_3, 103, 24}}},
    {"cis_rad", S, -31, 0, {{D1_3, 127, 18}}},
    {"idot_radps", S, -43, SEMICIRCLES, {{D1_3, 145, 14}}},
    {"omega0_rad", S, -31, SEMICIRCLES, {{D1_3, 159, 32}}},
    {"omega_rad", S, -31, SEMICIRCLES, {{D1_3, 191, 32}}},
};

static const fw_nav_field d1_ionosphere[] = {
    {"alpha0_s", S, -30, 0, {{D1_1, 98, 8}}},  {"alpha1_s", S, -27, 0, {{D1_1, 106, 8}}},
    {"alpha2_s", S, -24, 0, {{D1_1, 114, 8}}}, {"alpha3_s", S, -24, 0, {{D1_1, 122, 8}}},
    {"beta0_s", S, 11, 0, {{D1_1, 130, 8}}},   {"beta1_s", S, 14, 0, {{D1_1, 138, 8}}},
    {"beta2_s", S, 16, 0, {{D1_1, 146, 8}}},   {"beta3_s", S, 16, 0, {{D1_1, 154, 8}}},
};

/* Subframe 5, page 10; D2's page 102 is the same. */
#define UTC_FIELDS(page)                                                                                     \
	{                                                                                                    \
		{"leap_s", S, 0, 0, {{page, 46, 8}}}, {"leap_future_s", S, 0, 0, {{page, 54, 8}}},           \
		    {"wnlsf", U, 0, 0, {{page, 62, 8}}}, {"a0_s", S, -30, 0, {{page, 70, 32}}},              \
		    {"a1_sps", S, -50, 0, {{page, 102, 24}}}, {"dn", U, 0, 0, {{page, 126, 8}}},             \
	}

static const fw_nav_field d1_utc[] = UTC_FIELDS(D1_UTC);

static fw_status unpack_d1(const fw_nav_raw *raw, fw_nav_arrival *arrival)
{
	int subframe = 0;
	const fw_status status = unpack(raw, arrival->page.bits, &subframe);

	if (subframe >= 1 && subframe <= 3)
		arrival->index = subframe - 1;
	else if (subframe == 5 && page_number(arrival->page.bits) == 10)
		arrival->index = D1_UTC;
	arrival->page.begin_ms = raw->end_ms - 6000 * subframe;
	return status;
}

static const fw_nav_layout d1_messages[] = {
    {FW_eph_bds, 1 << D1_1 | 1 << D1_2 | 1 << D1_3, 0, FRAME_SLACK_MS, COUNT(d1_ephemeris), d1_ephemeris,
     finish_ephemeris},
    {FW_klobuchar, 1 << D1_1, 0, 0, COUNT(d1_ionosphere), d1_ionosphere, NULL},
    {FW_utc, 1 << D1_UTC, 0, 0, COUNT(d1_utc), d1_utc, NULL},
};

const fw_nav_system fw_nav_d1 = {unpack_d1, COUNT(d1_messages), d1_messages};

/* ---- D2 ---- */

enum { D2_1, D2_2, D2_3, D2_4, D2_5, D2_6, D2_7, D2_8, D2_9, D2_10, D2_UTC };

static const fw_nav_field d2_ephemeris[] = {
    {"health", U, 0, 0, {{D2_1, 42, 1}}},
    {"aodc", U, 0, 0, {{D2_1, 43, 5}}},
    {"ura", U, 0, 0, {{D2_1, 48, 4}}},
    {"week", U, 0, 0, {{D2_1, 52, 13}}},
    {"toc_s", U, 3, 0, {{D2_1, 65, 17}}},
    {"tgd1_s", S, 0, 1e-10, {{D2_1, 82, 10}}},
    {"tgd2_s", S, 0, 1e-10, {{D2_1, 92, 10}}},
    {"af0_s", S, -33, 0, {{D2_3, 80, 24}}},
    {"af1_sps", S, -50, 0, {{D2_3, 104, 4}, {D2_4, 42, 18}}},
    {"af2_sps2", S, -66, 0, {{D2_4, 60, 11}}},
    {"aode", U, 0, 0, {{D2_4, 71, 5}}},
    {"deltan_radps", S, -43, SEMICIRCLES, {{D2_4, 76, 16}}},
    {"cuc_rad", S, -31, 0, {{D2_4, 92, 14}, {D2_5, 42, 4}}},
    {"m0_rad", S, -31, SEMICIRCLES, {{D2_5, 46, 32}}},
    {"cus_rad", S, -31, 0, {{D2_5, 78, 18}}},
    {"ecc", U, -33, 0, {{D2_5, 96, 10}, {D2_6, 42, 22}}},
    {"sqrt_a_sqrtm", U, -19, 0, {{D2_6, 64, 32}}},
    {"cic_rad", S, -31, 0, {{D2_6, 96, 10}, {D2_7, 42, 8}}},
    {"cis_rad", S, -31, 0, {{D2_7, 50, 18}}},
    {"toe_s", U, 3, 0, {{D2_7, 68, 17}}},
    {"i0_rad", S, -31, SEMICIRCLES, {{D2_7, 85, 21}, {D2_8, 42, 11}}},
    {"crc_m", S, -6, 0, {{D2_8, 53, 18}}},
    {"crs_m", S, -6, 0, {{D2_8, 71, 18}}},
    {"omegadot_radps", S, -43, SEMICIRCLES, {{D2_8, 89, 19}, {D2_9, 42, 5}}},
    {"omega0_rad", S, -31, SEMICIRCLES, {{D2_9, 47, 32}}},
    {"omega_rad", S, -31, SEMICIRCLES, {{D2_9, 79, 27}, {D2_10, 42, 5}}},
    {"idot_radps", S, -43, SEMICIRCLES, {{D2_10, 47, 14}}},
};

static const fw_nav_field d2_ionosphere[] = {
    {"alpha0_s", S, -30, 0, {{D2_2, 42, 8}}}, {"alpha1_s", S, -27, 0, {{D2_2, 50, 8}}},
    {"alpha2_s", S, -24, 0, {{D2_2, 58, 8}}}, {"alpha3_s", S, -24, 0, {{D2_2, 66, 8}}},
    {"beta0_s", S, 11, 0, {{D2_2, 74, 8}}},   {"beta1_s", S, 14, 0, {{D2_2, 82, 8}}},
    {"beta2_s", S, 16, 0, {{D2_2, 90, 8}}},   {"beta3_s", S, 16, 0, {{D2_2, 98, 8}}},
};

static const fw_nav_field d2_utc[] = UTC_FIELDS(D2_UTC);

static fw_status unpack_d2(const fw_nav_raw *raw, fw_nav_arrival *arrival)
{
	int subframe = 0;
	const fw_status status = unpack(raw, arrival->page.bits, &subframe);
	const int page = (int)fw_bits_unsigned(arrival->page.bits, FW_NAV_PAGE_BYTES, 38, 4);

	if (subframe == 1 && page >= 1 && page <= 10) {
		arrival->index = page - 1;
		/* a page every 3 s, subframe 1 at its beginning */
		arrival->page.begin_ms = raw->end_ms - 600 - 3000 * (page - 1);
	} else if (subframe == 5 && page_number(arrival->page.bits) == 102) {
		arrival->index = D2_UTC;
	}
	return status;
}

static const fw_nav_layout d2_messages[] = {
    {FW_eph_bds, 0x3ff & ~(1 << D2_2), 0, FRAME_SLACK_MS, COUNT(d2_ephemeris), d2_ephemeris,
     finish_ephemeris},
    {FW_klobuchar, 1 << D2_2, 0, 0, COUNT(d2_ionosphere), d2_ionosphere, NULL},
    {FW_utc, 1 << D2_UTC, 0, 0, COUNT(d2_utc), d2_utc, NULL},
};

const fw_nav_system fw_nav_d2 = {unpack_d2, COUNT(d2_messages), d2_messages};
