"""The rows of points.csv and the registers that their places give them: the rule of hal/points/bacnet_row.hpp.

airsided checks the whole map (limits, units, topology); here is what the gateway needs of it, and the fingerprint by
which the two find out whether they have read the same map (hal/points/point_map.cpp)."""

import csv
import math
import struct
from dataclasses import dataclass

from airside_bacnet.input_error import InputError, cell_text
from airside_bacnet.objects import HELD_BY_GATEWAY, WRITTEN, ObjectName, parse_object

COLUMNS = ("name", "unit", "fc", "addr", "type", "byte_order", "word_order", "scale", "offset", "min", "max",
           "max_rate", "stale_s", "sentinel", "write_policy", "fc_write", "default", "readback", "protocol", "object")
DECIDED = ("fc", "addr", "type", "byte_order", "word_order", "sentinel", "fc_write")
POLICIES = {"": 2, "on-change": 1, "refresh": 2}
FLOAT32, UINT32 = 6, 5  # of hal::PointType
MOST_POINTS = 2000
UNWATCHED = ("nothing in the AHU notices a power loss of this machine: the last command then stays for ever; have the "
             "AHU's program watch a commandable object, and name that one heartbeat (docs/bacnet.md, Priorities and "
             "hand-back)")


@dataclass(frozen=True)
class Point:
    name: str
    unit: str
    object: ObjectName | None  # None: the gateway's own
    address: int  # of two registers
    written: bool
    readback: str
    line: int
    fingerprint_line: str

    @property
    def function(self):
        return 3 if self.written else 4


@dataclass(frozen=True)
class PointMap:
    file: str
    points: tuple

    def find(self, name):
        return next((p for p in self.points if p.name == name), None)

    @property
    def fingerprint(self):
        value = 0xCBF29CE484222325
        for point in sorted(self.points, key=lambda p: p.name):
            for byte in point.fingerprint_line.encode():
                value = (value ^ byte) * 0x100000001B3 % 2**64
        return value

    def shown_fingerprint(self, default):
        """What the register map_fingerprint holds: the row's default, or the low half of the hash."""
        return int(default) if math.isfinite(default) else self.fingerprint & 0xFFFFFFFF


def float_registers(value):
    """Two registers, the high one first; what float32 cannot hold is no value."""
    try:
        return struct.unpack(">HH", struct.pack(">f", value))
    except OverflowError:
        return struct.unpack(">HH", struct.pack(">f", math.nan))


def registers_float(registers):
    return struct.unpack(">f", struct.pack(">HH", *registers))[0]


class _Row:
    def __init__(self, file, line, cells):
        self.file, self.line, self.cells = file, line, cells

    def __getitem__(self, column):
        return self.cells.get(column, "")

    def complain(self, column, found, expected, remedy):
        raise InputError(f"{self.file}:{self.line}, column {column}", found, expected, remedy)

    def number(self, column, otherwise):
        text = self[column]
        if not text:
            return otherwise
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self.complain(column, cell_text(text), "a finite decimal number with a point",
                          "write it as in 0.01, without a unit or thousands separator")
        return value


def _g17(value):
    return f"{value:.17g}"


def _point(row, index):
    name, protocol = row["name"], row["protocol"]
    if protocol not in ("", "modbus", "bacnet"):
        row.complain("protocol", cell_text(protocol), "one of modbus, bacnet", "use one of these words, in lower case")
    if protocol != "bacnet":
        row.complain("protocol", cell_text(protocol), "bacnet in every row, since this program serves nothing else",
                     "let airsided reach a Modbus device by itself; a map holds rows of one protocol")
    for column in DECIDED:
        if row[column]:
            row.complain(column, cell_text(row[column]),
                         "an empty cell, since the place of a row of BACnet decides its registers",
                         "clear the cell, or leave the column out")
    if name in ("clock_s", "clock_advance_s"):
        row.complain("name", cell_text(name) + " of BACnet", "no clock, which only simulated plants on Modbus have",
                     'remove the row, and set source = "system" in [clock] of the site file')
    parsed = parse_object(name, row["object"], lambda *texts: row.complain("object", *texts))
    written = name in WRITTEN
    policy = row["write_policy"]
    if not written and policy:
        row.complain("write_policy", cell_text(policy), "an empty cell, since only setpoint and heartbeat are written",
                     "clear the cell")
    if policy not in POLICIES:
        row.complain("write_policy", cell_text(policy), "one of on-change, refresh",
                     "use one of these words, in lower case")
    readback = row["readback"] or ("self" if written else "none")
    numbers = [row.number(column, otherwise) for column, otherwise in
               (("scale", 1.0), ("offset", 0.0), ("min", 0.0), ("max", 1.0), ("max_rate", math.inf),
                ("stale_s", math.inf), ("default", math.nan))]
    kind = UINT32 if name == "map_fingerprint" else FLOAT32
    line = "|".join([name, row["unit"], "3" if written else "4", str(2 * index), str(kind), "0", "0",
                     *map(_g17, numbers[:6]), "", str(POLICIES[policy] if written else 0), "16" if written else "0",
                     _g17(numbers[6]), readback]) + "\n"
    object_text = parsed.text if parsed else HELD_BY_GATEWAY
    return Point(name, row["unit"], parsed, 2 * index, written, readback, row.line,
                 line + f"bacnet|{object_text}\n"), numbers[6]


