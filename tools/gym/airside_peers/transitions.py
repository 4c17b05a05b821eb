"""Scaling, and transitions from logged rows (docs/method.md 3.1, open points 1 and 3)."""

import dataclasses
import math

import numpy as np

from .signals import CYCLE_ROWS, FLAGS

SETPOINT_RANGE_DEGC = (20.0, 26.0)
FLOOR_K, FLOOR_KW, FLOOR_SHARE = 0.5, 0.05, 0.05


class Scaler:
    """Standard scores; one mean and scale for all rooms, the action range for the setpoint, flags as they are."""

    def __init__(self, layout, rows):
        self.mean, self.scale = np.zeros(layout.width), np.ones(layout.width)
        rooms = rows[:, :layout.rooms]
        for place, kind in enumerate(layout.kinds):
            if kind in FLAGS:
                continue
            values = rooms if kind == "room_temp_" else rows[:, place]
            self.mean[place] = values.mean()
            self.scale[place] = max(values.std(), _floor(kind, self.mean[place]))
        least, most = SETPOINT_RANGE_DEGC
        self.mean[-1], self.scale[-1] = (least + most) / 2, (most - least) / math.sqrt(12)

    def scaled(self, vectors):
        """Of whole inputs, or of readings without the setpoint."""
        width = vectors.shape[-1]
        return ((vectors - self.mean[:width]) / self.scale[:width]).astype(np.float32)

    def setpoints(self, degc):
        return ((np.asarray(degc) - self.mean[-1]) / self.scale[-1]).astype(np.float32)

    def room_degc(self, scaled):
        return self.mean[0] + self.scale[0] * scaled


def _floor(kind, mean):
    return max(FLOOR_SHARE * abs(mean), FLOOR_KW) if kind == "power_" else FLOOR_K


@dataclasses.dataclass
class Transitions:
    """windows: (count, cycles, inputs), the newest cycle last; after: (count, rooms + exogenous). Both scaled."""

    windows: np.ndarray
    after: np.ndarray

    def __len__(self):
        return len(self.after)


def starts_of(rows, cycles, aligned):
    """Rows that start a transition: the setpoint is constant over its three rows, and the window before is known."""
    starts = np.arange(CYCLE_ROWS * (cycles - 1), len(rows) - CYCLE_ROWS)
    held = np.ones(len(starts), dtype=bool)
    for later in range(1, CYCLE_ROWS):
        held &= rows[starts, -1] == rows[starts + later, -1]
    if aligned:
        held &= starts % CYCLE_ROWS == 0
    return starts[held]


def transitions_of(rows, scaler, cycles=1, aligned=False):
    """aligned: only those that start with a control cycle, 80 a day, so that every log gives as many."""
    starts = starts_of(rows, cycles, aligned)
    inputs = scaler.scaled(rows)
    back = CYCLE_ROWS * np.arange(cycles - 1, -1, -1)
    return Transitions(inputs[starts[:, None] - back], inputs[starts + CYCLE_ROWS, :-1])
