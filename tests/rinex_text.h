/* RINEX files made in memory, line by line, and what a reader finds in them. */
#ifndef FURROW_TESTS_RINEX_TEXT_H
#define FURROW_TESTS_RINEX_TEXT_H

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct {
	size_t used;
	char bytes[1 << 16];
} rinex_text;

/* Appends a line. */
static inline __attribute__((format(printf, 2, 3))) void add_line(rinex_text *t, const char *format, ...)
{
	va_list list;

	va_start(list, format);
	const int n = vsnprintf(t->bytes + t->used, sizeof t->bytes - t->used, format, list);
	va_end(list);
	t->used += (size_t)n;
	t->bytes[t->used++] = '\n';
}

/* Appends a header line: its text, blanks up to column 60, its label. */
static inline void add_header(rinex_text *t, const char *text, const char *label)
{
	add_line(t, "%-60s%-20s", text, label);
}

/* Replaces the first `from` by `to`, of the same length. Returns whether it was there. */
static inline int replace(rinex_text *t, const char *from, const char *to)
{
	char *p = memmem(t->bytes, t->used, from, strlen(from));

	if (p != NULL)
		memcpy(p, to, strlen(to));
	return p != NULL;
}

#endif
