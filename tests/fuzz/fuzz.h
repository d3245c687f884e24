/* Fuzzing: what each harness fuzz_NAME.c in this folder consists of. libFuzzer runs them (make fuzz), and so does
 * driver.c with the sanitizers of gcc (make check).
 *
 * An input that fails goes to corpus/fuzz_NAME/ before the fix; everything in there is run first, every time. */
#ifndef FURROW_TESTS_FUZZ_H
#define FURROW_TESTS_FUZZ_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/random.h"

enum { FUZZ_ROOM = 8192 }; /* longest input that is made or mutated */

/* Takes one input to pieces. Fails by a sanitizer or by require(). Returns 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Changes an input; when the seed is odd it then puts lengths and checksums right, so that the change gets past them.
 * Returns the new size. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed);

/* Writes a valid input, at most FUZZ_ROOM bytes: where mutations begin. Returns its size. */
size_t fuzz_make(fw_random *random, uint8_t *data);

/* Changes a few bytes without knowing what they mean. Of libFuzzer, or of driver.c. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max);

/* What must hold whatever the input is. */
#define require(condition)                                                                                   \
	do {                                                                                                 \
		if (!(condition)) {                                                                          \
			dprintf(2, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                   \
			abort();                                                                             \
		}                                                                                            \
	} while (0)

#endif
