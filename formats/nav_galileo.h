/* Galileo I/NAV (E1-B, E5b-I) and F/NAV (E5a-I): ephemeris, NeQuick-G, UTC and Galileo-GPS time offset.
 *
 * Source: Galileo OS SIS ICD 2.1: 4.2 (F/NAV pages 1 to 4), 4.3 (I/NAV words 1 to 6, 10), 5.1.9.4 (CRC). */
#ifndef FURROW_FORMATS_NAV_GALILEO_H
#define FURROW_FORMATS_NAV_GALILEO_H

#include "formats/nav_message.h"

/* Records eph_gal, nequick, utc, ggto with message 2 from GALRawINAV: 114 bits of the even half-page, 120 of
 * the odd one. Both signals carry the same words and are mixed. A page counts only if it is nominal (not an
 * alert page) and its CRC holds. */
extern const fw_nav_system fw_nav_inav;

/* The same records with message 16 from GALRawFNAV: 244 bits of a page, synchronisation pattern apart. */
extern const fw_nav_system fw_nav_fnav;

#endif
