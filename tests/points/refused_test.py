"""tools/points/import_points: what is wrong is refused with place, finding, expectation and remedy; nothing is written."""

import unittest

import openpyxl

from desk import Desk

HEAD = "Name,Register,Type,Scale,Unit\n"
ROOM = "VAV1 zone temp,30001,int16,0.1,°C\n"
SETPOINT = "SAT SP,40001,int16,0.1,°C\n"
# list, options, what the complaint holds
LISTS = {
    "no column of registers": ("Name,Type\nVAV1 zone temp,int16\n", [], ("list.csv:1: found no column of the address", "[columns]")),
    "headings of another language": (
        "Pkt,Adr,Art,Skal,E,Z\nVAV1 zone temp,30001,INT16,0.1,°C,R\nSAT SP,40001,INT16,0.1,°C,RW\n", [],
        ("list.csv:1: found no column of the name and no column of the address", '"Adr" (could be address), "Art" (could be type)',
         '"Skal" (could be scale), "E" (could be unit), "Z" (could be access)', "[columns]")),
    "no column of the scale": (
        "Name,Register,Type,Skal,Unit,Note\nVAV1 zone temp,30001,int16,0.1,C,a\nVAV1 damper,30009,uint16,0.1,%,b\n"
        "SAT SP,40001,int16,0.1,C,c\nVAV1 status,30011,uint16,,,d\n", [],
        ("columns that were not used: Skal, Note", "list.csv:1: found no column of the scale, for room_temp_1 (int16), damper_1 (uint16), "
         "setpoint (int16); expected", 'scale = ["Skal"]', "scale = 1 in [list]")),
    "a cell without a scale": (HEAD + ROOM.replace("0.1", "") + SETPOINT, [],
                               ("list.csv:2, column 4 (Scale): found an empty cell for room_temp_1, int16", "scale = 1 in [list]")),
    "a point of ours without a register": (HEAD + ROOM + SETPOINT + "VAV2 zone temp,,int16,0.1,\n", [],
                                           ('list.csv:4, column 2 (Register): found an empty cell for "VAV2 zone temp", which is taken for '
                                            "room_temp_2", '"VAV2 zone temp" = ""')),
    "a quote that is not closed": (HEAD + ROOM.replace("VAV1 zone temp", 'VAV1 zone temp",3,"') + SETPOINT, [],
                                   ("list.csv:2: found a quote that is not closed",)),
    "a quote that is not closed, two lines before the end": (
        HEAD + SETPOINT + ROOM.replace(",int16", ',"int16') + ROOM.replace("VAV1", "VAV2"), [],
        ("list.csv:3: found a quote that is not closed",)),
    "no heading": ("a,b,c\n1,2,3\n", [], ("list.csv:1: found no column of the name", '"a", "b", "c"')),
    "a register twice": (HEAD + ROOM + ROOM.replace("VAV1", "VAV2") + SETPOINT, [],
                         ('list.csv:3, column 2 (Register): found function 4, register 0', '"VAV1 zone temp" in row 2')),
    "an overlap": (HEAD + ROOM.replace("int16,0.1", "float32,1") + "VAV2 zone temp,30002,int16,0.1,\n" + SETPOINT, [],
                   ("list.csv:3, column 2", "32 bits that should have 16")),
    "an unknown type": (HEAD + ROOM.replace("int16", "float64") + SETPOINT, [],
                        ('list.csv:2, column 3 (Type): found "float64"', "expected one of int16", "[types]")),
    "a bit in a register": (HEAD + ROOM.replace("int16", "bool") + SETPOINT, [], ("list.csv:2, column 3 (Type)", "a bit, for a register")),
    "a bit of a register": (HEAD + ROOM.replace("30001", "30001.3") + SETPOINT, [], ("list.csv:2, column 2", "one bit of a register")),
    "no type": (HEAD + ROOM.replace("int16", "") + SETPOINT, [], ("list.csv:2, column 3 (Type): found no data type", 'type = "int16"')),
    "an unknown unit": (HEAD + ROOM.replace("°C", "bar") + SETPOINT, [], ('column 5 (Unit): found "bar"', "degc, degf, kelvin")),
    "a foreign unit": (HEAD + ROOM.replace("°C", "kW") + SETPOINT, [], ('column 5 (Unit): found "kW"', "a unit of room_temp_1")),
    "a factor upside down": (HEAD + ROOM.replace("0.1", "x10") + SETPOINT, [], ('column 4 (Scale): found "x10", a step of 10 degc', "/10")),
    "a damper without percent": (HEAD + ROOM + SETPOINT + "VAV1 damper,30005,uint16,1,\n", [],
                                 ("list.csv:4, column 4 (Scale)", "or % as its unit")),
    "a factor of zero": (HEAD + ROOM.replace("0.1", "0") + SETPOINT, [], ('column 4 (Scale): found "0"',)),
    "a text for a factor": (HEAD + ROOM.replace("0.1", "tenth") + SETPOINT, [], ('column 4 (Scale): found "tenth"',)),
    "a decimal comma in quotes": (HEAD + ROOM.replace("0.1", '"0,1"') + SETPOINT, [],
                                  ('column 4 (Scale): found "0,1"', "--decimal ,")),
    "comma and point": ((HEAD + ROOM.replace("0.1", "0.1") + SETPOINT).replace(",", ";").replace("40001;int16;0.1", "40001;int16;0,1"),
                        [], ('list.csv:3, column 4 (Scale): found "0,1"', "decimal point")),
    "from 0 or from 1": (HEAD + ROOM.replace("30001", "17") + SETPOINT.replace("40001", "18"), [],
                         ("column 2 (Register): found registers from 17 on", "--addresses zero-based")),
    "no function": (HEAD + ROOM.replace("30001", "17") + SETPOINT.replace("40001", "18"), ["--addresses", "one-based"],
                    ("without a function", "function in [list]")),
    "beyond the last register": (HEAD + ROOM.replace("30001", "365537") + SETPOINT, [], ("column 2 (Register)", "0 to 65535")),
    "a text for a register": (HEAD + ROOM.replace("30001", "see note") + SETPOINT, [], ('found "see note"', "40001, 30001, 12 or 0x000C")),
    "a name twice": (HEAD + ROOM + ROOM.replace("zone temp", "zone temperature").replace("30001", "30002") + SETPOINT, [],
                     ("list.csv:3, column 1 (Name)", "as room_temp_1", "in row 2", '"VAV1 zone temperature" = ""')),
    "no setpoint": (HEAD + ROOM, [], ("no point that is taken for setpoint", "[names]")),
    "no room": (HEAD + SETPOINT + "VAV1 thing,30001,int16,0.1,\n", [], ("no point that is taken for room_temp_1", "not used: VAV1 thing")),
    "a setpoint that is read": (HEAD + ROOM + SETPOINT.replace("40001", "30009"), [], ("setpoint, which can only be read", "holding, RW")),
    "no point": (HEAD, [], ("a heading and no point below it",)),
    "an empty file": ("", [], ("found an empty file",)),
    "an open quote": (HEAD + '"VAV1\n', [], ("list.csv:2: found a quote that is not closed", "close the quote")),
    "a point without a name": (HEAD + ",30001,int16,0.1,\n" + SETPOINT, [], ("list.csv:2, column 1 (Name): found an empty cell",)),
    "a PDF": ("%PDF-1.7 ...", [], ("found a PDF",)),
    "a device's number": ("Name,Object type,Instance\nVAV1 zone temp,AI,3\nSAT SP,AO,1\n", [], ("as the device's number", "--device 1201")),
    "an unknown object": ("Name,Object type,Instance\nVAV1 zone temp,XY,3\nSAT SP,AO,1\n", ["--device", "1"],
                          ('list.csv:2, column 2 (Object type): found "XY"', "analog-input")),
    "a setpoint that is an input": ("Name,Object type,Instance\nVAV1 zone temp,AI,3\nSAT SP,AI,1\n", ["--device", "1"],
                                    ("list.csv:3", "found analog-input for setpoint", "commanded")),
    "an object twice": ("Name,Object type,Instance\nVAV1 zone temp,AI,3\nVAV2 zone temp,AI,3\nSAT SP,AO,1\n", ["--device", "1"],
                        ("list.csv:3", "1:analog-input:3", "each once")),
}


