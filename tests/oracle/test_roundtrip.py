#!/usr/bin/env python3
"""Records come back whole from each of the three forms, and other people's programs read them.

  stream -> stream, stream -> LCM log -> stream, SBF -> LCM log -> stream: the same bytes but for #pg and #cfg
                          and the losses that #end counts
  tables: GDAL's ogrinfo, pandas without options and awk see the same rows and columns, numbers as numbers, gaps as gaps
  10,000 of 10,000 events come through pipes; lcm-logplayer plays each of them, PyPI's lcm receives what is published live

The logs are all real ones, testdata/demo.sbf, and one of random blocks of every type that sbf_tables.py has.
"""

import csv
import os
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys
import threading

sys.dont_write_bytecode = True  # leave nothing in the source tree
import lcm
import pandas
import read_lcm
import sbf_log
import sbf_tables
from sbf_random import load_tables

SBF2CSV = pathlib.Path(os.environ["BIN"]) / "sbf2csv"
SRC = pathlib.Path(os.environ["SRC"])
DATA = pathlib.Path(os.environ["FURROW_DATA"]) / "sbf"
EVENTS = 10000
LOGPLAYER = "/usr/bin/lcm-logplayer"


def run(*arguments, stdin=None):
    """sbf2csv's output as bytes. It may have lost something (1), or found nothing (4), but must not fail otherwise."""
    done = subprocess.run([SBF2CSV, "-q", *arguments], input=stdin, capture_output=True, check=False)
    assert done.returncode in (0, 1, 4), (arguments, done.returncode, done.stderr)
    return done.stdout


def lines(stream):
    """The lines of a stream but for the provenance, which grows with each tool."""
    kept = [line for line in stream.splitlines() if not line.startswith((b"#pg", b"#cfg"))]
    kept[-1] = kept[-1].split(b" skipped=")[0]
    return kept


def random_log():
    rng = random.Random(3)
    tables = (
        load_tables(sbf_tables.TABLES)
        + load_tables(sbf_tables.NAVIGATION, False)
        + load_tables(sbf_tables.JOINED)
    )
    blocks = [t.random(rng, 1000 * n)[0] for n in range(40) for t in tables]
    blocks += [
        sbf_log.build(5936, 0, 41000, 2400, struct.pack("<H", len(text)) + text)
        for text in (
            b"plain",
            b'"quoted", with commas',
            b"two\nlines",
            "äöü – µ".encode(),
            b"#end",
            b"",
            b" spaces ",
        )
    ]
    return b"".join(blocks)


def check_forms(name, log):
    stream = run("-s", stdin=log)
    lines_of = lines(stream)
    again = {
        "stream to stream": run("-s", stdin=stream),
        "stream to LCM to stream": run("-s", stdin=run("-f", "lcm", stdin=stream)),
        "SBF to LCM to stream": run("-s", stdin=run("-f", "lcm", stdin=log)),
    }
    for way, other in again.items():
        for a, b in zip(lines_of, lines(other)):
            assert a == b, (name, way, a, b)
        assert len(lines_of) == len(lines(other)), (name, way, len(lines_of), len(lines(other)))
    return len(lines_of)


def column_types(record):
    """{column: its type in the definition}"""
    found = re.findall(r"^\t(\w+) (\w+);", (SRC / f"formats/records/{record}.lcm").read_text(), re.M)
    return {name: kind for kind, name in found if name != "present"}


def check_with_pandas(path, rows, columns):
    table = pandas.read_csv(path)
    assert list(table.columns) == columns, (path, list(table.columns))
    assert len(table) == len(rows), (path, len(table), len(rows))
    for column, kind in column_types(path.stem).items():
        empty = sum(row[column] == "" for row in rows)
        assert table[column].isna().sum() == empty, (path, column, table[column].isna().sum(), empty)
        assert kind == "string" or pandas.api.types.is_numeric_dtype(table[column]), (
            path,
            column,
            table[column].dtype,
        )


def check_with_ogrinfo(path, rows, columns):
    if shutil.which("ogrinfo") is None:
        return
    shown = subprocess.run(["ogrinfo", "-al", "-so", path], capture_output=True, text=True, check=True).stdout
    assert f"Feature Count: {len(rows)}\n" in shown, (path, len(rows), shown)
    fields = re.findall(r"^(\w+): \w+ \(\d+\.\d+\)$", shown, re.M)
    assert fields == columns, (path, fields)


def check_with_awk(path, rows, columns):
    if any("," in value or '"' in value or "\n" in value for row in rows for value in row.values()):
        return  # only awk programs that know quotes read these
    program = f"NF != {len(columns)} {{ bad++ }} END {{ print NR - 1, bad + 0 }}"
    shown = subprocess.run(["awk", "-F,", program, path], capture_output=True, text=True, check=True).stdout
    assert shown == f"{len(rows)} 0\n", (path, shown, len(rows))


