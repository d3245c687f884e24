#include "sim_log.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "formats/bytes.h"
#include "formats/sbf_build.h"
#include "formats/sbf_measurements.h"
#include "formats/sbf_signal.h"
#include "furrow_event.h"
#include "furrow_event_columns.h"
#include "furrow_klobuchar.h"
#include "furrow_klobuchar_columns.h"
#include "furrow_setup.h"
#include "furrow_setup_columns.h"
#include "furrow_time.h"
#include "furrow_time_columns.h"
#include "furrow_utc.h"
#include "furrow_utc_columns.h"

#define ALL(type)   ((INT64_C(1) << FW_COL_##type##_COUNT) - 1)
#define BIT(column) (INT64_C(1) << (FW_COL_##column))

enum {
	DOP = 4001,
	GAL_NAV = 4002,
	GLO_NAV = 4004,
	PVT_GEODETIC = 4007,
	BDS_NAV = 4081,
	GPS_NAV = 5891,
	GPS_ION = 5893,
	GPS_UTC = 5894,
	RECEIVER_SETUP = 5902,
	POS_COV_GEODETIC = 5906,
	VEL_COV_GEODETIC = 5908,
	RECEIVER_TIME = 5914,
	END_OF_PVT = 5921,
	END_OF_MEAS = 5922,
	EXT_EVENT = 5924,
	COMMENT = 5936,
	ATT_EULER = 5938,
	ATT_COV_EULER = 5939,
	END_OF_ATT = 5943,
	MARKER_LENGTH = 16
};

/* ---- bytes ---- */

static void write_out(sim_log *log)
{
	if (log->used > 0 && output_write(&log->out, log->buffer, log->used) < 0)
		return; /* the error stays in log->out */
	log->used = 0;
}

/* Room for one more block. */
static uint8_t *room(sim_log *log)
{
	if (log->used + FW_SBF_MAX_LENGTH > sizeof log->buffer)
		write_out(log);
	if (log->used + FW_SBF_MAX_LENGTH > sizeof log->buffer)
		log->used = 0; /* the output has failed: what is written no longer matters */
	return log->buffer + log->used;
}

static void took(sim_log *log, fw_status status, uint16_t length)
{
	if (status != FW_OK && log->refused == FW_OK)
		log->refused = status;
	if (status != FW_OK)
		return;
	log->used += length;
	log->blocks++;
}

static void put_block(sim_log *log, uint16_t id, uint8_t revision, const void *record)
{
	uint16_t length = 0;
	const void *const records[] = {record};
	fw_status status = fw_sbf_build(log->plans, id, revision, records, 1, room(log), &length);
	took(log, status, length);
}

static void stamp(fw_time t, uint32_t *tow_ms, uint16_t *week)
{
	int gps_week;
	int64_t tow_ns;
	fw_time_to_gps(t, &gps_week, &tow_ns);
	*week = (uint16_t)gps_week;
	*tow_ms = (uint32_t)(tow_ns / 1000000);
}

/* A block of which only the time stamp says something. */
static void put_marker(sim_log *log, uint16_t id)
{
	uint8_t *block = room(log);
	uint32_t tow_ms;
	uint16_t week;
	stamp(log->now, &tow_ms, &week);
	memset(block, 0, MARKER_LENGTH);
	fw_sbf_seal(block, id, 0, MARKER_LENGTH, tow_ms, week);
	took(log, FW_OK, MARKER_LENGTH);
}

static void put_comment(sim_log *log, const char *text)
{
	enum { TEXT_MAX = 1000, HEAD = 16 };
	uint8_t *block = room(log);
	size_t n = strnlen(text, TEXT_MAX);
	uint16_t length = (uint16_t)((HEAD + n + 3) / 4 * 4), week;
	uint32_t tow_ms;
	stamp(log->now, &tow_ms, &week);
	memset(block, 0, length);
	fw_store_u16(block + 14, (uint16_t)n);
	memcpy(block + HEAD, text, n);
	fw_sbf_seal(block, COMMENT, 0, length, tow_ms, week);
	took(log, FW_OK, length);
}

static void tell(const sim_log *log, fw_kind kind, const void *record)
{
	if (log->also.put != NULL)
		log->also.put(log->also.context, kind, record);
}

fw_status sim_log_open(sim_log *log, const char *path, const fw_sbf_plans *plans, fw_sink also)
{
	*log = (sim_log){.plans = plans, .also = also};
	return output_open(&log->out, path);
}

fw_status sim_log_end(sim_log *log)
{
	write_out(log);
	if (output_finish(&log->out) < 0)
		return FW_EIO;
	return log->refused == FW_OK ? FW_OK : FW_EINVAL;
}

/* ---- the beginning ---- */

