#!/bin/sh
# Every benchmark of tests/bench, on the release build: scripts, and programs in C.
set -eu
cd "$(dirname "$0")/.."
SRC=$PWD
BIN=$SRC/build/release/bin
BENCH=$SRC/build/release/bench
TOOLS=$SRC/build/release/tools
PYTHON=$SRC/build/venv/bin/python3
FURROW_DATA=${FURROW_DATA:-$SRC/../shared/data}
export SRC BIN BENCH TOOLS PYTHON FURROW_DATA
mkdir -p build/bench # scratch

for bench in "$BENCH"/bench_*; do
	echo "== $(basename "$bench")"
	"$bench"
done
for bench in "$SRC"/tests/bench/*.sh; do
	echo "== $(basename "$bench" .sh)"
	(cd build/bench && bash "$bench")
done
