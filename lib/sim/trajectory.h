/* Trajectories: from waypoints, or from a table of someone else's motion, to a motion that an IMU could have felt.
 *
 * Positions live on a map around an origin: north and east are differences of latitude and longitude times the radii of
 * curvature at the origin, up is the difference of ellipsoidal heights. Over a survey the map is true to 1e-4. Latitude
 * and longitude are linear in it, so all derivatives of the motion are exact; velocity, attitude, angular rate and
 * specific force are those of the true motion over the ellipsoid, not of its image on the map.
 *
 * Attitudes along waypoints: a ground vehicle points along its path, up and down hill, and does not lean; a plane points
 * along its path and banks so that it feels no side force (Coriolis force aside); a multirotor looks along its path and
 * leans so that its thrust gives the acceleration. All of them are C1 in time or better, the position is C3: angular
 * rate and specific force have no steps.
 *
 * Nothing here uses random numbers, and nothing changes once a trajectory is made. */
#ifndef FURROW_SIM_TRAJECTORY_H
#define FURROW_SIM_TRAJECTORY_H

#include "base/status.h"
#include "sim/motion.h"
#include "sim/route.h"
#include "sim/spline.h"

typedef enum { FW_VEHICLE_GROUND, FW_VEHICLE_PLANE, FW_VEHICLE_MULTIROTOR } fw_vehicle;

typedef struct {
	fw_vehicle vehicle;
	double origin_llh[3]; /* of the map [rad, rad, m]; |latitude| <= 85 degrees */
	double heading_rad;   /* of a vehicle that never goes anywhere; otherwise the first leg decides */
	fw_trajectory_limits limits;
} fw_trajectory_setup;

/* A row of a table of someone else's motion. */
typedef struct {
	double t_s;
	double llh[3]; /* [rad, rad, m] */
	double velocity_ned_mps[3];
	double rpy_rad[3]; /* roll, pitch, heading */
} fw_trajectory_row;

typedef struct {
	double first_s, last_s; /* what it covers: 0 and the end of the route, or the times of the table */
	double origin_llh[3];
	double metres_per_lat_rad, metres_per_lon_rad; /* of the map */
	bool from_table;
	fw_vehicle vehicle;
	fw_route route;
	fw_spline spline;
} fw_trajectory; /* about 1 MB: not for the stack */

/* Latitude, longitude and height to the map around an origin: sets north_m, east_m, up_m of *w, leaves the rest.
 * Returns FW_OK; FW_ENONFINITE; FW_ERANGE (|latitude| of either > 85 degrees): *w untouched. */
fw_status fw_waypoint_place(const double origin_llh[static 3], const double llh[static 3],
                            fw_waypoint *w) FW_MUST_CHECK;

/* The trajectory through waypoints, from time 0 at the first one to the last one, at rest at both; before and after, the
 * vehicle stands there. route.h says how the way between them is found. Only a multirotor moves vertically.
 *   n    in   1..FW_WAYPOINTS_MAX
 *   bad  out  on error the waypoint that is to blame, -1: the setup
 * Returns FW_OK; FW_EINVAL, FW_ENONFINITE as fw_route_plan; FW_ERANGE (|latitude| of the origin > 85 degrees). *t is
 * without meaning on error. */
fw_status fw_trajectory_from_waypoints(const fw_trajectory_setup *setup, int n, const fw_waypoint w[],
                                       fw_trajectory *t, int *bad) FW_MUST_CHECK;

/* The trajectory along a table: the quintic spline (C4) that is nearest to its positions and velocities, and to its
 * attitudes as quaternions, by least squares. A velocity in m/s weighs as much as a position in m: both rounded to the
 * same decimal, they are taken for what they are.
 *   n          in   rows, at least 2, time increasing
 *   spacing_s  in   of the spline's knots, usually the interval of the rows; no two rows in a row are further
 *                   apart than three times this
 *   knots      in   fw_spline_knots(time of the first row, of the last row, spacing_s) of them: memory that *t goes on
 *                   using
 * The map's origin is the first row.
 * Returns FW_OK; FW_EINVAL (rows out of order or with a gap, number of knots); FW_ENONFINITE; FW_ERANGE (latitude);
 * FW_ESINGULAR. *t is without meaning on error. */
fw_status fw_trajectory_from_table(int n, const fw_trajectory_row rows[], double spacing_s, int n_knots,
                                   fw_spline_knot knots[], fw_trajectory *t) FW_MUST_CHECK;

/* The motion at a time, in one to two microseconds. Angular rate and specific force are the exact derivatives of attitude
 * and velocity in inertial space: Earth rotation, transport rate, Coriolis force and normal gravity (ins/gravity.h)
 * included.
 * Returns FW_OK; FW_ENONFINITE; FW_ERANGE (outside a table): *m untouched. */
fw_status fw_trajectory_at(const fw_trajectory *t, double t_s, fw_motion *m) FW_MUST_CHECK;

/* What an IMU without errors reports at the end of an interval: angular rate and specific force in body axes, their integrals
 * over the interval divided by its length. By Gauss-Legendre quadrature with 4 nodes: for an interval of 10 ms good
 * to 1e-9.
 * Returns as fw_trajectory_at; FW_EINVAL (not from_s < to_s). Outputs untouched on error. */
fw_status fw_trajectory_average(const fw_trajectory *t, double from_s, double to_s,
                                double omega_ib_b_radps[static 3],
                                double force_b_mps2[static 3]) FW_MUST_CHECK;

#endif
