#include "formats/ulog.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/frame.h"
#include "formats/bytes.h"

#define UNKNOWN ((double)NAN)

/* PX4, module.yaml of ekf2: EKF2_GPS_DELAY [s] */
#define EKF2_GPS_DELAY_S 0.11

#define GAUSS_UT    100.0
#define UTC_LEAST   1e15 /* 2001 in microseconds: a receiver without time says 0 or 1970 */
#define WHOLE_SHARE 0.9  /* increments that cover so much of the time join on to each other */
#define DECISION_US 1e6  /* without a survey: vehicle_imu without sensor_combined for so long */
#define BOOT_MOST   0x1p48

enum {
	FILE_HEADER = 16,
	HEADER = 3,
	MOST_MESSAGE = HEADER + UINT16_MAX,
	FLAGS_LENGTH = 40,
	NO_ACCEL = INT32_MAX
};

static const uint8_t magic[] = {0x55, 0x4c, 0x6f, 0x67, 0x01, 0x12, 0x35};
static const uint8_t sync_magic[] = {0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12};

/* ---- topics ---- */

enum {
	VEHICLE_IMU,
	SENSOR_COMBINED,
	VEHICLE_MAG,
	SENSOR_MAG,
	VEHICLE_AIR,
	VEHICLE_GPS,
	SENSOR_GPS,
	ATTITUDE,
	CAPTURE,
	TRIGGER
};

/* All topics have the first, many the second. */
enum { TIME, SAMPLE_TIME, FIRST };

#define GPS_FIELDS                                                                                           \
	"timestamp", "timestamp_sample", "fix_type", "satellites_used", "lat", "lon", "alt",                 \
	    "alt_ellipsoid", "latitude_deg", "longitude_deg", "altitude_msl_m", "altitude_ellipsoid_m",      \
	    "eph", "epv", "s_variance_m_s", "vel_n_m_s", "vel_e_m_s", "vel_d_m_s", "vel_ned_valid",          \
	    "time_utc_usec", "timestamp_time_relative"

/* A name with a digit behind a star is an array of at least so many. */
static const struct {
	const char *name, *fields[FW_ULOG_FIELDS];
} topics[FW_ULOG_TOPICS] = {
    [VEHICLE_IMU] = {"vehicle_imu",
                     {"timestamp", "timestamp_sample", "delta_angle*3", "delta_velocity*3", "delta_angle_dt",
                      "delta_velocity_dt", "dt"}},
    [SENSOR_COMBINED] = {"sensor_combined",
                         {"timestamp", "timestamp_sample", "gyro_rad*3", "accelerometer_m_s2*3",
                          "accelerometer_timestamp_relative"}},
    [VEHICLE_MAG] = {"vehicle_magnetometer", {"timestamp", "timestamp_sample", "magnetometer_ga*3"}},
    [SENSOR_MAG] = {"sensor_mag", {"timestamp", "timestamp_sample", "x", "y", "z"}},
    [VEHICLE_AIR] = {"vehicle_air_data", {"timestamp", "timestamp_sample", "baro_alt_meter"}},
    [VEHICLE_GPS] = {"vehicle_gps_position", {GPS_FIELDS}},
    [SENSOR_GPS] = {"sensor_gps", {GPS_FIELDS}},
    [ATTITUDE] = {"vehicle_attitude", {"timestamp", "timestamp_sample", "q*4"}},
    [CAPTURE] = {"camera_capture", {"timestamp"}},
    [TRIGGER] = {"camera_trigger", {"timestamp"}},
};

enum { IMU_ANGLE = FIRST, IMU_VELOCITY, IMU_ANGLE_DT, IMU_VELOCITY_DT, IMU_DT };
enum { COMBINED_GYRO = FIRST, COMBINED_ACCEL, COMBINED_RELATIVE };
enum { MAG_FIELD = FIRST };
enum { AIR_HEIGHT = FIRST };
enum { ATTITUDE_Q = FIRST };
enum {
	GPS_FIX = FIRST,
	GPS_NSATS,
	GPS_LAT_E7,
	GPS_LON_E7,
	GPS_MSL_MM,
	GPS_ELLIPSOID_MM,
	GPS_LAT,
	GPS_LON,
	GPS_MSL,
	GPS_ELLIPSOID,
	GPS_EPH,
	GPS_EPV,
	GPS_SPEED_SD,
	GPS_VN,
	GPS_VE,
	GPS_VD,
	GPS_VELOCITY_VALID,
	GPS_UTC,
	GPS_UTC_RELATIVE
};

