#include "fusion/measure_navigation.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"

enum { ATT = 0, VEL = 3, POS = 6 };

/* Pitch beyond which heading says nothing [rad]. */
#define STEEP fw_rad_from_deg(80)

static void begin(fw_measurement *z, int m)
{
	memset(z, 0, sizeof *z);
	z->m = m;
}

static void set_noise(fw_measurement *z, const double R[static 3][3])
{
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			z->R[i][j] = R[i][j];
}

static void set_identity(fw_measurement *z, int at)
{
	for (int i = 0; i < 3 && at >= 0; i++)
		z->H[i][at + i] = 1;
}

/* H = -[v x], over the columns from `at`: d(C x) = phi x (C x) = -(C x) x phi */
static void set_turned(fw_measurement *z, int at, const double v[3])
{
	double S[3][3];
	fw_skew(v, S);
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			z->H[i][at + j] = -S[i][j];
}

static double error_of(const fw_filter *f, fw_block block, int i)
{
	const int at = f->model.layout.at[block];
	return at >= 0 ? f->x[at + i] : 0;
}

void fw_measure_position(const fw_filter *f, const double llh[static 3], const double R[static 3][3],
                         const double lever_b[static 3], fw_measurement *z)
{
	const double still[3] = {0};
	double C[3][3], lever_n[3];
	fw_earth e;

	begin(z, 3);
	fw_quat_to_matrix(f->pva.q_n_b, C);
	fw_mat3_vec(C, lever_b, lever_n);
	fw_earth_at(f->pva.llh, still, &e);
	z->innovation[0] = (llh[0] - f->pva.llh[0]) * e.M_m;
	z->innovation[1] = fw_wrap_pi(llh[1] - f->pva.llh[1]) * e.N_m * e.cos_lat;
	z->innovation[2] = f->pva.llh[2] - llh[2];
	for (int i = 0; i < 3; i++)
		z->innovation[i] -= lever_n[i] + error_of(f, FW_BLOCK_POSITION_ERROR, i);
	set_identity(z, POS);
	set_turned(z, ATT, lever_n);
	set_identity(z, f->model.layout.at[FW_BLOCK_POSITION_ERROR]);
	set_noise(z, R);
}

/* The antenna moves with v + C (omega_nb x lever). */
void fw_measure_velocity(const fw_filter *f, const double velocity_mps[static 3], const double R[static 3][3],
                         const double lever_b[static 3], fw_measurement *z)
{
	const int bias = f->model.layout.at[FW_BLOCK_GYRO_BIAS];
	double C[3][3], L[3][3], CL[3][3], around_b[3], around_n[3];

	begin(z, 3);
	fw_quat_to_matrix(f->pva.q_n_b, C);
	fw_skew(lever_b, L);
	fw_mat3_vec(L, f->omega_nb_b, around_b); /* lever x omega */
	fw_mat3_vec(C, around_b, around_n);
	for (int i = 0; i < 3; i++) {
		around_n[i] = -around_n[i];
		z->innovation[i] = velocity_mps[i] - f->pva.velocity_mps[i] - around_n[i] -
		                   error_of(f, FW_BLOCK_VELOCITY_ERROR, i);
	}
	set_identity(z, VEL);
	set_turned(z, ATT, around_n);
	set_identity(z, f->model.layout.at[FW_BLOCK_VELOCITY_ERROR]);
	if (bias >= 0) { /* d(omega) = -d(bias): d(omega x lever) = lever x d(bias) */
		fw_mat3_mul(C, L, CL);
		for (int i = 0; i < 3; i++)
			for (int j = 0; j < 3; j++)
				z->H[i][bias + j] = CL[i][j];
	}
	set_noise(z, R);
}

/* heading = atan2(C_21, C_11); of the error C' = phi x C:
 * d(heading) = phi_down - tan(pitch) (phi_north cos(heading) + phi_east sin(heading)) with its sign from C_31 = -sin(pitch). */
fw_status fw_measure_heading(const fw_filter *f, double heading_rad, double sd_rad, fw_measurement *z)
{
	double C[3][3];
	fw_quat_to_matrix(f->pva.q_n_b, C);
	const double h2 = C[0][0] * C[0][0] + C[1][0] * C[1][0];
	if (!(fabs(C[2][0]) < sin(STEEP)))
		return FW_ESINGULAR;
	begin(z, 1);
	z->innovation[0] = fw_wrap_pi(heading_rad - atan2(C[1][0], C[0][0]));
	z->H[0][ATT] = -C[0][0] * C[2][0] / h2;
	z->H[0][ATT + 1] = -C[1][0] * C[2][0] / h2;
	z->H[0][ATT + 2] = 1;
	z->R[0][0] = sd_rad * sd_rad;
	return FW_OK;
}

