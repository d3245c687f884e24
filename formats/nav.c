#include "formats/nav.h"

#include <string.h>

#include "base/time.h"
#include "formats/bytes.h"
#include "formats/nav_beidou.h"
#include "formats/nav_galileo.h"
#include "formats/nav_glonass.h"
#include "formats/nav_gps.h"
#include "formats/sbf_signal.h"

/* SBF reference guide, "GNSS navigation message blocks": the body that all of them share. */
enum { AT_TOW = 8, AT_WEEK = 12, AT_SVID = 14, AT_CRC_PASSED = 15, AT_CHANNEL = 18, AT_BITS = 20 };

enum {
	GPS_RAW_CA = 4017,
	GAL_RAW_FNAV = 4022,
	GAL_RAW_INAV = 4023,
	GLO_RAW_CA = 4026,
	BDS_RAW = 4047,
	QZS_RAW_L1CA = 4066
};

static const struct source {
	uint16_t block_number;
	uint8_t n_words;
	char letter; /* of the satellites whose pages it holds */
	const fw_nav_system *system;
} sources[] = {
    {GPS_RAW_CA, 10, 'G', &fw_nav_lnav},  {GAL_RAW_FNAV, 8, 'E', &fw_nav_fnav},
    {GAL_RAW_INAV, 8, 'E', &fw_nav_inav}, {GLO_RAW_CA, 3, 'R', &fw_nav_gnav},
    {BDS_RAW, 10, 'C', &fw_nav_d1},       {QZS_RAW_L1CA, 10, 'J', &fw_nav_lnav},
};

/* Where the satellites of a range of SVIDs lie among the stores. */
static const struct {
	uint8_t first, last, store;
} ranges[] = {
    {1, 37, 0},      /* GPS */
    {181, 190, 37},  /* QZSS */
    {71, 106, 47},   /* Galileo, I/NAV; F/NAV lies FNAV_STORES further on */
    {141, 180, 119}, /* BeiDou 1 to 40 */
    {223, 245, 159}, /* BeiDou 41 to 63 */
    {38, 61, 182},   /* GLONASS 1 to 24 */
    {63, 68, 206},   /* GLONASS 25 to 30 */
};

enum { FNAV_STORES = 36 };

static const struct source *source_of(uint16_t block_number)
{
	for (size_t i = 0; i < sizeof sources / sizeof *sources; i++)
		if (sources[i].block_number == block_number)
			return &sources[i];
	return NULL;
}

/* The store of a satellite; its SVID lies in one of the ranges, since it has a name of one of the systems. */
static fw_nav_store *store_of(fw_nav *nav, const fw_nav_system *system, uint8_t svid)
{
	for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
		if (svid < ranges[i].first || svid > ranges[i].last)
			continue;
		const int at = ranges[i].store + svid - ranges[i].first;
		return &nav->stores[system == &fw_nav_fnav ? at + FNAV_STORES : at];
	}
	return NULL;
}

/* BeiDou's geostationary satellites, C01 to C05 and C59 to C63, send D2 (BDS-SIS-ICD-B1I-3.0, 5.1.1). */
static bool is_geostationary(uint8_t svid)
{
	return (svid >= 141 && svid <= 145) || (svid >= 241 && svid <= 245);
}

static void read_raw(const uint8_t *block, int n_words, fw_nav_raw *raw)
{
	memset(raw, 0, sizeof *raw);
	raw->svid = block[AT_SVID];
	raw->channel = block[AT_CHANNEL];
	raw->end_ms = fw_load_u16(block + AT_WEEK) * FW_NAV_WEEK_MS + fw_load_u32(block + AT_TOW);
	for (int i = 0; i < n_words; i++) {
		const uint32_t word = fw_load_u32(block + AT_BITS + 4 * i);
		raw->words[i] = word;
		for (int b = 0; b < 4; b++)
			raw->bytes[4 * i + b] = (uint8_t)(word >> (24 - 8 * b));
	}
}

void fw_nav_init(fw_nav *nav)
{
	memset(nav, 0, sizeof *nav);
}

bool fw_nav_reads(uint16_t block_number)
{
	return source_of(block_number) != NULL;
}

fw_status fw_nav_block(fw_nav *nav, const uint8_t *block, size_t length, const fw_sink *sink)
{
	const struct source *source = source_of(fw_load_u16(block + 4) & 0x1fff);
	fw_nav_raw raw;

	if (!source)
		return FW_EUNKNOWN;
	if (length < AT_BITS + 4 * (size_t)source->n_words || fw_load_u32(block + AT_TOW) >= FW_NAV_WEEK_MS ||
	    fw_load_u16(block + AT_WEEK) > FW_TIME_WEEK_MAX)
		return FW_EFORMAT;
	const char *name = fw_sbf_satellite(block[AT_SVID]);
	if (!name || name[0] != source->letter)
		return FW_EUNKNOWN;
	if (block[AT_CRC_PASSED] != 1)
		return FW_ECHECKSUM;

	read_raw(block, source->n_words, &raw);
	const fw_nav_system *system = source->system;
	if (system == &fw_nav_d1 && is_geostationary(raw.svid))
		system = &fw_nav_d2;
	fw_nav_arrival arrival = {.index = -1, .svid = raw.svid, .page.begin_ms = raw.end_ms};
	const fw_status status = system->unpack(&raw, &arrival);
	if (status != FW_OK || arrival.index < 0)
		return status;
	fw_nav_take(system, &arrival, raw.end_ms, store_of(nav, system, arrival.svid), sink);
	return FW_OK;
}
