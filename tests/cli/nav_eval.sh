# nav-eval: what it says of solutions whose errors are known, and of files that are not what they should be.
. "$SRC/tests/cli/case.bash"
sbf2csv=$BIN/nav-eval # what `gives` runs

# Truth: east along the equator with 10 m/s, at 10 Hz, over the end of a week; a hole of 2 s in it.
# The solutions: half-way between its rows, one metre further north, two east, 3 m below; four epochs lost.
awk 'BEGIN {
	a = 6378137; e2 = 0.00669437999014132; height = 100; deg = 180 / 3.14159265358979323846
	truth = "truth.csv"; solution = "nav.csv"; position = "pos.csv"; levels = "pl.csv"
	print "gps_week,tow_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,heading_deg" > truth
	for (i = 0; i <= 100; i++) {
		if (i > 40 && i < 60)
			continue
		t = 604799 + i / 10
		printf "%d,%.1f,0,%.12f,100,0,10,0,0,0,90\n", 2400 + (t >= 604800), t - 604800 * (t >= 604800), i * deg / (a + height) > truth
	}
	print "gps_week,tow_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,heading_deg," \
		"sd_n_m,sd_e_m,sd_d_m,hpl_m,vpl_m,hfom_m" > solution
	print "gps_week,tow_s,lat_deg,lon_deg,height_m,sd_n_m,sd_e_m,sd_d_m,quality" > position
	print "gps_week,tow_s,hpl_m,vpl_m,hal_m,val_m,state" > levels
	for (i = 0; i < 50; i++) {
		t = 604799.05 + i / 5
		week = 2400 + (t >= 604800)
		tow = t - 604800 * (t >= 604800)
		lat = deg / (a * (1 - e2) + height)
		lon = deg * (2 + 10 * (i / 5 + 0.05)) / (a + height)
		if (i < 10 || i >= 14)
			printf "%d,%.2f,%.12f,%.12f,97,0.1,10,0,1,0,%d,2,1.5,2,5,%d,2\n", week, tow, lat, lon, 88, i < 30 ? 4 : 2 > solution
		printf "%d,%.2f,%.12f,%.12f,100,,,,single\n", week, tow, lat, lon > position
		printf "%d,%.2f,2,9,40,8,test\n", week, tow > levels
	}
}'

gives 0 -q --truth truth.csv nav.csv
silent
cat > wanted <<'EOF'
solution  nav.csv (nav), every 0.2 s
truth     truth.csv (nav), 82 rows every 0.1 s, 1 gap of up to 2 s; between rows good to about GOOD m
          10 epochs of the solution at times without truth
epochs    36 of 40 solved, 90.00 % available

                     n       mean        rms       50 %       68 %       95 %       99 %        max   1 sd   2 sd   3 sd
north_m             36     1.0000     1.0000     1.0000     1.0000     1.0000     1.0000     1.0000 100.00 100.00 100.00
EOF
sed -i 's/good to about [0-9.e-]* m/good to about GOOD m/' out
head -n 7 out > head
same wanted head
prints "east_m              36     2.0000     2.0000     2.0000     2.0000     2.0000     2.0000     2.0000   0.00 100.00 100.00"
prints "down_m              36     3.0000     3.0000     3.0000     3.0000     3.0000     3.0000     3.0000   0.00 100.00 100.00"
prints "horizontal_m        36     2.2361     2.2361"
prints "position_m          36     3.7417     3.7417"
prints "vn_mps              36     0.1000     0.1000"
prints "ve_mps              36     0.0000     0.0000"
prints "roll_deg            36     1.0000     1.0000"
prints "heading_deg         36    -2.0000     2.0000"
prints "position            36 epochs with standard deviations: NEES 1.426 (1 expected), 100.00 % below its 95 % point"
prints "horizontal          36 epochs with protection level: 36 nominal, 0 MI, 0 HMI, 0 unavailable"
prints "horizontal          36 epochs with figure of merit: 0.00 % of errors inside (95 expected)"
prints "vertical            36 epochs with protection level: 16 nominal, 20 MI, 0 HMI, 0 unavailable"

