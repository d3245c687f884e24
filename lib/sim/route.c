#include "sim/route.h"

#include <math.h>
#include <stddef.h>

#include "base/frame.h"

/* The largest first and second derivative of the step. */
#define STEP_RATE_MAX 1.875
#define STEP_BEND_MAX 5.773502691896258 /* 10 / sqrt(3) */

/* However little the course or the speed changes, it takes so long [s]: what an IMU samples has no spikes. */
#define TURN_LEAST_S   0.5
#define CHANGE_LEAST_S 0.25

/* ---- the step ---- */

/* Everything about the step at x, 0..1, and its integral. */
struct step {
	double integral, value, rate, bend;
};

static struct step step_at(double x)
{
	double y = 1 - x, xx = x * x;

	return (struct step){
	    .integral = xx * xx * (2.5 - 3 * x + xx),
	    .value = xx * x * (10 - 15 * x + 6 * xx),
	    .rate = 30 * xx * y * y,
	    .bend = 60 * x * y * (1 - 2 * x),
	};
}

/* A quantity q with its integral and derivatives, d after the beginning of a change from q0 to q1 over a length. */
struct change {
	double integral, q, rate, bend;
};

static struct change change_at(double q0, double q1, double length, double d)
{
	struct step s = step_at(d / length);
	double dq = q1 - q0;

	return (struct change){
	    .integral = q0 * d + dq * length * s.integral,
	    .q = q0 + dq * s.value,
	    .rate = dq * s.rate / length,
	    .bend = dq * s.bend / (length * length),
	};
}

/* ---- the path ---- */

enum { NODES = 16 };

/* Gauss-Legendre quadrature on 0..1, 16 nodes in pairs (1 +- x) / 2; Abramowitz and Stegun, table 25.4. */
static const double gauss_node[NODES / 2] = {
    0.095012509837637440185, 0.281603550779258913230, 0.458016777657227386342, 0.617876244402643748447,
    0.755404408355003033895, 0.865631202387831743880, 0.944575023073232576078, 0.989400934991649932596,
};
static const double gauss_weight[NODES / 2] = {
    0.189450610455068496285, 0.182603415044923588867, 0.169156519395002538189, 0.149595988816576732081,
    0.124628971255533872052, 0.095158511682492784810, 0.062253523938647892863, 0.027152459411754094852,
};

static struct change curvature_at(const fw_route_piece *p, double d)
{
	return change_at(p->curvature0, p->curvature1, p->length_m, d);
}

/* Adds to *north and *east the way along the first d metres of a piece: the integral of its direction. The course
 * changes by less than pi, so that 16 nodes are good to the last bits. */
static void advance(const fw_route_piece *p, double d, double *north, double *east)
{
	double sum_n = 0, sum_e = 0;

	if (p->curvature0 == p->curvature1) { /* straight line or arc: its chord */
		double half = p->curvature0 * d / 2;
		double chord = half == 0 ? d : d * sin(half) / half;

		*north += chord * cos(p->course_rad + half);
		*east += chord * sin(p->course_rad + half);
		return;
	}
	for (int i = 0; i < NODES; i++) {
		double x = (1 + (i % 2 ? gauss_node[i / 2] : -gauss_node[i / 2])) / 2;
		double course = p->course_rad + curvature_at(p, x * d).integral;

		sum_n += gauss_weight[i / 2] * cos(course);
		sum_e += gauss_weight[i / 2] * sin(course);
	}
	*north += d / 2 * sum_n;
	*east += d / 2 * sum_e;
}

/* The height on a leg d after its beginning: integral, slope and its derivatives. */
static struct change slope_at(const fw_route_slope *leg, double d)
{
	double ramp = leg->length_m / 4;
	double slope = leg->rise_m / (leg->length_m - ramp);
	double left = leg->length_m - d;
	struct change c;

	if (d < ramp) {
		c = change_at(0, slope, ramp, d);
	} else if (left < ramp) { /* the way up, seen from the other end */
		c = change_at(0, slope, ramp, left);
		c.integral = leg->rise_m - c.integral;
		c.rate = -c.rate;
	} else {
		c = (struct change){.integral = slope * (d - ramp / 2), .q = slope};
	}
	c.integral += leg->up0_m;
	return c;
}

