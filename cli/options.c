#include "options.h"

#include <errno.h>
#include <getopt.h>
#include <ini.h>
#include <stdlib.h>
#include <string.h>

#include "formats/number.h"

/* Entries of every tool, after those of its table. */

static const option common[] = {
    {"config", 'c', OPTION_TEXT, "FILE", NULL, "read settings from an INI file", 0, 0},
    {"set", 0, OPTION_TEXT, "KEY=VALUE", NULL, "set one key, as in the INI file", 0, 0},
    {"print-config", 0, OPTION_FLAG, NULL, NULL, "print the settings in force and leave", 0, 0},
    {"help", 'h', OPTION_FLAG, NULL, NULL, "print this and leave", 0, 0},
    {"version", 'V', OPTION_FLAG, NULL, NULL, "print the version and leave", 0, 0},
};
enum { N_COMMON = sizeof common / sizeof common[0] };

static size_t edit_distance(const char *a, const char *b)
{
	size_t row[64], n = strlen(b);
	if (n >= 64 || strlen(a) >= 64)
		return 64;
	for (size_t j = 0; j <= n; j++)
		row[j] = j;
	for (size_t i = 0; a[i] != '\0'; i++) {
		size_t diagonal = row[0];
		row[0] = i + 1;
		for (size_t j = 0; j < n; j++) {
			size_t best = diagonal + (a[i] != b[j]);
			if (row[j] + 1 < best)
				best = row[j] + 1;
			if (row[j + 1] + 1 < best)
				best = row[j + 1] + 1;
			diagonal = row[j + 1];
			row[j + 1] = best;
		}
	}
	return row[n];
}

const char *nearest_word(const char *word, const char *(*word_at)(const void *words, int i),
                         const void *words, int n)
{
	const char *nearest = NULL;
	size_t best = strlen(word) / 2 + 1;
	for (int i = 0; i < n; i++) {
		const char *candidate = word_at(words, i);
		size_t distance = edit_distance(word, candidate);
		if (strncmp(word, candidate, strlen(word)) == 0)
			distance = 1; /* an abbreviation */
		if (distance <= best && (nearest == NULL || distance < best)) {
			best = distance;
			nearest = candidate;
		}
	}
	return nearest;
}

static const char *option_name_at(const void *words, int i)
{
	const options *o = words;
	return i < o->n ? o->table[i].name : common[i - o->n].name;
}

static void complain_unknown(const options *o, const char *where, const char *key)
{
	const char *nearest = nearest_word(key, option_name_at, o, o->n + N_COMMON);
	fprintf(stderr, "%s: %sunknown option or key '%s'", o->tool, where, key);
	if (nearest != NULL)
		fprintf(stderr, "; did you mean '%s'?", nearest);
	fputc('\n', stderr);
}

static int is_choice(const char *choices, const char *word)
{
	size_t n = strlen(word);
	for (const char *p = choices; n > 0; p = strchr(p, '|') + 1) {
		if (strncmp(p, word, n) == 0 && (p[n] == '|' || p[n] == '\0'))
			return 1;
		if (strchr(p, '|') == NULL)
			break;
	}
	return 0;
}

static int parse_yes_no(const char *text, double *value)
{
	static const char *const yes[] = {"yes", "true", "on", "1"}, *const no[] = {"no", "false", "off",
	                                                                            "0"};
	for (size_t i = 0; i < sizeof yes / sizeof yes[0]; i++) {
		if (strcmp(text, yes[i]) == 0 || strcmp(text, no[i]) == 0) {
			*value = strcmp(text, yes[i]) == 0;
			return 1;
		}
	}
	return 0;
}

/* Sets entry i to `value`. Returns 0 after a message when the value is not one. */
static int set_value(options *o, int i, const char *where, const char *value)
{
	const option *entry = &o->table[i];
	switch (entry->type) {
	case OPTION_TEXT: break;
	case OPTION_FLAG:
		if (!parse_yes_no(value, &o->number[i])) {
			fprintf(stderr, "%s: %s%s: '%s' is neither yes nor no\n", o->tool, where, entry->name,
			        value);
			return 0;
		}
		break;
	case OPTION_NUMBER:
		if (fw_get_double(value, strlen(value), &o->number[i]) != FW_OK ||
		    !(o->number[i] >= entry->min && o->number[i] <= entry->max)) {
			fprintf(stderr, "%s: %s%s: '%s' is not a number from %g to %g\n", o->tool, where,
			        entry->name, value, entry->min, entry->max);
			return 0;
		}
		break;
	case OPTION_CHOICE:
		if (!is_choice(entry->argument, value)) {
			fprintf(stderr, "%s: %s%s: '%s' is not one of %s\n", o->tool, where, entry->name,
			        value, entry->argument);
			return 0;
		}
		break;
	case OPTION_TIME:
		if (fw_time_parse(value, &o->time[i]) < 0) {
			fprintf(stderr,
			        "%s: %s%s: '%s' is no time; write WEEK:SECONDS, YYYY-MM-DDTHH:MM:SS (GPS "
			        "time), or the "
			        "same with Z (UTC)\n",
			        o->tool, where, entry->name, value);
			return 0;
		}
		break;
	}
	o->text[i] = value;
	return 1;
}

