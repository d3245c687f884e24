#include "formats/csv.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "formats/number.h"
#include "furrow_meta.h"

#define STREAM_LINE "#furrow-stream 1"

/* ---- Writing ------------------------------------------------------------------------------------------ */

enum {
	FLUSH_AT = 64 * 1024, /* what a pipe takes at once */

	/* A row starts below FLUSH_AT, behind an announcement if its type is new. Strings stop at
	 * FW_CSV_LINE_MAX; numbers do not look, they have this much room. */
	NUMBERS_ROOM = FW_MAX_COLUMNS * (FW_FIXED_ROOM + 1),
	HEADER_ROOM = FW_MAX_COLUMNS * 32 + 64,
};
static_assert(FLUSH_AT + HEADER_ROOM + FW_CSV_LINE_MAX + NUMBERS_ROOM + 64 <= FW_CSV_BUFFER,
              "room for any row");

/* Appends n bytes; room is the caller's care. */
static char *put_text(char *p, const char *text, size_t n)
{
	memcpy(p, text, n);
	return p + n;
}

/* "gps_week,tow_s,..." and the line's end. */
static void put_header(fw_csv_writer *w, const fw_record_type *type, const char *before)
{
	char *p = put_text(w->buffer + w->used, before, strlen(before));

	for (int i = 0; i < type->n_columns; i++) {
		p = put_text(p, type->columns[i].name, strlen(type->columns[i].name));
		*p++ = i + 1 < type->n_columns ? ',' : '\n';
	}
	w->used = (size_t)(p - w->buffer);
}

static void begin(fw_csv_writer *w, fw_kind only, fw_output *output, void *context)
{
	memset(w, 0, offsetof(fw_csv_writer, buffer));
	w->only = only;
	w->output = output;
	w->context = context;
	w->time_text[0] = ','; /* no week, no time of week */
	w->time_length = 1;
}

void fw_csv_begin_table(fw_csv_writer *w, fw_kind kind, fw_output *output, void *context)
{
	begin(w, kind, output, context);
	put_header(w, fw_record_type_of(kind), "");
}

void fw_csv_begin_stream(fw_csv_writer *w, fw_output *output, void *context)
{
	begin(w, FW_RECORD_COUNT, output, context);
	w->used = (size_t)(put_text(w->buffer, STREAM_LINE "\n", sizeof STREAM_LINE) - w->buffer);
}

fw_status fw_csv_flush(fw_csv_writer *w)
{
	if (w->status == FW_OK && w->used > 0)
		w->status = w->output(w->context, w->buffer, w->used);
	w->used = 0;
	return w->status;
}

/* The line from `start` to p is done: keep it, unless it is too long. */
static bool end_line(fw_csv_writer *w, const char *start, const char *p)
{
	const bool fits = p - start <= FW_CSV_LINE_MAX;

	if (fits)
		w->used = (size_t)(p - w->buffer);
	else
		w->refused++;
	if (w->used >= FLUSH_AT && fw_csv_flush(w) != FW_OK)
		return false;
	return fits;
}

/* Bytes that need neither quotes nor a second look: printable ASCII without comma and quote. */
static const bool plain[256] = {[' ' ... '!'] = true, ['#' ... '+'] = true, ['-' ... '~'] = true};

/* Length of the UTF-8 character at s, 0 if there is none (overlong forms and surrogates included).
 * Source: The Unicode Standard 15.0, table 3-7. */
static int utf8_length(const unsigned char *s)
{
	const unsigned char low = s[0] == 0xe0 ? 0xa0 : s[0] == 0xf0 ? 0x90 : 0x80;
	const unsigned char high = s[0] == 0xed ? 0x9f : s[0] == 0xf4 ? 0x8f : 0xbf;
	const int n = s[0] < 0x80   ? 1
	              : s[0] < 0xc2 ? 0
	              : s[0] < 0xe0 ? 2
	              : s[0] < 0xf0 ? 3
	              : s[0] < 0xf5 ? 4
	                            : 0;

	if (n > 1 && (s[1] < low || s[1] > high))
		return 0;
	for (int i = 2; i < n; i++)
		if (s[i] < 0x80 || s[i] > 0xbf)
			return 0;
	return n;
}

