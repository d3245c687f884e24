/* The truth at any moment, and how far a fix is from it. */
#ifndef FURROW_CLI_EVAL_MATCH_H
#define FURROW_CLI_EVAL_MATCH_H

#include <stdbool.h>

#include "eval_series.h"

typedef struct {
	const eval_series *series;
	int64_t gap_ns;        /* between rows further apart than this there is no truth */
	bool moved;            /* the solutions are of another point of the body, */
	double lever_arm_m[3]; /* here, from the truth's point: forward, right, down */
} eval_truth;

/* The truth at time t.
 *   state  out  position, velocity and attitude, as far as the rows around t have them; no more than that
 * Position: the cubic through the rows on both sides with their velocities (Hermite); where they have none, the
 * polynomial through up to four rows. Velocity: the polynomial through up to four rows. Attitude: slerp. All of it in
 * ECEF, so that a pole or the date line is a place like any other. With a lever arm position and velocity are those of
 * the solutions' point, which takes the truth's attitude.
 * Returns FW_OK; FW_ERANGE: no truth at t: before the first row, after the last, in a gap, or no attitude for the
 * lever arm. */
fw_status eval_truth_at(const eval_truth *truth, fw_time t, eval_fix *state) FW_MUST_CHECK;

/* How many moments first + k interval, k any whole number, lie in [begin, end) and where there is truth: what a
 * solution could have had. */
uint64_t eval_truth_expected(const eval_truth *truth, fw_time first, int64_t interval_ns, fw_time begin,
                             fw_time end);

/* How many gaps there are, and the longest [s]. */
size_t eval_truth_gaps(const eval_truth *truth, double *longest_s);

/* About how much of a position error is the interpolation's [m], 95 %: rows are held against what the rows next to
 * them give, which is twice as far apart, hence (fourth order) sixteen times as far off. Noise of the truth counts as
 * well. NaN when there are too few rows. */
double eval_truth_interpolation(const eval_truth *truth);

/* What is compared. The names and units: eval_quantity_names. */
typedef enum {
	EVAL_NORTH,
	EVAL_EAST,
	EVAL_DOWN,
	EVAL_HORIZONTAL,
	EVAL_POSITION, /* the length of all three */
	EVAL_VN,
	EVAL_VE,
	EVAL_VD,
	EVAL_VELOCITY, /* the length of all three */
	EVAL_ROLL,
	EVAL_PITCH,
	EVAL_HEADING,
	EVAL_ATTITUDE, /* the angle of the one rotation that takes the true attitude to the solution's */
	EVAL_QUANTITIES
} eval_quantity;

extern const char *const eval_quantity_names[EVAL_QUANTITIES];

/* The errors of a fix, solution minus truth, in m, m/s and degrees; angles -180..180. NaN: either has it not. */
void eval_errors(const eval_fix *solution, const eval_fix *truth, double error[static EVAL_QUANTITIES]);

#endif