static int find_entry(const options *o, const char *key)
{
	for (int i = 0; i < o->n; i++)
		if (strcmp(o->table[i].name, key) == 0)
			return i;
	return -1;
}

static int set_key(options *o, const char *where, const char *key, const char *value)
{
	int i = find_entry(o, key);
	if (i < 0) {
		complain_unknown(o, where, key);
		return 0;
	}
	return set_value(o, i, where, value);
}

/* inih's handler. Sections of other tools are theirs; keys before any section are everyone's. */
typedef struct {
	options *o;
	const char *file;
	int refused;   /* a message was written */
	int no_memory; /* a value could not be kept */
} config_reader;

static int ini_value(void *context, const char *section, const char *key, const char *value)
{
	config_reader *r = context;
	if (section[0] != '\0' && strcmp(section, r->o->tool) != 0)
		return 1;
	char where[512];
	snprintf(where, sizeof where, "%s: ", r->file);
	char *copy = strdup(value);
	r->no_memory |= copy == NULL;
	if (copy == NULL || !set_key(r->o, where, key, copy)) {
		free(copy);
		r->refused = 1;
		return 0;
	}
	char **kept = &r->o->kept[find_entry(r->o, key)];
	free(*kept); /* the key stood there twice */
	*kept = copy;
	return 1;
}

/* What became of the file, said on stderr. `line` is inih's verdict: 0, the first bad line, or < 0 without memory. */
static options_result judge_file(const config_reader *r, int line, int error)
{
	const char *tool = r->o->tool;
	if (error != 0 || line < 0 || r->no_memory) {
		fprintf(stderr, "%s: %s: %s\n", tool, r->file, strerror(error != 0 ? error : ENOMEM));
		return OPTIONS_FAILED;
	}
	if (line == 0)
		return OPTIONS_RUN;
	if (r->refused)
		fprintf(stderr, "%s: %s:%d: setting refused\n", tool, r->file, line);
	else
		fprintf(stderr, "%s: %s:%d: not a section, key = value, or comment\n", tool, r->file, line);
	return OPTIONS_WRONG;
}

/* Opened here because inih takes a read that fails for the end of the file. */
static options_result read_file(options *o, const char *file)
{
	config_reader r = {o, file, 0, 0};
	FILE *f = fopen(file, "re");
	if (f == NULL)
		return judge_file(&r, 0, errno);
	errno = 0;
	int line = ini_parse_file(f, ini_value, &r);
	int error = ferror(f) ? errno : 0;
	fclose(f);
	return judge_file(&r, line, error);
}

static void print_option(FILE *f, const option *entry)
{
	char left[80];
	int n =
	    snprintf(left, sizeof left, "  %c%c%c --%s", entry->letter != 0 ? '-' : ' ',
	             entry->letter != 0 ? entry->letter : ' ', entry->letter != 0 ? ',' : ' ', entry->name);
	if (entry->argument != NULL)
		snprintf(left + n, sizeof left - (size_t)n, " %s", entry->argument);
	if (strlen(left) > 32)
		fprintf(f, "%s\n%-33s%s", left, "", entry->help);
	else
		fprintf(f, "%-33s%s", left, entry->help);
	if (entry->fallback != NULL && entry->type != OPTION_FLAG)
		fprintf(f, " [%s]", entry->fallback);
	fputc('\n', f);
}

static void print_help(const options *o)
{
	printf("usage: %s %s\n%s\n\n", o->tool, o->synopsis, o->purpose);
	for (int i = 0; i < o->n; i++)
		print_option(stdout, &o->table[i]);
	for (int i = 0; i < N_COMMON; i++)
		print_option(stdout, &common[i]);
}

static void print_setting(void *context, const char *key, const char *value)
{
	fprintf(context, "%s = %s\n", key, value);
}

void options_each(const options *o, void (*each)(void *context, const char *key, const char *value),
                  void *context)
{
	for (int i = 0; i < o->n; i++) {
		if (o->table[i].type == OPTION_FLAG)
			each(context, o->table[i].name, o->number[i] != 0 ? "yes" : "no");
		else if (o->text[i] != NULL)
			each(context, o->table[i].name, o->text[i]);
	}
}

/* getopt's tables, made from ours. `val` of a long option is 256 plus its place, so that it never collides with a
 * letter. */
