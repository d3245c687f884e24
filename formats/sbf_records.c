#include "formats/sbf_records.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "formats/sbf_signal.h"
#include "formats/sbf_special.h"
#include "furrow_comment.h"
#include "furrow_comment_columns.h"

#define BIT(column) (INT64_C(1) << (column))

/* Do-not-use is -2e10. */
#define LOWEST (-1.9e10)

/* A raw value that no integer field can have. */
#define NEVER INT64_MIN

enum {
	EXT_SENSOR_MEAS = 4050,
	PVT_SAT_CARTESIAN = 4008,
	RECEIVER_STATUS = 4014,
	EXT_EVENT = 5924,
	COMMENT = 5936
};

/* ---- Plans ---------------------------------------------------------------------------------------------- */

static int64_t do_not_use(const fw_sbf_field *field)
{
	if (field->dnu != SBF_DNU)
		return field->dnu == SBF_DNU_ZERO ? 0 : NEVER;
	switch (field->type) {
	case SBF_U1: return UINT8_MAX;
	case SBF_U2: return UINT16_MAX;
	case SBF_U4: return UINT32_MAX;
	case SBF_I1: return INT8_MIN;
	case SBF_I2: return INT16_MIN;
	case SBF_I4: return INT32_MIN;
	default: return NEVER;
	}
}

/* How a step makes its value. */
enum { PUT_F4, PUT_F8, PUT_ROOT, PUT_INTEGER, PUT_CHANNEL, PUT_INDEX, PUT_STRING };

static uint8_t action_of(const fw_sbf_field *field)
{
	switch (field->convert) {
	case SBF_NUMBER: return field->type == SBF_F4 ? PUT_F4 : field->type == SBF_F8 ? PUT_F8 : PUT_INTEGER;
	case SBF_ROOT: return PUT_ROOT;
	case SBF_CHANNEL: return PUT_CHANNEL;
	case SBF_INDEX: return PUT_INDEX;
	default: return PUT_STRING;
	}
}

static uint16_t end_of(const fw_sbf_field *field)
{
	if (field->convert == SBF_INDEX || field->convert == SBF_CONSTANT)
		return 0; /* takes nothing from the block */
	return (uint16_t)(field->offset + fw_sbf_type_size(field->type) * field->count);
}

static fw_sbf_steps plan_fields(fw_sbf_plans *plans, fw_kind kind, const fw_sbf_field *fields, unsigned n)
{
	fw_sbf_steps steps = {plans->n_steps, 0};
	const fw_record_type *type = kind < FW_RECORD_COUNT ? fw_record_type_of(kind) : NULL;
	for (unsigned i = 0; type && i < n; i++) {
		const fw_sbf_field *field = &fields[i];
		int column =
		    field->column ? fw_record_column(type, field->column, strlen(field->column)) : -1;
		if (column < 0)
			continue;
		assert(plans->n_steps < FW_SBF_MAX_STEPS);
		plans->steps[plans->n_steps++] = (fw_sbf_step){
		    .field = field,
		    .mul = field->mul < 0 || field->mul > 0 ? field->mul : 1,
		    .div = field->div > 0 ? field->div : 1,
		    .add = field->add,
		    .do_not_use = do_not_use(field),
		    .mask = field->width > 0 && field->width < 63 ? BIT(field->width) - 1 : -1,
		    .offset = field->offset,
		    .end = end_of(field),
		    .action = action_of(field),
		    .type = field->type,
		    .shift = field->shift,
		    .since = field->since,
		    .member = type->columns[column].offset,
		    .column = (uint8_t)column,
		    .column_type = (uint8_t)type->columns[column].type,
		};
		steps.n++;
	}
	return steps;
}

void fw_sbf_plans_init(fw_sbf_plans *plans)
{
	memset(plans, 0, sizeof *plans);
	assert(fw_sbf_n_schemas <= FW_SBF_MAX_SCHEMAS);
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		const fw_sbf_schema *s = &fw_sbf_schemas[i];
		plans->plan[i].fixed = plan_fields(plans, s->kind, s->fields, s->n_fields);
		for (unsigned g = 0; g < s->n_groups; g++)
			plans->plan[i].group[g] =
			    plan_fields(plans, s->kind, s->groups[g].fields, s->groups[g].n_fields);
		const fw_sbf_group *nested = s->n_groups > 0 ? s->groups[0].nested : NULL;
		if (nested)
			plans->plan[i].nested = plan_fields(plans, s->kind, nested->fields, nested->n_fields);
	}
}

