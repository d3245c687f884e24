/* The Earth's magnetic field by the World Magnetic Model. */
#ifndef FURROW_INS_MAGNETIC_FIELD_H
#define FURROW_INS_MAGNETIC_FIELD_H

#include "base/status.h"
#include "base/time.h"

/* Field at a place and time, north, east, down along the ellipsoid's normal [nT].
 *   llh  in   latitude [rad], longitude [rad], height above the ellipsoid [m], -10 km..1000 km
 * At the poles north and east are those of the longitude given. Declination is atan2(east, north).
 * The model is WMM2025, of degree 12, for 2025.0 to 2030.0: standard error about 150 nT and half a degree of declination, more near
 * the magnetic poles.
 * Returns FW_OK; FW_DUBIOUS (done, outside these years); FW_ENONFINITE; FW_ERANGE (place or time): field untouched.
 * Source: The US/UK World Magnetic Model for 2025-2030, NOAA technical report (2024), equations 1 to 18. */
fw_status fw_magnetic_field(const double llh[static 3], fw_time t,
                            double field_ned_nt[static 3]) FW_MUST_CHECK;

#endif
