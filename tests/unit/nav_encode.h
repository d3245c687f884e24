/* What the tests of the navigation decoders share: pages written bit by bit as the ICDs print them, wrapped
 * in SBF blocks, and a sink that keeps the records. Nothing here uses the decoders' own tables or checks. */
#ifndef FURROW_TESTS_NAV_ENCODE_H
#define FURROW_TESTS_NAV_ENCODE_H

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/random.h"
#include "formats/bytes.h"
#include "formats/nav.h"

/* ---- a page: one byte per bit, bit 1 of the ICD at [1] ---- */

typedef struct {
	uint8_t bit[325];
} icd_page;

static inline void write_bits(icd_page *page, int first, int width, uint32_t value)
{
	for (int i = 0; i < width; i++)
		page->bit[first + i] = (uint8_t)(value >> (width - 1 - i) & 1);
}

static inline uint32_t read_bits(const icd_page *page, int first, int width)
{
	uint32_t value = 0;
	for (int i = 0; i < width; i++)
		value = value << 1 | page->bit[first + i];
	return value;
}

/* A parameter as an ICD defines it. form: 'u' unsigned, 's' two's complement, 'm' sign and magnitude. A part
 * is page, first bit (from 1), width; most significant part first. */
typedef struct {
	const char *column;
	char form;
	double lsb;
	double to_column; /* factor from the ICD's unit to the column's; 0 stands for 1 */
	int part[3][3];
} icd_field;

static inline int field_width(const icd_field *f)
{
	return f->part[0][2] + f->part[1][2] + f->part[2][2];
}

/* Writes raw into the field's bits and returns the value it stands for. */
static inline double write_field(icd_page *pages, const icd_field *f, uint32_t raw)
{
	int left = field_width(f);
	const uint32_t top = UINT32_C(1) << (left - 1);
	double value = raw;

	if (f->form == 's' && raw & top)
		value = (double)raw - 2.0 * top;
	if (f->form == 'm')
		value = raw & top ? -(double)(raw - top) : (double)raw;
	for (int i = 0; i < 3; i++) {
		left -= f->part[i][2];
		if (f->part[i][2] > 0)
			write_bits(&pages[f->part[i][0]], f->part[i][1], f->part[i][2],
			           f->part[i][2] == 32 ? raw : raw >> left & ((1U << f->part[i][2]) - 1));
	}
	return value * f->lsb * (f->to_column != 0 ? f->to_column : 1);
}

/* A random value of the field's width; the extremes of the range come often. */
static inline uint32_t random_raw(fw_random *r, const icd_field *f)
{
	const uint32_t mask = (uint32_t)((UINT64_C(1) << field_width(f)) - 1);
	switch (fw_random_below(r, 12)) {
	case 0: return 0;
	case 1: return mask;
	case 2: return mask >> 1;
	case 3: return mask - (mask >> 1);
	default: return (uint32_t)fw_random_u64(r) & mask;
	}
}

/* ---- blocks ---- */

typedef struct {
	uint8_t bytes[64];
	size_t length;
} nav_block;

static inline nav_block make_block(uint16_t number, uint8_t svid, double tow_s, const uint32_t *words, int n)
{
	nav_block b = {.bytes = {'$', '@'}, .length = 20 + 4 * (size_t)n};
	fw_store_u16(b.bytes + 4, number);
	fw_store_u16(b.bytes + 6, (uint16_t)b.length);
	fw_store_u32(b.bytes + 8, (uint32_t)lround(tow_s * 1000));
	fw_store_u16(b.bytes + 12, 2360);
	b.bytes[14] = svid;
	b.bytes[15] = 1; /* CRCPassed */
	for (int i = 0; i < n; i++)
		fw_store_u32(b.bytes + 20 + 4 * i, words[i]);
	return b;
}

/* A block whose bits are one string, as all but GPS's are. */
static inline nav_block block_of_bits(uint16_t number, uint8_t svid, double tow_s, const icd_page *page,
                                      int n)
{
	uint32_t words[10];
	for (int i = 0; i < n; i++)
		words[i] = read_bits(page, 1 + 32 * i, 32);
	return make_block(number, svid, tow_s, words, n);
}

