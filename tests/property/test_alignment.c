/* Alignment in motion on simulated flights and drives, 50 of each with their own IMU and GNSS errors: errors
 * are as large as their sigmas say, and 5 degrees of heading are there soon after the first horizontal
 * acceleration. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "ins/alignment.h"
#include "sim/sensors.h"
#include "sim/trajectory.h"

enum { RATE_HZ = 50, GNSS_HZ = 5, SECONDS = 40, SAMPLES = RATE_HZ * SECONDS, SEEDS = 50 };

static fw_trajectory trajectory;
static fw_increment truth[SAMPLES];
static fw_motion moment[SECONDS + 1], fix[GNSS_HZ * SECONDS + 1];

static const double lever[3] = {0.5, 0.2, -0.8};

/* GNSS velocities fall between samples of the IMU. */
static double fix_time(int k)
{
	return 0.0037 + k / (double)GNSS_HZ;
}

static double deg(double degrees)
{
	return fw_rad_from_deg(degrees);
}

static fw_time at(double seconds)
{
	return (fw_time){INT64_C(1450000000) * FW_NS_PER_S + llround(seconds * 1e9)};
}

static void prepare(fw_vehicle vehicle, int n, const fw_waypoint w[])
{
	fw_trajectory_setup setup = {
	    .vehicle = vehicle, .origin_llh = {deg(52), deg(11), 120}, .limits = {2, 3, 3, 3, deg(60), 3}};
	int bad;

	assert_int_equal(fw_trajectory_from_waypoints(&setup, n, w, &trajectory, &bad), FW_OK);
	for (int i = 0; i < SAMPLES; i++) {
		double from = i / (double)RATE_HZ, until = (i + 1) / (double)RATE_HZ;

		assert_int_equal(fw_trajectory_average(&trajectory, from, until, truth[i].angle_rad,
		                                       truth[i].velocity_mps),
		                 FW_OK);
	}
	for (int i = 0; i <= SECONDS; i++)
		assert_int_equal(fw_trajectory_at(&trajectory, i, &moment[i]), FW_OK);
	for (int k = 0; k <= GNSS_HZ * SECONDS; k++)
		assert_int_equal(fw_trajectory_at(&trajectory, fix_time(k), &fix[k]), FW_OK);
}

/* A few seconds upwards, then along. */
static void prepare_drone(void)
{
	static const fw_waypoint w[] = {
	    {0, 0, 0, 1, 1}, {0, 0, 10, 2, 0}, {200, 0, 10, 8, 0}, {200, 200, 10, 8, 0}, {0, 200, 10, 8, 0}};

	prepare(FW_VEHICLE_MULTIROTOR, 5, w);
}

static void prepare_car(void)
{
	static const fw_waypoint w[] = {{0, 0, 0, 1, 1},
	                                {200, 30, 0, 12, 0},
	                                {250, 200, 0, 14, 0},
	                                {100, 300, 0, 10, 0},
	                                {-200, 200, 0, 14, 0}};

	prepare(FW_VEHICLE_GROUND, 5, w);
}

static void prepare_tractor(void)
{
	static const fw_waypoint w[] = {
	    {0, 0, 0, 1, 1}, {50, 0, 0, 2.5, 0}, {50, 20, 0, 1.5, 0}, {-50, 20, 0, 2.5, 0}};

	prepare(FW_VEHICLE_GROUND, 4, w);
}

/* MEMS of a better kind: 50 degrees per hour, 0.15 degrees per root hour, 2 mg, 60 ug per root hertz; a part
 * in 1000. */
static fw_imu_model industrial(double gyro_bias_sd)
{
	return (fw_imu_model){
	    .gyro = {.bias_sd = gyro_bias_sd,
	             .white = deg(0.15) / 60,
	             .flicker = deg(3) / 3600,
	             .scale_sd = 5e-4,
	             .misalignment_sd = 1e-3},
	    .accel = {
	        .bias_sd = 0.02, .white = 6e-4, .flicker = 3e-4, .scale_sd = 5e-4, .misalignment_sd = 1e-3}};
}

static void give_velocity(fw_align_motion *m, fw_random *r, int k)
{
	const fw_motion *now = &fix[k];
	double llh[3] = {now->lat_rad, now->lon_rad, now->height_m}, S[3][3], swing[3], velocity[3];

	fw_skew(now->omega_ib_b_radps, S);
	fw_mat3_vec(S, lever, swing);
	fw_mat3_vec(now->C_n_b, swing, velocity);
	for (int i = 0; i < 3; i++)
		velocity[i] += now->velocity_ned_mps[i] + (i == 2 ? 0.1 : 0.05) * fw_random_normal(r);
	assert_int_equal(fw_align_motion_velocity(m, at(fix_time(k)), llh, velocity, 0.05), FW_OK);
}

