#include "sim/receiver.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "base/stats.h"
#include "gnss/range_model.h"

#define C FW_SPEED_OF_LIGHT_MPS

/** All interface documents: the frequency that ionospheric delays are given for [Hz] */
#define L1_HZ 1575.42e6

/* ---- signals ---- */

/** Chip rates: IS-GPS-200, IS-GPS-705, Galileo OS SIS ICD 2.1 table 14, BDS-SIS-ICD-B1I-3.0 4.1.1, B2a,
 * GLONASS ICD 5.1 3.3.1. Losses: minimum received powers of the same documents against the system's first
 * signal, rounded; 2W with what semi-codeless tracking costs. */
#define MCPS(rate) (C / ((rate)*1e6))
static const struct {
	fw_system system;
	fw_tracked_signal tracked;
} known[] = {
    {FW_GPS, {{'1', 'C'}, MCPS(1.023), 0.1, 0}},      {FW_GPS, {{'1', 'L'}, MCPS(1.023), 0.1, 0}},
    {FW_GPS, {{'2', 'W'}, MCPS(10.23), 0.5, 8}},      {FW_GPS, {{'2', 'L'}, MCPS(1.023), 0.1, 3}},
    {FW_GPS, {{'5', 'Q'}, MCPS(10.23), 0.5, 0}},      {FW_GALILEO, {{'1', 'C'}, MCPS(1.023), 0.1, 0}},
    {FW_GALILEO, {{'5', 'Q'}, MCPS(10.23), 0.5, 0}},  {FW_GALILEO, {{'7', 'Q'}, MCPS(10.23), 0.5, 0}},
    {FW_GALILEO, {{'8', 'Q'}, MCPS(51.15), 0.9, -2}}, {FW_GALILEO, {{'6', 'C'}, MCPS(5.115), 0.5, 0}},
    {FW_BEIDOU, {{'2', 'I'}, MCPS(2.046), 0.25, 0}},  {FW_BEIDOU, {{'7', 'I'}, MCPS(2.046), 0.25, 0}},
    {FW_BEIDOU, {{'6', 'I'}, MCPS(10.23), 0.5, 0}},   {FW_BEIDOU, {{'1', 'P'}, MCPS(1.023), 0.1, 1}},
    {FW_BEIDOU, {{'5', 'P'}, MCPS(10.23), 0.5, 0}},   {FW_BEIDOU, {{'7', 'D'}, MCPS(10.23), 0.5, 0}},
    {FW_GLONASS, {{'1', 'C'}, MCPS(0.511), 0.1, 0}},  {FW_GLONASS, {{'1', 'P'}, MCPS(5.11), 0.5, 0}},
    {FW_GLONASS, {{'2', 'C'}, MCPS(0.511), 0.1, 3}},  {FW_GLONASS, {{'2', 'P'}, MCPS(5.11), 0.5, 3}},
};

fw_status fw_tracked_signal_named(fw_system system, fw_signal signal, fw_tracked_signal *tracked)
{
	for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
		const fw_signal *s = &known[i].tracked.signal;
		if (known[i].system == system && s->band == signal.band && s->attribute == signal.attribute) {
			*tracked = known[i].tracked;
			return FW_OK;
		}
	}
	return FW_EUNKNOWN;
}

/* ---- thermal noise ---- */

static double ratio(double db)
{
	return exp(db * 0.23025850929940457); /* ln 10 / 10 */
}

double fw_dll_noise_m(const fw_receiver_noise *n, const fw_tracked_signal *signal, double cn0_dbhz)
{
	double cn0 = ratio(cn0_dbhz), d = signal->spacing,
	       squaring = 1 + 2 / (n->integration_s * cn0 * (2 - d));
	return signal->chip_m * sqrt(n->dll_hz * d / (2 * cn0) * squaring);
}

double fw_pll_noise_m(const fw_receiver_noise *n, double wavelength_m, double cn0_dbhz)
{
	double cn0 = ratio(cn0_dbhz), squaring = 1 + 1 / (2 * n->integration_s * cn0);
	return wavelength_m / (2 * FW_PI) * sqrt(n->pll_hz / cn0 * squaring);
}

