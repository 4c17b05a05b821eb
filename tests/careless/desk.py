"""A folder of whole files, made once by the programs themselves, and the ways in which people break them."""

import dataclasses
import gzip
import hashlib
import os
import pathlib
import shutil
import subprocess
import typing

NOBODY = 65534
MADE = ("airside init site",
        "airside init small --topology 3vav-0fcu-1power",
        "airside simulate --plant rc --room 301-real --method expert --expert-days 0 --days 2 --log log.csv",
        "airside pretrain --plant rc --days 2 --updates 1 -o a.blob",
        "airside keygen -o ann")


@dataclasses.dataclass
class Case:
    """One mistake, the command that meets it, and what must be said of it. Without `want` the mistake is no matter:
    the command does what was meant. `want`: parts of place, finding, expectation, remedy."""

    name: str
    breaks: typing.Callable
    command: str
    want: typing.Optional[tuple] = None
    code: int = 1
    leaves: tuple = ()  # files that the command may write
    free: bool = False  # the four parts stand in the program's own form: usage errors, and what doctor prints


def make(bin_dir, folder, model):
    for command in MADE:
        run(bin_dir, folder, command, check=True)
    shutil.copy(model, folder / "m.epJSON")
    (folder / "answers.toml").write_text("[site]\nname = \"AHU 3\"\nvavs = 3\nfcus = 0\npowers = 1\n", encoding="utf-8")


def hand_over(folder):
    """Gives a folder to whom run() runs as."""
    if os.geteuid() != 0:
        return
    for at, _, files in os.walk(folder):
        for path in [at, *(os.path.join(at, name) for name in files)]:
            os.chown(path, NOBODY, NOBODY)


def run(bin_dir, folder, command, check=False):
    """What a person sees who types `command` in `folder`. As root, files without rights are readable, so nobody runs
    it instead."""
    environment = {"PATH": f"{bin_dir}:/usr/bin:/bin", "HOME": str(folder), "LC_ALL": "C.UTF-8"}
    words = ["bash", "-c", command]
    if os.geteuid() == 0 and not check:
        words = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", *words]
    return subprocess.run(words, cwd=folder, env=environment, capture_output=True, timeout=60, check=check,
                          stdin=subprocess.DEVNULL)


def state(folder):
    """Every file below, by its content."""
    found = {}
    for at, folders, files in os.walk(folder):
        for name in folders + files:
            path = pathlib.Path(at, name)
            content = path.read_bytes() if path.is_file() else b"folder"
            found[str(path.relative_to(folder))] = hashlib.sha256(content).hexdigest()
    return found


# Ways to break a file, each a function of the folder.

def nothing(_folder):
    pass


def edit(name, old, new, count=1):
    def change(folder):
        text = (folder / name).read_text(encoding="utf-8")
        assert old in text, f"the case edits a text that is not there: {old}"
        (folder / name).write_text(text.replace(old, new, count), encoding="utf-8")
    return change


def write(name, content):
    def change(folder):
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return change


def recode(name, change):
    """The file's bytes as `change` makes them of its text."""
    def recoded(folder):
        text = (folder / name).read_text(encoding="utf-8")
        made = change(text)
        (folder / name).write_bytes(made if isinstance(made, bytes) else made.encode())
    return recoded


def rows(name, change):
    """Each line of a CSV file as `change(number from 1, cells)` makes it."""
    def changed(text):
        lines = text.splitlines()
        return "".join(",".join(change(n, line.split(","))) + "\n" for n, line in enumerate(lines, 1))
    return recode(name, changed)


def cell(name, line, column, to):
    """One cell of a CSV file; `column` is a number from 0."""
    return rows(name, lambda n, cells: cells if n != line else cells[:column] + [to] + cells[column + 1:])


def both(*changes):
    def change(folder):
        for one in changes:
            one(folder)
    return change


def zipped(name):
    return lambda folder: (folder / name).write_bytes(gzip.compress((folder / name).read_bytes()))


def no_rights(name, mode):
    return lambda folder: (folder / name).chmod(mode)
