/* The SBF framer at length, on the real log: cut at every byte, every bit of a hundred blocks, every
 * number of foreign bytes in front of every block, and inputs made to be slow. The short form is
 * tests/unit/test_sbf_frame.c. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <time.h>
#include <cmocka.h>

#include "../sbf_stream.h"

enum { MIB = 1 << 20 };

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

static void cut_at_every_byte(void **state)
{
	size_t whole = 0;

	(void)state;
	for (size_t cut = 0; cut < logged.size; cut++) {
		struct result r = frame_bytes(logged.bytes, cut);

		whole += cut == logged.start[whole + 1];
		assert_int_equal(r.stats.blocks, whole);
		assert_int_equal(r.stats.blocks_damaged, 0);
		assert_int_equal(r.stats.truncated, cut != logged.start[whole]);
		assert_int_equal(r.stats.bytes_good, logged.start[whole]);
		assert_int_equal(r.stats.bytes_good + r.stats.bytes_skipped, cut);
	}
}

/* Only a changed length can meet a CRC that fits by chance, 2^-16 each time; none does here. */
static void any_bit_of_a_hundred_blocks(void **state)
{
	(void)state;
	for (size_t k = 0; k < 100; k++) {
		const size_t i = k * (logged.blocks - 1) / 100;
		uint8_t *p = logged.bytes + logged.start[i];

		for (size_t bit = 0; bit < 8 * (logged.start[i + 1] - logged.start[i]); bit++) {
			struct result r;

			p[bit / 8] ^= (uint8_t)(1u << bit % 8);
			r = frame_bytes(logged.bytes, logged.size);
			p[bit / 8] ^= (uint8_t)(1u << bit % 8);
			assert_int_equal(r.stats.blocks, logged.blocks - 1);
			assert_int_equal(r.stats.blocks_damaged, 1);
			assert_int_equal(r.stats.truncated, 0);
			assert_int_equal(r.loss.offset, logged.start[i]);
		}
	}
}

/* 47,872 insertions. Noise looks like the remains of a block once in 2^18 times or so, which is why one
 * false alarm is let pass; a lost block never is. */
static void noise_of_every_length(void **state)
{
	uint64_t seed = 1, alarms = 0;
	uint8_t noise[64];

	(void)state;
	for (size_t i = 0; i < logged.blocks; i++)
		for (size_t n = 1; n <= sizeof(noise); n++) {
			struct result r;

			fill_random(&seed, noise, n);
			r = frame_inserted(&logged, logged.start[i], noise, n);
			assert_int_equal(r.stats.blocks, logged.blocks);
			assert_int_equal(r.stats.bytes_skipped, n);
			alarms += r.stats.blocks_damaged + r.stats.truncated;
		}
	assert_in_range(alarms, 0, 1);
}

/* Half of another block: no block may be lost by it. It counts as one damaged block, which it is. */
static void half_of_another_block(void **state)
{
	uint64_t seed = 2;

	(void)state;
	for (size_t i = 0; i < logged.blocks; i++) {
		const size_t j = below(&seed, logged.blocks);
		const size_t n = (logged.start[j + 1] - logged.start[j]) / 2;
		struct result r = frame_inserted(&logged, logged.start[i], logged.bytes + logged.start[j], n);

		assert_int_equal(r.stats.blocks, logged.blocks);
		assert_in_range(r.stats.blocks_damaged, 0, 1);
		assert_int_equal(r.stats.truncated, 0);
	}
}

/* 20 times 1,000 of 100,000. Damage of more than two bytes meets a CRC that fits once in 65,536 times, and
 * a burst over id, length and time can leave too little of a header: two in 20,000 are let pass. */
static void losses_are_counted(void **state)
{
	uint64_t miscounted = 0;

	(void)state;
	for (uint64_t seed = 100; seed < 120; seed++) {
		struct stream s =
		    seed % 2 ? make_stream(seed, 100000) : shuffle_stream(&logged, seed, 100000);
		struct result r;

		damage_stream(&s, seed, 1000);
		r = frame_bytes(s.bytes, s.size);
		assert_in_range(r.stats.blocks, 99000, 99001);
		miscounted += (uint64_t)llabs((long long)(r.stats.blocks_damaged + r.stats.truncated) - 1000);
		free_stream(&s);
	}
	assert_in_range(miscounted, 0, 2);
}

