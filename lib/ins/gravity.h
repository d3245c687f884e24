/* The Earth as an INS knows it: normal gravity and rotation of WGS84. */
#ifndef FURROW_INS_GRAVITY_H
#define FURROW_INS_GRAVITY_H

/** NGA.STND.0036_1.0.0_WGS84, table 3.1: angular velocity of the Earth [rad/s] */
#define FW_EARTH_RATE_RADPS 7.292115e-5

/* Normal gravity [m/s^2], down along the ellipsoid's normal: Somigliana's formula on the ellipsoid, second order in the
 * height above it. The deflection of normal gravity with height (8e-9 1/s^2 per metre, northwards) is left out.
 *   lat_rad   geodetic latitude
 *   height_m  above the ellipsoid, up to 20 km
 * NaN gives NaN. Source: NGA.STND.0036_1.0.0_WGS84, equations 4.1 and 4.3. */
double fw_gravity_mps2(double lat_rad, double height_m);

/* The same for someone who has the sine of the latitude at hand, with the decrease of gravity per metre of height [1/s^2]. */
double fw_gravity_at(double sin2_lat, double height_m, double *decrease_per_m);

#endif
