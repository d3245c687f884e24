/* Numbers to text and back. The independent sources are glibc's snprintf, strtod and strtof, which round
 * correctly, and texts that Python 3's repr() and numpy.float32's repr() gave, copied into the tables. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/number.h"

enum { MANY = 1000000, SOME = 200000 };

static uint64_t seed = 20240229;

/* splitmix64: any 64 bits, the same ones in every run */
static uint64_t random_bits(void)
{
	uint64_t z = seed += UINT64_C(0x9e3779b97f4a7c15);

	z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
	z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
	return z ^ z >> 31;
}

static int random_below(int n)
{
	return (int)(random_bits() % (unsigned)n);
}

static double double_of(uint64_t bits)
{
	double x;

	memcpy(&x, &bits, sizeof x);
	return x;
}

static float float_of(uint32_t bits)
{
	float x;

	memcpy(&x, &bits, sizeof x);
	return x;
}

/* Same bits, so that the sign of a zero counts. */
static bool same(double a, double b)
{
	return memcmp(&a, &b, sizeof a) == 0;
}

static double random_finite(void)
{
	double x;

	do
		x = double_of(random_bits());
	while (!isfinite(x));
	return x;
}

static float random_finite_float(void)
{
	float x;

	do
		x = float_of((uint32_t)random_bits());
	while (!isfinite(x));
	return x;
}

/* All the kinds of values that tables hold, and those where rounding is hardest. */
static double random_value(void)
{
	double sign = random_bits() & 1 ? -1 : 1;

	switch (random_below(8)) {
	case 0: return random_finite();
	case 1: return sign * ldexp((double)(random_bits() >> 11), -random_below(75));      /* 53 bits */
	case 2: return sign * (double)random_below(2000000000) / pow(10, random_below(16)); /* few digits */
	case 3: return sign * ldexp((double)random_below(1 << 24), -random_below(24));      /* exact ties */
	case 4: return sign * (random_below(1000000) + 0.5) / pow(10, random_below(10));    /* near ties */
	case 5: return ldexp(sign, random_below(2046) - 1022);                              /* powers of 2 */
	case 6: return sign * nextafter(pow(10, random_below(40) - 20), random_below(3) - 1); /* and of 10 */
	default: return sign * double_of(random_bits() >> (12 + random_below(52)));           /* denormals */
	}
}

/* ---- Fixed notation ----------------------------------------------------------------------------------- */

/* What printf says, without the sign of a zero. */
static const char *printf_fixed(char text[static 400], double x, int decimals)
{
	snprintf(text, 400, "%.*f", decimals, x);
	return text[0] == '-' && strspn(text + 1, "0.") == strlen(text + 1) ? text + 1 : text;
}

static void check_fixed(double x, int decimals)
{
	char ours[FW_FIXED_ROOM + 1], trimmed[FW_FIXED_ROOM + 1], buffer[400];
	const char *expected = printf_fixed(buffer, x, decimals);
	size_t length = strlen(expected);

	*fw_put_fixed(ours, x, decimals) = 0;
	if (strcmp(ours, expected) != 0)
		fail_msg("%a with %d decimals: '%s', printf says '%s'", x, decimals, ours, expected);

	*fw_put_fixed_trim(trimmed, x, decimals) = 0;
	if (decimals) {
		while (expected[length - 1] == '0')
			length--;
		length -= expected[length - 1] == '.';
	}
	if (strlen(trimmed) != length || memcmp(trimmed, expected, length) != 0)
		fail_msg("%a with %d decimals, trimmed: '%s', printf says '%s'", x, decimals, trimmed,
		         expected);
}

static void fixed_equals_printf(void **state)
{
	(void)state;
	for (int i = 0; i < MANY; i++)
		check_fixed(random_value(), random_below(FW_FIXED_DECIMALS_MAX + 1));
}

static void fixed_equals_printf_where_the_paths_meet(void **state)
{
	static const double edges[] = {0,
	                               0.5,
	                               1,
	                               1.5,
	                               2.5,
	                               0x1p52,
	                               0x1p53,
	                               0x1p63,
	                               0x1p64,
	                               1e15,
	                               1e16,
	                               1e17,
	                               1e22,
	                               DBL_MAX,
	                               DBL_MIN,
	                               DBL_TRUE_MIN,
	                               0x1p-75,
	                               0x1p-76,
	                               9.9999999999999995};
	(void)state;
	for (size_t i = 0; i < sizeof edges / sizeof *edges; i++)
		for (int decimals = 0; decimals <= FW_FIXED_DECIMALS_MAX; decimals++)
			for (int sign = -1; sign <= 1; sign += 2) {
				double x = sign * edges[i], ten = sign * 1e16 / pow(10, decimals);
				check_fixed(x, decimals);
				check_fixed(nextafter(x, 0), decimals);
				check_fixed(nextafter(x, sign * DBL_MAX), decimals);
				check_fixed(ten, decimals);
				check_fixed(nextafter(ten, 0), decimals);
			}
}

