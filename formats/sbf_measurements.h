/* The measurement blocks of SBF: MeasEpoch (4027) and MeasExtra (4000) to records, and MeasEpoch from records.
 *
 * Source: Septentrio SBF reference guides, section "Measurement Blocks"; RINEX codes by sbf_signal.h.
 * A block is passed whole, header included, its CRC checked; `length` is its length. Counts and sub-block lengths
 * are taken from the block and held against `length`: sub-blocks that do not fit are left out. */
#ifndef FURROW_FORMATS_SBF_MEASUREMENTS_H
#define FURROW_FORMATS_SBF_MEASUREMENTS_H

#include <stdbool.h>
#include <stdint.h>

#include "furrow_epoch.h"
#include "furrow_obs.h"
#include "formats/record.h"

/* Which satellite a receiver channel tracks: MeasEpoch tells, MeasExtra of the same epoch needs it. */
typedef struct {
	uint32_t tow_ms;
	uint16_t week;
	bool e6b; /* E6 signals are E6B */
	const char *satellite[256];
} fw_sbf_channels;

/* Observations that were left out. */
typedef struct {
	uint64_t other_antenna; /* not wanted */
	uint64_t unnamed;       /* of satellites without a name: GLONASS of unknown slot */
} fw_sbf_left_out;

/* The antennas whose observations are wanted: bit 0 main, 1 aux1, 2 aux2. */
enum { FW_ANTENNA_MAIN = 1, FW_ANTENNA_AUX1 = 2, FW_ANTENNA_AUX2 = 4, FW_ANTENNA_ALL = 255 };

/* Whether a MeasEpoch block holds scrambled measurements (CommonFlags bit 7), which only Septentrio can read. */
int fw_sbf_is_scrambled(const uint8_t *block, uint16_t length);

/* Emits `epoch` and one `obs` per satellite and signal of a MeasEpoch block, each kind only if it is in `wanted`,
 * and notes the channels; of a scrambled block only the epoch. Adds to *left_out what was left out. */
void fw_sbf_meas_epoch(const uint8_t *block, uint16_t length, unsigned antennas, const fw_kind_set *wanted,
                       fw_sink sink, fw_sbf_channels *channels, fw_sbf_left_out *left_out);

/* Emits one `obs_extra` per satellite and signal of a MeasExtra block. */
void fw_sbf_meas_extra(const uint8_t *block, uint16_t length, unsigned antennas,
                       const fw_sbf_channels *channels, fw_sink sink);

/* Writes a MeasEpoch block (revision 1, CRC included) that holds the epoch and n observations; those of one
 * satellite and antenna stand together, the first becomes Type1, the others Type2. `block` has room for
 * FW_SBF_MAX_LENGTH bytes. Values are rounded to the wire's resolution (1 mm, 0.001 cycle, 0.0001 Hz, 0.25 dB-Hz);
 * absent ones become do-not-use. Returns FW_EUNKNOWN for a satellite or signal that SBF cannot name, FW_ERANGE for
 * a value that the wire cannot hold or more observations than a block holds; *length untouched. */
fw_status fw_sbf_encode_meas_epoch(const furrow_epoch *epoch, const furrow_obs *obs, unsigned n,
                                   uint8_t *block, uint16_t *length) FW_MUST_CHECK;

#endif
