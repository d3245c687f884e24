/* Reading RINEX navigation files. The files are written here after the RINEX documents (2.11, 3.05, 4.02);
 * expected values stand beside them. Against RTKLIB and georinex: tests/oracle/test_rinex.py. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "../rinex_text.h"
#include "formats/rinex_nav.h"
#include "furrow_eph_bds.h"
#include "furrow_eph_gal.h"
#include "furrow_eph_gal_columns.h"
#include "furrow_eph_glo.h"
#include "furrow_eph_glo_columns.h"
#include "furrow_eph_gps.h"
#include "furrow_eph_gps_columns.h"
#include "furrow_eph_sbas.h"
#include "furrow_klobuchar.h"
#include "furrow_nequick.h"
#include "furrow_utc.h"
#include "furrow_utc_columns.h"

enum { MOST = 64, TEXT = 8 };

static rinex_text t;
static fw_input input;
static fw_rinex_nav reader;

static struct {
	int n, n_problems;
	fw_kind kind[MOST];
	fw_any_record record[MOST];
	char sat[MOST][TEXT];
	fw_rinex_problem problems[MOST];
	fw_status end;
} got;

static void read_bytes(size_t n)
{
	fw_any_record record;
	fw_kind kind;
	fw_status status;

	memset(&got, 0, sizeof got);
	fw_input_open_memory(&input, t.bytes, n);
	fw_rinex_nav_begin(&reader, &input);
	while ((status = fw_rinex_nav_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_ESYNTAX) {
			got.problems[got.n_problems++ % MOST] = reader.problem;
			continue;
		}
		const furrow_klobuchar *head =
		    (const furrow_klobuchar *)(const void *)&record; /* all begin alike */
		assert_true(got.n < MOST);
		assert_string_equal(head->source, "rinex");
		snprintf(got.sat[got.n], TEXT, "%s", head->sat);
		got.kind[got.n] = kind;
		got.record[got.n++] = record;
	}
	got.end = status;
	assert_int_equal(fw_rinex_nav_read(&reader, &kind, &record), status);
}

static void read_all(void)
{
	read_bytes(t.used);
}

static void begin(const char *version)
{
	char text[64];

	t.used = 0;
	snprintf(text, sizeof text, "%9s           NAVIGATION DATA     M", version);
	add_header(&t, text, "RINEX VERSION / TYPE");
}

static void end_header(void)
{
	add_header(&t, "", "END OF HEADER");
}

static const void *record(int i, fw_kind kind, const char *sat)
{
	assert_true(i < got.n);
	assert_int_equal(got.kind[i], kind);
	assert_string_equal(got.sat[i], sat);
	return &got.record[i];
}

static void is(double x, double wanted)
{
	if (!(x == wanted))
		fail_msg("%.17g, not %.17g", x, wanted);
}

static int has(const void *r, int column)
{
	return (int)(((const fw_record_head *)r)->present >> column & 1);
}

/* Numbers 1.5, 2.5, ... in fields first..last of lines with four of them. */
static void add_numbers(int first, int last)
{
	for (int i = first; i <= last; i += 4) {
		char line[128] = "    ";
		for (int k = i; k < i + 4 && k <= last; k++)
			snprintf(line + strlen(line), sizeof line - strlen(line), "%19.12E", k + 0.5);
		add_line(&t, "%s", line);
	}
}

static const char gps[] = "G05 2024 06 24 10 00 00-1.774230040610E-04-1.364242052659E-12 0.000000000000E+00\n"
                          "     7.200000000000E+01-9.821875000000E+01 4.293035965037E-09 1.714815412488E+00\n"
                          "    -5.291774868965E-06 5.927642923780E-03 1.830980181694E-06 5.153635631561E+03\n"
                          "     1.224000000000E+05 3.352761268616E-08 2.520897825810E+00-5.774199962616E-08\n"
                          "     9.719266524177E-01 3.536250000000E+02 1.273307347665E+00-8.275344701323E-09\n"
                          "    -2.610823036973E-10 1.000000000000E+00 2.320000000000E+03 0.000000000000E+00\n"
                          "     2.000000000000E+00 0.000000000000E+00-1.071020960808E-08 7.200000000000E+01\n"
                          "     1.152180000000E+05 4.000000000000E+00";

