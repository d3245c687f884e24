/* SBF framing: from a stream of bytes to whole, checked blocks (protocol: Septentrio SBF reference guide,
 * section 1).
 *
 * A block is `$@`, CRC, id, length, body. The framer hands out each block whose CRC matches, skips
 * everything else (NMEA, RTCM, zeros, noise), and resumes one byte behind a sync pair that led nowhere, so
 * a false header never costs a block. It also finds out what the skipped bytes were: a damaged block is a
 * loss and counted as one; foreign bytes between blocks are no loss.
 *
 * Time is linear in the input whatever it holds. A claim that fails its CRC leaves running CRCs behind for
 * the bytes it covers, and every later claim in there is settled from two of them (fw_crc16_range()).
 * Memory is the struct.
 *
 * A claim is settled only when all its bytes are there, so a false header on a live pipe holds back what
 * follows it, for at most 65,532 bytes: the price of an output that does not depend on how the bytes
 * happen to arrive. */
#ifndef FURROW_FORMATS_SBF_FRAME_H
#define FURROW_FORMATS_SBF_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "formats/input.h"

enum {
	FW_SBF_HEADER = 8,      /* sync 2, CRC 2, id and revision 2, length 2 */
	FW_SBF_LONGEST = 65532, /* the largest multiple of 4 in a u2 */
	FW_SBF_BUFFER =
	    128 * 1024, /* two of the longest blocks: what must be moved is never more than what was used */
	FW_SBF_MARKS = 32, /* places remembered in a skipped region */
};

/* Do-not-use values of the time stamp, also given for blocks too short to hold one. */
#define FW_SBF_NO_TOW  UINT32_MAX
#define FW_SBF_NO_WEEK UINT16_MAX

/* One block whose CRC matches. */
typedef struct {
	const uint8_t *data; /* all of it, from the `$`; valid until the next call with this framer */
	size_t length;       /* 8 .. 65,532, a multiple of 4 */
	uint16_t id;         /* block number, 13 bits */
	uint8_t revision;    /* 0 .. 7 */
	uint16_t week;       /* GPS week, continuous; FW_SBF_NO_WEEK */
	uint32_t tow_ms;     /* time of week [ms]; FW_SBF_NO_TOW */
	uint64_t offset;     /* of data[0] in the (uncompressed) input */
} fw_sbf_block;

/* One block that did not survive. */
typedef struct {
	uint64_t offset;  /* where it starts */
	uint16_t id;      /* what its header says; 0 when its header is damaged */
	fw_status status; /* FW_ECHECKSUM: the CRC does not match; FW_EFORMAT: the header is damaged;
			     FW_ETRUNCATED: the input ends inside it */
} fw_sbf_loss;

/* Called for each loss, in the order of the input and before the first block behind it is handed out. */
typedef void fw_sbf_loss_fn(void *context, const fw_sbf_loss *loss);

/* bytes_good + bytes_skipped = all bytes of the input, once it has ended. Blocks lost: blocks_damaged +
 * truncated. */
typedef struct {
	uint64_t blocks;         /* handed out */
	uint64_t bytes_good;     /* in these */
	uint64_t bytes_skipped;  /* outside of them: foreign bytes and damaged blocks */
	uint64_t blocks_damaged; /* see fw_sbf_next() */
	uint64_t resyncs;        /* skipped regions */
	unsigned truncated;      /* 1: the input ends inside a block */
} fw_sbf_stats;

/* A time stamp to compare headers with. */
typedef struct {
	bool known;
	uint16_t week;
	int64_t ms; /* since 1980-01-06 */
} fw_sbf_stamp;

/* A place in a skipped region where a block may have started. */
typedef struct {
	uint64_t at;         /* offset in the input */
	uint16_t id, length; /* as the header says */
	uint8_t sync;        /* bit 0: `$` is there, bit 1: `@` */
	uint8_t size;        /* header bytes that the input had, up to 14 */
	bool expected;       /* a block, or a claim, ends right here */
	fw_sbf_stamp stamp;
	/* While a region is judged: its claim ends where something starts; or behind the end; it was a
	 * block. */
	bool exact, cut, good;
} fw_sbf_mark;

/* Owned by the caller: about 390 KiB. Only stats is for reading; the rest is private. */
typedef struct {
	fw_sbf_stats stats;

	fw_input *in;
	fw_sbf_loss_fn *on_loss;
	void *context;
	fw_status status; /* FW_OK until the input ends or fails */

	/* buffer[pos .. end) is still to be looked at; buffer[0] is byte `base` of the input. */
	uint64_t base;
	size_t pos, end;

	/* Running CRCs: state[i - crc_first] is the CRC of buffer[crc_first .. i), for i up to crc_last. */
	size_t crc_first, crc_last;

	/* The region that is being skipped. */
	uint64_t region; /* where it starts */
	uint64_t judged; /* up to here everything is accounted for */
	uint64_t expect; /* the next place where a claim of one of the marks ends */
	size_t n_marks;
	fw_sbf_mark marks[FW_SBF_MARKS];
	fw_sbf_stamp last; /* time stamp of the last good block that had one */

	uint8_t buffer[FW_SBF_BUFFER];
	uint16_t state[FW_SBF_BUFFER + 1];
} fw_sbf_framer;

/* Get ready to read blocks from in, which must outlive the framer.
 *   on_loss  called for each loss, with context; may be NULL */
void fw_sbf_init(fw_sbf_framer *f, fw_input *in, fw_sbf_loss_fn *on_loss, void *context);

/* The next block.
 *   b  out  untouched unless FW_OK
 * Returns FW_OK; FW_EOF; or, once every block in front of the failure has been handed out, what
 * fw_input_read() says: FW_EIO, FW_EFORMAT, FW_ETRUNCATED, FW_ENOMEM. After the first status other than
 * FW_OK it stays.
 *
 * A block is accepted when `$@`, a length that is a multiple of 4 and at least 8, and the CRC agree.
 *
 * Skipped bytes count as a damaged block when enough of its header is left. Evidence is counted in bits:
 * the sync pair 18, one byte of it 8; a length that leads to the next block 16, one byte of such a length
 * 8, room for a multiple of 4 bytes 2; a known id 4; a time stamp in the week of the blocks around 16,
 * within a day of them 20, within an hour 25. It takes 20 where a block is due, 30 elsewhere. So any
 * damage to the body, to the CRC, or to up to eight adjacent bytes of the header is counted as the one
 * block that it is, next to other damaged blocks too (in trials, all but 1 of 60,000). Bytes inserted
 * between blocks are not counted; random ones look like a block about once in 200,000 insertions. The
 * front half of another block, inserted, is a damaged block. A last block whose length was damaged upwards
 * cannot be told from one that was cut: it counts as truncated. */
fw_status fw_sbf_next(fw_sbf_framer *f, fw_sbf_block *b) FW_MUST_CHECK;

#endif
