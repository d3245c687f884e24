/* Numbers to text and back: exact, locale-free and quick, for tables of millions of rows.
 *
 * Writers append to the caller's text: they write at p, return the new end and set no NUL. They work in
 * strides of 8 and 16 bytes, so bytes behind the returned end may be overwritten: p must have the whole
 * room that is documented with each writer, whatever the number.
 *
 * Readers take a field of n bytes that must be a number as a whole: [+-] digits [. digits] [(e|E) [+-]
 * digits] with a digit before or behind the point. No blanks, no hexadecimal, no "inf", no "nan".
 *
 * Needs a compiler with unsigned __int128 (gcc and clang on 64-bit machines).
 * Tested by tests/unit/test_number.c; tests/bench/bench_number.c says what each call costs. */
#ifndef FURROW_FORMATS_NUMBER_H
#define FURROW_FORMATS_NUMBER_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

enum {
	FW_INTEGER_ROOM = 24,  /* bytes for fw_put_u64 and fw_put_i64; their text is <= 20 long */
	FW_SHORTEST_ROOM = 40, /* bytes for fw_put_float (text <= 16) and fw_put_double (text <= 24) */
	FW_FIXED_ROOM = 344,   /* bytes for fw_put_fixed and fw_put_fixed_trim; their text is <= 326 long, and
	                        * <= 18 for |x| < 10^(16 - decimals), where 40 bytes are room enough */
	FW_FIXED_DECIMALS_MAX = 15,
	FW_NUMBER_TEXT_MAX = 400 /* longest field that a reader accepts [bytes] */
};

/* Appends a whole number in decimal, without leading zeros.
 *   p      out  FW_INTEGER_ROOM bytes
 *   value  in   any
 * Returns the end of the text. */
char *fw_put_u64(char *p, uint64_t value);
char *fw_put_i64(char *p, int64_t value);

/* Appends x in fixed notation with a given number of decimals, as printf("%.*f") does, for every finite x:
 * rounded exactly, ties to even. Only a zero has no sign: "0.000" where printf says "-0.000".
 *   p         out  FW_FIXED_ROOM bytes
 *   x         in   finite; anything else is the caller's error and writes nothing
 *   decimals  in   0..FW_FIXED_DECIMALS_MAX; with 0 there is no point
 * Returns the end of the text.
 * Quick for |x| < 10^(16 - decimals); anything larger is only right. */
char *fw_put_fixed(char *p, double x, int decimals);

/* fw_put_fixed without the zeros at the end of the fraction, and without a bare point:
 * 482321 with 9 decimals is "482321", 0.2 is "0.2". Same arguments, same rounding. */
char *fw_put_fixed_trim(char *p, double x, int decimals);

/* Append the shortest decimal text that reads back as exactly x; of several, the one nearest to x.
 *   p  out  FW_SHORTEST_ROOM bytes
 *   x  in   finite; anything else is the caller's error and writes nothing
 * Plain notation for 1e-5 <= |x| < 1e15 ("0.00012", "131.185965425466", "7"), otherwise "1.5e-08" with two
 * digits or more in the exponent. Both zeros are "0".
 * "Reads back" means: as a float for fw_put_float (0.1f is "0.1"), as a double for fw_put_double.
 * Returns the end of the text.
 * Source: R. Giulietti, The Schubfach way to render doubles, 2021. */
char *fw_put_float(char *p, float x);
char *fw_put_double(char *p, double x);

/* Reads the double that is nearest to the decimal number in a field (ties to even), as strtod does.
 *   s  in   text, need not end in NUL
 *   n  in   its length [bytes]
 *   x  out  the number; a number too small for a double gives a zero
 * Returns FW_OK; FW_ESYNTAX (not a number as a whole, or n > FW_NUMBER_TEXT_MAX); FW_ERANGE (too large for
 * a double). On failure x is untouched.
 * Quick for <= 19 digits, leading zeros included. */
FW_MUST_CHECK fw_status fw_get_double(const char *s, size_t n, double *x);

/* The same, rounded once and to the nearest float. FW_ERANGE: too large for a float. */
FW_MUST_CHECK fw_status fw_get_float(const char *s, size_t n, float *x);

/* Reads a whole number: [+-] digits, nothing else.
 * Returns FW_OK; FW_ESYNTAX as above; FW_ERANGE (does not fit int64_t). On failure x is untouched. */
FW_MUST_CHECK fw_status fw_get_i64(const char *s, size_t n, int64_t *x);

#endif