double fw_fll_noise_mps(const fw_receiver_noise *n, double wavelength_m, double cn0_dbhz)
{
	double cn0 = ratio(cn0_dbhz), squaring = 1 + 1 / (n->integration_s * cn0);
	return wavelength_m / (2 * FW_PI * n->integration_s) * sqrt(4 * n->fll_hz / cn0 * squaring);
}

/* ---- faults ---- */

static bool breaks_lock(fw_fault_kind kind)
{
	return kind == FW_FAULT_STEP || kind == FW_FAULT_MEACON || kind == FW_FAULT_SLIP;
}

/* The place of a meacon's antenna: offset_ned_m from the origin. */
static bool meacon_place(const fw_receiver_setup *setup, const fw_fault *f, double p[static 3],
                         double llh[static 3])
{
	double C_e_n[3][3], offset[3];
	if (fw_llh_to_ecef(setup->origin_llh, p) < 0)
		return false;
	fw_frame_ned(setup->origin_llh[0], setup->origin_llh[1], C_e_n);
	fw_mat3_vec(C_e_n, f->offset_ned_m, offset);
	for (int i = 0; i < 3; i++)
		p[i] += offset[i];
	return fw_ecef_to_llh(p, llh) >= 0;
}

static double distance(const double a[static 3], const double b[static 3])
{
	return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
	            (a[2] - b[2]) * (a[2] - b[2]));
}

/* The range by way of the meacon instead of the direct one. The receiver's own motion changes it along with
 * every other range alike, which its clock takes up. */
static void add_meacon(const fw_receiver *r, const fw_sky *sky, fw_time t, const fw_antenna *antenna,
                       const fw_fault *f, fw_measured *m)
{
	static const double still[3];
	double p[3], llh[3], step = 1e-3, later[3];
	fw_sky_view there;
	if (!meacon_place(&r->setup, f, p, llh) || !fw_sky_look(sky, m->satellite, t, p, still, llh, &there))
		return;
	for (int i = 0; i < 3; i++)
		later[i] = antenna->position_m[i] + step * antenna->velocity_mps[i];
	double way = distance(antenna->position_m, p), way_later = distance(later, p);
	m->extra_m += there.range_m + way + f->delay_m - m->view.range_m;
	m->extra_mps += there.range_rate_mps + (way_later - way) / step - m->view.range_rate_mps;
}

/* The range to an imagined place beside the antenna instead of the one to the antenna. */
static void add_drag_off(const fw_antenna *antenna, const fw_fault *f, fw_measured *m)
{
	double C_e_n[3][3], ned[3], shift[3], rate[3], line[3], along = 0;
	double dt = antenna->t_s - f->window.from_s;
	fw_frame_ned(antenna->llh[0], antenna->llh[1], C_e_n);
	for (int i = 0; i < 3; i++)
		ned[i] = f->offset_ned_m[i] + f->rate_ned_mps[i] * dt;
	fw_mat3_vec(C_e_n, ned, shift);
	fw_mat3_vec(C_e_n, f->rate_ned_mps, rate);
	for (int i = 0; i < 3; i++) {
		line[i] = m->view.range_m * m->view.unit[i];
		along += m->view.unit[i] * rate[i];
	}
	m->extra_m += distance(line, shift) - m->view.range_m + f->delay_m + f->rate_mps * dt;
	m->extra_mps += f->rate_mps - along;
}

static void add_faults(const fw_receiver *r, const fw_sky *sky, fw_time t, const fw_antenna *antenna,
                       fw_measured *m)
{
	fw_satellite s = sky->satellite[m->satellite].satellite;
	for (unsigned i = 0; i < r->setup.n_faults; i++) {
		const fw_fault *f = &r->setup.fault[i];
		bool holds = fw_window_holds(f->window, antenna->t_s);
		if ((f->stations & r->setup.station) == 0 || !fw_satellite_in(&f->satellites, s))
			continue;
		m->jumped |= breaks_lock(f->kind) && holds != r->fault_on[i];
		if (!holds)
			continue;
		switch (f->kind) {
		case FW_FAULT_STEP: m->extra_m += f->size_m; break;
		case FW_FAULT_RAMP:
			m->extra_m += f->rate_mps * (antenna->t_s - f->window.from_s);
			m->extra_mps += f->rate_mps;
			break;
		case FW_FAULT_MEACON: add_meacon(r, sky, t, antenna, f, m); break;
		case FW_FAULT_DRAG_OFF: add_drag_off(antenna, f, m); break;
		case FW_FAULT_SLIP:
		case FW_FAULT_NO_PVT:
		case FW_FAULT_NO_ATTITUDE:
		case FW_FAULT_SILENCE: break;
		}
	}
}

