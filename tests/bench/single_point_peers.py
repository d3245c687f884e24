"""See bench_single_point.sh."""

import os
import pathlib
import subprocess
import sys
import time

TARGET = 20
TOOL = pathlib.Path(os.environ["BIN"]) / "virtualite-ls"
DATA = pathlib.Path(os.environ["FURROW_DATA"])
CONF = """pos1-posmode=single
pos1-frequency=l1
pos1-elmask=10
pos1-ionoopt=brdc
pos1-tropopt=saas
pos1-sateph=brdc
pos1-navsys=61
"""
SETS = {
    "mosaic_static": ["rtk/mosaic_static/rover.obs", "rtk/mosaic_static/base.nav"],
    "spirent_dynamic": ["rtk/spirent_dynamic/rover.obs", "rtk/spirent_dynamic/gps.nav", "rtk/spirent_dynamic/gal.nav"],
    "walk_0827": ["ins/walk_0827/converted/gnss_1730.obs", "ins/walk_0827/converted/gnss_1730.nav"],
}


def best(command):
    """Seconds of the fastest of five runs, and the lines that it wrote."""
    seconds, lines = [], 0
    for _ in range(5):
        start = time.perf_counter()
        out = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        seconds.append(time.perf_counter() - start)
        lines = sum(line[:1] != b"%" and line[:3] != b"gps" for line in out.stdout.splitlines())
    return min(seconds), lines


def wc(files):
    return best(["wc", "-l", *files])[0]


def main():
    conf = pathlib.Path("single.conf")
    conf.write_text(CONF)
    worst = float("inf")
    print(f"{'set':16s} {'epochs':>6s} {'MB':>6s} {'rnx2rtkp/s':>10s} {'furrow/s':>10s} {'ratio':>6s} {'MB/s':>6s} {'wc -l MB/s':>10s}")
    for name, paths in SETS.items():
        files = [str(DATA / p) for p in paths]
        size = sum(os.path.getsize(f) for f in files) / 1e6
        slow, epochs = best(["rnx2rtkp", "-k", str(conf), *files])
        fast, solved = best([str(TOOL), "-q", "--systems", "GECRJ", "--ionosphere", "broadcast", *files])
        ratio = (solved / fast) / (epochs / slow)
        worst = min(worst, ratio)
        print(f"{name:16s} {solved:6d} {size:6.1f} {epochs / slow:10.0f} {solved / fast:10.0f} {ratio:6.1f} {size / fast:6.0f} {size / wc(files):10.0f}")
    if worst < TARGET:
        print(f"below its target: {worst:.1f} instead of {TARGET}")
        return 1
    return 0


sys.exit(main())
