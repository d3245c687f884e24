#include "sim/constellation.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/random.h"

/** IS-GPS-200N 20.3.3.4.3.3, Galileo OS SIS ICD 2.1 5.1.1, BDS-SIS-ICD-B1I-3.0 5.2.4.12, GLONASS ICD 5.1
 * A.3.1.2: what is broadcast is in semi-circles of this pi */
#define ICD_PI 3.1415926535898

enum { GLONASS_INTERVAL_S = 1800, CLOCK_STEP = 225 };

/* A shell of satellites: planes evenly round the equator, satellites evenly round each plane, each plane's
 * satellites ahead of those of the plane before by phase_deg. */
typedef struct {
	fw_system system;
	fw_nav_message message;
	unsigned n, planes;
	const uint8_t *numbers;
	double axis_m, inclination_deg, phase_deg, ecc;
	double node_rate_radps; /* of the plane, in inertial space */
	int interval_s;         /* between ephemerides */
} shell;

static const uint8_t gps_numbers[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15, 16,
                                      17, 18, 19, 20, 21, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32};
static const uint8_t galileo_numbers[] = {1,  2,  3,  4,  5,  7,  8,  9,  10, 11, 12, 13,
                                          15, 19, 21, 24, 25, 26, 27, 30, 31, 33, 34, 36};
static const uint8_t beidou_meo_numbers[] = {19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30,
                                             32, 33, 34, 35, 36, 37, 41, 42, 43, 44, 45, 46};
static const uint8_t beidou_igso_numbers[] = {38, 39, 40};

/* Sources of the nominal orbits: GPS SPS Performance Standard 5 (2020), 3.2; Galileo OS SDD 1.3, annex A;
 * BeiDou OS Performance Standard 3.0, 3.1.1. */
static const shell shells[] = {
    {FW_GPS, FW_NAV_LNAV, 31, 6, gps_numbers, 26559710, 55, 24, 0.008, -8.0e-9, 7200},
    {FW_GALILEO, FW_NAV_INAV, 24, 3, galileo_numbers, 29600318, 56, 15, 0.0003, -5.4e-9, 3600},
    {FW_BEIDOU, FW_NAV_D1D2, 24, 3, beidou_meo_numbers, 27906100, 55, 15, 0.0008, -6.8e-9, 3600},
    {FW_BEIDOU, FW_NAV_D1D2, 3, 3, beidou_igso_numbers, 42164200, 55, 240, 0.003, 0, 3600},
};
enum { N_SHELLS = sizeof shells / sizeof shells[0] };

/** BeiDou OS Performance Standard 3.0, 3.1.1: places of the geostationary satellites C01 to C05 */
static const double beidou_geo_deg[] = {140, 80, 110.5, 160, 58.75};

/** GLONASS ICD 5.1, 4.4 and the agency's constellation status: frequency numbers of slots 1 to 24, antipodes
 * share one */
static const int8_t glonass_channels[] = {1,  -4, 5, 6,  1, -4, 5, 6, -2, -7, 0, -1,
                                          -2, -7, 0, -1, 4, -3, 3, 2, 4,  -3, 3, 2};

static double to_step(double x, double step)
{
	return nearbyint(x / step) * step;
}

/* To the 2^-bits of a semi-circle. */
static double angle_to_bits(double rad, int bits)
{
	return to_step(rad, ldexp(ICD_PI, -bits));
}

static double between(fw_random *r, double low, double high)
{
	return low + (high - low) * fw_random_uniform(r);
}

static double gravitation(fw_system system)
{
	return system == FW_GPS ? 3.986005e14 : 3.986004418e14;
}

static double earth_rate(fw_system system)
{
	return system == FW_BEIDOU ? 7.292115e-5 : 7.2921151467e-5;
}

/* Seconds of the system's own week: BeiDou's runs 14 s behind. */
static double system_tow_s(fw_system system, fw_time t)
{
	int week;
	int64_t tow_ns;
	if (system == FW_BEIDOU)
		fw_time_to_bdt(t, &week, &tow_ns);
	else
		fw_time_to_gps(t, &week, &tow_ns);
	return (double)tow_ns / 1e9;
}

