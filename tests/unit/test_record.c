/* The table of types against the structs that lcm-gen made (offsetof, sizeof); text forms and the encoding
 * against what was written down by hand, the latter from LCM's type specification. The fingerprints are
 * compared with PyPI's lcm in tests/oracle. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../random_record.h"
#include "furrow_baro.h"
#include "furrow_comment.h"
#include "furrow_obs.h"
#include "furrow_pvt.h"

static const fw_column *column(fw_kind kind, const char *name)
{
	const fw_record_type *type = fw_record_type_of(kind);
	const int i = fw_record_column(type, name, strlen(name));

	assert_in_range(i, 0, type->n_columns - 1);
	return &type->columns[i];
}

static void table_is_the_structs(void **state)
{
	(void)state;
	const fw_record_type *type = fw_record_type_of(FW_obs);
	assert_string_equal(type->name, "obs");
	assert_string_equal(type->channel, "FURROW_OBS");
	assert_int_equal(type->size, sizeof(furrow_obs));
	assert_int_equal(type->n_columns, 14);
	assert_string_equal(type->columns[0].name, "gps_week");
	assert_string_equal(type->columns[13].name, "rx_channel");
	assert_int_equal(type->columns[13].offset, offsetof(furrow_obs, rx_channel));
	assert_int_equal(type->columns[13].type, FW_I16);
	assert_int_equal(column(FW_obs, "sat")->type, FW_STR);
	assert_int_equal(column(FW_obs, "antenna")->type, FW_I8);
	assert_int_equal(column(FW_obs, "cn0_dbhz")->offset, offsetof(furrow_obs, cn0_dbhz));
	assert_int_equal(column(FW_pvt, "signals")->type, FW_I64);
	assert_int_equal(column(FW_pvt, "undulation_m")->type, FW_F32);
	assert_string_equal(fw_record_type_of(FW_sbas5_almanac)->channel, "FURROW_SBAS5_ALMANAC");
}

static void every_type_is_sound(void **state)
{
	(void)state;
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++) {
		const fw_record_type *type = fw_record_type_of(kind);
		assert_int_equal(fw_record_find(type->name, strlen(type->name)), kind);
		assert_in_range(type->n_columns, 3, FW_MAX_COLUMNS);
		assert_in_range(type->size, 32, sizeof(fw_any_record));
		for (int i = 0; i < type->n_columns; i++)
			assert_int_equal(
			    fw_record_column(type, type->columns[i].name, strlen(type->columns[i].name)), i);
		for (fw_kind other = 0; other < kind; other++)
			assert_string_not_equal(type->name, fw_record_type_of(other)->name);
	}
	assert_int_equal(fw_record_find("ob", 2), FW_RECORD_COUNT);
	assert_int_equal(fw_record_find("obsx", 4), FW_RECORD_COUNT);
	assert_int_equal(fw_record_find("", 0), FW_RECORD_COUNT);
	assert_int_equal(fw_record_column(fw_record_type_of(FW_obs), "present", 7), -1);
	assert_int_equal(fw_record_column(fw_record_type_of(FW_obs), "sa", 2), -1);
	assert_int_equal(fw_record_column(fw_record_type_of(FW_obs), "", 0), -1);
}

static void text_forms(void **state)
{
	static const struct {
		fw_kind kind;
		const char *column;
		fw_column_text text;
		int decimals;
	} cases[] = {
	    {FW_obs, "gps_week", FW_TEXT_PLAIN, 0},
	    {FW_obs, "tow_s", FW_TEXT_TRIMMED, 9},
	    {FW_event, "rx_tow_s", FW_TEXT_TRIMMED, 9},
	    {FW_obs, "sat", FW_TEXT_PLAIN, 0},
	    {FW_obs, "pseudorange_m", FW_TEXT_FIXED, 4},
	    {FW_obs, "carrier_cyc", FW_TEXT_FIXED, 3},
	    {FW_obs, "doppler_hz", FW_TEXT_FIXED, 4},
	    {FW_obs, "cn0_dbhz", FW_TEXT_FIXED, 2},
	    {FW_obs_extra, "multipath_corr_m", FW_TEXT_FIXED, 4},
	    {FW_obs_extra, "code_var_m2", FW_TEXT_FIXED, 4},
	    {FW_obs_extra, "carrier_multipath_corr_cyc", FW_TEXT_TRIMMED, 9},
	    {FW_obs_extra, "cn0_highres_dbhz", FW_TEXT_TRIMMED, 5},
	    {FW_pvt, "lat_deg", FW_TEXT_FIXED, 9},
	    {FW_pvt, "height_m", FW_TEXT_FIXED, 4},
	    {FW_pvt, "undulation_m", FW_TEXT_SHORTEST, 0}, /* float */
	    {FW_pvt, "vn_mps", FW_TEXT_SHORTEST, 0},       /* float */
	    {FW_nav, "vn_mps", FW_TEXT_FIXED, 4},
	    {FW_pvt, "clock_bias_s", FW_TEXT_SHORTEST, 0},
	    {FW_dop, "pdop", FW_TEXT_SHORTEST, 0},
	    {FW_imu, "gyro_x_radps", FW_TEXT_FIXED, 9},
	    {FW_imu, "accel_z_mps2", FW_TEXT_FIXED, 9},
	    {FW_mag, "mag_x_ut", FW_TEXT_FIXED, 3},
	    {FW_eph_gps, "idot_radps", FW_TEXT_SHORTEST, 0},
	    {FW_eph_gps, "omega0_rad", FW_TEXT_SHORTEST, 0},
	    {FW_eph_glo, "x_m", FW_TEXT_SHORTEST, 0},
	    {FW_eph_glo, "ax_mps2", FW_TEXT_SHORTEST, 0},
	    {FW_satpos, "x_m", FW_TEXT_SHORTEST, 0},
	    {FW_sbas5_nav, "a_m", FW_TEXT_SHORTEST, 0},
	    {FW_pvt_ecef, "x_m", FW_TEXT_FIXED, 4},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const fw_column *c = column(cases[i].kind, cases[i].column);
		assert_int_equal(c->text, cases[i].text);
		assert_int_equal(c->decimals, cases[i].decimals);
	}
}

