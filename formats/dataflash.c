#include "formats/dataflash.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/frame.h"
#include "formats/bytes.h"
#include "formats/number.h"

#define UNKNOWN ((double)NAN)

/* AP_GPS_UBLOX::get_lag(): receivers of series 7 and later [s] */
#define UBLOX_LAG_S 0.12

#define MILLIGAUSS_UT 0.1

enum {
	FMT_ID = 0x80,
	FMT_LENGTH = 89,
	PADDING = 16,              /* so many equal bytes behind a message are padding */
	GPA_WITHIN_US = 50000,     /* GPA is written right after its GPS */
	FIX_WAITS_US = 200000,     /* for a GPA */
	RAW_DECISION_US = 1000000, /* ACC and GYR without an IMU for so long: there is none */
	RAW_SPAN_US = 100000,      /* samples that are further apart are not averaged */
	TEXT_LABELS = 5            /* field of a text FMT at which the columns' names begin */
};

/* What furrow makes of messages. */
enum { IMU, ACC, GYR, MAG, BARO, GPS, GPA, ATT, AHR2, CAM, TRIG, PARM, KINDS };

/* Columns that all of them have, or may have. */
enum { TIME, INSTANCE, FIRST };

static const struct {
	const char *name, *columns[FW_DATAFLASH_FIELDS];
} kinds[KINDS] = {
    [IMU] = {"IMU", {"TimeUS", "I", "GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ", "GH", "AH"}},
    [ACC] = {"ACC", {"TimeUS", "I", "AccX", "AccY", "AccZ", "SampleUS"}},
    [GYR] = {"GYR", {"TimeUS", "I", "GyrX", "GyrY", "GyrZ", "SampleUS"}},
    [MAG] = {"MAG", {"TimeUS", "I", "MagX", "MagY", "MagZ", "Health"}},
    [BARO] = {"BARO", {"TimeUS", "I", "Alt", "Health"}},
    [GPS] = {"GPS",
             {"TimeUS", "I", "Status", "GMS", "GWk", "NSats", "Lat", "Lng", "Alt", "Spd", "GCrs", "VZ", "U"}},
    [GPA] = {"GPA", {"TimeUS", "I", "HAcc", "VAcc", "SAcc", "AEl", "VV"}},
    [ATT] = {"ATT", {"TimeUS", "I", "Roll", "Pitch", "Yaw"}},
    [AHR2] = {"AHR2", {"TimeUS", "I", "Roll", "Pitch", "Yaw"}},
    [CAM] = {"CAM", {"TimeUS", "I"}},
    [TRIG] = {"TRIG", {"TimeUS", "I"}},
    [PARM] = {"PARM", {"TimeUS", "I", "Name", "Value"}},
};

enum { IMU_GYRO = FIRST, IMU_ACCEL = FIRST + 3, IMU_GH = FIRST + 6, IMU_AH };
enum { RAW_X = FIRST, RAW_SAMPLE = FIRST + 3 };
enum { MAG_X = FIRST, MAG_HEALTH = FIRST + 3 };
enum { BARO_ALT = FIRST, BARO_HEALTH };
enum {
	GPS_STATUS = FIRST,
	GPS_MS,
	GPS_WEEK,
	GPS_NSATS,
	GPS_LAT,
	GPS_LNG,
	GPS_ALT,
	GPS_SPD,
	GPS_CRS,
	GPS_VZ,
	GPS_USED
};
enum { GPA_H = FIRST, GPA_V, GPA_S, GPA_ELLIPSOID, GPA_VV };
enum { ATT_ROLL = FIRST };
enum { PARM_NAME = FIRST, PARM_VALUE };

/* Whose instances are chosen. */
enum { OF_IMU, OF_MAG, OF_BARO, OF_GPS };

/* A message's columns that furrow reads: NaN where it has none. */
typedef struct {
	int kind, instance;
	int64_t us;
	double v[FW_DATAFLASH_FIELDS];
	const char *text; /* of PARM's name */
	size_t n_text;
} message;

