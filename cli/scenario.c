#include "scenario.h"

#include <errno.h>
#include <ini.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/frame.h"
#include "furrow_nav.h"
#include "furrow_nav_columns.h"
#include "scenario_keys.h"
#include "source.h"

/* ---- settings ---- */

/* Where a setting comes from, for messages, and whether there was one already. */
typedef struct {
	scenario *s;
	const tool *t;
	const char *file; /* NULL: --set */
	int line, reported;
	FILE *from;
	bool overlong;
} reader;

static __attribute__((format(printf, 2, 3))) void refuse(reader *r, const char *format, ...)
{
	char text[400];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	if (r->file == NULL)
		tool_error(r->t, "--set: %s", text);
	else
		tool_error(r->t, "%s:%d: %s", r->file, r->line, text);
	r->reported = 1;
}

static void set_section(const char *section, void *base)
{
	char why[200];
	for (int i = 0; i < scenario_n_keys; i++) {
		const scenario_key *key = &scenario_keys[i];
		if (strcmp(key->section, section) == 0 && key->fallback != NULL &&
		    !scenario_key_set(key, base, key->fallback, 0, why, sizeof why))
			abort(); /* the table contradicts itself */
	}
}

void scenario_defaults(scenario *s)
{
	*s = (scenario){.file = ""};
	for (int i = 0; i < scenario_n_keys; i++) {
		const char *section = scenario_keys[i].section;
		if ((i == 0 || strcmp(section, scenario_keys[i - 1].section) != 0) &&
		    strcmp(section, "mask") != 0 && strcmp(section, "fault") != 0)
			set_section(section, s);
	}
}

/* The mask of that name, a new one if there is none; NULL: there are too many. */
static void *mask_named(scenario *s, const char *name, int line)
{
	for (unsigned i = 0; i < s->n_masks; i++)
		if (strcmp(s->mask[i].name, name) == 0)
			return &s->mask[i].mask;
	if (s->n_masks == FW_RECEIVER_MASKS)
		return NULL;
	scenario_mask *m = &s->mask[s->n_masks++];
	*m = (scenario_mask){.line = line};
	snprintf(m->name, sizeof m->name, "%s", name);
	set_section("mask", &m->mask);
	return &m->mask;
}

static void *fault_named(scenario *s, const char *name, int line)
{
	for (unsigned i = 0; i < s->n_faults; i++)
		if (strcmp(s->fault[i].name, name) == 0)
			return &s->fault[i].fault;
	if (s->n_faults == FW_RECEIVER_FAULTS)
		return NULL;
	scenario_fault *f = &s->fault[s->n_faults++];
	*f = (scenario_fault){.line = line};
	snprintf(f->name, sizeof f->name, "%s", name);
	set_section("fault", &f->fault);
	return &f->fault;
}

/* "mask tree-line" to "mask", and the struct that its keys belong to. NULL after a message. */
static void *place_of(reader *r, const char *heading, char section[static SCENARIO_NAME])
{
	const char *name = heading + strcspn(heading, " ");
	size_t length = (size_t)(name - heading);
	name += strspn(name, " ");
	snprintf(section, SCENARIO_NAME, "%.*s", (int)length, heading);
	bool mask = strcmp(section, "mask") == 0, fault = strcmp(section, "fault") == 0;
	if (!scenario_section_known(section) || length >= SCENARIO_NAME) {
		const char *near = scenario_section_near(section);
		refuse(r, "unknown section [%.60s]%s%s%s", heading, near != NULL ? "; did you mean [" : "",
		       near != NULL ? near : "", near != NULL ? "]?" : "");
	} else if ((mask || fault) != (name[0] != '\0') || strlen(name) >= SCENARIO_NAME) {
		refuse(r,
		       mask || fault ? "[%.60s] needs a name, as in [mask trees]" : "[%.60s] takes no name",
		       heading);
	} else {
		void *place = mask    ? mask_named(r->s, name, r->line)
		              : fault ? fault_named(r->s, name, r->line)
		                      : r->s;
		if (place == NULL)
			refuse(r, "[%.60s] is one too many", heading);
		return place;
	}
	return NULL;
}

