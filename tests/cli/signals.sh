# SIGINT and SIGTERM: whole rows, a last line that says partial, the exit status of the signal; with -o the old file.
set -u
. "$SRC/tests/common.bash"
rm -rf out
mkdir out

ulimit -f 1000000 # 1 GB: a tool that does not end must not fill the disk

# caught PID: waits until the program catches SIGINT and SIGTERM
caught() {
	until grep -q '^SigCgt:.*4..2$' "/proc/$1/status" || ! kill -0 "$1"; do
		sleep 0.01
	done
}

# interrupted SIGNAL STATUS ARGUMENT...: sends SIGNAL while an endless log is read and something has been written
interrupted() {
	local signal=$1 wanted=$2 status=0
	shift 2
	"$sbf2csv" "$@" < <("$BENCH/extend_log" "$log" 0 2> endless) > printed 2> messages &
	caught $!
	sleep 0.1
	[[ $* = *out* || $* = --list ]] || until [ -s printed ] || ! kill -0 $!; do sleep 0.01; done
	kill -"$signal" $!
	wait $! || status=$?
	[ $status = "$wanted" ] || complain "$signal, $*: exit $status"
}

"$sbf2csv" -s "$log" > log.stream 2> messages
"$sbf2csv" -f lcm "$log" > log.lcm 2> messages
for signal in INT TERM; do
	status=$((128 + $(kill -l $signal)))
	interrupted $signal $status -s
	tail -n 1 printed | grep -q '^#end status=partial rows=[1-9][0-9]* skipped=0$' || complain "$signal: no #end"
	expect 1 "$signal: reading it again" "$sbf2csv" -s printed > again
	[ "$(grep -c '^[^#]' printed)" = "$(grep -c '^[^#]' again)" ] || complain "$signal: rows that cannot be read again"

	interrupted $signal $status -t obs
	awk -F, 'NR == 1 { n = NF } NF != n { exit 1 } END { exit NR < 2 }' printed || complain "$signal: half a row"
	[ -z "$(tail -c 1 printed)" ] || complain "$signal: no line end"

	for mode in "-t obs" "-s" "-f lcm" "--list"; do
		echo old > out/target
		interrupted $signal $status $mode -o out/target
		[ "$(< out/target)" = old ] || complain "$signal, $mode: the target has changed"
		[ "$(ls -A out)" = target ] || complain "$signal, $mode: left behind: $(ls -A out | tr '\n' ' ')"
	done
	echo old > out/obs.csv
	rm out/target
	interrupted $signal $status --split out
	[ "$(< out/obs.csv)" = old ] || complain "$signal, --split: a table has changed"
	[ "$(ls -A out)" = obs.csv ] || complain "$signal, --split: left behind: $(ls -A out | tr '\n' ' ')"
	rm out/obs.csv

	# While it waits: for a log that pauses, for a writer, for a reader.
	rm -f pipe
	mkfifo pipe
	for arguments in "-s pipe" "-s -o pipe $log"; do
		status_now=0
		"$sbf2csv" $arguments > printed 2> messages &
		caught $!
		sleep 0.05
		kill -$signal $!
		wait $! || status_now=$?
		[ $status_now = $status ] || complain "$signal, $arguments: exit $status_now"
	done
	# In the midst of a block, a row, an event: it is not the log that ends there, so nothing is lost.
	for input in "$log" log.stream log.lcm; do
		status_now=0
		"$sbf2csv" -s < <(head -c -5 "$input"; sleep 1) > printed 2> messages &
		caught $!
		sleep 0.1
		kill -$signal $!
		wait $! || status_now=$?
		[ $status_now = $status ] || complain "$signal, $input that pauses: exit $status_now"
		tail -n 1 printed | grep -q '^#end status=partial rows=[1-9][0-9]* skipped=0$' ||
			complain "$signal, $input that pauses: $(tail -n 1 printed)"
	done
done
exit $failed
