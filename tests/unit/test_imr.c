/* imr: files made byte by byte after the layout in the header's comment. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "formats/imr.h"

#include "log_test.h"

static log_bytes file;
static fw_input input;
static fw_imr reader;
static fw_any_record record;
static fw_kind kind;

static void put_header(int increments, double gyro_scale, double accel_scale, int scale_of_time)
{
	file.n = 0;
	put_text(&file, "$IMURAW", 8);
	put_le(&file, 0, 1);
	put_f64(&file, 8.8);
	put_le(&file, (uint64_t)increments, 4);
	put_le(&file, (uint64_t)increments, 4);
	put_f64(&file, 200);
	put_f64(&file, gyro_scale);
	put_f64(&file, accel_scale);
	put_le(&file, (uint64_t)scale_of_time, 4);
	put_le(&file, 0, 4);
	put_f64(&file, 0.25); /* bias of the time tags */
	assert_int_equal(file.n, 65);
	while (file.n < 512)
		put_le(&file, 0, 1);
}

static void put_sample(double tow, int gx, int gy, int gz, int ax, int ay, int az)
{
	put_f64(&file, tow);
	const int v[] = {gx, gy, gz, ax, ay, az};
	for (int i = 0; i < 6; i++)
		put_le(&file, (uint32_t)v[i], 4);
}

static void begin(const char *axes, const char *time)
{
	fw_imu_problem problem;
	fw_imu_plan plan;

	fw_imu_plan_begin(&plan);
	if (axes != NULL)
		assert_int_equal(fw_imu_parse_axes(axes, &plan.axes, &problem), FW_OK);
	if (time != NULL)
		assert_int_equal(fw_imu_parse_time(time, &plan.clock, &problem), FW_OK);
	fw_input_open_memory(&input, file.bytes, file.n);
	fw_imr_begin(&reader, &input, &plan);
}

static void expect(const char *columns)
{
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_OK);
	assert_int_equal(kind, FW_imu);
	assert_columns(kind, &record, columns);
}

/* 180 units of 0.5 deg/s and 100 units of 0.01 m/s^2; RFU to FRD: y, x, -z. The week ends. */
static void rates(void **state)
{
	(void)state;
	put_header(0, 0.5, 0.01, 2);
	put_sample(604799.5, 360, -180, 90, 100, -200, 981);
	put_sample(0.5, 0, 0, 0, 0, 0, 0);
	begin(NULL, "gps,week=2300");
	assert_true(fw_imr_detect(file.bytes, file.n));
	expect(
	    "gps_week=2300 tow_s=604799.75 gyro_x_radps=-1.5707963267948966 gyro_y_radps=3.141592653589793 "
	    "gyro_z_radps=-0.7853981633974483 accel_x_mps2=-2 accel_y_mps2=1 accel_z_mps2=-9.81");
	expect("gps_week=2301 tow_s=0.75");
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_EOF);
	begin("FRD", "gps,week=2300");
	expect("accel_x_mps2=1 accel_y_mps2=-2 accel_z_mps2=9.81");
}

static void increments(void **state)
{
	(void)state;
	put_header(1, 1, 0.001, 0);
	put_sample(10, 1, 2, 3, 4, 5, 6);
	put_sample(10.005, 0, 9, 0, 0, 50, 0);
	put_sample(10.005, 0, 9, 0, 0, 50, 0);
	put_sample(10.010, 0, 9, 0, 0, 50, 0);
	begin(NULL, "gps,week=2300");
	expect("tow_s=10.255 gyro_x_radps=31.41592653589793 accel_x_mps2=10");
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_ESYNTAX);
	assert_int_equal(reader.lost_offset, 512 + 64);
	expect("tow_s=10.26 accel_x_mps2=10");
	assert_int_equal(reader.lost, 1);
}

static void samples_without_a_time(void **state)
{
	(void)state;
	put_header(0, 1, 1, 2);
	put_sample((double)NAN, 1, 2, 3, 4, 5, 6);
	put_sample(-1, 1, 2, 3, 4, 5, 6);
	put_sample(5, 1, 2, 3, 4, 5, 6);
	put_bytes(&file, "half", 4);
	begin(NULL, "gps,week=2300");
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_ESYNTAX);
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_ESYNTAX);
	expect("tow_s=5.25");
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_ETRUNCATED);
	assert_int_equal(reader.lost, 2);
}

static void headers_with_which_nothing_can_be_done(void **state)
{
	(void)state;
	put_header(0, 1, 1, 1);
	begin(NULL, "gps,week=2300");
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_EUNKNOWN);
	put_header(0, (double)NAN, 1, 2);
	begin(NULL, "gps,week=2300");
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_EUNKNOWN);
	put_header(0, 1, 1, 2);
	begin(NULL, NULL);
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_EUNKNOWN);
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_EUNKNOWN);
	file.bytes[8] = 1;
	begin(NULL, "gps,week=2300");
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_EUNKNOWN);
	file.n = 100;
	begin(NULL, "gps,week=2300");
	assert_int_equal(fw_imr_read(&reader, &kind, &record), FW_ETRUNCATED);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(rates),
	    cmocka_unit_test(increments),
	    cmocka_unit_test(samples_without_a_time),
	    cmocka_unit_test(headers_with_which_nothing_can_be_done),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
