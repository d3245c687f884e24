#include "formats/sbf_build.h"

#include <math.h>
#include <string.h>

#include "formats/sbf_signal.h"
#include "furrow_event.h"
#include "furrow_event_columns.h"

#define BIT(column) (INT64_C(1) << (column))

/* What SBF writes for a float that is not available. */
#define FLOAT_DO_NOT_USE (-2e10)

#define SECONDS_PER_WEEK 604800.0

enum {
	PVT_SAT_CARTESIAN = 4008,
	PVT_RESIDUALS = 4009,
	EXT_SENSOR_MEAS = 4050,
	EXT_EVENT = 5924,
	COMMENT = 5936
};

/* ---- One value ------------------------------------------------------------------------------------------ */

static fw_record_head head_of(const void *record)
{
	fw_record_head head;
	memcpy(&head, record, sizeof head);
	return head;
}

static double read_real(const fw_sbf_step *step, const char *member)
{
	float narrow;
	double x;
	if (step->column_type == FW_F32) {
		memcpy(&narrow, member, sizeof narrow);
		return (double)narrow;
	}
	memcpy(&x, member, sizeof x);
	return x;
}

static double read_number(const fw_sbf_step *step, const char *member)
{
	int8_t i8;
	int16_t i16;
	int32_t i32;
	int64_t i64;
	switch (step->column_type) {
	case FW_I8: memcpy(&i8, member, sizeof i8); return i8;
	case FW_I16: memcpy(&i16, member, sizeof i16); return i16;
	case FW_I32: memcpy(&i32, member, sizeof i32); return i32;
	case FW_I64: memcpy(&i64, member, sizeof i64); return (double)i64;
	default: return read_real(step, member);
	}
}

static const char *read_string(const char *member)
{
	const char *text;
	memcpy(&text, member, sizeof text);
	return text;
}

static void or_bytes(uint8_t *p, size_t size, uint64_t raw)
{
	for (size_t i = 0; i < size; i++)
		p[i] |= (uint8_t)(raw >> 8 * i);
}

static void write_float(uint8_t *p, uint8_t type, double x)
{
	float narrow = (float)x;
	uint32_t bits32;
	uint64_t bits64;
	memcpy(&bits32, &narrow, sizeof bits32);
	memcpy(&bits64, &x, sizeof bits64);
	if (type == SBF_F4)
		fw_store_u32(p, bits32);
	else
		fw_store_u64(p, bits64);
}

/* The nearest raw value in the range of the field or view that does not mean "not available". */
static int64_t nearest_raw(const fw_sbf_step *step, double x)
{
	const fw_sbf_field *field = step->field;
	int bits = field->width > 0 ? field->width : 8 * (int)fw_sbf_type_size(field->type);
	bool is_signed = field->type == SBF_I1 || field->type == SBF_I2 || field->type == SBF_I4;
	int64_t low = is_signed ? -BIT(bits - 1) : 0;
	int64_t high = is_signed ? BIT(bits - 1) - 1 : BIT(bits) - 1;
	if (step->do_not_use == low)
		low++;
	if (step->do_not_use == high)
		high--;
	if (!(x > (double)low))
		return low;
	return x < (double)high ? llround(x) : high;
}

static void write_number(const fw_sbf_step *step, const char *member, uint8_t *p)
{
	const fw_sbf_field *field = step->field;
	double x = (read_number(step, member) - step->add) * step->div / step->mul;
	if (field->type == SBF_F4 || field->type == SBF_F8)
		write_float(p, field->type, x);
	else
		or_bytes(p, fw_sbf_type_size(field->type), (uint64_t)nearest_raw(step, x) << field->shift);
}

/* A RINEX code says which signal only together with the satellite's system; without one, or for a code that the
 * system does not have, the first signal of that code is taken. Where no number fits, the highest one, which is the
 * escape of the five bits, stands for "none". */
