"""The example of docs/gym.md runs as it is printed; docs/examples/lockstep_client.py says what it lacks."""

import importlib.util
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from documents import blocks, text_of

ROOT = Path(__file__).resolve().parents[2]


class LockstepClient(unittest.TestCase):
    def test_without_a_room_it_says_what_it_needs(self):
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = str(free.getsockname()[1])
        for words, said in (([], "lockstep_client.py HOST PORT"), (["localhost", "first"], "lockstep_client.py HOST PORT"),
                            (["127.0.0.1", port], f"127.0.0.1:{port}: found no server .*; start airside serve")):
            done = subprocess.run([sys.executable, "-B", ROOT / "docs" / "examples" / "lockstep_client.py", *words],
                                  capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, said)
            self.assertEqual(len(done.stderr.splitlines()), 1)


class Document(unittest.TestCase):
    def test_its_example_runs(self):
        page = text_of(str(ROOT / "docs" / "gym.md"))
        examples = [block.text for block in blocks(page) if block.language == "python"]
        self.assertEqual(len(examples), 1)
        path = {**os.environ, "PYTHONPATH": str(ROOT / "tools" / "gym"),
                "PATH": os.path.dirname(os.environ["AIRSIDE_PROGRAM"]) + os.pathsep + os.environ["PATH"]}
        del path["AIRSIDE_PROGRAM"]
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-B", "-c", examples[0]], env=path, cwd=folder, capture_output=True,
                                  text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"^distance from the target in working hours: \d\.\d\d K\n$")

    @unittest.skipUnless(importlib.util.find_spec("setuptools"), "setuptools is missing, which builds the package")
    def test_the_package_holds_all_its_modules(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(ROOT / "tools" / "gym", Path(folder) / "gym")  # building leaves files beside the source
            build = "import setuptools; setuptools.setup(script_args=['-q', 'build_py', '--build-lib', 'built'])"
            done = subprocess.run([sys.executable, "-c", build], cwd=Path(folder) / "gym", capture_output=True,
                                  text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            built = {path.name for path in (Path(folder) / "gym" / "built" / "airside_gym").glob("*.py")}
        self.assertEqual(built, {path.name for path in (ROOT / "tools/gym/airside_gym").glob("*.py")})
