/* GLONASS: random parameters in strings as the ICD (L1, L2, edition 5.1) draws them in its figure 4.3, with
 * the units of its tables 4.5 and 4.9. Bits count from the idle bit: ICD bit n is 86 - n here. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "nav_encode.h"
#include "nav_logs.h"

#define COUNT(a)   (int)(sizeof(a) / sizeof *(a))
#define B(icd_bit) (86 - (icd_bit))

enum {
	/* Frame begins on a Tuesday at 11:02:00 UTC + 18 s: 14:02:00 in Moscow, the last of its superframe.
	 */
	TOW = 2 * 86400 + 11 * 3600 + 2 * 60 + 18,
	R01 = 38,
	CHANNEL = 9, /* k = 1 */
};

static const icd_field eph[] = {
    {"vx_mps", 'm', 0x1p-20, 1000, {{1, B(64), 24}}},
    {"ax_mps2", 'm', 0x1p-30, 1000, {{1, B(40), 5}}},
    {"x_m", 'm', 0x1p-11, 1000, {{1, B(35), 27}}},
    {"health_b", 'u', 1, 0, {{2, B(80), 3}}},
    {"p2", 'u', 1, 0, {{2, B(77), 1}}},
    {"tb_min", 'u', 15, 0, {{2, B(76), 7}}},
    {"vy_mps", 'm', 0x1p-20, 1000, {{2, B(64), 24}}},
    {"ay_mps2", 'm', 0x1p-30, 1000, {{2, B(40), 5}}},
    {"y_m", 'm', 0x1p-11, 1000, {{2, B(35), 27}}},
    {"gamma", 'm', 0x1p-40, 0, {{3, B(79), 11}}},
    {"p", 'u', 1, 0, {{3, B(67), 2}}},
    {"l", 'u', 1, 0, {{3, B(65), 1}}},
    {"vz_mps", 'm', 0x1p-20, 1000, {{3, B(64), 24}}},
    {"az_mps2", 'm', 0x1p-30, 1000, {{3, B(40), 5}}},
    {"z_m", 'm', 0x1p-11, 1000, {{3, B(35), 27}}},
    {"tau_s", 'm', 0x1p-30, 0, {{4, B(80), 22}}},
    {"dtau_s", 'm', 0x1p-30, 0, {{4, B(58), 5}}},
    {"age_days", 'u', 1, 0, {{4, B(53), 5}}},
    {"p4", 'u', 1, 0, {{4, B(34), 1}}},
    {"nt_day", 'u', 1, 0, {{4, B(26), 11}}},
    {"m", 'u', 1, 0, {{4, B(10), 2}}},
};

static const icd_field time5[] = {
    {"day", 'u', 1, 0, {{5, B(80), 11}}},        {"tau_c_s", 'm', 0x1p-31, 0, {{5, B(69), 32}}},
    {"n4", 'u', 1, 0, {{5, B(36), 5}}},          {"tau_gps_s", 'm', 0x1p-30, 0, {{5, B(31), 22}}},
    {"b1_s", 'm', 0x1p-10, 0, {{6, B(80), 11}}}, /* page 6: string 14 */
    {"b2_s", 'm', 0x1p-16, 0, {{6, B(69), 10}}}, {"kp", 'u', 1, 0, {{6, B(59), 2}}},
};

static fw_nav nav;

/* A string of the frame that begins at tow_s. */
static fw_status give_string(uint8_t svid, int tow_s, const icd_page *page, uint32_t number,
                             kept_records *kept)
{
	icd_page whole = *page;
	write_bits(&whole, B(84), 4, number);
	const nav_block b = glo_block(svid, CHANNEL, tow_s + 2 * (int)number, &whole);
	return give(&nav, &b, kept);
}

static void give_frame(uint8_t svid, int tow_s, const icd_page *pages, kept_records *kept)
{
	for (uint32_t s = 1; s <= 4; s++)
		assert_int_equal(give_string(svid, tow_s, &pages[s], s, kept), FW_OK);
}