/* GPS: the parity of IS-GPS-200 table 20-XIV as that table prints it, and the storage of GPSRawCA. */
static inline nav_block gps_block(uint16_t number, uint8_t svid, double tow_s, const icd_page *page)
{
	static const uint8_t terms[6][16] = {
	    {1, 2, 3, 5, 6, 10, 11, 12, 13, 14, 17, 18, 20, 23},
	    {2, 3, 4, 6, 7, 11, 12, 13, 14, 15, 18, 19, 21, 24},
	    {1, 3, 4, 5, 7, 8, 12, 13, 14, 15, 16, 19, 20, 22},
	    {2, 4, 5, 6, 8, 9, 13, 14, 15, 16, 17, 20, 21, 23},
	    {1, 3, 5, 6, 7, 9, 10, 14, 15, 16, 17, 18, 21, 22, 24},
	    {3, 5, 6, 8, 9, 10, 11, 13, 15, 19, 22, 23, 24},
	};
	uint32_t words[10];
	unsigned d29 = 0, d30 = 0;

	for (int w = 0; w < 10; w++) {
		uint8_t d[31] = {0};
		for (int i = 1; i <= 24; i++)
			d[i] = page->bit[30 * w + i];
		for (int spare = 0; spare < 4;
		     spare++) { /* words 2 and 10: bits 23, 24 make D29 and D30 zero */
			if (w == 1 || w == 9) {
				d[23] = (uint8_t)(spare >> 1);
				d[24] = (uint8_t)(spare & 1);
			}
			for (int p = 0; p < 6; p++) {
				d[25 + p] = p == 0 || p == 2 || p == 5 ? (uint8_t)d29 : (uint8_t)d30;
				for (int t = 0; t < 16 && terms[p][t] > 0; t++)
					d[25 + p] ^= d[terms[p][t]];
			}
			if ((w != 1 && w != 9) || (d[29] == 0 && d[30] == 0))
				break;
		}
		uint32_t data = 0, parity = 0;
		for (int i = 1; i <= 24; i++)
			data = data << 1 | d[i];
		for (int i = 25; i <= 30; i++)
			parity = parity << 1 | d[i];
		/* sent: data bits xor D30*, then parity; stored: all of that inverted if D30* */
		words[w] = data << 6 | (d30 ? parity ^ 0x3f : parity);
		d29 = d[29];
		d30 = d[30];
	}
	return make_block(number, svid, tow_s, words, 10);
}

static inline uint32_t crc24q(const icd_page *page, int n)
{
	uint32_t crc = 0;
	for (int i = 1; i <= n; i++) {
		const uint32_t out = (crc >> 23 ^ page->bit[i]) & 1;
		crc = (crc << 1 & 0xffffff) ^ (out ? 0x864cfb : 0);
	}
	return crc;
}

/* Galileo I/NAV: a word of 128 bits into two halves (OS SIS ICD 4.3.2.3). */
static inline nav_block inav_block(uint8_t svid, double tow_s, const icd_page *word)
{
	icd_page page = {{0}};
	memcpy(page.bit + 3, word->bit + 1, 112);
	write_bits(&page, 115, 2, 2); /* odd, nominal */
	memcpy(page.bit + 117, word->bit + 113, 16);
	write_bits(&page, 197, 24, crc24q(&page, 196));
	return block_of_bits(4023, svid, tow_s, &page, 8);
}

static inline nav_block fnav_block(uint8_t svid, double tow_s, const icd_page *page)
{
	icd_page whole = *page;
	write_bits(&whole, 215, 24, crc24q(&whole, 214));
	return block_of_bits(4022, svid, tow_s, &whole, 8);
}

/* BeiDou: a subframe with the BCH(15,11) parity of its words filled in: the remainder of the information,
 * shifted by four, divided by x^4 + x + 1 (ICD 5.1.3, figure 5-2). */
static inline uint32_t bch_parity(uint32_t information)
{
	uint32_t word = information << 4;
	for (int i = 14; i >= 4; i--)
		if (word >> i & 1)
			word ^= 0x13U << (i - 4);
	return word;
}

static inline nav_block bds_block(uint8_t svid, double tow_s, const icd_page *page, uint32_t subframe)
{
	icd_page whole = *page;
	write_bits(&whole, 1, 11, 0x712);
	write_bits(&whole, 16, 3, subframe);
	write_bits(&whole, 19, 8, (uint32_t)tow_s >> 12);
	write_bits(&whole, 31, 12, (uint32_t)tow_s & 0xfff);
	write_bits(&whole, 27, 4, bch_parity(read_bits(&whole, 16, 11)));
	for (int w = 31; w <= 271; w += 30) {
		write_bits(&whole, w + 22, 4, bch_parity(read_bits(&whole, w, 11)));
		write_bits(&whole, w + 26, 4, bch_parity(read_bits(&whole, w + 11, 11)));
	}
	return block_of_bits(4047, svid, tow_s, &whole, 10);
}

