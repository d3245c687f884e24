/* The receiver: measurements against the equations in its header, noise against its formulas, solutions
 * against their own covariance, faults against what they are to do. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "sim/constellation.h"
#include "sim/receiver.h"

#define C   299792458.0
#define DEG 0.017453292519943295

enum { ROOM = 4096 };

static fw_ephemeris list[ROOM];
static fw_sky sky;
static fw_receiver receiver;
static fw_epoch epoch;
static const double llh[3] = {0.9084, 0.1998, 120};
static const double clock_s = 1.25e-5, drift_sps = 3e-8;

static fw_time at(double s)
{
	fw_time t = {0};
	assert_int_equal(fw_time_parse("2026-06-10T08:00:00", &t), FW_OK);
	return fw_time_add_ns(t, llround(s * 1e9));
}

static void begin_sky(double error_m, uint64_t seed)
{
	fw_sky_errors errors = {
	    .radial_m = error_m,
	    .clock_m = error_m,
	    .orbit_tau_s = 3600,
	    .clock_tau_s = 3600,
	    .iono_tau_s = 3600,
	    .tropo_tau_s = 3600,
	    .klobuchar = {{1e-8, 1.5e-8, -6e-8, -6e-8}, {90112, 32768, -196608, -131072}}};
	unsigned n = 0;
	assert_int_equal(fw_constellation(at(0), at(3600), 15, ROOM, list, &n), FW_OK);
	assert_int_equal(fw_sky_init(&sky, &errors, list, n, at(0), seed), FW_OK);
}

static void track(fw_receiver_setup *s, fw_system system, unsigned k, char band, char attribute)
{
	assert_int_equal(fw_tracked_signal_named(system, (fw_signal){band, attribute}, &s->signal[system][k]),
	                 FW_OK);
}

/* Next to no noise. */
static fw_receiver_setup quiet(void)
{
	fw_receiver_setup s = {.station = FW_STATION_ROVER};
	track(&s, FW_GPS, 0, '1', 'C');
	track(&s, FW_GPS, 1, '2', 'W');
	track(&s, FW_GPS, 2, '5', 'Q');
	track(&s, FW_GALILEO, 0, '1', 'C');
	track(&s, FW_GALILEO, 1, '5', 'Q');
	track(&s, FW_BEIDOU, 0, '2', 'I');
	track(&s, FW_BEIDOU, 1, '5', 'P');
	track(&s, FW_GLONASS, 0, '1', 'C');
	track(&s, FW_GLONASS, 1, '2', 'C');
	s.noise = (fw_receiver_noise){.elevation_mask_rad = 5 * DEG,
	                              .cn0_zenith_dbhz = 51,
	                              .cn0_horizon_dbhz = 36,
	                              .cn0_track_dbhz = 20,
	                              .dll_hz = 1e-12,
	                              .pll_hz = 1e-10,
	                              .fll_hz = 1e-12,
	                              .integration_s = 0.02,
	                              .multipath_scale_rad = 20 * DEG};
	s.pvt = (fw_pvt_setup){.elevation_mask_rad = 10 * DEG, .k_h = 6, .k_v = 5.33};
	memcpy(s.origin_llh, llh, sizeof llh);
	return s;
}

static fw_receiver_setup noisy(void)
{
	fw_receiver_setup s = quiet();
	s.noise.dll_hz = 0.25;
	s.noise.pll_hz = 15;
	s.noise.fll_hz = 2;
	s.noise.multipath_m = 1;
	s.noise.multipath_tau_s = 0;
	return s;
}

static fw_antenna antenna_at(double t_s)
{
	static const double velocity[3] = {3, 1, -2};
	fw_antenna a = {.t_s = t_s};
	assert_int_equal(fw_llh_to_ecef(llh, a.position_m), FW_OK);
	for (int i = 0; i < 3; i++) {
		a.velocity_mps[i] = velocity[i];
		a.position_m[i] += t_s * velocity[i];
	}
	assert_true(fw_ecef_to_llh(a.position_m, a.llh) >= 0);
	return a;
}

static fw_antenna measure(double t_s)
{
	double clock = clock_s + drift_sps * t_s;
	fw_antenna a = antenna_at(t_s - clock);
	fw_sky_advance(&sky, at(t_s));
	fw_receiver_measure(&receiver, &sky, at(t_s), clock, drift_sps, &a, &epoch);
	return a;
}

