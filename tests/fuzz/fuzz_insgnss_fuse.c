/* The whole of insgnss-fuse, from argv to exit status, in this process. The first byte of an input says how it is called;
 * the rest is a stream, a table or whatever else it reads. */
#include <math.h>

#include "text_input.h"
#include "tool_input.h"

static int tool_main(int argc, char **argv);
#define main tool_main
#include "../../cli/insgnss-fuse.c"
#undef main

enum { ARGUMENTS_MOST = 12 };

/* FILE stands for the input, once more. */
static const char *const calls[][ARGUMENTS_MOST] = {
    {"-q"},
    {"-s", "--compass", "yes", "--baro-sd", "1"},
    {"--smooth", "rts", "--memory", "1", "--rate", "7"},
    {"--adapt", "pl", "--rate", "events"},
    {"--adapt", "gm", "--smooth", "rts", "-s"},
    {"--adapt", "vb", "--gate", "0", "--gyro-scale", "100", "--accel-scale", "100"},
    {"--adapt", "student", "--gap", "0.05", "-v"},
    {"--align", "given", "--heading", "30", "--wheels", "0.1"},
    {"--align", "magnetic", "-f", "lcm", "--lever-x", "1"},
    {"--align", "motion", "--window", "0", "--withhold", "3:1:1"},
    {"--fixes", "nav", "--imu", "FILE", "--imu-roll", "180"},
    {"--fixes", "pos", "--velocity", "no", "--imu-offset", "-0.3"},
    {"--compass", "yes", "--compass-calibration", "log"},
    {"--compass", "yes", "--compass-calibration", "turning", "--smooth", "rts"},
    {"--imu", "FILE", "--imu-columns", "kf-gins", "--imu-time", "gps,week=2400"},
};

enum { CALLS = sizeof calls / sizeof *calls };

static const char head[] =
    "#furrow-stream 1\n"
    "#imu,gps_week,tow_s,gyro_x_radps,gyro_y_radps,gyro_z_radps,accel_x_mps2,accel_y_mps2,accel_z_mps2\n"
    "#pvt,gps_week,tow_s,mode,error,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,sd_n_m,sd_e_m,sd_d_m\n"
    "#att,gps_week,tow_s,mode,heading_deg,sd_heading_deg\n"
    "#mag,gps_week,tow_s,mag_x_ut,mag_y_ut,mag_z_ut\n"
    "#baro,gps_week,tow_s,baro_height_m\n"
    "#pl,gps_week,tow_s,hpl_m,vpl_m,state\n"
    "#event,gps_week,tow_s,source\n";

/* A vehicle that stands for two seconds and goes north then, at 20 Hz, with all sensors. */
static size_t put_epoch(fw_random *r, int i, char *text, size_t room)
{
	const double t = i * 0.05, a = i > 40 ? 1 : 0, v = i > 40 ? t - 2 : 0, north = v * v / 2;
	size_t used = (size_t)snprintf(text, room, "imu,2400,%.2f,%.4f,0,0,%.3f,%.3f,-9.81\n", t,
	                               fw_random_normal(r) * 1e-3, a, fw_random_normal(r) * 0.01);
	if (i % 5 == 0)
		used += (size_t)snprintf(
		    text + used, room - used,
		    "pl,2400,%.2f,%d,12,%s\npvt,2400,%.2f,4,0,%.9f,11,100,%.2f,0,0,0.1,0.1,0.2\n", t,
		    5 + i % 20, i % 3 == 0 ? "RELIABLE" : "UNRELIABLE", t, 52 + north / 111e3, v);
	if (i % 10 == 0 && fw_random_below(r, 2) == 0)
		used += (size_t)snprintf(text + used, room - used, "att,2400,%.2f,2,1.5,0.3\n", t);
	if (i % 10 == 3)
		used += (size_t)snprintf(text + used, room - used,
		                         "mag,2400,%.2f,18,1,45\nbaro,2400,%.2f,99\nevent,2400,%.3f,1\n", t,
		                         t, t + 0.01);
	return used;
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	char *text = (char *)data + 1;
	size_t used = 0;
	data[0] = (uint8_t)fw_random_u64(random);
	used += (size_t)snprintf(text, FUZZ_ROOM - 1, "%s", head);
	for (int i = 0; i < 70 && used + 500 < FUZZ_ROOM - 1; i++)
		used += put_epoch(random, i, text + used, FUZZ_ROOM - 1 - used);
	used +=
	    (size_t)snprintf(text + used, FUZZ_ROOM - 1 - used, "#end status=complete rows=1 skipped=0\n");
	return 1 + used;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	static const char *const words[] = {"1e308",      "-1e30", "4e-324", "90",          "604799.999",
	                                    "0",          "-0",    "",       "\nimu,2400,", "\npvt,2400,",
	                                    "2401",       "1e9",   "8191",   "-9.81",       "\natt,2400,1,",
	                                    "\npl,2400,", ",,,,",  "3600.5"};
	if (size < 2)
		return LLVMFuzzerMutate(data, size, max);
	return 1 + text_mutate(data + 1, size - 1, max - 1, seed, words, sizeof words / sizeof *words);
}

/* The command line of a mode, in words that the tool may write to. */
static int make_arguments(uint8_t mode, const char *input, char **argv, char words[][64])
{
	const char *const *call = calls[mode % CALLS];
	const char *const always[] = {"insgnss-fuse", "-o", "/dev/null"};
	int n = 0;
	for (size_t i = 0; i < sizeof always / sizeof *always; i++)
		snprintf(words[n++], sizeof words[0], "%s", always[i]);
	for (int i = 0; i < ARGUMENTS_MOST && call[i] != NULL; i++)
		snprintf(words[n++], sizeof words[0], "%s", strcmp(call[i], "FILE") == 0 ? input : call[i]);
	snprintf(words[n++], sizeof words[0], "%s", input);
	for (int i = 0; i < n; i++)
		argv[i] = words[i];
	argv[n] = NULL;
	return n;
}

/* What a new process would find. The large rings need no clearing: they are looked at where something was put only. */
static void clear_all(const options *pristine)
{
	opts = *pristine;
	self = (tool){.name = "insgnss-fuse"};
	memset(&sinks, 0, sizeof sinks);
	memset(&run, 0, sizeof run);
	memset(&inputs, 0, sizeof inputs);
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
	clear_all(&pristine);
	const int argc = make_arguments(data[0], path, argv, words);
	const tool_streams old = tool_hush();
	const int status = tool_main(argc, argv);
	tool_speak(old, 0);
	require(status == EXIT_COMPLETE || status == EXIT_PARTIAL || status == EXIT_NO_DATA);
	require(run.bad_rows == 0);
	return 0;
}
