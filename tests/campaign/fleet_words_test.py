"""What `airside fleet` says of mistakes that a newcomer makes, before any box runs."""

import json
import subprocess
import unittest

from fleet_yard import BIN, TOPOLOGY, Yard

NEVER_RAN = "airsided has not run with this site yet (no "


def fleet_text(more, keys="keys"):
    return f"""
[fleet]
keys = "{keys}"
topology = "{TOPOLOGY}"
cycle_min = 24
{more}
"""


SOUND = '[group.bench]\nsite = "{box}/site.toml"\nboxes = ["hall-1", "hall-2"]'
PAGES = '[group.pages]\npage = "https://{box}.example.org"\nboxes = ["p-1", "p-2"]'
COMMANDS = """[group.ssh]
push = ["scp", "{blob}", "airside@{box}:inbox/fleet.blob"]
status = ["ssh", "{box}", "airside", "status", "--json"]
boxes = ["s-1", "s-2"]"""


class FleetWords(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.yard = yard = Yard(["hall-1", "hall-2"])
        cls.addClassCleanup(yard.clear)
        yard.make_weights()
        yard.make_sites()

    def setUp(self):
        self.yard.fleet_file(fleet_text(SOUND))

    def complaint(self, *words, more=None, keys="keys"):
        """The one line of a refusal, which has the four parts and leaves nothing behind."""
        if more is not None:
            self.yard.fleet_file(fleet_text(more, keys))
        done = self.yard.fleet(*words)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        (line,) = done.stderr.strip().splitlines()
        self.assertRegex(line, r"^airside fleet: .+: found .+; expected .+; .+")
        self.assertNotIn("correct it", line)
        self.assertFalse((self.yard.folder / "fleet-push").exists())
        return line

    def refused_file(self, more, *parts):
        line = self.complaint("status", "fleet.toml", more=more)
        for part in parts:
            self.assertIn(part, line)

    def test_boxes_that_never_ran_are_named_in_words_and_a_dry_run_that_reaches_nobody_fails(self):
        done = self.yard.fleet("push", "fleet.toml", "--blob", "good.blob", "--dry-run")
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertEqual(done.stdout.count(NEVER_RAN), 2, done.stdout)
        self.assertIn("no box is fit", done.stderr)
        asked = self.yard.fleet("push", "fleet.toml", "--blob", "good.blob", "--dry-run", "--json")
        self.assertEqual((asked.returncode, sorted(json.loads(asked.stdout)["not_fit"])), (1, ["hall-1", "hall-2"]))
        status = self.yard.fleet("status", "fleet.toml")
        self.assertEqual((status.returncode, status.stderr.count(NEVER_RAN)), (1, 2), status.stderr)
        self.yard.fleet_file(
            fleet_text(PAGES.replace("https://{box}.example.org", "http://127.0.0.1:1").replace(', "p-2"', ""))
        )
        page = self.yard.fleet("status", "fleet.toml")
        self.assertIn("127.0.0.1:1: connection refused", page.stderr)
        for output in (done, asked, status, page):
            self.assertNotIn("Errno", output.stdout + output.stderr)

    def test_two_boxes_behind_one_way_are_refused_with_both_names(self):
        for sound in (SOUND, PAGES, COMMANDS):
            self.yard.fleet_file(fleet_text(sound))
            self.assertIn("no answer", self.yard.fleet("status", "fleet.toml", "--json").stdout)
        write = "write {box} where"
        self.refused_file(SOUND.replace("{box}/", "hall-1/"), "for both hall-1 and hall-2", "group.bench.site", write)
        self.refused_file(PAGES.replace("{box}.", ""), "for both p-1 and p-2", "group.pages.page", write)
        self.refused_file(COMMANDS.replace("@{box}", "@s-1"), "for both s-1 and s-2", "group.ssh.push", write)
        self.refused_file(COMMANDS.replace('"ssh", "{box}"', '"ssh", "s-1"'), "for both", "group.ssh.status", write)
        (self.yard.folder / "again").symlink_to("hall-1")
        for site in ("./hall-1/site.toml", "again/site.toml"):
            other = f'{SOUND}\n[group.other]\nsite = "{site}"\nboxes = ["third"]'
            self.refused_file(other, "for both hall-1 and third", "group.other.site")

    def test_what_is_wrong_in_the_file_comes_with_what_to_write(self):
        self.refused_file(SOUND.replace("[group.bench]", "[bench]"), "found [bench]", "write [group.bench]")
        self.refused_file(SOUND.replace('["hall-1", "hall-2"]', '"hall-1"'), 'write boxes = ["ahu-1", "ahu-2"]')
        self.refused_file(SOUND.replace('"{box}/site.toml"', "3"), 'write site = "{box}/site.toml"')
        self.refused_file("poll_s = 0\n" + SOUND, "fleet.poll_s", "write poll_s = 300")
        self.refused_file("waves = [1, 0.5]\n" + SOUND, "write waves = [0.04, 0.2, 1.0]")
        self.refused_file(COMMANDS.replace('"{blob}", ', ""), "group.ssh.push", 'write push = ["scp"')
        self.refused_file(PAGES.replace("https://", ""), 'write page = "https://')

    def test_missing_keys_say_what_to_copy_and_no_blob_is_named_as_it_was_given(self):
        line = self.complaint("push", "fleet.toml", "--blob", "good.blob", more=SOUND, keys="nowhere")
        self.assertIn("copy a box's keys folder", line)
        self.assertIn("nowhere", line)
        self.yard.fleet_file(fleet_text(SOUND))
        for name, content in (("text.blob", b"no weights at all\n" * 40), ("short.blob", b"abc"), ("none.blob", b"")):
            (self.yard.folder / name).write_bytes(content)
            line = self.complaint("push", "fleet.toml", "--blob", name)
            self.assertTrue(line.startswith(f"airside fleet: {name}"), line)
            self.assertNotIn("/", line.split("; ")[0])
            self.assertEqual(line.count("found "), 1, line)

    def test_undo_of_an_unknown_push_leaves_nothing(self):
        self.assertIn("0 pushes of 01234567", self.complaint("undo", "fleet.toml", "01234567"))

    def test_usage_after_an_error_is_that_of_the_action(self):
        for words in (("push", "--blbo", "x"), ("push",), ("push", "fleet.toml"), ("undo", "fleet.toml"), ("status",)):
            done = self.yard.fleet(*words)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertTrue(done.stderr.startswith(f"usage: airside fleet {words[0]} "), done.stderr)

    def test_help_of_the_program_names_values(self):
        asked = [str(BIN / "airside"), "fleet", "push", "--help"]
        help_text = subprocess.run(asked, capture_output=True, text=True, check=True).stdout
        for value in ("--blob FILE", "--from-library DIGEST", "--library ADDRESS", "--by NAME", "--at-least SERIAL"):
            self.assertRegex(help_text, rf"(?m)^  {value} ")


if __name__ == "__main__":
    unittest.main()
