# insgnss-fuse without memory: each heap call fails in its turn, and the tool ends with a message or does without. And the
# number of heap calls depends on the length of the log by what smoothing keeps only.
set -u
. "$SRC/tests/common.bash"
cat > still.ini <<'EOF'
[trajectory]
waypoint = 0 0 0 1 10
[attitude]
baseline_m = -1 0 0
[base]
present = no
EOF
"$BIN/gnss-sim" -q still.ini -o short || exit 1
"$BIN/gnss-sim" -q still.ini -o long --set 'trajectory.waypoint=0 1 0 1 60' || exit 1

preload() {
	LD_PRELOAD=$FAULTS/fail_heap.so HEAP_COUNT=count "$@"
}

# fail_each ARGUMENT...
fail_each() {
	local n=0
	reference "$BIN/insgnss-fuse" -q "$@"
	echo 0 > count
	until [ "$(< count)" -lt $n ]; do
		n=$((n + 1))
		HEAP_FAIL=$n attempt "heap call $n of $*" preload "$BIN/insgnss-fuse" -q "$@"
	done
}
fail_each --imu short/imu.csv short/rover.sbf
fail_each -s -o out/stream --imu short/imu.csv short/rover.sbf
fail_each --smooth rts -o out/nav --imu short/imu.csv short/rover.sbf
fail_each --smooth rts --memory 1 -o out/nav --imu short/imu.csv short/rover.sbf
fail_each --compass yes --compass-calibration log -o out/nav --imu short/imu.csv --mag short/mag.csv short/rover.sbf

for mode in "" "-s" "-f lcm"; do
	preload "$BIN/insgnss-fuse" -q $mode --imu short/imu.csv short/rover.sbf > /dev/null
	once=$(< count)
	preload "$BIN/insgnss-fuse" -q $mode --imu long/imu.csv long/rover.sbf > /dev/null
	[ "$(< count)" = "$once" ] || complain "$mode: $once heap calls for 10 s, $(< count) for more"
done
exit $failed
