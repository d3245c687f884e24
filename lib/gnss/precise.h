/* Precise orbits and clocks: the state of a satellite from tables of positions (SP3) and clocks (SP3 or RINEX
 * clock files), as analysis centres publish them after the fact.
 *
 * The tables are windows over streams: epochs are added in time order, the oldest make room for new ones, and
 * fw_precise_wants_*() says when to read on. Memory is fixed, whatever the length of the files:
 *
 *     while (fw_precise_wants_orbits(&precise, t) && fw_sp3_read(&sp3, &point) == FW_OK)
 *             if (point.has_position)
 *                     status = fw_precise_add_position(&precise, point.time, point.satellite, point.position_m);
 *     status = fw_precise_state(&precise, satellite, t, &state);
 *
 * Positions are those of the centre of mass, in the frame of the products (ITRF); the antenna's phase centre
 * lies up to some metres from it. */
#ifndef FURROW_GNSS_PRECISE_H
#define FURROW_GNSS_PRECISE_H

#include "base/time.h"
#include "gnss/ephemeris.h"
#include "gnss/signal.h"

enum {
	FW_PRECISE_POINTS = 11, /* positions that a polynomial of order 10 goes through */
	FW_PRECISE_EPOCHS = 16, /* held: the points, one that is being read, some that time may go back */
};

/* Widest spacing of epochs, and furthest beyond the first or last of them [s]: 15 min, the usual spacing of
 * SP3. */
#define FW_PRECISE_SPACING_S 900

/* Owned by the caller, 230 KB. */
typedef struct {
	/* Private. Epochs in time order, the oldest first; a value that is missing is NaN. */
	struct fw_precise_orbits {
		unsigned n;
		fw_time time[FW_PRECISE_EPOCHS];
		double position_m[FW_PRECISE_EPOCHS][FW_SATELLITE_COUNT][3];
	} orbits;
	struct fw_precise_clocks {
		unsigned n;
		fw_time time[FW_PRECISE_EPOCHS];
		double clock_s[FW_PRECISE_EPOCHS][FW_SATELLITE_COUNT];
	} clocks;
} fw_precise;

/* Empty tables. */
void fw_precise_init(fw_precise *p);

/* Add a satellite's position (ECEF) or clock offset (periodic relativistic effect not included, as SP3 and
 * RINEX clock files have it) at an epoch, not before the newest. A value for the newest epoch replaces the
 * one that was there, so that daily files which share midnight can follow one another. Add clocks from one
 * source only: SP3 or clock files.
 * Returns FW_OK; FW_EINVAL (earlier than the newest epoch, or no such satellite); FW_ENONFINITE. */
fw_status fw_precise_add_position(fw_precise *p, fw_time t, fw_satellite s,
                                  const double position_m[static 3]) FW_MUST_CHECK;
fw_status fw_precise_add_clock(fw_precise *p, fw_time t, fw_satellite s, double clock_s) FW_MUST_CHECK;

/* Whether reading on would improve (or first make possible) states at t: the points around t are not all
 * complete, an epoch being complete when a later one has begun. At the end of the file the answer may stay
 * true. */
bool fw_precise_wants_orbits(const fw_precise *p, fw_time t);
bool fw_precise_wants_clocks(const fw_precise *p, fw_time t);

/* The state of a satellite at GPST t (time of transmission). Orbit: polynomial of order 10 through six epochs
 * before t and five at or after it, in the frame that does not rotate with the Earth and coincides with ECEF
 * at t; velocity is its derivative. Clock: linear between the satellite's nearest values before and after t,
 * plus the periodic relativistic effect -2 r.v/c^2.
 * Returns FW_OK; FW_DUBIOUS: done, but t is not in the middle of the points (begin or end of the files) or up
 * to FW_PRECISE_SPACING_S outside them, where a polynomial is decimetres worse, or the clock is that of one
 * neighbour alone; FW_ERANGE: t is further outside, there are fewer than 11 epochs, or a gap among the
 * points; FW_EUNKNOWN: the satellite lacks a position in one of them, or clocks around t; FW_ENONFINITE:
 * numbers of the tables overflow. *state untouched on error.
 * Source: M. Horemuz, J. V. Andersson, "Polynomial interpolation of GPS satellite coordinates", GPS Solutions
 * 10 (2006); Neville's scheme; relativistic effect: IS-GPS-200N 20.3.3.3.3.1. */
fw_status fw_precise_state(const fw_precise *p, fw_satellite s, fw_time t,
                           fw_satellite_state *state) FW_MUST_CHECK;

#endif
