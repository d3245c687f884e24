#include "eval_sky.h"

#include <stdlib.h>
#include <string.h>

#include "furrow_obs.h"
#include "furrow_satpos.h"

/* A week of sixty satellites. */
enum { SIGHTINGS_MAX = 4000000 };
#define EVERY_NS (10 * FW_NS_PER_S)

void eval_sky_kinds(fw_kind_set *kinds)
{
	ephemeris_kinds(kinds);
	fw_kind_add(kinds, FW_obs);
	fw_kind_add(kinds, FW_satpos);
}

/* Room for one more. A picture that lacks satellites for want of memory is no reason to fail. */
static eval_sighting *next_place(eval_sky *sky)
{
	if (sky->n == sky->room) {
		size_t room = sky->room > 0 ? 2 * sky->room : 1024;
		void *larger =
		    room <= SIGHTINGS_MAX ? realloc(sky->sighting, room * sizeof sky->sighting[0]) : NULL;
		if (larger == NULL)
			return NULL;
		sky->sighting = larger;
		sky->room = room;
	}
	return &sky->sighting[sky->n];
}

/* Notes a satellite unless it was noted a moment ago. `position_m` is NULL when it is not known yet. */
static void note(eval_sky *sky, fw_time t, const char *name, const double *position_m)
{
	eval_sighting sighting = {.t = t, .placed = position_m != NULL};
	if (name == NULL || fw_satellite_parse(name, &sighting.satellite) != FW_OK)
		return;
	fw_time *last = &sky->last[fw_satellite_index(sighting.satellite)];
	if (last->ns != 0 && t.ns >= last->ns && t.ns - last->ns < EVERY_NS)
		return;
	eval_sighting *place = next_place(sky);
	if (place == NULL)
		return;
	for (int i = 0; position_m != NULL && i < 3; i++)
		sighting.position_m[i] = position_m[i];
	*place = sighting;
	sky->n++;
	*last = t;
}

void eval_sky_put(void *context, fw_kind kind, const void *record)
{
	eval_sky *sky = context;
	fw_time t;
	ephemeris_store_put(&sky->ephemerides, kind, record);
	if (fw_record_time(record, &t) != FW_OK)
		return;
	if (kind == FW_satpos) {
		const furrow_satpos *p = record;
		note(sky, t, p->sat, (const double[3]){p->x_m, p->y_m, p->z_m});
	} else if (kind == FW_obs) {
		note(sky, t, ((const furrow_obs *)record)->sat, NULL);
	}
}

static int by_satellite(const void *a, const void *b)
{
	const eval_sighting *x = a, *y = b;
	int order = (int)fw_satellite_index(x->satellite) - (int)fw_satellite_index(y->satellite);
	return order != 0 ? order : fw_time_compare(x->t, y->t);
}

/* Where the satellite is at the time of reception: some 300 m from where it sent, which no picture shows. */
static void find_place(eval_sky *sky, eval_sighting *s)
{
	fw_satellite_state state;
	const fw_ephemeris *e = ephemeris_store_find(&sky->ephemerides, s->satellite, FW_NAV_INAV, s->t);
	if (e == NULL || fw_ephemeris_state(e, s->t, &state) < 0)
		return;
	memcpy(s->position_m, state.position_m, sizeof s->position_m);
	s->placed = true;
}

void eval_sky_settle(eval_sky *sky)
{
	size_t kept = 0;
	for (size_t i = 0; i < sky->n; i++) {
		if (!sky->sighting[i].placed)
			find_place(sky, &sky->sighting[i]);
		if (sky->sighting[i].placed)
			sky->sighting[kept++] = sky->sighting[i];
	}
	sky->n = kept;
	if (kept > 0)
		qsort(sky->sighting, kept, sizeof sky->sighting[0], by_satellite);
}

void eval_sky_release(eval_sky *sky)
{
	ephemeris_store_free(&sky->ephemerides);
	free(sky->sighting);
	*sky = (eval_sky){0};
}