static void random_pages(fw_random *r, icd_page *pages, double *expected)
{
	for (int i = 0; i < COUNT(eph); i++) {
		uint32_t raw = random_raw(r, &eph[i]);
		if (strcmp(eph[i].column, "tb_min") == 0)
			raw %= 96;
		expected[i] = write_field(pages, &eph[i], raw);
	}
}

static void test_ephemeris(void **state)
{
	static const double accuracy_m[] = {1,  2,  2.5, 4,  5,   7,   10,  12,
	                                    14, 16, 32,  64, 128, 256, 512, (double)NAN};
	static const double p1_min[] = {0, 30, 45, 60};
	fw_random r;

	(void)state;
	fw_random_init(&r, 31);
	for (int round = 0; round < 300; round++) {
		icd_page pages[5] = {0};
		double expected[COUNT(eph)];
		kept_records kept = {0};
		const uint32_t p1 = (uint32_t)round % 4, f_t = (uint32_t)round % 16;

		random_pages(&r, pages, expected);
		write_bits(&pages[1], B(78), 2, p1);
		write_bits(&pages[4], B(33), 4, f_t);
		fw_nav_init(&nav);
		give_frame(R01 + (uint8_t)(round % 24), TOW, pages, &kept);
		assert_int_equal(kept.n, 1);
		const kept_record *k = &kept.list[0];
		assert_true(k->record.head.tow_s == TOW + 8);
		for (int i = 0; i < COUNT(eph); i++)
			assert_true(column_is(k, eph[i].column, expected[i]));
		assert_true(column_is(k, "p1_min", p1_min[p1]));
		assert_true(column_is(k, "accuracy_m", accuracy_m[f_t]));
		assert_true(column_is(k, "glonass_channel", 1));
		assert_true(column_is(k, "health_c", (double)NAN));
		/* tb in the Moscow day that puts it within half a day of 14:02:08 */
		const double tb_s = value_of(k, "tb_min") * 60;
		double toe = 2 * 86400 - 10800 + 18 + tb_s;
		if (tb_s < 2 * 3600 + 2 * 60 + 8)
			toe += 86400;
		assert_true(column_is(k, "toe_s", toe));
		assert_true(column_is(k, "toe_week", 312));
	}
}

/* Around the end of the week: Saturday night, tb on Moscow's Sunday, which begins at 21:00 UTC. */
static void test_toe_across_the_week(void **state)
{
	static const struct {
		int tow_s, tb_quarters;
		double toe_s, toe_week;
	} cases[] = {
	    {604800 - 30 + 18 - 30, 12, 18, 313},                /* 03:00 Moscow: 00:00 UTC on Sunday */
	    {604800 - 30 + 18 - 30, 11, 604800 - 900 + 18, 312}, /* a quarter of an hour earlier */
	    {18, 11, 604800 - 900 + 18, 311},                    /* seen from behind it, in week 312 */
	};

	(void)state;
	for (int i = 0; i < COUNT(cases); i++) {
		icd_page pages[5] = {0};
		kept_records kept = {0};
		write_bits(&pages[2], B(76), 7, (uint32_t)cases[i].tb_quarters);
		fw_nav_init(&nav);
		give_frame(R01, cases[i].tow_s, pages, &kept);
		assert_int_equal(kept.n, 1);
		assert_true(column_is(&kept.list[0], "toe_s", cases[i].toe_s));
		assert_true(column_is(&kept.list[0], "toe_week", cases[i].toe_week));
	}
}

