#include "formats/sbf_decoder.h"

#include <math.h>
#include <string.h>

#include "formats/sbas_message.h"
#include "formats/sbf_schema.h"
#include "formats/sbf_signal.h"
#include "furrow_imu.h"
#include "furrow_imu_columns.h"

enum {
	MEAS_EXTRA = 4000,
	GEO_RAW_L1 = 4020,
	MEAS_EPOCH = 4027,
	EXT_SENSOR_MEAS = 4050,
	MEAS3_FIRST = 4109,
	MEAS3_LAST = 4113,
	IMU_SETUP = 4224,
	END_OF_PVT = 5921,
	END_OF_MEAS = 5922,
	END_OF_ATT = 5943
};

enum { PVT, PVT_ECEF, ATT, IMU };

static const fw_kind merged_kinds[FW_SBF_MERGED] = {FW_pvt, FW_pvt_ecef, FW_att, FW_imu};

/* The blocks that are a part of a merged record. */
static const struct {
	uint16_t id;
	uint8_t record, part;
} parts[] = {
    {4007, PVT, 1},      {5906, PVT, 2},      {5908, PVT, 4}, {4006, PVT_ECEF, 1},
    {5905, PVT_ECEF, 2}, {5907, PVT_ECEF, 4}, {5938, ATT, 1}, {5939, ATT, 2},
};

/* Kinds that hold what satellites broadcast: chosen by their source. */
static const fw_kind nav_kinds[] = {
    FW_eph_gps,      FW_eph_bds,      FW_eph_gal,      FW_eph_glo,        FW_eph_sbas,
    FW_klobuchar,    FW_nequick,      FW_utc,          FW_ggto,           FW_glo_time,
    FW_sbas_mt0,     FW_sbas_mask,    FW_sbas_fast,    FW_sbas_integrity, FW_sbas_degradation,
    FW_sbas_factors, FW_sbas_time,    FW_sbas_almanac, FW_sbas_igp_mask,  FW_sbas_long,
    FW_sbas_iono,    FW_sbas_service, FW_sbas_cov,     FW_sbas5_nav,      FW_sbas5_almanac,
};

static int is_nav_kind(fw_kind kind)
{
	for (size_t i = 0; i < sizeof nav_kinds / sizeof nav_kinds[0]; i++)
		if (nav_kinds[i] == kind)
			return 1;
	return 0;
}

static void emit(const fw_sbf_decoder *d, fw_kind kind, const void *record)
{
	if (fw_kind_in(&d->options.wanted, kind))
		d->sink.put(d->sink.context, kind, record);
}

/* ---- records that are put together ---- */

static void close_record(fw_sbf_decoder *d, int which)
{
	if (d->pending[which].parts == 0)
		return;
	d->pending[which].parts = 0;
	emit(d, merged_kinds[which], &d->pending[which].record);
}

void fw_sbf_decoder_flush(fw_sbf_decoder *d)
{
	const fw_sbf_meas3_stats *m = &d->meas3.stats;
	fw_sbf_meas3_flush(&d->meas3);
	d->stats.left_out.other_antenna += m->other_antenna;
	d->stats.scrambled += m->scrambled;
	d->stats.no_reference += m->lost_epochs;
	d->stats.malformed += m->malformed;
	for (int which = 0; which < FW_SBF_MERGED; which++)
		close_record(d, which);
}

/* A block of the receiver's time scale with another time tag ends the epoch. */
static void follow_epoch(fw_sbf_decoder *d, const fw_sbf_block *block)
{
	if (block->tow_ms == d->epoch_tow_ms && block->week == d->epoch_week)
		return;
	close_record(d, PVT);
	close_record(d, PVT_ECEF);
	close_record(d, ATT);
	d->epoch_tow_ms = block->tow_ms;
	d->epoch_week = block->week;
}

