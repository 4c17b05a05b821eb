"""The package that is installed on a box: a wheel of firmware/bacnet in a fresh environment."""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from desk import ROOT


def run(*words, **more):
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    command = [str(word) for word in words]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment, **more)


class Wheel(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_installs_with_its_dependencies_into_a_fresh_environment(self):
        built = run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index",
                    "--wheel-dir", self.folder, ROOT / "firmware" / "bacnet")
        self.assertEqual(built.returncode, 0, built.stderr)
        wheel, = self.folder.glob("airside_bacnet-*.whl")
        fresh = self.folder / "fresh"
        self.assertEqual(run(sys.executable, "-m", "venv", fresh).returncode, 0)
        python = fresh / "bin" / "python3"
        # The first time from PyPI, then from pip's own cache.
        installed = run(python, "-m", "pip", "install", "--disable-pip-version-check", "--no-input", "--timeout", "20",
                        "--retries", "1", wheel)
        if installed.returncode and "No matching distribution" in installed.stderr + installed.stdout:
            self.skipTest("PyPI cannot be reached, so nothing was installed. This test checked the build of the wheel "
                          "alone.")
        self.assertEqual(installed.returncode, 0, installed.stdout + installed.stderr)
        program = fresh / "bin" / "airside-bacnet"
        shown = run(program, "--help", cwd=self.folder)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertIn("--discover", shown.stdout)
        build = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
        version = re.search(r"project\(airside VERSION ([0-9.]+)", build).group(1)
        self.assertEqual(run(program, "--version").stdout, f"airside-bacnet {version}\n")
        for words, code in ((("--site", "/nowhere/site.toml", "--check"), 1), ((), 2), (("--site", "x", "--chek"), 2)):
            done = run(program, *words, cwd=self.folder)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
        self.assertRegex(run(program, "--site", "/nowhere/site.toml").stderr,
                         r"^airside-bacnet: /nowhere/site.toml: found no readable file .*; expected .*; check the path")


class Unit(unittest.TestCase):
    """The unit as systemd reads it."""

    unit = ROOT / "firmware" / "bacnet" / "airside-bacnet.service"

    def setUp(self):
        if run("systemd-analyze", "--version").returncode:
            self.skipTest("systemd-analyze is not installed: run tools/setup --for test. The unit was not checked.")

    def test_is_accepted(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / self.unit.name
            text = self.unit.read_text(encoding="utf-8").replace("/opt/airside-bacnet/bin/airside-bacnet", "/bin/true")
            copy.write_text(text, encoding="utf-8")
            done = run("systemd-analyze", "verify", "--man=no", copy)
            self.assertNotIn(self.unit.name, done.stderr)

    def test_has_few_rights(self):
        done = run("systemd-analyze", "security", "--offline=true", "--no-pager", self.unit)
        exposure = float(done.stdout.rsplit("Overall exposure level", 1)[1].split(":")[1].split()[0])
        self.assertLess(exposure, 2.5, done.stdout)


if __name__ == "__main__":
    unittest.main()
