# Neither language nor time zone of the user changes a byte.
set -u
. "$SRC/tests/common.bash"
for mode in "-s" "-f lcm" "--list"; do
	LC_ALL=C TZ=UTC0 "$sbf2csv" $mode < "$log" > want 2> messages
	TZ=America/St_Johns "$sbf2csv" $mode < "$log" > other 2> messages
	cmp want other || complain "$mode: depends on TZ"
	TZ=LHT-10:30LHDT-11,M10.1.0,M4.1.0 "$sbf2csv" $mode --from 2023-01-01T00:00:00Z < "$log" > other 2> messages
	TZ=UTC0 "$sbf2csv" $mode --from 2023-01-01T00:00:00Z < "$log" > want 2> messages
	cmp want other || complain "$mode --from: depends on TZ"
done
localedef -i de_DE -f UTF-8 ./de_DE.UTF-8 2> messages || { echo "no German locale here"; exit $failed; }
export LOCPATH=$PWD
for mode in "-s" "-f lcm" "--list" "-s --every 0.5"; do
	LC_ALL=C "$sbf2csv" $mode < "$log" > want 2> messages
	LC_ALL=de_DE.UTF-8 "$sbf2csv" $mode < "$log" > other 2> messages
	cmp want other || complain "$mode: depends on the locale"
done
exit $failed
