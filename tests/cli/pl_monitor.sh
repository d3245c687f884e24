# pl-monitor: states of logs whose levels are known, streams that go on, input that is not what it should be.
. "$SRC/tests/cli/case.bash"
decoder=$BIN/sbf2csv
sbf2csv=$BIN/pl-monitor # what `gives` runs

# states: the states in the order of the rows, each once per run of equal ones; with how many rows.
states() { awk -F, 'NR == 1 {for (i = 1; i <= NF; i++) if ($i == "state") c = i; next} {print $c}' out | uniq -c | awk '{print $1, $2}'; }

# Our own log: no position for 3 s, stand-alone until 12 s, SBAS from there, levels growing from 3.87 and 7.19 m.
gives 0 "$log"
rows 60
[ "$(states)" = "3 NO_POSITION
9 NO_SBAS
48 RELIABLE" ] || complain "states: $(states)"
prints "2422,289827,3.8698,7.1938,40.0000,50.0000,RELIABLE,receiver,13"
prints "2422,289826,,,40.0000,50.0000,NO_SBAS,receiver,13"
prints "2422,289815,,,40.0000,50.0000,NO_POSITION,receiver,"
says "60 epochs, 2 transitions; available 79.66 % of 59.0 s: RELIABLE 47.0 s, NO_SBAS 9.0 s, UNRELIABLE 0.0 s, NO_POSITION 3.0 s"
gives 0 -q -t transition --hal 3.88 "$log"
silent
[ "$(cat out)" = "gps_week,tow_s,from_state,to_state,cause
2422,289818,NO_POSITION,NO_SBAS,no-sbas
2422,289827,NO_SBAS,RELIABLE,within-limits
2422,289846,RELIABLE,UNRELIABLE,hpl" ] || complain "transitions: $(cat out)"
gives 0 -q -t transition --hal 3 --val 5 "$log"
prints "289827,NO_SBAS,UNRELIABLE,hpl-vpl"
gives 0 -q -v -t transition --val 7.2 "$log"
gives 0 -v -t transition --val 7.2 "$log"
says "2422:289833.000: RELIABLE to UNRELIABLE: vpl"
gives 0 -q --from 2422:289820 --until 2422:289830 "$log"
rows 10
[ "$(states)" = "7 NO_SBAS
3 RELIABLE" ] || complain "window: $(states)"
gives 0 -q -t transition --hold 4 "$log"
prints "289822,NO_POSITION,NO_SBAS,no-sbas"
prints "289831,NO_SBAS,RELIABLE,within-limits"
gives 0 -q -t transition --hal 3.88 --time-to-alert 5 "$log"
prints "289851,RELIABLE,UNRELIABLE,hpl"
gives 0 -q -t transition --hal 4 --margin 10 "$log"
prints "289818,NO_POSITION,NO_SBAS,no-sbas"
[ "$(wc -l < out)" = 2 ] || complain "margin: $(cat out)"

# The same from a stream, an LCM log, compressed, from standard input, and as LCM log and stream.
gives 0 -q "$log"
mv out want
"$decoder" -q -s "$log" -o all.stream
"$decoder" -q -f lcm "$log" -o all.lcm
gzip -k all.stream
for file in all.stream all.lcm all.stream.gz; do
	gives 0 -q "$file"
	same out want
done
gives 0 -q < all.stream
same out want
gives 0 -q -f lcm "$log"
"$decoder" -q -t pl out > back
same back want
gives 0 -q -s "$log"
"$decoder" -q -t pl out > back
same back want
"$decoder" -q -t transition out > back
[ "$(wc -l < back)" = 3 ] || complain "transitions of a stream: $(cat back)"
"$decoder" -q -s -t pvt "$log" | "$sbf2csv" -q > out
[ "$(states)" = "3 NO_POSITION
57 NO_SBAS" ] || complain "no dop: $(states)"
gives 4 -q <("$decoder" -q -t dop "$log")
"$decoder" -q -t pvt "$log" | cut -d, -f1-4,6-8 > few.csv
gives 0 -q few.csv
[ "$(states)" = "3 NO_POSITION
57 NO_SBAS" ] || complain "few columns: $(states)"

# A stream goes on whole: without our rows it is what came in. Those of an epoch stand between it and the next one.
gives 0 -q -s all.stream
diff <(grep -v '^#' all.stream) <(grep -v '^#\|^pl,\|^transition,' out) > /dev/null || complain "the stream is not the old one and ours"
grep -q '^#pg tool=sbf2csv' out && grep -q '^#pg tool=pl-monitor' out || complain "provenance: $(grep '^#pg' out)"
grep -q '^#cfg hal=40' out || complain "settings: $(grep '^#cfg' out)"
tail -n 1 out | grep -q '^#end status=complete' || complain "$(tail -n 1 out)"
awk -F, '$1 == "pvt" || $1 == "dop" {last = $3} $1 == "pl" {n++; if ($3 != last) exit 1} END {if (n != 60) exit 1}' out ||
	complain "rows of pl do not follow their epochs"
awk -F, '/^#/ {next} $1 == "pl" && $3 < before {exit 1} $1 ~ /^(pvt|dop|pl|epoch)$/ {before = $3}' out || complain "not in the order of time"
# Levels that are there already make room for ours.
mv out first.stream
gives 0 -s --hal 3.88 first.stream
says "62 rows of pl and transition in the input not passed on"
[ "$(grep -c '^pl,' out)" = 60 ] || complain "$(grep -c '^pl,' out) rows of pl"
prints ",UNRELIABLE,"

# Made-up epochs: a gap, a return, an epoch twice, one back in time, one of a wrong time far ahead.
epochs() {
	echo "#furrow-stream 1"
	echo "#pvt,gps_week,tow_s,mode,error,lat_deg,lon_deg,height_m,n_sats"
	echo "#dop,gps_week,tow_s,hpl_m,vpl_m"
	for t in "$@"; do printf 'pvt,2400,%s,6,0,52,11,100,9\ndop,2400,%s,10,20\n' "$t" "$t"; done
	echo "#end status=complete rows=1 skipped=0"
}
gives 0 -q -t transition <(epochs 1 2 3 9 10)
[ "$(tail -n +2 out)" = "2400,1,NO_POSITION,RELIABLE,within-limits
2400,6,RELIABLE,NO_POSITION,timeout
2400,9,NO_POSITION,RELIABLE,within-limits" ] || complain "gap: $(cat out)"
gives 0 -q <(epochs 1 2 3 9 10)
prints "2400,6,,,40.0000,50.0000,NO_POSITION,receiver,"
rows 6
gives 0 -q -t transition --timeout 10 <(epochs 1 2 3 9 10)
rows 1
gives 1 <(epochs 1 2 2 3 1.5 4)
rows 4
says "2 lost"
says "2400:1.500: an epoch that is not after the one before, left out"
gives 1 <(epochs 1 2 90000 3 4 5 6 7)
says "2400:5.000: time begins anew"
[ "$(grep -c RELIABLE out)" = 6 ] || complain "time ahead: $(cat out)"
gives 0 -q <(epochs 1 2 | sed 's/^dop.*//')
[ "$(states)" = "2 NO_SBAS" ] || complain "no levels: $(states)"
gives 0 -q <(epochs 1 2 | sed 's/,10,20$/,,/')
[ "$(states)" = "2 NO_SBAS" ] || complain "empty levels: $(states)"
gives 0 -q <(epochs 1 2 | sed 's/,6,0,/,6,3,/')
[ "$(states)" = "2 NO_POSITION" ] || complain "an error: $(states)"
gives 0 -q <(epochs 1 2 | sed 's/,6,0,52,11,/,6,0,,,/')
[ "$(states)" = "2 NO_POSITION" ] || complain "no coordinates: $(states)"
gives 1 -q <(epochs 1 2 3 | sed 's/^dop,2400,2,10/dop,2400,2,nan/; s/^dop,2400,3,10/dop,2400,3,1e999/')
[ "$(states)" = "1 RELIABLE
2 NO_SBAS" ] || complain "levels that are no numbers: $(states)"
gives 0 -q -t transition <(epochs 1 2 | sed 's/,10,20$/,10,1e30/')
prints "2400,1,NO_POSITION,UNRELIABLE,vpl"

# Earth-centred positions will do.
epochs 1 2 | sed 's/pvt/pvt_ecef/; s/lat_deg,lon_deg,height_m/x_m,y_m,z_m/; s/,52,11,100,/,3857000,749000,5006000,/' > ecef.stream
gives 0 -q ecef.stream
[ "$(states)" = "2 RELIABLE" ] || complain "pvt_ecef: $(states)"

# Real logs: all of log_0000.sbf was computed with SBAS.
if [ -r "$FURROW_DATA/sbf/log_0000.sbf" ]; then
	gives 0 -q "$FURROW_DATA/sbf/log_0000.sbf"
	[ "$(states)" = "12 RELIABLE" ] || complain "log_0000: $(states)"
fi

# The golden sets: SBAS on the flight, none on the other one.
gives 0 -q --hal 20 "$SRC/testdata/golden/fieldcopter/rover.sbf"
[ "$(states | cut -d' ' -f2 | sort -u | tr '\n' ' ')" = "RELIABLE UNRELIABLE " ] || complain "fieldcopter: $(states)"
gives 0 -q "$SRC/testdata/golden/hnu/rover.sbf"
[ "$(states)" = "16 NO_SBAS" ] || complain "hnu: $(states)"

# nav-eval takes the levels: every epoch of the flight is nominal or, where a level is above the limit, unavailable.
set=$SRC/testdata/golden/fieldcopter
gives 0 -q --hal 20 --val 30 -o pl.csv "$set/rover.sbf"
"$BIN/nav-eval" -q --truth "$set/truth.csv" --levels pl.csv -t pvt "$set/rover.sbf" > out 2> err || complain "nav-eval: $(cat err)"
grep -qE '^horizontal +31 epochs with protection level: .* 0 MI, 0 HMI, ' out || complain "Stanford: $(grep epochs out)"
grep -qE '^vertical +31 epochs with protection level: .* 0 MI, 0 HMI, [1-9]' out || complain "Stanford: $(grep epochs out)"

# Cut, damaged, empty, foreign.
size=$(wc -c < "$log")
head -c $((size / 2)) "$log" > cut.sbf
gives 1 cut.sbf
says "the log ends inside a"
[ "$(wc -l < out)" -gt 20 ] || complain "cut: $(wc -l < out) lines"
gives 1 -s cut.sbf
tail -n 1 out | grep -q '^#end status=partial' || complain "$(tail -n 1 out)"
head -c 20000 all.stream > cut.stream
gives 1 -q cut.stream
cp "$log" damaged.sbf
for at in 3000 9000 20000 31000; do printf 'garbage' | dd of=damaged.sbf bs=1 seek=$at conv=notrunc 2> /dev/null; done
gives 1 damaged.sbf
says "CRC mismatch"
[ "$(wc -l < out)" -gt 50 ] || complain "damaged: $(wc -l < out) lines"
gives 4 /dev/null
says "empty"
head -c 5000 /dev/zero > zeros
gives 4 zeros
"$decoder" -q -t obs "$log" > obs.csv
gives 4 -o none.csv obs.csv
says "nothing of what was asked for is there"
[ ! -e none.csv ] || complain "none.csv was made"
gives 3 missing.sbf
gives 3 -o /dev/full "$log"
gives 3 -o no/such/folder/pl.csv "$log"
echo old > kept.csv
gives 4 -o kept.csv obs.csv
[ "$(cat kept.csv)" = old ] || complain "kept.csv was touched"

# Options.
refused() {
	local message=$1
	shift
	gives 2 "$@"
	says "pl-monitor: $message"
	no_output
}
refused "--types: 'pvt' is not one of pl, transition" -t pvt "$log"
refused "a table holds one type; add -s for a stream" -t pl,transition "$log"
refused "unknown option or key 'houd'; did you mean 'hold'?" --houd 3 "$log"
refused "--hal" --hal 0 "$log"
refused "--hal" --hal nan "$log"
refused "--source" --source sbas "$log"
refused "--timeout" --timeout 0 "$log"
printf '[pl-monitor]\nhal = 3.88\nhold = 2\n' > settings.ini
gives 0 -q -c settings.ini --set hold=0 -t transition "$log"
prints "289846,RELIABLE,UNRELIABLE,hpl"
gives 0 -c settings.ini --print-config
prints "hal = 3.88"
finish
