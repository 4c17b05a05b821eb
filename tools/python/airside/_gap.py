"""The gap workflow: which effect is missing in a model."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _airside
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


def gap(measured: _Path, *, site: _Path | None = None, plant: str | None = None, room: str | None = None,
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
    if reference_days and not 2 <= reference_days <= 366:
        raise InputError("reference_days", str(reference_days), "2 to 366", "choose another")
    if jobs is not None and not 1 <= jobs <= 256:
        raise InputError("jobs", str(jobs), "1 to 256", "choose another, or leave it out")
    if buildings is not None and not 0 <= buildings <= 1000:
        raise InputError("buildings", str(buildings), "0 to 1000", "choose another, or leave it out")
    if plant not in (None, "rc", "energyplus"):
        raise InputError("plant", repr(plant), "rc or energyplus", "choose one of these")

    def text(path: _Path | None) -> str | None:
        return None if path is None else os.fspath(path)

    with tempfile.TemporaryDirectory(prefix="airside-gap-") as nowhere:
        folder = Path(nowhere) / "out" if out is None else Path(out)
        facts: dict[str, Any] = json.loads(_airside.gap(
            measured=os.fspath(measured), site=text(site), plant=plant, room=room, twin=text(twin),
            patches=[os.fspath(patch) for patch in patches], weather=text(weather), reference=text(reference),
            reference_days=reference_days, no_reference=no_reference, effects=text(effects), tries=list(tries),
            buildings=buildings, best_guess=best_guess, findings_only=findings_only, no_duties=no_duties,
            sun_on_site=sun_on_site, jobs=jobs, out=str(folder), progress=progress))
    return GapVerdict(facts["verdict"], facts["sentence"], None if out is None else folder, facts)
