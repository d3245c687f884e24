#include "fuse_order.h"

#include <stddef.h>

fw_time fuse_entry_time(const fuse_entry *e)
{
	return e->is_imu ? e->imu.time : e->item.time;
}

/* Does heap[a] come before heap[b]? */
static bool before(const fuse_order *o, unsigned a, unsigned b)
{
	if (o->heap[a].time_ns != o->heap[b].time_ns)
		return o->heap[a].time_ns < o->heap[b].time_ns;
	return o->heap[a].rank < o->heap[b].rank;
}

static void swap(fuse_order *o, unsigned a, unsigned b)
{
	const typeof(o->heap[0]) kept = o->heap[a];
	o->heap[a] = o->heap[b];
	o->heap[b] = kept;
}

void fuse_order_put(fuse_order *o, const fuse_entry *e)
{
	const uint64_t class = e->is_imu ? 2 : e->item.kind == FW_ITEM_LEVELS ? 0 : 1;
	const unsigned slot = o->n_free > 0 ? o->free[--o->n_free] : o->slots++;
	unsigned at = o->n++;
	o->entry[slot] = *e;
	o->heap[at].time_ns = fuse_entry_time(e).ns;
	o->heap[at].rank = class << 60 | o->arrivals++;
	o->heap[at].slot = slot;
	for (; at > 0 && before(o, at, (at - 1) / 2); at = (at - 1) / 2)
		swap(o, at, (at - 1) / 2);
}

fuse_entry *fuse_order_first(fuse_order *o)
{
	return o->n > 0 ? &o->entry[o->heap[0].slot] : NULL;
}

void fuse_order_drop(fuse_order *o)
{
	o->free[o->n_free++] = o->heap[0].slot;
	o->heap[0] = o->heap[--o->n];
	for (unsigned at = 0;;) {
		unsigned least = at;
		for (unsigned child = 2 * at + 1; child <= 2 * at + 2; child++)
			if (child < o->n && before(o, child, least))
				least = child;
		if (least == at)
			return;
		swap(o, at, least);
		at = least;
	}
}
