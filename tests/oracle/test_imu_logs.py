#!/usr/bin/env python3
"""Autopilots' logs: what pymavlink and pyulog find in a log, sbf2csv finds too.

The logs are made here, with the message definitions of ArduPilot and PX4 packed by struct; the oracles read the same bytes.
"""
import csv
import io
import math
import os
import pathlib
import random
import struct
import subprocess
import sys

sys.dont_write_bytecode = True  # leave nothing in the source tree
try:
    from pymavlink import DFReader
    from pyulog import ULog
except ImportError:
    print("skipped: no pymavlink or pyulog")
    sys.exit(77)

SBF2CSV = pathlib.Path(os.environ["BIN"]) / "sbf2csv"
WEEK, BOOT_TOW = 2300, 1000  # the autopilots were switched on then
LATENCY_US = 120000          # what furrow takes for the least one of ArduPilot; of PX4 it is 110000
GPS_EPOCH_UNIX = 315964800
LEAP = 18


def table(kind, *arguments):
    """A table of sbf2csv as a list of {column: number}."""
    text = subprocess.run([SBF2CSV, "-q", "-t", kind, *arguments], check=True, capture_output=True, text=True).stdout
    return [{k: float(v) for k, v in row.items() if v not in ("", "autopilot")} for row in csv.DictReader(io.StringIO(text))]


def near(a, b, tolerance=1e-6):
    assert abs(a - b) <= tolerance * (1 + abs(b)), (a, b)


# ---- ArduPilot ----

