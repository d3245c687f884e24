# testdata/demo.sbf is what its maker makes, and a log without a flaw, in which raw subframes and the receiver's own
# decoding tell the same orbits.
set -eu
"$TOOLS/make_demo_log" > made.sbf
cmp made.sbf "$SRC/testdata/demo.sbf"

"$BIN/sbf2csv" -s "$SRC/testdata/demo.sbf" > demo.stream 2> messages
tail -n 1 demo.stream | grep -q '^#end status=complete rows=[1-9][0-9]* skipped=0$'

for source in raw decoded; do
	"$BIN/sbf2csv" -q --nav $source -t eph_gps made.sbf | cut -d, -f 3,5- > $source
done
cmp raw decoded
[ "$(wc -l < raw)" = 6 ]
