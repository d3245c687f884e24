/* What an observation row costs as text, in nanoseconds; the best of several runs. The row is a full one,
 * with the time of its neighbours, as in a receiver's log. */
#include <stdio.h>
#include <time.h>

#include "base/random.h"
#include "formats/csv.h"
#include "furrow_obs.h"

enum { ROWS = 4096, PER_EPOCH = 40, PASSES = 50, RUNS = 7 };

static char sats[ROWS][16];
static furrow_obs rows[ROWS];
static fw_csv_writer writer;

static fw_status count(void *total, const void *bytes, size_t n)
{
	(void)bytes;
	*(uint64_t *)total += n;
	return FW_OK;
}

static double uniform(fw_random *r, double low, double high)
{
	return low + (high - low) * fw_random_uniform(r);
}

/* Raw values have the steps of a receiver's: 1 mm, 1/1000 cycle, 0.1 mHz, 1/4 dB-Hz. */
static void make_rows(void)
{
	static char signals[][3] = {"1C", "2W", "5Q", "7I"};
	fw_random r;

	fw_random_init(&r, 1);
	for (int i = 0; i < ROWS; i++) {
		furrow_obs *o = &rows[i];
		snprintf(sats[i], sizeof sats[i], "G%02d", i % 32 + 1);
		o->present = (1 << 14) - 1 - (1 << 5);
		o->gps_week = 2345;
		o->tow_s = 482321 + i / PER_EPOCH * 0.2;
		o->sat = sats[i];
		o->signal = signals[i % 4];
		o->pseudorange_m = uniform(&r, 2e7, 2.6e7);
		o->carrier_cyc = o->pseudorange_m / 0.19029367;
		o->doppler_hz = uniform(&r, -4000, 4000);
		o->cn0_dbhz = (double)(100 + fw_random_below(&r, 110)) / 4;
		o->lock_s = (int32_t)fw_random_below(&r, 65535);
		o->rx_channel = (int16_t)(i % 60);
	}
}

static double now_ns(void)
{
	struct timespec t;

	clock_gettime(CLOCK_MONOTONIC, &t);
	return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

int main(void)
{
	double best = 1e300;
	uint64_t bytes = 0;

	make_rows();
	for (int run = 0; run < RUNS; run++) {
		bytes = 0;
		const double start = now_ns();
		fw_csv_begin_table(&writer, FW_obs, count, &bytes);
		for (int pass = 0; pass < PASSES; pass++)
			for (int i = 0; i < ROWS; i++)
				fw_csv_put(&writer, FW_obs, &rows[i]);
		if (fw_csv_end(&writer, true, 0) != FW_OK)
			return 1;
		const double ns = (now_ns() - start) / (PASSES * ROWS);
		best = ns < best ? ns : best;
	}
	printf("obs row: %.0f ns, %.0f bytes, %.0f MB/s\n", best, (double)bytes / (PASSES * ROWS),
	       (double)bytes / (PASSES * ROWS) * 1e3 / best);
	return 0;
}
