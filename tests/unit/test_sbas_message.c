/* SBAS messages. Independent sources: the receiver's own decoding of the same messages (Septentrio blocks in
 * the real logs), numbers that a decoder in Python gave, written from the message layouts of DO-229 apart
 * from this code, and the places and spare bits of each message by the same layouts. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <glob.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/random.h"
#include "formats/bytes.h"
#include "formats/crc.h"
#include "formats/nav_bits.h"
#include "formats/sbas_message.h"
#include "formats/sbf_signal.h"
#include "furrow_eph_sbas.h"
#include "furrow_sbas_almanac.h"
#include "furrow_sbas_cov.h"
#include "furrow_sbas_degradation.h"
#include "furrow_sbas_factors.h"
#include "furrow_sbas_fast.h"
#include "furrow_sbas_igp_mask.h"
#include "furrow_sbas_integrity.h"
#include "furrow_sbas_iono.h"
#include "furrow_sbas_long.h"
#include "furrow_sbas_mask.h"
#include "furrow_sbas_mt0.h"
#include "furrow_sbas_service.h"
#include "furrow_sbas_time.h"

enum { MAX_ROWS = 256, RANDOM_MESSAGES = 10000 };

static const unsigned known_types[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 10, 12, 17, 18, 24, 25, 26, 27, 28};
enum { N_KNOWN = sizeof known_types / sizeof known_types[0] };

static char raw[] = "raw";

/* ---- records in memory ---- */

typedef struct {
	unsigned n;
	fw_kind kind[MAX_ROWS];
	fw_any_record record[MAX_ROWS];
} rows;

static void keep(void *context, fw_kind kind, const void *record)
{
	rows *r = context;
	assert_true(r->n < MAX_ROWS);
	r->kind[r->n] = kind;
	memcpy(&r->record[r->n++], record, fw_record_type_of(kind)->size);
}

static const fw_record_head *stamp_at(int32_t week, double tow_s)
{
	static fw_record_head head;
	head = (fw_record_head){.present = 3, .gps_week = week, .tow_s = tow_s};
	return &head;
}

static fw_status decode(const uint8_t *message, const char *satellite, const fw_record_head *stamp, rows *r)
{
	r->n = 0;
	return fw_sbas_decode(message, satellite, stamp, (fw_sink){keep, r});
}

static double number(const void *record, const fw_column *c)
{
	const char *p = (const char *)record + c->offset;
	switch (c->type) {
	case FW_I8: return *(const int8_t *)(const void *)p;
	case FW_I16: return *(const int16_t *)(const void *)p;
	case FW_I32: return *(const int32_t *)(const void *)p;
	case FW_I64: return (double)*(const int64_t *)(const void *)p;
	case FW_F32: return (double)*(const float *)(const void *)p;
	default: return *(const double *)(const void *)p;
	}
}

static const char *string(const void *record, const fw_column *c)
{
	return *(char *const *)(const void *)((const char *)record + c->offset);
}

static const fw_column *column(fw_kind kind, const char *name)
{
	int i = fw_record_column(fw_record_type_of(kind), name, strlen(name));
	assert_true(i >= 0);
	return &fw_record_type_of(kind)->columns[i];
}

static bool equal(fw_kind kind, const void *a, const void *b)
{
	const fw_record_type *type = fw_record_type_of(kind);
	if (((const fw_record_head *)a)->present != ((const fw_record_head *)b)->present)
		return false;
	for (unsigned i = 0; i < type->n_columns; i++) {
		const fw_column *c = &type->columns[i];
		if (c->type == FW_STR ? strcmp(string(a, c), string(b, c)) != 0
		                      : number(a, c) != number(b, c)) {
			fprintf(stderr, "%s.%s differs\n", type->name, c->name);
			return false;
		}
	}
	return true;
}

static void assert_same(const rows *a, const rows *b)
{
	assert_int_equal(a->n, b->n);
	for (unsigned i = 0; i < a->n; i++) {
		assert_int_equal(a->kind[i], b->kind[i]);
		assert_true(equal(a->kind[i], &a->record[i], &b->record[i]));
	}
}

static void from_hex(const char *hex, uint8_t message[static FW_SBAS_BYTES])
{
	memset(message, 0, FW_SBAS_BYTES);
	for (unsigned i = 0; i < FW_SBAS_BYTES && hex[0] > ' ' && hex[1] > ' '; i++, hex += 2) {
		const char byte[3] = {hex[0], hex[1], 0};
		message[i] = (uint8_t)strtoul(byte, NULL, 16);
	}
}

static unsigned bits(const uint8_t *message, unsigned start, unsigned width)
{
	return fw_bits_unsigned(message, FW_SBAS_BYTES, start, width);
}

static void set_bits(uint8_t *message, unsigned start, unsigned width, unsigned number_to_set)
{
	size_t end = start;
	fw_bits_clear(message, FW_SBAS_BYTES, start, width);
	fw_bits_append(message, FW_SBAS_BYTES, &end, number_to_set, width);
}

/* Makes a message of records and decodes it again. */
static void encode(unsigned type, const rows *r, uint8_t message[static FW_SBAS_BYTES])
{
	assert_int_equal(fw_sbas_begin(type, 0, message), FW_OK);
	for (unsigned i = 0; i < r->n; i++)
		assert_int_equal(fw_sbas_add(r->kind[i], &r->record[i], message), FW_OK);
	fw_sbas_finish(message);
}

/* ---- known messages ---- */

/* From a mosaic-X5 log, PRN 136; the values were worked out by hand from the bits. */
static void test_fast_corrections(void **state)
{
	(void)state;
	static const double prc[13] = {-1.875, 0, 0, -0.125, -0.75};
	static const int udrei[13] = {14, 14, 14, 11, 5, 14, 14};
	uint8_t message[FW_SBAS_BYTES];
	static rows r;

	from_hex("c612ffc4000003ffffe8000000000000000000000003bbad7b8000000dc52980", message);
	assert_int_equal(decode(message, "S136", stamp_at(2367, 482415), &r), FW_OK);
	assert_int_equal(r.n, 13);
	for (unsigned i = 0; i < 13; i++) {
		furrow_sbas_fast expected = {.present = 0x3ff,
		                             .gps_week = 2367,
		                             .tow_s = 482415,
		                             .source = raw,
		                             .type = 4,
		                             .iodp = 3,
		                             .iodf = 2,
		                             .mask_no = (int16_t)(27 + i),
		                             .udrei = (int16_t)udrei[i],
		                             .prc_m = prc[i]};
		char sat[] = "S136";
		expected.sat = sat;
		assert_int_equal(r.kind[i], FW_sbas_fast);
		assert_true(equal(FW_sbas_fast, &expected, &r.record[i]));
	}
}

