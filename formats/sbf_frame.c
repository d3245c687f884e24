#include "formats/sbf_frame.h"

#include <string.h>

#include "formats/crc.h"

enum {
	STAMPED = 14,  /* a header with its time stamp: TOW u4 at 8, WNc u2 at 12 */
	SMALLEST = 16, /* the same with padding: what any real block has at least */
	SYNC = 3,      /* both bits of fw_sbf_mark.sync */

	/* Evidence, in bits: fw_sbf_next() explains them. */
	PER_BYTE = 8,
	WHOLE_SYNC = 18,
	MULTIPLE_OF_4 = 2,
	KNOWN_ID = 4,
	SAME_WEEK = 16,
	SAME_DAY = 20,
	SAME_HOUR = 25,
	WHERE_DUE = 20,
	ANYWHERE = 30,
};

#define NEVER UINT64_MAX

static uint16_t get_u2(const uint8_t *p)
{
	return (uint16_t)(p[0] | p[1] << 8);
}

static uint32_t get_u4(const uint8_t *p)
{
	return (uint32_t)get_u2(p) | (uint32_t)get_u2(p + 2) << 16;
}

static bool plausible(size_t length)
{
	return length % 4 == 0 && length >= FW_SBF_HEADER;
}

/* The ranges that Septentrio has given out so far, with some room. */
static bool known_id(uint16_t id)
{
	return (id >= 4000 && id < 4300) || (id >= 5880 && id < 5970);
}

static fw_sbf_stamp stamp_of(const uint8_t *block, size_t size)
{
	fw_sbf_stamp stamp = {0};

	if (size < STAMPED)
		return stamp;
	stamp.week = get_u2(block + 12);
	stamp.known = stamp.week != FW_SBF_NO_WEEK;
	stamp.ms = (int64_t)stamp.week * 604800000 + get_u4(block + 8);
	return stamp;
}

void fw_sbf_init(fw_sbf_framer *f, fw_input *in, fw_sbf_loss_fn *on_loss, void *context)
{
	memset(f, 0, offsetof(fw_sbf_framer, buffer)); /* the buffers are written before they are read */
	f->in = in;
	f->on_loss = on_loss;
	f->context = context;
}

/* The buffer */

static void drop_used(fw_sbf_framer *f)
{
	memmove(f->buffer, f->buffer + f->pos, f->end - f->pos);
	f->base += f->pos;
	f->end -= f->pos;
	f->pos = 0;
	f->crc_first = f->crc_last = 0;
}

/* Are there n <= FW_SBF_LONGEST bytes from pos on? Reads until there are, or until the input ends. */
static bool have(fw_sbf_framer *f, size_t n)
{
	size_t got;

	while (f->end - f->pos < n) {
		if (f->status != FW_OK)
			return false;
		if (f->end == FW_SBF_BUFFER)
			drop_used(f);
		f->status = fw_input_read(f->in, f->buffer + f->end, FW_SBF_BUFFER - f->end, &got);
		f->end += got;
	}
	return true;
}

/* Does the CRC of the claim at pos match? Claims inside a range that has running CRCs are settled from
 * those; others by a CRC of their own, and when that fails the running CRCs of the whole claim are made.
 * So each byte of the buffer costs one failing CRC and one running CRC at most. */
static bool crc_matches(fw_sbf_framer *f, size_t length)
{
	const size_t from = f->pos + 4, to = f->pos + length;
	const uint16_t stated = get_u2(f->buffer + f->pos + 2);

	if (f->pos < f->crc_first || f->pos >= f->crc_last) {
		if (fw_crc16(f->buffer + from, length - 4) == stated)
			return true;
		f->crc_first = f->pos;
		f->crc_last = to;
		fw_crc16_prefix(0, f->buffer + f->pos, length, f->state);
		return false;
	}
	if (to > f->crc_last) {
		fw_crc16_prefix(f->state[f->crc_last - f->crc_first], f->buffer + f->crc_last,
		                to - f->crc_last, f->state + (f->crc_last - f->crc_first));
		f->crc_last = to;
	}
	return fw_crc16_range(f->state[from - f->crc_first], f->state[to - f->crc_first], length - 4) ==
	       stated;
}