static void fixed_by_hand(void **state)
{
	static const struct {
		double x;
		int decimals;
		const char *fixed, *trimmed;
	} cases[] = {
	    {22451367.994, 3, "22451367.994", "22451367.994"},
	    {482321, 9, "482321.000000000", "482321"},
	    {0.2, 9, "0.200000000", "0.2"},
	    {-0.0004, 3, "0.000", "0"},
	    {-0.0, 2, "0.00", "0"},
	    {0.5, 0, "0", "0"},
	    {1.5, 0, "2", "2"},
	    {-2.5, 0, "-2", "-2"},
	    {100, 0, "100", "100"},
	    {0.125, 2, "0.12", "0.12"},
	    {0.375, 2, "0.38", "0.38"},
	    {999.9996, 3, "1000.000", "1000"},
	    {-1234567.1, 1, "-1234567.1", "-1234567.1"},
	};
	char text[FW_FIXED_ROOM + 1];

	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		*fw_put_fixed(text, cases[i].x, cases[i].decimals) = 0;
		assert_string_equal(text, cases[i].fixed);
		*fw_put_fixed_trim(text, cases[i].x, cases[i].decimals) = 0;
		assert_string_equal(text, cases[i].trimmed);
	}
}

/* ---- Shortest text ------------------------------------------------------------------------------------ */

