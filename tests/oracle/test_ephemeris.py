#!/usr/bin/env python3
"""States of satellites beside RTKLIB's (demo5, by PyPI's pyrtklib): broadcast ephemerides of every shared navigation file,
read by furrow's RINEX reader, and precise orbits and clocks from SP3 and RINEX clock files that this script makes.

Broadcast: each ephemeris of furrow must have its counterpart among RTKLIB's (same satellite, same toe, clock equal to the
digits of RINEX), and each satellite that RTKLIB has must be there. States are compared at times from toe to the end of
validity, position within 2 mm, clock within 0.01 ns. What is known of RTKLIB:

  iteration   none in eph2pos(): time is that of transmission, as in furrow
  GLONASS     Runge-Kutta steps of 60 s, in furrow 40 s; the difference is RTKLIB's error: 0.4 mm after 15 minutes,
              and up to 1.8 mm after 30
  relativity  in the clock, -2 sqrt(GM a) e sin E / c^2 for all Kepler orbits, as in furrow; none for GLONASS and SBAS
  delays      TGD, BGD: in neither clock
  velocity    RTKLIB differentiates over 1 ms, so ours is compared with differences over 0.25 s of its positions: 1e-5 m/s
  messages    RTKLIB takes CNAV of RINEX 4 for LNAV; furrow passes it over

Precise: both interpolate with order 10 through six epochs before and five after, the Earth's rotation taken out. The clock's
relativistic effect is -2 r.v / c^2 in both; RTKLIB's velocity and drift are differences over 1 ms: 1e-3 m/s.
"""

import collections
import gzip
import math
import os
import pathlib
import subprocess
import sys

sys.dont_write_bytecode = True  # leave nothing in the source tree
try:
    import pyrtklib as rtklib
except ImportError:
    print("skipped: no pyrtklib")
    sys.exit(77)

TOOL = pathlib.Path(os.environ["TOOLS"]) / "satellite_states"
DATA = pathlib.Path(os.environ["FURROW_DATA"])
FILES = ["ins/walk_0827/converted/gnss_1730.nav", "rtk/mosaic_static/base.nav", "rtk/spirent_dynamic/gps.nav",
         "rtk/spirent_dynamic/gal.nav", "rinex/tlse_1hz/BRDC00IGS_R_20240010000_01D_MN.rnx.gz",
         "sbas/msas_2008/cres_20080526.nav", "sbas/japan_2025/046r_rnx.nav"]  # fmt: skip
OFFSETS = [-14000, -7200, -3611.5, -1800, -900, -61.25, -7.25, 0, 1, 33.25, 240, 359.5, 900, 1799.5, 3600, 7200, 14000,
           21600]  # fmt: skip
LAST = {"G": 7200, "J": 7200, "E": 14000, "C": 21600, "R": 1800, "S": 360}  # RTKLIB's limits [s]
MESSAGES = ["LNAV", "INAV", "FNAV", "D1", "D2", "FDMA", "SBAS"]
POSITION_M, CLOCK_S, VELOCITY_MPS, DRIFT = 2e-3, 1e-11, 1e-5, 1e-15
CLOCK_OF = {"1": 1 << 9, "2": 1 << 8}  # Galileo: our message to the bit of RINEX's data sources; E1 and E5b, E1 and E5a
GPS_EPOCH = 315964800  # Unix time of 1980-01-06
LETTERS = {rtklib.SYS_GPS: "G", rtklib.SYS_GAL: "E", rtklib.SYS_CMP: "C", rtklib.SYS_QZS: "J", rtklib.SYS_GLO: "R",
           rtklib.SYS_SBS: "S", rtklib.SYS_IRN: "I"}  # fmt: skip

failures = []


def check(condition, message):
    if not condition:
        failures.append(message)


# ---- RTKLIB's side ----


def ns(t):
    return (t.time - GPS_EPOCH) * 10**9 + round(t.sec * 1e9)


def moment(t_ns):
    t = rtklib.gtime_t()
    t.time = t_ns // 10**9 + GPS_EPOCH
    t.sec = t_ns % 10**9 * 1e-9
    return t


def name(number):
    prn = rtklib.Arr1Dint(1)
    letter = LETTERS.get(rtklib.satsys(number, prn), "")
    if letter == "S":
        return f"S{prn[0]}"
    return f"{letter}{prn[0] - (192 if letter == 'J' else 0):02d}"


def state(function, ephemeris, t):
    """x, y, z, clock"""
    position, clock, variance = rtklib.Arr1Ddouble(3), rtklib.Arr1Ddouble(1), rtklib.Arr1Ddouble(1)
    function(t, ephemeris, position, clock, variance)
    return [position[0], position[1], position[2], clock[0]]