static void make_getopt_tables(const options *o, struct option *longs, char *shorts)
{
	*shorts++ = ':';
	for (int i = 0; i < o->n + N_COMMON; i++) {
		const option *entry = i < o->n ? &o->table[i] : &common[i - o->n];
		int has_argument = entry->type != OPTION_FLAG;
		longs[i] = (struct option){entry->name, has_argument ? required_argument : no_argument, NULL,
		                           256 + i};
		if (entry->letter != 0) {
			*shorts++ = entry->letter;
			if (has_argument)
				*shorts++ = ':';
		}
	}
	longs[o->n + N_COMMON] = (struct option){NULL, 0, NULL, 0};
	*shorts = '\0';
}

static int entry_of_letter(const options *o, int c)
{
	for (int i = 0; i < o->n + N_COMMON; i++)
		if ((i < o->n ? o->table[i].letter : common[i - o->n].letter) == c)
			return i;
	return -1;
}

static int set_assignment(options *o, char *assignment)
{
	char *equals = strchr(assignment, '=');
	if (equals == NULL) {
		fprintf(stderr, "%s: --set: '%s' is not KEY=VALUE\n", o->tool, assignment);
		return 0;
	}
	if (o->has_scenario && o->n_settings == MAX_SETTINGS) {
		fprintf(stderr, "%s: --set: more than %d of them\n", o->tool, MAX_SETTINGS);
		return 0;
	}
	if (o->has_scenario) {
		o->settings[o->n_settings++] = assignment;
		return 1;
	}
	*equals = '\0';
	int ok = set_key(o, "--set: ", assignment, equals + 1);
	*equals = '=';
	return ok;
}

typedef struct {
	int help, version, print;
} requests;

/* One option; `pass` 0 reads the configuration file, pass 1 all else. OPTIONS_RUN: go on. */
static options_result take(options *o, int i, int pass, char *argument, requests *r)
{
	int which = i < o->n ? -1 : i - o->n, ok = 1;
	if (which == 0)
		return pass == 0 ? read_file(o, argument) : OPTIONS_RUN;
	if (pass == 0)
		return OPTIONS_RUN;
	if (which < 0)
		ok = set_value(o, i, "--", o->table[i].type == OPTION_FLAG ? "yes" : argument);
	else if (which == 1)
		ok = set_assignment(o, argument);
	if (o->has_scenario)
		o->print_config |= which == 2;
	else
		r->print |= which == 2;
	r->help |= which == 3;
	r->version |= which == 4;
	return ok ? OPTIONS_RUN : OPTIONS_WRONG;
}

static void complain_getopt(const options *o, int c, char **argv)
{
	const char *given = argv[optind - 1];
	if (c == ':') {
		fprintf(stderr, "%s: option '%s' needs an argument\n", o->tool, given);
	} else if (optopt != 0 && optopt < 256) {
		fprintf(stderr, "%s: unknown option '-%c'\n", o->tool, optopt);
	} else if (optopt >= 256) {
		fprintf(stderr, "%s: option '%s' takes no argument\n", o->tool, given);
	} else {
		char key[64];
		snprintf(key, sizeof key, "%.*s", (int)strcspn(given + 2, "="), given + 2);
		complain_unknown(o, "", key);
	}
}

options_result options_parse(options *o, int argc, char **argv)
{
	struct option longs[MAX_OPTIONS + N_COMMON + 1];
	char shorts[2 * (MAX_OPTIONS + N_COMMON) + 2];
	requests r = {0, 0, 0};

	make_getopt_tables(o, longs, shorts);
	for (int i = 0; i < o->n; i++)
		if (o->table[i].fallback != NULL && !set_value(o, i, "", o->table[i].fallback))
			return OPTIONS_WRONG;
	opterr = 0;
	for (int pass = 0; pass < 2; pass++) {
		optind = 0;
		for (int c; (c = getopt_long(argc, argv, shorts, longs, NULL)) != -1;) {
			if (c == '?' || c == ':') {
				complain_getopt(o, c, argv);
				return OPTIONS_WRONG;
			}
			options_result taken =
			    take(o, c >= 256 ? c - 256 : entry_of_letter(o, c), pass, optarg, &r);
			if (taken != OPTIONS_RUN)
				return taken;
		}
	}
	o->first_file = optind;
	if (r.help) {
		print_help(o);
	} else if (r.version) {
		printf("%s (furrow) %s\n", o->tool, FURROW_VERSION);
	} else if (r.print) {
		printf("[%s]\n", o->tool);
		options_each(o, print_setting, stdout);
	} else {
		return OPTIONS_RUN;
	}
	return OPTIONS_DONE;
}

int options_index(const options *o, const char *name)
{
	int i = find_entry(o, name);
	if (i < 0)
		abort(); /* a tool asked for an option that its own table lacks */
	return i;
}

const char *options_text(const options *o, const char *name)
{
	return o->text[options_index(o, name)];
}

double options_number(const options *o, const char *name)
{
	return o->number[options_index(o, name)];
}

int options_flag(const options *o, const char *name)
{
	return options_number(o, name) != 0;
}

const fw_time *options_time(const options *o, const char *name)
{
	int i = options_index(o, name);
	return o->text[i] != NULL ? &o->time[i] : NULL;
}