static void add_part(fw_sbf_decoder *d, const fw_sbf_block *block, int which, unsigned part)
{
	if (!fw_kind_in(&d->options.wanted, merged_kinds[which]))
		return;
	if (d->pending[which].parts & part)
		close_record(d, which); /* a second one with the same time tag is a record of its own */
	if (d->pending[which].parts == 0)
		fw_record_clear(merged_kinds[which], &d->pending[which].record);
	if (fw_sbf_fill(&d->plans, block->data, block->length, &d->pending[which].record) == FW_OK)
		d->pending[which].parts |= part;
	else
		d->stats.malformed++;
}

/* ---- inertial samples: rates and accelerations may come in blocks of their own ---- */

static int same_stamp(const fw_record_head *a, const fw_record_head *b)
{
	return (a->present & 3) == 3 && (b->present & 3) == 3 && a->gps_week == b->gps_week &&
	       fabs(a->tow_s - b->tow_s) < 1e-9;
}

static void put_sensor(void *context, fw_kind kind, const void *record)
{
	enum { GYRO = 7 << FW_COL_imu_gyro_x_radps, ACCEL = 7 << FW_COL_imu_accel_x_mps2 };
	fw_sbf_decoder *d = context;
	const furrow_imu *imu = record;
	furrow_imu *held = (furrow_imu *)&d->pending[IMU].record;
	if (kind != FW_imu) {
		emit(d, kind, record);
		return;
	}
	if (d->pending[IMU].parts != 0 && (!same_stamp((const fw_record_head *)held, record) ||
	                                   (held->present & imu->present & (GYRO | ACCEL))))
		close_record(d, IMU);
	if (d->pending[IMU].parts == 0) {
		*held = *imu;
	} else if (imu->present & GYRO) {
		held->gyro_x_radps = imu->gyro_x_radps;
		held->gyro_y_radps = imu->gyro_y_radps;
		held->gyro_z_radps = imu->gyro_z_radps;
	} else {
		held->accel_x_mps2 = imu->accel_x_mps2;
		held->accel_y_mps2 = imu->accel_y_mps2;
		held->accel_z_mps2 = imu->accel_z_mps2;
	}
	held->present |= imu->present;
	d->pending[IMU].parts = 1;
	if ((held->present & GYRO) && (held->present & ACCEL))
		close_record(d, IMU);
}

/* ---- measurements ---- */

/* What Meas3 says, unless the same epoch has come as MeasEpoch. */
static void put_meas3(void *context, fw_kind kind, const void *record)
{
	fw_sbf_decoder *d = context;
	const fw_record_head *head = record;
	const fw_record_head known = {(d->channels.week != FW_SBF_NO_WEEK ? 1 : 0) |
	                                  (d->channels.tow_ms != FW_SBF_NO_TOW ? 2 : 0),
	                              d->channels.week, d->channels.tow_ms / 1000.0};
	if (!(d->seen[MEAS_EPOCH] && same_stamp(head, &known)))
		emit(d, kind, record);
}

/* ---- navigation ---- */

static void put_raw(void *context, fw_kind kind, const void *record)
{
	emit(context, kind, record);
}

/* GEORawL1: 8 little-endian words whose most significant bit came first. */
static void decode_sbas(fw_sbf_decoder *d, const fw_sbf_block *block)
{
	enum { BITS = 20 };
	uint8_t message[FW_SBAS_BYTES];
	fw_record_head stamp = {0, block->week, block->tow_ms / 1000.0};
	if (block->length < BITS + FW_SBAS_BYTES || block->data[15] != 1) {
		d->stats.bad_pages++;
		return;
	}
	for (int i = 0; i < FW_SBAS_BYTES; i++)
		message[i] = block->data[BITS + (i ^ 3)];
	stamp.present = (block->week != FW_SBF_NO_WEEK ? 1 : 0) | (block->tow_ms != FW_SBF_NO_TOW ? 2 : 0);
	fw_status status =
	    fw_sbas_decode(message, fw_sbf_satellite(block->data[14]), &stamp, (fw_sink){put_raw, d});
	d->stats.bad_pages += status == FW_ECHECKSUM || status == FW_EFORMAT;
}