/* The field as the filter has it is B - phi x B: its direction in the horizontal plane is off by
 * -phi_down + (B_down / B_horizontal) (phi_north cos(declination) + phi_east sin(declination)). */
fw_status fw_measure_compass(const fw_filter *f, double heading_rad, double sd_rad,
                             const double field_ned_nt[static 3], fw_measurement *z)
{
	const double *B = field_ned_nt, h2 = B[0] * B[0] + B[1] * B[1];
	const fw_status status = fw_measure_heading(f, heading_rad, sd_rad, z);
	if (status < 0)
		return status;
	z->H[0][ATT] = -B[2] * B[0] / h2;
	z->H[0][ATT + 1] = -B[2] * B[1] / h2;
	return FW_OK;
}

void fw_measure_height(const fw_filter *f, double height_m, double sd_m, fw_measurement *z)
{
	const int at = f->model.layout.at[FW_BLOCK_HEIGHT_ERROR];
	begin(z, 1);
	z->innovation[0] = height_m - f->pva.llh[2] - error_of(f, FW_BLOCK_HEIGHT_ERROR, 0);
	z->H[0][POS + 2] = -1;
	if (at >= 0)
		z->H[0][at] = 1;
	z->R[0][0] = sd_m * sd_m;
}

void fw_measure_zero_velocity(const fw_filter *f, double sd_mps, fw_measurement *z)
{
	begin(z, 3);
	for (int i = 0; i < 3; i++) {
		z->innovation[i] = -f->pva.velocity_mps[i];
		z->R[i][i] = sd_mps * sd_mps;
	}
	set_identity(z, VEL);
}

/* What the gyros read, standing, is the Earth's rotation and their bias: omega_ib_b = C^T omega_ie + bias. */
void fw_measure_zero_rate(const fw_filter *f, const double omega_ib_b[static 3], double sd_radps,
                          fw_measurement *z)
{
	const double still[3] = {0};
	const int bias = f->model.layout.at[FW_BLOCK_GYRO_BIAS];
	double C[3][3], earth_b[3], S[3][3];
	fw_earth e;

	begin(z, 3);
	fw_quat_to_matrix(f->pva.q_n_b, C);
	fw_earth_at(f->pva.llh, still, &e);
	fw_mat3_t_vec(C, e.omega_ie_n, earth_b);
	fw_skew(e.omega_ie_n, S);
	for (int i = 0; i < 3; i++) {
		z->innovation[i] = omega_ib_b[i] - earth_b[i] - error_of(f, FW_BLOCK_GYRO_BIAS, i);
		z->R[i][i] = sd_radps * sd_radps;
		for (int j = 0; j < 3; j++) /* d(C^T w) = -C^T (phi x w) = C^T [w x] phi */
			for (int k = 0; k < 3; k++)
				z->H[i][ATT + j] += C[k][i] * S[k][j];
	}
	set_identity(z, bias);
}

/* v_b = C^T v + omega x lever; of the error: C^T (d(v) + [v x] phi). */
void fw_measure_wheels(const fw_filter *f, double sd_mps, const double lever_b[static 3], fw_measurement *z)
{
	const double *w = f->omega_nb_b, *l = lever_b, *v = f->pva.velocity_mps;
	const double around[3] = {0, w[2] * l[0] - w[0] * l[2], w[0] * l[1] - w[1] * l[0]};
	const int bias = f->model.layout.at[FW_BLOCK_GYRO_BIAS];
	double C[3][3], S[3][3], L[3][3], v_b[3];

	begin(z, 2);
	fw_quat_to_matrix(f->pva.q_n_b, C);
	fw_mat3_t_vec(C, v, v_b);
	fw_skew(v, S);
	fw_skew(l, L);
	for (int r = 0; r < 2; r++) {
		const int axis = r + 1;
		z->innovation[r] = -v_b[axis] - around[axis];
		z->R[r][r] = sd_mps * sd_mps;
		for (int j = 0; j < 3; j++) {
			z->H[r][VEL + j] = C[j][axis];
			if (bias >= 0)
				z->H[r][bias + j] = L[axis][j];
			for (int k = 0; k < 3; k++)
				z->H[r][ATT + j] += C[k][axis] * S[k][j];
		}
	}
}
