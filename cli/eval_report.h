/* The figures of nav-eval as text for people and as a table for programs. */
#ifndef FURROW_CLI_EVAL_REPORT_H
#define FURROW_CLI_EVAL_REPORT_H

#include <stdio.h>

#include "eval_sky.h"
#include "eval_stats.h"

typedef struct {
	const eval_truth *truth;
	const eval_result *results;
	int n;
	fw_time origin;      /* where seconds are counted from */
	const eval_sky *sky; /* empty: nothing is known of it */
} eval_report;

/* A share in percent; 0 of nothing is 0. */
double eval_percent(uint64_t part, uint64_t whole);

/* Seconds from the report's origin to t. */
double eval_seconds(const eval_report *report, fw_time t);

/* Write the report to `out`, whose owner asks it about errors. */
void eval_write_text(const eval_report *report, FILE *out);
void eval_write_csv(const eval_report *report, FILE *out);

#endif
