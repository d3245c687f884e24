# insgnss-fuse on an hour of IMU at 200 Hz and GNSS at 5 Hz, tables in and out, whole process: time and memory, forwards and
# smoothed. Fails when the best of three forward runs takes more than 6 s or 32 MiB.
set -eu
trap 'rm -rf hour hour.ini hour.csv hour.kib' EXIT
cat >hour.ini <<'END'
[scenario]
duration_s = 3600
[trajectory]
vehicle = ground
rows = 0 0 0 0 400 20 100 6 4
[imu]
rate_hz = 200
[gnss]
signals = G1C E1C
[sky]
systems = GPS Galileo
[base]
present = no
END
"$BIN/gnss-sim" -q hour.ini -o hour
"$BIN/sbf2csv" -q -t pvt -o hour/pvt.csv hour/rover.sbf
# measure OPTION...: seconds and KiB of the best of three runs
measure() {
	for run in 1 2 3; do
		begin=$(date +%s%N)
		"$TOOLS/peak" hour.kib "$BIN/insgnss-fuse" -q "$@" --imu hour/imu.csv -o hour.csv hour/pvt.csv || [ $? = 1 ]
		echo "$(($(date +%s%N) - begin)) $(cat hour.kib)"
	done | sort -n | head -1
}
set -- $(measure)
forward_ms=$(($1 / 1000000)) forward_kib=$2
set -- $(measure --smooth rts)
echo "insgnss-fuse, an hour at 200 Hz: $forward_ms ms, $forward_kib KiB (limits 6000, 32768); smoothed $(($1 / 1000000)) ms, $2 KiB"
[ "$forward_ms" -le 6000 ] && [ "$forward_kib" -le 32768 ]
