/* SBF blocks to records. The blocks in hexadecimal are from a public log of a mosaic-X5 receiver; their raw values
 * are those that pysbf2 gives for them, converted here by the rules of the reference guide. All other blocks are made
 * byte by byte, and what they should become is worked out by hand. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <stdlib.h>

#include "../sbf_record_list.h"
#include "base/random.h"
#include "formats/sbf_records.h"

#define ABSENT ((double)NAN)
#define GPS_PI 3.1415926535898
#define TO_DEG (180 / M_PI)
#define GIVEN  1e-8 /* nine digits are given for floats */

static fw_sbf_plans plans;
static record_list list;
static fw_kind_set all;
static uint8_t block[8192];

static int set_up(void **state)
{
	(void)state;
	memset(&all, 0xFF, sizeof all);
	fw_sbf_plans_init(&plans);
	return 0;
}

static fw_status emit(const uint8_t *bytes)
{
	list_clear(&list);
	return fw_sbf_emit(&plans, bytes, fw_load_u16(bytes + 6), &all, (fw_sink){list_put, &list});
}

static void emit_hex(const char *hex)
{
	bytes_from_hex(hex, block);
	assert_int_equal(emit(block), FW_OK);
}

/* Seals `block`, whose body is written, and emits its records. */
static void emit_block(uint16_t id, uint16_t length)
{
	fw_sbf_seal(block, id, fw_sbf_schema_find(id)->revision, length, 100500, 2367);
	assert_int_equal(emit(block), FW_OK);
}

static void put_f4(size_t at, float x)
{
	uint32_t bits;
	memcpy(&bits, &x, sizeof bits);
	fw_store_u32(block + at, bits);
}

static void put_f8(size_t at, double x)
{
	uint64_t bits;
	memcpy(&bits, &x, sizeof bits);
	fw_store_u64(block + at, bits);
}

typedef struct {
	const char *column;
	double value;
} expectation;

/* The only record of the list against n columns. */
static void expect_all(fw_kind kind, const expectation *expected, size_t n)
{
	assert_int_equal(list.n, 1);
	assert_int_equal(list.at[0].kind, kind);
	for (size_t i = 0; i < n; i++)
		expect_number(&list, 0, expected[i].column, expected[i].value, GIVEN);
}

#define EXPECT(kind, ...)                                                                                    \
	do {                                                                                                 \
		const expectation e_[] = {__VA_ARGS__};                                                      \
		expect_all(kind, e_, sizeof e_ / sizeof e_[0]);                                              \
	} while (0)

static unsigned present_columns(size_t i)
{
	return (unsigned)__builtin_popcountll((unsigned long long)list.at[i].record.head.present);
}

/* ---- Real blocks ---- */

static void receiver_time(void **state)
{
	(void)state;
	emit_hex("2440bd131a171800702fcb1c3f091905170e0b0012070000");
	EXPECT(FW_time, {"gps_week", 2367}, {"tow_s", 483078}, {"utc_year", 25}, {"utc_month", 5},
	       {"utc_day", 23}, {"utc_hour", 14}, {"utc_min", 11}, {"utc_sec", 0}, {"leap_s", 18},
	       {"sync", 7});
}

static void dop(void **state)
{
	(void)state;
	emit_hex("244057f9a10f2000e052c91c3f0925004f0028002c004200f5e77840fc96b540");
	EXPECT(FW_dop, {"gps_week", 2367}, {"tow_s", 482956}, {"n_sats", 37}, {"pdop", 0.79}, {"tdop", 0.40},
	       {"hdop", 0.44}, {"vdop", 0.66}, {"hpl_m", 3.88915753}, {"vpl_m", 5.67468071});
}

#define PVT                                                                                                  \
	"2440710ea74f600018a9c71c3f09060091827c11fecaed3f0decd5a89a13a4bf0f92c36df36560404fe941425bb9a03a0b" \
	"98"                                                                                                 \
	"50ba738efc39f90295d0d821db51dcc3b13f7f8b4a3e000024077b0016010101225001010000370066008a006000"
#define POS_COV                                                                                              \
	"2440e0b91217380018a9c71c3f090600d7ae253eb743c93dae2ef43e009a863e432e703c6218573d156f113dc1ff70bd4e" \
	"47"                                                                                                 \
	"5cbd8c58ab3e"
#define VEL_COV                                                                                              \
	"244034961417380018a9c71c3f090600bdb6da374d9a9b374f384038f8ac1a38673d1b36f70ea23533cf3f35d3b244b6d8" \
	"90"                                                                                                 \
	"99b567fc0538"

static void pvt_geodetic(void **state)
{
	(void)state;
	emit_hex(PVT);
	EXPECT(FW_pvt, {"gps_week", 2367}, {"tow_s", 482847}, {"mode", 6}, {"auto_base", 0}, {"two_d", 0},
	       {"error", 0}, {"lat_deg", 0.931029352334081 * TO_DEG},
	       {"lon_deg", -0.039212067708796 * TO_DEG}, {"height_m", 131.185965425466},
	       {"undulation_m", 48.4778404}, {"vn_mps", 0.00122622715}, {"ve_mps", -0.000795722648},
	       {"vd_mps", -0.000481713185}, {"course_deg", ABSENT}, {"clock_bias_s", 0.0693948459476198e-3},
	       {"clock_drift_ppm", 0.19779776}, {"time_system", 0}, {"datum", 0}, {"n_sats", 36},
	       {"wa_corr", 7}, {"reference_id", 123}, {"corr_age_s", 2.78}, {"signals", 1344405761},
	       {"alert", 1}, {"n_bases", 1}, {"ppp_info", 0}, {"latency_s", 0.0055}, {"h_accuracy_m", 1.02},
	       {"v_accuracy_m", 1.38}, {"misc", 96}, {"sd_n_m", ABSENT}, {"cov_vnvn_m2ps2", ABSENT});
	expect_number(&list, 0, "lat_deg", 0.931029352334081 * TO_DEG, 1e-14);
}

