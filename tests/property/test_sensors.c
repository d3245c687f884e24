/* Sensor errors: Allan deviations against those that the model's coefficients stand for (IEEE Std 952, annex C;
 * IEEE Std 1139), over three decades, from the readings of a sensor at rest; and the parts that are exact. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "sim/sensors.h"

enum { SAMPLES = 200000, RUNS = 2 };

#define STEP_S 0.01

static double series[3 * RUNS][SAMPLES];
static double sums[SAMPLES + 1];

/* Overlapping Allan deviation of the means over m samples. */
static double allan(const double *y, int m)
{
	double total = 0;
	sums[0] = 0;
	for (int i = 0; i < SAMPLES; i++)
		sums[i + 1] = sums[i] + y[i];
	const int n = SAMPLES - 2 * m + 1;
	for (int i = 0; i < n; i++) {
		double d = (sums[i + 2 * m] - 2 * sums[i + m] + sums[i]) / m;
		total += d * d;
	}
	return sqrt(total / (2.0 * n));
}

/* The same over all series: root mean square. */
static double allan_of_all(int m)
{
	double total = 0;
	for (int i = 0; i < 3 * RUNS; i++) {
		double a = allan(series[i], m);
		total += a * a;
	}
	return sqrt(total / (3 * RUNS));
}

/* Gyros at rest. */
static void record(const fw_triad_model *triad)
{
	static fw_imu imu;
	const fw_imu_model model = {.gyro = *triad};
	const double zero[3] = {0, 0, 0};
	for (unsigned run = 0; run < RUNS; run++) {
		assert_int_equal(fw_imu_init(&model, STEP_S, 1000 + run, &imu), FW_OK);
		for (int k = 0; k < SAMPLES; k++) {
			double gyro[3], accel[3];
			fw_imu_sample(&imu, zero, zero, gyro, accel);
			for (unsigned i = 0; i < 3; i++)
				series[3 * run + i][k] = gyro[i];
		}
	}
}

static void within(double got, double expected, double relative)
{
	if (!(fabs(got / expected - 1) <= relative))
		fail_msg("%g, not %g", got, expected);
}

static void white_noise(void **state)
{
	(void)state;
	record(&(fw_triad_model){.white = 2e-4});
	for (int m = 1; m <= 1000; m *= 10)
		within(allan_of_all(m), 2e-4 / sqrt(m * STEP_S), 0.1);
}

static void random_walk(void **state)
{
	(void)state;
	record(&(fw_triad_model){.walk = 3e-5});
	for (int m = 10; m <= 10000; m *= 10)
		within(allan_of_all(m), 3e-5 * sqrt(m * STEP_S / 3), 0.1);
}

static void flicker(void **state)
{
	(void)state;
	record(&(fw_triad_model){.flicker = 1e-4});
	for (int m = 1; m <= 10000; m *= 10)
		within(allan_of_all(m), sqrt(2 * M_LN2 / M_PI) * 1e-4, 0.1);
}

/* Gauss-Markov: ADEV^2 = s^2 (2 x - 3 + 4 exp(-x) - exp(-2 x)) / x^2, x = tau / T. */
static void markov(void **state)
{
	(void)state;
	const double T = 2;
	record(&(fw_triad_model){.markov_sd = 5e-4, .markov_tau_s = T});
	for (int m = 10; m <= 10000; m *= 10) {
		double x = m * STEP_S / T;
		within(allan_of_all(m), 5e-4 * sqrt(2 * x - 3 + 4 * exp(-x) - exp(-2 * x)) / x, 0.1);
	}
}

