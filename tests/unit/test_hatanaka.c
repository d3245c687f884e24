/* Compact RINEX back to RINEX. The files were compressed by RNX2CRX 4.1.0, and the lines that must come back
 * are those that CRX2RNX 4.1.0 gives (PyPI's hatanaka). Real files: tests/oracle/test_rinex.py. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "formats/hatanaka.h"

/* clang-format off */
static const char three_compact[] =
    "3.0                 COMPACT RINEX FORMAT                    CRINEX VERS   / TYPE\n"
    "RNX2CRX ver.4.1.0                       22-Nov-26 00:00     CRINEX PROG / DATE\n"
    "     3.04           OBSERVATION DATA    M                   RINEX VERSION / TYPE\n"
    "G    3 C1C L1C S1C                                          SYS / # / OBS TYPES\n"
    "R    1 C1C                                                  SYS / # / OBS TYPES\n"
    "                                                            END OF HEADER\n"
    "> 2024 06 24 08 20  0.0000000  0  2      G05R12\n"
    "3&-123456\n"
    "3&20005000615 3&105289483921 3&45250 &&&7&&\n"
    "3&20012001476 &&\n"
    "                    1             3            G07\n"
    "1000\n"
    "613000 3226316 250   1\n"
    "613000\n"
    "3&20007613861 3&105303237847 3&45500 &&17&&\n"
    ">                              4  1\n"
    "an event                                                    COMMENT\n"
    "> 2024 06 24 08 20  2.0000000  0  2      G07R12\n"
    "3&-121456\n"
    "3&20008228261  3&45750 &&&&&&\n"
    "3&20013228876 &&\n"
    "                    3                       G05\n"
    "1000\n"
    "615800 3&105309712584 250    7\n"
    "3&20006843815 3&105299184974 3&46000 &&&7&&\n"
    ;

static const char three_plain[] =
    "     3.04           OBSERVATION DATA    M                   RINEX VERSION / TYPE\n"
    "G    3 C1C L1C S1C                                          SYS / # / OBS TYPES\n"
    "R    1 C1C                                                  SYS / # / OBS TYPES\n"
    "                                                            END OF HEADER\n"
    "> 2024 06 24 08 20  0.0000000  0  2       -.000000123456\n"
    "G05  20005000.615   105289483.921 7        45.250\n"
    "R12  20012001.476\n"
    "> 2024 06 24 08 20  1.0000000  0  3       -.000000122456\n"
    "G05  20005613.615   105292710.23717        45.500\n"
    "R12  20012614.476\n"
    "G07  20007613.861   105303237.84717        45.500\n"
    ">                              4  1\n"
    "an event                                                    COMMENT\n"
    "> 2024 06 24 08 20  2.0000000  0  2       -.000000121456\n"
    "G07  20008228.261                          45.750\n"
    "R12  20013228.876\n"
    "> 2024 06 24 08 20  3.0000000  0  2       -.000000120456\n"
    "G07  20008844.061   105309712.584 7        46.000\n"
    "G05  20006843.815   105299184.974 7        46.000\n"
    ;

