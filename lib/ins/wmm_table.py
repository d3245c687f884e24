#!/usr/bin/env python3
"""Writes wmm_table.h: python3 lib/ins/wmm_table.py WMM_2025.COF > lib/ins/wmm_table.h

The file is the coefficient file that NOAA and the British Geological Survey publish (public domain); PyPI's pygeomag
carries it as pygeomag/wmm/WMM_2025.COF. Its first line has epoch, name and date of issue; then come n, m, g, h and their
changes per year.
"""

import sys

lines = open(sys.argv[1], encoding="ascii").read().splitlines()
epoch, name, issued = lines[0].split()
rows = [line.split() for line in lines[1:] if not line.startswith("9999")]
degree = max(int(row[0]) for row in rows)
assert [(int(row[0]), int(row[1])) for row in rows] == [(n, m) for n in range(1, degree + 1) for m in range(n + 1)]

print(f"""/* Coefficients of {name}, issued {issued}: Schmidt semi-normalised, reference radius 6371.2 km.
 * Made by wmm_table.py from NOAA's coefficient file (public domain); do not edit. */
#ifndef FURROW_INS_WMM_TABLE_H
#define FURROW_INS_WMM_TABLE_H

enum {{ WMM_DEGREE = {degree}, WMM_TERMS = {len(rows)} }};

/* Valid from the epoch for five years [year]. */
#define WMM_EPOCH {float(epoch)}
#define WMM_END   {float(epoch) + 5}

/* g and h [nT], and their changes [nT/year]; n = 1..{degree}, m = 0..n in this order. */
struct wmm_term {{
	double g, h, g_per_year, h_per_year;
}};

/* clang-format off */
static const struct wmm_term wmm_terms[WMM_TERMS] = {{""")
for n, m, g, h, g_dot, h_dot in rows:
    print(f"\t{{{', '.join(repr(float(x)) for x in (g, h, g_dot, h_dot))}}}, /* {n} {m} */")
print("""};
/* clang-format on */

#endif""")