static void covariances(void **state)
{
	(void)state;
	emit_hex(POS_COV);
	EXPECT(FW_pvt, {"mode", 6}, {"error", 0}, {"cov_nn_m2", 0.161799774}, {"cov_ee_m2", 0.0982736871},
	       {"cov_dd_m2", 0.476918638}, {"cov_bb_m2", 0.262893677}, {"cov_ne_m2", 0.0146594672},
	       {"cov_nd_m2", -0.0525134876}, {"cov_nb_m2", 0.0355063267}, {"cov_ed_m2", 0.0588376559},
	       {"cov_eb_m2", -0.0537789389}, {"cov_db_m2", -0.334659934}, {"sd_n_m", sqrt(0.161799774)},
	       {"sd_e_m", sqrt(0.0982736871)}, {"sd_d_m", sqrt(0.476918638)}, {"lat_deg", ABSENT});
	emit_hex(VEL_COV);
	EXPECT(FW_pvt, {"cov_vnvn_m2ps2", 2.60727193e-05}, {"cov_veve_m2ps2", 1.85492918e-05},
	       {"cov_vdvd_m2ps2", 4.58288087e-05}, {"cov_ff_m2ps2", 3.68775509e-05},
	       {"cov_vnve_m2ps2", 2.31325407e-06}, {"cov_vnvd_m2ps2", -1.20742959e-06},
	       {"cov_vnf_m2ps2", 7.14545592e-07}, {"cov_vevd_m2ps2", 2.93103653e-06},
	       {"cov_vef_m2ps2", -1.14415434e-06}, {"cov_vdf_m2ps2", -3.1944739e-05});
}

/* Three blocks of one epoch become one record, in whatever order. */
static void blocks_of_an_epoch_merge(void **state)
{
	(void)state;
	const char *const hex[] = {VEL_COV, PVT, POS_COV};
	static fw_any_record record;
	fw_record_clear(FW_pvt, &record);
	for (int i = 0; i < 3; i++) {
		size_t length = bytes_from_hex(hex[i], block);
		assert_int_equal(fw_sbf_fill(&plans, block, length, &record), FW_OK);
	}
	list_clear(&list);
	list_put(&list, FW_pvt, &record);
	EXPECT(FW_pvt, {"gps_week", 2367}, {"tow_s", 482847}, {"height_m", 131.185965425466},
	       {"cov_nd_m2", -0.0525134876}, {"cov_vnvd_m2ps2", -1.20742959e-06},
	       {"sd_d_m", sqrt(0.476918638)});
	assert_int_equal(present_columns(0),
	                 fw_record_type_of(FW_pvt)->n_columns - 1); /* all but the course */
}

static void attitude_not_requested(void **state)
{
	(void)state;
	emit_hex("244049c332172c008831ca1c3f09ff8000000000f90295d0f90295d0f90295d0f90295d0f90295d0f90295d0");
	EXPECT(FW_att, {"tow_s", 483013}, {"n_sats", ABSENT}, {"error_aux1", 0}, {"error_aux2", 0},
	       {"not_requested", 1}, {"mode", 0}, {"heading_deg", ABSENT}, {"pitch_deg", ABSENT},
	       {"roll_deg", ABSENT}, {"headingrate_degps", ABSENT});
	emit_hex("24407c90331728008831ca1c3f090080f90295d0f90295d0f90295d0f90295d0f90295d0f90295d0");
	EXPECT(FW_att, {"not_requested", 1}, {"cov_hh_deg2", ABSENT}, {"sd_heading_deg", ABSENT},
	       {"cov_pr_deg2", ABSENT});
	assert_int_equal(present_columns(0), 5);
}

static void ionosphere(void **state)
{
	(void)state;
	emit_hex("2440ba2c05173000f0bb59183f090900000060320000c032000080b3000000b40000cc4700000048000080c7000"
	         "0e0c8");
	EXPECT(FW_klobuchar, {"tow_s", 408534}, {"alpha0_s", 1.3038516e-08}, {"alpha1_s", 2.23517418e-08},
	       {"alpha2_s", -5.96046448e-08}, {"alpha3_s", -1.1920929e-07}, {"beta0_s", 104448},
	       {"beta1_s", 131072}, {"beta2_s", -65536}, {"beta3_s", -458752});
	assert_string_equal(list_text(&list, 0, "sat"), "G09");
	assert_string_equal(list_text(&list, 0, "source"), "decoded");
	emit_hex("24407b2cbe0f20003815c31c3f096a020080f9420000083f0000243c00000000");
	EXPECT(FW_nequick, {"tow_s", 482547}, {"message", 2}, {"ai0_sfu", 124.75}, {"ai1_sfu", 0.53125},
	       {"ai2_sfu", 0.0100097656}, {"storm", 0});
	assert_string_equal(list_text(&list, 0, "sat"), "E36");
}

