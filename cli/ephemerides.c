#include "ephemerides.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "furrow_eph_bds.h"
#include "furrow_eph_bds_columns.h"
#include "furrow_eph_gal.h"
#include "furrow_eph_gal_columns.h"
#include "furrow_eph_glo.h"
#include "furrow_eph_glo_columns.h"
#include "furrow_eph_gps.h"
#include "furrow_eph_gps_columns.h"
#include "furrow_eph_sbas.h"
#include "furrow_eph_sbas_columns.h"
#include "furrow_klobuchar.h"
#include "furrow_klobuchar_columns.h"

/* ---- times ---- */

static bool has(const void *record, int column)
{
	return (((const fw_record_head *)record)->present >> column & 1) != 0;
}

/* Whether all columns from the first to the last one have a value. */
static bool has_range(const void *record, int first, int last)
{
	for (int i = first; i <= last; i++)
		if (!has(record, i))
			return false;
	return true;
}

/* The moment with this time of week that is nearest to another one. */
static fw_status nearest(fw_time near, int tow_s, int64_t period_s, fw_time *t)
{
	if (tow_s < 0 || tow_s > 604800)
		return FW_ERANGE;
	const int64_t period = period_s * FW_NS_PER_S;
	int64_t after = (tow_s * FW_NS_PER_S - near.ns % period) % period;
	if (after >= period / 2)
		after -= period;
	if (after < -period / 2)
		after += period;
	*t = fw_time_add_ns(near, after);
	return FW_OK;
}

/* GPS week (as many bits of it as `modulus` says, when has_week) and time of week to a moment near the stamp. */
static fw_status week_time(fw_time stamp, bool has_week, int week, int modulus, int tow_s, fw_time *t)
{
	int near_week, full;
	int64_t tow_ns;
	if (!has_week)
		return nearest(stamp, tow_s, 604800, t);
	fw_time_to_gps(stamp, &near_week, &tow_ns);
	if (tow_s < 0 || tow_s > 604800 || week < 0)
		return FW_ERANGE;
	fw_status status = fw_week_resolve(week % modulus, modulus, near_week, &full);
	if (status == FW_OK)
		status = fw_time_from_gps(full, 0, t);
	if (status == FW_OK)
		*t = fw_time_add_ns(*t, tow_s * FW_NS_PER_S);
	return status;
}

/* ---- accuracies ---- */

/* IS-GPS-200N 20.3.3.3.1.3, nominal values [m]; BDS-SIS-ICD-B1I-3.0 5.2.4.5 has the same. 15: do not use. */
static double ura_m(int index)
{
	static const double table[] = {2, 2.8, 4, 5.7, 8, 11.3, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096};
	return index >= 0 && index < 15 ? table[index] : 0;
}

/* Galileo OS SIS ICD 2.1, 5.1.12. 255: no accuracy prediction available. */
static double sisa_m(int index)
{
	if (index < 0 || index > 125)
		return 0;
	return index < 50    ? index * 0.01
	       : index < 75  ? 0.5 + (index - 50) * 0.02
	       : index < 100 ? 1 + (index - 75) * 0.04
	                     : 2 + (index - 100) * 0.16;
}

/* ---- one type each ---- */

/* The orbit's members have the same names in the three types. */
#define TAKE_KEPLER(e, r)                                                                                    \
	do {                                                                                                 \
		(e)->kepler.sqrt_a = (r)->sqrt_a_sqrtm;                                                      \
		(e)->kepler.ecc = (r)->ecc;                                                                  \
		(e)->kepler.i0 = (r)->i0_rad;                                                                \
		(e)->kepler.omega0 = (r)->omega0_rad;                                                        \
		(e)->kepler.omega = (r)->omega_rad;                                                          \
		(e)->kepler.m0 = (r)->m0_rad;                                                                \
		(e)->kepler.delta_n = (r)->deltan_radps;                                                     \
		(e)->kepler.omega_dot = (r)->omegadot_radps;                                                 \
		(e)->kepler.idot = (r)->idot_radps;                                                          \
		(e)->kepler.cuc = (double)(r)->cuc_rad;                                                      \
		(e)->kepler.cus = (double)(r)->cus_rad;                                                      \
		(e)->kepler.crc = (double)(r)->crc_m;                                                        \
		(e)->kepler.crs = (double)(r)->crs_m;                                                        \
		(e)->kepler.cic = (double)(r)->cic_rad;                                                      \
		(e)->kepler.cis = (double)(r)->cis_rad;                                                      \
		(e)->af0_s = (double)(r)->af0_s;                                                             \
		(e)->af1_sps = (double)(r)->af1_sps;                                                         \
		(e)->af2_sps2 = (double)(r)->af2_sps2;                                                       \
	} while (0)

