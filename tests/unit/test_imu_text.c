/* imu_text: small tables written here, with what comes out counted by hand (GPS epoch in Unix time 315964800;
 * 18 leap seconds since 2017). The logs of other people are read too, where they are there. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "formats/imu_text.h"

#include "log_test.h"

static fw_input input;
static fw_imu_text reader;
static fw_any_record record;
static fw_kind kind;

static void begin_bytes(const char *text, size_t n, const char *columns, const char *axes, const char *time)
{
	fw_imu_problem problem;
	fw_imu_plan plan;

	fw_imu_plan_begin(&plan);
	if (columns != NULL)
		assert_int_equal(fw_imu_parse_columns(columns, &plan.map, &problem), FW_OK);
	if (axes != NULL)
		assert_int_equal(fw_imu_parse_axes(axes, &plan.axes, &problem), FW_OK);
	if (time != NULL)
		assert_int_equal(fw_imu_parse_time(time, &plan.clock, &problem), FW_OK);
	fw_input_open_memory(&input, text, n);
	fw_imu_text_begin(&reader, &input, columns != NULL ? &plan : NULL);
}

static void begin(const char *text, const char *columns, const char *axes, const char *time)
{
	begin_bytes(text, strlen(text), columns, axes, time);
}

static void expect(fw_kind wanted, const char *columns)
{
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_OK);
	assert_int_equal(kind, wanted);
	assert_columns(kind, &record, columns);
}

static void expect_loss(uint64_t line, int column, const char *name)
{
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_ESYNTAX);
	assert_int_equal(reader.problem.line, line);
	assert_int_equal(reader.problem.column, column);
	assert_string_equal(reader.problem.name, name);
}

static void expect_end(uint64_t lost)
{
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_EOF);
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_EOF);
	assert_int_equal(reader.lost, lost);
}

#define RATES "gx=2 gy=3 gz=4 ax=5 ay=6 az=7"

static void a_table_without_header(void **state)
{
	(void)state;
	begin("1000.5,1,2,3,4,5,6\n1000.505,-1,-2,-3,-4,-5,-6\n", "time=1 " RATES, NULL, "gps,week=2300");
	expect(FW_imu,
	       "gps_week=2300 tow_s=1000.5 gyro_x_radps=1 gyro_y_radps=2 gyro_z_radps=3 accel_x_mps2=4 "
	       "accel_y_mps2=5 accel_z_mps2=6");
	expect(FW_imu, "tow_s=1000.505 gyro_x_radps=-1 accel_z_mps2=-6");
	expect_end(0);
}

static void units_and_axes(void **state)
{
	(void)state;
	begin("1.0 180 0 -90 1 2 -1\n", "time=1 gx=2:deg/s gy=3:deg/s gz=4:deg/s ax=5:g ay=6:g az=7:g", "FLU",
	      "gps,week=2300");
	expect(FW_imu, "gyro_x_radps=3.141592653589793 gyro_y_radps=0 gyro_z_radps=1.5707963267948966 "
	               "accel_x_mps2=9.80665 accel_y_mps2=-19.6133 accel_z_mps2=9.80665");
	expect_end(0);
}

/* By name, separators of all kinds, comments, a byte order mark, quotes, blanks and CR LF. */
static void headers_and_separators(void **state)
{
	static const char *const tables[] = {
	    "t,p,q,r,x,y,z\n5,1,2,3,4,5,6\n",
	    "# made by hand\n#t;p;q;r;x;y;z\n\n5;1;2;3;4;5;6\n# the end\n",
	    "% t\tp\tq\tr\tx\ty\tz\r\n5\t1\t2\t3\t4\t5\t6\r\n",
	    "t p q r x y z\n   5  1   2 3\t4 5  6  \n",
	    "\xef\xbb\xbf\"t\",\"p\",\"q\",\"r\",\"x\",\"y\",\"z\"\n\"5\", \"1\",2,3,4,5,6",
	    "title of the table\nz,y,x,r,q,p,t\n6,5,4,3,2,1,5\n",
	};

	(void)state;
	for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
		begin(tables[i], "time=t gx=p gy=q gz=r ax=x ay=y az=z", NULL, "gps,week=2300");
		expect(FW_imu,
		       "tow_s=5 gyro_x_radps=1 gyro_y_radps=2 gyro_z_radps=3 accel_x_mps2=4 accel_z_mps2=6");
		expect_end(0);
	}
}

