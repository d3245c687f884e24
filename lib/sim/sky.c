#include "sim/sky.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "gnss/range_model.h"

enum { HUMIDITY_PERCENT = 70 };

/* ---- ephemerides in order ---- */

static int compare(const fw_ephemeris *a, const fw_ephemeris *b)
{
	unsigned ia = fw_satellite_index(a->satellite), ib = fw_satellite_index(b->satellite);
	if (ia != ib)
		return ia < ib ? -1 : 1;
	if (a->message != b->message)
		return a->message < b->message ? -1 : 1;
	return fw_time_compare(a->toe, b->toe);
}

/* Shell's sort with Knuth's gaps: in place, stable where it matters not. */
static void sort(fw_ephemeris *e, unsigned n)
{
	unsigned gap = 1;
	while (gap < n / 3)
		gap = 3 * gap + 1;
	for (; gap > 0; gap /= 3) {
		for (unsigned i = gap; i < n; i++) {
			fw_ephemeris moved = e[i];
			unsigned k = i;
			for (; k >= gap && compare(&moved, &e[k - gap]) < 0; k -= gap)
				e[k] = e[k - gap];
			e[k] = moved;
		}
	}
}

/* One ephemeris for each toe: of several, the first. Returns how many are left. */
static unsigned unique(fw_ephemeris *e, unsigned n)
{
	unsigned kept = 0;
	for (unsigned i = 0; i < n; i++)
		if (kept == 0 || compare(&e[kept - 1], &e[i]) != 0)
			e[kept++] = e[i];
	return kept;
}

/* ---- nodes ---- */

static double smooth_step(double x, double *slope)
{
	*slope = 6 * x * (1 - x);
	return x * x * (3 - 2 * x);
}

/* The orbit and clock without errors: from the ephemeris before to the one after, smoothly. Where there is
 * one only, at the ends of the list, that one as long as it is meant for. */
static fw_status broadcast_state(const fw_sky_satellite *s, fw_time t, fw_satellite_state *state)
{
	unsigned after = 0;
	while (after < s->n && s->ephemerides[after].toe.ns <= t.ns)
		after++;
	if (after == 0 || after == s->n) {
		fw_status status = fw_ephemeris_state(&s->ephemerides[after == 0 ? 0 : after - 1], t, state);
		return status == FW_DUBIOUS ? FW_ERANGE : status;
	}
	const fw_ephemeris *a = &s->ephemerides[after - 1], *b = &s->ephemerides[after];
	fw_satellite_state sa, sb;
	fw_status status = fw_ephemeris_state(a, t, &sa);
	if (status >= 0)
		status = fw_ephemeris_state(b, t, &sb);
	if (status < 0)
		return status;
	double gap = fw_time_diff_s(b->toe, a->toe), slope,
	       w = smooth_step(fw_time_diff_s(t, a->toe) / gap, &slope);
	for (int i = 0; i < 3; i++) {
		double step = sb.position_m[i] - sa.position_m[i];
		state->position_m[i] = sa.position_m[i] + w * step;
		state->velocity_mps[i] =
		    sa.velocity_mps[i] + w * (sb.velocity_mps[i] - sa.velocity_mps[i]) + slope / gap * step;
	}
	state->clock_s = sa.clock_s + w * (sb.clock_s - sa.clock_s);
	state->drift_sps =
	    sa.drift_sps + w * (sb.drift_sps - sa.drift_sps) + slope / gap * (sb.clock_s - sa.clock_s);
	return FW_OK;
}

static void cross(const double a[static 3], const double b[static 3], double c[static 3])
{
	c[0] = a[1] * b[2] - a[2] * b[1];
	c[1] = a[2] * b[0] - a[0] * b[2];
	c[2] = a[0] * b[1] - a[1] * b[0];
}

