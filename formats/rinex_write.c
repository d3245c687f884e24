#include "formats/rinex_write.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "furrow_eph_glo.h"
#include "furrow_eph_glo_columns.h"
#include "furrow_event.h"
#include "furrow_obs.h"
#include "furrow_obs_columns.h"
#include "furrow_pvt.h"
#include "furrow_pvt_columns.h"
#include "furrow_setup.h"
#include "furrow_setup_columns.h"
#include "furrow_utc_columns.h"

enum { CODE, CARRIER, DOPPLER, CN0 };
enum { LLI_LOST = 1, LLI_HALF = 2 };

static const char letters[] = "CLDS";

/* 1 degree is pi / 180 rad. */
#define RAD_PER_DEG 0.017453292519943295769

static bool has(int64_t present, int column)
{
	return present >> column & 1;
}

/* ---- which satellite, which signal ---- */

/* What a row is of. False: RINEX has no name for it, or something is missing. */
static bool name_row(const furrow_obs *o, fw_rinex_row *row)
{
	static const int columns[4] = {FW_COL_obs_pseudorange_m, FW_COL_obs_carrier_cyc,
	                               FW_COL_obs_doppler_hz, FW_COL_obs_cn0_dbhz};
	const double values[4] = {o->pseudorange_m, o->carrier_cyc, o->doppler_hz, o->cn0_dbhz};
	const char *signal = o->signal;
	fw_satellite satellite;

	if (!has(o->present, FW_COL_obs_sat) || !has(o->present, FW_COL_obs_signal) ||
	    fw_satellite_parse(o->sat, &satellite) != FW_OK || satellite.number >= FW_SATELLITES_PER_SYSTEM)
		return false;
	if (signal[0] < '1' || signal[0] > '9' || signal[1] < 'A' || signal[1] > 'Z' || signal[2] != '\0')
		return false;
	*row = (fw_rinex_row){.system = satellite.system,
	                      .number = satellite.number,
	                      .band = (uint8_t)(signal[0] - '0'),
	                      .attribute = (uint8_t)(signal[1] - 'A')};
	for (int i = 0; i < 4; i++) {
		row->value[i] = values[i];
		row->has |= (uint8_t)(has(o->present, columns[i]) << i);
	}
	return row->has != 0;
}

static int antenna_of(const furrow_obs *o)
{
	return o->antenna >= 0 && o->antenna < FW_RINEX_ANTENNAS ? o->antenna : -1;
}

/* ---- survey ---- */

void fw_rinex_survey_begin(fw_rinex_survey *s)
{
	memset(s, 0, sizeof *s);
	s->facts.leap_s = -1;
	memset(s->facts.glonass_channel, INT8_MIN, sizeof s->facts.glonass_channel);
}

static void survey_slot(fw_rinex_survey *s, const char *sat, int channel)
{
	fw_satellite satellite;

	if (fw_satellite_parse(sat, &satellite) == FW_OK && satellite.system == FW_GLONASS &&
	    satellite.number < FW_SATELLITES_PER_SYSTEM && channel >= -7 && channel <= 6)
		s->facts.glonass_channel[satellite.number] = (int8_t)channel;
}

static void survey_obs(fw_rinex_survey *s, const furrow_obs *o)
{
	const int antenna = antenna_of(o);
	fw_rinex_row row;
	fw_time t;

	if (antenna < 0 || !name_row(o, &row) || fw_record_time(o, &t) != FW_OK)
		return;
	s->seen[antenna][row.system][row.band][row.attribute] |= row.has;
	s->has_antenna[antenna] = true;
	if (!s->timed)
		s->first = s->last = t;
	s->timed = true;
	if (t.ns > s->last.ns && (s->interval_ns == 0 || t.ns - s->last.ns < s->interval_ns))
		s->interval_ns = t.ns - s->last.ns;
	s->last = t.ns > s->last.ns ? t : s->last;
	s->first = t.ns < s->first.ns ? t : s->first;
	if (has(o->present, FW_COL_obs_glonass_channel))
		survey_slot(s, o->sat, o->glonass_channel);
}

