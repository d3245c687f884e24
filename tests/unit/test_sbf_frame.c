/* The truth is known by construction: streams of blocks made here (tests/sbf_stream.h) or the real log,
 * with one thing changed at a time. The same at length: tests/property/test_sbf_frame_campaign.c. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cmocka.h>

#include "../sbf_stream.h"

static struct stream made, logged; /* logged is the real log, or a longer made one where that is absent */

static int make_streams(void **state)
{
	(void)state;
	made = make_stream(1, 60);
	if (!load_log(&logged, "log_0000.sbf"))
		logged = make_stream(2, 748);
	return 0;
}

static int free_streams(void **state)
{
	(void)state;
	free_stream(&made);
	free_stream(&logged);
	return 0;
}

/* The blocks, and nothing lost but these. */
static void assert_result(const struct result *r, uint64_t blocks, uint64_t damaged, unsigned truncated,
                          uint64_t size)
{
	assert_int_equal(r->status, FW_EOF);
	assert_int_equal(r->stats.blocks, blocks);
	assert_int_equal(r->stats.blocks_damaged, damaged);
	assert_int_equal(r->stats.truncated, truncated);
	assert_int_equal(r->losses, damaged + truncated);
	assert_int_equal(r->stats.bytes_good + r->stats.bytes_skipped, size);
}

/* A DOP block (4001) written out by hand; its CRC was computed with Python's binascii.crc_hqx. */
static const uint8_t dop[] = {0x24, 0x40, 0x85, 0x90, 0xa1, 0x2f, 0x20, 0x00, 0x68, 0xd1, 0xf2,
                              0x0b, 0x38, 0x09, 0x0c, 0x00, 0x5b, 0x00, 0x40, 0x00, 0x33, 0x00,
                              0x4d, 0x00, 0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x00, 0x40};

static void one_block(void **state)
{
	static fw_sbf_framer framer;
	static fw_input in;
	fw_sbf_block b;

	(void)state;
	fw_input_open_memory(&in, dop, sizeof(dop));
	fw_sbf_init(&framer, &in, NULL, NULL);
	assert_int_equal(fw_sbf_next(&framer, &b), FW_OK);
	assert_int_equal(b.id, 4001);
	assert_int_equal(b.revision, 1);
	assert_int_equal(b.length, 32);
	assert_int_equal(b.tow_ms, 200462696);
	assert_int_equal(b.week, 2360);
	assert_int_equal(b.offset, 0);
	assert_memory_equal(b.data, dop, sizeof(dop));
	assert_int_equal(fw_sbf_next(&framer, &b), FW_EOF);
	assert_int_equal(fw_sbf_next(&framer, &b), FW_EOF);
	assert_int_equal(b.id, 4001); /* untouched */
}

/* The shortest blocks have no room for a time stamp. */
static void blocks_without_time(void **state)
{
	static fw_sbf_framer framer;
	static fw_input in;
	uint8_t bytes[20] = {0};
	fw_sbf_block b;

	(void)state;
	seal_block(bytes, 5000, 8);
	seal_block(bytes + 8, 5001, 12);
	fw_input_open_memory(&in, bytes, sizeof(bytes));
	fw_sbf_init(&framer, &in, NULL, NULL);
	for (unsigned id = 5000; id < 5002; id++) {
		assert_int_equal(fw_sbf_next(&framer, &b), FW_OK);
		assert_int_equal(b.id, id);
		assert_int_equal(b.week, FW_SBF_NO_WEEK);
		assert_int_equal(b.tow_ms, FW_SBF_NO_TOW);
	}
	assert_int_equal(b.offset, 8);
}

static void longest_block(void **state)
{
	static uint8_t bytes[3 * FW_SBF_LONGEST];
	uint64_t seed = 3;
	struct result r;

	(void)state;
	fill_random(&seed, bytes, sizeof(bytes));
	for (size_t i = 0; i < 3; i++)
		seal_block(bytes + i * FW_SBF_LONGEST, 4000, FW_SBF_LONGEST);
	r = frame_bytes(bytes, sizeof(bytes));
	assert_result(&r, 3, 0, 0, sizeof(bytes));
}

