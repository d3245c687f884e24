#include "formats/rinex_clock.h"

#include <string.h>

enum { SHIFT_304 = 5 /* names of nine characters instead of four */ };

void fw_rinex_clock_begin(fw_rinex_clock_reader *r, fw_input *input)
{
	fw_lines_begin(&r->lines, input);
	r->reason = "";
	r->begun = r->in_header = false;
	r->scale = FW_RINEX_GPS;
	r->shift = 0;
	r->overlong = 0;
}

static fw_status lost(fw_rinex_clock_reader *r, const char *reason)
{
	r->reason = reason;
	return FW_ESYNTAX;
}

static fw_status unknown(fw_rinex_clock_reader *r, const char *reason)
{
	r->reason = reason;
	return FW_EUNKNOWN;
}

static bool labelled(const fw_line *line, size_t column, const char *label)
{
	char text[24];

	fw_rinex_text(line, column, sizeof text - 1, text, sizeof text);
	return strcmp(text, label) == 0;
}

/* "3.00           C ...". In version 3.04 all labels moved; where this one stands tells, whatever the number
 * says. */
static fw_status take_first(fw_rinex_clock_reader *r, const fw_line *line)
{
	const char label[] = "RINEX VERSION / TYPE";
	char type[24];
	double version;

	if (!labelled(line, FW_RINEX_LABEL, label)) {
		r->shift = SHIFT_304;
		if (!labelled(line, FW_RINEX_LABEL + SHIFT_304, label))
			return unknown(r, "not RINEX");
	}
	if (fw_rinex_double(line, 0, 9, &version) != FW_OK || !(version >= 2 && version < 4))
		return unknown(r, "a version of RINEX that is not known");
	fw_rinex_text(line, 15, 20, type, sizeof type);
	if (type[0] != 'C')
		return unknown(r, "RINEX, but no clock file");
	r->begun = r->in_header = true;
	return FW_MORE;
}

static fw_status take_header(fw_rinex_clock_reader *r, const fw_line *line)
{
	const size_t column = FW_RINEX_LABEL + r->shift;
	char name[8];

	if (labelled(line, column, "END OF HEADER"))
		r->in_header = false;
	if (!labelled(line, column, "TIME SYSTEM ID"))
		return FW_MORE;
	fw_rinex_text(line, 3, 3, name, sizeof name);
	if (name[0] != '\0' && fw_rinex_time_system(name, &r->scale) < 0)
		return unknown(r, "a time system that is not known");
	return FW_MORE;
}

static fw_status take_epoch(fw_rinex_clock_reader *r, const fw_line *line, fw_time *t)
{
	const size_t at = 8 + r->shift;
	fw_civil c;
	int64_t ns;

	if (fw_rinex_int(line, at, 4, &c.year) != FW_OK || fw_rinex_int(line, at + 4, 3, &c.month) != FW_OK ||
	    fw_rinex_int(line, at + 7, 3, &c.day) != FW_OK ||
	    fw_rinex_int(line, at + 10, 3, &c.hour) != FW_OK ||
	    fw_rinex_int(line, at + 13, 3, &c.minute) != FW_OK ||
	    fw_rinex_seconds(line, at + 16, 10, &ns) != FW_OK)
		return lost(r, "an epoch that is no date and time");
	c.second = (int)(ns / FW_NS_PER_S);
	c.nanosecond = (int)(ns % FW_NS_PER_S);
	if (fw_rinex_moment(&c, r->scale, t) < 0)
		return lost(r, "an epoch with a date or time that does not exist");
	return FW_MORE;
}

/* "AS G02  2010 07 01 00 00  0.000000  2    2.691084288582e-04  1.507490528240e-11" */
static fw_status take_clock(fw_rinex_clock_reader *r, const fw_line *line, fw_rinex_clock_point *point)
{
	fw_rinex_clock_point p = {0};
	char name[4] = {0};
	fw_status status;

	if (line->n < 6)
		return lost(r, "a line cut short");
	memcpy(name, line->text + 3, 3);
	if (name[0] == 'L') /* a low orbit */
		return FW_MORE;
	if (fw_satellite_parse(name, &p.satellite) < 0)
		return lost(r, "a satellite that is not known");
	status = take_epoch(r, line, &p.time);
	if (status != FW_MORE)
		return status;
	if (fw_rinex_double(line, 40 + r->shift, 19, &p.clock_s) != FW_OK)
		return lost(r, "a clock that is no number");
	if (fw_rinex_double(line, 60 + r->shift, 19, &p.sd_s) < 0)
		return lost(r, "a standard deviation that is no number");
	*point = p;
	return FW_OK;
}

/* One line; FW_MORE: it made no clock. */
static fw_status take_line(fw_rinex_clock_reader *r, const fw_line *line, fw_rinex_clock_point *point)
{
	if (r->lines.overlong != r->overlong) {
		r->overlong = r->lines.overlong;
		return lost(r, "a line that is too long");
	}
	if (!r->begun)
		return take_first(r, line);
	if (r->in_header)
		return take_header(r, line);
	if (line->n < 2 || memcmp(line->text, "AS", 2) != 0)
		return FW_MORE;
	return take_clock(r, line, point);
}

fw_status fw_rinex_clock_read(fw_rinex_clock_reader *r, fw_rinex_clock_point *point)
{
	fw_status status;
	fw_line line;

	do {
		status = fw_lines_next(&r->lines, &line);
		if (status == FW_EOF)
			return !r->begun      ? unknown(r, "an empty file")
			       : r->in_header ? FW_ETRUNCATED
			                      : FW_EOF;
		if (status == FW_OK)
			status = take_line(r, &line, point);
	} while (status == FW_MORE);
	return status;
}
