#!/usr/bin/env python3
"""Random blocks of each type that sbf2csv decodes, written here from the tables of the SBF reference guides, come out of
it with the values that went in: every column, every revision, marks of "not available", sub-blocks longer than known.

Nothing here knows furrow's own tables: sbf_tables.py says where a block has its fields, sbf_random.py makes blocks of it,
and the functions below are for what a table does not describe."""

import collections
import csv
import functools
import math
import os
import pathlib
import random
import struct
import subprocess
import sys
from fractions import Fraction

sys.dont_write_bytecode = True  # leave nothing in the source tree
import numpy
import sbf_log
import sbf_tables
from sbf_random import WEEK, draw_fields, load_fields, load_tables, satellite, svids

SBF2CSV = pathlib.Path(os.environ["BIN"]) / "sbf2csv"
SRC = pathlib.Path(os.environ["SRC"])
ROUNDS = 200
SPEED_OF_LIGHT = 299792458
# Decimals of double columns by their ending; of what satellites send all digits are there.
DECIMALS = {
    "tow_s": 9,
    "_deg": 9,
    "_m": 4,
    "_mps": 4,
    "_mps2": 9,
    "_radps": 9,
    "_cyc": 3,
    "_hz": 4,
    "_hz2": 6,
}
EXACT = ("eph_", "sbas", "satpos")


@functools.cache
def record_columns(record):
    """{column: whether it is of single precision}"""
    lines = (SRC / f"formats/records/{record}.lcm").read_text().splitlines()
    return {
        line.split()[1].rstrip(";"): line.startswith("\tfloat ") for line in lines if line.startswith("\t")
    }


def tolerance(record, column, value):
    """What printing may cost."""
    single = record_columns(record)[column]
    decimals = [n for end, n in DECIMALS.items() if column.endswith(end) and not single]
    printed = (
        0.5 * 10 ** -decimals[0] * (1 + 1e-9)
        if decimals and (column == "tow_s" or not record.startswith(EXACT))
        else 0
    )
    return printed + abs(value) * (1.3e-7 if single else 5e-16)


def same(record, column, text, value):
    """value: None, text, a number, or a number with its tolerance."""
    if value is None or isinstance(value, str):
        return text == (value or "")
    number, allowed = value if isinstance(value, tuple) else (value, 0)
    return text != "" and abs(float(text) - number) <= allowed + tolerance(record, column, number)


