#include "formats/input.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <unistd.h>

/* zlib's memory, from the arena. It asks twice (state and window), frees at the end, and so does not need
 * a heap. */
static voidpf arena_alloc(voidpf opaque, uInt items, uInt size)
{
	fw_input *in = opaque;
	const size_t room = sizeof(in->arena) - in->arena_used;
	const uint64_t wanted = ((uint64_t)items * size + 15) & ~(uint64_t)15;
	uint8_t *p = in->arena + in->arena_used;

	if (wanted > room)
		return Z_NULL;
	in->arena_used += (size_t)wanted;
	return p;
}

static void arena_free(voidpf opaque, voidpf address)
{
	(void)opaque;
	(void)address;
}

/* Everything but the big buffers, which are written before they are read. */
static void reset(fw_input *in)
{
	in->offset = 0;
	in->error_number = 0;
	in->stop = NULL;
	in->idle = NULL;
	in->idle_context = NULL;
	in->fd = -1;
	in->memory = NULL;
	in->memory_left = 0;
	in->started = in->gzip = in->member_done = false;
	in->latched = FW_OK;
	memset(&in->z, 0, sizeof(in->z));
	in->raw_pos = in->raw_end = in->head_pos = in->head_end = in->arena_used = 0;
}

fw_status fw_input_open(fw_input *in, const char *path)
{
	reset(in);
	if (strcmp(path, "-") == 0) {
		in->fd = STDIN_FILENO;
		return FW_OK;
	}
	in->fd = open(path, O_RDONLY | O_CLOEXEC);
	if (in->fd < 0) {
		in->error_number = errno;
		in->latched = FW_EIO;
		return FW_EIO;
	}
	return FW_OK;
}

void fw_input_open_memory(fw_input *in, const void *bytes, size_t n)
{
	reset(in);
	in->memory = bytes;
	in->memory_left = n;
}

static size_t read_memory(fw_input *in, void *buf, size_t n)
{
	const size_t take = n < in->memory_left ? n : in->memory_left;

	if (take > 0)
		memcpy(buf, in->memory, take);
	in->memory += take;
	in->memory_left -= take;
	return take;
}

/* Would a read have to wait? At the end of the input, or after a failure, it would not. */
static bool would_wait(int fd)
{
	struct pollfd ready = {.fd = fd, .events = POLLIN};

	return poll(&ready, 1, 0) == 0;
}

/* Up to n bytes as they are stored; *got = 0 with FW_OK is the end. */
static fw_status read_stored(fw_input *in, void *buf, size_t n, size_t *got)
{
	ssize_t r;

	*got = 0;
	if (in->fd < 0) {
		*got = read_memory(in, buf, n);
		return FW_OK;
	}
	if (in->idle != NULL && would_wait(in->fd))
		in->idle(in->idle_context);
	do {
		if (in->stop != NULL && *in->stop != 0) {
			in->error_number = EINTR;
			return FW_EIO;
		}
		r = read(in->fd, buf, n);
	} while (r < 0 && errno == EINTR);
	if (r < 0) {
		in->error_number = errno;
		return FW_EIO;
	}
	*got = (size_t)r;
	return FW_OK;
}

/* Move what is left of raw to its front and add to it; *got as read_stored(). */
static fw_status refill_raw(fw_input *in, size_t *got)
{
	const size_t left = in->raw_end - in->raw_pos;
	fw_status status;

	memmove(in->raw, in->raw + in->raw_pos, left);
	in->raw_pos = 0;
	in->raw_end = left;
	status = read_stored(in, in->raw + left, sizeof(in->raw) - left, got);
	in->raw_end += *got;
	return status;
}

/* Gzip or not? The first two bytes say it (RFC 1952, 2.3.1). */
static fw_status start(fw_input *in)
{
	size_t got;
	fw_status status;

	while (in->raw_end < 2) {
		status = refill_raw(in, &got);
		if (status != FW_OK)
			return status;
		if (got == 0)
			break;
	}
	in->started = true;
	in->gzip = in->raw_end >= 2 && in->raw[0] == 0x1f && in->raw[1] == 0x8b;
	if (!in->gzip)
		return FW_OK;
	in->z.zalloc = arena_alloc;
	in->z.zfree = arena_free;
	in->z.opaque = in;
	return inflateInit2(&in->z, 15 + 16) == Z_OK ? FW_OK : FW_ENOMEM; /* 15 + 16: gzip, any window */
}