/* ---- One value ------------------------------------------------------------------------------------------ */

static bool put_integer(const fw_sbf_step *step, int64_t x, char *member)
{
	switch (step->column_type) {
	case FW_I8:
		if (x != (int8_t)x)
			return false;
		memcpy(member, &(int8_t){(int8_t)x}, sizeof(int8_t));
		return true;
	case FW_I16:
		if (x != (int16_t)x)
			return false;
		memcpy(member, &(int16_t){(int16_t)x}, sizeof(int16_t));
		return true;
	case FW_I32:
		if (x != (int32_t)x)
			return false;
		memcpy(member, &(int32_t){(int32_t)x}, sizeof(int32_t));
		return true;
	default: memcpy(member, &x, sizeof x); return true;
	}
}

/* x * mul / div + add. The sum also makes +0 of -0. */
static bool put_real(const fw_sbf_step *step, double x, char *member)
{
	x *= step->mul;
	if (step->div > 1)
		x /= step->div;
	x += step->add;
	if (step->column_type == FW_F64) {
		memcpy(member, &x, sizeof x);
		return fabs(x) <= DBL_MAX;
	}
	float narrow = (float)x;
	memcpy(member, &narrow, sizeof narrow);
	return fabsf(narrow) <= FLT_MAX;
}

static bool put_integer_field(const fw_sbf_step *step, const uint8_t *p, char *member)
{
	int64_t raw = fw_sbf_load(p, step->type);
	if (raw == step->do_not_use)
		return false;
	raw = raw >> step->shift & step->mask;
	if (step->column_type == FW_F32 || step->column_type == FW_F64)
		return put_real(step, (double)raw, member);
	return put_integer(step, raw + (int64_t)step->add, member);
}

static bool put_string(const char *text, char *member)
{
	if (!text || !text[0])
		return false;
	memcpy(member, &text, sizeof text);
	return true;
}

/* Up to n characters at p, as far as the first NUL, to where strings live until the next block. */
static const char *keep_text(fw_sbf_plans *plans, const uint8_t *p, size_t n)
{
	char *text = plans->text + plans->text_used;
	size_t used = strnlen((const char *)p, n);
	assert(plans->text_used + used < sizeof plans->text);
	memcpy(text, p, used);
	text[used] = '\0';
	plans->text_used += used + 1;
	return text;
}

/* The eight hexadecimal digits of a word, the first one in the lowest byte: each nibble to a byte of its own, then
 * 0..9 to '0'..'9' and 10..15 to 'A'..'F' in all lanes at once. */
static uint64_t hex_digits(uint32_t word)
{
	uint64_t lanes = __builtin_bswap32(word);
	lanes = (lanes | lanes << 16) & UINT64_C(0x0000FFFF0000FFFF);
	lanes = (lanes | lanes << 8) & UINT64_C(0x00FF00FF00FF00FF);
	lanes = (lanes >> 4 | lanes << 8) & UINT64_C(0x0F0F0F0F0F0F0F0F);
	uint64_t letters = (lanes + UINT64_C(0x0606060606060606)) >> 4 & UINT64_C(0x0101010101010101);
	return lanes + UINT64_C(0x3030303030303030) + letters * ('A' - '0' - 10);
}

/* The first `bits` bits of the words at p, in hexadecimal; bits behind them in the last digit are 0. */
static const char *keep_hex(fw_sbf_plans *plans, const uint8_t *p, unsigned bits)
{
	char *text = plans->text + plans->text_used;
	unsigned digits = (bits + 3) / 4;
	assert(plans->text_used + digits + 8 < sizeof plans->text);
	for (unsigned done = 0; done < bits; done += 32, p += 4) {
		uint32_t word = fw_load_u32(p);
		if (bits - done < 32)
			word &= ~(UINT32_MAX >> (bits - done));
		fw_store_u64((uint8_t *)text + done / 4, hex_digits(word));
	}
	text[digits] = '\0';
	plans->text_used += digits + 1;
	return text;
}

static const char *signal_code(unsigned number)
{
	const fw_sbf_signal *signal = fw_sbf_signal_of(number);
	return signal ? signal->rinex : NULL;
}

