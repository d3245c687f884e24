#!/usr/bin/env python3
"""insgnss-fuse on damaged input: simulated flights whose truth is known, one fault at a time.

Every case has to end in good time with the exit status that fits, without a number that is none, and without a row that is
more than five of its own standard deviations from the truth. What was refused is counted. Thirty seconds after a single bad
record the solution is the clean one again, within half a standard deviation; after a longer fault it is as far off as its own
covariance says.

    fuse_faults.py [-v] [NAME...]      all cases, or those whose names begin with one of the texts; -v: a line for each
"""
import math
import os
import pathlib
import struct
import subprocess
import sys
import time

sys.dont_write_bytecode = True  # leave nothing in the source tree
import numpy

from damage_tables import Table, sbf_blocks, sbf_put

BIN = pathlib.Path(os.environ["BIN"])
SANITIZE = os.environ.get("SANITIZE") == "ON"
SLOW, EVERY = (10, 12) if SANITIZE else (1, 1)  # with sanitizers a sample of the cases is enough
VERBOSE = "-v" in sys.argv[1:]
WORDS = [word for word in sys.argv[1:] if word != "-v"]

FLIGHT = """
[scenario]
start = 2422:288000
[trajectory]
waypoint = 0 0 0 1 10
waypoint = 0 0 30 3
waypoint = 80 0 30 5
waypoint = 80 50 30 5
waypoint = 0 50 30 5
waypoint = 0 0 30 5
waypoint = 80 0 30 5
waypoint = 80 50 30 5 10
[imu]
gyro_misalignment_mrad = 0
accel_misalignment_mrad = 0
[gnss]
lever_m = 0.3 0.1 -0.2
[attitude]
baseline_m = -1 0 0
[pvt]
mode = sbas
section_s = 10000
horizontal_m2 = 1
vertical_m2 = 2
horizontal_m2ps2 = 0.01
vertical_m2ps2 = 0.02
[base]
present = no
"""

# A minute before and after the end of a week: an ordinary one, and those at which ten bits of week roll over.
ROLLOVER = {week: FLIGHT.replace("2422:288000", f"{week}:604740") for week in (2421, 1023, 2047)}

# Errors of fixes that stay a while, which is what protection levels and --adapt gm are made for.
CORRELATED = FLIGHT.replace("section_s = 10000", "section_s = 10000\nsection_tau_s = 30")

# More than an hour there and back. Slow sensors make a short log of it.
ROUND = FLIGHT[FLIGHT.index("waypoint = 80 0"):FLIGHT.index("[imu]")]
LONG = (FLIGHT.replace(ROUND, "rows = 30 40 30 0 400 40 56 6 3\n")
        .replace("[imu]", "[imu]\nrate_hz = 20").replace("[gnss]", "[gnss]\nrate_hz = 1"))

OPTIONS = "--rate 10 --lever-x 0.3 --lever-y 0.1 --lever-z -0.2".split()
SMOOTH = ["--smooth", "rts"]

failures = n_cases = n_names = 0


def complain(name, text):
    global failures
    failures += 1
    print(f"{name}: {text}")


# ---- solutions and truth ----

NAMES = "lat_deg lon_deg height_m vn_mps ve_mps vd_mps roll_deg pitch_deg heading_deg".split()


class Nav:
    """Times, the nine values of NAMES, their standard deviations."""

    def __init__(self, text):
        rows = numpy.loadtxt(text.splitlines()[1:], delimiter=",", usecols=range(20), ndmin=2)
        self.t = rows[:, 0] * 604800 + rows[:, 1]
        self.values, self.sd = rows[:, 2:11], rows[:, 11:20]


def difference(a, b):
    """a - b in metres, m/s, degrees."""
    d = a - b
    d[:, 0] *= 111.2e3
    d[:, 1] *= 111.2e3 * math.cos(math.radians(52.05))
    d[:, 8] = (d[:, 8] + 180) % 360 - 180
    return d


