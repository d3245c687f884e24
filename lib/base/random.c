#include "base/random.h"

#include <assert.h>
#include <math.h>

static uint64_t splitmix64(uint64_t *x)
{
	uint64_t z = *x += UINT64_C(0x9e3779b97f4a7c15);

	z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
	z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
	return z ^ (z >> 31);
}

void fw_random_init(fw_random *r, uint64_t seed)
{
	for (int i = 0; i < 4; i++)
		r->s[i] = splitmix64(&seed);
}

static uint64_t rotate_left(uint64_t x, int k)
{
	return (x << k) | (x >> (64 - k));
}

uint64_t fw_random_u64(fw_random *r)
{
	uint64_t *s = r->s;
	uint64_t result = rotate_left(s[0] + s[3], 23) + s[0];
	uint64_t t = s[1] << 17;

	s[2] ^= s[0];
	s[3] ^= s[1];
	s[1] ^= s[2];
	s[0] ^= s[3];
	s[2] ^= t;
	s[3] = rotate_left(s[3], 45);
	return result;
}

double fw_random_uniform(fw_random *r)
{
	return (double)(fw_random_u64(r) >> 11) * 0x1p-53;
}

uint64_t fw_random_below(fw_random *r, uint64_t n)
{
	uint64_t spare, x;

	assert(n > 0);
	/* 2^64 mod n values at the bottom are surplus; without them every remainder is met equally often. */
	spare = -n % n;
	do {
		x = fw_random_u64(r);
	} while (x < spare);
	return x % n;
}

/* ln x, x > 0, from operations that IEEE 754 fixes to the last bit: libm's log differs between machines.
 * x = m 2^e, m in [sqrt(1/2), sqrt(2)); ln m = 2 artanh z, z = (m - 1)/(m + 1), |z| < 0.172: z^25 is below
 * 1e-19. */
static double portable_log(double x)
{
	int e;
	double m = frexp(x, &e);
	double z, sum = 0;

	if (m < M_SQRT1_2) {
		m *= 2;
		e--;
	}
	z = (m - 1) / (m + 1);
	for (int k = 23; k >= 1; k -= 2)
		sum = sum * z * z + 1.0 / k;
	return 2 * z * sum + e * M_LN2;
}

double fw_random_normal(fw_random *r)
{
	double x, y, s;

	do {
		x = 2 * fw_random_uniform(r) - 1;
		y = 2 * fw_random_uniform(r) - 1;
		s = x * x + y * y;
	} while (s >= 1 || s == 0);
	return x * sqrt(-2 * portable_log(s) / s);
}
