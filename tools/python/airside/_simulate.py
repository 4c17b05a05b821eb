"""A simulated room under any method."""

from __future__ import annotations

import datetime
import json
import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _airside, _arguments
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


def simulate(*, room: str | int | os.PathLike[str] = "301", method: str = "ours", seed: int = 1, days: int = 14,
             expert_days: int = 5, start: str | datetime.date = "2021-08-01", weights: _Path | None = None,
             transfer: bool = False, steps: int = 3000, site: _Path | None = None, topology: str = "5vav-5fcu-2power",
             preset: str | None = None, weather: _Path | None = None, weekends: bool = False,
             history: _Path | None = None, faults: _Path | None = None, log: _Path | None = None,
             history_log: _Path | None = None, progress: Callable[[float], object] | None = None) -> Run:
    """Controls a simulated room of resistances and capacities with the box's own code: `airside simulate --plant rc`.

    `room`: a built-in room ("301", "301-real", "study-0", ...) or a room file. `method`: "ours", "expert" (the
    schedule), "pid-tuned", ...; a wrong name lists all. "ours" wants `weights` (a blob), or `transfer` (trains on the
    schedule's days), or both; the objective band wants neither. `seed`: of people, outages and noise, 0 to
    9223372036854775807; the same seed gives the same bits as the program. `site`: a site file or its folder. `log`,
    `history_log`: CSV files to write; where no `weather` (EPW) is given, the made-up one goes beside `log`. `progress`
    is called with a share of 0 to 1; Ctrl-C ends a run.

    Raises InputError for what cannot be used, before anything is computed.
    """
    if preset is not None and preset not in _airside.preset_names():
        raise InputError("preset", repr(preset), " or ".join(_airside.preset_names()), "choose one of these")
    if progress is not None and not callable(progress):
        raise InputError("progress", repr(progress), "a function that takes a share of 0 to 1", "leave it out")
    found = _airside.simulate(
        method=_arguments.text("method", method, "pid-tuned"), room=_arguments.room(room),
        seed=_arguments.whole("seed", seed, 0, _arguments.MOST_SEED), days=_arguments.whole("days", days, 1, 300),
        expert_days=_arguments.whole("expert_days", expert_days, 0, 60), start=_arguments.day("start", start),
        weights=_arguments.path_or_none("weights", weights), transfer=_arguments.flag("transfer", transfer),
        steps=_arguments.whole("steps", steps, 0, 1_000_000), site=_arguments.site(site),
        topology=_arguments.text("topology", topology, "5vav-5fcu-2power"), preset=preset,
        weather=_arguments.path_or_none("weather", weather), weekends=_arguments.flag("weekends", weekends),
        history=_arguments.path_or_none("history", history), faults=_arguments.path_or_none("faults", faults),
        log=_arguments.path_or_none("log", log), history_log=_arguments.path_or_none("history_log", history_log),
        progress=progress)
    facts: dict[str, Any] = json.loads(found["json"])
    return Run(Figures(**{field.name: facts[field.name] for field in fields(Figures)}), made(found["log"]),
               made(found["history"]), np.array(facts["setpoint_degc"]), facts, found["weather"])
