/* Records of observations to epochs: the rows of one receiver time tag, together as the solvers take them. */
#ifndef FURROW_CLI_EPOCHS_H
#define FURROW_CLI_EPOCHS_H

#include "formats/record.h"
#include "gnss/observation.h"

typedef struct {
	void (*ready)(void *context, const fw_epoch *epoch); /* called with each epoch that is complete */
	void *context;
	uint64_t refused;    /* rows without time, satellite or signal */
	uint64_t overflowed; /* rows beyond FW_EPOCH_MAX of an epoch */

	/* Private from here. */
	fw_epoch epoch;
	int32_t gps_week; /* the stamp of the last row */
	double tow_s;
	uint16_t
	    after[FW_SATELLITE_COUNT]; /* where the next row of a satellite belongs; 0: it has none yet */
	char last_name[8];             /* the satellite of the last row, since rows come by satellite */
	fw_satellite last;
} epochs;

/* An observation as the solvers take it. Returns FW_EINVAL when satellite or signal are none; *o untouched. */
fw_status observation_of_record(const void *record, fw_observation *o) FW_MUST_CHECK;

/* Epochs of the main antenna go to ready(). */
void epochs_begin(epochs *e, void (*ready)(void *context, const fw_epoch *epoch), void *context);

/* Takes obs records; all others are passed over. An epoch is complete when the time tag changes. A sink's put; `e` is an
 * epochs. */
void epochs_put(void *e, fw_kind kind, const void *record);

/* There are no more rows of the present epoch. */
void epochs_flush(epochs *e);

#endif
