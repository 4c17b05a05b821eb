"""The whole chain: airsided, gateway, BACnet/IP over UDP, a device, and a simulated room behind it.

One run in the order of a bad day, since each step begins where the one before ended. The clocks of plant, gateway and
daemon run 120 times as fast: a row each 3 s."""

import signal
import subprocess
from contextlib import contextmanager

from desk import BIN, DEFAULT_DEGC, DEVICE, BacnetTest, until
from pymodbus.client import ModbusTcpClient

SCHEDULE_DEGC = 21.0


class Chain(BacnetTest):
    speed = 120
    more_bacnet = "stale_s = 600.0\nheartbeat_timeout_s = 600.0\n"

    def write_site(self):
        super().write_site()
        site = self.folder / "site.toml"
        text = site.read_text(encoding="utf-8").replace("[modbus]", "[controller.override]\noverride_h = 0.2\n[modbus]")
        text = text.replace("timeout_s = 1.5", "timeout_s = 1.0").replace("deadline_s = 5.0", "deadline_s = 2.0")
        site.write_text(text, encoding="utf-8")

    @contextmanager
    def step(self, what):
        """The first that fails ends the run, and is named."""
        print(f"  {what}", flush=True)
        try:
            yield
        except AssertionError as error:
            raise AssertionError(f"{what}: {error}; status {self.status()}") from error

    def airside(self, *words):
        done = subprocess.run([BIN / "airside", *words], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def controlled(self):
        """The schedule's setpoint stands at priority 10, and the daemon is not held by an override."""
        return (self.device.slots().get(10) == SCHEDULE_DEGC and self.status().get("reason") not in
                ("overridden", "released by hand") and self.status().get("setpoint_degc") == SCHEDULE_DEGC)

    def reasons(self):
        return self.alarms() | {self.status().get("reason")}

    def plant_setpoint(self):
        with ModbusTcpClient("127.0.0.1", port=self.plant_port, timeout=5) as client:
            return client.read_holding_registers(0, count=1, device_id=1).registers[0] / 100

    def test_a_bad_day(self):
        self.start_plant()
        self.start_device(with_plant=True)
        gateway = self.start_gateway()
        daemon = self.start_daemon()

        with self.step("the room is controlled through all of it"):
            until(self.controlled, 60)
            until(lambda: self.plant_setpoint() == SCHEDULE_DEGC)
            rooms = self.status()["room_temp_degc"]
            self.assertTrue(all(10 < room < 40 and room != DEFAULT_DEGC for room in rooms), rooms)
            self.assertGreater(self.status()["setpoint_writes"], 0)

        with self.step("a faulty sensor is invalid, and the others go on"):
            self.device.do(fault=["analog-input", 1, True])
            until(lambda: self.status().get("fault_signal") == "room_temp_1", 30)
            self.assertTrue(gateway.has_said(f"{DEVICE}:analog-input:1: fault (open-loop)"))
            self.device.do(fault=["analog-input", 1, False])
            until(lambda: self.status().get("fault_signal") != "room_temp_1" and self.controlled(), 30)

        with self.step("a person at a higher priority is an override"):
            operator = self.operator()
            operator.command(23.0, 8)
            until(lambda: "overridden" in self.reasons(), 30)
            self.assertEqual(self.device.slots(), {8: 23.0, 10: SCHEDULE_DEGC})
            operator.relinquish(8)
            until(self.controlled, 60)

        with self.step("a killed daemon's setpoint is given back"):
            daemon.kill(signal.SIGKILL)
            self.assertEqual(self.device.slots(), {10: SCHEDULE_DEGC})
            until(lambda: not self.device.slots(), 30)
            self.assertTrue(gateway.has_said("the heartbeat has stood still"))
            daemon = self.start_daemon()
            until(self.controlled, 30)

        with self.step("a release gives it back, a hand-back takes it again"):
            self.airside("release", str(self.folder / "site.toml"))
            until(lambda: self.status().get("state") == "release" and not self.device.slots(), 30)
            self.airside("hand-back", str(self.folder / "site.toml"))
            until(self.controlled, 30)

        with self.step("a killed gateway is a lost link, and the next one begins with an empty slot"):
            gateway.kill(signal.SIGKILL)
            until(lambda: self.status().get("room_mean_degc") is None or self.status().get("fault") != "none", 30)
            self.assertEqual(self.device.slots(), {10: SCHEDULE_DEGC})
            said = gateway.said().count("priority 10 relinquished")
            gateway = self.start_gateway()
            self.assertEqual(gateway.said().count("priority 10 relinquished"), said + 1)
            until(self.controlled, 30)
            self.assertEqual(daemon.said().count("somebody else has set the setpoint"), 1)  # the person's

        with self.step("a device that dies is no reading, and one that returns is no override"):
            self.device.kill(signal.SIGKILL)
            until(lambda: {"gateway failed", "no reading", "signal lost"} & self.reasons(), 30)
            self.start_device(with_plant=True)
            self.assertEqual(self.device.slots(), {})
            until(self.controlled, 60)
            self.assertEqual(daemon.said().count("somebody else has set the setpoint"), 1)  # the person's

        with self.step("stopped in order: nothing is left in the device"):
            self.assertEqual(daemon.kill(signal.SIGTERM), 0)
            self.assertEqual(gateway.kill(signal.SIGTERM), 0)
            self.assertEqual(self.device.slots(), {})
