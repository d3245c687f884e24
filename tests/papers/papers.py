#!/usr/bin/env python3
"""The tests of the papers, flown again: what the papers report beside what furrow does.

    papers.py --bin DIR --campaign FILE -o DIR [--flights N] [--first SEED] [--only PART[,PART]] [--quick]

PART: sections, heading, consistency, outages. Writes REPORT.md, REPORT.html and pictures (SVG, gnuplot). --quick: a few
flights of each, to see that all of it works; figures that need many are shown, not judged. Exit 0: every figure that was
judged is reached, as far as chance allows; 1: not.
"""

import argparse
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy

import report
import solution

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parent.parent
SCENARIOS = SOURCE / "testdata" / "scenarios"
SETTINGS = SOURCE / "testdata" / "papers"

# Mean errors of the paper, metres, without and with protection levels; sections 1 to 6, north, east, vertical.
PAPER_WITHOUT = numpy.array([[2.584, 1.898, 2.777], [1.462, 1.715, 5.495], [2.423, 3.626, 7.457],
                             [4.032, 4.238, 8.510], [1.996, 1.965, 2.445], [1.670, 2.599, 2.775]])
PAPER_WITH = numpy.array([[1.972, 1.494, 1.977], [1.077, 1.383, 3.588], [1.855, 2.771, 4.798],
                          [3.658, 3.916, 4.156], [1.106, 1.484, 1.844], [1.576, 2.129, 1.924]])
AXES = ("north", "east", "vertical")

MODES = ("static", "receiver", "pl", "gm", "vb", "student")
SAYS = {"static": "constant sigmas", "receiver": "the receiver's own covariance", "pl": "R and Q follow protection levels",
        "gm": "Gauss-Markov errors of the fixes", "vb": "variational Bayes", "student": "Student's t"}
NOISES = {"white": "0", "correlated": "30"}
# The adaptation that each kind of error asks for; the others are listed beside it.
ADAPTIVE = {"white": "pl", "correlated": "gm"}


