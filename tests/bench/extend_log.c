/* Makes a long SBF log from a short one: the log's blocks again and again, each time with their stamps moved on by
 * the length of the log, CRCs renewed. For benchmarks and for endless-input tests.
 *
 * usage: extend_log LOG MEGABYTES > OUT     (0 megabytes: without end) */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/bytes.h"
#include "formats/crc.h"
#include "formats/input.h"
#include "formats/sbf_frame.h"

enum { WEEK_MS = 604800000, MAX_LOG = 8 << 20 };

static fw_input input;
static fw_sbf_framer framer;
static uint8_t log_bytes[MAX_LOG];

static int has_stamp(const uint8_t *block)
{
	return fw_load_u16(block + 6) >= 14 && fw_load_u32(block + 8) < WEEK_MS &&
	       fw_load_u16(block + 12) != UINT16_MAX;
}

/* Reads the valid blocks of the log. Returns their bytes together, and the stamps' span to the next whole second. */
static size_t read_log(const char *path, int64_t *span_ms)
{
	size_t n = 0;
	int64_t first = INT64_MAX, last = INT64_MIN;
	fw_sbf_block b;
	if (fw_input_open(&input, path) != FW_OK)
		return 0;
	fw_sbf_init(&framer, &input, NULL, NULL);
	while (fw_sbf_next(&framer, &b) == FW_OK && n + b.length <= sizeof log_bytes) {
		memcpy(log_bytes + n, b.data, b.length);
		if (has_stamp(b.data)) {
			int64_t t = (int64_t)b.week * WEEK_MS + b.tow_ms;
			first = t < first ? t : first;
			last = t > last ? t : last;
		}
		n += b.length;
	}
	fw_input_close(&input);
	*span_ms = n > 0 && last >= first ? (last - first) / 1000 * 1000 + 1000 : 1000;
	return n;
}

static void advance(size_t n, int64_t step_ms)
{
	for (size_t i = 0; i < n; i += fw_load_u16(log_bytes + i + 6)) {
		uint8_t *block = log_bytes + i;
		size_t length = fw_load_u16(block + 6);
		if (!has_stamp(block))
			continue;
		int64_t t = (int64_t)fw_load_u16(block + 12) * WEEK_MS + fw_load_u32(block + 8) + step_ms;
		fw_store_u32(block + 8, (uint32_t)(t % WEEK_MS));
		fw_store_u16(block + 12, (uint16_t)(t / WEEK_MS));
		fw_store_u16(block + 2, fw_crc16(block + 4, length - 4));
	}
}

int main(int argc, char **argv)
{
	if (argc != 3) {
		fprintf(stderr, "usage: extend_log LOG MEGABYTES > OUT\n");
		return 2;
	}
	int64_t span_ms;
	size_t n = read_log(argv[1], &span_ms);
	double wanted = strtod(argv[2], NULL) * 1e6, written = 0;
	if (n == 0)
		return 4;
	while (wanted <= 0 || written < wanted) {
		if (fwrite(log_bytes, 1, n, stdout) != n)
			return 3;
		written += (double)n;
		advance(n, span_ms);
	}
	return fclose(stdout) == 0 ? 0 : 3;
}
