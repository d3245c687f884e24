#!/usr/bin/env python3
"""RINEX, read and written, beside those who do it elsewhere.

  counts      satellites per epoch and ephemerides of every shared file: as many as RTKLIB reads (pyrtklib)
  values      every observable of every shared file is georinex's; here of the first epochs, georinex being slow, of whole
              files in test_rinex_long.py. The same after convbin has made RINEX 2.11 of it
  compact     the shared .crx.gz, and what RNX2CRX makes of the other files, give the rows that the plain file gives,
              unpacked by PyPI's hatanaka where it was not plain
  written     `sbf2csv -f rinex` of log_0000.sbf: every observable is that of convbin's RINEX, by the rules of
              test_convbin.py, and none is missing
  solved      rnx2rtkp, given our RINEX, gives the positions that it gives of the files it was made from
"""

import collections
import csv
import datetime
import decimal
import os
import pathlib
import shutil
import subprocess
import sys
import warnings

sys.dont_write_bytecode = True  # leave nothing in the source tree
warnings.filterwarnings("ignore")

try:
    import georinex
    import hatanaka
    import numpy
    import pyrtklib as rtklib
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

import sbf_log
import test_convbin

SBF2CSV = pathlib.Path(os.environ["BIN"]) / "sbf2csv"
DATA = pathlib.Path(os.environ["FURROW_DATA"])
SKIPPED = 77

OBSERVATIONS = ["rtk/mosaic_static/base.obs", "rtk/mosaic_static/rover.obs", "rtk/spirent_dynamic/base.obs",
                "rtk/spirent_dynamic/rover.obs", "ins/walk_0827/converted/gnss_1730.obs", "sbas/msas_2008/cres_20080526.obs",
                "rinex/tlse_1hz/TLSE00FRA_R_20240011200_15M_01S_MO.crx.gz"]  # fmt: skip
NAVIGATION = ["rtk/mosaic_static/base.nav", "rtk/spirent_dynamic/gps.nav", "rtk/spirent_dynamic/gal.nav",
              "ins/walk_0827/converted/gnss_1730.nav", "sbas/msas_2008/cres_20080526.nav", "sbas/japan_2025/046r_rnx.nav",
              "rinex/tlse_1hz/BRDC00IGS_R_20240010000_01D_MN.rnx.gz"]  # fmt: skip
COLUMNS = {"C": "pseudorange_m", "L": "carrier_cyc", "D": "doppler_hz", "S": "cn0_dbhz"}
GPS_EPOCH = datetime.datetime(1980, 1, 6)


def plain(path):
    """the file as RINEX text in the scratch folder: georinex and RTKLIB unpack beside it, or not at all"""
    path = DATA / path
    to = pathlib.Path(path.name.split(".")[0] + (".nav" if ".nav" in path.name or "_MN" in path.name else ".obs"))
    to.write_bytes(hatanaka.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes())
    return to


