/* What only the sequence of blocks can say: epochs, records put together from several blocks, choices of the user. The
 * blocks are made byte by byte; their layouts are tested in test_sbf_records.c and test_sbf_measurements.c. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../sbf_record_list.h"
#include "formats/bytes.h"
#include "formats/sbf_codec.h"
#include "formats/sbf_decoder.h"

#define ABSENT ((double)NAN)

enum { WEEK = 2360, PVT_GEODETIC = 4007, POS_COV = 5906, VEL_COV = 5908, DOP = 4001, END_OF_PVT = 5921 };

static fw_sbf_decoder decoder;
static record_list list;
static uint8_t block[2048];

static void start(unsigned antennas, unsigned nav_sources, const char *only)
{
	fw_sbf_decoder_options o = {.antennas = antennas, .nav_sources = nav_sources};
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++)
		if (only == NULL || strcmp(fw_record_type_of(kind)->name, only) == 0)
			fw_kind_add(&o.wanted, kind);
	list_clear(&list);
	fw_sbf_decoder_init(&decoder, &o, (fw_sink){list_put, &list});
}

static void start_all(void)
{
	start(FW_ANTENNA_MAIN, FW_NAV_DECODED | FW_NAV_RAW, NULL);
}

/* Seals what is in block[14..length) and hands it over. */
static void give(uint16_t id, uint16_t length, uint32_t tow_ms)
{
	const fw_sbf_schema *schema = fw_sbf_schema_find(id);
	fw_sbf_seal(block, id, schema != NULL ? schema->revision : 0, length, tow_ms, WEEK);
	const fw_sbf_block b = {.data = block,
	                        .length = length,
	                        .id = id,
	                        .revision = block[5] >> 5,
	                        .week = WEEK,
	                        .tow_ms = tow_ms};
	fw_sbf_decoder_put(&decoder, &b);
}

static void store_f32(size_t at, float x)
{
	uint32_t bits;
	memcpy(&bits, &x, sizeof bits);
	fw_store_u32(block + at, bits);
}

static void store_f64(size_t at, double x)
{
	uint64_t bits;
	memcpy(&bits, &x, sizeof bits);
	fw_store_u64(block + at, bits);
}

static void give_pvt(uint32_t tow_ms, double height_m)
{
	memset(block, 0, sizeof block);
	block[14] = 1;
	store_f64(32, height_m);
	give(PVT_GEODETIC, 96, tow_ms);
}

static void give_cov(uint16_t id, uint32_t tow_ms, float first)
{
	memset(block, 0, sizeof block);
	store_f32(16, first);
	give(id, 56, tow_ms);
}

static void give_dop(uint32_t tow_ms)
{
	memset(block, 0, sizeof block);
	give(DOP, 32, tow_ms);
}

static void an_epoch_makes_one_pvt(void **state)
{
	(void)state;
	start_all();
	give_pvt(1000, 10);
	give_cov(POS_COV, 1000, 4);
	give_cov(VEL_COV, 1000, 9);
	assert_int_equal(list.n, 0); /* it may go on */
	give_pvt(2000, 20);
	assert_int_equal(list.n, 1);
	expect_number(&list, 0, "height_m", 10, 0);
	expect_number(&list, 0, "cov_nn_m2", 4, 0);
	expect_number(&list, 0, "sd_n_m", 2, 1e-15);
	expect_number(&list, 0, "cov_vnvn_m2ps2", 9, 0);
	fw_sbf_decoder_flush(&decoder);
	assert_int_equal(list.n, 2);
	expect_number(&list, 1, "height_m", 20, 0);
	expect_number(&list, 1, "cov_nn_m2", ABSENT, 0);
	expect_number(&list, 1, "sd_n_m", ABSENT, 0);
	fw_sbf_decoder_flush(&decoder);
	assert_int_equal(list.n, 2);
}

static void any_block_of_the_receivers_time_closes_an_epoch(void **state)
{
	(void)state;
	start_all();
	give_pvt(1000, 10);
	give_dop(1000);
	assert_int_equal(list.n, 1); /* the DOP */
	give_dop(2000);
	assert_int_equal(list.n, 3);
	assert_int_equal(list.at[1].kind, FW_pvt);
	assert_int_equal(list.at[2].kind, FW_dop);
	/* Covariances that come late are an epoch of their own, not the next one's. */
	give_cov(POS_COV, 1000, 4);
	give_pvt(2000, 20);
	fw_sbf_decoder_flush(&decoder);
	assert_int_equal(list.n, 5);
	expect_number(&list, 3, "height_m", ABSENT, 0);
	expect_number(&list, 4, "cov_nn_m2", ABSENT, 0);
}

static void events_and_pages_do_not_close_an_epoch(void **state)
{
	(void)state;
	start_all();
	give_pvt(1000, 10);
	memset(block, 0, sizeof block);
	give(5924, 32, 900); /* ExtEvent */
	memset(block, 0, sizeof block);
	block[14] = 71;
	give(4023, 52, 600); /* GALRawINAV */
	give_cov(POS_COV, 1000, 4);
	fw_sbf_decoder_flush(&decoder);
	assert_int_equal(list.n, 3);
	assert_int_equal(list.at[2].kind, FW_pvt);
	expect_number(&list, 2, "cov_nn_m2", 4, 0);
}