/* ---- what is in view ---- */

/* Delays on the way, and how fast they change since the epoch before. */
static void add_delays(fw_receiver *r, const fw_sky *sky, fw_time t, const fw_antenna *antenna,
                       fw_measured *m)
{
	double *last = r->last_delay_m[m->satellite], dt = antenna->t_s - r->last_t_s;
	fw_sky_delays(sky, m->satellite, t, &m->view, antenna->llh, &m->iono_m, &m->tropo_m);
	if (last[1] > 0 && dt > 0) {
		m->iono_mps = (m->iono_m - last[0]) / dt;
		m->tropo_mps = (m->tropo_m - last[1]) / dt;
	}
	last[0] = m->iono_m;
	last[1] = m->tropo_m;
}

static void find_visible(fw_receiver *r, const fw_sky *sky, fw_time t, const fw_antenna *antenna)
{
	r->n_measured = 0;
	for (unsigned i = 0; i < sky->n; i++) {
		fw_measured *m = &r->measured[r->n_measured];
		*m = (fw_measured){.satellite = i};
		if (r->setup.signal[sky->satellite[i].satellite.system][0].signal.band == 0 ||
		    !fw_sky_look(sky, i, t, antenna->position_m, antenna->velocity_mps, antenna->llh,
		                 &m->view) ||
		    !(m->view.elevation_rad >= r->setup.noise.elevation_mask_rad)) {
			memset(r->last_delay_m[i], 0, sizeof r->last_delay_m[i]);
			for (unsigned k = 0; k < FW_RECEIVER_SIGNALS; k++)
				r->channel[i][k].tracking = false;
			continue;
		}
		add_delays(r, sky, t, antenna, m);
		add_faults(r, sky, t, antenna, m);
		r->n_measured++;
	}
}

/* When a mask sets in, the highest of the satellites it covers are those that it keeps. */
static void choose_kept(fw_receiver *r, const fw_sky *sky, unsigned which)
{
	const fw_mask *mask = &r->setup.mask[which];
	fw_satellite_set *kept = &r->kept[which];
	*kept = (fw_satellite_set){0};
	for (unsigned k = 0; k < mask->keep; k++) {
		const fw_measured *best = NULL;
		for (unsigned i = 0; i < r->n_measured; i++) {
			const fw_measured *m = &r->measured[i];
			fw_satellite s = sky->satellite[m->satellite].satellite;
			if (fw_mask_covers(mask, s, m->view.azimuth_rad, m->view.elevation_rad) &&
			    !fw_satellite_in(kept, s) &&
			    (best == NULL || m->view.elevation_rad > best->view.elevation_rad))
				best = m;
		}
		if (best == NULL)
			return;
		fw_satellite s = sky->satellite[best->satellite].satellite;
		kept->bits[s.system] |= UINT64_C(1) << s.number % 64;
	}
}

static void set_in_masks(fw_receiver *r, const fw_sky *sky, double t_s)
{
	for (unsigned i = 0; i < r->setup.n_masks; i++) {
		bool on = fw_window_holds(r->setup.mask[i].window, t_s);
		if (on && !r->mask_on[i] && r->setup.mask[i].keep > 0)
			choose_kept(r, sky, i);
		r->mask_on[i] = on;
	}
	for (unsigned i = 0; i < r->setup.n_faults; i++)
		r->fault_on[i] = fw_window_holds(r->setup.fault[i].window, t_s);
}

/* ---- one signal ---- */

static void acquire(const fw_receiver *r, fw_channel *c, double t_s)
{
	c->tracking = true;
	c->since_s = t_s;
	c->cycles = (int64_t)fw_random_below(&c->random, 1001) - 500;
	c->half_off = fw_random_uniform(&c->random) < 0.5 && r->setup.noise.half_cycle_s > 0;
	fw_gm1_init(&c->code, 1, &c->random);
	fw_gm1_init(&c->carrier, 1, &c->random);
}

