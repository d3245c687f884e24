#include "formats/rinex_obs.h"

#include <endian.h>
#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "formats/number.h"
#include "furrow_epoch.h"
#include "furrow_epoch_columns.h"
#include "furrow_event.h"
#include "furrow_event_columns.h"
#include "furrow_obs.h"
#include "furrow_obs_columns.h"
#include "furrow_setup.h"
#include "furrow_setup_columns.h"

#define BIT(column) (INT64_C(1) << (column))

enum { CODE, CARRIER, DOPPLER, CN0 }; /* fw_rinex_signal.index */

enum { LLI_LOST = 1, LLI_HALF = 2 }; /* RINEX 3.05, table A3, note on LLI */

enum { FIELD = 16, NUMBER = 14 }; /* columns of an observable, and of its number: F14.3, I1, I1 */

/* ---- lines ---- */

static fw_status next_line(fw_rinex_obs *r)
{
	if (r->held) {
		r->held = false;
		return FW_OK;
	}
	if (!r->is_compact)
		return fw_lines_next(&r->lines, &r->line);
	const fw_status status = fw_hatanaka_next(&r->compact, &r->line);
	if (status == FW_ESYNTAX || status == FW_EUNKNOWN) { /* the next line is that of a new epoch */
		r->problem = r->compact.problem;
		r->lost++;
		r->in_epoch = false;
		r->satellite = NULL;
	}
	return status;
}

static fw_status complain(fw_rinex_obs *r, const char *reason)
{
	r->problem = (fw_rinex_problem){r->line.number, reason};
	r->lost++;
	return FW_ESYNTAX;
}

static bool label_is(const fw_rinex_obs *r, const char *label)
{
	const size_t n = strlen(label);
	return r->line.n >= FW_RINEX_LABEL + n && memcmp(r->line.text + FW_RINEX_LABEL, label, n) == 0;
}

/* ---- observables to signals ---- */

/* Attribute of RINEX 2's code C or P of a band; '\0': there is none. Column: band. */
static const char attribute_c[FW_SYSTEM_COUNT][10] = {
    [FW_GPS] = "\0CX\0\0X",        [FW_GALILEO] = "\0X\0\0\0XXXX", [FW_BEIDOU] = "\0II\0\0XII",
    [FW_GLONASS] = "\0CC\0\0\0\0", [FW_QZSS] = "\0CX\0\0XX",       [FW_NAVIC] = "\0\0\0\0\0A",
    [FW_SBAS] = "\0C\0\0\0I",
};
static const char attribute_p[FW_SYSTEM_COUNT][10] = {[FW_GPS] = "\0WW", [FW_GLONASS] = "\0PP"};

static bool is_listed(const fw_rinex_obs *r, fw_system system, char letter, char band)
{
	for (int i = 0; i < r->n_types[system]; i++)
		if (r->types[system][i][0] == letter && r->types[system][i][1] == band)
			return true;
	return false;
}

/* The signal of a version 2 observable. */
static void name_of_2(const fw_rinex_obs *r, fw_system system, const char *type, char name[3])
{
	const int band = type[1] - '0';
	const char c = attribute_c[system][band], p = attribute_p[system][band];
	bool is_p = type[0] == 'P';

	if (type[0] != 'C' && type[0] != 'P' && p != '\0')
		is_p = band == 1 ? !is_listed(r, system, 'C', '1') && is_listed(r, system, 'P', '1')
		                 : is_listed(r, system, 'P', type[1]) || !is_listed(r, system, 'C', type[1]);
	name[0] = system == FW_BEIDOU && band == 1 ? '2' : type[1];
	name[1] = is_p ? p : c;
}

/* What an observable is, and of which signal. Returns -1 when furrow has no column for it. */
static int classify(const fw_rinex_obs *r, fw_system system, const char *type, char name[3])
{
	static const char letters[] = "CLDS";
	const char *letter = memchr(letters, type[0] == 'P' && r->header.version < 300 ? 'C' : type[0], 4);

	name[2] = '\0';
	if (letter == NULL || type[1] < '1' || type[1] > '9')
		return -1;
	if (r->header.version < 300) {
		name_of_2(r, system, type, name);
	} else {
		name[0] = type[1];
		name[1] = type[2];
		if (r->header.version == 302 && system == FW_BEIDOU && name[0] == '1')
			name[0] = '2';
	}
	return name[1] >= 'A' && name[1] <= 'Z' ? (int)(letter - letters) : -1;
}

static fw_rinex_signal *find_signal(fw_rinex_obs *r, fw_system system, const char *name)
{
	int n = r->n_signals[system];
	fw_rinex_signal *s = r->signals[system];

	for (int i = 0; i < n; i++, s++)
		if (memcmp(s->name, name, 2) == 0)
			return s;
	*s = (fw_rinex_signal){{name[0], name[1], '\0'}, {-1, -1, -1, -1}};
	r->n_signals[system]++;
	return s;
}

