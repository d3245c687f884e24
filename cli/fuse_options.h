/* The options of insgnss-fuse, in the units of the command line, and what they are to the library, in its own. */
#ifndef FURROW_CLI_FUSE_OPTIONS_H
#define FURROW_CLI_FUSE_OPTIONS_H

#include "fuse_compass.h"
#include "fuse_output.h"
#include "fuse_records.h"
#include "fuse_start.h"
#include "options.h"
#include "source.h"
#include "tool.h"

extern const option fuse_option_table[];
extern const int fuse_option_count;

typedef struct {
	fw_loose_options loose;
	fuse_records_setup records;
	fuse_start_setup start;
	log_plan logs;
	bool lever_given; /* by the user, so that the log's own is not used */
	bool smooth;
	uint64_t memory; /* for smoothing [bytes] */
	fuse_rate rate;
	double misalignment_rad; /* of the IMU's axes, sigma */
	int64_t window_ns;       /* how far records may be out of order */
	fuse_compass_way compass_way;
	fw_mag_calibration compass;
} fuse_config;

/* Turns options into a configuration. Returns EXIT_COMPLETE or, after a message, EXIT_USAGE. *c must not move afterwards. */
int fuse_configure(const options *o, const tool *t, fuse_config *c);

#endif
