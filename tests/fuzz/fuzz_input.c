/* Input, plain and gzip: the same bytes in whatever pieces they are asked for. */
#include <string.h>
#include <zlib.h>

#include "formats/bytes.h"
#include "formats/input.h"

#include "fuzz.h"

enum { HEAD = 10, TRAILER = 8, OUT_MOST = 16 << 20 };

static uint8_t out[OUT_MOST], unpacked[1 << 20];

/* A gzip member with n bytes of text that compresses well or not at all; returns its size. */
static size_t make_member(fw_random *r, uint8_t *data, size_t room)
{
	uint8_t plain[1024];
	const size_t n = (size_t)fw_random_below(r, sizeof plain);
	const unsigned spread = (unsigned)(1 + fw_random_below(r, 255));
	z_stream z = {0};

	for (size_t i = 0; i < n; i++)
		plain[i] = (uint8_t)fw_random_below(r, spread);
	require(deflateInit2(&z, (int)fw_random_below(r, 10), Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY) == Z_OK);
	z.next_in = plain;
	z.avail_in = (unsigned)n;
	z.next_out = data;
	z.avail_out = (unsigned)room;
	const int done = deflate(&z, Z_FINISH) == Z_STREAM_END;
	const size_t used = room - z.avail_out;
	deflateEnd(&z);
	return done ? used : 0;
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	size_t size = 0;
	for (size_t n = 1 + (size_t)fw_random_below(random, 4); n > 0; n--)
		size += make_member(random, data + size, FUZZ_ROOM - size);
	return size;
}

/* Head and trailer of the first member, as far as its middle can be inflated. */
static void repair(uint8_t *data, size_t size)
{
	static const uint8_t head[HEAD] = {0x1f, 0x8b, 8};
	z_stream z = {0};
	if (size < HEAD + TRAILER)
		return;
	memcpy(data, head, sizeof head);
	require(inflateInit2(&z, -15) == Z_OK);
	z.next_in = data + HEAD;
	z.avail_in = (unsigned)(size - HEAD);
	z.next_out = unpacked;
	z.avail_out = sizeof unpacked;
	if (inflate(&z, Z_FINISH) == Z_STREAM_END && z.avail_in >= TRAILER) {
		uint8_t *trailer = data + size - z.avail_in;
		fw_store_u32(trailer, (uint32_t)crc32(0, unpacked, (unsigned)z.total_out));
		fw_store_u32(trailer + 4, (uint32_t)z.total_out);
	}
	inflateEnd(&z);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	size = LLVMFuzzerMutate(data, size, max);
	if (seed & 1)
		repair(data, size);
	return size;
}

/* All of it, at most OUT_MOST, at once. Returns the status at the end. */
static fw_status read_all(fw_input *in, size_t *used)
{
	fw_status status = FW_OK;
	*used = 0;
	while (*used < OUT_MOST && status == FW_OK) {
		size_t got = 99;
		status = fw_input_read(in, out + *used, OUT_MOST - *used, &got);
		require(status == FW_OK ? got >= 1 && got <= OUT_MOST - *used : got == 0);
		*used += got;
	}
	require(in->offset == *used);
	return status;
}

/* The same in small pieces, with looks ahead. */
static fw_status read_pieces(fw_input *in, size_t most, size_t *used)
{
	uint8_t piece[256];
	fw_status status = FW_OK;
	*used = 0;
	for (size_t n = 1; *used < most && status == FW_OK; n = n * 7 % 251) {
		const uint8_t *ahead;
		size_t got, seen;
		if (n % 5 == 0 && fw_input_peek(in, 1 + n * 16, &ahead, &seen) == FW_OK)
			require(seen <= OUT_MOST - *used && memcmp(ahead, out + *used, seen) == 0);
		status = fw_input_read(in, piece, n, &got);
		require(got <= n && memcmp(piece, out + *used, got) == 0);
		*used += got;
	}
	return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	enum { PIECES_MOST = 64 * 1024 };
	static fw_input in;
	size_t used, used_again;

	fw_input_open_memory(&in, data, size);
	const fw_status status = read_all(&in, &used);
	fw_input_close(&in);
	require(used == OUT_MOST || status == FW_EOF || status == FW_EFORMAT || status == FW_ETRUNCATED);
	if (size < 2 || data[0] != 0x1f || data[1] != 0x8b)
		require(status == FW_EOF && used == size && memcmp(out, data, size) == 0);

	fw_input_open_memory(&in, data, size);
	const fw_status status_again =
	    read_pieces(&in, used < PIECES_MOST ? OUT_MOST : PIECES_MOST, &used_again);
	require(used >= PIECES_MOST || (status_again == status && used_again == used));
	fw_input_close(&in);
	return 0;
}
