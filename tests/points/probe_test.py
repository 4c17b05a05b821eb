"""`airside probe` proposes what a wrong row should say. The servers are real: `airside serve`, and pymodbus."""

import asyncio
import json
import logging
import socket
import struct
import subprocess
import threading
import time
import unittest

from pymodbus.datastore import ModbusDeviceContext, ModbusServerContext, ModbusSparseDataBlock
from pymodbus.server import ModbusTcpServer

from desk import BIN, Desk

logging.getLogger("pymodbus_internal").setLevel(logging.ERROR)
logging.getLogger("pymodbus.logging").setLevel(logging.ERROR)
HEAD = "name,unit,fc,addr,type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,write_policy,fc_write,default,readback\n"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def float_words(value):
    return list(struct.unpack(">HH", struct.pack(">f", value)))


def room(n, addr, kind="int16", scale="0.01", fc=4, order="big,big", limits="5,45"):
    return f"room_temp_{n},degc,{fc},{addr},{kind},{order},{scale},0,{limits},,,,,,,\n"


SETPOINT = "setpoint,degc,3,0,int16,big,big,0.1,0,8,32,,,,on-change,6,,self\n"


class Device:
    """A Modbus TCP server of pymodbus that has the given registers and no others."""

    def __init__(self, test, input_registers, holding_registers=None):
        self.port = free_port()
        holding = {0: 180} | (holding_registers or {})
        blocks = {"ir": input_registers, "hr": holding}
        context = ModbusServerContext(ModbusDeviceContext(
            **{key: ModbusSparseDataBlock({addr: value % 65536 for addr, value in block.items()})
               for key, block in blocks.items()}), single=True)
        self.loop = asyncio.new_event_loop()
        started = threading.Event()

        async def serve():
            self.server = ModbusTcpServer(context, address=("127.0.0.1", self.port))
            await self.server.listen()
            started.set()
            await self.stop.wait()
            await self.server.shutdown()

        async def whole():
            self.stop = asyncio.Event()
            await serve()
        self.thread = threading.Thread(target=lambda: self.loop.run_until_complete(whole()), daemon=True)
        self.thread.start()
        test.assertTrue(started.wait(20), "pymodbus does not listen")
        test.addCleanup(self.end)

    def end(self):
        self.loop.call_soon_threadsafe(self.stop.set)
        self.thread.join(20)


