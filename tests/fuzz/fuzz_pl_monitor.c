/* The whole of pl-monitor, from argv to exit status, in this process. The first byte of an input says how it is called; the
 * rest is a receiver log, or a stream of positions and levels. */
#include "log_input.h"
#include "text_input.h"
#include "tool_input.h"

static int tool_main(int argc, char **argv);
#define main tool_main
#include "../../cli/pl-monitor.c"
#undef main

enum { ARGUMENTS_MOST = 10 };

/* Words of a command line. */
static const char *const calls[][ARGUMENTS_MOST] = {
    {"-q"},
    {"-s", "-v", "--hal", "3", "--val", "4"},
    {"-t", "transition", "--hold", "0.7", "--time-to-alert", "1.1"},
    {"-f", "lcm", "--margin", "50", "--timeout", "0.3"},
    {"-s", "--from", "2360:300000", "--until", "2400:7"},
    {"-f", "lcm", "-s", "--hold", "2", "--margin", "99", "--timeout", "86400"},
};

enum { CALLS = sizeof calls / sizeof *calls };

/* Half of the inputs: epochs, some of them without levels, or without SBAS, or out of order. */
size_t fuzz_make(fw_random *random, uint8_t *data)
{
	char *text = (char *)data + 1;
	size_t used = 0;
	double t = 1;
	if (fw_random_below(random, 2) == 0)
		return log_make(random, data);
	data[0] = (uint8_t)fw_random_u64(random);
	used +=
	    (size_t)snprintf(text, FUZZ_ROOM - 1,
	                     "#furrow-stream 1\n#pvt,gps_week,tow_s,mode,error,two_d,lat_deg,lon_deg,n_sats\n"
	                     "#dop,gps_week,tow_s,hpl_m,vpl_m\n#imu,gps_week,tow_s\n");
	for (int i = 0; i < 60; i++) {
		t += (double)fw_random_below(random, 12) * 0.25 - 0.25;
		if (fw_random_below(random, 10) > 0)
			used += (size_t)snprintf(
			    text + used, FUZZ_ROOM - 1 - used, "pvt,2400,%.9g,%d,%d,%d,1,2,9\n", t,
			    fw_random_below(random, 4) > 0 ? 6 : 1, fw_random_below(random, 10) == 0,
			    fw_random_below(random, 10) == 0);
		if (fw_random_below(random, 10) > 0)
			used += (size_t)snprintf(
			    text + used, FUZZ_ROOM - 1 - used, "dop,2400,%.9g,%.3f,%.3f\n", t,
			    60 * fw_random_uniform(random), 60 * fw_random_uniform(random));
		if (fw_random_below(random, 10) == 0)
			used +=
			    (size_t)snprintf(text + used, FUZZ_ROOM - 1 - used, "imu,2400,%.9g\n", t + 20);
	}
	used +=
	    (size_t)snprintf(text + used, FUZZ_ROOM - 1 - used, "#end status=complete rows=1 skipped=0\n");
	return 1 + used;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	static const char *const words[] = {
	    "1e308",       "-1e308",     "4e-324",   "",         "\npl,", "\ndop,", "\npvt,",   "\nimu,",
	    "8191",        "604799.999", "604800",   "0",        "-1",    "2400",   "0.000001", "6",
	    "\npvt_ecef,", ",,,,",       "\n#end\n", "3.000001", "1e-30", "nan",    "40",       "50"};
	if (size > 1 && data[1] == '#')
		return 1 +
		       text_mutate(data + 1, size - 1, max - 1, seed, words, sizeof words / sizeof *words);
	return log_mutate(data, size, max, seed);
}

/* The command line of a mode, in words that the tool may write to. */
static int make_arguments(uint8_t mode, const char *input, char **argv, char words[][64])
{
	const char *const *call = calls[mode % CALLS];
	int n = 0;
	snprintf(words[n++], sizeof words[0], "pl-monitor");
	for (int i = 0; i < ARGUMENTS_MOST && call[i] != NULL; i++)
		snprintf(words[n++], sizeof words[0], "%s", call[i]);
	snprintf(words[n++], sizeof words[0], "-o");
	snprintf(words[n++], sizeof words[0], "/dev/null");
	snprintf(words[n++], sizeof words[0], "%s", input);
	for (int i = 0; i < n; i++)
		argv[i] = words[i];
	argv[n] = NULL;
	return n;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static options pristine;
	char words[ARGUMENTS_MOST + 8][64], *argv[ARGUMENTS_MOST + 8];
	const char *path;

	if (size == 0)
		return 0;
	if (pristine.tool == NULL)
		pristine = opts;
	(void)tool_file(data + 1, size - 1, &path);
	opts = pristine;
	self = (tool){.name = "pl-monitor"};
	memset(&sinks, 0, sizeof sinks);
	memset(&run, 0, sizeof run);
	const int argc = make_arguments(data[0], path, argv, words);
	const tool_streams old = tool_hush();
	const int status = tool_main(argc, argv);
	tool_speak(old, 0);
	require(status == EXIT_COMPLETE || status == EXIT_PARTIAL || status == EXIT_NO_DATA);
	require((status == EXIT_NO_DATA) == (run.epochs == 0));
	for (int s = FW_RELIABLE; s <= FW_NO_POSITION; s++)
		require(run.seconds[s] >= 0 && run.seconds[s] < 1e10);
	require(run.transitions > 0 || run.machine.state == FW_NO_POSITION);
	return 0;
}
