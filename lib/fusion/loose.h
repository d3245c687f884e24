/* The recipe `loose`: an INS corrected by positions and velocities of a GNSS receiver, by headings and a barometer.
 *
 * Items (fixes, headings, ...) come first, then the IMU sample that ends at their time or after it: the sample is divided at
 * each item's time, so that everything is used when it was measured. A sample or an item that is not usable is
 * refused, with a cause, and counted; nothing that is not finite gets in. */
#ifndef FURROW_FUSION_LOOSE_H
#define FURROW_FUSION_LOOSE_H

#include <stdint.h>

#include "fusion/adapt.h"
#include "fusion/filter.h"
#include "ins/heading_table.h"
#include "ins/magnetometer.h"
#include "ins/stillness.h"
#include "integrity/state_machine.h"

/* An IMU sample: averages over the interval that ends at its time. */
typedef struct {
	fw_time time;
	double gyro_radps[3];
	double accel_mps2[3];
} fw_imu_reading;

typedef enum {
	FW_ITEM_FIX,     /* position, and velocity if there is one */
	FW_ITEM_HEADING, /* of the body, by two antennas */
	FW_ITEM_FIELD,   /* magnetometer, body axes, calibrated as the ground calibration can */
	FW_ITEM_HEIGHT,  /* barometer */
	FW_ITEM_LEVELS,  /* protection levels and state */
	FW_ITEM_MARK     /* an event: nothing but a moment at which the state is wanted */
} fw_item_kind;

typedef struct {
	fw_time time;
	fw_item_kind kind;
	union {
		struct {
			bool has_position, has_velocity;
			double llh[3];           /* of the antenna */
			double R_position[3][3]; /* [m^2] NED */
			double velocity_mps[3];  /* NED */
			double R_velocity[3][3]; /* [m^2/s^2] NED */
		} fix;
		struct {
			double heading_rad, sd_rad;
		} heading;
		struct {
			double b_ut[3]; /* FRD */
		} field;
		struct {
			double height_m;
		} height;
		struct {
			double hpl_m, vpl_m;      /* NAN: not known */
			fw_integrity_state state; /* of the integrity monitor */
		} levels;
		struct {
			uint64_t number; /* the caller's */
		} mark;
	};
} fw_item;

/* Why something was not used. */
typedef enum {
	FW_REFUSED_NOT_FINITE,
	FW_REFUSED_RANGE,     /* beyond what the sensor or the Earth allows */
	FW_REFUSED_SIGMA,     /* covariance not positive definite, or out of all proportion */
	FW_REFUSED_DUPLICATE, /* the time of the one before */
	FW_REFUSED_BACKWARDS, /* before the time of the one before */
	FW_REFUSED_LATE,      /* before the present time of the filter */
	FW_REFUSED_GATE,      /* innovation too large for its covariance */
	FW_REFUSED_INTEGRITY, /* state UNRELIABLE */
	FW_REFUSED_OVERFLOW,  /* too many items at once */
	FW_REFUSED_COUNT
} fw_refusal;

const char *fw_refusal_text(fw_refusal why);

/* What is wrong with the numbers of an IMU reading: not finite, beyond what the sensors can measure [rad/s], [m/s^2], or those
 * of a dead sensor: a denormal number, or an accelerometer that says exactly 0 where gravity should be.
 * Returns FW_REFUSED_COUNT: nothing. */
fw_refusal fw_examine_reading(const fw_imu_reading *r, double gyro_max, double accel_max);

typedef struct {
	/* the sensors, in SI units */
	double gyro_noise, accel_noise;     /* [rad/sqrt(s)], [m/s/sqrt(s)] */
	double gyro_bias_sd, accel_bias_sd; /* of the turn-on bias [rad/s], [m/s^2] */
	double gyro_bias_walk,
	    accel_bias_walk; /* what the bias changes during the run: Gauss-Markov, standard deviation */
	double gyro_bias_tau_s, accel_bias_tau_s; /* and correlation time */
	double gyro_scale_sd, accel_scale_sd;     /* [1]; 0: not estimated */
	double gyro_matrix, accel_matrix; /* scale and misalignment that are not estimated, sigma [1] */

	/* how things are mounted */
	double lever_b[3]; /* antenna from the IMU, body axes [m] */

	/* what is believed of the fixes */
	double position_sd[3], velocity_sd[3];       /* NED; > 0: in place of what the receiver says */
	double position_floor_m, velocity_floor_mps; /* least sigma that is believed */
	fw_adapt_options adapt;
	double gate; /* a fix that would come with less than this probability is refused; 0: all are taken */
	int gate_patience; /* after so many refused fixes in a row they are believed, with the covariance that it takes; 0: never */

	/* compass */
	bool use_field;
	double field_sd_rad; /* of a magnetic heading, not corrected by the table */
	double field_tau_s;  /* headings follow each other this far apart at least [s] */
	bool use_table;
	double declination_rad; /* to be added; NAN: from the World Magnetic Model */

	/* barometer */
	double height_sd_m, height_drift_m, height_tau_s; /* white; wandering and its time; 0: not used */

	/* stillness */
	bool use_still;
	fw_stillness_setup still;
	double still_sd_mps;

	/* wheels: sd of sideways and vertical velocity [m/s]; 0: no wheels */
	double wheels_sd_mps;

	/* IMU samples */
	double gap_s;               /* a gap up to this is bridged; a longer one ends the run of the filter */
	double gyro_max, accel_max; /* beyond: refused [rad/s], [m/s^2] */
	double node_s;              /* nodes for the smoother are at most so far apart */
} fw_loose_options;

extern const fw_loose_options fw_loose_defaults;

struct fw_loose;

