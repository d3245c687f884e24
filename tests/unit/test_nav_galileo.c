/* Galileo I/NAV and F/NAV: random parameters in words and pages as OS SIS ICD 2.1 prints them (tables 34 to
 * 54; first bit of a word or page: 1), with the scale factors of its tables 67 to 85. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "nav_encode.h"
#include "nav_logs.h"

#define PI       3.1415926535898
#define COUNT(a) (int)(sizeof(a) / sizeof *(a))

enum { TOW = 212400, E12 = 82, INAV = 2, FNAV = 16 };

static const icd_field inav_eph[] = {
    {"iodnav", 'u', 1, 0, {{1, 7, 10}}},
    {"toe_s", 'u', 60, 0, {{1, 17, 14}}},
    {"m0_rad", 's', 0x1p-31, PI, {{1, 31, 32}}},
    {"ecc", 'u', 0x1p-33, 0, {{1, 63, 32}}},
    {"sqrt_a_sqrtm", 'u', 0x1p-19, 0, {{1, 95, 32}}},
    {"omega0_rad", 's', 0x1p-31, PI, {{2, 17, 32}}},
    {"i0_rad", 's', 0x1p-31, PI, {{2, 49, 32}}},
    {"omega_rad", 's', 0x1p-31, PI, {{2, 81, 32}}},
    {"idot_radps", 's', 0x1p-43, PI, {{2, 113, 14}}},
    {"omegadot_radps", 's', 0x1p-43, PI, {{3, 17, 24}}},
    {"deltan_radps", 's', 0x1p-43, PI, {{3, 41, 16}}},
    {"cuc_rad", 's', 0x1p-29, 0, {{3, 57, 16}}},
    {"cus_rad", 's', 0x1p-29, 0, {{3, 73, 16}}},
    {"crc_m", 's', 0x1p-5, 0, {{3, 89, 16}}},
    {"crs_m", 's', 0x1p-5, 0, {{3, 105, 16}}},
    {"sisa_e1e5b", 'u', 1, 0, {{3, 121, 8}}},
    {"cic_rad", 's', 0x1p-29, 0, {{4, 23, 16}}},
    {"cis_rad", 's', 0x1p-29, 0, {{4, 39, 16}}},
    {"toc_s", 'u', 60, 0, {{4, 55, 14}}},
    {"af0_s", 's', 0x1p-34, 0, {{4, 69, 31}}},
    {"af1_sps", 's', 0x1p-46, 0, {{4, 100, 21}}},
    {"af2_sps2", 's', 0x1p-59, 0, {{4, 121, 6}}},
    {"bgd_e1e5a_s", 's', 0x1p-32, 0, {{5, 48, 10}}},
    {"bgd_e1e5b_s", 's', 0x1p-32, 0, {{5, 58, 10}}},
};

static const icd_field inav_rest[] = {
    {"ai0_sfu", 'u', 0.25, 0, {{5, 7, 11}}},
    {"ai1_sfu", 's', 0x1p-8, 0, {{5, 18, 11}}},
    {"ai2_sfu", 's', 0x1p-15, 0, {{5, 29, 14}}},
    {"storm", 'u', 1, 0, {{5, 43, 5}}},
    {"a0_s", 's', 0x1p-30, 0, {{6, 7, 32}}},
    {"a1_sps", 's', 0x1p-50, 0, {{6, 39, 24}}},
    {"leap_s", 's', 1, 0, {{6, 63, 8}}},
    {"tot_s", 'u', 3600, 0, {{6, 71, 8}}},
    {"wnt", 'u', 1, 0, {{6, 79, 8}}},
    {"wnlsf", 'u', 1, 0, {{6, 87, 8}}},
    {"dn", 'u', 1, 0, {{6, 95, 3}}},
    {"leap_future_s", 's', 1, 0, {{6, 98, 8}}},
    {"a0_s", 's', 0x1p-35, 0, {{10, 87, 16}}},
    {"a1_sps", 's', 0x1p-51, 0, {{10, 103, 12}}},
    {"tot_s", 'u', 3600, 0, {{10, 115, 8}}},
    {"wnt", 'u', 1, 0, {{10, 123, 6}}},
};

static const icd_field fnav_eph[] = {
    {"iodnav", 'u', 1, 0, {{1, 13, 10}}},
    {"toc_s", 'u', 60, 0, {{1, 23, 14}}},
    {"af0_s", 's', 0x1p-34, 0, {{1, 37, 31}}},
    {"af1_sps", 's', 0x1p-46, 0, {{1, 68, 21}}},
    {"af2_sps2", 's', 0x1p-59, 0, {{1, 89, 6}}},
    {"sisa_e1e5a", 'u', 1, 0, {{1, 95, 8}}},
    {"bgd_e1e5a_s", 's', 0x1p-32, 0, {{1, 144, 10}}},
    {"m0_rad", 's', 0x1p-31, PI, {{2, 17, 32}}},
    {"omegadot_radps", 's', 0x1p-43, PI, {{2, 49, 24}}},
    {"ecc", 'u', 0x1p-33, 0, {{2, 73, 32}}},
    {"sqrt_a_sqrtm", 'u', 0x1p-19, 0, {{2, 105, 32}}},
    {"omega0_rad", 's', 0x1p-31, PI, {{2, 137, 32}}},
    {"idot_radps", 's', 0x1p-43, PI, {{2, 169, 14}}},
    {"i0_rad", 's', 0x1p-31, PI, {{3, 17, 32}}},
    {"omega_rad", 's', 0x1p-31, PI, {{3, 49, 32}}},
    {"deltan_radps", 's', 0x1p-43, PI, {{3, 81, 16}}},
    {"cuc_rad", 's', 0x1p-29, 0, {{3, 97, 16}}},
    {"cus_rad", 's', 0x1p-29, 0, {{3, 113, 16}}},
    {"crc_m", 's', 0x1p-5, 0, {{3, 129, 16}}},
    {"crs_m", 's', 0x1p-5, 0, {{3, 145, 16}}},
    {"toe_s", 'u', 60, 0, {{3, 161, 14}}},
    {"cic_rad", 's', 0x1p-29, 0, {{4, 17, 16}}},
    {"cis_rad", 's', 0x1p-29, 0, {{4, 33, 16}}},
};

static const icd_field fnav_rest[] = {
    {"ai0_sfu", 'u', 0.25, 0, {{1, 103, 11}}},
    {"ai1_sfu", 's', 0x1p-8, 0, {{1, 114, 11}}},
    {"ai2_sfu", 's', 0x1p-15, 0, {{1, 125, 14}}},
    {"storm", 'u', 1, 0, {{1, 139, 5}}},
    {"a0_s", 's', 0x1p-30, 0, {{4, 49, 32}}},
    {"a1_sps", 's', 0x1p-50, 0, {{4, 81, 24}}},
    {"leap_s", 's', 1, 0, {{4, 105, 8}}},
    {"tot_s", 'u', 3600, 0, {{4, 113, 8}}},
    {"wnt", 'u', 1, 0, {{4, 121, 8}}},
    {"wnlsf", 'u', 1, 0, {{4, 129, 8}}},
    {"dn", 'u', 1, 0, {{4, 137, 3}}},
    {"leap_future_s", 's', 1, 0, {{4, 140, 8}}},
    {"a0_s", 's', 0x1p-35, 0, {{4, 156, 16}}},
    {"a1_sps", 's', 0x1p-51, 0, {{4, 172, 12}}},
    {"tot_s", 'u', 3600, 0, {{4, 148, 8}}},
    {"wnt", 'u', 1, 0, {{4, 184, 6}}},
};

/* Rows of the two "rest" tables that belong to each record. */
static const struct {
	fw_kind kind;
	int first, last;
} rest_of[] = {{FW_nequick, 0, 3}, {FW_utc, 4, 11}, {FW_ggto, 12, 15}};

