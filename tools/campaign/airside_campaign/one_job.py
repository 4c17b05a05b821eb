"""One run of the program in a folder of its own, whole or not at all. Runs on whichever machine Ray chooses; imports no
more of this package than goes with it, so that a machine needs Python, Ray and the airside program alone."""

import ctypes
import json
import os
import shutil
import signal
import socket
import subprocess
import time

from airside_campaign.uses import digest_of, used_by  # goes with this module to each machine

NO_CAUSE = "Run with --help for more information."  # stands below the cause in every complaint of a command line


def dies_with_its_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)


def is_done(folder):
    """Whether a job is there as it was left: its record, each file with its size. Records of before have no sizes."""
    try:
        with open(os.path.join(folder, "job.json"), encoding="utf-8") as record:
            sizes = json.load(record).get("sizes", {})
        return all(os.path.getsize(os.path.join(folder, name)) == size for name, size in sizes.items())
    except (OSError, ValueError, AttributeError):
        return False


def run_one(spec):
    """Runs spec["command"] unless spec["folder"] is there; returns what is known of it: done or not, seconds, host,
    what was said. A folder appears by one rename, so that of two machines with one job only the first leaves it."""
    host = socket.gethostname()
    if not _sees(spec):
        why = f"{host} does not see {spec['out']}; it takes the same folder at the same path there"
        return _failed(spec, host, why)
    final = spec["folder"]
    if is_done(final):
        return {"key": spec["key"], "done": True, "kept": True, "host": host}
    parent, name = os.path.split(final)
    part = os.path.join(parent, f".{name}.{host}.{os.getpid()}.part")
    try:
        why = _differs(spec, host) or _changed(spec, host)
        if why:
            return _failed(spec, host, why)
        shutil.rmtree(part, ignore_errors=True)
        _set_aside(final)
        os.mkdir(part)  # and no folder above it: it would be one of this machine alone
        began = time.monotonic()
        why = _run(spec, part) or _changed(spec, host)
        if why:
            return _moved(spec, part, host, why)
        seconds = time.monotonic() - began
        _make(spec["logs"])  # apart: it has times in it, and the folder shall be the same anywhere
        os.replace(os.path.join(part, "stderr"), os.path.join(spec["logs"], spec["key"] + ".txt"))
        _write_record(spec, part, _on_disk(part))
        try:
            os.rename(part, final)
        except OSError:
            if not is_done(final):
                raise
            shutil.rmtree(part, ignore_errors=True)  # another machine was first: the same bytes
        sync(parent)
        shutil.rmtree(os.path.join(spec["failed"], spec["key"]), ignore_errors=True)  # what an earlier try left
        return {"key": spec["key"], "done": True, "kept": False, "seconds": seconds, "host": host}
    except OSError as error:
        shutil.rmtree(part, ignore_errors=True)
        return _failed(
            spec, host, f"{error.filename or part}: {error.strerror.lower()}; make room or correct the folder's rights"
        )


def _run(spec, part):
    """Why the program failed; empty: it did not."""
    with open(os.path.join(part, "stdout"), "wb") as out, open(os.path.join(part, "stderr"), "wb") as err:
        child = subprocess.Popen(
            [spec["program"], *spec["command"]],
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
            return f"not done after {spec['timeout_min']:g} min; give it more by timeout_min"
    return _last_words(part, code) if code else ""


def _sees(spec):
    """Whether the campaign's folder is that of the machine which the campaign runs from, not one of the same name."""
    try:
        with open(os.path.join(spec["out"], ".lock"), encoding="utf-8") as lock:
            return lock.read() == spec["token"]
    except (OSError, ValueError):
        return False


def _differs(spec, host):
    """What this machine has not as the machine has it that the campaign runs from."""
    if shutil.which(spec["program"]) is None:
        return f"{host} has no {spec['program']}; install the same airside there"
    here = used_by(spec["program"])
    for name, digest in spec["uses"].items():
        if here.get(name) != digest:
            what = f"another airside at {spec['program']}" if name == "airside" else f"another {name} for airside"
            return f"{host} has {what}; install the same one there"
    return ""


def _changed(spec, host):
    for path, digest in spec["reads"].items():
        try:
            if digest_of(path) != digest:
                return f"{path} changed meanwhile; run again"
        except FileNotFoundError:
            return f"{host} does not see {path}; it takes the same file at the same path there"
    return ""


def _make(folder):
    try:
        os.mkdir(folder)
    except FileExistsError:
        pass


def _set_aside(final):
    """A job that is not whole any more; the campaign takes away what ends in .part."""
    if os.path.isdir(final):
        aside = os.path.join(os.path.dirname(final), f".{os.path.basename(final)}.old.part")
        shutil.rmtree(aside, ignore_errors=True)
        os.rename(final, aside)


def sync(path):
    """A file's content, or the names in a folder, onto the disk: they outlive a power cut."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _on_disk(part):
    """Name -> size of all files, each on the disk: a power cut after the rename finds them whole."""
    sizes = {}
    for folder, _, names in os.walk(part):
        for name in names:
            path = os.path.join(folder, name)
            if os.path.isfile(path) and not os.path.islink(path):
                sync(path)
                sizes[os.path.relpath(path, part)] = os.path.getsize(path)
        sync(folder)
    return sizes


def _write_record(spec, folder, sizes=None):
    record = {"name": spec["name"], "key": spec["key"], "command": spec["command"]}
    record |= {"inputs": spec["reads"]} if spec["reads"] else {}
    record |= {"sizes": sizes} if sizes is not None else {}
    with open(os.path.join(folder, "job.json"), "w", encoding="utf-8") as file:
        json.dump(record, file, sort_keys=True)
        file.flush()
        os.fsync(file.fileno())
    sync(folder)


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
    _make(spec["failed"])
    os.rename(part, apart)
    return _failed(spec, host, why)
