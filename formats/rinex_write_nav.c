#include "formats/rinex_write_nav.h"

#include <math.h>
#include <string.h>

#include "formats/rinex_accuracy.h"
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
#include "furrow_klobuchar_columns.h"
#include "furrow_nequick_columns.h"
#include "furrow_utc_columns.h"

/** BDS-SIS-ICD-B1I-3.0, 3.3: BeiDou weeks count from GPS week 1356, and BDT = GPST - 14 s */
enum { BDT_WEEKS = 1356, BDT_BEHIND_S = 14 };

enum { FNAV = 16 };

/* Not there: blanks. */
#define NONE ((double)NAN)

/* An entry on its way out: the numbers of its lines, three on the first, four on each of the others. */
typedef struct {
	fw_satellite satellite;
	fw_civil time; /* of the clock, on the system's own scale */
	int n;
	double value[31];
} entry;

static bool has(int64_t present, int column)
{
	return present >> column & 1;
}

/* ---- header ---- */

/* D notation with fewer decimals than an entry's numbers have. */
static void put_short(fw_rinex_out *o, double x, size_t width, int decimals)
{
	x = fabs(x) >= 1e-99 ? x : 0;
	int e = x != 0 ? (int)floor(log10(fabs(x))) : 0;

	if (fabs(x) / pow(10, e) >= 10 - 0.5 / pow(10, decimals)) /* would be rounded up to 10 */
		e++;
	const int digits = e < 0 ? -e : e;
	fw_rinex_out_fixed(o, x / pow(10, e), width - 4, decimals);
	fw_rinex_out_text(o, (char[]){'E', e < 0 ? '-' : '+', (char)('0' + digits / 10 % 10),
	                              (char)('0' + digits % 10), '\0'});
}

static void put_iono(fw_rinex_out *o, const char *name, const float *x, int n)
{
	fw_rinex_out_field(o, name, 5);
	for (int i = 0; i < n; i++)
		put_short(o, (double)x[i], 12, 4);
	fw_rinex_out_label(o, "IONOSPHERIC CORR");
}

static void put_klobuchar(fw_rinex_out *o, const char *a, const char *b, const furrow_klobuchar *k)
{
	if (k->present == 0)
		return;
	put_iono(o, a, (float[]){k->alpha0_s, k->alpha1_s, k->alpha2_s, k->alpha3_s}, 4);
	put_iono(o, b, (float[]){k->beta0_s, k->beta1_s, k->beta2_s, k->beta3_s}, 4);
}

/* TIME SYSTEM CORR. The reference week has eight bits; the full one is that next to the stamp. */
static void put_utc(fw_rinex_out *o, const char *name, const furrow_utc *u, int weeks)
{
	int week = 0;

	if (u->present == 0 || !has(u->present, FW_COL_utc_a0_s))
		return;
	const int now = u->gps_week - weeks;
	if (!has(u->present, FW_COL_utc_wnt) || fw_week_resolve(u->wnt & 255, 256, now, &week) != FW_OK)
		week = now;
	fw_rinex_out_field(o, name, 5);
	put_short(o, u->a0_s, 17, 10);
	put_short(o, (double)u->a1_sps, 16, 9);
	fw_rinex_out_int(o, u->tot_s, 7);
	fw_rinex_out_int(o, week, 5);
	fw_rinex_out_label(o, "TIME SYSTEM CORR");
}

static void put_leap(fw_rinex_out *o, const fw_rinex_survey *s)
{
	const furrow_utc *u = &s->utc[FW_GPS];
	int week = 0;

	if (s->facts.leap_s < 0)
		return;
	fw_rinex_out_int(o, s->facts.leap_s, 6);
	if (has(u->present, FW_COL_utc_leap_future_s) && u->leap_future_s != u->leap_s &&
	    has(u->present, FW_COL_utc_wnlsf) &&
	    fw_week_resolve(u->wnlsf & 255, 256, u->gps_week, &week) == FW_OK) {
		fw_rinex_out_int(o, u->leap_future_s, 6);
		fw_rinex_out_int(o, week, 6);
		fw_rinex_out_int(o, u->dn, 6);
	}
	fw_rinex_out_label(o, "LEAP SECONDS");
}