static void clocks_of_systems(void **state)
{
	(void)state;
	emit_hex("2440e78a06172800f0bb59183f090900000000a800000000000028be000009003f12890712000048");
	EXPECT(FW_utc, {"tow_s", 408534}, {"a1_sps", -7.10542736e-15}, {"a0_s", -2.79396772384644e-09},
	       {"tot_s", 589824}, {"wnt", 63}, {"leap_s", 18}, {"wnlsf", 137}, {"dn", 7},
	       {"leap_future_s", 18}, {"message", ABSENT});
	assert_string_equal(list_text(&list, 0, "sat"), "G09");
	emit_hex("2440b2a6c00f2000e0f9c21c3f096a10000090270000ac3000e907003f970600");
	EXPECT(FW_ggto, {"tow_s", 482540}, {"message", 16}, {"a1_sps", 3.99680289e-15},
	       {"a0_s", 1.25146471e-09}, {"tot_s", 518400}, {"wnt", 63});
	emit_hex("24400904c40f28002019c31c3f09380b0800fc010000003100000000000028be0000f03c00001cba");
	EXPECT(FW_glo_time, {"tow_s", 482548}, {"glonass_channel", 3}, {"n4", 8}, {"kp", 0}, {"day", 508},
	       {"tau_gps_s", 1.86264515e-09}, {"tau_c_s", -2.79396772384644e-09}, {"b1_s", 0.029296875},
	       {"b2_s", -0.000595092773});
	assert_string_equal(list_text(&list, 0, "sat"), "R19");
}

static void sbas_messages(void **state)
{
	(void)state;
	emit_hex("2440adb125171000d0d2c21c3f097904");
	EXPECT(FW_sbas_mt0, {"tow_s", 482530});
	assert_string_equal(list_text(&list, 0, "sat"), "S121");
	emit_hex("2440cfbd2a177000e0f9c21c3f0988000000000000000000b6f3fdd478e9d63fdf718a8ee4f27f3f780000000f2"
	         "db29defa7"
	         "ee3f780000000e2db29defa7c63f7b14ae47e17a943f7800000000000000a01a2fdd2406e53f2c0100000000000"
	         "0000000"
	         "00000000000000000000000000");
	EXPECT(FW_sbas_factors, {"tow_s", 482540}, {"brrc_m", 0}, {"cltc_lsb_m", 0.358},
	       {"cltc_v1_mps", 0.0078}, {"iltc_v1_s", 120}, {"cltc_v0_m", 0.958}, {"iltc_v0_s", 120},
	       {"cgeo_lsb_m", 0.177}, {"cgeo_v_mps", 0.02}, {"igeo_s", 120}, {"cer_m", 0},
	       {"ciono_step_m", 0.657}, {"iiono_s", 300}, {"ciono_ramp_mps", 0}, {"rss_udre", 0},
	       {"rss_iono", 0}, {"ccovariance", 0});
	emit_hex(
	    "2440bfe00817680040eac21c3f097bffb8000f0060c50000000000e035708241000000c0cf0870410000000000000000"
	    "000000"
	    "000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
	    "0000");
	EXPECT(FW_eph_sbas, {"tow_s", 482536}, {"iodn", 184}, {"ura", 15}, {"t0_s", 50528}, {"x_m", 38667964},
	       {"y_m", 16813308}, {"z_m", 0}, {"vx_mps", 0}, {"az_mps2", 0}, {"agf0_s", 0}, {"agf1_sps", 0});
	assert_string_equal(list_text(&list, 0, "sat"), "S123");
}

static void pages(void **state)
{
	(void)state;
	emit_hex("244091e8b10f3c00501dc11c3f0901010000002f103fc122c46b422741d4f93fe1644709c549050032138605d08"
	         "18b06d1bf"
	         "8030bac8e93f3ccdfc00");
	EXPECT(FW_page, {"crc_ok", 1}, {"viterbi", 0}, {"rx_channel", 47}, {"glonass_channel", ABSENT},
	       {"e1_e5b", ABSENT});
	assert_string_equal(list_text(&list, 0, "sat"), "G01");
	assert_string_equal(list_text(&list, 0, "message"), "LNAV");
	assert_string_equal(list_text(&list, 0, "signal"), "1C");
	assert_string_equal(
	    list_text(&list, 0, "bits"),
	    "22C13F1027426BC43FF9D441094764E1000549C505861332068B81D03080BFD13FE9C8BA00FCCD3C");

	emit_hex("2440f568b70f34009811c11c3f096a010011000e34087a1362cc7b83201188c4506fd60bb001ebda0448f5b0e0f"
	         "b0a5e0000"
	         "0040");
	EXPECT(FW_page, {"crc_ok", 1}, {"e1_e5b", 0}, {"rx_channel", 14});
	assert_string_equal(list_text(&list, 0, "sat"), "E36");
	assert_string_equal(list_text(&list, 0, "message"), "INAV");
	assert_string_equal(list_text(&list, 0, "signal"), "1C");
	assert_string_equal(list_text(&list, 0, "bits"),
	                    "137A0834837BCC62C48811200BD66F50DAEB01B0B0F548045E0AFBE040000000");

	emit_hex("24400b7eb40f34009811c11c3f0988010018001ec4ff12c6ff0300000000e8ff0000000000000000adbb0300000"
	         "0807b8029"
	         "c50d");
	EXPECT(FW_sbas, {"type", 4}, {"crc_ok", 1}, {"viterbi", 0}, {"rx_channel", 30});
	assert_string_equal(list_text(&list, 0, "sat"), "S136");
	assert_string_equal(list_text(&list, 0, "signal"), "1C");
	assert_string_equal(list_text(&list, 0, "bits"),
	                    "C612FFC4000003FFFFE8000000000000000000000003BBAD7B8000000DC5298");
}

