# The tests of the papers with a few flights each: that they run, and that the figures with room to spare are reached.
if [ "$SANITIZE" = ON ]; then
	echo "skipped: hundreds of flights take too long with sanitizers"
	exit 77
fi
exec sh "$SRC/scripts/oracle.sh" "$SRC/tests/papers/papers.py" --bin "$BIN" --campaign "$TOOLS/campaign" -o report --quick