/* repr(x) of Python 3.11, the exponents written in the manner of number.h */
static const struct {
	uint64_t bits;
	const char *text;
} shortest_doubles[] = {
    /* clang-format off */
	{0x0000000000000000, "0"}, {0x8000000000000000, "0"}, {0x3ff0000000000000, "1"},
	{0xbff0000000000000, "-1"}, {0x4024000000000000, "10"}, {0x3fb999999999999a, "0.1"},
	{0x3fc999999999999a, "0.2"}, {0x3fd3333333333333, "0.3"}, {0xbff8000000000000, "-1.5"},
	{0x3ee4f8b588e368f1, "0.00001"}, {0x3ee4f8b588e368f0, "9.999999999999999e-06"},
	{0x3f1f75104d551d69, "0.00012"}, {0x42d6bcc41e900000, "100000000000000"},
	{0x430c6bf52633ffff, "999999999999999.9"}, {0x430c6bf526340000, "1e+15"},
	{0x4341c37937e08000, "1e+16"}, {0x4480f0cf064dd592, "1e+22"}, {0x44b52d02c7e14af6, "1e+23"},
	{0x437b69b4ba630f35, "1.2345678901234568e+17"}, {0x406065f36dc39206, "131.185965425466"},
	{0x4175694a7fe76c8b, "22451367.994"}, {0x3fe62e42fefa39ef, "0.6931471805599453"},
	{0x0000000000000001, "5e-324"}, {0x0000000000000002, "1e-323"}, {0x0000000000000003, "1.5e-323"},
	{0x0010000000000000, "2.2250738585072014e-308"}, {0x000fffffffffffff, "2.225073858507201e-308"},
	{0x7fefffffffffffff, "1.7976931348623157e+308"}, {0x433fffffffffffff, "9.007199254740991e+15"},
	{0x4340000000000000, "9.007199254740992e+15"}, {0x4340000000000001, "9.007199254740994e+15"},
	{0x3eb0000000000000, "9.5367431640625e-07"}, {0x0028000000000000, "6.675221575521604e-308"},
	{0x3ff6a09e667f3bcd, "1.4142135623730951"}, {0x3e6ad7f29abcaf48, "5e-08"},
	{0x3e501b2b29a4692b, "1.5e-08"}, {0x4011666666666666, "4.35"},
	{0x43b0000000000000, "1.152921504606847e+18"}, {0x3c30000000000000, "8.673617379884035e-19"},
	{0x41b1de784a000000, "299792458"}, {0x42f6a8665bda5400, "398600441800000"},
	{0x3f131da7d7cb8d5b, "0.000072921151467"}, {0xbdfe87deae177a99, "-4.442807633e-10"},
	{0x40b421adb59fffff, "5153.678552627563"}, {0x415854a640000000, "6378137"},
	{0x44dfe185ca57c517, "6.02214076e+23"}, {0x390b860bde023111, "6.62607015e-34"},
	{0x4fb0000000000000, "7.237005577332262e+75"}, {0x2360000000000000, "2.6871504430268355e-138"},
	{0x61e0000000000000, "2.879304828507646e+163"}, {0x0920000000000000, "9.924161033296096e-265"},
	{0x0f50000000000000, "6.290184345309701e-235"}, {0x14e0000000000000, "3.8934355277724873e-208"},
	{0x5a60000000000000, "2.1661481985318866e+127"}, {0x0ba0000000000000, "1.091173045203054e-252"},
	{0x7eb0000000000000, "1.7144137714980277e+302"}, {0x33c0000000000000, "1.9913648889155653e-59"},
	{0x0660000000000000, "5.641232424577593e-278"}, {0x12d0000000000000, "4.532555499780559e-218"},
	{0x6bd0000000000000, "2.1040543606193494e+211"}, {0x67d0000000000000, "1.1406101544055488e+192"},
	{0x0eb0000000000000, "6.142758149716505e-238"}, {0x3a60000000000000, "1.6155871338926322e-27"},
	{0x1400000000000000, "2.37636445786895e-212"}, {0x6970000000000000, "7.654505172902098e+199"},
	{0x0bf0000000000000, "3.491753744649773e-251"}, {0x1c80000000000000, "2.070105401319524e-171"},
	{0x35f0000000000000, "6.842277657836021e-49"}, {0x0ca0000000000000, "7.151111669042735e-248"},
	{0x6250000000000000, "3.6855101804897865e+165"}, {0x0980000000000000, "6.351463061309501e-263"},
	{0x3560000000000000, "1.3363823550460978e-51"}, {0x08b0000000000000, "7.753250807262575e-267"},
	{0x1ee0000000000000, "5.6902623986817984e-160"}, {0x46f0000000000000, "5.192296858534828e+33"},
	{0x6810000000000000, "1.824976247048878e+193"}, {0x21b0000000000000, "2.002083095183101e-146"},
	{0x1e27a1c08a6a63ec, "2.0518706419806528e-163"}, {0x0ef8aa3892276658, "1.5151067337818125e-236"},
	{0x90eda82f8f6d0558, "-3.9121918487939644e-227"}, {0x2e44158bae97ba94, "8.076904981638927e-86"},
	{0x94e3bf911a61dbe2, "-4.805547711536507e-208"}, {0xa38fd547923a7369, "-2.1385097871442245e-137"},
	{0x1f557203301850c5, "9.762378571076627e-158"}, {0x8c38fb2918f135d2, "-8.722783496930154e-250"},
	{0x1012f037b64ce422, "3.0496182610151205e-231"}, {0x0f4205b4907a70c3, "3.542609501695945e-235"},
	{0x34b9b5df9e7769b1, "1.0485529451675802e-54"}, {0xae2eb1547f150524, "-3.0857894137963574e-86"},
	{0x2d76b07e881ed162, "1.1138453608294672e-89"}, {0x106bf2efc6f87718, "1.440187852174412e-229"},
	{0x95e761d17731af10, "-3.7288635744050265e-203"}, {0x3403e430ec66a787, "3.961097882231256e-58"},
	{0x0cbd87ad5c90a958, "2.6396531149379436e-247"}, {0x8b5c74273f98e277, "-6.064050104938361e-254"},
	{0xb2f14c942e05319a, "-2.628241891952923e-63"}, {0x3e7d1bfbc7a2ea20, "1.084406323928777e-07"},
	{0x930d6eaf14f4733f, "-6.670190041254896e-217"}, {0x867347214cdd2055, "-1.3593855381697515e-277"},
	{0xa00902c77ebff206, "-2.331743626976924e-154"}, {0xbabced2057ee05cd, "-9.346583470705478e-26"},
	{0x09b64a0872e6cc3a, "7.078448798205026e-262"}, {0xbaecbd389be4bcfc, "-7.428894873003333e-25"},
	{0x1e398f1012bd4ace, "4.438369768029888e-163"}, {0x2b0a18e8830e07bc, "2.33038143669551e-101"},
	{0x81d3fcff2a3af4d4, "-7.461729518280267e-300"}, {0x26e875555790f82e, "2.9599107635242675e-121"},
	{0x408b1452ca01ed1c, "866.5404243612752"}, {0xc063934e2906578c, "-156.60329104651134"},
	{0x408ce04e2a686e84, "924.0381668242194"}, {0xc08a66128146dbb8, "-844.7590356384089"},
	{0x405d09b243506a30, "116.15150530674941"}, {0x40821181b9f6f4a2, "578.1883429807096"},
	{0x4083e5a74a537eba, "636.7066847346352"}, {0xc073fc159be2d18c, "-319.75527561760896"},
	{0xc072ba4aa5d68540, "-299.6432245616634"}, {0xc01a9a04ec1ad480, "-6.65040940202482"},
	{0x40828e4588706920, "593.7839516431886"}, {0xc08af3caf5901080, "-862.4741011862789"},
	{0xc0896676cccea348, "-812.8080078261928"}, {0xc07cc1f171179b50, "-460.1214457437645"},
	{0x4078a1589ea09bdc, "394.0841356538565"}, {0xc08b30001976a942, "-870.0000485678104"},
	{0x407ce51944f5f7d0, "462.3186692817808"}, {0xc077cc905f237c0e, "-380.78524698125045"},
	{0x40637c8f0b48c478, "155.8924614354362"}, {0x4076a796ef77b2f8, "362.4743494678255"},
	{0xbe3bd4f920000000, "-6.480125325225572e-09"}, {0x417596698f000000, "22636184.9375"},
	{0x3fec33960d400000, "0.8812971361912787"}, {0xc1888180a2000000, "-51392532.25"},
	{0xbe5b356e33800000, "-2.534008844423674e-08"}, {0xbfc027141f400000, "-0.12619258428458124"},
	{0xc03c9df880000000, "-28.61707305908203"}, {0xbefa041bfc000000, "-0.000024810840614009066"},
	{0x3e39b660be000000, "5.986637824362262e-09"}, {0x40a8969d81400000, "3147.307626724243"},
	{0xc0a6574fd0c00000, "-2859.6558895111084"}, {0xbe66512090c00000, "-4.1568471415009967e-08"},
	{0xbfc1110585800000, "-0.1333319570403546"}, {0xbfe4547e8c400000, "-0.6353142489679158"},
	{0xbfcfbcee29c00000, "-0.24795319593977183"}, {0x3ef1b5e802000000, "0.000016890117080947675"},
	{0x4080fbbd11000000, "543.4673175811768"}, {0xbe6c8b6166c00000, "-5.316819060019462e-08"},
	{0xbfab8d0e5d000000, "-0.05381054768804461"}, {0xbfab1af353000000, "-0.05293999088462442"},
    /* clang-format on */
};