/* The length of the block at pos; 0 when there is none. */
static size_t block_here(fw_sbf_framer *f)
{
	const uint8_t *p;
	size_t length;

	if (!have(f, FW_SBF_HEADER))
		return 0;
	p = f->buffer + f->pos;
	length = get_u2(p + 6);
	if (p[0] != '$' || p[1] != '@' || !plausible(length))
		return 0;
	return have(f, length) && crc_matches(f, length) ? length : 0;
}

/* Skipped regions: what was lost in them?
 *
 * While bytes are skipped, marks are set where a block may have started: where one is due (behind the last
 * block, and where a claim ends), at sync pairs, and where a time stamp fits those of the blocks before.
 * When the next block or the end is reached, the marks are judged by their evidence, the last one first,
 * because a claim is stronger when it leads to another block. */

/* Where the region that is judged ends: at a good block, at the end of the input, or not yet. */
enum boundary { AT_BLOCK, AT_END, OPEN };

static uint64_t claim_end(const fw_sbf_mark *k)
{
	return k->size >= FW_SBF_HEADER && plausible(k->length) ? k->at + k->length : NEVER;
}

static fw_sbf_mark read_mark(const fw_sbf_framer *f, bool expected)
{
	const uint8_t *p = f->buffer + f->pos;
	const size_t left = f->end - f->pos;
	fw_sbf_mark k = {.at = f->base + f->pos, .expected = expected};

	k.size = (uint8_t)(left < STAMPED ? left : STAMPED);
	k.sync = (uint8_t)((left >= 1 && p[0] == '$') | (left >= 2 && p[1] == '@') << 1);
	if (left >= FW_SBF_HEADER) {
		k.id = get_u2(p + 4) & 0x1fff;
		k.length = get_u2(p + 6);
	}
	k.stamp = stamp_of(p, left);
	return k;
}

static int time_evidence(const fw_sbf_stamp *a, const fw_sbf_stamp *b)
{
	const int64_t apart = a->ms > b->ms ? a->ms - b->ms : b->ms - a->ms;

	if (!a->known || !b->known)
		return 0;
	if (apart <= 86400000)
		return apart <= 3600000 ? SAME_HOUR : SAME_DAY;
	return a->week == b->week ? SAME_WEEK : 0;
}

static bool starts_something(const fw_sbf_mark *k)
{
	return k->good || k->sync == SYNC;
}

/* Does the claim of mark i end where something else starts? */
static bool leads_on(const fw_sbf_framer *f, size_t i, uint64_t end, enum boundary boundary)
{
	const uint64_t claim = claim_end(&f->marks[i]);

	if (boundary != OPEN && claim == end)
		return true;
	for (size_t j = i + 1; j < f->n_marks && f->marks[j].at <= claim; j++)
		if (f->marks[j].at == claim)
			return starts_something(&f->marks[j]);
	return false;
}

/* The length that a block at mark i must have had if its length field is wrong: up to the next start. */
static uint64_t room_of(const fw_sbf_framer *f, size_t i, uint64_t end)
{
	for (size_t j = i + 1; j < f->n_marks; j++)
		if (starts_something(&f->marks[j]))
			return f->marks[j].at - f->marks[i].at;
	return end - f->marks[i].at;
}

/* Is mark k, whose evidence is given, a block that goes on behind the end of the input? */
static bool is_cut(const fw_sbf_mark *k, int evidence, uint64_t end)
{
	const uint8_t sync = k->size >= 2 ? SYNC : 1;

	if (k->size >= FW_SBF_HEADER && (claim_end(k) <= end || claim_end(k) == NEVER))
		return false;
	if (evidence >= ANYWHERE)
		return true;
	return k->sync == sync && (k->expected || k->size < STAMPED);
}

