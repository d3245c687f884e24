/* frame: expected positions from mpmath (40 digits; PROJ's cart agrees to 3e-9 m) and attitudes from scipy's
 * Rotation; the rest are round trips and definitions. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "base/random.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

/* What the header promises below a height of 1e7 m. */
#define CLOSE_M (LDBL_MANT_DIG > DBL_MANT_DIG ? 5e-9 : 1e-8)

static void assert_near(int count, const double *actual, const double *expected, double tolerance)
{
	for (int i = 0; i < count; i++)
		if (!(fabs(actual[i] - expected[i]) <= tolerance))
			fail_msg("element %d: %.17g is not %.17g", i, actual[i], expected[i]);
}

static double distance(const double a[static 3], const double b[static 3])
{
	return sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
}

static double between(fw_random *r, double low, double high)
{
	return low + (high - low) * fw_random_uniform(r);
}

static void angles_wrap(void **state)
{
	(void)state;
	assert_true(fw_wrap_pi(0.5) == 0.5 && fw_wrap_pi(-3) == -3);
	assert_true(fabs(fw_wrap_pi(4) - (4 - 2 * FW_PI)) < 1e-15);
	assert_true(fabs(fw_wrap_pi(-4 - 20 * FW_PI) - (2 * FW_PI - 4)) < 1e-14);
	assert_true(fw_wrap_2pi(0) == 0 && fw_wrap_2pi(6) == 6 && fw_wrap_2pi(2 * FW_PI) == 0);
	assert_true(fabs(fw_wrap_2pi(-1) - (2 * FW_PI - 1)) < 1e-15);
	assert_true(fw_wrap_2pi(-1e-300) == 0);
	assert_true(isnan(fw_wrap_pi(nan(""))) && isnan(fw_wrap_2pi(nan(""))) &&
	            isnan(fw_wrap_2pi(HUGE_VAL)));
	assert_true(fw_rad_from_deg(180) == FW_PI && fw_deg_from_rad(FW_PI / 2) == 90);
}

/* ---- positions ---- */

static const struct {
	double lat_deg, lon_deg, h, ecef[3];
} positions[] = {
    {0, 0, 0, {6378137.0, 0, 0}},
    {90, 0, 0, {0, 0, 6356752.3142451795}},
    {-90, 0, 100, {0, 0, -6356852.3142451795}},
    {37.4, -5.9, 50, {5046319.5576873344, -521486.39759273314, 3852783.4570721207}},
    {53.344, -2.247, 127.25, {3813177.8385266035, -149620.19998761814, 5093593.3039721311}},
    {-33.8568, 151.2153, 4.2, {-4646971.6942079382, 2553078.5996313851, -3533269.4673906253}},
    {0, 180, -1000, {-6377137.0, 0, 0}},
    {45, 90, 20200000, {0, 18801147.858817191, 18770905.38883418}},
    {89.999999, 123.456, 8848.86, {-0.0616616368066132, 0.09331619275733875, 6365601.1742451785}},
    {1e-09, -75, -5000, {1649489.2326475439, -6155977.6227784338, 0.00011048700935899465}},
};

static void llh_to_ecef_is_right(void **state)
{
	(void)state;
	for (size_t i = 0; i < COUNT(positions); i++) {
		double llh[3] = {fw_rad_from_deg(positions[i].lat_deg), fw_rad_from_deg(positions[i].lon_deg),
		                 positions[i].h};
		double ecef[3];

		assert_int_equal(fw_llh_to_ecef(llh, ecef), FW_OK);
		assert_near(3, ecef, positions[i].ecef, CLOSE_M);
	}
}

static void ecef_to_llh_is_right(void **state)
{
	(void)state;
	for (size_t i = 0; i < COUNT(positions); i++) {
		double llh[3];
		double r = 6.4e6 + fabs(positions[i].h);

		assert_int_equal(fw_ecef_to_llh(positions[i].ecef, llh), FW_OK);
		assert_true(fabs(llh[0] - fw_rad_from_deg(positions[i].lat_deg)) * r < 5e-9);
		assert_true(fabs(llh[1] - fw_rad_from_deg(positions[i].lon_deg)) * r * cos(llh[0]) < 5e-9);
		assert_true(fabs(llh[2] - positions[i].h) < 5e-9);
	}
}

