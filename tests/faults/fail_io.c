/* Preloaded: lets a system call fail, be interrupted, or do less than it was asked for.
 *
 *   IO_CALL    which: open, read, write, fsync, close, rename, mkdir
 *   IO_NTH     the number of the call that fails, from 1
 *   IO_ERRNO   EIO, ENOSPC or EINTR; after EINTR the next call works
 *   IO_SHORT   reads and writes move at most so many bytes
 *   IO_STORM   every second open, read, write and fsync ends with EINTR
 *   IO_DONE    a file that is made when the call has failed
 *
 * Calls on stderr are let through; so are those that libc makes for itself, such as stdio's. */
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static long number(const char *name)
{
	const char *text = getenv(name);
	return text != NULL ? strtol(text, NULL, 10) : 0;
}

static void leave_word(void)
{
	const char *name = getenv("IO_DONE");
	if (name != NULL)
		syscall(SYS_close, syscall(SYS_openat, AT_FDCWD, name, O_WRONLY | O_CREAT, 0666));
}

static int named_errno(void)
{
	const char *name = getenv("IO_ERRNO");
	return name == NULL || strcmp(name, "EIO") == 0 ? EIO : strcmp(name, "ENOSPC") == 0 ? ENOSPC : EINTR;
}

/* Is this the call that has to fail? Sets errno. */
static int fails(const char *call)
{
	static long seen;
	static int storm;
	const char *wanted = getenv("IO_CALL");

	if (getenv("IO_STORM") != NULL && strstr("open read write fsync", call) != NULL &&
	    (storm ^= 1) != 0) {
		errno = EINTR;
		return 1;
	}
	if (wanted == NULL || strcmp(call, wanted) != 0 || ++seen != number("IO_NTH"))
		return 0;
	leave_word();
	errno = named_errno();
	return 1;
}

static size_t shortened(size_t n)
{
	size_t most = (size_t)number("IO_SHORT");
	return most > 0 && most < n ? most : n;
}

int open(const char *path, int flags, ...)
{
	va_list rest;
	va_start(rest, flags);
	unsigned mode = flags & O_CREAT ? va_arg(rest, unsigned) : 0;
	va_end(rest);
	return fails("open") ? -1 : (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

ssize_t read(int fd, void *buffer, size_t n)
{
	return fails("read") ? -1 : syscall(SYS_read, fd, buffer, shortened(n));
}

/* What read() becomes with _FORTIFY_SOURCE when the buffer's size is known. */
ssize_t __read_chk(int fd, void *buffer, size_t n, size_t room)
{
	return n > room ? (abort(), -1) : read(fd, buffer, n);
}

ssize_t write(int fd, const void *buffer, size_t n)
{
	if (fd != STDERR_FILENO && fails("write"))
		return -1;
	return syscall(SYS_write, fd, buffer, shortened(n));
}

int fsync(int fd)
{
	return fails("fsync") ? -1 : (int)syscall(SYS_fsync, fd);
}

/* A close that fails closes nevertheless, as Linux does. */
int close(int fd)
{
	int failed = fails("close"), error = errno;
	int result = (int)syscall(SYS_close, fd);
	errno = failed ? error : errno;
	return failed ? -1 : result;
}

int rename(const char *from, const char *to)
{
	return fails("rename") ? -1 : (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int mkdir(const char *path, mode_t mode)
{
	return fails("mkdir") ? -1 : (int)syscall(SYS_mkdirat, AT_FDCWD, path, mode);
}
