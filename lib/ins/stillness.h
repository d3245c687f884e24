/* Standing still: told from the IMU, and what the IMU reads meanwhile.
 *
 * An IMU cannot tell rest from smooth straight motion. Where GNSS velocity is there, hand it over too: a
 * vehicle that is known to move is not still, whatever the IMU says. */
#ifndef FURROW_INS_STILLNESS_H
#define FURROW_INS_STILLNESS_H

#include <stdbool.h>

#include "base/status.h"
#include "base/time.h"

/* When an IMU is at rest. Standard deviations and means are over the window, per axis; the noise of the
 * samples is part of the deviations, so fast and noisy IMUs want wider limits. */
typedef struct {
	double window_s;      /* over which it must be quiet before it counts as still */
	double gyro_sd_radps; /* largest standard deviation */
	double accel_sd_mps2;
	double gyro_mean_radps; /* largest mean rate, the bias included: |omega| */
	double gravity_mps2;    /* |f| must be near it */
	double gravity_within_mps2;
	double leave;     /* the limits are wider by this factor for staying still, >= 1 */
	double speed_mps; /* GNSS speeds above this, and above 3 sigma, are motion */
} fw_stillness_setup;

/* Good for MEMS IMUs on drones, cars and tractors with the engine off or quiet: 1 s, 0.6 deg/s, 0.15 m/s^2, 3
 * deg/s (an uncalibrated bias is well inside), 9.80665 +- 0.6 m/s^2, 2, 0.3 m/s. */
fw_stillness_setup fw_stillness_defaults(void);

/* Count, means and sums of squared deviations of angular rate and specific force over some time. */
typedef struct {
	double n, seconds;
	double mean[6], squares[6]; /* gyro x, y, z [rad/s], accelerometer x, y, z [m/s^2] */
} fw_stillness_sums;

enum { FW_STILLNESS_BLOCKS = 8 }; /* of a window */

typedef struct {
	fw_stillness_setup setup;
	bool still;
	bool running;            /* a sample has been taken */
	fw_time t;               /* of the last sample */
	fw_time since;           /* while still: when the stretch began */
	fw_time moving_until;    /* GNSS says so */
	int filled, next;        /* blocks in the ring, and where the next one goes */
	fw_stillness_sums block; /* being filled */
	fw_stillness_sums ring[FW_STILLNESS_BLOCKS];
	fw_stillness_sums
	    stretch; /* while still: the window at its begin and all blocks since, the last one excepted */
	fw_stillness_sums held; /* that last one: if motion begins in the next, it may have begun in this */
} fw_stillness;

/* Means over a still stretch. */
typedef struct {
	fw_time since;
	double seconds;                 /* that the means are over */
	double omega_ib_b[3];           /* [rad/s]: less the Earth's rotation it is the gyros' bias */
	double force_b[3];              /* [m/s^2]: for levelling */
	double gyro_sd[3], accel_sd[3]; /* of single samples [rad/s, m/s^2] */
} fw_stillness_means;

/* Starts. Returns FW_OK; FW_EINVAL (a limit not positive, leave < 1, NaN): *s untouched. */
fw_status fw_stillness_init(const fw_stillness_setup *setup, fw_stillness *s) FW_MUST_CHECK;

/* The next sample: averages over the interval that ends at a time, any rate from 20 to 1000 Hz. s->still is
 * the answer, renewed every eighth of a window. After a gap of more than a quarter of a window all begins
 * anew.
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (time not after the last): nothing taken. */
fw_status fw_stillness_imu(fw_stillness *s, fw_time t, const double omega_ib_b_radps[static 3],
                           const double force_b_mps2[static 3]) FW_MUST_CHECK;

/* A GNSS speed over ground. A speed that is motion ends stillness at once and keeps it away for a window and
 * a half. Speeds and sigmas that are not finite, and negative sigmas, are ignored. */
void fw_stillness_speed(fw_stillness *s, fw_time t, double speed_mps, double sd_mps);

/* Means over the stretch of stillness that goes on, its last eighth to quarter of a window left out once it
 * is longer than a window.
 * Returns FW_OK; FW_MORE (not still): *m untouched. */
fw_status fw_stillness_averages(const fw_stillness *s, fw_stillness_means *m) FW_MUST_CHECK;

#endif
