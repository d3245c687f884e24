# gnss-sim: same seed, same bytes; other seed, other bytes; every scenario runs; wrong scenarios are refused by file and line.
. "$SRC/tests/cli/case.bash"
sim=$BIN/gnss-sim
scenarios=$SRC/testdata/scenarios

# simulates STATUS ARGUMENT...: runs gnss-sim; what it says is in the file err.
simulates() {
	local wanted=$1 status=0
	shift
	"$sim" "$@" > out 2> err || status=$?
	[ $status = "$wanted" ] || complain "exit $status, not $wanted: gnss-sim $*: $(head -n 3 err)"
}

# hash FOLDER: one number for all files in it.
hash() { (cd "$1" && find . -type f | sort | xargs sha256sum) | sha256sum; }

# ---- every scenario, shortened to where things happen ----

for scenario in "$scenarios"/*.ini; do
	name=$(basename "$scenario" .ini)
	simulates 0 "$scenario" -o "$name" --set scenario.duration_s=20 --truth-rate 10
	for file in rover.sbf imu.csv truth.csv; do
		[ -s "$name/$file" ] || complain "$name: no $file"
	done
	"$sbf2csv" -q -t pvt "$name/rover.sbf" > pvt.csv || complain "$name: no positions"
	grep -q "$name: 20 s" err || complain "$name: $(cat err)"
	simulates 0 "$scenario" --print-config
	cp out "$name.full"
	simulates 0 "$name.full" --print-config
	same out "$name.full"
done

# Every key has its place in the manual, in the same order: the file has one mask and one fault to show theirs.
printf '[trajectory]\nwaypoint = 0 0 0 1 9\nplace = 52.05 11.45 120\nrows = 9 0 0 0 50 9 4 2 1\n' > keys.ini
printf '[mask a]\nkeep = 1\n[fault a]\nsize_m = 1\n' >> keys.ini
simulates 0 keys.ini --print-config
sed -nE 's/^\[([a-z]+).*/[\1]/p; s/^([a-z0-9_]+) =.*/\1/p' out > printed
sed -nE '/^\.Sh THE SCENARIO/,/^\.Ss Types/ {s/^\.Ss \[([a-z]+).*/[\1]/p; s/^\.It Cm ([a-z0-9_]+)$/\1/p}' "$SRC/man/gnss-sim.1" > manual
diff printed manual > /dev/null || complain "the manual's keys differ: $(diff printed manual)"

# ---- bytes ----

simulates 0 "$scenarios/farm.ini" -o again --set scenario.duration_s=20 --truth-rate 10
[ "$(hash farm)" = "$(hash again)" ] || complain "the same seed gives other bytes"
for file in rover.sbf base.sbf imu.csv mag.csv baro.csv; do
	simulates 0 "$scenarios/farm.ini" -o other --set scenario.duration_s=20 --truth-rate 10 --seed 2
	cmp -s farm/$file other/$file && complain "another seed gives the same $file"
done
same farm/truth.csv other/truth.csv
simulates 0 "$scenarios/farm.ini" -o other --set scenario.duration_s=20 --truth-rate 10 --set scenario.seed=1
[ "$(hash farm)" = "$(hash other)" ] || complain "--set scenario.seed is not --seed"

# The sky does not depend on how often it is looked at: satellites' errors are those of the slower receiver.
simulates 0 "$scenarios/farm.ini" -o slow --set scenario.duration_s=20 --set gnss.rate_hz=1
same farm/imu.csv slow/imu.csv

# ---- RINEX beside SBF ----

simulates 0 "$scenarios/farm.ini" -o rinex --set scenario.duration_s=5 --rinex
for file in rover/obs.rnx rover/nav.rnx base/obs.rnx base/nav.rnx; do
	[ -s rinex/$file ] || complain "no $file"
done

# ---- defaults: an IMU of which nothing is said is an industrial one; single keys change single errors ----

