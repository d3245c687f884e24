/* A GNSS receiver: what it measures of a sky, and the position, velocity and attitude that it makes of it.
 *
 * Code and carrier of satellite s on signal i, for an antenna at time t = tag - clock:
 *     code    = rho + c (dt_r - dt_s + X_i) + B + T + q_i I + multipath + noise
 *     carrier = (rho + c (dt_r - dt_s + X_i) + B + T - q_i I + multipath + noise) / lambda_i + N_i
 * rho, dt_s, I, T are those of sim/sky.h; q_i = (f_L1 / f_i)^2; X_i is the group delay that the broadcast
 * gives for the signal; B a constant of the receiver for each system (0 for GPS); N_i is an integer that
 * stays until the next cycle slip, and is half an integer while half_cycle is set on an unlucky channel.
 * The Doppler is the carrier's derivative. */
#ifndef FURROW_SIM_RECEIVER_H
#define FURROW_SIM_RECEIVER_H

#include "gnss/observation.h"
#include "sim/fault.h"
#include "sim/process.h"
#include "sim/sky.h"

enum { FW_RECEIVER_SIGNALS = 4, FW_RECEIVER_MASKS = 32, FW_RECEIVER_FAULTS = 32, FW_PVT_SECTIONS = 32 };

/* A signal that the receiver tracks. */
typedef struct {
	fw_signal signal; /* band 0: none */
	double chip_m;    /* length of a code chip */
	double spacing;   /* of the early and late correlators [chips] */
	double loss_db;   /* how much weaker than the system's strongest */
} fw_tracked_signal;

/* Measurement errors, the receiver's own and those of its surroundings. */
typedef struct {
	double elevation_mask_rad;
	double cn0_zenith_dbhz; /* of a system's strongest signal; as the sine of the elevation down to */
	double cn0_horizon_dbhz;
	double cn0_sd_db;                             /* white scatter of C/N0 */
	double cn0_track_dbhz;                        /* below it a signal is lost */
	double dll_hz, pll_hz, fll_hz, integration_s; /* tracking loops: noise bandwidths */
	double multipath_m, multipath_carrier_m;      /* standard deviation of both at the horizon */
	double multipath_scale_rad; /* of their decay with elevation: exp(-elevation / scale) */
	double multipath_tau_s;
	double slips_per_hour; /* of a signal at 45 dB-Hz; ten times as many for each 10 dB less */
	double half_cycle_s;   /* how long a new carrier may be off by half a cycle */
	double system_bias_m;  /* standard deviation of B */
} fw_receiver_noise;

/* A stretch of time with position and velocity errors of given variances instead of computed ones. */
typedef struct {
	fw_window window;
	double horizontal_m2, vertical_m2; /* of each of north and east; of down */
	double horizontal_m2ps2, vertical_m2ps2;
} fw_pvt_section;

typedef struct {
	double elevation_mask_rad;
	bool sbas; /* corrected by SBAS: of orbit, clock and ionosphere errors only the rest below remains */
	double sbas_rest; /* as a fraction */
	/* Protection level by standard deviation. RTCA DO-229, J.2.1: K_H 6.18, or 6.0 with vertical guidance;
	 * K_V 5.33. */
	double k_h, k_v;
	unsigned n_sections;
	fw_pvt_section section[FW_PVT_SECTIONS];
	double section_tau_s; /* correlation time of the sections' errors; 0: white */
} fw_pvt_setup;

typedef struct {
	unsigned station; /* FW_STATION_..., for masks and faults */
	fw_tracked_signal signal[FW_SYSTEM_COUNT][FW_RECEIVER_SIGNALS];
	fw_receiver_noise noise;
	fw_pvt_setup pvt;
	double baseline_b_m[3];  /* from the main to the auxiliary antenna, body axes; all 0: no attitude */
	double attitude_noise_m; /* of a component of that baseline, times DOP */
	double origin_llh[3];    /* what the meacon's place counts from */
	unsigned n_masks, n_faults;
	fw_mask mask[FW_RECEIVER_MASKS];
	fw_fault fault[FW_RECEIVER_FAULTS];
} fw_receiver_setup;

/* The code of a signal as it is usually tracked: GPS 1C 2W 2L 5Q 1L, Galileo 1C 5Q 7Q 8Q 6C, BeiDou 2I 7I
 * 6I 1P 5P 7D, GLONASS 1C 1P 2C 2P, with chip length and loss. Returns FW_EUNKNOWN: none of these. */
fw_status fw_tracked_signal_named(fw_system system, fw_signal signal,
                                  fw_tracked_signal *tracked) FW_MUST_CHECK;

/* Where an antenna is and how it moves at the moment of reception. */
typedef struct {
	double t_s; /* receiver time tag since the start of the scenario: what windows hold for */
	double position_m[3], velocity_mps[3]; /* ECEF */
	double llh[3];
} fw_antenna;

/* The carrier and code of one signal of one satellite. */
typedef struct {
	bool tracking;
	bool half_off;        /* off by half a cycle, as long as that is not settled */
	double since_s;       /* scenario time of the lock */
	int64_t cycles;       /* N */
	fw_gm1 code, carrier; /* multipath, of variance 1 */
	fw_random random;
} fw_channel;