void fw_rinex_nav_write(fw_rinex_nav_writer *w, const fw_rinex_survey *survey, fw_output *output,
                        void *context)
{
	fw_rinex_out *o = &w->out;
	const furrow_nequick *n = &survey->nequick;

	fw_rinex_out_begin(o, output, context);
	w->entries = w->repeated = w->refused = 0;
	memset(w->last, 0, sizeof w->last);
	fw_rinex_out_head(o, "NAVIGATION DATA", survey->last);
	put_klobuchar(o, "GPSA", "GPSB", &survey->klobuchar[FW_GPS]);
	put_klobuchar(o, "QZSA", "QZSB", &survey->klobuchar[FW_QZSS]);
	put_klobuchar(o, "BDSA", "BDSB", &survey->klobuchar[FW_BEIDOU]);
	if (n->present != 0)
		put_iono(o, "GAL", (float[]){n->ai0_sfu, n->ai1_sfu, n->ai2_sfu}, 3);
	put_utc(o, "GPUT", &survey->utc[FW_GPS], 0);
	put_utc(o, "GAUT", &survey->utc[FW_GALILEO], 0);
	put_utc(o, "QZUT", &survey->utc[FW_QZSS], 0);
	put_utc(o, "BDUT", &survey->utc[FW_BEIDOU], BDT_WEEKS);
	put_leap(o, survey);
	fw_rinex_out_label(o, "END OF HEADER");
}

/* ---- entries ---- */

static void put_entry(fw_rinex_nav_writer *w, const entry *e)
{
	fw_rinex_out *o = &w->out;
	const int parts[5] = {e->time.month, e->time.day, e->time.hour, e->time.minute, e->time.second};
	char name[5];

	fw_satellite_name(e->satellite, name);
	if (e->satellite.system == FW_SBAS)
		memmove(name + 1, name + 2, 3);
	fw_rinex_out_field(o, name, 4);
	fw_rinex_out_int(o, e->time.year, 4);
	for (int i = 0; i < 5; i++)
		fw_rinex_out_text(
		    o, (char[]){' ', (char)('0' + parts[i] / 10), (char)('0' + parts[i] % 10), '\0'});
	for (int i = 0; i < e->n; i++) {
		if (i >= 3 && i % 4 == 3) {
			fw_rinex_out_end_line(o);
			fw_rinex_out_column(o, 4);
		}
		fw_rinex_out_scientific(o, e->value[i]);
	}
	fw_rinex_out_end_line(o);
	w->entries++;
}

/* What a column holds, or blanks. */
static double value_or_none(int64_t present, int column, double x)
{
	return has(present, column) ? x : NONE;
}

/* The satellite, and the stamp. False: the record has none. */
static bool begin_entry(fw_rinex_nav_writer *w, const void *record, const char *sat, entry *e, fw_time *stamp)
{
	*e = (entry){.n = 0};
	if (sat != NULL && fw_satellite_parse(sat, &e->satellite) == FW_OK &&
	    e->satellite.number < FW_SATELLITES_PER_SYSTEM && fw_record_time(record, stamp) == FW_OK)
		return true;
	w->refused++;
	return false;
}

/* Whether the satellite's last entry of this message said the same; `content` is what tells them apart. */
static bool is_repeated(fw_rinex_nav_writer *w, const entry *e, int message, int64_t content)
{
	int64_t *last = &w->last[e->satellite.system][e->satellite.number][message];

	content++; /* 0: nothing yet */
	if (*last == content) {
		w->repeated++;
		return true;
	}
	*last = content;
	return false;
}

/* A number that differs when the week, the second of week or the issue of data does. */
static int64_t content_of(int week, int32_t tow_s, int issue)
{
	return ((int64_t)week * 1048576 + tow_s) * 1024 + (issue & 1023);
}

/* A week of which only some bits were sent, next to the stamp's. */
static int full_week(int week, int modulus, int near_week)
{
	int full = near_week;

	(void)!fw_week_resolve(((week % modulus) + modulus) % modulus, modulus, near_week, &full);
	return full;
}

/* Date and time of a second of a week, on the scale that the week is of. */
static bool civil_of(int week, int tow_s, fw_civil *c)
{
	fw_time t;

	return fw_time_from_gps(week, tow_s * FW_NS_PER_S, &t) == FW_OK && fw_time_to_civil(t, c) == FW_OK;
}

/* Seconds from the beginning of a GPS week to a moment. */
static double since_week_s(fw_time t, int week)
{
	return (double)(t.ns - week * FW_NS_PER_WEEK) / 1e9;
}

/* What GPS, Galileo and BeiDou have in common: fields 0 to 19. */
#define KEPLER(p, issue)                                                                                     \
	(p)->af0_s, (double)(p)->af1_sps, (double)(p)->af2_sps2, (double)(issue), (double)(p)->crs_m,        \
	    (p)->deltan_radps, (p)->m0_rad, (double)(p)->cuc_rad, (p)->ecc, (double)(p)->cus_rad,            \
	    (p)->sqrt_a_sqrtm, (double)(p)->toe_s, (double)(p)->cic_rad, (p)->omega0_rad,                    \
	    (double)(p)->cis_rad, (p)->i0_rad, (double)(p)->crc_m, (p)->omega_rad, (p)->omegadot_radps,      \
	    (p)->idot_radps

