/* Coarse alignment: the first attitude, and how sure it is.
 *
 * What a vehicle does decides the way. Standing still, the specific force gives roll and pitch (levelling)
 * and, with gyros far better than the Earth's rotation, heading too (gyrocompassing). Moving with GNSS
 * velocity, the accelerations seen by the IMU and by GNSS give all three, whether or not the vehicle points
 * where it goes. A heading from elsewhere (two antennas, magnetometer, course over ground, given) joins roll
 * and pitch by fw_align_from_angles.
 *
 * Frames as in base/frame.h. Biases are reading minus truth. Outputs are untouched when a function fails or
 * wants more. */
#ifndef FURROW_INS_ALIGNMENT_H
#define FURROW_INS_ALIGNMENT_H

#include <stdbool.h>

#include "base/status.h"
#include "base/time.h"
#include "ins/strapdown.h"

/* What may be wrong with the IMU, the same for its three axes: standard deviations of the biases as they are
 * left (after what is known of them has been taken out), and random walk coefficients. All >= 0. */
typedef struct {
	double gyro_bias_sd;  /* [rad/s] */
	double gyro_noise;    /* angle random walk [rad/sqrt(s)] */
	double accel_bias_sd; /* [m/s^2] */
	double accel_noise;   /* velocity random walk [m/s/sqrt(s)] */
	double scale_sd;      /* scale factors and misalignments [1]; 0: 0.001, as of calibrated MEMS */
} fw_align_imu;

/* An attitude and its errors. */
typedef struct {
	double q_n_b[4];              /* of norm 1 */
	double rpy_rad[3];            /* the same as roll, pitch, heading */
	double sd_rad[3];             /* of roll, pitch, heading */
	double covariance_rad2[3][3]; /* of the rotation vector phi, NED: C_n_b(true) = (I + [phi x]) C_n_b */
} fw_alignment;

/* ---- standing still ---- */

/* Roll and pitch from the mean specific force of a vehicle at rest.
 *   force_b       in   mean specific force [m/s^2]
 *   seconds       in   over how long, > 0
 *   gravity_mps2  in   fw_gravity_mps2, > 0
 *   rp_rad        out  roll -pi..pi, pitch -pi/2..pi/2
 *   sd_rad        out  of each: bias and averaged noise over gravity; roll's is at most pi, as it is with the
 *                      nose straight up
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (seconds, gravity or a sigma); FW_ERANGE (|force| is further from
 * gravity than 5 % and 5 sigma: not at rest). */
fw_status fw_align_level(const double force_b[static 3], double seconds, double gravity_mps2,
                         const fw_align_imu *imu, double rp_rad[static 2],
                         double sd_rad[static 2]) FW_MUST_CHECK;

/* An attitude from angles {roll, pitch, heading} and their sigmas, taken as independent.
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (a sigma negative; |pitch| > pi/2). */
fw_status fw_align_from_angles(const double rpy_rad[static 3], const double sd_rad[static 3],
                               fw_alignment *a) FW_MUST_CHECK;

/* Gyrocompassing: the whole attitude from the means of specific force and angular rate of a vehicle at rest.
 * Down is where the force says, east is across down and the axis of the Earth.
 *   omega_ib_b     in  mean angular rate as the gyros say, what is known of their bias taken out [rad/s]
 *   llh            in  latitude and height are used
 *   heading_sd_limit_rad  in  largest heading sigma that is still an answer, > 0
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (seconds, a sigma, latitude, limit); FW_ERANGE (not at rest:
 * |force| as above, or |omega| is further from the Earth rate than 10 % of it and 5 sigma); FW_ESINGULAR (the
 * heading sigma is above the limit: gyros too coarse or too short a time, or too near a pole).
 * Source: Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed.
 * (2013), 5.6.2. */
fw_status fw_align_gyrocompass(const double force_b[static 3], const double omega_ib_b[static 3],
                               double seconds, const double llh[static 3], const fw_align_imu *imu,
                               double heading_sd_limit_rad, fw_alignment *a) FW_MUST_CHECK;

/* ---- course over ground ---- */

/* Heading of a vehicle that goes where it points (on wheels, forwards), from GNSS velocity. Wind and side
 * slip are the caller's to add to the sigma.
 *   velocity_mps   in   NED
 *   sd_mps         in   of north and east velocity each, > 0
 *   heading_rad    out  0..2 pi
 *   sd_rad         out  sd_mps over speed
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (sd_mps); FW_ESINGULAR (slower than 3 sd_mps: no course). */
fw_status fw_align_course(const double velocity_mps[static 3], double sd_mps, double *heading_rad,
                          double *sd_rad) FW_MUST_CHECK;

/* ---- in motion ---- */

