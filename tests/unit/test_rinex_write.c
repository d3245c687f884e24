/* Writing RINEX observation files. Lines that must come out are written by hand after RINEX 3.04; what was
 * written is read again by rinex_obs.c, whose own tests stand on files written by hand. Against convbin and
 * rnx2rtkp: tests/oracle/test_rinex.py. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>

#include "../random_record.h"
#include "formats/rinex_obs.h"
#include "formats/rinex_write.h"
#include "furrow_event.h"
#include "furrow_obs.h"
#include "furrow_obs_columns.h"
#include "furrow_pvt.h"
#include "furrow_pvt_columns.h"
#include "furrow_setup.h"
#include "furrow_setup_columns.h"

enum { MOST = 256 };

static char bytes[1 << 20];
static memory out;
static fw_rinex_survey survey;
static fw_rinex_obs_writer writer;
static furrow_obs rows[MOST];
static int n_rows;

static void add(double tow_s, const char *sat, const char *signal, double pseudorange_m, double carrier_cyc,
                int lock_s)
{
	furrow_obs *o = &rows[n_rows++];
	fw_record_clear(FW_obs, o);
	o->gps_week = 2320;
	o->tow_s = tow_s;
	o->sat = (char *)(uintptr_t)sat;
	o->signal = (char *)(uintptr_t)signal;
	o->pseudorange_m = pseudorange_m;
	o->carrier_cyc = carrier_cyc;
	o->lock_s = lock_s > 0 ? lock_s : 0;
	o->present = 0x1f | (int64_t)(pseudorange_m != 0) << FW_COL_obs_pseudorange_m |
	             (int64_t)(carrier_cyc != 0) << FW_COL_obs_carrier_cyc |
	             (int64_t)(lock_s >= 0) << FW_COL_obs_lock_s;
}

/* All rows through survey and writer. */
static void write_rows(int antenna)
{
	out = (memory){bytes, sizeof bytes - 1, 0};
	for (int i = 0; i < n_rows; i++)
		fw_rinex_survey_put(&survey, FW_obs, &rows[i]);
	fw_rinex_obs_write(&writer, &survey, antenna, to_memory, &out);
	for (int i = 0; i < n_rows; i++)
		fw_rinex_obs_put(&writer, FW_obs, &rows[i]);
	assert_int_equal(fw_rinex_obs_end(&writer), FW_OK);
	bytes[out.used] = '\0';
}

static int begin(void **state)
{
	(void)state;
	fw_rinex_survey_begin(&survey);
	n_rows = 0;
	return 0;
}

static void line_is_there(const char *line)
{
	char wanted[256];
	snprintf(wanted, sizeof wanted, "\n%s\n", line);
	if (strstr(bytes, wanted) == NULL)
		fail_msg("no line '%s' in\n%s", line, bytes);
}

