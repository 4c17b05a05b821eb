"""Inputs of the networks: X = [S | E | A] in the order of docs/method.md 3.1, from logs and from observations."""

import csv

import numpy as np
from airside_gym.failure import refused

CYCLE_ROWS = 3  # rows of 6 min in a control cycle
KINDS = ("room_temp_", "fcu_temp_", "vav_on_", "fcu_on_", "power_", "mau_temp", "outdoor_temp", "rain")
ENDINGS = ("", "_degc", "_kw")
LABELS = {"fcu_on_": -1.0, "rain": -1.0}  # all others +1 (docs/method.md 3.1; `paper`)
FLAGS = ("vav_on_", "fcu_on_", "rain")


def kind_of(name):
    return next((kind for kind in KINDS if name.startswith(kind)), None)


class Layout:
    """Which of a plant's signals are inputs. names: without units, in any order."""

    def __init__(self, names):
        self.names = [name for kind in KINDS for name in names if kind_of(name) == kind]
        self.kinds = [kind_of(name) for name in self.names] + ["setpoint"]
        self.rooms = self.kinds.count("room_temp_")
        self.exogenous = len(self.names) - self.rooms
        if not self.rooms:
            raise refused("signals", ", ".join(names), "room temperatures room_temp_1 ..", "name another plant")
        self.labels = np.array([LABELS.get(kind, 1.0) for kind in self.kinds], dtype=np.float32)

    @property
    def width(self):
        return len(self.kinds)

    def from_observation(self, names, observation):
        """[S | E] of an observation whose signals are names."""
        told = dict(zip(names, observation.tolist(), strict=True))
        return np.array([told[name] for name in self.names], dtype=np.float64)


def read_rows(path):
    """(names, rows): the 6-min rows [S | E | A] of a log, in the order of Layout(names)."""
    with open(path, encoding="utf-8", newline="") as file:
        table = csv.reader(file)
        header = next(table)
        places = {}
        for place, column in enumerate(header):
            if kind_of(column) and not column.endswith("_stand_in"):
                places[_without_unit(column)] = place
        layout = Layout(list(places))
        wanted = [places[name] for name in layout.names] + [header.index("setpoint_degc")]
        rows = np.array([[float(row[place]) for place in wanted] for row in table], dtype=np.float64)
    if len(rows) < 2 * CYCLE_ROWS or not np.isfinite(rows).all():
        raise refused(path, f"{len(rows)} rows", "finite rows of some cycles", "simulate more days")
    return layout, rows


def _without_unit(column):
    for ending in ENDINGS[1:]:
        if column.endswith(ending):
            return column[:-len(ending)]
    return column
