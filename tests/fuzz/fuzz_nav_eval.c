/* The whole of nav-eval, from argv to exit status, in this process. The first byte of an input says how it is called; the
 * rest is a stream, a table or whatever else, at once the truth and the solution. Its pictures are left to gnuplot. */
#include "text_input.h"
#include "tool_input.h"

static int tool_main(int argc, char **argv);
#define main tool_main
#include "../../cli/nav-eval.c"
#undef main

enum { ARGUMENTS_MOST = 10 };

static const char *const calls[][ARGUMENTS_MOST] = {
    {"-t", "pos"},
    {"-q", "-f", "csv", "--sections", "1"},
    {"-t", "pvt", "--max-gap", "604800", "--hal", "10", "--val", "20"},
    {"--lever-arm", "1,-2,0.5", "--interval", "0.001", "--sections", "0,1,2.5,2400:100"},
    {"--max-rows", "3", "-f", "csv"},
    {"--from", "2400:3", "--until", "2400:7", "-v"},
    {"--levels", "FILE", "-t", "nav"},
};

enum { CALLS = sizeof calls / sizeof *calls };

/* Rows of one kind, so many per second, at one place but for a few metres. */
static size_t put_rows(fw_random *random, char *text, size_t room, const char *name)
{
	size_t used = 0;
	for (int i = 0; i < 12 && used + 400 < room; i++)
		used += (size_t)snprintf(
		    text + used, room - used,
		    "%s,2400,%.9g,%.9f,%.9f,%.4f,%.3f,%.3f,%.3f,%.2f,%.2f,%.2f,%d,1,2,%d,40\n", name,
		    i * 0.5 + (double)fw_random_below(random, 3) * 0.25,
		    53 + fw_random_uniform(random) * 1e-4, -2 + fw_random_uniform(random) * 1e-4,
		    100 + fw_random_uniform(random), 1.0, 2.0, 0.5, 1.0, 2.0, 359 + fw_random_uniform(random),
		    3, 5);
	return used;
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	static const char *const kinds[] = {"nav", "pos", "pvt", "ins"};
	char *text = (char *)data + 1;
	size_t used = 0;
	data[0] = (uint8_t)fw_random_u64(random);
	used += (size_t)snprintf(text, FUZZ_ROOM - 1, "#furrow-stream 1\n");
	for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
		if (k > 0 && fw_random_below(random, 2) == 0)
			continue;
		used += (size_t)snprintf(
		    text + used, FUZZ_ROOM - 1 - used,
		    "#%s,gps_week,tow_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,"
		    "heading_deg,sd_n_m,sd_e_m,sd_d_m,hpl_m,vpl_m\n",
		    kinds[k]);
		used += put_rows(random, text + used, FUZZ_ROOM - 1 - used, kinds[k]);
	}
	used += (size_t)snprintf(
	    text + used, FUZZ_ROOM - 1 - used,
	    "#pl,gps_week,tow_s,hpl_m,vpl_m,hal_m,val_m\npl,2400,1,3,4,5,6\npl,2400,2,1e300,-4,0,\n"
	    "#end status=complete rows=1 skipped=0\n");
	return 1 + used;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	static const char *const words[] = {
	    "1e308",  "-1e308",      "4e-324", "90",     "-90",     "180",    "8191", "604799.999999999",
	    "604800", "0",           "-0",     "",       "\npl,",   "\nnav,", "2400", "0.000000001",
	    "1e9",    "\npos,2400,", "\ndop,", "\natt,", "6378137", ",,,,"};
	if (size < 2)
		return LLVMFuzzerMutate(data, size, max);
	return 1 + text_mutate(data + 1, size - 1, max - 1, seed, words, sizeof words / sizeof *words);
}

/* The command line of a mode, in words that the tool may write to. */
static int make_arguments(uint8_t mode, const char *input, char **argv, char words[][64])
{
	const char *const *call = calls[mode % CALLS];
	int n = 0;
	const char *const always[] = {"nav-eval", "-o", "/dev/null", "--truth", input};
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
	self = (tool){.name = "nav-eval"};
	memset(&all, 0, sizeof all);
	const int argc = make_arguments(data[0], path, argv, words);
	const tool_streams old = tool_hush();
	const int status = tool_main(argc, argv);
	tool_speak(old, 0);
	require(status == EXIT_COMPLETE || status == EXIT_PARTIAL || status == EXIT_NO_DATA ||
	        status == EXIT_USAGE);
	return 0;
}
