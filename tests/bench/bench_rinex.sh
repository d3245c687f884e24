# RINEX observations, read whole, beside a plain wc -l of the same text. Fails below 100 MB/s.
set -eu
real=${FURROW_DATA:-none}/rtk/mosaic_static/base.obs
trap 'rm -rf rinex_made obs.rnx obs.rnx.gz obs.crx found' EXIT
if [ -r "$real" ]; then
	cp "$real" one.rnx
else
	"$BIN/sbf2csv" -q -f rinex --split rinex_made "$SRC/testdata/demo.sbf"
	mv rinex_made/obs.rnx one.rnx
fi
size=$(wc -c < one.rnx)
for ((i = ${MEGABYTES:-100} * 1000000 / size; i >= 0; i--)); do
	cat one.rnx
done > obs.rnx
gzip -1 -k obs.rnx
"$PYTHON" -c 'import sys, hatanaka; sys.stdout.buffer.write(hatanaka.rnx2crx(sys.stdin.buffer.read()))' < one.rnx > one.crx 2> found || true
[ -s one.crx ] && cp one.crx obs.crx
rm -f one.rnx one.crx

wc -l obs.rnx > found # once, so that all is in memory
begin=${EPOCHREALTIME/./}
wc -l obs.rnx > found
took=$((${EPOCHREALTIME/./} - begin))
printf '%-10s %8.1f MB/s\n' "wc -l" "$(($(wc -c < obs.rnx) * 10 / took))e-1"
"$BENCH/read_rinex" obs.rnx obs.rnx.gz $([ -s obs.crx ] && echo obs.crx) | tee found
awk '$1 == "obs.rnx" && $2 < 100 { exit 1 }' found || { echo "obs.rnx: below 100 MB/s"; exit 1; }
