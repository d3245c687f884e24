/* alignment: against attitudes by hand and against statistics of simulated sensors; in motion against
 * specific forces that are written down in closed form. What it does on flights and drives is in
 * property/test_alignment.c. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "base/random.h"
#include "ins/alignment.h"
#include "ins/gravity.h"

static const double place[3] = {0.9, 0.2, 100}; /* latitude 51.6 degrees */

static double deg(double degrees)
{
	return fw_rad_from_deg(degrees);
}

static fw_time at(double seconds)
{
	return (fw_time){INT64_C(1450000000) * FW_NS_PER_S + llround(seconds * 1e9)};
}

/* What perfect sensors at rest say at an attitude: C_b_n (0, 0, -g) and C_b_n (omega cos lat, 0, -omega sin
 * lat). */
static void at_rest(const double rpy[3], double force_b[3], double omega_b[3])
{
	double up[3] = {0, 0, -fw_gravity_mps2(place[0], place[2])}, C[3][3];
	double axis[3] = {FW_EARTH_RATE_RADPS * cos(place[0]), 0, -FW_EARTH_RATE_RADPS * sin(place[0])};

	fw_euler_to_matrix(rpy, C);
	fw_mat3_t_vec(C, up, force_b);
	fw_mat3_t_vec(C, axis, omega_b);
}

/* Rotation vector phi with C_true = (I + [phi x]) C, for small ones. */
static void rotation_between(const double q_n_b[4], const double rpy_true[3], double phi[3])
{
	double q_true[4], back[4] = {q_n_b[0], -q_n_b[1], -q_n_b[2], -q_n_b[3]}, q[4];

	fw_euler_to_quat(rpy_true, q_true);
	fw_quat_mul(q_true, back, q);
	for (int i = 0; i < 3; i++)
		phi[i] = 2 * q[1 + i] * (q[0] < 0 ? -1 : 1);
}

/* phi^T P^-1 phi */
static double nees(const fw_alignment *a, const double rpy_true[3])
{
	double phi[3], y[3];

	rotation_between(a->q_n_b, rpy_true, phi);
	assert_int_equal(fw_mat_solve_spd(3, 1, a->covariance_rad2[0], phi, y), FW_OK);
	return phi[0] * y[0] + phi[1] * y[1] + phi[2] * y[2];
}

/* ---- levelling ---- */

static void level_by_hand(void **state)
{
	/* Nose up by 30 degrees: the nose feels half of gravity. Rolled to the right by 60: the left wing
	 * feels sqrt(3)/2 of it. */
	static const double nose_up[3] = {4.9, 0, -9.8 * 0.86602540378443865},
	                    rolled[3] = {0, -9.8 * 0.86602540378443865, -4.9};
	fw_align_imu imu = {.accel_bias_sd = 0.03, .accel_noise = 0.08};
	double rp[2], sd[2];

	(void)state;
	assert_int_equal(fw_align_level(nose_up, 4, 9.8, &imu, rp, sd), FW_OK);
	assert_true(fabs(rp[0]) < 1e-12 && fabs(rp[1] - FW_PI / 6) < 1e-12);
	assert_true(fabs(sd[1] - 0.05 / 9.8) < 1e-12); /* 0.03 and 0.08 / sqrt(4) make 0.05 */
	assert_true(fabs(sd[0] - 0.05 / 9.8 / 0.86602540378443865) < 1e-12); /* over cos(pitch) */
	assert_int_equal(fw_align_level(rolled, 4, 9.8, &imu, rp, sd), FW_OK);
	assert_true(fabs(rp[0] - FW_PI / 3) < 1e-12 && fabs(rp[1]) < 1e-12);
}

