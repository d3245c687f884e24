#include "fuse_output.h"

#include <math.h>

#include "base/frame.h"
#include "furrow_nav.h"
#include "furrow_nav_columns.h"

void fuse_spread_of(const double P[FW_STATES_MAX][FW_STATES_MAX], double spread[static FUSE_SPREAD])
{
	enum { V = 3, P_ = 6 };
	const double all[FUSE_SPREAD] = {P[0][0],         P[1][1],   P[2][2],           P[0][1],
	                                 P[0][2],         P[1][2],   P[V][V],           P[V + 1][V + 1],
	                                 P[V + 2][V + 2], P[P_][P_], P[P_ + 1][P_ + 1], P[P_ + 2][P_ + 2],
	                                 P[P_][P_ + 1]};
	for (int i = 0; i < FUSE_SPREAD; i++)
		spread[i] = all[i];
}

void fuse_moment_of(const fw_loose *l, fuse_moment *m)
{
	m->pva = l->filter.pva;
	fuse_spread_of(l->filter.P, m->spread);
	m->hpl_m = l->levels.known ? (float)l->levels.hpl_m : (float)NAN;
	m->vpl_m = l->levels.known ? (float)l->levels.vpl_m : (float)NAN;
	m->status = fw_time_diff_s(m->pva.time, l->last_fix) > FUSE_COAST_S ? FUSE_COASTING
	            : l->options.use_still && l->stillness.still            ? FUSE_STILL
	                                                                    : FUSE_FUSED;
}

/* The radius that holds 95 % of a normal distribution in two dimensions with these variances and covariance.
 * Source: P. P. Leenhouts, "On the computation of bi-normal radial error", Navigation 32 (1985): exact to 0.1 %. */
static double radius95(double nn, double ee, double ne)
{
	const double mean = (nn + ee) / 2, spread = hypot((nn - ee) / 2, ne);
	const double a = sqrt(mean + spread), b = sqrt(fmax(mean - spread, 0)), c = a > 0 ? b / a : 0;
	return a * (1.960790 + c * (0.004071 + c * (0.114276 + c * 0.371625)));
}

/* Rounding may leave a variance of nothing below 0; what is no number stays none. */
static double deviation(double variance)
{
	return variance < 0 ? 0 : sqrt(variance);
}

/* Sigmas of roll, pitch and heading from the covariance of phi: d(roll, pitch, heading) = J phi. */
static void angle_deviations(const double q_n_b[static 4], const double s[static 6], double sd[static 3])
{
	double C[3][3];
	fw_quat_to_matrix(q_n_b, C);
	const double cos2 = fmax(C[0][0] * C[0][0] + C[1][0] * C[1][0], 1e-12), cos1 = sqrt(cos2);
	const double J[3][3] = {{C[0][0] / cos2, C[1][0] / cos2, 0},
	                        {-C[1][0] / cos1, C[0][0] / cos1, 0},
	                        {-C[0][0] * C[2][0] / cos2, -C[1][0] * C[2][0] / cos2, 1}};
	for (int r = 0; r < 3; r++) {
		const double *j = J[r];
		const double variance = j[0] * j[0] * s[0] + j[1] * j[1] * s[1] + j[2] * j[2] * s[2] +
		                        2 * (j[0] * j[1] * s[3] + j[0] * j[2] * s[4] + j[1] * j[2] * s[5]);
		sd[r] = deviation(variance);
		if (sd[r] > FW_PI)
			sd[r] = FW_PI;
	}
}

bool fuse_output_put(const fuse_output *o, const fuse_moment *m)
{
	static char names[][12] = {"fused", "coasting", "still", "smoothed"};
	const double *s = m->spread, *v = m->pva.velocity_mps, *p = m->spread + FUSE_SPREAD_POSITION;
	double rpy[3], sd[3];
	int week;
	fw_quat_to_euler(m->pva.q_n_b, rpy);
	angle_deviations(m->pva.q_n_b, s + FUSE_SPREAD_ATTITUDE, sd);
	for (int i = 0; i < 3; i++)
		sd[i] = hypot(sd[i], o->misalignment_rad);
	furrow_nav r = {
	    .present = (INT64_C(1) << FW_COL_nav_COUNT) - 1,
	    .lat_deg = fw_deg_from_rad(m->pva.llh[0]),
	    .lon_deg = fw_deg_from_rad(m->pva.llh[1]),
	    .height_m = m->pva.llh[2],
	    .vn_mps = v[0],
	    .ve_mps = v[1],
	    .vd_mps = v[2],
	    .roll_deg = fw_deg_from_rad(rpy[0]),
	    .pitch_deg = fw_deg_from_rad(rpy[1]),
	    .heading_deg = fw_deg_from_rad(rpy[2]),
	    .sd_n_m = deviation(p[0]),
	    .sd_e_m = deviation(p[1]),
	    .sd_d_m = deviation(p[2]),
	    .sd_vn_mps = deviation(s[FUSE_SPREAD_VELOCITY]),
	    .sd_ve_mps = deviation(s[FUSE_SPREAD_VELOCITY + 1]),
	    .sd_vd_mps = deviation(s[FUSE_SPREAD_VELOCITY + 2]),
	    .sd_roll_deg = fw_deg_from_rad(sd[0]),
	    .sd_pitch_deg = fw_deg_from_rad(sd[1]),
	    .sd_heading_deg = fw_deg_from_rad(sd[2]),
	    .hpl_m = (double)m->hpl_m,
	    .vpl_m = (double)m->vpl_m,
	    .hfom_m = radius95(p[0], p[1], p[3]),
	    .vfom_m = 1.96 * deviation(p[2]),
	    .status = names[m->status],
	};
	const double *q = m->pva.q_n_b, sum = r.lat_deg + r.lon_deg + r.height_m + v[0] + v[1] + v[2] + q[0] +
	                                      q[1] + q[2] + q[3] + r.hfom_m + r.sd_n_m + r.sd_e_m + r.sd_d_m +
	                                      r.sd_vn_mps + r.sd_ve_mps + r.sd_vd_mps + sd[0] + sd[1] + sd[2];
	if (!isfinite(sum))
		return false;
	fw_time_to_gps_s(m->pva.time, &week, &r.tow_s);
	r.gps_week = week;
	if (!isfinite(m->hpl_m))
		r.present &= ~(INT64_C(1) << FW_COL_nav_hpl_m);
	if (!isfinite(m->vpl_m))
		r.present &= ~(INT64_C(1) << FW_COL_nav_vpl_m);
	o->to.put(o->to.context, FW_nav, &r);
	return true;
}

bool fuse_rate_keeps(fuse_rate *r, fw_time t)
{
	if (r->every_ns <= 0)
		return r->every_ns == 0;
	if (t.ns < r->next_ns && t.ns >= r->next_ns - r->every_ns)
		return false;
	/* In whole weeks, so that the multiples are those of the time of week. */
	const int64_t week = t.ns / FW_NS_PER_WEEK * FW_NS_PER_WEEK;
	r->next_ns = week + ((t.ns - week) / r->every_ns + 1) * r->every_ns;
	return true;
}