static fw_nav nav;

static void random_pages(fw_random *r, const icd_field *fields, int n, icd_page *pages, double *expected)
{
	for (int i = 0; i < n; i++) {
		uint32_t raw = random_raw(r, &fields[i]);
		if (strcmp(fields[i].column, "toe_s") == 0 || strcmp(fields[i].column, "toc_s") == 0)
			raw %= 604800 / 60;
		expected[i] = write_field(pages, &fields[i], raw);
		if (strncmp(fields[i].column, "sisa", 4) == 0 && raw == 255)
			expected[i] = (double)NAN;
	}
}

static void check_rest(const kept_records *kept, const icd_field *fields, const double *expected, int message)
{
	for (size_t k = 0; k < sizeof rest_of / sizeof *rest_of; k++) {
		const kept_record *record = last_of(kept, rest_of[k].kind);
		assert_non_null(record);
		assert_true(column_is(record, "message", message));
		assert_string_equal(record->sat, "E12");
		for (int i = rest_of[k].first; i <= rest_of[k].last; i++)
			assert_true(column_is(record, fields[i].column, expected[i]));
	}
}

/* Word types, issues of data, the satellite's number and health bits into pages[1..6, 10]. */
static void complete_inav(icd_page *pages, uint32_t issue, uint32_t health, uint32_t tow_s)
{
	for (uint32_t w = 1; w <= 10; w++)
		write_bits(&pages[w], 1, 6, w);
	for (int w = 1; w <= 4; w++)
		write_bits(&pages[w], 7, 10, issue);
	write_bits(&pages[4], 17, 6, E12 - 70);
	write_bits(&pages[5], 68, 6, health); /* E5b HS, E1-B HS, E5b DVS, E1-B DVS */
	write_bits(&pages[5], 74, 12, 2360 - 1024);
	write_bits(&pages[5], 86, 20, tow_s);
	write_bits(&pages[6], 106, 20, tow_s);
}

