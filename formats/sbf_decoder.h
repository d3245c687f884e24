/* SBF blocks to records: the one way in. Each block goes to the code that knows it: the measurement blocks, the
 * raw navigation pages and SBAS messages, the few blocks that need more than a table, and all others by the schema.
 * What an epoch says in several blocks (position, its covariance, that of the velocity) becomes one record, which
 * leaves when the time tag of the receiver's epoch changes or fw_sbf_decoder_flush() is called: end markers are
 * welcome but not waited for. An epoch that a log holds both as MeasEpoch and as Meas3 is taken from MeasEpoch. */
#ifndef FURROW_FORMATS_SBF_DECODER_H
#define FURROW_FORMATS_SBF_DECODER_H

#include "formats/nav.h"
#include "formats/record.h"
#include "formats/sbf_frame.h"
#include "formats/sbf_meas3.h"
#include "formats/sbf_measurements.h"
#include "formats/sbf_records.h"

/* Where navigation records come from: bits. */
enum { FW_NAV_DECODED = 1, FW_NAV_RAW = 2 };

typedef struct {
	fw_kind_set wanted;
	unsigned antennas;    /* FW_ANTENNA_... */
	unsigned nav_sources; /* FW_NAV_... */
} fw_sbf_decoder_options;

enum { FW_SBF_IDS = 8192 };

/* Records that are put together from several blocks: pvt, pvt_ecef, att, imu. */
enum { FW_SBF_MERGED = 4 };

/* For reading; complete after fw_sbf_decoder_flush(). */
typedef struct {
	uint64_t unknown;         /* blocks of a number whose layout furrow does not know */
	fw_sbf_left_out left_out; /* observations */
	uint64_t scrambled;       /* measurement epochs that only Septentrio can read */
	uint64_t no_reference;    /* Meas3 epochs whose reference epoch is missing */
	uint64_t malformed;       /* blocks with a good CRC whose counts contradict their length */
	uint64_t bad_pages;       /* raw pages and messages that fail their own checksum or parity */
} fw_sbf_decoder_stats;

/* Owned by the caller. Only stats is for reading. */
typedef struct {
	fw_sbf_decoder_stats stats;

	fw_sbf_decoder_options options;
	fw_sink sink;
	fw_sbf_plans plans;
	fw_sbf_channels channels;
	fw_sbf_meas3 meas3;
	fw_nav nav;
	uint8_t actions[FW_SBF_IDS]; /* what is to be done with a block, by its number; decided once */
	bool seen[FW_SBF_IDS];       /* block numbers that came */
	uint32_t epoch_tow_ms;       /* the receiver epoch that is open */
	uint16_t epoch_week;
	struct {
		unsigned parts; /* which of the blocks that make the record are in it; 0: none */
		fw_any_record record;
	} pending[FW_SBF_MERGED];
} fw_sbf_decoder;

void fw_sbf_decoder_init(fw_sbf_decoder *d, const fw_sbf_decoder_options *options, fw_sink sink);

/* Takes the next block of a log; its CRC has been checked. Records go to the sink. */
void fw_sbf_decoder_put(fw_sbf_decoder *d, const fw_sbf_block *block);

/* Closes the epoch that is open: at the end of a log. */
void fw_sbf_decoder_flush(fw_sbf_decoder *d);

/* Adds the record types that the blocks so far could have become, wanted or not. */
void fw_sbf_decoder_offered(const fw_sbf_decoder *d, fw_kind_set *offered);

/* The names of the record types that a block becomes, separated by blanks; "" when it is only counted. */
const char *fw_sbf_decoder_records(uint16_t id);

#endif