/* repr(numpy.float32(x)) of numpy 2.4, likewise */
static const struct {
	uint32_t bits;
	const char *text;
} shortest_floats[] = {
    /* clang-format off */
	{0x00000000, "0"}, {0x80000000, "0"}, {0x3f800000, "1"}, {0x3dcccccd, "0.1"}, {0x3e4ccccd, "0.2"},
	{0xbe99999a, "-0.3"}, {0x3727c5ac, "0.00001"}, {0x3727c53e, "9.9999e-06"}, {0x58635fa9, "1e+15"},
	{0x56b5e621, "100000000000000"}, {0x4b800000, "16777216"}, {0x4b800000, "16777216"},
	{0x4c000000, "33554432"}, {0x00000001, "1e-45"}, {0x00000002, "3e-45"},
	{0x00800000, "1.1754944e-38"}, {0x007fffff, "1.1754942e-38"}, {0x7f7fffff, "3.4028235e+38"},
	{0x4b000000, "8388608"}, {0x38fba882, "0.00012"}, {0x3280d959, "1.5e-08"}, {0x4145851f, "12.345"},
	{0xc0f4f033, "-7.654321"}, {0x4d8ef3c2, "299792450"}, {0x501502f9, "10000000000"},
	{0x4f9502f9, "5000000000"}, {0x33800000, "5.9604645e-08"}, {0x4e800000, "1073741800"},
	{0x357f0381, "9.5e-07"}, {0x64078678, "1e+22"}, {0x368637bd, "4e-06"},
	{0x5b800000, "7.2057594e+16"}, {0x04800000, "3.0092655e-36"}, {0x25800000, "2.220446e-16"},
	{0x06000000, "2.4074124e-35"}, {0x2a000000, "1.1368684e-13"}, {0x65800000, "7.5557864e+22"},
	{0x1e800000, "1.3552527e-20"}, {0x11000000, "1.009742e-28"}, {0x4c000000, "33554432"},
	{0x02000000, "9.403955e-38"}, {0x0f000000, "6.3108872e-30"}, {0x00000001, "1e-45"},
	{0x1b800000, "2.1175824e-22"}, {0x7e000000, "4.2535296e+37"}, {0x0e800000, "3.1554436e-30"},
	{0x52000000, "137438950000"}, {0x00002000, "1.148e-41"}, {0x07000000, "9.62965e-35"},
	{0x2a000000, "1.1368684e-13"}, {0x55000000, "8796093000000"}, {0x2607679d, "4.6977956e-16"},
	{0xa268aa87, "-3.153214e-18"}, {0x0093f6de, "1.3588377e-38"}, {0xb4998d7c, "-2.8601414e-07"},
	{0x18ee8571, "6.16563e-24"}, {0x9a2ef80f, "-3.6182737e-23"}, {0x1d39d0a8, "2.4592419e-21"},
	{0x3961fd92, "0.00021552134"}, {0x1f7296ab, "5.1370123e-20"}, {0x1d87cec3, "3.594799e-21"},
	{0x9953ee26, "-1.0956538e-23"}, {0x3cf20724, "0.02954442"}, {0xbe3bfada, "-0.18357411"},
	{0xba529ba3, "-0.0008034056"}, {0x374b15d7, "0.000012104828"}, {0x3afb2c68, "0.0019163014"},
	{0x3bdc968b, "0.0067318133"}, {0x0fd58dbe, "2.1058019e-29"}, {0x15fc899e, "1.0199911e-25"},
	{0x24e4e25a, "9.926269e-17"}, {0xc17e9995, "-15.912496"}, {0xc0c96d17, "-6.2945666"},
	{0xc1168e3b, "-9.409724"}, {0x415277aa, "13.154215"}, {0xc158ade6, "-13.542456"},
	{0xc1989c00, "-19.076172"}, {0x419050bd, "18.039423"}, {0x3f90ad88, "1.1302958"},
	{0xc1622ca4, "-14.135899"}, {0x3fdd0af6, "1.726897"}, {0xc19758ae, "-18.9183"},
	{0x3f8feb9b, "1.1243776"}, {0x41991ed2, "19.140049"}, {0x4168872c, "14.533001"},
	{0x40fb21c3, "7.8478713"},
    /* clang-format on */
};