static const char two_compact[] =
    "1.0                 COMPACT RINEX FORMAT                    CRINEX VERS   / TYPE\n"
    "RNX2CRX ver.4.1.0                       22-Nov-26 00:00     CRINEX PROG / DATE\n"
    "     2.11           OBSERVATION DATA    G                   RINEX VERSION / TYPE\n"
    "     6    C1    L1    L2    P2    D1    S1                  # / TYPES OF OBSERV\n"
    "                                                            END OF HEADER\n"
    "&05  3 24 13 10 36.0000000  0 13G 1G 2G 3G 4G 5G 6G 7G 8G 9G10G11G12G13\n"
    "3&123\n"
    "3&21000000000 3&110526315789  3&21000003000 3&-353 3&40000   12\n"
    "3&21000100000 3&110526842105 3&-3000014786 3&21000103000 3&-353 3&40000   12 5\n"
    "3&21000200000 3&110527368421  3&21000203000 3&-353 3&40000   12\n"
    "3&21000300000 3&110527894737 3&-3000043357 3&21000303000 3&-353 3&40000   12 5\n"
    "3&21000400000 3&110528421053  3&21000403000 3&-353 3&40000   12\n"
    "3&21000500000 3&110528947368 3&-3000071929 3&21000503000 3&-353 3&40000   12 5\n"
    "3&21000600000 3&110529473684  3&21000603000 3&-353 3&40000   12\n"
    "3&21000700000 3&110530000000 3&-3000100500 3&21000703000 3&-353 3&40000   12 5\n"
    "3&21000800000 3&110530526316  3&21000803000 3&-353 3&40000   12\n"
    "3&21000900000 3&110531052632 3&-3000129071 3&21000903000 3&-353 3&40000   12 5\n"
    "3&21001000000 3&110531578947  3&21001003000 3&-353 3&40000   12\n"
    "3&21001100000 3&110532105263 3&-3000157643 3&21001103000 3&-353 3&40000   12 5\n"
    "3&21001200000 3&110532631579  3&21001203000 3&-353 3&40000   12\n"
    "&                           4  1\n"
    "an event                                                    COMMENT\n"
    "&05  3 24 13 10 37.0000000  0 13G 1G 2G 3G 4G 5G 6G 7G 8G 9G10G11G12G13\n"
    "\n"
    "3&21000033500 3&110526492105  3&21000036500 3&647 3&41000   12\n"
    "3&21000133500 3&110527018421 3&-3000019571 3&21000136500 3&647 3&41000   12 5\n"
    "3&21000233500 3&110527544737  3&21000236500 3&647 3&41000   12\n"
    "3&21000333500 3&110528071053 3&-3000048143 3&21000336500 3&647 3&41000   12 5\n"
    "3&21000433500 3&110528597368  3&21000436500 3&647 3&41000   12\n"
    "3&21000533500 3&110529123684 3&-3000076714 3&21000536500 3&647 3&41000   12 5\n"
    "3&21000633500 3&110529650000  3&21000636500 3&647 3&41000   12\n"
    "3&21000733500 3&110530176316 3&-3000105286 3&21000736500 3&647 3&41000   12 5\n"
    "3&21000833500 3&110530702632  3&21000836500 3&647 3&41000   12\n"
    "3&21000933500 3&110531228947 3&-3000133857 3&21000936500 3&647 3&41000   12 5\n"
    "3&21001033500 3&110531755263  3&21001036500 3&647 3&41000   12\n"
    "3&21001133500 3&110532281579 3&-3000162429 3&21001136500 3&647 3&41000   12 5\n"
    "3&21001233500 3&110532807895  3&21001236500 3&647 3&41000   12\n"
    "                 8            &2      & && && && && && && &&&&&&&&&&&&&\n"
    "3&121\n"
    "33500 176316  33500 1000 1000\n"
    "33500 176316 -4786 33500 1000 1000\n"
    ;

