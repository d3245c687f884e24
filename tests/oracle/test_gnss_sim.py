#!/usr/bin/env python3
"""What gnss-sim makes is what a receiver would: independent programs read it and find the truth in it.

pysbf2 1.0.7   parses every block of rover.sbf and base.sbf; counts and some values agree with the scenario
convbin        (Debian's rtklib 2.4.3) makes RINEX of both without a word of complaint, all epochs, all satellites
rnx2rtkp       (the same) finds the antenna: single, from convbin's RINEX and from gnss-sim's own, with each system and with
               all; kinematic against the base with integers fixed on at least 99 % of the epochs of open sky

Expected sizes of errors follow from what the scenario says. Single point: orbit and clock 0.5 m, ionosphere a quarter of the
model, multipath and noise below 0.5 m, times DOPs of about 1 (horizontal) and 1.5 (vertical) with all systems: below 2 m and
3 m RMS; the receiver's own sigmas are those that the errors were drawn with. Kinematic: carriers have 1 to 2 mm of noise
and multipath, which DOP and differencing make 1 to 4 mm. The wet troposphere between base and a drone 60 m higher, which
rnx2rtkp leaves out, is 4 mm at the zenith, up to 2 cm in height.

Without any errors what is left are the models' differences and the steps in which messages are sent: some centimetres of
orbits, some decimetres of GLONASS's.

Not compared: Galileo from convbin's navigation file, which has the message's type where RINEX has the data source, so that
rnx2rtkp refuses it; BeiDou's, which convbin does not take from BDSNav.
"""
import csv
import os
import pathlib
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True  # leave nothing in the source tree
import numpy
import pysbf2

BIN = pathlib.Path(os.environ["BIN"])
SRC = pathlib.Path(os.environ["SRC"])
SKIPPED = 77
LEVER = [0.05, 0, -0.2]  # of the scenario farm
SECONDS = 300
OPEN_SKY = ["--set", "mask tree-line.station=none"]
SINGLE = "pos1-posmode=single\npos1-frequency=l1\npos1-ionoopt=brdc\n"
KINEMATIC = "pos1-posmode=kinematic\npos1-frequency=l1+l2+l5\npos1-ionoopt=brdc\npos2-armode=continuous\npos2-gloarmode=on\n"
COMMON = (
    "pos1-elmask=10\npos1-tropopt=saas\nout-solformat=llh\nout-timesys=gpst\nout-timeform=tow\nout-outhead=off\n"
    "out-timendec=3\n"
)
SYSTEMS = {"GPS": 1, "GLONASS": 4, "Galileo": 8, "BeiDou": 32, "all": 45}


def run(*command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)


def table(kind, path):
    made = run(BIN / "sbf2csv", "-q", "-t", kind, path)
    assert made.returncode == 0, made.stderr
    return list(csv.DictReader(made.stdout.splitlines()))


def column(rows, name):
    return numpy.array([float(row[name]) for row in rows])


# ---- truth ----


def ecef(lat, lon, height):
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)
    n = a / numpy.sqrt(1 - e2 * numpy.sin(lat) ** 2)
    horizontal = (n + height) * numpy.cos(lat)
    return numpy.stack([horizontal * numpy.cos(lon), horizontal * numpy.sin(lon), (n * (1 - e2) + height) * numpy.sin(lat)], -1)


def ned_axes(lat, lon):
    """Columns north, east, down, one matrix for each place."""
    sl, cl, so, co = numpy.sin(lat), numpy.cos(lat), numpy.sin(lon), numpy.cos(lon)
    axes = [[-sl * co, -so, -cl * co], [-sl * so, co, -cl * so], [cl, 0 * sl, -sl]]
    return numpy.array(axes).transpose(2, 0, 1)


class Truth:
    """The antenna's place, from truth.csv and the lever arm."""

    def __init__(self, folder):
        rows = list(csv.DictReader(open(folder / "truth.csv")))
        self.t = column(rows, "tow_s")
        lat, lon = numpy.radians(column(rows, "lat_deg")), numpy.radians(column(rows, "lon_deg"))
        r, p, y = (numpy.radians(column(rows, f"{name}_deg")) for name in ("roll", "pitch", "heading"))
        cr, sr, cp, sp, cy, sy = (f(x) for x in (r, p, y) for f in (numpy.cos, numpy.sin))
        turn = numpy.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                            [-sp, cp * sr, cp * cr]]).transpose(2, 0, 1)  # fmt: skip
        self.axes = ned_axes(lat, lon)
        arm = numpy.einsum("nij,nj->ni", self.axes, turn @ numpy.array(LEVER))
        self.place = ecef(lat, lon, column(rows, "height_m")) + arm

    def errors(self, t, lat_deg, lon_deg, height):
        """North, east, down."""
        there = numpy.stack([numpy.interp(t, self.t, self.place[:, k]) for k in range(3)], -1)
        miss = ecef(numpy.radians(lat_deg), numpy.radians(lon_deg), height) - there
        return numpy.einsum("nji,nj->ni", self.axes[numpy.searchsorted(self.t, t).clip(0, len(self.t) - 1)], miss)


