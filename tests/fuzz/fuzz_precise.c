/* SP3 and RINEX clock files, read into tables as time goes on. Reading ends, and every state is finite. */
#include "text_input.h"

#include <math.h>

#include "formats/rinex_clock.h"
#include "formats/sp3.h"
#include "gnss/precise.h"

static const char *const words[] = {
    "#cP2010  7  1  0  0  0.00000000      12 ORBIT IGS20 HLM  TST\n",
    "%c M  cc UTC ccc\n",
    "%c M  cc TAI ccc\n",
    "*  2010  7  1  0 15  0.00000000\n",
    "*  2016 12 31 23 59 60.00000000\n",
    "PG01  18392.619117   7490.690408 -17846.346485 999999.999999\n",
    "PE36                                                        ",
    "EOF\n",
    "     3.00           C                                       RINEX VERSION / TYPE\n",
    "                                                            END OF HEADER\n",
    "   BDT                                                      TIME SYSTEM ID\n",
    "AS G01  2010 07 01 00 00  0.000000  1    2.691084288582e-04\n",
    "AR ",
    "      0.000000",
    " 999999.999999",
    "D+09",
    "e308",
    "-",
    "\r\n",
    "\n\n",
};

/* Two satellites at some epochs; a clock file every other time. */
size_t fuzz_make(fw_random *random, uint8_t *data)
{
	char *p = (char *)data, *end = p + FUZZ_ROOM;
	const bool clocks = fw_random_below(random, 2) == 0;

	p += snprintf(p, (size_t)(end - p), "%s%s", clocks ? words[8] : words[0],
	              clocks ? words[9] : "%c M  cc GPS ccc\n");
	for (int i = 0; i < 13; i++) {
		const int minute = 15 * i;

		if (!clocks)
			p += snprintf(p, (size_t)(end - p), "*  2010  7  1 %2d %2d  0.00000000\n",
			              minute / 60, minute % 60);
		for (int s = 1; s <= 2; s++)
			if (clocks)
				p += snprintf(p, (size_t)(end - p),
				              "AS G%02d  2010 07 01 %02d %02d  0.000000  1   %19.12E\n", s,
				              minute / 60, minute % 60, fw_random_uniform(random) * 1e-4);
			else
				p += snprintf(p, (size_t)(end - p), "PG%02d%14.6f%14.6f%14.6f%14.6f\n", s,
				              26000 * cos(i * 0.13 + s), 26000 * sin(i * 0.13 + s), 100.0 * i,
				              fw_random_uniform(random));
	}
	p += snprintf(p, (size_t)(end - p), "%s", clocks ? "" : "EOF\n");
	return (size_t)(p - (char *)data);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return text_mutate(data, size, max, seed, words, sizeof words / sizeof *words);
}

static fw_precise table;

/* Whatever the table holds now, a state is finite or there is none. */
static void ask(fw_satellite satellite, fw_time t)
{
	fw_satellite_state s;

	(void)fw_precise_wants_orbits(&table, t);
	(void)fw_precise_wants_clocks(&table, t);
	if (fw_precise_state(&table, satellite, t, &s) < 0)
		return;
	for (int i = 0; i < 3; i++)
		require(isfinite(s.position_m[i]) && isfinite(s.velocity_mps[i]));
	require(isfinite(s.clock_s) && isfinite(s.drift_sps));
}

static void read_sp3(fw_input *in)
{
	static fw_sp3_reader reader;
	fw_sp3_point p;
	fw_status status;

	fw_sp3_begin(&reader, in);
	while ((status = fw_sp3_read(&reader, &p)) == FW_OK || status == FW_ESYNTAX) {
		require(status == FW_OK || reader.reason[0] != '\0');
		if (status != FW_OK)
			continue;
		if (p.has_position)
			(void)!fw_precise_add_position(&table, p.time, p.satellite, p.position_m);
		if (p.has_clock)
			(void)!fw_precise_add_clock(&table, p.time, p.satellite, p.clock_s);
		ask(p.satellite, fw_time_add_ns(p.time, -5000 * FW_NS_PER_S));
	}
	require(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EUNKNOWN);
}

static void read_clocks(fw_input *in)
{
	static fw_rinex_clock_reader reader;
	fw_rinex_clock_point p;
	fw_status status;

	fw_rinex_clock_begin(&reader, in);
	while ((status = fw_rinex_clock_read(&reader, &p)) == FW_OK || status == FW_ESYNTAX) {
		require(status == FW_OK || reader.reason[0] != '\0');
		if (status == FW_OK)
			(void)!fw_precise_add_clock(&table, p.time, p.satellite, p.clock_s);
	}
	require(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EUNKNOWN);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_input in;

	fw_precise_init(&table);
	fw_input_open_memory(&in, data, size);
	if (size > 0 && data[0] == '#')
		read_sp3(&in);
	else
		read_clocks(&in);
	return 0;
}
