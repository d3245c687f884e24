/* Text of RINEX files on its way out: fixed columns, header lines, a buffer. */
#ifndef FURROW_FORMATS_RINEX_OUT_H
#define FURROW_FORMATS_RINEX_OUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/time.h"
#include "formats/record.h"

enum {
	FW_RINEX_OUT_BUFFER = 128 * 1024,
	FW_RINEX_OUT_LINE = 16 * 1024 /* room that a line may need */
};

typedef struct {
	fw_status status; /* FW_OK, or the first failure of `output`; after it nothing more is written */

	/* Private from here. */
	fw_output *output;
	void *context;
	size_t used, line; /* where the line at hand begins */
	char buffer[FW_RINEX_OUT_BUFFER];
} fw_rinex_out;

void fw_rinex_out_begin(fw_rinex_out *o, fw_output *output, void *context);

/* Append to the line at hand: text as it is; text in a field of n columns, cut or filled with blanks; a whole
 * number right-aligned in n columns; x with decimals right-aligned in n columns (blanks if it does not fit);
 * x as D19.12. A line has at most FW_RINEX_OUT_LINE bytes. */
void fw_rinex_out_text(fw_rinex_out *o, const char *text);
void fw_rinex_out_field(fw_rinex_out *o, const char *text, size_t n);
void fw_rinex_out_int(fw_rinex_out *o, int64_t x, size_t n);
void fw_rinex_out_fixed(fw_rinex_out *o, double x, size_t n, int decimals);
void fw_rinex_out_scientific(fw_rinex_out *o, double x);

/* Fill the line at hand with blanks up to a column. */
void fw_rinex_out_column(fw_rinex_out *o, size_t column);

/* End the line at hand: blanks at its end are dropped. With a label: it comes in column 60. */
void fw_rinex_out_end_line(fw_rinex_out *o);
void fw_rinex_out_label(fw_rinex_out *o, const char *label);

/* The lines that every file begins with. `type` is columns 20 to 39, the system mixed; `made` is the date. */
void fw_rinex_out_head(fw_rinex_out *o, const char *type, fw_time made);

/* Hands on what is in the buffer. Returns o->status. */
fw_status fw_rinex_out_flush(fw_rinex_out *o) FW_MUST_CHECK;

#endif