/* Copies one character of a string, or '?' for a byte that is none. Moves *s behind it. */
static char *put_character(char *p, const char **s)
{
	const int n = utf8_length((const unsigned char *)*s);

	if (n == 0)
		*p++ = '?';
	for (int i = 0; i < n; i++)
		*p++ = (*s)[i];
	*s += n ? n : 1;
	return p;
}

/* A string with bytes that are not plain. Stops short behind `limit`. */
static char *put_special(char *p, const char *s, const char *limit)
{
	bool quoted = false;

	for (const char *t = s; *t && !quoted; t++)
		quoted = *t == '"' || *t == ',' || (unsigned char)*t < ' ' || *t == 0x7f;
	if (quoted)
		*p++ = '"';
	while (*s && p <= limit) {
		if (*s == '"')
			*p++ = '"';
		p = put_character(p, &s);
	}
	if (quoted)
		*p++ = '"';
	return p;
}

/* Whether all n bytes are plain. Compilers make vector code of it. */
static bool all_plain(const char *s, size_t n)
{
	unsigned special = 0;

	for (size_t i = 0; i < n; i++) {
		const unsigned char c = (unsigned char)s[i];
		special |= (c < ' ') | (c > '~') | (c == '"') | (c == ',');
	}
	return !special;
}

static char *put_string(char *p, const char *s, const char *limit)
{
	enum { LONG = 32 };
	char *q = p;
	const char *t = s;

	for (int i = 0; i < LONG && plain[(unsigned char)*t] && q <= limit; i++)
		*q++ = *t++;
	if (t - s == LONG) { /* raw pages */
		const size_t n = strlen(t);
		if (limit - q >= (ptrdiff_t)n && all_plain(t, n))
			return put_text(q, t, n);
	}
	while (plain[(unsigned char)*t] && q <= limit)
		*q++ = *t++;
	return *t == '\0' || q > limit ? q : put_special(p, s, limit);
}

static char *put_double(char *p, double x, const fw_column *c)
{
	if (!isfinite(x))
		return p;
	switch (c->text) {
	case FW_TEXT_FIXED: return fw_put_fixed(p, x, c->decimals);
	case FW_TEXT_TRIMMED: return fw_put_fixed_trim(p, x, c->decimals);
	default: return fw_put_double(p, x);
	}
}

/* The member of column c as text. */
static inline char *put_column(char *p, const fw_column *c, const char *record, const char *limit)
{
	const char *member = record + c->offset;
	const char *text;
	int64_t i8;
	int32_t i4;
	int16_t i2;
	float f;
	double d;

	switch (c->type) {
	case FW_I8: return fw_put_i64(p, (signed char)*member);
	case FW_I16: memcpy(&i2, member, sizeof i2); return fw_put_i64(p, i2);
	case FW_I32: memcpy(&i4, member, sizeof i4); return fw_put_i64(p, i4);
	case FW_I64: memcpy(&i8, member, sizeof i8); return fw_put_i64(p, i8);
	case FW_F32: memcpy(&f, member, sizeof f); return isfinite(f) ? fw_put_float(p, f) : p;
	case FW_F64: memcpy(&d, member, sizeof d); return put_double(p, d, c);
	default: memcpy(&text, member, sizeof text); return text ? put_string(p, text, limit) : p;
	}
}

/* Week and time of week, the same as in the row before more often than not. */
static char *put_time(fw_csv_writer *w, const fw_record_type *type, const fw_record_head *head, char *p)
{
	enum { COMMON = 32 }; /* longer than nearly all, and quick to copy because it is a constant */
	const int64_t present = head->present & 3;

	if (present != w->time.present || head->gps_week != w->time.gps_week ||
	    memcmp(&head->tow_s, &w->time.tow_s, sizeof head->tow_s) != 0) {
		const char *record = (const char *)head;
		char *q = w->time_text;
		if (present & 1)
			q = put_column(q, &type->columns[0], record, NULL);
		*q++ = ',';
		if (present & 2)
			q = put_column(q, &type->columns[1], record, NULL);
		w->time_length = (size_t)(q - w->time_text);
		w->time = *head;
		w->time.present = present;
	}
	memcpy(p, w->time_text, COMMON);
	if (w->time_length > COMMON)
		memcpy(p + COMMON, w->time_text + COMMON, w->time_length - COMMON);
	return p + w->time_length;
}

