"""fleet.toml: boxes by name, how each is reached, and the waves of a push. Format: docs/fleet.md."""

import itertools
import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

from airside_campaign.complaint import BadInput, nearest
from airside_campaign.toml_file import read_toml

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
SHAPE = re.compile(r"\d+vav-\d+fcu-\d+power")
WAYS = ("site", "page", "push")
FLEET_KEYS = {"out", "keys", "topology", "cycle_min", "waves", "rolled_back_limit", "no_answer_limit"}
FLEET_KEYS |= {"trial_limit_h", "poll_s", "at_once"}
GROUP_KEYS = {"boxes", "topology", "cycle_min", "site", "page", "ca", "access", "push", "status", "rollback"}
BELONGS = {"ca": "page", "access": "page", "status": "push", "rollback": "push"}
MOST_BOXES = 100_000

SUCH_AS = {
    "out": "fleet-push",
    "keys": "keys",
    "topology": "5vav-5fcu-2power",
    "site": "{box}/site.toml",
    "page": "https://{box}.example.org:8350",
    "ca": "site.pem",
    "access": "installer.key",
}
ONE_WAY = 'write one alone, such as site = "{box}/site.toml"'
PUSH = 'write push = ["scp", "-q", "{blob}", "airside@{box}:/var/lib/airside/inbox/fleet.blob"]'
STATUS = 'write status = ["ssh", "airside@{box}", "airside", "status", "--json"]'

EXAMPLE = """\
# Weights for many boxes, in waves. {box} is a box's name, {blob} the file that is sent. Paths are from this file on.
[fleet]
out = "fleet-push"             # state and ledger
keys = "keys"                  # public keys that the boxes believe: their keys folder, or one .pub file
topology = "5vav-5fcu-2power"  # of all boxes; also in a group, as cycle_min
cycle_min = 18
waves = [0.04, 0.2, 1.0]       # share of each group that has the weights after each wave; the first is the canary
rolled_back_limit = 0.1        # halt when more of a wave roll back or refuse
no_answer_limit = 0.2          # halt when more of a wave give no answer
trial_limit_h = 48             # a trial that is not over by then counts as no answer
poll_s = 300                   # between two looks at the boxes of a wave; they write each 6 min
at_once = 16                   # boxes that are asked or sent to at the same time

[group.tower-a]                # by their pages; the first boxes of a list are the canaries
page = "https://{box}.tower-a.example.org:8350"
ca = "tower-a.pem"             # certificates to trust
access = "installer.key"       # of airside-page --new-key installer
boxes = ["ahu-1", "ahu-2", "ahu-3"]

[group.works]                  # by commands, such as ssh
push = ["scp", "-q", "{blob}", "airside@{box}:/var/lib/airside/inbox/fleet.blob"]
status = ["ssh", "airside@{box}", "airside", "status", "--json"]
rollback = ["ssh", "airside@{box}", "airside", "rollback"]
boxes = ["hall-1", "hall-2"]

[group.bench]                  # by their site files, on this machine or a disk that it sees
site = "/srv/bench/{box}/site.toml"
boxes = ["bench-1"]
"""


@dataclass(frozen=True)
class Box:
    name: str
    group: str
    topology: str
    cycle_min: int
    ways: dict  # keys of the group that say how it is reached, {box} filled in


@dataclass(frozen=True)
class Fleet:
    path: Path
    out: Path
    keys: Path
    boxes: dict  # name -> Box, in the order of the file
    groups: dict  # name -> names of its boxes
    waves: list
    rolled_back_limit: float
    no_answer_limit: float
    trial_limit_s: float
    poll_s: float
    at_once: int

    def target(self, wave, group):
        """How many boxes of a group have the weights after a wave: at least one."""
        return math.ceil(self.waves[wave] * len(self.groups[group]) - 1e-9)


def read_fleet(path):
    """Raises BadInput with the file and the key."""
    path = Path(path)
    content = read_toml(path, "a fleet file", "airside fleet push --example prints one")
    return _Reader(path, content).fleet()