printf '[trajectory]\nwaypoint = 0 0 0 1 5\n' > still.ini
simulates 0 still.ini -o plain
simulates 0 still.ini -o industrial --set imu.grade=industrial
same plain/imu.csv industrial/imu.csv
simulates 0 still.ini -o perfect --set imu.grade=perfect
cmp -s plain/imu.csv perfect/imu.csv && complain "the IMU is perfect by default"
simulates 0 still.ini --print-config --set imu.gyro_bias_degph=0
prints "gyro_bias_degph = 0"
prints "gyro_noise_degprth = 0.15"

# ---- someone else's motion, someone else's sky ----

simulates 0 "$scenarios/farm.ini" -o first --set scenario.duration_s=60 --truth-rate 20
cat > table.ini <<-END
	[trajectory]
	table = first/truth.csv
	[sky]
	nav_file = first/rover.sbf
	systems = GPS Galileo
	[base]
	present = no
END
simulates 0 table.ini -o second
head -n 1200 first/truth.csv | tail -n 1 | cut -d, -f3-11 > a
time=$(head -n 1200 first/truth.csv | tail -n 1 | cut -d, -f2)
awk -F, -v t="$time" '$2 == t' second/truth.csv | cut -d, -f3-11 > b
paste -d, a b | awk -F, 'END {if (NR != 1) exit 1; for (i = 1; i <= 9; i++) {d = $i - $(i + 9); if (d > 0.01 || d < -0.01) exit 1}}' ||
	complain "a table's motion comes out as another: $(paste a b)"
"$sbf2csv" -q -t eph_gps second/rover.sbf | cut -d, -f3,6-20 | sort > c
"$sbf2csv" -q -t eph_gps first/rover.sbf | cut -d, -f3,6-20 | sort > d
[ "$(comm -12 c d | wc -l)" -ge 6 ] || complain "the navigation file's ephemerides are not in the log"
simulates 0 table.ini -o third --set sky.nav_file=rinex/rover/nav.rnx
rounded() { "$sbf2csv" -q -t eph_gps "$1" | awk -F, 'NR > 1 {printf "%s %.6f %.8f %.8f\n", $3, $6, $7, $8}' | sort; }
rounded first/rover.sbf > c
rounded third/rover.sbf > d
[ "$(comm -12 c d | wc -l)" -ge 6 ] || complain "RINEX's ephemerides are not in the log"

# ---- options ----

simulates 2
says "one scenario file is wanted"
simulates 2 "$scenarios/farm.ini"
says "-o DIR is needed"
simulates 3 missing.ini -o x
says "missing.ini: No such file"
simulates 3 "$scenarios/farm.ini" -o no/such/folder
says "no/such/folder: No such file"
simulates 2 "$scenarios/farm.ini" -o x --sed 3
says "unknown option or key 'sed'; did you mean 'seed'?"
simulates 2 "$scenarios/farm.ini" -o x --set rate_hz=3
says "--set: 'rate_hz=3' is not SECTION.KEY=VALUE"
simulates 2 "$scenarios/farm.ini" -o x --set gnss.rate=3
says "--set: [gnss] has no key 'rate'; did you mean 'rate_hz'?"
simulates 2 "$scenarios/farm.ini" -o x --set gnss.rate_hz=3
says "[gnss] rate_hz: 3 epochs per second are not a whole number of milliseconds apart"
simulates 2 "$scenarios/farm.ini" -o x --set "gnss.signals=G1C X9Z"
says "[gnss] signals: no signal 'X9Z' is simulated"
simulates 2 "$scenarios/farm.ini" -o x --set "sky.systems=GPS Beidou"
says "[sky] systems: 'Beidou' is not one of GPS Galileo BeiDou GLONASS"
simulates 2 "$scenarios/farm.ini" -o x --set "pvt.vertical_m2=1 2"
says "must be lists of the same length"
simulates 4 "$scenarios/farm.ini" -o x --set scenario.start=2020-01-01T00:00:00 --set "sky.nav_file=$PWD/first/rover.sbf"
says "no ephemerides for the time of the scenario"
[ ! -e x ] || complain "a refused run left a folder behind"

