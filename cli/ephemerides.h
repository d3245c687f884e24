/* Ephemerides as the solvers take them, from records, and a store that gives the best one for a satellite and a time. */
#ifndef FURROW_CLI_EPHEMERIDES_H
#define FURROW_CLI_EPHEMERIDES_H

#include "formats/record.h"
#include "gnss/atmosphere.h"
#include "gnss/ephemeris.h"
#include "gnss/range_model.h"
#include "gnss/single_point.h"

/* An eph_gps, eph_gal, eph_bds, eph_glo or eph_sbas record as an ephemeris. Weeks cut short are completed near the
 * record's stamp; without a week the reference time nearest to the stamp is meant.
 * Returns FW_OK; FW_EINVAL (another type of record, or one that lacks a column that is needed); FW_ERANGE (no time).
 * *e untouched on failure. */
fw_status ephemeris_of_record(fw_kind kind, const void *record, fw_ephemeris *e) FW_MUST_CHECK;

/* The coefficients of a klobuchar record. Returns FW_EINVAL when one is missing; *k untouched. */
fw_status klobuchar_of_record(const void *record, fw_klobuchar *k) FW_MUST_CHECK;

/* The ephemerides of one satellite and message, by reference time. */
typedef struct {
	fw_ephemeris *list;
	unsigned n, room;
	unsigned last; /* found last: the next one wanted is near it */
} ephemeris_list;

enum {
	EPHEMERIS_MESSAGES = 2,     /* Galileo: I/NAV and F/NAV; the others have one */
	EPHEMERIDES_PER_LIST = 4096 /* beyond this the oldest make room: a month and a half of Galileo's */
};

/* A piece of a satellite's way between two moments, from one ephemeris: states in between are interpolated. */
typedef struct {
	bool there;
	fw_ephemeris from;
	fw_time begin;
	fw_satellite_state ends[2];
} ephemeris_arc;

/* Zero it at the start. */
typedef struct {
	ephemeris_list lists[FW_SATELLITE_COUNT][EPHEMERIS_MESSAGES];
	fw_iono_coefficients iono; /* the newest of each system */
	ephemeris_arc arcs[FW_SATELLITE_COUNT];
	uint64_t taken, refused; /* records */
	bool no_memory;          /* ephemerides were lost for lack of memory */
} ephemeris_store;

/* Takes navigation records; all others are passed over. A sink's put; `store` is an ephemeris_store. */
void ephemeris_store_put(void *store, fw_kind kind, const void *record);

/* The ephemeris for satellite s at time t: the one whose reference time is nearest to t; of two alike the one that came
 * last. A satellite with two messages has the wanted one, or, when that is too far from t to be used, the other.
 * NULL when there is none, or when that one says that the satellite is unhealthy. */
const fw_ephemeris *ephemeris_store_find(void *store, fw_satellite s, fw_nav_message wanted, fw_time t);

/* fw_ephemeris_state(), interpolated (cubic Hermite) between states half a minute apart, so that orbits need not be computed
 * anew at each epoch: positions differ by less than 0.1 mm, velocities by less than 0.05 mm/s. */
fw_status ephemeris_store_state(void *store, const fw_ephemeris *e, fw_time t,
                                fw_satellite_state *state) FW_MUST_CHECK;

void ephemeris_store_free(ephemeris_store *store);

/* The kinds of records that the store takes. */
void ephemeris_kinds(fw_kind_set *kinds);

#endif
