#include "sim/process.h"

#include <math.h>

void fw_gm1_init(fw_gm1 *p, double sd, fw_random *random)
{
	p->value = sd * fw_random_normal(random);
}

void fw_gm1_step(fw_gm1 *p, double sd, double tau_s, double dt_s, fw_random *random)
{
	double keep = tau_s > 0 ? exp(-dt_s / tau_s) : 0;
	p->value = keep * p->value + sd * sqrt(1 - keep * keep) * fw_random_normal(random);
}

void fw_gm2_init(fw_gm2 *p, double sd, double tau_s, fw_random *random)
{
	p->value = sd * fw_random_normal(random);
	p->rate = sd / tau_s * fw_random_normal(random);
}

void fw_gm2_step(fw_gm2 *p, double sd, double tau_s, double dt_s, fw_random *random)
{
	double x = dt_s / tau_s, decay = exp(-x);
	double a = decay * (1 + x), b = decay * x,
	       c = decay * (1 - x); /* Phi with the rate in units of 1 / tau */
	double value = p->value, scaled = p->rate * tau_s;

	/* Q of the scaled process for sd 1, and its Cholesky factor; both vanish with the step. */
	double q11 = fmax(1 - a * a - b * b, 0), q12 = a * b - b * c, q22 = fmax(1 - b * b - c * c, 0);
	double l11 = sqrt(q11), l21 = l11 > 0 ? q12 / l11 : 0, l22 = sqrt(fmax(q22 - l21 * l21, 0));
	double n1 = fw_random_normal(random), n2 = fw_random_normal(random);
	p->value = a * value + b * scaled + sd * l11 * n1;
	p->rate = (-b * value + c * scaled + sd * (l21 * n1 + l22 * n2)) / tau_s;
}
