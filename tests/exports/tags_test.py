"""airside tags: Brick by the ontology's own shapes, Haystack by its form; names that need escapes; registers that are right."""

import csv
import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import brickschema
import rdflib
from phable.io.ph_json import ph_from_json  # reads a grid as a client of a Haystack server does
from phable.kinds import Grid, Marker, Ref

BIN = Path(os.environ["AIRSIDE_BIN"])
BRICK = rdflib.Namespace("https://brickschema.org/schema/Brick#")
REC = rdflib.Namespace("https://w3id.org/rec#")
REF = rdflib.Namespace("https://brickschema.org/schema/Brick/ref#")
UNIT = rdflib.Namespace("http://qudt.org/vocab/unit/")
SH = rdflib.Namespace("http://www.w3.org/ns/shacl#")
AIRSIDE = rdflib.Namespace("urn:airside:vocabulary#")
BACNET = rdflib.Namespace("http://data.ashrae.org/bacnet/2020#")
NAME = "房間 301 \\ l'étage"


BACNET_ANSWERS = """
[site]
vavs = 2
fcus = 0
powers = 0
[bus]
transport = "bacnet"
address = "192.168.1.30/24"
[signals.room_temp]
object = "1201:analog-input:3"
scale = 0.5555555556
offset = -17.77777778
[signals.vav_on]
object = "1201:binary-value:12"
[signals.supply_temp]
object = "1202:loop:2:controlled-variable-value"
[signals.setpoint]
object = "1201:analog-output:1"
"""


