#!/usr/bin/env python3
"""insgnss-fuse on real logs, by the commands of its manual page, against what is known better.

walk_0827 (hand-held, RTK positions at 4 Hz): positions are withheld for 5, 10 and 20 s, all along the log; the error is that at the
window's last withheld RTK position, and the largest within the window. thor_flight75 (a small aeroplane, 1 Hz): positions
withheld for 10, 30 and 60 s in flight; attitude against the onboard filter's, with the magnetometer. spirent_dynamic:
positions by virtualite-ls from the signal simulator's observations, an IMU that gnss-sim makes along its exact trajectory,
which is the truth.
"""

import datetime
import os
import pathlib
import subprocess
import sys

sys.dont_write_bytecode = True  # leave nothing in the source tree
import numpy

sys.path.insert(0, str(pathlib.Path(os.environ["SRC"]) / "tests" / "papers"))
import solution

BIN = pathlib.Path(os.environ["BIN"])
DATA = pathlib.Path(os.environ["FURROW_DATA"])
SKIPPED = 77
failures = 0


def run(name, *arguments):
    done = subprocess.run([BIN / name, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"{name} {' '.join(map(str, arguments))}: exit status {done.returncode}: {done.stderr}")


def expect(good, what):
    global failures
    if not good:
        print(f"  FAILED: {what}")
        failures += 1


def at_antenna(s, lever):
    """The solution moved from the IMU to a point of the body."""
    roll, pitch, heading = (numpy.radians(s[n]) for n in solution.DEGREES)
    cr, sr, cp, sp, ch, sh = (f(a) for a in (roll, pitch, heading) for f in (numpy.cos, numpy.sin))
    x, y, z = lever
    north = ch * cp * x + (ch * sp * sr - sh * cr) * y + (ch * sp * cr + sh * sr) * z
    east = sh * cp * x + (sh * sp * sr + ch * cr) * y + (sh * sp * cr - ch * sr) * z
    down = -sp * x + cp * sr * y + cp * cr * z
    per_lat, per_lon = solution.radii(numpy.radians(s["lat_deg"]), s["height_m"])
    return {"t": s["t"], "lat_deg": s["lat_deg"] + numpy.degrees(north / per_lat),
            "lon_deg": s["lon_deg"] + numpy.degrees(east / per_lon), "height_m": s["height_m"] - down}


def errors_at(s, reference):
    """Distance from the solution, interpolated, to each position of the reference within its time."""
    inside = (reference["t"] >= s["t"][0]) & (reference["t"] <= s["t"][-1])
    t = reference["t"][inside]
    r = {n: reference[n][inside] for n in ("lat_deg", "lon_deg", "height_m")}
    lat, lon, height = (numpy.interp(t, s["t"], s[n]) for n in ("lat_deg", "lon_deg", "height_m"))
    per_lat, per_lon = solution.radii(numpy.radians(r["lat_deg"]), r["height_m"])
    return t, numpy.sqrt((numpy.radians(lat - r["lat_deg"]) * per_lat) ** 2
                         + (numpy.radians(lon - r["lon_deg"]) * per_lon) ** 2 + (height - r["height_m"]) ** 2)


def outages(fuse, reference, lever, every, length, first):
    """Errors at the last position of each window of withheld ones, and the largest in it; forward and smoothed."""
    found = {}
    for way in ("none", "rts"):
        fuse("--withhold", f"{every}:{length}:{first}", "--smooth", way, "-o", "withheld.csv")
        t, e = errors_at(at_antenna(solution.read_solution("withheld.csv"), lever), reference)
        begins = reference["t"][0] + first
        rows = []
        while begins + length <= t[-1]:
            window = e[(t > begins - 1e-6) & (t < begins + length - 1e-6)]
            if len(window) > 0:
                rows.append([window[-1], window.max()])
            begins += every
        found[way] = numpy.array(rows)
    return found


def show_outages(name, fuse, reference, lever, plans, firsts, most):
    for (every, length), limit in zip(plans, most):
        all_of = [outages(fuse, reference, lever, every, length, f) for f in firsts]
        forward, smoothed = (numpy.concatenate([o[w] for o in all_of]) for w in ("none", "rts"))
        f, s = ([solution.rms(x[:, k]) for k in range(2)] for x in (forward, smoothed))
        print(f"  {name}, {length:2.0f} s withheld, {len(forward):2d} windows: RMS at the end {f[0]:6.2f} -> {s[0]:5.2f} m smoothed, "
              f"largest within {f[1]:6.2f} -> {s[1]:5.2f} m")
        expect(f[0] <= limit, f"{name}: {length} s: more than {limit} m at the end")
        expect(s[0] <= f[0] / 2 and s[1] <= f[1] / 2, f"{name}: {length} s: smoothed is more than half")


# ---- walk_0827 ----

WALK = DATA / "ins" / "walk_0827"
WALK_LEVER = (0, 0.05, 0)
WALK_OPTIONS = ["--imu", WALK / "imu_1730_sf.csv", "--imu-columns", "time=1 ax=2:g ay=3:g az=4:g gx=5 gy=6 gz=7", "--imu-time",
                "unix-gps", "--imu-roll", 180, "--imu-yaw", -90, "--lever-x", 0, "--lever-y", 0.05, "--lever-z", 0, "--imu-grade",
                "mems", "--gyro-noise", 2, "--accel-noise", 1400, "--position-floor", 0.02, "--velocity-floor", 0.1]


def rtk_positions():
    rows = [line.split() for line in (WALK / "gnss_1730_sf.pos").read_text().splitlines() if line[0] != "%"]
    epoch = datetime.datetime(1980, 1, 6)
    times = [datetime.datetime.strptime(f"{r[0]} {r[1]}", "%Y/%m/%d %H:%M:%S.%f") for r in rows]
    place = numpy.array([[float(v) for v in r[2:5]] for r in rows])
    return {"t": numpy.array([(t - epoch).total_seconds() for t in times]), "lat_deg": place[:, 0], "lon_deg": place[:, 1],
            "height_m": place[:, 2]}


def test_walk():
    def fuse(*more):
        run("insgnss-fuse", "-q", WALK / "gnss_1730_sf.pos", *WALK_OPTIONS, *more)

    print("walk_0827:")
    show_outages("walk", fuse, rtk_positions(), WALK_LEVER, [(15, 5), (25, 10), (40, 20)], (12, 17, 22), (1, 3, 8))


# ---- thor_flight75 ----

THOR = DATA / "ins" / "thor_flight75" / "thor_flight75.csv.gz"
THOR_MAP = ("time=time gx=p gy=q gz=r ax=ax ay=ay az=az mx=hx:1 my=hy:1 mz=hz:1 lat=lat lon=lon height=alt vn=vn ve=ve vd=vd "
            "nsats=satVisible fixtime=GPS_TOW")
THOR_TIME = ["--imu-time", "boot,week=1709"]
THOR_OPTIONS = ["--imu-columns", THOR_MAP, *THOR_TIME, "--imu-grade", "consumer"]
THOR_COMPASS = ["--compass", "yes", "--compass-calibration", "log", "--compass-sd", 10]
THOR_ONBOARD = THOR_MAP + (" nlat=navlat:rad nlon=navlon:rad nheight=navalt nvn=navvn nve=navve nvd=navvd roll=phi:rad "
                           "pitch=theta:rad heading=psi:rad")
# In the air, seconds of week, away from take-off and landing.
THOR_FLIGHT = (319780, 320160)


def test_thor():
    def fuse(*more):
        run("insgnss-fuse", "-q", THOR, *THOR_OPTIONS, *more)

    def in_flight(table):
        keep = (table["tow_s"] > THOR_FLIGHT[0]) & (table["tow_s"] < THOR_FLIGHT[1])
        return {n: v[keep] for n, v in table.items()}

    print("thor_flight75:")
    run("sbf2csv", "-q", "-t", "nav", "--imu-columns", THOR_ONBOARD, *THOR_TIME, THOR, "-o", "onboard.csv")
    run("sbf2csv", "-q", "-t", "pos", "--imu-columns", THOR_MAP, *THOR_TIME, THOR, "-o", "gps.csv")
    onboard, gps = in_flight(solution.read_solution("onboard.csv")), solution.read_solution("gps.csv")
    for name, more in (("with magnetometer", THOR_COMPASS), ("without", []), ("smoothed", [*THOR_COMPASS, "--smooth", "rts"])):
        fuse(*more, "-o", "thor.csv")
        e = solution.errors(solution.read_solution("thor.csv"), onboard)
        angles = [solution.rms(e["rpy"][:, k]) for k in range(3)]
        print(f"  attitude against the onboard filter, {name}: roll {angles[0]:.2f}, pitch {angles[1]:.2f}, heading {angles[2]:.2f} deg RMS")
        expect(max(angles) <= 3, f"thor: attitude, {name}")
    first = THOR_FLIGHT[0] - gps["tow_s"][0]
    until = {n: v[gps["tow_s"] < THOR_FLIGHT[1]] for n, v in gps.items()}
    show_outages("thor", lambda *more: fuse(*THOR_COMPASS, *more), until, (0, 0, 0), [(40, 10), (75, 30), (110, 60)],
                 (first, first + 20), (20, 150, 500))


# ---- spirent_dynamic ----

SPIRENT = DATA / "rtk" / "spirent_dynamic"
ROSE = """[trajectory]
table = truth.csv
[imu]
grade = {grade}
[base]
present = no
[magnetometer]
rate_hz = 0
[barometer]
rate_hz = 0
"""


def spirent_truth():
    """truth_motion.csv as a nav table: angles in rad, velocity in ECEF there."""
    t = numpy.loadtxt(SPIRENT / "truth_motion.csv", delimiter=",", skiprows=2)
    lat, lon = t[:, 13], t[:, 14]
    outward = numpy.cos(lon) * t[:, 4] + numpy.sin(lon) * t[:, 5]
    north = numpy.cos(lat) * t[:, 6] - numpy.sin(lat) * outward
    east = numpy.cos(lon) * t[:, 5] - numpy.sin(lon) * t[:, 4]
    down = -(numpy.cos(lat) * outward + numpy.sin(lat) * t[:, 6])
    with open("truth.csv", "w") as out:
        print("gps_week,tow_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,heading_deg", file=out)
        for k in range(len(t)):
            a = numpy.degrees([lat[k], lon[k], t[k, 18], t[k, 17], t[k, 16] % (2 * numpy.pi)])
            print(f"2244,{36000 + t[k, 0] / 1000:.1f},{a[0]:.9f},{a[1]:.9f},{t[k, 15]:.4f},{north[k]:.4f},{east[k]:.4f},{down[k]:.4f},"
                  f"{a[2]:.9f},{a[3]:.9f},{a[4]:.9f}", file=out)


def test_spirent():
    print("spirent_dynamic:")
    spirent_truth()
    run("virtualite-ls", "-q", SPIRENT / "rover.obs", SPIRENT / "gps.nav", SPIRENT / "gal.nav", "-o", "gnss.csv")
    truth, gnss = solution.read_solution("truth.csv"), solution.read_solution("gnss.csv")
    alone = solution.rms(errors_at({n: gnss[n] for n in ("t", "lat_deg", "lon_deg", "height_m")}, truth)[1])
    for grade, most_m, most_deg in (("industrial", 0.1, 3), ("tactical", 0.1, 1)):
        pathlib.Path("rose.ini").write_text(ROSE.format(grade=grade))
        run("gnss-sim", "rose.ini", "-q", "-o", "rose")
        found = {}
        for way in ("none", "rts"):
            run("insgnss-fuse", "-q", "gnss.csv", "--imu", "rose/imu.csv", "--imu-grade", grade, "--lever-x", 0, "--lever-y", 0,
                "--lever-z", 0, "--smooth", way, "-o", "rose.csv")
            e = solution.errors(solution.read_solution("rose.csv"), truth)
            found[way] = [solution.rms(numpy.linalg.norm(e["ned"], axis=1)), solution.rms(e["rpy"][:, 2]), solution.rms(e["rpy"][:, 0])]
        f, s = found["none"], found["rts"]
        print(f"  {grade} IMU: position {alone:.3f} m by GNSS alone, {f[0]:.3f} -> {s[0]:.3f} m smoothed; heading {f[1]:.2f} -> {s[1]:.2f} deg, "
              f"roll {f[2]:.3f} -> {s[2]:.3f} deg RMS")
        expect(f[0] <= most_m and s[0] <= f[0], f"spirent, {grade}: position")
        expect(f[1] <= most_deg and s[1] <= f[1], f"spirent, {grade}: heading")


def main():
    tests = [(WALK, test_walk), (THOR, test_thor), (SPIRENT, test_spirent)]
    there = [test for folder, test in tests if folder.exists()]
    if not there:
        print(f"skipped: none of the real logs in {DATA}")
        return SKIPPED
    for test in there:
        test()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
