#include "formats/sbas_message.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "formats/crc.h"
#include "formats/nav_bits.h"
#include "formats/sbf_signal.h"
#include "furrow_eph_sbas.h"
#include "furrow_sbas_almanac.h"
#include "furrow_sbas_almanac_columns.h"
#include "furrow_sbas_cov.h"
#include "furrow_sbas_degradation.h"
#include "furrow_sbas_factors.h"
#include "furrow_sbas_fast.h"
#include "furrow_sbas_igp_mask.h"
#include "furrow_sbas_integrity.h"
#include "furrow_sbas_iono.h"
#include "furrow_sbas_long.h"
#include "furrow_sbas_mask.h"
#include "furrow_sbas_mask_columns.h"
#include "furrow_sbas_mt0.h"
#include "furrow_sbas_mt0_columns.h"
#include "furrow_sbas_service.h"
#include "furrow_sbas_time.h"

#define BIT(column) (INT64_C(1) << (column))

enum { TYPE_START = 8, DATA_START = 14, CRC_START = 226 };
enum { FAST_BLOCK = 13, IONO_BLOCK = 15 };     /* mask numbers from one message, or block, to the next */
enum { MASK_NUMBERS = 51, IGP_NUMBERS = 201 }; /* the longest masks of satellites and of grid points */
enum { SBAS_MASK_START = 14, IGP_MASK_START = 24 };
enum { FAST_BLOCK_ID = 112, IONO_BLOCK_ID = 18, REGION_COUNT = 23 };
enum { ALMANAC_PRN = 16, ALMANAC_STRIDE = 67, ALMANAC_TIME = 215 };
enum { COV_IODP = 14, COV_MASK_NO = 16, COV_STRIDE = 105 };
enum { LONG_MASK_NO = 1, LONG_STRIDE = 51, LONG_IODP = 103 }; /* in a half message without rates */

#define DAY_S      INT64_C(86400)
#define HALF_DAY_S INT64_C(43200)

/** DO-229, appendix A: the preamble's 24 bits, spread over three messages */
static const uint8_t preamble[3] = {0x53, 0x9a, 0xc6};

/* One number: column = (raw + bias) scale. */
typedef struct {
	uint8_t start;  /* first bit, counted from the layout's base */
	uint8_t stride; /* bits to the same number in the next place; 0: one for all places */
	int8_t width;   /* negative: two's complement */
	int8_t bias;
	uint8_t type;    /* fw_column_type of the member */
	uint16_t offset; /* of the member in the record */
	double scale;
} field;

/* The records of one kind in a message of one type: up to `places` of them, equally far apart. */
typedef struct {
	uint8_t type;
	uint8_t base; /* what the fields' first bits count from */
	uint8_t places;
	uint8_t n_fields;
	const field *fields;
	fw_kind kind;
} layout;

