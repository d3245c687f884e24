/* ArduPilot's logs, binary and text: read twice, as files are, and once, as pipes are. */
#include "text_input.h"

#include "../dataflash_make.h"
#include "formats/dataflash.h"

#include "record_check.h"

static const char *const words[] = {"FMT, ",
                                    "GPS, ",
                                    "IMU, ",
                                    "\n",
                                    ", ",
                                    "nan",
                                    "2300",
                                    "1e308",
                                    "-1",
                                    "TimeUS",
                                    "FMT, 130, 45, GPS, QB, TimeUS,I\n",
                                    "99999999999999999999",
                                    "PARM, 1, GPS_DELAY_MS, 1\n"};

static const char text_log[] =
    "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n"
    "FMT, 130, 45, GPS, QBBIHBcLLeffffB, TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U\n"
    "FMT, 131, 31, IMU, QBffffffIIfBBHH, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz\n"
    "GPS, 1200000, 0, 6, 1001000, 2300, 17, 0.75, 48.5, -7.25, 200.5, 10, 90, 1.5, 0, 1\n"
    "IMU, 2000000, 0, 0.5, 0.25, -0.5, 1, 2, -9.75, 0, 0, 30.1, 1, 1, 1000, 1000\n"
    "IMU, 2010000, 0, 0.5, 0.25, -0.5, 1, 2, -9.75, 0, 0, 30.1, 1, 1, 1000, 1000\n";

static void make_message(fw_random *r, log_bytes *b, uint64_t us)
{
	const df_fix fix = {us,
	                    (int)fw_random_below(r, 2),
	                    (int)fw_random_below(r, 8),
	                    fw_random_below(r, 4) != 0,
	                    (uint32_t)(us / 1000 + fw_random_below(r, 100)),
	                    2300};

	switch (fw_random_below(r, 9)) {
	case 0: df_mag(b, us, 0, 200, 1); break;
	case 1: df_baro(b, us, 12); break;
	case 2: df_gps(b, &fix); break;
	case 3: df_accuracy(b, &fix, 24575); break;
	case 4: df_attitude(b, us); break;
	case 5: df_camera(b, us); break;
	case 6: df_raw(b, fw_random_below(r, 2) ? DF_ACC : DF_GYR, us, 1); break;
	case 7: df_parameter(b, "GPS_DELAY_MS", (float)fw_random_below(r, 300)); break;
	default: df_imu(b, us, (int)fw_random_below(r, 2), 0.5F, -9.75F, 1); break;
	}
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	static log_bytes b;
	uint64_t us = 1000000;

	b.n = 0;
	if (fw_random_below(random, 4) == 0) {
		put_bytes(&b, text_log, sizeof text_log - 1);
	} else {
		df_formats(&b);
		for (int n = 5 + (int)fw_random_below(random, 80); n > 0;
		     n--, us += fw_random_below(random, 400000))
			make_message(random, &b, us);
	}
	memcpy(data, b.bytes, b.n);
	return b.n;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return size > 0 && data[0] == 'F'
	           ? text_mutate(data, size, max, seed, words, sizeof words / sizeof *words)
	           : LLVMFuzzerMutate(data, size, max);
}

/* The number of records. */
static uint64_t read_log(fw_dataflash *r, size_t size)
{
	fw_any_record record;
	uint64_t n = 0;
	fw_status status;
	fw_kind kind;

	while ((status = fw_dataflash_read(r, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_OK)
			record_check(NULL, kind, &record);
		else
			require(r->reason[0] != '\0' && r->lost_offset <= size);
		n += status == FW_OK;
	}
	require(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EFORMAT); /* broken gzip */
	require(r->bytes_lost <= size);
	return n;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_dataflash reader;
	static fw_input input;
	const fw_dataflash_kind form = size > 0 && data[0] == 'F' ? FW_DATAFLASH_TEXT : FW_DATAFLASH_BINARY;

	fw_input_open_memory(&input, data, size);
	fw_dataflash_begin(&reader, &input, form, NULL);
	const fw_status first = fw_dataflash_survey(&reader);
	fw_input_open_memory(&input, data, size);
	fw_dataflash_again(&reader, &input);
	(void)read_log(&reader, size);
	require(reader.final == first);

	fw_input_open_memory(&input, data, size);
	fw_dataflash_begin(&reader, &input, form, NULL);
	(void)read_log(&reader, size);
	return 0;
}
