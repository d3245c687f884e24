/* The pictures of nav-eval's page. Each is written as SVG; each returns FW_OK, or FW_EIO after a message. A picture for
 * which there is nothing to draw writes nothing. */
#ifndef FURROW_CLI_EVAL_PICTURES_H
#define FURROW_CLI_EVAL_PICTURES_H

#include "eval_plot.h"
#include "eval_report.h"

/* The colour of a solution where several are in one picture. */
const char *eval_colour(int solution);

/* Of all solutions: the tracks, seen from above, and the share of errors below a size. */
fw_status eval_draw_track(const eval_report *report, const tool *t, FILE *out) FW_MUST_CHECK;
fw_status eval_draw_shares(const eval_report *report, const tool *t, FILE *out) FW_MUST_CHECK;

/* Of one: three errors from `first` on over time, with twice their standard deviations; horizontal and vertical error
 * with protection level and alert limit; how often which error, position, in units of its standard deviation if that is
 * known. */
fw_status eval_draw_errors(const eval_report *report, const eval_result *r, eval_quantity first,
                           const tool *t, FILE *out) FW_MUST_CHECK;
fw_status eval_draw_levels(const eval_report *report, const eval_result *r, const tool *t,
                           FILE *out) FW_MUST_CHECK;
fw_status eval_draw_histogram(const eval_result *r, const tool *t, FILE *out) FW_MUST_CHECK;

/* The Stanford diagrams of one: which is EVAL_H or EVAL_V. */
fw_status eval_draw_stanford(const eval_result *r, int which, const tool *t, FILE *out) FW_MUST_CHECK;

/* Where the satellites stood that the receiver saw. */
fw_status eval_draw_sky(const eval_report *report, const tool *t, FILE *out) FW_MUST_CHECK;

/* Whether there are protection levels to draw. */
int eval_has_levels(const eval_result *r, int which);

#endif
