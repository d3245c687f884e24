/* The integrity state over random epochs, rules and gaps: what must hold whatever comes. */
#include "integrity/state_machine.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/random.h"

#define S FW_NS_PER_S

enum { RUNS = 2000, EPOCHS = 300 };

static double random_level(fw_random *r)
{
	static const double odd[] = {0, -1, (double)NAN, (double)INFINITY, -(double)INFINITY, 5e-324, 10, 20};
	const uint64_t which = fw_random_below(r, 40);
	return which < sizeof odd / sizeof odd[0] ? odd[which] : 14 * fw_random_uniform(r);
}

static fw_integrity_epoch random_epoch(fw_random *r)
{
	return (fw_integrity_epoch){.position = fw_random_below(r, 15) > 0,
	                            .sbas = fw_random_below(r, 10) > 0,
	                            .hpl_m = random_level(r),
	                            .vpl_m = random_level(r)};
}

static fw_integrity_rules random_rules(fw_random *r)
{
	return (fw_integrity_rules){
	    .hal_m = 10,
	    .val_m = 12,
	    .margin = fw_random_below(r, 2) ? 0 : 0.9 * fw_random_uniform(r),
	    .hold_ns = fw_random_below(r, 2) ? 0 : (int64_t)fw_random_below(r, 10) * S / 2,
	    .alert_ns = fw_random_below(r, 2) ? 0 : (int64_t)fw_random_below(r, 10) * S / 2,
	    .timeout_ns = (int64_t)(1 + fw_random_below(r, 8)) * S / 2};
}

static int bounded(const fw_integrity_rules *rules, const fw_integrity_epoch *e)
{
	return e->position && e->sbas && e->hpl_m <= rules->hal_m && e->vpl_m <= rules->val_m &&
	       e->hpl_m > 0 && e->vpl_m > 0;
}

/* Transitions chain, in the order of time, each to another state and by a cause that belongs to it. */
static void check_transition(const fw_transition *t, const fw_transition *before)
{
	static const unsigned causes[] = {
	    [FW_RELIABLE] = 1U << FW_CAUSE_WITHIN_LIMITS,
	    [FW_NO_SBAS] = 1U << FW_CAUSE_NO_SBAS | 1U << FW_CAUSE_NO_LEVELS | 1U << FW_CAUSE_MARGIN,
	    [FW_UNRELIABLE] =
	        1U << FW_CAUSE_HPL | 1U << FW_CAUSE_VPL | 1U << FW_CAUSE_HPL_VPL | 1U << FW_CAUSE_MARGIN,
	    [FW_NO_POSITION] = 1U << FW_CAUSE_NO_POSITION | 1U << FW_CAUSE_TIMEOUT};
	assert_int_equal(t->from, before->to);
	assert_int_not_equal(t->to, t->from);
	assert_true(t->time.ns >= before->time.ns);
	assert_true(causes[t->to] >> t->cause & 1);
}

static void one_run(fw_random *r)
{
	const fw_integrity_rules rules = random_rules(r);
	fw_integrity m;
	fw_transition t, before = {.to = FW_NO_POSITION};
	fw_time now = {1000 * S}, last_bounded = {0}, last = now;
	assert_int_equal(fw_integrity_init(&rules, &m), FW_OK);
	for (int i = 0; i < EPOCHS; i++) {
		const fw_integrity_epoch e = random_epoch(r);
		now.ns += (int64_t)(1 + fw_random_below(r, fw_random_below(r, 20) > 0 ? 3 : 20)) * S / 2;
		while (fw_integrity_expire(&m, now, &t)) {
			check_transition(&t, &before);
			assert_true(t.time.ns < now.ns);
			before = t;
		}
		/* no epoch for longer than the timeout: no position */
		assert_true(i == 0 || now.ns - last.ns <= rules.timeout_ns || m.state == FW_NO_POSITION);
		assert_int_equal(fw_integrity_update(&m, now, &e, &t), FW_OK);
		if (t.from != t.to) {
			check_transition(&t, &before);
			before = t;
		}
		assert_int_equal(m.state, t.to);
		last = now;

		if (bounded(&rules, &e))
			last_bounded = now;
		/* RELIABLE never outlives bounded epochs by the time to alert, or at all when that is 0 */
		assert_true(m.state != FW_RELIABLE || bounded(&rules, &e) ||
		            (e.position && now.ns - last_bounded.ns < rules.alert_ns + rules.timeout_ns));
		assert_true(m.state != FW_RELIABLE || bounded(&rules, &e) || rules.alert_ns > 0);
		assert_true(e.position == (m.state != FW_NO_POSITION) || (e.position && rules.hold_ns > 0));
	}
}

static void invariants(void **state)
{
	(void)state;
	fw_random r;
	fw_random_init(&r, 20260610);
	for (int i = 0; i < RUNS; i++)
		one_run(&r);
}

/* Larger levels never make a better state: the same epochs with all levels raised, without hysteresis. */
static void monotone(void **state)
{
	(void)state;
	fw_random r;
	fw_random_init(&r, 3);
	const fw_integrity_rules rules = {.hal_m = 10, .val_m = 12, .timeout_ns = S};
	fw_integrity a, b;
	fw_transition t;
	assert_int_equal(fw_integrity_init(&rules, &a), FW_OK);
	assert_int_equal(fw_integrity_init(&rules, &b), FW_OK);
	for (int i = 0; i < 20000; i++) {
		fw_integrity_epoch e = random_epoch(&r);
		e.hpl_m = 1 + 14 * fw_random_uniform(&r);
		e.vpl_m = 1 + 14 * fw_random_uniform(&r);
		assert_int_equal(fw_integrity_update(&a, (fw_time){i * S}, &e, &t), FW_OK);
		e.hpl_m *= 1 + fw_random_uniform(&r);
		e.vpl_m *= 1 + fw_random_uniform(&r);
		assert_int_equal(fw_integrity_update(&b, (fw_time){i * S}, &e, &t), FW_OK);
		assert_true(b.state >= a.state);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(invariants),
	    cmocka_unit_test(monotone),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