static void of_gps(void **state)
{
	(void)state;
	begin("3.04");
	add_header(&t, "GPSA   1.8626E-08  2.2352E-08 -1.1921E-07 -5.9605E-08", "IONOSPHERIC CORR");
	add_header(&t, "GPSB   1.2902E+05  1.6384E+05 -1.9661E+05 -2.6214E+05", "IONOSPHERIC CORR");
	add_header(&t, "BDSA   3.1665E-08  9.6858E-08 -1.1325E-06  1.7285E-06 A 02", "IONOSPHERIC CORR");
	add_header(&t, "GAL    1.6175E+02  6.6016E-01  1.9379E-02  0.0000E+00", "IONOSPHERIC CORR");
	add_header(&t, "GPUT -9.3132257462E-10-7.993605777E-15 319488 2320", "TIME SYSTEM CORR");
	add_header(&t, "    18    19  2400     7", "LEAP SECONDS");
	end_header();
	add_line(&t, "%s", gps);
	add_line(&t, "J%s", gps + 1);
	read_all();
	assert_int_equal(got.n_problems, 0);
	assert_int_equal(got.end, FW_EOF);
	assert_int_equal(got.n, 6);
	const furrow_klobuchar *k = record(0, FW_klobuchar, "G");
	assert_true(k->alpha3_s == -5.9605E-08F && k->beta0_s == 1.2902E+05F && k->beta3_s == -2.6214E+05F);
	k = record(1, FW_klobuchar, "C02");
	assert_true(k->alpha1_s == 9.6858E-08F && k->present == 0xff); /* no beta */
	const furrow_nequick *n = record(2, FW_nequick, "E");
	assert_true(n->ai0_sfu == 161.75F && n->ai2_sfu == 1.9379E-02F);
	const furrow_utc *u = record(3, FW_utc, "G");
	is(u->a0_s, -9.3132257462E-10);
	assert_int_equal(u->tot_s, 319488);
	assert_int_equal(u->wnt, 2320 % 256);
	assert_int_equal(u->leap_s, 18);
	assert_int_equal(u->leap_future_s, 19);
	assert_int_equal(u->wnlsf, 2400 % 256);
	assert_int_equal(u->dn, 7);

	const furrow_eph_gps *e = record(4, FW_eph_gps, "G05");
	assert_int_equal(e->gps_week, 2320);
	is(e->tow_s, 115218); /* sent */
	is(u->tow_s, 115218); /* what the header says comes with it */
	assert_true(e->af0_s == -1.774230040610E-04 && e->af1_sps == -1.364242052659E-12F &&
	            e->af2_sps2 == 0);
	is(e->m0_rad, 1.714815412488);
	is(e->ecc, 5.927642923780E-03);
	is(e->sqrt_a_sqrtm, 5.153635631561E+03);
	is(e->omega0_rad, 2.520897825810);
	is(e->i0_rad, 9.719266524177E-01);
	is(e->omega_rad, 1.273307347665);
	is(e->omegadot_radps, -8.275344701323E-09);
	is(e->idot_radps, -2.610823036973E-10);
	is(e->deltan_radps, 4.293035965037E-09);
	assert_true(e->crs_m == -98.21875F && e->cuc_rad == -5.291774868965E-06F &&
	            e->cus_rad == 1.830980181694E-06F);
	assert_true(e->cic_rad == 3.352761268616E-08F && e->cis_rad == -5.774199962616E-08F &&
	            e->crc_m == 353.625F);
	assert_true(e->tgd_s == -1.071020960808E-08F);
	assert_int_equal(e->toe_s, 122400);
	assert_int_equal(e->toc_s, 122400); /* 10:00 on a Monday */
	assert_int_equal(e->toe_week, 2320 - 2048);
	assert_int_equal(e->toc_week, 2320 - 2048);
	assert_int_equal(e->week, 2320 - 2048);
	assert_int_equal(e->iodc, 72);
	assert_int_equal(e->iode2, 72);
	assert_int_equal(e->iode3, 72);
	assert_int_equal(e->ura, 0);
	assert_int_equal(e->code_on_l2, 1);
	assert_int_equal(e->fit, 0); /* 4 h */
	assert_int_equal(((const furrow_eph_gps *)record(5, FW_eph_gps, "J05"))->fit, 1);
}

