#include "tool.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { SHOWN_PER_CAUSE = 5, PROGRESS_INTERVAL_NS = 200000000 };

static volatile sig_atomic_t noted_signal;

static __attribute__((format(printf, 2, 0))) void message(const tool *t, const char *format,
                                                          va_list arguments)
{
	char line[1024];
	vsnprintf(line, sizeof line, format, arguments);
	fprintf(stderr, "%s: %s\n", t->name, line);
}

void tool_error(const tool *t, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	message(t, format, arguments);
	va_end(arguments);
}

void tool_note(const tool *t, const char *format, ...)
{
	if (t->quiet)
		return;
	va_list arguments;
	va_start(arguments, format);
	message(t, format, arguments);
	va_end(arguments);
}

void tool_warn(tool *t, tool_cause cause, const char *format, ...)
{
	if (t->quiet || (++t->repeats[cause] > SHOWN_PER_CAUSE && !t->verbose))
		return;
	va_list arguments;
	va_start(arguments, format);
	message(t, format, arguments);
	va_end(arguments);
}

void tool_repeats(const tool *t)
{
	unsigned held_back = 0;
	for (int i = 0; i < CAUSE_COUNT; i++)
		if (t->repeats[i] > SHOWN_PER_CAUSE)
			held_back += t->repeats[i] - SHOWN_PER_CAUSE;
	if (held_back > 0 && !t->verbose)
		tool_note(t, "%u more messages like these (-v shows all)", held_back);
}

void tool_hold_standard_streams(void)
{
	static const int flags[] = {
	    [STDIN_FILENO] = O_WRONLY, [STDOUT_FILENO] = O_RDONLY, [STDERR_FILENO] = O_RDWR};
	for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
		if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", flags[fd]) != fd)
			_exit(EXIT_IO); /* nowhere to say why */
}

static void note_signal(int number)
{
	noted_signal = number;
}

void tool_catch_signals(void)
{
	struct sigaction act = {.sa_handler = note_signal};
	signal(SIGPIPE, SIG_DFL);
	sigaction(SIGINT, &act, NULL);
	sigaction(SIGTERM, &act, NULL);
}

int tool_interrupted(void)
{
	return noted_signal;
}

const volatile sig_atomic_t *tool_stop_flag(void)
{
	return &noted_signal;
}

int tool_die_of(int signal_number)
{
	signal(signal_number, SIG_DFL);
	raise(signal_number);
	return 128 + signal_number;
}

int tool_end_answer(const tool *t)
{
	const int failed = ferror(stdout);
	if (fclose(stdout) == 0 && !failed)
		return EXIT_COMPLETE;
	tool_error(t, "standard output: %s", strerror(errno));
	return EXIT_IO;
}

static int64_t monotonic_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

void tool_progress_start(tool_progress *p, const tool *t, const char *when, const char *file, int64_t size)
{
	int shown =
	    strcmp(when, "always") == 0 || (strcmp(when, "auto") == 0 && isatty(STDERR_FILENO) && !t->quiet);
	*p = (tool_progress){.owner = t, .file = file, .size = size, .shown = shown};
}

void tool_progress_update(tool_progress *p, int64_t bytes_read)
{
	if (!p->shown)
		return;
	int64_t now = monotonic_ns();
	if (now < p->next_ns)
		return;
	p->next_ns = now + PROGRESS_INTERVAL_NS;
	double megabytes = (double)bytes_read / 1e6;
	if (p->size > 0)
		fprintf(stderr, "\r%s: %s: %.0f MB, %.0f %%\033[K", p->owner->name, p->file, megabytes,
		        100.0 * (double)bytes_read / (double)p->size);
	else
		fprintf(stderr, "\r%s: %s: %.0f MB\033[K", p->owner->name, p->file, megabytes);
}

void tool_progress_end(tool_progress *p)
{
	if (p->shown && p->next_ns != 0)
		fprintf(stderr, "\r\033[K");
	p->shown = 0;
}