static void list_signals(fw_rinex_obs *r, fw_system system)
{
	char name[3];

	r->n_signals[system] = 0;
	for (int i = 0; i < r->n_types[system]; i++) {
		const int what = classify(r, system, r->types[system][i], name);
		fw_rinex_signal *s = what >= 0 ? find_signal(r, system, name) : NULL;
		if (s != NULL && s->index[what] < 0)
			s->index[what] = (int16_t)i;
		else
			r->passed_over++;
	}
}

/* The lists of observables are as they should be, for now. */
static fw_status end_lists(fw_rinex_obs *r)
{
	r->passed_over = 0;
	for (int system = 0; system < FW_SYSTEM_COUNT; system++)
		list_signals(r, (fw_system)system);
	if (r->list_left <= 0)
		return FW_OK;
	r->list_left = 0;
	return complain(r, "a list of observables is shorter than it says");
}

/* ---- header ---- */

static void forget_header(fw_rinex_obs *r)
{
	memset(&r->header, 0, sizeof r->header);
	r->header.leap_s = -1;
	memset(r->header.glonass_channel, INT8_MIN, sizeof r->header.glonass_channel);
	memset(r->n_types, 0, sizeof r->n_types);
	memset(r->n_signals, 0, sizeof r->n_signals);
	memset(r->half_wavelength, 0, sizeof r->half_wavelength);
	r->list_of = r->list_left = 0;
	r->has_header = false;
}

static void get_text(const fw_rinex_obs *r, size_t from, size_t n, char *text, size_t room)
{
	fw_rinex_text(&r->line, from, n, text, room);
}

/* The numbers of a line, `width` columns each. */
static bool get_doubles(const fw_rinex_obs *r, int n, size_t width, double *x)
{
	for (int i = 0; i < n; i++)
		if (fw_rinex_double(&r->line, (size_t)i * width, width, &x[i]) != FW_OK)
			return false;
	return true;
}

static fw_status version_line(fw_rinex_obs *r)
{
	static const struct {
		char system;
		fw_rinex_time time;
	} own[] = {{'R', FW_RINEX_GLO},
	           {'E', FW_RINEX_GAL},
	           {'C', FW_RINEX_BDT},
	           {'J', FW_RINEX_QZS},
	           {'I', FW_RINEX_IRN}};
	double version = 0;

	if (fw_rinex_double(&r->line, 0, 9, &version) != FW_OK || !(version >= 2 && version < 5) ||
	    r->line.text[20] != 'O') {
		(void)!complain(r, "no RINEX observation file of version 2, 3 or 4");
		return FW_EUNKNOWN;
	}
	r->header.version = (int)lround(version * 100);
	r->header.system = r->line.text[40] == ' ' ? 'G' : r->line.text[40];
	r->header.time_system = FW_RINEX_GPS;
	for (size_t i = 0; i < sizeof own / sizeof *own; i++)
		if (own[i].system == r->header.system)
			r->header.time_system = own[i].time;
	return FW_OK;
}

/* One line of a list of observables: `n` of them on it, every `step` columns. */
static void take_types(fw_rinex_obs *r, size_t from, size_t step, int n)
{
	const fw_system system = (fw_system)r->list_of;

	for (int i = 0; i < n && r->list_left > 0; i++, r->list_left--) {
		char type[4];
		get_text(r, from + (size_t)i * step, 3, type, sizeof type);
		if (r->n_types[system] == FW_RINEX_TYPES) {
			r->passed_over++;
			continue;
		}
		memcpy(r->types[system][r->n_types[system]], type, sizeof type);
		r->scale[system][r->n_types[system]++] = 1;
	}
}

static fw_status types_line(fw_rinex_obs *r)
{
	if (r->line.text[0] != ' ') {
		const fw_system system = fw_system_of_letter(r->line.text[0]);
		if (system == FW_SYSTEM_COUNT) {
			r->list_left = 0;
			return complain(r, "a satellite system that is not known");
		}
		r->list_of = (int)system;
		r->n_types[system] = 0;
		if (fw_rinex_int(&r->line, 3, 3, &r->list_left) != FW_OK || r->list_left < 0) {
			r->list_left = 0;
			return complain(r, "damaged list of observables");
		}
	}
	take_types(r, 7, 4, 13);
	return FW_OK;
}

/* # / TYPES OF OBSERV: one list for all systems. */
static fw_status types_line_2(fw_rinex_obs *r)
{
	int n = 0;
	const fw_status status = fw_rinex_int(&r->line, 0, 6, &n);

	if (status == FW_OK && n >= 0) {
		r->list_of = FW_GPS;
		r->list_left = n;
		r->n_types[FW_GPS] = 0;
	} else if (status != FW_EOF) {
		r->list_left = 0;
		return complain(r, "damaged list of observables");
	}
	take_types(r, 10, 6, 9);
	for (int i = FW_GPS + 1; i < FW_SYSTEM_COUNT; i++) {
		r->n_types[i] = r->n_types[FW_GPS];
		memcpy(r->types[i], r->types[FW_GPS], sizeof r->types[i]);
		memcpy(r->scale[i], r->scale[FW_GPS], sizeof r->scale[i]);
	}
	return FW_OK;
}

