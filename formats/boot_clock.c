#include "formats/boot_clock.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define STRAY_S      1.0   /* a pair that is further off is wrong, or all before it were */
#define TURN_DRIFT   3e-4  /* in turn: the most that the offset may fall [s/s], of a cheap clock */
#define LEARNT_DRIFT 50e-6 /* learnt: departure from the straight drift [s/s] */
#define DRIFT_MOST   1e-3  /* of the straight drift [s/s] */
#define DRIFT_SPAN_S 60.0  /* a shorter log tells no drift */
#define LAG_MOST_S   1e6

enum { AGREEING = 5, FIRST_SPACING_US = 1000000 };

static const int64_t boot_most_us = INT64_C(1) << 48;

void fw_boot_clock_begin(fw_boot_clock *c)
{
	memset(c, 0, offsetof(fw_boot_clock, knots));
	c->spacing_us = FIRST_SPACING_US;
}

/* Two neighbours become one, the better, until there is room. */
static void make_room(fw_boot_clock *c)
{
	while (c->n == FW_BOOT_KNOTS) {
		int n = 0;

		c->spacing_us *= 2;
		for (int i = 0; i < c->n; i++) {
			const fw_boot_knot k = c->knots[i];

			if (n == 0 || k.boot_us / c->spacing_us != c->knots[n - 1].boot_us / c->spacing_us)
				c->knots[n++] = k;
			else if (k.offset_s > c->knots[n - 1].offset_s)
				c->knots[n - 1] = k;
		}
		c->n = n;
	}
}

static void keep(fw_boot_clock *c, int64_t boot_us, double offset_s)
{
	fw_boot_knot *last = c->n > 0 ? &c->knots[c->n - 1] : NULL;
	const double passed_s = c->n > 0 && boot_us > c->last_us ? (double)(boot_us - c->last_us) * 1e-6 : 0;

	c->pairs++;
	c->n_agreeing = 0;
	c->now_s = c->n > 0 ? fmax(offset_s, c->now_s - TURN_DRIFT * passed_s) : offset_s;
	c->last_us = boot_us;
	if (last != NULL && boot_us / c->spacing_us <= last->boot_us / c->spacing_us) {
		if (offset_s > last->offset_s && boot_us >= last->boot_us)
			*last = (fw_boot_knot){boot_us, offset_s};
		return;
	}
	make_room(c);
	c->knots[c->n++] = (fw_boot_knot){boot_us, offset_s};
}

/* A pair that is far off what those before it said. */
static void doubt(fw_boot_clock *c, int64_t boot_us, double offset_s)
{
	c->strays++;
	c->n_agreeing = c->n_agreeing > 0 && fabs(offset_s - c->stray_s) < STRAY_S ? c->n_agreeing + 1 : 1;
	c->stray_s = offset_s;
	if (c->n_agreeing < AGREEING)
		return;
	c->n = 0;
	keep(c, boot_us, offset_s);
}

void fw_boot_clock_add(fw_boot_clock *c, int64_t boot_us, fw_time gps)
{
	if (c->learnt || boot_us < 0 || boot_us > boot_most_us || gps.ns < 0 || gps.ns > FW_TIME_NS_MAX)
		return;
	const int64_t offset_ns = gps.ns - boot_us * 1000;
	if (c->n == 0)
		c->origin_ns = offset_ns;
	const double offset_s = (double)(offset_ns - c->origin_ns) * 1e-9;
	if (c->n > 0 && fabs(offset_s - c->now_s) > STRAY_S)
		doubt(c, boot_us, offset_s);
	else
		keep(c, boot_us, offset_s);
}

/* Least squares through the knots. */
static double straight_drift(const fw_boot_clock *c)
{
	const double span_s = (double)(c->knots[c->n - 1].boot_us - c->knots[0].boot_us) * 1e-6;
	double mean_t = 0, mean_x = 0, tt = 0, tx = 0, drift;

	if (span_s < DRIFT_SPAN_S)
		return 0;
	for (int i = 0; i < c->n; i++) {
		mean_t += (double)(c->knots[i].boot_us - c->knots[0].boot_us) * 1e-6 / c->n;
		mean_x += c->knots[i].offset_s / c->n;
	}
	for (int i = 0; i < c->n; i++) {
		const double t = (double)(c->knots[i].boot_us - c->knots[0].boot_us) * 1e-6 - mean_t;

		tt += t * t;
		tx += t * (c->knots[i].offset_s - mean_x);
	}
	drift = tx / tt;
	return fabs(drift) < DRIFT_MOST ? drift : 0;
}

/* The knot, raised to what its neighbour allows at least. */
static void raise_to(fw_boot_knot *k, const fw_boot_knot *neighbour, double drift)
{
	const double dt = (double)(k->boot_us - neighbour->boot_us) * 1e-6;
	const double least = neighbour->offset_s + drift * dt - LEARNT_DRIFT * fabs(dt);

	if (k->offset_s < least)
		k->offset_s = least;
}

void fw_boot_clock_learn(fw_boot_clock *c)
{
	c->learnt = true;
	if (c->n == 0)
		return;
	c->drift = straight_drift(c);
	for (int i = 1; i < c->n; i++)
		raise_to(&c->knots[i], &c->knots[i - 1], c->drift);
	for (int i = c->n - 1; i > 0; i--)
		raise_to(&c->knots[i - 1], &c->knots[i], c->drift);
}

static double learnt_offset(const fw_boot_clock *c, int64_t boot_us)
{
	const fw_boot_knot *k = c->knots;
	int low = 0, high = c->n - 1; /* k[low] <= boot_us < k[high] */

	if (boot_us <= k[low].boot_us)
		return k[low].offset_s + c->drift * (double)(boot_us - k[low].boot_us) * 1e-6;
	if (boot_us >= k[high].boot_us)
		return k[high].offset_s + c->drift * (double)(boot_us - k[high].boot_us) * 1e-6;
	while (high - low > 1) {
		const int middle = (low + high) / 2;

		if (k[middle].boot_us <= boot_us)
			low = middle;
		else
			high = middle;
	}
	const double part = (double)(boot_us - k[low].boot_us) / (double)(k[high].boot_us - k[low].boot_us);
	return k[low].offset_s + part * (k[high].offset_s - k[low].offset_s);
}

fw_status fw_boot_clock_time(const fw_boot_clock *c, int64_t boot_us, double lag_s, fw_time *t)
{
	if (c->n == 0)
		return FW_MORE;
	if (boot_us < 0 || boot_us > boot_most_us || !(fabs(lag_s) < LAG_MOST_S))
		return FW_ERANGE;
	const double offset_s = (c->learnt ? learnt_offset(c, boot_us) : c->now_s) + lag_s;
	const int64_t ns = boot_us * 1000 + c->origin_ns + llround(offset_s * 1e9);
	if (ns < 0 || ns > FW_TIME_NS_MAX)
		return FW_ERANGE;
	t->ns = ns;
	return FW_OK;
}
