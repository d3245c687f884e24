/* SP3: tables of satellite positions and clocks, one point at a time. Versions a to d.
 *
 *     fw_input_open(&input, name);
 *     fw_sp3_begin(&sp3, &input);
 *     while ((status = fw_sp3_read(&sp3, &point)) == FW_OK || status == FW_ESYNTAX)
 *             ...
 *
 * Source: S. Hilla, "The Extended Standard Product 3 Orbit Format (SP3-c)", 2010, and "(SP3-d)", 2016. */
#ifndef FURROW_FORMATS_SP3_H
#define FURROW_FORMATS_SP3_H

#include <stdbool.h>

#include "base/time.h"
#include "formats/rinex.h"
#include "gnss/signal.h"

/* A satellite at an epoch. */
typedef struct {
	fw_time time;
	fw_satellite satellite;
	bool has_position, has_clock;
	bool clock_event;     /* the clock jumped between the epoch before and this one */
	bool clock_predicted; /* not observed */
	bool manoeuvre;       /* the satellite manoeuvred between the epoch before and this one */
	bool orbit_predicted;
	double position_m[3]; /* ECEF, centre of mass */
	double clock_s;       /* offset, periodic relativistic effect not included */
} fw_sp3_point;

/* Owned by the caller. Public to read: lines.number, reason. */
typedef struct {
	fw_lines lines;
	const char *reason; /* why the last fw_sp3_read() failed: a few words of English */

	/* Private. */
	bool begun, has_epoch, ended;
	bool tai; /* the time scale: TAI, or else */
	fw_rinex_time scale;
	fw_time epoch;
	uint64_t overlong;
} fw_sp3_reader;

/* Begin to read; the caller closes the input. Files that follow one another in one input are read as one. */
void fw_sp3_begin(fw_sp3_reader *r, fw_input *input);

/* The next point: velocities, correlations and comments are passed over, and so are satellites that furrow
 * does not name (low orbits, "L").
 * Returns
 *   FW_OK          a point
 *   FW_ESYNTAX     line r->lines.number is lost, r->reason says why; call again
 *   FW_EOF         the end, behind the line EOF
 *   FW_ETRUNCATED  the end, but no line EOF before it, or a gzip file that is cut short
 *   FW_EUNKNOWN    not SP3, or a version or time scale that furrow does not know
 *   FW_EIO, FW_EFORMAT, FW_ENOMEM   from fw_input_read()
 * All but the first two are final. *point is set with FW_OK only. */
fw_status fw_sp3_read(fw_sp3_reader *r, fw_sp3_point *point) FW_MUST_CHECK;

#endif