/* SYS / SCALE FACTOR: the file's numbers are that many times the values; no list means all observables. */
static fw_status scale_line(fw_rinex_obs *r)
{
	const fw_system system = fw_system_of_letter(r->line.text[0]);
	int n = 0;
	double factor = 1;

	if (system == FW_SYSTEM_COUNT || fw_rinex_double(&r->line, 2, 4, &factor) != FW_OK ||
	    !(factor >= 1) || fw_rinex_int(&r->line, 8, 2, &n) < 0 || n > 12)
		return complain(r, "a scale factor that is not understood");
	for (int i = 0; i < r->n_types[system]; i++) {
		bool meant = n <= 0;
		for (int k = 0; k < n; k++) {
			char type[4];
			get_text(r, 11 + 4 * (size_t)k, 3, type, sizeof type);
			meant |= strcmp(type, r->types[system][i]) == 0;
		}
		if (meant)
			r->scale[system][i] = factor;
	}
	return FW_OK;
}

static fw_status slots_line(fw_rinex_obs *r)
{
	for (size_t at = 4; at + 6 <= FW_RINEX_LABEL && at + 6 <= r->line.n; at += 7) {
		int slot = 0, k = 0;
		if (r->line.text[at] != 'R')
			continue;
		if (fw_rinex_int(&r->line, at + 1, 2, &slot) != FW_OK ||
		    fw_rinex_int(&r->line, at + 4, 2, &k) != FW_OK || slot < 1 ||
		    slot >= FW_SATELLITES_PER_SYSTEM || k < -7 || k > 6)
			return complain(r, "a GLONASS frequency number that is none");
		r->header.glonass_channel[slot] = (int8_t)k;
	}
	return FW_OK;
}

static fw_status time_line(fw_rinex_obs *r)
{
	char name[4];

	get_text(r, 48, 3, name, sizeof name);
	if (name[0] != '\0' && fw_rinex_time_system(name, &r->header.time_system) != FW_OK)
		return complain(r, "a time system that is not known");
	return FW_OK;
}

static fw_status position_line(fw_rinex_obs *r)
{
	double x[3];

	if (!get_doubles(r, 3, 14, x))
		return complain(r, "damaged position");
	r->header.has_position = x[0] != 0 || x[1] != 0 || x[2] != 0;
	memcpy(r->header.position_m, x, sizeof x);
	return FW_OK;
}

/* WAVELENGTH FACT L1/2, the one for all satellites: factor 2 stands for half cycles. */
static fw_status wavelength_line(fw_rinex_obs *r)
{
	int factor[2] = {1, 1}, n = 0;

	if (fw_rinex_int(&r->line, 12, 6, &n) == FW_OK && n > 0)
		return FW_OK;
	if (fw_rinex_int(&r->line, 0, 6, &factor[0]) < 0 || fw_rinex_int(&r->line, 6, 6, &factor[1]) < 0)
		return complain(r, "damaged wavelength factors");
	r->half_wavelength[0] = factor[0] == 2;
	r->half_wavelength[1] = factor[1] == 2;
	return FW_OK;
}

static fw_status interval_line(fw_rinex_obs *r)
{
	return fw_rinex_double(&r->line, 0, 10, &r->header.interval_s) < 0 ? complain(r, "damaged interval")
	                                                                   : FW_OK;
}

static fw_status antenna_delta_line(fw_rinex_obs *r)
{
	double x[3];

	if (!get_doubles(r, 3, 14, x))
		return complain(r, "damaged antenna offset");
	memcpy(r->header.antenna_hen_m, x, sizeof x);
	return FW_OK;
}

static fw_status shift_line(fw_rinex_obs *r)
{
	double shift = 0;

	r->header.phase_shifts += fw_rinex_double(&r->line, 6, 8, &shift) == FW_OK && shift != 0;
	return FW_OK;
}

static fw_status leap_line(fw_rinex_obs *r)
{
	return fw_rinex_int(&r->line, 0, 6, &r->header.leap_s) < 0 ? complain(r, "damaged leap seconds")
	                                                           : FW_OK;
}

static fw_status clock_line(fw_rinex_obs *r)
{
	int applied = 0;

	if (fw_rinex_int(&r->line, 0, 6, &applied) < 0)
		return complain(r, "damaged clock flag");
	r->header.clock_applied = applied != 0;
	return FW_OK;
}

