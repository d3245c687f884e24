/* PX4's logs: read twice, as files are, and once, as pipes are. */
#include "fuzz.h"

#include "../ulog_make.h"
#include "formats/ulog.h"

#include "record_check.h"

static void make_message(fw_random *r, log_bytes *b, uint64_t us)
{
	const ul_fix fix = {us, UINT64_C(1756400382000000) + us - fw_random_below(r, 200000),
	                    (int)fw_random_below(r, 8), fw_random_below(r, 2) ? 547.5 : 0};

	switch (fw_random_below(r, 11)) {
	case 0: ul_mag(b, us); break;
	case 1: ul_air(b, us); break;
	case 2: ul_gps(b, &fix); break;
	case 3: ul_sensor_gps(b, &fix); break;
	case 4: ul_attitude(b, us); break;
	case 5: ul_capture(b, us); break;
	case 6: ul_dropout(b, 20); break;
	case 7: ul_sync(b); break;
	case 8: ul_imu(b, fw_random_below(r, 2) ? UL_IMU : UL_IMU_1, us, 0.01F, 5000); break;
	default: ul_combined(b, us, 0.5F); break;
	}
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	static log_bytes b;
	uint64_t us = 1000000;

	ul_file(&b);
	ul_flags(&b, (int)fw_random_below(random, 2), fw_random_below(random, 6000));
	ul_parameter(&b, "float EKF2_GPS_DELAY", (float)fw_random_below(random, 300));
	ul_definitions(&b);
	ul_subscriptions(&b);
	for (int n = 5 + (int)fw_random_below(random, 60); n > 0; n--, us += fw_random_below(random, 400000))
		make_message(random, &b, us);
	memcpy(data, b.bytes, b.n);
	return b.n;
}

/* Every other time the definitions stay as they are, so that the data behind them are read. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	const size_t head = (seed & 1) && size > 3000 ? 3000 : 0;

	return head + LLVMFuzzerMutate(data + head, size - head, max - head);
}

static void read_log(fw_ulog *r, size_t size)
{
	fw_any_record record;
	fw_status status;
	fw_kind kind;

	while ((status = fw_ulog_read(r, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_OK)
			record_check(NULL, kind, &record);
		else
			require(r->reason[0] != '\0' && r->lost_offset <= size);
	}
	require(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EUNKNOWN || status == FW_EFORMAT);
	require(r->bytes_lost <= size);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_ulog reader;
	static fw_input input;

	fw_input_open_memory(&input, data, size);
	fw_ulog_begin(&reader, &input, NULL);
	const fw_status first = fw_ulog_survey(&reader);
	fw_input_open_memory(&input, data, size);
	fw_ulog_again(&reader, &input);
	read_log(&reader, size);
	require(reader.final == first);

	fw_input_open_memory(&input, data, size);
	fw_ulog_begin(&reader, &input, NULL);
	read_log(&reader, size);
	return 0;
}
