/* GPS and QZSS LNAV: random parameters are written into subframes as IS-GPS-200N figure 20-1 draws them
 * (word, bit 1..30 of it; here bit 30 (word - 1) + bit), with the scale factors of tables 20-I, 20-III,
 * 20-IX, 20-X. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "nav_encode.h"
#include "nav_logs.h"

#define PI           3.1415926535898
#define W(word, bit) (30 * ((word)-1) + (bit))

static const icd_field eph[] = {
    {"week", 'u', 1, 0, {{1, W(3, 1), 10}}},
    {"code_on_l2", 'u', 1, 0, {{1, W(3, 11), 2}}},
    {"ura", 'u', 1, 0, {{1, W(3, 13), 4}}},
    {"health", 'u', 1, 0, {{1, W(3, 17), 6}}},
    {"iodc", 'u', 1, 0, {{1, W(3, 23), 2}, {1, W(8, 1), 8}}},
    {"l2p_data", 'u', 1, 0, {{1, W(4, 1), 1}}},
    {"tgd_s", 's', 0x1p-31, 0, {{1, W(7, 17), 8}}},
    {"toc_s", 'u', 16, 0, {{1, W(8, 9), 16}}},
    {"af2_sps2", 's', 0x1p-55, 0, {{1, W(9, 1), 8}}},
    {"af1_sps", 's', 0x1p-43, 0, {{1, W(9, 9), 16}}},
    {"af0_s", 's', 0x1p-31, 0, {{1, W(10, 1), 22}}},
    {"iode2", 'u', 1, 0, {{2, W(3, 1), 8}}},
    {"crs_m", 's', 0x1p-5, 0, {{2, W(3, 9), 16}}},
    {"deltan_radps", 's', 0x1p-43, PI, {{2, W(4, 1), 16}}},
    {"m0_rad", 's', 0x1p-31, PI, {{2, W(4, 17), 8}, {2, W(5, 1), 24}}},
    {"cuc_rad", 's', 0x1p-29, 0, {{2, W(6, 1), 16}}},
    {"ecc", 'u', 0x1p-33, 0, {{2, W(6, 17), 8}, {2, W(7, 1), 24}}},
    {"cus_rad", 's', 0x1p-29, 0, {{2, W(8, 1), 16}}},
    {"sqrt_a_sqrtm", 'u', 0x1p-19, 0, {{2, W(8, 17), 8}, {2, W(9, 1), 24}}},
    {"toe_s", 'u', 16, 0, {{2, W(10, 1), 16}}},
    {"fit", 'u', 1, 0, {{2, W(10, 17), 1}}},
    {"cic_rad", 's', 0x1p-29, 0, {{3, W(3, 1), 16}}},
    {"omega0_rad", 's', 0x1p-31, PI, {{3, W(3, 17), 8}, {3, W(4, 1), 24}}},
    {"cis_rad", 's', 0x1p-29, 0, {{3, W(5, 1), 16}}},
    {"i0_rad", 's', 0x1p-31, PI, {{3, W(5, 17), 8}, {3, W(6, 1), 24}}},
    {"crc_m", 's', 0x1p-5, 0, {{3, W(7, 1), 16}}},
    {"omega_rad", 's', 0x1p-31, PI, {{3, W(7, 17), 8}, {3, W(8, 1), 24}}},
    {"omegadot_radps", 's', 0x1p-43, PI, {{3, W(9, 1), 24}}},
    {"iode3", 'u', 1, 0, {{3, W(10, 1), 8}}},
    {"idot_radps", 's', 0x1p-43, PI, {{3, W(10, 9), 14}}},
};

static const icd_field iono[] = {
    {"alpha0_s", 's', 0x1p-30, 0, {{4, W(3, 9), 8}}}, {"alpha1_s", 's', 0x1p-27, 0, {{4, W(3, 17), 8}}},
    {"alpha2_s", 's', 0x1p-24, 0, {{4, W(4, 1), 8}}}, {"alpha3_s", 's', 0x1p-24, 0, {{4, W(4, 9), 8}}},
    {"beta0_s", 's', 2048, 0, {{4, W(4, 17), 8}}},    {"beta1_s", 's', 16384, 0, {{4, W(5, 1), 8}}},
    {"beta2_s", 's', 65536, 0, {{4, W(5, 9), 8}}},    {"beta3_s", 's', 65536, 0, {{4, W(5, 17), 8}}},
};

static const icd_field utc[] = {
    {"a1_sps", 's', 0x1p-50, 0, {{4, W(6, 1), 24}}},
    {"a0_s", 's', 0x1p-30, 0, {{4, W(7, 1), 24}, {4, W(8, 1), 8}}},
    {"tot_s", 'u', 4096, 0, {{4, W(8, 9), 8}}},
    {"wnt", 'u', 1, 0, {{4, W(8, 17), 8}}},
    {"leap_s", 's', 1, 0, {{4, W(9, 1), 8}}},
    {"wnlsf", 'u', 1, 0, {{4, W(9, 9), 8}}},
    {"dn", 'u', 1, 0, {{4, W(9, 17), 8}}},
    {"leap_future_s", 's', 1, 0, {{4, W(10, 1), 8}}},
};

#define COUNT(a) (int)(sizeof(a) / sizeof *(a))

enum { TOW = 212400 }; /* end of subframe 1 is TOW + 6 */

