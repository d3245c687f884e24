#include "formats/nav_message.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "formats/nav_bits.h"
#include "formats/sbf_signal.h"

/* The columns that every record here begins with: gps_week, tow_s, sat, source. */
enum { SAT = 2, SOURCE = 3, HEAD_COLUMNS = 4 };

static const fw_column *find(fw_kind kind, const char *name, int64_t *bit)
{
	const fw_record_type *type = fw_record_type_of(kind);
	const int i = fw_record_column(type, name, strlen(name));

	assert(i >= 0);
	*bit = INT64_C(1) << i;
	return &type->columns[i];
}

void fw_nav_put(fw_kind kind, void *record, const char *name, double value)
{
	int64_t bit;
	const fw_column *column = find(kind, name, &bit);
	void *member = (char *)record + column->offset;

	switch (column->type) {
	case FW_I8: *(int8_t *)member = (int8_t)value; break;
	case FW_I16: *(int16_t *)member = (int16_t)value; break;
	case FW_I32: *(int32_t *)member = (int32_t)value; break;
	case FW_F32: *(float *)member = (float)value; break;
	case FW_F64: *(double *)member = value; break;
	default: assert(0 && "a number"); return;
	}
	((fw_record_head *)record)->present |= bit;
}

void fw_nav_remove(fw_kind kind, void *record, const char *name)
{
	int64_t bit;

	find(kind, name, &bit);
	fw_nav_put(kind, record, name, 0);
	((fw_record_head *)record)->present &= ~bit;
}

int32_t fw_nav_week_of(int64_t now_ms, int32_t tow_s)
{
	/* The start of the week that puts tow_s between half a week before and half a week after now. */
	const int64_t half = FW_NAV_WEEK_MS / 2;
	const int64_t start = now_ms + half - (int64_t)tow_s * 1000;

	return (int32_t)(start >= 0 ? start / FW_NAV_WEEK_MS : -1);
}

static double field_value(const fw_nav_store *store, const fw_nav_field *field)
{
	const double unit = field->unit != 0 ? field->unit : 1;
	uint32_t raw = 0;
	unsigned width = 0;
	double number;

	if (field->coding == FW_NAV_CONSTANT)
		return unit;
	for (int i = 0; i < 2 && field->part[i].width > 0; i++) {
		const fw_nav_part *part = &field->part[i];
		const uint8_t *bits = store->pages[part->page].bits;
		const uint32_t piece = fw_bits_unsigned(bits, FW_NAV_PAGE_BYTES, part->first, part->width);
		raw = i == 0 ? piece : raw << part->width | piece;
		width += part->width;
	}
	if (field->coding == FW_NAV_SIGN_MAGNITUDE)
		number = fw_bits_sign_magnitude(raw, width);
	else
		number = field->coding == FW_NAV_SIGNED ? (double)fw_bits_twos_complement(raw, width) : raw;
	return ldexp(number, field->power) * unit;
}

/* FNV-1a over the columns behind the head: two contents that differ share a fingerprint once in 2^64. */
static uint64_t fingerprint(fw_kind kind, const void *record)
{
	static const uint8_t size[] = {[FW_I8] = 1, [FW_I16] = 2, [FW_I32] = 4, [FW_F32] = 4, [FW_F64] = 8};
	const fw_record_type *type = fw_record_type_of(kind);
	const uint8_t *bytes = record;
	uint64_t hash = UINT64_C(14695981039346656037);

	for (int i = HEAD_COLUMNS; i < type->n_columns; i++) {
		const fw_column *column = &type->columns[i];
		const bool present = ((const fw_record_head *)record)->present >> i & 1;
		hash = (hash ^ present) * UINT64_C(1099511628211);
		for (unsigned b = 0; b < size[column->type]; b++)
			hash = (hash ^ bytes[column->offset + b]) * UINT64_C(1099511628211);
	}
	return hash | 1; /* 0 means "nothing emitted yet" */
}

/* Have all needed pages been received, close enough to each other, and within the last hour? (Almanac data of
 * a satellite that has set must not bring its old ephemeris back.) */
static bool complete(const fw_nav_layout *message, const fw_nav_store *store, int64_t now_ms)
{
	int64_t first = INT64_MAX, last = INT64_MIN;

	if ((store->have & message->pages) != message->pages)
		return false;
	for (int i = 0; i < FW_NAV_PAGES; i++) {
		if (!(message->pages >> i & 1))
			continue;
		const int64_t begin = store->pages[i].begin_ms;
		first = begin < first ? begin : first;
		last = begin > last ? begin : last;
	}
	return last - first <= message->within_ms && now_ms - last <= 3600000;
}

static bool build(const fw_nav_layout *message, const fw_nav_store *store, int64_t now_ms, void *record)
{
	for (int i = 0; i < message->n_fields; i++) {
		const fw_nav_field *field = &message->fields[i];
		if (field->coding == FW_NAV_CONSTANT || store->have >> field->part[0].page & 1)
			fw_nav_put(message->kind, record, field->column, field_value(store, field));
	}
	return !message->finish || message->finish(store, now_ms, record);
}

/* The head: the stamp, the satellite and where the record is from. */
static void put_head(fw_kind kind, int64_t now_ms, char *sat, char *source, fw_any_record *record)
{
	const fw_column *columns = fw_record_type_of(kind)->columns;

	record->head.present |= (1 << HEAD_COLUMNS) - 1;
	record->head.gps_week = (int32_t)(now_ms / FW_NAV_WEEK_MS);
	record->head.tow_s = (double)(now_ms % FW_NAV_WEEK_MS) / 1000;
	*(char **)(void *)(record->bytes + columns[SAT].offset) = sat;
	*(char **)(void *)(record->bytes + columns[SOURCE].offset) = source;
}

/* Hands the message out unless its content is what was handed out last. Returns false when it cannot be
 * built: its pages do not belong together. */
static bool emit(const fw_nav_layout *message, const fw_nav_arrival *arrival, int64_t now_ms,
                 const fw_nav_store *store, uint64_t *sent, const fw_sink *sink)
{
	fw_any_record record = {0};
	char sat[8] = "", source[] = "raw"; /* copies: lcm-gen wants its strings as char * */

	if (!build(message, store, now_ms, &record))
		return false;
	const uint64_t hash = fingerprint(message->kind, &record);
	if (hash == *sent)
		return true;
	*sent = hash;
	memcpy(sat, fw_sbf_satellite(arrival->svid), 4);
	put_head(message->kind, now_ms, sat, source, &record);
	sink->put(sink->context, message->kind, &record);
	return true;
}

void fw_nav_take(const fw_nav_system *system, const fw_nav_arrival *arrival, int64_t now_ms,
                 fw_nav_store *store, const fw_sink *sink)
{
	fw_nav_page *kept = &store->pages[arrival->index];
	const uint16_t bit = (uint16_t)(1U << arrival->index);
	const bool news =
	    !(store->have & bit) || memcmp(kept->bits, arrival->page.bits, sizeof kept->bits) != 0;

	*kept = arrival->page;
	store->have |= bit;
	for (int m = 0; m < system->n_messages; m++) {
		const fw_nav_layout *message = &system->messages[m];
		const uint16_t flag = (uint16_t)(1U << m);
		if (!((message->pages | message->extra) & bit))
			continue;
		if (news)
			store->pending |= flag;
		if (store->pending & flag && complete(message, store, now_ms) &&
		    emit(message, arrival, now_ms, store, &store->sent[m], sink))
			store->pending &= (uint16_t)~flag;
	}
}
