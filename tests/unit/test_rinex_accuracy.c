/* Accuracy indices. IS-GPS-200N 20.3.3.3.1.3; Galileo OS SIS ICD 2.1, table 89. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "formats/rinex_accuracy.h"

static void ura(void **state)
{
	(void)state;
	assert_int_equal(fw_ura_index(0), 0);
	assert_int_equal(fw_ura_index(2.4), 0);
	assert_int_equal(fw_ura_index(2.41), 1);
	assert_int_equal(fw_ura_index(6144), 14);
	assert_int_equal(fw_ura_index(6144.1), 15);
	assert_int_equal(fw_ura_index(-1), 15);
	assert_int_equal(fw_ura_index((double)NAN), 15);
	for (int i = 0; i < 15; i++)
		assert_int_equal(fw_ura_index(fw_ura_m(i)), i);
	assert_int_equal(fw_ura_index(fw_ura_m(15)), 15);
}

static void sisa(void **state)
{
	(void)state;
	assert_true(fw_sisa_m(49) == 49 * 0.01 && fw_sisa_m(50) == 0.5 && fw_sisa_m(75) == 1 &&
	            fw_sisa_m(125) == 6);
	assert_int_equal(fw_sisa_index(3.12), 107);
	for (int i = 0; i <= 125; i++)
		assert_int_equal(fw_sisa_index(fw_sisa_m(i)), i);
	assert_int_equal(fw_sisa_index(-1), -1);
	assert_int_equal(fw_sisa_index(7), -1);
	assert_int_equal(fw_sisa_index((double)NAN), -1);
	assert_true(fw_sisa_m(126) < 0);
	assert_true(fw_sisa_m(-1) < 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(ura), cmocka_unit_test(sisa)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