/* Up to ten cycles, never none. */
static void slip(fw_channel *c, double t_s)
{
	int64_t n = (int64_t)fw_random_below(&c->random, 20) - 10;
	c->cycles += n >= 0 ? n + 1 : n;
	c->since_s = t_s;
}

/* Keeps a channel going; returns whether its carrier begins anew. */
static bool keep_tracking(const fw_receiver *r, fw_channel *c, const fw_measured *m, double t_s,
                          double cn0_dbhz)
{
	const fw_receiver_noise *n = &r->setup.noise;
	double dt = t_s - r->last_t_s;
	if (!c->tracking || !(dt > 0)) {
		acquire(r, c, t_s);
		return true;
	}
	fw_gm1_step(&c->code, 1, n->multipath_tau_s, dt, &c->random);
	fw_gm1_step(&c->carrier, 1, n->multipath_tau_s, dt, &c->random);
	double slips = n->slips_per_hour / 3600 * dt * ratio(45 - cn0_dbhz);
	bool lost = m->jumped || fw_random_uniform(&c->random) < -expm1(-slips);
	if (lost)
		slip(c, t_s);
	return lost;
}

/* What the range has become on its way to this signal of this receiver, clock and ionosphere aside. */
static double bias_of(const fw_receiver *r, const fw_sky_satellite *s, fw_signal signal)
{
	double delay_s;
	if (fw_ephemeris_group_delay(&s->ephemerides[0], signal, &delay_s) < 0)
		delay_s = 0;
	return C * delay_s + r->bias_m[s->satellite.system];
}

static void observe(fw_receiver *r, const fw_sky *sky, const fw_tracked_signal *tracked, fw_channel *c,
                    fw_measured *m, double clock_s, double drift_sps, double t_s, double cn0_dbhz,
                    fw_observation *o)
{
	const fw_receiver_noise *n = &r->setup.noise;
	const fw_sky_satellite *s = &sky->satellite[m->satellite];
	double f =
	    fw_signal_frequency_hz((fw_system)s->satellite.system, tracked->signal, s->glonass_channel);
	double wave = C / f, q = L1_HZ / f * (L1_HZ / f),
	       fading = exp(-m->view.elevation_rad / n->multipath_scale_rad);
	double dll = fw_dll_noise_m(n, tracked, cn0_dbhz), mp = n->multipath_m * fading;
	double fll = fw_fll_noise_mps(n, wave, cn0_dbhz);
	double range = m->view.range_m + m->extra_m + C * clock_s - m->view.clock_m + m->tropo_m +
	               bias_of(r, s, tracked->signal);
	double rate =
	    m->view.range_rate_mps + m->extra_mps + C * drift_sps - m->view.drift_mps + m->tropo_mps;

	*o = (fw_observation){.satellite = s->satellite, .signal = tracked->signal, .cn0_dbhz = cn0_dbhz};
	o->glonass_channel = (int8_t)s->glonass_channel;
	o->has = FW_HAS_CODE | FW_HAS_CARRIER | FW_HAS_DOPPLER | FW_HAS_CN0 | FW_HAS_LOCK;
	o->slip = keep_tracking(r, c, m, t_s, cn0_dbhz);
	o->lock_s = t_s - c->since_s;
	o->half_cycle = o->lock_s < n->half_cycle_s;
	o->code_m = range + q * m->iono_m + mp * c->code.value + dll * fw_random_normal(&c->random);
	double carrier_m = range - q * m->iono_m + n->multipath_carrier_m * fading * c->carrier.value +
	                   fw_pll_noise_m(n, wave, cn0_dbhz) * fw_random_normal(&c->random);
	o->carrier_cyc = carrier_m / wave + (double)c->cycles + (o->half_cycle && c->half_off ? 0.5 : 0);
	o->doppler_hz = -(rate - q * m->iono_mps + fll * fw_random_normal(&c->random)) / wave;
	if (m->sd_m > 0)
		return;
	m->sd_m = hypot(dll, mp);
	m->rate_sd_mps = fll;
}