static void rounding(void **state)
{
	char none[] = "", sat[] = "G05";
	furrow_obs o = {.present = -1,
	                .gps_week = 2345,
	                .tow_s = 482321.12345678949,
	                .sat = sat,
	                .signal = none,
	                .pseudorange_m = 23456789.12345,
	                .carrier_cyc = -0.0004,
	                .doppler_hz = NAN,
	                .cn0_dbhz = 47.25};
	(void)state;
	fw_record_round(FW_obs, &o);
	/* bits: 14 columns without signal (3) and Doppler (8) */
	assert_int_equal(o.present, 0x3fff & ~(1 << 3) & ~(1 << 8));
	assert_true(o.tow_s == 482321.123456789);
	assert_true(o.pseudorange_m == 23456789.1234); /* the double is 23456789.12344999... */
	assert_true(o.carrier_cyc == 0 && !signbit(o.carrier_cyc));
	assert_true(o.doppler_hz == 0);
	assert_true(o.cn0_dbhz == 47.25);
	assert_string_equal(o.sat, "G05");
	assert_string_equal(o.signal, "");
}

static void rounding_twice_changes_nothing(void **state)
{
	fw_any_record once, twice;
	fw_random r;

	(void)state;
	fw_random_init(&r, 1);
	for (int i = 0; i < 20 * FW_RECORD_COUNT; i++) {
		const fw_kind kind = (fw_kind)(i % FW_RECORD_COUNT);
		random_record(&r, kind, &once);
		fw_record_round(kind, &once);
		twice = once;
		fw_record_round(kind, &twice);
		assert_int_equal(first_difference(kind, &once, &twice), -1);
	}
}

/* Absent columns come out empty whatever they hold. */
static void rounding_clears_absent_columns(void **state)
{
	furrow_obs o = {.present = 0, .gps_week = 1, .tow_s = 2, .pseudorange_m = 3, .lock_s = 4};
	(void)state;
	fw_record_round(FW_obs, &o);
	assert_int_equal(o.gps_week, 0);
	assert_true(o.tow_s == 0 && o.pseudorange_m == 0);
	assert_int_equal(o.lock_s, 0);
	assert_string_equal(o.sat, "");
}

static void record_time(void **state)
{
	furrow_baro b = {.present = 3, .gps_week = 2000, .tow_s = 1.5};
	fw_time t = {-1};

	(void)state;
	assert_int_equal(fw_record_time(&b, &t), FW_OK);
	assert_int_equal(t.ns, INT64_C(2000) * 604800 * 1000000000 + 1500000000);
	b.present = 1;
	t.ns = -1;
	assert_int_equal(fw_record_time(&b, &t), FW_EINVAL);
	b.present = 3, b.tow_s = 604800;
	assert_int_equal(fw_record_time(&b, &t), FW_ERANGE);
	b.tow_s = NAN;
	assert_int_equal(fw_record_time(&b, &t), FW_ENONFINITE);
	assert_int_equal(t.ns, -1);
}