/* What 50 runs gave. */
typedef struct {
	int answers, within1, within2, wrong; /* every second; wrong: beyond 4 sigma */
	double to_5deg_s;                     /* the latest of them; SECONDS + 1 if one did not get there */
	double error_at_5deg;                 /* root mean square */
} outcome;

static void judge(const fw_align_motion *m, int second, double *reached, outcome *o)
{
	fw_align_motion_answer a;
	double z;

	if (fw_align_motion_solve(m, &a) != FW_OK)
		return;
	z = fabs(fw_wrap_pi(a.attitude.rpy_rad[2] - moment[second].heading_rad)) / a.attitude.sd_rad[2];
	o->answers++;
	o->within1 += z < 1;
	o->within2 += z < 2;
	o->wrong += z > 4;
	if (a.attitude.sd_rad[2] < deg(5) && *reached > SECONDS) {
		*reached = second;
		o->error_at_5deg += z * z * a.attitude.sd_rad[2] * a.attitude.sd_rad[2] / SEEDS;
	}
}

static void run(const fw_imu_model *model, uint64_t seed, outcome *o)
{
	fw_align_motion_setup setup = {
	    .imu = {model->gyro.bias_sd, model->gyro.white, model->accel.bias_sd, model->accel.white, 0},
	    .lever_b = {lever[0], lever[1], lever[2]}};
	double reached = SECONDS + 1;
	fw_align_motion m;
	fw_random r;
	fw_imu imu;
	int k = 0;

	fw_random_init(&r, 1000 + seed);
	assert_int_equal(fw_imu_init(model, 1.0 / RATE_HZ, seed, &imu), FW_OK);
	assert_int_equal(fw_align_motion_init(&setup, &m), FW_OK);
	for (int i = 0; i < SAMPLES; i++) {
		fw_increment raw = {.dt_s = 1.0 / RATE_HZ};

		fw_imu_sample(&imu, truth[i].angle_rad, truth[i].velocity_mps, raw.angle_rad,
		              raw.velocity_mps);
		for (int j = 0; j < 3; j++) {
			raw.angle_rad[j] /= RATE_HZ;
			raw.velocity_mps[j] /= RATE_HZ;
		}
		if (fix_time(k) <= (i + 1) / (double)RATE_HZ)
			give_velocity(&m, &r, k++);
		assert_int_equal(fw_align_motion_imu(&m, at((i + 1) / (double)RATE_HZ), &raw), FW_OK);
		if ((i + 1) % (2 * RATE_HZ) == 0)
			judge(&m, (i + 1) / RATE_HZ, &reached, o);
	}
	o->to_5deg_s = fmax(o->to_5deg_s, reached);
}

static outcome campaign(double gyro_bias_sd)
{
	fw_imu_model model = industrial(gyro_bias_sd);
	outcome o = {0};

	for (uint64_t seed = 1; seed <= SEEDS; seed++)
		run(&model, seed, &o);
	o.error_at_5deg = sqrt(o.error_at_5deg);
	return o;
}

/* 68 and 95 % of the errors within one and two sigmas. Errors of one run hang together, so there are fewer
 * than there seem. */
static void assert_honest(const outcome *o)
{
	assert_true(o->within1 >= 0.6 * o->answers && o->within1 <= 0.85 * o->answers);
	assert_true(o->within2 >= 0.9 * o->answers);
	assert_true(o->wrong <= 0.005 * o->answers);
	assert_true(o->error_at_5deg < deg(5));
}

static void a_drone_knows_its_heading_when_it_flies_off(void **state)
{
	outcome o;

	(void)state;
	prepare_drone();
	o = campaign(deg(50) / 3600);
	assert_honest(&o);
	assert_true(o.answers > 10 * SEEDS && o.to_5deg_s <= 14); /* it leaves the vertical after 10 s */
}

static void a_car_knows_its_heading_when_it_drives_off(void **state)
{
	outcome o;

	(void)state;
	prepare_car();
	o = campaign(deg(50) / 3600);
	assert_honest(&o);
	assert_true(o.answers > 18 * SEEDS && o.to_5deg_s <= 6);
}

static void a_tractor_knows_its_heading_soon(void **state)
{
	outcome o;

	(void)state;
	prepare_tractor();
	o = campaign(deg(50) / 3600);
	assert_honest(&o);
	assert_true(o.answers > 18 * SEEDS && o.to_5deg_s <= 8);
}

/* A bias of a degree per second, unknown: it takes longer, and says so. */
static void gyros_of_the_cheapest_kind_are_survived(void **state)
{
	outcome o;

	(void)state;
	prepare_car();
	o = campaign(deg(1));
	assert_honest(&o);
	assert_true(o.to_5deg_s <= SECONDS);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(a_drone_knows_its_heading_when_it_flies_off),
	    cmocka_unit_test(a_car_knows_its_heading_when_it_drives_off),
	    cmocka_unit_test(a_tractor_knows_its_heading_soon),
	    cmocka_unit_test(gyros_of_the_cheapest_kind_are_survived),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
