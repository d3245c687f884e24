/* A sky that is made here: satellites at chosen azimuths and elevations, codes computed from the geometry with the whole
 * rotation of the Earth, so that the right answer is known exactly. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "base/random.h"
#include "gnss/single_point.h"

static const fw_time tag = {1400000000LL * FW_NS_PER_S};
static const double place_llh[3] = {0.8876, 0.0826, 120.0};
static const double moving_ned[3] = {12.0, -7.5, 1.25};

static const struct {
	uint8_t system;
	double azimuth, elevation; /* degrees */
} sky[] = {
    {FW_GPS, 10, 70},      {FW_GPS, 95, 35},      {FW_GPS, 170, 25},     {FW_GPS, 230, 50},
    {FW_GPS, 300, 15},     {FW_GPS, 340, 40},     {FW_GALILEO, 40, 20},  {FW_GALILEO, 130, 60},
    {FW_GALILEO, 200, 33}, {FW_GALILEO, 275, 45}, {FW_GALILEO, 320, 80}, {FW_GALILEO, 60, 12},
};
enum { SKY = sizeof sky / sizeof sky[0] };

static double place[3], C_e_n[3][3];
static fw_range ranges[FW_RANGE_MAX];
static fw_solution solution;

static void near(double got, double expected, double tolerance)
{
	if (!(fabs(got - expected) <= tolerance))
		fail_msg("%.12g is not %.12g within %g", got, expected, tolerance);
}

/* No corrections: the codes have none. */
static fw_single_point_options plain(void)
{
	fw_single_point_options o = fw_single_point_defaults;
	o.iono = FW_IONO_OFF;
	o.tropo = FW_TROPO_OFF;
	return o;
}

/* A satellite 26,000 km from the centre at reception, and where it was, in its own frame, at transmission. */
static void make_range(unsigned i, uint8_t system, double azimuth_deg, double elevation_deg, double clock_m)
{
	const double az = fw_rad_from_deg(azimuth_deg), el = fw_rad_from_deg(elevation_deg), drift = 30;
	const double ned[3] = {cos(el) * cos(az), cos(el) * sin(az), -sin(el)};
	double u[3], v[3], velocity_e[3];
	fw_mat3_vec(C_e_n, ned, u);
	fw_mat3_vec(C_e_n, moving_ned, velocity_e);
	const double along = place[0] * u[0] + place[1] * u[1] + place[2] * u[2];
	const double r2 = place[0] * place[0] + place[1] * place[1] + place[2] * place[2];
	const double distance = -along + sqrt(along * along - r2 + 26e6 * 26e6);
	const double now[3] = {place[0] + distance * u[0], place[1] + distance * u[1],
	                       place[2] + distance * u[2]};
	const double turn = FW_EARTH_RATE_RADPS * distance / FW_SPEED_OF_LIGHT_MPS;
	fw_range *r = &ranges[i];
	*r = (fw_range){
	    .satellite = {system, (uint8_t)(i + 1)}, .n_codes = 1, .has_rate = true, .rate_cn0_dbhz = 45};
	r->code[0] = (fw_code){{'1', 'C'}, distance + clock_m, 1, 45, true};
	r->position_m[0] = cos(turn) * now[0] - sin(turn) * now[1];
	r->position_m[1] = sin(turn) * now[0] + cos(turn) * now[1];
	r->position_m[2] = now[2];
	for (int k = 0; k < 3; k++)
		r->velocity_mps[k] = 1000.0 * ((int)(i + (unsigned)k) % 5 - 2);
	fw_line_of_sight line;
	fw_range_line(place, r->position_m, r->velocity_mps, &line);
	for (int k = 0; k < 3; k++)
		v[k] = -velocity_e[k] * line.unit[k];
	r->rate_mps = line.rate_mps + v[0] + v[1] + v[2] + drift;
}

static void make_sky(double gps_clock_m, double galileo_clock_m)
{
	assert_int_equal(fw_llh_to_ecef(place_llh, place), FW_OK);
	fw_frame_ned(place_llh[0], place_llh[1], C_e_n);
	for (unsigned i = 0; i < SKY; i++)
		make_range(i, sky[i].system, sky[i].azimuth, sky[i].elevation,
		           sky[i].system == FW_GPS ? gps_clock_m : galileo_clock_m);
}

static fw_single_point_status solve(unsigned n, const fw_single_point_options *o,
                                    fw_single_point_memory *memory)
{
	return fw_single_point_ranges(ranges, n, tag, NULL, o, memory, &solution);
}

