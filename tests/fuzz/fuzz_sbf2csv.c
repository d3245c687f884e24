/* The whole of sbf2csv, from argv to exit status, in this process. The first byte of an input says how it is called;
 * the rest is the log, the stream or whatever else it reads. */
#include "lcm_input.h"
#include "log_input.h"
#include "tool_input.h"

static int tool_main(int argc, char **argv);
#define main tool_main
#include "../../cli/sbf2csv.c"
#undef main

enum { ARGUMENTS_MOST = 8 };

/* Words of a command line; "DIR" stands for a folder in memory. -o is added to all that can have it. */
static const char *const calls[][ARGUMENTS_MOST] = {
    {"-t", "pvt"},
    {"-t", "obs", "--antenna", "all"},
    {"-t", "eph_gps", "--nav", "raw"},
    {"-t", "imu", "-q"},
    {"-t", "obs,pvt,att,sbas_fast", "-s", "--until", "2360:300000"},
    {"-s"},
    {"-s", "-v", "--antenna", "aux1"},
    {"-s", "--from", "2360:300000", "--every", "0.5"},
    {"-s", "--nav", "decoded", "--progress", "always"},
    {"-f", "lcm"},
    {"-f", "lcm", "--nav", "raw", "--antenna", "all"},
    {"--list"},
    {"--split", "DIR"},
};

enum { CALLS = sizeof calls / sizeof *calls };

static char folder[64];

static void remove_folder(void)
{
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++) {
		char path[128];
		snprintf(path, sizeof path, "%s/%s.csv", folder, fw_record_type_of(kind)->name);
		unlink(path);
	}
	rmdir(folder);
}

/* Now and then what other tools of furrow write, since that is read too. */
size_t fuzz_make(fw_random *random, uint8_t *data)
{
	static fw_csv_writer writer;
	memory m = {(char *)data + 1, FUZZ_ROOM - 1, 0};
	const unsigned which = (unsigned)fw_random_below(random, 8);

	if (which > 1)
		return log_make(random, data);
	data[0] = (uint8_t)fw_random_u64(random);
	if (which == 1)
		return 1 + lcm_make(random, data + 1, FUZZ_ROOM - 1);
	fw_csv_begin_stream(&writer, to_memory, &m);
	for (int n = 0; n < 5; n++) {
		const fw_kind kind = (fw_kind)fw_random_below(random, FW_meta);
		fw_any_record record;
		random_record(random, kind, &record);
		fw_csv_put(&writer, kind, &record);
	}
	(void)!fw_csv_end(&writer, true, 0);
	return 1 + m.used;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	static const uint8_t lcm_sync[] = {0xed, 0xa1, 0xda, 0x01};
	if (size > sizeof lcm_sync && memcmp(data + 1, lcm_sync, sizeof lcm_sync) == 0)
		return 1 + lcm_mutate(data + 1, size - 1, max - 1, seed);
	return log_mutate(data, size, max, seed);
}

/* The command line of a mode, in words that the tool may write to. */
static int make_arguments(uint8_t mode, const char *input, char **argv, char words[][sizeof folder])
{
	const char *const *call = calls[mode % CALLS];
	int n = 0;
	snprintf(words[n++], sizeof folder, "sbf2csv");
	for (int i = 0; call[i] != NULL; i++)
		snprintf(words[n++], sizeof folder, "%s", strcmp(call[i], "DIR") == 0 ? folder : call[i]);
	if (strcmp(call[0], "--split") != 0) {
		snprintf(words[n++], sizeof folder, "-o");
		snprintf(words[n++], sizeof folder, "/dev/null");
	}
	snprintf(words[n++], sizeof folder, "%s", mode & 0x80 ? "-" : input);
	for (int i = 0; i < n; i++)
		argv[i] = words[i];
	argv[n] = NULL;
	return n;
}

/* What a new process would find. */
static void begin_anew(const options *pristine, uint8_t mode)
{
	opts = *pristine;
	self = (tool){.name = "sbf2csv"};
	memset(&sinks, 0, sizeof sinks);
	if (strcmp(calls[mode % CALLS][0], "--list") == 0)
		memset(&blocks, 0, sizeof blocks);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static options pristine;
	char words[ARGUMENTS_MOST + 8][sizeof folder], *argv[ARGUMENTS_MOST + 8];
	const char *path;

	if (size == 0)
		return 0;
	if (pristine.tool == NULL) {
		pristine = opts;
		snprintf(folder, sizeof folder, "/dev/shm/furrow.%ld", (long)getpid());
		atexit(remove_folder);
	}
	const int fd = tool_file(data + 1, size - 1, &path);
	if (data[0] & 0x80)
		require(dup2(fd, STDIN_FILENO) == STDIN_FILENO);
	begin_anew(&pristine, data[0]);
	const int argc = make_arguments(data[0], path, argv, words);
	const tool_streams old = tool_hush();
	const int status = tool_main(argc, argv);
	tool_speak(old, 0);
	require(status == EXIT_COMPLETE || status == EXIT_PARTIAL || status == EXIT_NO_DATA);
	return 0;
}
