/* What the columns of a text table of sensor data mean, as the user says it. formats/imu_text.h reads the table.
 *
 * Three texts make a plan; each is an option of the tools. */
/* clang-format off */
/* --imu-columns MAP
 *     NAME=COLUMN[:UNIT] for each column that is wanted, separated by blanks or commas:
 *         "time=1:us gx=5:deg/s gy=6:deg/s gz=7:deg/s ax=2:g ay=3:g az=4:g"
 *         "time=timestamp gx='w_RS_S_x [rad s^-1]' ..."
 *     COLUMN is a number from 1, or the column's name in the header line; in quotes (' or ") when it has blanks,
 *     commas or colons in it. Several NAMEs may take the same COLUMN.
 *     WORD@COLUMN is a column of those lines only whose first field that is no number is WORD, for files with
 *     lines of several kinds: "gx=imu@6 mx=mag@3:G".
 *     UNIT is one of those below, the first of them when nothing is said; or a number by which the column is
 *     multiplied to have the first one ("vd=20:-1" for a column that is positive upwards).
 *
 *     NAME                UNIT                what
 *     time                s, ms, us, ns       when the line was measured; needed. --imu-time says what it counts
 *     week                1                   GPS week
 *     gx gy gz            rad/s, deg/s        angular rate
 *                         rad, deg            increments over the interval that ends at the time
 *     ax ay az            m/s2, g             specific force; g is 9.80665 m/s2
 *                         m/s                 increments
 *     mx my mz            uT, nT, G, mG       magnetic field
 *                         1                   normalised: 1 becomes 50 uT, its direction counts
 *     baro                m                   barometric height
 *                         Pa, hPa, kPa        pressure; to height by ISO 2533, 1013.25 hPa being 0 m
 *     lat lon             deg, rad            position of the GNSS receiver, geodetic
 *     height              m                   ellipsoidal
 *     vn ve vd            m/s                 its velocity north, east, down
 *     sdn sde sdd         m                   standard deviations of the position
 *     sdvn sdve sdvd      m/s                 of the velocity
 *     nsats               1                   satellites; lines with less than 4 have no position
 *     fix                 1                   type of the fix; lines with less than 3 have no position
 *     fixtime             s, ms, us, ns       when the position was measured; counts as `time` does or, with
 *                                             --imu-time boot,week=N, is a time of the GPS week
 *     nlat nlon           deg, rad            reference: position, velocity, attitude by another filter
 *     nheight             m
 *     nvn nve nvd         m/s
 *     roll pitch heading  deg, rad
 *
 *     Of these, gx..az become an `imu` record, mx..mz `mag`, baro `baro`, lat..fixtime `pos`, nlat..heading `nav`.
 *     Of gx..az, of mx..mz, of lat, lon and height, and so on, all must be named or none.
 *     A table often repeats a position on every line until the next comes: `pos` is written where fixtime changes
 *     or, without fixtime, where position or velocity changes.
 *
 *     Instead of entries, a word for a known layout:
 *         kf-gins      KF-GINS, OB_GINS, i2Nav: IMU increments (7 columns), GNSS (7) or reference (11), told apart
 *                      by their numbers, or said: kf-gins-imu, kf-gins-gnss, kf-gins-nav. Seconds of week:
 *                      --imu-time has to say the week of the first two
 *         euroc        EuRoC, ASL: nanoseconds, rates, specific force; also found by its header, without a map
 *         px4-replay   PX4's EKF replay files: lines `microseconds,imu,...`, mag, baro, gps
 *
 * --imu-axes AXES
 *     Where the sensor's axes point: FRD (forward, right, down; the default), FLU (forward, left, up), RFU (right,
 *     forward, up), or the body's forward, right and down axis in terms of the sensor's x, y, z, such as "-y,x,z".
 *     For gx..gz, ax..az, mx..mz. Left-handed axes are refused.
 *
 * --imu-time SCALE[,week=N][,start=TIME][,shift=SECONDS]
 *     What `time` counts:
 *         unix-utc    seconds since 1970 by UTC clocks (leap seconds are added)
 *         unix-gps    the same by clocks that run on GPS time
 *         gps         seconds of the GPS week: of column `week`, or of week=N in the first line and then of the
 *                     week that is nearest to the line before
 *         boot        seconds since start=TIME (see TIME of the other options); or, with a column fixtime and
 *                     week=N, since the device was switched on: its clock is set by the positions, see
 *                     formats/boot_clock.h
 *     Default: gps with a column `week` or with week=N; unix-utc when the first time is 5e8 s or more.
 *     shift is added to every time; a sensor that is stamped 20 ms late has shift=-0.02. */