static void expect_place(double tolerance_m)
{
	for (int i = 0; i < 3; i++)
		near(solution.position_m[i], place[i], tolerance_m);
}

static void answer_is_exact_from_the_centre_of_the_earth(void **state)
{
	(void)state;
	const fw_single_point_options o = plain();
	make_sky(150000.25, 150012.5);
	assert_int_equal(solve(SKY, &o, NULL), FW_SP_OK);
	expect_place(1e-6);
	near(solution.clock_m[FW_GPS], 150000.25, 1e-6);
	near(solution.clock_m[FW_GALILEO], 150012.5, 1e-6);
	near(solution.llh[0], place_llh[0], 1e-12);
	near(solution.llh[2], place_llh[2], 1e-6);
	near(fw_time_diff_s(tag, solution.time), 150000.25 / FW_SPEED_OF_LIGHT_MPS, 1e-9);
	assert_int_equal(solution.n_used, SKY);
	assert_int_equal(solution.n_excluded, 0);
	assert_int_equal(solution.systems, 1U << FW_GPS | 1U << FW_GALILEO);
	near(solution.chi2, 0, 1e-9);
}

static void velocity_is_exact(void **state)
{
	(void)state;
	const fw_single_point_options o = plain();
	make_sky(0, 0);
	assert_int_equal(solve(SKY, &o, NULL), FW_SP_OK);
	assert_true(solution.has_velocity);
	for (int i = 0; i < 3; i++)
		near(solution.velocity_mps[i], moving_ned[i], 1e-6);
	near(solution.drift_mps, 30, 1e-6);
}

static void wrong_memory_does_no_harm(void **state)
{
	(void)state;
	const fw_single_point_options o = plain();
	const double antipode[3] = {-place[0], -place[1], -place[2]},
	             behind[3] = {place[0] + 300e3, place[1], place[2]};
	const double *const wrong[] = {antipode, behind};
	make_sky(5, 6);
	for (int i = 0; i < 2; i++) {
		fw_single_point_memory memory = {.has_position = true, .time = tag};
		memcpy(memory.position_m, wrong[i], sizeof memory.position_m);
		assert_int_equal(solve(SKY, &o, &memory), FW_SP_OK);
		expect_place(1e-6);
		assert_int_equal(solution.n_used, SKY);
	}
}

static void outlier_of_100_m_is_excluded(void **state)
{
	(void)state;
	const fw_single_point_options o = plain();
	for (unsigned bad = 0; bad < SKY; bad++) {
		make_sky(1000, 1010);
		ranges[bad].code[0].code_m += 100;
		assert_int_equal(solve(SKY, &o, NULL), FW_SP_OK);
		assert_int_equal(solution.n_excluded, 1);
		assert_int_equal(solution.satellite[bad].use, FW_OUTLIER);
		near(solution.satellite[bad].residual_m, 100, 1e-3);
		expect_place(1e-6);
	}
}

static void two_outliers_and_a_bad_doppler_are_excluded(void **state)
{
	(void)state;
	const fw_single_point_options o = plain();
	make_sky(0, 0);
	ranges[1].code[0].code_m += 100;
	ranges[8].code[0].code_m -= 250;
	ranges[4].rate_mps += 20;
	assert_int_equal(solve(SKY, &o, NULL), FW_SP_OK);
	assert_int_equal(solution.n_excluded, 2);
	expect_place(1e-6);
	for (int i = 0; i < 3; i++)
		near(solution.velocity_mps[i], moving_ned[i], 1e-6);
}

static void gate_0_excludes_nothing(void **state)
{
	(void)state;
	fw_single_point_options o = plain();
	o.gate = 0;
	make_sky(0, 0);
	ranges[2].code[0].code_m += 100;
	assert_int_equal(solve(SKY, &o, NULL), FW_SP_OK);
	assert_int_equal(solution.n_excluded, 0);
	/* but the covariance knows that something is wrong */
	assert_true(sqrt(solution.covariance_m2[2][2]) > 10);
}

static void rank_deficient_geometry_has_a_name(void **state)
{
	(void)state;
	fw_single_point_options o = plain();
	make_sky(0, 0);
	for (unsigned i = 0; i < 8; i++) /* a cone about the zenith: height and clock are one */
		make_range(i, FW_GPS, 45.0 * i, 40, 0);
	assert_int_equal(solve(8, &o, NULL), FW_SP_BAD_GEOMETRY);
	for (unsigned i = 0; i < 4; i++) /* nearly one */
		make_range(i, FW_GPS, 90.0 * i, 40 + 0.3 * i, 0);
	assert_int_equal(solve(4, &o, NULL), FW_SP_BAD_GEOMETRY);
	o.max_gdop = 1e6;
	assert_int_equal(solve(4, &o, NULL), FW_SP_OK);
}

