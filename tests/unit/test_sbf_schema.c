/* The table of SBF blocks against itself and against the record types: what every walk through it relies on. The
 * layouts themselves are proved elsewhere, by real blocks and by an independent decoder. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "formats/record.h"
#include "formats/sbf_codec.h"
#include "formats/sbf_schema.h"

#define ASSERT(condition, schema, field)                                                                     \
	do {                                                                                                 \
		if (!(condition))                                                                            \
			fail_msg("%s, %s: not %s", (schema)->name, (field), #condition);                     \
	} while (0)

typedef void field_fn(const fw_sbf_schema *schema, const fw_sbf_field *fields, unsigned n, void *context);

static void each_group(const fw_sbf_schema *schema, const fw_sbf_group *group, field_fn *call, void *context)
{
	call(schema, group->fields, group->n_fields, context);
	if (group->nested)
		each_group(schema, group->nested, call, context);
}

/* Calls for the fixed part and for each group, nested ones too. */
static void each_list(const fw_sbf_schema *schema, field_fn *call, void *context)
{
	call(schema, schema->fields, schema->n_fields, context);
	for (unsigned g = 0; g < schema->n_groups; g++)
		each_group(schema, &schema->groups[g], call, context);
}

static void each_schema(field_fn *call)
{
	for (int i = 0; i < fw_sbf_n_schemas; i++)
		each_list(&fw_sbf_schemas[i], call, NULL);
}

static void blocks_ascend_and_are_found(void **state)
{
	(void)state;
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		const fw_sbf_schema *s = &fw_sbf_schemas[i];
		assert_true(i == 0 || s[-1].id < s->id);
		assert_in_range(s->id, 4000, 8191);
		assert_in_range(s->revision, 0, 7);
		assert_ptr_equal(fw_sbf_schema_find(s->id), s);
		assert_string_equal(fw_sbf_block_name(s->id), s->name);
	}
	assert_null(fw_sbf_schema_find(0));
	assert_null(fw_sbf_schema_find(4003));
	assert_null(fw_sbf_schema_find(8191));
	assert_string_equal(fw_sbf_block_name(4013), "ChannelStatus");
	assert_string_equal(fw_sbf_block_name(4109), "Meas3Ranges");
	assert_string_equal(fw_sbf_block_name(5949), "BaseStation");
	assert_string_equal(fw_sbf_block_name(1), "");
}

/* Every byte from `start` to `end` belongs to one field. */
static void check_no_gap(const fw_sbf_schema *schema, const fw_sbf_field *fields, unsigned n, size_t start,
                         size_t end)
{
	for (unsigned i = 0; i < n; i++) {
		if (fields[i].width > 0)
			continue;
		ASSERT(fields[i].offset == start, schema, fields[i].name);
		ASSERT(fields[i].count > 0, schema, fields[i].name);
		start += fw_sbf_type_size(fields[i].type) * fields[i].count;
	}
	ASSERT(start == end, schema, "end of the fields");
}

static void check_group(const fw_sbf_schema *schema, const fw_sbf_group *group)
{
	check_no_gap(schema, group->fields, group->n_fields, 0, group->size);
	ASSERT(group->size_offset < schema->size, schema, group->name);
	if (group->nested)
		check_group(schema, group->nested);
}

static void fields_have_no_gaps(void **state)
{
	(void)state;
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		const fw_sbf_schema *s = &fw_sbf_schemas[i];
		check_no_gap(s, s->fields, s->n_fields, FW_SBF_BODY, s->size);
		for (unsigned g = 0; g < s->n_groups; g++) {
			ASSERT(s->groups[g].start == (g == 0 ? s->size : 0), s, s->groups[g].name);
			ASSERT(s->groups[g].count_offset < s->size, s, s->groups[g].name);
			check_group(s, &s->groups[g]);
		}
	}
}

static bool on_the_wire(const fw_sbf_field *f, const fw_sbf_field *fields, unsigned n)
{
	for (unsigned i = 0; i < n; i++)
		if (fields[i].width == 0 && fields[i].offset == f->offset && fields[i].type == f->type)
			return true;
	return false;
}

static void check_views(const fw_sbf_schema *schema, const fw_sbf_field *fields, unsigned n, void *context)
{
	(void)context;
	for (unsigned i = 0; i < n; i++) {
		const fw_sbf_field *f = &fields[i];
		if (f->width == 0)
			continue;
		ASSERT(f->column != NULL, schema, f->name);
		ASSERT(f->dnu == SBF_ALWAYS, schema, f->name);
		if (f->convert == SBF_INDEX || f->convert == SBF_CONSTANT)
			continue;
		ASSERT(on_the_wire(f, fields, n), schema, f->name);
		ASSERT(f->shift + f->width <= 8 * fw_sbf_type_size(f->type) * f->count, schema, f->name);
		if (f->convert != SBF_ROOT && f->convert != SBF_HEX)
			ASSERT(f->type == SBF_U1 || f->type == SBF_U2 || f->type == SBF_U4, schema, f->name);
	}
}