static fw_nav nav;

/* Telemetry and hand-over word: preamble, and a count that goes up. */
static void write_head(icd_page *page, int subframe, int tow_s)
{
	write_bits(page, W(1, 1), 8, 0x8b);
	write_bits(page, W(1, 9), 14, (uint32_t)tow_s & 0x3fff);
	write_bits(page, W(2, 1), 17, (uint32_t)tow_s / 6);
	write_bits(page, W(2, 20), 3, (uint32_t)subframe);
}

static const icd_field *field(const icd_field *fields, int n, const char *column)
{
	for (int i = 0; i < n; i++)
		if (strcmp(fields[i].column, column) == 0)
			return &fields[i];
	fail();
	return NULL;
}

/* Random parameters that belong together. expected[i] is what eph[i] stands for. */
static void random_ephemeris(fw_random *r, icd_page *pages, double *expected)
{
	const uint32_t iodc = (uint32_t)fw_random_below(r, 1024);

	for (int i = 0; i < COUNT(eph); i++) {
		const char *name = eph[i].column;
		uint32_t raw = random_raw(r, &eph[i]);
		if (strncmp(name, "io", 2) == 0)
			raw = strcmp(name, "iodc") == 0 ? iodc : iodc & 0xff;
		if (strncmp(name, "to", 2) == 0)
			raw %= 604800 / 16;
		expected[i] = write_field(pages, &eph[i], raw);
		if (strcmp(name, "tgd_s") == 0 && raw == 0x80)
			expected[i] = (double)NAN;
	}
}

static void give_ephemeris(const icd_page *pages, uint16_t number, uint8_t svid, int tow_s,
                           kept_records *kept)
{
	for (int s = 1; s <= 3; s++) {
		icd_page page = pages[s];
		write_head(&page, s, tow_s + 6 * s);
		const nav_block b = gps_block(number, svid, tow_s + 6 * s, &page);
		assert_int_equal(give(&nav, &b, kept), FW_OK);
	}
}

static void test_ephemeris(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 1);
	for (int round = 0; round < 300; round++) {
		const bool qzss = round % 3 == 2;
		const uint8_t svid = (uint8_t)(qzss ? 181 + round % 10 : 1 + round % 37);
		icd_page pages[5] = {0};
		double expected[COUNT(eph)];
		kept_records kept = {0};

		random_ephemeris(&r, pages, expected);
		fw_nav_init(&nav);
		give_ephemeris(pages, qzss ? 4066 : 4017, svid, TOW, &kept);
		assert_int_equal(kept.n, 1);
		const kept_record *k = &kept.list[0];
		assert_int_equal(k->kind, FW_eph_gps);
		assert_int_equal(k->sat[0], qzss ? 'J' : 'G');
		assert_string_equal(k->source, "raw");
		assert_true(k->record.head.gps_week == 2360 && k->record.head.tow_s == TOW + 18);
		for (int i = 0; i < COUNT(eph); i++)
			assert_true(column_is(k, eph[i].column, expected[i]));
		/* 2360 mod 1024 = 312; toe more than half a week off lies in a neighbouring week */
		const double toe = value_of(k, "toe_s");
		assert_true(column_is(k, "toe_week", toe - (TOW + 18) > 302400 ? 311 : 312));
	}
}

static void test_week_of_toe(void **state)
{
	(void)state;
	assert_int_equal(fw_nav_week_of(604800000LL * 5 + 604799000, 0), 6);
	assert_int_equal(fw_nav_week_of(604800000LL * 5 + 1000, 604799), 4);
	assert_int_equal(fw_nav_week_of(604800000LL * 5 + 302400000, 0),
	                 5 + 1); /* half a week: the later one */
	assert_int_equal(fw_nav_week_of(604800000LL * 5, 302400), 5);
	assert_int_equal(fw_nav_week_of(0, 604799), -1);
}

