"""Run by network_test.py in a network namespace: three addresses in one broadcast domain, on the BACnet port."""

import os
import re
import subprocess
import sys
import unittest

from desk import HEADER, OWN_ROWS, AhuDevice, BacnetTest, until
from pymodbus.client import ModbusTcpClient

GATEWAY, DIRECT, ROUTER, TWIN = "192.0.2.2", "192.0.2.10", "192.0.2.20", "192.0.2.30"
MAP = (HEADER + "room_temp_1,degc,bacnet,1201:analog-input:1,5,45\nroom_temp_2,degc,bacnet,1305:analog-input:2,5,45\n"
       "setpoint,degc,bacnet,1305:analog-output:1,8,32\n" + OWN_ROWS)


def setUpModule():
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    for address in (GATEWAY, DIRECT, ROUTER, TWIN):
        subprocess.run(["ip", "address", "replace", f"{address}/24", "brd", "192.0.2.255", "dev", "lo"], check=True)


class ByBroadcast(BacnetTest):
    points = MAP
    speed = 20

    def setUp(self):
        super().setUp()
        site = self.folder / "site.toml"
        text = re.sub(r"devices = .*\n", "", site.read_text(encoding="utf-8"))
        text = text.replace("127.0.0.1/32", f"{GATEWAY}/24").replace(f"port = {self.gateway_port}", "port = 47808")
        site.write_text(text, encoding="utf-8")
        self.keep(AhuDevice(self.folder, 47808, address=f"{DIRECT}/24"))
        self.routed = self.keep(AhuDevice(self.folder, 47808, instance=1305, address=f"2001:5@{ROUTER}/24"))

    def ask(self, *words):
        command = [sys.executable, "-B", "-m", "airside_bacnet", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})

    def test_discovers_both_and_lists_rows_that_are_a_point_map(self):
        done = self.ask("--discover", "--address", f"{GATEWAY}/24")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f'# device 1201 "AHU-1201" at {DIRECT}', done.stdout)
        self.assertIn('# device 1305 "AHU-1305" at 2001:5', done.stdout)
        self.assertIn("\nroom_temp_1,degc,bacnet,1201:analog-input:1,", done.stdout)
        self.assertIn("commandable\nsupply_air_setpoint,degc,bacnet,1201:analog-output:1,", done.stdout)
        self.assertIn("\nroom_temp_1_2,degc,bacnet,1305:analog-input:1,", done.stdout)
        self.assertIn("\nheartbeat,,bacnet,1201:analog-value:1,", done.stdout)
        self.assertIn("may be the heartbeat, 1201:analog-value:1, 1305:analog-value:1; expected", done.stderr)
        renamed = done.stdout.replace("\nsupply_air_setpoint,", "\nsetpoint,")
        (self.folder / "points.csv").write_text(renamed, encoding="utf-8")
        self.assertEqual(self.ask("--site", str(self.folder / "site.toml"), "--check").returncode, 0)

    def test_discovers_one_by_its_address(self):
        done = self.ask("--discover", "--address", f"{GATEWAY}/24", "--device", "2001:5")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("device 1305", done.stdout)
        self.assertNotIn("device 1201", done.stdout)
        self.assertEqual(self.ask("--discover", "--address", f"{GATEWAY}/24", "--device", "192.0.2.99").returncode, 1)

    def test_two_devices_of_one_number_are_said_and_not_commanded(self):
        twin = self.keep(AhuDevice(self.folder, 47808, instance=1305, address=f"{TWIN}/24"))
        done = self.ask("--discover", "--address", f"{GATEWAY}/24")
        self.assertEqual(done.stdout.count("# TWO DEVICES HAVE THE NUMBER 1305"), 2, done.stdout)
        gateway = self.start_gateway()
        self.assertIn(f"answers from {TWIN} and 2001:5: two devices with one number", gateway.said())
        modbus = ModbusTcpClient("127.0.0.1", port=self.modbus_port, timeout=5)
        self.addCleanup(modbus.close)
        self.assertEqual(modbus.write_registers(4, [0x419C, 0], device_id=1).exception_code, 11)
        self.assertEqual((twin.slots(), self.routed.slots()), ({}, {}))

    def test_another_device_with_the_gateways_own_number_is_said(self):
        self.keep(AhuDevice(self.folder, 47808, instance=4190000, address=f"{TWIN}/24"))
        self.assertIn(f"own device number 4190000 is also that of {TWIN}; set instance", self.start_gateway().said())

    def test_reads_both_and_commands_through_the_router(self):
        done = self.ask("--site", str(self.folder / "site.toml"), "--read")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("commandable; nobody commands it", done.stdout)
        self.assertNotIn("own device number", self.start_gateway().said())
        modbus = ModbusTcpClient("127.0.0.1", port=self.modbus_port, timeout=5)
        self.addCleanup(modbus.close)
        self.assertEqual(modbus.read_input_registers(0, count=4, device_id=1).registers, [0x41C0, 0, 0x41C0, 0])  # 24.0
        self.assertFalse(modbus.write_registers(4, [0x419C, 0], device_id=1).isError())  # 19.5
        self.assertEqual(self.routed.slots(), {10: 19.5})
        until(lambda: not self.routed.slots(), 20)


if __name__ == "__main__":
    unittest.main()