static void scales_of_time(void **state)
{
	(void)state;
	/* 1756402240.961 - 315964800 = 2381 weeks + 408640.961 s */
	begin("1756402240.9610000,0,0,0,0,0,0\n", "time=1 " RATES, NULL, "unix-gps");
	expect(FW_imu, "gps_week=2381 tow_s=408640.961");
	begin("1756402240961000123,0,0,0,0,0,0\n", "time=1:ns " RATES, NULL, "unix-gps");
	expect(FW_imu, "gps_week=2381");
	assert_near(record.head.tow_s, 408640.961000123, 1e-9);
	begin("1756402240961000123,0,0,0,0,0,0\n", "time=1:ns " RATES, NULL, NULL); /* found out: UTC */
	expect(FW_imu, "gps_week=2381");
	assert_near(record.head.tow_s, 408658.961000123, 1e-9);
	begin("2.5e3,0,0,0,0,0,0\n", "time=1:ms " RATES, NULL, "boot,start=2300:10,shift=-1");
	expect(FW_imu, "gps_week=2300 tow_s=11.5");
	begin("2300 604799.99 0 0 0 0 0 0\n2301 0.01 0 0 0 0 0 0\n",
	      "week=1 time=2 gx=3 gy=4 gz=5 ax=6 ay=7 az=8", NULL, NULL);
	expect(FW_imu, "gps_week=2300 tow_s=604799.99");
	expect(FW_imu, "gps_week=2301 tow_s=0.01");
}

/* Seconds of week run over, and one line far off does not take the others with it. */
static void weeks_are_counted_on(void **state)
{
	(void)state;
	begin("604799 0 0 0 0 0 0\n0.5 0 0 0 0 0 0\n300000 0 0 0 0 0 0\n1.5 0 0 0 0 0 0\n", "time=1 " RATES,
	      NULL, "gps,week=2300");
	expect(FW_imu, "gps_week=2300 tow_s=604799");
	expect(FW_imu, "gps_week=2301 tow_s=0.5");
	expect(FW_imu, "gps_week=2301 tow_s=300000");
	expect(FW_imu, "gps_week=2301 tow_s=1.5");
}

/* 0.001 rad and 0.05 m/s in 5 ms; a gap of a second does not dilute them; time that stands still is refused.
 * */
static void increments_become_rates(void **state)
{
	(void)state;
	begin("100.000 .001 0 0 .05 0 0\n100.005 .001 0 0 .05 0 -.05\n100.010 .001 0 0 .05 0 0\n"
	      "101.010 .001 0 0 .05 0 0\n101.010 .001 0 0 .05 0 0\n101.015 .001 0 0 .05 0 0\n",
	      "kf-gins", NULL, "gps,week=2300");
	expect(FW_imu, "tow_s=100.005 gyro_x_radps=0.2 accel_x_mps2=10 accel_z_mps2=-10");
	expect(FW_imu, "tow_s=100.01 gyro_x_radps=0.2");
	expect(FW_imu, "tow_s=101.01 gyro_x_radps=0.2");
	expect_loss(5, 1, "time");
	expect(FW_imu, "tow_s=101.015 gyro_x_radps=0.2");
	expect_end(1);
}

static void kf_gins_in_its_three_layouts(void **state)
{
	(void)state;
	begin("456250.000 30.4447858054 114.4718661162 21.095 0.010 0.009 0.019\n", "kf-gins", NULL,
	      "gps,week=2017");
	expect(FW_pos,
	       "gps_week=2017 tow_s=456250 lat_deg=30.4447858054 lon_deg=114.4718661162 height_m=21.095 "
	       "sd_n_m=0.01 sd_e_m=0.009 sd_d_m=0.019 vn_mps=nan");
	expect_end(0);
	begin("2017 456300 30.5 114.5 20 1 2 3 -1 2 359\n", "kf-gins", NULL, NULL);
	expect(FW_nav,
	       "gps_week=2017 tow_s=456300 lat_deg=30.5 height_m=20 ve_mps=2 roll_deg=-1 heading_deg=359");
	expect_end(0);
	begin("456250.000 30.4447858054 114.4718661162 21.095 0.010 0.009 0.019\n", "kf-gins", NULL, NULL);
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_EUNKNOWN);
	assert_string_equal(reader.problem.name, "time");
}

