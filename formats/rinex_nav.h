/* RINEX navigation files, 2.10 to 4.02, as a stream of records with source "rinex".
 *
 *   eph_gps    GPS and QZSS LNAV            eph_glo   GLONASS FDMA
 *   eph_gal    Galileo I/NAV and F/NAV      eph_sbas  SBAS
 *   eph_bds    BeiDou D1 and D2
 *   klobuchar  GPS, QZSS, BeiDou            nequick   Galileo
 *   utc        GPS, QZSS, Galileo, BeiDou
 *
 * A record's stamp is the message's time of transmission where the file has one within a day of the clock's
 * reference time, else that reference time. What stands in a header has no time: it comes before the first
 * ephemeris, with its stamp, and its `sat` is the one that the header names or, mostly, the system's letter
 * alone ("G"). Full weeks of toe are those next to toc, whatever the file's week says (week roll-over, BeiDou
 * weeks counted as GPS weeks). Accuracies in metres become the index that stands for them. A Galileo message
 * is F/NAV if its clock is that of E5a and E1 (data source bit 8), I/NAV if not, and only the health of that
 * message's own signals is taken. Other messages (CNAV and its kin, NavIC, EOP) are passed over and counted.
 *
 * An entry that is damaged or cut short is lost as a whole, and costs no other. */
#ifndef FURROW_FORMATS_RINEX_NAV_H
#define FURROW_FORMATS_RINEX_NAV_H

#include "formats/record.h"
#include "formats/rinex.h"

enum {
	FW_RINEX_PENDING = 160, /* sets of parameters that a header can have; further ones are passed over */
	FW_RINEX_FIELDS = 43    /* numbers of an entry: 3 on the first line, 4 on each of the others */
};

/* A set of parameters that a header gives. */
typedef struct {
	char satellite[5]; /* "G", or the one that sent it */
	fw_kind kind;      /* FW_klobuchar, FW_nequick or FW_utc */
	uint64_t line;     /* of the first of them */
	double value[8];   /* alpha and beta; ai0 to ai2; a0, a1, t, week */
} fw_rinex_parameters;

/* An entry's numbers, as they stand. */
typedef struct {
	uint64_t line; /* of its first */
	int n_lines;
	int64_t have; /* bit i: value[i] is there */
	double value[FW_RINEX_FIELDS];
	fw_time time; /* of its first line, in GPST */
} fw_rinex_entry;

/* The reader, about 300 KiB; owned by the caller; must not be moved once begun. */
typedef struct {
	/* Public to read. */
	fw_rinex_problem problem; /* why the last fw_rinex_nav_read() failed */
	int version;              /* times 100 */
	uint64_t entries;         /* records handed out */
	uint64_t lost;            /* entries and header lines lost */
	uint64_t passed_over;     /* entries of messages that furrow has no record for */

	/* Private from here. */
	fw_lines lines;
	bool held; /* `line` is still to be looked at */
	fw_line line;
	fw_status final; /* FW_OK until nothing more will come */
	bool has_header, searching;
	char system;                 /* of a version 2 file */
	int leap[4];                 /* LEAP SECONDS: now, later, week and day; -1: not said */
	int n_pending, next_pending; /* of the header: they come before `waiting` */
	fw_rinex_parameters pending[FW_RINEX_PENDING];
	bool has_waiting;
	fw_kind waiting_kind;
	fw_any_record waiting;
	fw_rinex_entry entry;
	char satellite[5], parameters_of[5]; /* strings of the records */
} fw_rinex_nav;

/* Begin to read a file.
 *   input  in  open, nothing read; read to its end, the caller closes it */
void fw_rinex_nav_begin(fw_rinex_nav *r, fw_input *input);

/* The next record. Strings, status values and conditions as fw_rinex_obs_read(). */
fw_status fw_rinex_nav_read(fw_rinex_nav *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

#endif