def check_tables(log):
    shutil.rmtree("tables", ignore_errors=True)
    run("--split", "tables", stdin=log)
    seen = []
    for path in sorted(pathlib.Path("tables").glob("*.csv")):
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            rows, columns = list(reader), reader.fieldnames
        assert columns == list(column_types(path.stem)) and rows, path
        assert path.read_bytes() == run("-t", path.stem, stdin=log), path
        for reads in (check_with_pandas, check_with_ogrinfo, check_with_awk):
            reads(path, rows, columns)
        seen.append(path.stem)
    return seen


def event_log():
    rng = random.Random(5924)
    return b"".join(
        sbf_log.build(
            5924, 1, 20 * n, 2400, struct.pack("<BBfdH", 1 + n % 4, 0, rng.uniform(0, 0.02), 1e-4, 1)
        )
        for n in range(EVENTS)
    )


def through_pipes():
    """cat log | sbf2csv -s | sbf2csv -f lcm | sbf2csv -t event"""
    commands = [
        ["cat", "events.sbf"],
        *([SBF2CSV, "-q", *way] for way in (["-s"], ["-f", "lcm"], ["-t", "event"])),
    ]
    last = None
    for command in commands:
        started = subprocess.Popen(command, stdin=last and last.stdout, stdout=subprocess.PIPE)
        if last:
            last.stdout.close()
        last = started
    out = last.communicate()[0]
    assert last.returncode == 0
    assert out == run("-t", "event", "events.sbf") and out.count(b"\n") == EVENTS + 1, out.count(b"\n")


def channel_and_data(path):
    return [(event.channel, event.data) for event in lcm.EventLog(path, "r")]


def played():
    """lcm-logplayer plays the log into another log, which then holds the same messages."""
    if not os.path.exists(LOGPLAYER):
        return "no lcm-logplayer"
    run("-f", "lcm", "-o", "events.lcm", "events.sbf")
    pathlib.Path("played.lcm").unlink(missing_ok=True)
    subprocess.run([LOGPLAYER, "-s", "1000000", "-l", "file://played.lcm?mode=w", "events.lcm"], check=True, timeout=60,
                   stdout=subprocess.DEVNULL)  # fmt: skip
    sent = channel_and_data("events.lcm")
    assert sum(channel == "FURROW_EVENT" for channel, _ in sent) == EVENTS
    assert channel_and_data("played.lcm") == sent
    return f"{len(sent)} messages played by lcm-logplayer"


def subscribe(url):
    """Returns an LCM handle that has heard itself, or None where multicast does not come back to this host."""
    heard = []
    try:
        handle = lcm.LCM(url)
    except RuntimeError:
        return None
    handle.subscribe("HELLO", lambda channel, data: heard.append(data))
    for _ in range(10):
        handle.publish("HELLO", b"hello")
        if handle.handle_timeout(200) and heard:
            return handle
    return None


def received():
    """What --lcm-url sends arrives at a subscriber, record by record."""
    url = f"udpm://239.255.76.67:{20000 + os.getpid() % 20000}?ttl=0&recv_buf_size=2000000"
    handle = subscribe(url)
    if handle is None:
        return "live: skipped, no multicast on this host"
    got, done = [], threading.Event()
    subscription = handle.subscribe("FURROW_EVENT", lambda channel, data: got.append(data))
    subscription.set_queue_capacity(0)  # without it liblcm drops what Python does not fetch at once

    def listen():
        while not done.is_set() or handle.handle_timeout(500):
            handle.handle_timeout(100)

    listener = threading.Thread(target=listen)
    listener.start()
    sender = subprocess.run([SBF2CSV, "-q", "-t", "event", "--lcm-url", url, "events.sbf"], check=False)
    done.set()
    listener.join()
    assert sender.returncode == 0
    decode = read_lcm.load_types()["FURROW_EVENT"].decode
    stamps = [(record.tow_s, record.source) for record in map(decode, got)]
    table = run("-t", "event", "events.sbf").decode().splitlines()
    wanted = [(float(row["tow_s"]), int(row["source"])) for row in csv.DictReader(table)]
    assert stamps == wanted, (len(stamps), len(wanted))
    return f"{len(stamps)} records received live"


def main():
    logs = {
        path.name: path.read_bytes() for path in sorted([*DATA.glob("*.sbf"), *DATA.glob("pysbf2/*.log")])
    }
    logs["demo.sbf"] = (SRC / "testdata/demo.sbf").read_bytes()
    logs["random"] = random_log()
    for name, log in logs.items():
        print(f"{name}: {check_forms(name, log)} lines come back")
    seen = set()
    for name in ("random", "demo.sbf", "log_0000.sbf"):
        if name in logs:
            seen |= set(check_tables(logs[name]))
    print(f"tables of {len(seen)} types read by ogrinfo, pandas and awk:", *sorted(seen))
    assert len(seen) > 50
    pathlib.Path("events.sbf").write_bytes(event_log())
    through_pipes()
    print(f"{EVENTS} events through pipes; {played()}; {received()}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
