/* Satellites and signals: the names that RINEX gives them, and their carrier frequencies. */
#ifndef FURROW_GNSS_SIGNAL_H
#define FURROW_GNSS_SIGNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

/** CGPM: speed of light [m/s] */
#define FW_SPEED_OF_LIGHT_MPS 299792458.0

/* Satellite systems, in the order in which furrow lists them. */
typedef enum {
	FW_GPS,
	FW_GALILEO,
	FW_BEIDOU,
	FW_GLONASS,
	FW_QZSS,
	FW_NAVIC,
	FW_SBAS,
	FW_SYSTEM_COUNT
} fw_system;

/* A satellite: system and number as in RINEX (GPS 1.., SBAS PRN - 100). number 0: none. */
typedef struct {
	uint8_t system; /* fw_system */
	uint8_t number;
} fw_satellite;

enum { FW_SATELLITES_PER_SYSTEM = 64, FW_SATELLITE_COUNT = FW_SYSTEM_COUNT * FW_SATELLITES_PER_SYSTEM };

/* A dense index of a satellite for tables, 0 .. FW_SATELLITE_COUNT - 1. */
static inline unsigned fw_satellite_index(fw_satellite s)
{
	return (unsigned)s.system * FW_SATELLITES_PER_SYSTEM + s.number % FW_SATELLITES_PER_SYSTEM;
}

static inline bool fw_satellite_equal(fw_satellite a, fw_satellite b)
{
	return a.system == b.system && a.number == b.number;
}

/* "G05", "S123" (SBAS also as "S23") to a satellite and back. "G 5" and "  5", as old files have it, are read
 * too. Numbers are 1 .. 63; name holds 5 characters with the NUL; SBAS as "S123".
 * Returns FW_ESYNTAX: no satellite; *s untouched. */
fw_status fw_satellite_parse(const char *name, fw_satellite *s) FW_MUST_CHECK;
void fw_satellite_name(fw_satellite s, char name[static 5]);

/* RINEX letter of a system and back; FW_SYSTEM_COUNT when there is none. */
char fw_system_letter(fw_system system);
fw_system fw_system_of_letter(char letter);

/* A signal within its system: RINEX 3 band digit and attribute letter, {'1','C'}. band 0: none. */
typedef struct {
	char band, attribute;
} fw_signal;

/* Carrier frequency [Hz]; GLONASS FDMA bands need the channel k (-7..6). 0 for a band that the system does
 * not have. Sources: IS-GPS-200, IS-GPS-705, Galileo OS SIS ICD 2.1, BDS-SIS-ICD B1I 3.0 / B1C / B2a / B2b /
 * B3I, GLONASS ICD 5.1, IS-QZSS-PNT, IRNSS SPS ICD, RINEX 4.01 tables 4 to 10. */
double fw_signal_frequency_hz(fw_system system, fw_signal signal, int glonass_channel);

#endif
