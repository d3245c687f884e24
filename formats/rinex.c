#include "formats/rinex.h"

#include <math.h>
#include <string.h>

#include "formats/number.h"
#include "gnss/signal.h"

/* ---- which kind ---- */

static bool label_is(const uint8_t *line, size_t n, const char *label)
{
	const size_t length = strlen(label);
	return n >= FW_RINEX_LABEL + length && memcmp(line + FW_RINEX_LABEL, label, length) == 0;
}

fw_rinex_kind fw_rinex_detect(const uint8_t *bytes, size_t n)
{
	static const char version[] = "RINEX VERSION / TYPE";
	const uint8_t *end = memchr(bytes, '\n', n);
	const size_t length = end != NULL ? (size_t)(end - bytes) : n;

	if (label_is(bytes, length, "CRINEX VERS   / TYPE"))
		return FW_RINEX_OBSERVATION;
	if (memmem(bytes, length, version, sizeof version - 1) == NULL)
		return FW_RINEX_NONE;
	if (!label_is(bytes, length, version) || bytes[5] < '2' || bytes[5] > '4')
		return FW_RINEX_OTHER;
	switch (bytes[20]) {
	case 'O': return FW_RINEX_OBSERVATION;
	case 'N': return FW_RINEX_NAVIGATION;
	case 'G': /* version 2 has a type for each system */
	case 'H':
	case 'J':
	case 'L': return bytes[5] == '2' ? FW_RINEX_NAVIGATION : FW_RINEX_OTHER;
	default: return FW_RINEX_OTHER;
	}
}

/* ---- lines ---- */

void fw_lines_begin(fw_lines *l, fw_input *input)
{
	l->number = 0;
	l->overlong = 0;
	l->input = input;
	l->input_status = FW_OK;
	l->pos = l->end = l->looked_at = 0;
	l->inside = false;
}

/* Moves what is left to the front and adds to it. */
static void refill(fw_lines *l)
{
	size_t got = 0;

	memmove(l->buffer, l->buffer + l->pos, l->end - l->pos);
	l->end -= l->pos;
	l->looked_at -= l->pos;
	l->pos = 0;
	l->input_status = fw_input_read(l->input, l->buffer + l->end, FW_RINEX_BUFFER - l->end, &got);
	l->end += got;
}

/* Hands out what lies before `end`. Of an overlong line, whose beginning is gone, the rest is an empty one. */
static fw_status hand_out(fw_lines *l, size_t end, bool whole, fw_line *line)
{
	size_t n = end - l->pos;

	if (l->inside || n > FW_RINEX_LINE_MAX) {
		l->overlong++;
		n = 0;
	}
	*line = (fw_line){l->buffer + l->pos, n, ++l->number, whole};
	while (line->n > 0 && line->text[line->n - 1] == '\r')
		line->n--;
	l->inside = false;
	l->pos = l->looked_at = end + whole;
	return FW_OK;
}

fw_status fw_lines_next(fw_lines *l, fw_line *line)
{
	for (;;) {
		const char *from = l->buffer + l->looked_at;
		const char *end = memchr(from, '\n', l->end - l->looked_at);
		if (end != NULL)
			return hand_out(l, (size_t)(end - l->buffer), true, line);
		l->looked_at = l->end;
		if (l->end - l->pos > FW_RINEX_LINE_MAX) {
			l->inside = true;
			l->pos = l->end;
		}
		if (l->input_status != FW_OK)
			break;
		refill(l);
	}
	if (l->pos < l->end || l->inside)
		return hand_out(l, l->end, false, line);
	return l->input_status;
}

/* ---- columns ---- */

/* The columns without the blanks around them. */
static const char *trim(const fw_line *line, size_t from, size_t *n)
{
	const char *p = line->text + from, *end;

	if (from >= line->n) {
		*n = 0;
		return line->text;
	}
	end = p + (*n < line->n - from ? *n : line->n - from);
	while (p < end && *p == ' ')
		p++;
	while (p < end && end[-1] == ' ')
		end--;
	*n = (size_t)(end - p);
	return p;
}

void fw_rinex_text(const fw_line *line, size_t from, size_t n, char *text, size_t room)
{
	const char *p = trim(line, from, &n);

	n = n < room - 1 ? n : room - 1;
	for (size_t i = 0; i < n; i++)
		text[i] = p[i] >= 0 && p[i] < ' ' ? '?' : p[i];
	text[n] = '\0';
}

