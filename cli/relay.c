#include "relay.h"

#include <signal.h>
#include <string.h>

/* In a batch: this, the record's struct, its strings; and so on, each from a multiple of 16. */
typedef struct {
	fw_kind kind;
	uint32_t length; /* to the next one [bytes] */
} item;

enum { ITEM = 16 };

static size_t aligned(size_t n)
{
	return (n + 15) / 16 * 16;
}

static void empty_batch(const relay *r, const char *bytes, size_t used)
{
	for (size_t at = 0; at < used;) {
		item it;
		memcpy(&it, bytes + at, sizeof it);
		r->to.put(r->to.context, it.kind, bytes + at + ITEM);
		at += it.length;
	}
}

static void *run(void *context)
{
	relay *r = context;
	pthread_mutex_lock(&r->lock);
	for (;;) {
		while (r->emptied == r->filled && !r->stopping)
			pthread_cond_wait(&r->changed, &r->lock);
		if (r->emptied == r->filled)
			break;
		unsigned i = r->emptied % RELAY_BATCHES;
		pthread_mutex_unlock(&r->lock);
		empty_batch(r, r->batch[i].bytes, r->batch[i].used);
		pthread_mutex_lock(&r->lock);
		r->batch[i].used = 0;
		r->emptied++;
		if (r->filled - r->emptied <= RELAY_BATCHES / 2)
			pthread_cond_broadcast(&r->changed);
	}
	pthread_mutex_unlock(&r->lock);
	return NULL;
}

/* Hands the batch over and waits until there is a next one to fill. */
static void hand_over(relay *r)
{
	pthread_mutex_lock(&r->lock);
	r->filled++;
	if (r->filled - r->emptied >= RELAY_BATCHES / 2)
		pthread_cond_broadcast(&r->changed);
	while (r->filled - r->emptied == RELAY_BATCHES)
		pthread_cond_wait(&r->changed, &r->lock);
	pthread_mutex_unlock(&r->lock);
}

static void find_strings(relay *r)
{
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++) {
		const fw_record_type *type = fw_record_type_of(kind);
		r->strings[kind].n = 0;
		for (int i = 0; i < type->n_columns; i++)
			if (type->columns[i].type == FW_STR)
				r->strings[kind].member[r->strings[kind].n++] = type->columns[i].offset;
	}
}

/* What an item needs, strings included; the length of each of these, with its end, is left in lengths. NULL: 0. */
static size_t item_length(const relay *r, fw_kind kind, const char *record, size_t lengths[RELAY_STRINGS])
{
	size_t n = ITEM + fw_record_type_of(kind)->size;
	for (unsigned i = 0; i < r->strings[kind].n; i++) {
		const char *text;
		memcpy(&text, record + r->strings[kind].member[i], sizeof text);
		lengths[i] = text != NULL ? strlen(text) + 1 : 0;
		n += lengths[i];
	}
	return aligned(n);
}

/* A record's struct at `copy`, its strings behind it. */
static void put_record(const relay *r, char *copy, fw_kind kind, const char *record,
                       const size_t lengths[RELAY_STRINGS])
{
	const size_t size = fw_record_type_of(kind)->size;
	char *text = copy + size;
	memcpy(copy, record, size);
	for (unsigned i = 0; i < r->strings[kind].n; i++) {
		const char *from;
		char *member = copy + r->strings[kind].member[i];
		if (lengths[i] == 0)
			continue;
		memcpy(&from, member, sizeof from);
		memcpy(member, &text, sizeof text);
		memcpy(text, from, lengths[i]);
		text += lengths[i];
	}
}

/* Room for an item of this length, its head filled in; NULL: it is larger than any batch, and all before it has come out
 * at the other end. */
static char *begin_item(relay *r, fw_kind kind, size_t length)
{
	const item it = {kind, (uint32_t)length};
	if (length > RELAY_BATCH) {
		relay_drain(r);
		return NULL;
	}
	if (length > RELAY_BATCH - r->batch[r->filled % RELAY_BATCHES].used)
		hand_over(r);
	const unsigned i = r->filled % RELAY_BATCHES;
	char *p = r->batch[i].bytes + r->batch[i].used;
	r->batch[i].used += length;
	memcpy(p, &it, sizeof it);
	return p + ITEM;
}

static void put(void *context, fw_kind kind, const void *record)
{
	relay *r = context;
	size_t lengths[RELAY_STRINGS];
	char *room = begin_item(r, kind, item_length(r, kind, record, lengths));
	if (room != NULL)
		put_record(r, room, kind, record, lengths);
	else
		r->to.put(r->to.context, kind, record);
}

void relay_bytes(relay *r, const void *bytes, size_t n)
{
	char *room = begin_item(r, FW_RECORD_COUNT, aligned(ITEM + n));
	if (room != NULL)
		memcpy(room, bytes, n);
	else
		r->to.put(r->to.context, FW_RECORD_COUNT, bytes);
}

fw_sink relay_start(relay *r, fw_sink to)
{
	sigset_t ours, before;
	r->to = to;
	r->filled = r->emptied = 0;
	r->stopping = false;
	find_strings(r);
	for (int i = 0; i < RELAY_BATCHES; i++)
		r->batch[i].used = 0;
	pthread_mutex_init(&r->lock, NULL);
	pthread_cond_init(&r->changed, NULL);
	sigemptyset(&ours); /* to stop is for the thread that reads; a broken pipe is the writer's */
	sigaddset(&ours, SIGINT);
	sigaddset(&ours, SIGTERM);
	pthread_sigmask(SIG_BLOCK, &ours, &before);
	r->running = pthread_create(&r->thread, NULL, run, r) == 0;
	pthread_sigmask(SIG_SETMASK, &before, NULL);
	return r->running ? (fw_sink){put, r} : to;
}

void relay_drain(relay *r)
{
	if (!r->running)
		return;
	if (r->batch[r->filled % RELAY_BATCHES].used > 0)
		hand_over(r);
	pthread_mutex_lock(&r->lock);
	pthread_cond_broadcast(&r->changed);
	while (r->emptied != r->filled)
		pthread_cond_wait(&r->changed, &r->lock);
	pthread_mutex_unlock(&r->lock);
}

void relay_stop(relay *r)
{
	if (!r->running)
		return;
	relay_drain(r);
	pthread_mutex_lock(&r->lock);
	r->stopping = true;
	pthread_cond_broadcast(&r->changed);
	pthread_mutex_unlock(&r->lock);
	pthread_join(r->thread, NULL);
	r->running = false;
}