static void euroc_says_itself_what_it_is(void **state)
{
	static const char table[] =
	    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
	    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
	    "1403636579758555392,-0.099,0.147,0.028,8.1,-0.3,-4.2\n";

	(void)state;
	assert_true(fw_imu_text_detect((const uint8_t *)table, sizeof table));
	begin(table, NULL, NULL, NULL);
	/* 1403636579.758555392 - 315964800 + 16 leap seconds = 1798 weeks + 241395.758555392 s */
	expect(FW_imu, "gps_week=1798 gyro_x_radps=-0.099 accel_x_mps2=8.1 accel_z_mps2=-4.2");
	assert_near(record.head.tow_s, 241395.758555392, 1e-9);
	expect_end(0);
}

static void lines_of_several_kinds(void **state)
{
	(void)state;
	begin(
	    "4000,mag,0.2,-0.08,0.425\n4000,airspeed,-3.9,-3.8\n4000,imu,-0.19,0.22,-9.9,-0.004,-0.007,0.01\n"
	    "4000,baro,487.76\n200000,gps,488103.0,85456073.0,473977508.0,-0.01,-0.02,0.5\n200000,imu,1,2\n",
	    "px4-replay", NULL, "boot,start=2000:0");
	expect(FW_mag, "gps_week=2000 tow_s=0.004 mag_x_ut=20 mag_y_ut=-8 mag_z_ut=42.5");
	expect(FW_imu,
	       "tow_s=0.004 gyro_x_radps=-0.004 gyro_z_radps=0.01 accel_x_mps2=-0.19 accel_z_mps2=-9.9");
	expect(FW_baro, "tow_s=0.004 baro_height_m=487.76");
	expect(FW_pos,
	       "tow_s=0.2 lat_deg=47.3977508 lon_deg=8.5456073 height_m=488.103 vn_mps=-0.01 ve_mps=-0.02 "
	       "vd_mps=0.5");
	expect_loss(6, 6, "gx");
	expect_end(1);
	assert_int_equal(reader.passed_over, 1);
}

/* Pressure: 900 hPa is 988.5 m in the standard atmosphere (tables of ISO 2533). */
static void everything_in_one_line(void **state)
{
	(void)state;
	begin("t,p,q,r,ax,ay,az,hx,hy,hz,P,lat,lon,h,vn,ve,vd,n,roll,pitch,yaw\n"
	      "10,1,2,3,4,5,6,.6,0,-.8,900,48,7,100,1,2,3,3,.1,.2,-1\n"
	      "11,1,2,3,4,5,6,.6,0,-.8,900,48,7,100,1,2,3,9,.1,.2,-1\n"
	      "12,1,2,3,4,5,6,.6,0,-.8,900,48,7,100,1,2,3,9,.1,.2,-1\n"
	      "13,1,2,3,4,5,6,.6,0,-.8,900,48,7,101,1,2,3,9,.1,.2,-1\n",
	      "time=t gx=p gy=q gz=r ax=ax ay=ay az=az mx=hx:1 my=hy:1 mz=hz:1 baro=P:hPa lat=lat lon=lon "
	      "height=h "
	      "vn=vn ve=ve vd=vd nsats=n roll=roll:rad pitch=pitch:rad heading=yaw:rad",
	      "RFU", "gps,week=2300");
	for (int line = 0; line < 4; line++) {
		expect(FW_imu, "gyro_x_radps=2 gyro_y_radps=1 gyro_z_radps=-3");
		expect(FW_mag, "mag_x_ut=0 mag_y_ut=30 mag_z_ut=40");
		expect(FW_baro, "");
		assert_near(number_of(kind, &record, "baro_height_m"), 988.5, 0.1);
		if (line == 1)
			expect(FW_pos, "tow_s=11 height_m=100 n_sats=9 vd_mps=3");
		if (line == 3)
			expect(FW_pos, "tow_s=13 height_m=101");
		expect(FW_nav, "roll_deg=5.729577951308232 heading_deg=302.70422048691768 lat_deg=nan");
	}
	expect_end(0);
}

/* The clock counts from power-up, 1 s of it is 1.0002 s; fixes at whole seconds are seen 0.1 s late in lines
 * of 10 ms. */