static void write_signal(const fw_sbf_step *step, const char *code, char system, uint8_t *p)
{
	unsigned none = (1U << step->field->width) - 1, found = none;
	for (unsigned number = none; number-- > 0;) {
		const fw_sbf_signal *signal = fw_sbf_signal_of(number);
		if (!signal || !code[0] || strcmp(signal->rinex, code) != 0)
			continue;
		found = number;
		if (signal->system == system)
			break;
	}
	p[0] |= (uint8_t)(found << step->field->shift);
}

static void write_absent(const fw_sbf_step *step, uint8_t *p)
{
	const fw_sbf_field *field = step->field;
	if (field->convert == SBF_SIGNAL)
		write_signal(step, "", '\0', p);
	if (field->width > 0 || (field->convert != SBF_NUMBER && field->convert != SBF_CHANNEL))
		return;
	if (field->type == SBF_F4 || field->type == SBF_F8)
		write_float(p, field->type, FLOAT_DO_NOT_USE);
	else if (step->do_not_use != INT64_MIN)
		or_bytes(p, fw_sbf_type_size(field->type), (uint64_t)step->do_not_use);
}

static void write_hex(const fw_sbf_field *field, const char *digits, uint8_t *p)
{
	static const char alphabet[] = "0123456789ABCDEF";
	for (unsigned i = 0; i < field->count * 8U && digits[i]; i++) {
		const char *digit = strchr(alphabet, digits[i]);
		uint32_t raw = digit ? (uint32_t)(digit - alphabet) : 0;
		or_bytes(p + i / 8 * 4, 4, raw << (28 - i % 8 * 4));
	}
}

/* ---- One part of a block -------------------------------------------------------------------------------- */

static char system_of(const fw_sbf_plans *plans, fw_sbf_steps steps, const void *record)
{
	for (unsigned i = 0; i < steps.n; i++) {
		const fw_sbf_step *step = &plans->steps[steps.first + i];
		const char *text = read_string((const char *)record + step->member);
		if (step->field->convert == SBF_SATELLITE && text)
			return text[0];
	}
	return '\0';
}

static void write_values(const fw_sbf_plans *plans, fw_sbf_steps steps, const void *record, uint8_t *start)
{
	const int64_t present = head_of(record).present;
	for (unsigned i = 0; i < steps.n; i++) {
		const fw_sbf_step *step = &plans->steps[steps.first + i];
		const fw_sbf_field *field = step->field;
		const char *member = (const char *)record + step->member;
		uint8_t *p = start + field->offset;
		if (!(present & BIT(step->column))) {
			write_absent(step, p);
			continue;
		}
		switch (field->convert) {
		case SBF_CHANNEL:
		case SBF_NUMBER: write_number(step, member, p); break;
		case SBF_SATELLITE: p[0] = fw_sbf_svid(read_string(member)); break;
		case SBF_SIGNAL:
			write_signal(step, read_string(member), system_of(plans, steps, record), p);
			break;
		case SBF_TEXT:
			memcpy(p, read_string(member), strnlen(read_string(member), field->count));
			break;
		case SBF_HEX: write_hex(field, read_string(member), p); break;
		default: break; /* what the wire does not carry */
		}
	}
}

static bool has_any(const fw_sbf_plans *plans, fw_sbf_steps steps, const void *record)
{
	int64_t columns = 0;
	for (unsigned i = 0; i < steps.n; i++)
		columns |= BIT(plans->steps[steps.first + i].column);
	return (head_of(record).present & columns) != 0;
}

/* ---- A block -------------------------------------------------------------------------------------------- */

/* The optional parts that the record has something for. */
static size_t write_parts(const fw_sbf_plans *plans, const fw_sbf_schema *schema, const void *record,
                          uint8_t *block)
{
	size_t at = schema->size;
	for (unsigned g = 0; g < schema->n_groups; g++) {
		const fw_sbf_group *group = &schema->groups[g];
		fw_sbf_steps steps = plans->plan[schema - fw_sbf_schemas].group[g];
		if (!has_any(plans, steps, record))
			continue;
		or_bytes(block + group->count_offset, 2, UINT64_C(1) << group->count_bit);
		memset(block + at, 0, group->size);
		write_values(plans, steps, record, block + at);
		at += group->size;
	}
	return at;
}

