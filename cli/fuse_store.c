#include "fuse_store.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { CHUNK = 1 << 20 };

void fuse_budget_begin(fuse_budget *b, uint64_t memory)
{
	*b = (fuse_budget){.memory_left = memory, .fd = -1};
}

void fuse_budget_end(fuse_budget *b)
{
	if (b->fd >= 0)
		close(b->fd);
	b->fd = -1;
}

static void *fail(fuse_store *s)
{
	if (s->budget->error == 0)
		s->budget->error = errno != 0 ? errno : EIO;
	return NULL;
}

void fuse_store_begin(fuse_store *s, fuse_budget *budget, size_t size)
{
	*s = (fuse_store){.budget = budget, .size = size, .per_chunk = CHUNK / size, .in_window = SIZE_MAX};
}

/* A file in TMPDIR that nobody else sees and that is gone when it is closed. */
static bool open_file(fuse_budget *b)
{
	const char *folder = getenv("TMPDIR");
	char path[PATH_MAX];
	if (b->fd >= 0)
		return true;
	if (folder == NULL || folder[0] == '\0')
		folder = "/tmp";
	errno = ENAMETOOLONG;
	if (snprintf(path, sizeof path, "%s/furrow.XXXXXX", folder) >= (int)sizeof path)
		return false;
	b->fd = mkostemp(path, O_CLOEXEC);
	if (b->fd >= 0)
		unlink(path);
	return b->fd >= 0;
}

static bool move_bytes(bool out, int fd, char *bytes, size_t n, int64_t offset)
{
	while (n > 0) {
		const ssize_t moved = out ? pwrite(fd, bytes, n, offset) : pread(fd, bytes, n, offset);
		if (moved < 0 && errno == EINTR)
			continue;
		if (moved <= 0)
			return false;
		bytes += moved;
		offset += moved;
		n -= (size_t)moved;
	}
	return true;
}

static bool write_back(fuse_store *s)
{
	if (!s->changed)
		return true;
	s->changed = false;
	return move_bytes(true, s->budget->fd, s->window, CHUNK, s->chunk[s->in_window].offset);
}

/* Where a chunk's bytes are: in memory, or in the window once that shows it. */
static char *look_at(fuse_store *s, size_t number, bool fresh)
{
	if (s->chunk[number].memory != NULL)
		return s->chunk[number].memory;
	if (s->in_window == number)
		return s->window;
	if (s->window == NULL && (s->window = malloc(CHUNK)) == NULL)
		return fail(s);
	errno = 0;
	if (!write_back(s))
		return fail(s);
	if (fresh)
		memset(s->window, 0, CHUNK);
	else if (!move_bytes(false, s->budget->fd, s->window, CHUNK, s->chunk[number].offset))
		return fail(s);
	s->in_window = number;
	return s->window;
}

static bool add_chunk(fuse_store *s)
{
	fuse_budget *b = s->budget;
	fuse_chunk c = {0};
	if (s->n_chunks == s->room) {
		const size_t room = s->room > 0 ? 2 * s->room : 64;
		fuse_chunk *more = realloc(s->chunk, room * sizeof *more);
		if (more == NULL)
			return fail(s) != NULL;
		s->chunk = more;
		s->room = room;
	}
	if (b->memory_left >= CHUNK && (c.memory = calloc(1, CHUNK)) != NULL) {
		b->memory_left -= CHUNK;
		b->in_memory += CHUNK;
	} else {
		if (!open_file(b))
			return fail(s) != NULL;
		c.offset = b->file_end;
		b->file_end += CHUNK;
		b->in_file += CHUNK;
	}
	if (b->in_memory + b->in_file > b->most)
		b->most = b->in_memory + b->in_file;
	s->chunk[s->n_chunks++] = c;
	return look_at(s, s->n_chunks - 1, true) != NULL;
}

static char *record_at(fuse_store *s, uint64_t i)
{
	char *chunk = look_at(s, (size_t)(i / s->per_chunk), false);
	return chunk != NULL ? chunk + i % s->per_chunk * s->size : NULL;
}

void *fuse_store_add(fuse_store *s)
{
	if (s->budget->error != 0)
		return NULL;
	if (s->n == s->n_chunks * s->per_chunk && !add_chunk(s))
		return NULL;
	char *record = record_at(s, s->n++);
	s->changed |= s->chunk[s->n_chunks - 1].memory == NULL;
	return record;
}

const void *fuse_store_at(fuse_store *s, uint64_t i)
{
	return record_at(s, i);
}

void fuse_store_end(fuse_store *s)
{
	fuse_budget *b = s->budget;
	for (size_t i = 0; i < s->n_chunks; i++) {
		if (s->chunk[i].memory != NULL) {
			b->memory_left += CHUNK;
			b->in_memory -= CHUNK;
		} else {
			b->in_file -= CHUNK;
		}
		free(s->chunk[i].memory);
	}
	if (b->in_file == 0) { /* nobody has anything in the file any more */
		b->file_end = 0;
		if (b->fd >= 0)
			(void)!ftruncate(b->fd, 0);
	}
	free(s->chunk);
	free(s->window);
	fuse_store_begin(s, b, s->size);
}
