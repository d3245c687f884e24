#include "gnss/precise.h"

#include <math.h>
#include <string.h>

enum {
	AFTER = FW_PRECISE_POINTS / 2,
	BEFORE = FW_PRECISE_POINTS - AFTER /* points at or after t, and before it */
};

#define C FW_SPEED_OF_LIGHT_MPS

/** IERS Conventions 2010, tables 1.1 and 1.2: nominal mean angular velocity of the Earth [rad/s], geocentric
 * gravitational constant [m^3/s^2] */
#define OMEGA_E 7.292115e-5
#define GM      3.986004418e14

void fw_precise_init(fw_precise *p)
{
	p->orbits.n = p->clocks.n = 0;
}

/* ---- the tables ---- */

/* The number of the first epoch that is not before t. */
static unsigned first_from(const fw_time *times, unsigned n, fw_time t)
{
	unsigned i = 0;

	while (i < n && fw_time_compare(times[i], t) < 0)
		i++;
	return i;
}

/* Makes room at the end for an epoch of `size` values, all of them missing; the oldest goes if need be. */
static void append(fw_time *times, double *values, size_t size, unsigned *n, fw_time t)
{
	double *newest;

	if (*n == FW_PRECISE_EPOCHS) {
		--*n;
		memmove(times, times + 1, *n * sizeof *times);
		memmove(values, values + size, *n * size * sizeof *values);
	}
	newest = values + *n * size;
	for (size_t i = 0; i < size; i++)
		newest[i] = (double)NAN;
	times[(*n)++] = t;
}

/* Sees to it that the newest epoch is that of t. */
static fw_status begin_epoch(fw_time *times, double *values, size_t size, unsigned *n, fw_time t,
                             fw_satellite s)
{
	if (s.system >= FW_SYSTEM_COUNT || (*n > 0 && fw_time_compare(t, times[*n - 1]) < 0))
		return FW_EINVAL;
	if (*n == 0 || fw_time_compare(t, times[*n - 1]) > 0)
		append(times, values, size, n, t);
	return FW_OK;
}

fw_status fw_precise_add_position(fw_precise *p, fw_time t, fw_satellite s, const double position_m[static 3])
{
	struct fw_precise_orbits *o = &p->orbits;
	fw_status status;

	if (!isfinite(position_m[0]) || !isfinite(position_m[1]) || !isfinite(position_m[2]))
		return FW_ENONFINITE;
	status = begin_epoch(o->time, &o->position_m[0][0][0], 3 * (size_t)FW_SATELLITE_COUNT, &o->n, t, s);
	if (status < 0)
		return status;
	memcpy(o->position_m[o->n - 1][fw_satellite_index(s)], position_m, sizeof o->position_m[0][0]);
	return FW_OK;
}

fw_status fw_precise_add_clock(fw_precise *p, fw_time t, fw_satellite s, double clock_s)
{
	struct fw_precise_clocks *c = &p->clocks;
	fw_status status;

	if (!isfinite(clock_s))
		return FW_ENONFINITE;
	status = begin_epoch(c->time, &c->clock_s[0][0], FW_SATELLITE_COUNT, &c->n, t, s);
	if (status < 0)
		return status;
	c->clock_s[c->n - 1][fw_satellite_index(s)] = clock_s;
	return FW_OK;
}

/* The points after t, and one more epoch that says that those are complete. */
bool fw_precise_wants_orbits(const fw_precise *p, fw_time t)
{
	return p->orbits.n - first_from(p->orbits.time, p->orbits.n, t) < AFTER + 1;
}

bool fw_precise_wants_clocks(const fw_precise *p, fw_time t)
{
	return p->clocks.n - first_from(p->clocks.time, p->clocks.n, t) < 2;
}

/* ---- orbits ---- */

/* Sets *from to the first of the 11 epochs around t. */
static fw_status choose(const struct fw_precise_orbits *o, fw_time t, unsigned *from)
{
	const int64_t spacing_ns = FW_PRECISE_SPACING_S * FW_NS_PER_S;
	const unsigned next = first_from(o->time, o->n, t);

	if (o->n < FW_PRECISE_POINTS || fw_time_diff_ns(o->time[0], t) > spacing_ns ||
	    fw_time_diff_ns(t, o->time[o->n - 1]) > spacing_ns)
		return FW_ERANGE;
	*from = next < BEFORE ? 0 : next - BEFORE;
	if (*from > o->n - FW_PRECISE_POINTS)
		*from = o->n - FW_PRECISE_POINTS;
	for (unsigned i = *from; i + 1 < *from + FW_PRECISE_POINTS; i++)
		if (fw_time_diff_ns(o->time[i + 1], o->time[i]) > spacing_ns)
			return FW_ERANGE;
	return *from + BEFORE == next ? FW_OK : FW_DUBIOUS;
}

