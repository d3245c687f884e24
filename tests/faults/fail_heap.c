/* Preloaded: counts the calls of malloc, calloc, realloc and aligned_alloc, and lets one of them fail.
 *
 *   HEAP_FAIL   the number of the call that fails, from 1; unset: none
 *   HEAP_COUNT  a file; the number of calls is written there at the end
 *
 * A call that asks for nothing (free through realloc) counts too; libc's own calls, such as strdup's, come here as well. */
#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

extern void *__libc_malloc(size_t n);
extern void *__libc_calloc(size_t items, size_t n);
extern void *__libc_realloc(void *p, size_t n);
extern void *__libc_memalign(size_t alignment, size_t n);

static unsigned long calls;

static int must_fail(void)
{
	static unsigned long which;
	if (calls++ == 0 && getenv("HEAP_FAIL") != NULL)
		which = strtoul(getenv("HEAP_FAIL"), NULL, 10);
	if (calls != which)
		return 0;
	errno = ENOMEM;
	return 1;
}

void *malloc(size_t n)
{
	return must_fail() ? NULL : __libc_malloc(n);
}

void *calloc(size_t items, size_t n)
{
	return must_fail() ? NULL : __libc_calloc(items, n);
}

void *realloc(void *p, size_t n)
{
	return must_fail() ? NULL : __libc_realloc(p, n);
}

void *aligned_alloc(size_t alignment, size_t n)
{
	return must_fail() ? NULL : __libc_memalign(alignment, n);
}

__attribute__((destructor)) static void report(void)
{
	const char *name = getenv("HEAP_COUNT");
	char text[32];
	int n = snprintf(text, sizeof text, "%lu\n", calls), fd;
	if (name == NULL || (fd = open(name, O_WRONLY | O_CREAT | O_TRUNC, 0666)) < 0)
		return;
	if (write(fd, text, (size_t)n) != n)
		_exit(99);
	close(fd);
}
