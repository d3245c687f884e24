/* PX4's ULog as records.
 *
 *     vehicle_imu or sensor_combined           imu    FRD, averaged
 *     vehicle_magnetometer, else sensor_mag    mag
 *     vehicle_air_data                         baro
 *     vehicle_gps_position or sensor_gps       pvt    of the one that comes more often
 *     vehicle_attitude                         nav    attitude only, status "autopilot"
 *     camera_capture, camera_trigger           event  source 1, 2
 *
 * Messages are taken apart by the log's own definitions (F), so that old and new names and units of the
 * columns are found: lat in 1e-7 degrees or latitude_deg, alt in mm or altitude_msl_m. PX4 logs vehicle_imu
 * at 2 Hz by default; its increments are used where they join on to each other, else sensor_combined.
 *
 * Time: `timestamp` (timestamp_sample where there is one) counts from power-up; it becomes GPS time by the
 * pairs in position messages (timestamp; time_utc_usec and the leap seconds of base/time.h), see
 * formats/boot_clock.h. Fixes are stamped by their own time. The receiver's latency is the parameter
 * EKF2_GPS_DELAY of the log, else 0.11 s, PX4's default.
 *
 * Heights are ellipsoidal; a log without them sets `msl`. eph is taken as sqrt(sd_n^2 + sd_e^2),
 * s_variance_m_s (it is a deviation, its name notwithstanding) likewise.
 *
 * A message is believed when another one, or the end, follows it; otherwise the search goes on behind its
 * first byte, and the stretch counts as one loss. Appended data are read where the log says they are.
 *
 * Source: PX4 documentation, "ULog File Format"; pyulog, core.py; px4_msgs. */
#ifndef FURROW_FORMATS_ULOG_H
#define FURROW_FORMATS_ULOG_H

#include "formats/boot_clock.h"
#include "formats/log_records.h"
#include "formats/window.h"

/* A ULog, by its first 8 bytes. */
bool fw_ulog_detect(const uint8_t *bytes, size_t n);

enum {
	FW_ULOG_TOPICS = 10, /* that furrow reads */
	FW_ULOG_FIELDS = 24, /* of a topic, most */
	FW_ULOG_IDS = 4096   /* message numbers that a log may use; PX4 counts them from 0 */
};

/* Where a field of a topic is. */
typedef struct {
	char type;       /* one letter per type; 0: the topic has no such field */
	uint16_t offset; /* from the timestamp's first byte */
} fw_ulog_field;

/* A subscription: one instance of a topic. */
typedef struct {
	bool known;
	int8_t topic; /* -1: not one that furrow reads */
	uint8_t instance;
	uint16_t length; /* of its messages; 0: none seen yet */
} fw_ulog_stream;

/* What is read of a log. */
typedef struct {
	int imu, mag, baro, gps; /* instance wanted; -1: the first */
	double lag_s;            /* latency of fixes; NaN: of the log's parameter, or 0.11 s */
} fw_ulog_plan;

fw_ulog_plan fw_ulog_default_plan(void);

/* About 300 KiB, owned by the caller; must not be moved once begun. */
typedef struct {
	/* Public to read. */
	uint64_t messages; /* intact ones, of whatever type */
	uint64_t lost;     /* stretches that are no message */
	uint64_t bytes_lost;
	uint64_t lost_offset; /* where the last loss began [bytes] */
	const char *reason;   /* and what it was, a few words of English */
	uint64_t untimed;     /* messages left out because no GPS time was known yet */
	uint64_t unhealthy;   /* samples left out whose numbers are not finite */
	uint64_t dropouts;    /* times the autopilot could not write in time */
	uint64_t dropout_ms;  /* and for how long */
	bool msl;             /* some height is above mean sea level */

	/* Private from here. */
	fw_ulog_plan plan;
	bool surveying, surveyed, searching, begun;
	fw_status final;
	fw_log_queue queue;
	fw_boot_clock clock;
	double log_lag_s;
	uint64_t appended[3];                /* where data were appended; what lies before may be cut */
	int64_t first_imu_us;                /* the first of vehicle_imu; -1: none */
	bool imu_of_increments, decided_imu; /* vehicle_imu, and not sensor_combined */
	bool use_sensor_gps;                 /* and not vehicle_gps_position */
	uint64_t
	    count[FW_ULOG_TOPICS]; /* messages of the instance that is read, in this reading and the survey */
	int64_t last_us[FW_ULOG_TOPICS];
	int instance[FW_ULOG_TOPICS]; /* the one that is read; -1: not yet */
	double covered_us;            /* by the intervals of vehicle_imu */
	fw_ulog_field field[FW_ULOG_TOPICS][FW_ULOG_FIELDS];
	fw_ulog_stream stream[FW_ULOG_IDS];
	fw_window window;
} fw_ulog;

/* Begin, survey, read again, read: as formats/dataflash.h has it. */
void fw_ulog_begin(fw_ulog *r, fw_input *input, const fw_ulog_plan *plan);
fw_status fw_ulog_survey(fw_ulog *r) FW_MUST_CHECK;
void fw_ulog_again(fw_ulog *r, fw_input *input);

/* The next record. Returns as fw_dataflash_read(), and FW_EUNKNOWN: no ULog; final. */
fw_status fw_ulog_read(fw_ulog *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

#endif
