#include "ins/gravity.h"

#include <math.h>

#include "base/frame.h"

/* NGA.STND.0036_1.0.0_WGS84, tables 3.5 and 3.6. */
#define GRAVITY_EQUATOR 9.7803253359     /* normal gravity at the equator [m/s^2] */
#define SOMIGLIANA_K    0.00193185265241 /* Somigliana's constant */
#define GRAVITY_M       0.00344978650684 /* omega^2 a^2 b / GM */

double fw_gravity_at(double sin2_lat, double height_m, double *decrease_per_m)
{
	const double s = sin2_lat, x = height_m / FW_WGS84_A;
	const double surface = GRAVITY_EQUATOR * (1 + SOMIGLIANA_K * s) / sqrt(1 - FW_WGS84_E2 * s);
	const double slope = 2 * (1 + FW_WGS84_F + GRAVITY_M - 2 * FW_WGS84_F * s);

	*decrease_per_m = surface * (slope - 6 * x) / FW_WGS84_A;
	return surface * (1 - slope * x + 3 * x * x);
}

double fw_gravity_mps2(double lat_rad, double height_m)
{
	double s = sin(lat_rad), decrease;
	return fw_gravity_at(s * s, height_m, &decrease);
}