/* A satellite measured in this epoch: what the solution starts from. */
typedef struct {
	unsigned satellite; /* in the sky */
	fw_sky_view view;
	unsigned observation;      /* the first of it in the epoch */
	double extra_m, extra_mps; /* what faults add to the range */
	bool jumped;               /* a fault that no carrier survives has begun or ended */
	double iono_m, tropo_m;    /* true delays, iono on L1 */
	double iono_mps, tropo_mps;
	double sd_m, rate_sd_mps; /* of the first signal: code's noise and multipath; Doppler's noise */
} fw_measured;

/* Owned by the caller, about 100 kB. */
typedef struct {
	fw_receiver_setup setup;
	fw_channel channel[FW_SKY_SATELLITES][FW_RECEIVER_SIGNALS];
	double last_t_s;                           /* scenario time of the last epoch; NAN: none yet */
	double dt_s;                               /* between it and the one before; 0: there was none */
	double last_delay_m[FW_SKY_SATELLITES][2]; /* its ionosphere and troposphere; 0: not seen */
	double bias_m[FW_SYSTEM_COUNT];            /* B */
	fw_satellite_set kept[FW_RECEIVER_MASKS];
	bool mask_on[FW_RECEIVER_MASKS], fault_on[FW_RECEIVER_FAULTS];
	unsigned n_measured;
	fw_measured measured[FW_SKY_SATELLITES];
	fw_gm1 section_error[6], attitude_error[2];
	fw_random random;
} fw_receiver;

/* The receiver's own solution. */
typedef struct {
	unsigned n_used;
	double llh[3]; /* rad, rad, m */
	double velocity_ned_mps[3];
	double covariance_m2[4][4]; /* north, east, down, clock (of the system with the most satellites) */
	double velocity_covariance_m2ps2[4][4]; /* the same, and the clock's drift */
	double clock_m, drift_mps;              /* receiver clock, times c */
	unsigned systems;                       /* bit 1 << fw_system: those used */
	double pdop, hdop, vdop, tdop;          /* unweighted */
	double hpl_m, vpl_m;
} fw_receiver_solution;

typedef struct {
	double heading_rad, pitch_rad; /* of the baseline turned to the body's x axis */
	double sd_heading_rad, sd_pitch_rad;
} fw_receiver_attitude;

/* Begins a receiver. One seed, one sequence. */
void fw_receiver_init(fw_receiver *r, const fw_receiver_setup *setup, uint64_t seed);

/* Measures: fills in an epoch. To be called in the order of time, after fw_sky_advance(sky, tag).
 *   clock_s, drift_sps  in   receiver clock minus GPST, at the tag
 *   antenna             in   at GPST tag - clock_s
 *   epoch               out  satellite by satellite; the tag is its time */
void fw_receiver_measure(fw_receiver *r, const fw_sky *sky, fw_time tag, double clock_s, double drift_sps,
                         const fw_antenna *antenna, fw_epoch *epoch);

/* Position, velocity, clock from the epoch just measured: weighted least squares on the first signal of
 * each satellite, corrected by the broadcast ionosphere and Saastamoinen's troposphere, with one clock for
 * each system; weights, covariance and protection levels from the standard deviations that the errors were
 * drawn with. Solved in one step from the true place, which leaves out terms of (error squared / distance
 * of the satellites): 2.5 micrometres for 10 m.
 * Returns FW_OK; FW_ENOSPACE: fewer satellites than unknowns, or FW_FAULT_NO_PVT; FW_ESINGULAR: *solution
 * untouched. */
fw_status fw_receiver_solve(fw_receiver *r, const fw_sky *sky, const fw_epoch *epoch, double clock_s,
                            double drift_sps, const fw_antenna *antenna,
                            fw_receiver_solution *solution) FW_MUST_CHECK;

/* Heading and pitch from the two antennas: the true ones plus the errors of a carrier baseline, half of
 * their variance correlated over multipath_tau_s.
 *   C_n_b     in   true attitude
 *   solution  in   of the same epoch; NULL: there is none
 * Returns FW_OK; FW_ENOSPACE: no baseline, fewer than five satellites, or FW_FAULT_NO_ATTITUDE: *attitude
 * untouched. */
fw_status fw_receiver_attitude_of(fw_receiver *r, const double C_n_b[static 3][3], const fw_antenna *antenna,
                                  const fw_receiver_solution *solution,
                                  fw_receiver_attitude *attitude) FW_MUST_CHECK;

/* Standard deviations of the thermal noise of the tracking loops.
 *   code [m]: noncoherent early-late DLL; carrier [m]: PLL; rate [m/s]: FLL
 * Source: E. D. Kaplan and C. J. Hegarty (eds.), Understanding GPS/GNSS, 3rd ed. (2017), 8.9: equations for
 * the DLL (with a spacing d that the front end lets through), the PLL and the FLL. */
double fw_dll_noise_m(const fw_receiver_noise *n, const fw_tracked_signal *signal, double cn0_dbhz);
double fw_pll_noise_m(const fw_receiver_noise *n, double wavelength_m, double cn0_dbhz);
double fw_fll_noise_mps(const fw_receiver_noise *n, double wavelength_m, double cn0_dbhz);

#endif
