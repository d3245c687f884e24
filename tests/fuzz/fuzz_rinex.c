/* RINEX, observations and navigation, plain and compact. Whatever comes in, records are sound; and
 * observations that were read, written as RINEX 3 and read again are the same. */
#include "text_input.h"

#include "../random_record.h"
#include "formats/rinex_nav.h"
#include "formats/rinex_obs.h"
#include "formats/rinex_write.h"
#include "formats/rinex_write_nav.h"
#include "furrow_obs.h"

#include "record_check.h"

enum { TEXT_MOST = 4 << 20 };

static char text[TEXT_MOST];
static fw_input input;

static const char *const words[] = {
    "> 2024 06 24 08 20  0.0000000  0  2\n",
    "> 2024 06 24 08 20  0.0000000  0999\n",
    ">                              4  1\n",
    " 05  3 24 13 10 36.0000000  0 13G 1G 2G 3",
    "                            4  2\n",
    "G05  24722972.976 1 129920098.14617",
    "R02",
    "S23",
    "C60",
    "SYS / # / OBS TYPES",
    "# / TYPES OF OBSERV ",
    "END OF HEADER",
    "RINEX VERSION / TYPE",
    "SYS / SCALE FACTOR",
    "GLONASS SLOT / FRQ #",
    "G  999",
    "3&1234567",
    "5&-9223372036854775808",
    "&05  3 24",
    " 1.500000000000E+00",
    "-9.999999999999E+99",
    " .999999999999e+09",
    "> EPH G05 LNAV\n",
    "> ION E05 IFNV\n",
    "> STO C05 D1\n",
    "2024 12 31 23 59 60",
    "\r\n",
    "\n\n",
    "                ",
};

static size_t line(uint8_t *data, size_t at, const char *content, const char *label)
{
	return at + (size_t)snprintf((char *)data + at, FUZZ_ROOM - at,
	                             label != NULL ? "%-60s%-20s\n" : "%s\n", content, label);
}

static size_t make_observations(fw_random *r, uint8_t *data, bool old)
{
	size_t n = line(data, 0,
	                old ? "     2.11           OBSERVATION DATA    M"
	                    : "     3.04           OBSERVATION DATA    M",
	                "RINEX VERSION / TYPE");
	if (old) {
		n = line(data, n, "     7    C1    P1    L1    L2    P2    S1    D1", "# / TYPES OF OBSERV");
	} else {
		n = line(data, n, "G    6 C1C L1C D1C S1C C2W L2W", "SYS / # / OBS TYPES");
		n = line(data, n, "R    2 C1C L1C", "SYS / # / OBS TYPES");
		n = line(data, n, "  1 R02 -4", "GLONASS SLOT / FRQ #");
	}
	n = line(data, n, "  2024     6    24     8    20    0.0000000     GPS", "TIME OF FIRST OBS");
	n = line(data, n, "", "END OF HEADER");
	for (unsigned epoch = 0; epoch < 3; epoch++) {
		char one[256];
		snprintf(one, sizeof one,
		         old ? " 24  6 24  8 20 %2u.0000000  0  2G05R02"
		             : "> 2024 06 24 08 20 %2u.0000000  0  2",
		         epoch);
		n = line(data, n, one, NULL);
		for (int i = 0; i < (old ? 4 : 2); i++) {
			const double x = (double)fw_random_below(r, 30000000000) / 1000;
			snprintf(one, sizeof one, "%s%14.3f 5%14.3f%u7",
			         old      ? ""
			         : i == 0 ? "G05"
			                  : "R02",
			         x, x / 0.19, (unsigned)fw_random_below(r, 8));
			n = line(data, n, one, NULL);
		}
	}
	return n;
}

static size_t make_compact(fw_random *r, uint8_t *data)
{
	size_t n = line(data, 0, "3.0                 COMPACT RINEX FORMAT", "CRINEX VERS   / TYPE");
	n = line(data, n, "somebody", "CRINEX PROG / DATE");
	n = line(data, n, "     3.04           OBSERVATION DATA    M", "RINEX VERSION / TYPE");
	n = line(data, n, "G    2 C1C L1C", "SYS / # / OBS TYPES");
	n = line(data, n, "", "END OF HEADER");
	n = line(data, n, "> 2024 06 24 08 20  0.0000000  0  2      G05G06", NULL);
	n = line(data, n, "3&123\n3&20005000615 3&105289483921 &&17\n3&20005000615  1", NULL);
	for (unsigned i = 1; i < 6; i++) {
		char one[128];
		snprintf(one, sizeof one, "                    %u\n1\n%u 17\n%u 5&7 8", i,
		         (unsigned)fw_random_below(r, 1000000), i);
		n = line(data, n, one, NULL);
	}
	return n;
}

static size_t make_navigation(fw_random *r, uint8_t *data)
{
	static const char letters[] = "GEJCRSI";
	size_t n = line(data, 0, "     3.04           NAVIGATION DATA     M", "RINEX VERSION / TYPE");
	n = line(data, n, "GPSA   1.8626E-08  2.2352E-08 -1.1921E-07 -5.9605E-08", "IONOSPHERIC CORR");
	n = line(data, n, "GPUT -9.3132257462E-10-7.993605777E-15 319488 2320", "TIME SYSTEM CORR");
	n = line(data, n, "    18", "LEAP SECONDS");
	n = line(data, n, "", "END OF HEADER");
	for (int i = 0; i < 5; i++) {
		const char letter = letters[fw_random_below(r, 7)];
		char one[128];
		snprintf(one, sizeof one,
		         "%c22 2024 06 24 10 00 00 1.0E-04            1.0E-12            0.0E+00", letter);
		n = line(data, n, one, NULL);
		for (int k = 0; k < (letter == 'R' || letter == 'S' ? 3 : 7); k++) {
			snprintf(one, sizeof one, "    %19.12E%19.12E%19.12E%19.12E",
			         (double)fw_random_below(r, 600000), 1e-3, -2.0,
			         (double)fw_random_below(r, 8));
			n = line(data, n, one, NULL);
		}
	}
	return n;
}

