#include "formats/nav_gps.h"

#include <string.h>

#include "formats/nav_bits.h"

#include "furrow_eph_gps.h"

#define U           FW_NAV_UNSIGNED
#define S           FW_NAV_SIGNED
#define SEMICIRCLES FW_GPS_PI

enum { PAGE_1, PAGE_2, PAGE_3, PAGE_IONO_UTC }; /* of a satellite's store */

enum { PREAMBLE = 0x8b, HEAD_BITS = 48 /* telemetry and hand-over word */ };

/* Bits counted over the data bits alone, 24 in a word: word n begins at 24 (n - 1). */
static const fw_nav_field ephemeris[] = {
    {"week", U, 0, 0, {{PAGE_1, 48, 10}}},
    {"code_on_l2", U, 0, 0, {{PAGE_1, 58, 2}}},
    {"ura", U, 0, 0, {{PAGE_1, 60, 4}}},
    {"health", U, 0, 0, {{PAGE_1, 64, 6}}},
    {"iodc", U, 0, 0, {{PAGE_1, 70, 2}, {PAGE_1, 168, 8}}},
    {"l2p_data", U, 0, 0, {{PAGE_1, 72, 1}}},
    {"tgd_s", S, -31, 0, {{PAGE_1, 160, 8}}},
    {"toc_s", U, 4, 0, {{PAGE_1, 176, 16}}},
    {"af2_sps2", S, -55, 0, {{PAGE_1, 192, 8}}},
    {"af1_sps", S, -43, 0, {{PAGE_1, 200, 16}}},
    {"af0_s", S, -31, 0, {{PAGE_1, 216, 22}}},
    {"iode2", U, 0, 0, {{PAGE_2, 48, 8}}},
    {"crs_m", S, -5, 0, {{PAGE_2, 56, 16}}},
    {"deltan_radps", S, -43, SEMICIRCLES, {{PAGE_2, 72, 16}}},
    {"m0_rad", S, -31, SEMICIRCLES, {{PAGE_2, 88, 32}}},
    {"cuc_rad", S, -29, 0, {{PAGE_2, 120, 16}}},
    {"ecc", U, -33, 0, {{PAGE_2, 136, 32}}},
    {"cus_rad", S, -29, 0, {{PAGE_2, 168, 16}}},
    {"sqrt_a_sqrtm", U, -19, 0, {{PAGE_2, 184, 32}}},
    {"toe_s", U, 4, 0, {{PAGE_2, 216, 16}}},
    {"fit", U, 0, 0, {{PAGE_2, 232, 1}}},
    {"cic_rad", S, -29, 0, {{PAGE_3, 48, 16}}},
    {"omega0_rad", S, -31, SEMICIRCLES, {{PAGE_3, 64, 32}}},
    {"cis_rad", S, -29, 0, {{PAGE_3, 96, 16}}},
    {"i0_rad", S, -31, SEMICIRCLES, {{PAGE_3, 112, 32}}},
    {"crc_m", S, -5, 0, {{PAGE_3, 144, 16}}},
    {"omega_rad", S, -31, SEMICIRCLES, {{PAGE_3, 160, 32}}},
    {"omegadot_radps", S, -43, SEMICIRCLES, {{PAGE_3, 192, 24}}},
    {"iode3", U, 0, 0, {{PAGE_3, 216, 8}}},
    {"idot_radps", S, -43, SEMICIRCLES, {{PAGE_3, 224, 14}}},
};

static const fw_nav_field ionosphere[] = {
    {"alpha0_s", S, -30, 0, {{PAGE_IONO_UTC, 56, 8}}}, {"alpha1_s", S, -27, 0, {{PAGE_IONO_UTC, 64, 8}}},
    {"alpha2_s", S, -24, 0, {{PAGE_IONO_UTC, 72, 8}}}, {"alpha3_s", S, -24, 0, {{PAGE_IONO_UTC, 80, 8}}},
    {"beta0_s", S, 11, 0, {{PAGE_IONO_UTC, 88, 8}}},   {"beta1_s", S, 14, 0, {{PAGE_IONO_UTC, 96, 8}}},
    {"beta2_s", S, 16, 0, {{PAGE_IONO_UTC, 104, 8}}},  {"beta3_s", S, 16, 0, {{PAGE_IONO_UTC, 112, 8}}},
};

static const fw_nav_field utc[] = {
    {"a1_sps", S, -50, 0, {{PAGE_IONO_UTC, 120, 24}}}, {"a0_s", S, -30, 0, {{PAGE_IONO_UTC, 144, 32}}},
    {"tot_s", U, 12, 0, {{PAGE_IONO_UTC, 176, 8}}},    {"wnt", U, 0, 0, {{PAGE_IONO_UTC, 184, 8}}},
    {"leap_s", S, 0, 0, {{PAGE_IONO_UTC, 192, 8}}},    {"wnlsf", U, 0, 0, {{PAGE_IONO_UTC, 200, 8}}},
    {"dn", U, 0, 0, {{PAGE_IONO_UTC, 208, 8}}},        {"leap_future_s", S, 0, 0, {{PAGE_IONO_UTC, 216, 8}}},
};

