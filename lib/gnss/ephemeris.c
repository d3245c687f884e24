#include "gnss/ephemeris.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/frame.h"

#define C  FW_SPEED_OF_LIGHT_MPS
#define PI FW_PI

/* What a system's orbit rests on. */
struct model {
	double gm;      /* gravitational constant of the Earth [m^3/s^2] */
	double omega_e; /* its angular rate [rad/s] */
	double meant_s; /* the message is meant for so long before and after toe */
	double last_s;  /* and should never be used beyond this */
};

#define HOUR   3600.0
#define MINUTE 60.0

static const struct model models[FW_SYSTEM_COUNT] = {
    /** IS-GPS-200N table 20-IV */
    [FW_GPS] = {3.986005e14, 7.2921151467e-5, 2 * HOUR, 4 * HOUR},
    /** Galileo OS SIS ICD 2.1, table 59 */
    [FW_GALILEO] = {3.986004418e14, 7.2921151467e-5, 4 * HOUR, 4 * HOUR},
    /** BDS-SIS-ICD-B1I-3.0, 3.2 (CGCS2000) */
    [FW_BEIDOU] = {3.986004418e14, 7.2921150e-5, 6 * HOUR, 6 * HOUR},
    /** GLONASS ICD L1, L2, edition 5.1, table 3.2 */
    [FW_GLONASS] = {3.9860044e14, 7.292115e-5, 15 * MINUTE, 30 * MINUTE},
    /** IS-QZSS-PNT-005, 5.5 */
    [FW_QZSS] = {3.986005e14, 7.2921151467e-5, 2 * HOUR, 4 * HOUR},
    /** IRNSS SIS ICD for SPS 1.1, table 14 */
    [FW_NAVIC] = {3.986005e14, 7.2921151467e-5, 2 * HOUR, 4 * HOUR},
    /** RTCA DO-229: the message is a polynomial, nothing is integrated */
    [FW_SBAS] = {0, 0, 4 * MINUTE, 6 * MINUTE},
};

/** GLONASS ICD L1, L2, edition 5.1, table 3.2: equatorial radius [m], second zonal harmonic of the
 * geopotential */
#define GLONASS_RADIUS_M 6378136.0
#define GLONASS_J2       1.0826257e-3
/** Longest step of the integration [s]. The ICD's 60 s leave 0.5 mm after 15 min, and 2e-6 m/s between the
 * velocity and the derivative of the position; 40 s leave a fifth of that. */
#define GLONASS_STEP_S 40.0

/** BDS-SIS-ICD-B1I-3.0, table 5-11: the frame of the elements of geostationary satellites is tilted by 5
 * degrees */
#define TILT_RAD (5 * PI / 180)

/* Every navigation satellite is this far from the centre of the Earth [m], and its clock this good [s]. */
#define NEAREST_M   1e7
#define FURTHEST_M  1e8
#define CLOCK_MAX_S 1.0

/* ---- Kepler orbits ---- */

/* The eccentric anomaly E with E - e sin E = M, for 0 <= e < 1 and any M; NaN unless M is finite. On 0..pi
 * the left side is convex, so Newton's method comes down on the solution from the right without passing it:
 * the first step that does not go down is the last. Orbits need four. Near e = 1, M = 0, where the solution
 * is nearly a triple one, each step takes off a third only, down to where rounding has the last word; that is
 * within 60. */
static double eccentric_anomaly(double M, double e)
{
	const double reduced = remainder(M, 2 * PI), m = fabs(reduced);
	double E = m + e < PI ? m + e : PI;

	if (!(m <= PI))
		return (double)NAN;
	for (int i = 0; i < 60; i++) {
		const double next = E - (E - e * sin(E) - m) / (1 - e * cos(E));

		if (!(next < E))
			break;
		E = next;
	}
	return copysign(E, reduced);
}

/* BeiDou's geostationary satellites: their elements are given in a frame that does not turn with the Earth
 * and is tilted, so that the inclination is far from zero and the node well defined. Source:
 * BDS-SIS-ICD-B1I-3.0, 5.2.4.12. */
static bool is_tilted(fw_satellite s)
{
	return s.system == FW_BEIDOU && (s.number <= 5 || s.number >= 59);
}

/* Seconds of the week of toe, on the system's own scale. */
static double toe_of_week_s(const fw_ephemeris *e)
{
	int64_t tow_ns;
	int week;

	if (e->satellite.system == FW_BEIDOU)
		fw_time_to_bdt(e->toe, &week, &tow_ns);
	else
		fw_time_to_gps(e->toe, &week, &tow_ns);
	return (double)tow_ns / 1e9;
}

