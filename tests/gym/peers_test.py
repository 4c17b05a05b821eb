"""Stable-Baselines3 learns on the environments, and the script that compares runs; skipped where it is missing."""

import importlib.util
import json
import subprocess
import sys
import unittest
from pathlib import Path

from desk import PROGRAM, environment

SCRIPT = Path(__file__).resolve().parents[2] / "tools" / "gym" / "train_peers"
PACKAGES = importlib.util.find_spec("torch") and importlib.util.find_spec("stable_baselines3")


class Alone(unittest.TestCase):
    def test_help_needs_no_package(self):
        done = subprocess.run([sys.executable, "-S", "-B", SCRIPT, "--help"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("--training-seeds", done.stdout)


@unittest.skipUnless(PACKAGES, "torch and stable-baselines3 are not installed: install them with pip into a Python that has "
                     "gymnasium, and name it in AIRSIDE_GYM_PYTHON. This test checked nothing.")
class Peers(unittest.TestCase):
    def test_dqn_learns_for_some_hundred_steps(self):
        from stable_baselines3 import DQN

        with environment("Rc", days=3, discrete_step_k=0.5) as env:
            agent = DQN("MlpPolicy", env, learning_starts=50, seed=1, device="cpu")
            before = {name: value.clone() for name, value in agent.policy.state_dict().items()}
            agent.learn(400)
            self.assertEqual(agent.num_timesteps, 400)
            self.assertTrue(any((before[name] != value).any() for name, value in agent.policy.state_dict().items()))

    def test_the_comparison_has_a_row_for_each_method_and_room(self):
        done = subprocess.run(
            [sys.executable, "-B", SCRIPT, "--airside", PROGRAM, "--steps", "300", "--score-days", "1", "--seeds", "1",
             "--rooms", "301-real", "--json"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = json.loads(done.stdout)["rows"]
        self.assertEqual({row["method"] for row in rows}, {"dqn", "sac", "ours", "integral-tuned", "expert"})
        self.assertTrue(all(0 < row["dae_degc"] <= row["me_degc"] < 10 for row in rows))

    def test_what_it_cannot_do_is_refused(self):
        for words, said in ((["--algorithms", "ppo"], "found 'ppo'; expected some of dqn, sac"),
                            (["--days", "0"], "--days: found 0; expected 1 or more"),
                            (["--airside", "/nowhere/airside"], "found no program '/nowhere/airside'")):
            done = subprocess.run([sys.executable, "-B", SCRIPT, *words], capture_output=True, text=True, check=False)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(said, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
