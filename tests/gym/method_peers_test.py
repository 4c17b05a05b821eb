"""What tools/gym/method_peers plans, keeps, tables and refuses, and its data, without any network."""

import importlib.util
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from airside_gym import AirsideError
from airside_peers import choices, claims, published, runs, signals, tables, transitions
from desk import PROGRAM, airside, simulated

ROOT = Path(__file__).resolve().parents[2]
SCRIPT, GOLDEN = ROOT / "tools/gym/method_peers", ROOT / "tests/golden/data"
NAMES = [f"{kind}{n}" for kind in ("power_", "vav_on_", "room_temp_", "fcu_on_", "fcu_temp_")
         for n in range(1, 3 if kind == "power_" else 6)] + ["rain", "outdoor_temp", "supply_temp", "mau_temp"]


def golden(name):
    return json.loads((GOLDEN / name).read_text(encoding="utf-8"))


def method_peers(*words):
    return subprocess.run([sys.executable, "-B", SCRIPT, *map(str, words)], capture_output=True, text=True, check=False)


def control_runs(methods, seeds=2):
    return runs.planned("control", "rc", ["301-real"], methods, seeds, {"days": 14})


def control_figures(dae, **others):
    return {"dae_degc": dae, "me_degc": 2 * dae, "darv_degc": 0.5, "cdh_degch": 300.0, "hdh_degch": 0.0,
            "daily_dae_degc": [dae, dae, dae, 9.0], **others}


class Plan(unittest.TestCase):
    def test_every_published_method_has_runs(self):
        self.assertEqual(set(published.CONTROL) - set(runs.CONTROL_COST), set())
        for rows in published.TRANSFER.values():
            self.assertEqual(set(rows) - set(runs.TRANSFER_COST), set())

    def test_all_rows_of_a_seed_come_before_the_next_and_cheap_ones_first(self):
        planned = control_runs(["ed", "lstm-6-4", "expert"])
        self.assertEqual([(run.seed, run.method) for run in planned],
                         [(s, m) for s in (1, 2) for m in ("expert", "ed", "lstm-6-4")])

    def test_whatever_a_result_depends_on_is_in_its_name(self):
        def name(**other):
            words = {"study": "control", "plant": "rc", "room": "301-real", "method": "ed", "seed": 1, "days": 14}
            words.update(other)
            return runs.Run(words["study"], words["plant"], words["room"], words["method"], words["seed"],
                            (("days", words["days"]),)).name

        self.assertEqual(name(), "control_rc_301-real_ed_days14_seed1")
        others = [name(study="transfer"), name(plant="energyplus"), name(room="a/b.json"), name(method="osln"),
                  name(seed=2), name(days=42), name()]
        self.assertEqual(len(set(others)), 7)
        self.assertFalse(any("/" in other for other in others))

    def test_shapes_of_series_are_read_from_their_names(self):
        self.assertEqual(runs.series_of("transformer-6-4"), ("transformer", 6, 4))
        self.assertIsNone(runs.series_of("ed"))


class Folder(unittest.TestCase):
    def setUp(self):
        self.desk = tempfile.TemporaryDirectory()
        self.addCleanup(self.desk.cleanup)
        self.results = runs.Results(Path(self.desk.name) / "new" / "runs")

    def test_what_is_there_is_left_out_and_read_again(self):
        planned = control_runs(["expert", "ed"])
        self.results.save(planned[1], control_figures(0.25), "airside")
        self.assertEqual(self.results.missing(planned), [planned[0], planned[2], planned[3]])
        self.assertEqual(self.results.load(planned), {planned[1]: control_figures(0.25)})
        self.assertEqual([path.suffix for path in self.results.folder.iterdir()], [".json"])

    def test_a_run_that_was_broken_off_is_missing(self):
        planned = control_runs(["ed"], 1)
        with self.assertRaises(TypeError):
            self.results.save(planned[0], {"dae_degc": object()}, "airside")
        self.assertEqual(self.results.missing(planned), planned)

    def test_a_file_that_is_no_result_is_named(self):
        planned = control_runs(["ed"], 1)
        self.results.folder.mkdir(parents=True)
        self.results.path(planned[0]).write_text("{", encoding="utf-8")
        with self.assertRaisesRegex(AirsideError, "seed1.json: found no result.*delete it"):
            self.results.load(planned)


