"""Runs, one JSON file each: what is in the folder already is not done again."""

import dataclasses
import json
import os
from pathlib import Path

from airside_gym.failure import refused

from . import published

# Relative cost of a run, for the time that is left. Methods of the program itself need no torch.
CONTROL_COST = {
    "expert": 0.1, "pid-spec": 0.1, "airside-product": 2, "airside-paper": 20, "ddqn": 20, "osln": 30, "ed": 75,
    "lstm-2-2": 170, "lstm-3-2": 190, "lstm-3-4": 380, "lstm-6-4": 840,
    "transformer-2-2": 200, "transformer-3-2": 270, "transformer-3-4": 540, "transformer-6-4": 1200,
}
TRANSFER_COST = {"persistence": 1, "none": 15, "fatdm-head": 80, "fatdm-tail": 20, "static": 130, "dynamic": 130,
                 "daf": 80}
COSTS = {"control": CONTROL_COST, "transfer": TRANSFER_COST}
OF_THE_PROGRAM = ("expert", "pid-spec", "airside-product", "airside-paper")


@dataclasses.dataclass(frozen=True)
class Run:
    """settings: whatever else the result depends on, as (name, value); it is part of the file's name."""

    study: str
    plant: str
    room: str
    method: str
    seed: int
    settings: tuple

    @property
    def name(self):
        words = [self.study, self.plant, self.room.replace("/", "-"), self.method]
        return "_".join(words + [f"{name}{value}" for name, value in self.settings] + [f"seed{self.seed}"])

    @property
    def cost(self):
        return COSTS[self.study][self.method]


def planned(study, plant, rooms, methods, seeds, settings):
    """[Run]: all rows of the first seed come first; within a seed the cheap methods."""
    methods = sorted(methods, key=list(COSTS[study]).index)
    return [Run(study, plant, room, method, seed, tuple(settings.items()))
            for seed in range(1, seeds + 1) for room in rooms for method in methods]


class Results:
    """A folder of results; made when the first is kept."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def check_place(self):
        """Raises AirsideError where the folder cannot be made, before hours of work; leaves nothing."""
        lacking = [path for path in (self.folder, *self.folder.parents) if not path.exists()]
        self._make()
        for path in lacking:
            path.rmdir()

    def _make(self):
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as cause:
            raise refused(self.folder, f"no folder ({cause})", "a folder for results", "name another with --results") \
                from cause

    def path(self, run):
        return self.folder / f"{run.name}.json"

    def missing(self, runs):
        return [run for run in runs if not self.path(run).exists()]

    def save(self, run, figures, program):
        """All or nothing: a run that was broken off leaves no file. program: what it says of its version."""
        found = {**dataclasses.asdict(run), "settings": dict(run.settings), "program": program, "figures": figures}
        text = json.dumps(found, indent=1) + "\n"
        self._make()
        unfinished = self.path(run).with_suffix(".unfinished")
        unfinished.write_text(text, encoding="utf-8")
        os.replace(unfinished, self.path(run))

    def load(self, runs):
        """{run: figures} of those that are there."""
        found = {}
        for run in runs:
            path = self.path(run)
            if not path.exists():
                continue
            try:
                found[run] = json.loads(path.read_text(encoding="utf-8"))["figures"]
            except (ValueError, KeyError, TypeError) as cause:
                raise refused(path, f"no result ({cause})", "a file that this tool wrote",
                              "delete it; it will be made again") from cause
        return found

    def load_some(self, runs):
        """As load(), but none at all is an AirsideError."""
        expected = "a folder for results with some of the runs that are asked for"
        if not self.folder.is_dir():
            raise refused(self.folder, "no such folder", expected, "correct --results, or leave --only-table out")
        found = self.load(runs)
        if not found:
            raise refused(self.folder, f"none of {len(runs)} runs such as {self.path(runs[0]).name}", expected,
                          "name the same --days, --rooms and so on as when they were made, or leave --only-table out")
        return found


def series_of(method):
    """(kind, sequence length, layers) of a time-series method, else None."""
    if method not in published.SERIES:
        return None
    kind, length, layers = method.split("-")
    return kind, int(length), int(layers)
