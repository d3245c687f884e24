/* What is in an SBF log: for each block number and revision how many, from when to when, how large, how damaged. */
#ifndef FURROW_CLI_INVENTORY_H
#define FURROW_CLI_INVENTORY_H

#include <stdint.h>

#include "base/time.h"
#include "formats/sbf_frame.h"
#include "output.h"

enum { INVENTORY_IDS = 8192, INVENTORY_REVISIONS = 8 };

typedef struct {
	uint64_t count;
	uint64_t bytes;
	fw_time first, last; /* only if stamped > 0 */
	uint64_t stamped;    /* blocks that have a time stamp */
} inventory_entry;

/* About 3 MiB, of which a log touches little. */
typedef struct {
	inventory_entry entries[INVENTORY_IDS][INVENTORY_REVISIONS];
	uint64_t damaged[INVENTORY_IDS]; /* by the number in the damaged header; 0: not readable */
} inventory;

void inventory_add(inventory *inv, const fw_sbf_block *block);
void inventory_add_loss(inventory *inv, const fw_sbf_loss *loss);

/* Writes the inventory as a table, a row per block number and revision. Failures stay with `out`. */
void inventory_write(const inventory *inv, output *out);

#endif