/* ---- corners ---- */

/* How a corner is rounded: a ramp of curvature, an arc, a ramp. */
struct corner {
	double angle_rad; /* signed, right positive */
	double speed_mps;
	double curvature; /* of the arc */
	double ramp_m, arc_m;
	double tangent_m; /* from the corner to where the turn begins and ends */
};

/* The pieces of a corner that begins at a place; returns how many. Ramps always have a length; the arc may have none. */
static int corner_pieces(const struct corner *c, const fw_route_piece *begin, fw_route_piece p[static 3])
{
	double lengths[3] = {c->ramp_m, c->arc_m, c->ramp_m};
	double curvatures[4] = {0, c->curvature, c->curvature, 0};
	fw_route_piece at = *begin;
	int n = 0;

	for (int i = 0; i < 3; i++) {
		if (!(lengths[i] > 0))
			continue;
		p[n] = at;
		p[n].length_m = lengths[i];
		p[n].curvature0 = curvatures[i];
		p[n].curvature1 = curvatures[i + 1];
		at.s0_m += lengths[i];
		advance(&p[n], lengths[i], &at.north_m, &at.east_m);
		at.course_rad += lengths[i] * (curvatures[i] + curvatures[i + 1]) / 2;
		n++;
	}
	return n;
}

/* The rounding of a corner at a speed. Curvature is limited by turn rate, lateral acceleration and radius; its change by
 * the jerk, and so that at least a quarter of the angle is turned on the ramps. */
static void round_corner(const fw_trajectory_limits *limits, double angle, double speed, struct corner *c)
{
	double turn = fabs(angle);
	double by_rate = speed / limits->turn_radps;
	double by_force = speed * speed / limits->lateral_mps2;
	double curvature = 1 / fmax(limits->radius_m, fmax(by_rate, by_force));
	double softness =
	    STEP_RATE_MAX * speed * speed * speed / limits->jerk_mps3; /* least ramp per curvature */
	fw_route_piece begin = {0}, p[3];
	double north = 0, east = 0;
	int n;

	*c = (struct corner){.angle_rad = angle, .speed_mps = speed};
	if (turn < 1e-9)
		return;
	curvature = fmin(curvature, fmin(sqrt(turn / softness), turn / (TURN_LEAST_S * speed)));
	c->ramp_m = fmin(fmax(softness * curvature, turn / curvature / 4), turn / curvature);
	c->arc_m = fmax(0, turn / curvature - c->ramp_m);
	c->curvature = copysign(turn / (c->arc_m + c->ramp_m), angle);
	n = corner_pieces(c, &begin, p);
	north = p[n - 1].north_m;
	east = p[n - 1].east_m;
	advance(&p[n - 1], p[n - 1].length_m, &north, &east);
	c->tangent_m = hypot(north, east) / (2 * cos(angle / 2));
}

/* The corner at the highest speed that keeps it inside the room; false: none does. */
static bool fit_corner(const fw_trajectory_limits *limits, double room, struct corner *c)
{
	double angle = c->angle_rad, low = 0, high = c->speed_mps;

	room *= 1 + 1e-12; /* what was made to fit exactly fits */
	if (c->tangent_m <= room)
		return true;
	for (int i = 0; i < 50; i++) {
		double middle = (low + high) / 2;

		round_corner(limits, angle, middle, c);
		if (c->tangent_m <= room)
			low = middle;
		else
			high = middle;
	}
	if (low == 0)
		return false;
	round_corner(limits, angle, low, c);
	return true;
}

/* ---- planning ---- */

/* Waypoints first..last are one place: the vehicle arrives at the height of the first and leaves at that of the last. */
struct place {
	int first, last;
	struct corner corner;
	double distance_m, course_rad;   /* of the leg that leads here */
	double speed_mps;                /* limit on it */
	double begin_m, middle_m, end_m; /* of the corner, along the path */
	bool stop;
};

struct plan {
	const fw_waypoint *w;
	const fw_trajectory_limits *limits;
	fw_route *route;
	double t_s, s_m, lift_m; /* where the phases have come to */
};

