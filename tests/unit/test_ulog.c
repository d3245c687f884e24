/* ulog: files made byte by byte after PX4's documentation (ulog_make.h). The clock: the autopilot was
 * switched on at 2025-08-28T17:00:00 GPST, week 2381, 406800 s; Unix time 1756400382 s, by hand: 315964800 +
 * 2381 weeks + 406800 - 18. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../ulog_make.h"
#include "formats/ulog.h"

#include "log_test.h"

#define BOOT_UNIX_US UINT64_C(1756400382000000)

static log_bytes file;
static fw_input input;
static fw_ulog reader;
static fw_any_record record;
static fw_kind kind;

/* A fix of a moment, published 110 ms later. */
static ul_fix fix_at(uint64_t us)
{
	return (ul_fix){us + 110000, BOOT_UNIX_US + us, 3, 547.5};
}

static void begin_log(void)
{
	ul_file(&file);
	ul_flags(&file, 0, 0);
	ul_definitions(&file);
	ul_subscriptions(&file);
}

static void begin(const fw_ulog_plan *plan)
{
	fw_input_open_memory(&input, file.bytes, file.n);
	fw_ulog_begin(&reader, &input, plan);
}

static void survey(const fw_ulog_plan *plan)
{
	begin(plan);
	(void)!fw_ulog_survey(&reader);
	fw_input_open_memory(&input, file.bytes, file.n);
	fw_ulog_again(&reader, &input);
}

static void expect(fw_kind wanted, const char *columns)
{
	const fw_status status = fw_ulog_read(&reader, &kind, &record);

	if (status != FW_OK)
		fail_msg("%d: %s", status, reader.reason);
	assert_int_equal(kind, wanted);
	assert_columns(kind, &record, columns);
}

static void expect_end(uint64_t lost)
{
	assert_int_equal(fw_ulog_read(&reader, &kind, &record), FW_EOF);
	assert_int_equal(fw_ulog_read(&reader, &kind, &record), FW_EOF);
	assert_int_equal(reader.lost, lost);
}

#define FIX_COLUMNS                                                                                          \
	"gps_week=2381 mode=1 two_d=0 lat_deg=47.5 lon_deg=-8.5 height_m=547.5 undulation_m=47.5 vn_mps=1 "  \
	"ve_mps=-2 vd_mps=0.25 n_sats=12 sd_n_m=1.4142135623730951 sd_d_m=3 cov_vdvd_m2ps2=0.25"

static void everything_of_a_log(void **state)
{
	ul_fix fix = fix_at(2000000);

	(void)state;
	begin_log();
	assert_true(fw_ulog_detect(file.bytes, file.n));
	ul_combined(&file, 1000000, 0.5F);
	ul_gps(&file, &fix);
	ul_mag(&file, 2500000);
	ul_air(&file, 2600000);
	ul_attitude(&file, 2700000);
	ul_capture(&file, 2800000);
	ul_dropout(&file, 150);
	ul_sync(&file);
	ul_string(&file, 'L', "6\1\2\3\4\5\6\7\10text");
	survey(NULL);
	expect(
	    FW_imu,
	    "gps_week=2381 tow_s=406801 gyro_x_radps=0.5 gyro_y_radps=0.25 gyro_z_radps=-0.5 accel_x_mps2=1 "
	    "accel_y_mps2=2 accel_z_mps2=-9.75");
	expect(FW_pvt, "tow_s=406802 " FIX_COLUMNS);
	expect(FW_mag, "tow_s=406802.499 mag_x_ut=25 mag_y_ut=-12.5 mag_z_ut=50");
	expect(FW_baro, "tow_s=406802.599 baro_height_m=488.5");
	expect(FW_nav, "tow_s=406802.6999 pitch_deg=0 heading_deg=0 lat_deg=nan");
	assert_near(number_of(kind, &record, "roll_deg"), 90, 1e-5);
	expect(FW_event, "tow_s=406802.8 source=1");
	expect_end(0);
	assert_true(reader.dropouts == 1 && reader.dropout_ms == 150 && !reader.msl);
}

