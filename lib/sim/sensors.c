#include "sim/sensors.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* ---- coloured noise ---- */

/* 2 x - 3 + 4 exp(-x) - exp(-2 x), which is 2/3 x^3 for small x: there as a series, for the terms cancel. */
static double integral_variance(double x)
{
	if (x < 1e-2)
		return x * x * x * (2.0 / 3 - x / 2 + x * x * 7 / 30);
	return 2 * x - 3 + 4 * exp(-x) - exp(-2 * x);
}

/* The noise of the value over a step (variance ww), of the integral (jj), and what they have in common (wj). */
static void set_noise(fw_wander *w, double ww, double wj, double jj, double step_s)
{
	w->value_sd = sqrt(ww);
	w->mean_per_value = ww > 0 ? wj / ww / step_s : 0;
	double rest = ww > 0 ? jj - wj * wj / ww : jj;
	w->mean_sd = sqrt(rest > 0 ? rest : 0) / step_s;
}

/* First-order Gauss-Markov of standard deviation sd and correlation time tau, stationary from the start.
 * Source: A. Gelb (ed.), Applied Optimal Estimation (1974), 3.8: variance of v(dt) and of its integral, given v(0). */
static void start_markov(fw_wander *w, double sd, double tau_s, double step_s, fw_random *random)
{
	double x = step_s / tau_s, left = -expm1(-x);
	w->value = sd * fw_random_normal(random);
	w->keep = exp(-x);
	w->share = left / x;
	set_noise(w, -sd * sd * expm1(-2 * x), sd * sd * tau_s * left * left,
	          sd * sd * tau_s * tau_s * integral_variance(x), step_s);
}

/* Random walk from 0, whose variance grows by q each second. */
static void start_walk(fw_wander *w, double q, double step_s)
{
	w->value = 0;
	w->keep = w->share = 1;
	set_noise(w, q * step_s, q * step_s * step_s / 2, q * step_s * step_s * step_s / 3, step_s);
}

/* A step on; returns the mean over it. */
static double wander(fw_wander *w, fw_random *random)
{
	double noise = w->value_sd * fw_random_normal(random);
	double mean = w->share * w->value + w->mean_per_value * noise + w->mean_sd * fw_random_normal(random);
	w->value = w->keep * w->value + noise;
	return mean;
}

/* Noise of the one-sided spectral density h / f. Processes whose times are a factor r apart, each of variance
 * h ln r, add up to it between the shortest and the longest: sum over poles of 4 s^2 tau / (1 + w^2 tau^2)
 * is nearly the integral of it over ln(tau), s^2 / (f ln r). What shorter ones would add to the mean over a step is white:
 * the sum of 2 s^2 tau / step over their times, the shortest's over r, r^2, ... */
static void start_flicker(fw_flicker *flicker, double h, double step_s, fw_random *random)
{
	const double ratio = 4;
	double tau_s = step_s / ratio, sd = sqrt(h * log(ratio));
	const double shorter = 2 * sd * sd * tau_s / (ratio - 1) / step_s;
	for (int i = 0; i < FW_FLICKER_POLES; i++, tau_s *= ratio)
		start_markov(&flicker->pole[i], sd, tau_s, step_s, random);
	flicker->pole[0].mean_sd = hypot(flicker->pole[0].mean_sd, sqrt(shorter));
}

static double flicker_mean(fw_flicker *flicker, fw_random *random)
{
	double mean = 0;
	for (int i = 0; i < FW_FLICKER_POLES; i++)
		mean += wander(&flicker->pole[i], random);
	return mean;
}

/* ---- IMU ---- */

static bool all_not_negative(const double *numbers, size_t n)
{
	for (size_t i = 0; i < n; i++)
		if (!(numbers[i] >= 0 && numbers[i] <= 1e30))
			return false;
	return true;
}

static bool triad_is_sound(const fw_triad_model *m)
{
	const double numbers[] = {m->bias_sd,  m->white,           m->flicker, m->walk, m->markov_sd,
	                          m->scale_sd, m->misalignment_sd, m->quantum, m->range};
	return all_not_negative(numbers, sizeof numbers / sizeof numbers[0]) &&
	       (m->markov_sd <= 0 || (m->markov_tau_s > 0 && isfinite(m->markov_tau_s)));
}

