/* The satellites as they really are: broadcast ephemerides plus errors of orbit and clock, and the
 * atmosphere that their signals come through.
 *
 * The true state of a satellite runs smoothly from one broadcast ephemeris to the next, so that carrier
 * phases do, and carries Gauss-Markov errors of second order on top. It is made at nodes every
 * FW_SKY_STEP_S seconds of GPS time, with its derivatives, and interpolated between them: errors do not
 * depend on who asks when. */
#ifndef FURROW_SIM_SKY_H
#define FURROW_SIM_SKY_H

#include <stdbool.h>
#include <stdint.h>

#include "base/random.h"
#include "gnss/atmosphere.h"
#include "gnss/ephemeris.h"
#include "sim/process.h"

enum { FW_SKY_SATELLITES = 192, FW_SKY_STEP_S = 10 };

/* Standard deviations and correlation times of what the broadcast does not tell. */
typedef struct {
	double radial_m, along_m, cross_m, orbit_tau_s; /* orbit */
	double clock_m, clock_tau_s;                    /* satellite clock */
	double iono_fraction, iono_tau_s; /* ionosphere: of the model's delay, for each satellite */
	double tropo_m, tropo_tau_s;      /* wet zenith delay, the same for all satellites */
	fw_klobuchar klobuchar;           /* the broadcast model, which is right on average */
} fw_sky_errors;

typedef struct {
	fw_time time;
	double position_m[3], velocity_mps[3]; /* ECEF */
	double clock_m, drift_mps;             /* times c; relativity included */
	fw_gm2 radial, along, cross, clock, iono;
	fw_status status; /* < 0: no ephemeris for this moment */
} fw_sky_node;

typedef struct {
	fw_satellite satellite;
	int glonass_channel;             /* INT8_MIN: no FDMA */
	const fw_ephemeris *ephemerides; /* its own, ascending by toe */
	unsigned n;
	fw_random random;
	fw_sky_node node[2]; /* before and after the moment of fw_sky_advance */
} fw_sky_satellite;

/* Owned by the caller. */
typedef struct {
	fw_sky_errors errors;
	unsigned n;
	fw_sky_satellite satellite[FW_SKY_SATELLITES];
	fw_random random;
	fw_gm2 tropo[2]; /* wet zenith delay, at the nodes */
	fw_time time[2];
} fw_sky;

/* A satellite as an antenna sees it. */
typedef struct {
	double range_m;        /* from transmission to reception, ECEF turned by the time of travel */
	double range_rate_mps; /* its derivative */
	double unit[3];        /* towards the satellite, ECEF at reception */
	double azimuth_rad, elevation_rad;
	double clock_m, drift_mps; /* the satellite's, times c */
	fw_time transmitted;
} fw_sky_view;

/* Begins a sky.
 *   ephemerides  in   n of them, in any order; sorted in place by satellite, message and toe. Of Galileo,
 *                     where both messages are there, only I/NAV is kept in the sky. They must outlive the
 *                     sky.
 *   start        in   nothing will be asked that is before
 *   seed         in   of the errors
 * Returns FW_OK; FW_ENOSPACE (more than FW_SKY_SATELLITES). */
fw_status fw_sky_init(fw_sky *sky, const fw_sky_errors *errors, fw_ephemeris *ephemerides, unsigned n,
                      fw_time start, uint64_t seed) FW_MUST_CHECK;

/* Moves the sky on, so that what follows may be asked for times from t - 0.3 s to t. t does not go back by
 * more than a step. Ephemerides that do not reach to t leave their satellite out of sight. */
void fw_sky_advance(fw_sky *sky, fw_time t);

/* The ephemeris that satellite i of the sky broadcasts at t: the one whose toe is nearest; of Galileo the
 * one with the latest toe not after t. NULL: none is within its validity (FW_DUBIOUS or worse). */
const fw_ephemeris *fw_sky_broadcast(const fw_sky *sky, unsigned i, fw_time t);

/* Satellite i seen at GPST t by an antenna.
 *   position_m, velocity_mps  in   ECEF
 *   llh                       in   the same position, geodetic
 * Returns false, *view untouched: the satellite has no ephemeris now. Source of the light-time and rate
 * equations: see sky.c. */
bool fw_sky_look(const fw_sky *sky, unsigned i, fw_time t, const double position_m[static 3],
                 const double velocity_mps[static 3], const double llh[static 3], fw_sky_view *view);

/* The true delays towards satellite i at t [m]: ionosphere on L1 (Klobuchar's model times 1 + error),
 * troposphere (Saastamoinen's zenith delays and the error of the wet one, mapped after Niell). Either
 * pointer may be NULL. */
void fw_sky_delays(const fw_sky *sky, unsigned i, fw_time t, const fw_sky_view *view,
                   const double llh[static 3], double *iono_m, double *tropo_m);

#endif