static const char *text_of(fw_sbf_plans *plans, const fw_sbf_field *field, const uint8_t *p)
{
	switch (field->convert) {
	case SBF_SATELLITE: return fw_sbf_satellite(p[0]);
	case SBF_SIGNAL: return signal_code(p[0] >> field->shift & ((1U << field->width) - 1));
	case SBF_TEXT: return keep_text(plans, p, field->count);
	case SBF_HEX: return keep_hex(plans, p, field->width > 0 ? field->width : field->count * 32U);
	default: return field->name;
	}
}

/* Slots 1 to 30, and one not known. Source: SBF reference guide, "Satellite ID". */
static bool is_glonass(uint8_t svid)
{
	return svid >= 38 && svid <= 68;
}

/* One step; `index` is the number of the sub-block, from 1. Returns whether there is a value. */
static bool put_value(fw_sbf_plans *plans, const fw_sbf_step *step, const uint8_t *start, size_t index,
                      char *member)
{
	const uint8_t *p = start + step->offset;
	double x;
	switch (step->action) {
	case PUT_F4: x = (double)fw_load_f32(p); return x >= LOWEST && put_real(step, x, member);
	case PUT_F8: x = fw_load_f64(p); return x >= LOWEST && put_real(step, x, member);
	case PUT_ROOT: x = (double)fw_load_f32(p); return x >= 0 && put_real(step, sqrt(x), member);
	case PUT_INTEGER: return put_integer_field(step, p, member);
	case PUT_CHANNEL: return is_glonass(p[-1]) && put_integer_field(step, p, member);
	case PUT_INDEX: return put_integer(step, (int64_t)index, member);
	default: return put_string(text_of(plans, step->field, p), member);
	}
}

static void put_nothing(const fw_sbf_step *step, char *member)
{
	static const uint8_t sizes[] = {
	    [FW_I8] = 1, [FW_I16] = 2, [FW_I32] = 4, [FW_I64] = 8, [FW_F32] = 4, [FW_F64] = 8};
	static const char *const empty = "";
	if (step->column_type == FW_STR)
		memcpy(member, &empty, sizeof empty);
	else
		memset(member, 0, sizes[step->column_type]);
}

/* ---- One record ----------------------------------------------------------------------------------------- */

/* Records come here as bytes, and what they share is copied in and out: a pointer to another struct than theirs would
 * entitle the compiler to believe that it points to another record. */

/* Walks over the steps of the `size` bytes at `start`, a block or sub-block. */
static void put_values(fw_sbf_plans *plans, fw_sbf_steps steps, const uint8_t *start, size_t size,
                       size_t index, void *record)
{
	int64_t present;
	memcpy(&present, record, sizeof present);
	for (const fw_sbf_step *step = plans->steps + steps.first, *end = step + steps.n; step < end;
	     step++) {
		char *member = (char *)record + step->member;
		if (step->end <= size && step->since <= plans->revision &&
		    put_value(plans, step, start, index, member)) {
			present |= BIT(step->column);
		} else {
			present &= ~BIT(step->column);
			put_nothing(step, member);
		}
	}
	memcpy(record, &present, sizeof present);
}

static void put_stamp(const uint8_t *block, void *record)
{
	uint32_t tow_ms = fw_load_u32(block + 8);
	uint16_t week = fw_load_u16(block + 12);
	fw_record_head head;
	memcpy(&head, record, sizeof head);
	head.present &= ~(BIT(0) | BIT(1));
	head.gps_week = week == UINT16_MAX ? 0 : week;
	head.tow_s = tow_ms == UINT32_MAX ? 0 : tow_ms / 1000.0;
	if (week != UINT16_MAX)
		head.present |= BIT(0);
	if (tow_ms != UINT32_MAX)
		head.present |= BIT(1);
	memcpy(record, &head, sizeof head);
}

/* Whether all sub-blocks that the counts promise lie inside the block. Moves *at over those of a group. */
static bool group_fits(const fw_sbf_group *group, const uint8_t *block, size_t length, const uint8_t *parent,
                       size_t parent_size, size_t *at)
{
	size_t count = fw_sbf_group_count(group, parent, parent_size);
	size_t size = fw_sbf_group_size(group, block, length);
	if (count > 0 && size == 0)
		return false;
	for (size_t i = 0; i < count; i++) {
		if (*at > length || size > length - *at)
			return false;
		const uint8_t *sub = block + *at;
		*at += size;
		if (group->nested && !group_fits(group->nested, block, length, sub, size, at))
			return false;
	}
	return true;
}

