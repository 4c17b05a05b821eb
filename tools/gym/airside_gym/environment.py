"""A room and its air handling unit as a Gymnasium environment."""

import datetime
import math
import os
import statistics

import gymnasium
import numpy as np

from .failure import AirsideError, refused
from .points import blocks_of
from .program import ServedRoom, find_program
from .site import ROW_S, SECONDS_OF_DAY, Site, limits_of

HOURS_OF_A_ROW = ROW_S / 3600
CLOCK_EPOCH = datetime.datetime(2000, 1, 1)
TIME_NAMES = ("time_of_day_sin", "time_of_day_cos", "weekend")
OF_ONE_EPISODE = {"start", "room", "plant", "days", "expert_days", "serve_options"}


def _checked_number(name, value, least, expected):
    number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not number or not math.isfinite(value) or value < least:
        raise refused(name, value if number else repr(value), expected, "correct it" if number else "give a number")


def _checked_words(words):
    """Of serve_options: a text would be taken letter by letter."""
    if isinstance(words, (str, bytes, os.PathLike)):
        remedy = f"write {tuple(words.split())!r}" if isinstance(words, str) else "put it into a tuple"
        raise refused("serve_options", repr(words), 'a list of words such as ("--faults", "faults.csv")', remedy)
    try:
        return tuple(words)
    except TypeError:
        raise refused("serve_options", repr(words), 'a list of words such as ("--faults", "faults.csv")',
                      "leave it out where there are none") from None


