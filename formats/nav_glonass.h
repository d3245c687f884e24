/* GLONASS, the navigation message of the FDMA signals L1 and L2 C/A: ephemeris (strings 1 to 4), time
 * parameters (strings 5 and 14), health flags of the almanac.
 *
 * Source: GLONASS ICD, L1 and L2, edition 5.1: 4.4 (parameters), 4.5 (almanac), 4.7 (Hamming code). */
#ifndef FURROW_FORMATS_NAV_GLONASS_H
#define FURROW_FORMATS_NAV_GLONASS_H

#include "formats/nav_message.h"

/* Records eph_glo, glo_time from GLORawCA: the 85 bits of a string. A string counts only if its Hamming code
 * is free of error (nothing is corrected). The ephemeris is joined from the strings of one frame (30 s).
 *
 * health_c is the almanac's flag C, which the satellites send of each other; it is absent until it was heard.
 * glo_time waits for string 14 of the last frame of a superframe (2.5 min): only there are KP, B1 and B2. */
extern const fw_nav_system fw_nav_gnav;

#endif
