# insgnss-fuse and pl-monitor on damaged input, against the truth of simulated flights: see fuse_faults.py.
[ -x "$PYTHON" ] || { echo "skipped: needs build/venv (make check makes it)"; exit 77; }
exec "$PYTHON" "$SRC/tests/faults/fuse_faults.py"
