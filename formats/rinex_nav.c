#include "formats/rinex_nav.h"

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
#include "furrow_klobuchar.h"
#include "furrow_klobuchar_columns.h"
#include "furrow_nequick.h"
#include "furrow_nequick_columns.h"
#include "furrow_utc.h"
#include "furrow_utc_columns.h"
#include "gnss/signal.h"

/* The columns that every record here begins with. */
enum { SAT = FW_COL_eph_gps_sat, SOURCE = FW_COL_eph_gps_source };

enum { KM = 1000 };

/* Not there. */
#define NONE ((double)NAN)

#define COUNT(table) (int)(sizeof(table) / sizeof *(table))

/* ---- numbers to columns ---- */

/* A number of an entry, times `unit`, is a column. Field 0 to 2 stand on the first line, 3 to 6 on the
 * second, ... */
typedef struct {
	uint8_t column, field;
	int16_t unit;
} rule;

#define KEPLER(type)                                                                                         \
	{FW_COL_##type##_af0_s, 0, 1}, {FW_COL_##type##_af1_sps, 1, 1}, {FW_COL_##type##_af2_sps2, 2, 1},    \
	    {FW_COL_##type##_crs_m, 4, 1}, {FW_COL_##type##_deltan_radps, 5, 1},                             \
	    {FW_COL_##type##_m0_rad, 6, 1}, {FW_COL_##type##_cuc_rad, 7, 1}, {FW_COL_##type##_ecc, 8, 1},    \
	    {FW_COL_##type##_cus_rad, 9, 1}, {FW_COL_##type##_sqrt_a_sqrtm, 10, 1},                          \
	    {FW_COL_##type##_toe_s, 11, 1}, {FW_COL_##type##_cic_rad, 12, 1},                                \
	    {FW_COL_##type##_omega0_rad, 13, 1}, {FW_COL_##type##_cis_rad, 14, 1},                           \
	    {FW_COL_##type##_i0_rad, 15, 1}, {FW_COL_##type##_crc_m, 16, 1},                                 \
	    {FW_COL_##type##_omega_rad, 17, 1}, {FW_COL_##type##_omegadot_radps, 18, 1},                     \
	{                                                                                                    \
		FW_COL_##type##_idot_radps, 19, 1                                                            \
	}

#define CARTESIAN(type)                                                                                      \
	{FW_COL_##type##_x_m, 3, KM}, {FW_COL_##type##_vx_mps, 4, KM}, {FW_COL_##type##_ax_mps2, 5, KM},     \
	    {FW_COL_##type##_y_m, 7, KM}, {FW_COL_##type##_vy_mps, 8, KM}, {FW_COL_##type##_ay_mps2, 9, KM}, \
	    {FW_COL_##type##_z_m, 11, KM}, {FW_COL_##type##_vz_mps, 12, KM},                                 \
	{                                                                                                    \
		FW_COL_##type##_az_mps2, 13, KM                                                              \
	}

enum {
	GPS_ACCURACY = 23,
	GPS_FIT = 28,
	GAL_SOURCE = 20,
	GAL_ACCURACY = 23,
	GAL_HEALTH = 24,
	GAL_BGD_E5B = 26,
	BDS_ACCURACY = 23,
	KEPLER_SENT = 27,
	GLO_SENT = 2,
	GLO_HEALTH = 6,
	GLO_DELAY = 16,
	SBAS_SENT = 2,
	SBAS_ACCURACY = 10
};

static const rule gps_rules[] = {
    KEPLER(eph_gps),
    {FW_COL_eph_gps_iode2, 3, 1},
    {FW_COL_eph_gps_iode3, 3, 1},
    {FW_COL_eph_gps_code_on_l2, 20, 1},
    {FW_COL_eph_gps_l2p_data, 22, 1},
    {FW_COL_eph_gps_health, 24, 1},
    {FW_COL_eph_gps_tgd_s, 25, 1},
    {FW_COL_eph_gps_iodc, 26, 1},
};
static const rule gal_rules[] = {
    KEPLER(eph_gal),
    {FW_COL_eph_gal_iodnav, 3, 1},
    {FW_COL_eph_gal_bgd_e1e5a_s, 25, 1},
};
static const rule bds_rules[] = {
    KEPLER(eph_bds),
    {FW_COL_eph_bds_aode, 3, 1},
    {FW_COL_eph_bds_health, 24, 1},
    {FW_COL_eph_bds_tgd1_s, 25, 1},
    {FW_COL_eph_bds_tgd2_s, 26, 1},
    {FW_COL_eph_bds_aodc, 28, 1},
};
static const rule glo_rules[] = {
    CARTESIAN(eph_glo),
    {FW_COL_eph_glo_tau_s, 0, -1},
    {FW_COL_eph_glo_gamma, 1, 1},
    {FW_COL_eph_glo_glonass_channel, 10, 1},
    {FW_COL_eph_glo_age_days, 14, 1},
};
static const rule sbas_rules[] = {
    CARTESIAN(eph_sbas),
    {FW_COL_eph_sbas_agf0_s, 0, 1},
    {FW_COL_eph_sbas_agf1_sps, 1, 1},
    {FW_COL_eph_sbas_iodn, 14, 1},
};
static const rule klobuchar_rules[] = {
    {FW_COL_klobuchar_alpha0_s, 0, 1}, {FW_COL_klobuchar_alpha1_s, 1, 1}, {FW_COL_klobuchar_alpha2_s, 2, 1},
    {FW_COL_klobuchar_alpha3_s, 3, 1}, {FW_COL_klobuchar_beta0_s, 4, 1},  {FW_COL_klobuchar_beta1_s, 5, 1},
    {FW_COL_klobuchar_beta2_s, 6, 1},  {FW_COL_klobuchar_beta3_s, 7, 1},
};
static const rule nequick_rules[] = {
    {FW_COL_nequick_ai0_sfu, 0, 1},
    {FW_COL_nequick_ai1_sfu, 1, 1},
    {FW_COL_nequick_ai2_sfu, 2, 1},
    {FW_COL_nequick_storm, 3, 1},
};

/* Gives a column a value. Returns false when it cannot hold it. */
static bool put(fw_kind kind, fw_any_record *record, int column, double x)
{
	static const double most[] = {[FW_I8] = INT8_MAX, [FW_I16] = INT16_MAX, [FW_I32] = INT32_MAX};
	const fw_column *c = &fw_record_type_of(kind)->columns[column];
	void *member = record->bytes + c->offset;

	x += 0.0; /* -0 is 0 */
	if (!isfinite(x) || (c->type == FW_F32 && !(fabs(x) < 3e38)) ||
	    (c->type <= FW_I32 && !(fabs(x) <= most[c->type])))
		return false;
	switch (c->type) {
	case FW_I8: *(int8_t *)member = (int8_t)lround(x); break;
	case FW_I16: *(int16_t *)member = (int16_t)lround(x); break;
	case FW_I32: *(int32_t *)member = (int32_t)lround(x); break;
	case FW_F32: *(float *)member = (float)x; break;
	default: *(double *)member = x; break;
	}
	record->head.present |= INT64_C(1) << column;
	return true;
}

static bool has(const fw_rinex_entry *e, int field)
{
	return e->have >> field & 1;
}

static bool apply(const rule *rules, int n, const fw_rinex_entry *e, fw_kind kind, fw_any_record *record)
{
	for (int i = 0; i < n; i++)
		if (has(e, rules[i].field) &&
		    !put(kind, record, rules[i].column, e->value[rules[i].field] * rules[i].unit))
			return false;
	return true;
}

/* ---- time ---- */

static int64_t floor_div(int64_t a, int64_t b)
{
	return a / b - (a % b < 0);
}

/* Time of transmission from a second of `period` (a week, or a day) of the message's own system, which is
 * `ahead_s` before GPST. Fields that say nothing (0.9999e9, or 0 on another day) leave the reference time. */
static fw_time sent_at(const fw_rinex_entry *e, int field, double ahead_s, double period_s)
{
	const double now_s = (double)(e->time.ns % FW_NS_PER_WEEK) / 1e9 - ahead_s;
	const double away = has(e, field) ? remainder(e->value[field] - now_s, period_s) : NONE;

	if (!(fabs(away) <= 86400) || !(fabs(e->value[field]) < 1e6))
		return e->time;
	return (fw_time){e->time.ns + llround(away * 1e3) * 1000000};
}

static void stamp(fw_any_record *record, fw_time t)
{
	int32_t week;

	fw_time_to_gps_s(t, &week, &record->head.tow_s);
	record->head.gps_week = week;
	record->head.present |= 3;
}

/* Second of week and week of toc, and the week of toe that is next to it, in a time that is `behind_s` behind
 * GPST and `weeks` younger. False: no such time. */
static bool put_weeks(const fw_rinex_entry *e, int behind_s, int weeks, int modulus, fw_kind kind,
                      const int column[3], fw_any_record *record)
{
	const int64_t own_ns = e->time.ns - behind_s * FW_NS_PER_S - weeks * FW_NS_PER_WEEK;
	const int64_t toc_s = floor_div(own_ns, FW_NS_PER_S),
	              toe_s = has(e, 11) ? llround(fmin(fmax(e->value[11], -1), 1e6)) : -1;
	const int64_t week = floor_div(toc_s, 604800), toe_week = floor_div(toc_s - toe_s + 302400, 604800);

	if (toe_s < 0 || toe_s > 604800 || week < 0 || toe_week < 0)
		return false;
	return put(kind, record, column[0], (double)(toc_s - week * 604800)) &&
	       put(kind, record, column[1], (double)(week % modulus)) &&
	       put(kind, record, column[2], (double)(toe_week % modulus));
}

/* ---- messages ---- */

static bool finish_gps(const fw_rinex_entry *e, const char *satellite, fw_any_record *record)
{
	static const int columns[3] = {FW_COL_eph_gps_toc_s, FW_COL_eph_gps_toc_week,
	                               FW_COL_eph_gps_toe_week};
	const double fit = e->value[GPS_FIT];

	if (!put_weeks(e, 0, 0, 1024, FW_eph_gps, columns, record))
		return false;
	stamp(record, sent_at(e, KEPLER_SENT, 0, 604800));
	if (has(e, GPS_ACCURACY) &&
	    !put(FW_eph_gps, record, FW_COL_eph_gps_ura, fw_ura_index(e->value[GPS_ACCURACY])))
		return false;
	if (has(e, GPS_FIT)) /* hours, or the flag itself */
		(void)put(FW_eph_gps, record, FW_COL_eph_gps_fit,
		          fit == 1 || fit > (satellite[0] == 'J' ? 2 : 4));
	return put(FW_eph_gps, record, FW_COL_eph_gps_week, record->head.gps_week % 1024);
}

/* Health of RINEX: E1B DVS 0, HS 1-2; E5a DVS 3, HS 4-5; E5b DVS 6, HS 7-8. */
static int gal_health(int rinex, bool fnav)
{
	const int e1b = 1 | (rinex & 7) << 1, e5a = 1 | (rinex >> 3 & 7) << 1,
	          e5b = 1 | (rinex >> 6 & 7) << 1;
	return fnav ? e5a << 8 : e1b | e5b << 4;
}

static bool finish_gal(const fw_rinex_entry *e, const char *satellite, fw_any_record *record)
{
	static const int columns[3] = {FW_COL_eph_gal_toc_s, FW_COL_eph_gal_toc_week,
	                               FW_COL_eph_gal_toe_week};
	const int source =
	    has(e, GAL_SOURCE) && fabs(e->value[GAL_SOURCE]) < 1024 ? (int)e->value[GAL_SOURCE] : 0;
	const bool fnav = (source >> 8 & 1) || (!(source >> 9 & 1) && (source & 7) == 2);
	const int sisa = has(e, GAL_ACCURACY) ? fw_sisa_index(e->value[GAL_ACCURACY]) : -1;

	(void)satellite;
	if (!put_weeks(e, 0, 0, 4096, FW_eph_gal, columns, record))
		return false;
	stamp(record, sent_at(e, KEPLER_SENT, 0, 604800));
	if (has(e, GAL_HEALTH) && fabs(e->value[GAL_HEALTH]) < 512)
		(void)put(FW_eph_gal, record, FW_COL_eph_gal_health,
		          gal_health((int)e->value[GAL_HEALTH], fnav));
	if (sisa >= 0)
		(void)put(FW_eph_gal, record, fnav ? FW_COL_eph_gal_sisa_e1e5a : FW_COL_eph_gal_sisa_e1e5b,
		          sisa);
	if (has(e, GAL_BGD_E5B) && (!fnav || e->value[GAL_BGD_E5B] != 0) && /* F/NAV sends none */
	    !put(FW_eph_gal, record, FW_COL_eph_gal_bgd_e1e5b_s, e->value[GAL_BGD_E5B]))
		return false;
	return put(FW_eph_gal, record, FW_COL_eph_gal_message, fnav ? 16 : 2);
}

static bool finish_bds(const fw_rinex_entry *e, const char *satellite, fw_any_record *record)
{
	static const int columns[3] = {FW_COL_eph_bds_toc_s, FW_COL_eph_bds_toc_week,
	                               FW_COL_eph_bds_toe_week};
	enum { WEEKS = 1356, BEHIND_S = 14 };
	int week;
	int64_t tow_ns;

	(void)satellite;
	if (!put_weeks(e, BEHIND_S, WEEKS, 8192, FW_eph_bds, columns, record))
		return false;
	const fw_time sent = sent_at(e, KEPLER_SENT, BEHIND_S, 604800);
	stamp(record, sent);
	fw_time_to_bdt(sent, &week, &tow_ns);
	if (has(e, BDS_ACCURACY) &&
	    !put(FW_eph_bds, record, FW_COL_eph_bds_ura, fw_ura_index(e->value[BDS_ACCURACY])))
		return false;
	return put(FW_eph_bds, record, FW_COL_eph_bds_week, week);
}

static bool finish_glo(const fw_rinex_entry *e, const char *satellite, fw_any_record *record)
{
	int n4, nt, week;
	int64_t tod_ns;
	double tow_s;

	(void)satellite;
	if (fw_time_to_glonass(e->time, &n4, &nt, &tod_ns) < 0)
		return false;
	/* The frame's time is UTC's: of the week in version 3, of the day in version 2. */
	const double ahead_s = 10800 - (double)((tod_ns - e->time.ns) % FW_NS_PER_DAY) / 1e9;
	stamp(record, sent_at(e, GLO_SENT, remainder(ahead_s, 86400), 86400));
	fw_time_to_gps_s(e->time, &week, &tow_s);
	if (has(e, GLO_HEALTH)) /* 1 stands for the flag's highest bit, the one that matters */
		(void)put(FW_eph_glo, record, FW_COL_eph_glo_health_b,
		          e->value[GLO_HEALTH] == 1 ? 4 : e->value[GLO_HEALTH]);
	if (has(e, GLO_DELAY) && fabs(e->value[GLO_DELAY]) < 1)
		(void)put(FW_eph_glo, record, FW_COL_eph_glo_dtau_s, e->value[GLO_DELAY]);
	return put(FW_eph_glo, record, FW_COL_eph_glo_toe_s, tow_s) &&
	       put(FW_eph_glo, record, FW_COL_eph_glo_toe_week, week % 1024) &&
	       put(FW_eph_glo, record, FW_COL_eph_glo_tb_min, (double)(tod_ns / (60 * FW_NS_PER_S))) &&
	       put(FW_eph_glo, record, FW_COL_eph_glo_nt_day, nt);
}

static bool finish_sbas(const fw_rinex_entry *e, const char *satellite, fw_any_record *record)
{
	(void)satellite;
	stamp(record, sent_at(e, SBAS_SENT, 0, 604800));
	if (has(e, SBAS_ACCURACY))
		(void)put(FW_eph_sbas, record, FW_COL_eph_sbas_ura, fw_ura_index(e->value[SBAS_ACCURACY]));
	return put(FW_eph_sbas, record, FW_COL_eph_sbas_t0_s,
	           (double)(e->time.ns % FW_NS_PER_DAY / FW_NS_PER_S));
}

typedef struct {
	char system;
	const char *names; /* of the message in version 4 */
	fw_kind kind;
	fw_rinex_time time;
	int n_lines; /* at least */
	const rule *rules;
	int n_rules;
	/* What a rule cannot say. False: the entry makes no sense. */
	bool (*finish)(const fw_rinex_entry *e, const char *satellite, fw_any_record *record);
} message;

static const message messages[] = {
    {'G', " LNAV ", FW_eph_gps, FW_RINEX_GPS, 8, gps_rules, COUNT(gps_rules), finish_gps},
    {'J', " LNAV ", FW_eph_gps, FW_RINEX_QZS, 8, gps_rules, COUNT(gps_rules), finish_gps},
    {'E', " INAV FNAV ", FW_eph_gal, FW_RINEX_GAL, 8, gal_rules, COUNT(gal_rules), finish_gal},
    {'C', " D1 D2 D1D2 ", FW_eph_bds, FW_RINEX_BDT, 8, bds_rules, COUNT(bds_rules), finish_bds},
    {'R', " FDMA ", FW_eph_glo, FW_RINEX_GLO, 4, glo_rules, COUNT(glo_rules), finish_glo},
    {'S', " SBAS ", FW_eph_sbas, FW_RINEX_GPS, 4, sbas_rules, COUNT(sbas_rules), finish_sbas},
};

static const message *find_message(char system)
{
	for (int i = 0; i < COUNT(messages); i++)
		if (messages[i].system == system)
			return &messages[i];
	return NULL;
}

/* ---- lines ---- */

static fw_status next_line(fw_rinex_nav *r)
{
	if (r->held) {
		r->held = false;
		return FW_OK;
	}
	return fw_lines_next(&r->lines, &r->line);
}

static fw_status complain(fw_rinex_nav *r, uint64_t line, const char *reason)
{
	r->problem = (fw_rinex_problem){line, reason};
	r->lost++;
	return FW_ESYNTAX;
}

static bool label_is(const fw_rinex_nav *r, const char *label)
{
	const size_t n = strlen(label);
	return r->line.n >= FW_RINEX_LABEL + n && memcmp(r->line.text + FW_RINEX_LABEL, label, n) == 0;
}

/* ---- header ---- */

static void forget_header(fw_rinex_nav *r)
{
	r->version = 0;
	r->has_header = false;
	r->n_pending = r->next_pending = 0;
	for (int i = 0; i < 4; i++)
		r->leap[i] = -1;
}

/* The set of a kind and satellite; a new one if there is none. NULL: too many. */
static fw_rinex_parameters *parameters(fw_rinex_nav *r, fw_kind kind, const char *satellite)
{
	fw_rinex_parameters *p = r->pending;

	for (int i = 0; i < r->n_pending; i++, p++)
		if (p->kind == kind && strcmp(p->satellite, satellite) == 0)
			return p;
	if (r->n_pending == FW_RINEX_PENDING) {
		r->passed_over++;
		return NULL;
	}
	*p = (fw_rinex_parameters){.kind = kind, .line = r->line.number};
	for (int i = 0; i < 8; i++)
		p->value[i] = NONE;
	memcpy(p->satellite, satellite, strlen(satellite) + 1);
	r->n_pending++;
	return p;
}

/* Numbers of a header line: n of them, from a column on, each `width` wide. Blank ones are absent. */
static fw_status take_numbers(fw_rinex_nav *r, fw_rinex_parameters *p, int first, int n, size_t from,
                              size_t width)
{
	for (int i = 0; p != NULL && i < n; i++) {
		double x;
		const fw_status status = fw_rinex_double(&r->line, from + (size_t)i * width, width, &x);
		if (status < 0)
			return complain(r, r->line.number, "damaged parameters in the header");
		if (status == FW_OK)
			p->value[first + i] = x;
	}
	return FW_OK;
}

/* IONOSPHERIC CORR: GPSA, GPSB, QZSA, ..., GAL */
static fw_status iono_line(fw_rinex_nav *r)
{
	static const struct {
		char name[5], letter;
	} sets[] = {{"GPSA", 'G'}, {"GPSB", 'G'}, {"QZSA", 'J'}, {"QZSB", 'J'}, {"BDSA", 'C'}, {"BDSB", 'C'}};
	char name[5], satellite[5] = "";
	int number = 0;

	fw_rinex_text(&r->line, 0, 4, name, sizeof name);
	if (strcmp(name, "GAL") == 0)
		return take_numbers(r, parameters(r, FW_nequick, "E"), 0, 3, 5, 12);
	for (int i = 0; i < COUNT(sets); i++) {
		if (strcmp(name, sets[i].name) != 0)
			continue;
		satellite[0] = sets[i].letter;
		if (fw_rinex_int(&r->line, 55, 3, &number) == FW_OK &&
		    fw_rinex_satellite(sets[i].letter, number) != NULL)
			memcpy(satellite, fw_rinex_satellite(sets[i].letter, number), 5);
		return take_numbers(r, parameters(r, FW_klobuchar, satellite), i % 2 == 0 ? 0 : 4, 4, 5, 12);
	}
	return FW_OK;
}

/* TIME SYSTEM CORR: GPUT, GAUT, QZUT, BDUT; the others are not of use here */
static fw_status time_line(fw_rinex_nav *r)
{
	static const char names[][5] = {"GPUT", "GAUT", "QZUT", "BDUT"}, letters[][2] = {"G", "E", "J", "C"};
	char name[5];

	fw_rinex_text(&r->line, 0, 4, name, sizeof name);
	for (int i = 0; i < COUNT(names); i++) {
		if (strcmp(name, names[i]) != 0)
			continue;
		fw_rinex_parameters *p = parameters(r, FW_utc, letters[i]);
		fw_status status = take_numbers(r, p, 0, 1, 5, 17);
		if (status == FW_OK)
			status = take_numbers(r, p, 1, 1, 22, 16);
		if (status == FW_OK)
			status = take_numbers(r, p, 2, 1, 38, 7);
		return status == FW_OK ? take_numbers(r, p, 3, 1, 45, 5) : status;
	}
	return FW_OK;
}

static fw_status alpha_line(fw_rinex_nav *r)
{
	return take_numbers(r, parameters(r, FW_klobuchar, "G"), 0, 4, 2, 12);
}

static fw_status beta_line(fw_rinex_nav *r)
{
	return take_numbers(r, parameters(r, FW_klobuchar, "G"), 4, 4, 2, 12);
}

/* DELTA-UTC: A0,A1,T,W of version 2 */
static fw_status utc_line(fw_rinex_nav *r)
{
	fw_rinex_parameters *p = parameters(r, FW_utc, "G");
	const fw_status status = take_numbers(r, p, 0, 2, 3, 19);

	return status == FW_OK ? take_numbers(r, p, 2, 2, 41, 9) : status;
}

static fw_status leap_line(fw_rinex_nav *r)
{
	char system[4];

	fw_rinex_text(&r->line, 24, 3, system, sizeof system);
	if (strcmp(system, "BDS") == 0) /* counted from BeiDou's beginning */
		return FW_OK;
	for (size_t i = 0; i < 4; i++)
		if (fw_rinex_int(&r->line, 6 * i, 6, &r->leap[i]) < 0)
			return complain(r, r->line.number, "damaged leap seconds");
	return FW_OK;
}

static const struct {
	const char *label;
	fw_status (*take)(fw_rinex_nav *r);
} header_lines[] = {
    {"IONOSPHERIC CORR", iono_line}, {"TIME SYSTEM CORR", time_line},    {"ION ALPHA", alpha_line},
    {"ION BETA", beta_line},         {"DELTA-UTC: A0,A1,T,W", utc_line}, {"LEAP SECONDS", leap_line},
};

static fw_status header_line(fw_rinex_nav *r)
{
	for (int i = 0; i < COUNT(header_lines); i++)
		if (label_is(r, header_lines[i].label))
			return header_lines[i].take(r);
	return FW_OK;
}

static fw_status version_line(fw_rinex_nav *r)
{
	static const char types[] = "NGHJL", systems[] = "GRSJE";
	double version = 0;
	const char *type =
	    r->line.n > 40 && r->line.text[20] != '\0' ? strchr(types, r->line.text[20]) : NULL;

	if (!label_is(r, "RINEX VERSION / TYPE") || type == NULL ||
	    fw_rinex_double(&r->line, 0, 9, &version) != FW_OK || !(version >= 2 && version < 5) ||
	    (version >= 3 && *type != 'N')) {
		(void)!complain(r, r->line.number, "no RINEX navigation file of version 2, 3 or 4");
		return FW_EUNKNOWN;
	}
	r->version = (int)lround(version * 100);
	r->system = systems[type - types];
	return FW_MORE;
}

/* One more line of the header. FW_MORE: it has been taken. */
static fw_status read_header(fw_rinex_nav *r)
{
	fw_status status = next_line(r);

	if (status != FW_OK)
		return status == FW_EOF && r->version != 0 ? FW_ETRUNCATED : status;
	if (r->version == 0)
		return version_line(r);
	if (!label_is(r, "END OF HEADER")) {
		status = header_line(r);
		return status == FW_OK ? FW_MORE : status;
	}
	if (r->leap[0] >= 0) /* where there are leap seconds but no parameters, the leap seconds alone */
		(void)parameters(r, FW_utc, "G");
	r->has_header = true;
	return FW_MORE;
}

/* ---- records ---- */

static void begin_record(fw_kind kind, const char *satellite, fw_any_record *record)
{
	static char source[] = "rinex";
	const fw_column *columns = fw_record_type_of(kind)->columns;

	fw_record_clear(kind, record);
	memcpy(record->bytes + columns[SAT].offset, &satellite, sizeof satellite);
	*(char **)(void *)(record->bytes + columns[SOURCE].offset) = source;
	record->head.present = INT64_C(1) << SAT | INT64_C(1) << SOURCE;
}

/* The values of a set; NAN: absent. */
static bool put_known(fw_kind kind, fw_any_record *record, int column, double x)
{
	return isnan(x) || put(kind, record, column, x);
}

static bool put_utc(const fw_rinex_nav *r, const double *value, bool is_gps, fw_any_record *record)
{
	static const int leap_columns[4] = {FW_COL_utc_leap_s, FW_COL_utc_leap_future_s, FW_COL_utc_wnlsf,
	                                    FW_COL_utc_dn};

	for (int i = 0; is_gps && i < 4; i++)
		if (r->leap[i] >= 0 &&
		    !put(FW_utc, record, leap_columns[i], i == 2 ? r->leap[i] % 256 : r->leap[i]))
			return false;
	return put_known(FW_utc, record, FW_COL_utc_a0_s, value[0]) &&
	       put_known(FW_utc, record, FW_COL_utc_a1_sps, value[1]) &&
	       put_known(FW_utc, record, FW_COL_utc_tot_s, value[2]) &&
	       put_known(FW_utc, record, FW_COL_utc_wnt, isnan(value[3]) ? NONE : fmod(value[3], 256));
}

/* A set of the header as a record. FW_MORE: nothing is in it; FW_ERANGE: or more than a column holds. */
static fw_status put_parameters(fw_rinex_nav *r, const fw_rinex_parameters *p, fw_any_record *record)
{
	const bool is_klobuchar = p->kind == FW_klobuchar;
	const rule *rules = is_klobuchar ? klobuchar_rules : nequick_rules;
	const int n = is_klobuchar ? COUNT(klobuchar_rules) : COUNT(nequick_rules) - 1;
	bool sound = true;

	memcpy(r->parameters_of, p->satellite, sizeof r->parameters_of);
	begin_record(p->kind, r->parameters_of, record);
	const int64_t empty = record->head.present;
	if (p->kind == FW_utc)
		sound = put_utc(r, p->value, p->satellite[0] != 'C', record);
	for (int i = 0; p->kind != FW_utc && i < n; i++)
		sound &= put_known(p->kind, record, rules[i].column, p->value[i]);
	return !sound ? FW_ERANGE : record->head.present == empty ? FW_MORE : FW_OK;
}

/* Sets of the header first, with the stamp of the record that waits for them. */
static fw_status hand_out(fw_rinex_nav *r, fw_kind *kind, fw_any_record *record)
{
	while (r->next_pending < r->n_pending) {
		const fw_rinex_parameters *p = &r->pending[r->next_pending++];
		const fw_status status = put_parameters(r, p, record);
		if (status == FW_ERANGE)
			return complain(r, p->line, "a parameter in the header is out of range");
		if (status == FW_MORE)
			continue;
		record->head.gps_week = r->waiting.head.gps_week;
		record->head.tow_s = r->waiting.head.tow_s;
		record->head.present |= 3;
		*kind = p->kind;
		r->entries++;
		return FW_OK;
	}
	memcpy(record, &r->waiting, sizeof *record);
	*kind = r->waiting_kind;
	r->has_waiting = false;
	r->entries++;
	return FW_OK;
}

/* ---- entries ---- */

/* The line that an entry begins with has something in its first columns; those behind it do not. */
static bool continues(const fw_rinex_nav *r)
{
	const size_t n = r->version >= 300 ? 4 : 3;

	return r->line.n > n && memcmp(r->line.text, "    ", n) == 0;
}

/* Numbers of a line to fields first, ..., `n` of them. One that the file ends in is none. */
static bool take_fields(const fw_line *line, fw_rinex_entry *e, int first, int n, size_t from)
{
	for (int i = 0; i < n; i++, from += 19) {
		const fw_status status = fw_rinex_double(line, from, 19, &e->value[first + i]);
		if (status < 0 || (status == FW_OK && !line->whole && line->n < from + 19))
			return false;
		e->have |= (int64_t)(status == FW_OK) << (first + i);
	}
	return true;
}

static bool take_time(const fw_rinex_nav *r, fw_rinex_time system, fw_rinex_entry *e)
{
	const fw_line *l = &r->line;
	const size_t year = r->version >= 300 ? 4 : 3, width = r->version >= 300 ? 4 : 2, next = year + width;
	fw_civil c = {0};
	int64_t ns = 0;

	if (fw_rinex_int(l, year, width, &c.year) != FW_OK || fw_rinex_int(l, next, 3, &c.month) != FW_OK ||
	    fw_rinex_int(l, next + 3, 3, &c.day) != FW_OK || fw_rinex_int(l, next + 6, 3, &c.hour) != FW_OK ||
	    fw_rinex_int(l, next + 9, 3, &c.minute) != FW_OK ||
	    fw_rinex_seconds(l, next + 12, r->version >= 300 ? 3 : 5, &ns) != FW_OK)
		return false;
	c.second = (int)(ns / FW_NS_PER_S);
	if (fw_rinex_moment(&c, system, &e->time) < 0)
		return false;
	e->time = fw_time_add_ns(e->time, ns % FW_NS_PER_S);
	return true;
}

/* All lines of the entry whose first is at hand. FW_ESYNTAX: damaged; all its lines have been taken. */
static fw_status take_entry(fw_rinex_nav *r, fw_rinex_time system, fw_rinex_entry *e)
{
	const size_t column = r->version >= 300 ? 23 : 22, indent = r->version >= 300 ? 4 : 3;
	fw_status status;

	*e = (fw_rinex_entry){.line = r->line.number, .n_lines = 1};
	bool sound = take_time(r, system, e) && take_fields(&r->line, e, 0, 3, column);
	while ((status = next_line(r)) == FW_OK && continues(r)) {
		const int first = 4 * e->n_lines - 1;
		sound = sound && first + 4 <= FW_RINEX_FIELDS && take_fields(&r->line, e, first, 4, indent);
		e->n_lines++;
	}
	r->held = status == FW_OK;
	if (status != FW_OK && status != FW_EOF)
		return status;
	return sound ? FW_OK : complain(r, e->line, "damaged entry, lost");
}

static fw_status read_ephemeris(fw_rinex_nav *r, const message *m)
{
	fw_rinex_entry *e = &r->entry;
	const fw_status status = take_entry(r, m->time, e);

	if (status != FW_OK)
		return status;
	if (e->n_lines < m->n_lines)
		return complain(r, e->line, "an entry ends too early, lost");
	begin_record(m->kind, r->satellite, &r->waiting);
	if (!apply(m->rules, m->n_rules, e, m->kind, &r->waiting) || !m->finish(e, r->satellite, &r->waiting))
		return complain(r, e->line, "an entry has a value out of range, lost");
	r->waiting_kind = m->kind;
	r->has_waiting = true;
	return FW_MORE;
}

static bool names_satellite(fw_rinex_nav *r, const char *name)
{
	const int ten = name[1] == ' ' ? 0 : name[1] - '0', one = name[2] - '0';
	const char *satellite;

	if (ten < 0 || ten > 9 || one < 0 || one > 9)
		return false;
	satellite = fw_rinex_satellite(name[0], 10 * ten + one);
	if (satellite != NULL)
		memcpy(r->satellite, satellite, strlen(satellite) + 1);
	return satellite != NULL;
}

/* The lines that belong to an entry which is not wanted. */
static fw_status pass_over(fw_rinex_nav *r)
{
	fw_status status;

	do
		status = next_line(r);
	while (status == FW_OK && continues(r));
	r->held = status == FW_OK;
	return status == FW_OK ? FW_MORE : status;
}

/* Ionosphere and time offsets of version 4 lie as numbers on lines like those of an ephemeris. */
static fw_status read_parameters(fw_rinex_nav *r, fw_kind kind)
{
	const rule *rules = kind == FW_klobuchar ? klobuchar_rules : nequick_rules;
	const int n = kind == FW_klobuchar ? COUNT(klobuchar_rules) : COUNT(nequick_rules);
	fw_rinex_entry *e = &r->entry;
	char code[5];

	fw_rinex_text(&r->line, 24, 4, code, sizeof code);
	if (kind == FW_utc) { /* the first line's text is no number */
		if (r->line.n > 23)
			r->line.n = 23;
		if (strcmp(code + 2, "UT") != 0) {
			r->passed_over++;
			return pass_over(r);
		}
	}
	const fw_status status = take_entry(r, r->satellite[0] == 'C' ? FW_RINEX_BDT : FW_RINEX_GPS, e);
	if (status != FW_OK)
		return status;
	begin_record(kind, r->satellite, &r->waiting);
	stamp(&r->waiting, e->time);
	bool sound = e->n_lines >= (kind == FW_klobuchar ? 3 : 2);
	if (kind == FW_utc) {
		const double value[4] = {has(e, 4) ? e->value[4] : NONE, has(e, 5) ? e->value[5] : NONE,
		                         r->waiting.head.tow_s, r->waiting.head.gps_week};
		sound = sound && put_utc(r, value, r->satellite[0] != 'C', &r->waiting);
	} else {
		sound = sound && apply(rules, n, e, kind, &r->waiting);
	}
	if (!sound)
		return complain(r, e->line, "damaged parameters, lost");
	r->waiting_kind = kind;
	r->has_waiting = true;
	return FW_MORE;
}

/* "> EPH G05 LNAV": what the lines behind it are. */
static fw_status read_frame(fw_rinex_nav *r)
{
	char type[4], name[5], wanted[8] = " ";
	const uint64_t line = r->line.number;
	const bool is_named = r->line.n >= 9 && names_satellite(r, r->line.text + 6);
	const message *m = is_named ? find_message(r->line.text[6]) : NULL;

	fw_rinex_text(&r->line, 2, 3, type, sizeof type);
	fw_rinex_text(&r->line, 10, 4, name, sizeof name);
	fw_status status = next_line(r);
	if (status != FW_OK)
		return status == FW_EOF ? FW_ETRUNCATED : status;
	if (r->line.n > 0 && r->line.text[0] == '>') {
		r->held = true;
		return complain(r, line, "an entry ends too early, lost");
	}
	if (strcmp(type, "ION") == 0 && m != NULL && (strcmp(name, "LNAV") == 0 || strcmp(name, "D1D2") == 0))
		return read_parameters(r, FW_klobuchar);
	if (strcmp(type, "ION") == 0 && m != NULL && strcmp(name, "IFNV") == 0)
		return read_parameters(r, FW_nequick);
	if (strcmp(type, "STO") == 0 && m != NULL && m->time != FW_RINEX_GLO && m->system != 'S')
		return read_parameters(r, FW_utc);
	memcpy(wanted + 1, name, strlen(name));
	wanted[1 + strlen(name)] = ' ';
	if (strcmp(type, "EPH") == 0 && m != NULL && name[0] != '\0' && strstr(m->names, wanted) != NULL)
		return read_ephemeris(r, m);
	r->passed_over++;
	return pass_over(r);
}

/* An entry of version 2 or 3. */
static fw_status read_satellite(fw_rinex_nav *r)
{
	char name[4];
	const message *m;

	fw_rinex_text(&r->line, 0, 3, name, sizeof name);
	if (r->version >= 300)
		memcpy(name, r->line.text, 3);
	else {
		name[0] = r->system;
		memcpy(name + 1, r->line.text, 2);
	}
	if (!names_satellite(r, name)) {
		const uint64_t line = r->line.number;
		const fw_status status = pass_over(r);
		return status == FW_MORE || status == FW_EOF
		           ? complain(r, line, "no satellite has this name, entry lost")
		           : status;
	}
	m = find_message(name[0]);
	if (m != NULL)
		return read_ephemeris(r, m);
	r->passed_over++;
	return pass_over(r);
}

/* FW_MORE: something has been taken, and perhaps waits to be handed out. */
static fw_status read_entry(fw_rinex_nav *r)
{
	const fw_status status = next_line(r);

	if (status != FW_OK)
		return status;
	if (label_is(r, "RINEX VERSION / TYPE")) { /* another file behind the first */
		forget_header(r);
		r->held = true;
		return FW_MORE;
	}
	if (r->line.n < 4 || continues(r)) { /* of an entry whose beginning is lost */
		if (r->searching || r->line.n == 0 || strspn(r->line.text, " ") >= r->line.n)
			return FW_MORE;
		r->searching = true;
		return complain(r, r->line.number, "lines that belong to no entry");
	}
	r->searching = false;
	if (r->version >= 400) {
		if (r->line.text[0] == '>')
			return read_frame(r);
		r->searching = true;
		return complain(r, r->line.number, "lines that belong to no entry");
	}
	return read_satellite(r);
}

void fw_rinex_nav_begin(fw_rinex_nav *r, fw_input *input)
{
	r->problem = (fw_rinex_problem){0, ""};
	r->entries = r->lost = r->passed_over = 0;
	r->held = r->searching = r->has_waiting = false;
	r->final = FW_OK;
	forget_header(r);
	fw_lines_begin(&r->lines, input);
}

fw_status fw_rinex_nav_read(fw_rinex_nav *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status = FW_MORE;

	while (r->final == FW_OK && status == FW_MORE)
		status = r->has_waiting  ? hand_out(r, kind, record)
		         : r->has_header ? read_entry(r)
		                         : read_header(r);
	if (r->final == FW_OK && status != FW_OK && status != FW_ESYNTAX)
		r->final = status;
	return r->final != FW_OK ? r->final : status;
}
