# Pipes: readers that leave, logs that come in pieces, logs that pause.
set -u
. "$SRC/tests/common.bash"
"$BENCH/extend_log" "$log" 4 > long.sbf
"$sbf2csv" -s < "$log" > want.stream 2> messages || [ $? = 1 ] || complain "reference failed"

# The reader leaves after any number of bytes: no message, the end by SIGPIPE.
for bytes in $(seq 1 99991 5000000); do
	"$sbf2csv" -s long.sbf 2> messages | head -c "$bytes" > head.stream
	status=${PIPESTATUS[0]}
	[ "$status" = 141 ] || complain "reader that leaves after $bytes bytes: exit $status"
	[ ! -s messages ] || complain "reader that leaves after $bytes bytes: $(head -n 1 messages)"
done
started=${EPOCHREALTIME/./}
"$BENCH/extend_log" "$log" 0 2> endless | "$sbf2csv" -s 2> messages | head -n 1 > head.stream
status=${PIPESTATUS[1]}
[ "$status" = 141 ] || complain "head -n 1: exit $status"
[ $((${EPOCHREALTIME/./} - started)) -lt 1000000 ] || [ "$SANITIZE" = ON ] || complain "head -n 1: took over a second"

# Pieces of any size: the same bytes.
for pieces in "1 1" "7 2" "100 3" "4096 4" "4096 5"; do
	"$TOOLS/feed" $pieces "$sbf2csv" -s < "$log" > stream 2> messages
	cmp want.stream stream || complain "pieces of 1 to ${pieces% *} bytes: other output"
	gzip -c "$log" | "$TOOLS/feed" $pieces "$sbf2csv" -s > stream 2> messages
	cmp want.stream stream || complain "gzip in pieces of 1 to ${pieces% *} bytes: other output"
done
"$sbf2csv" -s < want.stream > want 2> messages
"$TOOLS/feed" 3 6 "$sbf2csv" -s < want.stream > stream 2> messages
cmp want stream || complain "a stream in pieces: other output"
"$sbf2csv" -f lcm < "$log" > log.lcm 2> messages
"$sbf2csv" -s < log.lcm > want 2> messages
"$TOOLS/feed" 3 7 "$sbf2csv" -s < log.lcm > stream 2> messages
cmp want stream || complain "an LCM log in pieces: other output"

# A log that pauses: what is there becomes rows within a second, be it one small block only.
# row_within_a_second START END LINE ARGUMENT...: line number LINE comes while the input stays open
row_within_a_second() {
	local start=$1 end=$2 line=$3 i lines=0
	shift 3
	mkfifo live
	"$sbf2csv" "$@" < live 2> messages > rows &
	exec 9> live
	tail -c +$((start + 1)) "$log" | head -c $((end - start)) >&9
	for ((i = 0; i < 10 && lines < line; i++)); do
		sleep 0.1
		lines=$(wc -l < rows)
	done
	exec 9>&-
	wait $!
	rm live
	[ "$lines" -ge "$line" ] || [ "$SANITIZE" = ON ] || complain "$*: nothing after a second of bytes $start to $end"
}
# Start and end of the first block with this number, from the lengths in the headers.
block() {
	od -An -v -tu1 -w1 "$log" | awk -v wanted="$1" '{ b[NR - 1] = $1 }
		END { for (at = 0; at < NR; at = end) {
			end = at + b[at + 6] + 256 * b[at + 7]
			if ((b[at + 4] + 256 * b[at + 5]) % 8192 == wanted) { print at, end; exit } } }'
}
row_within_a_second $(block 4027) 2 -t obs
row_within_a_second $(block 4027) 20 -s
row_within_a_second $(block 4014) 2 -t status
exit $failed
