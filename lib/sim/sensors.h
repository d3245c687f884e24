/* Sensors as they are: what a perfect reading becomes inside an IMU, a magnetometer, a barometer, a receiver's clock.
 *
 * Every sensor is a model (numbers that do not change), and a state that starts from a seed; one seed gives one
 * sequence. The errors come at a fixed interval, given at the start. A model of all zeros is a perfect sensor. */
#ifndef FURROW_SIM_SENSORS_H
#define FURROW_SIM_SENSORS_H

#include "base/random.h"
#include "base/status.h"

/* ---- coloured noise, the part that they share ---- */

/* A first-order Gauss-Markov process or, with tau_s = INFINITY, a random walk, by exact sampling of its
 * value and of its integral over each step. */
typedef struct {
	double value;
	double keep;                              /* of the value over a step */
	double share;                             /* of the value in the mean over the step */
	double value_sd, mean_per_value, mean_sd; /* noise of value; of the mean, given that of the value */
} fw_wander;

enum { FW_FLICKER_POLES = 12 };

/* Noise with the spectrum 1/f, made of Gauss-Markov processes whose times are a factor of 4 apart: true to 2 % in Allan deviation
 * from one step to 200,000 steps. */
typedef struct {
	fw_wander pole[FW_FLICKER_POLES];
} fw_flicker;

/* ---- IMU ---- */

/* The errors of three like axes. Unit: rad/s (gyros) or m/s^2 (accelerometers), called u below. */
typedef struct {
	double bias_sd; /* turn-on bias [u], the same for the whole run */
	double white;   /* random walk coefficient N (ARW, VRW) [u/sqrt(Hz)]: Allan deviation N / sqrt(tau) */
	double flicker; /* bias instability B [u]: Allan deviation 0.664 B */
	double walk;    /* rate random walk K [u/sqrt(s)]: Allan deviation K sqrt(tau / 3) */
	double markov_sd;       /* in-run bias as a Gauss-Markov process: standard deviation [u] */
	double markov_tau_s;    /* its correlation time; > 0 if markov_sd > 0 */
	double scale_sd;        /* scale factor error [1] */
	double misalignment_sd; /* of each axis towards each of the other two [rad] */
	double
	    quantum; /* least step of the increment over an interval [u s]; what is left over comes with the next one. 0: none */
	double range; /* most that an axis can report, either sign [u]; 0: no limit */
} fw_triad_model;

typedef struct {
	fw_triad_model gyro, accel;
} fw_imu_model;

typedef struct {
	fw_triad_model model;
	double interval_s;
	double bias[3];      /* turn-on [u] */
	double matrix[3][3]; /* scale and misalignment: reading = matrix true + bias */
	double wandering[3]; /* flicker, walk and Gauss-Markov together, of the last sample [u] */
	double remainder[3]; /* of the quantisation [u s] */
	fw_wander walk[3], markov[3];
	fw_flicker flicker[3];
	fw_random random;
} fw_triad;

typedef struct {
	fw_triad gyro, accel;
} fw_imu;

/* Starts an IMU: draws its biases, scale factors and misalignments.
 *   interval_s  in   between samples
 * Returns FW_OK; FW_EINVAL (interval not positive, a negative number, NaN): *imu untouched. */
fw_status fw_imu_init(const fw_imu_model *model, double interval_s, uint64_t seed, fw_imu *imu) FW_MUST_CHECK;

/* The next sample. Inputs are true averages over the interval (fw_trajectory_average), outputs are
 * what the IMU says. gyro may be omega_ib_b and accel may be force_b. */
void fw_imu_sample(fw_imu *imu, const double omega_ib_b_radps[static 3], const double force_b_mps2[static 3],
                   double gyro_radps[static 3], double accel_mps2[static 3]);

/* ---- magnetometer ---- */

typedef struct {
	double hard_iron_ut[3];
	double soft_iron[3][3]; /* reading = (I + soft_iron) field + hard_iron + noise */
	double noise_ut;        /* white, of each sample */
	double quantum_ut;      /* 0: none */
} fw_magnetometer_model;

typedef struct {
	fw_magnetometer_model model;
	fw_random random;
} fw_magnetometer;

/* Returns FW_OK or FW_EINVAL (a negative sigma or quantum, NaN): *m untouched. */
fw_status fw_magnetometer_init(const fw_magnetometer_model *model, uint64_t seed,
                               fw_magnetometer *m) FW_MUST_CHECK;

/* The next reading in body axes [uT] from the Earth's field in NED [nT] (fw_magnetic_field). */
void fw_magnetometer_sample(fw_magnetometer *m, const double C_n_b[static 3][3],
                            const double field_ned_nt[static 3], double mag_b_ut[static 3]);

/* ---- barometer ---- */

typedef struct {
	double bias_sd_m;   /* once per run */
	double drift_sd_m;  /* weather and temperature: Gauss-Markov */
	double drift_tau_s; /* > 0 if drift_sd_m > 0 */
	double noise_m;     /* white, of each sample */
	double quantum_m;   /* 0: none */
} fw_barometer_model;

typedef struct {
	fw_barometer_model model;
	double bias_m;
	fw_wander drift;
	fw_random random;
} fw_barometer;

/* Returns FW_OK or FW_EINVAL (interval not positive, a negative number, NaN): *b untouched. */
fw_status fw_barometer_init(const fw_barometer_model *model, double interval_s, uint64_t seed,
                            fw_barometer *b) FW_MUST_CHECK;

/* The next reading of a height [m], above whatever the true height is above. */
double fw_barometer_sample(fw_barometer *b, double height_m);

/* ---- receiver clock ---- */

/* One-sided spectral density of the fractional frequency: S_y(f) = h0 + h-1 / f + h-2 / f^2. */
typedef struct {
	double h0;           /* white FM [s] */
	double hm1;          /* flicker FM [1] */
	double hm2;          /* random walk FM [1/s] */
	double ageing_per_s; /* steady change of the frequency [1/s] */
	double offset_s;     /* at the start */
	double drift_sps;    /* at the start */
} fw_clock_model;

typedef struct {
	fw_clock_model model;
	double interval_s;
	double offset_s; /* receiver clock minus GPST now */
	double
	    drift_sps; /* mean rate of the offset over the step that ended now; before the first step that of the model */
	double frequency_sps; /* start and ageing */
	fw_wander walk;
	fw_flicker flicker;
	fw_random random;
} fw_clock;

/* The model that a name stands for: "tcxo", "ocxo", "csac", "rubidium", "caesium", "perfect"; offset and drift at the start are 0.
 * Sources: Brown and Hwang, Introduction to Random Signals and Applied Kalman Filtering, 4th ed., table 9.3
 * (csac: sigma_y(1 s) = 3e-10, white, down to a floor of 1e-11).
 * Returns FW_OK or FW_EUNKNOWN: *model untouched. */
fw_status fw_clock_model_named(const char *name, fw_clock_model *model) FW_MUST_CHECK;

/* Returns FW_OK or FW_EINVAL (interval not positive, a negative h, NaN): *clock untouched. */
fw_status fw_clock_init(const fw_clock_model *model, double interval_s, uint64_t seed,
                        fw_clock *clock) FW_MUST_CHECK;

/* One interval later: offset_s and drift_sps are brought up to date. */
void fw_clock_step(fw_clock *clock);

#endif
