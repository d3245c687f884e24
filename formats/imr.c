#include "formats/imr.h"

#include <math.h>
#include <string.h>

#include "base/frame.h"
#include "formats/bytes.h"

enum { HEADER = 512, SAMPLE = 32, UTC = 1 };

static const char magic[8] = "$IMURAW";

bool fw_imr_detect(const uint8_t *bytes, size_t n)
{
	return n >= sizeof magic && memcmp(bytes, magic, sizeof magic) == 0;
}

void fw_imr_begin(fw_imr *r, fw_input *input, const fw_imu_plan *plan)
{
	static const fw_imu_axes rfu = {true, {1, 0, 2}, {1, 1, -1}};

	memset(r, 0, offsetof(fw_imr, window));
	r->reason = "";
	r->axes = plan->axes.given ? plan->axes : rfu;
	r->clock = plan->clock;
	fw_window_begin(&r->window, input);
}

static fw_status unknown(fw_imr *r, const char *reason)
{
	r->reason = reason;
	r->lost_offset = r->window.offset;
	r->lost++;
	return FW_EUNKNOWN;
}

static fw_status read_header(fw_imr *r)
{
	const uint8_t *b;

	if (!fw_window_need(&r->window, HEADER))
		return r->window.status == FW_EOF ? FW_ETRUNCATED : r->window.status;
	b = r->window.bytes;
	if (!fw_imr_detect(b, HEADER))
		return unknown(r, "no IMR header");
	if (b[8] != 0)
		return unknown(r, "an IMR file of a big-endian machine");
	if (fw_load_u32(b + 49) == UTC)
		return unknown(r, "an IMR file on UTC, whose leap seconds it does not say");
	if (!r->clock.has_week)
		return unknown(r, "which GPS week? --imu-time gps,week=N");
	r->gyro_increments = fw_load_u32(b + 17) != 0;
	r->accel_increments = fw_load_u32(b + 21) != 0;
	r->gyro_scale = fw_rad_from_deg(fw_load_f64(b + 33));
	r->accel_scale = fw_load_f64(b + 41);
	r->bias_s = fw_load_f64(b + 57);
	if (!isfinite(r->gyro_scale) || !isfinite(r->accel_scale) || !(fabs(r->bias_s) < 86400))
		return unknown(r, "an IMR header with impossible scale factors");
	fw_window_skip(&r->window, HEADER);
	r->begun = true;
	return FW_OK;
}

static fw_status lose(fw_imr *r, const char *reason)
{
	r->lost++;
	r->lost_offset = r->window.offset;
	r->reason = reason;
	fw_window_skip(&r->window, SAMPLE);
	return FW_ESYNTAX;
}

/* Time of week; when it falls by half a week or more, a week has ended. */
static fw_status sample_time(fw_imr *r, double tow_s, fw_time *t)
{
	int64_t ns;

	if (!(tow_s >= 0 && tow_s <= 2 * 604800.0))
		return FW_ERANGE;
	ns = (int64_t)r->clock.week * FW_NS_PER_WEEK + llround((tow_s + r->bias_s + r->clock.shift_s) * 1e9);
	while (r->rates.n > 0 && ns < r->rates.last.ns - FW_NS_PER_WEEK / 2)
		ns += FW_NS_PER_WEEK;
	if (ns < 0 || ns > FW_TIME_NS_MAX)
		return FW_ERANGE;
	t->ns = ns;
	return FW_OK;
}

/* FW_MORE: the first sample, of which nothing becomes. */
static fw_status read_sample(fw_imr *r)
{
	const uint8_t *b;
	double dt = 1, gyro[3], accel[3];
	fw_status status;
	fw_time t;

	if (!fw_window_need(&r->window, SAMPLE))
		return r->window.status == FW_EOF && r->window.n > 0 ? FW_ETRUNCATED : r->window.status;
	b = r->window.bytes;
	if (sample_time(r, fw_load_f64(b), &t) != FW_OK)
		return lose(r, "a sample without a time of week");
	status = fw_imu_rates_interval(&r->rates, t, &dt);
	if (status == FW_ERANGE && (r->gyro_increments || r->accel_increments))
		return lose(r, "increments, and the time does not advance");
	if (status == FW_MORE && (r->gyro_increments || r->accel_increments)) {
		fw_window_skip(&r->window, SAMPLE);
		return FW_MORE;
	}
	for (int i = 0; i < 3; i++) {
		gyro[i] = (int32_t)fw_load_u32(b + 8 + 4 * i) * r->gyro_scale / (r->gyro_increments ? dt : 1);
		accel[i] =
		    (int32_t)fw_load_u32(b + 20 + 4 * i) * r->accel_scale / (r->accel_increments ? dt : 1);
	}
	fw_imu_turn(&r->axes, gyro, gyro);
	fw_imu_turn(&r->axes, accel, accel);
	if (fw_log_put_imu(&r->queue, t, gyro, accel) != FW_OK)
		return lose(r, "a sample whose numbers are not finite");
	fw_window_skip(&r->window, SAMPLE);
	r->rows++;
	return FW_OK;
}

fw_status fw_imr_read(fw_imr *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status = r->final;

	if (status == FW_OK && !r->begun)
		status = read_header(r);
	while (status == FW_OK || status == FW_MORE) {
		if (fw_log_take(&r->queue, kind, record) == FW_OK)
			return FW_OK;
		status = read_sample(r);
	}
	if (status != FW_ESYNTAX)
		r->final = status;
	return status;
}
