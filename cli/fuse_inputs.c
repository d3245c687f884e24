#include "fuse_inputs.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "record_copy.h"

enum {
	BATCHES = 2,
	BATCH = 128 * 1024,
	RECENT = 4,         /* records whose times make the horizon */
	LEAP_RECORDS = 128, /* a leap of it is believed when so many records come from beyond */
	POLL_MS = 50,       /* how long to wait before looking for signals, and flushing */
	FAREWELL_MS = 1000  /* for a reader that waits for a live pipe */
};

/* In a batch: this, then the record's copy, and so on, each from a multiple of 16. */
typedef struct {
	fw_kind kind;
	uint32_t length; /* to the next one [bytes] */
} item;

enum { ITEM = 16 };

struct fuse_source {
	/* Of both threads, under the lock. */
	pthread_mutex_t lock;
	pthread_cond_t changed;
	unsigned filled, emptied; /* batches handed over, and given back, so far */
	bool ended;               /* the reader has put its last record */
	_Atomic bool unwanted;    /* nobody will take any more */
	struct {
		size_t used;
		_Alignas(16) char bytes[BATCH];
	} batch[BATCHES]; /* batch[filled % BATCHES] is being filled */

	/* Of the reader, and of everyone once it has ended. */
	pthread_t thread;
	const char *path;
	source_plan plan;
	tool tool; /* its own count of messages */
	source_totals totals;
	uint64_t too_long;
	int status;

	/* Of the one who takes. */
	bool finished;
	bool holding; /* batch[emptied % BATCHES] is being emptied, up to `at` */
	size_t at;
	unsigned n_recent, leaping;
	int64_t recent[RECENT], horizon, latest;
	fw_kind_set timed; /* types that have had a time */
};

/* ---- the reader's side ---- */

/* Hands the batch over and waits until there is a next one to fill. */
static void hand_over(fuse_source *s)
{
	pthread_mutex_lock(&s->lock);
	s->filled++;
	pthread_cond_broadcast(&s->changed);
	while (s->filled - s->emptied == BATCHES && !s->unwanted)
		pthread_cond_wait(&s->changed, &s->lock);
	pthread_mutex_unlock(&s->lock);
}

static void put(void *context, fw_kind kind, const void *record)
{
	fuse_source *s = context;
	const size_t length = (ITEM + record_copy_size(kind, record) + 15) / 16 * 16;
	if (s->unwanted)
		return;
	if (length > BATCH) {
		s->too_long++;
		return;
	}
	if (length > BATCH - s->batch[s->filled % BATCHES].used)
		hand_over(s);
	if (s->unwanted)
		return;
	const unsigned i = s->filled % BATCHES;
	char *p = s->batch[i].bytes + s->batch[i].used;
	const item it = {kind, (uint32_t)length};
	memcpy(p, &it, sizeof it);
	record_copy(kind, record, p + ITEM);
	s->batch[i].used += length;
}

/* The input pauses: what has come so far goes on. */
static void pause_reading(void *context)
{
	fuse_source *s = context;
	if (s->batch[s->filled % BATCHES].used > 0 && !s->unwanted)
		hand_over(s);
}

static void *run(void *context)
{
	fuse_source *s = context;
	s->status = source_read(&s->tool, s->path, &s->plan, (fw_sink){put, s}, &s->totals);
	pause_reading(s);
	pthread_mutex_lock(&s->lock);
	s->ended = true;
	pthread_cond_broadcast(&s->changed);
	pthread_mutex_unlock(&s->lock);
	return NULL;
}

/* ---- the taker's side ---- */

void fuse_inputs_begin(fuse_inputs *in, tool *owner, sink_set *sinks)
{
	*in = (fuse_inputs){.owner = owner, .sinks = sinks};
	record_copy_prepare();
}

static void release(fuse_source *s)
{
	if (s != NULL)
		source_readers_free(s->plan.readers);
	free(s);
}

int fuse_inputs_add(fuse_inputs *in, const char *path, const source_plan *plan)
{
	if (in->n == FUSE_SOURCES) {
		tool_error(in->owner, "%s: more than %d files", path, FUSE_SOURCES);
		return EXIT_USAGE;
	}
	int error = ENOMEM;
	fuse_source *s = calloc(1, sizeof *s);
	if (s != NULL) {
		s->path = path;
		s->plan = *plan;
		s->plan.readers = source_readers_new();
		s->plan.pause = pause_reading;
		s->plan.pause_context = s;
		s->tool = *in->owner;
		memset(s->tool.repeats, 0, sizeof s->tool.repeats);
		s->horizon = s->latest = INT64_MIN / 4; /* so that it can be taken off times */
		pthread_mutex_init(&s->lock, NULL);
		pthread_cond_init(&s->changed, NULL);
		if (s->plan.readers != NULL)
			error = pthread_create(&s->thread, NULL, run, s);
	}
	if (error == 0) {
		in->source[in->n++] = s;
		return EXIT_COMPLETE;
	}
	tool_error(in->owner, "%s: %s", path, strerror(error));
	release(s);
	return EXIT_IO;
}

static struct timespec in_ms(int ms)
{
	struct timespec t;
	clock_gettime(CLOCK_REALTIME, &t);
	t.tv_nsec += ms * 1000000L;
	t.tv_sec += t.tv_nsec / 1000000000;
	t.tv_nsec %= 1000000000;
	return t;
}

static bool must_stop(const fuse_inputs *in)
{
	return tool_interrupted() || (in->sinks != NULL && sinks_failed(in->sinks));
}

