"""Weights to fifty real boxes: canary, waves, halt, going on after kills, and the way back. One yard for all tests."""

import json
import random
import re
import subprocess
import time
import unittest
from pathlib import Path

from fleet_yard import BIN, ROOT, TOPOLOGY, Yard

HALLS = [f"hall-{n:02}" for n in range(24)]
TOWERS = [f"tower-{n:02}" for n in range(24)]
ALL = [*HALLS, *TOWERS, "page-1", "ssh-1"]
CANARIES = ["hall-00", "page-1", "ssh-1", "tower-00"]


def fleet_text(yard, out="fleet-push", more=""):
    command = json.dumps(str(BIN / "airside"))
    return f"""
[fleet]
out = "{out}"
keys = "keys"
topology = "{TOPOLOGY}"
cycle_min = 24
waves = [0.04, 0.3, 1.0]
trial_limit_h = 0.05
poll_s = 0.4
at_once = 32
{more}
[group.halls]
site = "{{box}}/site.toml"
boxes = {json.dumps(HALLS)}
[group.towers]
site = "{{box}}/site.toml"
boxes = {json.dumps(TOWERS)}
[group.page]
page = "{yard.address}"
access = "{{box}}/access"
boxes = ["page-1"]
[group.ssh]  # its transport is the shell here: commands like those that ssh and scp would run
push = ["cp", "{{blob}}", "{{box}}/inbox/fleet.blob"]
status = [{command}, "status", "{{box}}/state", "--json"]
rollback = [{command}, "rollback", "{{box}}/site.toml"]
boxes = ["ssh-1"]
"""


