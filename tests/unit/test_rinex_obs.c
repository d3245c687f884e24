/* Reading RINEX observation files. The files are written here after the RINEX documents (2.11, 3.02, 3.05);
 * expected values stand beside them. Against other readers: tests/oracle/test_rinex.py. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "../rinex_text.h"
#include "formats/rinex_obs.h"
#include "furrow_epoch.h"
#include "furrow_event.h"
#include "furrow_event_columns.h"
#include "furrow_obs.h"
#include "furrow_obs_columns.h"
#include "furrow_setup.h"

enum { MOST = 256, TEXT = 8 };

static rinex_text t;
static fw_input input;
static fw_rinex_obs reader;

/* All that the reader said about a file. */
static struct {
	int n, n_epochs, n_events, n_setups, n_problems;
	furrow_obs obs[MOST];
	char sat[MOST][TEXT], signal[MOST][TEXT];
	furrow_epoch epochs[MOST];
	furrow_event events[MOST];
	char marker[80];
	fw_rinex_problem problems[MOST];
	fw_status end;
} got;

static void take(fw_kind kind, const fw_any_record *record)
{
	if (kind == FW_obs) {
		const furrow_obs *o = (const furrow_obs *)(const void *)record;
		assert_true(got.n < MOST);
		got.obs[got.n] = *o;
		snprintf(got.sat[got.n], TEXT, "%s", o->sat);
		snprintf(got.signal[got.n++], TEXT, "%s", o->signal);
	} else if (kind == FW_epoch) {
		got.epochs[got.n_epochs++ % MOST] = *(const furrow_epoch *)(const void *)record;
	} else if (kind == FW_event) {
		got.events[got.n_events++ % MOST] = *(const furrow_event *)(const void *)record;
	} else {
		assert_int_equal(kind, FW_setup);
		got.n_setups++;
		snprintf(got.marker, sizeof got.marker, "%s",
		         ((const furrow_setup *)(const void *)record)->marker_name);
	}
}

static void read_bytes(size_t n)
{
	fw_any_record record;
	fw_kind kind;
	fw_status status;

	memset(&got, 0, sizeof got);
	fw_input_open_memory(&input, t.bytes, n);
	fw_rinex_obs_begin(&reader, &input);
	while ((status = fw_rinex_obs_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_OK)
			take(kind, &record);
		else
			got.problems[got.n_problems++ % MOST] = reader.problem;
	}
	got.end = status;
	assert_int_equal(fw_rinex_obs_read(&reader, &kind, &record), status); /* final */
}

static void read_all(void)
{
	read_bytes(t.used);
}

static void begin_3(const char *version)
{
	char text[64];

	t.used = 0;
	snprintf(text, sizeof text, "%9s           OBSERVATION DATA    M: MIXED", version);
	add_header(&t, text, "RINEX VERSION / TYPE");
}

static void end_header(void)
{
	add_header(&t, "", "END OF HEADER");
}

/* The observation of a satellite and signal; NULL when there is none. */
static const furrow_obs *find(const char *sat, const char *signal)
{
	for (int i = 0; i < got.n; i++)
		if (strcmp(got.sat[i], sat) == 0 && strcmp(got.signal[i], signal) == 0)
			return &got.obs[i];
	return NULL;
}

static int has(const furrow_obs *o, int column)
{
	assert_non_null(o);
	return (int)(o->present >> column & 1);
}

static void is(double x, double wanted)
{
	if (!(x == wanted))
		fail_msg("%.17g, not %.17g", x, wanted);
}

/* ---- version 3 ---- */

