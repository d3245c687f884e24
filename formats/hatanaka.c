#include "formats/hatanaka.h"

#include <string.h>

#include "formats/number.h"

/* Where things stand in an epoch's line, by version 1 or 3. */
typedef struct {
	char fresh; /* first character of an epoch that begins anew, as stored */
	char first; /* and in RINEX */
	uint8_t flag, count,
	    list;         /* columns of event flag, number of satellites (3 wide), list of satellites */
	uint8_t year_end; /* column behind the year */
	uint8_t clock_at, clock_decimals, clock_width;
} layout;

static const layout layouts[2] = {
    {'&', ' ', 28, 29, 32, 3, 68, 9, 12},
    {'>', '>', 31, 32, 41, 6, 41, 12, 15},
};

static const layout *layout_of(const fw_hatanaka *h)
{
	return &layouts[h->version == 3];
}

static bool is_digit(char c)
{
	return c >= '0' && c <= '9';
}

void fw_hatanaka_begin(fw_hatanaka *h, fw_lines *lines)
{
	h->problem = (fw_rinex_problem){0, ""};
	h->lines = lines;
	h->version = 0;
	h->in_header = true;
	h->held = h->lost = false;
	h->verbatim = h->n_satellites = h->next_satellite = h->part = 0;
	memset(h->n_types, 0, sizeof h->n_types);
	h->epoch_n = 0;
	h->clock.order = -1;
	h->epochs = 1;
	memset(h->seen, 0, sizeof h->seen);
}

/* ---- input ---- */

static fw_status next_line(fw_hatanaka *h, fw_line *line)
{
	if (h->held) {
		h->held = false;
		*line = h->line;
		return FW_OK;
	}
	const fw_status status = fw_lines_next(h->lines, line);
	if (status == FW_OK && line->n > 0 && line->text[0] == '\x1a') /* the end, as DOS had it */
		return FW_EOF;
	/* A number that is cut short is another number. */
	return status == FW_OK && !line->whole && !h->in_header ? FW_ETRUNCATED : status;
}

static fw_status complain(fw_hatanaka *h, uint64_t line, const char *reason)
{
	h->problem = (fw_rinex_problem){line, reason};
	return FW_ESYNTAX;
}

/* What follows cannot be understood before an epoch begins anew. */
static fw_status lose(fw_hatanaka *h, uint64_t line, const char *reason)
{
	h->lost = true;
	h->n_satellites = h->next_satellite = 0;
	return complain(h, line, reason);
}

/* ---- the header ---- */

static int letter_index(char letter)
{
	return letter >= 'A' && letter <= 'Z' ? letter - 'A' + 1 : -1;
}

/* Header lines, also those of events, say how many observables there are. */
static fw_status note_types(fw_hatanaka *h, const fw_line *line)
{
	char label[21];
	int n = 0, index = 0;
	fw_status status = FW_EOF;

	fw_rinex_label(line, label);
	if (strcmp(label, "# / TYPES OF OBSERV") == 0) {
		status = fw_rinex_int(line, 0, 6, &n);
	} else if (strcmp(label, "SYS / # / OBS TYPES") == 0 && line->text[0] != ' ') {
		status = fw_rinex_int(line, 3, 3, &n);
		index = letter_index(line->text[0]);
	}
	if (status == FW_EOF)
		return FW_OK;
	if (status != FW_OK || index < 0 || n < 0 || n > FW_HATANAKA_TYPES)
		return complain(h, line->number, "no usable number of observables");
	h->n_types[index] = n;
	return FW_OK;
}

/* The two lines that Compact RINEX puts before the header. */
static fw_status begin(fw_hatanaka *h)
{
	fw_line line;
	fw_status status = fw_lines_next(h->lines, &line);

	if (status == FW_OK && line.n > 0 && (line.text[0] == '1' || line.text[0] == '3'))
		h->version = line.text[0] - '0';
	if (status == FW_OK && h->version == 0) {
		(void)!complain(h, line.number, "a version of Compact RINEX that is not known");
		return FW_EUNKNOWN;
	}
	return status == FW_OK ? fw_lines_next(h->lines, &line) : status;
}

