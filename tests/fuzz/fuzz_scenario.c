/* Scenario files of gnss-sim: read, completed, printed and read again, and the route laid. */
#include <math.h>
#include <string.h>

#include "cli/scenario.h"

#include "text_input.h"
#include "tool_input.h"

static const char *const words[] = {
    "[scenario]\n",
    "[trajectory]\n",
    "[imu]\n",
    "[clock]\n",
    "[sky]\n",
    "[gnss]\n",
    "[pvt]\n",
    "[base]\n",
    "[camera]\n",
    "[mask a]\n",
    "[mask b]\n",
    "[fault a]\n",
    "[fault\n",
    "duration_s = 60\n",
    "start = 2026-06-10T08:00:00\n",
    "vehicle = plane\n",
    "vehicle = ground\n",
    "waypoint = 0 0 0 1 9\n",
    "waypoint = 100 0 0 5\n",
    "waypoint = 0 0 10 1\n",
    "place = 52.05 11.45 120\n",
    "rows = 8 0 0 0 50 3 8 1.2 0.8\n",
    "radius_m = 1e5\n",
    "jerk_mps3 = 0.001\n",
    "grade = tactical\n",
    "model = csac\n",
    "signals = G1C E5Q R1C\n",
    "horizontal_m2 = 10 20\n",
    "vertical_m2 = 10 20\n",
    "satellites = all\n",
    "satellites = G E05, C\n",
    "keep = 3\n",
    "type = meacon\n",
    "offset_ned_m = 1 2 3\n",
    "from_s = 3\n",
    "until_s = 3\n",
    "klobuchar_alpha = 1e-8 0 0 0\n",
    "= nan\n",
    " 1e308",
    " -1e9",
    "; comment\n",
    "\xef\xbb\xbf",
};

enum { WORDS = sizeof words / sizeof *words };

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	static const char *const files[] = {"[trajectory]\nwaypoint = 0 0 0 1 30\nwaypoint = 0 0 40 "
	                                    "2\nwaypoint = 90 20 40 8\n[gnss]\nrate_hz = 5\n",
	                                    "[trajectory]\nvehicle = ground\nwaypoint = 0 0 0 1 9\nrows = 8 "
	                                    "0 0 0 50 3 8 1.2 0.8\n[mask a]\nkeep = 3\n",
	                                    "[scenario]\nseed = 7\n[trajectory]\nplace = 52 11 100\nplace = "
	                                    "52.001 11 100 5 9\n[clock]\nmodel = csac\n",
	                                    "[pvt]\nhorizontal_m2 = 1 2\nvertical_m2 = 1 2\nhorizontal_m2ps2 "
	                                    "= 1 2\nvertical_m2ps2 = 3 4\n[fault a]\n"
	                                    "type = ramp\nsatellites = G05 E\nrate_mps = 1\n"};
	return (size_t)snprintf((char *)data, FUZZ_ROOM, "%s", files[fw_random_below(random, 4)]);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return text_mutate(data, size, max, seed, words, WORDS);
}

static void check(const scenario *s)
{
	require(isfinite(s->duration_s) && s->duration_s >= 0 && s->gnss_rate_hz > 0);
	require(s->n_masks <= FW_RECEIVER_MASKS && s->n_faults <= FW_RECEIVER_FAULTS);
	for (unsigned i = 0; i < s->n_masks; i++)
		require(s->rover.mask[i].window.until_s > s->rover.mask[i].window.from_s &&
		        s->mask[i].name[0] != '\0');
	for (unsigned i = 0; i < s->n_route; i++)
		for (unsigned k = 0; k < s->route[i].n; k++)
			require(isfinite(s->route[i].value[k]));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static scenario s;
	static fw_trajectory trajectory;
	static fw_receiver_setup base;
	static const tool self = {.name = "gnss-sim"};
	const char *file;
	fw_motion m;

	if (size > FUZZ_ROOM)
		return 0;
	tool_file(data, size, &file);
	const tool_streams old = tool_hush();
	scenario_defaults(&s);
	bool good = scenario_read(&s, &self, file) == EXIT_COMPLETE &&
	            scenario_complete(&s, &self, &base) == EXIT_COMPLETE;
	if (good)
		scenario_print(&s, stdout);
	if (good && s.table[0] == '\0' && scenario_trajectory(&s, &self, &trajectory) == EXIT_COMPLETE) {
		require(s.duration_s > 0 && fw_trajectory_at(&trajectory, s.duration_s / 2, &m) == FW_OK);
		require(isfinite(m.position_ecef_m[0]) && isfinite(m.force_b_mps2[2]) &&
		        isfinite(m.omega_ib_b_radps[0]));
	}
	tool_speak(old, 0);
	if (good)
		check(&s);
	return 0;
}
