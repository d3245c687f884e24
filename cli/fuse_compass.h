/* Calibrating the magnetometer from the log that it is used on: the log is read once for this before it is read for good. */
#ifndef FURROW_CLI_FUSE_COMPASS_H
#define FURROW_CLI_FUSE_COMPASS_H

#include <stddef.h>

#include "fusion/loose.h"
#include "ins/magnetometer.h"

typedef enum {
	FUSE_COMPASS_AS_IT_IS,
	FUSE_COMPASS_GIVEN,   /* by the user: three numbers of the offset, nine of the matrix */
	FUSE_COMPASS_TURNING, /* the ellipsoid on which the readings lie before the vehicle goes off */
	FUSE_COMPASS_LOG      /* the attitudes of a first run, without the magnetometer */
} fuse_compass_way;

/* Reads "none", "turning", "log" or twelve numbers with commas. Returns false if it is none of these: outputs untouched. */
bool fuse_compass_parse(const char *text, fuse_compass_way *way, fw_mag_calibration *cal);

/* The twelve numbers, as fuse_compass_parse takes them. */
void fuse_compass_print(const fw_mag_calibration *cal, char *text, size_t room);

/* What a first reading of the log finds out. */
typedef struct {
	double declination_rad; /* NAN: from the World Magnetic Model */
	bool has_field;
	double field_ned_nt[3]; /* the Earth's, at the first attitude */
	bool gone;              /* the vehicle has gone off */
	bool waiting;           /* for the attitude of its time */
	fw_item reading;
	fw_mag_turning turning;
	fw_mag_referenced referenced;
} fuse_compass;

void fuse_compass_begin(fuse_compass *c, double declination_rad);

/* What comes in: readings of the magnetometer and fixes; and the filter at an IMU sample. */
void fuse_compass_item(fuse_compass *c, const fw_item *item);
void fuse_compass_attitude(fuse_compass *c, const fw_loose *l);

/* The calibration. Returns FW_OK; FW_DUBIOUS (done, good near level only); FW_MORE (no attitude, or too few readings);
 * FW_ESINGULAR (the motion shows too little): *cal untouched. */
fw_status fuse_compass_solve(const fuse_compass *c, fuse_compass_way way,
                             fw_mag_calibration *cal) FW_MUST_CHECK;

#endif
