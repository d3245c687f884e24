/* Increments to rates: the interval that an increment spans. */
#ifndef FURROW_FORMATS_IMU_RATES_H
#define FURROW_FORMATS_IMU_RATES_H

#include <stdint.h>

#include "base/status.h"
#include "base/time.h"

/* Zeroed at the beginning of a log. */
typedef struct {
	int n;          /* samples so far, up to 2 */
	fw_time last;   /* the last one's time */
	double usual_s; /* the usual interval */
	int odd;        /* intervals in a row that were not usual */
} fw_imu_rates;

/* The interval [s] that the increments at time t span: the time since the sample before or, after a gap (more
 * than 1.5 of the usual interval), the usual one, because a sample that is not in the log took its share with
 * it. When five intervals in a row are longer than usual, the rate has changed.
 * Returns FW_OK; FW_MORE: the first sample, its interval is not known; FW_ERANGE: t is not after the last
 * one, which stays the last. *dt_s untouched unless FW_OK. */
fw_status fw_imu_rates_interval(fw_imu_rates *r, fw_time t, double *dt_s) FW_MUST_CHECK;

#endif