static void test_iono_utc(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 2);
	for (int round = 0; round < 100; round++) {
		icd_page pages[5] = {0};
		double expected[COUNT(iono)], expected_utc[COUNT(utc)];
		kept_records kept = {0};
		const bool qzss = round & 1;

		for (int i = 0; i < COUNT(iono); i++)
			expected[i] = write_field(pages, &iono[i], random_raw(&r, &iono[i]));
		for (int i = 0; i < COUNT(utc); i++)
			expected_utc[i] = write_field(pages, &utc[i], random_raw(&r, &utc[i]));
		write_head(&pages[4], 4, TOW);
		write_bits(&pages[4], W(3, 1), 2, qzss ? 3 : 1);
		write_bits(&pages[4], W(3, 3), 6, 56);
		fw_nav_init(&nav);
		const nav_block b = gps_block(qzss ? 4066 : 4017, qzss ? 182 : 29, TOW, &pages[4]);
		assert_int_equal(give(&nav, &b, &kept), FW_OK);
		assert_int_equal(kept.n, 2);
		for (int i = 0; i < COUNT(iono); i++)
			assert_true(column_is(last_of(&kept, FW_klobuchar), iono[i].column, expected[i]));
		for (int i = 0; i < COUNT(utc); i++)
			assert_true(column_is(last_of(&kept, FW_utc), utc[i].column, expected_utc[i]));
		assert_true(column_is(last_of(&kept, FW_utc), "message", (double)NAN));
	}
}

/* Other pages of subframe 4, and QZSS's data ID from a GPS satellite, are no such parameters. */
static void test_other_pages(void **state)
{
	kept_records kept = {0};

	(void)state;
	fw_nav_init(&nav);
	for (uint32_t id = 0; id < 256; id++) {
		icd_page page = {{0}};
		if (id == (1 << 6 | 56))
			continue;
		write_head(&page, 4, TOW);
		write_bits(&page, W(3, 1), 8, id);
		const nav_block b = gps_block(4017, 5, TOW, &page);
		assert_int_equal(give(&nav, &b, &kept), FW_OK);
	}
	assert_int_equal(kept.n, 0);
}

/* Each bit of each word, flipped alone, is seen by the parity. */
static void test_parity(void **state)
{
	fw_random r;
	icd_page pages[5] = {0};
	double expected[COUNT(eph)];
	kept_records kept = {0};

	(void)state;
	fw_random_init(&r, 3);
	random_ephemeris(&r, pages, expected);
	write_head(&pages[1], 1, TOW);
	fw_nav_init(&nav);
	for (int word = 0; word < 10; word++) {
		for (int bit = 0; bit < 30; bit++) {
			nav_block b = gps_block(4017, 7, TOW, &pages[1]);
			b.bytes[20 + 4 * word + bit / 8] ^= (uint8_t)(1 << bit % 8);
			assert_int_equal(give(&nav, &b, &kept), FW_ECHECKSUM);
		}
	}
	const nav_block good = gps_block(4017, 7, TOW, &pages[1]);
	assert_int_equal(give(&nav, &good, &kept), FW_OK);
}

/* The same data again says nothing; a new issue of data speaks once it is complete; so does health alone. */
static void test_when(void **state)
{
	const icd_field *health = field(eph, COUNT(eph), "health"), *iode3 = field(eph, COUNT(eph), "iode3");
	fw_random r;
	icd_page first[5] = {0}, second[5] = {0};
	double expected[COUNT(eph)];
	kept_records kept = {0};

	(void)state;
	fw_random_init(&r, 4);
	random_ephemeris(&r, first, expected);
	do
		random_ephemeris(&r, second, expected);
	while (read_bits(&first[2], W(3, 1), 8) == read_bits(&second[2], W(3, 1), 8));
	fw_nav_init(&nav);

	give_ephemeris(first, 4017, 9, TOW, &kept);
	give_ephemeris(first, 4017, 9, TOW + 30, &kept);
	assert_int_equal(kept.n, 1);
	give_ephemeris(first, 4017, 10, TOW + 30, &kept); /* another satellite */
	assert_int_equal(kept.n, 2);

	/* subframes 1 and 2 new, 3 still old: nothing */
	icd_page mixed[5] = {second[0], second[1], second[2], first[3], second[4]};
	give_ephemeris(mixed, 4017, 9, TOW + 60, &kept);
	assert_int_equal(kept.n, 2);
	give_ephemeris(second, 4017, 9, TOW + 90, &kept);
	assert_int_equal(kept.n, 3);
	assert_true(kept.list[2].record.head.tow_s == TOW + 90 + 18);

	write_field(second, health, 63 - (uint32_t)value_of(&kept.list[2], "health"));
	give_ephemeris(second, 4017, 9, TOW + 120, &kept);
	assert_int_equal(kept.n, 4);
	assert_true(kept.list[3].record.head.tow_s == TOW + 120 + 6);

	write_field(second, iode3, 1 + (uint32_t)value_of(&kept.list[2], "iode3"));
	give_ephemeris(second, 4017, 9, TOW + 150, &kept);
	assert_int_equal(kept.n, 4);
}

