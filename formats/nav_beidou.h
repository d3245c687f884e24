/* BeiDou D1 (medium and inclined orbits) and D2 (geostationary), the navigation messages of B1I, B2I and B3I:
 * ephemeris, ionosphere and UTC parameters.
 *
 * Source: BDS-SIS-ICD-B1I-3.0: 5.1.3 (BCH code), 5.2 (D1), 5.3 (D2). */
#ifndef FURROW_FORMATS_NAV_BEIDOU_H
#define FURROW_FORMATS_NAV_BEIDOU_H

#include "formats/nav_message.h"

/* Records eph_bds, klobuchar, utc from BDSRaw: the 300 bits of a subframe, deinterleaved. A subframe counts
 * only if the BCH(15,11) parity of all its words holds. No issue of data ties subframes together, so the
 * ephemeris is joined from one frame (D1: 30 s) or one run of pages 1 to 10 (D2: 30 s). Times are BeiDou
 * time. */
extern const fw_nav_system fw_nav_d1;
extern const fw_nav_system fw_nav_d2;

#endif
