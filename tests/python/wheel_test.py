"""The wheel of tools/python: built by scikit-build-core, installed by pip into a fresh environment, held beside the
program `airside` on the same seeds."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "docs"))
from documents import blocks, text_of  # noqa: E402

BIN = Path(os.environ["AIRSIDE_BIN"])
AIRSIDE = str(BIN / "airside")


def ran(words, **options):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **options)
    if done.returncode:
        raise AssertionError(f"{words}: exit code {done.returncode}\n{done.stdout[-2000:]}\n{done.stderr[-6000:]}")
    return done.stdout


def with_numpy_alone(environment):
    """The environment sees numpy of this Python, and nothing else of it: pip need not fetch it."""
    import numpy
    site = Path(numpy.__file__).parents[1]
    seen = environment / "numpy-of-tools-setup"
    seen.mkdir()
    for part in site.glob("numpy*"):
        (seen / part.name).symlink_to(part)
    packages = next(environment.glob("lib/python3*/site-packages"))
    (packages / "numpy.pth").write_text(f"{seen}\n")


class Installed:
    """Built and installed once, for all tests."""

    def __init__(self):
        self.folder = Path(tempfile.mkdtemp(prefix="airside-wheel-"))
        ran([sys.executable, "-m", "pip", "wheel", ROOT / "tools" / "python", "-w", self.folder, "--no-deps",
             "--no-build-isolation", "--disable-pip-version-check",
             "--config-settings", f"build-dir={self.folder / 'built'}",
             "--config-settings", f"cmake.define.AIRSIDE_BUILD={BIN.parent}"])
        self.wheel = next(self.folder.glob("*.whl"))
        environment = self.folder / "fresh"
        ran([sys.executable, "-m", "venv", environment])
        with_numpy_alone(environment)
        self.python = environment / "bin" / "python"
        ran([self.python, "-m", "pip", "install", "--no-index", "--disable-pip-version-check", self.wheel])
        shutil.rmtree(self.folder / "built")
        self.package = next(environment.glob("lib/python3*/site-packages/airside"))

    def says(self, program, folder, **environment):
        """What a Python program prints there, in a folder of its own and without this machine's variables."""
        kept = {name: os.environ[name] for name in ("HOME", "LANG") if name in os.environ}
        return ran([self.python, "-B", "-c", program], cwd=folder, env={**kept, "PATH": "/usr/bin:/bin", **environment})

    def gives(self, program, folder, **environment):
        """The JSON that it prints."""
        return json.loads(self.says("import airside, json\n" + program, folder, **environment))


def setUpModule():
    global installed
    installed = Installed()


def tearDownModule():
    shutil.rmtree(installed.folder)


