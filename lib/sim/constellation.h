/* The satellites of GPS, Galileo, BeiDou and GLONASS as they would broadcast themselves: nominal
 * constellations for any date, in ephemerides quantised as the interface documents have it.
 *
 * GPS: 31 satellites in 6 planes; Galileo: 24 in 3; BeiDou: 24 MEO in 3, 3 IGSO, 5 GEO; GLONASS: 24 in 3.
 * Planes drift with their nodes from date to date as the real ones do; numbers and slots within a plane are
 * ours. */
#ifndef FURROW_SIM_CONSTELLATION_H
#define FURROW_SIM_CONSTELLATION_H

#include "gnss/ephemeris.h"

/* Fills in the ephemerides that are broadcast from `from` to `until`: for each satellite those whose toe is
 * up to two intervals (GPS 2 h, Galileo and BeiDou 1 h, GLONASS 30 min) before the one and after the other.
 *   systems      in   bit 1 << fw_system: those wanted, of the four
 *   ephemerides  out  room for `room`; those of a satellite together, ascending by toe
 *   n            out  how many
 * The same dates give the same ephemerides, to the last bit. Returns FW_OK; FW_EINVAL (until is before
 * from); FW_ENOSPACE: *n untouched. */
fw_status fw_constellation(fw_time from, fw_time until, unsigned systems, unsigned room,
                           fw_ephemeris *ephemerides, unsigned *n) FW_MUST_CHECK;

#endif