static fw_status solve(double t_s, fw_receiver_solution *solution)
{
	fw_antenna a = measure(t_s);
	return fw_receiver_solve(&receiver, &sky, &epoch, clock_s + drift_sps * t_s, drift_sps, &a, solution);
}

static double wavelength(const fw_observation *o)
{
	return C / fw_signal_frequency_hz((fw_system)o->satellite.system, o->signal, o->glonass_channel);
}

static double iono_scale(const fw_observation *o)
{
	double ratio = wavelength(o) / (C / 1575.42e6);
	return ratio * ratio;
}

/* ---- measurements ---- */

/* code - lambda carrier = 2 q I - lambda N, with N an integer that stays. */
static void test_ambiguities(void **state)
{
	(void)state;
	static double first[FW_EPOCH_MAX];
	fw_receiver_setup setup = quiet();
	unsigned n = 0;
	begin_sky(1, 1);
	fw_receiver_init(&receiver, &setup, 1);
	for (double t = 0; t < 30; t += 0.5) {
		measure(t);
		n = t == 0 ? epoch.n : n;
		assert_int_equal(epoch.n, n);
		for (unsigned i = 0; i < epoch.n; i++) {
			const fw_observation *o = &epoch.obs[i];
			const fw_measured *m = NULL;
			for (unsigned k = 0; k < receiver.n_measured; k++)
				if (receiver.measured[k].observation <= i)
					m = &receiver.measured[k];
			double N =
			    o->carrier_cyc - (o->code_m - 2 * iono_scale(o) * m->iono_m) / wavelength(o);
			assert_true(fabs(N - nearbyint(N)) < 2e-3);
			assert_true(t == 0 || nearbyint(N) == first[i]);
			assert_int_equal(o->slip, t == 0);
			assert_true(fabs(o->lock_s - t) < 1e-6);
			first[i] = nearbyint(N);
		}
	}
	assert_true(n > 60);
}

/* The code of the first satellites put together by hand from the sky. */
static void test_code(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	begin_sky(1, 2);
	fw_receiver_init(&receiver, &setup, 2);
	fw_antenna a = measure(7);
	for (unsigned k = 0; k < receiver.n_measured; k++) {
		const fw_measured *m = &receiver.measured[k];
		const fw_observation *o = &epoch.obs[m->observation];
		fw_sky_view v;
		double iono, tropo, delay_s = 0;
		fw_time t = at(7 - clock_s - 7 * drift_sps);
		assert_true(fw_sky_look(&sky, m->satellite, t, a.position_m, a.velocity_mps, a.llh, &v));
		fw_sky_delays(&sky, m->satellite, t, &v, a.llh, &iono, &tropo);
		(void)!fw_ephemeris_group_delay(sky.satellite[m->satellite].ephemerides, o->signal, &delay_s);
		double code = v.range_m + C * (clock_s + 7 * drift_sps) - v.clock_m + C * delay_s + tropo +
		              iono_scale(o) * iono;
		assert_true(fabs(o->code_m - code) < 1e-3);
		assert_true(o->code_m > 1.8e7 && o->code_m < 4.3e7);
	}
}

/* The Doppler is minus the derivative of the carrier: over 0.1 s the mean of both ends, to what the third
 * derivative and the delays, whose rates come an epoch late, leave. */
static void test_doppler(void **state)
{
	(void)state;
	static fw_epoch before;
	fw_receiver_setup setup = quiet();
	begin_sky(1, 3);
	fw_receiver_init(&receiver, &setup, 3);
	for (double t = 0; t < 25; t += 0.1) {
		before = epoch;
		measure(t);
		if (t < 0.15)
			continue;
		assert_int_equal(before.n, epoch.n);
		for (unsigned i = 0; i < epoch.n; i++) {
			double cycles = epoch.obs[i].carrier_cyc - before.obs[i].carrier_cyc;
			double mean = 0.5 * (epoch.obs[i].doppler_hz + before.obs[i].doppler_hz);
			assert_true(fabs(cycles + 0.1 * mean) * wavelength(&epoch.obs[i]) < 5e-5);
		}
	}
}

