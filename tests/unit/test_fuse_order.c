#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../cli/fuse_order.h"
#include "base/random.h"

static fuse_order order;

static fuse_entry item_at(int64_t ns, fw_item_kind kind, uint64_t number)
{
	return (fuse_entry){.item = {.time = {ns}, .kind = kind, .mark = {number}}};
}

static fuse_entry imu_at(int64_t ns)
{
	return (fuse_entry){.is_imu = true, .imu = {.time = {ns}}};
}

static void test_in_order_of_time(void **state)
{
	fw_random r;
	int64_t last = INT64_MIN;
	(void)state;
	fw_random_init(&r, 1);
	order = (fuse_order){0};
	assert_null(fuse_order_first(&order));
	for (int round = 0; round < 3; round++) {
		for (int i = 0; i < 2000; i++) {
			const fuse_entry e = imu_at(round * 10000 + (int64_t)fw_random_below(&r, 10000));
			fuse_order_put(&order, &e);
		}
		while (order.n > 0) {
			const int64_t now = fuse_entry_time(fuse_order_first(&order)).ns;
			assert_true(now >= last);
			last = now;
			fuse_order_drop(&order);
		}
	}
	assert_true(order.slots <= 2000); /* places are used again */
}

/* Of one moment: levels, then everything else as it came, then the IMU. */
static void test_ranks(void **state)
{
	const fuse_entry in[] = {imu_at(5), item_at(5, FW_ITEM_FIX, 1), item_at(5, FW_ITEM_MARK, 2),
	                         item_at(5, FW_ITEM_LEVELS, 3), item_at(5, FW_ITEM_FIX, 4)};
	static const fw_item_kind kinds[] = {FW_ITEM_LEVELS, FW_ITEM_FIX, FW_ITEM_MARK, FW_ITEM_FIX};
	static const uint64_t numbers[] = {3, 1, 2, 4};
	(void)state;
	order = (fuse_order){0};
	for (int i = 0; i < 5; i++)
		fuse_order_put(&order, &in[i]);
	for (int i = 0; i < 4; i++) {
		const fuse_entry *e = fuse_order_first(&order);
		assert_false(e->is_imu);
		assert_int_equal(e->item.kind, kinds[i]);
		assert_int_equal(e->item.mark.number, numbers[i]);
		fuse_order_drop(&order);
	}
	assert_true(fuse_order_first(&order)->is_imu);
}

static void test_full(void **state)
{
	(void)state;
	order = (fuse_order){0};
	for (int i = 0; i < FUSE_ORDER; i++) {
		const fuse_entry e = imu_at(FUSE_ORDER - i);
		fuse_order_put(&order, &e);
	}
	assert_int_equal(order.n, FUSE_ORDER);
	for (int i = 1; i <= FUSE_ORDER; i++) {
		assert_int_equal(fuse_entry_time(fuse_order_first(&order)).ns, i);
		fuse_order_drop(&order);
	}
	assert_null(fuse_order_first(&order));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_in_order_of_time),
	    cmocka_unit_test(test_ranks),
	    cmocka_unit_test(test_full),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
