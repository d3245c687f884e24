/* What was written is what must be read: the gzip files are made here, with zlib's own writer. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <errno.h>
#include <signal.h>
#include <string.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cmocka.h>
#include <zlib.h>

#include "../sbf_stream.h"
#include "formats/input.h"

enum { SIZE = 300000 };

static uint8_t text[SIZE], back[SIZE + 100], packed[2 * SIZE];
static fw_input in;

/* Half noise, half pattern, so that it compresses but not to nothing. */
static int make_text(void **state)
{
	uint64_t seed = 8;

	(void)state;
	fill_random(&seed, text, SIZE);
	for (size_t i = 0; i < SIZE; i += 2)
		text[i] = (uint8_t)(i / 1000);
	return 0;
}

/* One gzip member of n bytes at `to`. */
static size_t pack(uint8_t *bytes, size_t n, uint8_t *to, size_t room)
{
	z_stream z = {.next_in = bytes, .avail_in = (uInt)n, .next_out = to, .avail_out = (uInt)room};

	assert_int_equal(deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
	assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
	assert_int_equal(deflateEnd(&z), Z_OK);
	return room - z.avail_out;
}

/* Read to the end in pieces of `piece` bytes; *n is what came. */
static fw_status read_all(size_t piece, size_t *n)
{
	fw_status status;
	size_t got;

	for (*n = 0;; *n += got) {
		const size_t room = sizeof(back) - *n;

		status = fw_input_read(&in, back + *n, piece < room ? piece : room, &got);
		if (status != FW_OK) {
			assert_int_equal(got, 0);
			return status;
		}
		assert_in_range(got, 1, piece);
		assert_int_equal(in.offset, *n + got);
	}
}

static void plain_memory(void **state)
{
	static const size_t sizes[] = {0, 1, 2, 3, 4096, SIZE}, pieces[] = {1, 7, 4096, SIZE};

	(void)state;
	for (size_t i = 0; i < 6; i++)
		for (size_t j = 0; j < 4; j++) {
			size_t got;

			fw_input_open_memory(&in, text, sizes[i]);
			assert_int_equal(read_all(pieces[j], &got), FW_EOF);
			assert_int_equal(got, sizes[i]);
			assert_memory_equal(back, text, got);
			assert_int_equal(read_all(1, &got), FW_EOF);
			fw_input_close(&in);
		}
}

static void nothing_asked_nothing_read(void **state)
{
	size_t got = 9;

	(void)state;
	fw_input_open_memory(&in, text, 10);
	assert_int_equal(fw_input_read(&in, back, 0, &got), FW_OK);
	assert_int_equal(got, 0);
	assert_int_equal(in.offset, 0);
}

static void gzip_in_any_pieces(void **state)
{
	static const size_t pieces[] = {1, 7, 4096, SIZE};
	const size_t n = pack(text, SIZE, packed, sizeof(packed));

	(void)state;
	for (size_t j = 0; j < 4; j++) {
		size_t got;

		fw_input_open_memory(&in, packed, n);
		assert_int_equal(read_all(pieces[j], &got), FW_EOF);
		assert_int_equal(got, SIZE);
		assert_memory_equal(back, text, SIZE);
		fw_input_close(&in);
	}
}

/* Members behind one another, empty ones and zero padding too. */
static void gzip_members(void **state)
{
	size_t n = 0, got;

	(void)state;
	n += pack(text, 1000, packed + n, 10000);
	n += pack(text, 0, packed + n, 10000);
	n += pack(text + 1000, 99000, packed + n, 200000);
	memset(packed + n, 0, 512);
	n += 512;
	fw_input_open_memory(&in, packed, n);
	assert_int_equal(read_all(4096, &got), FW_EOF);
	assert_int_equal(got, 100000);
	assert_memory_equal(back, text, got);
	fw_input_close(&in);
}

/* A cut anywhere gives what came before it, then FW_ETRUNCATED; only in front of the second byte it is no
 * gzip. */
static void gzip_cut(void **state)
{
	const size_t n = pack(text, 3000, packed, sizeof(packed));
	size_t got;

	(void)state;
	for (size_t cut = 2; cut < n; cut++) {
		fw_input_open_memory(&in, packed, cut);
		assert_int_equal(read_all(4096, &got), FW_ETRUNCATED);
		assert_in_range(got, 0, 3000);
		assert_memory_equal(back, text, got);
		assert_int_equal(fw_input_read(&in, back, 1, &got), FW_ETRUNCATED);
		fw_input_close(&in);
	}
	fw_input_open_memory(&in, packed, 1);
	assert_int_equal(read_all(4096, &got), FW_EOF);
	assert_int_equal(got, 1);
}

static void gzip_damaged(void **state)
{
	const size_t n = pack(text, 3000, packed, sizeof(packed));
	size_t got;

	(void)state;
	packed[n - 6] ^= 1; /* in the CRC-32 of the trailer */
	fw_input_open_memory(&in, packed, n);
	assert_int_equal(read_all(4096, &got), FW_EFORMAT);
	assert_int_equal(got, 3000);
	fw_input_close(&in);
	packed[n - 6] ^= 1;
	memcpy(packed + n, "garbage", 7);
	fw_input_open_memory(&in, packed, n + 7);
	assert_int_equal(read_all(4096, &got), FW_EFORMAT);
	assert_int_equal(got, 3000);
	fw_input_close(&in);
}

/* Peeking shows the same bytes however often, and reading then gives them all. */
static void peek(void **state)
{
	const size_t n = pack(text, SIZE, packed, sizeof(packed));
	const uint8_t *bytes;
	size_t got;

	(void)state;
	for (int gzip = 0; gzip < 2; gzip++) {
		fw_input_open_memory(&in, gzip ? packed : text, gzip ? n : SIZE);
		for (size_t want = 1; want <= FW_INPUT_PEEK; want = 2 * want) {
			assert_int_equal(fw_input_peek(&in, want, &bytes, &got), FW_OK);
			assert_true(got >= want);
			assert_memory_equal(bytes, text, got);
			assert_int_equal(in.offset, 0);
		}
		assert_int_equal(fw_input_read(&in, back, 100, &got), FW_OK);
		assert_int_equal(fw_input_peek(&in, FW_INPUT_PEEK, &bytes, &got), FW_OK);
		assert_memory_equal(bytes, text + in.offset, got);
		while (in.offset < 100) /* the first read may have given less */
			assert_int_equal(fw_input_read(&in, back + in.offset, 100 - in.offset, &got), FW_OK);
		assert_memory_equal(back, text, 100);
		fw_input_close(&in);
	}
}

static void peek_at_a_short_input(void **state)
{
	const uint8_t *bytes;
	size_t got;

	(void)state;
	fw_input_open_memory(&in, "abc", 3);
	assert_int_equal(fw_input_peek(&in, 0, &bytes, &got), FW_EINVAL);
	assert_int_equal(fw_input_peek(&in, FW_INPUT_PEEK + 1, &bytes, &got), FW_EINVAL);
	assert_int_equal(fw_input_peek(&in, 10, &bytes, &got), FW_OK);
	assert_int_equal(got, 3);
	assert_memory_equal(bytes, "abc", 3);
	assert_int_equal(read_all(10, &got), FW_EOF);
	assert_int_equal(got, 3);
	assert_int_equal(fw_input_peek(&in, 1, &bytes, &got), FW_EOF);
	assert_int_equal(got, 0);
}

static void no_such_file(void **state)
{
	(void)state;
	assert_int_equal(fw_input_open(&in, "/nowhere/at/all.sbf"), FW_EIO);
	assert_int_equal(in.error_number, ENOENT);
	fw_input_close(&in);
}

static void a_directory_is_no_file(void **state)
{
	size_t got;

	(void)state;
	assert_int_equal(fw_input_open(&in, "/"), FW_OK);
	assert_int_equal(fw_input_read(&in, back, 10, &got), FW_EIO);
	assert_int_equal(in.error_number, EISDIR);
	assert_int_equal(fw_input_read(&in, back, 10, &got), FW_EIO);
	fw_input_close(&in);
	fw_input_close(&in);
}

static void a_file_on_disk(void **state)
{
	char name[] = "/tmp/furrow-test-XXXXXX";
	const int fd = mkstemp(name);
	const size_t n = pack(text, SIZE, packed, sizeof(packed));
	size_t got;

	(void)state;
	assert_true(fd >= 0);
	assert_int_equal(write(fd, packed, n), n);
	close(fd);
	assert_int_equal(fw_input_open(&in, name), FW_OK);
	assert_int_equal(read_all(5000, &got), FW_EOF);
	assert_int_equal(got, SIZE);
	assert_memory_equal(back, text, SIZE);
	fw_input_close(&in);
	unlink(name);
}

/* A child writes to our stdin, a byte at a time in the beginning; signals interrupt the reading. */
static void interrupted_pipe(void (*handler)(int), size_t *got, fw_status *end)
{
	struct sigaction action = {.sa_handler = handler};
	const struct itimerval on = {{0, 200}, {0, 200}}, off = {{0, 0}, {0, 0}};
	const int old = dup(STDIN_FILENO);
	int fds[2], status;
	pid_t child;

	assert_int_equal(pipe(fds), 0);
	child = fork();
	if (child == 0) {
		close(fds[0]);
		for (size_t i = 0; i < SIZE; i += i < 1000 ? 1 : 1000)
			if (write(fds[1], text + i, i < 1000 ? 1 : 1000) < 0)
				_exit(1);
		_exit(0);
	}
	close(fds[1]);
	dup2(fds[0], STDIN_FILENO);
	close(fds[0]);
	sigaction(SIGALRM, &action, NULL);
	setitimer(ITIMER_REAL, &on, NULL);
	*end = read_all(700, got);
	setitimer(ITIMER_REAL, &off, NULL);
	fw_input_close(&in);
	dup2(old, STDIN_FILENO);
	close(old);
	assert_int_equal(waitpid(child, &status, 0), child);
}

static volatile sig_atomic_t rung;

static void ring(int signal_number)
{
	(void)signal_number;
	rung = 1;
}

static void stdin_with_interruptions(void **state)
{
	fw_status end;
	size_t got;

	(void)state;
	rung = 0;
	assert_int_equal(fw_input_open(&in, "-"), FW_OK);
	interrupted_pipe(ring, &got, &end);
	assert_int_equal(end, FW_EOF);
	assert_int_equal(got, SIZE);
	assert_memory_equal(back, text, SIZE);
	assert_int_equal(rung, 1);
}

static void stopped(void **state)
{
	size_t got;

	(void)state;
	rung = 0;
	assert_int_equal(fw_input_open(&in, "/dev/zero"), FW_OK);
	in.stop = &rung;
	assert_int_equal(fw_input_read(&in, back, 10, &got), FW_OK);
	assert_int_equal(fw_input_read(&in, back, 10, &got), FW_OK);
	rung = 1;
	while (fw_input_read(&in, back, 100, &got) == FW_OK)
		assert_true(in.offset <= FW_INPUT_RAW);
	assert_int_equal(fw_input_read(&in, back, 10, &got), FW_EIO);
	assert_int_equal(in.error_number, EINTR);
	fw_input_close(&in);
}

/* A pipe that a live source fills only when its reader has nothing left to do. */
typedef struct {
	int fd, calls;
} live_source;

static void send_more(void *context)
{
	live_source *source = context;

	source->calls++;
	assert_int_equal(write(source->fd, text, 100), 100);
}

static void idle_before_waiting(void **state)
{
	int ends[2], stdin_kept = dup(STDIN_FILENO);
	live_source source = {0};
	size_t got;

	(void)state;
	assert_int_equal(pipe(ends), 0);
	dup2(ends[0], STDIN_FILENO);
	source.fd = ends[1];
	assert_int_equal(write(ends[1], text, 150), 150);
	assert_int_equal(fw_input_open(&in, "-"), FW_OK);
	in.idle = send_more;
	in.idle_context = &source;
	for (int i = 0; i < 15; i++)
		assert_int_equal(fw_input_read(&in, back, 10, &got), FW_OK);
	assert_int_equal(source.calls, 0);
	assert_int_equal(fw_input_read(&in, back, 10, &got), FW_OK);
	assert_int_equal(source.calls, 1);
	for (int i = 0; i < 9; i++)
		assert_int_equal(fw_input_read(&in, back, 10, &got), FW_OK);
	close(ends[1]);
	assert_int_equal(fw_input_read(&in, back, 10, &got), FW_EOF); /* not a wait either */
	assert_int_equal(source.calls, 1);
	fw_input_close(&in);
	dup2(stdin_kept, STDIN_FILENO);
	close(stdin_kept);
	close(ends[0]);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(plain_memory),
	    cmocka_unit_test(nothing_asked_nothing_read),
	    cmocka_unit_test(gzip_in_any_pieces),
	    cmocka_unit_test(gzip_members),
	    cmocka_unit_test(gzip_cut),
	    cmocka_unit_test(gzip_damaged),
	    cmocka_unit_test(peek),
	    cmocka_unit_test(peek_at_a_short_input),
	    cmocka_unit_test(no_such_file),
	    cmocka_unit_test(a_directory_is_no_file),
	    cmocka_unit_test(a_file_on_disk),
	    cmocka_unit_test(stdin_with_interruptions),
	    cmocka_unit_test(stopped),
	    cmocka_unit_test(idle_before_waiting),
	};

	return cmocka_run_group_tests_name("input", tests, make_text, NULL);
}
