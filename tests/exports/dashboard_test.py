"""The Grafana dashboard: each expression is one of Prometheus, and has an answer where a real page is scraped."""

import json
import os
import re
import shutil
import socket
import subprocess
import tempfile
import time
import unittest
import urllib.parse
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ["AIRSIDE_BIN"])
DASHBOARD = ROOT / "docs" / "examples" / "grafana_dashboard.json"
STATUS = {"time": "2021-08-02T10:00:00", "site": "Room 301", "topology": "3vav-0fcu-1power", "stopped": False,
          "stopped_at": "", "state": "run", "reason": "none", "why": "", "way_out": "",
          "alarms": [{"reason": "sensor drifts", "since": "2021-08-02T09:00:00"}], "fault": "none", "fault_signal": "",
          "has_weights": True, "target_degc": 25.25, "room_mean_degc": 25.2, "hold": "mean", "held_degc": 25.2,
          "room_temp_degc": [25.1, 25.2, 25.3], "setpoint_degc": 22.4, "network_setpoint_degc": 22.3,
          "head_setpoint_degc": 22.4, "expert_setpoint_degc": 20.5, "g36_setpoint_degc": 21.0, "mean_error_k": 0.05,
          "schedule_mean_error_k": 1.5, "objective": "mean", "confidence": 0.8, "expected_held_degc": 25.24,
          "expected_room_mean_degc": 25.24, "cycles": 100, "rejected_updates": 0, "replay_transitions": 90,
          "generation": 7, "lost_until": "", "pushed_weights": "none", "pushed_crc": "00000000",
          "pushed_refusal": "none", "pushed_refusal_field": "", "storage": "ok", "clock": "ok", "row_late_ms": 3.0,
          "row_done_ms": 40.0, "link_timeouts": 1, "link_bad_frames": 0, "link_wrong_ids": 0, "link_exceptions": 0,
          "setpoint_writes": 33}


def dashboard():
    return json.loads(DASHBOARD.read_text())


def expressions():
    """(panel, expression as Grafana sends it) of every target."""
    for panel in dashboard()["panels"]:
        for target in panel["targets"]:
            yield panel["title"], target["expr"].replace("$instance", ".*").replace("$__rate_interval", "5m")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def get(url):
    with urllib.request.urlopen(url, timeout=5) as answer:
        return answer.read().decode()


class Dashboard(unittest.TestCase):
    def test_its_form_is_that_of_grafana(self):
        board = dashboard()
        self.assertGreaterEqual(board["schemaVersion"], 36)
        self.assertRegex(board["uid"], r"^[a-zA-Z0-9_-]{1,40}$")
        self.assertEqual({v["name"] for v in board["templating"]["list"]}, {"datasource", "instance"})
        ids, taken = set(), set()
        for panel in board["panels"]:
            ids.add(panel["id"])
            self.assertIn(panel["type"], ("stat", "timeseries", "state-timeline"))
            self.assertEqual(panel["datasource"], {"type": "prometheus", "uid": "${datasource}"})
            place = panel["gridPos"]
            self.assertLessEqual(place["x"] + place["w"], 24)
            cells = {(x, y) for x in range(place["x"], place["x"] + place["w"])
                     for y in range(place["y"], place["y"] + place["h"])}
            self.assertFalse(cells & taken, panel["title"])
            taken |= cells
            self.assertTrue(panel["targets"])
            for target in panel["targets"]:
                self.assertIn('{instance=~"$instance"}', target["expr"])
                self.assertEqual(target["datasource"], panel["datasource"])
        self.assertEqual(len(ids), len(board["panels"]))

    @unittest.skipUnless(shutil.which("promtool"), "promtool is not installed: run tools/setup --for test")
    def test_promtool_takes_every_expression(self):
        found = list(expressions())
        self.assertGreater(len(found), 15)

        def checked(texts):
            rules = "".join(f"  - record: airside:e{i}\n    expr: {json.dumps(text)}\n" for i, text in enumerate(texts))
            with tempfile.NamedTemporaryFile("w", suffix=".yml") as file:
                file.write("groups:\n- name: dashboard\n  rules:\n" + rules)
                file.flush()
                return subprocess.run(["promtool", "check", "rules", file.name], capture_output=True, text=True,
                                      check=False)

        done = checked([text for _, text in found])
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn(f"SUCCESS: {len(found)} rules found", done.stdout)
        self.assertNotEqual(checked(["airside_up{"]).returncode, 0)

    @unittest.skipUnless(shutil.which("prometheus"), "prometheus is not installed: run tools/setup --for test")
    def test_every_panel_has_an_answer_where_a_page_is_scraped(self):
        folder = Path(tempfile.mkdtemp(prefix="airside-dashboard-"))
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        for name in ("state", "inbox", "keys"):
            (folder / name).mkdir()
        (folder / "state" / "status.json").write_text(json.dumps(STATUS))
        page_port, port = free_port(), free_port()
        (folder / "site.toml").write_text(f'[site]\nname = "Room 301"\ntopology = "{STATUS["topology"]}"\n'
                                          f'[page]\nport = {page_port}\n')
        self.start([BIN / "airside-page", "--site", folder / "site.toml", "--ready", folder / "ready"])
        self.within(20, (folder / "ready").exists, "the page answers")
        try:
            served = get(f"http://127.0.0.1:{page_port}/metrics")
        except urllib.error.HTTPError as refusal:
            self.assertEqual(refusal.code, 404)
            self.skipTest("this airside-page has no /metrics: whether its names are those of the dashboard is not known")
        names = set(re.findall(r"^(airside_\w+)", served, re.MULTILINE))
        used = {name for _, text in expressions() for name in re.findall(r"airside_\w+", text)}
        self.assertLessEqual(used, names)
        (folder / "prometheus.yml").write_text(
            "global: {scrape_interval: 1s}\nscrape_configs:\n- job_name: airside\n  static_configs:\n"
            f"  - targets: ['127.0.0.1:{page_port}']\n")
        self.start(["prometheus", f"--config.file={folder}/prometheus.yml", f"--storage.tsdb.path={folder}/tsdb",
                    f"--web.listen-address=127.0.0.1:{port}"])
        asked = f"http://127.0.0.1:{port}/api/v1/query?query="

        def answer(text):
            try:
                return json.loads(get(asked + urllib.parse.quote(text)))["data"]["result"]
            except OSError:
                return []

        # increase() needs two scrapes.
        self.within(40, lambda: answer("count_over_time(airside_up[1m]) > 2"), "three scrapes")
        for panel, text in expressions():
            self.assertTrue(answer(text), f"{panel}: {text}")
        self.assertEqual([row["value"][1] for row in answer('airside_room_temperature_celsius{room="2"}')], ["25.2"])

    def start(self, command):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)

    def within(self, seconds, holds, what):
        until = time.monotonic() + seconds
        while not holds():
            self.assertLess(time.monotonic(), until, f"not within {seconds} s: {what}")
            time.sleep(0.1)