static const char two_plain[] =
    "     2.11           OBSERVATION DATA    G                   RINEX VERSION / TYPE\n"
    "     6    C1    L1    L2    P2    D1    S1                  # / TYPES OF OBSERV\n"
    "                                                            END OF HEADER\n"
    " 05  3 24 13 10 36.0000000  0 13G 1G 2G 3G 4G 5G 6G 7G 8G 9G10G11G12  .000000123\n"
    "                                G13\n"
    "  21000000.000   110526315.78912                  21000003.000           -.353\n"
    "        40.000\n"
    "  21000100.000   110526842.10512  -3000014.786 5  21000103.000           -.353\n"
    "        40.000\n"
    "  21000200.000   110527368.42112                  21000203.000           -.353\n"
    "        40.000\n"
    "  21000300.000   110527894.73712  -3000043.357 5  21000303.000           -.353\n"
    "        40.000\n"
    "  21000400.000   110528421.05312                  21000403.000           -.353\n"
    "        40.000\n"
    "  21000500.000   110528947.36812  -3000071.929 5  21000503.000           -.353\n"
    "        40.000\n"
    "  21000600.000   110529473.68412                  21000603.000           -.353\n"
    "        40.000\n"
    "  21000700.000   110530000.00012  -3000100.500 5  21000703.000           -.353\n"
    "        40.000\n"
    "  21000800.000   110530526.31612                  21000803.000           -.353\n"
    "        40.000\n"
    "  21000900.000   110531052.63212  -3000129.071 5  21000903.000           -.353\n"
    "        40.000\n"
    "  21001000.000   110531578.94712                  21001003.000           -.353\n"
    "        40.000\n"
    "  21001100.000   110532105.26312  -3000157.643 5  21001103.000           -.353\n"
    "        40.000\n"
    "  21001200.000   110532631.57912                  21001203.000           -.353\n"
    "        40.000\n"
    "                            4  1\n"
    "an event                                                    COMMENT\n"
    " 05  3 24 13 10 37.0000000  0 13G 1G 2G 3G 4G 5G 6G 7G 8G 9G10G11G12\n"
    "                                G13\n"
    "  21000033.500   110526492.10512                  21000036.500            .647\n"
    "        41.000\n"
    "  21000133.500   110527018.42112  -3000019.571 5  21000136.500            .647\n"
    "        41.000\n"
    "  21000233.500   110527544.73712                  21000236.500            .647\n"
    "        41.000\n"
    "  21000333.500   110528071.05312  -3000048.143 5  21000336.500            .647\n"
    "        41.000\n"
    "  21000433.500   110528597.36812                  21000436.500            .647\n"
    "        41.000\n"
    "  21000533.500   110529123.68412  -3000076.714 5  21000536.500            .647\n"
    "        41.000\n"
    "  21000633.500   110529650.00012                  21000636.500            .647\n"
    "        41.000\n"
    "  21000733.500   110530176.31612  -3000105.286 5  21000736.500            .647\n"
    "        41.000\n"
    "  21000833.500   110530702.63212                  21000836.500            .647\n"
    "        41.000\n"
    "  21000933.500   110531228.94712  -3000133.857 5  21000936.500            .647\n"
    "        41.000\n"
    "  21001033.500   110531755.26312                  21001036.500            .647\n"
    "        41.000\n"
    "  21001133.500   110532281.57912  -3000162.429 5  21001136.500            .647\n"
    "        41.000\n"
    "  21001233.500   110532807.89512                  21001236.500            .647\n"
    "        41.000\n"
    " 05  3 24 13 10 38.0000000  0  2G 1G 2                                .000000121\n"
    "  21000067.000   110526668.42112                  21000070.000           1.647\n"
    "        42.000\n"
    "  21000167.000   110527194.73712  -3000024.357 5  21000170.000           1.647\n"
    "        42.000\n"
    ;

/* clang-format on */

static fw_input input;
static fw_lines lines;
static fw_hatanaka filter;
static char text[1 << 16];
static int n_problems;
static uint64_t problem_line;

/* Decompresses n bytes into `text`. */
static fw_status expand(const char *bytes, size_t n)
{
	fw_line line;
	fw_status status;
	size_t used = 0;

	n_problems = 0;
	fw_input_open_memory(&input, bytes, n);
	fw_lines_begin(&lines, &input);
	fw_hatanaka_begin(&filter, &lines);
	while ((status = fw_hatanaka_next(&filter, &line)) == FW_OK || status == FW_ESYNTAX) {
		if (status == FW_ESYNTAX) {
			n_problems++;
			problem_line = filter.problem.line;
			assert_true(filter.problem.reason[0] != '\0');
			continue;
		}
		while (line.n > 0 && line.text[line.n - 1] == ' ')
			line.n--;
		assert_true(used + line.n + 1 < sizeof text);
		memcpy(text + used, line.text, line.n);
		used += line.n;
		text[used++] = '\n';
	}
	text[used] = '\0';
	return status;
}

static void version_3(void **state)
{
	(void)state;
	assert_int_equal(expand(three_compact, sizeof three_compact - 1), FW_EOF);
	assert_string_equal(text, three_plain);
	assert_int_equal(n_problems, 0);
}

static void version_1(void **state)
{
	(void)state;
	assert_int_equal(expand(two_compact, sizeof two_compact - 1), FW_EOF);
	assert_string_equal(text, two_plain);
	assert_int_equal(n_problems, 0);
}

/* Escape lines of version 3, and the end of file of DOS. */
static void oddities(void **state)
{
	static char bytes[sizeof three_compact + 64];
	const char *epoch = strstr(three_compact, "> 2024");
	const size_t head = (size_t)(epoch - three_compact);
	(void)state;
	const int n = snprintf(bytes, sizeof bytes, "%.*s&escaped\n&\n%s\x1a\nrubbish", (int)head,
	                       three_compact, epoch);
	assert_int_equal(expand(bytes, (size_t)n), FW_EOF);
	assert_string_equal(text, three_plain);
}

