/* The strapdown against the simulator's trajectory, whose rates and forces are exact derivatives (property.trajectory holds
 * them against a Runge-Kutta integration in the Earth-centred frame): from increments alone back to the truth. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "base/frame.h"
#include "ins/gravity.h"
#include "ins/strapdown.h"
#include "sim/trajectory.h"

static fw_trajectory trajectory;

static void fly(fw_vehicle vehicle)
{
	static const fw_waypoint course[] = {
	    {0, 0, 0, 0, 10},       {400, 0, 40, 15, 0},   {400, 300, 40, 18, 0},  {-300, 300, 60, 18, 0},
	    {-300, 600, 60, 15, 0}, {500, 700, 50, 18, 0}, {600, -200, 50, 18, 0}, {0, 0, 0, 10, 400},
	};
	const fw_trajectory_setup setup = {
	    .vehicle = vehicle,
	    .origin_llh = {0.9075712, 0.1998401, 100},
	    .limits = {.accel_mps2 = 2,
	               .lateral_mps2 = 4,
	               .jerk_mps3 = 3,
	               .climb_mps = 3,
	               .turn_radps = 0.5,
	               .radius_m = 15},
	};
	int bad = -1;
	assert_int_equal(
	    fw_trajectory_from_waypoints(&setup, sizeof course / sizeof course[0], course, &trajectory, &bad),
	    FW_OK);
}

static void pva_of(const fw_motion *m, fw_pva *pva)
{
	pva->time.ns = llround(m->t_s * 1e9);
	pva->llh[0] = m->lat_rad;
	pva->llh[1] = m->lon_rad;
	pva->llh[2] = m->height_m;
	memcpy(pva->velocity_mps, m->velocity_ned_mps, sizeof pva->velocity_mps);
	fw_quat_from_matrix(m->C_n_b, pva->q_n_b);
}

/* Largest errors after `seconds` at so many samples per second. */
static void run(double seconds, int rate, double *position, double *velocity, double *attitude)
{
	fw_motion m;
	fw_pva pva, truth;
	fw_increment before = {0}, now = {.dt_s = 1.0 / rate};
	fw_strapdown_step step;
	double turned[3], rate_b[3], force_b[3];
	assert_int_equal(fw_trajectory_at(&trajectory, 0, &m), FW_OK);
	pva_of(&m, &pva);
	for (int k = 0; k < lround(seconds * rate); k++) {
		assert_int_equal(
		    fw_trajectory_average(&trajectory, (double)k / rate, (k + 1.0) / rate, rate_b, force_b),
		    FW_OK);
		for (int i = 0; i < 3; i++) {
			now.angle_rad[i] = rate_b[i] / rate;
			now.velocity_mps[i] = force_b[i] / rate;
		}
		fw_strapdown(&pva, &now, &before, &step);
		before = now;
	}
	assert_int_equal(fw_trajectory_at(&trajectory, seconds, &m), FW_OK);
	pva_of(&m, &truth);
	*position = hypot(hypot((pva.llh[0] - truth.llh[0]) * 6.37e6, (pva.llh[1] - truth.llh[1]) * 3.9e6),
	                  pva.llh[2] - truth.llh[2]);
	*velocity = hypot(
	    hypot(pva.velocity_mps[0] - truth.velocity_mps[0], pva.velocity_mps[1] - truth.velocity_mps[1]),
	    pva.velocity_mps[2] - truth.velocity_mps[2]);
	double q[4];
	const double inverse[4] = {pva.q_n_b[0], -pva.q_n_b[1], -pva.q_n_b[2], -pva.q_n_b[3]};
	fw_quat_mul(truth.q_n_b, inverse, q);
	for (int i = 0; i < 3; i++)
		turned[i] = 2 * q[i + 1];
	*attitude = hypot(hypot(turned[0], turned[1]), turned[2]);
	assert_int_equal(pva.time.ns, llround(seconds * 1e9));
}

static void comes_back(fw_vehicle vehicle, int rate, double most_m)
{
	double position, velocity, attitude;
	fly(vehicle);
	run(600, rate, &position, &velocity, &attitude);
	assert_true(position < most_m);
	assert_true(velocity < 2e-3);
	assert_true(attitude < 1e-6);
}

static void plane(void **state)
{
	(void)state;
	comes_back(FW_VEHICLE_PLANE, 200, 0.05);
}

static void ground_vehicle(void **state)
{
	(void)state;
	comes_back(FW_VEHICLE_GROUND, 100, 0.05);
}

static void multirotor(void **state)
{
	(void)state;
	comes_back(FW_VEHICLE_MULTIROTOR, 200,
	           0.5); /* its attitude follows accelerations with corners: 2e-7 rad */
}

/* Coning: the axis of a rotation goes round. Without the term of two intervals attitude drifts by half the product of the two
 * amplitudes per turn times 2 pi; P. G. Savage, J. Guidance 21 (1998). */
static void coning(void **state)
{
	(void)state;
	const double amplitude = 0.02, turns_per_s = 4, dt = 0.01, w = 2 * FW_PI * turns_per_s;
	fw_pva pva = {.llh = {0.9, 0.2, 0}, .q_n_b = {1, 0, 0, 0}};
	fw_increment before = {0}, now;
	fw_strapdown_step step;
	double rpy[3];
	/* omega = amplitude w (cos wt, sin wt, 0): the attitude comes back each turn, but for the cone's solid angle about z. */
	for (int k = 0; k < 1000; k++) {
		const double t0 = k * dt, t1 = t0 + dt;
		now = (fw_increment){.dt_s = dt,
		                     .angle_rad = {amplitude * (sin(w * t1) - sin(w * t0)),
		                                   -amplitude * (cos(w * t1) - cos(w * t0)), 0},
		                     .velocity_mps = {0, 0, -9.81 * dt}};
		fw_strapdown(&pva, &now, &before, &step);
		before = now;
	}
	fw_quat_to_euler(pva.q_n_b, rpy);
	/* Solid angle per turn: area of the circle on the sphere, pi amplitude^2; 40 turns. The Earth's own turning: 10 s. */
	const double cone = 40 * FW_PI * amplitude * amplitude, earth = -10 * FW_EARTH_RATE_RADPS * sin(0.9);
	const double heading = fw_wrap_pi(rpy[2]);
	assert_true(fabs(heading - (cone - earth)) < 1e-3 * cone);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(plane),
	    cmocka_unit_test(ground_vehicle),
	    cmocka_unit_test(multirotor),
	    cmocka_unit_test(coning),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
