#include "gnss/atmosphere.h"

#include <math.h>

#include "base/frame.h"
#include "gnss/signal.h"

static double clamp(double x, double low, double high)
{
	return x < low ? low : x > high ? high : x;
}

/* c0 + c1 x + c2 x^2 + c3 x^3 */
static double cubic(const double c[4], double x)
{
	return c[0] + x * (c[1] + x * (c[2] + x * c[3]));
}

/* ---- ionosphere ---- */

double fw_klobuchar_m(const fw_klobuchar *k, const fw_sight *s)
{
	/* In semi-circles, as the document has it. */
	const double elevation = clamp(s->elevation_rad / FW_PI, 0, 0.5);
	const double psi = 0.0137 / (elevation + 0.11) - 0.022;
	const double lat = clamp(s->lat_rad / FW_PI + psi * cos(s->azimuth_rad), -0.416, 0.416);
	const double lon = s->lon_rad / FW_PI + psi * sin(s->azimuth_rad) / cos(lat * FW_PI);
	const double geomagnetic = lat + 0.064 * cos((lon - 1.617) * FW_PI);
	double t = fmod(43200 * lon + s->tow_s, 86400);
	if (t < 0)
		t += 86400;

	const double gap = 0.53 - elevation, slant = 1 + 16 * gap * gap * gap;
	const double amplitude = fmax(cubic(k->alpha, geomagnetic), 0);
	const double period = fmax(cubic(k->beta, geomagnetic), 72000);
	const double x = 2 * FW_PI * (t - 50400) / period;
	const double day = fabs(x) < 1.57 ? amplitude * (1 - x * x / 2 + x * x * x * x / 24) : 0;
	return FW_SPEED_OF_LIGHT_MPS * slant * (5e-9 + day);
}

double fw_klobuchar_beidou_m(const fw_klobuchar *k, const fw_sight *s)
{
	const double R = 6378e3, height = 375e3; /* BDS-SIS-ICD-B1I-3.0, 5.2.4.7 */
	const double q = R / (R + height) * cos(s->elevation_rad);
	const double psi = FW_PI / 2 - s->elevation_rad - asin(q);
	const double lat =
	    asin(sin(s->lat_rad) * cos(psi) + cos(s->lat_rad) * sin(psi) * cos(s->azimuth_rad));
	const double lon = s->lon_rad + asin(clamp(sin(psi) * sin(s->azimuth_rad) / cos(lat), -1, 1));
	double t = fmod(s->tow_s - 14 + lon * 43200 / FW_PI, 86400);
	if (t < 0)
		t += 86400;

	const double semicircles = fabs(lat / FW_PI);
	const double amplitude = fmax(cubic(k->alpha, semicircles), 0);
	const double period = clamp(cubic(k->beta, semicircles), 72000, 172800);
	const double day =
	    fabs(t - 50400) < period / 4 ? amplitude * cos(2 * FW_PI * (t - 50400) / period) : 0;
	return FW_SPEED_OF_LIGHT_MPS * (5e-9 + day) / sqrt(1 - q * q);
}

double fw_iono_mapping(double elevation_rad, double height_m)
{
	const double R = 6371e3, q = R / (R + height_m) * cos(elevation_rad);
	return 1 / sqrt(1 - q * q);
}

double fw_iono_free(double f1_hz, double p1_m, double f2_hz, double p2_m)
{
	const double a = f1_hz * f1_hz, b = f2_hz * f2_hz;
	return (a * p1_m - b * p2_m) / (a - b);
}

/* ---- troposphere ---- */

fw_zenith_delay fw_saastamoinen(double lat_rad, double height_m, double humidity)
{
	const double h = clamp(height_m, 0, 10000);
	const double pressure = 1013.25 * pow(1 - 2.2557e-5 * h, 5.2568);               /* hPa */
	const double T = 15 - 6.5e-3 * h + 273.16;                                      /* K */
	const double vapour = 6.108 * humidity * exp((17.15 * T - 4684) / (T - 38.45)); /* hPa */
	return (fw_zenith_delay){
	    .dry_m = 0.0022768 * pressure / (1 - 0.00266 * cos(2 * lat_rad) - 0.00028 * h / 1e3),
	    .wet_m = 0.002277 * (1255 / T + 0.05) * vapour,
	};
}

/* Where x lies between the five latitudes 15, 30, ... 75 degrees: index of the lower one and fraction of the way. */
static int between_latitudes(double lat_rad, double *fraction)
{
	const double x = clamp((fw_deg_from_rad(fabs(lat_rad)) - 15) / 15, 0, 4);
	const int i = x >= 3 ? 3 : x >= 2 ? 2 : x >= 1 ? 1 : 0;
	*fraction = x - i;
	return i;
}

static double interpolate(const double at[5], int i, double fraction)
{
	return at[i] + fraction * (at[i + 1] - at[i]);
}

/* RTCA DO-229 tables A-2: average and seasonal variation at 15, 30, 45, 60, 75 degrees of latitude. */
typedef struct {
	double average[5], variation[5];
} season;
static const season pressure_hpa = {{1013.25, 1017.25, 1015.75, 1011.75, 1013.00},
                                    {0, -3.75, -2.25, -1.75, -0.50}};
