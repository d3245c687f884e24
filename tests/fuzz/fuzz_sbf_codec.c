/* The exact codec: what decodes encodes to the same bytes. */
#include "sbf_input.h"

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

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_sbf_values values;
	static uint8_t again[FW_SBF_MAX_LENGTH];

	for (size_t at = 0; (at = sbf_find(data, size, at)) + FW_SBF_HEADER <= size; at += 2) {
		const size_t length = fw_load_u16(data + at + 6);
		if (length < FW_SBF_HEADER || length > FW_SBF_MAX_LENGTH || length > size - at)
			continue;
		if (fw_sbf_decode(sbf_alone(data + at, length), &values) != FW_OK)
			continue;
		uint8_t *const out = again + sizeof again - length;
		memset(out, 0xa5, length);
		require(fw_sbf_encode(&values, out) == FW_OK);
		require(memcmp(out + 4, data + at + 4, length - 4) == 0);
	}
	return 0;
}