def check(record, blocks, expected, *options):
    """blocks: those of a log; expected: (tow_s, {column: value}) for each row; columns not named there are empty."""
    path = pathlib.Path(f"{record}.sbf")
    path.write_bytes(b"".join(blocks))
    run = subprocess.run(
        [SBF2CSV, "-q", "-t", record, *options, path], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, (record, run.returncode, run.stderr)
    rows = list(csv.DictReader(run.stdout.splitlines()))
    faults = collections.Counter()
    for n, (row, (tow, values)) in enumerate(zip(rows, expected)):
        values = {"gps_week": WEEK, "tow_s": tow} | values
        assert values.keys() <= row.keys(), (record, values.keys() - row.keys())
        for column, text in row.items():
            if not same(record, column, text, values.get(column)):
                faults[column] += 1
                if faults[column] == 1:
                    print(f"{record}: row {n}: {column} is '{text}', not {values.get(column)!r}")
    if len(rows) != len(expected):
        print(f"{record}: {len(rows)} rows, not {len(expected)}")
        faults["rows"] += 1
    values = len(rows) * len(rows[0]) if rows else 0
    print(f"{record}: {len(rows)} rows, {values} values" + f", {sum(faults.values())} wrong" * bool(faults))
    return values, not faults


def stamps(rng):
    return [1000 * n + rng.randint(0, 999) for n in range(ROUNDS)]


def real(rng, scale=1):
    """A random number that a float holds."""
    return float(numpy.float32(rng.uniform(-scale, scale)))


def check_table(table, extra):
    """extra: columns that are not in the block."""
    rng = random.Random(table.number)
    blocks, expected = [], []
    for tow_ms in stamps(rng):
        block, rows = table.random(rng, tow_ms)
        if table.record in ("sbas_mask", "sbas_igp_mask"):
            rows = [row | {"mask_no": n} for n, row in enumerate(rows, 1)]
        blocks.append(block)
        expected += [(tow_ms / 1000, row | extra) for row in rows]
    return check(table.record, blocks, expected)


def check_joined(tables):
    """Blocks that make one row for each epoch, in any order, the first of them always there."""
    rng = random.Random(tables[0].number)
    log, expected = [], []
    for tow_ms in stamps(rng):
        made = [table.random(rng, tow_ms) for table in tables if table is tables[0] or rng.random() < 0.8]
        row = {}
        for _, rows in made:
            row |= rows[0]
        error = (
            made[0][0][14:16] if tables[0].record != "att" else made[0][0][15:16]
        )  # all blocks of an epoch say the same
        blocks = [sbf_log.seal(block[: 16 - len(error)] + error + block[16:]) for block, _ in made]
        rng.shuffle(blocks)
        log += blocks
        expected.append((tow_ms / 1000, row))
    return check(tables[0].record, log, expected)


def check_ins(record, number, head, groups):
    rng = random.Random(number)
    fields = load_fields(head)
    blocks, expected = [], []
    for tow_ms in stamps(rng):
        body = bytearray(rng.randbytes(fields[-1].offset + 2))
        values = draw_fields(rng, fields, body)
        listed = rng.choice(
            [0, 255, rng.randint(0, 255), rng.randint(0, 1023)]
        )  # bits 8 and 9: what nobody knows yet
        body += struct.pack("<H", listed)
        for bit, columns in enumerate(groups):
            if listed >> bit & 1:
                piece = bytearray(12)
                values |= draw_fields(
                    rng, load_fields("\n".join(f"{4 * i} f4 {c}" for i, c in enumerate(columns))), piece
                )
                body += piece
        body += rng.randbytes(12 * (listed >> 8).bit_count())
        blocks.append(sbf_log.build(number, rng.choice([0, 0, 1]), tow_ms, WEEK, bytes(body[14:])))
        expected.append((tow_ms / 1000, values))
    return check(record, blocks, expected)


def check_event():
    """The row's time is that of the event: stamp + offset - clock bias."""
    rng = random.Random(5924)
    blocks, expected = [], []
    for tow_ms in stamps(rng):
        revision = rng.choice([0, 1, 1, 2])
        offset, bias, age = (
            real(rng, 0.5),
            rng.choice([-2e10, rng.uniform(-1e-3, 1e-3)]),
            rng.choice([0, 3, 600]),
        )
        source, polarity = rng.randint(1, 4), rng.randint(0, 1)
        body = struct.pack("<BBfd", source, polarity, offset, bias) + struct.pack("<H", age) * (revision > 0)
        blocks.append(sbf_log.build(5924, revision, tow_ms + 1000, WEEK, body))
        values = {"source": source, "polarity": polarity, "rx_tow_s": tow_ms / 1000 + 1, "offset_s": offset}
        values["clock_bias_s"] = None if bias == -2e10 else bias
        values["pvt_age_s"] = age if revision else None
        expected.append((tow_ms / 1000 + 1 + offset - (values["clock_bias_s"] or 0), values))
    return check("event", blocks, expected)


def rotation(axis, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    matrix = numpy.eye(3)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def sensor_readings(rng):
    """Readings of one ExtSensorMeas: (type, 24 bytes, columns of ext_sensor, vector for imu)."""
    vector = lambda scale: [-2e10 if rng.random() < 0.03 else rng.uniform(-scale, scale) for _ in range(3)]
    shown = lambda values, names: dict(zip(names, [None if v == -2e10 else v for v in values]))
    accel, gyro = vector(30), vector(300)
    rates = [v if v == -2e10 else math.radians(v) for v in gyro]
    speed = [real(rng, 40) for _ in range(6)]
    celsius, still = rng.choice([-32768, rng.randint(-4000, 8500)]), float(rng.randint(0, 1))
    names = lambda text, unit: [f"{text}_{axis}_{unit}" for axis in "xyz"]
    return [
        (0, struct.pack("<3d", *accel), shown(accel, names("accel", "mps2")), accel),
        (1, struct.pack("<3d", *gyro), shown(rates, names("gyro", "radps")), rates),
        (3, struct.pack("<h22x", celsius), {"temperature_degc": None if celsius == -32768 else celsius / 100}, None),
        (4, struct.pack("<6f", *speed),
         shown(speed, ["vx_mps", "vy_mps", "vz_mps", "sd_vx_mps", "sd_vy_mps", "sd_vz_mps"]), None),
        (20, struct.pack("<d16x", still), {"zero_velocity": still}, None),
    ]  # fmt: skip


def sensor_log(rng):
    """A log of ExtSensorMeas and IMUSetup at 50 Hz, the rows of ext_sensor and those of imu."""
    blocks, readings, samples = [], [], []
    mounting = None
    for n in range(ROUNDS):
        tow_ms = 20 * n
        if n % 50 == 10:
            angles = [180.0, 0.0, 90.0] if n == 10 else [real(rng, 180) for _ in range(3)]
            mounting = rotation(2, angles[2]) @ rotation(1, angles[1]) @ rotation(0, angles[0])
            body = struct.pack("<BB6f", 0, 1, 0.1, 0.2, 0.3, *angles) + rng.randbytes(rng.choice([0, 24]))
            blocks.append(sbf_log.build(4224, 0, tow_ms, WEEK, body))
        chosen = [r for r in sensor_readings(rng) if rng.random() < (0.95 if r[0] < 2 else 0.3)]
        size = 28 + rng.choice([0, 0, 4])
        body = bytes([len(chosen), size])
        sample = {}
        for kind, data, columns, vector in chosen:
            body += bytes([1, 10, kind, 0]) + data + bytes(size - 28)
            readings.append((tow_ms / 1000, {"source": 1, "model": 10, "type": kind, "info": 0} | columns))
            if vector and -2e10 not in vector:
                turned = mounting @ vector if mounting is not None else vector
                sample |= zip([c for c in columns], [(v, 1e-13 * numpy.linalg.norm(vector)) for v in turned])
        blocks.append(sbf_log.build(4050, 0, tow_ms, WEEK, body))
        if sample:
            samples.append((tow_ms / 1000, sample))
    return blocks, readings, samples


def check_sensors():
    blocks, readings, samples = sensor_log(random.Random(4050))
    return [check("ext_sensor", blocks, readings), check("imu", blocks, samples)]


def check_satpos(table):
    """Iono and Tropo are made of two fields each."""
    rng = random.Random(4008)
    blocks, expected = [], []
    for tow_ms in stamps(rng):
        block, rows = table.random(rng, tow_ms)
        size = block[15]
        for n, row in enumerate(rows):
            sub = block[16 + n * size :]
            (iono, tropo), fine = struct.unpack_from("<hh", sub, 40), sub[44:46]
            row["iono_m"], row["tropo_m"] = 0.1 * (iono + fine[0] / 256), 0.1 * (tropo + fine[1] / 256)
            expected.append((tow_ms / 1000, row))
        blocks.append(block)
    return check("satpos", blocks, expected)


def check_residual():
    rng = random.Random(4009)
    units = {"code": 0.1, "carrier": 0.01, "doppler": 0.01}
    blocks, expected = [], []
    for tow_ms in stamps(rng):
        n, size1, size2 = rng.randint(0, 4), 12 + rng.choice([0, 4]), 8 + rng.choice([0, 4])
        body = bytes([n, size1, size2, 0, 0, 0])
        for _ in range(n):
            system = rng.choice("GREC")
            svid, antenna = rng.choice(svids(system)), rng.randint(0, 2)
            signal = rng.choice([s for s in sbf_tables.SIGNALS_OF[system] if s < 31])
            channel = rng.randint(1, 14) if system == "R" else 0
            reference, info = rng.choice([0, rng.choice(svids("G"))]), rng.randint(0, 7)
            iode, age, base = rng.randint(0, 999), rng.choice([65535, 123]), rng.choice([65535, 1000])
            kind = signal | antenna << 5
            body += struct.pack("<6BHHH", svid, channel, kind, reference, 0, info, iode, age, base) + bytes(
                size1 - 12
            )
            for bit, (quantity, unit) in enumerate(units.items()):
                if info >> bit & 1:
                    value, weight, mdb = real(rng, 9), rng.randint(0, 65534), rng.choice([65535, 77])
                    body += struct.pack("<fHH", value, weight, mdb) + bytes(size2 - 8)
                    row = {"sat": satellite(svid), "glonass_channel": channel - 8 if system == "R" else None,
                           "signal": sbf_tables.SIGNALS[signal][0], "antenna": antenna, "iode": iode,
                           "ref_sat": satellite(reference), "corr_age_s": None if age == 65535 else age / 100,
                           "reference_id": None if base == 65535 else base, "quantity": quantity, "residual": value,
                           "weight": weight / 1000, "mdb": None if mdb == 65535 else mdb * unit}  # fmt: skip
                    expected.append((tow_ms / 1000, row))
        blocks.append(sbf_log.build(4009, 1, tow_ms, WEEK, body))
    return check("residual", blocks, expected)


def check_array(record, number, head, length, first_row, column):
    """A block that ends in an array of u1, one row for each of its elements."""
    rng = random.Random(number)
    fields = load_fields(head, False)
    blocks, expected = [], []
    for tow_ms in stamps(rng):
        body = bytearray(rng.randbytes(first_row))
        values = draw_fields(rng, fields, body)
        array = [rng.randint(0, 15) for _ in range(length)]
        blocks.append(sbf_log.build(number, 0, tow_ms, WEEK, bytes(body[14:]) + bytes(array)))
        expected += [(tow_ms / 1000, values | {"mask_no": n, column: x}) for n, x in enumerate(array, 1)]
    extra = {"source": "decoded"}
    return check(record, blocks, [(tow, row | extra) for tow, row in expected])


def check_pages():
    rng = random.Random(4017)
    blocks, expected = [], []
    for number, (system, words, message) in sbf_tables.PAGES.items():
        for tow_ms in range(number * 1000, number * 1000 + 9000, 1000):
            svid, signal = rng.choice(svids(system)), rng.choice(
                [s for s in sbf_tables.SIGNALS_OF[system] if s < 31]
            )
            both, channel, ok, errors, receiver = (rng.randint(0, 1), rng.randint(1, 14), rng.randint(0, 1),
                                                   rng.randint(0, 200), rng.randint(1, 99))  # fmt: skip
            source = signal | (both << 5 if number == 4023 else 0)
            data = [rng.getrandbits(32) for _ in range(words)]
            body = struct.pack(
                f"<6B{words}I", svid, ok, errors, source, channel if system == "R" else 0, receiver, *data
            )
            blocks.append(sbf_log.build(number, 0, tow_ms, WEEK, body))
            row = {"sat": satellite(svid), "message": message, "crc_ok": ok, "viterbi": errors, "rx_channel": receiver,
                   "signal": sbf_tables.SIGNALS[signal][0], "bits": "".join(f"{word:08X}" for word in data),
                   "e1_e5b": both if number == 4023 else None,
                   "glonass_channel": channel - 8 if system == "R" else None}  # fmt: skip
            expected.append((tow_ms / 1000, row))
    return check("page", blocks, expected)


def check_sbas():
    rng = random.Random(4020)
    blocks, expected = [], []
    for n, tow_ms in enumerate(stamps(rng)):
        message = [0x53, 0x9A, 0xC6][n % 3] << 242 | rng.getrandbits(242)
        kind, signal, ok = (
            message >> (236, 240)[n % 2] & 63,
            24 + n % 2,
            rng.randint(0, 1),
        )  # L5: preamble of 4 bits
        svid = rng.choice(svids("S"))
        words = (message << 6).to_bytes(32, "big")
        body = bytes([svid, ok, 3, signal, 0, 17]) + b"".join(words[i : i + 4][::-1] for i in range(0, 32, 4))
        blocks.append(sbf_log.build(4020 + n % 2, 0, tow_ms, WEEK, body))
        row = {"sat": satellite(svid), "signal": sbf_tables.SIGNALS[signal][0], "type": kind, "crc_ok": ok, "viterbi": 3,
               "rx_channel": 17, "bits": f"{message << 2:063X}"}  # fmt: skip
        expected.append((tow_ms / 1000, row))
    return check("sbas", blocks, expected)


def check_comment():
    rng = random.Random(5936)
    texts = ["", "plain", 'with "quotes", commas', "end", "x" * 200]
    blocks, expected = [], []
    for tow_ms in stamps(rng):
        text = rng.choice(texts)
        blocks.append(sbf_log.build(5936, 0, tow_ms, WEEK, struct.pack("<H", len(text)) + text.encode()))
        expected.append((tow_ms / 1000, {"text": text}))
    return check("comment", blocks, expected)


def measured(rng, mark, value):
    return mark if rng.random() < 0.05 else value


def random_measurement(rng, system, signal, channel):
    """The fields that sub-blocks of both types have."""
    info = rng.randint(0, 1) | rng.randint(0, 1) << 2
    info |= signal - 32 << 3 if signal >= 31 else channel + 8 << 3 if 8 <= signal <= 11 else 0
    carrier = measured(rng, (-128, 0), (rng.randint(-127, 127), rng.randint(0, 65535)))
    return min(signal, 31), info, carrier, measured(rng, 255, rng.randint(20, 230))


def observed(signal, info, cn0, lock, lock_mark):
    strength = None if cn0 == 255 else cn0 / 4 + (0 if signal in (1, 2) else 10)
    return {"cn0_dbhz": strength, "lock_s": None if lock == lock_mark else lock, "half_cycle": info >> 2 & 1,
            "smoothed": info & 1}  # fmt: skip


def cycles(code_mm, frequency, carrier):
    """Carrier phase in cycles, exactly, from the pseudorange in millimetres."""
    if carrier == (-128, 0) or code_mm is None:
        return None
    return float(Fraction(code_mm, 1000) * Fraction(frequency) / SPEED_OF_LIGHT
                 + Fraction(carrier[0] * 65536 + carrier[1], 1000))  # fmt: skip


def random_satellite(rng, receiver, e6b):
    """Sub-blocks of a MeasEpoch for one satellite. Returns its bytes, the rows of obs and the keys of MeasExtra."""
    system = rng.choice("GRECSJI")
    svid, antenna, channel = rng.choice(svids(system)), rng.choice([0, 0, 1]), rng.randint(-7, 6)
    signals = rng.sample(sbf_tables.SIGNALS_OF[system], rng.randint(1, len(sbf_tables.SIGNALS_OF[system])))
    if signals[0] == 12:
        signals.reverse()  # the first one tells the others their frequency number
    code = measured(rng, None, rng.randint(19000000000, 42000000000))
    doppler = measured(rng, None, rng.randint(-60000000, 60000000))
    hz = lambda s: int(sbf_tables.SIGNALS[s][1] + 0.5) + channel * (sbf_tables.SIGNALS[s] + (0,))[2]
    name = lambda s: "6B" if e6b and s == 19 else sbf_tables.SIGNALS[s][0]
    common = {"sat": satellite(svid), "antenna": antenna, "rx_channel": receiver}
    fdma = any(8 <= s <= 11 for s in signals[:1])
    out, rows, keys = b"", [], []
    for n, signal in enumerate(signals):
        low, info, carrier, cn0 = random_measurement(rng, system, signal, channel)
        if n == 0:
            lock = measured(rng, 65535, rng.randint(0, 65534))
            out += struct.pack("<BBBBIiHbBHBB", receiver, antenna << 5 | low, svid, (code or 0) >> 32 | rng.getrandbits(4) << 4,
                               (code or 0) & 0xFFFFFFFF, -(2**31) if doppler is None else doppler, carrier[1], carrier[0],
                               cn0, lock, info, len(signals) - 1)  # fmt: skip
            mm, rate = code, None if doppler is None else Fraction(doppler, 10000)
        else:
            lock = measured(rng, 255, rng.randint(0, 254))
            offset = measured(rng, (-4, 0), (rng.randint(-4, 3), rng.randint(1, 65535)))
            shift = measured(rng, (-16, 0), (rng.randint(-16, 15), rng.randint(1, 65535)))
            out += struct.pack("<BBBBbBHHH", antenna << 5 | low, lock, cn0, offset[0] & 7 | (shift[0] & 31) << 3, carrier[0],
                               info, offset[1], carrier[1], shift[1])  # fmt: skip
            mm = None if code is None or offset == (-4, 0) else code + offset[0] * 65536 + offset[1]
            rate = None
            if doppler is not None and shift != (-16, 0):
                rate = Fraction(doppler * hz(signal), 10000 * hz(signals[0])) + Fraction(
                    shift[0] * 65536 + shift[1], 10000
                )
        row = common | observed(signal, info, cn0, lock, 65535 if n == 0 else 255)
        row |= {"signal": name(signal), "glonass_channel": channel if fdma else None}
        row["pseudorange_m"] = None if mm is None else mm / 1000
        row["carrier_cyc"] = cycles(mm, hz(signal), carrier)
        row["doppler_hz"] = None if rate is None else float(rate)
        rows.append(row)
        keys.append((receiver, signal, antenna, satellite(svid), name(signal)))
    return out, rows, keys


def random_extra(rng, keys, revision):
    """A MeasExtra for these signals: its body and the rows of obs_extra."""
    size = 12 if revision == 0 else 16
    factor = abs(real(rng, 5))
    body = struct.pack("<BBf", len(keys), size, factor)
    rows = []
    for receiver, signal, antenna, sat, name in keys:
        multipath, smoothing = rng.randint(-32767, 32767), rng.randint(-32767, 32767)
        code, carrier, lock = rng.choice([65535, 400]), rng.choice([65535, 9000]), rng.choice([65535, 60])
        losses, phase, info, fine = (
            rng.randint(0, 254),
            rng.randint(-127, 127),
            rng.randint(0, 254),
            rng.randint(0, 7),
        )
        body += struct.pack(
            "<BBhhHHH", receiver, antenna << 5 | min(signal, 31), multipath, smoothing, code, carrier, lock
        )
        body += struct.pack("<BbBB", losses, phase, info, fine | max(signal - 32, 0) << 3)[: size - 12]
        row = {"sat": sat, "signal": name, "antenna": antenna, "rx_channel": receiver,
               "multipath_corr_m": multipath / 1000, "smoothing_corr_m": smoothing / 1000,
               "code_var_m2": None if code == 65535 else code * 1e-4,
               "carrier_var_cyc2": None if carrier == 65535 else carrier * 1e-6,
               "doppler_var_hz2": None if carrier == 65535 else carrier * 1e-6 * factor,
               "lock_s": None if lock == 65535 else lock}  # fmt: skip
        if revision >= 1:
            row |= {"loss_count": losses, "carrier_multipath_corr_cyc": phase / 512}
        if revision >= 2:
            row["info"] = info
        if revision >= 3:
            row["cn0_highres_dbhz"] = fine * 0.03125
        rows.append((row, signal))
    return body, rows


def check_measurements():
    rng = random.Random(4027)
    blocks, observations, epochs, extras = [], [], [], []
    for tow_ms in stamps(rng):
        # bit 7 stays 0: scrambled epochs are left out
        revision, flags, jumps = rng.randint(0, 2), rng.randint(0, 255) & 0x6B, rng.randint(0, 254)
        out, keys, rows = b"", [], []
        n = rng.randint(1, 12)
        for receiver in range(1, n + 1):
            piece, satellite_rows, satellite_keys = random_satellite(rng, receiver, flags >> 6 & 1)
            out, rows, keys = out + piece, rows + satellite_rows, keys + satellite_keys
        head = bytes([n, 20, 12, flags, jumps, 0])
        blocks.append(sbf_log.build(4027, revision, tow_ms, WEEK, head + out))
        tow = tow_ms / 1000
        observations += [(tow, row) for row in rows]
        flag = lambda bit: flags >> bit & 1
        epochs.append((tow, {"n_signals": len(rows), "multipath_mitigation": flag(0), "smoothed": flag(1),
                             "clock_steering": flag(3), "high_dynamics": flag(5), "e6b": flag(6), "scrambled": flag(7),
                             "clock_jumps_ms": jumps if revision else None}))  # fmt: skip
        revision = rng.randint(0, 3)
        keys = [key for key in keys if key[1] < 31 or revision >= 3]  # earlier ones cannot say which
        keys = [key for key in keys if key[4] != "6B"]  # MeasExtra does not know E6B from E6C
        body, extra = random_extra(rng, keys, revision)
        blocks.append(sbf_log.build(4000, revision, tow_ms, WEEK, body))
        extras += [(tow, row) for row, _ in extra]
    return [check("obs", blocks, observations, "--antenna", "all"), check("epoch", blocks, epochs),
            check("obs_extra", blocks, extras, "--antenna", "all")]  # fmt: skip


def main():
    satpos = next(t for t in load_tables(sbf_tables.TABLES) if t.record == "satpos")
    results = [check_table(table, {}) for table in load_tables(sbf_tables.TABLES) if table.record != "satpos"]
    for table in load_tables(sbf_tables.NAVIGATION, False):
        results.append(check_table(table, {"source": "decoded"}))
    joined = collections.defaultdict(list)
    for table in load_tables(sbf_tables.JOINED):
        joined[table.record].append(table)
    results += [check_joined(tables) for tables in joined.values()]
    results += [
        check_ins("ins", 4226, sbf_tables.INS_GEODETIC, sbf_tables.INS_GEODETIC_GROUPS),
        check_ins("event_ins", 4230, sbf_tables.INS_GEODETIC, sbf_tables.INS_GEODETIC_GROUPS),
        check_ins("ins_ecef", 4225, sbf_tables.INS_CARTESIAN, sbf_tables.INS_CARTESIAN_GROUPS),
        check_ins("event_ins_ecef", 4229, sbf_tables.INS_CARTESIAN, sbf_tables.INS_CARTESIAN_GROUPS),
        check_event(),
        *check_sensors(),
        check_satpos(satpos),
        check_residual(),
        check_array("sbas_integrity", 5928, "14 u1 sat sat:S\n16 u1 iodf2\n17 u1 iodf3\n18 u1 iodf4\n19 u1 iodf5", 51, 20, "udrei"),
        check_array("sbas_degradation", 5929, "14 u1 sat sat:S\n15 u1 iodp\n16 u1 latency_s", 51, 17, "ai"),
        check_pages(),
        check_sbas(),
        check_comment(),
        *check_measurements(),
    ]  # fmt: skip
    good = sum(ok for _, ok in results)
    print(
        f"{good} of {len(results)} kinds of blocks come out as they went in, {sum(n for n, _ in results)} values"
    )
    return 0 if good == len(results) else 1


if __name__ == "__main__":
    sys.exit(main())