fw_dataflash_kind fw_dataflash_detect(const uint8_t *bytes, size_t n)
{
	if (n >= 3 && bytes[0] == 0xa3 && bytes[1] == 0x95 && bytes[2] == FMT_ID)
		return FW_DATAFLASH_BINARY;
	if (n >= 4 && memcmp(bytes, "FMT,", 4) == 0)
		return FW_DATAFLASH_TEXT;
	return FW_DATAFLASH_NONE;
}

fw_dataflash_plan fw_dataflash_default_plan(void)
{
	return (fw_dataflash_plan){-1, -1, -1, -1, UNKNOWN};
}

/* What a reading begins with, be it the first or the second. */
static void restart(fw_dataflash *r, fw_input *input)
{
	r->messages = r->lost = r->bytes_lost = r->lost_offset = r->untimed = r->unhealthy = 0;
	r->reason = "";
	r->msl = r->surveying = r->searching = r->fix_waits = false;
	r->final = FW_OK;
	r->queue.first = r->queue.n = 0;
	r->raw_since_us = r->raw_begin_us = -1;
	r->raw_n[0] = r->raw_n[1] = 0;
	if (r->text)
		fw_lines_begin(&r->from.lines, input);
	else
		fw_window_begin(&r->from.window, input);
}

void fw_dataflash_begin(fw_dataflash *r, fw_input *input, fw_dataflash_kind kind,
                        const fw_dataflash_plan *plan)
{
	memset(r, 0, offsetof(fw_dataflash, from));
	r->plan = plan != NULL ? *plan : fw_dataflash_default_plan();
	r->text = kind == FW_DATAFLASH_TEXT;
	r->log_lag_s = UNKNOWN;
	r->chosen[OF_IMU] = r->plan.imu;
	r->chosen[OF_MAG] = r->plan.mag;
	r->chosen[OF_BARO] = r->plan.baro;
	r->chosen[OF_GPS] = r->plan.gps;
	fw_boot_clock_begin(&r->clock);
	restart(r, input);
}

void fw_dataflash_again(fw_dataflash *r, fw_input *input)
{
	r->reread = true;
	restart(r, input);
}

/* ---- what a message becomes ---- */

/* GPS time of a time since boot; false: none yet. */
static bool boot_time(fw_dataflash *r, int64_t us, fw_time *t)
{
	const double lag_s = isfinite(r->plan.lag_s)  ? r->plan.lag_s
	                     : isfinite(r->log_lag_s) ? r->log_lag_s
	                                              : UBLOX_LAG_S;

	if (r->surveying)
		return false;
	if (fw_boot_clock_time(&r->clock, us, lag_s, t) == FW_OK)
		return true;
	r->untimed++;
	return false;
}

/* Whether the message is of the instance that is read; the first healthy one is. */
static bool is_chosen(fw_dataflash *r, int whose, int instance, bool healthy)
{
	if (r->chosen[whose] < 0 && healthy)
		r->chosen[whose] = instance;
	return r->chosen[whose] == instance;
}

/* A column that says 0 means no; one that is not there means nothing. */
static bool says_no(double x)
{
	return x == 0;
}

static void count_unhealthy(fw_dataflash *r, fw_status status)
{
	r->unhealthy += status != FW_OK && !r->surveying;
}

static void take_imu(fw_dataflash *r, const message *m)
{
	const bool healthy = !says_no(m->v[IMU_GH]) && !says_no(m->v[IMU_AH]);
	fw_time t;

	if (!is_chosen(r, OF_IMU, m->instance, healthy) || r->raw_in_use)
		return;
	r->has_imu = true;
	if (!boot_time(r, m->us, &t))
		return;
	count_unhealthy(r, healthy ? fw_log_put_imu(&r->queue, t, &m->v[IMU_GYRO], &m->v[IMU_ACCEL])
	                           : FW_EINVAL);
}

