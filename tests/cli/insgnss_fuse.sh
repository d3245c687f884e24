# insgnss-fuse: a short survey flight of the simulator, whole and damaged, forwards and smoothed, alone and in a pipeline.
. "$SRC/tests/cli/case.bash"
sbf2csv=$BIN/insgnss-fuse # what `gives` runs

cat > survey.ini <<'EOF'
[trajectory]
waypoint = 0 0 0 1 20
waypoint = 0 0 30 2
waypoint = 100 0 30 5
waypoint = 100 50 30 5
waypoint = 0 50 30 5 10
[imu]
gyro_misalignment_mrad = 0
accel_misalignment_mrad = 0
[magnetometer]
hard_iron_ut = 4 -3 2
soft_iron = 0.05 0 0 0 -0.03 0 0 0 0
[attitude]
baseline_m = -1 0 0
[pvt]
mode = sbas
section_s = 1000
horizontal_m2 = 1
vertical_m2 = 2
horizontal_m2ps2 = 0.01
vertical_m2ps2 = 0.02
[camera]
interval_s = 2
EOF
"$BIN/gnss-sim" -q survey.ini -o survey || exit 1
rover=survey/rover.sbf imu=survey/imu.csv
first=$(sed -n 2p $imu | cut -d, -f2) # of 10008 samples at 100 Hz

# rms NAME FILE: root mean square of an error. at_most LIMIT NAME FILE
rms() { "$BIN/nav-eval" -q -f csv --truth survey/truth.csv "$2" | awk -F, -v name="$1" '$5 == name && $2 == "all" { print $9 }'; }
at_most() {
	awk -v got="$(rms "$2" "$3")" -v limit="$1" 'BEGIN { exit !(got != "" && got + 0 <= limit) }' || complain "$3: $2 $(rms "$2" "$3"), not at most $1"
}
whole() { ! grep -qiE 'nan|inf' "$1" || complain "$1: not a number in it"; }

# Forwards: white errors of a metre and 0.1 m/s become these.
gives 0 -o nav.csv --imu $imu $rover
says "begins, heading"
says "10008 IMU samples, 501 fixes, 501 headings used; 0 gaps bridged; 10008 rows"
at_most 0.45 horizontal_m nav.csv
at_most 0.06 velocity_mps nav.csv
at_most 0.25 attitude_deg nav.csv
whole nav.csv
[ "$(cut -d, -f25 nav.csv | sort | uniq -c | awk '{ print $2 }' | tr '\n' ' ')" = "fused status still " ] || complain "status: $(cut -d, -f25 nav.csv | sort | uniq -c)"

# Smoothed: better, in memory as well as in a file.
gives 0 --smooth rts -o smooth.csv --imu $imu $rover
says "smoothing took"
at_most 0.25 horizontal_m smooth.csv
at_most 0.03 velocity_mps smooth.csv
at_most 0.2 attitude_deg smooth.csv
whole smooth.csv
gives 0 -q --smooth rts --memory 1 -o in_file.csv --imu $imu $rover
silent
same smooth.csv in_file.csv
TMPDIR=/nowhere gives 3 --smooth rts --memory 1 -o in_file.csv --imu $imu $rover
says "smoothing: No such file or directory"
same smooth.csv in_file.csv

# The order of the files, and how they come, make no difference.
gives 0 -q -o other.csv $imu $rover
same nav.csv other.csv
gives 0 -q -o other.csv - --imu $imu < $rover
same nav.csv other.csv
gives 0 -q -o other.csv $rover < /dev/null --imu <(cat $imu)
same nav.csv other.csv

# Rows: at a rate, at events, in a window, as LCM.
gives 0 -q --rate 10 --imu $imu $rover
[ "$(cut -d, -f2 out | sed -n 3,5p | tr "\n" " ")" = "288000.1 288000.2 288000.3 " ] || complain "rate: $(head -n 5 out)"
events=$("$BIN/sbf2csv" -q -t event $rover | tail -n +2 | wc -l)
gives 0 -q --rate events --imu $imu $rover
rows "$events"
gives 0 -q --rate imu --until 2422:288010 --from 2422:288009 --imu $imu $rover
rows 100
gives 0 -q -f lcm -o nav.lcm --imu $imu $rover
"$BIN/sbf2csv" -q -t nav nav.lcm > other.csv
same nav.csv other.csv

# In a pipeline: everything is passed on, levels are put beside the solution.
"$BIN/sbf2csv" -q -s $rover | "$BIN/pl-monitor" -q -s --hal 40 --val 50 | "$BIN/insgnss-fuse" -s -q --imu $imu > stream || complain "pipeline: exit $?"
for type in obs pvt att event pl nav; do
	grep -q "^$type," stream || complain "no $type in the stream"
done
tail -n 1 stream | grep -q '^#end status=complete' || complain "end: $(tail -n 1 stream)"
[ "$("$BIN/sbf2csv" -q -t nav stream | awk -F, 'NR == 5000 { print ($21 > 0) }')" = 1 ] || complain "no protection level in nav"
"$BIN/sbf2csv" -q -t nav stream > piped.csv
"$BIN/nav-eval" -q -f csv --truth nav.csv piped.csv | awk -F, '$5 == "position_m" && $2 == "all" { exit !($9 < 1e-3) }' || complain "another solution through the pipeline"

# Fixes and headings withheld: it coasts, and drifts.
gives 0 -v --withhold 40:15:30 -o coast.csv --imu $imu $rover
says "withheld"
grep -q ',coasting$' coast.csv || complain "no coasting"
at_most 10 horizontal_m coast.csv

