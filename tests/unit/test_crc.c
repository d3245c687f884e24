/* The references are bitwise: the definitions, one bit at a time. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "../sbf_stream.h"
#include "formats/crc.h"

static uint8_t noise[70000];

static int make_noise(void **state)
{
	uint64_t seed = 16;

	(void)state;
	fill_random(&seed, noise, sizeof(noise));
	return 0;
}

/* Check value of CRC-16/XMODEM in the catalogue of parametrised CRC algorithms. */
static void check_value(void **state)
{
	(void)state;
	assert_int_equal(fw_crc16("123456789", 9), 0x31c3);
	assert_int_equal(fw_crc16_portable(0, "123456789", 9), 0x31c3);
	assert_int_equal(bitwise_crc16((const uint8_t *)"123456789", 9), 0x31c3);
	assert_int_equal(fw_crc16("", 0), 0);
}

/* Every length up to 600 at every alignment, and some long ones. */
static void equals_the_definition(void **state)
{
	static const size_t longer[] = {1023, 4096, 65528, 65535, 65536, 65537, 69999};

	(void)state;
	for (size_t n = 0; n <= 600; n++) {
		const uint8_t *p = noise + n % 17;
		const uint16_t expected = bitwise_crc16(p, n);

		assert_int_equal(fw_crc16(p, n), expected);
		assert_int_equal(fw_crc16_portable(0, p, n), expected);
	}
	for (size_t i = 0; i < sizeof(longer) / sizeof(longer[0]); i++) {
		const uint16_t expected = bitwise_crc16(noise, longer[i]);

		assert_int_equal(fw_crc16(noise, longer[i]), expected);
		assert_int_equal(fw_crc16_portable(0, noise, longer[i]), expected);
	}
}

static void continues(void **state)
{
	(void)state;
	for (size_t cut = 0; cut <= 300; cut++) {
		const uint16_t first = bitwise_crc16(noise, cut), all = bitwise_crc16(noise, 300);

		assert_int_equal(fw_crc16_update(first, noise + cut, 300 - cut), all);
		assert_int_equal(fw_crc16_portable(first, noise + cut, 300 - cut), all);
	}
	assert_int_equal(fw_crc16_update(bitwise_crc16(noise, 9), noise + 9, 69000),
	                 bitwise_crc16(noise, 69009));
}

static void range_from_running_crcs(void **state)
{
	static uint16_t running[sizeof(noise) + 1];
	uint64_t seed = 5;

	(void)state;
	fw_crc16_prefix(0, noise, sizeof(noise), running);
	assert_int_equal(running[0], 0);
	assert_int_equal(running[1000], bitwise_crc16(noise, 1000));
	for (int i = 0; i < 2000; i++) {
		const size_t n = i < 1000 ? below(&seed, 300) : below(&seed, 65536);
		const size_t from = below(&seed, sizeof(noise) - n);

		assert_int_equal(fw_crc16_range(running[from], running[from + n], n),
		                 fw_crc16(noise + from, n));
	}
}

static uint32_t bitwise_crc24q(const uint8_t *bytes, size_t first, size_t n)
{
	uint32_t crc = 0;

	for (size_t bit = first; bit < first + n; bit++) {
		crc = crc << 1 ^ (uint32_t)(bytes[bit / 8] >> (7 - bit % 8) & 1) << 24;
		if (crc & 0x1000000)
			crc ^= 0x1864cfb;
	}
	return crc;
}

static void crc24q_equals_the_definition(void **state)
{
	(void)state;
	for (size_t first = 0; first < 20; first++)
		for (size_t n = 0; n < 270; n++)
			assert_int_equal(fw_crc24q_bits(noise, first, n), bitwise_crc24q(noise, first, n));
}

/* An RTCM 3 message 1005, the example of the standard (RTCM 10403, message type 1005): its last three
 * bytes are the CRC-24Q of the others. And whole with its CRC it leaves nothing. */
static void crc24q_of_an_rtcm_message(void **state)
{
	static const uint8_t message[] = {0xd3, 0x00, 0x13, 0x3e, 0xd7, 0xd3, 0x02, 0x02, 0x98,
	                                  0x0e, 0xde, 0xef, 0x34, 0xb4, 0xbd, 0x62, 0xac, 0x09,
	                                  0x41, 0x98, 0x6f, 0x33, 0x36, 0x0b, 0x98};

	(void)state;
	assert_int_equal(fw_crc24q_bits(message, 0, 8 * 22), 0x360b98);
	assert_int_equal(fw_crc24q_bits(message, 0, 8 * 25), 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(check_value),
	    cmocka_unit_test(equals_the_definition),
	    cmocka_unit_test(continues),
	    cmocka_unit_test(range_from_running_crcs),
	    cmocka_unit_test(crc24q_equals_the_definition),
	    cmocka_unit_test(crc24q_of_an_rtcm_message),
	};

	return cmocka_run_group_tests_name("crc", tests, make_noise, NULL);
}
