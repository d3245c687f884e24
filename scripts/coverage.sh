#!/bin/sh
# Lines and branches of lib, formats and cli that the last tests of the coverage build reached.
set -eu
cd "$(dirname "$0")/.."
out=build/coverage
branches="--rc lcov_branch_coverage=1"

lcov -q $branches --capture --directory $out --base-directory "$PWD" --output-file $out/all.info
lcov -q $branches --extract $out/all.info "$PWD/lib/*" "$PWD/formats/*" "$PWD/cli/*" --output-file $out/furrow.info
lcov $branches --list $out/furrow.info
genhtml -q --branch-coverage --output-directory $out/html $out/furrow.info
echo "in detail: $out/html/index.html"