def run(*arguments):
    """sbf2csv's output; it must have nothing to complain of"""
    done = subprocess.run([SBF2CSV, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, (arguments, done.returncode, done.stderr)
    return done.stdout


def rows(path):
    return list(csv.DictReader(run("-q", "-t", "obs", path).splitlines()))


def ours(path):
    """{(ms of GPS time, satellite, observable): value}"""
    found = {}
    for row in rows(path):
        ms = round((int(row["gps_week"]) * 604800 + float(row["tow_s"])) * 1000)
        for letter, column in COLUMNS.items():
            if row[column]:
                found[ms, row["sat"], letter + row["signal"]] = float(row[column])
    return found


# ---- counts ----


def counts():
    for file in OBSERVATIONS:
        path = plain(file)
        obs, nav, sta = rtklib.obs_t(), rtklib.nav_t(), rtklib.sta_t()
        assert rtklib.readrnx(str(path), 1, "", obs, nav, sta) == 1
        theirs = collections.Counter()
        for i in range(obs.n):
            prn = rtklib.Arr1Dint(1)
            theirs[rtklib.satsys(obs.data[i].sat, prn)] += 1
        satellites = {(row["gps_week"], row["tow_s"], row["sat"]) for row in rows(DATA / file)}
        mine = collections.Counter(sat[0] for _, _, sat in satellites)
        assert len(satellites) == obs.n, (file, len(satellites), obs.n, mine, theirs)
        print(f"{file}: {obs.n} satellites in all epochs, as RTKLIB")
    for file in NAVIGATION:
        path = plain(file)
        obs, nav, sta = rtklib.obs_t(), rtklib.nav_t(), rtklib.sta_t()
        assert rtklib.readrnx(str(path), 1, "", obs, nav, sta) == 1
        done = subprocess.run([SBF2CSV, "-s", DATA / file], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        n = collections.Counter(line.split(",")[0] for line in done.stdout.splitlines())
        passed = [int(line.split(": ")[2].split()[0]) for line in done.stderr.splitlines() if "passed over" in line]
        kepler = n["eph_gps"] + n["eph_gal"] + n["eph_bds"] + sum(passed)  # NavIC, CNAV and its kin: RTKLIB takes them
        assert (kepler, n["eph_glo"], n["eph_sbas"]) == (nav.n, nav.ng, nav.ns), (file, n, passed, nav.n, nav.ng, nav.ns)
        print(f"{file}: {nav.n} + {nav.ng} + {nav.ns} ephemerides, as RTKLIB ({sum(passed)} of messages without records)")


# ---- values ----


def shortened(path, epochs):
    """the first epochs of a file of version 3"""
    kept = []
    for line in path.read_text().splitlines(keepends=True):
        epochs -= line.startswith(">")
        if epochs < 0:
            break
        kept.append(line)
    to = path.with_name("short_" + path.name)
    to.write_text("".join(kept))
    return to


def of_georinex(path):
    """what `ours` gives, by georinex"""
    data = georinex.load(path)
    times = [round((t.astype("datetime64[us]").item() - GPS_EPOCH).total_seconds() * 1000) for t in data.time.values]
    satellites = [f"S{100 + int(s[1:])}" if s[0] == "S" else s for s in data.sv.values]
    found = {}
    for kind in data.data_vars:
        if kind[0] not in [*COLUMNS, "P"] or kind.endswith("lli") or kind.endswith("ssi"):
            continue
        values = data[kind].values
        for i, k in zip(*numpy.nonzero(numpy.isfinite(values) & (values != 0))):
            found[times[i], satellites[k], kind] = float(values[i, k])
    return found


def compare_values(file, mine, theirs):
    off = lambda key: abs(mine.get(key, 1e9) - theirs.get(key, -1e9))
    different = [key for key in mine.keys() | theirs.keys() if off(key) > (0.0050001 if key[2][0] == "S" else 0)]
    assert not different, (file, len(different), [(k, mine.get(k), theirs.get(k)) for k in sorted(different)[:5]])
    print(f"{file}: {len(mine)} observables, all equal to georinex's")


def values(epochs):
    for file in OBSERVATIONS:
        path = plain(file)
        if epochs:
            path = shortened(path, epochs)
        compare_values(file, ours(path), of_georinex(path))


# RINEX 2's bands as signals of RINEX 3, in a file that has C1, P2, C2, C5 and C7 (rinex_obs.h)
VERSION_2 = {"G": {"C1": "1C", "1": "1C", "P2": "2W", "C2": "2X", "2": "2W", "5": "5X"},
             "R": {"C1": "1C", "1": "1C", "P2": "2P", "C2": "2C", "2": "2P"},
             "E": {"1": "1X", "5": "5X", "7": "7X"}, "J": {"1": "1C", "2": "2X", "5": "5X"}, "S": {"1": "1C"}}  # fmt: skip


def version_3_name(sat, kind):
    names = VERSION_2[sat[0]]
    return ("C" if kind[0] == "P" else kind[0]) + names.get(kind, names.get(kind[1]))


def version_2():
    """convbin's RINEX 2.11"""
    source = shortened(plain(OBSERVATIONS[0]), 20)
    subprocess.run(["convbin", "-r", "rinex", "-v", "2.11", "-od", "-os", "-f", "3", "-o", "old.obs", "-n", "old.nav", source], capture_output=True)
    theirs = {(ms, sat, version_3_name(sat, kind)): x for (ms, sat, kind), x in of_georinex("old.obs").items()}
    compare_values("the same as RINEX 2.11", ours("old.obs"), theirs)


# ---- Compact RINEX ----


def compact():
    for file in OBSERVATIONS:
        path = plain(file)
        packed = pathlib.Path("packed.crx")
        packed.write_bytes(hatanaka.rnx2crx(path.read_bytes()))
        wanted = run("-q", "-t", "obs,epoch", "-s", path)
        for source in [packed] + ([DATA / file] if file.endswith(".crx.gz") else []):
            mine = run("-q", "-t", "obs,epoch", "-s", source)
            assert body(mine) == body(wanted), (file, source)
        print(f"{file}: {len(body(wanted))} rows, the same from Compact RINEX 3")
    old = pathlib.Path("old.obs").read_bytes()
    packed.write_bytes(hatanaka.rnx2crx(old))
    assert body(run("-q", "-t", "obs,epoch", "-s", packed)) == body(run("-q", "-t", "obs,epoch", "-s", "old.obs"))
    print("and from Compact RINEX 1")


def body(stream):
    return [line for line in stream.splitlines() if not line.startswith("#")]


# ---- written ----


def parse(path):
    """{(ms, satellite, observable): text} of a RINEX 3 file, and GLONASS's frequency numbers"""
    types, found, slots = {}, {}, {}
    lines = iter(pathlib.Path(path).read_text().splitlines())
    for line in lines:
        if line[60:].startswith("SYS / # / OBS TYPES"):
            system = line[0] if line[0] != " " else system
            types[system] = types.get(system, []) + line[7:58].split()
        if line[60:].startswith("GLONASS SLOT"):
            for at in range(4, 60, 7):
                if line[at : at + 1] == "R":
                    slots[line[at : at + 3]] = line[at + 4 : at + 6].strip()
        if line[60:].startswith("END OF HEADER"):
            break
    for line in lines:
        if line[0] == ">":
            y, month, day, h, m, s = line[2:29].split()
            t = datetime.datetime(int(y), int(month), int(day), int(h), int(m))
            ms = round((t - GPS_EPOCH).total_seconds() * 1000 + float(s) * 1000)
            continue
        sat = f"S{int(line[1:3]) + 100}" if line[0] == "S" else line[:3]
        for k, kind in enumerate(types[line[0]]):
            text = line[3 + 16 * k : 17 + 16 * k].strip()
            if text:
                found[ms, sat, kind] = text
    return found, slots


def written():
    log = DATA / "sbf/log_0000.sbf"
    shutil.rmtree("made", ignore_errors=True)
    run("-q", "-f", "rinex", "--split", "made", log)
    mine, slots = parse("made/obs.rnx")
    # Thousandths of what the table has: the table itself, with its further digit of the Doppler, is what is compared.
    table, channels = test_convbin.ours(log, "main")
    table = {key: text for key, text in table.items() if text and float(text) != 0}
    assert mine.keys() == table.keys()
    for key, text in mine.items():
        assert abs(decimal.Decimal(text) - decimal.Decimal(table[key])) <= decimal.Decimal("0.0005"), (key, text, table[key])
    assert all(slots.get(sat, "") == channel for (_, sat), channel in channels.items())
    blocks = [b for b in sbf_log.blocks(log.read_bytes()) if sbf_log.block_id(b) == sbf_log.MEAS_EPOCH]
    seen = list(test_convbin.of_antenna(blocks, 0))
    unknown, names = test_convbin.renamed(seen)
    theirs = test_convbin.all_of_convbin(seen, "as_is.sbf", None)
    theirs |= test_convbin.all_of_convbin(unknown, "renamed.sbf", names)
    rules = collections.Counter()
    for key in mine.keys() | theirs.keys():
        rule = test_convbin.verdict(key, table, theirs.get(key), channels)
        assert rule, (key, mine.get(key), theirs.get(key))
        rules[rule] += 1
    print("log_0000.sbf as RINEX beside convbin's:", ", ".join(f"{n} {rule}" for rule, n in rules.items()))
    assert rules["equal"] == len(mine) and rules["equal"] > 3000


# ---- solved ----


def solve(obs, *nav):
    command = ["rnx2rtkp", "-p", "0", "-m", "15", "-sys", "G,R,E,C", "-o", "solution.pos", obs, *nav]
    subprocess.run([str(c) for c in command], capture_output=True, check=True)
    lines = pathlib.Path("solution.pos").read_text().splitlines()
    return [line.split() for line in lines if not line.startswith("%")]


def solved():
    for obs, navs in ((OBSERVATIONS[1], NAVIGATION[:1]), (OBSERVATIONS[3], NAVIGATION[1:3]), (OBSERVATIONS[4], NAVIGATION[3:4])):
        shutil.rmtree("made", ignore_errors=True)
        run("-q", "-f", "rinex", "--split", "made", DATA / obs, *(DATA / nav for nav in navs))
        wanted = solve(DATA / obs, *(DATA / nav for nav in navs))
        found = solve("made/obs.rnx", "made/nav.rnx")
        assert len(found) == len(wanted) > 0, (obs, len(found), len(wanted))
        worst = [max(abs(float(a[i]) - float(b[i])) for a, b in zip(wanted, found)) for i in (2, 3, 4)]
        # an ephemeris keeps some of its numbers as float
        assert all(a[:2] == b[:2] for a, b in zip(wanted, found)) and max(worst[:2]) < 3e-9 and worst[2] < 3e-4, (obs, worst)
        print(f"{obs}: rnx2rtkp solves {len(found)} epochs of ours, within {worst[0]:.0e} deg and {worst[2]:.0e} m")
    shutil.rmtree("made", ignore_errors=True)
    run("-q", "-f", "rinex", "--split", "made", DATA / "sbf/log_0000.sbf")
    found = solve("made/obs.rnx", "made/nav.rnx")
    assert len(found) == 12, len(found)
    print("log_0000.sbf: rnx2rtkp solves all 12 epochs of ours")


def main():
    if shutil.which("convbin") is None:
        print("skipped: no convbin (Debian package rtklib)")
        return SKIPPED
    if not (DATA / OBSERVATIONS[0]).exists():
        print(f"skipped: no files in {DATA}")
        return SKIPPED
    counts()
    values(10)
    version_2()
    compact()
    written()
    solved()
    return 0


if __name__ == "__main__":
    sys.exit(main())