/* All signals of one satellite. */
static void observe_satellite(fw_receiver *r, const fw_sky *sky, fw_measured *m, double clock_s,
                              double drift_sps, double t_s, fw_epoch *epoch)
{
	const fw_receiver_noise *n = &r->setup.noise;
	fw_satellite s = sky->satellite[m->satellite].satellite;
	double dimmed = fw_masks_attenuation_db(r->setup.mask, r->setup.n_masks, r->kept, r->setup.station,
	                                        t_s, s, m->view.azimuth_rad, m->view.elevation_rad);
	double strongest = n->cn0_horizon_dbhz +
	                   (n->cn0_zenith_dbhz - n->cn0_horizon_dbhz) * sin(fmax(m->view.elevation_rad, 0)) -
	                   dimmed;
	m->observation = epoch->n;
	for (unsigned k = 0; k < FW_RECEIVER_SIGNALS; k++) {
		const fw_tracked_signal *tracked = &r->setup.signal[s.system][k];
		fw_channel *c = &r->channel[m->satellite][k];
		if (tracked->signal.band == 0 || epoch->n == FW_EPOCH_MAX)
			break;
		double cn0 = strongest - tracked->loss_db + n->cn0_sd_db * fw_random_normal(&c->random);
		if (!(cn0 >= n->cn0_track_dbhz)) {
			c->tracking = false;
			continue;
		}
		observe(r, sky, tracked, c, m, clock_s, drift_sps, t_s, cn0, &epoch->obs[epoch->n++]);
	}
}

void fw_receiver_init(fw_receiver *r, const fw_receiver_setup *setup, uint64_t seed)
{
	*r = (fw_receiver){.setup = *setup, .last_t_s = (double)NAN};
	fw_random_init(&r->random, seed);
	uint64_t own = fw_random_u64(&r->random);
	for (unsigned i = 0; i < FW_SKY_SATELLITES; i++)
		for (unsigned k = 0; k < FW_RECEIVER_SIGNALS; k++)
			fw_random_init(&r->channel[i][k].random, own + i * FW_RECEIVER_SIGNALS + k);
	for (unsigned i = 1; i < FW_SYSTEM_COUNT; i++)
		r->bias_m[i] = setup->noise.system_bias_m * fw_random_normal(&r->random);
	for (unsigned i = 0; i < 6; i++)
		fw_gm1_init(&r->section_error[i], 1, &r->random);
	for (unsigned i = 0; i < 2; i++)
		fw_gm1_init(&r->attitude_error[i], 1, &r->random);
}

void fw_receiver_measure(fw_receiver *r, const fw_sky *sky, fw_time tag, double clock_s, double drift_sps,
                         const fw_antenna *antenna, fw_epoch *epoch)
{
	unsigned kept = 0;
	fw_time t = fw_time_add_ns(tag, -llround(clock_s * 1e9));
	epoch->time = tag;
	epoch->n = 0;
	find_visible(r, sky, t, antenna);
	set_in_masks(r, sky, antenna->t_s);
	for (unsigned i = 0; i < r->n_measured; i++) {
		unsigned before = epoch->n;
		observe_satellite(r, sky, &r->measured[i], clock_s, drift_sps, antenna->t_s, epoch);
		if (epoch->n > before)
			r->measured[kept++] = r->measured[i];
	}
	r->n_measured = kept;
	r->dt_s = antenna->t_s > r->last_t_s ? antenna->t_s - r->last_t_s : 0;
	r->last_t_s = antenna->t_s;
}

/* ---- the solution ---- */

enum { UNKNOWNS = 3 + FW_SYSTEM_COUNT };

/* A satellite in the equations. */
typedef struct {
	double h[UNKNOWNS];   /* north, east, down, clocks in the order in which their systems come up */
	double error_m, sd_m; /* measured minus computed at the true place and clock */
	double error_mps, sd_mps;
} row;

typedef struct {
	unsigned n, n_systems;
	fw_system system[FW_SYSTEM_COUNT];
	unsigned count[FW_SYSTEM_COUNT]; /* satellites of each of them */
	row row[FW_SKY_SATELLITES];
} equations;

