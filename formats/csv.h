/* Records as text: tables (RFC 4180, one type, first line the column names) and streams (many types; see
 * furrow-stream(5)).
 *
 *     #furrow-stream 1
 *     #pg tool=sbf2csv version=0.1.0 cl=sbf2csv -s flight.sbf
 *     #cfg antenna=main
 *     #obs,gps_week,tow_s,sat,...           announces a type before its first row
 *     obs,2345,482321.2,G05,...
 *     #end status=complete rows=1 skipped=0
 *
 * An empty field is an absent column. Strings are UTF-8, quoted when they hold a comma, a quote or a control
 * character; a line break inside quotes is part of its field. Columns are found by name, in any order.
 *
 * Writer and reader belong to the caller, hold their buffers themselves (about 270 KiB each, too much for
 * small stacks), work on pipes and use no heap. */
#ifndef FURROW_FORMATS_CSV_H
#define FURROW_FORMATS_CSV_H

#include <stdbool.h>

#include "formats/input.h"
#include "formats/record.h"

enum {
	/* Longest row [bytes]. The longest that a receiver can cause is 65,500 quotes in a comment, doubled. */
	FW_CSV_LINE_MAX = 160 * 1024,
	FW_CSV_BUFFER = 256 * 1024,
	FW_CSV_FIELDS_MAX = 256, /* columns that a table may have, unknown ones included */
};

/* ---- Writing ---- */

typedef struct {
	/* Public to read. */
	fw_status status; /* FW_OK, or the first failure of `output`; after it nothing more is written */
	uint64_t rows;    /* rows written; lines with # do not count */
	uint64_t refused; /* records left out because their row would be longer than FW_CSV_LINE_MAX */

	/* Private from here. */
	fw_output *output;
	void *context;
	fw_kind only;                    /* the table's type; FW_RECORD_COUNT: a stream */
	bool announced[FW_RECORD_COUNT]; /* types whose # line is out */
	fw_record_head time;             /* the last row's week and time of week, */
	size_t time_length;              /* and their text, which the next row most likely shares */
	char time_text[400];
	size_t used;
	char buffer[FW_CSV_BUFFER];
} fw_csv_writer;

/* Begin a table of one type (the line of column names is its first), or a stream.
 *   w        out  ready for fw_csv_put(); fw_csv_end() it
 *   output   in   gets the text, some 64 KiB at a time
 *   context  in   passed on to it
 * Cannot fail: an output that fails shows in w->status. */
void fw_csv_begin_table(fw_csv_writer *w, fw_kind kind, fw_output *output, void *context);
void fw_csv_begin_stream(fw_csv_writer *w, fw_output *output, void *context);

/* Write a record: the `put` of a fw_sink whose context is the writer. A table passes over records of other
 * types. In a stream a FW_meta record becomes a line `#key value`, unless its key would make it another line.
 * A number that is not finite is written as absent; a byte that is not UTF-8 is written as '?'. Failures are
 * latched in w->status. */
void fw_csv_put(void *writer, fw_kind kind, const void *record);

/* Write the line `#key value`: provenance ("pg"), settings ("cfg"). Control characters become blanks.
 * A table has no such lines: nothing happens. */
void fw_csv_meta(fw_csv_writer *w, const char *key, const char *value);

/* Hand all rows so far to the output: when the input pauses. Returns w->status. */
fw_status fw_csv_flush(fw_csv_writer *w) FW_MUST_CHECK;

/* The last line of a stream, and the last flush.
 *   complete  in   false when the output is known to lack something, because the input did
 *   skipped   in   how many units of the input were lost
 * Returns w->status. */
fw_status fw_csv_end(fw_csv_writer *w, bool complete, uint64_t skipped) FW_MUST_CHECK;

/* ---- Reading ---- */

/* What was wrong, for a message "FILE:line: column COLUMN (NAME): REASON". */
typedef struct {
	uint64_t line;      /* from 1 */
	int field;          /* from 1, as the file counts its columns; 0: the row as a whole */
	const char *column; /* name of that column, "" when there is none */
	const char *reason; /* a few words of English */
} fw_csv_problem;

typedef struct {
	/* Public to read. */
	bool stream;            /* a stream (else a table): known after the first fw_csv_read() */
	bool partial;           /* a writer upstream marked its stream as partial */
	uint64_t skipped;       /* and how many units it had lost */
	fw_kind table;          /* a table's type */
	uint64_t rows;          /* rows read */
	uint64_t lost;          /* rows lost */
	fw_csv_problem problem; /* why the last fw_csv_read() failed */
	int unknown_columns;    /* columns whose names furrow does not know; they are passed over */
	char unknown[64];       /* the first of them */

	/* Private from here. */
	fw_input *input;
	fw_kind wanted;
	fw_status input_status; /* FW_OK until the input ends or fails */
	fw_status final;        /* FW_OK until nothing more will come */
	bool begun, ended, overlong;
	uint64_t line; /* of the next row */
	size_t pos, end;
	int n_fields[FW_RECORD_COUNT]; /* columns that the type's header has; 0: not seen */
	int8_t columns[FW_RECORD_COUNT][FW_CSV_FIELDS_MAX]; /* field to column; -1: unknown */
	char buffer[FW_CSV_BUFFER + 1];
} fw_csv_reader;

/* Begin to read a table or a stream, whichever it is.
 *   input   in  open; read to its end, the caller closes it
 *   wanted  in  the type that a table must have, or FW_RECORD_COUNT: found from the column names, as the type
 *               that knows most of them and lacks fewest; of two types with the same columns (pvt and
 *               event_pvt) the one that is no event */
void fw_csv_begin_read(fw_csv_reader *r, fw_input *input, fw_kind wanted);

/* The next record.
 *   kind    out  its type; FW_meta: a line `#key value` of a stream (`#end` is not handed out)
 *   record  out  its strings point into the reader, until the next call
 * Returns
 *   FW_OK          a record
 *   FW_ESYNTAX     a row is lost: r->problem says why; call again
 *   FW_EOF         the end; of a stream, after its #end line
 *   FW_ETRUNCATED  the end, but a stream without its #end line, or a gzip file that is cut short
 *   FW_EUNKNOWN    a header with which nothing can be done (r->problem): no or several types have these
 *                  columns, a column comes twice, too many columns, a version of the stream that furrow does
 *                  not know
 *   FW_EIO, FW_EFORMAT, FW_ENOMEM   from fw_input_read()
 * The last four and FW_EOF are final. kind and record are set with FW_OK only.
 * A row that ends the file without a line break may be cut short: a stream loses it, a table takes it. */
fw_status fw_csv_read(fw_csv_reader *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

#endif
