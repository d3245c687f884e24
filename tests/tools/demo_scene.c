#include "demo_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "formats/sbf_signal.h"

/* ---- the drone ----
 * Lines of LINE_S seconds north and south, joined by half turns of TURN_S seconds to the right and to the left. */

enum { LINE_S = 14, TURN_S = 8, LEG_S = LINE_S + TURN_S };

#define FIELD_LAT_DEG 52.0517
#define FIELD_LON_DEG 11.4462
#define FLIGHT_M      191.4 /* above the ellipsoid: 60 m above ground */
#define SPEED_MPS     8.0
#define PITCH_RAD     -0.12 /* nose down: a multicopter that moves forward */
#define GRAVITY_MPS2  9.8124

typedef struct {
	double heading, rate; /* rad, rad/s */
} course;

/* In a turn the rate follows 1 - cos, so that it begins and ends with no jerk of the roll. */
static course course_at(double s)
{
	int leg = (int)(s / LEG_S);
	double in_turn = (s - leg * LEG_S - LINE_S) / TURN_S, done = fmax(in_turn, 0),
	       phase = 2 * FW_PI * done;
	double side = leg % 2 == 0 ? 1 : -1, from = leg % 2 == 0 ? 0 : FW_PI;
	return (course){from + side * FW_PI * (done - sin(phase) / (2 * FW_PI)),
	                side * FW_PI / TURN_S * (1 - cos(phase))};
}

static double roll_at(double s)
{
	return atan(SPEED_MPS * course_at(s).rate / GRAVITY_MPS2);
}

/* Metres north and east of the start after s seconds. */
static void track(double s, double *north, double *east)
{
	const double step = 0.05;
	long n = lround(floor(s / step));
	*north = *east = 0;
	for (long i = 0; i <= n; i++) {
		double begin = step * (double)i, length = fmin(step, s - begin);
		double heading = course_at(begin + length / 2).heading;
		*north += SPEED_MPS * length * cos(heading);
		*east += SPEED_MPS * length * sin(heading);
	}
}

/* Rates of the Euler angles to the rates about the body's axes, and the force that an accelerometer feels. */
static void feel(scene_drone *d, double turn_rate)
{
	double roll = d->rpy[0], pitch = d->rpy[1];
	d->turn_b[0] = d->rpy_rate[0] - turn_rate * sin(pitch);
	d->turn_b[1] = turn_rate * sin(roll) * cos(pitch);
	d->turn_b[2] = turn_rate * cos(roll) * cos(pitch);
	double C_n_b[3][3], force_n[3] = {-turn_rate * d->vel_n[1], turn_rate * d->vel_n[0], -GRAVITY_MPS2};
	fw_euler_to_matrix(d->rpy, C_n_b);
	fw_mat3_t_vec(C_n_b, force_n, d->force_b);
}

void scene_fly(double t, scene_drone *d)
{
	double s = t - SCENE_START_S + 1, north,
	       east; /* the clock's offset must not lead to before the start */
	course c = course_at(s);
	track(s, &north, &east);
	d->llh[0] = fw_rad_from_deg(FIELD_LAT_DEG) + north / 6377000;
	d->llh[1] = fw_rad_from_deg(FIELD_LON_DEG) + east / (6391000 * cos(fw_rad_from_deg(FIELD_LAT_DEG)));
	d->llh[2] = FLIGHT_M + 0.15 * sin(0.4 * s);
	d->vel_n[0] = SPEED_MPS * cos(c.heading);
	d->vel_n[1] = SPEED_MPS * sin(c.heading);
	d->vel_n[2] = -0.06 * cos(0.4 * s);
	d->rpy[0] = roll_at(s);
	d->rpy[1] = PITCH_RAD;
	d->rpy[2] = fw_wrap_2pi(c.heading);
	d->rpy_rate[0] = (roll_at(s + 0.01) - roll_at(s - 0.01)) / 0.02;
	d->rpy_rate[1] = 0;
	d->rpy_rate[2] = c.rate;
	feel(d, c.rate);
	double C_e_n[3][3];
	fw_frame_ned(d->llh[0], d->llh[1], C_e_n);
	fw_mat3_vec(C_e_n, d->vel_n, d->vel_e);
	if (fw_llh_to_ecef(d->llh, d->pos_e) != FW_OK)
		abort();
}

double scene_clock_s(double t)
{
	return 1.24e-4 + SCENE_CLOCK_DRIFT * (t - SCENE_START_S);
}

/* ---- the sky ---- */

typedef struct {
	char system;
	int first, planes, slots, wanted; /* number of the first satellite; how many are taken */
	unsigned signals[2];
	double radius_m, inclination_deg, node_deg, usable_s, mu_m3ps2, rotation_radps, delay_s;
} constellation;