/* Above the Earth: every coordinate comes back. */
static void geodetic_round_trip(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 11);
	for (int i = 0; i < 100000; i++) {
		double llh[3] = {asin(between(&r, -1, 1)), between(&r, -FW_PI, FW_PI),
		                 between(&r, -6e6, 1e7)};
		double ecef[3], back[3], error[3];

		if (i % 2)
			llh[2] /= 1000; /* where farms are */
		assert_int_equal(fw_llh_to_ecef(llh, ecef), FW_OK);
		assert_int_equal(fw_ecef_to_llh(ecef, back), FW_OK);
		error[0] = (back[0] - llh[0]) * (6.4e6 + llh[2]);
		error[1] = (back[1] - llh[1]) * (6.4e6 + llh[2]) * cos(llh[0]);
		error[2] = back[2] - llh[2];
		assert_true(distance(error, (double[3]){0, 0, 0}) < CLOSE_M);
	}
}

/* Everywhere, the Earth's interior and beyond its centre included: the point comes back. */
static void cartesian_round_trip(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 12);
	for (int i = 0; i < 100000; i++) {
		static const double scale[] = {1.6e7, 6.4e6, 60e3, 1};
		double s = scale[i % 4];
		double ecef[3] = {between(&r, -s, s), between(&r, -s, s), between(&r, -s, s)};
		double llh[3], back[3];

		if (i % 5 == 0)
			ecef[2] *= 1e-9;
		if (distance(ecef, (double[3]){0, 0, 0}) > 1.63e7)
			continue;
		assert_int_equal(fw_ecef_to_llh(ecef, llh), FW_OK);
		assert_int_equal(fw_llh_to_ecef(llh, back), FW_OK);
		assert_true(distance(ecef, back) < CLOSE_M);
	}
}

static void assert_llh(double x, double y, double z, double lat, double lon, double h)
{
	double llh[3];
	const double expected[3] = {lat, lon, h};

	assert_int_equal(fw_ecef_to_llh((double[3]){x, y, z}, llh), FW_OK);
	assert_near(2, llh, expected, 1e-15);
	assert_true(fabs(llh[2] - h) < 1e-9);
}

/* On the axis the nearer pole is the foot. In the equatorial plane, closer to the centre than a e^2 = 42.7
 * km, two feet are equally near, and the sign of z chooses: foot for R = 30 km by minimising the distance in
 * mpmath. */
static void axis_and_centre_are_defined(void **state)
{
	const double b = 6356752.3142451795;

	(void)state;
	assert_llh(0, 0, b + 10, FW_PI / 2, 0, 10);
	assert_llh(0, 0, -b + 10, -FW_PI / 2, 0, -10);
	assert_llh(-0.0, -0.0, 1000, FW_PI / 2, 0, 1000 - b);
	assert_llh(0, 0, -1e-300, -FW_PI / 2, 0, -b);
	assert_llh(0, 0, 0, FW_PI / 2, 0, -b);
	assert_llh(6378137, -0.0, 0, 0, 0, 0);
	assert_llh(-6378137, 0, 0, 0, FW_PI, 0);
	assert_llh(0, 30000, 0, 0.79341037586391899, FW_PI / 2, -6346239.741471599);
	assert_llh(0, 30000, -0.0, -0.79341037586391899, FW_PI / 2, -6346239.741471599);
}

