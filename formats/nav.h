/* Broadcast navigation from raw pages: what a receiver that only logs the pages themselves leaves to be done.
 *
 * One decoder takes the raw page blocks of a log in their order and hands out the records eph_gps, eph_gal,
 * eph_bds, eph_glo, klobuchar, nequick, utc, ggto and glo_time with source "raw". Column by column they equal
 * what a receiver's own decoded blocks say; columns that no page carries (Galileo's PRS and C/NAV status) are
 * absent.
 *
 * A record comes when a satellite's set of pages first is complete and consistent, and then only when its
 * content has changed. Its stamp is that of the block that completed it.
 *
 * Everything lies in the caller's fw_nav; nothing is allocated, and no block, whatever its bytes, can do
 * harm. */
#ifndef FURROW_FORMATS_NAV_H
#define FURROW_FORMATS_NAV_H

#include <stddef.h>

#include "formats/nav_message.h"

enum {
	/* Satellites: GPS 37, QZSS 10, Galileo 36 in two messages, BeiDou 63, GLONASS 30. */
	FW_NAV_STORES = 37 + 10 + 2 * 36 + 63 + 30
};

/* The decoder, about 110 kB. */
typedef struct {
	fw_nav_store stores[FW_NAV_STORES];
} fw_nav;

/* Makes a decoder that has seen nothing. */
void fw_nav_init(fw_nav *nav);

/* Is a block number that of raw pages which this decoder reads (GPSRawCA 4017, GALRawFNAV 4022, GALRawINAV
 * 4023, GLORawCA 4026, BDSRaw 4047, QZSRawL1CA 4066)? */
bool fw_nav_reads(uint16_t block_number);

/* Takes one block.
 *   block   in      a whole SBF block, header included
 *   length  in      its length [bytes], at least 8
 *   sink    in      gets the records that the block completes
 * Returns FW_OK: a page, taken or not needed; FW_EUNKNOWN: no block of raw pages, or of a satellite that has
 * no name; FW_EFORMAT: too short, or without a time stamp; FW_ECHECKSUM: the receiver says that its check
 * failed (CRCPassed is not 1), or our own does. Nothing was kept unless FW_OK. */
fw_status fw_nav_block(fw_nav *nav, const uint8_t *block, size_t length, const fw_sink *sink) FW_MUST_CHECK;

#endif
