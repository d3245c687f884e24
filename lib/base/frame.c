#include "base/frame.h"

#include <math.h>
#include <stdbool.h>

#include "base/matrix.h"

static bool all_finite(const double v[static 3])
{
	return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

double fw_wrap_pi(double angle)
{
	return remainder(angle, 2 * FW_PI);
}

double fw_wrap_2pi(double angle)
{
	double r = fmod(angle, 2 * FW_PI);

	if (r < 0)
		r += 2 * FW_PI;
	return r == 2 * FW_PI ? 0 : r; /* a tiny negative angle rounds up to the full turn */
}

/* ---- positions ----
 *
 * In long double: at 1.6e7 m from the centre a unit in the last place of a double is 1.9e-9 m, and the
 * handful of roundings of either direction would eat the 5e-9 m that the header promises. */

#define A  6378137.0L
#define F  (1 / 298.257223563L)
#define E2 (F * (2 - F))
#define E4 (E2 * E2)

/* The prime vertical's radius of curvature [m]. */
static long double normal_radius(long double sin_lat)
{
	return A / sqrtl(1 - E2 * sin_lat * sin_lat);
}

fw_status fw_llh_to_ecef(const double llh[static 3], double ecef[static 3])
{
	long double lat = (long double)llh[0], lon = (long double)llh[1], h = (long double)llh[2];
	long double s, c, N;

	if (!all_finite(llh))
		return FW_ENONFINITE;
	if (!(fabs(llh[0]) <= FW_PI / 2 && fabs(llh[2]) <= FW_FRAME_FAR_M))
		return FW_ERANGE;
	s = sinl(lat);
	c = cosl(lat);
	N = normal_radius(s);
	ecef[0] = (double)((N + h) * c * cosl(lon));
	ecef[1] = (double)((N + h) * c * sinl(lon));
	ecef[2] = (double)((N * (1 - E2) + h) * s);
	return FW_OK;
}

/* The real root u of Vermeille's cubic, with S = E4 p q / 4. */
static long double cubic_root(long double S, long double r)
{
	long double r3 = r * r * r;
	long double disc = S * (2 * r3 + S);
	long double T3, T;

	if (disc < 0) /* three real roots, r < 0: the one that keeps u large */
		return r + 2 * r * cosl(atan2l(sqrtl(-disc), -(S + r3)) / 3);
	T3 = S + r3;
	T = cbrtl(T3 + copysignl(sqrtl(disc), T3)); /* the sign that does not cancel */
	return r + T + (T != 0 ? r * r / T : 0);
}

/* Latitude and height of a point at distance R from the axis and z above the equator. */
static void meridian_to_geodetic(long double R, long double z, double *lat, double *height)
{
	long double p = (R / A) * (R / A);
	long double q = (1 - E2) * (z / A) * (z / A);
	long double r = (p + q - E4) / 6;
	long double u, v, uv, w, k, s, c, norm, N;

	if (q == 0 && r <= 0) { /* the equatorial disc inside the evolute: the normals come from two sides */
		s = sqrtl((E4 - p) / (1 - E2));
		c = sqrtl(p);
		*lat = (double)copysignl(atan2l(s, c), z);
		*height = (double)(-A * (1 - E2) * hypotl(s, c) / E2);
		return;
	}
	u = cubic_root(E4 * p * q / 4, r);
	v = sqrtl(u * u + E4 * q);
	uv = u < 0 ? E4 * q / (v - u) : u + v; /* u + v without cancellation */
	w = fmaxl(0, E2 * (uv - q) / (2 * v));
	k = uv / (sqrtl(uv + w * w) + w);
	s = z * (k + E2);
	c = R * k;
	norm = hypotl(s, c);
	s /= norm;
	c /= norm;
	N = normal_radius(s);
	*lat = (double)atan2l(s, c);
	*height =
	    (double)((R - N * c) * c + (z - N * (1 - E2) * s) * s); /* hardly depends on an error of s, c */
}

fw_status fw_ecef_to_llh(const double ecef[static 3], double llh[static 3])
{
	long double x = (long double)ecef[0], y = (long double)ecef[1], z = (long double)ecef[2];
	long double R = hypotl(x, y);

	if (!all_finite(ecef))
		return FW_ENONFINITE;
	if (!((double)hypotl(R, z) <= FW_FRAME_FAR_M))
		return FW_ERANGE;
	meridian_to_geodetic(R, z, &llh[0], &llh[2]);
	llh[1] = R > 0 ? (double)atan2l(y, x) : 0;
	return FW_OK;
}

/* Unit vectors of north, east and up in ECEF. */
static void local_axes(double lat, double lon, double north[static 3], double east[static 3],
                       double up[static 3])
{
	double sp = sin(lat), cp = cos(lat), sl = sin(lon), cl = cos(lon);

	north[0] = -sp * cl;
	north[1] = -sp * sl;
	north[2] = cp;
	east[0] = -sl;
	east[1] = cl;
	east[2] = 0;
	up[0] = cp * cl;
	up[1] = cp * sl;
	up[2] = sp;
}

void fw_frame_ned(double lat_rad, double lon_rad, double C_e_n[static 3][3])
{
	double north[3], east[3], up[3];

	local_axes(lat_rad, lon_rad, north, east, up);
	for (int i = 0; i < 3; i++) {
		C_e_n[i][0] = north[i];
		C_e_n[i][1] = east[i];
		C_e_n[i][2] = -up[i];
	}
}

void fw_frame_enu(double lat_rad, double lon_rad, double C_e_u[static 3][3])
{
	double north[3], east[3], up[3];

	local_axes(lat_rad, lon_rad, north, east, up);
	for (int i = 0; i < 3; i++) {
		C_e_u[i][0] = east[i];
		C_e_u[i][1] = north[i];
		C_e_u[i][2] = up[i];
	}
}

fw_status fw_baseline_enu(const double origin_e[static 3], const double point_e[static 3],
                          double enu[static 3])
{
	double llh[3], C_e_u[3][3], baseline[3];
	fw_status status = fw_ecef_to_llh(origin_e, llh);

	if (status < 0)
		return status;
	if (!all_finite(point_e))
		return FW_ENONFINITE;
	for (int i = 0; i < 3; i++) {
		if (!(fabs(point_e[i]) <= FW_FRAME_FAR_M))
			return FW_ERANGE;
		baseline[i] = point_e[i] - origin_e[i];
	}
	fw_frame_enu(llh[0], llh[1], C_e_u);
	fw_mat3_t_vec(C_e_u, baseline, enu);
	return FW_OK;
}

fw_status fw_azimuth_elevation(const double enu[static 3], double *azimuth, double *elevation)
{
	double level = hypot(enu[0], enu[1]);

	if (!all_finite(enu))
		return FW_ENONFINITE;
	if (level == 0 && enu[2] == 0)
		return FW_EINVAL;
	*azimuth = level > 0 ? fw_wrap_2pi(atan2(enu[0], enu[1])) : 0;
	*elevation = atan2(enu[2], level);
	return FW_OK;
}

/* ---- rotations ---- */

void fw_euler_to_matrix(const double rpy[static 3], double C_n_b[static 3][3])
{
	double sr = sin(rpy[0]), cr = cos(rpy[0]);
	double sp = sin(rpy[1]), cp = cos(rpy[1]);
	double sh = sin(rpy[2]), ch = cos(rpy[2]);

	C_n_b[0][0] = ch * cp;
	C_n_b[0][1] = ch * sp * sr - sh * cr;
	C_n_b[0][2] = ch * sp * cr + sh * sr;
	C_n_b[1][0] = sh * cp;
	C_n_b[1][1] = sh * sp * sr + ch * cr;
	C_n_b[1][2] = sh * sp * cr - ch * sr;
	C_n_b[2][0] = -sp;
	C_n_b[2][1] = cp * sr;
	C_n_b[2][2] = cp * cr;
}

void fw_euler_to_quat(const double rpy[static 3], double q_n_b[static 4])
{
	double sr = sin(rpy[0] / 2), cr = cos(rpy[0] / 2);
	double sp = sin(rpy[1] / 2), cp = cos(rpy[1] / 2);
	double sh = sin(rpy[2] / 2), ch = cos(rpy[2] / 2);

	q_n_b[0] = ch * cp * cr + sh * sp * sr;
	q_n_b[1] = ch * cp * sr - sh * sp * cr;
	q_n_b[2] = ch * sp * cr + sh * cp * sr;
	q_n_b[3] = sh * cp * cr - ch * sp * sr;
}

/* Heading is read from the matrix with the roll taken out again, C Rx(-roll) = Rz Ry, whose second column is
 * {-sin h, cos h, 0} whatever the pitch: no threshold near the vertical. */
void fw_matrix_to_euler(const double C_n_b[static 3][3], double rpy[static 3])
{
	double level = hypot(C_n_b[2][1], C_n_b[2][2]);
	double roll = level > 0 ? atan2(C_n_b[2][1], C_n_b[2][2]) : 0;
	double s = sin(roll), c = cos(roll);

	rpy[0] = roll;
	rpy[1] = atan2(-C_n_b[2][0], level);
	rpy[2] = fw_wrap_2pi(atan2(s * C_n_b[0][2] - c * C_n_b[0][1], c * C_n_b[1][1] - s * C_n_b[1][2]));
}

void fw_quat_to_euler(const double q_n_b[static 4], double rpy[static 3])
{
	double C_n_b[3][3];

	fw_quat_to_matrix(q_n_b, C_n_b);
	fw_matrix_to_euler(C_n_b, rpy);
}

void fw_quat_to_matrix(const double q[static 4], double C[static 3][3])
{
	double w = q[0], x = q[1], y = q[2], z = q[3];

	C[0][0] = w * w + x * x - y * y - z * z;
	C[0][1] = 2 * (x * y - w * z);
	C[0][2] = 2 * (x * z + w * y);
	C[1][0] = 2 * (x * y + w * z);
	C[1][1] = w * w - x * x + y * y - z * z;
	C[1][2] = 2 * (y * z - w * x);
	C[2][0] = 2 * (x * z - w * y);
	C[2][1] = 2 * (y * z + w * x);
	C[2][2] = w * w - x * x - y * y + z * z;
}

/* 4 q q^T can be read off the matrix; its row with the largest diagonal element is q times a factor. */
void fw_quat_from_matrix(const double C[static 3][3], double q[static 4])
{
	double trace = C[0][0] + C[1][1] + C[2][2];
	double wx = C[2][1] - C[1][2], wy = C[0][2] - C[2][0], wz = C[1][0] - C[0][1];
	double xy = C[0][1] + C[1][0], xz = C[0][2] + C[2][0], yz = C[1][2] + C[2][1];
	const double rows[4][4] = {
	    {1 + trace, wx, wy, wz},
	    {wx, 1 + 2 * C[0][0] - trace, xy, xz},
	    {wy, xy, 1 + 2 * C[1][1] - trace, yz},
	    {wz, xz, yz, 1 + 2 * C[2][2] - trace},
	};
	int best = 0;
	double norm;

	for (int i = 1; i < 4; i++)
		if (rows[i][i] > rows[best][best])
			best = i;
	norm = sqrt(rows[best][0] * rows[best][0] + rows[best][1] * rows[best][1] +
	            rows[best][2] * rows[best][2] + rows[best][3] * rows[best][3]);
	norm = copysign(norm, rows[best][0]);
	for (int i = 0; i < 4; i++)
		q[i] = rows[best][i] / norm;
}

void fw_quat_mul(const double p[static 4], const double q[static 4], double r[static 4])
{
	r[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
	r[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
	r[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1];
	r[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0];
}

fw_status fw_quat_normalise(double q[static 4])
{
	double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);

	if (!(norm > 0 && isfinite(norm)))
		return FW_ESINGULAR;
	for (int i = 0; i < 4; i++)
		q[i] /= norm;
	return FW_OK;
}

void fw_quat_from_rotvec(const double v[static 3], double q[static 4])
{
	double half = 0.5 * sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
	double scale = half > 0 ? 0.5 * sin(half) / half : 0.5; /* sin(x)/x is accurate for every x but 0 */

	q[0] = cos(half);
	for (int i = 0; i < 3; i++)
		q[i + 1] = scale * v[i];
}

void fw_skew(const double v[static 3], double S[static 3][3])
{
	S[0][0] = S[1][1] = S[2][2] = 0;
	S[0][1] = -v[2];
	S[0][2] = v[1];
	S[1][0] = v[2];
	S[1][2] = -v[0];
	S[2][0] = -v[1];
	S[2][1] = v[0];
}
