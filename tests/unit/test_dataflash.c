/* dataflash: logs made byte by byte after ArduPilot's LogStructure.h (dataflash_make.h); the clock's offset
 * is known, since it was chosen. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../dataflash_make.h"
#include "formats/dataflash.h"

#include "log_test.h"

enum { WEEK = 2300, BOOT_S = 1000 }; /* the autopilot was switched on at 1000 s of the week */

static log_bytes file;
static fw_input input;
static fw_dataflash reader;
static fw_any_record record;
static fw_kind kind;

static const fw_dataflash_plan no_lag = {-1, -1, -1, -1, 0};

/* A fix at a time since boot: of that moment, its message comes 120 ms later. */
static df_fix fix_at(uint64_t us)
{
	return (df_fix){us + 120000, 0, 3, 1, (uint32_t)(BOOT_S * 1000 + us / 1000), WEEK};
}

static void begin_log(void)
{
	file.n = 0;
	df_formats(&file);
}

static void begin_as(fw_dataflash_kind form, const fw_dataflash_plan *plan)
{
	fw_input_open_memory(&input, file.bytes, file.n);
	assert_int_equal(fw_dataflash_detect(file.bytes, file.n), form);
	fw_dataflash_begin(&reader, &input, form, plan);
}

/* Reads the log twice, as files are. */
static void survey(const fw_dataflash_plan *plan)
{
	begin_as(FW_DATAFLASH_BINARY, plan);
	(void)!fw_dataflash_survey(&reader);
	fw_input_open_memory(&input, file.bytes, file.n);
	fw_dataflash_again(&reader, &input);
}

static void expect(fw_kind wanted, const char *columns)
{
	const fw_status status = fw_dataflash_read(&reader, &kind, &record);

	if (status != FW_OK)
		fail_msg("%d: %s", status, reader.reason);
	assert_int_equal(kind, wanted);
	assert_columns(kind, &record, columns);
}

static void expect_end(uint64_t lost)
{
	assert_int_equal(fw_dataflash_read(&reader, &kind, &record), FW_EOF);
	assert_int_equal(fw_dataflash_read(&reader, &kind, &record), FW_EOF);
	assert_int_equal(reader.lost, lost);
}

/* 2 / sqrt(2) and 0.5 / sqrt(2) */
#define GPS_COLUMNS                                                                                          \
	"gps_week=2300 mode=1 two_d=0 lat_deg=48.5 lon_deg=-7.25 vn_mps=6.123233995736766e-16 ve_mps=10 "    \
	"vd_mps=1.5 n_sats=17"
#define GPA_COLUMNS "sd_n_m=1.4142135623730951 sd_e_m=1.4142135623730951 sd_d_m=3 cov_vdvd_m2ps2=0.25"

static void everything_of_a_log(void **state)
{
	df_fix fix = fix_at(2000000);

	(void)state;
	begin_log();
	df_imu(&file, 1000000, 0, 0.5F, -9.75F, 1); /* before the first fix: the survey knows when that was */
	df_gps(&file, &fix);
	df_accuracy(&file, &fix, 24575);
	df_mag(&file, 2500000, 0, 250, 1);
	df_baro(&file, 2600000, 12.5F);
	df_attitude(&file, 2700000);
	df_camera(&file, 2800000);
	df_message(&file, 2900000, "nothing of interest");
	survey(NULL);
	expect(FW_imu,
	       "gps_week=2300 tow_s=1001 gyro_x_radps=0.5 gyro_y_radps=0.25 gyro_z_radps=-0.5 accel_x_mps2=1 "
	       "accel_y_mps2=2 accel_z_mps2=-9.75");
	expect(FW_pvt, "tow_s=1002 height_m=245.75 undulation_m=45.25 " GPS_COLUMNS);
	assert_columns(kind, &record, GPA_COLUMNS);
	expect(FW_mag, "tow_s=1002.5 mag_x_ut=25 mag_y_ut=-10 mag_z_ut=40");
	expect(FW_baro, "tow_s=1002.6 baro_height_m=12.5");
	expect(FW_nav, "tow_s=1002.7 roll_deg=1.5 pitch_deg=-2.25 heading_deg=271 lat_deg=nan");
	assert_string_equal(text_of(kind, &record, "status"), "autopilot");
	expect(FW_event, "tow_s=1002.8 source=1");
	expect_end(0);
	assert_false(reader.msl);
	assert_int_equal(reader.messages, 12 + 8);
}

