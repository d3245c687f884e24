/* Runs a harness without libFuzzer: all of its corpus, then mutations of that and of what fuzz_make() makes.
 *
 *   fuzz_NAME              the corpus and FUZZ_RUNS mutations (200,000), as many of them as 100 s of processor time allow
 *   fuzz_NAME FILE...      these inputs only, with their time and memory
 *   fuzz_NAME -w DIR N     write N inputs of fuzz_make() to DIR
 *
 * The sequence follows from FUZZ_SEED (1) alone. Time and heap of every input are measured: over 100 ms of processor
 * time (the least of three runs) or over 16 MiB is a finding, as is any report of a sanitizer and 20 s without an
 * end. The input is left in ./finding. */
#include <dirent.h>
#include <inttypes.h>
#include <signal.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <sanitizer/common_interface_defs.h>

#include "fuzz.h"

enum { POOL = 512, REFRESH = 8, MUTATIONS_MOST = 5, HANG_S = 20, SLOW_NS = 100000000, HEAP_MOST = 16 << 20 };

/* Of libasan; gcc 12 does not install the header that declares them. */
int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void *, size_t),
                                              void (*on_free)(const volatile void *));
size_t __sanitizer_get_allocated_size(const volatile void *p);
const char *__ubsan_default_options(void);

typedef struct {
	size_t size;
	uint8_t bytes[FUZZ_ROOM];
} input;

static input pool[POOL], mutant;
static size_t n_pool;
static fw_random dice;

/* The input at hand, for whoever has to write it down. */
static const uint8_t *current;
static size_t current_size;
#define MOST_NS INT64_C(100000000000)

static volatile sig_atomic_t seconds;

/* Heap of the input at hand [bytes]. */
static _Atomic int64_t heap, heap_peak; /* tools have threads */

static int64_t slowest_ns, largest_heap;

/* ---- findings ---- */

/* libubsan of gcc knows nothing of __sanitizer_set_death_callback(): it is to call abort(). */
const char *__ubsan_default_options(void)
{
	return "abort_on_error=1:print_stacktrace=1";
}

/* To descriptor 2, since a harness may have bent stderr. */
static void save_current(void)
{
	FILE *file = current != NULL ? fopen("finding", "wb") : NULL;
	if (file == NULL)
		return;
	(void)!fwrite(current, 1, current_size, file);
	fclose(file);
	dprintf(STDERR_FILENO, "the input, %zu bytes, is in ./finding\n", current_size);
	current = NULL;
}

static void on_abort(int number)
{
	save_current();
	signal(number, SIG_DFL);
	raise(number);
}

static void on_alarm(int number)
{
	(void)number;
	if (++seconds <= HANG_S)
		return;
	dprintf(STDERR_FILENO, "no end after %d s\n", HANG_S);
	save_current();
	_exit(1);
}

static void watch(void)
{
	const struct itimerval every_second = {{1, 0}, {1, 0}};
	struct sigaction act = {.sa_handler = on_alarm, .sa_flags = SA_RESTART};
	sigaction(SIGALRM, &act, NULL);
	setitimer(ITIMER_REAL, &every_second, NULL);
	signal(SIGABRT, on_abort);
	__sanitizer_set_death_callback(save_current);
}

static void on_malloc(const volatile void *p, size_t n)
{
	(void)p;
	const int64_t now = heap += (int64_t)n;
	if (now > heap_peak)
		heap_peak = now;
}

static void on_free(const volatile void *p)
{
	if (p != NULL)
		heap -= (int64_t)__sanitizer_get_allocated_size(p);
}

/* ---- one input ---- */

static int64_t processor_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
	return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static int64_t time_once(const uint8_t *bytes, size_t n)
{
	const int64_t start = processor_ns();
	LLVMFuzzerTestOneInput(bytes, n);
	return processor_ns() - start;
}

