/* GPS and QZSS LNAV, the navigation message of L1 C/A: subframes 1 to 3 (ephemeris) and the page with the
 * ionosphere and UTC parameters.
 *
 * Source: IS-GPS-200N, 20.3.3 (layout) and 20.3.5 (parity); IS-QZSS-PNT-005, 4.3 (data ID 3). */
#ifndef FURROW_FORMATS_NAV_GPS_H
#define FURROW_FORMATS_NAV_GPS_H

#include "formats/nav_message.h"

/* Records eph_gps, klobuchar, utc from the ten words of GPSRawCA and QZSRawL1CA, each right-aligned with its
 * six parity bits. A word that follows a transmitted D30 of 1 is stored inverted as a whole, which leaves the
 * 24 data bits as they were before transmission. A subframe counts only if all ten words hold. */
extern const fw_nav_system fw_nav_lnav;

#endif
