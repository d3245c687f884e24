#include "ins/gravity.h"

#include <math.h>

#include "base/frame.h"

/* NGA.STND.0036_1.0.0_WGS84, tables 3.5 and 3.6. */
#define GRAVITY_EQUATOR 9.7803253359     /* normal gravity at the equator [m/s^2] */
#define SOMIGLIANA_K    0.00193185265241 /* Somigliana's constant */
#define GRAVITY_M       0.00344978650684 /* omega^2 a^2 b / GM */

double fw_gravity_mps2(double lat_rad, double height_m)
{
	double s = sin(lat_rad) * sin(lat_rad), x = height_m / FW_WGS84_A;
	double surface = GRAVITY_EQUATOR * (1 + SOMIGLIANA_K * s) / sqrt(1 - FW_WGS84_E2 * s);

	return surface * (1 - 2 * (1 + FW_WGS84_F + GRAVITY_M - 2 * FW_WGS84_F * s) * x + 3 * x * x);
}
