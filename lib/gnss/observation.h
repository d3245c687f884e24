/* One epoch of observations, as the solvers take it. */
#ifndef FURROW_GNSS_OBSERVATION_H
#define FURROW_GNSS_OBSERVATION_H

#include "base/time.h"
#include "gnss/signal.h"

/* Bits of fw_observation.has */
enum { FW_HAS_CODE = 1, FW_HAS_CARRIER = 2, FW_HAS_DOPPLER = 4, FW_HAS_CN0 = 8, FW_HAS_LOCK = 16 };

typedef struct {
	fw_satellite satellite;
	fw_signal signal;
	int8_t glonass_channel; /* FDMA frequency number; INT8_MIN: not known or not FDMA */
	uint8_t has;            /* FW_HAS_... */
	bool half_cycle;        /* the carrier may be off by half a cycle */
	bool slip;     /* continuity of the carrier was lost since the epoch before, as the receiver says */
	double code_m; /* pseudorange */
	double carrier_cyc; /* carrier phase, decreasing range = decreasing phase */
	double doppler_hz;  /* positive: approaching */
	double cn0_dbhz;
	double lock_s;
} fw_observation;

enum { FW_EPOCH_MAX = 512 };

/* Observations of one antenna at one receiver time tag, those of a satellite together. */
typedef struct {
	fw_time time; /* receiver time tag */
	unsigned n;
	fw_observation obs[FW_EPOCH_MAX];
} fw_epoch;

#endif
