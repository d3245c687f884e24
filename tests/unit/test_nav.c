/* The front of the navigation decoders: which blocks are taken, which are refused, and that no bytes can do
 * harm. What the messages say is tested in test_nav_gps.c, _galileo.c, _beidou.c, _glonass.c. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "nav_encode.h"

#define COUNT(a) (int)(sizeof(a) / sizeof *(a))

static const uint16_t numbers[] = {4017, 4022, 4023, 4026, 4047, 4066};

static fw_nav nav;

static void test_which_blocks(void **state)
{
	int read = 0;

	(void)state;
	for (int number = 0; number < 8192; number++)
		read += fw_nav_reads((uint16_t)number);
	assert_int_equal(read, COUNT(numbers));
	for (int i = 0; i < COUNT(numbers); i++)
		assert_true(fw_nav_reads(numbers[i]));
}

static void test_refused(void **state)
{
	icd_page page = {{0}};
	kept_records kept = {0};

	(void)state;
	write_bits(&page, 1, 8, 0x8b);
	write_bits(&page, 50, 3, 1);
	fw_nav_init(&nav);
	const nav_block good = gps_block(4017, 1, 212400, &page);
	assert_int_equal(give(&nav, &good, &kept), FW_OK);

	nav_block b = good;
	fw_store_u16(b.bytes + 4, 4017 | 5 << 13); /* any revision */
	assert_int_equal(give(&nav, &b, &kept), FW_OK);
	fw_store_u16(b.bytes + 4, 4018);
	assert_int_equal(give(&nav, &b, &kept), FW_EUNKNOWN);
	b = good;
	b.bytes[15] = 0; /* the receiver's check failed */
	assert_int_equal(give(&nav, &b, &kept), FW_ECHECKSUM);
	b = good;
	fw_store_u32(b.bytes + 8, UINT32_MAX); /* no time stamp */
	assert_int_equal(give(&nav, &b, &kept), FW_EFORMAT);
	b = good;
	fw_store_u16(b.bytes + 12, UINT16_MAX);
	assert_int_equal(give(&nav, &b, &kept), FW_EFORMAT);
	b = good;
	for (b.length = 8; b.length < good.length; b.length += 4)
		assert_int_equal(give(&nav, &b, &kept), FW_EFORMAT);
	assert_int_equal(kept.n, 0);
}

/* A block of one system with a satellite of another, or of none, is refused. */
static void test_satellites(void **state)
{
	static const int satellites[] = {37, 36, 36, 30, 63, 10}; /* by block, see numbers[] */
	icd_page page = {{0}};
	kept_records kept = {0};

	(void)state;
	fw_nav_init(&nav);
	for (int i = 0; i < COUNT(numbers); i++) {
		int taken = 0;
		for (int svid = 0; svid < 256; svid++) {
			const nav_block b = block_of_bits(numbers[i], (uint8_t)svid, 212400, &page, 10);
			taken += give(&nav, &b, &kept) != FW_EUNKNOWN;
		}
		assert_int_equal(taken, satellites[i]);
	}
}

/* A block of random bits whose own checks hold, of any satellite of the system. */
static nav_block random_block(fw_random *r)
{
	icd_page page;
	const double tow_s = (double)fw_random_below(r, 1008000) * 0.6;

	for (size_t i = 0; i < sizeof page.bit; i++)
		page.bit[i] = fw_random_u64(r) & 1;
	switch (fw_random_below(r, 6)) {
	case 0:
		write_bits(&page, 1, 8, 0x8b);
		return gps_block(4017, (uint8_t)(1 + fw_random_below(r, 37)), tow_s, &page);
	case 1:
		write_bits(&page, 1, 8, 0x8b);
		return gps_block(4066, (uint8_t)(181 + fw_random_below(r, 10)), tow_s, &page);
	case 2: return inav_block((uint8_t)(71 + fw_random_below(r, 36)), tow_s, &page);
	case 3: return fnav_block((uint8_t)(71 + fw_random_below(r, 36)), tow_s, &page);
	case 4:
		return bds_block(
		    (uint8_t)(r->s[0] & 1 ? 141 + fw_random_below(r, 40) : 223 + fw_random_below(r, 23)),
		    tow_s, &page, (uint32_t)fw_random_below(r, 8));
	default:
		return glo_block((uint8_t)(38 + fw_random_below(r, 31)), (uint8_t)fw_random_u64(r), tow_s,
		                 &page);
	}
}

/* Whatever pages say, values stay inside their columns' types and weeks (the sanitizers watch). */
static void test_random_pages(void **state)
{
	static kept_records kept;
	fw_random r;
	int records = 0;

	(void)state;
	fw_random_init(&r, 41);
	fw_nav_init(&nav);
	for (int i = 0; i < 50000; i++) {
		nav_block b = random_block(&r);
		fw_store_u16(b.bytes + 12, (uint16_t)(i % 3 == 0 ? 0 : i % 3 == 1 ? 2360 : 8191));
		kept.n = 0;
		const fw_status status = give(&nav, &b, &kept);
		assert_true(status == FW_OK || b.bytes[14] == 62);
		records += kept.n;
		for (int k = 0; k < kept.n; k++) {
			assert_true(kept.list[k].record.head.present & 1);
			assert_string_equal(kept.list[k].source, "raw");
		}
	}
	assert_true(records > 1000);
}

static void test_random_bytes(void **state)
{
	static kept_records kept;
	fw_random r;

	(void)state;
	fw_random_init(&r, 42);
	fw_nav_init(&nav);
	for (int i = 0; i < 50000; i++) {
		nav_block b = {.length = 8 + 4 * (size_t)fw_random_below(&r, 15)};
		for (size_t j = 0; j < b.length; j++)
			b.bytes[j] = (uint8_t)fw_random_u64(&r);
		fw_store_u16(b.bytes + 4, numbers[i % COUNT(numbers)]);
		if (b.length > 15 && i & 8)
			b.bytes[15] = 1;
		assert_true(give(&nav, &b, &kept) != FW_EINVAL);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_which_blocks), cmocka_unit_test(test_refused),
	    cmocka_unit_test(test_satellites),   cmocka_unit_test(test_random_pages),
	    cmocka_unit_test(test_random_bytes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
