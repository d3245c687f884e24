/* The figures of nav-eval as one page for a browser, with pictures drawn by gnuplot. */
#ifndef FURROW_CLI_EVAL_HTML_H
#define FURROW_CLI_EVAL_HTML_H

#include "eval_report.h"
#include "tool.h"

/* Writes the page: complete in itself, nothing is fetched when it is opened.
 *   command  in  what the user typed, for the foot of the page
 * Errors of `out` are for its owner to find. Returns FW_OK; FW_EIO after a message: gnuplot is missing or failed. */
fw_status eval_write_html(const eval_report *report, const char *command, const tool *t,
                          FILE *out) FW_MUST_CHECK;

#endif