static void begin_plain(void)
{
	begin_3("3.04");
	add_header(&t, "FIELD", "MARKER NAME");
	add_header(&t, "  4021428.5670   332891.8765  4923030.2845", "APPROX POSITION XYZ");
	add_header(&t, "G    8 C1C L1C D1C S1C C2W L2W D2W S2W", "SYS / # / OBS TYPES");
	add_header(&t, "R    4 C1C L1C D1C S1C", "SYS / # / OBS TYPES");
	add_header(&t, "E    4 C1C L1C D1C S1C", "SYS / # / OBS TYPES");
	add_header(&t, "     1.000", "INTERVAL");
	add_header(&t, "  2024     6    24     8    20    0.0000000     GPS", "TIME OF FIRST OBS");
	add_header(&t, "  2 R01  1 R02 -4", "GLONASS SLOT / FRQ #");
	add_header(&t, "    18", "LEAP SECONDS");
	end_header();
}

static void plain_epochs(void **state)
{
	(void)state;
	begin_plain();
	add_line(&t, "> 2024 06 24 08 20  0.0000000  0  3");
	add_line(&t, "G05  24722972.976   129920098.14617     -2390.278 7        27.250    24722981.505 6 "
	             "101236449.51126     -1862.523 5         7.250");
	add_line(&t, "R02  19497563.592 7 103932986.89328       262.991          43.500");
	add_line(&t, "E 7         0.000   126240000.00000                        30.000");
	add_line(&t, "> 2024 06 24 08 20  1.0000000  0  1");
	add_line(&t, "R03  19497563.592");
	read_all();
	assert_int_equal(got.end, FW_EOF);
	assert_int_equal(got.n_problems, 0);
	assert_int_equal(got.n_setups, 1);
	assert_string_equal(got.marker, "FIELD");
	assert_int_equal(got.n, 5);
	assert_int_equal(got.n_epochs, 2);
	assert_int_equal(got.epochs[0].n_signals, 4);
	assert_int_equal(got.epochs[1].n_signals, 1);
	/* 2024-06-24 is a Monday: week 2320, day 1 */
	assert_int_equal(got.epochs[0].gps_week, 2320);
	is(got.epochs[0].tow_s, 86400 + 8 * 3600 + 20 * 60);
	is(got.epochs[1].tow_s, 86400 + 8 * 3600 + 20 * 60 + 1);

	const furrow_obs *o = find("G05", "1C");
	is(o->pseudorange_m, 24722972.976);
	is(o->carrier_cyc, 129920098.146);
	is(o->doppler_hz, -2390.278);
	is(o->cn0_dbhz, 27.25);
	assert_int_equal(has(o, FW_COL_obs_lock_s), 1); /* LLI 1 */
	assert_int_equal(o->lock_s, 0);
	assert_int_equal(o->half_cycle, 0);
	assert_int_equal(has(o, FW_COL_obs_glonass_channel), 0);
	assert_int_equal(has(find("G05", "2W"), FW_COL_obs_lock_s), 0); /* LLI 2 */
	assert_int_equal(find("G05", "2W")->half_cycle, 1);
	assert_int_equal(find("R02", "1C")->glonass_channel, -4);
	assert_int_equal(has(find("R03", "1C"), FW_COL_obs_glonass_channel), 0);
	o = find("E07", "1C"); /* 0.000 is missing */
	assert_int_equal(has(o, FW_COL_obs_pseudorange_m), 0);
	assert_int_equal(has(o, FW_COL_obs_doppler_hz), 0);
	is(o->cn0_dbhz, 30);
	assert_int_equal(reader.header.leap_s, 18);
	is(reader.header.position_m[2], 4923030.2845);
	is(reader.header.interval_s, 1);
}

