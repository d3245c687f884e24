#include "formats/number.h"

#include <assert.h>
#include <endian.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/number_table.h"

__extension__ typedef unsigned __int128 u128;

#define TEN8  UINT64_C(100000000)
#define TEN16 UINT64_C(10000000000000000)

static const uint64_t ten_to[] = {
    UINT64_C(1),
    UINT64_C(10),
    UINT64_C(100),
    UINT64_C(1000),
    UINT64_C(10000),
    UINT64_C(100000),
    UINT64_C(1000000),
    UINT64_C(10000000),
    UINT64_C(100000000),
    UINT64_C(1000000000),
    UINT64_C(10000000000),
    UINT64_C(100000000000),
    UINT64_C(1000000000000),
    UINT64_C(10000000000000),
    UINT64_C(100000000000000),
    UINT64_C(1000000000000000),
    UINT64_C(10000000000000000),
    UINT64_C(100000000000000000),
};

/* ---- Digits -------------------------------------------------------------------------------------------
 *
 * Digits live in registers, one per byte, the first (leftmost) one in the lowest byte. Shifting right by
 * 8 bits drops a leading digit, counting zero bits counts zero digits, and one store writes 8 or 16 of
 * them: no loop, and hardly a branch that depends on the number. */

/* The digits of value < 10^8. Each step splits all lanes in two at once, by a multiplication with the
 * rounded-up inverse of 10^4, 100 and 10, exact in the range at hand. */
static inline uint64_t eight_digits(uint64_t value)
{
	uint64_t quotient = value * 109951163 >> 40;
	uint64_t fours = quotient + ((value - 10000 * quotient) << 32);

	quotient = (fours * 10486 >> 20) & UINT64_C(0x0000007f0000007f);
	uint64_t twos = quotient + ((fours - 100 * quotient) << 16);

	quotient = (twos * 103 >> 10) & UINT64_C(0x000f000f000f000f);
	return quotient + ((twos - 10 * quotient) << 8);
}

/* The digits of value < 10^16. */
static inline u128 sixteen_digits(uint64_t value)
{
	uint64_t high = value / TEN8;

	return (u128)eight_digits(value - TEN8 * high) << 64 | eight_digits(high);
}

/* How many zeros lead, 0..15: the last digit counts as one even if it is 0. */
static inline int leading_zeros(u128 digits)
{
	uint64_t low = (uint64_t)digits, high = (uint64_t)(digits >> 64) | UINT64_C(1) << 63;

	return (low ? __builtin_ctzll(low) : 64 + __builtin_ctzll(high)) >> 3;
}

/* How many digits remain without the zeros at the end, 0..16. */
static inline int significant(u128 digits)
{
	uint64_t low = (uint64_t)digits, high = (uint64_t)(digits >> 64);
	int bits = high ? 128 - __builtin_clzll(high) : low ? 64 - __builtin_clzll(low) : 0;

	return (bits + 7) >> 3;
}

static inline void store_8(char *p, uint64_t digits)
{
	uint64_t text = htole64(digits + UINT64_C(0x3030303030303030));

	memcpy(p, &text, sizeof text);
}

static inline void store_16(char *p, u128 digits)
{
	store_8(p, (uint64_t)digits);
	store_8(p + 8, (uint64_t)(digits >> 64));
}

/* Writes '-' or leaves it to be overwritten. */
static inline char *put_sign(char *p, bool negative)
{
	*p = '-';
	return p + negative;
}

/* ---- Whole numbers ------------------------------------------------------------------------------------ */

/* value < 10^16 */
static inline char *put_whole(char *p, uint64_t value)
{
	if (value < 10) { /* flags and counts */
		*p = (char)('0' + value);
		return p + 1;
	}
	if (value < TEN8) { /* most are */
		uint64_t eight = eight_digits(value);
		int zeros = __builtin_ctzll(eight | UINT64_C(1) << 63) >> 3;
		store_8(p, eight >> 8 * zeros);
		return p + 8 - zeros;
	}
	u128 digits = sixteen_digits(value);
	int skip = leading_zeros(digits);

	store_16(p, digits >> 8 * skip);
	return p + 16 - skip;
}

