/* The loose recipe: what it refuses, bridges, gives up; that nothing that is not finite gets in; that it finds its way back. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/random.h"
#include "../flight.h"

static flight f;
static fw_loose l, clean;
static fw_imu imu;

static const double lever[3] = {0.1, 0, -0.3}, sd_m[3] = {0.5, 0.5, 1}, sd_mps[3] = {0.05, 0.05, 0.1};

static int make_flight(void **state)
{
	static const fw_waypoint w[] = {
	    {0, 0, 0, 0, 5},  {0, 0, 20, 3, 0},  {80, 0, 20, 6, 0},  {80, 80, 25, 6, 0}, {0, 80, 20, 6, 0},
	    {0, 0, 20, 6, 0}, {80, 0, 20, 6, 0}, {80, 80, 25, 6, 0}, {0, 80, 20, 6, 0},  {0, 0, 20, 6, 30}};
	const fw_trajectory_limits limits = {2, 3, 3, 3, 1, 3};
	(void)state;
	flight_make(&f, FW_VEHICLE_MULTIROTOR, &limits, sizeof w / sizeof w[0], w, 100, 100);
	return 0;
}

static fw_random noise;

static void start_with(fw_loose_options *o, const fw_loose_hooks *hooks)
{
	const double attitude[3] = {0.01, 0.01, 0.05}, velocity[3] = {0.05, 0.05, 0.1},
	             position[3] = {0.5, 0.5, 1};
	const fw_imu_model model = {.gyro = {.white = 4.4e-5, .bias_sd = 2e-4},
	                            .accel = {.white = 6e-4, .bias_sd = 0.01}};
	memcpy(o->lever_b, lever, sizeof lever);
	assert_int_equal(fw_loose_init(&l, o, hooks), FW_OK);
	assert_int_equal(fw_loose_start(&l, &f.truth[0], attitude, velocity, position, NULL, NULL), FW_OK);
	assert_int_equal(fw_imu_init(&model, 0.01, 77, &imu), FW_OK);
	fw_random_init(&noise, 3);
}

static void start(void)
{
	fw_loose_options o = fw_loose_defaults;
	start_with(&o, NULL);
}

/* An undisturbed fix of epoch k. */
static fw_item fix_at(int k)
{
	double e[3], v[3];
	for (int i = 0; i < 3; i++) {
		e[i] = sd_m[i] * fw_random_normal(&noise);
		v[i] = sd_mps[i] * fw_random_normal(&noise);
	}
	return flight_fix(&f, k, lever, e, v, sd_m, sd_mps);
}

/* Samples from..to, a fix every 20 of them; returns how many samples were not taken. */
static int fly(int from, int to)
{
	int refused = 0;
	for (int k = from; k <= to; k++) {
		if (k % 20 == 0) {
			const fw_item item = fix_at(k);
			fw_loose_item(&l, &item);
		}
		const fw_imu_reading s = flight_imu(&f, &imu, k);
		refused += fw_loose_imu(&l, &s) != FW_OK;
	}
	return refused;
}

/* How far off, in sigmas, the worst of the nine; and nothing may be NaN. */
static double worst(int k)
{
	double e[9], most = 0;
	flight_errors(&l.filter.pva, &f.truth[k], e);
	for (int i = 0; i < 9; i++) {
		assert_true(isfinite(e[i]) && isfinite(l.filter.P[i][i]) && l.filter.P[i][i] > 0);
		most = fmax(most, fabs(e[i]) / sqrt(l.filter.P[i][i]));
	}
	return most;
}

/* The largest difference to an undisturbed run, in sigmas of that. */
static double from_clean(void)
{
	double e[9], most = 0;
	flight_errors(&l.filter.pva, &clean.filter.pva, e);
	for (int i = 0; i < 9; i++)
		most = fmax(most, fabs(e[i]) / sqrt(clean.filter.P[i][i]));
	return most;
}