/* The least latency is that of the parameter, of the plan, or 0.12 s. */
static void latency_comes_from_the_log(void **state)
{
	const df_fix fix = fix_at(2000000);

	(void)state;
	begin_log();
	df_parameter(&file, "GPS_DELAY_MS", 220);
	df_gps(&file, &fix);
	df_imu(&file, 3000000, 0, 0, 0, 1);
	survey(NULL);
	expect(FW_pvt, "tow_s=1002");
	expect(FW_imu, "tow_s=1003.1");
	survey(&no_lag);
	expect(FW_pvt, "tow_s=1002");
	expect(FW_imu, "tow_s=1002.88");
}

static void from_a_pipe_what_comes_before_the_first_fix_has_no_time(void **state)
{
	const df_fix fix = fix_at(2000000);

	(void)state;
	begin_log();
	df_imu(&file, 1000000, 0, 0.5F, -9.75F, 1);
	df_gps(&file, &fix);
	df_imu(&file, 3000000, 0, 0.5F, -9.75F, 1);
	begin_as(FW_DATAFLASH_BINARY, NULL);
	expect(FW_pvt, "tow_s=1002");
	expect(FW_imu, "tow_s=1003");
	expect_end(0);
	assert_int_equal(reader.untimed, 1);
}

static void modes_and_heights(void **state)
{
	static const int status[] = {0, 1, 2, 3, 4, 5, 6, 7}, mode[] = {0, 0, 1, 1, 2, 5, 4, 0};

	(void)state;
	begin_log();
	for (int i = 0; i < 8; i++) {
		df_fix fix = fix_at((uint64_t)(i + 1) * 1000000);

		fix.status = status[i];
		df_gps(&file, &fix);
	}
	survey(NULL);
	for (int i = 0; i < 8; i++) {
		expect(FW_pvt, "gps_week=2300 n_sats=17 undulation_m=nan sd_n_m=nan");
		assert_near(number_of(kind, &record, "mode"), mode[i], 0);
		if (mode[i] != 0)
			assert_columns(kind, &record,
			               i == 2 ? "two_d=1 height_m=200.5" : "two_d=0 height_m=200.5");
		assert_true(reader.msl == (i >= 2));
	}
	expect_end(0);
}

/* Of two IMUs the first that is healthy, of two receivers the one in use; or those of the plan. */
static void instances_are_chosen(void **state)
{
	const fw_dataflash_plan plan = {0, 1, -1, 1, 0.12};

	(void)state;
	begin_log();
	for (uint64_t us = 1000000; us < 3000000; us += 1000000) {
		df_fix first = fix_at(us), second = fix_at(us);

		first.used = 0;
		second.instance = 1;
		second.week_ms += 100; /* to tell them apart */
		df_gps(&file, &first);
		df_gps(&file, &second);
		df_imu(&file, us + 500000, 0, 1, 0, us > 1500000);
		df_imu(&file, us + 500000, 1, 2, 0, 1);
		df_mag(&file, us + 600000, 0, 10, 1);
		df_mag(&file, us + 600000, 1, 20, 1);
	}
	survey(NULL);
	for (int i = 0; i < 2; i++) {
		expect(FW_pvt, i == 0 ? "tow_s=1001.1" : "tow_s=1002.1");
		expect(FW_imu, "gyro_x_radps=2");
		expect(FW_mag, "mag_x_ut=1");
	}
	expect_end(0);
	survey(&plan);
	expect(FW_pvt, "tow_s=1001.1");
	expect(FW_mag, "mag_x_ut=2");
	expect(FW_pvt, "tow_s=1002.1");
	expect(FW_imu, "gyro_x_radps=1");
	expect(FW_mag, "mag_x_ut=2");
	expect_end(0);
	assert_int_equal(reader.unhealthy, 1);
}

