"""The gateway beside a device of another BACnet library, node-bacnet, where Node.js and that package are."""

import math
import os
import shutil
import signal
import subprocess
import unittest
from pathlib import Path

from desk import DEVICE, HEADER, HERE, OWN_ROWS, ROOT, SETPOINT_ROW, Program, until
from gateway_test import GatewayCase

MODULES = Path(os.environ.get("AIRSIDE_NODE_MODULES") or ROOT / "build" / "node" / "node_modules")
ROOM, STATE, ABSENT, SETPOINT = range(0, 8, 2)


class SecondStack(GatewayCase):
    points = (HEADER + f"room_temp_1,degc,bacnet,{DEVICE}:analog-input:3,5,45\n"
              f"vav_on_1,,bacnet,{DEVICE}:binary-input:2,0,1\nabsent,,bacnet,{DEVICE}:analog-input:77,0,1\n"
              + SETPOINT_ROW + OWN_ROWS)

    def setUp(self):
        if not shutil.which("node") or not (MODULES / "node-bacnet").is_dir():
            self.skipTest(f"no Node.js with node-bacnet in {MODULES}: install npm and run tools/setup --for test. No "
                          "other BACnet library than the gateway's own was tried.")
        super().setUp()

    def start_device(self, with_plant=False):
        self.device = self.keep(Program(["node", HERE / "second_stack.js", MODULES, self.device_port],
                                        self.folder / "device.txt", subprocess.DEVNULL))
        until(lambda: self.device.has_said("ready"))

    def test_is_read_commanded_and_relinquished(self):
        self.assertEqual((self.input(ROOM), self.input(STATE), self.holding(SETPOINT)), (22.5, 1.0, 24.0))
        self.assertTrue(math.isnan(self.input(ABSENT)))
        self.assertEqual(self.write(SETPOINT, 19.5), 0)
        self.assertEqual(self.holding(SETPOINT), 19.5)
        self.assertEqual(self.gateway.kill(signal.SIGTERM), 0)
        self.assertEqual(self.device.said().splitlines(), ["ready", "10 null", "10 19.5", "10 null"])


del GatewayCase

if __name__ == "__main__":
    unittest.main()