static bool limits_hold(const fw_trajectory_limits *l)
{
	const double value[6] = {l->accel_mps2, l->lateral_mps2, l->jerk_mps3,
	                         l->climb_mps,  l->turn_radps,   l->radius_m};

	for (int i = 0; i < 6; i++) {
		if (!(value[i] > 0 && value[i] < HUGE_VAL))
			return false;
	}
	return true;
}

static fw_status check_waypoint(const fw_waypoint *w, bool first)
{
	if (!isfinite(w->north_m + w->east_m + w->up_m + w->stay_s + (first ? 0 : w->speed_mps)))
		return FW_ENONFINITE;
	return w->stay_s >= 0 && (first || w->speed_mps > 0) ? FW_OK : FW_EINVAL;
}

/* Gathers the waypoints into places; -> how many, or 0 with status and bad. */
static int gather_places(int n, const fw_waypoint w[], bool may_lift, struct place place[], fw_status *status,
                         int *bad)
{
	int m = 0;

	for (int i = 0; i < n; i++) {
		bool same, lift;

		*bad = i;
		*status = check_waypoint(&w[i], i == 0);
		if (*status < 0)
			return 0;
		same = i > 0 && hypot(w[i].north_m - w[i - 1].north_m, w[i].east_m - w[i - 1].east_m) < 1e-3;
		lift = same && w[i].up_m != w[i - 1].up_m;
		*status = lift && !may_lift ? FW_EINVAL : FW_OK;
		if (*status < 0)
			return 0;
		if (!same)
			place[m++] = (struct place){.first = i};
		place[m - 1].last = i;
		place[m - 1].stop |= lift || w[i].stay_s > 0 || i == 0;
	}
	place[m - 1].stop = true;
	return m;
}

/* Courses and lengths of the legs, and the corners as fast as the vehicle would like to take them; returns the place
 * that cannot be turned at, 0 if all can. */
static int lay_legs(const struct plan *plan, int m, struct place place[])
{
	for (int k = 1; k < m;
	     k++) { /* from where the waypoints of a place begin: they differ by less than a millimetre */
		const fw_waypoint *a = &plan->w[place[k - 1].first], *b = &plan->w[place[k].first];
		double north = b->north_m - a->north_m, east = b->east_m - a->east_m;

		place[k].distance_m = hypot(north, east);
		place[k].course_rad = atan2(east, north);
		place[k].speed_mps = b->speed_mps;
	}
	for (int k = 1; k < m - 1; k++) {
		double angle = fw_wrap_pi(place[k + 1].course_rad - place[k].course_rad);

		if (!(fabs(angle) <= fw_rad_from_deg(170)))
			return k;
		round_corner(plan->limits, angle, fmin(place[k].speed_mps, place[k + 1].speed_mps),
		             &place[k].corner);
	}
	return 0;
}

/* Where two corners want more than the leg between them has, each gets its share; returns the place without enough, or 0. */
static int fit_corners(const struct plan *plan, int m, struct place place[])
{
	for (int k = 1; k < m - 1; k++) {
		double mine = place[k].corner.tangent_m, next = place[k + 1].corner.tangent_m;
		double before = place[k].distance_m - place[k - 1].corner.tangent_m;
		double after = place[k + 1].distance_m;

		if (mine + next > after)
			after *= mine / (mine + next);
		if (!fit_corner(plan->limits, fmin(before, after), &place[k].corner))
			return k;
	}
	return 0;
}

/* The pieces of the path, and where along it the corners are. */
static void lay_path(const struct plan *plan, int m, struct place place[])
{
	fw_route *route = plan->route;
	fw_route_piece at = {
	    .north_m = plan->w[0].north_m, .east_m = plan->w[0].east_m, .course_rad = place[1].course_rad};

	for (int k = 1; k < m; k++) {
		struct corner *c = &place[k].corner;
		int n;

		at.length_m = place[k].distance_m - place[k - 1].corner.tangent_m - c->tangent_m;
		if (at.length_m > 1e-9) {
			route->piece[route->n_pieces++] = at;
			advance(&at, at.length_m, &at.north_m, &at.east_m);
			at.s0_m += at.length_m;
		}
		place[k].begin_m = at.s0_m;
		n = corner_pieces(c, &at, &route->piece[route->n_pieces]);
		for (int i = 0; i < n; i++) {
			const fw_route_piece *p = &route->piece[route->n_pieces++];

			advance(p, p->length_m, &at.north_m, &at.east_m);
			at.s0_m += p->length_m;
		}
		at.course_rad += c->angle_rad;
		place[k].end_m = at.s0_m;
		place[k].middle_m = (place[k].begin_m + at.s0_m) / 2;
	}
	route->length_m = at.s0_m;
}

