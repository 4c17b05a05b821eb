"""Rooms of the RC plant as environments."""

import unittest

import gymnasium
import numpy as np
from airside_gym.scores import Scores
from desk import environment, episode, passes_the_checker, setpoint, simulated

ROOM = {"room": "301-real", "expert_days": 5}


def scores_of(env, infos):
    scores = Scores(env.unwrapped.target_degc)
    for before, after in zip(infos, infos[1:]):
        scores.add(before, after)
    return scores.figures()


class Rc(unittest.TestCase):
    def test_gymnasium_has_nothing_to_complain_of(self):
        for choices in ({}, {"discrete_step_k": 0.5}, {"movement_penalty": 0.1}):
            with environment("Rc", days=2, **choices) as env:
                passes_the_checker(env)

    def test_same_seed_and_actions_give_the_same_bits_and_another_seed_others(self):
        actions = np.random.default_rng(4).uniform(20, 26, (240, 1)).astype(np.float32)
        with environment("Rc", days=3, **ROOM) as env:
            first, again, other = (episode(env, lambda i: actions[i], seed) for seed in (7, 7, 8))
        self.assertEqual(first[0].tobytes(), again[0].tobytes())
        self.assertEqual(first[1].tobytes(), again[1].tobytes())
        self.assertEqual(first[2][1:], again[2][1:])
        self.assertNotEqual(first[0].tobytes(), other[0].tobytes())

    def test_reset_without_a_seed_goes_on_with_further_runs(self):
        with environment("Rc", days=1) as env:
            drawn = [env.reset(seed=5)[1]["seed"]] + [env.reset()[1]["seed"] for _ in range(2)]
            self.assertEqual(drawn[0], 5)
            self.assertEqual(len(set(drawn)), 3)
            self.assertEqual(drawn, [env.reset(seed=5)[1]["seed"]] + [env.reset()[1]["seed"] for _ in range(2)])

    def test_a_constant_scores_as_in_the_simulation(self):
        told = simulated("--plant", "rc", "--room", "301-real", "--method", "constant-22.5", "--seed", "3",
                         "--days", "7")
        with environment("Rc", days=7, **ROOM) as env:
            _, rewards, infos = episode(env, lambda _: setpoint(22.5), 3)
            self.assertAlmostEqual(scores_of(env, infos)["dae_degc"], told["dae_degc"], places=9)
        self.assertAlmostEqual(infos[-1]["energy_kwh"], told["hvac_kwh"], places=2)
        self.assertAlmostEqual(-rewards.sum() / np.count_nonzero(rewards), told["dae_degc"], places=9)

    def test_setpoints_of_a_method_give_its_figures_again(self):
        told = simulated("--plant", "rc", "--room", "study-0", "--method", "integral-tuned", "--days", "7")
        with environment("Rc", room="study-0", days=7, expert_days=5) as env:
            _, _, infos = episode(env, lambda i: setpoint(told["setpoint_degc"][i]), 1)
            figures = scores_of(env, infos)
        for name, value in figures.items():
            self.assertAlmostEqual(value, told[name], places=9, msg=name)

    def test_a_random_agent_lives_seven_days(self):
        with environment("Rc", days=7) as env:
            env.action_space.seed(1)
            observations, rewards, infos = episode(env, lambda _: env.action_space.sample(), 1)
            self.assertTrue(all(env.observation_space.contains(o) for o in observations))
        self.assertEqual(len(rewards), 7 * 80)
        self.assertTrue((rewards <= 0).all())
        self.assertEqual(infos[-1]["time"], "2021-08-08T00:00:00")

    def test_names_and_units_belong_to_the_observation(self):
        with environment("Rc", days=1, start="2021-08-07") as env:
            observation, info = env.reset(seed=1)
            told = dict(zip(env.unwrapped.signal_names, observation.tolist(), strict=True))
            units = dict(zip(env.unwrapped.signal_names, env.unwrapped.signal_units, strict=True))
        rooms = [told[f"room_temp_{n}"] for n in range(1, 6)]
        self.assertAlmostEqual(np.mean(rooms), info["room_mean_degc"], places=5)
        self.assertEqual((told["time_of_day_sin"], told["time_of_day_cos"], told["weekend"]), (0, 1, 1))
        self.assertEqual((units["room_temp_1"], units["power_1"], units["weekend"]), ("degc", "kw", ""))

    def test_movement_costs_what_was_asked(self):
        choose = (22.0, 24.0, 24.0, 21.0)
        with environment("Rc", days=1, movement_penalty=0.5) as env:
            env.reset(seed=1)
            rewards = [env.step(setpoint(degc))[1] for degc in choose]
        self.assertEqual(rewards[1:], [-1.0, 0.0, -1.5])

    def test_discrete_actions_are_setpoints(self):
        with environment("Rc", days=1, discrete_step_k=0.5) as env:
            self.assertEqual(env.action_space.n, 13)
            env.reset(seed=1)
            for action in (0, 5, 12):
                info = env.step(action)[4]
                self.assertEqual(info["setpoint_degc"], env.unwrapped.setpoints_degc[action])
            self.assertEqual(env.unwrapped.setpoints_degc[::6], (20.0, 23.0, 26.0))

    def test_setpoints_beyond_the_site_s_range_are_taken_to_its_end(self):
        with environment("Rc", days=1) as env:
            env.reset(seed=1)
            self.assertEqual(env.step(setpoint(5))[4]["setpoint_degc"], 20.0)
            self.assertEqual(env.step(setpoint(50))[4]["setpoint_degc"], 26.0)

    def test_options_of_reset_hold_for_one_episode(self):
        with environment("Rc", days=3, room="301") as env:
            chosen = {"room": "402-real", "start": "2021-06-01", "days": 1, "expert_days": 2}
            _, info = env.reset(seed=1, options=chosen)
            self.assertEqual(info["time"], "2021-06-03T00:00:00")
            self.assertIn("402-real", info["plant"])
            _, info = env.reset(seed=1)
            self.assertIn("room 301 ", info["plant"])

    def test_several_at_once_do_not_disturb_each_other(self):
        actions = np.random.default_rng(1).uniform(20, 26, (40, 3, 1)).astype(np.float32)
        alone = []
        for k in range(3):
            with environment("Rc", days=1) as env:
                env.reset(seed=10 + k)
                alone.append([env.step(a[k])[0] for a in actions])
        for kind in (gymnasium.vector.SyncVectorEnv, gymnasium.vector.AsyncVectorEnv):
            together = kind([lambda: environment("Rc", days=1)] * 3)
            together.reset(seed=10)
            seen = np.stack([together.step(a)[0] for a in actions])
            together.close()
            self.assertEqual(seen.tobytes(), np.array(alone).transpose(1, 0, 2).tobytes(), kind.__name__)

    def test_a_sensor_without_a_value_keeps_its_last_one_and_is_named(self):
        import pathlib
        import tempfile

        with tempfile.TemporaryDirectory() as folder:
            faults = pathlib.Path(folder) / "faults.csv"
            faults.write_text("begin_h,for_h,fault,signal,magnitude\n1,1,not_a_number,room_temp_2,\n", encoding="utf-8")
            with environment("Rc", days=1, serve_options=("--faults", faults)) as env:
                observations, _, infos = episode(env, lambda _: setpoint(23), 1)
                place = env.unwrapped.signal_names.index("room_temp_2")
        self.assertEqual(infos[3]["missing"], ())
        self.assertEqual(infos[4]["missing"], ("room_temp_2",))
        self.assertEqual(infos[7]["missing"], ())
        self.assertTrue(np.isfinite(observations).all())
        self.assertEqual(observations[4][place], observations[3][place])
