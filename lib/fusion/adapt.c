#include "fusion/adapt.h"

#include <math.h>

/* A level far below the user's would switch the measurement to certainty, one far above would switch it off. */
static double bounded(double ratio)
{
	return fmin(fmax(ratio, 1e-3), 1e6);
}

fw_adapt_factors fw_adapt_by_levels(const fw_adapt_options *o, const fw_levels *levels)
{
	fw_adapt_factors k = {1, 1, 1};
	if (!levels->known)
		return k;
	const double h = bounded(levels->hpl_m / o->hul_m), v = bounded(levels->vpl_m / o->vul_m);
	k.r_h = h <= 1 ? h / o->tau1 : h * o->tau2;
	k.r_v = v <= 1 ? v / o->tau1 : v * o->tau2;
	k.q = h <= 1 ? o->tau4 / h : 1 / (o->tau3 * h);
	return k;
}

void fw_vb_start(fw_vb_scale *s)
{
	s->a = 5;
	s->b = 5;
}

double fw_student_factor(double dof, double nis, int m)
{
	return fmax(1, (dof + nis) / (dof + m));
}
