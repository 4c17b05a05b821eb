"""A real mosquitto on a free port, a client that listens to it, and airside-mqtt on a site of its own."""

import json
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import paho.mqtt.client as paho

BIN = Path(os.environ["AIRSIDE_BIN"])
MOSQUITTO = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/sbin")
SITE = """[site]
name = "{name}"
topology = "{topology}"
[state]
dir = "state"
[mqtt]
host = "{host}"
port = {port}
{more}
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def within(seconds, holds, what):
    """Waits until holds() is true and returns its value."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        found = holds()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError(f"not within {seconds} s: {what}")


class Broker:
    """mosquitto, which keeps nothing over a restart."""

    def __init__(self, folder, lines=("allow_anonymous true",)):
        self.port, self.folder, self.process = free_port(), Path(folder), None
        self.log = self.folder / "broker.log"
        (self.folder / "broker.conf").write_text(
            f"user {os.environ.get('USER') or 'root'}\npersistence false\nlog_dest stderr\nlog_type all\n"
            f"connection_messages true\nlistener {self.port} 127.0.0.1\n" + "\n".join(lines) + "\n")
        self.start()

    def start(self):
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen([MOSQUITTO, "-c", str(self.folder / "broker.conf")], stdout=log, stderr=log)
        within(10, self.answers, "mosquitto listens")

    def answers(self):
        if self.process.poll() is not None:
            raise AssertionError(f"mosquitto ended: {self.log.read_text()}")
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def stop(self, number=signal.SIGTERM):
        self.process.send_signal(signal.SIGCONT)
        self.process.send_signal(number)
        self.process.wait(10)


class Listener:
    """Everything that the broker says, and how often: topic -> newest payload."""

    def __init__(self, broker, **login):
        self.retained, self.heard, self.messages = {}, {}, []
        self.client = paho.Client(paho.CallbackAPIVersion.VERSION2, client_id=f"listener-{time.monotonic_ns()}")
        if login:
            self.client.username_pw_set(login["username"], login["password"])
        self.client.on_connect = lambda client, *_: client.subscribe("#", qos=1)
        self.client.on_message = self.take
        self.client.reconnect_delay_set(1, 1)
        self.client.connect("127.0.0.1", broker.port)
        self.client.loop_start()

    def take(self, _client, _self, message):
        payload = message.payload.decode()
        self.messages.append((message.topic, payload))
        self.heard[message.topic] = payload
        if message.retain:
            self.retained[message.topic] = payload

    def close(self):
        self.client.loop_stop()
        self.client.disconnect()


def retained_at(broker, wait_s=0.4, **login):
    """What a client that comes now is shown."""
    listener = Listener(broker, **login)
    time.sleep(wait_s)
    listener.close()
    return listener.retained


def status(**changes):
    """A status as airsided writes it, of three rooms."""
    found = {"time": "2021-08-02T10:00:00", "site": "Room 301", "topology": "3vav-0fcu-1power", "stopped": False,
             "state": "run", "reason": "none", "why": "why", "way_out": "", "alarms": [], "target_degc": 25.25,
             "held_degc": 25.2, "room_temp_degc": [25.1, None, 25.3], "setpoint_degc": 22.4,
             "expected_held_degc": 25.24, "confidence": 0.8}
    return {**found, **changes}


@unittest.skipUnless(MOSQUITTO, "mosquitto is not installed: run tools/setup --for test")
class Desk(unittest.TestCase):
    NAME, TOPOLOGY = "Room 301", "3vav-0fcu-1power"
    BROKER = ("allow_anonymous true",)
    AVAILABILITY, STATUS = "airside/room_301/availability", "airside/room_301/status"

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="airside-mqtt-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        (self.folder / "state").mkdir()
        self.said_at = self.folder / "said.txt"
        self.process = None

    def start_broker(self, lines=None):
        broker = Broker(self.folder, lines or self.BROKER)
        self.addCleanup(broker.stop, signal.SIGKILL)
        return broker

    def listen(self, broker, **login):
        listener = Listener(broker, **login)
        self.addCleanup(listener.close)
        return listener

    def write_site(self, port, more="", host="127.0.0.1"):
        (self.folder / "site.toml").write_text(
            SITE.format(name=self.NAME, topology=self.TOPOLOGY, host=host, port=port, more=more))

    def write_status(self, age_s=0, **changes):
        """Replaced whole, as the daemon does it."""
        text = json.dumps(status(**changes), separators=(",", ":"))
        new = self.folder / "state" / "status.json.new"
        new.write_text(text + "\n")
        os.utime(new, (time.time() - age_s,) * 2)
        new.rename(self.folder / "state" / "status.json")
        return text

    def start(self):
        with open(self.said_at, "ab") as said:
            self.process = subprocess.Popen([BIN / "airside-mqtt", "--site", self.folder / "site.toml"], stdout=said,
                                            stderr=said)
        self.addCleanup(self.kill, self.process)
        return self.process

    @staticmethod
    def kill(process):
        if process.poll() is None:
            process.kill()
            process.wait()

    def said(self):
        return self.said_at.read_text()

    def run_once(self, *arguments):
        return subprocess.run([BIN / "airside-mqtt", "--site", self.folder / "site.toml", *arguments],
                              capture_output=True, text=True, timeout=40, check=False)

    def says(self, text, seconds=10):
        within(seconds, lambda: text in self.said(), f"\"{text}\" in: {self.said() if self.said_at.exists() else ''}")

    def hears(self, listener, topic, payload, seconds=10):
        within(seconds, lambda: listener.heard.get(topic) == payload,
               f"{topic} = {payload}; heard {listener.heard.get(topic)}; said {self.said()}")