/* Subframes more than an hour apart are not joined, whatever their issue says. */
static void test_gap(void **state)
{
	fw_random r;
	icd_page pages[5] = {0};
	double expected[COUNT(eph)];
	kept_records kept = {0};

	(void)state;
	fw_random_init(&r, 5);
	random_ephemeris(&r, pages, expected);
	fw_nav_init(&nav);
	for (int s = 1; s <= 3; s++) {
		const int tow_s = TOW + (s == 3 ? 7200 : 0);
		write_head(&pages[s], s, tow_s);
		const nav_block b = gps_block(4017, 9, tow_s, &pages[s]);
		assert_int_equal(give(&nav, &b, &kept), FW_OK);
	}
	assert_int_equal(kept.n, 0);
	for (int s = 1; s <= 2; s++) {
		const nav_block b = gps_block(4017, 9, TOW + 7200 + 6 * s, &pages[s]);
		assert_int_equal(give(&nav, &b, &kept), FW_OK);
	}
	assert_int_equal(kept.n, 1);
}

/* The subframes 4 and 5 of a real log: parity and storage are as the decoder has them. */
static void test_real_parity(void **state)
{
	size_t n = 0;
	uint8_t *log = load_log("sbf/log_0000.sbf", &n);
	const uint8_t *b;
	kept_records kept = {0};
	const fw_sink sink = {keep, &kept};
	int pages = 0;

	(void)state;
	if (!log)
		skip();
	fw_nav_init(&nav);
	for (size_t at = 0, length; (b = next_block(log, n, &at, &length)) != NULL;) {
		if ((fw_load_u16(b + 4) & 0x1fff) == 4017) {
			assert_int_equal(fw_nav_block(&nav, b, length, &sink), FW_OK);
			pages++;
		}
	}
	assert_int_equal(pages, 24);
	free(log);
}

/* Real subframes of another receiver (u-blox), decoded by RTKLIB: RINEX 3.04 table A6. */
static void test_against_rtklib(void **state)
{
	static const char *const columns[31] = {
	    "af0_s",   "af1_sps",  "af2_sps2", "iode2",        "crs_m",          "deltan_radps", "m0_rad",
	    "cuc_rad", "ecc",      "cus_rad",  "sqrt_a_sqrtm", "toe_s",          "cic_rad",      "omega0_rad",
	    "cis_rad", "i0_rad",   "crc_m",    "omega_rad",    "omegadot_radps", "idot_radps",   "code_on_l2",
	    NULL,      "l2p_data", NULL,       "health",       "tgd_s",          "iodc",
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
		if (s.system != 0 || s.signal != 0)
			continue;
		for (int w = 1; w <= 10; w++)
			write_bits(&page, W(w, 1), 30, s.words[w - 1] & 0x3fffffff);
		const nav_block b = gps_block(4017, (uint8_t)s.sat, 6 * read_bits(&page, W(2, 1), 17), &page);
		assert_int_equal(give(&nav, &b, &kept), FW_OK);
	}
	assert_int_equal(compare_with_rinex(&kept, FW_eph_gps, columns, "iode2", 3, 0, (char *)rinex), 4);
	free(log);
	free(rinex);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_ephemeris),
	    cmocka_unit_test(test_week_of_toe),
	    cmocka_unit_test(test_iono_utc),
	    cmocka_unit_test(test_other_pages),
	    cmocka_unit_test(test_parity),
	    cmocka_unit_test(test_when),
	    cmocka_unit_test(test_gap),
	    cmocka_unit_test(test_real_parity),
	    cmocka_unit_test(test_against_rtklib),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
