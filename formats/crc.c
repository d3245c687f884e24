#include "formats/crc.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

/* A table entry is the sum of what the bits of its index contribute: eight constants make 256 entries. */
#define BITS(i, a, b, c, d, e, f, g, h)                                                                      \
	((i)&1 ? (a) : 0) ^ ((i)&2 ? (b) : 0) ^ ((i)&4 ? (c) : 0) ^ ((i)&8 ? (d) : 0) ^ ((i)&16 ? (e) : 0) ^ \
	    ((i)&32 ? (f) : 0) ^ ((i)&64 ? (g) : 0) ^ ((i)&128 ? (h) : 0)
#define BY4(i, ...)                                                                                          \
	BITS(i, __VA_ARGS__), BITS(i + 1, __VA_ARGS__), BITS(i + 2, __VA_ARGS__), BITS(i + 3, __VA_ARGS__)
#define BY16(i, ...)                                                                                         \
	BY4(i, __VA_ARGS__), BY4(i + 4, __VA_ARGS__), BY4(i + 8, __VA_ARGS__), BY4(i + 12, __VA_ARGS__)
#define BY64(i, ...)                                                                                         \
	BY16(i, __VA_ARGS__), BY16(i + 16, __VA_ARGS__), BY16(i + 32, __VA_ARGS__), BY16(i + 48, __VA_ARGS__)
#define TABLE(...) BY64(0, __VA_ARGS__), BY64(64, __VA_ARGS__), BY64(128, __VA_ARGS__), BY64(192, __VA_ARGS__)

/* slice[j][i] = i(x) x^(16 + 8j) mod P: what byte i adds to the CRC when j more bytes follow it.
 * The constants are x^(16 + 8j + k), k = 0 .. 7. */
static const uint16_t slice[8][256] = {
    {TABLE(0x1021, 0x2042, 0x4084, 0x8108, 0x1231, 0x2462, 0x48c4, 0x9188)},
    {TABLE(0x3331, 0x6662, 0xccc4, 0x89a9, 0x0373, 0x06e6, 0x0dcc, 0x1b98)},
    {TABLE(0x3730, 0x6e60, 0xdcc0, 0xa9a1, 0x4363, 0x86c6, 0x1dad, 0x3b5a)},
    {TABLE(0x76b4, 0xed68, 0xcaf1, 0x85c3, 0x1ba7, 0x374e, 0x6e9c, 0xdd38)},
    {TABLE(0xaa51, 0x4483, 0x8906, 0x022d, 0x045a, 0x08b4, 0x1168, 0x22d0)},
    {TABLE(0x45a0, 0x8b40, 0x06a1, 0x0d42, 0x1a84, 0x3508, 0x6a10, 0xd420)},
    {TABLE(0xb861, 0x60e3, 0xc1c6, 0x93ad, 0x377b, 0x6ef6, 0xddec, 0xabf9)},
    {TABLE(0x47d3, 0x8fa6, 0x0f6d, 0x1eda, 0x3db4, 0x7b68, 0xf6d0, 0xfd81)},
};

/* i(x) x^24 mod the CRC-24Q generator. */
static const uint32_t slice24[256] = {
    TABLE(0x864cfb, 0x8ad50d, 0x93e6e1, 0xa18139, 0xc54e89, 0x0cd1e9, 0x19a3d2, 0x3347a4)};

static uint16_t step(uint16_t crc, uint8_t byte)
{
	return (uint16_t)(slice[0][(crc >> 8) ^ byte] ^ (unsigned)crc << 8);
}

uint16_t fw_crc16_portable(uint16_t crc, const void *bytes, size_t n)
{
	const uint8_t *p = bytes;

	for (; n >= 8; p += 8, n -= 8)
		crc = slice[7][p[0] ^ crc >> 8] ^ slice[6][p[1] ^ (crc & 0xff)] ^ slice[5][p[2]] ^
		      slice[4][p[3]] ^ slice[3][p[4]] ^ slice[2][p[5]] ^ slice[1][p[6]] ^ slice[0][p[7]];
	while (n-- > 0)
		crc = step(crc, *p++);
	return crc;
}

