/* Bit fields of navigation pages. Expected values by hand. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "formats/nav_bits.h"

static const uint8_t bytes[] = {0x8b, 0x5a, 0xff, 0x00, 0x12, 0x34, 0x56};

static void test_unsigned(void **state)
{
	(void)state;
	assert_int_equal(fw_bits_unsigned(bytes, 7, 0, 8), 0x8b);
	assert_int_equal(fw_bits_unsigned(bytes, 7, 4, 8), 0xb5);
	assert_int_equal(fw_bits_unsigned(bytes, 7, 1, 1), 0);
	assert_int_equal(fw_bits_unsigned(bytes, 7, 0, 32), 0x8b5aff00);
	assert_int_equal(fw_bits_unsigned(bytes, 7, 7, 32), 0xad7f8009); /* five bytes */
	assert_int_equal(fw_bits_unsigned(bytes, 7, 3, 0), 0);
}

static void test_end(void **state)
{
	(void)state;
	assert_int_equal(fw_bits_unsigned(bytes, 7, 52, 4), 6);
	assert_int_equal(fw_bits_unsigned(bytes, 7, 52, 8), 0x60); /* zeros behind the end */
	assert_int_equal(fw_bits_unsigned(bytes, 7, 5600, 32), 0);
	assert_int_equal(fw_bits_unsigned(bytes, 0, 0, 32), 0);
}

static void test_signs(void **state)
{
	(void)state;
	assert_int_equal(fw_bits_twos_complement(0x80, 8), -128);
	assert_int_equal(fw_bits_twos_complement(0x7f, 8), 127);
	assert_int_equal(fw_bits_twos_complement(1, 1), -1);
	assert_true(fw_bits_twos_complement(0x80000000, 32) == -INT64_C(2147483648));
	assert_true(fw_bits_twos_complement(0xffffffff, 32) == -1);
	assert_true(fw_bits_sign_magnitude(0x83, 8) == -3);
	assert_true(fw_bits_sign_magnitude(0x03, 8) == 3);
	assert_true(fw_bits_sign_magnitude(0xffffffff, 32) == -2147483647.0);
	assert_true(signbit(fw_bits_sign_magnitude(0x10, 5))); /* -0 */
}

static void test_append_and_clear(void **state)
{
	uint8_t page[3] = {0};
	size_t used = 0;

	(void)state;
	fw_bits_append(page, 3, &used, 5, 3);
	fw_bits_append(page, 3, &used, 0xabc, 12);
	assert_int_equal(used, 15);
	assert_memory_equal(page, ((uint8_t[]){0xb5, 0x78, 0}), 3);
	fw_bits_append(page, 3, &used, 0xffff, 16); /* only nine bits have room */
	assert_memory_equal(page, ((uint8_t[]){0xb5, 0x79, 0xff}), 3);
	fw_bits_clear(page, 3, 4, 6);
	assert_memory_equal(page, ((uint8_t[]){0xb0, 0x39, 0xff}), 3);
	fw_bits_clear(page, 3, 20, 1000);
	assert_memory_equal(page, ((uint8_t[]){0xb0, 0x39, 0xf0}), 3);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_unsigned),
	    cmocka_unit_test(test_end),
	    cmocka_unit_test(test_signs),
	    cmocka_unit_test(test_append_and_clear),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
