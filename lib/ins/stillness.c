#include "ins/stillness.h"

#include <math.h>
#include <string.h>

fw_stillness_setup fw_stillness_defaults(void)
{
	return (fw_stillness_setup){.window_s = 1,
	                            .gyro_sd_radps = 0.0105,
	                            .accel_sd_mps2 = 0.15,
	                            .gyro_mean_radps = 0.052,
	                            .gravity_mps2 = 9.80665,
	                            .gravity_within_mps2 = 0.6,
	                            .leave = 2,
	                            .speed_mps = 0.3};
}

fw_status fw_stillness_init(const fw_stillness_setup *setup, fw_stillness *s)
{
	const double limits[] = {setup->window_s,        setup->gyro_sd_radps, setup->accel_sd_mps2,
	                         setup->gyro_mean_radps, setup->gravity_mps2,  setup->gravity_within_mps2,
	                         setup->speed_mps};

	for (size_t i = 0; i < sizeof(limits) / sizeof(limits[0]); i++)
		if (!(limits[i] > 0) || !isfinite(limits[i]))
			return FW_EINVAL;
	if (!(setup->leave >= 1))
		return FW_EINVAL;
	*s = (fw_stillness){.setup = *setup, .moving_until = {INT64_MIN}};
	return FW_OK;
}

/* ---- sums ---- */

/* One more sample, by Welford's method: no digits are lost on the mean. */
static void add_sample(fw_stillness_sums *s, double seconds, const double x[6])
{
	s->n++;
	s->seconds += seconds;
	for (int i = 0; i < 6; i++) {
		double off = x[i] - s->mean[i];

		s->mean[i] += off / s->n;
		s->squares[i] += off * (x[i] - s->mean[i]);
	}
}

/* The sums of both together (Chan, Golub and LeVeque). */
static void add_sums(fw_stillness_sums *s, const fw_stillness_sums *more)
{
	double n = s->n + more->n;

	if (more->n == 0)
		return;
	for (int i = 0; i < 6; i++) {
		double off = more->mean[i] - s->mean[i];

		s->mean[i] += off * more->n / n;
		s->squares[i] += more->squares[i] + off * off * s->n * more->n / n;
	}
	s->n = n;
	s->seconds += more->seconds;
}

/* Standard deviation of the samples; with one sample there is none. */
static double sd_of(const fw_stillness_sums *s, int axis)
{
	return s->n > 1 ? sqrt(s->squares[axis] / (s->n - 1)) : 0;
}

static double mean_length(const double *v)
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Whether some samples look like rest, the limits widened by a factor. */
static bool quiet(const fw_stillness *s, const fw_stillness_sums *sums, double wider)
{
	const fw_stillness_setup *limit = &s->setup;

	for (int i = 0; i < 3; i++)
		if (!(sd_of(sums, i) <= wider * limit->gyro_sd_radps) ||
		    !(sd_of(sums, 3 + i) <= wider * limit->accel_sd_mps2))
			return false;
	return mean_length(sums->mean) <= wider * limit->gyro_mean_radps &&
	       fabs(mean_length(sums->mean + 3) - limit->gravity_mps2) <= wider * limit->gravity_within_mps2;
}

/* ---- the stream ---- */

static void begin_anew(fw_stillness *s)
{
	s->still = false;
	s->filled = s->next = 0;
	s->block = (fw_stillness_sums){0};
}

/* A block is full: goes on being still, or begins to be. */
static void judge(fw_stillness *s, fw_time t)
{
	fw_stillness_sums window = {0};

	if (s->still) {
		s->still = quiet(s, &s->block, s->setup.leave);
		add_sums(&s->stretch, &s->held);
		s->held = s->block;
		return;
	}
	for (int i = 0; i < s->filled; i++)
		add_sums(&window, &s->ring[i]);
	if (s->filled < FW_STILLNESS_BLOCKS || fw_time_compare(t, s->moving_until) < 0 ||
	    !quiet(s, &window, 1))
		return;
	s->still = true;
	s->since = fw_time_add_ns(t, -(int64_t)llround(window.seconds * 1e9));
	s->stretch = window;
	s->held = (fw_stillness_sums){0};
}

fw_status fw_stillness_imu(fw_stillness *s, fw_time t, const double omega_ib_b_radps[3],
                           const double force_b_mps2[3])
{
	const double x[6] = {omega_ib_b_radps[0], omega_ib_b_radps[1], omega_ib_b_radps[2],
	                     force_b_mps2[0],     force_b_mps2[1],     force_b_mps2[2]};
	/* Blocks are those of the clock, so that it makes no difference which sample came first. */
	const int64_t block_ns = llround(s->setup.window_s / FW_STILLNESS_BLOCKS * 1e9);
	const bool full = block_ns > 0 && t.ns / block_ns != s->t.ns / block_ns;
	double dt = s->running ? fw_time_diff_s(t, s->t) : 0;

	for (int i = 0; i < 6; i++)
		if (!isfinite(x[i]))
			return FW_ENONFINITE;
	if (s->running && !(dt > 0))
		return FW_EINVAL;
	if (dt > s->setup.window_s / 4)
		begin_anew(s);
	if (s->running && dt <= s->setup.window_s / 4)
		add_sample(&s->block, dt, x);
	s->running = true;
	s->t = t;
	if (!full || s->block.n == 0)
		return FW_OK;
	s->ring[s->next] = s->block;
	s->next = (s->next + 1) % FW_STILLNESS_BLOCKS;
	s->filled += s->filled < FW_STILLNESS_BLOCKS;
	judge(s, t);
	s->block = (fw_stillness_sums){0};
	return FW_OK;
}

void fw_stillness_speed(fw_stillness *s, fw_time t, double speed_mps, double sd_mps)
{
	if (!isfinite(speed_mps) || !(sd_mps >= 0) || !(speed_mps > fmax(s->setup.speed_mps, 3 * sd_mps)))
		return;
	s->still = false;
	s->moving_until = fw_time_add_ns(t, (int64_t)llround(fmin(1.5 * s->setup.window_s, 1e6) * 1e9));
}

fw_status fw_stillness_averages(const fw_stillness *s, fw_stillness_means *m)
{
	if (!s->still)
		return FW_MORE;
	m->since = s->since;
	m->seconds = s->stretch.seconds;
	memcpy(m->omega_ib_b, s->stretch.mean, sizeof(m->omega_ib_b));
	memcpy(m->force_b, s->stretch.mean + 3, sizeof(m->force_b));
	for (int i = 0; i < 3; i++) {
		m->gyro_sd[i] = sd_of(&s->stretch, i);
		m->accel_sd[i] = sd_of(&s->stretch, 3 + i);
	}
	return FW_OK;
}
