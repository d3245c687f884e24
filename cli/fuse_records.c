#include "fuse_records.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "furrow_att.h"
#include "furrow_att_columns.h"
#include "furrow_baro.h"
#include "furrow_baro_columns.h"
#include "furrow_imu.h"
#include "furrow_imu_columns.h"
#include "furrow_imu_setup.h"
#include "furrow_imu_setup_columns.h"
#include "furrow_mag.h"
#include "furrow_mag_columns.h"
#include "furrow_nav.h"
#include "furrow_nav_columns.h"
#include "furrow_pl.h"
#include "furrow_pl_columns.h"
#include "furrow_pos.h"
#include "furrow_pos_columns.h"
#include "furrow_pvt.h"
#include "furrow_pvt_columns.h"
#include "furrow_pvt_ecef.h"
#include "furrow_pvt_ecef_columns.h"
#include "ins/magnetic_field.h"

#define HAS(r, type, column) (((r)->present >> FW_COL_##type##_##column & 1) != 0)

/* Are all columns from a to b there? */
#define HAS_ALL(r, type, a, b) has_all((r)->present, FW_COL_##type##_##a, FW_COL_##type##_##b)

static bool has_all(int64_t present, int a, int b)
{
	const int64_t wanted = ((INT64_C(1) << b) - (INT64_C(1) << a)) | INT64_C(1) << b;
	return (present & wanted) == wanted;
}

/* What a fix is worth when its record does not say: a code receiver outdoors. Height held by the receiver is no measurement. */
static const double assumed_sd_m[3] = {3, 3, 5}, assumed_sd_mps[3] = {0.3, 0.3, 0.5};
enum { HELD_SD_M = 1000, HELD_SD_MPS = 100 };

/** A receiver's 95 % to one sigma: of the normal distribution in two dimensions and in one. */
#define H95 2.4477
#define V95 1.96

void fuse_records_begin(fuse_records *r, const fuse_records_setup *setup)
{
	*r = (fuse_records){.setup = *setup, .other_kind = FW_RECORD_COUNT};
}

void fuse_records_kinds(fw_kind_set *set)
{
	static const fw_kind kinds[] = {FW_imu, FW_imu_setup, FW_pvt,  FW_pvt_ecef, FW_pos,  FW_nav,
	                                FW_att, FW_mag,       FW_baro, FW_pl,       FW_event};
	for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
		fw_kind_add(set, kinds[i]);
}

/* ---- sensors ---- */

static void turn(const fuse_records *r, const double sensor[static 3], double body[static 3])
{
	fw_mat3_vec(r->setup.C_b_s, sensor, body);
}

static bool take_imu(fuse_records *r, const furrow_imu *imu, fw_time t, fuse_entry *e)
{
	const double gyro[3] = {imu->gyro_x_radps, imu->gyro_y_radps, imu->gyro_z_radps},
	             accel[3] = {imu->accel_x_mps2, imu->accel_y_mps2, imu->accel_z_mps2};
	e->is_imu = true;
	e->imu.time = fw_time_add_ns(t, r->setup.imu_offset_ns);
	turn(r, gyro, e->imu.gyro_radps);
	turn(r, accel, e->imu.accel_mps2);
	if (!HAS_ALL(imu, imu, gyro_x_radps, accel_z_mps2))
		e->imu.gyro_radps[0] = (double)NAN;
	r->imu++;
	return true;
}

/** Weaker than any place of the Earth [uT]: 22 is the least there is. */
#define NORMALISED_MOST 5

/* A field without a unit gets the strength that the Earth's has there: only its direction is known. */
static void give_unit(fuse_records *r, fw_time t, double b_ut[static 3])
{
	double earth[3];
	if (!(hypot(hypot(b_ut[0], b_ut[1]), b_ut[2]) < NORMALISED_MOST))
		return;
	if (r->unit_ut <= 0 && r->has_first_fix && fw_magnetic_field(r->llh, t, earth) >= 0)
		r->unit_ut = hypot(hypot(earth[0], earth[1]), earth[2]) * 1e-3;
	for (int i = 0; i < 3; i++)
		b_ut[i] *= r->unit_ut > 0 ? r->unit_ut : 50;
}

static bool take_mag(fuse_records *r, const furrow_mag *mag, fw_time t, fuse_entry *e)
{
	const double sensor[3] = {mag->mag_x_ut, mag->mag_y_ut, mag->mag_z_ut};
	double body[3];
	e->item = (fw_item){.time = t, .kind = FW_ITEM_FIELD};
	turn(r, sensor, body);
	give_unit(r, t, body);
	if (r->setup.compass != NULL)
		fw_mag_field(r->setup.compass, body, e->item.field.b_ut);
	else
		memcpy(e->item.field.b_ut, body, sizeof body);
	if (!HAS_ALL(mag, mag, mag_x_ut, mag_z_ut))
		e->item.field.b_ut[0] = (double)NAN;
	r->fields++;
	return true;
}

