#include "formats/lcm_log.h"

#include <assert.h>
#include <endian.h>
#include <stdio.h>
#include <string.h>

#include "furrow_meta.h"

static const unsigned char sync_word[4] = {0xed, 0xa1, 0xda, 0x01};

static uint32_t load_u32(const unsigned char *p)
{
	uint32_t x;
	memcpy(&x, p, sizeof x);
	return be32toh(x);
}

static void store_u32(unsigned char *p, uint32_t x)
{
	x = htobe32(x);
	memcpy(p, &x, sizeof x);
}

static void store_i64(unsigned char *p, int64_t x)
{
	const uint64_t bits = htobe64((uint64_t)x);
	memcpy(p, &bits, sizeof bits);
}

/* ---- Reading ------------------------------------------------------------------------------------------ */

void fw_lcm_begin_read(fw_lcm_reader *r, fw_input *input)
{
	memset(r, 0, offsetof(fw_lcm_reader, buffer));
	r->input = input;
	r->reason = "";
}

/* Waits for n bytes at pos, at most FW_LCM_EVENT_MAX + 4. False when the input ends before. */
static bool need(fw_lcm_reader *r, size_t n)
{
	size_t got;

	while (r->end - r->pos < n) {
		if (r->input_status != FW_OK)
			return false;
		if (r->pos == r->end || r->pos + n > sizeof r->buffer) {
			memmove(r->buffer, r->buffer + r->pos, r->end - r->pos);
			r->end -= r->pos;
			r->pos = 0;
		}
		r->input_status =
		    fw_input_read(r->input, r->buffer + r->end, sizeof r->buffer - r->end, &got);
		r->end += got;
	}
	return true;
}

static void advance(fw_lcm_reader *r, size_t n)
{
	r->pos += n;
	r->offset += n;
}

/* Something is lost here; the search goes on n bytes further. */
static fw_status lose(fw_lcm_reader *r, size_t n, const char *reason)
{
	r->lost++;
	r->lost_offset = r->offset;
	r->reason = reason;
	r->searching = true;
	advance(r, n);
	return FW_ESYNTAX;
}

/* Nothing more will come. `inside`: the input ends in the midst of an event. */
static fw_status finish(fw_lcm_reader *r, bool inside)
{
	r->final = r->input_status;
	if (r->final == FW_EOF && (inside || (r->provenance && !r->ended)))
		r->final = FW_ETRUNCATED;
	return r->final;
}

/* Where the next sync is from pos + n on, NULL if there is none in the buffer. */
static const unsigned char *find_sync(const fw_lcm_reader *r, size_t n)
{
	return memmem(r->buffer + r->pos + n, r->end - r->pos - n, sync_word, sizeof sync_word);
}

/* Goes to the next sync. FW_OK: it is at pos. */
static fw_status seek_sync(fw_lcm_reader *r)
{
	while (need(r, sizeof sync_word)) {
		if (memcmp(r->buffer + r->pos, sync_word, sizeof sync_word) == 0)
			return FW_OK;
		if (!r->searching)
			return lose(r, 0, "no event where one should begin");
		const unsigned char *at = find_sync(r, 0);
		advance(r, at ? (size_t)(at - r->buffer) - r->pos : r->end - r->pos - (sizeof sync_word - 1));
	}
	const bool inside = !r->searching && r->end > r->pos;
	advance(r, r->end - r->pos);
	return finish(r, inside);
}

/* The input ends before the event at pos does: it is cut short, or its lengths are wrong. */
static fw_status end_inside(fw_lcm_reader *r)
{
	if (find_sync(r, sizeof sync_word))
		return lose(r, sizeof sync_word, "an event that reaches beyond the end of the log");
	advance(r, r->end - r->pos);
	return finish(r, true);
}

/* Whether the event of n bytes at pos is followed by another one, or by the end. */
static bool is_followed(fw_lcm_reader *r, size_t n)
{
	const size_t left = need(r, n + sizeof sync_word) ? sizeof sync_word : r->end - r->pos - n;

	return memcmp(r->buffer + r->pos + n, sync_word, left) == 0;
}

/* The type of the channel with this name of n bytes. */
static fw_kind kind_of(const unsigned char *channel, size_t n)
{
	char name[FW_LCM_CHANNEL_MAX];

	if (n < 7 || memcmp(channel, "FURROW_", 7) != 0)
		return FW_RECORD_COUNT;
	for (size_t i = 7; i < n; i++)
		name[i - 7] =
		    (char)(channel[i] >= 'A' && channel[i] <= 'Z' ? channel[i] - 'A' + 'a' : channel[i]);
	return fw_record_find(name, n - 7);
}

/* Keeps what a FURROW_META record says about the log itself. FW_MORE: it is not for the caller. */
static fw_status note_meta(fw_lcm_reader *r, const furrow_meta *meta)
{
	if (strcmp(meta->key, "pg") == 0) {
		r->provenance = true;
		r->ended = false; /* one log behind another */
	}
	if (strcmp(meta->key, "end") != 0)
		return FW_OK;
	r->ended = true;
	r->partial |= fw_record_end(meta->value, &r->skipped);
	return FW_MORE;
}