/* BDT is 14 s behind GPST, UTC 18 s in 2024; 3.02 calls B1I 1I; a list on two lines; factors. */
static void variants_of_version_3(void **state)
{
	(void)state;
	begin_3("3.02");
	add_header(&t, "C   14 C1I L1I D1I S1I C7I L7I D7I S7I C6I L6I D6I S6I X1 ", "SYS / # / OBS TYPES");
	add_header(&t, "       C5P", "SYS / # / OBS TYPES");
	add_header(&t, "C   10   1 C1I", "SYS / SCALE FACTOR");
	add_header(&t, "  2024     6    24     8    20    0.0000000     BDT", "TIME OF FIRST OBS");
	end_header();
	add_line(&t, "> 2024 06 24 08 20 30.5000000  0  1");
	add_line(&t, "C06%14.3f%180s%14.3f  %14.3f", 389284038.0, "", 5.0, 12.5);
	read_all();
	assert_int_equal(got.n_problems, 0);
	is(find("C06", "2I")->pseudorange_m, 38928403.8);
	is(got.epochs[0].tow_s, 86400 + 8 * 3600 + 20 * 60 + 30.5 + 14);
}

static void times_of_other_systems(void **state)
{
	static const struct {
		const char *name;
		double behind_s;
	} systems[] = {{"GPS", 0},  {"GAL", 0},  {"QZS", 0},  {"IRN", 0},
	               {"GLO", 18}, {"UTC", 18}, {"BDT", 14}, {"   ", 0}};
	char text[64];
	(void)state;
	for (size_t i = 0; i < sizeof systems / sizeof *systems; i++) {
		begin_3("4.02");
		add_header(&t, "G    1 C1C", "SYS / # / OBS TYPES");
		snprintf(text, sizeof text, "  2024     6    24     8    20    0.0000000     %s",
		         systems[i].name);
		add_header(&t, text, "TIME OF FIRST OBS");
		end_header();
		add_line(&t, "> 2024 06 22 23 59 59.5000000  0  1");
		add_line(&t, "G05  24722972.976");
		read_all();
		assert_int_equal(got.n_problems, 0);
		assert_int_equal(got.epochs[0].gps_week, systems[i].behind_s > 0 ? 2320 : 2319);
		is(got.epochs[0].tow_s, systems[i].behind_s > 0 ? systems[i].behind_s - 0.5 : 604799.5);
	}
	/* a file of GLONASS alone is in UTC without a word */
	t.used = 0;
	add_header(&t, "     3.03           OBSERVATION DATA    R: GLONASS", "RINEX VERSION / TYPE");
	add_header(&t, "R    1 C1C", "SYS / # / OBS TYPES");
	end_header();
	add_line(&t, "> 2024 06 24 00 00  0.0000000  0  1");
	add_line(&t, "R05  24722972.976");
	read_all();
	is(got.epochs[0].tow_s, 86400 + 18);
}

static void flags_of_epochs(void **state)
{
	(void)state;
	begin_plain();
	add_line(&t, "> 2024 06 24 08 20  0.0000000  1  1"); /* power failure */
	add_line(&t, "G05  24722972.976   129920098.146");
	add_line(&t, ">                              4  2"); /* header lines */
	add_header(&t, "G    2 C5Q C1C", "SYS / # / OBS TYPES");
	add_header(&t, "something else", "COMMENT");
	add_line(&t, "> 2024 06 24 08 20  0.7500000  5  0"); /* external event */
	add_line(&t, ">                              3  1"); /* new site */
	add_header(&t, "BARN", "MARKER NAME");
	add_line(&t, "> 2024 06 24 08 20  1.0000000  0  1");
	add_line(&t, "G05                  24722972.976");
	add_line(&t, "> 2024 06 24 08 20  1.0000000  6  2"); /* cycle slips */
	add_line(&t, "G05             1.000");
	add_line(&t, "G06             1.000");
	add_line(&t, ">                              2  0");
	add_line(&t, "> 2024 06 24 08 20  2.0000000  0  1");
	add_line(&t, "G05  24722972.976");
	read_all();
	assert_int_equal(got.n_problems, 0);
	assert_int_equal(got.end, FW_EOF);
	assert_int_equal(got.n_epochs, 3);
	assert_int_equal(got.n, 3);
	assert_int_equal(has(&got.obs[0], FW_COL_obs_lock_s), 1);
	assert_string_equal(got.signal[1], "1C");
	is(got.obs[1].pseudorange_m, 24722972.976);
	assert_string_equal(got.signal[2], "5Q");
	assert_string_equal(reader.header.marker_name, "BARN");
	assert_int_equal(got.n_events, 1);
	is(got.events[0].tow_s, 86400 + 8 * 3600 + 20 * 60 + 0.75);
	assert_int_equal(got.events[0].present, 1 << FW_COL_event_gps_week | 1 << FW_COL_event_tow_s);
}

