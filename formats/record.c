#include "formats/record.h"

#include <assert.h>
#include <endian.h>
#include <lcm/lcm_coretypes.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "formats/number.h"

/* What lcm-gen says about each type; these lines stand for as many includes. */
#define X(name) const lcm_type_info_t *furrow_##name##_get_type_info(void);
FW_RECORD_TYPES(X)
#undef X

typedef const lcm_type_info_t *get_info(void);

static get_info *const infos[FW_RECORD_COUNT] = {
#define X(name) furrow_##name##_get_type_info,
    FW_RECORD_TYPES(X)
#undef X
};

static const struct {
	const char *text;
	size_t n;
} names[FW_RECORD_COUNT] = {
#define X(name) {#name, sizeof #name - 1},
    FW_RECORD_TYPES(X)
#undef X
};

/* ---- The table of types ------------------------------------------------------------------------------- */

/* The form of a double column by its name; the first line that fits counts, and no line means SHORTEST. Fixed
 * decimals are for quantities with a natural resolution. What a satellite sent, or a receiver computed from
 * it, has to come back exactly: SHORTEST. */
static const struct {
	const char *type;  /* how the type's name begins */
	const char *start; /* how the column's name begins */
	const char *end;   /* how it ends */
	fw_column_text text;
	int decimals;
} forms[] = {
    {"", "", "tow_s", FW_TEXT_TRIMMED, 9},
    {"eph_", "", "", FW_TEXT_SHORTEST, 0},
    {"sbas", "", "", FW_TEXT_SHORTEST, 0},
    {"satpos", "", "", FW_TEXT_SHORTEST, 0},
    {"obs_extra", "", "_cyc", FW_TEXT_TRIMMED, 9},  /* steps of 1/512 */
    {"obs_extra", "", "_dbhz", FW_TEXT_TRIMMED, 5}, /* steps of 1/32 */
    {"obs_extra", "", "_m2", FW_TEXT_FIXED, 4},     /* steps of 0.0001 */
    {"obs_extra", "", "_cyc2", FW_TEXT_FIXED, 6},   /* steps of 0.000001 */
    {"obs_extra", "", "_hz2", FW_TEXT_FIXED, 6},    /* some hundred times as much */
    {"", "", "_deg", FW_TEXT_FIXED, 9},
    {"", "", "_m", FW_TEXT_FIXED, 4},
    {"aux_ant", "", "_mps", FW_TEXT_SHORTEST, 0},
    {"", "", "_mps", FW_TEXT_FIXED, 4},
    {"", "", "_mps2", FW_TEXT_FIXED, 9},
    {"", "gyro_", "_radps", FW_TEXT_FIXED, 9},
    {"", "", "_cyc", FW_TEXT_FIXED, 3},
    {"", "", "_hz", FW_TEXT_FIXED, 4},
    {"", "", "_dbhz", FW_TEXT_FIXED, 2},
    {"", "", "_ut", FW_TEXT_FIXED, 3},
};

static bool starts(const char *text, const char *with)
{
	return strncmp(text, with, strlen(with)) == 0;
}

static bool ends(const char *text, const char *with)
{
	const size_t n = strlen(text), m = strlen(with);
	return n >= m && memcmp(text + n - m, with, m) == 0;
}

static void choose_form(const char *type, fw_column *c)
{
	c->decimals = 0;
	if (c->type != FW_F32 && c->type != FW_F64) {
		c->text = FW_TEXT_PLAIN;
		return;
	}
	c->text = FW_TEXT_SHORTEST;
	for (size_t i = 0; c->type == FW_F64 && i < sizeof forms / sizeof *forms; i++) {
		if (starts(type, forms[i].type) && starts(c->name, forms[i].start) &&
		    ends(c->name, forms[i].end)) {
			c->text = forms[i].text;
			c->decimals = forms[i].decimals;
			return;
		}
	}
}

static fw_column_type column_type(lcm_field_type_t type)
{
	switch (type) {
	case LCM_FIELD_INT8_T: return FW_I8;
	case LCM_FIELD_INT16_T: return FW_I16;
	case LCM_FIELD_INT32_T: return FW_I32;
	case LCM_FIELD_INT64_T: return FW_I64;
	case LCM_FIELD_FLOAT: return FW_F32;
	case LCM_FIELD_DOUBLE: return FW_F64;
	default: assert(type == LCM_FIELD_STRING); return FW_STR;
	}
}