static void test_absent_columns(void **state)
{
	(void)state;
	const fw_record_head nothing = {0};
	uint8_t message[FW_SBAS_BYTES];
	static rows r;

	/* No stamp, no sender: these three columns are absent, the others are there. */
	assert_int_equal(fw_sbas_begin(10, 0, message), FW_OK);
	fw_sbas_finish(message);
	assert_int_equal(decode(message, NULL, &nothing, &r), FW_OK);
	assert_int_equal(r.n, 1);
	assert_int_equal(r.record[0].head.present, 0xffff8);
	assert_string_equal(((furrow_sbas_factors *)&r.record[0])->sat, "");

	/* Number 62 of the satellite mask has no name; 158 is the last SBAS satellite. No stamp, no almanac
	 * day. */
	assert_int_equal(fw_sbas_begin(1, 0, message), FW_OK);
	set_bits(message, 14 + 61, 1, 1);
	set_bits(message, 14 + 157, 1, 1);
	fw_sbas_finish(message);
	assert_int_equal(decode(message, "S123", stamp_at(2367, 0), &r), FW_OK);
	assert_int_equal(r.n, 2);
	assert_int_equal(r.record[0].head.present, 0x3f);
	assert_string_equal(((furrow_sbas_mask *)&r.record[0])->mask_sat, "");
	assert_string_equal(((furrow_sbas_mask *)&r.record[1])->mask_sat, "S158");
	assert_int_equal(((furrow_sbas_mask *)&r.record[1])->mask_no, 2);

	assert_int_equal(fw_sbas_begin(17, 0, message), FW_OK);
	set_bits(message, 16, 8, 123);
	fw_sbas_finish(message);
	assert_int_equal(decode(message, NULL, &nothing, &r), FW_OK);
	assert_int_equal(r.n, 1);
	assert_int_equal(r.record[0].head.present, 0x1fbc); /* `sat` is the almanac's, so it is there */
	assert_string_equal(((furrow_sbas_almanac *)&r.record[0])->sat, "S123");
}

/* Bits put where the message layouts of DO-229 have them, and what they mean in which record. Real messages,
 * below, say nothing, or always the same, in many of these. The lines of a type make one message. */
static void test_places(void **state)
{
	(void)state;
	static const struct {
		unsigned type, start, width, raw, record;
		const char *column;
		double value;
	} cases[] = {
	    {0, 174, 4, 9, 1, "udrei", 9}, /* record 0 is sbas_mt0 */
	    {5, 150, 12, 0x801, 11, "prc_m", -255.875},
	    {5, 218, 4, 13, 11, "udrei", 13},
	    {5, 14, 2, 1, 0, "iodf", 1},
	    {5, 16, 2, 2, 0, "iodp", 2},
	    {6, 14, 2, 1, 0, "iodf2", 1},
	    {6, 16, 2, 2, 0, "iodf3", 2},
	    {6, 18, 2, 3, 0, "iodf4", 3},
	    {6, 20, 2, 1, 50, "iodf5", 1},
	    {6, 22, 4, 7, 0, "udrei", 7},
	    {6, 222, 4, 15, 50, "udrei", 15},
	    {7, 14, 4, 3, 50, "latency_s", 3},
	    {7, 18, 2, 2, 50, "iodp", 2},
	    {7, 222, 4, 11, 50, "ai", 11},
	    {9, 206, 12, 0xfff, 0, "agf0_s", -0x1p-31},
	    {9, 218, 8, 0x81, 0, "agf1_sps", -127 * 0x1p-40},
	    {10, 126, 10, 1000, 0, "ciono_ramp_mps", 1000 * 0.000005},
	    {10, 136, 1, 1, 0, "rss_udre", 1},
	    {10, 137, 1, 0, 0, "rss_iono", 0},
	    {10, 138, 7, 99, 0, "ccovariance", 99 * 0.1},
	    {12, 14, 24, 0x800001, 0, "a1_sps", -8388607 * 0x1p-50},
	    {12, 38, 32, 0x80000000, 0, "a0_s", -2},
	    {12, 70, 8, 118, 0, "tot_s", 483328},
	    {12, 78, 8, 63, 0, "wnt", 63},
	    {12, 86, 8, 18, 0, "leap_s", 18},
	    {12, 94, 8, 137, 0, "wnlsf", 137},
	    {12, 102, 8, 7, 0, "dn", 7},
	    {12, 110, 8, 0xff, 0, "leap_future_s", -1},
	    {12, 118, 3, 3, 0, "utc_std", 3},
	    {12, 121, 20, 482527, 0, "gps_tow_s", 482527},
	    {12, 141, 10, 319, 0, "gps_wn", 319},
	    {12, 151, 1, 1, 0, "glonass_id", 1},
	    {17, 148, 2, 2, 0, "data_id", 2},
	    {17, 150, 8, 136, 0, NULL, 0},
	    {17, 205, 3, 5, 0, "vx_mps", -30},
	    {17, 208, 3, 3, 0, "vy_mps", 30},
	    {17, 211, 4, 9, 0, "vz_mps", -420},
	    {24, 74, 12, 5, 5, "prc_m", 0.625},
	    {24, 106, 4, 6, 5, "udrei", 6},
	    {24, 110, 2, 1, 5, "iodp", 1},
	    {24, 112, 2, 2, 5, "mask_no", 32}, /* block 2: 27..32 */
	    {24, 114, 2, 3, 5, "iodf", 3},
	    {24, 121, 6, 30, 6, "mask_no", 30},
	    {24, 127, 8, 200, 6, "iode", 200},
	    {24, 135, 9, 0x1ff, 6, "dx_m", -0.125},
	    {24, 223, 2, 1, 6, "iodp", 1},
	    {25, 120, 1, 1, 0, "velocity_code", 1},
	    {25, 121, 6, 51, 0, "mask_no", 51},
	    {25, 146, 11, 0x400, 0, "dy_m", -128},
	    {25, 187, 8, 0x80, 0, "vy_mps", -0.0625},
	    {25, 203, 8, 2, 0, "daf1_sps", 0x1p-38},
	    {25, 211, 13, 5399, 0, "toe_s", 86384},
	    {25, 224, 2, 3, 0, "iodp", 3},
	    {26, 14, 4, 10, 0, "band", 10},
	    {26, 18, 4, 13, 5, "mask_no", 201},
	    {26, 87, 9, 511, 5, "delay_m", 63.875},
	    {26, 96, 4, 15, 5, "givei", 15},
	    {26, 217, 2, 2, 5, "iodi", 2},
	    {27, 14, 3, 5, 0, "iods", 5},
	    {27, 17, 3, 7, 0, "messages", 8},
	    {27, 20, 3, 1, 0, "message_no", 2},
	    {27, 23, 3, 2, 1, "shape", 0},
	    {27, 26, 2, 3, 1, "priority", 3},
	    {27, 28, 4, 4, 1, "dudre_in", 4},
	    {27, 32, 4, 11, 1, "dudre_out", 11},
	    {27, 71, 8, 0xa6, 1, "lat1_deg", -90},
	    {27, 79, 9, 180, 1, "lon1_deg", 180},
	    {27, 88, 8, 90, 1, "lat2_deg", 90},
	    {27, 96, 9, 0x14c, 1, "lon2_deg", -180},
	};
	enum { N = sizeof cases / sizeof cases[0] };
	static rows r;

	for (unsigned first = 0, end; first < N; first = end) {
		uint8_t message[FW_SBAS_BYTES];
		assert_int_equal(fw_sbas_begin(cases[first].type, 0, message), FW_OK);
		for (end = first; end < N && cases[end].type == cases[first].type; end++)
			set_bits(message, cases[end].start, cases[end].width, cases[end].raw);
		fw_sbas_finish(message);
		assert_int_equal(decode(message, "S123", stamp_at(2367, 0), &r), FW_OK);
		for (unsigned i = first; i < end; i++) {
			unsigned k = cases[i].record;
			assert_true(k < r.n);
			if (cases[i].column != NULL &&
			    number(&r.record[k], column(r.kind[k], cases[i].column)) != cases[i].value)
				fail_msg("type %u: %s", cases[i].type, cases[i].column);
		}
	}
}