static void positions_refuse_what_is_no_position(void **state)
{
	double out[3] = {7, 7, 7};
	static const double sevens[3] = {7, 7, 7};

	(void)state;
	assert_int_equal(fw_llh_to_ecef((double[3]){nan(""), 0, 0}, out), FW_ENONFINITE);
	assert_int_equal(fw_llh_to_ecef((double[3]){0, HUGE_VAL, 0}, out), FW_ENONFINITE);
	assert_int_equal(fw_llh_to_ecef((double[3]){1.5708, 0, 0}, out), FW_ERANGE);
	assert_int_equal(fw_llh_to_ecef((double[3]){0, 0, -2e12}, out), FW_ERANGE);
	assert_int_equal(fw_ecef_to_llh((double[3]){0, 0, nan("")}, out), FW_ENONFINITE);
	assert_int_equal(fw_ecef_to_llh((double[3]){-HUGE_VAL, 0, 0}, out), FW_ENONFINITE);
	assert_int_equal(fw_ecef_to_llh((double[3]){1e12, 1e12, 0}, out), FW_ERANGE);
	assert_int_equal(fw_ecef_to_llh((double[3]){1e308, 1e308, 1e308}, out), FW_ERANGE);
	assert_near(3, out, sevens, 0);
}

/* ---- local frames ---- */

/* At 0 N 90 E east is -x, north is z, up is y. */
static void local_axes_by_hand(void **state)
{
	static const double ned[9] = {0, -1, 0, 0, 0, -1, 1, 0, 0};
	static const double enu[9] = {-1, 0, 0, 0, 0, 1, 0, 1, 0};
	double C[3][3];

	(void)state;
	fw_frame_ned(0, FW_PI / 2, C);
	assert_near(9, C[0], ned, 1e-16);
	fw_frame_enu(0, FW_PI / 2, C);
	assert_near(9, C[0], enu, 1e-16);
}

/* Up is the derivative of the position by height, north and east those by latitude and longitude. */
static void local_axes_point_where_the_coordinates_grow(void **state)
{
	static const double llh[3] = {0.7, -2.1, 300};
	double C_e_n[3][3], C_e_u[3][3], here[3], there[3];

	(void)state;
	fw_frame_ned(llh[0], llh[1], C_e_n);
	fw_frame_enu(llh[0], llh[1], C_e_u);
	assert_int_equal(fw_llh_to_ecef(llh, here), FW_OK);
	for (int axis = 0; axis < 3; axis++) { /* north, east, up */
		static const double step[3] = {1e-6, 1e-6, 1};
		static const int ned_column[3] = {0, 1, 2}, enu_column[3] = {1, 0, 2};
		double moved[3] = {llh[0], llh[1], llh[2]};
		double length;

		moved[axis] += step[axis];
		assert_int_equal(fw_llh_to_ecef(moved, there), FW_OK);
		length = distance(here, there);
		for (int i = 0; i < 3; i++) {
			double direction = (there[i] - here[i]) / length;
			double sign = axis == 2 ? -1 : 1; /* down in NED */

			assert_true(fabs(C_e_n[i][ned_column[axis]] * sign - direction) < 1e-6);
			assert_true(fabs(C_e_u[i][enu_column[axis]] - direction) < 1e-6);
		}
	}
}

/* mpmath, 30 digits; PROJ's +proj=topocentric agrees to 3e-8 m (its geodetic latitude is that good). */
static void baselines_are_right(void **state)
{
	static const double origin[3] = {4000000, -300000, 4900000};
	static const struct {
		double point[3], enu[3], azimuth, elevation;
	} cases[] = {
	    {{4000100, -300000, 4900000},
	     {7.4789948241634229, -77.370901853918272, 62.911113348370197},
	     3.0452278718407234,
	     0.68040917344914202},
	    {{15600000, 7540000, 20140000},
	     {8685605.9891284551, 1094497.4244540683, 18752213.842356836},
	     1.4454442504128405,
	     1.1340263499366048},
	};
	double enu[3], azimuth, elevation;

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		assert_int_equal(fw_baseline_enu(origin, cases[i].point, enu), FW_OK);
		assert_near(3, enu, cases[i].enu, i == 0 ? 1e-13 : 1e-8);
		assert_int_equal(fw_azimuth_elevation(enu, &azimuth, &elevation), FW_OK);
		assert_true(fabs(azimuth - cases[i].azimuth) < 1e-14);
		assert_true(fabs(elevation - cases[i].elevation) < 1e-14);
	}
	assert_int_equal(fw_baseline_enu(origin, (double[3]){0, nan(""), 0}, enu), FW_ENONFINITE);
	assert_int_equal(fw_baseline_enu((double[3]){0, 0, 1e13}, origin, enu), FW_ERANGE);
	assert_int_equal(fw_baseline_enu(origin, (double[3]){0, 0, 1e13}, enu), FW_ERANGE);
}

