/* Records to SBF blocks: the inverse of sbf_records.h, through the same plans. */
#ifndef FURROW_FORMATS_SBF_BUILD_H
#define FURROW_FORMATS_SBF_BUILD_H

#include "formats/sbf_records.h"

/* Writes the block that becomes these records.
 *   id        in   block number
 *   revision  in   0..7, for the header; all known fields are written whatever it says
 *   records   in   n pointers to records of the block's kind, n >= 1. The first gives the stamp and the fixed part;
 *                  in a block with sub-blocks each gives one, unless all of that sub-block's columns are absent.
 *   block     out  room for FW_SBF_MAX_LENGTH bytes
 *   length    out  of the block [bytes]
 * Absent columns become the do-not-use value, or 0 where the format has none; fields without a column become 0.
 * Numbers are rounded to the wire's resolution and kept inside its range.
 * Returns FW_OK; FW_EUNKNOWN: the block has no record, or one that its table alone cannot write (measurements,
 * PVTSatCartesian, PVTResiduals, ExtSensorMeas, Comment); FW_EINVAL: n is 0, a fixed number of sub-blocks is not met,
 * or the revision; FW_ENOSPACE: more records than the block can count or hold. *length untouched on error. */
fw_status fw_sbf_build(const fw_sbf_plans *plans, uint16_t id, uint8_t revision, const void *const *records,
                       size_t n, uint8_t *block, uint16_t *length) FW_MUST_CHECK;

#endif