static void markers_make_no_record(void **state)
{
	(void)state;
	bytes_from_hex("244045b42217100068a2bf1c3f096410", block);
	assert_int_equal(emit(block), FW_EUNKNOWN);
	assert_int_equal(list.n, 0);
}

/* ---- Made blocks ---- */

/* Do-not-use of every kind in one block; an impossible integer; the stamp. */
static void absent_values(void **state)
{
	(void)state;
	bytes_from_hex(PVT, block);
	memset(block + 72, 0xFF, 24 - 4); /* TimeSystem .. HAccuracy: all ones */
	put_f8(16, -2e10);
	put_f8(24, (double)NAN);
	put_f8(32, (double)INFINITY);
	put_f4(44, -2e10F);
	put_f4(48, -1.8e10F);
	fw_sbf_seal(block, 4007, 2, 96, UINT32_MAX, UINT16_MAX);
	assert_int_equal(emit(block), FW_OK);
	EXPECT(FW_pvt, {"gps_week", ABSENT}, {"tow_s", ABSENT}, {"lat_deg", ABSENT}, {"lon_deg", ABSENT},
	       {"height_m", ABSENT}, {"vn_mps", ABSENT}, {"ve_mps", (double)-1.8e10F},
	       {"time_system", ABSENT}, {"datum", ABSENT}, {"n_sats", ABSENT}, {"wa_corr", 255},
	       {"reference_id", ABSENT}, {"corr_age_s", ABSENT}, {"signals", 4294967295.0},
	       {"latency_s", ABSENT}, {"h_accuracy_m", ABSENT}, {"v_accuracy_m", 1.38});
	assert_int_equal(list.at[0].record.head.gps_week, 0);

	memset(block, 0, sizeof block);
	block[14] = 5, block[15] = 200; /* CRCPassed is 0 or 1; 200 does not even fit its column */
	emit_block(4017, 60);
	EXPECT(FW_page, {"crc_ok", ABSENT}, {"viterbi", 0});
}

/* What an old revision does not have is absent. */
static void short_blocks(void **state)
{
	(void)state;
	bytes_from_hex(PVT, block);
	fw_sbf_seal(block, 4007, 0, 88, 1000, 2000);
	assert_int_equal(emit(block), FW_OK);
	EXPECT(FW_pvt, {"ppp_info", ABSENT}, {"n_bases", ABSENT}, {"latency_s", ABSENT}, {"misc", ABSENT});
	fw_sbf_seal(block, 4007, 1, 88, 1000, 2000); /* as long, but what was padding means something */
	assert_int_equal(emit(block), FW_OK);
	EXPECT(FW_pvt, {"ppp_info", 0}, {"n_bases", 1}, {"latency_s", ABSENT}, {"misc", ABSENT});
	fw_sbf_seal(block, 4007, 0, 16, 1000, 2000);
	assert_int_equal(emit(block), FW_OK);
	EXPECT(FW_pvt, {"tow_s", 1}, {"mode", 6}, {"error", 0}, {"lat_deg", ABSENT});
	assert_int_equal(present_columns(0), 6);
}

static void rows_take_what_the_block_says_once(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	block[14] = 136, block[15] = 3, block[16] = 3; /* GEOPRNMask: G01, S123, and no satellite */
	block[17] = 1, block[18] = 123, block[19] = 0;
	emit_block(5926, 20);
	assert_int_equal(list.n, 3);
	for (size_t i = 0; i < 3; i++) {
		expect_number(&list, i, "iodp", 3, 0);
		expect_number(&list, i, "mask_no", (double)i + 1, 0);
		assert_string_equal(list_text(&list, i, "sat"), "S136");
	}
	assert_string_equal(list_text(&list, 0, "mask_sat"), "G01");
	assert_string_equal(list_text(&list, 1, "mask_sat"), "S123");
	assert_string_equal(list_text(&list, 2, "mask_sat"), "absent");

	for (int i = 0; i < 51; i++)
		block[20 + i] = (uint8_t)(i % 16);
	emit_block(5928, 72);
	assert_int_equal(list.n, 51);
	expect_number(&list, 50, "mask_no", 51, 0);
	expect_number(&list, 50, "udrei", 2, 0);
}