static void two_files_in_one(void **state)
{
	(void)state;
	begin_plain();
	add_line(&t, "> 2024 06 24 08 20  0.0000000  0  1");
	add_line(&t, "G05  24722972.976   129920098.146");
	const size_t first = t.used;
	memcpy(t.bytes + first, t.bytes, first);
	t.used = 2 * first;
	memcpy(strstr(t.bytes + first, "C1C L1C"), "C1X L1X", 7);
	read_all();
	assert_int_equal(got.n_problems, 0);
	assert_int_equal(got.n_setups, 2);
	assert_non_null(find("G05", "1C"));
	assert_non_null(find("G05", "1X"));
}

/* ---- version 2 ---- */

static void begin_2(const char *types)
{
	t.used = 0;
	add_header(&t, "     2.11           OBSERVATION DATA    M (MIXED)", "RINEX VERSION / TYPE");
	add_header(&t, types, "# / TYPES OF OBSERV");
	add_header(&t, "  2005     3    24    13    10   36.0000000     GPS", "TIME OF FIRST OBS");
	end_header();
}

static void version_2_wrapped(void **state)
{
	(void)state;
	begin_2("     7    C1    P1    L1    L2    P2    S1    S2");
	/* 13 satellites: the list goes over two lines; seven observables: two lines each */
	add_line(&t, " 05  3 24 13 10 36.0000000  0 13G12G 9G 6R21R22E11S20G 3G 4G 5G 7G 8");
	add_line(&t, "                                 10");
	for (int i = 0; i < 13; i++) {
		add_line(&t, "%14.3f 5%14.3f  %s%14s  %14.3f", 23629347.915, 23629347.1,
		         i == 0 ? "       300.25018" : "           300 8", "-.353", 24128700.0);
		add_line(&t, "%14.3f  %14.3f", 24.158, 12.25);
	}
	add_line(&t, " 05  3 24 13 10 37.0000000  0  1G12");
	add_line(&t, "  23629347.915");
	add_line(&t, " ");
	read_all();
	assert_int_equal(got.end, FW_EOF);
	/* 300 without a point is no F14.3: the satellites that have it are lost, all but the first */
	assert_int_equal(got.n_problems, 12);
	const furrow_obs *o = find("G12", "1C");
	is(o->pseudorange_m, 23629347.915);
	is(o->carrier_cyc, 300.25);
	is(o->cn0_dbhz, 24.158);
	assert_int_equal(has(o, FW_COL_obs_lock_s), 1);
	o = find("G12", "1W");
	is(o->pseudorange_m, 23629347.1);
	assert_int_equal(has(o, FW_COL_obs_carrier_cyc), 0);
	o = find("G12", "2W");
	is(o->carrier_cyc, -0.353);
	is(o->pseudorange_m, 24128700);
	is(o->cn0_dbhz, 12.25);
	assert_int_equal(got.n_epochs, 2);
	is(got.epochs[1].tow_s, got.epochs[0].tow_s + 1);
	assert_int_equal(got.epochs[0].gps_week, 1315); /* 2005-03-24, Thursday */
	is(got.epochs[0].tow_s, 4 * 86400 + 13 * 3600 + 10 * 60 + 36);
}