/* The almanac's time of day belongs to the day that brings it nearest, also over midnight and over the week.
 * */
static void test_almanac_day(void **state)
{
	(void)state;
	static const struct {
		int32_t week;
		double tow_s;
		unsigned t0;
		int64_t toa_s;
	} cases[] = {
	    {2367, 482547, 790, 1432044160}, /* the receiver's, by its own decoded block */
	    {2367, 100.5, 1349, 2366 * 604800LL + 604736},
	    {2366, 604700, 1, 2367 * 604800LL + 64},
	    {2367, 86400, 0, 2367 * 604800LL + 86400},
	};
	uint8_t message[FW_SBAS_BYTES];
	static rows r;

	for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		assert_int_equal(fw_sbas_begin(17, 0, message), FW_OK);
		set_bits(message, 16, 8, 121);
		set_bits(message, 215, 11, cases[i].t0);
		fw_sbas_finish(message);
		assert_int_equal(decode(message, "S136", stamp_at(cases[i].week, cases[i].tow_s), &r), FW_OK);
		assert_int_equal(((furrow_sbas_almanac *)&r.record[0])->toa_s, cases[i].toa_s);
	}
}

static void test_refused(void **state)
{
	(void)state;
	uint8_t message[FW_SBAS_BYTES];
	static rows r;

	for (unsigned type = 0, k = 0; type < 64; type++) {
		bool known = k < N_KNOWN && known_types[k] == type;
		k += known;
		assert_int_equal(fw_sbas_begin(type, 1, message), FW_OK);
		fw_sbas_finish(message);
		assert_int_equal(decode(message, "S123", stamp_at(2367, 0), &r),
		                 known || type >= 62 ? FW_OK : FW_EUNKNOWN);
		assert_true(known || r.n == 0);
	}
	assert_int_equal(fw_sbas_begin(64, 0, message), FW_EINVAL);

	from_hex("c612ffc4000003ffffe8000000000000000000000003bbad7b8000000dc52980", message);
	for (unsigned bit = 0; bit < FW_SBAS_BITS; bit++) { /* any single error is found */
		message[bit / 8] ^= (uint8_t)(0x80 >> bit % 8);
		assert_int_equal(decode(message, "S136", stamp_at(2367, 0), &r),
		                 bit < 8 ? FW_EFORMAT : FW_ECHECKSUM);
		assert_int_equal(r.n, 0);
		message[bit / 8] ^= (uint8_t)(0x80 >> bit % 8);
	}
	message[31] |= 0x3f; /* these six bits are not the message's */
	assert_int_equal(decode(message, "S136", stamp_at(2367, 0), &r), FW_OK);
}

static void assert_refused(fw_kind kind, const void *record, uint8_t *message, fw_status status)
{
	uint8_t before[FW_SBAS_BYTES];
	memcpy(before, message, sizeof before);
	assert_int_equal(fw_sbas_add(kind, record, message), status);
	assert_memory_equal(before, message, sizeof before);
}

static void test_add_refuses(void **state)
{
	(void)state;
	uint8_t message[FW_SBAS_BYTES];
	furrow_sbas_fast fast = {.type = 3, .mask_no = 14, .udrei = 14};
	furrow_sbas_long without_rates = {.mask_no = 7, .iodp = 1},
	                 with_rates = {.velocity_code = 1, .mask_no = 8};
	char gps[] = "G05", unnamed[] = "E05";
	furrow_sbas_mask mask = {.mask_sat = gps};

	assert_int_equal(fw_sbas_begin(3, 0, message), FW_OK);
	assert_int_equal(fw_sbas_add(FW_sbas_fast, &fast, message), FW_OK);
	assert_refused(FW_sbas_mask, &mask, message, FW_EINVAL);
	fast.mask_no = 13;
	assert_refused(FW_sbas_fast, &fast, message, FW_EINVAL);
	fast.mask_no = 27;
	assert_refused(FW_sbas_fast, &fast, message, FW_EINVAL);
	fast = (furrow_sbas_fast){.type = 4, .mask_no = 14};
	assert_refused(FW_sbas_fast, &fast, message, FW_EINVAL);
	fast = (furrow_sbas_fast){.type = 3, .mask_no = 14, .udrei = 16};
	assert_refused(FW_sbas_fast, &fast, message, FW_ERANGE);
	fast = (furrow_sbas_fast){.type = 3, .mask_no = 14, .prc_m = 256};
	assert_refused(FW_sbas_fast, &fast, message, FW_ERANGE);
	fast.prc_m = (double)NAN;
	assert_refused(FW_sbas_fast, &fast, message, FW_ERANGE);
	fast.prc_m = -256.06; /* rounds to the lowest that there is */
	assert_int_equal(fw_sbas_add(FW_sbas_fast, &fast, message), FW_OK);
	assert_int_equal(bits(message, 18, 12), 0x800);

	assert_int_equal(fw_sbas_begin(1, 0, message), FW_OK);
	assert_int_equal(fw_sbas_add(FW_sbas_mask, &mask, message), FW_OK);
	assert_int_equal(bits(message, 14, 32), 0x08000000);
	mask.mask_sat = unnamed;
	assert_refused(FW_sbas_mask, &mask, message, FW_EINVAL);
	mask.mask_sat = NULL;
	assert_refused(FW_sbas_mask, &mask, message, FW_EINVAL);

	/* Half messages: two satellites without rates that share the issue of data, or one with rates. */
	assert_int_equal(fw_sbas_begin(25, 0, message), FW_OK);
	assert_int_equal(fw_sbas_add(FW_sbas_long, &without_rates, message), FW_OK);
	without_rates.iodp = 2;
	assert_int_equal(fw_sbas_add(FW_sbas_long, &without_rates, message), FW_OK);
	assert_int_equal(bits(message, 14 + 52, 6), 0);
	assert_int_equal(bits(message, 120 + 1, 6), 7);
	assert_refused(FW_sbas_long, &with_rates, message, FW_ENOSPACE);
	without_rates.mask_no = 0;
	assert_refused(FW_sbas_long, &without_rates, message, FW_EINVAL);
}