static void nothing_at_all(void **state)
{
	static uint8_t bytes[100000];
	uint64_t seed = 4;
	struct result r = frame_bytes(bytes, 0);

	(void)state;
	assert_result(&r, 0, 0, 0, 0);
	r = frame_bytes(bytes, sizeof(bytes));
	assert_result(&r, 0, 0, 0, sizeof(bytes));
	assert_int_equal(r.stats.resyncs, 1);
	fill_random(&seed, bytes, sizeof(bytes));
	r = frame_bytes(bytes, sizeof(bytes));
	assert_result(&r, 0, 0, 0, sizeof(bytes));
}

static void undamaged(void **state)
{
	struct result r = frame_bytes(logged.bytes, logged.size);

	(void)state;
	assert_result(&r, logged.blocks, 0, 0, logged.size);
	assert_int_equal(r.stats.resyncs, 0);
}

static void cut_at_every_byte(void **state)
{
	size_t whole = 0;

	(void)state;
	for (size_t cut = 0; cut < made.size; cut++) {
		struct result r = frame_bytes(made.bytes, cut);
		unsigned inside;

		whole += cut == made.start[whole + 1];
		inside = cut != made.start[whole];
		assert_result(&r, whole, 0, inside, cut);
		if (inside) {
			assert_int_equal(r.loss.offset, made.start[whole]);
			assert_int_equal(r.loss.status, FW_ETRUNCATED);
		}
	}
}

/* What may stand between blocks without being one. */
static size_t foreign_bytes(unsigned kind, uint64_t *seed, uint8_t *bytes)
{
	static const uint16_t lengths[] = {0, 4, 6, 8192, 65532, 65535};
	static const char *const sentences[] = {
	    "$GPGGA,120000.00,4807.0380,N,01131.0000,E,1,08,0.9,545.4,M,46.9,M,,*42\r\n",
	    "$PSSN,HRP,120000.00,010124,123.456,1.234,,0.1,0.2,,12,2,1.0,E*1A\r\n",
	    "$GPHRP,1,1,02,05,40,083,46*7A\r\n!AIVDM,1,1,,A,14eG;o@034o8sd<L9i:a;WF>062D,0*7D\r\n",
	    "COM1> exe, CopyConfigFile, Current, Boot\r\n$R: exe\r\n",
	};

	if (kind < 6) {
		fill_random(seed, bytes, 8);
		memcpy(bytes, "$@", 2);
		if (below(seed, 2) == 0)
			put_u2(bytes + 4, 4027);
		put_u2(bytes + 6, lengths[kind]);
		return 8;
	}
	if (kind < 10) {
		memcpy(bytes, sentences[kind - 6], strlen(sentences[kind - 6]));
		return strlen(sentences[kind - 6]);
	}
	if (kind == 10) {
		memset(bytes, 0, 1000);
		return 1000;
	}
	if (kind == 11) { /* half a sync pair, and one too many */
		memcpy(bytes, "$$@@$", 5);
		return 5;
	}
	kind = 1 + (unsigned)below(seed, 64);
	fill_random(seed, bytes, kind);
	return kind;
}

static void foreign_bytes_cost_nothing(void **state)
{
	uint64_t seed = 6;
	uint8_t bytes[1000];

	(void)state;
	for (size_t i = 0; i < logged.blocks; i++)
		for (unsigned kind = 0; kind < 14; kind++) {
			const size_t n = foreign_bytes(kind, &seed, bytes);
			struct result r = frame_inserted(&logged, logged.start[i], bytes, n);

			assert_result(&r, logged.blocks, 0, 0, logged.size + n);
			assert_int_equal(r.stats.bytes_skipped, n);
			assert_int_equal(r.stats.resyncs, 1);
		}
}

/* Foreign bytes everywhere at once, between damaged blocks too. */
static void foreign_bytes_between_damaged_blocks(void **state)
{
	struct stream s = make_stream(9, 1000), t = new_stream(s.size + 2000 * 1000, 1000);
	uint64_t seed = 10;
	struct result r;

	(void)state;
	for (size_t i = 0; i < s.blocks; i++) {
		t.size += foreign_bytes((unsigned)below(&seed, 12), &seed, t.bytes + t.size);
		if (i % 2 == 1) /* in the body */
			s.bytes[s.start[i] + 14 + below(&seed, s.start[i + 1] - s.start[i] - 14)] ^= 0x10;
		memcpy(t.bytes + t.size, s.bytes + s.start[i], s.start[i + 1] - s.start[i]);
		t.size += s.start[i + 1] - s.start[i];
	}
	r = frame_bytes(t.bytes, t.size);
	assert_result(&r, 500, 500, 0, t.size);
	free_stream(&s);
	free_stream(&t);
}

