/* LCM event logs: the files of lcm-logger, lcm-logplayer and lcm.EventLog, read and written without seeking.
 *
 * An event is, all numbers big-endian:
 *     0   u4   ED A1 DA 01
 *     4   i8   event number
 *     12  i8   timestamp, microseconds of Unix time (UTC)
 *     20  i4   length of the channel's name
 *     24  i4   length of the data
 *     28  the name, without NUL; then the data
 * Source: liblcm 1.3.1, lcm/eventlog.c.
 *
 * furrow writes each record as one event on channel FURROW_ + TYPE. What the lines with # are in a stream are
 * FURROW_META records here; the last one has the key "end".
 *
 * Reader and writer belong to the caller, hold their own buffers (2.1 MiB and 260 KiB) and use no heap. */
#ifndef FURROW_FORMATS_LCM_LOG_H
#define FURROW_FORMATS_LCM_LOG_H

#include <stdbool.h>

#include "formats/input.h"
#include "formats/record.h"

enum {
	FW_LCM_HEADER = 28,
	FW_LCM_CHANNEL_MAX = 63,   /* longest name of a channel; LCM_MAX_CHANNEL_NAME_LENGTH */
	FW_LCM_DATA_MAX = 1 << 20, /* longest data that the reader takes; longer ones are damage */
	FW_LCM_EVENT_MAX = FW_LCM_HEADER + FW_LCM_CHANNEL_MAX + FW_LCM_DATA_MAX,
	FW_LCM_WRITE_MAX = 160 * 1024, /* longest event that the writer makes */
	FW_LCM_BUFFER = 256 * 1024,
};

/* ---- Reading ---- */

typedef struct {
	/* Public to read. */
	bool partial;         /* a writer upstream marked its log as partial */
	uint64_t skipped;     /* and how many units it had lost */
	uint64_t rows;        /* records read, FURROW_META not among them */
	uint64_t foreign;     /* events on channels that are not furrow's */
	uint64_t lost;        /* damaged events, and stretches between events that are none */
	uint64_t lost_offset; /* where the last of these was [bytes] */
	const char *reason;   /* and what was wrong there, a few words of English */

	/* Private from here. */
	fw_input *input;
	fw_status input_status; /* FW_OK until the input ends or fails */
	fw_status final;        /* FW_OK until nothing more will come */
	bool provenance, ended; /* a FURROW_META with key pg, end was there */
	bool searching;         /* for the next sync, because of a loss that has been counted */
	uint64_t offset;        /* of buffer[pos] in the input */
	size_t pos, end;
	unsigned char buffer[2 * FW_LCM_EVENT_MAX];
} fw_lcm_reader;

/* Begin to read a log.
 *   input  in  open; read to its end, the caller closes it */
void fw_lcm_begin_read(fw_lcm_reader *r, fw_input *input);

/* The next record. An event is believed when it decodes as what its channel says, down to the last byte; one
 * on a channel that furrow does not know when another event, or the end, follows it. Otherwise only its sync
 * is skipped and the search goes on behind that: wrong lengths cost no other event.
 *   kind    out  its type; FW_meta for provenance (key "end" is not handed out)
 *   record  out  its strings point into the reader, until the next call
 * Returns
 *   FW_OK          a record
 *   FW_ESYNTAX     an event is lost: r->lost_offset and r->reason say where and why; call again
 *   FW_EOF         the end
 *   FW_ETRUNCATED  the end, but inside an event, of a log that a furrow tool began and did not end (key "pg",
 *                  but no "end"), or of a gzip file that is cut short
 *   FW_EIO, FW_EFORMAT, FW_ENOMEM   from fw_input_read()
 * The last four and FW_EOF are final. kind and record are set with FW_OK only. */
fw_status fw_lcm_read(fw_lcm_reader *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

/* ---- Writing ---- */

typedef struct {
	/* Public to read. */
	fw_status status; /* FW_OK, or the first failure of `output`; after it nothing more is written */
	uint64_t rows;    /* records written, FURROW_META not among them */
	uint64_t refused; /* records left out because their event would be longer than FW_LCM_WRITE_MAX */

	/* Private from here. */
	fw_output *output;
	void *context;
	bool timed;      /* a record with a time has been seen */
	int64_t unix_us; /* the last one's */
	int64_t number;  /* of the next event */
	size_t used;
	unsigned char buffer[FW_LCM_BUFFER];
} fw_lcm_writer;

/* Begin a log. Cannot fail: an output that fails shows in w->status.
 *   output, context  in  gets the events, some 64 KiB at a time */
void fw_lcm_begin(fw_lcm_writer *w, fw_output *output, void *context);

/* Write a record, rounded as fw_record_round() does, so that a log and a stream hold the same: the `put` of a
 * fw_sink whose context is the writer. Its timestamp is its own time; without one, that of the record before,
 * and at the beginning of the log that of the first record that has one, so that a player does not wait for
 * decades. */
void fw_lcm_put(void *writer, fw_kind kind, const void *record);

/* Write a FURROW_META record: provenance ("pg"), settings ("cfg"). */
void fw_lcm_meta(fw_lcm_writer *w, const char *key, const char *value);

/* Hand all events so far to the output: when the input pauses. Events that still wait for a time stay.
 * Returns w->status. */
fw_status fw_lcm_flush(fw_lcm_writer *w) FW_MUST_CHECK;

/* The FURROW_META record "end" and the last flush; arguments as fw_csv_end(). Returns w->status. */
fw_status fw_lcm_end(fw_lcm_writer *w, bool complete, uint64_t skipped) FW_MUST_CHECK;

#endif