class Tables(unittest.TestCase):
    def rows(self, dae):
        planned = control_runs(list(dae))
        shift = {1: -0.1, 2: 0.1}
        return tables.rows_of({run: control_figures(dae[run.method] + shift[run.seed], decision_s=0.002)
                               for run in planned})

    def test_a_row_has_mean_spread_and_published_figure(self):
        row, = self.rows({"osln": 0.5})
        self.assertAlmostEqual(row["dae_degc"], 0.5)
        self.assertAlmostEqual(row["dae_degc_sd"], math.sqrt(0.02))
        self.assertAlmostEqual(row["first_days_degc"], 0.5)
        line = tables.markdown("control", [row]).splitlines()[2]
        self.assertIn("| osln | 2 | 0.500 ± 0.141 | 0.17189 |", line)
        self.assertIn("| 2.00 ± 0.00 |", line)

    def test_one_run_has_no_spread(self):
        run, = control_runs(["expert"], 1)
        line = tables.markdown("control", tables.rows_of({run: control_figures(1.5)})).splitlines()[2]
        self.assertIn("| expert | 1 | 1.500 | 1 |", line)

    def test_transfer_rows_are_kept_apart_by_room(self):
        planned = runs.planned("transfer", "rc", ["701-real", "702-real"], ["dynamic"], 1, {})
        found = {run: {"mae_summer_degc": 0.1, "mae_winter_degc": 0.3} for run in planned}
        lines = tables.markdown("transfer", tables.rows_of(found)).splitlines()[2:]
        self.assertEqual(lines, ["| 701-real | dynamic | 1 | 0.100 | 0.078 | 0.300 | 0.202 | 0.200 | 0.14 |",
                                 "| 702-real | dynamic | 1 | 0.100 | 0.056 | 0.300 | 0.298 | 0.200 | 0.177 |"])

    def test_published_figures_hold_the_published_claims(self):
        control = [{"method": method, **said, "first_days_degc": said["dae_degc"], "decision_s": said.get("decision")}
                   for method, said in published.CONTROL.items()]
        for row in control:
            row.setdefault("darv_degc", 0.0)
            if row["decision_s"] is None:
                del row["decision_s"]
        told = {(v["claim"], v["condition"]): v["holds"] for v in claims.verdicts("control", control)}
        self.assertTrue(told.pop((15, "CDH: ed below osln and pid-spec")))
        self.assertEqual([key for key, holds in told.items() if not holds], [(4, "expert above 1 °C")])
        rows = []
        for (room, season), said in published.TRANSFER.items():
            for method, error in said.items():
                rows.append({"room": room, "method": method, f"mae_{season}_degc": error})
        merged = {}
        for row in rows:
            merged.setdefault((row["room"], row["method"]), {}).update(row)
        for row in merged.values():
            row["mae_average_degc"] = (row["mae_summer_degc"] + row["mae_winter_degc"]) / 2
        verdicts = claims.verdicts("transfer", list(merged.values()))
        self.assertEqual(len(verdicts), 8)
        self.assertTrue(all(verdict["holds"] for verdict in verdicts), verdicts)

    def test_claims_fail_and_stay_open(self):
        rows = self.rows({"ed": 0.5, "osln": 0.4, "ddqn": 0.6, "expert": 1.5, "pid-spec": 0.7})
        told = {(v["claim"], v["condition"]): v["holds"] for v in claims.verdicts("control", rows)}
        self.assertFalse(told[4, "DAE: ed below expert, pid-spec, osln, ddqn"])
        self.assertTrue(told[15, "DAE: ed below pid-spec and ddqn"])
        self.assertIsNone(told[16, "DAE: ed below every LSTM and Transformer"])
        self.assertIn("not known yet", claims.markdown(claims.verdicts("control", rows)))


