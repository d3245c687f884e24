#include "sim_records.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "formats/rinex_accuracy.h"
#include "furrow_att_columns.h"
#include "furrow_dop_columns.h"
#include "furrow_eph_bds.h"
#include "furrow_eph_bds_columns.h"
#include "furrow_eph_gal.h"
#include "furrow_eph_gal_columns.h"
#include "furrow_eph_glo.h"
#include "furrow_eph_glo_columns.h"
#include "furrow_eph_gps.h"
#include "furrow_eph_gps_columns.h"
#include "furrow_obs_columns.h"
#include "furrow_pvt_columns.h"

#define ALL(type)   ((INT64_C(1) << FW_COL_##type##_COUNT) - 1)
#define BIT(column) (INT64_C(1) << (FW_COL_##column))

/* All columns from `first` to `last`. */
#define RANGE(first, last) ((BIT(last) << 1) - BIT(first))

void record_stamp(void *record, fw_time t)
{
	fw_record_head *head = record;
	int week;
	fw_time_to_gps_s(t, &week, &head->tow_s);
	head->gps_week = week;
	head->present |= 3;
}

/* ---- ephemerides ---- */

static char decoded[] = "decoded";

/* The orbit's and clock's members have the same names in the three types. */
#define PUT_KEPLER(r, e)                                                                                     \
	do {                                                                                                 \
		(r)->source = decoded;                                                                       \
		(r)->sqrt_a_sqrtm = (e)->kepler.sqrt_a;                                                      \
		(r)->m0_rad = (e)->kepler.m0;                                                                \
		(r)->ecc = (e)->kepler.ecc;                                                                  \
		(r)->i0_rad = (e)->kepler.i0;                                                                \
		(r)->omega_rad = (e)->kepler.omega;                                                          \
		(r)->omega0_rad = (e)->kepler.omega0;                                                        \
		(r)->omegadot_radps = (e)->kepler.omega_dot;                                                 \
		(r)->idot_radps = (e)->kepler.idot;                                                          \
		(r)->deltan_radps = (e)->kepler.delta_n;                                                     \
		(r)->cuc_rad = (float)(e)->kepler.cuc;                                                       \
		(r)->cus_rad = (float)(e)->kepler.cus;                                                       \
		(r)->crc_m = (float)(e)->kepler.crc;                                                         \
		(r)->crs_m = (float)(e)->kepler.crs;                                                         \
		(r)->cic_rad = (float)(e)->kepler.cic;                                                       \
		(r)->cis_rad = (float)(e)->kepler.cis;                                                       \
		(r)->af2_sps2 = (float)(e)->af2_sps2;                                                        \
		(r)->af1_sps = (float)(e)->af1_sps;                                                          \
	} while (0)

static int seconds(int64_t tow_ns)
{
	return (int)(tow_ns / FW_NS_PER_S);
}

static void put_gps(const fw_ephemeris *e, furrow_eph_gps *r)
{
	int week;
	int64_t tow_ns;
	PUT_KEPLER(r, e);
	fw_time_to_gps(e->toc, &week, &tow_ns);
	r->toc_s = seconds(tow_ns);
	r->toc_week = week % 1024;
	fw_time_to_gps(e->toe, &week, &tow_ns);
	r->toe_s = seconds(tow_ns);
	r->toe_week = r->week = week % 1024;
	r->af0_s = e->af0_s;
	r->code_on_l2 = 1;
	r->ura = (int16_t)fw_ura_index(e->accuracy_m);
	r->health = e->healthy ? 0 : 1;
	r->iodc = e->issue;
	r->iode2 = r->iode3 = (int16_t)(e->issue % 256);
	r->tgd_s = (float)e->tgd_s[0];
	r->present = ALL(eph_gps);
}

static void put_gal(const fw_ephemeris *e, furrow_eph_gal *r)
{
	int week;
	int64_t tow_ns;
	PUT_KEPLER(r, e);
	fw_time_to_gps(e->toc, &week, &tow_ns);
	r->toc_s = seconds(tow_ns);
	r->toc_week = week;
	fw_time_to_gps(e->toe, &week, &tow_ns);
	r->toe_s = seconds(tow_ns);
	r->toe_week = week;
	r->af0_s = e->af0_s;
	r->message = e->message == FW_NAV_FNAV ? 16 : 2;
	r->iodnav = e->issue;
	r->health = 0x111 | (e->healthy ? 0 : 0x444);
	r->sisa_e1e5a = r->sisa_e1e5b = (int16_t)fw_sisa_index(e->accuracy_m);
	r->bgd_e1e5a_s = (float)e->tgd_s[0];
	r->bgd_e1e5b_s = (float)e->tgd_s[1];
	r->present = ALL(eph_gal) & ~(BIT(eph_gal_health_prs) | BIT(eph_gal_sisa_e1e6a) |
	                              BIT(eph_gal_bgd_e1e6a_s) | BIT(eph_gal_cnav_enc));
}