static bool take_baro(fuse_records *r, const furrow_baro *baro, fw_time t, fuse_entry *e)
{
	if (!HAS(baro, baro, baro_height_m))
		return false;
	e->item = (fw_item){.time = t, .kind = FW_ITEM_HEIGHT, .height.height_m = baro->baro_height_m};
	r->heights++;
	return true;
}

static bool take_setup(fuse_records *r, const furrow_imu_setup *setup)
{
	if (HAS_ALL(setup, imu_setup, lever_x_m, lever_z_m)) {
		r->lever_b[0] = (double)setup->lever_x_m;
		r->lever_b[1] = (double)setup->lever_y_m;
		r->lever_b[2] = (double)setup->lever_z_m;
		r->has_lever = true;
	}
	return false;
}

/* ---- integrity, events ---- */

static fw_integrity_state state_of(const char *name)
{
	for (fw_integrity_state state = FW_RELIABLE; name != NULL && state <= FW_NO_POSITION; state++)
		if (strcmp(name, fw_integrity_state_name(state)) == 0)
			return state;
	return FW_INTEGRITY_UNKNOWN;
}

static bool take_levels(fuse_records *r, const furrow_pl *pl, fw_time t, fuse_entry *e)
{
	e->item =
	    (fw_item){.time = fw_time_add_ns(t, -llround(r->clock_bias_s * 1e9)),
	              .kind = FW_ITEM_LEVELS,
	              .levels = {.hpl_m = HAS(pl, pl, hpl_m) ? pl->hpl_m : (double)NAN,
	                         .vpl_m = HAS(pl, pl, vpl_m) ? pl->vpl_m : (double)NAN,
	                         .state = HAS(pl, pl, state) ? state_of(pl->state) : FW_INTEGRITY_UNKNOWN}};
	r->levels++;
	return true;
}

static bool take_event(fuse_records *r, fw_time t, fuse_entry *e)
{
	e->item = (fw_item){.time = t, .kind = FW_ITEM_MARK, .mark.number = r->events++};
	return true;
}

/* ---- fixes ---- */

static void put_symmetric(double R[3][3], double nn, double ee, double dd, double ne, double nd, double ed)
{
	const double full[3][3] = {{nn, ne, nd}, {ne, ee, ed}, {nd, ed, dd}};
	memcpy(R, full, sizeof full);
}

static void put_deviations(double R[3][3], double n, double e, double d)
{
	put_symmetric(R, n * n, e * e, d * d, 0, 0, 0);
}

static void hold(double R[3][3], double sd)
{
	put_symmetric(R, R[0][0], R[1][1], sd * sd, R[0][1], 0, 0);
}

/* Fixes come from one type of record: the one asked for, or the first that comes. */
static bool is_chosen(fuse_records *r, fw_kind kind)
{
	if (!r->has_kind && r->setup.fixes == FUSE_FIXES_AUTO && kind != FW_nav) {
		r->kind = kind;
		r->has_kind = true;
	}
	switch (r->setup.fixes) {
	case FUSE_FIXES_AUTO: break;
	case FUSE_FIXES_PVT:
		if (!r->has_kind && (kind == FW_pvt || kind == FW_pvt_ecef)) {
			r->kind = kind;
			r->has_kind = true;
		}
		break;
	case FUSE_FIXES_POS: r->has_kind = true, r->kind = FW_pos; break;
	case FUSE_FIXES_NAV: r->has_kind = true, r->kind = FW_nav; break;
	}
	if (r->has_kind && kind == r->kind)
		return true;
	if (kind != FW_nav) {
		r->other_kind = r->other_fixes == 0 ? kind : r->other_kind;
		r->other_fixes++;
	}
	return false;
}

/* A fix without a sigma of its own gets an assumed one. */
static void assume(fuse_records *r, double R[3][3], const double sd[3])
{
	put_deviations(R, sd[0], sd[1], sd[2]);
	r->without_sigma++;
}

/* Ambiguities that are no whole numbers: solvers say centimetres, and are off by decimetres. */
static void distrust(const fuse_records *r, double R[3][3])
{
	const double least = r->setup.float_floor_m * r->setup.float_floor_m;
	for (int i = 0; i < 3; i++)
		if (R[i][i] > 0 && R[i][i] < least)
			R[i][i] = least;
}

