/* Prints the states of satellites, for comparison with other programs.
 *
 * usage: satellite_states NAVIGATION OFFSET...
 *            each ephemeris of a RINEX file, OFFSET [s] after its toe
 *        satellite_states -p SP3 CLOCKS BEGIN STEP N
 *            each satellite, N times from BEGIN [ns of GPST] in steps of STEP [ns]; CLOCKS is a RINEX clock
 *            file, or - for the clocks of SP3
 *
 * A line is: satellite, message, toe [ns], af0 [s], time [ns], status, x, y, z [m], vx, vy, vz [m/s], clock [s],
 * drift [s/s]; behind a negative status there is nothing. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/ephemerides.h"
#include "formats/rinex_clock.h"
#include "formats/rinex_nav.h"
#include "formats/sp3.h"
#include "gnss/precise.h"

static fw_input input[2];
static fw_rinex_nav navigation;
static fw_sp3_reader sp3;
static fw_rinex_clock_reader clocks;
static fw_precise precise;

static void print(fw_satellite satellite, int message, fw_time toe, double af0_s, fw_time t, fw_status status,
                  const fw_satellite_state *s)
{
	char name[5];

	fw_satellite_name(satellite, name);
	printf("%s,%d,%" PRId64 ",%.17g,%" PRId64 ",%d", name, message, toe.ns, af0_s, t.ns, status);
	for (int i = 0; i < 3 && status >= 0; i++)
		printf(",%.17g", s->position_m[i]);
	for (int i = 0; i < 3 && status >= 0; i++)
		printf(",%.17g", s->velocity_mps[i]);
	if (status >= 0)
		printf(",%.17g,%.17g", s->clock_s, s->drift_sps);
	putchar('\n');
}

static void open_input(fw_input *in, const char *name)
{
	if (fw_input_open(in, name) != FW_OK) {
		fprintf(stderr, "satellite_states: %s: cannot be opened\n", name);
		exit(3);
	}
}

static int broadcast(int n_offsets, char **offsets)
{
	fw_any_record record;
	fw_kind kind;
	fw_status status;

	fw_rinex_nav_begin(&navigation, &input[0]);
	while ((status = fw_rinex_nav_read(&navigation, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		fw_ephemeris e;
		fw_satellite_state s;

		if (status != FW_OK || ephemeris_of_record(kind, &record, &e) != FW_OK)
			continue;
		for (int i = 0; i < n_offsets; i++) {
			const fw_time t = fw_time_add_ns(e.toe, (int64_t)(strtod(offsets[i], NULL) * 1e9));

			print(e.satellite, (int)e.message, e.toe, e.af0_s, t, fw_ephemeris_state(&e, t, &s),
			      &s);
		}
	}
	return status == FW_EOF ? 0 : 1;
}

static void read_until(fw_time t, bool sp3_clocks)
{
	fw_sp3_point p;
	fw_rinex_clock_point c;

	while (fw_precise_wants_orbits(&precise, t) && fw_sp3_read(&sp3, &p) == FW_OK) {
		if (p.has_position &&
		    fw_precise_add_position(&precise, p.time, p.satellite, p.position_m) < 0)
			exit(1);
		if (sp3_clocks && p.has_clock &&
		    fw_precise_add_clock(&precise, p.time, p.satellite, p.clock_s) < 0)
			exit(1);
	}
	while (!sp3_clocks && fw_precise_wants_clocks(&precise, t) &&
	       fw_rinex_clock_read(&clocks, &c) == FW_OK)
		if (fw_precise_add_clock(&precise, c.time, c.satellite, c.clock_s) < 0)
			exit(1);
}

static int from_tables(bool sp3_clocks, fw_time t, int64_t step_ns, int n)
{
	fw_sp3_begin(&sp3, &input[0]);
	fw_rinex_clock_begin(&clocks, &input[1]);
	fw_precise_init(&precise);
	for (; n > 0; n--, t.ns += step_ns) {
		read_until(t, sp3_clocks);
		for (unsigned system = 0; system < FW_SYSTEM_COUNT; system++)
			for (unsigned number = 1; number < FW_SATELLITES_PER_SYSTEM; number++) {
				const fw_satellite satellite = {(uint8_t)system, (uint8_t)number};
				fw_satellite_state s;
				const fw_status status = fw_precise_state(&precise, satellite, t, &s);

				if (status >= 0)
					print(satellite, 0, t, 0, t, status, &s);
			}
	}
	return 0;
}

int main(int argc, char **argv)
{
	if (argc == 7 && strcmp(argv[1], "-p") == 0) {
		const bool sp3_clocks = strcmp(argv[3], "-") == 0;

		open_input(&input[0], argv[2]);
		if (!sp3_clocks)
			open_input(&input[1], argv[3]);
		return from_tables(sp3_clocks, (fw_time){strtoll(argv[4], NULL, 10)},
		                   strtoll(argv[5], NULL, 10), (int)strtol(argv[6], NULL, 10));
	}
	if (argc < 3) {
		fprintf(stderr,
		        "usage: satellite_states NAVIGATION OFFSET... | -p SP3 CLOCKS BEGIN STEP N\n");
		return 2;
	}
	open_input(&input[0], argv[1]);
	return broadcast(argc - 2, argv + 2);
}
