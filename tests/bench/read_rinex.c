/* Reads RINEX observation files to their ends and says how fast: read_rinex FILE... The bytes are those of the text,
 * unpacked where the file is packed; the records go nowhere. */
#include <inttypes.h>
#include <stdio.h>
#include <time.h>

#include "formats/rinex_obs.h"

static fw_input input;
static fw_rinex_obs reader;

static double now_s(void)
{
	struct timespec t;

	clock_gettime(CLOCK_MONOTONIC, &t);
	return (double)t.tv_sec + (double)t.tv_nsec / 1e9;
}

static int read_file(const char *path)
{
	const double begin_s = now_s();
	uint64_t n[FW_RECORD_COUNT] = {0};
	fw_any_record record;
	fw_kind kind;
	fw_status status = fw_input_open(&input, path);

	if (status != FW_OK) {
		perror(path);
		return 1;
	}
	fw_rinex_obs_begin(&reader, &input);
	while ((status = fw_rinex_obs_read(&reader, &kind, &record)) == FW_OK || status == FW_ESYNTAX)
		n[kind] += status == FW_OK;
	const double took_s = now_s() - begin_s;
	printf("%-10s %8.1f MB/s %10.0f epochs/s %8.2f million observations/s\n", path,
	       (double)input.offset / took_s / 1e6, (double)n[FW_epoch] / took_s,
	       (double)n[FW_obs] / took_s / 1e6);
	fw_input_close(&input);
	return status != FW_EOF || reader.lost > 0;
}

int main(int argc, char **argv)
{
	int failed = argc < 2;

	for (int i = 1; i < argc; i++)
		failed |= read_file(argv[i]);
	return failed;
}
