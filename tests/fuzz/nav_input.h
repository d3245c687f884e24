/* Raw navigation pages for the harnesses: sets of pages of one satellite, with random parameters but with the identity,
 * issue of data and parity that a decoder asks for; and SBAS messages. */
#ifndef FURROW_TESTS_FUZZ_NAV_INPUT_H
#define FURROW_TESTS_FUZZ_NAV_INPUT_H

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h> /* declares what parts of nav_encode.h that are not used here call */

#include "../unit/nav_encode.h"
#include "formats/sbas_message.h"

#include "sbf_input.h"

enum {
	NAV_GPS = 4017,
	NAV_SBAS = 4020,
	NAV_FNAV = 4022,
	NAV_INAV = 4023,
	NAV_GLONASS = 4026,
	NAV_BEIDOU = 4047
};

static inline icd_page nav_random_page(fw_random *r)
{
	icd_page page;
	uint64_t bits = 0;
	for (size_t i = 0; i < sizeof page.bit; i++, bits >>= 1) {
		if (i % 64 == 0)
			bits = fw_random_u64(r);
		page.bit[i] = bits & 1;
	}
	return page;
}

/* ---- one page: `which` of its system ---- */

static inline nav_block nav_gps_page(icd_page *page, uint8_t svid, double tow_s, unsigned which,
                                     unsigned issue)
{
	write_bits(page, 1, 8, 0x8b);
	write_bits(page, 50, 3, which);
	write_bits(page, which == 1 ? 211 : which == 2 ? 61 : 271, 8, issue);
	if (which == 4)
		write_bits(page, 61, 8, 1 << 6 | 56);
	return gps_block(NAV_GPS, svid, tow_s, page);
}

static inline nav_block nav_galileo_page(icd_page *page, uint8_t svid, double tow_s, unsigned which,
                                         unsigned issue, int fnav)
{
	write_bits(page, 1, 6, which);
	if (which <= 4)
		write_bits(page, fnav && which == 1 ? 13 : 7, 10, issue);
	if (fnav && which == 1)
		write_bits(page, 7, 6, svid - 70U);
	if (!fnav && which == 4)
		write_bits(page, 17, 6, svid - 70U);
	return fnav ? fnav_block(svid, tow_s, page) : inav_block(svid, tow_s, page);
}

static inline nav_block nav_beidou_page(icd_page *page, uint8_t svid, double tow_s, unsigned which, int d2)
{
	if (d2)
		write_bits(page, 43, 4, which);
	if (which == (d2 ? 11 : 4))
		write_bits(page, 44, 7, d2 ? 102 : 10);
	return bds_block(svid, tow_s, page, which == (d2 ? 11 : 4) ? 5 : d2 ? 1 : which);
}

static inline nav_block nav_glonass_string(icd_page *page, uint8_t svid, double tow_s, unsigned which)
{
	write_bits(page, 1, 1, 0);
	write_bits(page, 2, 4, which);
	return glo_block(svid, 8, tow_s, page);
}

/* ---- sets ---- */

static const struct nav_set {
	uint16_t number;
	uint8_t first_svid, n_svids, n_pages, d2;
	double step_s;
	uint8_t pages[11];
} nav_sets[] = {
    {NAV_GPS, 1, 37, 4, 0, 6, {1, 2, 3, 4}},
    {NAV_INAV, 71, 36, 7, 0, 2, {1, 2, 3, 4, 5, 6, 10}},
    {NAV_FNAV, 71, 36, 4, 0, 10, {1, 2, 3, 4}},
    {NAV_GLONASS, 38, 24, 6, 0, 2, {1, 2, 3, 4, 5, 14}},
    {NAV_BEIDOU, 146, 35, 4, 0, 6, {1, 2, 3, 4}},
    {NAV_BEIDOU, 141, 5, 11, 1, 3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}},
};

static inline nav_block nav_page(fw_random *r, const struct nav_set *set, uint8_t svid, double tow_s,
                                 unsigned which, unsigned issue)
{
	icd_page page = nav_random_page(r);
	switch (set->number) {
	case NAV_GPS: return nav_gps_page(&page, svid, tow_s, which, issue);
	case NAV_INAV: return nav_galileo_page(&page, svid, tow_s, which, issue, 0);
	case NAV_FNAV: return nav_galileo_page(&page, svid, tow_s, which, issue, 1);
	case NAV_GLONASS: return nav_glonass_string(&page, svid, tow_s, which);
	default: return nav_beidou_page(&page, svid, tow_s, which, set->d2);
	}
}

