/* PX4's ULog files in the making, after the format's documentation. */
#ifndef FURROW_TESTS_ULOG_MAKE_H
#define FURROW_TESTS_ULOG_MAKE_H

#include "log_bytes.h"

enum {
	UL_COMBINED,
	UL_IMU,
	UL_MAG,
	UL_AIR,
	UL_GPS,
	UL_SENSOR_GPS,
	UL_ATTITUDE,
	UL_CAPTURE,
	UL_OTHER,
	UL_IMU_1,
	UL_IDS
};

static inline void ul_message(log_bytes *b, char type, size_t size)
{
	put_le(b, size, 2);
	put_bytes(b, &type, 1);
}

static inline void ul_string(log_bytes *b, char type, const char *text)
{
	ul_message(b, type, strlen(text));
	put_bytes(b, text, strlen(text));
}

static inline void ul_file(log_bytes *b)
{
	b->n = 0;
	put_bytes(b, "ULog\x01\x12\x35\x01", 8);
	put_le(b, 1000, 8);
}

/* Incompatible flags and the place of appended data. */
static inline void ul_flags(log_bytes *b, int incompatible, uint64_t appended)
{
	ul_message(b, 'B', 40);
	put_le(b, 0, 8);
	put_le(b, (uint64_t)incompatible, 8);
	put_le(b, appended, 8);
	put_le(b, 0, 8);
	put_le(b, 0, 8);
}

static inline void ul_parameter(log_bytes *b, const char *key, float value)
{
	ul_message(b, 'P', 1 + strlen(key) + 4);
	put_le(b, strlen(key), 1);
	put_bytes(b, key, strlen(key));
	put_f32(b, value);
}

static inline void ul_subscribe(log_bytes *b, int id, int instance, const char *topic)
{
	ul_message(b, 'A', 3 + strlen(topic));
	put_le(b, (uint64_t)instance, 1);
	put_le(b, (uint64_t)id, 2);
	put_bytes(b, topic, strlen(topic));
}

/* Definitions of today's PX4; of positions both the new form (sensor_gps) and the old (vehicle_gps_position).
 * */
static inline void ul_definitions(log_bytes *b)
{
	ul_string(b, 'F',
	          "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
	          "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;"
	          "uint32_t accelerometer_integral_dt;uint8_t accelerometer_clipping;uint8_t[3] _padding0;");
	ul_string(
	    b, 'F',
	    "vehicle_imu:uint64_t timestamp;uint64_t timestamp_sample;uint32_t accel_device_id;"
	    "uint32_t gyro_device_id;float[3] delta_angle;float[3] delta_velocity;uint32_t delta_angle_dt;"
	    "uint32_t delta_velocity_dt;uint8_t delta_angle_clipping;uint8_t[7] _padding0;");
	ul_string(b, 'F',
	          "vehicle_magnetometer:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;"
	          "float[3] magnetometer_ga;uint8_t calibration_count;uint8_t[7] _padding0;");
	ul_string(b, 'F',
	          "vehicle_air_data:uint64_t timestamp;uint64_t timestamp_sample;float baro_alt_meter;");
	ul_string(
	    b, 'F',
	    "vehicle_gps_position:uint64_t timestamp;uint64_t time_utc_usec;int32_t lat;int32_t lon;int32_t "
	    "alt;"
	    "int32_t alt_ellipsoid;float s_variance_m_s;float eph;float epv;float vel_n_m_s;float vel_e_m_s;"
	    "float vel_d_m_s;int32_t timestamp_time_relative;uint8_t fix_type;bool vel_ned_valid;"
	    "uint8_t satellites_used;uint8_t[5] _padding0;");
	ul_string(
	    b, 'F',
	    "sensor_gps:uint64_t timestamp;uint64_t timestamp_sample;double latitude_deg;double "
	    "longitude_deg;"
	    "double altitude_msl_m;double altitude_ellipsoid_m;uint64_t time_utc_usec;uint32_t device_id;"
	    "float s_variance_m_s;float eph;float epv;float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;"
	    "int32_t timestamp_time_relative;uint8_t fix_type;bool vel_ned_valid;uint8_t satellites_used;"
	    "uint8_t[5] _padding0;");
	ul_string(
	    b, 'F',
	    "vehicle_attitude:uint64_t timestamp;uint64_t timestamp_sample;float[4] q;float[4] delta_q_reset;"
	    "uint8_t quat_reset_counter;uint8_t[7] _padding0;");
	ul_string(b, 'F',
	          "camera_capture:uint64_t timestamp;uint64_t timestamp_utc;double lat;uint32_t seq;");
	ul_string(b, 'F', "esc_status:uint64_t timestamp;esc_report[8] esc;uint16_t counter;");
}

