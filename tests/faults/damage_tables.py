"""Tables as furrow writes them, as lists of rows to be damaged: one cell, one time stamp, one row at a time."""
import decimal
import math

WEEK_S = 604800


class Table:
    def __init__(self, text):
        self.header, *self.rows = text.splitlines()
        self.columns = self.header.split(",")

    def copy(self):
        other = Table(self.header)
        other.rows = list(self.rows)
        return other

    def text(self):
        return "\n".join([self.header] + self.rows) + "\n"

    def get(self, row, column):
        return self.rows[row].split(",")[self.columns.index(column)]

    def put(self, row, column, value):
        """A cell becomes a text, or what a function makes of its number."""
        fields = self.rows[row].split(",")
        at = self.columns.index(column)
        fields[at] = f"{value(float(fields[at])):.9f}" if callable(value) else value
        self.rows[row] = ",".join(fields)

    def fill(self, first, n, columns, value):
        """The same in n rows."""
        for row in range(max(first, 0), min(first + n, len(self.rows))):
            for column in columns:
                self.put(row, column, value)

    def time(self, row):
        return int(self.get(row, "gps_week")) * WEEK_S + float(self.get(row, "tow_s"))

    def set_time(self, row, other, seconds):
        """The time of another row and some seconds, which are a text and exact."""
        week, tow = int(self.get(other, "gps_week")), decimal.Decimal(self.get(other, "tow_s"))
        tow += decimal.Decimal(seconds)
        weeks = math.floor(tow / WEEK_S)
        self.put(row, "gps_week", str(week + weeks))
        self.put(row, "tow_s", str(tow - weeks * WEEK_S))

    def cut_out(self, since, until):
        """Takes out the rows between two times, in seconds since the first row."""
        week, tow = self.columns.index("gps_week"), self.columns.index("tow_s")
        start, kept = self.time(0), []
        for row in self.rows:
            fields = row.split(",")
            t = int(fields[week]) * WEEK_S + float(fields[tow]) - start
            if not since < t < until:
                kept.append(row)
        self.rows = kept


# ---- SBF ----

def crc16(data):
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1
        crc &= 0xFFFF
    return crc


def sbf_blocks(data):
    """Offset, number and length of each block."""
    at = 0
    while at + 8 <= len(data):
        number, length = int.from_bytes(data[at + 4:at + 6], "little") & 0x1FFF, int.from_bytes(data[at + 6:at + 8], "little")
        yield at, number, length
        at += length


def sbf_put(data, at, offset, value):
    """Writes bytes into a block of a bytearray and repairs its CRC."""
    length = int.from_bytes(data[at + 6:at + 8], "little")
    data[at + offset:at + offset + len(value)] = value
    data[at + 2:at + 4] = crc16(data[at + 4:at + length]).to_bytes(2, "little")
