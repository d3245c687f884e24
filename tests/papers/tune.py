#!/usr/bin/env python3
"""Settings of insgnss-fuse for the fieldcopter test, found by one and the same search for every kind of adaptation.

    tune.py CAMPAIGN SCENARIO MODE NOISE -o FILE [--seeds 1001-1024] [--random 60] [--simplex 300]

MODE: static (constant sigmas, no protection levels), receiver (the receiver's own covariance), pl, gm, vb or student.
NOISE: white or correlated (section_tau_s = 30).

Every setting is searched over on a logarithmic scale. First as many settings as --random says are drawn around where the
search begins; then Nelder and Mead's simplex goes on from the best of them, and once more from where it ends.
What is made small is the mean, over all sections and axes, of the mean absolute error divided by that of the paper.
The flights are those of campaign.c, at seeds that are used for nothing else. Same arguments, same file.
"""

import argparse
import math
import random
import subprocess
import sys

# Mean errors with protection levels, metres: north, east, vertical of each section (the paper's table).
PAPER = [1.972, 1.494, 1.977, 1.077, 1.383, 3.588, 1.855, 2.771, 4.798,
         3.658, 3.916, 4.156, 1.106, 1.484, 1.844, 1.576, 2.129, 1.924]

SIGMAS = {"position-sd-h": 4.0, "position-sd-v": 5.8, "velocity-sd-h": 0.85, "velocity-sd-v": 1.83}
SENSORS = {"gyro-noise": 0.15, "gyro-walk": 3.0, "accel-noise": 60.0, "accel-walk": 30.0}
LEVELS = {"hul": 24.0, "vul": 31.0, "tau1": 1.0, "tau2": 1.0, "tau3": 1.0, "tau4": 1.0}
MARKOV = {"gm-tau": 30.0, "gm-k-h": 6.0, "gm-k-v": 5.33, "1-gm-share": 0.03}

MODES = {
    "static": ("none", {**SIGMAS, **SENSORS}),
    "receiver": ("none", {**SENSORS}),
    "pl": ("pl", {**SIGMAS, **SENSORS, **LEVELS}),
    "gm": ("gm", {**SENSORS, **MARKOV}),
    "vb": ("vb", {**SIGMAS, **SENSORS, "1-vb-memory": 0.02}),
    "student": ("student", {**SIGMAS, **SENSORS, "student-dof-2": 2.0}),
}


def settings_of(mode, x):
    """The settings, KEY -> text, of a point in the logarithms."""
    adapt, begin = MODES[mode]
    out = {"adapt": adapt}
    for (name, first), value in zip(begin.items(), x):
        v = first * math.exp(value)
        if name.startswith("1-"):
            name, v = name[2:], 1 - min(max(v, 1e-6), 0.999)
        elif name.endswith("-2"):
            name, v = name[:-2], 2 + min(max(v, 0.01), 500)
        out[name] = f"{v:.6g}"
    return out


class Flights:
    """Two campaigns that share the seeds."""

    def __init__(self, campaign, scenario, noise, first, last):
        tau = "30" if noise == "correlated" else "0"
        middle = (first + last) // 2
        self.parts = [(b - a + 1, subprocess.Popen(
            [campaign, scenario, "--seeds", f"{a}-{b}", "--set", f"pvt.section_tau_s={tau}", "--set", "imu.rate_hz=50"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)) for a, b in ((first, middle), (middle + 1, last))]

    def errors(self, settings):
        line = " ".join(f"{k}={v}" for k, v in settings.items()) + "\n"
        for _, p in self.parts:
            p.stdin.write(line)
            p.stdin.flush()
        total, flights = [0.0] * len(PAPER), 0
        for n, p in self.parts:
            words = p.stdout.readline().split()
            if words[:1] != ["forward"]:
                return None
            total = [t + n * float(w) for t, w in zip(total, words[1:])]
            flights += n
        return [t / flights for t in total]


def cost_of(errors):
    if errors is None or not all(math.isfinite(e) for e in errors):
        return 1e9
    return sum(e / p for e, p in zip(errors, PAPER)) / len(PAPER)


def simplex(cost, x, size, budget):
    """Nelder and Mead (1965), with the factors of Gao and Han (2012) for many dimensions."""
    n = len(x)
    alpha, beta, gamma, delta = 1, 1 + 2 / n, 0.75 - 1 / (2 * n), 1 - 1 / n
    points = [(cost(x), x)]
    for i in range(n):
        y = list(x)
        y[i] += size
        points.append((cost(y), y))
    used = n + 1
    while used < budget:
        points.sort(key=lambda p: p[0])
        worst = points[-1]
        middle = [sum(p[1][i] for p in points[:-1]) / n for i in range(n)]

        def at(t):
            return [m + t * (m - w) for m, w in zip(middle, worst[1])]

        y = at(alpha)
        f = cost(y)
        used += 1
        if f < points[0][0]:
            z = at(alpha * beta)
            g = cost(z)
            used += 1
            points[-1] = (g, z) if g < f else (f, y)
        elif f < points[-2][0]:
            points[-1] = (f, y)
        else:
            z = at(alpha * gamma) if f < worst[0] else at(-gamma)
            g = cost(z)
            used += 1
            if g < min(f, worst[0]):
                points[-1] = (g, z)
            else:
                best = points[0][1]
                points[1:] = [(cost(s), s) for s in ([b + delta * (v - b) for b, v in zip(best, p[1])] for p in points[1:])]
                used += n
    return min(points, key=lambda p: p[0])


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("campaign")
    arguments.add_argument("scenario")
    arguments.add_argument("mode", choices=MODES)
    arguments.add_argument("noise", choices=["white", "correlated"])
    arguments.add_argument("-o", "--output", required=True)
    arguments.add_argument("--seeds", default="1001-1024")
    arguments.add_argument("--random", type=int, default=60)
    arguments.add_argument("--simplex", type=int, default=300)
    a = arguments.parse_args()
    first, last = (int(s) for s in a.seeds.split("-"))
    flights = Flights(a.campaign, a.scenario, a.noise, first, last)
    n = len(MODES[a.mode][1])
    draw = random.Random(1)

    def cost(x):
        return cost_of(flights.errors(settings_of(a.mode, x)))

    best = (cost([0.0] * n), [0.0] * n)
    begin = best[0]
    for _ in range(a.random):
        x = [draw.gauss(0, 0.7) for _ in range(n)]
        best = min(best, (cost(x), x), key=lambda p: p[0])
    drawn = best[0]
    best = simplex(cost, best[1], 0.4, a.simplex // 2)
    best = min(best, simplex(cost, best[1], 0.15, a.simplex // 2), key=lambda p: p[0])
    with open(a.output, "w") as out:
        print(f"; {a.mode}, for {a.noise} errors of the fieldcopter test. Found by tests/papers/tune.py {a.mode} {a.noise},\n"
              f"; seeds {a.seeds}, {a.random} random settings and {a.simplex} steps of the simplex. Mean error over that of the\n"
              f"; paper: {begin:.4f} at the begin, {drawn:.4f} after the random ones, {best[0]:.4f} at the end.\n[insgnss-fuse]", file=out)
        for name, value in settings_of(a.mode, best[1]).items():
            print(f"{name} = {value}", file=out)
    print(f"{a.mode} {a.noise}: {begin:.4f} {drawn:.4f} {best[0]:.4f}", file=sys.stderr)


if __name__ == "__main__":
    main()