class Flight:
    """A simulated flight: its tables, its truth, and its clean solution by each set of options."""

    def __init__(self, scenario, seed=1, name="flight"):
        self.folder = pathlib.Path(name)
        pathlib.Path(name + ".ini").write_text(scenario)
        subprocess.run([BIN / "gnss-sim", "-q", "--seed", str(seed), name + ".ini", "-o", name], check=True)
        for kind in "pvt", "att":
            self.make(kind, [BIN / "sbf2csv", "-q", "-t", kind, self.folder / "rover.sbf"])
        self.make("pl", [BIN / "pl-monitor", "-q", "--hal", "40", "--val", "50", self.folder / "rover.sbf"])
        self.tables = {}
        rows = numpy.loadtxt((self.folder / "truth.csv").read_text().splitlines()[1:], delimiter=",", usecols=range(11))
        self.t = rows[:, 0] * 604800 + rows[:, 1]
        self.start, self.length = self.t[0], self.t[-1] - self.t[0]
        self.values = rows[:, 2:11]
        self.values[:, 8] = numpy.degrees(numpy.unwrap(numpy.radians(self.values[:, 8])))
        self.clean = {}

    def make(self, kind, command):
        with open(self.folder / (kind + ".csv"), "w") as out:
            subprocess.run(command, stdout=out, check=True)

    def table(self, kind):
        if kind not in self.tables:
            self.tables[kind] = Table((self.folder / (kind + ".csv")).read_text())
        return self.tables[kind]

    def errors(self, nav):
        return difference(nav.values, numpy.stack([numpy.interp(nav.t, self.t, v) for v in self.values.T], axis=1))

    def fuse(self, damaged, options):
        """Runs the tool on the tables, some of them damaged (bytes), or on damaged `sbf` in place of fixes and headings."""
        def file(kind):
            if kind not in damaged:
                return self.folder / (kind + ".csv")
            path = pathlib.Path("damaged." + kind)
            path.write_bytes(damaged[kind])
            return path
        arguments = [BIN / "insgnss-fuse", "-o", "nav.csv", "--imu", file("imu")]
        for option in options:
            arguments += [option] + ([file(option[2:])] if option in ("--mag", "--baro", "--pl") else [])
        arguments += [file("sbf")] if "sbf" in damaged else [file("pvt"), file("att")]
        pathlib.Path("nav.csv").write_text("")
        run = subprocess.run(arguments, capture_output=True, text=True, timeout=20 * SLOW)
        return run, pathlib.Path("nav.csv").read_text()

    def solution(self, options):
        key = " ".join(options)
        if key not in self.clean:
            run, output = self.fuse({}, options)
            if run.returncode != 0:
                complain(key, f"exit {run.returncode}, not 0, of the clean run: {run.stderr}")
            self.clean[key] = Nav(output)
            self.judge(f"clean {key}", self.clean[key])
        return self.clean[key]

    def judge(self, name, nav, blind=None):
        """Nothing is more than five of its own sigmas off."""
        ratio = numpy.abs(self.errors(nav)) / nav.sd
        if blind is not None:
            ratio[(nav.t >= self.start + blind[0]) & (nav.t <= self.start + blind[1])] = 0
        row, column = numpy.unravel_index(numpy.argmax(ratio), ratio.shape)
        if not ratio[row, column] <= 5:
            complain(name, f"{NAMES[column]} is {ratio[row, column]:.1f} sigma off at {nav.t[row] - self.start:.2f} s, "
                           f"{numpy.sum(ratio > 5)} values of {ratio.size}")
        return ratio[row, column]

    def compare(self, name, nav, clean, since, most=0.5):
        """From some time on it is the clean solution, within half a sigma."""
        common, mine, its = numpy.intersect1d(numpy.round((nav.t - self.start) * 1000),
                                              numpy.round((clean.t - self.start) * 1000), return_indices=True)
        late = common > since * 1000
        if not late.any():
            complain(name, f"no row after {since} s")
            return 0
        ratio = numpy.abs(difference(nav.values[mine[late]], clean.values[its[late]])) / clean.sd[its[late]]
        row, column = numpy.unravel_index(numpy.argmax(ratio), ratio.shape)
        if not ratio[row, column] <= most:
            complain(name, f"{NAMES[column]} is {ratio[row, column]:.2f} sigma from the clean run "
                           f"{common[late][row] / 1000 - since:.1f} s later")
        return ratio[row, column]


# ---- one case ----

def is_wanted(name, options):
    global n_names
    n_names += 1
    if WORDS:
        return any(name.startswith(word) for word in WORDS)
    return n_names % (EVERY * (3 if "--smooth" in options else 1)) == 0


