# The options that a tool's --help lists are those of its manual page, in the same order.
set -eu
failed=0
for page in "$SRC"/man/*.1; do
	tool=$(basename "$page" .1)
	"$BIN/$tool" --help | sed -nE 's/^ +(-(.), )?--([a-z-]+).*/\2 \3/p' > help
	sed -nE 's/^\.It Fl ((.) , )?-([a-z-]+).*/\2 \3/p' "$page" > manual
	[ -s help ] || failed=1
	diff -u --label "$tool --help" --label "$tool(1)" help manual || failed=1
done
exit $failed
