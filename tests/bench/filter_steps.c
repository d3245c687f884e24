/* How long the filter takes for a sample of the IMU: filter_steps SAMPLES [smooth].
 * 15 states at 200 Hz with a fix every 40 samples; covariance at the IMU's rate. Prints the seconds of the filter, and of smoothing. */
#include <stdio.h>
#include <time.h>

#include "base/random.h"
#include "../flight.h"
#include "fusion/rts.h"

static fw_loose l;
static fw_node *nodes;
static int n_nodes;

static void on_node(void *context, const fw_loose *now)
{
	(void)context;
	nodes[n_nodes++] = now->node;
}

static double now_s(void)
{
	struct timespec t;
	clock_gettime(CLOCK_MONOTONIC, &t);
	return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A vehicle that circles, as an IMU sees it, made without a simulator so that nothing but the filter counts. */
static fw_imu_reading reading(int k)
{
	const double t = k / 200.0;
	return (fw_imu_reading){.time = flight_time(t),
	                        .gyro_radps = {0.01 * sin(t), 0.02 * cos(t), 0.2},
	                        .accel_mps2 = {0.1 * sin(t), 1.0, -9.81}};
}

static double smooth(void)
{
	static fw_smoothed s[2];
	const fw_layout *layout = &l.filter.model.layout;
	const double begin = now_s();
	int status = 0;
	fw_rts_last(layout, &nodes[n_nodes - 1], &s[0]);
	for (int k = n_nodes - 2, at = 0; k >= 0; k--, at = !at)
		status |= fw_rts_step(layout, &nodes[k], &nodes[k + 1], &s[at], &s[!at]);
	return status == FW_OK ? now_s() - begin : -1;
}

int main(int argc, char **argv)
{
	const int samples = argc > 1 ? (int)strtol(argv[1], NULL, 10) : 720000;
	const bool smoothed = argc > 2;
	const fw_loose_hooks hooks = {.node = smoothed ? on_node : NULL};
	const double sd[3] = {0.1, 0.1, 0.1};
	fw_loose_options o = fw_loose_defaults;
	fw_pva start = {
	    .time = flight_time(0), .llh = {0.9, 0.2, 100}, .velocity_mps = {5, 0, 0}, .q_n_b = {1, 0, 0, 0}};
	o.gate = 0;
	nodes = smoothed ? malloc(sizeof *nodes * (size_t)(samples / 40 + 10)) : NULL;
	if (fw_loose_init(&l, &o, &hooks) != FW_OK ||
	    fw_loose_start(&l, &start, sd, sd, sd, NULL, NULL) != FW_OK)
		return 1;
	const double begin = now_s();
	for (int k = 1; k <= samples; k++) {
		const fw_imu_reading s = reading(k);
		if (k % 40 == 0) {
			fw_item item = {.time = s.time, .kind = FW_ITEM_FIX};
			item.fix.has_position = item.fix.has_velocity = true;
			item.fix.llh[0] = 0.9 + 3e-6 * sin(0.2 * k / 200.0);
			item.fix.llh[1] = 0.2 - 5e-6 * cos(0.2 * k / 200.0);
			item.fix.llh[2] = 100;
			item.fix.velocity_mps[0] = 5 * cos(0.2 * k / 200.0);
			item.fix.velocity_mps[1] = 5 * sin(0.2 * k / 200.0);
			for (int i = 0; i < 3; i++)
				item.fix.R_position[i][i] = item.fix.R_velocity[i][i] = 0.01;
			fw_loose_item(&l, &item);
		}
		if (fw_loose_imu(&l, &s) != FW_OK)
			return 1;
	}
	const double forward_s = now_s() - begin;
	printf("%d %.6f %.6f\n", samples, forward_s, smoothed ? smooth() : 0);
	return 0;
}
