/* Real logs for the tests of the navigation decoders: SBF blocks, the fields of the receiver's own decoded
 * blocks, and u-blox subframes with the RINEX navigation file that RTKLIB (demo5) made of them. */
#ifndef FURROW_TESTS_NAV_LOGS_H
#define FURROW_TESTS_NAV_LOGS_H

#include <stdio.h>
#include <stdlib.h>

#include "formats/crc.h"
#include "formats/sbf_signal.h"
#include "nav_encode.h"

/* Reads a file below the folder of real data; NULL, after a message, when it is not there. The caller frees
 * it. */
static inline uint8_t *load_log(const char *name, size_t *n)
{
	const char *folder = getenv("FURROW_DATA");
	char path[1024];
	uint8_t *bytes = NULL;

	if (!folder)
		folder = "../shared/data";
	snprintf(path, sizeof path, "%s/%s", folder, name);
	FILE *file = fopen(path, "rb");
	if (!file) {
		print_message("%s: not there, skipped\n", path);
		return NULL;
	}
	bytes = malloc(1 << 22);
	assert_non_null(bytes);
	*n = fread(bytes, 1, (1 << 22) - 1, file);
	bytes[*n] = '\0';
	fclose(file);
	return bytes;
}

/* The next block of an SBF file from *at on, or NULL at its end. */
static inline const uint8_t *next_block(const uint8_t *log, size_t n, size_t *at, size_t *length)
{
	for (; *at + 8 <= n; ++*at) {
		const uint8_t *b = log + *at;
		*length = fw_load_u16(b + 6);
		if (b[0] != '$' || b[1] != '@' || *length < 8 || *length > n - *at ||
		    fw_crc16(b + 4, *length - 4) != fw_load_u16(b + 2))
			continue;
		*at += *length;
		return b;
	}
	return NULL;
}

/* Every block of a log through a decoder. */
static inline void decode_log(fw_nav *nav, const uint8_t *log, size_t n, kept_records *kept)
{
	const fw_sink sink = {keep, kept};
	const uint8_t *b;

	for (size_t at = 0, length; (b = next_block(log, n, &at, &length)) != NULL;)
		if (fw_nav_block(nav, b, length, &sink) == FW_OK)
			assert_true(fw_nav_reads(fw_load_u16(b + 4) & 0x1fff));
}

/* A field of a decoded block. type: b u1, c i1, h u2, i u4, f f4, d f8. The column is the field times factor
 * (0: 1); `unknown` set: that raw value, and -2e10, mean absent. */
typedef struct {
	const char *column;
	char type;
	int offset;
	double factor;
	int unknown;
} block_field;

static inline double block_value(const uint8_t *block, const block_field *f)
{
	const uint8_t *p = block + f->offset;
	double value = (double)NAN;

	switch (f->type) {
	case 'b': value = *p; break;
	case 'c': value = (int8_t)*p; break;
	case 'h': value = fw_load_u16(p); break;
	case 'i': value = fw_load_u32(p); break;
	case 'f': value = (double)fw_load_f32(p); break;
	default: value = fw_load_f64(p); break;
	}
	if (value < -1.9e10 || (f->unknown != 0 && value == f->unknown))
		return (double)NAN;
	return f->factor != 0 ? value * f->factor : value;
}

/* Compares all records of a kind with the decoded blocks of the same satellite (SVID at offset 14; with
 * `message`: Source at 15). Returns the number of pairs, all equal field by field. */
static inline int compare_with_blocks(const kept_records *kept, fw_kind kind, uint16_t number, bool message,
                                      const block_field *fields, int n_fields, const uint8_t *log, size_t n)
{
	const uint8_t *b;
	int pairs = 0;

	for (size_t at = 0, length; (b = next_block(log, n, &at, &length)) != NULL;) {
		if ((fw_load_u16(b + 4) & 0x1fff) != number)
			continue;
		for (int i = 0; i < kept->n; i++) {
			const kept_record *k = &kept->list[i];
			if (k->kind != kind || strcmp(k->sat, fw_sbf_satellite(b[14])) != 0 ||
			    (message && value_of(k, "message") != b[15]))
				continue;
			pairs++;
			for (int f = 0; f < n_fields; f++)
				assert_true(column_is(k, fields[f].column, block_value(b, &fields[f])));
		}
	}
	return pairs;
}

