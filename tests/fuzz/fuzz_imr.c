/* Waypoint's IMR files. */
#include "fuzz.h"

#include "../log_bytes.h"
#include "formats/imr.h"

#include "record_check.h"

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	static log_bytes b;

	b.n = 0;
	put_text(&b, "$IMURAW", 8);
	put_le(&b, 0, 1);
	put_f64(&b, 8.8);
	put_le(&b, fw_random_below(random, 2), 4);
	put_le(&b, fw_random_below(random, 2), 4);
	put_f64(&b, 200);
	put_f64(&b, 1e-6);
	put_f64(&b, 1e-6);
	put_le(&b, 2, 4);
	while (b.n < 512)
		put_le(&b, 0, 1);
	for (int i = 0; i < 20; i++) {
		put_f64(&b, 604799.95 + 0.005 * i - (i > 10 ? 604800 : 0));
		for (int k = 0; k < 6; k++)
			put_le(&b, fw_random_u64(random) & 0xffff, 4);
	}
	memcpy(data, b.bytes, b.n);
	return b.n;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	const size_t head = (seed & 1) && size > 512 ? 512 : 0;

	return head + LLVMFuzzerMutate(data + head, size - head, max - head);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_imr reader;
	static fw_input input;
	fw_imu_plan plan;
	fw_any_record record;
	fw_status status;
	fw_kind kind;

	fw_imu_plan_begin(&plan);
	plan.clock.has_week = true;
	plan.clock.week = 2300;
	fw_input_open_memory(&input, data, size);
	fw_imr_begin(&reader, &input, &plan);
	while ((status = fw_imr_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_OK)
			record_check(NULL, kind, &record);
		else
			require(reader.lost_offset < size && reader.reason[0] != '\0');
	}
	require(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EUNKNOWN || status == FW_EFORMAT);
	return 0;
}
