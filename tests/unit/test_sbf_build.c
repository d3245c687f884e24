/* Records to SBF blocks. What is written is read back by sbf_records.c, whose own tests stand on known blocks; where
 * the conversion loses nothing, the block itself must come back byte by byte. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../sbf_files.h"
#include "../sbf_record_list.h"
#include "base/random.h"
#include "formats/sbf_build.h"

static fw_sbf_plans plans;
static record_list first, second;
static fw_kind_set all;
static uint8_t block[FW_SBF_MAX_LENGTH], built[FW_SBF_MAX_LENGTH];

static int set_up(void **state)
{
	(void)state;
	memset(&all, 0xFF, sizeof all);
	fw_sbf_plans_init(&plans);
	return 0;
}

static fw_status emit(const uint8_t *bytes, record_list *list)
{
	list_clear(list);
	return fw_sbf_emit(&plans, bytes, fw_load_u16(bytes + 6), &all, (fw_sink){list_put, list});
}

static fw_status build(uint16_t id, const record_list *list, uint16_t *length)
{
	const void *records[LIST_MOST];
	for (size_t i = 0; i < list->n; i++)
		records[i] = &list->at[i].record;
	return fw_sbf_build(&plans, id, fw_sbf_schema_find(id)->revision, records, list->n, built, length);
}

/* A column of the same value. What was absent may come back as 0 where the format has no do-not-use value. Angles go
 * through degrees or radians and back: a few units in the last place. */
static void compare_column(const char *name, const fw_record_type *type, const void *a, const void *b, int i)
{
	const fw_column *column = &type->columns[i];
	if (column->type == FW_STR) {
		if (column_present(a, i) && strcmp(column_text(type, a, i), column_text(type, b, i)) != 0)
			fail_msg("%s.%s: '%s', then '%s'", name, column->name, column_text(type, a, i),
			         column_text(type, b, i));
		return;
	}
	double x = column_number(type, a, i), y = column_number(type, b, i);
	double tolerance = column->type == FW_F32 ? 3e-7 : 1e-15;
	if (column_present(a, i) && !column_present(b, i))
		fail_msg("%s.%s: %.17g is lost", name, column->name, x);
	if (!(fabs(x - y) <= tolerance * fabs(x)))
		fail_msg("%s.%s: %.17g, then %.17g", name, column->name, x, y);
}

/* A satellite that is not GLONASS has no channel, so one from random bytes does not come back. */
static bool is_stray_channel(const fw_record_type *type, const void *record, int i)
{
	int sat = fw_record_column(type, "sat", 3);
	return strcmp(type->columns[i].name, "glonass_channel") == 0 &&
	       column_text(type, record, sat)[0] != 'R';
}

static void compare_lists(const char *name)
{
	assert_int_equal(second.n, first.n);
	for (size_t i = 0; i < first.n; i++) {
		const fw_record_type *type = fw_record_type_of(first.at[i].kind);
		assert_int_equal(second.at[i].kind, first.at[i].kind);
		for (int column = 0; column < type->n_columns; column++)
			if (!is_stray_channel(type, &first.at[i].record, column))
				compare_column(name, type, &first.at[i].record, &second.at[i].record, column);
	}
}

/* Block to records to block to records. Returns whether the block could be built. */
static bool round_trip(const uint8_t *bytes)
{
	uint16_t length;
	uint16_t id = fw_load_u16(bytes + 4) & 0x1FFF;
	if (emit(bytes, &first) != FW_OK || first.n == 0 || first.n > LIST_MOST)
		return false;
	fw_status status = build(id, &first, &length);
	if (status == FW_EUNKNOWN)
		return false;
	assert_int_equal(status, FW_OK);
	assert_int_equal(fw_load_u16(built + 6), length);
	assert_int_equal(fw_crc16(built + 4, length - 4U), fw_load_u16(built + 2));
	assert_int_equal(emit(built, &second), FW_OK);
	compare_lists(fw_sbf_block_name(id));
	return true;
}

typedef struct {
	size_t built, identical;
} counts;

