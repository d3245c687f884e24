#!/usr/bin/env python3
"""Prints furrow's LCM log as CSV, by way of PyPI's lcm alone: its EventLog finds the events, and classes that
lcm-gen -p makes of formats/records/*.lcm decode them.

    read_lcm.py LOG          rows of all types, in order: type,value,...
    read_lcm.py LOG TYPE     a table of one type

Numbers are printed with all their digits, so compare them as numbers. Needs lcm-gen (LCM_GEN, or
/usr/bin/lcm-gen) and the source tree (SRC).
"""
import csv
import importlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import lcm
import numpy

SRC = pathlib.Path(os.environ.get("SRC", pathlib.Path(__file__).resolve().parents[2]))
LCM_GEN = os.environ.get("LCM_GEN", "/usr/bin/lcm-gen")
DEFINITIONS = sorted((SRC / "formats/records").glob("*.lcm"))


def load_types():
    """{"FURROW_OBS": class obs, ...}"""
    with tempfile.TemporaryDirectory() as made:
        subprocess.run([LCM_GEN, "-p", "--ppath", made, *map(str, DEFINITIONS)], check=True)
        sys.path.insert(0, made)
        return {
            "FURROW_" + d.stem.upper(): getattr(importlib.import_module("furrow." + d.stem), d.stem)
            for d in DEFINITIONS
        }


def load_floats():
    """{"obs": names of its single-precision columns, ...}, which Python's classes do not tell"""
    return {d.stem: set(re.findall(r"^\tfloat (\w+);", d.read_text(), re.MULTILINE)) for d in DEFINITIONS}


def records(path):
    """Yields (type's name, {column: value or None}) for each event, in the order of the log."""
    types, floats = load_types(), load_floats()
    for event in lcm.EventLog(path, "r"):
        cls = types[event.channel]
        record = cls.decode(event.data)
        row = {}
        for i, name in enumerate(cls.__slots__[1:]):  # the first one is the mask
            value = getattr(record, name) if record.present >> i & 1 else None
            row[name] = numpy.float32(value) if value is not None and name in floats[cls.__name__] else value
        yield cls.__name__, row


def text(value):
    return "" if value is None else str(value)


def main():
    out = csv.writer(sys.stdout, lineterminator="\n")
    wanted = sys.argv[2] if len(sys.argv) > 2 else None
    header = False
    for name, row in records(sys.argv[1]):
        if wanted is None:
            out.writerow([name, *map(text, row.values())])
        elif name == wanted:
            if not header:
                out.writerow(row)
            header = True
            out.writerow(map(text, row.values()))


if __name__ == "__main__":
    main()
