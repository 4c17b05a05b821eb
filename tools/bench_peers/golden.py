"""The network, the batch and the known results of tests/golden/data, as NumPy arrays."""

import json
from pathlib import Path

import numpy as np

DATA = Path(__file__).resolve().parents[2] / "tests/golden/data"
META = json.loads((DATA / "meta.json").read_text(encoding="utf-8"))
LAYERS = [tuple(layer[:3]) for layer in META["layers"]]  # name, outputs, inputs
LABELS = np.array(META["labels"])
ROOMS, SIGNALS, INPUTS = 5, 25, 26


class Stream:
    """splitmix64."""

    def __init__(self, seed):
        self.state = seed

    def unit(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) % 2**64
        z = self.state
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
        z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
        return ((z ^ z >> 31) >> 11) * 2.0**-53

    def both(self):
        return 2 * self.unit() - 1


def weights(name):
    """[(W, b)] of the golden net `name` in the order of LAYERS."""
    stream, out = Stream(META["seeds"][name]), []
    for _, outputs, inputs in LAYERS:
        w = [stream.both() * (6 / inputs) ** 0.5 for _ in range(outputs * inputs)]
        b = [stream.both() * inputs**-0.5 for _ in range(outputs)]
        out.append((np.array(w).reshape(outputs, inputs), np.array(b)))
    return out


def batch(count):
    """`count` rows of (S, E, A, S after, E after): 51 columns."""
    stream, status, rows = Stream(META["seeds"][f"batch{count}"]), META["is_status"], []
    for _ in range(count):
        row = [float(stream.unit() >= 0.5) if status[j] else stream.both() * 3**0.5 for j in range(INPUTS)]
        after = [row[j] + 0.3 * stream.both() for j in range(ROOMS)]
        for j in range(ROOMS, SIGNALS):
            change = stream.unit() < 0.1 if status[j] else 0.2 * stream.both()
            after.append((1 - row[j] if change else row[j]) if status[j] else row[j] + change)
        rows.append(row + after)
    return np.array(rows)


def forecasts_of_32():
    """(S', D', reconstruction) of the 32 golden rows."""
    rows = np.array(json.loads((DATA / "forward_32.json").read_text(encoding="utf-8"))["rows"])
    return rows[:, :5], rows[:, 5:10], rows[:, 10:15]


def gradient_of_32():
    return np.loadtxt(DATA / "grad_total_32.csv")


def flat(layers):
    return np.concatenate([np.concatenate([np.ravel(w), np.ravel(b)]) for w, b in layers])
