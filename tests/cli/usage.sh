# What is asked for wrongly: exit status 2, nothing on standard output, and a message that names what is near.
. "$SRC/tests/cli/case.bash"

# refused MESSAGE ARGUMENT...
refused() {
	local message=$1
	shift
	gives 2 "$@" "$log"
	says "sbf2csv: $message"
	no_output
	[ "$(wc -l < err)" = 1 ] || complain "more than one line of message: $*"
}

refused "unknown option or key 'tipes'; did you mean 'types'?" --tipes pvt
refused "unknown option or key 'quite'; did you mean 'quiet'?" --quite
refused "unknown option '-Z'" -Z
refused "option '--quiet=3' takes no argument" --quiet=3
refused "--types: no record type 'pvtt'; did you mean 'pvt'?" -t pvtt
refused "--types: no record type 'evnet'; did you mean 'event'?" -t pvt,evnet -s
refused "--types: no record type 'eph'; did you mean 'eph_" -t eph
refused "--types: no record type 'xyzzyxyzzy'; furrow-stream(5) lists all" -t xyzzyxyzzy
refused "--types: no type given" -t ''
refused "a table holds one type; add -s" -t pvt,dop
refused "--antenna: 'man' is not one of main|aux1|aux2|all" --antenna man
refused "--nav: 'both|raw' is not one of" --nav 'both|raw'
refused "--format: 'json' is not one of csv|lcm|rinex" -f json
refused "--every: '0' is not a number from 0.001 to 604800" --every 0
refused "--every: '1s' is not a number" --every 1s
refused "--every: 'nan' is not a number" --every nan
refused "--every: '' is not a number" --every ''
refused "--from: 'yesterday' is no time; write WEEK:SECONDS" --from yesterday
refused "--until: '2422:700000' is no time" --until 2422:700000
refused "--until: '2026-02-30T00:00:00' is no time" --until 2026-02-30T00:00:00
refused "--set: 'quiet' is not KEY=VALUE" --set quiet
refused "--set: unknown option or key 'tpyes'; did you mean 'types'?" --set tpyes=pvt
refused "--set: quiet: 'maybe' is neither yes nor no" --set quiet=maybe
refused "--output, --split" --split tables -o file

gives 2 -o
says "option '-o' needs an argument"
gives 2 "$log" --every
says "option '--every' needs an argument"

# Nothing was made on the way.
[ "$(ls)" = "$(printf 'err\nout')" ] || complain "left behind: $(ls)"

gives 0 --help
prints "usage: sbf2csv [options] [FILE...]"
silent
gives 0 -V
grep -qxE 'sbf2csv \(furrow\) [0-9]+\.[0-9]+\.[0-9]+' out || complain "version: $(cat out)"
gives 0 "$log" -h --every 3
prints "usage:"
finish
