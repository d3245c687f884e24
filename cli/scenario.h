/* The scenario of a simulation: an INI file (gnss-sim(1) lists its keys) turned into what lib/sim takes.
 *
 * Every key is one line of a table: section, name, unit, range, default. Sections [mask NAME] and [fault
 * NAME] may come as often as there are names. Messages begin FILE:LINE: and name the nearest known key. */
#ifndef FURROW_CLI_SCENARIO_H
#define FURROW_CLI_SCENARIO_H

#include <limits.h>
#include <stdio.h>

#include "sim/receiver.h"
#include "sim/sensors.h"
#include "sim/trajectory.h"
#include "tool.h"

enum { SCENARIO_TEXT = 256, SCENARIO_LIST = 32, SCENARIO_NAME = 48, SCENARIO_ROUTE = FW_WAYPOINTS_MAX };

/* A list of numbers. */
typedef struct {
	unsigned n;
	double value[SCENARIO_LIST];
} scenario_list;

/* A line of the route: a waypoint, one by latitude and longitude, or rows. */
typedef enum { ROUTE_WAYPOINT, ROUTE_PLACE, ROUTE_ROWS } scenario_route_kind;
typedef struct {
	scenario_route_kind kind;
	int line; /* of the file; 0: --set */
	double value[9];
	unsigned n;
} scenario_route;

typedef struct {
	char name[SCENARIO_NAME];
	int line;
	fw_mask mask;
} scenario_mask;

typedef struct {
	char name[SCENARIO_NAME];
	int line;
	fw_fault fault;
} scenario_fault;

/* Zeroed by scenario_defaults, and large: not for the stack. Numbers are in SI units, as lib/sim has them. */
typedef struct {
	const char *file;

	fw_time start;
	double duration_s; /* 0: as long as the trajectory */
	double seed;
	double truth_rate_hz; /* 0: that of the IMU */

	fw_trajectory_setup path;
	int vehicle; /* fw_vehicle */
	char table[SCENARIO_TEXT];
	double table_spacing_s;
	unsigned n_route;
	scenario_route route[SCENARIO_ROUTE];

	int imu_grade;
	double imu_rate_hz;
	fw_imu_model imu;
	double mag_rate_hz;
	fw_magnetometer_model mag;
	double baro_rate_hz;
	fw_barometer_model baro;

	int clock_name;
	fw_clock_model clock;

	char nav_file[SCENARIO_TEXT];
	char systems[SCENARIO_TEXT];
	fw_sky_errors sky;

	double gnss_rate_hz;
	char signals[SCENARIO_TEXT];
	double lever_m[3]; /* from the body's reference point to the main antenna, body axes */
	bool aux_observations;
	fw_receiver_setup rover;
	int pvt_mode; /* 0 stand-alone, 1 SBAS */
	double section_s, section_from_s;
	scenario_list section[4]; /* variances: horizontal, vertical; the same of velocity */

	bool has_base;
	double base_rate_hz;
	double base_place_m[3]; /* north, east, up of the origin */
	double base_multipath_m;
	int base_clock_name;
	fw_clock_model base_clock;

	double camera_interval_s, camera_distance_m, camera_from_s, camera_until_s, camera_speed_mps;

	unsigned n_masks, n_faults;
	scenario_mask mask[FW_RECEIVER_MASKS];
	scenario_fault fault[FW_RECEIVER_FAULTS];
} scenario;

/* Sets every key to its default. */
void scenario_defaults(scenario *s);

/* Reads a file. Returns an exit status: EXIT_COMPLETE, or after a message EXIT_USAGE (what it says) or
 * EXIT_IO. */
int scenario_read(scenario *s, const tool *t, const char *file) FW_MUST_CHECK;

/* One setting SECTION.KEY=VALUE of the command line. Returns EXIT_COMPLETE or, after a message, EXIT_USAGE.
 */
int scenario_set(scenario *s, const tool *t, const char *assignment) FW_MUST_CHECK;

/* Puts the parts together that depend on more than one key: signals, masks, faults, sections, and the
 * base's receiver. Returns EXIT_COMPLETE or, after a message, EXIT_USAGE. */
int scenario_complete(scenario *s, const tool *t, fw_receiver_setup *base) FW_MUST_CHECK;

/* Makes the trajectory. From a table it goes on using memory that it takes and never gives back, and the
 * start is that of the table. Returns EXIT_COMPLETE or, after a message, EXIT_USAGE or EXIT_IO. */
int scenario_trajectory(scenario *s, const tool *t, fw_trajectory *trajectory) FW_MUST_CHECK;

/* Writes all settings in force, as a scenario file. */
void scenario_print(const scenario *s, FILE *to);

/* PATH as a file beside the scenario file, unless it is absolute. Returns false when it is too long. */
bool scenario_path(const scenario *s, const char *path, char full[static SCENARIO_TEXT + PATH_MAX]);

#endif