static void run(const uint8_t *bytes, size_t n)
{
	static uint8_t room[FUZZ_ROOM];
	uint8_t *const alone = room + sizeof room - n; /* a step behind the end is a step out of `room` */
	memcpy(alone, bytes, n);
	current = alone;
	current_size = n;
	seconds = 0;
	heap = heap_peak = 0;
	int64_t ns = time_once(alone, n);
	for (int again = 0; again < 2 && ns > SLOW_NS; again++) {
		int64_t other = time_once(alone, n);
		ns = other < ns ? other : ns;
	}
	if (ns > slowest_ns)
		slowest_ns = ns;
	if (heap_peak > largest_heap)
		largest_heap = heap_peak;
	if (ns > SLOW_NS || heap_peak > HEAP_MOST) {
		dprintf(STDERR_FILENO, "%" PRId64 " us, %" PRId64 " bytes of heap\n", ns / 1000, heap_peak);
		save_current();
		exit(1);
	}
	current = NULL;
}

/* ---- mutation ---- */

static size_t below(size_t n)
{
	return (size_t)fw_random_below(&dice, n);
}

/* Moves the bytes from `from` on to `to`; returns the new size. The gap keeps what was there. */
static size_t move_tail(uint8_t *data, size_t size, size_t from, size_t to, size_t max)
{
	size_t n = size - from;
	if (n > max - to)
		n = max - to;
	memmove(data + to, data + from, n);
	return to + n;
}

static size_t insert(uint8_t *data, size_t size, size_t max)
{
	const size_t n = 1 + below(8), at = below(size + 1);
	const uint8_t byte = (uint8_t)fw_random_u64(&dice);
	const int same = below(2) == 0;
	if (n > max - at)
		return size;
	size = move_tail(data, size, at, at + n, max);
	for (size_t i = 0; i < n; i++)
		data[at + i] = same ? byte : (uint8_t)fw_random_u64(&dice);
	return size;
}

/* The values at which counts and lengths break. */
static void put_number(uint8_t *data, size_t size)
{
	static const uint64_t odd[] = {0,      1,       2,          3,          4,          0x7f,
	                               0x80,   0xff,    0x100,      0x7fff,     0x8000,     0xfffc,
	                               0xffff, 0x10000, 0x7fffffff, 0x80000000, 0xffffffff, UINT64_MAX};
	size_t width = (size_t)1 << below(4);
	uint64_t value = odd[below(sizeof odd / sizeof *odd)];
	const int big_endian = below(2) == 0;
	if (width > size)
		width = 1;
	const size_t at = below(size - width + 1);
	if (below(3) == 0)
		value = data[at] + (below(2) == 0 ? UINT64_C(1) : UINT64_MAX);
	for (size_t i = 0; i < width; i++, value >>= 8)
		data[at + (big_endian ? width - 1 - i : i)] = (uint8_t)value;
}

/* A stretch of the input to another place in it: over what is there, or in between. */
static size_t copy_part(uint8_t *data, size_t size, size_t max)
{
	uint8_t part[256];
	size_t n = 1 + below(size < sizeof part ? size : sizeof part);
	const size_t from = below(size - n + 1), to = below(size + 1);
	memcpy(part, data + from, n);
	if (n > max - to)
		n = max - to;
	if (below(2) == 0)
		size = move_tail(data, size, to, to + n, max);
	else if (n > size - to)
		n = size - to;
	memcpy(data + to, part, n);
	return size;
}

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max)
{
	if (size == 0)
		return insert(data, size, max);
	const size_t at = below(size);
	switch (below(12)) {
	case 0:
	case 1:
	case 2: data[at] ^= (uint8_t)(1U << below(8)); break;
	case 3:
	case 4: data[at] = (uint8_t)fw_random_u64(&dice); break;
	case 5: data[at] = (uint8_t)("0123456789.,-+eE\"\n#=:\r\t \xff"[below(25)]); break;
	case 6:
	case 7: put_number(data, size); break;
	case 8: return insert(data, size, max);
	case 9: return move_tail(data, size, at + 1 + below(size - at), at, max);
	case 10: return copy_part(data, size, max);
	default: return below(4) == 0 ? at : size;
	}
	return size;
}

/* The front of one input and the back of another. */
static void splice(input *to, const input *from)
{
	const size_t cut = below(to->size + 1), at = below(from->size + 1);
	size_t n = from->size - at;
	if (n > FUZZ_ROOM - cut)
		n = FUZZ_ROOM - cut;
	memcpy(to->bytes + cut, from->bytes + at, n);
	to->size = cut + n;
}