/* Inputs made to be slow. Each fills n bytes. */
static void storm_of_longest(uint8_t *p, size_t n)
{
	for (size_t i = 0; i < n; i++)
		p[i] = (const uint8_t[]){'$', '@', 0, 0, 0xa0, 0x0f, 0xfc, 0xff}[i % 8];
}

static void storm_of_pairs(uint8_t *p, size_t n)
{
	for (size_t i = 0; i < n; i++)
		p[i] = i % 2 ? '@' : '$';
}

static void storm_of_dollars(uint8_t *p, size_t n)
{
	memset(p, '$', n);
}

static void storm_of_noise(uint8_t *p, size_t n)
{
	uint64_t seed = 3;

	fill_random(&seed, p, n);
}

/* A good block, then a false header with the longest claim, over and over: each block makes the framer
 * trust again. */
static void storm_of_hopes(uint8_t *p, size_t n)
{
	uint8_t pair[24] = {[16] = '$', '@', 1, 2, 0xa0, 0x0f, 0xfc, 0xff};

	seal_block(pair, 4000, 16);
	for (size_t i = 0; i < n; i++)
		p[i] = pair[i % sizeof(pair)];
}

/* The same with claims of all lengths, which end in one another. */
static void storm_of_claims(uint8_t *p, size_t n)
{
	uint64_t seed = 4;

	storm_of_longest(p, n);
	for (size_t i = 6; i + 1 < n; i += 8)
		put_u2(p + i, below(&seed, 16384) * 4);
}

static double seconds_for(const uint8_t *p, size_t n)
{
	const clock_t before = clock();
	const struct result r = frame_bytes(p, n);

	assert_int_equal(r.status, FW_EOF);
	assert_int_equal(r.stats.bytes_good + r.stats.bytes_skipped, n);
	return (double)(clock() - before) / CLOCKS_PER_SEC;
}

static void hostile_input_is_linear(void **state)
{
	static void (*const storms[])(uint8_t *, size_t) = {storm_of_longest, storm_of_pairs,
	                                                    storm_of_dollars, storm_of_noise,
	                                                    storm_of_hopes,   storm_of_claims};
	uint8_t *p = malloc(16 * MIB);

	(void)state;
	assert_non_null(p);
	for (size_t i = 0; i < sizeof(storms) / sizeof(storms[0]); i++) {
		double one, sixteen;

		storms[i](p, 16 * MIB);
		one = seconds_for(p, MIB);
		sixteen = seconds_for(p, 16 * MIB);
		print_message("storm %zu: %.4f s for 1 MiB, %.4f s for 16 MiB\n", i, one, sixteen);
		assert_true(sixteen <= 16 * 0.5);
		assert_true(sixteen <= 20 * one + 0.05); /* clock() is coarse for what takes a millisecond */
	}
	free(p);
}

static void noise_holds_no_blocks(void **state)
{
	uint8_t *p = malloc(64 * MIB);
	struct result r;

	(void)state;
	assert_non_null(p);
	storm_of_noise(p, 64 * MIB);
	r = frame_bytes(p, 64 * MIB);
	assert_int_equal(r.stats.blocks, 0);
	assert_int_equal(r.stats.blocks_damaged, 0);
	assert_int_equal(r.stats.bytes_skipped, 64 * MIB);
	free(p);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(cut_at_every_byte),     cmocka_unit_test(any_bit_of_a_hundred_blocks),
	    cmocka_unit_test(noise_of_every_length), cmocka_unit_test(half_of_another_block),
	    cmocka_unit_test(losses_are_counted),    cmocka_unit_test(hostile_input_is_linear),
	    cmocka_unit_test(noise_holds_no_blocks),
	};

	return cmocka_run_group_tests_name("sbf_frame_campaign", tests, make_streams, free_streams);
}
