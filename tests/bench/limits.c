/* How fast a log can be read, checked and walked at best on this machine: what sbf2csv's times are held against.
 *
 * usage: limits LOG     prints "read MB/s", "crc MB/s" and "walk MB/s", the best of several runs each */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "formats/bytes.h"
#include "formats/crc.h"
#include "formats/input.h"
#include "formats/sbf_frame.h"

enum { RUNS = 5, PIECE = 1 << 17, KEPT = 8 << 20 };

static fw_input input;
static fw_sbf_framer framer;
static uint8_t piece[PIECE], blocks[KEPT];

static double now_s(void)
{
	struct timespec t;

	clock_gettime(CLOCK_MONOTONIC, &t);
	return (double)t.tv_sec + (double)t.tv_nsec / 1e9;
}

/* Each returns the number of bytes it has gone through, 0 if it could not. */
static size_t read_all(const char *path)
{
	size_t total = 0, n;
	FILE *file = fopen(path, "rb");

	if (file == NULL)
		return 0;
	setvbuf(file, NULL, _IONBF, 0);
	while ((n = fread(piece, 1, sizeof piece, file)) > 0)
		total += n;
	fclose(file);
	return total;
}

static size_t walk(const char *path)
{
	fw_sbf_block b;

	if (fw_input_open(&input, path) != FW_OK)
		return 0;
	fw_sbf_init(&framer, &input, NULL, NULL);
	while (fw_sbf_next(&framer, &b) == FW_OK)
		;
	fw_input_close(&input);
	return (size_t)framer.stats.bytes_good;
}

/* The first blocks of the log, one after the other in memory. */
static size_t keep(const char *path)
{
	size_t n = 0;
	fw_sbf_block b;

	if (fw_input_open(&input, path) != FW_OK)
		return 0;
	fw_sbf_init(&framer, &input, NULL, NULL);
	while (fw_sbf_next(&framer, &b) == FW_OK && n + b.length <= sizeof blocks) {
		memcpy(blocks + n, b.data, b.length);
		n += b.length;
	}
	fw_input_close(&input);
	return n;
}

static size_t check(size_t n)
{
	unsigned wrong = 0;

	for (size_t i = 0; i < n; i += fw_load_u16(blocks + i + 6))
		wrong +=
		    fw_crc16(blocks + i + 4, fw_load_u16(blocks + i + 6) - 4U) != fw_load_u16(blocks + i + 2);
	return wrong == 0 ? n : 0;
}

int main(int argc, char **argv)
{
	double read_mbps = 0, crc_mbps = 0, walk_mbps = 0;
	size_t kept = argc == 2 ? keep(argv[1]) : 0;

	if (kept == 0) {
		fprintf(stderr, "usage: limits LOG\n");
		return 2;
	}
	for (int run = 0; run < RUNS; run++) {
		double start = now_s(), n = (double)read_all(argv[1]), mbps = n / 1e6 / (now_s() - start);
		read_mbps = mbps > read_mbps ? mbps : read_mbps;
		start = now_s(), n = (double)check(kept), mbps = n / 1e6 / (now_s() - start);
		crc_mbps = mbps > crc_mbps ? mbps : crc_mbps;
		start = now_s(), n = (double)walk(argv[1]), mbps = n / 1e6 / (now_s() - start);
		walk_mbps = mbps > walk_mbps ? mbps : walk_mbps;
	}
	printf("read %.0f\ncrc %.0f\nwalk %.0f\n", read_mbps, crc_mbps, walk_mbps);
	return 0;
}
