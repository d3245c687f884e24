/* The integrity state of a navigation: from each epoch's protection levels to one of four states, with hysteresis and a
 * time to alert, and a record of every change.
 *
 * An epoch by itself stands for
 *   RELIABLE     position with SBAS, HPL <= HAL and VPL <= VAL
 *   NO_SBAS      position without SBAS, or with SBAS but without protection levels: nothing bounds its error
 *   UNRELIABLE   position with SBAS, a protection level above its alert limit: not to be used
 *   NO_POSITION  no position
 * in the order from good to bad. The machine follows to worse states at once, or after the time to alert; to better ones
 * when all epochs have been better for the hold time. */
#ifndef FURROW_INTEGRITY_STATE_MACHINE_H
#define FURROW_INTEGRITY_STATE_MACHINE_H

#include <stdbool.h>

#include "base/status.h"
#include "base/time.h"

typedef enum {
	FW_INTEGRITY_UNKNOWN,
	FW_RELIABLE,
	FW_NO_SBAS,
	FW_UNRELIABLE,
	FW_NO_POSITION
} fw_integrity_state;

/* Why a state is entered, and none that is better. */
typedef enum {
	FW_CAUSE_WITHIN_LIMITS, /* RELIABLE: both levels are within their limits */
	FW_CAUSE_NO_SBAS,       /* NO_SBAS: the receiver did not use SBAS */
	FW_CAUSE_NO_LEVELS,     /* NO_SBAS: SBAS, but a level is missing or is no positive number */
	FW_CAUSE_MARGIN,        /* levels within the limits, but not by the margin that a return asks for */
	FW_CAUSE_HPL,           /* UNRELIABLE: HPL above HAL */
	FW_CAUSE_VPL,           /* UNRELIABLE: VPL above VAL */
	FW_CAUSE_HPL_VPL,       /* UNRELIABLE: both */
	FW_CAUSE_NO_POSITION,   /* NO_POSITION: the epoch has none */
	FW_CAUSE_TIMEOUT        /* NO_POSITION: no epoch came */
} fw_integrity_cause;

/* The words for them: "RELIABLE", "within-limits". Never NULL; "" for a value that is none. */
const char *fw_integrity_state_name(fw_integrity_state state);
const char *fw_integrity_cause_name(fw_integrity_cause cause);

typedef struct {
	double hal_m, val_m; /* alert limits, > 0; INFINITY: none */
	double margin;       /* a return to RELIABLE needs PL <= (1 - margin) AL; 0..1, 1 excluded */
	int64_t hold_ns;     /* how long all epochs must be better before a better state is entered; >= 0 */
	/* Time to alert: how long SBAS or levels may be missing or too large before a worse state is entered; >= 0.
	 * Without a position the state is NO_POSITION at once. */
	int64_t alert_ns;
	int64_t timeout_ns; /* NO_POSITION when no epoch has come for longer; > 0 */
} fw_integrity_rules;

/* What an epoch has. */
typedef struct {
	bool position;
	bool sbas;           /* the position was computed with SBAS corrections and integrity */
	double hpl_m, vpl_m; /* NaN: not available */
} fw_integrity_epoch;

/* A change of state; from == to: none. */
typedef struct {
	fw_time time;
	fw_integrity_state from, to;
	fw_integrity_cause cause;
} fw_transition;

/* Owned by the caller. `state` is for reading, the rest is private. */
typedef struct {
	fw_integrity_state state;
	fw_integrity_rules rules;
	bool begun;                     /* there was an epoch since the beginning or restart */
	fw_time last, changed;          /* latest epoch, latest transition */
	int trend;                      /* epochs have been better (-1) or worse (1) than the state ... */
	fw_time since;                  /* ... since this one */
	fw_integrity_state seen, worst; /* what the latest epoch stands for; the worst since then */
	fw_integrity_cause seen_cause, worst_cause;
} fw_integrity;

/* Begins in NO_POSITION.
 * Returns FW_OK; FW_EINVAL (a rule outside its range, NaN): *m untouched. */
fw_status fw_integrity_init(const fw_integrity_rules *rules, fw_integrity *m) FW_MUST_CHECK;

/* What falls due before `now` although no epoch came: the end of the time to alert, or the timeout, each at its own
 * time. To be called until it returns false, before each epoch is put and whenever it is known that time went by.
 *   transition  out  untouched when the result is false */
bool fw_integrity_expire(fw_integrity *m, fw_time now, fw_transition *transition);

/* Takes an epoch. The very first one decides the state at once.
 *   transition  out  from == to if the state stays
 * Returns FW_OK; FW_EINVAL (not after the epoch before, or before the latest transition): nothing has changed. */
fw_status fw_integrity_update(fw_integrity *m, fw_time time, const fw_integrity_epoch *epoch,
                              fw_transition *transition) FW_MUST_CHECK;

/* Forgets when the last epoch was, but not the state: the next epoch may be of any time, and decides at once. */
void fw_integrity_restart(fw_integrity *m);

#endif
