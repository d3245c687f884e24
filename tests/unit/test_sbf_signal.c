/* SBF's numbers for satellites and signals. Expected values: the ranges and carriers of the SBF reference guide, typed
 * anew from its tables. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "formats/sbf_signal.h"

static void satellites(void **state)
{
	(void)state;
	static const struct {
		uint8_t svid;
		const char *name;
	} cases[] = {
	    {1, "G01"},   {37, "G37"},  {38, "R01"},   {61, "R24"},   {63, "R25"},   {68, "R30"},
	    {71, "E01"},  {106, "E36"}, {120, "S120"}, {140, "S140"}, {141, "C01"},  {180, "C40"},
	    {181, "J01"}, {190, "J10"}, {191, "I01"},  {197, "I07"},  {198, "S141"}, {215, "S158"},
	    {216, "I08"}, {222, "I14"}, {223, "C41"},  {245, "C63"},
	};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		assert_string_equal(fw_sbf_satellite(cases[i].svid), cases[i].name);
		assert_int_equal(fw_sbf_svid(cases[i].name), cases[i].svid);
	}
	static const uint8_t nameless[] = {0, 62, 69, 70, 107, 119, 246, 255};
	for (size_t i = 0; i < sizeof nameless; i++)
		assert_null(fw_sbf_satellite(nameless[i]));
	assert_int_equal(fw_sbf_svid("G38"), 0);
	assert_int_equal(fw_sbf_svid(""), 0);
}

static void every_name_leads_back(void **state)
{
	(void)state;
	for (unsigned svid = 0; svid < 256; svid++)
		if (fw_sbf_satellite((uint8_t)svid) != NULL)
			assert_int_equal(fw_sbf_svid(fw_sbf_satellite((uint8_t)svid)), svid);
}

static void signals(void **state)
{
	(void)state;
	static const struct {
		unsigned number;
		char system;
		const char *rinex;
		double mhz;
	} cases[] = {
	    {0, 'G', "1C", 1575.42},   {2, 'G', "2W", 1227.60},  {4, 'G', "5Q", 1176.45},
	    {8, 'R', "1C", 1602},      {11, 'R', "2C", 1246},    {12, 'R', "3Q", 1202.025},
	    {19, 'E', "6C", 1278.75},  {20, 'E', "5Q", 1176.45}, {21, 'E', "7Q", 1207.14},
	    {22, 'E', "8Q", 1191.795}, {25, 'S', "5I", 1176.45}, {28, 'C', "2I", 1561.098},
	    {30, 'C', "6I", 1268.52},  {34, 'C', "7D", 1207.14}, {38, 'J', "1E", 1575.42},
	};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		const fw_sbf_signal *s = fw_sbf_signal_of(cases[i].number);
		assert_non_null(s);
		assert_int_equal(s->system, cases[i].system);
		assert_string_equal(s->rinex, cases[i].rinex);
		assert_true(fabs(s->frequency_hz - cases[i].mhz * 1e6) < 1e-3);
	}
	assert_true(fabs(fw_sbf_signal_of(8)->channel_spacing_hz - 9e6 / 16) < 1e-6);
	assert_true(fabs(fw_sbf_signal_of(10)->channel_spacing_hz - 7e6 / 16) < 1e-6);
	static const unsigned unknown[] = {16, 18, 31, 35, 36, 40, 63, 1000};
	for (size_t i = 0; i < sizeof unknown / sizeof unknown[0]; i++)
		assert_null(fw_sbf_signal_of(unknown[i]));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(satellites),
	    cmocka_unit_test(every_name_leads_back),
	    cmocka_unit_test(signals),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
