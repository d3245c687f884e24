#!/bin/sh
# What sbf2csv makes of a receiver log.
#   scripts/demo.sh [LOG]     without LOG: testdata/demo.sbf
# Tables go to demo/, one file per record type.
set -eu
cd "$(dirname "$0")/.."
sbf2csv=build/release/bin/sbf2csv
log=${1:-testdata/demo.sbf}

if [ ! -r "$log" ]; then
	echo "demo: cannot read $log" >&2
	exit 3
fi

# Exit 1 is "done, but something in the log was skipped": worth a look, no reason to stop.
run() {
	"$sbf2csv" "$@" || [ $? = 1 ]
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

rm -rf demo
mkdir demo
run --split demo "$log"

title "What $log holds: sbf2csv --list $log"
run -q --list "$log" | align

title "The receiver's own solution: sbf2csv -t pvt $log"
show pvt 5 gps_week,tow_s,mode,lat_deg,lon_deg,height_m,vn_mps,ve_mps,n_sats,sd_n_m,sd_e_m,sd_d_m

title "Its measurements: sbf2csv -t obs $log"
show obs 8 gps_week,tow_s,sat,signal,pseudorange_m,carrier_cyc,doppler_hz,cn0_dbhz,lock_s

title "Every record type as a table: sbf2csv --split demo $log"
wc -l demo/*.csv | awk '$2 != "total" { printf "  %-32s %7d rows\n", $2, $1 - 1 }'
printf '\nOpen them with QGIS, pandas, R or a spreadsheet. Manual: man man/sbf2csv.1\n'