char *fw_put_u64(char *p, uint64_t value)
{
	if (value < TEN16)
		return put_whole(p, value);
	p = put_whole(p, value / TEN16);
	store_16(p, sixteen_digits(value % TEN16));
	return p + 16;
}

char *fw_put_i64(char *p, int64_t value)
{
	bool negative = value < 0;
	uint64_t magnitude = (uint64_t)value;

	p = put_sign(p, negative);
	return fw_put_u64(p, negative ? -magnitude : magnitude);
}

/* ---- Fixed notation ----------------------------------------------------------------------------------- */

/* Appends scaled / 10^decimals, scaled < 10^8, 0 < decimals < 8: as below, in half the registers. */
static inline char *put_scaled_small(char *p, uint64_t scaled, int decimals)
{
	uint64_t digits = eight_digits(scaled);
	int point = 8 - decimals;
	int skip = __builtin_ctzll(digits | UINT64_C(1) << 63) >> 3;

	if (skip > point - 1)
		skip = point - 1;
	store_8(p, digits >> 8 * skip);
	p += point - skip;
	*p++ = '.';
	store_8(p, digits >> 8 * point);
	return p + decimals;
}

/* Appends scaled / 10^decimals, scaled < 10^16: the digits twice, shifted so that the part before the point
 * and the part behind it come to lie where they belong. */
static inline char *put_scaled(char *p, uint64_t scaled, int decimals, bool trim)
{
	if (scaled < TEN8 && !trim && 0 < decimals && decimals < 8)
		return put_scaled_small(p, scaled, decimals);
	u128 digits = sixteen_digits(scaled);
	int point = 16 - decimals;
	int skip = leading_zeros(digits);
	int fraction = decimals;

	if (skip > point - 1)
		skip = point - 1;
	if (trim)
		fraction = significant(digits) - point;

	store_16(p, digits >> 8 * skip);
	p += point - skip;
	if (fraction <= 0)
		return p;
	*p++ = '.';
	store_16(p, digits >> 8 * point);
	return p + fraction;
}

/* x 10^decimals < 10^16, x >= 0, rounded to the nearest integer, ties to even. Exact: the factors, 53 bits
 * and a power of ten, are shifted so that their product has its binary point in the middle of 128 bits. For
 * x < 1 the product must go down to get there; what falls off at the end leaves a one behind. */
static inline uint64_t scale(double x, int decimals)
{
	uint64_t bits;
	memcpy(&bits, &x, sizeof bits);
	uint64_t significand = bits << 11 | UINT64_C(1) << 63;
	int exponent = (int)(bits >> 52) - 1022;
	int up = exponent > 0 ? exponent : 0, down = exponent < 0 ? -exponent : 0;

	if (exponent < -60) /* also zeros and denormals, which lack the leading one */
		return 0;
	u128 product = (u128)significand * (ten_to[decimals] << up);
	bool lost = (uint64_t)product & ((UINT64_C(1) << down) - 1);
	product = product >> down | lost;
	bool odd = product >> 64 & 1;
	return (uint64_t)((product + (UINT64_C(1) << 63) - 1 + odd) >> 64);
}

/* x 10^decimals >= 10^16. The whole part and the fraction go separately; the fraction cannot round up to 1,
 * because a step of x is then worth more than a unit of the last decimal. */
static __attribute__((noinline)) char *put_large(char *p, double x, int decimals, bool trim)
{
	char *end = x < 0x1p63 ? fw_put_u64(p, (uint64_t)x) : p + snprintf(p, FW_FIXED_ROOM - 1, "%.0f", x);
	char unit = end[-1];
	char *last = put_scaled(end - 1, scale(x - floor(x), decimals), decimals, trim);

	end[-1] = unit; /* where put_scaled had its "0" */
	return last;
}

