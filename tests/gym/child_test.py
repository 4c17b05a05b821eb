"""No program outlives its environment, however that ends."""

import gc
import os
import signal
import subprocess
import sys
import unittest

from airside_gym import AirsideError
from desk import ends, environment, is_running, setpoint

BEGIN = ("import gymnasium, airside_gym, os, signal\n"
         "env = gymnasium.make('airside/Rc-v0', days=1)\n"
         "env.reset(seed=1)\n"
         "print(env.unwrapped.child_pid, flush=True)\n")


def child_of_a_program(last_lines):
    """Process number of the child of another Python that has ended, and that one's exit code."""
    path = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", BEGIN + last_lines], env=path, capture_output=True, text=True,
                          check=False)
    return int(done.stdout), done.returncode


class Child(unittest.TestCase):
    def test_close_ends_it_and_may_be_called_again(self):
        env = environment("Rc", days=1)
        env.reset(seed=1)
        pid = env.unwrapped.child_pid
        self.assertTrue(is_running(pid))
        env.close()
        self.assertFalse(is_running(pid))
        env.close()

    def test_the_next_reset_ends_the_run_before(self):
        with environment("Rc", days=1) as env:
            env.reset(seed=1)
            first = env.unwrapped.child_pid
            env.reset(seed=2)
            self.assertFalse(is_running(first))
            self.assertTrue(is_running(env.unwrapped.child_pid))

    def test_an_exception_in_a_with_block_ends_it(self):
        with self.assertRaises(ZeroDivisionError):
            with environment("Rc", days=1) as env:
                env.reset(seed=1)
                pid = env.unwrapped.child_pid
                raise ZeroDivisionError
        self.assertFalse(is_running(pid))

    def test_an_environment_that_nobody_holds_ends_it(self):
        env = environment("Rc", days=1)
        env.reset(seed=1)
        pid = env.unwrapped.child_pid
        del env
        gc.collect()
        self.assertTrue(ends(pid))

    def test_a_program_that_ends_by_an_exception_ends_it(self):
        pid, status = child_of_a_program("raise RuntimeError('an agent that fails')")
        self.assertEqual(status, 1)
        self.assertTrue(ends(pid))

    def test_a_program_that_is_killed_ends_it(self):
        for number in (signal.SIGTERM, signal.SIGKILL):
            pid, status = child_of_a_program(f"os.kill(os.getpid(), {int(number)})")
            self.assertEqual(status, -number)
            self.assertTrue(ends(pid))

    def test_a_child_that_died_is_an_error_and_the_next_reset_works(self):
        with environment("Rc", days=1) as env:
            env.reset(seed=1)
            os.kill(env.unwrapped.child_pid, signal.SIGKILL)
            with self.assertRaisesRegex(AirsideError, "airside ended without a word, exit code -9"):
                env.step(setpoint(22))
            self.assertIsNone(env.unwrapped.child_pid)
            with self.assertRaisesRegex(AirsideError, "call reset"):
                env.unwrapped.step(setpoint(22))
            env.reset(seed=1)
            env.step(setpoint(22))
