/* What all tools share beside options and output: exit status, messages, signals, progress. */
#ifndef FURROW_CLI_TOOL_H
#define FURROW_CLI_TOOL_H

#include <signal.h>
#include <stdint.h>

/* Exit status, the same for every tool. */
enum {
	EXIT_COMPLETE = 0,
	EXIT_PARTIAL = 1, /* output written, but some input was skipped, cut short or refused */
	EXIT_USAGE = 2,   /* usage or configuration */
	EXIT_IO = 3,      /* input or output failed */
	EXIT_NO_DATA = 4  /* no usable data, no solution */
};

/* Kinds of messages that repeat; each is shown a few times and then only counted. */
typedef enum {
	CAUSE_DAMAGE,
	CAUSE_TRUNCATED,
	CAUSE_ROW,
	CAUSE_UNKNOWN,
	CAUSE_UNSUPPORTED,
	CAUSE_REFUSED,
	CAUSE_COUNT
} tool_cause;

typedef struct {
	const char *name;
	int quiet;   /* -q: errors only */
	int verbose; /* -v: every message, however often it repeats */
	unsigned repeats[CAUSE_COUNT];
} tool;

/* One line on stderr: "NAME: message". For errors that end the tool; -q does not silence it. */
void tool_error(const tool *t, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* One line on stderr unless -q. */
void tool_note(const tool *t, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* One line on stderr for something that may repeat: after five of a cause the rest are only counted (not with -v). */
void tool_warn(tool *t, tool_cause cause, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Says how many messages of each cause were held back. */
void tool_repeats(const tool *t);

/* To be called first. A program started without stdin, stdout or stderr would get its own files under their numbers,
 * and its messages into them; this puts something there that cannot be read from, or written to. */
void tool_hold_standard_streams(void);

/* SIGPIPE ends the tool silently; SIGINT and SIGTERM are noted so that the tool can end with whole rows. */
void tool_catch_signals(void);

/* The signal that was noted, or 0. */
int tool_interrupted(void);

/* The same, for code that waits: not 0 once a signal was noted. */
const volatile sig_atomic_t *tool_stop_flag(void);

/* Ends the program as the noted signal would have. Returns 128 + signal should that not work. */
int tool_die_of(int signal_number);

/* --help and the like have been printed to stdout; has it arrived? Returns EXIT_COMPLETE, or EXIT_IO after a message. */
int tool_end_answer(const tool *t);

/* A progress line on stderr: how much of the input has been read. */
typedef struct {
	const tool *owner;
	const char *file;
	int64_t size;    /* bytes; 0: not known */
	int64_t next_ns; /* monotonic time of the next update */
	int shown;
} tool_progress;

/* `when` is auto (stderr is a terminal), always or never. */
void tool_progress_start(tool_progress *p, const tool *t, const char *when, const char *file, int64_t size);
void tool_progress_update(tool_progress *p, int64_t bytes_read);
void tool_progress_end(tool_progress *p);

#endif
