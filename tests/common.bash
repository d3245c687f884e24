# What the test scripts share: sourced, not run. BIN, SRC and the rest: see CMakeLists.txt.

sbf2csv=$BIN/sbf2csv
failed=0

# The real log of 748 blocks, or our own.
log=$FURROW_DATA/sbf/log_0000.sbf
[ -r "$log" ] || log=$SRC/testdata/demo.sbf

complain() {
	echo "$*"
	failed=1
}

# expect STATUS WHAT COMMAND...: runs it (stderr to `messages`) and compares the exit status.
expect() {
	local wanted=$1 what=$2 status=0
	shift 2
	"$@" 2> messages || status=$?
	[ $status = "$wanted" ] || complain "$what: exit $status, not $wanted: $(head -n 1 messages)"
}

# Commands that write into the folder out/ are judged against a first run without faults.
# reference COMMAND...: keeps what it writes, and what it prints, as want/.
reference() {
	rm -rf out want
	mkdir out
	expect 0 "reference: $*" "$@" > printed
	mv out want
	mv printed want.printed
}

# attempt WHAT COMMAND...: runs it on top of old files of the same names. It may end with 0 and the same output, or
# with 3, a message, and the old files as they were; with WHOLE set each file may be the old or the new one.
attempt() {
	local what=$1 status=0 name
	shift
	rm -rf out
	mkdir out
	for name in want/*; do
		[ -e "$name" ] && echo old > "out/${name#want/}"
	done
	"$@" > printed 2> messages || status=$?
	case $status in
	0)
		diff -r want out > /dev/null && cmp -s want.printed printed || complain "$what: exit 0, but other output"
		;;
	3)
		[ -s messages ] || complain "$what: exit 3 without a message"
		[ "$(ls -A want)" = "$(ls -A out)" ] || complain "$what: exit 3, but files came or went: $(ls -A out | tr '\n' ' ')"
		for name in out/*; do
			[ -n "${WHOLE:-}" ] && cmp -s "$name" "want/${name#out/}" && continue
			[ ! -e "$name" ] || [ "$(< "$name")" = old ] || complain "$what: exit 3, but $name has changed"
		done
		;;
	*)
		complain "$what: exit $status: $(head -n 1 messages)"
		;;
	esac
}