/* Position and velocity turned by an angle about an axis (0 x, 1 y, 2 z) that turns at `rate` [rad/s]: the
 * velocity stays the derivative of the position. */
static void turn(int axis, double angle, double rate, double p[static 3], double v[static 3])
{
	const int i = (axis + 1) % 3, j = (axis + 2) % 3;
	const double c = cos(angle), s = sin(angle);
	const double pi = p[i], pj = p[j], vi = v[i] - rate * pj, vj = v[j] + rate * pi;

	p[i] = c * pi - s * pj;
	p[j] = s * pi + c * pj;
	v[i] = c * vi - s * vj;
	v[j] = s * vi + c * vj;
}

/* Where the satellite is in its orbit, after the harmonic corrections, and the rates of it. */
struct in_orbit {
	double u, r, i; /* argument of latitude [rad], radius [m], inclination [rad] */
	double u_dot, r_dot, i_dot;
	double relativity_s, relativity_dot; /* periodic effect on the clock */
};

/* tk [s] after toe. Source: IS-GPS-200N table 20-IV, which gives the rates too (sheets 3 and 4). */
static void propagate(const fw_ephemeris *e, double gm, double tk, struct in_orbit *o)
{
	const double a = e->kepler.sqrt_a * e->kepler.sqrt_a, ecc = e->kepler.ecc;
	const double n = sqrt(gm / (a * a * a)) + e->kepler.delta_n;
	const double E = eccentric_anomaly(e->kepler.m0 + n * tk, ecc);
	const double sin_E = sin(E), cos_E = cos(E), to_focus = 1 - ecc * cos_E;
	const double E_dot = n / to_focus, root = sqrt((1 - ecc) * (1 + ecc));
	const double phi = atan2(root * sin_E, cos_E - ecc) + e->kepler.omega,
	             phi_dot = root * E_dot / to_focus;
	const double s = sin(2 * phi), c = cos(2 * phi), s_dot = 2 * phi_dot * c, c_dot = -2 * phi_dot * s;

	o->u = phi + e->kepler.cus * s + e->kepler.cuc * c;
	o->r = a * to_focus + e->kepler.crs * s + e->kepler.crc * c;
	o->i = e->kepler.i0 + e->kepler.idot * tk + e->kepler.cis * s + e->kepler.cic * c;
	o->u_dot = phi_dot + e->kepler.cus * s_dot + e->kepler.cuc * c_dot;
	o->r_dot = a * ecc * sin_E * E_dot + e->kepler.crs * s_dot + e->kepler.crc * c_dot;
	o->i_dot = e->kepler.idot + e->kepler.cis * s_dot + e->kepler.cic * c_dot;

	const double f = -2 * sqrt(gm * a) / (C * C) * ecc; /* the ICDs' F e sqrt(A) */

	o->relativity_s = f * sin_E;
	o->relativity_dot = f * cos_E * E_dot;
}

/* The parts of the systems fill a state of zeros. */
static fw_status kepler_state(const fw_ephemeris *e, const struct model *m, double tk,
                              fw_satellite_state *state)
{
	double *p = state->position_m, *v = state->velocity_mps;
	const double frame_dot = is_tilted(e->satellite) ? 0 : -m->omega_e;
	const double node_dot = e->kepler.omega_dot + frame_dot;
	const double node = e->kepler.omega0 + node_dot * tk - m->omega_e * toe_of_week_s(e);
	struct in_orbit o;

	if (!(e->kepler.ecc >= 0 && e->kepler.ecc < 1) || !(e->kepler.sqrt_a > 0))
		return FW_EINVAL;
	propagate(e, m->gm, tk, &o);
	p[0] = o.r;
	v[0] = o.r_dot;
	state->clock_s = o.relativity_s;
	state->drift_sps = o.relativity_dot;
	turn(2, o.u, o.u_dot, p, v);
	turn(0, o.i, o.i_dot, p, v);
	turn(2, node, node_dot, p, v);
	if (is_tilted(e->satellite)) {
		turn(0, TILT_RAD, 0, p, v);
		turn(2, -m->omega_e * tk, -m->omega_e, p, v);
	}
	return FW_OK;
}

/* ---- GLONASS: the equations of motion, in ECEF ---- */

struct motion {
	double p[3], v[3];
};