static void levelling_refuses_motion_and_nonsense(void **state)
{
	static const double good[3] = {0, 0, -9.8}, pushed[3] = {6, 0, -9.8}, bad[3] = {0, (double)NAN, -9.8};
	static const double up[3] = {9.8, 0, 0};
	fw_align_imu imu = {.accel_bias_sd = 0.03}, wrong = {.accel_bias_sd = -1};
	double rp[2] = {7, 7}, sd[2] = {8, 8};

	(void)state;
	assert_int_equal(fw_align_level(pushed, 1, 9.8, &imu, rp, sd), FW_ERANGE);
	assert_int_equal(fw_align_level(bad, 1, 9.8, &imu, rp, sd), FW_ENONFINITE);
	assert_int_equal(fw_align_level(good, 0, 9.8, &imu, rp, sd), FW_EINVAL);
	assert_int_equal(fw_align_level(good, 1, (double)NAN, &imu, rp, sd), FW_EINVAL);
	assert_int_equal(fw_align_level(good, 1, 9.8, &wrong, rp, sd), FW_EINVAL);
	assert_true(rp[0] == 7 && rp[1] == 7 && sd[0] == 8 && sd[1] == 8);
	assert_int_equal(fw_align_level(up, 1, 9.8, &imu, rp, sd), FW_OK); /* roll is anyone's guess */
	assert_true(fabs(rp[1] - FW_PI / 2) < 1e-12 && sd[0] == FW_PI);
}

/* ---- angles ---- */

/* The covariance of the rotation vector is that of rotations made of disturbed angles. */
static void angles_and_their_covariance(void **state)
{
	enum { N = 20000 };
	static const double rpy[3] = {0.4, -0.6, 2.5}, sd[3] = {0.002, 0.003, 0.01}, bad[3] = {0.4, 1.7, 0};
	double sum[3][3] = {{0}};
	fw_alignment a;
	fw_random r;

	(void)state;
	fw_random_init(&r, 4);
	assert_int_equal(fw_align_from_angles(rpy, sd, &a), FW_OK);
	for (int k = 0; k < N; k++) {
		double disturbed[3], phi[3];

		for (int i = 0; i < 3; i++)
			disturbed[i] = rpy[i] + sd[i] * fw_random_normal(&r);
		rotation_between(a.q_n_b, disturbed, phi);
		for (int i = 0; i < 9; i++)
			sum[i / 3][i % 3] += phi[i / 3] * phi[i % 3] / N;
	}
	for (int i = 0; i < 9; i++)
		assert_true(fabs(sum[i / 3][i % 3] - a.covariance_rad2[i / 3][i % 3]) < 3e-6);
	for (int i = 0; i < 3; i++) {
		assert_true(fabs(a.rpy_rad[i] - rpy[i]) < 1e-12);
		assert_true(a.sd_rad[i] == sd[i]);
	}
	assert_int_equal(fw_align_from_angles(bad, sd, &a), FW_EINVAL);
}

/* ---- gyrocompassing ---- */

static const fw_align_imu navigation = {
    .gyro_bias_sd = 4.85e-8, .gyro_noise = 8.7e-7, .accel_bias_sd = 2.5e-4, .accel_noise = 5e-5};

static void a_perfect_gyrocompass(void **state)
{
	static const double rpy[3] = {0.1, -0.2, 4};
	double force[3], omega[3], phi[3];
	fw_alignment a;

	(void)state;
	at_rest(rpy, force, omega);
	assert_int_equal(fw_align_gyrocompass(force, omega, 300, place, &navigation, deg(1), &a), FW_OK);
	rotation_between(a.q_n_b, rpy, phi);
	assert_true(fabs(phi[0]) < 1e-12 && fabs(phi[1]) < 1e-12 && fabs(phi[2]) < 1e-9);
}

/* 200 runs: the mean of 200 values of chi-square with 3 degrees of freedom is 3 +- 0.34 (95 %), and every
 * error is made of bias and noise as they were promised. */