static void give_inav(const icd_page *pages, int tow_s, kept_records *kept)
{
	static const int order[] = {2, 4, 6, 10, 1, 3, 5};
	for (int i = 0; i < COUNT(order); i++) {
		const nav_block b = inav_block(E12, tow_s + 2 * i, &pages[order[i]]);
		assert_int_equal(give(&nav, &b, kept), FW_OK);
	}
}

static void test_inav(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 11);
	for (int round = 0; round < 200; round++) {
		icd_page pages[11] = {0};
		double expected[COUNT(inav_eph)], rest[COUNT(inav_rest)];
		kept_records kept = {0};
		const uint32_t health = (uint32_t)fw_random_below(&r, 64);

		random_pages(&r, inav_eph, COUNT(inav_eph), pages, expected);
		random_pages(&r, inav_rest, COUNT(inav_rest), pages, rest);
		if (rest[12] < 0 && rest[13] < 0)
			rest[15] =
			    write_field(pages, &inav_rest[15], 7); /* not the "no offset" of all ones */
		complete_inav(pages, (uint32_t)expected[0], health, TOW);
		fw_nav_init(&nav);
		give_inav(pages, TOW, &kept);
		assert_int_equal(kept.n, 4);
		const kept_record *k = last_of(&kept, FW_eph_gal);
		assert_true(k->record.head.tow_s == TOW + 12); /* word 5 was the last */
		for (int i = 0; i < COUNT(inav_eph); i++)
			assert_true(column_is(k, inav_eph[i].column, expected[i]));
		assert_true(column_is(k, "message", INAV));
		/* column health: E1-B valid, DVS, HS (2), E5b valid, DVS, HS (2) from the lowest bit on */
		assert_true(column_is(k, "health",
		                      0x11 | (health & 1) << 1 | (health >> 2 & 3) << 2 |
		                          (health >> 1 & 1) << 5 | (health >> 4) << 6));
		assert_true(
		    column_is(k, "toe_week", value_of(k, "toe_s") - (TOW + 12) > 302400 ? 2359 : 2360));
		assert_true(
		    column_is(k, "toc_week", value_of(k, "toc_s") - (TOW + 12) > 302400 ? 2359 : 2360));
		const char *const absent[] = {"health_prs", "sisa_e1e5a", "sisa_e1e6a", "bgd_e1e6a_s",
		                              "cnav_enc"};
		for (int i = 0; i < COUNT(absent); i++)
			assert_true(column_is(k, absent[i], (double)NAN));
		check_rest(&kept, inav_rest, rest, INAV);
	}
}