static fw_status names_line(fw_rinex_obs *r)
{
	fw_rinex_header *h = &r->header;

	if (label_is(r, "MARKER NAME"))
		get_text(r, 0, 60, h->marker_name, sizeof h->marker_name);
	else if (label_is(r, "MARKER NUMBER"))
		get_text(r, 0, 20, h->marker_number, sizeof h->marker_number);
	else if (label_is(r, "MARKER TYPE"))
		get_text(r, 0, 20, h->marker_type, sizeof h->marker_type);
	else if (label_is(r, "OBSERVER / AGENCY")) {
		get_text(r, 0, 20, h->observer, sizeof h->observer);
		get_text(r, 20, 40, h->agency, sizeof h->agency);
	} else if (label_is(r, "REC # / TYPE / VERS")) {
		get_text(r, 0, 20, h->rx_serial, sizeof h->rx_serial);
		get_text(r, 20, 20, h->rx_name, sizeof h->rx_name);
		get_text(r, 40, 20, h->rx_version, sizeof h->rx_version);
	} else if (label_is(r, "ANT # / TYPE")) {
		get_text(r, 0, 20, h->ant_serial, sizeof h->ant_serial);
		get_text(r, 20, 20, h->ant_type, sizeof h->ant_type);
	}
	return FW_OK;
}

static const struct {
	const char *label;
	fw_status (*take)(fw_rinex_obs *r);
} header_lines[] = {
    {"SYS / # / OBS TYPES", types_line},
    {"# / TYPES OF OBSERV", types_line_2},
    {"SYS / SCALE FACTOR", scale_line},
    {"GLONASS SLOT / FRQ #", slots_line},
    {"TIME OF FIRST OBS", time_line},
    {"APPROX POSITION XYZ", position_line},
    {"ANTENNA: DELTA H/E/N", antenna_delta_line},
    {"INTERVAL", interval_line},
    {"WAVELENGTH FACT L1/2", wavelength_line},
    {"SYS / PHASE SHIFT", shift_line},
    {"LEAP SECONDS", leap_line},
    {"RCV CLOCK OFFS APPL", clock_line},
};

static fw_status header_line(fw_rinex_obs *r)
{
	for (size_t i = 0; i < sizeof header_lines / sizeof *header_lines; i++)
		if (label_is(r, header_lines[i].label))
			return header_lines[i].take(r);
	return names_line(r);
}

/* One more line of the header. FW_MORE: it has been taken. */
static fw_status read_header(fw_rinex_obs *r)
{
	fw_status status = next_line(r);

	if (status != FW_OK)
		return status == FW_EOF && r->header.version != 0 ? FW_ETRUNCATED : status;
	if (r->header.version == 0) {
		if (!label_is(r, "RINEX VERSION / TYPE")) {
			(void)!complain(r, "no RINEX header");
			return FW_EUNKNOWN;
		}
		status = version_line(r);
	} else if (label_is(r, "END OF HEADER")) {
		r->has_header = r->setup_due = true;
		status = end_lists(r);
	} else {
		status = header_line(r);
	}
	return status == FW_OK ? FW_MORE : status;
}

/* ---- epochs ---- */

/* Could it be an epoch's line? It need not be a sound one. */
static bool is_epoch(const fw_rinex_obs *r)
{
	const char *p = r->line.text;

	if (r->header.version >= 300)
		return r->line.n > 0 && p[0] == '>';
	/* " yy mm dd hh mm ss.sssssss  f nnn": numbers of observables have their points elsewhere. */
	return r->line.n > 28 && p[0] == ' ' && p[3] == ' ' && p[18] == '.' && p[10] != '.' && p[26] == ' ';
}

static bool get_civil(const fw_rinex_obs *r, fw_civil *c, int64_t *ns)
{
	const fw_line *l = &r->line;
	const size_t at = r->header.version >= 300 ? 2 : 1, year = r->header.version >= 300 ? 4 : 2,
	             next = at + year;

	*c = (fw_civil){0};
	if (fw_rinex_int(l, at, year, &c->year) != FW_OK || fw_rinex_int(l, next, 3, &c->month) != FW_OK ||
	    fw_rinex_int(l, next + 3, 3, &c->day) != FW_OK ||
	    fw_rinex_int(l, next + 6, 3, &c->hour) != FW_OK ||
	    fw_rinex_int(l, next + 9, 3, &c->minute) != FW_OK ||
	    fw_rinex_seconds(l, next + 12, 11, ns) != FW_OK)
		return false;
	c->second = (int)(*ns / FW_NS_PER_S);
	return true;
}

static bool get_time(fw_rinex_obs *r)
{
	fw_civil civil;
	fw_time t;
	int64_t ns;
	int32_t week;
	double tow_s;

	if (!get_civil(r, &civil, &ns) || fw_rinex_moment(&civil, r->header.time_system, &t) < 0)
		return false;
	t = fw_time_add_ns(t, ns % FW_NS_PER_S);
	fw_time_to_gps_s(t, &week, &tow_s);
	r->stamp = (fw_record_head){BIT(FW_COL_obs_gps_week) | BIT(FW_COL_obs_tow_s), week, tow_s};
	return true;
}