static inline char *put_fixed(char *p, double x, int decimals, bool trim)
{
	assert(isfinite(x) && 0 <= decimals && decimals <= FW_FIXED_DECIMALS_MAX);
	double magnitude = fabs(x);

	if (magnitude == 0) { /* corrections that were not needed */
		memcpy(p, "0.00000000000000000000000", 24);
		return p + (trim || decimals == 0 ? 1 : 2 + decimals);
	}
	if (!(magnitude < (double)(int64_t)ten_to[16 - decimals]))
		return isfinite(x) ? put_large(put_sign(p, x < 0), magnitude, decimals, trim) : p;
	uint64_t scaled = scale(magnitude, decimals);
	p = put_sign(p, x < 0 && scaled != 0);
	return put_scaled(p, scaled, decimals, trim);
}

char *fw_put_fixed(char *p, double x, int decimals)
{
	return put_fixed(p, x, decimals, false);
}

char *fw_put_fixed_trim(char *p, double x, int decimals)
{
	return put_fixed(p, x, decimals, true);
}

/* ---- Shortest text ------------------------------------------------------------------------------------
 *
 * Schubfach. All reals between the midpoints to the neighbours of x = c 2^q read back as x. With
 * k = floor(log10(width of that interval)) the interval holds a multiple of 10^k, and at most one of
 * 10^(k+1). So: scale the three numbers (lower midpoint, x, upper midpoint) by 4 / 10^k, and see which of
 * the multiples next to x are inside. The scaled numbers are rounded to odd: the last bit says "and
 * something", which makes the comparisons exact (section 9 of the paper). */

/* floor(log2(10^e)), |e| <= 1233 */
static inline int floor_log2_ten_to(int e)
{
	return e * 1741647 >> 19;
}

/* k of the interval around c 2^q; the lower half of it is only half as wide if c is a power of two. */
static inline int floor_log10_width(int q, bool narrow)
{
	return (q * 1262611 - (narrow ? 524031 : 0)) >> 22;
}

/* g / 2^127 cp, rounded to odd */
static inline uint64_t scale_to_odd(struct power g, uint64_t cp)
{
	u128 product = (u128)g.high * cp + (uint64_t)((u128)g.low * cp >> 64);

	return (uint64_t)(product >> 64) | ((uint64_t)product > 1);
}

/* The same for a float's short cp and the first 64 bits of g. */
static inline uint64_t scale_to_odd_64(uint64_t g, uint64_t cp)
{
	u128 product = (u128)g * cp;

	return (uint64_t)(product >> 64) | ((uint32_t)(product >> 32) > 1);
}

/* The integer (of units 10^k) inside lower..upper that has a zero at its end if there is one, otherwise the
 * one nearest to x. Arguments in quarters of a unit. Which it is cannot be predicted: hence no branches. */
static inline uint64_t nearest_short(uint64_t lower, uint64_t x, uint64_t upper)
{
	uint64_t unit = x / 4, ten = unit / 10 * 10;
	bool unit_inside = lower <= 4 * unit, next_unit_inside = 4 * unit + 4 <= upper;
	bool ten_inside = lower <= 4 * ten, next_ten_inside = 4 * ten + 40 <= upper;
	bool next_nearer = x % 4 + (unit & 1) > 2; /* above the middle, or on it and unit odd */

	unit += next_unit_inside & (next_nearer | !unit_inside);
	ten += next_ten_inside ? 10 : 0;
	return unit + (ten_inside | next_ten_inside) * (ten - unit);
}

static inline int count_digits(uint64_t value)
{
	int guess = (64 - __builtin_clzll(value)) * 1233 >> 12;

	return guess + (value >= ten_to[guess]);
}

