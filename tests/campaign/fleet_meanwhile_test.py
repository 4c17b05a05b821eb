"""What changes while a push lasts its days: boxes that go back late, weights that are revoked, boxes that are silent or
renamed. Boxes are a script here, whose trials are over at once; `airside fleet` reaches them by commands."""

import json
import subprocess
import sys
import unittest

from fleet_yard import TOPOLOGY, Yard

BOX = """
import json, subprocess, sys
from pathlib import Path
from airside_campaign.fleet.weights import crc32c
action, name, *more = sys.argv[1:]
place = Path(__file__).parent / (name + ".json")
box = json.loads(place.read_text())
if box.pop("silent", 0):
    sys.exit("no route to " + name)
if action == "status":
    print(json.dumps(box))
    sys.exit(0)
if action == "push" and "takes_nothing" in box:
    box |= {"pushed_refusal": "key unknown", "pushed_refusal_field": "key_id"}
elif action == "push":
    crc = f"{crc32c(Path(more[0]).read_bytes()):08x}"
    box |= {"pushed_crc": crc, "pushed_weights": "confirmed"}
else:
    box["pushed_weights"] = "rolled back"
place.write_text(json.dumps(box))
after = place.with_suffix(".sh")
if action == "push" and after.exists():
    subprocess.run(["sh", after], check=True)
"""
STATUS = {
    "time": "2026-11-01 12:00", "topology": TOPOLOGY, "state": "control", "condition": "running", "alarms": [],
    "pushed_crc": "00000000", "pushed_weights": "none", "pushed_refusal": "none", "pushed_refusal_field": "",
}  # fmt: skip
NAMES = [f"b-{n}" for n in range(1, 11)]


