# virtualite-ls: the standard deviations that it states are honest. Errors of orbits, clocks and atmosphere stay for hours,
# so one simulated log is one draw of them: it takes many short ones, of different seeds and hours of the day. Of the
# errors in north, east and down 68 % have to be inside one sigma and 95 % inside two, within 10 points and 5.
. "$SRC/tests/cli/case.bash"
[ "$SANITIZE" != ON ] || { echo "skipped: many runs, and the other builds do them"; exit 77; }

row() { # scenario
	for seed in $(seq 120); do
		printf -v start '2026-06-10T%02d:%02d:00' $((seed * 7 % 24)) $((seed * 13 % 60))
		"$BIN/gnss-sim" -q "$SRC/testdata/scenarios/$1.ini" -o "$1" --seed "$seed" --set "scenario.start=$start" \
			--set scenario.duration_s=5 --set gnss.rate_hz=1 --set base.present=no --set 'gnss.lever_m=0 0 0'
		"$BIN/virtualite-ls" -q -o "$1/pos.csv" "$1/rover.sbf"
		"$BIN/nav-eval" -q -f csv --truth "$1/truth.csv" "$1/pos.csv"
	done | awk -F , -v name="$1" '
		$5 ~ /^(north|east|down)_m$/ { n[$5] += $6; one[$5] += $6 * $16 / 100; two[$5] += $6 * $17 / 100 }
		END {
			for (axis in n) {
				a = 100 * one[axis] / n[axis]
				b = 100 * two[axis] / n[axis]
				printf "%-12s %-8s %5d positions, %5.1f %% inside 1 sigma, %5.1f %% inside 2\n", name, axis, n[axis], a, b
				dishonest += !(a >= 58 && a <= 78 && b >= 90)
			}
			exit dishonest > 0
		}'
}

for scenario in farm cart hnu fieldcopter csac-open; do
	row $scenario || complain "$scenario: the standard deviations are not honest"
done
finish
