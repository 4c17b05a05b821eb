"""Logs of the transfer study: two of the twin to pretrain on, one of the target's schedule, two of its seasons."""

import tempfile
from pathlib import Path

from airside_gym.program import run as run_program

from .signals import read_rows
from .transitions import Scaler, transitions_of

ROWS_OF_A_DAY = 240
EXPERT_DAYS = 5
SOURCE_START = "2021-07-01"
SEASONS = {"summer": "2021-07-20", "winter": "2021-12-01"}  # first schedule day; the season begins five days later


class Logs:
    """Made by the program into a folder and kept there, since all methods of a room and seed use them."""

    def __init__(self, program, folder, run):
        self._program, self._folder, self._run = program, Path(folder), run
        self._settings = dict(run.settings)
        self._folder.mkdir(parents=True, exist_ok=True)

    def source(self, kind):
        """(layout, rows) of the twin under kind: dynamic (the method's agent) or static (schedules drawn)."""
        days = self._settings["source"]
        words = ["pretrain", "--plant", self._run.plant, "--room", self._run.room.removesuffix("-real"), "--preset",
                 "paper", "--start", SOURCE_START, "--days", str(days), "--seed", str(self._run.seed)]
        words += ["--static=drawn", "--updates", "1"] if kind == "static" else []
        return read_rows(self._made(f"{kind}_{days}", words, "--log", blob=True))

    def season(self, season):
        """Rows of the target room under the product."""
        days = self._settings[season]
        words = ["--days", str(days), "--transfer"]
        return read_rows(self._made(f"{season}_{days}", self._simulated(season, words), "--log"))[1]

    def schedule(self, season):
        """(layout, rows) of the five biased days before a season."""
        words = self._simulated(season, ["--days", "1", "--method", "expert"])
        return read_rows(self._made("schedule" if season == "summer" else f"schedule_{season}", words, "--history-log"))

    def _simulated(self, season, words):
        return ["simulate", "--plant", self._run.plant, "--room", self._run.room, "--start", SEASONS[season],
                "--expert-days", str(EXPERT_DAYS), "--seed", str(self._run.seed), *words]

    def _made(self, what, words, option, blob=False):
        run = self._run
        path = self._folder / f"{run.plant}_{run.room.replace('/', '-')}_seed{run.seed}_{what}.csv"
        if not path.exists():
            with tempfile.TemporaryDirectory(dir=self._folder) as desk:
                made = Path(desk) / "log.csv"
                weights = ["--out", str(Path(desk) / "weights.blob")] if blob else []
                run_program(self._program, *words, option, str(made), "--json", *weights)
                made.rename(path)
        return path


def source_transitions(logs, kind):
    """(scaler, transitions): 80 a day whatever the setpoints did, so that every log teaches as many."""
    layout, rows = logs.source(kind)
    scaler = Scaler(layout, rows[:ROWS_OF_A_DAY])
    return scaler, transitions_of(rows, scaler, aligned=True)
