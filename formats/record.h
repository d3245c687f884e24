/* Records: what every tool reads and writes.
 *
 * A record type is defined once, in records/NAME.lcm. lcm-gen turns that into the C struct furrow_NAME
 * (header furrow_NAME.h) and its LCM coding; this file adds what the CSV side needs: for each type the
 * list of its columns, found through the type information that lcm-gen emits.
 *
 * Every struct begins
 *     int64_t present;   bit i: column i has a value (column 0 is gps_week)
 *     int32_t gps_week;  column 0, GPS week counted on without roll-over
 *     double  tow_s;     column 1, GPS time of week [s]
 * A column whose bit is clear holds 0 or "" and is an empty field in CSV: never 0, never NaN.
 * Strings belong to whoever made the record; they live until its maker is called again. */
#ifndef FURROW_FORMATS_RECORD_H
#define FURROW_FORMATS_RECORD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/time.h"

/* Every record type: X(name), in the order in which the manual lists them. */
/* clang-format off */
#define FW_RECORD_TYPES(X) \
	X(obs) X(epoch) X(obs_extra) X(pvt) X(event_pvt) X(pvt_ecef) X(event_pvt_ecef) X(dop) X(att) \
	X(event_att) X(aux_ant) X(base) X(event_base) X(base_ecef) X(event_base_ecef) X(event) \
	X(satpos) X(residual) X(raim) X(quality) X(time) X(status) X(setup) X(comment) X(eph_gps) \
	X(eph_bds) X(eph_gal) X(eph_glo) X(eph_sbas) X(klobuchar) X(nequick) X(utc) X(ggto) \
	X(glo_time) X(page) X(sbas) X(sbas_mt0) X(sbas_mask) X(sbas_fast) X(sbas_integrity) \
	X(sbas_degradation) X(sbas_factors) X(sbas_time) X(sbas_almanac) X(sbas_igp_mask) \
	X(sbas_long) X(sbas_iono) X(sbas_service) X(sbas_cov) X(sbas_corr) X(sbas5_nav) \
	X(sbas5_almanac) X(ins) X(event_ins) X(ins_ecef) X(event_ins_ecef) X(imu) X(ext_sensor) \
	X(imu_setup) X(velocity_setup) X(sensor_setup) X(mag) X(baro) X(pl) X(transition) X(pos) X(nav) X(meta)
/* clang-format on */

/* FW_obs, FW_epoch, ...: one constant per record type. */
typedef enum {
#define X(name) FW_##name,
	FW_RECORD_TYPES(X)
#undef X
	    FW_RECORD_COUNT
} fw_kind;

typedef enum { FW_I8, FW_I16, FW_I32, FW_I64, FW_F32, FW_F64, FW_STR } fw_column_type;

/* How a column is written as text. Integers and strings know one form only. */
typedef enum {
	FW_TEXT_PLAIN,   /* integer or string */
	FW_TEXT_FIXED,   /* `decimals` decimals */
	FW_TEXT_TRIMMED, /* `decimals` decimals, trailing zeros dropped */
	FW_TEXT_SHORTEST /* the shortest text that reads back as the same float or double */
} fw_column_text;

enum { FW_MAX_COLUMNS = 63 };

typedef struct {
	const char *name;    /* snake_case with the unit as suffix */
	fw_column_type type; /* type of the member */
	fw_column_text text; /* form in CSV */
	int decimals;        /* for FW_TEXT_FIXED and FW_TEXT_TRIMMED */
	uint16_t offset;     /* of the member in the struct [bytes] */
} fw_column;

typedef struct {
	const char *name;    /* "obs" */
	const char *channel; /* "FURROW_OBS", the LCM channel */
	uint16_t size;       /* of the struct [bytes] */
	uint16_t n_columns;  /* at most FW_MAX_COLUMNS */
	int64_t hash;        /* LCM fingerprint */
	fw_column columns[FW_MAX_COLUMNS];
} fw_record_type;

/* The head that all record structs share. */
typedef struct {
	int64_t present;
	int32_t gps_week;
	double tow_s;
} fw_record_head;

/* Room for a record of any type, suitably aligned. */
typedef union {
	fw_record_head head;
	char bytes[640];
} fw_any_record;

/* A set of kinds, such as those that the user asked for. */
typedef struct {
	uint64_t bits[(FW_RECORD_COUNT + 63) / 64];
} fw_kind_set;

static inline int fw_kind_in(const fw_kind_set *set, fw_kind kind)
{
	return (int)(set->bits[(unsigned)kind / 64] >> ((unsigned)kind % 64) & 1);
}

static inline void fw_kind_add(fw_kind_set *set, fw_kind kind)
{
	set->bits[(unsigned)kind / 64] |= UINT64_C(1) << ((unsigned)kind % 64);
}

/* Where records go: called once per record; `record` points to a struct furrow_NAME of that kind and is the
 * callee's only until it returns. Errors stay with `context`, which its owner asks afterwards. */
typedef struct {
	void (*put)(void *context, fw_kind kind, const void *record);
	void *context;
} fw_sink;

/* Where a writer's bytes go: takes all n of them or fails. Its first failure is the writer's last call. */
typedef fw_status fw_output(void *context, const void *bytes, size_t n);

/* The type of a kind, with its columns. The table is built from lcm-gen's type information at the first call
 * (a program with threads makes that call before it starts them) and never changes after. */
const fw_record_type *fw_record_type_of(fw_kind kind);

/* The kind named by the n characters at `name` ("obs"), or FW_RECORD_COUNT. */
fw_kind fw_record_find(const char *name, size_t n);

/* The index of a type's column named by the n characters at `name`, or -1. */
int fw_record_column(const fw_record_type *type, const char *name, size_t n);

/* Makes an empty record: nothing present, numbers 0, strings "". */
void fw_record_clear(fw_kind kind, void *record);

/* The LCM encoding of a record, made by lcm-gen's own functions.
 *   record  in   strings may be NULL, which encodes as ""
 *   buffer  out  `size` bytes of room
 *   used    out  length of the encoding [bytes]
 * Returns FW_OK; FW_ENOSPACE: `size` is too small, *used untouched. */
fw_status fw_record_encode(fw_kind kind, const void *record, void *buffer, size_t size,
                           size_t *used) FW_MUST_CHECK;

/* The record that an LCM encoding holds. Trusts nothing: the fingerprint must be the type's, every string has
 * to end inside `data`, and nothing may be left over. A column that the mask calls absent comes out empty
 * whatever it holds; a number that is not finite and an empty string come out absent.
 *   data    in   n bytes; the record's strings point into them
 *   record  out  room for the type's struct; undefined on failure
 * Returns FW_OK; FW_EFORMAT: no encoding of this type. */
fw_status fw_record_decode(fw_kind kind, const void *data, size_t n, void *record) FW_MUST_CHECK;

/* Rounds every column of a record to what its text form carries, so that a record that came through CSV and
 * one that did not are the same bit for bit: a number that is not finite and an empty string become absent,
 * -0 becomes 0. (CSV writes '?' for bytes that are no UTF-8; strings stay as they are here.) */
void fw_record_round(fw_kind kind, void *record);

/* What the closing line of a stream or log says, "status=... rows=... skipped=N": returns whether it is partial, and adds
 * N to *skipped. */
bool fw_record_end(const char *value, uint64_t *skipped);

/* The record's time stamp. Returns FW_OK; FW_EINVAL: week or time of week is absent; FW_ERANGE or
 * FW_ENONFINITE: they are no time (base/time.h). *t untouched on failure. */
fw_status fw_record_time(const void *record, fw_time *t) FW_MUST_CHECK;

#endif