static void test_preamble_follows_time(void **state)
{
	(void)state;
	uint8_t message[FW_SBAS_BYTES];

	/* A stamp of 212541 s was seen with 0xC6, one of 212542 s with 0x53; messages start a second before.
	 * */
	assert_int_equal(fw_sbas_begin(63, 212540, message), FW_OK);
	assert_int_equal(message[0], 0xc6);
	assert_int_equal(fw_sbas_begin(63, 212541, message), FW_OK);
	assert_int_equal(message[0], 0x53);
	assert_int_equal(fw_sbas_begin(63, 212542, message), FW_OK);
	assert_int_equal(message[0], 0x9a);
}

/* ---- random messages ---- */

static void randomise(fw_random *random, unsigned type, uint8_t message[static FW_SBAS_BYTES])
{
	for (unsigned i = 0; i < FW_SBAS_BYTES; i++)
		message[i] = (uint8_t)fw_random_u64(random);
	message[0] = 0x53;
	set_bits(message, 8, 6, type);
}

/* Bits that say nothing, by the message layouts, are cleared. */
static void clear_spare(uint8_t *message)
{
	static const struct {
		unsigned type, start, end;
	} spare[] = {
	    {1, 14 + 61, 14 + 119}, {1, 14 + 158, 14 + 210}, /* numbers that no satellite has */
	    {5, 18 + 12 * 12, 174}, {5, 174 + 12 * 4, 226},  {7, 20, 22},
	    {10, 145, 226},         {12, 152, 226},          {18, 225, 226},
	    {24, 116, 120},         {26, 219, 226},          {27, 36 + 5 * 35, 226},
	};
	unsigned type = bits(message, 8, 6);
	for (unsigned i = 0; i < sizeof spare / sizeof spare[0]; i++)
		if (spare[i].type == type)
			fw_bits_clear(message, FW_SBAS_BYTES, spare[i].start, spare[i].end - spare[i].start);
}

/* Every satellite place of a half message taken. */
static void settle_half(fw_random *random, uint8_t *message, unsigned half)
{
	set_bits(message, half + 1, 6, 1 + (unsigned)fw_random_below(random, 51));
	if (bits(message, half, 1) == 1)
		return;
	set_bits(message, half + 52, 6, 1 + (unsigned)fw_random_below(random, 51));
	set_bits(message, half + 105, 1, 0);
}

/* Makes a random message one that could be sent: no empty places, no numbers beyond what they may be. */
static void settle(fw_random *random, uint8_t *message)
{
	unsigned type = bits(message, 8, 6);

	clear_spare(message);
	if (type == 17) {
		for (unsigned i = 0; i < 3; i++)
			set_bits(message, 16 + 67 * i, 8, 120 + (unsigned)fw_random_below(random, 39));
		set_bits(message, 215, 11, (unsigned)fw_random_below(random, 1350));
	}
	if (type == 25)
		settle_half(random, message, 14);
	if (type == 24 || type == 25)
		settle_half(random, message, 120);
	if (type == 26)
		set_bits(message, 18, 4, (unsigned)fw_random_below(random, 13));
	if (type == 27) {
		unsigned n = 1 + (unsigned)fw_random_below(random, 5);
		set_bits(message, 23, 3, n);
		fw_bits_clear(message, FW_SBAS_BYTES, 36 + 35 * n, 35 * (5 - n));
	}
	if (type == 28)
		for (unsigned i = 0; i < 2; i++)
			set_bits(message, 16 + 105 * i, 6, 1 + (unsigned)fw_random_below(random, 51));
}

/* Records of a message that can be sent make the same message, bit by bit; so the records hold all of it. */
static void test_random_round_trip(void **state)
{
	(void)state;
	uint8_t message[FW_SBAS_BYTES], again[FW_SBAS_BYTES];
	fw_random random;
	static rows first, second;

	fw_random_init(&random, 229);
	for (unsigned k = 0; k < N_KNOWN; k++)
		for (unsigned i = 0; i < RANDOM_MESSAGES; i++) {
			randomise(&random, known_types[k], message);
			settle(&random, message);
			fw_sbas_finish(message);
			const fw_record_head *stamp = stamp_at((int32_t)fw_random_below(&random, 8000),
			                                       (double)fw_random_below(&random, 604800));
			assert_int_equal(decode(message, "S123", stamp, &first), FW_OK);
			encode(known_types[k], &first, again);
			assert_memory_equal(message, again, FW_SBAS_BYTES);
			assert_int_equal(decode(again, "S123", stamp, &second), FW_OK);
			assert_same(&first, &second);
		}
}

/* Any bits at all: nothing is read or written outside, and the records that come, if there are any, make a
 * message that gives them again. Types 1 and 17 have satellites without a name here, which cannot be sent. */
