#!/bin/sh
# A simulated survey flight, flown, solved and judged; or a log of yours as tables.
#   scripts/demo.sh          testdata/scenarios/farm.ini: logs, trajectory and report go to demo/
#   scripts/demo.sh LOG      what sbf2csv makes of a receiver log: one table for each record type in demo/
set -eu
cd "$(dirname "$0")/.."
PATH=$PWD/build/release/bin:$PATH

# Exit 1 is "done, but something in the log was skipped": worth a look, no reason to stop.
run() {
	"$@" || [ $? = 1 ]
}

# align [COLUMN,...] < table: columns side by side for reading, only those named if any are.
align() {
	awk -F, -v names="${1:-}" '
	NR == 1 {
		for (i = 1; i <= NF; i++)
			at[$i] = i
		n = split(names, wanted, ",")
		for (i = 1; i <= n; i++)
			if (wanted[i] in at)
				use[++m] = at[wanted[i]]
		for (i = 1; n == 0 && i <= NF; i++)
			use[++m] = i
	}
	{
		for (i = 1; i <= m; i++) {
			cell[NR, i] = $(use[i])
			if (length($(use[i])) > width[i])
				width[i] = length($(use[i]))
		}
	}
	END {
		for (row = 1; row <= NR; row++) {
			line = " "
			for (i = 1; i <= m; i++)
				line = line sprintf(" %" width[i] "s", cell[row, i])
			print line
		}
	}'
}

title() {
	printf '\n\033[1m%s\033[0m\n' "$1"
}

# show TYPE ROWS COLUMN,...: the beginning of a table, if the log has that type.
show() {
	if [ -e "demo/$1.csv" ]; then
		head -n $(($2 + 1)) "demo/$1.csv" | align "$3"
	else
		echo "  (none in this log)"
	fi
}

# ---- a log of yours ----

tables() {
	log=$1
	if [ ! -r "$log" ]; then
		echo "demo: cannot read $log" >&2
		exit 3
	fi
	run sbf2csv --split demo "$log"

	title "What $log holds: sbf2csv --list $log"
	run sbf2csv -q --list "$log" | align

	title "The receiver's own solution: sbf2csv -t pvt $log"
	show pvt 5 gps_week,tow_s,mode,lat_deg,lon_deg,height_m,vn_mps,ve_mps,n_sats,sd_n_m,sd_e_m,sd_d_m

	title "Its measurements: sbf2csv -t obs $log"
	show obs 8 gps_week,tow_s,sat,signal,pseudorange_m,carrier_cyc,doppler_hz,cn0_dbhz,lock_s

	title "Every record type as a table: sbf2csv --split demo $log"
	wc -l demo/*.csv | awk '$2 != "total" { printf "  %-32s %7d rows\n", $2, $1 - 1 }'
	printf '\nOpen them with QGIS, pandas, R or a spreadsheet. Manual: man man/sbf2csv.1\n'
}

# ---- the flight ----

# say COMMAND: prints it, then runs it.
say() {
	printf '  $ %s\n' "$1"
	run sh -c "$1"
}

flight() {
	title "A quarter of an hour over a field: receiver, IMU, base station, camera, and the truth"
	say "gnss-sim -q testdata/scenarios/farm.ini -o demo"

	title "How far can the position be trusted, and where was the drone, by all of the log?"
	solve="insgnss-fuse -q --adapt gm --imu demo/imu.csv --lever-x 0.05 --lever-z -0.2"
	say "sbf2csv -q -s demo/rover.sbf | pl-monitor -s | tee demo/monitored.stream | $solve --smooth rts -o demo/nav.csv"

	title "The same forwards only, and at the moments of the pictures"
	say "$solve -o demo/forward.csv demo/monitored.stream"
	say "$solve --smooth rts --rate events -o demo/camera.csv demo/monitored.stream"
	run sbf2csv -q -t pvt -o demo/receiver.csv demo/rover.sbf

	title "Against the truth"
	say "nav-eval -q --truth demo/truth.csv --levels demo/monitored.stream --html demo/report.html demo/nav.csv >demo/report.txt"
	nav-eval -q -f csv --truth demo/truth.csv demo/receiver.csv demo/forward.csv demo/nav.csv demo/camera.csv | closing
	pages
}

# What is left to say: the errors of each solution, from nav-eval's table.
closing() {
	awk -F, '
	BEGIN {
		name["demo/receiver.csv"] = "the receiver alone"
		name["demo/forward.csv"] = "with the IMU, forwards"
		name["demo/nav.csv"] = "with the IMU, smoothed"
		name["demo/camera.csv"] = "smoothed, at the camera"
		printf "  %-26s %10s %10s %12s %10s %10s\n", "", "horizontal", "vertical", "velocity", "tilt", "heading"
		printf "  %-26s %10s %10s %12s %10s %10s\n", "errors", "95 % [m]", "95 % [m]", "RMS [mm/s]", "RMS [deg]", "RMS [deg]"
	}
	NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
	!($1 in name) { next }
	!($1 in seen) { seen[$1] = ++n; order[n] = $1 }
	{ p95[$1, $(at["quantity"])] = $(at["p95"]); rms[$1, $(at["quantity"])] = $(at["rms"]) }
	END {
		for (i = 1; i <= n; i++) {
			s = order[i]
			tilt = rms[s, "roll_deg"] == "" ? "" : sprintf("%.3f", sqrt((rms[s, "roll_deg"] ^ 2 + rms[s, "pitch_deg"] ^ 2) / 2))
			heading = rms[s, "heading_deg"] == "" ? "" : sprintf("%.3f", rms[s, "heading_deg"])
			printf "  %-26s %10.2f %10.2f %12.1f %10s %10s\n", name[s], p95[s, "horizontal_m"], p95[s, "down_m"],
			    1000 * rms[s, "velocity_mps"], tilt, heading
		}
	}'
}

pages() {
	printf '\n  trajectory   demo/nav.csv, poses of the pictures demo/camera.csv\n  judgement    demo/report.html\n'
	if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] && command -v xdg-open >/dev/null; then
		xdg-open demo/report.html >/dev/null 2>&1 &
	else
		printf '               (open it in a browser)\n'
	fi
	printf '\nmake demo LOG=flight.sbf takes a log of yours. A tour: man man/furrow.7\n'
}

rm -rf demo
mkdir demo
if [ $# -gt 0 ]; then
	tables "$1"
else
	flight
fi
