/* Observation rows to epochs. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "../../cli/epochs.h"
#include "furrow_obs.h"
#include "furrow_obs_columns.h"

static epochs rows;
static char seen[1024]; /* "10:G05.1C,G05.2W;11:..." */

static void note(void *context, const fw_epoch *epoch)
{
	(void)context;
	int week;
	double tow_s;
	char name[5];
	fw_time_to_gps_s(epoch->time, &week, &tow_s);
	snprintf(seen + strlen(seen), sizeof seen - strlen(seen), "%.0f:", tow_s);
	for (unsigned i = 0; i < epoch->n; i++) {
		const fw_observation *o = &epoch->obs[i];
		fw_satellite_name(o->satellite, name);
		snprintf(seen + strlen(seen), sizeof seen - strlen(seen), "%s.%c%c%s", name, o->signal.band,
		         o->signal.attribute, i + 1 < epoch->n ? "," : ";");
	}
}

static void put(double tow_s, const char *sat, const char *signal, int antenna)
{
	char s[8], g[8];
	snprintf(s, sizeof s, "%s", sat);
	snprintf(g, sizeof g, "%s", signal);
	furrow_obs r = {.present = INT64_C(1) << FW_COL_obs_gps_week | INT64_C(1) << FW_COL_obs_tow_s |
	                           INT64_C(1) << FW_COL_obs_pseudorange_m,
	                .gps_week = 2320,
	                .tow_s = tow_s,
	                .sat = s,
	                .signal = g,
	                .antenna = (int8_t)antenna,
	                .pseudorange_m = 2e7};
	epochs_put(&rows, FW_obs, &r);
}

static int begin(void **state)
{
	(void)state;
	seen[0] = '\0';
	epochs_begin(&rows, note, NULL);
	return 0;
}

static void an_epoch_ends_when_the_time_changes(void **state)
{
	(void)state;
	put(10, "G05", "1C", 0);
	put(10, "G05", "2W", 0);
	put(10, "E11", "1C", 0);
	assert_string_equal(seen, "");
	put(11, "R02", "1C", 0);
	assert_string_equal(seen, "10:G05.1C,G05.2W,E11.1C;");
	epochs_flush(&rows);
	epochs_flush(&rows);
	assert_string_equal(seen, "10:G05.1C,G05.2W,E11.1C;11:R02.1C;");
}

static void rows_of_a_satellite_come_together(void **state)
{
	(void)state;
	put(10, "G05", "1C", 0);
	put(10, "G07", "1C", 0);
	put(10, "E11", "1C", 0);
	put(10, "G07", "2W", 0);
	put(10, "G05", "2W", 0);
	put(10, "G07", "5Q", 0);
	put(10, "E11", "5Q", 0);
	epochs_flush(&rows);
	put(11, "G07", "1C", 0);
	epochs_flush(&rows);
	assert_string_equal(seen, "10:G05.1C,G05.2W,G07.1C,G07.2W,G07.5Q,E11.1C,E11.5Q;11:G07.1C;");
}

static void other_antennas_and_nonsense_are_left_out(void **state)
{
	(void)state;
	put(10, "G05", "1C", 1);
	put(10, "X05", "1C", 0);
	put(10, "G05", "1", 0);
	put(10, "", "1C", 0);
	epochs_flush(&rows);
	assert_string_equal(seen, "");
	assert_int_equal(rows.refused, 3);
}

static void too_many_rows_are_counted(void **state)
{
	(void)state;
	for (int i = 0; i < FW_EPOCH_MAX + 3; i++)
		put(10, "G05", "1C", 0);
	assert_int_equal(rows.overflowed, 3);
	assert_int_equal(rows.epoch.n, FW_EPOCH_MAX);
}

static void columns_become_members(void **state)
{
	(void)state;
	static char g05[] = "S123", c1[] = "1C";
	fw_observation o;
	const furrow_obs r = {.present = INT64_C(1) << FW_COL_obs_doppler_hz |
	                                 INT64_C(1) << FW_COL_obs_lock_s | INT64_C(1) << FW_COL_obs_cn0_dbhz,
	                      .sat = g05,
	                      .signal = c1,
	                      .doppler_hz = -12.5,
	                      .cn0_dbhz = 44.25,
	                      .lock_s = 0,
	                      .half_cycle = 1};
	assert_int_equal(observation_of_record(&r, &o), FW_OK);
	assert_int_equal(o.has, FW_HAS_DOPPLER | FW_HAS_LOCK | FW_HAS_CN0);
	assert_true(o.satellite.system == FW_SBAS && o.satellite.number == 23);
	assert_true(o.doppler_hz == -12.5 && o.cn0_dbhz == 44.25 && o.half_cycle && o.slip);
	assert_int_equal(o.glonass_channel, INT8_MIN);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test_setup(an_epoch_ends_when_the_time_changes, begin),
	    cmocka_unit_test_setup(rows_of_a_satellite_come_together, begin),
	    cmocka_unit_test_setup(other_antennas_and_nonsense_are_left_out, begin),
	    cmocka_unit_test_setup(too_many_rows_are_counted, begin),
	    cmocka_unit_test_setup(columns_become_members, begin),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