/* A data message of a topic that furrow reads. */
typedef struct {
	int topic;
	const fw_ulog_field *field;
	const uint8_t *payload; /* from the timestamp on */
	size_t n;
	int64_t us, sample_us;
} message;

bool fw_ulog_detect(const uint8_t *bytes, size_t n)
{
	return n >= sizeof magic && memcmp(bytes, magic, sizeof magic) == 0;
}

fw_ulog_plan fw_ulog_default_plan(void)
{
	return (fw_ulog_plan){-1, -1, -1, -1, UNKNOWN};
}

static void restart(fw_ulog *r, fw_input *input)
{
	r->messages = r->lost = r->bytes_lost = r->lost_offset = r->untimed = r->unhealthy = 0;
	r->dropouts = r->dropout_ms = 0;
	r->reason = "";
	r->msl = r->surveying = r->searching = r->begun = false;
	r->final = FW_OK;
	r->queue.first = r->queue.n = 0;
	memset(r->appended, 0, sizeof r->appended);
	memset(r->stream, 0, sizeof r->stream);
	memset(r->field, 0, sizeof r->field);
	fw_window_begin(&r->window, input);
}

void fw_ulog_begin(fw_ulog *r, fw_input *input, const fw_ulog_plan *plan)
{
	memset(r, 0, offsetof(fw_ulog, window));
	r->plan = plan != NULL ? *plan : fw_ulog_default_plan();
	r->log_lag_s = UNKNOWN;
	r->first_imu_us = -1;
	for (int i = 0; i < FW_ULOG_TOPICS; i++)
		r->instance[i] = -1;
	r->instance[VEHICLE_IMU] = r->plan.imu;
	r->instance[VEHICLE_MAG] = r->instance[SENSOR_MAG] = r->plan.mag;
	r->instance[VEHICLE_AIR] = r->plan.baro;
	r->instance[SENSOR_GPS] = r->plan.gps;
	fw_boot_clock_begin(&r->clock);
	restart(r, input);
}

/* The whole log was there: where do IMU samples and positions come from? */
static void decide(fw_ulog *r)
{
	const double span_us = (double)(r->last_us[VEHICLE_IMU] - r->first_imu_us);
	const bool whole = r->count[VEHICLE_IMU] > 1 && r->covered_us >= WHOLE_SHARE * span_us;

	r->surveyed = r->decided_imu = true;
	r->imu_of_increments = r->count[VEHICLE_IMU] > 0 && (whole || r->count[SENSOR_COMBINED] == 0);
	r->use_sensor_gps = r->count[SENSOR_GPS] > r->count[VEHICLE_GPS];
}

void fw_ulog_again(fw_ulog *r, fw_input *input)
{
	restart(r, input);
}

/* ---- fields ---- */

/* Letters for the types of fields, and how long they are; 0: a type of its own. */
static size_t width_of(const char *type, size_t n, char *letter)
{
	static const struct {
		const char *name;
		char letter;
		size_t width;
	} types[] = {{"int8_t", 'b', 1},  {"uint8_t", 'B', 1},  {"int16_t", 'h', 2}, {"uint16_t", 'H', 2},
	             {"int32_t", 'i', 4}, {"uint32_t", 'I', 4}, {"int64_t", 'q', 8}, {"uint64_t", 'Q', 8},
	             {"float", 'f', 4},   {"double", 'd', 8},   {"bool", 'B', 1},    {"char", 'b', 1}};

	for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
		if (strlen(types[i].name) == n && memcmp(types[i].name, type, n) == 0) {
			*letter = types[i].letter;
			return types[i].width;
		}
	}
	return 0;
}

static double load(const uint8_t *b, char type)
{
	switch (type) {
	case 'b': return (int8_t)b[0];
	case 'B': return b[0];
	case 'h': return (int16_t)fw_load_u16(b);
	case 'H': return fw_load_u16(b);
	case 'i': return (int32_t)fw_load_u32(b);
	case 'I': return fw_load_u32(b);
	case 'q': return (double)(int64_t)fw_load_u64(b);
	case 'Q': return (double)fw_load_u64(b);
	case 'f': return (double)fw_load_f32(b);
	case 'd': return fw_load_f64(b);
	default: return UNKNOWN;
	}
}