/* toe in the next week, a week number that has rolled over, a time of transmission that is none. */
static void weeks_of_gps(void **state)
{
	(void)state;
	begin("3.04");
	end_header();
	add_line(&t, "%s", gps);
	assert_true(replace(&t, "2024 06 24 10 00 00", "2024 06 29 23 59 44"));
	assert_true(replace(&t, "1.224000000000E+05", "0.000000000000E+00"));
	assert_true(replace(&t, "2.320000000000E+03", "2.730000000000E+02"));
	assert_true(replace(&t, "1.152180000000E+05", "9.999000000000E+08"));
	read_all();
	assert_int_equal(got.n_problems, 0);
	const furrow_eph_gps *e = record(0, FW_eph_gps, "G05");
	assert_int_equal(e->toc_s, 604784);
	assert_int_equal(e->toc_week, 2320 - 2048);
	assert_int_equal(e->toe_week, 2321 - 2048);
	assert_int_equal(e->gps_week, 2320);
	is(e->tow_s, 604784);
}

static void of_galileo(void **state)
{
	(void)state;
	begin("3.04");
	end_header();
	for (int i = 0; i < 2; i++) {
		add_line(&t,
		         "E05 2023 12 31 23 40 00 4.705949453637e-03 3.666400516522e-12 0.000000000000e+00");
		add_numbers(0, 7);
		add_line(&t,
		         "     8.520000000000e+04 4.656612873077e-08 4.691600838407e-01 0.000000000000e+00");
		add_numbers(12, 15);
		/* F/NAV: sources 1 and 8; I/NAV: 0, 2 and 9 */
		add_line(&t, "    -4.643050544549e-11 %s 2.295000000000e+03 0.000000000000e+00",
		         i == 0 ? "2.580000000000e+02" : "5.170000000000e+02");
		/* health: E1B DVS and HS 3, E5a HS 1, E5b HS 2 */
		add_line(&t, "     3.120000000000e+00%19.12e 3.725290298462e-09 %s",
		         1 + 2 * 3 + 16 * 1 + 128 * 2.0,
		         i == 0 ? "0.000000000000e+00" : "4.190951585770e-09");
		add_line(&t, "     8.590000000000e+04");
	}
	read_all();
	assert_int_equal(got.n_problems, 0);
	/* Sunday 2023-12-31 23:40 is second 85200 of week 2295 */
	const furrow_eph_gal *e = record(0, FW_eph_gal, "E05");
	is(e->af0_s, 4.705949453637e-03);
	assert_int_equal(e->message, 16);
	assert_int_equal(e->health, 1 << 8 | 1 << 10);
	assert_int_equal(e->sisa_e1e5a, 107);
	assert_int_equal(has(e, FW_COL_eph_gal_sisa_e1e5b), 0);
	assert_int_equal(has(e, FW_COL_eph_gal_bgd_e1e5b_s), 0);
	assert_int_equal(e->toe_s, 85200);
	assert_int_equal(e->toc_s, 85200);
	assert_int_equal(e->toe_week, 2295);
	is(e->tow_s, 85900);
	e = record(1, FW_eph_gal, "E05");
	assert_int_equal(e->message, 2);
	assert_int_equal(e->health, 1 | 1 << 1 | 3 << 2 | 1 << 4 | 2 << 6);
	assert_true(e->bgd_e1e5b_s == 4.190951585770e-09F && e->bgd_e1e5a_s == 3.725290298462e-09F);
	assert_int_equal(e->sisa_e1e5b, 107);
}