static void codes_of_version_2(void **state)
{
	static const struct {
		const char *types, *list, *signals;
	} cases[] = {
	    {"     4    C1    L1    D1    S1", "G01R02E03S20J01C05 07",
	     "G01 1C,R02 1C,E03 1X,S120 1C,J01 1C,C05 2I,G07 1C,"},
	    {"     4    P1    L1    D1    S1", "G01R02", "G01 1W,R02 1P,"},
	    {"     3    C2    L2    D2", "G01R02J01C05", "G01 2X,R02 2C,J01 2X,C05 2I,"},
	    {"     3    P2    L2    D2", "G01R02", "G01 2W,R02 2P,"},
	    {"     4    C1    L1    L2    D2", "G01R02", "G01 1C,G01 2W,R02 1C,R02 2P,"},
	    {"     3    C5    L5    D5", "G01E03S20J01", "G01 5X,E03 5X,S120 5I,J01 5X,"},
	    {"     2    C7    L7", "G01E03C05", "E03 7X,C05 7I,"},
	    {"     2    C8    C6", "E03C05", "E03 8X,E03 6X,C05 6I,"},
	    {"     3    C1    P1    L1", "G01", "G01 1C,G01 1W,"},
	    {"     3    C2    P2    L2", "G01", "G01 2X,G01 2W,"},
	    {"     3    T1    XX    A5", "G01", ""},
	};
	(void)state;
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		const int n = (int)strlen(cases[k].list) / 3;
		char seen[256] = "";
		begin_2(cases[k].types);
		add_line(&t, " 05  3 24 13 10 36.0000000  0%3d%s", n, cases[k].list);
		for (int i = 0; i < n; i++)
			add_line(&t, "         1.000           2.000           3.000           4.000");
		read_all();
		assert_int_equal(got.n_problems, 0);
		for (int i = 0; i < got.n; i++)
			snprintf(seen + strlen(seen), sizeof seen - strlen(seen), "%s %s,", got.sat[i],
			         got.signal[i]);
		assert_string_equal(seen, cases[k].signals);
	}
	/* with both codes of band 1 the carrier is C1's, of band 2 P2's */
	begin_2("     6    C1    P1    L1    C2    P2    L2");
	add_line(&t, " 05  3 24 13 10 36.0000000  0  1G01");
	add_line(&t, "         1.000           2.000           3.000           4.000           5.000");
	add_line(&t, "         6.000");
	read_all();
	is(find("G01", "1C")->carrier_cyc, 3);
	is(find("G01", "2W")->carrier_cyc, 6);
	is(find("G01", "2X")->pseudorange_m, 4);
}

static void half_wavelengths(void **state)
{
	(void)state;
	t.used = 0;
	add_header(&t, "     2.10           OBSERVATION DATA    G (GPS)", "RINEX VERSION / TYPE");
	add_header(&t, "     1     2", "WAVELENGTH FACT L1/2");
	add_header(&t, "     1     1     2   G14   G15", "WAVELENGTH FACT L1/2");
	add_header(&t, "     2    L1    L2", "# / TYPES OF OBSERV");
	end_header();
	add_line(&t, " 99  8 22  0  0  0.0000000  0  1G12");
	add_line(&t, "         1.000           2.000");
	read_all();
	assert_int_equal(find("G12", "1C")->half_cycle, 0);
	assert_int_equal(find("G12", "2W")->half_cycle, 1);
	assert_int_equal(got.epochs[0].gps_week, 1024); /* 1999-08-22: the first roll-over */
	is(got.epochs[0].tow_s, 0);
}

/* ---- damage ---- */

static void problem_is(int i, uint64_t line, const char *words)
{
	assert_true(i < got.n_problems);
	if (got.problems[i].line != line || strstr(got.problems[i].reason, words) == NULL)
		fail_msg("line %d: %s; not line %d: %s", (int)got.problems[i].line, got.problems[i].reason,
		         (int)line, words);
}

