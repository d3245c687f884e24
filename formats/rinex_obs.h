/* RINEX observation files, 2.10 to 4.02, plain or Compact (Hatanaka), as a stream of records.
 *
 *   setup   once per header: marker, receiver, antenna, position; stamped with the first epoch behind it
 *   obs     one per satellite and signal, as from SBF; columns that RINEX does not have are absent. lock_s is
 *           0 where the loss-of-lock bit is set or the receiver had lost power (event flag 1), and absent
 *           elsewhere; half_cycle is bit 1 of the loss-of-lock indicator
 *   epoch   one per epoch, behind its obs: n_signals
 *   event   one per external event (event flag 5)
 *
 * Observation codes of RINEX 2 become signals of RINEX 3:
 *   C1 1C, P1 1W (GLONASS 1P), C2 2X (GLONASS 2C, BeiDou 2I), P2 2W (GLONASS 2P), C5 5X, C6 6X, C7 7X, C8 8X
 *   (BeiDou 6I, 7I, SBAS 5I; Galileo 1X); L, D and S belong to C on band 1 if the file has C1, and else to P
 *   where there is one.
 * In 3.02 BeiDou's B1I is called 1I: here it is 2I, as in all other versions.
 * A value of 0 is a missing one. SYS / SCALE FACTOR is applied. Times of any system become GPST.
 *
 * Nothing is believed: counts are held against the lines that are there. A damaged line costs its satellite,
 * a damaged epoch line its epoch; reading goes on with the next epoch line. */
#ifndef FURROW_FORMATS_RINEX_OBS_H
#define FURROW_FORMATS_RINEX_OBS_H

#include <stdbool.h>

#include "formats/hatanaka.h"
#include "formats/record.h"
#include "formats/rinex.h"
#include "gnss/signal.h"

enum {
	FW_RINEX_TYPES = 128,     /* observables per system; a file's further ones are passed over */
	FW_RINEX_SATELLITES = 999 /* of an epoch: three digits */
};

/* The facts of the header in force. Strings end in NUL, "" when missing. */
typedef struct {
	int version; /* times 100: 211, 304 */
	char system; /* of the file: G R E C J I S, M mixed */
	fw_rinex_time time_system;
	double interval_s; /* 0: not said */
	bool has_position;
	double position_m[3];    /* approximate position of the marker, ECEF */
	double antenna_hen_m[3]; /* antenna reference point over, east of, north of the marker */
	int leap_s;              /* GPST - UTC; -1: not said */
	bool clock_applied; /* the receiver's clock offset is already taken off code, carrier and epoch */
	int phase_shifts; /* SYS / PHASE SHIFT lines with a shift that is not 0; carriers stay as they are */
	char marker_name[61], marker_number[21], marker_type[21], observer[21], agency[41];
	char rx_serial[21], rx_name[21], rx_version[21], ant_serial[21], ant_type[21];
	int8_t glonass_channel[FW_SATELLITES_PER_SYSTEM]; /* by slot; INT8_MIN: not said */
} fw_rinex_header;

/* Where the observables of a signal stand. */
typedef struct {
	char name[3];     /* "1C" */
	int16_t index[4]; /* code, carrier, Doppler, C/N0: which of the system's observables; -1: none */
} fw_rinex_signal;

/* The reader, owned by the caller; must not be moved once begun. Large because of Compact RINEX (see
 * hatanaka.h). */
typedef struct {
	/* Public to read. */
	fw_rinex_header header;
	fw_rinex_problem problem; /* why the last fw_rinex_obs_read() failed */
	uint64_t epochs;          /* epoch records handed out */
	uint64_t lost;            /* satellites' lines, epochs and header lines lost */
	uint64_t passed_over;     /* observables in header lists that make no column */

	/* To be set after the beginning, before the first reading: carrier phases are not wanted, nor looked at. */
	bool no_carriers;

	/* Private from here. */
	fw_lines lines;
	bool is_compact;
	bool held; /* `line` is still to be looked at */
	fw_line line;
	fw_status final; /* FW_OK until nothing more will come */
	bool has_header, setup_due;
	bool searching;         /* for an epoch line, because of a loss that was counted */
	int list_of, list_left; /* the list of observables that goes on: its system, how many are to come */
	int n_types[FW_SYSTEM_COUNT]; /* version 2: the same list for all */
	char types[FW_SYSTEM_COUNT][FW_RINEX_TYPES][4];
	double scale[FW_SYSTEM_COUNT][FW_RINEX_TYPES];
	bool half_wavelength[2]; /* WAVELENGTH FACT L1/2 */
	int n_signals[FW_SYSTEM_COUNT];
	fw_rinex_signal signals[FW_SYSTEM_COUNT][FW_RINEX_TYPES];

	bool in_epoch, power_failed, cycle_slips;
	int n_satellites, next_satellite;
	char list[FW_RINEX_SATELLITES][3]; /* version 2: the epoch's satellites */
	fw_record_head stamp;
	int n_measured; /* signals of the epoch so far */

	const char *satellite; /* whose signals are being handed out; NULL: none */
	fw_system system;
	int number, next_signal;
	double values[FW_RINEX_TYPES]; /* 0: missing */
	uint8_t lli[FW_RINEX_TYPES];
	fw_hatanaka compact;
} fw_rinex_obs;

/* Begin to read a file.
 *   input  in  open, nothing read; read to its end, the caller closes it */
void fw_rinex_obs_begin(fw_rinex_obs *r, fw_input *input);

/* The next record.
 *   kind    out  FW_setup, FW_obs, FW_epoch or FW_event
 *   record  out  its strings point into the reader, until the next call
 * Returns
 *   FW_OK          a record
 *   FW_ESYNTAX     something is lost: r->problem says where and why; call again
 *   FW_EOF         the end
 *   FW_ETRUNCATED  the end, inside a header, an epoch or a gzip file
 *   FW_EUNKNOWN    no header that furrow can make anything of: r->problem
 *   FW_EIO, FW_EFORMAT, FW_ENOMEM   from fw_input_read()
 * All but the first two are final. kind and record are set with FW_OK only. */
fw_status fw_rinex_obs_read(fw_rinex_obs *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

#endif