class Tools:
    def __init__(self, folder, campaign):
        self.folder, self.campaign = pathlib.Path(folder), campaign

    def run(self, name, *arguments):
        done = subprocess.run([self.folder / name, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode not in (0, 1):
            sys.exit(f"papers.py: {name} {' '.join(map(str, arguments))}: exit {done.returncode}\n{done.stderr}")

    def fly(self, scenario, options, settings):
        """One line of words from campaign for each line of settings."""
        done = subprocess.run([self.campaign, SCENARIOS / scenario, *map(str, options)], input="\n".join(settings) + "\n",
                              capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"papers.py: campaign: {done.stderr}")
        return [line.split() for line in done.stdout.splitlines()]


def in_parallel(work, items):
    """Results in the order of items, one process of the tools per core at a time."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(work, items))


def pairs(words):
    """name=value words to a dictionary."""
    return dict(w.split("=") for w in words if "=" in w)


# Fewer flights than this say too little to judge a figure that is near its limit.
ENOUGH = 20


# ---- the test of the paper, by sections ----

def fly_sections(tools, noise, seed, smoothed):
    """Mean absolute errors, mode -> (forward 6 x 3, smoothed 6 x 3 or None), and a series of one axis for the picture."""
    found, series = {}, {}
    with tempfile.TemporaryDirectory() as scratch:
        flight = pathlib.Path(scratch)
        tools.run("gnss-sim", SCENARIOS / "fieldcopter.ini", "-q", "-o", flight, "--seed", seed, "--truth-rate", 10,
                  "--set", f"pvt.section_tau_s={NOISES[noise]}", "--set", "magnetometer.rate_hz=0",
                  "--set", "barometer.rate_hz=0")
        tools.run("pl-monitor", "-q", flight / "rover.sbf", "-t", "pl", "-o", flight / "pl.csv")
        truth = solution.read_solution(flight / "truth.csv")
        for mode in MODES:
            for way in ("none", "rts") if smoothed else ("none",):
                tools.run("insgnss-fuse", "-q", flight / "rover.sbf", "--imu", flight / "imu.csv", "--pl", flight / "pl.csv",
                          "--lever-x", 0, "--lever-y", 0, "--lever-z", -0.25, "-c", SETTINGS / f"{mode}-{noise}.ini",
                          "--rate", 10, "--smooth", way, "-o", flight / "nav.csv")
                e = solution.errors(solution.read_solution(flight / "nav.csv"), truth)
                t = e["t"] - truth["t"][0]
                found[mode, way] = numpy.array([numpy.abs(e["ned"][(t > 100 * s) & (t <= 100 * s + 100)]).mean(axis=0)
                                                for s in range(6)])
                series[mode, way] = (t, e["ned"], e["sd"])
    return found, series


def put_sections(r, tools, first, flights, smooth_flights):
    r.heading("EGNOS paper: sections of 100 s with different errors (Table 4)")
    r.text(f"Scenario fieldcopter.ini, flown by gnss-sim with seeds {first} to {first + flights - 1}, through pl-monitor and "
           "insgnss-fuse with the settings of testdata/papers, which tune.py has found with other seeds. Mean absolute "
           "errors in metres, mean of all flights.")
    for noise in NOISES:
        put_noise(r, tools, noise, first, flights, smooth_flights)


def put_noise(r, tools, noise, first, flights, smooth_flights):
    seeds = range(first, first + flights)
    results = in_parallel(lambda s: fly_sections(tools, noise, s, s < first + smooth_flights), seeds)
    runs = {mode: numpy.array([f[mode, "none"] for f, _ in results]) for mode in MODES}
    mean = {mode: e.mean(axis=0) for mode, e in runs.items()}
    best = ADAPTIVE[noise]
    cells = [(s, a) for s in range(6) for a in range(3)]

    r.heading(f"{noise} errors", 3)
    if noise == "white":
        r.table(["section", "axis", "paper without", "paper with", "furrow static", f"furrow {best}", ""],
                [[s + 1, AXES[a], f"{PAPER_WITHOUT[s, a]:.3f}", f"{PAPER_WITH[s, a]:.3f}", f"{mean['static'][s, a]:.3f}",
                  f"{mean[best][s, a]:.3f}", r.verdict(mean[best][s, a] < PAPER_WITH[s, a],
                                                       f"white, section {s + 1}, {AXES[a]}: below the paper")]
                 for s, a in cells])
        r.table(["axis", "paper: with / without", f"furrow: {best} / static"],
                [[AXES[a], f"{(PAPER_WITH / PAPER_WITHOUT)[:, a].mean():.2f}",
                  f"{(mean[best] / mean['static'])[:, a].mean():.3f}"] for a in range(3)])
    r.text(f"The adaptive filter ({best}: {SAYS[best]}) against the static one, both at their best. The standard error is "
           "that of the mean difference, flight by flight.")
    difference = (runs[best] - runs["static"]) / mean["static"]
    standard_error = difference.std(axis=0, ddof=1) / numpy.sqrt(flights)
    ratio = mean[best] / mean["static"]
    r.table(["section", "axis", "static", best, "ratio", "standard error", ""],
            [[s + 1, AXES[a], f"{mean['static'][s, a]:.3f}", f"{mean[best][s, a]:.3f}", f"{ratio[s, a]:.3f}",
              f"{standard_error[s, a]:.3f}",
              r.verdict(ratio[s, a] <= 1, f"{noise}, section {s + 1}, {AXES[a]}: no worse than static",
                        close=ratio[s, a] <= 1 + 2 * standard_error[s, a], judged=flights >= ENOUGH)] for s, a in cells])
    r.text("All kinds of adaptation, mean over sections (ratio to static in brackets), and how many of the 18 cells each wins:")
    wins = {m: sum(mean[m][c] == min(mean[k][c] for k in MODES) for c in cells) for m in MODES}
    r.table(["settings", "", "north", "east", "vertical", "cells won"],
            [[m, SAYS[m]] + [f"{mean[m][:, a].mean():.3f} ({(mean[m] / mean['static'])[:, a].mean():.3f})" for a in range(3)]
             + [wins[m]] for m in MODES])
    put_smoothed(r, noise, [f for f, _ in results[:smooth_flights]])
    put_pictures(r, noise, mean, results[0][1], best)


def put_smoothed(r, noise, results):
    r.text(f"Smoothed over forward, {len(results)} flights, mean over sections:")
    rows = []
    for mode in MODES:
        forward = numpy.mean([f[mode, "none"] for f in results], axis=0)
        smoothed = numpy.mean([f[mode, "rts"] for f in results], axis=0)
        share = smoothed.mean() / forward.mean()
        judged = mode == ADAPTIVE[noise]
        rows.append([mode] + [f"{smoothed[:, a].mean():.3f} ({smoothed[:, a].mean() / forward[:, a].mean():.2f})" for a in range(3)]
                    + [f"{share:.3f}", r.verdict(share <= 0.6, f"{noise}: smoothed at most 0.6 of forward",
                                                   judged=judged and len(results) >= ENOUGH)])
    r.table(["settings", "north", "east", "vertical", "all", ""], rows)


def put_pictures(r, noise, mean, series, best):
    bars = [[f"{s + 1}{AXES[a][0].upper()}", PAPER_WITH[s, a], mean["static"][s, a], mean[best][s, a]]
            for s in range(6) for a in range(3)]
    r.picture(f"sections-{noise}", "Mean absolute error by section and axis [m]", report.bars(
        bars, ["paper, with levels", "static", best]))
    curves = []
    for mode, way, name in (("static", "none", "static"), (best, "none", best), (best, "rts", f"{best}, smoothed")):
        if (mode, way) in series:
            t, ned, _ = series[mode, way]
            curves.append((name, t[::5], ned[::5, 0]))
    r.picture(f"flight-{noise}", "Error north of the first flight [m] over time [s]", report.lines(curves))


# ---- heading ----

# Fixes of a drone's receiver in place of the sections: 1 m and 5 cm/s.
OPEN_SKY = [w for key in ("section_s=1e6", "horizontal_m2=1", "vertical_m2=2", "horizontal_m2ps2=0.0025", "vertical_m2ps2=0.01")
            for w in ("--set", "pvt." + key)]


def fly_heading(tools, seed):
    with tempfile.TemporaryDirectory() as scratch:
        flight = pathlib.Path(scratch)
        tools.run("gnss-sim", SCENARIOS / "heading.ini", "-q", "-o", flight, "--seed", seed, "--truth-rate", 10)
        truth = solution.read_solution(flight / "truth.csv")
        found = {}
        for name, more in (("with compass", ["--compass", "yes", "--mag", flight / "mag.csv"]), ("without", [])):
            tools.run("insgnss-fuse", "-q", flight / "rover.sbf", "--imu", flight / "imu.csv", *more, "--antenna-heading", 0,
                      "--lever-x", 0.5, "--lever-y", 0, "--lever-z", -0.1, "--rate", 10, "-o", flight / "nav.csv")
            e = solution.errors(solution.read_solution(flight / "nav.csv"), truth)
            t = e["t"] - truth["t"][0]
            away = (t > 300) & (t <= 420)
            found[name] = solution.rms(e["rpy"][away, 2])
            found[name, "series"] = (t, e["rpy"][:, 2])
    return found


def put_heading(r, tools, first, flights):
    seeds = range(first, first + flights)
    r.heading("EGNOS paper: heading through an outage of 120 s")
    r.text(f"Scenario heading.ini, seeds {first} to {first + flights - 1}: hard and soft iron, no GNSS heading from 300 to 420 s. "
           "RMS of heading errors through the outage, degrees. The compass with and without the look-up table: campaign.c on the "
           "library, whose magnetometer has had no ground calibration; the filter: the same, and insgnss-fuse on the files of gnss-sim.")

    def campaign(seed):
        words = tools.fly("heading.ini", OPEN_SKY + ["--report", "heading", "--seeds", f"{seed}-{seed}"], ["compass=yes"])[0]
        return {k: float(v) for k, v in pairs(words).items()}

    flown = in_parallel(campaign, seeds)
    files = in_parallel(lambda s: fly_heading(tools, s), seeds)

    def over(name):
        return solution.rms([f[name] for f in flown])

    rows = [["compass alone", "3 to 4 (iron)", f"{over('outage-compass'):.3f}", max(f["outage-compass"] for f in flown), ""]]
    for name, key in (("compass with the table", "outage-corrected"), ("filter, library", "outage-filter")):
        rows.append([name, "", f"{over(key):.3f}", max(f[key] for f in flown),
                     r.verdict(over(key) <= 0.5, f"heading: {name} within 0.5 degrees")])
    for name in ("with compass", "without"):
        value = solution.rms([f[name] for f in files])
        rows.append([f"filter, insgnss-fuse, {name}", "", f"{value:.3f}", max(f[name] for f in files),
                     r.verdict(value <= 0.5, f"heading: insgnss-fuse {name} within 0.5 degrees", judged=name == "with compass")])
    r.table(["", "paper", "furrow: RMS", "worst flight", ""], [row[:3] + [f"{row[3]:.3f}"] + row[4:] for row in rows])
    better = sum(f["outage-corrected"] <= f["outage-compass"] and f["outage-filter"] <= f["outage-compass"]
                 and f["corrected"] <= f["compass"] for f in flown)
    r.table(["", "flights", ""], [["corrected compass and filter no worse than the compass alone, in the outage and all along",
                                   f"{better} of {flights}", r.verdict(better == flights, "heading: never worse than the compass alone")]])
    r.picture("heading", "Heading error of the first flight [deg] over time [s]; no GNSS heading from 300 to 420 s",
              report.lines([(name, files[0][name, "series"][0][::5], files[0][name, "series"][1][::5])
                            for name in ("without", "with compass")], limit=2))


# ---- consistency ----

# An IMU that is what the filter models: white noise and one Gauss-Markov bias.
MODELLED_IMU = [w for key in ("grade=perfect", "gyro_noise_degprth=0.15", "gyro_markov_degph=30", "gyro_markov_tau_s=1000",
                              "accel_noise_ugprthz=60", "accel_markov_mg=1", "accel_markov_tau_s=1000")
                for w in ("--set", "imu." + key)]
CORRELATED = ["--set", "pvt.section_tau_s=30"]
STATES = ("att-n", "att-e", "att-d", "vel-n", "vel-e", "vel-d", "pos-n", "pos-e", "pos-d")
GM = "adapt=gm gm-tau=30 gm-share=1 still=no"
# The paper's form as it stands: levels of a user, all tau 1.
PL = "adapt=pl still=no"
CASES = (("none, white errors", MODELLED_IMU, "adapt=none still=no", True),
         ("gm, correlated errors", MODELLED_IMU + CORRELATED, GM, True),
         ("pl, white errors", MODELLED_IMU, PL, False),
         ("pl, correlated errors", MODELLED_IMU + CORRELATED, PL, False),
         ("none, correlated errors", MODELLED_IMU + CORRELATED, "adapt=none still=no", False),
         ("none, white errors, industrial IMU", [], "adapt=none", False),
         ("gm, correlated errors, industrial IMU", CORRELATED, "adapt=gm gm-tau=30 gm-share=1", False))


def put_consistency(r, tools, first, flights):
    r.heading("Consistency")
    r.text(f"{flights} flights of fieldcopter.ini in memory (campaign.c), seeds {first} to {first + flights - 1}. NEES of attitude, "
           "velocity and position together (9 states), NIS of position and velocity (6 rows), once a second, from 20 s on: their mean "
           f"over the flights against the 95 % band of a chi-square over {flights} flights. The IMU is white noise and a Gauss-Markov "
           "bias, which is what the filter takes it for; the last two lines have the industrial grade of gnss-sim, with flicker noise, scale "
           "factors and misalignments, and zero-velocity updates.")

    def fly(options):
        settings = [c[2] for c in CASES if c[1] == options]
        seeds = ["--report", "consistency", "--seeds", f"{first}-{first + flights - 1}"]
        return dict(zip(settings, map(pairs, tools.fly("fieldcopter.ini", options + seeds, settings))))

    kinds = [k for i, k in enumerate(c[1] for c in CASES) if k not in [c[1] for c in CASES[:i]]]
    results = dict(zip(map(tuple, kinds), in_parallel(fly, kinds)))
    found = [results[tuple(c[1])][c[2]] for c in CASES]
    rows, inside = [], []
    for (name, _, _, judged), f in zip(CASES, found):
        row = [name]
        for what in ("nees", "nis"):
            value, low, high = float(f[what]), float(f[what + "-low"]), float(f[what + "-high"])
            verdict = r.verdict(low <= value <= high, f"{name}: {what.upper()} inside its band", judged=judged)
            row += [f"{value:.3f}", f"{low:.2f} to {high:.2f}", f"{100 * float(f[what + '-share']):.1f} %", verdict]
        rows.append(row)
        shares = numpy.array([[float(v) for v in f[s].split(",")] for s in STATES]) * 100
        groups = [shares[3 * k:3 * k + 3].mean(axis=0) for k in range(3)]
        good = all(abs(g[0] - 68.27) <= 5 and abs(g[1] - 95.45) <= 5 for g in groups)
        inside.append([name] + [f"{g[0]:.1f} / {g[1]:.1f}" for g in (groups[2], groups[1], groups[0])]
                      + [r.verdict(good, f"{name}: shares inside 1 and 2 sigma", judged=judged and flights >= ENOUGH)])
    r.table(["", "NEES", "band", "moments inside", "", "NIS", "band", "moments inside", ""], rows)
    r.text("Percent of errors inside 1 sigma and 2 sigma (68.3 and 95.4 expected):")
    r.table(["", "position", "velocity", "attitude", ""], inside)
    r.text("The paper's form, pl, takes R as white noise whatever the errors are. With errors that stay for 30 s its covariance becomes "
           "many times too small: its line above says how many, and none shares the fault. gm carries the errors as states and is "
           "consistent. With white errors pl is off by what HPL/HUL makes of R.")


# ---- outages ----

CAR_LEVER = ["--lever-x", 0.6, "--lever-y", -0.3, "--lever-z", -1.5]
OUTAGE = {"every": 180, "length": 60, "first": 240}
NAVIGATION = ["--imu-grade", "navigation", "--gyro-noise", 0.003, "--gyro-bias", 0, "--gyro-walk", 0.03, "--gyro-tau", 14400,
              "--accel-noise", 51, "--accel-bias", 0, "--accel-walk", 15.3, "--accel-tau", 14400]
# ADIS16465 as KF-GINS takes it: 0.1 deg/sqrt(h), 0.1 m/s/sqrt(h), 50 deg/h, 50 mGal, 1000 ppm, 1 h; turn-on bias of the data sheet.
MEMS_IMU = [w for key in ("grade=perfect", "gyro_noise_degprth=0.1", "gyro_markov_degph=50", "gyro_markov_tau_s=3600",
                          "accel_noise_ugprthz=170", "accel_markov_mg=0.051", "accel_markov_tau_s=3600", "accel_bias_mg=1.4",
                          "gyro_scale_ppm=1000", "accel_scale_ppm=1000")
            for w in ("--set", "imu." + key)]
MEMS = ["--imu-grade", "industrial", "--gyro-noise", 0.1, "--gyro-bias", 0, "--gyro-walk", 50, "--gyro-tau", 3600,
        "--accel-noise", 170, "--accel-bias", 1.4, "--accel-walk", 51, "--accel-tau", 3600, "--gyro-scale", 1000,
        "--accel-scale", 1000, "--align", "motion"]
IMUS = {"navigation": ([], NAVIGATION), "MEMS": (MEMS_IMU, MEMS)}


def fly_outages(tools, imu, seed):
    """Of each outage, forward and smoothed: largest error, largest sigma, error of heading and its sigma (RMS over it)."""
    found = {}
    simulated, told = IMUS[imu]
    with tempfile.TemporaryDirectory() as scratch:
        drive = pathlib.Path(scratch)
        tools.run("gnss-sim", SCENARIOS / "outage.ini", "-q", "-o", drive, "--seed", seed, "--truth-rate", 10, *simulated)
        truth = solution.read_solution(drive / "truth.csv")
        for way in ("none", "rts"):
            tools.run("insgnss-fuse", "-q", drive / "rover.sbf", "--imu", drive / "imu.csv", *CAR_LEVER, *told, "--rate", 10,
                      "--withhold", "{every}:{length}:{first}".format(**OUTAGE), "--smooth", way, "-o", drive / "nav.csv")
            e = solution.errors(solution.read_solution(drive / "nav.csv"), truth)
            t = e["t"] - truth["t"][0]
            size, sigma = (numpy.linalg.norm(e[k], axis=1) for k in ("ned", "sd"))
            rows = []
            for i in solution.windows(t, OUTAGE["first"], OUTAGE["every"], OUTAGE["length"]):
                rows.append([size[i].max(), sigma[i].max(), solution.rms(e["rpy"][i, 2]), solution.rms(e["sd_rpy"][i, 2])])
            found[way] = numpy.array(rows)
            found[way, "series"] = (t, size, sigma)
    return found


def put_outages(r, tools, first, drives):
    r.heading("Outages of 60 s")
    r.text(f"Scenario outage.ini, seeds {first} to {first + drives - 1}: half an hour of a car; centimetre fixes at 1 Hz, withheld "
           "for 60 s every 3 minutes (insgnss-fuse --withhold 180:60:240). RMS, over all outages, of the largest error in each, and of the "
           "filter's own largest sigma; heading likewise, RMS through the outages. The paper column: KF-GINS and "
           "Inertial Explorer on real data of that grade.")
    rows = []
    for imu in IMUS:
        results = in_parallel(lambda s: fly_outages(tools, imu, s), range(first, first + drives))
        forward, smoothed = (numpy.concatenate([f[way] for f in results]) for way in ("none", "rts"))
        f, s = ([solution.rms(x[:, k]) for k in range(4)] for x in (forward, smoothed))
        judged = imu == "navigation"
        rows += [
            [imu, "largest error, forward [m]", "0.874, 0.849" if judged else "", f"{f[0]:.3f}",
             r.verdict(f[0] <= 0.87, "outages: forward at most 0.87 m", judged=judged)],
            [imu, "its sigma [m], ratio", "", f"{f[1]:.3f}, {f[0] / f[1]:.2f}",
             r.verdict(f[0] <= 1.15 * f[1], f"outages, {imu}: forward within 1.15 of its sigma", judged=drives >= ENOUGH)],
            [imu, "largest error, smoothed [m], of forward", "", f"{s[0]:.3f}, {s[0] / f[0]:.2f}",
             r.verdict(s[0] <= f[0] / 4, f"outages, {imu}: smoothed at most a quarter", judged=judged)],
            [imu, "its sigma [m], ratio", "", f"{s[1]:.3f}, {s[0] / s[1]:.2f}",
             r.verdict(s[0] <= 1.15 * s[1], f"outages, {imu}: smoothed within 1.15 of its sigma", judged=drives >= ENOUGH)],
            [imu, "heading, forward [deg]", "", f"{f[2]:.4f} (sigma {f[3]:.4f})",
             r.verdict(f[2] <= 0.02, "outages: heading at most 0.02 degrees", judged=judged)],
            [imu, "heading, smoothed [deg]", "", f"{s[2]:.4f} (sigma {s[3]:.4f})", ""],
        ]
        t, size, sigma = results[0]["none", "series"]
        ts, size_s, _ = results[0]["rts", "series"]
        r.picture(f"outages-{imu.lower()}", f"Position error of the first drive, {imu} IMU [m] over time [s]",
                  report.lines([("forward", t[::10], size[::10]), ("its sigma", t[::10], sigma[::10]),
                                ("smoothed", ts[::10], size_s[::10])]))
    r.table(["IMU", "", "paper", f"furrow, {len(forward)} outages", ""], rows)


# ---- all ----

PARTS = ("sections", "heading", "consistency", "outages")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--bin", required=True)
    arguments.add_argument("--campaign", required=True)
    arguments.add_argument("-o", "--output", required=True)
    arguments.add_argument("--flights", type=int, default=40)
    arguments.add_argument("--first", type=int, default=1)
    arguments.add_argument("--only", default=",".join(PARTS))
    arguments.add_argument("--quick", action="store_true")
    a = arguments.parse_args()
    tools = Tools(a.bin, a.campaign)
    parts = a.only.split(",")
    few = 2 if a.quick else a.flights
    r = report.Report(a.output, "furrow and the papers")
    if "sections" in parts:
        put_sections(r, tools, a.first, few, min(few, 20))
    if "heading" in parts:
        put_heading(r, tools, a.first, min(few, 20))
    if "consistency" in parts:
        put_consistency(r, tools, a.first, 10 if a.quick else 100)
    if "outages" in parts:
        put_outages(r, tools, a.first, 1 if a.quick else min(few, 20))
    r.write()
    return 0 if r.missed == [] else 1


if __name__ == "__main__":
    sys.exit(main())