class Probe(Desk):
    def probe(self, points, port, *options):
        self.write("points.csv", points if points.startswith("name") else HEAD + points)
        self.write("site.toml", f'[site]\nname = "x"\ntopology = "5vav-5fcu-2power"\n[modbus]\nhost = "127.0.0.1"\nport = {port}\n'
                                'points = "points.csv"\n')
        return self.airside("probe", "site.toml", *options)

    def proposals(self, points, port, *options):
        done = self.probe(points, port, "--json", *options)
        self.assertTrue(done.stdout, done.stderr)
        return {p["name"]: p for p in json.loads(done.stdout)["proposals"]}

    def assert_decided(self, proposal, value, **cells):
        self.assertTrue(proposal["decided"], proposal)
        self.assertEqual(proposal["readings"][0]["cells"], cells)
        self.assertAlmostEqual(proposal["readings"][0]["value"], value, places=3)

    def test_a_map_in_order_has_no_proposals(self):
        device = Device(self, {0: 2235, 1: 2310})
        done = self.probe(room(1, 0) + room(2, 1) + SETPOINT, device.port, "--write", "new.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("proposals", done.stdout)
        self.assertIn("nothing to propose", done.stdout)
        self.assertFalse((self.folder / "new.csv").exists())

    def test_scale(self):
        device = Device(self, {0: 2235, 1: 2310, 2: 2188})
        wrong = "".join(room(n, n - 1, scale="1") for n in (1, 2, 3)) + SETPOINT
        done = self.probe(wrong, device.port)
        self.assertEqual(done.returncode, 1)
        self.assertIn("room_temp_1        scale 1 -> 0.01: reads 22.35 degc instead of 2235; so do all 3 doubtful rows of its kind",
                      done.stdout)
        self.assertIn("points.csv is as it was", done.stdout)
        self.assertIn("not in order: room_temp_1, room_temp_2, room_temp_3", done.stderr)
        self.assertEqual(self.text("points.csv"), HEAD + wrong)

    def test_write_makes_a_map_in_order_and_keeps_the_rest(self):
        device = Device(self, {0: 2235, 1: 2310})
        wrong = HEAD + "# rooms\n" + room(1, 0, scale="1") + "\n" + room(2, 1, scale="1") + SETPOINT
        done = self.probe(wrong, device.port, "--write", "new.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.text("new.csv"), HEAD + "# rooms\n" + room(1, 0) + "\n" + room(2, 1) + SETPOINT)
        self.assertEqual(self.text("points.csv"), wrong)
        again = self.probe(wrong, device.port, "--write", "points.csv")
        self.assertEqual(again.returncode, 1)
        self.assertIn("points.csv: found a file that is already there", again.stderr)
        self.assertEqual(self.text("points.csv"), wrong)
        self.assertEqual(self.probe(wrong, device.port, "--write", "points.csv", "--force").returncode, 0)
        self.assertEqual(self.probe(self.text("points.csv"), device.port).returncode, 0)

    def test_orders_and_types(self):
        values = {1: 22.35, 2: 23.1, 3: 21.9}
        registers = {}
        for n, value in values.items():
            high, low = float_words(value)
            registers |= {2 * n: low, 2 * n + 1: high}
        device = Device(self, registers)
        stated_big = "".join(room(n, 2 * n, "float32", "1") for n in values) + SETPOINT
        for n, proposal in enumerate(self.proposals(stated_big, device.port).values(), 1):
            self.assert_decided(proposal, values[n], word_order="little")
        whole = "".join(room(n, 2 * n, "int32", "1") for n in values) + SETPOINT
        for n, proposal in enumerate(self.proposals(whole, device.port).values(), 1):
            self.assert_decided(proposal, values[n], type="float32", word_order="little")
        short = "".join(room(n, 2 * n, "int16", "0.01") for n in values) + SETPOINT
        for n, proposal in enumerate(self.proposals(short, device.port).values(), 1):
            self.assert_decided(proposal, values[n], type="float32", word_order="little", scale="1")

    def test_degrees_fahrenheit(self):
        device = Device(self, {0: 715, 1: 702, 2: 738, 10: 72})
        found = self.proposals("".join(room(n, n - 1, scale="0.1") for n in (1, 2, 3)) + SETPOINT, device.port)
        self.assertEqual(len(found), 3)
        self.assert_decided(found["room_temp_1"], 21.944, scale="0.05555555556", offset="-17.77777778")
        done = self.probe("".join(room(n, n - 1, scale="0.1") for n in (1, 2, 3)) + SETPOINT, device.port)
        self.assertIn("(degrees Fahrenheit)", done.stdout)

    def test_what_is_in_order_either_way_goes_with_its_kind(self):
        device = Device(self, {0: 450, 1: 0, 2: 1000, 10: 2235})
        dampers = "".join(f"damper_{n},,4,{n - 1},uint16,big,big,1,0,0,1,,,,,,,\n" for n in (1, 2, 3))
        found = self.proposals(dampers + room(1, 10) + SETPOINT, device.port)
        self.assertEqual(sorted(found), ["damper_1", "damper_2", "damper_3"])
        for name, value in (("damper_1", 0.45), ("damper_2", 0), ("damper_3", 1)):
            self.assert_decided(found[name], value, scale="0.001")

    def test_function(self):
        device = Device(self, {500: 1}, {10: 2235, 11: 2301})
        found = self.proposals(room(1, 10) + room(2, 11) + SETPOINT, device.port)
        self.assert_decided(found["room_temp_1"], 22.35, fc="3")
        self.assert_decided(found["room_temp_2"], 23.01, fc="3")

    def test_a_block_that_is_off_by_one(self):
        device = Device(self, {10: 2235, 11: 2301, 12: 2290, 13: 812, 14: 1790})
        wrong = (room(1, 11) + room(2, 12) + room(3, 13) + "outdoor_temp,degc,4,14,int16,big,big,0.01,0,-40,60,,,,,,,\n"
                 "supply_temp,degc,4,15,int16,big,big,0.01,0,-10,60,,,,,,,\n" + SETPOINT)
        found = self.proposals(wrong, device.port)
        self.assertEqual([p["readings"][0]["cells"] for p in found.values()], [{"addr": str(a)} for a in range(10, 15)])
        self.assertIn("one register lower", found["room_temp_1"]["evidence"])
        self.assertNotIn("setpoint", found)
        self.assertEqual(self.probe(wrong, device.port, "--write", "new.csv").returncode, 0)
        self.assertEqual(self.probe(self.text("new.csv"), device.port).returncode, 0)

    def test_several_plausible_readings_are_named_and_left(self):
        device = Device(self, {0: 2235, 9: 250})
        wrong = room(1, 0) + "outdoor_temp,degc,4,9,int16,big,big,1,0,-40,60,,,,,,,\n" + SETPOINT
        done = self.probe(wrong, device.port, "--write", "new.csv")
        self.assertEqual(done.returncode, 1)
        self.assertIn("left as it is, several readings fit: ", done.stdout)
        for reading in ("scale 1 -> 0.1 gives 25 degc", "scale 1 -> 0.01 gives 2.5 degc"):
            self.assertIn(reading, done.stdout)
        self.assertFalse((self.folder / "new.csv").exists())

    def test_objects_of_bacnet_get_columns_that_their_map_lacks(self):
        registers = {}
        for place, value in enumerate((71.5, 70.2, 55.0)):
            registers |= {2 * place: float_words(value)[0], 2 * place + 1: float_words(value)[1]}
        device = Device(self, registers | {10: 0, 11: 0}, {6: float_words(18)[0], 7: float_words(18)[1], 8: 0, 9: 0})
        points = ("name,unit,protocol,object,min,max\n" + "".join(
            f"room_temp_{n},degc,bacnet,1201:analog-input:{n},5,45\n" for n in (1, 2)) +
            "supply_temp,degc,bacnet,1201:analog-input:9,-10,60\nsetpoint,degc,bacnet,1201:analog-output:1,8,32\n"
            "heartbeat,,bacnet,gateway,0,65535\nmap_fingerprint,,bacnet,gateway,0,4294967295\n")
        done = self.probe(points, device.port, "--write", "new.csv")
        self.assertIn("(degrees Fahrenheit)", done.stdout, done.stderr)
        row = self.rows("new.csv")["room_temp_2"]
        self.assertEqual((row["scale"], row["offset"]), ("0.5555555556", "-17.77777778"))
        self.assertEqual(self.rows("new.csv")["supply_temp"]["scale"], "", "55 degC is no supply air, but within its limits")

    def test_nothing_fits_and_no_value(self):
        device = Device(self, {0: 0, 1: 0x8000, 2: 2235})
        found = self.proposals(room(1, 0) + "room_temp_2,degc,4,1,int16,big,big,0.01,0,5,45,,,0x8000,,,,\n" + room(3, 2) + SETPOINT,
                               device.port)
        self.assertEqual([p["readings"] for p in found.values() if p["decided"]], [])

    def test_a_served_room_with_another_map(self):
        """The simulated AHU, as `airside serve` has it; the site's map is wrong in scale, orders and function."""
        self.assertEqual(self.airside("init", "truth").returncode, 0)
        true_map = self.text("truth/points.csv").replace("float32,big,big", "float32,big,little")
        true_map = "".join(line for line in true_map.splitlines(keepends=True) if not line.startswith("map_fingerprint"))
        self.write("truth/points.csv", true_map)
        port = free_port()
        self.replace("truth/site.toml", "port = 502", f"port = {port}")
        server = subprocess.Popen([BIN / "airside", "serve", "--plant", "rc", "--room", "301-real", "--site", "truth/site.toml",
                                   "--expert-days", "0", "--days", "2", "--ready", "ready"], cwd=self.folder,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(server.stderr.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        until = time.monotonic() + 60
        while not (self.folder / "ready").exists() and server.poll() is None and time.monotonic() < until:
            time.sleep(0.02)
        wrong = []
        for line in true_map.splitlines(keepends=True):
            if line.startswith("room_temp"):
                line = line.replace(",0.01,0,", ",1,0,")
            elif line.startswith("fcu_temp"):
                line = line.replace(",0.01,0,", ",0.1,0,")
            elif line.startswith("supply_temp"):
                line = line.replace("supply_temp,degc,4,", "supply_temp,degc,3,")
            wrong.append(line.replace("float32,big,little", "float32,big,big"))
        wrong = "".join(wrong)
        done = self.probe(wrong[wrong.index("name,"):], port, "--write", "new.csv")
        self.assertTrue((self.folder / "new.csv").exists(), done.stdout + done.stderr)
        new, true = self.rows("new.csv"), self.rows("truth/points.csv")
        for name, row in true.items():
            if name.startswith(("room_temp", "fcu_temp")):
                self.assertEqual(new[name]["scale"], row["scale"], name)
            if name.startswith("power"):
                self.assertEqual(new[name]["word_order"], "little", done.stdout)
        self.assertEqual(new["supply_temp"]["fc"], "4", done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(self.probe(self.text("new.csv")[self.text("new.csv").index("name,"):], port).returncode, 0)


if __name__ == "__main__":
    unittest.main()