static void of_beidou(void **state)
{
	(void)state;
	begin("3.05");
	end_header();
	add_line(&t, "C01 2024 01 01 00 00 00 8.813514141370e-04 5.533351554730e-13 0.000000000000e+00");
	add_line(&t, "     1.000000000000e+00-4.073593750000e+02 3.017268538490e-09-4.899218874420e-02");
	add_numbers(4, 7);
	add_line(&t, "     8.640000000000e+04-1.573935151100e-07-2.924794698380e+00 8.195638656620e-08");
	add_numbers(12, 15);
	add_line(
	    &t,
	    "    -3.764442518430e-10 0.000000000000e+00 2.295000000000e+03 0.000000000000e+00"); /* a GPS week */
	add_line(&t, "     2.000000000000e+00 1.000000000000e+00-5.400000002710e-09-9.800000000000e-09");
	add_line(&t, "     8.640700000000e+04 5.000000000000e+00                                      ");
	read_all();
	assert_int_equal(got.n_problems, 0);
	const furrow_eph_bds *e = record(0, FW_eph_bds, "C01");
	assert_int_equal(e->toe_s, 86400);
	assert_int_equal(e->toc_s, 86400);
	assert_int_equal(e->toe_week, 939); /* 2295 - 1356 */
	assert_int_equal(e->toc_week, 939);
	assert_int_equal(e->week, 939);
	assert_int_equal(e->aode, 1);
	assert_int_equal(e->aodc, 5);
	assert_int_equal(e->health, 1);
	assert_int_equal(e->ura, 0);
	assert_true(e->tgd1_s == -5.4000000027e-09F && e->tgd2_s == -9.8e-09F);
	assert_int_equal(e->gps_week, 2295);
	is(e->tow_s, 86407 + 14);
}

static void of_glonass_and_sbas(void **state)
{
	(void)state;
	begin("3.05");
	end_header();
	add_line(&t, "R01 2023 12 31 23 45 00 7.346738129854e-05 9.094947017729e-13 8.460000000000e+04");
	add_line(&t, "    -1.590860058594e+04 2.358419418335e+00-1.862645149231e-09 1.000000000000e+00");
	add_line(&t, "    -9.789697265625e+03 3.281402587891e-01-1.862645149231e-09-7.000000000000e+00");
	add_line(&t, "    -1.737410107422e+04-2.343545913696e+00-0.000000000000e+00 3.000000000000e+00");
	add_line(&t, "                         .999999999999e+09 1.500000000000e+01                   ");
	add_line(&t, "S22 2025 02 15 15 59 44 1.000000000000E-08 2.000000000000E-12 5.760000000000E+05");
	add_line(&t, "    -3.389392800000E+04 1.000000000000E-03 1.250000000000E-07 1.000000000000E+00");
	add_line(&t, "     2.508018800000E+04 0.000000000000E+00 0.000000000000E+00 3.276700000000E+04");
	add_line(&t, "     1.589600000000E+00 0.000000000000E+00 0.000000000000E+00 1.570000000000E+02");
	read_all();
	assert_int_equal(got.n_problems, 0);
	const furrow_eph_glo *e = record(0, FW_eph_glo, "R01");
	is(e->x_m, -1.590860058594e+07);
	is(e->vy_mps, 328.1402587891);
	is(e->ax_mps2, -1.862645149231e-06);
	assert_true(e->tau_s == -7.346738129854e-05 && e->gamma == 9.094947017729e-13F);
	assert_int_equal(e->glonass_channel, -7);
	assert_int_equal(e->health_b, 4);
	assert_int_equal(e->age_days, 3);
	assert_int_equal(has(e, FW_COL_eph_glo_dtau_s), 0);
	assert_int_equal(e->toe_s, 85500 + 18); /* Sunday 23:45 UTC */
	assert_int_equal(e->toe_week, 2295 % 1024);
	assert_int_equal(e->tb_min, 2 * 60 + 45); /* in Moscow */
	assert_int_equal(e->nt_day, 1);           /* where 2024 has begun */
	is(e->tow_s, 84600 + 18);
	assert_true(e->az_mps2 == 0 && !signbit(e->az_mps2));
	const furrow_eph_sbas *s = record(1, FW_eph_sbas, "S122");
	assert_int_equal(s->t0_s, 15 * 3600 + 59 * 60 + 44);
	is(s->x_m, -33893928);
	is(s->vx_mps, 1);
	assert_true(fabs(s->ax_mps2 - 1.25e-4) < 1e-18 && fabs(s->z_m - 1589.6) < 1e-9);
	assert_int_equal(s->iodn, 157);
	assert_int_equal(s->ura, 15);
	assert_true(s->agf0_s == 1e-8F && s->agf1_sps == 2e-12F);
	is(s->tow_s, 576000);
}

