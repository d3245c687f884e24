# RINEX in and out: files of our own log, read back, damaged, cut short, as a stream.
. "$SRC/tests/cli/case.bash"

# Out: two files, nothing else; the same bytes from a pipe.
gives 0 -f rinex --split files "$log"
no_output
[ "$(ls -A files)" = "nav.rnx
obs.rnx" ] || complain "in the folder: $(ls -A files)"
cat "$log" | "$sbf2csv" -q -f rinex --split piped || complain "from a pipe"
same files/obs.rnx piped/obs.rnx
same files/nav.rnx piped/nav.rnx
head -n 1 files/obs.rnx | grep -q '^     3.04           OBSERVATION DATA    M' || complain "$(head -n 1 files/obs.rnx)"

# In: what went out comes back, apart from what RINEX does not have.
gives 0 -t obs "$log"
cut -d, -f 1-4,7-9 out > wanted.csv
gives 0 -t obs files/obs.rnx
cut -d, -f 1-4,7-9 out > found.csv
python3 - << 'END' || complain "obs there and back"
import csv
wanted, found = ([r for r in csv.reader(open(f))] for f in ("wanted.csv", "found.csv"))
assert sorted(r[:4] for r in wanted) == sorted(r[:4] for r in found)
found = {tuple(r[:4]): r[4:] for r in found[1:]}
for r in wanted[1:]:
    for a, b in zip(r[4:], found[tuple(r[:4])]):
        assert (a == "") == (b == "") and (a == "" or abs(float(a) - float(b)) < 0.000501), (r, b)
END
for type in eph_gps epoch setup; do
	gives 0 -t $type files/obs.rnx files/nav.rnx
done

# Once more, and again: nothing changes any more. gzip, streams and LCM logs on the way do not matter.
"$sbf2csv" -q -f rinex --split again files/obs.rnx files/nav.rnx || complain "RINEX of RINEX"
"$sbf2csv" -q -f rinex --split third again/obs.rnx again/nav.rnx || complain "and of that"
same again/obs.rnx third/obs.rnx
same again/nav.rnx third/nav.rnx
gzip -k again/obs.rnx
"$sbf2csv" -q -s again/obs.rnx.gz again/nav.rnx > stream || complain "to a stream"
"$sbf2csv" -q -f rinex --split fourth stream || complain "of a stream"
same again/obs.rnx fourth/obs.rnx
same again/nav.rnx fourth/nav.rnx

# Damage: status 1, the line is named, the rest is there.
n=$(grep -c '^[A-Z][0-9]' again/obs.rnx)
line=$(grep -n '^G' again/obs.rnx | sed -n 100p | cut -d: -f 1)
sed "${line}s/\\./x/" again/obs.rnx > damaged.rnx
gives 1 -t obs damaged.rnx
says "sbf2csv: damaged.rnx:$line: damaged number, satellite lost"
says " 1 lost,"
head -c 20000 again/obs.rnx > short.rnx
gives 1 -t obs short.rnx
says "short.rnx: cut short"
head -c 300 again/nav.rnx > short.rnx
gives 4 -t eph_gps short.rnx
says "short.rnx: cut short"

# No data: nothing is written, old files stay.
echo old > fourth/obs.rnx
gives 4 -f rinex --split fourth -t satpos "$log"
[ "$(cat fourth/obs.rnx)" = old ] || complain "an old file was touched"
[ "$(ls -A fourth)" = "nav.rnx
obs.rnx" ] || complain "left behind: $(ls -A fourth)"

# Usage.
gives 2 -f rinex "$log"
says "--split DIR says where"
gives 2 -f rinex -o x.rnx "$log"
gives 2 -f rinex -s --split x "$log"
gives 3 -f rinex --split /dev/null "$log"
finish
