#include "gnss/signal.h"

#include <string.h>

static const char letters[FW_SYSTEM_COUNT] = {
    [FW_GPS] = 'G',  [FW_GALILEO] = 'E', [FW_BEIDOU] = 'C', [FW_GLONASS] = 'R',
    [FW_QZSS] = 'J', [FW_NAVIC] = 'I',   [FW_SBAS] = 'S',
};

/* Bands of each system [Hz], by the digit that RINEX gives them. */
static const double bands[FW_SYSTEM_COUNT][10] = {
    [FW_GPS] = {[1] = 1575.42e6, [2] = 1227.60e6, [5] = 1176.45e6},
    [FW_GALILEO] = {[1] = 1575.42e6, [5] = 1176.45e6, [6] = 1278.75e6, [7] = 1207.14e6, [8] = 1191.795e6},
    [FW_BEIDOU] = {[1] = 1575.42e6,
                   [2] = 1561.098e6,
                   [5] = 1176.45e6,
                   [6] = 1268.52e6,
                   [7] = 1207.14e6,
                   [8] = 1191.795e6},
    [FW_GLONASS] = {[1] = 1602e6, [2] = 1246e6, [3] = 1202.025e6, [4] = 1600.995e6, [6] = 1248.06e6},
    [FW_QZSS] = {[1] = 1575.42e6, [2] = 1227.60e6, [5] = 1176.45e6, [6] = 1278.75e6},
    [FW_NAVIC] = {[1] = 1575.42e6, [5] = 1176.45e6, [9] = 2492.028e6},
    [FW_SBAS] = {[1] = 1575.42e6, [5] = 1176.45e6},
};

/** GLONASS ICD L1, L2, edition 5.1, 3.3.1.1: spacing of the channels [Hz] */
#define GLONASS_SPACING_1 562.5e3
#define GLONASS_SPACING_2 437.5e3
enum { GLONASS_CHANNEL_MIN = -7, GLONASS_CHANNEL_MAX = 6 };

char fw_system_letter(fw_system system)
{
	return (unsigned)system < FW_SYSTEM_COUNT ? letters[system] : '?';
}

fw_system fw_system_of_letter(char letter)
{
	unsigned system = 0;

	while (system < FW_SYSTEM_COUNT && letters[system] != letter)
		system++;
	return (fw_system)system;
}

static bool is_digit(char c)
{
	return c >= '0' && c <= '9';
}

fw_status fw_satellite_parse(const char *name, fw_satellite *s)
{
	const fw_system system = fw_system_of_letter(name[0] == ' ' ? 'G' : name[0]);
	const char *digits = name + 1;
	int number;

	if (name[0] == '\0' || system == FW_SYSTEM_COUNT)
		return FW_ESYNTAX;
	if (system == FW_SBAS && digits[0] == '1' && strlen(digits) == 3)
		digits++; /* the PRN itself */
	if ((digits[0] != ' ' && !is_digit(digits[0])) || !is_digit(digits[1]) || digits[2] != '\0')
		return FW_ESYNTAX;
	number = (digits[0] == ' ' ? 0 : 10 * (digits[0] - '0')) + digits[1] - '0';
	if (number < 1 || number >= FW_SATELLITES_PER_SYSTEM)
		return FW_ESYNTAX;
	*s = (fw_satellite){(uint8_t)system, (uint8_t)number};
	return FW_OK;
}

void fw_satellite_name(fw_satellite s, char name[static 5])
{
	const unsigned number = s.system == FW_SBAS ? s.number + 100U : s.number;
	char *p = name;

	*p++ = fw_system_letter((fw_system)s.system);
	if (number >= 100)
		*p++ = (char)('0' + number / 100);
	*p++ = (char)('0' + number / 10 % 10);
	*p++ = (char)('0' + number % 10);
	*p = '\0';
}

double fw_signal_frequency_hz(fw_system system, fw_signal signal, int glonass_channel)
{
	if ((unsigned)system >= FW_SYSTEM_COUNT || !is_digit(signal.band))
		return 0;

	const double frequency = bands[system][signal.band - '0'];

	if (system != FW_GLONASS || (signal.band != '1' && signal.band != '2'))
		return frequency;
	if (glonass_channel < GLONASS_CHANNEL_MIN || glonass_channel > GLONASS_CHANNEL_MAX)
		return 0;
	return frequency + glonass_channel * (signal.band == '1' ? GLONASS_SPACING_1 : GLONASS_SPACING_2);
}
