# A dozen of the cases of tests/faults/fuse_faults.sh, one of each kind.
[ -x "$PYTHON" ] || { echo "skipped: needs build/venv (make test makes it)"; exit 77; }
exec "$PYTHON" "$SRC/tests/faults/fuse_faults.py" \
	"imu middle 1 gyro_x_radps nan" "imu middle 1 accel_z_mps2 1e30" "pvt middle 1 lat_deg 1e30" "pvt middle 1 cov_nn_m2 -0" \
	"imu duplicate with other values" "imu one 0.000000001 s back" "imu 10 rows 5 s back" "pvt short row" \
	"fix middle 1 degree off, variance 0.0001" "fix 5% outliers of 0.001 degrees" "fix all variances 0" \
	"cover imu gap of 5 s" "cover outage of 60 s" "cover first imu, then gnss" "monitor dop 1 hpl_m nan"