static void fixes_set_the_clock(void **state)
{
	enum { N = 6000, FIRST_FIX = 500 };
	static char text[N * 60];
	size_t n = 0;
	int fixes = 0;

	(void)state;
	for (int i = 0; i < N; i++) {
		const double boot = 3 + 0.01 * i, gps = 5000.25 + 1.0002 * boot;

		n += (size_t)snprintf(text + n, sizeof text - n, "%.6f,1,2,3,4,5,6,48,7,100,%.3f,%d\n", boot,
		                      i < FIRST_FIX ? 0 : floor(gps - 0.1), i < FIRST_FIX ? 0 : 8);
	}
	begin_bytes(text, n, "time=1 " RATES " lat=8 lon=9 height=10 fixtime=11 nsats=12", NULL,
	            "boot,week=2300,shift=0.1");
	assert_true(fw_imu_text_wants_survey(&reader));
	assert_int_equal(fw_imu_text_survey(&reader), FW_EOF);
	fw_input_open_memory(&input, text, n);
	fw_imu_text_again(&reader, &input);
	for (int i = 0; i < N; i++) {
		expect(FW_imu, "gps_week=2300 gyro_x_radps=1");
		assert_near(record.head.tow_s, 5000.25 + 1.0002 * (3 + 0.01 * i), 0.015);
		if (reader.queue.n > 0) {
			expect(FW_pos, "gps_week=2300 lat_deg=48");
			assert_near(record.head.tow_s, floor(record.head.tow_s), 0);
			fixes++;
		}
	}
	assert_in_range(fixes, 54, 56);
	expect_end(0);
	assert_int_equal(reader.untimed, 0);
}

static void damaged_lines_are_refused_and_named(void **state)
{
	(void)state;
	begin("1,1,2,3,4,5,6\n2,1,2,x,4,5,6\n3,1,2,3,4,5\n4,,,,,,\nx\n5,1,2,inf,4,5,6\n6,1,2,3,4,5,nan\n7,"
	      "1e400,2,3,4,5,6\n"
	      "-8,1,2,3,4,5,6\n9,1,2,3,4,5,6\n,1,2,3,4,5,6\n",
	      "time=1 " RATES, NULL, "gps,week=2300");
	expect(FW_imu, "tow_s=1");
	expect_loss(2, 4, "gz");
	expect_loss(3, 2, "gx");
	expect_loss(4, 0, "");
	expect_loss(5, 1, "time");
	expect_loss(6, 4, "gz");
	expect_loss(7, 2, "gx");
	expect_loss(8, 2, "gx");
	expect_loss(9, 1, "time");
	expect(FW_imu, "tow_s=9");
	expect_loss(11, 1, "time");
	expect_end(9);
	assert_int_equal(reader.rows, 2);
}

static void tables_with_which_nothing_can_be_done(void **state)
{
	(void)state;
	begin("a,b\n1,2\n", NULL, NULL, NULL);
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_EUNKNOWN);
	begin("a,b\n1,2\n", "time=a baro=c", NULL, "gps,week=1");
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_EUNKNOWN);
	assert_string_equal(reader.problem.name, "baro");
	begin("1,2\n", "time=1 baro=2", NULL, NULL);
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_EUNKNOWN);
	begin("1,2\n", "time=1 baro=2", NULL, "boot");
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_EUNKNOWN);
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_EUNKNOWN);
	begin("", "time=1 baro=2", NULL, "gps,week=1");
	expect_end(0);
}

static void a_line_without_end_is_refused(void **state)
{
	static char text[3 * FW_RINEX_LINE_MAX];

	(void)state;
	memset(text, '1', sizeof text);
	memcpy(text, "1,2\n", 4);
	memcpy(text + sizeof text - 5, "\n3,4\n", 5);
	begin_bytes(text, sizeof text, "time=1 baro=2", NULL, "gps,week=2300");
	expect(FW_baro, "tow_s=1");
	assert_int_equal(fw_imu_text_read(&reader, &kind, &record), FW_ESYNTAX);
	expect(FW_baro, "tow_s=3");
	expect_end(1);
}

/* ---- other people's logs ---- */

static const char *path_of(const char *name)
{
	static char path[4096];
	const char *data = getenv("FURROW_DATA");

	snprintf(path, sizeof path, "%s/%s", data != NULL ? data : "../shared/data", name);
	return path;
}

static bool begin_file(const char *name, const fw_imu_plan *plan)
{
	if (fw_input_open(&input, path_of(name)) != FW_OK) {
		print_message("skipped: no %s\n", name);
		return false;
	}
	fw_imu_text_begin(&reader, &input, plan);
	return true;
}