static void build_type(fw_kind kind, fw_record_type *type, char *channel)
{
	static const fw_any_record record; /* lcm-gen tells where a field lies by pointing into a struct */
	const lcm_type_info_t *info = infos[kind]();

	memcpy(channel, "FURROW_", 7);
	for (size_t i = 0; i < names[kind].n; i++) {
		const char c = names[kind].text[i];
		channel[7 + i] = (char)(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
	}
	type->name = names[kind].text;
	type->channel = channel;
	type->size = (uint16_t)info->struct_size();
	type->n_columns = (uint16_t)(info->num_fields() - 1); /* the first field is the mask */
	type->hash = info->get_hash();
	assert(type->size <= sizeof record && type->n_columns <= FW_MAX_COLUMNS);
	for (int i = 0; i < type->n_columns; i++) {
		fw_column *c = &type->columns[i];
		lcm_field_t field;
		info->get_field(&record, i + 1, &field);
		c->name = field.name;
		c->type = column_type(field.type);
		c->offset = (uint16_t)((const char *)field.data - record.bytes);
		choose_form(type->name, c);
	}
	assert(type->columns[0].offset == offsetof(fw_record_head, gps_week));
	assert(type->columns[1].offset == offsetof(fw_record_head, tow_s));
}

const fw_record_type *fw_record_type_of(fw_kind kind)
{
	static fw_record_type types[FW_RECORD_COUNT];
	static char channels[FW_RECORD_COUNT][32];
	static bool built;

	if (!built) {
		for (fw_kind k = 0; k < FW_RECORD_COUNT; k++)
			build_type(k, &types[k], channels[k]);
		built = true;
	}
	return &types[kind];
}

fw_kind fw_record_find(const char *name, size_t n)
{
	for (fw_kind kind = 0; kind < FW_RECORD_COUNT; kind++)
		if (names[kind].n == n && memcmp(names[kind].text, name, n) == 0)
			return kind;
	return FW_RECORD_COUNT;
}

int fw_record_column(const fw_record_type *type, const char *name, size_t n)
{
	for (int i = 0; i < type->n_columns; i++)
		if (strncmp(type->columns[i].name, name, n) == 0 && strlen(type->columns[i].name) == n)
			return i;
	return -1;
}

/* ---- Records ------------------------------------------------------------------------------------------ */

static const size_t sizes[] = {
    [FW_I8] = 1,
    [FW_I16] = 2,
    [FW_I32] = 4,
    [FW_I64] = 8,
    [FW_F32] = 4,
    [FW_F64] = 8,
    [FW_STR] = sizeof(char *),
};

static void set_string(const fw_column *c, void *record, const char *text)
{
	memcpy((char *)record + c->offset, &text, sizeof text);
}

/* Column i gets no value: its bit is cleared, and it holds 0 or "". */
static void set_absent(const fw_record_type *type, int i, fw_any_record *record)
{
	const fw_column *c = &type->columns[i];

	record->head.present &= (int64_t) ~(UINT64_C(1) << i);
	if (c->type == FW_STR)
		set_string(c, record, "");
	else
		memset(record->bytes + c->offset, 0, sizes[c->type]);
}

void fw_record_clear(fw_kind kind, void *record)
{
	const fw_record_type *type = fw_record_type_of(kind);

	memset(record, 0, type->size);
	for (int i = 2; i < type->n_columns; i++)
		if (type->columns[i].type == FW_STR)
			set_string(&type->columns[i], record, "");
}

/* x as its column's text says it, found by writing and reading that text. */
static double round_double(const fw_column *c, double x)
{
	char text[FW_FIXED_ROOM];
	const char *end;

	if (c->text == FW_TEXT_SHORTEST)
		return x + 0.0;                   /* exact already, but for the sign of -0 */
	end = fw_put_fixed(text, x, c->decimals); /* trimming does not change the value */
	const fw_status status = fw_get_double(text, (size_t)(end - text), &x);
	assert(status == FW_OK);
	(void)status;
	return x;
}

/* Whether column c holds something that its text can show. */
static bool showable(const fw_column *c, const fw_any_record *record)
{
	const char *member = record->bytes + c->offset;
	const char *text;
	double d;
	float f;

	switch (c->type) {
	case FW_F32: memcpy(&f, member, sizeof f); return isfinite(f);
	case FW_F64: memcpy(&d, member, sizeof d); return isfinite(d);
	case FW_STR: memcpy(&text, member, sizeof text); return text && *text;
	default: return true;
	}
}

static void round_column(const fw_column *c, char *member)
{
	double d;
	float f;

	if (c->type == FW_F64) {
		memcpy(&d, member, sizeof d);
		d = round_double(c, d);
		memcpy(member, &d, sizeof d);
	} else if (c->type == FW_F32) {
		memcpy(&f, member, sizeof f);
		f += 0.0F;
		memcpy(member, &f, sizeof f);
	}
}

/* The bits that a type's mask may have. */
static int64_t all_columns(const fw_record_type *type)
{
	return (int64_t)((UINT64_C(1) << type->n_columns) - 1);
}

void fw_record_round(fw_kind kind, void *record)
{
	const fw_record_type *type = fw_record_type_of(kind);
	fw_any_record *any = record;

	any->head.present &= all_columns(type);
	for (int i = 0; i < type->n_columns; i++) {
		if ((any->head.present >> i & 1) && showable(&type->columns[i], any))
			round_column(&type->columns[i], any->bytes + type->columns[i].offset);
		else
			set_absent(type, i, any);
	}
}

fw_status fw_record_time(const void *record, fw_time *t)
{
	const fw_record_head *head = record;

	if ((head->present & 3) != 3)
		return FW_EINVAL;
	return fw_time_from_gps_s(head->gps_week, head->tow_s, t);
}

bool fw_record_end(const char *value, uint64_t *skipped)
{
	const char *word = strstr(value, " skipped=");
	int64_t n;

	if (word != NULL) {
		word += strlen(" skipped=");
		if (fw_get_i64(word, strcspn(word, " "), &n) == FW_OK && n > 0)
			*skipped += (uint64_t)n;
	}
	return strncmp(value, "status=complete", 15) != 0;
}

/* ---- LCM ---------------------------------------------------------------------------------------------- */

fw_status fw_record_encode(fw_kind kind, const void *record, void *buffer, size_t size, size_t *used)
{
	const fw_record_type *type = fw_record_type_of(kind);
	const lcm_type_info_t *info = infos[kind]();
	fw_any_record copy;
	const char *text;

	memcpy(&copy, record, type->size);
	for (int i = 2; i < type->n_columns; i++) {
		if (type->columns[i].type != FW_STR)
			continue;
		memcpy(&text, copy.bytes + type->columns[i].offset, sizeof text);
		if (!text)
			set_string(&type->columns[i], &copy, "");
	}
	const int n = info->encoded_size(&copy);
	if (n < 0 || (size_t)n > size || info->encode(buffer, 0, n, &copy) != n)
		return FW_ENOSPACE;
	*used = (size_t)n;
	return FW_OK;
}

/* Bytes that are being decoded. */
typedef struct {
	const char *p;
	size_t left;
} cursor;

/* Takes a big-endian number of 1, 2, 4 or 8 bytes to the same number in this machine's order. */
static bool take_number(cursor *c, size_t size, char *to)
{
	uint16_t u2;
	uint32_t u4;
	uint64_t u8;

	if (size > c->left)
		return false;
	switch (size) {
	case 1: *to = *c->p; break;
	case 2: memcpy(&u2, c->p, 2), u2 = be16toh(u2), memcpy(to, &u2, 2); break;
	case 4: memcpy(&u4, c->p, 4), u4 = be32toh(u4), memcpy(to, &u4, 4); break;
	case 8: memcpy(&u8, c->p, 8), u8 = be64toh(u8), memcpy(to, &u8, 8); break;
	}
	c->p += size;
	c->left -= size;
	return true;
}

/* A string is its length as int32, NUL included, and its bytes. */
static bool take_string(cursor *c, const char **text)
{
	uint32_t n;

	if (!take_number(c, 4, (char *)&n) || n < 1 || n > c->left || c->p[n - 1] != '\0')
		return false;
	*text = c->p;
	c->p += n;
	c->left -= n;
	return true;
}

static bool take_column(cursor *from, const fw_column *c, fw_any_record *record)
{
	const char *text;

	if (c->type != FW_STR)
		return take_number(from, sizes[c->type], record->bytes + c->offset);
	if (!take_string(from, &text))
		return false;
	set_string(c, record, text);
	return true;
}

fw_status fw_record_decode(fw_kind kind, const void *data, size_t n, void *record)
{
	const fw_record_type *type = fw_record_type_of(kind);
	fw_any_record *any = record;
	cursor from = {data, n};
	int64_t hash;

	memset(record, 0, type->size);
	if (!take_number(&from, 8, (char *)&hash) || hash != type->hash ||
	    !take_number(&from, 8, (char *)&any->head.present))
		return FW_EFORMAT;
	any->head.present &= all_columns(type);
	for (int i = 0; i < type->n_columns; i++) {
		if (!take_column(&from, &type->columns[i], any))
			return FW_EFORMAT;
		if (!(any->head.present >> i & 1) || !showable(&type->columns[i], any))
			set_absent(type, i, any);
	}
	return from.left == 0 ? FW_OK : FW_EFORMAT;
}