static bool groups_fit(const fw_sbf_schema *schema, const uint8_t *block, size_t length)
{
	size_t at = schema->n_groups > 0 ? schema->groups[0].start : 0;
	for (unsigned g = 0; g < schema->n_groups; g++)
		if (!group_fits(&schema->groups[g], block, length, block, length, &at))
			return false;
	return true;
}

/* The optional parts of a block that make one record with the fixed part. */
static void put_parts(fw_sbf_plans *plans, const fw_sbf_schema *schema, const uint8_t *block, size_t length,
                      void *record)
{
	size_t at = schema->groups[0].start;
	for (unsigned g = 0; g < schema->n_groups; g++) {
		const fw_sbf_group *group = &schema->groups[g];
		if (fw_sbf_group_count(group, block, length) == 0)
			continue;
		put_values(plans, plans->plan[schema - fw_sbf_schemas].group[g], block + at, group->size, 0,
		           record);
		at += group->size;
	}
}

static bool makes_rows(const fw_sbf_plans *plans, const fw_sbf_schema *schema)
{
	return schema->n_groups > 0 && schema->groups[0].count != SBF_COUNT_BIT &&
	       plans->plan[schema - fw_sbf_schemas].group[0].n > 0;
}

/* All that the block says once. */
static void put_block(fw_sbf_plans *plans, const fw_sbf_schema *schema, const uint8_t *block, size_t length,
                      void *record)
{
	plans->revision = block[5] >> 5;
	plans->text_used = 0;
	put_stamp(block, record);
	size_t fixed_end = fw_sbf_fixed_end(schema, length);
	put_values(plans, plans->plan[schema - fw_sbf_schemas].fixed, block, fixed_end, 0, record);
	if (schema->n_groups > 0 && schema->groups[0].count == SBF_COUNT_BIT)
		put_parts(plans, schema, block, length, record);
}

static void put_comment(fw_sbf_plans *plans, const uint8_t *block, furrow_comment *comment)
{
	const char *text = keep_text(plans, block + 16, fw_load_u16(block + 14));
	memcpy(&comment->text, &text, sizeof text);
	if (text[0])
		comment->present |= BIT(FW_COL_comment_text);
}

/* What the table cannot say about the blocks that make one record. */
static void put_special(fw_sbf_plans *plans, uint16_t id, const uint8_t *block, void *record)
{
	if (id == EXT_EVENT)
		fw_sbf_place_event(record);
	else if (id == COMMENT)
		put_comment(plans, block, record);
}

/* The schema of a block that makes records; NULL when there is none, or *status is not FW_OK. */
static const fw_sbf_schema *schema_of(const uint8_t *block, size_t length, fw_status *status)
{
	const fw_sbf_schema *schema = fw_sbf_schema_find(fw_load_u16(block + 4) & 0x1FFF);
	*status = FW_EUNKNOWN;
	if (!schema || schema->kind == FW_RECORD_COUNT)
		return NULL;
	*status = length < FW_SBF_BODY || !groups_fit(schema, block, length) ? FW_EFORMAT : FW_OK;
	return *status == FW_OK ? schema : NULL;
}

fw_status fw_sbf_fill(fw_sbf_plans *plans, const uint8_t *block, size_t length, void *record)
{
	fw_status status;
	const fw_sbf_schema *schema = schema_of(block, length, &status);
	if (!schema)
		return status;
	put_block(plans, schema, block, length, record);
	put_special(plans, schema->id, block, record);
	return FW_OK;
}

/* ---- Many records --------------------------------------------------------------------------------------- */

/* A block on its way into rows. */
typedef struct {
	fw_sbf_plans *plans;
	const fw_sbf_schema *schema;
	const uint8_t *block;
	size_t length;
	void *record;
	fw_sink sink;
} rows;

