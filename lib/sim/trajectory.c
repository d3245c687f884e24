#include "sim/trajectory.h"

#include <math.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "ins/gravity.h"

#define LATITUDE_MAX fw_rad_from_deg(85)

/* What a pilot takes for gravity when leaning into a turn [m/s^2]. */
#define LEAN_GRAVITY 9.80665

/* ---- vectors that change: value and rate of change ---- */

struct moving {
	double value[3], rate[3];
};

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void add_cross(const double a[3], const double b[3], double c[3])
{
	c[0] += a[1] * b[2] - a[2] * b[1];
	c[1] += a[2] * b[0] - a[0] * b[2];
	c[2] += a[0] * b[1] - a[1] * b[0];
}

/* The unit vector along v. */
static struct moving unit(const struct moving *v)
{
	double length = sqrt(dot(v->value, v->value));
	struct moving u;
	double growth;

	for (int i = 0; i < 3; i++)
		u.value[i] = v->value[i] / length;
	growth = dot(u.value, v->rate);
	for (int i = 0; i < 3; i++)
		u.rate[i] = (v->rate[i] - u.value[i] * growth) / length;
	return u;
}

/* The unit vector across a and b, along a cross b. */
static struct moving across(const struct moving *a, const struct moving *b)
{
	struct moving c = {0};

	add_cross(a->value, b->value, c.value);
	add_cross(a->rate, b->value, c.rate);
	add_cross(a->value, b->rate, c.rate);
	return unit(&c);
}

/* ---- the map and the Earth ---- */

/* Radii at a latitude and height: metres per radian of latitude and of longitude. */
static void metres_per_rad(double lat, double height, double *per_lat, double *per_lon)
{
	double s = sin(lat), w = sqrt(1 - FW_WGS84_E2 * s * s);

	*per_lat = FW_WGS84_A * (1 - FW_WGS84_E2) / (w * w * w) + height;
	*per_lon = (FW_WGS84_A / w + height) * cos(lat);
}

/* The place on the Earth and how it changes, from the map. */
struct place {
	double sin_lat, cos_lat;
	double lat_rate, lon_rate;          /* [rad/s] */
	double per_lat, per_lon;            /* [m/rad] */
	double per_lat_rate, per_lon_rate;  /* [m/rad/s] */
	double stretch[2], stretch_rate[2]; /* true metres per metre on the map, north and east */
};

static void place_on_earth(const fw_trajectory *t, const fw_route_state *s, fw_motion *m, struct place *p)
{
	double sine, up_rate = s->velocity_mps[2], w2;

	m->lat_rad = t->origin_llh[0] + s->position_m[0] / t->metres_per_lat_rad;
	m->lon_rad = t->origin_llh[1] + s->position_m[1] / t->metres_per_lon_rad;
	m->height_m = t->origin_llh[2] + s->position_m[2];
	sine = p->sin_lat = sin(m->lat_rad);
	p->cos_lat = cos(m->lat_rad);
	metres_per_rad(m->lat_rad, m->height_m, &p->per_lat, &p->per_lon);
	p->lat_rate = s->velocity_mps[0] / t->metres_per_lat_rad;
	p->lon_rate = s->velocity_mps[1] / t->metres_per_lon_rad;
	/* d/dlat of the meridian's radius is 3 e2 sin cos / (1 - e2 sin^2) times itself; of the parallel's, -per_lat sin. */
	w2 = 1 - FW_WGS84_E2 * sine * sine;
	p->per_lat_rate =
	    3 * FW_WGS84_E2 * sine * p->cos_lat / w2 * (p->per_lat - m->height_m) * p->lat_rate + up_rate;
	p->per_lon_rate = -p->per_lat * sine * p->lat_rate + p->cos_lat * up_rate;
	p->stretch[0] = p->per_lat / t->metres_per_lat_rad;
	p->stretch[1] = p->per_lon / t->metres_per_lon_rad;
	p->stretch_rate[0] = p->per_lat_rate / t->metres_per_lat_rad;
	p->stretch_rate[1] = p->per_lon_rate / t->metres_per_lon_rad;
}

/* A vector of the map {north, east, up} and its rate as true {north, east, down}. */
static struct moving to_ned(const struct place *p, const double value[3], const double rate[3])
{
	struct moving v;

