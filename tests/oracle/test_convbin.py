#!/usr/bin/env python3
"""Each observable of MeasEpoch in `sbf2csv -t obs` is that of convbin's RINEX (Debian's rtklib 2.4.3), to its last digit.

Compared are all real logs, two of them joined, and a log of random measurements that this script makes. convbin leaves
signals out and takes all antennas for one, so it reads each log several times: for each antenna, for each code that
shares a place with another one (SHARED), and once more with the satellites that it does not know (KNOWN) under numbers
that it knows. After that nothing may differ but what these rules, which are counted, explain:

  signal      convbin has no name for it (UNNAMED); it writes it as 1C, or not at all
  carrier     a carrier marked as not available (MSB -128, LSB 0): convbin looks for the mark in a two-byte integer, does
              not find it and writes what the formula gives, pseudorange / wavelength - 8388.608
  alone       the pseudorange is not available (0; of a second signal MSB -4, LSB 0), so neither is what is counted from
              it, the carrier and the second signals' pseudoranges; convbin takes it for 0
  mark        Doppler (-2147483648) or C/N0 (255) marked as not available: convbin writes the mark as a value
  zero        a value of exactly 0 is blank in RINEX

C/N0 is read as S / 0.004: this convbin keeps quarters of dB-Hz and writes them as thousandths. A Doppler counts as equal
if some number that rounds to ours also becomes theirs by way of the float in which convbin keeps it.
"""

import collections
import csv
import datetime
import decimal
import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys

sys.dont_write_bytecode = True  # leave nothing in the source tree
import numpy
import sbf_log

SBF2CSV = pathlib.Path(os.environ["BIN"]) / "sbf2csv"
DATA = pathlib.Path(os.environ["FURROW_DATA"]) / "sbf"
SKIPPED = 77

COLUMNS = {"C": "pseudorange_m", "L": "carrier_cyc", "D": "doppler_hz", "S": "cn0_dbhz"}
SHARED = ["", "-EL5Q", "-EL7Q", "-EL6C", "-GL2L", "-RL2C"]
KNOWN = {"G": 32, "R": 27, "E": 32, "C": 37, "I": 7, "S": 140, "J": 0, "": 255}
UNNAMED = {"G1L", "C1P", "C5P", "C7D", "I1P", "J1L", "J1Z", "J1E", "J5P", "J6S"}
QZSS_AS_GPS = {6: 0, 7: 3, 26: 4}  # the same frequencies and codes
SPEED_OF_LIGHT = 299792458.0


def satellite(svid):
    """SVID to (system, number), by the table of the SBF reference guides."""
    ranges = [(1, 37, "G", 0), (38, 61, "R", 37), (63, 68, "R", 38), (71, 106, "E", 70), (120, 140, "S", 0),
              (141, 180, "C", 140), (181, 190, "J", 180), (191, 197, "I", 190), (198, 215, "S", 57),
              (216, 222, "I", 208), (223, 245, "C", 182)]  # fmt: skip
    found = ((system, svid - less) for first, last, system, less in ranges if first <= svid <= last)
    return next(found, ("", svid))  # 62: GLONASS without a slot number; 107 to 119: L-band


def name(svid):
    system, number = satellite(svid)
    return f"S{number}" if system == "S" else f"{system}{number:02d}"


def signal_number(kind, info):
    low = kind & 31
    return 32 + (info >> 3) if low == 31 else low


def groups(block):
    """Yields each Type1 sub-block of a MeasEpoch with the list of its Type2 sub-blocks."""
    n, size1, size2 = block[14:17]
    at = 20
    for _ in range(n):
        first = block[at : at + size1]
        at += size1
        yield first, [block[at + i * size2 : at + (i + 1) * size2] for i in range(first[19])]
        at += first[19] * size2


def with_groups(block, kept):
    """The MeasEpoch with other groups of sub-blocks."""
    body = block[14:20] + b"".join(first + b"".join(others) for first, others in kept)
    number, length = struct.unpack_from("<HH", block, 4)
    tow, week = struct.unpack_from("<IH", block, 8)
    return sbf_log.build(number & 0x1FFF, number >> 13, tow, week, bytes([len(kept)]) + body[1:])


