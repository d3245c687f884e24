/* What the atmosphere adds to a range: models of the ionosphere and the troposphere.
 *
 * Angles are radians, delays are metres, positive: they make a code longer (and, the ionosphere's, a carrier shorter).
 * Nothing here can fail: latitudes, heights and elevations outside a model's range are brought to its edge. */
#ifndef FURROW_GNSS_ATMOSPHERE_H
#define FURROW_GNSS_ATMOSPHERE_H

/* The eight coefficients that GPS, QZSS and BeiDou broadcast: amplitude [s, s per semi-circle, ...] and period. */
typedef struct {
	double alpha[4], beta[4];
} fw_klobuchar;

/* Where a satellite is seen from: what the ionosphere models need to know. */
typedef struct {
	double lat_rad, lon_rad;
	double azimuth_rad, elevation_rad;
	double tow_s; /* GPS time of week */
} fw_sight;

/* Klobuchar's model as GPS has it: slant delay on L1. Source: IS-GPS-200N, 20.3.3.5.2.5, figure 20-4. */
double fw_klobuchar_m(const fw_klobuchar *k, const fw_sight *s);

/* The same as BeiDou has it: a thin shell at 375 km, geographic latitude of the pierce point, its own period limits;
 * slant delay on B1I. Source: BDS-SIS-ICD-B1I-3.0, 5.2.4.7. */
double fw_klobuchar_beidou_m(const fw_klobuchar *k, const fw_sight *s);

/* How much longer a slant path through the ionosphere is than the vertical one: a thin shell at height_m.
 * 1 at the zenith, about 2.7 at the horizon for 400 km. */
double fw_iono_mapping(double elevation_rad, double height_m);

/* Zenith delays of the troposphere. */
typedef struct {
	double dry_m, wet_m;
} fw_zenith_delay;

/* Saastamoinen's zenith delays in the standard atmosphere (1013.25 hPa and 15 C at sea level).
 *   height_m  above sea level; brought to 0..10,000
 *   humidity  0..1 at all heights
 * Source: J. Saastamoinen, "Atmospheric correction for the troposphere and stratosphere in radio ranging of satellites"
 * (1972), with the constants of RTKLIB manual 2.4.2, E.5 (1). */
fw_zenith_delay fw_saastamoinen(double lat_rad, double height_m, double humidity);

/* The zenith delays of the SBAS receiver standard: seasonal averages by latitude.
 *   height_m     above sea level; brought to 0..10,000
 *   day_of_year  1..366, fractions welcome
 * Source: RTCA DO-229, A.4.2.4. */
fw_zenith_delay fw_mops_troposphere(double lat_rad, double height_m, double day_of_year);

/* How much longer a slant path through the troposphere is than the vertical one; elevations below 2 degrees are brought
 * to it. mops: one for both parts, good above 5 degrees (DO-229 A.4.2.4). niell: one for each part, good above 3 degrees;
 * source: A. E. Niell, "Global mapping functions for the atmosphere delay at radio wavelengths", JGR 101 B2 (1996). */
double fw_mops_mapping(double elevation_rad);
double fw_niell_dry(double elevation_rad, double lat_rad, double height_m, double day_of_year);
double fw_niell_wet(double elevation_rad, double lat_rad);

/* The combination of two codes (metres) on two carriers (Hz) that no first-order ionosphere is left in:
 * (f1^2 p1 - f2^2 p2) / (f1^2 - f2^2). The frequencies must differ. */
double fw_iono_free(double f1_hz, double p1_m, double f2_hz, double p2_m);

#endif
