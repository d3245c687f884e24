#!/bin/sh
# Run a libFuzzer harness for FUZZ_SECONDS.
#   scripts/fuzz.sh build/fuzz/fuzz/fuzz_NAME
# It starts from tests/fuzz/corpus/fuzz_NAME; what it learns stays in corpus/ beside the harness. An input that fails
# is left in findings/ there: put it into tests/fuzz/corpus/fuzz_NAME before the fix.
set -eu
harness=$1
name=$(basename "$harness")
directory=$(dirname "$harness")
seeds=$(dirname "$0")/../tests/fuzz/corpus/$name
[ -d "$seeds" ] || seeds=

mkdir -p "$directory/corpus/$name" "$directory/findings"
exec "$harness" -max_total_time="${FUZZ_SECONDS:-60}" -timeout=5 -malloc_limit_mb=16 -print_final_stats=1 -error_exitcode=1 \
	-artifact_prefix="$directory/findings/$name-" "$directory/corpus/$name" $seeds
