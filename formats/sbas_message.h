/* SBAS messages of the L1 signal, 250 bits each, to records and back.
 *
 * A message lies in 32 bytes: bit 0, the first one sent, is the most significant bit of byte 0; the last six
 * bits of byte 31 are not part of it. Bits 0-7 are one of three preambles in turn, 8-13 the type, 226-249 the
 * CRC-24Q of all before.
 *
 * Decoding gives what a receiver's own decoder gives: the records, units and left-out places of Septentrio's
 * blocks GEOMT00, GEOPRNMask, GEOFastCorr, GEOIntegrity, GEOFastCorrDegr, GEONav, GEODegrFactors,
 * GEONetworkTime, GEOAlm, GEOIGPMask, GEOLongTermCorr, GEOIonoDelay, GEOServiceLevel and GEOClockEphCovMatrix,
 * with source "raw". Nothing is looked up in an earlier message: mask numbers stay mask numbers.
 *
 *   type      records                      one per
 *   0         sbas_mt0, and sbas_fast      message; satellite, when the message is not empty ("type 0/2")
 *   1         sbas_mask                    satellite in the mask; mask_sat absent for a number without a name
 *   2-5       sbas_fast                    satellite, 13 (type 5: 12)
 *   6         sbas_integrity               satellite, 51
 *   7         sbas_degradation             satellite, 51
 *   9         eph_sbas                     message
 *   10        sbas_factors                 message
 *   12        sbas_time                    message
 *   17        sbas_almanac                 satellite, 0 to 3; `sat` is the satellite whose almanac it is
 *   18        sbas_igp_mask                grid point in the mask
 *   24        sbas_fast, sbas_long         satellite, 6 and 0 to 2
 *   25        sbas_long                    satellite, 0 to 4; without rates (velocity code 0) they are 0
 *   26        sbas_iono                    grid point, 15; none beyond 201, the last that a mask can have
 *   27        sbas_service                 region, 0 to 5
 *   28        sbas_cov                     satellite, 0 to 2
 *   62, 63    none
 *
 * Sources: RTCA DO-229, appendix A; SBF reference guide, "SBAS L1 Decoded Message Blocks".
 * Tested by tests/unit/test_sbas_message.c. */
#ifndef FURROW_FORMATS_SBAS_MESSAGE_H
#define FURROW_FORMATS_SBAS_MESSAGE_H

#include <stdint.h>

#include "formats/record.h"

enum { FW_SBAS_BYTES = 32, FW_SBAS_BITS = 250 };

/* Decodes a message and puts its records into the sink, in the order of the bits.
 *   message    in  the 250 bits
 *   satellite  in  GEO that sent it ("S123"), or NULL: column absent; the records point to it
 *   stamp      in  time of the records, with its bits of presence: GPS time of the END of the message, as SBF
 *                  stamps it, 1 s after the start. It also tells the day that an almanac's time belongs to;
 *                  the almanac's toa_s is absent without it.
 * Returns FW_OK (types 62 and 63 among them); nothing put: FW_EFORMAT (no preamble), FW_ECHECKSUM,
 * FW_EUNKNOWN (a type that is not in the list above). */
fw_status fw_sbas_decode(const uint8_t message[static FW_SBAS_BYTES], const char *satellite,
                         const fw_record_head *stamp, fw_sink sink) FW_MUST_CHECK;

/* The inverse, in three steps: begin, add the records that fw_sbas_decode is to give back, finish.
 *
 * begin: preamble, type, and zeros for all the rest.
 *   type     in   0..63
 *   start_s  in   GPS time at which the message starts, in seconds of the week: every third second, 0 among
 *                 them, carries the first preamble
 *   message  out  FW_SBAS_BYTES bytes
 * Returns FW_OK or FW_EINVAL (type): message untouched. */
fw_status fw_sbas_begin(unsigned type, unsigned start_s, uint8_t message[static FW_SBAS_BYTES]) FW_MUST_CHECK;

/* add: one record, values rounded to the wire's resolution. Where the record belongs is told by its mask
 * number or satellite, otherwise it takes the first place that is free; what the message holds once for all
 * (issues of data, the block of types 24 and 26) is that of the record added last. A place without a record
 * stays zero bits, which in types 0, 2-6, 24 and 26 is good health: add all of these. Absent columns count
 * as 0.
 *   kind, record  in      a record as in the list above
 *   message       in/out  begun
 * Returns FW_OK; FW_EINVAL (no such record in this type, or its mask number or satellite is not one that the
 * message can carry), FW_ENOSPACE (all places taken), FW_ERANGE (a value does not fit its bits, or is not
 * finite): message untouched. */
fw_status fw_sbas_add(fw_kind kind, const void *record, uint8_t message[static FW_SBAS_BYTES]) FW_MUST_CHECK;

/* finish: the CRC, and zeros in the six bits behind it. Never fails. */
void fw_sbas_finish(uint8_t message[static FW_SBAS_BYTES]);

#endif