/* A satellite's own: what does not change from one ephemeris to the next, and where node and anomaly were
 * at time 0. */
typedef struct {
	fw_ephemeris e;
	double node0_rad;    /* longitude, Earth-fixed, at GPS time 0 */
	double anomaly0_rad; /* mean anomaly at GPS time 0 */
	double clock_start;  /* where the clock was at GPS time 0, as a fraction of its period */
	int clock_slope;     /* -1, 0, 1 */
} satellite;

/* The clock runs up and down a slope for years, between +-0.4 ms. Slopes are such that from one toe to the next
 * the offset changes by CLOCK_STEP of the steps that it is sent in: ephemerides of a satellite agree on its clock
 * to the last bit. GLONASS's clocks, sent more coarsely, stand. */
static void set_clock(const satellite *s, fw_time t, int interval_s, fw_ephemeris *e)
{
	static const int bits[] = {[FW_GPS] = 31, [FW_GALILEO] = 34, [FW_BEIDOU] = 33, [FW_GLONASS] = 30};
	double step_s = ldexp(1, -bits[e->satellite.system]);
	int64_t top = (int64_t)(0.4e-3 / step_s) / CLOCK_STEP, period = 4 * top;
	int64_t intervals = e->satellite.system == FW_GLONASS ? 0 : t.ns / FW_NS_PER_S / interval_s;
	int64_t at = ((int64_t)(s->clock_start * (double)period) + s->clock_slope * intervals) % period;
	if (at < 0)
		at += period;
	bool rising = at < 2 * top;
	e->toc = t;
	e->af0_s = (double)(CLOCK_STEP * (rising ? at - top : 3 * top - at)) * step_s;
	e->af1_sps =
	    intervals == 0 ? 0 : (rising ? 1 : -1) * s->clock_slope * CLOCK_STEP * step_s / interval_s;
	e->af2_sps2 = 0;
}

static void set_group_delays(fw_ephemeris *e, fw_random *r)
{
	double first = between(r, -12e-9, 12e-9), second = first + between(r, -1e-9, 1e-9);
	double step = e->satellite.system == FW_GPS       ? ldexp(1, -31)
	              : e->satellite.system == FW_GALILEO ? ldexp(1, -32)
	                                                  : 1e-10;
	e->tgd_s[0] = to_step(first, step);
	e->tgd_s[1] = e->satellite.system == FW_GPS ? 0 : to_step(second, step);
}

static void set_harmonics(fw_ephemeris *e, fw_random *r)
{
	double angle = ldexp(1, e->satellite.system == FW_BEIDOU ? -31 : -29);
	double length = ldexp(1, e->satellite.system == FW_BEIDOU ? -6 : -5);
	e->kepler.cuc = to_step(between(r, -5e-6, 5e-6), angle);
	e->kepler.cus = to_step(between(r, 4e-6, 1e-5), angle);
	e->kepler.cic = to_step(between(r, -1e-7, 1e-7), angle);
	e->kepler.cis = to_step(between(r, -1e-7, 1e-7), angle);
	e->kepler.crc = to_step(between(r, 150, 300), length);
	e->kepler.crs = to_step(between(r, -100, 100), length);
}

static satellite make_satellite(fw_system system, fw_nav_message message, uint8_t number, double axis_m,
                                double ecc)
{
	fw_random r;
	satellite s = {.e = {.satellite = {(uint8_t)system, number}, .message = message, .healthy = true}};
	fw_random_init(&r, fw_satellite_index(s.e.satellite));
	s.e.accuracy_m = system == FW_GALILEO ? 3.12 : 2.0;
	s.e.kepler.sqrt_a = to_step(sqrt(axis_m), ldexp(1, -19));
	s.e.kepler.ecc = to_step(ecc * between(&r, 0.3, 1.7), ldexp(1, -33));
	s.e.kepler.omega = angle_to_bits(between(&r, -FW_PI, FW_PI), 31);
	s.clock_start = fw_random_uniform(&r);
	s.clock_slope = (int)fw_random_below(&r, 3) - 1;
	set_group_delays(&s.e, &r);
	set_harmonics(&s.e, &r);
	return s;
}

