#!/usr/bin/env python3
"""Single-point positions beside those of rnx2rtkp (Debian's rtklib) from the same files, on real and simulated data.

Both have the same systems, the same mask, broadcast ionosphere and Saastamoinen. Errors are against each set's truth; a
row says horizontal and vertical 95 %, and the share of epochs whose error is inside the standard deviation that the
solution states, by axis (a set of minutes has one draw of each slow error: its share says little by itself). No error of
broadcast mode may be larger than rnx2rtkp's (half a centimetre and 2 % granted), most must be smaller, and no epoch may
be missing that rnx2rtkp has. The other modes are shown beside.
"""

import gzip
import math
import os
import pathlib
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True  # leave nothing in the source tree
import numpy

TOOL = pathlib.Path(os.environ["BIN"]) / "virtualite-ls"
DATA = pathlib.Path(os.environ["FURROW_DATA"])
SKIPPED = 77
MASK_DEG = 10
NAVSYS = {"G": 1, "S": 2, "R": 4, "E": 8, "J": 16, "C": 32}


# ---- geometry ----


def ecef(lat_deg, lon_deg, height):
    a, e2 = 6378137.0, 0.0066943799901413165
    lat, lon = numpy.radians(lat_deg), numpy.radians(lon_deg)
    n = a / numpy.sqrt(1 - e2 * numpy.sin(lat) ** 2)
    return numpy.stack([(n + height) * numpy.cos(lat) * numpy.cos(lon), (n + height) * numpy.cos(lat) * numpy.sin(lon),
                        (n * (1 - e2) + height) * numpy.sin(lat)], axis=-1)  # fmt: skip


def latlon(xyz):
    """Good enough for directions."""
    x, y, z = xyz
    return math.atan2(z, math.hypot(x, y) * (1 - 0.0066943799901413165)), math.atan2(y, x)


def ned(origin, vectors):
    lat, lon = latlon(origin)
    sl, cl, so, co = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    return vectors @ numpy.array([[-sl * co, -sl * so, cl], [-so, co, 0], [-cl * co, -cl * so, -sl]]).T


# ---- the two solvers ----


def furrow(files, systems, *options):
    """time of week, ECEF, standard deviations N E D, satellites"""
    command = [TOOL, "-q", "--systems", systems, "--elevation-mask", str(MASK_DEG), *options, *map(str, files)]
    out = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if out.returncode not in (0, 1):
        sys.exit(f"{' '.join(map(str, command))}: exit status {out.returncode}")
    rows = [line.split(",") for line in out.stdout.splitlines()[1:]]
    table = numpy.array([[float(r[i]) for i in (1, 2, 3, 4, 5, 6, 7, 9)] for r in rows])
    return table[:, 0], ecef(table[:, 1], table[:, 2], table[:, 3]), table[:, 4:7], table[:, 7]


