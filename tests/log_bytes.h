/* Logs of other devices, made byte by byte after their documentation. */
#ifndef FURROW_TESTS_LOG_BYTES_H
#define FURROW_TESTS_LOG_BYTES_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Bytes in the making. */
typedef struct {
	uint8_t bytes[65536];
	size_t n;
} log_bytes;

static inline void put_bytes(log_bytes *b, const void *bytes, size_t n)
{
	if (n > sizeof b->bytes - b->n)
		abort();
	memcpy(b->bytes + b->n, bytes, n);
	b->n += n;
}

/* Little-endian, whatever machine this is. */
static inline void put_le(log_bytes *b, uint64_t value, int width)
{
	for (int i = 0; i < width; i++) {
		const uint8_t byte = (uint8_t)(value >> (8 * i));
		put_bytes(b, &byte, 1);
	}
}

static inline void put_f32(log_bytes *b, float value)
{
	uint32_t bits;
	memcpy(&bits, &value, sizeof bits);
	put_le(b, bits, 4);
}

static inline void put_f64(log_bytes *b, double value)
{
	uint64_t bits;
	memcpy(&bits, &value, sizeof bits);
	put_le(b, bits, 8);
}

/* Text of a fixed length, padded with NUL. */
static inline void put_text(log_bytes *b, const char *text, size_t n)
{
	char padded[64] = {0};
	memcpy(padded, text, strlen(text));
	put_bytes(b, padded, n);
}

#endif