static void assert_direction(double e, double n, double u, double azimuth, double elevation)
{
	double a, el;

	assert_int_equal(fw_azimuth_elevation((double[3]){e, n, u}, &a, &el), FW_OK);
	assert_true(fabs(a - azimuth) < 1e-15 && fabs(el - elevation) < 1e-15);
}

static void directions_by_hand(void **state)
{
	double a = 7, el = 7;

	(void)state;
	assert_direction(0, 2, 0, 0, 0);
	assert_direction(2, 0, 0, FW_PI / 2, 0);
	assert_direction(-1, 0, 1, 3 * FW_PI / 2, FW_PI / 4);
	assert_direction(0, -1, -1, FW_PI, -FW_PI / 4);
	assert_direction(0, 0, 5, 0, FW_PI / 2);
	assert_int_equal(fw_azimuth_elevation((double[3]){0, 0, 0}, &a, &el), FW_EINVAL);
	assert_int_equal(fw_azimuth_elevation((double[3]){0, nan(""), 0}, &a, &el), FW_ENONFINITE);
	assert_true(a == 7 && el == 7);
}

/* ---- rotations ---- */

/* scipy: Rotation.from_euler('ZYX', [heading, pitch, roll]), as_matrix and as_quat. */
static const struct {
	double rpy_deg[3], C[3][3], q[4];
} attitudes[] = {
    {{10, -20, 30},
     {{0.8137976813493737, -0.5438381424823255, -0.20487412870286215},
      {0.46984631039295416, 0.8231729446455008, -0.3187957775971678},
      {0.34202014332566866, 0.1631759111665348, 0.9254165783983233}},
     {0.943714364147489, 0.12767944069578063, -0.14487812541736916, 0.2685358227515692}},
    {{-170, 60, 355},
     {{0.4980973490458729, -0.23564312885102473, -0.8344886737989757},
      {-0.04357787137382918, -0.9679534562279005, 0.24731978429350954},
      {-0.8660254037844387, -0.08682408883346515, -0.4924038765061041}},
     {0.0971339491525341, -0.8600079478963956, 0.08116814527930719, 0.49433091919177063}},
    {{0, 90, 45},
     {{0, -0.70710678118654746, 0.70710678118654746},
      {0, 0.70710678118654746, 0.70710678118654746},
      {-1, 0, 0}},
     {0.6532814824381883, -0.27059805007309845, 0.6532814824381882, 0.2705980500730985}},
};

static void radians(const double deg[static 3], double rad[static 3])
{
	for (int i = 0; i < 3; i++)
		rad[i] = fw_rad_from_deg(deg[i]);
}

/* Quaternions q and -q are the same rotation: compare in the half where w is expected. */
static void assert_quat(const double q[static 4], const double expected[static 4], double tolerance)
{
	double sign = q[0] * expected[0] < 0 ? -1 : 1;
	const double same[4] = {sign * q[0], sign * q[1], sign * q[2], sign * q[3]};

	assert_near(4, same, expected, tolerance);
}

static void attitudes_are_what_scipy_says(void **state)
{
	(void)state;
	for (size_t i = 0; i < COUNT(attitudes); i++) {
		double rpy[3], C[3][3], q[4], expected[3][3];

		radians(attitudes[i].rpy_deg, rpy);
		memcpy(expected, attitudes[i].C, sizeof(expected));
		fw_euler_to_matrix(rpy, C);
		assert_near(9, C[0], expected[0], 4e-16);
		fw_euler_to_quat(rpy, q);
		assert_quat(q, attitudes[i].q, 4e-16);
		fw_quat_to_matrix(attitudes[i].q, C);
		assert_near(9, C[0], expected[0], 1e-15);
		fw_quat_from_matrix(expected, q);
		assert_near(4, q, attitudes[i].q, 4e-16); /* w > 0 */
	}
}