/* At rest the specific force points up, 1 g: the walk begins so. */
static void a_walk_with_an_imu_upside_down(void **state)
{
	double mean[3] = {0}, last = 0;
	fw_imu_problem problem;
	fw_imu_plan plan;
	int n = 0;

	(void)state;
	fw_imu_plan_begin(&plan);
	assert_int_equal(
	    fw_imu_parse_columns("time=1 ax=2:g ay=3:g az=4:g gx=5 gy=6 gz=7", &plan.map, &problem), FW_OK);
	assert_int_equal(fw_imu_parse_axes("-y,-x,-z", &plan.axes, &problem), FW_OK);
	assert_int_equal(fw_imu_parse_time("unix-gps", &plan.clock, &problem), FW_OK);
	if (!begin_file("ins/walk_0827/imu_1730_sf.csv", &plan))
		skip();
	for (; fw_imu_text_read(&reader, &kind, &record) == FW_OK; n++) {
		assert_true(kind == FW_imu && record.head.gps_week == 2381 && record.head.tow_s > last);
		last = record.head.tow_s;
		if (n == 0)
			assert_near(last, 408640.961, 1e-7);
		if (n < 500)
			for (int i = 0; i < 3; i++)
				mean[i] += number_of(kind, &record,
				                     (const char *[]){"accel_x_mps2", "accel_y_mps2",
				                                      "accel_z_mps2"}[i]) /
				           500;
	}
	assert_int_equal(n, 20455);
	assert_int_equal(reader.lost, 0);
	assert_near(mean[2], -9.8, 0.2);
	assert_near(hypot(mean[0], mean[1]), 0, 0.5);
	fw_input_close(&input);
}

static void a_drone_with_all_in_one_table(void **state)
{
	uint64_t count[FW_RECORD_COUNT] = {0};
	fw_imu_problem problem;
	fw_imu_plan plan;

	(void)state;
	fw_imu_plan_begin(&plan);
	assert_int_equal(fw_imu_parse_columns(
	                     "time=time gx=p gy=q gz=r ax=ax ay=ay az=az mx=hx:1 my=hy:1 mz=hz:1 baro=h "
	                     "lat=lat lon=lon height=alt vn=vn ve=ve vd=vd nsats=satVisible nlat=navlat:rad "
	                     "nlon=navlon:rad nheight=navalt nvn=navvn nve=navve nvd=navvd roll=phi:rad "
	                     "pitch=theta:rad heading=psi:rad",
	                     &plan.map, &problem),
	                 FW_OK);
	assert_int_equal(fw_imu_parse_time("boot,start=1709:319547.2", &plan.clock, &problem), FW_OK);
	if (!begin_file("ins/thor_flight75/thor_flight75.csv.gz", &plan))
		skip();
	while (fw_imu_text_read(&reader, &kind, &record) == FW_OK)
		count[kind]++;
	assert_int_equal(count[FW_imu], 34812);
	assert_int_equal(count[FW_mag], 34812);
	assert_int_equal(count[FW_baro], 34812);
	assert_in_range(count[FW_pos], 660, 690); /* 674 s with satellites, one each second */
	assert_in_range(count[FW_nav], 33000, 34812);
	assert_int_equal(reader.lost, 0);
	fw_input_close(&input);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(a_table_without_header),
	    cmocka_unit_test(units_and_axes),
	    cmocka_unit_test(headers_and_separators),
	    cmocka_unit_test(scales_of_time),
	    cmocka_unit_test(weeks_are_counted_on),
	    cmocka_unit_test(increments_become_rates),
	    cmocka_unit_test(kf_gins_in_its_three_layouts),
	    cmocka_unit_test(euroc_says_itself_what_it_is),
	    cmocka_unit_test(lines_of_several_kinds),
	    cmocka_unit_test(everything_in_one_line),
	    cmocka_unit_test(fixes_set_the_clock),
	    cmocka_unit_test(damaged_lines_are_refused_and_named),
	    cmocka_unit_test(tables_with_which_nothing_can_be_done),
	    cmocka_unit_test(a_line_without_end_is_refused),
	    cmocka_unit_test(a_walk_with_an_imu_upside_down),
	    cmocka_unit_test(a_drone_with_all_in_one_table),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
