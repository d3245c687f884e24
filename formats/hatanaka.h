/* Compact RINEX (Hatanaka) 1.0, 3.0 and 3.1: the lines of a compressed observation file back to RINEX lines.
 *
 * A filter between fw_lines and a reader: it takes lines as they are stored and gives out those of the RINEX
 * file, header included, character by character as CRX2RNX writes them, blanks at the ends of lines aside.
 *
 * Every number is a sum of differences, so what is damaged damages what follows: behind an error everything
 * is passed over up to the next epoch that begins anew, as the format has it. What is then lost is one loss.
 * A last line without a line break counts as cut short: a number that is not whole is another number.
 *
 * Source: Y. Hatanaka, "A compression format and tools for GNSS observation data", Bulletin of the
 * Geographical Survey Institute 55 (2008); RNXCMP 4.1. */
#ifndef FURROW_FORMATS_HATANAKA_H
#define FURROW_FORMATS_HATANAKA_H

#include <stdbool.h>
#include <stdint.h>

#include "formats/rinex.h"

enum {
	FW_HATANAKA_ORDER = 5,        /* highest order of differences; RNXCMP: 5 */
	FW_HATANAKA_TYPES = 128,      /* observables per system; RNXCMP: 100 */
	FW_HATANAKA_SATELLITES = 160, /* of an epoch; RNXCMP: 100 */
	FW_HATANAKA_SLOTS = 27 * 100  /* satellites by letter and number */
};

/* A number that is sent as differences. Level k holds the k-th difference, level 0 the number itself. */
typedef struct {
	int8_t order; /* the next token is for level order + 1, at most arc_order; -1: no arc */
	int8_t arc_order;
	uint64_t level[FW_HATANAKA_ORDER + 1]; /* two's complement: sums may wrap around */
} fw_hatanaka_arc;

/* What is kept of a satellite. */
typedef struct {
	fw_hatanaka_arc arcs[FW_HATANAKA_TYPES];
	char flags[2 * FW_HATANAKA_TYPES]; /* loss of lock and signal strength of each observable */
} fw_hatanaka_satellite;

/* The filter: some 20 MB, of which each satellite that occurs touches 8 kB. Let it be static. */
typedef struct {
	fw_rinex_problem problem; /* behind the last FW_ESYNTAX or FW_EUNKNOWN */

	/* Private from here. */
	fw_lines *lines;
	int version; /* 1 or 3; 0: nothing read so far */
	bool in_header, held, lost;
	int verbatim;    /* lines of an event still to be handed on */
	fw_line line;    /* read but not used, if held */
	int n_types[27]; /* by letter; 0 is RINEX 2's one list */
	char epoch[64 + 3 * FW_HATANAKA_SATELLITES];
	size_t epoch_n;
	fw_hatanaka_arc clock;
	char clock_text[24]; /* of this epoch; "" none */
	int n_satellites;    /* of the epoch at hand */
	int next_satellite;  /* whose line comes; -1: the epoch's own */
	int part;            /* RINEX 2: of an epoch line or a satellite, the next line of several */
	uint64_t epochs;
	uint64_t seen[FW_HATANAKA_SLOTS]; /* the epoch in which each satellite was last */
	char out[FW_HATANAKA_TYPES * 16 + 64];
	fw_hatanaka_satellite satellites[FW_HATANAKA_SLOTS];
} fw_hatanaka;

/* Begin to decompress.
 *   lines  in  at the beginning of the file; its owner keeps it in place */
void fw_hatanaka_begin(fw_hatanaka *h, fw_lines *lines);

/* The next line of the RINEX file; it lives until the call after it, and its number is that of the compressed
 * line. Returns FW_OK; FW_ESYNTAX: something is lost, h->problem says where and why, call again; FW_EUNKNOWN:
 * no Compact RINEX that furrow can read (h->problem), final; all others as fw_lines_next(), final. */
fw_status fw_hatanaka_next(fw_hatanaka *h, fw_line *line) FW_MUST_CHECK;

#endif