/* Strings of two frames are not joined; t_k going on says nothing; strings on both bands are the same. */
static void test_when(void **state)
{
	fw_random r;
	icd_page old[5] = {0}, new[5] = {0};
	double expected[COUNT(eph)];
	kept_records kept = {0};

	(void)state;
	fw_random_init(&r, 32);
	random_pages(&r, old, expected);
	random_pages(&r, new, expected);
	fw_nav_init(&nav);
	give_frame(R01, TOW, old, &kept);
	give_frame(R01, TOW, old, &kept);
	write_bits(&old[1], B(76), 12, 0xabc);
	give_frame(R01, TOW + 30, old, &kept);
	assert_int_equal(kept.n, 1);
	assert_int_equal(give_string(R01, TOW + 60, &new[1], 1, &kept), FW_OK);
	assert_int_equal(give_string(R01, TOW + 60, &new[2], 2, &kept), FW_OK);
	assert_int_equal(give_string(R01, TOW + 90, &new[3], 3, &kept), FW_OK);
	assert_int_equal(give_string(R01, TOW + 90, &new[4], 4, &kept), FW_OK);
	assert_int_equal(kept.n, 1);
	give_frame(R01, TOW + 120, new, &kept);
	assert_int_equal(kept.n, 2);
	/* a satellite without a known slot has no name */
	assert_int_equal(give_string(62, TOW, &new[1], 1, &kept), FW_EUNKNOWN);
}

static void test_time(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 33);
	for (int round = 0; round < 100; round++) {
		icd_page pages[7] = {0};
		double expected[COUNT(time5)];
		kept_records kept = {0};

		for (int i = 0; i < COUNT(time5); i++)
			expected[i] = write_field(pages, &time5[i], random_raw(&r, &time5[i]));
		fw_nav_init(&nav);
		/* string 14 of the frame before is almanac, this frame's has KP, B1 and B2 */
		assert_int_equal(give_string(R01, TOW - 30, &pages[6], 14, &kept), FW_OK);
		assert_int_equal(give_string(R01, TOW, &pages[5], 5, &kept), FW_OK);
		assert_int_equal(kept.n, 0);
		assert_int_equal(give_string(R01, TOW, &pages[6], 14, &kept), FW_OK);
		assert_int_equal(kept.n, 1);
		for (int i = 0; i < COUNT(time5); i++)
			assert_true(column_is(&kept.list[0], time5[i].column, expected[i]));
		assert_true(column_is(&kept.list[0], "glonass_channel", 1));
		assert_true(kept.list[0].record.head.tow_s == TOW + 28);
		assert_int_equal(give_string(R01, TOW + 30, &pages[5], 5, &kept), FW_OK);
		assert_int_equal(kept.n, 1);
	}
}

/* String 14 has time parameters in one frame of five and almanac in the others; so have strings 6 to 12
 * always. */
static void test_frames(void **state)
{
	(void)state;
	for (int frame = 0; frame < 15; frame++) {
		for (uint32_t string = 1; string <= 15; string++) {
			icd_page pages[5] = {0}, empty = {{0}}, other = {{0}};
			kept_records kept = {0};
			const bool last = frame % 5 == 0, even = string % 2 == 0;

			write_bits(&other, B(80), 1, 1); /* as almanac: C = 1 of slot 4 */
			write_bits(&other, B(77), 5, 4);
			fw_nav_init(&nav);
			give_frame(R01 + 3, TOW + 30 * frame, pages, &kept);
			assert_int_equal(give_string(R01, TOW + 30 * frame, &empty, 5, &kept), FW_OK);
			assert_int_equal(give_string(R01, TOW + 30 * frame, &other, string, &kept), FW_OK);
			const bool time = string == 14 && last, almanac = string >= 6 && even && !time;
			assert_int_equal(count_of(&kept, FW_glo_time), time ? 1 : 0);
			assert_int_equal(count_of(&kept, FW_eph_glo), almanac ? 2 : 1);
		}
	}
}

