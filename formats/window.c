#include "formats/window.h"

#include <string.h>

void fw_window_begin(fw_window *w, fw_input *input)
{
	w->offset = 0;
	w->status = FW_OK;
	w->bytes = w->buffer;
	w->n = 0;
	w->input = input;
}

bool fw_window_need(fw_window *w, size_t n)
{
	while (w->n < n) {
		size_t begin = (size_t)(w->bytes - w->buffer), got;

		if (w->status != FW_OK)
			return false;
		if (w->n == 0 || begin + n > sizeof w->buffer) {
			memmove(w->buffer, w->bytes, w->n);
			w->bytes = w->buffer;
			begin = 0;
		}
		w->status =
		    fw_input_read(w->input, w->buffer + begin + w->n, sizeof w->buffer - begin - w->n, &got);
		w->n += got;
	}
	return true;
}

void fw_window_skip(fw_window *w, size_t n)
{
	w->bytes += n;
	w->n -= n;
	w->offset += n;
}