static int header_evidence(const fw_sbf_mark *k, const fw_sbf_stamp *before, const fw_sbf_stamp *behind)
{
	const int a = time_evidence(&k->stamp, before), b = time_evidence(&k->stamp, behind);
	const int sync = k->sync == SYNC ? WHOLE_SYNC : k->sync != 0 ? PER_BYTE : 0;

	return sync + (known_id(k->id) ? KNOWN_ID : 0) + (a > b ? a : b);
}

/* How well does the length field fit the room up to the next start? */
static int length_evidence(const fw_sbf_mark *k, uint64_t room)
{
	if (k->exact)
		return 2 * PER_BYTE;
	return ((room & 0xff) == (k->length & 0xff) ? PER_BYTE : 0) +
	       (room >> 8 == k->length >> 8 ? PER_BYTE : 0) + (room % 4 == 0 ? MULTIPLE_OF_4 : 0);
}

/* Sets exact, cut and good of mark i; those of the marks behind it are set already. */
static void judge_mark(fw_sbf_framer *f, size_t i, uint64_t end, enum boundary boundary,
                       const fw_sbf_stamp *next)
{
	fw_sbf_mark *k = &f->marks[i];
	const uint64_t room = room_of(f, i, end);
	const int header = header_evidence(k, &f->last, next);
	int enough = k->expected ? WHERE_DUE : ANYWHERE;

	k->exact = leads_on(f, i, end, boundary);
	k->cut = boundary == AT_END && is_cut(k, header, end);
	if (!k->exact && room < SMALLEST)
		enough =
		    length_evidence(k, room) + ANYWHERE; /* too short, unless the header alone says enough */
	k->good = k->cut || header + length_evidence(k, room) >= enough;
}

/* Is there a block among the marks from i on? Half a header at the very end is not enough to say so. */
static bool good_from(const fw_sbf_framer *f, size_t i)
{
	for (; i < f->n_marks; i++)
		if (f->marks[i].good &&
		    (!f->marks[i].cut || f->marks[i].expected || f->marks[i].size == STAMPED))
			return true;
	return false;
}

/* Count a lost block, cut short or damaged, and tell the caller. */
static void lose(fw_sbf_framer *f, const fw_sbf_mark *k, bool cut)
{
	fw_sbf_loss loss = {.offset = k->at, .status = FW_EFORMAT};

	if (cut) {
		f->stats.truncated = 1;
		loss.status = FW_ETRUNCATED;
	} else {
		f->stats.blocks_damaged++;
		if (k->exact && k->sync == SYNC)
			loss.status = FW_ECHECKSUM;
	}
	if (k->exact || k->sync == SYNC)
		loss.id = k->id;
	if (f->on_loss != NULL)
		f->on_loss(f->context, &loss);
}

/* Judge the marks and count the blocks among them. An open region is judged only in its first half, the
 * part that can already be seen in full. A claim beyond the end is a cut block, unless another block lies
 * inside. */
static void judge(fw_sbf_framer *f, uint64_t end, enum boundary boundary, const fw_sbf_stamp *next)
{
	const size_t n = boundary == OPEN ? FW_SBF_MARKS / 2 : f->n_marks;

	for (size_t i = f->n_marks; i-- > 0;)
		judge_mark(f, i, end, boundary, next);
	for (size_t i = 0; i < n; i++) {
		const fw_sbf_mark *k = &f->marks[i];
		const bool cut = k->cut && !good_from(f, i + 1);

		if (!k->good || k->at < f->judged)
			continue;
		f->judged = cut ? end : k->exact ? claim_end(k) : k->at + 1;
		lose(f, k, cut);
	}
	f->n_marks -= n;
	memmove(f->marks, f->marks + n, f->n_marks * sizeof(f->marks[0]));
}

static void add_mark(fw_sbf_framer *f, const fw_sbf_mark *k)
{
	const uint64_t claim = claim_end(k);

	if (f->n_marks == FW_SBF_MARKS)
		judge(f, k->at, OPEN, &f->last);
	f->marks[f->n_marks++] = *k;
	if (claim < f->expect)
		f->expect = claim;
}