static int set_key(reader *r, const char *heading, const char *name, const char *value)
{
	char section[SCENARIO_NAME], why[200];
	void *place = place_of(r, heading, section);
	if (place == NULL)
		return 0;
	const scenario_key *key = scenario_key_find(section, name);
	if (key == NULL) {
		const char *near = scenario_key_near(section, name);
		refuse(r, "[%s] has no key '%.60s'%s%s%s", section, name,
		       near != NULL ? "; did you mean '" : "", near != NULL ? near : "",
		       near != NULL ? "'?" : "");
		return 0;
	}
	if (!scenario_key_set(key, place, value, r->file != NULL ? r->line : 0, why, sizeof why)) {
		refuse(r, "%s: %s", name, why);
		return 0;
	}
	return 1;
}

int scenario_set(scenario *s, const tool *t, const char *assignment)
{
	reader r = {.s = s, .t = t};
	char heading[2 * SCENARIO_NAME], name[SCENARIO_NAME];
	const char *equals = strchr(assignment, '='), *dot = equals;
	while (dot > assignment && *dot != '.')
		dot--;
	size_t length = (size_t)(dot - assignment), rest = (size_t)(equals - dot);
	if (*dot != '.' || length >= sizeof heading || rest > sizeof name || rest < 2) {
		refuse(&r, "'%.80s' is not SECTION.KEY=VALUE", assignment);
		return EXIT_USAGE;
	}
	snprintf(heading, sizeof heading, "%.*s", (int)length, assignment);
	snprintf(name, sizeof name, "%.*s", (int)rest - 1, dot + 1);
	return set_key(&r, heading, name, equals + 1) ? EXIT_COMPLETE : EXIT_USAGE;
}

/* ---- the file ---- */

/* inih takes its lines from here, so that their numbers are known and none is split. */
static char *next_line(char *line, int room, void *context)
{
	reader *r = context;
	if (r->reported || fgets(line, room, r->from) == NULL)
		return NULL;
	r->line++;
	if (strlen(line) == (size_t)room - 1 && line[room - 2] != '\n') {
		r->overlong = true;
		refuse(r, "a line longer than %d characters", room - 2);
		return NULL;
	}
	return line;
}

static int take_key(void *context, const char *section, const char *name, const char *value)
{
	reader *r = context;
	if (section[0] == '\0') {
		refuse(r, "'%.60s' stands before any [section]", name);
		return 0;
	}
	return set_key(r, section, name, value);
}

int scenario_read(scenario *s, const tool *t, const char *file)
{
	reader r = {.s = s, .t = t, .file = file};
	s->file = file;
	r.from = fopen(file, "re");
	if (r.from == NULL) {
		tool_error(t, "%s: %s", file, strerror(errno));
		return EXIT_IO;
	}
	errno = 0;
	int bad = ini_parse_stream(next_line, &r, take_key, &r), error = ferror(r.from) ? errno : 0;
	fclose(r.from);
	if (error != 0 || bad < 0) {
		tool_error(t, "%s: %s", file, strerror(error != 0 ? error : ENOMEM));
		return EXIT_IO;
	}
	if (bad > 0 && !r.reported)
		tool_error(t, "%s:%d: not a section, key = value, or comment", file, bad);
	return bad > 0 || r.reported ? EXIT_USAGE : EXIT_COMPLETE;
}

void scenario_print(const scenario *s, FILE *to)
{
	const char *section = "";
	for (int i = 0; i < scenario_n_keys; i++) {
		const scenario_key *key = &scenario_keys[i];
		if (strcmp(key->section, "mask") == 0 || strcmp(key->section, "fault") == 0)
			continue;
		if (strcmp(section, key->section) != 0)
			fprintf(to, "%s[%s]\n", i > 0 ? "\n" : "", key->section);
		section = key->section;
		scenario_key_print(key, s, to);
	}
	for (unsigned m = 0; m < s->n_masks; m++) {
		fprintf(to, "\n[mask %s]\n", s->mask[m].name);
		for (int i = 0; i < scenario_n_keys; i++)
			if (strcmp(scenario_keys[i].section, "mask") == 0)
				scenario_key_print(&scenario_keys[i], &s->mask[m].mask, to);
	}
	for (unsigned m = 0; m < s->n_faults; m++) {
		fprintf(to, "\n[fault %s]\n", s->fault[m].name);
		for (int i = 0; i < scenario_n_keys; i++)
			if (strcmp(scenario_keys[i].section, "fault") == 0)
				scenario_key_print(&scenario_keys[i], &s->fault[m].fault, to);
	}
}

