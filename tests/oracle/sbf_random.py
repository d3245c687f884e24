"""Random blocks from tables of fields.

A table says in lines of text where a block has its fields:

    record NAME, block ID [lengths of the revisions]
    OFFSET TYPE COLUMN [CONVERSION] [OPTION...]
    sub COUNT SIZE FIRST LENGTH           what follows is offsets in sub-blocks, one row of the record for each

COUNT and SIZE are the offsets of the number of sub-blocks and of their size (-: not stated), FIRST is that of the first
one. A conversion is a factor, a range of bits (bit6, bits0-3), "sat" with the systems allowed (sat:GE) or a function of
CONVERT. Options: rN: exists from revision N on; dnu=V: the value that says "not available", otherwise that of the type;
any: all values are values; max=V: the largest that occurs.
"""

import math
import struct

import numpy
import sbf_log

WEEK = 2400
GNSS_PI = 3.1415926535898  # the value that the interface documents prescribe
FORMATS = {"u1": "B", "u2": "H", "u4": "I", "i1": "b", "i2": "h", "i4": "i", "f4": "f", "f8": "d"}
MARKS = {
    "u1": 255,
    "u2": 65535,
    "u4": 2**32 - 1,
    "i1": -128,
    "i2": -32768,
    "i4": -(2**31),
    "f4": -2e10,
    "f8": -2e10,
}
CONVERT = {
    "deg": math.degrees,
    "rad": math.radians,
    "pi": lambda raw: raw * GNSS_PI,
    "sqrt": math.sqrt,
    "text": lambda raw: raw.rstrip(b"\0").decode(),
    "glo": lambda raw: raw - 8,
    "celsius": lambda raw: raw - 100,
}

# (first SVID, last, system, what to take off to get the number)
SVID_RANGES = [
    (1, 37, "G", 0),
    (38, 61, "R", 37),
    (63, 68, "R", 38),
    (71, 106, "E", 70),
    (120, 140, "S", 0),
    (141, 180, "C", 140),
    (181, 190, "J", 180),
    (191, 197, "I", 190),
    (198, 215, "S", 57),
    (216, 222, "I", 208),
    (223, 245, "C", 182),
]


def satellite(svid):
    for first, last, system, less in SVID_RANGES:
        if first <= svid <= last:
            return f"{system}{svid - less:02d}"
    return None


def svids(systems):
    """All SVIDs of the systems, "GE" for example; of all systems when empty."""
    return [n for first, last, s, _ in SVID_RANGES if s in (systems or s) for n in range(first, last + 1)]


def bits(raw, text):
    """ "0-3" or "6": these bits of raw."""
    first, _, last = text.partition("-")
    return raw >> int(first) & (1 << int(last or first) - int(first) + 1) - 1


class Field:
    """One line of a table. marked: integers have marks for "not available"."""

    def __init__(self, words, marked):
        named = dict(word.split("=") for word in words[3:] if "=" in word)
        self.offset, self.type, self.column = int(words[0]), words[1], words[2]
        self.convert = words[3] if len(words) > 3 and "=" not in words[3] else ""
        self.revision = next((int(w[1:]) for w in words[3:] if w[0] == "r" and w[1:].isdigit()), 0)
        self.mark = int(named["dnu"]) if "dnu" in named else MARKS.get(self.type)
        self.any = "any" in words or self.convert.startswith("bit") or self.type[0] == "c"
        self.any = self.any or not marked and self.type[0] != "f" and "dnu" not in named
        self.most = int(named.get("max", 0)) or (
            None if marked else {"u2": 8191, "u4": 604799}.get(self.type)
        )
        self.size = int(self.type[1:])

    def value(self, raw):
        """What the column should hold; None: nothing."""
        if not self.any and raw == self.mark:
            return None
        if self.convert.startswith("bit"):
            return bits(raw, self.convert.lstrip("bits"))
        if self.convert.startswith("sat"):
            return satellite(raw)
        if self.convert in CONVERT:
            return CONVERT[self.convert](raw)
        try:
            return raw * float(self.convert)
        except ValueError:
            return raw

    def draw(self, rng):
        """A random raw value."""
        if self.type[0] == "c":
            return bytes(
                rng.choice(b"ABCXYZabcxyz0189 -_.,\"'/") for _ in range(rng.randint(0, self.size))
            ).strip()
        if not self.any and rng.random() < 0.12:
            return self.mark
        if self.convert.startswith("sat"):
            return rng.choice(svids(self.convert[4:]))
        if self.convert == "glo":
            return rng.randint(1, 14)
        return self.draw_real(rng) if self.type[0] == "f" else self.draw_integer(rng)

    def draw_real(self, rng):
        x = rng.uniform(-1, 1) * 10 ** rng.uniform(-9, 6)
        if self.convert == "deg":
            x = rng.uniform(-1.5, 1.5)
        elif self.convert == "sqrt":
            x = 10 ** rng.uniform(-6, 4)
        return x if self.type == "f8" else float(numpy.float32(x))

    def draw_integer(self, rng):
        low = 0 if self.type[0] == "u" else -(2 ** (8 * self.size - 1))
        high = self.most or 2 ** (8 * self.size) + low - 1
        raw = rng.choice([rng.randint(low, high), rng.randint(max(low, -9), min(high, 30)), high - 1, 1])
        return raw if raw != MARKS[self.type] else 2  # where any value is one, leave the mark of others out

    def put(self, buffer, raw):
        packed = (
            raw.ljust(self.size, b"\0") if self.type[0] == "c" else struct.pack("<" + FORMATS[self.type], raw)
        )
        buffer[self.offset : self.offset + self.size] = packed


