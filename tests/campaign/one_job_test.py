"""A job on a machine: with the same program, folders and files as the machine that the campaign runs from, or not at
all; what it leaves is whole or is run again."""

import json
import os
import re
import shutil
import subprocess
import sys
import unittest
from pathlib import Path
from types import SimpleNamespace

from desk import ROOT, Desk

sys.path.insert(0, str(ROOT / "tools" / "campaign"))
from airside_campaign import one_job, results, run, uses

PROGRAM = '#!/bin/sh\necho "{\\"a\\": 1}"\necho log > log.csv\nif [ -f "$1" ]; then sh "$1"; fi\n'


class OneJob(unittest.TestCase):
    def setUp(self):
        self.desk = Desk(self)
        self.bin = self.desk.folder / "bin"
        self.bin.mkdir()
        for name in ("airside", "airside-energyplus"):
            (self.bin / name).write_text(PROGRAM)
            (self.bin / name).chmod(0o755)
        for name in ("models/twin.epJSON", "effects/library/leak.json"):
            place = self.desk.folder / "share" / "airside" / name
            place.parent.mkdir(parents=True)
            place.write_text(name)
        self.input = self.desk.folder / "input.txt"
        self.input.write_text("true\n")
        self.folder = run.Folder(self.desk.folder / "runs")
        self.addCleanup(lambda: self.folder._lock.close())

    def spec(self, key="k" * 24):
        job = SimpleNamespace(
            name="a", key=key, command=[str(self.input)], timeout_min=1,
            reads={str(self.input): uses.digest_of(str(self.input))},
        )  # fmt: skip
        return self.folder.spec(job, self.bin / "airside", uses.used_by(self.bin / "airside"))

    def fails(self, why, spec):
        record = one_job.run_one(spec)
        self.assertFalse(record["done"])
        self.assertRegex(record["why"], why)
        self.assertFalse(os.path.exists(spec["folder"]))

    def test_a_machine_that_has_not_the_folder_makes_none(self):
        spec = self.spec()
        gone = self.desk.folder / "not-mounted"
        self.fails("does not see .*/not-mounted;", spec | {
            "out": str(gone), "folder": str(gone / "jobs" / "k"), "logs": str(gone / "logs"), "failed": str(gone / "f")
        })  # fmt: skip
        self.assertFalse(gone.exists())
        (gone / "jobs").mkdir(parents=True)  # one of that machine alone, of the same name
        self.fails("does not see", spec | {"out": str(gone), "folder": str(gone / "jobs" / "k")})
        self.assertEqual(list((gone / "jobs").iterdir()), [])
        self.assertTrue(one_job.run_one(spec)["done"])

    def test_what_a_machine_says_is_done_and_is_not_here_is_a_failure(self):
        class Elsewhere(run.Serial):
            def next(self):
                return self._waiting.popleft()["key"], {"key": "k", "done": True, "host": "far"}

        waits, run.time = run.time, SimpleNamespace(sleep=lambda _: None)
        self.addCleanup(setattr, run, "time", waits)
        job = SimpleNamespace(name="a", key="k", command=["x"], timeout_min=1, reads={}, entry=0, after={}, cpus=1)
        campaign = SimpleNamespace(jobs=[job])
        with open(os.devnull, "w", encoding="utf-8") as nobody:
            records = run.run_jobs(campaign, self.folder, self.bin / "airside", {}, Elsewhere(), nobody)
        self.assertFalse(records["a"]["done"])
        self.assertRegex(records["a"]["why"], "far does not see .*/runs")

    def test_results_that_cannot_be_read_are_a_failure_and_no_traceback(self):
        job = SimpleNamespace(name="a", key="k", entry=0, values={})
        (row,) = results.rows_of(SimpleNamespace(jobs=[job]), self.folder, {"a": {"done": True}})
        self.assertFalse(row["done"])
        self.assertRegex(row["why"], "k/stdout: no such file")

    def test_another_version_of_anything_that_the_program_uses_is_named(self):
        share = self.desk.folder / "share" / "airside"
        for place, why in (
            (self.bin / "airside", "another airside at"),
            (self.bin / "airside-energyplus", "another airside-energyplus"),
            (share / "models" / "twin.epJSON", "another models"),
            (share / "effects" / "library" / "leak.json", "another effects"),
        ):
            spec, before = self.spec(), place.read_text()
            place.write_text(before + "# changed\n")
            self.fails(why, spec)
            place.write_text(before)
        spec = self.spec()
        self.addCleanup(os.environ.pop, "AIRSIDE_KERNELS", None)
        os.environ["AIRSIDE_KERNELS"] = "portable"
        self.fails("another AIRSIDE_KERNELS", spec)

    def test_keys_are_of_all_that_the_program_uses_wherever_it_lies(self):
        self.desk.write('[[job]]\nname = "a"\nrun = ["simulate"]\n')

        def key(**environment):
            self.desk.environment = {**os.environ, "PYTHONPATH": str(ROOT / "tools" / "campaign"), **environment}
            words = self.desk.words("--list")
            words[words.index("--program") + 1] = str(self.bin / "airside")
            done = subprocess.run(
                words, cwd=self.desk.folder, capture_output=True, text=True, env=self.desk.environment, check=True
            )  # fmt: skip
            return done.stdout.split()[0]

        first = key()
        share, moved = self.desk.folder / "share" / "airside", self.desk.folder / "moved"
        shutil.copytree(share, moved)
        self.assertEqual(key(AIRSIDE_MODELS=str(moved / "models")), first, "the same content at another place")
        (moved / "effects" / "library" / "leak.json").write_text("other")
        self.assertNotEqual(key(AIRSIDE_MODELS=str(moved / "models")), first)
        self.assertNotEqual(key(AIRSIDE_KERNELS="portable"), first)
        engine = self.desk.folder / "engine"
        engine.mkdir()
        (engine / uses.ENGINE).write_text("engine")
        self.assertNotEqual(key(AIRSIDE_ENERGYPLUS=str(engine)), first)
        (self.bin / "airside-energyplus").write_text(PROGRAM + "# changed\n")
        self.assertNotEqual(key(), first)

    def test_all_variables_that_the_program_reads_are_known(self):
        read = set()
        for folder in ("lib", "hal", "sim", "tools"):
            for source in (ROOT / folder).rglob("*.[ch]pp"):
                text = source.read_text(encoding="utf-8", errors="replace")
                read |= set(re.findall(r'(?:getenv|from_environment)\("(AIRSIDE_\w+)"\)', text))
        self.assertEqual(read, {*uses.PLACES, *uses.VALUES})

    def test_an_input_that_changes_before_or_during_the_run_is_named(self):
        spec = self.spec()
        self.input.write_text("true # edited\n")
        self.fails(f"{self.input} changed meanwhile; run again", spec)
        self.input.write_text(f"echo true > {self.input}\n")
        self.fails(f"{self.input} changed meanwhile; run again", self.spec())
        self.assertTrue(list((self.desk.folder / "runs" / "failed").iterdir()))
        self.assertTrue(one_job.run_one(self.spec())["done"])

    def test_a_job_that_is_not_whole_any_more_is_run_again(self):
        spec = self.spec()
        self.assertEqual(one_job.run_one(spec)["kept"], False)
        self.assertEqual(one_job.run_one(spec)["kept"], True)
        folder = Path(spec["folder"])
        record = json.loads((folder / "job.json").read_text())
        self.assertEqual(record["sizes"], {"log.csv": 4, "stdout": 9})
        self.assertEqual(record["inputs"], spec["reads"])
        for spoil in (lambda: (folder / "log.csv").write_text(""), lambda: (folder / "stdout").unlink()):
            spoil()
            self.assertFalse(one_job.is_done(folder))
            self.assertEqual(one_job.run_one(spec)["kept"], False)
            self.assertEqual(((folder / "log.csv").read_text(), one_job.is_done(folder)), ("log\n", True))

    def test_all_files_are_on_the_disk_before_the_rename_and_the_rename_after(self):
        synced, real = [], os.fsync
        rename = os.rename
        os.fsync = lambda handle: (synced.append(os.readlink(f"/proc/self/fd/{handle}")), real(handle))
        os.rename = lambda old, new: (synced.append("rename"), rename(old, new))
        self.addCleanup(setattr, os, "fsync", real)
        self.addCleanup(setattr, os, "rename", rename)
        self.assertTrue(one_job.run_one(self.spec())["done"])
        before = synced[: synced.index("rename")]
        names = {os.path.basename(name) for name in before}
        self.assertLess({"stdout", "log.csv", "job.json"}, names)
        self.assertTrue(any(name.endswith(".part") for name in before))
        self.assertEqual(synced[-1], str(self.desk.folder / "runs" / "jobs"))

    def test_a_job_of_before_counts_as_done(self):
        spec = self.spec()
        Path(spec["folder"]).mkdir()
        (Path(spec["folder"]) / "job.json").write_text('{"name": "a", "key": "k", "command": []}')
        self.assertEqual(one_job.run_one(spec)["kept"], True)


if __name__ == "__main__":
    unittest.main()