	for (int i = 0; i < 2; i++) {
		v.value[i] = p->stretch[i] * value[i];
		v.rate[i] = p->stretch[i] * rate[i] + p->stretch_rate[i] * value[i];
	}
	v.value[2] = -value[2];
	v.rate[2] = -rate[2];
	return v;
}

/* ---- attitude ---- */

/* The body's axes in NED: forward, right, down. */
static void lean(const fw_trajectory *t, const fw_route_state *s, const struct place *p,
                 struct moving axis[3])
{
	struct moving along = to_ned(p, s->tangent, s->tangent_rate_per_s);
	struct moving fall =
	    to_ned(p, s->acceleration_mps2, s->jerk_mps3); /* where a plumb line on board points */

	for (int i = 0; i < 3; i++) {
		fall.value[i] = -fall.value[i];
		fall.rate[i] = -fall.rate[i];
	}
	fall.value[2] += LEAN_GRAVITY;
	if (t->vehicle == FW_VEHICLE_GROUND)
		fall = (struct moving){.value = {0, 0, 1}};
	if (t->vehicle == FW_VEHICLE_MULTIROTOR) {
		along.value[2] = along.rate[2] = 0; /* heading only */
		axis[2] = unit(&fall);
		axis[1] = across(&axis[2], &along);
		axis[0] = across(&axis[1], &axis[2]);
	} else {
		axis[0] = unit(&along);
		axis[1] = across(&fall, &axis[0]);
		axis[2] = across(&axis[0], &axis[1]);
	}
}

/* Rotation and angular rate against NED, in body axes, of three moving axes. */
static void attitude_of_axes(const struct moving axis[3], double C_n_b[3][3], double omega_nb_b[3])
{
	for (int i = 0; i < 3; i++) {
		for (int j = 0; j < 3; j++)
			C_n_b[i][j] = axis[j].value[i];
	}
	omega_nb_b[0] = dot(axis[2].value, axis[1].rate);
	omega_nb_b[1] = dot(axis[0].value, axis[2].rate);
	omega_nb_b[2] = dot(axis[1].value, axis[0].rate);
}

/* The same of a quaternion with any norm: omega = 2 q* dq/dt / |q|^2. */
static void attitude_of_quaternion(const double q[4], const double rate[4], double C_n_b[3][3],
                                   double omega_nb_b[3])
{
	double norm2 = q[0] * q[0] + dot(q + 1, q + 1), scale = 1 / sqrt(norm2);
	double conjugate[4] = {q[0], -q[1], -q[2], -q[3]}, unit_q[4], product[4];

	for (int i = 0; i < 4; i++)
		unit_q[i] = q[i] * scale;
	fw_quat_to_matrix(unit_q, C_n_b);
	fw_quat_mul(conjugate, rate, product);
	for (int i = 0; i < 3; i++)
		omega_nb_b[i] = 2 * product[i + 1] / norm2;
}

/* ---- motion ---- */

/* What the IMU feels, from the motion against the Earth. velocity_ned, acceleration_ned and C_n_b of *m are there. */
static void feel(const struct place *p, const double omega_nb_b[3], fw_motion *m)
{
	double earth[2] = {FW_EARTH_RATE_RADPS * p->cos_lat, -FW_EARTH_RATE_RADPS * p->sin_lat};
	double transport[3] = {p->lon_rate * p->cos_lat, -p->lat_rate, -p->lon_rate * p->sin_lat};
	double omega_in[3] = {earth[0] + transport[0], transport[1], earth[1] + transport[2]};
	double coriolis[3] = {2 * earth[0] + transport[0], transport[1], 2 * earth[1] + transport[2]};
	double force[3], omega[3];

	for (int i = 0; i < 3; i++)
		force[i] = m->acceleration_ned_mps2[i];
	add_cross(coriolis, m->velocity_ned_mps, force);
	force[2] -= fw_gravity_mps2(m->lat_rad, m->height_m);
	fw_mat3_t_vec(m->C_n_b, force, m->force_b_mps2);
	fw_mat3_t_vec(m->C_n_b, omega_in, omega);
	for (int i = 0; i < 3; i++)
		m->omega_ib_b_radps[i] = omega[i] + omega_nb_b[i];
}

