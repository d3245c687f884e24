/* Trajectories in memory: what nav-eval compares. A file of any kind that furrow reads becomes a series of fixes in
 * order of time. */
#ifndef FURROW_CLI_EVAL_SERIES_H
#define FURROW_CLI_EVAL_SERIES_H

#include <stddef.h>
#include <stdint.h>

#include "base/time.h"
#include "formats/record.h"
#include "source.h"
#include "tool.h"

enum { EVAL_H, EVAL_V }; /* horizontal, vertical: index of what comes in such pairs */

/* One epoch of a trajectory. A number that is not known is NaN. */
typedef struct {
	fw_time t;
	fw_kind kind;
	double lat_rad, lon_rad, height_m;
	double position_m[3];   /* ECEF, from the three before */
	double velocity_mps[3]; /* NED */
	double rpy_rad[3];      /* roll, pitch, heading */
	double sd_position_m[3], sd_velocity_mps[3], sd_rpy_rad[3];
	double pl_m[2];  /* protection levels */
	double al_m[2];  /* alert limits */
	double fom_m[2]; /* figures of merit: 95 % */
} eval_fix;

typedef struct {
	const char *name; /* the file */
	fw_kind kind;     /* the record type that the fixes are from; FW_RECORD_COUNT: there is none */
	eval_fix *fix;
	size_t n, room;
	uint64_t no_position; /* rows without a position */
	uint64_t misplaced;   /* rows whose position is no place near the Earth */
	uint64_t repeated;    /* rows with the stamp of one before */
	uint64_t too_many;    /* rows beyond the limit */
	int no_memory;
} eval_series;

typedef struct {
	fw_kind kind;                /* the record type wanted; FW_RECORD_COUNT: the best that there is */
	const fw_time *from, *until; /* fixes before and from there on are left out; NULL: no limit */
	size_t max;                  /* rows to keep at most */
	const char *progress;
	fw_kind_set others; /* records for someone else that the file may have, */
	fw_sink other;      /* and for whom */
} eval_plan;

/* The record types that can be a trajectory, best first, then FW_RECORD_COUNT. */
extern const fw_kind eval_kinds[];

/* Reads a file into an empty series. Of the types that can be a trajectory one is kept: nav, else pos, ins, pvt. What else
 * there is with the same stamp is added to its fixes where they lack it: the receiver's attitude (att), protection
 * levels (pl, which come before those in nav, else dop).
 * Messages go to stderr. Returns an exit status; the series is to be released in any case. */
int eval_series_read(eval_series *s, tool *t, const char *path, const eval_plan *plan, source_totals *totals);

/* Takes protection levels and alert limits from another series, where it has them at the same time. */
void eval_series_add_levels(eval_series *s, const eval_series *levels);

/* The first fix at t or later: its index, s->n if there is none. */
size_t eval_series_at(const eval_series *s, fw_time t);

/* The median time between two fixes [ns], at most a week; 0 when there are fewer than two, or no memory. */
int64_t eval_series_interval(const eval_series *s);

/* Gives the memory back. */
void eval_series_release(eval_series *s);

/* ---- for tests and for those who make fixes themselves ---- */

/* A fix at t of which nothing else is known. */
eval_fix eval_fix_empty(fw_time t, fw_kind kind);

/* Appends a fix. A row without a position, or one too many, is counted and not kept. Returns FW_OK;
 * FW_ENOMEM; FW_ERANGE: its position is no place near the Earth. */
fw_status eval_series_add(eval_series *s, const eval_fix *fix, size_t max) FW_MUST_CHECK;

/* Brings all fixes into order, keeps those of one type and merges the others into them; see eval_series_read(). */
void eval_series_settle(eval_series *s, fw_kind wanted);

#endif