/* A base vector of 52 bytes in sub-blocks of 60, then in ones of 40, where the azimuth is missing. */
static void sub_blocks_are_stepped_by_their_length(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	block[14] = 2;
	for (unsigned i = 0; i < 2; i++) {
		put_f8(16 + 60 * i + 4, 10.5 + i);   /* east */
		put_f8(16 + 60 * i + 12, 20.25 + i); /* north */
		fw_store_u16(block + 16 + 60 * i + 40, (uint16_t)(9000 + i));
		fw_store_u16(block + 16 + 60 * i + 42, i == 0 ? (uint16_t)-1234 : 0x8000);
	}
	block[15] = 60;
	emit_block(4028, 136);
	assert_int_equal(list.n, 2);
	assert_int_equal(list.at[0].kind, FW_base);
	expect_number(&list, 1, "east_m", 11.5, 0);
	expect_number(&list, 1, "north_m", 21.25, 0);
	expect_number(&list, 0, "azimuth_deg", 90, 1e-15);
	expect_number(&list, 0, "elevation_deg", -12.34, 1e-15);
	expect_number(&list, 1, "azimuth_deg", 90.01, 1e-15);
	expect_number(&list, 1, "elevation_deg", ABSENT, 0);

	block[15] = 40;
	emit_block(4028, 96);
	assert_int_equal(list.n, 2);
	expect_number(&list, 0, "east_m", 10.5, 0);
	expect_number(&list, 0, "azimuth_deg", ABSENT, 0);

	block[14] = 0;
	emit_block(4028, 16);
	assert_int_equal(list.n, 0);
}

static void contradictions_emit_nothing(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	block[14] = 2, block[15] = 52;
	fw_sbf_seal(block, 4028, 0, 116, 1000, 2000);
	assert_int_equal(emit(block), FW_EFORMAT);
	assert_int_equal(list.n, 0);
	block[15] = 0;
	fw_sbf_seal(block, 4028, 0, 120, 1000, 2000);
	assert_int_equal(emit(block), FW_EFORMAT);
	/* The second of two signals has a residual more than there is room for. */
	block[14] = 2, block[15] = 12, block[16] = 8;
	block[20 + 5] = 1, block[20 + 12 + 8 + 5] = 3;
	fw_sbf_seal(block, 4009, 1, 20 + 2 * 12 + 2 * 8, 1000, 2000);
	assert_int_equal(emit(block), FW_EFORMAT);
	assert_int_equal(list.n, 0);
	fw_sbf_seal(block, 4013, 1, 16, 1000, 2000);
	assert_int_equal(emit(block), FW_EUNKNOWN);
}

static void residuals(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	block[14] = 1, block[15] = 12, block[16] = 8;
	block[20] = 38, block[21] = 9, block[22] = 8 | 1 << 5; /* R01, k = 1, GLONASS L1 C/A, antenna aux1 */
	block[23] = 39, block[25] = 5;                         /* reference R02; code and Doppler */
	fw_store_u16(block + 26, 77);
	fw_store_u16(block + 28, 150);
	fw_store_u16(block + 30, 65535);
	put_f4(32, 1.5F);
	fw_store_u16(block + 36, 500);
	fw_store_u16(block + 38, 25);
	put_f4(40, -0.25F);
	fw_store_u16(block + 44, 65535);
	fw_store_u16(block + 46, 25);
	emit_block(4009, 48);
	assert_int_equal(list.n, 2);
	for (size_t i = 0; i < 2; i++) {
		assert_string_equal(list_text(&list, i, "sat"), "R01");
		assert_string_equal(list_text(&list, i, "ref_sat"), "R02");
		assert_string_equal(list_text(&list, i, "signal"), "1C");
		expect_number(&list, i, "glonass_channel", 1, 0);
		expect_number(&list, i, "antenna", 1, 0);
		expect_number(&list, i, "iode", 77, 0);
		expect_number(&list, i, "corr_age_s", 1.5, 1e-15);
		expect_number(&list, i, "reference_id", ABSENT, 0);
	}
	assert_string_equal(list_text(&list, 0, "quantity"), "code");
	assert_string_equal(list_text(&list, 1, "quantity"), "doppler");
	expect_number(&list, 0, "residual", 1.5, 0);
	expect_number(&list, 0, "weight", 0.5, 1e-15);
	expect_number(&list, 0, "mdb", 2.5, 1e-15); /* in 0.1 m */
	expect_number(&list, 1, "residual", -0.25, 0);
	expect_number(&list, 1, "weight", ABSENT, 0);
	expect_number(&list, 1, "mdb", 0.25, 1e-15); /* in 0.01 m/s */
}

static void satellite_positions(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	block[14] = 2, block[15] = 48;
	for (unsigned i = 0; i < 2; i++) {
		uint8_t *sub = block + 16 + 48 * i;
		sub[0] = (uint8_t)(7 + i);
		fw_store_u16(sub + 40, i == 0 ? 45 : 0x8000);       /* 45 + 128/256: 4.55 m */
		fw_store_u16(sub + 42, i == 0 ? (uint16_t)-3 : 24); /* -3 + 64/256: -0.275 m */
		sub[44] = 128, sub[45] = 64, sub[46] = 1;
	}
	emit_block(4008, 112);
	assert_int_equal(list.n, 2);
	expect_number(&list, 0, "iono_m", 4.55, 1e-15);
	expect_number(&list, 0, "tropo_m", -0.275, 1e-15);
	expect_number(&list, 0, "glonass_channel", ABSENT, 0);
	expect_number(&list, 1, "iono_m", ABSENT, 0);
	expect_number(&list, 1, "tropo_m", 2.425, 1e-15);
	block[15] = 40; /* revision 0 */
	emit_block(4008, 96);
	expect_number(&list, 0, "iono_m", ABSENT, 0);
	expect_number(&list, 0, "iono_model", ABSENT, 0);
}

