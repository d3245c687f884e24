/* window: what lies ahead is what the input has, however it is asked for. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "formats/window.h"

static fw_input input;
static fw_window window;

static void bytes_come_in_order(void **state)
{
	enum { N = 700000 };
	static uint8_t bytes[N];
	size_t at = 0;

	(void)state;
	for (size_t i = 0; i < N; i++)
		bytes[i] = (uint8_t)(i * 2654435761U >> 13);
	fw_input_open_memory(&input, bytes, N);
	fw_window_begin(&window, &input);
	for (size_t step = 1; fw_window_need(&window, step); step = step * 7 % 100003) {
		assert_true(window.n >= step);
		assert_int_equal(window.offset, at);
		assert_memory_equal(window.bytes, bytes + at, step);
		fw_window_skip(&window, step);
		at += step;
	}
	assert_int_equal(window.status, FW_EOF);
	assert_memory_equal(window.bytes, bytes + at, window.n);
	assert_int_equal(at + window.n, N);
}

static void the_most_that_can_be_asked_for_is_there(void **state)
{
	static const uint8_t bytes[3 * FW_WINDOW_MOST];

	(void)state;
	fw_input_open_memory(&input, bytes, sizeof bytes);
	fw_window_begin(&window, &input);
	for (int i = 0; i < 10; i++) {
		assert_true(fw_window_need(&window, FW_WINDOW_MOST));
		fw_window_skip(&window, 12345);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(bytes_come_in_order),
	    cmocka_unit_test(the_most_that_can_be_asked_for_is_there),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