/* Computed in Python from the formulas of Kaplan and Hegarty for 45 dB-Hz. */
static void test_noise_formulas(void **state)
{
	(void)state;
	fw_receiver_noise n = {.dll_hz = 0.25, .pll_hz = 15, .fll_hz = 2, .integration_s = 0.02};
	fw_tracked_signal ca;
	assert_int_equal(fw_tracked_signal_named(FW_GPS, (fw_signal){'1', 'C'}, &ca), FW_OK);
	assert_true(fabs(fw_dll_noise_m(&n, &ca, 45) - 0.1844001142313694) < 1e-12);
	assert_true(fabs(fw_pll_noise_m(&n, C / 1575.42e6, 45) - 0.0006598750557391085) < 1e-15);
	assert_true(fabs(fw_fll_noise_mps(&n, C / 1575.42e6, 45) - 0.024104745284376106) < 1e-14);
	assert_int_equal(fw_tracked_signal_named(FW_GPS, (fw_signal){'7', 'Q'}, &ca), FW_EUNKNOWN);
}

/* Scatter of code minus carrier of one signal, to which noise and white multipath contribute: 1,500 epochs,
 * 6 %. */
static void test_noise_size(void **state)
{
	(void)state;
	fw_receiver_setup setup = noisy();
	double sum = 0, squares = 0, expected = 0;
	const int n = 1500;
	begin_sky(0, 4);
	fw_receiver_init(&receiver, &setup, 4);
	for (int i = 0; i < n; i++) {
		measure(0.2 * i);
		const fw_measured *m = &receiver.measured[0];
		const fw_observation *o = &epoch.obs[m->observation];
		double x = o->code_m - wavelength(o) * o->carrier_cyc - 2 * m->iono_m;
		sum += x / n;
		squares += x * x / n;
		double dll = fw_dll_noise_m(&setup.noise, &setup.signal[0][0], o->cn0_dbhz);
		double multipath = exp(-m->view.elevation_rad / (20 * DEG));
		expected += (dll * dll + multipath * multipath) / n;
	}
	assert_true(fabs(sqrt((squares - sum * sum) / expected) - 1) < 0.06);
}

/* ---- loss of lock ---- */

static void test_slip_fault(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	setup.n_faults = 1;
	setup.fault[0] = (fw_fault){.kind = FW_FAULT_SLIP,
	                            .window = {5, INFINITY},
	                            .stations = FW_STATION_ROVER,
	                            .satellites = {{[FW_GPS] = UINT64_MAX}}};
	begin_sky(0, 5);
	fw_receiver_init(&receiver, &setup, 5);
	for (int t = 0; t < 10; t++) {
		measure(t + 0.01);
		for (unsigned i = 0; i < epoch.n; i++) {
			bool gps = epoch.obs[i].satellite.system == FW_GPS;
			assert_int_equal(epoch.obs[i].slip, t == 0 || (gps && t == 5));
			assert_true(fabs(epoch.obs[i].lock_s - (gps && t >= 5 ? t - 5 : t)) < 1e-6);
		}
	}
}

/* 3,600 slips per hour at 45 dB-Hz are one per second on a signal of that strength; here they are counted
 * on many. */
static void test_random_slips(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	unsigned slips = 0;
	double expected = 0;
	setup.noise.slips_per_hour = 36;
	begin_sky(0, 6);
	fw_receiver_init(&receiver, &setup, 6);
	for (int t = 0; t < 200; t++) {
		measure(t);
		for (unsigned i = 0; t > 0 && i < epoch.n; i++) {
			slips += epoch.obs[i].slip;
			expected += 0.01 * pow(10, (45 - epoch.obs[i].cn0_dbhz) / 10);
		}
	}
	assert_true(expected > 100);
	assert_true(fabs(slips - expected) < 4 * sqrt(expected) + 0.05 * expected);
}

/* Half cycles: on about half of the channels, until they are settled. */
static void test_half_cycles(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	unsigned halves = 0, n = 0;
	setup.noise.half_cycle_s = 2.5;
	begin_sky(0, 7);
	fw_receiver_init(&receiver, &setup, 7);
	for (int t = 0; t < 6; t++) {
		measure(t);
		for (unsigned k = 0; k < receiver.n_measured; k++) {
			const fw_observation *o = &epoch.obs[receiver.measured[k].observation];
			double N =
			    o->carrier_cyc -
			    (o->code_m - 2 * iono_scale(o) * receiver.measured[k].iono_m) / wavelength(o);
			bool half = fabs(N - nearbyint(N)) > 0.25;
			assert_int_equal(o->half_cycle, t < 3);
			assert_false(half && t >= 3);
			halves += half && t == 0;
			n += t == 0;
		}
	}
	assert_true(halves > n / 5 && halves < n - n / 5);
}

