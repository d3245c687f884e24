/* What the filter takes, in order of time: a heap that holds entries back until nothing earlier is to be expected. Of the
 * same moment protection levels come first, since they judge the fix, then fixes and the like, then the IMU sample that ends there. */
#ifndef FURROW_CLI_FUSE_ORDER_H
#define FURROW_CLI_FUSE_ORDER_H

#include <stdbool.h>

#include "fusion/loose.h"

/* An IMU sample or something else with a time. */
typedef struct {
	bool is_imu;
	union {
		fw_imu_reading imu;
		fw_item item;
	};
} fuse_entry;

enum { FUSE_ORDER = 8192 };

/* Owned by the caller: 2 MiB, of which no more is touched than is held back. Zeroed is empty. */
typedef struct {
	unsigned n;
	uint64_t arrivals;
	struct {
		int64_t time_ns;
		uint64_t rank; /* of what has the same time: kind, then arrival */
		unsigned slot;
	} heap[FUSE_ORDER];
	unsigned slots; /* in use so far */
	unsigned n_free;
	unsigned free[FUSE_ORDER];
	fuse_entry entry[FUSE_ORDER];
} fuse_order;

fw_time fuse_entry_time(const fuse_entry *e);

/* Puts an entry in. There has to be room: n < FUSE_ORDER. */
void fuse_order_put(fuse_order *o, const fuse_entry *e);

/* The earliest entry; NULL: there is none. */
fuse_entry *fuse_order_first(fuse_order *o);

/* Takes it out. What fuse_order_first() gave is valid until the next fuse_order_put(). */
void fuse_order_drop(fuse_order *o);

#endif