static void damaged_lines(void **state)
{
	(void)state;
	begin_plain(); /* 11 lines */
	add_line(&t, "> 2024 06 24 08 20  0.0000000  0  4");
	add_line(&t, "G05  24722972.976   1299200x8.146"); /* 13 */
	add_line(&t, "Q07  24722972.976");                 /* 14: no such system */
	add_line(&t, "J01  24722972.976");                 /* 15: no list of observables */
	add_line(&t, "G06  24722972.976");
	add_line(&t, "> 2024 06 24 08 20  1.0000000  0  3"); /* ends too early */
	add_line(&t, "G05  24722972.976");
	add_line(&t, "> 2024 06 24 08 20  2.0000000  0  1"); /* 19 */
	add_line(&t, "G05  24722972.976");
	add_line(&t, "G06  24722972.976"); /* 21: one more than it says */
	add_line(&t, "G07  24722972.976");
	add_line(&t, "> 2024 06 31 08 20  3.0000000  0  1"); /* 23: no such day */
	add_line(&t, "G05  24722972.976");
	add_line(&t, "> 2024 06 24 08 20  4.0000000  x  1"); /* 25 */
	add_line(&t, "> 2024 06 24 08 20  5.0000000  0 -1"); /* 26 */
	add_line(&t, "> 2024 06 24 08 20  6.0000000  0  1");
	add_line(&t, "G05  24722972.9"); /* 28: ends inside a number */
	add_line(&t, "> 2024 06 24 08 20  7.0000000  0  1");
	add_line(&t, "G05  24722972.976");
	read_all();
	assert_int_equal(got.end, FW_EOF);
	problem_is(0, 13, "damaged number");
	problem_is(1, 14, "no satellite");
	problem_is(2, 15, "no observables");
	problem_is(3, 19, "too early");
	problem_is(4, 21, "no epoch line");
	problem_is(5, 23, "time of an epoch");
	problem_is(6, 25, "damaged epoch");
	problem_is(7, 26, "damaged epoch");
	problem_is(8, 28, "damaged number");
	assert_int_equal(got.n_problems, 9);
	assert_int_equal(reader.lost, 9);
	assert_int_equal(got.n, 4);
	assert_int_equal(got.n_epochs, 4);
}

static void damaged_lines_of_version_2(void **state)
{
	(void)state;
	begin_2("     6    C1    P1    L1    C2    P2    L2"); /* 4 lines */
	add_line(&t, " 05  3 24 13 10 36.0000000  0  3G01Q02G03");
	for (int i = 0; i < 3; i++) {
		add_line(&t,
		         "         1.000           2.000           3.000           4.000           5.000");
		add_line(&t, "         6.000");
	}
	add_line(&t, " 05  3 24 13 10 37.0000000  0  2G01G02"); /* ends too early */
	add_line(&t, "         1.000           2.000           3.000           4.000           5.000");
	add_line(
	    &t,
	    " 05  3 24 13 10 38.0000000  0 14G01G02G03G04G05G06G07G08G09G10G11G12"); /* its list ends too early */
	add_line(&t, " 05  3 24 13 10 39.0000000  0  1G01");
	add_line(&t, "         1.000           2.000           3.000           4.000           5.000");
	add_line(&t, "         6.000");
	read_all();
	assert_int_equal(got.end, FW_EOF);
	problem_is(0, 9, "no satellite");
	problem_is(1, 14, "too early");
	problem_is(2, 15, "list of satellites");
	assert_int_equal(got.n_problems, 3);
	assert_int_equal(got.n, 3 * 4);
	assert_int_equal(got.n_epochs, 2);
}