/* Everything that follows from the state on the map, but what only a reader wants (angles, ECEF). */
static void move(const fw_trajectory *t, double t_s, fw_motion *m, struct place *p)
{
	fw_route_state s;
	double omega_nb_b[3];
	struct moving velocity;

	m->t_s = t_s;
	if (t->from_table) {
		double d[4][FW_SPLINE_COLUMNS];

		fw_spline_at(&t->spline, t_s, 0, FW_SPLINE_COLUMNS, d);
		for (int i = 0; i < 3; i++) {
			s.position_m[i] = d[0][i];
			s.velocity_mps[i] = d[1][i];
			s.acceleration_mps2[i] = d[2][i];
		}
		attitude_of_quaternion(d[0] + 3, d[1] + 3, m->C_n_b, omega_nb_b);
		place_on_earth(t, &s, m, p);
	} else {
		struct moving axis[3];

		fw_route_at(&t->route, t_s, &s);
		place_on_earth(t, &s, m, p);
		lean(t, &s, p, axis);
		attitude_of_axes(axis, m->C_n_b, omega_nb_b);
	}
	velocity = to_ned(p, s.velocity_mps, s.acceleration_mps2);
	for (int i = 0; i < 3; i++) {
		m->velocity_ned_mps[i] = velocity.value[i];
		m->acceleration_ned_mps2[i] = velocity.rate[i];
	}
	feel(p, omega_nb_b, m);
}

static fw_status check_time(const fw_trajectory *t, double t_s)
{
	if (!isfinite(t_s))
		return FW_ENONFINITE;
	return t->from_table && !(t_s >= t->first_s && t_s <= t->last_s) ? FW_ERANGE : FW_OK;
}

fw_status fw_trajectory_at(const fw_trajectory *t, double t_s, fw_motion *m)
{
	fw_status status = check_time(t, t_s);
	struct place p;
	double C_e_n[3][3], rpy[3], across_parallel;

	if (status < 0)
		return status;
	move(t, t_s, m, &p);
	m->lon_rad = fw_wrap_pi(m->lon_rad);
	fw_matrix_to_euler(m->C_n_b, rpy);
	m->roll_rad = rpy[0];
	m->pitch_rad = rpy[1];
	m->heading_rad = rpy[2];
	fw_frame_ned(m->lat_rad, m->lon_rad, C_e_n);
	fw_mat3_vec(C_e_n, m->velocity_ned_mps, m->velocity_ecef_mps);
	across_parallel =
	    p.per_lon; /* distance from the axis; fw_frame_ned's second column is {-sin lon, cos lon, 0} */
	m->position_ecef_m[0] = across_parallel * C_e_n[1][1];
	m->position_ecef_m[1] = -across_parallel * C_e_n[0][1];
	m->position_ecef_m[2] =
	    (FW_WGS84_A / sqrt(1 - FW_WGS84_E2 * p.sin_lat * p.sin_lat) * (1 - FW_WGS84_E2) + m->height_m) *
	    p.sin_lat;
	return FW_OK;
}

fw_status fw_trajectory_average(const fw_trajectory *t, double from_s, double to_s,
                                double omega_ib_b_radps[static 3], double force_b_mps2[static 3])
{
	/* Gauss-Legendre, 4 nodes; Abramowitz and Stegun, table 25.4. */
	static const double node[2] = {0.339981043584856264803, 0.861136311594052575224};
	static const double weight[2] = {0.652145154862546142627, 0.347854845137453857373};
	double middle = (from_s + to_s) / 2, half = (to_s - from_s) / 2;
	double omega[3] = {0}, force[3] = {0};
	fw_status status = check_time(t, from_s);

	if (status == FW_OK)
		status = check_time(t, to_s);
	if (status < 0)
		return status;
	if (!(from_s < to_s))
		return FW_EINVAL;
	for (int k = 0; k < 4; k++) {
		double x = k % 2 ? node[k / 2] : -node[k / 2];
		struct place p;
		fw_motion m;

		move(t, middle + half * x, &m, &p);
		for (int i = 0; i < 3; i++) {
			omega[i] += weight[k / 2] / 2 * m.omega_ib_b_radps[i];
			force[i] += weight[k / 2] / 2 * m.force_b_mps2[i];
		}
	}
	for (int i = 0; i < 3; i++) {
		omega_ib_b_radps[i] = omega[i];
		force_b_mps2[i] = force[i];
	}
	return FW_OK;
}

/* ---- making one ---- */