static bool is_float(int mode)
{
	return mode == 5 || mode == 8;
}

static void pvt_position_sigma(fuse_records *r, const furrow_pvt *p, double R[3][3])
{
	if (HAS_ALL(p, pvt, cov_nn_m2, cov_dd_m2) && HAS_ALL(p, pvt, cov_ne_m2, cov_nd_m2) &&
	    HAS(p, pvt, cov_ed_m2))
		put_symmetric(R, (double)p->cov_nn_m2, (double)p->cov_ee_m2, (double)p->cov_dd_m2,
		              (double)p->cov_ne_m2, (double)p->cov_nd_m2, (double)p->cov_ed_m2);
	else if (HAS_ALL(p, pvt, sd_n_m, sd_d_m))
		put_deviations(R, p->sd_n_m, p->sd_e_m, p->sd_d_m);
	else if (HAS_ALL(p, pvt, h_accuracy_m, v_accuracy_m))
		put_deviations(R, p->h_accuracy_m / H95, p->h_accuracy_m / H95, p->v_accuracy_m / V95);
	else
		assume(r, R, assumed_sd_m);
}

static void pvt_velocity_sigma(const furrow_pvt *p, double R[3][3])
{
	if (HAS_ALL(p, pvt, cov_vnvn_m2ps2, cov_vdvd_m2ps2) &&
	    HAS_ALL(p, pvt, cov_vnve_m2ps2, cov_vnvd_m2ps2) && HAS(p, pvt, cov_vevd_m2ps2))
		put_symmetric(R, (double)p->cov_vnvn_m2ps2, (double)p->cov_veve_m2ps2,
		              (double)p->cov_vdvd_m2ps2, (double)p->cov_vnve_m2ps2, (double)p->cov_vnvd_m2ps2,
		              (double)p->cov_vevd_m2ps2);
	else if (HAS_ALL(p, pvt, cov_vnvn_m2ps2, cov_vdvd_m2ps2))
		put_symmetric(R, (double)p->cov_vnvn_m2ps2, (double)p->cov_veve_m2ps2,
		              (double)p->cov_vdvd_m2ps2, 0, 0, 0);
	else
		put_deviations(R, assumed_sd_mps[0], assumed_sd_mps[1], assumed_sd_mps[2]);
}

static bool take_pvt(fuse_records *r, const furrow_pvt *p, fw_item *z)
{
	r->clock_bias_s = HAS(p, pvt, clock_bias_s) && fabs(p->clock_bias_s) < 0.1 ? p->clock_bias_s : 0;
	if ((HAS(p, pvt, mode) && p->mode == 0) || (HAS(p, pvt, error) && p->error != 0)) {
		r->no_fix++;
		return false;
	}
	z->fix.has_position = true;
	z->fix.llh[0] = HAS_ALL(p, pvt, lat_deg, height_m) ? fw_rad_from_deg(p->lat_deg) : (double)NAN;
	z->fix.llh[1] = fw_rad_from_deg(p->lon_deg);
	z->fix.llh[2] = p->height_m;
	pvt_position_sigma(r, p, z->fix.R_position);
	if (HAS(p, pvt, mode) && is_float(p->mode))
		distrust(r, z->fix.R_position);
	if (HAS_ALL(p, pvt, vn_mps, vd_mps)) {
		z->fix.has_velocity = true;
		z->fix.velocity_mps[0] = (double)p->vn_mps;
		z->fix.velocity_mps[1] = (double)p->ve_mps;
		z->fix.velocity_mps[2] = (double)p->vd_mps;
		pvt_velocity_sigma(p, z->fix.R_velocity);
	}
	if (HAS(p, pvt, two_d) && p->two_d != 0) {
		hold(z->fix.R_position, HELD_SD_M);
		hold(z->fix.R_velocity, HELD_SD_MPS);
	}
	return true;
}

/* Covariance in NED from one in ECEF. */
static void to_ned(const double C_e_n[3][3], double R_e[3][3], double R_n[3][3])
{
	double C_n_e[3][3];
	fw_mat3_transpose(C_e_n, C_n_e);
	fw_mat_sandwich(3, 3, C_n_e[0], R_e[0], R_n[0]);
}

