/* The log that a simulated receiver writes: SBF blocks, epoch by epoch; and whatever else wants its
 * records. */
#ifndef FURROW_CLI_SIM_LOG_H
#define FURROW_CLI_SIM_LOG_H

#include "formats/record.h"
#include "formats/sbf_records.h"
#include "gnss/atmosphere.h"
#include "output.h"
#include "sim_records.h"
#include "tool.h"

enum { SIM_LOG_BUFFER = 256 * 1024 };

/* Large: static. */
typedef struct {
	output out;
	const fw_sbf_plans *plans;
	fw_sink also; /* gets obs, epoch, setup and navigation records too; put NULL: nobody */
	fw_time now;  /* tag of the epoch at hand */
	uint64_t blocks, epochs;
	fw_status refused; /* the first record that could not be written, FW_OK: none */
	uint8_t channel
	    [FW_SATELLITE_COUNT]; /* receiver channels, from 1 in the order in which satellites come up */
	unsigned n_channels;
	const fw_ephemeris *sent[FW_SATELLITE_COUNT]; /* ephemeris last written */
	size_t used;
	uint8_t buffer[SIM_LOG_BUFFER];
} sim_log;

/* Who the log is from. */
typedef struct {
	const char *marker, *receiver, *remark;
	const double *llh; /* of the marker [rad, rad, m]; NULL: not known */
} sim_log_head;

/* Opens the file. Returns FW_EIO with log->out.error set. */
fw_status sim_log_open(sim_log *log, const char *path, const fw_sbf_plans *plans, fw_sink also) FW_MUST_CHECK;

/* ReceiverSetup, Comment, GPSIon, GPSUtc: the beginning, stamped `now`. */
void sim_log_begin(sim_log *log, const sim_log_head *head, const fw_klobuchar *klobuchar, fw_time now);

/* The navigation message of a satellite, unless it is the one last written. */
void sim_log_ephemeris(sim_log *log, const fw_ephemeris *e, fw_time now);

/* MeasEpoch and EndOfMeas. aux NULL: one antenna. */
void sim_log_measurements(sim_log *log, const fw_epoch *main, const fw_epoch *aux, int clock_jumps_ms);

/* PVTGeodetic, PosCovGeodetic, VelCovGeodetic, DOP, EndOfPVT, and ReceiverTime on full seconds. s NULL: no
 * solution. */
void sim_log_solution(sim_log *log, const fw_receiver_solution *s, bool sbas, const fw_epoch *epoch);

/* AttEuler, AttCovEuler, EndOfAtt. a NULL: none. */
void sim_log_attitude(sim_log *log, const fw_receiver_attitude *a, unsigned n_sats);

/* ExtEvent of EventA at GPST t.
 *   clock_s  in  true receiver clock minus GPST, now
 *   bias_s   in  what the receiver takes it for */
void sim_log_event(sim_log *log, fw_time t, double clock_s, double bias_s);

/* Writes what is left and finishes the file, which is not in its place yet (output_commit). Returns FW_EIO
 * with log->out.error set; FW_EINVAL when records were refused. */
fw_status sim_log_end(sim_log *log) FW_MUST_CHECK;

#endif
