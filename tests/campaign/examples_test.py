"""docs/examples: the gap workflow's sealed cases and the studies as campaigns, with fewer cases and days."""

import json
import unittest

import pyarrow.parquet as pq
from desk import ROOT, Desk

EXAMPLES = ROOT / "docs" / "examples"


def smaller(test, name, *changes):
    text = (EXAMPLES / name).read_text(encoding="utf-8")
    for old, new in changes:
        test.assertIn(old, text)
        text = text.replace(old, new)
    return text


class Examples(unittest.TestCase):
    def printed(self, desk, out, job):
        folder = desk.folder / out
        table = pq.read_table(folder / "results.parquet").to_pydict()
        return json.loads((folder / "jobs" / table["key"][table["job"].index(job)] / "stdout").read_text())

    def test_sealed_cases_of_several_drawings_are_scored_together(self):
        desk = Desk(self)
        desk.write(
            smaller(
                self,
                "campaign-blind.toml",
                ("ratio = [1, 3], seed = [2001, 2002, 2003, 2004, 2005]", "ratio = [3], seed = [9001, 9002]"),
                ("ratio = [1, 3]", "ratio = [3]"),
                ('"--cases", "8", "--days", "14"', '"--cases", "1", "--days", "4"'),
                ('"--jobs", "1", "--json"]\nover = {ratio = [3], seed = [9001, 9002]}\n\n[[job]]\nname = "scored',
                 '"--jobs", "1", "--buildings", "0", "--json"]\nover = {ratio = [3], seed = [9001, 9002]}\n\n'
                 '[[job]]\nname = "scored'),
            )
        )
        done = desk.run("--serial", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["jobs"], 5)
        table = self.printed(desk, "blind-runs", "scored-3")
        self.assertEqual({s["set"]: s["cases"] for s in table["sets"]}["single"], 2)
        words = desk.commands("blind-runs/jobs")["scored-3"]
        self.assertEqual([w.rsplit("/", 1)[1] for w in words[2:6]], ["verdicts.json"] * 2 + ["key.json"] * 2)
        self.assertEqual(len(set(words[2:6])), 4)

    def test_studies_of_single_seeds_become_one_page(self):
        desk = Desk(self)
        desk.write(
            smaller(
                self,
                "campaign-studies.toml",
                ("[1, 2, 3, 4, 5]", "[1, 2]"),
                ('"--seeds", "5"', '"--seeds", "2"'),
                ('"--plant", "rc"', '"--plant", "rc", "--days", "1", "--pretrain-days", "2", "--operated-days", "2", '
                 '"--summer-days", "1", "--winter-days", "1", "--steps", "2"'),
                ('"study", "method"', '"study", "method", "--tables", "control"'),
            )
        )
        done = desk.run("--serial", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        page = self.printed(desk, "study-runs", "page")
        self.assertEqual((page["seeds"], page["runs"]), (2, 6))
        self.assertTrue(list((desk.folder / "study-runs" / "jobs").glob("*/report/index.html")))


if __name__ == "__main__":
    unittest.main()
