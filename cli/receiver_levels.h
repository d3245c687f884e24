/* Protection levels that the receiver computed itself: of each epoch its position (pvt or pvt_ecef: mode and error) and its
 * levels (dop), put together. Receivers fill in no levels where they have none.
 *
 * This is one place that levels can come from. Others belong beside it, in files of their own that hand on level_epochs
 * as this one does. */
#ifndef FURROW_CLI_RECEIVER_LEVELS_H
#define FURROW_CLI_RECEIVER_LEVELS_H

#include "formats/record.h"
#include "integrity/state_machine.h"

/* What is known of an epoch, wherever it comes from. */
typedef struct {
	fw_time time;
	fw_integrity_epoch seen;
	int n_sats; /* satellites used; -1: not known */
} level_epoch;

typedef struct {
	void (*ready)(void *context, const level_epoch *epoch); /* called with each epoch that is complete */
	void *context;
	int64_t patience_ns;
	bool waiting; /* a position is there, its levels are not: for reading */

	/* Private from here. */
	fw_kind position; /* pvt or pvt_ecef, whichever came first */
	level_epoch epoch;
	bool flat; /* its height was held, so that no level bounds it */
	bool has_levels;
	fw_time levels_time;
	double hpl_m, vpl_m;
} receiver_levels;

/* Adds the types that are needed. */
void receiver_levels_kinds(fw_kind_set *set);

/* Begins.
 *   patience_ns  in  a position whose levels have not come when the log is so far on is taken without */
void receiver_levels_begin(receiver_levels *l, int64_t patience_ns,
                           void (*ready)(void *context, const level_epoch *epoch), void *context);

/* To be called before a record of any type is passed on: hands on the epoch that waits if this record shows that
 * nothing more will come of it. */
void receiver_levels_before(receiver_levels *l, fw_kind kind, const void *record);

/* To be called after it: takes what it says of an epoch, and hands that on when it is all there. */
void receiver_levels_put(receiver_levels *l, fw_kind kind, const void *record);

/* There are no more records. */
void receiver_levels_flush(receiver_levels *l);

#endif