/* What happens, for those who write it down. Any may be NULL. The filter is to be looked at, not changed. */
typedef struct {
	void *context;
	void (*sample)(void *context,
	               const struct fw_loose *l); /* the filter is at the time of an IMU sample */
	void (*mark)(void *context, const struct fw_loose *l, uint64_t number); /* ... of an event */
	void (*node)(void *context, const struct fw_loose *l); /* a node is complete: l->node */
	void (*refused)(void *context, fw_time when, const char *what, fw_refusal why,
	                double size); /* size: of the innovation in sigmas, at the gate */
} fw_loose_hooks;

/* What a smoother needs of a moment: the estimate before and after its measurements, and the way from the node before. */
typedef struct {
	fw_time time;
	fw_pva predicted, filtered;
	double x_predicted[FW_STATES_MAX], x_filtered[FW_STATES_MAX];
	double P_predicted[FW_STATES_MAX][FW_STATES_MAX], P_filtered[FW_STATES_MAX][FW_STATES_MAX];
	double transition[FW_STATES_MAX][FW_STATES_MAX]; /* from the node before to this one */
} fw_node;

enum { FW_LOOSE_QUEUE = 256 };

typedef struct {
	uint64_t samples, bridged, gaps; /* IMU samples used; gaps that were bridged, and that ended a run */
	uint64_t strayed;                /* runs that ended because all fixes were somewhere else */
	uint64_t samples_refused[FW_REFUSED_COUNT];
	uint64_t used[FW_ITEM_MARK + 1];
	uint64_t refused[FW_ITEM_MARK + 1][FW_REFUSED_COUNT];
	uint64_t still, forced; /* zero-velocity updates; fixes believed after too many were refused */
	double nis_sum,
	    position_nis_sum; /* normalised innovations squared, of positions and velocities that were used; of the */
	uint64_t nis_rows, position_nis_rows; /* positions alone; and how many rows they had */
} fw_loose_counts;

typedef struct fw_loose {
	fw_loose_options options;
	fw_loose_hooks hooks;
	fw_filter filter;
	fw_loose_counts counts;
	fw_node node; /* under way; filled only while hooks.node is set */
	fw_integrity_state integrity;
	fw_levels levels;
	fw_time levels_time;
	fw_time last_fix; /* that was used */
	bool running;

	/* Private from here. */
	fw_imu_reading last; /* the last sample */
	double interval_s;   /* usual interval of samples */
	fw_time item_time[FW_ITEM_MARK + 1];
	fw_item queue[FW_LOOSE_QUEUE];
	int queued;
	int refused_in_row[FW_ITEM_MARK + 1];
	double push_mps[3]; /* change of velocity by what the IMU feels, since */
	fw_time rest_since;
	fw_time begun;        /* the run; or anew, with fixes that it had refused */
	int half_refused[2];  /* positions and velocities in a row */
	fw_time half_used[2]; /* the last that were used */
	int doubts;           /* of the attitude, not long after each other */
	fw_time doubted;
	fw_vb_scale vb[4];
	fw_stillness stillness;
	fw_time still_time, field_time;
	fw_heading_table table;
	fw_imu_reading suspect; /* far ahead in time: a gap, or a wrong time? */
	bool has_last, has_suspect, node_open;
	bool lost;              /* all fixes are somewhere else */
	double field_ned_nt[3]; /* the Earth's, of the first reading; 0: not yet */
	double compass_off_rad; /* magnetic heading minus the filter's, of the last reading, for the table */
	bool has_compass;
	double gate_limit[4]; /* chi-square limits for 1, 2, 3 rows */
} fw_loose;

/* Starts. The heading table and what was counted live on through fw_loose_restart.
 * Returns FW_OK; FW_EINVAL (an option out of range). */
fw_status fw_loose_init(fw_loose *l, const fw_loose_options *o, const fw_loose_hooks *hooks) FW_MUST_CHECK;

/* Begins a run at an aligned state.
 *   pva           in  of the IMU
 *   attitude_sd   in  NED [rad]; velocity_sd [m/s], position_sd [m], NED
 *   gyro_bias     in  first guess [rad/s], and its sd; NULL: 0 and the option's
 * Returns FW_OK; FW_ENONFINITE, FW_EINVAL. */
fw_status fw_loose_start(fw_loose *l, const fw_pva *pva, const double attitude_sd[static 3],
                         const double velocity_sd[static 3], const double position_sd[static 3],
                         const double *gyro_bias, const double *gyro_bias_sd) FW_MUST_CHECK;

/* Is an item fit to be used at all? For those who keep items until a run begins. Its covariance becomes what the options say; if
 * it is unusable it is refused and counted. Its time is not looked at. */
bool fw_loose_usable(fw_loose *l, fw_item *item);

/* Takes an item, for the sample that ends at its time or after it. Items come in order of time. Items before the present time are
 * refused. Without a run (not started, or lost) only levels and marks are taken. */
void fw_loose_item(fw_loose *l, const fw_item *item);

/* Takes an IMU sample. Returns FW_OK; FW_DUBIOUS: the sample was refused (counted) and the filter is where it was; FW_EUNKNOWN:
 * the run is over (l->running is false), because of a gap too long to bridge or because too many fixes in a row were far away from
 * here; alignment has to begin anew, with this sample. */
fw_status fw_loose_imu(fw_loose *l, const fw_imu_reading *sample) FW_MUST_CHECK;

/* No more samples: one that was far ahead in time, and waited for the next to say whether that was a gap, is refused. */
void fw_loose_end(fw_loose *l);

/* Standard deviations of roll, pitch and heading of the body [rad]: from the covariance of phi, and from the misalignment of the gyros, which
 * are what the filter's attitude is the attitude of. */
void fw_attitude_sd(const fw_filter *f, double rpy_sd[static 3]);

#endif