static inline void ul_subscriptions(log_bytes *b)
{
	static const char *const topics[] = {
	    "sensor_combined",  "vehicle_imu",          "vehicle_magnetometer",
	    "vehicle_air_data", "vehicle_gps_position", "sensor_gps",
	    "vehicle_attitude", "camera_capture",       "esc_status"};

	for (int i = 0; i <= UL_OTHER; i++)
		ul_subscribe(b, i, 0, topics[i]);
	ul_subscribe(b, UL_IMU_1, 1, "vehicle_imu");
}

static inline void ul_data(log_bytes *b, int id, size_t size, uint64_t us)
{
	ul_message(b, 'D', 2 + size);
	put_le(b, (uint64_t)id, 2);
	put_le(b, us, 8);
}

/* The trailing padding is not stored. */
static inline void ul_combined(log_bytes *b, uint64_t us, float gx)
{
	ul_data(b, UL_COMBINED, 45, us);
	put_f32(b, gx);
	put_f32(b, 0.25F);
	put_f32(b, -0.5F);
	put_le(b, 4000, 4);
	put_le(b, 0, 4);
	put_f32(b, 1);
	put_f32(b, 2);
	put_f32(b, -9.75F);
	put_le(b, 4000, 4);
	put_le(b, 0, 1);
}

/* Increments over dt, its sample taken 200 us before it was published. */
static inline void ul_imu(log_bytes *b, int id, uint64_t us, float angle, uint32_t dt)
{
	ul_data(b, id, 57, us);
	put_le(b, us - 200, 8);
	put_le(b, 0x12345678, 8);
	put_f32(b, angle);
	put_f32(b, 0);
	put_f32(b, 0);
	put_f32(b, 0);
	put_f32(b, 0);
	put_f32(b, -0.0625F);
	put_le(b, dt, 4);
	put_le(b, dt, 4);
	put_le(b, 0, 1);
}

static inline void ul_mag(log_bytes *b, uint64_t us)
{
	ul_data(b, UL_MAG, 33, us);
	put_le(b, us - 1000, 8);
	put_le(b, 1, 4);
	put_f32(b, 0.25F);
	put_f32(b, -0.125F);
	put_f32(b, 0.5F);
	put_le(b, 0, 1);
}

static inline void ul_air(log_bytes *b, uint64_t us)
{
	ul_data(b, UL_AIR, 20, us);
	put_le(b, us - 1000, 8);
	put_f32(b, 488.5F);
}

typedef struct {
	uint64_t us, utc_us;
	int fix;
	double ellipsoid_m;
} ul_fix;

static inline void ul_fix_tail(log_bytes *b, const ul_fix *f)
{
	static const float v[6] = {0.5F, 2, 3, 1, -2, 0.25F}; /* speed, eph, epv, velocity */

	for (int i = 0; i < 6; i++)
		put_f32(b, v[i]);
	put_le(b, 0, 4);
	put_le(b, (uint64_t)f->fix, 1);
	put_le(b, 1, 1);
	put_le(b, 12, 1);
}

/* 47.5 N, 8.5 W, 500 m above the sea; the old form. */
static inline void ul_gps(log_bytes *b, const ul_fix *f)
{
	ul_data(b, UL_GPS, 63, f->us);
	put_le(b, f->utc_us, 8);
	put_le(b, 475000000, 4);
	put_le(b, (uint32_t)-85000000, 4);
	put_le(b, 500000, 4);
	put_le(b, (uint32_t)(int32_t)(f->ellipsoid_m * 1000), 4);
	ul_fix_tail(b, f);
}

/* The same, in the new form. */
static inline void ul_sensor_gps(log_bytes *b, const ul_fix *f)
{
	ul_data(b, UL_SENSOR_GPS, 91, f->us);
	put_le(b, 0, 8);
	put_f64(b, 47.5);
	put_f64(b, -8.5);
	put_f64(b, 500);
	put_f64(b, f->ellipsoid_m);
	put_le(b, f->utc_us, 8);
	put_le(b, 0, 4);
	ul_fix_tail(b, f);
}

/* Roll 90 degrees. */
static inline void ul_attitude(log_bytes *b, uint64_t us)
{
	ul_data(b, UL_ATTITUDE, 49, us);
	put_le(b, us - 100, 8);
	put_f32(b, 0.70710678F);
	put_f32(b, 0.70710678F);
	for (int i = 0; i < 6; i++)
		put_f32(b, 0);
	put_le(b, 0, 1);
}

static inline void ul_capture(log_bytes *b, uint64_t us)
{
	ul_data(b, UL_CAPTURE, 28, us);
	put_le(b, 0, 8);
	put_f64(b, 0);
	put_le(b, 1, 4);
}

static inline void ul_dropout(log_bytes *b, int ms)
{
	ul_message(b, 'O', 2);
	put_le(b, (uint64_t)ms, 2);
}

static inline void ul_sync(log_bytes *b)
{
	ul_message(b, 'S', 8);
	put_bytes(b, "\x2f\x73\x13\x20\x25\x0c\xbb\x12", 8);
}

#endif