/** mu and the Earth's rotation: IS-GPS-200, Galileo OS SIS ICD, BDS-SIS-ICD-B1I, GLONASS ICD */
static const constellation constellations[] = {
    {'G', 1, 6, 5, 5, {0, 3}, 26559.71e3, 55.2, 12, 3, 3.986005e14, 7.2921151467e-5, 0},
    {'E', 1, 3, 8, 3, {17, 20}, 29600.32e3, 56.1, 77, 3, 3.986004418e14, 7.2921151467e-5, 0},
    {'C', 19, 3, 8, 3, {28, 30}, 27906.14e3, 55.0, 34, 5, 3.986004418e14, 7.2921150e-5, 14},
    {'R', 1, 3, 8, 2, {8, 11}, 25508.20e3, 64.8, 251, 7, 3.9860044e14, 7.292115e-5, 0},
    {'S', 123, 1, 1, 1, {24, 25}, 42164.17e3, 0, 31.5, 1e9, 3.986005e14, 7.2921151467e-5, 0},
};

/* As a broadcast message carries it. */
static double on_the_wire(double semicircles)
{
	return ldexp(nearbyint(ldexp(remainder(semicircles, 2), 31)), -31);
}

static scene_satellite place(const constellation *c, int plane, int slot)
{
	int number = c->first + plane * c->slots + slot;
	double node = c->node_deg + 360.0 / c->planes * plane;
	double along = 360.0 / c->slots * slot + 360.0 / (c->planes * c->slots) * plane;
	double turned = c->rotation_radps * SCENE_TOE_S / FW_PI; /* the Earth, since the week began */
	scene_satellite s = {
	    .channel = c->system == 'R' ? number % 13 - 6 : 0,
	    .signals = {c->signals[0], c->signals[1]},
	    .sqrt_a = ldexp(nearbyint(ldexp(sqrt(c->radius_m), 19)), -19),
	    .i0 = on_the_wire(c->inclination_deg / 180),
	    .omega0 = on_the_wire(node / 180 + turned),
	    .m0 = on_the_wire(along / 180),
	    .clock_s = c->system == 'S' ? 0 : ldexp((number * 7919) % 400000 - 200000, -31),
	    .usable_s = c->usable_s,
	    .mu_m3ps2 = c->mu_m3ps2,
	    .rotation_radps = c->rotation_radps,
	    .delay_s = c->delay_s,
	};
	snprintf(s.name, sizeof s.name, "%c%02u", c->system, (unsigned)number % 1000);
	s.svid = fw_sbf_svid(s.name);
	return s;
}

void scene_orbit(const scene_satellite *s, double t, double pos_e[static 3], double vel_e[static 3])
{
	double r = s->sqrt_a * s->sqrt_a, rate = sqrt(s->mu_m3ps2 / r) / r, tk = t - s->delay_s - SCENE_TOE_S;
	double u = s->m0 * FW_PI + rate * tk,
	       node = s->omega0 * FW_PI - s->rotation_radps * (tk + SCENE_TOE_S);
	double x = r * cos(u), y = r * sin(u), vx = -y * rate, vy = x * rate;
	double ci = cos(s->i0 * FW_PI), si = sin(s->i0 * FW_PI), co = cos(node), so = sin(node);
	pos_e[0] = x * co - y * ci * so;
	pos_e[1] = x * so + y * ci * co;
	pos_e[2] = y * si;
	vel_e[0] = vx * co - vy * ci * so + s->rotation_radps * pos_e[1];
	vel_e[1] = vx * so + vy * ci * co - s->rotation_radps * pos_e[0];
	vel_e[2] = vy * si;
}

void scene_look(const scene_satellite *s, const scene_drone *d, double t, scene_view *view)
{
	double pos[3], vel[3], sight[3], C_e_n[3][3];
	view->range_m = 2.4e7;
	for (int i = 0; i < 4; i++) { /* until it is where it was when it sent */
		double travel_s = view->range_m / SCENE_LIGHT_MPS, turn = s->rotation_radps * travel_s;
		scene_orbit(s, t - travel_s, pos, vel);
		double x = pos[0] + turn * pos[1] - turn * turn / 2 * pos[0];
		double y = pos[1] - turn * pos[0] - turn * turn / 2 * pos[1];
		sight[0] = x - d->pos_e[0];
		sight[1] = y - d->pos_e[1];
		sight[2] = pos[2] - d->pos_e[2];
		view->range_m = sqrt(sight[0] * sight[0] + sight[1] * sight[1] + sight[2] * sight[2]);
	}
	view->range_rate_mps = 0;
	for (int i = 0; i < 3; i++) {
		sight[i] /= view->range_m;
		view->range_rate_mps += sight[i] * (vel[i] - d->vel_e[i]);
	}
	fw_frame_ned(d->llh[0], d->llh[1], C_e_n);
	fw_mat3_t_vec(C_e_n, sight, view->sight_n);
	view->elevation_rad = asin(-view->sight_n[2]);
}

void scene_sky(scene_satellite sky[static SCENE_SATELLITES])
{
	scene_drone drone;
	int n = 0;
	scene_fly(SCENE_START_S, &drone);
	for (size_t k = 0; k < sizeof constellations / sizeof constellations[0]; k++) {
		const constellation *c = &constellations[k];
		int taken = 0;
		for (int i = 0; i < c->planes * c->slots && taken < c->wanted; i++) {
			scene_satellite s = place(c, i % c->planes, i / c->planes);
			scene_view view;
			scene_look(&s, &drone, SCENE_START_S, &view);
			if (view.elevation_rad > fw_rad_from_deg(12)) {
				sky[n++] = s;
				taken++;
			}
		}
		if (taken < c->wanted)
			abort();
	}
}
