/* Between samples: curves through the points of a trajectory, and the way from one attitude to the next.
 *
 * Vectors have n elements, points of a curve follow each other: y[i * n + j] is element j of point i. Inputs may not be
 * outputs. NaN goes in, NaN comes out. Quaternions as in base/frame.h. */
#ifndef FURROW_BASE_INTERPOLATE_H
#define FURROW_BASE_INTERPOLATE_H

#include "base/status.h"

/* The cubic with given ends and given derivatives there (Hermite).
 *   h       in   length of the interval [s]
 *   u       in   where: 0 is its begin, 1 its end
 *   p0, p1  in   points at the ends (n)
 *   v0, v1  in   their derivatives (n) [per s]
 *   p       out  the point at u (n)
 * Error below h^4 / 384 times the largest fourth derivative: circling with 20 m radius at 1 rad/s and sampled at 10 Hz,
 * 5e-6 m. */
void fw_hermite(int n, double h, double u, const double *p0, const double *v0, const double *p1,
                const double *v1, double *p);

enum { FW_LAGRANGE_MAX = 8 };

/* The polynomial of degree k - 1 through k points (Lagrange).
 *   k   in   1..FW_LAGRANGE_MAX
 *   t   in   abscissae (k), all different
 *   y   in   points (k x n)
 *   at  in   where
 *   p   out  the point there (n)
 * Returns FW_OK; FW_EINVAL: k, or two equal abscissae (NaN among them); p untouched. */
fw_status fw_lagrange(int k, int n, const double *t, const double *y, double at, double *p) FW_MUST_CHECK;

/* The shorter rotation from q0 to q1, as a rotation vector in the frame that both turn to (the body, for q_n_b) [rad]:
 * q1 = q0 exp(v). Its length is 0..pi; divided by the time between, it is the angular rate. */
void fw_quat_between(const double q0[static 4], const double q1[static 4], double v[static 3]);

/* The attitude at u of the way from q0 (u = 0) to q1 (u = 1), turning at a constant rate by the shorter way. u outside
 * 0..1 goes on at that rate.
 * Source: K. Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985 (slerp). */
void fw_slerp(const double q0[static 4], const double q1[static 4], double u, double q[static 4]);

#endif