static size_t letter_width(char type)
{
	return strchr("qQd", type) != NULL   ? 8
	       : strchr("iIf", type) != NULL ? 4
	       : strchr("hH", type) != NULL  ? 2
	                                     : 1;
}

/* An element of a field; NaN: the topic does not have it, or the message ends before it. */
static double value(const message *m, int field, size_t element)
{
	const fw_ulog_field *f = &m->field[field];
	const size_t width = letter_width(f->type), offset = f->offset + element * width;

	if (f->type == 0 || offset + width > m->n)
		return UNKNOWN;
	return load(m->payload + offset, f->type);
}

static void vector(const message *m, int field, double v[static 3])
{
	for (size_t i = 0; i < 3; i++)
		v[i] = value(m, field, i);
}

/* ---- definitions ---- */

/* "*3" of a name that is wanted: elements that there have to be. */
static int wanted_field(int topic, const char *name, size_t n, size_t elements)
{
	for (int i = 0; i < FW_ULOG_FIELDS && topics[topic].fields[i] != NULL; i++) {
		const char *wanted = topics[topic].fields[i];
		const size_t length = strcspn(wanted, "*");
		const size_t least = wanted[length] == '*' ? (size_t)(wanted[length + 1] - '0') : 1;

		if (length == n && memcmp(wanted, name, n) == 0 && elements >= least)
			return i;
	}
	return -1;
}

/* "float[3] gyro_rad", n bytes. Returns false behind a field whose length is not known. */
static bool note_field(fw_ulog *r, int topic, const char *text, size_t n, size_t *offset)
{
	const char *blank = memchr(text, ' ', n);
	const size_t n_type = blank != NULL ? (size_t)(blank - text) : 0;
	const char *bracket = memchr(text, '[', n_type);
	size_t elements = 1;
	char letter = 0;

	if (bracket != NULL) {
		elements = 0;
		for (const char *p = bracket + 1;
		     p < blank && *p >= '0' && *p <= '9' && elements < UINT16_MAX; p++)
			elements = 10 * elements + (size_t)(*p - '0');
	}
	const size_t width = width_of(text, bracket != NULL ? (size_t)(bracket - text) : n_type, &letter);
	if (n_type == 0 || width == 0 || elements == 0 || *offset + elements * width > UINT16_MAX)
		return false;
	const int field = wanted_field(topic, blank + 1, n - n_type - 1, elements);
	if (field >= 0)
		r->field[topic][field] = (fw_ulog_field){letter, (uint16_t)*offset};
	*offset += elements * width;
	return true;
}

static int find_topic(const char *name, size_t n)
{
	for (int i = 0; i < FW_ULOG_TOPICS; i++)
		if (strlen(topics[i].name) == n && memcmp(topics[i].name, name, n) == 0)
			return i;
	return -1;
}

/* "sensor_combined:uint64_t timestamp;float[3] gyro_rad;..." */
static void take_definition(fw_ulog *r, const char *text, size_t n)
{
	const char *colon = memchr(text, ':', n), *const end = text + n;
	const int topic = colon != NULL ? find_topic(text, (size_t)(colon - text)) : -1;
	size_t offset = 0;

	if (topic < 0)
		return;
	memset(r->field[topic], 0, sizeof r->field[topic]);
	for (const char *p = colon + 1; p < end;) {
		const char *stop = memchr(p, ';', (size_t)(end - p));
		const size_t length = (size_t)((stop != NULL ? stop : end) - p);

		if (!note_field(r, topic, p, length, &offset))
			break;
		p += length + 1;
	}
}

/* multi_id u1, msg_id u2, name */
static void take_subscription(fw_ulog *r, const uint8_t *b, size_t n)
{
	const unsigned id = fw_load_u16(b + 1);

	if (id < FW_ULOG_IDS)
		r->stream[id] =
		    (fw_ulog_stream){true, (int8_t)find_topic((const char *)b + 3, n - 3), b[0], 0};
}

/* key length u1, "type name", value */
static void take_parameter(fw_ulog *r, const uint8_t *b, size_t n)
{
	static const char key[] = "float EKF2_GPS_DELAY";
	const size_t n_key = sizeof key - 1;

	if (n != 1 + n_key + 4 || b[0] != n_key || memcmp(b + 1, key, n_key) != 0)
		return;
	const double ms = (double)fw_load_f32(b + 1 + n_key);
	if (ms >= 0 && ms <= 10000)
		r->log_lag_s = ms / 1000;
}

