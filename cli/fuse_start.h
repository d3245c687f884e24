/* Where a run of the filter begins: everything is kept until the attitude is known, and then the run begins with the first
 * fix that was kept, with the attitude carried back to it by the gyros, so that nothing of the log is lost.
 *
 * Ways to the attitude, best first:
 *   standing still   roll and pitch from gravity; heading from two antennas, from the rotation of the Earth when the gyros
 *                    are that good, from the compass
 *   in motion        all three from the velocities of GNSS (ins/alignment.h); or level by them and heading from two
 *                    antennas, from the course of a vehicle on wheels, from the compass
 *   given            the heading that the user says */
#ifndef FURROW_CLI_FUSE_START_H
#define FURROW_CLI_FUSE_START_H

#include "fuse_order.h"
#include "ins/alignment.h"

typedef enum {
	FUSE_ALIGN_AUTO,
	FUSE_ALIGN_GNSS,
	FUSE_ALIGN_MAGNETIC,
	FUSE_ALIGN_MOTION,
	FUSE_ALIGN_GYROCOMPASS,
	FUSE_ALIGN_GIVEN
} fuse_align;

typedef struct {
	fuse_align way;
	double heading_rad, heading_sd_rad; /* given */
	double limit_rad;                   /* a heading sigma that is good enough */
	fw_align_imu imu;
	double
	    gyro_bias_walk; /* what the bias changes during the run: no bias is known better than that [rad/s] */
	double lever_b[3];
	fw_stillness_setup still;
	double gap_s; /* a gap of the IMU that ends what is known */
	bool wheels;
	bool compass; /* whether it may be used */
	double compass_sd_rad;
	double declination_rad; /* NAN: from the World Magnetic Model */
} fuse_start_setup;

/* How a run begins: what fw_loose_start takes. */
typedef struct {
	fw_pva pva;
	double attitude_sd[3], velocity_sd[3], position_sd[3];
	bool has_gyro_bias;
	double gyro_bias[3], gyro_bias_sd[3];
	const char *way;      /* in a few words */
	unsigned stray_fixes; /* passed over: the next ones are somewhere else */
	double heading_sd_rad;
} fuse_beginning;

enum { FUSE_START_READINGS = 120000, FUSE_START_ITEMS = 32768 };

/* What roll and pitch follow from while the vehicle moves, once its heading is known: the same force, as IMU and GNSS saw it. */
typedef struct {
	bool known;
	fw_time time;
	double force_b[3], force_n[3]; /* means over a second or so [m/s^2] */
} fuse_push;

/* Means of a stretch of standing still up to a moment. A vehicle that begins to move does so slowly: they are believed when
 * it still stands some time later. */
typedef struct {
	bool known;
	fw_time until;
	fw_stillness_means means;
} fuse_rest;

/* Owned by the caller, 14 MiB, of which no more is touched than is kept. */
typedef struct {
	fuse_start_setup setup;
	fw_stillness stillness;
	fw_align_motion motion;
	fw_time last;      /* of the readings */
	double interval_s; /* usual; 0: not known yet */

	/* Rings; when one is full the oldest goes. Numbers count on; number modulo size is the place. */
	uint64_t first_reading, end_reading; /* kept are first <= number < end */
	uint64_t first_item, end_item;
	uint64_t motion_reading; /* the next one for the alignment in motion */
	fw_imu_reading reading[FUSE_START_READINGS];
	fw_item item[FUSE_START_ITEMS];

	/* What came last. */
	bool has_fix, has_heading, has_field;
	fw_item fix, heading, field;
	fw_time tried;   /* when it was tried last */
	double moving_s; /* how long the vehicle has been moving */
	fuse_rest young,
	    standing; /* of this stretch of standing still: the newest, and one that is old enough to be believed */
	fuse_rest rest; /* of the longest stretch */
	bool has_push_from;
	fw_item push_from; /* the fix at the begin of the push under way */
	double push_sum[3], push_n;
	fuse_push push;

	uint64_t refused[FW_REFUSED_COUNT]; /* readings */
	uint64_t lost;                      /* entries that went because a ring was full */
} fuse_start;

/* Begins anew, with nothing kept. Returns FW_OK or FW_EINVAL (a sigma). */
fw_status fuse_start_begin(fuse_start *s, const fuse_start_setup *setup) FW_MUST_CHECK;

/* Is a reading so late that what is kept cannot be joined to it? Then it is time for a last try, and to begin anew. */
bool fuse_start_breaks(const fuse_start *s, const fuse_entry *e);

/* Keeps an entry; in order of time. Returns true when it is worth a try. */
bool fuse_start_put(fuse_start *s, const fuse_entry *e);

/* Is the attitude known? `last`: no better chance will come.
 * Returns FW_OK; FW_MORE: not yet; *b untouched. */
fw_status fuse_start_try(fuse_start *s, bool last, fuse_beginning *b) FW_MUST_CHECK;

/* What keeps it from beginning, in a few words. */
const char *fuse_start_lacks(const fuse_start *s);

/* Hands out what was kept, in order of time, and keeps it no longer: items from before the beginning to `early`, readings and
 * items after it to `take`. */
void fuse_start_replay(fuse_start *s, fw_time begin, void (*early)(void *context, const fuse_entry *e),
                       void (*take)(void *context, const fuse_entry *e), void *context);

#endif
