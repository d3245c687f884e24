/* Smoothing over a whole run: what the filter said is kept, and corrected backwards when the run is over.
 *
 * Nodes (fusion/loose.h) are kept with their covariances in triangles, moments of the output without. A node's correction
 * is that of fusion/rts.h; a moment between two nodes gets what lies between the correction of the one
 * before it, after its measurements, and that of the one after it, before its measurements. */
#ifndef FURROW_CLI_FUSE_SMOOTH_H
#define FURROW_CLI_FUSE_SMOOTH_H

#include "fuse_output.h"
#include "fuse_store.h"
#include "fusion/rts.h"

/* Owned by the caller; 500 kB. */
typedef struct {
	fuse_budget budget;
	fw_layout layout;
	fuse_store nodes, moments, results;
	uint64_t singular; /* steps over which nothing could be smoothed */
	fw_node node[2];
	fw_smoothed smoothed[2];
} fuse_smooth;

/* Begins, with so many bytes of memory for what is kept; more goes to a file. */
void fuse_smooth_begin(fuse_smooth *s, uint64_t memory);

/* Keeps a node, and a moment of the output; in order of time. Failures stay with s->budget.error. */
void fuse_smooth_node(fuse_smooth *s, const fw_layout *layout, const fw_node *node);
void fuse_smooth_moment(fuse_smooth *s, const fuse_moment *m);

/* The run is over: its moments, smoothed, go to `to`; nothing is kept any more. Returns how many were not finite; failures stay
 * with s->budget.error. */
uint64_t fuse_smooth_run(fuse_smooth *s, const fuse_output *to);

/* Gives everything back. */
void fuse_smooth_end(fuse_smooth *s);

#endif
