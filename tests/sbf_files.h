/* The real SBF logs, for tests that want every block of them. Framing here is a plain walk over whole files; the
 * framer proper has tests of its own. */
#ifndef FURROW_TESTS_SBF_FILES_H
#define FURROW_TESTS_SBF_FILES_H

#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/bytes.h"
#include "formats/crc.h"

typedef void sbf_block_fn(const uint8_t *block, size_t length, void *context);

/* Calls for each block of a file whose CRC matches. Returns their number. */
static inline size_t sbf_each_block(const char *path, sbf_block_fn *call, void *context)
{
	static uint8_t bytes[4 << 20];
	FILE *file = fopen(path, "rb");
	if (!file)
		return 0;
	size_t n = fread(bytes, 1, sizeof bytes, file), blocks = 0;
	fclose(file);
	for (size_t at = 0; at + 16 <= n;) {
		const uint8_t *p = bytes + at;
		size_t length = fw_load_u16(p + 6);
		if (p[0] == '$' && p[1] == '@' && length >= 16 && length % 4 == 0 && length <= n - at &&
		    fw_crc16(p + 4, length - 4) == fw_load_u16(p + 2)) {
			call(p, length, context);
			at += length;
			blocks++;
		} else {
			at++;
		}
	}
	return blocks;
}

/* The same for all *.sbf and *.log below $FURROW_DATA/sbf. Returns 0 when there are none. */
static inline size_t sbf_each_real_block(sbf_block_fn *call, void *context)
{
	const char *data = getenv("FURROW_DATA");
	const char *const directories[] = {"sbf", "sbf/pysbf2"};
	size_t blocks = 0;
	for (int i = 0; i < 2; i++) {
		char path[4096];
		snprintf(path, sizeof path, "%s/%s", data ? data : "../shared/data", directories[i]);
		DIR *directory = opendir(path);
		for (struct dirent *entry; directory && (entry = readdir(directory));) {
			const char *dot = strrchr(entry->d_name, '.');
			if (!dot || (strcmp(dot, ".sbf") != 0 && strcmp(dot, ".log") != 0))
				continue;
			snprintf(path, sizeof path, "%s/%s/%s", data ? data : "../shared/data",
			         directories[i], entry->d_name);
			blocks += sbf_each_block(path, call, context);
		}
		if (directory)
			closedir(directory);
	}
	return blocks;
}

#endif
