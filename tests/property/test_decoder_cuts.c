/* A log cut at every byte: framer and decoder give the records of the blocks that are whole, and no other. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../record_sum.h"
#include "../sbf_stream.h"

static struct stream logged; /* the real log, or a made one where that is absent */

static int make_streams(void **state)
{
	(void)state;
	if (!load_log(&logged, "log_0000.sbf"))
		logged = make_stream(2, 748);
	return 0;
}

static int free_streams(void **state)
{
	(void)state;
	free_stream(&logged);
	return 0;
}

/* Block i into the decoder, without a framer: its place is known. */
static void put_block(fw_sbf_decoder *d, size_t i)
{
	const uint8_t *p = logged.bytes + logged.start[i];
	const fw_sbf_block b = {
	    .data = p,
	    .length = logged.start[i + 1] - logged.start[i],
	    .id = (uint16_t)((p[4] + 256u * p[5]) & 0x1fff),
	    .revision = p[5] >> 5,
	    .tow_ms = p[8] + 256u * p[9] + 65536u * p[10] + 16777216u * p[11],
	    .week = (uint16_t)(p[12] + 256u * p[13]),
	    .offset = logged.start[i],
	};

	fw_sbf_decoder_put(d, &b);
}

/* Each cut is framed from two blocks before, by a decoder that has had all blocks up to there; framing from the
 * first byte at every cut is test_sbf_frame_campaign.c's. */
static void cut_at_every_byte(void **state)
{
	static fw_sbf_decoder after_all, before_two[3], decoder;
	record_sum sum_after_all, sum_before_two[3], sum;

	(void)state;
	decode_everything(&after_all, &sum);
	for (size_t i = 0; i < logged.blocks; i++) {
		const size_t first = i < 2 ? 0 : i - 2;
		record_sum whole;

		before_two[i % 3] = after_all;
		sum_before_two[i % 3] = sum_after_all = sum;
		decoder = after_all;
		fw_sbf_decoder_flush(&decoder);
		whole = sum;
		for (size_t cut = logged.start[i]; cut < logged.start[i + 1]; cut++) {
			fw_sbf_stats stats;

			decoder = before_two[first % 3];
			sum = sum_before_two[first % 3];
			decode_bytes(&decoder, logged.bytes + logged.start[first], cut - logged.start[first],
			             &stats);
			fw_sbf_decoder_flush(&decoder);
			assert_int_equal(sum.records, whole.records);
			assert_int_equal(sum.sum, whole.sum);
			assert_int_equal(stats.blocks, i - first);
			assert_int_equal(stats.truncated, cut > logged.start[i]);
		}
		sum = sum_after_all;
		put_block(&after_all, i);
	}
	fw_sbf_decoder_flush(&after_all);
	assert_true(logged.size != 83028 || sum.records > 2000);
	print_message("%zu cuts, %zu records\n", logged.size, sum.records);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(cut_at_every_byte),
	};

	return cmocka_run_group_tests_name("decoder_cuts", tests, make_streams, free_streams);
}
