/* RINEX 3.04 observation files from records. (Navigation files: rinex_write_nav.h.)
 *
 * A RINEX header says what is in the file: which observables of which systems, from when to when. So writing
 * takes two passes over the records: a survey of all of them first, then the files. (Somebody who knows
 * beforehand what will come, such as a simulator, may put one epoch of it into the survey, and the last one.)
 *
 * Observations of a satellite need not stand together within an epoch, but epochs must come one after the
 * other. The loss-of-lock bit is set where lock_s has gone back, or is shorter than the time since the
 * signal's last observation, or is 0; bit 1 where half_cycle is set. Signal strength digits are left blank (S
 * observables say it better). Events become epochs with flag 5. The header's date is the last epoch's: the
 * same records make the same file.
 *
 * Source: RINEX 3.04 (2018), appendix, tables A2, A3, A5 to A18. */
#ifndef FURROW_FORMATS_RINEX_WRITE_H
#define FURROW_FORMATS_RINEX_WRITE_H

#include <stdbool.h>

#include "formats/record.h"
#include "formats/rinex_obs.h"
#include "formats/rinex_out.h"
#include "furrow_klobuchar.h"
#include "furrow_nequick.h"
#include "furrow_utc.h"
#include "gnss/signal.h"

enum {
	FW_RINEX_ANTENNAS = 3,      /* main, aux1, aux2: a file each */
	FW_RINEX_BANDS = 10,        /* digits of bands */
	FW_RINEX_ATTRIBUTES = 26,   /* letters of attributes */
	FW_RINEX_EPOCH_ROWS = 2048, /* signals of an epoch; further ones are refused */
};

/* What the records of a log say that headers need. Owned by the caller. */
typedef struct {
	/* By antenna, system, band, attribute: bit 0 code, 1 carrier, 2 Doppler, 3 C/N0 */
	uint8_t seen[FW_RINEX_ANTENNAS][FW_SYSTEM_COUNT][FW_RINEX_BANDS][FW_RINEX_ATTRIBUTES];
	bool has_antenna[FW_RINEX_ANTENNAS];
	bool timed;          /* first and last are set */
	fw_time first, last; /* of observations */
	int64_t interval_ns; /* the shortest between epochs; 0: not known */
	bool has_navigation;
	fw_rinex_header facts; /* names, position, antenna, GLONASS frequency numbers, leap seconds */
	furrow_klobuchar klobuchar[FW_SYSTEM_COUNT]; /* present 0: none */
	furrow_utc utc[FW_SYSTEM_COUNT];
	furrow_nequick nequick;
} fw_rinex_survey;

/* Begin a survey, and take a record into account: the `put` of a fw_sink whose context is the survey. Takes
 * obs, setup, pvt (an approximate position where setup has none), eph_* (which satellites' frequency
 * numbers), klobuchar, nequick and utc; others are passed over. */
void fw_rinex_survey_begin(fw_rinex_survey *s);
void fw_rinex_survey_put(void *survey, fw_kind kind, const void *record);

/* ---- observations ---- */

/* A signal's measurements of the epoch at hand. */
typedef struct {
	uint8_t system, number, band, attribute; /* digit; letter - 'A' */
	uint8_t has;                             /* as fw_rinex_survey.seen */
	uint8_t lli;
	double value[4];
} fw_rinex_row;

/* About 2 MB, owned by the caller. */
typedef struct {
	/* Public to read. */
	fw_rinex_out out; /* out.status: FW_OK, or the first failure of the output */
	uint64_t epochs;  /* written */
	uint64_t
	    refused; /* observations left out: no time, satellite or signal that RINEX or the survey knows */

	/* Private from here. */
	const fw_rinex_survey *survey;
	int antenna;
	int n_columns[FW_SYSTEM_COUNT];
	int16_t column[FW_SYSTEM_COUNT][FW_RINEX_BANDS]
	              [FW_RINEX_ATTRIBUTES]; /* of the first observable of a signal */
	struct {
		int64_t ns; /* of the last observation; 0: none */
		int32_t lock_s;
	} last[FW_SYSTEM_COUNT][FW_SATELLITES_PER_SYSTEM][FW_RINEX_BANDS][FW_RINEX_ATTRIBUTES];
	fw_time time; /* of the epoch at hand */
	int n_rows;
	fw_rinex_row rows[FW_RINEX_EPOCH_ROWS];
} fw_rinex_obs_writer;

/* Writes the header.
 *   survey   in  of all records; must stay until the end
 *   antenna  in  0 main, 1 aux1, 2 aux2: whose observations are wanted
 *   output, context  in  gets the text, some 64 KiB at a time
 * Cannot fail: an output that fails shows in w->out.status. */
void fw_rinex_obs_write(fw_rinex_obs_writer *w, const fw_rinex_survey *survey, int antenna, fw_output *output,
                        void *context);

/* Write a record, obs or event: the `put` of a fw_sink whose context is the writer. Other kinds are passed
 * over. */
void fw_rinex_obs_put(void *writer, fw_kind kind, const void *record);

/* Writes what is left. Returns w->out.status. */
fw_status fw_rinex_obs_end(fw_rinex_obs_writer *w) FW_MUST_CHECK;

#endif
