/* Random numbers for simulation and tests: one seed gives one sequence, to the last bit, on every platform.
 *
 * Generator: xoshiro256++ 1.0, seeded through SplitMix64. Source: D. Blackman and S. Vigna, "Scrambled linear
 * pseudorandom number generators", ACM Trans. Math. Softw. 47 (2021), and https://prng.di.unimi.it. Period
 * 2^256 - 1. Not for secrets. Nothing here can fail. */
#ifndef FURROW_BASE_RANDOM_H
#define FURROW_BASE_RANDOM_H

#include <stdint.h>

/* The whole state; a copy of it continues the same sequence. Not all zero. */
typedef struct {
	uint64_t s[4];
} fw_random;

/* Starts the sequence of a seed; every seed, 0 among them, is a good one. */
void fw_random_init(fw_random *r, uint64_t seed);

/* The next 64 random bits. */
uint64_t fw_random_u64(fw_random *r);

/* Uniform in [0, 1): one of the 2^53 multiples of 2^-53. */
double fw_random_uniform(fw_random *r);

/* An integer 0..n-1, each equally likely (no bias of the remainder). n >= 1. */
uint64_t fw_random_below(fw_random *r, uint64_t n);

/* A deviate of the normal distribution with mean 0 and standard deviation 1.
 * Source: G. Marsaglia and T. A. Bray, "A convenient method for generating normal variables", SIAM Review 6
 * (1964); only one deviate of each pair is used, so that the state is the generator's alone. */
double fw_random_normal(fw_random *r);

#endif
