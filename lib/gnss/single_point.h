/* Position, velocity and time from the codes and Doppler of one receiver at one moment: weighted least squares.
 *
 * Unknowns: the position, one receiver clock for each system, and, held near 0 by what is known of them, the errors of the
 * models at the zenith: ionosphere and troposphere. So the errors that satellites have in common are not taken for
 * independent ones, neither in the weights nor in the covariance. The velocity has one clock drift. */
#ifndef FURROW_GNSS_SINGLE_POINT_H
#define FURROW_GNSS_SINGLE_POINT_H

#include "gnss/atmosphere.h"
#include "gnss/range_model.h"

typedef enum {
	FW_IONO_OFF,
	FW_IONO_BROADCAST, /* first code of each satellite, corrected by Klobuchar's model */
	FW_IONO_FREE,      /* two codes, the ionosphere eliminated; satellites with one code are left out */
	FW_IONO_WEIGHTED /* up to three codes, the model's correction as an observation with its own error */
} fw_iono_mode;

typedef enum { FW_TROPO_OFF, FW_TROPO_SAASTAMOINEN, FW_TROPO_MOPS } fw_tropo_mode;

typedef struct {
	unsigned systems;                /* bit 1 << fw_system */
	const fw_signal_choice *signals; /* NULL: fw_signals_default */
	double elevation_mask_rad;
	double cn0_mask_dbhz; /* 0: none */
	fw_iono_mode iono;
	fw_tropo_mode tropo;
	double gate;     /* a normalised residual above this is an outlier; 0: no exclusion */
	double max_gdop; /* beyond it the geometry is called bad */
	bool no_velocity;
} fw_single_point_options;

/* GPS, Galileo, BeiDou, GLONASS, QZSS; mask 10 degrees; broadcast ionosphere, Saastamoinen. */
extern const fw_single_point_options fw_single_point_defaults;

/* What the models need beside the observations. alpha all 0: no such coefficients. */
typedef struct {
	bool has_gps, has_beidou;
	fw_klobuchar gps, beidou; /* QZSS is served by GPS's */
} fw_iono_coefficients;

typedef enum { FW_USED, FW_LOW, FW_WEAK, FW_OUTLIER, FW_NO_PAIR } fw_range_use;

/* A satellite in the solution. */
typedef struct {
	fw_satellite satellite;
	fw_range_use use;
	double azimuth_rad, elevation_rad;
	double
	    residual_m; /* measured minus computed; of excluded satellites against the solution without them */
	double sigma_m;
	double iono_m, tropo_m; /* corrections applied; iono on the combination used */
} fw_satellite_use;

typedef struct {
	fw_time time;                    /* GPST of reception: time tag minus receiver clock */
	double position_m[3];            /* ECEF */
	double llh[3];                   /* the same, geodetic: rad, rad, m */
	double covariance_m2[3][3];      /* of north, east, down */
	double clock_m[FW_SYSTEM_COUNT]; /* receiver clock times c, by system */
	unsigned systems;                /* bit 1 << fw_system: clocks that were estimated */
	bool has_velocity;
	double velocity_mps[3];              /* north, east, down */
	double velocity_covariance[3][3];    /* of the same [(m/s)^2] */
	double drift_mps;                    /* receiver clock drift times c */
	double gdop, pdop, hdop, vdop, tdop; /* unweighted, one clock per system */
	unsigned n_used;                     /* satellites used */
	unsigned n_excluded;                 /* outliers */
	double chi2;                         /* weighted sum of squared residuals */
	double redundancy;                   /* its degrees of freedom */
	double
	    variance_factor; /* of the measurements: by this, what was expected of them has been multiplied */
	unsigned n;          /* of satellites below */
	fw_satellite_use satellite[FW_RANGE_MAX];
} fw_solution;

/* What goes from epoch to epoch: only where to start, and how large residuals have been. Zero it at the start. */
typedef struct {
	bool has_position;
	double position_m[3], velocity_mps[3]; /* ECEF */
	fw_time time;
	double chi2, dof;           /* fading sums of the position's residuals, */
	double rate_chi2, rate_dof; /* and of the velocity's */
} fw_single_point_memory;

typedef enum {
	FW_SP_OK = 0,
	FW_SP_NO_RANGES,    /* no satellite with a code and an ephemeris */
	FW_SP_TOO_FEW,      /* fewer satellites than unknowns */
	FW_SP_BAD_GEOMETRY, /* singular, or GDOP above the limit */
	FW_SP_NO_CONVERGENCE
} fw_single_point_status;

/* The name of a status, as tools print it: "too-few-satellites". */
const char *fw_single_point_text(fw_single_point_status status);

/* Solves an epoch.
 *   epoch     in      observations of one receiver
 *   source    in      ephemerides
 *   iono      in      coefficients; NULL: none (broadcast correction is then 0, its uncertainty not)
 *   memory    in/out  may be NULL: start at the Earth's centre, variance factor from this epoch alone
 *   solution  out     untouched unless FW_SP_OK
 * Source: E. D. Kaplan and C. J. Hegarty, "Understanding GPS/GNSS", 3rd ed., 11.2; P. J. G. Teunissen and O. Montenbruck,
 * "Springer Handbook of Global Navigation Satellite Systems", 21.2, 24.1. */
fw_single_point_status fw_single_point(const fw_epoch *epoch, const fw_ephemeris_source *source,
                                       const fw_iono_coefficients *iono,
                                       const fw_single_point_options *options, fw_single_point_memory *memory,
                                       fw_solution *solution) FW_MUST_CHECK;

/* The same from ranges that are made already: for those who mix in ranges of their own. */
fw_single_point_status fw_single_point_ranges(const fw_range *ranges, unsigned n, fw_time tag,
                                              const fw_iono_coefficients *iono,
                                              const fw_single_point_options *options,
                                              fw_single_point_memory *memory,
                                              fw_solution *solution) FW_MUST_CHECK;

#endif