static void shortest_equals_repr(void **state)
{
	char text[FW_SHORTEST_ROOM + 1];

	(void)state;
	for (size_t i = 0; i < sizeof shortest_doubles / sizeof *shortest_doubles; i++) {
		*fw_put_double(text, double_of(shortest_doubles[i].bits)) = 0;
		assert_string_equal(text, shortest_doubles[i].text);
	}
	for (size_t i = 0; i < sizeof shortest_floats / sizeof *shortest_floats; i++) {
		*fw_put_float(text, float_of(shortest_floats[i].bits)) = 0;
		assert_string_equal(text, shortest_floats[i].text);
	}
}

/* The significant digits of a text, without the zeros at both ends; returns how many there are. */
static int get_significant(const char *text, char digits[static 64])
{
	int n = 0, last = 0;

	for (; *text && *text != 'e'; text++) {
		if (!('0' <= *text && *text <= '9') || (*text == '0' && n == 0))
			continue;
		digits[n++] = *text;
		if (*text != '0')
			last = n;
	}
	digits[last] = 0;
	return last;
}

static void double_reads_back(void **state)
{
	char text[FW_SHORTEST_ROOM + 1];

	(void)state;
	for (int i = 0; i < MANY; i++) {
		double x = random_value();
		*fw_put_double(text, x) = 0;
		if (strtod(text, NULL) != x)
			fail_msg("%a: '%s' reads back as something else", x, text);
	}
}

static void float_reads_back(void **state)
{
	char text[FW_SHORTEST_ROOM + 1];

	(void)state;
	for (int i = 0; i < MANY; i++) {
		float x = i & 1 ? random_finite_float() : (float)random_below(20000) / 1000;
		*fw_put_float(text, x) = 0;
		if (strtof(text, NULL) != x)
			fail_msg("%a: '%s' reads back as something else", (double)x, text);
	}
}

/* With n digits, printf's text is the nearest of all: ours must be the same. With n - 1 digits the nearest
 * of all must not read back. (Powers of two have uneven neighbours: the vectors above hold some.) */
static void no_text_is_shorter_or_nearer(void **state)
{
	char text[FW_SHORTEST_ROOM + 1], ours[64], other[64], nearest[64];

	(void)state;
	for (int i = 0; i < SOME; i++) {
		double x = random_value();
		int exponent;
		if (fabs(frexp(x, &exponent)) == 0.5)
			continue;
		*fw_put_double(text, x) = 0;
		int n = get_significant(text, ours);
		snprintf(other, sizeof other, "%.*e", n > 0 ? n - 1 : 0, x);
		get_significant(other, nearest);
		if (strcmp(ours, nearest) != 0)
			fail_msg("%a: '%s' but '%s' is nearer", x, text, other);
		if (n < 2)
			continue;
		snprintf(other, sizeof other, "%.*e", n - 2, x);
		if (strtod(other, NULL) == x)
			fail_msg("%a: '%s' but '%s' is shorter", x, text, other);
	}
}

static void no_float_text_is_shorter_or_nearer(void **state)
{
	char text[FW_SHORTEST_ROOM + 1], ours[64], other[64], nearest[64];

	(void)state;
	for (int i = 0; i < SOME; i++) {
		float x = random_finite_float();
		int exponent;
		if (fabsf(frexpf(x, &exponent)) == 0.5F)
			continue;
		*fw_put_float(text, x) = 0;
		int n = get_significant(text, ours);
		snprintf(other, sizeof other, "%.*e", n > 0 ? n - 1 : 0, (double)x);
		get_significant(other, nearest);
		if (strcmp(ours, nearest) != 0)
			fail_msg("%a: '%s' but '%s' is nearer", (double)x, text, other);
		if (n < 2)
			continue;
		snprintf(other, sizeof other, "%.*e", n - 2, (double)x);
		if (strtof(other, NULL) == x)
			fail_msg("%a: '%s' but '%s' is shorter", (double)x, text, other);
	}
}