/* The heights over the legs, and how fast these slopes may be taken. */
static void lay_slopes(const struct plan *plan, int m, struct place place[])
{
	const fw_trajectory_limits *limits = plan->limits;
	double up = plan->w[0].up_m;

	for (int k = 1; k < m; k++) {
		double length = place[k].middle_m - place[k - 1].middle_m, ramp = length / 4;
		double rise = plan->w[place[k].first].up_m - plan->w[place[k - 1].last].up_m;
		double slope = fabs(rise) / (length - ramp);
		double speed = limits->climb_mps / slope;

		plan->route->slope[plan->route->n_slopes++] = (fw_route_slope){
		    .s0_m = place[k - 1].middle_m, .length_m = length, .up0_m = up, .rise_m = rise};
		speed = fmin(speed, sqrt(limits->accel_mps2 * ramp / (STEP_RATE_MAX * slope)));
		speed = fmin(speed, cbrt(limits->jerk_mps3 * ramp * ramp / (STEP_BEND_MAX * slope)));
		place[k].speed_mps = fmin(place[k].speed_mps, speed);
		up += rise;
	}
}

/* ---- speed ---- */

/* A change of speed under the limits: how long it takes. Its way is the mean speed times that. */
static double change_time(const fw_trajectory_limits *limits, double u, double v)
{
	double dv = fabs(v - u);

	if (dv == 0)
		return 0;
	return fmax(CHANGE_LEAST_S, fmax(STEP_RATE_MAX * dv / limits->accel_mps2,
	                                 sqrt(STEP_BEND_MAX * dv / limits->jerk_mps3)));
}

static double change_way(const fw_trajectory_limits *limits, double u, double v)
{
	return (u + v) / 2 * change_time(limits, u, v);
}

/* The highest speed, from the higher of u and v up to most, that is reached from u and left for v within a distance. */
static double peak_speed(const fw_trajectory_limits *limits, double u, double v, double most, double distance)
{
	double low = fmax(u, v), high = most;

	if (change_way(limits, u, high) + change_way(limits, high, v) <= distance)
		return high;
	for (int i = 0; i < 60; i++) {
		double middle = (low + high) / 2;

		if (change_way(limits, u, middle) + change_way(limits, middle, v) <= distance)
			low = middle;
		else
			high = middle;
	}
	return low;
}

/* The highest speed that can be had a distance after (or before) u. */
static double reach(const fw_trajectory_limits *limits, double u, double most, double distance)
{
	double low = u, high = most;

	if (high <= u || change_way(limits, u, high) <= distance)
		return high;
	for (int i = 0; i < 60; i++) {
		double middle = (low + high) / 2;

		if (change_way(limits, u, middle) <= distance)
			low = middle;
		else
			high = middle;
	}
	return low;
}

/* A point of the path between two stretches with limits of their own. */
struct node {
	double s_m, speed_mps;
	double limit_mps; /* on the stretch that ends here */
	int place;        /* where the vehicle stops, or -1 */
};

/* Ends the stretch that began at the last node. */
static void add_node(struct node node[], int *n, double s_m, double limit_mps, int place)
{
	double speed = *n > 0 ? limit_mps : 0;

	if (*n > 0 && node[*n - 1].place < 0)
		node[*n - 1].speed_mps = fmin(node[*n - 1].speed_mps, limit_mps);
	node[(*n)++] = (struct node){s_m, place < 0 ? speed : 0, limit_mps, place};
}