/* Distance by the broadcast orbit, less the broadcast clock. */
static double broadcast_range_m(const fw_satellite_state *s, const fw_sky_view *view,
                                const fw_antenna *antenna)
{
	double angle = FW_EARTH_RATE_RADPS * view->range_m / C, c = cos(angle), d = sin(angle);
	double p[3] = {c * s->position_m[0] + d * s->position_m[1],
	               c * s->position_m[1] - d * s->position_m[0], s->position_m[2]};
	return distance(p, antenna->position_m) - C * s->clock_s;
}

/* What a receiver that knows the broadcast message finds to be wrong with a code, and how much of it it
 * expects. */
static bool code_error(const fw_receiver *r, const fw_sky *sky, const fw_measured *m, const fw_observation *o,
                       double clock_s, const fw_antenna *antenna, row *to)
{
	const fw_ephemeris *e = fw_sky_broadcast(sky, m->satellite, m->view.transmitted);
	const fw_sky_errors *sigma = &sky->errors;
	fw_satellite_state state;
	double delay_s, tow_s, rest = r->setup.pvt.sbas ? r->setup.pvt.sbas_rest : 1;
	int week;
	if (e == NULL || fw_ephemeris_state(e, m->view.transmitted, &state) < 0)
		return false;
	if (fw_ephemeris_group_delay(e, o->signal, &delay_s) < 0)
		delay_s = 0;
	fw_time_to_gps_s(m->view.transmitted, &week, &tow_s);
	fw_sight sight = {antenna->llh[0], antenna->llh[1], m->view.azimuth_rad, m->view.elevation_rad,
	                  tow_s};
	fw_zenith_delay zenith = fw_saastamoinen(antenna->llh[0], antenna->llh[2], 0.7);
	double f = fw_signal_frequency_hz((fw_system)o->satellite.system, o->signal, o->glonass_channel);
	double q = L1_HZ / f * (L1_HZ / f), iono = fw_klobuchar_m(&sigma->klobuchar, &sight);
	double mapping = fw_mops_mapping(m->view.elevation_rad),
	       tropo = mapping * (zenith.dry_m + zenith.wet_m);
	double range = broadcast_range_m(&state, &m->view, antenna);

	double unknown = m->view.range_m - m->view.clock_m - range + q * (m->iono_m - iono);
	to->error_m =
	    o->code_m - (range + C * clock_s + C * delay_s + tropo + q * iono) - (1 - rest) * unknown;
	double orbit = hypot(sigma->radial_m, sigma->clock_m), shell = rest * sigma->iono_fraction * q * iono;
	/* Two tenths of the orbit's error across the radius reach the ground at most. */
	orbit = rest * hypot(orbit, 0.2 * hypot(sigma->along_m, sigma->cross_m));
	to->sd_m = sqrt(m->sd_m * m->sd_m + orbit * orbit + shell * shell +
	                mapping * mapping * sigma->tropo_m * sigma->tropo_m);
	return to->sd_m > 0;
}

static unsigned clock_of(equations *eq, fw_system system)
{
	unsigned k = 0;
	while (k < eq->n_systems && eq->system[k] != system)
		k++;
	if (k == eq->n_systems) {
		eq->system[k] = system;
		eq->count[eq->n_systems++] = 0;
	}
	eq->count[k]++;
	return k;
}

static void set_up(const fw_receiver *r, const fw_sky *sky, const fw_epoch *epoch, double clock_s,
                   double drift_sps, const fw_antenna *antenna, equations *eq)
{
	double C_e_n[3][3], ned[3];
	fw_frame_ned(antenna->llh[0], antenna->llh[1], C_e_n);
	for (unsigned i = 0; i < r->n_measured; i++) {
		const fw_measured *m = &r->measured[i];
		const fw_observation *o = &epoch->obs[m->observation];
		row *to = &eq->row[eq->n];
		if (!(m->view.elevation_rad >= r->setup.pvt.elevation_mask_rad) ||
		    !code_error(r, sky, m, o, clock_s, antenna, to))
			continue;
		double f =
		    fw_signal_frequency_hz((fw_system)o->satellite.system, o->signal, o->glonass_channel);
		to->error_mps =
		    -o->doppler_hz * C / f - (m->view.range_rate_mps + C * drift_sps - m->view.drift_mps);
		to->sd_mps = m->rate_sd_mps;
		memset(to->h, 0, sizeof to->h);
		fw_mat3_t_vec(C_e_n, m->view.unit, ned);
		for (int k = 0; k < 3; k++)
			to->h[k] = -ned[k];
		to->h[3 + clock_of(eq, (fw_system)o->satellite.system)] = 1;
		eq->n++;
	}
}