static fw_status header_line(fw_hatanaka *h, fw_line *line)
{
	char label[21];
	fw_status status = h->version == 0 ? begin(h) : FW_OK;

	if (status == FW_OK)
		status = next_line(h, line);
	if (status != FW_OK)
		return status;
	fw_rinex_label(line, label);
	h->in_header = strcmp(label, "END OF HEADER") != 0;
	return note_types(h, line);
}

/* ---- differences ---- */

/* A token: [order&]difference. Returns false when it is none. */
static bool take(fw_hatanaka_arc *arc, const char *p, size_t n)
{
	int64_t value;

	if (n > 2 && p[1] == '&') {
		if (!is_digit(p[0]) || p[0] - '0' > FW_HATANAKA_ORDER)
			return false;
		arc->arc_order = (int8_t)(p[0] - '0');
		arc->order = -1;
		p += 2;
		n -= 2;
	} else if (arc->order < 0) {
		return false;
	}
	if (fw_get_i64(p, n, &value) != FW_OK)
		return false;
	arc->order = (int8_t)(arc->order + (arc->order < arc->arc_order));
	arc->level[arc->order] = (uint64_t)value;
	for (int k = arc->order - 1; k >= 0; k--)
		arc->level[k] += arc->level[k + 1];
	return true;
}

/* Text against text: a blank leaves a character, & makes it a blank. */
static void repair(char *text, const char *change, size_t n)
{
	for (size_t i = 0; i < n; i++)
		if (change[i] != ' ')
			text[i] = (char)(change[i] == '&' ? ' ' : change[i]);
}

/* value / 10^decimals right-aligned in `width` columns, without a zero before the point. False when it does
 * not fit. */
static bool put_number(char *to, size_t width, int decimals, uint64_t value)
{
	const bool negative = (int64_t)value < 0;
	uint64_t left = negative ? -value : value;
	size_t at = width;

	for (int i = 0; at > 0 && (i <= decimals || left > 0); i++) {
		if (i == decimals) {
			to[--at] = '.';
			continue;
		}
		to[--at] = (char)('0' + left % 10);
		left /= 10;
	}
	if (left > 0 || (negative && at == 0))
		return false;
	if (negative)
		to[--at] = '-';
	memset(to, ' ', at);
	return true;
}

/* ---- epochs ---- */

static bool is_fresh(const fw_hatanaka *h, const fw_line *line)
{
	const layout *at = layout_of(h);
	return line->n > at->flag && line->text[0] == at->fresh && is_digit(line->text[at->flag]);
}

/* A place of its own for every satellite; -1: the name is none. */
static int slot_of(const char *name)
{
	const int letter = letter_index(name[0] == ' ' ? 'G' : name[0]);
	const int ten = name[1] == ' ' ? 0 : name[1] - '0', one = name[2] - '0';

	if (letter < 0 || ten < 0 || ten > 9 || one < 0 || one > 9)
		return -1;
	return letter * 100 + 10 * ten + one;
}

static const char *name_of(const fw_hatanaka *h, int i)
{
	return h->epoch + layout_of(h)->list + 3 * i;
}

static int types_of(const fw_hatanaka *h, int i)
{
	return h->n_types[h->version == 1 ? 0 : slot_of(name_of(h, i)) / 100];
}

/* All satellites of the list have a name, and come once. */
static bool satellites_are_sound(fw_hatanaka *h)
{
	static const uint64_t now = UINT64_C(1) << 63;
	bool sound = true;

	for (int i = 0; i < h->n_satellites; i++) {
		const int slot = slot_of(name_of(h, i));
		if (slot < 0 || h->seen[slot] & now) {
			h->n_satellites = i; /* those before it have their mark taken off below */
			sound = false;
		} else {
			h->seen[slot] |= now;
		}
	}
	for (int i = 0; i < h->n_satellites; i++)
		h->seen[slot_of(name_of(h, i))] &= ~now;
	return sound;
}

/* An event: its line and those that belong to it are stored as they are. */
static fw_status event(fw_hatanaka *h, fw_line *line)
{
	const layout *at = layout_of(h);
	int n = 0;

	if (fw_rinex_int(line, at->count, 3, &n) < 0 || n < 0)
		return lose(h, line->number, "damaged event");
	memcpy(h->out, line->text, line->n < sizeof h->out ? line->n : sizeof h->out);
	h->out[0] = at->first;
	line->text = h->out;
	line->n = line->n < sizeof h->out ? line->n : sizeof h->out;
	h->verbatim = n;
	memset(h->epoch, ' ', sizeof h->epoch); /* the next epoch has to begin anew */
	return FW_OK;
}

