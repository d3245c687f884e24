/* What the tests of the SBF framer share: streams that they make themselves, the real log, and a plain way
 * to frame a piece of memory. The CRC is computed bit by bit, apart from the code under test. */
#ifndef FURROW_TESTS_SBF_STREAM_H
#define FURROW_TESTS_SBF_STREAM_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/sbf_frame.h"

/* splitmix64 (Steele, Lea and Flood 2014) */
static inline uint64_t next_random(uint64_t *seed)
{
	uint64_t z = *seed += 0x9e3779b97f4a7c15;

	z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
	z = (z ^ z >> 27) * 0x94d049bb133111eb;
	return z ^ z >> 31;
}

static inline size_t below(uint64_t *seed, size_t n)
{
	return (size_t)(next_random(seed) % n);
}

static inline void fill_random(uint64_t *seed, uint8_t *p, size_t n)
{
	while (n-- > 0)
		*p++ = (uint8_t)(next_random(seed) >> 32);
}

static inline uint16_t bitwise_crc16(const uint8_t *p, size_t n)
{
	unsigned crc = 0;

	for (; n > 0; n--, p++) {
		crc ^= (unsigned)*p << 8;
		for (int bit = 0; bit < 8; bit++)
			crc = crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1;
	}
	return (uint16_t)crc;
}

static inline void put_u2(uint8_t *p, size_t value)
{
	p[0] = (uint8_t)value;
	p[1] = (uint8_t)(value >> 8);
}

/* Header and CRC around the body that is there already. */
static inline void seal_block(uint8_t *p, unsigned id, size_t length)
{
	p[0] = '$';
	p[1] = '@';
	put_u2(p + 4, id);
	put_u2(p + 6, length);
	put_u2(p + 2, bitwise_crc16(p + 4, length - 4));
}

/* Bytes, and where the blocks in them start; start[blocks] is the end. */
struct stream {
	uint8_t *bytes;
	size_t size, blocks;
	size_t *start;
};

static inline struct stream new_stream(size_t room, size_t blocks)
{
	struct stream s = {malloc(room), 0, 0, malloc((blocks + 1) * sizeof(size_t))};

	if (s.bytes == NULL || s.start == NULL)
		abort();
	s.start[0] = 0;
	return s;
}

static inline void free_stream(struct stream *s)
{
	free(s->bytes);
	free(s->start);
}

static inline void append_block(struct stream *s, const uint8_t *block, size_t length)
{
	memcpy(s->bytes + s->size, block, length);
	s->size += length;
	s->start[++s->blocks] = s->size;
}

/* n blocks with random bodies of 16 to 255 bytes, now and then some kB, 100 ms apart in week 2360. */
static inline struct stream make_stream(uint64_t seed, size_t n)
{
	struct stream s = new_stream(n * 256 + (n / 50 + 1) * 8192, n);
	static uint8_t block[8192];

	for (size_t i = 0; i < n; i++) {
		const size_t length =
		    (i % 50 == 30 ? 1024 + below(&seed, 7168) : 16 + below(&seed, 240)) & ~(size_t)3;
		const uint32_t tow = (uint32_t)(200000000 + 100 * i);

		fill_random(&seed, block, length);
		put_u2(block + 8, tow & 0xffff);
		put_u2(block + 10, tow >> 16);
		put_u2(block + 12, 2360);
		seal_block(block, (unsigned)(4000 + below(&seed, 120) + (below(&seed, 8) << 13)), length);
		append_block(&s, block, length);
	}
	return s;
}

