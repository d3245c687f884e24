/* The world of testdata/demo.sbf: a small survey drone that flies lines over a field, and the satellites above it.
 * Time t is GPS time of week [s] all through; frames and signs as in base/frame.h. */
#ifndef FURROW_TESTS_DEMO_SCENE_H
#define FURROW_TESTS_DEMO_SCENE_H

#include <stdint.h>

enum {
	SCENE_WEEK = 2422,      /* 2026-06-10, a Wednesday */
	SCENE_START_S = 289815, /* 08:30:15: three seconds before the end of a GPS subframe 3 */
	SCENE_SECONDS = 60,
	SCENE_SATELLITES = 14,
	SCENE_TOE_S = 288000 /* reference of all orbits, in the system's own time of week; not GLONASS */
};

#define SCENE_LIGHT_MPS 299792458.0

/* The drone at a moment. */
typedef struct {
	double llh[3];      /* rad, rad, m */
	double pos_e[3];    /* m */
	double vel_n[3];    /* north, east, down [m/s] */
	double vel_e[3];    /* ECEF [m/s] */
	double rpy[3];      /* roll, pitch, heading [rad] */
	double rpy_rate[3]; /* their rates [rad/s] */
	double force_b[3];  /* specific force, forward, right, down [m/s2] */
	double turn_b[3];   /* angular rate about the same axes [rad/s] */
} scene_drone;

/* A satellite on a circular orbit. Angles in semi-circles, as broadcast. */
typedef struct {
	char name[5];        /* "G05", "S123" */
	uint8_t svid;        /* SBF's number */
	int channel;         /* GLONASS frequency number, else 0 */
	unsigned signals[2]; /* SBF's signal numbers */
	double sqrt_a;       /* square root of the radius [m^0.5] */
	double i0, omega0, m0;
	double clock_s;  /* ahead of system time */
	double usable_s; /* its ephemeris is known from this second of the log on */
	double mu_m3ps2, rotation_radps;
	double delay_s; /* GPS time minus the system's time that SCENE_TOE_S counts in */
} scene_satellite;

/* What a satellite looks like from the drone. */
typedef struct {
	double range_m; /* from where it was to where the drone is, the Earth's turn meanwhile included */
	double range_rate_mps;
	double sight_n[3]; /* unit vector to the satellite, north, east, down */
	double elevation_rad;
} scene_view;

/* The first SCENE_SATELLITES of a full sky that stand high enough at the start. */
void scene_sky(scene_satellite sky[static SCENE_SATELLITES]);

void scene_fly(double t, scene_drone *drone);

/* Position [m] and velocity [m/s] of a satellite in ECEF. */
void scene_orbit(const scene_satellite *satellite, double t, double pos_e[static 3], double vel_e[static 3]);

void scene_look(const scene_satellite *satellite, const scene_drone *drone, double t, scene_view *view);

/* The receiver's clock: GPS time is receiver time minus this [s]; it drifts by SCENE_CLOCK_DRIFT. */
#define SCENE_CLOCK_DRIFT 0.21e-6
double scene_clock_s(double t);

#endif