static void decode_page(fw_sbf_decoder *d, const fw_sbf_block *block)
{
	const fw_sink sink = {put_raw, d};
	fw_status status = fw_nav_block(&d->nav, block->data, block->length, &sink);
	d->stats.bad_pages += status == FW_ECHECKSUM || status == FW_EFORMAT;
}

/* ---- all blocks ---- */

/* What is to be done with a block; flags go with it. */
enum {
	UNKNOWN,   /* count it */
	PASS_OVER, /* nothing that was asked for is in it */
	TABLE,     /* one record, or one for each sub-block, by the schema */
	PART,      /* of a merged record */
	MEASUREMENTS,
	EXTRA,
	MEAS3,
	SENSORS,
	CLOSE_PVT,
	CLOSE_ATT,
	ACTION = 15,
	NEW_EPOCH = 16, /* its stamp is that of the receiver's epoch */
	PAGE = 32,      /* raw navigation page to be decoded */
	MESSAGE = 64    /* raw SBAS message to be decoded */
};

static const fw_kind measured[] = {FW_obs, FW_epoch, FW_obs_extra};

static int any_wanted(const fw_sbf_decoder_options *o, const fw_kind *kinds, size_t n)
{
	for (size_t i = 0; i < n; i++)
		if (fw_kind_in(&o->wanted, kinds[i]))
			return 1;
	return 0;
}

static int is_part(uint16_t id)
{
	for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
		if (parts[i].id == id)
			return 1;
	return 0;
}

static uint8_t choose_action(const fw_sbf_schema *schema, const fw_sbf_decoder_options *o)
{
	static const fw_kind sensed[] = {FW_imu, FW_ext_sensor};
	switch (schema->id) {
	case MEAS_EPOCH: return any_wanted(o, measured, 3) ? MEASUREMENTS : PASS_OVER;
	case MEAS_EXTRA: return any_wanted(o, &measured[2], 1) ? EXTRA : PASS_OVER;
	case EXT_SENSOR_MEAS: return any_wanted(o, sensed, 2) ? SENSORS : PASS_OVER;
	case IMU_SETUP: return TABLE; /* later samples need it */
	case END_OF_MEAS: return any_wanted(o, measured, 3) ? MEAS3 : PASS_OVER;
	case END_OF_PVT: return CLOSE_PVT;
	case END_OF_ATT: return CLOSE_ATT;
	default: break;
	}
	if (schema->kind == FW_RECORD_COUNT || !fw_kind_in(&o->wanted, schema->kind) ||
	    (is_nav_kind(schema->kind) && !(o->nav_sources & FW_NAV_DECODED)))
		return PASS_OVER;
	return is_part(schema->id) ? PART : TABLE;
}

static void choose_actions(fw_sbf_decoder *d)
{
	const fw_sbf_decoder_options *o = &d->options;
	const int raw =
	    (o->nav_sources & FW_NAV_RAW) && any_wanted(o, nav_kinds, sizeof nav_kinds / sizeof nav_kinds[0]);

	memset(d->actions, UNKNOWN, sizeof d->actions);
	for (unsigned id = MEAS3_FIRST; id <= MEAS3_LAST; id++)
		d->actions[id] = any_wanted(o, measured, 3) ? MEAS3 | NEW_EPOCH : PASS_OVER;
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		const fw_sbf_schema *schema = &fw_sbf_schemas[i];
		uint8_t action = choose_action(schema, o);
		if (schema->time == SBF_TIME_RECEIVER)
			action |= NEW_EPOCH;
		if (raw && schema->id == GEO_RAW_L1)
			action |= MESSAGE;
		else if (raw && fw_nav_reads(schema->id))
			action |= PAGE;
		d->actions[schema->id] = action;
	}
}