/* Waits for a batch, or for the end. Returns false when it is time to stop. */
static bool wait_for(fuse_inputs *in, fuse_source *s)
{
	bool flushed = in->sinks == NULL;
	pthread_mutex_lock(&s->lock);
	while (s->filled == s->emptied && !s->ended && !must_stop(in)) {
		const struct timespec until = in_ms(POLL_MS);
		if (pthread_cond_timedwait(&s->changed, &s->lock, &until) == ETIMEDOUT && !flushed) {
			pthread_mutex_unlock(&s->lock);
			sinks_flush(in->sinks);
			flushed = true;
			pthread_mutex_lock(&s->lock);
		}
	}
	s->holding = s->filled != s->emptied;
	pthread_mutex_unlock(&s->lock);
	return !must_stop(in);
}

static void give_back(fuse_source *s)
{
	pthread_mutex_lock(&s->lock);
	s->batch[s->emptied % BATCHES].used = 0;
	s->emptied++;
	pthread_cond_broadcast(&s->changed);
	pthread_mutex_unlock(&s->lock);
	s->holding = false;
	s->at = 0;
}

/* The horizon is the earliest of the last few stamps, if that is not far ahead of where it was: then some more have to say so. */
static void note_time(fuse_source *s, fw_time t)
{
	s->recent[s->n_recent++ % RECENT] = t.ns;
	int64_t earliest = s->recent[0];
	for (int i = 1; i < RECENT; i++)
		earliest = s->recent[i] < earliest ? s->recent[i] : earliest;
	if (earliest - s->horizon > FUSE_LEAP_NS && ++s->leaping < LEAP_RECORDS)
		return;
	s->leaping = 0;
	s->horizon = earliest;
	s->latest = earliest > s->latest ? earliest : s->latest;
}

/* The last stamp of all has none after it to speak against it. */
static void finish(fuse_source *s)
{
	s->finished = true;
	if (s->n_recent > 0 && s->recent[(s->n_recent - 1) % RECENT] > s->latest)
		s->latest = s->recent[(s->n_recent - 1) % RECENT];
}

/* The next record of a source. Returns false at its end. */
static bool take(fuse_source *s, fuse_record *r)
{
	const char *bytes = s->batch[s->emptied % BATCHES].bytes + s->at;
	item it;
	memcpy(&it, bytes, sizeof it);
	s->at += it.length;
	r->kind = it.kind;
	r->record = bytes + ITEM;
	const fw_status status = it.kind != FW_meta ? fw_record_time(r->record, &r->time) : FW_EINVAL;
	r->timed = status >= 0;
	r->mistimed = !r->timed && (status != FW_EINVAL || fw_kind_in(&s->timed, it.kind));
	if (r->timed) {
		fw_kind_add(&s->timed, it.kind);
		note_time(s, r->time);
	}
	return true;
}

static fuse_source *furthest_behind(const fuse_inputs *in)
{
	fuse_source *behind = NULL;
	for (unsigned i = 0; i < in->n; i++) {
		fuse_source *s = in->source[i];
		if (!s->finished && (behind == NULL || s->horizon < behind->horizon))
			behind = s;
	}
	return behind;
}

bool fuse_inputs_next(fuse_inputs *in, fuse_record *r)
{
	fuse_source *s;
	while ((s = furthest_behind(in)) != NULL) {
		if (s->holding && s->at >= s->batch[s->emptied % BATCHES].used)
			give_back(s);
		if (!s->holding && !wait_for(in, s))
			return false;
		if (s->holding)
			return take(s, r);
		finish(s);
	}
	return false;
}

fw_time fuse_inputs_horizon(const fuse_inputs *in)
{
	const fuse_source *s = furthest_behind(in);
	return (fw_time){s != NULL ? s->horizon : INT64_MAX};
}

fw_time fuse_inputs_latest(const fuse_inputs *in)
{
	int64_t latest = INT64_MIN / 4;
	for (unsigned i = 0; i < in->n; i++)
		latest = in->source[i]->latest > latest ? in->source[i]->latest : latest;
	return (fw_time){latest};
}

/* A reader may be waiting for a live pipe: a signal ends its wait, if that is why we end; if not, it stays behind
 * until the program ends. Returns false if it does. */
static bool join(fuse_source *s)
{
	pthread_mutex_lock(&s->lock);
	s->unwanted = true;
	pthread_cond_broadcast(&s->changed);
	pthread_mutex_unlock(&s->lock);
	for (int waited = 0; waited < FAREWELL_MS; waited += POLL_MS) {
		const struct timespec until = in_ms(POLL_MS);
		if (s->finished)
			return pthread_join(s->thread, NULL) == 0;
		if (pthread_timedjoin_np(s->thread, NULL, &until) == 0)
			return true;
		if (tool_interrupted())
			pthread_kill(s->thread, tool_interrupted());
	}
	return false;
}

static void add(source_totals *sum, const source_totals *t)
{
	sum->blocks += t->blocks;
	sum->records += t->records;
	sum->lost += t->lost;
	sum->bytes_skipped += t->bytes_skipped;
	sum->unknown += t->unknown;
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++)
		if (fw_kind_in(&t->offered, kind))
			fw_kind_add(&sum->offered, kind);
}

int fuse_inputs_end(fuse_inputs *in, source_totals *totals)
{
	int worst = EXIT_COMPLETE;
	for (unsigned i = 0; i < in->n; i++) {
		fuse_source *s = in->source[i];
		if (!join(s))
			continue;
		s->totals.lost += s->too_long;
		add(totals, &s->totals);
		for (int cause = 0; cause < CAUSE_COUNT; cause++)
			in->owner->repeats[cause] += s->tool.repeats[cause];
		worst = s->status > worst ? s->status : worst;
		worst = s->too_long > 0 && worst == EXIT_COMPLETE ? EXIT_PARTIAL : worst;
		pthread_mutex_destroy(&s->lock);
		pthread_cond_destroy(&s->changed);
		release(s);
	}
	in->n = 0;
	return worst;
}
