/* Tables of sensor data. The first byte says how they are to be read. */
#include "text_input.h"

#include "formats/imu_text.h"

#include "record_check.h"

static const struct {
	const char *columns, *axes, *time, *table;
} ways[] = {
    {"time=1 gx=2:deg/s gy=3:deg/s gz=4:deg/s ax=5:g ay=6:g az=7:g", "FLU", "unix-utc",
     "1756402240.9610000,-0.0170050,-0.0070006,1.0109805,0.0006601,-0.0028012,0.0027935\n"
     "1756402240.9670007,-0.0173355,-0.0065735,1.0110895,0.0011786,-0.0027377,0.0027161\n"},
    {"kf-gins", "FRD", "gps,week=2300",
     "604799.995 .001 .002 .003 .05 .0 -.05\n0.000 .001 .002 .003 .05 .0 -.05\n0.005 .001 0 0 .05 0 -.05\n"},
    {"kf-gins", "FRD", "gps,week=2300", "456250.000 30.4447858054 114.4718661162 21.095 0.010 0.009 0.019\n"},
    {"px4-replay", "FRD", "boot,start=2300:0",
     "4000,mag,0.2,-0.08,0.425\n4000,imu,-0.19,0.22,-9.9,-0.004,-0.007,0.01\n4000,baro,487.76\n"
     "200000,gps,488103.0,85456073.0,473977508.0,-0.01,-0.02,0.5\n"},
    {"time=t gx=p gy=q gz=r ax=x ay=y az=z mx=a my=b mz=c baro=P:hPa lat=lat lon=lon height=h vn=n ve=e vd=d "
     "fixtime=tow nsats=s roll=o pitch=i heading=u",
     "-y,x,z", "boot,week=2300",
     "t;p;q;r;x;y;z;a;b;c;P;lat;lon;h;n;e;d;tow;s;o;i;u\n"
     "1;1;2;3;4;5;6;.1;.2;.3;900;48;7;100;1;2;3;5000;9;1;2;3\n2;1;2;3;4;5;6;.1;.2;.3;900;48;7;100;1;2;3;5001;"
     "9;1;2;3\n"},
    {NULL, NULL, NULL,
     "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
     "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n1403636579758555392,-0.099,0.147,0.028,8.1,-0.3,-4.2\n"},
};

enum { WAYS = sizeof ways / sizeof *ways };

static const char *const words[] = {",",
                                    ";",
                                    "\t",
                                    "\n",
                                    "nan",
                                    "inf",
                                    "1e308",
                                    "-",
                                    "imu",
                                    "mag",
                                    "gps",
                                    "#",
                                    "\"",
                                    "604800",
                                    "99999999999999999999",
                                    "0.0000000000000000000000001",
                                    "\xef\xbb\xbf"};

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	const size_t way = (size_t)fw_random_below(random, WAYS), n = strlen(ways[way].table);
	size_t size = 1;

	data[0] = (uint8_t)way;
	for (size_t times = 1 + (size_t)fw_random_below(random, 4); times > 0; times--, size += n)
		memcpy(data + size, ways[way].table, n);
	return size;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	if (size == 0 || seed % 64 == 0)
		data[0] = (uint8_t)(seed >> 6);
	return 1 + text_mutate(data + 1, size > 0 ? size - 1 : 0, max - 1, seed, words,
	                       sizeof words / sizeof *words);
}

static const fw_imu_plan *plan_of(size_t way, fw_imu_plan *plan)
{
	fw_imu_problem problem;

	if (ways[way].columns == NULL)
		return NULL;
	fw_imu_plan_begin(plan);
	require(fw_imu_parse_columns(ways[way].columns, &plan->map, &problem) == FW_OK);
	require(fw_imu_parse_axes(ways[way].axes, &plan->axes, &problem) == FW_OK);
	require(fw_imu_parse_time(ways[way].time, &plan->clock, &problem) == FW_OK);
	return plan;
}

static void read_table(fw_imu_text *r)
{
	fw_any_record record;
	fw_status status;
	fw_kind kind;

	while ((status = fw_imu_text_read(r, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_OK)
			record_check(NULL, kind, &record);
		else
			require(r->problem.line > 0 && r->problem.reason[0] != '\0');
	}
	require(status == FW_EOF || status == FW_EUNKNOWN || status == FW_EFORMAT ||
	        status == FW_ETRUNCATED); /* the last two: gzip */
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static fw_imu_text reader;
	static fw_input input;
	fw_imu_plan plan;

	if (size == 0)
		return 0;
	const fw_imu_plan *p = plan_of(data[0] % WAYS, &plan);
	fw_input_open_memory(&input, data + 1, size - 1);
	fw_imu_text_begin(&reader, &input, p);
	if (fw_imu_text_wants_survey(&reader)) {
		(void)!fw_imu_text_survey(&reader);
		fw_input_open_memory(&input, data + 1, size - 1);
		fw_imu_text_again(&reader, &input);
	}
	read_table(&reader);
	return 0;
}
