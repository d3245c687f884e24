/* signal: names and frequencies as RINEX 4.01, tables 1 and 4 to 10, has them. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "gnss/signal.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

static const struct {
	const char *name;
	fw_satellite satellite;
	const char *written;
} satellites[] = {
    {"G05", {FW_GPS, 5}, "G05"},      {"E36", {FW_GALILEO, 36}, "E36"}, {"C63", {FW_BEIDOU, 63}, "C63"},
    {"R24", {FW_GLONASS, 24}, "R24"}, {"J01", {FW_QZSS, 1}, "J01"},     {"I14", {FW_NAVIC, 14}, "I14"},
    {"S123", {FW_SBAS, 23}, "S123"},  {"S23", {FW_SBAS, 23}, "S123"},   {"G 5", {FW_GPS, 5}, "G05"},
    {"  5", {FW_GPS, 5}, "G05"},      {" 12", {FW_GPS, 12}, "G12"},     {"S158", {FW_SBAS, 58}, "S158"},
};

static void satellites_have_names(void **state)
{
	(void)state;
	for (size_t i = 0; i < COUNT(satellites); i++) {
		fw_satellite s = {FW_SYSTEM_COUNT, 99};
		char name[5];

		assert_int_equal(fw_satellite_parse(satellites[i].name, &s), FW_OK);
		assert_true(fw_satellite_equal(s, satellites[i].satellite));
		fw_satellite_name(s, name);
		assert_string_equal(name, satellites[i].written);
	}
}

static void other_text_is_no_satellite(void **state)
{
	static const char *const bad[] = {"",    "G",   "G5",  "G05 ", "G005", "G00",
	                                  "G64", "X05", "g05", "S223", "S100", "S1234",
	                                  "05",  "G-1", "G5 ", "S 23", "E1a",  "L01"};
	fw_satellite s = {FW_QZSS, 7};

	(void)state;
	for (size_t i = 0; i < COUNT(bad); i++)
		if (fw_satellite_parse(bad[i], &s) != FW_ESYNTAX)
			fail_msg("\"%s\" was taken for a satellite", bad[i]);
	assert_true(fw_satellite_equal(s, (fw_satellite){FW_QZSS, 7}));
}

static void hostile_satellites_are_named_within_their_room(void **state)
{
	char name[5];

	(void)state;
	for (unsigned system = 0; system < 256; system += 5)
		for (unsigned number = 0; number < 256; number++) {
			fw_satellite_name((fw_satellite){(uint8_t)system, (uint8_t)number}, name);
			assert_in_range(strlen(name), 3, 4);
		}
}

static void satellites_have_an_index_of_their_own(void **state)
{
	bool seen[FW_SATELLITE_COUNT] = {false};

	(void)state;
	for (unsigned system = 0; system < FW_SYSTEM_COUNT; system++)
		for (unsigned number = 0; number < FW_SATELLITES_PER_SYSTEM; number++) {
			const unsigned i =
			    fw_satellite_index((fw_satellite){(uint8_t)system, (uint8_t)number});

			assert_true(i < FW_SATELLITE_COUNT && !seen[i]);
			seen[i] = true;
		}
}

static void systems_have_letters(void **state)
{
	(void)state;
	for (unsigned i = 0; i < FW_SYSTEM_COUNT; i++) {
		assert_int_equal(fw_system_letter((fw_system)i), "GECRJIS"[i]);
		assert_int_equal(fw_system_of_letter("GECRJIS"[i]), i);
	}
	assert_int_equal(fw_system_of_letter('X'), FW_SYSTEM_COUNT);
	assert_int_equal(fw_system_of_letter('\0'), FW_SYSTEM_COUNT);
	assert_int_equal(fw_system_letter(FW_SYSTEM_COUNT), '?');
}

static const struct {
	fw_system system;
	fw_signal signal;
	int channel;
	double hz;
} frequencies[] = {
    {FW_GPS, {'1', 'C'}, 0, 1575.42e6},
    {FW_GPS, {'2', 'W'}, 0, 1227.60e6},
    {FW_GPS, {'5', 'Q'}, 0, 1176.45e6},
    {FW_GPS, {'7', 'Q'}, 0, 0},
    {FW_GALILEO, {'1', 'X'}, 0, 1575.42e6},
    {FW_GALILEO, {'5', 'X'}, 0, 1176.45e6},
    {FW_GALILEO, {'7', 'X'}, 0, 1207.140e6},
    {FW_GALILEO, {'8', 'X'}, 0, 1191.795e6},
    {FW_GALILEO, {'6', 'C'}, 0, 1278.75e6},
    {FW_GALILEO, {'2', 'C'}, 0, 0},
    {FW_BEIDOU, {'2', 'I'}, 0, 1561.098e6},
    {FW_BEIDOU, {'1', 'P'}, 0, 1575.42e6},
    {FW_BEIDOU, {'5', 'P'}, 0, 1176.45e6},
    {FW_BEIDOU, {'7', 'I'}, 0, 1207.140e6},
    {FW_BEIDOU, {'8', 'P'}, 0, 1191.795e6},
    {FW_BEIDOU, {'6', 'I'}, 0, 1268.52e6},
    {FW_GLONASS, {'1', 'C'}, 0, 1602e6},
    {FW_GLONASS, {'1', 'C'}, -7, 1598.0625e6},
    {FW_GLONASS, {'1', 'C'}, 6, 1605.375e6},
    {FW_GLONASS, {'2', 'P'}, -7, 1242.9375e6},
    {FW_GLONASS, {'2', 'P'}, 6, 1248.625e6},
    {FW_GLONASS, {'1', 'C'}, INT8_MIN, 0},
    {FW_GLONASS, {'1', 'C'}, 7, 0},
    {FW_GLONASS, {'3', 'Q'}, INT8_MIN, 1202.025e6},
    {FW_GLONASS, {'4', 'X'}, 0, 1600.995e6},
    {FW_GLONASS, {'6', 'X'}, 0, 1248.06e6},
    {FW_QZSS, {'1', 'C'}, 0, 1575.42e6},
    {FW_QZSS, {'2', 'L'}, 0, 1227.60e6},
    {FW_QZSS, {'5', 'Q'}, 0, 1176.45e6},
    {FW_QZSS, {'6', 'L'}, 0, 1278.75e6},
    {FW_NAVIC, {'5', 'A'}, 0, 1176.45e6},
    {FW_NAVIC, {'9', 'A'}, 0, 2492.028e6},
    {FW_NAVIC, {'1', 'P'}, 0, 1575.42e6},
    {FW_SBAS, {'1', 'C'}, 0, 1575.42e6},
    {FW_SBAS, {'5', 'I'}, 0, 1176.45e6},
    {FW_SBAS, {'2', 'C'}, 0, 0},
    {FW_GPS, {0, 0}, 0, 0},
    {FW_GPS, {'0' - 1, 'C'}, 0, 0},
    {FW_GPS, {'9' + 1, 'C'}, 0, 0},
    {FW_SYSTEM_COUNT, {'1', 'C'}, 0, 0},
};

static void bands_have_frequencies(void **state)
{
	(void)state;
	for (size_t i = 0; i < COUNT(frequencies); i++) {
		const double hz = fw_signal_frequency_hz(frequencies[i].system, frequencies[i].signal,
		                                         frequencies[i].channel);

		if (hz != frequencies[i].hz)
			fail_msg("row %zu: %.3f is not %.3f", i, hz, frequencies[i].hz);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(satellites_have_names),
	    cmocka_unit_test(other_text_is_no_satellite),
	    cmocka_unit_test(hostile_satellites_are_named_within_their_room),
	    cmocka_unit_test(satellites_have_an_index_of_their_own),
	    cmocka_unit_test(systems_have_letters),
	    cmocka_unit_test(bands_have_frequencies),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
