"""Measures and prints for bench_sbf2csv.sh: sbf2csv_peers.py LONG_LOG SHORT_LOG

All programs take turns, round after round, each writing to /dev/null; the median of its rounds counts. MB are those of
the input. convbin does what `sbf2csv -t obs` does: ranges, phases, Dopplers and C/N0 (-od -os) of a log to text. Where its
output goes makes no difference to it. pysbf2 parses every block of the short log, without any output.

At the limit: the time that reading, the blocks' CRCs and the numbers as text would take at the rates measured here, over
the time it took. The numbers are counted in the output of the short log, by the form in which they are written.
"""
import json
import os
import re
import statistics
import subprocess
import sys
import time
from collections import Counter

ROUNDS = 4
PYSBF2_ROUNDS = 2
TARGETS = {"-t obs": 15, "-s": 8, "-t pvt": 60}  # times convbin
MODES = ["-t obs", "-s", "-t pvt", "-f lcm", "--list"]
AT_LIMIT = ["-t obs", "-s", "-t pvt", "--list"]  # an LCM log holds no text to count

sbf2csv = os.path.join(os.environ["BIN"], "sbf2csv")
bench = os.environ["BENCH"]
python = os.environ.get("PYTHON", "")
long_log, short_log = sys.argv[1:3]

PARSE_ALL = """
import sys
from pysbf2 import SBFReader
for raw, parsed in SBFReader(open(sys.argv[1], "rb"), quitonerror=0):
    pass
"""


def seconds(command):
    start = time.monotonic()
    null = subprocess.DEVNULL
    subprocess.run(command, stdin=null, stdout=null, stderr=null, check=True)
    return time.monotonic() - start


def output(*command):
    null = subprocess.DEVNULL
    return subprocess.run(command, stdin=null, stdout=subprocess.PIPE, stderr=null, text=True, check=True).stdout


def has_pysbf2():
    command = [python, "-c", "import pysbf2"]
    return os.access(python, os.X_OK) and subprocess.run(command, stderr=subprocess.DEVNULL).returncode == 0


def measure():
    """Median time of each program, by its name in the table."""
    # convbin deletes output files that it finds empty: it must not get hold of /dev/null itself.
    if not os.path.islink("convbin.obs"):
        os.symlink(os.devnull, "convbin.obs")
    commands = {"convbin": ["convbin", "-r", "sbf", "-v", "3.04", "-od", "-os", "-o", "convbin.obs", long_log]}
    commands |= {"sbf2csv " + mode: [sbf2csv, "-q", *mode.split(), long_log] for mode in MODES}
    times = {name: [] for name in commands}
    for _ in range(ROUNDS):
        for name, command in commands.items():
            times[name].append(seconds(command))
    if has_pysbf2():
        times["pysbf2"] = [seconds([python, "-c", PARSE_ALL, short_log]) for _ in range(PYSBF2_ROUNDS)]
    return {name: statistics.median(t) for name, t in times.items()}


def limits():
    """Rates of reading, CRC and block walk [MB/s]; cost of a number of each form [ns]."""
    lines = output(f"{bench}/limits", long_log).splitlines()
    rates = {name: float(rate) for name, rate in map(str.split, lines)}
    cost = {}
    for line in output(f"{bench}/bench_number").split("\n\n")[0].splitlines()[1:]:
        what, ns = re.match(r"(.*?):.* ([\d.]+) +[\d.]+ +[\d.]+$", line).groups()
        cost[what] = min(float(ns), cost.get(what, 1e9))
    return rates, cost


def form(field):
    """What kind of number a field of the output is, in the words of bench_number; None: text, or nothing."""
    if not re.fullmatch(r"-?\d+(\.\d+)?(e-?\d+)?", field):
        return None
    if re.fullmatch(r"-?\d+", field):
        return "whole"
    decimals = len(field.partition(".")[2])
    if decimals in (3, 4, 9):
        return f"fixed, {decimals}"
    return "shortest float" if decimals < 9 else "shortest double"


def count_numbers(mode):
    """Rows that the short log becomes, and its numbers by form."""
    text = output(sbf2csv, "-q", *mode.split(), short_log)
    rows = [line for line in text.splitlines()[1:] if not line.startswith("#")]
    forms = Counter(form(field) for row in rows for field in row.split(","))
    del forms[None]
    return len(rows), forms


def share(mode, took_s, size, rates, cost):
    """Rows and numbers written, and the share of the time at the limit."""
    ns = size * (1e3 / rates["read"] + 1e3 / rates["crc"])
    rows, forms = (0, Counter()) if mode == "--list" else count_numbers(mode)
    scale = size / os.path.getsize(short_log)
    ns += scale * sum(n * cost[what] for what, n in forms.items())
    return {"rows": round(rows * scale), "numbers": round(forms.total() * scale), "at_limit": ns / 1e9 / took_s}


def machine():
    model = re.search(r"model name\s*: (.*)", open("/proc/cpuinfo").read())
    return f"{model.group(1) if model else os.uname().machine}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"


def main():
    size = os.path.getsize(long_log)
    seconds(["cat", long_log])  # into the page cache
    times = measure()
    rates, cost = limits()
    short_size = os.path.getsize(short_log)
    speed = {name: (short_size if name == "pysbf2" else size) / 1e6 / t for name, t in times.items()}
    result = {"machine": machine(), "input_bytes": size, "limits_mbps": rates, "number_ns": cost, "programs": {}}

    print(f"machine: {result['machine']}; {size / 1e6:.0f} MB, median of {ROUNDS} rounds")
    print("limits: " + ", ".join(f"{name} {rate:.0f} MB/s" for name, rate in rates.items()))
    print("        " + ", ".join(f"{what} {ns:.0f} ns" for what, ns in cost.items()))
    print(f"{'':16} {'MB/s':>7} {'x convbin':>10} {'target':>7} {'x pysbf2':>9} "
          f"{'rows':>10} {'numbers':>11} {'at limit':>9}")
    missed = []
    for name, mbps in sorted(speed.items(), key=lambda item: item[1]):
        mode = name.removeprefix("sbf2csv ")
        entry = {"mbps": mbps, "per_convbin": mbps / speed["convbin"]}
        target = TARGETS.get(mode)
        line = f"{name:16} {mbps:7.{0 if mbps > 10 else 2}f} {entry['per_convbin']:10.{1 if mbps > 1 else 3}f} "
        line += f"{f'>= {target}' if target else '':>7} "
        line += f"{mbps / speed['pysbf2']:9.0f}" if "pysbf2" in speed else f"{'':9}"
        if mode in AT_LIMIT:
            entry |= share(mode, times[name], size, rates, cost)
            line += f" {entry['rows'] or '':>10} {entry['numbers'] or '':>11} {100 * entry['at_limit']:7.0f} %"
        if target and not entry["per_convbin"] >= target:
            missed.append(f"{name}: {entry['per_convbin']:.1f} times convbin, the target is {target}")
        result["programs"][name] = entry
        print(line)
    if "pysbf2" not in speed:
        print("pysbf2 is not here (scripts/venv.sh): left out")
    with open("sbf2csv.json", "w", encoding="utf-8") as file:
        json.dump(result, file, indent=1)
    for line in missed:
        print("MISSED " + line)
    return 1 if missed else 0


sys.exit(main())