def of_antenna(epochs, antenna):
    """The epochs as the one antenna sees them, with its bits cleared: convbin does not look at them."""
    cleared = lambda sub, at: sub[:at] + bytes([sub[at] & 31]) + sub[at + 1 :]
    for block in epochs:
        kept = [
            (cleared(first, 1), [cleared(other, 0) for other in others if other[0] >> 5 == antenna])
            for first, others in groups(block)
            if first[1] >> 5 == antenna
        ]
        yield with_groups(block, kept)


def renamed(epochs):
    """Only the satellites that convbin does not know, under numbers that it does know.

    Returns the epochs and {convbin's name: true name}."""
    unknown = sorted({first[2] for block in epochs for first, _ in groups(block)})
    unknown = [svid for svid in unknown if satellite(svid)[1] > KNOWN[satellite(svid)[0]]]
    free = {s: iter(range(120 if s == "S" else 1, KNOWN[s] + 1)) for s in KNOWN}
    base = {"G": 0, "R": 37, "E": 70, "C": 140, "I": 190, "S": 0}
    number = {}
    for svid in unknown:
        system = satellite(svid)[0].replace("J", "G")
        number[svid] = base[system] + next(free[system])
    made = []
    for block in epochs:
        kept = [
            as_known(first, others, number[first[2]]) for first, others in groups(block) if first[2] in number
        ]
        made.append(with_groups(block, [group for group in kept if group]))
    return made, {name(number[svid]): name(svid) for svid in unknown}


def as_known(first, others, svid):
    """A group under another number, QZSS as GPS. None when its first signal has no counterpart."""
    if satellite(first[2])[0] == "J":
        if first[1] not in QZSS_AS_GPS:
            return None
        first = first[:1] + bytes([QZSS_AS_GPS[first[1]]]) + first[2:]
        others = [bytes([QZSS_AS_GPS[o[0]]]) + o[1:] for o in others if o[0] in QZSS_AS_GPS]
    return first[:2] + bytes([svid]) + first[3:19] + bytes([len(others)]), others


def convbin(path, option):
    """{(ms of GPS time, satellite, type of observable): text} of convbin's RINEX."""
    command = ["convbin", "-r", "sbf", "-v", "3.04", "-od", "-os", "-f", "5", "-o", "cb.obs", "-n", "cb.nav"]
    pathlib.Path("cb.obs").unlink(missing_ok=True)
    run = subprocess.run(command + (["-ro", option] if option else []) + [path], capture_output=True)
    assert run.returncode == 0, run.stderr
    if not pathlib.Path("cb.obs").exists():
        return {}
    lines = iter(pathlib.Path("cb.obs").read_text().splitlines())
    types, found = {}, {}
    for line in lines:
        if line[60:].startswith("SYS / # / OBS TYPES"):
            system = line[0] if line[0] != " " else system  # a blank continues the line above
            types[system] = types.get(system, []) + line[7:58].split()
        if line[60:].startswith("END OF HEADER"):
            break
    for line in lines:
        if line[0] == ">":
            y, month, day, h, m, s = line[2:29].split()
            days = (datetime.date(int(y), int(month), int(day)) - datetime.date(1980, 1, 6)).days
            ms = round(((days * 24 + int(h)) * 60 + int(m)) * 60000 + float(s) * 1000)
            continue
        system, number = line[0], int(line[1:3])
        sat = f"S{number + 100}" if system == "S" else f"{system}{number:02d}"
        for k, kind in enumerate(types[system]):
            text = line[3 + 16 * k : 17 + 16 * k].strip()
            if text:
                found[ms, sat, kind] = text
    return found


def all_of_convbin(epochs, path, names):
    """What convbin finds in all its passes. They must agree with each other."""
    found = {}
    pathlib.Path(path).write_bytes(b"".join(epochs))
    for option in SHARED:
        for (ms, sat, kind), text in convbin(path, option).items():
            if names is not None and sat not in names:
                continue
            key = ms, names[sat] if names else sat, kind
            assert found.setdefault(key, text) == text, (key, option, text, found[key])
    return found


