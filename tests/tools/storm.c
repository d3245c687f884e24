/* Makes input that is no log: noise, or what would cost a careless framer much time.
 *
 * usage: storm noise|longest|pairs|dollars|hopes|claims MEBIBYTES > OUT
 *
 *   noise    random bytes
 *   longest  headers that claim 65,532 bytes each
 *   claims   headers that claim all lengths
 *   pairs    $@$@$@...
 *   dollars  $$$...
 *   hopes    a good block and a header that claims 65,532 bytes, in turns */
#include "../sbf_stream.h"

enum { CHUNK = 1 << 20 };

static void repeat(uint8_t *p, const uint8_t *pattern, size_t n)
{
	for (size_t i = 0; i < CHUNK; i++)
		p[i] = pattern[i % n];
}

static int make_chunk(const char *kind, uint8_t *p, uint64_t *seed)
{
	static const uint8_t header[8] = {'$', '@', 0, 0, 0xa0, 0x0f, 0xfc, 0xff};
	uint8_t pair[32] = {0};

	if (strcmp(kind, "noise") == 0) {
		fill_random(seed, p, CHUNK);
	} else if (strcmp(kind, "longest") == 0 || strcmp(kind, "claims") == 0) {
		repeat(p, header, sizeof header);
		for (size_t i = 6; kind[0] == 'c' && i < CHUNK; i += sizeof header)
			put_u2(p + i, below(seed, 16384) * 4);
	} else if (strcmp(kind, "pairs") == 0 || strcmp(kind, "dollars") == 0) {
		repeat(p, (const uint8_t *)(kind[0] == 'p' ? "$@" : "$$"), 2);
	} else if (strcmp(kind, "hopes") == 0) {
		seal_block(pair, 4000, 24);
		memcpy(pair + 24, header, sizeof header);
		repeat(p, pair, sizeof pair);
	} else {
		return 0;
	}
	return 1;
}

int main(int argc, char **argv)
{
	static uint8_t chunk[CHUNK];
	uint64_t seed = 3;
	long n = argc == 3 ? strtol(argv[2], NULL, 10) : -1;

	for (; n > 0; n--)
		if (!make_chunk(argv[1], chunk, &seed) || fwrite(chunk, 1, CHUNK, stdout) != CHUNK)
			return 3;
	return n == 0 && fclose(stdout) == 0 ? 0 : 2;
}
