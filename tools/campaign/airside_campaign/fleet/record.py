"""What a push has done: one state file, replaced whole, and a ledger to which lines are only added."""

import datetime
import fcntl
import getpass
import json
import os
import socket
import tempfile
from contextlib import contextmanager
from pathlib import Path

from airside_campaign.complaint import BadInput

FORMAT = 1
WAITING = ("sending", "sent", "on trial")  # phases that still end


def now_text():
    return datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def person():
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return str(os.getuid())


class Record:
    """`out`: folder of all pushes of a fleet. State is that of one push, by the digest of its weights."""

    def __init__(self, out, by=None):
        self.out, self.by = Path(out), by or person()
        self.state, self.path = None, None

    @contextmanager
    def alone(self):
        """One push of a fleet at a time. Raises BadInput."""
        try:
            self.out.mkdir(parents=True, exist_ok=True)
            lock = os.open(self.out / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise BadInput(
                self.out, error.strerror.lower(), "a folder that can be written", "check its rights"
            ) from error
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield
        except BlockingIOError as error:
            raise BadInput(
                self.out, "another airside fleet at work", "one at a time", "wait until it has ended"
            ) from error
        finally:
            os.close(lock)

    def open(self, weights, create=True):
        """Reads the state of a push, or begins one."""
        self.path = self.out / f"{weights.digest[:16]}.json"
        if self.path.exists():
            self.state = read_state(self.path)
        elif create:
            self.state = {
                "kind": "airside fleet push",
                "format": FORMAT,
                "digest": weights.digest,
                "crc": weights.crc,
                "key": weights.key,
                "provenance": weights.provenance,
                "begun": now_text(),
                "boxes": {},
            }

    def save(self):
        text = json.dumps(self.state, indent=1, ensure_ascii=False) + "\n"
        try:
            with tempfile.NamedTemporaryFile(
                "w", dir=self.out, prefix=".state.", delete=False, encoding="utf-8"
            ) as staged:
                staged.write(text)
                staged.flush()
                os.fsync(staged.fileno())
            os.chmod(staged.name, 0o644)
            os.replace(staged.name, self.path)
            folder = os.open(self.out, os.O_RDONLY)
            os.fsync(folder)
            os.close(folder)
        except OSError as error:
            raise BadInput(
                self.path, error.strerror.lower(), "room for the state", "make room; run it again"
            ) from error

    def note(self, *events):
        """Adds lines to the ledger, each {at, by, host, weights} and what is given."""
        head = {"at": now_text(), "by": self.by, "host": socket.gethostname(), "weights": self.state["digest"]}
        text = "".join(json.dumps(head | event, ensure_ascii=False) + "\n" for event in events)
        ledger = self.out / "ledger.jsonl"
        try:
            line = os.open(ledger, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644)
            try:
                os.write(line, text.encode())
                os.fsync(line)
            finally:
                os.close(line)
        except OSError as error:
            raise BadInput(ledger, error.strerror.lower(), "room for the ledger", "make room; run it again") from error

    def set(self, changes, events):
        """`changes`: box -> what is new of it, None: nothing was sent to it. On the disk before it returns."""
        for box, change in changes.items():
            if change is None:
                self.state["boxes"].pop(box, None)
            else:
                self.state["boxes"].setdefault(box, {}).update(change)
        self.save()
        if events:
            self.note(*events)


def read_state(path):
    try:
        state = json.loads(path.read_text(encoding="utf-8"))
        if state["format"] == FORMAT and state["kind"] == "airside fleet push":
            return state
    except (OSError, ValueError, KeyError, TypeError):
        pass
    raise BadInput(path, "something else", "the state of a push", "restore it; the ledger beside it says what was done")


def read_states(out):
    """All pushes of a fleet, oldest first."""
    return sorted((read_state(p) for p in Path(out).glob("*.json")), key=lambda state: state["begun"])