static void check_real_block(const uint8_t *bytes, size_t length, void *context)
{
	counts *c = context;
	if (!round_trip(bytes))
		return;
	c->built++;
	c->identical += fw_load_u16(built + 6) == length && memcmp(built + 8, bytes + 8, length - 8) == 0;
}

static void real_blocks_can_be_built_again(void **state)
{
	(void)state;
	counts c = {0, 0};
	if (sbf_each_real_block(check_real_block, &c) == 0) {
		print_message("no real logs: skipped\n");
		skip();
	}
	assert_true(c.built > 700);
	assert_true(c.identical > c.built / 3);
}

/* A random block of each schema: sub-blocks of the known length, up to four of them, or as many as there must be. */
static uint16_t make_block(fw_random *random, const fw_sbf_schema *schema)
{
	size_t end = schema->size;
	for (size_t at = FW_SBF_BODY; at < 1000; at++)
		block[at] = (uint8_t)fw_random_u64(random);
	for (unsigned g = 0; g < schema->n_groups; g++) {
		const fw_sbf_group *group = &schema->groups[g];
		if (group->count == SBF_COUNT_U1 || group->count == SBF_COUNT_U2)
			block[group->count_offset] = (uint8_t)(1 + fw_random_below(random, 4));
		if (group->count == SBF_COUNT_U2)
			block[group->count_offset + 1] = 0;
		if (group->size_offset > 0)
			block[group->size_offset] = (uint8_t)group->size;
		end += fw_sbf_group_count(group, block, end) * group->size;
	}
	uint16_t length = (uint16_t)((end + 3) / 4 * 4);
	fw_sbf_seal(block, schema->id, 0, length, (uint32_t)fw_random_below(random, 604800000), 2367);
	return length;
}

static void random_records_come_back(void **state)
{
	(void)state;
	fw_random random;
	fw_random_init(&random, 4007);
	int schemas = 0;
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		int times = 0;
		for (int k = 0; k < 300; k++) {
			make_block(&random, &fw_sbf_schemas[i]);
			times += round_trip(block);
		}
		assert_true(times == 0 || times > 250);
		schemas += times > 0;
	}
	/* All but EndOf..., MeasEpoch, MeasExtra, IntPVAAGeod, both PVTResiduals, PVTSatCartesian, ExtSensorMeas,
	 * Comment. */
	assert_int_equal(schemas, fw_sbf_n_schemas - 11);
}

static void a_block_comes_back_byte_by_byte(void **state)
{
	(void)state;
	const char *const hex[] = {
	    "244057f9a10f2000e052c91c3f0925004f0028002c004200f5e77840fc96b540", /* DOP */
	    "2440bd131a171800702fcb1c3f091905170e0b0012070000",                 /* ReceiverTime */
	    "2440adb125171000d0d2c21c3f097900", /* GEOMT00, its padding cleared */
	    "244049c332172c008831ca1c3f09ff8000000000f90295d0f90295d0f90295d0f90295d0f90295d0f90295d0",
	    "24400b7eb40f34009811c11c3f0988010018001ec4ff12c6ff0300000000e8ff0000000000000000adbb03000000807b"
	    "8029"
	    "c50d", /* GEORawL1 */
	    "244091e8b10f3c00501dc11c3f0901010000002f103fc122c46b422741d4f93fe1644709c549050032138605d0818b06"
	    "d1bf"
	    "8030bac8e93f3ccdfc00", /* GPSRawCA */
	};
	for (size_t i = 0; i < sizeof hex / sizeof hex[0]; i++) {
		size_t length = bytes_from_hex(hex[i], block);
		assert_true(round_trip(block));
		assert_int_equal(fw_load_u16(built + 6), length);
		assert_memory_equal(built + 8, block + 8, length - 8);
	}
}

