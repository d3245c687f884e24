/* Options and configuration: one table per tool. Each entry is at once a long option, a key for --set and for the
 * INI file, a line of --help and of --print-config. */
#ifndef FURROW_CLI_OPTIONS_H
#define FURROW_CLI_OPTIONS_H

#include <stdio.h>

#include "base/time.h"

typedef enum {
	OPTION_FLAG,   /* no argument on the command line; yes or no in a file */
	OPTION_TEXT,   /* any text */
	OPTION_NUMBER, /* a number from min to max */
	OPTION_CHOICE, /* one of the words in `argument`, separated by | */
	OPTION_TIME    /* a time, see fw_time_parse */
} option_type;

typedef struct {
	const char *name; /* long option and key */
	char letter;      /* short option, or 0 */
	option_type type;
	const char *argument; /* what --help calls it; for OPTION_CHOICE the words */
	const char *fallback; /* the value when nothing is said; NULL: unset */
	const char *help;     /* one line */
	double min, max;      /* for OPTION_NUMBER */
} option;

enum { MAX_OPTIONS = 128, MAX_SETTINGS = 256 };

/* The table and the values in force. */
typedef struct {
	const char *tool;     /* name of the tool, section of the INI file */
	const char *synopsis; /* what --help says after the name */
	const char *purpose;  /* one sentence */
	const option *table;
	int n;
	const char *text[MAX_OPTIONS]; /* as given, or the fallback; NULL: unset */
	double number[MAX_OPTIONS];    /* OPTION_NUMBER and OPTION_FLAG (0 or 1) */
	fw_time time[MAX_OPTIONS];     /* OPTION_TIME */
	char *kept[MAX_OPTIONS]; /* the text of values from the INI file, also when others are in force */
	int first_file;          /* index in argv of the first operand */
	/* A tool whose operand is itself a configuration, with keys of its own, answers --set and --print-config itself. */
	int has_scenario;
	int print_config;                   /* --print-config was given */
	const char *settings[MAX_SETTINGS]; /* arguments of --set */
	int n_settings;
} options;

/* What options_parse asks the tool to do. */
typedef enum {
	OPTIONS_RUN,   /* go on */
	OPTIONS_DONE,  /* --help, --version or --print-config was answered: leave with status 0 */
	OPTIONS_WRONG, /* a message was written: leave with status 2 */
	OPTIONS_FAILED /* the INI file could not be read; a message was written: leave with status 3 */
} options_result;

/* Reads the command line: first the INI file that -c names, then options and --set in their order. Entries that
 * every tool has (-c, --set, --print-config, -h, -V) are not in the table; they are added here. */
options_result options_parse(options *o, int argc, char **argv);

/* The index of the entry called `name`; the name must be in the table. */
int options_index(const options *o, const char *name);

/* The value in force of the entry called `name`: text (NULL: unset), number, flag. */
const char *options_text(const options *o, const char *name);
double options_number(const options *o, const char *name);
int options_flag(const options *o, const char *name);

/* The time that the entry called `name` holds; NULL: unset. */
const fw_time *options_time(const options *o, const char *name);

/* Calls `each` with key and value of every entry that is set, in the order of the table. */
void options_each(const options *o, void (*each)(void *context, const char *key, const char *value),
                  void *context);

/* Of n words the one that is most like `word`; NULL when none is near. For "did you mean". */
const char *nearest_word(const char *word, const char *(*word_at)(const void *words, int i),
                         const void *words, int n);

#endif
