/* What the harnesses of tools share: a file in memory, and silence. */
#ifndef FURROW_TESTS_FUZZ_TOOL_INPUT_H
#define FURROW_TESTS_FUZZ_TOOL_INPUT_H

#include <sys/mman.h>
#include <unistd.h>

#include "fuzz.h"

/* A file that lives in memory and holds these bytes, always the same one; its name in *path. Returns its
 * descriptor, at its beginning. */
static inline int tool_file(const uint8_t *data, size_t size, const char **path)
{
	static char name[32];
	static int fd = -1;
	if (fd < 0) {
		fd = memfd_create("input", 0);
		snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
	}
	require(fd >= 0 && ftruncate(fd, 0) == 0);
	require(pwrite(fd, data, size, 0) == (ssize_t)size);
	require(lseek(fd, 0, SEEK_SET) == 0);
	*path = name;
	return fd;
}

/* stdout and stderr of the C library to nowhere, so that thousands of messages need not be read. The sanitizers write
 * to descriptor 2, which stays. */
typedef struct {
	FILE *out, *err;
} tool_streams;

static inline tool_streams tool_hush(void)
{
	static FILE *nowhere;
	const tool_streams old = {stdout, stderr};
	if (nowhere == NULL)
		nowhere = fopen("/dev/null", "w");
	stderr = nowhere;
	stdout = fopen("/dev/null", "w"); /* the tool closes it, or we do */
	require(stderr != NULL && stdout != NULL);
	return old;
}

static inline void tool_speak(tool_streams old, int closed)
{
	if (!closed)
		fclose(stdout);
	stdout = old.out;
	stderr = old.err;
}

#endif
