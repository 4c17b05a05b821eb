"""Bad input is refused with what was found, expected and to do; what the program refuses, in its own words."""

import gc
import pathlib
import sys
import tempfile
import unittest
import warnings

import numpy as np
from airside_gym import AirsideError
from desk import airside, environment, setpoint


class Complaint(unittest.TestCase):
    def refused(self, words, call):
        with self.assertRaisesRegex(AirsideError, words):
            call()

    def refused_at_reset(self, words, options=None, **choices):
        env = environment("Rc", **choices)
        self.refused(words, lambda: env.reset(options=options))
        self.assertIsNone(env.unwrapped.child_pid)
        env.close()

    def test_a_program_that_is_missing_is_named_with_the_remedy(self):
        self.refused("found no program '/nowhere/airside'; expected the program airside; build it",
                     lambda: environment("Rc", airside="/nowhere/airside"))

    def test_what_the_program_refuses_comes_in_its_own_words(self):
        self.refused_at_reset("airside: --room: found room \"attic\"; expected one of", room="attic")
        self.refused_at_reset("airside: --start: found '2021-13-01'; expected a date", start="2021-13-01")
        self.refused_at_reset("--room: found room \"attic\"", options={"room": "attic"})
        self.refused_at_reset("--no-such-word", serve_options=["--no-such-word"])
        self.refused_at_reset("--days", days=0)
        self.refused("--topology|topology", lambda: environment("Rc", topology="5vav"))

    def test_options_that_no_episode_has_are_listed(self):
        self.refused_at_reset("reset: options: found weather, site; expected days, expert_days|found site, weather",
                              options={"site": 1, "weather": 2})

    def test_serve_options_are_a_list_of_words(self):
        said = r"serve_options: found '--weekends --speed 1'; expected a list of words .*write \('--weekends', '--speed', '1'\)"
        self.refused(said, lambda: environment("Rc", serve_options="--weekends --speed 1"))
        self.refused("serve_options: found 3; expected a list", lambda: environment("Rc", serve_options=3))
        self.refused_at_reset("serve_options: found '--weekends'", options={"serve_options": "--weekends"})

    def test_a_refused_environment_leaves_no_folder(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error", ResourceWarning)
            caught = []
            sys.unraisablehook, hook = caught.append, sys.unraisablehook
            try:
                for choices in ({"movement_penalty": -1}, {"discrete_step_k": 9}, {"topology": "5vav"}, {"site": "/nowhere"},
                                {"serve_options": "--weekends"}):
                    with self.assertRaises(AirsideError):
                        environment("Rc", **choices)
                gc.collect()
            finally:
                sys.unraisablehook = hook
        self.assertEqual(caught, [])

    def test_numbers_that_make_no_sense_are_refused(self):
        self.refused("movement_penalty: found '1'; expected 0 or more .*number", lambda: environment("Rc", movement_penalty="1"))
        self.refused("discrete_step_k: found '1'", lambda: environment("Rc", discrete_step_k="1"))
        self.refused("movement_penalty: found -1", lambda: environment("Rc", movement_penalty=-1))
        for step_k in (0, -0.5, 7):
            self.refused("discrete_step_k: found .* up to 6 K", lambda s=step_k: environment("Rc", discrete_step_k=s))

    def test_actions_that_are_no_setpoint_are_refused_and_the_episode_goes_on(self):
        with environment("Rc", days=1) as env:
            env.reset(seed=1)
            for action in (setpoint(np.nan), setpoint(np.inf), np.zeros(2), np.zeros(0)):
                self.refused("action: found .*; expected one finite setpoint", lambda a=action: env.step(a))
            env.step(setpoint(22))
        with environment("Rc", days=1, discrete_step_k=0.5) as env:
            env.reset(seed=1)
            for action in (-1, 13, 0.5):
                self.refused("action: found .*; expected a number from 0 to 12", lambda a=action: env.step(a))

    def test_a_step_after_the_last_day_is_refused(self):
        with environment("Rc", days=1) as env:
            env.reset(seed=1)
            for _ in range(80):
                over = env.step(setpoint(22))[3]
            self.assertTrue(over)
            self.refused("an episode that is over", lambda: env.step(setpoint(22)))

    def test_a_plant_that_does_not_wait_is_refused(self):
        with environment("Rc", days=1, serve_options=("--speed", "1")) as env:
            env.reset(seed=1)
            self.refused("the plant did not go on", lambda: env.step(setpoint(22)))

    def test_sites_that_cannot_be_simulated_are_refused(self):
        self.refused("airside/Site-v0: found no site", lambda: environment("Site"))
        self.refused("/nowhere: found no site file", lambda: environment("Site", site="/nowhere"))
        with tempfile.TemporaryDirectory() as folder:
            airside("init", folder)
            site, points = pathlib.Path(folder) / "site.toml", pathlib.Path(folder) / "points.csv"
            right, mapped = site.read_text(encoding="utf-8"), points.read_text(encoding="utf-8")
            site.write_text(right.replace("points =", "# points ="), encoding="utf-8")
            self.refused(r"no point map under \[modbus\]", lambda: environment("Site", site=folder))
            site.write_text("not toml", encoding="utf-8")
            self.refused("no site file", lambda: environment("Site", site=site))
            site.write_text(right, encoding="utf-8")
            points.write_text(mapped.replace("clock_advance_s,", "# clock_advance_s,"), encoding="utf-8")
            self.refused("no point clock_advance_s", lambda: environment("Site", site=folder))
            points.write_text(mapped.replace("room_temp_1,degc,4,0", "room_temp_1,degc,four,0"), encoding="utf-8")
            self.refused("points.csv: found no point map", lambda: environment("Site", site=folder))
