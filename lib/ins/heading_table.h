/* A compass that learns from GNSS heading: corrections of the magnetic heading as a function of that heading,
 * learnt while GNSS heading is there, used when it is gone.
 *
 * correction(heading) = c + a1 cos + b1 sin + a2 cos 2 + b2 sin 2
 *                       + roll (d1 cos + e1 sin) + pitch (d2 cos + e2 sin) + table,
 * the table linear between its cells around the circle. The first five are the form that hard iron (one
 * cycle) and soft iron (two cycles, and c) give a level compass, so a few headings tell about all; the next
 * four are what vertical iron, and soft iron in the vertical field, do to first order when the vehicle leans;
 * the table holds what is left, where the vehicle has been. All are estimated together by one Kalman filter
 * that begins with corrections of zero: where nothing was learnt, the compass is used as it is, and the sigma
 * says so.
 *
 * After the look-up table of the EGNOS navigation system for survey drones; the Fourier terms are the
 * deviation coefficients A to E of ships' compasses. */
#ifndef FURROW_INS_HEADING_TABLE_H
#define FURROW_INS_HEADING_TABLE_H

#include <stdbool.h>

#include "base/status.h"
#include "base/time.h"

enum {
	FW_HEADING_HARMONICS = 5,
	FW_HEADING_CELLS = 36, /* every 10 degrees */
	FW_HEADING_TILTS = 4,
	FW_HEADING_STATES = FW_HEADING_HARMONICS + FW_HEADING_TILTS + FW_HEADING_CELLS
};

typedef struct {
	double harmonic_sd_rad; /* of each coefficient before anything is learnt */
	double cell_sd_rad;     /* of each cell */
	double memory_s;        /* what is learnt fades away with this time constant */
	double correlation_s;   /* errors within this time are taken for the same */
} fw_heading_table_setup;

/* 5 degrees and 1 degree, for a compass that was never calibrated (after a calibration 1 and 0.3 are enough);
 * one day (the deviation then wanders by about half a degree in ten minutes); 1 s. */
fw_heading_table_setup fw_heading_table_defaults(void);

typedef struct {
	fw_heading_table_setup setup;
	bool begun;
	fw_time t;                   /* of the last update */
	double rp_rad[2];            /* roll and pitch now */
	double x[FW_HEADING_STATES]; /* c a1 b1 a2 b2 d1 e1 d2 e2, cells [rad] */
	double P[FW_HEADING_STATES][FW_HEADING_STATES];
} fw_heading_table; /* 17 kB */

/* Starts with nothing learnt. Returns FW_OK; FW_EINVAL (not positive, NaN): *h untouched. */
fw_status fw_heading_table_init(const fw_heading_table_setup *setup, fw_heading_table *h) FW_MUST_CHECK;

/* Roll and pitch [rad] at which the headings are that come next; level at the start. Not finite ones are
 * ignored. */
void fw_heading_table_tilt(fw_heading_table *h, const double rp_rad[static 2]);

/* A GNSS heading and the magnetic heading (fw_mag_heading) of the same moment.
 *   sd_rad  in  of their difference, the compass's deviation left out: GNSS heading and noise of the
 *               magnetometer; > 0
 * A difference beyond 3 sigma of what was expected counts less, the more so the further it is off, but never
 * nothing.
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (sd; time before the last): nothing learnt. */
fw_status fw_heading_table_update(fw_heading_table *h, fw_time t, double magnetic_heading_rad,
                                  double gnss_heading_rad, double sd_rad) FW_MUST_CHECK;

/* What to add to a magnetic heading, and its sigma as of the last update. Not finite headings give NaN. */
void fw_heading_table_correction(const fw_heading_table *h, double magnetic_heading_rad,
                                 double *correction_rad, double *sd_rad);

#endif
