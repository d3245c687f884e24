# Memory does not grow with the input: at most 32 MiB for 4 GiB through a pipe, and less for each other kind of output.
set -u
. "$SRC/tests/common.bash"

# within_limits BYTES ARGUMENT...
within_limits() {
	local bytes=$1
	shift
	"$BENCH/extend_log" "$log" 0 2> endless | head -c "$bytes" | "$TOOLS/peak" peak "$sbf2csv" "$@" > /dev/null 2> messages
	[ "${PIPESTATUS[2]}" -le 1 ] || complain "$*: exit ${PIPESTATUS[2]}: $(tail -n 1 messages)"
	echo "$* of $((bytes >> 20)) MiB: $(< peak) KiB"
	[ "$(< peak)" -le 32768 ] || complain "$*: $(< peak) KiB"
}
within_limits $((256 << 20)) -s
first=$(< peak)
within_limits $((4096 << 20)) -s
[ $(($(< peak) - first)) -le 256 ] || complain "grew by $(($(< peak) - first)) KiB"
within_limits $((1024 << 20)) -t obs
within_limits $((1024 << 20)) -f lcm
within_limits $((1024 << 20)) --list
within_limits $((256 << 20)) --split tables
rm -r tables

# What sbf2csv writes it can read in the same way.
for format in "-s" "-f lcm"; do
	"$BENCH/extend_log" "$log" 200 | "$sbf2csv" $format 2> messages | "$TOOLS/peak" peak "$sbf2csv" -s > /dev/null 2> messages
	[ "${PIPESTATUS[2]}" = 0 ] || complain "reading $format: $(tail -n 1 messages)"
	[ "$(< peak)" -le 32768 ] || complain "reading $format: $(< peak) KiB"
done
exit $failed