static void receiver_status(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	block[14] = 30, block[31] = 145, block[29] = 4;
	emit_block(4014, 32);
	assert_int_equal(list.n, 1); /* no front end: the status all the same */
	expect_number(&list, 0, "temperature_degc", 45, 0);
	expect_number(&list, 0, "front_end", ABSENT, 0);
	block[28] = 2, block[31] = 0;
	memcpy(block + 32, (const uint8_t[]){3, 40, 100, 0, 4 | 2 << 5, 0x80, 99, 7}, 8);
	emit_block(4014, 40);
	assert_int_equal(list.n, 2);
	expect_number(&list, 0, "temperature_degc", ABSENT, 0);
	expect_number(&list, 0, "gain_db", 40, 0);
	expect_number(&list, 1, "gain_db", ABSENT, 0);
	expect_number(&list, 1, "cpu_load_pct", 30, 0);
	expect_number(&list, 1, "front_end", 4, 0);
	expect_number(&list, 1, "antenna", 2, 0);
	expect_number(&list, 1, "blanking_pct", 7, 0);
}

static void texts(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	memset(block + 16, 'm', 60); /* no NUL: the field's end ends it */
	memcpy(block + 76, "17", 2);
	memset(block + 400, 'B', 3);
	emit_block(5902, 424);
	assert_int_equal(list.n, 1);
	assert_string_equal(list_text(&list, 0, "marker_name"),
	                    "mmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmmm");
	assert_string_equal(list_text(&list, 0, "marker_number"), "17");
	assert_string_equal(list_text(&list, 0, "observer"), "absent");
	assert_string_equal(list_text(&list, 0, "country"), "BBB");

	memset(block, 'x', sizeof block);
	fw_store_u16(block + 14, 5);
	memcpy(block + 16, "hello", 5);
	emit_block(5936, 24);
	assert_string_equal(list_text(&list, 0, "text"), "hello");
	fw_store_u16(block + 14, 0);
	emit_block(5936, 16);
	assert_int_equal(list.n, 1);
	assert_string_equal(list_text(&list, 0, "text"), "absent");
	fw_store_u16(block + 14, 5);
	fw_sbf_seal(block, 5936, 0, 20, 0, 0);
	assert_int_equal(emit(block), FW_EFORMAT);
}

static void emit_event(uint32_t tow_ms, uint16_t week, float offset, double bias)
{
	memset(block, 0, sizeof block);
	block[14] = 2, block[15] = 1;
	put_f4(16, offset);
	put_f8(20, bias);
	fw_store_u16(block + 28, 600);
	fw_sbf_seal(block, 5924, 1, 32, tow_ms, week);
	assert_int_equal(emit(block), FW_OK);
	assert_int_equal(list.at[0].kind, FW_event);
}

/* t = stamp + Offset - RxClkBias; 0.5 and 0.125 are exact in every format. */
static void events_carry_their_own_time(void **state)
{
	(void)state;
	emit_event(100000, 2367, 0.5F, 0.125);
	EXPECT(FW_event, {"gps_week", 2367}, {"tow_s", 100.375}, {"rx_tow_s", 100}, {"offset_s", 0.5},
	       {"clock_bias_s", 0.125}, {"source", 2}, {"polarity", 1}, {"pvt_age_s", 600});
	emit_event(100000, 2367, 0.5F, -2e10);
	EXPECT(FW_event, {"tow_s", 100.5}, {"rx_tow_s", 100}, {"clock_bias_s", ABSENT});
	emit_event(604799750, 2367, 0.5F, 0.125);
	EXPECT(FW_event, {"gps_week", 2368}, {"tow_s", 0.125}, {"rx_tow_s", 604799.75});
	emit_event(0, 2367, 0.125F, 0.5);
	EXPECT(FW_event, {"gps_week", 2366}, {"tow_s", 604799.625}, {"rx_tow_s", 0});
	emit_event(0, 2367, 0, 1e-15); /* rounds up to the end of the week, which is the start of the next */
	EXPECT(FW_event, {"gps_week", 2367}, {"tow_s", 0});
	emit_event(0, UINT16_MAX, 0.125F, 0.5);
	EXPECT(FW_event, {"gps_week", ABSENT}, {"tow_s", 604799.625});
	assert_int_equal(list.at[0].record.head.gps_week, 0);
	emit_event(UINT32_MAX, 2367, 0.5F, 0.125);
	EXPECT(FW_event, {"gps_week", 2367}, {"tow_s", ABSENT}, {"rx_tow_s", ABSENT});
	emit_event(100000, 2367, 3e38F, 0.125);
	EXPECT(FW_event, {"gps_week", ABSENT}, {"tow_s", ABSENT}, {"rx_tow_s", 100});
}