static fw_status from_gps(const furrow_eph_gps *r, fw_time stamp, fw_ephemeris *e)
{
	if (!has_range(r, FW_COL_eph_gps_sqrt_a_sqrtm, FW_COL_eph_gps_af0_s))
		return FW_EINVAL;
	TAKE_KEPLER(e, r);
	e->message = FW_NAV_LNAV;
	e->issue = r->iode2;
	/* QZSS: the last bit is about another signal (L6) */
	e->healthy = (e->satellite.system == FW_QZSS ? r->health & ~1 : r->health) == 0;
	e->accuracy_m = ura_m(r->ura);
	e->tgd_s[0] = (double)r->tgd_s;
	fw_status status =
	    week_time(stamp, has(r, FW_COL_eph_gps_toe_week), r->toe_week, 1024, r->toe_s, &e->toe);
	if (status != FW_OK)
		return status;
	return nearest(e->toe, r->toc_s, 604800, &e->toc);
}

/* The bits of a signal in `health`: valid, data validity, two of status. */
static bool signal_healthy(int health, int shift)
{
	return (health >> shift & 1) == 0 || (health >> shift & 0xE) == 0;
}

static fw_status from_gal(const furrow_eph_gal *r, fw_time stamp, fw_ephemeris *e)
{
	if (!has_range(r, FW_COL_eph_gal_sqrt_a_sqrtm, FW_COL_eph_gal_af0_s))
		return FW_EINVAL;
	TAKE_KEPLER(e, r);
	const bool fnav = r->message == 16;
	const int sisa = fnav ? r->sisa_e1e5a : r->sisa_e1e5b;
	e->message = fnav ? FW_NAV_FNAV : FW_NAV_INAV;
	e->issue = r->iodnav;
	e->healthy = signal_healthy(r->health, 0) && signal_healthy(r->health, 4) &&
	             signal_healthy(r->health, 8) && sisa != 255;
	e->accuracy_m = sisa_m(sisa);
	e->tgd_s[0] = (double)r->bgd_e1e5a_s;
	e->tgd_s[1] = (double)r->bgd_e1e5b_s;
	fw_status status =
	    week_time(stamp, has(r, FW_COL_eph_gal_toe_week), r->toe_week, 4096, r->toe_s, &e->toe);
	if (status != FW_OK)
		return status;
	return nearest(e->toe, r->toc_s, 604800, &e->toc);
}

static fw_status from_bds(const furrow_eph_bds *r, fw_time stamp, fw_ephemeris *e)
{
	const int64_t bdt_ns = 14 * FW_NS_PER_S; /* GPST - BDT */
	if (!has_range(r, FW_COL_eph_bds_sqrt_a_sqrtm, FW_COL_eph_bds_af0_s))
		return FW_EINVAL;
	TAKE_KEPLER(e, r);
	e->message = FW_NAV_D1D2;
	e->issue = r->aode;
	e->healthy = r->health == 0;
	e->accuracy_m = ura_m(r->ura);
	e->tgd_s[0] = (double)r->tgd1_s;
	e->tgd_s[1] = (double)r->tgd2_s;
	const fw_time bdt = fw_time_add_ns(stamp, -bdt_ns);
	fw_status status =
	    week_time(bdt, has(r, FW_COL_eph_bds_toe_week), r->toe_week + 1356, 8192, r->toe_s, &e->toe);
	if (status == FW_OK)
		status = nearest(e->toe, r->toc_s, 604800, &e->toc);
	e->toe = fw_time_add_ns(e->toe, bdt_ns);
	e->toc = fw_time_add_ns(e->toc, bdt_ns);
	return status;
}