static void damaged_headers(void **state)
{
	(void)state;
	t.used = 0;
	add_line(&t, "nothing of the kind");
	read_all();
	assert_int_equal(got.end, FW_EUNKNOWN);
	assert_int_equal(reader.problem.line, 1);

	t.used = 0;
	add_header(&t, "     5.00           OBSERVATION DATA    M: MIXED", "RINEX VERSION / TYPE");
	read_all();
	assert_int_equal(got.end, FW_EUNKNOWN);

	begin_3("3.04");
	read_all();
	assert_int_equal(got.end, FW_ETRUNCATED);

	begin_3("3.04");
	add_header(&t, "G   xx C1C L1C", "SYS / # / OBS TYPES");
	add_header(&t, "Q    2 C1C L1C", "SYS / # / OBS TYPES");
	add_header(&t, "R    3 C1C L1C", "SYS / # / OBS TYPES");
	add_header(&t, "E    1 C1C", "SYS / # / OBS TYPES");
	add_header(&t, "G    0   1 C1C", "SYS / SCALE FACTOR");
	add_header(&t, "  1 R01 99", "GLONASS SLOT / FRQ #");
	add_header(&t, "  2024     6    24     8    20    0.0000000     XYZ", "TIME OF FIRST OBS");
	add_header(&t, "  abc", "APPROX POSITION XYZ");
	end_header();
	add_line(&t, "> 2024 06 24 08 20  0.0000000  0  1");
	add_line(&t, "E05  24722972.976");
	read_all();
	assert_int_equal(got.end, FW_EOF);
	problem_is(0, 2, "list of observables");
	problem_is(1, 3, "system that is not known");
	problem_is(2, 6, "scale factor");
	problem_is(3, 7, "GLONASS");
	problem_is(4, 8, "time system");
	problem_is(5, 9, "position");
	assert_int_equal(got.n_problems, 6);
	assert_int_equal(got.n, 1);
	t.used = 0;
	read_all();
	assert_int_equal(got.end, FW_EOF);
}

/* A file that is cut short gives a beginning of what the whole one gives, number by number, and says so
 * unless the cut lies between two epochs. */
static void cut_anywhere(void **state)
{
	static furrow_obs whole[MOST];
	(void)state;
	begin_plain();
	for (int i = 0; i < 3; i++) {
		add_line(&t, "> 2024 06 24 08 20 %2d.0000000  0  2", i);
		add_line(&t, "G05  24722972.976   129920098.14617     -2390.278 7        27.250");
		add_line(&t, "R02  19497563.592 7 103932986.89328       262.991          43.500");
	}
	read_all();
	const int n = got.n;
	memcpy(whole, got.obs, sizeof whole);
	for (size_t cut = 0; cut < t.used; cut++) {
		read_bytes(cut);
		assert_true(got.n <= n);
		for (int i = 0; i < got.n; i++) {
			const int64_t common = whole[i].present & got.obs[i].present;
			assert_int_equal(common | got.obs[i].present,
			                 common | (got.obs[i].present & whole[i].present));
			assert_true(got.obs[i].pseudorange_m == whole[i].pseudorange_m);
			assert_true(!has(&got.obs[i], FW_COL_obs_carrier_cyc) ||
			            got.obs[i].carrier_cyc == whole[i].carrier_cyc);
			assert_true(!has(&got.obs[i], FW_COL_obs_cn0_dbhz) ||
			            got.obs[i].cn0_dbhz == whole[i].cn0_dbhz);
		}
		assert_true(got.end == FW_EOF || got.end == FW_ETRUNCATED || got.end == FW_EUNKNOWN);
		if (got.end == FW_EOF && cut > 0 && got.n_problems == 0)
			assert_true(got.n >=
			            2 * got.n_epochs - 1); /* cut between two numbers of the last line */
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(plain_epochs),           cmocka_unit_test(variants_of_version_3),
	    cmocka_unit_test(times_of_other_systems), cmocka_unit_test(flags_of_epochs),
	    cmocka_unit_test(two_files_in_one),       cmocka_unit_test(version_2_wrapped),
	    cmocka_unit_test(codes_of_version_2),     cmocka_unit_test(half_wavelengths),
	    cmocka_unit_test(damaged_lines),          cmocka_unit_test(damaged_lines_of_version_2),
	    cmocka_unit_test(damaged_headers),        cmocka_unit_test(cut_anywhere),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