static void a_gyrocompass_knows_how_good_it_is(void **state)
{
	double sum = 0, heading = 0, heading_sd = 0;
	fw_random r;

	(void)state;
	fw_random_init(&r, 20);
	for (int k = 0; k < 200; k++) {
		double rpy[3] = {0.05, -0.03, 2 * FW_PI * fw_random_uniform(&r)}, force[3], omega[3], phi[3];
		double gyro_sd = hypot(4.85e-8, 8.7e-7 / sqrt(300)),
		       accel_sd = hypot(2.5e-4, 5e-5 / sqrt(300));
		fw_alignment a;

		at_rest(rpy, force, omega);
		for (int i = 0; i < 3; i++) {
			omega[i] += gyro_sd * fw_random_normal(&r);
			force[i] += accel_sd * fw_random_normal(&r);
		}
		assert_int_equal(fw_align_gyrocompass(force, omega, 300, place, &navigation, deg(1), &a),
		                 FW_OK);
		sum += nees(&a, rpy) / 200;
		rotation_between(a.q_n_b, rpy, phi);
		heading += phi[2] * phi[2] / 200;
		heading_sd = a.sd_rad[2];
	}
	assert_true(fabs(sum - 3) < 0.34);
	assert_true(fabs(sqrt(heading) / heading_sd - 1) < 0.1);
	assert_true(fabs(heading_sd - deg(0.0886)) <
	            deg(0.001)); /* 7.0e-8 / (omega cos lat), and what tilt adds */
}

static void gyrocompassing_refuses(void **state)
{
	static const double rpy[3] = {0, 0, 1}, pole[3] = {1.5707, 0, 0}, beyond[3] = {2, 0, 0};
	fw_align_imu mems = {.gyro_bias_sd = 2.4e-4, .accel_bias_sd = 0.02};
	double force[3], omega[3];
	fw_alignment a = {.sd_rad = {-1}};

	(void)state;
	at_rest(rpy, force, omega);
	assert_int_equal(fw_align_gyrocompass(force, omega, 300, place, &mems, deg(5), &a), FW_ESINGULAR);
	assert_int_equal(fw_align_gyrocompass(force, omega, 300, pole, &navigation, deg(1), &a),
	                 FW_ESINGULAR);
	assert_int_equal(fw_align_gyrocompass(force, omega, 300, beyond, &navigation, deg(1), &a), FW_EINVAL);
	assert_int_equal(fw_align_gyrocompass(force, omega, 0, place, &navigation, deg(1), &a), FW_EINVAL);
	omega[2] += 1e-4; /* turning */
	assert_int_equal(fw_align_gyrocompass(force, omega, 300, place, &navigation, deg(1), &a), FW_ERANGE);
	omega[2] = (double)NAN;
	assert_int_equal(fw_align_gyrocompass(force, omega, 300, place, &navigation, deg(1), &a),
	                 FW_ENONFINITE);
	assert_true(a.sd_rad[0] == -1);
}

/* ---- course ---- */

static void course_by_hand(void **state)
{
	static const double southwest[3] = {-3, -3, 1}, slow[3] = {0.1, 0, 0};
	double heading = 7, sd = 8;

	(void)state;
	assert_int_equal(fw_align_course(southwest, 0.05, &heading, &sd), FW_OK);
	assert_true(fabs(heading - deg(225)) < 1e-12);
	assert_true(fabs(sd - 0.05 / sqrt(18)) < 1e-12);
	heading = 7;
	assert_int_equal(fw_align_course(slow, 0.05, &heading, &sd), FW_ESINGULAR);
	assert_int_equal(fw_align_course(slow, 0, &heading, &sd), FW_EINVAL);
	assert_true(heading == 7);
}

/* ---- in motion ---- */

static const fw_align_motion_setup coarse = {
    .imu = {.gyro_bias_sd = 1e-3, .gyro_noise = 4e-5, .accel_bias_sd = 0.02, .accel_noise = 6e-4}};

/* A sled that looks one way and slides another: at a fixed attitude, accelerated for some seconds to the
 * north-east, at 100 Hz, with velocity at 5 Hz. Gravity, and the Earth's rotation as the gyros and the
 * velocity feel it, in closed form. */
typedef struct {
	double rpy[3];
	double gyro_bias[3];
	double push_mps2, from_s, until_s; /* to the north and to the east, each */
	double noise_mps;
	fw_random random;
} sled;

static double speed_of(const sled *s, double t)
{
	return s->push_mps2 * (fmin(fmax(t, s->from_s), s->until_s) - s->from_s);
}