static void put_bds(const fw_ephemeris *e, furrow_eph_bds *r)
{
	int week;
	int64_t tow_ns;
	PUT_KEPLER(r, e);
	fw_time_to_bdt(e->toc, &week, &tow_ns);
	r->toc_s = seconds(tow_ns);
	r->toc_week = week;
	fw_time_to_bdt(e->toe, &week, &tow_ns);
	r->toe_s = seconds(tow_ns);
	r->toe_week = r->week = week;
	r->af0_s = e->af0_s;
	r->ura = (int16_t)fw_ura_index(e->accuracy_m);
	r->health = e->healthy ? 0 : 1;
	r->aodc = r->aode = (int16_t)(e->issue % 32);
	r->tgd1_s = (float)e->tgd_s[0];
	r->tgd2_s = (float)e->tgd_s[1];
	r->present = ALL(eph_bds);
}

static void put_glo(const fw_ephemeris *e, furrow_eph_glo *r)
{
	int week, n4 = 0, nt = 0;
	int64_t tow_ns, tod_ns = 0;
	fw_time_to_gps(e->toe, &week, &tow_ns);
	r->source = decoded;
	r->glonass_channel = (int8_t)e->state.channel;
	r->x_m = e->state.position_m[0];
	r->y_m = e->state.position_m[1];
	r->z_m = e->state.position_m[2];
	r->vx_mps = e->state.velocity_mps[0];
	r->vy_mps = e->state.velocity_mps[1];
	r->vz_mps = e->state.velocity_mps[2];
	r->ax_mps2 = e->state.acceleration_mps2[0];
	r->ay_mps2 = e->state.acceleration_mps2[1];
	r->az_mps2 = e->state.acceleration_mps2[2];
	r->gamma = (float)e->af1_sps;
	r->tau_s = -e->af0_s;
	r->dtau_s = (float)e->tgd_s[0];
	r->toe_s = seconds(tow_ns);
	r->toe_week = week % 1024;
	r->p1_min = 30;
	r->p2 = 1;
	r->health_b = e->healthy ? 0 : 4;
	r->m = 1;
	r->accuracy_m = e->accuracy_m;
	r->health_c = 1;
	if (fw_time_to_glonass(e->toe, &n4, &nt, &tod_ns) >= 0) {
		r->tb_min = (int16_t)(tod_ns / (60 * FW_NS_PER_S));
		r->nt_day = (int16_t)nt;
	}
	r->present = ALL(eph_glo);
}

fw_kind ephemeris_record(const fw_ephemeris *e, fw_time received, fw_any_record *record, char name[static 5])
{
	fw_kind kind = FW_RECORD_COUNT;
	fw_satellite_name(e->satellite, name);
	switch ((fw_system)e->satellite.system) {
	case FW_GPS:
	case FW_QZSS: kind = FW_eph_gps; break;
	case FW_GALILEO: kind = FW_eph_gal; break;
	case FW_BEIDOU: kind = FW_eph_bds; break;
	case FW_GLONASS: kind = FW_eph_glo; break;
	default: return kind;
	}
	fw_record_clear(kind, record);
	switch (kind) {
	case FW_eph_gps: put_gps(e, (furrow_eph_gps *)record); break;
	case FW_eph_gal: put_gal(e, (furrow_eph_gal *)record); break;
	case FW_eph_bds: put_bds(e, (furrow_eph_bds *)record); break;
	default: put_glo(e, (furrow_eph_glo *)record); break;
	}
	/* `sat` stands in the same place in all of them. */
	((furrow_eph_gps *)record)->sat = name;
	record_stamp(record, received);
	return kind;
}

/* ---- observations ---- */

void observation_record(const fw_observation *o, fw_time tag, int antenna, int channel, furrow_obs *record,
                        char satellite[static 5], char signal[static 3])
{
	fw_satellite_name(o->satellite, satellite);
	signal[0] = o->signal.band;
	signal[1] = o->signal.attribute;
	signal[2] = '\0';
	*record = (furrow_obs){.sat = satellite,
	                       .signal = signal,
	                       .antenna = (int8_t)antenna,
	                       .pseudorange_m = o->code_m,
	                       .carrier_cyc = o->carrier_cyc,
	                       .doppler_hz = o->doppler_hz,
	                       .cn0_dbhz = o->cn0_dbhz,
	                       .lock_s = (int32_t)o->lock_s,
	                       .half_cycle = o->half_cycle,
	                       .rx_channel = (int16_t)channel};
	record->present = ALL(obs);
	record_stamp(record, tag);
	if (o->satellite.system == FW_GLONASS)
		record->glonass_channel = o->glonass_channel;
	else
		record->present &= ~BIT(obs_glonass_channel);
}

/* ---- solutions ---- */

