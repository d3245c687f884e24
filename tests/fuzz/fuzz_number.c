/* Numbers: text against the C library's reading of it, bit patterns through text and back. A field a line. */
#include <errno.h>
#include <math.h>
#include <string.h>

#include "formats/bytes.h"
#include "formats/number.h"

#include "text_input.h"

static const char *const words[] = {
    "1e",
    "e-",
    ".",
    "-",
    "+",
    "0",
    "00000000000000000000000000000000000000000000",
    "9007199254740993",
    "1e308",
    "e+999999",
    "17976931348623158079372897140530341507993413271003782693617377898044496829276475094664901797758720709633"
    "02864166928879109465555478519404026306574886715058206819089020007083836762738548458177115317644757302700"
    "69855571366959622842914819860834936475292719074168444365510704342711559699508093042880",
    "4.9406564584124654e-324",
    "2.4703282292062327e-324",
    "2.2250738585072011e-308",
    "340282356779733661637539395458142568448",
    "1.401298464324817e-45",
    "0x1p3",
    "inf",
    "nan",
    "9223372036854775807",
    "-9223372036854775809",
    "0.5",
    "123456789012345678901234567890",
};

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	size_t size = 0;
	for (size_t n = 1 + (size_t)fw_random_below(random, 20); n > 0; n--) {
		const uint64_t bits = fw_random_u64(random);
		double x;
		memcpy(&x, &bits, sizeof x);
		if (fw_random_below(random, 2) == 0)
			x = (fw_random_uniform(random) - 0.5) *
			    pow(10, (double)fw_random_below(random, 30) - 10);
		size += (size_t)snprintf((char *)data + size, FUZZ_ROOM - size, "%.*g\n",
		                         (int)fw_random_below(random, 25), x);
	}
	return size;
}

/* There is nothing to repair in a number; words are enough. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	return text_mutate(data, size, max, seed, words, sizeof words / sizeof *words);
}

static size_t digits(const char *s)
{
	return strspn(s, "0123456789");
}

/* The grammar of formats/number.h, on a string. */
static int is_decimal(const char *s)
{
	s += *s == '+' || *s == '-';
	const size_t before = digits(s);
	s += before;
	size_t behind = 0;
	if (*s == '.') {
		behind = digits(s + 1);
		s += 1 + behind;
	}
	if (before + behind == 0)
		return 0;
	if (*s == 'e' || *s == 'E') {
		s += s[1] == '+' || s[1] == '-' ? 2 : 1;
		if (digits(s) == 0)
			return 0;
		s += digits(s);
	}
	return *s == '\0';
}

static int is_whole(const char *s)
{
	s += *s == '+' || *s == '-';
	return digits(s) > 0 && s[digits(s)] == '\0';
}

static void check_text(const char *s, size_t n)
{
	const int decimal = n <= FW_NUMBER_TEXT_MAX && strlen(s) == n && is_decimal(s);
	const int whole = n <= FW_NUMBER_TEXT_MAX && strlen(s) == n && is_whole(s);
	double d = 7;
	float f = 7;
	int64_t i = 7;

	fw_status status = fw_get_double(s, n, &d);
	const double expected_d = strtod(s, NULL);
	require(status == (!decimal ? FW_ESYNTAX : isinf(expected_d) ? FW_ERANGE : FW_OK));
	require(status == FW_OK ? memcmp(&d, &expected_d, sizeof d) == 0 : d == 7);

	status = fw_get_float(s, n, &f);
	const float expected_f = strtof(s, NULL);
	require(status == (!decimal ? FW_ESYNTAX : isinf(expected_f) ? FW_ERANGE : FW_OK));
	require(status == FW_OK ? memcmp(&f, &expected_f, sizeof f) == 0 : f == 7);

	status = fw_get_i64(s, n, &i);
	errno = 0;
	const int64_t expected_i = strtoll(s, NULL, 10);
	require(status == (!whole ? FW_ESYNTAX : errno == ERANGE ? FW_ERANGE : FW_OK));
	require(i == (status == FW_OK ? expected_i : 7));
}

static void check_fixed(double x, int decimals)
{
	char text[FW_FIXED_ROOM], expected[400];
	const size_t n = (size_t)(fw_put_fixed(text, x, decimals) - text);
	snprintf(expected, sizeof expected, "%.*f", decimals, x);
	const char *e = expected;
	if (*e == '-' && strspn(e + 1, "0.") == strlen(e + 1))
		e++; /* a zero has no sign */
	require(n == strlen(e) && memcmp(text, e, n) == 0);
}

static void check_bits(const uint8_t *p)
{
	char text[FW_SHORTEST_ROOM];
	const double x = fw_load_f64(p);
	const float y = fw_load_f32(p);
	double d;
	float f;

	if (isfinite(x)) {
		require(fw_get_double(text, (size_t)(fw_put_double(text, x) - text), &d) == FW_OK && d == x);
		check_fixed(x, p[0] % (FW_FIXED_DECIMALS_MAX + 1));
	}
	if (isfinite(y))
		require(fw_get_float(text, (size_t)(fw_put_float(text, y) - text), &f) == FW_OK && f == y);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static char field[FUZZ_ROOM + 1];
	for (size_t at = 0; at < size;) {
		const uint8_t *end = memchr(data + at, '\n', size - at);
		size_t n = end != NULL ? (size_t)(end - (data + at)) : size - at;
		if (n > FUZZ_ROOM)
			n = FUZZ_ROOM;
		memcpy(field, data + at, n);
		field[n] = '\0';
		check_text(field, n);
		if (n >= 8)
			check_bits(data + at);
		at += n + 1;
	}
	return 0;
}