static void run_clean(int to)
{
	start();
	assert_int_equal(fly(1, to), 0);
	clean = l;
}

static void stays_on_the_path(void **state)
{
	(void)state;
	start();
	for (int k = 1; k <= 9000; k += 500) {
		assert_int_equal(fly(k, k + 499), 0);
		assert_true(worst(k + 499) < 4.5);
	}
	assert_int_equal(l.counts.samples, 9000);
	assert_int_equal(l.counts.used[FW_ITEM_FIX], 450);
	assert_true(fabs(l.counts.nis_sum / (double)l.counts.nis_rows - 1) < 0.15);
}

static void bad_samples_are_refused(void **state)
{
	(void)state;
	const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1e30, -1e30};
	run_clean(6000);
	for (int column = 0; column < 6; column++)
		for (size_t b = 0; b < sizeof bad / sizeof bad[0]; b++)
			for (int many = 1; many <= 50; many += 49) {
				start();
				fly(1, 2999);
				for (int k = 3000; k < 3000 + many; k++) {
					const bool with_fix = k % 20 == 0;
					if (with_fix) {
						const fw_item item = fix_at(k);
						fw_loose_item(&l, &item);
					}
					fw_imu_reading s = flight_imu(&f, &imu, k);
					(column < 3 ? s.gyro_radps : s.accel_mps2)[column % 3] = bad[b];
					assert_int_equal(fw_loose_imu(&l, &s), FW_DUBIOUS);
				}
				assert_int_equal(fly(3000 + many, 6000), 0);
				assert_int_equal(l.counts.samples_refused[FW_REFUSED_NOT_FINITE] +
				                     l.counts.samples_refused[FW_REFUSED_RANGE],
				                 many);
				assert_int_equal(l.counts.bridged, 1);
				assert_true(worst(6000) < 5);
				/* half a second of not knowing costs heading, and heading takes time to come back */
				assert_true(from_clean() < (many == 1 ? 0.1 : 3));
			}
}

static void times_are_in_order(void **state)
{
	(void)state;
	run_clean(6000);
	start();
	fly(1, 3000);
	fw_imu_reading s = {.time = f.truth[3000].time, .gyro_radps = {1, 1, 1}, .accel_mps2 = {5, 5, 5}};
	assert_int_equal(fw_loose_imu(&l, &s), FW_DUBIOUS);
	for (int k = 0; k < 10; k++) {
		s.time = f.truth[2500 + k].time;
		assert_int_equal(fw_loose_imu(&l, &s), FW_DUBIOUS);
	}
	s.time.ns = f.truth[3000].time.ns + FW_NS_PER_WEEK; /* one wrong stamp: a week ahead */
	assert_int_equal(fw_loose_imu(&l, &s), FW_DUBIOUS);
	assert_int_equal(fly(3001, 6000), 0);
	assert_int_equal(l.counts.samples_refused[FW_REFUSED_DUPLICATE], 1);
	assert_int_equal(l.counts.samples_refused[FW_REFUSED_BACKWARDS], 10);
	assert_int_equal(l.counts.samples_refused[FW_REFUSED_RANGE], 1);
	assert_true(from_clean() < 1e-9);
}

static void gaps(void **state)
{
	(void)state;
	static const int lost[] = {1, 10, 50, 99};
	for (size_t i = 0; i < sizeof lost / sizeof lost[0]; i++) {
		start();
		fly(1, 3000);
		assert_int_equal(fly(3001 + lost[i], 6100), 0);
		assert_true(worst(6100) < 5);
		assert_int_equal(l.counts.bridged, 1);
	}
	start();
	fly(1, 3000);
	fw_imu_reading s = flight_imu(&f, &imu, 3500);
	assert_int_equal(fw_loose_imu(&l, &s), FW_DUBIOUS); /* a gap or a wrong time? */
	s = flight_imu(&f, &imu, 3501);
	assert_int_equal(fw_loose_imu(&l, &s), FW_EUNKNOWN);
	assert_false(l.running);
	assert_int_equal(fw_loose_imu(&l, &s), FW_EUNKNOWN);
	assert_int_equal(l.counts.gaps, 1);
}