void fw_sbf_decoder_init(fw_sbf_decoder *d, const fw_sbf_decoder_options *options, fw_sink sink)
{
	memset(&d->stats, 0, sizeof d->stats);
	memset(d->seen, 0, sizeof d->seen);
	d->options = *options;
	d->sink = sink;
	fw_sbf_plans_init(&d->plans);
	memset(&d->channels, 0, sizeof d->channels);
	fw_nav_init(&d->nav);
	d->epoch_tow_ms = FW_SBF_NO_TOW;
	d->epoch_week = FW_SBF_NO_WEEK;
	for (int which = 0; which < FW_SBF_MERGED; which++)
		d->pending[which].parts = 0;
	fw_sbf_meas3_init(&d->meas3, options->antennas, &options->wanted, (fw_sink){put_meas3, d});
	choose_actions(d);
}

static void put_part(fw_sbf_decoder *d, const fw_sbf_block *block)
{
	for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
		if (parts[i].id == block->id)
			add_part(d, block, parts[i].record, parts[i].part);
}

static void put_by_table(fw_sbf_decoder *d, const fw_sbf_block *block, fw_sink sink)
{
	if (fw_sbf_emit(&d->plans, block->data, block->length, &d->options.wanted, sink) == FW_EFORMAT)
		d->stats.malformed++;
}

void fw_sbf_decoder_put(fw_sbf_decoder *d, const fw_sbf_block *block)
{
	const uint8_t action = d->actions[block->id];
	const uint16_t length = (uint16_t)block->length;

	d->seen[block->id] = true;
	if (action & NEW_EPOCH)
		follow_epoch(d, block);
	switch (action & ACTION) {
	case UNKNOWN: d->stats.unknown++; break;
	case TABLE: put_by_table(d, block, d->sink); break;
	case MEAS3:
		(void)!fw_sbf_meas3_put(&d->meas3, block->data, length);
		break; /* it counts what is wrong */
	case SENSORS: put_by_table(d, block, (fw_sink){put_sensor, d}); break;
	case PART: put_part(d, block); break;
	case MEASUREMENTS:
		if (fw_sbf_is_scrambled(block->data, length))
			d->stats.scrambled++;
		fw_sbf_meas_epoch(block->data, length, d->options.antennas, &d->options.wanted, d->sink,
		                  &d->channels, &d->stats.left_out);
		break;
	case EXTRA: fw_sbf_meas_extra(block->data, length, d->options.antennas, &d->channels, d->sink); break;
	case CLOSE_PVT:
		close_record(d, PVT);
		close_record(d, PVT_ECEF);
		break;
	case CLOSE_ATT: close_record(d, ATT); break;
	default: break;
	}
	if (action & MESSAGE)
		decode_sbas(d, block);
	else if (action & PAGE)
		decode_page(d, block);
}

const char *fw_sbf_decoder_records(uint16_t id)
{
	const fw_sbf_schema *schema = fw_sbf_schema_find(id);
	switch (id) {
	case MEAS_EPOCH: return "obs epoch";
	case MEAS_EXTRA: return "obs_extra";
	case EXT_SENSOR_MEAS: return "imu ext_sensor";
	case MEAS3_FIRST: return "obs epoch obs_extra";
	default:
		return schema != NULL && schema->kind != FW_RECORD_COUNT
		           ? fw_record_type_of(schema->kind)->name
		           : "";
	}
}

void fw_sbf_decoder_offered(const fw_sbf_decoder *d, fw_kind_set *offered)
{
	for (unsigned id = 0; id < FW_SBF_IDS; id++) {
		if (!d->seen[id])
			continue;
		for (const char *name = fw_sbf_decoder_records((uint16_t)id); *name != '\0';) {
			size_t n = strcspn(name, " ");
			fw_kind_add(offered, fw_record_find(name, n));
			name += n + (name[n] == ' ');
		}
	}
}