/* Version 2: the list of satellites, 12 on a line. */
static fw_status get_list(fw_rinex_obs *r)
{
	for (int i = 0; i < r->n_satellites; i++) {
		const size_t at = 32 + 3 * (size_t)(i % 12);
		if (i > 0 && i % 12 == 0) {
			const fw_status status = next_line(r);
			if (status != FW_OK)
				return status == FW_EOF ? FW_ETRUNCATED : status;
			if (is_epoch(r)) {
				r->held = true;
				return complain(r, "the list of satellites ends too early");
			}
		}
		if (r->line.n < at + 3) {
			r->searching = true;
			return complain(r, "the list of satellites ends too early");
		}
		memcpy(r->list[i], r->line.text + at, 3);
	}
	return FW_OK;
}

/* Event flags 2 to 5: header lines follow. */
static fw_status read_event(fw_rinex_obs *r, char flag, int n, fw_kind *kind, fw_any_record *record)
{
	const bool is_event = flag == '5' && get_time(r);
	fw_status status = FW_OK, worst = FW_OK;

	for (; n > 0 && status == FW_OK; n--) {
		status = next_line(r);
		if (status == FW_OK && is_epoch(r)) {
			r->held = true;
			break;
		}
		if (status == FW_OK && header_line(r) != FW_OK)
			worst = FW_ESYNTAX;
	}
	if (status != FW_OK)
		return status == FW_EOF ? FW_ETRUNCATED : status;
	if (end_lists(r) != FW_OK)
		worst = FW_ESYNTAX;
	if (worst != FW_OK || !is_event)
		return worst != FW_OK ? worst : FW_MORE;
	furrow_event *event = (furrow_event *)(void *)record;
	fw_record_clear(FW_event, event);
	memcpy(event, &r->stamp, sizeof r->stamp);
	*kind = FW_event;
	return FW_OK;
}

/* An epoch's line, or whatever stands in its place. FW_MORE: it has been taken. */
static fw_status read_epoch(fw_rinex_obs *r, fw_kind *kind, fw_any_record *record)
{
	const size_t at = r->header.version >= 300 ? 31 : 28;
	int n = 0;
	char flag;
	fw_status status = next_line(r);

	if (status != FW_OK)
		return status;
	if (label_is(r, "RINEX VERSION / TYPE")) { /* another file behind the first */
		forget_header(r);
		r->held = true;
		return FW_MORE;
	}
	if (!is_epoch(r)) {
		if (r->searching || r->line.n == 0)
			return FW_MORE;
		r->searching = true;
		return complain(r, "no epoch line where one should be; what follows is lost up to the next");
	}
	if (!r->line.whole) /* nothing can follow, and its own numbers may be cut short */
		return FW_ETRUNCATED;
	r->searching = false;
	flag = r->line.n > at ? r->line.text[at] : '\0';
	if (flag < ' ' || (flag > ' ' && flag < '0') || flag > '6' ||
	    fw_rinex_int(&r->line, at + 1, 3, &n) < 0 || n < 0) {
		r->searching = true;
		return complain(r, "damaged epoch line, epoch lost");
	}
	if (flag >= '2' && flag <= '5')
		return read_event(r, flag, n, kind, record);
	r->cycle_slips = flag == '6';
	if (!get_time(r) && !r->cycle_slips) {
		r->searching = true;
		return complain(r, "damaged time of an epoch, epoch lost");
	}
	r->n_satellites = n;
	if (r->header.version < 300 && (status = get_list(r)) != FW_OK)
		return status;
	r->in_epoch = true;
	r->power_failed = flag == '1';
	r->next_satellite = r->n_measured = 0;
	return FW_MORE;
}

/* ---- numbers ---- */

/* A number that is not as it should be: anywhere in its columns, with any decimals. Returns false when it is
 * none; without a point it is none, since F14.3 has it mean thousandths. */
static bool get_slowly(const char *p, double *x)
{
	static const char blanks[NUMBER + 1] = "              ";
	const char *end = p + NUMBER;

	*x = 0;
	if (memcmp(p, blanks, NUMBER) == 0) /* most of those without a point in their place */
		return true;
	while (p < end && *p == ' ')
		p++;
	while (p < end && end[-1] == ' ')
		end--;
	return memchr(p, '.', (size_t)(end - p)) != NULL && fw_get_double(p, (size_t)(end - p), x) == FW_OK;
}

/* Eight characters as one number, the first in its lowest byte. */
static inline uint64_t load_8(const char *p)
{
	uint64_t x;
	memcpy(&x, p, sizeof x);
	return le64toh(x);
}

static inline bool are_digits(uint64_t x)
{
	const uint64_t high = 0xF0F0F0F0F0F0F0F0, zeros = 0x3030303030303030, to_ten = 0x0606060606060606;
	return (x & high) == zeros && ((x + to_ten) & high) == zeros;
}

