/* The SBF framer on any bytes: what it says of them must add up. */
#include "sbf_input.h"

static uint64_t losses;

static void count_loss(void *context, const fw_sbf_loss *loss)
{
	(void)context;
	require(loss->status == FW_ECHECKSUM || loss->status == FW_EFORMAT || loss->status == FW_ETRUNCATED);
	losses++;
}

static size_t make(fw_random *r, uint32_t *tow_ms, uint8_t *blocks)
{
	return sbf_make_any(r, *tow_ms, blocks);
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	return sbf_make_stream(random, make, data, FUZZ_ROOM);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return sbf_mutate(data, size, max, seed, make);
}

static void frame(const uint8_t *data, size_t size)
{
	static fw_sbf_framer framer;
	static fw_input in;
	fw_sbf_block b;
	uint64_t blocks = 0, bytes = 0, end = 0;
	fw_status status;

	losses = 0;
	fw_input_open_memory(&in, data, size);
	const int plain = size < 2 || data[0] != 0x1f || data[1] != 0x8b; /* not taken for gzip */
	fw_sbf_init(&framer, &in, count_loss, NULL);
	while ((status = fw_sbf_next(&framer, &b)) == FW_OK) {
		require(b.offset >= end && b.length >= FW_SBF_HEADER && b.length % 4 == 0);
		require(fw_crc16(b.data + 4, b.length - 4) == fw_load_u16(b.data + 2));
		require(!plain || memcmp(b.data, data + b.offset, b.length) == 0);
		end = b.offset + b.length;
		bytes += b.length;
		blocks++;
	}
	const fw_sbf_stats *s = &framer.stats;
	require(!plain || (status == FW_EOF && s->bytes_good + s->bytes_skipped == size));
	require(s->blocks == blocks && s->bytes_good == bytes);
	require(losses == s->blocks_damaged + s->truncated);
	fw_input_close(&in);
}

/* Now and then the input many times over: more than fits into the framer's buffer. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static uint8_t large[FW_SBF_BUFFER / 4 * 5];
	size_t used = 0;

	frame(data, size);
	if (size == 0 || size > FUZZ_ROOM || size % 256 != 12)
		return 0;
	for (; used + size <= sizeof large; used += size)
		memcpy(large + used, data, size);
	frame(large, used);
	return 0;
}