/* The event at pos, which begins with the sync. FW_MORE: nothing for the caller in it. */
static fw_status read_event(fw_lcm_reader *r, fw_kind *kind, fw_any_record *record)
{
	if (!need(r, FW_LCM_HEADER))
		return end_inside(r);
	const size_t n_channel = load_u32(r->buffer + r->pos + 20),
	             n_data = load_u32(r->buffer + r->pos + 24);
	if (n_channel > FW_LCM_CHANNEL_MAX || n_data > FW_LCM_DATA_MAX)
		return lose(r, sizeof sync_word, "an event with an impossible length");
	const size_t n = FW_LCM_HEADER + n_channel + n_data;
	if (!need(r, n))
		return end_inside(r);

	const unsigned char *channel = r->buffer + r->pos + FW_LCM_HEADER;
	const fw_kind k = kind_of(channel, n_channel);
	const bool ours = k != FW_RECORD_COUNT;
	const bool good = ours && fw_record_decode(k, channel + n_channel, n_data, record) == FW_OK;
	if (!good && !is_followed(r, n))
		return lose(r, sizeof sync_word, "an event with a wrong length");
	if (!good && ours)
		return lose(r, n, "an event that is not what its channel says");
	advance(r, n);
	r->searching = false;
	r->foreign += !ours;
	if (!ours)
		return FW_MORE;
	*kind = k;
	r->rows += k != FW_meta;
	return k == FW_meta ? note_meta(r, (const furrow_meta *)record) : FW_OK;
}

fw_status fw_lcm_read(fw_lcm_reader *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status = r->final;

	while (r->final == FW_OK) {
		status = seek_sync(r);
		if (status == FW_OK)
			status = read_event(r, kind, record);
		if (status != FW_MORE)
			break;
	}
	return status;
}

/* ---- Writing ------------------------------------------------------------------------------------------ */

enum { FLUSH_AT = 64 * 1024 };
static_assert(FLUSH_AT + FW_LCM_WRITE_MAX <= FW_LCM_BUFFER, "room for any event");

void fw_lcm_begin(fw_lcm_writer *w, fw_output *output, void *context)
{
	memset(w, 0, offsetof(fw_lcm_writer, buffer));
	w->output = output;
	w->context = context;
}

static fw_status flush(fw_lcm_writer *w)
{
	if (w->status == FW_OK && w->used > 0)
		w->status = w->output(w->context, w->buffer, w->used);
	w->used = 0;
	return w->status;
}

fw_status fw_lcm_flush(fw_lcm_writer *w)
{
	return w->timed ? flush(w) : w->status;
}

/* Gives the events that wait in the buffer the first time that is known. */
static void stamp_waiting(fw_lcm_writer *w)
{
	for (size_t at = 0; at < w->used;) {
		unsigned char *event = w->buffer + at;
		store_i64(event + 12, w->unix_us);
		at += FW_LCM_HEADER + load_u32(event + 20) + load_u32(event + 24);
	}
}

static void keep_time(fw_lcm_writer *w, const fw_any_record *record)
{
	fw_time t;

	if (fw_record_time(record, &t) < 0 || fw_time_to_unix_us(t, &w->unix_us) < 0)
		return;
	if (!w->timed)
		stamp_waiting(w);
	w->timed = true;
}

void fw_lcm_put(void *writer, fw_kind kind, const void *record)
{
	fw_lcm_writer *w = writer;
	const fw_record_type *type = fw_record_type_of(kind);
	const size_t n_channel = strlen(type->channel);
	unsigned char *event = w->buffer + w->used;
	unsigned char *data = event + FW_LCM_HEADER + n_channel;
	fw_any_record copy;
	size_t n;

	if (w->status != FW_OK)
		return;
	memcpy(&copy, record, type->size);
	fw_record_round(kind, &copy);
	if (fw_record_encode(kind, &copy, data, FW_LCM_WRITE_MAX - FW_LCM_HEADER - n_channel, &n) != FW_OK) {
		w->refused++;
		return;
	}
	keep_time(w, &copy);
	memcpy(event, sync_word, sizeof sync_word);
	store_i64(event + 4, w->number++);
	store_i64(event + 12, w->unix_us);
	store_u32(event + 20, (uint32_t)n_channel);
	store_u32(event + 24, (uint32_t)n);
	memcpy(event + FW_LCM_HEADER, type->channel, n_channel);
	w->used += FW_LCM_HEADER + n_channel + n;
	w->rows += kind != FW_meta;
	if (w->used >= FLUSH_AT)
		(void)flush(w); /* latched */
}

void fw_lcm_meta(fw_lcm_writer *w, const char *key, const char *value)
{
	furrow_meta meta = {.present = 0xc};

	/* lcm-gen declares strings as char *, though nobody writes to them. */
	memcpy(&meta.key, &key, sizeof key);
	memcpy(&meta.value, &value, sizeof value);
	fw_lcm_put(w, FW_meta, &meta);
}

fw_status fw_lcm_end(fw_lcm_writer *w, bool complete, uint64_t skipped)
{
	char text[96];

	snprintf(text, sizeof text, "status=%s rows=%llu skipped=%llu", complete ? "complete" : "partial",
	         (unsigned long long)w->rows, (unsigned long long)skipped);
	fw_lcm_meta(w, "end", text);
	return flush(w);
}
