/* Cyclic redundancy checks: CRC-16/XMODEM (Septentrio SBF) and CRC-24Q (SBAS, Galileo, QZSS, RTCM 3).
 *
 * Both are plain remainders: first value 0, most significant bit first, nothing inverted. That makes them
 * linear, and fw_crc16_range() lives on it: the CRC of any range of bytes from two running CRCs, whatever
 * its length.
 *
 * None of these functions can fail; none keeps any state. */
#ifndef FURROW_FORMATS_CRC_H
#define FURROW_FORMATS_CRC_H

#include <stddef.h>
#include <stdint.h>

/* CRC-16/XMODEM of n bytes, with carry-less multiplication where the processor has it.
 * Generator x^16 + x^12 + x^5 + 1; "123456789" gives 0x31C3 (the check value of the CRC catalogue). */
uint16_t fw_crc16(const void *bytes, size_t n);

/* The same, continued: crc is the CRC of the bytes before these (0 when there are none). */
uint16_t fw_crc16_update(uint16_t crc, const void *bytes, size_t n);

/* The same by tables alone, eight bytes a step: what processors without carry-less multiplication run. */
uint16_t fw_crc16_portable(uint16_t crc, const void *bytes, size_t n);

/* Running CRCs: state[i] = fw_crc16_update(crc, bytes, i) for i = 0 .. n.
 *   state  out  n + 1 values */
void fw_crc16_prefix(uint16_t crc, const uint8_t *bytes, size_t n, uint16_t *state);

/* CRC of the n bytes that lie between two running CRCs, in constant time.
 *   before  running CRC in front of the range
 *   after   running CRC at its end
 *   n       length of the range, below 65,536 */
uint16_t fw_crc16_range(uint16_t before, uint16_t after, size_t n);

/* CRC-24Q of n_bits bits from bit first_bit on; bit 0 is the most significant bit of bytes[0].
 * Generator 0x1864CFB (RTCA DO-229 A.4.3.3, IS-GPS-200 20.3.5, Galileo OS SIS ICD 5.1.9.4).
 * A message followed by its own CRC gives 0. */
uint32_t fw_crc24q_bits(const uint8_t *bytes, size_t first_bit, size_t n_bits);

#endif