static satellite shell_satellite(const shell *sh, unsigned k)
{
	satellite s = make_satellite(sh->system, sh->message, sh->numbers[k], sh->axis_m, sh->ecc);
	unsigned plane = k % sh->planes, slot = k / sh->planes;
	unsigned in_plane = sh->n / sh->planes + (plane < sh->n % sh->planes);
	double argument_deg = 360.0 * slot / in_plane + sh->phase_deg * plane;

	s.e.kepler.i0 = angle_to_bits(fw_rad_from_deg(sh->inclination_deg), 31);
	s.e.kepler.omega_dot = angle_to_bits(sh->node_rate_radps, 43);
	s.e.kepler.delta_n = angle_to_bits(4.4e-9, 43);
	s.node0_rad = 2 * FW_PI * plane / sh->planes + (int)sh->system;
	s.anomaly0_rad = fw_rad_from_deg(argument_deg) - s.e.kepler.omega;
	return s;
}

/* Makes the satellite go round once a sidereal day. */
static void synchronise(satellite *s)
{
	double mu = gravitation((fw_system)s->e.satellite.system),
	       a = s->e.kepler.sqrt_a * s->e.kepler.sqrt_a;
	s->e.kepler.delta_n = angle_to_bits(earth_rate(FW_BEIDOU) - sqrt(mu / (a * a * a)), 43);
}

/* The inclined three: their figures of eight cross the equator at 118 degrees east. */
static satellite igso_satellite(const shell *sh, unsigned k)
{
	satellite s = shell_satellite(sh, k);
	double argument = fw_rad_from_deg(sh->phase_deg * (double)k);
	synchronise(&s);
	s.node0_rad = fw_rad_from_deg(118) - argument;
	s.anomaly0_rad = argument - s.e.kepler.omega;
	return s;
}

/* BDS-SIS-ICD-B1I-3.0, 5.2.4.12: the orbit of a geostationary satellite is given in a plane that is tilted
 * by 5 degrees against the equator about the x axis at toe; there it is an orbit of 5 degrees whose node
 * lies on that axis. */
static satellite geo_satellite(unsigned k)
{
	satellite s = make_satellite(FW_BEIDOU, FW_NAV_D1D2, (uint8_t)(k + 1), 42164200, 0.0003);
	s.e.kepler.i0 = angle_to_bits(fw_rad_from_deg(5), 31);
	synchronise(&s);
	s.node0_rad = FW_PI;
	s.anomaly0_rad = fw_rad_from_deg(beidou_geo_deg[k]) - FW_PI - s.e.kepler.omega;
	/* The node is laid anew at each toe; harmonics that count from it would make steps. */
	s.e.kepler.cuc = s.e.kepler.cus = s.e.kepler.cic = s.e.kepler.cis = s.e.kepler.crc = s.e.kepler.crs =
	    0;
	return s;
}

