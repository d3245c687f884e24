# For scripts that look at what the tool prints and says: . "$SRC/tests/cli/case.bash", end with `finish`.
set -u
. "$SRC/tests/common.bash"
log=$SRC/testdata/demo.sbf
rm -rf case && mkdir case && cd case || exit 1

# gives STATUS ARGUMENT...: runs sbf2csv; its output is in the file out, its messages in err.
gives() {
	local wanted=$1 status=0
	shift
	"$sbf2csv" "$@" > out 2> err || status=$?
	[ $status = "$wanted" ] || complain "exit $status, not $wanted: sbf2csv $*: $(cat err)"
}

# says TEXT: the messages of the last run hold the text. prints TEXT: its output does.
says() { grep -qF -- "$1" err || complain "no '$1' in the messages: $(cat err)"; }
prints() { grep -qF -- "$1" out || complain "no '$1' in the output: $(head out)"; }

# rows N: the output is a table of N rows.
rows() {
	local n=$(($(wc -l < out) - 1))
	[ $n = "$1" ] || complain "$n rows, not $1"
}

silent() { [ ! -s err ] || complain "messages where none should be: $(cat err)"; }
no_output() { [ ! -s out ] || complain "output where none should be: $(head out)"; }
same() { cmp "$1" "$2" || complain "$1 and $2 differ"; }
finish() { exit $failed; }