static double norm(const double a[static 3])
{
	return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/* Adds the orbit's errors, given along the radius, the flight and the normal of the orbit, which turn with
 * the satellite. */
static void displace(fw_sky_node *node)
{
	double *p = node->position_m, *v = node->velocity_mps, along[3], normal[3], turn[3], moved[3],
	       swept[3];
	double inertial[3] = {v[0] - FW_EARTH_RATE_RADPS * p[1], v[1] + FW_EARTH_RATE_RADPS * p[0], v[2]};
	double r = norm(p), area;

	cross(p, inertial, normal);
	area = norm(normal);
	for (int i = 0; i < 3; i++)
		turn[i] = normal[i] / (r * r) - (i == 2 ? FW_EARTH_RATE_RADPS : 0);
	for (int i = 0; i < 3; i++)
		normal[i] /= area;
	cross(normal, p, along);
	for (int i = 0; i < 3; i++) {
		double radial = p[i] / r;
		moved[i] = node->radial.value * radial + node->along.value * along[i] / r +
		           node->cross.value * normal[i];
		swept[i] = node->radial.rate * radial + node->along.rate * along[i] / r +
		           node->cross.rate * normal[i];
	}
	cross(turn, moved, along);
	for (int i = 0; i < 3; i++) {
		p[i] += moved[i];
		v[i] += swept[i] + along[i];
	}
}

/* Fills in a node whose time and errors are set. */
static void place(const fw_sky_satellite *s, fw_sky_node *node)
{
	fw_satellite_state state;
	node->status = broadcast_state(s, node->time, &state);
	if (node->status < 0)
		return;
	memcpy(node->position_m, state.position_m, sizeof node->position_m);
	memcpy(node->velocity_mps, state.velocity_mps, sizeof node->velocity_mps);
	displace(node);
	node->clock_m = FW_SPEED_OF_LIGHT_MPS * state.clock_s + node->clock.value;
	node->drift_mps = FW_SPEED_OF_LIGHT_MPS * state.drift_sps + node->clock.rate;
}

static void start_node(const fw_sky_errors *e, fw_sky_satellite *s, fw_time t)
{
	fw_sky_node *node = &s->node[1];
	node->time = t;
	fw_gm2_init(&node->radial, e->radial_m, e->orbit_tau_s, &s->random);
	fw_gm2_init(&node->along, e->along_m, e->orbit_tau_s, &s->random);
	fw_gm2_init(&node->cross, e->cross_m, e->orbit_tau_s, &s->random);
	fw_gm2_init(&node->clock, e->clock_m, e->clock_tau_s, &s->random);
	fw_gm2_init(&node->iono, e->iono_fraction, e->iono_tau_s, &s->random);
	place(s, node);
}

static void next_node(const fw_sky_errors *e, fw_sky_satellite *s)
{
	fw_sky_node *node = &s->node[1];
	s->node[0] = *node;
	node->time = fw_time_add_ns(node->time, FW_SKY_STEP_S * FW_NS_PER_S);
	fw_gm2_step(&node->radial, e->radial_m, e->orbit_tau_s, FW_SKY_STEP_S, &s->random);
	fw_gm2_step(&node->along, e->along_m, e->orbit_tau_s, FW_SKY_STEP_S, &s->random);
	fw_gm2_step(&node->cross, e->cross_m, e->orbit_tau_s, FW_SKY_STEP_S, &s->random);
	fw_gm2_step(&node->clock, e->clock_m, e->clock_tau_s, FW_SKY_STEP_S, &s->random);
	fw_gm2_step(&node->iono, e->iono_fraction, e->iono_tau_s, FW_SKY_STEP_S, &s->random);
	place(s, node);
}

static void next_nodes(fw_sky *sky)
{
	const fw_sky_errors *e = &sky->errors;
	for (unsigned i = 0; i < sky->n; i++)
		next_node(e, &sky->satellite[i]);
	sky->tropo[0] = sky->tropo[1];
	sky->time[0] = sky->time[1];
	sky->time[1] = fw_time_add_ns(sky->time[0], FW_SKY_STEP_S * FW_NS_PER_S);
	fw_gm2_step(&sky->tropo[1], e->tropo_m, e->tropo_tau_s, FW_SKY_STEP_S, &sky->random);
}

/* The satellites of the sky: each run of one satellite's ephemerides of one message, the first message
 * only. */
static fw_status gather(fw_sky *sky, const fw_ephemeris *e, unsigned n)
{
	for (unsigned i = 0, k; i < n; i = k) {
		for (k = i; k < n && e[k].message == e[i].message &&
		            fw_satellite_equal(e[k].satellite, e[i].satellite);)
			k++;
		if (sky->n > 0 && fw_satellite_equal(sky->satellite[sky->n - 1].satellite, e[i].satellite))
			continue;
		if (sky->n == FW_SKY_SATELLITES)
			return FW_ENOSPACE;
		int channel = e[i].satellite.system == FW_GLONASS ? e[i].state.channel : INT8_MIN;
		sky->satellite[sky->n++] = (fw_sky_satellite){.satellite = e[i].satellite,
		                                              .glonass_channel = channel,
		                                              .ephemerides = &e[i],
		                                              .n = k - i};
	}
	return FW_OK;
}

fw_status fw_sky_init(fw_sky *sky, const fw_sky_errors *errors, fw_ephemeris *ephemerides, unsigned n,
                      fw_time start, uint64_t seed)
{
	sort(ephemerides, n);
	*sky = (fw_sky){.errors = *errors};
	fw_status status = gather(sky, ephemerides, unique(ephemerides, n));
	if (status < 0)
		return status;

	int64_t step = FW_SKY_STEP_S * FW_NS_PER_S;
	fw_random_init(&sky->random, seed);
	fw_gm2_init(&sky->tropo[1], errors->tropo_m, errors->tropo_tau_s, &sky->random);
	sky->time[1] = (fw_time){start.ns / step * step};
	uint64_t own = fw_random_u64(&sky->random);
	for (unsigned i = 0; i < sky->n; i++) {
		fw_sky_satellite *s = &sky->satellite[i];
		fw_random_init(&s->random, own + fw_satellite_index(s->satellite));
		start_node(errors, s, sky->time[1]);
	}
	next_nodes(sky);
	return FW_OK;
}

void fw_sky_advance(fw_sky *sky, fw_time t)
{
	while (fw_time_compare(t, sky->time[1]) > 0)
		next_nodes(sky);
}

const fw_ephemeris *fw_sky_broadcast(const fw_sky *sky, unsigned i, fw_time t)
{
	const fw_sky_satellite *s = &sky->satellite[i];
	const fw_ephemeris *best = NULL;
	double nearest = (double)INFINITY;
	for (unsigned k = 0; k < s->n; k++) {
		double age = fw_time_diff_s(t, s->ephemerides[k].toe);
		if (s->satellite.system == FW_GALILEO && age < 0)
			continue;
		if (fabs(age) < nearest) {
			nearest = fabs(age);
			best = &s->ephemerides[k];
		}
	}
	fw_satellite_state state;
	return best != NULL && fw_ephemeris_state(best, t, &state) == FW_OK ? best : NULL;
}

/* ---- looking up ---- */

/* Cubic Hermite interpolation at s (0..1) of an interval of h seconds; the rate too. */
static double hermite(double x0, double v0, double x1, double v1, double h, double s, double *rate)
{
	double rise = x1 - x0, a = h * v0 - rise, b = rise - h * v1;
	*rate = (rise + (1 - 2 * s) * (a * (1 - s) + b * s) + s * (1 - s) * (b - a)) / h;
	return x0 + s * (rise + (1 - s) * (a * (1 - s) + b * s));
}

/* The satellite so long after its first node. */
static void state_at(const fw_sky_satellite *s, double since_node_s, double p[static 3], double v[static 3])
{
	const fw_sky_node *a = &s->node[0], *b = &s->node[1];
	for (int i = 0; i < 3; i++)
		p[i] = hermite(a->position_m[i], a->velocity_mps[i], b->position_m[i], b->velocity_mps[i],
		               FW_SKY_STEP_S, since_node_s / FW_SKY_STEP_S, &v[i]);
}

/* x turned with the Earth for a time, about z. */
static void turn_with_earth(double s, const double x[static 3], double y[static 3])
{
	double angle = FW_EARTH_RATE_RADPS * s, c = cos(angle), d = sin(angle);
	y[0] = c * x[0] + d * x[1];
	y[1] = c * x[1] - d * x[0];
	y[2] = x[2];
}

bool fw_sky_look(const fw_sky *sky, unsigned i, fw_time t, const double position_m[static 3],
                 const double velocity_mps[static 3], const double llh[static 3], fw_sky_view *view)
{
	const fw_sky_satellite *s = &sky->satellite[i];
	double since = fw_time_diff_s(t, sky->time[0]), travel = 0.08, p[3], v[3], at[3], moving[3], line[3];
	double C_e_n[3][3], ned[3];

	if (s->node[0].status < 0 || s->node[1].status < 0)
		return false;
	/* The signal's path, from where the satellite was: each round takes five digits off the error. */
	for (int round = 0; round < 3; round++) {
		state_at(s, since - travel, p, v);
		turn_with_earth(travel, p, at);
		for (int k = 0; k < 3; k++)
			line[k] = at[k] - position_m[k];
		view->range_m = norm(line);
		travel = view->range_m / FW_SPEED_OF_LIGHT_MPS;
	}
	turn_with_earth(travel, v, moving);

	/* rho = |R(w tau) s(t - tau) - r|, c tau = rho. Differentiated: rho' (1 + u.(v_s - w x s) / c) =
	 * u.(v_s - v_r), with w x s because the longer the signal travels, the further the Earth turns. */
	double apart = 0, later = 0;
	for (int k = 0; k < 3; k++) {
		double swept = k == 0 ? at[1] : k == 1 ? -at[0] : 0;
		view->unit[k] = line[k] / view->range_m;
		apart += view->unit[k] * (moving[k] - velocity_mps[k]);
		later += view->unit[k] * (moving[k] - FW_EARTH_RATE_RADPS * swept);
	}
	view->range_rate_mps = apart / (1 + later / FW_SPEED_OF_LIGHT_MPS);

	fw_frame_ned(llh[0], llh[1], C_e_n);
	fw_mat3_t_vec(C_e_n, view->unit, ned);
	view->azimuth_rad = fw_wrap_2pi(atan2(ned[1], ned[0]));
	view->elevation_rad = asin(fmin(fmax(-ned[2], -1), 1));
	view->clock_m =
	    hermite(s->node[0].clock_m, s->node[0].drift_mps, s->node[1].clock_m, s->node[1].drift_mps,
	            FW_SKY_STEP_S, (since - travel) / FW_SKY_STEP_S, &view->drift_mps);
	view->transmitted = fw_time_add_ns(t, -llround(travel * 1e9));
	return true;
}

/* Days since the beginning of the year, near enough for the seasons of the troposphere: GPS time began on 6
 * January. */
static double day_of_year(fw_time t)
{
	return fmod((double)(t.ns / FW_NS_PER_S) / 86400 + 5, 365.25) + 1;
}

void fw_sky_delays(const fw_sky *sky, unsigned i, fw_time t, const fw_sky_view *view,
                   const double llh[static 3], double *iono_m, double *tropo_m)
{
	const fw_sky_node *a = &sky->satellite[i].node[0], *b = &sky->satellite[i].node[1];
	double s = fw_time_diff_s(t, sky->time[0]) / FW_SKY_STEP_S, tow_s, rate;
	int week;

	fw_time_to_gps_s(t, &week, &tow_s);
	if (iono_m != NULL) {
		fw_sight sight = {llh[0], llh[1], view->azimuth_rad, view->elevation_rad, tow_s};
		double error = hermite(a->iono.value, a->iono.rate, b->iono.value, b->iono.rate,
		                       FW_SKY_STEP_S, s, &rate);
		*iono_m = (1 + error) * fw_klobuchar_m(&sky->errors.klobuchar, &sight);
	}
	if (tropo_m != NULL) {
		fw_zenith_delay zenith = fw_saastamoinen(llh[0], llh[2], HUMIDITY_PERCENT / 100.0);
		double wet =
		    zenith.wet_m + hermite(sky->tropo[0].value, sky->tropo[0].rate, sky->tropo[1].value,
		                           sky->tropo[1].rate, FW_SKY_STEP_S, s, &rate);
		*tropo_m = zenith.dry_m * fw_niell_dry(view->elevation_rad, llh[0], llh[2], day_of_year(t)) +
		           wet * fw_niell_wet(view->elevation_rad, llh[0]);
	}
}