void fw_csv_meta(fw_csv_writer *w, const char *key, const char *value)
{
	char *const start = w->buffer + w->used;
	char *const limit = start + FW_CSV_LINE_MAX;
	char *p = start;

	if (w->status != FW_OK || w->only != FW_RECORD_COUNT)
		return;
	*p++ = '#';
	while (*key && p <= limit)
		p = put_character(p, &key);
	*p++ = ' ';
	while (*value && p <= limit)
		p = put_character(p, &value);
	for (char *c = start; c < p; c++)
		if ((unsigned char)*c < ' ' || *c == 0x7f)
			*c = ' ';
	*p++ = '\n';
	end_line(w, start, p);
}

/* Whether a line `#key value` would be just that, and not a stream's begin, its end or the announcement of a type:
 * records that came from elsewhere may have any key. */
static bool is_key(const char *key)
{
	return key && *key &&
	       key[strspn(key, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-")] ==
	           '\0' &&
	       strcmp(key, "end") != 0 && strcmp(key, "furrow-stream") != 0;
}

static void announce(fw_csv_writer *w, fw_kind kind, const fw_record_type *type)
{
	char before[40];

	snprintf(before, sizeof before, "#%s,", type->name);
	put_header(w, type, before);
	w->announced[kind] = true;
}

static void put_row(fw_csv_writer *w, const fw_record_type *type, const fw_record_head *head)
{
	char *const start = w->buffer + w->used;
	const char *const limit = start + FW_CSV_LINE_MAX;
	char *p = start;

	if (w->only == FW_RECORD_COUNT) {
		p = put_text(p, type->name, strlen(type->name));
		*p++ = ',';
	}
	p = put_time(w, type, head, p);
	/* Text may alias anything, as far as the compiler knows: what the loop needs is kept out of its sight. */
	const fw_column *c = &type->columns[2], *const end = &type->columns[type->n_columns];
	for (uint64_t present = (uint64_t)head->present >> 2; c < end; c++, present >>= 1) {
		*p++ = ',';
		if (present & 1)
			p = put_column(p, c, (const char *)head, limit);
	}
	*p++ = '\n';
	if (end_line(w, start, p))
		w->rows++;
}

void fw_csv_put(void *writer, fw_kind kind, const void *record)
{
	fw_csv_writer *w = writer;
	const fw_record_type *type = fw_record_type_of(kind);

	if (w->status != FW_OK || (w->only != FW_RECORD_COUNT && w->only != kind))
		return;
	if (w->only == FW_RECORD_COUNT && kind == FW_meta) {
		const furrow_meta *meta = record;
		if (is_key(meta->key))
			fw_csv_meta(w, meta->key, meta->value ? meta->value : "");
		return;
	}
	if (w->only == FW_RECORD_COUNT && !w->announced[kind])
		announce(w, kind, type);
	put_row(w, type, record);
}

fw_status fw_csv_end(fw_csv_writer *w, bool complete, uint64_t skipped)
{
	char text[96];

	snprintf(text, sizeof text, "status=%s rows=%llu skipped=%llu", complete ? "complete" : "partial",
	         (unsigned long long)w->rows, (unsigned long long)skipped);
	fw_csv_meta(w, "end", text);
	return fw_csv_flush(w);
}

/* ---- Reading: lines ----------------------------------------------------------------------------------- */

void fw_csv_begin_read(fw_csv_reader *r, fw_input *input, fw_kind wanted)
{
	memset(r, 0, offsetof(fw_csv_reader, columns));
	r->input = input;
	r->wanted = wanted;
	r->table = FW_RECORD_COUNT;
	r->line = 1;
	r->problem.column = r->problem.reason = "";
}

static fw_status problem(fw_csv_reader *r, int field, const char *column, const char *reason)
{
	r->problem.field = field;
	r->problem.column = column;
	r->problem.reason = reason;
	return FW_ESYNTAX;
}

/* A stretch of the buffer. */
typedef struct {
	char *p;
	size_t n;
} span;

/* Reads more behind what is there. False when the input has no more. */
static bool more(fw_csv_reader *r)
{
	size_t got;

	if (r->input_status != FW_OK)
		return false;
	if (r->end == FW_CSV_BUFFER ||
	    r->pos == r->end) { /* to the front; a row is shorter than the buffer */
		memmove(r->buffer, r->buffer + r->pos, r->end - r->pos);
		r->end -= r->pos;
		r->pos = 0;
	}
	r->input_status = fw_input_read(r->input, r->buffer + r->end, FW_CSV_BUFFER - r->end, &got);
	r->end += got;
	return r->input_status == FW_OK;
}

/* Takes n bytes out of the buffer as a row. */
static span take(fw_csv_reader *r, size_t n, uint64_t newlines)
{
	const span row = {r->buffer + r->pos, n};

	r->problem.line = r->line;
	r->pos += n;
	r->line += newlines;
	return row;
}

/* Gives up on a row: drops it up to its first line break, so that a stray quote costs one line only. */
static fw_status drop_line(fw_csv_reader *r, const char *reason)
{
	const char *start = r->buffer + r->pos;
	const char *newline = memchr(start, '\n', r->end - r->pos);

	r->overlong = !newline && r->input_status == FW_OK;
	take(r, newline ? (size_t)(newline + 1 - start) : r->end - r->pos, newline != NULL);
	return problem(r, 0, "", reason);
}

/* The rest of a line that was dropped before its end was seen. */
static void skip_overlong(fw_csv_reader *r)
{
	while (r->overlong) {
		const char *newline = memchr(r->buffer + r->pos, '\n', r->end - r->pos);
		r->pos = newline ? (size_t)(newline + 1 - r->buffer) : r->end;
		r->line += newline != NULL;
		r->overlong = !newline && more(r);
	}
}

/* Where a byte stands in a row. */
typedef enum {
	ROW_START,
	FIELD_START,
	BARE,
	QUOTED,
	QUOTE_IN_QUOTED,
	BEHIND_QUOTED,
	META,
	DONE,
	BROKEN
} place;

/* The place behind byte c. Quotes count at the start of a field only, and in no line with #. */
static place step(place at, char c)
{
	switch (at) {
	case QUOTED: return c == '"' ? QUOTE_IN_QUOTED : QUOTED;
	case META: return c == '\n' ? DONE : META;
	case QUOTE_IN_QUOTED:
	case BEHIND_QUOTED:
		if (c == '"' && at == QUOTE_IN_QUOTED)
			return QUOTED;
		return c == ',' ? FIELD_START : c == '\n' ? DONE : c == '\r' ? BEHIND_QUOTED : BROKEN;
	case ROW_START:
		if (c == '#')
			return META;
		/* fall through */
	case FIELD_START:
		if (c == '"')
			return QUOTED;
		/* fall through */
	default: return c == ',' ? FIELD_START : c == '\n' ? DONE : BARE;
	}
}

/* What ends the input without a line break. A stream's last line has one, so there it is half a row. */
static fw_status last_row(fw_csv_reader *r, place at, span *row)
{
	if (r->pos == r->end || r->input_status == FW_EIO)
		return FW_EOF; /* a read that failed or was interrupted says nothing about the row */
	if (at == QUOTED)
		return drop_line(r, "a quote that is not closed");
	if (r->stream || r->input_status != FW_EOF)
		return drop_line(r, "the input ends inside this row");
	*row = take(r, r->end - r->pos, 0);
	return FW_OK;
}

/* The next row with a quote in it or not yet wholly read. */
static fw_status next_row_stepwise(fw_csv_reader *r, span *row)
{
	place at = ROW_START;
	size_t n = 0;
	uint64_t newlines = 0;

	while (at != DONE) {
		if (r->pos + n == r->end && !more(r))
			return last_row(r, at, row);
		const char c = r->buffer[r->pos + n++];
		newlines += c == '\n';
		at = step(at, c);
		if (at == BROKEN)
			return drop_line(r, "text behind a closing quote");
		if (n > FW_CSV_LINE_MAX)
			return drop_line(r, at == QUOTED ? "a quote that is not closed" : "line too long");
	}
	*row = take(r, n, newlines);
	return FW_OK;
}

/* The next row, up to the first line break outside quotes, without that. FW_EOF: there is none. */
static fw_status next_row(fw_csv_reader *r, span *row)
{
	skip_overlong(r);
	const char *start = r->buffer + r->pos;
	const char *newline = memchr(start, '\n', r->end - r->pos);
	const size_t n = newline ? (size_t)(newline + 1 - start) : 0;

	if (newline && n <= FW_CSV_LINE_MAX && !memchr(start, '"', n)) {
		*row = take(r, n, 1);
	} else {
		const fw_status status = next_row_stepwise(r, row);
		if (status != FW_OK)
			return status;
	}
	if (row->n > 0 && row->p[row->n - 1] == '\n')
		row->n--;
	if (row->n > 0 && row->p[row->n - 1] == '\r')
		row->n--;
	return FW_OK;
}

/* ---- Reading: fields ---------------------------------------------------------------------------------- */

/* Splits the first field off a row (row->p becomes NULL behind the last), without its quotes and with a NUL
 * behind it. The row's quotes are known to be in order. */
static span next_field(span *row)
{
	char *const start = row->p, *const end = row->p + row->n;
	const bool quoted = row->n > 0 && *start == '"';
	char *stop = start, *to = start;

	if (quoted) {
		for (stop++; stop < end && (*stop != '"' || (stop + 1 < end && stop[1] == '"')); stop++) {
			stop += *stop == '"'; /* of two quotes, the second */
			*to++ = *stop;
		}
	}
	char *const comma = memchr(stop, ',', (size_t)(end - stop));
	if (!quoted)
		to = comma ? comma : end;
	*row = comma ? (span){comma + 1, (size_t)(end - comma - 1)} : (span){NULL, 0};
	*to = '\0';
	return (span){start, (size_t)(to - start)};
}

static void store_integer(fw_column_type type, int64_t x, void *member)
{
	const int32_t i4 = (int32_t)x;
	const int16_t i2 = (int16_t)x;
	const int8_t i1 = (int8_t)x;

	switch (type) {
	case FW_I8: memcpy(member, &i1, sizeof i1); break;
	case FW_I16: memcpy(member, &i2, sizeof i2); break;
	case FW_I32: memcpy(member, &i4, sizeof i4); break;
	default: memcpy(member, &x, sizeof x); break;
	}
}

/* Reads a whole number that fits the type. */
static fw_status get_integer(fw_column_type type, const span *field, int64_t *x)
{
	static const int64_t most[] = {
	    [FW_I8] = INT8_MAX, [FW_I16] = INT16_MAX, [FW_I32] = INT32_MAX, [FW_I64] = INT64_MAX};
	const fw_status status = fw_get_i64(field->p, field->n, x);

	if (status == FW_OK && (*x > most[type] || *x < -most[type] - 1))
		return FW_ERANGE;
	return status;
}

/* Puts a field into its column of the record. Returns NULL, or what is wrong with it. */
static const char *set_column(const fw_column *c, const span *field, fw_any_record *record)
{
	char *const member = record->bytes + c->offset;
	fw_status status = FW_OK;
	int64_t i;
	double d;
	float f;

	switch (c->type) {
	case FW_STR: memcpy(member, &field->p, sizeof field->p); return NULL;
	case FW_F64:
		if ((status = fw_get_double(field->p, field->n, &d)) == FW_OK)
			memcpy(member, &d, sizeof d);
		break;
	case FW_F32:
		if ((status = fw_get_float(field->p, field->n, &f)) == FW_OK)
			memcpy(member, &f, sizeof f);
		break;
	default:
		if ((status = get_integer(c->type, field, &i)) == FW_OK)
			store_integer(c->type, i, member);
		else if (status == FW_ESYNTAX)
			return "not a whole number";
	}
	return status == FW_OK ? NULL : status == FW_ERANGE ? "number out of range" : "not a number";
}

/* A row's fields become a record. `field` is the number of its first field in the file. */
static fw_status read_row(fw_csv_reader *r, fw_kind kind, span row, int field, fw_any_record *record)
{
	const fw_record_type *type = fw_record_type_of(kind);

	if (row.p && memchr(row.p, '\0', row.n))
		return problem(r, 0, "", "a NUL byte");
	fw_record_clear(kind, record);
	for (int i = 0; i < r->n_fields[kind]; i++, field++) {
		if (!row.p)
			return problem(r, 0, "", "fewer fields than columns");
		const span text = next_field(&row);
		const int column = r->columns[kind][i];
		if (column < 0 || text.n == 0)
			continue;
		const char *reason = set_column(&type->columns[column], &text, record);
		if (reason)
			return problem(r, field, type->columns[column].name, reason);
		record->head.present |= INT64_C(1) << column;
	}
	return row.p ? problem(r, field, "", "more fields than columns") : FW_OK;
}

/* ---- Reading: headers --------------------------------------------------------------------------------- */

/* Column names of a header. */
typedef struct {
	int n;
	span name[FW_CSV_FIELDS_MAX];
} header;

static bool split_header(span line, header *h)
{
	for (h->n = 0; line.p && h->n < FW_CSV_FIELDS_MAX; h->n++)
		h->name[h->n] = next_field(&line);
	return !line.p;
}

/* Remembers which field is which column. `field` is the number of the first of them in the file. */
static fw_status keep_header(fw_csv_reader *r, fw_kind kind, const header *h, int field)
{
	const fw_record_type *type = fw_record_type_of(kind);
	uint64_t seen = 0;

	r->n_fields[kind] = 0;
	for (int i = 0; i < h->n; i++) {
		const int column = fw_record_column(type, h->name[i].p, h->name[i].n);
		if (column < 0 && r->unknown_columns++ == 0)
			snprintf(r->unknown, sizeof r->unknown, "%s", h->name[i].p);
		if (column >= 0 && seen >> column & 1)
			return problem(r, field + i, type->columns[column].name, "a column that comes twice");
		if (column >= 0)
			seen |= UINT64_C(1) << column;
		r->columns[kind][i] = (int8_t)column;
	}
	r->n_fields[kind] = h->n;
	return FW_OK;
}

/* How well a header fits a type: first the columns that it has, then those that it lacks. Week and time of
 * week, which all types have, say nothing; 0: nothing else fits. */
static int fit(const fw_record_type *type, const header *h)
{
	int known = 0;

	for (int i = 0; i < h->n; i++)
		known += fw_record_column(type, h->name[i].p, h->name[i].n) >= 2;
	return known ? known * (FW_MAX_COLUMNS + 1) - (type->n_columns - known) : 0;
}

/* Whether b is what a is, at an external event: event_pvt has the columns of pvt. */
static bool is_event_of(fw_kind a, fw_kind b)
{
	const char *name = fw_record_type_of(b)->name;

	return strncmp(name, "event_", 6) == 0 && strcmp(name + 6, fw_record_type_of(a)->name) == 0;
}

/* The type of a table. FW_RECORD_COUNT: *reason says why none. */
static fw_kind recognise(const header *h, const char **reason)
{
	fw_kind best = FW_RECORD_COUNT;
	bool tie = false;
	int best_fit = 0;

	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++) {
		const int f = fit(fw_record_type_of(kind), h);
		if (f > best_fit) {
			best = kind;
			best_fit = f;
			tie = false;
		} else if (f == best_fit && f > 0 && !is_event_of(best, kind)) {
			tie = true;
		}
	}
	*reason = tie ? "these columns fit several types of record"
	              : "no line of column names that fit a type of record";
	return tie ? FW_RECORD_COUNT : best;
}

static fw_status fatal(fw_csv_reader *r, const char *reason)
{
	(void)problem(r, r->problem.field, r->problem.column, reason);
	return r->final = FW_EUNKNOWN;
}

static fw_status begin_table(fw_csv_reader *r, span line)
{
	const char *reason = "none of the columns that are wanted here";
	header h;

	if (!split_header(line, &h))
		return fatal(r, "too many columns");
	if (r->wanted == FW_RECORD_COUNT)
		r->table = recognise(&h, &reason);
	else if (fit(fw_record_type_of(r->wanted), &h) > 0)
		r->table = r->wanted;
	if (r->table == FW_RECORD_COUNT)
		return fatal(r, reason);
	if (keep_header(r, r->table, &h, 1) != FW_OK)
		return fatal(r, r->problem.reason);
	return FW_MORE;
}

static bool is(span line, const char *text)
{
	return line.n == strlen(text) && memcmp(line.p, text, line.n) == 0;
}

/* The first line of all. */
static fw_status begin_reading(fw_csv_reader *r, span line)
{
	r->begun = true;
	if (line.p[0] != '#')
		return begin_table(r, line);
	r->stream = true;
	if (is(line, STREAM_LINE))
		return FW_MORE;
	return fatal(r, "not a stream of a version that furrow knows");
}

/* ---- Reading: streams --------------------------------------------------------------------------------- */

/* A stream may follow another one (`cat a b`): types are announced anew. */
static fw_status begin_again(fw_csv_reader *r)
{
	const bool cut = !r->ended;

	memset(r->n_fields, 0, sizeof r->n_fields);
	r->ended = false;
	r->partial |= cut;
	return cut ? problem(r, 0, "", "a stream begins before the one before it has ended") : FW_MORE;
}

/* "obs,gps_week,...": of a type that furrow does not know, the rows will tell. */
static fw_status read_announcement(fw_csv_reader *r, span line)
{
	const span name = next_field(&line);
	const fw_kind kind = fw_record_find(name.p, name.n);
	header h;

	if (kind == FW_RECORD_COUNT)
		return FW_MORE;
	if (!split_header(line, &h))
		return problem(r, 0, "", "too many columns");
	const fw_status status = keep_header(r, kind, &h, 2);
	return status == FW_OK ? FW_MORE : status;
}

/* A line with #. FW_MORE: nothing for the caller in it. */
static fw_status read_meta(fw_csv_reader *r, span line, fw_kind *kind, fw_any_record *record)
{
	furrow_meta meta = {.present = 0xc};

	if (memchr(line.p, '\0', line.n))
		return problem(r, 0, "", "a NUL byte");
	if (is(line, STREAM_LINE))
		return begin_again(r);
	line.p[line.n] = '\0';
	meta.key = line.p + 1;
	meta.value = meta.key + strcspn(meta.key, " ,");
	if (*meta.value == ',')
		return read_announcement(r, (span){meta.key, line.n - 1});
	if (*meta.value == ' ')
		*meta.value++ = '\0';
	if (strcmp(meta.key, "end") == 0) {
		r->ended = true;
		r->partial |= fw_record_end(meta.value, &r->skipped);
		return FW_MORE;
	}
	*kind = FW_meta;
	memcpy(record, &meta, sizeof meta);
	return FW_OK;
}

static fw_status read_stream_row(fw_csv_reader *r, span row, fw_kind *kind, fw_any_record *record)
{
	if (r->ended)
		return problem(r, 0, "", "a row behind the stream's end");
	const span name = next_field(&row);
	const fw_kind k = fw_record_find(name.p, name.n);
	if (k == FW_RECORD_COUNT || r->n_fields[k] == 0)
		return problem(r, 1, "",
		               "a type of record that furrow does not know or that was not announced");
	const fw_status status = read_row(r, k, row, 2, record);
	if (status == FW_OK)
		*kind = k;
	return status;
}

/* ---- Reading: all -------------------------------------------------------------------------------------- */

/* The mark that some editors put before a text in UTF-8. */
static void skip_byte_order_mark(fw_csv_reader *r)
{
	while (r->end < 3 && more(r))
		;
	if (r->end >= 3 && memcmp(r->buffer, "\xef\xbb\xbf", 3) == 0)
		r->pos = 3;
}

static fw_status finish(fw_csv_reader *r)
{
	r->final = r->input_status;
	if (r->final == FW_EOF && r->stream && !r->ended)
		r->final = FW_ETRUNCATED;
	return r->final;
}

/* Whatever a line is. Counts rows; FW_MORE: nothing for the caller in it. */
static fw_status read_line(fw_csv_reader *r, span line, fw_kind *kind, fw_any_record *record)
{
	fw_status status;

	if (line.n == 0)
		return FW_MORE;
	if (!r->begun)
		return begin_reading(r, line);
	if (r->stream && line.p[0] == '#')
		return read_meta(r, line, kind, record);
	if (r->stream) {
		status = read_stream_row(r, line, kind, record);
	} else {
		status = read_row(r, r->table, line, 1, record);
		if (status == FW_OK)
			*kind = r->table;
	}
	r->rows += status == FW_OK;
	return status;
}

fw_status fw_csv_read(fw_csv_reader *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status = r->final;
	span line = {NULL, 0};

	if (status == FW_OK && !r->begun && r->pos == 0)
		skip_byte_order_mark(r);
	while (r->final == FW_OK) {
		status = next_row(r, &line);
		if (status == FW_EOF)
			return finish(r);
		if (status == FW_OK)
			status = read_line(r, line, kind, record);
		if (status == FW_MORE)
			continue;
		r->lost += status == FW_ESYNTAX;
		break;
	}
	return status;
}
