"""Runs the jobs of a campaign: those that are there are left out, those that need others wait for them."""

import fcntl
import itertools
import math
import os
import secrets
import shutil
import socket
import time
from collections import deque
from pathlib import Path

from airside_campaign import one_job, uses
from airside_campaign.complaint import BadInput
from airside_campaign.progress import Progress

SENT = (one_job, uses)  # go by value, so that no machine needs this package


class Folder:
    """The campaign's folder: jobs/KEY for what is done, logs/KEY.txt for what was said meanwhile, failed/KEY for
    what was not done; one campaign at a time."""

    def __init__(self, path):
        self.path = Path(path)
        try:
            if self.path.exists() and not made_by_a_campaign(self.path):
                raise BadInput(
                    path,
                    "files that no campaign made",
                    "a new or empty folder, or one that a campaign made",
                    "give another in campaign.out",
                )
            (self.path / "jobs").mkdir(parents=True, exist_ok=True)
            self._lock = open(self.path / ".lock", "a", encoding="utf-8")  # held until this process ends
        except OSError as error:
            raise BadInput(
                error.filename or path,
                error.strerror.lower(),
                "a folder that can be written",
                "correct campaign.out, or the folder's rights",
            ) from error
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise BadInput(
                path, "a campaign that runs in it", "a folder of its own", "wait for it, or choose another"
            ) from error
        self.token = secrets.token_hex(16)  # other machines find it in the lock, or have another folder of that name
        try:
            self._lock.truncate(0)
            self._lock.write(self.token)
            self._lock.flush()
            os.fsync(self._lock.fileno())
        except OSError as error:
            raise BadInput(path, error.strerror.lower(), "room for a lock file", "make room") from error
        self.clear()

    def clear(self):
        """Takes away what killed runs and lost machines left unfinished."""
        for part in (self.path / "jobs").glob(".*.part"):
            shutil.rmtree(part, ignore_errors=True)

    def spec(self, job, program, used):
        return {
            "name": job.name,
            "key": job.key,
            "command": job.command,
            "program": str(program),
            "uses": used,
            "reads": job.reads,
            "out": str(self.path.resolve()),
            "token": self.token,
            "folder": str((self.path / "jobs" / job.key).resolve()),
            "failed": str((self.path / "failed").resolve()),
            "logs": str((self.path / "logs").resolve()),
            "timeout_min": job.timeout_min,
        }


def made_by_a_campaign(path):
    """Or empty. Who killed a campaign early has left no more than the lock and no job."""
    names = {entry.name for entry in path.iterdir()} - {"lost+found"}
    return names <= {".lock", "jobs"} or {".lock", "jobs"} <= names or any(path.glob("jobs/*/job.json"))


class Serial:
    """In this process, one after the other: for a machine without Ray, and to compare with."""

    slots = 1

    def __init__(self):
        self._waiting = deque()

    def largest(self):
        return math.inf, ""  # it has this machine to itself

    def can_take(self):
        return not self._waiting

    def submit(self, spec, cpus):
        self._waiting.append(spec)

    def next(self):
        spec = self._waiting.popleft()
        return spec["key"], one_job.run_one(spec)

    def close(self):
        pass