void fw_rinex_label(const fw_line *line, char label[static 21])
{
	fw_rinex_text(line, FW_RINEX_LABEL, 20, label, 21);
}

fw_status fw_rinex_double(const fw_line *line, size_t from, size_t n, double *x)
{
	char copy[32];
	const char *p = trim(line, from, &n);

	if (n == 0)
		return FW_EOF;
	if (n > sizeof copy)
		return FW_ESYNTAX;
	for (size_t i = 0; i < n; i++)
		copy[i] = p[i] == 'D' || p[i] == 'd' ? 'e' : p[i];
	return fw_get_double(copy, n, x);
}

fw_status fw_rinex_int(const fw_line *line, size_t from, size_t n, int *x)
{
	const char *p = trim(line, from, &n);
	int64_t value;

	if (n == 0)
		return FW_EOF;
	const fw_status status = fw_get_i64(p, n, &value);
	if (status != FW_OK)
		return status;
	if (value < INT32_MIN || value > INT32_MAX)
		return FW_ERANGE;
	*x = (int)value;
	return FW_OK;
}

/* ---- time ---- */

fw_status fw_rinex_seconds(const fw_line *line, size_t from, size_t n, int64_t *ns)
{
	double s = 0;
	const fw_status status = fw_rinex_double(line, from, n, &s);

	if (status != FW_OK)
		return status;
	if (!(s >= 0 && s < 61))
		return FW_ERANGE;
	*ns = llround(s * 1e9);
	return FW_OK;
}

fw_status fw_rinex_time_system(const char *name, fw_rinex_time *system)
{
	static const char names[][4] = {"GPS", "GLO", "GAL", "BDT", "QZS", "IRN", "UTC", "BDS"};

	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		if (strcmp(name, names[i]) == 0) {
			*system = i == 7 ? FW_RINEX_BDT : (fw_rinex_time)i;
			return FW_OK;
		}
	}
	return FW_EUNKNOWN;
}

fw_status fw_rinex_moment(const fw_civil *civil, fw_rinex_time system, fw_time *t)
{
	const bool is_utc = system == FW_RINEX_GLO || system == FW_RINEX_UTC;
	fw_civil c = *civil;
	int64_t later_ns = system == FW_RINEX_BDT ? 14 * FW_NS_PER_S : 0;

	if (c.year >= 0 && c.year < 100)
		c.year += c.year >= 80 ? 1900 : 2000;
	if (is_utc && c.second == 60) { /* a leap second, if there was one */
		const fw_status status = fw_time_from_utc(&c, t);
		if (status >= 0)
			return status;
	}
	if (c.second == 60) {
		c.second = 59;
		later_ns += FW_NS_PER_S;
	}
	const fw_status status = is_utc ? fw_time_from_utc(&c, t) : fw_time_from_civil(&c, t);
	if (status >= 0)
		*t = fw_time_add_ns(*t, later_ns);
	return status;
}

/* ---- satellites ---- */

#define TEN(letter, ten)                                                                                     \
	letter ten "0", letter ten "1", letter ten "2", letter ten "3", letter ten "4", letter ten "5",      \
	    letter ten "6", letter ten "7", letter ten "8", letter ten "9"
#define SEVENTY(letter)                                                                                      \
	TEN(letter, "0"), TEN(letter, "1"), TEN(letter, "2"), TEN(letter, "3"), TEN(letter, "4"),            \
	    TEN(letter, "5"), TEN(letter, "6")

const char *fw_rinex_satellite(char letter, int number)
{
	static const char names[FW_SYSTEM_COUNT][70][5] = {
	    [FW_GPS] = {SEVENTY("G")},     [FW_GALILEO] = {SEVENTY("E")}, [FW_BEIDOU] = {SEVENTY("C")},
	    [FW_GLONASS] = {SEVENTY("R")}, [FW_QZSS] = {SEVENTY("J")},    [FW_NAVIC] = {SEVENTY("I")},
	    [FW_SBAS] = {SEVENTY("S1")},
	};
	const fw_system system = fw_system_of_letter(letter);

	if (system == FW_SYSTEM_COUNT || number < (system == FW_SBAS ? 20 : 1) ||
	    number >= FW_SATELLITES_PER_SYSTEM)
		return NULL;
	return names[system][number];
}
