#include "demo_lnav.h"

#include <math.h>

#include "formats/nav_bits.h"

enum { DATA_BITS = 24, DATA_BYTES = LNAV_WORDS * DATA_BITS / 8 };

/* The data bits of a subframe one after the other; parity comes last. */
typedef struct {
	uint8_t bytes[DATA_BYTES];
	size_t used;
} subframe;

static void put(subframe *s, unsigned width, int64_t value)
{
	uint32_t mask = (uint32_t)((UINT64_C(1) << width) - 1);
	fw_bits_append(s->bytes, sizeof s->bytes, &s->used, (uint32_t)value & mask, width);
}

/* A number in units of 2^power. */
static void put_scaled(subframe *s, unsigned width, double value, int power)
{
	put(s, width, llround(ldexp(value, -power)));
}

static void put_clock(subframe *s, const scene_satellite *satellite)
{
	put(s, 10, SCENE_WEEK % 1024);
	put(s, 2, 1);              /* code on L2: P */
	put(s, 4 + 6, 0);          /* URA, health: good */
	put(s, 2, LNAV_IODE >> 8); /* IODC */
	for (int word = 4; word <= 6; word++)
		put(s, DATA_BITS, 0);
	put(s, 16 + 8, 0); /* reserved; T_GD */
	put(s, 8, LNAV_IODE);
	put(s, 16, SCENE_TOE_S / 16);
	put(s, 8 + 16, 0); /* a_f2, a_f1 */
	put_scaled(s, 22, satellite->clock_s, -31);
}

static void put_orbit_2(subframe *s, const scene_satellite *satellite)
{
	put(s, 8, LNAV_IODE);
	put(s, 16 + 16, 0); /* C_rs, delta n */
	put_scaled(s, 32, satellite->m0, -31);
	put(s, 16, 0); /* C_uc */
	put(s, 32, 0); /* e */
	put(s, 16, 0); /* C_us */
	put_scaled(s, 32, satellite->sqrt_a, -19);
	put(s, 16, SCENE_TOE_S / 16);
	put(s, 1 + 5, 0); /* fit interval, AODO */
}

static void put_orbit_3(subframe *s, const scene_satellite *satellite)
{
	put(s, 16, 0); /* C_ic */
	put_scaled(s, 32, satellite->omega0, -31);
	put(s, 16, 0); /* C_is */
	put_scaled(s, 32, satellite->i0, -31);
	put(s, 16, 0); /* C_rc */
	put(s, 32, 0); /* omega */
	put(s, 24, 0); /* rate of omega0 */
	put(s, 8, LNAV_IODE);
	put(s, 14, 0); /* rate of i0 */
}

/* The six parity bits of 24 data bits, after a word that ended in the bits d29, d30 (table 20-XIV). */
static uint32_t parity(uint32_t data, unsigned d29, unsigned d30)
{
	static const uint32_t masks[6] = {0xEC7CD2, 0x763E69, 0xBB1F34, 0x5D8F9A, 0xAEC7CD, 0x2DEA27};
	const unsigned before[6] = {d29, d30, d29, d30, d30, d29};
	uint32_t bits = 0;
	for (int i = 0; i < 6; i++)
		bits = bits << 1 | (before[i] ^ ((unsigned)__builtin_popcount(data & masks[i]) & 1));
	return bits;
}

/* The two data bits that make words 2 and 10 end in 00. */
static uint32_t solve_for_zeros(uint32_t data, unsigned d29, unsigned d30)
{
	uint32_t bits = parity(data, d29, d30);
	uint32_t d24 = bits >> 1 & 1, d23 = (bits & 1) ^ d24;
	return data | d23 << 1 | d24;
}

static void add_parity(const subframe *s, uint32_t words[static LNAV_WORDS])
{
	unsigned d29 = 0, d30 = 0;
	for (unsigned i = 0; i < LNAV_WORDS; i++) {
		uint32_t data = fw_bits_unsigned(s->bytes, sizeof s->bytes, DATA_BITS * i, DATA_BITS);
		if (i == 1 || i == LNAV_WORDS - 1)
			data = solve_for_zeros(data, d29, d30);
		uint32_t bits = parity(data, d29, d30);
		words[i] = data << 6 | (d30 ? bits ^ 0x3F : bits);
		d29 = bits >> 1 & 1;
		d30 = bits & 1;
	}
}

void lnav_subframe(const scene_satellite *satellite, unsigned id, unsigned end_s,
                   uint32_t words[static LNAV_WORDS])
{
	subframe s = {0};
	put(&s, 8, 0x8B); /* preamble */
	put(&s, 16, 0);
	put(&s, 17, end_s / 6);
	put(&s, 2, 0); /* alert, anti-spoof */
	put(&s, 3, id);
	put(&s, 2, 0);
	if (id == 1)
		put_clock(&s, satellite);
	else if (id == 2)
		put_orbit_2(&s, satellite);
	else
		put_orbit_3(&s, satellite);
	add_parity(&s, words);
}