/* ACC or GYR: averaged until there is one of each. */
static void take_raw(fw_dataflash *r, const message *m)
{
	const int which = m->kind == GYR;
	const double sample = m->v[RAW_SAMPLE];
	const int64_t us = sample > 0 && sample < 0x1p48 ? (int64_t)sample : m->us;
	double mean[2][3];
	fw_time t;

	if (!is_chosen(r, OF_IMU, m->instance, true) || r->has_imu)
		return;
	if (r->raw_since_us < 0)
		r->raw_since_us = m->us;
	r->raw_in_use |= r->reread || m->us - r->raw_since_us > RAW_DECISION_US;
	if (!r->raw_in_use)
		return;
	if (r->raw_begin_us < 0 || us - r->raw_begin_us > RAW_SPAN_US || us < r->raw_begin_us) {
		r->raw_begin_us = us;
		memset(r->raw_sum, 0, sizeof r->raw_sum);
		r->raw_n[0] = r->raw_n[1] = 0;
	}
	r->raw_n[which]++;
	for (int i = 0; i < 3; i++)
		r->raw_sum[which][i] += m->v[RAW_X + i];
	if (r->raw_n[0] == 0 || r->raw_n[1] == 0)
		return;
	for (int i = 0; i < 6; i++)
		mean[i / 3][i % 3] = r->raw_sum[i / 3][i % 3] / r->raw_n[i / 3];
	r->raw_begin_us = -1;
	if (boot_time(r, us, &t))
		count_unhealthy(r, fw_log_put_imu(&r->queue, t, mean[1], mean[0]));
}

static void take_mag(fw_dataflash *r, const message *m)
{
	const bool healthy = !says_no(m->v[MAG_HEALTH]);
	double field_ut[3];
	fw_time t;

	if (!is_chosen(r, OF_MAG, m->instance, healthy) || !boot_time(r, m->us, &t))
		return;
	for (int i = 0; i < 3; i++)
		field_ut[i] = m->v[MAG_X + i] * MILLIGAUSS_UT;
	count_unhealthy(r, healthy ? fw_log_put_mag(&r->queue, t, field_ut) : FW_EINVAL);
}

static void take_baro(fw_dataflash *r, const message *m)
{
	const bool healthy = !says_no(m->v[BARO_HEALTH]);
	fw_time t;

	if (is_chosen(r, OF_BARO, m->instance, healthy) && boot_time(r, m->us, &t))
		count_unhealthy(r, healthy ? fw_log_put_baro(&r->queue, t, m->v[BARO_ALT]) : FW_EINVAL);
}

static void take_attitude(fw_dataflash *r, const message *m)
{
	fw_log_nav nav = fw_log_no_nav();
	fw_time t;

	r->has_att |= m->kind == ATT;
	if ((m->kind == AHR2 && r->has_att) || !boot_time(r, m->us, &t))
		return;
	memcpy(nav.angle_deg, &m->v[ATT_ROLL], sizeof nav.angle_deg);
	count_unhealthy(r, fw_log_put_nav(&r->queue, t, &nav, "autopilot"));
}

static void take_event(fw_dataflash *r, const message *m)
{
	fw_time t;

	if (boot_time(r, m->us, &t))
		count_unhealthy(r, fw_log_put_event(&r->queue, t, m->kind == CAM ? 1 : 2));
}

static void take_parameter(fw_dataflash *r, const message *m)
{
	static const char *const names[] = {"GPS_DELAY_MS", "GPS1_DELAY_MS"};
	const double ms = m->v[PARM_VALUE];

	for (size_t i = 0; i < 2; i++)
		if (m->n_text == strlen(names[i]) && memcmp(m->text, names[i], m->n_text) == 0 && ms > 0 &&
		    ms < 10000)
			r->log_lag_s = ms / 1000;
}

/* ---- positions ---- */

