/* What nav-eval finds out: for each stretch of time and each quantity one row of figures. */
#ifndef FURROW_CLI_EVAL_STATS_H
#define FURROW_CLI_EVAL_STATS_H

#include "base/summary.h"
#include "eval_match.h"
#include "integrity/stanford.h"

/* A fix for which there is truth. */
typedef struct {
	fw_time t;
	const eval_fix *solution;
	double truth_m[3];                 /* ECEF */
	double error[EVAL_QUANTITIES];     /* NaN: not known */
	double sd[EVAL_QUANTITIES];        /* in the units of the errors; NaN: not known, or not positive */
	double pl_m[2], al_m[2], fom_m[2]; /* al_m: infinite when there is none */
} eval_epoch;

typedef struct {
	fw_time begin, end; /* epochs at `end` belong to the next one */
} eval_section;

/* One quantity in one section. */
typedef struct {
	fw_summary errors;
	uint64_t solved;    /* of the epochs that could have been, those with this quantity */
	uint64_t with_sd;   /* errors that come with a standard deviation, */
	uint64_t inside[3]; /* and those not above one, two, three of it */
	uint64_t
	    with_nees; /* EVAL_POSITION, _VELOCITY, _ATTITUDE: epochs with all three standard deviations */
	double nees;   /* their mean normalised error squared, for one degree of freedom: expected 1 */
	uint64_t nees_inside; /* those below the 95 % quantile of chi-square with three degrees of freedom */
	uint64_t with_level;  /* EVAL_HORIZONTAL, _DOWN: epochs with a protection level, by class */
	uint64_t stanford[FW_STANFORD_CLASSES];
	uint64_t with_fom,
	    fom_inside; /* the same two: figures of merit, and those that the error did not exceed */
} eval_row;

typedef struct {
	eval_section section;
	uint64_t expected; /* epochs that could have been solved */
	eval_row row[EVAL_QUANTITIES];
} eval_figures;

/* A solution held against the truth. */
typedef struct {
	const eval_series *solution;
	int64_t interval_ns; /* between its epochs */
	eval_epoch *epoch;
	size_t n;
	size_t without_truth;   /* fixes at times for which there is no truth */
	eval_figures whole;     /* everything */
	eval_figures *sections; /* if there are any */
	size_t n_sections;
} eval_result;

typedef struct {
	int64_t interval_ns; /* between the epochs that could be solved; 0: the solution's own */
	double al_m[2];      /* alert limits where the solution has none; NaN: none */
	eval_section window; /* what is looked at */
	const eval_section *sections;
	size_t n_sections;
} eval_question;

/* Compares a solution with the truth.
 *   r  out  to be given back with eval_result_release() in any case
 * Returns FW_OK; FW_ENOMEM; FW_ERANGE: no epoch of the solution has truth. */
fw_status eval_compare(const eval_series *solution, const eval_truth *truth, const eval_question *question,
                       eval_result *r) FW_MUST_CHECK;

/* Gives the memory back. */
void eval_result_release(eval_result *r);

#endif
