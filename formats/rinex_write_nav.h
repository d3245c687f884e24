/* RINEX 3.04 navigation files from records.
 *
 * One entry per eph_* record; of entries with the same content (decoded by the receiver and by furrow) the
 * first. klobuchar, nequick and utc stand in the header, the last of each system: the survey of rinex_write.h
 * has them.
 *
 * Source: RINEX 3.04 (2018), appendix, tables A5 to A18. */
#ifndef FURROW_FORMATS_RINEX_WRITE_NAV_H
#define FURROW_FORMATS_RINEX_WRITE_NAV_H

#include "formats/rinex_out.h"
#include "formats/rinex_write.h"

typedef struct {
	/* Public to read. */
	fw_rinex_out out;  /* out.status: FW_OK, or the first failure of the output */
	uint64_t entries;  /* written */
	uint64_t repeated; /* left out because they were there already */
	uint64_t refused;  /* left out because they have no time, or no satellite that RINEX knows */

	/* Private from here. */
	int64_t last[FW_SYSTEM_COUNT][FW_SATELLITES_PER_SYSTEM]
	            [2]; /* what stands for the content written last */
} fw_rinex_nav_writer;

/* Writes the header. Arguments and conditions as fw_rinex_obs_write(). */
void fw_rinex_nav_write(fw_rinex_nav_writer *w, const fw_rinex_survey *survey, fw_output *output,
                        void *context);

/* Write a record, eph_gps, eph_gal, eph_bds, eph_glo or eph_sbas: the `put` of a fw_sink whose context is the
 * writer. Other kinds are passed over. Absent columns are blank. */
void fw_rinex_nav_put(void *writer, fw_kind kind, const void *record);

/* Writes what is left. Returns w->out.status. */
fw_status fw_rinex_nav_end(fw_rinex_nav_writer *w) FW_MUST_CHECK;

#endif
