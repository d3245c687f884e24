/* Text tables of sensor data: IMU, magnetometer, barometer, GNSS positions and somebody's reference, in any
 * columns. What they mean is said by a plan, formats/imu_columns.h, which is also where the columns and
 * layouts are documented.
 *
 * Fields are separated by commas, semicolons, tabs or blanks: found from the first line of data. Lines that
 * begin with #, % or // are comments; the last line before the data that is not all numbers has the columns'
 * names. An empty field and "nan" are no value; a line of which part of an IMU sample, of a magnetic field or
 * of a position is missing is refused as a whole, and so is one that has no value at all.
 *
 * Increments become rates by the time since the line before; after a gap (more than 1.5 of the usual
 * interval) by the usual one, since they span no more. The first line of increments has no interval and gives
 * no record; nor does one whose time does not advance. */
#ifndef FURROW_FORMATS_IMU_TEXT_H
#define FURROW_FORMATS_IMU_TEXT_H

#include "formats/boot_clock.h"
#include "formats/imu_columns.h"
#include "formats/imu_rates.h"
#include "formats/log_records.h"
#include "formats/rinex.h"

/* The file could be read without a plan: EuRoC by its header. n bytes of the file's beginning. */
bool fw_imu_text_detect(const uint8_t *bytes, size_t n);

/* What was wrong, for a message "FILE:LINE: column COLUMN (NAME): REASON". */
typedef struct {
	uint64_t line;
	int column;         /* from 1; 0: the line as a whole */
	const char *name;   /* of the entry: "gx"; "" */
	const char *reason; /* a few words of English */
} fw_imu_text_problem;

/* About 300 KiB, owned by the caller; must not be moved once begun. */
typedef struct {
	/* Public to read. */
	fw_imu_text_problem problem; /* why the last fw_imu_text_read() failed */
	uint64_t rows;               /* lines that gave a record */
	uint64_t lost;               /* lines refused */
	uint64_t untimed;            /* lines left out because the clock was not set yet */
	uint64_t passed_over;        /* lines of kinds that the plan does not name */

	/* Private from here. */
	fw_imu_plan plan;
	fw_lines lines;
	fw_log_queue queue;
	fw_boot_clock clock;
	fw_status final;
	bool surveying, begun, is_euroc;
	uint64_t overlong;
	char separator; /* ' ': blanks */
	int column[FW_IMU_NAMES];
	char header[FW_RINEX_LINE_MAX];
	size_t n_header;
	bool has_last; /* a line with GPS time was there: */
	fw_time last;  /* the week of the next is the one nearest to it */
	fw_imu_rates rates;
	bool has_fix;
	double last_fix[7]; /* fixtime, position, velocity: to see whether they are new */
} fw_imu_text;

/* Begin to read.
 *   input  in  open, nothing read; read to its end, the caller closes it
 *   plan   in  copied; NULL: the file's own header says it all (EuRoC) */
void fw_imu_text_begin(fw_imu_text *r, fw_input *input, const fw_imu_plan *plan);

/* Whether the plan needs two readings: its clock is set by the positions in the file. */
bool fw_imu_text_wants_survey(const fw_imu_text *r);

/* First reading of two: learns the clock, to the end of the input. Then open the input anew and call
 * fw_imu_text_again(). Returns FW_EOF, or what ended it early as fw_imu_text_read(). */
fw_status fw_imu_text_survey(fw_imu_text *r) FW_MUST_CHECK;
void fw_imu_text_again(fw_imu_text *r, fw_input *input);

/* The next record.
 * Returns
 *   FW_OK        a record
 *   FW_ESYNTAX   a line is lost: r->problem says why; call again
 *   FW_EOF       the end
 *   FW_EUNKNOWN  nothing can be done with this table (r->problem): a column that its header does not have, no
 *   week, no
 *                scale; final
 *   FW_ETRUNCATED, FW_EIO, FW_EFORMAT, FW_ENOMEM   from fw_input_read(); final
 * kind and record are set with FW_OK only. */
fw_status fw_imu_text_read(fw_imu_text *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

#endif
