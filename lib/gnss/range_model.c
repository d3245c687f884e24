#include "gnss/range_model.h"

#include <math.h>
#include <stddef.h>

/* The carrier that all ionospheric delays are stated on. */
static const double f_L1_hz = 1575.42e6;

/* clang-format off */
const fw_signal_choice fw_signals_default = {{
	[FW_GPS] = {{'1','C'}, {'1','W'}, {'1','P'}, {'1','X'}, {'1','L'}, {'1',0}, {'2','L'}, {'2','X'}, {'2','S'},
	            {'2','W'}, {'2','P'}, {'2',0}, {'5','Q'}, {'5','X'}, {'5',0}},
	[FW_GALILEO] = {{'1','C'}, {'1','X'}, {'1','B'}, {'1',0}, {'5','Q'}, {'5','X'}, {'5',0}, {'7','Q'}, {'7','X'},
	                {'7',0}},
	[FW_BEIDOU] = {{'2','I'}, {'2','X'}, {'2',0}, {'6','I'}, {'6','X'}, {'6',0}, {'7','I'}, {'7',0}, {'1','P'},
	               {'1','X'}, {'1','D'}, {'5','P'}, {'5','X'}, {'5','D'}},
	[FW_GLONASS] = {{'1','C'}, {'1','P'}, {'2','C'}, {'2','P'}},
	[FW_QZSS] = {{'1','C'}, {'1','X'}, {'1','L'}, {'1',0}, {'2','L'}, {'2','X'}, {'2',0}, {'5','Q'}, {'5','X'},
	             {'5',0}},
	[FW_NAVIC] = {{'5','A'}, {'5',0}},
	[FW_SBAS] = {{'1','C'}},
}};
/* clang-format on */

static bool matches(fw_signal wanted, fw_signal have)
{
	return wanted.band == have.band && (wanted.attribute == 0 || wanted.attribute == have.attribute);
}

static bool has_band(const fw_observation *const *chosen, unsigned n, char band)
{
	for (unsigned i = 0; i < n; i++)
		if (chosen[i]->signal.band == band)
			return true;
	return false;
}

/* How many bands the observations are on, counted up to FW_RANGE_CODES. */
static unsigned count_bands(const fw_observation *obs, unsigned n)
{
	const fw_observation *first[FW_RANGE_CODES];
	unsigned found = 0;
	for (unsigned i = 0; i < n && found < FW_RANGE_CODES; i++)
		if (!has_band(first, found, obs[i].signal.band))
			first[found++] = &obs[i];
	return found;
}

/* The codes to be used of the n observations of one satellite, in order of preference. Returns how many. */
static unsigned choose(const fw_observation *obs, unsigned n, const fw_signal choice[FW_SIGNAL_CHOICES],
                       const fw_observation *chosen[FW_RANGE_CODES])
{
	const unsigned bands = count_bands(obs, n);
	unsigned found = 0;
	for (unsigned j = 0; j < FW_SIGNAL_CHOICES && choice[j].band != 0 && found < bands; j++) {
		if (has_band(chosen, found, choice[j].band))
			continue;
		for (unsigned i = 0; i < n; i++) {
			if (matches(choice[j], obs[i].signal) && (obs[i].has & FW_HAS_CODE) != 0) {
				chosen[found++] = &obs[i];
				break;
			}
		}
	}
	return found;
}

static double frequency_hz(const fw_observation *o, const fw_ephemeris *e)
{
	const int channel = o->glonass_channel != INT8_MIN      ? o->glonass_channel
	                    : o->satellite.system == FW_GLONASS ? e->state.channel
	                                                        : 0;
	return fw_signal_frequency_hz((fw_system)o->satellite.system, o->signal, channel);
}

/* The satellite's state when it sent what the receiver stamps `tag`, `travel_s` before by its own clock. */
static fw_status state_at_transmission(const fw_ephemeris_source *source, const fw_ephemeris *e, fw_time tag,
                                       double travel_s, fw_satellite_state *state)
{
	const double age = fw_time_diff_s(tag, e->toc) - travel_s;
	const double clock = e->af0_s + age * (e->af1_sps + age * e->af2_sps2);
	const double back_s = travel_s + clock;
	if (!(fabs(back_s) < 10))
		return FW_ERANGE;
	const int64_t back_ns = (int64_t)llround(back_s * 1e9);
	const fw_time sent = fw_time_add_ns(tag, -back_ns);
	fw_status status = source->state != NULL ? source->state(source->context, e, sent, state)
	                                         : fw_ephemeris_state(e, sent, state);
	if (status < 0)
		return status;
	/* What is left: the fraction of a nanosecond, and relativity. */
	const double rest_s = (double)back_ns * 1e-9 - (travel_s + state->clock_s);
	for (int i = 0; i < 3; i++)
		state->position_m[i] += rest_s * state->velocity_mps[i];
	return FW_OK;
}

/* Adds the code of an observation, if its group delay is known or not, as `known` says. */
static void add_code(fw_range *r, const fw_observation *o, const fw_ephemeris *e,
                     const fw_satellite_state *state, bool known)
{
	const double f = frequency_hz(o, e);
	double delay_s = 0;
	if (!(f > 0) || (fw_ephemeris_group_delay(e, o->signal, &delay_s) == FW_OK) != known)
		return;
	r->code[r->n_codes++] = (fw_code){
	    .signal = o->signal,
	    .code_m = o->code_m + FW_SPEED_OF_LIGHT_MPS * (state->clock_s - delay_s),
	    .iono_scale = (f_L1_hz / f) * (f_L1_hz / f),
	    .cn0_dbhz = (o->has & FW_HAS_CN0) != 0 ? o->cn0_dbhz : 0,
	    .delay_known = known,
	};
}

