"""What the tests of point lists share: a folder, the programs, lists."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ["AIRSIDE_BIN"])
IMPORT = ROOT / "tools" / "points" / "import_points"


class Desk(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="airside-points-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def run_here(self, *words):
        return subprocess.run([str(word) for word in words], cwd=self.folder, capture_output=True, text=True, check=False,
                              timeout=60)

    def airside(self, *words):
        return self.run_here(BIN / "airside", *words)

    def import_list(self, *words):
        return self.run_here(sys.executable, "-B", IMPORT, *words)

    def imported(self, *words):
        """Facts of an import that must succeed."""
        done = self.import_list(*words, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def write(self, name, text, encoding="utf-8"):
        (self.folder / name).write_bytes(text.encode(encoding))
        return name

    def text(self, name):
        return (self.folder / name).read_text()

    def replace(self, name, old, new):
        text = self.text(name)
        self.assertIn(old, text)
        self.write(name, text.replace(old, new))

    def rows(self, name="points.csv"):
        """Rows of a map by name, each a dictionary."""
        lines = [line.split(",") for line in self.text(name).splitlines() if line and not line.startswith("#")]
        return {cells[0]: dict(zip(lines[0], cells)) for cells in lines[1:]}

    def site(self, topology, stand_ins=()):
        """A site of `airside init` in the folder, with stand-ins."""
        done = self.airside("init", ".", "--topology", topology, "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        if stand_ins:
            text = self.text("site.toml")
            lines = "".join(line + "\n" for line in stand_ins)
            self.write("site.toml", text.replace("\n[stand_in]\n", "\n[stand_in]\n" + lines, 1) if "\n[stand_in]\n" in text
                       else text + "\n[stand_in]\n" + lines)
        return "site.toml"