/* Gyro at twice the rate of the accelerometer: means of what there is of each. */
static void raw_samples_where_there_is_no_imu(void **state)
{
	const df_fix fix = fix_at(1000000);

	(void)state;
	begin_log();
	df_gps(&file, &fix);
	for (uint64_t us = 2000000; us < 2004000; us += 2000) {
		df_raw(&file, DF_GYR, us, 1);
		df_raw(&file, DF_GYR, us + 1000, 3);
		df_raw(&file, DF_ACC, us + 1000, 5);
	}
	survey(NULL);
	expect(FW_pvt, "tow_s=1001");
	expect(FW_imu, "tow_s=1002.001 gyro_x_radps=2 gyro_y_radps=2 gyro_z_radps=3 accel_x_mps2=5");
	expect(FW_imu, "tow_s=1002.003 gyro_x_radps=2");
	expect_end(0);
	df_imu(&file, 2005000, 0, 7, 0, 1); /* there is one after all */
	survey(NULL);
	expect(FW_pvt, "tow_s=1001");
	expect(FW_imu, "tow_s=1002.005 gyro_x_radps=7");
	expect_end(0);
}

static void samples_that_are_not_finite_are_left_out(void **state)
{
	const df_fix fix = fix_at(1000000);

	(void)state;
	begin_log();
	df_gps(&file, &fix);
	df_imu(&file, 2000000, 0, NAN, 0, 1);
	df_imu(&file, 2010000, 0, INFINITY, 0, 1);
	df_imu(&file, 2020000, 0, 1, 0, 1);
	survey(NULL);
	expect(FW_pvt, "tow_s=1001");
	expect(FW_imu, "tow_s=1002.02");
	expect_end(0);
	assert_int_equal(reader.unhealthy, 2);
}

/* ---- damage ---- */

/* Six IMU samples; where[i] is where the i-th begins. */
static void make_six(size_t where[7])
{
	const df_fix fix = fix_at(1000000);

	begin_log();
	df_gps(&file, &fix);
	for (int i = 0; i < 6; i++) {
		where[i] = file.n;
		df_imu(&file, 2000000 + (uint64_t)i * 10000, 0, (float)i, 0, 1);
	}
	where[6] = file.n;
}

/* Which samples come through, as bits; losses are reported at `offset`. */
static unsigned samples(uint64_t *offset)
{
	unsigned seen = 0;
	fw_status status;

	*offset = 0;
	survey(NULL);
	while ((status = fw_dataflash_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_ESYNTAX)
			*offset = reader.lost_offset;
		else if (kind == FW_imu)
			seen |= 1U << (int)number_of(kind, &record, "gyro_x_radps");
	}
	return seen;
}

static void damage_costs_what_it_hits(void **state)
{
	size_t where[7];
	uint64_t offset;

	(void)state;
	make_six(where);
	assert_int_equal(samples(&offset), 63);
	assert_int_equal(reader.lost, 0);

	file.bytes[where[2]] ^= 1; /* the sync: this one and the one before, which nothing follows */
	assert_int_equal(samples(&offset), 63 & ~6);
	assert_int_equal(offset, where[1]);
	assert_int_equal(reader.lost, 1);
	assert_int_equal(reader.bytes_lost, where[3] - where[1]);

	make_six(where);
	file.bytes[where[2] + 2] = 7; /* a type that there is not */
	assert_int_equal(samples(&offset), 63 & ~4);
	assert_int_equal(offset, where[2]);

	make_six(where);
	file.bytes[where[2] + 2] = DF_TEXT; /* another type's length */
	assert_int_equal(samples(&offset), 63 & ~4);
	assert_int_equal(offset, where[2]);
	assert_int_equal(reader.bytes_lost, where[3] - where[2]);
}