/* A fix that is wrong costs nothing, however sure it is of itself. */
static void wrong_fixes_are_refused(void **state)
{
	(void)state;
	enum { CASES = 9 };
	static const fw_refusal expected[CASES] = {
	    FW_REFUSED_RANGE, FW_REFUSED_NOT_FINITE, FW_REFUSED_SIGMA, FW_REFUSED_SIGMA, FW_REFUSED_SIGMA,
	    FW_REFUSED_GATE,  FW_REFUSED_NOT_FINITE, FW_REFUSED_RANGE, FW_REFUSED_SIGMA};
	run_clean(6000);
	for (int wrong = 0; wrong < CASES; wrong++) {
		start();
		fly(1, 2999);
		fw_item item = fix_at(3000);
		switch (wrong) {
		case 0:
			item.fix.llh[0] += 0.0174;
			item.fix.R_position[0][0] = 1e-4;
			break;
		case 1: item.fix.llh[2] = (double)NAN; break;
		case 2: item.fix.R_position[1][1] = 0; break;
		case 3: item.fix.R_position[1][1] = -1; break;
		case 4: item.fix.R_position[0][1] = item.fix.R_position[1][0] = 10; break;
		case 5: item.fix.llh[1] += 1e-5; break;
		case 6: item.fix.velocity_mps[0] = (double)INFINITY; break;
		case 7: item.fix.velocity_mps[0] = 1e30; break;
		default: item.fix.R_velocity[2][2] = 1e30; break;
		}
		fw_loose_item(&l, &item);
		const fw_imu_reading s = flight_imu(&f, &imu, 3000);
		assert_int_equal(fw_loose_imu(&l, &s), FW_OK);
		fly(3001, 6000);
		if (l.counts.refused[FW_ITEM_FIX][expected[wrong]] != 1)
			fail_msg("case %d: not refused as '%s'", wrong, fw_refusal_text(expected[wrong]));
		assert_true(from_clean() < 0.5);
	}
}

static void five_percent_outliers(void **state)
{
	(void)state;
	uint64_t sent = 0;
	start();
	fw_random_init(&noise, 9);
	for (int k = 1; k <= 9000; k++) {
		if (k % 20 == 0) {
			fw_item item = fix_at(k);
			if (fw_random_uniform(&noise) < 0.05) {
				item.fix.llh[0] += 5e-6 * (1 + fw_random_uniform(&noise));
				sent++;
			}
			fw_loose_item(&l, &item);
		}
		const fw_imu_reading s = flight_imu(&f, &imu, k);
		assert_int_equal(fw_loose_imu(&l, &s), FW_OK);
	}
	assert_true(sent > 10);
	assert_int_equal(l.counts.refused[FW_ITEM_FIX][FW_REFUSED_GATE], sent);
	assert_true(worst(9000) < 4.5);
}

static void items_keep_their_order(void **state)
{
	(void)state;
	start();
	fly(1, 100);
	fw_item item = fix_at(120), again = item, late = fix_at(60);
	fw_loose_item(&l, &item);
	fw_loose_item(&l, &again);
	fw_loose_item(&l, &late);
	item = fix_at(110);
	fw_loose_item(&l, &item);
	assert_int_equal(l.counts.refused[FW_ITEM_FIX][FW_REFUSED_DUPLICATE], 1);
	assert_int_equal(l.counts.refused[FW_ITEM_FIX][FW_REFUSED_BACKWARDS], 2);
	const fw_item heading = {.time = f.truth[50].time, .kind = FW_ITEM_HEADING, .heading = {1, 0.1}};
	fw_loose_item(&l, &heading);
	assert_int_equal(l.counts.refused[FW_ITEM_HEADING][FW_REFUSED_LATE], 1);
}