static const season temperature_k = {{299.65, 294.15, 283.15, 272.15, 263.65}, {0, 7, 11, 15, 14.5}};
static const season vapour_hpa = {{26.31, 21.79, 11.66, 6.78, 4.11}, {0, 8.85, 7.24, 5.36, 3.39}};
static const season lapse_kpm = {{6.30e-3, 6.05e-3, 5.58e-3, 5.39e-3, 4.53e-3},
                                 {0, 0.25e-3, 0.32e-3, 0.81e-3, 0.62e-3}};
static const season vapour_lapse = {{2.77, 3.15, 2.57, 1.81, 1.55}, {0, 0.33, 0.46, 0.74, 0.30}};

fw_zenith_delay fw_mops_troposphere(double lat_rad, double height_m, double day_of_year)
{
	const double k1 = 77.604, k2 = 382000, Rd = 287.054, gm = 9.784, g = 9.80665; /* DO-229 A.4.2.4 */
	const double H = clamp(height_m, 0, 10000);
	const double winter = cos(2 * FW_PI * (day_of_year - (lat_rad >= 0 ? 28 : 211)) / 365.25);
	double f;
	const int i = between_latitudes(lat_rad, &f);
#define NOW(table) (interpolate((table).average, i, f) - interpolate((table).variation, i, f) * winter)
	const double P = NOW(pressure_hpa), T = NOW(temperature_k), e = NOW(vapour_hpa);
	const double beta = NOW(lapse_kpm), lambda = NOW(vapour_lapse);
#undef NOW
	const double dry = 1e-6 * k1 * Rd * P / gm;
	const double wet = 1e-6 * k2 * Rd / (gm * (lambda + 1) - beta * Rd) * e / T;
	const double cooler = 1 - beta * H / T;
	return (fw_zenith_delay){
	    .dry_m = dry * pow(cooler, g / (Rd * beta)),
	    .wet_m = wet * pow(cooler, (lambda + 1) * g / (Rd * beta) - 1),
	};
}

static double floor_elevation(double elevation_rad)
{
	return fmax(elevation_rad, fw_rad_from_deg(2));
}

double fw_mops_mapping(double elevation_rad)
{
	const double elevation = floor_elevation(elevation_rad), s = sin(elevation);
	const double below_4 = fmax(4 - fw_deg_from_rad(elevation), 0);
	return 1.001 / sqrt(0.002001 + s * s) * (1 + 0.015 * below_4 * below_4);
}

/* Marini's continued fraction, 1 at the zenith. */
static double marini(double sine, double a, double b, double c)
{
	return (1 + a / (1 + b / (1 + c))) / (sine + a / (sine + b / (sine + c)));
}

/* Niell (1996), tables 3 and 4, at 15, 30, 45, 60, 75 degrees. */
static const double niell_dry[3][5] = {
    {1.2769934e-3, 1.2683230e-3, 1.2465397e-3, 1.2196049e-3, 1.2045996e-3},
    {2.9153695e-3, 2.9152299e-3, 2.9288445e-3, 2.9022565e-3, 2.9024912e-3},
    {62.610505e-3, 62.837393e-3, 63.721774e-3, 63.824265e-3, 64.258455e-3}};
static const double niell_dry_season[3][5] = {{0, 1.2709626e-5, 2.6523662e-5, 3.4000452e-5, 4.1202191e-5},
                                              {0, 2.1414979e-5, 3.0160779e-5, 7.2562722e-5, 11.723375e-5},
                                              {0, 9.0128400e-5, 4.3497037e-5, 84.795348e-5, 170.37206e-5}};
static const double niell_wet[3][5] = {
    {5.8021897e-4, 5.6794847e-4, 5.8118019e-4, 5.9727542e-4, 6.1641693e-4},
    {1.4275268e-3, 1.5138625e-3, 1.4572752e-3, 1.5007428e-3, 1.7599082e-3},
    {4.3472961e-2, 4.6729510e-2, 4.3908931e-2, 4.4626982e-2, 5.4736038e-2}};

double fw_niell_dry(double elevation_rad, double lat_rad, double height_m, double day_of_year)
{
	const double sine = sin(floor_elevation(elevation_rad));
	const double winter = cos(2 * FW_PI * (day_of_year - 28) / 365.25 + (lat_rad >= 0 ? 0 : FW_PI));
	double f, c[3];
	const int i = between_latitudes(lat_rad, &f);
	for (int j = 0; j < 3; j++)
		c[j] = interpolate(niell_dry[j], i, f) - interpolate(niell_dry_season[j], i, f) * winter;
	const double higher = 1 / sine - marini(sine, 2.53e-5, 5.49e-3, 1.14e-3); /* per km of height */
	return marini(sine, c[0], c[1], c[2]) + higher * height_m / 1e3;
}

double fw_niell_wet(double elevation_rad, double lat_rad)
{
	const double sine = sin(floor_elevation(elevation_rad));
	double f, c[3];
	const int i = between_latitudes(lat_rad, &f);
	for (int j = 0; j < 3; j++)
		c[j] = interpolate(niell_wet[j], i, f);
	return marini(sine, c[0], c[1], c[2]);
}
