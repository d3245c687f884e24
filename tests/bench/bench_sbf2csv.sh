# sbf2csv beside RTKLIB's convbin and pysbf2, whole processes, on a log of 500 MB that is made here and removed again.
# The result is printed and left in sbf2csv.json, in the working directory. Fails when a ratio is below its target.
set -eu
log=${FURROW_DATA:-none}/sbf/log_0000.sbf
[ -r "$log" ] || log=$SRC/testdata/demo.sbf

trap 'rm -f long.sbf slice.sbf convbin.obs' EXIT
trap 'exit 1' HUP INT TERM
"$BENCH/extend_log" "$log" "${MEGABYTES:-500}" > long.sbf
"$BENCH/extend_log" "$log" 2 > slice.sbf

echo "log: $(basename "$log") again and again, with advancing time"
PYTHONDONTWRITEBYTECODE=1 python3 "$SRC/tests/bench/sbf2csv_peers.py" long.sbf slice.sbf