/* The real log of 748 blocks, without a gap; false when it is not there. */
static inline int load_log(struct stream *s, const char *name)
{
	const char *directory = getenv("FURROW_DATA");
	char path[4096];
	FILE *file;
	long size;

	snprintf(path, sizeof(path), "%s/sbf/%s", directory != NULL ? directory : "../shared/data", name);
	file = fopen(path, "rb");
	if (file == NULL) {
		fprintf(stderr, "%s: not here, skipped (set FURROW_DATA)\n", path);
		return 0;
	}
	fseek(file, 0, SEEK_END);
	size = ftell(file);
	rewind(file);
	*s = new_stream((size_t)size, (size_t)size / 8);
	s->size = fread(s->bytes, 1, (size_t)size, file);
	fclose(file);
	while (s->start[s->blocks] < s->size) {
		const size_t at = s->start[s->blocks];

		s->start[++s->blocks] = at + s->bytes[at + 6] + 256u * s->bytes[at + 7];
	}
	return 1;
}

/* n blocks of s drawn at random. */
static inline struct stream shuffle_stream(const struct stream *s, uint64_t seed, size_t n)
{
	size_t longest = 0;
	struct stream t;

	for (size_t i = 0; i < s->blocks; i++)
		if (s->start[i + 1] - s->start[i] > longest)
			longest = s->start[i + 1] - s->start[i];
	t = new_stream(n * longest, n);
	while (t.blocks < n) {
		const size_t i = below(&seed, s->blocks);

		append_block(&t, s->bytes + s->start[i], s->start[i + 1] - s->start[i]);
	}
	return t;
}

/* What framing gave. */
struct result {
	fw_sbf_stats stats;
	fw_status status;
	uint64_t sum;       /* over the bytes and offsets of the blocks: the same blocks give the same sum */
	size_t losses;      /* calls of the loss function */
	fw_sbf_loss loss;   /* the first */
	uint64_t last_loss; /* offset of the last */
};

static inline void note_loss(void *context, const fw_sbf_loss *loss)
{
	struct result *r = context;

	if (r->losses++ == 0)
		r->loss = *loss;
	r->last_loss = loss->offset;
}

static inline struct result frame_input(fw_input *in)
{
	static fw_sbf_framer framer;
	struct result r = {0};
	fw_sbf_block b;

	fw_sbf_init(&framer, in, note_loss, &r);
	while ((r.status = fw_sbf_next(&framer, &b)) == FW_OK)
		r.sum = (r.sum * 31 + b.length) * 31 + b.data[2] + 256u * b.data[3] + 65536u * b.id;
	r.stats = framer.stats;
	fw_input_close(in);
	return r;
}

static inline struct result frame_bytes(const uint8_t *bytes, size_t n)
{
	static fw_input in;

	fw_input_open_memory(&in, bytes, n);
	return frame_input(&in);
}

/* s with n bytes put in front of byte `at`, framed. */
static inline struct result frame_inserted(const struct stream *s, size_t at, const uint8_t *bytes, size_t n)
{
	uint8_t *copy = malloc(s->size + n);
	struct result r;

	if (copy == NULL)
		abort();
	memcpy(copy, s->bytes, at);
	memcpy(copy + at, bytes, n);
	memcpy(copy + at + n, s->bytes + at, s->size - at);
	r = frame_bytes(copy, s->size + n);
	free(copy);
	return r;
}

/* Damage one block: a bit, a byte, or up to eight bytes that follow one another. */
static inline void damage_block(struct stream *s, size_t i, uint64_t *seed)
{
	uint8_t *p = s->bytes + s->start[i];
	const size_t length = s->start[i + 1] - s->start[i];
	const size_t n = 1 + below(seed, 8);
	const size_t at = below(seed, length - n + 1);

	if (below(seed, 2) == 0) {
		p[at] ^= (uint8_t)(1u << below(seed, 8));
		return;
	}
	for (size_t j = 0; j < n; j++)
		p[at + j] ^= (uint8_t)(1 + below(seed, 255));
}

/* Damage n different blocks, picked at random. */
static inline void damage_stream(struct stream *s, uint64_t seed, size_t n)
{
	uint8_t *done = calloc(s->blocks, 1);

	if (done == NULL)
		abort();
	while (n > 0) {
		const size_t i = below(&seed, s->blocks);

		if (done[i])
			continue;
		done[i] = 1;
		damage_block(s, i, &seed);
		n--;
	}
	free(done);
}

#endif