def answers(address):
    """Raises BadInput unless something listens at HOST:PORT."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise BadInput("--address", repr(address), "HOST:PORT of a Ray cluster", "such as 10.0.0.5:6379")
    try:
        socket.create_connection((host, int(port)), timeout=10).close()
    except OSError as error:
        raise BadInput(
            "--address",
            f"no cluster at {address} ({error.strerror or error})",
            "a running Ray cluster",
            "start one by `ray start --head --port 6379`, or leave --address out",
        ) from error


class Quiet:
    """Standard output and error of this process go into a file meanwhile: Ray writes what its own processes said there."""

    def __init__(self, path):
        self._kept = [os.dup(1), os.dup(2)]
        log = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o644)
        for number in (1, 2):
            os.dup2(log, number)
        os.close(log)

    def end(self):
        for number, kept in zip((1, 2), self._kept, strict=True):
            os.dup2(kept, number)
            os.close(kept)


class OnRay:
    """On the cluster at `address`, or on this machine's own with `slots` processes. Ray repeats what a lost machine or a
    killed process did not finish; what it says of itself is in `log`."""

    def __init__(self, address, slots, retries, log):
        try:
            import ray
        except ImportError as error:
            remedy = "pip install ray, or give --serial"
            raise BadInput("Ray", str(error).lower(), "the Python package ray", remedy) from error
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        if address:
            answers(address)  # Ray itself ends the process where nothing answers
        self._ray = ray
        self._quiet = Quiet(log)
        try:
            if address:
                ray.init(address=address, logging_level="ERROR", log_to_driver=False)
            else:
                ray.init(  # "local": else it joins a cluster that $RAY_ADDRESS names, or that runs here
                    address="local",
                    num_cpus=slots,
                    include_dashboard=False,
                    logging_level="ERROR",
                    log_to_driver=False,
                )
        except Exception as error:  # whatever Ray raises, nothing has been run
            self._quiet.end()
            raise BadInput(
                "--address",
                f"no cluster at {address or 'this machine'} ({type(error).__name__}: see {log})",
                "a running Ray cluster",
                "start one by `ray start --head`, or leave --address out" if address else "give --serial",
            ) from error
        for module in SENT:
            ray.cloudpickle.register_pickle_by_value(module)
        self._address = address
        self._run = ray.remote(max_retries=retries)(one_job.run_one)
        self._refs = {}
        self._finished = deque()

    @property
    def slots(self):
        return max(1, int(self._ray.cluster_resources().get("CPU", 1)))

    def largest(self):
        """Processors of the largest machine, and how to have more."""
        have = (n["Resources"].get("CPU", 0) for n in self._ray.nodes() if n["Alive"])
        return max(have, default=0), "start a larger machine" if self._address else "raise --jobs"

    def can_take(self):
        return len(self._refs) < 2 * self.slots + 2  # a few more than are at work, so that nobody waits for the next

    def submit(self, spec, cpus):
        self._refs[self._run.options(num_cpus=cpus).remote(spec)] = spec

    def next(self):
        while not self._finished:
            ready, _ = self._ray.wait(list(self._refs), num_returns=min(8, len(self._refs)), timeout=0.05)
            if not ready:
                ready, _ = self._ray.wait(list(self._refs), num_returns=1, timeout=None)
            self._finished.extend(ready)
        ref = self._finished.popleft()
        spec = self._refs.pop(ref)
        try:
            return spec["key"], self._ray.get(ref)
        except self._ray.exceptions.RayError as error:
            why = f"lost again and again ({type(error).__name__}); see `ray status` for the machines"
            return spec["key"], {"key": spec["key"], "done": False, "why": why}

    def close(self):
        self._ray.shutdown()
        self._quiet.end()


def check_cpus(campaign, executor):
    """Raises BadInput for a job that would wait for ever, since no machine is large enough."""
    most, remedy = executor.largest()
    for job in campaign.jobs:
        if job.cpus > most:
            place = f"{campaign.path}: job {job.entry + 1}: cpus"
            expected = f"at most {most:g}, as the largest machine has"
            raise BadInput(place, f"{job.cpus:g}", expected, f"lower it, or {remedy}")


def seen_from_here(spec, record):
    """The record of a job, done only if its folder is found here too. A network file system may take a while."""
    for wait_s in (0, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4):
        time.sleep(wait_s)
        if not record["done"] or one_job.is_done(spec["folder"]):
            return record
        os.listdir(os.path.dirname(spec["folder"]))  # so that it asks its server again
    why = f"{record.get('host', 'its machine')} does not see {spec['out']}: what it wrote is not there"
    return record | {"done": False, "why": why}


def run_jobs(campaign, folder, program, used, executor, stream):
    """Runs what is missing. Returns a record for each job, by name: a job whose need failed is not run."""
    progress = Progress(campaign.jobs, stream)
    records, by_key, blocked_by, needed_by = {}, {}, {}, {}
    ready = deque()
    for job in campaign.jobs:
        by_key.setdefault(job.key, []).append(job)
        needs = set(itertools.chain.from_iterable(job.after.values()))
        for other in needs:
            needed_by.setdefault(other, []).append(job)
        blocked_by[job.name] = len(needs)
        if not needs:
            ready.append(job)
    at_work = {}  # key -> what it was sent with

    def finish(job, record):
        """And what waited for it."""
        todo = [(job, record)]
        while todo:
            job, record = todo.pop()
            if job.name in records:
                continue
            records[job.name] = record
            progress.one(job, record, executor.slots)
            for later in needed_by.get(job.name, ()):
                if not record["done"]:
                    todo.append(
                        (later, {"key": later.key, "done": False, "why": f"{job.name}, which it needs, failed"})
                    )
                    continue
                blocked_by[later.name] -= 1
                if blocked_by[later.name] == 0 and later.name not in records:
                    ready.append(later)

    while ready or at_work:
        while ready and executor.can_take():
            job = ready.popleft()
            if job.name in records or job.key in at_work:
                continue  # two names for the same work are run once
            spec = folder.spec(job, program, used)
            if one_job.is_done(spec["folder"]):
                finish(job, {"key": job.key, "done": True, "kept": True})
                continue
            at_work[job.key] = spec
            executor.submit(spec, job.cpus)
        if at_work:
            key, record = executor.next()
            record = seen_from_here(at_work.pop(key), record)
            for job in by_key[key]:
                if job.name not in records and blocked_by[job.name] == 0:
                    finish(job, record)
    return records
