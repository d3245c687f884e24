#include "integrity/state_machine.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>

#define S FW_NS_PER_S

/* Sequences are written as one letter an epoch, a second apart: R within limits, m within them but not by the margin (of a
 * quarter), N no SBAS, L SBAS without levels, H V B a level too large (both: B), P no position, '.' no epoch. Expected is
 * the state after each: R N U P; worked out by hand from the rules in the header. */
static fw_integrity_epoch epoch_of(char letter)
{
	const double hpl = letter == 'H' || letter == 'B' ? 41 : letter == 'm' ? 35 : 10;
	const double vpl = letter == 'V' || letter == 'B' ? 50.001 : 20;
	return (fw_integrity_epoch){.position = letter != 'P',
	                            .sbas = letter != 'N' && letter != 'P',
	                            .hpl_m = letter == 'L' ? nan("") : hpl,
	                            .vpl_m = vpl};
}

static fw_integrity_rules rules_of(double hold_s, double alert_s)
{
	return (fw_integrity_rules){.hal_m = 40,
	                            .val_m = 50,
	                            .hold_ns = (int64_t)(hold_s * 1e9),
	                            .alert_ns = (int64_t)(alert_s * 1e9),
	                            .timeout_ns = 2 * S + S / 2};
}

/* The transitions of a run, as "second from to cause" lines. */
static char story[2000];
static size_t told;

static void tell(const fw_transition *t)
{
	if (t->from == t->to)
		return;
	told += (size_t)snprintf(story + told, sizeof story - told, "%g %s %s %s\n", (double)t->time.ns / 1e9,
	                         fw_integrity_state_name(t->from), fw_integrity_state_name(t->to),
	                         fw_integrity_cause_name(t->cause));
}

static void run(const fw_integrity_rules *rules, const char *epochs, char *states)
{
	static const char letters[] = {
	    [FW_RELIABLE] = 'R', [FW_NO_SBAS] = 'N', [FW_UNRELIABLE] = 'U', [FW_NO_POSITION] = 'P'};
	fw_integrity m;
	fw_transition t;
	story[told = 0] = '\0';
	assert_int_equal(fw_integrity_init(rules, &m), FW_OK);
	for (size_t i = 0; epochs[i] != '\0'; i++) {
		const fw_time now = {(int64_t)i * S};
		const fw_integrity_epoch e = epoch_of(epochs[i]);
		while (fw_integrity_expire(&m, now, &t))
			tell(&t);
		if (epochs[i] != '.') {
			assert_int_equal(fw_integrity_update(&m, now, &e, &t), FW_OK);
			tell(&t);
		}
		states[i] = letters[m.state];
		states[i + 1] = '\0';
	}
}

static void expect(const fw_integrity_rules *rules, const char *epochs, const char *wanted)
{
	char states[100];
	run(rules, epochs, states);
	assert_string_equal(states, wanted);
}

static void plain(void **state)
{
	(void)state;
	const fw_integrity_rules r = rules_of(0, 0);
	expect(&r, "RNLHVBPRmR", "RNNUUUPRRR");
	assert_string_equal(story, "0 NO_POSITION RELIABLE within-limits\n"
	                           "1 RELIABLE NO_SBAS no-sbas\n"
	                           "3 NO_SBAS UNRELIABLE hpl\n"
	                           "6 UNRELIABLE NO_POSITION no-position\n"
	                           "7 NO_POSITION RELIABLE within-limits\n");
	expect(&r, "VR", "UR");
	assert_string_equal(story, "0 NO_POSITION UNRELIABLE vpl\n1 UNRELIABLE RELIABLE within-limits\n");
	expect(&r, "RBL", "RUN");
	assert_string_equal(story, "0 NO_POSITION RELIABLE within-limits\n"
	                           "1 RELIABLE UNRELIABLE hpl-vpl\n"
	                           "2 UNRELIABLE NO_SBAS no-levels\n");
	expect(&r, "PPN", "PPN");
	assert_string_equal(story, "2 NO_POSITION NO_SBAS no-sbas\n");
}