static fw_status read_plain(fw_input *in, void *buf, size_t n, size_t *got)
{
	const size_t left = in->raw_end - in->raw_pos;
	fw_status status;

	if (left > 0) {
		*got = n < left ? n : left;
		memcpy(buf, in->raw + in->raw_pos, *got);
		in->raw_pos += *got;
		return FW_OK;
	}
	status = read_stored(in, buf, n, got);
	return status != FW_OK || *got > 0 ? status : FW_EOF;
}

/* Behind a member: another one, padding with zeros (tapes; gzip(1) ignores it too), or the end. */
static fw_status next_member(fw_input *in)
{
	while (in->raw_pos < in->raw_end && in->raw[in->raw_pos] == 0)
		in->raw_pos++;
	if (in->raw_pos == in->raw_end)
		return FW_OK;
	in->member_done = false;
	return inflateReset(&in->z) == Z_OK ? FW_OK : FW_EFORMAT;
}

static fw_status inflate_some(fw_input *in, void *buf, size_t n, size_t *got)
{
	const uInt room = n < (1u << 30) ? (uInt)n : 1u << 30;
	int result;

	in->z.next_in = in->raw + in->raw_pos;
	in->z.avail_in = (uInt)(in->raw_end - in->raw_pos);
	in->z.next_out = buf;
	in->z.avail_out = room;
	result = inflate(&in->z, Z_NO_FLUSH);
	in->raw_pos = in->raw_end - in->z.avail_in;
	*got = room - in->z.avail_out;
	in->member_done = result == Z_STREAM_END;
	if (result == Z_OK || result == Z_STREAM_END || result == Z_BUF_ERROR)
		return FW_OK;
	return result == Z_MEM_ERROR ? FW_ENOMEM : FW_EFORMAT;
}

static fw_status read_gzip(fw_input *in, void *buf, size_t n, size_t *got)
{
	size_t more;
	fw_status status = FW_OK;

	while (status == FW_OK) {
		/* First without new bytes: zlib may hold some back that a small buf had no room for. */
		if (!in->member_done)
			status = inflate_some(in, buf, n, got);
		if (status != FW_OK || *got > 0)
			return status;
		if (in->raw_pos == in->raw_end) {
			status = refill_raw(in, &more);
			if (status == FW_OK && more == 0)
				return in->member_done ? FW_EOF : FW_ETRUNCATED;
		} else if (in->member_done) {
			status = next_member(in);
		}
	}
	return status;
}

/* The next bytes behind head. What comes with a failure is handed out first, the failure latched for the
 * next call. */
static fw_status read_behind_head(fw_input *in, void *buf, size_t n, size_t *got)
{
	fw_status status = in->latched;

	*got = 0;
	if (status == FW_OK && !in->started)
		status = start(in);
	if (status == FW_OK)
		status = in->gzip ? read_gzip(in, buf, n, got) : read_plain(in, buf, n, got);
	in->latched = status;
	return *got > 0 ? FW_OK : status;
}

fw_status fw_input_read(fw_input *in, void *buf, size_t n, size_t *got)
{
	const size_t head = in->head_end - in->head_pos;
	fw_status status = FW_OK;

	*got = 0;
	if (n == 0)
		return FW_OK;
	if (head > 0) {
		*got = n < head ? n : head;
		memcpy(buf, in->head + in->head_pos, *got);
		in->head_pos += *got;
	} else {
		status = read_behind_head(in, buf, n, got);
	}
	in->offset += *got;
	return status;
}

fw_status fw_input_peek(fw_input *in, size_t want, const uint8_t **bytes, size_t *got)
{
	size_t have = in->head_end - in->head_pos, more;
	fw_status status = FW_OK;

	*got = 0;
	if (want == 0 || want > sizeof(in->head))
		return FW_EINVAL;
	memmove(in->head, in->head + in->head_pos, have);
	for (; have < want && status == FW_OK; have += more)
		status = read_behind_head(in, in->head + have, sizeof(in->head) - have, &more);
	in->head_pos = 0;
	in->head_end = have;
	*bytes = in->head;
	*got = have;
	return have > 0 ? FW_OK : status;
}

void fw_input_close(fw_input *in)
{
	if (in->gzip)
		(void)inflateEnd(&in->z);
	if (in->fd > STDIN_FILENO)
		(void)close(in->fd);
	in->fd = -1;
	in->memory_left = 0;
	in->gzip = false;
	in->latched = FW_EOF;
	in->started = true;
	in->raw_pos = in->raw_end = in->head_pos = in->head_end = 0;
}