/* The mode of pvt from AP_GPS::GPS_Status: 3 3D, 4 DGPS, 5 RTK float, 6 RTK fixed. */
static int mode_of(double status)
{
	static const int modes[] = {0, 0, 1, 1, 2, 5, 4};

	return status >= 0 && status <= 6 ? modes[(int)status] : 0;
}

static void flush_fix(fw_dataflash *r)
{
	if (!r->fix_waits)
		return;
	r->fix_waits = false;
	if (r->surveying)
		return;
	if (!isfinite(r->fix.height_m)) {
		r->fix.height_m = r->fix_msl_m;
		r->msl |= r->fix.mode != 0;
	}
	count_unhealthy(r, fw_log_put_pvt(&r->queue, r->fix_time, &r->fix));
}

static bool gps_time(const message *m, fw_time *t)
{
	const double week = m->v[GPS_WEEK], ms = m->v[GPS_MS];

	return week >= 1 && week <= FW_TIME_WEEK_MAX && ms >= 0 && ms < 604800e3 &&
	       fw_time_from_gps((int)week, (int64_t)ms * 1000000, t) == FW_OK;
}

static void take_gps(fw_dataflash *r, const message *m)
{
	const double *v = m->v, course = fw_rad_from_deg(v[GPS_CRS]);
	const bool used = !says_no(v[GPS_USED]);
	fw_time t;

	flush_fix(r);
	if (r->plan.gps < 0 && isfinite(v[GPS_USED]) ? !used : !is_chosen(r, OF_GPS, m->instance, true))
		return;
	if (!gps_time(m, &t)) {
		r->untimed += !r->surveying;
		return;
	}
	if (v[GPS_STATUS] >= 3)
		fw_boot_clock_add(&r->clock, m->us, t);
	r->fix = fw_log_no_fix();
	r->fix.mode = mode_of(v[GPS_STATUS]);
	r->fix.two_d = v[GPS_STATUS] == 2;
	r->fix.lat_deg = v[GPS_LAT];
	r->fix.lon_deg = v[GPS_LNG];
	r->fix.velocity_mps[0] = v[GPS_SPD] * cos(course);
	r->fix.velocity_mps[1] = v[GPS_SPD] * sin(course);
	r->fix.velocity_mps[2] = v[GPS_VZ];
	if (v[GPS_NSATS] >= 0 && v[GPS_NSATS] < 255)
		r->fix.n_sats = (int)v[GPS_NSATS];
	r->fix_msl_m = v[GPS_ALT];
	r->fix_time = t;
	r->fix_us = m->us;
	r->fix_instance = m->instance;
	r->fix_waits = true;
}

/* A standard deviation; 0 is "not known". */
static double deviation(double x)
{
	return x > 0 ? x : UNKNOWN;
}

static void take_accuracy(fw_dataflash *r, const message *m)
{
	const double *v = m->v;

	if (!r->fix_waits || m->instance != r->fix_instance || m->us < r->fix_us ||
	    m->us - r->fix_us > GPA_WITHIN_US)
		return;
	r->fix.sd_m[0] = r->fix.sd_m[1] = fw_log_each_of_two(deviation(v[GPA_H]));
	r->fix.sd_m[2] = deviation(v[GPA_V]);
	r->fix.sd_velocity_mps[0] = r->fix.sd_velocity_mps[1] = fw_log_each_of_two(deviation(v[GPA_S]));
	r->fix.sd_velocity_mps[2] = deviation(v[GPA_S]);
	if (says_no(v[GPA_VV]))
		r->fix.velocity_mps[2] = r->fix.sd_velocity_mps[2] = UNKNOWN;
	if (fabs(v[GPA_ELLIPSOID]) < 1e5) {
		r->fix.height_m = v[GPA_ELLIPSOID];
		r->fix.undulation_m = v[GPA_ELLIPSOID] - r->fix_msl_m;
	}
	flush_fix(r);
}

/* ---- messages ---- */