/* Increments only where they join on to each other. */
static void the_better_imu_is_taken(void **state)
{
	const ul_fix fix = fix_at(1000000);

	(void)state;
	begin_log();
	ul_gps(&file, &fix);
	for (uint64_t us = 2000000; us < 2040000; us += 5000) {
		ul_combined(&file, us, 0.5F);
		ul_imu(&file, UL_IMU, us + 200, 0.0078125F, 5000);
	}
	survey(NULL);
	expect(FW_pvt, "");
	for (int i = 0; i < 8; i++) {
		expect(FW_imu, "gyro_x_radps=1.5625 accel_z_mps2=-12.5");
		assert_near(record.head.tow_s, 406802 + 0.005 * i, 1e-9);
	}
	expect_end(0);
	for (uint64_t us = 2540000; us < 9000000; us += 500000) /* every hundredth is logged */
		ul_imu(&file, UL_IMU, us, 0.0078125F, 5000);
	survey(NULL);
	expect(FW_pvt, "");
	for (int i = 0; i < 8; i++)
		expect(FW_imu, "gyro_x_radps=0.5");
	expect_end(0);
	begin(NULL); /* a pipe: sensor_combined, since it is there */
	expect(FW_pvt, "");
	expect(FW_imu, "gyro_x_radps=0.5");
}

static void increments_alone_and_other_instances(void **state)
{
	const ul_fix fix = fix_at(1000000);
	fw_ulog_plan plan = fw_ulog_default_plan();

	(void)state;
	begin_log();
	ul_gps(&file, &fix);
	for (uint64_t us = 2000000; us < 4000000; us += 5000) {
		ul_imu(&file, UL_IMU, us, 0.0078125F, 5000);
		ul_imu(&file, UL_IMU_1, us, 0.015625F, 5000);
	}
	survey(NULL);
	expect(FW_pvt, "");
	expect(FW_imu, "gyro_x_radps=1.5625 tow_s=406801.9998");
	plan.imu = 1;
	survey(&plan);
	expect(FW_pvt, "");
	expect(FW_imu, "gyro_x_radps=3.125 tow_s=406801.9998");
	begin(NULL); /* a pipe: after a second without the other */
	expect(FW_pvt, "");
	expect(FW_imu, "gyro_x_radps=1.5625");
	assert_near(record.head.tow_s, 406803.0048, 1e-6);
}

static void positions_of_the_topic_that_has_more(void **state)
{
	(void)state;
	begin_log();
	for (uint64_t i = 1; i < 5; i++) {
		ul_fix fix = fix_at(i * 1000000);

		ul_sensor_gps(&file, &fix);
		fix.utc_us += 500000;
		fix.us += 500000;
		if (i == 2)
			ul_gps(&file, &fix);
	}
	survey(NULL);
	for (int i = 1; i < 5; i++) {
		expect(FW_pvt, FIX_COLUMNS);
		assert_near(record.head.tow_s, 406800 + i, 1e-9);
	}
	expect_end(0);
}

static void modes_heights_and_latency(void **state)
{
	static const int mode[] = {0, 0, 1, 1, 2, 5, 4, 0};

	(void)state;
	begin_log();
	ul_parameter(&file, "float EKF2_GPS_DELAY", 60);
	for (int i = 0; i < 8; i++) {
		ul_fix fix = fix_at((uint64_t)(i + 1) * 1000000);

		fix.fix = i;
		fix.ellipsoid_m = 0; /* not known */
		ul_gps(&file, &fix);
	}
	ul_combined(&file, 20000000, 1);
	survey(NULL);
	for (int i = 0; i < 8; i++) {
		expect(FW_pvt, mode[i] == 0 ? "lat_deg=nan" : "height_m=500 undulation_m=nan");
		assert_near(number_of(kind, &record, "mode"), mode[i], 0);
	}
	expect(FW_imu, "tow_s=406819.95");
	assert_true(reader.msl);
}

static void a_fix_without_utc_is_as_late_as_the_others(void **state)
{
	ul_fix fix = fix_at(1000000);

	(void)state;
	begin_log();
	ul_gps(&file, &fix);
	fix = fix_at(2000000);
	fix.utc_us = 0;
	ul_gps(&file, &fix);
	survey(NULL);
	expect(FW_pvt, "tow_s=406801");
	expect(FW_pvt, "tow_s=406802");
	expect_end(0);
}

static void without_positions_there_is_no_time(void **state)
{
	(void)state;
	begin_log();
	ul_combined(&file, 1000000, 1);
	ul_combined(&file, 1005000, 1);
	survey(NULL);
	expect_end(0);
	assert_int_equal(reader.untimed, 2);
}

