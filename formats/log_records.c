#include "formats/log_records.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "furrow_baro_columns.h"
#include "furrow_event_columns.h"
#include "furrow_imu_columns.h"
#include "furrow_mag_columns.h"
#include "furrow_nav_columns.h"
#include "furrow_pos_columns.h"
#include "furrow_pvt_columns.h"

#define UNKNOWN ((double)NAN)

fw_log_fix fw_log_no_fix(void)
{
	return (fw_log_fix){
	    .lat_deg = UNKNOWN,
	    .lon_deg = UNKNOWN,
	    .height_m = UNKNOWN,
	    .undulation_m = UNKNOWN,
	    .velocity_mps = {UNKNOWN, UNKNOWN, UNKNOWN},
	    .sd_m = {UNKNOWN, UNKNOWN, UNKNOWN},
	    .sd_velocity_mps = {UNKNOWN, UNKNOWN, UNKNOWN},
	    .n_sats = -1,
	};
}

fw_log_nav fw_log_no_nav(void)
{
	return (fw_log_nav){
	    .lat_deg = UNKNOWN,
	    .lon_deg = UNKNOWN,
	    .height_m = UNKNOWN,
	    .velocity_mps = {UNKNOWN, UNKNOWN, UNKNOWN},
	    .angle_deg = {UNKNOWN, UNKNOWN, UNKNOWN},
	};
}

double fw_log_each_of_two(double horizontal)
{
	return horizontal / sqrt(2);
}

/* ---- the queue ---- */