/* INSNavGeod with position deviations, attitude and velocity covariances only: SBList bits 0, 1, 7. */
static void ins_parts_make_one_record(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	block[14] = 4 | 2 << 4;
	fw_store_u16(block + 16, 0x1234);
	fw_store_u16(block + 18, 20);
	put_f8(20, 1);
	put_f8(28, -2);
	put_f8(36, 99.5);
	put_f4(44, 48.5F);
	fw_store_u16(block + 48, 5);
	fw_store_u16(block + 50, 12);
	fw_store_u16(block + 54, 1 << 0 | 1 << 1 | 1 << 7);
	for (unsigned i = 0; i < 9; i++)
		put_f4(56 + 4 * i, (float)i + 0.5F);
	emit_block(4226, 92);
	EXPECT(FW_ins, {"mode", 4}, {"att_mode", 2}, {"info", 0x1234}, {"gnss_age_s", 0.2},
	       {"lat_deg", TO_DEG}, {"lon_deg", -2 * TO_DEG}, {"height_m", 99.5}, {"undulation_m", 48.5},
	       {"accuracy_m", 0.05}, {"latency_s", 0.0012}, {"datum", 0}, {"sd_n_m", 0.5}, {"sd_e_m", 1.5},
	       {"sd_d_m", 2.5}, {"heading_deg", 3.5}, {"pitch_deg", 4.5}, {"roll_deg", 5.5},
	       {"sd_heading_deg", ABSENT}, {"ve_mps", ABSENT}, {"cov_vnve_m2ps2", 6.5},
	       {"cov_vevd_m2ps2", -7.5}, {"cov_vnvd_m2ps2", -8.5});

	fw_store_u16(block + 54, 1 << 3 | 1 << 5);
	emit_block(4230, 80);
	EXPECT(FW_event_ins, {"ve_mps", 0.5}, {"vn_mps", 1.5}, {"vd_mps", -2.5}, {"cov_ne_m2", 3.5},
	       {"cov_nd_m2", -4.5}, {"cov_ed_m2", -5.5}, {"sd_n_m", ABSENT}, {"roll_deg", ABSENT});
	fw_sbf_seal(block, 4230, 0, 76, 0, 0);
	assert_int_equal(emit(block), FW_EFORMAT);
}

static void sensor(unsigned i, uint8_t type, double x, double y, double z)
{
	uint8_t *sub = block + 16 + 28 * i;
	sub[0] = 1, sub[1] = 10, sub[2] = type, sub[3] = 0;
	put_f8(20 + 28 * i, x);
	put_f8(28 + 28 * i, y);
	put_f8(36 + 28 * i, z);
}

/* A sensor mounted with x to the right, y forward and z up, which is (180, 0, 90): at rest it feels +9.8 along z, and
 * that is -9.8 along down. */
static void imu_is_turned_into_the_vehicle(void **state)
{
	(void)state;
	set_up(NULL);
	memset(block, 0, sizeof block);
	block[14] = 2, block[15] = 28;
	sensor(0, 0, 1, 2, 9.8);
	sensor(1, 1, 10, 20, 30);
	emit_block(4050, 72);
	assert_int_equal(list.n, 3);
	assert_int_equal(list.at[0].kind, FW_ext_sensor);
	expect_number(&list, 0, "accel_z_mps2", 9.8, 0);
	expect_number(&list, 0, "gyro_x_radps", ABSENT, 0);
	expect_number(&list, 0, "model", 10, 0);
	assert_int_equal(list.at[1].kind, FW_ext_sensor);
	expect_number(&list, 1, "gyro_y_radps", 20 / TO_DEG, 1e-15);
	expect_number(&list, 1, "accel_x_mps2", ABSENT, 0);
	assert_int_equal(list.at[2].kind, FW_imu);
	expect_number(&list, 2, "accel_x_mps2", 1, 0); /* no IMUSetup seen */

	static uint8_t measurement[128];
	memcpy(measurement, block, sizeof measurement);
	memset(block, 0, sizeof block);
	put_f4(28, 180);
	put_f4(32, 0);
	put_f4(36, 90);
	fw_kind_set none = {{0}};
	fw_sbf_seal(block, 4224, 0, 40, 1, 2);
	list_clear(&list);
	assert_int_equal(fw_sbf_emit(&plans, block, 40, &none, (fw_sink){list_put, &list}), FW_OK);
	assert_int_equal(list.n, 0); /* noted although nobody wants the record */
	memcpy(block, measurement, sizeof measurement);
	emit_block(4050, 72);
	assert_int_equal(list.n, 3);
	expect_number(&list, 0, "accel_x_mps2", 1, 0); /* in the sensor's own axes as ever */
	const double expected[] = {2, 1, -9.8, 20 / TO_DEG, 10 / TO_DEG, -30 / TO_DEG};
	const char *const columns[] = {"accel_x_mps2", "accel_y_mps2", "accel_z_mps2",
	                               "gyro_x_radps", "gyro_y_radps", "gyro_z_radps"};
	for (int i = 0; i < 6; i++)
		expect_number(&list, 2, columns[i], expected[i], 1e-14);
}

/* All three angles at once, (30, 45, 60): Rz Ry Rx (1, 2, 3) worked out with the three matrices in numpy. */
static void mounting_angles_apply_in_order(void **state)
{
	(void)state;
	set_up(NULL);
	memset(block, 0, sizeof block);
	put_f4(28, 30);
	put_f4(32, 45);
	put_f4(36, 60);
	emit_block(4224, 40);
	assert_int_equal(list.at[0].kind, FW_imu_setup);
	memset(block, 0, sizeof block);
	block[14] = 1, block[15] = 28;
	sensor(0, 0, 1, 2, 3);
	emit_block(4050, 44);
	assert_int_equal(list.n, 2);
	expect_number(&list, 1, "accel_x_mps2", 1.4247035404069, 1e-12);
	expect_number(&list, 1, "accel_y_mps2", 2.93176053284576, 1e-12);
	expect_number(&list, 1, "accel_z_mps2", 1.83711730708738, 1e-12);
	expect_number(&list, 1, "gyro_x_radps", ABSENT, 0);
	set_up(NULL);
}