static void bytes_that_are_missing_or_too_many(void **state)
{
	size_t where[7];
	uint64_t offset;

	(void)state;
	make_six(where);
	memmove(file.bytes + where[3] + 20, file.bytes + where[3] + 27, file.n - where[3] - 27);
	file.n -= 7;
	assert_int_equal(samples(&offset), 63 & ~8);
	assert_int_equal(offset, where[3]);
	make_six(where);
	memmove(file.bytes + where[3] + 5, file.bytes + where[3], file.n - where[3]);
	memcpy(file.bytes + where[3], "\xa3\x95\xa3xy", 5);
	file.n += 5;
	assert_int_equal(samples(&offset), 63);
	assert_int_equal(reader.lost, 1);
	assert_int_equal(reader.bytes_lost, 5);
}

static void the_end_is_found_at_every_byte(void **state)
{
	size_t where[7];
	uint64_t offset;

	(void)state;
	make_six(where);
	for (size_t n = where[4] + 1; n < where[5]; n++) {
		file.n = n;
		assert_int_equal(samples(&offset), 15);
		assert_int_equal(reader.final, FW_ETRUNCATED);
		assert_int_equal(reader.lost, 0);
	}
	file.n = where[5];
	assert_int_equal(samples(&offset), 31);
	assert_int_equal(reader.final, FW_EOF);
}

static void padding_at_the_end_is_no_loss(void **state)
{
	size_t where[7];
	uint64_t offset;

	(void)state;
	for (int byte = 0; byte < 256; byte += 255) {
		make_six(where);
		memset(file.bytes + file.n, byte, 5000);
		file.n += 5000;
		assert_int_equal(samples(&offset), 63);
		assert_int_equal(reader.lost, 0);
		assert_int_equal(reader.final, FW_EOF);
	}
	df_imu(&file, 5000000, 0, 6, 0, 1); /* but it was not the end */
	assert_int_equal(samples(&offset), 127);
	assert_int_equal(reader.lost, 1);
	assert_int_equal(offset, where[6]);
}

/* A definition that contradicts itself is none, and its messages are of no known type. */
static void definitions_are_checked(void **state)
{
	const df_fix fix = fix_at(1000000);

	(void)state;
	begin_log();
	df_format(&file, 200, 50, "IMU2", "Qfff", "TimeUS,GyrX,GyrY,GyrZ");
	df_format(&file, 201, 20, "ODD", "Q?", "TimeUS,What");
	df_gps(&file, &fix);
	survey(NULL);
	assert_int_equal(fw_dataflash_read(&reader, &kind, &record), FW_ESYNTAX);
	assert_int_equal(reader.lost_offset, 12 * 89);
	assert_int_equal(fw_dataflash_read(&reader, &kind, &record), FW_ESYNTAX);
	expect(FW_pvt, "tow_s=1001");
	expect_end(2);
}