/* The three subframes carry the same issue of data; toe and toc are seconds of a week near now. */
static bool finish_ephemeris(const fw_nav_store *store, int64_t now_ms, void *record)
{
	const furrow_eph_gps *eph = record;

	(void)store;
	if ((eph->iodc & 0xff) != eph->iode2 || eph->iode2 != eph->iode3)
		return false;
	if (eph->toe_s >= 604800 || eph->toc_s >= 604800)
		return false;
	fw_nav_put(FW_eph_gps, record, "toe_week", fw_nav_week_of(now_ms, eph->toe_s) & 1023);
	fw_nav_put(FW_eph_gps, record, "toc_week", fw_nav_week_of(now_ms, eph->toc_s) & 1023);
	if (eph->tgd_s == -0x1p-24F) /* 10000000, the lowest value, says that there is none */
		fw_nav_remove(FW_eph_gps, record, "tgd_s");
	return true;
}

/* Table 20-XIV: bit i of a mask (from the left, 24 bits) says whether data bit d_i enters the parity bit. */
static uint32_t parity(uint32_t data, unsigned d29, unsigned d30)
{
	static const uint32_t masks[6] = {0xec7cd2, 0x763e69, 0xbb1f34, 0x5d8f9a, 0xaec7cd, 0x2dea27};
	uint32_t bits = 0;

	for (int i = 0; i < 6; i++) {
		const unsigned seed = i == 0 || i == 2 || i == 5 ? d29 : d30;
		bits = bits << 1 | ((unsigned)__builtin_parity(data & masks[i]) ^ seed);
	}
	return bits;
}

/* Checks the ten words and joins their data bits. Word 10 of every subframe ends in two zeros (20.3.3.2), so
 * the chain of inversions begins anew with each subframe. */
static bool join_words(const uint32_t *words, uint8_t *bits)
{
	unsigned d29 = 0, d30 = 0;
	size_t used = 0;

	for (int i = 0; i < 10; i++) {
		const uint32_t stored = words[i] & 0x3fffffff;
		const uint32_t sent = d30 ? stored ^ 0x3fffffff : stored;
		if (parity(stored >> 6, d29, d30) != (sent & 0x3f))
			return false;
		fw_bits_append(bits, FW_NAV_PAGE_BYTES, &used, stored >> 6, 24);
		d29 = sent >> 1 & 1;
		d30 = sent & 1;
	}
	return fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 0, 8) == PREAMBLE;
}

/* GPS sends the parameters as page 18 of subframe 4, QZSS in subframe 4 or 5 under its own data ID; both call
 * the page 56. (QZSS's page 61, parameters for Japan alone, is left aside.) */
static bool is_iono_utc(const uint8_t *bits, unsigned subframe, bool qzss)
{
	const unsigned data_id = fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 48, 2);
	const unsigned page_id = fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 50, 6);

	return page_id == 56 && data_id == (qzss ? 3 : 1) && (subframe == 4 || (qzss && subframe == 5));
}

static fw_status unpack(const fw_nav_raw *raw, fw_nav_arrival *arrival)
{
	uint8_t *bits = arrival->page.bits;

	if (!join_words(raw->words, bits))
		return FW_ECHECKSUM;
	const unsigned subframe = fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, 43, 3);
	if (subframe >= 1 && subframe <= 3)
		arrival->index = (int)subframe - 1;
	else if (is_iono_utc(bits, subframe, raw->svid >= 181))
		arrival->index = PAGE_IONO_UTC;
	fw_bits_clear(bits, FW_NAV_PAGE_BYTES, 0, HEAD_BITS);
	return FW_OK;
}

/* Subframes are joined by their issue of data; an issue may return after six hours (20.3.4.4). */
static const fw_nav_layout messages[] = {
    {FW_eph_gps, 1 << PAGE_1 | 1 << PAGE_2 | 1 << PAGE_3, 0, 3600000, sizeof ephemeris / sizeof *ephemeris,
     ephemeris, finish_ephemeris},
    {FW_klobuchar, 1 << PAGE_IONO_UTC, 0, 0, sizeof ionosphere / sizeof *ionosphere, ionosphere, NULL},
    {FW_utc, 1 << PAGE_IONO_UTC, 0, 0, sizeof utc / sizeof *utc, utc, NULL},
};

const fw_nav_system fw_nav_lnav = {unpack, sizeof messages / sizeof *messages, messages};