class RoomEnvironment(gymnasium.Env):
    """One episode is a run of days, one step a control cycle: 18 min unless the site says otherwise.

    Observation: Box of float32, shape (len(signal_names),): the site's signals in the order of its point map and in
    their units (signal_units), as the sensors show them at the end of the step, then sine and cosine of the time of
    day and 1 on Saturday and Sunday. A signal without a value keeps its last one; info["missing"] names it.

    Action: Box of float32, shape (1,): supply-air setpoint in degC within the site's range. With discrete_step_k:
    Discrete, the number of a setpoint in `setpoints_degc`.

    Reward: minus the distance of the mean room temperature from the target in K at the end of the step, 0 outside
    working hours; minus movement_penalty for each K that the setpoint moved, at all hours.

    The days are over: truncated. Nothing terminates an episode.
    """

    metadata = {"render_modes": []}

    def __init__(self, *, plant="auto", room=None, site=None, twin=None, topology="5vav-5fcu-2power", start=None,
                 days=14, expert_days=0, discrete_step_k=None, movement_penalty=0.0, serve_options=(), airside=None,
                 needs_site=False):
        """plant, room, topology, start (a date), days, expert_days: as of `airside serve`; those of the program where
        they are None. site: a site file or its folder. twin: whether the site's [twin] is served (default: where it
        has one). serve_options: further words for `airside serve`. airside: path of the program."""
        if needs_site and site is None:
            raise refused("airside/Site-v0", "no site", "a site file or its folder", "give site=PATH")
        _checked_number("movement_penalty", movement_penalty, 0, "0 or more for each K")
        if discrete_step_k is not None:
            _checked_number("discrete_step_k", discrete_step_k, -math.inf, "more than 0 K")
        self._movement_penalty = movement_penalty
        options = _checked_words(serve_options)
        self._program = find_program(airside)
        self._site = Site(self._program, site, topology)
        self._twin = self._site.has_twin if twin is None else twin
        self._choices = {"plant": plant, "room": room, "start": start, "days": days, "expert_days": expert_days,
                         "serve_options": options}
        self._served = None
        try:
            self._make_spaces(discrete_step_k)
        except AirsideError:
            self._site.close()
            raise
        self._blocks = blocks_of([*self._site.signals, self._site.points["clock_s"]])
        self._rooms = self._site.rooms()
        self._meters = [p.name for p in self._site.signals if p.name.startswith("power_")]

    def _make_spaces(self, discrete_step_k):
        signals = self._site.signals
        self.signal_names = tuple(p.name for p in signals) + TIME_NAMES
        self.signal_units = tuple(p.unit for p in signals) + ("",) * len(TIME_NAMES)
        limits = [limits_of(p) for p in signals] + [(-1, 1), (-1, 1), (0, 1)]
        self._least, self._most = np.array(limits, dtype=np.float32).T.copy()
        self.observation_space = gymnasium.spaces.Box(self._least, self._most, dtype=np.float32)
        least, most = self._site.setpoint_degc
        self.setpoints_degc = None
        if discrete_step_k is None:
            self.action_space = gymnasium.spaces.Box(least, most, (1,), np.float32)
            return
        if not 0 < discrete_step_k <= most - least:
            raise refused("discrete_step_k", discrete_step_k, f"more than 0 and up to {most - least:g} K", "correct it")
        count = math.floor((most - least) / discrete_step_k + 1e-9) + 1
        self.setpoints_degc = tuple(round(least + i * discrete_step_k, 6) for i in range(count))
        self.action_space = gymnasium.spaces.Discrete(count)

    @property
    def target_degc(self):
        return self._site.target_degc

    def reset(self, *, seed=None, options=None):
        """Starts another run. seed: `--seed` of the run, of people, outages and noise; without one the next of this
        environment's own. options: other values of start, room, plant, days, expert_days or serve_options, for this
        episode alone."""
        super().reset(seed=seed)
        unknown = set(options or {}) - OF_ONE_EPISODE
        if unknown:
            raise refused("reset: options", ", ".join(sorted(map(str, unknown))), ", ".join(sorted(OF_ONE_EPISODE)),
                          "give the others when the environment is made")
        chosen = {**self._choices, **(options or {})}
        chosen["serve_options"] = _checked_words(chosen["serve_options"])
        self._stop()
        run_seed = int(self.np_random.integers(2**31)) if seed is None else seed
        self._served = ServedRoom(self._program, self._serve_options(chosen, run_seed))
        self._values, self._setpoint_degc = {}, None
        self._energy_kwh = 0.0
        self._read(self._exchange([block.request for block in self._blocks]))
        self._end = self._time + datetime.timedelta(days=int(chosen["days"]))
        return self._observation(), {**self._info(), "seed": run_seed, "plant": self._served.facts["plant"]}

    def _serve_options(self, chosen, seed):
        options = ["--site", self._site.path, "--seed", str(seed)]
        for name in ("plant", "room", "start", "days", "expert_days"):
            if chosen[name] is not None:
                options += ["--" + name.replace("_", "-"), str(chosen[name])]
        return options + (["--twin"] if self._twin else []) + [str(word) for word in chosen["serve_options"]]

    def step(self, action):
        if self._served is None or self._time >= self._end:
            raise refused("step", "an episode that is over or not begun", "one that goes on", "call reset() first")
        before, setpoint = self._setpoint_degc, self._setpoint_of(action)
        rows = self._site.rows_of_a_cycle
        now_s = round((self._time - CLOCK_EPOCH).total_seconds())
        requests = [self._site.points["setpoint"].write_of(setpoint)]
        for row in range(1, rows + 1):
            requests.append(self._site.points["clock_advance_s"].write_of(now_s + row * ROW_S))
            if self._meters or row == rows:
                requests += [block.request for block in self._blocks]
        answers = [answer for answer in self._exchange(requests) if answer]
        for at in range(0, len(answers), len(self._blocks)):
            self._energy_kwh += HOURS_OF_A_ROW * sum(self._values[name] for name in self._meters)
            self._read(answers[at:at + len(self._blocks)])
        reached_s = round((self._time - CLOCK_EPOCH).total_seconds())
        if reached_s != now_s + rows * ROW_S:
            self._stop()
            raise refused("clock_s", f"{reached_s} s", f"{now_s + rows * ROW_S} s",
                          "the plant did not go on; let it be served without --speed")
        moved = 0.0 if before is None else abs(self._setpoint_degc - before)
        scored = self._site.is_scored(self._time)
        reward = -abs(self._room_mean() - self.target_degc) if scored else 0.0
        return (self._observation(), reward - self._movement_penalty * moved, False, self._time >= self._end,
                self._info())

    def _exchange(self, requests):
        try:
            return self._served.exchange(requests)
        except BaseException:
            self._stop()  # an answer may still be on its way
            raise

    def _setpoint_of(self, action):
        if self.setpoints_degc is not None:
            if not self.action_space.contains(action):
                raise refused("action", repr(action), f"a number from 0 to {len(self.setpoints_degc) - 1}",
                              "give the place of a setpoint in setpoints_degc")
            return self.setpoints_degc[int(action)]
        setpoint = np.asarray(action, dtype=np.float64).reshape(-1)
        if setpoint.shape != (1,) or not np.isfinite(setpoint[0]):
            raise refused("action", repr(action), "one finite setpoint in degC", "give an array of shape (1,)")
        least, most = self._site.setpoint_degc
        return min(max(float(setpoint[0]), least), most)

    def _read(self, answers):
        """Takes one reading of all blocks; what has no value keeps its last one, at first the middle of its limits."""
        told = {}
        for block, words in zip(self._blocks, answers, strict=True):
            told.update(block.values(words))
        self._time = CLOCK_EPOCH + datetime.timedelta(seconds=told.pop("clock_s"))
        self._missing = tuple(name for name, value in told.items() if math.isnan(value))
        for name in self._missing:
            told[name] = self._values.get(name, sum(limits_of(self._site.points[name])) / 2)
        self._values = told
        self._setpoint_degc = told["setpoint"]

    def _room_mean(self):
        """Mean room temperature in degC; a room of several sensors counts with their median."""
        return statistics.fmean(statistics.median(self._values[n] for n in names) for names in self._rooms)

    def _observation(self):
        second = self._time.hour * 3600 + self._time.minute * 60 + self._time.second
        angle = 2 * math.pi * second / SECONDS_OF_DAY
        values = [self._values[p.name] for p in self._site.signals]
        values += [math.sin(angle), math.cos(angle), float(self._time.weekday() >= 5)]
        return np.clip(np.array(values, dtype=np.float32), self._least, self._most)

    def _info(self):
        info = {"time": self._time.isoformat(), "room_mean_degc": self._room_mean(),
                "setpoint_degc": self._setpoint_degc, "scored": self._site.is_scored(self._time),
                "missing": self._missing}
        return {**info, "energy_kwh": self._energy_kwh} if self._meters else info

    @property
    def child_pid(self):
        """Process number of the program that serves the episode; None between episodes."""
        return None if self._served is None else self._served.pid

    def _stop(self):
        if self._served is not None:
            self._served.close()
            self._served = None

    def close(self):
        """Ends the program; may be called again. What holds no reference is closed as well."""
        self._stop()
        self._site.close()