static void take_message(fw_dataflash *r, const message *m)
{
	if (r->fix_waits && m->us > r->fix_us + FIX_WAITS_US)
		flush_fix(r);
	switch (m->kind) {
	case IMU: take_imu(r, m); break;
	case ACC:
	case GYR: take_raw(r, m); break;
	case MAG: take_mag(r, m); break;
	case BARO: take_baro(r, m); break;
	case GPS: take_gps(r, m); break;
	case GPA: take_accuracy(r, m); break;
	case ATT:
	case AHR2: take_attitude(r, m); break;
	case CAM:
	case TRIG: take_event(r, m); break;
	case PARM: take_parameter(r, m); break;
	default: break;
	}
}

/* Time and instance, which come before all else. Returns false: there is no time. */
static bool complete(const fw_dataflash_type *type, message *m)
{
	m->kind = type->kind;
	if (!(m->v[TIME] >= 0 && m->v[TIME] < 0x1p48))
		return false;
	m->us = (int64_t)m->v[TIME];
	m->instance = m->v[INSTANCE] >= 0 && m->v[INSTANCE] < 128 ? (int)m->v[INSTANCE] : type->instance;
	return true;
}

/* ---- definitions ---- */

/* The kind of messages with a name: "IMU", or as old logs have it "IMU2" for instance 1, "ACC1" for 0; -1: of
 * no use. */
static int kind_of(const char *name, uint8_t *instance)
{
	const size_t n = strlen(name);
	const bool numbered = n > 1 && name[n - 1] >= '1' && name[n - 1] <= '9';

	*instance = 0;
	for (int kind = 0; kind < KINDS; kind++)
		if (strcmp(name, kinds[kind].name) == 0)
			return kind;
	if (!numbered)
		return -1;
	*instance = (uint8_t)(name[n - 1] - '1');
	if (n == 4 && memcmp(name, "BAR", 3) == 0)
		return BARO;
	for (int kind = 0; kind < KINDS; kind++)
		if (strlen(kinds[kind].name) == n - 1 && memcmp(name, kinds[kind].name, n - 1) == 0)
			return kind;
	return -1;
}

/* Bytes of a column; 0: no such type. */
static size_t width_of(char type)
{
	switch (type) {
	case 'b':
	case 'B':
	case 'M': return 1;
	case 'h':
	case 'H':
	case 'c':
	case 'C':
	case 'g': return 2;
	case 'i':
	case 'I':
	case 'f':
	case 'n':
	case 'e':
	case 'E':
	case 'L': return 4;
	case 'd':
	case 'q':
	case 'Q': return 8;
	case 'N': return 16;
	case 'Z':
	case 'a': return 64;
	default: return 0;
	}
}

/* Notes where the columns are that furrow reads. `offset` counts from the message's beginning. */
static void note_column(fw_dataflash_type *type, const char *label, size_t n, char format, size_t offset)
{
	if (type->kind < 0)
		return;
	for (int i = 0; i < FW_DATAFLASH_FIELDS; i++) {
		const char *wanted = kinds[type->kind].columns[i];

		if (wanted != NULL && strlen(wanted) == n && memcmp(wanted, label, n) == 0)
			type->field[i] = (fw_dataflash_field){format, (uint16_t)offset};
	}
}

/* A FMT's format and labels (NUL-terminated) to a type. Returns false: they are none. */
static bool define(const char *name, const char *format, const char *labels, fw_dataflash_type *type)
{
	size_t offset = 3;

	memset(type, 0, sizeof *type);
	memcpy(type->name, name, strlen(name));
	type->kind = (int8_t)kind_of(name, &type->instance);
	for (; *format != '\0'; format++) {
		const size_t width = width_of(*format), n = strcspn(labels, ",");

		if (width == 0)
			return false;
		note_column(type, labels, n, *format, offset);
		offset += width;
		labels += n + (labels[n] == ',');
	}
	type->length = (uint8_t)offset;
	return offset <= UINT8_MAX;
}

