/* GPS LNAV subframes for testdata/demo.sbf. Source: IS-GPS-200N, 20.3.3 and 20.3.5. */
#ifndef FURROW_TESTS_DEMO_LNAV_H
#define FURROW_TESTS_DEMO_LNAV_H

#include <stdint.h>

#include "demo_scene.h"

enum { LNAV_WORDS = 10, LNAV_IODE = 85 };

/* Subframe 1, 2 or 3 of a satellite that ends at GPS time of week end_s, as GPSRawCA stores it: ten words, each
 * right-aligned with its parity, inverted as a whole after a word that ended in 1. */
void lnav_subframe(const scene_satellite *satellite, unsigned id, unsigned end_s,
                   uint32_t words[static LNAV_WORDS]);

#endif