static void end_markers_close_earlier(void **state)
{
	(void)state;
	start_all();
	give_pvt(1000, 10);
	memset(block, 0, sizeof block);
	give(END_OF_PVT, 16, 1000);
	assert_int_equal(list.n, 1);
}

/* Without time stamps, as while a receiver starts, no two blocks are of one epoch. */
static void a_second_block_of_a_kind_is_a_second_record(void **state)
{
	(void)state;
	start_all();
	give_pvt(UINT32_MAX, 10);
	give_pvt(UINT32_MAX, 11);
	fw_sbf_decoder_flush(&decoder);
	assert_int_equal(list.n, 2);
	expect_number(&list, 0, "height_m", 10, 0);
	expect_number(&list, 1, "height_m", 11, 0);
	expect_number(&list, 1, "tow_s", ABSENT, 0);
}

static void give_sensor(uint32_t tow_ms, uint8_t type, double x)
{
	memset(block, 0, sizeof block);
	block[14] = 1;
	block[15] = 28;
	block[18] = type;
	store_f64(20, x);
	give(4050, 44, tow_ms);
}

static void rates_and_accelerations_meet(void **state)
{
	(void)state;
	start(FW_ANTENNA_MAIN, FW_NAV_DECODED, "imu");
	give_sensor(1000, 0, 9.8);
	give_sensor(1000, 1, 180);
	assert_int_equal(list.n, 1);
	expect_number(&list, 0, "accel_x_mps2", 9.8, 0);
	expect_number(&list, 0, "gyro_x_radps", 3.14159265358979, 1e-14);
	give_sensor(1020, 0, 1); /* alone */
	give_sensor(1040, 0, 2);
	give_sensor(1040, 1, 90);
	fw_sbf_decoder_flush(&decoder);
	assert_int_equal(list.n, 3);
	expect_number(&list, 1, "accel_x_mps2", 1, 0);
	expect_number(&list, 1, "gyro_x_radps", ABSENT, 0);
	expect_number(&list, 2, "accel_x_mps2", 2, 0);
}

/* GEONetworkTime as the receiver decoded it; MT 12 is the same from a raw message. */
static void navigation_is_chosen_by_its_source(void **state)
{
	(void)state;
	for (unsigned sources = 1; sources <= 3; sources++) {
		start(FW_ANTENNA_MAIN, sources, "sbas_time");
		memset(block, 0, sizeof block);
		block[14] = 123;
		give(5918, 48, 1000);
		assert_int_equal(list.n, sources & FW_NAV_DECODED ? 1 : 0);
		if (list.n > 0)
			assert_string_equal(list_text(&list, 0, "source"), "decoded");
	}
}

static void give_measurements(uint32_t tow_ms, uint8_t common_flags, uint8_t svid)
{
	memset(block, 0, sizeof block);
	block[14] = 1;
	block[15] = 20;
	block[16] = 12;
	block[17] = common_flags;
	block[20 + 2] = svid;
	fw_store_u32(block + 24, 22000000);
	give(4027, 40, tow_ms);
}

static void what_is_left_out_is_counted(void **state)
{
	(void)state;
	start_all();
	give_measurements(1000, 0, 5);
	assert_int_equal(list.n, 2);      /* obs and epoch */
	give_measurements(2000, 0x80, 5); /* scrambled */
	assert_int_equal(list.n, 3);
	assert_int_equal(list.at[2].kind, FW_epoch);
	assert_int_equal(decoder.stats.scrambled, 1);
	give_measurements(3000, 0, 62); /* GLONASS of unknown slot */
	assert_int_equal(list.n, 4);
	assert_int_equal(decoder.stats.left_out.unnamed, 1);
	give(4013, 16, 4000); /* ChannelStatus: no layout */
	assert_int_equal(decoder.stats.unknown, 1);
	memset(block, 0, sizeof block);
	block[14] = 255, block[15] = 52;
	give(4028, 16, 4000); /* 255 base vectors in a block without room for one */
	assert_int_equal(decoder.stats.malformed, 1);
	assert_int_equal(list.n, 4);
}

static void what_a_log_offers(void **state)
{
	(void)state;
	fw_kind_set offered = {{0}}, expected = {{0}};
	start(FW_ANTENNA_MAIN, FW_NAV_DECODED, "att");
	give_measurements(1000, 0, 5);
	give_dop(1000);
	fw_sbf_decoder_offered(&decoder, &offered);
	fw_kind_add(&expected, FW_obs);
	fw_kind_add(&expected, FW_epoch);
	fw_kind_add(&expected, FW_dop);
	assert_memory_equal(&offered, &expected, sizeof offered);
	assert_int_equal(list.n, 0);
	assert_string_equal(fw_sbf_decoder_records(4001), "dop");
	assert_string_equal(fw_sbf_decoder_records(4013), "");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(an_epoch_makes_one_pvt),
	    cmocka_unit_test(any_block_of_the_receivers_time_closes_an_epoch),
	    cmocka_unit_test(events_and_pages_do_not_close_an_epoch),
	    cmocka_unit_test(end_markers_close_earlier),
	    cmocka_unit_test(a_second_block_of_a_kind_is_a_second_record),
	    cmocka_unit_test(rates_and_accelerations_meet),
	    cmocka_unit_test(navigation_is_chosen_by_its_source),
	    cmocka_unit_test(what_is_left_out_is_counted),
	    cmocka_unit_test(what_a_log_offers),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