static void test_random_bits(void **state)
{
	(void)state;
	uint8_t message[FW_SBAS_BYTES], again[FW_SBAS_BYTES];
	fw_random random;
	static rows first, second;

	fw_random_init(&random, 2029);
	for (unsigned i = 0; i < 4 * RANDOM_MESSAGES; i++) {
		unsigned type = (unsigned)fw_random_below(&random, 64);
		randomise(&random, type, message);
		if (i % 4 == 0)
			message[0] = (uint8_t)fw_random_u64(&random);
		if (i % 3 != 0)
			fw_sbas_finish(message);
		fw_status status = decode(message, "S123", stamp_at(2367, 1), &first);
		assert_true(status >= 0 || first.n == 0);
		if (first.n == 0 || type == 1 || type == 17)
			continue;
		encode(type, &first, again);
		assert_int_equal(decode(again, "S123", stamp_at(2367, 1), &second), FW_OK);
		assert_same(&first, &second);
	}
}

/* ---- the receiver's own decoding ---- */

static void head_of(const uint8_t *block, void *record, fw_kind kind)
{
	furrow_sbas_mt0 *r = record;
	memset(record, 0, fw_record_type_of(kind)->size);
	r->present = (INT64_C(1) << fw_record_type_of(kind)->n_columns) - 1;
	r->gps_week = fw_load_u16(block + 12);
	r->tow_s = fw_load_u32(block + 8) / 1000.0;
	r->sat = (char *)(uintptr_t)fw_sbf_satellite(block[14]);
	r->source = raw;
}

