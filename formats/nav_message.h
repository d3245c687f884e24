/* What the decoders of all navigation messages have in common: pages are kept until a set of them is
 * complete, and a table says which bits of which page become which column of a record.
 *
 * A system (GPS LNAV, Galileo I/NAV, BeiDou D1, ...) is one function that checks a page and says which of the
 * pages it is, and the list of messages that its pages make up. The rest is done here: a record is handed out
 * when a set first becomes complete and consistent, and again only when its content has changed.
 *
 * The values equal those of the receiver's own decoded blocks: raw integers times a power of two are exact,
 * columns of type float hold the same float, and angles are semi-circles times GPS's own pi in double. */
#ifndef FURROW_FORMATS_NAV_MESSAGE_H
#define FURROW_FORMATS_NAV_MESSAGE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "formats/record.h"

enum {
	FW_NAV_WORDS = 10,      /* most words of a raw page block */
	FW_NAV_PAGE_BYTES = 32, /* room for the bits of a page that are kept */
	FW_NAV_PAGES = 11,      /* most pages of one system that are kept per satellite (D2) */
	FW_NAV_MESSAGES = 4     /* most messages of one system */
};

/* IS-GPS-200, 20.3.3.4.3.2; the ICDs of Galileo and BeiDou have the same number. */
#define FW_GPS_PI 3.1415926535898

#define FW_NAV_WEEK_MS INT64_C(604800000)

/* A raw page as the receiver hands it on. */
typedef struct {
	uint8_t svid;                    /* SBF's number of the satellite */
	uint8_t channel;                 /* GLONASS: k + 8; 0 unknown */
	int64_t end_ms;                  /* GPS time at which its last bit was sent [ms since 1980-01-06] */
	uint32_t words[FW_NAV_WORDS];    /* NAVBits; those that the block lacks are 0 */
	uint8_t bytes[4 * FW_NAV_WORDS]; /* the same as one string of bits, first bit first */
} fw_nav_raw;

/* A page that is kept. Bits that change from page to page without meaning anything for a record (time of
 * week, telemetry) are cleared, so that a page that says nothing new is equal to its predecessor. */
typedef struct {
	int64_t begin_ms; /* GPS time at which the frame began that it belongs to [ms] */
	uint8_t bits[FW_NAV_PAGE_BYTES];
} fw_nav_page;

/* A page on its way to the pages kept. */
typedef struct {
	int index;    /* which of the system's pages; -1: one that furrow does not need */
	uint8_t svid; /* the satellite that it tells of: the sender's, save for almanac data */
	fw_nav_page page;
} fw_nav_arrival;

/* What is kept of one satellite and system. Zero at the start. */
typedef struct {
	uint16_t have;                  /* bit i: pages[i] has been received */
	uint16_t pending;               /* bit m: pages of message m have changed since it was emitted */
	uint64_t sent[FW_NAV_MESSAGES]; /* fingerprint of the content emitted last; 0: nothing yet */
	fw_nav_page pages[FW_NAV_PAGES];
} fw_nav_store;

typedef enum { FW_NAV_UNSIGNED, FW_NAV_SIGNED, FW_NAV_SIGN_MAGNITUDE, FW_NAV_CONSTANT } fw_nav_coding;

/* A run of bits of a page. */
typedef struct {
	uint8_t page, first, width;
} fw_nav_part;

/* A column: the bits of part[0], followed by those of part[1], as a whole number (at most 32 bits) times
 * 2^power times unit. A unit of 0 stands for 1. FW_NAV_CONSTANT is `unit` itself. */
typedef struct {
	const char *column;
	uint8_t coding; /* fw_nav_coding */
	int8_t power;
	double unit;
	fw_nav_part part[2];
} fw_nav_field;

/* A message: the record that a set of pages makes. */
typedef struct {
	fw_kind kind;
	uint16_t pages;    /* bit i: page i is needed */
	uint16_t extra;    /* bit i: page i is used once it is there */
	int32_t within_ms; /* the frames of all needed pages began within this time of each other */
	int n_fields;
	const fw_nav_field *fields;
	/* Called with the record, columns of the table filled in: adds what a table cannot say. Returns false
	 * when the pages do not belong together or mean nothing. NULL: nothing to add. */
	bool (*finish)(const fw_nav_store *store, int64_t now_ms, void *record);
} fw_nav_layout;

typedef struct {
	/* Checks a raw page and says which it is. FW_OK (arrival->index may be -1) or FW_ECHECKSUM. */
	fw_status (*unpack)(const fw_nav_raw *raw, fw_nav_arrival *arrival);
	int n_messages;
	const fw_nav_layout *messages;
} fw_nav_system;

/* Keeps a page and hands out the records that it completes or changes.
 *   store   in/out  what is kept of arrival->svid
 *   now_ms  in      GPS time of the block [ms]: the stamp of the records
 *   sink    in      gets the records; their strings live until it returns */
void fw_nav_take(const fw_nav_system *system, const fw_nav_arrival *arrival, int64_t now_ms,
                 fw_nav_store *store, const fw_sink *sink);

/* Gives a column of a record a value; the column must exist and take the value. */
void fw_nav_put(fw_kind kind, void *record, const char *column, double value);

/* Takes a column's value away: absent, 0. */
void fw_nav_remove(fw_kind kind, void *record, const char *column);

/* The week in which a second of week lies, the one nearest to a moment.
 *   now_ms  in  milliseconds since week 0 of that system's time
 *   tow_s   in  0..604799
 * Returns the full week; it may be -1 at the very beginning of the count. */
int32_t fw_nav_week_of(int64_t now_ms, int32_t tow_s);

#endif