/* A FMT message of a binary log. */
static const char *take_format(fw_dataflash *r, const uint8_t *b)
{
	char name[5] = {0}, format[17] = {0}, labels[65] = {0};
	fw_dataflash_type type;

	memcpy(name, b + 5, 4);
	memcpy(format, b + 9, 16);
	memcpy(labels, b + 25, 64);
	if (!define(name, format, labels, &type) || type.length != b[4])
		return "a definition whose length is not that of its columns";
	r->types[b[3]] = type;
	return NULL;
}

/* ---- binary ---- */

/* IEEE 754 half precision. */
static double half(uint16_t bits)
{
	const int exponent = bits >> 10 & 31, fraction = bits & 1023;
	const double size = exponent == 31  ? (fraction != 0 ? UNKNOWN : (double)INFINITY)
	                    : exponent == 0 ? ldexp(fraction, -24)
	                                    : ldexp(fraction + 1024, exponent - 25);

	return bits >> 15 ? -size : size;
}

static double load(const uint8_t *b, char type)
{
	switch (type) {
	case 'b':
	case 'M': return (int8_t)b[0];
	case 'B': return b[0];
	case 'h': return (int16_t)fw_load_u16(b);
	case 'H': return fw_load_u16(b);
	case 'c': return (int16_t)fw_load_u16(b) / 100.0;
	case 'C': return fw_load_u16(b) / 100.0;
	case 'g': return half(fw_load_u16(b));
	case 'i': return (int32_t)fw_load_u32(b);
	case 'I': return fw_load_u32(b);
	case 'e': return (int32_t)fw_load_u32(b) / 100.0;
	case 'E': return fw_load_u32(b) / 100.0;
	case 'L': return (int32_t)fw_load_u32(b) / 1e7;
	case 'f': return (double)fw_load_f32(b);
	case 'd': return fw_load_f64(b);
	case 'q': return (double)(int64_t)fw_load_u64(b);
	case 'Q': return (double)fw_load_u64(b);
	default: return UNKNOWN;
	}
}

static void take_binary(fw_dataflash *r, const uint8_t *b, const fw_dataflash_type *type)
{
	message m = {0};

	for (int i = 0; i < FW_DATAFLASH_FIELDS; i++)
		m.v[i] =
		    type->field[i].type != 0 ? load(b + type->field[i].offset, type->field[i].type) : UNKNOWN;
	if (type->kind == PARM && type->field[PARM_NAME].type == 'N') {
		m.text = (const char *)b + type->field[PARM_NAME].offset;
		m.n_text = strnlen(m.text, 16);
	}
	if (complete(type, &m))
		take_message(r, &m);
}

static fw_status lose(fw_dataflash *r, uint64_t where, const char *reason)
{
	r->lost++;
	r->lost_offset = where;
	r->reason = reason;
	return FW_ESYNTAX;
}

/* The bytes ahead are no message. Goes on to where the next may be; the first time it is a loss. */
static fw_status search(fw_dataflash *r, const char *reason)
{
	static const uint8_t sync[] = {0xa3, 0x95};
	fw_window *w = &r->from.window;
	const uint64_t where = w->offset;
	const uint8_t *next = memmem(w->bytes + 1, w->n - 1, sync, sizeof sync);
	/* The last byte may be the first of a sync. */
	const size_t n = next != NULL ? (size_t)(next - w->bytes) : w->n > 1 ? w->n - 1 : 1;

	fw_window_skip(w, n);
	r->bytes_lost += n;
	if (r->searching)
		return FW_OK;
	r->searching = true;
	return lose(r, where, reason);
}

/* Zeros or 0xff: what is left of a flash memory's page. */
static fw_status skip_padding(fw_dataflash *r)
{
	fw_window *w = &r->from.window;
	const uint64_t where = w->offset;
	const uint8_t padding = w->bytes[0];

	while (fw_window_need(w, 1) && w->bytes[0] == padding) {
		size_t n = 1;

		while (n < w->n && w->bytes[n] == padding)
			n++;
		fw_window_skip(w, n);
	}
	if (w->n == 0)
		return FW_OK;
	r->bytes_lost += w->offset - where;
	return lose(r, where, "padding in the midst of the log");
}

