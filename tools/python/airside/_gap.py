"""The gap workflow: which effect is missing in a model."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _airside, _arguments
from ._errors import InputError

_Path = str | os.PathLike[str]


@dataclass(frozen=True)
class GapVerdict:
    """What the workflow says of a log and a model."""

    verdict: str
    """"none", "named", "ambiguous" or "unknown"."""
    sentence: str
    """The same in one sentence."""
    folder: Path | None
    """With report, gap.json and patch; None where none was asked for."""
    facts: dict[str, Any]
    """All of `airside gap --json` (docs/formats.md)."""


def gap(measured: _Path, *, site: _Path | None = None, plant: str | None = None, room: str | int | None = None,
        twin: _Path | None = None, patches: Sequence[_Path] = (), weather: _Path | None = None,
        reference: _Path | None = None, reference_days: int = 0, no_reference: bool = False,
        effects: _Path | None = None, tries: Sequence[str] = (), buildings: int | None = None,
        best_guess: bool = False, findings_only: bool = False, no_duties: bool = False, sun_on_site: bool = False,
        jobs: int | None = None, out: _Path | None = None, progress: bool = False) -> GapVerdict:
    """Compares a log with a model, and names the effect that is missing: `airside gap`.

    `measured`: the log to judge. The model: `plant` "rc" with `room`, an EnergyPlus `twin`, or that of the `site`. One
    of `reference` (a log of days on which the model was right), `reference_days` (the first days of `measured` are) and
    `no_reference`. `weather`: EPW; default that beside the log. `out`: folder for report, gap.json and patch; without,
    nothing is left. `progress`: a bar on standard error. The other arguments are the program's options.

    Raises InputError for what cannot be used. An EnergyPlus model needs the engine and the program airside-energyplus
    (AIRSIDE_ENERGYPLUS_WORKER names it).
    """
    days = _arguments.whole("reference_days", reference_days, 0, 366)
    if days == 1:
        raise InputError("reference_days", "1", "2 to 366", "choose another")
    if jobs is not None:
        jobs = _arguments.whole("jobs", jobs, 1, 256)
    if buildings is not None:
        buildings = _arguments.whole("buildings", buildings, 0, 1000)
    if plant not in (None, "rc", "energyplus"):
        raise InputError("plant", repr(plant), "rc or energyplus", "choose one of these")
    for name, value in (("patches", patches), ("tries", tries)):
        if isinstance(value, (str, bytes, os.PathLike)) or not isinstance(value, Iterable):
            raise InputError(name, repr(value), "a list", "put it in [ ]")
    path = _arguments.path_or_none
    with tempfile.TemporaryDirectory(prefix="airside-gap-") as nowhere:
        folder = Path(nowhere) / "out" if out is None else Path(_arguments.path("out", out))
        facts: dict[str, Any] = json.loads(_airside.gap(
            measured=_arguments.path("measured", measured), site=_arguments.site(site), plant=plant,
            room=None if room is None else _arguments.room(room), twin=path("twin", twin),
            patches=[_arguments.path("patches", patch) for patch in patches], weather=path("weather", weather),
            reference=path("reference", reference), reference_days=days,
            no_reference=_arguments.flag("no_reference", no_reference), effects=path("effects", effects),
            tries=[_arguments.text("tries", one, "vav_flow@2=0.5") for one in tries], buildings=buildings,
            best_guess=_arguments.flag("best_guess", best_guess),
            findings_only=_arguments.flag("findings_only", findings_only),
            no_duties=_arguments.flag("no_duties", no_duties), sun_on_site=_arguments.flag("sun_on_site", sun_on_site),
            jobs=jobs, out=str(folder), progress=_arguments.flag("progress", progress)))
    return GapVerdict(facts["verdict"], facts["sentence"], None if out is None else folder, facts)
