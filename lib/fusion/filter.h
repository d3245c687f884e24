/* The error-state Kalman filter that all recipes share: an INS that runs on, and a covariance of what is wrong with it.
 *
 * The states are blocks; a recipe says which. Errors are truth minus estimate and are taken out of the estimate at once, so
 * that the error state is zero between updates:
 *     attitude         phi [rad], NED:         C_n_b(true) = (I + [phi x]) C_n_b
 *     velocity         [m/s], NED
 *     position         [m], NED
 *     all others       their own value, added: bias, scale factor, error of a sensor
 * Sensors: omega_true = (1 - scale) reading - bias, for gyros [rad/s] and accelerometers [m/s^2], axis by axis.
 * Blocks other than attitude, velocity and position are Gauss-Markov processes, dx/dt = -x / tau + noise.
 *
 * Nothing here uses the heap; a filter is a plain struct that may be copied. */
#ifndef FURROW_FUSION_FILTER_H
#define FURROW_FUSION_FILTER_H

#include <stdbool.h>

#include "base/status.h"
#include "ins/strapdown.h"

typedef enum {
	FW_BLOCK_ATTITUDE,
	FW_BLOCK_VELOCITY,
	FW_BLOCK_POSITION,
	FW_BLOCK_GYRO_BIAS,      /* [rad/s] */
	FW_BLOCK_ACCEL_BIAS,     /* [m/s^2] */
	FW_BLOCK_GYRO_SCALE,     /* [1] */
	FW_BLOCK_ACCEL_SCALE,    /* [1] */
	FW_BLOCK_POSITION_ERROR, /* of GNSS, that stays a while [m], NED: measured minus true */
	FW_BLOCK_VELOCITY_ERROR, /* likewise [m/s], NED */
	FW_BLOCK_HEIGHT_ERROR,   /* of the barometer [m], one state: measured minus true */
	FW_BLOCK_COUNT
} fw_block;

enum { FW_STATES_MAX = 32, FW_ROWS_MAX = 8, FW_NAV_STATES = 9 };

/* Which blocks there are and where each begins. Attitude, velocity, position are always there, at 0, 3, 6. */
typedef struct {
	int n;                  /* states */
	int at[FW_BLOCK_COUNT]; /* first state of each block; -1: not there */
} fw_layout;

/* The layout with these blocks, bit 1 << FW_BLOCK_... each, and the three of navigation. */
fw_layout fw_layout_of(unsigned blocks);

/* States of a block: 3, or 1. */
int fw_block_size(fw_block block);

/* dx/dt = -x / tau + w. */
typedef struct {
	double tau_s; /* correlation time; INFINITY: random walk */
	double
	    density[3]; /* of w, for each state: root of the two-sided spectral density [unit of x / sqrt(s)];
	                      sd sqrt(2 / tau) for a standard deviation sd in the long run */
} fw_process_noise;

typedef struct {
	fw_layout layout;
	double gyro_noise;  /* angle random walk [rad/sqrt(s)] */
	double accel_noise; /* velocity random walk [m/s/sqrt(s)] */
	double gyro_matrix,
	    accel_matrix; /* scale factor errors and misalignments that no state stands for, sigma [1]: noise
	                                           while the vehicle turns and accelerates, see fw_filter_predict */
	fw_process_noise process[FW_BLOCK_COUNT]; /* of blocks other than attitude, velocity, position */
} fw_filter_model;

typedef struct {
	fw_filter_model model; /* may be changed between steps, the layout excepted */
	fw_pva pva;
	double x[FW_STATES_MAX]; /* values of the other blocks, at their states; 0 at those of navigation */
	double P[FW_STATES_MAX][FW_STATES_MAX]; /* covariance of the errors, n x n of it */
	fw_increment before;                    /* the last interval, errors taken out */
	double omega_nb_b[3]; /* angular rate against NED in body axes, of the last interval [rad/s] */
	double force_b[3];    /* specific force of the last interval [m/s^2] */
	bool keep_transition; /* whether transition is kept up, as smoothers need it */
	double transition[FW_STATES_MAX][FW_STATES_MAX]; /* of the errors since it was last set to one */
} fw_filter;

/* A measurement, linear in the errors: innovation = measured - predicted = H error + noise. */
typedef struct {
	int m; /* rows, 1..FW_ROWS_MAX */
	double innovation[FW_ROWS_MAX];
	double H[FW_ROWS_MAX][FW_STATES_MAX];
	double R[FW_ROWS_MAX][FW_ROWS_MAX]; /* covariance of the noise */
} fw_measurement;

/* Starts a filter.
 *   pva  in  a good first guess
 *   sd   in  standard deviations of its errors, one for each state of the layout; covariances are 0
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (a negative sd; poles): *f untouched. */
fw_status fw_filter_init(fw_filter *f, const fw_filter_model *model, const fw_pva *pva,
                         const double sd[]) FW_MUST_CHECK;

/* Goes on by one IMU interval: strapdown with the sensors' errors taken out, then P = Phi P Phi^T + Q at the IMU's own rate,
 * Phi = I + F dt.
 * An error m of scale or alignment turns the attitude by m times the angle of a manoeuvre, all of it the same way. As noise that is
 * q = (m omega)^2 T for manoeuvres of T = 2 s, which comes to the same at their end; of velocity likewise, by what is felt beside
 * gravity.
 *   raw  in  increments as the IMU says; dt > 0
 * Nothing is checked: see that what goes in is finite and in range. */
void fw_filter_predict(fw_filter *f, const fw_increment *raw);

/* The normalised innovation squared, innovation^T S^-1 innovation, S = H P H^T + R: chi-square with m degrees of freedom if
 * the filter is what it takes itself for.
 * Returns FW_OK; FW_ESINGULAR (S; R negative or not finite): *nis untouched. */
fw_status fw_filter_nis(const fw_filter *f, const fw_measurement *z, double *nis) FW_MUST_CHECK;

/* Takes a measurement in: Joseph's form, then the errors are taken out of the estimate. *nis as above (NULL: not wanted).
 * Returns FW_OK; FW_ESINGULAR, FW_ENONFINITE: *f untouched. */
fw_status fw_filter_update(fw_filter *f, const fw_measurement *z, double *nis) FW_MUST_CHECK;

/* Sets the transition to one. */
void fw_filter_restart_transition(fw_filter *f);

/* Takes errors (n) out of an estimate, and the other way: the errors that lead from one to another. */
void fw_estimate_add(const fw_layout *layout, const double error[], fw_pva *pva, double x[]);
void fw_estimate_difference(const fw_layout *layout, const fw_pva *from, const double x_from[],
                            const fw_pva *to, const double x_to[], double error[]);

/* F of the errors of attitude, velocity and position and of the others, d(error)/dt = F error, as n x n; for tests. */
void fw_filter_jacobian(const fw_filter *f, const fw_increment *raw, double F[]);

#endif