/* Each bit of some blocks, seen among their neighbours. Only a changed length can meet a CRC that fits. */
static void any_bit_costs_one_block(void **state)
{
	(void)state;
	for (size_t i = 4; i + 4 < logged.blocks; i += 29) {
		const size_t from = logged.start[i - 4], n = logged.start[i + 4] - from;
		uint8_t *p = logged.bytes + logged.start[i];

		for (size_t bit = 0; bit < 8 * (logged.start[i + 1] - logged.start[i]); bit++) {
			struct result r;

			p[bit / 8] ^= (uint8_t)(1u << bit % 8);
			r = frame_bytes(logged.bytes + from, n);
			p[bit / 8] ^= (uint8_t)(1u << bit % 8);
			assert_result(&r, 7, 1, 0, n);
			assert_int_equal(r.loss.offset, logged.start[i] - from);
		}
	}
}

/* What the caller is told. */
static void losses_are_described(void **state)
{
	uint8_t *block = made.bytes + made.start[20];
	const uint16_t id = (uint16_t)((block[4] | block[5] << 8) & 0x1fff);
	struct result r;

	(void)state;
	block[15] ^= 1;
	r = frame_bytes(made.bytes, made.size);
	assert_int_equal(r.loss.offset, made.start[20]);
	assert_int_equal(r.loss.status, FW_ECHECKSUM);
	assert_int_equal(r.loss.id, id);
	block[15] ^= 1;
	block[6] ^= 64;
	r = frame_bytes(made.bytes, made.size);
	assert_int_equal(r.loss.status, FW_EFORMAT);
	assert_int_equal(r.loss.id, id);
	block[6] ^= 64;
	block[0] ^= 1;
	block[6] ^= 1;
	r = frame_bytes(made.bytes, made.size);
	assert_int_equal(r.loss.offset, made.start[20]);
	assert_int_equal(r.loss.status, FW_EFORMAT);
	assert_int_equal(r.loss.id, 0);
	block[6] ^= 1;
	block[0] ^= 1;
}

/* 1,000 of 100,000, of made blocks and of the log's; a pair of neighbours is damaged about ten times. */
static void losses_are_counted_exactly(void **state)
{
	(void)state;
	for (uint64_t seed = 1; seed <= 4; seed++) {
		struct stream s =
		    seed % 2 ? make_stream(seed, 100000) : shuffle_stream(&logged, seed, 100000);
		struct result r;

		damage_stream(&s, seed, 1000);
		r = frame_bytes(s.bytes, s.size);
		assert_result(&r, 99000, 1000, 0, s.size);
		free_stream(&s);
	}
}

/* More than the framer can remember at once, in a row: each damaged in its body, or in its length too. */
static void many_damaged_in_a_row(void **state)
{
	(void)state;
	for (unsigned lengths = 0; lengths < 2; lengths++) {
		struct stream s = make_stream(11, 600);
		struct result r;

		for (size_t i = 100; i < 500; i++) {
			s.bytes[s.start[i] + 14] ^= 0x55;
			if (lengths && i % 3 == 0)
				s.bytes[s.start[i] + 6] ^= 0x04;
		}
		r = frame_bytes(s.bytes, s.size);
		assert_result(&r, 200, 400, 0, s.size);
		assert_int_equal(r.stats.resyncs, 1);
		assert_int_equal(r.loss.offset, s.start[100]);
		assert_int_equal(r.last_loss, s.start[499]);
		free_stream(&s);
	}
}

/* Two neighbours, each damaged in each byte of its header in turn. */
static void neighbours_with_damaged_headers(void **state)
{
	(void)state;
	for (size_t a = 0; a < 8; a++)
		for (size_t b = 0; b < 8; b++) {
			uint8_t *p = made.bytes + made.start[10] + a, *q = made.bytes + made.start[11] + b;
			struct result r;

			*p ^= 0xff;
			*q ^= 0xff;
			r = frame_bytes(made.bytes, made.size);
			*p ^= 0xff;
			*q ^= 0xff;
			assert_result(&r, made.blocks - 2, 2, 0, made.size);
			assert_int_equal(r.loss.offset, made.start[10]);
			assert_int_equal(r.last_loss, made.start[11]);
		}
}

