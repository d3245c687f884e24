#!/usr/bin/env python3
"""The noise of gnss-sim's sensors and clocks is the noise that was asked for.

allantools 2024.6 computes overlapping Allan deviations of what the simulated logs hold: readings of gyros and accelerometers
of a vehicle that stands still (imu.csv), and the receiver's own estimate of its clock (rover.sbf), made under a sky without
errors so that nothing but the clock is in it. Over three decades, 1 to 1000 samples, they are within 10 % of

    sensors  sigma^2(tau) = N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3                        (IEEE Std 952, annex C)
    clocks   sigma^2(tau) = h0 / (2 tau) + 2 ln 2 h-1 + (2 pi^2 / 3) h-2 tau + (a tau)^2 / 2   (IEEE Std 1139)

each of the three noises by itself, and all together as in a grade of IMU or a model of clock.

An Allan deviation is itself an estimate. Root mean squares over the three axes (seeds for clocks) of 200,000 (150,000)
samples leave it a standard deviation of 3 to 4 % at 1000 samples, less below; seeds are fixed.
"""
import concurrent.futures
import os
import pathlib
import subprocess
import sys

sys.dont_write_bytecode = True  # leave nothing in the source tree
import allantools
import numpy
import pandas

BIN = pathlib.Path(os.environ["BIN"])
WITHIN = 0.1
AVERAGED = numpy.array([1, 2, 5, 10, 20, 50, 100, 200, 500, 1000])  # samples in tau

STILL = """
[trajectory]
waypoint = 0 0 0
[magnetometer]
rate_hz = 0
[barometer]
rate_hz = 0
[gnss]
rate_hz = 1
signals = G1C
elevation_mask_deg = 15
cn0_zenith_dbhz = 70
cn0_horizon_dbhz = 70
dll_hz = 0.0001
multipath_m = 0
[sky]
systems = GPS
radial_m = 0
along_m = 0
cross_m = 0
clock_m = 0
iono_pct = 0
tropo_m = 0
[base]
present = no
"""

DEG_H = numpy.pi / 180 / 3600
DEG_RTH = numpy.pi / 180 / 60
MICROG = 9.80665e-6
# of gyros: key, unit; of accelerometers likewise
N, B, K = 0, 1, 2
GYRO = (("gyro_noise_degprth", DEG_RTH), ("gyro_instability_degph", DEG_H), ("gyro_walk_degphprth", DEG_H / 60))
ACCEL = (("accel_noise_ugprthz", MICROG), ("accel_instability_ug", MICROG), ("accel_walk_ugprts", MICROG))

# h0, h-1, h-2 and ageing: one at a time, then those of a chip-scale clock's data sheet (3e-10 at 1 s, floor 1e-11, 9e-10 a month)
CLOCKS = {
    "white": (4e-20, 0, 0, 0),
    "flicker": (0, 2e-20, 0, 0),
    "walk": (0, 0, 1e-20, 0),
    "csac": (1.8e-19, 7.2e-23, 1e-27, 9e-10 / (30 * 86400)),
}


def simulate(folder, seconds, settings):
    settings = {"scenario.duration_s": seconds, "scenario.truth_rate_hz": 0.001, **settings}
    options = [word for key, value in settings.items() for word in ("--set", f"{key}={value!r}".replace("'", ""))]
    subprocess.run([BIN / "gnss-sim", "-q", "still.ini", "-o", folder, *options], check=True)


def deviation(frequency, interval_s):
    """Root mean square over the rows of `frequency`."""
    each = []
    for row in frequency:
        tau, sigma, _, _ = allantools.oadev(row, rate=1 / interval_s, data_type="freq", taus=AVERAGED * interval_s)
        assert numpy.allclose(tau, AVERAGED * interval_s), tau
        each.append(sigma)
    return numpy.sqrt(numpy.mean(numpy.square(each), axis=0))


def compare(what, got, variance):
    ratio = got / numpy.sqrt(variance)
    worst = numpy.argmax(numpy.abs(ratio - 1))
    print(f"{what:28s} at most {100 * abs(ratio[worst] - 1):4.1f} % off, at {AVERAGED[worst]} samples")
    assert abs(ratio[worst] - 1) <= WITHIN, (what, ratio)


def sensor(settings, keys, tau):
    n, b, k = (settings.get(f"imu.{key}", 0) * unit for key, unit in keys)
    return n**2 / tau + 2 * numpy.log(2) / numpy.pi * b**2 + k**2 * tau / 3


def check_imu(what, settings, as_keys, rate_hz=100):
    """`as_keys` is what the settings come to, for those that are a grade."""
    simulate("imu", 200000 / rate_hz, {"imu.rate_hz": rate_hz, "gnss.rate_hz": 0.01, **settings})
    rows = pandas.read_csv("imu/imu.csv").to_numpy()
    assert len(rows) == 200000, len(rows)
    tau = AVERAGED / rate_hz
    for name, first, keys in (("gyros", 2, GYRO), ("accelerometers", 5, ACCEL)):
        compare(f"{name}, {what}", deviation(rows[:, first : first + 3].T, 1 / rate_hz), sensor(as_keys, keys, tau))


def check_sensors():
    for gyro, accel, what in ((N, B, "white/flicker"), (B, K, "flicker/walk"), (K, N, "walk/white")):
        values = {f"imu.{GYRO[gyro][0]}": (0.3, 20, 60)[gyro], f"imu.{ACCEL[accel][0]}": (150, 400, 90)[accel]}
        check_imu(what, {"imu.grade": "perfect", **values}, values)
    # what gnss-sim(1) calls industrial: data sheets' numbers; 0.5 Hz, so that the flicker comes out of the white noise
    grade = {"imu.gyro_noise_degprth": 0.15, "imu.gyro_instability_degph": 3}
    grade |= {"imu.accel_noise_ugprthz": 60, "imu.accel_instability_ug": 30}
    check_imu("industrial", {"imu.grade": "industrial"}, grade, rate_hz=0.5)


def clock_frequency(settings, seed):
    """Offsets of a receiver's clock, the milliseconds by which it was set back undone, to frequency."""
    folder = f"clock-{seed}"
    simulate(folder, 150000, {"imu.rate_hz": 0, "scenario.seed": seed, **settings})
    subprocess.run([BIN / "sbf2csv", "-q", "-t", "pvt", f"{folder}/rover.sbf", "-o", f"{folder}/pvt.csv"], check=True)
    offset = pandas.read_csv(f"{folder}/pvt.csv", usecols=["clock_bias_s"]).to_numpy()[:, 0]
    assert len(offset) == 150001 and numpy.isfinite(offset).all(), len(offset)
    return numpy.diff(numpy.unwrap(offset, period=1e-3))


def check_clocks():
    tau = AVERAGED
    for name, (h0, hm1, hm2, ageing) in CLOCKS.items():
        settings = {"clock.model": name}
        if name != "csac":
            settings = {"clock.model": "perfect", "clock.h0_s": h0, "clock.hm1": hm1, "clock.hm2_ps": hm2}
        with concurrent.futures.ThreadPoolExecutor() as pool:
            got = deviation(list(pool.map(lambda seed: clock_frequency(settings, seed), (3, 4))), 1)
        variance = h0 / (2 * tau) + 2 * numpy.log(2) * hm1 + 2 * numpy.pi**2 / 3 * hm2 * tau + (ageing * tau) ** 2 / 2
        compare(f"clock, {name}", got, variance)


pathlib.Path("still.ini").write_text(STILL)
check_sensors()
check_clocks()
