/* Compressed measurements for the harnesses: a reference epoch, an epoch that leans on it, and their extensions.
 * Layout as formats/sbf_meas3.c describes it; what is not structure is random. */
#ifndef FURROW_TESTS_FUZZ_MEAS3_INPUT_H
#define FURROW_TESTS_FUZZ_MEAS3_INPUT_H

#include "sbf_input.h"

enum { MEAS3_GLONASS = 1, MEAS3_BEIDOU = 3, MEAS3_SYSTEMS = 7 };

/* The bodies of the two Meas3Ranges, which grow side by side. */
typedef struct {
	fw_random *r;
	uint8_t *reference, *delta;
	unsigned has_rate;
} meas3_writer;

static inline uint8_t *meas3_random(meas3_writer *w, uint8_t *p, size_t n)
{
	sbf_fill(w->r, p, n);
	return p + n;
}

/* n bytes whose lowest bits say what they are. */
static inline uint8_t *meas3_unit(meas3_writer *w, uint8_t *p, size_t n, unsigned mask, unsigned kind)
{
	sbf_fill(w->r, p, n);
	p[0] = (uint8_t)((p[0] & ~mask) | kind);
	return p + n;
}

/* A master that announces up to two slaves, and these. */
static inline void meas3_satellite(meas3_writer *w)
{
	const unsigned slaves = (unsigned)fw_random_below(w->r, 4);
	uint8_t *master = w->reference;
	if (fw_random_below(w->r, 2) == 0) {
		w->reference = meas3_unit(w, master, 8 + 2 * w->has_rate, 1, 1);
		master[3] = (uint8_t)((master[3] & 15) | slaves << 4);
	} else {
		w->reference = meas3_unit(w, master, 10 + 2 * w->has_rate, 3, 0);
		fw_store_u16(master + 8, (uint16_t)((master[8] & 63) | 1 << 6 | slaves << 7));
	}
	if (fw_random_below(w->r, 2) == 0)
		w->delta = meas3_unit(w, w->delta, 5, 15, 14);
	else
		w->delta = meas3_unit(w, w->delta, 4, 15, 2);
	for (unsigned i = 0; i < 2; i++) {
		if (!(slaves >> i & 1))
			continue;
		if (fw_random_below(w->r, 2) == 0)
			w->reference = meas3_unit(w, w->reference, 5, 1, 1);
		else
			w->reference = meas3_unit(w, w->reference, 7, 3, 0);
		w->delta = meas3_unit(w, w->delta, 3, 3, 2);
	}
}

static inline void meas3_system(meas3_writer *w, unsigned system)
{
	const unsigned mask = (unsigned)fw_random_u64(w->r) & (unsigned)fw_random_u64(w->r) & 0xffff;
	const unsigned n = (unsigned)__builtin_popcount(mask), excluded = fw_random_below(w->r, 8) == 0;
	*w->reference++ = (uint8_t)(2 | excluded << 7);
	*w->delta++ = 0;
	fw_store_u16(w->reference, (uint16_t)mask);
	w->reference += 2;
	if (system == MEAS3_GLONASS)
		w->reference = meas3_random(w, w->reference, (n + 1) / 2);
	if (system == MEAS3_BEIDOU)
		w->reference = meas3_random(w, w->reference, 2);
	if (excluded)
		*w->reference++ = (uint8_t)fw_random_u64(w->r);
	for (unsigned i = 0; i < n; i++)
		meas3_satellite(w);
}

/* Header and end of a block whose body is written; returns where the next one starts. */
static inline uint8_t *meas3_close(uint8_t *block, const uint8_t *end, unsigned id, uint32_t tow_ms)
{
	size_t length = (size_t)(end - block);
	while (length % 4 != 0)
		block[length++] = 0;
	fw_sbf_seal(block, (uint16_t)id, 0, (uint16_t)length, tow_ms, SBF_WEEK);
	return block + length;
}

/* The makers' signature: see sbf_maker. */
static inline size_t meas3_make(fw_random *r, uint32_t *tow_ms, uint8_t *blocks)
{
	static uint8_t delta[SBF_BLOCK_ROOM];
	const unsigned systems =
	    1U << fw_random_below(r, MEAS3_SYSTEMS) | 1U << fw_random_below(r, MEAS3_SYSTEMS);
	const uint32_t reference_ms = *tow_ms / 1000 * 1000, delta_ms = reference_ms + 300;
	meas3_writer w = {r, blocks + 20, delta + 20, (unsigned)fw_random_below(r, 2)};

	blocks[14] = (uint8_t)fw_random_u64(r) & 127; /* not scrambled */
	blocks[15] = (uint8_t)fw_random_u64(r);
	fw_store_u16(blocks + 16, (uint16_t)systems);
	blocks[18] =
	    (uint8_t)(fw_random_below(r, 3) | w.has_rate << 3 | 2 << 4); /* a reference every second */
	blocks[19] = 7;
	memcpy(delta + 14, blocks + 14, 6);
	for (unsigned system = 0; system < MEAS3_SYSTEMS; system++)
		if (systems >> system & 1)
			meas3_system(&w, system);

	uint8_t *p = meas3_close(blocks, w.reference, 4109, reference_ms);
	const size_t n = (size_t)(meas3_close(delta, w.delta, 4109, delta_ms) - delta);
	memcpy(p, delta, n);
	p += n;
	for (unsigned id = 4110; id <= 4113; id++) {
		const size_t body = 8 + 4 * (size_t)fw_random_below(r, 20);
		if (fw_random_below(r, 2) == 0)
			continue;
		sbf_fill(r, p + 16, body);
		fw_store_u16(p + 14, (uint16_t)((blocks[18] & 7) | (fw_random_u64(r) & 0x700)));
		p = meas3_close(p, p + 16 + body, id, delta_ms);
	}
	*tow_ms = delta_ms + 100;
	return (size_t)(p - blocks);
}

#endif
