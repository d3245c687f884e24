/* Exact decoding and encoding. The blocks in hexadecimal are from a public log of a mosaic-X5 receiver, their values
 * those that pysbf2 and the fact sheet of the format give. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdbool.h>
#include <string.h>

#include "../sbf_files.h"
#include "base/random.h"
#include "formats/sbf_codec.h"

static fw_sbf_values values;
static uint8_t bytes[FW_SBF_MAX_LENGTH];

static size_t from_hex(const char *hex, uint8_t *out)
{
	size_t n = strlen(hex) / 2;
	for (size_t i = 0; i < n; i++) {
		const char pair[3] = {hex[2 * i], hex[2 * i + 1], '\0'};
		out[i] = (uint8_t)strtoul(pair, NULL, 16);
	}
	return n;
}

/* ReceiverTime: every field a different small number. */
static void fields_come_in_the_order_of_the_wire(void **state)
{
	(void)state;
	const int64_t expected[] = {25, 5, 23, 14, 11, 0, 18, 7, 0, 0}; /* the last two are padding */
	uint8_t block[64];
	from_hex("2440bd131a171800702fcb1c3f091905170e0b0012070000", block);
	assert_int_equal(fw_sbf_decode(block, &values), FW_OK);
	assert_string_equal(values.schema->name, "ReceiverTime");
	assert_int_equal(values.revision, 0);
	assert_int_equal(values.length, 24);
	assert_int_equal(values.tow_ms, 483078000);
	assert_int_equal(values.week, 2367);
	assert_int_equal(values.n, 10);
	assert_memory_equal(values.values, expected, sizeof expected);
}

/* DOP: scaled integers and floats; HPL 3.88915753 is 0x4078e7f5. */
static void floats_are_bit_patterns(void **state)
{
	(void)state;
	const int64_t expected[] = {37, 0, 79, 40, 44, 66, 0x4078e7f5, 0x40b596fc};
	uint8_t block[64];
	from_hex("244057f9a10f2000e052c91c3f0925004f0028002c004200f5e77840fc96b540", block);
	assert_int_equal(fw_sbf_decode(block, &values), FW_OK);
	assert_int_equal(values.n, 8);
	assert_memory_equal(values.values, expected, sizeof expected);
}

typedef struct {
	size_t known, unknown;
} counts;

static void check_block(const uint8_t *block, size_t length, void *context)
{
	counts *c = context;
	fw_status status = fw_sbf_decode(block, &values);
	if (status == FW_EUNKNOWN) {
		assert_null(fw_sbf_schema_find(fw_load_u16(block + 4) & 0x1FFF));
		c->unknown++;
		return;
	}
	assert_int_equal(status, FW_OK);
	memset(bytes, 0xA5, length);
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_OK);
	assert_memory_equal(bytes, block, length);
	c->known++;
}

static void real_blocks_come_back_identical(void **state)
{
	(void)state;
	counts c = {0, 0};
	if (sbf_each_real_block(check_block, &c) == 0) {
		print_message("no real logs: skipped\n");
		skip();
	}
	assert_true(c.known > 1000);
}

/* A block cut short inside its fields, as an old revision would be, and one with bytes behind the known fields. */
static void missing_fields_and_tails_survive(void **state)
{
	(void)state;
	const fw_sbf_schema *dop = fw_sbf_schema_find(4001);
	uint8_t block[64];
	for (uint16_t length = 16; length <= 48; length = (uint16_t)(length + 4)) {
		for (int i = FW_SBF_BODY; i < length; i++)
			block[i] = (uint8_t)(0xF0 + i);
		fw_sbf_seal(block, 4001, 5, length, 1000, 2000);
		assert_int_equal(fw_sbf_decode(block, &values), FW_OK);
		assert_ptr_equal(values.schema, dop);
		/* 1, 1, 2, 2, 2, 2, 4, 4 bytes; what does not make a field comes as bytes */
		const uint32_t expected[] = {2, 4, 6, 7, 8, 12, 16, 20, 24};
		assert_int_equal(values.n, expected[(length - 16) / 4]);
		assert_int_equal(fw_sbf_encode(&values, bytes), FW_OK);
		assert_memory_equal(bytes, block, length);
	}
}

static void contradictions_are_refused(void **state)
{
	(void)state;
	uint8_t block[128] = {0};
	fw_sbf_seal(block, 4028, 0, 68, 0, 0); /* BaseVectorGeod: 16 bytes and one vector of 52 */
	block[14] = 1, block[15] = 52;
	assert_int_equal(fw_sbf_decode(block, &values), FW_OK);
	assert_int_equal(values.n, 2 + 15);
	block[14] = 2;
	assert_int_equal(fw_sbf_decode(block, &values), FW_EFORMAT);
	block[14] = 1, block[15] = 53;
	assert_int_equal(fw_sbf_decode(block, &values), FW_EFORMAT);
	block[15] = 0;
	assert_int_equal(fw_sbf_decode(block, &values), FW_EFORMAT);
	block[14] = 0;
	assert_int_equal(fw_sbf_decode(block, &values), FW_OK);
	block[6] = 70;
	assert_int_equal(fw_sbf_decode(block, &values), FW_EFORMAT);
	block[6] = 12;
	assert_int_equal(fw_sbf_decode(block, &values), FW_EFORMAT);
	fw_sbf_seal(block, 4013, 0, 16, 0, 0);
	assert_int_equal(fw_sbf_decode(block, &values), FW_EUNKNOWN);
}

static void encode_refuses_what_does_not_fit(void **state)
{
	(void)state;
	values =
	    (fw_sbf_values){.schema = fw_sbf_schema_find(5925), .length = 16, .n = 2, .values = {121, 4}};
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_OK);
	values.n = 1;
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_EINVAL);
	values.n = 3;
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_EINVAL);
	values.n = 2;
	values.values[0] = 256;
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_EINVAL);
	values.values[0] = -1;
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_EINVAL);
	values.values[0] = 255;
	values.revision = 8;
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_EINVAL);
	values.revision = 7;
	values.length = 18;
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_EINVAL);
	values.length = 16;
	assert_int_equal(fw_sbf_encode(&values, bytes), FW_OK);
}

/* Noise under every header, in a buffer that ends where the block ends: refused, or decoded and encoded again. */
static void noise_does_no_harm(void **state)
{
	(void)state;
	fw_random random;
	fw_random_init(&random, 4027);
	unsigned accepted = 0;
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		for (int k = 0; k < 300; k++) {
			uint16_t length =
			    (uint16_t)(16 + 4 * fw_random_below(&random, k % 10 == 0 ? 2000 : 50));
			uint8_t *block = malloc(length);
			for (unsigned at = 0; at < length; at++)
				block[at] = (uint8_t)fw_random_u64(&random);
			fw_sbf_seal(block, fw_sbf_schemas[i].id, (uint8_t)(k % 8), length, 1, 2);
			if (fw_sbf_decode(block, &values) == FW_OK) {
				assert_int_equal(fw_sbf_encode(&values, bytes), FW_OK);
				assert_memory_equal(bytes, block, length);
				accepted++;
			}
			free(block);
		}
	}
	assert_true(accepted > 5000);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(fields_come_in_the_order_of_the_wire),
	    cmocka_unit_test(floats_are_bit_patterns),
	    cmocka_unit_test(real_blocks_come_back_identical),
	    cmocka_unit_test(missing_fields_and_tails_survive),
	    cmocka_unit_test(contradictions_are_refused),
	    cmocka_unit_test(encode_refuses_what_does_not_fit),
	    cmocka_unit_test(noise_does_no_harm),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
