# --from, --until and --every in all their forms. demo.sbf is a minute: 2422:289815 to 2422:289874, 2026-06-10 08:30:15
# GPS time, which is 18 s ahead of UTC; pvt at 1 Hz, events every other second with times of their own.
. "$SRC/tests/cli/case.bash"

# stamps OPTION...: the seconds of the table of positions, first, last, number
stamps() {
	gives 0 -q "$@" "$log"
	awk -F, 'NR == 2 { first = $2 } END { print first, $2, NR - 1 }' out
}

# is "FIRST LAST ROWS" OPTION...
is() {
	local wanted=$1 got
	shift
	got=$(stamps "$@")
	[ "$got" = "$wanted" ] || complain "$*: $got, not $wanted"
}

is "289815 289874 60"
is "289830 289874 45" --from 2422:289830
is "289831 289874 44" --from 2422:289830.000000001
is "289815 289829 15" --until 2422:289830
is "289815 289830 16" --until 2422:289830.5
is "289820 289839 20" --from 2422:289820 --until 2422:289840
is "289820 289839 20" --from 2026-06-10T08:30:20 --until 2026-06-10T08:30:40
is "289820 289839 20" --from 2026-06-10T08:30:02Z --until 2026-06-10T08:30:22Z
is "289820 289839 20" --from 2026-06-10T08:30:19.25 --until 2026-06-10T08:30:21.5Z
is "289815 289874 60" --from 2421:604799 --until 2423:0

# Epochs at multiples of the interval, counted from the start of the week.
is "289820 289870 6" --every 10
is "289815 289874 60" --every 0.5
is "289815 289870 12" --every 5
is "289830 289850 3" --every 10 --from 2422:289825 --until 2422:289860

# Events are all kept, and sorted out by their own time, not by that of the block.
is "289819.031763025 289873.033882581 28" -t event --every 10
is "289821.035633648 289873.033882581 27" -t event --from 2422:289819.031763026
is "289819.031763025 289873.033882581 28" -t event --from 2422:289819.031763025

# An interval that holds nothing is no usable data.
gives 4 --from 2422:300000 "$log"
gives 4 --until 2000-01-01T00:00:00 "$log"
gives 4 --from 2422:289840 --until 2422:289820 "$log"
finish