static void survey_place(fw_rinex_survey *s, double lat_deg, double lon_deg, double height_m)
{
	const double llh[3] = {lat_deg * RAD_PER_DEG, lon_deg * RAD_PER_DEG, height_m};

	if (!s->facts.has_position)
		s->facts.has_position = fw_llh_to_ecef(llh, s->facts.position_m) == FW_OK;
}

static void copy(char *to, size_t room, const char *from)
{
	const size_t n = from != NULL ? strnlen(from, room - 1) : 0;

	memcpy(to, from, n);
	to[n] = '\0';
}

static void survey_setup(fw_rinex_survey *s, const furrow_setup *p)
{
	fw_rinex_header *h = &s->facts;

	copy(h->marker_name, sizeof h->marker_name, p->marker_name);
	copy(h->marker_number, sizeof h->marker_number, p->marker_number);
	copy(h->marker_type, sizeof h->marker_type, p->marker_type);
	copy(h->observer, sizeof h->observer, p->observer);
	copy(h->agency, sizeof h->agency, p->agency);
	copy(h->rx_serial, sizeof h->rx_serial, p->rx_serial);
	copy(h->rx_name, sizeof h->rx_name, p->rx_name);
	copy(h->rx_version, sizeof h->rx_version, p->rx_version);
	copy(h->ant_serial, sizeof h->ant_serial, p->ant_serial);
	copy(h->ant_type, sizeof h->ant_type, p->ant_type);
	h->antenna_hen_m[0] = (double)p->delta_h_m;
	h->antenna_hen_m[1] = (double)p->delta_e_m;
	h->antenna_hen_m[2] = (double)p->delta_n_m;
	if (has(p->present, FW_COL_setup_lat_deg) && has(p->present, FW_COL_setup_lon_deg) &&
	    has(p->present, FW_COL_setup_height_m) && (p->lat_deg != 0 || p->lon_deg != 0))
		survey_place(s, p->lat_deg, p->lon_deg, (double)p->height_m);
}

/* The satellite that a set of parameters is from, or its system's letter alone. */
static fw_system system_of(const char *sat)
{
	return sat != NULL && sat[0] != '\0' ? fw_system_of_letter(sat[0]) : FW_SYSTEM_COUNT;
}

static void survey_utc(fw_rinex_survey *s, const furrow_utc *p)
{
	const fw_system system = system_of(p->sat);
	fw_time t;

	if (system == FW_SYSTEM_COUNT || fw_record_time(p, &t) != FW_OK)
		return;
	s->utc[system] = *p;
	if (system != FW_BEIDOU && has(p->present, FW_COL_utc_leap_s))
		s->facts.leap_s = p->leap_s;
}

void fw_rinex_survey_put(void *survey, fw_kind kind, const void *record)
{
	fw_rinex_survey *s = survey;

	switch (kind) {
	case FW_obs: survey_obs(s, record); break;
	case FW_setup: survey_setup(s, record); break;
	case FW_pvt: {
		const furrow_pvt *p = record;
		if (has(p->present, FW_COL_pvt_lat_deg) && has(p->present, FW_COL_pvt_lon_deg) &&
		    has(p->present, FW_COL_pvt_height_m))
			survey_place(s, p->lat_deg, p->lon_deg, p->height_m);
		break;
	}
	case FW_eph_glo: {
		const furrow_eph_glo *p = record;
		if (has(p->present, FW_COL_eph_glo_glonass_channel))
			survey_slot(s, p->sat, p->glonass_channel);
		s->has_navigation = true;
		break;
	}
	case FW_eph_gps:
	case FW_eph_gal:
	case FW_eph_bds:
	case FW_eph_sbas: s->has_navigation = true; break;
	case FW_klobuchar: {
		const furrow_klobuchar *p = record;
		if (system_of(p->sat) != FW_SYSTEM_COUNT)
			s->klobuchar[system_of(p->sat)] = *p;
		break;
	}
	case FW_nequick: s->nequick = *(const furrow_nequick *)record; break;
	case FW_utc: survey_utc(s, record); break;
	default: break;
	}
}

/* ---- header ---- */

