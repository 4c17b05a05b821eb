"""DDQN: a model-free agent that is trained inside an identified model first, then goes on learning in the room."""

import copy

import numpy as np
import torch

from . import losses
from .learner import CAPACITY, LEARNING_RATE, SYNC_STEPS, Learner, Replay
from .networks import EdNetwork, layers
from .signals import CYCLE_ROWS
from .transitions import SETPOINT_RANGE_DEGC

STEP_K, DISCOUNT, BATCH = 0.5, 0.9, 64
MODEL_STEPS, EPISODES, CYCLES_OF_A_DAY = 3000, 200, 80
EXPLORATION_FIRST, EXPLORATION_LAST = 1.0, 0.05


class QLearner:
    """Double Q-learning over readings [S | E]."""

    def __init__(self, readings, actions):
        self.network = torch.nn.Sequential(layers(readings, 64, 64), torch.nn.Linear(64, actions))
        self._target = copy.deepcopy(self.network).requires_grad_(False)
        self._optimiser = torch.optim.Adam(self.network.parameters(), LEARNING_RATE, fused=True)
        self._before, self._after = torch.empty(CAPACITY, readings), torch.empty(CAPACITY, readings)
        self._actions, self._rewards = torch.empty(CAPACITY, dtype=torch.long), torch.empty(CAPACITY)
        self._seen = self._steps = 0

    def remember(self, before, action, reward, after):
        place = self._seen % CAPACITY
        self._before[place], self._after[place] = before, after
        self._actions[place], self._rewards[place] = action, reward
        self._seen += 1

    def step(self):
        known = min(self._seen, CAPACITY)
        if known < BATCH:
            return
        drawn = torch.randint(known, (BATCH,))
        with torch.no_grad():
            best = self.network(self._after[drawn]).argmax(1, keepdim=True)
            wanted = self._rewards[drawn] + DISCOUNT * self._target(self._after[drawn]).gather(1, best)[:, 0]
        found = self.network(self._before[drawn]).gather(1, self._actions[drawn][:, None])[:, 0]
        self._optimiser.zero_grad()
        losses.squared(found, wanted).backward()
        self._optimiser.step()
        self._steps += 1
        if self._steps % SYNC_STEPS == 0:
            self._target.load_state_dict(self.network.state_dict())

    @torch.no_grad()
    def best(self, readings):
        return int(self.network(readings[None]).argmax())


class QAgent:
    """Its setpoint is not blended: it has no forecast whose loss could tell how far to trust it."""

    is_blended, cycles = False, 1

    def __init__(self, layout, scaler, target_degc, seed):
        self._layout, self._scaler, self._target_degc = layout, scaler, target_degc
        least, most = SETPOINT_RANGE_DEGC
        self._setpoints = np.arange(least, most + STEP_K / 2, STEP_K)
        self._model = Learner(EdNetwork(layout), losses.short_loss)
        self._q = QLearner(layout.rooms + layout.exogenous, len(self._setpoints))
        self._rng, self._action = np.random.default_rng(seed), 0

    def prepare(self, schedule, batch, show):
        self._model.train(Replay(schedule), MODEL_STEPS, show, batch)
        for episode in range(EPISODES):
            share = episode / (EPISODES - 1)
            self._episode(schedule, EXPLORATION_FIRST + share * (EXPLORATION_LAST - EXPLORATION_FIRST))

    def _episode(self, schedule, exploration):
        """A day in the model: rooms go their way from a drawn row on, everything else as it was logged."""
        logged = torch.from_numpy(schedule.windows[:, -1, :-1])
        place = int(self._rng.integers(max(1, len(logged) - CYCLE_ROWS * CYCLES_OF_A_DAY)))
        readings = logged[place]
        setpoints = self._scaler.setpoints(self._setpoints)
        for _ in range(CYCLES_OF_A_DAY):
            place += CYCLE_ROWS
            if place >= len(logged):
                return
            action = self._explored(readings, exploration)
            inputs = torch.cat([readings, torch.tensor(setpoints[action:action + 1])])
            with torch.no_grad():
                rooms = self._model.network.short_term(inputs[None])[0][0]
            after = torch.cat([rooms, logged[place, self._layout.rooms:]])
            self._q.remember(readings, action, self._reward(after), after)
            self._q.step()
            readings = after

    def _explored(self, readings, exploration):
        if self._rng.random() < exploration:
            return int(self._rng.integers(len(self._setpoints)))
        return self._q.best(readings)

    def _reward(self, readings):
        degc = self._scaler.room_degc(float(readings[:self._layout.rooms].mean()))
        return -abs(degc - self._target_degc)

    def absorb(self, windows, after, updates, _batch):
        self._q.remember(windows[0, -1, :-1], self._action, self._reward(after[0]), after[0])
        for _ in range(updates):
            self._q.step()

    def choose(self, window, _last_degc):
        self._action = self._explored(torch.from_numpy(window[-1, :-1]), EXPLORATION_LAST)
        return float(self._setpoints[self._action])
