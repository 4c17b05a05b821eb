"""On a local Ray cluster of several node processes, one of which is killed in the middle: nothing is lost, nothing is
done twice, and all bytes are those of a serial run. AIRSIDE_CAMPAIGN_JOBS sets how many jobs (40; 200 in
docs/campaigns.md)."""

import json
import os
import subprocess
import sys
import time
import unittest

from desk import SHORT, Desk

JOBS = int(os.environ.get("AIRSIDE_CAMPAIGN_JOBS", "40"))


def campaign():
    seeds = list(range(1, JOBS // 2 + 1))
    return (
        f'[campaign]\nout = "runs"\n[[job]]\nname = "day-{{room}}-{{seed}}"\nrun = {SHORT}\n'
        f'over = {{room = ["301", "401"], seed = {seeds}}}\n'
    )


class Cluster(unittest.TestCase):
    def test_a_node_that_is_killed_costs_nothing(self):
        from ray.cluster_utils import Cluster as LocalCluster

        serial = Desk(self)
        serial.write(campaign())
        self.assertEqual(serial.run("--serial").returncode, 0)
        os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
        cluster = LocalCluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
        self.addCleanup(cluster.shutdown)
        nodes = [cluster.add_node(num_cpus=1) for _ in range(3)]
        desk = Desk(self)
        desk.write(campaign())
        child = subprocess.Popen(
            desk.words("--address", cluster.address, "--json"),
            env=desk.environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        deadline = time.monotonic() + 120
        while len(list((desk.folder / "runs" / "jobs").glob("[0-9a-f]*"))) < JOBS // 4 and time.monotonic() < deadline:
            time.sleep(0.05)
        killed_at = len(list((desk.folder / "runs" / "jobs").glob("[0-9a-f]*")))
        cluster.remove_node(nodes[0], allow_graceful=False)
        out, err = child.communicate(timeout=500)
        self.assertEqual(child.returncode, 0, err)
        self.assertTrue(JOBS // 4 <= killed_at < JOBS, "killed in the middle")
        self.assertEqual(json.loads(out)["done"], JOBS)
        self.assertEqual(desk.files(), serial.files())
        self.assertEqual(
            (desk.folder / "runs" / "results.parquet").read_bytes(),
            (serial.folder / "runs" / "results.parquet").read_bytes(),
        )

    def test_a_job_that_no_machine_can_hold_is_refused_before_anything_runs(self):
        desk = Desk(self)
        desk.write(campaign() + "cpus = 5\n")
        done = desk.run("--jobs", "2")
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertRegex(done.stderr, r"job 1: cpus: found 5; expected at most 2, as .*; lower it, or raise --jobs")
        self.assertEqual(desk.files(), {})

    def test_without_an_address_no_other_cluster_is_joined(self):
        desk = Desk(self)
        run = SHORT.replace("{room}", "301").replace("{seed}", "1")
        desk.write(f'[campaign]\nout = "runs"\n[[job]]\nname = "a"\nrun = {run}\n')
        desk.environment["RAY_ADDRESS"] = "127.0.0.1:1"
        done = desk.run("--jobs", "1")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_what_goes_to_other_machines_needs_no_package_there(self):
        send = (
            "import sys, ray; from airside_campaign import one_job, run\n"
            "for module in run.SENT: ray.cloudpickle.register_pickle_by_value(module)\n"
            "sys.stdout.buffer.write(ray.cloudpickle.dumps(one_job.run_one))"
        )
        take = (
            "import pickle, sys; run_one = pickle.load(sys.stdin.buffer)\n"
            "print(run_one({'key': 'k', 'out': '/nonexistent', 'token': ''})['why'])\n"
            "print(run_one.__globals__['used_by'](sys.executable)['airside'])"
        )
        desk = Desk(self)
        sent = subprocess.run([sys.executable, "-c", send], env=desk.environment, capture_output=True, check=True)
        bare = {k: v for k, v in desk.environment.items() if k != "PYTHONPATH"}
        words = [sys.executable, "-c", take]
        said = subprocess.run(words, env=bare, input=sent.stdout, cwd=desk.folder, capture_output=True, check=True)
        self.assertRegex(said.stdout.decode(), r"does not see /nonexistent;.*\n[0-9a-f]{64}\n")

    def test_no_cluster_at_the_address(self):
        desk = Desk(self)
        desk.write(campaign())
        desk.environment["RAY_gcs_rpc_server_reconnect_timeout_s"] = "1"
        done = desk.run("--address", "127.0.0.1:1")
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("--address: found no cluster at 127.0.0.1:1", done.stderr)
        self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main()
