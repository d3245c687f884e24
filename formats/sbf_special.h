/* The few things about SBF blocks that no table line can say. Called by sbf_records.c. */
#ifndef FURROW_FORMATS_SBF_SPECIAL_H
#define FURROW_FORMATS_SBF_SPECIAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "furrow_event.h"
#include "furrow_ext_sensor.h"
#include "furrow_imu.h"
#include "furrow_imu_setup.h"
#include "furrow_residual.h"
#include "furrow_satpos.h"

/* ExtEvent: moves the stamp, which is receiver time at the last epoch, to the event, in GNSS time where the clock
 * bias is known: stamp + Offset - RxClkBias. A correction of a week or more is damage: no stamp at all. */
void fw_sbf_place_event(furrow_event *event);

/* PVTSatCartesian: the delays, which come as MSB and LSB. `sub` is the sub-block of `size` bytes. */
void fw_sbf_set_delays(furrow_satpos *satpos, const uint8_t *sub, size_t size);

/* PVTResiduals: which quantity the k-th (0, 1, 2) residual of a signal is about, as the bits of MeasInfo say, and its
 * detectable bias, whose unit depends on that. `info` is the residual's sub-block of `size` bytes. */
void fw_sbf_set_quantity(furrow_residual *residual, uint8_t meas_info, unsigned k, const uint8_t *info,
                         size_t size);

/* ExtSensorMeas: what the 24 bytes of a measurement hold, in the sensor's axes, into a record whose `type` is set. */
void fw_sbf_set_sensor(furrow_ext_sensor *sensor, const uint8_t *data);

/* The rotation that an IMUSetup block describes: C = Rz(ThetaZ) Ry(ThetaY) Rx(ThetaX), x_vehicle = C x_sensor, 3 x 3
 * row-major. Returns false, C untouched, when an angle is absent. */
bool fw_sbf_mounting(const furrow_imu_setup *setup, double C_vehicle_sensor[9]);

/* Adds a measurement of acceleration or angular rate to an `imu` record, turned into the vehicle's axes. A vector of
 * which a component is absent, or of a kind that the record has already, is left out.
 *   C_vehicle_sensor  in  NULL: the sensor's axes are taken as they are */
void fw_sbf_add_imu(furrow_imu *imu, const furrow_ext_sensor *sensor, const double *C_vehicle_sensor);

#endif
