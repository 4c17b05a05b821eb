"""Site file and point map are the same thing to airsided and to the gateway: registers, fingerprint, refusals."""

import contextlib
import io
import json
import re
import socket
import subprocess
from unittest import main

from airside_bacnet.main import main as gateway_main
from airside_bacnet.objects import TYPES
from airside_bacnet.point_map import load_point_map
from airside_bacnet.values import judge
from desk import BIN, DEVICE, HEADER, OWN_ROWS, SETPOINT_ROW, BacnetTest, full_map

ROOM_ROW = f"room_temp_1,degc,bacnet,{DEVICE}:analog-input:1,5,45\n"
SMALL = HEADER + ROOM_ROW + SETPOINT_ROW + OWN_ROWS
WIDE = ("object,protocol,name,unit,min,max,scale,offset,max_rate,stale_s,write_policy,default,readback\n"
        f"{DEVICE}:analog-input:1,bacnet,room_temp_1,degc,5,45,0.5555555556,-17.77777778,1.0,1200,,,\n"
        f"{DEVICE}:loop:2:setpoint,bacnet,shown,degc,5,45,0.1,,,,,,\n"
        f"{DEVICE}:analog-value:1,bacnet,setpoint,degc,8,32,,,,,on-change,18,shown\n"
        f"{DEVICE}:binary-value:3,bacnet,heartbeat,,0,1,,,,,,,\n"
        "gateway,bacnet,map_fingerprint,,0,4294967295,,,,,,,\n")
BAD_MAPS = {  # what is written for what, and what both complain of
    "an unknown protocol": ("bacnet,1201:analog-input:1", "bacnet4,1201:analog-input:1", "column protocol"),
    "a protocol in capitals": ("bacnet,1201:analog-input:1", "BACnet,1201:analog-input:1", "column protocol"),
    "no object": ("1201:analog-input:1", "", "column object"),
    "an object with a comma": ("1201:analog-input:1", '"1201:analog-input,1"', "column object"),
    "an unknown type": ("analog-input", "analogue-input", "column object"),
    "an instance out of range": ("1201:analog-input:1", "1201:analog-input:4194303", "column object"),
    "a device that is a name": ("1201:analog-input:1", "AHU-1:analog-input:1", "column object"),
    "a property that is no number": ("1201:analog-input:1", "1201:analog-input:1:units", "column object"),
    "a setpoint that is an input": ("analog-output:1", "analog-input:9", "column object"),
    "a setpoint that is a state": ("analog-output:1", "binary-value:1", "column object"),
    "the same object twice": ("setpoint,", "b,,bacnet,1201:analog-input:1,0,1\nsetpoint,", "column object"),
    "the same name twice": ("setpoint,", "room_temp_1,degc,bacnet,1201:analog-input:8,0,1\nsetpoint,", "column name"),
    "no heartbeat": (OWN_ROWS.split("\n")[0] + "\n", "", "points.csv"),
    "no fingerprint": (OWN_ROWS.split("\n")[1] + "\n", "", "points.csv"),
    "a fingerprint of a device": ("map_fingerprint,,bacnet,gateway", "map_fingerprint,,bacnet,1201:analog-value:9",
                                  "column object"),
    "a clock": ("heartbeat,", "clock_s,s,bacnet,1201:analog-value:8,0,1\nheartbeat,", "column name"),
    "a missing comma": ("1201:analog-input:1,5,45", "1201:analog-input:1,5", ":2"),
    "an unknown column": ("name,unit", "nmae,unit", "header"),
}
BAD_SITES = {
    "an address without prefix": ("127.0.0.1/32", "127.0.0.1", "bacnet.address"),
    "a card's name": ("127.0.0.1/32", "eth0/24", "bacnet.address"),
    "a priority for life safety": ("timeout_s = 1.5", "timeout_s = 1.5\npriority = 2", "bacnet.priority"),
    "a priority that is a text": ("timeout_s = 1.5", 'timeout_s = 1.5\npriority = "10"', "bacnet.priority"),
    "a misspelt key": ("timeout_s = 1.5", "timeout = 1.5", "bacnet"),
    "a slow device and a short deadline": ("timeout_s = 1.5", "timeout_s = 6.0", "timeout_s"),
    "values that are stale at once": ("timeout_s = 1.5", "timeout_s = 1.5\nstale_s = 20.0", "bacnet.stale_s"),
    "a device without address": ("1201@127.0.0.1", "1201", "bacnet.devices"),
    "a network of the bus": ('host = "127.0.0.1"', 'host = "192.168.1.9"', "host"),
    "a serial line": ('host = "127.0.0.1"', 'transport = "rtu"\ndevice = "/dev/ttyS0"', "modbus"),
    "a heartbeat that is slower than its watch": ("deadline_s = 5.0", "deadline_s = 5.0\nheartbeat_s = 30.0",
                                                  "heartbeat_timeout_s"),
    "no TOML": ("[bacnet]", "[bacnet", "site.toml"),
}


