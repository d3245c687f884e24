# Where data come from: files, several of them, compressed ones, pipes, other forms than SBF; and what is no data.
. "$SRC/tests/cli/case.bash"

gives 0 -t pvt "$log"
rows 60
says "sbf2csv: 1031 blocks, 0 lost, 0 bytes skipped, 60 rows written"
cp out table.csv
gzip -c "$log" > log.gz
cp "$log" log.txt # no name tells what is in a file

for input in log.gz log.txt; do
	gives 0 -t pvt $input
	same table.csv out
done
for command in "cat log.txt" "cat log.gz" "dd status=none bs=1 if=log.gz"; do
	$command | "$sbf2csv" -q -t pvt > out || complain "$command |"
	same table.csv out
	$command | "$sbf2csv" -q -t pvt - > out || complain "$command | sbf2csv -"
	same table.csv out
done
"$sbf2csv" -q -t pvt < log.txt > out || complain "< log.txt"
same table.csv out

# One after the other; the header once. Two members of gzip in one file are one input.
gives 0 -t pvt log.txt log.gz "$log"
rows 180
cat log.gz log.gz > two.gz
gives 0 -t pvt two.gz
rows 120
cat log.txt | "$sbf2csv" -q -t pvt log.gz - > out || complain "file and standard input"
rows 120

# A stream, a table and an LCM log are known by what is in them.
"$sbf2csv" -q -s "$log" > stream
"$sbf2csv" -q -f lcm -o records.lcm "$log"
gzip -k stream
for input in stream stream.gz records.lcm table.csv; do
	gives 0 -t pvt $input
	same table.csv out
done
gives 0 -t event stream log.txt records.lcm
rows 84

# No usable data: 4. The table's header is there all the same when there was something to read.
: > empty
gives 4 empty
says "0 blocks, 0 lost, 0 bytes skipped, 0 rows written"
gives 4 < empty
gzip -c empty > empty.gz
gives 4 empty.gz
head -c 100000 /dev/zero > zeros
gives 4 zeros
gives 4 -t satpos "$log"
says "nothing of what was asked for is there"
head -n 1 table.csv > header.csv
gives 4 header.csv
printf '     3.04           OBSERVATION DATA    M: Mixed            RINEX VERSION / TYPE\n' > rinex
gives 4 rinex # a header that never ends
says "rinex: cut short"
printf '     3.04           CLOCK DATA          M: Mixed            RINEX VERSION / TYPE\n' > clocks
gives 4 clocks
says "neither observations nor navigation"
printf '#dP2024  1  1\n' > orbits.sp3
gives 4 orbits.sp3
says "precise orbits (SP3)"
printf '\037\235\220' > obs.Z
gives 4 obs.Z
says "compressed with compress(1)"
gives 4 --list zeros

# Part of it is missing: 1, and what there is.
head -c 40000 "$log" > cut
gives 1 -t pvt cut
says "cut: byte "
says "the log ends inside a block"
head -c 20000 log.gz > cut.gz
gives 1 -t pvt cut.gz
says "cut.gz: cut short"
head -n 1000 stream > cut.stream
gives 1 -s cut.stream
prints "#end status=partial"
echo '$GPGGA,083015.00,5133.1,N,00000.0,W,1,12,0.7,60.0,M,47.0,M,,*5C' > nmea
cat "$log" nmea "$log" > mixed
gives 1 -t pvt mixed
rows 120
says "2062 blocks, 0 lost, $(stat -c %s nmea) bytes skipped"

# Not to be read: 3, and the rest is read all the same.
gives 3 missing.sbf
says "missing.sbf: No such file or directory"
gives 3 .
says ".: Is a directory"
gives 3 -t pvt missing.sbf "$log"
says "missing.sbf: No such file or directory"
finish
