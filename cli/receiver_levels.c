#include "receiver_levels.h"

#include <math.h>

#include "furrow_dop.h"
#include "furrow_dop_columns.h"
#include "furrow_pvt.h"
#include "furrow_pvt_columns.h"
#include "furrow_pvt_ecef.h"
#include "furrow_pvt_ecef_columns.h"

enum { MODE_NONE = 0, MODE_SBAS = 6 }; /* of pvt */

#define HAS(record, column) (((record)->present >> FW_COL_##column & 1) != 0)

void receiver_levels_kinds(fw_kind_set *set)
{
	fw_kind_add(set, FW_pvt);
	fw_kind_add(set, FW_pvt_ecef);
	fw_kind_add(set, FW_dop);
}

void receiver_levels_begin(receiver_levels *l, int64_t patience_ns,
                           void (*ready)(void *context, const level_epoch *epoch), void *context)
{
	*l = (receiver_levels){
	    .ready = ready, .context = context, .patience_ns = patience_ns, .position = FW_RECORD_COUNT};
}

/* An epoch of which only the position is known. */
static level_epoch position_of(fw_time time, bool placed, int mode, int error, int n_sats)
{
	return (level_epoch){.time = time,
	                     .seen = {.position = placed && mode != MODE_NONE && error == 0,
	                              .sbas = mode == MODE_SBAS,
	                              .hpl_m = (double)NAN,
	                              .vpl_m = (double)NAN},
	                     .n_sats = n_sats};
}

static void take_position(receiver_levels *l, fw_time time, fw_kind kind, const void *record)
{
	const furrow_pvt *g = record;
	const furrow_pvt_ecef *c = record;
	if (l->position == FW_RECORD_COUNT)
		l->position = kind;
	if (kind != l->position)
		return; /* the same once more, in other coordinates */
	if (kind == FW_pvt)
		l->epoch = position_of(time, HAS(g, pvt_lat_deg) && HAS(g, pvt_lon_deg), g->mode, g->error,
		                       HAS(g, pvt_n_sats) ? g->n_sats : -1);
	else
		l->epoch =
		    position_of(time, HAS(c, pvt_ecef_x_m) && HAS(c, pvt_ecef_y_m) && HAS(c, pvt_ecef_z_m),
		                c->mode, c->error, HAS(c, pvt_ecef_n_sats) ? c->n_sats : -1);
	l->flat = (kind == FW_pvt ? g->two_d : c->two_d) != 0;
	l->waiting = true;
}

static void take_levels(receiver_levels *l, fw_time time, const furrow_dop *r)
{
	l->has_levels = true;
	l->levels_time = time;
	l->hpl_m = HAS(r, dop_hpl_m) ? (double)r->hpl_m : (double)NAN;
	l->vpl_m = HAS(r, dop_vpl_m) ? (double)r->vpl_m : (double)NAN;
}

static bool levels_are_there(const receiver_levels *l)
{
	return l->has_levels && fw_time_compare(l->levels_time, l->epoch.time) == 0;
}

void receiver_levels_flush(receiver_levels *l)
{
	if (!l->waiting)
		return;
	if (levels_are_there(l)) {
		l->epoch.seen.hpl_m = l->hpl_m;
		l->epoch.seen.vpl_m = l->flat ? (double)NAN : l->vpl_m;
	}
	l->waiting = false;
	l->ready(l->context, &l->epoch);
}

void receiver_levels_before(receiver_levels *l, fw_kind kind, const void *record)
{
	fw_time t;
	if (!l->waiting || fw_record_time(record, &t) != FW_OK)
		return;
	if (kind == l->position || fw_time_diff_ns(t, l->epoch.time) > l->patience_ns)
		receiver_levels_flush(l);
}

void receiver_levels_put(receiver_levels *l, fw_kind kind, const void *record)
{
	fw_time t;
	if ((kind != FW_pvt && kind != FW_pvt_ecef && kind != FW_dop) || fw_record_time(record, &t) != FW_OK)
		return;
	if (kind == FW_dop)
		take_levels(l, t, record);
	else
		take_position(l, t, kind, record);
	if (levels_are_there(l))
		receiver_levels_flush(l);
}
