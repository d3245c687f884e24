/* SBF's numbering of satellites (SVID) and signals, as in the SBF reference guides, section "Satellite ID and
 * GLONASS frequency number" and "Signal type". */
#ifndef FURROW_FORMATS_SBF_SIGNAL_H
#define FURROW_FORMATS_SBF_SIGNAL_H

#include <stdint.h>

typedef struct {
	char system;         /* RINEX letter: G R E C J I S */
	char rinex[3];       /* RINEX 3 band and attribute, "1C"; "" for the L-band beam, which has none */
	double frequency_hz; /* carrier; GLONASS FDMA: of channel 0; 0 for the L-band beam */
	double channel_spacing_hz; /* GLONASS FDMA: carrier = frequency + k spacing; else 0 */
} fw_sbf_signal;

/* The signal of a number (0..31 from SigIdxLo, or 32 + SigIdxHi), or NULL when none is known by it. */
const fw_sbf_signal *fw_sbf_signal_of(unsigned number);

/* RINEX name of a satellite ("G05", "S123"), or NULL for an SVID that names no satellite (0, L-band beams, the
 * GLONASS satellite of unknown slot). Points to constant storage. */
const char *fw_sbf_satellite(uint8_t svid);

/* The SVID of a RINEX satellite name, or 0. The inverse of fw_sbf_satellite. */
uint8_t fw_sbf_svid(const char *satellite);

#endif
