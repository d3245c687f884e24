# The golden sets, made again by the commands that their ORIGINs tell: the same seed gives the same bytes. Where it does not,
# gnss-sim simulates something else than it did, which has to be meant.
. "$SRC/tests/cli/case.bash"
PATH=$BIN:$PATH
mkdir golden
cp -r "$SRC/testdata/scenarios" .

for origin in "$SRC"/testdata/golden/*/ORIGIN; do
	set=golden/$(basename "$(dirname "$origin")")
	expect 0 "$set" bash -c "$(grep '^    ' "$origin")"
	diff -rq -x ORIGIN "$SRC/testdata/$set" "$set" || complain "$set: gnss-sim makes other bytes than the golden ones"
done
[ -s golden/fieldcopter/rover.sbf ] || complain "no golden set was made"
finish