/* ---- masks ---- */

/* Of the satellites measured, how many stand higher than this one. */
static unsigned higher_than(unsigned k)
{
	unsigned n = 0;
	for (unsigned i = 0; i < receiver.n_measured; i++)
		n += receiver.measured[i].view.elevation_rad > receiver.measured[k].view.elevation_rad;
	return n;
}

/* While the mask is on, the two satellites that were the highest are left, and no position. */
static void test_keep(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	fw_receiver_solution s;
	unsigned highest[2] = {0};
	setup.n_masks = 1;
	setup.mask[0] = (fw_mask){.window = {10, 20},
	                          .stations = FW_STATION_ROVER,
	                          .below_rad = 2,
	                          .keep = 2,
	                          .attenuation_db = INFINITY};
	memset(&setup.mask[0].satellites, 0xff, sizeof setup.mask[0].satellites);
	begin_sky(0, 8);
	fw_receiver_init(&receiver, &setup, 8);
	for (int t = 0; t < 30; t++) {
		bool masked = t >= 10 && t < 20;
		assert_int_equal(solve(t + 0.1, &s), masked ? FW_ENOSPACE : FW_OK);
		for (unsigned k = 0; k < receiver.n_measured && t == 9; k++)
			if (higher_than(k) < 2)
				highest[higher_than(k)] = receiver.measured[k].satellite;
		if (!masked) {
			assert_true(receiver.n_measured > 20);
			continue;
		}
		assert_int_equal(receiver.n_measured, 2);
		for (unsigned k = 0; k < 2; k++)
			assert_true(receiver.measured[k].satellite == highest[0] ||
			            receiver.measured[k].satellite == highest[1]);
	}
}

static void test_attenuation(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	setup.n_masks = 1;
	setup.mask[0] = (fw_mask){.window = {10, 20},
	                          .stations = FW_STATION_ROVER,
	                          .satellites = {{[FW_GALILEO] = UINT64_MAX}},
	                          .below_rad = 2,
	                          .attenuation_db = 7};
	begin_sky(0, 9);
	fw_receiver_init(&receiver, &setup, 9);
	measure(9);
	static fw_epoch before;
	before = epoch;
	measure(11);
	assert_int_equal(before.n, epoch.n);
	for (unsigned i = 0; i < epoch.n; i++) {
		double wanted = epoch.obs[i].satellite.system == FW_GALILEO ? 7 : 0;
		assert_true(fabs(before.obs[i].cn0_dbhz - epoch.obs[i].cn0_dbhz - wanted) < 0.05);
	}
}

/* ---- solutions ---- */

static void error_of(const fw_receiver_solution *s, const fw_antenna *a, double error[static 3])
{
	double p[3], C_e_n[3][3], d[3];
	assert_int_equal(fw_llh_to_ecef(s->llh, p), FW_OK);
	fw_frame_ned(a->llh[0], a->llh[1], C_e_n);
	for (int i = 0; i < 3; i++)
		d[i] = p[i] - a->position_m[i];
	fw_mat3_t_vec(C_e_n, d, error);
}

/* Errors fit the covariance: the mean of e^T P^-1 e over independent epochs is 3, its scatter sqrt(6 / n). */
static void test_consistency(void **state)
{
	(void)state;
	fw_receiver_setup setup = noisy();
	double nees = 0, rate_nees = 0;
	const int n = 250;
	int inside = 0;
	for (int i = 0; i < n; i++) {
		fw_receiver_solution s;
		double P[9], V[9], inverse[9], e[3], v_n[3], C_e_n[3][3];
		begin_sky(2, (uint64_t)i);
		fw_receiver_init(&receiver, &setup, (uint64_t)i + 1000);
		measure(0);
		fw_antenna a = antenna_at(1 - clock_s - drift_sps);
		assert_int_equal(solve(1, &s), FW_OK);
		for (int k = 0; k < 9; k++) {
			P[k] = s.covariance_m2[k / 3][k % 3];
			V[k] = s.velocity_covariance_m2ps2[k / 3][k % 3];
		}
		error_of(&s, &a, e);
		assert_int_equal(fw_mat_inverse_spd(3, P, inverse), FW_OK);
		for (int k = 0; k < 9; k++)
			nees += e[k / 3] * inverse[k] * e[k % 3] / n;
		fw_frame_ned(a.llh[0], a.llh[1], C_e_n);
		fw_mat3_t_vec(C_e_n, a.velocity_mps, v_n);
		assert_int_equal(fw_mat_inverse_spd(3, V, inverse), FW_OK);
		for (int k = 0; k < 9; k++)
			rate_nees += (s.velocity_ned_mps[k / 3] - v_n[k / 3]) * inverse[k] *
			             (s.velocity_ned_mps[k % 3] - v_n[k % 3]) / n;
		inside += hypot(e[0], e[1]) < s.hpl_m && fabs(e[2]) < s.vpl_m;
	}
	assert_true(fabs(nees - 3) < 4 * sqrt(6.0 / n));
	assert_true(fabs(rate_nees - 3) < 4 * sqrt(6.0 / n));
	assert_int_equal(inside, n);
}

