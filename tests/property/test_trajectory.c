/* Trajectories against an independent strapdown: fourth-order Runge-Kutta in the Earth-centred frame, fed with nothing but the
 * angular rate and the specific force, must come back to the trajectory's own position, velocity and attitude. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "base/frame.h"
#include "ins/gravity.h"
#include "sim/trajectory.h"

static fw_trajectory trajectory;

/* Position, velocity, attitude C_e_b by rows. */
enum { P = 0, V = 3, C = 6, STATES = 15 };

static void gravity(const double *position, double *g)
{
	double llh[3], C_e_n[3][3];
	assert_int_equal(fw_ecef_to_llh(position, llh), FW_OK);
	fw_frame_ned(llh[0], llh[1], C_e_n);
	for (int i = 0; i < 3; i++)
		g[i] = C_e_n[i][2] * fw_gravity_mps2(llh[0], llh[2]);
}

/* d(state)/dt with the motion's rate and force:
 * r' = v, v' = C f + g - 2 w_ie x v, C' = C [w_ib x] - [w_ie x] C. */
static void derivative(const double *x, const fw_motion *m, double *dx)
{
	const double w = FW_EARTH_RATE_RADPS, *rate = m->omega_ib_b_radps;
	double g[3];
	gravity(x + P, g);
	for (int i = 0; i < 3; i++) {
		const double *row = x + C + 3 * i;
		dx[P + i] = x[V + i];
		dx[V + i] = row[0] * m->force_b_mps2[0] + row[1] * m->force_b_mps2[1] +
		            row[2] * m->force_b_mps2[2] + g[i];
		dx[C + 3 * i] = row[1] * rate[2] - row[2] * rate[1];
		dx[C + 3 * i + 1] = row[2] * rate[0] - row[0] * rate[2];
		dx[C + 3 * i + 2] = row[0] * rate[1] - row[1] * rate[0];
	}
	dx[V] += 2 * w * x[V + 1];
	dx[V + 1] -= 2 * w * x[V];
	for (int j = 0; j < 3; j++) {
		dx[C + j] += w * x[C + 3 + j];
		dx[C + 3 + j] -= w * x[C + j];
	}
}

static void state_of(const fw_motion *m, double *x)
{
	double C_e_n[3][3];
	fw_frame_ned(m->lat_rad, m->lon_rad, C_e_n);
	for (int i = 0; i < 3; i++) {
		x[P + i] = m->position_ecef_m[i];
		x[V + i] = m->velocity_ecef_mps[i];
		for (int j = 0; j < 3; j++) {
			x[C + 3 * i + j] = 0;
			for (int k = 0; k < 3; k++)
				x[C + 3 * i + j] += C_e_n[i][k] * m->C_n_b[k][j];
		}
	}
}

static void at(double t_s, fw_motion *m)
{
	assert_int_equal(fw_trajectory_at(&trajectory, t_s, m), FW_OK);
}

