#include "formats/rinex_out.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "formats/number.h"
#include "formats/rinex.h"

void fw_rinex_out_begin(fw_rinex_out *o, fw_output *output, void *context)
{
	o->status = FW_OK;
	o->output = output;
	o->context = context;
	o->used = o->line = 0;
}

/* Room for n more bytes of the line; past the longest line that there is, none. */
static char *room(fw_rinex_out *o, size_t n)
{
	if (n > FW_RINEX_OUT_LINE - (o->used - o->line))
		return NULL;
	o->used += n;
	return o->buffer + o->used - n;
}

void fw_rinex_out_field(fw_rinex_out *o, const char *text, size_t n)
{
	const size_t length = strnlen(text, n);
	char *p = room(o, n);

	if (p == NULL)
		return;
	for (size_t i = 0; i < length; i++)
		p[i] = text[i] >= ' ' && text[i] <= '~' ? text[i] : '?';
	memset(p + length, ' ', n - length);
}

void fw_rinex_out_text(fw_rinex_out *o, const char *text)
{
	fw_rinex_out_field(o, text, strlen(text));
}

/* `length` bytes of text at the right end of n columns; blanks if they do not fit. */
static void right_align(fw_rinex_out *o, const char *text, size_t length, size_t n)
{
	char *p = room(o, n);

	if (p == NULL)
		return;
	memset(p, ' ', n);
	if (length <= n)
		memcpy(p + n - length, text, length);
}

void fw_rinex_out_int(fw_rinex_out *o, int64_t x, size_t n)
{
	char text[FW_INTEGER_ROOM];

	right_align(o, text, (size_t)(fw_put_i64(text, x) - text), n);
}

void fw_rinex_out_fixed(fw_rinex_out *o, double x, size_t n, int decimals)
{
	char text[FW_FIXED_ROOM];

	right_align(o, text, isfinite(x) ? (size_t)(fw_put_fixed(text, x, decimals) - text) : n + 1, n);
}

/* "%.12E", whatever the locale has for a point. */
void fw_rinex_out_scientific(fw_rinex_out *o, double x)
{
	char text[64];
	const bool tiny = !(fabs(x) >= 1e-99); /* two digits of exponent */

	if (!isfinite(x) || fabs(x) >= 9.9999999999995e99) {
		right_align(o, "", 0, 19);
		return;
	}
	snprintf(text, sizeof text, "%+.12E", tiny ? 0 : x + 0.0);
	const char *exponent = strrchr(text, 'E');
	char *p = room(o, 19);
	if (p == NULL)
		return;
	p[0] = text[0] == '-' ? '-' : ' ';
	p[1] = text[1];
	p[2] = '.';
	memcpy(p + 3, exponent - 12, 16);
}

void fw_rinex_out_column(fw_rinex_out *o, size_t column)
{
	const size_t at = o->used - o->line;
	char *p = at < column ? room(o, column - at) : NULL;

	if (p != NULL)
		memset(p, ' ', column - at);
}

static void hand_on(fw_rinex_out *o)
{
	if (o->status == FW_OK && o->line > 0)
		o->status = o->output(o->context, o->buffer, o->line);
	memmove(o->buffer, o->buffer + o->line, o->used - o->line);
	o->used -= o->line;
	o->line = 0;
}

void fw_rinex_out_end_line(fw_rinex_out *o)
{
	while (o->used > o->line && o->buffer[o->used - 1] == ' ')
		o->used--;
	o->buffer[o->used++] = '\n';
	o->line = o->used;
	if (o->used + FW_RINEX_OUT_LINE + 1 > FW_RINEX_OUT_BUFFER)
		hand_on(o);
}

void fw_rinex_out_label(fw_rinex_out *o, const char *label)
{
	fw_rinex_out_column(o, FW_RINEX_LABEL);
	fw_rinex_out_text(o, label);
	fw_rinex_out_end_line(o);
}

void fw_rinex_out_head(fw_rinex_out *o, const char *type, fw_time made)
{
	fw_civil c = {0};
	char text[64];

	fw_rinex_out_text(o, "     3.04           ");
	fw_rinex_out_field(o, type, 20);
	fw_rinex_out_text(o, "M: MIXED");
	fw_rinex_out_label(o, "RINEX VERSION / TYPE");
	fw_rinex_out_field(o, "furrow " FURROW_VERSION, 40);
	if (fw_time_to_civil(made, &c) == FW_OK) {
		snprintf(text, sizeof text, "%04d%02d%02d %02d%02d%02d GPS", c.year, c.month, c.day, c.hour,
		         c.minute, c.second);
		fw_rinex_out_field(o, text, 20);
	}
	fw_rinex_out_label(o, "PGM / RUN BY / DATE");
}

fw_status fw_rinex_out_flush(fw_rinex_out *o)
{
	hand_on(o);
	return o->status;
}
