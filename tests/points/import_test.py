"""tools/points/import_points: what it makes of lists is what they say, and `airside check` takes it."""

import os
import subprocess
import sys
import unittest

from desk import Desk, IMPORT, ROOT

EUROPEAN = """Anlage 3;;;;;;;
;;;;;;;
Tag name;Description;Modbus address (0-based);FC;Format;Multiplier;EU;Endian
VAV-302/RmTemp;Room 302;11;3;signed;0,1;°C;
VAV-301/RmTemp;Room 301;10;3;signed;0,1;°C;
VAV-302/Sts;;30;01;;;;
VAV-301/Sts;;31;coil;;;;
AHU-1 Discharge Air Temp Setpoint;;100;3/16;real;;degF;CDAB
AHU-1 Discharge Air Temperature;;102;4;real;;degF;word swap
"""
GERMAN = """Bezeichnung;Adresse;Datentyp;Faktor;Einheit;Beschreibung;Zugriff
VAV1 room temp;30001;INT16;0,1;Grad C;Raum 1;nur lesen
SAT SP;40001;Ganzzahl;0,1;°C;Zuluft;Lesen/Schreiben
"""
CHINESE = """名稱,暫存器位址（Modbus）,資料型別,倍率,單位,說明,讀寫
VAV1 room temp,30001,INT16,0.1,攝氏,室溫,唯讀
SAT SP,40001,整數,0.1,°C,送風溫度設定,讀寫
"""
BOXES = """Name,Register,Type,Scale
AHU7/KL-01/RmTmp,30001,INT16,0.1
AHU7/KL-02/RmTmp,30002,INT16,0.1
AHU7/KL-01/OCC,10001,,
AHU7/KL-02/OCC,10002,,
VAV-09.OCC,10009,,
AHU7.DaTmpSetp,40001,INT16,0.1
"""
BACNET = """Object name,Object type,Instance,Device instance,Unit,R/W
VAV 1 Zone Temp,AI,3,1201,degF,R
VAV 2 Zone Temp,analog input,4,1201,degF,R
Supply Air Temp Stpt,AO,1,1201,°C,RW
Outside Air Temp,AI,9,1201,°C,R
Lobby lights,BO,77,1201,,RW
"""