static bool take_pvt_ecef(fuse_records *r, const furrow_pvt_ecef *p, fw_item *z)
{
	const double ecef[3] = {p->x_m, p->y_m, p->z_m};
	double C_e_n[3][3], R_e[3][3];
	r->clock_bias_s = HAS(p, pvt_ecef, clock_bias_s) && fabs(p->clock_bias_s) < 0.1 ? p->clock_bias_s : 0;
	if ((HAS(p, pvt_ecef, mode) && p->mode == 0) || (HAS(p, pvt_ecef, error) && p->error != 0) ||
	    !HAS_ALL(p, pvt_ecef, x_m, z_m) || fw_ecef_to_llh(ecef, z->fix.llh) != FW_OK) {
		r->no_fix++;
		return false;
	}
	z->fix.has_position = true;
	fw_frame_ned(z->fix.llh[0], z->fix.llh[1], C_e_n);
	if (HAS_ALL(p, pvt_ecef, cov_xx_m2, cov_zz_m2) && HAS_ALL(p, pvt_ecef, cov_xy_m2, cov_xz_m2) &&
	    HAS(p, pvt_ecef, cov_yz_m2)) {
		put_symmetric(R_e, (double)p->cov_xx_m2, (double)p->cov_yy_m2, (double)p->cov_zz_m2,
		              (double)p->cov_xy_m2, (double)p->cov_xz_m2, (double)p->cov_yz_m2);
		to_ned(C_e_n, R_e, z->fix.R_position);
	} else {
		assume(r, z->fix.R_position, assumed_sd_m);
	}
	if (HAS(p, pvt_ecef, mode) && is_float(p->mode))
		distrust(r, z->fix.R_position);
	if (!HAS_ALL(p, pvt_ecef, vx_mps, vz_mps))
		return true;
	const double v_e[3] = {(double)p->vx_mps, (double)p->vy_mps, (double)p->vz_mps};
	z->fix.has_velocity = true;
	fw_mat3_t_vec(C_e_n, v_e, z->fix.velocity_mps);
	if (HAS_ALL(p, pvt_ecef, cov_vxvx_m2ps2, cov_vzvz_m2ps2) &&
	    HAS_ALL(p, pvt_ecef, cov_vxvy_m2ps2, cov_vxvz_m2ps2) && HAS(p, pvt_ecef, cov_vyvz_m2ps2)) {
		put_symmetric(R_e, (double)p->cov_vxvx_m2ps2, (double)p->cov_vyvy_m2ps2,
		              (double)p->cov_vzvz_m2ps2, (double)p->cov_vxvy_m2ps2, (double)p->cov_vxvz_m2ps2,
		              (double)p->cov_vyvz_m2ps2);
		to_ned(C_e_n, R_e, z->fix.R_velocity);
	} else {
		put_deviations(z->fix.R_velocity, assumed_sd_mps[0], assumed_sd_mps[1], assumed_sd_mps[2]);
	}
	return true;
}

/* What a solver other than the receiver says; NULL: nothing. Degrees and metres, m/s, sigmas of both. */
static bool take_plain(fuse_records *r, const double *place, const double *sd, const double *velocity,
                       const double *velocity_sd, fw_item *z)
{
	if (place == NULL) {
		r->no_fix++;
		return false;
	}
	z->fix.has_position = true;
	z->fix.llh[0] = fw_rad_from_deg(place[0]);
	z->fix.llh[1] = fw_rad_from_deg(place[1]);
	z->fix.llh[2] = place[2];
	if (sd != NULL)
		put_deviations(z->fix.R_position, sd[0], sd[1], sd[2]);
	else
		assume(r, z->fix.R_position, assumed_sd_m);
	if (velocity == NULL)
		return true;
	if (velocity_sd == NULL)
		velocity_sd = assumed_sd_mps;
	z->fix.has_velocity = true;
	memcpy(z->fix.velocity_mps, velocity, sizeof z->fix.velocity_mps);
	put_deviations(z->fix.R_velocity, velocity_sd[0], velocity_sd[1], velocity_sd[2]);
	return true;
}

/* The parts of a pos or nav record for take_plain(). */
#define PLACE(p, type)                                                                                       \
	(HAS_ALL(p, type, lat_deg, height_m) ? (const double[3]){p->lat_deg, p->lon_deg, p->height_m} : NULL)
#define PLACE_SD(p, type)                                                                                    \
	(HAS_ALL(p, type, sd_n_m, sd_d_m) ? (const double[3]){p->sd_n_m, p->sd_e_m, p->sd_d_m} : NULL)
#define VELOCITY(p, type)                                                                                    \
	(HAS_ALL(p, type, vn_mps, vd_mps) ? (const double[3]){p->vn_mps, p->ve_mps, p->vd_mps} : NULL)
#define VELOCITY_SD(p, type)                                                                                 \
	(HAS_ALL(p, type, sd_vn_mps, sd_vd_mps)                                                              \
	     ? (const double[3]){p->sd_vn_mps, p->sd_ve_mps, p->sd_vd_mps}                                   \
	     : NULL)

