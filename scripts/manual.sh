#!/bin/sh
# The record types in furrow-stream(5) come from formats/records/*.lcm, in the order of formats/record.h.
#   scripts/manual.sh          rewrite them in man/furrow-stream.5
#   scripts/manual.sh check    exit 1 when they are not what the definitions say
set -eu
cd "$(dirname "$0")/.."
page=man/furrow-stream.5
new=$(mktemp)
trap 'rm -f "$new"' EXIT

types=$(sed -n '/define FW_RECORD_TYPES/,/[^\\]$/p' formats/record.h | grep -o 'X([a-z_0-9]*)' | sed 's/X(\(.*\))/\1/')
files=
for type in $types; do
	files="$files formats/records/$type.lcm"
done
{
	sed '/^\.\\" records: begin/q' "$page"
	awk -f formats/records/manual.awk $files
	sed -n '/^\.\\" records: end/,$p' "$page"
} >"$new"

if [ "${1:-}" = check ]; then
	diff -u "$page" "$new" || { echo "manual.sh: run scripts/manual.sh" >&2 && exit 1; }
else
	cat "$new" >"$page"
fi