/* ---- Whole numbers ------------------------------------------------------------------------------------ */

static void check_whole(uint64_t bits)
{
	char text[FW_INTEGER_ROOM + 1], expected[32];
	int64_t value = (int64_t)bits, back = 0;

	*fw_put_u64(text, bits) = 0;
	snprintf(expected, sizeof expected, "%llu", (unsigned long long)bits);
	assert_string_equal(text, expected);

	*fw_put_i64(text, value) = 0;
	snprintf(expected, sizeof expected, "%lld", (long long)value);
	assert_string_equal(text, expected);

	assert_int_equal(fw_get_i64(text, strlen(text), &back), FW_OK);
	assert_true(back == value);
}

static void whole_numbers_equal_printf_and_read_back(void **state)
{
	(void)state;
	for (uint64_t power = 1; power < UINT64_MAX / 10; power *= 10)
		for (int i = -1; i <= 1; i++) {
			check_whole(power + (uint64_t)i);
			check_whole(-power + (uint64_t)i);
		}
	check_whole(UINT64_MAX);
	check_whole((uint64_t)INT64_MAX);
	check_whole((uint64_t)INT64_MIN);
	for (int i = 0; i < MANY; i++)
		check_whole(random_bits() >> random_below(64));
}

/* ---- Room --------------------------------------------------------------------------------------------- */

static void nothing_is_written_behind_the_room(void **state)
{
	static const double values[] = {-DBL_MAX,
	                                -1e15,
	                                -9.999999999999998e14,
	                                -1.2345678901234567e-5,
	                                -DBL_TRUE_MIN,
	                                -9007199254740991,
	                                -2.2250738585072014e-308,
	                                0};
	char text[FW_FIXED_ROOM + 64], untouched[64];

	(void)state;
	memset(untouched, '~', sizeof untouched);
	for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
		memset(text, '~', sizeof text);
		for (int decimals = 0; decimals <= FW_FIXED_DECIMALS_MAX; decimals++) {
			fw_put_fixed(text, values[i], decimals);
			fw_put_fixed_trim(text, values[i], decimals);
		}
		assert_memory_equal(text + FW_FIXED_ROOM, untouched, 64);

		memset(text, '~', sizeof text);
		fw_put_double(text, values[i]);
		if (fabs(values[i]) <= (double)FLT_MAX)
			fw_put_float(text, (float)values[i]);
		assert_memory_equal(text + FW_SHORTEST_ROOM, untouched, 64);
	}
	memset(text, '~', sizeof text);
	for (int decimals = 0; decimals <= FW_FIXED_DECIMALS_MAX; decimals++)
		fw_put_fixed(text, -9.9999999999999e15 / pow(10, decimals), decimals);
	assert_memory_equal(text + 40, untouched, 64);

	memset(text, '~', sizeof text);
	fw_put_u64(text, UINT64_MAX);
	fw_put_i64(text, INT64_MIN);
	fw_put_i64(text, -9999999999999999);
	assert_memory_equal(text + FW_INTEGER_ROOM, untouched, 64);
}

/* In a debug build the same calls are an assertion. */
#ifdef NDEBUG
static void non_finite_writes_nothing(void **state)
{
	static const double values[] = {(double)NAN, -(double)NAN, (double)INFINITY, -(double)INFINITY};
	char text[FW_FIXED_ROOM];

	(void)state;
	for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
		assert_ptr_equal(fw_put_fixed(text, values[i], 3), text);
		assert_ptr_equal(fw_put_fixed_trim(text, values[i], 3), text);
		assert_ptr_equal(fw_put_double(text, values[i]), text);
		assert_ptr_equal(fw_put_float(text, (float)values[i]), text);
	}
}
#endif

/* ---- Readers ------------------------------------------------------------------------------------------ */

/* Both readers against strtod and strtof, from an unterminated copy of exactly n bytes. */
static void check_read(const char *text)
{
	size_t n = strlen(text);
	double expected = strtod(text, NULL), x = -7;
	float expected_float = strtof(text, NULL), f = -7;
	char *field = malloc(n);

	memcpy(field, text, n);
	fw_status status = fw_get_double(field, n, &x), status_float = fw_get_float(field, n, &f);
	free(field);
	if (isinf(expected) ? status != FW_ERANGE || x != -7 : status != FW_OK || !same(x, expected))
		fail_msg("'%s': status %d, %a, strtod says %a", text, status, x, expected);
	if (isinf(expected_float) ? status_float != FW_ERANGE || f != -7
	                          : status_float != FW_OK || !same((double)f, (double)expected_float))
		fail_msg("'%s': status %d, %a, strtof says %a", text, status_float, (double)f,
		         (double)expected_float);
}