/* The ephemeris of a satellite for toe. */
static fw_ephemeris ephemeris_at(const satellite *s, fw_time toe, int interval_s, bool geo)
{
	fw_ephemeris e = s->e;
	fw_system system = (fw_system)e.satellite.system;
	double t_s = (double)toe.ns / 1e9, a = e.kepler.sqrt_a * e.kepler.sqrt_a, rate = earth_rate(system);
	double motion = sqrt(gravitation(system) / (a * a * a)) + e.kepler.delta_n;
	double node = s->node0_rad, anomaly = s->anomaly0_rad;

	anomaly += fmod(motion * t_s, 2 * FW_PI);
	if (geo) /* the perigee stays where it is among the stars, the node goes with the Earth */
		e.kepler.omega =
		    angle_to_bits(fw_wrap_pi(e.kepler.omega - fmod(motion * t_s, 2 * FW_PI)), 31);
	else
		node += fmod((e.kepler.omega_dot - rate) * t_s, 2 * FW_PI);
	e.toe = toe;
	e.kepler.m0 = angle_to_bits(fw_wrap_pi(anomaly), 31);
	e.kepler.omega0 = angle_to_bits(fw_wrap_pi(node + rate * system_tow_s(system, toe)), 31);
	e.issue = (int32_t)(toe.ns / FW_NS_PER_S / interval_s %
	                    (system == FW_GPS      ? 240
	                     : system == FW_BEIDOU ? 24
	                                           : 1024));
	set_clock(s, toe, interval_s, &e);
	return e;
}

/* ---- GLONASS ---- */

/* A circular orbit at time t, Earth-fixed. */
static void glonass_start(unsigned k, fw_time t, fw_ephemeris *e)
{
	double a = 25508000, rate = 7.292115e-5, mu = 3.9860044e14, motion = sqrt(mu / (a * a * a));
	double t_s = (double)t.ns / 1e9, incl = fw_rad_from_deg(64.8), node_rate = -6.8e-9 - rate;
	double node = 2 * FW_PI * (k / 8) / 3.0 + fmod(node_rate * t_s, 2 * FW_PI);
	double u = fw_rad_from_deg(45.0 * (k % 8) + 15.0 * (k / 8)) + fmod(motion * t_s, 2 * FW_PI);
	double in_plane[2][2] = {{a * cos(u), a * sin(u)}, {-a * motion * sin(u), a * motion * cos(u)}},
	       fixed[2][3];
	for (int i = 0; i < 2; i++) {
		double x = in_plane[i][0], y = in_plane[i][1] * cos(incl);
		fixed[i][0] = x * cos(node) - y * sin(node);
		fixed[i][1] = x * sin(node) + y * cos(node);
		fixed[i][2] = in_plane[i][1] * sin(incl);
	}
	fixed[1][0] -= node_rate * fixed[0][1];
	fixed[1][1] += node_rate * fixed[0][0];
	memcpy(e->state.position_m, fixed[0], sizeof fixed[0]);
	memcpy(e->state.velocity_mps, fixed[1], sizeof fixed[1]);
}

/* What is broadcast of it: GLONASS ICD 5.1, table 4.5 */
static fw_ephemeris glonass_rounded(const fw_ephemeris *exact)
{
	fw_ephemeris e = *exact;
	for (int i = 0; i < 3; i++) {
		e.state.position_m[i] = to_step(e.state.position_m[i], 1e3 * ldexp(1, -11));
		e.state.velocity_mps[i] = to_step(e.state.velocity_mps[i], 1e3 * ldexp(1, -20));
	}
	return e;
}

/* Half an hour on, by the system's own equations of motion. */
static fw_status glonass_step(fw_ephemeris *e)
{
	fw_satellite_state state;
	fw_time next = fw_time_add_ns(e->toe, GLONASS_INTERVAL_S * FW_NS_PER_S);
	fw_status status = fw_ephemeris_state(e, next, &state);
	if (status < 0)
		return status;
	memcpy(e->state.position_m, state.position_m, sizeof state.position_m);
	memcpy(e->state.velocity_mps, state.velocity_mps, sizeof state.velocity_mps);
	e->toe = e->toc = next;
	return FW_OK;
}

static void glonass_clock(const satellite *s, fw_ephemeris *e)
{
	int n4, nt;
	int64_t tod_ns = 0;
	set_clock(s, e->toe, GLONASS_INTERVAL_S, e);
	if (fw_time_to_glonass(e->toe, &n4, &nt, &tod_ns) >= 0)
		e->issue = (int32_t)(tod_ns / (900 * FW_NS_PER_S)); /* the ICD's t_b */
}

/* ---- all of them ---- */

