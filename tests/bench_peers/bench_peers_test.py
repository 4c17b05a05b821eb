"""tools/bench-peers: the peers' equations against the golden vectors, and a whole run beside NumPy."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TOOL = ROOT / "tools/bench-peers"
sys.path.insert(0, str(ROOT / "tools/bench_peers"))
import closed_form
import golden
import peers

BIN = Path(os.environ["AIRSIDE_BIN"])


def tool(*words):
    command = [str(TOOL), "--bin", str(BIN), "--venv", sys.prefix, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


class Equations(unittest.TestCase):
    def setUp(self):
        self.weights, self.rows = golden.weights("weights"), golden.batch(32)

    def test_forecasts_are_the_golden_ones(self):
        found = closed_form.graph(peers.NumpyOps, self.weights, self.rows[:, : golden.INPUTS])
        for one, known in zip(found, golden.forecasts_of_32()):
            np.testing.assert_allclose(one, known, atol=1e-7)

    def test_a_decision_is_the_graph_of_rows_that_share_their_state(self):
        state, setpoints = self.rows[:1, : golden.SIGNALS], self.rows[:7, golden.SIGNALS : golden.INPUTS]
        inputs = np.concatenate([np.repeat(state, 7, 0), setpoints], 1)
        found = closed_form.decide(peers.NumpyOps, self.weights, state, setpoints, peers.NumpyOps.repeated)
        for one, known in zip(found, closed_form.graph(peers.NumpyOps, self.weights, inputs)):
            np.testing.assert_allclose(one, known, atol=1e-7)

    def test_the_gradient_by_hand_is_the_golden_one(self):
        found = closed_form.gradient(
            peers.NumpyOps, self.weights, golden.weights("target_weights"), self.rows, golden.LABELS
        )
        np.testing.assert_allclose(golden.flat(found), golden.gradient_of_32(), atol=1e-6)

    def test_a_peer_that_computes_something_else_is_not_timed(self):
        class Wrong(peers.Numpy):
            def gradient(self, rows):
                return super().gradient(rows * np.float32(1.001))

        self.assertLess(peers.Numpy().check(), peers.ALLOWED)
        with self.assertRaisesRegex(SystemExit, "Wrong: differs by .* golden vectors"):
            Wrong().check()


class Run(unittest.TestCase):
    def test_rows_ratios_and_file_agree(self):
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder) / "peers.json"
            done = tool("--only", "numpy", "--rounds", 1, "--seconds", 0.002, "--json", place)
            self.assertEqual(done.returncode, 0, done.stderr)
            data = json.loads(place.read_text(encoding="utf-8"))
        figures = {(f["row"], f["kind"], f["count"]): f for f in data["figures"]}
        for kind, counts in peers.KINDS.items():
            for count in counts:
                ours, other = figures["airside_strict", kind, count], figures["numpy", kind, count]
                (line,) = (r for r in data["ratios"] if r["row"] == "airside_strict" and r["work"] == f"{kind} {count}")
                self.assertEqual(line["median_us"]["peer"], "numpy")
                self.assertAlmostEqual(line["median_us"]["ratio"], other["median_us"] / ours["median_us"])
                self.assertLessEqual(other["min_us"], other["median_us"])
        self.assertIn("| numpy: gradient by hand, OpenBLAS |", done.stdout)
        self.assertIn("| airside_strict | step 1000 |", done.stdout)

    def test_wrong_words_are_refused_before_anything_is_timed(self):
        for words, said in (
            (("--only", "caffe"), "--only caffe: expected some of numpy, torch"),
            (("--only", "numpy", "--kernels", "foo"), "--kernels foo: expected one of best, strict"),
            (("--only", "numpy", "--venv", "/proc/x"), "--venv /proc/x: found no Python environment and could not make one"),
            (("--rounds", 0), "--rounds 0"),
            (("--chart", "peers.pdf"), "expected a name that ends in .svg or .png"),
            (("--json", "/no/such/folder/peers.json"), "found no folder /no/such/folder"),
            (("--bin", "/no/such/folder"), "/no/such/folder/airside-bench: found no such program"),
        ):
            done = tool(*words)
            self.assertEqual(done.returncode, 1)
            self.assertIn(said, done.stderr)
            self.assertEqual(done.stdout, "")
            self.assertNotIn("Traceback", done.stderr)

    def test_what_the_program_complains_of_is_passed_on(self):
        with tempfile.TemporaryDirectory() as folder:
            bench = Path(folder) / "airside-bench"
            bench.write_text("#!/bin/sh\necho 'this CPU has no avx512' >&2\nexit 1\n", encoding="utf-8")
            bench.chmod(0o755)
            done = tool("--bin", folder, "--only", "numpy", "--kernels", "avx512")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "tools/bench-peers: .*airside-bench --peers --kernels avx512.*: this CPU has no avx512\n$")
        self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main()
