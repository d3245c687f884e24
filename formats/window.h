/* A stretch of an input that can be looked at before it is taken: for readers of binary logs. */
#ifndef FURROW_FORMATS_WINDOW_H
#define FURROW_FORMATS_WINDOW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "formats/input.h"

enum {
	FW_WINDOW_MOST = 2 * 65536, /* most bytes that can be asked for */
	FW_WINDOW_BUFFER = 4 * 65536
};

/* Owned by the caller. Public to read: offset, status, bytes. */
typedef struct {
	uint64_t offset;      /* of bytes[0] in the input */
	fw_status status;     /* FW_OK until the input ends or fails */
	const uint8_t *bytes; /* what lies ahead */
	size_t n;             /* how much of it is there */

	/* Private from here. */
	fw_input *input;
	uint8_t buffer[FW_WINDOW_BUFFER];
} fw_window;

void fw_window_begin(fw_window *w, fw_input *input);

/* Waits for n bytes ahead, n <= FW_WINDOW_MOST. Returns false when the input ends or fails before: w->n says
 * how many are there, w->status why. Earlier values of w->bytes are void afterwards. */
bool fw_window_need(fw_window *w, size_t n);

/* Leaves n <= w->n bytes behind. */
void fw_window_skip(fw_window *w, size_t n);

#endif
