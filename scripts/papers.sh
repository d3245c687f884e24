#!/bin/sh
# The tests of the papers, on the release build: tables "paper | furrow" and pictures in build/papers.
#   scripts/papers.sh [options of tests/papers/papers.py]
set -eu
cd "$(dirname "$0")/.."
python=build/venv/bin/python3
if [ ! -x $python ]; then
	echo "furrow: no $python (scripts/venv.sh makes it, PyPI needed)" >&2
	exit 1
fi
status=0
$python tests/papers/papers.py --bin build/release/bin --campaign build/release/tools/campaign -o build/papers "$@" ||
	status=$?
echo "furrow: build/papers/REPORT.md, build/papers/REPORT.html"
exit $status
