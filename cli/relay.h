/* A thread of its own for the writer: records are handed over in batches, so that one core decodes while another
 * writes numbers. The order of the records, and so the output, is the same with and without it. */
#ifndef FURROW_CLI_RELAY_H
#define FURROW_CLI_RELAY_H

#include <pthread.h>
#include <stdbool.h>

#include "formats/record.h"

/* Together they stay in a core's cache. To wake the other thread takes longer than a batch: a thread that waits is woken
 * when half of them are there for it. */
enum { RELAY_BATCHES = 8, RELAY_BATCH = 16 * 1024, RELAY_STRINGS = 16 };

/* Owned by the caller: 256 KiB, static. */
typedef struct {
	fw_sink to;
	bool running;
	pthread_t thread;
	pthread_mutex_t lock;
	pthread_cond_t changed;
	unsigned filled, emptied; /* batches handed over, and taken, so far */
	bool stopping;
	struct {
		uint8_t n;
		uint16_t member[RELAY_STRINGS]; /* offsets in the struct [bytes] */
	} strings[FW_RECORD_COUNT];
	struct {
		size_t used;
		_Alignas(16) char bytes[RELAY_BATCH];
	} batch[RELAY_BATCHES]; /* batch[filled % RELAY_BATCHES] is being filled */
} relay;

/* Starts the thread. Returns where records are to be put: into the relay, or, if there can be no thread, into `to`
 * itself. From here to relay_stop() only the thread may touch what is behind `to`, save just after relay_drain(). */
fw_sink relay_start(relay *r, fw_sink to);

/* Puts n bytes that are no record, between the records: they come out as kind FW_RECORD_COUNT. The relay must be running. */
void relay_bytes(relay *r, const void *bytes, size_t n);

/* Waits until all records put so far have come out at the other end. */
void relay_drain(relay *r);

/* The same, and ends the thread. Harmless if there is none. */
void relay_stop(relay *r);

#endif