static fw_status set_origin(fw_trajectory *t, const double llh[3])
{
	if (!isfinite(llh[0] + llh[1] + llh[2]))
		return FW_ENONFINITE;
	if (!(fabs(llh[0]) <= LATITUDE_MAX))
		return FW_ERANGE;
	for (int i = 0; i < 3; i++)
		t->origin_llh[i] = llh[i];
	metres_per_rad(llh[0], llh[2], &t->metres_per_lat_rad, &t->metres_per_lon_rad);
	return FW_OK;
}

fw_status fw_waypoint_place(const double origin_llh[static 3], const double llh[static 3], fw_waypoint *w)
{
	double per_lat, per_lon;

	for (int i = 0; i < 3; i++) {
		if (!isfinite(origin_llh[i]) || !isfinite(llh[i]))
			return FW_ENONFINITE;
	}
	if (!(fabs(origin_llh[0]) <= LATITUDE_MAX && fabs(llh[0]) <= LATITUDE_MAX))
		return FW_ERANGE;
	metres_per_rad(origin_llh[0], origin_llh[2], &per_lat, &per_lon);
	w->north_m = (llh[0] - origin_llh[0]) * per_lat;
	w->east_m = fw_wrap_pi(llh[1] - origin_llh[1]) * per_lon;
	w->up_m = llh[2] - origin_llh[2];
	return FW_OK;
}

fw_status fw_trajectory_from_waypoints(const fw_trajectory_setup *setup, int n, const fw_waypoint w[],
                                       fw_trajectory *t, int *bad)
{
	fw_status status = set_origin(t, setup->origin_llh);

	*bad = -1;
	if (status < 0)
		return status;
	status = fw_route_plan(n, w, &setup->limits, setup->vehicle == FW_VEHICLE_MULTIROTOR,
	                       setup->heading_rad, &t->route, bad);
	if (status < 0)
		return status;
	t->from_table = false;
	t->vehicle = setup->vehicle;
	t->first_s = 0;
	t->last_s = t->route.duration_s;
	return FW_OK;
}

/* The columns of the spline for a row: place on the map, quaternion on the side of the one before, and rates. */
static fw_status columns_of_row(const fw_trajectory *t, const fw_trajectory_row *row, double before[4],
                                double value[FW_SPLINE_COLUMNS], double rate[3])
{
	const double *v = row->velocity_ned_mps;
	double q[4], per_lat, per_lon, sign;
	fw_waypoint place;
	fw_status status = fw_waypoint_place(t->origin_llh, row->llh, &place);

	if (status < 0)
		return status;
	metres_per_rad(row->llh[0], row->llh[2], &per_lat, &per_lon);
	value[0] = place.north_m;
	value[1] = place.east_m;
	value[2] = place.up_m;
	rate[0] = v[0] / per_lat * t->metres_per_lat_rad;
	rate[1] = v[1] / per_lon * t->metres_per_lon_rad;
	rate[2] = -v[2];
	fw_euler_to_quat(row->rpy_rad, q);
	sign = q[0] * before[0] + dot(q + 1, before + 1) < 0 ? -1 : 1;
	for (int i = 0; i < 4; i++)
		value[3 + i] = before[i] = sign * q[i];
	return FW_OK;
}

fw_status fw_trajectory_from_table(int n, const fw_trajectory_row rows[], double spacing_s, int n_knots,
                                   fw_spline_knot knots[], fw_trajectory *t)
{
	double before[4] = {1};
	fw_status status;

	if (!(n >= 2))
		return FW_EINVAL;
	t->from_table = true;
	t->first_s = rows[0].t_s;
	t->last_s = rows[n - 1].t_s;
	status = set_origin(t, rows[0].llh);
	if (status == FW_OK)
		status = fw_spline_begin(t->first_s, t->last_s, spacing_s, n_knots, knots, &t->spline);
	for (int i = 0; i < n && status == FW_OK; i++) {
		double value[FW_SPLINE_COLUMNS], rate[3];

		if (i > 0 &&
		    !(rows[i].t_s > rows[i - 1].t_s && rows[i].t_s - rows[i - 1].t_s <= 3 * spacing_s))
			return FW_EINVAL;
		status = columns_of_row(t, &rows[i], before, value, rate);
		if (status == FW_OK)
			status = fw_spline_add(&t->spline, rows[i].t_s, value, rate);
	}
	return status == FW_OK ? fw_spline_solve(&t->spline) : status;
}