static void complete_fnav(icd_page *pages, uint32_t issue, uint32_t hs, uint32_t dvs)
{
	static const int time_at[] = {0, 168, 195, 187, 190};
	for (uint32_t p = 1; p <= 4; p++) {
		write_bits(&pages[p], 1, 6, p);
		write_bits(&pages[p], p == 1 ? 13 : 7, 10, issue);
		write_bits(&pages[p], time_at[p], 20, TOW);
		if (p < 4)
			write_bits(&pages[p], time_at[p] - 12, 12, 2360 - 1024);
	}
	write_bits(&pages[1], 7, 6, E12 - 70);
	write_bits(&pages[1], 154, 2, hs);
	write_bits(&pages[1], 188, 1, dvs);
}

static void test_fnav(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 12);
	for (int round = 0; round < 200; round++) {
		icd_page pages[5] = {0};
		double expected[COUNT(fnav_eph)], rest[COUNT(fnav_rest)];
		kept_records kept = {0};
		const uint32_t hs = (uint32_t)fw_random_below(&r, 4), dvs = (uint32_t)fw_random_below(&r, 2);

		random_pages(&r, fnav_eph, COUNT(fnav_eph), pages, expected);
		random_pages(&r, fnav_rest, COUNT(fnav_rest), pages, rest);
		if (rest[12] < 0 && rest[13] < 0)
			rest[15] = write_field(pages, &fnav_rest[15], 7);
		complete_fnav(pages, (uint32_t)expected[0], hs, dvs);
		fw_nav_init(&nav);
		for (int p = 1; p <= 4; p++) {
			const nav_block b = fnav_block(E12, TOW + 10 * p, &pages[p]);
			assert_int_equal(give(&nav, &b, &kept), FW_OK);
		}
		assert_int_equal(kept.n, 4);
		const kept_record *k = last_of(&kept, FW_eph_gal);
		for (int i = 0; i < COUNT(fnav_eph); i++)
			assert_true(column_is(k, fnav_eph[i].column, expected[i]));
		assert_true(column_is(k, "message", FNAV));
		assert_true(column_is(k, "health", 0x100 | dvs << 9 | hs << 10));
		assert_true(column_is(k, "bgd_e1e5b_s", (double)NAN) &&
		            column_is(k, "sisa_e1e5b", (double)NAN));
		check_rest(&kept, fnav_rest, rest, FNAV);
	}
}

/* Time goes on in words 5 and 6 and says nothing; one word of another issue is waited for; I/NAV and F/NAV
 * are kept apart. */
static void test_when(void **state)
{
	fw_random r;
	icd_page pages[11] = {0}, fnav[5] = {0};
	double ignored[COUNT(inav_eph)];
	kept_records kept = {0};

	(void)state;
	fw_random_init(&r, 13);
	random_pages(&r, inav_eph, COUNT(inav_eph), pages, ignored);
	fw_nav_init(&nav);
	complete_inav(pages, 500, 0, TOW);
	give_inav(pages, TOW, &kept);
	assert_int_equal(count_of(&kept, FW_eph_gal), 1);
	complete_inav(pages, 500, 0, TOW + 30);
	give_inav(pages, TOW + 30, &kept);
	assert_int_equal(kept.n, 4);

	complete_inav(pages, 501, 0, TOW + 60);
	write_bits(&pages[3], 7, 10, 500);
	give_inav(pages, TOW + 60, &kept);
	assert_int_equal(kept.n, 4);
	write_bits(&pages[3], 7, 10, 501);
	give_inav(pages, TOW + 90, &kept);
	assert_int_equal(kept.n, 5);

	random_pages(&r, fnav_eph, COUNT(fnav_eph), fnav, ignored);
	complete_fnav(fnav, 501, 0, 0);
	for (int p = 1; p <= 4; p++) {
		const nav_block b = fnav_block(E12, TOW + 120, &fnav[p]);
		assert_int_equal(give(&nav, &b, &kept), FW_OK);
	}
	assert_int_equal(kept.n, 9);
}

