"""tools/log_parquet: what pyarrow reads back is what the log says, to the bit."""

import csv
import datetime
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ["AIRSIDE_BIN"])
TEXTS = ("mode", "reason", "fault")


class Parquet(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="airside-parquet-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.log = cls.folder / "log.csv"
        subprocess.run([BIN / "airside", "simulate", "--plant", "rc", "--room", "301-real", "--method", "expert",
                        "--expert-days", "0", "--days", "2", "--log", cls.log], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)

    def convert(self, *logs, options=()):
        out = self.folder / "out.parquet"
        out.unlink(missing_ok=True)
        done = subprocess.run([sys.executable, ROOT / "tools" / "log_parquet", *logs, "-o", out, *options],
                              capture_output=True, text=True, check=False)
        self.assertEqual([p.name for p in self.folder.iterdir() if p.name.endswith(".new")], [])
        return done, out

    def refused(self, text, *parts):
        bad = self.folder / "bad.csv"
        bad.write_bytes(text.encode() if isinstance(text, str) else text)
        done, out = self.convert(bad)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertFalse(out.exists())
        for part in parts:
            self.assertIn(part, done.stderr)

    def test_what_is_read_back_is_the_log(self):
        done, out = self.convert(self.log, options=["--json"])
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.log, newline="") as file:
            header, *rows = csv.reader(file)
        table = pq.read_table(out)
        self.assertEqual(table.column_names, header)
        self.assertEqual(table.num_rows, len(rows))
        self.assertEqual(len(rows), 480)
        facts = json.loads(done.stdout)
        self.assertEqual((facts["rows"], facts["gaps"], facts["left_out"]), (480, 0, 0))
        compared = 0
        for place, name in enumerate(header):
            column = table.column(name).to_pylist()
            for row, value in zip(rows, column):
                text = row[place]
                if name == "time":
                    self.assertEqual(value, datetime.datetime.fromisoformat(text))
                elif text == "":
                    self.assertIsNone(value)
                elif name in TEXTS:
                    self.assertEqual(value, text)
                else:
                    self.assertEqual(struct.pack("d", value), struct.pack("d", float(text)), name)
                    compared += 1
        self.assertGreater(compared, 480 * 20)

    def test_types_and_units(self):
        _, out = self.convert(self.log)
        schema = pq.read_schema(out)
        self.assertEqual(schema.field("time").type, pa.timestamp("ms"))
        self.assertIsNone(schema.field("time").type.tz)
        for name in TEXTS:
            self.assertTrue(pa.types.is_dictionary(schema.field(name).type), name)
        for name, unit in (("room_temp_1_degc", b"degC"), ("power_1_kw", b"kW"), ("rain", b"1"), ("loss_tdb", b"1")):
            self.assertEqual(schema.field(name).type, pa.float64())
            self.assertEqual(schema.field(name).metadata[b"unit"], unit)
        self.assertEqual(schema.metadata[b"format"], b"airside log 1")
        self.assertEqual(json.loads(schema.metadata[b"sources"]), ["log.csv"])

    def test_days_of_a_folder_are_one_table_and_may_differ_in_columns(self):
        days = self.folder / "days"
        days.mkdir()
        head = "time,room_temp_1_degc,power_1_kw_stand_in,setpoint_degc"
        (days / "airside-2021-07-01.csv").write_text(f"{head}\n2021-07-01T23:54:00,25.1,4,22\n")
        (days / "airside-2021-07-02.csv").write_text(
            "time,room_temp_1_degc,damper_1,setpoint_degc,mode,note,meter\n2021-07-02T00:06:00,25.2,0.5,22.5,run,\"a, b\",7\n")
        done, out = self.convert(days, options=["--json"])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["gaps"], 1)
        table = pq.read_table(out)
        self.assertEqual(table.to_pydict(), {
            "time": [datetime.datetime(2021, 7, 1, 23, 54), datetime.datetime(2021, 7, 2, 0, 6)],
            "room_temp_1_degc": [25.1, 25.2], "damper_1": [None, 0.5], "power_1_kw_stand_in": [4.0, None],
            "setpoint_degc": [22.0, 22.5], "mode": [None, "run"], "note": [None, "a, b"], "meter": [None, 7.0]})
        self.assertEqual(table.schema.field("power_1_kw_stand_in").metadata, {b"unit": b"kW", b"stand_in": b"true"})

    def test_a_bad_row_is_named_by_file_and_line(self):
        head = "time,room_temp_1_degc,setpoint_degc\n2021-07-01T00:00:00,25,22\n"
        self.refused(head + "2021-07-01T00:06:00,warm,22\n", "bad.csv:3: room_temp_1_degc: found `warm`",
                     "a number such as 25.3", "--skip-bad")
        self.refused(head + "2021-07-01T00:06:00,25,22,3\n", "bad.csv:3: found 4 fields", "3 as in the header")
        self.refused(head + "2021-07-01T00:06:00,nan,22\n", "bad.csv:3: room_temp_1_degc: found `nan`")
        self.refused(head + "2021-07-01T00:07:00,25,22\n", "bad.csv:3: time", "every 6 min")
        self.refused(head + "1.7.2021 0:06,25,22\n", "bad.csv:3: time: found `1.7.2021 0:06`", "2021-07-01T00:06:00")
        self.refused(head + "2021-07-01T00:00:00,25,22\n", "bad.csv:3: time", "not after 2021-07-01T00:00:00")
        self.refused("a,b\n1,2\n", "bad.csv:1", "`a,b`", "a column `time`")
        self.refused("time,rain,rain\n", "bad.csv:1", "the column `rain` twice")
        self.refused("time;rain\n2021-07-01T00:00:00;0\n", "bad.csv:1: found columns separated by `;`; expected columns",
                     "export with comma as separator and point as decimal mark")
        self.refused("time\train\n", "found columns separated by tabs")
        self.refused("", "bad.csv:1", "a column `time`")
        self.refused(b"PK\x03\x04\xff\xfe\n", "bad.csv:1", "a column `time`")
        self.refused("time,rain\n", "found no row")

    def test_help_needs_no_package(self):
        done = subprocess.run([sys.executable, "-S", ROOT / "tools" / "log_parquet", "--help"], capture_output=True,
                              text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("--skip-bad", done.stdout)

    def test_bad_rows_can_be_left_out_and_are_listed(self):
        bad = self.folder / "bad.csv"
        bad.write_text("time,rain\n2021-07-01T00:00:00,0\n2021-07-01T00:06:00,wet\n2021-07-01T00:12:00,1\n2021-07-01T")
        done, out = self.convert(bad, options=["--skip-bad"])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("left out: " + str(bad) + ":3: rain: found `wet`", done.stderr)
        self.assertIn(str(bad) + ":5: found 1 fields", done.stderr)
        self.assertEqual(pq.read_table(out).column("rain").to_pylist(), [0.0, 1.0])

    def test_places_that_are_none_are_refused(self):
        done, _ = self.convert(self.folder / "none.csv")
        self.assertEqual(done.returncode, 1)
        self.assertIn("none.csv: found No such file or directory; expected a CSV log", done.stderr)
        done = subprocess.run([sys.executable, ROOT / "tools" / "log_parquet", self.log, "-o",
                               self.folder / "no" / "where.parquet"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "where.parquet: found no folder .*/no; expected .*make it")
        self.assertNotIn(".new", done.stderr)
        done = subprocess.run([sys.executable, ROOT / "tools" / "log_parquet", self.log], capture_output=True, check=False)
        self.assertEqual(done.returncode, 2)
