#include "ins/strapdown.h"

#include <math.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "ins/gravity.h"

static void cross(const double a[static 3], const double b[static 3], double c[static 3])
{
	c[0] = a[1] * b[2] - a[2] * b[1];
	c[1] = a[2] * b[0] - a[0] * b[2];
	c[2] = a[0] * b[1] - a[1] * b[0];
}

void fw_earth_at(const double llh[static 3], const double velocity_mps[static 3], fw_earth *earth)
{
	const double s = sin(llh[0]), c = cos(llh[0]);
	const double w2 = 1 - FW_WGS84_E2 * s * s, w = sqrt(w2);
	const double vn = velocity_mps[0], ve = velocity_mps[1];

	earth->sin_lat = s;
	earth->cos_lat = c;
	earth->N_m = FW_WGS84_A / w + llh[2];
	earth->M_m = FW_WGS84_A * (1 - FW_WGS84_E2) / (w * w2) + llh[2];
	earth->omega_ie_n[0] = FW_EARTH_RATE_RADPS * c;
	earth->omega_ie_n[1] = 0;
	earth->omega_ie_n[2] = -FW_EARTH_RATE_RADPS * s;
	earth->omega_en_n[0] = ve / earth->N_m;
	earth->omega_en_n[1] = -vn / earth->M_m;
	earth->omega_en_n[2] = -ve / earth->N_m * s / c;
	earth->gravity_mps2 = fw_gravity_at(s * s, llh[2], &earth->gravity_per_m);
}

/* Gravity less the Coriolis and transport accelerations of a velocity: g - (2 omega_ie + omega_en) x v. */
static void gravity_and_coriolis(const fw_earth *e, const double v[static 3], double a[static 3])
{
	const double w[3] = {2 * e->omega_ie_n[0] + e->omega_en_n[0], e->omega_en_n[1],
	                     2 * e->omega_ie_n[2] + e->omega_en_n[2]};
	double turn[3];

	cross(w, v, turn);
	a[0] = -turn[0];
	a[1] = -turn[1];
	a[2] = e->gravity_mps2 - turn[2];
}

/* The velocity increment in body axes at the begin of the interval: rotation and sculling terms added. */
static void force_increment(const fw_increment *now, const fw_increment *before, double dv[static 3])
{
	double rotation[3], scull1[3], scull2[3];

	cross(now->angle_rad, now->velocity_mps, rotation);
	cross(before->angle_rad, now->velocity_mps, scull1);
	cross(before->velocity_mps, now->angle_rad, scull2);
	for (int i = 0; i < 3; i++)
		dv[i] = now->velocity_mps[i] + rotation[i] / 2 + (scull1[i] + scull2[i]) / 12;
}

/* q turned by the body's rotation and, the other way, by that of the local frame, a small vector zeta. */
static void turn(double q[static 4], const fw_increment *now, const fw_increment *before,
                 const double zeta[static 3])
{
	double coning[3], rotation[3], q_body[4], turned[4];
	const double q_frame[4] = {1, -zeta[0] / 2, -zeta[1] / 2, -zeta[2] / 2};

	cross(before->angle_rad, now->angle_rad, coning);
	for (int i = 0; i < 3; i++)
		rotation[i] = now->angle_rad[i] + coning[i] / 12;
	fw_quat_from_rotvec(rotation, q_body);
	fw_quat_mul(q, q_body, turned);
	fw_quat_mul(q_frame, turned, q);
	(void)!fw_quat_normalise(q);
}

void fw_strapdown(fw_pva *pva, const fw_increment *now, const fw_increment *before, fw_strapdown_step *step)
{
	const double dt = now->dt_s;
	fw_earth *earth = &step->earth;
	double dv_b[3], dv_n[3], half[3], frame[3], a[3], v[3], zeta[3];

	fw_earth_at(pva->llh, pva->velocity_mps, earth);
	fw_quat_to_matrix(pva->q_n_b, step->C_n_b);

	/* What is felt, turned to NED as it stands in the middle of the interval. */
	force_increment(now, before, dv_b);
	fw_mat3_vec(step->C_n_b, dv_b, dv_n);
	for (int i = 0; i < 3; i++)
		zeta[i] = (earth->omega_ie_n[i] + earth->omega_en_n[i]) * dt;
	cross(zeta, dv_n, frame);
	for (int i = 0; i < 3; i++)
		dv_n[i] -= frame[i] / 2;

	/* What is not felt, with the velocity in the middle. */
	gravity_and_coriolis(earth, pva->velocity_mps, a);
	for (int i = 0; i < 3; i++)
		half[i] = pva->velocity_mps[i] + (dv_n[i] + a[i] * dt) / 2;
	gravity_and_coriolis(earth, half, a);

	for (int i = 0; i < 3; i++) {
		v[i] = pva->velocity_mps[i] + dv_n[i] + a[i] * dt;
		step->force_n[i] = dv_n[i] / dt;
		step->velocity_mps[i] = (pva->velocity_mps[i] + v[i]) / 2;
		pva->velocity_mps[i] = v[i];
	}
	const double north = step->velocity_mps[0] * dt / earth->M_m;
	const double cos_mid = earth->cos_lat - earth->sin_lat * north / 2;
	pva->llh[0] += north;
	pva->llh[1] += step->velocity_mps[1] * dt / (earth->N_m * cos_mid);
	if (fabs(pva->llh[1]) > FW_PI)
		pva->llh[1] = fw_wrap_pi(pva->llh[1]);
	pva->llh[2] -= step->velocity_mps[2] * dt;
	turn(pva->q_n_b, now, before, zeta);
	pva->time.ns += llround(dt * 1e9);
}
