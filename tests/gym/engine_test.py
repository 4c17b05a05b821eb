"""EnergyPlus rooms, and a site that `airside adopt` makes of a model that the project did not write."""

import importlib.util
import os
import pathlib
import tempfile
import unittest

import numpy as np
from airside_gym.scores import Scores
from desk import airside, ends, environment, episode, needs_engine, passes_the_checker, setpoint, simulated

MODEL, AIR_LOOP = "RefBldgSmallOfficeNew2004_Chicago.idf", "PSZ-AC:1"


def setUpModule():
    needs_engine()


def foreign_model():
    """The file of the reference building; skips where its package is not installed."""
    named = os.environ.get("AIRSIDE_FOREIGN_MODELS")
    package = importlib.util.find_spec("pyenergyplus")
    places = (package.submodule_search_locations or ()) if package else ()
    folders = [named] if named else [os.path.join(place, "data", "model") for place in places]
    for folder in folders:
        if (pathlib.Path(folder) / MODEL).is_file():
            return str(pathlib.Path(folder) / MODEL)
    raise unittest.SkipTest("the reference buildings are not installed: run tools/setup --for test, or name their "
                            "folder in AIRSIDE_FOREIGN_MODELS. This test checked nothing.")


def same_bits_twice(test, env):
    rng = np.random.default_rng(2)
    actions = rng.uniform(env.action_space.low[0], env.action_space.high[0], (80, 1)).astype(np.float32)
    first, again = (episode(env, lambda i: actions[i], 6) for _ in range(2))
    test.assertEqual(first[0].tobytes(), again[0].tobytes())


def constant_is_as_simulated(test, env, told):
    """Where told is the report of `airside simulate --method constant-22.5` with seed 3 on the days of env."""
    _, _, infos = episode(env, lambda _: setpoint(22.5), 3)
    scores = Scores(env.unwrapped.target_degc)
    for before, after in zip(infos, infos[1:]):
        scores.add(before, after)
    test.assertAlmostEqual(scores.figures()["dae_degc"], told["dae_degc"], places=9)


class EnergyPlus(unittest.TestCase):
    def test_gymnasium_has_nothing_to_complain_of(self):
        with environment("EnergyPlus", days=1) as env:
            passes_the_checker(env)

    def test_same_seed_and_actions_give_the_same_bits(self):
        with environment("EnergyPlus", days=1, room="301-real") as env:
            same_bits_twice(self, env)

    def test_a_constant_scores_as_in_the_simulation(self):
        choices = {"room": "301-real", "start": "2021-08-01", "days": 3}
        told = simulated("--plant", "energyplus", "--room", "301-real", "--method", "constant-22.5", "--seed", "3",
                         "--expert-days", "2", "--days", "3")
        with environment("EnergyPlus", expert_days=2, **choices) as env:
            constant_is_as_simulated(self, env, told)

    def test_closing_in_the_middle_of_a_day_ends_the_engine_too(self):
        env = environment("EnergyPlus", days=2)
        env.reset(seed=1)
        env.step(setpoint(22))
        pid = env.unwrapped.child_pid
        engines = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8").split()
        self.assertTrue(engines)
        env.close()
        for engine in (pid, *engines):
            self.assertTrue(ends(engine))


class Adopted(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        model = foreign_model()
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.site = os.path.join(folder.name, "office")
        airside("adopt", model, "--air-loop", AIR_LOOP, "-o", cls.site)

    def environment(self, **choices):
        return environment("Site", site=self.site, start="2021-07-05", **choices)

    def test_gymnasium_has_nothing_to_complain_of(self):
        with self.environment(days=1) as env:
            passes_the_checker(env)

    def test_same_seed_and_actions_give_the_same_bits(self):
        with self.environment(days=1) as env:
            same_bits_twice(self, env)

    def test_a_constant_scores_as_in_the_simulation(self):
        told = simulated("--site", os.path.join(self.site, "site.toml"), "--twin", "--method", "constant-22.5",
                         "--seed", "3", "--start", "2021-07-05", "--expert-days", "0", "--days", "2")
        with self.environment(days=2) as env:
            constant_is_as_simulated(self, env, told)

    def test_signals_range_and_hours_are_those_of_the_site(self):
        with self.environment(days=6) as env:  # 5 July is a Monday
            names, low, high = env.unwrapped.signal_names, env.action_space.low[0], env.action_space.high[0]
            self.assertIn("zone_setpoint_1", names)
            self.assertNotIn("room_temp_2", names)
            self.assertLess(low, high)
            _, rewards, infos = episode(env, lambda _: setpoint((low + high) / 2), 1)
        scored = {info["time"][:10] for info in infos if info["scored"]}
        self.assertEqual(scored, {f"2021-07-{day:02}" for day in range(5, 10)})
        self.assertTrue((rewards[400:] == 0).all(), "Saturday is a day off")