def read_navigation(path):
    """(satellite, toe) to RTKLIB's ephemerides: a list of (function, ephemeris, af0)"""
    nav, obs, sta = rtklib.nav_t(), rtklib.obs_t(), rtklib.sta_t()
    rtklib.readrnx(str(path), 1, "", obs, nav, sta)
    found = collections.defaultdict(list)
    for i in range(nav.n):
        found[name(nav.eph[i].sat), ns(nav.eph[i].toe)].append((rtklib.eph2pos, nav.eph[i], nav.eph[i].f0))
    for i in range(nav.ng):
        found[name(nav.geph[i].sat), ns(nav.geph[i].toe)].append((rtklib.geph2pos, nav.geph[i], -nav.geph[i].taun))
    for i in range(nav.ns):
        found[name(nav.seph[i].sat), ns(nav.seph[i].t0)].append((rtklib.seph2pos, nav.seph[i], nav.seph[i].af0))
    return nav, found


# ---- broadcast ----


class Worst:
    """the largest differences of a system"""

    def __init__(self):
        self.satellites, self.ephemerides, self.states = set(), set(), 0
        self.largest = [0.0] * 4

    def add(self, satellite, ephemeris, differences):
        self.satellites.add(satellite)
        self.ephemerides.add(ephemeris)
        self.states += 1
        self.largest = [max(a, b) for a, b in zip(self.largest, differences)]

    def __str__(self):
        return (f"{len(self.satellites):3} satellites {len(self.ephemerides):6} ephemerides {self.states:7} states: "
                "position {:.1e} m, velocity {:.1e} m/s, clock {:.1e} s, drift {:.1e}".format(*self.largest))  # fmt: skip


def differences(ours, function, ephemeris, t):
    """of position, velocity, clock, drift"""
    here = state(function, ephemeris, t)
    before, after = (state(function, ephemeris, rtklib.timeadd(t, s)) for s in (-0.125, 0.125))
    rates = [(b - a) / 0.25 for a, b in zip(before, after)]
    return [math.dist(ours[:3], here[:3]), math.dist(ours[3:6], rates[:3]), abs(ours[6] - here[3]),
            abs(ours[7] - rates[3])]  # fmt: skip


def compare_line(file, line, theirs, worst):
    satellite, message, toe, af0, t, status, *numbers = line.split(",")
    after = (int(t) - int(toe)) / 1e9
    alike = [c for c in theirs[satellite, int(toe)] if math.isclose(c[2], float(af0), rel_tol=1e-7, abs_tol=1e-15)]
    if satellite[0] == "E":
        alike = [c for c in alike if c[1].code & CLOCK_OF[message]]
    if not alike:
        check(after != 0, f"{file}: {satellite} toe {toe}: RTKLIB has no such ephemeris")
        return
    if abs(after) > LAST[satellite[0]]:
        return
    if int(status) < 0:
        check(False, f"{file}: {satellite} toe {toe} {after:+} s: status {status}")
        return
    ours = [float(x) for x in numbers]
    found = min((differences(ours, function, e, moment(int(t))) for function, e, _ in alike), key=lambda d: d[0] + 299792458 * d[2])
    worst[satellite[0]].add(satellite, (satellite, toe, af0), found)
    for value, limit, what in zip(found, (POSITION_M, VELOCITY_MPS, CLOCK_S, DRIFT),
                                  ("position", "velocity", "clock", "drift")):  # fmt: skip
        check(value <= limit, f"{file}: {satellite} toe {toe} {after:+} s: {what} {value:g} off")


def known(path, satellites):
    """those of a RINEX 4 file that have a message which furrow reads; of older files all"""
    entries = [line.split()[2:4] for line in path.read_text().splitlines() if line.startswith("> EPH")]
    if not entries:
        return satellites
    plain = {"S" + str(100 + int(s[1:])) if s[0] == "S" else s for s, message in entries if message in MESSAGES}
    return satellites & plain


def navigation_file(file):
    path = DATA / file
    if path.suffix == ".gz":  # RTKLIB unpacks beside the file, where nothing may be written
        path = pathlib.Path(path.stem)
        path.write_bytes(gzip.decompress((DATA / file).read_bytes()))
    _, theirs = read_navigation(path)
    lines = subprocess.run([TOOL, DATA / file, *map(str, OFFSETS)], stdout=subprocess.PIPE, text=True).stdout.splitlines()
    check(lines, f"{file}: furrow reads nothing")
    worst = collections.defaultdict(Worst)
    for line in lines:
        compare_line(file, line, theirs, worst)
    read = {line.split(",")[0] for line in lines}
    for satellite in known(path, {s for s, _ in theirs if s[0] in LAST}) - read:
        check(False, f"{file}: {satellite} is missing")
    print(file)
    for system, w in sorted(worst.items()):
        print(f"  {system} {w}")


# ---- precise ----

BEGIN = 1388145600 * 10**9  # 2024-01-01T12:00:00
CLOCK_STEP = 30


def calendar(t_ns):
    e = rtklib.Arr1Ddouble(6)
    rtklib.time2epoch(moment(t_ns), e)
    return [int(e[i]) for i in range(5)] + [e[5]]