static int add_nodes(int m, const struct place place[], struct node node[])
{
	int n = 0;

	add_node(node, &n, 0, 0, 0);
	for (int k = 1; k < m; k++) {
		const struct place *p = &place[k];
		double corner = fmin(p->corner.speed_mps,
		                     fmin(p->speed_mps, k + 1 < m ? place[k + 1].speed_mps : HUGE_VAL));

		if (!(p->end_m > p->begin_m)) {
			add_node(node, &n, p->begin_m, p->speed_mps, p->stop ? k : -1);
			continue;
		}
		add_node(node, &n, p->begin_m, p->speed_mps, -1);
		if (p->stop)
			add_node(node, &n, p->middle_m, corner, k);
		add_node(node, &n, p->end_m, corner, -1);
	}
	return n;
}

/* No node is passed faster than its neighbours let the vehicle arrive or leave. */
static void settle_speeds(const fw_trajectory_limits *limits, int n, struct node node[])
{
	for (int i = 1; i < n; i++) {
		double most =
		    reach(limits, node[i - 1].speed_mps, node[i].limit_mps, node[i].s_m - node[i - 1].s_m);

		node[i].speed_mps = fmin(node[i].speed_mps, most);
	}
	for (int i = n - 1; i > 0; i--) {
		double most =
		    reach(limits, node[i].speed_mps, node[i].limit_mps, node[i].s_m - node[i - 1].s_m);

		node[i - 1].speed_mps = fmin(node[i - 1].speed_mps, most);
	}
}

/* ---- phases ---- */

/* Adds a stretch of time with a change of speed along the path, or of climbing on the spot. */
static void add_phase(struct plan *plan, double length_s, double speed0, double speed1, double climb0,
                      double climb1)
{
	if (!(length_s > 0))
		return;
	plan->route->phase[plan->route->n_phases++] = (fw_route_phase){
	    plan->t_s, length_s, plan->s_m, speed0, speed1, plan->lift_m, climb0, climb1,
	};
	plan->t_s += length_s;
	plan->s_m += length_s * (speed0 + speed1) / 2;
	plan->lift_m += length_s * (climb0 + climb1) / 2;
}

static void travel(struct plan *plan, double u, double v, double most, double distance)
{
	const fw_trajectory_limits *limits = plan->limits;
	double peak = peak_speed(limits, u, v, most, distance);
	double left = distance - change_way(limits, u, peak) - change_way(limits, peak, v);

	add_phase(plan, change_time(limits, u, peak), u, peak, 0, 0);
	add_phase(plan, left / peak, peak, peak, 0, 0);
	add_phase(plan, change_time(limits, peak, v), peak, v, 0, 0);
}

static void lift(struct plan *plan, double rise, double most)
{
	const fw_trajectory_limits *limits = plan->limits;
	double peak = peak_speed(limits, 0, 0, fmin(most, limits->climb_mps), fabs(rise));
	double left = fabs(rise) - 2 * change_way(limits, 0, peak);
	double climb = copysign(peak, rise);

	add_phase(plan, change_time(limits, 0, peak), 0, 0, 0, climb);
	add_phase(plan, left / peak, 0, 0, climb, climb);
	add_phase(plan, change_time(limits, peak, 0), 0, 0, climb, 0);
}

/* What happens at a place: stays, and vertical moves between its waypoints. */
static void stay(struct plan *plan, const struct place *p)
{
	for (int i = p->first; i <= p->last; i++) {
		double rise = i > p->first ? plan->w[i].up_m - plan->w[i - 1].up_m : 0;

		if (rise != 0)
			lift(plan, rise, plan->w[i].speed_mps);
		add_phase(plan, plan->w[i].stay_s, 0, 0, 0, 0);
	}
}

static void lay_phases(struct plan *plan, int m, const struct place place[])
{
	struct node node[3 * FW_WAYPOINTS_MAX];
	int n = add_nodes(m, place, node);

	settle_speeds(plan->limits, n, node);
	for (int i = 0; i < n; i++) {
		if (i > 0 && node[i].s_m > node[i - 1].s_m)
			travel(plan, node[i - 1].speed_mps, node[i].speed_mps, node[i].limit_mps,
			       node[i].s_m - node[i - 1].s_m);
		if (node[i].place >= 0)
			stay(plan, &place[node[i].place]);
	}
	if (plan->route->n_phases == 0)
		add_phase(plan, 1, 0, 0, 0, 0);
	plan->route->duration_s = plan->t_s;
}

