# The filter alone, 15 states at 200 Hz, covariance at the IMU's rate: microseconds and instructions per sample, and smoothing as a
# multiple of it. Fails beyond 2 us or beyond three times the forward filter.
set -eu
steps=$BENCH/filter_steps
best() { # of five runs, field $1
	for run in 1 2 3 4 5; do "$steps" 400000 $2; done | sort -k"$1" -g | head -1
}
set -- $(best 2 "")
us=$(awk "BEGIN { print $2 * 1e6 / $1 }")
set -- $(best 2 smooth)
ratio=$(awk "BEGIN { print ($2 + $3) / ($us * $1 * 1e-6) }")
printf 'filter: %.2f us per sample (limit 2); forward with nodes and smoothing %.2f times that (limit 4)\n' "$us" "$ratio"
if command -v valgrind >/dev/null; then
	count() { valgrind --tool=callgrind --callgrind-out-file=/dev/null "$steps" "$1" 2>&1 | sed -n 's/.*Collected : //p'; }
	few=$(count 2000) many=$(count 12000)
	echo "filter: $(((many - few) / 10000)) instructions per sample (callgrind)"
else
	echo "filter: no valgrind, instructions not counted"
fi
awk "BEGIN { exit !($us < 2 && $ratio < 4) }"