static void other_sensor_measurements(void **state)
{
	(void)state;
	memset(block, 0, sizeof block);
	block[14] = 4, block[15] = 28;
	sensor(0, 3, 0, 0, 0);
	fw_store_u16(block + 20, (uint16_t)-1550);
	sensor(1, 4, 0, 0, 0);
	put_f4(48, 1.5F);
	put_f4(52, -2e10F);
	put_f4(60, 0.25F);
	sensor(2, 20, 1, 0, 0);
	sensor(3, 0, 1, (double)NAN, 3); /* an acceleration without y is none that could be turned */
	emit_block(4050, 128);
	assert_int_equal(list.n, 4);
	expect_number(&list, 0, "temperature_degc", -15.5, 0);
	expect_number(&list, 1, "vx_mps", 1.5, 0);
	expect_number(&list, 1, "vy_mps", ABSENT, 0);
	expect_number(&list, 1, "sd_vx_mps", 0.25, 0);
	expect_number(&list, 2, "zero_velocity", 1, 0);
	expect_number(&list, 3, "accel_x_mps2", 1, 0);
	expect_number(&list, 3, "accel_y_mps2", ABSENT, 0);
}

static void unwanted_kinds_are_not_made(void **state)
{
	(void)state;
	fw_kind_set only_imu = {{0}};
	fw_kind_add(&only_imu, FW_imu);
	memset(block, 0, sizeof block);
	block[14] = 1, block[15] = 28;
	sensor(0, 0, 1, 2, 3);
	fw_sbf_seal(block, 4050, 0, 44, 1, 2);
	list_clear(&list);
	assert_int_equal(fw_sbf_emit(&plans, block, 44, &only_imu, (fw_sink){list_put, &list}), FW_OK);
	assert_int_equal(list.n, 1);
	assert_int_equal(list.at[0].kind, FW_imu);
	size_t length = bytes_from_hex(PVT, block);
	list_clear(&list);
	assert_int_equal(fw_sbf_emit(&plans, block, length, &only_imu, (fw_sink){list_put, &list}), FW_OK);
	assert_int_equal(list.n, 0);
}

/* An absent column holds 0 or "", a present one a finite number or a text. */
static void check_record(void *context, fw_kind kind, const void *record)
{
	size_t *records = context;
	const fw_record_type *type = fw_record_type_of(kind);
	for (int i = 0; i < type->n_columns; i++) {
		bool present = column_present(record, i);
		if (type->columns[i].type == FW_STR) {
			assert_int_equal(present, column_text(type, record, i)[0] != '\0');
		} else {
			double x = column_number(type, record, i);
			assert_true(present ? isfinite(x) : !(x > 0) && !(x < 0));
		}
	}
	(*records)++;
}

/* Noise under every header, in a buffer that ends where the block ends. */
static void noise_does_no_harm(void **state)
{
	(void)state;
	fw_random random;
	fw_random_init(&random, 4226);
	size_t records = 0;
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		for (int k = 0; k < 200; k++) {
			uint16_t length =
			    (uint16_t)(16 + 4 * fw_random_below(&random, k % 10 == 0 ? 2000 : 50));
			uint8_t *bytes = malloc(length);
			for (unsigned at = 0; at < length; at++)
				bytes[at] = (uint8_t)fw_random_u64(&random);
			fw_sbf_seal(bytes, fw_sbf_schemas[i].id, 0, length, (uint32_t)k, 2);
			fw_status status =
			    fw_sbf_emit(&plans, bytes, length, &all, (fw_sink){check_record, &records});
			assert_true(status == FW_OK || status == FW_EUNKNOWN || status == FW_EFORMAT);
			free(bytes);
		}
	}
	assert_true(records > 10000);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(receiver_time),
	    cmocka_unit_test(dop),
	    cmocka_unit_test(pvt_geodetic),
	    cmocka_unit_test(covariances),
	    cmocka_unit_test(blocks_of_an_epoch_merge),
	    cmocka_unit_test(attitude_not_requested),
	    cmocka_unit_test(ionosphere),
	    cmocka_unit_test(clocks_of_systems),
	    cmocka_unit_test(sbas_messages),
	    cmocka_unit_test(pages),
	    cmocka_unit_test(markers_make_no_record),
	    cmocka_unit_test(absent_values),
	    cmocka_unit_test(short_blocks),
	    cmocka_unit_test(rows_take_what_the_block_says_once),
	    cmocka_unit_test(sub_blocks_are_stepped_by_their_length),
	    cmocka_unit_test(contradictions_emit_nothing),
	    cmocka_unit_test(residuals),
	    cmocka_unit_test(satellite_positions),
	    cmocka_unit_test(receiver_status),
	    cmocka_unit_test(texts),
	    cmocka_unit_test(events_carry_their_own_time),
	    cmocka_unit_test(ins_parts_make_one_record),
	    cmocka_unit_test(imu_is_turned_into_the_vehicle),
	    cmocka_unit_test(mounting_angles_apply_in_order),
	    cmocka_unit_test(other_sensor_measurements),
	    cmocka_unit_test(unwanted_kinds_are_not_made),
	    cmocka_unit_test(noise_does_no_harm),
	};
	return cmocka_run_group_tests(tests, set_up, NULL);
}
