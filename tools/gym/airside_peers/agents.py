"""Control peers that forecast: the method's own network, OSLN, LSTM and Transformer."""

import functools

import numpy as np
import torch

from . import choices, losses
from .learner import Learner, Replay
from .networks import EdNetwork, LstmNetwork, TransformerNetwork
from .q_agent import QAgent
from .runs import series_of
from .transitions import Transitions

FIRST_STEPS = 3000  # on the schedule's days
SYNTHETIC_K, SYNTHETIC_GAIN = (-2.0, -1.0, 1.0, 2.0), (0.1, 0.3)


class ForecastAgent:
    """Chooses the best setpoint by its forecasts, and is blended with the schedule by its confidence."""

    is_blended = True

    def __init__(self, network, loss, scaler, target_degc, scores, cycles=1, augment=None):
        self.cycles, self._scaler, self._target_degc = cycles, scaler, target_degc
        self._learner, self._scores, self._augment = Learner(network, loss), scores, augment
        self._setpoints = torch.from_numpy(scaler.setpoints(choices.SETPOINTS_DEGC))
        self._replay = None

    def prepare(self, schedule, batch, show):
        self._replay = Replay(self._augment(schedule) if self._augment else schedule)
        self._learner.train(self._replay, FIRST_STEPS, show, batch)

    def absorb(self, windows, after, updates, batch):
        """Loss of the newest transition before it is learned from; then some optimiser steps."""
        surprise = self._learner.surprise(windows, after)
        self._replay.add(windows, after)
        self._learner.train(self._replay, updates, batch=batch)
        return surprise

    @torch.no_grad()
    def choose(self, window, last_degc):
        """window: (cycles, inputs), scaled; the setpoint of its newest cycle is the one that is asked for."""
        candidates = torch.from_numpy(window).repeat(len(self._setpoints), 1, 1)
        candidates[:, -1, -1] = self._setpoints
        scores = self._scores(self._learner.network, candidates, self._scaler, self._target_degc)
        return choices.nearest_of_the_best(scores, choices.SETPOINTS_DEGC, last_degc)


def _mean_degc(scaled, scaler):
    return scaler.room_degc(scaled.numpy().astype(np.float64)).mean(axis=1)


def _method_scores(network, candidates, scaler, target_degc):
    short, difference, _ = network(candidates[:, -1])
    now = _mean_degc(candidates[:1, -1, :network.rooms], scaler)[0]
    return choices.long_term_scores(now, _mean_degc(short + difference, scaler), target_degc)


def _osln_scores(network, candidates, scaler, target_degc):
    return -np.abs(_mean_degc(network.short_term(candidates[:, -1])[0], scaler) - target_degc)


def _series_scores(network, candidates, scaler, target_degc):
    return -np.abs(_mean_degc(network(candidates), scaler) - target_degc)


def with_synthetic(transitions, layout, scaler, seed):
    """OSLN: copies of the schedule's transitions under other setpoints, which move the rooms by a simple rule."""
    rng = np.random.default_rng(seed)
    windows, after = [transitions.windows], [transitions.after]
    for change_k in SYNTHETIC_K:
        gains = rng.uniform(*SYNTHETIC_GAIN, size=(len(transitions), 1))
        moved, reached = transitions.windows.copy(), transitions.after.copy()
        moved[:, -1, -1] += change_k / scaler.scale[-1]
        reached[:, :layout.rooms] += gains * change_k / scaler.scale[0]
        windows.append(moved)
        after.append(reached)
    return Transitions(np.concatenate(windows), np.concatenate(after))


def agent_of(method, layout, scaler, target_degc, seed):
    torch.manual_seed(seed)
    if method == "ddqn":
        return QAgent(layout, scaler, target_degc, seed)
    if method == "ed":
        loss = functools.partial(losses.method_loss, labels=torch.from_numpy(layout.labels))
        return ForecastAgent(EdNetwork(layout), loss, scaler, target_degc, _method_scores)
    if method == "osln":
        augment = functools.partial(with_synthetic, layout=layout, scaler=scaler, seed=seed)
        return ForecastAgent(EdNetwork(layout), losses.plain_loss, scaler, target_degc, _osln_scores, augment=augment)
    kind, length, depth = series_of(method)
    network = LstmNetwork(layout, depth) if kind == "lstm" else TransformerNetwork(layout, length, depth)
    return ForecastAgent(network, losses.series_loss, scaler, target_degc, _series_scores, cycles=length)
