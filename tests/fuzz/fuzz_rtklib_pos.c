/* RTKLIB's solution files. */
#include "text_input.h"

#include "formats/rtklib_pos.h"

#include "record_check.h"

static const char *const heads[] = {
    "%  GPST                  latitude(deg) longitude(deg)  height(m)   Q  ns\n",
    "%  UTC                   latitude(d'\")  longitude(d'\")  height(m)   Q  ns\n",
    "%  JST                   x-ecef(m) y-ecef(m) z-ecef(m)   Q  ns\n",
    "% (lat/lon/height=WGS84/geodetic,Q=1:fix)\n",
    "",
};

static const char *const lines[] = {
    "2025/08/28 17:30:39.749   48.500000000  -7.000000000   120.0000   1  25   0.0100   0.0200   0.0300   "
    "0.0010  "
    "-0.0020   0.0030   1.00   12.5    0.50000   -0.25000    0.12500   0.04000  0.05000  0.06000  0 0 0\n",
    "2381 408639.749   48 30 00.00000  -7 15 36.00000   120.0000   5   9\n",
    "2381;408639.749;4202756.4867;516033.6098;4753987.5015;1;25;0.02;0.03;0.04;0.005;-0.006;0.007;1;12.5\n",
    "2381,408639.749,4202756.4867,516033.6098,4753987.5015,1,25\n",
};

static const char *const words[] = {"%",
                                    "GPST",
                                    "UTC",
                                    "x-ecef(m)",
                                    "latitude(d'\")",
                                    "latitude(deg)",
                                    "e-baseline(m)",
                                    "/",
                                    ":",
                                    ",",
                                    " ",
                                    "nan",
                                    "1e308",
                                    "-0",
                                    "2381 1 ",
                                    "604800",
                                    "60.5",
                                    "WGS84/geodetic"};

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	size_t size = 0;

	for (int i = 0; i < 6; i++) {
		const char *text =
		    i == 0 ? heads[fw_random_below(random, 5)] : lines[fw_random_below(random, 4)];

		memcpy(data + size, text, strlen(text));
		size += strlen(text);
	}
	return size;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return text_mutate(data, size, max, seed, words, sizeof words / sizeof *words);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_rtklib_pos reader;
	static fw_input input;
	fw_any_record record;
	fw_status status;
	fw_kind kind;

	(void)fw_rtklib_pos_detect(data, size);
	fw_input_open_memory(&input, data, size);
	fw_rtklib_pos_begin(&reader, &input);
	while ((status = fw_rtklib_pos_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_OK)
			record_check(NULL, kind, &record);
		else
			require(reader.problem.line > 0 && reader.problem.reason[0] != '\0');
	}
	require(status == FW_EOF || status == FW_EUNKNOWN || status == FW_EFORMAT ||
	        status == FW_ETRUNCATED); /* the last two: gzip */
	return 0;
}