/* Strings of records are not const, but nobody writes to them. */
static char *text(const char *s)
{
	return (char *)(uintptr_t)s;
}

static void put_setup(sim_log *log, const sim_log_head *head)
{
	furrow_setup setup;
	fw_record_clear(FW_setup, &setup);
	setup.marker_name = text(head->marker);
	setup.rx_serial = text(head->receiver);
	setup.rx_name = setup.product = text("gnss-sim");
	setup.rx_version = text(FURROW_VERSION);
	setup.ant_type = text("simulated       NONE");
	setup.marker_type = text("NON_GEODETIC");
	setup.observer = setup.agency = text("furrow");
	setup.present = BIT(setup_marker_name) | BIT(setup_rx_name) | BIT(setup_rx_version) |
	                BIT(setup_rx_serial) | BIT(setup_ant_type) | BIT(setup_marker_type) |
	                BIT(setup_observer) | BIT(setup_agency) | BIT(setup_product) | BIT(setup_delta_h_m) |
	                BIT(setup_delta_e_m) | BIT(setup_delta_n_m);
	if (head->llh != NULL) {
		setup.lat_deg = fw_deg_from_rad(head->llh[0]);
		setup.lon_deg = fw_deg_from_rad(head->llh[1]);
		setup.height_m = (float)head->llh[2];
		setup.present |= BIT(setup_lat_deg) | BIT(setup_lon_deg) | BIT(setup_height_m);
	}
	record_stamp(&setup, log->now);
	put_block(log, RECEIVER_SETUP, 4, &setup);
	tell(log, FW_setup, &setup);
}

static void put_ionosphere(sim_log *log, const fw_klobuchar *k)
{
	furrow_klobuchar ion = {.present = ALL(klobuchar), .sat = text("G01"), .source = text("decoded")};
	ion.alpha0_s = (float)k->alpha[0];
	ion.alpha1_s = (float)k->alpha[1];
	ion.alpha2_s = (float)k->alpha[2];
	ion.alpha3_s = (float)k->alpha[3];
	ion.beta0_s = (float)k->beta[0];
	ion.beta1_s = (float)k->beta[1];
	ion.beta2_s = (float)k->beta[2];
	ion.beta3_s = (float)k->beta[3];
	record_stamp(&ion, log->now);
	put_block(log, GPS_ION, 0, &ion);
	tell(log, FW_klobuchar, &ion);
}

static int leap_seconds(fw_time t)
{
	int leap_s;
	return fw_time_leap_seconds(t, &leap_s) >= 0 ? leap_s : 18;
}

/* UTC as GPS tells it: no offset, and the leap second of the end of 2016. */
static void put_utc(sim_log *log)
{
	furrow_utc utc = {
	    .present = ALL(utc) & ~BIT(utc_message), .sat = text("G01"), .source = text("decoded")};
	int week;
	int64_t tow_ns;
	fw_time_to_gps(log->now, &week, &tow_ns);
	utc.tot_s = 503808;
	utc.wnt = (int16_t)(week % 256);
	utc.leap_s = utc.leap_future_s = (int16_t)leap_seconds(log->now);
	utc.wnlsf = 1929 % 256;
	utc.dn = 7;
	record_stamp(&utc, log->now);
	put_block(log, GPS_UTC, 0, &utc);
	tell(log, FW_utc, &utc);
}

void sim_log_begin(sim_log *log, const sim_log_head *head, const fw_klobuchar *klobuchar, fw_time now)
{
	log->now = now;
	put_setup(log, head);
	put_comment(log, head->remark);
	put_ionosphere(log, klobuchar);
	put_utc(log);
}

void sim_log_ephemeris(sim_log *log, const fw_ephemeris *e, fw_time now)
{
	static const struct {
		fw_kind kind;
		uint16_t id;
		uint8_t revision;
	} blocks[] = {{FW_eph_gps, GPS_NAV, 0},
	              {FW_eph_gal, GAL_NAV, 0},
	              {FW_eph_bds, BDS_NAV, 0},
	              {FW_eph_glo, GLO_NAV, 1}};
	unsigned s = fw_satellite_index(e->satellite);
	fw_any_record record;
	char name[5];
	if (log->sent[s] == e)
		return;
	log->sent[s] = e;
	fw_kind kind = ephemeris_record(e, now, &record, name);
	for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++)
		if (blocks[i].kind == kind)
			put_block(log, blocks[i].id, blocks[i].revision, &record);
	tell(log, kind, &record);
}

/* ---- epochs ---- */

static int channel_of(sim_log *log, fw_satellite s)
{
	uint8_t *channel = &log->channel[fw_satellite_index(s)];
	if (*channel == 0)
		*channel = (uint8_t)++log->n_channels;
	return *channel;
}

