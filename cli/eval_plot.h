/* Pictures by gnuplot: a script and its data go in, SVG comes out, ready to stand inside an HTML page. */
#ifndef FURROW_CLI_EVAL_PLOT_H
#define FURROW_CLI_EVAL_PLOT_H

#include <stdio.h>

#include "base/status.h"
#include "tool.h"

/* Colours as gnuplot writes them; the page's style sheet finds them by these names and has others for the dark. Nothing
 * else in a script may come from outside: names of files never do. */
#define PLOT_INK    "#334155" /* axes, text */
#define PLOT_GRID   "#d6dce5"
#define PLOT_MUTED  "#94a3b8"
#define PLOT_BLUE   "#2563eb"
#define PLOT_ORANGE "#ea580c"
#define PLOT_GREEN  "#16a34a"
#define PLOT_VIOLET "#9333ea"
#define PLOT_RED    "#dc2626"
#define PLOT_TEAL   "#0d9488"

typedef struct {
	FILE *script; /* what gnuplot is to do: write to it with fprintf */
} plot;

/* Begins a picture of so many units; it takes the width that the page has.
 * Returns FW_OK; FW_EIO after a message: no scratch file. */
fw_status plot_begin(plot *p, int width, int height, const tool *t) FW_MUST_CHECK;

/* Has gnuplot draw it and copies the SVG to `out`. To be called once for each plot_begin() that succeeded.
 * Returns FW_OK; FW_EIO after a message: gnuplot is missing, or it refused the script. */
fw_status plot_end(plot *p, const tool *t, FILE *out) FW_MUST_CHECK;

#endif