static void slide(const sled *s, double t, double dt, fw_increment *raw)
{
	double gain = speed_of(s, t) - speed_of(s, t - dt), v = speed_of(s, t - dt / 2), C[3][3], force[3],
	       omega[3];
	double n = FW_EARTH_RATE_RADPS * cos(place[0]), d = -FW_EARTH_RATE_RADPS * sin(place[0]);
	/* 2 omega x v; gravity; the transport rate is left out: v / R = 1e-6 rad/s */
	double gained_n[3] = {gain - 2 * d * v * dt, gain + 2 * d * v * dt,
	                      2 * n * v * dt - fw_gravity_mps2(place[0], place[2]) * dt};

	fw_euler_to_matrix(s->rpy, C);
	at_rest(s->rpy, force, omega);
	fw_mat3_t_vec(C, gained_n, raw->velocity_mps);
	for (int i = 0; i < 3; i++)
		raw->angle_rad[i] = (omega[i] + s->gyro_bias[i]) * dt;
	raw->dt_s = dt;
}

static void run_sled(sled *s, fw_align_motion *m, double seconds)
{
	for (int i = 1; i <= (int)round(seconds * 100); i++) {
		double t = i * 0.01, v = speed_of(s, t);
		double velocity[3] = {v + s->noise_mps * fw_random_normal(&s->random),
		                      v + s->noise_mps * fw_random_normal(&s->random),
		                      s->noise_mps * fw_random_normal(&s->random)};
		fw_increment raw;

		slide(s, t, 0.01, &raw);
		if (i % 20 == 0)
			assert_int_equal(fw_align_motion_velocity(m, at(t), place, velocity, 0.05), FW_OK);
		assert_int_equal(fw_align_motion_imu(m, at(t), &raw), FW_OK);
	}
}

static sled new_sled(double noise)
{
	sled s = {.rpy = {0.1, -0.2, 4}, .push_mps2 = 1, .from_s = 5, .until_s = 8, .noise_mps = noise};

	fw_random_init(&s.random, 77);
	return s;
}

static void acceleration_shows_heading_whatever_the_course(void **state)
{
	fw_align_motion_answer a;
	fw_align_motion m;
	sled s = new_sled(0);
	double phi[3];

	(void)state;
	assert_int_equal(fw_align_motion_init(&coarse, &m), FW_OK);
	run_sled(&s, &m, 10);
	assert_int_equal(fw_align_motion_solve(&m, &a), FW_OK);
	assert_int_equal(fw_time_compare(a.t, at(10)), 0);
	rotation_between(a.attitude.q_n_b, s.rpy, phi);
	assert_true(fabs(phi[0]) < 1e-9 && fabs(phi[1]) < 1e-9 && fabs(phi[2]) < 1e-9);
	assert_true(a.attitude.sd_rad[2] < deg(2) && a.attitude.sd_rad[2] > deg(0.2));
	assert_true(a.misfit < 1e-3);
}

static void rest_does_not_show_heading(void **state)
{
	fw_align_motion_answer a = {.misfit = -1};
	fw_align_motion m;
	sled s = new_sled(0.05);

	(void)state;
	s.push_mps2 = 0;
	for (int k = 0; k < 20; k++) {
		assert_int_equal(fw_align_motion_init(&coarse, &m), FW_OK);
		run_sled(&s, &m, 20);
		assert_int_equal(fw_align_motion_solve(&m, &a), FW_MORE);
	}
	assert_true(a.misfit == -1);
}

/* With navigation-grade gyros it does: in a minute to some degrees. */
static void the_rotation_of_the_earth_shows_heading_to_good_gyros(void **state)
{
	fw_align_motion_setup setup = {.imu = navigation};
	fw_align_motion_answer a;
	fw_align_motion m;
	sled s = new_sled(0.05);

	(void)state;
	s.push_mps2 = 0;
	assert_int_equal(fw_align_motion_init(&setup, &m), FW_OK);
	run_sled(&s, &m, 60);
	assert_int_equal(fw_align_motion_solve(&m, &a), FW_OK);
	assert_true(a.attitude.sd_rad[2] < deg(10));
	assert_true(fabs(fw_wrap_pi(a.attitude.rpy_rad[2] - s.rpy[2])) < 3 * a.attitude.sd_rad[2]);
}