def ours(path, antenna):
    """The same of sbf2csv's obs table, and the frequencies' channel numbers of GLONASS."""
    command = [SBF2CSV, "-q", "-t", "obs", "--antenna", antenna, path]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode in (0, 1, 4), run.stderr
    found, channels = {}, {}
    for row in csv.DictReader(run.stdout.splitlines()):
        ms = round((int(row["gps_week"]) * 604800 + decimal.Decimal(row["tow_s"])) * 1000)
        for letter, column in COLUMNS.items():
            found[ms, row["sat"], letter + row["signal"]] = row[column]
        channels[ms, row["sat"]] = row["glonass_channel"]
    return found, channels


def frequency(sat, signal, channel):
    if sat[0] == "R" and signal[0] in "12":
        return (1602e6 + 562500 * int(channel)) if signal[0] == "1" else (1246e6 + 437500 * int(channel))
    if sat[0] == "R":
        return 1202.025e6
    beidou = {"2": 1561.098e6, "7": 1207.14e6, "6": 1268.52e6}
    others = {"1": 1575.42e6, "2": 1227.6e6, "5": 1176.45e6, "6": 1278.75e6, "7": 1207.14e6, "8": 1191.795e6}
    return (beidou if sat[0] == "C" else others)[signal[0]]


def equal(letter, mine, theirs):
    if letter == "S":
        return decimal.Decimal(mine) * 4 % 256 == decimal.Decimal(theirs) * 1000
    if letter != "D":
        return decimal.Decimal(mine).quantize(decimal.Decimal("0.001")) == decimal.Decimal(theirs)
    ends = [numpy.float32(float(mine) + half) for half in (-0.00005, 0.00005)]
    low, high = (decimal.Decimal(f"{float(end):.3f}") for end in ends)
    return low <= decimal.Decimal(theirs) <= high


def verdict(key, mine, theirs, channels):
    """ "equal", the rule that explains the difference, or None."""
    ms, sat, kind = key
    letter, signal = kind[0], kind[1:]
    value = mine.get(key, "")
    if sat[0] + signal in UNNAMED or sat[0] + signal == "C1C":
        return "signal"
    if value and theirs is not None:
        return "equal" if equal(letter, value, theirs) else None
    if value:
        return "zero" if float(value) == 0 else None
    if theirs is None:
        return "absent in both"
    if letter == "S":
        return (
            "mark" if theirs in ("0.039", "0.255") else None
        )  # 255 quarters with and without 10 dB-Hz, modulo 256
    if letter == "D":
        return "mark" if float(theirs) < -150000 else None
    code = mine.get((ms, sat, "C" + signal), "")
    if not code:  # offsets alone: at most 262 m of code, 8389 cycles and those of the code
        return "alone" if abs(float(theirs)) < {"C": 263, "L": 9900}[letter] else None
    carrier = float(code) * frequency(sat, signal, channels[ms, sat]) / SPEED_OF_LIGHT - 8388.608
    return "carrier" if abs(carrier - float(theirs)) < 0.00101 else None


def compare(label, path, counts):
    log = pathlib.Path(path).read_bytes()
    epochs = [block for block in sbf_log.blocks(log) if sbf_log.block_id(block) == sbf_log.MEAS_EPOCH]
    here = collections.Counter()
    for bits, antenna in enumerate(("main", "aux1", "aux2")):
        seen = list(of_antenna(epochs, bits))
        mine, channels = ours(path, antenna)
        other, names = renamed(seen)
        theirs = all_of_convbin(seen, "as_is.sbf", None) | all_of_convbin(other, "renamed.sbf", names)
        for key in mine.keys() | theirs.keys():
            rule = verdict(key, mine, theirs.get(key), channels)
            assert rule, (label, antenna, key, "sbf2csv", mine.get(key), "convbin", theirs.get(key))
            here[rule] += 1
    if here:
        print(
            f"{label}: {sum(here.values())} observables,",
            ", ".join(f"{n} {rule}" for rule, n in here.items()),
        )
    counts += here