static bool take_pos(fuse_records *r, const furrow_pos *p, fw_item *z)
{
	if (!take_plain(r, PLACE(p, pos), PLACE_SD(p, pos), VELOCITY(p, pos), VELOCITY_SD(p, pos), z))
		return false;
	if (HAS(p, pos, quality) && strcmp(p->quality, "float") == 0)
		distrust(r, z->fix.R_position);
	return true;
}

static bool take_nav(fuse_records *r, const furrow_nav *p, fw_item *z)
{
	return take_plain(r, PLACE(p, nav), PLACE_SD(p, nav), VELOCITY(p, nav), VELOCITY_SD(p, nav), z);
}

/* Left out on purpose, to see how well the INS does without. */
static bool is_withheld(fuse_records *r, fw_time t)
{
	const fuse_records_setup *s = &r->setup;
	if (s->withhold_every_ns <= 0 || !r->has_first_fix)
		return false;
	const int64_t since = t.ns - r->first_fix.ns - s->withhold_first_ns;
	const bool out = since >= 0 && since % s->withhold_every_ns < s->withhold_length_ns;
	r->withheld += out;
	return out;
}

static bool take_fix(fuse_records *r, fw_kind kind, const void *record, fw_time t, fuse_entry *e)
{
	bool there;
	if (!is_chosen(r, kind))
		return false;
	e->item = (fw_item){.kind = FW_ITEM_FIX};
	switch (kind) {
	case FW_pvt: there = take_pvt(r, record, &e->item); break;
	case FW_pvt_ecef: there = take_pvt_ecef(r, record, &e->item); break;
	case FW_pos: there = take_pos(r, record, &e->item); break;
	default: there = take_nav(r, record, &e->item); break;
	}
	if (!there)
		return false;
	if (kind == FW_pvt || kind == FW_pvt_ecef) /* stamped by the receiver's clock */
		t = fw_time_add_ns(t, -llround(r->clock_bias_s * 1e9));
	e->item.time = t;
	e->item.fix.has_velocity &= r->setup.use_velocity;
	memcpy(r->llh, e->item.fix.llh, sizeof r->llh);
	if (!r->has_first_fix) {
		r->has_first_fix = true;
		r->first_fix = t;
	}
	if (is_withheld(r, t))
		return false;
	r->fixes++;
	return true;
}

static bool take_heading(fuse_records *r, const furrow_att *a, fw_time t, fuse_entry *e)
{
	if ((HAS(a, att, mode) && a->mode == 0) || (HAS(a, att, error_aux1) && a->error_aux1 != 0) ||
	    (HAS(a, att, not_requested) && a->not_requested != 0) || !HAS(a, att, heading_deg))
		return false;
	t = fw_time_add_ns(t, -llround(r->clock_bias_s * 1e9));
	if (is_withheld(r, t))
		return false;
	double sd_deg = 1; /* of a baseline of a metre or so */
	if (HAS(a, att, sd_heading_deg))
		sd_deg = a->sd_heading_deg;
	else if (HAS(a, att, cov_hh_deg2))
		sd_deg = sqrt((double)a->cov_hh_deg2);
	e->item = (fw_item){.time = t, .kind = FW_ITEM_HEADING};
	e->item.heading.heading_rad = fw_rad_from_deg((double)a->heading_deg) - r->setup.antenna_heading_rad;
	if (fabs((double)a->heading_deg) <= 360) /* else it shall be refused */
		e->item.heading.heading_rad = fw_wrap_2pi(e->item.heading.heading_rad);
	e->item.heading.sd_rad = fw_rad_from_deg(sd_deg);
	if (e->item.heading.sd_rad > 0 && e->item.heading.sd_rad < r->setup.heading_floor_rad)
		e->item.heading.sd_rad = r->setup.heading_floor_rad;
	r->headings++;
	return true;
}

bool fuse_records_take(fuse_records *r, fw_kind kind, const void *record, fw_time t, fuse_entry *e)
{
	e->is_imu = false;
	switch (kind) {
	case FW_imu: return take_imu(r, record, t, e);
	case FW_imu_setup: return take_setup(r, record);
	case FW_pvt:
	case FW_pvt_ecef:
	case FW_pos:
	case FW_nav: return take_fix(r, kind, record, t, e);
	case FW_att: return take_heading(r, record, t, e);
	case FW_mag: return take_mag(r, record, t, e);
	case FW_baro: return take_baro(r, record, t, e);
	case FW_pl: return take_levels(r, record, t, e);
	case FW_event: return take_event(r, t, e);
	default: return false;
	}
}
