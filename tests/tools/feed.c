/* Gives a program its standard input in pieces: each of its reads gets one piece, as from a slow line.
 *
 * usage: feed MOST SEED COMMAND... < FILE     pieces of 1 to MOST bytes; MOST at most 4096 */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../sbf_stream.h"

static void pour(int fd, size_t most, uint64_t seed)
{
	static uint8_t piece[4096];
	for (;;) {
		ssize_t n = read(STDIN_FILENO, piece, 1 + below(&seed, most));
		if (n <= 0 || write(fd, piece, (size_t)n) != n)
			break;
	}
	close(fd);
}

int main(int argc, char **argv)
{
	size_t most = argc > 3 ? (size_t)strtoul(argv[1], NULL, 10) : 0;
	int ends[2], status;
	if (most < 1 || most > 4096) {
		fprintf(stderr, "usage: feed MOST SEED COMMAND... < FILE\n");
		return 2;
	}
	if (pipe2(ends, O_DIRECT) != 0) /* a pipe of packets */
		return 3;
	pid_t child = fork();
	if (child == 0) {
		dup2(ends[0], STDIN_FILENO);
		close(ends[0]);
		close(ends[1]);
		execvp(argv[3], argv + 3);
		_exit(127);
	}
	close(ends[0]);
	pour(ends[1], most, strtoull(argv[2], NULL, 10));
	if (child < 0 || waitpid(child, &status, 0) != child)
		return 3;
	return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
