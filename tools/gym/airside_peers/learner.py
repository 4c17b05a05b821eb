"""Replay and optimiser (docs/method.md 5)."""

import copy

import torch

CAPACITY, BATCH, LEARNING_RATE, SYNC_STEPS = 42 * 240, 1000, 1e-3, 100


class Replay:
    """First in, first out."""

    def __init__(self, first, capacity=CAPACITY):
        """first: Transitions to begin with, which also say how large one is."""
        self._windows = torch.empty((capacity, *first.windows.shape[1:]))
        self._after = torch.empty((capacity, *first.after.shape[1:]))
        self.size, self._next = 0, 0
        self.add(torch.from_numpy(first.windows), torch.from_numpy(first.after))

    def add(self, windows, after):
        for window, reached in zip(windows[-len(self._after):], after[-len(self._after):]):
            self._windows[self._next], self._after[self._next] = window, reached
            self._next = (self._next + 1) % len(self._after)
            self.size = min(self.size + 1, len(self._after))

    def draw(self, most=BATCH):
        """A batch without replacement."""
        places = torch.randperm(self.size)[:most]
        return self._windows[places], self._after[places]


class Learner:
    """Adam on a network; its target network is a copy, copied again after every 100 steps."""

    def __init__(self, network, loss, parameters=None):
        """loss: of (network, target, windows, after). parameters: those to train, all by default."""
        self.network, self.loss, self.steps = network, loss, 0
        self.target = copy.deepcopy(network).requires_grad_(False)
        self._optimiser = torch.optim.Adam(parameters or network.parameters(), LEARNING_RATE, fused=True)

    def step(self, windows, after):
        loss = self.loss(self.network, self.target, windows, after)
        self._optimiser.zero_grad()
        loss.backward()
        self._optimiser.step()
        self.steps += 1
        if self.steps % SYNC_STEPS == 0:
            self.target.load_state_dict(self.network.state_dict())

    def train(self, replay, steps, show=lambda done: None, batch=BATCH):
        for done in range(steps):
            self.step(*replay.draw(batch))
            if done % 20 == 19:
                show(done + 1)

    def surprise(self, windows, after):
        """Loss of transitions that were not trained on yet."""
        return float(self.loss(self.network, self.target, windows, after).detach())