static inline size_t nav_seal(uint8_t *block, const nav_block *b)
{
	memcpy(block, b->bytes, b->length);
	fw_sbf_seal(block, fw_load_u16(block + 4), 0, (uint16_t)b->length, fw_load_u32(block + 8), SBF_WEEK);
	return b->length;
}

/* All pages of a satellite, in their order: see sbf_maker. */
static inline size_t nav_make_pages(fw_random *r, uint32_t *tow_ms, uint8_t *blocks)
{
	const struct nav_set *set = &nav_sets[fw_random_below(r, sizeof nav_sets / sizeof *nav_sets)];
	const uint8_t svid = (uint8_t)(set->first_svid + fw_random_below(r, set->n_svids));
	const unsigned issue = (unsigned)fw_random_below(r, 256);
	double tow_s = *tow_ms % 604800000 / 30000 * 30;
	size_t size = 0;
	for (unsigned i = 0; i < set->n_pages; i++) {
		tow_s += set->step_s;
		const nav_block b = nav_page(r, set, svid, tow_s, set->pages[i], issue);
		size += nav_seal(blocks + size, &b);
	}
	*tow_ms = (uint32_t)(tow_s * 1000);
	return size;
}

/* ---- SBAS ---- */

/* A message of any type, its content random, its parity right. */
static inline void nav_random_message(fw_random *r, uint8_t message[FW_SBAS_BYTES])
{
	const unsigned type = (unsigned)fw_random_below(r, fw_random_below(r, 4) == 0 ? 64 : 29);
	uint8_t head[FW_SBAS_BYTES];
	require(fw_sbas_begin(type, (unsigned)fw_random_below(r, 604800), head) == FW_OK);
	sbf_fill(r, message, FW_SBAS_BYTES);
	message[0] = head[0];
	message[1] = (uint8_t)((head[1] & 0xfc) | (message[1] & 3));
	fw_sbas_finish(message);
}

static inline size_t nav_make_sbas(fw_random *r, uint32_t *tow_ms, uint8_t *blocks)
{
	uint8_t message[FW_SBAS_BYTES];
	memset(blocks, 0, 20);
	nav_random_message(r, message);
	for (int i = 0; i < FW_SBAS_BYTES; i++)
		blocks[20 + i] = message[i ^ 3];
	blocks[14] = (uint8_t)(120 + fw_random_below(r, 20));
	blocks[15] = 1;
	fw_sbf_seal(blocks, NAV_SBAS, 0, 20 + FW_SBAS_BYTES, *tow_ms, SBF_WEEK);
	return 20 + FW_SBAS_BYTES;
}

/* ---- repair ---- */

/* Puts the parity of a page right that lies in a block of raw pages; GLONASS's channel stays. */
static inline void nav_repair_page(uint8_t *block, size_t length)
{
	const unsigned number = fw_load_u16(block + 4) & 0x1fff, bits = number == NAV_GPS ? 30 : 32;
	const unsigned words = number == NAV_GLONASS ? 3 : number == NAV_GPS || number == NAV_BEIDOU ? 10 : 8;
	icd_page page = {{0}}, word = {{0}};
	nav_block b;

	if (length < 20 + 4 * words)
		return;
	for (unsigned i = 0; i < words; i++)
		write_bits(&page, (int)(1 + bits * i), (int)bits, fw_load_u32(block + 20 + 4 * i));
	switch (number) {
	case NAV_GPS: b = gps_block(NAV_GPS, 1, 0, &page); break;
	case NAV_FNAV: b = fnav_block(71, 0, &page); break;
	case NAV_INAV:
		memcpy(word.bit + 1, page.bit + 3, 112);
		memcpy(word.bit + 113, page.bit + 117, 16);
		b = inav_block(71, 0, &word);
		break;
	case NAV_GLONASS: b = glo_block(38, 8, 0, &page); break;
	case NAV_BEIDOU: b = bds_block(141, 0, &page, read_bits(&page, 16, 3)); break;
	default: return;
	}
	memcpy(block + 20, b.bytes + 20, 4 * words);
	block[15] = 1;
}

/* Puts all parities and then all CRCs of a stream right. */
static inline void nav_repair(uint8_t *data, size_t size)
{
	sbf_repair(data, size);
	for (size_t at = 0; (at = sbf_find(data, size, at)) + FW_SBF_HEADER <= size; at += 2)
		if (fw_load_u16(data + at + 6) <= size - at)
			nav_repair_page(data + at, fw_load_u16(data + at + 6));
	sbf_repair(data, size);
}

#endif
