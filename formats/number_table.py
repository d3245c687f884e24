#!/usr/bin/env python3
"""Writes number_table.h: python3 formats/number_table.py > formats/number_table.h

Entry k is g(k) = ceil(10^k / 2^(floor(log2(10^k)) - 127)), so 2^127 <= g(k) < 2^128: the first 128 bits
of 10^k, rounded up, exact for 0 <= k <= 55. Integers only, hence no rounding of Python's own.
"""

FIRST, LAST = -292, 324  # what the shortest text of any double asks for

print(f"""/* The first 128 bits of the powers of ten from 10^{FIRST} to 10^{LAST}, rounded up.
 * Made by number_table.py, which says how; do not edit. */
#ifndef FURROW_FORMATS_NUMBER_TABLE_H
#define FURROW_FORMATS_NUMBER_TABLE_H

#include <stdint.h>

enum {{ POWER_FIRST = {FIRST}, POWER_LAST = {LAST} }};

struct power {{
	uint64_t high, low;
}};

/* clang-format off */
static const struct power powers_of_ten[POWER_LAST - POWER_FIRST + 1] = {{""")

for k in range(FIRST, LAST + 1):
    top, bottom = 10 ** max(k, 0), 10 ** max(-k, 0)
    shift = 0
    while (top << shift if shift >= 0 else top >> -shift) < bottom << 127:
        shift += 1
    while (top << shift if shift >= 0 else top >> -shift) >= bottom << 128:
        shift -= 1
    top, bottom = top << max(shift, 0), bottom << max(-shift, 0)
    g = -(-top // bottom)
    assert 1 << 127 <= g < 1 << 128
    assert (g & (1 << 64) - 1 != 0) == (0 > k or k > 27)  # the 64-bit table is high + (low != 0)
    print(f"\t{{ 0x{g >> 64:016x}, 0x{g & (1 << 64) - 1:016x} }}, /* {k} */")

print("""};
/* clang-format on */

#endif""")