static void test_refused(void **state)
{
	icd_page pages[11] = {0};
	kept_records kept = {0};

	(void)state;
	fw_nav_init(&nav);
	complete_inav(pages, 7, 0, TOW);
	for (int bit = 0; bit < 220; bit++) { /* CRC-24Q sees every single bit */
		nav_block b = inav_block(E12, TOW, &pages[1]);
		b.bytes[20 + bit / 32 * 4 + 3 - bit % 32 / 8] ^= (uint8_t)(0x80 >> bit % 8);
		assert_int_equal(give(&nav, &b, &kept), FW_ECHECKSUM);
	}
	for (int bit = 0; bit < 238; bit++) {
		nav_block b = fnav_block(E12, TOW, &pages[1]);
		b.bytes[20 + bit / 32 * 4 + 3 - bit % 32 / 8] ^= (uint8_t)(0x80 >> bit % 8);
		assert_int_equal(give(&nav, &b, &kept), FW_ECHECKSUM);
	}

	/* no offset to GPS time; word 4 of another satellite */
	write_bits(&pages[10], 87, 32, 0xffffffff);
	write_bits(&pages[10], 119, 10, 0x3ff);
	write_bits(&pages[4], 17, 6, E12 - 70 + 1);
	give_inav(pages, TOW, &kept);
	assert_int_equal(count_of(&kept, FW_ggto), 0);
	assert_int_equal(count_of(&kept, FW_eph_gal), 0);
	assert_int_equal(count_of(&kept, FW_utc), 1);

	/* toe behind the end of the week */
	fw_nav_init(&nav);
	write_bits(&pages[4], 17, 6, E12 - 70);
	write_bits(&pages[1], 17, 14, 604800 / 60);
	give_inav(pages, TOW + 30, &kept);
	assert_int_equal(count_of(&kept, FW_eph_gal), 0);
	write_bits(&pages[1], 17, 14, 604800 / 60 - 1);
	give_inav(pages, TOW + 60, &kept);
	assert_int_equal(count_of(&kept, FW_eph_gal), 1);
}

/* A real log: what the decoder makes of its pages is what the receiver made of them. Fields: SBF reference
 * guide, GALNav 4002, GALIon 4030, GALUtc 4031; C/NAV and PRS are not in I/NAV. */
static void test_against_receiver(void **state)
{
	static const block_field galnav[] = {
	    {"sqrt_a_sqrtm", 'd', 16, 0, 0},
	    {"m0_rad", 'd', 24, PI, 0},
	    {"ecc", 'd', 32, 0, 0},
	    {"i0_rad", 'd', 40, PI, 0},
	    {"omega_rad", 'd', 48, PI, 0},
	    {"omega0_rad", 'd', 56, PI, 0},
	    {"omegadot_radps", 'f', 64, PI, 0},
	    {"idot_radps", 'f', 68, PI, 0},
	    {"deltan_radps", 'f', 72, PI, 0},
	    {"cuc_rad", 'f', 76, 0, 0},
	    {"cus_rad", 'f', 80, 0, 0},
	    {"crc_m", 'f', 84, 0, 0},
	    {"crs_m", 'f', 88, 0, 0},
	    {"cic_rad", 'f', 92, 0, 0},
	    {"cis_rad", 'f', 96, 0, 0},
	    {"toe_s", 'i', 100, 0, 0},
	    {"toc_s", 'i', 104, 0, 0},
	    {"af2_sps2", 'f', 108, 0, 0},
	    {"af1_sps", 'f', 112, 0, 0},
	    {"af0_s", 'd', 116, 0, 0},
	    {"toe_week", 'h', 124, 0, 0},
	    {"toc_week", 'h', 126, 0, 0},
	    {"iodnav", 'h', 128, 0, 0},
	    {"health", 'h', 130, 0, 0},
	    {"sisa_e1e5a", 'b', 133, 0, 255},
	    {"sisa_e1e5b", 'b', 134, 0, 255},
	    {"sisa_e1e6a", 'b', 135, 0, 255},
	    {"bgd_e1e5a_s", 'f', 136, 0, 0},
	    {"bgd_e1e5b_s", 'f', 140, 0, 0},
	    {"bgd_e1e6a_s", 'f', 144, 0, 0},
	};
	static const block_field galion[] = {
	    {"ai0_sfu", 'f', 16, 0, 0},
	    {"ai1_sfu", 'f', 20, 0, 0},
	    {"ai2_sfu", 'f', 24, 0, 0},
	    {"storm", 'b', 28, 0, 0},
	};
	static const block_field galutc[] = {
	    {"a1_sps", 'f', 16, 0, 0}, {"a0_s", 'd', 20, 0, 0},          {"tot_s", 'i', 28, 0, 0},
	    {"wnt", 'b', 32, 0, 0},    {"leap_s", 'c', 33, 0, 0},        {"wnlsf", 'b', 34, 0, 0},
	    {"dn", 'b', 35, 0, 0},     {"leap_future_s", 'c', 36, 0, 0},
	};
	size_t n = 0;
	uint8_t *log = load_log("sbf/log_0000.sbf", &n);
	kept_records kept = {0};

	(void)state;
	if (!log)
		skip();
	fw_nav_init(&nav);
	decode_log(&nav, log, n, &kept);
	assert_int_equal(compare_with_blocks(&kept, FW_eph_gal, 4002, true, galnav, COUNT(galnav), log, n),
	                 9);
	assert_int_equal(compare_with_blocks(&kept, FW_nequick, 4030, true, galion, COUNT(galion), log, n),
	                 2);
	assert_int_equal(compare_with_blocks(&kept, FW_utc, 4031, true, galutc, COUNT(galutc), log, n), 2);
	free(log);
}