class Files(BacnetTest):
    points = full_map()

    def gateway_says(self):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = gateway_main(["--site", str(self.folder / "site.toml"), "--check"])
        return subprocess.CompletedProcess("airside-bacnet", code, out.getvalue(), err.getvalue())

    def daemon_says(self):
        return subprocess.run([BIN / "airsided", "--check", "--site", self.folder / "site.toml"], capture_output=True,
                              text=True, check=False)

    def expect_refused_by_both(self, place):
        for done in (self.gateway_says(), self.daemon_says()):
            self.assertEqual(done.returncode, 1, done)
            self.assertRegex(done.stderr, r"^[\w-]+: .*" + re.escape(place) + r".*: found .+; expected .+; .+\n$")

    def test_both_make_the_same_fingerprint_of_a_map(self):
        for text in (full_map(), full_map("1201:analog-value:1")):
            (self.folder / "points.csv").write_text(text, encoding="utf-8")
            self.compare_fingerprints()

    def test_both_make_the_same_fingerprint_of_every_column(self):
        site = self.folder / "site.toml"
        small = site.read_text(encoding="utf-8").replace("5vav-5fcu-2power", "1vav-0fcu-0power")
        stand_ins = "[stand_in]\nmau_temp = 18.0\noutdoor_temp = 28.0\nrain = 0\nvav_on = 1\n"
        site.write_text(small + stand_ins, encoding="utf-8")
        (self.folder / "points.csv").write_text(WIDE, encoding="utf-8")
        self.compare_fingerprints()

    def compare_fingerprints(self):
        shown = re.search(r"fingerprint ([0-9a-f]{16})", self.gateway_says().stdout)
        checked = subprocess.run([BIN / "airside", "check", self.folder / "site.toml", "--json"], capture_output=True,
                                 text=True, check=False)
        known = re.search(r"fingerprint ([0-9a-f]{16})", json.dumps(json.loads(checked.stdout)))
        self.assertIsNotNone(known, checked.stdout + checked.stderr)
        self.assertEqual(shown.group(1), known.group(1))

    def test_both_accept_the_same_map_and_site(self):
        self.assertEqual(self.gateway_says().returncode, 0)
        self.assertEqual(self.daemon_says().returncode, 0, self.daemon_says())

    def test_a_heartbeat_that_no_ahu_watches_is_said(self):
        self.assertIn("nothing in the AHU notices a power loss", self.gateway_says().stderr)
        (self.folder / "points.csv").write_text(full_map("1305:analog-value:1"), encoding="utf-8")
        self.assertIn("heartbeat of device 1305 and setpoint of device 1201", self.gateway_says().stderr)
        (self.folder / "points.csv").write_text(full_map("1201:analog-value:1"), encoding="utf-8")
        self.assertEqual(self.gateway_says().stderr, "")

    def test_both_know_the_same_object_types(self):
        source = (BIN.parent.parent.parent / "hal" / "points" / "bacnet_row.cpp")
        if not source.exists():
            self.skipTest(f"no {source}")
        listed = re.search(r"object_types = \{\{(.*?)\}\};", source.read_text(encoding="utf-8"), re.S).group(1)
        self.assertEqual(sorted(re.findall(r'"([a-z-]+)"', listed)), sorted(TYPES))

    def test_both_refuse_the_same_maps_at_the_same_place(self):
        for what, (old, new, place) in BAD_MAPS.items():
            with self.subTest(what):
                self.assertIn(old, SMALL)
                (self.folder / "points.csv").write_text(SMALL.replace(old, new, 1), encoding="utf-8")
                self.expect_refused_by_both(place)

    def test_both_refuse_the_same_sites_at_the_same_place(self):
        good = (self.folder / "site.toml").read_text(encoding="utf-8")
        for what, (old, new, place) in BAD_SITES.items():
            with self.subTest(what):
                self.assertIn(old, good)
                (self.folder / "site.toml").write_text(good.replace(old, new, 1), encoding="utf-8")
                self.expect_refused_by_both(place)

    def test_both_ask_for_the_table_where_the_map_is_of_bacnet(self):
        site = self.folder / "site.toml"
        text = re.sub(r"\[bacnet\].*?\[state\]", "[state]", site.read_text(encoding="utf-8"), flags=re.DOTALL)
        site.write_text(text, encoding="utf-8")
        self.expect_refused_by_both("[bacnet]")

    def expect_no_start(self, complaint):
        gateway = self.start_gateway(wait=False)
        self.assertEqual(gateway.process.wait(30), 1)
        self.assertRegex(gateway.said().splitlines()[-1], complaint)

    def test_a_card_that_is_not_there_and_ports_that_are_taken_are_said_at_the_start(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind(("127.0.0.1", self.gateway_port))
            self.expect_no_start(rf"bacnet.address: found .*{self.gateway_port}.*; expected .*free; ")
        with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as other:
            other.bind(("127.0.0.1", self.modbus_port))
            other.listen()
            self.expect_no_start(rf"modbus.port: found {self.modbus_port}.*; expected a free port.*; take another")
        site = self.folder / "site.toml"
        site.write_text(site.read_text(encoding="utf-8").replace("127.0.0.1/32", "192.0.2.77/24"), encoding="utf-8")
        self.expect_no_start(r"bacnet.address: found 192.0.2.77/24.*; expected an address of this machine")

    def test_a_value_is_judged_by_its_flags_and_its_reliability(self):
        sound = [0, 0, 0, 0]
        self.assertEqual(judge({"value": 22.5, "status-flags": sound}).value, 22.5)
        self.assertEqual(judge({"value": 22.5}).value, 22.5)
        self.assertEqual(judge({"value": 22.5, "status-flags": [1, 0, 1, 0]}).value, 22.5)  # in alarm, overridden
        self.assertEqual(judge({"value": 22.5, "reliability": "unknown-property"}).value, 22.5)
        for properties in ({"value": 22.5, "status-flags": [0, 1, 0, 0]}, {"value": 22.5, "status-flags": [0, 0, 0, 1]},
                           {"value": 22.5, "reliability": 4}, {"value": None}, {"value": "unknown-object"},
                           {"value": float("nan")}, {"value": float("inf")}):
            self.assertFalse(judge(properties).is_good, properties)

    def test_registers_are_those_of_the_rule(self):
        point_map, shown = load_point_map(str(self.folder / "points.csv"))
        for place, point in enumerate(point_map.points):
            self.assertEqual((point.address, point.function), (2 * place, 3 if point.written else 4))
        self.assertEqual(shown, point_map.fingerprint & 0xFFFFFFFF)


if __name__ == "__main__":
    main()