class Meanwhile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.yard = yard = Yard([])
        cls.addClassCleanup(yard.clear)
        yard.make_weights()
        yard.airside("keygen", "-o", "librarian")
        (yard.folder / "box.py").write_text(BOX)

    def setUp(self):
        self.out = "out-" + self.id().rsplit(".", 1)[1][:30]
        self.write(NAMES)
        for name in NAMES:
            self.set(name, STATUS)
            (self.yard.folder / f"{name}.sh").unlink(missing_ok=True)
        (self.yard.folder / "keys" / "revoked").unlink(missing_ok=True)

    def write(self, names, more=""):
        box = json.dumps([sys.executable, "-B", "box.py"])[:-1]
        self.yard.fleet_file(
            f'[fleet]\nout = "{self.out}"\nkeys = "keys"\ntopology = "{TOPOLOGY}"\ncycle_min = 24\n'
            f"waves = [0.1, 0.3, 1.0]\npoll_s = 0.1\n{more}\n[group.all]\n"
            f'push = {box}, "push", "{{box}}", "{{blob}}"]\nstatus = {box}, "status", "{{box}}"]\n'
            f'rollback = {box}, "rollback", "{{box}}"]\nboxes = {json.dumps(names)}\n'
        )

    def set(self, name, what):
        (self.yard.folder / f"{name}.json").write_text(json.dumps(STATUS | what))

    def after_push_to(self, name, command):
        (self.yard.folder / f"{name}.sh").write_text(command)

    def push(self, *words):
        done = self.yard.fleet("push", "fleet.toml", "--blob", "good.blob", *words, "--json")
        self.assertTrue(done.stdout, done.stderr)
        return json.loads(done.stdout), done.returncode

    def phases(self, said):
        return {name: box["phase"] for name, box in said["boxes"].items()}

    def test_a_canary_that_goes_back_after_its_wave_halts_the_next(self):
        change = "sed -i s/confirmed/rolled\\ back/ b-1.json"
        self.after_push_to("b-3", change)
        said, code = self.push()
        why = "wave 1 of 3: 1 of 1 boxes rolled back or refused, more than 10 %"
        self.assertEqual((code, said["halted"]), (1, why))
        self.assertEqual(self.phases(said), {"b-1": "rolled back", "b-2": "kept", "b-3": "kept"})
        self.assertEqual(said["boxes"]["b-1"]["why"], "after they were kept")
        events = [(line["event"], line.get("box")) for line in self.yard.ledger(self.out)]
        self.assertIn(("rolled back", "b-1"), events)

    def test_a_box_that_goes_back_during_the_last_wave_is_seen_at_the_end(self):
        self.after_push_to("b-10", "sed -i s/confirmed/rolled\\ back/ b-2.json")
        said, code = self.push()
        self.assertEqual(code, 1)
        self.assertIn("wave 2 of 3: 1 of 2 boxes rolled back", said["halted"])
        self.assertEqual(self.phases(said)["b-2"], "rolled back")

    def library(self, *words):
        command = self.yard.fleet_words(*words, "--key", "librarian.key", "--json")
        command[command.index("airside_campaign.fleet.command")] = "airside_campaign.library_command"
        return subprocess.list2cmdline(command), subprocess.run(
            command, cwd=self.yard.folder, env=self.yard.environment, capture_output=True, text=True, check=False
        )

    def test_weights_that_are_revoked_meanwhile_go_no_further(self):
        _, done = self.library("add", "good.blob")
        digest = json.loads(done.stdout)["added"][0]["digest"]
        revoke, _ = self.library("revoke", "0" * 8, "--why", "wrong weather")
        self.after_push_to("b-2", revoke.replace("0" * 8, digest))
        said, code = self.push("--library", "library", "--library-keys", "librarian.pub")
        self.assertEqual((code, sorted(said["boxes"])), (1, ["b-1", "b-2", "b-3"]))
        self.assertIn("wave 3 of 3: revoked meanwhile", said["halted"])
        self.assertIn("wrong weather", said["halted"])

    def test_a_key_that_is_revoked_meanwhile_sends_no_further(self):
        key = json.loads(
            subprocess.run(
                [self.yard.fleet_words()[5], "blob", "inspect", "--json", self.yard.folder / "good.blob"],
                capture_output=True,
                check=True,
            ).stdout
        )["header"]["key"]
        self.after_push_to("b-1", f"echo {key} > keys/revoked")
        said, code = self.push()
        self.assertEqual((code, list(said["boxes"])), (1, ["b-1"]))
        self.assertIn("wave 2 of 3: revoked meanwhile", said["halted"])

    def test_a_silent_first_box_is_replaced_by_the_next_and_too_many_halt(self):
        self.set("b-1", {"silent": 1})
        said, code = self.push("--dry-run")
        self.assertEqual(said["waves"][0], ["b-2"])
        said, code = self.push()
        self.assertEqual(said["boxes"]["b-2"], {"phase": "kept", "wave": 1, "why": ""})
        self.assertEqual((code, said["halted"]), (1, None), "it was not reached in the end")
        self.assertEqual(list(said["not_sent"]), ["b-1"])
        for name in NAMES:
            self.set(name, {} if name == "b-10" else {"silent": 1})
        self.out += "-again"
        self.write(NAMES)
        said, code = self.push()
        self.assertEqual(said["boxes"], {"b-10": {"phase": "kept", "wave": 1, "why": ""}})
        self.assertIn("wave 2 of 3: 1 of 2 boxes give no answer, more than 20 %", said["halted"])

    def undo(self, said):
        done = self.yard.fleet("undo", "fleet.toml", said["weights"][:12], "--json")
        return json.loads(done.stdout), done.returncode

    def test_undo_names_boxes_that_the_file_has_no_more(self):
        said, code = self.push()
        self.assertEqual(code, 0, said)
        self.write(["a-1", *NAMES[1:]])
        back, code = self.undo(said)
        self.assertEqual((code, list(back["not"])), (1, ["b-1"]))
        self.assertIn("fleet.toml has no such box; add it again", back["not"]["b-1"])
        self.assertEqual(sorted(back["undone"]), sorted(NAMES[1:]))
        self.write(NAMES)
        self.assertEqual(self.undo(said), ({"weights": said["weights"], "undone": NAMES, "not": {}}, 0))

    def test_undo_takes_back_what_boxes_took_though_the_record_says_refused_or_replaced(self):
        for name in ("b-9", "b-10"):
            self.set(name, {"takes_nothing": 1})
        self.write(NAMES, "rolled_back_limit = 0.9")
        other = "sed -i 's/\"pushed_crc\": \"[0-9a-f]*/\"pushed_crc\": \"12345678/'"
        self.after_push_to("b-8", f"{other} b-1.json b-2.json")
        said, _ = self.push()
        phases = self.phases(said)
        self.assertEqual([phases[n] for n in ("b-1", "b-2", "b-9", "b-10")], ["replaced"] * 2 + ["refused"] * 2)
        for name in ("b-1", "b-9"):
            self.set(name, {"pushed_crc": said["crc"], "pushed_weights": "confirmed"})
        back, code = self.undo(said)
        self.assertEqual((code, back["not"]), (0, {}))
        self.assertEqual(sorted(back["undone"]), sorted({*NAMES} - {"b-2", "b-10"}))
        weights = [json.loads((self.yard.folder / f"{n}.json").read_text())["pushed_weights"] for n in ("b-1", "b-9")]
        self.assertEqual(weights, ["rolled back"] * 2)

    def test_a_record_of_before_is_gone_on_with(self):
        said, code = self.push()
        (place,) = (self.yard.folder / self.out).glob("*.json")
        state = json.loads(place.read_text())
        self.assertEqual(set(state), {"kind", "format", "digest", "crc", "key", "provenance", "begun", "boxes"})
        self.assertEqual(state["format"], 1)
        again, code = self.push()
        self.assertEqual((code, again), (0, said))


if __name__ == "__main__":
    unittest.main()
