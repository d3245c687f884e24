# A log cut anywhere gives the rows of the blocks before the cut: no half row, a message, exit 1; at the end of a block
# exit 0; without a row exit 4.
#   cuts.sh [N]     cuts at N places, by default 60
set -u
. "$SRC/tests/common.bash"
cuts=${1:-60}
size=$(wc -c < "$log")

# What each cut must give, by a framing of our own: "CUT COMPLETE_BYTES OBS_ROWS", where the rows are those whose epoch has
# its MeasEpoch (4027) before the cut.
"$sbf2csv" -t obs "$log" > all.csv 2> messages
{
	awk -F, 'NR > 1 && $2 != last { print "rows", n; last = $2 } { n = NR - 1 } END { print "rows", n }' all.csv
	od -An -v -tu1 -w1 "$log"
} | awk -v cuts="$cuts" '
	$1 == "rows" { if (epochs++) rows[epochs - 1] = $2; next }
	{ b[n++] = $1 }
	END {
		srand(1)
		for (i = 0; i < cuts; i++) {
			# every fourth at the end of a block or a byte beside it
			cut[i] = int(rand() * n)
			wish[i] = i % 4 ? -1 : i / 4 % 3 - 1
		}
		for (at = 0; at < n; at = end) {
			end = at + b[at + 6] + 256 * b[at + 7]
			for (i = 0; i < cuts; i++) {
				c = cut[i]
				if (c < at || c >= end)
					continue
				if (i % 4 == 0)
					c = at + wish[i] < 0 ? 0 : at + wish[i]
				print c, c < at ? before : at, rows[c < at ? measured_before : measured] + 0
			}
			before = at
			measured_before = measured
			measured += (b[at + 4] + 256 * b[at + 5]) % 8192 == 4027
		}
	}' > places
[ "$(wc -l < places)" = "$cuts" ] || complain "$cuts places wanted, $(wc -l < places) made"

# without_end < STREAM
without_end() {
	grep -v '^#end '
}

while read -r cut complete rows; do
	head -c "$cut" "$log" > cut.sbf
	head -c "$complete" "$log" > whole.sbf

	status=0
	"$sbf2csv" -t obs < cut.sbf > obs.csv 2> messages || status=$?
	wanted=1
	[ "$cut" != "$complete" ] || wanted=0
	[ "$rows" != 0 ] || wanted=4
	[ $status = $wanted ] || complain "cut at $cut: exit $status, not $wanted"
	[ $status != 1 ] || grep -q 'the log ends inside a block' messages || complain "cut at $cut: no message"
	head -n $((rows + 1)) all.csv | cmp - obs.csv || complain "cut at $cut: not $rows rows"

	status=0 state=complete
	"$sbf2csv" -s < cut.sbf > stream 2> messages || status=$?
	"$sbf2csv" -s < whole.sbf > want.stream 2> want.messages
	[ "$cut" = "$complete" ] || state=partial
	[ -n "$(grep -v '^#' stream)" ] && [ $state = partial ] && wanted=1
	[ -n "$(grep -v '^#' stream)" ] && [ $state = complete ] && wanted=0
	[ $status = $wanted ] || complain "-s, cut at $cut: exit $status, not $wanted"
	[ "$(tail -n 1 stream)" = "#end status=$state rows=$(grep -c '^[^#]' stream) skipped=$((cut > complete))" ] ||
		complain "-s, cut at $cut: $(tail -n 1 stream)"
	cmp <(without_end < stream) <(without_end < want.stream) || complain "-s, cut at $cut: not the rows of the whole blocks"
done < places
exit $failed