/* Of these headers only id and length are left: they are found because a block is due there. */
static void found_where_they_are_due(void **state)
{
	struct stream s = make_stream(15, 20);
	struct result r;

	(void)state;
	s.bytes[s.start[5] + 14] ^= 1;
	for (size_t i = 6; i < 9; i++) {
		memset(s.bytes + s.start[i], 0x77, 4);
		memset(s.bytes + s.start[i] + 8, 0x77, 6);
	}
	r = frame_bytes(s.bytes, s.size);
	assert_result(&r, 16, 4, 0, s.size);
	free_stream(&s);
}

/* Nothing is left of the header but the time, and that is two hours or two days from the others'. */
static void found_by_the_time_alone(void **state)
{
	struct stream s = make_stream(16, 20);
	uint8_t *p = s.bytes + s.start[7];
	struct result r;

	(void)state;
	memset(p, 0x77, 8);
	p[10] += 110; /* 110 * 65.536 s */
	r = frame_bytes(s.bytes, s.size);
	assert_result(&r, 19, 1, 0, s.size);
	p[11] += 11; /* 11 * 16,777.216 s: the week alone is not enough */
	r = frame_bytes(s.bytes, s.size);
	assert_result(&r, 19, 0, 0, s.size);
	free_stream(&s);
}

/* A damaged block that holds a damaged block with a perfect header is one. */
static void a_block_inside_a_block(void **state)
{
	struct stream s = new_stream(1000, 3);
	uint8_t outer[200], *inner = outer + 40;
	struct result r;

	(void)state;
	for (size_t i = 0; i < 3; i++) {
		memcpy(outer, dop, sizeof(dop));
		memset(outer + sizeof(dop), 0x11, sizeof(outer) - sizeof(dop));
		memcpy(inner, dop, sizeof(dop));
		inner[20] ^= 1;
		seal_block(outer, 4001, sizeof(outer));
		append_block(&s, outer, sizeof(outer));
	}
	r = frame_bytes(s.bytes, s.size);
	assert_result(&r, 3, 0, 0, s.size);
	s.bytes[s.start[1] + 150] ^= 1;
	r = frame_bytes(s.bytes, s.size);
	assert_result(&r, 2, 1, 0, s.size);
	assert_int_equal(r.loss.offset, s.start[1]);
	free_stream(&s);
}

/* The end of the input comes inside a block: behind foreign bytes, with its sync damaged, behind a damaged
 * block. */
static void cut_and_something_else(void **state)
{
	const size_t last = made.start[10], whole = made.start[11];
	uint8_t copy[20000];
	struct result r;

	(void)state;
	assert_true(whole + 20 < sizeof(copy));
	memcpy(copy, made.bytes, last);
	memcpy(copy + last, "$GPGGA,,*00\r\n", 13);
	memcpy(copy + last + 13, made.bytes + last, whole - last);
	for (size_t n = last + 13 + 2; n < whole + 13; n++) { /* one byte is no sign behind foreign bytes */
		r = frame_bytes(copy, n);
		assert_result(&r, 10, 0, 1, n);
		assert_int_equal(r.loss.offset, last + 13);
	}
	memcpy(copy, made.bytes, whole);
	copy[last] ^= 1;
	for (size_t n = last + 16; n < whole; n++) {
		r = frame_bytes(copy, n);
		assert_result(&r, 10, 0, 1, n);
	}
	copy[last] ^= 1;
	copy[made.start[9] + 15] ^= 1;
	for (size_t n = last + 1; n < whole; n++) {
		r = frame_bytes(copy, n);
		assert_result(&r, 9, 1, 1, n);
	}
}

/* A claim that goes beyond the end, with another damaged block inside: two damaged, none cut. */
static void no_cut_around_a_block(void **state)
{
	const size_t n = made.start[12];
	uint8_t *length = made.bytes + made.start[10] + 7, *body = made.bytes + made.start[11] + 15;
	struct result r;

	(void)state;
	*length ^= 0x80;
	*body ^= 1;
	r = frame_bytes(made.bytes, n);
	assert_result(&r, 10, 2, 0, n);
	*length ^= 0x80;
	*body ^= 1;
}

/* A length that swallows what follows it: everything inside is still found, at the end of the input too. */
static void a_length_too_long(void **state)
{
	(void)state;
	for (size_t i = 0; i + 1 < made.blocks; i++) {
		uint8_t *length = made.bytes + made.start[i] + 7;
		const uint8_t old = *length;
		struct result r;

		*length = 0xfe;
		r = frame_bytes(made.bytes, made.size);
		assert_result(&r, made.blocks - 1, 1, 0, made.size);
		*length = old;
	}
}

