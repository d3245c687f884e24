#include "base/interpolate.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/frame.h"

static void assert_near(int n, const double *have, const double *want, double tolerance)
{
	for (int i = 0; i < n; i++)
		if (!(fabs(have[i] - want[i]) <= tolerance))
			fail_msg("element %d: %.17g, not %.17g", i, have[i], want[i]);
}

/* A cubic is its own interpolation: x^3 - 2 x^2 + 5 from 1 to 3, by hand. */
static void hermite_gives_a_cubic_back(void **state)
{
	const double p0[] = {4, -4}, v0[] = {-1, 1}, p1[] = {14, -14}, v1[] = {15, -15};
	const double at_2[] = {5, -5}, at_1_5[] = {3.875, -3.875}, at_3_5[] = {23.375, -23.375};
	double p[2];

	(void)state;
	fw_hermite(2, 2, 0.5, p0, v0, p1, v1, p);
	assert_near(2, p, at_2, 1e-14);
	fw_hermite(2, 2, 0.25, p0, v0, p1, v1, p);
	assert_near(2, p, at_1_5, 1e-14);
	fw_hermite(2, 2, 1.25, p0, v0, p1, v1, p); /* beyond the end as well */
	assert_near(2, p, at_3_5, 1e-13);
	fw_hermite(2, 2, 0, p0, v0, p1, v1, p);
	assert_near(2, p, p0, 0);
	fw_hermite(2, 2, 1, p0, v0, p1, v1, p);
	assert_near(2, p, p1, 0);
}

/* The bound of the header holds for a circle, and is no larger than it needs to be. */
static void hermite_error_is_as_documented(void **state)
{
	const double h = 0.1, radius = 20, bound = h * h * h * h / 384 * radius;
	double worst = 0;

	(void)state;
	for (int i = 0; i < 100; i++) {
		double a = i * h, b = a + h, middle = a + h / 2;
		const double p0[] = {radius * cos(a), radius * sin(a)},
		             v0[] = {-radius * sin(a), radius * cos(a)};
		const double p1[] = {radius * cos(b), radius * sin(b)},
		             v1[] = {-radius * sin(b), radius * cos(b)};
		double p[2];
		fw_hermite(2, h, 0.5, p0, v0, p1, v1, p);
		worst = fmax(worst, hypot(p[0] - radius * cos(middle), p[1] - radius * sin(middle)));
	}
	assert_true(worst < bound);
	assert_true(worst > 0.9 * bound);
}

static void lagrange_gives_a_polynomial_back(void **state)
{
	/* x^3 - 2 x^2 + 5 and its negative at uneven places. */
	const double t[] = {-1, 0.5, 2, 3}, y[] = {2, -2, 4.625, -4.625, 5, -5, 14, -14};
	const double at_1_5[] = {3.875, -3.875}, linear[] = {4.75, -4.75};
	double p[2];

	(void)state;
	assert_int_equal(fw_lagrange(4, 2, t, y, 1.5, p), FW_OK);
	assert_near(2, p, at_1_5, 1e-14);
	assert_int_equal(fw_lagrange(2, 2, t + 1, y + 2, 1, p), FW_OK); /* 4.625 + (5 - 4.625) / 3 */
	assert_near(2, p, linear, 1e-14);
	assert_int_equal(fw_lagrange(1, 2, t, y, 1e9, p), FW_OK);
	assert_near(2, p, y, 0);
}

static void lagrange_refuses(void **state)
{
	const double t[] = {0, 1, 1}, with_nan[] = {0, nan(""), 1}, y[] = {1, 2, 3};
	double p = 7;

	(void)state;
	assert_int_equal(fw_lagrange(3, 1, t, y, 0.5, &p), FW_EINVAL);
	assert_int_equal(fw_lagrange(3, 1, with_nan, y, 0.5, &p), FW_EINVAL);
	assert_int_equal(fw_lagrange(0, 1, t, y, 0.5, &p), FW_EINVAL);
	assert_int_equal(fw_lagrange(FW_LAGRANGE_MAX + 1, 1, t, y, 0.5, &p), FW_EINVAL);
	assert_true(p == 7);
}

/* Expected values: numpy, by the formula (sin((1-u) o) q0 + sin(u o) q1) / sin(o), which is not the one of the code. */
static const double q0[] = {0.93937271284737889, 0.091643293869591302, 0.1832865877391826,
                            0.27492988160877391};
static const double q1[] = {0.55850986773601041, 0.65492795168361295, -0.42850397621815495,
                            0.27480983990796659};
static const double at_0_3[] = {0.9056597988314935, 0.29589699691703186, -0.0090709150599187771,
                                0.30355067862871993};
static const double between[] = {0.92466210044534636, -1.541103500742244, 0.61644140029689765};

static void slerp_is_right(void **state)
{
	double q[4];
	const double other_sign[] = {-q1[0], -q1[1], -q1[2], -q1[3]};

	(void)state;
	fw_slerp(q0, q1, 0.3, q);
	assert_near(4, q, at_0_3, 1e-15);
	fw_slerp(q0, other_sign, 0.3, q); /* the same rotation, so the same way */
	assert_near(4, q, at_0_3, 1e-15);
	fw_slerp(q0, q1, 0, q);
	assert_near(4, q, q0, 1e-15);
	fw_slerp(q0, q1, 1, q);
	assert_near(4, q, q1, 1e-15);
	fw_slerp(q0, q0, 0.5, q);
	assert_near(4, q, q0, 1e-15);
}

static void rotation_between_is_right(void **state)
{
	const double zero[] = {0, 0, 0};
	double v[3];

	(void)state;
	fw_quat_between(q0, q1, v);
	assert_near(3, v, between, 1e-14);
	fw_quat_between(q0, q0, v);
	assert_near(3, v, zero, 1e-15);
}

/* Tiny turns keep their digits; half a turn is the longest. */
static void rotation_between_at_its_ends(void **state)
{
	const double level[] = {1, 0, 0, 0};
	double q[4], v[3];

	(void)state;
	for (double angle = 1e-9; angle < FW_PI; angle *= 3) {
		fw_quat_from_rotvec((const double[]){0, 0, angle}, q);
		fw_quat_between(level, q, v);
		assert_true(fabs(v[2] - angle) < 1e-15 * fmax(1, angle));
	}
	fw_quat_from_rotvec((const double[]){0, 0, FW_PI + 0.1}, q); /* shorter the other way */
	fw_quat_between(level, q, v);
	assert_true(fabs(v[2] + FW_PI - 0.1) < 1e-14);
}

/* Heading from 350 to 10 degrees goes through north. */
static void slerp_goes_through_north(void **state)
{
	double a[4], b[4], q[4], rpy[3];

	(void)state;
	fw_euler_to_quat((const double[]){0, 0, fw_rad_from_deg(350)}, a);
	fw_euler_to_quat((const double[]){0, 0, fw_rad_from_deg(10)}, b);
	fw_slerp(a, b, 0.75, q);
	fw_quat_to_euler(q, rpy);
	assert_true(fabs(fw_deg_from_rad(rpy[2]) - 5) < 1e-12);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(hermite_gives_a_cubic_back),
	    cmocka_unit_test(hermite_error_is_as_documented),
	    cmocka_unit_test(lagrange_gives_a_polynomial_back),
	    cmocka_unit_test(lagrange_refuses),
	    cmocka_unit_test(slerp_is_right),
	    cmocka_unit_test(rotation_between_is_right),
	    cmocka_unit_test(rotation_between_at_its_ends),
	    cmocka_unit_test(slerp_goes_through_north),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
