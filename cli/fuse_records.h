/* From records to what the filter takes: IMU samples, fixes, headings, fields, heights, protection levels, events. */
#ifndef FURROW_CLI_FUSE_RECORDS_H
#define FURROW_CLI_FUSE_RECORDS_H

#include "formats/record.h"
#include "fuse_order.h"

/* Which records positions are taken from. */
typedef enum { FUSE_FIXES_AUTO, FUSE_FIXES_PVT, FUSE_FIXES_POS, FUSE_FIXES_NAV } fuse_fixes;

typedef struct {
	/* how the IMU is mounted: x_body = C_b_s x_sensor; magnetometers are taken to be turned like it */
	double C_b_s[3][3];
	int64_t imu_offset_ns; /* added to the times of IMU samples */

	fuse_fixes fixes;
	bool use_velocity;
	double float_floor_m;       /* least sigma of a position with ambiguities that are not fixed */
	double antenna_heading_rad; /* of the antennas' baseline in the body: body = measured - this */
	double heading_floor_rad;   /* least sigma of such a heading that is believed */

	const fw_mag_calibration *compass; /* NULL: readings are taken as they are */

	/* Fixes and headings are left out in windows: every_ns > 0, length_ns long, the first one first_ns after the first fix. */
	int64_t withhold_every_ns, withhold_length_ns, withhold_first_ns;
} fuse_records_setup;

typedef struct {
	fuse_records_setup setup;
	bool has_kind; /* the type of record that positions come from is settled */
	fw_kind kind;
	double clock_bias_s; /* the receiver's, as it said last */
	double unit_ut;      /* what a normalised magnetic field is multiplied by; 0: not known yet */
	double llh[3];       /* of the last fix */
	bool has_first_fix;
	fw_time first_fix;
	bool has_lever;    /* the log says where the antenna is, from the IMU */
	double lever_b[3]; /* [m] */
	uint64_t imu, fixes, headings, fields, heights, levels, events; /* entries made */
	uint64_t no_fix;        /* epochs of which the receiver says that it has no position */
	uint64_t other_fixes;   /* positions of types that are not used */
	fw_kind other_kind;     /* the first of these */
	uint64_t without_sigma; /* fixes whose sigma had to be assumed */
	uint64_t withheld;
} fuse_records;

void fuse_records_begin(fuse_records *r, const fuse_records_setup *setup);

/* The types of records that are looked at. */
void fuse_records_kinds(fw_kind_set *set);

/* What a record is to the filter. Returns false if it is nothing: *e is then undefined. Missing numbers of IMU samples,
 * magnetometers and of fixes that a receiver says it has become NaN, for the filter to refuse and count. */
bool fuse_records_take(fuse_records *r, fw_kind kind, const void *record, fw_time t, fuse_entry *e);

#endif
