"""A line that says how far it is and how long it will take."""

import sys
import time


def clock(seconds):
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"


class Progress:
    """Time left is what the waiting jobs take at the mean of their own entry so far, over the slots at work."""

    def __init__(self, jobs, stream=sys.stderr):
        self.stream, self.total = stream, len(jobs)
        self.waiting, self.seconds, self.counts = {}, {}, {}
        for job in jobs:
            self.waiting[job.entry] = self.waiting.get(job.entry, 0) + 1
        self.done = self.failed = 0
        self.began = time.monotonic()
        self.live = stream.isatty()
        self.said = 0.0

    def one(self, job, record, slots):
        self.waiting[job.entry] -= 1
        self.done += 1
        if not record["done"]:
            self.failed += 1
        if "seconds" in record:
            self.seconds[job.entry] = self.seconds.get(job.entry, 0) + record["seconds"]
            self.counts[job.entry] = self.counts.get(job.entry, 0) + 1
        now = time.monotonic()
        if now - self.said > (0.2 if self.live else 10) or self.done == self.total:
            self.said = now
            self.show(now, slots)

    def left(self, slots):
        if not self.counts:
            return None
        mean = sum(self.seconds.values()) / sum(self.counts.values())
        work = sum(
            n * (self.seconds[e] / self.counts[e] if e in self.counts else mean) for e, n in self.waiting.items()
        )
        return work / max(1, slots)

    def show(self, now, slots):
        bar = "#" * (24 * self.done // max(1, self.total))
        left = self.left(slots)
        text = f"  [{bar:<24}] {self.done} of {self.total}, {clock(now - self.began)} gone"
        text += f", about {clock(left)} left" if left is not None and self.done < self.total else ""
        text += f", {self.failed} failed" if self.failed else ""
        self.stream.write(f"\r\x1b[K{text}" if self.live else text + "\n")
        if self.live and self.done == self.total:
            self.stream.write("\n")
        self.stream.flush()
