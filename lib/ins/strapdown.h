/* Strapdown navigation: from angular rate and specific force to position, velocity and attitude, in the local frame NED. */
#ifndef FURROW_INS_STRAPDOWN_H
#define FURROW_INS_STRAPDOWN_H

#include "base/status.h"
#include "base/time.h"

/* Where the IMU is, how it moves and how it is turned. Frames as in base/frame.h. */
typedef struct {
	fw_time time;
	double llh[3];          /* latitude [rad], longitude [rad], height above the ellipsoid [m] */
	double velocity_mps[3]; /* relative to the Earth: north, east, down */
	double q_n_b[4];        /* attitude, of norm 1 */
} fw_pva;

/* What an IMU feels over an interval, as integrals: increments of angle and velocity in body axes, without errors. */
typedef struct {
	double dt_s;
	double angle_rad[3];    /* integral of omega_ib_b */
	double velocity_mps[3]; /* integral of the specific force in body axes, not corrected for rotation */
} fw_increment;

/* The Earth at a place, for someone who moves over it. */
typedef struct {
	double sin_lat, cos_lat;
	double M_m, N_m;      /* radii of curvature of the meridian and of the prime vertical, height added */
	double omega_ie_n[3]; /* rotation of the Earth [rad/s], NED */
	double omega_en_n[3]; /* transport rate [rad/s], NED */
	double gravity_mps2;  /* normal gravity, down */
	double gravity_per_m; /* its decrease with height [1/s^2] */
} fw_earth;

/* What a step went through, for the error model. */
typedef struct {
	fw_earth earth;         /* at its begin */
	double C_n_b[3][3];     /* at its begin */
	double force_n[3];      /* mean specific force [m/s^2], NED */
	double velocity_mps[3]; /* mean velocity, NED */
} fw_strapdown_step;

/* The Earth below a place. |latitude| below pi/2. Sources: Groves, Principles of GNSS, Inertial, and Multisensor Integrated
 * Navigation Systems, 2nd ed. (2013), equations 2.105, 2.106, 5.44; ins/gravity.h. */
void fw_earth_at(const double llh[static 3], const double velocity_mps[static 3], fw_earth *earth);

/* Moves *pva on over one interval. Attitude by the rotation vector with the coning term of two intervals, velocity with sculling and
 * rotation terms and with Coriolis force at the middle of the interval, position by the mean velocity.
 *   now     in   increments over the interval; |angle| below 1 rad
 *   before  in   increments over the one before it, of about the same length; all zero if there is none
 *   step    out  what the error model wants to know
 * Nothing is checked; what is not finite comes out not finite.
 * Source: P. G. Savage, "Strapdown inertial navigation integration algorithm design", J. Guidance 21 (1998), in the
 * two-sample form of E.-H. Shin, Estimation techniques for low-cost inertial navigation, UCGE report 20219 (2005), 2.3. */
void fw_strapdown(fw_pva *pva, const fw_increment *now, const fw_increment *before, fw_strapdown_step *step);

#endif