static void clocks(void **state)
{
	(void)state;
	static const char *const names[] = {"tcxo", "csac", "rubidium"};
	static fw_clock clock;
	for (unsigned k = 0; k < 3; k++) {
		fw_clock_model model;
		assert_int_equal(fw_clock_model_named(names[k], &model), FW_OK);
		model.ageing_per_s = 0;
		for (unsigned run = 0; run < 3 * RUNS; run++) {
			assert_int_equal(fw_clock_init(&model, 1, 77 + run, &clock), FW_OK);
			for (int i = 0; i < SAMPLES; i++) {
				fw_clock_step(&clock);
				series[run][i] = clock.drift_sps;
			}
		}
		for (int m = 1; m <= 1000; m *= 10) {
			double expected = model.h0 / (2.0 * m) + 2 * M_LN2 * model.hm1 +
			                  2 * M_PI * M_PI / 3 * m * model.hm2;
			within(allan_of_all(m), sqrt(expected), 0.1);
		}
	}
	fw_clock_model untouched = {.h0 = 1};
	assert_int_equal(fw_clock_model_named("sundial", &untouched), FW_EUNKNOWN);
	assert_true(untouched.h0 == 1);
}

/* Scale 1000 ppm on the turn-on: reading = (I + M) true + bias, the same all run; a perfect sensor says the truth. */
static void deterministic_errors(void **state)
{
	(void)state;
	static fw_imu imu;
	const double rate[3] = {0.1, -0.2, 0.3}, force[3] = {1, 2, -9.8}, twice[3] = {0.2, -0.4, 0.6};
	double gyro[3], accel[3], first[3], second[3];
	fw_imu_model model = {0};
	assert_int_equal(fw_imu_init(&model, STEP_S, 5, &imu), FW_OK);
	fw_imu_sample(&imu, rate, force, gyro, accel);
	for (int i = 0; i < 3; i++)
		assert_true(gyro[i] == rate[i] && accel[i] == force[i]);

	model.gyro.bias_sd = 1e-3;
	model.gyro.scale_sd = 1e-3;
	model.gyro.misalignment_sd = 1e-3;
	assert_int_equal(fw_imu_init(&model, STEP_S, 6, &imu), FW_OK);
	fw_imu_sample(&imu, rate, force, first, accel);
	fw_imu_sample(&imu, twice, force, second, accel);
	for (int i = 0; i < 3; i++) {
		double slope = second[i] - first[i], bias = first[i] - slope;
		assert_true(fabs(slope - rate[i]) > 1e-6 && fabs(slope - rate[i]) < 5e-3);
		assert_true(fabs(bias) > 1e-6 && fabs(bias) < 5e-3);
	}
	fw_imu_sample(&imu, rate, force, second, accel);
	for (int i = 0; i < 3; i++)
		assert_true(fabs(second[i] - first[i]) < 1e-15);
}

/* Quantisation loses nothing in the long run; the range does. */
static void quantisation_and_range(void **state)
{
	(void)state;
	static fw_imu imu;
	const fw_imu_model model = {.gyro = {.quantum = 1e-4, .range = 0.5}};
	const double rate[3] = {0.00123, -0.3, 2}, zero[3] = {0, 0, 0};
	double gyro[3], accel[3], sum[3] = {0, 0, 0};
	assert_int_equal(fw_imu_init(&model, STEP_S, 7, &imu), FW_OK);
	for (int k = 0; k < 1000; k++) {
		fw_imu_sample(&imu, rate, zero, gyro, accel);
		double steps = gyro[0] * STEP_S / 1e-4;
		assert_true(fabs(steps - nearbyint(steps)) < 1e-9);
		for (int i = 0; i < 3; i++)
			sum[i] += gyro[i] * STEP_S;
	}
	assert_true(fabs(sum[0] - 0.0123) < 1.01e-4);
	assert_true(fabs(sum[1] + 3) < 1.01e-4);
	assert_true(fabs(sum[2] - 5) < 1e-9);
}

