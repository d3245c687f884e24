/* Fixed-interval smoothing: every estimate from all of the measurements, those after it too (Rauch, Tung, Striebel). */
#ifndef FURROW_FUSION_RTS_H
#define FURROW_FUSION_RTS_H

#include "fusion/loose.h"

/* What all of the measurements say at a node. */
typedef struct {
	double error[FW_STATES_MAX]; /* smoothed minus filtered, to be taken out of the filtered estimate */
	double ahead[FW_STATES_MAX]; /* smoothed minus predicted, likewise */
	double P[FW_STATES_MAX][FW_STATES_MAX];
} fw_smoothed;

/* The last node of a run: smoothed is filtered. */
void fw_rts_last(const fw_layout *layout, const fw_node *node, fw_smoothed *s);

/* One node back.
 *   node, next        in   a node and the one after it
 *   next_smoothed     in   of the one after it
 *   s                 out  of the node; may not be next_smoothed
 * Returns FW_OK; FW_DUBIOUS: the prediction's covariance is singular and no smoothing was done over this step (s is the filtered estimate).
 * Source: H. E. Rauch, F. Tung, C. T. Striebel, AIAA Journal 3 (1965); in error states, S. Saerkkae, Bayesian
 * Filtering and Smoothing (2013), 8.2. */
fw_status fw_rts_step(const fw_layout *layout, const fw_node *node, const fw_node *next,
                      const fw_smoothed *next_smoothed, fw_smoothed *s) FW_MUST_CHECK;

#endif
