/* rtklib_pos: lines as RTKLIB's outecef() and outpos() print them; ECEF positions and turned covariances by
 * numpy (48.5 deg N, 7 deg E, 120 m). The solution of a walk is read too, where it is there. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "formats/rtklib_pos.h"

#include "log_test.h"

static fw_input input;
static fw_rtklib_pos reader;
static fw_any_record record;
static fw_kind kind;

static void begin(const char *text)
{
	fw_input_open_memory(&input, text, strlen(text));
	fw_rtklib_pos_begin(&reader, &input);
}

static void expect(const char *columns, const char *quality)
{
	const fw_status status = fw_rtklib_pos_read(&reader, &kind, &record);

	if (status != FW_OK)
		fail_msg("%d: %s", status, reader.problem.reason);
	assert_int_equal(kind, FW_pos);
	assert_columns(kind, &record, columns);
	assert_string_equal(text_of(kind, &record, "quality"), quality);
}

static void expect_end(uint64_t lost)
{
	assert_int_equal(fw_rtklib_pos_read(&reader, &kind, &record), FW_EOF);
	assert_int_equal(reader.lost, lost);
}

#define LLH                                                                                                  \
	"% program   : RTKPOST ver.2.4.3\n"                                                                  \
	"% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of "          \
	"satellites)\n"                                                                                      \
	"%  GPST                  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   "      \
	"sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio    vn(m/s)    ve(m/s)    vu(m/s)      sdvn     "    \
	"sdve     sdvu    sdvne    sdveu    sdvun\n"

#define REST "   0.0100   0.0200   0.0300   0.0010  -0.0020   0.0030   1.00   12.5"

static void degrees_and_dates(void **state)
{
	(void)state;
	assert_true(fw_rtklib_pos_detect((const uint8_t *)LLH, sizeof LLH - 1));
	begin(LLH
	      "2025/08/28 17:30:39.749   48.500000000  -7.000000000   120.0000   1  25" REST
	      "    0.50000   -0.25000    0.12500   0.04000  0.05000  0.06000  0.00100  0.00200  0.00300\r\n"
	      "2025/08/28 17:30:40.749   48.500000000  -7.000000000   120.0000   2  25" REST "\n");
	expect("gps_week=2381 tow_s=408639.749 lat_deg=48.5 lon_deg=-7 height_m=120 n_sats=25 sd_n_m=0.01 "
	       "sd_e_m=0.02 "
	       "sd_d_m=0.03 ratio=12.5 vn_mps=0.5 ve_mps=-0.25 vd_mps=-0.125 sd_vn_mps=0.04 sd_ve_mps=0.05 "
	       "sd_vd_mps=0.06",
	       "fixed");
	expect("tow_s=408640.749 vn_mps=nan sd_vd_mps=nan", "float");
	expect_end(0);
	assert_false(reader.msl);
}

static void qualities(void **state)
{
	static const char *const words[] = {"fixed", "float", "sbas", "dgnss", "single", "single"};
	char text[200];

	(void)state;
	for (int q = 1; q <= 6; q++) {
		snprintf(text, sizeof text, "2381 408639.749 48.5 7 120 %d 25" REST "\n", q);
		begin(text);
		expect("gps_week=2381 tow_s=408639.749 lon_deg=7", words[q - 1]);
	}
	begin("2381 408639.749 48.5 7 120 0 25" REST "\n2381 408640 48.5 7 120 9 25" REST "\n");
	expect_end(0);
	assert_int_equal(reader.none, 2);
}

static void degrees_minutes_seconds(void **state)
{
	(void)state;
	begin("%  UTC                     latitude(d'\")   longitude(d'\")  height(m)   Q  ns\n"
	      "2025/08/28 17:30:39.749   48 30 00.00000  -7 15 36.00000   120.0000   5   9\n"
	      "2025/08/28 17:30:39.749   48 30 00.00000  -0 15 36.00000   120.0000   5   9\n");
	expect("tow_s=408657.749 lat_deg=48.5 lon_deg=-7.26 height_m=120 n_sats=9 sd_n_m=nan", "single");
	expect("lon_deg=-0.26", "single");
	expect_end(0);
}

static void other_clocks_and_separators(void **state)
{
	(void)state;
	begin("%  JST,latitude(deg),longitude(deg),height(m),Q,ns\n2025/08/29 02:30:39.749,48.5,7,120,4,9\n");
	expect("tow_s=408657.749 lat_deg=48.5", "dgnss");
	begin("%  GPST;latitude(deg);longitude(deg);height(m);Q;ns\n2381;408639.749;48.5;7;120;4;9\n");
	expect("tow_s=408639.749 lat_deg=48.5 n_sats=9", "dgnss");
	begin("% (lat/lon/height=WGS84/geodetic,Q=1:fix)\n%  UTC  latitude(deg)\n2381 408639.749 48.5 7 120 "
	      "4 9\n");
	expect("tow_s=408639.749 height_m=120", "dgnss");
	assert_true(reader.msl);
}

static void earth_fixed_positions(void **state)
{
	(void)state;
	begin("%  GPST                      x-ecef(m)      y-ecef(m)      z-ecef(m)   Q  ns   sdx(m)   "
	      "sdy(m)   sdz(m)  "
	      "sdxy(m)  sdyz(m)  sdzx(m) age(s)  ratio  vx(m/s) vy(m/s) vz(m/s) sdvx sdvy sdvz sdvxy sdvyz "
	      "sdvzx\n"
	      "2025/08/28 17:30:39.749   4202756.4867    516033.6098   4753987.5015   1  25   0.0200   "
	      "0.0300   0.0400   "
	      "0.0050  -0.0060   0.0070   1.00   12.5 1 2 3 0.1 0.1 0.1 0 0 0\n");
	assert_int_equal(fw_rtklib_pos_read(&reader, &kind, &record), FW_OK);
	assert_near(number_of(kind, &record, "lat_deg"), 48.5, 1e-9);
	assert_near(number_of(kind, &record, "lon_deg"), 7.0, 1e-9);
	assert_near(number_of(kind, &record, "height_m"), 120, 1e-4);
	assert_near(number_of(kind, &record, "sd_n_m"), 0.029841562, 1e-8);
	assert_near(number_of(kind, &record, "sd_e_m"), 0.029774585, 1e-8);
	assert_near(number_of(kind, &record, "sd_d_m"), 0.033510525, 1e-8);
	assert_near(number_of(kind, &record, "vn_mps"), 1.061937542, 1e-8);
	assert_near(number_of(kind, &record, "ve_mps"), 1.863222960, 1e-8);
	assert_near(number_of(kind, &record, "vd_mps"), -3.066054282, 1e-8);
	assert_near(number_of(kind, &record, "sd_vd_mps"), 0.1, 1e-12);
	expect_end(0);
}

static void baselines_are_refused(void **state)
{
	(void)state;
	begin("%  GPST  e-baseline(m)  n-baseline(m)  u-baseline(m)   Q  ns\n2381 408639.749 1 2 3 1 9\n");
	assert_int_equal(fw_rtklib_pos_read(&reader, &kind, &record), FW_EUNKNOWN);
	assert_int_equal(fw_rtklib_pos_read(&reader, &kind, &record), FW_EUNKNOWN);
	assert_int_equal(reader.problem.line, 2);
}

static void damaged_lines_are_refused(void **state)
{
	static const char *const wrong[] = {"2381",
	                                    "2381 x 48.5 7 120",
	                                    "2381 700000 48.5 7 120",
	                                    "9999 1 48.5 7 120",
	                                    "2025/13/28 17:30:39 48.5 7 120",
	                                    "2025/08/28 17:30 48.5 7 120",
	                                    "2381 1 48.5 7",
	                                    "2381 1 48.5 7 nan",
	                                    "2381 1 98.5 7 120",
	                                    "2381 1 48.5 7 120 1 9 0.1 0.2"};
	char text[300];

	(void)state;
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		snprintf(text, sizeof text, "2381 408639 48.5 7 120\n%s\n2381 408640 48.5 7 120\n", wrong[i]);
		begin(text);
		expect("tow_s=408639", "");
		if (fw_rtklib_pos_read(&reader, &kind, &record) != FW_ESYNTAX)
			fail_msg("%s was taken", wrong[i]);
		assert_int_equal(reader.problem.line, 2);
		expect("tow_s=408640", "");
		expect_end(1);
	}
}

static void a_walk(void **state)
{
	const char *data = getenv("FURROW_DATA");
	int fixed = 0, floats = 0;
	char path[4096];

	(void)state;
	snprintf(path, sizeof path, "%s/ins/walk_0827/gnss_1730_sf.pos",
	         data != NULL ? data : "../shared/data");
	if (fw_input_open(&input, path) != FW_OK) {
		print_message("skipped: no %s\n", path);
		skip();
	}
	fw_rtklib_pos_begin(&reader, &input);
	while (fw_rtklib_pos_read(&reader, &kind, &record) == FW_OK) {
		fixed += strcmp(text_of(kind, &record, "quality"), "fixed") == 0;
		floats += strcmp(text_of(kind, &record, "quality"), "float") == 0;
		assert_near(number_of(kind, &record, "lat_deg"), 40.0967, 0.001);
		assert_true(isfinite(number_of(kind, &record, "sd_vd_mps")));
	}
	assert_int_equal(fixed, 349);
	assert_int_equal(floats, 187);
	assert_int_equal(reader.lost, 0);
	fw_input_close(&input);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(degrees_and_dates),         cmocka_unit_test(qualities),
	    cmocka_unit_test(degrees_minutes_seconds),   cmocka_unit_test(other_clocks_and_separators),
	    cmocka_unit_test(earth_fixed_positions),     cmocka_unit_test(baselines_are_refused),
	    cmocka_unit_test(damaged_lines_are_refused), cmocka_unit_test(a_walk),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
