/* Routes: the path through waypoints on a flat map, and the way along it in time.
 *
 * The path runs straight along the legs between the waypoints and rounds the corners (it passes a waypoint by, as a
 * pilot does), with a curvature that rises and falls smoothly; heights change smoothly along the legs, from the middle
 * of one corner to the middle of the next. Along the path the speed changes smoothly too. North, east and up are C3 in
 * time. Where a limit leaves no room, the vehicle goes slower.
 *
 * Every smooth change, of curvature over the path, of slope over the path, of speed over time, is the quintic step
 * x^3 (10 - 15 x + 6 x^2), of which two derivatives vanish at both ends. */
#ifndef FURROW_SIM_ROUTE_H
#define FURROW_SIM_ROUTE_H

#include <stdbool.h>

#include "base/status.h"

enum { FW_WAYPOINTS_MAX = 1024 };

/* A place to pass, and how. */
typedef struct {
	double north_m, east_m, up_m; /* on the map */
	double
	    speed_mps; /* over ground (of a vertical move: upwards) on the way here; of the first place not used */
	double stay_s; /* > 0: the vehicle stops here and stands still so long */
} fw_waypoint;

/* What the vehicle can do; all > 0. */
typedef struct {
	double accel_mps2;   /* along the path, and vertically */
	double lateral_mps2; /* across the path: g tan(bank) */
	double jerk_mps3;    /* change of each of these */
	double climb_mps;    /* up or down */
	double turn_radps;   /* turn rate */
	double radius_m;     /* the least radius of a turn, however slow */
} fw_trajectory_limits;

/* A piece of the path: curvature goes from one value to the other, and the course with it. */
typedef struct {
	double s0_m, length_m;
	double north_m, east_m, course_rad; /* at its beginning */
	double curvature0, curvature1;      /* [1/m], positive to the right */
} fw_route_piece;

/* The height over one leg: the slope rises over a quarter of the length, holds for a half, falls over a quarter. */
typedef struct {
	double s0_m, length_m;
	double up0_m, rise_m;
} fw_route_slope;

/* A stretch of time in which the speed along the path goes from one value to the other, and that of climbing above it
 * on the spot. */
typedef struct {
	double t0_s, length_s;
	double s0_m, speed0_mps, speed1_mps;
	double lift0_m, climb0_mps, climb1_mps;
} fw_route_phase;

enum { FW_ROUTE_PIECES = 4 * FW_WAYPOINTS_MAX, FW_ROUTE_PHASES = 10 * FW_WAYPOINTS_MAX };

typedef struct {
	double duration_s, length_m; /* of the path over ground */
	int n_pieces, n_slopes, n_phases;
	fw_route_piece piece[FW_ROUTE_PIECES];
	fw_route_slope slope[FW_WAYPOINTS_MAX];
	fw_route_phase phase[FW_ROUTE_PHASES];
} fw_route; /* about 1 MB: not for the stack */

/* Where the vehicle is on the map, {north, east, up}, and which way its path leads. */
typedef struct {
	double position_m[3];
	double velocity_mps[3], acceleration_mps2[3], jerk_mps3[3]; /* derivatives with time */
	double tangent[3]; /* derivative of the position with the distance over ground: also when standing */
	double tangent_rate_per_s[3]; /* its derivative with time */
} fw_route_state;

/* The route through waypoints. It begins at time 0 at the first one, at rest, and ends at the last one, at rest. Corners
 * are cut by as much as the turn at that speed needs; a stay at a corner is in the middle of the turn. Waypoints straight
 * above or below each other are joined by a vertical move.
 *   n              in   1..FW_WAYPOINTS_MAX
 *   may_lift       in   whether the vehicle can move vertically
 *   heading_rad    in   of a route that never leaves its place; otherwise the first leg decides
 *   bad            out  the waypoint that FW_EINVAL or FW_ENONFINITE is about; -1: a limit, the heading or n; else untouched
 * Returns FW_OK; FW_EINVAL: a turn for which there is no room however slow, or straight back (more than 170 degrees), a
 * speed that is not positive, a negative stay, a vertical move without may_lift, a limit that is not positive, n;
 * FW_ENONFINITE. *route is without meaning on error. */
fw_status fw_route_plan(int n, const fw_waypoint w[], const fw_trajectory_limits *limits, bool may_lift,
                        double heading_rad, fw_route *route, int *bad) FW_MUST_CHECK;

/* The state at a time; before the beginning and after the end the vehicle stands still. t_s finite. */
void fw_route_at(const fw_route *route, double t_s, fw_route_state *state);

/* Parallel rows there and back, joined by turns on the headlands: every row is straight from its first to its last
 * metre. Where the rows are too close for a plain turn, the turn swings out first (an omega). */
typedef struct {
	double north_m, east_m, up_m; /* where the first row begins */
	double heading_rad;           /* of the first row */
	double length_m;
	double spacing_m; /* to the next row, positive to the right */
	int count;
	double speed_mps, turn_speed_mps;
} fw_rows;

/* The waypoints of such rows, to be used as they are or among others.
 *   room  in   of w
 *   n     out  how many there are: at most 4 count - 2
 * Returns FW_OK; FW_EINVAL (a length, spacing, count, speed or limit that is none); FW_ENOSPACE. Outputs untouched on
 * error. */
fw_status fw_route_rows(const fw_rows *rows, const fw_trajectory_limits *limits, int room, fw_waypoint *w,
                        int *n) FW_MUST_CHECK;

#endif
