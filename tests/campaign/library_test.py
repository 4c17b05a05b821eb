"""The weight library: what is in it is what was signed, and what is revoked is not given out."""

import json
import os
import re
import subprocess
import sys
import threading
import unittest

import fsspec
from desk import BIN
from library_shelf import Shelf

from airside_campaign.complaint import BadInput
from airside_campaign.library import Library
from airside_campaign.lineage import Family


class Weights(unittest.TestCase):
    def setUp(self):
        self.shelf = Shelf(self)

    def test_what_is_added_is_found_with_what_is_known_of_it_and_comes_back_to_the_byte(self):
        shelf = self.shelf
        (digest,) = shelf.add(
            "a.blob",
            "--room",
            "Room 301",
            "--figure",
            "dae_degc=0.045",
            "--effect",
            "leak",
            "--data",
            "2021-07-01..2021-07-02",
        )
        entry = shelf.found("--topology", "5vav-5fcu-2power", "--room", "room 3", "--effect", "leak")[0]
        self.assertEqual(entry["digest"], digest)
        self.assertEqual(entry["figures"], {"dae_degc": 0.045})
        self.assertEqual(entry["by"], "Ann")
        self.assertEqual(entry["data"], {"from": "2021-07-01", "to": "2021-07-02"})
        self.assertIn("pretrain", entry["provenance"])
        for none in (["--topology", "3vav-0fcu-1power"], ["--room", "402"], ["--effect", "none"]):
            self.assertEqual(shelf.read("find", *none).returncode, 1, none)
        self.assertEqual(shelf.read("get", digest[:8], "-o", "back.blob").returncode, 0)
        self.assertEqual((shelf.folder / "back.blob").read_bytes(), (shelf.folder / "a.blob").read_bytes())
        shelf.add("a.blob", "--figure", "darv_degc=0.2", "--effect", "fan")
        entry = shelf.found()[0]
        self.assertEqual(len(shelf.found()), 1, "the same bytes are the same weights")
        self.assertEqual(entry["figures"], {"dae_degc": 0.045, "darv_degc": 0.2})
        self.assertEqual(entry["effects"], ["fan", "leak"])

    def test_revoking_weights_stops_all_that_was_made_from_them(self):
        shelf = self.shelf
        (first,) = shelf.add("a.blob")
        (second,) = shelf.add("b.blob", "--parent", first[:10])
        line = json.loads(shelf.read("lineage", second, "--json").stdout)
        self.assertEqual((line["made_from"], line["made_of_it"]), ([first], []))
        done = shelf.library("revoke", first, "--why", "wrong weather", "--key", "me.key", "--json")
        expected = {"revoked": [first], "signed_copies": [], "made_from_them": [second]}
        self.assertEqual(json.loads(done.stdout), expected)
        self.assertIn("8 to 64 hex digits", shelf.read("show", "zz").stderr)
        self.assertEqual(shelf.read("find").returncode, 1)
        self.assertEqual({w["digest"] for w in shelf.found("--all")}, {first, second})
        refused = shelf.read("get", second, "-o", "no.blob")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("wrong weather", refused.stderr)
        self.assertFalse((shelf.folder / "no.blob").exists())
        self.assertEqual(shelf.read("get", first, "-o", "look.blob", "--revoked").returncode, 0)

    def test_a_campaign_is_added_with_its_figures_and_what_was_made_from_what(self):
        shelf = self.shelf
        shelf.write("""
[campaign]
out = "runs"
[[job]]
name = "train-{seed}"
run = ["pretrain", "--plant", "rc", "--room", "301", "--days", "2", "--seed", "{seed}", "-o", "{out}/w.blob", "--json"]
over = {seed = [1, 2]}
[[job]]
name = "log"
run = ["simulate", "--plant", "rc", "--room", "401-real", "--method", "expert", "--expert-days", "0", "--days", "2",
       "--log", "{out}/log.csv", "--json"]
[[job]]
name = "fit-{seed}"
after = {train = "train-{seed}", log = "log"}
run = ["transfer", "--from", "{train}/w.blob", "--log", "{log}/log.csv", "--steps", "5", "-o", "{out}/w.blob", "--json"]
over = {seed = [1, 2]}
""")
        self.assertEqual(shelf.run("--serial").returncode, 0)
        self.assertEqual(len(shelf.add("runs")), 4)
        made = [w for w in shelf.found() if w.get("parents")]
        self.assertEqual(len(made), 2)
        for weights in made:
            self.assertTrue(weights["command"].startswith("airside transfer"))
            (parent,) = weights["parents"]
            source = next(w for w in shelf.found() if w["digest"] == parent)
            self.assertEqual(source["room"], "301")
            self.assertIn("transitions", source["figures"])

    def test_what_was_not_signed_by_a_trusted_key_is_not_believed(self):
        shelf = self.shelf
        (digest,) = shelf.add("a.blob")
        shelf.airside("keygen", "-o", "other", "--name", "Bob")
        place = shelf.folder / "library"
        index = (place / "index").read_text()
        for why, text, words in (
            ("another text", index.replace('"added"', '"adde1"'), ["--keys", "me.pub"]),
            ("trusted keys", index, ["--keys", "other.pub"]),
            ("something else", "{}", ["--keys", "me.pub"]),
            ("or later", index, ["--keys", "me.pub", "--at-least", "2"]),
        ):
            (place / "index").write_text(text)
            done = shelf.library("find", *words)
            self.assertEqual(done.returncode, 1)
            self.assertIn(why, done.stderr)
        done = shelf.library("add", "b.blob", "--key", "other.key", "--keys", "other.pub")
        self.assertEqual(done.returncode, 1, "whom the index's own keys do not know adds nothing")
        (place / "index").write_text(index)
        keys = shelf.folder / "keys"
        keys.mkdir()
        (keys / "me.pub").write_bytes((shelf.folder / "me.pub").read_bytes())
        self.assertEqual(shelf.library("find").returncode, 0, "./keys by default")
        (keys / "revoked").write_text(index.split()[1] + " # lost\n")
        self.assertEqual(shelf.library("find").returncode, 1, "a revoked key")
        blob = place / "blobs" / f"{digest}.blob"
        blob.write_bytes(blob.read_bytes()[:-1] + b"x")
        self.assertIn("other bytes", shelf.read("get", digest, "-o", "x.blob").stderr)
        self.assertEqual(shelf.read("check").returncode, 1)
        shelf.add("a.blob")
        self.assertEqual(shelf.read("check").returncode, 0, "adding the blob again mends it")

    def test_the_key_has_the_id_that_blobs_show(self):
        shelf = self.shelf
        shelf.airside("sign", "a.blob", "--key", "me.key")
        (digest,) = shelf.add("a.blob")
        index = (shelf.folder / "library" / "index").read_text()
        self.assertEqual(shelf.found()[0]["signed_by"], index.split()[1])
        self.assertEqual(shelf.found()[0]["digest"], digest)

    def test_wrong_words_and_files_are_named(self):
        shelf = self.shelf
        (shelf.folder / "text.blob").write_text("no weights")
        (shelf.folder / "empty").mkdir()
        (shelf.folder / "open.key").write_bytes((shelf.folder / "me.key").read_bytes())
        (shelf.folder / "open.key").chmod(0o644)
        for why, words in (
            ("text.blob", ["add", "text.blob", "--key", "me.key"]),
            ("gone.blob", ["add", "gone.blob", "--key", "me.key"]),
            ("no finished job", ["add", "empty", "--key", "me.key"]),
            ("NAME=NUMBER", ["add", "a.blob", "--key", "me.key", "--figure", "dae"]),
            ("FROM..TO", ["add", "a.blob", "--key", "me.key", "--data", "July"]),
            ("mode 600", ["add", "a.blob", "--key", "open.key", "--keys", "me.pub"]),
            ("one line `airside-secret-key-1", ["add", "a.blob", "--key", "me.pub"]),
            ("0 weights that begin", ["add", "a.blob", "--key", "me.key", "--parent", "0123456789"]),
            ("no index", ["show", "zz", "--keys", "me.pub"]),
            ("the public keys that are believed", ["find"]),
            ("an address that fsspec knows", ["find", "--library", "nonsense://x", "--keys", "me.pub"]),
        ):
            done = shelf.library(*words)
            self.assertEqual(done.returncode, 1, words)
            self.assertIn(why, done.stderr)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
            self.assertFalse((shelf.folder / "library" / "index").exists(), "nothing was written")
            self.assertFalse((shelf.folder / "library" / "lock").exists(), "no lock is left")

    def test_the_program_hands_all_words_over(self):
        shelf = self.shelf
        shim = shelf.folder / "airside-library"
        shim.write_text(f'#!/bin/sh\nexec "{sys.executable}" -B -m airside_campaign.library_command "$@"\n')
        shim.chmod(0o755)
        environment = dict(shelf.environment, PATH=f"{shelf.folder}:/usr/bin:/bin")

        def airside(*words):
            command = [str(BIN / "airside"), "library", *words]
            done = subprocess.run(
                command, cwd=shelf.folder, env=environment, capture_output=True, text=True, check=False
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            return done.stdout

        airside("add", "a.blob", "b.blob", "--key", "me.key", "--room", "Room 1", "--figure", "a=1", "--figure", "b=2")
        found = json.loads(airside("find", "--json", "--keys", "me.pub", "--room", "room 1"))["weights"]
        self.assertEqual([w["figures"] for w in found], [{"a": 1, "b": 2}] * 2)
        airside("revoke", found[0]["digest"], "--why", "a trial of words", "--key", "me.key")
        airside("get", found[0]["digest"], "--out", "c.blob", "--revoked", "--keys", "me.pub")
        self.assertTrue((shelf.folder / "c.blob").is_file())

    def test_program_and_package_know_the_same_options(self):
        for action in ("add", "find", "show", "lineage", "revoke", "get", "check"):
            program = subprocess.run(
                [str(BIN / "airside"), "library", action, "--help"], capture_output=True, text=True, check=True
            ).stdout
            package = self.shelf.library(action, "--help").stdout
            # Of words within a description only those of the package's own usage count.
            usage = package[: package.index("\n\n")]
            named = set(re.findall(r"(?:^|[\s,\[])(--[a-z-]+)", usage)) - {"--help"}
            listed = set(re.findall(r"^  (?:-\w,)?(--[a-z-]+)", program, re.MULTILINE)) - {"--help"}
            self.assertEqual(named | ({"--out"} if action == "get" else set()), listed, action)

    def test_ten_who_add_at_once_lose_nothing(self):
        shelf = self.shelf
        blob = (shelf.folder / "a.blob").read_bytes()
        secret, trusted = shelf.keys()

        def add_one(number):
            library = Library(str(shelf.folder / "shared"), trusted)
            with library.change(secret, begin=True) as index:
                library.put(index, blob + bytes([number]), {"room": str(number)})

        threads = [threading.Thread(target=add_one, args=[n]) for n in range(10)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        index = Library(str(shelf.folder / "shared"), trusted).read()
        self.assertEqual({entry["room"] for entry in index["weights"].values()}, {str(n) for n in range(10)})
        self.assertEqual(index["serial"], 10)

    def test_index_and_blobs_are_on_the_disk_before_and_after_their_renames(self):
        synced, real = [], os.fsync
        os.fsync = lambda handle: (synced.append(os.readlink(f"/proc/self/fd/{handle}")), real(handle))
        self.addCleanup(setattr, os, "fsync", real)
        secret, trusted = self.shelf.keys()
        with Library(str(self.shelf.folder / "new"), trusted).change(secret, begin=True) as index:
            Library(str(self.shelf.folder / "new"), trusted).put(index, b"some", {})
        names = [name.rsplit("/new", 1)[1] for name in synced]
        (digest,) = index["weights"]
        self.assertEqual([name.split(".")[0] for name in names[::2]], [f"/blobs/{digest}", "/index"])
        self.assertTrue(all(name.endswith(".new") for name in names[::2]), names)
        self.assertEqual(names[1::2], ["/blobs", ""])

    def test_an_object_store_serves_as_well_and_tells_two_writers(self):
        shelf = self.shelf
        secret, trusted = shelf.keys()
        self.addCleanup(fsspec.filesystem("memory").rm, "/weights", recursive=True)
        library = Library("memory://weights", trusted)
        with library.change(secret, begin=True) as index:
            first = library.put(index, b"first", {"room": "301"})
        with library.change(secret) as index:
            second = library.put(index, b"second", {"parents": [first]})
            third = library.put(index, b"third", {"parents": [second]})
        index = library.read()
        self.assertEqual(library.blob(index, second), b"second")
        self.assertEqual(Family(index).parents(third), [second, first])
        self.assertEqual(sorted(Family(index).children(first)), sorted([second, third]))
        with self.assertRaises(BadInput), library.change(secret) as index:
            index["weights"][first]["revoked"] = {"why": "x", "at": "now"}
            library._unlock()
            with library.change(secret) as meanwhile:
                meanwhile["weights"][first]["room"] = "302"
        index = library.read()
        self.assertEqual(index["weights"][first]["room"], "302")
        self.assertEqual(Family(index).why_not(third), "")


if __name__ == "__main__":
    unittest.main()