static void too_few_satellites_have_a_name(void **state)
{
	(void)state;
	fw_single_point_options o = plain();
	make_sky(0, 0);
	solution.n_used = 77;
	assert_int_equal(solve(0, &o, NULL), FW_SP_NO_RANGES);
	assert_int_equal(solve(3, &o, NULL), FW_SP_TOO_FEW);
	make_range(3, FW_GALILEO, 200, 50, 0); /* a fourth one with a clock of its own */
	assert_int_equal(solve(4, &o, NULL), FW_SP_TOO_FEW);
	make_sky(0, 0);
	o.elevation_mask_rad = fw_rad_from_deg(60);
	assert_int_equal(solve(SKY, &o, NULL), FW_SP_TOO_FEW);
	assert_int_equal(solution.n_used, 77); /* untouched */
	assert_string_equal(fw_single_point_text(FW_SP_TOO_FEW), "too-few-satellites");
}

static void codes_from_nowhere_do_not_converge(void **state)
{
	(void)state;
	const fw_single_point_options o = plain();
	make_sky(0, 0);
	for (unsigned i = 0; i < SKY; i++)
		ranges[i].code[0].code_m = NAN;
	assert_int_not_equal(solve(SKY, &o, NULL), FW_SP_OK);
}

/* The same equations with numpy, from azimuths and elevations alone: DOP of the twelve satellites, two clocks. */
static void dop_is_that_of_numpy(void **state)
{
	(void)state;
	const fw_single_point_options o = plain();
	make_sky(0, 0);
	assert_int_equal(solve(SKY, &o, NULL), FW_SP_OK);
	near(solution.hdop, 0.789027267, 1e-6);
	near(solution.vdop, 1.201070804, 1e-6);
	near(solution.tdop, 0.824083205, 1e-6);
	near(solution.pdop, 1.437057794, 1e-6);
}

/* Codes on L1 and L5 that have an ionosphere and a troposphere on them; what is modelled has to come off again. */
static void add_atmosphere(const fw_klobuchar *k, double iono_error)
{
	int week;
	fw_sight s = {place_llh[0], place_llh[1], 0, 0, 0};
	fw_time_to_gps_s(tag, &week, &s.tow_s);
	const fw_zenith_delay z = fw_saastamoinen(place_llh[0], place_llh[2], 0.7);
	for (unsigned i = 0; i < SKY; i++) {
		s.azimuth_rad = fw_rad_from_deg(sky[i].azimuth);
		s.elevation_rad = fw_rad_from_deg(sky[i].elevation);
		const double iono = fw_klobuchar_m(k, &s) * iono_error,
		             tropo = (z.dry_m + z.wet_m) / sin(s.elevation_rad);
		const double scale = pow(1575.42 / 1176.45, 2), code = ranges[i].code[0].code_m;
		ranges[i].n_codes = 2;
		ranges[i].code[0].code_m = code + iono + tropo;
		ranges[i].code[1] = (fw_code){{'5', 'Q'}, code + scale * iono + tropo, scale, 45, true};
	}
}

static const fw_iono_coefficients coefficients = {
    .has_gps = true,
    .gps = {{1.8626e-8, 2.2352e-8, -1.1921e-7, -5.9605e-8}, {1.2902e5, 1.6384e5, -1.9661e5, -2.6214e5}}};

static void modelled_atmosphere_comes_off(void **state)
{
	(void)state;
	fw_single_point_options o = fw_single_point_defaults;
	make_sky(0, 0);
	add_atmosphere(&coefficients.gps, 1);
	for (fw_iono_mode mode = FW_IONO_BROADCAST; mode <= FW_IONO_WEIGHTED; mode++) {
		o.iono = mode;
		for (unsigned i = 0; i < SKY; i++)
			ranges[i].n_codes = mode == FW_IONO_BROADCAST ? 1 : 2;
		assert_int_equal(fw_single_point_ranges(ranges, SKY, tag, &coefficients, &o, NULL, &solution),
		                 FW_SP_OK);
		expect_place(1e-4);
	}
}