/* Whether another message, padding or the end is n bytes ahead. */
static bool is_followed(fw_window *w, size_t n)
{
	const bool more = fw_window_need(w, n + PADDING);
	const uint8_t *b = w->bytes + n;
	const size_t left = w->n - n;

	if (left == 0 || (b[0] == 0xa3 && (left == 1 || b[1] == 0x95)))
		return true;
	for (size_t i = 0; i < (more ? PADDING : left); i++)
		if (b[i] != b[0])
			return false;
	return b[0] == 0 || b[0] == 0xff;
}

/* The end of the log, with less than a message ahead. */
static fw_status end_inside(fw_dataflash *r)
{
	fw_window *w = &r->from.window;
	const bool cut = w->n > 0 && !r->searching;

	r->bytes_lost += w->n;
	fw_window_skip(w, w->n);
	return w->status == FW_EOF && cut ? FW_ETRUNCATED : w->status;
}

static fw_status advance_binary(fw_dataflash *r)
{
	fw_window *w = &r->from.window;
	const fw_dataflash_type *type;
	const char *wrong = NULL;
	size_t length;

	if (!fw_window_need(w, 1))
		return w->status;
	if ((w->bytes[0] == 0 || w->bytes[0] == 0xff) && !r->searching)
		return skip_padding(r);
	if (!fw_window_need(w, 3))
		return end_inside(r);
	if (w->bytes[0] != 0xa3 || w->bytes[1] != 0x95)
		return search(r, "no message where one should begin");
	type = &r->types[w->bytes[2]];
	length = w->bytes[2] == FMT_ID ? FMT_LENGTH : type->length;
	if (length == 0)
		return search(r, "a message of a type that is not defined");
	if (!fw_window_need(w, length)) {
		if (memmem(w->bytes + 1, w->n - 1, "\xa3\x95", 2) != NULL)
			return search(r, "a message that reaches beyond the end");
		return end_inside(r);
	}
	if (!is_followed(w, length))
		return search(r, "a message that is not followed by one");
	r->searching = false;
	if (w->bytes[2] == FMT_ID)
		wrong = take_format(r, w->bytes);
	else
		take_binary(r, w->bytes, type);
	r->messages += wrong == NULL;
	r->bytes_lost += wrong != NULL ? length : 0;
	const uint64_t where = w->offset;
	fw_window_skip(w, length);
	return wrong != NULL ? lose(r, where, wrong) : FW_OK;
}

/* ---- text ---- */

typedef struct {
	const char *text;
	size_t n;
} field;

enum { TEXT_FIELDS = 64 };

/* "GPS, 1234, 3, ..." */
static int split(const fw_line *line, field *fields)
{
	const char *p = line->text, *const end = p + line->n;
	int n = 0;

	while (n < TEXT_FIELDS) {
		const char *stop = memchr(p, ',', (size_t)(end - p));
		const char *last = stop != NULL ? stop : end;

		while (p < last && *p == ' ')
			p++;
		while (last > p && (last[-1] == ' ' || last[-1] == '\t'))
			last--;
		fields[n++] = (field){p, (size_t)(last - p)};
		if (stop == NULL)
			break;
		p = stop + 1;
	}
	return n;
}

static fw_dataflash_type *find_type(fw_dataflash *r, field name)
{
	for (int i = 0; i < r->n_types; i++)
		if (strlen(r->types[i].name) == name.n && memcmp(r->types[i].name, name.text, name.n) == 0)
			return &r->types[i];
	return NULL;
}

