/* Frames and rotations.
 *
 * Frames, as the letters of the names have them:
 *   e  ECEF, Earth-centred Earth-fixed, WGS84: x to the Greenwich meridian, z to the north pole [m]
 *   n  NED at a geodetic point: north, east, down along the ellipsoid's normal
 *   u  ENU at a geodetic point: east, north, up
 *   b  body FRD: forward, right, down
 * A rotation C_n_b takes body coordinates to navigation coordinates, x_n = C_n_b x_b, and q_n_b is the
 * quaternion of the same rotation. llh is latitude [rad], longitude [rad], height above the ellipsoid [m].
 * Quaternions are Hamilton's, {w, x, y, z}, of norm 1. Angles are radians; degrees live at the edges only.
 *
 * Outputs are untouched when a function fails (status < 0). No output may be one of the inputs. */
#ifndef FURROW_BASE_FRAME_H
#define FURROW_BASE_FRAME_H

#include "base/status.h"

/* WGS84 ellipsoid (NGA.STND.0036_1.0.0_WGS84, tables 3.1 and 3.2). */
#define FW_WGS84_A  6378137.0                       /* semi-major axis [m] */
#define FW_WGS84_F  (1 / 298.257223563)             /* flattening */
#define FW_WGS84_E2 (FW_WGS84_F * (2 - FW_WGS84_F)) /* first eccentricity squared */

/* Beyond this height or distance from the centre [m] the conversions answer FW_ERANGE. */
#define FW_FRAME_FAR_M 1e12

#define FW_PI 3.14159265358979323846

static inline double fw_rad_from_deg(double deg)
{
	return deg * (FW_PI / 180);
}

static inline double fw_deg_from_rad(double rad)
{
	return rad * (180 / FW_PI);
}

/* An angle [rad] brought to -pi..pi, or to 0 <= angle < 2 pi. NaN and infinity give NaN. */
double fw_wrap_pi(double angle);
double fw_wrap_2pi(double angle);

/* ---- positions ---- */

/* Geodetic to Earth-centred Earth-fixed position.
 *   llh   in   latitude -pi/2..pi/2, any longitude, |height| <= FW_FRAME_FAR_M
 *   ecef  out  x, y, z [m]
 * Returns FW_OK; FW_ENONFINITE; FW_ERANGE. */
fw_status fw_llh_to_ecef(const double llh[static 3], double ecef[static 3]) FW_MUST_CHECK;

/* Earth-centred Earth-fixed to geodetic position, everywhere, the interior of the Earth included: of the
 * points on the ellipsoid whose normal passes through ecef, the nearest is taken. At the poles and on the
 * axis the longitude is 0; the centre is below the north pole (latitude pi/2, height -b); elsewhere -pi <=
 * longitude <= pi. There and back through fw_llh_to_ecef is within 5e-9 m for |height| < 1e7 m (1e-8 m where
 * long double is no wider than double).
 * Returns FW_OK; FW_ENONFINITE; FW_ERANGE (beyond FW_FRAME_FAR_M).
 * Source: H. Vermeille, "Direct transformation from geocentric coordinates to geodetic coordinates", J.
 * Geodesy 76 (2002), in the form of C. F. F. Karney, "Geodesics on an ellipsoid of revolution",
 * arXiv:1102.1215 (2011), appendix B, which holds inside the evolute too. */
fw_status fw_ecef_to_llh(const double ecef[static 3], double llh[static 3]) FW_MUST_CHECK;

/* Rotation from the local frame at a geodetic latitude and longitude to ECEF: x_e = C_e_n x_n (NED), and
 * x_e = C_e_u x_u (ENU). The way back is fw_mat3_t_vec(C, x_e, x_local). */
void fw_frame_ned(double lat_rad, double lon_rad, double C_e_n[static 3][3]);
void fw_frame_enu(double lat_rad, double lon_rad, double C_e_u[static 3][3]);

/* Baseline from an origin to a point, both ECEF [m], as east, north, up [m] at the origin.
 * Returns FW_OK; FW_ENONFINITE; FW_ERANGE (origin or point beyond FW_FRAME_FAR_M). */
fw_status fw_baseline_enu(const double origin_e[static 3], const double point_e[static 3],
                          double enu[static 3]) FW_MUST_CHECK;

/* Direction of a vector in ENU: azimuth clockwise from north, 0 <= azimuth < 2 pi, and elevation above the
 * horizon, -pi/2..pi/2. Straight up or down the azimuth is 0.
 * Returns FW_OK; FW_ENONFINITE; FW_EINVAL (the vector is zero). */
fw_status fw_azimuth_elevation(const double enu[static 3], double *azimuth, double *elevation) FW_MUST_CHECK;

/* ---- rotations ---- */

/* Euler angles Z-Y-X, {roll, pitch, heading}: the body turned from NED by heading about down, then by pitch
 * about the new right, then by roll about the new forward axis. C_n_b = Rz(heading) Ry(pitch) Rx(roll). */
void fw_euler_to_matrix(const double rpy[static 3], double C_n_b[static 3][3]);
void fw_euler_to_quat(const double rpy[static 3], double q_n_b[static 4]);

/* The way back: -pi <= roll <= pi, -pi/2 <= pitch <= pi/2, 0 <= heading < 2 pi. With the nose straight up or
 * down only the sum or difference of roll and heading is defined; the pair returned still gives the same
 * rotation. */
void fw_matrix_to_euler(const double C_n_b[static 3][3], double rpy[static 3]);
void fw_quat_to_euler(const double q_n_b[static 4], double rpy[static 3]);

/* Quaternion and matrix of the same rotation. From the matrix, w >= 0 and the norm is 1.
 * Source: F. L. Markley, "Unit quaternion from rotation matrix", J. Guidance 31 (2008). */
void fw_quat_to_matrix(const double q[static 4], double C[static 3][3]);
void fw_quat_from_matrix(const double C[static 3][3], double q[static 4]);

/* r = p q: the rotation q, then p; q_n_c = q_n_b q_b_c. */
void fw_quat_mul(const double p[static 4], const double q[static 4], double r[static 4]);

/* q scaled to norm 1, in place. Returns FW_OK; FW_ESINGULAR (norm zero, infinite or NaN): q untouched. */
fw_status fw_quat_normalise(double q[static 4]) FW_MUST_CHECK;

/* Rotation vector (axis times angle [rad]) to quaternion, accurate down to angle zero. */
void fw_quat_from_rotvec(const double v[static 3], double q[static 4]);

/* S x = v cross x */
void fw_skew(const double v[static 3], double S[static 3][3]);

#endif