/* Flag C of slot 3 comes from slot 1's almanac, and is news. */
static void test_almanac_health(void **state)
{
	fw_random r;
	icd_page pages[5] = {0}, almanac = {{0}};
	double expected[COUNT(eph)];
	kept_records kept = {0};

	(void)state;
	fw_random_init(&r, 34);
	random_pages(&r, pages, expected);
	fw_nav_init(&nav);
	give_frame(R01 + 2, TOW, pages, &kept);
	write_bits(&almanac, B(80), 1, 1);
	write_bits(&almanac, B(77), 5, 3);
	for (int i = 0; i < 2; i++)
		assert_int_equal(give_string(R01, TOW, &almanac, 10, &kept), FW_OK);
	assert_int_equal(kept.n, 2);
	assert_string_equal(kept.list[1].sat, "R03");
	assert_true(column_is(&kept.list[1], "health_c", 1));
	for (int i = 0; i < COUNT(eph); i++)
		assert_true(column_is(&kept.list[1], eph[i].column, expected[i]));
	for (uint32_t slot = 0; slot < 32; slot++) { /* whatever slot is named */
		write_bits(&almanac, B(77), 5, slot);
		assert_int_equal(give_string(R01, TOW, &almanac, 6, &kept), FW_OK);
	}
	assert_int_equal(kept.n, 2);

	/* two hours later slot 3 is out of sight: its flag says nothing about an ephemeris that is still good
	 */
	write_bits(&almanac, B(80), 1, 0);
	write_bits(&almanac, B(77), 5, 3);
	assert_int_equal(give_string(R01, TOW + 7200, &almanac, 10, &kept), FW_OK);
	assert_int_equal(kept.n, 2);
	give_frame(R01 + 2, TOW + 7230, pages, &kept); /* and is used as soon as the satellite is back */
	assert_int_equal(kept.n, 3);
	assert_true(column_is(&kept.list[2], "health_c", 0));
}

/* The Hamming code sees each single bit and each pair of bits. */
static void test_hamming(void **state)
{
	fw_random r;
	icd_page pages[5] = {0};
	double expected[COUNT(eph)];
	kept_records kept = {0};

	(void)state;
	fw_random_init(&r, 35);
	random_pages(&r, pages, expected);
	fw_nav_init(&nav);
	write_bits(&pages[3], B(84), 4, 3);
	const nav_block good = glo_block(R01, CHANNEL, TOW, &pages[3]);
	assert_int_equal(give(&nav, &good, &kept), FW_OK);
	for (int a = 0; a < 85; a++) {
		for (int b = a; b < 85; b++) {
			nav_block bad = good;
			bad.bytes[20 + a / 32 * 4 + 3 - a % 32 / 8] ^= (uint8_t)(0x80 >> a % 8);
			if (b > a)
				bad.bytes[20 + b / 32 * 4 + 3 - b % 32 / 8] ^= (uint8_t)(0x80 >> b % 8);
			assert_int_equal(give(&nav, &bad, &kept), FW_ECHECKSUM);
		}
	}
}

/* The real strings of a satellite, from a mask of string numbers. */
static int give_real_strings(uint8_t svid, unsigned strings, const uint8_t *log, size_t n, kept_records *kept)
{
	const fw_sink sink = {keep, kept};
	const uint8_t *b;
	int given = 0;

	for (size_t at = 0, length; (b = next_block(log, n, &at, &length)) != NULL;) {
		const unsigned string = fw_load_u32(b + 20) >> 27 & 15;
		if ((fw_load_u16(b + 4) & 0x1fff) != 4026 || b[14] != svid || !(strings >> string & 1))
			continue;
		assert_int_equal(fw_nav_block(&nav, b, length, &sink), FW_OK);
		given++;
	}
	return given;
}

/* Writes the fields of one page from the values of a decoded block. */
static void encode_page(const uint8_t *block, const block_field *values, int n_values,
                        const icd_field *fields, int n_fields, int page, icd_page *pages)
{
	for (int f = 0; f < n_fields; f++)
		for (int v = 0; v < n_values; v++)
			if (fields[f].part[0][0] == page && strcmp(fields[f].column, values[v].column) == 0)
				write_field(pages, &fields[f],
				            raw_of(&fields[f], block_value(block, &values[v])));
}

/* A real log of 12 s has strings 2 to 7 of a superframe's last frame. String 1 and string 14 are made from
 * the receiver's decoded blocks; what comes out of real and made strings together must be those blocks.
 * Fields: SBF reference guide, GLONav 4004, GLOTime 4036. C comes from the almanac of other frames. */