/* The number of eight digits: neighbours are made pairs, pairs fours, fours eight. Source: D. Lemire, "Number parsing at a
 * gigabyte per second", Software: Practice and Experience 51 (2021). */
static inline uint64_t value_of_8(uint64_t x)
{
	const uint64_t mask = 0x000000FF000000FF;
	x -= 0x3030303030303030;
	x = x * 10 + (x >> 8);
	return ((x & mask) * (100 + (UINT64_C(1000000) << 32)) +
	        (x >> 16 & mask) * (1 + (UINT64_C(10000) << 32))) >>
	       32;
}

/* A point and three digits: these in thousandths; anything from 1000 on when it is something else. */
static inline uint64_t get_decimals(const char *p)
{
	uint32_t x;
	memcpy(&x, p, sizeof x);
	x = le32toh(x) ^ 0x3030302E;
	if ((x & 0xF0F0F0FF) != 0 || ((x + 0x06060600) & 0xF0F0F000) != 0)
		return 1000;
	return 10 * (10 * (x >> 8 & 15) + (x >> 16 & 15)) + (x >> 24);
}

/* What most numbers look like, the 14 columns at p: blanks, a sign, up to nine digits, a point, three digits. Columns 2 to 9
 * are done at once. What they begin with, blanks and a sign, differs from digits in bit 4. Returns false when it is
 * something else. */
static inline bool get_quickly(const char *p, double *x)
{
	const uint64_t blanks = 0x2020202020202020, zeros = 0x3030303030303030,
	               digit_bits = 0x1010101010101010;
	uint64_t whole = load_8(p + 2);
	const unsigned lead =
	    (unsigned)__builtin_ctzll((whole & digit_bits) | UINT64_C(1) << 63) & ~7U; /* bits */
	const uint64_t in_lead = (UINT64_C(1) << lead) - 1;
	const uint64_t sign = (whole ^ blanks) & in_lead;
	whole = (whole & ~in_lead) | (zeros & in_lead);
	const uint64_t value = value_of_8(whole), decimals = get_decimals(p + 10);
	if (!are_digits(whole) || decimals >= 1000 || p[0] != ' ')
		return false;

	uint64_t front = 0;
	bool negative = sign != 0;
	if (negative && sign << 8 != (uint64_t)('-' ^ ' ') << lead)
		return false;
	if (p[1] != ' ') {
		negative = p[1] == '-';
		front = negative ? 0 : (uint64_t)((unsigned)p[1] - '0');
		if (lead > 0 || front > 9)
			return false;
	}
	const int64_t thousandths = (int64_t)((front * 100000000 + value) * 1000 + decimals);
	*x = (double)(negative ? -thousandths : thousandths) / 1000;
	return true;
}

/* The 14 columns of a number; blanks are 0. */
static inline bool get_number(const char *p, double *x)
{
	return get_quickly(p, x) || get_slowly(p, x);
}

/* A number that the line ends in: only blanks will do. */
static bool is_blank(const char *p, size_t n)
{
	for (size_t i = 0; i < n; i++)
		if (p[i] != ' ')
			return false;
	return true;
}

/* Observables first .. first + n - 1 of the satellite, from a column of the line on. False when one is
 * damaged. */
static bool get_fields(fw_rinex_obs *r, int first, int n, size_t from)
{
	const char *p = r->line.text + from, *end = r->line.text + r->line.n;
	const double *scale = r->scale[r->system];
	const char(*types)[4] = (const char(*)[4])r->types[r->system];
	int i = first;

	for (; i < first + n && end - p >= NUMBER; i++, p += FIELD) {
		double x;
		if (r->no_carriers && types[i][0] == 'L') {
			r->values[i] = 0;
			r->lli[i] = 0;
			continue;
		}
		if (!get_number(p, &x))
			return false;
		r->values[i] = scale[i] == 1 ? x : x / scale[i];
		r->lli[i] =
		    end - p > NUMBER && p[NUMBER] >= '0' && p[NUMBER] <= '9' ? (uint8_t)(p[NUMBER] - '0') : 0;
	}
	if (i < first + n && end > p && !is_blank(p, (size_t)(end - p)))
		return false;
	for (; i < first + n; i++) {
		r->values[i] = 0;
		r->lli[i] = 0;
	}
	return true;
}

/* ---- satellites ---- */

static bool name_satellite(fw_rinex_obs *r, const char *name)
{
	const char letter = name[0] == ' ' ? 'G' : name[0];
	const unsigned ten = name[1] == ' ' ? 0 : (unsigned)name[1] - '0', one = (unsigned)name[2] - '0';

	if (ten > 9 || one > 9)
		return false;
	r->number = (int)(10 * ten + one);
	r->satellite = fw_rinex_satellite(letter, r->number);
	r->system = fw_system_of_letter(letter);
	return r->satellite != NULL;
}

