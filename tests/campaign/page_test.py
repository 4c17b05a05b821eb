"""index.html has the look and the words of reports, failures first, and no name becomes markup."""

import re
import sys
import unittest
from pathlib import Path
from types import SimpleNamespace

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "campaign"))
from airside_campaign import page

REPORT = ROOT / "tools" / "report"


def campaign(name="variants"):
    """Two rooms with two seeds each; the last job has failed, and one name is hostile."""
    jobs, rows = [], []
    for room, seed, dae in (("301", 1, 0.2), ("301", 2, 0.4), ("<b>&", 1, 1.25), ("<b>&", 2, None)):
        job = SimpleNamespace(
            name=f"day-{room}-{seed}", entry=0, key="k", values={"room": room, "seed": seed}, command=["simulate"]
        )
        jobs.append(job)
        figures = {} if dae is None else {"dae_degc": dae, "own_figure": 12.5}
        rows.append(
            {
                "job": job.name,
                "entry": 0,
                "key": "k",
                "done": dae is not None,
                "why": "" if dae is not None else "found <script>; expected none",
                "values": job.values,
                "figures": figures,
            }
        )
    return SimpleNamespace(path=Path(f"{name}.toml"), jobs=jobs, figures={}), rows


class Look(unittest.TestCase):
    def setUp(self):
        self.page = page.page_of(*campaign(), "airside 0.1.0")

    def test_its_style_is_that_of_reports_and_nothing_else(self):
        styles = re.findall(r"<style>\n(.*?)</style>", self.page, re.DOTALL)
        self.assertEqual(styles, [(REPORT / "palette.css").read_text() + (REPORT / "page.css").read_text()])
        inline = set(re.findall(r' style="([^"]*)"', self.page))
        self.assertFalse(
            [s for s in inline if "color" in s or "#" in s or "family" in s], "colours or fonts of its own"
        )
        self.assertNotRegex(self.page, r'(?:fill|stroke)="')

    def test_every_class_is_one_that_reports_know(self):
        css = page.style_of()
        classes = {word for found in re.findall(r' class="([^"]*)"', self.page) for word in found.split()}
        self.assertGreater(len(classes), 10)
        for word in classes:
            self.assertRegex(css, rf"\.{re.escape(word)}\b", word)

    def test_figures_have_the_words_of_a_run_report(self):
        source = (REPORT / "run_report.cpp").read_text()
        table = source[source.index("ReportTable methods_table(") :]
        rows = re.findall(r'\{"([^"]+)", "([^"]+)", &Metrics::(\w+), (\d), \w+\}', table[: table.index("};\n  Rep")])
        self.assertEqual(len(rows), 10)
        reports = {member: (name, unit, int(decimals)) for name, unit, member, decimals in rows}
        for key, words in page.WORDS.items():
            expected = reports[key.replace("_per_day_degch", "_degch")]
            if key == "hvac_kwh_per_day":  # there the plant says whether it is all electricity
                expected = ("energy", *expected[1:])
            self.assertEqual(words, expected, key)
        self.assertIn('<th scope="col" title="dae_degc">DAE<span class="unit">K</span></th>', self.page)
        self.assertIn('<th scope="col" title="own_figure">own_figure</th>', self.page)

    def test_means_and_spreads_are_those_of_the_seeds(self):
        self.assertIn('<td>0.300<span class="pm"> ± 0.141</span></td>', self.page)
        self.assertIn("<td>1.250</td>", self.page, "one seed has no spread")
        self.assertEqual(self.page.count("<circle"), 3)

    def test_a_seed_without_the_figure_is_not_passed_over_in_silence(self):
        one, rows = campaign()
        rows[1]["figures"] = {"own_figure": 12.5}
        rows[3] |= {"done": True, "figures": {"dae_degc": float("nan")}}
        whole = page.page_of(one, rows, "")
        self.assertIn('<td>0.200<span class="unit"> 1 of 2</span></td>', whole)
        self.assertIn('<td>1.250<span class="unit"> 1 of 2</span></td>', whole)
        self.assertNotIn("1 of 2</span>", self.page, "a job that failed is in the column of done ones")

    def test_failures_come_first_and_are_counted(self):
        self.assertIn("3 of 4 jobs done, 1 failed", self.page)
        order = [self.page.index(words) for words in ("1 failed</h2>", "airside simulate</h2>", "How to repeat")]
        self.assertEqual(order, sorted(order))
        jobs, rows = campaign()
        whole = page.page_of(jobs, [row | {"done": True} for row in rows], "")
        self.assertIn("4 of 4 jobs done.", whole)
        self.assertNotIn("failed</h2>", whole)

    def test_no_name_becomes_markup_and_nothing_is_fetched(self):
        self.assertNotIn("<script", self.page)
        self.assertNotIn("<b>", self.page)
        self.assertIn("&lt;b&gt;&amp;", self.page)
        self.assertIn("default-src 'none'", self.page)
        self.assertNotRegex(self.page, r"(?:src|href)=|url\(")


if __name__ == "__main__":
    unittest.main()