static fw_status take_clock(fw_hatanaka *h)
{
	const layout *at = layout_of(h);
	fw_line line;
	const fw_status status = next_line(h, &line);

	h->clock_text[0] = '\0';
	if (status != FW_OK || line.n == 0) {
		if (status == FW_OK)
			h->clock.order = -1;
		return status;
	}
	if (!take(&h->clock, line.text, line.n))
		return lose(h, line.number, "damaged clock offset");
	h->clock_text[at->clock_width] = '\0';
	if (!put_number(h->clock_text, at->clock_width, at->clock_decimals, h->clock.level[0]))
		return lose(h, line.number, "clock offset out of range");
	return FW_OK;
}

/* Brings h->epoch up to date. The line is an epoch's. */
static fw_status take_epoch(fw_hatanaka *h, const fw_line *line)
{
	const layout *at = layout_of(h);
	char flag;

	if (line->n > sizeof h->epoch)
		return lose(h, line->number, "damaged epoch");
	if (is_fresh(h, line)) {
		memset(h->epoch, ' ', sizeof h->epoch);
		h->epoch_n = 0;
		h->epochs++; /* no satellite was in the epoch before */
		h->lost = false;
	}
	repair(h->epoch, line->text, line->n);
	h->epoch[0] = at->first;
	h->epoch_n = line->n > h->epoch_n ? line->n : h->epoch_n;
	while (h->epoch_n > 0 && h->epoch[h->epoch_n - 1] == ' ')
		h->epoch_n--;

	const fw_line whole = {h->epoch, h->epoch_n, line->number, true};
	flag = h->epoch[at->flag];
	if (h->epoch_n <= at->flag || (flag != '0' && flag != '1') || h->epoch[at->year_end] != ' ' ||
	    fw_rinex_int(&whole, at->count, 3, &h->n_satellites) != FW_OK || h->n_satellites < 0 ||
	    h->n_satellites > FW_HATANAKA_SATELLITES)
		return lose(h, line->number, "damaged epoch");
	if (!satellites_are_sound(h))
		return lose(h, line->number, "damaged list of satellites");
	h->epochs++;
	h->next_satellite = -1;
	h->part = 0;
	return FW_OK;
}

/* The line of an epoch that follows: the first one, or in RINEX 2 12 more satellites. */
static void put_epoch(fw_hatanaka *h, fw_line *line)
{
	const layout *at = layout_of(h);
	const size_t head = h->version == 3 ? 41 : 68;
	size_t n = h->epoch_n < head ? h->epoch_n : head;

	if (h->part > 0) {
		const size_t from = 32 + 36 * (size_t)h->part;
		n = h->epoch_n > from ? h->epoch_n - from : 0;
		n = n < 36 ? n : 36;
		memset(h->out, ' ', 32);
		memcpy(h->out + 32, h->epoch + from, n);
		n += 32;
	} else {
		memcpy(h->out, h->epoch, n);
		if (h->clock_text[0] != '\0') {
			memset(h->out + n, ' ', at->clock_at - n);
			memcpy(h->out + at->clock_at, h->clock_text, at->clock_width);
			n = (size_t)at->clock_at + at->clock_width;
		}
	}
	while (n > 0 && h->out[n - 1] == ' ')
		n--;
	line->text = h->out;
	line->n = n;
	if (h->version == 1 && 12 * ++h->part < h->n_satellites)
		return;
	h->part = 0;
	h->next_satellite = 0;
}

/* ---- satellites ---- */