static void views_lie_on_fields(void **state)
{
	(void)state;
	each_schema(check_views);
}

static void check_type(const fw_sbf_schema *schema, const fw_sbf_field *f, const fw_column *column)
{
	bool is_float = column->type == FW_F32 || column->type == FW_F64;
	bool is_string = column->type == FW_STR;
	switch (f->convert) {
	case SBF_CHANNEL: ASSERT(f->type == SBF_U1 && f->offset > 0, schema, f->name); break;
	case SBF_NUMBER:
		ASSERT(!is_string, schema, f->name);
		ASSERT(f->count == 1 || f->width > 0, schema, f->name);
		if (f->type == SBF_F4 || f->type == SBF_F8 || f->mul > 0 || f->mul < 0 || f->div > 0)
			ASSERT(is_float, schema, f->name);
		ASSERT(f->div >= 0 && isfinite(f->mul), schema, f->name);
		break;
	case SBF_ROOT: ASSERT(is_float && f->type == SBF_F4, schema, f->name); break;
	case SBF_INDEX: ASSERT(!is_string && !is_float, schema, f->name); break;
	case SBF_SATELLITE:
	case SBF_SIGNAL: ASSERT(is_string && f->type == SBF_U1, schema, f->name); break;
	case SBF_TEXT: ASSERT(is_string && f->type == SBF_C1, schema, f->name); break;
	case SBF_HEX: ASSERT(is_string && f->type == SBF_U4, schema, f->name); break;
	case SBF_CONSTANT: ASSERT(is_string && f->name[0], schema, f->name); break;
	default: fail();
	}
}

/* Columns that sbf_records.c fills by code, since no single field holds them. */
static const struct {
	fw_kind kind;
	const char *name;
} by_code[] = {
    {FW_event, "rx_tow_s"},    {FW_satpos, "iono_m"}, {FW_satpos, "tropo_m"},
    {FW_residual, "quantity"}, {FW_residual, "mdb"},  {FW_comment, "text"},
};

typedef struct {
	int64_t block;                   /* columns that the block at hand fills */
	int64_t filled[FW_RECORD_COUNT]; /* columns that any block fills */
} columns;

static void check_columns(const fw_sbf_schema *schema, const fw_sbf_field *fields, unsigned n, void *context)
{
	columns *c = context;
	for (unsigned i = 0; i < n; i++) {
		const fw_sbf_field *f = &fields[i];
		ASSERT(f->name && f->name[0], schema, "name");
		if (!f->column)
			continue;
		ASSERT(schema->kind != FW_RECORD_COUNT, schema, f->name);
		const fw_record_type *type = fw_record_type_of(schema->kind);
		int index = fw_record_column(type, f->column, strlen(f->column));
		ASSERT(index >= 2, schema, f->column);
		ASSERT(!(c->block >> index & 1), schema, f->column);
		c->block |= INT64_C(1) << index;
		check_type(schema, f, &type->columns[index]);
	}
}

static void each_column_exists_and_is_filled_once(void **state)
{
	(void)state;
	static columns c;
	for (int i = 0; i < fw_sbf_n_schemas; i++) {
		c.block = 0;
		each_list(&fw_sbf_schemas[i], check_columns, &c);
		if (fw_sbf_schemas[i].kind != FW_RECORD_COUNT)
			c.filled[fw_sbf_schemas[i].kind] |= c.block;
	}
	for (size_t i = 0; i < sizeof by_code / sizeof by_code[0]; i++) {
		const fw_record_type *type = fw_record_type_of(by_code[i].kind);
		int index = fw_record_column(type, by_code[i].name, strlen(by_code[i].name));
		assert_in_range(index, 2, FW_MAX_COLUMNS);
		assert_false(c.filled[by_code[i].kind] >> index & 1);
		c.filled[by_code[i].kind] |= INT64_C(1) << index;
	}

	/* What no block fills: ext_sensor and event_att are special, the rest was forgotten. */
	for (int kind = 0; kind < FW_RECORD_COUNT; kind++) {
		if (c.filled[kind] == 0 || kind == FW_ext_sensor || kind == FW_event_att ||
		    kind == FW_event_pvt || kind == FW_event_pvt_ecef)
			continue;
		const fw_record_type *type = fw_record_type_of((fw_kind)kind);
		for (int column = 2; column < type->n_columns; column++)
			if (!(c.filled[kind] >> column & 1))
				fail_msg("nothing fills %s.%s", type->name, type->columns[column].name);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(blocks_ascend_and_are_found),
	    cmocka_unit_test(fields_have_no_gaps),
	    cmocka_unit_test(views_lie_on_fields),
	    cmocka_unit_test(each_column_exists_and_is_filled_once),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