/* ---- what a message becomes ---- */

static double lag(const fw_ulog *r)
{
	return isfinite(r->plan.lag_s)  ? r->plan.lag_s
	       : isfinite(r->log_lag_s) ? r->log_lag_s
	                                : EKF2_GPS_DELAY_S;
}

static bool boot_time(fw_ulog *r, int64_t us, double lag_s, fw_time *t)
{
	if (r->surveying)
		return false;
	if (fw_boot_clock_time(&r->clock, us, lag_s, t) == FW_OK)
		return true;
	r->untimed++;
	return false;
}

static void count_unhealthy(fw_ulog *r, fw_status status)
{
	r->unhealthy += status != FW_OK;
}

static void put_rates(fw_ulog *r, const message *m, const double gyro[static 3], const double accel[static 3])
{
	fw_time t;

	if (boot_time(r, m->sample_us, lag(r), &t))
		count_unhealthy(r, fw_log_put_imu(&r->queue, t, gyro, accel));
}

/* Without a survey: vehicle_imu it is when sensor_combined does not come. */
static void decide_as_it_comes(fw_ulog *r, const message *m)
{
	if (m->topic == SENSOR_COMBINED) {
		r->decided_imu = true;
	} else if ((double)(m->us - r->first_imu_us) > DECISION_US) {
		r->decided_imu = true;
		r->imu_of_increments = true;
	}
}

static void take_increments(fw_ulog *r, const message *m)
{
	double gyro[3], accel[3], dt = value(m, IMU_ANGLE_DT, 0), dv = value(m, IMU_VELOCITY_DT, 0);

	dt = isfinite(dt) ? dt : value(m, IMU_DT, 0);
	dv = isfinite(dv) ? dv : dt;
	if (r->first_imu_us < 0)
		r->first_imu_us = m->us;
	if (r->surveying && dt > 0 && r->count[VEHICLE_IMU] > 1)
		r->covered_us += dt;
	if (!r->decided_imu && !r->surveying)
		decide_as_it_comes(r, m);
	if (!r->decided_imu || !r->imu_of_increments)
		return;
	vector(m, IMU_ANGLE, gyro);
	vector(m, IMU_VELOCITY, accel);
	for (int i = 0; i < 3; i++) {
		gyro[i] /= dt * 1e-6;
		accel[i] /= dv * 1e-6;
	}
	put_rates(r, m, gyro, accel);
}

static void take_combined(fw_ulog *r, const message *m)
{
	double gyro[3], accel[3];

	if (!r->decided_imu && !r->surveying)
		decide_as_it_comes(r, m);
	if (!r->decided_imu || r->imu_of_increments)
		return;
	vector(m, COMBINED_GYRO, gyro);
	vector(m, COMBINED_ACCEL, accel);
	if (value(m, COMBINED_RELATIVE, 0) == NO_ACCEL)
		accel[0] = UNKNOWN; /* there is none in it */
	put_rates(r, m, gyro, accel);
}

static void take_mag(fw_ulog *r, const message *m)
{
	double field_ut[3];
	fw_time t;

	if ((m->topic == SENSOR_MAG && r->count[VEHICLE_MAG] > 0) || !boot_time(r, m->sample_us, lag(r), &t))
		return;
	for (int i = 0; i < 3; i++)
		field_ut[i] = GAUSS_UT * (m->topic == VEHICLE_MAG ? value(m, MAG_FIELD, (size_t)i)
		                                                  : value(m, MAG_FIELD + i, 0));
	count_unhealthy(r, fw_log_put_mag(&r->queue, t, field_ut));
}

static void take_air(fw_ulog *r, const message *m)
{
	fw_time t;

	if (boot_time(r, m->sample_us, lag(r), &t))
		count_unhealthy(r, fw_log_put_baro(&r->queue, t, value(m, AIR_HEIGHT, 0)));
}

