# Each system call on files fails in its turn, is interrupted, or does less than it was asked for.
set -u
. "$SRC/tests/common.bash"
gzip -c "$log" > log.gz

preload() {
	LD_PRELOAD=$FAULTS/fail_io.so IO_DONE=done "$@"
}

# fail_each SHORT ARGUMENT...: with reads and writes of at most SHORT bytes, so that there are many.
fail_each() {
	local short=$1 call error n what
	shift
	reference "$sbf2csv" "$@"
	for call in open read write fsync close rename mkdir; do
		for error in EIO ENOSPC; do
			[ $call-$error = read-ENOSPC ] && continue
			# Of several tables the first may have their names when the last one's rename fails.
			[ $call = rename ] && WHOLE=1 || WHOLE=
			n=0
			touch done
			while [ -e done ]; do
				n=$((n + 1))
				rm done
				what="$call $n ($error, $short bytes at once) of $*"
				IO_SHORT=$short IO_CALL=$call IO_NTH=$n IO_ERRNO=$error attempt "$what" preload "$sbf2csv" "$@"
			done
		done
	done
}

# same WHAT ARGUMENT...: must not make a difference.
same() {
	local what=$1
	shift
	attempt "$what: $*" preload "$sbf2csv" "$@"
	[ -s want.printed ] || diff -r want out > /dev/null || complain "$what: not complete: $*: $(head -n 1 messages)"
}

disturb_each() {
	local short n
	reference "$sbf2csv" "$@"
	for short in 1 7 4093; do
		IO_SHORT=$short same "$short bytes at once" "$@"
	done
	IO_STORM=1 same "EINTR at every second call" "$@"
	IO_STORM=1 IO_SHORT=7 same "EINTR at every second call, 7 bytes at once" "$@"
	for call in open read write fsync close; do
		n=0
		touch done
		while [ -e done ]; do
			n=$((n + 1))
			rm done
			IO_CALL=$call IO_NTH=$n IO_ERRNO=EINTR same "EINTR at $call $n" "$@"
		done
	done
}

for arguments in "-t obs -o out/table" "-s -o out/stream" "-f lcm -o out/log" "--list -o out/list" "-t pvt" "--split out" "-f rinex --split out"; do
	fail_each 8191 $arguments "$log"
	disturb_each $arguments "$log"
done
fail_each 8191 -s -o out/stream log.gz
disturb_each -s -o out/stream log.gz
fail_each 240 -s -o out/stream "$log"
fail_each 240 -s "$log"
exit $failed