static void put_covariances(const fw_receiver_solution *s, furrow_pvt *r)
{
	const double(*P)[4] = s->covariance_m2, (*V)[4] = s->velocity_covariance_m2ps2;
	float *const position[] = {&r->cov_nn_m2, &r->cov_ee_m2, &r->cov_dd_m2, &r->cov_bb_m2, &r->cov_ne_m2,
	                           &r->cov_nd_m2, &r->cov_nb_m2, &r->cov_ed_m2, &r->cov_eb_m2, &r->cov_db_m2};
	float *const velocity[] = {
	    &r->cov_vnvn_m2ps2, &r->cov_veve_m2ps2, &r->cov_vdvd_m2ps2, &r->cov_ff_m2ps2,  &r->cov_vnve_m2ps2,
	    &r->cov_vnvd_m2ps2, &r->cov_vnf_m2ps2,  &r->cov_vevd_m2ps2, &r->cov_vef_m2ps2, &r->cov_vdf_m2ps2};
	static const int at[10][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1},
	                              {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
	for (int i = 0; i < 10; i++) {
		*position[i] = (float)P[at[i][0]][at[i][1]];
		*velocity[i] = (float)V[at[i][0]][at[i][1]];
	}
	r->sd_n_m = sqrt(P[0][0]);
	r->sd_e_m = sqrt(P[1][1]);
	r->sd_d_m = sqrt(P[2][2]);
}

void pvt_record(const fw_receiver_solution *s, fw_time tag, bool sbas, int64_t signals, furrow_pvt *r)
{
	enum { NO_SOLUTION = 1, STAND_ALONE = 1, SBAS = 6 };
	*r = (furrow_pvt){.present = BIT(pvt_mode) | BIT(pvt_error)};
	record_stamp(r, tag);
	if (s == NULL) {
		r->error = NO_SOLUTION; /* too few measurements */
		return;
	}
	r->mode = sbas ? SBAS : STAND_ALONE;
	r->lat_deg = fw_deg_from_rad(s->llh[0]);
	r->lon_deg = fw_deg_from_rad(s->llh[1]);
	r->height_m = s->llh[2];
	r->vn_mps = (float)s->velocity_ned_mps[0];
	r->ve_mps = (float)s->velocity_ned_mps[1];
	r->vd_mps = (float)s->velocity_ned_mps[2];
	r->course_deg =
	    (float)fw_deg_from_rad(fw_wrap_2pi(atan2(s->velocity_ned_mps[1], s->velocity_ned_mps[0])));
	r->clock_bias_s = s->clock_m / FW_SPEED_OF_LIGHT_MPS;
	r->clock_drift_ppm = (float)(1e6 * s->drift_mps / FW_SPEED_OF_LIGHT_MPS);
	r->n_sats = (int16_t)s->n_used;
	r->signals = signals;
	r->h_accuracy_m = 2 * sqrt(s->covariance_m2[0][0] + s->covariance_m2[1][1]);
	r->v_accuracy_m = 2 * sqrt(s->covariance_m2[2][2]);
	put_covariances(s, r);
	r->present = ALL(pvt) & ~(BIT(pvt_undulation_m) | BIT(pvt_reference_id) | BIT(pvt_corr_age_s) |
	                          BIT(pvt_latency_s));
}

void dop_record(const fw_receiver_solution *s, fw_time tag, furrow_dop *r)
{
	*r = (furrow_dop){0};
	record_stamp(r, tag);
	if (s == NULL)
		return;
	r->n_sats = (int16_t)s->n_used;
	r->pdop = s->pdop;
	r->tdop = s->tdop;
	r->hdop = s->hdop;
	r->vdop = s->vdop;
	r->hpl_m = (float)s->hpl_m;
	r->vpl_m = (float)s->vpl_m;
	r->present = ALL(dop);
}

void att_record(const fw_receiver_attitude *a, unsigned n_sats, fw_time tag, furrow_att *r)
{
	enum { TOO_FEW = 1, FIXED_HEADING_AND_PITCH = 2 };
	*r = (furrow_att){.error_aux1 = a == NULL ? TOO_FEW : 0};
	r->present = BIT(att_error_aux1) | BIT(att_error_aux2) | BIT(att_not_requested) | BIT(att_mode);
	record_stamp(r, tag);
	if (a == NULL)
		return;
	r->mode = FIXED_HEADING_AND_PITCH;
	r->n_sats = (int16_t)n_sats;
	r->heading_deg = (float)fw_deg_from_rad(a->heading_rad);
	r->pitch_deg = (float)fw_deg_from_rad(a->pitch_rad);
	r->sd_heading_deg = fw_deg_from_rad(a->sd_heading_rad);
	r->sd_pitch_deg = fw_deg_from_rad(a->sd_pitch_rad);
	r->cov_hh_deg2 = (float)(r->sd_heading_deg * r->sd_heading_deg);
	r->cov_pp_deg2 = (float)(r->sd_pitch_deg * r->sd_pitch_deg);
	r->present |= BIT(att_n_sats) | BIT(att_heading_deg) | BIT(att_pitch_deg) | BIT(att_sd_heading_deg) |
	              BIT(att_sd_pitch_deg) | BIT(att_cov_hh_deg2) | BIT(att_cov_pp_deg2) |
	              BIT(att_cov_hp_deg2);
}