def airside(*arguments, code=0):
    done = subprocess.run([BIN / "airside", *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    return done


class Tags(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """One site with everything that a point map may hold, a zone with two sensors, and names that need escapes."""
        cls.folder = Path(tempfile.mkdtemp(prefix="airside-tags-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        airside("init", cls.folder, "--topology", "3vav-2fcu-1power", "--objective", "band")
        points = (cls.folder / "points.csv").read_text()
        row = next(line for line in points.splitlines() if line.startswith("room_temp_2,"))
        fields = row.split(",")
        two = [",".join([f"room_temp_2{letter}", fields[1], fields[2], str(500 + i), *fields[4:]])
               for i, letter in enumerate("ab")]
        (cls.folder / "points.csv").write_text(points.replace(row, "\n".join(two)))
        site = (cls.folder / "site.toml").read_text()
        for old, new in (('name = "Room 301"', f"name = '''{NAME}'''"), ('dir = "log"', "dir = 'log \"of\" box'")):
            assert site.count(old) == 1, old
            site = site.replace(old, new)
        (cls.folder / "site.toml").write_text(site)
        cls.site = cls.folder / "site.toml"
        with open(cls.folder / "points.csv", newline="") as file:
            rows = csv.DictReader(line for line in file if not line.startswith("#"))
            cls.points = {row["name"]: row for row in rows}

    def tagged(self):
        """Names of the points that mean something to others."""
        return {name for name in self.points if not re.match(r"clock|heartbeat|map_fingerprint", name)}

    def graph(self):
        graph = rdflib.Graph()
        graph.parse(data=airside("tags", self.site, "--format", "brick").stdout, format="turtle")
        return graph

    def judged(self, text, version):
        """(severity, node, message) of what the ontology's shapes have to say of our nodes and references, which
        have no name, and the whole graph.
        Of its own nodes they say that QUDT is not there."""
        graph = brickschema.Graph(load_brick=True, brick_version=version)
        graph.parse(data=text, format="turtle")
        _, results, _ = graph.validate()
        found = [(str(results.value(one, SH.resultSeverity)).partition("#")[2],
                  str(results.value(one, SH.focusNode)).partition("#")[2], str(results.value(one, SH.resultMessage)))
                 for one in results.subjects(rdflib.RDF.type, SH.ValidationResult)
                 if "airside" in str(results.value(one, SH.focusNode))
                 or (None, REF.hasExternalReference, results.value(one, SH.focusNode)) in graph]
        return found, graph

    def test_brick_is_what_the_ontology_allows(self):
        text = airside("tags", self.site).stdout
        for version in ("1.3", "1.4"):
            found, graph = self.judged(text, version)
            self.assertEqual([one for one in found if one[0] == "Violation"], [])
            # Locations have the older word beside the newer one, which is remarked on.
            self.assertEqual([one for one in found if "deprecated in version 1.4.0" not in one[2]], [])
            self.assertEqual({one[1] for one in found}, {"building", *(f"{kind}_{i}" for kind in ("zone", "room") for i in (1, 2, 3))})
        # A class that Brick does not know would pass the shapes.
        own = self.graph()
        for subject, kind in own.subject_objects(rdflib.RDF.type):
            if kind.startswith((str(BRICK), str(REC), str(REF))):
                self.assertIn((kind, rdflib.RDFS.label, None), graph, kind)
                newer = graph.value(kind, BRICK.isReplacedBy)
                self.assertTrue(newer is None or (subject, rdflib.RDF.type, newer) in own, kind)

    def test_the_shapes_do_look(self):
        text = airside("tags", self.site).stdout
        for old, new in ((":room_temp_1 a brick:Zone_Air_Temperature_Sensor", ":room_temp_1 a brick:AHU"),
                         ("brick:hasUnit unit:KiloW", "brick:hasUnit unit:FURLONG"),
                         ("brick:feeds :zone_2", "brick:feeds :room_temp_3")):
            self.assertEqual(text.count(old), 1, old)
            text = text.replace(old, new)
        found, _ = self.judged(text, "1.4")
        self.assertLessEqual({"power_1", "vav_2"}, {one[1] for one in found if one[0] == "Violation"}, found)

    def test_brick_says_what_the_site_has(self):
        graph = self.graph()

        def count(kind):
            return len(set(graph.subjects(rdflib.RDF.type, kind)))

        self.assertEqual([count(BRICK[k]) for k in ("AHU", "VAV", "FCU", "MAU", "Electrical_Meter", "Supply_Fan")],
                         [1, 3, 2, 1, 1, 1])
        self.assertEqual((count(REC.HVACZone), count(REC.Room)), (3, 3))
        self.assertEqual(count(BRICK.Zone_Air_Temperature_Sensor), 4)
        self.assertEqual(count(BRICK.Supply_Air_Temperature_Setpoint), 1)
        site = graph.value(predicate=rdflib.RDF.type, object=REC.Building)
        self.assertEqual(str(graph.value(site, rdflib.RDFS.label)), NAME)
        points = {str(s).partition("#")[2]: s for s in graph.subjects(BRICK.isPointOf)}
        self.assertEqual(set(points), self.tagged())
        for name, point in points.items():
            row = self.points[name]
            self.assertEqual(graph.value(point, BRICK.hasUnit), {"degc": UNIT.DEG_C, "kw": UNIT.KiloW,
                             "m3/s": UNIT["M3-PER-SEC"]}.get(row["unit"], UNIT.UNITLESS if "damper" in name else None), name)
            register = [r for r in graph.objects(point, REF.hasExternalReference)
                        if (r, rdflib.RDF.type, AIRSIDE.ModbusReference) in graph]
            self.assertEqual(len(register), 1, name)
            for predicate, value in (("functionCode", int(row["fc"])), ("address", int(row["addr"])),
                                     ("type", row["type"]), ("scale", float(row["scale"] or 1))):
                self.assertEqual(graph.value(register[0], AIRSIDE[predicate]).toPython(), value, name)
        stored = set(map(str, graph.objects(predicate=REF.storedAt)))
        self.assertEqual(stored, {str(self.folder / 'log "of" box')})
        columns = set(map(str, graph.objects(predicate=REF.hasTimeseriesId)))
        self.assertLessEqual({"room_temp_1_degc", "setpoint_degc", "power_1_kw", "damper_3", "supply_flow_m3s"}, columns)
        self.assertNotIn("room_temp_2a_degc", columns)  # the log has the median of both

    def test_columns_are_those_of_a_log(self):
        log = self.folder / "log.csv"
        airside("simulate", "--plant", "rc", "--room", "modulating-mild", "--site", self.band_site(), "--expert-days", "0",
                "--days", "1", "--log", log)
        header = set(log.read_text().splitlines()[0].split(","))
        graph = rdflib.Graph()
        graph.parse(data=airside("tags", self.band_site()).stdout, format="turtle")
        columns = set(map(str, graph.objects(predicate=REF.hasTimeseriesId)))
        self.assertGreater(len(columns), 15)
        self.assertLessEqual(columns, header)

    def band_site(self):
        folder = self.folder / "band"
        if not folder.exists():
            airside("init", folder, "--objective", "band")
        return folder / "site.toml"

    def test_haystack_is_a_grid_of_points_that_belong_to_something(self):
        grid = ph_from_json(airside("tags", self.site, "--format", "haystack").stdout)
        self.assertIsInstance(grid, Grid)
        names = {column.name for column in grid.cols}
        rows = {row["id"].val: row for row in grid.rows}
        self.assertEqual(len(rows), len(grid.rows))  # no id twice
        for row in grid.rows:
            self.assertLessEqual(set(row), names)
            for value in row.values():
                if isinstance(value, Ref):
                    self.assertIn(value.val, rows)
                    self.assertRegex(value.val, r"^[a-zA-Z0-9_:.~-]+$")
        marked = lambda *tags: [r for r in grid.rows if all(isinstance(r.get(t), Marker) for t in tags)]  # noqa: E731
        self.assertEqual([len(marked(*tags)) for tags in (("site",), ("equip", "ahu"), ("equip", "vav"), ("equip", "fcu"),
                                                          ("elec", "meter"), ("space", "zone"))], [1, 1, 3, 2, 1, 3])
        self.assertEqual(marked("site")[0]["dis"], NAME)
        points = marked("point")
        self.assertEqual({p["airsidePoint"] for p in points}, self.tagged())
        for point in points:
            row = self.points[point["airsidePoint"]]
            self.assertIn("siteRef", point)
            self.assertIsInstance(rows[point["equipRef"].val]["equip"], Marker)
            self.assertEqual(sum(t in point for t in ("sensor", "cmd", "sp")), 1, point["dis"])
            self.assertIn(point["kind"], ("Number", "Bool"))
            self.assertEqual(point.get("unit"), {"degc": "°C", "kw": "kW", "m3/s": "m³/s"}.get(row["unit"]))
            self.assertEqual((point["modbusFunctionCode"].val, point["modbusAddress"].val), (int(row["fc"]), int(row["addr"])))
        self.assertEqual([p["airsidePoint"] for p in marked("point", "writable")], ["setpoint"])

    def bacnet_site(self):
        """Two devices, one of which reports degF and one of which has a loop; the gateway watches the heartbeat."""
        folder = self.folder / "bacnet"
        if not folder.exists():
            (self.folder / "answers.toml").write_text(BACNET_ANSWERS)
            airside("init", folder, "--answers", self.folder / "answers.toml")
        with open(folder / "points.csv", newline="") as file:
            rows = {row["name"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}
        self.assertEqual(rows["heartbeat"]["object"], "gateway")
        return folder / "site.toml", {n: r for n, r in rows.items() if r["object"] != "gateway"}

    def test_brick_refers_to_objects_of_bacnet_and_to_no_register_of_the_gateway(self):
        site, rows = self.bacnet_site()
        text = airside("tags", site).stdout
        self.assertNotIn("Modbus", text)
        self.assertNotIn("functionCode", text)
        for version in ("1.3", "1.4"):
            found, _ = self.judged(text, version)
            self.assertEqual([one for one in found if "deprecated in version 1.4.0" not in one[2]], [])
        graph = rdflib.Graph()
        graph.parse(data=text, format="turtle")
        points = {str(s).partition("#")[2]: s for s in graph.subjects(BRICK.isPointOf)}
        self.assertEqual(set(points), set(rows))
        for name, point in points.items():
            objects = [r for r in graph.objects(point, REF.hasExternalReference)
                       if (r, rdflib.RDF.type, REF.BACnetReference) in graph]
            self.assertEqual(len(objects), 1, name)
            device, kind, instance, *other = rows[name]["object"].split(":")
            name_of_property = other[0] if other else "present-value"
            facts = dict(graph.predicate_objects(objects[0]))
            self.assertEqual(str(facts[BACNET["object-identifier"]]), f"{kind},{instance}")
            self.assertEqual(str(facts[BACNET["object-type"]]), kind)
            self.assertEqual(str(facts[REF["bacnet-read-property"]]), name_of_property)
            self.assertEqual(str(facts[REF.BACnetURI]), f"bacnet://{device}/{kind},{instance}/{name_of_property}")
            there = facts[BACNET.objectOf]
            self.assertIn((there, rdflib.RDF.type, BACNET.BACnetDevice), graph)
            self.assertEqual(graph.value(there, BACNET["device-instance"]).toPython(), int(device))
            self.assertEqual(float(facts.get(AIRSIDE.scale, 1)), float(rows[name]["scale"] or 1))
            self.assertEqual(float(facts.get(AIRSIDE.offset, 0)), float(rows[name]["offset"] or 0))
        self.assertEqual(len(set(graph.subjects(rdflib.RDF.type, BACNET.BACnetDevice))), 2)
        # The shapes do look at these references.
        wrong = text.replace(":bacnet_device_1202 a bacnet:BACnetDevice", ":bacnet_device_1202 a brick:AHU")
        self.assertNotEqual(wrong, text)
        found, _ = self.judged(wrong, "1.4")
        self.assertIn("Violation", {one[0] for one in found})

    def test_haystack_has_bacnet_cur_and_no_register_of_the_gateway(self):
        site, rows = self.bacnet_site()
        text = airside("tags", site, "--format", "haystack").stdout
        self.assertNotIn("modbus", text)
        points = {row["airsidePoint"]: row for row in ph_from_json(text).rows if "airsidePoint" in row}
        self.assertEqual(set(points), set(rows))
        self.assertEqual({n: p.get("bacnetCur") for n, p in points.items()},
                         {"room_temp_1": "AI3", "room_temp_2": "AI4", "vav_on_1": "BV12", "vav_on_2": "BV13",
                          "setpoint": "AO1", "supply_temp": None})
        for name, point in points.items():
            device = rows[name]["object"].split(":")[0]
            self.assertEqual(point["bacnetDeviceInstance"].val, int(device))
            self.assertTrue(point["airsideBacnetObject"].startswith(rows[name]["object"]), name)
            self.assertEqual(point["bacnetScale"].val, float(rows[name]["scale"] or 1))
        self.assertEqual(points["supply_temp"]["airsideBacnetObject"], "1202:loop:2:controlled-variable-value")

    def test_a_simulated_site_has_no_registers(self):
        simulated = self.folder / "simulated.toml"
        simulated.write_text('[site]\nname = "a"\ntopology = "1vav-0fcu-0power"\n')
        self.assertNotIn("Modbus", airside("tags", simulated).stdout)
        self.assertNotIn("modbus", airside("tags", simulated, "--format", "haystack").stdout)

    def test_what_is_not_measured_has_no_point(self):
        lacking = self.folder / "lacking"
        airside("init", lacking, "--topology", "1vav-0fcu-0power")
        points = lacking / "points.csv"
        points.write_text("".join(line for line in points.read_text().splitlines(True) if not line.startswith("rain,")))
        (lacking / "site.toml").write_text((lacking / "site.toml").read_text() + "\n[stand_in]\nrain = 0\n")
        self.assertNotIn(":rain a", airside("tags", lacking / "site.toml").stdout)

    def test_a_file_is_written_whole_and_wrong_words_are_refused(self):
        out = self.folder / "site.ttl"
        done = airside("tags", self.site, "-o", out, "--json")
        self.assertEqual(json.loads(done.stdout), {"file": str(out), "format": "brick", "points": len(self.tagged())})
        self.assertEqual(out.read_text(), airside("tags", self.site).stdout)
        self.assertIn("--json: found no -o beside it", airside("tags", self.site, "--json", code=1).stderr)
        airside("tags", self.site, "--format", "zinc", code=2)
        self.assertIn("none.toml", airside("tags", self.folder / "none.toml", code=1).stderr)


if __name__ == "__main__":
    unittest.main()