static fw_status from_glo(const furrow_eph_glo *r, fw_time stamp, fw_ephemeris *e)
{
	if (!has_range(r, FW_COL_eph_glo_glonass_channel, FW_COL_eph_glo_tau_s))
		return FW_EINVAL;
	e->message = FW_NAV_FDMA;
	e->issue = r->tb_min;
	/* The highest bit of B is about the satellite; l, where there is one, repeats it. */
	e->healthy = (r->health_b & 4) == 0 && r->l <= 0;
	e->accuracy_m = r->accuracy_m > 0 ? r->accuracy_m : 0;
	e->af0_s = -(double)r->tau_s;
	e->af1_sps = (double)r->gamma;
	e->tgd_s[0] = (double)r->dtau_s;
	memcpy(e->state.position_m, (const double[3]){r->x_m, r->y_m, r->z_m}, sizeof e->state.position_m);
	memcpy(e->state.velocity_mps, (const double[3]){r->vx_mps, r->vy_mps, r->vz_mps},
	       sizeof e->state.velocity_mps);
	memcpy(e->state.acceleration_mps2, (const double[3]){r->ax_mps2, r->ay_mps2, r->az_mps2},
	       sizeof e->state.acceleration_mps2);
	e->state.channel = r->glonass_channel;
	fw_status status =
	    week_time(stamp, has(r, FW_COL_eph_glo_toe_week), r->toe_week, 1024, r->toe_s, &e->toe);
	e->toc = e->toe;
	return status;
}

static fw_status from_sbas(const furrow_eph_sbas *r, fw_time stamp, fw_ephemeris *e)
{
	if (!has_range(r, FW_COL_eph_sbas_t0_s, FW_COL_eph_sbas_az_mps2))
		return FW_EINVAL;
	e->message = FW_NAV_SBAS;
	e->issue = r->iodn;
	e->healthy = r->ura >= 0 && r->ura < 15;
	e->accuracy_m = ura_m(r->ura);
	e->af0_s = (double)r->agf0_s;
	e->af1_sps = (double)r->agf1_sps;
	memcpy(e->state.position_m, (const double[3]){r->x_m, r->y_m, r->z_m}, sizeof e->state.position_m);
	memcpy(e->state.velocity_mps, (const double[3]){r->vx_mps, r->vy_mps, r->vz_mps},
	       sizeof e->state.velocity_mps);
	memcpy(e->state.acceleration_mps2, (const double[3]){r->ax_mps2, r->ay_mps2, r->az_mps2},
	       sizeof e->state.acceleration_mps2);
	fw_status status = nearest(stamp, r->t0_s % 86400, 86400, &e->toe);
	e->toc = e->toe;
	return status;
}

static const char *satellite_of(fw_kind kind, const void *record)
{
	switch (kind) {
	case FW_eph_gps: return ((const furrow_eph_gps *)record)->sat;
	case FW_eph_gal: return ((const furrow_eph_gal *)record)->sat;
	case FW_eph_bds: return ((const furrow_eph_bds *)record)->sat;
	case FW_eph_glo: return ((const furrow_eph_glo *)record)->sat;
	case FW_eph_sbas: return ((const furrow_eph_sbas *)record)->sat;
	default: return "";
	}
}

fw_status ephemeris_of_record(fw_kind kind, const void *record, fw_ephemeris *e)
{
	fw_ephemeris made = {0};
	fw_time stamp;
	const char *sat = satellite_of(kind, record);
	if (sat == NULL || fw_satellite_parse(sat, &made.satellite) != FW_OK)
		return FW_EINVAL;
	fw_status status = fw_record_time(record, &stamp);
	if (status != FW_OK)
		return status;
	switch (kind) {
	case FW_eph_gps: status = from_gps(record, stamp, &made); break;
	case FW_eph_gal: status = from_gal(record, stamp, &made); break;
	case FW_eph_bds: status = from_bds(record, stamp, &made); break;
	case FW_eph_glo: status = from_glo(record, stamp, &made); break;
	case FW_eph_sbas: status = from_sbas(record, stamp, &made); break;
	default: status = FW_EINVAL; break;
	}
	if (status == FW_OK)
		*e = made;
	return status;
}

