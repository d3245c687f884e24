/* How much a measurement is believed, besides what it says of itself: covariances that follow protection levels, or the
 * innovations. */
#ifndef FURROW_FUSION_ADAPT_H
#define FURROW_FUSION_ADAPT_H

#include <stdbool.h>

#include "base/status.h"

typedef enum {
	FW_ADAPT_NONE,   /* R as the receiver says */
	FW_ADAPT_PL,     /* R and Q scaled by protection levels: the paper's form */
	FW_ADAPT_GM,     /* a Gauss-Markov error of the fixes, its sigma following the protection levels */
	FW_ADAPT_VB,     /* R learnt from the innovations: variational Bayes */
	FW_ADAPT_STUDENT /* R of each fix from its own innovation: Student's t */
} fw_adapt_mode;

typedef struct {
	fw_adapt_mode mode;

	/* pl: ratio = PL / UL, horizontal and vertical each with its own */
	double hul_m, vul_m; /* the user's levels */
	double tau1, tau2;   /* R times ratio / tau1 while ratio <= 1, times ratio tau2 beyond */
	double tau3, tau4;   /* Q times tau4 / ratio while ratio <= 1, times 1 / (tau3 ratio) beyond */
	double max_age_s;    /* protection levels older than this are none */

	/* gm */
	double gm_tau_s;       /* correlation time of position and velocity errors */
	double gm_k_h, gm_k_v; /* protection level over sigma, horizontal and vertical */
	double gm_share;       /* of the error's variance that stays a while, 0..1; the rest is white */

	/* vb */
	double vb_memory; /* how much of what was learnt is kept from fix to fix, 0..1 */

	/* student */
	double student_dof; /* degrees of freedom, above 2 */
} fw_adapt_options;

/* Protection levels in force. */
typedef struct {
	bool known;
	double hpl_m, vpl_m;
} fw_levels;

/* Factors on variances. */
typedef struct {
	double r_h, r_v; /* of R: horizontal and vertical, position and velocity alike */
	double q;        /* of Q */
} fw_adapt_factors;

/* Factors by protection levels; all 1 when the levels are not known.
 * Source: the paper on EGNOS navigation for survey drones (Fieldcopter), its adaptive filter: the factors grow with PL / UL, in two branches
 * that its taus set. */
fw_adapt_factors fw_adapt_by_levels(const fw_adapt_options *o, const fw_levels *levels);

/* The scale of a variance, learnt: an inverse gamma distribution. */
typedef struct {
	double a, b; /* shape, and sum of squares over two: the scale is b / a */
} fw_vb_scale;

void fw_vb_start(fw_vb_scale *s);

/* The factor of Student's t on R, for an innovation of nis = d^2 with m rows: (dof + d^2) / (dof + m), at least 1. */
double fw_student_factor(double dof, double nis, int m);

#endif
