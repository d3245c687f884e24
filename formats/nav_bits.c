#include "formats/nav_bits.h"

uint32_t fw_bits_unsigned(const uint8_t *bytes, size_t n, unsigned first, unsigned width)
{
	const size_t end = (size_t)first + width;
	uint64_t bits = 0; /* at most five bytes: 32 bits that begin inside a byte */

	if (width == 0)
		return 0;
	for (size_t i = first / 8; i <= (end - 1) / 8; i++)
		bits = bits << 8 | (i < n ? bytes[i] : 0);
	bits >>= 7 - (end - 1) % 8;
	return (uint32_t)(bits & (UINT64_C(0xffffffff) >> (32 - width)));
}

int64_t fw_bits_twos_complement(uint32_t raw, unsigned width)
{
	const int64_t sign = INT64_C(1) << (width - 1);
	return (int64_t)(raw ^ (uint32_t)sign) - sign;
}

double fw_bits_sign_magnitude(uint32_t raw, unsigned width)
{
	const uint32_t sign = UINT32_C(1) << (width - 1);
	const double magnitude = raw & (sign - 1);
	return raw & sign ? -magnitude : magnitude;
}

void fw_bits_append(uint8_t *bytes, size_t n, size_t *used, uint32_t value, unsigned width)
{
	while (width > 0 && *used / 8 < n) {
		const unsigned room = 8 - (unsigned)(*used % 8), take = width < room ? width : room;
		const uint32_t piece = value >> (width - take) & ((1U << take) - 1);
		bytes[*used / 8] |= (uint8_t)(piece << (room - take));
		*used += take;
		width -= take;
	}
	*used += width;
}

void fw_bits_clear(uint8_t *bytes, size_t n, unsigned first, unsigned width)
{
	for (size_t bit = first; bit < (size_t)first + width && bit / 8 < n; bit++)
		bytes[bit / 8] &= (uint8_t) ~(0x80U >> bit % 8);
}
