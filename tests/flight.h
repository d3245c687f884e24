/* A flight for tests of filters: the true motion of a simulated vehicle and what a perfect IMU feels on it, computed once; and
 * an IMU with errors, fixes with errors, from a seed. */
#ifndef FURROW_TESTS_FLIGHT_H
#define FURROW_TESTS_FLIGHT_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/frame.h"
#include "fusion/loose.h"
#include "sim/sensors.h"
#include "sim/trajectory.h"

enum { FLIGHT_SAMPLES_MAX = 200000 };

typedef struct {
	int rate_hz, n; /* samples k = 0..n, at k / rate_hz */
	fw_pva truth[FLIGHT_SAMPLES_MAX + 1];
	double omega[FLIGHT_SAMPLES_MAX + 1][3],
	    force[FLIGHT_SAMPLES_MAX + 1][3]; /* means over the interval that ends at k */
} flight;

static fw_trajectory flight_path;

static inline fw_time flight_time(double t_s)
{
	return (fw_time){INT64_C(2420) * FW_NS_PER_WEEK + llround(t_s * 1e9)};
}

static inline void flight_state(double t_s, fw_pva *pva)
{
	fw_motion m;
	if (fw_trajectory_at(&flight_path, t_s, &m) != FW_OK)
		abort();
	pva->time = flight_time(t_s);
	pva->llh[0] = m.lat_rad;
	pva->llh[1] = m.lon_rad;
	pva->llh[2] = m.height_m;
	memcpy(pva->velocity_mps, m.velocity_ned_mps, sizeof pva->velocity_mps);
	fw_quat_from_matrix(m.C_n_b, pva->q_n_b);
}

static inline void flight_make(flight *f, fw_vehicle vehicle, const fw_trajectory_limits *limits,
                               int n_waypoints, const fw_waypoint *waypoints, double seconds, int rate_hz)
{
	const fw_trajectory_setup setup = {
	    .vehicle = vehicle, .origin_llh = {0.9084, 0.1998, 120}, .limits = *limits};
	int bad;
	if (fw_trajectory_from_waypoints(&setup, n_waypoints, waypoints, &flight_path, &bad) != FW_OK)
		abort();
	f->rate_hz = rate_hz;
	f->n = (int)lround(seconds * rate_hz);
	for (int k = 0; k <= f->n; k++) {
		flight_state((double)k / rate_hz, &f->truth[k]);
		if (k > 0 && fw_trajectory_average(&flight_path, (k - 1.0) / rate_hz, (double)k / rate_hz,
		                                   f->omega[k], f->force[k]) != FW_OK)
			abort();
	}
}

/* The reading of an IMU at sample k. */
static inline fw_imu_reading flight_imu(const flight *f, fw_imu *imu, int k)
{
	fw_imu_reading r = {.time = f->truth[k].time};
	fw_imu_sample(imu, f->omega[k], f->force[k], r.gyro_radps, r.accel_mps2);
	return r;
}

/* A fix of an antenna at sample k whose errors are given, NED; sd: what it says of itself. */
static inline fw_item flight_fix(const flight *f, int k, const double lever_b[3], const double error_m[3],
                                 const double error_mps[3], const double sd_m[3], const double sd_mps[3])
{
	const fw_pva *t = &f->truth[k];
	const double none[3] = {0};
	fw_item item = {.time = t->time, .kind = FW_ITEM_FIX};
	fw_motion m;
	double C[3][3], lever_n[3], omega_n[3], w[3], around[3];
	fw_earth e;
	if (fw_trajectory_at(&flight_path, (double)k / f->rate_hz, &m) != FW_OK)
		abort();
	fw_quat_to_matrix(t->q_n_b, C);
	fw_earth_at(t->llh, t->velocity_mps, &e);
	(void)none;
	for (int i = 0; i < 3; i++) {
		lever_n[i] = C[i][0] * lever_b[0] + C[i][1] * lever_b[1] + C[i][2] * lever_b[2];
		omega_n[i] = C[i][0] * m.omega_ib_b_radps[0] + C[i][1] * m.omega_ib_b_radps[1] +
		             C[i][2] * m.omega_ib_b_radps[2];
		w[i] = omega_n[i] - e.omega_ie_n[i] - e.omega_en_n[i];
	}
	around[0] = w[1] * lever_n[2] - w[2] * lever_n[1];
	around[1] = w[2] * lever_n[0] - w[0] * lever_n[2];
	around[2] = w[0] * lever_n[1] - w[1] * lever_n[0];
	item.fix.has_position = item.fix.has_velocity = true;
	item.fix.llh[0] = t->llh[0] + (lever_n[0] + error_m[0]) / e.M_m;
	item.fix.llh[1] = t->llh[1] + (lever_n[1] + error_m[1]) / (e.N_m * e.cos_lat);
	item.fix.llh[2] = t->llh[2] - (lever_n[2] + error_m[2]);
	for (int i = 0; i < 3; i++) {
		item.fix.velocity_mps[i] = t->velocity_mps[i] + around[i] + error_mps[i];
		item.fix.R_position[i][i] = sd_m[i] * sd_m[i];
		item.fix.R_velocity[i][i] = sd_mps[i] * sd_mps[i];
	}
	return item;
}

/* Errors of an estimate, truth minus estimate, of the nine states of navigation. */
static inline void flight_errors(const fw_pva *estimate, const fw_pva *truth, double error[9])
{
	const fw_layout nav = fw_layout_of(0);
	fw_estimate_difference(&nav, estimate, NULL, truth, NULL, error);
}

#endif
