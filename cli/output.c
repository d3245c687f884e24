#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tool.h"

static fw_status fail(output *out)
{
	if (out->error == 0)
		out->error = errno != 0 ? errno : EIO;
	return FW_EIO;
}

/* A regular file is replaced as a whole; a device, a pipe or a link to one is written as it is. */
static int is_replaceable(const char *path)
{
	struct stat s;
	return stat(path, &s) != 0 || S_ISREG(s.st_mode);
}

/* The file beside the target in which the new content grows: ".NAME.PID.part" in the same folder. */
static int name_aside(output *out)
{
	const char *slash = strrchr(out->path, '/');
	int folder = slash != NULL ? (int)(slash - out->path) + 1 : 0;
	int n = snprintf(out->aside, sizeof out->aside, "%.*s.%s.%ld.part", folder, out->path,
	                 out->path + folder, (long)getpid());
	return n > 0 && n < (int)sizeof out->aside;
}

fw_status output_open(output *out, const char *path)
{
	out->error = 0;
	out->aside[0] = '\0';
	out->fd = STDOUT_FILENO;
	if (path == NULL || strcmp(path, "-") == 0) {
		snprintf(out->path, sizeof out->path, "standard output");
		return FW_OK;
	}
	errno = ENAMETOOLONG;
	if (snprintf(out->path, sizeof out->path, "%s", path) >= (int)sizeof out->path)
		return fail(out);
	const char *target = path;
	int flags = O_WRONLY | O_CLOEXEC;
	if (is_replaceable(path)) {
		if (!name_aside(out))
			return fail(out);
		target = out->aside;
		flags |= O_CREAT | O_TRUNC;
	}
	do
		out->fd = open(target, flags, 0666);
	while (out->fd < 0 && errno == EINTR && !tool_interrupted());
	if (out->fd < 0) {
		out->aside[0] = '\0';
		return fail(out);
	}
	return FW_OK;
}

fw_status output_write(void *context, const void *bytes, size_t n)
{
	output *out = context;
	const char *p = bytes;
	if (out->error != 0)
		return FW_EIO;
	while (n > 0) {
		ssize_t written = write(out->fd, p, n);
		if (written < 0 && errno == EINTR)
			continue;
		if (written <= 0)
			return fail(out);
		p += written;
		n -= (size_t)written;
	}
	return FW_OK;
}

void output_discard(output *out)
{
	if (out->fd > STDERR_FILENO)
		close(out->fd);
	out->fd = -1;
	if (out->aside[0] != '\0')
		unlink(out->aside);
	out->aside[0] = '\0';
}

fw_status output_finish(output *out)
{
	while (out->error == 0 && out->fd >= 0 && out->aside[0] != '\0' && fsync(out->fd) != 0)
		if (errno != EINTR)
			(void)fail(out);
	/* A file system may report a failed write only now. */
	if (out->error == 0 && out->fd >= 0 && close(out->fd) != 0 && errno != EINTR)
		(void)fail(out);
	else if (out->error != 0 && out->fd > STDERR_FILENO)
		close(out->fd);
	out->fd = -1;
	return out->error != 0 ? FW_EIO : FW_OK;
}

fw_status output_commit(output *out)
{
	if (output_finish(out) == FW_OK && out->aside[0] != '\0' && rename(out->aside, out->path) != 0)
		(void)fail(out);
	if (out->error != 0 && out->aside[0] != '\0')
		unlink(out->aside);
	out->aside[0] = '\0';
	return out->error != 0 ? FW_EIO : FW_OK;
}
