"""Logs as numpy arrays."""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _airside, _arguments
from ._errors import InputError

_UNITS = {"degc": "degC", "kw": "kW", "k": "K", "m3s": "m3/s"}
_PLACED = re.compile(r"(room_temp|fcu_temp|power)_(\d+)_")


def unit_of(column: str) -> str:
    """The unit that a column's name ends with: degC, kW, K or m3/s; "" of a status, a share or a text."""
    return _UNITS.get(column.removesuffix("_stand_in").rsplit("_", 1)[-1], "")


@dataclass(frozen=True, eq=False)
class Log(Mapping[str, npt.NDArray[Any]]):
    """Rows every 6 min, by column: log["room_temp_1_degc"]."""

    topology: str
    time: npt.NDArray[np.datetime64]
    """Local standard time of each row, without daylight saving."""
    names: list[str]
    """Columns of numbers, in the order of `numbers`."""
    numbers: npt.NDArray[np.float64]
    """Shape: rows x names. NaN where nothing was logged."""
    texts: dict[str, npt.NDArray[np.str_]]
    """Columns of texts: mode, reason and fault of the controller, and further ones of the file."""
    missing_rows: int = 0
    """In all gaps between rows."""

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column of numbers; "" where it has none."""
        return {name: unit_of(name) for name in self.names}

    @property
    def rooms(self) -> npt.NDArray[np.float64]:
        """Room temperatures, degC. Shape: rows x rooms."""
        return self.numbers[:, [i for i, name in enumerate(self.names) if name.startswith("room_temp_")]]

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        if name in self.names:
            return self.numbers[:, self.names.index(name)]
        if name in self.texts:
            return self.texts[name]
        raise KeyError(self._complaint(name))

    def _complaint(self, name: object) -> str:
        if name == "time":
            return "time is no column; take log.time"
        near = difflib.get_close_matches(str(name), list(self), 3)
        return f"{name}: found no such column; " + (f"did you mean {' or '.join(near)}?" if near else "list(log) has all")

    def __iter__(self) -> Iterator[str]:
        return iter([*self.names, *self.texts])

    def __len__(self) -> int:
        return len(self.names) + len(self.texts)

    def __repr__(self) -> str:
        return f"Log({self.topology}, {len(self.time)} rows, {len(self.names)} columns of numbers)"


def made(found: dict[str, Any]) -> Log:
    """Of what the extension gives."""
    return Log(found["topology"], found["time"].astype("datetime64[s]"), list(found["names"]), found["values"],
               {name: np.array(texts, dtype=np.str_) for name, texts in found["texts"].items()},
               found.get("missing_rows", 0))


def _topology_of(path: str) -> str:
    """Counts of boxes, fan coils and meters by the header of a log, or of the first of a folder."""
    place = Path(path)
    if place.is_dir():
        place = next(iter(sorted(place.glob("*.csv"))), place)
    try:
        with place.open(encoding="utf-8", errors="replace") as file:
            header = file.readline(100_000)
    except OSError as error:
        raise InputError(path, error.strerror or str(error), "a log: a CSV file or a folder of daily ones",
                         "check the path") from error
    most = {"room_temp": 0, "fcu_temp": 0, "power": 0}
    for kind, number in _PLACED.findall(header):
        most[kind] = max(most[kind], int(number))
    if not most["room_temp"]:
        raise InputError(f"{place}:1", "no column room_temp_1_degc", "the header of a log",
                         "give a log of airside or one in its format (docs/formats.md)")
    return f"{most['room_temp']}vav-{most['fcu_temp']}fcu-{most['power']}power"


def read_log(path: str | os.PathLike[str], *, site: str | os.PathLike[str] | None = None, topology: str | None = None,
             keep_missing: bool = False) -> Log:
    """Reads a log file, or all CSV files of a folder in order of name as one log.

    `site`: the site file or its folder, for columns beyond the topology's and stand-ins; `topology`: counts such as
    "5vav-5fcu-2power" instead (default: by the header). Raises InputError, naming file, line and column, for rows that
    cannot be used; with `keep_missing` empty values and values beyond a sensor's range are NaN instead.
    """
    name = _arguments.path("path", path)
    counts = _arguments.text_or_none("topology", topology, "5vav-5fcu-2power") or (
        "" if site is not None else _topology_of(name))
    return made(_airside.read_log(name, _arguments.site(site), counts, _arguments.flag("keep_missing", keep_missing)))
