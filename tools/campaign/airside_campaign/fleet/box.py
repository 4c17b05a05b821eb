"""One box, however it is reached: its status, weights for it, and the way back. The programs do the work."""

import http.client
import json
import os
import re
import ssl
import stat
import subprocess
import time
import tomllib
import urllib.error
import urllib.request
from dataclasses import dataclass
from pathlib import Path

OLD_AFTER_S = 900  # a box writes its status every 6 min
LONGEST_STATUS = 1 << 20
COMMAND_LIMIT_S = 120
LATER = re.compile(r"found (409|429|503)\b|other weights that wait")  # a blob waits there, or the page is busy


class NoAnswer(Exception):
    """Nobody knows what the box does, or whether something has arrived."""


class Refused(Exception):
    """Weights or wish were not taken; nothing was left at the box."""


class Later(Refused):
    """The same, and it may be different in a while."""


@dataclass(frozen=True)
class Seen:
    """What a box says of itself."""

    time: str  # of its last row, by its own clock
    topology: str
    state: str  # control mode
    condition: str  # running, stopped, stale, alarm
    alarms: list
    crc: str  # of the weights that were pushed last
    weights: str  # none, on trial, confirmed, rolled back
    refusal: str  # of the last blob; empty: none
    release_ends: str = ""


def seen_in(text, age_s):
    """`age_s`: since it was written; None: the text has condition itself. Raises NoAnswer."""
    try:
        status = json.loads(text)
        alarms = [alarm["reason"] for alarm in status.get("alarms", [])]
        condition = status.get("condition")
        if age_s is not None:
            old = abs(age_s) > OLD_AFTER_S
            condition = "stopped" if status.get("stopped") else "stale" if old else "alarm" if alarms else "running"
        refusal, field = status["pushed_refusal"], status["pushed_refusal_field"]
        return Seen(
            time=status["time"],
            topology=status["topology"],
            state=status["state"],
            condition=str(condition),
            alarms=alarms,
            crc=status["pushed_crc"],
            weights=status["pushed_weights"],
            refusal="" if refusal == "none" else f"{refusal} ({field})",
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise NoAnswer(f"no status of airsided: {type(error).__name__} {error}") from error


def in_words(error):
    """What the system says of an error, without its number and the path."""
    is_of_system = isinstance(error, OSError) and not isinstance(error, ssl.SSLError)
    return error.strerror.lower() if is_of_system and error.strerror else str(error)


def unfit(seen, crc):
    """Why nothing is to be sent to a box now; empty: it may be."""
    if seen.condition == "stopped":
        return "airsided has stopped"
    if seen.condition == "stale":
        return f"its status is old, of {seen.time}"
    if seen.state == "release":
        return "it is released"
    if seen.condition == "alarm" or seen.alarms:
        return "alarm: " + ", ".join(seen.alarms)
    if seen.weights == "on trial" and seen.crc != crc:
        return f"other weights ({seen.crc}) are on trial"
    return ""


def ran(words, limit_s=COMMAND_LIMIT_S):
    """Standard output, exit code and what it complained of. Raises NoAnswer."""
    try:
        done = subprocess.run(
            words,
            capture_output=True,
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
            timeout=limit_s,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise NoAnswer(f"{words[0]} took more than {limit_s} s") from error
    except OSError as error:
        raise NoAnswer(f"{words[0]}: {error.strerror.lower()}") from error
    lines = done.stderr.strip().splitlines()
    return done.stdout, done.returncode, lines[-1][:300] if lines else f"exit code {done.returncode}"


def airside(program, *words):
    """Runs a command that either does something or complains. Raises Refused, NoAnswer."""
    _, code, said = ran([str(program), *words])
    if code == 0:
        return
    if "found no answer" in said or code < 0:
        raise NoAnswer(said)
    raise Later(said) if LATER.search(said) else Refused(said)


class SiteBox:
    """By its site file, on this machine or on a disk that it sees."""

    def __init__(self, box, program):
        self.program, self.site = program, Path(box.ways["site"])

    def seen(self):
        path = None
        try:
            site = tomllib.loads(self.site.read_text(encoding="utf-8"))
            path = self.site.parent / site.get("state", {}).get("dir", "state") / "status.json"
            with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
                facts = os.fstat(file.fileno())
                if not stat.S_ISREG(facts.st_mode):
                    raise NoAnswer(f"{path} is no regular file")
                text = file.read(LONGEST_STATUS)
        except FileNotFoundError as error:
            if path is None:
                raise NoAnswer(f"no site file {self.site}") from error
            raise NoAnswer(f"airsided has not run with this site yet (no {path})") from error
        except (OSError, ValueError, AttributeError, TypeError) as error:
            raise NoAnswer(f"{path or self.site}: {in_words(error)}") from error
        return seen_in(text, time.time() - facts.st_mtime)

    def push(self, blob):
        airside(self.program, "push", str(blob), str(self.site))

    def roll_back(self):
        airside(self.program, "rollback", str(self.site))


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_):
        return None  # a key goes to the box that the file names and nowhere else


class PageBox:
    """By its airside-page: HTTPS, with a key of the role installer."""

    def __init__(self, box, program):
        self.program, self.address = program, box.ways["page"].rstrip("/")
        self.ca, self.access = box.ways.get("ca"), box.ways.get("access")

    def ask(self, path, data=None):
        try:
            headers = {}
            if self.access:
                headers["Authorization"] = "Bearer " + Path(self.access).read_text(encoding="ascii").strip()
            elif data is not None:
                headers["X-Airside-Token"] = self.ask("/token")[0].decode("ascii", "replace").strip()
            handlers = [urllib.request.ProxyHandler({}), _NoRedirect()]
            if self.address.startswith("https"):
                handlers.append(urllib.request.HTTPSHandler(context=ssl.create_default_context(cafile=self.ca)))
            request = urllib.request.Request(self.address + path, data=data, headers=headers)
            with urllib.request.build_opener(*handlers).open(request, timeout=20) as answer:
                return answer.read(LONGEST_STATUS), answer.headers
        except urllib.error.HTTPError as error:
            raise Refused(f"{self.address}{path}: {error.code} {error.reason}") from error
        except (OSError, ValueError, http.client.HTTPException) as error:
            raise NoAnswer(f"{self.address}: {in_words(getattr(error, 'reason', error))}") from error

    def seen(self):
        try:
            text, headers = self.ask("/status.json")
        except Refused as error:
            raise NoAnswer(str(error)) from error
        try:
            return seen_in(text, float(headers.get("Age", 0)))
        except ValueError as error:
            raise NoAnswer(f"{self.address}: an age that is no number") from error

    def push(self, blob):
        words = ["--ca", self.ca] if self.ca else []
        words += ["--access", self.access] if self.access else []
        airside(self.program, "push", str(blob), self.address, *words)

    def roll_back(self):
        self.ask("/rollback", b"")


class CommandBox:
    """By commands that the fleet file names, such as ssh. One that fails may have done its work."""

    def __init__(self, box, program):
        self.ways = box.ways

    def seen(self):
        text, _, said = ran(self.ways["status"])
        if not text.strip():
            raise NoAnswer(said)
        return seen_in(text, None)

    def run(self, words):
        _, code, said = ran(words)
        if code != 0:
            raise NoAnswer(said)

    def push(self, blob):
        self.run([word.replace("{blob}", str(blob)) for word in self.ways["push"]])

    def roll_back(self):
        if "rollback" not in self.ways:
            raise Refused("its group has no command rollback")
        self.run(self.ways["rollback"])


def reach(box, program):
    kind = SiteBox if "site" in box.ways else PageBox if "page" in box.ways else CommandBox
    return kind(box, program)
