# virtualite-ls beside RTKLIB's rnx2rtkp: epochs per second of whole processes, from the same RINEX files, same systems and
# mask, broadcast ionosphere, Saastamoinen. Best of five runs each. Fails when the ratio is below its target on any set.
set -eu
[ -d "${FURROW_DATA:-none}" ] || { echo "skipped: no real data"; exit 77; }
command -v rnx2rtkp > /dev/null || { echo "skipped: no rnx2rtkp"; exit 77; }
PYTHONDONTWRITEBYTECODE=1 python3 "$SRC/tests/bench/single_point_peers.py"