/* A path for a vehicle that stays where it is; nothing of its length is ever used. */
static void lay_spot(const struct plan *plan, double heading_rad)
{
	const fw_waypoint *w = plan->w;
	fw_route *route = plan->route;

	route->piece[route->n_pieces++] = (fw_route_piece){
	    .length_m = 1, .north_m = w->north_m, .east_m = w->east_m, .course_rad = heading_rad};
	route->slope[route->n_slopes++] = (fw_route_slope){.length_m = 1, .up0_m = w->up_m};
}

fw_status fw_route_plan(int n, const fw_waypoint w[], const fw_trajectory_limits *limits, bool may_lift,
                        double heading_rad, fw_route *route, int *bad)
{
	struct place place[FW_WAYPOINTS_MAX];
	struct plan plan = {.w = w, .limits = limits, .route = route};
	fw_status status = FW_EINVAL;
	int m, refused;

	*bad = -1;
	if (!isfinite(heading_rad))
		return FW_ENONFINITE;
	if (!(n >= 1 && n <= FW_WAYPOINTS_MAX && limits_hold(limits)))
		return FW_EINVAL;
	m = gather_places(n, w, may_lift, place, &status, bad);
	if (m == 0)
		return status;
	route->n_pieces = route->n_slopes = route->n_phases = 0;
	route->length_m = 0;
	if (m == 1) {
		lay_spot(&plan, heading_rad);
	} else {
		refused = lay_legs(&plan, m, place);
		if (refused == 0)
			refused = fit_corners(&plan, m, place);
		*bad = place[refused].first;
		if (refused != 0)
			return FW_EINVAL;
		lay_path(&plan, m, place);
		lay_slopes(&plan, m, place);
	}
	lay_phases(&plan, m, place);
	return FW_OK;
}

/* ---- the state at a time ---- */

/* The last of n elements that begins at or before x; begin is the first member of the first element. */
static int find(double x, int n, const double *begin, size_t size)
{
	int low = 0, high = n;

	while (high - low > 1) {
		int middle = (low + high) / 2;

		if (*(const double *)(const void *)((const char *)begin + (size_t)middle * size) <= x)
			low = middle;
		else
			high = middle;
	}
	return low;
}

/* Derivatives of the position with the distance along the path, first to third. */
static void path_at(const fw_route *route, double s_m, double position[3], double d1[3], double d2[3],
                    double d3[3])
{
	const fw_route_piece *p =
	    &route->piece[find(s_m, route->n_pieces, &route->piece[0].s0_m, sizeof(*p))];
	const fw_route_slope *leg =
	    &route->slope[find(s_m, route->n_slopes, &route->slope[0].s0_m, sizeof(*leg))];
	struct change bend = curvature_at(p, s_m - p->s0_m);
	struct change up = slope_at(leg, s_m - leg->s0_m);
	double course = p->course_rad + bend.integral, k = bend.q;
	double north = cos(course), east = sin(course);

	position[0] = p->north_m;
	position[1] = p->east_m;
	position[2] = up.integral;
	advance(p, s_m - p->s0_m, &position[0], &position[1]);
	d1[0] = north, d2[0] = -k * east, d3[0] = -bend.rate * east - k * k * north;
	d1[1] = east, d2[1] = k * north, d3[1] = bend.rate * north - k * k * east;
	d1[2] = up.q, d2[2] = up.rate, d3[2] = up.bend;
}

void fw_route_at(const fw_route *route, double t_s, fw_route_state *state)
{
	double t = fmin(fmax(t_s, 0), route->duration_s);
	const fw_route_phase *phase =
	    &route->phase[find(t, route->n_phases, &route->phase[0].t0_s, sizeof(*phase))];
	double d = t - phase->t0_s;
	struct change run = change_at(phase->speed0_mps, phase->speed1_mps, phase->length_s, d);
	struct change climb = change_at(phase->climb0_mps, phase->climb1_mps, phase->length_s, d);
	double v = run.q, a = run.rate, j = run.bend;
	double d2[3], d3[3];

	path_at(route, phase->s0_m + run.integral, state->position_m, state->tangent, d2, d3);
	for (int i = 0; i < 3; i++) {
		double d1 = state->tangent[i];

		state->velocity_mps[i] = d1 * v;
		state->acceleration_mps2[i] = d2[i] * v * v + d1 * a;
		state->jerk_mps3[i] = d3[i] * v * v * v + 3 * d2[i] * v * a + d1 * j;
		state->tangent_rate_per_s[i] = d2[i] * v;
	}
	state->position_m[2] += phase->lift0_m + climb.integral;
	state->velocity_mps[2] += climb.q;
	state->acceleration_mps2[2] += climb.rate;
	state->jerk_mps3[2] += climb.bend;
}