static void put_names(fw_rinex_out *o, const fw_rinex_header *h)
{
	fw_rinex_out_field(o, h->marker_name[0] != '\0' ? h->marker_name : "UNKN", 60);
	fw_rinex_out_label(o, "MARKER NAME");
	if (h->marker_number[0] != '\0') {
		fw_rinex_out_field(o, h->marker_number, 20);
		fw_rinex_out_label(o, "MARKER NUMBER");
	}
	fw_rinex_out_field(o, h->marker_type, 20);
	fw_rinex_out_label(o, "MARKER TYPE");
	fw_rinex_out_field(o, h->observer, 20);
	fw_rinex_out_field(o, h->agency, 40);
	fw_rinex_out_label(o, "OBSERVER / AGENCY");
	fw_rinex_out_field(o, h->rx_serial, 20);
	fw_rinex_out_field(o, h->rx_name, 20);
	fw_rinex_out_field(o, h->rx_version, 20);
	fw_rinex_out_label(o, "REC # / TYPE / VERS");
	fw_rinex_out_field(o, h->ant_serial, 20);
	fw_rinex_out_field(o, h->ant_type, 20);
	fw_rinex_out_label(o, "ANT # / TYPE");
	for (int i = 0; i < 3; i++)
		fw_rinex_out_fixed(o, h->position_m[i], 14, 4);
	fw_rinex_out_label(o, "APPROX POSITION XYZ");
	for (int i = 0; i < 3; i++)
		fw_rinex_out_fixed(o, h->antenna_hen_m[i], 14, 4);
	fw_rinex_out_label(o, "ANTENNA: DELTA H/E/N");
}

/* Each signal of a system in turn: its observables that occur. */
#define EACH_SIGNAL(band, attribute)                                                                         \
	for (int band = 1; band < FW_RINEX_BANDS; band++)                                                    \
		for (int attribute = 0; attribute < FW_RINEX_ATTRIBUTES; attribute++)

/* SYS / # / OBS TYPES; notes where each signal's observables begin. */
static void put_types(fw_rinex_obs_writer *w, fw_system system)
{
	const uint8_t(*seen)[FW_RINEX_ATTRIBUTES] = w->survey->seen[w->antenna][system];
	fw_rinex_out *o = &w->out;
	int n = 0, on_line = 0;

	EACH_SIGNAL(b, a)
	{
		w->column[system][b][a] = (int16_t)n;
		n += __builtin_popcount(seen[b][a]);
	}
	w->n_columns[system] = n;
	if (n == 0)
		return;
	fw_rinex_out_text(o, (char[]){fw_system_letter(system), '\0'});
	fw_rinex_out_int(o, n, 5);
	EACH_SIGNAL(b, a)
	{
		for (int i = 0; i < 4; i++) {
			if (!(seen[b][a] >> i & 1))
				continue;
			if (on_line++ == 13) {
				fw_rinex_out_label(o, "SYS / # / OBS TYPES");
				fw_rinex_out_column(o, 6);
				on_line = 1;
			}
			fw_rinex_out_text(o,
			                  (char[]){' ', letters[i], (char)('0' + b), (char)('A' + a), '\0'});
		}
	}
	fw_rinex_out_label(o, "SYS / # / OBS TYPES");
}

/* SYS / PHASE SHIFT: none is known to have been applied. */
static void put_shifts(fw_rinex_obs_writer *w, fw_system system)
{
	EACH_SIGNAL(b, a)
	{
		if (!(w->survey->seen[w->antenna][system][b][a] >> CARRIER & 1))
			continue;
		fw_rinex_out_text(&w->out, (char[]){fw_system_letter(system), ' ', 'L', (char)('0' + b),
		                                    (char)('A' + a), '\0'});
		fw_rinex_out_label(&w->out, "SYS / PHASE SHIFT");
	}
}

static void put_slots(fw_rinex_out *o, const fw_rinex_header *h)
{
	int n = 0, on_line = 0;

	for (int i = 0; i < FW_SATELLITES_PER_SYSTEM; i++)
		n += h->glonass_channel[i] != INT8_MIN;
	fw_rinex_out_int(o, n, 3);
	fw_rinex_out_text(o, " ");
	for (int i = 0; i < FW_SATELLITES_PER_SYSTEM; i++) {
		if (h->glonass_channel[i] == INT8_MIN)
			continue;
		if (on_line++ == 8) {
			fw_rinex_out_label(o, "GLONASS SLOT / FRQ #");
			fw_rinex_out_column(o, 4);
			on_line = 1;
		}
		fw_rinex_out_text(o, (char[]){'R', (char)('0' + i / 10), (char)('0' + i % 10), '\0'});
		fw_rinex_out_int(o, h->glonass_channel[i], 3);
		fw_rinex_out_text(o, " ");
	}
	fw_rinex_out_label(o, "GLONASS SLOT / FRQ #");
	fw_rinex_out_label(o, "GLONASS COD/PHS/BIS");
}