/* Before 4.1 each instance had a name of its own, and no health. */
static void old_logs(void **state)
{
	const fw_dataflash_plan second = {1, -1, -1, -1, 0.12};
	const df_fix fix = fix_at(1000000);
	static const char *const names[] = {"IMU", "IMU2"};

	(void)state;
	file.n = 0;
	df_format(&file, 128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
	df_format(&file, DF_GPS, 51, "GPS", "QBBIHBcLLeffffB",
	          "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U");
	for (int i = 0; i < 2; i++)
		df_format(&file, 160 + i, 35, names[i], "Qffffff", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
	df_gps(&file, &fix);
	for (int i = 0; i < 2; i++) {
		df_begin(&file, 160 + i);
		put_le(&file, 2000000, 8);
		for (int k = 0; k < 6; k++)
			put_f32(&file, (float)(10 * i + k));
	}
	survey(NULL);
	expect(FW_pvt, "tow_s=1001");
	expect(FW_imu, "tow_s=1002 gyro_x_radps=0 accel_z_mps2=5");
	expect_end(0);
	survey(&second);
	expect(FW_pvt, "tow_s=1001");
	expect(FW_imu, "tow_s=1002 gyro_x_radps=10 accel_z_mps2=15");
	expect_end(0);
}

/* ---- text ---- */

static const char text_log[] =
    "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n"
    "FMT, 129, 31, PARM, QNf, TimeUS,Name,Value\n"
    "FMT, 130, 45, GPS, QBBIHBcLLeffffB, TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U\n"
    "FMT, 131, 31, IMU, QBffffffIIfBBHH, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz\n"
    "FMT, 132, 31, MSG, QZ, TimeUS,Message\n"
    "PARM, 1000, GPS1_DELAY_MS, 200\n"
    "GPS, 1200000, 0, 6, 1001000, 2300, 17, 0.75, 48.5, -7.25, 200.5, 10, 90, 1.5, 0, 1\r\n"
    "MSG, 1300000, text, with commas\n"
    "\n"
    "IMU, 2000000, 0, 0.5, 0.25, -0.5, 1, 2, -9.75, 0, 0, 30.1, 1, 1, 1000, 1000\n"
    "IMU, 2010000, 0, 0.5, 0.25, x, 1, 2, -9.75, 0, 0, 30.1, 1, 1, 1000, 1000\n"
    "IMU, 2020000, 0, 0.5\n"
    "IMU, 2030000, 0, nan, 0.25, -0.5, 1, 2, -9.75, 0, 0, 30.1, 1, 1, 1000, 1000\n"
    "$%&/ nonsense\n"
    "IMU, 2040000, 0, 0.75, 0.25, -0.5, 1, 2, -9.75, 0, 0, 30.1, 1, 1, 1000, 1000";

static void a_log_as_text(void **state)
{
	static const uint64_t losses[] = {11, 12, 14};

	(void)state;
	file.n = sizeof text_log - 1;
	memcpy(file.bytes, text_log, file.n);
	begin_as(FW_DATAFLASH_TEXT, NULL);
	assert_int_equal(fw_dataflash_survey(&reader), FW_EOF);
	fw_input_open_memory(&input, file.bytes, file.n);
	fw_dataflash_again(&reader, &input);
	expect(
	    FW_pvt,
	    "gps_week=2300 tow_s=1001 mode=4 lat_deg=48.5 lon_deg=-7.25 height_m=200.5 vd_mps=1.5 n_sats=17");
	expect(FW_imu, "tow_s=1002 gyro_x_radps=0.5 gyro_z_radps=-0.5 accel_x_mps2=1 accel_z_mps2=-9.75");
	for (int i = 0; i < 3; i++) {
		assert_int_equal(fw_dataflash_read(&reader, &kind, &record), FW_ESYNTAX);
		assert_int_equal(reader.lost_offset, losses[i]);
	}
	expect(FW_imu, "tow_s=1002.04 gyro_x_radps=0.75");
	expect_end(3);
	assert_int_equal(reader.unhealthy, 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(everything_of_a_log),
	    cmocka_unit_test(latency_comes_from_the_log),
	    cmocka_unit_test(from_a_pipe_what_comes_before_the_first_fix_has_no_time),
	    cmocka_unit_test(modes_and_heights),
	    cmocka_unit_test(instances_are_chosen),
	    cmocka_unit_test(raw_samples_where_there_is_no_imu),
	    cmocka_unit_test(samples_that_are_not_finite_are_left_out),
	    cmocka_unit_test(damage_costs_what_it_hits),
	    cmocka_unit_test(bytes_that_are_missing_or_too_many),
	    cmocka_unit_test(the_end_is_found_at_every_byte),
	    cmocka_unit_test(padding_at_the_end_is_no_loss),
	    cmocka_unit_test(definitions_are_checked),
	    cmocka_unit_test(old_logs),
	    cmocka_unit_test(a_log_as_text),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
