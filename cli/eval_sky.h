/* Which satellites a receiver saw, and where they stood. */
#ifndef FURROW_CLI_EVAL_SKY_H
#define FURROW_CLI_EVAL_SKY_H

#include <stdbool.h>

#include "ephemerides.h"
#include "formats/record.h"
#include "gnss/signal.h"

/* A satellite seen at a time. */
typedef struct {
	fw_time t;
	fw_satellite satellite;
	bool placed;
	double position_m[3]; /* ECEF, if placed */
} eval_sighting;

/* Zero it at the start. */
typedef struct {
	eval_sighting *sighting;
	size_t n, room;
	fw_time last[FW_SATELLITE_COUNT]; /* when the satellite was noted last */
	ephemeris_store ephemerides;
} eval_sky;

/* The records that say something of it: observations, ephemerides, satellite positions. */
void eval_sky_kinds(fw_kind_set *kinds);

/* Takes such records; all others are passed over. A sink's put; `sky` is an eval_sky. Of a satellite one sighting is kept
 * for ten seconds, which is enough for a picture. */
void eval_sky_put(void *sky, fw_kind kind, const void *record);

/* After the last record: brings the sightings into order, by satellite, then by time, and finds positions by the
 * ephemerides. Sightings without one are dropped. */
void eval_sky_settle(eval_sky *sky);

/* Gives the memory back. */
void eval_sky_release(eval_sky *sky);

#endif