def any_wanted(prefix):
    """Whether a flight is needed at all."""
    return not WORDS or any(word.startswith(prefix) or prefix.startswith(word) for word in WORDS)


def case(name, flight, changes, status=1, options=(), says=(), again=None, rows=True, blind=None, most=0.5):
    """Runs and judges one case.
    changes  by table: a function that damages it, or that returns bytes in its place
    status   the exit status that fits, or several
    says     what messages have to hold
    again    when a single fault was, in seconds since the start: it is forgotten 30 s later
    most     so many sigmas from the clean run are forgotten
    rows     whether a solution is expected
    blind    from and until when, in seconds since the start, nothing in the data can tell right from wrong"""
    global n_cases
    if not is_wanted(name, options):
        return None
    n_cases += 1
    before, options, damaged = failures, OPTIONS + list(options), {}
    for kind, change in changes.items():
        table = flight.table(kind).copy() if kind != "sbf" else bytearray((flight.folder / "rover.sbf").read_bytes())
        result = change(table)
        damaged[kind] = result if result is not None else bytes(table) if kind == "sbf" else table.text().encode()
    clean, began = flight.solution(options), time.monotonic()
    try:
        run, output = flight.fuse(damaged, options)
    except subprocess.TimeoutExpired:
        complain(name, "does not end")
        return None
    took = time.monotonic() - began
    if run.returncode not in (status if isinstance(status, tuple) else (status,)):
        complain(name, f"exit {run.returncode}, not {status}")
    if run.returncode == 1 and not run.stderr.strip():
        complain(name, "exit 1 without a message")
    for text in says:
        if text not in run.stderr:
            complain(name, f"does not say '{text}'")
    if "nan" in output.lower() or "inf" in output.lower():
        complain(name, "not a number in the output")
    nav, worst, shift = None, 0, 0
    if output.count("\n") > 1:
        nav = Nav(output)
        worst = flight.judge(name, nav, blind)
        shift = flight.compare(name, nav, clean, again + 30, most) if again is not None else 0
    elif rows:
        complain(name, "no solution")
    if VERBOSE:
        print(f"{'ok  ' if failures == before else 'FAIL'} {name:50} exit {run.returncode} {took:.2f} s worst {worst:.1f} sigma, "
              f"later {shift:.3f} | {' / '.join(run.stderr.splitlines()[1:])[:300]}")
    elif failures > before:
        print("    " + "\n    ".join(run.stderr.splitlines()[-8:]))
    return nav


# ---- numbers that are none, or too large, or too small ----

NONE, HUGE, TINY = ["nan", "-inf"], ["1e30", "-1e30"], ["1e-310", "-0"]
POSITION = ["lat_deg", "lon_deg", "height_m"]