static void version_2(void **state)
{
	(void)state;
	t.used = 0;
	add_header(&t, "     2.11           N: GPS NAV DATA", "RINEX VERSION / TYPE");
	add_header(&t, "    .1676D-07   .2235D-07  -.1192D-06  -.1192D-06", "ION ALPHA");
	add_header(&t, "    .1208D+06   .1310D+06  -.1310D+06  -.1966D+06", "ION BETA");
	add_header(&t, "    .133179128170D-06  .107469588780D-12   552960     1025", "DELTA-UTC: A0,A1,T,W");
	add_header(&t, "    13", "LEAP SECONDS");
	end_header();
	add_line(&t, " 6 99  9  2 17 51 44.0 -.839701388031D-03 -.165982783074D-10  .000000000000D+00");
	add_line(&t, "     .910000000000D+02  .934062500000D+02  .116040547840D-08  .162092304801D+00");
	add_line(&t, "     .484101474285D-05  .626740418375D-02  .652112066746D-05  .515365489006D+04");
	add_line(&t, "     .409904000000D+06 -.242143869400D-07  .329237003460D+00 -.596046447754D-07");
	add_line(&t, "     .111541663136D+01  .326593750000D+03  .206958726335D+01 -.638312302555D-08");
	add_line(&t, "     .307155651409D-09  .000000000000D+00  .102500000000D+04  .000000000000D+00");
	add_line(&t, "     .000000000000D+00  .000000000000D+00  .000000000000D+00  .910000000000D+02");
	add_line(&t, "     .406800000000D+06  .000000000000D+00");
	add_line(&t, "13 99  9  2 19  0  0.0  .490025617182D-03  .204636307899D-11  .000000000000D+00");
	read_all(); /* the sample of the RINEX 2.11 document, table A4; the second satellite is cut short here */
	assert_int_equal(got.n_problems, 1);
	assert_int_equal(got.problems[0].line, 15);
	const furrow_klobuchar *k = record(0, FW_klobuchar, "G");
	assert_true(k->alpha0_s == .1676e-07F && k->beta3_s == -.1966e+06F);
	const furrow_utc *u = record(1, FW_utc, "G");
	is(u->a0_s, .133179128170e-06);
	assert_int_equal(u->wnt, 1025 % 256);
	assert_int_equal(u->leap_s, 13);
	assert_int_equal(has(u, FW_COL_utc_leap_future_s), 0);
	const furrow_eph_gps *e = record(2, FW_eph_gps, "G06");
	assert_int_equal(e->toc_s, 409904); /* Thursday 17:51:44 */
	assert_int_equal(e->toc_week, 1);
	is(e->sqrt_a_sqrtm, 5153.65489006);
	assert_int_equal(e->gps_week, 1025);
	is(e->tow_s, 406800);
	assert_int_equal(got.n, 3);

	t.used = 0;
	add_header(&t, "     2.11           G: GLONASS NAV DATA", "RINEX VERSION / TYPE");
	add_header(&t, "  1998     2    16    0.379979610443D-06", "CORR TO SYSTEM TIME");
	end_header();
	add_line(&t, " 3 98  2 15  0 15  0.0 0.163525342941D-03 0.363797880709D-11 0.108000000000D+05");
	add_line(&t, "    0.106275903320D+05-0.348924636841D+00 0.931322574615D-09 0.000000000000D+00");
	add_line(&t, "   -0.944422070313D+04 0.288163375854D+01 0.931322574615D-09 0.600000000000D+01");
	add_line(&t, "    0.212257280273D+05 0.144599342346D+01-0.186264514923D-08 0.300000000000D+01");
	read_all();
	assert_int_equal(got.n_problems, 0);
	const furrow_eph_glo *g = record(0, FW_eph_glo, "R03");
	assert_int_equal(g->glonass_channel, 6);
	assert_int_equal(g->toe_s, 15 * 60 + 12); /* Sunday; 12 leap seconds then */
	is(g->tow_s, 10800 + 12);                 /* 03:00 of that day */

	t.used = 0;
	add_header(&t, "     2.11           H: GEO NAV MSG DATA", "RINEX VERSION / TYPE");
	end_header();
	add_line(&t, "20 99  3 24  0  1 20.0 0.000000000000D+00 0.000000000000D+00 0.259200000000D+06");
	for (int i = 0; i < 3; i++)
		add_line(&t,
		         "    0.106275903320D+05 0.348924636841D+00 0.931322574615D-09 0.000000000000D+00");
	read_all();
	assert_int_equal(got.n_problems, 0);
	assert_int_equal(((const furrow_eph_sbas *)record(0, FW_eph_sbas, "S120"))->t0_s, 80);
}

