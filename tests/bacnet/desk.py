"""What the tests of the gateway share: a folder, ports, the processes of the chain, a person at another BACnet tool."""

import asyncio
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

from airside_bacnet.client import BacnetClient, Device, Refused
from airside_bacnet.objects import ObjectName
from airside_bacnet.site_file import BacnetSection
from bacpypes3.pdu import Address

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BIN = Path(os.environ["AIRSIDE_BIN"])
DEVICE = 1201
SETPOINT = ObjectName(DEVICE, "analog-output", 1)
DEFAULT_DEGC = 24.0  # of the device, where nobody commands

HEADER = "name,unit,protocol,object,min,max\n"
OWN_ROWS = "heartbeat,,bacnet,gateway,0,65535\nmap_fingerprint,,bacnet,gateway,0,4294967295\n"
SETPOINT_ROW = f"setpoint,degc,bacnet,{DEVICE}:analog-output:1,8,32\n"


def full_map(heartbeat="gateway"):
    """Of 5vav-5fcu-2power and the objects of device.py."""
    rows = HEADER
    for n in range(1, 6):
        rows += f"room_temp_{n},degc,bacnet,{DEVICE}:analog-input:{n},5,45\n"
        rows += f"fcu_temp_{n},degc,bacnet,{DEVICE}:analog-input:{10 + n},5,45\n"
        rows += f"vav_on_{n},,bacnet,{DEVICE}:binary-input:{n},0,1\n"
        rows += f"fcu_on_{n},,bacnet,{DEVICE}:binary-input:{10 + n},0,1\n"
    rows += f"power_1,kw,bacnet,{DEVICE}:analog-input:21,0,500\npower_2,kw,bacnet,{DEVICE}:analog-input:22,0,500\n"
    rows += f"mau_temp,degc,bacnet,{DEVICE}:analog-input:31,-20,60\n"
    rows += f"outdoor_temp,degc,bacnet,{DEVICE}:analog-input:32,-40,60\n"
    rows += f"rain,,bacnet,{DEVICE}:binary-input:21,0,1\nsupply_temp,degc,bacnet,{DEVICE}:analog-input:33,-10,60\n"
    return rows + SETPOINT_ROW + OWN_ROWS.replace("bacnet,gateway,0,65535", f"bacnet,{heartbeat},0,65535")


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def until(what, within_s=15.0, every_s=0.05):
    """Waits until `what()` is true; fails with what it last returned."""
    deadline = time.monotonic() + within_s
    while not (last := what()):
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {within_s} s: {what.__doc__ or what}; last {last!r}")
        time.sleep(every_s)
    return last


class Program:
    """A child process with its output in a file; ended with the test."""

    def __init__(self, command, log, stdin=None, stdout=None):
        self.log = Path(log)
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONDONTWRITEBYTECODE": "1"}
        with open(self.log, "a", encoding="utf-8") as file:
            self.process = subprocess.Popen([str(word) for word in command], stdin=stdin, stdout=stdout or file,
                                            stderr=file, text=True, env=environment)

    def said(self):
        return self.log.read_text(encoding="utf-8")

    def has_said(self, text, times=1):
        return self.said().count(text) >= times

    def kill(self, number=signal.SIGKILL):
        if self.process.poll() is None:
            self.process.send_signal(number)
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe:
                pipe.close()
        return self.process.wait(20)


