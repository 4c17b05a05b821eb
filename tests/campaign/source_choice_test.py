"""tools/source_choice --keep: a result is used again only where program and arguments are those that it came from."""

import importlib.machinery
import importlib.util
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """#!/bin/sh
echo run >> "$0.runs"
while [ $# -gt 0 ]; do if [ "$1" = -o ]; then echo blob > "$2"; fi; shift; done
echo '{"dae_degc": 0.1}'
"""


def source_choice():
    sys.dont_write_bytecode = True
    loader = importlib.machinery.SourceFileLoader("source_choice", str(ROOT / "tools" / "source_choice"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("source_choice", loader))
    loader.exec_module(module)
    return module


class Kept(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="airside-choice-")
        self.addCleanup(folder.cleanup)
        self.folder, self.tool = Path(folder.name), source_choice()
        self.program = self.folder / "airside"
        self.program.write_text(PROGRAM)
        self.program.chmod(0o755)

    def runs(self):
        return (self.folder / "airside.runs").read_text().count("run")

    def test_the_same_is_used_again_and_anything_else_is_run(self):
        place = self.folder / "one.json"
        for days, runs in ((2, 1), (2, 1), (3, 2), (3, 2)):
            self.tool.object_of(self.program, ["simulate", "--days", days], place)
            self.assertEqual(self.runs(), runs, days)
        self.program.write_text(PROGRAM + "# another\n")
        self.tool.object_of(self.program, ["simulate", "--days", 3], place)
        self.assertEqual(self.runs(), 3)
        place.with_suffix(".how").unlink()  # as it was kept before
        self.tool.object_of(self.program, ["simulate", "--days", 3], place)
        self.assertEqual(self.runs(), 4)

    def test_a_source_of_other_arguments_is_trained_anew(self):
        for preset, runs in (("product", 1), ("product", 1), ("paper", 2)):
            blob = self.tool.train(SimpleNamespace(program=self.program, preset=preset), self.folder, 0)
            self.assertEqual((self.runs(), blob.read_text()), (runs, "blob\n"))
        use = ["simulate", "--weights", blob]
        self.tool.object_of(self.program, use, self.folder / "use.json")
        blob.write_text("other")
        self.tool.object_of(self.program, use, self.folder / "use.json")
        self.assertEqual(self.runs(), 4)


if __name__ == "__main__":
    unittest.main()
