"""The steps of tools/container/Containerfile, one by one, without a builder of images; tests/packages/image has buildah
do them."""

import functools
import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ["AIRSIDE_BIN"]).absolute()
LISTS = Path("/var/lib/apt/lists")
KNOWN = {"ARG", "FROM", "COPY", "RUN", "USER", "WORKDIR", "ENTRYPOINT", "CMD"}


def steps():
    """(instruction, words) of each line of the file, in order."""
    lines = (
        (ROOT / "tools" / "container" / "Containerfile").read_text(encoding="utf-8").replace("\\\n", " ").splitlines()
    )
    lines = [line.split(None, 1) for line in lines if line.strip() and not line.startswith("#")]
    return [(line[0], line[1] if len(line) > 1 else "") for line in lines]


def words_of(instruction):
    return [words for found, words in steps() if found == instruction]


@functools.cache
def holders():
    """{file: package} of every library that a Debian package holds here."""
    shown = subprocess.run(["dpkg", "-S", "*.so*"], capture_output=True, text=True, check=True).stdout
    lines = (line.split(": ", 1) for line in shown.splitlines() if ": " in line)
    return {file: packages.split(",")[0].split(":")[0] for packages, file in lines}


def package_of(path):
    """dpkg may know a file by /lib, by /usr/lib, or by what a link leads to."""
    names = [n for file in (path, os.path.realpath(path)) for n in (file, file.removeprefix("/usr"), "/usr" + file)]
    return next((holders()[name] for name in names if name in holders()), None)


@functools.cache
def loaded(program):
    """(library, path) of each that a program loads, those of libraries too."""
    shown = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    return re.findall(r"^\s*(\S+) => (\S+|not found)", shown, re.MULTILINE)