static void add_rate(fw_range *r, const fw_observation *o, const fw_ephemeris *e,
                     const fw_satellite_state *state)
{
	if (r->has_rate || (o->has & FW_HAS_DOPPLER) == 0)
		return;
	const double f = frequency_hz(o, e);
	if (!(f > 0))
		return;
	r->has_rate = true;
	r->rate_mps = FW_SPEED_OF_LIGHT_MPS * (state->drift_sps - o->doppler_hz / f);
	r->rate_cn0_dbhz = (o->has & FW_HAS_CN0) != 0 ? o->cn0_dbhz : 0;
}

/* One satellite, from its n observations. Returns false when there is nothing to be had from it. */
static bool make_range(const fw_observation *obs, unsigned n, fw_time tag, const fw_ephemeris_source *source,
                       const fw_signal choice[FW_SIGNAL_CHOICES], unsigned bands, fw_range *r)
{
	const fw_observation *chosen[FW_RANGE_CODES];
	const unsigned found = choose(obs, n, choice, chosen);
	if (found == 0)
		return false;
	const double travel_s = chosen[0]->code_m / FW_SPEED_OF_LIGHT_MPS;
	if (!(fabs(travel_s) < 1))
		return false;
	/* Galileo's clock is that of a pair; E1 with E5a has F/NAV's. */
	const fw_nav_message wanted =
	    bands > 1 && found > 1 && chosen[1]->signal.band == '5' ? FW_NAV_FNAV : FW_NAV_INAV;
	const fw_time sent = fw_time_add_ns(tag, -(int64_t)(travel_s * 1e9));
	const fw_ephemeris *e = source->find(source->context, obs->satellite, wanted, sent);
	fw_satellite_state state;
	if (e == NULL || state_at_transmission(source, e, tag, travel_s, &state) < 0)
		return false;

	*r = (fw_range){.satellite = obs->satellite, .accuracy_m = e->accuracy_m, .issue = e->issue};
	for (int i = 0; i < 3; i++) {
		r->position_m[i] = state.position_m[i];
		r->velocity_mps[i] = state.velocity_mps[i];
	}
	for (unsigned i = 0; i < found && r->n_codes < bands; i++)
		add_code(r, chosen[i], e, &state, true);
	for (unsigned i = 0; i < found && r->n_codes < bands && r->n_codes < 2; i++)
		add_code(r, chosen[i], e, &state, false);
	for (unsigned i = 0; i < found; i++)
		add_rate(r, chosen[i], e, &state);
	for (unsigned i = 0; i < n; i++)
		add_rate(r, &obs[i], e, &state);
	return r->n_codes > 0;
}

fw_status fw_range_prepare(const fw_epoch *epoch, const fw_ephemeris_source *source,
                           const fw_signal_choice *choice, unsigned systems, unsigned bands,
                           fw_range ranges[static FW_RANGE_MAX], unsigned *n)
{
	if (bands < 1 || bands > FW_RANGE_CODES)
		return FW_EINVAL;
	*n = 0;
	for (unsigned i = 0, end; i < epoch->n && *n < FW_RANGE_MAX; i = end) {
		const fw_observation *o = &epoch->obs[i];
		for (end = i + 1;
		     end < epoch->n && fw_satellite_equal(o->satellite, epoch->obs[end].satellite);)
			end++;
		if ((systems >> o->satellite.system & 1) != 0 &&
		    make_range(o, end - i, epoch->time, source, choice->of[o->satellite.system], bands,
		               &ranges[*n]))
			++*n;
	}
	return FW_OK;
}

void fw_range_line(const double receiver_m[static 3], const double satellite_m[static 3],
                   const double *velocity_mps, fw_line_of_sight *line)
{
	const double *r = receiver_m, *s = satellite_m;
	const double omega_c = FW_EARTH_RATE_RADPS / FW_SPEED_OF_LIGHT_MPS;
	const double first = sqrt((s[0] - r[0]) * (s[0] - r[0]) + (s[1] - r[1]) * (s[1] - r[1]) +
	                          (s[2] - r[2]) * (s[2] - r[2]));
	/* The turn is below 1e-5 rad: two terms of its sine and cosine are exact. */
	const double turn = omega_c * (first + omega_c * (s[0] * r[1] - s[1] * r[0]));
	const double cosine = 1 - turn * turn / 2, sine = turn;
	const double now[3] = {cosine * s[0] + sine * s[1], cosine * s[1] - sine * s[0], s[2]};
	const double d[3] = {now[0] - r[0], now[1] - r[1], now[2] - r[2]};
	line->distance_m = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
	for (int i = 0; i < 3; i++)
		line->unit[i] = d[i] / line->distance_m;
	line->rate_mps = 0;
	if (velocity_mps == NULL)
		return;
	const double *v = velocity_mps, *u = line->unit;
	const double along =
	    u[0] * (cosine * v[0] + sine * v[1]) + u[1] * (cosine * v[1] - sine * v[0]) + u[2] * v[2];
	/* The signal that arrives a second later was not sent a second later: the travel time has changed meanwhile. */
	const double turning = FW_EARTH_RATE_RADPS * (u[0] * now[1] - u[1] * now[0]);
	line->rate_mps = along / (1 + (along - turning) / FW_SPEED_OF_LIGHT_MPS);
}