/* Levels exactly at their limits are within them; what is no positive number is no level. */
static void limits(void **state)
{
	(void)state;
	static const struct {
		double hpl, vpl;
		fw_integrity_state wanted;
	} cases[] = {{40, 50, FW_RELIABLE},
	             {40.000001, 50, FW_UNRELIABLE},
	             {40, 50.000001, FW_UNRELIABLE},
	             {0, 10, FW_NO_SBAS},
	             {10, -1, FW_NO_SBAS},
	             {(double)NAN, 10, FW_NO_SBAS},
	             {10, (double)NAN, FW_NO_SBAS},
	             {(double)NAN, 1e9, FW_NO_SBAS},
	             {(double)INFINITY, 10, FW_UNRELIABLE}};
	const fw_integrity_rules r = rules_of(0, 0);
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		const fw_integrity_epoch e = {true, true, cases[i].hpl, cases[i].vpl};
		fw_integrity m;
		fw_transition t;
		assert_int_equal(fw_integrity_init(&r, &m), FW_OK);
		assert_int_equal(fw_integrity_update(&m, (fw_time){0}, &e, &t), FW_OK);
		assert_int_equal(m.state, cases[i].wanted);
	}
}

/* Better states wait three seconds, all of them better; what is entered is the worst of what was seen meanwhile. */
static void hold(void **state)
{
	(void)state;
	const fw_integrity_rules r = rules_of(3, 0);
	expect(&r, "RHRRRRR", "RUUUURR");
	expect(&r, "RHRRHRRRRR", "RUUUUUUURR");
	expect(&r, "RHRNRRRRRRR", "RUUUUNNNNRR");
	expect(&r, "HRRNP", "UUUUP");
	expect(&r, "RNRRRRPRRRRR", "RNNNNRPPPPRR");
}

/* Worse states wait four seconds, unless there is no position; a good epoch in between starts the count anew. */
static void time_to_alert(void **state)
{
	(void)state;
	const fw_integrity_rules r = rules_of(0, 4);
	expect(&r, "RHHHHHR", "RRRRRUR");
	expect(&r, "RHHHRHHHHH", "RRRRRRRRRU");
	expect(&r, "RNHNHNR", "RRRRRNR");
	expect(&r, "RHHPR", "RRRPR");
	/* NO_SBAS is worse than RELIABLE from the first epoch on, though better than what came first */
	expect(&r, "RBBBNN", "RRRRRN");
}

/* The alert is raised in time even if no epoch comes then. */
static void time_to_alert_between_epochs(void **state)
{
	(void)state;
	fw_integrity_rules r = rules_of(0, 1.5);
	expect(&r, "RH.H", "RRRU");
	assert_string_equal(story, "0 NO_POSITION RELIABLE within-limits\n2.5 RELIABLE UNRELIABLE hpl\n");
	r.timeout_ns = S + S / 4;
	expect(&r, "RH.H", "RRRU");
	assert_string_equal(story, "0 NO_POSITION RELIABLE within-limits\n"
	                           "2.25 RELIABLE NO_POSITION timeout\n"
	                           "3 NO_POSITION UNRELIABLE hpl\n");
}

static void margin(void **state)
{
	(void)state;
	fw_integrity_rules r = rules_of(0, 0);
	r.margin = 0.25;
	expect(&r, "RmmHmmRm", "RRRUUURR");
	expect(&r, "NmRm", "NNRR");
	expect(&r, "PmNm", "PNNN");
	assert_string_equal(story, "1 NO_POSITION NO_SBAS margin\n");
}

static void gaps(void **state)
{
	(void)state;
	fw_integrity_rules r = rules_of(0, 0);
	expect(&r, "...R.R...R....", "PPPRRRRRPRRRPP");
	assert_string_equal(story, "3 NO_POSITION RELIABLE within-limits\n"
	                           "7.5 RELIABLE NO_POSITION timeout\n"
	                           "9 NO_POSITION RELIABLE within-limits\n"
	                           "11.5 RELIABLE NO_POSITION timeout\n");
	r = rules_of(2, 0);
	expect(&r, "RHRR...RRRR", "RUUUUUPPPRR");
}

