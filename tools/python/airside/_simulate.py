"""A simulated room under any method."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _airside
from ._errors import InputError
from ._log import Log, made

_Path = str | os.PathLike[str]


@dataclass(frozen=True)
class Figures:
    """Figures of the controlled days, as docs/method.md 9 defines them; working hours unless said otherwise."""

    dae_degc: float
    """DAE: mean distance of the rooms' mean from the target."""
    me_degc: float
    """ME: the worst day's DAE."""
    day1_dae_degc: float
    darv_degc: float
    """DARV: how restless the setpoint is."""
    cdh_degch: float
    """Cooling degree-hours, total."""
    hdh_degch: float
    """Heating degree-hours, total."""
    degree_hours_per_day_degch: float
    """Above and below the target."""
    hvac_kwh: float | None
    """Energy at all hours; None without a meter."""
    hvac_kwh_per_day: float | None
    worst_room_dae_degc: float
    room_dae_degc: list[float]
    daily_dae_degc: list[float]


@dataclass(frozen=True)
class Run:
    """What a simulated run left behind."""

    figures: Figures
    log: Log
    """The controlled days, rows of 6 min."""
    history: Log
    """The days under the schedule before."""
    setpoint_degc: npt.NDArray[np.float64]
    """One a decision."""
    facts: dict[str, Any]
    """All of `airside simulate --json`: figures, plant, engine, weather, version and commit, ..."""
    weather: str
    """The EPW file that was written beside `log`; "" without."""


def _within(name: str, value: int, least: int, most: int) -> None:
    if not least <= value <= most:
        raise InputError(name, str(value), f"{least} to {most}", "choose another")


def simulate(*, room: str = "301", method: str = "ours", seed: int = 1, days: int = 14, expert_days: int = 5,
             start: str = "2021-08-01", weights: _Path | None = None, transfer: bool = False, steps: int = 3000,
             site: _Path | None = None, topology: str = "5vav-5fcu-2power", preset: str | None = None,
             weather: _Path | None = None, weekends: bool = False, history: _Path | None = None,
             faults: _Path | None = None, log: _Path | None = None, history_log: _Path | None = None,
             progress: Callable[[float], object] | None = None) -> Run:
    """Controls a simulated room of resistances and capacities with the box's own code: `airside simulate --plant rc`.

    `room`: a built-in room ("301", "301-real", "study-0", ...) or a room file. `method`: "ours", "expert" (the
    schedule), "pid-tuned", ...; a wrong name lists all. "ours" wants `weights` (a blob), or `transfer` (trains on the
    schedule's days), or both; the objective band wants neither. `seed`: of people, outages and noise; the same seed
    gives the same bits as the program. `log`, `history_log`: CSV files to write; where no `weather` (EPW) is given, the
    made-up one goes beside `log`. `progress` is called with a share of 0 to 1; Ctrl-C ends a run.

    Raises InputError for what cannot be used, before anything is computed.
    """
    _within("days", days, 1, 300)
    _within("expert_days", expert_days, 0, 60)
    _within("steps", steps, 0, 1_000_000)
    _within("seed", seed, 0, 2**64 - 1)
    if preset is not None and preset not in _airside.preset_names():
        raise InputError("preset", repr(preset), " or ".join(_airside.preset_names()), "choose one of these")

    def text(path: _Path | None) -> str | None:
        return None if path is None else os.fspath(path)

    found = _airside.simulate(method=method, room=room, seed=seed, days=days, expert_days=expert_days, start=start,
                              weights=text(weights), transfer=transfer, steps=steps, site=text(site), topology=topology,
                              preset=preset, weather=text(weather), weekends=weekends, history=text(history),
                              faults=text(faults), log=text(log), history_log=text(history_log), progress=progress)
    facts: dict[str, Any] = json.loads(found["json"])
    return Run(Figures(**{field.name: facts[field.name] for field in fields(Figures)}), made(found["log"]),
               made(found["history"]), np.array(facts["setpoint_degc"]), facts, found["weather"])
