/* Input: a file, stdin or memory, read forwards once. Gzip is recognised by its first two bytes and
 * inflated on the way, concatenated members included, so that nobody above has to know. No seeking, no
 * mapping (a file may shrink under a map), no heap: zlib works in the struct's own arena. */
#ifndef FURROW_FORMATS_INPUT_H
#define FURROW_FORMATS_INPUT_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <zlib.h>

#include "base/status.h"

enum {
	FW_INPUT_PEEK = 4096,       /* most bytes that fw_input_peek() looks ahead */
	FW_INPUT_RAW = 65536,       /* bytes read at once from a gzip file */
	FW_INPUT_ARENA = 64 * 1024, /* what inflate needs: about 42 KiB with zlib 1.2.13 */
};

/* Owned by the caller; about 135 KiB, so not for small stacks. Must not be moved or copied once opened
 * (zlib points back into it). Public to read: offset, error_number. */
typedef struct {
	uint64_t offset;  /* bytes handed out so far, counted in the uncompressed data */
	int error_number; /* errno behind the last FW_EIO */

	/* When not NULL and the value is non-zero, reading stops with FW_EIO and error_number EINTR: the
	 * way a signal handler ends a read that waits for a live pipe. NULL after opening; the caller may
	 * set it. */
	const volatile sig_atomic_t *stop;

	/* When not NULL, called with idle_context before a read that would wait because no data are there:
	 * the moment to hand on what has been made of those before. NULL after opening, as stop. */
	void (*idle)(void *context);
	void *idle_context;

	/* Private from here. */
	int fd;                /* -1: memory */
	const uint8_t *memory; /* what is left of it */
	size_t memory_left;
	bool started, gzip, member_done;
	fw_status latched; /* FW_OK until the input ends or fails; then what every further read says */
	z_stream z;
	size_t raw_pos, raw_end, head_pos, head_end, arena_used;
	uint8_t raw[FW_INPUT_RAW];   /* compressed bytes; the first two of any input */
	uint8_t head[FW_INPUT_PEEK]; /* uncompressed bytes that were peeked at and not read yet */
	_Alignas(16) uint8_t arena[FW_INPUT_ARENA];
} fw_input;

/* Open a file, or stdin for "-". Nothing is read yet, so this does not wait for a pipe.
 *   in    out  ready to be read; fw_input_close() it
 *   path  in   name, or "-"
 * Returns FW_OK; FW_EIO (in->error_number says why, nothing to close; EINTR: a signal came while opening a
 * named pipe waited for its writer). */
fw_status fw_input_open(fw_input *in, const char *path) FW_MUST_CHECK;

/* Read from memory instead; the bytes stay the caller's and must outlive the reading. Cannot fail. */
void fw_input_open_memory(fw_input *in, const void *bytes, size_t n);

/* Read up to n bytes. Waits only until there is at least one, so a live pipe is passed on at once.
 *   buf  out  n bytes of room
 *   got  out  bytes read: 1 .. n with FW_OK, otherwise 0
 * Returns FW_OK (with n = 0 too); FW_EOF; FW_EIO (in->error_number); FW_EFORMAT: not what gzip writes;
 * FW_ETRUNCATED: the gzip data are cut short; FW_ENOMEM: a zlib that wants more than the arena. All that
 * was readable before a failure is handed out first; then the status stays. */
fw_status fw_input_read(fw_input *in, void *buf, size_t n, size_t *got) FW_MUST_CHECK;

/* Look at the first bytes that have not been read, without consuming them.
 *   want   in   wait for so many (at most FW_INPUT_PEEK)
 *   bytes  out  where they are; valid until the next call with this input
 *   got    out  how many there are: maybe more than want, fewer only when the input ends or fails there
 * Returns FW_OK when got > 0; otherwise as fw_input_read(); FW_EINVAL: want is 0 or too large. */
fw_status fw_input_peek(fw_input *in, size_t want, const uint8_t **bytes, size_t *got) FW_MUST_CHECK;

/* Close the file (stdin stays open). Harmless after a failure, and when called twice. */
void fw_input_close(fw_input *in);

#endif