static void biases_of_the_gyros_are_found_or_taken_as_told(void **state)
{
	static const double bias[3] = {0.004, -0.003, 0.006}; /* 0.2 to 0.35 degrees per second */
	fw_align_motion_setup setup = coarse;
	fw_align_motion_answer a;
	fw_align_motion m;
	sled s = new_sled(0);

	(void)state;
	memcpy(s.gyro_bias, bias, sizeof(bias));
	setup.imu.gyro_bias_sd = 5e-3;
	assert_int_equal(fw_align_motion_init(&setup, &m), FW_OK);
	run_sled(&s, &m, 8);
	assert_int_equal(fw_align_motion_solve(&m, &a), FW_OK);
	assert_true(fabs(fw_wrap_pi(a.attitude.rpy_rad[2] - s.rpy[2])) < 2 * a.attitude.sd_rad[2]);
	for (int i = 0; i < 3; i++)
		assert_true(fabs(a.gyro_bias[i] - bias[i]) < 3 * a.gyro_bias_sd[i]);
	assert_true(a.gyro_bias_sd[0] < 2e-3 &&
	            a.gyro_bias_sd[1] < 2e-3); /* by gravity; about the vertical only what was known */

	memcpy(setup.gyro_bias, bias, sizeof(bias));
	setup.imu.gyro_bias_sd = 1e-4;
	assert_int_equal(fw_align_motion_init(&setup, &m), FW_OK);
	run_sled(&s, &m, 10);
	assert_int_equal(fw_align_motion_solve(&m, &a), FW_OK);
	assert_true(fabs(fw_wrap_pi(a.attitude.rpy_rad[2] - s.rpy[2])) < 1e-4);
	assert_true(fabs(a.gyro_bias[2] - bias[2]) < 1e-6);
}

/* GNSS that is noisier than it says widens the sigmas. */
static void noise_beyond_promise_is_noticed(void **state)
{
	fw_align_motion_answer quiet, loud;
	fw_align_motion m;
	sled s = new_sled(0.05);

	(void)state;
	assert_int_equal(fw_align_motion_init(&coarse, &m), FW_OK);
	run_sled(&s, &m, 10);
	assert_int_equal(fw_align_motion_solve(&m, &quiet), FW_OK);
	s = new_sled(0.15);
	assert_int_equal(fw_align_motion_init(&coarse, &m), FW_OK);
	run_sled(&s, &m, 10);
	assert_int_equal(fw_align_motion_solve(&m, &loud), FW_OK);
	assert_true(quiet.misfit > 0.6 && quiet.misfit < 1.2);
	assert_true(loud.misfit > 2 && loud.misfit < 3.6);
	assert_true(loud.attitude.sd_rad[2] > 1.8 * quiet.attitude.sd_rad[2]);
}

/* A turntable at rest: the antenna on its rim goes round, the IMU in the middle does not move. Its velocity
 * is omega x lever. */
static void the_antenna_goes_round_the_imu(void **state)
{
	fw_align_motion_setup setup = coarse;
	fw_align_motion_answer a;
	fw_align_motion m;

	(void)state;
	setup.imu.scale_sd = 1e-5;
	setup.lever_b[0] = 0.5;
	setup.lever_b[2] = -0.8;
	assert_int_equal(fw_align_motion_init(&setup, &m), FW_OK);
	for (int i = 1; i <= 1000; i++) {
		double t = i * 0.01, rate = 0.5 * (1 - cos(0.6 * t)),
		       heading = 1 + 0.5 * (t - sin(0.6 * t) / 0.6);
		double before = 1 + 0.5 * (t - 0.01 - sin(0.6 * (t - 0.01)) / 0.6);
		double velocity[3] = {-0.5 * rate * sin(heading), 0.5 * rate * cos(heading), 0};
		fw_increment raw = {.dt_s = 0.01, .angle_rad = {0, 0, heading - before}};

		raw.velocity_mps[2] = -fw_gravity_mps2(place[0], place[2]) * 0.01;
		if (i % 20 == 0)
			assert_int_equal(fw_align_motion_velocity(&m, at(t), place, velocity, 0.01), FW_OK);
		assert_int_equal(fw_align_motion_imu(&m, at(t), &raw), FW_OK);
	}
	/* Accelerations come from the lever alone, and the answer is the heading at the end. */
	assert_int_equal(fw_align_motion_solve(&m, &a), FW_OK);
	assert_true(fabs(fw_wrap_pi(a.attitude.rpy_rad[2] - (1 + 0.5 * (10 - sin(6.0) / 0.6)))) < deg(0.5));
	assert_true(a.attitude.sd_rad[2] < deg(2));
}

