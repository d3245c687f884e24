# furrow-config(5) has every key of every tool, in the order of --help, with the default that --help says.
set -eu
command -v mandoc > /dev/null || { echo "skipped: no mandoc"; exit 77; }
failed=0
mandoc -T ascii -O width=400 "$SRC/man/furrow-config.5" | sed 's/.\x08//g' > page
for page in "$SRC"/man/*.1; do
	tool=$(basename "$page" .1)
	# An option with its default, which may stand in the next line.
	"$BIN/$tool" --help | awk '
		/^  (-.,|   ) --/ { if (key != "") print key, value; key = $0; sub(/^[^-]*(-., )?--/, "", key); sub(/ .*/, "", key); value = "none" }
		key != "" && / \[[^]]*\]$/ { word = $0; sub(/.* \[/, "", word); sub(/\]$/, "", word); if (word !~ /^(s|m|m\/s)$/) value = word }
		END { print key, value }' |
		grep -vE '^(config|set|print-config|help|version) ' > help
	sed -n "/^   \[$tool\]/,/^   \[/p" page | sed -nE 's/^ +([a-z0-9-]+) \(.*; default ([^ ]*)\)$/\1 \2/p' > manual
	# A flag that is not set is "no".
	sed -E 's/^(quiet|verbose|stream|list|rinex) none$/\1 no/' help > wanted
	[ -s manual ] || failed=1
	diff -u --label "$tool --help" --label "furrow-config(5)" wanted manual || failed=1
done
exit $failed