/* RTCA DO-229, J.2.1: HPL = K_H times the half axis of the error ellipse, VPL = K_V times the vertical
 * sigma. DOPs are those of unit weights. */
static void test_protection_levels(void **state)
{
	(void)state;
	fw_receiver_setup setup = noisy();
	fw_receiver_solution s;
	begin_sky(1, 11);
	fw_receiver_init(&receiver, &setup, 11);
	assert_int_equal(solve(2, &s), FW_OK);
	double a = s.covariance_m2[0][0], b = s.covariance_m2[1][1], c = s.covariance_m2[0][1];
	assert_true(fabs(s.hpl_m - 6 * sqrt((a + b) / 2 + sqrt((a - b) * (a - b) / 4 + c * c))) < 1e-9);
	assert_true(fabs(s.vpl_m - 5.33 * sqrt(s.covariance_m2[2][2])) < 1e-9);
	assert_true(s.hdop > 0.3 && s.hdop < 1 && s.vdop > 0.5 && s.vdop < 1.6);
	assert_true(fabs(s.pdop * s.pdop - s.hdop * s.hdop - s.vdop * s.vdop) < 1e-9);
	assert_int_equal(s.systems, 15);
}

/* SBAS leaves of orbit and clock errors what it is told to. */
static void test_sbas(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	double error[2][3];
	for (int sbas = 0; sbas < 2; sbas++) {
		fw_receiver_solution s;
		setup.pvt.sbas = sbas;
		setup.pvt.sbas_rest = 0.25;
		begin_sky(5, 12);
		fw_receiver_init(&receiver, &setup, 12);
		assert_int_equal(solve(3, &s), FW_OK);
		fw_antenna a = antenna_at(3 - clock_s - 3 * drift_sps);
		error_of(&s, &a, error[sbas]);
	}
	for (int i = 0; i < 3; i++)
		assert_true(fabs(error[1][i] - 0.25 * error[0][i]) < 0.3);
}

static void test_sections(void **state)
{
	(void)state;
	fw_receiver_setup setup = noisy();
	double sum[2][6] = {{0}};
	const int n = 1500;
	setup.pvt.n_sections = 2;
	setup.pvt.section[0] = (fw_pvt_section){{0, 300}, 10, 20, 0.5, 3};
	setup.pvt.section[1] = (fw_pvt_section){{300, 600}, 30, 50, 1.4, 3.5};
	begin_sky(1, 13);
	fw_receiver_init(&receiver, &setup, 13);
	for (int i = 0; i < 2 * n; i++) {
		fw_receiver_solution s;
		double e[3], t = 0.2 * i + 0.1, v_n[3], C_e_n[3][3];
		assert_int_equal(solve(t, &s), FW_OK);
		fw_antenna a = antenna_at(t - clock_s - t * drift_sps);
		fw_frame_ned(a.llh[0], a.llh[1], C_e_n);
		fw_mat3_t_vec(C_e_n, a.velocity_mps, v_n);
		error_of(&s, &a, e);
		for (int k = 0; k < 3; k++) {
			sum[i / n][k] += e[k] * e[k] / n;
			sum[i / n][3 + k] += pow(s.velocity_ned_mps[k] - v_n[k], 2) / n;
		}
		assert_true(fabs(s.covariance_m2[0][0] - (i < n ? 10 : 30)) < 1e-12);
		assert_true(fabs(s.vpl_m - 5.33 * sqrt(i < n ? 20 : 50)) < 1e-9);
	}
	static const double wanted[2][6] = {{10, 10, 20, 0.5, 0.5, 3}, {30, 30, 50, 1.4, 1.4, 3.5}};
	for (int i = 0; i < 12; i++) /* a variance of 1,500 draws scatters by 3.7 % */
		assert_true(fabs(sum[i / 6][i % 6] / wanted[i / 6][i % 6] - 1) < 0.15);
}