/* clang-format on */
#ifndef FURROW_FORMATS_IMU_COLUMNS_H
#define FURROW_FORMATS_IMU_COLUMNS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/time.h"

/* The columns that can be named, in the order of the table above. */
/* clang-format off */
typedef enum {
	FW_IMU_TIME, FW_IMU_WEEK,
	FW_IMU_GX, FW_IMU_GY, FW_IMU_GZ, FW_IMU_AX, FW_IMU_AY, FW_IMU_AZ,
	FW_IMU_MX, FW_IMU_MY, FW_IMU_MZ, FW_IMU_BARO,
	FW_IMU_LAT, FW_IMU_LON, FW_IMU_HEIGHT, FW_IMU_VN, FW_IMU_VE, FW_IMU_VD,
	FW_IMU_SDN, FW_IMU_SDE, FW_IMU_SDD, FW_IMU_SDVN, FW_IMU_SDVE, FW_IMU_SDVD,
	FW_IMU_NSATS, FW_IMU_FIX, FW_IMU_FIXTIME,
	FW_IMU_NLAT, FW_IMU_NLON, FW_IMU_NHEIGHT, FW_IMU_NVN, FW_IMU_NVE, FW_IMU_NVD,
	FW_IMU_ROLL, FW_IMU_PITCH, FW_IMU_HEADING,
	FW_IMU_NAMES
} fw_imu_name;
/* clang-format on */

enum {
	FW_IMU_COLUMN_TEXT = 48, /* longest name of a column in a header, NUL included */
	FW_IMU_TAG_TEXT = 16,    /* longest WORD before @, NUL included */
	FW_IMU_COLUMN_MAX = 256  /* columns of a table */
};

/* One entry of the map. */
typedef struct {
	bool wanted;
	int column;                    /* from 1; 0: by name */
	char name[FW_IMU_COLUMN_TEXT]; /* in the header line */
	char tag[FW_IMU_TAG_TEXT];     /* "": any line */
	double scale;                  /* to SI, degrees, microtesla; of times: ns */
	bool increment, pressure;
} fw_imu_column;

/* A map. Zeroed: none given. */
typedef struct {
	bool given, kf_gins; /* kf_gins: which of its three layouts, the file says */
	fw_imu_column entry[FW_IMU_NAMES];
} fw_imu_map;

typedef enum {
	FW_SCALE_AUTO,
	FW_SCALE_UNIX_UTC,
	FW_SCALE_UNIX_GPS,
	FW_SCALE_GPS,
	FW_SCALE_BOOT
} fw_imu_scale;

/* What `time` counts. Zeroed: nothing said. */
typedef struct {
	fw_imu_scale scale;
	bool has_week, has_start;
	int week;
	fw_time start;
	double shift_s;
} fw_imu_clock;

/* Signed permutation: body[i] = sign[i] * sensor[from[i]]. */
typedef struct {
	bool given; /* false: nothing was said */
	int from[3];
	double sign[3];
} fw_imu_axes;

typedef struct {
	fw_imu_map map;
	fw_imu_axes axes;
	fw_imu_clock clock;
} fw_imu_plan;

/* What is wrong with a text, for a message "--imu-columns: 'TOKEN': REASON". */
typedef struct {
	char token[64]; /* the part of the text that is meant, cut to this length */
	const char *reason;
} fw_imu_problem;

/* A plan that says nothing: no map, FRD, the scale found out. */
void fw_imu_plan_begin(fw_imu_plan *plan);

/* Read the texts of --imu-columns, --imu-axes and --imu-time into a plan that was begun.
 * Return FW_OK; FW_ESYNTAX: *problem says what is wrong, the plan is untouched. */
fw_status fw_imu_parse_columns(const char *text, fw_imu_map *map, fw_imu_problem *problem) FW_MUST_CHECK;
fw_status fw_imu_parse_axes(const char *text, fw_imu_axes *axes, fw_imu_problem *problem) FW_MUST_CHECK;
fw_status fw_imu_parse_time(const char *text, fw_imu_clock *clock, fw_imu_problem *problem) FW_MUST_CHECK;

/* The name of an entry, such as "gx". */
const char *fw_imu_name_text(fw_imu_name name);

/* A sensor's vector to the body. body and sensor may be the same. */
void fw_imu_turn(const fw_imu_axes *axes, const double sensor[static 3], double body[static 3]);

#endif