/* The integrated IMU gives velocity in a frame that is the body's at a moment t0 and turns no more, GNSS the
 * same in a frame that is NED at t0 and turns no more; between them is one constant rotation:
 *     R (beta(t) + J b_g - Theta b_a + e0) = alpha(t),      R = C_n0_b0
 *     beta  = int C_b0_b f dt  + C_b0_b (omega x lever), less its value at t0
 *     alpha = C_n0_n v - v(t0) + int C_n0_n (omega_ie x v - g) dt
 * with first-order effects of the biases (J, Theta) and the error e0 of the first velocity. Its least squares
 * need no history: each velocity adds to one quadratic form in (R, b_g, b_a, e0, 1), in which R stands
 * linearly. Gauss-Newton on the rotation with all unknowns, from level at six headings, finds the minimum,
 * and a heading that has a rival is not given out. The sigmas come from the whole normal matrix: sigmas of
 * the biases, noise of IMU and GNSS velocities, and all that the manoeuvres do not show, are in them; if the
 * residuals are larger than what was promised, so are the sigmas.
 *
 * Level is known in seconds (gravity), heading with the first horizontal accelerations of a few times the
 * noise of the velocity, or by the rotation of the Earth when the gyros are that good. Two windows take
 * turns, so that drift of old is forgotten; each takes over what the one before has found about the gyros'
 * biases, so that even a degree per second is got over in half a minute, window by window. A bias that is
 * told wrongly with a small sigma is not: the heading is then off by more than it says. The zero rate of
 * cheap gyros jumps by tenths of a degree per second; a sigma from noise alone would be too small.
 *
 * Source of the formula: Y. Wu and X. Pan, "Velocity/position integration formula, part I: application to
 * in-flight coarse alignment", IEEE Trans. Aerospace and Electronic Systems 49 (2013). Of the effects of the
 * biases: C. Forster et al., "On-manifold preintegration for real-time visual-inertial odometry", IEEE Trans.
 * Robotics 33 (2017). */
typedef struct {
	fw_align_imu imu;
	double gyro_bias[3];  /* what is known of them, from standing still for example; taken out [rad/s] */
	double accel_bias[3]; /* likewise [m/s^2] */
	double lever_b[3];    /* the antenna, from the IMU, body axes [m] */
	double window_s;      /* longest memory; 0: as long as bias and noise of the gyros allow, 5..600 s */
} fw_align_motion_setup;

enum { FW_ALIGN_FORM = 9 + 3 + 3 + 3 + 1 }; /* R by rows, b_g, b_a, e0, 1 */

/* Integrals since a moment t0. */
typedef struct {
	bool begun;
	fw_time t0, t_velocity;      /* the first and the last velocity */
	double q_b0_b[4], q_last[4]; /* now, at the last velocity */
	double turned;               /* sum of the turns from velocity to velocity [rad] */
	double beta[3], theta[3][3], J[3][3];
	double lever0[3]; /* velocity of the antenna against the IMU at t0, in b0 [m/s] */
	double C_e_n0[3][3];
	double v0[3];                 /* [m/s] */
	double push[3], push_rate[3]; /* integral in alpha, and its integrand at the last velocity, in n0 */
	double sd0_mps;
	double rows;                          /* velocities after the first */
	double longest_s;                     /* when it is done */
	double gyro_bias[3], gyro_bias_sd[3]; /* as known when it began */
	double form[FW_ALIGN_FORM][FW_ALIGN_FORM];
} fw_align_window;

typedef struct {
	fw_align_motion_setup setup;
	double gyro_bias[3], gyro_bias_sd[3]; /* as the windows before have shown them */
	bool running;      /* an increment has been taken since the start or the last gap */
	fw_time t;         /* end of the last increment */
	double omega_b[3]; /* its mean angular rate */
	bool waiting;      /* a velocity, for the increment that reaches it */
	fw_time t_waiting;
	double llh[3], velocity_mps[3], sd_mps;
	fw_align_window window[2]; /* the older one first */
} fw_align_motion;                 /* 7 kB */

/* The answer. */
typedef struct {
	fw_time t; /* end of the last increment: the attitude is of that moment */
	fw_alignment attitude;
	double gyro_bias[3], gyro_bias_sd[3];   /* whole, as the IMU has it [rad/s] */
	double accel_bias[3], accel_bias_sd[3]; /* likewise [m/s^2] */
	double memory_s;                        /* age of the window that it comes from, the better of two */
	double misfit; /* root mean square of the residuals over what was promised, about 1 */
} fw_align_motion_answer;

/* Starts. Returns FW_OK; FW_ENONFINITE; FW_EINVAL (a sigma or the window negative): *m untouched. */
fw_status fw_align_motion_init(const fw_align_motion_setup *setup, fw_align_motion *m) FW_MUST_CHECK;

/* The next increment of the IMU, as it reads, that ends at a time. Increments and velocities come in order of
 * time: a velocity before the increment whose interval it lies in. After a gap of more than 0.1 s and of 3
 * intervals all begins anew; smaller ones are bridged at the present rates.
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (dt not positive or over 1 s, time not after the last): nothing
 * taken. */
fw_status fw_align_motion_imu(fw_align_motion *m, fw_time end, const fw_increment *raw) FW_MUST_CHECK;

/* The next GNSS velocity and position of the antenna. Those without one valid velocity are not handed over.
 *   llh           in  a few hundred metres do not matter
 *   velocity_mps  in  NED
 *   sd_mps        in  of north and east velocity each, > 0, errors taken as white: twice the receiver's for
 *                     one that smooths
 * A velocity that is still waiting for its increment is replaced.
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (sd, latitude, time before the last increment's end): nothing
 * taken. */
fw_status fw_align_motion_velocity(fw_align_motion *m, fw_time t, const double llh[static 3],
                                   const double velocity_mps[static 3], double sd_mps) FW_MUST_CHECK;

/* The attitude as far as it is known; for the caller to look at sd_rad whether that is good enough. About a
 * millisecond.
 * Returns FW_OK; FW_MORE (too few velocities yet, or the heading is open: sigma above a radian, or another
 * heading fits nearly as well): *answer untouched. */
fw_status fw_align_motion_solve(const fw_align_motion *m, fw_align_motion_answer *answer) FW_MUST_CHECK;

#endif
