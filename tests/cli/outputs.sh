# Where data go, and how much is said.
. "$SRC/tests/cli/case.bash"

# -o: the whole new file or the old one, and nothing else in the folder.
gives 0 -t pvt "$log"
cp out pvt
gives 0 -t pvt -o table.csv "$log"
no_output
same pvt table.csv
echo old > kept.csv
gives 4 -t satpos -o kept.csv "$log"
[ "$(cat kept.csv)" = old ] || complain "kept.csv was touched"
gives 3 -t pvt -o kept.csv missing.sbf
[ "$(cat kept.csv)" = old ] || complain "kept.csv was touched"
gives 4 -t satpos -o never.csv "$log"
[ ! -e never.csv ] || complain "never.csv was made"
gives 3 -t pvt -o nowhere/table.csv "$log"
says "nowhere/table.csv: No such file or directory"
gives 3 -t pvt -o /dev/full "$log"
says "/dev/full: No space left on device"
mkdir folder
gives 3 -t pvt -o folder "$log"
[ "$(ls -A folder)" = "" ] || complain "something in folder"
ln -s table.csv link.csv
head -c 60000 "$log" > cut
gives 1 -t pvt -o cut.csv cut
[ -s cut.csv ] || complain "no cut.csv"
[ -z "$(ls -A | grep '^\.')" ] || complain "left behind: $(ls -A)"
gives 0 -t pvt -o - "$log"
same pvt out

# --split: a table for each type that occurs, as -t makes it.
gives 0 -q --split tables "$log"
no_output
gives 0 -q --split tables "$log" # again, into a folder that is there
for table in tables/*; do
	gives 0 -q -t "$(basename "$table" .csv)" "$log"
	same "$table" out
done
[ "$(ls tables | wc -l)" -ge 20 ] || complain "few tables: $(ls tables)"
gives 0 -q --split some -t pvt,event,satpos "$log"
[ "$(echo $(ls some))" = "event.csv pvt.csv" ] || complain "some: $(ls some)"
gives 3 --split table.csv "$log"
says "sbf2csv: table.csv/"

# Several types make a stream; its order of types is that of the log.
gives 0 -q -s -t dop,pvt "$log"
[ "$(head -n 1 out)" = "#furrow-stream 1" ] || complain "first line: $(head -n 1 out)"
[ "$(tail -n 1 out)" = "#end status=complete rows=120 skipped=0" ] || complain "last line: $(tail -n 1 out)"
[ "$(grep -c '^#pg tool=sbf2csv version=' out)" = 1 ] || complain "#pg"
[ "$(grep -v '^#' out | cut -d, -f 1 | sort | uniq -c | tr -s ' \n' ' ')" = " 60 dop 60 pvt " ] || complain "types"
cp out stream
gives 0 -q -s stream
[ "$(grep -c '^#pg ' out)" = 2 ] || complain "#pg lines do not add up"

# -q: nothing but what ends the run. -v: everything, however often.
{ for i in 1 2 3 4 5 6 7 8 9; do head -c 3000 "$log" | tail -c 1000; done; cat "$log"; } > bad
gives 1 -q -t pvt bad
silent
gives 1 -t pvt bad
messages=$(wc -l < err)
gives 1 -v -t pvt bad
[ "$(wc -l < err)" -gt "$messages" ] || complain "-v says no more"
gives 3 -q missing.sbf
says "missing.sbf: No such file or directory"
gives 0 --progress always -t pvt "$log"
same pvt out

# --list: blocks, whole and broken.
gives 0 --list "$log"
rows 28
header=block_id,name,revision,count,first_gps_week,first_tow_s,last_gps_week,last_tow_s,rate_hz,bytes,error_share,record
[ "$(head -n 1 out)" = $header ] || complain "header of the inventory"
prints "4007,PVTGeodetic,3,60,2422,289815,2422,289874,1,5760,0,pvt"
prints "4224,IMUSetup,0,1,2422,289815,2422,289815,,40,0,imu_setup"
prints "5922,EndOfMeas,0,60,2422,289815,2422,289874,1,960,0,"
cp out list
gives 0 --list -o list.csv "$log"
same list list.csv
[ "$(awk -F, 'NR > 1 { n += $10 } END { print n }' list)" = "$(stat -c %s "$log")" ] || complain "bytes do not add up"

# A byte changed inside the first block of positions: that block is counted as damaged.
at=$(LC_ALL=C grep -abo "$(printf '\247\157\140')" "$log" | head -n 1 | cut -d : -f 1)
cp "$log" broken
chmod u+w broken
printf '\377' | dd of=broken conv=notrunc bs=1 seek=$((at + 20)) status=none
gives 1 --list broken
prints "4007,PVTGeodetic,3,59,2422,289816,2422,289874,1,5664,0.016667,pvt"
gives 1 -t pvt broken
rows 60
says "block PVTGeodetic (4007): CRC mismatch, skipped"
says "1030 blocks, 1 lost"
finish
