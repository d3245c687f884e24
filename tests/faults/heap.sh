# Without memory: each heap call fails in its turn, and the tool ends with a message or does without.
# And the number of heap calls does not depend on the length of the log.
set -u
. "$SRC/tests/common.bash"
printf '[sbf2csv]\ntypes = obs\noutput = out/table\n' > settings.ini
gzip -c "$log" > log.gz
"$BENCH/extend_log" "$log" 0.8 > ten.sbf # ten times log_0000.sbf

preload() {
	LD_PRELOAD=$FAULTS/fail_heap.so HEAP_COUNT=count "$@"
}

# fail_each ARGUMENT...
fail_each() {
	local n=0
	reference "$sbf2csv" "$@"
	echo 0 > count
	until [ "$(< count)" -lt $n ]; do
		n=$((n + 1))
		HEAP_FAIL=$n attempt "heap call $n of $*" preload "$sbf2csv" "$@"
	done
}
fail_each -t obs "$log"
fail_each -s -o out/stream "$log"
fail_each -f lcm -o out/log "$log"
fail_each --split out "$log"
fail_each -f rinex --split out "$log"
fail_each --list -o out/list "$log"
fail_each -c settings.ini "$log"
fail_each -s -o out/stream log.gz
fail_each --help
fail_each --print-config -c settings.ini

for mode in "-t obs" "-s" "-f lcm" "--list" "--split tables" "-f rinex --split tables" "-s --every 1 --from 2000:0"; do
	preload "$sbf2csv" $mode "$log" > /dev/null 2> messages
	once=$(< count)
	preload "$sbf2csv" $mode ten.sbf > /dev/null 2> messages
	[ "$(< count)" = "$once" ] || complain "$mode: $once heap calls for a log, $(< count) for ten times that log"
done
exit $failed