/* Appends the number d.ddd 10^exponent whose first digit is `first` and the others are `rest`. */
static inline char *put_digits(char *p, uint64_t first, u128 rest, int exponent)
{
	int n = significant(rest);

	if (0 <= exponent && exponent < 15) { /* ddd.ddd */
		*p = (char)('0' + first);
		store_16(p + 1, rest);
		p += 1 + exponent;
		if (n <= exponent)
			return p;
		*p++ = '.';
		store_16(p, rest >> 8 * exponent);
		return p + n - exponent;
	}
	if (-5 <= exponent && exponent < 0) { /* 0.00ddd */
		memcpy(p, "0.000000", 8);
		p += 1 - exponent;
		*p++ = (char)('0' + first);
		store_16(p, rest);
		return p + n;
	}
	*p++ = (char)('0' + first);
	*p = '.';
	store_16(p + 1, rest);
	p += n ? 1 + n : 0;
	*p++ = 'e';
	*p++ = exponent < 0 ? '-' : '+';
	exponent = abs(exponent);
	if (exponent < 10)
		*p++ = '0';
	return put_whole(p, (uint64_t)exponent);
}

/* s 10^k, 0 < s < 10^17 */
static inline char *put_shortest_double(char *p, uint64_t s, int k)
{
	int length = count_digits(s);
	uint64_t full = s * ten_to[17 - length], first = full / TEN16;

	return put_digits(p, first, sixteen_digits(full - TEN16 * first), k + length - 1);
}

/* s 10^k, 0 < s < 10^9 */
static inline char *put_shortest_float(char *p, uint64_t s, int k)
{
	int length = count_digits(s);
	uint64_t full = s * ten_to[9 - length], first = full / TEN8;

	return put_digits(p, first, eight_digits(full - TEN8 * first), k + length - 1);
}

char *fw_put_double(char *p, double x)
{
	uint64_t bits;
	memcpy(&bits, &x, sizeof bits);
	int exponent = (int)(bits >> 52 & 0x7ff);
	uint64_t fraction = bits & ((UINT64_C(1) << 52) - 1);

	assert(exponent != 0x7ff);
	if (exponent == 0x7ff)
		return p;
	p = put_sign(p, x < 0);
	if (fabs(x) < 0x1p53 && (double)(int64_t)x == x)
		return x != 0 ? put_shortest_double(p, (uint64_t)fabs(x), 0) : put_whole(p, 0);

	uint64_t c = fraction | (uint64_t)(exponent != 0) << 52;
	int q = (exponent ? exponent : 1) - 1075;
	bool narrow = fraction == 0 && exponent > 1, odd = c & 1;
	int k = floor_log10_width(q, narrow);
	int h = q + floor_log2_ten_to(-k) + 1;
	struct power g = powers_of_ten[-k - POWER_FIRST];
	uint64_t lower = scale_to_odd(g, (4 * c - 2 + narrow) << h);
	uint64_t middle = scale_to_odd(g, 4 * c << h);
	uint64_t upper = scale_to_odd(g, (4 * c + 2) << h);

	/* A midpoint itself reads back as the neighbour whose c is even. */
	return put_shortest_double(p, nearest_short(lower + odd, middle, upper - odd), k);
}

char *fw_put_float(char *p, float x)
{
	uint32_t bits;
	memcpy(&bits, &x, sizeof bits);
	int exponent = (int)(bits >> 23 & 0xff);
	uint32_t fraction = bits & ((UINT32_C(1) << 23) - 1);

	assert(exponent != 0xff);
	if (exponent == 0xff)
		return p;
	p = put_sign(p, x < 0);
	if (fabsf(x) < 0x1p24F && (float)(int32_t)x == x)
		return x != 0 ? put_shortest_float(p, (uint64_t)fabsf(x), 0) : put_whole(p, 0);

	uint64_t c = fraction | (uint32_t)(exponent != 0) << 23;
	int q = (exponent ? exponent : 1) - 150;
	bool narrow = fraction == 0 && exponent > 1, odd = c & 1;
	int k = floor_log10_width(q, narrow);
	int h = q + floor_log2_ten_to(-k) + 1;
	struct power wide = powers_of_ten[-k - POWER_FIRST];
	uint64_t g = wide.high + (wide.low != 0); /* rounded up, as the table is */
	uint64_t lower = scale_to_odd_64(g, (4 * c - 2 + narrow) << h);
	uint64_t middle = scale_to_odd_64(g, 4 * c << h);
	uint64_t upper = scale_to_odd_64(g, (4 * c + 2) << h);

	return put_shortest_float(p, nearest_short(lower + odd, middle, upper - odd), k);
}

