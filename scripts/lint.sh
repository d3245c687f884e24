#!/bin/sh
# What a compiler does not check: layout, functions that we do not use, heap where there is none, cppcheck.
set -eu
cd "$(dirname "$0")/.."
failed=0

sources=$(find lib formats cli tests -name '*.[ch]')
clang-format --dry-run -Werror $sources || failed=1

# complain MESSAGE PATTERN FILE...
complain() {
	message=$1 pattern=$2
	shift 2
	if grep -nE "$pattern" "$@"; then
		echo "lint: $message" >&2
		failed=1
	fi
}
complain "unbounded or locale-dependent: not in furrow" \
	'(^|[^_[:alnum:]])(sprintf|vsprintf|strcpy|strcat|gets|atoi|atol|atof|sscanf|fscanf|scanf|alloca|system|popen)\(' $sources
complain "lib and formats own no memory; the caller does" \
	'(^|[^_[:alnum:]])(malloc|calloc|realloc|strdup|free)\(' $(find lib formats -name '*.[ch]')

cppcheck -q --std=c11 --enable=warning,portability --inline-suppr --error-exitcode=1 -Ilib -I. lib formats cli || failed=1
exit $failed