class InAFolder(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def program(self, *words):
        return ran([AIRSIDE, *words], cwd=self.folder)

    def complaint(self, *words):
        done = subprocess.run([AIRSIDE, *words], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        return done.stderr.strip().removeprefix("airside: ")


class Wheel(unittest.TestCase):
    def test_its_version_is_the_projects(self):
        version = re.search(r"project\(airside VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
        self.assertTrue(installed.wheel.name.startswith(f"airside-{version}-cp3"), installed.wheel.name)
        self.assertIn("linux", installed.wheel.name)
        self.assertEqual(installed.says("import airside; print(airside.__version__)", "/").strip(), version)
        self.assertEqual(installed.says("import airside; print(airside.program_text())", "/"), ran([AIRSIDE, "--version"]))

    def test_it_holds_types_models_effects_and_licence(self):
        names = set(zipfile.ZipFile(installed.wheel).namelist())
        for name in ("airside/py.typed", "airside/_airside.pyi", "airside/models/twin.epJSON"):
            self.assertIn(name, names)
        effects = {Path(name).name for name in names if name.startswith("airside/effects/library/")}
        self.assertEqual(effects, {path.name for path in (ROOT / "sim/effects/library").iterdir()})
        self.assertTrue(any(name.endswith("/licenses/LICENSE") for name in names), names)
        self.assertFalse([name for name in names if not name.startswith(("airside/", "airside-"))])

    def test_nothing_in_it_names_a_folder_of_this_machine(self):
        held = zipfile.ZipFile(installed.wheel)
        for name in held.namelist():
            content = held.read(name)
            for folder in {str(ROOT), str(BIN.parent), str(installed.folder), sys.prefix, str(Path.home()) + "/"}:
                self.assertNotIn(folder.encode(), content, name)

    def test_its_extension_looks_for_libraries_where_the_system_has_them(self):
        extension = next(installed.package.glob("_airside*.so"))
        said = ran(["readelf", "-d", extension])
        self.assertNotRegex(said, r"R(UN)?PATH")
        needed = re.findall(r"NEEDED.*\[(.*)\]", said)
        self.assertFalse([name for name in needed if "/" in name or "python" in name], needed)

    def test_every_public_name_is_described(self):
        undescribed = installed.gives("print(json.dumps([n for n in airside.__all__ if not getattr(airside, n).__doc__]))", "/")
        self.assertEqual(undescribed, [])


class Simulation(InAFolder):
    OPTIONS = "room='301-real', method='pid-tuned', seed=7, days=2, expert_days=1"
    WORDS = ("simulate", "--plant", "rc", "--room", "301-real", "--method", "pid-tuned", "--seed", "7", "--days", "2",
             "--expert-days", "1")

    def test_the_same_seed_gives_the_programs_figures_and_bits(self):
        ours = installed.gives(f"run = airside.simulate({self.OPTIONS}, log='python.csv', history_log='python_past.csv')\n"
                               "print(json.dumps([run.facts, run.figures.dae_degc, run.weather]))", self.folder)
        theirs = json.loads(self.program(*self.WORDS, "--log", "program.csv", "--history-log", "program_past.csv", "--json"))
        self.assertEqual(ours, [theirs, theirs["dae_degc"], "python.epw"])
        for name in (".csv", "_past.csv", ".epw"):
            self.assertEqual((self.folder / f"python{name}").read_bytes(), (self.folder / f"program{name}").read_bytes())

    def test_the_arrays_of_a_run_are_those_of_its_log(self):
        self.assertEqual(installed.gives(
            f"run = airside.simulate({self.OPTIONS}, log='a.csv')\n"
            "import numpy as np; log = airside.read_log('a.csv')\n"
            "print(json.dumps([log.names == run.log.names, bool(np.array_equal(log.numbers, run.log.numbers, equal_nan=True)),\n"
            "    bool((log.time == run.log.time).all()), all((log.texts[n] == run.log.texts[n]).all() for n in log.texts),\n"
            "    log.topology, len(log.time), str(log.time[0]), log.units['power_1_kw'], log.rooms.shape,\n"
            "    bool(np.diff(log.time).astype(int).max() == 360)]))", self.folder),
            [True, True, True, True, "5vav-5fcu-2power", 480, "2021-08-02T00:00:00", "kW", [480, 5], True])
        self.assertEqual(installed.gives("print(json.dumps(airside.read_log('a.csv')['room_temp_2_degc'].tolist()))",
                                         self.folder), self.column("a.csv", "room_temp_2_degc"))

    def column(self, file, name):
        header, *rows = [line.split(",") for line in (self.folder / file).read_text().splitlines()]
        return [float(row[header.index(name)]) for row in rows]

    def test_progress_is_told_and_may_end_the_run(self):
        self.assertEqual(installed.gives(
            f"shares = []\nairside.simulate({self.OPTIONS}, progress=shares.append)\n"
            "def stop(share): raise KeyError('enough')\n"
            f"try: airside.simulate({self.OPTIONS}, log='none.csv', progress=stop)\nexcept KeyError as e: ended = str(e)\n"
            "print(json.dumps([shares == sorted(shares), shares[-1], ended]))", self.folder), [True, 1.0, "'enough'"])
        self.assertEqual(list(self.folder.iterdir()), [])


class Blobs(InAFolder):
    def test_facts_and_signature_are_the_programs(self):
        self.program("pretrain", "--plant", "rc", "--room", "301", "--days", "2", "-o", "a.blob")
        self.program("keygen", "-o", "us")
        self.program("keygen", "-o", "other")
        self.program("sign", "a.blob", "--key", "us.key", "-o", "signed.blob")
        ours = installed.gives(
            "import numpy as np; blob = airside.read_blob('signed.blob'); layer = blob.layers[0]\n"
            "print(json.dumps([blob.facts, list(layer.weights.shape), float(np.r_[layer.weights.ravel(), layer.bias].max()),\n"
            "    airside.verify_blob('signed.blob', 'us.pub').key_name, blob.provenance[:16]]))", self.folder)
        theirs = json.loads(self.program("blob", "inspect", "signed.blob", "--json"))
        first = theirs["layers"][0]
        self.assertEqual(ours[:4], [theirs, [first["outputs"], first["inputs"]], first["max"], "us"])
        self.assertEqual(ours[4], "airside pretrain")
        for keys, word in (("other.pub", "signed.blob"), ("us.pub", "a.blob")):
            self.assertRegex(self.refusal(f"airside.verify_blob('{word}', '{keys}')")[0], f"^{word}: (signature|key_id)$")
        content = bytearray((self.folder / "signed.blob").read_bytes())
        content[400] ^= 1
        (self.folder / "bad.blob").write_bytes(content)
        self.assertEqual(": found ".join(self.refusal("airside.read_blob('bad.blob')")[:2]),
                         self.complaint("blob", "inspect", "bad.blob").split("; ")[0])
        self.assertFalse(installed.gives("print(json.dumps(airside.read_blob('bad.blob', damaged=True).digest_ok))", self.folder))

    def refusal(self, call):
        return installed.gives(f"try: {call}\nexcept airside.InputError as e: "
                               "print(json.dumps([e.place, e.found, e.expected, e.remedy]))", self.folder)


class Gap(InAFolder):
    def test_the_verdict_is_the_programs(self):
        few = self.folder / "effects"
        few.mkdir()
        for name in ("envelope_u", "infiltration", "vav_flow", "mau_setpoint", "gain_base", "thermal_mass"):
            shutil.copy(ROOT / "sim/effects/library" / f"{name}.json", few)
        words = ("--plant", "rc", "--room", "301", "--measured", "m.csv", "--reference-days", "4", "--no-duties",
                 "--buildings", "0", "--effects", "effects", "--jobs", "2", "--try", "vav_flow@2=0.5")
        self.program("simulate", "--plant", "rc", "--room", "301-real", "--method", "expert", "--days", "8", "--log", "m.csv")
        ours = installed.gives(
            "v = airside.gap('m.csv', plant='rc', room='301', reference_days=4, no_duties=True, buildings=0,\n"
            "    effects='effects', jobs=2, tries=['vav_flow@2=0.5'], out='out')\n"
            "print(json.dumps([v.facts, v.verdict, v.sentence, str(v.folder)]))", self.folder)
        written = json.loads((self.folder / "out/gap.json").read_text())
        shutil.rmtree(self.folder / "out")
        theirs = json.loads(self.program("gap", *words, "-o", "out", "--json"))
        for result in (ours[0], theirs, written):
            for other in ("command", "inputs"):  # how it was asked
                result.pop(other)
        self.assertEqual(ours, [theirs, theirs["verdict"], theirs["sentence"], "out"])
        self.assertEqual(written, theirs)

    def test_the_packages_own_effects_are_searched_and_a_missing_reference_is_refused(self):
        self.program("simulate", "--plant", "rc", "--room", "301", "--method", "expert", "--days", "1", "--log", "m.csv")
        said = installed.gives("try: airside.gap('m.csv', plant='rc', room='301')\nexcept airside.InputError as e: "
                               "print(json.dumps([str(e), e.place]))", self.folder)
        theirs = self.complaint("gap", "--plant", "rc", "--room", "301", "--measured", "m.csv")
        self.assertEqual(said, [re.sub(r"--([a-z]+)-?([a-z]*)", lambda m: m[1] + ("_" + m[2] if m[2] else ""), theirs),
                                "reference"])


class WrongInput(InAFolder):
    def test_every_refusal_has_its_four_parts_and_leaves_nothing(self):
        (self.folder / "cut.csv").write_text("time,room_temp_1_degc\n2021-08-01T00:00:00,\n")
        (self.folder / "no.blob").write_text("no blob")
        for call, place, found in (
                ("simulate(method='nonsense')", "method", "nonsense"),
                ("simulate(method='expert', room='nowhere')", "room", "nowhere"),
                ("simulate(method='expert', days=0)", "days", "0"),
                ("simulate(method='expert', seed=-1)", "seed", "-1"),
                ("simulate(method='expert', seed=2**63)", "seed", "9223372036854775808"),
                ("simulate(method='expert', seed='1')", "seed", "'1'"),
                ("simulate(method='expert', seed=1.5)", "seed", "1.5"),
                ("simulate(method='expert', seed=True)", "seed", "True"),
                ("simulate(method='expert', days=1.0)", "days", "1.0"),
                ("simulate(method='expert', room=3.01)", "room", "3.01"),
                ("simulate(method=1)", "method", "1"),
                ("simulate(method='expert', transfer='no')", "transfer", "'no'"),
                ("simulate(method='expert', start=20210801)", "start", "20210801"),
                ("simulate(method='expert', log=1)", "log", "1"),
                ("simulate(method='expert', progress=True)", "progress", "True"),
                ("simulate(method='expert', preset='best')", "preset", "'best'"),
                ("simulate(method='expert', start='August')", "start", "August"),
                ("simulate(method='expert', log='no/folder/a.csv')", "no/folder/a.csv", ""),
                ("simulate()", "weights", "no weights"),
                ("simulate(method='expert', topology='many')", "", "many"),
                ("simulate(method='expert', site='none.toml')", "none.toml", ""),
                ("read_log('none.csv')", "none.csv", "No such file"),
                ("read_log('cut.csv')", "cut.csv", ""),
                ("read_log(3)", "path", "3"),
                ("read_log('cut.csv', site='/')", "/site.toml", ""),
                ("gap('m.csv', plant='rc', room='301', reference_days=1.5)", "reference_days", "1.5"),
                ("gap('m.csv', plant='rc', room='301', tries='vav_flow@2=0.5')", "tries", "'vav_flow@2=0.5'"),
                ("read_blob(3)", "path", "3"),
                ("read_blob('none.blob')", "none.blob", ""),
                ("read_blob('no.blob')", "no.blob", ""),
                ("verify_blob('no.blob', 'none.pub')", "no.blob", ""),
                ("gap('none.csv', plant='rc', room='301', no_reference=True)", "weather", ""),
                ("gap('none.csv', plant='wood')", "plant", "'wood'")):
            with self.subTest(call):
                parts = installed.gives(f"try: airside.{call}; print('[]')\nexcept airside.InputError as e: "
                                        "print(json.dumps([e.place, e.found, e.expected, e.remedy]))", self.folder)
                self.assertEqual(len(parts), 4, "it was taken")
                self.assertTrue(all(parts), parts)
                self.assertIn(place, parts[0] + parts[1])
                self.assertIn(found, parts[0] + parts[1])
                self.assertNotIn("--", " ".join(parts))
        self.assertEqual({path.name for path in self.folder.iterdir()}, {"cut.csv", "no.blob"})


class WhatIsMeant(InAFolder):
    SAME = "method='expert', days=1, expert_days=0"

    def test_numbers_and_dates_of_python_are_taken_as_the_texts(self):
        self.assertEqual(installed.gives(
            "import datetime, numpy as np\n"
            f"a = airside.simulate({self.SAME}, room='301', seed=2, start='2021-07-01')\n"
            f"b = airside.simulate({self.SAME}, room=301, seed=np.int64(2), start=datetime.date(2021, 7, 1))\n"
            "print(json.dumps(a.facts == b.facts))", self.folder), True)

    def test_a_sites_folder_is_its_site_file(self):
        self.program("init", "mine")
        self.assertEqual(installed.gives(
            f"runs = [airside.simulate({self.SAME}, site=site, log='a.csv') for site in ('mine', 'mine/site.toml')]\n"
            "logs = [airside.read_log('a.csv', site=site) for site in ('mine', 'mine/site.toml')]\n"
            "print(json.dumps([runs[0].figures == runs[1].figures, logs[0].names == logs[1].names]))", self.folder),
            [True, True])

    def test_a_column_that_is_not_there_names_the_nearest(self):
        said = installed.gives(
            f"log, said = airside.simulate({self.SAME}).log, []\n"
            "for name in ('time', 'room_temp_9_degc', 'xyz'):\n"
            "    try: log[name]\n"
            "    except KeyError as e: said.append(e.args[0])\n"
            "print(json.dumps([said, 'xyz' in log, log.get('xyz')]))", self.folder)
        self.assertEqual(said[1:], [False, None])
        self.assertEqual(said[0][0], "time is no column; take log.time")
        self.assertRegex(said[0][1], r"^room_temp_9_degc: found no such column; did you mean room_temp_\d_degc or room_temp")
        self.assertEqual(said[0][2], "xyz: found no such column; list(log) has all")


class Moved(InAFolder):
    def test_the_package_works_from_another_folder(self):
        shutil.copytree(installed.package, self.folder / "elsewhere" / "airside")
        info = next(installed.package.parent.glob("airside-*.dist-info"))
        shutil.copytree(info, self.folder / "elsewhere" / info.name)
        kept = installed.package.rename(installed.package.with_name("set-aside"))
        try:
            said = installed.says("import airside; print(airside.__file__, airside.simulate(method='expert', days=1,"
                                  "expert_days=0).figures.dae_degc > 0)", self.folder,
                                  PYTHONPATH=str(self.folder / "elsewhere"))
        finally:
            kept.rename(installed.package)
        self.assertEqual(said, f"{self.folder}/elsewhere/airside/__init__.py True\n")


class Document(InAFolder):
    def test_its_example_runs_as_it_is_printed(self):
        page = text_of(str(ROOT / "docs" / "python.md"))
        examples = [block.text for block in blocks(page) if block.language == "python"]
        self.assertEqual(len(examples), 1)
        figures = json.loads(self.program("simulate", "--plant", "rc", "--room", "301-real", "--method", "pid-tuned",
                                          "--seed", "1", "--days", "3", "--json"))
        self.assertIn(f"{figures['dae_degc']:.3f} K from the target", installed.says(examples[0], self.folder))