/* ---- Text to numbers ---------------------------------------------------------------------------------- */

/* A field taken apart: the digits without the point are `digits` (right if there are <= 19 of them), and the
 * number is digits 10^exponent. */
struct parts {
	const char *text, *mantissa, *mantissa_end;
	uint64_t digits;
	int n_digits;
	int exponent;
	bool negative;
};

enum { DIGITS_THAT_FIT = 19, EXPONENT_ENOUGH = 99999 };

/* Appends digits to *value (modulo 2^64) up to the first byte that is none, and returns where that is. */
static inline const char *get_digits(const char *s, const char *end, uint64_t *value)
{
	uint64_t v = *value;

	for (; s < end && (unsigned char)(*s - '0') < 10; s++)
		v = 10 * v + (unsigned char)(*s - '0');
	*value = v;
	return s;
}

/* The exponent behind an 'e', up to the end of the field. Beyond EXPONENT_ENOUGH more digits say nothing
 * new: a field is too short to make up for it. */
static bool get_exponent(const char *s, const char *end, int *exponent)
{
	int e = 0;
	bool negative = s < end && *s == '-';

	s += s < end && (*s == '-' || *s == '+');
	if (s == end)
		return false;
	for (; s < end; s++) {
		if (!((unsigned char)(*s - '0') < 10))
			return false;
		if (e < EXPONENT_ENOUGH)
			e = 10 * e + (*s - '0');
	}
	*exponent += negative ? -e : e;
	return true;
}

static inline fw_status take_apart(const char *s, size_t n, struct parts *parts)
{
	const char *end = s + n, *point;

	if (!(0 < n && n <= FW_NUMBER_TEXT_MAX))
		return FW_ESYNTAX;
	*parts = (struct parts){.text = s, .negative = *s == '-'};
	s += *s == '-' || *s == '+';
	parts->mantissa = s;
	point = s = get_digits(s, end, &parts->digits);
	if (s < end && *s == '.') {
		s = get_digits(s + 1, end, &parts->digits);
		parts->exponent = (int)(point + 1 - s);
		parts->n_digits = -1; /* the point is none */
	}
	parts->mantissa_end = s;
	parts->n_digits += (int)(s - parts->mantissa);
	if (parts->n_digits <= 0)
		return FW_ESYNTAX;
	if (s == end)
		return FW_OK;
	return (*s == 'e' || *s == 'E') && get_exponent(s + 1, end, &parts->exponent) ? FW_OK : FW_ESYNTAX;
}

/* The field as "[-]digits e exponent" for strtod and strtof: without a point no locale can disturb them. */
enum { PLAIN_ROOM = FW_NUMBER_TEXT_MAX + 16 };
static void write_plain(const struct parts *parts, char text[static PLAIN_ROOM])
{
	char *p = put_sign(text, parts->negative);

	for (const char *s = parts->mantissa; s < parts->mantissa_end; s++)
		if (*s != '.')
			*p++ = *s;
	snprintf(p, (size_t)(text + PLAIN_ROOM - p), "e%d", parts->exponent);
}

/* digits 10^exponent, digits > 0, rounded to the nearest double; false where this cannot tell.
 * The product with g, shifted to 128 bits, is less than 2 of its units away from the truth, on either side
 * (g is rounded up, the product down). 53 of these bits are kept; unless the other 75 are that close to the
 * middle, where the rounding turns, the truth rounds to the same double. */