class Fleet(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.yard = yard = Yard(ALL)
        cls.addClassCleanup(yard.clear)
        yard.make_weights()
        yard.make_sites()
        yard.address = "http://127.0.0.1:1"  # as long as no box runs
        yard.fleet_file(fleet_text(yard))

    def start_boxes(self):
        """They are at work all the time, so they begin late."""
        yard = self.yard
        yard.start_boxes()
        yard.address = yard.start_page("page-1")
        yard.until(lambda: all(yard.status(name).get("cycles", 0) > 2 for name in ALL))
        yard.fleet_file(fleet_text(yard))

    def push(self, *words):
        """The report of a push, and its exit code."""
        done = self.yard.fleet("push", "fleet.toml", *words, "--json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertTrue(done.stdout, done.stderr)
        return json.loads(done.stdout), done.returncode

    def pushed(self):
        return {name: self.yard.status(name)["pushed_weights"] for name in ALL}

    def assert_untouched(self, names):
        for name in names:
            self.assertEqual(self.yard.status(name).get("pushed_weights", "none"), "none", name)
            self.assertEqual(list((self.yard.folder / name).glob("inbox/*")), [], name)

    def refused(self, why, *words, file="fleet.toml", code=1):
        done = self.yard.fleet("push", file, *words)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(why, done.stderr)
        if code == 1:
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
            for part in ("found", "expected"):
                self.assertIn(part, done.stderr)

    def test_1_what_boxes_would_refuse_is_refused_before_the_first_wave(self):
        yard = self.yard
        yard.airside("sign", "first.blob", "--key", "ann.key", "--scope", "hall-00", "-o", "scoped.blob")
        damaged = bytearray((yard.folder / "good.blob").read_bytes())
        damaged[5000] ^= 4
        (yard.folder / "damaged.blob").write_bytes(damaged)
        self.refused("an unsigned blob", "--blob", "first.blob")
        self.refused("a signature of a key", "--blob", "unknown.blob")
        self.refused("another site", "--blob", "scoped.blob")
        self.refused("damaged.blob", "--blob", "damaged.blob")
        self.refused("no such file", "--blob", "gone.blob")
        whole = fleet_text(yard)
        for why, text in (
            ("topology_hash", whole.replace(f'topology = "{TOPOLOGY}"', 'topology = "2vav-0fcu-0power"')),
            ("cycle", whole.replace("cycle_min = 24", "cycle_min = 18")),
            ("nowhere: site", whole.replace('["hall-00",', '["nowhere", "hall-00",')),
            ("hall-00 again", whole.replace('["tower-00",', '["hall-00", "tower-00",')),
            ("write poll_s", whole.replace("poll_s", "pol_s")),
            ("rising shares", whole.replace("0.3, 1.0]", "0.3, 0.2, 1.0]")),
            ("one of site, page and push", whole.replace('push = ["cp"', 'page = "https://x"\npush = ["cp"')),
            ("{blob}", whole.replace('"{blob}", ', "")),
            ("https, since the key", whole.replace(yard.address, "http://ahu-1.example.org:8350")),
            ("the public keys", whole.replace('keys = "keys"', 'keys = "no-keys"')),
        ):
            yard.fleet_file(text, "wrong.toml")
            self.assertNotEqual(text, whole, why)
            self.refused(why, "--blob", "good.blob", file="wrong.toml")
        self.refused("by one of --blob", code=2)
        self.refused("by one of --blob", "--blob", "good.blob", "--from-library", "0" * 8, code=2)
        self.assert_untouched(ALL)
        self.assertEqual(yard.ledger(), [])

    def test_2_weights_that_the_library_has_revoked_are_refused_under_every_signature(self):
        yard = self.yard
        self.start_boxes()
        yard.airside("keygen", "-o", "librarian")
        yard.airside("sign", "first.blob", "--key", "ann.key", "--counter", "7", "-o", "revoked.blob")

        def library(*words):
            command = yard.fleet_words(*words, "--key", "librarian.key", "--json")
            command[command.index("airside_campaign.fleet.command")] = "airside_campaign.library_command"
            done = subprocess.run(
                command, cwd=yard.folder, env=yard.environment, capture_output=True, text=True, check=False
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            return json.loads(done.stdout)

        (added,) = library("add", "revoked.blob")["added"]
        known = ["--library", "library", "--library-keys", "librarian.pub"]
        done = yard.fleet("push", "fleet.toml", "--from-library", added["digest"][:10], *known, "--dry-run", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        waves = json.loads(done.stdout)["waves"]
        self.assertEqual(sorted(waves[0]), CANARIES)
        self.assertEqual([len(wave) for wave in waves], [4, 14, 32])
        library("revoke", added["digest"], "--why", "trained on the wrong weather")
        self.refused("wrong weather", "--from-library", added["digest"][:10], *known)
        self.refused("wrong weather", "--blob", "good.blob", *known)
        self.assert_untouched(ALL)
        self.a_box_of_another_topology()

    def a_box_of_another_topology(self):
        """Though fleet file and weights agree."""
        yard = self.yard
        status = json.loads((yard.folder / "hall-00" / "state" / "status.json").read_text())
        (yard.folder / "other").mkdir()
        (yard.folder / "other" / "status.json").write_text(json.dumps(status | {"topology": "3vav-0fcu-1power"}))
        yard.fleet_file(fleet_text(yard).replace('"{box}/state"', '"other"'), "wrong.toml")
        self.refused("a box of 3vav-0fcu-1power", "--blob", "good.blob", file="wrong.toml")
        self.assertEqual(yard.ledger(), [])

    def test_3_weights_that_are_rolled_back_halt_after_the_canary(self):
        yard = self.yard
        said, code = self.push("--blob", "bad.blob")
        self.assertEqual(code, 1)
        self.assertIn("wave 1 of 3", said["halted"])
        self.assertEqual(sorted(said["boxes"]), CANARIES)
        rolled_back = [name for name, box in said["boxes"].items() if box["phase"] == "rolled back"]
        self.assertTrue(rolled_back)
        self.assert_untouched(sorted(set(ALL) - set(CANARIES)))
        yard.until(lambda: all(self.pushed()[name] == "rolled back" for name in CANARIES))
        for name in CANARIES:
            self.assertIn("they foretell the rooms worse than those before", yard.said(name))
        sent = [line["box"] for line in yard.ledger() if line["event"] == "sent"]
        self.assertEqual(sorted(sent), CANARIES)
        again, code = self.push("--blob", "bad.blob")
        self.assertEqual(code, 1)
        self.assertIn("wave 1 of 3: 4 of 4 boxes rolled back", again["halted"])
        self.assertEqual([line["box"] for line in yard.ledger() if line["event"] == "sent"], sent, "nothing further")

    def test_4_good_weights_reach_every_box_once_though_the_push_is_killed_again_and_again(self):
        yard = self.yard
        draw = random.Random(11)
        begun = len(yard.ledger())

        def lines(event):
            return [line for line in yard.ledger()[begun:] if line["event"] == event]

        # Right when each wave begins to send, and once at a time that is drawn.
        for wave in (1, 2, None, 3):
            self.push_killed(wave and (lambda wave=wave: self.wave_sends(lines, wave)), draw)
        said, code = self.push("--blob", "good.blob", "--by", "Ann")
        self.assertEqual(code, 0, said)
        self.assertTrue(said["all_kept"])
        self.assertEqual({box["phase"] for box in said["boxes"].values()}, {"kept"})
        self.assertEqual([sum(b["wave"] == w for b in said["boxes"].values()) for w in (1, 2, 3)], [4, 14, 32])
        self.assertEqual(set(self.pushed().values()), {"confirmed"})
        for name in ALL:
            self.assertEqual(yard.said(name).count(f"weights {said['crc']} of ann taken"), 1, name)
            self.assertNotIn("pushed weights refused", yard.said(name))
        kept = lines("kept")
        self.assertEqual(sorted(line["box"] for line in kept), sorted(ALL))
        sent = lines("sent")
        self.assertEqual(len({line["box"] for line in sent}), len(sent), "sent twice")
        self.assertEqual({line["by"] for line in sent}, {"Ann"})
        self.waves_follow_one_another(lines)
        again, code = self.push("--blob", "good.blob")
        self.assertEqual((code, len(lines("sent"))), (0, len(sent)), again)

    def push_killed(self, stop, draw):
        yard = self.yard
        command = yard.fleet_words("push", "fleet.toml", "--blob", "good.blob", "--by", "Ann")
        with open(yard.folder / "push.txt", "ab") as out:
            push = subprocess.Popen(command, cwd=yard.folder, env=yard.environment, stdout=out, stderr=out)
        try:
            if stop is None:
                time.sleep(draw.uniform(0.5, 2.5))
            else:
                yard.until(lambda: push.poll() is not None or stop(), 120)
            self.assertIsNone(push.poll(), "it had ended before it was killed")
        finally:
            push.kill()
            push.wait()

    def wave_sends(self, lines, wave):
        return any(line["wave"] == wave for line in lines("sending"))

    def waves_follow_one_another(self, lines):
        """No box is sent to before all of the wave before have kept the weights."""
        state = json.loads(
            next((self.yard.folder / "fleet-push").glob(lines("sent")[0]["weights"][:16] + "*")).read_text()
        )
        boxes = state["boxes"].values()
        for wave in (2, 3):
            ended = max(box["ended_at"] for box in boxes if box["wave"] == wave - 1)
            self.assertGreater(min(box["sent_at"] for box in boxes if box["wave"] == wave), ended)

    def test_5_all_boxes_go_back_and_the_same_push_is_refused_then(self):
        yard = self.yard
        digest = json.loads(yard.fleet("status", "fleet.toml", "--json").stdout)["last_push"]["digest"]
        done = yard.fleet("undo", "fleet.toml", digest[:10], "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(json.loads(done.stdout)["undone"]), sorted(ALL))
        self.assertEqual(set(self.pushed().values()), {"rolled back"})
        self.refused("taken back", "--blob", "good.blob")

    def test_6_boxes_that_are_not_fit_are_left_alone_and_silence_halts(self):
        yard = self.yard
        yard.airside("release", "hall-00/site.toml")
        yard.until(lambda: yard.status("hall-00")["state"] == "release")
        yard.airside("sign", "first.blob", "--key", "ann.key", "-o", "next.blob")
        plan = json.loads(yard.fleet("push", "fleet.toml", "--blob", "next.blob", "--dry-run", "--json").stdout)
        self.assertEqual(plan["not_fit"], {"hall-00": "it is released"})
        self.assertIn("hall-01", plan["waves"][0], "another is the canary")
        self.assertEqual(
            json.loads(yard.fleet("status", "fleet.toml", "--json").stdout)["boxes"]["hall-00"]["state"], "release"
        )
        yard.page.terminate()
        yard.page.wait(10)
        said, code = self.push("--blob", "next.blob")
        self.assertEqual((code, said["boxes"]), (1, {}))
        self.assertIn("give no answer", said["halted"])

    def test_7_program_and_package_know_the_same_options(self):
        for action in ("push", "status", "undo"):
            asked = [str(BIN / "airside"), "fleet", action, "--help"]
            program = subprocess.run(asked, capture_output=True, text=True, check=True).stdout
            package = self.yard.fleet(action, "--help").stdout
            usage = package[: package.index("\n\n")]
            named = set(re.findall(r"(?:^|[\s,\[])(--[a-z-]+)", usage)) - {"--help"}
            self.assertEqual(named, set(re.findall(r"^  (?:-\w,)?(--[a-z-]+)", program, re.MULTILINE)) - {"--help"})

    def test_8_the_example_is_a_fleet_file(self):
        done = self.yard.fleet("push", "--example")
        self.yard.fleet_file(done.stdout, "example.toml")
        self.refused("gone.blob", "--blob", "gone.blob", file="example.toml")
        self.assertIn(done.stdout, (Path(ROOT) / "docs" / "fleet.md").read_text(encoding="utf-8"))


if __name__ == "__main__":
    unittest.main()
