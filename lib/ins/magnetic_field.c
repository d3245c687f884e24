#include "ins/magnetic_field.h"

#include <math.h>
#include <stdbool.h>

#include "base/frame.h"
#include "ins/wmm_table.h"

#define REFERENCE_RADIUS_M 6371200.0 /* of the model */

/* Geocentric latitude and distance of a place. */
struct geocentric {
	double sine, cosine, radius_m;
};

static struct geocentric to_geocentric(double lat, double height)
{
	double s = sin(lat), n = FW_WGS84_A / sqrt(1 - FW_WGS84_E2 * s * s);
	double axis = (n + height) * cos(lat), polar = (n * (1 - FW_WGS84_E2) + height) * s;
	double radius = hypot(axis, polar);

	return (struct geocentric){polar / radius, axis / radius, radius};
}

static bool decimal_year(fw_time t, double *year)
{
	fw_civil c;
	int day, length;

	if (fw_time_to_civil(t, &c) < 0 || fw_civil_day_of_year(&c, &day) < 0)
		return false;
	length = c.year % 4 == 0 && (c.year % 100 != 0 || c.year % 400 == 0) ? 366 : 365;
	*year = c.year + (day - 1 + (c.hour * 3600 + c.minute * 60 + c.second) / 86400.0) / length;
	return true;
}

/* Adds the terms of order m to the field, {north, east, down} of the sphere. P and slope are Schmidt's functions of the
 * sine of latitude and their derivatives with latitude, by recursion in n; they begin with those of n = m. For m > 0
 * both P and the eastward terms have the factor cosine, so over_cosine carries P without it: no place is singular. */
static void add_order(int m, const struct geocentric *at, double lon, double years, double P, double slope,
                      double over_cosine, double field[3])
{
	double P_before = 0, slope_before = 0, over_before = 0, root_before = 0;
	double c = cos(m * lon), s = sin(m * lon);
	double ratio = REFERENCE_RADIUS_M / at->radius_m, power = pow(ratio, m + 2);

	for (int n = m; n <= WMM_DEGREE; n++) {
		if (n > 0) {
			const struct wmm_term *k = &wmm_terms[n * (n + 1) / 2 + m - 1];
			double g = k->g + k->g_per_year * years, h = k->h + k->h_per_year * years;

			field[0] -= power * (g * c + h * s) * slope;
			field[1] += power * m * (g * s - h * c) * over_cosine;
			field[2] -= power * (n + 1) * (g * c + h * s) * P;
		}
		double root = sqrt((n + 1) * (n + 1) - m * m);
		double P_next = ((2 * n + 1) * at->sine * P - root_before * P_before) / root;
		double slope_next =
		    ((2 * n + 1) * (at->sine * slope + at->cosine * P) - root_before * slope_before) / root;
		double over_next = ((2 * n + 1) * at->sine * over_cosine - root_before * over_before) / root;

		P_before = P, slope_before = slope, over_before = over_cosine, root_before = root;
		P = P_next, slope = slope_next, over_cosine = over_next;
		power *= ratio;
	}
}

fw_status fw_magnetic_field(const double llh[static 3], fw_time t, double field_ned_nt[static 3])
{
	double year, P = 1, slope = 0, over_cosine = 0, field[3] = {0}, tilt_s, tilt_c;
	struct geocentric at;

	if (!isfinite(llh[0] + llh[1] + llh[2]))
		return FW_ENONFINITE;
	if (!(fabs(llh[0]) <= FW_PI / 2 && llh[2] >= -10e3 && llh[2] <= 1000e3) || !decimal_year(t, &year))
		return FW_ERANGE;
	at = to_geocentric(llh[0], llh[2]);
	for (int m = 0; m <= WMM_DEGREE; m++) {
		add_order(m, &at, llh[1], year - WMM_EPOCH, P, slope, over_cosine, field);
		/* P of n = m + 1 = order: sqrt(1 - 1 / (2 n)) cosine times the last one, without the root for n = 1. */
		double factor = m == 0 ? 1 : sqrt(1 - 1 / (2.0 * (m + 1)));

		slope = factor * (at.cosine * slope - at.sine * P);
		over_cosine = factor * P;
		P = factor * at.cosine * P;
	}
	/* From the sphere's normal to the ellipsoid's: geocentric minus geodetic latitude. */
	tilt_s = at.sine * cos(llh[0]) - at.cosine * sin(llh[0]);
	tilt_c = at.cosine * cos(llh[0]) + at.sine * sin(llh[0]);
	field_ned_nt[0] = field[0] * tilt_c - field[2] * tilt_s;
	field_ned_nt[1] = field[1];
	field_ned_nt[2] = field[0] * tilt_s + field[2] * tilt_c;
	return year >= WMM_EPOCH && year < WMM_END ? FW_OK : FW_DUBIOUS;
}
