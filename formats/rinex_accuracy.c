#include "formats/rinex_accuracy.h"

#include <math.h>

/* Upper ends of the ranges [m]. */
static const double ura_ends_m[15] = {2.4, 3.4, 4.85, 6.85, 9.65, 13.65, 24,  48,
                                      96,  192, 384,  768,  1536, 3072,  6144};

/* Nominal values [m]: 2^(1 + N/2) up to 6, rounded as the document does, then 2^(N - 2). */
static const double ura_nominal_m[15] = {2,  2.8, 4,   5.7, 8,    11.3, 16,  32,
                                         64, 128, 256, 512, 1024, 2048, 4096};

int fw_ura_index(double ura_m)
{
	int i = 0;

	if (!(ura_m >= 0))
		return 15;
	while (i < 15 && ura_m > ura_ends_m[i])
		i++;
	return i;
}

double fw_ura_m(int index)
{
	return index >= 0 && index < 15 ? ura_nominal_m[index] : 8192;
}

/* Where the steps of an index change: from there on, from that value, that much a step. */
static const struct {
	int index;
	double from_m, step_m;
} sisa_parts[] = {{0, 0, 0.01}, {50, 0.5, 0.02}, {75, 1, 0.04}, {100, 2, 0.16}};

enum { SISA_PARTS = 4, SISA_LAST = 125 };

double fw_sisa_m(int index)
{
	int i = SISA_PARTS - 1;

	if (index < 0 || index > SISA_LAST)
		return -1;
	while (sisa_parts[i].index > index)
		i--;
	return sisa_parts[i].from_m + (index - sisa_parts[i].index) * sisa_parts[i].step_m;
}

int fw_sisa_index(double sisa_m)
{
	int i = SISA_PARTS - 1;

	if (!(sisa_m >= 0 && sisa_m <= 6.08)) /* that much: index 125 and half a step */
		return -1;
	while (sisa_parts[i].from_m > sisa_m + 1e-6)
		i--;
	return sisa_parts[i].index + (int)lround((sisa_m - sisa_parts[i].from_m) / sisa_parts[i].step_m);
}
