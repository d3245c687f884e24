/* log_records: what is put in comes out, in order; what is no number does not come in. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "formats/log_records.h"

#include "log_test.h"

static fw_log_queue queue;
static const fw_time at = {INT64_C(2300) * FW_NS_PER_WEEK + 1500 * INT64_C(1000000)};
static const double v[3] = {1, -2, 3}, bad[3] = {1, (double)NAN, 3};

static void records_come_out_in_order(void **state)
{
	fw_any_record record;
	fw_kind kind;

	(void)state;
	for (int round = 0; round < 5; round++) {
		for (int i = 0; i < FW_LOG_QUEUE_MAX; i++)
			assert_int_equal(fw_log_put_baro(&queue, at, i), FW_OK);
		assert_int_equal(fw_log_put_baro(&queue, at, 0), FW_ENOSPACE);
		for (int i = 0; i < FW_LOG_QUEUE_MAX - round; i++) {
			assert_int_equal(fw_log_take(&queue, &kind, &record), FW_OK);
			assert_int_equal(kind, FW_baro);
			assert_near(number_of(kind, &record, "baro_height_m"), i, 0);
		}
		while (fw_log_take(&queue, &kind, &record) == FW_OK)
			;
	}
}

static void take(fw_kind wanted, fw_any_record *record)
{
	fw_kind kind;

	assert_int_equal(fw_log_take(&queue, &kind, record), FW_OK);
	assert_int_equal(kind, wanted);
}

static void samples_have_their_columns(void **state)
{
	const double accel[3] = {0.5, 0.25, -9.75};
	fw_any_record r;

	(void)state;
	assert_int_equal(fw_log_put_imu(&queue, at, v, accel), FW_OK);
	take(FW_imu, &r);
	assert_columns(
	    FW_imu, &r,
	    "gps_week=2300 tow_s=1.5 gyro_x_radps=1 gyro_y_radps=-2 gyro_z_radps=3 accel_x_mps2=0.5 "
	    "accel_y_mps2=0.25 accel_z_mps2=-9.75");
	assert_int_equal(fw_log_put_mag(&queue, at, v), FW_OK);
	take(FW_mag, &r);
	assert_columns(FW_mag, &r, "tow_s=1.5 mag_x_ut=1 mag_y_ut=-2 mag_z_ut=3");
	assert_int_equal(fw_log_put_event(&queue, at, 2), FW_OK);
	take(FW_event, &r);
	assert_columns(FW_event, &r, "tow_s=1.5 source=2 polarity=nan");
}

static fw_log_fix some_fix(void)
{
	fw_log_fix fix = fw_log_no_fix();

	fix.lat_deg = 48.5;
	fix.lon_deg = 190;
	fix.height_m = 120;
	fix.mode = 4;
	return fix;
}

/* What is not known is absent, and longitudes are wrapped. */
static void fixes_say_what_is_known(void **state)
{
	fw_log_fix fix = some_fix();
	fw_any_record r;

	(void)state;
	assert_int_equal(fw_log_put_pvt(&queue, at, &fix), FW_OK);
	take(FW_pvt, &r);
	assert_columns(
	    FW_pvt, &r,
	    "mode=4 two_d=0 lat_deg=48.5 lon_deg=-170 height_m=120 vn_mps=nan sd_n_m=nan cov_nn_m2=nan "
	    "n_sats=nan undulation_m=nan");
	memcpy(fix.sd_m, (double[]){0.5, 0.25, 2}, sizeof fix.sd_m);
	memcpy(fix.velocity_mps, v, sizeof v);
	memcpy(fix.sd_velocity_mps, (double[]){1, 1, 3}, sizeof fix.sd_velocity_mps);
	fix.n_sats = 17;
	assert_int_equal(fw_log_put_pvt(&queue, at, &fix), FW_OK);
	take(FW_pvt, &r);
	assert_columns(FW_pvt, &r,
	               "sd_n_m=0.5 sd_d_m=2 cov_nn_m2=0.25 cov_ee_m2=0.0625 cov_dd_m2=4 vn_mps=1 vd_mps=3 "
	               "cov_vnvn_m2ps2=1 cov_vdvd_m2ps2=9 cov_ne_m2=nan n_sats=17");
	assert_int_equal(fw_log_put_pos(&queue, at, &fix, "float", 2.5), FW_OK);
	take(FW_pos, &r);
	assert_columns(FW_pos, &r,
	               "lat_deg=48.5 sd_d_m=2 vd_mps=3 sd_vd_mps=3 ratio=2.5 n_sats=17 clock_m=nan");
	assert_string_equal(text_of(FW_pos, &r, "quality"), "float");
}

static void no_solution_has_no_position(void **state)
{
	fw_log_fix fix = some_fix();
	fw_any_record r;

	(void)state;
	fix.mode = 0;
	assert_int_equal(fw_log_put_pvt(&queue, at, &fix), FW_OK);
	take(FW_pvt, &r);
	assert_columns(FW_pvt, &r, "mode=0 lat_deg=nan");
}

static void a_nav_may_be_attitude_alone(void **state)
{
	fw_log_nav nav = fw_log_no_nav();
	fw_any_record r;

	(void)state;
	assert_int_equal(fw_log_put_nav(&queue, at, &nav, NULL), FW_ENONFINITE);
	memcpy(nav.angle_deg, (double[]){1, 2, -30}, sizeof nav.angle_deg);
	assert_int_equal(fw_log_put_nav(&queue, at, &nav, "autopilot"), FW_OK);
	take(FW_nav, &r);
	assert_columns(FW_nav, &r, "lat_deg=nan vn_mps=nan roll_deg=1 pitch_deg=2 heading_deg=330");
	assert_string_equal(text_of(FW_nav, &r, "status"), "autopilot");
}

static void what_is_no_number_stays_out(void **state)
{
	fw_log_fix fix = some_fix();

	(void)state;
	assert_int_equal(fw_log_put_imu(&queue, at, bad, v), FW_ENONFINITE);
	assert_int_equal(fw_log_put_imu(&queue, at, v, bad), FW_ENONFINITE);
	assert_int_equal(fw_log_put_mag(&queue, at, bad), FW_ENONFINITE);
	assert_int_equal(fw_log_put_baro(&queue, at, (double)INFINITY), FW_ENONFINITE);
	assert_int_equal(fw_log_put_baro(&queue, (fw_time){-1}, 0), FW_ERANGE);
	assert_int_equal(fw_log_put_event(&queue, (fw_time){INT64_MAX}, 1), FW_ERANGE);
	fix.lat_deg = 91;
	assert_int_equal(fw_log_put_pvt(&queue, at, &fix), FW_ERANGE);
	fix.lat_deg = (double)NAN;
	assert_int_equal(fw_log_put_pos(&queue, at, &fix, NULL, 0), FW_ENONFINITE);
	assert_int_equal(queue.n, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(records_come_out_in_order),   cmocka_unit_test(samples_have_their_columns),
	    cmocka_unit_test(fixes_say_what_is_known),     cmocka_unit_test(no_solution_has_no_position),
	    cmocka_unit_test(a_nav_may_be_attitude_alone), cmocka_unit_test(what_is_no_number_stays_out),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