static void read_equals_strtod(void **state)
{
	char text[64];

	(void)state;
	for (int i = 0; i < MANY; i++) {
		double x = random_value();
		switch (random_below(4)) {
		case 0: snprintf(text, sizeof text, "%.*e", random_below(25), x); break;
		case 1: snprintf(text, sizeof text, "%.*g", 1 + random_below(20), x); break;
		case 2: snprintf(text, sizeof text, "%.*f", random_below(10), fmod(x, 1e9)); break;
		default:
			snprintf(text, sizeof text, "%llue%d",
			         (unsigned long long)(random_bits() >> random_below(64)),
			         random_below(700) - 350);
		}
		check_read(text);
	}
}

/* The middle between two neighbours, and a hair beside it: where a reader that rounds twice is wrong. */
static void read_equals_strtod_at_ties(void **state)
{
	char text[FW_NUMBER_TEXT_MAX];

	(void)state;
	for (int i = 0; i < SOME / 2; i++) {
		double x = ldexp((double)(random_bits() >> 11 | 1), -random_below(53) - 1);
		float f = (float)ldexp((double)(random_bits() >> 40 | 1), -random_below(60));
		double middle = ((double)f + (double)nextafterf(f, INFINITY)) / 2;
		snprintf(text, sizeof text, "%llu.5",
		         (unsigned long long)(random_bits() >> 12 | UINT64_C(1) << 52));
		check_read(text);
		snprintf(text, sizeof text, "%llu",
		         (unsigned long long)(random_bits() >> 10 | UINT64_C(1) << 53));
		check_read(text);
		snprintf(text, sizeof text, "%.17g", x);
		check_read(text);
		snprintf(text, sizeof text, "%.100f", middle);
		check_read(text);
		snprintf(text, sizeof text, "%.17g", middle);
		check_read(text);
		snprintf(text, sizeof text, "%.17g", nextafter(middle, i & 1 ? 0 : 1e30));
		check_read(text);
	}
}

static void read_accepts(void **state)
{
	static const char *const fields[] = {
	    "0",
	    "-0",
	    "+0",
	    "-0.0",
	    "00012.50",
	    "5.",
	    ".5",
	    "-.5e1",
	    "1e5",
	    "1E+05",
	    "1e-05",
	    "1.5e-08",
	    "+7",
	    "1e308",
	    "1.7976931348623157e308",
	    "1.7976931348623159e308",
	    "1e309",
	    "-1e400",
	    "1e99999999999999999",
	    "-1e-99999999999999999",
	    "0e999999999",
	    "0.0e-9999",
	    "4.9e-324",
	    "2.4e-324",
	    "2.5e-324",
	    "2.2250738585072011e-308",
	    "9007199254740993",
	    "9007199254740993.00000000000000000000000001",
	    "18446744073709551615",
	    "18446744073709551616",
	    "99999999999999999999999999",
	    "1e22",
	    "1e23",
	    "0.000000000000000000000000000001",
	    "3.4028235e38",
	    "3.4028235677973366e38",
	    "3.4028236e38",
	    "1.4e-45",
	    "7.006492321624085e-46",
	    "7.0064923216240854e-46",
	    "1.1754943e-38",
	    "16777217",
	    "-16777219",
	    "8.5e-292",
	    "1e-292",
	    "1e-293",
	    "9223372036854775808e-310",
	    "123456789012345678e292",
	};

	(void)state;
	for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
		check_read(fields[i]);
}

static void read_refuses(void **state)
{
	static const char *const fields[] = {
	    "",         "-",    "+",   ".",     "-.",  "e5",  ".e5",  "1e",    "1e+", "1e-",  "1e5.", "1e5x",
	    "1.2.3",    "--1",  "+-1", "1 ",    " 1",  "1,5", "0x10", "0x1p3", "inf", "-inf", "nan",  "NaN",
	    "infinity", "1e 5", "1f",  "1_000", "12a", "\t1", "1\n",  "/",     ":",   "1:",   "1/"};
	double x = 1;
	float f = 1;
	int64_t whole = 1;

	(void)state;
	for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
		size_t n = strlen(fields[i]);
		if (fw_get_double(fields[i], n, &x) != FW_ESYNTAX ||
		    fw_get_float(fields[i], n, &f) != FW_ESYNTAX ||
		    fw_get_i64(fields[i], n, &whole) != FW_ESYNTAX)
			fail_msg("'%s' was accepted", fields[i]);
	}
	assert_int_equal(fw_get_double("1\0", 2, &x), FW_ESYNTAX);
	assert_int_equal(fw_get_i64("1.0", 3, &whole), FW_ESYNTAX);
	assert_int_equal(fw_get_i64("1e3", 3, &whole), FW_ESYNTAX);
	assert_true(x == 1 && f == 1 && whole == 1);
}

