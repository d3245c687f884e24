/* Gauss-Markov processes: the errors that change slowly, each started from its stationary distribution and
 * stepped exactly, whatever the step. */
#ifndef FURROW_SIM_PROCESS_H
#define FURROW_SIM_PROCESS_H

#include "base/random.h"

/* First order: autocorrelation sd^2 exp(-|dt| / tau). Rough: it has no derivative. For multipath and the
 * like. */
typedef struct {
	double value;
} fw_gm1;

/* Second order, critically damped: autocorrelation sd^2 (1 + |dt| / tau) exp(-|dt| / tau). Smooth: `rate`
 * is the derivative of `value`, of standard deviation sd / tau, so that carrier phases and Dopplers can
 * share it. For orbits, clocks and the atmosphere. */
typedef struct {
	double value, rate;
} fw_gm2;

/* A first value out of the stationary distribution. */
void fw_gm1_init(fw_gm1 *p, double sd, fw_random *random);
void fw_gm2_init(fw_gm2 *p, double sd, double tau_s, fw_random *random);

/* The process dt_s >= 0 later. tau_s > 0; tau_s = 0 gives white noise (gm1 only). A fixed number of
 * deviates is drawn. Source: A. Gelb (ed.), Applied Optimal Estimation (1974), 2.4 (table 2.2-1) and 3.8,
 * discretised exactly: Phi = exp(-b dt) [1 + b dt, dt; -b^2 dt, 1 - b dt], Q = P - Phi P Phi^T, P =
 * diag(sd^2, b^2 sd^2), b = 1 / tau. */
void fw_gm1_step(fw_gm1 *p, double sd, double tau_s, double dt_s, fw_random *random);
void fw_gm2_step(fw_gm2 *p, double sd, double tau_s, double dt_s, fw_random *random);

#endif