# Alert limits make of the same epochs what they are.
gives 0 -q --truth truth.csv --hal 4 --val 2.5 nav.csv
prints "36 epochs with protection level: 0 nominal, 0 MI, 0 HMI, 36 unavailable, 0 unavailable and misleading"
prints "36 epochs with protection level: 0 nominal, 0 MI, 20 HMI, 16 unavailable, 0 unavailable and misleading"
gives 0 -q --truth truth.csv --levels pl.csv nav.csv
prints "36 epochs with protection level: 0 nominal, 36 MI, 0 HMI"
prints "36 epochs with protection level: 0 nominal, 0 MI, 0 HMI, 36 unavailable, 0 unavailable and misleading"

# The antenna 2 m ahead (east) and 3 m below the truth's point, one to the left: no error is left.
gives 0 -q --truth truth.csv --lever-arm 2,-1,3 nav.csv
prints "position_m          36     0.0000     0.0000"
prints "ve_mps              36     0.0000     0.0000"

# Sections, as a table; the numbers of the text.
gives 0 -q --truth truth.csv --sections 4 -f csv nav.csv pos.csv
[ "$(awk -F, '$1 == "nav.csv" && $5 == "east_m" { printf "%s %s %s %s %s %.5f\n", $2, $3, $4, $6, $7, $9 }' out)" = "all 0 10 36 40 2.00000
1 0 4 16 20 2.00000
2 4 8 10 10 2.00000
3 8 10 10 10 2.00000" ] || complain "sections: $(cut -d, -f 1-9 out)"
[ "$(awk -F, '$1 == "pos.csv" && $2 == "all" { printf "%s %s %.5f %s\n", $5, $6, $10, $16 }' out)" = "north_m 40 1.00000 
east_m 40 2.00000 
down_m 40 0.00000 
horizontal_m 40 2.23607 
position_m 40 2.23607 " ] || complain "pos: $(cut -d, -f 1-16 out)"
[ -z "$(grep -iE 'nan|inf' out)" ] || complain "not a number"
[ "$(awk -F, '{ print NF }' out | sort -u)" = 27 ] || complain "columns"
gives 0 -q --truth truth.csv --sections 1,2401:1,4 -f csv nav.csv
[ "$(awk -F, '$5 == "east_m" { print $2, $3, $4, $6 }' out)" = "all 0 10 36
1 1 2 5
2 2 4 6" ] || complain "boundaries: $(cut -d, -f 1-9 out)"
gives 0 -q --truth truth.csv --from 2401:0 --until 2401:1 -f csv nav.csv
[ "$(awk -F, '$5 == "east_m" { print $3, $4, $6, $7 }' out)" = "0 1 5 5" ] || complain "window: $(cut -d, -f 1-9 out)"

# A wider gap is bridged when asked for; streams, LCM logs and compressed files are read as well; the stream's own levels count.
gives 0 -q --truth truth.csv --max-gap 3 nav.csv
prints "46 of 50 solved, 92.00 % available"
"$BIN/sbf2csv" -q -s -t nav -o nav.stream nav.csv
"$BIN/sbf2csv" -q -f lcm -t nav -o nav.lcm nav.csv
gzip -k truth.csv
for file in nav.stream nav.lcm; do
	gives 0 -q --truth truth.csv.gz $file
	prints "position_m          36     3.7417"
done
gives 0 -q --truth truth.csv < nav.csv
prints "solution  standard input (nav)"
gives 0 -q --truth - nav.csv < truth.csv
prints "truth     standard input (nav)"
{ grep -v '^#end' nav.stream; sed '1s/^/#pl,/; 2,$s/^/pl,/' pl.csv; echo "#end status=complete rows=96 skipped=0"; } > both.stream
gives 0 -q --truth truth.csv both.stream
prints "36 epochs with protection level: 0 nominal, 36 MI, 0 HMI"

# A receiver's log against itself.
gives 0 -q --truth "$log" -t ins "$log"
prints "position_m          57     0.0000     0.0000"

# Rows in disorder, repeated, nonsense: what is left is judged, what is not is counted.
{ head -n 1 nav.csv; tail -n +2 nav.csv | tac; sed -n 5p nav.csv; } > tac.csv
gives 1 --truth truth.csv tac.csv
prints "position_m          36     3.7417"
says "tac.csv: 1 rows with the stamp of another left out"
sed '10s/[^,]*/x/; 11s/,0,/,91,/; 12s/.*/2401,5,1e308,-1e308,1e308/; 13s/.*/,,,,/; 14s/.*/99999,1,1,1/; 15s/^\(.*,.*,\)[^,]*/\1nan/' truth.csv > bad.csv
gives 1 --truth bad.csv nav.csv
says "bad.csv:10: column 1 gps_week"
gives 1 --truth truth.csv bad.csv
gives 1 --truth truth.csv --max-rows 20 nav.csv
says "truth.csv: 62 rows beyond the first 20 left out (--max-rows)"
head -c 3000 nav.stream > cut.stream
gives 1 --truth truth.csv cut.stream
gives 1 --truth truth.csv nav.csv pl.csv
says "pl.csv: no solution in it"
prints "position_m          36     3.7417"

# What cannot be done.
for file in pl.csv /dev/null; do
	gives 4 --truth $file nav.csv
	says "no trajectory in it, so no truth"
	no_output
done
gives 4 --truth truth.csv --from 2401:9 nav.csv
gives 4 --truth truth.csv pl.csv
gives 4 --truth truth.csv --levels nav.csv nav.csv
says "nav.csv: no protection levels (pl) in it"
gives 4 -o out.txt --truth pos.csv --lever-arm 1,0,0 nav.csv
[ ! -e out.txt ] || complain "out.txt was made"
gives 3 --truth missing.csv nav.csv
gives 3 --truth truth.csv missing.csv
gives 3 -o /dev/full --truth truth.csv nav.csv
refused() {
	local message=$1
	shift
	gives 2 "$@"
	says "nav-eval: $message"
	no_output
}
refused "--truth FILE is needed" nav.csv
refused "standard input can be one file only" --truth - - < nav.csv
refused "standard input can be one file only" --truth - < nav.csv
refused "--types: 'pl' is not one of nav, pos, ins, pvt" -t pl --truth truth.csv nav.csv
refused "--lever-arm: not three numbers" --lever-arm 1,2 --truth truth.csv nav.csv
refused "--lever-arm: not three numbers" --lever-arm 1,2,3,4 --truth truth.csv nav.csv
refused "--lever-arm: not three numbers" --lever-arm 1,2,nan --truth truth.csv nav.csv
refused "--sections: neither seconds nor times" --sections x --truth truth.csv nav.csv
refused "--sections: neither seconds nor times" --sections -5 --truth truth.csv nav.csv
refused "--sections: the boundaries are not in order" --sections 5,5 --truth truth.csv nav.csv
refused "--sections: more than 2000" --sections 0.004 --truth truth.csv nav.csv
refused "--sections: below a millisecond" --sections 0.0001 --truth truth.csv nav.csv
refused "--sections: one time is no stretch" --sections 2401:1 --truth truth.csv nav.csv
refused "--html and --output go to the same place" --html - --truth truth.csv nav.csv
refused "unknown option or key 'sektions'; did you mean 'sections'?" --sektions 5 --truth truth.csv nav.csv

# The page: whole, in one piece, without anything to fetch; names of files are text in it.
mkdir -p "q'\"<b>"
cp nav.csv "q'\"<b>/\`x\`.csv"
if command -v gnuplot > /dev/null; then
	gives 0 -q --truth truth.csv --hal 4 --val 8 --html page.html nav.csv pos.csv "q'\"<b>/\`x\`.csv"
	[ "$(grep -c '<svg' page.html)" -ge 15 ] || complain "few pictures: $(grep -c '<svg' page.html)"
	[ "$(grep -o '<svg' page.html | wc -l)" = "$(grep -o '</svg>' page.html | wc -l)" ] || complain "cut pictures"
	grep -q '</html>$' page.html || complain "no end"
	grep -q "q'&quot;&lt;b&gt;/" page.html || complain "name of a file"
	[ -z "$(grep -oE '(src|href)=' page.html)" ] || complain "something to fetch: $(grep -oE '(src|href)=.{20}' page.html)"
	[ -z "$(grep -oiE '[^a-z]nan[^a-z]' page.html)" ] || complain "not a number in the page"
	gives 0 -q --truth "$log" -t pvt --html sky.html "$log"
	grep -q '<h3>Sky</h3>' sky.html || complain "no sky"
	gives 0 -q --truth truth.csv --html again.html --hal 4 --val 8 nav.csv pos.csv "q'\"<b>/\`x\`.csv"
	same <(sed '/<footer>/,$d' page.html) <(sed '/<footer>/,$d' again.html)
fi
echo old > kept.html
PATH=/nowhere gives 3 -q --truth truth.csv --html kept.html nav.csv
says "--html needs gnuplot, which is not there"
[ "$(cat kept.html)" = old ] || complain "kept.html was touched"
no_output
finish