def bad_values(flight, kind, columns, values, where, options=()):
    """where: (place, how many rows) of each case."""
    table = flight.table(kind)
    last = len(table.rows) - 1
    for place, n in where:
        first = {"first": 0, "middle": last // 2, "last": last - n + 1}[place]
        at = table.time(first) - flight.start
        for column in columns:
            for value in values:
                blind = None
                # A hundred fixes that agree are believed in the end (--gate-patience). If all began with them it takes
                # three hundred others to end this.
                if n == 100 and value in TINY and column in POSITION:
                    blind = (at, at + (85 if place == "first" else 40))
                # A zero may be one; a clock that is off by ages is not corrected.
                status = (0, 1) if value in TINY or column == "clock_bias_s" else 1
                case(f"{kind} {place} {n} {column} {value}{' smooth' if options == SMOOTH else ''}", flight,
                     {kind: lambda t: t.fill(first, n, [column], value)}, status, options,
                     again=at if n == 1 and place != "last" else None, blind=blind)


def numbers(flight):
    some, elsewhere = ["nan", "1e30", "-0"], [("first", 1), ("last", 1), ("first", 100), ("middle", 100), ("last", 100)]
    bad_values(flight, "imu", flight.table("imu").columns, NONE + HUGE + TINY, [("middle", 1)])
    bad_values(flight, "imu", ["tow_s", "gyro_z_radps", "accel_z_mps2"], some, elsewhere)
    bad_values(flight, "imu", ["gyro_x_radps", "accel_z_mps2"], some, [("middle", 1), ("middle", 100)], SMOOTH)
    fix = "gps_week tow_s mode lat_deg lon_deg height_m vn_mps vd_mps clock_bias_s cov_nn_m2 cov_dd_m2 cov_ne_m2 " \
          "cov_vnvn_m2ps2 cov_vnvd_m2ps2".split()
    bad_values(flight, "pvt", fix, NONE + HUGE + TINY, [("middle", 1)])
    bad_values(flight, "pvt", ["tow_s", "lat_deg", "height_m", "vn_mps", "cov_dd_m2"], some, elsewhere)
    bad_values(flight, "pvt", ["lat_deg", "cov_nn_m2"], some, [("middle", 1), ("middle", 100)], SMOOTH)
    where = [("first", 1), ("middle", 1), ("middle", 100)]
    bad_values(flight, "att", ["tow_s", "heading_deg", "sd_heading_deg"], some, where)
    bad_values(flight, "mag", ["tow_s", "mag_x_ut", "mag_z_ut"], some, where, ["--compass", "yes", "--mag"])
    bad_values(flight, "baro", ["tow_s", "baro_height_m"], some, where, ["--baro"])


def levels():
    flight = Flight(CORRELATED)
    bad_values(flight, "pl", ["tow_s", "hpl_m", "vpl_m"], ["nan", "1e30", "-1e30", "-0"],
               [("first", 1), ("middle", 1), ("middle", 100)], ["--adapt", "gm", "--gate", "0", "--pl"])


def binary_numbers(flight):
    """What a text cannot hold but a log can: the bytes of a number replaced, as doubles and floats of an LCM log."""
    def replaced(kind, column, form, value):
        def change(table):
            subprocess.run([BIN / "sbf2csv", "-q", "-f", "lcm", "-o", "whole.lcm", flight.folder / (kind + ".csv")], check=True)
            log, row = pathlib.Path("whole.lcm").read_bytes(), len(table.rows) // 2
            bytes_of = lambda text: struct.pack(form, float(text))
            assert log.count(bytes_of(table.get(row, column))) == 1
            return log.replace(bytes_of(table.get(row, column)), bytes_of(value))
        at = flight.table(kind).time(len(flight.table(kind).rows) // 2) - flight.start
        status = (0, 1) if value in TINY or column == "vn_mps" else 1  # a fix without velocity is one
        case(f"lcm {kind} {column} {value}", flight, {kind: change}, status, again=at)
    for value in NONE + HUGE + TINY:
        replaced("imu", "accel_y_mps2", ">d", value)
        replaced("pvt", "lat_deg", ">d", value)
        replaced("pvt", "vn_mps", ">f", value if "e" not in value else value.replace("310", "40").replace("e30", "e38"))


# ---- times ----

def times(flight, kind, options=()):
    tag = kind + (" smooth" if options == SMOOTH else "")
    table = flight.table(kind)
    middle = len(table.rows) // 2
    column = {"imu": "accel_x_mps2", "pvt": "vn_mps"}[kind]

    def damaged(name, change, status=1, says=(), again=True):
        case(f"{tag} {name}", flight, {kind: change}, status, options, says,
             again=table.time(middle) - flight.start if again else None)

    def repeat(t):
        t.rows.insert(middle, t.rows[middle])

    def repeat_otherwise(t):
        repeat(t)
        t.put(middle + 1, column, "3.5")
    damaged("duplicate", repeat, says=["duplicate time"])
    damaged("duplicate with other values", repeat_otherwise, says=["duplicate time"])
    for seconds in "0.000000001", "0.005", "5", "604800":
        small = float(seconds) < 1  # within the window in which records are put in order
        damaged(f"one {seconds} s back", lambda t: t.set_time(middle, middle - 1, "-" + seconds), (0, 1) if small else 1)
        damaged(f"one {seconds} s ahead", lambda t: t.set_time(middle, middle, seconds), (0, 1) if small else 1)
    damaged("10 rows 5 s back", lambda t: [t.set_time(i, i, "-5") for i in range(middle, middle + 10)] and None)
    damaged("10 rows swapped", lambda t: t.rows.__setitem__(slice(middle, middle + 10), t.rows[middle + 9:middle - 1:-1]), (0, 1))
    span = {"imu": 500, "pvt": 25}[kind]
    damaged("5 s once more", lambda t: t.rows.__setitem__(slice(middle, middle), t.rows[middle - span:middle]))
    for n in 1, 100:
        for week in "65535", "0", "8000":
            damaged(f"{n} of week {week}", lambda t: t.fill(middle, n, ["gps_week"], week), again=n == 1)
        for tow in "4294967295", "4294967.295", "604800", "-1":
            damaged(f"{n} at time of week {tow}", lambda t: t.fill(middle, n, ["tow_s"], tow), again=n == 1)


def sbf_times(flight):
    """The same in a receiver's log: do-not-use values, and weeks to come, in blocks whose CRC is right."""
    def change_blocks(numbers, first, n, offset, value):
        def change(log):
            of_these = [at for at, number, _ in sbf_blocks(log) if number in numbers]
            for at in of_these[len(of_these) * first // 100:][:n]:
                sbf_put(log, at, offset, value)
        return change
    pvt_geodetic, att_euler = 4007, 5938
    for first in 0, 50:
        for n in 1, 20:
            at = 0 if first == 0 else None
            case(f"sbf {n} week 65535 at {first} %", flight, {"sbf": change_blocks([pvt_geodetic], first, n, 12, b"\xff\xff")}, (0, 1))
            case(f"sbf {n} tow 4294967295 at {first} %", flight, {"sbf": change_blocks([pvt_geodetic], first, n, 8, b"\xff\xff\xff\xff")}, (0, 1))
            case(f"sbf {n} week 4000 at {first} %", flight, {"sbf": change_blocks([pvt_geodetic, att_euler], first, n, 12, b"\xa0\x0f")}, 1)
            case(f"sbf {n} latitude not a number at {first} %", flight,
                 {"sbf": change_blocks([pvt_geodetic], first, n, 16, struct.pack("<d", math.nan))}, (0, 1))


def rollover():
    for week, scenario in ROLLOVER.items():
        flight = Flight(scenario)
        end = sum(flight.table("imu").time(row) < (week + 1) * 604800 for row in range(len(flight.table("imu").rows)))
        def shows(name, change, status, **more):
            case(f"week {week} ends, {name}", flight, {"imu": change}, status, **more)
        shows("whole", lambda t: None, 0, again=-30)
        shows("duplicate", lambda t: t.rows.insert(end, t.rows[end]), 1, again=60)
        shows("one week back", lambda t: t.put(end, "gps_week", str(week)), (0, 1), again=60)
        shows("week late by 10 rows", lambda t: t.fill(end, 10, ["gps_week"], str(week)), (0, 1), again=60, most=1) # a tenth of a second is lost
        shows("gap", lambda t: t.cut_out(59.5, 60.3), 0)


# ---- text ----

def texts(flight, kind):
    table = flight.table(kind)
    middle = len(table.rows) // 2
    fields = table.rows[middle].split(",")
    at = table.time(middle) - flight.start

    def line(name, text, status=1):
        says = [f"damaged.{kind}:{middle + 2}: "] if status == 1 else []
        case(f"{kind} {name}", flight, {kind: lambda t: t.rows.__setitem__(middle, text)}, status, says=says, again=at)

    def cell(name, text, status=1):
        line(name, ",".join(fields[:4] + [text] + fields[5:]), status)

    def whole(name, change, status, **more):
        case(f"{kind} {name}", flight, {kind: lambda t: change(t.text()).encode("utf-8", "surrogateescape")}, status, **more)
    line("short row", ",".join(fields[:4]))
    line("row of one field", fields[0])
    line("extra column", table.rows[middle] + ",17")
    line("1 MB line", "1" * 1000000)
    line("1 MB of commas", "," * 1000000)
    line("other bytes", "\u00ff\u00fe$@\x01" * 20)
    line("header once more", table.header, (0, 1))
    line("empty line", "", (0, 1))
    cell("text in a number", "abc")
    cell("unit behind a number", "0.1m/s")
    cell("decimal comma", "1,5")
    cell("hexadecimal", "0x10")
    cell("NUL", "0.1\0")
    cell("open quote", '"0.1', (0, 1))
    whole("CRLF", lambda t: t.replace("\n", "\r\n"), 0, again=-30)
    whole("BOM", lambda t: "\ufeff" + t, (0, 2), rows=False)
    whole("no header", lambda t: t.split("\n", 1)[1], (1, 2, 4), rows=False)
    whole("two headers", lambda t: table.header + "\n" + t, (0, 1), again=-30)
    whole("cut inside a row", lambda t: t[:len(t) // 2 - 10], 1)
    whole("header only", lambda t: table.header + "\n", 4, rows=False)
    whole("empty", lambda t: "", (2, 4), rows=False)
    whole("zeros", lambda t: "\0" * 100000, (1, 2, 4), rows=False)


# ---- fixes that are wrong ----

VARIANCES = ["cov_nn_m2", "cov_ee_m2", "cov_dd_m2"]
SPEED_VARIANCES = ["cov_vnvn_m2ps2", "cov_veve_m2ps2", "cov_vdvd_m2ps2"]


def wrong_fixes(flight, options=()):
    tag = "fix" + (" smooth" if options == SMOOTH else "")
    last = len(flight.table("pvt").rows) - 1
    generator = numpy.random.default_rng(7)

    def move(t, row, north_deg, up_m):
        t.put(row, "lat_deg", lambda x: x + north_deg)
        t.put(row, "height_m", lambda x: x + up_m)

    def moved(row, north_deg, up_m, variance):
        def change(t):
            move(t, row, north_deg, up_m)
            t.fill(row, 1, VARIANCES, variance)
        return change
    for place, row in ("first", 0), ("middle", last // 2), ("last", last):
        at = row / 5 if place != "last" else None
        for name, north_deg, up_m in ("1 degree", 1, 0), ("100 m", 0.0009, 0), ("120 m down", 0, -120), ("20 m up", 0, 20):
            for variance in "0.0001", "1":
                case(f"{tag} {place} {name} off, variance {variance}", flight, {"pvt": moved(row, north_deg, up_m, variance)}, 1,
                     options, again=at)
        for value in "0", "-1", "1e-24", "1e24", "1e-12", "1e12":
            for what, columns in ("variance", VARIANCES), ("speed variance", SPEED_VARIANCES):
                case(f"{tag} {place} {what} {value}", flight, {"pvt": lambda t: t.fill(row, 1, columns, value)}, (0, 1), options,
                     again=at)
    for share in 0.05, 0.1:
        for size in 0.001, 1.0:
            def outliers(t):
                for row in generator.permutation(last)[:int(share * last)]:
                    move(t, row, size * generator.standard_normal(), 1e5 * size * generator.standard_normal())
            case(f"{tag} {share:.0%} outliers of {size} degrees", flight, {"pvt": outliers}, 1, options)
    for value in "0", "-1", "1e-24", "1e24":
        case(f"{tag} all variances {value}", flight, {"pvt": lambda t: t.fill(0, last + 1, VARIANCES, value)}, 4, options,
             says=["no solution"], rows=False)


def wrong_headings(flight):
    last = len(flight.table("att").rows) - 1
    generator = numpy.random.default_rng(8)

    def turned(rows, by_deg):
        return lambda t: [t.put(row, "heading_deg", lambda x: (x + by_deg) % 360) for row in rows] and None
    for place, row in ("first", 0), ("middle", last // 2):
        for by_deg in 5, 90, 180:
            # the first one may be from before the run
            status = (0, 1) if row == 0 else 1
            case(f"heading {place} {by_deg} degrees off", flight, {"att": turned([row], by_deg)}, status, again=row / 5)
    for by_deg in 5, 90:
        case(f"heading 5% {by_deg} degrees off", flight, {"att": turned(generator.permutation(last)[:last // 20], by_deg)}, 1)
    for value in "0", "-1", "1e-12", "1e12":
        case(f"heading sigma {value}", flight, {"att": lambda t: t.fill(last // 2, 1, ["sd_heading_deg"], value)}, (0, 1),
             again=last / 10)


# ---- what is missing ----

def coverage(flight, options=()):
    tag = "smooth " if options == SMOOTH else ""
    def shows(name, kinds, since, until, status, **more):
        case(f"cover {tag}{name}", flight, {kind: lambda t: t.cut_out(since, until) for kind in kinds}, status, options, **more)
    gnss, imu, end = ["pvt", "att"], ["imu"], flight.length
    for seconds in 20, 30:
        shows(f"imu {seconds} s later", imu, -1, seconds, (0, 1))
        shows(f"gnss {seconds} s later", gnss, -1, seconds, (0, 1))
    shows("imu ends before", imu, end - 20, end + 9, (0, 1))
    shows("gnss ends before", gnss, end - 20, end + 9, (0, 1))
    for length in 1, 10, 60:
        shows(f"outage of {length} s", gnss, 40, 40 + length, 0)
    for length in 0.01, 0.1, 0.9, 5, 20:
        shows(f"imu gap of {length} s", imu, 50.004, 50.004 + length, 0 if length < 1 else 1)
    case(f"cover {tag}first imu, then gnss", flight, {"imu": lambda t: t.cut_out(50, end + 9),
         **{kind: lambda t: t.cut_out(-1, 60) for kind in gnss}}, 4, options, says=["no solution"], rows=False)
    case(f"cover {tag}first gnss, then imu", flight, {"imu": lambda t: t.cut_out(-1, 60),
         **{kind: lambda t: t.cut_out(50, end + 9) for kind in gnss}}, 4, options, says=["no solution"], rows=False)


def consistency():
    """Thirty seconds after a gap or an outage: position and velocity of all flights together within their 95 %. Of sixteen
    flights, each as good as one or two independent moments, 88 % is three of its own sigmas below that."""
    limit = 12.59  # chi-square, 6 degrees of freedom
    flights = [Flight(FLIGHT, seed, f"flight{seed}") for seed in range(100, 116)]
    for what, kinds, since, length in (("clean", [], 45, 0), ("gap of 0.01 s", ["imu"], 45, 0.01), ("gap of 0.9 s", ["imu"], 45, 0.9),
                                       ("gap of 5 s", ["imu"], 45, 5), ("outage of 30 s", ["pvt", "att"], 30, 30)):
        inside = []
        for flight in flights:
            nav = case(f"nees {what}", flight, {kind: lambda t: t.cut_out(since + 0.004, since + 0.004 + length) for kind in kinds},
                       (0, 1))
            if nav is None:
                continue
            late = nav.t > flight.start + since + length + 30
            nees = ((flight.errors(nav) / nav.sd)[late, :6] ** 2).sum(axis=1)
            inside.append(numpy.mean(nees < limit))
        if VERBOSE and inside:
            print(f"     nees {what}: {numpy.mean(inside):.1%} inside")
        if len(inside) == len(flights) and not numpy.mean(inside) > 0.88:
            complain(f"nees {what}", f"{numpy.mean(inside):.1%} of the rows inside 95 %")


def long_flight():
    flight = Flight(LONG)
    gnss, imu = ["pvt", "att"], ["imu"]
    def shows(name, kinds, change, status, options=()):
        # in an hour the accelerometers' flicker shows more than in a minute
        case(f"long {name}", flight, {kind: change for kind in kinds}, status, ["--accel-walk", "60", *options])
    shows("gap of 60 s", imu, lambda t: t.cut_out(100.01, 160), 1)
    shows("gap of 1 h", imu, lambda t: t.cut_out(200.01, 3800), 1)
    shows("gap of 1 h of everything", imu + gnss, lambda t: t.cut_out(200.01, 3800), 1)
    shows("gap of 1 h smooth", imu, lambda t: t.cut_out(200.01, 3800), 1, options=SMOOTH)
    shows("outage of 60 s", gnss, lambda t: t.cut_out(100.01, 160), 0)
    shows("outage of 600 s", gnss, lambda t: t.cut_out(500.01, 1100), 0)
    shows("outage of 600 s smooth", gnss, lambda t: t.cut_out(500.01, 1100), 0, options=SMOOTH)
    for kind in "imu", "pvt":
        middle = len(flight.table(kind).rows) // 2
        for n in 4, 100:
            shows(f"{kind}: {n} of week 8000", [kind], lambda t: t.fill(middle, n, ["gps_week"], "8000"), 1)
            shows(f"{kind}: first {n} of week 8000", [kind], lambda t: t.fill(0, n, ["gps_week"], "8000"), 1)
            shows(f"{kind}: {n} of week 0", [kind], lambda t: t.fill(middle, n, ["gps_week"], "0"), 1)


# ---- pl-monitor ----

def monitor(flight):
    """pl-monitor reads the same records: one epoch's levels or position damaged, the states of the others stay what they are, and
    no state is better than what is left of the record allows."""
    stream = subprocess.run([BIN / "sbf2csv", "-q", "-s", flight.folder / "rover.sbf"], capture_output=True, text=True).stdout
    lines = [line for line in stream.splitlines() if line.startswith(("#", "pvt,", "dop,"))]
    columns = {line[1:4]: line.split(",") for line in lines if line.startswith(("#pvt,", "#dop,"))}

    def watch(content):
        pathlib.Path("damaged.stream").write_text("\n".join(content) + "\n")
        run = subprocess.run([BIN / "pl-monitor", "damaged.stream"], capture_output=True, text=True, timeout=20 * SLOW)
        rows = [line.split(",") for line in run.stdout.splitlines()[1:]]
        return run, {(int(row[0]), float(row[1])): row for row in rows}
    clean = None

    def shows(name, kind, change, status=1, n=1, ahead=False):
        global n_cases
        nonlocal clean
        name = f"monitor {kind} {name}"
        if not is_wanted(name, ()):
            return
        n_cases += 1
        before, clean = failures, clean or watch(lines)[1]
        at = [i for i, line in enumerate(lines) if line.startswith(kind + ",")]
        at = at[len(at) // 2:][:n]
        hurt = [tuple(map(float, lines[i].split(",")[1:3])) for i in at]
        damaged = list(lines)
        change(damaged, at)
        run, rows = watch(damaged)
        if run.returncode not in (status if isinstance(status, tuple) else (status,)):
            complain(name, f"exit {run.returncode}, not {status}: {run.stderr}")
        if "nan" in run.stdout.lower() or "inf" in run.stdout.lower():
            complain(name, "not a number in the output")
        # One from weeks ahead makes those right behind it seem late, until there are enough of them.
        for t in clean.keys() - set(hurt) - {t for t in clean if ahead and 0 < t[1] - hurt[0][1] < 1}:
            if t not in rows or rows[t][6] != clean[t][6]:
                complain(name, f"{t}: {rows.get(t)}, not {clean[t]}")
                break
        for t in hurt:
            if kind == "dop" and t in rows and rows[t][6] == "RELIABLE" and rows[t][2:4] != clean[t][2:4]:
                complain(name, f"reliable by other levels: {rows[t]}")
        if VERBOSE:
            print(f"{'ok  ' if failures == before else 'FAIL'} {name:50} exit {run.returncode} | {' / '.join(run.stderr.splitlines())[:300]}")

    def cell(kind, column, value, n, status, ahead=False):
        def change(damaged, at):
            for i in at:
                fields = damaged[i].split(",")
                fields[columns[kind].index(column)] = value
                damaged[i] = ",".join(fields)
        shows(f"{n} {column} {value}", kind, change, status, n, ahead)
    for n in 1, 100:
        for value in NONE + HUGE + TINY:
            for kind, columns_of in ("dop", ("tow_s", "hpl_m", "vpl_m")), ("pvt", ("tow_s", "lat_deg", "mode")):
                for column in columns_of:
                    cell(kind, column, value, n, 1 if value in NONE or (value in HUGE and column == "tow_s") else (0, 1))
    for kind in "dop", "pvt":
        shows("duplicate", kind, lambda d, at: d.insert(at[0], d[at[0]]), (0, 1))
        shows("swapped", kind, lambda d, at: d.insert(at[0], d.pop(at[4])), (0, 1), n=5)
        cell(kind, "gps_week", "65535", 1, 1)
        cell(kind, "gps_week", "8000", 1, 1, ahead=True)
        cell(kind, "gps_week", "0", 1, (0, 1))


def main():
    began = time.monotonic()
    if any(any_wanted(p) for p in ("imu", "pvt", "att", "mag", "baro", "lcm", "sbf", "fix", "heading", "cover", "monitor")):
        flight = Flight(FLIGHT)
        numbers(flight)
        binary_numbers(flight)
        sbf_times(flight)
        for kind in "imu", "pvt":
            times(flight, kind)
            times(flight, kind, SMOOTH)
            texts(flight, kind)
        monitor(flight)
        for options in (), SMOOTH:
            wrong_fixes(flight, options)
            coverage(flight, options)
        wrong_headings(flight)
    for prefix, part in ("pl", levels), ("week", rollover), ("nees", consistency), ("long", long_flight):
        if any_wanted(prefix):
            part()
    print(f"{n_cases} cases, {failures} complaints, {time.monotonic() - began:.0f} s")
    return 1 if failures or not n_cases else 0


sys.exit(main())
