"""Without Ray: each job once, stopped campaigns go on, failures stay where they are and are named."""

import fcntl
import json
import os
import signal
import subprocess
import time
import unittest

import pyarrow.parquet as pq
from desk import SHORT, Desk

CHAIN = f"""
[campaign]
out = "runs"
[[job]]
name = "train-{{seed}}"
run = ["pretrain", "--plant", "rc", "--days", "2", "--seed", "{{seed}}", "-o", "{{out}}/w.blob", "--json"]
over = {{seed = [1, 2]}}
[[job]]
name = "use-{{seed}}"
after = {{train = "train-{{seed}}"}}
run = ["simulate", "--plant", "rc", "--expert-days", "1", "--days", "1", "--weights", "{{train}}/w.blob", "--transfer",
       "--steps", "5", "--seed", "{{seed}}", "--json"]
over = {{seed = [1, 2]}}
figures = ["dae_degc"]
"""
MANY = f"""
[campaign]
out = "runs"
[[job]]
name = "day-{{room}}-{{seed}}"
run = {SHORT}
over = {{room = ["301", "401"], seed = [1, 2, 3, 4, 5, 6]}}
"""


class Serial(unittest.TestCase):
    def test_what_comes_after_finds_what_it_needs_and_nothing_is_run_twice(self):
        desk = Desk(self)
        desk.write(CHAIN)
        first = desk.run("--serial", "--json")
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertEqual(
            {k: json.loads(first.stdout)[k] for k in ("jobs", "done", "kept")}, {"jobs": 4, "done": 4, "kept": 0}
        )
        self.assertIn("[########################] 4 of 4", first.stderr)
        before = desk.files()
        again = desk.run("--serial", "--json")
        self.assertEqual(json.loads(again.stdout)["kept"], 4)
        self.assertEqual(desk.files(), before)
        table = pq.read_table(desk.folder / "runs" / "results.parquet").to_pydict()
        self.assertEqual(table["job"], ["train-1", "train-2", "use-1", "use-2"])
        self.assertEqual(table["over.seed"], [1, 2, 1, 2])
        printed = json.loads(before[f"{table['key'][2]}/stdout"])
        self.assertEqual(table["dae_degc"][2], printed["dae_degc"])
        page = (desk.folder / "runs" / "index.html").read_text()
        self.assertIn("4 of 4 jobs done", page)
        self.assertIn("dae_degc", page)

    def test_what_fails_is_named_keeps_back_what_needs_it_and_is_tried_again(self):
        desk = Desk(self)
        desk.write(CHAIN.replace('"--days", "2"', '"--days", "2", "--weather", "{dir}/{seed}.epw"'))
        done = desk.run("--serial", "--json")
        self.assertEqual(done.returncode, 1)
        failed = {f["job"]: f["why"] for f in json.loads(done.stdout)["failed"]}
        self.assertEqual(sorted(failed), ["train-1", "train-2", "use-1", "use-2"])
        self.assertIn("exit code 1", failed["train-1"])
        self.assertIn("1.epw", failed["train-1"])
        self.assertEqual(failed["use-1"], "train-1, which it needs, failed")
        self.assertEqual(desk.files(), {})
        self.assertTrue(list((desk.folder / "runs" / "failed").glob("*/stderr")))
        self.assertIn("4 failed", (desk.folder / "runs" / "index.html").read_text())

    def test_a_missing_engine_is_named(self):
        desk = Desk(self)
        desk.write(
            '[[job]]\nname = "a"\nrun = ["simulate", "--plant", "energyplus", "--method", "expert", "--days", "1"]\n'
        )
        desk.environment["AIRSIDE_ENERGYPLUS"] = "/nonexistent"
        done = desk.run("--serial")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "a: exit code 1: airside: .*/nonexistent")

    def test_time_out(self):
        desk = Desk(self)
        desk.write(
            '[[job]]\nname = "a"\ntimeout_min = 0.01\nrun = ["simulate", "--plant", "rc", "--method", "expert", "--days", "300"]\n'
        )
        self.assertIn("a: not done after 0.01 min", desk.run("--serial").stderr)

    def test_killed_at_any_time_it_goes_on_to_the_same_bytes(self):
        whole = Desk(self)
        whole.write(MANY)
        self.assertEqual(whole.run("--serial").returncode, 0)
        desk = Desk(self)
        desk.write(MANY)
        for wait_s in (0.2, 0.4, 0.6):
            child = subprocess.Popen(
                desk.words("--serial"), env=desk.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
            time.sleep(wait_s)
            child.send_signal(signal.SIGKILL)
            child.wait()
        self.assertEqual(desk.run("--serial").returncode, 0)
        self.assertEqual(desk.files(), whole.files())
        self.assertEqual(
            (desk.folder / "runs" / "results.parquet").read_bytes(),
            (whole.folder / "runs" / "results.parquet").read_bytes(),
        )
        self.assertEqual(list((desk.folder / "runs" / "jobs").glob(".*")), [])

    def test_one_campaign_at_a_time(self):
        desk = Desk(self)
        desk.write(CHAIN)
        (desk.folder / "runs").mkdir()
        with open(desk.folder / "runs" / ".lock", "w", encoding="utf-8") as other:
            fcntl.flock(other, fcntl.LOCK_EX)
            refused = desk.run("--serial")
            self.assertEqual(refused.returncode, 1)
            self.assertIn("a campaign that runs in it", refused.stderr)
            self.assertEqual(desk.files(), {})
        self.assertEqual(desk.run("--serial").returncode, 0, "the lock goes with whoever held it")

    @unittest.skipUnless(os.geteuid() == 0, "a full disk takes root, who mounts a small one")
    def test_a_full_disk_leaves_nothing_half_written(self):
        desk = Desk(self)
        (desk.folder / "runs").mkdir()
        if subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=64k", "none", desk.folder / "runs"],
            check=False,
            stderr=subprocess.DEVNULL,
        ).returncode:
            self.skipTest("no small disk can be mounted here")
        try:
            desk.write(CHAIN)
            done = desk.run("--serial")
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, "(?i)no space left|room")
            self.assertEqual(desk.files(), {})
        finally:
            subprocess.run(["umount", desk.folder / "runs"], check=True)


if __name__ == "__main__":
    unittest.main()
