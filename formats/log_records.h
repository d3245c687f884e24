/* What the readers of other people's logs have in common: a few records that wait to be handed out, and the
 * ways to fill them.
 *
 * One line or message of such a log may hold an IMU sample, a magnetic field, a height and a position at
 * once; it becomes as many records, and they go out one by one. A record whose time is no GPS time, or one of
 * whose main numbers is not finite, is never made. */
#ifndef FURROW_FORMATS_LOG_RECORDS_H
#define FURROW_FORMATS_LOG_RECORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/time.h"
#include "formats/record.h"

enum { FW_LOG_QUEUE_MAX = 8 };

/* Records that wait. Owned by a reader; zeroed is empty. */
typedef struct {
	int first, n;
	fw_kind kind[FW_LOG_QUEUE_MAX];
	fw_any_record record[FW_LOG_QUEUE_MAX];
} fw_log_queue;

/* A position fix. NaN means "not known", in every member; a fix without latitude, longitude or height has
 * none. */
typedef struct {
	double lat_deg, lon_deg, height_m, undulation_m;
	double velocity_mps[3];    /* north, east, down */
	double sd_m[3];            /* north, east, down */
	double sd_velocity_mps[3]; /* north, east, down */
	int mode;   /* of pvt: 0 none, 1 stand-alone, 2 differential, 4 fixed, 5 float, 6 SBAS, ... */
	bool two_d; /* of pvt: height held */
	int n_sats; /* -1: not known */
} fw_log_fix;

/* A position, velocity and attitude that somebody else found. NaN means "not known". */
typedef struct {
	double lat_deg, lon_deg, height_m;
	double velocity_mps[3]; /* north, east, down */
	double angle_deg[3];    /* roll, pitch, heading */
} fw_log_nav;

/* A fix, and a nav, of which nothing is known. */
fw_log_fix fw_log_no_fix(void);
fw_log_nav fw_log_no_nav(void);

/* Append a record to the queue.
 *   t      in  its time
 *   gyro, accel  in  angular rate [rad/s], specific force [m/s^2], body FRD
 *   field  in  magnetic field [uT], body FRD
 * Returns FW_OK; FW_ENONFINITE (a number that has to be there is not finite) or FW_ERANGE (the time is
 * outside weeks 0..8191, the latitude or longitude outside the Earth, the number of satellites no int16):
 * nothing appended. FW_ENOSPACE: the queue is full. Of fix, nav: what is NaN stays absent; infinite is not
 * known either. */
fw_status fw_log_put_imu(fw_log_queue *q, fw_time t, const double gyro[static 3],
                         const double accel[static 3]) FW_MUST_CHECK;
fw_status fw_log_put_mag(fw_log_queue *q, fw_time t, const double field[static 3]) FW_MUST_CHECK;
fw_status fw_log_put_baro(fw_log_queue *q, fw_time t, double height_m) FW_MUST_CHECK;

/* A fix as pvt, the receiver's own; mode 0 needs no position. */
fw_status fw_log_put_pvt(fw_log_queue *q, fw_time t, const fw_log_fix *fix) FW_MUST_CHECK;

/* A fix as pos. `quality` is constant storage or NULL: not known; NaN ratio: not known. */
fw_status fw_log_put_pos(fw_log_queue *q, fw_time t, const fw_log_fix *fix, const char *quality,
                         double ratio) FW_MUST_CHECK;

/* `status` is constant storage or NULL. FW_ENONFINITE: neither position nor velocity nor attitude is whole.
 * */
fw_status fw_log_put_nav(fw_log_queue *q, fw_time t, const fw_log_nav *nav, const char *status) FW_MUST_CHECK;

/* An event at GNSS time t: source 1 is EventA. */
fw_status fw_log_put_event(fw_log_queue *q, fw_time t, int source) FW_MUST_CHECK;

/* The next record that waits. Returns FW_OK; FW_MORE: none, kind and record untouched. */
fw_status fw_log_take(fw_log_queue *q, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

/* Horizontal accuracy as receivers give it, sqrt(sd_n^2 + sd_e^2), to the deviation of each of the two. */
double fw_log_each_of_two(double horizontal);

#endif