static void velocities_between_samples_gaps_and_nonsense(void **state)
{
	static const double velocity[3] = {0}, bad[3] = {0, (double)NAN, 0}, nowhere[3] = {3, 0, 0};
	fw_align_motion_answer a;
	fw_align_motion m;
	sled s = new_sled(0);
	fw_increment raw;

	(void)state;
	assert_int_equal(fw_align_motion_init(&coarse, &m), FW_OK);
	run_sled(&s, &m, 10);
	slide(&s, 10.01, 0.01, &raw);
	assert_int_equal(fw_align_motion_imu(&m, at(10), &raw), FW_EINVAL);
	assert_int_equal(fw_align_motion_imu(&m, at(9), &raw), FW_EINVAL);
	assert_int_equal(fw_align_motion_velocity(&m, at(9.99), place, velocity, 0.05), FW_EINVAL);
	assert_int_equal(fw_align_motion_velocity(&m, at(11), place, velocity, 0), FW_EINVAL);
	assert_int_equal(fw_align_motion_velocity(&m, at(11), nowhere, velocity, 0.05), FW_EINVAL);
	assert_int_equal(fw_align_motion_velocity(&m, at(11), place, bad, 0.05), FW_ENONFINITE);
	raw.dt_s = 0;
	assert_int_equal(fw_align_motion_imu(&m, at(10.01), &raw), FW_EINVAL);
	raw.dt_s = 0.01;
	raw.angle_rad[1] = (double)INFINITY;
	assert_int_equal(fw_align_motion_imu(&m, at(10.01), &raw), FW_ENONFINITE);
	assert_int_equal(fw_align_motion_solve(&m, &a), FW_OK); /* nothing has happened */
	slide(&s, 10.05, 0.01, &raw);
	assert_int_equal(fw_align_motion_imu(&m, at(10.05), &raw), FW_OK); /* bridged */
	assert_int_equal(fw_align_motion_solve(&m, &a), FW_OK);
	assert_true(fabs(fw_wrap_pi(a.attitude.rpy_rad[2] - s.rpy[2])) < 1e-3);
	assert_int_equal(fw_align_motion_imu(&m, at(12), &raw), FW_OK); /* too far: anew */
	assert_int_equal(fw_align_motion_solve(&m, &a), FW_MORE);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(level_by_hand),
	    cmocka_unit_test(levelling_refuses_motion_and_nonsense),
	    cmocka_unit_test(angles_and_their_covariance),
	    cmocka_unit_test(a_perfect_gyrocompass),
	    cmocka_unit_test(a_gyrocompass_knows_how_good_it_is),
	    cmocka_unit_test(gyrocompassing_refuses),
	    cmocka_unit_test(course_by_hand),
	    cmocka_unit_test(acceleration_shows_heading_whatever_the_course),
	    cmocka_unit_test(rest_does_not_show_heading),
	    cmocka_unit_test(the_rotation_of_the_earth_shows_heading_to_good_gyros),
	    cmocka_unit_test(biases_of_the_gyros_are_found_or_taken_as_told),
	    cmocka_unit_test(noise_beyond_promise_is_noticed),
	    cmocka_unit_test(the_antenna_goes_round_the_imu),
	    cmocka_unit_test(velocities_between_samples_gaps_and_nonsense),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
