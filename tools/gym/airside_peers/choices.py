"""From forecasts to a setpoint (docs/method.md 6)."""

import math

import numpy as np

from .transitions import SETPOINT_RANGE_DEGC

SETPOINTS_DEGC = np.round(np.arange(SETPOINT_RANGE_DEGC[0], SETPOINT_RANGE_DEGC[1] + 0.05, 0.1), 1)
TIE_DEGC = 1e-6
SCORE_ALPHA, SCORE_BETA = 1.0, 0.9
WORK_H, EXPERT_WORK_DEGC, EXPERT_OFF_DEGC = (7, 19), 20.5, 25.0
SMOOTHING, SCALE, INITIAL = 0.2, 1.0, 0.5


def nearest_of_the_best(scores, setpoints, last_degc):
    """The best setpoint; of equals the one nearest to the last, then the lower."""
    best = setpoints[scores >= scores.max() - TIE_DEGC]
    return float(best[np.argmin(np.abs(best - last_degc))])


def long_term_scores(now_degc, long_degc, target_degc):
    """Source: docs/method.md 6.1."""
    return (abs(now_degc - target_degc) - SCORE_ALPHA * np.abs(long_degc - target_degc)
            - SCORE_BETA * np.abs(long_degc - now_degc))


def expert_degc(hour):
    return EXPERT_WORK_DEGC if WORK_H[0] <= hour < WORK_H[1] else EXPERT_OFF_DEGC


class Confidence:
    def __init__(self):
        self.value = INITIAL

    def update(self, loss):
        trust = math.exp(-loss / SCALE) if math.isfinite(loss) else 0.0
        self.value = SMOOTHING * trust + (1 - SMOOTHING) * self.value

    def blended(self, network_degc, schedule_degc):
        blend = self.value * network_degc + (1 - self.value) * schedule_degc
        return round(min(max(blend, SETPOINT_RANGE_DEGC[0]), SETPOINT_RANGE_DEGC[1]), 2)