static fw_status give_up_epoch(fw_rinex_obs *r, const char *reason)
{
	r->in_epoch = false;
	r->satellite = NULL;
	r->held = true;
	return complain(r, reason);
}

/* The line of a satellite, version 3 and 4. */
static fw_status read_satellite(fw_rinex_obs *r)
{
	const fw_status status = next_line(r);

	if (status != FW_OK)
		return status;
	if (is_epoch(r))
		return give_up_epoch(r, "the epoch before ends too early");
	r->next_satellite++;
	if (r->line.n < 3 || !name_satellite(r, r->line.text)) {
		r->satellite = NULL;
		return complain(r, "no satellite has this name, line lost");
	}
	if (r->cycle_slips || (r->n_types[r->system] > 0 && get_fields(r, 0, r->n_types[r->system], 3)))
		return FW_OK;
	r->satellite = NULL;
	return complain(r, r->n_types[r->system] > 0
	                       ? "damaged number, satellite lost"
	                       : "the header lists no observables of this system, satellite lost");
}

/* The lines of a satellite, version 2: five observables on each. */
static fw_status read_satellite_2(fw_rinex_obs *r)
{
	const bool is_named = name_satellite(r, r->list[r->next_satellite]);
	const char *satellite = r->satellite;
	const int n = r->n_types[FW_GPS];
	bool sound = true;

	r->satellite = NULL;
	if (!is_named)
		r->system = FW_GPS; /* its lines are there all the same */
	for (int i = 0; i < n; i += 5) {
		const fw_status status = next_line(r);
		if (status != FW_OK)
			return status;
		if (is_epoch(r))
			return give_up_epoch(r, "the epoch before ends too early");
		sound &= r->cycle_slips || get_fields(r, i, n - i < 5 ? n - i : 5, 0);
	}
	r->next_satellite++;
	if (!is_named)
		return complain(r, "no satellite has this name, satellite lost");
	if (!sound)
		return complain(r, "damaged number, satellite lost");
	r->satellite = satellite;
	return FW_OK;
}

/* Fills in what there is of a signal. Returns false when there is nothing. */
static bool put_signal(fw_rinex_obs *r, const fw_rinex_signal *s, furrow_obs *o)
{
	static const int64_t bits[4] = {BIT(FW_COL_obs_pseudorange_m), BIT(FW_COL_obs_carrier_cyc),
	                                BIT(FW_COL_obs_doppler_hz), BIT(FW_COL_obs_cn0_dbhz)};
	double values[4];
	int64_t present = 0;

	for (int i = 0; i < 4; i++) {
		values[i] = s->index[i] >= 0 ? r->values[s->index[i]] : 0;
		present |= values[i] != 0 ? bits[i] : 0;
	}
	if (present == 0)
		return false;
	*o = (furrow_obs){
	    .present = present | r->stamp.present | BIT(FW_COL_obs_sat) | BIT(FW_COL_obs_signal) |
	               BIT(FW_COL_obs_antenna),
	    .gps_week = r->stamp.gps_week,
	    .tow_s = r->stamp.tow_s,
	    .sat = (char *)(uintptr_t)r->satellite,
	    .signal = (char *)(uintptr_t)s->name,
	    .pseudorange_m = values[CODE],
	    .carrier_cyc = values[CARRIER],
	    .doppler_hz = values[DOPPLER],
	    .cn0_dbhz = values[CN0],
	};
	return true;
}

/* What the loss-of-lock indicator says of a carrier. */
static void put_lli(const fw_rinex_obs *r, const fw_rinex_signal *s, furrow_obs *o)
{
	const unsigned lli = r->lli[s->index[CARRIER]];
	const bool half = s->name[0] <= '2' && r->half_wavelength[s->name[0] - '1'];

	o->half_cycle = half != ((lli & LLI_HALF) != 0);
	o->present |= BIT(FW_COL_obs_half_cycle);
	if ((lli & LLI_LOST) || r->power_failed)
		o->present |= BIT(FW_COL_obs_lock_s); /* 0 */
}

/* The next signal of the satellite at hand; false when there are no more. */
static bool next_signal(fw_rinex_obs *r, furrow_obs *o)
{
	while (r->next_signal < r->n_signals[r->system]) {
		const fw_rinex_signal *s = &r->signals[r->system][r->next_signal++];
		if (!put_signal(r, s, o))
			continue;
		if (o->present & BIT(FW_COL_obs_carrier_cyc))
			put_lli(r, s, o);
		if (r->system == FW_GLONASS && r->header.glonass_channel[r->number] != INT8_MIN) {
			o->glonass_channel = r->header.glonass_channel[r->number];
			o->present |= BIT(FW_COL_obs_glonass_channel);
		}
		r->n_measured++;
		return true;
	}
	return false;
}

/* ---- records ---- */