static unsigned add_observations(sim_log *log, const fw_epoch *epoch, int antenna, furrow_obs *obs,
                                 char (*names)[8], unsigned n)
{
	for (unsigned i = 0; i < epoch->n; i++, n++)
		observation_record(&epoch->obs[i], epoch->time, antenna,
		                   channel_of(log, epoch->obs[i].satellite), &obs[n], names[n], names[n] + 5);
	return n;
}

void sim_log_measurements(sim_log *log, const fw_epoch *main, const fw_epoch *aux, int clock_jumps_ms)
{
	static furrow_obs obs[2 * FW_EPOCH_MAX];
	static char names[2 * FW_EPOCH_MAX][8];
	furrow_epoch epoch = {.present = 3};
	uint16_t length = 0;
	unsigned n = add_observations(log, main, 0, obs, names, 0);
	if (aux != NULL)
		n = add_observations(log, aux, 1, obs, names, n);
	log->now = main->time;
	log->epochs++;
	record_stamp(&epoch, main->time);
	epoch.n_signals = (int16_t)n;
	epoch.clock_jumps_ms = (int16_t)(clock_jumps_ms & 255);
	fw_status status = fw_sbf_encode_meas_epoch(&epoch, obs, n, room(log), &length);
	took(log, status, length);
	for (unsigned i = 0; i < n; i++)
		tell(log, FW_obs, &obs[i]);
	tell(log, FW_epoch, &epoch);
	put_marker(log, END_OF_MEAS);
}

static void put_time(sim_log *log)
{
	fw_civil utc;
	int leap_s = leap_seconds(log->now);
	if (fw_time_to_utc_leap(log->now, leap_s, &utc) < 0)
		return;
	furrow_time time = {.present = ALL(time),
	                    .utc_year = (int16_t)(utc.year % 100),
	                    .utc_month = (int16_t)utc.month,
	                    .utc_day = (int16_t)utc.day,
	                    .utc_hour = (int16_t)utc.hour,
	                    .utc_min = (int16_t)utc.minute,
	                    .utc_sec = (int16_t)utc.second,
	                    .leap_s = (int16_t)leap_s,
	                    .sync = 7};
	record_stamp(&time, log->now);
	put_block(log, RECEIVER_TIME, 0, &time);
}

/* The signals of an epoch as bits of their SBF numbers. */
static int64_t signals_of(const fw_epoch *epoch)
{
	int64_t bits = 0;
	for (unsigned i = 0; i < epoch->n; i++) {
		const fw_observation *o = &epoch->obs[i];
		if (i > 0 && fw_satellite_equal(o->satellite, epoch->obs[i - 1].satellite))
			continue; /* a satellite's first signal is the one that is used */
		for (unsigned number = 0; number < 32; number++) {
			const fw_sbf_signal *s = fw_sbf_signal_of(number);
			if (s != NULL && s->system == fw_system_letter((fw_system)o->satellite.system) &&
			    s->rinex[0] == o->signal.band && s->rinex[1] == o->signal.attribute)
				bits |= INT64_C(1) << number;
		}
	}
	return bits;
}

void sim_log_solution(sim_log *log, const fw_receiver_solution *s, bool sbas, const fw_epoch *epoch)
{
	furrow_pvt pvt;
	furrow_dop dop;
	pvt_record(s, log->now, sbas, signals_of(epoch), &pvt);
	dop_record(s, log->now, &dop);
	put_block(log, PVT_GEODETIC, 2, &pvt);
	put_block(log, POS_COV_GEODETIC, 0, &pvt);
	put_block(log, VEL_COV_GEODETIC, 0, &pvt);
	put_block(log, DOP, 0, &dop);
	put_marker(log, END_OF_PVT);
	if (log->now.ns % FW_NS_PER_S == 0)
		put_time(log);
}

void sim_log_attitude(sim_log *log, const fw_receiver_attitude *a, unsigned n_sats)
{
	furrow_att att;
	att_record(a, n_sats, log->now, &att);
	put_block(log, ATT_EULER, 0, &att);
	put_block(log, ATT_COV_EULER, 0, &att);
	put_marker(log, END_OF_ATT);
}

/* The receiver stamps with its own clock, counted from the last epoch; where that shows another time of
 * GPS. */
void sim_log_event(sim_log *log, fw_time t, double clock_s, double bias_s)
{
	furrow_event event = {.present = ALL(event), .source = 1};
	double offset = fw_time_diff_s(t, log->now) + clock_s;
	int week;
	record_stamp(&event, fw_time_add_ns(log->now, llround((offset - bias_s) * 1e9)));
	fw_time_to_gps_s(log->now, &week, &event.rx_tow_s);
	event.offset_s = offset;
	event.clock_bias_s = bias_s;
	put_block(log, EXT_EVENT, 1, &event);
}