/* The nearest claim that ends behind pos. */
static void expect_next(fw_sbf_framer *f)
{
	f->expect = NEVER;
	for (size_t i = 0; i < f->n_marks; i++) {
		const uint64_t claim = claim_end(&f->marks[i]);

		if (claim > f->base + f->pos && claim < f->expect)
			f->expect = claim;
	}
}

static void begin_region(fw_sbf_framer *f)
{
	fw_sbf_mark k;

	f->region = f->judged = f->base + f->pos;
	f->expect = NEVER;
	f->n_marks = 0;
	(void)have(f, STAMPED);
	k = read_mark(f, true);
	add_mark(f, &k);
	f->pos++;
}

static void end_region(fw_sbf_framer *f, enum boundary boundary, const fw_sbf_stamp *next)
{
	const uint64_t end = f->base + f->pos;

	judge(f, end, boundary, next);
	f->stats.bytes_skipped += end - f->region;
	f->stats.resyncs++;
}

/* Go on to the next place that is worth a look: half a sync pair, a week, the end of a claim. */
static void skip_dull(fw_sbf_framer *f)
{
	const uint8_t *p = f->buffer + f->pos;
	size_t n = f->end - f->pos - STAMPED;

	if (f->expect - f->base - f->pos < n)
		n = (size_t)(f->expect - f->base - f->pos);
	for (; n > 0 && p[0] != '$' && p[1] != '@' && get_u2(p + 12) != f->last.week; n--)
		p++;
	f->pos = (size_t)(p - f->buffer);
}

/* The length of the block at pos, or a mark if there may have been one. */
static size_t examine(fw_sbf_framer *f)
{
	const bool expected = f->base + f->pos == f->expect;
	const size_t length = block_here(f);
	fw_sbf_mark k;

	if (length > 0)
		return length;
	k = read_mark(f, expected);
	if (expected)
		expect_next(f);
	if (expected || k.sync == SYNC || time_evidence(&k.stamp, &f->last) == SAME_HOUR)
		add_mark(f, &k);
	return 0;
}

/* The length of the next block, with pos on it; 0 at the end. */
static size_t seek_block(fw_sbf_framer *f)
{
	size_t length;

	for (; f->pos < f->end; f->pos++) {
		if (have(f, STAMPED))
			skip_dull(f);
		length = examine(f);
		if (length > 0)
			return length;
	}
	return 0;
}

static void take(fw_sbf_framer *f, size_t length, const fw_sbf_stamp *stamp, fw_sbf_block *b)
{
	const uint8_t *p = f->buffer + f->pos;
	const uint16_t id = get_u2(p + 4);

	b->data = p;
	b->length = length;
	b->id = id & 0x1fff;
	b->revision = (uint8_t)(id >> 13);
	b->tow_ms = length < STAMPED ? FW_SBF_NO_TOW : get_u4(p + 8);
	b->week = length < STAMPED ? FW_SBF_NO_WEEK : get_u2(p + 12);
	b->offset = f->base + f->pos;
	f->stats.blocks++;
	f->stats.bytes_good += length;
	if (stamp->known)
		f->last = *stamp;
	f->pos += length;
}

fw_status fw_sbf_next(fw_sbf_framer *f, fw_sbf_block *b)
{
	size_t length = block_here(f);
	const bool skip = length == 0;
	fw_sbf_stamp stamp = {0};

	if (skip) {
		if (f->pos == f->end)
			return f->status;
		begin_region(f);
		length = seek_block(f);
	}
	if (length == 0) {
		end_region(f, AT_END, &stamp);
		return f->status;
	}
	stamp = stamp_of(f->buffer + f->pos, length);
	if (skip)
		end_region(f, AT_BLOCK, &stamp);
	take(f, length, &stamp, b);
	return FW_OK;
}