/* A record by hand: furrow_dop is the smallest with scaled and absent values. */
static void numbers_are_rounded_and_kept_in_range(void **state)
{
	(void)state;
	uint16_t length;
	fw_record_clear(FW_dop, &first.at[0].record);
	first.n = 1;
	first.at[0].kind = FW_dop;
	const fw_record_type *type = fw_record_type_of(FW_dop);
	const struct {
		const char *column;
		double value;
		uint16_t raw;
	} cases[] = {
	    {"pdop", 1.234999, 123},
	    {"pdop", 1.235001, 124},
	    {"pdop", 1e9, 65535},
	    {"pdop", -3, 1},
	    {"pdop", 0, 1} /* 0 would mean "not available" */,
	};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		int column = column_index(type, cases[i].column);
		fw_record_head head = {(int64_t)1 << column | 3, 2367, 604799.9996};
		memcpy(&first.at[0].record, &head, sizeof head);
		memcpy(first.at[0].record.bytes + type->columns[column].offset, &cases[i].value,
		       sizeof(double));
		assert_int_equal(build(4001, &first, &length), FW_OK);
		assert_int_equal(length, 32);
		assert_int_equal(fw_load_u16(built + 16), cases[i].raw);
		assert_int_equal(built[14], 255);                      /* NrSV: do-not-use */
		assert_int_equal(fw_load_u16(built + 18), 0);          /* TDOP: 0 is do-not-use */
		assert_int_equal(fw_load_u32(built + 24), 0xD09502F9); /* HPL: -2e10 */
	}
}

static void refusals(void **state)
{
	(void)state;
	uint16_t length = 7;
	const void *record[300];
	static fw_any_record any;
	fw_record_clear(FW_base, &any);
	for (int i = 0; i < 300; i++)
		record[i] = &any;
	assert_int_equal(fw_sbf_build(&plans, 4027, 0, record, 1, built, &length), FW_EUNKNOWN);
	assert_int_equal(fw_sbf_build(&plans, 4050, 0, record, 1, built, &length), FW_EUNKNOWN);
	assert_int_equal(fw_sbf_build(&plans, 4013, 0, record, 1, built, &length), FW_EUNKNOWN);
	assert_int_equal(fw_sbf_build(&plans, 4028, 0, record, 0, built, &length), FW_EINVAL);
	assert_int_equal(fw_sbf_build(&plans, 4028, 8, record, 1, built, &length), FW_EINVAL);
	assert_int_equal(length, 7);
	/* Records without a vector make a block without one. */
	assert_int_equal(fw_sbf_build(&plans, 4028, 0, record, 300, built, &length), FW_OK);
	assert_int_equal(length, 16);
	any.head.present |= (int64_t)1 << column_index(fw_record_type_of(FW_base), "east_m");
	assert_int_equal(fw_sbf_build(&plans, 4028, 0, record, 255, built, &length), FW_OK);
	assert_int_equal(length, 16 + 255 * 52);
	assert_int_equal(fw_sbf_build(&plans, 4028, 0, record, 256, built, &length), FW_ENOSPACE);
	fw_record_clear(FW_sbas_integrity, &any);
	assert_int_equal(fw_sbf_build(&plans, 5928, 0, record, 50, built, &length), FW_EINVAL);
	assert_int_equal(fw_sbf_build(&plans, 5928, 0, record, 51, built, &length), FW_OK);
}

/* The stamp of an event's block is not the event's: also where a week ends between them. */
static void events_keep_their_stamp(void **state)
{
	(void)state;
	const struct {
		uint32_t tow_ms;
		float offset;
		double bias;
	} cases[] = {{100000, 0.5F, 0.125}, {604799750, 0.5F, 0.125}, {0, 0.125F, 0.5}};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		uint32_t bits;
		uint64_t wide;
		memcpy(&bits, &cases[i].offset, sizeof bits);
		memcpy(&wide, &cases[i].bias, sizeof wide);
		memset(block, 0, 32);
		fw_store_u32(block + 16, bits);
		fw_store_u64(block + 20, wide);
		fw_sbf_seal(block, 5924, 1, 32, cases[i].tow_ms, 2367);
		assert_true(round_trip(block));
		assert_memory_equal(built, block, 32);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(real_blocks_can_be_built_again),
	    cmocka_unit_test(random_records_come_back),
	    cmocka_unit_test(a_block_comes_back_byte_by_byte),
	    cmocka_unit_test(numbers_are_rounded_and_kept_in_range),
	    cmocka_unit_test(refusals),
	    cmocka_unit_test(events_keep_their_stamp),
	};
	return cmocka_run_group_tests(tests, set_up, NULL);
}