#if defined(__x86_64__)

#define CLMUL __attribute__((target("pclmul,sse4.1")))

/* x^(128 k) and x^(128 k + 64) mod P: they carry the two halves of a 16-byte piece over the k pieces
 * behind it. */
static const uint64_t fold[9][2] = {
    {0x0001, 0xb861}, {0xaefc, 0x650b}, {0x8e29, 0x26aa}, {0xcde2, 0x2535}, {0x13fc, 0x8832},
    {0xda35, 0x87b3}, {0x106f, 0x0447}, {0xcbc5, 0xd24c}, {0x36c4, 0x71c4},
};

CLMUL static inline __m128i carry(__m128i v, size_t k)
{
	const __m128i f = _mm_loadu_si128((const __m128i *)fold[k]);

	return _mm_xor_si128(_mm_clmulepi64_si128(v, f, 0x00), _mm_clmulepi64_si128(v, f, 0x11));
}

/* acc followed by n (1 .. 8) pieces of 16 bytes, as a polynomial of degree below 80. The products do not
 * depend on one another, so they overlap; one multiplication per eight pieces is all the waiting there is. */
CLMUL static inline __m128i add_pieces(__m128i acc, const uint8_t *p, size_t n)
{
	const __m128i reverse = _mm_set_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);

	acc = carry(acc, n);
	for (size_t i = 0; i < n; i++) {
		const __m128i piece = _mm_loadu_si128((const __m128i *)(p + 16 * i));

		acc = _mm_xor_si128(acc, carry(_mm_shuffle_epi8(piece, reverse), n - 1 - i));
	}
	return acc;
}

/* v(x) x^16 mod P for a v of degree below 80: 16 bits folded onto the rest, then Barrett's division with
 * floor(x^80 / P) = x^64 + 0x11303471a041b343. */
CLMUL static inline uint16_t reduce(__m128i v)
{
	const __m128i constants = _mm_set_epi64x(0x11303471a041b343, 0xb861);
	const __m128i w = _mm_xor_si128(v, _mm_clmulepi64_si128(v, constants, 0x01));
	const __m128i high = _mm_srli_si128(_mm_clmulepi64_si128(w, constants, 0x10), 8);
	const __m128i quotient = _mm_xor_si128(high, w);
	const __m128i product = _mm_clmulepi64_si128(quotient, _mm_cvtsi32_si128(0x1021), 0x00);

	return (uint16_t)_mm_cvtsi128_si32(product);
}

/* CRC-16 of n >= 16 bytes. What n has beyond a multiple of 16 goes first: zeros in front change nothing. */
CLMUL static uint16_t crc16_clmul(const uint8_t *p, size_t n)
{
	static const uint8_t select[32] = {15,  14,  13,  12,  11,  10,  9,   8,   7,   6,   5,
	                                   4,   3,   2,   1,   0,   128, 128, 128, 128, 128, 128,
	                                   128, 128, 128, 128, 128, 128, 128, 128, 128, 128};
	const size_t odd = n % 16, pieces = n / 16 % 8;
	const __m128i mask = _mm_loadu_si128((const __m128i *)(select + 16 - odd));
	__m128i acc = _mm_shuffle_epi8(_mm_loadu_si128((const __m128i *)p), mask);

	p += odd;
	if (pieces > 0)
		acc = add_pieces(acc, p, pieces);
	p += 16 * pieces;
	for (size_t left = n / 128; left > 0; left--, p += 128)
		acc = add_pieces(acc, p, 8);
	return reduce(acc);
}

uint16_t fw_crc16(const void *bytes, size_t n)
{
	if (n >= 16 && __builtin_cpu_supports("pclmul") && __builtin_cpu_supports("sse4.1"))
		return crc16_clmul(bytes, n);
	return fw_crc16_portable(0, bytes, n);
}

