#include "epochs.h"

#include <string.h>

#include "furrow_obs.h"
#include "furrow_obs_columns.h"

/* Columns and the bits that they set in fw_observation.has. */
static unsigned bits_of(int64_t present)
{
	return (present >> FW_COL_obs_pseudorange_m & 1 ? FW_HAS_CODE : 0U) |
	       (present >> FW_COL_obs_carrier_cyc & 1 ? FW_HAS_CARRIER : 0U) |
	       (present >> FW_COL_obs_doppler_hz & 1 ? FW_HAS_DOPPLER : 0U) |
	       (present >> FW_COL_obs_cn0_dbhz & 1 ? FW_HAS_CN0 : 0U) |
	       (present >> FW_COL_obs_lock_s & 1 ? FW_HAS_LOCK : 0U);
}

static bool has_signal(const furrow_obs *r)
{
	const char *signal = r->signal;
	return signal != NULL && signal[0] != '\0' && signal[1] != '\0' && signal[2] == '\0';
}

/* Of a record that has a signal. */
static inline void take(const furrow_obs *r, fw_satellite s, fw_observation *o)
{
	*o = (fw_observation){
	    .satellite = s,
	    .signal = {r->signal[0], r->signal[1]},
	    .glonass_channel =
	        (r->present >> FW_COL_obs_glonass_channel & 1) != 0 ? r->glonass_channel : INT8_MIN,
	    .has = (uint8_t)bits_of(r->present),
	    .half_cycle = r->half_cycle != 0,
	    .slip = (r->present >> FW_COL_obs_lock_s & 1) != 0 && r->lock_s == 0,
	    .code_m = r->pseudorange_m,
	    .carrier_cyc = r->carrier_cyc,
	    .doppler_hz = r->doppler_hz,
	    .cn0_dbhz = r->cn0_dbhz,
	    .lock_s = r->lock_s,
	};
}

fw_status observation_of_record(const void *record, fw_observation *o)
{
	const furrow_obs *r = record;
	fw_satellite s;
	if (r->sat == NULL || fw_satellite_parse(r->sat, &s) != FW_OK || !has_signal(r))
		return FW_EINVAL;
	take(r, s, o);
	return FW_OK;
}

void epochs_begin(epochs *e, void (*ready)(void *context, const fw_epoch *epoch), void *context)
{
	*e = (epochs){.ready = ready, .context = context};
}

void epochs_flush(epochs *e)
{
	if (e->epoch.n > 0)
		e->ready(e->context, &e->epoch);
	for (unsigned i = 0; i < e->epoch.n; i++)
		e->after[fw_satellite_index(e->epoch.obs[i].satellite)] = 0;
	e->epoch.n = 0;
}

/* Room for an observation behind those of its satellite; NULL: there is none. */
static fw_observation *make_room(epochs *e, fw_satellite s)
{
	fw_epoch *epoch = &e->epoch;
	uint16_t *after = &e->after[fw_satellite_index(s)];
	if (epoch->n == FW_EPOCH_MAX) {
		e->overflowed++;
		return NULL;
	}
	const unsigned at = *after != 0 ? *after : epoch->n;
	if (at < epoch->n) { /* a receiver that does not keep a satellite's rows together */
		memmove(&epoch->obs[at + 1], &epoch->obs[at], (epoch->n - at) * sizeof epoch->obs[0]);
		for (unsigned i = 0; i < FW_SATELLITE_COUNT; i++)
			e->after[i] = (uint16_t)(e->after[i] + (e->after[i] > at));
	}
	epoch->n++;
	*after = (uint16_t)(at + 1);
	return &epoch->obs[at];
}

/* strcmp() == 0 without a call: names are short, and there is one for each row. */
static bool is_same(const char *a, const char *b)
{
	while (*a == *b && *a != '\0') {
		a++;
		b++;
	}
	return *a == *b;
}

/* The satellite of a row: most often that of the row before. */
static bool find_satellite(epochs *e, const char *name)
{
	if (name == NULL)
		return false;
	if (is_same(name, e->last_name))
		return true;
	if (strlen(name) >= sizeof e->last_name || fw_satellite_parse(name, &e->last) != FW_OK)
		return false;
	strncpy(e->last_name, name, sizeof e->last_name - 1);
	return true;
}

/* Its time: most often that of the row before, too. */
static bool find_time(epochs *e, const furrow_obs *r, fw_time *t)
{
	const int64_t stamp = INT64_C(1) << FW_COL_obs_gps_week | INT64_C(1) << FW_COL_obs_tow_s;
	if (e->epoch.n > 0 && (r->present & stamp) == stamp && r->gps_week == e->gps_week &&
	    r->tow_s == e->tow_s) {
		*t = e->epoch.time;
		return true;
	}
	if (fw_record_time(r, t) != FW_OK)
		return false;
	e->gps_week = r->gps_week;
	e->tow_s = r->tow_s;
	return true;
}

void epochs_put(void *context, fw_kind kind, const void *record)
{
	epochs *e = context;
	const furrow_obs *r = record;
	fw_time t;
	if (kind != FW_obs || r->antenna != 0)
		return;
	if (!find_time(e, r, &t) || !find_satellite(e, r->sat) || !has_signal(r)) {
		e->refused++;
		return;
	}
	if (e->epoch.n > 0 && t.ns != e->epoch.time.ns)
		epochs_flush(e);
	e->epoch.time = t;
	fw_observation *o = make_room(e, e->last);
	if (o != NULL)
		take(r, e->last, o);
}
