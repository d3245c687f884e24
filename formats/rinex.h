/* What RINEX files of all kinds have in common: which kind a file is, its lines, their labels and fixed
 * columns.
 *
 * Source: RINEX 2.11 (2007), 3.05 (2020), 4.02 (2024), IGS/RTCM SC-104. Columns are counted from 0 here. */
#ifndef FURROW_FORMATS_RINEX_H
#define FURROW_FORMATS_RINEX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/time.h"
#include "formats/input.h"

typedef enum {
	FW_RINEX_NONE,        /* not RINEX */
	FW_RINEX_OBSERVATION, /* read it with formats/rinex_obs.h, Compact RINEX included */
	FW_RINEX_NAVIGATION,  /* formats/rinex_nav.h */
	FW_RINEX_OTHER        /* clocks, meteorological data, a version that furrow does not know */
} fw_rinex_kind;

/* The kind of a file by its first bytes; 300 are enough. */
fw_rinex_kind fw_rinex_detect(const uint8_t *bytes, size_t n);

enum {
	FW_RINEX_LINE_MAX = 16 * 1024, /* longest line [bytes]: 999 observables and the satellite */
	FW_RINEX_BUFFER = 256 * 1024,
	FW_RINEX_LABEL = 60 /* column of a header line's label */
};

/* One line. */
typedef struct {
	const char *text;
	size_t n;        /* without the line break (LF or CR LF) */
	uint64_t number; /* from 1 */
	bool whole;      /* false: the file ends in it, without a line break */
} fw_line;

/* Lines of an input, about 270 KiB, owned by the caller; must not be moved once begun. */
typedef struct {
	uint64_t number;   /* of the line handed out last */
	uint64_t overlong; /* lines that were longer than FW_RINEX_LINE_MAX: passed over */

	/* Private from here. */
	fw_input *input;
	fw_status input_status; /* FW_OK until the input ends or fails */
	size_t pos, end;        /* what is there */
	size_t looked_at;       /* no line ends before here */
	bool inside;            /* an overlong line whose beginning is gone */
	char buffer[FW_RINEX_BUFFER + 64];
} fw_lines;

void fw_lines_begin(fw_lines *l, fw_input *input);

/* The next line; it lives until the call after it.
 * Returns FW_OK; FW_EOF, FW_ETRUNCATED, FW_EIO, FW_EFORMAT, FW_ENOMEM as fw_input_read(), all final. An
 * overlong line is handed out with n = 0, and counted. */
fw_status fw_lines_next(fw_lines *l, fw_line *line) FW_MUST_CHECK;

/* The label of a header line, "" when it has none, blanks at its end dropped, in 21 bytes with NUL. */
void fw_rinex_label(const fw_line *line, char label[static 21]);

/* Text of a line, columns from .. from + n - 1, blanks at both ends dropped, control characters as '?'.
 *   room  in  bytes at `text`, NUL included; what does not fit is dropped */
void fw_rinex_text(const fw_line *line, size_t from, size_t n, char *text, size_t room);

/* Numbers of fixed columns: blanks at both ends are dropped, 'D' and 'd' stand for 'e'.
 * Returns FW_OK; FW_EOF: all blank, or behind the end of the line; FW_ESYNTAX or FW_ERANGE: no number. *x
 * untouched unless FW_OK. */
fw_status fw_rinex_double(const fw_line *line, size_t from, size_t n, double *x) FW_MUST_CHECK;
fw_status fw_rinex_int(const fw_line *line, size_t from, size_t n, int *x) FW_MUST_CHECK;

/* Seconds as they stand in epochs ("17.0000000") to ns. Returns as above, FW_ERANGE outside 0 <= s < 61. */
fw_status fw_rinex_seconds(const fw_line *line, size_t from, size_t n, int64_t *ns) FW_MUST_CHECK;

/* Time systems of RINEX. */
typedef enum {
	FW_RINEX_GPS,
	FW_RINEX_GLO,
	FW_RINEX_GAL,
	FW_RINEX_BDT,
	FW_RINEX_QZS,
	FW_RINEX_IRN,
	FW_RINEX_UTC
} fw_rinex_time;

/* "GPS", "GLO", ... to a time system. Returns FW_EUNKNOWN for any other text, *system untouched. */
fw_status fw_rinex_time_system(const char *name, fw_rinex_time *system) FW_MUST_CHECK;

/* Calendar date and time of a time system to a moment. civil->year may have two digits (80..99: 19xx). second
 * may be 60: of UTC a leap second, of the others the full minute as some writers round it. Returns FW_OK or
 * FW_DUBIOUS (UTC past the leap second table's expiry), FW_EINVAL or FW_ERANGE. */
fw_status fw_rinex_moment(const fw_civil *civil, fw_rinex_time system, fw_time *t) FW_MUST_CHECK;

/* The name of a satellite as furrow writes it ("G05", "S123"), to constant storage, from its RINEX letter and
 * number (of SBAS: PRN - 100); NULL when there is no such satellite. */
const char *fw_rinex_satellite(char letter, int number);

/* What was wrong, for a message "FILE:line: REASON". */
typedef struct {
	uint64_t line;
	const char *reason; /* a few words of English */
} fw_rinex_problem;

#endif
