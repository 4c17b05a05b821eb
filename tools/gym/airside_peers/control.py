"""One control run: five days of the schedule teach an agent, then it controls the room and learns on."""

import datetime
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
import torch
from airside_gym.environment import RoomEnvironment
from airside_gym.program import run as run_program
from airside_gym.scores import Scores

from .agents import FIRST_STEPS, agent_of
from .choices import Confidence, expert_degc
from .signals import CYCLE_ROWS, Layout, read_rows
from .transitions import Scaler, transitions_of

EXPERT_DAYS = 5


def schedule_rows(program, run, start):
    """The rows of the schedule's days, as the environment lets them pass before its first observation."""
    with tempfile.TemporaryDirectory() as folder:
        log = str(Path(folder) / "schedule.csv")
        run_program(program, "simulate", "--plant", run.plant, "--room", run.room, "--seed", str(run.seed), "--start",
                    start, "--expert-days", str(EXPERT_DAYS), "--days", "1", "--method", "expert", "--history-log", log,
                    "--json")
        return read_rows(log)


class Controlled:
    """An agent in its room. show: of the share of the run that is done."""

    def __init__(self, program, run, show):
        self._settings, self._show = dict(run.settings), show
        start = self._settings["from"]
        layout, rows = schedule_rows(program, run, start)
        self._scaler, self._layout = Scaler(layout, rows), layout
        self._environment = RoomEnvironment(
            plant=run.plant, room=run.room, start=start, days=self._settings["days"], expert_days=EXPERT_DAYS,
            airside=program)
        self._agent = agent_of(run.method, layout, self._scaler, self._environment.target_degc, run.seed)
        self._total = FIRST_STEPS + self._settings["days"] * 80 * self._settings["updates"]
        self._agent.prepare(transitions_of(rows, self._scaler, self._agent.cycles), self._settings["batch"],
                            lambda done: show(done / self._total))
        cycles = self._agent.cycles
        last = len(rows) - CYCLE_ROWS * np.arange(cycles - 1, 0, -1)
        self._past = [self._scaler.scaled(rows[row]) for row in last]
        self._seed, self._last_degc = run.seed, float(rows[-1, -1])
        self._confidence, self._seconds = Confidence(), []

    def figures(self):
        with self._environment as room:
            return self._through(room)

    def _through(self, room):
        scores = Scores(room.target_degc)
        observation, before = room.reset(seed=self._seed)
        over, newest, cycle = False, None, 0
        while not over:
            readings = self._readings(room, observation)
            if newest is not None:
                self._absorb(newest, readings)
            newest = self._window(readings)
            applied = self._decided(newest, before)
            observation, _, _, over, after = room.step(np.array([applied], dtype=np.float32))
            self._last_degc = after["setpoint_degc"]
            newest[-1, -1] = self._scaler.setpoints(self._last_degc)
            self._past = [*self._past, newest[-1]][1:] if self._past else []
            scores.add(before, after)
            before, cycle = after, cycle + 1
            self._show(min(1.0, (FIRST_STEPS + cycle * self._settings["updates"]) / self._total))
        return {**scores.figures(), "daily_dae_degc": scores.daily_dae_degc(),
                "decision_s": statistics.median(self._seconds), "confidence": self._confidence.value}

    def _readings(self, room, observation):
        return self._scaler.scaled(self._layout.from_observation(room.signal_names, observation))

    def _window(self, readings):
        newest = np.append(readings, np.float32(0))
        return np.stack([*self._past, newest])

    def _absorb(self, window, readings):
        surprise = self._agent.absorb(torch.from_numpy(window[None].copy()), torch.from_numpy(readings[None]),
                                      self._settings["updates"], self._settings["batch"])
        if surprise is not None:
            self._confidence.update(surprise)

    def _decided(self, window, before):
        begun = time.perf_counter()
        chosen = self._agent.choose(window, self._last_degc)
        self._seconds.append(time.perf_counter() - begun)
        if not self._agent.is_blended:
            return chosen
        hour = datetime.datetime.fromisoformat(before["time"]).hour
        return self._confidence.blended(chosen, expert_degc(hour))
