"""The point map of a site: which register holds which signal, and how its bits become a number (docs/formats.md)."""

import csv
import math
import struct

from . import modbus
from .failure import refused

FORMATS = {"int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f"}


class Point:
    """One row of a point map."""

    def __init__(self, row):
        self.name, self.unit = row["name"], row["unit"]
        self.function, self.address = int(row["fc"]), int(row["addr"])
        self.format = FORMATS.get(row["type"])  # None: a coil or discrete input
        self.width = 2 if row["type"] in ("int32", "uint32", "float32") else 1
        self.scale, self.offset = float(row["scale"] or 1), float(row["offset"] or 0)
        self.least, self.most = float(row["min"] or -math.inf), float(row["max"] or math.inf)
        self.write_function = int(row["fc_write"] or 0)
        self._bytes_swapped = row["byte_order"] == "little"
        self._words_swapped = row["word_order"] == "little"
        self._sentinels = [self._sentinel(text) for text in row["sentinel"].split()]

    def _sentinel(self, text):
        if not text.lower().startswith("0x"):
            return self._words(float(text) if self.format == "f" else int(text))
        bits = int(text, 16)
        return self._ordered((bits >> 16, bits & 0xFFFF) if self.width == 2 else (bits,))

    def _ordered(self, words):
        """Register contents of words in big order, and the other way round."""
        if self._words_swapped:
            words = words[::-1]
        if self._bytes_swapped:
            words = [word >> 8 | (word & 0xFF) << 8 for word in words]
        return tuple(words)

    def _words(self, raw):
        if self.format is None:
            return (int(raw),)
        return self._ordered(struct.unpack(f">{self.width}H", struct.pack(">" + self.format, raw)))

    def value(self, words):
        """Physical value of register contents; NaN for a sentinel and for a value outside the limits of the map."""
        if words in self._sentinels:
            return math.nan
        if self.format is None:
            raw = words[0]
        else:
            raw = struct.unpack(">" + self.format, struct.pack(f">{self.width}H", *self._ordered(words)))[0]
        value = raw * self.scale + self.offset
        return value if self.least <= value <= self.most else math.nan

    def write_of(self, value):
        """Request that writes value, rounded to what the register holds."""
        raw = (value - self.offset) / self.scale
        return modbus.write_request(self.write_function, self.address,
                                    self._words(raw if self.format == "f" else round(raw)))


class Block:
    """Neighbouring points that one request reads."""

    def __init__(self, points):
        self.points = points
        self.first = points[0].address
        self.count = points[-1].address + points[-1].width - self.first
        self.request = modbus.read_request(points[0].function, self.first, self.count)

    def values(self, words):
        """{name: physical value} of an answer."""
        return {p.name: p.value(words[p.address - self.first:][:p.width]) for p in self.points}


def read_points(path):
    """[Point] of a points.csv, in its order."""
    columns = ("name", "unit", "fc", "addr", "type", "byte_order", "word_order", "scale", "offset", "min", "max",
               "sentinel", "fc_write")
    try:
        with open(path, encoding="utf-8", newline="") as file:
            rows = csv.DictReader((line for line in file if line.strip() and not line.startswith("#")), restval="")
            return [Point({c: (row.get(c) or "").strip() for c in columns}) for row in rows]
    except (OSError, ValueError) as cause:
        raise refused(path, f"no point map ({cause})", "a point map", "`airside check` says what is wrong") from cause


def blocks_of(points):
    """[Block] of the fewest reads: without gaps, since a server refuses addresses that no point has."""
    blocks, run = [], []
    for point in sorted(points, key=lambda p: (p.function, p.address)):
        most = modbus.MOST_OF_ONE_READ[point.function]
        if run and (point.function != run[-1].function or point.address != run[-1].address + run[-1].width
                    or point.address + point.width - run[0].address > most):
            blocks.append(Block(run))
            run = []
        run.append(point)
    return blocks + [Block(run)]