static void start_triad(fw_triad *t, const fw_triad_model *m, double interval_s, fw_random random)
{
	memset(t, 0, sizeof *t);
	t->model = *m;
	t->interval_s = interval_s;
	t->random = random;
	for (int i = 0; i < 3; i++) {
		t->bias[i] = m->bias_sd * fw_random_normal(&t->random);
		for (int j = 0; j < 3; j++)
			t->matrix[i][j] = i == j ? 1 + m->scale_sd * fw_random_normal(&t->random)
			                         : m->misalignment_sd * fw_random_normal(&t->random);
	}
	for (int i = 0; i < 3; i++) {
		/* Allan deviation K sqrt(tau / 3) is a walk of the variance K^2 each second; 0.664 B is h = B^2 / pi,
		 * for ADEV^2 = 2 ln 2 h. Source: IEEE Std 952, annex C. */
		start_walk(&t->walk[i], m->walk * m->walk, interval_s);
		start_flicker(&t->flicker[i], m->flicker * m->flicker / M_PI, interval_s, &t->random);
		if (m->markov_sd > 0)
			start_markov(&t->markov[i], m->markov_sd, m->markov_tau_s, interval_s, &t->random);
	}
}

fw_status fw_imu_init(const fw_imu_model *model, double interval_s, uint64_t seed, fw_imu *imu)
{
	fw_random gyro, accel;
	if (!(interval_s > 0 && isfinite(interval_s)) || !triad_is_sound(&model->gyro) ||
	    !triad_is_sound(&model->accel))
		return FW_EINVAL;
	fw_random_init(&gyro, seed);
	fw_random_init(&accel, fw_random_u64(&gyro));
	start_triad(&imu->gyro, &model->gyro, interval_s, gyro);
	start_triad(&imu->accel, &model->accel, interval_s, accel);
	return FW_OK;
}

static double quantised(double x, double quantum)
{
	return quantum > 0 ? nearbyint(x / quantum) * quantum : x;
}

/* What the electronics make of it: whole steps of the increment, and no more than the range. */
static double digitised(fw_triad *t, int i, double reading)
{
	if (t->model.quantum > 0) {
		double increment = reading * t->interval_s + t->remainder[i];
		double steps = quantised(increment, t->model.quantum);
		t->remainder[i] = increment - steps;
		reading = steps / t->interval_s;
	}
	return t->model.range > 0 ? fmin(fmax(reading, -t->model.range), t->model.range) : reading;
}

static void sample_triad(fw_triad *t, const double truth[3], double reading[3])
{
	const double white = t->model.white / sqrt(t->interval_s);
	const double in[3] = {truth[0], truth[1], truth[2]};
	for (int i = 0; i < 3; i++) {
		t->wandering[i] = wander(&t->walk[i], &t->random) + flicker_mean(&t->flicker[i], &t->random);
		if (t->model.markov_sd > 0)
			t->wandering[i] += wander(&t->markov[i], &t->random);
		double sum = t->bias[i] + t->wandering[i] + white * fw_random_normal(&t->random);
		for (int j = 0; j < 3; j++)
			sum += t->matrix[i][j] * in[j];
		reading[i] = digitised(t, i, sum);
	}
}

void fw_imu_sample(fw_imu *imu, const double omega_ib_b_radps[static 3], const double force_b_mps2[static 3],
                   double gyro_radps[static 3], double accel_mps2[static 3])
{
	sample_triad(&imu->gyro, omega_ib_b_radps, gyro_radps);
	sample_triad(&imu->accel, force_b_mps2, accel_mps2);
}

/* ---- magnetometer ---- */

fw_status fw_magnetometer_init(const fw_magnetometer_model *model, uint64_t seed, fw_magnetometer *m)
{
	const double sigmas[] = {model->noise_ut, model->quantum_ut};
	if (!all_not_negative(sigmas, 2))
		return FW_EINVAL;
	for (int i = 0; i < 3; i++) {
		if (!isfinite(model->hard_iron_ut[i]))
			return FW_EINVAL;
		for (int j = 0; j < 3; j++)
			if (!isfinite(model->soft_iron[i][j]))
				return FW_EINVAL;
	}
	m->model = *model;
	fw_random_init(&m->random, seed);
	return FW_OK;
}

void fw_magnetometer_sample(fw_magnetometer *m, const double C_n_b[static 3][3],
                            const double field_ned_nt[static 3], double mag_b_ut[static 3])
{
	double field[3];
	for (int i = 0; i < 3; i++)
		field[i] = (C_n_b[0][i] * field_ned_nt[0] + C_n_b[1][i] * field_ned_nt[1] +
		            C_n_b[2][i] * field_ned_nt[2]) /
		           1000;
	for (int i = 0; i < 3; i++) {
		double reading =
		    field[i] + m->model.hard_iron_ut[i] + m->model.noise_ut * fw_random_normal(&m->random);
		for (int j = 0; j < 3; j++)
			reading += m->model.soft_iron[i][j] * field[j];
		mag_b_ut[i] = quantised(reading, m->model.quantum_ut);
	}
}

