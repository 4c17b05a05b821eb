"""A desk with a weight library for tests of `airside library`."""

import json
import subprocess
import sys

from desk import BIN, ROOT, Desk

sys.path.insert(0, str(ROOT / "tools" / "campaign"))
from airside_campaign.library import Library
from airside_campaign.trusted_keys import read_secret, read_trusted


class Shelf(Desk):
    """A desk with a key pair and two short trainings."""

    def __init__(self, test):
        super().__init__(test)
        self.airside("keygen", "-o", "me", "--name", "Ann")
        for name, room in (("a", "301"), ("b", "401")):
            self.airside("pretrain", "--plant", "rc", "--room", room, "--days", "2", "-o", f"{name}.blob")

    def airside(self, *words):
        return subprocess.run(
            [str(BIN / "airside"), *words], cwd=self.folder, capture_output=True, text=True, check=True, timeout=300
        )

    def library(self, action, *words):
        command = [sys.executable, "-B", "-m", "airside_campaign.library_command", "--program", str(BIN / "airside")]
        return subprocess.run(
            [*command, action, *words],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
        )

    def add(self, *words):
        done = self.library("add", *words, "--key", "me.key", "--json")
        if done.returncode != 0:
            raise AssertionError(done.stderr)
        return [one["digest"] for one in json.loads(done.stdout)["added"]]

    def read(self, action, *words):
        return self.library(action, *words, "--keys", "me.pub")

    def found(self, *words):
        done = self.read("find", "--json", *words)
        return json.loads(done.stdout)["weights"]

    def keys(self):
        """The secret key and whose index is believed."""
        return read_secret(self.folder / "me.key")[0], read_trusted(self.folder / "me.pub")

    def as_it_was_written_before(self):
        """The index without `content` of its entries, signed."""
        secret, trusted = self.keys()
        with Library(str(self.folder / "library"), trusted).change(secret) as index:
            for entry in index["weights"].values():
                entry.pop("content")