/* The satellite's tokens and flags. */
static fw_status take_satellite(fw_hatanaka *h, const fw_line *line)
{
	const int n_types = types_of(h, h->next_satellite);
	const int slot = slot_of(name_of(h, h->next_satellite));
	fw_hatanaka_satellite *s = &h->satellites[slot];
	const char *p = line->text, *end = p + line->n;

	if (h->seen[slot] != h->epochs - 1) {
		for (int i = 0; i < n_types; i++)
			s->arcs[i].order = -1;
		memset(s->flags, ' ', sizeof s->flags);
	}
	h->seen[slot] = h->epochs;
	for (int i = 0; i < n_types; i++) {
		const char *blank = p < end ? memchr(p, ' ', (size_t)(end - p)) : NULL;
		const size_t n = (size_t)((blank != NULL ? blank : end) - p);
		if (n == 0)
			s->arcs[i].order = -1;
		else if (!take(&s->arcs[i], p, n))
			return lose(h, line->number, "damaged difference");
		p = blank != NULL ? blank + 1 : end;
	}
	const size_t room = 2 * (size_t)n_types, rest = (size_t)(end - p);
	repair(s->flags, p, rest < room ? rest : room);
	for (int i = 0; h->version == 1 && i < n_types; i++)
		if (s->arcs[i].order < 0) /* version 1: no flags without a number */
			memset(s->flags + 2 * i, ' ', 2);
	return FW_OK;
}

/* The satellite's line, or in RINEX 2 the next five observables. */
static fw_status put_satellite(fw_hatanaka *h, fw_line *line)
{
	const int i = h->next_satellite, n_types = types_of(h, i);
	const fw_hatanaka_satellite *s = &h->satellites[slot_of(name_of(h, i))];
	int from = 0, to = n_types;
	char *p = h->out;

	if (h->version == 1) {
		from = 5 * h->part++;
		to = from + 5 < n_types ? from + 5 : n_types;
	} else {
		memcpy(p, name_of(h, i), 3);
		p += 3;
	}
	for (int k = from; k < to; k++, p += 16) {
		if (s->arcs[k].order < 0)
			memset(p, ' ', 14);
		else if (!put_number(p, 14, 3, s->arcs[k].level[0]))
			return lose(h, line->number, "value out of range");
		memcpy(p + 14, s->flags + 2 * k, 2);
	}
	while (p > h->out && p[-1] == ' ')
		p--;
	line->text = h->out;
	line->n = (size_t)(p - h->out);
	if (to == n_types) {
		h->part = 0;
		h->next_satellite++;
	}
	return FW_OK;
}

static fw_status satellite_line(fw_hatanaka *h, fw_line *line)
{
	fw_status status = FW_OK;

	if (h->part > 0) {
		*line = h->line;
		return put_satellite(h, line);
	}
	status = next_line(h, line);
	if (status != FW_OK)
		return status == FW_EOF ? FW_ETRUNCATED : status;
	h->line = *line; /* its number, for the lines that it makes in RINEX 2 */
	if (is_fresh(h, line)) {
		h->held = true;
		return lose(h, line->number, "an epoch ends too early");
	}
	status = take_satellite(h, line);
	return status == FW_OK ? put_satellite(h, line) : status;
}

/* Between epochs version 3 may have escape lines, which nobody uses. */
static bool is_escape(const fw_hatanaka *h, const fw_line *line)
{
	return h->version == 3 && line->n > 0 && line->text[0] == '&';
}

static fw_status epoch_line(fw_hatanaka *h, fw_line *line)
{
	fw_status status = next_line(h, line);

	while (status == FW_OK && (is_escape(h, line) || (h->lost && !is_fresh(h, line))))
		status = next_line(h, line);
	if (status != FW_OK)
		return status;
	if (is_fresh(h, line) && line->text[layout_of(h)->flag] > '1') {
		h->lost = false;
		return event(h, line);
	}
	h->line = *line; /* its number, for the lines that it makes */
	status = take_epoch(h, line);
	if (status == FW_OK)
		status = take_clock(h);
	if (status == FW_OK)
		put_epoch(h, line);
	return status == FW_EOF ? FW_ETRUNCATED : status;
}

fw_status fw_hatanaka_next(fw_hatanaka *h, fw_line *line)
{
	fw_status status = FW_OK;

	if (h->in_header)
		return header_line(h, line);
	if (h->verbatim > 0) {
		h->verbatim--;
		status = next_line(h, line);
		return status == FW_OK ? note_types(h, line) : status;
	}
	if (h->next_satellite < 0) { /* RINEX 2: the rest of the list of satellites */
		*line = h->line;
		put_epoch(h, line);
		return FW_OK;
	}
	if (h->next_satellite < h->n_satellites)
		return satellite_line(h, line);
	return epoch_line(h, line);
}