static void version_4(void **state)
{
	(void)state;
	begin("4.02");
	add_header(&t, "    18", "LEAP SECONDS");
	end_header();
	add_line(&t, "> EPH G05 LNAV");
	add_line(&t, "%s", gps);
	add_line(&t, "> EPH C20 CNV1");
	add_line(&t, "C20 2025 02 15 15 00 00-8.602594025433E-04 4.520828156274E-12 0.000000000000E+00");
	add_numbers(0, 30);
	add_line(&t, "> EPH I02 LNAV");
	add_line(&t, "I%s", gps + 1);
	add_line(&t, "> EOP G05 CNVX");
	add_line(&t, "    2024 06 24 10 00 00 1.000000000000E+00 1.000000000000E+00 1.000000000000E+00");
	add_line(&t, "> ION G05 LNAV");
	add_line(&t, "    2024 06 24 10 00 00 1.862645149231E-08 2.235174179077E-08-1.192092895508E-07");
	add_line(&t, "    -5.960464477539E-08 1.290240000000E+05 1.638400000000E+05-1.966080000000E+05");
	add_line(&t, "    -2.621440000000E+05 0.000000000000E+00");
	add_line(&t, "> ION E05 IFNV");
	add_line(&t, "    2024 06 24 10 00 00 1.617500000000E+02 6.601562500000E-01 1.937866210938E-02");
	add_line(&t, "     3.000000000000E+00");
	add_line(&t, "> STO G05 LNAV");
	add_line(&t, "    2024 06 24 10 00 00 GPUT                                  UTC(USNO)");
	add_line(&t, "     1.152180000000E+05-9.313225746155E-10-7.993605777301E-15 0.000000000000E+00");
	add_line(&t, "> STO E05 INAV");
	add_line(&t, "    2024 06 24 10 00 00 GAGP");
	add_line(&t, "     1.152180000000E+05-9.313225746155E-10-7.993605777301E-15 0.000000000000E+00");
	add_line(&t, "> EPH G06 LNAV"); /* cut short */
	add_line(&t, "> EPH J05 LNAV");
	add_line(&t, "J%s", gps + 1);
	read_all();
	assert_int_equal(got.n_problems, 1);
	assert_int_equal(reader.passed_over, 4);
	assert_int_equal(got.n, 6);
	const furrow_utc *head = record(0, FW_utc, "G");
	assert_int_equal(head->leap_s, 18);
	(void)record(1, FW_eph_gps, "G05");
	const furrow_klobuchar *k = record(2, FW_klobuchar, "G05");
	assert_true(k->alpha3_s == -5.960464477539E-08F && k->beta3_s == -262144.0F &&
	            k->beta0_s == 129024.0F);
	const furrow_nequick *n = record(3, FW_nequick, "E05");
	assert_true(n->ai0_sfu == 161.75F && n->storm == 3);
	const furrow_utc *u = record(4, FW_utc, "G05");
	is(u->a0_s, -9.313225746155E-10);
	assert_int_equal(u->tot_s, 122400);
	assert_int_equal(u->leap_s, 18);
	(void)record(5, FW_eph_gps, "J05");
}

