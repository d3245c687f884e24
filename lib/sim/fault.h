/* What goes wrong around a receiver: satellites hidden, signals attenuated, ranges falsified, outputs lost.
 * Times are seconds since the start of the scenario; a window holds from `from_s` up to but not including
 * `until_s`. */
#ifndef FURROW_SIM_FAULT_H
#define FURROW_SIM_FAULT_H

#include <stdbool.h>
#include <stdint.h>

#include "gnss/signal.h"

/* Satellites, as a set. */
typedef struct {
	uint64_t bits[FW_SYSTEM_COUNT];
} fw_satellite_set;

static inline bool fw_satellite_in(const fw_satellite_set *set, fw_satellite s)
{
	return s.system < FW_SYSTEM_COUNT && (set->bits[s.system] >> (s.number % 64) & 1) != 0;
}

typedef struct {
	double from_s, until_s;
} fw_window;

static inline bool fw_window_holds(fw_window w, double t_s)
{
	return t_s >= w.from_s && t_s < w.until_s;
}

/* Stations that something applies to. */
enum { FW_STATION_ROVER = 1, FW_STATION_BASE = 2 };

/* A part of the sky that is hidden, or dimmed. It covers a satellite that is in the set, in the sector and
 * not above `below_rad`. Of the satellites covered, the `keep` that stood highest when the mask set in stay
 * visible. */
typedef struct {
	fw_window window;
	unsigned stations; /* FW_STATION_... */
	fw_satellite_set satellites;
	double azimuth_from_rad, azimuth_to_rad; /* clockwise; equal: all round */
	double below_rad;                        /* elevation */
	unsigned keep;
	double attenuation_db; /* infinite: hidden */
} fw_mask;

typedef enum {
	FW_FAULT_STEP,     /* ranges longer by size_m */
	FW_FAULT_RAMP,     /* ranges longer by rate_mps times the time since it began */
	FW_FAULT_MEACON,   /* signals as an antenna at a fixed place receives them, delay_m later */
	FW_FAULT_DRAG_OFF, /* signals as at the true place, plus an offset, plus a velocity times the time */
	FW_FAULT_SLIP,     /* once, at from_s: carriers lose their cycle count */
	FW_FAULT_NO_PVT,   /* no position */
	FW_FAULT_NO_ATTITUDE,
	FW_FAULT_SILENCE /* the receiver logs nothing at all */
} fw_fault_kind;

typedef struct {
	fw_fault_kind kind;
	fw_window window;
	unsigned stations;
	fw_satellite_set satellites;
	double size_m, rate_mps, delay_m;
	double offset_ned_m[3],
	    rate_ned_mps[3]; /* MEACON: place of its antenna, from the start; DRAG_OFF: from the truth */
} fw_fault;

/* The masks over one satellite.
 *   kept  in  by mask: the satellites that `keep` lets through; NULL: no mask has one
 * Returns the attenuation [dB], infinite when hidden. */
double fw_masks_attenuation_db(const fw_mask *masks, unsigned n, const fw_satellite_set *kept,
                               unsigned station, double t_s, fw_satellite s, double azimuth_rad,
                               double elevation_rad);

/* Whether a mask covers a satellite there, its window and its `keep` aside. */
bool fw_mask_covers(const fw_mask *mask, fw_satellite s, double azimuth_rad, double elevation_rad);

/* Whether a fault of that kind holds for the station at t_s. */
bool fw_faults_hold(const fw_fault *faults, unsigned n, fw_fault_kind kind, unsigned station, double t_s);

#endif