/* clang-format off */
#define MEMBER_TYPE(kind, member)                                                                            \
	_Generic(((furrow_##kind *)NULL)->member,                                                            \
		int8_t: FW_I8, int16_t: FW_I16, int32_t: FW_I32, float: FW_F32, double: FW_F64)
/* clang-format on */
#define FIELD_BIASED(kind, member, start, width, stride, scale, bias)                                        \
	{                                                                                                    \
		start, stride, width, bias, MEMBER_TYPE(kind, member), offsetof(furrow_##kind, member),      \
		    scale                                                                                    \
	}
#define FIELD(kind, member, start, width, stride, scale)                                                     \
	FIELD_BIASED(kind, member, start, width, stride, scale, 0)

static const field mask_fields[] = {FIELD(sbas_mask, iodp, 224, 2, 0, 1)};

static const field fast_fields[] = {
    FIELD(sbas_fast, type, 8, 6, 0, 1),    FIELD(sbas_fast, iodf, 14, 2, 0, 1),
    FIELD(sbas_fast, iodp, 16, 2, 0, 1),   FIELD(sbas_fast, prc_m, 18, -12, 12, 0.125),
    FIELD(sbas_fast, udrei, 174, 4, 4, 1),
};

static const field mixed_fast_fields[] = {
    FIELD(sbas_fast, type, 8, 6, 0, 1),   FIELD(sbas_fast, prc_m, 14, -12, 12, 0.125),
    FIELD(sbas_fast, udrei, 86, 4, 4, 1), FIELD(sbas_fast, iodp, 110, 2, 0, 1),
    FIELD(sbas_fast, iodf, 114, 2, 0, 1),
};

static const field integrity_fields[] = {
    FIELD(sbas_integrity, iodf2, 14, 2, 0, 1), FIELD(sbas_integrity, iodf3, 16, 2, 0, 1),
    FIELD(sbas_integrity, iodf4, 18, 2, 0, 1), FIELD(sbas_integrity, iodf5, 20, 2, 0, 1),
    FIELD(sbas_integrity, udrei, 22, 4, 4, 1),
};

static const field degradation_fields[] = {
    FIELD(sbas_degradation, latency_s, 14, 4, 0, 1),
    FIELD(sbas_degradation, iodp, 18, 2, 0, 1),
    FIELD(sbas_degradation, ai, 22, 4, 4, 1),
};

static const field eph_fields[] = {
    FIELD(eph_sbas, iodn, 14, 8, 0, 1),
    FIELD(eph_sbas, t0_s, 22, 13, 0, 16),
    FIELD(eph_sbas, ura, 35, 4, 0, 1),
    FIELD(eph_sbas, x_m, 39, -30, 0, 0.08),
    FIELD(eph_sbas, y_m, 69, -30, 0, 0.08),
    FIELD(eph_sbas, z_m, 99, -25, 0, 0.4),
    FIELD(eph_sbas, vx_mps, 124, -17, 0, 0.000625),
    FIELD(eph_sbas, vy_mps, 141, -17, 0, 0.000625),
    FIELD(eph_sbas, vz_mps, 158, -18, 0, 0.004),
    FIELD(eph_sbas, ax_mps2, 176, -10, 0, 0.0000125),
    FIELD(eph_sbas, ay_mps2, 186, -10, 0, 0.0000125),
    FIELD(eph_sbas, az_mps2, 196, -10, 0, 0.0000625),
    FIELD(eph_sbas, agf0_s, 206, -12, 0, 0x1p-31),
    FIELD(eph_sbas, agf1_sps, 218, -8, 0, 0x1p-40),
};

static const field factors_fields[] = {
    FIELD(sbas_factors, brrc_m, 14, 10, 0, 0.002),
    FIELD(sbas_factors, cltc_lsb_m, 24, 10, 0, 0.002),
    FIELD(sbas_factors, cltc_v1_mps, 34, 10, 0, 0.00005),
    FIELD(sbas_factors, iltc_v1_s, 44, 9, 0, 1),
    FIELD(sbas_factors, cltc_v0_m, 53, 10, 0, 0.002),
    FIELD(sbas_factors, iltc_v0_s, 63, 9, 0, 1),
    FIELD(sbas_factors, cgeo_lsb_m, 72, 10, 0, 0.0005),
    FIELD(sbas_factors, cgeo_v_mps, 82, 10, 0, 0.00005),
    FIELD(sbas_factors, igeo_s, 92, 9, 0, 1),
    FIELD(sbas_factors, cer_m, 101, 6, 0, 0.5),
    FIELD(sbas_factors, ciono_step_m, 107, 10, 0, 0.001),
    FIELD(sbas_factors, iiono_s, 117, 9, 0, 1),
    FIELD(sbas_factors, ciono_ramp_mps, 126, 10, 0, 0.000005),
    FIELD(sbas_factors, rss_udre, 136, 1, 0, 1),
    FIELD(sbas_factors, rss_iono, 137, 1, 0, 1),
    FIELD(sbas_factors, ccovariance, 138, 7, 0, 0.1),
};

static const field time_fields[] = {
    FIELD(sbas_time, a1_sps, 14, -24, 0, 0x1p-50),
    FIELD(sbas_time, a0_s, 38, -32, 0, 0x1p-30),
    FIELD(sbas_time, tot_s, 70, 8, 0, 4096),
    FIELD(sbas_time, wnt, 78, 8, 0, 1),
    FIELD(sbas_time, leap_s, 86, -8, 0, 1),
    FIELD(sbas_time, wnlsf, 94, 8, 0, 1),
    FIELD(sbas_time, dn, 102, 8, 0, 1),
    FIELD(sbas_time, leap_future_s, 110, -8, 0, 1),
    FIELD(sbas_time, utc_std, 118, 3, 0, 1),
    FIELD(sbas_time, gps_tow_s, 121, 20, 0, 1),
    FIELD(sbas_time, gps_wn, 141, 10, 0, 1),
    FIELD(sbas_time, glonass_id, 151, 1, 0, 1),
};

static const field almanac_fields[] = {
    FIELD(sbas_almanac, data_id, 14, 2, 67, 1),  FIELD(sbas_almanac, health, 24, 8, 67, 1),
    FIELD(sbas_almanac, x_m, 32, -15, 67, 2600), FIELD(sbas_almanac, y_m, 47, -15, 67, 2600),
    FIELD(sbas_almanac, z_m, 62, -9, 67, 26000), FIELD(sbas_almanac, vx_mps, 71, -3, 67, 10),
    FIELD(sbas_almanac, vy_mps, 74, -3, 67, 10), FIELD(sbas_almanac, vz_mps, 77, -4, 67, 60),
};

static const field igp_mask_fields[] = {
    FIELD(sbas_igp_mask, bands, 14, 4, 0, 1),
    FIELD(sbas_igp_mask, band, 18, 4, 0, 1),
    FIELD(sbas_igp_mask, iodi, 22, 2, 0, 1),
};

/* A half message of types 24 and 25 without rates: two satellites. */
static const field long_v0_fields[] = {
    FIELD(sbas_long, velocity_code, 0, 1, 0, 1),
    FIELD(sbas_long, mask_no, 1, 6, 51, 1),
    FIELD(sbas_long, iode, 7, 8, 51, 1),
    FIELD(sbas_long, dx_m, 15, -9, 51, 0.125),
    FIELD(sbas_long, dy_m, 24, -9, 51, 0.125),
    FIELD(sbas_long, dz_m, 33, -9, 51, 0.125),
    FIELD(sbas_long, daf0_s, 42, -10, 51, 0x1p-31),
    FIELD(sbas_long, iodp, LONG_IODP, 2, 0, 1),
};

/* And with rates: one. */
static const field long_v1_fields[] = {
    FIELD(sbas_long, velocity_code, 0, 1, 0, 1),
    FIELD(sbas_long, mask_no, 1, 6, 0, 1),
    FIELD(sbas_long, iode, 7, 8, 0, 1),
    FIELD(sbas_long, dx_m, 15, -11, 0, 0.125),
    FIELD(sbas_long, dy_m, 26, -11, 0, 0.125),
    FIELD(sbas_long, dz_m, 37, -11, 0, 0.125),
    FIELD(sbas_long, daf0_s, 48, -11, 0, 0x1p-31),
    FIELD(sbas_long, vx_mps, 59, -8, 0, 0x1p-11),
    FIELD(sbas_long, vy_mps, 67, -8, 0, 0x1p-11),
    FIELD(sbas_long, vz_mps, 75, -8, 0, 0x1p-11),
    FIELD(sbas_long, daf1_sps, 83, -8, 0, 0x1p-39),
    FIELD(sbas_long, toe_s, 91, 13, 0, 16),
    FIELD(sbas_long, iodp, 104, 2, 0, 1),
};

static const field iono_fields[] = {
    FIELD(sbas_iono, band, 14, 4, 0, 1),
    FIELD(sbas_iono, delay_m, 22, 9, 13, 0.125),
    FIELD(sbas_iono, givei, 31, 4, 13, 1),
    FIELD(sbas_iono, iodi, 217, 2, 0, 1),
};

static const field service_fields[] = {
    FIELD(sbas_service, iods, 14, 3, 0, 1),
    FIELD_BIASED(sbas_service, messages, 17, 3, 0, 1, 1),
    FIELD_BIASED(sbas_service, message_no, 20, 3, 0, 1, 1),
    FIELD(sbas_service, priority, 26, 2, 0, 1),
    FIELD(sbas_service, dudre_in, 28, 4, 0, 1),
    FIELD(sbas_service, dudre_out, 32, 4, 0, 1),
    FIELD(sbas_service, lat1_deg, 36, -8, 35, 1),
    FIELD(sbas_service, lon1_deg, 44, -9, 35, 1),
    FIELD(sbas_service, lat2_deg, 53, -8, 35, 1),
    FIELD(sbas_service, lon2_deg, 61, -9, 35, 1),
    FIELD(sbas_service, shape, 70, 1, 35, 1),
};

static const field cov_fields[] = {
    FIELD(sbas_cov, iodp, COV_IODP, 2, 0, 1),  FIELD(sbas_cov, mask_no, 16, 6, 105, 1),
    FIELD(sbas_cov, scale_exp, 22, 3, 105, 1), FIELD(sbas_cov, e11, 25, 9, 105, 1),
    FIELD(sbas_cov, e22, 34, 9, 105, 1),       FIELD(sbas_cov, e33, 43, 9, 105, 1),
    FIELD(sbas_cov, e44, 52, 9, 105, 1),       FIELD(sbas_cov, e12, 61, -10, 105, 1),
    FIELD(sbas_cov, e13, 71, -10, 105, 1),     FIELD(sbas_cov, e14, 81, -10, 105, 1),
    FIELD(sbas_cov, e23, 91, -10, 105, 1),     FIELD(sbas_cov, e24, 101, -10, 105, 1),
    FIELD(sbas_cov, e34, 111, -10, 105, 1),
};

#define LAYOUT(type, base, places, kind, fields)                                                             \
	{                                                                                                    \
		type, base, places, sizeof(fields) / sizeof((fields)[0]), fields, FW_##kind                  \
	}

static const layout layouts[] = {
    {0, 0, 1, 0, NULL, FW_sbas_mt0},
    LAYOUT(0, 0, 13, sbas_fast, fast_fields),
    LAYOUT(1, 0, 210, sbas_mask, mask_fields),
    LAYOUT(2, 0, 13, sbas_fast, fast_fields),
    LAYOUT(3, 0, 13, sbas_fast, fast_fields),
    LAYOUT(4, 0, 13, sbas_fast, fast_fields),
    LAYOUT(5, 0, 12, sbas_fast, fast_fields),
    LAYOUT(6, 0, MASK_NUMBERS, sbas_integrity, integrity_fields),
    LAYOUT(7, 0, MASK_NUMBERS, sbas_degradation, degradation_fields),
    LAYOUT(9, 0, 1, eph_sbas, eph_fields),
    LAYOUT(10, 0, 1, sbas_factors, factors_fields),
    LAYOUT(12, 0, 1, sbas_time, time_fields),
    LAYOUT(17, 0, 3, sbas_almanac, almanac_fields),
    LAYOUT(18, 0, IGP_NUMBERS, sbas_igp_mask, igp_mask_fields),
    LAYOUT(24, 0, 6, sbas_fast, mixed_fast_fields),
    LAYOUT(24, 120, 2, sbas_long, long_v0_fields),
    LAYOUT(24, 120, 1, sbas_long, long_v1_fields),
    LAYOUT(25, 14, 2, sbas_long, long_v0_fields),
    LAYOUT(25, 14, 1, sbas_long, long_v1_fields),
    LAYOUT(25, 120, 2, sbas_long, long_v0_fields),
    LAYOUT(25, 120, 1, sbas_long, long_v1_fields),
    LAYOUT(26, 0, 15, sbas_iono, iono_fields),
    LAYOUT(27, 0, 5, sbas_service, service_fields),
    LAYOUT(28, 0, 2, sbas_cov, cov_fields),
};

#define N_LAYOUTS (sizeof layouts / sizeof layouts[0])

/* ---- bits to records ---- */

/* What all records of a message share. */
typedef struct {
	const uint8_t *message;
	unsigned type;
	const char *satellite;
	const fw_record_head *stamp;
} source;

/* A record being made; mt0 has the columns that all kinds begin with, and no more. */
typedef union {
	furrow_sbas_mt0 head;
	furrow_sbas_mask mask;
	furrow_sbas_fast fast;
	furrow_sbas_integrity integrity;
	furrow_sbas_degradation degradation;
	furrow_eph_sbas eph;
	furrow_sbas_factors factors;
	furrow_sbas_time time;
	furrow_sbas_almanac almanac;
	furrow_sbas_igp_mask igp_mask;
	furrow_sbas_long longterm;
	furrow_sbas_iono iono;
	furrow_sbas_service service;
	furrow_sbas_cov cov;
} row;

static unsigned bits(const uint8_t *message, unsigned start, unsigned width)
{
	return fw_bits_unsigned(message, FW_SBAS_BYTES, start, width);
}

static int is_empty(const uint8_t *message)
{
	for (unsigned bit = DATA_START; bit < CRC_START; bit += 4)
		if (bits(message, bit, 4) != 0)
			return 0;
	return 1;
}

static int is_mask_no(unsigned n)
{
	return n >= 1 && n <= MASK_NUMBERS;
}

/* Of the two layouts of a half message, the one for its velocity code. */
static int holds_long(const uint8_t *message, const layout *l, unsigned place)
{
	unsigned with_rates = l->fields == long_v1_fields;
	return bits(message, l->base, 1) == with_rates &&
	       is_mask_no(bits(message, l->base + LONG_MASK_NO + LONG_STRIDE * place, 6));
}

/* Does a place of a message hold a record? */
static int is_taken(const uint8_t *message, const layout *l, unsigned place)
{
	switch (l->kind) {
	case FW_sbas_mask: return bits(message, SBAS_MASK_START + place, 1) != 0;
	case FW_sbas_igp_mask: return bits(message, IGP_MASK_START + place, 1) != 0;
	case FW_sbas_fast: return l->type != 0 || !is_empty(message);
	case FW_sbas_almanac: return bits(message, ALMANAC_PRN + ALMANAC_STRIDE * place, 8) != 0;
	case FW_sbas_long: return holds_long(message, l, place);
	case FW_sbas_iono: return IONO_BLOCK * bits(message, IONO_BLOCK_ID, 4) + place < IGP_NUMBERS;
	case FW_sbas_service: return place < bits(message, REGION_COUNT, 3);
	case FW_sbas_cov: return is_mask_no(bits(message, COV_MASK_NO + COV_STRIDE * place, 6));
	default: return 1;
	}
}

static void set_member(void *record, const field *f, double value)
{
	void *member = (char *)record + f->offset;
	switch (f->type) {
	case FW_I8: *(int8_t *)member = (int8_t)value; break;
	case FW_I16: *(int16_t *)member = (int16_t)value; break;
	case FW_I32: *(int32_t *)member = (int32_t)value; break;
	case FW_F32: *(float *)member = (float)value; break;
	default: *(double *)member = value; break;
	}
}

static double field_value(const uint8_t *message, unsigned base, const field *f, unsigned place)
{
	unsigned width = (unsigned)(f->width < 0 ? -f->width : f->width);
	uint32_t raw = bits(message, base + f->start + f->stride * place, width);
	int64_t value = f->width < 0 ? fw_bits_twos_complement(raw, width) : raw;
	return (double)(value + f->bias) * f->scale;
}

/* A string for a column: absent when NULL. */
static char *text(const char *string, int64_t *present, int column)
{
	*present &= ~BIT(column);
	if (string != NULL)
		*present |= BIT(column);
	return (char *)(uintptr_t)(string != NULL ? string : ""); /* records do not say const */
}

/* SBF's number of the satellite with a PRN of the SBAS mask (GPS, GLONASS slots + 37, SBAS), or 0. */
static uint8_t svid_of_prn(unsigned prn)
{
	if (prn >= 141 && prn <= 158)
		return (uint8_t)(prn + 57);
	return prn <= 61 || (prn >= 120 && prn <= 140) ? (uint8_t)prn : 0;
}

static unsigned prn_of_satellite(const char *satellite)
{
	unsigned svid = satellite == NULL ? 0 : fw_sbf_svid(satellite);
	unsigned prn = svid >= 198 ? svid - 57 : svid;
	return svid_of_prn(prn) == svid ? prn : 0;
}

/* Seconds since 1980-01-06 of a time of day, on the day that brings it nearest to the stamp. */
static void set_toa(const source *from, furrow_sbas_almanac *r)
{
	fw_time stamp;
	if (fw_record_time(from->stamp, &stamp) < 0) {
		r->present &= ~BIT(FW_COL_sbas_almanac_toa_s);
		return;
	}
	int64_t now_s = stamp.ns / FW_NS_PER_S;
	int64_t ahead_s = 64 * (int64_t)bits(from->message, ALMANAC_TIME, 11) - now_s % DAY_S;
	r->toa_s = now_s + (ahead_s + 3 * HALF_DAY_S) % DAY_S - HALF_DAY_S;
}

static unsigned fast_block(const source *from)
{
	if (from->type == 24)
		return bits(from->message, FAST_BLOCK_ID, 2);
	return from->type == 0 ? 0 : from->type - 2;
}

/* What a record's place in the message says: mask numbers, satellites. `ordinal` counts the places taken. */
static void set_numbers(const source *from, fw_kind kind, unsigned place, unsigned ordinal, row *r)
{
	const uint8_t *m = from->message;
	switch (kind) {
	case FW_sbas_mask:
		r->mask.mask_no = (int16_t)ordinal;
		r->mask.mask_sat = text(fw_sbf_satellite(svid_of_prn(place + 1)), &r->mask.present,
		                        FW_COL_sbas_mask_mask_sat);
		break;
	case FW_sbas_fast: r->fast.mask_no = (int16_t)(FAST_BLOCK * fast_block(from) + place + 1); break;
	case FW_sbas_integrity: r->integrity.mask_no = (int16_t)(place + 1); break;
	case FW_sbas_degradation: r->degradation.mask_no = (int16_t)(place + 1); break;
	case FW_sbas_almanac:
		r->almanac.sat =
		    text(fw_sbf_satellite(svid_of_prn(bits(m, ALMANAC_PRN + ALMANAC_STRIDE * place, 8))),
		         &r->almanac.present, FW_COL_sbas_almanac_sat);
		set_toa(from, &r->almanac);
		break;
	case FW_sbas_igp_mask:
		r->igp_mask.mask_no = (int16_t)ordinal;
		r->igp_mask.igp = (int16_t)(place + 1);
		break;
	case FW_sbas_iono:
		r->iono.mask_no = (int16_t)(IONO_BLOCK * bits(m, IONO_BLOCK_ID, 4) + place + 1);
		break;
	default: break;
	}
}

static void set_record(const source *from, const layout *l, unsigned place, unsigned ordinal, row *r)
{
	int64_t time = BIT(FW_COL_sbas_mt0_gps_week) | BIT(FW_COL_sbas_mt0_tow_s);
	int64_t all = BIT(fw_record_type_of(l->kind)->n_columns) - 1;

	memset(r, 0, sizeof *r);
	r->head.present = (all & ~time) | (from->stamp->present & time);
	r->head.gps_week = from->stamp->gps_week;
	r->head.tow_s = from->stamp->tow_s;
	r->head.sat = text(from->satellite, &r->head.present, FW_COL_sbas_mt0_sat);
	r->head.source = text("raw", &r->head.present, FW_COL_sbas_mt0_source);
	for (unsigned i = 0; i < l->n_fields; i++)
		set_member(r, &l->fields[i], field_value(from->message, l->base, &l->fields[i], place));
	set_numbers(from, l->kind, place, ordinal, r);
}

static int is_preamble(uint8_t byte)
{
	return byte == preamble[0] || byte == preamble[1] || byte == preamble[2];
}

fw_status fw_sbas_decode(const uint8_t message[static FW_SBAS_BYTES], const char *satellite,
                         const fw_record_head *stamp, fw_sink sink)
{
	if (!is_preamble(message[0]))
		return FW_EFORMAT;
	if (fw_crc24q_bits(message, 0, FW_SBAS_BITS) != 0)
		return FW_ECHECKSUM;

	source from = {message, bits(message, TYPE_START, 6), satellite, stamp};
	fw_status status = from.type >= 62 ? FW_OK : FW_EUNKNOWN;
	for (const layout *l = layouts; l < layouts + N_LAYOUTS; l++) {
		if (l->type != from.type)
			continue;
		status = FW_OK;
		unsigned ordinal = 0;
		for (unsigned place = 0; place < l->places; place++) {
			if (!is_taken(message, l, place))
				continue;
			row r;
			set_record(&from, l, place, ++ordinal, &r);
			sink.put(sink.context, l->kind, &r);
		}
	}
	return status;
}

/* ---- records to bits ---- */

static void put(uint8_t *message, unsigned start, unsigned width, uint32_t value)
{
	size_t end = start;
	fw_bits_clear(message, FW_SBAS_BYTES, start, width);
	fw_bits_append(message, FW_SBAS_BYTES, &end, value, width);
}

static double member_value(const void *record, const field *f)
{
	const void *member = (const char *)record + f->offset;
	switch (f->type) {
	case FW_I8: return *(const int8_t *)member;
	case FW_I16: return *(const int16_t *)member;
	case FW_I32: return *(const int32_t *)member;
	case FW_F32: return (double)*(const float *)member;
	default: return *(const double *)member;
	}
}

static fw_status put_field(uint8_t *message, const layout *l, const field *f, unsigned place,
                           const void *record)
{
	unsigned width = (unsigned)(f->width < 0 ? -f->width : f->width);
	double n_values = ldexp(1, (int)width);
	double lowest = f->width < 0 ? -n_values / 2 : 0;
	double raw = nearbyint(member_value(record, f) / f->scale) - f->bias;
	if (!(raw >= lowest && raw < lowest + n_values))
		return FW_ERANGE;
	put(message, l->base + f->start + f->stride * place, width, (uint32_t)(int64_t)raw);
	return FW_OK;
}

static fw_status place_of_fast(const layout *l, const furrow_sbas_fast *r, unsigned *place)
{
	if (r->type != l->type || r->mask_no < 1 || r->mask_no > MASK_NUMBERS)
		return FW_EINVAL;
	unsigned block = (unsigned)(r->mask_no - 1) / FAST_BLOCK;
	unsigned first = l->type < 2 ? 0 : l->type - 2u; /* block of types 0, 2-5 */
	*place = (unsigned)(r->mask_no - 1) % FAST_BLOCK;
	return *place < l->places && (l->type == 24 || block == first) ? FW_OK : FW_EINVAL;
}

/* A mask number, or the like, from 1 on that is the place itself. */
static fw_status place_of_number(int number, const layout *l, unsigned *place)
{
	if (number < 1 || number > l->places)
		return FW_EINVAL;
	*place = (unsigned)number - 1;
	return FW_OK;
}

/* The first place whose mask number or PRN, `width` bits at `start`, is zero. */
static fw_status free_place(const uint8_t *message, unsigned start, unsigned width, unsigned stride,
                            unsigned n_places, unsigned *place)
{
	for (unsigned i = 0; i < n_places; i++)
		if (bits(message, start + stride * i, width) == 0) {
			*place = i;
			return FW_OK;
		}
	return FW_ENOSPACE;
}

/* The second satellite of a half message shares its velocity code and issue of data. */
static fw_status place_of_long(const uint8_t *message, const layout *l, const furrow_sbas_long *r,
                               unsigned *place)
{
	if (!is_mask_no((unsigned)r->mask_no) || (r->velocity_code == 1) != (l->fields == long_v1_fields))
		return FW_EINVAL;
	if (free_place(message, l->base + LONG_MASK_NO, 6, LONG_STRIDE, l->places, place) < 0 ||
	    (*place > 0 &&
	     (bits(message, l->base, 1) != 0 || bits(message, l->base + LONG_IODP, 2) != (unsigned)r->iodp)))
		return FW_ENOSPACE;
	return FW_OK;
}

static fw_status place_of_cov(const uint8_t *message, const layout *l, const furrow_sbas_cov *r,
                              unsigned *place)
{
	if (!is_mask_no((unsigned)r->mask_no))
		return FW_EINVAL;
	if (free_place(message, COV_MASK_NO, 6, COV_STRIDE, l->places, place) < 0 ||
	    (*place > 0 && bits(message, COV_IODP, 2) != (unsigned)r->iodp))
		return FW_ENOSPACE;
	return FW_OK;
}

static fw_status place_of_iono(const furrow_sbas_iono *r, unsigned *place)
{
	if (r->mask_no < 1 || r->mask_no > IGP_NUMBERS)
		return FW_EINVAL;
	*place = (unsigned)(r->mask_no - 1) % IONO_BLOCK;
	return FW_OK;
}

static fw_status place_of_service(const uint8_t *message, const layout *l, unsigned *place)
{
	*place = bits(message, REGION_COUNT, 3);
	return *place < l->places ? FW_OK : FW_ENOSPACE;
}

static fw_status place_of(const uint8_t *message, const layout *l, const void *record, unsigned *place)
{
	switch (l->kind) {
	case FW_sbas_fast: return place_of_fast(l, record, place);
	case FW_sbas_integrity:
		return place_of_number(((const furrow_sbas_integrity *)record)->mask_no, l, place);
	case FW_sbas_degradation:
		return place_of_number(((const furrow_sbas_degradation *)record)->mask_no, l, place);
	case FW_sbas_mask:
		return place_of_number((int)prn_of_satellite(((const furrow_sbas_mask *)record)->mask_sat), l,
		                       place);
	case FW_sbas_igp_mask: return place_of_number(((const furrow_sbas_igp_mask *)record)->igp, l, place);
	case FW_sbas_almanac: return free_place(message, ALMANAC_PRN, 8, ALMANAC_STRIDE, l->places, place);
	case FW_sbas_long: return place_of_long(message, l, record, place);
	case FW_sbas_cov: return place_of_cov(message, l, record, place);
	case FW_sbas_iono: return place_of_iono(record, place);
	case FW_sbas_service: return place_of_service(message, l, place);
	default: *place = 0; return FW_OK;
	}
}

static fw_status put_almanac(uint8_t *message, unsigned place, const furrow_sbas_almanac *r)
{
	unsigned prn = prn_of_satellite(r->sat);
	if (prn == 0)
		return FW_EINVAL;
	if (r->toa_s < 0)
		return FW_ERANGE;
	put(message, ALMANAC_PRN + ALMANAC_STRIDE * place, 8, prn);
	put(message, ALMANAC_TIME, 11, (uint32_t)((r->toa_s % DAY_S + 32) / 64 % (DAY_S / 64)));
	return FW_OK;
}

/* The inverse of set_numbers and is_taken: what tells that there is a record in the place, and which. */
static fw_status put_numbers(uint8_t *message, const layout *l, unsigned place, const void *record)
{
	switch (l->kind) {
	case FW_sbas_mask: put(message, SBAS_MASK_START + place, 1, 1); break;
	case FW_sbas_igp_mask: put(message, IGP_MASK_START + place, 1, 1); break;
	case FW_sbas_fast:
		if (l->type == 24)
			put(message, FAST_BLOCK_ID, 2,
			    (uint32_t)(((const furrow_sbas_fast *)record)->mask_no - 1) / FAST_BLOCK);
		break;
	case FW_sbas_iono:
		put(message, IONO_BLOCK_ID, 4,
		    (uint32_t)(((const furrow_sbas_iono *)record)->mask_no - 1) / IONO_BLOCK);
		break;
	case FW_sbas_almanac: return put_almanac(message, place, record);
	case FW_sbas_service: put(message, REGION_COUNT, 3, place + 1); break;
	default: break;
	}
	return FW_OK;
}

static fw_status add(const layout *l, const void *record, uint8_t message[static FW_SBAS_BYTES])
{
	uint8_t work[FW_SBAS_BYTES];
	unsigned place;
	fw_status status = place_of(message, l, record, &place);
	if (status < 0)
		return status;
	memcpy(work, message, sizeof work);
	status = put_numbers(work, l, place, record);
	for (unsigned i = 0; i < l->n_fields && status >= 0; i++)
		status = put_field(work, l, &l->fields[i], place, record);
	if (status >= 0)
		memcpy(message, work, sizeof work);
	return status;
}

fw_status fw_sbas_begin(unsigned type, unsigned start_s, uint8_t message[static FW_SBAS_BYTES])
{
	if (type > 63)
		return FW_EINVAL;
	memset(message, 0, FW_SBAS_BYTES);
	message[0] = preamble[start_s % 3];
	put(message, TYPE_START, 6, type);
	return FW_OK;
}

fw_status fw_sbas_add(fw_kind kind, const void *record, uint8_t message[static FW_SBAS_BYTES])
{
	unsigned type = bits(message, TYPE_START, 6);
	fw_status status = FW_EINVAL;
	for (const layout *l = layouts; l < layouts + N_LAYOUTS; l++) {
		if (l->type != type || l->kind != kind)
			continue;
		fw_status here = add(l, record, message);
		if (here != FW_EINVAL)
			status = here;
		if (here != FW_EINVAL && here != FW_ENOSPACE)
			break;
	}
	return status;
}

void fw_sbas_finish(uint8_t message[static FW_SBAS_BYTES])
{
	put(message, CRC_START, 24, fw_crc24q_bits(message, 0, CRC_START));
	put(message, FW_SBAS_BITS, 6, 0);
}
