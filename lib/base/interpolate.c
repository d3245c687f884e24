#include "base/interpolate.h"

#include <math.h>

#include "base/frame.h"

void fw_hermite(int n, double h, double u, const double *p0, const double *v0, const double *p1,
                const double *v1, double *p)
{
	double w = 1 - u;
	double a0 = w * w * (1 + 2 * u), a1 = u * u * (1 + 2 * w); /* a0 + a1 = 1 */
	double b0 = h * u * w * w, b1 = -h * u * u * w;

	for (int i = 0; i < n; i++)
		p[i] = a0 * p0[i] + a1 * p1[i] + b0 * v0[i] + b1 * v1[i];
}

fw_status fw_lagrange(int k, int n, const double *t, const double *y, double at, double *p)
{
	double weight[FW_LAGRANGE_MAX];

	if (k < 1 || k > FW_LAGRANGE_MAX)
		return FW_EINVAL;
	for (int i = 0; i < k; i++) {
		weight[i] = 1;
		for (int j = 0; j < k; j++) {
			if (j == i)
				continue;
			if (!(fabs(t[i] - t[j]) > 0))
				return FW_EINVAL;
			weight[i] *= (at - t[j]) / (t[i] - t[j]);
		}
	}
	for (int j = 0; j < n; j++) {
		p[j] = 0;
		for (int i = 0; i < k; i++)
			p[j] += weight[i] * y[i * n + j];
	}
	return FW_OK;
}

void fw_quat_between(const double q0[static 4], const double q1[static 4], double v[static 3])
{
	const double back[4] = {q0[0], -q0[1], -q0[2], -q0[3]};
	double q[4];

	fw_quat_mul(back, q1, q);
	double sine = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
	double sign =
	    q[0] < 0 ? -1 : 1; /* q and -q are one rotation: take the one of less than half a turn */
	double scale = sine > 0 ? 2 * atan2(sine, sign * q[0]) / sine : 2;
	for (int i = 0; i < 3; i++)
		v[i] = sign * scale * q[i + 1];
}

void fw_slerp(const double q0[static 4], const double q1[static 4], double u, double q[static 4])
{
	double v[3], turn[4];

	fw_quat_between(q0, q1, v);
	for (int i = 0; i < 3; i++)
		v[i] *= u;
	fw_quat_from_rotvec(v, turn);
	fw_quat_mul(q0, turn, q);
}