#else

uint16_t fw_crc16(const void *bytes, size_t n)
{
	return fw_crc16_portable(0, bytes, n);
}

#endif

void fw_crc16_prefix(uint16_t crc, const uint8_t *bytes, size_t n, uint16_t *state)
{
	state[0] = crc;
	for (size_t i = 0; i < n; i++)
		state[i + 1] = step(state[i], bytes[i]);
}

/* a(x) b(x) mod P. */
static uint16_t multiply(uint16_t a, uint16_t b)
{
	uint32_t product = 0;

	for (unsigned i = 0; i < 16; i++)
		product ^= ((uint32_t)a << i) & (0u - ((uint32_t)b >> i & 1u));
	return (uint16_t)(slice[1][product >> 24] ^ slice[0][product >> 16 & 0xff] ^ product);
}

/* The register crc after n zero bytes, crc(x) x^(8n) mod P; power[k][i] = x^(8 i 16^k). */
static uint16_t advance(uint16_t crc, size_t n)
{
	static const uint16_t power[4][16] = {
	    {0x0001, 0x0100, 0x1021, 0x3331, 0x3730, 0x76b4, 0xaa51, 0x45a0, 0xb861, 0x47d3, 0xeb23, 0x6f45,
	     0xd849, 0x0375, 0x4563, 0x7b61},
	    {0x0001, 0xaefc, 0x8e29, 0xcde2, 0x13fc, 0xda35, 0x106f, 0xcbc5, 0x36c4, 0x400c, 0x30df, 0x0a5d,
	     0x2764, 0x0224, 0x46cf, 0x6d5a},
	    {0x0001, 0xfd50, 0xaa9e, 0x26bd, 0x881c, 0x21ec, 0xdb20, 0x2473, 0x4458, 0x8807, 0x88b5, 0x385c,
	     0x21ef, 0xccf1, 0xcbf0, 0x2f9f},
	    {0x0001, 0x0002, 0x0004, 0x0008, 0x0010, 0x0020, 0x0040, 0x0080, 0x0100, 0x0200, 0x0400, 0x0800,
	     0x1000, 0x2000, 0x4000, 0x8000},
	};

	for (size_t k = 0; n > 0; k++, n >>= 4)
		crc = multiply(crc, power[k % 4][n & 15]);
	return crc;
}

uint16_t fw_crc16_range(uint16_t before, uint16_t after, size_t n)
{
	return (uint16_t)(advance(before, n % 65536) ^ after);
}

uint16_t fw_crc16_update(uint16_t crc, const void *bytes, size_t n)
{
	const uint8_t *p = bytes;

	for (; n > 65535; p += 65535, n -= 65535)
		crc = (uint16_t)(advance(crc, 65535) ^ fw_crc16(p, 65535));
	return (uint16_t)(advance(crc, n) ^ fw_crc16(p, n));
}

static uint32_t step24(uint32_t crc, const uint8_t *bytes, size_t bit)
{
	const uint32_t next = (uint32_t)bytes[bit / 8] >> (7 - bit % 8) & 1u;
	const uint32_t out = crc >> 23 ^ next;

	return (crc << 1 & 0xffffff) ^ (out != 0 ? 0x864cfb : 0);
}

uint32_t fw_crc24q_bits(const uint8_t *bytes, size_t first_bit, size_t n_bits)
{
	const size_t end = first_bit + n_bits;
	uint32_t crc = 0;
	size_t bit = first_bit;

	for (; bit < end && bit % 8 != 0; bit++)
		crc = step24(crc, bytes, bit);
	for (; end - bit >= 8; bit += 8)
		crc = (crc << 8 & 0xffffff) ^ slice24[crc >> 16 ^ bytes[bit / 8]];
	for (; bit < end; bit++)
		crc = step24(crc, bytes, bit);
	return crc;
}