/* Weighted least squares in n unknowns.
 *   rate  in   solve for the velocity and one drift instead of position and clocks
 *   unit  in   all weights alike
 *   x, Q  out  solution and its covariance */
static fw_status least_squares(const equations *eq, bool rate, bool unit, double x[static UNKNOWNS],
                               double Q[static UNKNOWNS * UNKNOWNS])
{
	unsigned n = rate ? 4 : 3 + eq->n_systems;
	double N[UNKNOWNS * UNKNOWNS] = {0}, b[UNKNOWNS] = {0}, h[UNKNOWNS];
	for (unsigned i = 0; i < eq->n; i++) {
		const row *a = &eq->row[i];
		double sd = unit ? 1 : rate ? a->sd_mps : a->sd_m, w = 1 / (sd * sd);
		memcpy(h, a->h, sizeof h);
		if (rate)
			h[3] = 1;
		for (unsigned k = 0; k < n; k++) {
			b[k] += w * h[k] * (rate ? a->error_mps : a->error_m);
			for (unsigned j = 0; j < n; j++)
				N[k * n + j] += w * h[k] * h[j];
		}
	}
	fw_status status = fw_mat_inverse_spd((int)n, N, Q);
	if (status == FW_OK)
		fw_mat_mul((int)n, (int)n, 1, Q, b, x);
	return status;
}

/* Rows and columns `north, east, down, one more` of a covariance of n unknowns. */
static void pick(const double *Q, unsigned n, unsigned clock, double out[4][4])
{
	unsigned at[4] = {0, 1, 2, clock};
	for (int i = 0; i < 4; i++)
		for (int k = 0; k < 4; k++)
			out[i][k] = Q[at[i] * n + at[k]];
}

/* The longer half axis of the horizontal error ellipse, for one standard deviation. */
static double major_axis(const double Q[4][4])
{
	double mean = (Q[0][0] + Q[1][1]) / 2;
	return sqrt(mean + hypot((Q[0][0] - Q[1][1]) / 2, Q[0][1]));
}

/* The section of that moment puts its own errors in place of the computed ones. */
static void override(fw_receiver *r, double t_s, fw_receiver_solution *s, double x[static 4],
                     double v[static 4])
{
	const fw_pvt_setup *p = &r->setup.pvt;
	for (unsigned i = 0; i < 6 && p->n_sections > 0; i++)
		fw_gm1_step(&r->section_error[i], 1, p->section_tau_s, r->dt_s, &r->random);
	for (unsigned i = 0; i < p->n_sections; i++) {
		const fw_pvt_section *sec = &p->section[i];
		if (!fw_window_holds(sec->window, t_s))
			continue;
		memset(s->covariance_m2, 0, 3 * sizeof s->covariance_m2[0]);
		memset(s->velocity_covariance_m2ps2, 0, 3 * sizeof s->velocity_covariance_m2ps2[0]);
		for (int k = 0; k < 3; k++) {
			double variance = k < 2 ? sec->horizontal_m2 : sec->vertical_m2;
			double rate_variance = k < 2 ? sec->horizontal_m2ps2 : sec->vertical_m2ps2;
			x[k] = sqrt(variance) * r->section_error[k].value;
			v[k] = sqrt(rate_variance) * r->section_error[3 + k].value;
			s->covariance_m2[k][k] = variance;
			s->velocity_covariance_m2ps2[k][k] = rate_variance;
			s->covariance_m2[3][k] = s->velocity_covariance_m2ps2[3][k] = 0;
		}
	}
}

static fw_status place_solution(const fw_antenna *antenna, const double x[static 4], const double v[static 4],
                                fw_receiver_solution *s)
{
	double C_e_n[3][3], shift[3], p[3];
	fw_frame_ned(antenna->llh[0], antenna->llh[1], C_e_n);
	fw_mat3_vec(C_e_n, x, shift);
	fw_mat3_t_vec(C_e_n, antenna->velocity_mps, s->velocity_ned_mps);
	for (int i = 0; i < 3; i++) {
		p[i] = antenna->position_m[i] + shift[i];
		s->velocity_ned_mps[i] += v[i];
	}
	return fw_ecef_to_llh(p, s->llh);
}