static void put_values(entry *e, const double *value, int n)
{
	memcpy(e->value, value, (size_t)n * sizeof *value);
	e->n = n;
}

static void put_gps(fw_rinex_nav_writer *w, const furrow_eph_gps *p)
{
	entry e;
	fw_time stamp;

	if (!begin_entry(w, p, p->sat, &e, &stamp))
		return;
	const int toe_week = full_week(p->toe_week, 1024, p->gps_week),
	          toc_week = full_week(p->toc_week, 1024, p->gps_week);
	if (is_repeated(w, &e, 0, content_of(toe_week, p->toe_s, p->iodc)))
		return;
	if (!civil_of(toc_week, p->toc_s, &e.time)) {
		w->refused++;
		return;
	}
	const bool is_qzss = e.satellite.system == FW_QZSS;
	const double fit = is_qzss ? p->fit : p->fit != 0 ? 6 : 4; /* hours; the flag itself for QZSS */
	const double values[] = {
	    KEPLER(p, p->iode2),
	    value_or_none(p->present, FW_COL_eph_gps_code_on_l2, p->code_on_l2),
	    toe_week,
	    value_or_none(p->present, FW_COL_eph_gps_l2p_data, p->l2p_data),
	    value_or_none(p->present, FW_COL_eph_gps_ura, fw_ura_m(p->ura)),
	    value_or_none(p->present, FW_COL_eph_gps_health, p->health),
	    value_or_none(p->present, FW_COL_eph_gps_tgd_s, (double)p->tgd_s),
	    p->iodc,
	    since_week_s(stamp, toe_week),
	    value_or_none(p->present, FW_COL_eph_gps_fit, fit),
	};
	put_values(&e, values, sizeof values / sizeof *values);
	put_entry(w, &e);
}

/* Health of RINEX: E1B DVS 0, HS 1-2; E5a DVS 3, HS 4-5; E5b DVS 6, HS 7-8. */
static int gal_health(int health)
{
	return (health >> 1 & 7) | (health >> 9 & 7) << 3 | (health >> 5 & 7) << 6;
}

static void put_gal(fw_rinex_nav_writer *w, const furrow_eph_gal *p)
{
	const bool fnav = p->message == FNAV;
	entry e;
	fw_time stamp;

	if (!begin_entry(w, p, p->sat, &e, &stamp))
		return;
	const int toe_week = full_week(p->toe_week, 4096, p->gps_week),
	          toc_week = full_week(p->toc_week, 4096, p->gps_week);
	if (is_repeated(w, &e, fnav, content_of(toe_week, p->toe_s, p->iodnav)))
		return;
	if (!civil_of(toc_week, p->toc_s, &e.time)) {
		w->refused++;
		return;
	}
	const int sisa_column = fnav ? FW_COL_eph_gal_sisa_e1e5a : FW_COL_eph_gal_sisa_e1e5b;
	const double values[] = {
	    KEPLER(p, p->iodnav),
	    fnav ? 1 << 1 | 1 << 8 : 1 << 0 | 1 << 2 | 1 << 9, /* the signals it is from, the clock's pair */
	    toe_week,
	    NONE,
	    has(p->present, sisa_column) ? fw_sisa_m(fnav ? p->sisa_e1e5a : p->sisa_e1e5b) : -1,
	    value_or_none(p->present, FW_COL_eph_gal_health, gal_health(p->health)),
	    value_or_none(p->present, FW_COL_eph_gal_bgd_e1e5a_s, (double)p->bgd_e1e5a_s),
	    fnav ? 0 : value_or_none(p->present, FW_COL_eph_gal_bgd_e1e5b_s, (double)p->bgd_e1e5b_s),
	    since_week_s(stamp, toe_week),
	};
	put_values(&e, values, sizeof values / sizeof *values);
	put_entry(w, &e);
}

static void put_bds(fw_rinex_nav_writer *w, const furrow_eph_bds *p)
{
	entry e;
	fw_time stamp;

	if (!begin_entry(w, p, p->sat, &e, &stamp))
		return;
	const int now = p->gps_week - BDT_WEEKS;
	const int toe_week = full_week(p->toe_week, 8192, now), toc_week = full_week(p->toc_week, 8192, now);
	if (is_repeated(w, &e, 0, content_of(toe_week, p->toe_s, 32 * p->aode + p->aodc)))
		return;
	if (!civil_of(toc_week + BDT_WEEKS, p->toc_s, &e.time)) { /* a scale without leap seconds, as GPST */
		w->refused++;
		return;
	}
	const double values[] = {
	    KEPLER(p, p->aode),
	    NONE,
	    toe_week,
	    NONE,
	    value_or_none(p->present, FW_COL_eph_bds_ura, fw_ura_m(p->ura)),
	    value_or_none(p->present, FW_COL_eph_bds_health, p->health),
	    value_or_none(p->present, FW_COL_eph_bds_tgd1_s, (double)p->tgd1_s),
	    value_or_none(p->present, FW_COL_eph_bds_tgd2_s, (double)p->tgd2_s),
	    since_week_s(stamp, toe_week + BDT_WEEKS) - BDT_BEHIND_S,
	    value_or_none(p->present, FW_COL_eph_bds_aodc, p->aodc),
	};
	put_values(&e, values, sizeof values / sizeof *values);
	put_entry(w, &e);
}

