"""DAE, ME, DARV, CDH and HDH of an episode, as docs/method.md section 9 and `airside simulate` count them."""

import statistics

HOURS_OF_A_CYCLE = 0.3

def _darv(setpoints):
    """Unrest of the setpoint in one day's working hours, degC."""
    turns = [abs(c - 2 * b + a) for a, b, c in zip(setpoints, setpoints[1:], setpoints[2:])]
    return sum(turns) / (len(turns) - 1) if len(turns) > 1 else 0.0


class Scores:
    """Give it the info before each step and the info after it."""

    def __init__(self, target_degc):
        self._target_degc, self._days = target_degc, {}
        self._above_degch = self._below_degch = 0.0

    def add(self, before, after):
        if before["scored"]:
            errors, setpoints = self._days.setdefault(before["time"][:10], ([], []))
            errors.append(abs(before["room_mean_degc"] - self._target_degc))
            setpoints.append(after["setpoint_degc"])
            gap_k = before["room_mean_degc"] - after["setpoint_degc"]
            self._above_degch += max(gap_k, 0.0) * HOURS_OF_A_CYCLE
            self._below_degch += max(-gap_k, 0.0) * HOURS_OF_A_CYCLE

    def daily_dae_degc(self):
        return [statistics.fmean(errors) for errors, _ in self._days.values()]

    def figures(self):
        """{dae_degc, me_degc, darv_degc, cdh_degch, hdh_degch}; without a scored sample StatisticsError."""
        daily = self.daily_dae_degc()
        return {"dae_degc": statistics.fmean(daily), "me_degc": max(daily),
                "darv_degc": statistics.fmean(_darv(setpoints) for _, setpoints in self._days.values()),
                "cdh_degch": self._above_degch, "hdh_degch": self._below_degch}