FORMATS = {  # name: (number, format, columns); libraries/*/LogStructure.h
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "IMU": (150, "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
    "MAG": (151, "QBhhhhhhhhhBI", "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S"),
    "BARO": (152, "QBffcfIffB", "TimeUS,I,Alt,Press,Temp,CRt,SMS,Offset,GndTemp,Health"),
    "GPS": (153, "QBBIHBcLLeffffB", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U"),
    "GPA": (154, "QBCCCCfBIHeHH", "TimeUS,I,VDop,HAcc,VAcc,SAcc,YAcc,VV,SMS,Delta,AEl,RTCMFU,RTCMFD"),
    "ATT": (155, "QccccCCCCB", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,ErrRP,ErrYaw,AEKF"),
}
PACK = {"b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d", "c": "h", "C": "H", "e": "i",
        "E": "I", "L": "i", "M": "B", "q": "q", "Q": "Q", "n": "4s", "N": "16s", "Z": "64s"}


def pack(name, *values):
    number, form, _ = FORMATS[name]
    return struct.pack("<BBB" + "".join(PACK[c] for c in form), 0xa3, 0x95, number, *values)


def make_dataflash(path, dice):
    """Twenty seconds: IMU 50 Hz, MAG and ATT 10 Hz, BARO and GPS 5 Hz; messages of fixes 120 ms late or more."""
    with open(path, "wb") as log:
        for name, (number, form, columns) in FORMATS.items():
            length = struct.calcsize("<" + "".join(PACK[c] for c in form)) + 3
            log.write(pack("FMT", number, length, name.encode(), form.encode(), columns.encode()))
        for i in range(1000):
            us = 5000000 + 20000 * i
            log.write(pack("IMU", us, 0, *(dice.uniform(-5, 5) for _ in range(6)), 0, 0, 30.0, 1, 1, 1000, 1000))
            if i % 5 == 0:
                log.write(pack("MAG", us, 0, *(dice.randrange(-500, 500) for _ in range(9)), 1, 0))
                log.write(pack("ATT", us, 0, dice.randrange(-9000, 9000), 0, dice.randrange(-4500, 4500), 0,
                               dice.randrange(36000), 0, 0, 3))
            if i % 10 == 0:
                late = LATENCY_US if i == 500 else LATENCY_US + dice.randrange(30000)
                fix_ms = BOOT_TOW * 1000 + us // 1000 - late // 1000
                log.write(pack("BARO", us, 0, dice.uniform(-10, 100), 95000.0, 2500, 0.0, us // 1000, 0.0, 20.0, 1))
                log.write(pack("GPS", us, 0, dice.choice([3, 4, 5, 6]), fix_ms, WEEK, dice.randrange(30), 80,
                               dice.randrange(-900000000, 900000000), dice.randrange(-1800000000, 1800000000),
                               dice.randrange(100000), dice.uniform(0, 30), dice.uniform(0, 360), dice.uniform(-5, 5), 0.0, 1))
                log.write(pack("GPA", us, 0, 100, dice.randrange(1, 999), dice.randrange(1, 999), dice.randrange(1, 99), 0.0,
                               1, us // 1000, 200, dice.randrange(100000), 0, 0))


def compare_dataflash(path):
    log = DFReader.DFReader_binary(str(path))
    expected = {name: [] for name in FORMATS}
    while (message := log.recv_msg()) is not None:
        if message.get_type() in expected:
            expected[message.get_type()].append(message)
    rows = {kind: table(kind, path) for kind in ("imu", "mag", "baro", "nav", "pvt")}
    for kind, name in (("imu", "IMU"), ("mag", "MAG"), ("baro", "BARO"), ("nav", "ATT"), ("pvt", "GPS")):
        assert len(rows[kind]) == len(expected[name]) > 0, (kind, len(rows[kind]), len(expected[name]))
    for row, m in zip(rows["imu"], expected["IMU"]):
        # the clock is that of the least latency within its 50 ppm
        near(row["tow_s"], BOOT_TOW + m.TimeUS * 1e-6, 2e-6)
        for axis in "xyz":
            near(row[f"gyro_{axis}_radps"], getattr(m, "Gyr" + axis.upper()), 1e-8)
            near(row[f"accel_{axis}_mps2"], getattr(m, "Acc" + axis.upper()), 1e-8)
    for row, m in zip(rows["mag"], expected["MAG"]):
        for axis in "xyz":
            near(row[f"mag_{axis}_ut"], getattr(m, "Mag" + axis.upper()) / 10)  # milligauss
    for row, m in zip(rows["baro"], expected["BARO"]):
        near(row["baro_height_m"], m.Alt, 1e-4)
    for row, m in zip(rows["nav"], expected["ATT"]):
        near(row["roll_deg"], m.Roll), near(row["pitch_deg"], m.Pitch), near(row["heading_deg"], m.Yaw)
    for row, m, a in zip(rows["pvt"], expected["GPS"], expected["GPA"]):
        near(row["tow_s"], m.GMS / 1000), near(row["lat_deg"], m.Lat, 1e-9), near(row["lon_deg"], m.Lng, 1e-9)
        near(row["height_m"], a.AEl), near(row["undulation_m"], a.AEl - m.Alt, 1e-5)
        near(row["vn_mps"], m.Spd * math.cos(math.radians(m.GCrs)), 1e-4)
        near(row["ve_mps"], m.Spd * math.sin(math.radians(m.GCrs)), 1e-4)
        near(row["vd_mps"], m.VZ, 1e-4), near(row["sd_d_m"], a.VAcc, 1e-3)
        near(math.hypot(row["sd_n_m"], row["sd_e_m"]), a.HAcc, 1e-3)
        assert row["mode"] == {3: 1, 4: 2, 5: 5, 6: 4}[m.Status] and row["n_sats"] == m.NSats
    print(f"{path}: as pymavlink, {sum(map(len, rows.values()))} records")


# ---- PX4 ----

TOPICS = {  # name: (fields without the timestamp, struct)
    "sensor_combined": ("float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;"
                        "float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;", "3fIi3fI"),
    "vehicle_magnetometer": ("uint64_t timestamp_sample;uint32_t device_id;float[3] magnetometer_ga;", "QI3f"),
    "vehicle_air_data": ("uint64_t timestamp_sample;float baro_alt_meter;", "Qf"),
    "vehicle_attitude": ("uint64_t timestamp_sample;float[4] q;", "Q4f"),
    "vehicle_gps_position": ("double latitude_deg;double longitude_deg;double altitude_msl_m;double altitude_ellipsoid_m;"
                             "uint64_t time_utc_usec;float eph;float epv;float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;"
                             "uint8_t fix_type;uint8_t satellites_used;", "4dQ5f2B"),
}


def make_ulog(path, dice):
    numbers = {name: i for i, name in enumerate(TOPICS)}
    with open(path, "wb") as log:

        def message(kind, payload):
            log.write(struct.pack("<Hc", len(payload), kind) + payload)

        def data(name, us, *values):
            message(b"D", struct.pack("<HQ" + TOPICS[name][1], numbers[name], us, *values))

        log.write(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1000))
        message(b"B", bytes(40))
        for name, (fields, _) in TOPICS.items():
            message(b"F", f"{name}:uint64_t timestamp;{fields}".encode())
        for name, number in numbers.items():
            message(b"A", struct.pack("<BH", 0, number) + name.encode())
        for i in range(1000):
            us = 5000000 + 5000 * i
            data("sensor_combined", us, *(dice.uniform(-5, 5) for _ in range(3)), 5000, 0,
                 *(dice.uniform(-20, 20) for _ in range(3)), 5000)
            if i % 10 == 0:
                data("vehicle_magnetometer", us, us - 500, 1, *(dice.uniform(-1, 1) for _ in range(3)))
                data("vehicle_air_data", us, us - 500, dice.uniform(0, 500))
                angles = [dice.uniform(-math.pi, math.pi), dice.uniform(-1.5, 1.5), dice.uniform(-math.pi, math.pi)]
                data("vehicle_attitude", us, us - 500, *quaternion(*angles))
            if i % 20 == 0:
                late = 110000 if i == 500 else 110000 + dice.randrange(30000)
                utc = (GPS_EPOCH_UNIX + WEEK * 604800 + BOOT_TOW - LEAP) * 1000000 + us - late
                data("vehicle_gps_position", us, dice.uniform(-90, 90), dice.uniform(-180, 180), 100.0, dice.uniform(1, 999),
                     utc, dice.uniform(0.1, 9), dice.uniform(0.1, 9), *(dice.uniform(-20, 20) for _ in range(3)),
                     dice.choice([3, 4, 5, 6]), dice.randrange(30))


def quaternion(roll, pitch, yaw):
    """Z-Y-X, body to navigation frame."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (roll, pitch, yaw))
    return (cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy)


def compare_ulog(path):
    log = ULog(str(path))
    topics = {d.name: d.data for d in log.data_list}
    rows = {kind: table(kind, path) for kind in ("imu", "mag", "baro", "nav", "pvt")}
    for kind, name in (("imu", "sensor_combined"), ("mag", "vehicle_magnetometer"), ("baro", "vehicle_air_data"),
                       ("nav", "vehicle_attitude"), ("pvt", "vehicle_gps_position")):
        assert len(rows[kind]) == len(topics[name]["timestamp"]) > 0, kind
    for n, row in enumerate(rows["imu"]):
        d = topics["sensor_combined"]
        near(row["tow_s"], BOOT_TOW + d["timestamp"][n] * 1e-6, 2e-6)
        for i, axis in enumerate("xyz"):
            near(row[f"gyro_{axis}_radps"], d[f"gyro_rad[{i}]"][n], 1e-8)
            near(row[f"accel_{axis}_mps2"], d[f"accelerometer_m_s2[{i}]"][n], 1e-8)
    for n, row in enumerate(rows["mag"]):
        for i, axis in enumerate("xyz"):
            near(row[f"mag_{axis}_ut"], 100 * topics["vehicle_magnetometer"][f"magnetometer_ga[{i}]"][n], 1e-3)
    for n, row in enumerate(rows["baro"]):
        near(row["baro_height_m"], topics["vehicle_air_data"]["baro_alt_meter"][n], 1e-4)
    for n, row in enumerate(rows["nav"]):
        q = quaternion(*(math.radians(row[name]) for name in ("roll_deg", "pitch_deg", "heading_deg")))
        dot = sum(q[i] * topics["vehicle_attitude"][f"q[{i}]"][n] for i in range(4))
        near(abs(dot), 1, 1e-6)
    for n, row in enumerate(rows["pvt"]):
        d = {name: values[n] for name, values in topics["vehicle_gps_position"].items()}
        near(row["gps_week"] * 604800 + row["tow_s"], int(d["time_utc_usec"]) * 1e-6 - GPS_EPOCH_UNIX + LEAP, 1e-12)
        near(row["lat_deg"], d["latitude_deg"], 1e-9), near(row["lon_deg"], d["longitude_deg"], 1e-9)
        near(row["height_m"], d["altitude_ellipsoid_m"], 1e-4)
        for name in "ned":
            near(row[f"v{name}_mps"], d[f"vel_{name}_m_s"], 1e-4)
        near(math.hypot(row["sd_n_m"], row["sd_e_m"]), d["eph"], 1e-3), near(row["sd_d_m"], d["epv"], 1e-3)
        assert row["mode"] == {3: 1, 4: 2, 5: 5, 6: 4}[d["fix_type"]] and row["n_sats"] == d["satellites_used"]
    print(f"{path}: as pyulog, {sum(map(len, rows.values()))} records")


def main():
    for seed in range(3):
        dice = random.Random(seed)
        make_dataflash("log.bin", dice)
        compare_dataflash(pathlib.Path("log.bin"))
        make_ulog("log.ulg", dice)
        compare_ulog(pathlib.Path("log.ulg"))
    return 0


sys.exit(main())
