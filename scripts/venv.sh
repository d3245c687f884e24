#!/bin/sh
# The independent decoders of tests/oracle, from PyPI, in build/venv.
# Without a network this is no failure: the tests that need them are skipped.
set -eu
cd "$(dirname "$0")/.."

wanted=tests/oracle/requirements.txt
venv=build/venv
cmp -s "$wanted" "$venv/requirements.txt" && exit 0

echo "furrow: python oracles into $venv"
mkdir -p build
rm -rf "$venv"
if python3 -m venv "$venv" && "$venv/bin/pip" install -q --retries 1 --disable-pip-version-check -r "$wanted"; then
	cp "$wanted" "$venv/requirements.txt"
else
	rm -rf "$venv"
	echo "furrow: PyPI not reached; the tests against pysbf2, lcm and pandas will be skipped" >&2
fi