# ---- scenarios with something wrong in line 3 ----

# refused MESSAGE LINE: a file whose third line this is.
refused() {
	printf '[trajectory]\nwaypoint = 0 0 0 1 9\n%s\n[gnss]\nrate_hz = 5\n' "$2" > bad.ini
	simulates 2 bad.ini -o x
	says "gnss-sim: bad.ini:3: $1"
	[ "$(wc -l < err)" = 1 ] || complain "more than one line of message: $2: $(cat err)"
}
refused "[trajectory] has no key 'vehicel'; did you mean 'vehicle'?" "vehicel = plane"
refused "vehicle: 'boat' is not one of ground|plane|multirotor" "vehicle = boat"
refused "latitude_deg: '91' is not a number from -85 to 85" "latitude_deg = 91"
refused "latitude_deg: 'nan' is not" "latitude_deg = nan"
refused "height_m: '12m' is not 1 number" "height_m = 12m"
refused "waypoint: '1 2' is not NORTH EAST UP [SPEED [STAY]]" "waypoint = 1 2"
refused "rows: '1 2 3' is not NORTH EAST UP HEADING LENGTH SPACING COUNT SPEED TURN_SPEED" "rows = 1 2 3"
refused "no way to this waypoint" "waypoint = 100 0 0 -5"
refused "not a section, key = value, or comment" "what is this"
printf '[trajectory]\nwaypoint = 0 0 0 1 9\n[gns]\nrate_hz = 1\n' > bad.ini
simulates 2 bad.ini -o x
says "bad.ini:4: unknown section [gns]; did you mean [gnss]?"
printf '[scenario]\n[mask]\nkeep = 2\n' > bad.ini
simulates 2 bad.ini -o x
says "bad.ini:3: [mask] needs a name, as in [mask trees]"
printf 'seed = 3\n' > bad.ini
simulates 2 bad.ini -o x
says "bad.ini:1: 'seed' stands before any [section]"
printf '[trajectory]\nwaypoint = 0 0 0 1 9\n[fault a]\nfrom_s = 9\nuntil_s = 3\n' > bad.ini
simulates 2 bad.ini -o x
says "bad.ini:4: [fault a] ends (until_s) before it begins (from_s)"
printf '[mask a]\nsatellites = G05 Q7\n' > bad.ini
simulates 2 bad.ini -o x
says "bad.ini:2: satellites: 'G05 Q7' is not all, or letters and numbers as in G E05"
printf '[scenario]\nseed = 1\n' > bad.ini
simulates 2 bad.ini -o x
says "no waypoint, place, rows or table"
printf '[trajectory]\n# %0300d\nwaypoint = 0 0 0 1 9\n' 0 > bad.ini
simulates 2 bad.ini -o x
says "bad.ini:2: a line longer than"
printf '[trajectory]\ntable = nothing.csv\n' > bad.ini
simulates 3 bad.ini -o x
says "nothing.csv: No such file"
printf 'gps_week,tow_s,lat_deg\n2422,1,52\n' > few.csv
printf '[trajectory]\ntable = few.csv\n' > bad.ini
simulates 2 bad.ini -o x
[ ! -e x ] || complain "a refused scenario left a folder behind"

# ---- cut and damaged scenarios: named errors, no crash ----

farm=$scenarios/farm.ini
size=$(wc -c < "$farm")
for ((i = 0; i < 60; i++)); do
	head -c $((size * i / 60)) "$farm" > cut.ini
	printf "\\$(printf %o $((33 + i)))" | dd of=cut.ini bs=1 seek=$((size * i / 70)) conv=notrunc 2> /dev/null
	status=0
	timeout 20 "$sim" cut.ini -q --print-config > out 2> err || status=$?
	[ $status = 0 ] || { [ $status = 2 ] && grep -qE '^gnss-sim: (cut.ini:[0-9]+: |\[)' err; } ||
		complain "a damaged scenario: exit $status: $(cat err)"
done
finish