static void read_stops_at_the_end_of_the_field(void **state)
{
	double x = 0;
	int64_t whole = 0;

	(void)state;
	assert_int_equal(fw_get_double("12.5678,9", 4, &x), FW_OK);
	assert_true(x == 12.5);
	assert_int_equal(fw_get_double("3e17", 3, &x), FW_OK);
	assert_true(x == 30);
	assert_int_equal(fw_get_i64("12345", 3, &whole), FW_OK);
	assert_true(whole == 123);
}

static void read_bounds_the_length(void **state)
{
	char text[FW_NUMBER_TEXT_MAX + 2];
	double x = 1;
	float f = 1;
	int64_t whole = 1;

	(void)state;
	memset(text, '0', sizeof text);
	text[FW_NUMBER_TEXT_MAX - 1] = text[FW_NUMBER_TEXT_MAX] = '5';
	text[FW_NUMBER_TEXT_MAX + 1] = 0;
	assert_int_equal(fw_get_double(text, FW_NUMBER_TEXT_MAX + 1, &x), FW_ESYNTAX);
	assert_int_equal(fw_get_float(text, FW_NUMBER_TEXT_MAX + 1, &f), FW_ESYNTAX);
	assert_int_equal(fw_get_i64(text, FW_NUMBER_TEXT_MAX + 1, &whole), FW_ESYNTAX);
	assert_true(x == 1 && f == 1 && whole == 1);
	assert_int_equal(fw_get_double(text, FW_NUMBER_TEXT_MAX, &x), FW_OK);
	assert_int_equal(fw_get_float(text, FW_NUMBER_TEXT_MAX, &f), FW_OK);
	assert_int_equal(fw_get_i64(text, FW_NUMBER_TEXT_MAX, &whole), FW_OK);
	assert_true(x == 5 && f == 5 && whole == 5);

	memset(text, '1', FW_NUMBER_TEXT_MAX);
	text[FW_NUMBER_TEXT_MAX] = 0;
	check_read(text);
	text[1] = '.';
	check_read(text);
	memcpy(text + FW_NUMBER_TEXT_MAX - 5, "e-305", 5);
	check_read(text);
}

static void read_whole_range(void **state)
{
	int64_t x = 7;

	(void)state;
	assert_int_equal(fw_get_i64("9223372036854775808", 19, &x), FW_ERANGE);
	assert_int_equal(fw_get_i64("-9223372036854775809", 20, &x), FW_ERANGE);
	assert_int_equal(fw_get_i64("99999999999999999999999999", 26, &x), FW_ERANGE);
	assert_int_equal(fw_get_i64("18446744073709551617", 20, &x), FW_ERANGE);
	assert_true(x == 7);
	assert_int_equal(fw_get_i64("+000000000000000000000000005", 28, &x), FW_OK);
	assert_true(x == 5);
	assert_int_equal(fw_get_i64("-0", 2, &x), FW_OK);
	assert_true(x == 0);
}

/* What fw_put_double writes, fw_get_double reads: to the bit, the sign of zero aside. */
static void round_trip(void **state)
{
	char text[FW_SHORTEST_ROOM];
	double back = 0;
	float back_float = 0;

	(void)state;
	for (int i = 0; i < MANY; i++) {
		double x = random_value();
		float f = random_finite_float();
		assert_int_equal(fw_get_double(text, (size_t)(fw_put_double(text, x) - text), &back), FW_OK);
		assert_int_equal(fw_get_float(text, (size_t)(fw_put_float(text, f) - text), &back_float),
		                 FW_OK);
		assert_true(back == x && back_float == f);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(fixed_by_hand),
	    cmocka_unit_test(fixed_equals_printf),
	    cmocka_unit_test(fixed_equals_printf_where_the_paths_meet),
	    cmocka_unit_test(shortest_equals_repr),
	    cmocka_unit_test(double_reads_back),
	    cmocka_unit_test(float_reads_back),
	    cmocka_unit_test(no_text_is_shorter_or_nearer),
	    cmocka_unit_test(no_float_text_is_shorter_or_nearer),
	    cmocka_unit_test(whole_numbers_equal_printf_and_read_back),
	    cmocka_unit_test(nothing_is_written_behind_the_room),
#ifdef NDEBUG
	    cmocka_unit_test(non_finite_writes_nothing),
#endif
	    cmocka_unit_test(read_equals_strtod),
	    cmocka_unit_test(read_equals_strtod_at_ties),
	    cmocka_unit_test(read_accepts),
	    cmocka_unit_test(read_refuses),
	    cmocka_unit_test(read_stops_at_the_end_of_the_field),
	    cmocka_unit_test(read_bounds_the_length),
	    cmocka_unit_test(read_whole_range),
	    cmocka_unit_test(round_trip),
	};

	return cmocka_run_group_tests(tests, NULL, NULL);
}