@functools.cache
def installed():
    """{package: names that it needs, each as a set of alternatives}, {name: packages that provide it}."""
    shown = subprocess.run(
        ["dpkg-query", "-W", "-f", "${Package}\t${Depends}, ${Pre-Depends}\t${Provides}\n"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    needs, provided = {}, {}

    def names(text):
        return [re.sub(r"\(.*?\)|:\w+", "", word).strip() for word in text if word.strip()]

    for line in shown.splitlines():
        package, needed, provides = line.split("\t")
        needs[package] = [set(names(part.split("|"))) for part in needed.split(",") if part.strip()]
        for name in names(provides.split(",")):
            provided.setdefault(name, set()).add(package)
    return needs, provided


def with_what_they_need(packages):
    needs, provided = installed()
    found, waiting = set(), list(packages)
    while waiting:
        package = waiting.pop()
        if package in found or package not in needs:
            continue
        found.add(package)
        for alternatives in needs[package]:
            for name in alternatives:
                waiting += [name, *provided.get(name, ())]
    return found


def missing(programs, packages):
    """Libraries that the programs load, and that none of the packages gives."""
    given = with_what_they_need(packages)
    libraries = [library for program in programs for library in loaded(program)]
    return {name for name, path in libraries if package_of(path) not in given}


class ImageFile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Path(tempfile.mkdtemp(prefix="airside-image-"))
        cls.addClassCleanup(shutil.rmtree, cls.work, ignore_errors=True)
        cls.folder = cls.work / "image"
        made = subprocess.run(
            [ROOT / "tools" / "container" / "image", "--folder", cls.folder, "--folder-only"],
            capture_output=True,
            text=True,
            check=False,
            env=dict(os.environ, AIRSIDE_BUILD=str(BIN.parent)),
        )
        if made.returncode:
            raise AssertionError(made.stdout + made.stderr)
        cls.packages = (cls.folder / "packages.txt").read_text(encoding="utf-8").split()
        cls.programs = sorted((cls.folder / "airside" / "bin").iterdir())

    def test_each_step_is_one_that_this_test_knows(self):
        self.assertEqual({found for found, _ in steps()} - KNOWN, set())
        self.assertEqual([found for found, _ in steps()][:2], ["ARG", "FROM"])

    def test_whatever_is_copied_is_made(self):
        copies = words_of("COPY")
        self.assertGreaterEqual(len(copies), 2)
        for words in copies:
            *sources, _ = words.split()
            for source in sources:
                self.assertTrue((self.folder / source).exists(), f"COPY {words}: the build makes no {source}")
        self.assertEqual([p.name for p in self.programs], ["airside", "airside-energyplus"])

    def test_what_is_installed_is_read_from_where_it_was_copied(self):
        found = steps()
        install = next(i for i, (_, words) in enumerate(found) if "apt-get install" in words)
        read = re.search(r"<\s*(\S+)", found[install][1])[1]
        copied = [words.split()[-1] for name, words in found[:install] if name == "COPY"]
        self.assertIn(read, copied, "copied before it is read")
        self.assertLess(found[install][1].index("apt-get update"), found[install][1].index("apt-get install"))

    def test_user_folder_and_program_are_there_when_they_are_named(self):
        runs = " && ".join(words_of("RUN"))
        user = words_of("USER")[0]
        self.assertRegex(runs, rf"\buseradd [^&]*--uid 10001 [^&]*\b{user}\b")
        self.assertRegex(runs, rf"install -d -o {user} -g {user} {re.escape(words_of('WORKDIR')[0])}\b")
        self.assertEqual([n for n, _ in steps()][-4:], ["USER", "WORKDIR", "ENTRYPOINT", "CMD"], "rights go last")
        targets = dict(reversed(words.split()) for words in words_of("COPY"))
        entry = Path(json.loads(words_of("ENTRYPOINT")[0])[0])
        program = self.folder / targets["/usr/local/"] / entry.relative_to("/usr/local")
        self.assertTrue(os.access(program, os.X_OK), program)
        said = subprocess.run([program, *json.loads(words_of("CMD")[0])], capture_output=True, text=True, check=False)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("simulate", said.stdout)

    def test_the_program_finds_its_effects_where_it_will_lie(self):
        done = subprocess.run(
            [self.folder / "airside" / "bin" / "airside", "gap", "effects", "--json"],
            capture_output=True,
            text=True,
            check=False,
            cwd=self.work,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("vav_flow", done.stdout)

    def test_no_file_names_a_folder_of_this_machine(self):
        for file in sorted(p for p in (self.folder / "airside").rglob("*") if p.is_file()):
            self.assertNotIn(str(ROOT).encode(), file.read_bytes(), file)

    def test_every_package_is_one_that_apt_knows(self):
        self.assertGreater(len(self.packages), 10)
        for name in self.packages:
            self.assertRegex(name, r"^[a-z0-9][a-z0-9.+-]+$")
        if not shutil.which("apt-cache") or not any(LISTS.glob("*_Packages*")):
            self.skipTest("names of packages: apt has no lists here; apt-get update")

        # By an archive, and not only because it is installed here.
        shown = subprocess.run(
            ["apt-cache", "madison", *self.packages, "libairside-none0"], capture_output=True, text=True, check=False
        )
        offered = {line.split("|")[0].strip() for line in shown.stdout.splitlines() if line.count("|") == 2}
        self.assertEqual(offered, set(self.packages))

    @unittest.skipUnless(shutil.which("dpkg-query"), "libraries: no dpkg here")
    def test_the_packages_give_every_library_that_is_loaded(self):
        self.assertEqual(missing(self.programs, self.packages), set())

    @unittest.skipUnless(shutil.which("dpkg-query"), "libraries: no dpkg here")
    def test_without_one_of_them_a_library_is_missing(self):
        lacking = {name: missing(self.programs, set(self.packages) - {name}) for name in self.packages}
        needed = sorted(name for name, libraries in lacking.items() if libraries)
        self.assertGreater(len(needed), 3, lacking)
        self.assertTrue(any("modbus" in name for name in needed), needed)
        self.assertTrue(any("libmodbus" in library for name in needed for library in lacking[name]), lacking)


if __name__ == "__main__":
    unittest.main()
