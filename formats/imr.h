/* Waypoint (Inertial Explorer) IMR files as `imu` records: a header of 512 bytes, then 32 bytes per sample.
 *
 * Rates or increments and the scale factors are those of the header; the axes are RFU unless the plan says
 * otherwise. Times are seconds of the GPS week; the file does not say of which week, so the plan has to.
 * Increments become rates as in formats/imu_text.h. Files of big-endian machines and files on UTC are
 * refused.
 *
 *     header  0 c8 "$IMURAW"; 8 i1 byte order; 17 i4 gyro increments; 21 i4 accelerometer increments;
 *             33 f8 gyro scale; 41 f8 accelerometer scale; 49 i4 1 UTC, else GPS; 57 f8 bias of the times [s]
 *     sample  0 f8 time [s]; 8 i4 gyro x, y, z [deg or deg/s]; 20 i4 accelerometer x, y, z [m/s or m/s^2]
 *
 * Source: Waypoint's IMR header as five independent readers and writers have it. */
#ifndef FURROW_FORMATS_IMR_H
#define FURROW_FORMATS_IMR_H

#include "formats/imu_columns.h"
#include "formats/imu_rates.h"
#include "formats/log_records.h"
#include "formats/window.h"

/* An IMR file, by its first 8 bytes. */
bool fw_imr_detect(const uint8_t *bytes, size_t n);

/* About 260 KiB, owned by the caller; must not be moved once begun. */
typedef struct {
	/* Public to read. */
	uint64_t rows;        /* samples read */
	uint64_t lost;        /* samples refused */
	uint64_t lost_offset; /* where the last of them was [bytes] */
	const char *reason;   /* and what was wrong */

	/* Private from here. */
	fw_imu_axes axes;
	fw_imu_clock clock;
	fw_status final;
	bool begun;
	bool gyro_increments, accel_increments;
	double gyro_scale, accel_scale, bias_s;
	fw_imu_rates rates;
	fw_log_queue queue;
	fw_window window;
} fw_imr;

/* Begin to read.
 *   plan  in  axes (RFU where nothing was said) and the week */
void fw_imr_begin(fw_imr *r, fw_input *input, const fw_imu_plan *plan);

/* The next record. Returns FW_OK; FW_ESYNTAX: a sample is lost; FW_EOF; FW_EUNKNOWN: a header with which
 * nothing can be done, r->reason says why; FW_ETRUNCATED; FW_EIO, FW_EFORMAT, FW_ENOMEM from fw_input_read().
 * All but the first two are final. */
fw_status fw_imr_read(fw_imr *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

#endif