/* Roll to the right lowers the right wing; pitch up raises the nose; heading is clockwise from north. */
static void euler_angles_have_their_usual_sense(void **state)
{
	static const double forward[3] = {1, 0, 0}, right[3] = {0, 1, 0};
	double C_n_b[3][3], v[3];

	(void)state;
	fw_euler_to_matrix((double[3]){0.1, 0, 0}, C_n_b);
	fw_mat3_vec(C_n_b, right, v);
	assert_true(v[2] > 0);
	fw_euler_to_matrix((double[3]){0, 0.1, 0}, C_n_b);
	fw_mat3_vec(C_n_b, forward, v);
	assert_true(v[2] < 0);
	fw_euler_to_matrix((double[3]){0, 0, FW_PI / 2}, C_n_b);
	fw_mat3_vec(C_n_b, forward, v);
	assert_near(3, v, (double[3]){0, 1, 0}, 1e-16); /* east */
}

static void euler_angles_come_back(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 13);
	for (int i = 0; i < 100000; i++) {
		double rpy[3] = {between(&r, -FW_PI, FW_PI), between(&r, -1.57, 1.57),
		                 between(&r, 0, 2 * FW_PI)};
		double C[3][3], q[4], back[3];

		fw_euler_to_matrix(rpy, C);
		fw_matrix_to_euler(C, back);
		assert_near(3, back, rpy, 1e-12); /* 1e-15 / cos(pitch) */
		fw_euler_to_quat(rpy, q);
		fw_quat_to_euler(q, back);
		assert_near(3, back, rpy, 1e-12);
	}
}

/* With the nose at the zenith the angles share one freedom, but the rotation is kept to rounding. */
static void euler_angles_keep_the_rotation_near_the_vertical(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 14);
	for (int i = 0; i < 10000; i++) {
		double off = pow(10, between(&r, -18, -1));
		double rpy[3] = {between(&r, -3, 3), (i % 2 ? 1 : -1) * (FW_PI / 2 - off), between(&r, 0, 6)};
		double C[3][3], angles[3], back[3][3];

		fw_euler_to_matrix(rpy, C);
		fw_matrix_to_euler(C, angles);
		fw_euler_to_matrix(angles, back);
		assert_near(9, back[0], C[0], 2e-15);
	}
}

static void straight_up_gives_roll_zero(void **state)
{
	static const double C[3][3] = {{0, -0.6, 0.8}, {0, 0.8, 0.6}, {-1, 0, -0.0}};
	double rpy[3];

	(void)state;
	fw_matrix_to_euler(C, rpy);
	assert_near(3, rpy, (double[3]){0, FW_PI / 2, atan2(0.6, 0.8)}, 1e-15);
}

static void quaternions_and_matrices_are_the_same_rotations(void **state)
{
	fw_random r;

	(void)state;
	fw_random_init(&r, 15);
	for (int i = 0; i < 20000; i++) {
		double p[4], q[4], pq[4], back[4], P[3][3], Q[3][3], PQ[3][3], expected[3][3];

		for (int k = 0; k < 4; k++) {
			p[k] = fw_random_normal(&r);
			q[k] = fw_random_normal(&r);
		}
		if (i % 4 == 0)
			q[0] = 0; /* half turns, where the trace is -1 */
		assert_int_equal(fw_quat_normalise(p), FW_OK);
		assert_int_equal(fw_quat_normalise(q), FW_OK);
		fw_quat_to_matrix(p, P);
		fw_quat_to_matrix(q, Q);
		fw_quat_from_matrix(Q, back);
		assert_true(back[0] >= 0);
		if (i % 4 != 0)
			assert_quat(back, q, 1e-15);
		fw_quat_mul(p, q, pq);
		fw_quat_to_matrix(pq, PQ);
		fw_mat3_mul(P, Q, expected);
		assert_near(9, PQ[0], expected[0], 2e-15);
	}
}