/* One byte is not what it was. What is lost is lost up to the next epoch that begins anew, and not without a
 * word. */
static void damaged(void **state)
{
	static const struct {
		const char *was, *is;
		int line;
	} cases[] = {
	    {"613000 3226316", "61x000 3226316", 13}, {"3&20007613861", "9&20007613861", 15},
	    {"3&20007613861", "&&20007613861", 15},   {"G05R12\n3&-1", "G05R1x\n3&-1", 7},
	    {"G05R12\n3&-1", "G05G05\n3&-1", 7},      {"  1             3", "  1             9", 11},
	    {"\n1000\n613000", "\n1x00\n613000", 12}, {"0  2      G05R12", "0999      G05R12", 7},
	};
	static char bytes[sizeof three_compact];
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		memcpy(bytes, three_compact, sizeof bytes);
		memcpy(strstr(bytes, cases[i].was), cases[i].is, strlen(cases[i].is));
		const fw_status status = expand(bytes, sizeof bytes - 1);
		assert_int_equal(status, FW_EOF);
		assert_int_equal(n_problems, 1);
		assert_int_equal(problem_line, cases[i].line);
		/* the epoch at 2 s begins anew: it and the last one are whole */
		const char *rest = strstr(three_plain, ">                              4");
		assert_non_null(strstr(text, rest));
	}
}

static void not_compact(void **state)
{
	static const char other[] =
	    "9.0                 COMPACT RINEX FORMAT                    CRINEX VERS   / TYPE\n";
	(void)state;
	assert_int_equal(expand(other, sizeof other - 1), FW_EUNKNOWN);
	assert_int_equal(filter.problem.line, 1);
	assert_int_equal(expand("", 0), FW_EOF);
}

/* Sums of differences that wrap around, numbers that do not fit: no value comes out that was not sent. */
static void large_numbers(void **state)
{
	static const char head[] =
	    "3.0                 COMPACT RINEX FORMAT                    CRINEX VERS   / TYPE\n"
	    "x\n"
	    "     3.04           OBSERVATION DATA    M                   RINEX VERSION / TYPE\n"
	    "G    1 C1C                                                  SYS / # / OBS TYPES\n"
	    "                                                            END OF HEADER\n";
	static const char *const values[] = {
	    "3&9999999999999",       "3&99999999999999", "3&9223372036854775807", "3&-9223372036854775808",
	    "3&9223372036854775808", "3&-999999999999",  "3&-9999999999999"};
	static const bool fits[] = {true, false, false, false, false, true, false};
	char bytes[2048];
	(void)state;
	for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
		int n = snprintf(bytes, sizeof bytes,
		                 "%s> 2024 06 24 08 20  0.0000000  0  1      G05\n\n%s\n", head, values[i]);
		for (int k = 0; k < 5; k++)
			n += snprintf(bytes + n, sizeof bytes - (size_t)n, "%41s\n\n9223372036854775807\n",
			              "");
		assert_true(expand(bytes, (size_t)n) == FW_EOF);
		assert_int_equal(n_problems, 1);
		assert_int_equal(strstr(text, "\nG05") != NULL, fits[i]);
	}
}

/* Cut short at any byte: a beginning of the whole. A number that is cut short is not believed. */
static void cut_anywhere(void **state)
{
	static const struct {
		const char *compact, *plain;
	} files[] = {{three_compact, three_plain}, {two_compact, two_plain}};
	(void)state;
	for (size_t i = 0; i < 2; i++) {
		for (size_t cut = 0; cut < strlen(files[i].compact); cut++) {
			const fw_status status = expand(files[i].compact, cut);
			assert_true(status == FW_EOF || status == FW_ETRUNCATED || status == FW_EUNKNOWN);
			assert_int_equal(n_problems, 0);
			if (cut > (size_t)(strstr(files[i].compact, "END OF HEADER") - files[i].compact) + 20)
				assert_memory_equal(text, files[i].plain, strlen(text));
		}
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	    cmocka_unit_test(version_3),    cmocka_unit_test(version_1),   cmocka_unit_test(oddities),
	    cmocka_unit_test(damaged),      cmocka_unit_test(not_compact), cmocka_unit_test(large_numbers),
	    cmocka_unit_test(cut_anywhere),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