static bool all_finite(const double v[static 3])
{
	return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

/* Room at the queue's end for a record of time t, with its head filled. */
static fw_status append(fw_log_queue *q, fw_kind kind, fw_time t, fw_any_record **record)
{
	const int at = (q->first + q->n) % FW_LOG_QUEUE_MAX;

	if (t.ns < 0 || t.ns > FW_TIME_NS_MAX)
		return FW_ERANGE;
	if (q->n == FW_LOG_QUEUE_MAX)
		return FW_ENOSPACE;
	q->n++;
	q->kind[at] = kind;
	*record = &q->record[at];
	fw_record_clear(kind, *record);
	(*record)->head.present = 3;
	fw_time_to_gps_s(t, &(*record)->head.gps_week, &(*record)->head.tow_s);
	return FW_OK;
}

fw_status fw_log_take(fw_log_queue *q, fw_kind *kind, fw_any_record *record)
{
	if (q->n == 0)
		return FW_MORE;
	*kind = q->kind[q->first];
	memcpy(record, &q->record[q->first], fw_record_type_of(*kind)->size);
	q->first = (q->first + 1) % FW_LOG_QUEUE_MAX;
	q->n--;
	return FW_OK;
}

/* ---- records ---- */

/* Sets a column of numbers, unless the value is not known. */
static void set(fw_kind kind, fw_any_record *record, int column, double value)
{
	const fw_column *c = &fw_record_type_of(kind)->columns[column];
	char *const member = record->bytes + c->offset;
	const float single = fabs(value) <= (double)FLT_MAX ? (float)value : 0;
	const int32_t whole = fabs(value) < 1e9 ? (int32_t)value : 0;
	const int16_t word = (int16_t)whole;
	const int8_t byte = (int8_t)whole;

	if (!isfinite(value) || (c->type == FW_F32 && fabs(value) > (double)FLT_MAX))
		return;
	record->head.present |= INT64_C(1) << column;
	switch (c->type) {
	case FW_F64: memcpy(member, &value, sizeof value); break;
	case FW_F32: memcpy(member, &single, sizeof single); break;
	case FW_I32: memcpy(member, &whole, sizeof whole); break;
	case FW_I16: memcpy(member, &word, sizeof word); break;
	case FW_I8: memcpy(member, &byte, sizeof byte); break;
	case FW_I64:
	case FW_STR: break;
	}
}

/* Three columns that follow one another. */
static void set3(fw_kind kind, fw_any_record *record, int column, const double v[static 3])
{
	for (int i = 0; i < 3; i++)
		set(kind, record, column + i, v[i]);
}

static void set_text(fw_kind kind, fw_any_record *record, int column, const char *text)
{
	if (text == NULL)
		return;
	memcpy(record->bytes + fw_record_type_of(kind)->columns[column].offset, &text, sizeof text);
	record->head.present |= INT64_C(1) << column;
}

fw_status fw_log_put_imu(fw_log_queue *q, fw_time t, const double gyro[static 3],
                         const double accel[static 3])
{
	fw_any_record *record;
	fw_status status;

	if (!all_finite(gyro) || !all_finite(accel))
		return FW_ENONFINITE;
	status = append(q, FW_imu, t, &record);
	if (status != FW_OK)
		return status;
	set3(FW_imu, record, FW_COL_imu_gyro_x_radps, gyro);
	set3(FW_imu, record, FW_COL_imu_accel_x_mps2, accel);
	return FW_OK;
}

fw_status fw_log_put_mag(fw_log_queue *q, fw_time t, const double field[static 3])
{
	fw_any_record *record;
	fw_status status;

	if (!all_finite(field))
		return FW_ENONFINITE;
	status = append(q, FW_mag, t, &record);
	if (status == FW_OK)
		set3(FW_mag, record, FW_COL_mag_mag_x_ut, field);
	return status;
}

fw_status fw_log_put_baro(fw_log_queue *q, fw_time t, double height_m)
{
	fw_any_record *record;
	fw_status status;

	if (!isfinite(height_m))
		return FW_ENONFINITE;
	status = append(q, FW_baro, t, &record);
	if (status == FW_OK)
		set(FW_baro, record, FW_COL_baro_baro_height_m, height_m);
	return status;
}

/* ---- positions ---- */

static fw_status check_place(double lat_deg, double lon_deg, double height_m)
{
	if (!isfinite(lat_deg) || !isfinite(lon_deg) || !isfinite(height_m))
		return FW_ENONFINITE;
	return fabs(lat_deg) <= 90 && fabs(lon_deg) <= 360 ? FW_OK : FW_ERANGE;
}

/* Longitudes are written -180..180. */
static double wrapped(double lon_deg)
{
	return lon_deg > 180 ? lon_deg - 360 : lon_deg < -180 ? lon_deg + 360 : lon_deg;
}

static double squared(double x)
{
	return x * x;
}

/* The position of a pvt with its accuracy. */
static void set_pvt_position(fw_any_record *record, const fw_log_fix *fix)
{
	static const int variances[3] = {FW_COL_pvt_cov_nn_m2, FW_COL_pvt_cov_ee_m2, FW_COL_pvt_cov_dd_m2};

	set(FW_pvt, record, FW_COL_pvt_lat_deg, fix->lat_deg);
	set(FW_pvt, record, FW_COL_pvt_lon_deg, wrapped(fix->lon_deg));
	set(FW_pvt, record, FW_COL_pvt_height_m, fix->height_m);
	set(FW_pvt, record, FW_COL_pvt_undulation_m, fix->undulation_m);
	set3(FW_pvt, record, FW_COL_pvt_sd_n_m, fix->sd_m);
	for (int i = 0; i < 3; i++)
		set(FW_pvt, record, variances[i], squared(fix->sd_m[i]));
}

static void set_pvt_velocity(fw_any_record *record, const fw_log_fix *fix)
{
	static const int variances[3] = {FW_COL_pvt_cov_vnvn_m2ps2, FW_COL_pvt_cov_veve_m2ps2,
	                                 FW_COL_pvt_cov_vdvd_m2ps2};

	set3(FW_pvt, record, FW_COL_pvt_vn_mps, fix->velocity_mps);
	for (int i = 0; i < 3; i++)
		set(FW_pvt, record, variances[i], squared(fix->sd_velocity_mps[i]));
}

fw_status fw_log_put_pvt(fw_log_queue *q, fw_time t, const fw_log_fix *fix)
{
	fw_any_record *record;
	fw_status status = fix->mode == 0 ? FW_OK : check_place(fix->lat_deg, fix->lon_deg, fix->height_m);

	if (status == FW_OK && (fix->mode < 0 || fix->mode > 10 || fix->n_sats > INT16_MAX))
		status = FW_ERANGE;
	if (status == FW_OK)
		status = append(q, FW_pvt, t, &record);
	if (status != FW_OK)
		return status;
	set(FW_pvt, record, FW_COL_pvt_mode, fix->mode);
	if (fix->n_sats >= 0)
		set(FW_pvt, record, FW_COL_pvt_n_sats, fix->n_sats);
	if (fix->mode == 0)
		return FW_OK;
	set(FW_pvt, record, FW_COL_pvt_two_d, fix->two_d);
	set_pvt_position(record, fix);
	set_pvt_velocity(record, fix);
	return FW_OK;
}

fw_status fw_log_put_pos(fw_log_queue *q, fw_time t, const fw_log_fix *fix, const char *quality, double ratio)
{
	fw_any_record *record;
	fw_status status = check_place(fix->lat_deg, fix->lon_deg, fix->height_m);

	if (status == FW_OK && fix->n_sats > INT16_MAX)
		status = FW_ERANGE;
	if (status == FW_OK)
		status = append(q, FW_pos, t, &record);
	if (status != FW_OK)
		return status;
	set(FW_pos, record, FW_COL_pos_lat_deg, fix->lat_deg);
	set(FW_pos, record, FW_COL_pos_lon_deg, wrapped(fix->lon_deg));
	set(FW_pos, record, FW_COL_pos_height_m, fix->height_m);
	set3(FW_pos, record, FW_COL_pos_sd_n_m, fix->sd_m);
	set_text(FW_pos, record, FW_COL_pos_quality, quality);
	if (fix->n_sats >= 0)
		set(FW_pos, record, FW_COL_pos_n_sats, fix->n_sats);
	set(FW_pos, record, FW_COL_pos_ratio, ratio);
	set3(FW_pos, record, FW_COL_pos_vn_mps, fix->velocity_mps);
	set3(FW_pos, record, FW_COL_pos_sd_vn_mps, fix->sd_velocity_mps);
	return FW_OK;
}

fw_status fw_log_put_nav(fw_log_queue *q, fw_time t, const fw_log_nav *nav, const char *status_text)
{
	const fw_status place = check_place(nav->lat_deg, nav->lon_deg, nav->height_m);
	const bool attitude = all_finite(nav->angle_deg), velocity = all_finite(nav->velocity_mps);
	fw_any_record *record;
	fw_status status;

	if (place != FW_OK && !attitude && !velocity)
		return place;
	status = append(q, FW_nav, t, &record);
	if (status != FW_OK)
		return status;
	if (place == FW_OK) {
		set(FW_nav, record, FW_COL_nav_lat_deg, nav->lat_deg);
		set(FW_nav, record, FW_COL_nav_lon_deg, wrapped(nav->lon_deg));
		set(FW_nav, record, FW_COL_nav_height_m, nav->height_m);
	}
	if (velocity)
		set3(FW_nav, record, FW_COL_nav_vn_mps, nav->velocity_mps);
	if (attitude) {
		const double heading = fmod(nav->angle_deg[2], 360);

		set(FW_nav, record, FW_COL_nav_roll_deg, nav->angle_deg[0]);
		set(FW_nav, record, FW_COL_nav_pitch_deg, nav->angle_deg[1]);
		set(FW_nav, record, FW_COL_nav_heading_deg, heading < 0 ? heading + 360 : heading);
	}
	set_text(FW_nav, record, FW_COL_nav_status, status_text);
	return FW_OK;
}

fw_status fw_log_put_event(fw_log_queue *q, fw_time t, int source)
{
	fw_any_record *record;
	fw_status status = append(q, FW_event, t, &record);

	if (status != FW_OK)
		return status;
	set(FW_event, record, FW_COL_event_source, source);
	return FW_OK;
}
