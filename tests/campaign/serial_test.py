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

    def test_a_failure_has_its_cause_and_its_command(self):
        desk = Desk(self)
        desk.write(
            "#!/bin/sh\ncase $2 in one | two) ;; *) exit 0 ;; esac\n"
            "echo Could not convert: $2 >&2\necho Run with --help for more information. >&2\nexit 2\n",
            "program",
        )
        (desk.folder / "program").chmod(0o755)
        text = '[campaign]\nout = "runs"\n[[job]]\nname = "day-{seed}"\nrun = ["day", "{seed}"]\n'
        desk.write(text + 'over = {seed = [1, "one"]}\n')
        done = desk.run("--serial", "--program", str(desk.folder / "program"))
        self.assertIn("day-one: exit code 2: Could not convert: one\n", done.stderr)
        self.assertNotIn("of no job of this file", done.stderr)
        self.assertEqual(desk.commands("runs/failed"), {"day-one": ["day", "one"]})
        first = next((desk.folder / "runs" / "failed").iterdir()).name
        desk.write(text + 'over = {seed = [1, "two"]}\n')
        done = desk.run("--serial", "--program", str(desk.folder / "program"))
        self.assertIn("1 of 2 jobs failed", done.stderr)
        self.assertIn(f"of no job of this file, so free to be deleted: {first}\n", done.stderr)

    def test_what_a_failed_try_left_goes_when_the_job_is_done(self):
        desk = Desk(self)
        long = '[campaign]\nout = "runs"\ntimeout_min = {}\n[[job]]\nname = "a"\n' + (
            'run = ["pretrain", "--plant", "rc", "--days", "20", "-o", "{{out}}/w.blob"]\n'
        )
        desk.write(long.format(0.01))
        self.assertIn("1 of 1 jobs failed", desk.run("--serial").stderr)
        self.assertIn("a", desk.commands("runs/failed"))
        desk.write(long.format(5))
        done = desk.run("--serial")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(desk.commands("runs/failed"), {})
        self.assertIn("a", desk.commands())

    def test_a_figure_that_no_job_prints_is_named(self):
        desk = Desk(self)
        desk.write(CHAIN.replace('["dae_degc"]', '["dae", "darv_degc"]'))
        done = desk.run("--serial")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"job 2: figures: found dae, which no job printed; expected .*; did you mean dae_degc\?")
        self.assertEqual(done.stderr.count("figures: found"), 1)

    def test_ray_is_not_started_where_nothing_is_open(self):
        desk = Desk(self)
        desk.write(CHAIN)
        (desk.folder / "ray.py").write_text("raise ImportError('it was started')\n")
        desk.environment["PYTHONPATH"] += os.pathsep + str(desk.folder)
        self.assertIn("it was started", desk.run().stderr)
        self.assertEqual(desk.run("--serial").returncode, 0)
        again = desk.run()
        self.assertEqual(again.returncode, 0, again.stderr)

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
            '[[job]]\nname = "a"\ntimeout_min = 0.01\nrun = ["serve", "--plant", "rc", "--port", "0"]\n'
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