/* Fixes that all say the same other thing are believed in the end: the filter was wrong. */
static void many_against_one(void **state)
{
	(void)state;
	fw_loose_options o = fw_loose_defaults;
	o.gate_patience = 10;
	start_with(&o, NULL);
	fly(1, 2000);
	const double off[3] = {50e-6, 0, 0}; /* 320 m */
	fw_pva moved = l.filter.pva;
	moved.llh[0] += off[0];
	l.filter.pva = moved;
	fly(2001, 6000);
	assert_true(l.counts.refused[FW_ITEM_FIX][FW_REFUSED_GATE] >= 10);
	assert_true(l.counts.forced >= 1);
	assert_true(worst(6000) < 5);
}

/* Protection levels above the limit leave fixes out; when nobody renews them they are forgotten. */
static void integrity_steers(void **state)
{
	(void)state;
	fw_item levels = {.kind = FW_ITEM_LEVELS, .levels = {100, 100, FW_UNRELIABLE}};
	start();
	fly(1, 1000);
	const uint64_t used = l.counts.used[FW_ITEM_FIX];
	for (int k = 1001; k <= 1500; k++) {
		levels.time = f.truth[k].time;
		if (k % 20 == 0)
			fw_loose_item(&l, &levels);
		fly(k, k);
	}
	assert_int_equal(l.counts.used[FW_ITEM_FIX], used);
	assert_int_equal(l.counts.refused[FW_ITEM_FIX][FW_REFUSED_INTEGRITY], 25);
	fly(1501, 2000);
	assert_true(l.counts.used[FW_ITEM_FIX] > used + 10);
}

struct marks {
	int n;
	fw_time at[4];
};

static void on_mark(void *context, const fw_loose *now, uint64_t number)
{
	struct marks *m = context;
	(void)number;
	m->at[m->n++] = now->filter.pva.time;
}

/* An item between two samples divides the sample: a mark sees the state of its own time. */
static void samples_are_divided(void **state)
{
	(void)state;
	struct marks marks = {0};
	const fw_loose_hooks hooks = {.context = &marks, .mark = on_mark};
	fw_loose_options o = fw_loose_defaults;
	start_with(&o, &hooks);
	fly(1, 1000);
	fw_item mark = {.kind = FW_ITEM_MARK};
	mark.time.ns = f.truth[1000].time.ns + 3700000;
	fw_loose_item(&l, &mark);
	fly(1001, 1100);
	assert_int_equal(marks.n, 1);
	assert_true(marks.at[0].ns == mark.time.ns);
	assert_true(worst(1100) < 4.5);
	assert_int_equal(l.filter.pva.time.ns, f.truth[1100].time.ns);
}

static void options_are_checked(void **state)
{
	(void)state;
	fw_loose_options o = fw_loose_defaults;
	o.gyro_noise = 0;
	assert_int_equal(fw_loose_init(&l, &o, NULL), FW_EINVAL);
	o = fw_loose_defaults;
	o.lever_b[1] = (double)NAN;
	assert_int_equal(fw_loose_init(&l, &o, NULL), FW_EINVAL);
	o = fw_loose_defaults;
	o.gate = 1;
	assert_int_equal(fw_loose_init(&l, &o, NULL), FW_EINVAL);
}

/* A stamp a nanosecond after another says nothing about how often samples come: later ones are no gaps, and take no ages. */
static void two_samples_at_once(void **state)
{
	(void)state;
	for (int at = 0; at <= 3000; at += 3000) {
		start();
		fly(1, at);
		fw_imu_reading s = flight_imu(&f, &imu, at + 1);
		assert_int_equal(fw_loose_imu(&l, &s), FW_OK);
		s.time.ns++;
		assert_int_equal(fw_loose_imu(&l, &s), FW_OK);
		assert_int_equal(fly(at + 2, at + 3000), 0);
		assert_true(l.counts.bridged <= 1);
		assert_true(worst(at + 3000) < 5);
	}
}