/* ---- faults ---- */

static void with_fault(fw_fault f, double *before, double *after)
{
	fw_receiver_setup setup = quiet();
	double *error[2] = {before, after};
	f.window = (fw_window){10, INFINITY};
	f.stations = FW_STATION_ROVER;
	memset(&f.satellites, 0xff, sizeof f.satellites);
	setup.n_faults = 1;
	setup.fault[0] = f;
	begin_sky(0, 14);
	fw_receiver_init(&receiver, &setup, 14);
	for (int k = 0; k < 2; k++) {
		fw_receiver_solution s;
		double t = k == 0 ? 5 : 15;
		assert_int_equal(solve(t, &s), FW_OK);
		fw_antenna a = antenna_at(t - clock_s - t * drift_sps);
		error_of(&s, &a, error[k]);
		error[k][3] = s.clock_m - C * (clock_s + t * drift_sps);
	}
}

/* All ranges longer by the same: the clock takes it. */
static void test_common_step(void **state)
{
	(void)state;
	double before[4], after[4];
	with_fault((fw_fault){.kind = FW_FAULT_STEP, .size_m = 30}, before, after);
	for (int i = 0; i < 3; i++)
		assert_true(fabs(after[i] - before[i]) < 0.3);
	assert_true(fabs(after[3] - before[3] - 30) < 0.3);
}

/* Dragged off from a start at the truth: 5 s at this velocity. */
static void test_drag_off(void **state)
{
	(void)state;
	double before[4], after[4];
	with_fault(
	    (fw_fault){.kind = FW_FAULT_DRAG_OFF, .offset_ned_m = {1, 0, 0}, .rate_ned_mps = {2, -1, 0.5}},
	    before, after);
	static const double wanted[3] = {1 + 2 * 5, -1 * 5, 0.5 * 5};
	for (int i = 0; i < 3; i++)
		assert_true(fabs(after[i] - before[i] - wanted[i]) < 0.3);
	assert_true(fabs(after[3] - before[3]) < 0.5);
}

