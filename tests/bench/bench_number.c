/* What a number costs as text, in nanoseconds, beside snprintf and strtod; the best of several runs.
 * The values are like those of the columns of a table of a receiver's log. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "formats/number.h"

enum { COUNT = 4096, PASSES = 200, RUNS = 7 };

static double values[COUNT];
static char text[COUNT * 32 + FW_FIXED_ROOM];
static unsigned short lengths[COUNT];

typedef char *writer(char *p, double x);

static char *fixed_3(char *p, double x)
{
	return fw_put_fixed(p, x, 3);
}
static char *fixed_4(char *p, double x)
{
	return fw_put_fixed(p, x, 4);
}
static char *fixed_9(char *p, double x)
{
	return fw_put_fixed(p, x, 9);
}
static char *trim_9(char *p, double x)
{
	return fw_put_fixed_trim(p, x, 9);
}
static char *float_shortest(char *p, double x)
{
	return fw_put_float(p, (float)x);
}
static char *whole(char *p, double x)
{
	return fw_put_i64(p, (int64_t)x);
}
static char *printf_3(char *p, double x)
{
	return p + snprintf(p, 64, "%.3f", x);
}
static char *printf_4(char *p, double x)
{
	return p + snprintf(p, 64, "%.4f", x);
}
static char *printf_9(char *p, double x)
{
	return p + snprintf(p, 64, "%.9f", x);
}
static char *printf_float(char *p, double x)
{
	return p + snprintf(p, 64, "%.9g", (double)(float)x);
}
static char *printf_double(char *p, double x)
{
	return p + snprintf(p, 64, "%.17g", x);
}
static char *printf_whole(char *p, double x)
{
	return p + snprintf(p, 64, "%lld", (long long)x);
}

static double uniform(double low, double high)
{
	return low + (high - low) * ((double)random() + (double)random() / 2147483648.0) / 2147483648.0;
}

static double pseudorange_m(void)
{
	return uniform(2e7, 3e7);
}
static double carrier_cycles(void)
{
	return uniform(-1.5e8, 1.5e8);
}
static double latitude_deg(void)
{
	return uniform(-90, 90);
}
static double deviation_m(void)
{
	return exp(uniform(-5, 3));
}
static double tow_s(void)
{
	return (double)(random() % 6048000) / 10;
}
static double velocity_mps(void)
{
	return uniform(-20, 20);
}
static double ephemeris_value(void)
{
	static const double units[] = {0x1p-31, 0x1p-43, 0x1p-33, 0x1p-19, 0x1p-5, 0x1p-55, 0x1p4};
	return (double)(int32_t)(random() * 2) * units[random() % 7];
}
static double any_double(void)
{
	return uniform(-1e3, 1e3);
}
static double satellite_number(void)
{
	return (double)(random() % 37 + 1);
}
static double thousands(void)
{
	return (double)(random() % 1000000);
}

static double now_ns(void)
{
	struct timespec t;

	clock_gettime(CLOCK_MONOTONIC, &t);
	return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static double time_writer(writer *put, int passes)
{
	double best = 1e300;

	for (int run = 0; run < RUNS; run++) {
		double start = now_ns();
		for (int pass = 0; pass < passes; pass++) {
			char *p = text;
			for (int i = 0; i < COUNT; i++) {
				p = put(p, values[i]);
				*p++ = ',';
			}
		}
		double ns = (now_ns() - start) / passes / COUNT;
		best = ns < best ? ns : best;
	}
	return best;
}

static void bench_writer(const char *what, double (*make)(void), writer *ours, writer *theirs)
{
	for (int i = 0; i < COUNT; i++)
		values[i] = make();
	double a = time_writer(ours, PASSES), b = time_writer(theirs, PASSES / 10);
	printf("%-36s %8.1f %8.1f %7.1f\n", what, a, b, b / a);
}

typedef double *reader(const char *s, size_t n, double *x);

static double *get_double(const char *s, size_t n, double *x)
{
	return fw_get_double(s, n, x) == FW_OK ? x : NULL;
}
static double *get_strtod(const char *s, size_t n, double *x)
{
	char *end;

	*x = strtod(s, &end);
	return end == s + n ? x : NULL;
}

static double time_reader(reader *get, int passes)
{
	double best = 1e300, x;

	for (int run = 0; run < RUNS; run++) {
		double start = now_ns();
		for (int pass = 0; pass < passes; pass++) {
			const char *s = text;
			for (int i = 0; i < COUNT; s += lengths[i++] + 1)
				if (!get(s, lengths[i], &x))
					abort();
		}
		double ns = (now_ns() - start) / passes / COUNT;
		best = ns < best ? ns : best;
	}
	return best;
}

static void bench_reader(const char *what, double (*make)(void), writer *put)
{
	char *p = text;

	for (int i = 0; i < COUNT; i++) {
		char *end = put(p, make());
		lengths[i] = (unsigned short)(end - p);
		*end = ',';
		p = end + 1;
	}
	double a = time_reader(get_double, PASSES), b = time_reader(get_strtod, PASSES / 5);
	printf("%-36s %8.1f %8.1f %7.1f\n", what, a, b, b / a);
}

int main(void)
{
	printf("%-36s %8s %8s %7s\n", "ns per number written", "furrow", "printf", "ratio");
	bench_writer("fixed, 4: pseudorange [m]", pseudorange_m, fixed_4, printf_4);
	bench_writer("fixed, 3: carrier [cycles]", carrier_cycles, fixed_3, printf_3);
	bench_writer("fixed, 4: standard deviation [m]", deviation_m, fixed_4, printf_4);
	bench_writer("fixed, 9: latitude [deg]", latitude_deg, fixed_9, printf_9);
	bench_writer("fixed, 9, trimmed: time of week [s]", tow_s, trim_9, printf_9);
	bench_writer("shortest float: velocity [m/s]", velocity_mps, float_shortest, printf_float);
	bench_writer("shortest double: ephemeris", ephemeris_value, fw_put_double, printf_double);
	bench_writer("shortest double: -1000..1000", any_double, fw_put_double, printf_double);
	bench_writer("whole: satellite 1..37", satellite_number, whole, printf_whole);
	bench_writer("whole: 0..999999", thousands, whole, printf_whole);

	printf("\n%-36s %8s %8s %7s\n", "ns per number read", "furrow", "strtod", "ratio");
	bench_reader("fixed, 4: pseudorange [m]", pseudorange_m, fixed_4);
	bench_reader("fixed, 9: latitude [deg]", latitude_deg, fixed_9);
	bench_reader("shortest double: ephemeris", ephemeris_value, fw_put_double);
	bench_reader("shortest double: -1000..1000", any_double, fw_put_double);
	bench_reader("whole: satellite 1..37", satellite_number, whole);
	return 0;
}