/* "FMT, 129, 23, PARM, QNf, TimeUS,Name,Value": kept when furrow reads such messages. */
static const char *take_text_format(fw_dataflash *r, const field *fields, int n)
{
	fw_dataflash_type type = {0}, *place;

	if (n < TEXT_LABELS || fields[3].n == 0 || fields[3].n >= sizeof type.name)
		return "a definition cut short";
	memcpy(type.name, fields[3].text, fields[3].n);
	type.kind = (int8_t)kind_of(type.name, &type.instance);
	if (type.kind < 0)
		return NULL;
	for (int i = TEXT_LABELS; i < n; i++)
		note_column(&type, fields[i].text, fields[i].n, 'd', (size_t)(i - TEXT_LABELS + 1));
	place = find_type(r, fields[3]);
	if (place == NULL && r->n_types == FW_DATAFLASH_TYPES)
		return "too many definitions";
	*(place != NULL ? place : &r->types[r->n_types++]) = type;
	return NULL;
}

static const char *take_text_message(fw_dataflash *r, const fw_dataflash_type *type, const field *fields,
                                     int n)
{
	message m = {0};

	for (int i = 0; i < FW_DATAFLASH_FIELDS; i++) {
		const size_t at = type->field[i].offset;

		m.v[i] = UNKNOWN;
		if (at == 0)
			continue;
		if (at >= (size_t)n)
			return "a message cut short";
		if (type->kind == PARM && i == PARM_NAME) {
			m.text = fields[at].text;
			m.n_text = fields[at].n;
		} else if (fw_get_double(fields[at].text, fields[at].n, &m.v[i]) != FW_OK &&
		           memmem(fields[at].text, fields[at].n, "nan", 3) == NULL) {
			return "a column that is no number";
		}
	}
	if (complete(type, &m))
		take_message(r, &m);
	return NULL;
}

static bool is_name(field f)
{
	for (size_t i = 0; i < f.n; i++)
		if (!((f.text[i] >= 'A' && f.text[i] <= 'Z') || (f.text[i] >= '0' && f.text[i] <= '9') ||
		      (f.text[i] >= 'a' && f.text[i] <= 'z') || f.text[i] == '_'))
			return false;
	return f.n > 0 && f.n <= 4;
}

static fw_status advance_text(fw_dataflash *r)
{
	const fw_dataflash_type *type;
	field fields[TEXT_FIELDS];
	const char *wrong = NULL;
	const uint64_t overlong = r->from.lines.overlong;
	fw_line line;
	fw_status status = fw_lines_next(&r->from.lines, &line);
	int n;

	if (status != FW_OK)
		return status;
	if (line.n == 0 && r->from.lines.overlong == overlong)
		return FW_OK;
	n = split(&line, fields);
	type = find_type(r, fields[0]);
	if (n < 2 || !is_name(fields[0]))
		wrong = "no message";
	else if (fields[0].n == 3 && memcmp(fields[0].text, "FMT", 3) == 0)
		wrong = take_text_format(r, fields, n);
	else if (type != NULL)
		wrong = take_text_message(r, type, fields, n);
	r->messages += wrong == NULL;
	r->bytes_lost += wrong != NULL ? line.n : 0;
	return wrong != NULL ? lose(r, line.number, wrong) : FW_OK;
}

/* ---- reading ---- */

static fw_status advance(fw_dataflash *r)
{
	const fw_status status = r->text ? advance_text(r) : advance_binary(r);

	if (status == FW_OK || status == FW_ESYNTAX)
		return status;
	r->final = status;
	flush_fix(r);
	return FW_OK; /* what waited is still to be handed out */
}

fw_status fw_dataflash_read(fw_dataflash *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status = FW_OK;

	while (status == FW_OK) {
		if (fw_log_take(&r->queue, kind, record) == FW_OK)
			return FW_OK;
		status = r->final == FW_OK ? advance(r) : r->final;
	}
	return status;
}

fw_status fw_dataflash_survey(fw_dataflash *r)
{
	r->surveying = true;
	while (r->final == FW_OK)
		(void)!advance(r);
	fw_boot_clock_learn(&r->clock);
	return r->final;
}