/* ---- barometer ---- */

fw_status fw_barometer_init(const fw_barometer_model *model, double interval_s, uint64_t seed,
                            fw_barometer *b)
{
	const double numbers[] = {model->bias_sd_m, model->drift_sd_m, model->noise_m, model->quantum_m};
	if (!(interval_s > 0 && isfinite(interval_s)) || !all_not_negative(numbers, 4) ||
	    (model->drift_sd_m > 0 && !(model->drift_tau_s > 0 && isfinite(model->drift_tau_s))))
		return FW_EINVAL;
	memset(b, 0, sizeof *b);
	b->model = *model;
	fw_random_init(&b->random, seed);
	b->bias_m = model->bias_sd_m * fw_random_normal(&b->random);
	if (model->drift_sd_m > 0)
		start_markov(&b->drift, model->drift_sd_m, model->drift_tau_s, interval_s, &b->random);
	return FW_OK;
}

double fw_barometer_sample(fw_barometer *b, double height_m)
{
	double drift = b->model.drift_sd_m > 0 ? wander(&b->drift, &b->random) : 0;
	double reading = height_m + b->bias_m + drift + b->model.noise_m * fw_random_normal(&b->random);
	return quantised(reading, b->model.quantum_m);
}

/* ---- receiver clock ---- */

static const struct {
	const char *name;
	fw_clock_model model; /* h0, h-1, h-2, ageing */
} clocks[] = {
    {"tcxo", {2e-19, 7e-21, 2e-20, 0, 0, 0}},
    {"ocxo", {2e-25, 7e-25, 6e-25, 0, 0, 0}},
    /* sigma_y(1 s) = 3e-10 is h0 = 2 sigma^2; floor 1e-11 is h-1 = 1e-22 / (2 ln 2); ageing 9e-10 a month */
    {"csac", {1.8e-19, 7.2e-23, 1e-27, 3.5e-16, 0, 0}},
    {"rubidium", {2e-22, 4.5e-26, 1e-30, 0, 0, 0}},
    {"caesium", {2e-22, 5e-27, 1.5e-33, 0, 0, 0}},
    {"perfect", {0, 0, 0, 0, 0, 0}},
};

fw_status fw_clock_model_named(const char *name, fw_clock_model *model)
{
	for (size_t i = 0; i < sizeof clocks / sizeof clocks[0]; i++) {
		if (strcmp(clocks[i].name, name) == 0) {
			*model = clocks[i].model;
			return FW_OK;
		}
	}
	return FW_EUNKNOWN;
}

fw_status fw_clock_init(const fw_clock_model *model, double interval_s, uint64_t seed, fw_clock *clock)
{
	const double h[] = {model->h0, model->hm1, model->hm2};
	if (!(interval_s > 0 && isfinite(interval_s)) || !all_not_negative(h, 3) ||
	    !isfinite(model->ageing_per_s) || !isfinite(model->offset_s) || !isfinite(model->drift_sps))
		return FW_EINVAL;
	memset(clock, 0, sizeof *clock);
	clock->model = *model;
	clock->interval_s = interval_s;
	clock->offset_s = model->offset_s;
	clock->drift_sps = clock->frequency_sps = model->drift_sps;
	fw_random_init(&clock->random, seed);
	/* S_y = h-2 / f^2 is a walk of the variance 2 pi^2 h-2 each second. */
	start_walk(&clock->walk, 2 * M_PI * M_PI * model->hm2, interval_s);
	start_flicker(&clock->flicker, model->hm1, interval_s, &clock->random);
	return FW_OK;
}

void fw_clock_step(fw_clock *clock)
{
	const double step_s = clock->interval_s;
	/* White FM: the mean of the frequency over a step has the variance h0 / (2 step). */
	double mean = clock->frequency_sps + clock->model.ageing_per_s * step_s / 2 +
	              sqrt(clock->model.h0 / (2 * step_s)) * fw_random_normal(&clock->random) +
	              flicker_mean(&clock->flicker, &clock->random) + wander(&clock->walk, &clock->random);
	clock->frequency_sps += clock->model.ageing_per_s * step_s;
	clock->offset_s += mean * step_s;
	clock->drift_sps = mean;
}
