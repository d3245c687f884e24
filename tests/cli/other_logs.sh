# Logs of other devices through sbf2csv: found out by their first bytes, from files and from pipes, whole and damaged.
set -u
. "$SRC/tests/common.bash"
map="time=1 gx=2 gy=3 gz=4 ax=5 ay=6 az=7"

# The rows of a table without its header must be these.
rows_are() {
	diff <(tail -n +2 out.csv) - || complain "$1: other rows"
}

printf '100,1,2,3,4,5,6\n100.01,-1,-2,-3,-4,-5,-6\n' > imu.csv
expect 0 "a table" "$sbf2csv" -t imu --imu-columns "$map" --imu-axes FLU --imu-time gps,week=2300 imu.csv > out.csv
rows_are "a table" << 'ROWS'
2300,100,1.000000000,-2.000000000,-3.000000000,4.000000000,-5.000000000,-6.000000000
2300,100.01,-1.000000000,2.000000000,3.000000000,-4.000000000,5.000000000,6.000000000
ROWS
gzip -kf imu.csv
cp out.csv plain.csv
expect 0 "a compressed table from a pipe" "$sbf2csv" -t imu --imu-columns "$map" --imu-axes FLU \
	--imu-time gps,week=2300 < imu.csv.gz > out.csv
cmp plain.csv out.csv || complain "a pipe gives other rows"

# Settings by a file mean the same.
printf '[sbf2csv]\nimu-columns = %s\nimu-axes = FLU\nimu-time = gps,week=2300\n' "$map" > furrow.ini
expect 0 "settings in a file" "$sbf2csv" -c furrow.ini -t imu imu.csv > out.csv
cmp plain.csv out.csv || complain "settings in a file give other rows"

# Lines that are refused are named and counted, the others are not lost.
printf '100,1,2,3,4,5,6\n100.01,1,2,x,4,5,6\n100.02,1,2,3,4,5\n100.03,1,2,3,4,5,nan\n100.04,1,2,3,4,5,6\n' > bad.csv
expect 1 "damaged lines" "$sbf2csv" -t imu --imu-columns "$map" --imu-time gps,week=2300 bad.csv > out.csv
[ "$(wc -l < out.csv)" = 3 ] || complain "damaged lines: $(wc -l < out.csv) lines"
grep -q 'bad.csv:2: column 4 (gz): no number' messages || complain "no message for line 2"
grep -q '3 lost' messages || complain "the losses are not counted"

# What is wrong with an option is said, and nothing is written.
for wrong in "--imu-columns=time=1 gx=2" "--imu-columns=time=1 sped=2" --imu-axes=y,x,z --imu-time=tai --imu-time=gps,week=x; do
	expect 2 "$wrong" "$sbf2csv" "$wrong" imu.csv > out.csv
	grep -qe "${wrong%%=*}: '" messages || complain "$wrong: $(head -n 1 messages)"
done
expect 4 "a table whose week nobody knows" "$sbf2csv" -t imu --imu-columns "$map" imu.csv > out.csv
grep -q 'imu-time' messages || complain "no hint at --imu-time"
expect 4 "a table without a map" "$sbf2csv" -t imu imu.csv > out.csv

# RTKLIB's solution needs no option.
cat > walk.pos << 'POS'
% program   : RTKPOST ver.2.4.3
%  GPST                  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio
2025/08/28 17:30:39.749   40.096691600 -105.147166500  1601.4350   1  25   0.0100   0.0200   0.0300   0.0000   0.0000   0.0000   0.00    3.2
POS
expect 0 "a solution" "$sbf2csv" -t pos walk.pos > out.csv
rows_are "a solution" << 'ROWS'
2381,408639.749,40.096691600,-105.147166500,1601.4350,0.0100,0.0200,0.0300,fixed,25,,3.2,,,,,,,
ROWS

# An autopilot's log, as text: heights above the sea are told.
cat > flight.log << 'LOG'
FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns
FMT, 130, 45, GPS, QBBIHBcLLeffffB, TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U
FMT, 131, 31, IMU, QBffffffIIfBBHH, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz
IMU, 1000000, 0, 0.5, 0.25, -0.5, 1, 2, -9.75, 0, 0, 30.1, 1, 1, 1000, 1000
GPS, 1200000, 0, 6, 1001000, 2300, 17, 0.75, 48.5, -7.25, 200.5, 10, 90, 1.5, 0, 1
LOG
expect 0 "ArduPilot's text" "$sbf2csv" -s flight.log > out.stream
grep -q '^imu,2300,1000.92,0.5' out.stream || complain "no IMU sample: $(grep ^imu out.stream)"
grep -q '^pvt,2300,1001,' out.stream || complain "no position"
grep -q '^#heights above mean sea level' out.stream || complain "the stream does not say what its heights are"
expect 0 "another latency" "$sbf2csv" -s --gps-lag 0.2 flight.log > out.stream
grep -q '^imu,2300,1001,0.5' out.stream || complain "--gps-lag: $(grep ^imu out.stream)"
cat flight.log | expect 0 "ArduPilot's text from a pipe" "$sbf2csv" -s > out.stream
grep -q '^imu,' out.stream && complain "a pipe has no time before its first position"
grep -q '1 messages without GPS time' messages || complain "not said: $(cat messages)"
exit $failed
