"""How far a run of several unequal parts is, and how long it will still take."""

import sys
import time


class Progress:
    """A line each ten seconds, or one live line on a terminal."""

    def __init__(self, what, total):
        self.what, self.total, self.begun, self.told = what, total, time.monotonic(), 0.0

    def show(self, done):
        now = time.monotonic()
        live = sys.stderr.isatty()
        if done < self.total and now - self.told < (0.5 if live else 10):
            return
        self.told = now
        left = (now - self.begun) * (self.total - done) / max(done, 1e-9)
        line = f"{self.what}: {100 * done / self.total:.0f} %, {left:.0f} s left"
        if done >= self.total:
            line = f"{self.what}: done in {now - self.begun:.0f} s"
        print(f"\r{line:<70}" if live else line, end="\n" if not live or done >= self.total else "", file=sys.stderr,
              flush=True)
