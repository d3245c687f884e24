/* Bit fields of navigation pages: most significant bit first, bit 0 is the first bit sent.
 *
 * All readers are bounded: bits behind the last byte read as zeros, so no page, however it came about, can
 * make them read outside its bytes. None of these functions can fail. */
#ifndef FURROW_FORMATS_NAV_BITS_H
#define FURROW_FORMATS_NAV_BITS_H

#include <stddef.h>
#include <stdint.h>

/* The unsigned number in `width` bits from bit `first` on.
 *   bytes  in  n bytes; bit 0 is the most significant bit of bytes[0]
 *   width  in  0..32; 0 gives 0 */
uint32_t fw_bits_unsigned(const uint8_t *bytes, size_t n, unsigned first, unsigned width);

/* What the lowest `width` bits of `raw` stand for in two's complement. width 1..32. */
int64_t fw_bits_twos_complement(uint32_t raw, unsigned width);

/* What they stand for as a sign bit (1: negative) and a magnitude, as GLONASS writes numbers. A negative zero
 * stays one: receivers hand it on, too. width 2..32. */
double fw_bits_sign_magnitude(uint32_t raw, unsigned width);

/* Appends `width` (0..32) bits to a string of bits; *used counts the bits written so far. Bits that would lie
 * behind the n bytes are dropped. The bytes must have been zero. */
void fw_bits_append(uint8_t *bytes, size_t n, size_t *used, uint32_t value, unsigned width);

/* Sets `width` bits from bit `first` on to zero; bits behind the n bytes are left alone. */
void fw_bits_clear(uint8_t *bytes, size_t n, unsigned first, unsigned width);

#endif