class AhuDevice(Program):
    def __init__(self, folder, port, plant_port=0, instance=DEVICE, address="127.0.0.1/32"):
        command = [sys.executable, "-B", HERE / "device.py", instance, f"{address}:{port}"]
        super().__init__(command + ([plant_port] if plant_port else []), folder / "device.txt", subprocess.PIPE,
                         subprocess.PIPE)
        if not self.process.stdout.readline():
            raise AssertionError("device.py: " + self.said())

    def do(self, **order):
        self.process.stdin.write(json.dumps(order) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise AssertionError("device.py: " + self.said())
        return json.loads(answer)

    def slots(self):
        """{priority: value} of the setpoint's priority array."""
        return {int(k): v for k, v in self.do(priorities=["analog-output", 1])["slots"].items()}


class Operator:
    """Somebody with another BACnet tool, on a port of their own."""

    def __init__(self, device_port):
        self.loop = asyncio.new_event_loop()
        threading.Thread(target=self.loop.run_forever, daemon=True).start()
        self.device = Device(DEVICE, address=Address(f"127.0.0.1:{device_port}"))
        self.client = self.run(self.make())

    async def make(self):
        port = free_port(socket.SOCK_DGRAM)
        return BacnetClient(BacnetSection("127.0.0.1/32", port, instance=4190001, timeout_s=2.0), "operator")

    def run(self, what):
        return asyncio.run_coroutine_threadsafe(what, self.loop).result(20)

    def command(self, value, priority):
        self.run(self.client.command(self.device, SETPOINT, value, priority))

    def relinquish(self, priority):
        self.run(self.client.relinquish(self.device, SETPOINT, priority))

    def close(self):
        async def end():
            self.client.close()

        self.run(end())
        self.loop.call_soon_threadsafe(self.loop.stop)


class BacnetTest(unittest.TestCase):
    """A folder, a site, a device, a gateway. `speed`: of the clocks of plant, gateway and daemon."""

    speed = 60
    points = None
    more_bacnet = ""
    more_site = ""

    def setUp(self):
        base = "/dev/shm" if os.path.isdir("/dev/shm") else None
        self.folder = Path(tempfile.mkdtemp(prefix="airside_bacnet_", dir=base))
        self.addCleanup(self.forget_folder)
        self.modbus_port, self.plant_port = free_port(), free_port()
        self.device_port, self.gateway_port = free_port(socket.SOCK_DGRAM), free_port(socket.SOCK_DGRAM)
        self.write_site()
        (self.folder / "points.csv").write_text(self.points or full_map(), encoding="utf-8")
        for part in ("state", "log", "inbox"):
            (self.folder / part).mkdir()

    def forget_folder(self):
        outcome = getattr(self, "_outcome", None)
        if outcome is None or outcome.success:
            shutil.rmtree(self.folder, ignore_errors=True)
        else:
            print(f"what is left: {self.folder}")

    def write_site(self):
        (self.folder / "site.toml").write_text(f"""[site]
name = "BACnet"
topology = "5vav-5fcu-2power"
[expert]
work_degc = 21.0
off_degc = 21.0
[controller]
cycle_min = 6
[modbus]
host = "127.0.0.1"
port = {self.modbus_port}
deadline_s = 5.0
points = "points.csv"
[bacnet]
address = "127.0.0.1/32"
port = {self.gateway_port}
timeout_s = 1.5
devices = ["{DEVICE}@127.0.0.1:{self.device_port}"]
{self.more_bacnet}[state]
dir = "state"
[log]
dir = "log"
{self.more_site}""", encoding="utf-8")

    def keep(self, program):
        self.addCleanup(program.kill)
        return program

    def start_plant(self):
        """The RC room, free running, behind Modbus."""
        ready = self.folder / "ready"
        plant = self.keep(Program([BIN / "airside", "serve", "--plant", "rc", "--room", "301", "--speed", self.speed,
                                   "--port", self.plant_port, "--ready", ready, "--days", "300"],
                                  self.folder / "plant.txt"))
        until(lambda: ready.exists() or plant.process.poll() is not None, 60)
        self.assertIsNone(plant.process.poll(), plant.said())
        return plant

    def start_device(self, with_plant=False):
        self.device = self.keep(AhuDevice(self.folder, self.device_port, self.plant_port if with_plant else 0))
        return self.device

    def gateway_command(self, *more):
        return [sys.executable, "-B", "-m", "airside_bacnet", "--site", self.folder / "site.toml", *more]

    def start_gateway(self, wait=True):
        gateway = self.keep(Program(self.gateway_command("--clock-speed", self.speed), self.folder / "gateway.txt"))
        before = gateway.said().count("serves ")
        if wait:
            until(lambda: gateway.said().count("serves ") > before or gateway.process.poll() is not None)
            self.assertIsNone(gateway.process.poll(), gateway.said())
        return gateway

    def start_daemon(self):
        return self.keep(Program([BIN / "airsided", "--site", self.folder / "site.toml", "--clock-speed", self.speed,
                                  "--backoff", "0.05", "--crash-limit", "0", "--no-sync"], self.folder / "daemon.txt"))

    def operator(self):
        operator = Operator(self.device_port)
        self.addCleanup(operator.close)
        return operator

    def status(self):
        try:
            return json.loads((self.folder / "state" / "status.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}

    def alarms(self):
        return {alarm["reason"] for alarm in self.status().get("alarms", [])}


__all__ = ["BacnetTest", "AhuDevice", "Operator", "Program", "Refused", "free_port", "full_map", "until", "BIN",
           "DEVICE", "DEFAULT_DEGC", "HEADER", "HERE", "OWN_ROWS", "ROOT", "SETPOINT", "SETPOINT_ROW"]