static bool round_product(uint64_t digits, int exponent, double *x)
{
	if (!(POWER_FIRST <= exponent && exponent <= POWER_LAST))
		return false;
	struct power g = powers_of_ten[exponent - POWER_FIRST];
	int up = __builtin_clzll(digits);
	u128 product = (u128)g.high * (digits << up) + (uint64_t)((u128)g.low * (digits << up) >> 64);
	int short_by = product >> 127 ? 0 : 1;
	u128 raised = (product << short_by) + ((u128)1 << 74); /* may carry out of bit 127 */
	bool carry = raised < (u128)1 << 74;
	u128 dropped = (raised + 2) & (((u128)1 << 75) - 1);
	int biased = 1075 + 12 + floor_log2_ten_to(exponent) - up - short_by;

	if (dropped <= 4 || !(1 <= biased && biased < 2046))
		return false;
	/* The leading one of the significand adds 1 to the exponent field. */
	uint64_t significand = (uint64_t)(raised >> 75) + ((uint64_t)carry << 53);
	uint64_t bits = ((uint64_t)(biased - 1) << 52) + significand;
	memcpy(x, &bits, sizeof bits);
	return true;
}

/* The magnitude if that is quick. Up to 2^53 and 10^22 both operands are doubles, so that the one operation
 * is the one rounding (Clinger 1990). */
static inline bool get_quickly(const struct parts *parts, double *x)
{
	static const double ten_to_double[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
	                                       1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
	                                       1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
	int e = parts->exponent;

	if (parts->n_digits > DIGITS_THAT_FIT)
		return false;
	if (parts->digits > UINT64_C(1) << 53 || abs(e) > 22)
		return parts->digits != 0 && round_product(parts->digits, e, x);
	*x = (double)(int64_t)parts->digits;
	*x = e < 0 ? *x / ten_to_double[-e] : *x * ten_to_double[e];
	return true;
}

static double get_slowly(const struct parts *parts)
{
	char text[PLAIN_ROOM];

	write_plain(parts, text);
	return strtod(text, NULL);
}

fw_status fw_get_double(const char *s, size_t n, double *x)
{
	struct parts parts;
	double value;
	fw_status status = take_apart(s, n, &parts);

	if (status != FW_OK)
		return status;
	if (get_quickly(&parts, &value))
		value = parts.negative ? -value : value;
	else
		value = get_slowly(&parts);
	if (!isfinite(value))
		return FW_ERANGE;
	*x = value;
	return FW_OK;
}

/* Rounding to double first is harmless unless that double lies in the middle between two floats. */
static inline bool rounds_twice(double x)
{
	uint64_t bits;

	memcpy(&bits, &x, sizeof bits);
	return (bits & 0x1fffffff) == 0x10000000 || fabs(x) < (double)FLT_MIN;
}

fw_status fw_get_float(const char *s, size_t n, float *x)
{
	struct parts parts;
	double value;
	float narrow;
	char text[PLAIN_ROOM];
	fw_status status = take_apart(s, n, &parts);

	if (status != FW_OK)
		return status;
	if (get_quickly(&parts, &value) && !rounds_twice(value)) {
		narrow = (float)(parts.negative ? -value : value);
	} else {
		write_plain(&parts, text);
		narrow = strtof(text, NULL);
	}
	if (!isfinite(narrow))
		return FW_ERANGE;
	*x = narrow;
	return FW_OK;
}

fw_status fw_get_i64(const char *s, size_t n, int64_t *x)
{
	const char *end = s + n;
	bool negative = n > 0 && *s == '-', overflow = false;
	int64_t value = 0;

	if (n > FW_NUMBER_TEXT_MAX)
		return FW_ESYNTAX;
	s += n > 0 && (*s == '-' || *s == '+');
	if (s == end)
		return FW_ESYNTAX;
	for (; s < end; s++) {
		int digit = *s - '0';
		if (!(0 <= digit && digit < 10))
			return FW_ESYNTAX;
		overflow |= __builtin_mul_overflow(value, 10, &value);
		overflow |= __builtin_sub_overflow(value, digit, &value); /* downwards: INT64_MIN fits */
	}
	if (overflow || (!negative && value == INT64_MIN))
		return FW_ERANGE;
	*x = negative ? value : -value;
	return FW_OK;
}
