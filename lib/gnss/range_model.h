/* What a receiver measured against what it should have measured: the codes and Doppler of one epoch with the satellites'
 * side of the equation settled (orbit, clock, relativity, group delays), and the geometry towards a receiver.
 *
 * The code of a satellite s on signal i, as it is left here:
 *     code_i = rho + c dt_r + scale_i I + T + noise
 * with rho the distance from the satellite at transmission to the receiver at reception, I the ionosphere's delay on L1
 * and scale_i = (f_L1 / f_i)^2. The carrier is not looked at. */
#ifndef FURROW_GNSS_RANGE_MODEL_H
#define FURROW_GNSS_RANGE_MODEL_H

#include "gnss/ephemeris.h"
#include "gnss/observation.h"

/** IS-GPS-200N 20.3.3.4.3.3: rotation rate of the Earth [rad/s]; all other systems agree to 1e-12 */
#define FW_EARTH_RATE_RADPS 7.2921151467e-5

enum {
	FW_RANGE_MAX = 128,    /* satellites of an epoch */
	FW_RANGE_CODES = 3,    /* codes of a satellite, on different bands */
	FW_SIGNAL_CHOICES = 16 /* signals of a system in order of preference */
};

/* Where ephemerides come from. find() gives the one to be used for satellite s at time t, or NULL: none, or the
 * satellite is unhealthy. Where a system has two messages with clocks of their own (Galileo), `wanted` is preferred
 * to the other. state() is fw_ephemeris_state() or does the same from what it remembers; NULL: fw_ephemeris_state(). */
typedef struct {
	const fw_ephemeris *(*find)(void *context, fw_satellite s, fw_nav_message wanted, fw_time t);
	void *context;
	fw_status (*state)(void *context, const fw_ephemeris *e, fw_time t, fw_satellite_state *state);
} fw_ephemeris_source;

/* Signals to be used, by system, best first; of several on one band the first that was measured is taken. band 0 ends
 * a list before its end; attribute 0 is any attribute. */
typedef struct {
	fw_signal of[FW_SYSTEM_COUNT][FW_SIGNAL_CHOICES];
} fw_signal_choice;

/* The default: by system the band that most receivers track best first, on each band the usual codes. */
extern const fw_signal_choice fw_signals_default;

/* One code of a satellite. */
typedef struct {
	fw_signal signal;
	double code_m;     /* as above: satellite clock and group delay are taken out */
	double iono_scale; /* delay on this signal for 1 m of delay on L1 */
	double cn0_dbhz;   /* 0: not known */
	bool delay_known;  /* false: the message does not give its group delay */
} fw_code;

/* One satellite of an epoch. */
typedef struct {
	fw_satellite satellite;
	unsigned n_codes;
	fw_code code[FW_RANGE_CODES];
	bool has_rate;
	double rate_mps; /* rhodot + c ddt_r, from the Doppler of the first signal that has one */
	double rate_cn0_dbhz;
	double position_m[3]; /* ECEF at the time of transmission */
	double velocity_mps[3];
	double accuracy_m; /* what the message says of itself; 0: nothing */
	int32_t issue;     /* of the ephemeris used */
} fw_range;

/* Makes the ranges of an epoch.
 *   epoch    in   the observations of a satellite together
 *   systems  in   bit 1 << fw_system: those to be used
 *   bands    in   how many codes a satellite may have at most, 1..FW_RANGE_CODES; one whose group delay the message does
 *                 not give is taken only to make a first or a second
 *   ranges   out  room for FW_RANGE_MAX
 *   n        out  how many; satellites without code, ephemeris or health are left out
 * Returns FW_OK, also when n is 0. */
fw_status fw_range_prepare(const fw_epoch *epoch, const fw_ephemeris_source *source,
                           const fw_signal_choice *choice, unsigned systems, unsigned bands,
                           fw_range ranges[static FW_RANGE_MAX], unsigned *n) FW_MUST_CHECK;

/* A satellite seen from a receiver. */
typedef struct {
	double
	    distance_m; /* from the satellite at transmission to the receiver at reception, Earth rotation included */
	double unit[3];  /* from the receiver to the satellite, ECEF at reception */
	double rate_mps; /* change of the distance when the receiver stands still in ECEF */
} fw_line_of_sight;

/* The line from a receiver (ECEF) to a satellite; velocity may be NULL: rate_mps is then 0. The satellite's position is
 * turned with the Earth by the time that the signal travels. */
void fw_range_line(const double receiver_m[static 3], const double satellite_m[static 3],
                   const double *velocity_mps, fw_line_of_sight *line);

#endif