/* Source: GLONASS ICD L1, L2, edition 5.1, A.3.1.2, equations (1). */
static struct motion derivative(const struct motion *x, const double sun_moon_mps2[static 3])
{
	const double gm = models[FW_GLONASS].gm, w = models[FW_GLONASS].omega_e;
	const double r2 = x->p[0] * x->p[0] + x->p[1] * x->p[1] + x->p[2] * x->p[2], r3 = r2 * sqrt(r2);
	const double oblate = 1.5 * GLONASS_J2 * gm * GLONASS_RADIUS_M * GLONASS_RADIUS_M / (r2 * r3);
	const double pull = -gm / r3 - oblate * (1 - 5 * x->p[2] * x->p[2] / r2);

	return (struct motion){
	    {x->v[0], x->v[1], x->v[2]},
	    {(pull + w * w) * x->p[0] + 2 * w * x->v[1] + sun_moon_mps2[0],
	     (pull + w * w) * x->p[1] - 2 * w * x->v[0] + sun_moon_mps2[1],
	     (pull - 2 * oblate) * x->p[2] + sun_moon_mps2[2]},
	};
}

/* x + h k */
static struct motion advance(const struct motion *x, double h, const struct motion *k)
{
	struct motion y;

	for (int i = 0; i < 3; i++) {
		y.p[i] = x->p[i] + h * k->p[i];
		y.v[i] = x->v[i] + h * k->v[i];
	}
	return y;
}

/* One Runge-Kutta step of h [s]. */
static void step(struct motion *x, double h, const double sun_moon_mps2[static 3])
{
	const struct motion k1 = derivative(x, sun_moon_mps2), x1 = advance(x, h / 2, &k1);
	const struct motion k2 = derivative(&x1, sun_moon_mps2), x2 = advance(x, h / 2, &k2);
	const struct motion k3 = derivative(&x2, sun_moon_mps2), x3 = advance(x, h, &k3);
	const struct motion k4 = derivative(&x3, sun_moon_mps2);

	for (int i = 0; i < 3; i++) {
		x->p[i] += h / 6 * (k1.p[i] + 2 * k2.p[i] + 2 * k3.p[i] + k4.p[i]);
		x->v[i] += h / 6 * (k1.v[i] + 2 * k2.v[i] + 2 * k3.v[i] + k4.v[i]);
	}
}

static void glonass_state(const fw_ephemeris *e, double tk, fw_satellite_state *state)
{
	struct motion x;

	memcpy(x.p, e->state.position_m, sizeof x.p);
	memcpy(x.v, e->state.velocity_mps, sizeof x.v);
	for (; fabs(tk) > GLONASS_STEP_S; tk -= copysign(GLONASS_STEP_S, tk))
		step(&x, copysign(GLONASS_STEP_S, tk), e->state.acceleration_mps2);
	for (int half = 0; half < 2;
	     half++) /* so that the velocity is the derivative of the position to 1e-6 m/s */
		step(&x, tk / 2, e->state.acceleration_mps2);
	memcpy(state->position_m, x.p, sizeof x.p);
	memcpy(state->velocity_mps, x.v, sizeof x.v);
}

/* ---- SBAS ---- */

static void sbas_state(const fw_ephemeris *e, double tk, fw_satellite_state *state)
{
	for (int i = 0; i < 3; i++) {
		const double v = e->state.velocity_mps[i], a = e->state.acceleration_mps2[i];

		state->position_m[i] = e->state.position_m[i] + tk * (v + tk / 2 * a);
		state->velocity_mps[i] = v + tk * a;
	}
}

/* ---- any system ---- */

/* Numbers that no navigation satellite could send make no state. NaN fails. */
static fw_status check(const fw_satellite_state *s)
{
	const double *p = s->position_m, *v = s->velocity_mps;
	const double r2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2],
	             v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];

	if (!isfinite(r2) || !isfinite(v2) || !isfinite(s->clock_s) || !isfinite(s->drift_sps))
		return FW_ENONFINITE;
	if (r2 < NEAREST_M * NEAREST_M || r2 > FURTHEST_M * FURTHEST_M || fabs(s->clock_s) > CLOCK_MAX_S)
		return FW_EINVAL;
	return FW_OK;
}

fw_status fw_ephemeris_state(const fw_ephemeris *e, fw_time t, fw_satellite_state *state)
{
	if (e->satellite.system >= FW_SYSTEM_COUNT)
		return FW_EINVAL;

	const struct model *m = &models[e->satellite.system];
	const double tk = fw_time_diff_s(t, e->toe), since_toc = fw_time_diff_s(t, e->toc);
	fw_satellite_state s = {0};
	fw_status status = FW_OK;

	if (fabs(tk) > m->last_s)
		return FW_ERANGE;
	if (e->satellite.system == FW_GLONASS)
		glonass_state(e, tk, &s);
	else if (e->satellite.system == FW_SBAS)
		sbas_state(e, tk, &s);
	else
		status = kepler_state(e, m, tk, &s);
	if (status < 0)
		return status;
	s.clock_s += e->af0_s + since_toc * (e->af1_sps + since_toc * e->af2_sps2);
	s.drift_sps += e->af1_sps + 2 * since_toc * e->af2_sps2;
	status = check(&s);
	if (status < 0)
		return status;
	*state = s;
	return fabs(tk) > m->meant_s ? FW_DUBIOUS : FW_OK;
}

