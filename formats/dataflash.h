/* ArduPilot's DataFlash logs, binary (.bin) and text (.log), as records.
 *
 *     IMU, or ACC and GYR when there is no IMU   imu     rates and specific force, FRD
 *     MAG                                        mag
 *     BARO                                       baro    above the place of calibration
 *     GPS with GPA                               pvt     the receiver in use
 *     ATT, or AHR2 when there is no ATT          nav     attitude only, status "autopilot"
 *     CAM, TRIG                                  event   source 1, 2
 *
 * The autopilot's attitude is `nav` and not `att`: it is no measurement, its IMU is in it.
 *
 * The log says itself what its messages consist of (FMT); nothing is assumed but their names and their
 * columns' names, so old and new logs are read alike. Columns that are not there are absent. A message is
 * believed when its length leads to another message or to the end; otherwise the search for A3 95 goes on
 * behind its first byte, and the stretch counts as one loss. Zeros or 0xff up to the end are padding.
 *
 * Time: TimeUS counts from power-up; it becomes GPS time by the pairs in GPS messages (TimeUS; GWk, GMS), see
 * formats/boot_clock.h. IMU samples are stamped TimeUS (or SampleUS), fixes by their own GPS time, so in the
 * output a fix comes up to some 0.3 s after samples of later time. The receiver's latency, the time from a
 * fix to its message, is that of the parameter GPS_DELAY_MS (GPS1_DELAY_MS) in the log, where it is set, else
 * 0.12 s, which ArduPilot assumes for the u-blox receivers that most have.
 *
 * Heights of GPS messages are above mean sea level. Where GPA has AEl, as newer logs do, the fix gets its
 * ellipsoidal height and the undulation; where not, `msl` says that heights are those of the geoid.
 *
 * IMU messages hold what the sensor said at that moment, at the rate of the log, not an average over the
 * interval. HAcc is taken as sqrt(sd_n^2 + sd_e^2), SAcc likewise.
 *
 * Source: ArduPilot, libraries/AP_Logger/LogStructure.h and AP_GPS/LogStructure.h; pymavlink, DFReader.py. */
#ifndef FURROW_FORMATS_DATAFLASH_H
#define FURROW_FORMATS_DATAFLASH_H

#include "formats/boot_clock.h"
#include "formats/log_records.h"
#include "formats/rinex.h"
#include "formats/window.h"

enum {
	FW_DATAFLASH_TYPES = 256, /* message types of a log */
	FW_DATAFLASH_FIELDS = 16  /* columns of a message that furrow reads, most */
};

/* Which form a log has, by its first bytes. */
typedef enum { FW_DATAFLASH_NONE, FW_DATAFLASH_BINARY, FW_DATAFLASH_TEXT } fw_dataflash_kind;
fw_dataflash_kind fw_dataflash_detect(const uint8_t *bytes, size_t n);

/* What is read of a log. */
typedef struct {
	int imu, mag, baro,
	    gps; /* instance wanted; -1: of IMU, magnetometer and barometer the first that says it is healthy,
	                          * of GPS the one in use */
	double lag_s; /* latency of fixes; NaN: of the log's parameter, or 0.12 s */
} fw_dataflash_plan;

/* The first healthy of everything, latency as the log says. */
fw_dataflash_plan fw_dataflash_default_plan(void);

/* Where one column of a message is. */
typedef struct {
	char type;       /* of FMT's format; 0: the message has no such column */
	uint16_t offset; /* binary: from the message's first byte; text: field, the name being 0 */
} fw_dataflash_field;

/* A message type of the log. */
typedef struct {
	uint8_t length;   /* binary: with its 3 bytes of header; 0: not defined */
	int8_t kind;      /* what furrow makes of it; -1: nothing */
	uint8_t instance; /* of a name like IMU2, where there is no column for it */
	char name[5];
	fw_dataflash_field field[FW_DATAFLASH_FIELDS];
} fw_dataflash_type;

/* About 300 KiB, owned by the caller; must not be moved once begun. */
typedef struct {
	/* Public to read. */
	uint64_t messages; /* intact ones, of whatever type */
	uint64_t lost;     /* messages damaged, or stretches that are none */
	uint64_t bytes_lost;
	uint64_t lost_offset; /* where the last loss began [bytes]; of text: its line */
	const char *reason;   /* and what it was, a few words of English */
	uint64_t untimed;     /* messages left out because no GPS time was known yet */
	uint64_t unhealthy;   /* samples left out: not healthy, as they say, or not finite */
	bool msl;             /* some height is above mean sea level */

	/* Private from here. */
	fw_dataflash_plan plan;
	bool text, surveying, searching, reread;
	fw_status final;
	fw_log_queue queue;
	fw_boot_clock clock;
	double log_lag_s;      /* of the parameter; NaN: not there */
	int chosen[4];         /* instances: IMU, MAG, BARO, GPS; -1: not yet */
	bool has_imu, has_att; /* seen, here or in the survey */
	bool raw_in_use;       /* ACC and GYR, since there is no IMU */
	int64_t raw_since_us;  /* the first of them; -1: none */
	int64_t raw_begin_us;  /* the first one since the last sample; -1: none */
	double raw_sum[2][3];  /* ACC, GYR since then */
	int raw_n[2];
	bool fix_waits; /* for its GPA */
	int64_t fix_us;
	fw_time fix_time;
	int fix_instance;
	double fix_msl_m;
	fw_log_fix fix;
	fw_dataflash_type types[FW_DATAFLASH_TYPES];
	int n_types; /* text: used of `types` */
	union {
		fw_window window;
		fw_lines lines;
	} from;
} fw_dataflash;

/* Begin to read.
 *   input  in  open, nothing read; read to its end, the caller closes it
 *   kind   in  binary or text
 *   plan   in  copied; NULL: the default */
void fw_dataflash_begin(fw_dataflash *r, fw_input *input, fw_dataflash_kind kind,
                        const fw_dataflash_plan *plan);

/* First reading of two, to the end of the input: learns the clock, the latency and what there is. Then open
 * the input anew and call fw_dataflash_again(). Without it (a pipe) what comes before the first GPS time has
 * none and is left out, and time stamps settle in the first seconds only.
 * Returns FW_EOF, or what ended it early as fw_dataflash_read(). */
fw_status fw_dataflash_survey(fw_dataflash *r) FW_MUST_CHECK;
void fw_dataflash_again(fw_dataflash *r, fw_input *input);

/* The next record.
 * Returns
 *   FW_OK          a record
 *   FW_ESYNTAX     something is lost: r->lost_offset and r->reason say where and why; call again
 *   FW_EOF         the end
 *   FW_ETRUNCATED  the end, but inside a message, or a gzip file that is cut short
 *   FW_EIO, FW_EFORMAT, FW_ENOMEM   from fw_input_read()
 * All but the first two are final. kind and record are set with FW_OK only. */
fw_status fw_dataflash_read(fw_dataflash *r, fw_kind *kind, fw_any_record *record) FW_MUST_CHECK;

#endif
