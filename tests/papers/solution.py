"""Solutions and truth as arrays: tables of type nav or pos, read by column name, and the differences between two."""

import csv
import math

import numpy

DEGREES = ("roll_deg", "pitch_deg", "heading_deg")
SIGMAS = ("sd_n_m", "sd_e_m", "sd_d_m", "sd_roll_deg", "sd_pitch_deg", "sd_heading_deg")


def read_table(path, wanted):
    """Columns NAME -> array; what is empty is NaN, what is not there is left out."""
    with open(path, newline="") as f:
        rows = csv.reader(f)
        head = next(rows)
        at = {name: head.index(name) for name in wanted if name in head}
        lines = list(rows)
    return {name: numpy.array([float(r[i]) if r[i] else math.nan for r in lines]) for name, i in at.items()}


def read_solution(path):
    """With `t`, seconds of GPS time since an arbitrary week."""
    s = read_table(path, ("gps_week", "tow_s", "lat_deg", "lon_deg", "height_m", "vn_mps", "ve_mps", "vd_mps")
                   + DEGREES + SIGMAS)
    s["t"] = s["gps_week"] * 604800 + s["tow_s"]
    return s


def radii(lat_rad, height_m):
    """Metres per radian of latitude and of longitude, WGS84."""
    a, e2 = 6378137.0, 6.69437999014e-3
    w = 1 - e2 * numpy.sin(lat_rad) ** 2
    return a * (1 - e2) / w ** 1.5 + height_m, (a / numpy.sqrt(w) + height_m) * numpy.cos(lat_rad)


def same_times(a, b, tolerance_s=1e-4):
    """Indices into a and b of the moments that both have."""
    i = numpy.searchsorted(b, a - tolerance_s)
    i[i == len(b)] = 0
    match = numpy.abs(b[i] - a) <= tolerance_s
    return numpy.nonzero(match)[0], i[match]


def errors(solution, truth):
    """Solution minus truth at their common times: t, ned (n x 3) [m], rpy (n x 3) [deg], and the solution's sigmas of both.
    Attitudes are NaN where either has none."""
    i, k = same_times(solution["t"], truth["t"])
    s = {name: v[i] for name, v in solution.items()}
    r = {name: v[k] for name, v in truth.items()}
    north, east = radii(numpy.radians(r["lat_deg"]), r["height_m"])
    ned = numpy.stack([numpy.radians(s["lat_deg"] - r["lat_deg"]) * north,
                       numpy.radians((s["lon_deg"] - r["lon_deg"] + 180) % 360 - 180) * east,
                       r["height_m"] - s["height_m"]], axis=1)
    nothing = numpy.full(len(i), math.nan)

    def column(which, name):
        return which.get(name, nothing)

    rpy = numpy.stack([(column(s, n) - column(r, n) + 180) % 360 - 180 for n in DEGREES], axis=1)
    return {"t": r["t"], "ned": ned, "rpy": rpy, "sd": numpy.stack([column(s, n) for n in SIGMAS[:3]], axis=1),
            "sd_rpy": numpy.stack([column(s, n) for n in SIGMAS[3:]], axis=1)}


def rms(x):
    return float(numpy.sqrt(numpy.nanmean(numpy.square(x))))


def windows(t, first, every, length):
    """Index arrays of the moments inside each window of withheld fixes, their ends included."""
    found = []
    begin = first
    while begin + length <= t[-1]:
        found.append(numpy.nonzero((t > begin + 1e-6) & (t <= begin + length + 1e-3))[0])
        begin += every
    return found