def draw_fields(rng, fields, buffer, revision=0):
    """Puts random values into the buffer. Returns {column: value}."""
    raws, values = {}, {}
    for field in fields:
        place = field.offset, field.type
        if field.offset + field.size > len(buffer):
            values[field.column] = None
            continue
        if place not in raws:
            choosy = [f for f in fields if (f.offset, f.type) == place and (f.any or f.convert)]
            raws[place] = (choosy + [field])[0].draw(rng)  # suits all the columns that are made of it
            field.put(buffer, raws[place])
        values[field.column] = field.value(raws[place]) if revision >= field.revision else None
    if "glonass_channel" in values:
        satellite = next(f for f in fields if f.column == "sat")
        if not 38 <= raws[satellite.offset, satellite.type] <= 68:  # the SVIDs of GLONASS
            values["glonass_channel"] = None
    return values


class Table:
    """One record type and the block that makes it."""

    def __init__(self, words):
        self.record, self.number = words[0].rstrip(","), int(words[2])
        self.lengths = [int(length) for length in words[3:]]
        self.fields, self.sub, self.inner = [], None, []

    def random(self, rng, tow_ms):
        """A block and the rows that it should become."""
        revision = rng.choice([*range(len(self.lengths) or 1), len(self.lengths) or 1])
        end = max([14] + [f.offset + f.size for f in self.fields])
        if self.lengths:
            end = self.lengths[min(revision, len(self.lengths) - 1)]
        body = bytearray(rng.randbytes(end))
        outer = draw_fields(rng, self.fields, body, revision)
        rows = [outer]
        if self.sub:
            rows = self.random_sub_blocks(rng, body, outer, revision)
        elif revision >= max(1, len(self.lengths)):
            body += rng.randbytes(rng.choice([0, 4, 12]))  # what a later revision appends
        return sbf_log.build(self.number, revision, tow_ms, WEEK, bytes(body[14:])), rows

    def random_sub_blocks(self, rng, body, outer, revision):
        count, size, first, step = self.sub
        n = rng.randint(0, 6)
        body[len(body) :] = bytes(max(0, first - len(body)))
        del body[first:]
        body[count] = n
        if size is not None:
            step += rng.choice([0, 0, 0, 4, 8])
            body[size] = step
        rows = []
        for _ in range(n):
            piece = bytearray(rng.randbytes(step))
            rows.append(outer | draw_fields(rng, self.inner, piece, revision))
            body += piece
        if n == 0 and self.record == "status":
            return [outer | {f.column: None for f in self.inner}]  # has a row also without front ends
        return rows


def load_tables(text, marked=True):
    tables = []
    for line in text.strip().splitlines():
        words = line.split()
        if words and words[0] == "record":
            tables.append(Table(words[1:]))
        elif words and words[0] == "sub":
            tables[-1].sub = tuple(int(word) if word != "-" else None for word in words[1:])
        elif words:
            (tables[-1].inner if tables[-1].sub else tables[-1].fields).append(Field(words, marked))
    return tables


def load_fields(text, marked=True):
    return [Field(line.split(), marked) for line in text.splitlines() if line]