static void dead_sensors(void **state)
{
	(void)state;
	fw_imu_reading s = {.gyro_radps = {0, 0, 0},
	                    .accel_mps2 = {0, 0.1, -9.8}}; /* coarse steps, at rest */
	assert_int_equal(fw_examine_reading(&s, 60, 500), FW_REFUSED_COUNT);
	s.accel_mps2[0] = 0.2; /* a fall, but one that is felt */
	s.accel_mps2[2] = -0.1;
	assert_int_equal(fw_examine_reading(&s, 60, 500), FW_REFUSED_COUNT);
	s.accel_mps2[2] = -0.0;
	assert_int_equal(fw_examine_reading(&s, 60, 500), FW_REFUSED_RANGE);
	s.accel_mps2[2] = -9.8;
	s.gyro_radps[1] = 1e-310;
	assert_int_equal(fw_examine_reading(&s, 60, 500), FW_REFUSED_RANGE);
}

/* A hundred fixes somewhere else are a fault of the receiver; three hundred say that the filter is not where it thinks. */
static void strayed(void **state)
{
	(void)state;
	start();
	fly(1, 1000);
	l.filter.pva.llh[0] += 0.01; /* 64 km */
	assert_int_equal(fly(1001, 3000), 0);
	assert_int_equal(l.counts.refused[FW_ITEM_FIX][FW_REFUSED_RANGE], 100);
	fly(3001, 9000);
	assert_false(l.running);
	assert_int_equal(l.counts.strayed, 1);
	assert_int_equal(l.counts.refused[FW_ITEM_FIX][FW_REFUSED_RANGE], 300);
}

/* The zero of the barometer came from a reading that was wrong: it is learnt anew. */
static void wrong_first_height(void **state)
{
	(void)state;
	fw_loose_options o = fw_loose_defaults;
	o.height_sd_m = 1;
	start_with(&o, NULL);
	for (int k = 1; k <= 3000; k++) {
		const fw_item height = {.time = f.truth[k].time,
		                        .kind = FW_ITEM_HEIGHT,
		                        .height.height_m = k == 20 ? 2000 : f.truth[k].llh[2]};
		if (k % 20 == 0)
			fw_loose_item(&l, &height);
		fly(k, k);
	}
	assert_int_equal(l.counts.refused[FW_ITEM_HEIGHT][FW_REFUSED_GATE], o.gate_patience);
	assert_int_equal(l.counts.used[FW_ITEM_HEIGHT], 150 - o.gate_patience);
	assert_true(worst(3000) < 5);
}

/* Level and straight on at constant speed an IMU feels what it feels at rest. When the filter has lost its speed, too, it is not
 * to be taken for rest. */
static void cruise_is_no_rest(void **state)
{
	(void)state;
	const double attitude[3] = {0.001, 0.001, 0.01}, velocity[3] = {5, 5, 5}, position[3] = {1, 1, 1};
	const double still[3] = {0}, down = -9.81;
	fw_loose_options o = fw_loose_defaults;
	fw_pva slow = f.truth[0];
	memcpy(slow.velocity_mps, still, sizeof still);
	assert_int_equal(fw_loose_init(&l, &o, NULL), FW_OK);
	assert_int_equal(fw_loose_start(&l, &slow, attitude, velocity, position, NULL, NULL), FW_OK);
	for (int k = 1; k <= 500; k++) {
		const fw_imu_reading s = {.time = f.truth[k].time, .accel_mps2 = {0, 0, down}};
		assert_int_equal(fw_loose_imu(&l, &s), FW_OK);
	}
	assert_true(l.stillness.still);
	assert_int_equal(l.counts.still, 0);
	assert_true(l.filter.P[3][3] > 20);
}

