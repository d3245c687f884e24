/* A part of source.h: logs of other devices, of autopilots (ArduPilot, PX4), tables of sensor data,
 * Waypoint's IMR, RTKLIB's solutions. And what it shares with source.c. */
#ifndef FURROW_CLI_SOURCE_LOGS_H
#define FURROW_CLI_SOURCE_LOGS_H

#include "formats/dataflash.h"
#include "formats/imr.h"
#include "formats/imu_text.h"
#include "formats/input.h"
#include "formats/rtklib_pos.h"
#include "formats/ulog.h"
#include "source.h"

/* What reading such a log takes; one of them at a time. */
typedef union {
	fw_dataflash dataflash;
	fw_ulog ulog;
	fw_imr imr;
	fw_rtklib_pos solutions;
	fw_imu_text table;
} log_readers;

/* What a file is being read for. */
typedef struct {
	tool *t;
	const char *name, *path;
	const source_plan *plan;
	fw_sink sink;
	source_totals *totals;
	fw_input *input;
	log_readers *logs;
	tool_progress progress;
	uint64_t lost; /* in this file */
	int partial;   /* it says itself that it is not all */
} source_job;

/* In source.c: */

/* Opens the job's file, once more if need be. Returns as fw_input_open(). */
fw_status source_open(source_job *j) FW_MUST_CHECK;

/* Not worth reading on: a signal came, or nobody takes the records any more. */
int source_must_stop(const source_job *j);

/* Hands a record on, if it is wanted, and counts it. */
void source_put(const source_job *j, fw_kind kind, const fw_any_record *record);

/* Whether a path names a file, which can be read twice, and its size, else 0. */
int source_is_file(const char *path, int64_t *size);

/* In source_logs.c: */

/* Whether a file is a log of such a kind, by its first bytes and the plan. */
int source_logs_detect(const source_job *j, const uint8_t *bytes, size_t n);

/* Reads it. Returns FW_EOF, or what ended it early as fw_input_read(). */
fw_status source_logs_read(source_job *j, const uint8_t *bytes, size_t n);

#endif