# ---- the programs ----


def check_pysbf2(log, epochs):
    counts = {}
    with open(log, "rb") as stream:
        for raw, message in pysbf2.SBFReader(stream, protfilter=2, quitonerror=2):
            assert message is not None, raw[:16]
            counts[message.identity] = counts.get(message.identity, 0) + 1
            if message.identity == "PVTGeodetic" and message.Type in (1, 6):
                assert abs(message.Latitude - numpy.radians(52.05)) < 1e-3, message
                assert message.NrSV > 10, message
    for name in ("MeasEpoch", "EndOfMeas", "PVTGeodetic", "PosCovGeodetic", "VelCovGeodetic", "DOP", "EndOfPVT"):
        assert counts.get(name) == epochs, (log, name, counts)
    for name in ("GPSNav", "GALNav", "BDSNav", "GLONav", "GPSIon", "GPSUtc", "ReceiverSetup", "ReceiverTime"):
        assert counts.get(name, 0) > 0, (log, name, counts)
    listed = run(BIN / "sbf2csv", "--list", log)
    mine = {row["name"]: int(row["count"]) for row in csv.DictReader(listed.stdout.splitlines())}
    assert mine == counts, (mine, counts)
    print(f"pysbf2: {log}: {sum(counts.values())} blocks of {len(counts)} kinds")


def check_convbin(log, name, epochs):
    """Returns the observation and the navigation file."""
    made = run("convbin", "-r", "sbf", "-v", "3.04", "-od", "-os", "-f", "5", "-o", f"{name}.obs", "-n", f"{name}.nav", log)
    assert made.returncode == 0, made.stderr
    last = made.stderr.replace("\r", "\n").strip().splitlines()[-1]
    assert f"O={epochs} " in last and "E=" not in last, last
    for word in ("error", "warn", "invalid"):
        assert word not in (made.stdout + made.stderr).lower(), (word, last)
    rows = sum(1 for line in open(f"{name}.obs") if line[:1] in "GREC" and line[1:3].isdigit() and len(line) > 20)
    # convbin knows BeiDou up to C37
    satellites = {(row["gps_week"], row["tow_s"], row["sat"]) for row in table("obs", log) if row["sat"] < "C38" or row["sat"] > "D"}
    assert rows == len(satellites), (rows, len(satellites))
    print(f"convbin: {log}: {epochs} epochs, {rows} rows of satellites")
    return f"{name}.obs", f"{name}.nav"


def solve(settings, systems, options, files):
    pathlib.Path("rtk.conf").write_text(COMMON + settings + f"pos1-navsys={systems}\n")
    made = run("rnx2rtkp", "-k", "rtk.conf", *options, "-o", "out.pos", *files)
    assert made.returncode == 0, made.stderr[-300:]
    lines = [line.split() for line in open("out.pos") if not line.startswith("%")]
    return numpy.array([[float(x) for x in line[1:7]] for line in lines]).reshape(-1, 6)


def rms(x):
    return numpy.sqrt(numpy.mean(numpy.square(x), axis=0))


def check_single(truth, files, systems, epochs):
    rows = solve(SINGLE, SYSTEMS[systems], [], files)
    assert len(rows) == epochs, (systems, len(rows), epochs)
    errors = truth.errors(*rows[:, :4].T)
    north, east, down = rms(errors)
    # fewer satellites, weaker geometry: GLONASS alone has a DOP of 3 and worse
    slack = 1 if systems == "all" else 3
    assert numpy.hypot(north, east) < 2 * slack and down < 3 * slack, (systems, files[0], rms(errors))
    assert numpy.hypot(north, east) > 0.02, "too good to be simulated"
    print(f"rnx2rtkp single: {files[0]}, {systems}: {len(rows)} epochs, RMS N {north:.2f} E {east:.2f} D {down:.2f} m")


def check_kinematic(truth, files, systems, epochs, base):
    rows = solve(KINEMATIC, SYSTEMS[systems], ["-l", *base], files)
    fixed = rows[:, 4] == 1
    assert len(rows) == epochs and fixed.mean() >= 0.99, (systems, len(rows), fixed.mean())
    errors = truth.errors(*rows[fixed, :4].T)
    north, east, down = rms(errors)
    assert 0.0003 < north < 0.006 and 0.0003 < east < 0.006, rms(errors)
    assert abs(errors[:, 2].mean()) < 0.025 and errors[:, 2].std() < 0.012, (errors[:, 2].mean(), errors[:, 2].std())
    assert numpy.abs(errors[:, :2]).max() < 0.04, numpy.abs(errors).max(axis=0)
    print(
        f"rnx2rtkp kinematic: {files[0]}, {systems}: {100 * fixed.mean():.1f} % of {len(rows)} fixed, "
        f"RMS N {1e3 * north:.1f} E {1e3 * east:.1f} D {1e3 * down:.1f} mm"
    )