static void put_limit(fw_rinex_out *o, fw_time t, const char *label)
{
	fw_civil c = {0};

	if (fw_time_to_civil(t, &c) != FW_OK)
		return;
	const int parts[5] = {c.year, c.month, c.day, c.hour, c.minute};
	for (int i = 0; i < 5; i++)
		fw_rinex_out_int(o, parts[i], 6);
	fw_rinex_out_fixed(o, c.second + c.nanosecond / 1e9, 13, 7);
	fw_rinex_out_text(o, "     GPS");
	fw_rinex_out_label(o, label);
}

static void put_header(fw_rinex_obs_writer *w)
{
	const fw_rinex_survey *s = w->survey;
	fw_rinex_out *o = &w->out;

	fw_rinex_out_head(o, "OBSERVATION DATA", s->last);
	put_names(o, &s->facts);
	for (int i = 0; i < FW_SYSTEM_COUNT; i++)
		put_types(w, (fw_system)i);
	fw_rinex_out_text(o, "DBHZ");
	fw_rinex_out_label(o, "SIGNAL STRENGTH UNIT");
	if (s->interval_ns > 0) {
		fw_rinex_out_fixed(o, (double)s->interval_ns / 1e9, 10, 3);
		fw_rinex_out_label(o, "INTERVAL");
	}
	put_limit(o, s->first, "TIME OF FIRST OBS");
	put_limit(o, s->last, "TIME OF LAST OBS");
	for (int i = 0; i < FW_SYSTEM_COUNT; i++)
		put_shifts(w, (fw_system)i);
	if (w->n_columns[FW_GLONASS] > 0)
		put_slots(o, &s->facts);
	if (s->facts.leap_s >= 0) {
		fw_rinex_out_int(o, s->facts.leap_s, 6);
		fw_rinex_out_label(o, "LEAP SECONDS");
	}
	fw_rinex_out_label(o, "END OF HEADER");
}

void fw_rinex_obs_write(fw_rinex_obs_writer *w, const fw_rinex_survey *survey, int antenna, fw_output *output,
                        void *context)
{
	fw_rinex_out_begin(&w->out, output, context);
	w->epochs = w->refused = 0;
	w->survey = survey;
	w->antenna = antenna;
	w->n_rows = 0;
	memset(w->last, 0, sizeof w->last);
	put_header(w);
}

/* ---- epochs ---- */

static void put_epoch_line(fw_rinex_obs_writer *w, fw_time t, int flag, int n)
{
	fw_rinex_out *o = &w->out;
	fw_civil c = {0};

	if (fw_time_to_civil(t, &c) != FW_OK)
		return; /* fw_record_time() has seen to that */
	const int parts[5] = {c.year, c.month, c.day, c.hour, c.minute};
	fw_rinex_out_text(o, "> ");
	fw_rinex_out_int(o, parts[0], 4);
	for (int i = 1; i < 5; i++)
		fw_rinex_out_text(
		    o, (char[]){' ', (char)('0' + parts[i] / 10), (char)('0' + parts[i] % 10), '\0'});
	fw_rinex_out_fixed(o, c.second + c.nanosecond / 1e9, 11, 7);
	fw_rinex_out_int(o, flag, 3);
	fw_rinex_out_int(o, n, 3);
	fw_rinex_out_end_line(o);
}