fw_status klobuchar_of_record(const void *record, fw_klobuchar *k)
{
	const furrow_klobuchar *r = record;
	if (!has_range(r, FW_COL_klobuchar_alpha0_s, FW_COL_klobuchar_beta3_s))
		return FW_EINVAL;
	*k = (fw_klobuchar){
	    {(double)r->alpha0_s, (double)r->alpha1_s, (double)r->alpha2_s, (double)r->alpha3_s},
	    {(double)r->beta0_s, (double)r->beta1_s, (double)r->beta2_s, (double)r->beta3_s}};
	return FW_OK;
}

/* ---- the store ---- */

static int64_t distance_ns(const fw_ephemeris *e, fw_time t)
{
	return llabs(fw_time_diff_ns(e->toe, t));
}

/* The index of the last element that is not after t; -1: all are. */
static int last_not_after(const ephemeris_list *l, fw_time t)
{
	int i = (int)l->n - 1;
	while (i >= 0 && l->list[i].toe.ns > t.ns)
		i--;
	return i;
}

static bool make_room(ephemeris_list *l)
{
	if (l->n == EPHEMERIDES_PER_LIST) {
		l->n--;
		memmove(l->list, l->list + 1, l->n * sizeof l->list[0]);
	}
	if (l->n < l->room)
		return true;
	const unsigned room = l->room == 0 ? 4 : 2 * l->room;
	fw_ephemeris *list = realloc(l->list, room * sizeof list[0]);
	if (list == NULL)
		return false;
	l->list = list;
	l->room = room;
	return true;
}

static void insert(ephemeris_store *store, const fw_ephemeris *e)
{
	ephemeris_list *l = &store->lists[fw_satellite_index(e->satellite)][e->message == FW_NAV_FNAV];
	int i = last_not_after(l, e->toe);
	if (i >= 0 && l->list[i].toe.ns == e->toe.ns && l->list[i].issue == e->issue) {
		l->list[i] = *e;
		return;
	}
	if (!make_room(l)) {
		store->no_memory = true;
		return;
	}
	i = last_not_after(l, e->toe) + 1;
	memmove(l->list + i + 1, l->list + i, (l->n - (unsigned)i) * sizeof l->list[0]);
	l->list[i] = *e;
	l->n++;
}

void ephemeris_store_put(void *context, fw_kind kind, const void *record)
{
	ephemeris_store *store = context;
	fw_ephemeris e;
	fw_klobuchar k;
	if (kind == FW_klobuchar) {
		const char *sat = ((const furrow_klobuchar *)record)->sat;
		const char system = sat != NULL ? sat[0] : '\0';
		if ((system != 'G' && system != 'C') || klobuchar_of_record(record, &k) != FW_OK)
			return;
		if (system == 'G')
			store->iono.gps = k;
		else
			store->iono.beidou = k;
		store->iono.has_gps |= system == 'G';
		store->iono.has_beidou |= system == 'C';
		return;
	}
	if (kind != FW_eph_gps && kind != FW_eph_gal && kind != FW_eph_bds && kind != FW_eph_glo &&
	    kind != FW_eph_sbas)
		return;
	if (ephemeris_of_record(kind, record, &e) == FW_OK) {
		insert(store, &e);
		store->taken++;
	} else {
		store->refused++;
	}
}

/* The element nearest to t; of those equally near the last. */
static const fw_ephemeris *nearest_in(ephemeris_list *l, fw_time t)
{
	if (l->n == 0)
		return NULL;
	unsigned i = l->last < l->n ? l->last : l->n - 1;
	while (i + 1 < l->n && distance_ns(&l->list[i + 1], t) <= distance_ns(&l->list[i], t))
		i++;
	while (i > 0 && distance_ns(&l->list[i - 1], t) < distance_ns(&l->list[i], t))
		i--;
	l->last = i;
	return &l->list[i];
}

