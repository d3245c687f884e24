/* Whether the filter is as good as it says: normalised errors and innovations over many runs against their chi-square
 * distributions, forward and smoothed, with white errors and with errors that stay a while. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/matrix.h"
#include "base/random.h"
#include "../flight.h"
#include "fusion/rts.h"

enum { RUNS = 24, SECONDS = 200, NODES_MAX = 2000, FIX_EVERY = 20, FROM = 2000, CHECK_EVERY = 500 };

static flight f;
static fw_loose l;
static fw_node nodes[NODES_MAX];
static fw_smoothed smoothed[NODES_MAX];
static int n_nodes;

static const double lever[3] = {0.1, 0.05, -0.25};
static const double sd_m[3] = {3, 3, 4.5}, sd_mps[3] = {0.7, 0.7, 1.7};

static int make_flight(void **state)
{
	static const fw_waypoint w[] = {{0, 0, 0, 1, 5},      {0, 0, 40, 2, 0},     {300, 0, 40, 8, 0},
	                                {300, 60, 40, 8, 0},  {0, 60, 45, 8, 0},    {0, 120, 45, 8, 0},
	                                {300, 120, 50, 8, 0}, {300, 180, 50, 8, 0}, {0, 0, 40, 8, 300}};
	const fw_trajectory_limits limits = {2, 3, 3, 3, 1, 3};
	(void)state;
	flight_make(&f, FW_VEHICLE_MULTIROTOR, &limits, sizeof w / sizeof w[0], w, SECONDS, 100);
	return 0;
}

static void on_node(void *context, const fw_loose *now)
{
	(void)context;
	nodes[n_nodes++] = now->node;
}

/* Sums over runs. */
typedef struct {
	double nees, nis, nis_rows;
	double inside[2][9], n;
} sums;

static void add_errors(sums *s, const fw_pva *estimate, const fw_pva *truth,
                       const double P[FW_STATES_MAX][FW_STATES_MAX])
{
	double e[9], nav[81], y[9];
	flight_errors(estimate, truth, e);
	for (int i = 0; i < 81; i++)
		nav[i] = P[i / 9][i % 9];
	assert_int_equal(fw_mat_solve_spd(9, 1, nav, e, y), FW_OK);
	for (int i = 0; i < 9; i++) {
		s->nees += e[i] * y[i];
		s->inside[0][i] += fabs(e[i]) < sqrt(P[i][i]);
		s->inside[1][i] += fabs(e[i]) < 2 * sqrt(P[i][i]);
	}
	s->n++;
}

static void begin(int run, fw_adapt_mode mode, fw_imu *imu, fw_random *r, double position[3],
                  double velocity[3])
{
	fw_loose_options o = fw_loose_defaults;
	const fw_loose_hooks hooks = {.node = on_node};
	const double attitude_sd[3] = {0.02, 0.02, 0.1};
	const fw_layout nav = fw_layout_of(0);
	fw_pva guess = f.truth[0];
	double error[9];
	memcpy(o.lever_b, lever, sizeof lever);
	o.adapt.mode = mode;
	o.adapt.gm_share = 1;
	o.gate = 0;
	o.use_still = false;
	o.gyro_matrix = o.accel_matrix = 0; /* this IMU has none */
	o.position_floor_m = o.velocity_floor_mps = 1e-3;
	const fw_imu_model model = {.gyro = {.white = o.gyro_noise,
	                                     .bias_sd = o.gyro_bias_sd,
	                                     .markov_sd = o.gyro_bias_walk,
	                                     .markov_tau_s = o.gyro_bias_tau_s},
	                            .accel = {.white = o.accel_noise,
	                                      .bias_sd = o.accel_bias_sd,
	                                      .markov_sd = o.accel_bias_walk,
	                                      .markov_tau_s = o.accel_bias_tau_s}};
	assert_int_equal(fw_imu_init(&model, 0.01, 1000 + (uint64_t)run, imu), FW_OK);
	fw_random_init(r, 77 + (uint64_t)run);
	for (int i = 0; i < 3; i++) { /* begun with the first fix and its errors */
		position[i] = sd_m[i] * fw_random_normal(r);
		velocity[i] = sd_mps[i] * fw_random_normal(r);
		error[i] = attitude_sd[i] * fw_random_normal(r);
		error[3 + i] = velocity[i];
		error[6 + i] = position[i];
	}
	fw_estimate_add(&nav, error, &guess, NULL);
	n_nodes = 0;
	assert_int_equal(fw_loose_init(&l, &o, &hooks), FW_OK);
	assert_int_equal(fw_loose_start(&l, &guess, attitude_sd, sd_mps, sd_m, NULL, NULL), FW_OK);
}