/* Epochs that are not after the one before are refused, and leave no trace. */
static void order(void **state)
{
	(void)state;
	const fw_integrity_rules r = rules_of(0, 0);
	const fw_integrity_epoch good = epoch_of('R'), bad = epoch_of('H');
	fw_integrity m;
	fw_transition t;
	assert_int_equal(fw_integrity_init(&r, &m), FW_OK);
	assert_int_equal(fw_integrity_update(&m, (fw_time){10 * S}, &good, &t), FW_OK);
	assert_int_equal(fw_integrity_update(&m, (fw_time){10 * S}, &bad, &t), FW_EINVAL);
	assert_int_equal(fw_integrity_update(&m, (fw_time){9 * S}, &bad, &t), FW_EINVAL);
	assert_int_equal(m.state, FW_RELIABLE);
	assert_true(fw_integrity_expire(&m, (fw_time){100 * S}, &t));
	assert_int_equal(t.time.ns, 12 * S + S / 2);
	assert_false(fw_integrity_expire(&m, (fw_time){200 * S}, &t));
	assert_int_equal(fw_integrity_update(&m, (fw_time){11 * S}, &good, &t), FW_EINVAL);
	assert_int_equal(fw_integrity_update(&m, (fw_time){13 * S}, &good, &t), FW_OK);
	assert_int_equal(t.from, FW_NO_POSITION);
	assert_int_equal(m.state, FW_RELIABLE);
}

/* After a restart any time will do; the state is the old one until the epoch says otherwise, at once. */
static void restart(void **state)
{
	(void)state;
	const fw_integrity_rules r = rules_of(5, 5);
	const fw_integrity_epoch good = epoch_of('R'), bad = epoch_of('H');
	fw_integrity m;
	fw_transition t;
	assert_int_equal(fw_integrity_init(&r, &m), FW_OK);
	assert_int_equal(fw_integrity_update(&m, (fw_time){1000 * S}, &good, &t), FW_OK);
	fw_integrity_restart(&m);
	assert_false(fw_integrity_expire(&m, (fw_time){9000 * S}, &t));
	assert_int_equal(fw_integrity_update(&m, (fw_time){10 * S}, &bad, &t), FW_OK);
	assert_int_equal(t.from, FW_RELIABLE);
	assert_int_equal(t.to, FW_UNRELIABLE);
	assert_int_equal(fw_integrity_update(&m, (fw_time){11 * S}, &good, &t), FW_OK);
	assert_int_equal(m.state, FW_UNRELIABLE);
	fw_integrity_restart(&m);
	assert_int_equal(fw_integrity_update(&m, (fw_time){2 * S}, &bad, &t), FW_OK);
	assert_int_equal(t.to, t.from);
	assert_int_equal(fw_integrity_update(&m, (fw_time){3 * S}, &bad, &t), FW_OK);
}

static void rules_out_of_range(void **state)
{
	(void)state;
	const fw_integrity_rules good = rules_of(0, 0);
	fw_integrity m = {.state = FW_NO_SBAS};
	for (int i = 0; i < 8; i++) {
		fw_integrity_rules r = good;
		switch (i) {
		case 0: r.hal_m = 0; break;
		case 1: r.val_m = nan(""); break;
		case 2: r.margin = 1; break;
		case 3: r.margin = -0.1; break;
		case 4: r.margin = nan(""); break;
		case 5: r.hold_ns = -1; break;
		case 6: r.alert_ns = -1; break;
		default: r.timeout_ns = 0; break;
		}
		assert_int_equal(fw_integrity_init(&r, &m), FW_EINVAL);
	}
	assert_int_equal(m.state, FW_NO_SBAS);
	assert_string_equal(fw_integrity_state_name((fw_integrity_state)0), "");
	assert_string_equal(fw_integrity_cause_name((fw_integrity_cause)99), "");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(plain),
	    cmocka_unit_test(limits),
	    cmocka_unit_test(hold),
	    cmocka_unit_test(time_to_alert),
	    cmocka_unit_test(time_to_alert_between_epochs),
	    cmocka_unit_test(margin),
	    cmocka_unit_test(gaps),
	    cmocka_unit_test(order),
	    cmocka_unit_test(restart),
	    cmocka_unit_test(rules_out_of_range),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
