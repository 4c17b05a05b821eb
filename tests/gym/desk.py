"""What the tests of the environments share."""

import json
import os
import subprocess
import time
import unittest
import warnings

import airside_gym  # noqa: F401  registers the environments
import gymnasium
import numpy as np

PROGRAM = os.environ["AIRSIDE_PROGRAM"]


def environment(name, **choices):
    return gymnasium.make(f"airside/{name}-v0", disable_env_checker=True, **choices)


def airside(*arguments):
    """Standard output of the program; what it complains of fails the test."""
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(f"airside {' '.join(arguments)}: {done.stderr}")
    return done.stdout


def simulated(*arguments):
    return json.loads(airside("simulate", *arguments, "--json"))


def needs_engine():
    """Skips where EnergyPlus is not installed."""
    done = subprocess.run([PROGRAM, "simulate", "--plant", "energyplus", "--method", "expert", "--days", "1",
                           "--expert-days", "0"], capture_output=True, text=True, check=False)
    if "EnergyPlus engine: found no" in done.stderr:
        raise unittest.SkipTest("EnergyPlus is not installed: run tools/setup, or set AIRSIDE_VENV or "
                                "AIRSIDE_ENERGYPLUS. This test checked nothing.")


def is_running(pid):
    """Whether the process is there and no zombie."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def ends(pid, within_s=30):
    until = time.monotonic() + within_s
    while is_running(pid):
        if time.monotonic() > until:
            return False
        time.sleep(0.02)
    return True


def setpoint(degc):
    return np.array([degc], dtype=np.float32)


def episode(env, choose, seed):
    """(observations, rewards, infos) of a whole episode; infos[0] is that of reset()."""
    observation, info = env.reset(seed=seed)
    observations, rewards, infos, over = [observation], [], [info], False
    while not over:
        observation, reward, terminated, over, info = env.step(choose(len(rewards)))
        assert not terminated
        observations.append(observation)
        rewards.append(reward)
        infos.append(info)
    return np.stack(observations), np.array(rewards), infos


def passes_the_checker(env):
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Physical units are meant; wrappers scale.
        warnings.filterwarnings("ignore", message=".*action space.*")
        check_env(env.unwrapped, skip_render_check=True)
