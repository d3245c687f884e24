# Every example of the manual pages, as the reader sees it (mandoc's output, not its input): it succeeds, and it prints
# something or leaves a file behind.
set -u
command -v mandoc > /dev/null || { echo "skipped: no mandoc"; exit 77; }
PATH=$BIN:$PATH
rm -rf work && mkdir work && cd work || exit 1
cp "$SRC/testdata/demo.sbf" flight.sbf
failed=0 count=0

# run PAGE EXAMPLE
run() {
	local status one
	find . -exec touch -d 2000-01-01 {} +
	eval "$2"'; status="${PIPESTATUS[*]}"' > ../printed 2> ../messages < /dev/null
	count=$((count + 1))
	for one in $status; do
		# 141: ended by SIGPIPE, because the reader (head) had seen enough
		[ "$one" = 0 ] || [ "$one" = 141 ] || { echo "$1: exit status $one: $2"; cat ../messages; failed=1; }
	done
	if [ ! -s ../printed ] && [ -z "$(find . -type f -newermt 2001-01-01 -size +0)" ]; then
		echo "$1: printed nothing, left nothing behind: $2"
		failed=1
	fi
}

for page in "$SRC"/man/*; do
	while IFS= read -r example; do
		run "$(basename "$page")" "$example"
	done < <(mandoc -T ascii -O width=400 "$page" | sed -n 's/^ *\$ //p')
done
[ $count -ge 5 ] || { echo "only $count examples found"; failed=1; }
exit $failed