/* Every receiver in reach of a meacon finds itself at the meacon's place, with a clock that is late. */
static void test_meacon(void **state)
{
	(void)state;
	double before[4], after[4];
	with_fault((fw_fault){.kind = FW_FAULT_MEACON, .offset_ned_m = {100, 200, -30}, .delay_m = 50},
	           before, after);
	fw_antenna a = antenna_at(15 - clock_s - 15 * drift_sps);
	double origin[3], C_e_n[3][3], d[3], from_origin[3];
	assert_int_equal(fw_llh_to_ecef(llh, origin), FW_OK);
	fw_frame_ned(llh[0], llh[1], C_e_n);
	for (int i = 0; i < 3; i++)
		d[i] = a.position_m[i] - origin[i];
	fw_mat3_t_vec(C_e_n, d, from_origin);
	double offset[3] = {100 - from_origin[0], 200 - from_origin[1], -30 - from_origin[2]};
	for (int i = 0; i < 3; i++)
		assert_true(fabs(after[i] - before[i] - offset[i]) < 0.5);
	double way = sqrt(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
	assert_true(fabs(after[3] - before[3] - way - 50) < 0.5);
}

static void test_ramp_on_one(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	begin_sky(0, 15);
	fw_receiver_init(&receiver, &setup, 15);
	measure(1);
	fw_satellite victim = epoch.obs[0].satellite;
	setup.n_faults = 1;
	setup.fault[0] = (fw_fault){
	    .kind = FW_FAULT_RAMP, .window = {10, 20}, .stations = FW_STATION_ROVER, .rate_mps = 0.5};
	setup.fault[0].satellites.bits[victim.system] = UINT64_C(1) << victim.number;
	for (int k = 0; k < 2; k++) {
		static fw_epoch without;
		fw_receiver_init(&receiver, &setup, 15);
		begin_sky(0, 15);
		fw_antenna a = measure(9);
		a = measure(14);
		if (k == 0)
			without = epoch;
		else
			for (unsigned i = 0; i < epoch.n; i++) {
				bool hit = fw_satellite_equal(epoch.obs[i].satellite, victim);
				assert_true(fabs(without.obs[i].code_m - epoch.obs[i].code_m -
				                 (hit ? 0.5 * (a.t_s - 10) : 0)) < 1e-3);
				assert_false(epoch.obs[i].slip);
			}
		setup.n_faults = 0;
	}
}

static void test_no_pvt(void **state)
{
	(void)state;
	fw_receiver_setup setup = quiet();
	fw_receiver_solution s;
	setup.n_faults = 1;
	setup.fault[0] = (fw_fault){.kind = FW_FAULT_NO_PVT, .window = {5, 6}, .stations = FW_STATION_ROVER};
	begin_sky(0, 16);
	fw_receiver_init(&receiver, &setup, 16);
	assert_int_equal(solve(4.5, &s), FW_OK);
	assert_int_equal(solve(5.5, &s), FW_ENOSPACE);
	assert_int_equal(solve(6.5, &s), FW_OK);
}

/* ---- attitude ---- */

static void test_attitude(void **state)
{
	(void)state;
	fw_receiver_setup setup = noisy();
	fw_receiver_attitude att = {0};
	fw_receiver_solution s;
	double C_n_b[3][3], rpy[3] = {0.02, -0.05, 6.2}, scatter = 0, expected = 0;
	const int n = 1000;
	setup.attitude_noise_m = 0.01;
	fw_euler_to_matrix(rpy, C_n_b);
	begin_sky(0, 17);
	fw_receiver_init(&receiver, &setup, 17);
	fw_antenna a = antenna_at(0);
	assert_int_equal(solve(0, &s), FW_OK);
	assert_int_equal(fw_receiver_attitude_of(&receiver, C_n_b, &a, &s, &att),
	                 FW_ENOSPACE); /* no baseline */
	receiver.setup.baseline_b_m[0] = 2;
	receiver.setup.noise.multipath_tau_s = 1;
	for (int i = 0; i < n; i++) {
		receiver.dt_s = 1;
		assert_int_equal(fw_receiver_attitude_of(&receiver, C_n_b, &a, &s, &att), FW_OK);
		scatter += pow(fw_wrap_pi(att.heading_rad - 6.2), 2) / n;
		expected += att.sd_heading_rad * att.sd_heading_rad / n;
		assert_true(fabs(att.pitch_rad + 0.05) < 5 * att.sd_pitch_rad);
	}
	assert_true(fabs(att.sd_heading_rad - 0.01 * s.hdop / 2) < 1e-12);
	assert_true(fabs(scatter / expected - 1) < 0.2);
	s.n_used = 4;
	assert_int_equal(fw_receiver_attitude_of(&receiver, C_n_b, &a, &s, &att), FW_ENOSPACE);
	assert_int_equal(fw_receiver_attitude_of(&receiver, C_n_b, &a, NULL, &att), FW_ENOSPACE);
}

/* ---- seeds ---- */

static void test_seeds(void **state)
{
	(void)state;
	static fw_epoch first;
	fw_receiver_setup setup = noisy();
	for (int k = 0; k < 3; k++) {
		begin_sky(1, 18);
		fw_receiver_init(&receiver, &setup, k == 2 ? 19 : 18);
		measure(1);
		if (k == 0)
			first = epoch;
		for (unsigned i = 0; i < epoch.n; i++)
			assert_int_equal(first.obs[i].code_m == epoch.obs[i].code_m, k < 2);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_ambiguities),  cmocka_unit_test(test_code),
	    cmocka_unit_test(test_doppler),      cmocka_unit_test(test_noise_formulas),
	    cmocka_unit_test(test_noise_size),   cmocka_unit_test(test_slip_fault),
	    cmocka_unit_test(test_random_slips), cmocka_unit_test(test_half_cycles),
	    cmocka_unit_test(test_keep),         cmocka_unit_test(test_attenuation),
	    cmocka_unit_test(test_consistency),  cmocka_unit_test(test_protection_levels),
	    cmocka_unit_test(test_sbas),         cmocka_unit_test(test_sections),
	    cmocka_unit_test(test_common_step),  cmocka_unit_test(test_drag_off),
	    cmocka_unit_test(test_meacon),       cmocka_unit_test(test_ramp_on_one),
	    cmocka_unit_test(test_no_pvt),       cmocka_unit_test(test_attitude),
	    cmocka_unit_test(test_seeds),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
