/* The magnetometer as a compass: calibration of hard and soft iron, and the heading with its sigma.
 *
 * A reading in body axes is m = (I + S) field + h + noise: h the hard iron, S the soft iron. A calibration
 * takes both out,
 *     field = matrix (m - offset),
 * Units are microtesla; readings in a unit of their own (normalised, raw counts) may be calibrated by
 * turning, and come out in microtesla. */
#ifndef FURROW_INS_MAGNETOMETER_H
#define FURROW_INS_MAGNETOMETER_H

#include <stdbool.h>

#include "base/status.h"
#include "base/time.h"

typedef struct {
	double matrix[3][3];
	double offset[3];      /* in the unit of the readings */
	double field_ut;       /* strength of the Earth's field where it was calibrated */
	double noise_ut;       /* root mean square of what is left of each component */
	double heading_sd_rad; /* of the calibration itself, held level, the worst of all headings */
	bool flat;             /* from turning on level ground only: good near level */
} fw_mag_calibration;

/* No calibration: the readings are the field, to the noise given. */
fw_mag_calibration fw_mag_as_it_is(double field_ut, double noise_ut);

/* ---- without any reference: turning on the ground ---- */

/* Gram matrix of the terms of a quadric, xx yy zz yz xz xy x y z 1, of readings less the first one. */
enum { FW_MAG_TERMS = 10 };
typedef struct {
	double n;
	double first[3];
	double scale; /* readings are divided by it: the length of the first one */
	double gram[FW_MAG_TERMS][FW_MAG_TERMS];
} fw_mag_turning;

void fw_mag_turning_init(fw_mag_turning *g);

/* A reading, in any unit. Readings are best from motion that is even in time over all directions.
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (the first one is zero): nothing taken. */
fw_status fw_mag_turning_add(fw_mag_turning *g, const double m_b[static 3]) FW_MUST_CHECK;

/* The calibration: the ellipsoid |N (m - h)| = 1, N symmetric and positive, by least squares on the Gram
 * matrix (Gauss-Newton; always an ellipsoid). A symmetric N leaves open a soft iron that turns the field
 * without distorting it: GNSS heading shows that. If the motion was a turn on level ground, an ellipse in the
 * plane of x and y instead: north and east are calibrated, z only as far as the vertical strength tells its
 * offset.
 *   field_ned_nt  in   fw_magnetic_field there
 *   cal           out
 * Returns FW_OK; FW_DUBIOUS (done, flat: cal->flat); FW_MORE (fewer than 20 readings); FW_ESINGULAR (the
 * readings cover too little: heading_sd_rad would be above 3 degrees); FW_ENONFINITE, FW_EINVAL (field). *cal
 * untouched unless done. */
fw_status fw_mag_turning_solve(const fw_mag_turning *g, const double field_ned_nt[static 3],
                               fw_mag_calibration *cal) FW_MUST_CHECK;

/* ---- with the attitude known, its heading from GNSS ---- */

/* Normal equations of m = T field_b + h, axis by axis the same matrix. */
typedef struct {
	double n;
	double field_ut; /* of the last reading */
	double horizontal_ut, vertical_ut;
	double normal[4][4]; /* of (field_b, 1), field_b over its strength */
	double right[4][3];  /* with the readings */
	double squares[3];   /* of the readings */
} fw_mag_referenced;

void fw_mag_referenced_init(fw_mag_referenced *g);

/* A reading [uT] with the attitude at its time.
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (no horizontal field): nothing taken. */
fw_status fw_mag_referenced_add(fw_mag_referenced *g, const double q_n_b[static 4],
                                const double field_ned_nt[static 3],
                                const double m_b[static 3]) FW_MUST_CHECK;

/* The calibration: T and h by least squares, drawn to T = I (each element to 0.2) where the motion shows
 * nothing.
 * Returns FW_OK; FW_MORE (fewer than 20 readings); FW_ESINGULAR (heading_sd_rad would be above 3 degrees).
 * *cal untouched unless done. */
fw_status fw_mag_referenced_solve(const fw_mag_referenced *g, fw_mag_calibration *cal) FW_MUST_CHECK;

/* ---- heading ---- */

/* The calibrated field in body axes [uT]. */
void fw_mag_field(const fw_mag_calibration *cal, const double m_b[static 3], double field_b_ut[static 3]);

/* True heading from a reading: calibrated, levelled by roll and pitch, declination added.
 *   rp_rad       in   roll, pitch
 *   tilt_sd_rad  in   sigma of each: by the vertical field it counts tan(inclination) times
 *   field_ned_nt in   fw_magnetic_field there and then (that says FW_DUBIOUS outside its years; pass it on)
 *   heading_rad  out  0..2 pi
 *   sd_rad       out  from noise (at least what the strength is off by), tilt, and calibration; the model's
 *                     half degree of
 *                     declination and what moves about in the vehicle are not in it
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (sigma negative); FW_ESINGULAR (no horizontal field: near a
 * magnetic pole, or the reading says so). Outputs untouched on error. */
fw_status fw_mag_heading(const fw_mag_calibration *cal, const double m_b[static 3],
                         const double rp_rad[static 2], double tilt_sd_rad,
                         const double field_ned_nt[static 3], double *heading_rad,
                         double *sd_rad) FW_MUST_CHECK;

/* The same at a place and time, where it asks for the World Magnetic Model itself.
 * Returns as fw_mag_heading and fw_magnetic_field; FW_DUBIOUS: done, outside the model's years. */
fw_status fw_mag_heading_at(const fw_mag_calibration *cal, const double m_b[static 3],
                            const double rp_rad[static 2], double tilt_sd_rad, const double llh[static 3],
                            fw_time t, double *heading_rad, double *sd_rad) FW_MUST_CHECK;

#endif