class Data(unittest.TestCase):
    def test_inputs_and_labels_are_those_of_the_golden_vectors(self):
        layout = signals.Layout(NAMES)
        self.assertEqual(layout.names[:6] + layout.names[-5:],
                         [f"room_temp_{n}" for n in range(1, 6)] + ["fcu_temp_1"]
                         + ["power_1", "power_2", "mau_temp", "outdoor_temp", "rain"])
        self.assertEqual(layout.labels.tolist(), golden("meta.json")["labels"])

    def test_a_transition_holds_one_setpoint_and_its_window(self):
        rows = np.zeros((12, 26))
        rows[:, 0], rows[:, -1] = np.arange(12), [25] * 4 + [20] * 8
        scaler = transitions.Scaler(signals.Layout(NAMES), rows)
        self.assertEqual(transitions.starts_of(rows, 1, False).tolist(), [0, 1, 4, 5, 6, 7, 8])
        self.assertEqual(transitions.starts_of(rows, 1, True).tolist(), [0, 6])
        self.assertEqual(transitions.starts_of(rows, 3, False).tolist(), [6, 7, 8])
        made = transitions.transitions_of(rows, scaler, cycles=3)
        degc = made.windows[0, :, 0] * scaler.scale[0] + scaler.mean[0]
        np.testing.assert_allclose(degc, [0, 3, 6], atol=1e-5)
        self.assertAlmostEqual(float(made.after[0, 0] * scaler.scale[0] + scaler.mean[0]), 9, places=5)

    def test_scales_have_floors_and_flags_none(self):
        rows = np.full((240, 26), 10.0)
        scaler = transitions.Scaler(signals.Layout(NAMES), rows)
        told = dict(zip(signals.Layout(NAMES).names + ["setpoint"], scaler.scale, strict=True))
        self.assertEqual((told["room_temp_1"], told["power_1"], told["rain"], told["vav_on_1"]), (0.5, 0.5, 1, 1))
        self.assertAlmostEqual(told["setpoint"], 6 / math.sqrt(12))
        self.assertEqual(scaler.mean[-1], 23)

    def test_a_log_of_the_program_is_read_in_this_order(self):
        with tempfile.TemporaryDirectory() as folder:
            log = os.path.join(folder, "log.csv")
            airside("simulate", "--plant", "rc", "--room", "301-real", "--method", "constant-22.5", "--expert-days",
                    "0", "--days", "1", "--log", log)
            layout, rows = signals.read_rows(log)
            self.assertEqual((rows.shape, layout.rooms, layout.exogenous), ((240, 26), 5, 20))
            self.assertEqual(set(rows[:, -1]), {22.5})
            header, first = Path(log).read_text(encoding="utf-8").splitlines()[:2]
        told = dict(zip(header.split(","), first.split(",")))
        self.assertEqual(rows[0, layout.names.index("mau_temp")], float(told["mau_temp_degc"]))


class Choice(unittest.TestCase):
    def test_scores_are_the_golden_ones(self):
        for case in golden("scores.json")["cases"]:
            scores = choices.long_term_scores(np.mean(case["s_raw"]), np.mean(case["long"], axis=1), case["t_exp"])
            np.testing.assert_allclose(scores, case["score"], atol=1e-12)
            best = choices.nearest_of_the_best(scores, np.array(case["actions"]), 22.0)
            self.assertEqual(best, case["a_highest"])

    def test_confidence_is_the_golden_one(self):
        known, confidence = golden("confidence.json"), choices.Confidence()
        for loss, value, fused in zip(known["loss"], known["alpha"], known["fused"], strict=True):
            confidence.update(loss)
            self.assertAlmostEqual(confidence.value, value, places=12)
            self.assertAlmostEqual(confidence.blended(known["a_highest"], known["a_expert"]), fused, delta=0.00501)
        confidence.update(math.nan)
        self.assertAlmostEqual(confidence.value, 0.8 * known["alpha"][-1])

    def test_ties_go_to_the_last_setpoint_then_to_the_lower(self):
        scores, setpoints = np.array([0.0, 1.0, 1.0, 1.0]), np.array([20.0, 21.0, 22.0, 23.0])
        self.assertEqual(choices.nearest_of_the_best(scores, setpoints, 24), 23)
        self.assertEqual(choices.nearest_of_the_best(scores, setpoints, 21.5), 21)


