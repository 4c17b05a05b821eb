"""One run of the program in a folder of its own, whole or not at all. Runs on whichever machine Ray chooses; imports
nothing of this package, so that a machine needs Python, Ray and the airside program alone."""

import ctypes
import hashlib
import json
import os
import shutil
import signal
import socket
import subprocess
import time

NO_CAUSE = "Run with --help for more information."  # stands below the cause in every complaint of a command line


def dies_with_its_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)


def run_one(spec):
    """Runs spec["command"] unless spec["folder"] is there; returns what is known of it: done or not, seconds, host, what
    was said. A folder appears by one rename, so that of two machines with one job only the first leaves it."""
    final = spec["folder"]
    if os.path.isfile(os.path.join(final, "job.json")):
        return {"key": spec["key"], "done": True, "kept": True}
    host = socket.gethostname()
    program = shutil.which(spec["program"])
    if program is None:
        return _failed(spec, host, f"{host} has no {spec['program']}; install the same airside there")
    with open(program, "rb") as content:
        digest = hashlib.file_digest(content, "sha256").hexdigest()
    if digest != spec["program_digest"]:
        return _failed(spec, host, f"{host} has another airside at {program}; install the same one there")
    parent, name = os.path.split(final)
    part = os.path.join(parent, f".{name}.{host}.{os.getpid()}.part")
    try:
        shutil.rmtree(part, ignore_errors=True)
        os.makedirs(part)
        began = time.monotonic()
        with open(os.path.join(part, "stdout"), "wb") as out, open(os.path.join(part, "stderr"), "wb") as err:
            child = subprocess.Popen(
                [program, *spec["command"]],
                cwd=part,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                start_new_session=True,
                preexec_fn=dies_with_its_parent,
            )
            try:
                code = child.wait(timeout=60 * spec["timeout_min"])
            except subprocess.TimeoutExpired:
                os.killpg(child.pid, signal.SIGKILL)
                child.wait()
                return _moved(
                    spec, part, host, f"not done after {spec['timeout_min']:g} min; give it more by timeout_min"
                )
        seconds = time.monotonic() - began
        if code != 0:
            return _moved(spec, part, host, _last_words(part, code))
        _write_record(spec, part)
        os.makedirs(spec["logs"], exist_ok=True)  # apart: it has times in it, and the folder shall be the same anywhere
        os.replace(os.path.join(part, "stderr"), os.path.join(spec["logs"], spec["key"] + ".txt"))
        try:
            os.rename(part, final)
        except OSError:
            if not os.path.isfile(os.path.join(final, "job.json")):
                raise
            shutil.rmtree(part, ignore_errors=True)  # another machine was first: the same bytes
        shutil.rmtree(os.path.join(spec["failed"], spec["key"]), ignore_errors=True)  # what an earlier try left
        return {"key": spec["key"], "done": True, "kept": False, "seconds": seconds, "host": host}
    except OSError as error:
        shutil.rmtree(part, ignore_errors=True)
        return _failed(
            spec, host, f"{error.filename or part}: {error.strerror.lower()}; make room or correct the folder's rights"
        )


def _write_record(spec, folder):
    with open(os.path.join(folder, "job.json"), "w", encoding="utf-8") as record:
        json.dump({"name": spec["name"], "key": spec["key"], "command": spec["command"]}, record, sort_keys=True)
        record.flush()
        os.fsync(record.fileno())


def _last_words(part, code):
    with open(os.path.join(part, "stderr"), "rb") as said:
        said.seek(0, os.SEEK_END)
        said.seek(max(0, said.tell() - 2000))
        lines = said.read().decode(errors="replace").strip().splitlines()
    if len(lines) > 1 and lines[-1] == NO_CAUSE:
        lines.pop()
    how = f"signal {-code}" if code < 0 else f"exit code {code}"
    return f"{how}: {lines[-1] if lines else 'without a word'}"


def _failed(spec, host, why):
    return {"key": spec["key"], "done": False, "why": why, "host": host}


def _moved(spec, part, host, why):
    """What it left is kept apart, for whoever wants to know why."""
    try:
        _write_record(spec, part)
    except OSError:
        pass  # no room for it: why the job failed is worth more
    apart = os.path.join(spec["failed"], spec["key"])
    shutil.rmtree(apart, ignore_errors=True)
    os.makedirs(spec["failed"], exist_ok=True)
    os.rename(part, apart)
    return _failed(spec, host, why)