/* scipy: p = ZYX(30, -20, 10) deg, q = ZYX(-100, 5, 70) deg, p * q. */
static void quaternion_product_is_what_scipy_says(void **state)
{
	static const double p[4] = {0.943714364147489, 0.12767944069578063, -0.14487812541736916,
	                            0.2685358227515692};
	static const double q[4] = {0.5068739280238563, 0.39570838268492853, -0.41599945812713873,
	                            -0.6429915612202632};
	static const double expected[4] = {0.5402174279546283, 0.6430192331878555, -0.27766092960448746,
	                                   -0.46647165450406564};
	double r[4];

	(void)state;
	fw_quat_mul(p, q, r);
	assert_near(4, r, expected, 4e-16);
}

static void normalise_refuses_a_quaternion_without_direction(void **state)
{
	double zero[4] = {0, 0, 0, 0};
	double bad[4] = {1, nan(""), 0, 0};
	double large[4] = {1e200, 0, 0, 0};

	(void)state;
	assert_int_equal(fw_quat_normalise(zero), FW_ESINGULAR);
	assert_int_equal(fw_quat_normalise(bad), FW_ESINGULAR);
	assert_int_equal(fw_quat_normalise(large), FW_ESINGULAR);
	assert_true(zero[0] == 0 && bad[0] == 1 && large[0] == 1e200);
}

static void rotation_vectors_are_what_scipy_says(void **state)
{
	static const struct {
		double v[3], q[4];
	} cases[] = {
	    {{0.1, -0.2, 0.3},
	     {0.9825509821552589, 0.049708843324859475, -0.09941768664971895, 0.14912652997457843}},
	    {{1e-09, 2e-09, -3e-09}, {1.0, 5e-10, 1e-09, -1.5e-09}},
	    {{0, 0, 3.141592653589793}, {6.123233995736766e-17, 0.0, 0.0, 1.0}},
	    {{2, 3, -1}, {-0.29555112749297824, 0.5106437200905286, 0.765965580135793, -0.2553218600452643}},
	    {{0, 0, 0}, {1, 0, 0, 0}},
	    {{0, 1e-200, 0}, {1, 0, 5e-201, 0}},
	};
	double q[4];

	(void)state;
	for (size_t i = 0; i < COUNT(cases); i++) {
		fw_quat_from_rotvec(cases[i].v, q);
		for (int k = 0; k < 4; k++)
			assert_true(fabs(q[k] - cases[i].q[k]) <= 1e-15 * fabs(cases[i].q[k]) + 1e-310);
	}
}

/* x cross y = z, and its cyclic fellows: S(v) w for v = {1, 2, 3}, w = {4, 5, 7}, by hand. */
static void skew_is_the_cross_product(void **state)
{
	double S[3][3] = {{9, 9, 9}, {9, 9, 9}, {9, 9, 9}}, y[3];

	(void)state;
	fw_skew((double[3]){1, 2, 3}, S);
	fw_mat3_vec(S, (double[3]){4, 5, 7}, y);
	assert_near(3, y, (double[3]){-1, 5, -3}, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(angles_wrap),
	    cmocka_unit_test(llh_to_ecef_is_right),
	    cmocka_unit_test(ecef_to_llh_is_right),
	    cmocka_unit_test(geodetic_round_trip),
	    cmocka_unit_test(cartesian_round_trip),
	    cmocka_unit_test(axis_and_centre_are_defined),
	    cmocka_unit_test(positions_refuse_what_is_no_position),
	    cmocka_unit_test(local_axes_by_hand),
	    cmocka_unit_test(local_axes_point_where_the_coordinates_grow),
	    cmocka_unit_test(baselines_are_right),
	    cmocka_unit_test(directions_by_hand),
	    cmocka_unit_test(attitudes_are_what_scipy_says),
	    cmocka_unit_test(euler_angles_have_their_usual_sense),
	    cmocka_unit_test(euler_angles_come_back),
	    cmocka_unit_test(euler_angles_keep_the_rotation_near_the_vertical),
	    cmocka_unit_test(straight_up_gives_roll_zero),
	    cmocka_unit_test(quaternions_and_matrices_are_the_same_rotations),
	    cmocka_unit_test(quaternion_product_is_what_scipy_says),
	    cmocka_unit_test(normalise_refuses_a_quaternion_without_direction),
	    cmocka_unit_test(rotation_vectors_are_what_scipy_says),
	    cmocka_unit_test(skew_is_the_cross_product),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