bool scenario_path(const scenario *s, const char *path, char full[static SCENARIO_TEXT + PATH_MAX])
{
	const char *slash = strrchr(s->file, '/');
	int folder = path[0] == '/' || slash == NULL ? 0 : (int)(slash - s->file) + 1;
	return snprintf(full, SCENARIO_TEXT + PATH_MAX, "%.*s%s", folder, s->file, path) <
	       SCENARIO_TEXT + PATH_MAX;
}

/* ---- what several keys say together ---- */

/* "G1C E5Q ..." to the receiver's table of signals. */
static bool set_signals(const scenario *s, const tool *t, fw_receiver_setup *setup)
{
	unsigned n[FW_SYSTEM_COUNT] = {0};
	for (const char *p = s->signals + strspn(s->signals, " ,"); *p != '\0'; p += strspn(p, " ,")) {
		size_t length = strcspn(p, " ,");
		fw_system system = fw_system_of_letter(p[0]);
		fw_tracked_signal signal;
		if (length != 3 || system == FW_SYSTEM_COUNT ||
		    fw_tracked_signal_named(system, (fw_signal){p[1], p[2]}, &signal) != FW_OK) {
			tool_error(t, "[gnss] signals: no signal '%.*s' is simulated; see gnss-sim(1)",
			           (int)length, p);
			return false;
		}
		if (n[system] == FW_RECEIVER_SIGNALS) {
			tool_error(t, "[gnss] signals: more than %d of a system", FW_RECEIVER_SIGNALS);
			return false;
		}
		setup->signal[system][n[system]++] = signal;
		p += length;
	}
	return true;
}

static bool set_sections(scenario *s, const tool *t)
{
	unsigned n = s->section[0].n;
	for (int k = 1; k < 4; k++) {
		if (s->section[k].n != n) {
			tool_error(t, "[pvt] horizontal_m2, vertical_m2, horizontal_m2ps2 and vertical_m2ps2 "
			              "must be lists "
			              "of the same length");
			return false;
		}
	}
	s->rover.pvt.n_sections = n;
	for (unsigned i = 0; i < n; i++) {
		double from = s->section_from_s + i * s->section_s;
		s->rover.pvt.section[i] = (fw_pvt_section){{from, from + s->section_s},
		                                           s->section[0].value[i],
		                                           s->section[1].value[i],
		                                           s->section[2].value[i],
		                                           s->section[3].value[i]};
	}
	return true;
}

static bool window_good(const scenario *s, const tool *t, fw_window w, const char *kind, const char *name,
                        int line)
{
	if (w.until_s > w.from_s)
		return true;
	if (line > 0)
		tool_error(t, "%s:%d: [%s %s] ends (until_s) before it begins (from_s)", s->file, line, kind,
		           name);
	else
		tool_error(t, "--set: [%s %s] ends (until_s) before it begins (from_s)", kind, name);
	return false;
}

static bool set_masks_and_faults(scenario *s, const tool *t)
{
	s->rover.n_masks = s->n_masks;
	s->rover.n_faults = s->n_faults;
	for (unsigned i = 0; i < s->n_masks; i++) {
		s->rover.mask[i] = s->mask[i].mask;
		if (!window_good(s, t, s->mask[i].mask.window, "mask", s->mask[i].name, s->mask[i].line))
			return false;
	}
	for (unsigned i = 0; i < s->n_faults; i++) {
		s->rover.fault[i] = s->fault[i].fault;
		if (!window_good(s, t, s->fault[i].fault.window, "fault", s->fault[i].name, s->fault[i].line))
			return false;
	}
	return true;
}

