#!/usr/bin/env python3
"""sbf2csv's LCM log, read by PyPI's lcm, holds what its stream holds: every record, every value."""
import csv
import os
import pathlib
import subprocess
import sys

import numpy

sys.dont_write_bytecode = True  # leave nothing in the source tree
import read_lcm

SBF2CSV = pathlib.Path(os.environ["BIN"]) / "sbf2csv"
DATA = pathlib.Path(os.environ["FURROW_DATA"]) / "sbf"
SKIPPED = 77


def stream(path):
    """(type's name, {column: text}) for each row of a stream."""
    columns = {}
    with open(path, newline="", encoding="utf-8") as lines:
        for line in lines:
            if not line.startswith("#"):
                fields = next(csv.reader([line]))  # no line breaks inside fields in these logs
                yield fields[0], dict(zip(columns[fields[0]], fields[1:], strict=True))
            elif "," in line and " " not in line.split(",")[0]:
                name, *columns[name] = line[1:].rstrip("\n").split(",")


def same(text, value):
    """Whether a field of CSV and a value from LCM are the same to the last bit."""
    if value is None or isinstance(value, str):
        return text == (value or "")
    return text != "" and type(value)(text) == value


def compare(log):
    subprocess.run([SBF2CSV, "-q", "-s", "-o", "log.stream", log], check=True)
    subprocess.run([SBF2CSV, "-q", "-f", "lcm", "-o", "log.lcm", log], check=True)
    events = [record for record in read_lcm.records("log.lcm") if record[0] != "meta"]
    rows = list(stream("log.stream"))
    assert len(rows) == len(events) > 0, (len(rows), len(events))
    for n, ((row_type, row), (event_type, event)) in enumerate(zip(rows, events)):
        assert row_type == event_type, (n, row_type, event_type)
        for column, value in event.items():
            assert same(row[column], value), (n, row_type, column, row[column], value)
    print(f"{log.name}: {len(rows)} records are the same")


def main():
    logs = sorted(DATA.glob("*_0000.sbf"))
    if not logs:
        print(f"skipped: no logs in {DATA}")
        return SKIPPED
    assert same("0.1", numpy.float32(0.1)) and not same("0.1", 0.1000001)
    for log in logs:
        compare(log)
    return 0


if __name__ == "__main__":
    sys.exit(main())
