/* What the simulator has to what a receiver logs: ephemerides, observations and solutions as records. */
#ifndef FURROW_CLI_SIM_RECORDS_H
#define FURROW_CLI_SIM_RECORDS_H

#include "formats/record.h"
#include "furrow_att.h"
#include "furrow_dop.h"
#include "furrow_obs.h"
#include "furrow_pvt.h"
#include "gnss/ephemeris.h"
#include "gnss/observation.h"
#include "sim/receiver.h"

/* The stamp that all records begin with. */
void record_stamp(void *record, fw_time t);

/* A broadcast ephemeris as the record of its system, stamped with the moment at which it was received.
 *   record  out  its strings are constant, or point into `name`
 * Returns the record's kind, or FW_RECORD_COUNT: a system that has none. */
fw_kind ephemeris_record(const fw_ephemeris *e, fw_time received, fw_any_record *record, char name[static 5]);

/* An observation. satellite and signal hold the record's strings. */
void observation_record(const fw_observation *o, fw_time tag, int antenna, int channel, furrow_obs *record,
                        char satellite[static 5], char signal[static 3]);

/* The receiver's solution; NULL: there is none.
 *   signals  in  bits of the SBF signal numbers used */
void pvt_record(const fw_receiver_solution *s, fw_time tag, bool sbas, int64_t signals, furrow_pvt *record);
void dop_record(const fw_receiver_solution *s, fw_time tag, furrow_dop *record);

/* The attitude of two antennas; NULL: there is none. */
void att_record(const fw_receiver_attitude *a, unsigned n_sats, fw_time tag, furrow_att *record);

#endif
