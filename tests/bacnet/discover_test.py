"""What --discover makes of a device: limits, the heartbeat that the AHU watches, and no row of the gateway itself."""

import csv
import os
import subprocess
import sys
import unittest

from desk import DEVICE, BacnetTest, ROOT


class Discover(BacnetTest):
    def ask(self, *words):
        command = [sys.executable, "-B", "-m", "airside_bacnet", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})

    def discover(self, address="127.0.0.1/32", device=None):
        return self.ask("--discover", "--address", address, "--port", str(self.gateway_port),
                        "--device", device or f"127.0.0.1:{self.device_port}")

    def check(self, text):
        (self.folder / "points.csv").write_text(text.replace("\nsupply_air_setpoint,", "\nsetpoint,"), encoding="utf-8")
        done = self.ask("--site", str(self.folder / "site.toml"), "--check")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def test_a_commandable_heartbeat_has_its_name_and_the_gateways_row_is_a_comment(self):
        self.start_device()
        done = self.discover()
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn(f"\nheartbeat,,bacnet,{DEVICE}:analog-value:1,,,0,65535,,\n", done.stdout)
        self.assertIn("\n# heartbeat,,bacnet,gateway,", done.stdout)
        self.assertEqual(self.check(done.stdout), "")

    def test_without_one_the_power_loss_is_said(self):
        self.start_device().do(rename=["analog-value", 1, "counter"])
        done = self.discover()
        self.assertIn("\nheartbeat,,bacnet,gateway,", done.stdout)
        self.assertIn("nothing in the AHU notices a power loss", done.stderr)
        self.assertIn("nothing in the AHU notices a power loss", self.check(done.stdout))

    def test_a_name_of_several_lines_adds_no_row(self):
        row = "x\"\nsetpoint,degc,bacnet,666:analog-output:1,,,20,26,,"
        self.start_device().do(rename=["analog-input", 31, row], device_name=f"AHU {row}")
        done = self.discover()
        self.assertEqual(done.stdout.count("setpoint,degc,bacnet,666:"), 2, "in two comments")
        self.assertNotIn("\nsetpoint,", done.stdout)

    def test_limits_are_those_of_the_importer(self):
        self.start_device().do(rename=["analog-input", 31, "AI-31"])
        done = self.discover()
        lines = [line for line in done.stdout.splitlines() if not line.startswith("#")]
        rows = {row["name"]: row for row in csv.DictReader(lines)}
        sys.path.insert(0, str(ROOT / "tools" / "points"))
        from roles import ROLES
        for name, stem in (("room_temp_3", "room_temp"), ("fcu_temp_2", "fcu_temp"), ("supply_air_setpoint", "setpoint"),
                           ("outdoor_temp", "outdoor_temp"), ("supply_temp", "supply_temp"), ("power_1", "power")):
            role, row = ROLES[stem], rows[name]
            self.assertEqual((float(row["min"]), float(row["max"]), row["max_rate"], row["stale_s"]),
                             (role.least, role.most, role.rate, role.stale), name)
        self.assertEqual((rows["ai_31"]["min"], rows["ai_31"]["stale_s"]), ("-40", "1200"))
        self.assertIn("degrees-celsius, wide limits: ", done.stdout)

    def test_on_the_loopback_one_is_not_found_oneself(self):
        done = self.discover("127.0.0.1/8", f"127.0.0.2:{self.gateway_port}")
        self.assertEqual((done.returncode, done.stdout), (1, ""), done.stderr)
        self.assertIn(f"found this program itself at 127.0.0.2:{self.gateway_port}; expected a device", done.stderr)
        self.assertIn("found no device", done.stderr)


if __name__ == "__main__":
    unittest.main()