static void pair_and_weights_resist_a_wrong_model(void **state)
{
	(void)state;
	fw_single_point_options o = fw_single_point_defaults;
	double error[4] = {0};
	make_sky(0, 0);
	add_atmosphere(&coefficients.gps, 1.5);
	for (fw_iono_mode mode = FW_IONO_BROADCAST; mode <= FW_IONO_WEIGHTED; mode++) {
		o.iono = mode;
		for (unsigned i = 0; i < SKY; i++)
			ranges[i].n_codes = mode == FW_IONO_BROADCAST ? 1 : 2;
		assert_int_equal(fw_single_point_ranges(ranges, SKY, tag, &coefficients, &o, NULL, &solution),
		                 FW_SP_OK);
		for (int i = 0; i < 3; i++)
			error[mode] = hypot(error[mode], solution.position_m[i] - place[i]);
	}
	assert_true(error[FW_IONO_BROADCAST] > 1);
	near(error[FW_IONO_FREE], 0, 1e-4);
	assert_true(error[FW_IONO_WEIGHTED] < error[FW_IONO_BROADCAST] / 2);
}

static void satellites_without_a_pair_are_left_out_of_pairs(void **state)
{
	(void)state;
	fw_single_point_options o = fw_single_point_defaults;
	o.iono = FW_IONO_FREE;
	make_sky(0, 0);
	add_atmosphere(&coefficients.gps, 1);
	ranges[3].n_codes = 1;
	assert_int_equal(fw_single_point_ranges(ranges, SKY, tag, &coefficients, &o, NULL, &solution),
	                 FW_SP_OK);
	assert_int_equal(solution.satellite[3].use, FW_NO_PAIR);
	assert_int_equal(solution.n_used, SKY - 1);
	expect_place(1e-4);
}

/* Codes with the errors that the solver expects, times `factor`: errors lie inside one standard deviation in 68.3 % of
 * cases, whatever the factor. */
static void share_inside_one_sigma(double factor, const fw_single_point_options *o, uint64_t seed)
{
	enum { TRIALS = 600 };
	fw_random random;
	int inside[3] = {0};
	double sigma[SKY];
	fw_single_point_memory memory = {0};
	fw_random_init(&random, seed);
	make_sky(100, 200);
	assert_int_equal(solve(SKY, o, NULL), FW_SP_OK);
	for (unsigned i = 0; i < SKY; i++)
		sigma[i] = solution.satellite[i].sigma_m;
	for (int trial = 0; trial < TRIALS; trial++) {
		double error[3], d[3];
		make_sky(100, 200);
		for (unsigned i = 0; i < SKY; i++)
			ranges[i].code[0].code_m += factor * sigma[i] * fw_random_normal(&random);
		const fw_time t = fw_time_add_ns(tag, trial * FW_NS_PER_S);
		assert_int_equal(fw_single_point_ranges(ranges, SKY, t, NULL, o, &memory, &solution),
		                 FW_SP_OK);
		for (int i = 0; i < 3; i++)
			d[i] = solution.position_m[i] - place[i];
		fw_mat3_t_vec(C_e_n, d, error);
		for (int i = 0; i < 3; i++)
			inside[i] += fabs(error[i]) <= sqrt(solution.covariance_m2[i][i]);
	}
	for (int i = 0; i < 3; i++)
		near((double)inside[i] / TRIALS, 0.683, 0.08);
}

static void standard_deviations_are_honest(void **state)
{
	(void)state;
	const fw_single_point_options o = plain();
	share_inside_one_sigma(1, &o, 1);
	share_inside_one_sigma(0.1, &o, 2);
	share_inside_one_sigma(4, &o, 3);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(answer_is_exact_from_the_centre_of_the_earth),
	    cmocka_unit_test(velocity_is_exact),
	    cmocka_unit_test(wrong_memory_does_no_harm),
	    cmocka_unit_test(outlier_of_100_m_is_excluded),
	    cmocka_unit_test(two_outliers_and_a_bad_doppler_are_excluded),
	    cmocka_unit_test(gate_0_excludes_nothing),
	    cmocka_unit_test(rank_deficient_geometry_has_a_name),
	    cmocka_unit_test(too_few_satellites_have_a_name),
	    cmocka_unit_test(codes_from_nowhere_do_not_converge),
	    cmocka_unit_test(dop_is_that_of_numpy),
	    cmocka_unit_test(modelled_atmosphere_comes_off),
	    cmocka_unit_test(pair_and_weights_resist_a_wrong_model),
	    cmocka_unit_test(satellites_without_a_pair_are_left_out_of_pairs),
	    cmocka_unit_test(standard_deviations_are_honest),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
