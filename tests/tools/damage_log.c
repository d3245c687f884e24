/* Damages blocks of a log whose blocks are all whole: a bit, or up to eight bytes in a row, each block at most once.
 *
 * usage: damage_log N SEED < LOG > OUT */
#include "../sbf_stream.h"

enum { ROOM = 64 << 20 };

int main(int argc, char **argv)
{
	struct stream s = new_stream(ROOM, ROOM / 8);
	size_t n = argc == 3 ? strtoul(argv[1], NULL, 10) : 0;

	s.size = fread(s.bytes, 1, ROOM, stdin);
	while (s.start[s.blocks] + 8 <= s.size) {
		const size_t at = s.start[s.blocks];
		s.start[s.blocks + 1] = at + s.bytes[at + 6] + 256u * s.bytes[at + 7];
		s.blocks++;
	}
	if (argc != 3 || n > s.blocks || s.start[s.blocks] != s.size) {
		fprintf(stderr, "usage: damage_log N SEED < LOG > OUT (N blocks at most, 64 MiB at most)\n");
		return 2;
	}
	damage_stream(&s, strtoull(argv[2], NULL, 10), n);
	const size_t written = fwrite(s.bytes, 1, s.size, stdout);
	free_stream(&s);
	return written == s.size && fclose(stdout) == 0 ? 0 : 3;
}