def _rows(text, file):
    header = None
    for number, content in enumerate(text.removeprefix("\ufeff").split("\n"), 1):
        content = content.rstrip("\r ")
        if not content or content.startswith("#"):
            continue
        try:
            cells = [cell.strip() for cell in next(csv.reader([content], strict=True, skipinitialspace=True))]
        except csv.Error as error:
            raise InputError(f"{file}:{number}", f"a row that is not CSV ({error})", "cells separated by commas",
                             "close the quote, and double a quote that belongs to the text") from None
        if header is None:
            header = _header(cells, file, number)
            continue
        if len(cells) != len(header):
            raise InputError(f"{file}:{number}", f"{len(cells)} cells", f"{len(header)} as in the header",
                             "add the missing commas, quote cells that hold one")
        yield _Row(file, number, dict(zip(header, cells)))
    if header is None:
        raise InputError(file, "no header row", "a header row and at least one point",
                         "start from what `airside-bacnet --discover` lists")


def _header(cells, file, line):
    place = f"{file}:{line}, header"
    for i, cell in enumerate(cells):
        if cell not in COLUMNS:
            raise InputError(place, f'column "{cell[:60]}"', f"only {', '.join(COLUMNS)}",
                             "correct or remove the column")
        if cell in cells[:i]:
            raise InputError(place, f'column "{cell}" twice', "each column once", "remove one")
    for needed in ("name", "protocol", "object"):
        if needed not in cells:
            raise InputError(place, f'no column "{needed}"', "name, protocol and object at least",
                             "add the column; airside-bacnet serves rows that name a BACnet object")
    return cells


def parse_point_map(text, file):
    """Returns the map and the number that its map_fingerprint shows. Raises InputError."""
    points, default = [], math.nan
    for row in _rows(text, file):
        if len(points) == MOST_POINTS:
            raise InputError(f"{file}:{row.line}", f"more than {MOST_POINTS} points", "a map of one AHU",
                             "leave out what the controller does not use")
        point, its_default = _point(row, len(points))
        for other in points:
            if other.name == point.name:
                row.complain("name", f'"{point.name}" again, first on line {other.line}', "each name once",
                             "rename or remove one of the two rows")
            if point.object and other.object == point.object:
                row.complain("object", f'"{point.object.text}" again, first on line {other.line}', "each object once",
                             "correct one of the two rows")
        if point.name == "map_fingerprint":
            default = its_default
        points.append(point)
    found = PointMap(file, tuple(points))
    for name, why in (("setpoint", "the object that is commanded"),
                      ("heartbeat", "object gateway, or an object that the AHU watches"),
                      ("map_fingerprint", "object gateway")):
        if found.find(name) is None:
            raise InputError(file, f'no point "{name}"', f"a row for it: {why}", "add it (docs/bacnet.md)")
    return found, found.shown_fingerprint(default)


def load_point_map(path):
    try:
        with open(path, encoding="utf-8", newline="") as file:
            return parse_point_map(file.read(), path)
    except OSError as error:
        raise InputError(path, f"no readable file ({error.strerror})", "a point map in CSV", "check the path") from None
    except UnicodeDecodeError:
        raise InputError(path, "bytes that are no UTF-8", "plain text", "save the file as UTF-8 CSV") from None


def unwatched(point_map):
    """What is wrong with the heartbeat of a map; empty where the AHU that is commanded has it."""
    heartbeat, setpoint = point_map.find("heartbeat").object, point_map.find("setpoint").object
    if heartbeat is None:
        return f'found heartbeat of "gateway"; {UNWATCHED}'
    if heartbeat.device != setpoint.device:
        return (f"found heartbeat of device {heartbeat.device} and setpoint of device {setpoint.device}; expected both "
                f"of one AHU: otherwise {UNWATCHED}")
    return ""
