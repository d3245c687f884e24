#include "integrity/stanford.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

/* The regions of the diagram, their borders included, read off the definitions in the header. */
static void every_region(void **state)
{
	static const struct {
		double error, pl, al;
		fw_stanford class;
	} cases[] = {
	    {1, 2, 3, FW_NOMINAL},
	    {2, 2, 2, FW_NOMINAL},
	    {0, 0, 0, FW_NOMINAL},
	    {2.5, 2, 3, FW_MISLEADING},
	    {3, 2, 3, FW_MISLEADING},
	    {3.1, 2, 3, FW_HAZARDOUS},
	    {3.1, 3, 3, FW_HAZARDOUS},
	    {1, 4, 3, FW_UNAVAILABLE},
	    {3.5, 4, 3, FW_UNAVAILABLE},
	    {4, 4, 3, FW_UNAVAILABLE},
	    {5, 4, 3, FW_UNAVAILABLE_MISLEADING},
	};

	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
		assert_int_equal(fw_stanford_class(cases[i].error, cases[i].pl, cases[i].al), cases[i].class);
}

static void without_limit_nothing_is_unavailable(void **state)
{
	(void)state;
	assert_int_equal(fw_stanford_class(1, 1e9, (double)INFINITY), FW_NOMINAL);
	assert_int_equal(fw_stanford_class(1e9, 1, (double)INFINITY), FW_MISLEADING);
}

static void not_a_number_is_never_nominal(void **state)
{
	(void)state;
	assert_int_equal(fw_stanford_class(nan(""), 2, 3), FW_HAZARDOUS);
	assert_int_equal(fw_stanford_class(1, nan(""), 3), FW_UNAVAILABLE_MISLEADING);
	assert_int_equal(fw_stanford_class(1, 2, nan("")), FW_UNAVAILABLE);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(every_region),
	    cmocka_unit_test(without_limit_nothing_is_unavailable),
	    cmocka_unit_test(not_a_number_is_never_nominal),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