def write_precise(chosen, begin, step, epochs):
    """SP3 and clock files as an analysis centre would write them from these orbits"""
    with open("made.sp3", "w") as sp3:
        year, month, day, hour, minute, second = calendar(begin)
        sp3.write(f"#dP{year:4} {month:2} {day:2} {hour:2} {minute:2} {second:11.8f} {epochs:7} ORBIT IGS20 HLM  TST\n")
        sp3.write(f"## 2295 216000.00000000 {step:14.8f} 60310 0.5000000000000\n")
        names = sorted(chosen)
        for i in range(0, 85, 17):
            count = f"{len(names):3}" if i == 0 else "   "
            sp3.write(f"+  {count}   " + "".join((names + ["  0"] * 85)[i : i + 17]) + "\n")
        sp3.write(("++       " + "  0" * 17 + "\n") * 5)
        sp3.write("%c M  cc GPS ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc\n")
        sp3.write("%c cc cc ccc ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc\n")
        sp3.write("%f  1.2500000  1.025000000  0.00000000000  0.000000000000000\n" * 2)
        sp3.write("%i    0    0    0    0      0      0      0      0         0\n" * 2)
        sp3.write("/* made of broadcast ephemerides\n" * 4)
        for k in range(epochs):
            t = begin + k * step * 10**9
            year, month, day, hour, minute, second = calendar(t)
            sp3.write(f"*  {year:4} {month:2} {day:2} {hour:2} {minute:2} {second:11.8f}\n")
            for satellite in names:
                x, y, z, clock = state(rtklib.eph2pos, chosen[satellite], moment(t))
                sp3.write(f"P{satellite}{x / 1e3:14.6f}{y / 1e3:14.6f}{z / 1e3:14.6f}{clock * 1e6:14.6f}\n")
        sp3.write("EOF\n")
    with open("made.clk", "w") as clk:
        clk.write(f"{'     3.00           C':60}RINEX VERSION / TYPE\n{'':60}END OF HEADER\n")
        for k in range(epochs * step // CLOCK_STEP):
            t = begin + k * CLOCK_STEP * 10**9
            year, month, day, hour, minute, second = calendar(t)
            for satellite in names:
                clock = state(rtklib.eph2pos, chosen[satellite], moment(t))[3]
                clk.write(f"AS {satellite}  {year:4} {month:02} {day:02} {hour:02} {minute:02}{second:10.6f}  1   "
                          f"{clock:19.12e}\n")  # fmt: skip


def precise(step, with_clocks):
    """Made of one ephemeris for each satellite, so that the orbits are smooth."""
    path = pathlib.Path(pathlib.Path(FILES[4]).stem)
    _, found = read_navigation(path)
    chosen, epochs = {}, 25
    begin = BEGIN - 12 * step * 10**9
    for (satellite, toe), candidates in sorted(found.items()):
        if abs(toe - BEGIN) < 3700 * 10**9 and satellite[0] in "GEJC" and satellite not in chosen:
            chosen[satellite] = candidates[0][1]
    chosen = dict(sorted(chosen.items(), key=lambda c: (c[0][0] == "C", c))[:85])  # RTKLIB reads no more than 99
    write_precise(chosen, begin, step, epochs)

    nav = rtklib.nav_t()
    rtklib.readsp3("made.sp3", nav, 0)
    if with_clocks:
        rtklib.readrnxc("made.clk", nav)
    first = begin + 6 * step * 10**9
    command = [TOOL, "-p", "made.sp3", "made.clk" if with_clocks else "-", str(first), str(97 * 10**9),
               str((epochs - 13) * step // 97)]  # fmt: skip
    lines = subprocess.run(command, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    worst = Worst()
    for line in lines:
        satellite, _, _, _, t, status, *numbers = line.split(",")
        ours = [float(x) for x in numbers]
        rs, dts, var = rtklib.Arr1Ddouble(6), rtklib.Arr1Ddouble(2), rtklib.Arr1Ddouble(1)
        if not rtklib.peph2pos(moment(int(t)), rtklib.satid2no(satellite), nav, 0, rs, dts, var):
            check(False, f"precise: RTKLIB has no {satellite}")
            continue
        theirs = [rs[i] for i in range(6)] + [dts[0], dts[1]]
        check(status == "0", f"precise: {satellite} at {t}: status {status}")
        difference = [math.dist(ours[:3], theirs[:3]), math.dist(ours[3:6], theirs[3:6]), abs(ours[6] - theirs[6]),
                      abs(ours[7] - theirs[7])]  # fmt: skip
        worst.add(satellite, satellite, difference)
        check(difference[0] <= POSITION_M, f"precise: {satellite} at {t}: position {difference[0]:g} m off")
        check(difference[1] <= 1e-3, f"precise: {satellite} at {t}: velocity {difference[1]:g} m/s off")
        check(difference[2] <= CLOCK_S, f"precise: {satellite} at {t}: clock {difference[2]:g} s off")
    check(len(worst.satellites) == len(chosen), "precise: satellites are missing")
    print(f"SP3 {step} s, clocks {'of a clock file' if with_clocks else 'of SP3'}\n    {worst}")


def main():
    if not DATA.is_dir():
        print("skipped: no real data")
        return 77
    for file in FILES:
        navigation_file(file)
    precise(900, False)
    precise(300, True)
    for message in failures[:20]:
        print(message, file=sys.stderr)
    print(f"{len(failures)} failures")
    return len(failures) > 0


sys.exit(main())