static void take_attitude(fw_ulog *r, const message *m)
{
	fw_log_nav nav = fw_log_no_nav();
	double q[4], rpy[3];
	fw_time t;

	if (!boot_time(r, m->sample_us, lag(r), &t))
		return;
	for (size_t i = 0; i < 4; i++)
		q[i] = value(m, ATTITUDE_Q, i);
	if (fw_quat_normalise(q) == FW_OK) {
		fw_quat_to_euler(q, rpy);
		for (int i = 0; i < 3; i++)
			nav.angle_deg[i] = fw_deg_from_rad(rpy[i]);
	}
	count_unhealthy(r, fw_log_put_nav(&r->queue, t, &nav, "autopilot"));
}

static void take_event(fw_ulog *r, const message *m)
{
	fw_time t;

	if (boot_time(r, m->us, lag(r), &t))
		count_unhealthy(r, fw_log_put_event(&r->queue, t, m->topic == CAPTURE ? 1 : 2));
}

/* ---- positions ---- */

/* The one of two fields that a log has: an old one times `scale`, or a new one. */
static double either(const message *m, int old, double scale, int new)
{
	const double x = value(m, new, 0);

	return isfinite(x) ? x : value(m, old, 0) * scale;
}

static double deviation(double x)
{
	return x > 0 ? x : UNKNOWN;
}

/* Drivers without an ellipsoidal height leave it at 0. */
static void take_heights(fw_ulog *r, const message *m, fw_log_fix *fix)
{
	const double msl = either(m, GPS_MSL_MM, 1e-3, GPS_MSL),
	             ellipsoid = either(m, GPS_ELLIPSOID_MM, 1e-3, GPS_ELLIPSOID);

	if (isfinite(ellipsoid) && ellipsoid != 0) {
		fix->height_m = ellipsoid;
		fix->undulation_m = ellipsoid - msl;
	} else {
		fix->height_m = msl;
		r->msl |= fix->mode != 0;
	}
}

static void take_position(fw_ulog *r, const message *m, fw_log_fix *fix)
{
	static const int modes[] = {0, 0, 1, 1, 2, 5, 4};
	const double type = value(m, GPS_FIX, 0), n_sats = value(m, GPS_NSATS, 0),
	             speed = value(m, GPS_SPEED_SD, 0);

	*fix = fw_log_no_fix();
	fix->mode = type >= 0 && type <= 6 ? modes[(int)type] : 0;
	fix->two_d = type == 2;
	fix->n_sats = n_sats >= 0 && n_sats < 255 ? (int)n_sats : -1;
	fix->lat_deg = either(m, GPS_LAT_E7, 1e-7, GPS_LAT);
	fix->lon_deg = either(m, GPS_LON_E7, 1e-7, GPS_LON);
	take_heights(r, m, fix);
	fix->sd_m[0] = fix->sd_m[1] = fw_log_each_of_two(deviation(value(m, GPS_EPH, 0)));
	fix->sd_m[2] = deviation(value(m, GPS_EPV, 0));
	if (value(m, GPS_VELOCITY_VALID, 0) == 0)
		return;
	for (int i = 0; i < 3; i++)
		fix->velocity_mps[i] = value(m, GPS_VN + i, 0);
	fix->sd_velocity_mps[0] = fix->sd_velocity_mps[1] = fw_log_each_of_two(deviation(speed));
	fix->sd_velocity_mps[2] = deviation(speed);
}

/* The GPS time that the receiver says, and the pair for the clock. */
static bool utc_of(fw_ulog *r, const message *m, fw_time *t)
{
	const double utc = value(m, GPS_UTC, 0), relative = value(m, GPS_UTC_RELATIVE, 0);

	if (!(utc >= UTC_LEAST && utc < 1e16) || fw_time_from_unix_us((int64_t)utc, t) < 0)
		return false;
	if (value(m, GPS_FIX, 0) >= 3)
		fw_boot_clock_add(&r->clock, m->us + (isfinite(relative) ? (int64_t)relative : 0), *t);
	return true;
}

/* Without a survey: as long as there is no other. */
static bool uses_sensor_gps(const fw_ulog *r)
{
	return r->surveyed ? r->use_sensor_gps : r->count[VEHICLE_GPS] == 0;
}

static void take_gps(fw_ulog *r, const message *m)
{
	fw_log_fix fix;
	fw_time t;
	const bool timed = utc_of(r, m, &t);

	if (r->surveying || (m->topic == SENSOR_GPS) != uses_sensor_gps(r))
		return;
	/* A position that does not say when it was: it was as late as the others. */
	if (!timed && !boot_time(r, m->sample_us, 0, &t))
		return;
	take_position(r, m, &fix);
	count_unhealthy(r, fw_log_put_pvt(&r->queue, t, &fix));
}

