/* Foreign bytes in front of each block of a log, and damage to single blocks, through framer and decoder: all records
 * of the blocks that were not touched come out, as they were. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../record_sum.h"
#include "../sbf_stream.h"

static struct stream logged; /* the real log, or a made one where that is absent */
static record_sum undisturbed;

static int make_streams(void **state)
{
	fw_sbf_stats stats;

	(void)state;
	if (!load_log(&logged, "log_0000.sbf"))
		logged = make_stream(2, 748);
	undisturbed = sum_records(logged.bytes, logged.size, &stats);
	return 0;
}

static int free_streams(void **state)
{
	(void)state;
	free_stream(&logged);
	return 0;
}

static void check_inserted(size_t block, const void *bytes, size_t n)
{
	uint8_t *copy = malloc(logged.size + n);
	const size_t at = logged.start[block];
	fw_sbf_stats stats;
	record_sum got;

	assert_non_null(copy);
	memcpy(copy, logged.bytes, at);
	memcpy(copy + at, bytes, n);
	memcpy(copy + at + n, logged.bytes + at, logged.size - at);
	got = sum_records(copy, logged.size + n, &stats);
	free(copy);
	assert_int_equal(stats.blocks, logged.blocks);
	assert_int_equal(stats.bytes_skipped, n);
	assert_int_equal(got.records, undisturbed.records);
	assert_int_equal(got.sum, undisturbed.sum);
}

static void false_headers(void **state)
{
	static const uint16_t lengths[] = {0, 4, 6, 8192, 65532, 65535};

	(void)state;
	for (size_t i = 0; i < logged.blocks; i++)
		for (size_t k = 0; k < sizeof(lengths) / sizeof(lengths[0]); k++) {
			uint8_t header[8] = {'$', '@', 0x12, 0x34, 0xab, 0x0f}; /* PVTGeodetic */

			put_u2(header + 6, lengths[k]);
			check_inserted(i, header, sizeof(header));
		}
}

/* 1 to 64 bytes in turn; every length in front of every block is test_sbf_frame_campaign.c's. */
static void noise(void **state)
{
	uint64_t seed = 1;
	uint8_t bytes[64];

	(void)state;
	for (size_t i = 0; i < logged.blocks; i++) {
		fill_random(&seed, bytes, sizeof(bytes));
		check_inserted(i, bytes, 1 + i % sizeof(bytes));
	}
}

static void zeros_and_sentences(void **state)
{
	static const char sentence[] =
	    "$GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,*76\r\n";
	static const uint8_t zeros[1000];

	(void)state;
	for (size_t i = 0; i < logged.blocks; i++) {
		check_inserted(i, zeros, sizeof(zeros));
		check_inserted(i, sentence, sizeof(sentence) - 1);
	}
}

/* With one damaged block the records are those of the log without that block. */
static void each_block_damaged(void **state)
{
	uint64_t seed = 2;

	(void)state;
	for (size_t i = 0; i < logged.blocks; i++) {
		const size_t at = logged.start[i], length = logged.start[i + 1] - at;
		uint8_t *copy = malloc(logged.size);
		struct stream damaged = {copy, logged.size, logged.blocks, logged.start};
		fw_sbf_stats stats;
		record_sum got, wanted;

		assert_non_null(copy);
		memcpy(copy, logged.bytes, at);
		memcpy(copy + at, logged.bytes + at + length, logged.size - at - length);
		wanted = sum_records(copy, logged.size - length, &stats);
		memcpy(copy, logged.bytes, logged.size);
		damage_block(&damaged, i, &seed);
		got = sum_records(copy, logged.size, &stats);
		free(copy);
		assert_int_equal(stats.blocks, logged.blocks - 1);
		assert_int_equal(stats.blocks_damaged + stats.truncated, 1);
		assert_int_equal(got.records, wanted.records);
		assert_int_equal(got.sum, wanted.sum);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(false_headers),
	    cmocka_unit_test(noise),
	    cmocka_unit_test(zeros_and_sentences),
	    cmocka_unit_test(each_block_damaged),
	};

	return cmocka_run_group_tests_name("decoder_damage", tests, make_streams, free_streams);
}