#define NEW(kind, variable)                                                                                  \
	furrow_##kind variable;                                                                              \
	head_of(b, &variable, FW_##kind)
#define KEEP(kind, variable) keep(r, FW_##kind, &variable)

static void read_fast(const uint8_t *b, rows *r)
{
	for (unsigned i = 0; i < b[18]; i++) {
		const uint8_t *sub = b + 20 + i * b[19];
		NEW(sbas_fast, x);
		x.type = b[15], x.iodp = b[16], x.iodf = b[17], x.udrei = sub[1],
		x.prc_m = (double)fw_load_f32(sub + 4);
		/* This firmware counts from 0 in types 2-5: 13..25 in type 3, where the message means 14..26.
		 * Its own GEOLongTermCorr of the second after corrects 14 and 26, the two that are monitored
		 * so. */
		x.mask_no = (int16_t)(sub[0] + (b[15] == 24 ? 0 : 1));
		KEEP(sbas_fast, x);
	}
}

static void read_long(const uint8_t *b, rows *r)
{
	for (unsigned i = 0; i < b[15]; i++) {
		const uint8_t *s = b + 20 + i * b[16];
		NEW(sbas_long, x);
		x.velocity_code = s[0], x.mask_no = s[1], x.iodp = s[2], x.iode = s[3];
		x.dx_m = fw_load_f32(s + 4), x.dy_m = fw_load_f32(s + 8), x.dz_m = fw_load_f32(s + 12);
		x.vx_mps = fw_load_f32(s + 16), x.vy_mps = fw_load_f32(s + 20),
		x.vz_mps = fw_load_f32(s + 24);
		x.daf0_s = fw_load_f32(s + 28), x.daf1_sps = fw_load_f32(s + 32),
		x.toe_s = (int32_t)fw_load_u32(s + 36);
		KEEP(sbas_long, x);
	}
}

static void read_masks(const uint8_t *b, bool satellites, rows *r)
{
	for (unsigned i = 0; i < (satellites ? b[16] : b[18]); i++) {
		if (satellites) {
			NEW(sbas_mask, x);
			x.iodp = b[15], x.mask_no = (int16_t)(i + 1);
			x.mask_sat = (char *)(uintptr_t)fw_sbf_satellite(b[17 + i]);
			KEEP(sbas_mask, x);
		} else {
			NEW(sbas_igp_mask, x);
			x.bands = b[15], x.band = b[16], x.iodi = b[17], x.mask_no = (int16_t)(i + 1),
			x.igp = b[19 + i];
			KEEP(sbas_igp_mask, x);
		}
	}
}

static void read_iono(const uint8_t *b, rows *r)
{
	for (unsigned i = 0; i < b[17]; i++) {
		const uint8_t *s = b + 20 + i * b[18];
		NEW(sbas_iono, x);
		x.band = b[15], x.iodi = b[16], x.mask_no = s[0], x.givei = s[1],
		x.delay_m = (double)fw_load_f32(s + 4);
		KEEP(sbas_iono, x);
	}
}

static void read_51(const uint8_t *b, bool integrity, rows *r)
{
	for (unsigned i = 0; i < 51; i++) {
		if (integrity) {
			NEW(sbas_integrity, x);
			x.iodf2 = b[16], x.iodf3 = b[17], x.iodf4 = b[18], x.iodf5 = b[19];
			x.mask_no = (int16_t)(i + 1), x.udrei = b[20 + i];
			KEEP(sbas_integrity, x);
		} else {
			NEW(sbas_degradation, x);
			x.iodp = b[15], x.latency_s = b[16], x.mask_no = (int16_t)(i + 1), x.ai = b[17 + i];
			KEEP(sbas_degradation, x);
		}
	}
}

static void read_nav(const uint8_t *b, rows *r)
{
	NEW(eph_sbas, x);
	x.iodn = (int16_t)fw_load_u16(b + 16), x.ura = (int16_t)fw_load_u16(b + 18),
	x.t0_s = (int32_t)fw_load_u32(b + 20);
	x.x_m = fw_load_f64(b + 24), x.y_m = fw_load_f64(b + 32), x.z_m = fw_load_f64(b + 40);
	x.vx_mps = fw_load_f64(b + 48), x.vy_mps = fw_load_f64(b + 56), x.vz_mps = fw_load_f64(b + 64);
	x.ax_mps2 = fw_load_f64(b + 72), x.ay_mps2 = fw_load_f64(b + 80), x.az_mps2 = fw_load_f64(b + 88);
	x.agf0_s = fw_load_f32(b + 96), x.agf1_sps = fw_load_f32(b + 100);
	KEEP(eph_sbas, x);
}

static void read_factors(const uint8_t *b, rows *r)
{
	NEW(sbas_factors, x);
	x.brrc_m = fw_load_f64(b + 16), x.cltc_lsb_m = fw_load_f64(b + 24),
	x.cltc_v1_mps = fw_load_f64(b + 32);
	x.iltc_v1_s = (int32_t)fw_load_u32(b + 40), x.cltc_v0_m = fw_load_f64(b + 44);
	x.iltc_v0_s = (int32_t)fw_load_u32(b + 52), x.cgeo_lsb_m = fw_load_f64(b + 56);
	x.cgeo_v_mps = fw_load_f64(b + 64), x.igeo_s = (int32_t)fw_load_u32(b + 72),
	x.cer_m = fw_load_f32(b + 76);
	x.ciono_step_m = fw_load_f64(b + 80), x.iiono_s = (int32_t)fw_load_u32(b + 88);
	x.ciono_ramp_mps = fw_load_f64(b + 92), x.rss_udre = (int8_t)b[100], x.rss_iono = (int8_t)b[101];
	x.ccovariance = fw_load_f64(b + 104);
	KEEP(sbas_factors, x);
}

static void read_time(const uint8_t *b, rows *r)
{
	NEW(sbas_time, x);
	x.a1_sps = fw_load_f32(b + 16), x.a0_s = fw_load_f64(b + 20), x.tot_s = (int32_t)fw_load_u32(b + 28);
	x.wnt = b[32], x.leap_s = (int8_t)b[33], x.wnlsf = b[34], x.dn = b[35],
	x.leap_future_s = (int8_t)b[36];
	x.utc_std = b[37], x.gps_wn = fw_load_u16(b + 38), x.gps_tow_s = (int32_t)fw_load_u32(b + 40);
	x.glonass_id = b[44];
	KEEP(sbas_time, x);
}

static void read_almanac(const uint8_t *b, rows *r)
{
	NEW(sbas_almanac, x);
	x.data_id = b[16], x.health = (int16_t)fw_load_u16(b + 18), x.toa_s = fw_load_u32(b + 20);
	x.x_m = fw_load_f64(b + 24), x.y_m = fw_load_f64(b + 32), x.z_m = fw_load_f64(b + 40);
	x.vx_mps = fw_load_f64(b + 48), x.vy_mps = fw_load_f64(b + 56), x.vz_mps = fw_load_f64(b + 64);
	KEEP(sbas_almanac, x);
}

/* The records of a decoded block, by the layouts of the SBF reference guide, and the type of the message that
 * it was decoded from; -1 for other blocks. */
static int read_decoded(const uint8_t *b, rows *r)
{
	r->n = 0;
	switch (fw_load_u16(b + 4) & 0x1fff) {
	case 5925: {
		NEW(sbas_mt0, x);
		KEEP(sbas_mt0, x);
		return 0;
	}
	case 5926: read_masks(b, true, r); return 1;
	case 5927: read_fast(b, r); return b[15];
	case 5928: read_51(b, true, r); return 6;
	case 5929: read_51(b, false, r); return 7;
	case 5896: read_nav(b, r); return 9;
	case 5930: read_factors(b, r); return 10;
	case 5918: read_time(b, r); return 12;
	case 5897: read_almanac(b, r); return 17;
	case 5931: read_masks(b, false, r); return 18;
	case 5932: read_long(b, r); return 25;
	case 5933: read_iono(b, r); return 26;
	default: return -1;
	}
}

/* A file in memory and the blocks in it that are whole. */
typedef struct {
	size_t n;
	const uint8_t *block[1000];
	uint8_t bytes[1 << 20];
} sbf_file;

static void load(const char *path, sbf_file *f)
{
	FILE *stream = fopen(path, "rb");
	assert_non_null(stream);
	size_t size = fread(f->bytes, 1, sizeof f->bytes, stream);
	fclose(stream);
	f->n = 0;
	for (const uint8_t *p = f->bytes; p + 16 <= f->bytes + size;) {
		size_t length = fw_load_u16(p + 6);
		if (p[0] == '$' && p[1] == '@' && length >= 16 && p + length <= f->bytes + size &&
		    fw_crc16(p + 4, length - 4) == fw_load_u16(p + 2)) {
			assert_true(f->n < sizeof f->block / sizeof f->block[0]);
			f->block[f->n++] = p;
			p += length;
		} else {
			p++;
		}
	}
}

static void message_of(const uint8_t *block, uint8_t message[static FW_SBAS_BYTES])
{
	for (unsigned i = 0; i < FW_SBAS_BYTES; i++)
		message[i] = block[20 + (i ^ 3)]; /* words are little-endian */
}

/* The raw message that a decoded block came from must give the same records. */
static unsigned compare_raw(const sbf_file *f, const uint8_t *decoded, int type, const rows *expected)
{
	uint8_t message[FW_SBAS_BYTES];
	static rows r;
	unsigned found = 0;

	for (size_t i = 0; i < f->n; i++) {
		const uint8_t *b = f->block[i];
		message_of(b, message);
		if ((fw_load_u16(b + 4) & 0x1fff) != 4020 || memcmp(b + 8, decoded + 8, 7) != 0 ||
		    (int)bits(message, 8, 6) != type)
			continue;
		const fw_record_head *stamp = stamp_at(fw_load_u16(b + 12), fw_load_u32(b + 8) / 1000.0);
		assert_int_equal(decode(message, fw_sbf_satellite(b[14]), stamp, &r), FW_OK);
		assert_same(&r, expected);
		found++;
	}
	return found;
}

/* A message made of a decoded block's records must give them again, to the last bit of every double: the
 * receiver multiplies by the same scales. */
static void compare_made(const uint8_t *b, int type, const rows *expected)
{
	uint8_t message[FW_SBAS_BYTES];
	static rows r;

	encode((unsigned)type, expected, message);
	const fw_record_head *stamp = stamp_at(fw_load_u16(b + 12), fw_load_u32(b + 8) / 1000.0);
	assert_int_equal(decode(message, fw_sbf_satellite(b[14]), stamp, &r), FW_OK);
	assert_same(&r, expected);
}

static const char *data_directory(void)
{
	const char *directory = getenv("FURROW_DATA");
	return directory != NULL ? directory : "../shared/data";
}

static void test_receiver_decoded(void **state)
{
	(void)state;
	static sbf_file file;
	static rows expected;
	char pattern[4096];
	glob_t found;
	unsigned raw_pairs = 0, decoded = 0;
	uint64_t types = 0;

	snprintf(pattern, sizeof pattern, "%s/sbf/log_0000.sbf", data_directory());
	if (glob(pattern, 0, NULL, &found) != 0) {
		fprintf(stderr, "%s: not here, skipped (set FURROW_DATA)\n", pattern);
		skip();
	}
	snprintf(pattern, sizeof pattern, "%s/sbf/*.sbf", data_directory());
	assert_int_equal(glob(pattern, GLOB_APPEND, NULL, &found), 0);
	snprintf(pattern, sizeof pattern, "%s/sbf/pysbf2/*.log", data_directory());
	assert_int_equal(glob(pattern, GLOB_APPEND, NULL, &found), 0);
	for (size_t i = 1; i < found.gl_pathc; i++) {
		load(found.gl_pathv[i], &file);
		for (size_t k = 0; k < file.n; k++) {
			int type = read_decoded(file.block[k], &expected);
			if (type < 0)
				continue;
			decoded++;
			types |= UINT64_C(1) << type;
			raw_pairs += compare_raw(&file, file.block[k], type, &expected);
			compare_made(file.block[k], type, &expected);
		}
	}
	globfree(&found);
	/* 11 in the mosaic-X5 log, 4 in log_0000, 3 in all_blocks_0000; two GEONav have their message beside
	 * them. */
	assert_int_equal(decoded, 18);
	assert_int_equal(raw_pairs, 2);
	assert_int_equal(types, 1 << 0 | 1 << 1 | 1 << 3 | 1 << 7 | 1 << 9 | 1 << 10 | 1 << 12 | 1 << 17 |
	                            1 << 18 | 1 << 25 | 1 << 26);
}

/* ---- an hour of messages ---- */

/* Made by the Python decoder: the number of messages of each type ... */
static const struct {
	unsigned type, n;
} type_counts[] = {
    {0, 2550}, {1, 281},  {2, 3104}, {3, 3855},  {4, 3853},  {7, 232}, {8, 6},    {9, 316}, {10, 232},
    {12, 18},  {17, 150}, {18, 302}, {25, 2412}, {26, 1273}, {27, 35}, {28, 922}, {62, 20}, {63, 2841},
};

/* ... and of records of each kind ... */
static const struct {
	fw_kind kind;
	unsigned n;
} row_counts[] = {
    {FW_sbas_mt0, 2550},       {FW_sbas_mask, 9162},   {FW_sbas_fast, 150306}, {FW_sbas_degradation, 11832},
    {FW_eph_sbas, 316},        {FW_sbas_factors, 232}, {FW_sbas_time, 18},     {FW_sbas_almanac, 332},
    {FW_sbas_igp_mask, 16390}, {FW_sbas_long, 4001},   {FW_sbas_iono, 19095},  {FW_sbas_service, 53},
    {FW_sbas_cov, 1508},
};

/* ... and the sum over all records i of a kind of (i mod 97 + 1) times the column; a satellite G05 counts as
 * 71005, its letter and number. */
static const struct {
	fw_kind kind;
	const char *column;
	double sum;
} row_sums[] = {
    {FW_sbas_mask, "iodp", 755360},
    {FW_sbas_mask, "mask_no", 7500407},
    {FW_sbas_mask, "mask_sat", 31916616530},
    {FW_sbas_fast, "type", 21114059},
    {FW_sbas_fast, "iodp", 14182621},
    {FW_sbas_fast, "iodf", 7370990},
    {FW_sbas_fast, "mask_no", 147133944},
    {FW_sbas_fast, "udrei", 76696286},
    {FW_sbas_fast, "prc_m", 762707254.375},
    {FW_sbas_degradation, "iodp", 1191126},
    {FW_sbas_degradation, "latency_s", 932679},
    {FW_sbas_degradation, "mask_no", 15067896},
    {FW_sbas_degradation, "ai", 6427987},
    {FW_eph_sbas, "iodn", 841354},
    {FW_eph_sbas, "t0_s", 579926752},
    {FW_eph_sbas, "ura", 217212},
    {FW_eph_sbas, "x_m", -205620664736.4},
    {FW_eph_sbas, "y_m", 528057953391.9202},
    {FW_eph_sbas, "z_m", 7329982836},
    {FW_eph_sbas, "vx_mps", -2938.05875},
    {FW_eph_sbas, "vy_mps", -897.0699999999996},
    {FW_eph_sbas, "vz_mps", 2502.004000000011},
    {FW_eph_sbas, "ax_mps2", -0.161975},
    {FW_eph_sbas, "ay_mps2", 0.6399374999999999},
    {FW_eph_sbas, "az_mps2", -19.4581875},
    {FW_eph_sbas, "agf0_s", -0.001931175123900175},
    {FW_eph_sbas, "agf1_sps", -2.364686224609613e-10},
    {FW_sbas_factors, "brrc_m", 748.8720000000001},
    {FW_sbas_factors, "cltc_lsb_m", 1713.037999999999},
    {FW_sbas_factors, "cltc_v1_mps", 52.1906},
    {FW_sbas_factors, "iltc_v1_s", 1624992},
    {FW_sbas_factors, "cltc_v0_m", 5281.79},
    {FW_sbas_factors, "iltc_v0_s", 1171500},
    {FW_sbas_factors, "cgeo_lsb_m", 1664.638},
    {FW_sbas_factors, "cgeo_v_mps", 95.03610000000002},
    {FW_sbas_factors, "igeo_s", 1624992},
    {FW_sbas_factors, "cer_m", 15478},
    {FW_sbas_factors, "ciono_step_m", 8287.609999999999},
    {FW_sbas_factors, "iiono_s", 2832480},
    {FW_sbas_factors, "ciono_ramp_mps", 0},
    {FW_sbas_factors, "rss_udre", 0},
    {FW_sbas_factors, "rss_iono", 0},
    {FW_sbas_factors, "ccovariance", 0},
    {FW_sbas_time, "a1_sps", 0},
    {FW_sbas_time, "a0_s", 0},
    {FW_sbas_time, "tot_s", 0},
    {FW_sbas_time, "wnt", 0},
    {FW_sbas_time, "leap_s", 0},
    {FW_sbas_time, "wnlsf", 0},
    {FW_sbas_time, "dn", 0},
    {FW_sbas_time, "leap_future_s", 0},
    {FW_sbas_time, "utc_std", 1197},
    {FW_sbas_time, "gps_tow_s", 0},
    {FW_sbas_time, "gps_wn", 0},
    {FW_sbas_time, "glonass_id", 0},
    {FW_sbas_almanac, "sat", 1257041255},
    {FW_sbas_almanac, "data_id", 0},
    {FW_sbas_almanac, "health", 1198771},
    {FW_sbas_almanac, "toa_s", 21442592800704},
    {FW_sbas_almanac, "x_m", -224862721200},
    {FW_sbas_almanac, "y_m", 535636384400},
    {FW_sbas_almanac, "z_m", 20309640000},
    {FW_sbas_almanac, "vx_mps", 0},
    {FW_sbas_almanac, "vy_mps", 0},
    {FW_sbas_almanac, "vz_mps", 0},
    {FW_sbas_igp_mask, "bands", 2462100},
    {FW_sbas_igp_mask, "band", 5326148},
    {FW_sbas_igp_mask, "iodi", 591123},
    {FW_sbas_igp_mask, "mask_no", 30226786},
    {FW_sbas_igp_mask, "igp", 83943823},
    {FW_sbas_long, "velocity_code", 5038},
    {FW_sbas_long, "mask_no", 3518189},
    {FW_sbas_long, "iodp", 194537},
    {FW_sbas_long, "iode", 10640546},
    {FW_sbas_long, "dx_m", -17037.25},
    {FW_sbas_long, "dy_m", 36942.625},
    {FW_sbas_long, "dz_m", 2949.5},
    {FW_sbas_long, "vx_mps", -1.4794921875},
    {FW_sbas_long, "vy_mps", -1.771484375},
    {FW_sbas_long, "vz_mps", 1.3095703125},
    {FW_sbas_long, "daf0_s", -0.0003595766611397266},
    {FW_sbas_long, "daf1_sps", -3.028617356903851e-09},
    {FW_sbas_long, "toe_s", 109796672},
    {FW_sbas_iono, "band", 6155233},
    {FW_sbas_iono, "iodi", 568074},
    {FW_sbas_iono, "mask_no", 35487586},
    {FW_sbas_iono, "givei", 8287051},
    {FW_sbas_iono, "delay_m", 8148581.125},
    {FW_sbas_service, "iods", 0},
    {FW_sbas_service, "messages", 1431},
    {FW_sbas_service, "message_no", 1431},
    {FW_sbas_service, "priority", 0},
    {FW_sbas_service, "dudre_in", 0},
    {FW_sbas_service, "dudre_out", 21465},
    {FW_sbas_service, "lat1_deg", 13041},
    {FW_sbas_service, "lon1_deg", 15516},
    {FW_sbas_service, "lat2_deg", -44550},
    {FW_sbas_service, "lon2_deg", 63216},
    {FW_sbas_service, "shape", 1431},
    {FW_sbas_cov, "iodp", 214550},
    {FW_sbas_cov, "mask_no", 1422021},
    {FW_sbas_cov, "scale_exp", 141406},
    {FW_sbas_cov, "e11", 3738419},
    {FW_sbas_cov, "e22", 4045744},
    {FW_sbas_cov, "e33", 1771250},
    {FW_sbas_cov, "e44", 358418},
    {FW_sbas_cov, "e12", -3141201},
    {FW_sbas_cov, "e13", -2144858},
    {FW_sbas_cov, "e14", 565808},
    {FW_sbas_cov, "e23", 656649},
    {FW_sbas_cov, "e24", -334216},
    {FW_sbas_cov, "e34", -324550},
};

enum { N_SUMS = sizeof row_sums / sizeof row_sums[0] };

typedef struct {
	unsigned types[64];
	unsigned rows[FW_RECORD_COUNT];
	double sums[N_SUMS];
} totals;

static void add_record(void *context, fw_kind kind, const void *record)
{
	totals *t = context;
	double weight = t->rows[kind]++ % 97 + 1;
	for (unsigned i = 0; i < N_SUMS; i++) {
		if (row_sums[i].kind != kind)
			continue;
		const fw_column *c = column(kind, row_sums[i].column);
		if (c->type == FW_STR)
			t->sums[i] += weight * (string(record, c)[0] * 1000 +
			                        (double)strtol(string(record, c) + 1, NULL, 10));
		else
			t->sums[i] += weight * number(record, c);
	}
}

/* Lines "week tow PRN type : hex" with 226 bits; what stands for the CRC is its first six bits, or zeros. */
static void add_file(const char *name, totals *t)
{
	char path[4096], line[256];
	snprintf(path, sizeof path, "%s/sbas/%s", data_directory(), name);
	gzFile file = gzopen(path, "rb");
	if (file == NULL) {
		fprintf(stderr, "%s: not here, skipped (set FURROW_DATA)\n", path);
		skip();
	}
	while (gzgets(file, line, sizeof line) != NULL) {
		uint8_t message[FW_SBAS_BYTES];
		char sat[8], *p = line;
		const int week = (int)strtol(p, &p, 10), tow = (int)strtol(p, &p, 10),
		          prn = (int)strtol(p, &p, 10);
		const unsigned type = (unsigned)strtoul(p, &p, 10);
		char *const hex = p + strspn(p, " :");

		hex[strcspn(hex, "\r\n")] = '\0';
		from_hex(hex, message);
		if ((message[0] != 0x53 && message[0] != 0x9a && message[0] != 0xc6) ||
		    bits(message, 8, 6) != type)
			continue; /* L5 */
		unsigned crc_start = bits(message, 226, 6);
		fw_sbas_finish(message);
		assert_true(crc_start == 0 || crc_start == bits(message, 226, 6));
		snprintf(sat, sizeof sat, "S%d", prn);
		fw_status status =
		    fw_sbas_decode(message, sat, stamp_at(week, tow), (fw_sink){add_record, t});
		assert_int_equal(status, type == 8 ? FW_EUNKNOWN : FW_OK);
		t->types[type]++;
	}
	gzclose(file);
}

static void test_real_messages(void **state)
{
	(void)state;
	static totals t;

	add_file("japan_2025/046r_sbas.txt.gz", &t);
	add_file("msas_2008/cres_20080526.sbs", &t);
	for (unsigned i = 0; i < sizeof type_counts / sizeof type_counts[0]; i++)
		assert_int_equal(t.types[type_counts[i].type], type_counts[i].n);
	for (unsigned i = 0; i < sizeof row_counts / sizeof row_counts[0]; i++)
		assert_int_equal(t.rows[row_counts[i].kind], row_counts[i].n);
	for (unsigned i = 0; i < N_SUMS; i++)
		if (!(fabs(t.sums[i] - row_sums[i].sum) <= 1e-9 * fabs(row_sums[i].sum)))
			fail_msg("%s.%s: %.16g, not %.16g", fw_record_type_of(row_sums[i].kind)->name,
			         row_sums[i].column, t.sums[i], row_sums[i].sum);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_fast_corrections),
	    cmocka_unit_test(test_places),
	    cmocka_unit_test(test_absent_columns),
	    cmocka_unit_test(test_almanac_day),
	    cmocka_unit_test(test_refused),
	    cmocka_unit_test(test_add_refuses),
	    cmocka_unit_test(test_preamble_follows_time),
	    cmocka_unit_test(test_random_round_trip),
	    cmocka_unit_test(test_random_bits),
	    cmocka_unit_test(test_receiver_decoded),
	    cmocka_unit_test(test_real_messages),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