def check_receiver(truth, log, epochs):
    """The receiver's own solution: errors of the size that it claims."""
    rows = table("pvt", log)
    errors = truth.errors(*(column(rows, name) for name in ("tow_s", "lat_deg", "lon_deg", "height_m")))
    claimed = numpy.stack([column(rows, f"sd_{axis}_m") for axis in "ned"], -1)
    ratio = rms(errors / claimed)
    assert len(rows) == epochs and (ratio < 2.5).all() and (ratio > 0.1).all(), ratio
    levels = table("dop", log)
    outside = (numpy.hypot(errors[:, 0], errors[:, 1]) > column(levels, "hpl_m")) | (
        numpy.abs(errors[:, 2]) > column(levels, "vpl_m")
    )
    assert not outside.any()
    print(f"receiver: error / sigma N {ratio[0]:.2f} E {ratio[1]:.2f} D {ratio[2]:.2f}, all within protection levels")


def check_without_errors():
    """All error sizes 0: another program's models of orbits, clocks, delays and Sagnac find the same place.

    Above 20 degrees: below, its troposphere (1 / sin of the elevation) differs from Niell's by decimetres."""
    folder = pathlib.Path("perfect")
    shutil.rmtree(folder, ignore_errors=True)
    zero = ["sky.radial_m", "sky.along_m", "sky.cross_m", "sky.clock_m", "sky.iono_pct", "sky.tropo_m", "gnss.multipath_m"]
    settings = [x for key in zero for x in ("--set", f"{key}=0")]
    settings += ["--set", "gnss.dll_hz=0.0001", "--set", "gnss.rate_hz=1", "--set", "scenario.duration_s=60", "--rinex"]
    made = run(BIN / "gnss-sim", SRC / "testdata/scenarios/farm.ini", "-o", folder, *settings)
    assert made.returncode == 0, made.stderr
    truth = Truth(folder)
    for systems, limit in (("Galileo", 0.1), ("BeiDou", 0.12), ("GPS", 0.15), ("GLONASS", 0.5), ("all", 0.15)):
        rows = solve(SINGLE + "pos1-elmask=20\n", SYSTEMS[systems], [], (folder / "rover/obs.rnx", folder / "rover/nav.rnx"))
        errors = numpy.abs(truth.errors(*rows[:, :4].T))
        assert len(rows) == 61 and errors.max() < limit, (systems, len(rows), errors.max(axis=0))
        print(f"rnx2rtkp single, no errors simulated: {systems}: largest error {errors.max():.3f} m")


def main():
    for program in ("convbin", "rnx2rtkp"):
        if shutil.which(program) is None:
            print(f"skipped: no {program}")
            return SKIPPED
    folder = pathlib.Path("farm")
    shutil.rmtree(folder, ignore_errors=True)
    settings = ["--set", f"scenario.duration_s={SECONDS}", *OPEN_SKY, "--rinex", "--set", "gnss.rate_hz=2"]
    made = run(BIN / "gnss-sim", SRC / "testdata/scenarios/farm.ini", "-o", folder, *settings)
    assert made.returncode == 0, made.stderr
    epochs = 2 * SECONDS + 1
    rover, base = folder / "rover.sbf", folder / "base.sbf"
    truth = Truth(folder)

    check_without_errors()
    check_pysbf2(rover, epochs)
    check_pysbf2(base, SECONDS + 1)
    theirs = check_convbin(rover, "rover", epochs)
    theirs_base = check_convbin(base, "base", SECONDS + 1)
    ours = folder / "rover/obs.rnx", folder / "rover/nav.rnx"
    check_receiver(truth, rover, epochs)
    for systems in ("GPS", "GLONASS"):
        check_single(truth, theirs, systems, epochs)
    for systems in SYSTEMS:
        check_single(truth, ours, systems, epochs)
    marker = table("setup", base)[0]
    place = [marker[name] for name in ("lat_deg", "lon_deg", "height_m")]
    check_kinematic(truth, (theirs[0], theirs_base[0], theirs[1]), "GPS", epochs, place)
    for systems in ("GPS", "all"):
        check_kinematic(truth, (ours[0], folder / "base/obs.rnx", ours[1]), systems, epochs, place)
    return 0


sys.exit(main())