/* One flight; errors of fixes white, or Gauss-Markov with tau_s. */
static void fly(int run, fw_adapt_mode mode, double tau_s, sums *forward)
{
	const double left = tau_s > 0 ? exp(-0.01 * FIX_EVERY / tau_s) : 0;
	double position[3], velocity[3];
	fw_imu imu;
	fw_random r;
	begin(run, mode, &imu, &r, position, velocity);
	for (int k = 1; k <= f.n; k++) {
		if (k % FIX_EVERY == 0) {
			for (int i = 0; i < 3; i++) {
				const double fresh = sqrt(1 - left * left);
				position[i] = left * position[i] + fresh * sd_m[i] * fw_random_normal(&r);
				velocity[i] = left * velocity[i] + fresh * sd_mps[i] * fw_random_normal(&r);
			}
			const fw_item item = flight_fix(&f, k, lever, position, velocity, sd_m, sd_mps);
			fw_loose_item(&l, &item);
		}
		const fw_imu_reading s = flight_imu(&f, &imu, k);
		assert_int_equal(fw_loose_imu(&l, &s), FW_OK);
		if (k % CHECK_EVERY == 0 && k >= FROM)
			add_errors(forward, &l.filter.pva, &f.truth[k],
			           (const double(*)[FW_STATES_MAX])l.filter.P);
	}
	forward->nis += l.counts.nis_sum;
	forward->nis_rows += (double)l.counts.nis_rows;
}

static void smooth(sums *s)
{
	const fw_layout *layout = &l.filter.model.layout;
	fw_rts_last(layout, &nodes[n_nodes - 1], &smoothed[n_nodes - 1]);
	for (int k = n_nodes - 2; k >= 0; k--)
		assert_int_equal(
		    fw_rts_step(layout, &nodes[k], &nodes[k + 1], &smoothed[k + 1], &smoothed[k]), FW_OK);
	for (int k = FROM / FIX_EVERY; k < n_nodes; k += CHECK_EVERY / FIX_EVERY) {
		fw_pva pva = nodes[k].filtered;
		double x[FW_STATES_MAX];
		memcpy(x, nodes[k].x_filtered, sizeof x);
		fw_estimate_add(layout, smoothed[k].error, &pva, x);
		const int64_t at = (pva.time.ns - f.truth[0].time.ns) / 10000000;
		add_errors(s, &pva, &f.truth[at], (const double(*)[FW_STATES_MAX])smoothed[k].P);
	}
}

/* Errors of one run are correlated in time: the band counts runs, not epochs. */
static void judge(const char *name, const sums *s)
{
	const double nees = s->nees / s->n, band = 1.96 * sqrt(2 * 9.0 / RUNS);
	print_message("%s: NEES %.2f of 9 +- %.2f", name, nees, band);
	if (s->nis_rows > 0)
		print_message(", NIS per row %.3f", s->nis / s->nis_rows);
	print_message("; inside 1 and 2 sigma, mean of states:");
	for (int k = 0; k < 2; k++) {
		double share = 0;
		for (int i = 0; i < 9; i++)
			share += s->inside[k][i] / s->n / 9;
		print_message(" %.3f", share);
		assert_true(fabs(share - (k == 0 ? 0.683 : 0.954)) < 0.05);
	}
	print_message("\n");
	assert_true(fabs(nees - 9) < band);
	if (s->nis_rows > 0)
		assert_true(fabs(s->nis / s->nis_rows - 1) < 1.96 * sqrt(2 / s->nis_rows) + 0.005);
}

static void white_errors(void **state)
{
	(void)state;
	sums forward = {0}, back = {0};
	for (int run = 0; run < RUNS; run++) {
		fly(run, FW_ADAPT_NONE, 0, &forward);
		smooth(&back);
	}
	judge("white, forward", &forward);
	judge("white, smoothed", &back);
}

static void errors_that_stay(void **state)
{
	(void)state;
	sums forward = {0}, back = {0};
	for (int run = 0; run < RUNS; run++) {
		fly(run, FW_ADAPT_GM, 30, &forward);
		smooth(&back);
	}
	judge("Gauss-Markov, forward", &forward);
	judge("Gauss-Markov, smoothed", &back);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(white_errors),
	    cmocka_unit_test(errors_that_stay),
	};
	return cmocka_run_group_tests(tests, make_flight, NULL);
}
