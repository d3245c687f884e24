#!/bin/sh
# Run a script of tests/oracle with the python that has the oracles, or skip it (77).
set -eu
python=${PYTHON:-$(dirname "$0")/../build/venv/bin/python3}
if [ ! -x "$python" ]; then
	echo "skipped: no $python (scripts/venv.sh makes it, PyPI needed)"
	exit 77
fi
exec "$python" "$@"
