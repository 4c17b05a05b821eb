"""Registers become numbers as docs/formats.md says, and a map of any forms is read as the program serves it."""

import csv
import math
import pathlib
import tempfile
import unittest

from airside_gym.points import Point, blocks_of
from desk import airside, environment, setpoint

EMPTY = dict.fromkeys(("unit", "byte_order", "word_order", "scale", "offset", "min", "max", "sentinel", "fc_write"), "")


def point(name="p", **columns):
    return Point({**EMPTY, "name": name, "fc": "4", "addr": "0", **columns})


class Points(unittest.TestCase):
    def test_types_and_orders(self):
        for columns, words, value in (
                ({"type": "int16", "scale": "0.01"}, (0xFFFF,), -0.01),
                ({"type": "uint16", "offset": "2"}, (0xFFFF,), 65537),
                ({"type": "uint16", "byte_order": "little"}, (0x0100,), 1),
                ({"type": "int32"}, (0xFFFF, 0xFFFE), -2),
                ({"type": "uint32", "word_order": "little"}, (0x0002, 0x0001), 65538),
                ({"type": "float32"}, (0x41BC, 0x0000), 23.5),
                ({"type": "float32", "word_order": "little", "byte_order": "little"}, (0x0000, 0xBC41), 23.5),
                ({"type": "coil"}, (1,), 1)):
            self.assertAlmostEqual(point(**columns).value(words), value, msg=str(columns))

    def test_no_value_is_nan(self):
        for columns, words in (({"type": "int16", "sentinel": "0x8000 32767"}, (0x8000,)),
                               ({"type": "int16", "sentinel": "0x8000 32767"}, (0x7FFF,)),
                               ({"type": "int16", "max": "40"}, (41,)), ({"type": "int16", "min": "0"}, (0xFFFF,)),
                               ({"type": "float32"}, (0x7FC0, 0))):
            self.assertTrue(math.isnan(point(**columns).value(words)), columns)

    def test_blocks_have_no_gaps_and_no_more_than_one_request_holds(self):
        points = [point(f"p{i}", type="int16", addr=str(i)) for i in range(130)]
        points += [point("apart", type="float32", addr="200"), point("coil", type="coil", fc="1", addr="5")]
        self.assertEqual([(b.points[0].function, b.first, b.count) for b in blocks_of(points)],
                         [(1, 5, 1), (4, 0, 125), (4, 125, 5), (4, 200, 2)])


class ServedForms(unittest.TestCase):
    FORMS = [{"type": t, "scale": "1" if t == "float32" else "0.01", "byte_order": b, "word_order": w, "sentinel": ""}
             for t in ("int16", "int32", "float32") for b in ("big", "little") for w in ("big", "little")]

    def map_with(self, folder, form):
        path = pathlib.Path(folder) / "points.csv"
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        for address, row in enumerate(rows):
            row["addr"] = str(3 * address)
            if row["name"].startswith(("room_temp", "setpoint", "outdoor")):
                row.update(form)
            if row["name"] == "setpoint":
                row["fc_write"] = "6" if form["type"] == "int16" else "16"
            if row["name"].startswith(("vav_on", "rain")):
                row.update({"fc": "2", "type": "discrete", "sentinel": "", "byte_order": "", "word_order": ""})
        with open(path, "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)

    def test_each_form_shows_the_same_room(self):
        seen = []
        with tempfile.TemporaryDirectory() as folder:
            for form in self.FORMS:
                airside("init", folder, "--force")
                self.map_with(folder, form)
                with environment("Site", site=folder, plant="rc", room="301-real", days=1) as env:
                    env.reset(seed=1)
                    for degc in (22.5, 24.25):
                        observation, _, _, _, info = env.step(setpoint(degc))
                    self.assertEqual(info["missing"], ())
                    told = dict(zip(env.unwrapped.signal_names, observation.tolist(), strict=True))
                    seen.append([round(told[name], 2) for name in sorted(told)])
        for form, values in zip(self.FORMS, seen):
            for value, first in zip(values, seen[0]):
                self.assertAlmostEqual(value, first, delta=0.011, msg=str(form))


class SeveralSensors(unittest.TestCase):
    def test_a_room_of_several_sensors_counts_once(self):
        with tempfile.TemporaryDirectory() as folder:
            airside("init", folder)
            path = pathlib.Path(folder) / "points.csv"
            text = path.read_text(encoding="utf-8")
            row = next(line for line in text.splitlines() if line.startswith("room_temp_3,"))
            rows = [row.replace("room_temp_3,degc,4,2,", f"room_temp_3{letter},degc,4,{100 + i},")
                    for i, letter in enumerate("abc")]
            path.write_text(text.replace(row, "\n".join(rows)), encoding="utf-8")
            means = []
            for site in (folder, None):
                with environment("Rc", site=site, room="301-real", days=1) as env:
                    means.append(env.reset(seed=1)[1]["room_mean_degc"])
        self.assertAlmostEqual(means[0], means[1], places=9)