class CommandLine(unittest.TestCase):
    def test_runs_are_made_once_and_tabled(self):
        with tempfile.TemporaryDirectory() as folder:
            words = ["control", "--airside", PROGRAM, "--results", folder, "--methods", "expert,pid-spec", "--days",
                     "1", "--seeds", "2"]
            first = method_peers(*words)
            self.assertEqual(first.returncode, 0, first.stderr)
            self.assertIn("4 of 4 runs", first.stdout)
            written = {path: path.stat().st_mtime_ns for path in Path(folder).glob("*.json")}
            self.assertEqual(len(written), 4)
            min(written).unlink()
            again = method_peers(*words, "--json")
            kept = [path for path in written if path.stat().st_mtime_ns == written[path]]  # three were not made again
            self.assertEqual(len(kept), 3)
            told = json.loads(again.stdout)
            self.assertEqual([(row["method"], row["runs"]) for row in told["rows"]], [("expert", 2), ("pid-spec", 2)])
            alone = simulated("--plant", "rc", "--room", "301-real", "--method", "expert", "--days", "1", "--seed", "2")
            path, = (path for path in written if "expert" in path.name and "seed2" in path.name)
            row = json.loads(path.read_text(encoding="utf-8"))
            self.assertIn("airside ", row["program"])
            self.assertEqual(row["figures"]["dae_degc"], alone["dae_degc"])
            tabled = method_peers(*words, "--methods", "expert,osln", "--only-table")
            self.assertIn("2 of 4 runs", tabled.stdout)

    def test_only_a_run_makes_the_folder_and_a_table_of_nothing_is_refused(self):
        with tempfile.TemporaryDirectory() as desk:
            folder = Path(desk) / "new" / "runs"
            base = ["control", "--airside", PROGRAM, "--methods", "expert", "--seeds", "1", "--days", "1"]
            for words, said in ((["--results", folder, "--only-table"], "runs: found no such folder; expected a folder for"),
                                (["--results", desk, "--only-table"], "found none of 1 runs such as control_rc_301-real_"),
                                (["--results", folder, "--rooms", "attic"], '--room: found room "attic"')):
                done = method_peers(*base, *words)
                self.assertEqual((done.returncode, done.stdout), (1, ""))
                self.assertIn(said, done.stderr)
            self.assertEqual(os.listdir(desk), [])

    def test_what_it_cannot_do_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            base = ["control", "--results", folder, "--methods", "expert", "--seeds", "1", "--days", "1"]
            for words, said in (
                    (["control", "--methods", "ppo"], "found 'ppo'; expected some of expert, pid-spec"),
                    (["transfer", "--methods", "osln"], "found 'osln'; expected some of persistence, none"),
                    (["control", "--seeds", "0"], "--seeds: found 0; expected 1 or more"),
                    ([*base, "--airside", "/nowhere/airside"], "found no program '/nowhere/airside'"),
                    ([*base, "--airside", PROGRAM, "--rooms", "attic"], '--room: found room "attic"; expected one of'),
                    ([*base, "--airside", PROGRAM, "--start", "2021-13-01"], "--start: found '2021-13-01'"),
                    ([*base, "--airside", PROGRAM, "--plant", "nuclear"], "--plant: nuclear not in {auto,rc,energyplus"),
                    (["control", "--results", "/proc/nowhere", "--only-table"], "expected a folder for results")):
                done = method_peers(*words)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(said, done.stderr)
                self.assertNotIn("Traceback", done.stderr)
            self.assertEqual(os.listdir(folder), [])

    def test_help_teaches_without_any_package(self):
        for python in ([sys.executable], [sys.executable, "-S"]):  # -S: nothing that was installed
            done = subprocess.run([*python, "-B", SCRIPT, "--help"], capture_output=True, text=True, check=False)
            self.assertIn("method_peers transfer", done.stdout)
            self.assertIn("pip install torch", done.stdout)

    @unittest.skipIf(importlib.util.find_spec("torch"), "torch is there, so its absence cannot be tried")
    def test_torch_that_is_missing_is_named_with_its_pip_line(self):
        with tempfile.TemporaryDirectory() as folder:
            done = method_peers("control", "--airside", PROGRAM, "--results", folder, "--methods", "ed", "--seeds", "1")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("torch: found no such Python package; expected PyTorch 2; pip install torch", done.stderr)
        self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main()