static void header_and_epochs(void **state)
{
	furrow_setup setup;
	furrow_pvt pvt;
	(void)state;
	fw_record_clear(FW_setup, &setup);
	setup.marker_name = (char *)(uintptr_t) "FIELD 7";
	setup.ant_type = (char *)(uintptr_t) "an\nantenna whose name is longer than that";
	setup.delta_h_m = 1.5F;
	fw_rinex_survey_put(&survey, FW_setup, &setup);
	fw_record_clear(FW_pvt, &pvt); /* on the equator: x is the semi-major axis */
	pvt.present = INT64_C(1) << FW_COL_pvt_lat_deg | INT64_C(1) << FW_COL_pvt_lon_deg |
	              INT64_C(1) << FW_COL_pvt_height_m;
	fw_rinex_survey_put(&survey, FW_pvt, &pvt);

	add(86400, "G05", "1C", 24722972.9764, 129920098.1464, 100);
	add(86400, "R02", "1C", 19497563.592, 0, -1);
	rows[n_rows - 1].glonass_channel = -4;
	rows[n_rows - 1].present |= INT64_C(1) << FW_COL_obs_glonass_channel;
	add(86400, "G05", "2W", 0, -0.0004, -1);
	rows[n_rows - 1].cn0_dbhz = 7.25;
	rows[n_rows - 1].half_cycle = 1;
	rows[n_rows - 1].present |= INT64_C(1) << FW_COL_obs_cn0_dbhz | INT64_C(1) << FW_COL_obs_half_cycle;
	add(86400.2, "S123", "1C", 38000000, 0, -1);
	write_rows(0);
	line_is_there("FIELD 7                                                     MARKER NAME");
	line_is_there("                    an?antenna whose nam                    ANT # / TYPE");
	line_is_there("  6378137.0000        0.0000        0.0000                  APPROX POSITION XYZ");
	line_is_there("        1.5000        0.0000        0.0000                  ANTENNA: DELTA H/E/N");
	line_is_there("G    4 C1C L1C L2W S2W                                      SYS / # / OBS TYPES");
	line_is_there("R    1 C1C                                                  SYS / # / OBS TYPES");
	line_is_there("S    1 C1C                                                  SYS / # / OBS TYPES");
	line_is_there("     0.200                                                  INTERVAL");
	line_is_there("  2024     6    24     0     0    0.0000000     GPS         TIME OF FIRST OBS");
	line_is_there("  2024     6    24     0     0    0.2000000     GPS         TIME OF LAST OBS");
	line_is_there("  1 R02 -4                                                  GLONASS SLOT / FRQ #");
	line_is_there("> 2024 06 24 00 00  0.0000000  0  2");
	line_is_there("G05  24722972.976   129920098.146           0.0002          7.250");
	line_is_there("R02  19497563.592");
	line_is_there("> 2024 06 24 00 00  0.2000000  0  1");
	line_is_there("S23  38000000.000");
	assert_int_equal(writer.epochs, 2);
	assert_int_equal(writer.refused, 0);
}

/* Bit 0 of a carrier's indicator: lost at once (0), gone back, or shorter than the time since the last
 * observation. */
static void losses_of_lock(void **state)
{
	static const struct {
		double tow_s;
		int lock_s;
		const char *indicator;
	} epochs[] = {{1, 10, "  "}, {2, 11, "  "},  {3, 1, "1 "},  {4, 2, "  "},   {5, 0, "1 "},
	              {6, 1, "  "},  {16, 11, "  "}, {26, 5, "1 "}, {56, 10, "1 "}, {57, -1, "  "}};
	char line[64];
	(void)state;
	for (size_t i = 0; i < sizeof epochs / sizeof *epochs; i++)
		add(epochs[i].tow_s, "E07", "5Q", 0, 1000 + epochs[i].tow_s, epochs[i].lock_s);
	write_rows(0);
	for (size_t i = 0; i < sizeof epochs / sizeof *epochs; i++) {
		const int n =
		    snprintf(line, sizeof line, "E07%14.3f%s", 1000 + epochs[i].tow_s, epochs[i].indicator);
		line[n - 1] = '\0';
		if (line[n - 2] == ' ')
			line[n - 2] = '\0';
		line_is_there(line);
	}
}

/* Many observables: 13 on a line of the header. Antennas apart; what RINEX cannot name is refused. */
static void lists_and_refusals(void **state)
{
	static const char *const signals[] = {"1C", "1L", "1W", "2L", "2W", "5Q", "5I", "5X"};
	furrow_event event;
	(void)state;
	for (size_t i = 0; i < 8; i++)
		add(1, "G07", signals[i], 2e7, 1e8, -1);
	add(1, "G08", "1C", 2e7, 1e8, -1);
	rows[n_rows - 1].antenna = 1;
	add(1, "X08", "1C", 2e7, 1e8, -1);
	add(1, "G08", "??", 2e7, 1e8, -1);
	add(1, "G08", "1C", 0, 0, -1);
	add(1, "G08", "1C", 2e7, 0, -1);
	rows[n_rows - 1].present &= ~INT64_C(2);
	write_rows(0);
	line_is_there("G   16 C1C L1C C1L L1L C1W L1W C2L L2L C2W L2W C5I L5I C5Q  SYS / # / OBS TYPES");
	line_is_there("       L5Q C5X L5X                                          SYS / # / OBS TYPES");
	assert_null(strstr(bytes, "G08"));
	assert_int_equal(writer.refused, 4);
	write_rows(1);
	line_is_there("G    2 C1C L1C                                              SYS / # / OBS TYPES");
	line_is_there("G08  20000000.000   100000000.000");
	assert_null(strstr(bytes, "G07"));

	fw_record_clear(FW_event, &event);
	event.gps_week = 2320;
	event.tow_s = 1.25;
	event.present = 3;
	fw_rinex_obs_put(&writer, FW_event, &event);
	assert_int_equal(fw_rinex_obs_end(&writer), FW_OK);
	bytes[out.used] = '\0';
	line_is_there("> 2024 06 23 00 00  1.2500000  5  0");
}

