# Output that cannot be written, input that cannot be read: exit 3 and a message, whatever the mode.
set -u
. "$SRC/tests/common.bash"

# refused WHAT COMMAND...
refused() {
	expect 3 "$@" > /dev/null
	[ -s messages ] || complain "$1: no message"
}

full() {
	"$@" > /dev/full
}

closed() {
	"$@" >&-
}

rm -f target
printf '[sbf2csv]\ntypes = obs\n' > settings.ini
for mode in "-t obs" "-t pvt" "-s" "-f lcm" "--list" "-s -q" "-c settings.ini"; do
	refused "$mode > /dev/full" full "$sbf2csv" $mode "$log"
	refused "$mode -o /dev/full" "$sbf2csv" $mode -o /dev/full "$log"
	refused "$mode >&-" closed "$sbf2csv" $mode "$log"
	refused "$mode -o in no folder" "$sbf2csv" $mode -o nowhere/at/all "$log"
	refused "$mode of no file" "$sbf2csv" $mode nowhere.sbf
	refused "$mode of a folder" "$sbf2csv" $mode /
	refused "$mode of a good file and no file" "$sbf2csv" $mode -o target "$log" nowhere.sbf
	[ ! -e target ] || complain "$mode: a target in spite of exit 3"
done
for answer in --help --version --print-config; do
	refused "$answer > /dev/full" full "$sbf2csv" $answer
	refused "$answer >&-" closed "$sbf2csv" $answer
done
refused "--split in no folder" "$sbf2csv" --split nowhere/at/all "$log"
refused "settings in no file" "$sbf2csv" -c nowhere.ini "$log"
refused "settings in a folder" "$sbf2csv" -c / "$log"
refused "settings that cannot be read" "$sbf2csv" -c /proc/self/mem "$log"

# A full disk ends the run, even if the input never does.
for mode in "-s" "-f lcm"; do
	refused "$mode > /dev/full, endless" full timeout 20 "$sbf2csv" $mode < <("$BENCH/extend_log" "$log" 0 2> endless)
done

# Programs are also started without the standard streams. Messages must not end in the output then.
"$sbf2csv" -t obs < "$log" > want 2> messages
"$sbf2csv" -t obs -o target < "$log" 2>&-
cmp want target || complain "-o with stderr closed: other output"
"$sbf2csv" -t obs -o target "$log" <&- 2> messages
cmp want target || complain "-o with stdin closed: other output"
refused "stdin closed" "$sbf2csv" -t obs <&-
rm target
"$sbf2csv" -t obs -o target "$log" >&- 2> messages
cmp want target || complain "-o with stdout closed: other output"
exit $failed