/* The polynomial through (x_i, y_i) and its derivative at 0, by Neville's scheme; y is used up. */
static void interpolate(const double x[static FW_PRECISE_POINTS], double y[static FW_PRECISE_POINTS],
                        double *value, double *slope)
{
	double d[FW_PRECISE_POINTS] = {0};

	for (int k = 1; k < FW_PRECISE_POINTS; k++)
		for (int i = 0; i + k < FW_PRECISE_POINTS; i++) {
			const double width = x[i + k] - x[i];

			d[i] = (y[i + 1] - y[i] + x[i + k] * d[i] - x[i] * d[i + 1]) / width;
			y[i] = (x[i + k] * y[i] - x[i] * y[i + 1]) / width;
		}
	*value = y[0];
	*slope = d[0];
}

/* Each position is turned to where it is in the frame that stands still in space and coincides with ECEF at
 * t. */
static fw_status orbit(const struct fw_precise_orbits *o, fw_satellite s, fw_time t,
                       fw_satellite_state *state)
{
	double x[FW_PRECISE_POINTS], y[3][FW_PRECISE_POINTS];
	double *p = state->position_m, *v = state->velocity_mps;
	unsigned from;
	const fw_status status = choose(o, t, &from);

	if (status < 0)
		return status;
	for (unsigned i = 0; i < FW_PRECISE_POINTS; i++) {
		const double *q = o->position_m[from + i][fw_satellite_index(s)];
		double sine, cosine;

		if (isnan(q[0]))
			return FW_EUNKNOWN;
		x[i] = fw_time_diff_s(o->time[from + i], t);
		sincos(OMEGA_E * x[i], &sine, &cosine);
		y[0][i] = cosine * q[0] - sine * q[1];
		y[1][i] = sine * q[0] + cosine * q[1];
		y[2][i] = q[2];
	}
	for (int k = 0; k < 3; k++)
		interpolate(x, y[k], &p[k], &v[k]);
	v[0] += OMEGA_E * p[1];
	v[1] -= OMEGA_E * p[0];
	return status;
}

/* ---- clocks ---- */

/* A satellite's clock at some epoch. */
struct sample {
	bool found;
	double since_s; /* t minus the epoch */
	double clock_s;
};

/* The satellite's first value from epoch `start` on, in steps of `way`; not found: none, or too far from
 * t. */
static struct sample find_clock(const struct fw_precise_clocks *c, fw_satellite s, fw_time t, int start,
                                int way)
{
	for (int i = start; i >= 0 && i < (int)c->n; i += way) {
		const double since_s = fw_time_diff_s(t, c->time[i]),
		             clock_s = c->clock_s[i][fw_satellite_index(s)];

		if (!isnan(clock_s))
			return (struct sample){fabs(since_s) <= FW_PRECISE_SPACING_S, since_s, clock_s};
	}
	return (struct sample){0};
}

/* Linear between the neighbours; at the ends, the one there is. */
static fw_status clock_at(const struct fw_precise_clocks *c, fw_satellite s, fw_time t,
                          fw_satellite_state *state)
{
	const int next = (int)first_from(c->time, c->n, t);
	const struct sample before = find_clock(c, s, t, next - 1, -1), after = find_clock(c, s, t, next, 1);

	if (before.found && after.found) {
		state->drift_sps = (after.clock_s - before.clock_s) / (before.since_s - after.since_s);
		state->clock_s = before.clock_s + before.since_s * state->drift_sps;
		return FW_OK;
	}
	if (!before.found && !after.found)
		return FW_EUNKNOWN;
	state->clock_s = before.found ? before.clock_s : after.clock_s;
	state->drift_sps = 0;
	return FW_DUBIOUS;
}

/* The periodic effect, and its rate with the acceleration of a point mass, which is right to 0.1 %. */
static void add_relativity(fw_satellite_state *s)
{
	const double *p = s->position_m;
	const double v[3] = {s->velocity_mps[0] - OMEGA_E * p[1], s->velocity_mps[1] + OMEGA_E * p[0],
	                     s->velocity_mps[2]};
	const double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);

	s->clock_s -= 2 * (p[0] * v[0] + p[1] * v[1] + p[2] * v[2]) / (C * C);
	s->drift_sps -= 2 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - GM / r) / (C * C);
}

static bool is_finite(const fw_satellite_state *s)
{
	double sum = s->clock_s + s->drift_sps;

	for (int i = 0; i < 3; i++)
		sum += s->position_m[i] + s->velocity_mps[i];
	return isfinite(sum);
}

fw_status fw_precise_state(const fw_precise *p, fw_satellite s, fw_time t, fw_satellite_state *state)
{
	fw_satellite_state found = {0};
	fw_status orbit_status, clock_status;

	if (s.system >= FW_SYSTEM_COUNT)
		return FW_EUNKNOWN;
	orbit_status = orbit(&p->orbits, s, t, &found);
	if (orbit_status < 0)
		return orbit_status;
	clock_status = clock_at(&p->clocks, s, t, &found);
	if (clock_status < 0)
		return clock_status;
	add_relativity(&found);
	if (!is_finite(&found))
		return FW_ENONFINITE;
	*state = found;
	return orbit_status == FW_DUBIOUS || clock_status == FW_DUBIOUS ? FW_DUBIOUS : FW_OK;
}