int scenario_complete(scenario *s, const tool *t, fw_receiver_setup *base)
{
	s->path.vehicle = (fw_vehicle)s->vehicle;
	s->rover.station = FW_STATION_ROVER;
	s->rover.pvt.sbas = s->pvt_mode == 1;
	memset(s->rover.signal, 0, sizeof s->rover.signal);
	if (!set_signals(s, t, &s->rover) || !set_sections(s, t) || !set_masks_and_faults(s, t))
		return EXIT_USAGE;
	memcpy(s->rover.origin_llh, s->path.origin_llh, sizeof s->rover.origin_llh);
	*base = s->rover;
	base->station = FW_STATION_BASE;
	base->noise.multipath_m = s->base_multipath_m;
	base->noise.slips_per_hour = 0;
	base->pvt.n_sections = 0;
	memset(base->baseline_b_m, 0, sizeof base->baseline_b_m);
	return EXIT_COMPLETE;
}

/* ---- the trajectory ---- */

static int complain_route(const scenario *s, const tool *t, int line, const char *what)
{
	if (line > 0)
		tool_error(t, "%s:%d: %s", s->file, line, what);
	else
		tool_error(t, "[trajectory] %s", what);
	return EXIT_USAGE;
}

/* One line of the route to waypoints. Returns NULL, or what is wrong with it. */
static const char *lay_out(const scenario *s, const scenario_route *r, int room, fw_waypoint *w, int *n)
{
	const double *v = r->value;
	double speed = r->n > 3 ? v[3] : 5, stay = r->n > 4 ? v[4] : 0;
	if (r->kind == ROUTE_ROWS) {
		fw_rows rows = {
		    v[0], v[1], v[2], fw_rad_from_deg(v[3]), v[4], v[5], (int)fmin(fmax(v[6], 0), 1e6),
		    v[7], v[8]};
		fw_status status = fw_route_rows(&rows, &s->path.limits, room, w, n);
		return status == FW_OK         ? NULL
		       : status == FW_ENOSPACE ? "more waypoints than there is room for"
		                               : "rows with a length, spacing, count or speed that is none";
	}
	if (room < 1)
		return "more waypoints than there is room for";
	*n = 1;
	*w = (fw_waypoint){v[0], v[1], v[2], speed, stay};
	double llh[3] = {fw_rad_from_deg(v[0]), fw_rad_from_deg(v[1]), v[2]};
	if (r->kind == ROUTE_PLACE && fw_waypoint_place(s->path.origin_llh, llh, w) < 0)
		return "a place that is none";
	return NULL;
}

static int from_waypoints(scenario *s, const tool *t, fw_trajectory *trajectory)
{
	static fw_waypoint w[FW_WAYPOINTS_MAX];
	static int line[FW_WAYPOINTS_MAX];
	int n = 0, bad = -1;
	for (unsigned i = 0; i < s->n_route; i++) {
		int more = 0;
		const char *wrong = lay_out(s, &s->route[i], FW_WAYPOINTS_MAX - n, &w[n], &more);
		if (wrong != NULL)
			return complain_route(s, t, s->route[i].line, wrong);
		for (int k = n; k < n + more; k++)
			line[k] = s->route[i].line;
		n += more;
	}
	if (n == 0)
		return complain_route(s, t, 0, "no waypoint, place, rows or table");
	fw_status status = fw_trajectory_from_waypoints(&s->path, n, w, trajectory, &bad);
	if (status >= 0)
		return EXIT_COMPLETE;
	if (status == FW_EINVAL && bad >= 0)
		return complain_route(
		    s, t, line[bad],
		    "no way to this waypoint: a turn without room, straight back, a speed or stay that is "
		    "none, or a vertical move of a vehicle that cannot");
	return complain_route(s, t, 0, "a limit or origin that is none");
}

/* ---- a trajectory from a table ---- */