class Import(Desk):
    def check(self):
        done = self.airside("check", "site.toml")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_example_is_taken_in_both_forms(self):
        self.assertEqual(self.import_list("--example", "example").returncode, 0)
        facts = self.imported("example/list.csv", "-o", "points.csv")
        self.assertEqual(facts["topology"], "3vav-0fcu-1power")
        self.assertEqual([entry["name"] for entry in facts["left_out"]], ["AHU3.FILTER"])
        self.assertIn("list.csv:11", facts["left_out"][0]["place"])
        rows = self.rows()
        self.assertEqual(len(rows), 12)
        expected = {"room_temp_3": ("4", "2", "int16", "0.1", "0"), "supply_temp": ("4", "20", "int16", "0.05555555556", "-17.77777778"),
                    "power_1": ("4", "30", "float32", "0.001", "0"), "damper_2": ("4", "11", "uint16", "0.001", "0"),
                    "setpoint": ("3", "0", "int16", "0.1", "0"), "ahu_on": ("2", "0", "discrete", "", "")}
        for name, cells in expected.items():
            self.assertEqual(tuple(rows[name][c] for c in ("fc", "addr", "type", "scale", "offset")), cells, name)
        self.assertEqual((rows["power_1"]["byte_order"], rows["power_1"]["word_order"]), ("big", "little"))
        self.assertEqual((rows["setpoint"]["write_policy"], rows["setpoint"]["fc_write"]), ("on-change", "6"))
        self.imported("example/list.xlsx", "--map", "example/map.toml", "-o", "other.csv")
        self.assertEqual(self.rows("other.csv"), rows)
        self.site(facts["topology"], facts["stand_in"])
        self.assertEqual(self.import_list("example/list.xlsx", "--site", "site.toml", "-o", "points.csv", "--force").returncode, 0)
        self.check()

    def test_semicolons_decimal_commas_and_room_numbers(self):
        self.write("list.csv", EUROPEAN)
        facts = self.imported("list.csv", "-o", "points.csv")
        self.assertIn("numbers have a decimal comma", facts["notes"])
        self.assertIn("VAV box 301 is place 1, 302 is place 2", facts["notes"])
        rows = self.rows()
        self.assertEqual((rows["room_temp_1"]["addr"], rows["room_temp_2"]["addr"], rows["room_temp_1"]["scale"]), ("10", "11", "0.1"))
        self.assertEqual((rows["vav_on_1"]["fc"], rows["vav_on_1"]["addr"], rows["vav_on_1"]["type"]), ("1", "31", "coil"))
        self.assertEqual((rows["setpoint"]["word_order"], rows["setpoint"]["fc_write"]), ("little", "16"))
        self.site(facts["topology"], facts["stand_in"])
        self.imported("list.csv", "-o", "points.csv", "--force")
        self.check()

    def test_headings_in_german_and_chinese(self):
        self.import_list("--example", "example")
        for text in (GERMAN, CHINESE):
            self.write("list.csv", text)
            facts = self.imported("list.csv", "-o", "points.csv", "--force")
            self.assertEqual(facts["unused_columns"], [])
            self.assertEqual(self.imported("list.csv", "--map", "example/map.toml", "-o", "points.csv", "--force"), facts)
            rows = self.rows()
            for name in ("room_temp_1", "setpoint"):
                self.assertEqual([rows[name][key] for key in ("scale", "addr", "unit")], ["0.1", "0", "degc"])

    def test_what_the_list_does_not_say_is_said(self):
        self.write("list.csv", "Name,Register,Type,Skal,Unit\nVAV1 room temp,30001,int16,0.1,C\nSAT SP,40001,float,1,C\n")
        self.write("map.toml", "[list]\nscale = 1\n")
        facts = self.imported("list.csv", "--map", "map.toml", "-o", "points.csv")
        self.assertEqual(facts["unused_columns"], ["Skal"])
        self.assertEqual(self.rows()["room_temp_1"]["scale"], "1")
        self.assertIn("setpoint: no order of bytes in the list, taken as ABCD", " ".join(facts["notes"]))
        done = self.import_list("list.csv", "--map", "map.toml", "-o", "points.csv", "--force")
        self.assertIn("columns that were not used: Skal", done.stderr)
        self.write("map.toml", '[columns]\nscale = ["Skal"]\n')
        facts = self.imported("list.csv", "--map", "map.toml", "-o", "points.csv", "--force")
        self.assertEqual(facts["unused_columns"], [])
        self.assertEqual(self.rows()["room_temp_1"]["scale"], "0.1")

    def test_patterns_of_ones_own_go_first_and_a_box_is_not_the_building(self):
        self.write("list.csv", BOXES)
        self.write("map.toml", '[roles]\n"room_temp_{n}" = ["* kl {n} rmtmp"]\n"vav_on_{n}" = ["* kl {n} occ"]\n')
        facts = self.imported("list.csv", "--map", "map.toml", "-o", "points.csv")
        self.assertEqual(facts["rows"], {"room_temp_1": 2, "room_temp_2": 3, "vav_on_1": 4, "vav_on_2": 5, "setpoint": 7})
        self.assertIn("the number of a box (vav 9), and occupied has no such number", facts["left_out"][0]["remedy"])
        self.write("list.csv", BOXES + "FCU-03 Room Temp,30020,INT16,0.1\n")
        self.write("map.toml", '[roles]\n"room_temp_{n}" = ["* kl|fcu {n} rmtmp", "* fcu {n} room temp"]\n')
        facts = self.imported("list.csv", "--map", "map.toml", "-o", "points.csv", "--force")
        self.assertEqual((facts["rows"]["room_temp_3"], len(facts["left_out"])), (8, 3))
        self.assertIn('read as "ahu 7 kl 1 occupied"', facts["left_out"][0]["remedy"])

    def test_numbers_of_inputs_are_no_boxes(self):
        self.write("list.csv", "Name,Register,Type,Scale\nAI-01 OAT,30001,INT16,0.1\nAI-02 VAV1 room temp,30002,INT16,0.1\n"
                               "AO-01 SAT SP,40001,INT16,0.1\nAI-03 SAT,30003,INT16,0.1\n")
        self.assertEqual(self.imported("list.csv", "-o", "points.csv")["left_out"], [])

    def test_an_output_that_nobody_reads_to_its_end(self):
        self.write("list.csv", BACNET)
        read, written = os.pipe()
        os.close(read)
        done = subprocess.run([sys.executable, "-B", IMPORT, "list.csv", "-o", "points.csv"], cwd=self.folder, stdout=written,
                              stderr=subprocess.PIPE, text=True, check=False)
        os.close(written)
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        self.assertIn("room_temp_2", self.rows())

    def test_objects_of_bacnet(self):
        self.write("list.csv", BACNET)
        facts = self.imported("list.csv", "-o", "points.csv")
        self.assertEqual((facts["protocol"], facts["topology"]), ("bacnet", "2vav-0fcu-0power"))
        rows = self.rows()
        self.assertEqual(rows["room_temp_2"]["object"], "1201:analog-input:4")
        self.assertEqual(rows["setpoint"]["object"], "1201:analog-output:1")
        self.assertIn("map_fingerprint", rows)
        self.site(facts["topology"], facts["stand_in"])
        self.imported("list.csv", "-o", "points.csv", "--force")
        self.replace("site.toml", "port = 502", "port = 1502")
        self.write("site.toml", self.text("site.toml") + '\n[bacnet]\naddress = "192.168.1.30/24"\n')
        self.check()

    def test_the_ways_to_write_a_register(self):
        ways = {"40011": ("3", "10"), "400011": ("3", "10"), "4x0011": ("3", "10"), "HR10": ("3", "10"), "0x000A": ("3", "10"),
                "000Ah": ("3", "10"), "30011": ("4", "10"), "IR10": ("4", "10")}
        for written, (fc, addr) in ways.items():
            function = "3" if written.lower().startswith("0") else ""
            style = ["--addresses", "zero-based"] if written[0] in "HI" else []
            self.write("list.csv", f"Name,Register,Function,Type,Scale\nVAV1 room temp,{written},{function},int16,/10\n"
                                   f"SAT SP,{'0x0063' if function else 'HR99' if style else '40100'},{function},int16,0.1\n")
            self.imported("list.csv", *style, "-o", "points.csv", "--force")
            row = self.rows()["room_temp_1"]
            self.assertEqual((row["fc"], row["addr"], row["scale"]), (fc, addr, "0.1"), written)

    def test_headings_that_say_how_to_read_a_column(self):
        self.write("list.csv", "Name,Register (hex),FC,Type,Scale\nVAV1 room temp,A,3,int16,0.1\nSAT SP,10,3,int16,0.1\n")
        self.imported("list.csv", "-o", "points.csv")
        self.assertEqual([row["addr"] for row in self.rows().values()], ["10", "16"])
        self.write("list.csv", "Name,Type,Instance,Device\nVAV1 room temp,AI,7,12\nSAT SP,AV,8,12\n")
        self.imported("list.csv", "-o", "points.csv", "--force")
        self.assertEqual(self.rows()["setpoint"]["object"], "12:analog-value:8")

    def test_a_mapping_of_ones_own(self):
        self.write("list.csv", "Punkt,Reg.,Art,Faktor\nB17,40001,INT16,0.1\nY1,40002,INT16,0.1\nVAV1 room temp,40003,INT16,0.1\n")
        self.write("map.toml", '[columns]\nname = ["punkt"]\ntype = ["art"]\nscale = ["faktor"]\n'
                               '[names]\nB17 = "room_temp_2"\nY1 = "setpoint"\n"VAV1 room temp" = ""\n')
        facts = self.imported("list.csv", "--map", "map.toml", "-o", "points.csv")
        self.assertEqual(facts["rows"], {"room_temp_1": 2, "setpoint": 3})
        self.assertEqual(self.rows()["room_temp_1"]["addr"], "0")

    def test_limits_are_those_of_airside_init(self):
        done = self.airside("init", ".", "--objective", "band", "--topology", "1vav-1fcu-1power")
        self.assertEqual(done.returncode, 0, done.stderr)
        sys.path.insert(0, str(ROOT / "tools" / "points"))
        from roles import ROLES
        compared = 0
        for name, row in self.rows().items():
            role = ROLES.get(name.removesuffix("_1"))
            if role is None:
                continue
            self.assertEqual((row["unit"], float(row["min"]), float(row["max"]), row["max_rate"], row["stale_s"]),
                             (role.unit, role.least, role.most, role.rate, role.stale), name)
            compared += 1
        self.assertEqual(compared, len(ROLES) - 1)  # init has no device_heartbeat


if __name__ == "__main__":
    unittest.main()