static void test_against_receiver(void **state)
{
	static const block_field glonav[] = {
	    {"x_m", 'd', 16, 1000, 0},
	    {"y_m", 'd', 24, 1000, 0},
	    {"z_m", 'd', 32, 1000, 0},
	    {"vx_mps", 'f', 40, 1000, 0},
	    {"vy_mps", 'f', 44, 1000, 0},
	    {"vz_mps", 'f', 48, 1000, 0},
	    {"ax_mps2", 'f', 52, 1000, 0},
	    {"ay_mps2", 'f', 56, 1000, 0},
	    {"az_mps2", 'f', 60, 1000, 0},
	    {"gamma", 'f', 64, 0, 0},
	    {"tau_s", 'f', 68, 0, 0},
	    {"dtau_s", 'f', 72, 0, 0},
	    {"toe_s", 'i', 76, 0, 0},
	    {"toe_week", 'h', 80, 0, 0},
	    {"p1_min", 'b', 82, 0, 0},
	    {"p2", 'b', 83, 0, 0},
	    {"age_days", 'b', 84, 0, 0},
	    {"health_b", 'b', 85, 0, 0},
	    {"tb_min", 'h', 86, 0, 0},
	    {"m", 'b', 88, 0, 0},
	    {"p", 'b', 89, 0, 0},
	    {"l", 'b', 90, 0, 0},
	    {"p4", 'b', 91, 0, 0},
	    {"nt_day", 'h', 92, 0, 0},
	    {"accuracy_m", 'h', 94, 0.01, 0},
	};
	static const block_field glotime[] = {
	    {"n4", 'b', 16, 0, 0},        {"kp", 'b', 17, 0, 0},      {"day", 'h', 18, 0, 0},
	    {"tau_gps_s", 'f', 20, 0, 0}, {"tau_c_s", 'd', 24, 0, 0}, {"b1_s", 'f', 32, 0, 0},
	    {"b2_s", 'f', 36, 0, 0},
	};
	size_t n = 0;
	uint8_t *log = load_log("sbf/log_0000.sbf", &n);
	const uint8_t *b;
	int satellites = 0, times = 0;

	(void)state;
	if (!log)
		skip();
	for (size_t at = 0, length; (b = next_block(log, n, &at, &length)) != NULL;) {
		const uint16_t number = fw_load_u16(b + 4) & 0x1fff;
		icd_page pages[7] = {0};
		kept_records kept = {0};
		fw_nav_init(&nav);
		if (number == 4004) {
			static const uint32_t p1_code[] = {0, 0, 1, 2, 3}; /* 30, 45, 60 min */
			encode_page(b, glonav, COUNT(glonav), eph, COUNT(eph), 1, pages);
			write_bits(&pages[1], B(78), 2, p1_code[b[82] / 15]);
			assert_int_equal(give_string(b[14], 212538, &pages[1], 1, &kept), FW_OK);
			if (give_real_strings(b[14], 1 << 2 | 1 << 3 | 1 << 4, log, n, &kept) == 0)
				continue;
			const kept_record *k = last_of(&kept, FW_eph_glo);
			assert_non_null(k);
			for (int f = 0; f < COUNT(glonav); f++)
				assert_true(column_is(k, glonav[f].column, block_value(b, &glonav[f])));
			assert_true(column_is(k, "glonass_channel", b[15] - 8));
			satellites++;
		} else if (number == 4036) {
			encode_page(b, glotime, COUNT(glotime), time5, COUNT(time5), 6, pages);
			assert_int_equal(give_string(b[14], 212538, &pages[6], 14, &kept), FW_OK);
			if (give_real_strings(b[14], 1 << 5, log, n, &kept) == 0)
				continue;
			for (int f = 0; f < COUNT(glotime); f++)
				assert_true(column_is(last_of(&kept, FW_glo_time), glotime[f].column,
				                      block_value(b, &glotime[f])));
			times++;
		}
	}
	assert_int_equal(satellites, 9);
	assert_int_equal(times, 1);
	free(log);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_ephemeris), cmocka_unit_test(test_toe_across_the_week),
	    cmocka_unit_test(test_when),      cmocka_unit_test(test_time),
	    cmocka_unit_test(test_frames),    cmocka_unit_test(test_almanac_health),
	    cmocka_unit_test(test_hamming),   cmocka_unit_test(test_against_receiver),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