typedef struct {
	fw_trajectory_row *row;
	int n, room;
	fw_time start;
	bool no_memory, incomplete;
} rows;

static bool has_all(int64_t present, int first, int last)
{
	int64_t wanted = ((INT64_C(1) << (last - first + 1)) - 1) << first;
	return (present & wanted) == wanted;
}

static void take_row(void *context, fw_kind kind, const void *record)
{
	rows *r = context;
	const furrow_nav *nav = record;
	fw_time t;
	if (kind != FW_nav || r->no_memory)
		return;
	if (fw_record_time(record, &t) < 0 ||
	    !has_all(nav->present, FW_COL_nav_lat_deg, FW_COL_nav_heading_deg)) {
		r->incomplete = true;
		return;
	}
	if (r->n == r->room) {
		r->room = r->room == 0 ? 4096 : 2 * r->room;
		fw_trajectory_row *more = realloc(r->row, (size_t)r->room * sizeof *more);
		if (more == NULL) {
			r->no_memory = true;
			return;
		}
		r->row = more;
	}
	if (r->n == 0)
		r->start = t;
	r->row[r->n++] =
	    (fw_trajectory_row){fw_time_diff_s(t, r->start),
	                        {fw_rad_from_deg(nav->lat_deg), fw_rad_from_deg(nav->lon_deg), nav->height_m},
	                        {nav->vn_mps, nav->ve_mps, nav->vd_mps},
	                        {fw_rad_from_deg(nav->roll_deg), fw_rad_from_deg(nav->pitch_deg),
	                         fw_rad_from_deg(nav->heading_deg)}};
}

static int through_table(scenario *s, const tool *t, const char *path, const rows *r,
                         fw_trajectory *trajectory)
{
	if (r->no_memory) {
		tool_error(t, "%s: %s", path, strerror(ENOMEM));
		return EXIT_IO;
	}
	if (r->n < 6 || r->incomplete) {
		tool_error(t, "%s: %s", path,
		           r->incomplete ? "a row lacks time, position, velocity or attitude"
		                         : "fewer than 6 rows");
		return EXIT_USAGE;
	}
	double last = r->row[r->n - 1].t_s,
	       spacing = s->table_spacing_s > 0 ? s->table_spacing_s : last / (r->n - 1);
	int n_knots = fw_spline_knots(0, last, spacing);
	fw_spline_knot *knots = n_knots > 0 ? calloc((size_t)n_knots, sizeof *knots) : NULL;
	fw_status status = knots == NULL
	                       ? FW_EINVAL
	                       : fw_trajectory_from_table(r->n, r->row, spacing, n_knots, knots, trajectory);
	if (status < 0) {
		free(knots);
		tool_error(t, "%s: no trajectory: %s", path,
		           status == FW_ESINGULAR ? "a gap in the rows" : fw_status_text(status));
		return EXIT_USAGE;
	}
	s->start = r->start;
	return EXIT_COMPLETE;
}

static int from_table(scenario *s, const tool *t, fw_trajectory *trajectory)
{
	char path[SCENARIO_TEXT + PATH_MAX];
	rows r = {0};
	source_plan plan = {.table = FW_nav, .progress = "never"};
	source_totals totals = {0};
	tool reader_of_table = *t;
	fw_kind_add(&plan.wanted, FW_nav);
	if (!scenario_path(s, s->table, path))
		return complain_route(s, t, 0, "table: the path is too long");
	int status = source_read(&reader_of_table, path, &plan, (fw_sink){take_row, &r}, &totals);
	if (status == EXIT_COMPLETE)
		status = through_table(s, t, path, &r, trajectory);
	free(r.row);
	return status == EXIT_PARTIAL ? EXIT_USAGE : status;
}

int scenario_trajectory(scenario *s, const tool *t, fw_trajectory *trajectory)
{
	int status = s->table[0] != '\0' ? from_table(s, t, trajectory) : from_waypoints(s, t, trajectory);
	if (status == EXIT_COMPLETE && s->duration_s == 0)
		s->duration_s = trajectory->last_s - trajectory->first_s;
	return status;
}