/* Only the last change of an input is one that may be followed by a repair: half of the inputs are repaired. */
static void mutate_and_run(void)
{
	mutant = pool[below(n_pool)];
	if (below(8) == 0)
		splice(&mutant, &pool[below(n_pool)]);
	for (size_t n = 1 + below(MUTATIONS_MOST); n > 0; n--) {
		const unsigned odd = n == 1 ? 1 : 0, seed = (unsigned)fw_random_u64(&dice) & (~1U | odd);
		mutant.size = LLVMFuzzerCustomMutator(mutant.bytes, mutant.size, FUZZ_ROOM, seed);
	}
	run(mutant.bytes, mutant.size);
}

/* ---- where inputs come from ---- */

static int read_input(const char *path, input *in)
{
	FILE *file = fopen(path, "rb");
	if (file == NULL)
		return 0;
	in->size = fread(in->bytes, 1, FUZZ_ROOM, file);
	fclose(file);
	return 1;
}

static int is_name(const struct dirent *entry)
{
	return entry->d_name[0] != '.';
}

/* The corpus, in an order that no file system decides. */
static void load_corpus(const char *program)
{
	const char *source = getenv("SRC"), *slash = strrchr(program, '/');
	char folder[2048], path[4096];
	struct dirent **entries;
	snprintf(folder, sizeof folder, "%s/tests/fuzz/corpus/%s", source != NULL ? source : ".",
	         slash != NULL ? slash + 1 : program);
	const int n = scandir(folder, &entries, is_name, alphasort);
	for (int i = 0; i < n; i++) {
		snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
		if (n_pool < POOL / 2 && read_input(path, &pool[n_pool])) {
			run(pool[n_pool].bytes, pool[n_pool].size);
			n_pool++;
		}
		free(entries[i]);
	}
	if (n >= 0)
		free(entries);
	printf("%s: %zu inputs of the corpus\n", program, n_pool);
}

static int replay(int n, char **files)
{
	for (int i = 0; i < n; i++) {
		if (!read_input(files[i], &mutant)) {
			perror(files[i]);
			return 1;
		}
		slowest_ns = largest_heap = 0;
		run(mutant.bytes, mutant.size);
		printf("%s: %zu bytes, %" PRId64 " us, %" PRId64 " bytes of heap\n", files[i], mutant.size,
		       slowest_ns / 1000, largest_heap);
	}
	return 0;
}

static int write_inputs(const char *folder, long n)
{
	for (long i = 0; i < n; i++) {
		char path[4096];
		snprintf(path, sizeof path, "%s/made_%02ld", folder, i);
		FILE *file = fopen(path, "wb");
		const size_t size = fuzz_make(&dice, mutant.bytes);
		if (file == NULL || fwrite(mutant.bytes, 1, size, file) != size || fclose(file) != 0) {
			perror(path);
			return 1;
		}
	}
	return 0;
}

static uint64_t setting(const char *name, uint64_t fallback)
{
	const char *text = getenv(name);
	return text != NULL ? strtoull(text, NULL, 10) : fallback;
}

int main(int argc, char **argv)
{
	const uint64_t seed = setting("FUZZ_SEED", 1), runs = setting("FUZZ_RUNS", 200000);

	fw_random_init(&dice, seed);
	if (argc == 4 && strcmp(argv[1], "-w") == 0)
		return write_inputs(argv[2], strtol(argv[3], NULL, 10));
	watch();
	__sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
	if (argc > 1)
		return replay(argc - 1, argv + 1);

	load_corpus(argv[0]);
	const size_t kept = n_pool;
	for (; n_pool < POOL; n_pool++) {
		pool[n_pool].size = fuzz_make(&dice, pool[n_pool].bytes);
		run(pool[n_pool].bytes, pool[n_pool].size);
	}
	const int64_t start = processor_ns();
	uint64_t i = 0;
	for (; i < runs && processor_ns() - start < MOST_NS; i++) {
		mutate_and_run();
		if (i % REFRESH == 0) {
			input *old = &pool[kept + below(POOL - kept)];
			old->size = fuzz_make(&dice, old->bytes);
		}
	}
	const double s = (double)(processor_ns() - start) / 1e9;
	printf("%s: seed %" PRIu64 ", %" PRIu64
	       " mutations, no finding; %.0f per second, slowest %.1f ms, most heap %" PRId64 " bytes\n",
	       argv[0], seed, i, (double)i / s, (double)slowest_ns / 1e6, largest_heap);
	return 0;
}