/* Levels that cannot be are none, but what the record says of the state stands. */
static void impossible_levels(void **state)
{
	(void)state;
	fw_item levels = {.kind = FW_ITEM_LEVELS, .levels = {1e30, 10, FW_UNRELIABLE}};
	start();
	fly(1, 99);
	levels.time = f.truth[100].time;
	fw_loose_item(&l, &levels);
	fly(100, 100);
	assert_int_equal(l.counts.refused[FW_ITEM_LEVELS][FW_REFUSED_RANGE], 1);
	assert_false(l.levels.known);
	assert_int_equal(l.integrity, FW_UNRELIABLE);
}

/* Before a run items are judged by what they say, and come out with the covariance of the options. */
static void usable_items(void **state)
{
	(void)state;
	fw_loose_options o = fw_loose_defaults;
	start();
	fw_item item = fix_at(100);
	assert_true(fw_loose_usable(&l, &item));
	item.fix.R_position[0][0] = 0;
	assert_false(fw_loose_usable(&l, &item));
	assert_int_equal(l.counts.refused[FW_ITEM_FIX][FW_REFUSED_SIGMA], 1);
	for (int i = 0; i < 3; i++)
		o.position_sd[i] = 2;
	start_with(&o, NULL);
	assert_true(fw_loose_usable(&l, &item));
	assert_true(item.fix.R_position[0][0] == 4);
}

/* The log ends before it is known whether its last sample came after a gap or has a wrong time. */
static void the_end(void **state)
{
	(void)state;
	start();
	fly(1, 100);
	fw_imu_reading s = flight_imu(&f, &imu, 5000);
	assert_int_equal(fw_loose_imu(&l, &s), FW_DUBIOUS);
	fw_loose_end(&l);
	fw_loose_end(&l);
	assert_int_equal(l.counts.samples_refused[FW_REFUSED_RANGE], 1);
}

/* The factors of the paper, by hand: HPL 10 of 20, VPL 50 of 25. */
static void factors_of_the_paper(void **state)
{
	(void)state;
	fw_adapt_options o = fw_loose_defaults.adapt;
	const fw_levels levels = {true, 10, 50}, unknown = {0};
	o.tau1 = 2;
	o.tau2 = 3;
	o.tau3 = 5;
	o.tau4 = 7;
	fw_adapt_factors k = fw_adapt_by_levels(&o, &levels);
	assert_true(fabs(k.r_h - 0.25) < 1e-15 && fabs(k.r_v - 6) < 1e-15 && fabs(k.q - 14) < 1e-14);
	k = fw_adapt_by_levels(&o, &(fw_levels){true, 40, 10});
	assert_true(fabs(k.r_h - 6) < 1e-15 && fabs(k.r_v - 0.2) < 1e-15 && fabs(k.q - 0.1) < 1e-15);
	k = fw_adapt_by_levels(&o, &unknown);
	assert_true(k.r_h == 1 && k.r_v == 1 && k.q == 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(stays_on_the_path),
	    cmocka_unit_test(bad_samples_are_refused),
	    cmocka_unit_test(times_are_in_order),
	    cmocka_unit_test(gaps),
	    cmocka_unit_test(wrong_fixes_are_refused),
	    cmocka_unit_test(five_percent_outliers),
	    cmocka_unit_test(items_keep_their_order),
	    cmocka_unit_test(many_against_one),
	    cmocka_unit_test(integrity_steers),
	    cmocka_unit_test(samples_are_divided),
	    cmocka_unit_test(options_are_checked),
	    cmocka_unit_test(factors_of_the_paper),
	    cmocka_unit_test(two_samples_at_once),
	    cmocka_unit_test(dead_sensors),
	    cmocka_unit_test(strayed),
	    cmocka_unit_test(wrong_first_height),
	    cmocka_unit_test(cruise_is_no_rest),
	    cmocka_unit_test(impossible_levels),
	    cmocka_unit_test(usable_items),
	    cmocka_unit_test(the_end),
	};
	return cmocka_run_group_tests(tests, make_flight, NULL);
}