typedef struct {
	fw_time first, last; /* ephemerides with toe in here are wanted, and one more */
	unsigned room, n;
	fw_ephemeris *out;
} list;

static fw_status append(list *l, const fw_ephemeris *e)
{
	if (l->n == l->room)
		return FW_ENOSPACE;
	l->out[l->n++] = *e;
	return FW_OK;
}

/* The first toe of a series not before t: multiples of the interval after `offset_s`. */
static fw_time first_toe(fw_time t, int interval_s, int offset_s)
{
	int64_t step = interval_s * FW_NS_PER_S, from = t.ns - offset_s * FW_NS_PER_S;
	return (fw_time){(from + step - 1) / step * step + offset_s * FW_NS_PER_S};
}

static fw_status append_all(list *l, const satellite *s, int interval_s, bool geo)
{
	int64_t reach = 2 * interval_s * FW_NS_PER_S;
	int offset_s = s->e.satellite.system == FW_BEIDOU ? 14 : 0; /* BeiDou time: GPS time - 14 s */
	fw_time toe = first_toe(fw_time_add_ns(l->first, -reach), interval_s, offset_s);
	fw_status status = FW_OK;
	for (; status == FW_OK && toe.ns <= l->last.ns + reach; toe.ns += reach / 2) {
		fw_ephemeris e = ephemeris_at(s, toe, interval_s, geo);
		status = append(l, &e);
	}
	return status;
}

static fw_status append_glonass(list *l, unsigned k)
{
	int64_t reach = 2 * GLONASS_INTERVAL_S * FW_NS_PER_S;
	int leap_s;
	fw_status status = fw_time_leap_seconds(l->first, &leap_s);
	if (status < 0)
		return status;
	satellite s = make_satellite(FW_GLONASS, FW_NAV_FDMA, (uint8_t)(k + 1), 25508000, 0);
	fw_ephemeris exact = {
	    .satellite = s.e.satellite, .message = FW_NAV_FDMA, .healthy = true, .accuracy_m = 4};
	exact.tgd_s[0] = to_step(s.e.tgd_s[0] / 3, ldexp(1, -30));
	exact.state.channel = glonass_channels[k];
	exact.toe = first_toe(fw_time_add_ns(l->first, -reach), GLONASS_INTERVAL_S, 900 + leap_s);
	glonass_start(k, exact.toe, &exact);
	for (status = FW_OK; status == FW_OK && exact.toe.ns <= l->last.ns + reach;) {
		glonass_clock(&s, &exact);
		fw_ephemeris e = glonass_rounded(&exact);
		status = append(l, &e);
		if (status == FW_OK)
			status = glonass_step(&exact);
	}
	return status;
}

static fw_status append_shell(list *l, const shell *sh)
{
	fw_status status = FW_OK;
	for (unsigned k = 0; k < sh->n && status == FW_OK; k++) {
		satellite s =
		    sh->numbers == beidou_igso_numbers ? igso_satellite(sh, k) : shell_satellite(sh, k);
		status = append_all(l, &s, sh->interval_s, false);
	}
	return status;
}

fw_status fw_constellation(fw_time from, fw_time until, unsigned systems, unsigned room,
                           fw_ephemeris *ephemerides, unsigned *n)
{
	list l = {from, until, room, 0, ephemerides};
	fw_status status = until.ns >= from.ns ? FW_OK : FW_EINVAL;
	for (unsigned i = 0; i < N_SHELLS && status == FW_OK; i++)
		if (systems >> shells[i].system & 1)
			status = append_shell(&l, &shells[i]);
	for (unsigned k = 0; k < 5 && status == FW_OK && systems >> FW_BEIDOU & 1; k++) {
		satellite s = geo_satellite(k);
		status = append_all(&l, &s, 3600, true);
	}
	for (unsigned k = 0; k < 24 && status == FW_OK && systems >> FW_GLONASS & 1; k++)
		status = append_glonass(&l, k);
	if (status == FW_OK)
		*n = l.n;
	return status;
}