/* GLONASS: page bit 1 is the ICD's bit 85. Hamming code by its definition in the ICD, 4.7: data bits take, in
 * their order, the positions 3, 5, 6, 7, 9, ... that are no power of two; check i covers the positions whose
 * binary number has bit i; the eighth covers everything. */
static inline nav_block glo_block(uint8_t svid, uint8_t channel, double tow_s, const icd_page *page)
{
	icd_page whole = *page;
	unsigned checks = 0, all = 0, position = 3;

	for (int icd_bit = 9; icd_bit <= 85; icd_bit++, position++) {
		if ((position & (position - 1)) == 0)
			position++;
		if (whole.bit[86 - icd_bit]) {
			checks ^= position;
			all ^= 1;
		}
	}
	for (int i = 0; i < 7; i++)
		whole.bit[86 - (1 + i)] = checks >> i & 1;
	whole.bit[86 - 8] = (uint8_t)((unsigned)(__builtin_popcount(checks) & 1) ^ all);
	nav_block b = block_of_bits(4026, svid, tow_s, &whole, 3);
	b.bytes[18] = channel;
	return b;
}

/* ---- the sink ---- */

typedef struct {
	fw_kind kind;
	fw_any_record record;
	char sat[8], source[8];
} kept_record;

typedef struct {
	int n;
	kept_record list[256];
} kept_records;

static inline void keep(void *context, fw_kind kind, const void *record)
{
	kept_records *kept = context;
	const fw_record_type *type = fw_record_type_of(kind);
	if (kept->n == 256)
		return;
	kept_record *k = &kept->list[kept->n++];
	k->kind = kind;
	memcpy(&k->record, record, type->size);
	const char *const *sat = (const void *)(k->record.bytes + type->columns[2].offset);
	const char *const *source = (const void *)(k->record.bytes + type->columns[3].offset);
	strncpy(k->sat, *sat, 7);
	strncpy(k->source, *source, 7);
}

/* The value of a column; NaN when it is absent. */
static inline double value_of(const kept_record *k, const char *name)
{
	const fw_record_type *type = fw_record_type_of(k->kind);
	const int i = fw_record_column(type, name, strlen(name));
	const char *member = k->record.bytes + (i < 0 ? 0 : type->columns[i].offset);

	if (i < 0 || !(k->record.head.present >> i & 1))
		return (double)NAN;
	switch (type->columns[i].type) {
	case FW_I8: return *(const int8_t *)member;
	case FW_I16: return *(const int16_t *)(const void *)member;
	case FW_I32: return *(const int32_t *)(const void *)member;
	case FW_F32: return (double)*(const float *)(const void *)member;
	case FW_F64: return *(const double *)(const void *)member;
	default: return (double)NAN;
	}
}

/* Is a column, a float or a double, equal to what was sent? Absent (NaN) equals absent. */
static inline bool column_is(const kept_record *k, const char *name, double expected)
{
	const fw_record_type *type = fw_record_type_of(k->kind);
	const int i = fw_record_column(type, name, strlen(name));
	const double got = value_of(k, name);

	if (isnan(expected))
		return isnan(got);
	if (i >= 0 && type->columns[i].type == FW_F32)
		expected = (double)(float)expected;
	if (got != expected)
		print_message("%s of %s: %.17g, not %.17g\n", name, k->sat, got, expected);
	return got == expected;
}

static inline const kept_record *last_of(const kept_records *kept, fw_kind kind)
{
	for (int i = kept->n - 1; i >= 0; i--)
		if (kept->list[i].kind == kind)
			return &kept->list[i];
	return NULL;
}

static inline int count_of(const kept_records *kept, fw_kind kind)
{
	int n = 0;
	for (int i = 0; i < kept->n; i++)
		n += kept->list[i].kind == kind;
	return n;
}

static inline fw_status give(fw_nav *nav, const nav_block *block, kept_records *kept)
{
	const fw_sink sink = {keep, kept};
	return fw_nav_block(nav, block->bytes, block->length, &sink);
}

#endif
