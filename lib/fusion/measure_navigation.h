/* Measurements of position, velocity, heading and height for the filter: innovation and Jacobian at its present state.
 *
 * Each sets *z whole. lever_b is where the antenna is, from the IMU, in body axes [m]. Sigmas and covariances are positive; they are not checked
 * here (fw_filter_update refuses what is not). */
#ifndef FURROW_FUSION_MEASURE_NAVIGATION_H
#define FURROW_FUSION_MEASURE_NAVIGATION_H

#include "fusion/filter.h"

/* Position of the antenna: llh [rad, rad, m], R (3 x 3) [m^2] NED. The position error block is part of it if there is one. */
void fw_measure_position(const fw_filter *f, const double llh[static 3], const double R[static 3][3],
                         const double lever_b[static 3], fw_measurement *z);

/* Velocity of the antenna against the Earth [m/s], NED; R (3 x 3) [m^2/s^2]. The velocity error block is part of it if there is one. */
void fw_measure_velocity(const fw_filter *f, const double velocity_mps[static 3], const double R[static 3][3],
                         const double lever_b[static 3], fw_measurement *z);

/* Heading of the body [rad], true north. Without meaning where the nose points up or down: returns FW_ESINGULAR beyond 80 degrees
 * of pitch. */
fw_status fw_measure_heading(const fw_filter *f, double heading_rad, double sd_rad,
                             fw_measurement *z) FW_MUST_CHECK;

/* Heading by a compass whose field was levelled with the filter's own roll and pitch [rad], true north: an error of those turns it
 * by tan(inclination) times as much, which is part of H.
 *   field_ned_nt  in  the Earth's field, fw_magnetic_field; not vertical
 * Returns as fw_measure_heading. */
fw_status fw_measure_compass(const fw_filter *f, double heading_rad, double sd_rad,
                             const double field_ned_nt[static 3], fw_measurement *z) FW_MUST_CHECK;

/* Barometric height [m]. The height error block is part of it if there is one. */
void fw_measure_height(const fw_filter *f, double height_m, double sd_m, fw_measurement *z);

/* Standing still: velocity zero, of the IMU. */
void fw_measure_zero_velocity(const fw_filter *f, double sd_mps, fw_measurement *z);

/* Not turning: angular rate against the Earth zero, so that the gyros show their bias and the Earth's rotation.
 *   omega_ib_b  in  mean of the gyros as they read [rad/s], over a stretch that sd_radps is for */
void fw_measure_zero_rate(const fw_filter *f, const double omega_ib_b[static 3], double sd_radps,
                          fw_measurement *z);

/* A wheeled vehicle: no velocity to the side and none up, at a point of the body. */
void fw_measure_wheels(const fw_filter *f, double sd_mps, const double lever_b[static 3], fw_measurement *z);

#endif