/* ---- messages ---- */

static bool take_times(message *m)
{
	const double time = value(m, TIME, 0), sample = value(m, SAMPLE_TIME, 0);

	if (!(time >= 0 && time < BOOT_MOST))
		return false;
	m->us = (int64_t)time;
	m->sample_us = sample > 0 && sample < BOOT_MOST ? (int64_t)sample : m->us;
	return true;
}

static void take_data(fw_ulog *r, const uint8_t *b, size_t n)
{
	const unsigned id = fw_load_u16(b);
	fw_ulog_stream *s = &r->stream[id];
	message m;

	s->length = (uint16_t)n;
	if (s->topic < 0)
		return;
	m = (message){.topic = s->topic, .field = r->field[s->topic], .payload = b + 2, .n = n - 2};
	if (r->instance[m.topic] < 0)
		r->instance[m.topic] = s->instance;
	if (r->instance[m.topic] != s->instance || !take_times(&m))
		return;
	r->count[m.topic]++;
	r->last_us[m.topic] = m.us;
	switch (m.topic) {
	case VEHICLE_IMU: take_increments(r, &m); break;
	case SENSOR_COMBINED: take_combined(r, &m); break;
	case VEHICLE_MAG:
	case SENSOR_MAG: take_mag(r, &m); break;
	case VEHICLE_AIR: take_air(r, &m); break;
	case VEHICLE_GPS:
	case SENSOR_GPS: take_gps(r, &m); break;
	case ATTITUDE: take_attitude(r, &m); break;
	case CAPTURE:
	case TRIGGER: take_event(r, &m); break;
	default: break;
	}
}

static fw_status lose(fw_ulog *r, uint64_t where, const char *reason)
{
	r->lost++;
	r->lost_offset = where;
	r->reason = reason;
	return FW_ESYNTAX;
}

/* compatible flags, incompatible flags, where data were appended */
static fw_status take_flags(fw_ulog *r, const uint8_t *b)
{
	uint8_t unknown = b[8] & 0xfe;

	for (int i = 9; i < 16; i++)
		unknown |= b[i];
	if (unknown != 0) {
		r->final = FW_EUNKNOWN;
		(void)lose(r, r->window.offset, "a log with features that are not known");
		return FW_EUNKNOWN;
	}
	for (int i = 0; i < 3; i++)
		r->appended[i] = b[8] & 1 ? fw_load_u64(b + 16 + 8 * i) : 0;
	return FW_OK;
}

static fw_status take_message(fw_ulog *r, char type, const uint8_t *b, size_t n)
{
	switch (type) {
	case 'B': return take_flags(r, b);
	case 'F': take_definition(r, (const char *)b, n); break;
	case 'A': take_subscription(r, b, n); break;
	case 'P': take_parameter(r, b, n); break;
	case 'D': take_data(r, b, n); break;
	case 'O':
		r->dropouts++;
		r->dropout_ms += fw_load_u16(b);
		break;
	default: break; /* texts, information, marks */
	}
	return FW_OK;
}

/* ---- framing ---- */

/* Whether a message may begin at b, as far as the n bytes there tell. */
static bool may_begin(const fw_ulog *r, const uint8_t *b, size_t n)
{
	const size_t size = n >= 2 ? fw_load_u16(b) : 0;

	if (n < HEADER)
		return true;
	switch (b[2]) {
	case 'B': return size >= FLAGS_LENGTH && size < 256;
	case 'F':
	case 'I':
	case 'M':
	case 'P':
	case 'Q': return size > 0;
	case 'A': return size > 3 && size < 256;
	case 'R':
	case 'O': return size == 2;
	case 'L': return size >= 9;
	case 'C': return size >= 11;
	case 'S': return size == 8 && memcmp(b + HEADER, sync_magic, n - HEADER < 8 ? n - HEADER : 8) == 0;
	case 'D': break;
	default: return false;
	}
	if (size < 10 || n < HEADER + 2)
		return size >= 10;
	const unsigned id = fw_load_u16(b + HEADER);
	return id < FW_ULOG_IDS && r->stream[id].known &&
	       (r->stream[id].length == 0 || r->stream[id].length == size);
}

