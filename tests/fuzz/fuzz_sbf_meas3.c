/* The compressed measurement blocks. */
#include "meas3_input.h"

#include "formats/sbf_meas3.h"
#include "formats/sbf_measurements.h"

#include "record_check.h"

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	return sbf_make_stream(random, meas3_make, data, FUZZ_ROOM);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return sbf_mutate(data, size, max, seed, meas3_make);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_sbf_meas3 meas3;
	fw_kind_set wanted = {{0}};

	fw_kind_add(&wanted, FW_epoch);
	fw_kind_add(&wanted, FW_obs);
	fw_kind_add(&wanted, FW_obs_extra);
	fw_sbf_meas3_init(&meas3, FW_ANTENNA_ALL, &wanted, (fw_sink){record_check, NULL});
	for (size_t at = 0; (at = sbf_find(data, size, at)) + FW_SBF_HEADER <= size;) {
		const size_t length = fw_load_u16(data + at + 6);
		const int whole =
		    length >= FW_SBF_HEADER && length <= FW_SBF_MAX_LENGTH && length <= size - at;
		if (whole)
			(void)!fw_sbf_meas3_put(&meas3, sbf_alone(data + at, length), (uint16_t)length);
		at += whole ? length : 2;
	}
	fw_sbf_meas3_flush(&meas3);
	return 0;
}
