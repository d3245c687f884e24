/* RTKLIB's solution files (.pos) as `pos` records.
 *
 * Read are latitude, longitude (degrees, or degrees, minutes, seconds) and height, or ECEF x, y, z; time as
 * date or as week and time of week, in GPST, UTC or JST as the header says; then what follows, in RTKLIB's
 * order: Q, ns, deviations, age, ratio and, if it is there, velocity with its deviations. Baselines (e, n, u)
 * have no place on the Earth and are refused. Separators: blanks, commas, semicolons, tabs. Without a header:
 * degrees, GPST.
 *
 * Q becomes `quality`: 1 fixed, 2 float, 3 sbas, 4 dgnss, 5 single, 6 (PPP) single, which is what is there
 * besides: its deviations say how good it is. Lines with Q 0 or another Q have no solution and are passed
 * over. Heights are ellipsoidal; a header that says WGS84/geodetic sets `msl`.
 *
 * Source: RTKLIB 2.4.3, src/solution.c; manual 2.4.2, appendix B.1. */
#ifndef FURROW_FORMATS_RTKLIB_POS_H
#define FURROW_FORMATS_RTKLIB_POS_H

#include "formats/log_records.h"
#include "formats/rinex.h"

/* A .pos file, by the first lines of its header. */
bool fw_rtklib_pos_detect(const uint8_t *bytes, size_t n);

/* About 270 KiB, owned by the caller; must not be moved once begun. */
typedef struct {
	/* Public to read. */
	fw_rinex_problem problem; /* why the last fw_rtklib_pos_read() failed */
	uint64_t rows;            /* solutions read */
	uint64_t lost;            /* lines refused */
	uint64_t none;            /* lines without a solution */
	bool msl;                 /* heights are above the geoid */

	/* Private from here. */
	fw_lines lines;
	fw_status final;
	uint64_t overlong;
	bool xyz, dms, baseline;
	fw_rinex_time scale; /* GPST or UTC */
	bool jst;
	fw_log_queue queue;
} fw_rtklib_pos;

/* Begin to read.
 *   input  in  open, nothing read; read to its end, the caller closes it */
void fw_rtklib_pos_begin(fw_rtklib_pos *r, fw_input *input);

/* The next record.
 * Returns
 *   FW_OK        a record
 *   FW_ESYNTAX   a line is lost: r->problem says why; call again
 *   FW_EOF       the end
 *   FW_EUNKNOWN  a file of baselines (r->problem); final
 *   FW_ETRUNCATED, FW_EIO, FW_EFORMAT, FW_ENOMEM   from fw_input_read(); final
 * kind and record are set with FW_OK only. */
fw_status fw_rtklib_pos_read(fw_rtklib_pos *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

#endif