/* A child writes the bytes to a pipe, in pieces of 1 .. longest bytes. */
static struct result frame_pipe(const struct stream *s, size_t longest)
{
	static fw_input in;
	const int old = dup(STDIN_FILENO);
	uint64_t seed = 12;
	struct result r;
	int fds[2];
	pid_t child;

	assert_int_equal(pipe(fds), 0);
	child = fork();
	if (child == 0) {
		close(fds[0]);
		for (size_t at = 0, n; at < s->size; at += n) {
			n = 1 + below(&seed, longest);
			n = n < s->size - at ? n : s->size - at;
			if (write(fds[1], s->bytes + at, n) != (ssize_t)n)
				_exit(1);
		}
		_exit(0);
	}
	close(fds[1]);
	dup2(fds[0], STDIN_FILENO);
	close(fds[0]);
	assert_int_equal(fw_input_open(&in, "-"), FW_OK);
	r = frame_input(&in);
	dup2(old, STDIN_FILENO);
	close(old);
	assert_int_equal(waitpid(child, NULL, 0), child);
	return r;
}

static void pieces_do_not_matter(void **state)
{
	struct stream s = make_stream(13, 3000);
	struct result whole, r;

	(void)state;
	damage_stream(&s, 14, 100);
	for (size_t longest = 4096; longest >= 64; longest /= 8) {
		whole = frame_bytes(s.bytes, s.size);
		r = frame_pipe(&s, longest);
		assert_result(&r, whole.stats.blocks, whole.stats.blocks_damaged, whole.stats.truncated,
		              s.size);
		assert_int_equal(r.sum, whole.sum);
	}
	s.blocks = 300; /* a byte at a time */
	s.size = s.start[s.blocks];
	whole = frame_bytes(s.bytes, s.size);
	r = frame_pipe(&s, 1);
	assert_result(&r, whole.stats.blocks, whole.stats.blocks_damaged, whole.stats.truncated, s.size);
	assert_int_equal(r.sum, whole.sum);
	free_stream(&s);
}

/* The input fails: the blocks in front of the failure come first, then what went wrong, again and again. */
static void failures_of_the_input(void **state)
{
	static fw_sbf_framer framer;
	static fw_input in;
	static const uint8_t no_gzip[20] = {0x1f, 0x8b, 8};
	fw_sbf_block b;

	(void)state;
	fw_input_open_memory(&in, no_gzip, sizeof(no_gzip));
	fw_sbf_init(&framer, &in, NULL, NULL);
	assert_int_equal(fw_sbf_next(&framer, &b), FW_EFORMAT);
	assert_int_equal(fw_sbf_next(&framer, &b), FW_EFORMAT);
	fw_input_close(&in);
	assert_int_equal(fw_input_open(&in, "/"), FW_OK);
	fw_sbf_init(&framer, &in, NULL, NULL);
	assert_int_equal(fw_sbf_next(&framer, &b), FW_EIO);
	fw_input_close(&in);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(one_block),
	    cmocka_unit_test(blocks_without_time),
	    cmocka_unit_test(longest_block),
	    cmocka_unit_test(nothing_at_all),
	    cmocka_unit_test(undamaged),
	    cmocka_unit_test(cut_at_every_byte),
	    cmocka_unit_test(foreign_bytes_cost_nothing),
	    cmocka_unit_test(foreign_bytes_between_damaged_blocks),
	    cmocka_unit_test(any_bit_costs_one_block),
	    cmocka_unit_test(losses_are_described),
	    cmocka_unit_test(losses_are_counted_exactly),
	    cmocka_unit_test(many_damaged_in_a_row),
	    cmocka_unit_test(neighbours_with_damaged_headers),
	    cmocka_unit_test(found_where_they_are_due),
	    cmocka_unit_test(found_by_the_time_alone),
	    cmocka_unit_test(a_block_inside_a_block),
	    cmocka_unit_test(cut_and_something_else),
	    cmocka_unit_test(no_cut_around_a_block),
	    cmocka_unit_test(a_length_too_long),
	    cmocka_unit_test(pieces_do_not_matter),
	    cmocka_unit_test(failures_of_the_input),
	};

	return cmocka_run_group_tests_name("sbf_frame", tests, make_streams, free_streams);
}