class Refused(Desk):
    def refused(self, name, options, parts):
        done = self.import_list(name, "-o", "points.csv", *options)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertNotIn("Traceback", done.stderr)
        for part in (*parts, "; expected ", ": found "):
            self.assertIn(part, done.stderr)
        self.assertEqual([p.name for p in self.folder.iterdir() if "points" in p.name], [])

    def test_lists(self):
        for what, (text, options, parts) in LISTS.items():
            with self.subTest(what):
                self.write("list.csv", text)
                self.refused("list.csv", options, parts)

    def test_every_complaint_is_listed_at_once(self):
        self.write("list.csv", HEAD + ROOM.replace("int16", "float64") + SETPOINT.replace("0.1", "tenth"))
        done = self.import_list("list.csv", "-o", "points.csv")
        self.assertEqual(len(done.stderr.splitlines()), 2, done.stderr)

    def test_encodings(self):
        self.write("list.csv", HEAD + ROOM + SETPOINT, "cp1252")
        self.refused("list.csv", [], ("list.csv:2, character 32: found the byte 0xB0", "--encoding cp1252"))
        self.assertEqual(self.import_list("list.csv", "--encoding", "cp1252", "-o", "points.csv").returncode, 0)
        self.write("list.csv", (HEAD + ROOM + SETPOINT).replace(",", "\t"), "utf-16")  # Excel's Unicode text
        self.assertEqual(self.import_list("list.csv", "-o", "points.csv", "--force").returncode, 0)

    def workbook(self, change, rows=(HEAD, ROOM, SETPOINT)):
        book = openpyxl.Workbook()
        book.active.title = "Points"
        for row in rows:
            book.active.append(row.strip().split(","))
        change(book)
        book.save(self.folder / "list.xlsx")

    def test_workbooks(self):
        self.workbook(lambda book: book.active.merge_cells("A2:A3"))
        self.refused("list.xlsx", [], ("list.xlsx, sheet Points, cells A2:A3: found merged cells", "unmerge"))
        self.workbook(lambda book: None, rows=())
        self.refused("list.xlsx", [], ("list.xlsx, sheet Points: found an empty sheet",))
        self.workbook(lambda book: book.active.__setitem__("D2", "=1/10"))
        self.refused("list.xlsx", [], ('sheet Points, row 2, column D: found the formula "=1/10"', "save it"))
        self.workbook(lambda book: book.active.__setitem__("C2", "float64"))
        self.refused("list.xlsx", [], ('sheet Points, row 2, column C (Type): found "float64"',))
        self.workbook(lambda book: book.copy_worksheet(book.active))
        self.refused("list.xlsx", [], ("in the sheets Points, Points Copy", "--sheet"))
        self.refused("list.xlsx", ["--sheet", "Other"], ('--sheet: found "Other"', "one of Points, Points Copy"))
        whole = (self.folder / "list.xlsx").read_bytes()
        (self.folder / "list.xlsx").write_bytes(whole[: len(whole) // 2])
        self.refused("list.xlsx", [], ("no whole XLSX",))
        (self.folder / "list.xls").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")
        self.refused("list.xls", [], ("the old form XLS",))

    def test_mappings(self):
        self.write("list.csv", HEAD + ROOM + SETPOINT)
        for text, parts in (("[colums]\n", ("map.toml: [colums]", "unknown table")), ("[list\n", ("map.toml: found no TOML",)),
                            ("[list]\naddresses = \"two-based\"\n", ("list.addresses", "modicon, zero-based, one-based")),
                            ("[list]\nscale = 0\n", ("list.scale", "other than 0")),
                            ("[names]\n\"SAT SP\" = \"set_point\"\n", ('found "set_point" as our name of "SAT SP"',)),
                            ("[names]\n\"SAT SPX\" = \"setpoint\"\n", ("[names]", "the name of a point in the list")),
                            ("[types]\nint64 = [\"x\"]\n", ("types.int64", "unknown key"))):
            with self.subTest(text):
                self.write("map.toml", text)
                self.refused("list.csv", ["--map", "map.toml"], parts)
        self.refused("list.csv", ["--map", "nowhere.toml"], ("nowhere.toml: found No such file",))

    def test_a_site_that_needs_more(self):
        self.write("list.csv", HEAD + ROOM + SETPOINT)
        self.write("site.toml", '[site]\ntopology = "2vav-0fcu-1power"\n[stand_in]\nrain = 0\nvav_on = 1\nmau_temp = 18\noutdoor_temp = 28\n')
        self.refused("list.csv", ["--site", "site.toml"], ("found no room_temp_2", "found no power_1", "`power = 4`", "[stand_in]"))

    def test_names_that_no_pattern_fits_are_shown_as_they_were_read(self):
        self.write("list.csv", HEAD + ROOM.replace("VAV1 zone temp", "AHU7/KL-01/RmTmp") + SETPOINT)
        self.write("map.toml", '[roles]\n"room_temp_{n}" = ["* kl {n} rmtmpr"]\n')
        self.write("site.toml", '[site]\ntopology = "1vav-0fcu-0power"\n[stand_in]\nrain = 0\nvav_on = 1\nmau_temp = 18\noutdoor_temp = 28\n')
        self.refused("list.csv", ["--map", "map.toml", "--site", "site.toml"], (
            'AHU7/KL-01/RmTmp (read as "ahu 7 kl 1 room temp")', 'none of these fits: "* kl {n} rmtmpr"', "[names]",
            '[roles] there, such as "room_temp_{n}" = ["* kl {n} room temp"]'))
        self.assertNotIn("topology", self.import_list("list.csv", "-o", "points.csv", "--site", "site.toml").stderr)

    def test_a_file_that_is_there_stays(self):
        self.write("list.csv", HEAD + ROOM + SETPOINT)
        self.write("kept.csv", "mine")
        done = self.import_list("list.csv", "-o", "kept.csv")
        self.assertEqual((done.returncode, self.text("kept.csv")), (1, "mine"))
        self.assertIn("--force", done.stderr)
        self.assertEqual(self.import_list("list.csv").returncode, 2)


if __name__ == "__main__":
    unittest.main()