/* The raw bits that a field's value in a decoded block was made of. */
static inline uint32_t raw_of(const icd_field *f, double value)
{
	const double number = value / f->lsb / (f->to_column != 0 ? f->to_column : 1);
	const uint32_t mask = (uint32_t)((UINT64_C(1) << field_width(f)) - 1);

	if (f->form == 'm')
		return (uint32_t)llround(fabs(number)) | (signbit(number) ? mask - (mask >> 1) : 0);
	return (uint32_t)llround(number) & mask;
}

/* ---- u-blox RXM-SFRBX ---- */

typedef struct {
	int system, sat, signal, n_words; /* system 0 GPS, 2 Galileo, 3 BeiDou */
	uint32_t words[16];
	double tow_s; /* of the epoch of measurements before it */
} ubx_subframe;

/* The next subframe of a UBX file, checksum right; false at its end. */
static inline bool next_subframe(const uint8_t *log, size_t n, size_t *at, ubx_subframe *s)
{
	for (; *at + 8 <= n; ++*at) {
		const uint8_t *b = log + *at;
		const size_t length = fw_load_u16(b + 4);
		uint8_t sum1 = 0, sum2 = 0;
		if (b[0] != 0xb5 || b[1] != 0x62 || b[2] != 2 || length + 8 > n - *at)
			continue;
		for (size_t i = 2; i < 6 + length; i++) {
			sum1 = (uint8_t)(sum1 + b[i]);
			sum2 = (uint8_t)(sum2 + sum1);
		}
		if (b[6 + length] != sum1 || b[7 + length] != sum2)
			continue;
		if (b[3] == 0x15) { /* RXM-RAWX */
			uint64_t bits = fw_load_u64(b + 6);
			memcpy(&s->tow_s, &bits, 8);
		}
		if (b[3] != 0x13 || b[10] > 16)
			continue;
		*at += length + 8;
		s->system = b[6];
		s->sat = b[7];
		s->signal = b[8];
		s->n_words = b[10];
		for (int i = 0; i < s->n_words; i++)
			s->words[i] = fw_load_u32(b + 14 + 4 * i);
		return true;
	}
	return false;
}

/* Compares all records of a kind with the RINEX 3 navigation file: for each record of that letter, the
 * numbers of its epoch line and of seven lines of four are named by `columns` (NULL: not compared). An
 * ephemeris of the file and a record belong together when satellite and key column agree. Twelve digits are
 * in the file; columns of type float hold the float nearest to its number. Returns the number of pairs. */
static inline int compare_with_rinex(const kept_records *kept, fw_kind kind, const char *const columns[31],
                                     const char *key, int key_at, int source_at, const char *rinex)
{
	int pairs = 0;

	for (const char *line = strstr(rinex, "END OF HEADER"); line; line = strchr(line, '\n')) {
		double numbers[31] = {0};
		line += strcspn(line, "\n") + 1;
		const char *p = line;
		for (int i = 0; i < 31 && *p; i++) {
			char text[20] = "";
			const int column = i < 3 ? 23 + 19 * i : 4 + 19 * ((i - 3) % 4);
			if (i == 3 || (i > 3 && (i - 3) % 4 == 0))
				p += strcspn(p, "\n") + 1;
			if (strcspn(p, "\n") < (size_t)column + 19)
				continue;
			memcpy(text, p + column, 19);
			char *d = strchr(text, 'D');
			if (d)
				*d = 'e';
			numbers[i] = strtod(text, NULL);
		}
		for (int k = 0; k < kept->n; k++) {
			const kept_record *r = &kept->list[k];
			if (r->kind != kind || strncmp(r->sat, line, 3) != 0 ||
			    value_of(r, key) != numbers[key_at])
				continue;
			/* Galileo: bit 1 of the data source stands for F/NAV */
			if (source_at > 0 &&
			    (value_of(r, "message") == 16) != ((int)numbers[source_at] >> 1 & 1))
				continue;
			pairs++;
			for (int i = 0; i < 31; i++) {
				if (!columns[i])
					continue;
				const double got = value_of(r, columns[i]);
				const bool same = got == (double)(float)numbers[i] ||
				                  fabs(got - numbers[i]) <= 1e-11 * fabs(numbers[i]);
				if (!same)
					print_message("%s %s: %.17g, RINEX %.17g\n", r->sat, columns[i], got,
					              numbers[i]);
				assert_true(same);
			}
		}
		while (*line && strncmp(line + strcspn(line, "\n") + 1, "    ", 4) == 0)
			line += strcspn(line, "\n") + 1;
	}
	return pairs;
}

#endif