/* ---- group delays ---- */

/* One row: the delay of a signal is factor[0] tgd[0] + factor[1] tgd[1]. */
struct delay {
	fw_nav_message message;
	fw_system system;
	char band;
	const char *attributes; /* of the signals; NULL: all in the band */
	double factor[2];
};

#define SQUARE(x) ((x) * (x))

/** Galileo: (f_E1/f_E5a)^2, (f_E1/f_E5b)^2 */
#define GAMMA_5A SQUARE(154.0 / 115)
#define GAMMA_5B SQUARE(154.0 / 118)

static const struct delay delays[] = {
    /* The clock is that of L1 P(Y) and L2 P(Y), ionosphere-free (IS-GPS-200N, 20.3.3.3.3.2). What C/A differs
     * from P(Y) is not in this message. */
    {FW_NAV_LNAV, FW_GPS, '1', NULL, {1}},
    {FW_NAV_LNAV, FW_GPS, '2', NULL, {SQUARE(77.0 / 60)}},
    /* IS-QZSS-PNT-005, 5.8: as GPS */
    {FW_NAV_LNAV, FW_QZSS, '1', NULL, {1}},
    {FW_NAV_LNAV, FW_QZSS, '2', NULL, {SQUARE(77.0 / 60)}},
    /* S and L5, ionosphere-free (IRNSS SIS ICD for SPS 1.1, 6.2.1.5) */
    {FW_NAV_LNAV, FW_NAVIC, '9', NULL, {1}},
    {FW_NAV_LNAV, FW_NAVIC, '5', NULL, {SQUARE(2492.028 / 1176.45)}},
    /* Galileo OS SIS ICD 2.1, 5.1.5: I/NAV is for E1 and E5b, F/NAV for E1 and E5a. On the clock of I/NAV E1
     * is late by BGD(E1,E5b), and E5a lags behind E1 by (gamma - 1) BGD(E1,E5a). */
    {FW_NAV_INAV, FW_GALILEO, '1', NULL, {0, 1}},
    {FW_NAV_INAV, FW_GALILEO, '7', NULL, {0, GAMMA_5B}},
    {FW_NAV_INAV, FW_GALILEO, '5', NULL, {GAMMA_5A - 1, 1}},
    {FW_NAV_FNAV, FW_GALILEO, '1', NULL, {1}},
    {FW_NAV_FNAV, FW_GALILEO, '5', NULL, {GAMMA_5A}},
    /* The clock is that of B3I (BDS-SIS-ICD-B1I-3.0, 5.2.4.10). RINEX has the later signals in the same
     * bands. */
    {FW_NAV_D1D2, FW_BEIDOU, '2', "IQX", {1}},
    {FW_NAV_D1D2, FW_BEIDOU, '7', "IQX", {0, 1}},
    {FW_NAV_D1D2, FW_BEIDOU, '6', "IQX", {0}},
    /* tau_n is that of L1, delta tau_n how much later L2 is sent (GLONASS ICD L1, L2, edition 5.1, 4.4) */
    {FW_NAV_FDMA, FW_GLONASS, '1', "CP", {0}},
    {FW_NAV_FDMA, FW_GLONASS, '2', "CP", {1}},
    {FW_NAV_SBAS, FW_SBAS, '1', NULL, {0}},
};

static bool concerns(const struct delay *d, const fw_ephemeris *e, fw_signal signal)
{
	return d->message == e->message && d->system == e->satellite.system && d->band == signal.band &&
	       (d->attributes == NULL ||
	        memchr(d->attributes, signal.attribute, strlen(d->attributes)) != NULL);
}

fw_status fw_ephemeris_group_delay(const fw_ephemeris *e, fw_signal signal, double *delay_s)
{
	*delay_s = 0;
	for (size_t i = 0; i < sizeof delays / sizeof delays[0]; i++) {
		if (!concerns(&delays[i], e, signal))
			continue;
		*delay_s = delays[i].factor[0] * e->tgd_s[0] + delays[i].factor[1] * e->tgd_s[1];
		return FW_OK;
	}
	return FW_EUNKNOWN;
}
