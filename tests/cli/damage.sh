# Damage costs the damaged blocks, which are counted; what is no log gives no rows, in good time.
set -u
. "$SRC/tests/common.bash"
[ "$log" != "$SRC/testdata/demo.sbf" ] || { echo "skipped: needs the real log"; exit 77; }

# 1,000 of 100,000 blocks.
"$BENCH/extend_log" "$log" 11.07 > long.sbf
blocks=$(("$(wc -c < long.sbf)" / 83028 * 748))
[ $blocks -ge 100000 ] || complain "only $blocks blocks to damage"
for seed in 1 2 3; do
	"$TOOLS/damage_log" 1000 $seed < long.sbf > damaged.sbf || complain "damage $seed: not made"
	expect 1 "damage $seed" "$sbf2csv" -s damaged.sbf > stream
	tail -n 1 stream | grep -q '^#end status=partial rows=[0-9]* skipped=1000$' || complain "damage $seed: $(tail -n 1 stream)"
	tail -n 1 messages | grep -q "^sbf2csv: $((blocks - 1000)) blocks.* 1000 lost, " || complain "damage $seed: $(tail -n 1 messages)"
	[ "$(grep -c 'CRC mismatch\|damaged header' messages)" = 5 ] || complain "damage $seed: not five messages"
	grep -q '^sbf2csv: 995 more messages like these' messages || complain "damage $seed: the others are not counted"
done

# Foreign bytes between blocks cost none of them, but are said: false headers, noise, zeros, NMEA.
"$sbf2csv" -t obs < "$log" > want 2> messages
head -c 64 damaged.sbf | tail -c 37 > noise
printf '$@\1\2\253\017\4\0' > header4
printf '$@\1\2\253\017\374\377' > header65532
head -c 1000 /dev/zero > zeros
printf '$GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,*76\r\n' > nmea
for foreign in noise header4 header65532 zeros nmea; do
	expect 1 "$foreign in front" "$sbf2csv" -t obs < <(cat $foreign "$log") > rows
	cmp want rows || complain "$foreign in front: other rows"
	grep -q " $(wc -c < $foreign) bytes skipped, " messages || complain "$foreign in front: $(tail -n 1 messages)"
	expect 1 "$foreign behind" "$sbf2csv" -t obs < <(cat "$log" $foreign) > rows
	cmp want rows || complain "$foreign behind: other rows"
done

# No log at all. The limit is half a second for each MiB.
for kind in noise longest pairs dollars hopes; do
	mebibytes=16
	[ $kind != noise ] || mebibytes=64
	[ "$SANITIZE" != ON ] || mebibytes=1
	"$TOOLS/storm" $kind $mebibytes > storm
	started=${EPOCHREALTIME/./}
	expect 4 "$kind" "$sbf2csv" -t obs storm > rows
	took=$((${EPOCHREALTIME/./} - started))
	[ "$(wc -l < rows)" -le 1 ] || complain "$kind: $(wc -l < rows) lines"
	[ "$SANITIZE" = ON ] || [ $took -le $((mebibytes * 500000)) ] || complain "$kind: $mebibytes MiB took $took microseconds"
	[ $kind != hopes ] || continue # its good blocks can be listed
	expect 4 "$kind --list" "$sbf2csv" --list -o list storm
	[ ! -e list ] || complain "$kind: an inventory of nothing"
done
rm -f storm damaged.sbf long.sbf stream
exit $failed
