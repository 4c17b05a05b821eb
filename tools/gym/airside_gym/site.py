"""What a site says of target, hours and setpoint. Defaults are the program's own, as `airside init` writes them."""

import math
import os
import tempfile
import tomllib

from .failure import refused
from .points import read_points
from .program import run

BEYOND_SIGNALS = {"clock_s", "clock_advance_s", "heartbeat", "device_heartbeat", "map_fingerprint"}
SECONDS_OF_DAY = 86400
ROW_S = 360


def _seconds(text):
    hours, minutes = text.split(":")
    return int(hours) * 3600 + int(minutes) * 60


def _toml(path):
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except (OSError, tomllib.TOMLDecodeError) as cause:
        raise refused(path, f"no site file ({cause})", "a site file such as `airside init` or `airside adopt` writes",
                      "correct its name or its text") from cause


class Site:
    """A site file with its point map.

    path: site.toml or its folder; None for the built-in site of `topology`, kept in a folder of its own.
    """

    def __init__(self, program, path, topology):
        self._folder = tempfile.TemporaryDirectory(prefix="airside-gym-")
        try:
            self._read(self._tables(program, path, topology))
        except BaseException:
            self.close()
            raise

    def _tables(self, program, path, topology):
        """The site file's tables over those of the built-in site."""
        own = {}
        if path is not None:
            path = os.path.join(path, "site.toml") if os.path.isdir(path) else os.fspath(path)
            own = _toml(path)
            topology = own.get("site", {}).get("topology", topology)
        run(program, "init", self._folder.name, "--topology", topology, "--force")
        built_in = os.path.join(self._folder.name, "site.toml")
        self.path = built_in if path is None else path
        self.has_twin = "twin" in own
        if path is not None and "points" not in own.get("modbus", {}):
            raise refused(path, "no point map under [modbus]", 'points = "points.csv"', "name the site's point map")
        return {name: {**table, **own.get(name, {})} for name, table in _toml(built_in).items()}

    def _read(self, tables):
        target, setpoint = tables["target"], tables["setpoint"]
        self.target_degc = float(target["room_temp_degc"])
        self.work_s = _seconds(target["work_start"]), _seconds(target["work_end"])
        self.weekday_only = bool(target["weekday_only"])
        self.rows_of_a_cycle = int(tables["controller"]["cycle_min"]) * 60 // ROW_S
        self.setpoint_degc = float(setpoint["min_degc"]), float(setpoint["max_degc"])
        points = read_points(os.path.join(os.path.dirname(self.path), tables["modbus"]["points"]))
        self.points = {point.name: point for point in points}
        for needed in ("setpoint", "clock_s", "clock_advance_s"):
            if needed not in self.points:
                raise refused(self.path, f"no point {needed}", "the points of a simulated plant",
                              "take the point map of `airside init` or `airside adopt`")
        self.signals = [p for p in points if p.name not in BEYOND_SIGNALS]

    def rooms(self):
        """Names of room temperature points, a list a room: a room may have several sensors."""
        rooms = {}
        for name in self.points:
            if name.startswith("room_temp_"):
                rooms.setdefault(int("".join(filter(str.isdigit, name))), []).append(name)
        return [rooms[number] for number in sorted(rooms)]

    def is_scored(self, time):
        """Whether time is within working hours: the end is not, as in `airside simulate`."""
        if self.weekday_only and time.weekday() >= 5:
            return False
        second = (time.hour * 60 + time.minute) * 60 + time.second
        return self.work_s[0] <= second < self.work_s[1]

    def close(self):
        self._folder.cleanup()


def limits_of(point):
    """Least and most of a signal in its unit, never infinite: those of the map."""
    return (point.least if math.isfinite(point.least) else -1e6, point.most if math.isfinite(point.most) else 1e6)