/* A satellite's line: of the rows from `first` on those that are of it. */
static void put_satellite(fw_rinex_obs_writer *w, int first)
{
	const fw_rinex_row *head = &w->rows[first];
	const int n = w->n_columns[head->system];
	const fw_rinex_row *of[4 * 9 * FW_RINEX_ATTRIBUTES] = {0};
	uint8_t what[4 * 9 * FW_RINEX_ATTRIBUTES];

	for (int i = first; i < w->n_rows; i++) {
		const fw_rinex_row *row = &w->rows[i];
		int column = w->column[row->system][row->band][row->attribute];
		if (row->system != head->system || row->number != head->number)
			continue;
		const uint8_t seen = w->survey->seen[w->antenna][row->system][row->band][row->attribute];
		for (uint8_t k = 0; k < 4; k++) {
			if (!(seen >> k & 1))
				continue;
			if (row->has >> k & 1)
				of[column] = row;
			what[column++] = k;
		}
	}
	const int number = head->number;
	fw_rinex_out_text(&w->out, (char[]){fw_system_letter((fw_system)head->system),
	                                    (char)('0' + number / 10), (char)('0' + number % 10), '\0'});
	for (int i = 0; i < n; i++) {
		if (of[i] == NULL) {
			fw_rinex_out_column(&w->out, 3 + 16 * ((size_t)i + 1));
			continue;
		}
		const uint8_t lli = what[i] == CARRIER ? of[i]->lli : 0;
		fw_rinex_out_fixed(&w->out, of[i]->value[what[i]], 14, 3);
		fw_rinex_out_text(&w->out, (char[]){(char)(lli != 0 ? '0' + lli : ' '), ' ', '\0'});
	}
	fw_rinex_out_end_line(&w->out);
}

static bool is_first_of_satellite(const fw_rinex_obs_writer *w, int i)
{
	for (int k = 0; k < i; k++)
		if (w->rows[k].system == w->rows[i].system && w->rows[k].number == w->rows[i].number)
			return false;
	return true;
}

static void put_epoch(fw_rinex_obs_writer *w)
{
	int first[FW_RINEX_EPOCH_ROWS], n = 0;

	if (w->n_rows == 0)
		return;
	for (int i = 0; i < w->n_rows; i++)
		if (is_first_of_satellite(w, i))
			first[n++] = i;
	put_epoch_line(w, w->time, 0, n);
	for (int i = 0; i < n; i++)
		put_satellite(w, first[i]);
	w->n_rows = 0;
	w->epochs++;
}

/* Loss of lock since the signal's last observation, and the half cycle. */
static uint8_t indicator(fw_rinex_obs_writer *w, const fw_rinex_row *row, const furrow_obs *o)
{
	typeof(w->last[0][0][0][0]) *last = &w->last[row->system][row->number][row->band][row->attribute];
	const double since_s = last->ns != 0 ? (double)(w->time.ns - last->ns) / 1e9 : 0;
	bool lost = false;

	if (has(o->present, FW_COL_obs_lock_s)) {
		lost = o->lock_s == 0 ||
		       (last->ns != 0 && (o->lock_s < last->lock_s || o->lock_s + 1 < since_s));
		last->lock_s = o->lock_s;
	}
	last->ns = w->time.ns;
	return (uint8_t)((lost ? LLI_LOST : 0) |
	                 (has(o->present, FW_COL_obs_half_cycle) && o->half_cycle != 0 ? LLI_HALF : 0));
}

static void put_obs(fw_rinex_obs_writer *w, const furrow_obs *o)
{
	fw_rinex_row row;
	fw_time t;

	if (antenna_of(o) != w->antenna)
		return;
	if (!name_row(o, &row) || fw_record_time(o, &t) != FW_OK ||
	    (w->survey->seen[w->antenna][row.system][row.band][row.attribute] & row.has) != row.has) {
		w->refused++;
		return;
	}
	if (w->n_rows > 0 && t.ns != w->time.ns)
		put_epoch(w);
	if (w->n_rows == FW_RINEX_EPOCH_ROWS) {
		w->refused++;
		return;
	}
	w->time = t;
	if (row.has >> CARRIER & 1)
		row.lli = indicator(w, &row, o);
	w->rows[w->n_rows++] = row;
}

void fw_rinex_obs_put(void *writer, fw_kind kind, const void *record)
{
	fw_rinex_obs_writer *w = writer;
	fw_time t;

	if (kind == FW_obs)
		put_obs(w, record);
	if (kind != FW_event || fw_record_time(record, &t) != FW_OK)
		return;
	put_epoch(w);
	put_epoch_line(w, t, 5, 0);
}

fw_status fw_rinex_obs_end(fw_rinex_obs_writer *w)
{
	put_epoch(w);
	return fw_rinex_out_flush(&w->out);
}
