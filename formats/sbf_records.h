/* SBF blocks to records, by the table (sbf_schema.h): all blocks but the measurements.
 *
 * A plan holds the table with every column resolved to a place in the record's struct; making a record is a walk
 * over its steps. Values that mean "not available", floats that are not finite or below -1.9e10, fields that the
 * block is too short for, and numbers that do not fit their column are absent. */
#ifndef FURROW_FORMATS_SBF_RECORDS_H
#define FURROW_FORMATS_SBF_RECORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "formats/record.h"
#include "formats/sbf_codec.h"

enum { FW_SBF_MAX_SCHEMAS = 128, FW_SBF_MAX_GROUPS = 8, FW_SBF_MAX_STEPS = 1280 };

/* One field or view that becomes a column. */
typedef struct {
	const fw_sbf_field *field;
	double mul, div, add;
	int64_t do_not_use;         /* raw value that means "not available" */
	int64_t mask;               /* of an integer or its view, after the shift */
	uint16_t offset;            /* of the field in its block or sub-block [bytes] */
	uint16_t end;               /* likewise: the byte after it; 0 for what is not on the wire */
	uint16_t member;            /* offset in the record's struct [bytes] */
	uint8_t column;             /* index */
	uint8_t column_type;        /* fw_column_type */
	uint8_t action;             /* what makes a value of it */
	uint8_t type, shift, since; /* the field's */
} fw_sbf_step;

/* The steps of one list of fields. */
typedef struct {
	uint16_t first, n;
} fw_sbf_steps;

/* The plans of all blocks, and what has to be remembered between them. Owned by the caller, about 160 kB. */
typedef struct {
	struct {
		fw_sbf_steps fixed, group[FW_SBF_MAX_GROUPS], nested; /* nested: in group 0 */
	} plan[FW_SBF_MAX_SCHEMAS];                                   /* in the order of fw_sbf_schemas */
	uint16_t n_steps;
	fw_sbf_step steps[FW_SBF_MAX_STEPS];
	bool mounted;               /* an IMUSetup block was seen */
	double C_vehicle_sensor[9]; /* 3 x 3, row-major: x_vehicle = C x_sensor */
	uint8_t revision;           /* of the block at hand */
	size_t text_used;
	char text[FW_SBF_MAX_LENGTH + 1024]; /* the strings of the record at hand */
} fw_sbf_plans;

/* Makes the plans. Call it once; the plans then serve one log. */
void fw_sbf_plans_init(fw_sbf_plans *plans);

/* Fills what the fixed part of a block and its optional parts say into a record of the block's kind, time stamp
 * included, and leaves all other columns alone: so several blocks of an epoch become one record. Nothing is
 * emitted; sub-blocks that make a record each are passed over.
 *   block   in      whole block of `length` bytes (its own length field), CRC checked
 *   record  in/out  cleared or filled before; its strings live until the next call with these plans
 * Returns FW_OK; FW_EUNKNOWN: the block has no schema or no record; FW_EFORMAT: its counts and lengths contradict
 * its length. *record untouched on error. */
fw_status fw_sbf_fill(fw_sbf_plans *plans, const uint8_t *block, size_t length, void *record) FW_MUST_CHECK;

/* Emits the records of a block: one, or one for each sub-block, or none if it has none. ReceiverStatus without
 * front ends still makes its one. ExtSensorMeas makes `ext_sensor` and, of acceleration and angular rate, `imu`, in
 * the vehicle's frame as the last IMUSetup block describes it, in the sensor's own while none was seen.
 *   wanted  in  other kinds are not made
 * Returns as fw_sbf_fill; nothing is emitted on error. */
fw_status fw_sbf_emit(fw_sbf_plans *plans, const uint8_t *block, size_t length, const fw_kind_set *wanted,
                      fw_sink sink) FW_MUST_CHECK;

#endif
