/* From the filter's state to nav records. */
#ifndef FURROW_CLI_FUSE_OUTPUT_H
#define FURROW_CLI_FUSE_OUTPUT_H

#include "formats/record.h"
#include "fusion/loose.h"

typedef enum { FUSE_FUSED, FUSE_COASTING, FUSE_STILL, FUSE_SMOOTHED } fuse_status;

/* What of a covariance a nav record needs. Linear in the covariance, so that those between two moments can be interpolated. */
enum {
	FUSE_SPREAD_ATTITUDE = 0, /* of phi, NED: nn ee dd ne nd ed [rad^2] */
	FUSE_SPREAD_VELOCITY = 6, /* variances [m^2/s^2] */
	FUSE_SPREAD_POSITION = 9, /* nn ee dd, ne [m^2] */
	FUSE_SPREAD = 13
};

/* A moment of the solution. */
typedef struct {
	fw_pva pva;
	double spread[FUSE_SPREAD];
	float hpl_m, vpl_m; /* NAN: none */
	fuse_status status;
} fuse_moment;

/* A fix older than this makes the solution coast [s]. */
#define FUSE_COAST_S 2.0

/* The spread of a covariance whose first states are attitude, velocity, position. */
void fuse_spread_of(const double P[FW_STATES_MAX][FW_STATES_MAX], double spread[static FUSE_SPREAD]);

/* The present moment of a filter. */
void fuse_moment_of(const fw_loose *l, fuse_moment *m);

/* Where nav records go. The axes of the IMU are turned a little against each other and against its case, which nothing shows:
 * attitudes are no better than that. */
typedef struct {
	fw_sink to;
	double misalignment_rad; /* sigma, about each axis */
} fuse_output;

/* Puts a nav record. Nothing that is not finite is put: returns false then. */
bool fuse_output_put(const fuse_output *o, const fuse_moment *m);

/* Samples of a table at a lower rate than the IMU's: the first one at or after each multiple of the interval. */
typedef struct {
	int64_t every_ns; /* 0: all; < 0: none */
	int64_t next_ns;
} fuse_rate;

bool fuse_rate_keeps(fuse_rate *r, fw_time t);

#endif