class _Reader:
    def __init__(self, path, content):
        self.path, self.content, self.folder = path, content, path.resolve().parent
        self.reached = {}  # what leads to a box -> its name

    def refuse(self, key, found, expected, remedy):
        raise BadInput(f"{self.path}: {key}", found, expected, remedy)

    def only(self, table, known, where):
        if not isinstance(table, dict):
            self.refuse(where, repr(table), "a table", f"write [{where}], and keys below it")
        for key, value in table.items():
            if key not in known:
                if not where and isinstance(value, dict) and (not value or GROUP_KEYS & set(value)):
                    self.refuse(key, f"[{key}]", "[fleet] and [group.NAME]", f"write [group.{key}]")
                near = nearest(key, sorted(known))
                self.refuse(
                    f"{where}.{key}".lstrip("."),
                    "an unknown key",
                    "one of " + ", ".join(sorted(known)),
                    f"write {near}" if near else "remove it",
                )

    def text(self, table, key, where, default=None):
        value = table.get(key, default)
        if not isinstance(value, str) or not value:
            found = "nothing" if value is None else repr(value)
            self.refuse(f"{where}.{key}", found, "a text", f'write {key} = "{SUCH_AS[key]}", with what is true here')
        return value

    def number(self, key, default, least, most, whole=False):
        value = self.top.get(key, default)
        if (
            isinstance(value, bool)
            or not isinstance(value, int if whole else (int, float))
            or not least <= value <= most
        ):
            expected = f"{'a whole' if whole else 'a'} number, {least} to {most}"
            self.refuse(f"fleet.{key}", repr(value), expected, f"write {key} = {default}, or remove it: the same")
        return value

    def fleet(self):
        self.only(self.content, {"fleet", "group"}, "")
        self.top = self.content.get("fleet", {})
        self.only(self.top, FLEET_KEYS, "fleet")
        boxes, groups = {}, {}
        tables = self.content.get("group", {})
        if not isinstance(tables, dict) or not tables:
            self.refuse("group", "none", "[group.NAME] with boxes", "airside fleet push --example shows two")
        for name, table in tables.items():
            groups[name] = self.group(name, table, boxes)
        return Fleet(
            path=self.path,
            out=self.folder / self.text(self.top, "out", "fleet", self.path.stem + "-push"),
            keys=self.folder / self.text(self.top, "keys", "fleet"),
            boxes=boxes,
            groups=groups,
            waves=self.waves(),
            rolled_back_limit=self.number("rolled_back_limit", 0.1, 0, 1),
            no_answer_limit=self.number("no_answer_limit", 0.2, 0, 1),
            trial_limit_s=3600 * self.number("trial_limit_h", 48, 0.01, 720),
            poll_s=self.number("poll_s", 300, 0.1, 3600),
            at_once=self.number("at_once", 16, 1, 256, whole=True),
        )

    def waves(self):
        shares = self.top.get("waves", [0.04, 0.2, 1.0])
        is_list = isinstance(shares, list) and 1 <= len(shares) <= 20
        if not is_list or any(isinstance(s, bool) or not isinstance(s, (int, float)) for s in shares):
            self.refuse("fleet.waves", repr(shares), "1 to 20 shares", "write waves = [0.04, 0.2, 1.0]")
        if not 0 < shares[0] or shares[-1] != 1 or any(a >= b for a, b in itertools.pairwise(shares)):
            expected = "rising shares above 0, of which the last is 1"
            self.refuse("fleet.waves", repr(shares), expected, "write waves = [0.04, 0.2, 1.0]")
        return shares

    def group(self, name, table, boxes):
        where = f"group.{name}"
        self.only(table, GROUP_KEYS, where)
        ways = [way for way in WAYS if way in table]
        if len(ways) != 1:
            self.refuse(where, " and ".join(ways) or "no way to the boxes", "one of site, page and push", ONE_WAY)
        for key, way in BELONGS.items():
            if key in table and way != ways[0]:
                self.refuse(f"{where}.{key}", f"beside {ways[0]}", f"it beside {way} alone", "remove it")
        if ways[0] == "push" and "status" not in table:
            self.refuse(f"{where}.status", "nothing", "a command that prints airside status --json", STATUS)
        topology = self.text(table, "topology", where, self.top.get("topology"))
        if not SHAPE.fullmatch(topology):
            self.refuse(f"{where}.topology", topology, "such as 5vav-5fcu-2power", "write that of the site files")
        cycle = table.get("cycle_min", self.top.get("cycle_min", 18))
        if isinstance(cycle, bool) or cycle not in (6, 12, 18, 24):
            self.refuse(f"{where}.cycle_min", repr(cycle), "6, 12, 18 or 24", "write that of the site files")
        names = table.get("boxes")
        if not isinstance(names, list) or not names:
            found = "nothing" if names is None else repr(names)
            self.refuse(f"{where}.boxes", found, "a list of names", 'write boxes = ["ahu-1", "ahu-2"]')
        for box in names:
            if not isinstance(box, str) or not NAME.fullmatch(box):
                expected = "names of letters, digits, dots, dashes, 64 at most"
                self.refuse(f"{where}.boxes", repr(box), expected, "write it so, such as ahu-1")
            if box in boxes:
                self.refuse(f"{where}.boxes", f"{box} again", "each box once", "remove one, or give it another name")
            if len(boxes) == MOST_BOXES:
                self.refuse(f"{where}.boxes", f"more than {MOST_BOXES} boxes", "fewer", "make two fleet files")
            filled = {key: self.way(table, key, where, box) for key in WAYS + tuple(BELONGS) if key in table}
            boxes[box] = Box(box, name, topology, cycle, filled)
            for key in ("site", "page", "push", "status", "rollback"):
                if key in filled:
                    self.lead_to_one(key, filled[key], where, box, "{box}" in str(table[key]))
        return names

    def lead_to_one(self, key, value, where, box, has_name):
        """Two boxes behind one way would be one box that is counted twice, and a canary that stands for itself."""
        if key == "site":
            same = os.path.realpath(value)
        else:
            same = tuple(value) if isinstance(value, list) else value.lower().removesuffix(":443")
        other = self.reached.setdefault((key, same), box)
        if other != box:
            shown = " ".join(value) if isinstance(value, list) else value
            remedy = "remove one of the two" if has_name else "write {box} where the name of the box stands in it"
            self.refuse(f"{where}.{key}", f"{shown} for both {other} and {box}", "a way to each box alone", remedy)

    def way(self, table, key, where, box):
        value = table[key]
        if key in ("push", "status", "rollback"):
            if not isinstance(value, list) or not value or any(not isinstance(word, str) or not word for word in value):
                remedy = STATUS if key == "status" else 'write it such as ["ssh", "{box}", "airside", "rollback"]'
                self.refuse(f"{where}.{key}", repr(value), "a list of words", PUSH if key == "push" else remedy)
            if key == "push" and not any("{blob}" in word for word in value):
                self.refuse(f"{where}.push", " ".join(value), "a command with {blob}, the file that is sent", PUSH)
            return [word.replace("{box}", box) for word in value]
        text = self.text(table, key, where).replace("{box}", box)
        if key == "page":
            address = re.fullmatch(r"(https?)://([A-Za-z0-9.-]+|\[[0-9a-fA-F:.]+\])(:\d{1,5})?", text)
            if not address:
                example = f'write page = "{SUCH_AS["page"]}"'
                self.refuse(f"{where}.page", text, "https://HOST:PORT, and nothing behind", example)
            if address[1] == "http" and not (address[2] in ("localhost", "[::1]") or address[2].startswith("127.")):
                self.refuse(f"{where}.page", text, "https, since the key would travel in the clear", "write https")
            return text
        return str(self.folder / text)
