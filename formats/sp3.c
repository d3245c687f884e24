#include "formats/sp3.h"

#include <math.h>
#include <string.h>

/** BIPM: TAI - GPST [s] */
enum { TAI_LEAD_S = 19 };

/** SP3-c, SP3-d: a clock that is not known is 999999.999999 microseconds */
#define NO_CLOCK_US 999999.0

void fw_sp3_begin(fw_sp3_reader *r, fw_input *input)
{
	fw_lines_begin(&r->lines, input);
	r->reason = "";
	r->begun = r->has_epoch = r->ended = r->tai = false;
	r->scale = FW_RINEX_GPS;
	r->overlong = 0;
}

static fw_status lost(fw_sp3_reader *r, const char *reason)
{
	r->reason = reason;
	return FW_ESYNTAX;
}

static fw_status unknown(fw_sp3_reader *r, const char *reason)
{
	r->reason = reason;
	return FW_EUNKNOWN;
}

/* "#cP2010  7  1 ...", the first line; "## ..." is the second. */
static fw_status take_version(fw_sp3_reader *r, const fw_line *line)
{
	const char version = line->n > 1 ? line->text[1] : ' ';

	if (version == '#')
		return FW_MORE;
	if (version < 'a' || version > 'd')
		return unknown(r, "a version of SP3 that is not known");
	r->begun = true;
	r->has_epoch = r->ended = r->tai = false;
	r->scale = FW_RINEX_GPS;
	return FW_MORE;
}

/* "%c G  cc GPS ccc ...": of the two such lines the first has the time scale. Files of version a have
 * none. */
static fw_status take_scale(fw_sp3_reader *r, const fw_line *line)
{
	char name[4];

	fw_rinex_text(line, 9, 3, name, sizeof name);
	if (strcmp(name, "ccc") == 0 || name[0] == '\0')
		return FW_MORE;
	r->tai = strcmp(name, "TAI") == 0;
	if (!r->tai && fw_rinex_time_system(name, &r->scale) < 0)
		return unknown(r, "a time scale that is not known");
	return FW_MORE;
}

/* "*  2010  7  1  0 15  0.00000000" */
static fw_status take_epoch(fw_sp3_reader *r, const fw_line *line)
{
	fw_civil c;
	int64_t ns;
	fw_time t;

	r->has_epoch = false;
	if (fw_rinex_int(line, 3, 4, &c.year) != FW_OK || fw_rinex_int(line, 7, 3, &c.month) != FW_OK ||
	    fw_rinex_int(line, 10, 3, &c.day) != FW_OK || fw_rinex_int(line, 13, 3, &c.hour) != FW_OK ||
	    fw_rinex_int(line, 16, 3, &c.minute) != FW_OK || fw_rinex_seconds(line, 19, 12, &ns) != FW_OK)
		return lost(r, "an epoch that is no date and time");
	c.second = (int)(ns / FW_NS_PER_S);
	c.nanosecond = (int)(ns % FW_NS_PER_S);
	if (fw_rinex_moment(&c, r->scale, &t) < 0)
		return lost(r, "an epoch with a date or time that does not exist");
	r->epoch = r->tai ? fw_time_add_ns(t, -TAI_LEAD_S * FW_NS_PER_S) : t;
	r->has_epoch = true;
	return FW_MORE;
}

static bool flag(const fw_line *line, size_t column, char letter)
{
	return line->n > column && line->text[column] == letter;
}

/* "PG02 -14889.160729  -5131.952946 -21416.801336    269.108429  7  6  8 110 EP  MP" */
static fw_status take_point(fw_sp3_reader *r, const fw_line *line, fw_sp3_point *point)
{
	fw_sp3_point p = {.time = r->epoch};
	char name[4] = {0};
	double clock_us;
	fw_status status;

	if (!r->has_epoch)
		return lost(r, "a position without an epoch");
	if (line->n < 4)
		return lost(r, "a line cut short");
	memcpy(name, line->text + 1, 3);
	if (name[0] == 'L') /* a low orbit */
		return FW_MORE;
	if (fw_satellite_parse(name, &p.satellite) < 0)
		return lost(r, "a satellite that is not known");
	for (size_t i = 0; i < 3; i++) {
		if (fw_rinex_double(line, 4 + 14 * i, 14, &p.position_m[i]) != FW_OK)
			return lost(r, "a position that is no number");
		p.position_m[i] *= 1000;
	}
	p.has_position = p.position_m[0] != 0 && p.position_m[1] != 0 && p.position_m[2] != 0;
	status = fw_rinex_double(line, 46, 14, &clock_us);
	if (status < 0)
		return lost(r, "a clock that is no number");
	p.has_clock = status == FW_OK && fabs(clock_us) < NO_CLOCK_US;
	p.clock_s = p.has_clock ? clock_us * 1e-6 : 0;
	p.clock_event = flag(line, 74, 'E');
	p.clock_predicted = flag(line, 75, 'P');
	p.manoeuvre = flag(line, 78, 'M');
	p.orbit_predicted = flag(line, 79, 'P');
	*point = p;
	return FW_OK;
}

/* One line; FW_MORE: it made no point. */
static fw_status take_line(fw_sp3_reader *r, const fw_line *line, fw_sp3_point *point)
{
	const char first = line->n > 0 ? line->text[0] : ' ';

	if (r->lines.overlong != r->overlong) {
		r->overlong = r->lines.overlong;
		return lost(r, "a line that is too long");
	}
	if (!r->begun && first != '#')
		return unknown(r, "not SP3");
	if (line->n >= 3 && memcmp(line->text, "EOF", 3) == 0) {
		r->ended = true;
		return FW_MORE;
	}
	switch (first) {
	case '#': return take_version(r, line);
	case '%': return flag(line, 1, 'c') ? take_scale(r, line) : FW_MORE;
	case '*': return take_epoch(r, line);
	case 'P': return take_point(r, line, point);
	case 'V': /* velocity */
	case 'E': /* correlations */
	case '+': /* satellites and their accuracies */
	case '/': /* comment */
	case ' ': return FW_MORE;
	default: return lost(r, "a line of a kind that SP3 does not have");
	}
}

fw_status fw_sp3_read(fw_sp3_reader *r, fw_sp3_point *point)
{
	fw_status status;
	fw_line line;

	do {
		status = fw_lines_next(&r->lines, &line);
		if (status == FW_EOF)
			return !r->begun ? unknown(r, "an empty file") : r->ended ? FW_EOF : FW_ETRUNCATED;
		if (status == FW_OK)
			status = take_line(r, &line, point);
	} while (status == FW_MORE);
	return status;
}
