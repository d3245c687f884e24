/* RINEX clock files: offsets of the satellites' clocks, one at a time. Versions 2 and 3.
 *
 * Source: J. Ray, W. Gurtner, M. Coleman, "RINEX Extensions to Handle Clock Information", versions 2.00
 * (1999), 3.02 (2010) and 3.04 (2017, names of nine characters). */
#ifndef FURROW_FORMATS_RINEX_CLOCK_H
#define FURROW_FORMATS_RINEX_CLOCK_H

#include <stdbool.h>

#include "base/time.h"
#include "formats/rinex.h"
#include "gnss/signal.h"

typedef struct {
	fw_time time;
	fw_satellite satellite;
	double clock_s; /* offset, periodic relativistic effect not included */
	double sd_s;    /* its standard deviation; 0: not given */
} fw_rinex_clock_point;

/* Owned by the caller. Public to read: lines.number, reason. */
typedef struct {
	fw_lines lines;
	const char *reason; /* why the last fw_rinex_clock_read() failed: a few words of English */

	/* Private. */
	bool begun, in_header;
	fw_rinex_time scale;
	size_t shift; /* columns by which labels and fields lie further right than in version 3.02 */
	uint64_t overlong;
} fw_rinex_clock_reader;

/* Begin to read; the caller closes the input. */
void fw_rinex_clock_begin(fw_rinex_clock_reader *r, fw_input *input);

/* The next satellite clock (AS); receivers' clocks and calibrations are passed over, and so are satellites
 * that furrow does not name.
 * Returns
 *   FW_OK          a clock
 *   FW_ESYNTAX     line r->lines.number is lost, r->reason says why; call again
 *   FW_EOF         the end
 *   FW_ETRUNCATED  the end, inside the header, or a gzip file that is cut short
 *   FW_EUNKNOWN    not a RINEX clock file, or a version or time scale that furrow does not know
 *   FW_EIO, FW_EFORMAT, FW_ENOMEM   from fw_input_read()
 * All but the first two are final. *point is set with FW_OK only. */
fw_status fw_rinex_clock_read(fw_rinex_clock_reader *r, fw_rinex_clock_point *point) FW_MUST_CHECK;

#endif