# A gap that is too long: a new run begins, with the motion of the rest.
awk -F, -v t="$first" 'NR == 1 || $2 < t + 30 || $2 > t + 60' $imu > gap.csv
gives 1 -o with_gap.csv --imu gap.csv $rover
says "1 gaps of the IMU, each followed by a new beginning"
at_most 0.6 horizontal_m with_gap.csv
gives 1 -s --imu gap.csv $rover
[ "$(grep -c '^#gap from=' out)" = 1 ] || complain "no #gap"
gives 1 --smooth rts -o with_gap.csv --imu gap.csv $rover
at_most 0.5 horizontal_m with_gap.csv

# A short one is bridged.
awk -F, -v t="$first" 'NR == 1 || $2 < t + 50 || $2 > t + 50.2' $imu > short.csv
gives 0 -o bridged.csv --imu short.csv $rover
says "1 gaps bridged"
at_most 0.45 horizontal_m bridged.csv

# Samples that are no use are refused and counted; the solution stays what it was.
awk -F, -v OFS=, -v t="$first" 'NR == 3000 { print; print; next } NR == 4000 { $3 = 1e30 } NR == 5000 { $6 = "" } NR == 6000 { $2 -= 5 } { print }' $imu > bad.csv
gives 1 -o refused.csv --imu bad.csv $rover
says "refused:"
says "1 IMU samples duplicate time"
says "1 IMU samples out of range"
says "1 IMU samples not finite"
says "1 IMU samples back in time"
at_most 0.45 horizontal_m refused.csv
whole refused.csv

# Fixes far off, and fixes without a sigma that can be.
"$BIN/sbf2csv" -q -t pvt $rover | awk -F, -v OFS=, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i } NR == 200 { $at["lat_deg"] += 1 } NR == 300 { $at["cov_nn_m2"] = -1 } NR == 400 { $at["cov_nn_m2"] = $at["cov_ee_m2"] = $at["cov_dd_m2"] = 0 } { print }' > pvt.csv
gives 1 -o outlier.csv --imu $imu pvt.csv
says "1 fixes out of range"
says "2 fixes no valid sigma"
at_most 0.6 horizontal_m outlier.csv

# What is cut short, damaged or missing.
head -c 300000 $rover > cut.sbf
gives 1 -o cut.csv --imu $imu cut.sbf
says "the log ends inside a block"
gives 4 $rover
says "no solution: no IMU sample"
rows 0
gives 4 $imu
says "no solution: no position"
gives 4 --imu $imu < /dev/null
gives 3 --imu missing.csv $rover
gives 3 --imu $imu missing.sbf
gives 3 -o /dev/full --imu $imu $rover
echo old > kept.csv
gives 4 -o kept.csv $rover
[ "$(cat kept.csv)" = old ] || complain "kept.csv was touched"

# Without the second antenna: heading from the motion, and from the user.
"$BIN/sbf2csv" -q -t pvt $rover > pvt.csv
gives 0 -o moving.csv --imu $imu pvt.csv
says "(motion)"
at_most 0.5 horizontal_m moving.csv
gives 0 -o given.csv --align given --heading 359 --imu $imu pvt.csv
says "(given heading)"
at_most 0.5 horizontal_m given.csv

# The compass: its iron is found from the log; the numbers that are printed do the same.
gives 0 -o compass.csv --compass yes --compass-calibration log --mag survey/mag.csv --imu $imu pvt.csv
says "compass calibrated to"
numbers=$(sed -n 's/.*compass calibrated to [^:]*: //p' err)
echo "$numbers" | awk -F, '{ exit !(NF == 12 && sqrt(($1 - 4) ^ 2 + ($2 + 3) ^ 2) < 1 && $4 > 0.93 && $4 < 0.98) }' || complain "calibration: $numbers"
at_most 0.3 heading_deg compass.csv
gives 0 -o again.csv --compass yes --compass-calibration "$numbers" --align magnetic --mag survey/mag.csv --imu $imu pvt.csv
says "(compass)"
at_most 0.5 heading_deg again.csv
gives 0 -o turned.csv --compass yes --compass-calibration turning --mag survey/mag.csv --imu $imu $rover
says "compass not calibrated: the motion shows too little"

# Usage.
refused() {
	local message=$1
	shift
	gives 2 "$@"
	says "insgnss-fuse: $message"
	no_output
}
refused "--align given needs --heading DEG" --align given $rover
refused "--withhold: '10' is not EVERY:LENGTH[:FIRST]" --withhold 10 $rover
refused "--withhold: '10:20' is not EVERY:LENGTH[:FIRST]" --withhold 10:20 $rover
refused "--rate: 'often' is neither imu nor events" --rate often $rover
refused "--imu-columns:" --imu-columns "gx=banana" $rover
refused "standard input can be one file only" --imu - - < $imu
refused "unknown option or key 'lever'; did you mean 'lever-x'?" --lever 1 $rover
refused "--compass-calibration: 'iron' is neither none, turning nor log" --compass-calibration iron $rover
refused "--compass-calibration: '1,2,3' is neither" --compass-calibration 1,2,3 $rover
refused "--compass-calibration log reads files twice: a pipe cannot be" --compass-calibration log - --imu $imu < $rover
refused "--gap: '0' is not a number" --gap 0 $rover

# A few MiB, however long the log.
if [ "${SANITIZE:-}" != ON ]; then
	"$TOOLS/peak" peak "$BIN/insgnss-fuse" -q -o other.csv --imu $imu $rover
	[ "$(cat peak)" -le 32768 ] || complain "$(cat peak) KiB"
fi
finish