static void dilute(const double *Q, unsigned n, unsigned clock, fw_receiver_solution *s)
{
	double D[4][4];
	pick(Q, n, clock, D);
	s->hdop = sqrt(D[0][0] + D[1][1]);
	s->vdop = sqrt(D[2][2]);
	s->pdop = hypot(s->hdop, s->vdop);
	s->tdop = sqrt(D[3][3]);
}

fw_status fw_receiver_solve(fw_receiver *r, const fw_sky *sky, const fw_epoch *epoch, double clock_s,
                            double drift_sps, const fw_antenna *antenna, fw_receiver_solution *solution)
{
	equations eq = {0};
	fw_receiver_solution s = {0};
	double x[UNKNOWNS], v[UNKNOWNS], Q[UNKNOWNS * UNKNOWNS];
	unsigned most = 0;

	if (fw_faults_hold(r->setup.fault, r->setup.n_faults, FW_FAULT_NO_PVT, r->setup.station,
	                   antenna->t_s))
		return FW_ENOSPACE;
	set_up(r, sky, epoch, clock_s, drift_sps, antenna, &eq);
	unsigned n = 3 + eq.n_systems;
	if (eq.n_systems == 0 || eq.n < n)
		return FW_ENOSPACE;
	for (unsigned k = 1; k < eq.n_systems; k++)
		most = eq.count[k] > eq.count[most] ? k : most;

	fw_status status = least_squares(&eq, false, true, x, Q);
	if (status < 0)
		return status;
	dilute(Q, n, 3 + most, &s);
	if ((status = least_squares(&eq, true, false, v, Q)) < 0)
		return status;
	pick(Q, 4, 3, s.velocity_covariance_m2ps2);
	if ((status = least_squares(&eq, false, false, x, Q)) < 0)
		return status;
	pick(Q, n, 3 + most, s.covariance_m2);

	s.n_used = eq.n;
	for (unsigned k = 0; k < eq.n_systems; k++)
		s.systems |= 1U << eq.system[k];
	s.clock_m = C * clock_s + x[3 + most];
	s.drift_mps = C * drift_sps + v[3];
	override(r, antenna->t_s, &s, x, v);
	s.hpl_m = r->setup.pvt.k_h * major_axis((const double(*)[4])s.covariance_m2);
	s.vpl_m = r->setup.pvt.k_v * sqrt(s.covariance_m2[2][2]);
	if ((status = place_solution(antenna, x, v, &s)) < 0)
		return status;
	*solution = s;
	return FW_OK;
}

fw_status fw_receiver_attitude_of(fw_receiver *r, const double C_n_b[static 3][3], const fw_antenna *antenna,
                                  const fw_receiver_solution *solution, fw_receiver_attitude *attitude)
{
	const double *b = r->setup.baseline_b_m;
	double length = sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]), rpy[3], error[2];
	for (unsigned i = 0; i < 2; i++) {
		fw_gm1_step(&r->attitude_error[i], 1, r->setup.noise.multipath_tau_s, r->dt_s, &r->random);
		error[i] = sqrt(0.5) * (r->attitude_error[i].value + fw_random_normal(&r->random));
	}
	if (!(length > 0) || solution == NULL || solution->n_used < 5 ||
	    fw_faults_hold(r->setup.fault, r->setup.n_faults, FW_FAULT_NO_ATTITUDE, r->setup.station,
	                   antenna->t_s))
		return FW_ENOSPACE;
	fw_matrix_to_euler(C_n_b, rpy);
	attitude->sd_heading_rad = r->setup.attitude_noise_m * solution->hdop / length;
	attitude->sd_pitch_rad = r->setup.attitude_noise_m * solution->vdop / length;
	attitude->heading_rad = fw_wrap_2pi(rpy[2] + attitude->sd_heading_rad * error[0]);
	attitude->pitch_rad = rpy[1] + attitude->sd_pitch_rad * error[1];
	return FW_OK;
}