const fw_ephemeris *ephemeris_store_find(void *context, fw_satellite s, fw_nav_message wanted, fw_time t)
{
	const int64_t usable_ns = 4 * 3600 * FW_NS_PER_S; /* Galileo: as far as fw_ephemeris_state() goes */
	ephemeris_store *store = context;
	ephemeris_list *lists = store->lists[fw_satellite_index(s)];
	const int first = s.system == FW_GALILEO && wanted == FW_NAV_FNAV;
	const fw_ephemeris *e = nearest_in(&lists[first], t);
	if (s.system == FW_GALILEO && (e == NULL || distance_ns(e, t) > usable_ns)) {
		const fw_ephemeris *other = nearest_in(&lists[!first], t);
		e = other != NULL ? other : e;
	}
	return e != NULL && e->healthy ? e : NULL;
}

/* ---- states ---- */

enum { ARC_S = 30 };

/* Value and derivative at the fraction f of an arc of h seconds, from those at its ends. */
static void hermite(const double x[2], const double v[2], double f, double h, double *value, double *rate)
{
	const double g = 1 - f, slope = x[1] - x[0];
	const double a = h * v[0] - slope, b = slope - h * v[1];
	*value = g * x[0] + f * x[1] + f * g * (g * a + f * b);
	*rate = (slope + (g - f) * (g * a + f * b) + f * g * (b - a)) / h;
}

static void between(const ephemeris_arc *arc, double f, fw_satellite_state *state)
{
	const fw_satellite_state *s = arc->ends;
	for (int i = 0; i < 3; i++)
		hermite((const double[2]){s[0].position_m[i], s[1].position_m[i]},
		        (const double[2]){s[0].velocity_mps[i], s[1].velocity_mps[i]}, f, ARC_S,
		        &state->position_m[i], &state->velocity_mps[i]);
	hermite((const double[2]){s[0].clock_s, s[1].clock_s},
	        (const double[2]){s[0].drift_sps, s[1].drift_sps}, f, ARC_S, &state->clock_s,
	        &state->drift_sps);
}

/* Ephemerides are compared as bytes: what came again unchanged keeps its arc. */
static bool is_of(const ephemeris_arc *arc, const fw_ephemeris *e)
{
	return arc->there && memcmp(&arc->from, e, sizeof *e) == 0;
}

fw_status ephemeris_store_state(void *context, const fw_ephemeris *e, fw_time t, fw_satellite_state *state)
{
	const int64_t step_ns = ARC_S * FW_NS_PER_S;
	ephemeris_store *store = context;
	ephemeris_arc *arc = &store->arcs[fw_satellite_index(e->satellite)];
	const fw_time begin = {t.ns / step_ns * step_ns};
	if (!is_of(arc, e) || arc->begin.ns != begin.ns) {
		arc->there = false;
		fw_status status = fw_ephemeris_state(e, begin, &arc->ends[0]);
		if (status >= 0)
			status = fw_ephemeris_state(e, fw_time_add_ns(begin, step_ns), &arc->ends[1]);
		if (status < 0) /* the end of its validity: to the second */
			return fw_ephemeris_state(e, t, state);
		arc->from = *e;
		arc->begin = begin;
		arc->there = true;
	}
	between(arc, (double)(t.ns - begin.ns) / (double)step_ns, state);
	return FW_OK;
}

/* Only what has been used is cleared: the rest has not cost any memory so far. */
void ephemeris_store_free(ephemeris_store *store)
{
	for (unsigned i = 0; i < FW_SATELLITE_COUNT; i++) {
		for (int j = 0; j < EPHEMERIS_MESSAGES; j++) {
			if (store->lists[i][j].list == NULL)
				continue;
			free(store->lists[i][j].list);
			store->lists[i][j] = (ephemeris_list){0};
			store->arcs[i].there = false;
		}
	}
	store->iono = (fw_iono_coefficients){0};
	store->taken = store->refused = 0;
	store->no_memory = false;
}

void ephemeris_kinds(fw_kind_set *kinds)
{
	static const fw_kind all[] = {FW_eph_gps, FW_eph_gal,  FW_eph_bds,
	                              FW_eph_glo, FW_eph_sbas, FW_klobuchar};
	for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
		fw_kind_add(kinds, all[i]);
}
