/* Broadcast ephemerides: where a satellite is, how fast it moves, and what its clock says.
 *
 * One struct holds the ephemeris of any system; the satellite's system says which members mean something. All
 * angles are in radians, all times are fw_time (GPST), whatever the system's own time scale is. */
#ifndef FURROW_GNSS_EPHEMERIS_H
#define FURROW_GNSS_EPHEMERIS_H

#include "base/time.h"
#include "gnss/signal.h"

/* Which navigation message an ephemeris is from: it decides the reference of the clock and the group
 * delays. */
typedef enum { FW_NAV_LNAV, FW_NAV_INAV, FW_NAV_FNAV, FW_NAV_D1D2, FW_NAV_FDMA, FW_NAV_SBAS } fw_nav_message;

typedef struct {
	fw_satellite satellite;
	fw_nav_message message;
	fw_time toe, toc; /* reference times of orbit and clock; GLONASS, SBAS: both the reference time */
	int32_t issue;    /* IODE, IODnav, AODE, SBAS IODN, GLONASS tb index: changes with the content */
	bool healthy;
	double accuracy_m; /* URA, SISA: nominal standard deviation of the range; 0 when not known */
	double af0_s, af1_sps, af2_sps2; /* satellite clock: offset = af0 + af1 (t - toc) + af2 (t - toc)^2 */
	/* Group delays that the message carries [s]: GPS, QZSS tgd[0] = T_GD; Galileo tgd[0] = BGD E1/E5a,
	 * tgd[1] = BGD E1/E5b; BeiDou tgd[0] = T_GD1 (B1I), tgd[1] = T_GD2 (B2I); GLONASS tgd[0] = dtau (L2
	 * minus L1). */
	double tgd_s[2];

	union {
		struct { /* GPS, Galileo, BeiDou, QZSS */
			double sqrt_a, ecc, i0, omega0, omega, m0, delta_n, omega_dot, idot; /* SI, rad */
			double cuc, cus, crc, crs, cic, cis;                                 /* rad, m */
		} kepler;
		struct { /* GLONASS: PZ-90 at toe, ECEF; SBAS: polynomial at toe */
			double position_m[3], velocity_mps[3], acceleration_mps2[3];
			int channel; /* GLONASS frequency number */
		} state;
	};
} fw_ephemeris;

typedef struct {
	/* ECEF (WGS84, within centimetres also PZ-90.11, GTRF, CGCS2000) at the time asked for */
	double position_m[3];
	double velocity_mps[3]; /* ECEF */
	double clock_s;         /* satellite clock offset, relativistic term included, group delay not */
	double drift_sps;       /* its rate, relativistic term included */
} fw_satellite_state;

/* The state of a satellite at GPST t (time of transmission).
 * Returns FW_OK; FW_DUBIOUS: t is further from toe than the message is meant for (GPS 2 h, Galileo 4 h,
 * BeiDou 6 h, GLONASS 15 min, SBAS 4 min), result given; FW_ERANGE: further than the solver should ever go
 * (GPS, QZSS 4 h, Galileo 4 h, BeiDou 6 h, GLONASS 30 min, SBAS 6 min); FW_EINVAL, FW_ENONFINITE: the
 * ephemeris is nonsense (eccentricity outside 0..1, a satellite not 10,000 to 100,000 km from the centre of
 * the Earth, a clock off by more than a second, ...). NavIC is taken as GPS. *state untouched on error.
 * Source: IS-GPS-200 20.3.3.4.3, Galileo OS SIS ICD 5.1.1, BDS-SIS-ICD-B1I 5.2.4.12 (GEO included), GLONASS
 * ICD 5.1 A.3.1.2 (Runge-Kutta, steps of at most 40 s), RTCA DO-229 A.4.4.11. */
fw_status fw_ephemeris_state(const fw_ephemeris *e, fw_time t, fw_satellite_state *state) FW_MUST_CHECK;

/* The group delay of a signal against the clock of the message [s]: subtract it from the satellite clock for
 * a code measured on that signal. FW_EUNKNOWN: the message says nothing about that signal (delay 0 is given).
 * NavIC: tgd[0] as T_GD. Source: the systems' ICDs, row by row of the table in ephemeris.c. */
fw_status fw_ephemeris_group_delay(const fw_ephemeris *e, fw_signal signal, double *delay_s) FW_MUST_CHECK;

#endif
