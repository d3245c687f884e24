#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "../../cli/fuse_compass.h"
#include "base/frame.h"
#include "base/matrix.h"
#include "base/random.h"
#include "ins/magnetic_field.h"

#define near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static void test_parse(void **state)
{
	static const char *const wrong[] = {"",
	                                    "logs",
	                                    "1,2,3",
	                                    "1,2,3,4,5,6,7,8,9,10,11,12,13",
	                                    "1,2,3,4,5,6,7,8,9,10,11,x",
	                                    "1,2,3,4,5,6,7,8,9,10,11,",
	                                    "1,2,3,4,5,6,7,8,9,10,11,1e30"};
	fuse_compass_way way = FUSE_COMPASS_AS_IT_IS;
	fw_mag_calibration cal = {0}, again = {0};
	char text[200];
	(void)state;
	for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
		assert_false(fuse_compass_parse(wrong[i], &way, &cal));
	assert_int_equal(way, FUSE_COMPASS_AS_IT_IS);
	assert_true(fuse_compass_parse("log", &way, &cal));
	assert_int_equal(way, FUSE_COMPASS_LOG);
	assert_true(fuse_compass_parse("turning", &way, &cal));
	assert_int_equal(way, FUSE_COMPASS_TURNING);
	assert_true(fuse_compass_parse("1,-2,3.5,1,0.1,0,0.1,0.9,0,0,0,1.1", &way, &cal));
	assert_int_equal(way, FUSE_COMPASS_GIVEN);
	assert_true(cal.offset[1] == -2 && cal.matrix[0][1] == 0.1 && cal.matrix[2][2] == 1.1);
	fuse_compass_print(&cal, text, sizeof text);
	assert_true(fuse_compass_parse(text, &way, &again));
	assert_memory_equal(&cal.matrix, &again.matrix, sizeof cal.matrix);
	assert_memory_equal(&cal.offset, &again.offset, sizeof cal.offset);
}

/* Readings with known iron and the attitudes of their times: the iron is found, by either way. */
static void test_solve(void **state)
{
	static const double hard[3] = {6, -4, 3}, soft[3] = {1.05, 0.97, 1};
	static fuse_compass c;
	static fw_loose l;
	fw_mag_calibration cal;
	double earth[3];
	fw_random r;
	(void)state;
	l.filter.pva = (fw_pva){.time = {2400 * FW_NS_PER_WEEK}, .llh = {0.9, 0.2, 100}};
	assert_int_equal(fw_magnetic_field(l.filter.pva.llh, l.filter.pva.time, earth), FW_OK);
	fw_random_init(&r, 1);
	fuse_compass_begin(&c, (double)NAN);
	assert_int_equal(fuse_compass_solve(&c, FUSE_COMPASS_LOG, &cal), FW_MORE);
	for (int i = 0; i < 2000; i++) {
		const double rpy[3] = {0.6 * sin(i * 0.11), 0.5 * sin(i * 0.07), i * 0.03};
		double C[3][3], b[3];
		fw_item item = {.time = l.filter.pva.time, .kind = FW_ITEM_FIELD};
		fw_euler_to_matrix(rpy, C);
		fw_euler_to_quat(rpy, l.filter.pva.q_n_b);
		fw_mat3_t_vec(C, earth, b);
		for (int k = 0; k < 3; k++)
			item.field.b_ut[k] = soft[k] * b[k] * 1e-3 + hard[k] + 0.05 * fw_random_normal(&r);
		fuse_compass_item(&c, &item);
		fuse_compass_attitude(&c, &l);
		l.filter.pva.time.ns += 100000000;
	}
	for (int way = FUSE_COMPASS_TURNING; way <= FUSE_COMPASS_LOG; way++) {
		assert_int_equal(fuse_compass_solve(&c, (fuse_compass_way)way, &cal), FW_OK);
		for (int k = 0; k < 3; k++) {
			/* The ellipsoid is seen from near its equator only: its height is less sure. */
			near(cal.offset[k], hard[k], way == FUSE_COMPASS_TURNING && k == 2 ? 1 : 0.1);
			near(cal.matrix[k][k], 1 / soft[k], 0.012);
		}
	}
	assert_true(cal.heading_sd_rad < 0.02);
}

/* Once the vehicle has gone off, its readings are no ground calibration any more. */
static void test_gone(void **state)
{
	static fuse_compass c;
	fw_item fix = {.kind = FW_ITEM_FIX}, field = {.kind = FW_ITEM_FIELD, .field.b_ut = {20, 0, 40}};
	(void)state;
	fuse_compass_begin(&c, (double)NAN);
	fix.fix.has_velocity = true;
	fix.fix.velocity_mps[0] = 1;
	fuse_compass_item(&c, &fix);
	fuse_compass_item(&c, &field);
	assert_true(c.turning.n == 1);
	fix.fix.velocity_mps[0] = 3;
	fuse_compass_item(&c, &fix);
	fuse_compass_item(&c, &field);
	assert_true(c.turning.n == 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(test_parse),
	    cmocka_unit_test(test_solve),
	    cmocka_unit_test(test_gone),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