static void emit_nested(const rows *r, const fw_sbf_group *group, const uint8_t *sub, size_t sub_size,
                        size_t *at)
{
	size_t count = fw_sbf_group_count(group, sub, sub_size);
	size_t size = fw_sbf_group_size(group, r->block, r->length);
	for (size_t k = 0; k < count; k++, *at += size) {
		const uint8_t *p = r->block + *at;
		put_values(r->plans, r->plans->plan[r->schema - fw_sbf_schemas].nested, p, size, k + 1,
		           r->record);
		fw_sbf_set_quantity(r->record, sub[group->count_offset], (unsigned)k, p, size);
		r->sink.put(r->sink.context, r->schema->kind, r->record);
	}
}

/* A record for each sub-block of the first group, or for each one nested in these. Returns how many sub-blocks. */
static size_t emit_rows(const rows *r)
{
	const fw_sbf_group *group = r->schema->groups;
	const fw_sbf_steps steps = r->plans->plan[r->schema - fw_sbf_schemas].group[0];
	size_t count = fw_sbf_group_count(group, r->block, r->length);
	size_t size = fw_sbf_group_size(group, r->block, r->length);
	size_t at = group->start, text_used = r->plans->text_used;
	for (size_t i = 0; i < count; i++) {
		const uint8_t *sub = r->block + at;
		r->plans->text_used = text_used;
		put_values(r->plans, steps, sub, size, i + 1, r->record);
		if (r->schema->id == PVT_SAT_CARTESIAN)
			fw_sbf_set_delays(r->record, sub, size);
		at += size;
		if (group->nested)
			emit_nested(r, group->nested, sub, size, &at);
		else
			r->sink.put(r->sink.context, r->schema->kind, r->record);
	}
	return count;
}

static void emit_sensors(const rows *r, const fw_kind_set *wanted)
{
	const fw_sbf_group *group = r->schema->groups;
	const fw_sbf_steps steps = r->plans->plan[r->schema - fw_sbf_schemas].group[0];
	const double *C = r->plans->mounted ? r->plans->C_vehicle_sensor : NULL;
	size_t count = fw_sbf_group_count(group, r->block, r->length);
	size_t size = fw_sbf_group_size(group, r->block, r->length);
	furrow_imu imu = {0};
	r->plans->revision = r->block[5] >> 5;
	for (size_t i = 0; i < count; i++) {
		const uint8_t *sub = r->block + group->start + i * size;
		furrow_ext_sensor sensor = {0};
		put_stamp(r->block, &sensor);
		put_values(r->plans, steps, sub, size, i + 1, &sensor);
		if (size >= group->size)
			fw_sbf_set_sensor(&sensor, sub + 4);
		fw_sbf_add_imu(&imu, &sensor, C);
		if (fw_kind_in(wanted, FW_ext_sensor))
			r->sink.put(r->sink.context, FW_ext_sensor, &sensor);
	}
	if (imu.present == 0 || !fw_kind_in(wanted, FW_imu))
		return;
	put_stamp(r->block, &imu);
	r->sink.put(r->sink.context, FW_imu, &imu);
}

static void note_mounting(fw_sbf_plans *plans, const furrow_imu_setup *setup)
{
	if (fw_sbf_mounting(setup, plans->C_vehicle_sensor))
		plans->mounted = true;
}

fw_status fw_sbf_emit(fw_sbf_plans *plans, const uint8_t *block, size_t length, const fw_kind_set *wanted,
                      fw_sink sink)
{
	fw_status status;
	const fw_sbf_schema *schema = schema_of(block, length, &status);
	if (!schema)
		return status;
	fw_any_record record;
	const rows r = {plans, schema, block, length, &record, sink};
	if (schema->id == EXT_SENSOR_MEAS) {
		if (fw_kind_in(wanted, FW_ext_sensor) || fw_kind_in(wanted, FW_imu))
			emit_sensors(&r, wanted);
		return FW_OK;
	}
	if (!fw_kind_in(wanted, schema->kind) && schema->kind != FW_imu_setup)
		return FW_OK;

	memset(&record, 0, fw_record_type_of(schema->kind)->size); /* all strings are set below */
	put_block(plans, schema, block, length, &record);
	put_special(plans, schema->id, block, &record);
	if (schema->kind == FW_imu_setup)
		note_mounting(plans, (const furrow_imu_setup *)(const void *)&record);
	if (!fw_kind_in(wanted, schema->kind))
		return FW_OK;
	if (!makes_rows(plans, schema) || (emit_rows(&r) == 0 && schema->id == RECEIVER_STATUS))
		sink.put(sink.context, schema->kind, &record);
	return FW_OK;
}