/* ---- rows ---- */

enum { TURN_MAX = 4 }; /* waypoints of a turn */

#define SWING_OUT (FW_PI / 6)

/* The turn from the end of a row to the beginning of the next, in metres ahead of the row's end and towards the next row. */
static int headland_turn(const fw_rows *rows, const fw_trajectory_limits *limits,
                         double ahead[static TURN_MAX], double across[static TURN_MAX])
{
	double w = fabs(rows->spacing_m), speed = rows->turn_speed_mps;
	struct corner quarter, swing, back;
	double out;

	round_corner(limits, FW_PI / 2, speed, &quarter);
	if (w >= 2 * quarter.tangent_m) {
		ahead[0] = ahead[1] = quarter.tangent_m;
		across[0] = 0;
		across[1] = w;
		return 2;
	}
	round_corner(limits, SWING_OUT, speed, &swing);
	round_corner(limits, FW_PI / 2 + SWING_OUT, speed, &back);
	/* Both slanted legs, 2 out long as sin 30 degrees = 1/2, and the crosswise one must have room for their turns. */
	out = fmax((swing.tangent_m + back.tangent_m) / 2, back.tangent_m - w / 2);
	ahead[0] = ahead[3] = swing.tangent_m;
	ahead[1] = ahead[2] = swing.tangent_m + 2 * out * cos(SWING_OUT);
	across[0] = 0;
	across[1] = -out;
	across[2] = w + out;
	across[3] = w;
	return TURN_MAX;
}

/* The place a distance along the first row's direction and a distance to its right. */
static fw_waypoint row_place(const fw_rows *rows, double along, double right, double speed)
{
	double c = cos(rows->heading_rad), s = sin(rows->heading_rad);

	return (fw_waypoint){
	    .north_m = rows->north_m + along * c - right * s,
	    .east_m = rows->east_m + along * s + right * c,
	    .up_m = rows->up_m,
	    .speed_mps = speed,
	};
}

static bool rows_hold(const fw_rows *r)
{
	return isfinite(r->north_m + r->east_m + r->up_m + r->heading_rad + r->length_m + r->spacing_m +
	                r->speed_mps + r->turn_speed_mps) &&
	       r->length_m > 0 && r->spacing_m != 0 && r->count >= 1 && r->speed_mps > 0 &&
	       r->turn_speed_mps > 0;
}

fw_status fw_route_rows(const fw_rows *rows, const fw_trajectory_limits *limits, int room, fw_waypoint *w,
                        int *n)
{
	double ahead[TURN_MAX], across[TURN_MAX];
	double side = copysign(1, rows->spacing_m);
	int turn, needed, at = 0;

	if (!rows_hold(rows) || !limits_hold(limits))
		return FW_EINVAL;
	turn = headland_turn(rows, limits, ahead, across);
	if (rows->count > FW_WAYPOINTS_MAX)
		return FW_ENOSPACE;
	needed = 2 + turn * (rows->count - 1);
	if (needed > room)
		return FW_ENOSPACE;
	w[at++] = row_place(rows, 0, 0, rows->speed_mps);
	for (int row = 0; row < rows->count; row++) {
		double right = row * rows->spacing_m;
		double end = row % 2 ? 0 : rows->length_m, sense = row % 2 ? -1 : 1;

		if (row == rows->count - 1) {
			w[at++] = row_place(rows, end, right, rows->speed_mps);
			break;
		}
		for (int i = 0; i < turn; i++)
			w[at++] = row_place(rows, end + sense * ahead[i], right + side * across[i],
			                    i == 0 ? rows->speed_mps : rows->turn_speed_mps);
	}
	*n = at;
	return FW_OK;
}