static void damaged(void **state)
{
	static const struct {
		const char *was, *is, *words;
	} cases[] = {
	    {"5.927642923780E-03", "5.9276429237x0E-03", "damaged"},
	    {"2024 06 24", "2024 16 24", "damaged"},
	    {"1.224000000000E+05", "1.224000000000E+55", "range"},
	    {"1.224000000000E+05", "9.999999000000E+05", "range"},
	    {"7.200000000000E+01", "7.200000000000E+31", "range"},
	    {"G05", "G99", "no satellite"},
	    {"G05", "?05", "no satellite"},
	    {"G05", "   ", "no entry"},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		begin("3.04");
		end_header();
		add_line(&t, "%s", gps);
		assert_true(replace(&t, cases[i].was, cases[i].is));
		add_line(&t, "J%s", gps + 1);
		read_all();
		assert_int_equal(got.end, FW_EOF);
		assert_int_equal(got.n_problems, 1);
		assert_int_equal(got.problems[0].line, 3);
		if (strstr(got.problems[0].reason, cases[i].words) == NULL)
			fail_msg("%s: %s", cases[i].is, got.problems[0].reason);
		assert_int_equal(got.n, 1);
		(void)record(0, FW_eph_gps, "J05");
	}
	t.used = 0;
	add_header(&t, "     3.04           OBSERVATION DATA", "RINEX VERSION / TYPE");
	read_all();
	assert_int_equal(got.end, FW_EUNKNOWN);
	begin("3.04");
	read_all();
	assert_int_equal(got.end, FW_ETRUNCATED);
}

/* An ephemeris comes whole, or not at all. */
static void cut_anywhere(void **state)
{
	(void)state;
	begin("3.04");
	end_header();
	add_line(&t, "%s", gps);
	read_all();
	assert_int_equal(got.n, 1);
	const fw_any_record whole = got.record[0];
	for (size_t cut = 0; cut < t.used; cut++) {
		read_bytes(cut);
		assert_true(got.end == FW_EOF || got.end == FW_ETRUNCATED || got.end == FW_EUNKNOWN);
		if (got.n == 0)
			continue;
		const furrow_eph_gps *a = (const furrow_eph_gps *)(const void *)&got.record[0],
		                     *b = (const furrow_eph_gps *)(const void *)&whole;
		assert_true(a->tow_s == b->tow_s ||
		            a->tow_s == 122400); /* cut before the time of transmission */
		is(a->ecc, b->ecc);
		assert_int_equal(a->iodc, b->iodc);
		is((double)a->tgd_s, (double)b->tgd_s);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(of_gps),
	    cmocka_unit_test(weeks_of_gps),
	    cmocka_unit_test(of_galileo),
	    cmocka_unit_test(of_beidou),
	    cmocka_unit_test(of_glonass_and_sbas),
	    cmocka_unit_test(version_2),
	    cmocka_unit_test(version_4),
	    cmocka_unit_test(damaged),
	    cmocka_unit_test(cut_anywhere),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