/* Real pages of another receiver (u-blox), decoded by RTKLIB: RINEX 3.04 table A8. */
static void test_against_rtklib(void **state)
{
	static const char *const columns[31] = {
	    "af0_s",    "af1_sps", "af2_sps2", "iodnav",       "crs_m",          "deltan_radps", "m0_rad",
	    "cuc_rad",  "ecc",     "cus_rad",  "sqrt_a_sqrtm", "toe_s",          "cic_rad",      "omega0_rad",
	    "cis_rad",  "i0_rad",  "crc_m",    "omega_rad",    "omegadot_radps", "idot_radps",   NULL,
	    "toe_week", NULL,      NULL,       NULL,           "bgd_e1e5a_s",
	};
	size_t n = 0, n_rinex = 0, at = 0;
	uint8_t *log = load_log("ins/walk_0827/gnss_1730.ubx", &n);
	uint8_t *rinex = load_log("ins/walk_0827/converted/gnss_1730.nav", &n_rinex);
	ubx_subframe s = {0};
	kept_records kept = {0};

	(void)state;
	if (!log || !rinex) {
		free(log);
		free(rinex);
		skip();
	}
	fw_nav_init(&nav);
	while (next_subframe(log, n, &at, &s)) {
		icd_page page = {{0}};
		nav_block b;
		if (s.system != 2 || (s.signal != 1 && s.signal != 3))
			continue;
		for (int w = 0; w < 8; w++)
			write_bits(&page, 1 + 32 * w, 32, s.words[w]);
		if (s.signal == 1)
			memmove(page.bit + 115, page.bit + 129,
			        120); /* u-blox fills each half up to four words */
		b = block_of_bits(s.signal == 1 ? 4023 : 4022, (uint8_t)(70 + s.sat), s.tow_s, &page, 8);
		fw_store_u16(b.bytes + 12, 2381);
		assert_int_equal(give(&nav, &b, &kept), FW_OK);
	}
	assert_int_equal(compare_with_rinex(&kept, FW_eph_gal, columns, "iodnav", 3, 20, (char *)rinex), 16);
	free(log);
	free(rinex);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_inav),
	    cmocka_unit_test(test_fnav),
	    cmocka_unit_test(test_when),
	    cmocka_unit_test(test_refused),
	    cmocka_unit_test(test_against_receiver),
	    cmocka_unit_test(test_against_rtklib),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