def random_epoch(rng, tow_ms):
    """A MeasEpoch of random measurements of all signals that convbin can name, on three antennas."""
    systems = {
        "G": (range(1, 38), [0, 1, 2, 3, 4]),
        "R": ([*range(38, 62), *range(63, 69)], [8, 9, 10, 11, 12]),
        "E": (range(71, 107), [17, 19, 20, 21, 22]),
        "S": ([*range(120, 141), *range(198, 216)], [24, 25]),
        "C": ([*range(141, 181), *range(223, 246)], [28, 29, 30]),
        "J": (range(181, 188), [6, 7, 26]),
        "I": ([*range(191, 198), *range(216, 223)], [15]),
    }
    body = b""
    satellites = [
        (s, svid) for s, (svids, _) in systems.items() for svid in rng.sample(list(svids), min(6, len(svids)))
    ]
    for system, svid in satellites:
        signals = rng.sample(systems[system][1], rng.randint(1, len(systems[system][1])))
        if signals[0] == 12:  # the others would have no frequency number
            signals.reverse()
        body += random_group(rng, svid, signals, rng.choice([0, 0, 1, 2]))
    head = bytes([len(satellites), 20, 12, 0, 0, 0])
    return sbf_log.build(sbf_log.MEAS_EPOCH, 1, tow_ms, 2400, head + body)


def random_group(rng, svid, signals, antenna):
    rare = lambda mark, value: mark if rng.random() < 0.02 else value
    info = rng.randint(1, 14) << 3 | rng.choice([0, 1, 4])
    code = rare(0, rng.randint(19000000000, 42000000000))
    carrier = rare((-128, 0), (rng.randint(-127, 127), rng.randint(0, 65535)))
    doppler = rare(-(2**31), rng.randint(-60000000, 60000000))
    cn0 = rare(255, rng.randint(30, 215))
    others = signals[1:]
    out = struct.pack("<BBBBIiHbBHBB", rng.randint(1, 99), antenna << 5 | signals[0], svid, code >> 32, code & 0xFFFFFFFF,
                      doppler, carrier[1], carrier[0], cn0, rng.randint(0, 65535), info, len(others))  # fmt: skip
    for signal in others:
        offset = rare((-4, 0), (rng.randint(-4, 3), rng.randint(1, 65535)))
        carrier = rare((-128, 0), (rng.randint(-127, 127), rng.randint(0, 65535)))
        shift = rare((-16, 0), (rng.randint(-16, 15), rng.randint(1, 65535)))
        msb = offset[0] & 7 | (shift[0] & 31) << 3
        out += struct.pack("<BBBBbBHHH", antenna << 5 | signal, rng.randint(0, 255), rare(255, rng.randint(30, 215)), msb,
                           carrier[0], info, offset[1], carrier[1], shift[1])  # fmt: skip
    return out


def main():
    if shutil.which("convbin") is None:
        print("skipped: no convbin (Debian package rtklib)")
        return SKIPPED
    counts = collections.Counter()
    logs = sorted([*DATA.glob("*.sbf"), *DATA.glob("pysbf2/*.log")])
    for log in logs:
        compare(log.name, log, counts)
    if not logs:
        print(f"no logs in {DATA}: only random measurements")
    else:
        with_signals = [
            log
            for log in (DATA / "log_0000.sbf", DATA / "pysbf2/pygpsdata_x5_measurements.log")
            if log in logs
        ]
        pathlib.Path("joined.sbf").write_bytes(b"".join(log.read_bytes() for log in with_signals))
        compare("joined", "joined.sbf", counts)
    rng = random.Random(20261122)
    pathlib.Path("random.sbf").write_bytes(b"".join(random_epoch(rng, 1000 * k) for k in range(60)))
    compare("random", "random.sbf", counts)
    absent = counts.pop("absent in both")
    total = sum(counts.values())
    print(
        f"all: {total} observables, {counts['equal']} equal, {total - counts['equal']} explained; {absent} absent in both"
    )
    assert counts["equal"] > 3000
    return 0


if __name__ == "__main__":
    sys.exit(main())