static fw_status write_rows(const fw_sbf_plans *plans, const fw_sbf_schema *schema,
                            const void *const *records, size_t n, uint8_t *block, size_t *end)
{
	const fw_sbf_group *group = schema->groups;
	fw_sbf_steps steps = plans->plan[schema - fw_sbf_schemas].group[0];
	size_t count = 0;
	for (size_t i = 0; i < n; i++) {
		if (group->count != SBF_COUNT_FIXED && !has_any(plans, steps, records[i]))
			continue;
		if (*end + group->size > FW_SBF_MAX_LENGTH)
			return FW_ENOSPACE;
		memset(block + *end, 0, group->size);
		write_values(plans, steps, records[i], block + *end);
		*end += group->size;
		count++;
	}
	if (group->size_offset > 0)
		block[group->size_offset] = (uint8_t)group->size;
	if (group->count == SBF_COUNT_FIXED)
		return count == group->count_bit ? FW_OK : FW_EINVAL;
	if (count > (group->count == SBF_COUNT_U1 ? UINT8_MAX : UINT16_MAX))
		return FW_ENOSPACE;
	or_bytes(block + group->count_offset, group->count == SBF_COUNT_U1 ? 1 : 2, count);
	return FW_OK;
}

/* The stamp on the wire; an event's own time is not that of its block. */
static void stamp_of(const fw_sbf_schema *schema, const void *record, uint32_t *tow_ms, uint16_t *week)
{
	fw_record_head head = head_of(record);
	const furrow_event *event = record;
	int64_t gps_week = head.gps_week;
	if (schema->id == EXT_EVENT && event->present & BIT(FW_COL_event_rx_tow_s)) {
		/* How many ends of weeks lie between stamp and event: -1, 0 or 1. */
		double weeks =
		    round((event->rx_tow_s + event->offset_s - event->clock_bias_s - event->tow_s) /
		          SECONDS_PER_WEEK);
		gps_week -= (weeks > 0) - (weeks < 0);
		head.tow_s = event->rx_tow_s;
		head.present |= BIT(1);
	}
	bool in_range = head.tow_s >= 0 && head.tow_s < SECONDS_PER_WEEK;
	*tow_ms = head.present & BIT(1) && in_range ? (uint32_t)llround(head.tow_s * 1000) : UINT32_MAX;
	in_range = gps_week >= 0 && gps_week < UINT16_MAX;
	*week = head.present & BIT(0) && in_range ? (uint16_t)gps_week : UINT16_MAX;
}

static bool table_suffices(const fw_sbf_schema *schema)
{
	return schema && schema->kind != FW_RECORD_COUNT && schema->id != PVT_SAT_CARTESIAN &&
	       schema->id != PVT_RESIDUALS && schema->id != EXT_SENSOR_MEAS && schema->id != COMMENT;
}

fw_status fw_sbf_build(const fw_sbf_plans *plans, uint16_t id, uint8_t revision, const void *const *records,
                       size_t n, uint8_t *block, uint16_t *length)
{
	const fw_sbf_schema *schema = fw_sbf_schema_find(id);
	if (!table_suffices(schema))
		return FW_EUNKNOWN;
	if (n == 0 || revision > 7)
		return FW_EINVAL;

	size_t end = schema->size;
	fw_status status = FW_OK;
	memset(block, 0, end);
	write_values(plans, plans->plan[schema - fw_sbf_schemas].fixed, records[0], block);
	if (schema->n_groups > 0 && schema->groups[0].count == SBF_COUNT_BIT)
		end = write_parts(plans, schema, records[0], block);
	else if (schema->n_groups > 0)
		status = write_rows(plans, schema, records, n, block, &end);
	if (status != FW_OK)
		return status;

	uint16_t padded = (uint16_t)((end + 3) / 4 * 4), week;
	uint32_t tow_ms;
	memset(block + end, 0, padded - end);
	stamp_of(schema, records[0], &tow_ms, &week);
	fw_sbf_seal(block, id, revision, padded, tow_ms, week);
	*length = padded;
	return FW_OK;
}