/* Random observations there and back. */
static void there_and_back(void **state)
{
	static const char *const sats[] = {"G01", "G32", "R24", "E36", "C63", "J07", "I05", "S158"};
	static const char *const signals[] = {"1C", "2W", "5X", "7I"};
	static fw_rinex_obs reader;
	static fw_input input;
	fw_any_record record;
	fw_kind kind;
	fw_status status;
	fw_random random;
	int n = 0;
	(void)state;
	fw_random_init(&random, 3);
	for (int epoch = 0; epoch < 4; epoch++)
		for (size_t i = 0; i < 8; i++)
			for (size_t k = 0; k < 4; k++)
				if (fw_random_below(&random, 3) > 0) {
					add(604799 + epoch * 0.1, sats[i], signals[k],
					    1 + (double)fw_random_below(&random, 1000000000) / 1000,
					    1 - (double)fw_random_below(&random, 1000000000) / 1000 - 2,
					    (int)fw_random_below(&random, 2) - 1);
					rows[n_rows - 1].half_cycle = (int8_t)fw_random_below(&random, 2);
					rows[n_rows - 1].present |= INT64_C(1) << FW_COL_obs_half_cycle;
				}
	write_rows(0);
	fw_input_open_memory(&input, bytes, out.used);
	fw_rinex_obs_begin(&reader, &input);
	while ((status = fw_rinex_obs_read(&reader, &kind, &record)) == FW_OK) {
		const furrow_obs *o = (const furrow_obs *)(const void *)&record;
		if (kind != FW_obs)
			continue;
		assert_true(n < n_rows);
		assert_string_equal(o->sat, rows[n].sat);
		assert_string_equal(o->signal, rows[n].signal);
		assert_int_equal(o->present, rows[n].present);
		assert_true(o->pseudorange_m == rows[n].pseudorange_m &&
		            o->carrier_cyc == rows[n].carrier_cyc);
		assert_true(fabs(o->tow_s - rows[n].tow_s) < 1e-7);
		assert_int_equal(o->half_cycle, rows[n].half_cycle);
		n++;
	}
	assert_int_equal(status, FW_EOF);
	assert_int_equal(n, n_rows);
}

static fw_status fail_to_write(void *context, const void *data, size_t n)
{
	(void)data;
	(void)n;
	++*(int *)context;
	return FW_EIO;
}

static void failing_output(void **state)
{
	int calls = 0;
	(void)state;
	for (int i = 0; i < MOST; i++)
		add(i, "G07", "1C", 2e7, 1e8, -1);
	for (int i = 0; i < MOST; i++)
		fw_rinex_survey_put(&survey, FW_obs, &rows[i]);
	fw_rinex_obs_write(&writer, &survey, 0, fail_to_write, &calls);
	for (int i = 0; i < 100 * MOST; i++)
		fw_rinex_obs_put(&writer, FW_obs, &rows[i % MOST]);
	assert_int_equal(fw_rinex_obs_end(&writer), FW_EIO);
	assert_int_equal(calls, 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test_setup(header_and_epochs, begin),  cmocka_unit_test_setup(losses_of_lock, begin),
	    cmocka_unit_test_setup(lists_and_refusals, begin), cmocka_unit_test_setup(there_and_back, begin),
	    cmocka_unit_test_setup(failing_output, begin),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