def rtklib(files, systems, scratch):
    conf = scratch / "single.conf"
    conf.write_text(
        f"pos1-posmode=single\npos1-frequency=l1\npos1-elmask={MASK_DEG}\npos1-ionoopt=brdc\npos1-tropopt=saas\n"
        f"pos1-sateph=brdc\npos1-navsys={sum(NAVSYS[s] for s in systems)}\n"
        "out-solformat=xyz\nout-timesys=gpst\nout-timeform=tow\nout-timendec=6\nout-outhead=off\n"
    )
    out = subprocess.run(["rnx2rtkp", "-k", conf, *map(str, files)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    rows = [line.split() for line in out.stdout.splitlines() if line[:1] != "%"]
    table = numpy.array([[float(x) for x in r[1:10]] for r in rows])
    return table[:, 0], table[:, 1:4], table[:, 6:9], table[:, 5]


# ---- the sets ----


def fixed(position):
    return lambda tow: numpy.tile(position, (len(tow), 1))


def between(times, positions):
    """Truth along a table of times; outside of it and in its gaps there is none."""

    def at(tow):
        out = numpy.stack([numpy.interp(tow, times, positions[:, i]) for i in range(3)], axis=-1)
        place = numpy.clip(numpy.searchsorted(times, tow), 1, len(times) - 1)
        near = numpy.minimum(abs(times[place] - tow), abs(tow - times[place - 1]))
        out[near > 0.13] = numpy.nan
        return out

    return at


def mosaic(scratch):
    folder = DATA / "rtk/mosaic_static"
    lat, lon, height = map(float, (folder / "rover_position.txt").read_text().split())
    return [folder / "rover.obs", folder / "base.nav"], "GREJC", fixed(ecef(lat, lon, height))


def mosaic_base(scratch):
    folder = DATA / "rtk/mosaic_static"
    lat, lon, height = map(float, (folder / "base_position.txt").read_text().split())
    return [folder / "base.obs", folder / "base.nav"], "GREJC", fixed(ecef(lat, lon, height))


def spirent(scratch):
    folder = DATA / "rtk/spirent_dynamic"
    table = numpy.genfromtxt(folder / "truth_pva.csv", delimiter=",", skip_header=1)
    return [folder / "rover.obs", folder / "gps.nav", folder / "gal.nav"], "GE", between(table[:, 3], table[:, 4:7])


def tlse(scratch):
    import hatanaka  # PyPI: rnx2rtkp cannot read Compact RINEX

    folder = DATA / "rinex/tlse_1hz"
    observations = scratch / "tlse.obs"
    observations.write_bytes(hatanaka.decompress(next(folder.glob("*MO.crx.gz"))))
    navigation = scratch / "tlse.nav"
    navigation.write_bytes(gzip.decompress(next(folder.glob("BRDC*")).read_bytes()))
    marker = numpy.array([4627852.5264, 119640.5140, 4372994.8358])  # of the header
    lat, lon = latlon(marker)
    up = numpy.array([math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)])
    return [observations, navigation], "GREJC", fixed(marker + 1.0530 * up)


def walk(scratch):
    """The table has heights above sea level; the receiver's NAV-PVT in the UBX log has both, 21.387 m apart."""
    folder = DATA / "ins/walk_0827"
    rows = [line.split() for line in (folder / "gnss_1730_sf.pos").read_text().splitlines() if line[:1] != "%"]
    rows = [r for r in rows if r[5].startswith("1")]  # fixed ambiguities only
    seconds = numpy.array([[float(x) for x in r[1].split(":")] for r in rows]) @ [3600, 60, 1]
    tow = 4 * 86400 + seconds  # 2025-08-28 is a Thursday
    llh = numpy.array([[float(x) for x in r[2:5]] for r in rows])
    files = [folder / "converted/gnss_1730.obs", folder / "converted/gnss_1730.nav"]
    return files, "GREJC", between(tow, ecef(llh[:, 0], llh[:, 1], llh[:, 2] - 21.387))


def log_0000(scratch):
    """The truth is no better than its solution with EGNOS: the receiver's own, averaged."""
    log = DATA / "sbf/log_0000.sbf"
    out = subprocess.run([TOOL.parent / "sbf2csv", "-q", "-t", "pvt", log], stdout=subprocess.PIPE, text=True, check=True)
    head, *rows = [line.split(",") for line in out.stdout.splitlines()]
    llh = [[float(r[head.index(c)]) for c in ("lat_deg", "lon_deg", "height_m")] for r in rows]
    files = [scratch / "log.obs", scratch / "log.nav"]
    subprocess.run(["convbin", "-r", "sbf", "-o", files[0], "-n", files[1], log], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)  # fmt: skip
    return files, "GREJC", fixed(ecef(*numpy.mean(llh, axis=0)))


SETS = [mosaic, mosaic_base, spirent, tlse, walk, log_0000]


# ---- the comparison ----


def judge(truth, tow, xyz, sd):
    """horizontal and vertical 95 %, share inside one sigma N E D, epochs with truth"""
    there = truth(tow)
    good = ~numpy.isnan(there[:, 0])
    e = ned(there[good][0], xyz[good] - there[good])
    inside = numpy.mean(abs(e) <= sd[good], axis=0) if sd is not None else [math.nan] * 3
    h95, v95 = numpy.percentile(numpy.hypot(e[:, 0], e[:, 1]), 95), numpy.percentile(abs(e[:, 2]), 95)
    return h95, v95, inside, good.sum(), e.mean(axis=0), e.std(axis=0)


def row(name, who, epochs, verdict, satellites):
    h95, v95, inside, *_, mean, std = verdict
    print(f"{name:14s} {who:10s} {epochs:6d} {numpy.mean(satellites):5.1f} {h95:8.3f} {v95:8.3f}  "
          f"{inside[0]:5.0%}{inside[1]:5.0%}{inside[2]:5.0%}   mean {mean.round(3)} sd {std.round(3)}")  # fmt: skip


def compare(name, files, systems, truth, scratch):
    """Prints the set's rows. Returns complaints, and how many of the two errors are smaller than rnx2rtkp's."""
    log = [DATA / "sbf/log_0000.sbf"] if name == "log_0000" else files
    theirs = rtklib(files, systems, scratch)
    peer = judge(truth, *theirs[:2], None)
    row(name, "rnx2rtkp", len(theirs[0]), peer, theirs[3])
    results = {}
    for mode in ("broadcast", "weighted", "free"):
        ours = furrow(log, systems, "--ionosphere", mode)
        results[mode] = judge(truth, *ours[:3])
        row("", mode, len(ours[0]), results[mode], ours[3])
        missing = {round(t, 1) for t in theirs[0]} - {round(t, 1) for t in ours[0]}
        if missing and mode == "broadcast":
            return [f"{name}: {len(missing)} epochs missing that rnx2rtkp has, {min(missing)} first"], 0
    mine = results["broadcast"]
    complaints = [
        f"{name}: {what} 95 % is {a:.3f} m, rnx2rtkp's {b:.3f} m"
        for what, a, b in zip(("horizontal", "vertical"), mine, peer[:2])
        if not a <= 1.02 * b + 0.005
    ]
    return complaints, sum(a < b for a, b in zip(mine[:2], peer[:2]))


def main():
    if not DATA.is_dir() or shutil.which("rnx2rtkp") is None:
        print("skipped: no real data, or no rnx2rtkp")
        return SKIPPED
    scratch = pathlib.Path("single_point")
    scratch.mkdir(exist_ok=True)
    complaints, smaller = [], 0
    print(f"{'set':14s} {'solver':10s} {'epochs':>6s} {'sats':>5s} {'H95 m':>8s} {'V95 m':>8s}  inside 1 sigma N E D")
    for make in SETS:
        more, n = compare(make.__name__, *make(scratch), scratch)
        complaints += more
        smaller += n
    print(f"{smaller} of {2 * len(SETS)} errors are smaller than rnx2rtkp's")
    if smaller <= len(SETS):
        complaints.append("most of them are not")
    print("\n".join(complaints))
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