/* Fields in order, big-endian, doubles as IEEE 754, strings with length and NUL.
 * Source: LCM type specification, "Encoding". 482321.2 is 0x411d70444ccccccd (python: struct.pack). */
static const unsigned char encoded_comment[] = {
    0,    0,    0,    0,    0,    0,    0,    0,    /* the fingerprint, filled in below */
    0,    0,    0,    0,    0,    0,    0,    7,    /* present */
    0,    0,    0x09, 0x29,                         /* 2345 */
    0x41, 0x1d, 0x70, 0x44, 0xcc, 0xcc, 0xcc, 0xcd, /* 482321.2 */
    0,    0,    0,    3,    'h',  'i',  0,
};

static void encoding(void **state)
{
	char text[] = "hi";
	furrow_comment c = {.present = 7, .gps_week = 2345, .tow_s = 482321.2, .text = text};
	unsigned char buffer[64];
	size_t used = 99;

	(void)state;
	assert_int_equal(fw_record_encode(FW_comment, &c, buffer, sizeof encoded_comment - 1, &used),
	                 FW_ENOSPACE);
	assert_int_equal(used, 99);
	assert_int_equal(fw_record_encode(FW_comment, &c, buffer, sizeof encoded_comment, &used), FW_OK);
	assert_int_equal(used, sizeof encoded_comment);
	assert_memory_equal(buffer + 8, encoded_comment + 8, sizeof encoded_comment - 8);

	c.text = NULL; /* absent */
	assert_int_equal(fw_record_encode(FW_comment, &c, buffer, sizeof buffer, &used), FW_OK);
	assert_int_equal(used, sizeof encoded_comment - 2);
}

static void decoding(void **state)
{
	unsigned char bytes[sizeof encoded_comment + 1] = {0};
	const int64_t hash = fw_record_type_of(FW_comment)->hash;
	const size_t n = sizeof encoded_comment;
	furrow_comment c;

	(void)state;
	memcpy(bytes, encoded_comment, n);
	assert_int_equal(fw_record_decode(FW_comment, bytes, n, &c), FW_EFORMAT); /* fingerprint */
	for (int i = 0; i < 8; i++)
		bytes[i] = (unsigned char)(hash >> (56 - 8 * i));
	assert_int_equal(fw_record_decode(FW_comment, bytes, n, &c), FW_OK);
	assert_int_equal(c.present, 7);
	assert_int_equal(c.gps_week, 2345);
	assert_true(c.tow_s == 482321.2);
	assert_string_equal(c.text, "hi");

	assert_int_equal(fw_record_decode(FW_comment, bytes, n + 1, &c), FW_EFORMAT); /* a byte too many */
	for (size_t cut = 0; cut < n; cut++)
		assert_int_equal(fw_record_decode(FW_comment, bytes, cut, &c), FW_EFORMAT);
	bytes[n - 1] = 'x'; /* no NUL */
	assert_int_equal(fw_record_decode(FW_comment, bytes, n, &c), FW_EFORMAT);
	bytes[n - 1] = 0;
	bytes[n - 4] = 0; /* a string of length 0 has no room for its NUL */
	assert_int_equal(fw_record_decode(FW_comment, bytes, n - 3, &c), FW_EFORMAT);
	bytes[n - 7] = 0xff; /* a length of -16777216 + 3 */
	bytes[n - 4] = 3;
	assert_int_equal(fw_record_decode(FW_comment, bytes, n, &c), FW_EFORMAT);
}

/* A mask with more bits than columns, values in absent columns, NaN: none of it comes through. */
static void decoding_trusts_nothing(void **state)
{
	furrow_baro b = {.present = -1 & ~INT64_C(1), .gps_week = 2345, .tow_s = 1, .baro_height_m = NAN},
	            read;
	unsigned char bytes[64];
	size_t n;

	(void)state;
	assert_int_equal(fw_record_encode(FW_baro, &b, bytes, sizeof bytes, &n), FW_OK);
	assert_int_equal(fw_record_decode(FW_baro, bytes, n, &read), FW_OK);
	assert_int_equal(read.present, 2);
	assert_int_equal(read.gps_week, 0);
	assert_true(read.baro_height_m == 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(table_is_the_structs),
	    cmocka_unit_test(every_type_is_sound),
	    cmocka_unit_test(text_forms),
	    cmocka_unit_test(rounding),
	    cmocka_unit_test(rounding_twice_changes_nothing),
	    cmocka_unit_test(rounding_clears_absent_columns),
	    cmocka_unit_test(record_time),
	    cmocka_unit_test(encoding),
	    cmocka_unit_test(decoding),
	    cmocka_unit_test(decoding_trusts_nothing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
