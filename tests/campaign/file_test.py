"""What is wrong with a campaign file is said with place, finding, expectation and remedy, before anything runs."""

import subprocess
import unittest

from desk import BIN, Desk

GOOD = '[campaign]\nout = "runs"\n[[job]]\nname = "a-{x}"\nrun = ["blob", "{x}"]\nover = {x = [1, 2]}\n'

# what is replaced in GOOD, by what, and words that the complaint must have
WRONG = [
    ("[campaign]", "[campaing]", ["campaing", "an unknown key", "write campaign"]),
    ('out = "runs"', 'ouput = "runs"', ["campaign.ouput", "an unknown key", "write out"]),
    ('out = "runs"', "out = 3", ["campaign.out", "3", "a folder's name"]),
    ('out = "runs"', "retries = -1", ["campaign.retries", "-1", "from 0 to 20"]),
    ('out = "runs"', "timeout_min = true", ["campaign.timeout_min", "True", "a number"]),
    ("[[job]]", "[job]", ["job", "at least one [[job]]"]),
    ("over = {x = [1, 2]}", "over = {x = []}", ["job 1: over.x", "[]", "at least one value"]),
    ("over = {x = [1, 2]}", "over = {x = 1}", ["job 1: over.x", "1", "a list"]),
    ("over = {x = [1, 2]}", "over = {x = [1, 1]}", ["job 1: over.x", "a value twice"]),
    ("over = {x = [1, 2]}", "over = {x = [[1]]}", ["job 1: over.x", "texts or numbers"]),
    ("over = {x = [1, 2]}", "over = {out = [1]}", ["job 1: over.out", "a name that is taken"]),
    ('"{x}"]', '"{y}"]', ["job 1: run", "{y}", "one of {x}", "{out}"]),
    ('run = ["blob", "{x}"]', "run = []", ["job 1: run", "[]", "a list of texts"]),
    ('run = ["blob", "{x}"]', 'run = "blob"', ["job 1: run", "a list of texts"]),
    ('name = "a-{x}"', 'name = "a"', ["job 1: name", "a twice", "put every key of over into the name"]),
    ('name = "a-{x}"', 'name = "a/{x}"', ["job 1: name", "a/1", "letters, digits"]),
    ('name = "a-{x}"', 'name = "a-{x}"\nafter = "b-{x}"', ["job 1: after.after", "b-1, which no job is"]),
    ('name = "a-{x}"', 'name = "a-{x}"\nafter = "a-{x}"', ["job 1: after", "wait for each other"]),
    ('name = "a-{x}"', 'name = "a-{x}"\nafter = "b-*"', ["job 1: after.after", "b-*, which no job is", "a pattern"]),
    (
        'name = "a-{x}"\nrun = ["blob", "{x}"]',
        'name = "b-{x}"\nrun = ["blob", "{x}"]\nover = {x = [1, 2]}\n'
        '[[job]]\nname = "c-{x}"\nafter = {p = "b-*", q = "b-*"}\nrun = ["blob", "{x}", "{p}{q}"]',
        ["job 2: run", "two places of several jobs", "one such place in a word"],
    ),
    ('name = "a-{x}"', 'name = "a-{x}"\ninputs = ["no.csv"]', ["job 1: inputs", "no.csv, which is not there"]),
    ('name = "a-{x}"', 'name = "a-{x}"\ncpus = 0', ["job 1: cpus", "0", "from 0.1 to 64"]),
    ("[campaign]", "[campaign", ["campaign.toml", "expected TOML"]),
    (
        'name = "a-{x}"\nrun = ["blob", "{x}"]\nover = {x = [1, 2]}',
        'name = "a-{x}-{seed}"\nrun = ["blob", "{x}"]\nover = {x = [1, 2], seed = [1, 2]}',
        ["job 1: over.seed", "a key that run does not use", "{seed} in run", "or remove it"],
    ),
]


