/* The clock of an autopilot, microseconds since it was switched on, to GPS time.
 *
 * The log pairs the two each time a position fix arrives: the fix has its GPS time, its message the time
 * since boot, later by the receiver's latency, which is never less than some least value but often more. So
 * the offset (GPS time minus time since boot) that a pair gives is too small by the latency, and the largest
 * are the best. The offset is taken as the lowest line above all pairs that nowhere departs by more than 50
 * ppm from a straight drift; what is left is the least latency itself, which no log can tell: the caller adds
 * it (ArduPilot and PX4 assume 0.11 to 0.22 s).
 *
 * Used in two ways:
 *   when the log can be read twice, once to learn and once to read: add every pair, fw_boot_clock_learn(),
 *   then convert; when it cannot (a pipe): add and convert in turn. Then the offset is that of the best pairs
 *   so far, what comes before the first pair has no time, and time stamps jump when a better pair comes, most
 *   of all in the first seconds.
 *
 * A pair that is off by more than a second is passed over; when five in a row agree with each other, they are
 * right and all before them were wrong (a receiver that had not heard of the leap seconds yet). */
#ifndef FURROW_FORMATS_BOOT_CLOCK_H
#define FURROW_FORMATS_BOOT_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "base/time.h"

enum { FW_BOOT_KNOTS = 512 };

/* The best pair of a while. */
typedef struct {
	int64_t boot_us;
	double offset_s; /* from the clock's origin */
} fw_boot_knot;

/* Owned by the caller. Public to read: pairs, strays. */
typedef struct {
	uint64_t pairs;  /* taken */
	uint64_t strays; /* passed over */

	/* Private from here. */
	bool learnt;
	int64_t origin_ns; /* offset of the first pair */
	int n;
	int64_t spacing_us; /* of the knots: doubled whenever they are too many */
	int64_t last_us;    /* of the last pair */
	double now_s;       /* offset at the last pair, when used in turn */
	double drift;       /* straight drift [s/s], when learnt */
	int n_agreeing;
	double stray_s;
	fw_boot_knot knots[FW_BOOT_KNOTS];
} fw_boot_clock;

void fw_boot_clock_begin(fw_boot_clock *c);

/* A pair.
 *   boot_us  in  time since boot of the message, 0 .. 2^48 (nine years); others are passed over
 *   gps      in  the GPS time that it says */
void fw_boot_clock_add(fw_boot_clock *c, int64_t boot_us, fw_time gps);

/* All pairs are there: from now on fw_boot_clock_time() knows them all, and no further ones are taken. */
void fw_boot_clock_learn(fw_boot_clock *c);

/* The GPS time of a time since boot.
 *   lag_s  in  least latency of a pair, added to the result
 * Returns FW_OK; FW_MORE: no pair yet; FW_ERANGE: boot_us is none or the result is outside GPS weeks 0..8191,
 * or lag_s is no number. *t untouched
 * unless FW_OK. */
fw_status fw_boot_clock_time(const fw_boot_clock *c, int64_t boot_us, double lag_s, fw_time *t) FW_MUST_CHECK;

#endif
