#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdlib.h>

#include "../../cli/fuse_store.h"

typedef struct {
	uint64_t number;
	double more[36];
} record;

enum { N = 30000 }; /* 8.9 MB */

static void fill(fuse_store *s)
{
	for (uint64_t i = 0; i < N; i++) {
		record *r = fuse_store_add(s);
		assert_non_null(r);
		assert_true(r->number == 0 && r->more[35] == 0);
		r->number = i;
		r->more[35] = (double)i / 2;
	}
	assert_int_equal(s->n, N);
}

static void look(fuse_store *s, uint64_t i)
{
	const record *r = fuse_store_at(s, i);
	assert_non_null(r);
	assert_true(r->number == i && r->more[35] == (double)i / 2);
}

/* All records come back, forwards, backwards and in leaps, wherever they are kept. */
static void come_and_go(uint64_t memory, uint64_t in_file_at_least)
{
	fuse_budget budget;
	fuse_store s;
	fuse_budget_begin(&budget, memory);
	fuse_store_begin(&s, &budget, sizeof(record));
	for (int round = 0; round < 2; round++) {
		fill(&s);
		assert_true(budget.in_file >= in_file_at_least);
		assert_true(in_file_at_least > 0 || budget.fd < 0);
		for (uint64_t i = 0; i < N; i++)
			look(&s, i);
		for (uint64_t i = N; i-- > 0;)
			look(&s, i);
		for (uint64_t i = 0; i < 2000; i++)
			look(&s, i * 7919 % N);
		fuse_store_end(&s);
		assert_int_equal(budget.in_memory + budget.in_file, 0);
		assert_int_equal(budget.memory_left, memory);
	}
	assert_int_equal(budget.error, 0);
	assert_true(budget.most >= N * sizeof(record));
	fuse_budget_end(&budget);
}

static void test_in_memory(void **state)
{
	(void)state;
	come_and_go(64 << 20, 0);
}

static void test_in_file(void **state)
{
	(void)state;
	come_and_go(0, N * sizeof(record));
	come_and_go(4 << 20, 4 << 20);
}

/* Two lists share the budget and the file. */
static void test_two(void **state)
{
	fuse_budget budget;
	fuse_store s[2];
	(void)state;
	fuse_budget_begin(&budget, 1 << 20);
	fuse_store_begin(&s[0], &budget, sizeof(record));
	fuse_store_begin(&s[1], &budget, sizeof(uint64_t));
	for (uint64_t i = 0; i < N; i++) {
		record *r = fuse_store_add(&s[0]);
		uint64_t *n = fuse_store_add(&s[1]);
		assert_non_null(r);
		assert_non_null(n);
		*r = (record){.number = i, .more = {[35] = (double)i / 2}};
		*n = 3 * i;
	}
	for (uint64_t i = 0; i < N; i++) {
		look(&s[0], i);
		assert_int_equal(*(const uint64_t *)fuse_store_at(&s[1], i), 3 * i);
	}
	fuse_store_end(&s[0]);
	fuse_store_end(&s[1]);
	fuse_budget_end(&budget);
}

static void test_no_file(void **state)
{
	fuse_budget budget;
	fuse_store s;
	(void)state;
	setenv("TMPDIR", "/nowhere", 1);
	fuse_budget_begin(&budget, 0);
	fuse_store_begin(&s, &budget, sizeof(record));
	assert_null(fuse_store_add(&s));
	assert_int_equal(budget.error, ENOENT);
	assert_null(fuse_store_add(&s));
	fuse_store_end(&s);
	fuse_budget_end(&budget);
	unsetenv("TMPDIR");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_in_memory),
	    cmocka_unit_test(test_in_file),
	    cmocka_unit_test(test_two),
	    cmocka_unit_test(test_no_file),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