size_t fuzz_make(fw_random *random, uint8_t *data)
{
	switch (fw_random_below(random, 4)) {
	case 0: return make_compact(random, data);
	case 1: return make_navigation(random, data);
	case 2: return make_observations(random, data, true);
	default: return make_observations(random, data, false);
	}
}

/* Every other time the first line stays, so that what follows is read as what it is. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
	size_t head = 0;
	while ((seed & 1) && head < size && data[head++] != '\n')
		;
	return head +
	       text_mutate(data + head, size - head, max - head, seed, words, sizeof words / sizeof *words);
}

/* ---- observations ---- */

/* A sum over what was read that does not depend on the order within an epoch. */
typedef struct {
	uint64_t n, sum;
} digest;

static void add_to(digest *d, fw_kind kind, const fw_any_record *record)
{
	const furrow_obs *o = (const furrow_obs *)(const void *)record;
	fw_time t;
	uint64_t h = 1469598103934665603u;

	if (kind != FW_obs || fw_record_time(record, &t) != FW_OK)
		return;
	const double values[] = {o->pseudorange_m, o->carrier_cyc, o->doppler_hz, o->cn0_dbhz};
	for (size_t i = 0; i < 4; i++) {
		int64_t milli = (int64_t)(values[i] * 1000 + (values[i] < 0 ? -0.5 : 0.5));
		h = (h ^ (uint64_t)milli) * 1099511628211u;
	}
	for (const char *p = o->sat; *p != '\0'; p++)
		h = (h ^ (uint8_t)*p) * 1099511628211u;
	d->n++;
	d->sum += h ^ (uint64_t)(t.ns / 100);
}

static digest read_observations(const void *bytes, size_t n, fw_sink sink)
{
	static fw_rinex_obs reader;
	fw_any_record record;
	fw_kind kind;
	fw_status status;
	digest d = {0, 0};

	fw_input_open_memory(&input, bytes, n);
	fw_rinex_obs_begin(&reader, &input);
	while ((status = fw_rinex_obs_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		require(status == FW_OK || reader.problem.reason[0] != '\0');
		if (status != FW_OK)
			continue;
		record_check(NULL, kind, &record);
		add_to(&d, kind, &record);
		sink.put(sink.context, kind, &record);
	}
	return d;
}

static void drop(void *context, fw_kind kind, const void *record)
{
	(void)context;
	(void)kind;
	(void)record;
}

static void observations(const uint8_t *data, size_t size)
{
	static fw_rinex_survey survey;
	static fw_rinex_obs_writer writer;
	memory out = {text, TEXT_MOST, 0};

	fw_rinex_survey_begin(&survey);
	read_observations(data, size, (fw_sink){fw_rinex_survey_put, &survey});
	fw_rinex_obs_write(&writer, &survey, 0, to_memory, &out);
	read_observations(data, size, (fw_sink){fw_rinex_obs_put, &writer});
	require(fw_rinex_obs_end(&writer) == FW_OK);
	/* Once more: what RINEX 3.04 cannot say (duplicates, factors) is gone now. */
	static char first[TEXT_MOST];
	memcpy(first, text, out.used);
	const size_t n = out.used;
	out.used = 0;
	fw_rinex_survey_begin(&survey);
	const digest a = read_observations(first, n, (fw_sink){fw_rinex_survey_put, &survey});
	fw_rinex_obs_write(&writer, &survey, 0, to_memory, &out);
	read_observations(first, n, (fw_sink){fw_rinex_obs_put, &writer});
	require(fw_rinex_obs_end(&writer) == FW_OK);
	const digest b = read_observations(text, out.used, (fw_sink){drop, NULL});
	require(a.n == b.n && a.sum == b.sum);
}

/* ---- navigation ---- */

static uint64_t read_navigation(const void *bytes, size_t n, fw_sink sink)
{
	static fw_rinex_nav reader;
	fw_any_record record;
	fw_kind kind;
	fw_status status;

	fw_input_open_memory(&input, bytes, n);
	fw_rinex_nav_begin(&reader, &input);
	while ((status = fw_rinex_nav_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX) {
		require(status == FW_OK || reader.problem.reason[0] != '\0');
		if (status != FW_OK)
			continue;
		record_check(NULL, kind, &record);
		sink.put(sink.context, kind, &record);
	}
	return reader.lost;
}

static void navigation(const uint8_t *data, size_t size)
{
	static fw_rinex_survey survey;
	static fw_rinex_nav_writer writer;
	memory out = {text, TEXT_MOST, 0};

	fw_rinex_survey_begin(&survey);
	(void)read_navigation(data, size, (fw_sink){fw_rinex_survey_put, &survey});
	fw_rinex_nav_write(&writer, &survey, to_memory, &out);
	(void)read_navigation(data, size, (fw_sink){fw_rinex_nav_put, &writer});
	require(fw_rinex_nav_end(&writer) == FW_OK);
	(void)read_navigation(text, out.used, (fw_sink){drop, NULL});
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	(void)fw_rinex_detect(data, size);
	observations(data, size);
	navigation(data, size);
	return 0;
}