class File(unittest.TestCase):
    def test_each_mistake_is_named_and_nothing_is_made(self):
        for old, new, words in WRONG:
            with self.subTest(new):
                desk = Desk(self)
                self.assertIn(old, GOOD)
                desk.write(GOOD.replace(old, new))
                done = desk.run("--serial")
                self.assertEqual(done.returncode, 1, done.stderr)
                for word in [*words, "found ", "expected "]:
                    self.assertIn(word, done.stderr)
                self.assertEqual([p.name for p in desk.folder.iterdir()], ["campaign.toml"])

    def test_a_file_that_is_none(self):
        desk = Desk(self)
        self.assertIn("no such file", desk.run("--serial", file="none.toml").stderr)
        (desk.folder / "campaign.toml").write_bytes(b"\xff\xfe[")
        self.assertIn("no UTF-8", desk.run("--serial").stderr)

    def test_no_program(self):
        desk = Desk(self)
        desk.write(GOOD)
        done = desk.run("--serial", "--program", "no-such-airside")
        self.assertEqual(done.returncode, 1)
        self.assertIn("--program: found no-such-airside, which is no program here", done.stderr)

    def test_a_command_that_the_program_does_not_have(self):
        desk = Desk(self)
        desk.write(GOOD.replace('"blob", "{x}"', '"simulat", "--seed", "{x}"'))
        for words in (["--list"], ["--serial"]):
            done = desk.run(*words)
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertRegex(done.stderr, r"job 1: run: found simulat, .*expected .*; did you mean simulate\?")
        self.assertFalse((desk.folder / "runs").exists())

    def test_a_folder_that_is_somebody_elses(self):
        desk = Desk(self)
        desk.write(GOOD)
        (desk.folder / "runs").mkdir()
        (desk.folder / "runs" / "index.html").write_text("theirs")
        done = desk.run("--serial")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "runs: found files that no campaign made; expected .*; give another in campaign.out")
        self.assertEqual([p.name for p in (desk.folder / "runs").iterdir()], ["index.html"])

    def test_keys_are_of_content(self):
        desk = Desk(self)
        (desk.folder / "faults.csv").write_text("a\n")
        desk.write(
            '[[job]]\nname = "a"\nrun = ["simulate", "--faults", "faults.csv", "--log", "{out}/log.csv"]\n'
            '[[job]]\nname = "b"\nafter = "a"\nrun = ["report", "{after}/log.csv"]\n'
        )

        def keys():
            return [line.split()[0] for line in desk.run("--list").stdout.splitlines()]

        first = keys()
        self.assertEqual(first, keys())
        (desk.folder / "faults.csv").write_text("b\n")
        second = keys()
        self.assertTrue(first[0] != second[0] and first[1] != second[1], "what comes after it is other work too")
        (desk.folder / "faults.csv").rename(desk.folder / "other.csv")
        (desk.folder / "other.csv").write_text("a\n")
        desk.write((desk.folder / "campaign.toml").read_text().replace("faults.csv", "other.csv"))
        self.assertEqual(first, keys(), "a file's name is nothing")

    def keys(self, desk):
        done = desk.run("--list")
        self.assertEqual(done.returncode, 0, done.stderr)
        return [line.split()[0] for line in done.stdout.splitlines()]

    def test_a_key_of_over_may_be_used_by_the_job_before(self):
        desk = Desk(self)
        desk.write(
            '[[job]]\nname = "a-{x}"\nrun = ["blob", "{x}"]\nover = {x = [1, 2]}\n'
            '[[job]]\nname = "b-{x}"\nafter = "a-{x}"\nrun = ["blob", "{after}"]\nover = {x = [1, 2]}\n'
        )
        self.assertEqual(len(set(self.keys(desk))), 4)

    def test_keys_know_files_of_options_and_those_that_a_site_file_names(self):
        desk = Desk(self)
        site = '[site]\npoints = "plan/points.csv"\n[weights]\nblob = ["w.blob"]\nnext = "other.toml"\n'
        desk.write(site, "site.toml")
        desk.write('more = "deep.csv"\n', "other.toml")
        (desk.folder / "plan").mkdir()
        texts = {"plan/points.csv": "a", "w.blob": "b", "deep.csv": "c"}
        for name, text in texts.items():
            desk.write(text, name)
        desk.write('[[job]]\nname = "a"\nrun = ["simulate", "--site={dir}/site.toml"]\n')
        seen = [self.keys(desk)]
        for name in texts:
            desk.write("changed", name)
            self.assertNotIn(self.keys(desk), seen, name)
            seen.append(self.keys(desk))
            desk.write(texts[name], name)
        self.assertEqual(self.keys(desk), seen[0])
        desk.write(site + "# changed\n", "site.toml")
        self.assertNotIn(self.keys(desk), seen)

    def test_the_program_itself_hands_over(self):
        desk = Desk(self)
        airside = (BIN / "airside").resolve()

        def run(path, *words):
            return subprocess.run(
                [airside, "campaign", *words], capture_output=True, text=True, check=False, env={"PATH": path}
            )

        self.assertIn("--address", run("/nonexistent", "--help").stdout)
        missing = run("/nonexistent", "c.toml")
        self.assertEqual(missing.returncode, 1)
        self.assertIn("found no program airside-campaign that can be run (No such file", missing.stderr)
        self.assertIn("pip install ./tools/campaign", missing.stderr)
        self.assertEqual(run("/nonexistent", "c.toml", "--jobs", "0").returncode, 2)
        script = desk.folder / "airside-campaign"
        script.write_text('#!/bin/sh\necho "$*"\nexit 3\n')
        script.chmod(0o755)
        done = run(f"{desk.folder}:/usr/bin:/bin", "c.toml", "--jobs", "2", "--list")
        self.assertEqual(done.returncode, 3)
        self.assertEqual(done.stdout, f"--program {airside} --jobs 2 --list -- c.toml\n")

    def test_the_example_is_a_campaign(self):
        desk = Desk(self)
        desk.write(desk.run("--example").stdout)
        listed = desk.run("--list")
        self.assertEqual(listed.returncode, 0, listed.stderr)
        self.assertEqual(len(listed.stdout.splitlines()), 12)


if __name__ == "__main__":
    unittest.main()