static void put_epoch(fw_rinex_obs *r, furrow_epoch *epoch)
{
	*epoch =
	    (furrow_epoch){.present = r->stamp.present | BIT(FW_COL_epoch_n_signals),
	                   .gps_week = r->stamp.gps_week,
	                   .tow_s = r->stamp.tow_s,
	                   .n_signals = (int16_t)(r->n_measured < INT16_MAX ? r->n_measured : INT16_MAX)};
	r->epochs++;
}

static void put_text(furrow_setup *s, int column, char **member, char *text)
{
	if (text[0] == '\0')
		return;
	*member = text;
	s->present |= BIT(column);
}

/* 1 degree is pi / 180 rad. */
#define DEG_PER_RAD 57.295779513082320877

static void put_position(const fw_rinex_header *h, furrow_setup *s)
{
	double llh[3];

	if (!h->has_position || fw_ecef_to_llh(h->position_m, llh) != FW_OK)
		return;
	s->lat_deg = llh[0] * DEG_PER_RAD;
	s->lon_deg = llh[1] * DEG_PER_RAD;
	s->height_m = (float)llh[2];
	s->present |= BIT(FW_COL_setup_lat_deg) | BIT(FW_COL_setup_lon_deg) | BIT(FW_COL_setup_height_m);
}

static void put_setup(fw_rinex_obs *r, furrow_setup *s)
{
	fw_rinex_header *h = &r->header;

	fw_record_clear(FW_setup, s);
	memcpy(s, &r->stamp, sizeof r->stamp);
	put_text(s, FW_COL_setup_marker_name, &s->marker_name, h->marker_name);
	put_text(s, FW_COL_setup_marker_number, &s->marker_number, h->marker_number);
	put_text(s, FW_COL_setup_marker_type, &s->marker_type, h->marker_type);
	put_text(s, FW_COL_setup_observer, &s->observer, h->observer);
	put_text(s, FW_COL_setup_agency, &s->agency, h->agency);
	put_text(s, FW_COL_setup_rx_serial, &s->rx_serial, h->rx_serial);
	put_text(s, FW_COL_setup_rx_name, &s->rx_name, h->rx_name);
	put_text(s, FW_COL_setup_rx_version, &s->rx_version, h->rx_version);
	put_text(s, FW_COL_setup_ant_serial, &s->ant_serial, h->ant_serial);
	put_text(s, FW_COL_setup_ant_type, &s->ant_type, h->ant_type);
	s->delta_h_m = (float)h->antenna_hen_m[0];
	s->delta_e_m = (float)h->antenna_hen_m[1];
	s->delta_n_m = (float)h->antenna_hen_m[2];
	s->present |= BIT(FW_COL_setup_delta_h_m) | BIT(FW_COL_setup_delta_e_m) | BIT(FW_COL_setup_delta_n_m);
	put_position(h, s);
}

/* One step inside an epoch. FW_MORE: nothing to hand out yet. */
static fw_status step_epoch(fw_rinex_obs *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status;

	if (r->setup_due && !r->cycle_slips) {
		r->setup_due = false;
		put_setup(r, (furrow_setup *)(void *)record);
		*kind = FW_setup;
		return FW_OK;
	}
	if (r->satellite != NULL && !r->cycle_slips && next_signal(r, (furrow_obs *)(void *)record)) {
		*kind = FW_obs;
		return FW_OK;
	}
	r->satellite = NULL;
	if (r->next_satellite < r->n_satellites) {
		r->next_signal = 0;
		status = r->header.version >= 300 ? read_satellite(r) : read_satellite_2(r);
		return status == FW_OK ? FW_MORE : status == FW_EOF ? FW_ETRUNCATED : status;
	}
	r->in_epoch = false;
	if (r->cycle_slips)
		return FW_MORE;
	put_epoch(r, (furrow_epoch *)(void *)record);
	*kind = FW_epoch;
	return FW_OK;
}

void fw_rinex_obs_begin(fw_rinex_obs *r, fw_input *input)
{
	const uint8_t *head;
	size_t n = 0;

	memset(r, 0, offsetof(fw_rinex_obs, lines));
	forget_header(r);
	r->problem.reason = "";
	r->held = r->setup_due = r->searching = r->in_epoch = false;
	r->satellite = NULL;
	r->final = fw_input_peek(input, 80, &head, &n);
	r->is_compact = r->final == FW_OK && n > FW_RINEX_LABEL && head[FW_RINEX_LABEL] == 'C';
	fw_lines_begin(&r->lines, input);
	if (r->is_compact)
		fw_hatanaka_begin(&r->compact, &r->lines);
}

fw_status fw_rinex_obs_read(fw_rinex_obs *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status = FW_MORE;

	while (r->final == FW_OK && status == FW_MORE)
		status = !r->has_header ? read_header(r)
		         : r->in_epoch  ? step_epoch(r, kind, record)
		                        : read_epoch(r, kind, record);
	if (r->final == FW_OK && status != FW_OK && status != FW_ESYNTAX)
		r->final = status;
	return r->final != FW_OK ? r->final : status;
}