static void samples_that_are_not_finite_are_left_out(void **state)
{
	const ul_fix fix = fix_at(1000000);

	(void)state;
	begin_log();
	ul_gps(&file, &fix);
	ul_combined(&file, 2000000, NAN);
	ul_combined(&file, 2005000, 1);
	survey(NULL);
	expect(FW_pvt, "");
	expect(FW_imu, "gyro_x_radps=1");
	expect_end(0);
	assert_int_equal(reader.unhealthy, 1);
}

/* ---- damage ---- */

static void make_six(size_t where[7])
{
	const ul_fix fix = fix_at(1000000);

	begin_log();
	ul_gps(&file, &fix);
	for (int i = 0; i < 6; i++) {
		where[i] = file.n;
		ul_combined(&file, 2000000 + (uint64_t)i * 5000, (float)i);
	}
	where[6] = file.n;
}

static unsigned samples(uint64_t *offset)
{
	unsigned seen = 0;
	fw_status status;

	*offset = 0;
	survey(NULL);
	while ((status = fw_ulog_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
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
	file.bytes[where[2]] ^= 64; /* the length: and the one before, which nothing follows */
	assert_int_equal(samples(&offset), 63 & ~6);
	assert_int_equal(offset, where[1]);
	make_six(where);
	file.bytes[where[2] + 1] = 0xff; /* a length that reaches far beyond the end */
	assert_int_equal(samples(&offset), 63 & ~6);
	make_six(where);
	file.bytes[where[2] + 3] = 0x77; /* a number that nobody subscribed to */
	assert_int_equal(samples(&offset), 63 & ~6);
	make_six(where);
	memset(file.bytes + where[1] + 7, 0xee, where[3] - where[1]); /* a stretch */
	assert_int_equal(samples(&offset) & ~6U, 63 & ~14);
	assert_int_equal(reader.lost, 1);
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
	}
	for (size_t n = 0; n < 300; n++) {
		file.n = n;
		(void)samples(&offset);
		assert_true(reader.final == FW_ETRUNCATED || reader.final == FW_EOF);
	}
}

/* The autopilot crashed inside a message and appended what it knew about that. */
static void appended_data_are_read(void **state)
{
	size_t where[7];
	uint64_t offset;

	(void)state;
	make_six(where);
	file.n = where[4] + 20;
	const size_t appended = file.n;
	ul_combined(&file, 3000000, 5);
	memset(file.bytes + 16 + 3 + 8, 0, 8);
	file.bytes[16 + 3 + 8] = 1;
	for (int i = 0; i < 8; i++)
		file.bytes[16 + 3 + 16 + i] = (uint8_t)(appended >> (8 * i));
	assert_int_equal(samples(&offset), 63 & ~16);
	assert_int_equal(reader.lost, 0);
	assert_int_equal(reader.final, FW_EOF);
}

static void logs_that_are_not_known_are_refused(void **state)
{
	(void)state;
	ul_file(&file);
	ul_flags(&file, 2, 0);
	ul_definitions(&file);
	begin(NULL);
	assert_int_equal(fw_ulog_read(&reader, &kind, &record), FW_EUNKNOWN);
	assert_int_equal(fw_ulog_read(&reader, &kind, &record), FW_EUNKNOWN);
	file.bytes[0] = 'X';
	begin(NULL);
	assert_int_equal(fw_ulog_read(&reader, &kind, &record), FW_EUNKNOWN);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(everything_of_a_log),
	    cmocka_unit_test(the_better_imu_is_taken),
	    cmocka_unit_test(increments_alone_and_other_instances),
	    cmocka_unit_test(positions_of_the_topic_that_has_more),
	    cmocka_unit_test(modes_heights_and_latency),
	    cmocka_unit_test(a_fix_without_utc_is_as_late_as_the_others),
	    cmocka_unit_test(without_positions_there_is_no_time),
	    cmocka_unit_test(samples_that_are_not_finite_are_left_out),
	    cmocka_unit_test(damage_costs_what_it_hits),
	    cmocka_unit_test(the_end_is_found_at_every_byte),
	    cmocka_unit_test(appended_data_are_read),
	    cmocka_unit_test(logs_that_are_not_known_are_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