/* Seconds of the week on UTC's scale. */
static double utc_tow_s(fw_time t)
{
	int leap_s = 0;

	(void)!fw_time_leap_seconds(t, &leap_s);
	return (double)((t.ns - leap_s * FW_NS_PER_S) % FW_NS_PER_WEEK) / 1e9;
}

static void put_glo(fw_rinex_nav_writer *w, const furrow_eph_glo *p)
{
	entry e;
	fw_time stamp, toe;

	if (!begin_entry(w, p, p->sat, &e, &stamp))
		return;
	const int toe_week = full_week(p->toe_week, 1024, p->gps_week);
	if (is_repeated(w, &e, 0, content_of(toe_week, p->toe_s, 0)))
		return;
	if (fw_time_from_gps(toe_week, p->toe_s * FW_NS_PER_S, &toe) != FW_OK ||
	    fw_time_to_utc(toe, &e.time) < 0) {
		w->refused++;
		return;
	}
	const double km = 1e-3;
	const double values[] = {
	    -p->tau_s,
	    (double)p->gamma,
	    utc_tow_s(stamp),
	    p->x_m * km,
	    p->vx_mps * km,
	    p->ax_mps2 * km,
	    value_or_none(p->present, FW_COL_eph_glo_health_b, p->health_b >> 2 & 1),
	    p->y_m * km,
	    p->vy_mps * km,
	    p->ay_mps2 * km,
	    value_or_none(p->present, FW_COL_eph_glo_glonass_channel, p->glonass_channel),
	    p->z_m * km,
	    p->vz_mps * km,
	    p->az_mps2 * km,
	    value_or_none(p->present, FW_COL_eph_glo_age_days, p->age_days),
	};
	put_values(&e, values, sizeof values / sizeof *values);
	put_entry(w, &e);
}

static void put_sbas(fw_rinex_nav_writer *w, const furrow_eph_sbas *p)
{
	entry e;
	fw_time stamp;
	int32_t week;
	int64_t tow_ns;

	if (!begin_entry(w, p, p->sat, &e, &stamp))
		return;
	/* t0 is a second of the day: of the one that puts it next to the stamp. */
	const int64_t t0_ns = p->t0_s * FW_NS_PER_S, half_day_ns = FW_NS_PER_DAY / 2;
	const fw_time t0 = {(stamp.ns - t0_ns + half_day_ns) / FW_NS_PER_DAY * FW_NS_PER_DAY + t0_ns};
	if (is_repeated(w, &e, 0, content_of(0, 0, p->iodn) + t0.ns / FW_NS_PER_S * 1024))
		return;
	if (fw_time_to_civil(t0, &e.time) != FW_OK) {
		w->refused++;
		return;
	}
	fw_time_to_gps(stamp, &week, &tow_ns);
	const double km = 1e-3, healthy = p->ura < 15 ? 0 : 1;
	const double values[] = {
	    (double)p->agf0_s,
	    (double)p->agf1_sps,
	    (double)tow_ns / 1e9,
	    p->x_m * km,
	    p->vx_mps * km,
	    p->ax_mps2 * km,
	    healthy,
	    p->y_m * km,
	    p->vy_mps * km,
	    p->ay_mps2 * km,
	    value_or_none(p->present, FW_COL_eph_sbas_ura, fw_ura_m(p->ura)),
	    p->z_m * km,
	    p->vz_mps * km,
	    p->az_mps2 * km,
	    value_or_none(p->present, FW_COL_eph_sbas_iodn, p->iodn),
	};
	put_values(&e, values, sizeof values / sizeof *values);
	put_entry(w, &e);
}

void fw_rinex_nav_put(void *writer, fw_kind kind, const void *record)
{
	switch (kind) {
	case FW_eph_gps: put_gps(writer, record); break;
	case FW_eph_gal: put_gal(writer, record); break;
	case FW_eph_bds: put_bds(writer, record); break;
	case FW_eph_glo: put_glo(writer, record); break;
	case FW_eph_sbas: put_sbas(writer, record); break;
	default: break;
	}
}

fw_status fw_rinex_nav_end(fw_rinex_nav_writer *w)
{
	return fw_rinex_out_flush(&w->out);
}
