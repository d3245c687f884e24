/* status: every value has words of its own, and no number is without words. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "base/status.h"

static void every_status_has_its_own_text(void **state)
{
	(void)state;
	for (int a = FW_ENOSPACE; a <= FW_MORE; a++) {
		assert_string_not_equal(fw_status_text((fw_status)a), "");
		assert_string_not_equal(fw_status_text((fw_status)a), "unknown status");
		for (int b = FW_ENOSPACE; b < a; b++)
			assert_string_not_equal(fw_status_text((fw_status)a), fw_status_text((fw_status)b));
	}
}

static void other_numbers_are_unknown(void **state)
{
	(void)state;
	assert_string_equal(fw_status_text((fw_status)(FW_ENOSPACE - 1)), "unknown status");
	assert_string_equal(fw_status_text((fw_status)(FW_MORE + 1)), "unknown status");
	assert_string_equal(fw_status_text((fw_status)INT32_MIN), "unknown status");
}

static void signs_tell_done_from_not_done(void **state)
{
	(void)state;
	assert_int_equal(FW_OK, 0);
	assert_true(FW_EOF > 0 && FW_DUBIOUS > 0 && FW_MORE > 0);
	assert_true(FW_EINVAL < 0 && FW_ENOSPACE < 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(every_status_has_its_own_text),
	    cmocka_unit_test(other_numbers_are_unknown),
	    cmocka_unit_test(signs_tell_done_from_not_done),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