static void same_seed_same_readings(void **state)
{
	(void)state;
	static fw_imu a, b, c;
	const fw_imu_model model = {.gyro = {.white = 1e-3, .flicker = 1e-4},
	                            .accel = {.white = 1e-2, .walk = 1e-3}};
	const double zero[3] = {0, 0, 0};
	int differ = 0;
	assert_int_equal(fw_imu_init(&model, STEP_S, 9, &a), FW_OK);
	assert_int_equal(fw_imu_init(&model, STEP_S, 9, &b), FW_OK);
	assert_int_equal(fw_imu_init(&model, STEP_S, 10, &c), FW_OK);
	for (int k = 0; k < 100; k++) {
		double g[3][3], f[3][3];
		fw_imu_sample(&a, zero, zero, g[0], f[0]);
		fw_imu_sample(&b, zero, zero, g[1], f[1]);
		fw_imu_sample(&c, zero, zero, g[2], f[2]);
		for (int i = 0; i < 3; i++) {
			assert_true(g[0][i] == g[1][i] && f[0][i] == f[1][i]);
			differ += g[0][i] != g[2][i];
		}
	}
	assert_int_equal(differ, 300);
}

static void magnetometer_and_barometer(void **state)
{
	(void)state;
	fw_magnetometer m;
	fw_barometer b;
	const double east[3][3] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}; /* the nose points east */
	const double field[3] = {20000, 1000, 45000};
	double mag[3];
	const fw_magnetometer_model iron = {.hard_iron_ut = {1, 2, 3},
	                                    .soft_iron = {{0, 0.1, 0}, {0, 0, 0}, {0, 0, 0}}};
	assert_int_equal(fw_magnetometer_init(&iron, 1, &m), FW_OK);
	fw_magnetometer_sample(&m, east, field, mag);
	/* body: forward 1, right -20 (north is left), down 45 */
	assert_true(fabs(mag[0] - (1 + 1 - 2)) < 1e-12);
	assert_true(fabs(mag[1] - (-20 + 2)) < 1e-12);
	assert_true(fabs(mag[2] - (45 + 3)) < 1e-12);

	const fw_barometer_model model = {.noise_m = 0.5, .drift_sd_m = 2, .drift_tau_s = 100};
	double sum = 0, square = 0;
	assert_int_equal(fw_barometer_init(&model, 1, 2, &b), FW_OK);
	for (int i = 0; i < SAMPLES; i++) {
		double error = fw_barometer_sample(&b, 100) - 100;
		sum += error;
		square += error * error;
	}
	within(sqrt(square / SAMPLES), sqrt(4 + 0.25), 0.05);
	assert_true(fabs(sum / SAMPLES) < 0.15);
}

static void refusals(void **state)
{
	(void)state;
	static fw_imu imu;
	fw_clock clock;
	fw_barometer b;
	assert_int_equal(fw_imu_init(&(fw_imu_model){.gyro = {.white = -1}}, STEP_S, 1, &imu), FW_EINVAL);
	assert_int_equal(fw_imu_init(&(fw_imu_model){.accel = {.walk = (double)NAN}}, STEP_S, 1, &imu),
	                 FW_EINVAL);
	assert_int_equal(fw_imu_init(&(fw_imu_model){.gyro = {.markov_sd = 1}}, STEP_S, 1, &imu), FW_EINVAL);
	assert_int_equal(fw_imu_init(&(fw_imu_model){.gyro = {.white = 1}}, 0, 1, &imu), FW_EINVAL);
	assert_int_equal(fw_clock_init(&(fw_clock_model){.h0 = -1}, 1, 1, &clock), FW_EINVAL);
	assert_int_equal(fw_barometer_init(&(fw_barometer_model){.drift_sd_m = 1}, 1, 1, &b), FW_EINVAL);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(white_noise),
	    cmocka_unit_test(random_walk),
	    cmocka_unit_test(flicker),
	    cmocka_unit_test(markov),
	    cmocka_unit_test(clocks),
	    cmocka_unit_test(deterministic_errors),
	    cmocka_unit_test(quantisation_and_range),
	    cmocka_unit_test(same_seed_same_readings),
	    cmocka_unit_test(magnetometer_and_barometer),
	    cmocka_unit_test(refusals),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
