# testdata/demo.sbf is what its maker makes, and a log without a flaw.
set -eu
"$TOOLS/make_demo_log" > made.sbf
cmp made.sbf "$SRC/testdata/demo.sbf"

"$BIN/sbf2csv" -s "$SRC/testdata/demo.sbf" > demo.stream 2> messages
tail -n 1 demo.stream | grep -q '^#end status=complete rows=[1-9][0-9]* skipped=0$'
