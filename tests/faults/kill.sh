# kill -9 at 200 random times: the target is the old file or the new one, whole.
set -u
. "$SRC/tests/common.bash"
RANDOM=1
rm -rf out
mkdir out
"$BENCH/extend_log" "$log" 4 > long.sbf
started=${EPOCHREALTIME/./}
"$sbf2csv" -s -o out/target long.sbf 2> messages || [ $? = 1 ] || complain "reference failed"
took=$((${EPOCHREALTIME/./} - started))
mv out/target want
old=0 new=0
for ((i = 0; i < 200; i++)); do
	echo old > out/target
	"$sbf2csv" -s -o out/target long.sbf 2> messages &
	# Up to a fifth longer than it takes, so that some come through.
	wait_us=$((took * (RANDOM % 120) / 100))
	sleep "$(printf '%d.%06d' $((wait_us / 1000000)) $((wait_us % 1000000)))"
	kill -9 $! 2> gone
	wait $! 2> gone
	if [ "$(head -c 4 out/target)" = old ]; then
		old=$((old + 1))
	elif cmp -s out/target want; then
		new=$((new + 1))
	else
		complain "kill $i: neither the old file nor the new one"
	fi
	rm -f out/.target.*.part
	[ "$(ls -A out)" = target ] || complain "kill $i: left behind: $(ls -A out | tr '\n' ' ')"
done
echo "$old old, $new new"
[ $old -gt 20 ] || complain "too few were killed early: nothing was tested"
exit $failed
