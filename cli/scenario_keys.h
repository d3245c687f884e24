/* The keys of a scenario: one table, from which they are read, printed and checked. */
#ifndef FURROW_CLI_SCENARIO_KEYS_H
#define FURROW_CLI_SCENARIO_KEYS_H

#include "scenario.h"

typedef enum {
	KEY_NUMBER,     /* double */
	KEY_NUMBERS,    /* array of `n` doubles */
	KEY_LIST,       /* scenario_list: up to SCENARIO_LIST numbers */
	KEY_TEXT,       /* char[SCENARIO_TEXT] */
	KEY_CHOICE,     /* int: which of the words in `words` */
	KEY_FLAG,       /* bool */
	KEY_TIME,       /* fw_time */
	KEY_SATELLITES, /* fw_satellite_set */
	KEY_ROUTE,      /* adds a scenario_route of kind `n` */
	KEY_IMU_GRADE,  /* a choice that sets the IMU's other keys */
	KEY_CLOCK_MODEL /* a choice that sets the clock's other keys; `offset` is that of the model, `n` of the choice */
} scenario_key_type;

typedef struct {
	const char *section, *name;
	scenario_key_type type;
	size_t offset; /* in scenario; of a mask or fault in fw_mask, fw_fault */
	unsigned n;
	double unit;     /* SI value of 1 */
	double min, max; /* in the key's own unit */
	const char *words;
	const char *fallback; /* NULL: none */
} scenario_key;

extern const scenario_key scenario_keys[];
extern const int scenario_n_keys;

/* The key called `name` in a section ("mask" for [mask tree-line]); NULL: no such key. */
const scenario_key *scenario_key_find(const char *section, const char *name);

/* Whether any key belongs to that section. */
bool scenario_section_known(const char *section);

/* The nearest key of the section, or the nearest section; NULL: none is near. */
const char *scenario_key_near(const char *section, const char *name);
const char *scenario_section_near(const char *section);

/* Sets a key of what lies at `base` to `value`. Of a scenario's route the line is noted. Returns false with
 * a few words in `why` (at least 160 characters) when the value is none; *base untouched. */
bool scenario_key_set(const scenario_key *key, void *base, const char *value, int line, char *why,
                      size_t room);

/* Writes "name = value" lines for a key. */
void scenario_key_print(const scenario_key *key, const void *base, FILE *to);

#endif
