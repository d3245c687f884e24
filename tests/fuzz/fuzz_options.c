/* Command line and INI file: arguments, one a line, an empty line, and what -c is given to read. */
#include <math.h>
#include <string.h>

#include <sanitizer/lsan_interface.h>

#include "cli/options.h"

#include "text_input.h"
#include "tool_input.h"

enum { ARGUMENTS_MOST = 16 };

static const option table[] = {
    {"output", 'o', OPTION_TEXT, "FILE", NULL, "a text", 0, 0},
    {"stream", 's', OPTION_FLAG, NULL, NULL, "a flag", 0, 0},
    {"format", 'f', OPTION_CHOICE, "csv|lcm", "csv", "a choice", 0, 0},
    {"from", 0, OPTION_TIME, "TIME", NULL, "a time", 0, 0},
    {"every", 0, OPTION_NUMBER, "SECONDS", NULL, "a number", 0.001, 604800},
    {"hal", 0, OPTION_NUMBER, "METRES", "40", "a number with a fallback", 0, 1e6},
};

static const char *const words[] = {
    "--output",
    "-o",
    "-s",
    "--stream",
    "--stream=yes",
    "-fcsv",
    "--format=lcm",
    "--from",
    "2360:345600",
    "--every=0.1",
    "--hal=1e6",
    "--set\nhal=3",
    "--set",
    "--help",
    "-h",
    "-V",
    "--print-config",
    "--",
    "-",
    "\n\n",
    "[tool]\n",
    "[other]\n",
    "hal = 12\n",
    "stream = no\n",
    "from = 2026-11-22T05:00:00Z\n",
    "; comment\n",
    "# comment\n",
    " = ",
    "format: lcm\n",
    "every = nan\n",
    "every = 1e999\n",
    "--forma",
    "--outpud",
    "\xef\xbb\xbf",
    "]",
    "[",
    "=",
    " \t",
};

enum { WORDS = sizeof words / sizeof *words };

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	static const char *const commands[] = {"-s\n--every\n0.5\nfile\n", "--set\nhal=3\n-fcsv\n-ox\n",
	                                       "--print-config\n", ""};
	static const char *const files[] = {"[tool]\nhal = 12\nformat = lcm\n[other]\nx = 1\n",
	                                    "stream = yes\nevery=1\n", ""};
	return (size_t)snprintf((char *)data, FUZZ_ROOM, "%s\n%s", commands[fw_random_below(random, 4)],
	                        files[fw_random_below(random, 3)]);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return text_mutate(data, size, max, seed, words, WORDS);
}

/* Splits the arguments at line ends. Returns where the file begins. */
static size_t split(char *text, size_t size, int *argc, char **argv)
{
	size_t at = 0;
	while (at < size && text[at] != '\n') {
		char *end = memchr(text + at, '\n', size - at);
		if (*argc < ARGUMENTS_MOST)
			argv[(*argc)++] = text + at;
		if (end == NULL)
			return size;
		*end = '\0';
		at = (size_t)(end - text) + 1;
	}
	return at < size ? at + 1 : size;
}

static void check(const options *o, int argc)
{
	const char *format = options_text(o, "format");
	const double hal = options_number(o, "hal");
	const fw_time *from = options_time(o, "from");
	require(strcmp(format, "csv") == 0 || strcmp(format, "lcm") == 0);
	require(hal >= 0 && hal <= 1e6);
	require(options_text(o, "every") == NULL ||
	        (options_number(o, "every") >= 0.001 && options_number(o, "every") <= 604800));
	require(options_flag(o, "stream") == 0 || options_flag(o, "stream") == 1);
	require(from == NULL || (from->ns >= 0 && from->ns <= FW_TIME_NS_MAX));
	require(o->first_file >= 1 && o->first_file <= argc);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static char text[FUZZ_ROOM + 1], name[] = "tool", config[] = "-c";
	char path[32], *argv[ARGUMENTS_MOST + 1] = {name, config, path};
	const char *file;
	int argc = 3;
	options o = {
	    .tool = name, .synopsis = "", .purpose = "", .table = table, .n = sizeof table / sizeof *table};

	if (size > FUZZ_ROOM)
		return 0;
	memcpy(text, data, size);
	text[size] = '\0';
	const size_t at = split(text, size, &argc, argv);
	tool_file(data + at, size - at, &file);
	snprintf(path, sizeof path, "%s", file);

	const tool_streams old = tool_hush();
	__lsan_disable(); /* values from the file live as long as the program */
	const options_result result = options_parse(&o, argc, argv);
	__lsan_enable();
	tool_speak(old, 0);
	if (result == OPTIONS_RUN)
		check(&o, argc);
	return 0;
}