static fw_status search(fw_ulog *r, const char *reason)
{
	const uint64_t where = r->window.offset;

	fw_window_skip(&r->window, 1);
	r->bytes_lost++;
	if (r->searching)
		return FW_OK;
	r->searching = true;
	return lose(r, where, reason);
}

/* Bytes up to the next place where data were appended; UINT64_MAX: none. */
static uint64_t until_appended(const fw_ulog *r)
{
	uint64_t left = UINT64_MAX;

	for (int i = 0; i < 3; i++)
		if (r->appended[i] > r->window.offset && r->appended[i] - r->window.offset < left)
			left = r->appended[i] - r->window.offset;
	return left;
}

/* The end of the log, or of its part before appended data, comes before the message does. */
static fw_status end_inside(fw_ulog *r, uint64_t left)
{
	fw_window *w = &r->window;

	if (left < w->n) {
		fw_window_skip(w, (size_t)left); /* the autopilot crashed; what it appended goes on here */
		return FW_OK;
	}
	const bool cut = w->n > 0 && !r->searching;
	fw_window_skip(w, w->n);
	return w->status == FW_EOF && cut ? FW_ETRUNCATED : w->status;
}

/* The message ahead reaches beyond the end. Is its length wrong, because one byte or more on there are
 * others? */
static bool more_follows(const fw_ulog *r)
{
	const fw_window *w = &r->window;

	for (size_t i = 1; i + HEADER < w->n; i++) {
		const size_t end = i + HEADER + fw_load_u16(w->bytes + i);

		if (end <= w->n && may_begin(r, w->bytes + i, w->n - i) && w->n - end >= HEADER &&
		    may_begin(r, w->bytes + end, w->n - end))
			return true;
	}
	return false;
}

static fw_status read_header(fw_ulog *r)
{
	if (!fw_window_need(&r->window, FILE_HEADER))
		return r->window.status == FW_EOF ? FW_ETRUNCATED : r->window.status;
	if (!fw_ulog_detect(r->window.bytes, FILE_HEADER)) {
		(void)lose(r, 0, "no ULog");
		return FW_EUNKNOWN;
	}
	fw_window_skip(&r->window, FILE_HEADER);
	r->begun = true;
	return FW_OK;
}

static fw_status next_message(fw_ulog *r)
{
	fw_window *w = &r->window;
	const uint64_t left = until_appended(r);
	size_t n;

	if (!r->begun)
		return read_header(r);
	if (!fw_window_need(w, HEADER) || left < HEADER)
		return end_inside(r, left);
	if (!may_begin(r, w->bytes, w->n))
		return search(r, "no message where one should begin");
	n = HEADER + (size_t)fw_load_u16(w->bytes);
	if (left < n)
		return fw_window_need(w, (size_t)left + 1) ? end_inside(r, left) : end_inside(r, UINT64_MAX);
	if (!fw_window_need(w, n)) {
		if (w->status == FW_EOF && (r->searching || more_follows(r)))
			return search(r, "a message of impossible length");
		return end_inside(r, UINT64_MAX);
	}
	if (!may_begin(r, w->bytes, n))
		return search(r, "a message of impossible length");
	(void)fw_window_need(w, n + HEADER + 2);
	if (left > n && w->n > n &&
	    !may_begin(r, w->bytes + n, w->n - n < left - n ? w->n - n : (size_t)(left - n)))
		return search(r, "a message that is not followed by one");
	r->searching = false;
	const fw_status status = take_message(r, (char)w->bytes[2], w->bytes + HEADER, n - HEADER);
	r->messages += status == FW_OK;
	fw_window_skip(w, n);
	return status;
}

static fw_status advance(fw_ulog *r)
{
	const fw_status status = next_message(r);

	if (status != FW_OK && status != FW_ESYNTAX)
		r->final = status;
	return status;
}

fw_status fw_ulog_read(fw_ulog *r, fw_kind *kind, fw_any_record *record)
{
	fw_status status;

	do {
		if (fw_log_take(&r->queue, kind, record) == FW_OK)
			return FW_OK;
		status = r->final == FW_OK ? advance(r) : r->final;
	} while (status == FW_OK);
	return status;
}

fw_status fw_ulog_survey(fw_ulog *r)
{
	r->surveying = true;
	while (r->final == FW_OK)
		(void)!advance(r);
	fw_boot_clock_learn(&r->clock);
	decide(r);
	return r->final;
}
