/* The compressed measurement blocks of SBF, Meas3Ranges (4109) and its extensions Meas3CN0HiRes (4110), Meas3Doppler
 * (4111), Meas3PP (4112) and Meas3MP (4113), to the records that MeasEpoch and MeasExtra give.
 *
 * Meas3Ranges holds every signal in full at reference epochs (each 0.5 s to 2 min) and, in between, what changed
 * since the last of these. An epoch whose reference is missing cannot be known; it becomes no record and is counted.
 * The extensions say more about the signals of the Meas3Ranges of their epoch and antenna, in its order; that is why
 * blocks are held until the epoch is complete.
 *
 * Source: the reference guides tell what the blocks hold, not their layout. That is as in Septentrio's own decoder
 * (sbfread_meas.c and sbfdef.h of RxTools' sbf2asc) and in RTKLIB's septentrio.c, which agree; sbf_meas3.c has it,
 * and the few places where they differ. */
#ifndef FURROW_FORMATS_SBF_MEAS3_H
#define FURROW_FORMATS_SBF_MEAS3_H

#include <stdint.h>

#include "base/status.h"
#include "formats/record.h"

enum {
	FW_MEAS3_BLOCKS = 5,      /* Meas3Ranges and its four extensions */
	FW_MEAS3_ANTENNAS = 3,    /* main, aux1, aux2 */
	FW_MEAS3_SYSTEMS = 7,     /* G R E C S J I, in this order */
	FW_MEAS3_SATELLITES = 64, /* of one system */
	FW_MEAS3_SIGNALS = 8,     /* of one satellite: more have no meaning yet */
	FW_MEAS3_ROOM = 65536     /* for the blocks of one epoch [bytes]; receivers fill a few thousand */
};

/* What came of the input. */
typedef struct {
	uint64_t lost_epochs;  /* Meas3Ranges whose reference epoch is missing */
	uint64_t lost_signals; /* signals that lean on one which is missing, in an epoch that was decoded */
	uint64_t
	    malformed; /* Meas3Ranges that end too early or contradict themselves: no record made of them */
	uint64_t scrambled;     /* Meas3Ranges that only Septentrio can read */
	uint64_t orphans;       /* extensions without their Meas3Ranges */
	uint64_t other_antenna; /* observations left out because of their antenna */
} fw_sbf_meas3_stats;

/* A signal as measured. */
typedef struct {
	double range_m, carrier_cyc;
	int32_t lock_ms; /* at least */
	int16_t cn0_dbhz;
	uint8_t number; /* SBF's signal number */
	uint8_t known;  /* which of the others mean something */
} fw_sbf_meas3_signal;

/* A satellite as measured at the reference epoch, signals by their index. */
typedef struct {
	fw_sbf_meas3_signal signals[FW_MEAS3_SIGNALS];
	int16_t rate;    /* of the pseudorange [64 mm/s] */
	uint16_t slaves; /* bit i: signal i followed the master */
	uint8_t master;  /* index of the signal that came first */
	uint32_t stamp;  /* of the reference epoch that this is of */
} fw_sbf_meas3_satellite;

/* Which satellites and signals a system's measurements are of. */
typedef struct {
	uint64_t satellites;
	uint8_t glonass[FW_MEAS3_SATELLITES / 2]; /* four bits each: frequency number + 8 */
	uint16_t far;                             /* BeiDou: bit n: the n-th satellite is not a MEO */
	uint8_t excluded;                         /* bit i: signal i of the table does not occur */
	uint8_t short_master;                     /* signal index of all short masters */
} fw_sbf_meas3_layout;

typedef struct {
	uint32_t tow_ms;
	uint16_t week;
	uint8_t valid;
	uint32_t stamp; /* counts reference epochs */
	fw_sbf_meas3_layout layout[FW_MEAS3_SYSTEMS];
	fw_sbf_meas3_satellite satellites[FW_MEAS3_SYSTEMS][FW_MEAS3_SATELLITES];
} fw_sbf_meas3_reference;

/* Owned by the caller: about 340 KiB. Only stats is for reading. */
typedef struct {
	fw_sbf_meas3_stats stats;

	unsigned antennas;
	fw_kind_set wanted;
	fw_sink sink;

	/* The blocks of the epoch that is open. */
	uint32_t tow_ms;
	uint16_t week;
	uint32_t used;
	struct {
		uint32_t at;     /* in bytes[] */
		uint16_t length; /* 0: none */
	} held[FW_MEAS3_ANTENNAS][FW_MEAS3_BLOCKS];
	uint8_t bytes[FW_MEAS3_ROOM];

	fw_sbf_meas3_reference reference[FW_MEAS3_ANTENNAS];
} fw_sbf_meas3;

/* Gets ready for the first block.
 *   antennas  which are wanted: FW_ANTENNA_... of formats/sbf_measurements.h
 *   wanted    of epoch, obs, obs_extra; copied
 *   sink      where records go, at the latest by fw_sbf_meas3_flush() */
void fw_sbf_meas3_init(fw_sbf_meas3 *m, unsigned antennas, const fw_kind_set *wanted, fw_sink sink);

/* Takes the next block, whole, header included, its CRC checked. A block of another time closes the epoch that is
 * open, and so does EndOfMeas (5922). A closed epoch becomes, antenna by antenna,
 *   obs        per signal, in meaning as of MeasEpoch: cn0_dbhz has steps of 1 dB-Hz; lock_s is a lower bound, at
 *              most 60, and absent while half_cycle is 1; doppler_hz comes from Meas3Doppler; smoothed is 0 when the
 *              epoch has no smoothed code, else absent, for it is not said which are; rx_channel is absent
 *   obs_extra  per signal, if there is an extension: cn0_highres_dbhz (Meas3CN0HiRes, steps of 1/16 dB-Hz);
 *              loss_count (modulo 16) and info (bit 0: multipath mitigation is settling) from Meas3PP;
 *              multipath_corr_m and carrier_multipath_corr_cyc (Meas3MP)
 * and then one epoch for all antennas.
 * Returns FW_OK; FW_EUNKNOWN: another block, nothing was done; FW_EFORMAT: too short, of a version or antenna that is
 * not known, or the second of its kind in an epoch; FW_ENOSPACE: the epoch is larger than FW_MEAS3_ROOM. In the last
 * two cases the block is left out. */
fw_status fw_sbf_meas3_put(fw_sbf_meas3 *m, const uint8_t *block, uint16_t length) FW_MUST_CHECK;

/* Closes the epoch that is open: at the end of a log. */
void fw_sbf_meas3_flush(fw_sbf_meas3 *m);

#endif
