/* Raw navigation pages, block by block. */
#include "nav_input.h"

#include "record_check.h"

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	return sbf_make_stream(random, nav_make_pages, data, FUZZ_ROOM);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	size = sbf_mutate(data, size, max, seed, nav_make_pages);
	if (seed & 1)
		nav_repair(data, size);
	return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_nav nav;
	const fw_sink sink = {record_check, NULL};

	fw_nav_init(&nav);
	for (size_t at = 0; (at = sbf_find(data, size, at)) + FW_SBF_HEADER <= size;) {
		const size_t length = fw_load_u16(data + at + 6);
		const int whole =
		    length >= FW_SBF_HEADER && length <= FW_SBF_MAX_LENGTH && length <= size - at;
		if (whole)
			(void)!fw_nav_block(&nav, sbf_alone(data + at, length), length, &sink);
		at += whole ? length : 2;
	}
	return 0;
}