static void step(double *x, double t_s, double h)
{
	fw_motion m[3];
	double k[4][STATES], y[STATES];
	for (int i = 0; i < 3; i++)
		at(t_s + i * h / 2, &m[i]);
	derivative(x, &m[0], k[0]);
	for (int stage = 1; stage < 4; stage++) {
		for (int i = 0; i < STATES; i++)
			y[i] = x[i] + (stage == 3 ? h : h / 2) * k[stage - 1][i];
		derivative(y, &m[stage == 3 ? 2 : 1], k[stage]);
	}
	for (int i = 0; i < STATES; i++)
		x[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
}

/* Integrates from the start for `seconds` in steps of h and compares. The attitude of what flies leans on the acceleration,
 * whose third derivative has corners: there the integration is less good than its order, and needs the smaller steps. */
static void strapdown_comes_back(double seconds, double h)
{
	double x[STATES], truth[STATES];
	fw_motion m;
	at(0, &m);
	state_of(&m, x);
	const int n = (int)lround(seconds / h);
	for (int i = 0; i < n; i++)
		step(x, i * h, h);
	at(n * h, &m);
	state_of(&m, truth);
	double position = 0, velocity = 0, attitude = 0;
	for (int i = 0; i < 3; i++) {
		position = fmax(position, fabs(x[P + i] - truth[P + i]));
		velocity = fmax(velocity, fabs(x[V + i] - truth[V + i]));
	}
	for (int i = 0; i < 9; i++)
		attitude = fmax(attitude, fabs(x[C + i] - truth[C + i]));
	if (!(position < 0.01 && velocity < 1e-4 && attitude < 1e-7))
		fail_msg("after %g s: %g m, %g m/s, attitude %g off", seconds, position, velocity, attitude);
}

/* A closed course of 3 km at 52 degrees north, with climbs and a stay. */
static void make(fw_vehicle vehicle)
{
	static const fw_waypoint course[] = {
	    {0, 0, 0, 0, 10},       {400, 0, 40, 15, 0},   {400, 300, 40, 18, 0},  {-300, 300, 60, 18, 0},
	    {-300, 600, 60, 15, 0}, {500, 700, 50, 18, 0}, {600, -200, 50, 18, 0}, {0, -200, 20, 12, 0},
	    {0, 0, 0, 10, 60},      {200, 100, 10, 10, 0}, {50, 250, 10, 10, 0},   {0, 0, 0, 10, 200},
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

static void plane(void **state)
{
	(void)state;
	make(FW_VEHICLE_PLANE);
	assert_true(trajectory.last_s > 400);
	strapdown_comes_back(600, 0.002);
}

static void ground_vehicle(void **state)
{
	(void)state;
	make(FW_VEHICLE_GROUND);
	strapdown_comes_back(600, 0.01);
}

static void multirotor(void **state)
{
	(void)state;
	make(FW_VEHICLE_MULTIROTOR);
	strapdown_comes_back(600, 0.0005);
}

/* What an IMU reports over an interval is the mean of what it felt: Simpson's rule over 200 parts. */
static void averages_are_means(void **state)
{
	(void)state;
	enum { PARTS = 200 };
	make(FW_VEHICLE_PLANE);
	for (double t = 12; t < 300; t += 17.3) {
		const double h = 0.01 / PARTS;
		double rate[3], force[3], mean_rate[3] = {0}, mean_force[3] = {0};
		assert_int_equal(fw_trajectory_average(&trajectory, t, t + 0.01, rate, force), FW_OK);
		for (int i = 0; i <= PARTS; i++) {
			fw_motion m;
			const double weight = (i == 0 || i == PARTS ? 1 : i % 2 == 1 ? 4 : 2) / (3.0 * PARTS);
			at(t + i * h, &m);
			for (int k = 0; k < 3; k++) {
				mean_rate[k] += weight * m.omega_ib_b_radps[k];
				mean_force[k] += weight * m.force_b_mps2[k];
			}
		}
		for (int k = 0; k < 3; k++) {
			assert_true(fabs(rate[k] - mean_rate[k]) < 1e-9);
			assert_true(fabs(force[k] - mean_force[k]) < 1e-8);
		}
	}
}

/* No more than the vehicle can do, and continuous: angular rate and force have no jumps. */
static void limits_are_kept(void **state)
{
	(void)state;
	fw_motion before, m;
	make(FW_VEHICLE_PLANE);
	at(0, &before);
	for (double t = 0.01; t < trajectory.last_s; t += 0.01, before = m) {
		at(t, &m);
		const double speed = hypot(m.velocity_ned_mps[0], m.velocity_ned_mps[1]);
		assert_true(speed < 18.01);
		assert_true(fabs(m.velocity_ned_mps[2]) < 3.01);
		for (int k = 0; k < 3; k++) {
			assert_true(fabs(m.omega_ib_b_radps[k] - before.omega_ib_b_radps[k]) < 0.05);
			assert_true(fabs(m.force_b_mps2[k] - before.force_b_mps2[k]) < 0.1);
		}
	}
}

/* At rest an accelerometer feels gravity upwards and a gyro the Earth's turning. */
static void at_rest(void **state)
{
	(void)state;
	fw_motion m;
	make(FW_VEHICLE_GROUND);
	at(5, &m);
	double rate = 0, force = 0;
	for (int k = 0; k < 3; k++) {
		assert_true(fabs(m.velocity_ned_mps[k]) < 1e-12);
		rate += m.omega_ib_b_radps[k] * m.omega_ib_b_radps[k];
		force += m.force_b_mps2[k] * m.force_b_mps2[k];
	}
	assert_true(fabs(sqrt(rate) - FW_EARTH_RATE_RADPS) < 1e-15);
	assert_true(fabs(sqrt(force) - fw_gravity_mps2(m.lat_rad, m.height_m)) < 1e-12);
	assert_true(m.force_b_mps2[2] < -9.8);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(plane),           cmocka_unit_test(ground_vehicle),
	    cmocka_unit_test(multirotor),      cmocka_unit_test(averages_are_means),
	    cmocka_unit_test(limits_are_kept), cmocka_unit_test(at_rest),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
